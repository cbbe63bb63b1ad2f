"""Contacts of balls in motion with grooves and with each other: what they see, friction and losses."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.friction.screw.kernel_types import BallArrays, GrooveArrays
from rollbench.lowfi.jit import CONTACT, is_compiled, kernel, kernels

_OTHER = kernels(CONTACT, compiled=is_compiled(__name__))  # the kernels of one contact, compiled where these are
dissipation, evaluate, least_dissipation = _OTHER.dissipation, _OTHER.evaluate, _OTHER.least_dissipation
hertz_contact, solve_with_pivots, ROLLING = _OTHER.hertz_contact, _OTHER.solve_with_pivots, _OTHER.ROLLING


@kernel
def semi_axes(force: Array, C_a: Array, C_b: Array, a: Array, b: Array) -> None:
    """Writes semi-axes (N, 4) [m] of Hertz contacts of forces (N, 4) [N]; unloaded ones keep a vanishing ellipse."""
    least = max(1e-9 * np.max(force), 1e-30)
    for k in range(force.shape[0]):
        for i in range(4):
            cube = max(force[k, i], least) ** (1.0 / 3.0)
            a[k, i], b[k, i] = C_a[i] * cube, C_b[i] * cube


@kernel
def contact_map(groove: GrooveArrays, n_x: float, n_z: float, out: Array) -> None:
    """Writes the map (3, 4) of a contact in direction (n_x, n_z)."""
    affine = groove.affine
    for r in range(3):
        for j in range(4):
            out[r, j] = affine[0, r, j] + n_x * affine[1, r, j] + n_z * affine[2, r, j]


@kernel
def seen(groove: GrooveArrays, i: int, rows: Array, x: Array) -> tuple[float, float, float]:
    """Motion (vx, vz, spin) of contact i with the map ``rows`` (3, 4) in the ball's motion x (4,)."""
    orbit = x[0] - groove.ride[i]
    return (
        rows[0, 0] * orbit + rows[0, 1] * x[1] + rows[0, 2] * x[2] + rows[0, 3] * x[3],
        rows[1, 0] * orbit + rows[1, 1] * x[1] + rows[1, 2] * x[2] + rows[1, 3] * x[3],
        rows[2, 0] * orbit + rows[2, 1] * x[1] + rows[2, 2] * x[2] + rows[2, 3] * x[3],
    )


@kernel
def friction(balls: BallArrays, x: Array, eps: float, motion: Array, pull: Array, loss: Array) -> None:
    """Writes what the contacts see (N, 4, 3), friction on the balls (N, 4, 3) and losses (N, 4) at motions (N, 4).

    In the contacts' own axes: along x, z, about y. Motions as parts of ``speed``, forces in the unit of ``BallArrays``.
    """
    shape, maps, drives = balls.shape, balls.maps, balls.drives
    for k in range(x.shape[0]):
        for i in range(4):
            strength = shape[k, i, 2]
            for r in range(3):
                motion[k, i, r], pull[k, i, r] = drives[k, i, r], 0.0
                for j in range(4):
                    motion[k, i, r] += maps[k, i, r, j] * x[k, j]
            loss[k, i] = 0.0
            if strength == 0.0:
                continue
            vx, vz, spin = motion[k, i, 0], motion[k, i, 1], motion[k, i, 2]
            d = dissipation(shape[k, i, 0], shape[k, i, 1], vx, vz, spin, eps)
            pull[k, i, 0], pull[k, i, 1], pull[k, i, 2] = -strength * d.by_vx, -strength * d.by_vz, -strength * d.by_spin
            loss[k, i] = strength * (d.value - eps * d.by_speed)


@kernel
def rubbing(groove: GrooveArrays, this: Array, other: Array, eps: float) -> tuple[float, float, float]:
    """Sliding (2) of a ball of motion (4,) on the next one, and its size above ``eps``."""
    first, second = groove.first, groove.second
    u, v = 0.0, 0.0
    for j in range(4):
        u += first[0, j] * this[j] - second[0, j] * other[j]
        v += first[1, j] * this[j] - second[1, j] * other[j]
    return u, v, sqrt(u * u + v * v + eps * eps)


@kernel
def meeting(
    groove: GrooveArrays,
    balls: BallArrays,
    x: Array,
    f: Array,
    eps: float,
    push: Array,
    slide: Array,
    on_ball: Array,
    loss: Array,
) -> None:
    """Writes what neighbours do to balls (N, 3) [N] and the losses (N,) [W] where ball k slides on k + 1.

    f (N,): forces between them [N]; push (2, 3), slide (2, 2, 3): as in ``screw_groove.PairGeometry``.
    """
    n = f.shape[0]
    on_ball[:] = 0.0
    for k in range(n):
        ahead = (k + 1) % n
        u, v, size = rubbing(groove, x[k], x[ahead], eps)
        bite = balls.mu[k] * f[k] / size
        loss[k] = bite * (u * u + v * v) * groove.speed
        for r in range(3):
            on_ball[k, r] += f[k] * push[0, r] - bite * (u * slide[0, 0, r] + v * slide[0, 1, r])
            on_ball[ahead, r] += f[k] * push[1, r] + bite * (u * slide[1, 0, r] + v * slide[1, 1, r])


@kernel
def alone(balls: BallArrays, x: Array) -> None:
    """Overwrites the motions (N, 4) of loaded balls by those of least dissipation without neighbours."""
    forces, rest, bounds, none, start = np.empty((4, 3)), np.empty(4), np.empty(2), np.zeros(4), int(np.int64(ROLLING))
    for k in range(x.shape[0]):
        if np.sum(balls.shape[k, :, 2]) > 0.0:
            least_dissipation(balls.shape[k], balls.maps[k], balls.drives[k], none, start, x[k], forces, rest, bounds)
