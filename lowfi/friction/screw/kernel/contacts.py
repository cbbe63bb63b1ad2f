"""Friction at the grooves of balls in motion: its gradient and Hessian, forces and losses."""

from math import sqrt

import numpy as np

from lowfi.jit import CONTACT, is_compiled, kernel, kernels

from .arrays import Array, Balls, Groove

_OTHER = kernels(CONTACT, compiled=is_compiled(__name__))  # the kernels of one contact, compiled where these are
dissipation, least_dissipation = _OTHER.dissipation, _OTHER.least_dissipation


@kernel
def semi_axes(force: Array, C_a: Array, C_b: Array, a: Array, b: Array) -> None:
    """Writes semi-axes (N, 4) [m] of Hertz contacts of forces (N, 4) [N]; unloaded ones keep a vanishing ellipse."""
    least = max(1e-9 * np.max(force), 1e-30)
    for k in range(force.shape[0]):
        for i in range(4):
            cube = max(force[k, i], least) ** (1.0 / 3.0)
            a[k, i], b[k, i] = C_a[i] * cube, C_b[i] * cube


@kernel
def contact_map(groove: Groove, n_x: float, n_z: float, out: Array) -> None:
    """Writes the map (3, 4) of a contact in direction (n_x, n_z)."""
    affine = groove[0]
    for r in range(3):
        for j in range(4):
            out[r, j] = affine[0, r, j] + n_x * affine[1, r, j] + n_z * affine[2, r, j]


@kernel
def seen(groove: Groove, i: int, rows: Array, x: Array) -> tuple[float, float, float]:
    """Motion (vx, vz, spin) of contact i with the map ``rows`` (3, 4) in the ball's motion x (4,)."""
    own = x[0] - groove[1][i]
    return (
        rows[0, 0] * own + rows[0, 1] * x[1] + rows[0, 2] * x[2] + rows[0, 3] * x[3],
        rows[1, 0] * own + rows[1, 1] * x[1] + rows[1, 2] * x[2] + rows[1, 3] * x[3],
        rows[2, 0] * own + rows[2, 1] * x[1] + rows[2, 2] * x[2] + rows[2, 3] * x[3],
    )


@kernel
def ball(
    groove: Groove,
    force: Array,
    normal: Array,
    axes: tuple[Array, Array],
    strength: float,
    x: Array,
    eps: float,
    gradient: Array,
    hessian: Array,
) -> None:
    """Adds gradient (4,), Hessian (4, 4) of a ball's scaled dissipation; force (4,), normal (4, 2), semi-axes (4,)."""
    rows, speed = np.empty((3, 4)), groove[8]
    for i in range(4):
        if force[i] == 0.0:
            continue
        contact_map(groove, normal[i, 0], normal[i, 1], rows)
        vx, vz, spin = seen(groove, i, rows, x)
        d = dissipation(axes[0][i], axes[1][i], vx, vz, spin, eps * speed)
        scale = strength * force[i] / speed
        for j in range(4):
            mx, mz, ms = scale * rows[0, j], scale * rows[1, j], scale * rows[2, j]
            gradient[j] += mx * d[1] + mz * d[2] + ms * d[3]
            h_x, h_z = mx * d[5] + mz * d[6] + ms * d[8], mx * d[6] + mz * d[7] + ms * d[9]
            h_s = mx * d[8] + mz * d[9] + ms * d[10]
            for q in range(4):
                hessian[j, q] += h_x * rows[0, q] + h_z * rows[1, q] + h_s * rows[2, q]


@kernel
def friction(groove: Groove, balls: Balls, x: Array, eps: float, mu: float, wrench: Array, loss: Array) -> None:
    """Writes force and moment on the balls (N, 4, 6) in x3, y3, z3 [N, N m] and losses (N, 4) [W] at motions (N, 4).

    Contact axes: x across the groove, (n_z, 0, -n_x); z along the path, y3; y into the ball, -n.
    """
    force, normal = balls[0], balls[1]
    rows, a, b = np.empty((3, 4)), np.empty_like(force), np.empty_like(force)
    semi_axes(force, groove[2], groove[3], a, b)
    wrench[:] = 0.0
    loss[:] = 0.0
    for k in range(force.shape[0]):
        for i in range(4):
            if force[k, i] == 0.0:
                continue
            n_x, n_z, bound = normal[k, i, 0], normal[k, i, 1], mu * force[k, i]
            contact_map(groove, n_x, n_z, rows)
            vx, vz, spin = seen(groove, i, rows, x[k])
            d = dissipation(a[k, i], b[k, i], vx, vz, spin, eps * groove[8])
            wrench[k, i, 0], wrench[k, i, 1], wrench[k, i, 2] = -bound * d[1] * n_z, -bound * d[2], bound * d[1] * n_x
            wrench[k, i, 3], wrench[k, i, 5] = bound * d[3] * n_x, bound * d[3] * n_z
            loss[k, i] = bound * (d[0] - eps * groove[8] * d[4])


@kernel
def rubbing(groove: Groove, this: Array, other: Array, eps: float) -> tuple[float, float, float]:
    """Sliding (2) of a ball of motion (4,) on the next one, and its size above ``eps``."""
    first, second = groove[5], groove[6]
    u, v = 0.0, 0.0
    for j in range(4):
        u += first[0, j] * this[j] - second[0, j] * other[j]
        v += first[1, j] * this[j] - second[1, j] * other[j]
    return u, v, sqrt(u * u + v * v + eps * eps)


@kernel
def meeting(
    groove: Groove, balls: Balls, x: Array, f: Array, eps: float, push: Array, slide: Array, on_ball: Array, loss: Array
) -> None:
    """Writes what neighbours do to balls (N, 3) [N] and the losses (N,) [W] where ball k slides on k + 1.

    f (N,): forces between them [N]; push (2, 3), slide (2, 2, 3): as in ``screw_groove.PairGeometry``.
    """
    n = f.shape[0]
    on_ball[:] = 0.0
    for k in range(n):
        ahead = (k + 1) % n
        u, v, size = rubbing(groove, x[k], x[ahead], eps)
        bite = balls[5][k] * f[k] / size
        loss[k] = bite * (u * u + v * v) * groove[8]
        for r in range(3):
            on_ball[k, r] += f[k] * push[0, r] - bite * (u * slide[0, 0, r] + v * slide[0, 1, r])
            on_ball[ahead, r] += f[k] * push[1, r] + bite * (u * slide[1, 0, r] + v * slide[1, 1, r])


@kernel
def alone(groove: Groove, balls: Balls, x: Array) -> None:
    """Overwrites the motions (N, 4) of loaded balls by those of least dissipation without neighbours."""
    force, normal, strength = balls[0], balls[1], balls[6]
    a, b = np.empty_like(force), np.empty_like(force)
    semi_axes(force, groove[2], groove[3], a, b)
    shape, maps, drives = np.empty((4, 3)), np.empty((4, 3, 4)), np.empty((4, 3))
    forces, rest, bounds, none = np.empty((4, 3)), np.empty(4), np.empty(2), np.zeros(4)
    for k in range(force.shape[0]):
        if np.sum(force[k]) == 0.0:
            continue
        for i in range(4):
            shape[i, 0], shape[i, 1], shape[i, 2] = a[k, i], b[k, i], strength * force[k, i]
            contact_map(groove, normal[k, i, 0], normal[k, i, 1], maps[i])
            for r in range(3):
                drives[i, r] = -groove[1][i] * maps[i, r, 0]
        least_dissipation(shape, maps, drives, none, False, x[k], forces, rest, bounds)
