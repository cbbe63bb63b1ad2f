"""Loads of one ball between an inner and an outer ring: minimum of a convex energy, rigid but for Hertz contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ModuleLoad:
    """Contact forces (m,) [N]; contact angles (m,) [rad] from the radial line; inner ring (2,) and ball (2,) [m].

    imbalance: largest force left [N]; steps; converged: whether it is below 1e-9 of the sum of forces.
    """

    force: Array
    angle: Array
    ring: Array
    ball: Array
    imbalance: float
    steps: int
    converged: bool


@dataclass(frozen=True)
class Module:
    """Ball and rings: nominal directions (m, 2) from the ball's centre, reach = r_G - r_B > 0 [m], play [m] along each.

    C (m,): approach = C F^(2/3); inner (m,): contacts of the inner ring.
    """

    normals: Array
    reach: float
    play: float
    C: Array
    inner: NDArray[np.bool_]


State = tuple[float, Array, Array, Array, Array]


def approaches(module: Module, z: Array, u_y: float) -> tuple[Array, Array, Array]:
    """Approach (m,), unit normals (m, 2), distance (m,) from groove centre to ball centre at z = (u_x, ball) (3,)."""
    motion = z[1:] - np.where(module.inner[:, None], np.array([z[0], u_y]), 0.0)
    start = module.reach * module.normals
    w = start + motion
    size = np.linalg.norm(w, axis=1)
    # distance less reach, built as a change so that its round-off is that of the motion
    change = np.sum(motion * (2.0 * start + motion), axis=1) / (size + module.reach)
    return change - module.play, w / size[:, None], size


def energy_at(module: Module, z: Array, force: float, u_y: float) -> State:
    """Energy, gradient (3,), Hessian (3, 3), contact forces (m,) and normals (m, 2) at z = (u_x, ball x, ball y)."""
    approach, n, size = approaches(module, z, u_y)
    d = np.maximum(approach, 0.0) / module.C
    f = d * np.sqrt(d)
    rows = np.column_stack([np.where(module.inner, -n[:, 0], 0.0), n])
    cross = np.column_stack([np.where(module.inner, n[:, 1], 0.0), -n[:, 1], n[:, 0]])
    gradient = f @ rows - np.array([force, 0.0, 0.0])
    hessian = (rows.T * (1.5 * np.sqrt(d) / module.C)) @ rows + (cross.T * (f / size)) @ cross
    return float(np.sum(0.4 * module.C * d * f)) - force * float(z[0]), gradient, hessian, f, n


def _line(module: Module, z: Array, step: Array, state: State, force: float, u_y: float) -> tuple[Array, State] | None:
    """First point of a halved step that is lower, or as low with a smaller gradient; None where there is none."""
    slope, length = float(state[1] @ step), 1.0
    flat = -slope <= 1e-12 * abs(state[0])
    for _ in range(50):
        trial = z + length * step
        new = energy_at(module, trial, force, u_y)
        if new[0] <= state[0] + 1e-4 * length * slope or (flat and np.max(np.abs(new[1])) < np.max(np.abs(state[1]))):
            return trial, new
        length *= 0.5
    return None


def settle_module(module: Module, force: float, u_y: float) -> ModuleLoad:
    """Contact loads of a ball for the axial force on the inner ring [N] and its radial displacement u_y [m].

    Minimises the convex energy sum (2/5) C^(-3/2) <approach>^(5/2) - force u_x over u_x and the ball's centre, by
    Newton with line search. Contact forces are unique; with no force and play the ball floats, and its place is where
    the search ends.
    """
    typical = float(np.max(module.C)) * max(abs(force), 1e-6) ** (2.0 / 3.0) + max(module.play, 0.0) + abs(u_y)
    z = np.array([4.0 * typical * np.sign(force), 2.0 * typical * np.sign(force), 0.5 * u_y])
    state = energy_at(module, z, force, u_y)
    steps = 0
    while steps < 200:
        _, gradient, hessian, f, _ = state
        if float(np.max(np.abs(gradient))) <= 1e-13 * (float(np.sum(f)) + abs(force)):
            break
        steps += 1
        floor = 1e-9 * float(np.max(np.diag(hessian))) + 1e-12 * max(abs(force), 1e-9) / module.reach
        step: Array = np.asarray(np.linalg.solve(hessian + floor * np.eye(3), -gradient), dtype=float)
        step *= min(1.0, 0.3 * module.reach / float(np.max(np.abs(step))))
        moved = _line(module, z, step, state, force, u_y)
        if moved is None:
            break
        z, state = moved
    _, gradient, _, f, n = state
    left = float(np.max(np.abs(gradient)))
    return ModuleLoad(
        force=f,
        angle=np.arctan2(np.abs(n[:, 0]), np.abs(n[:, 1])),
        ring=np.array([z[0], u_y]),
        ball=z[1:].copy(),
        imbalance=left,
        steps=steps,
        converged=bool(left <= 1e-9 * (float(np.sum(f)) + abs(force))),
    )
