"""Contact forces of balls between two rigid bodies with Hertz contacts, alone and together with rolling.

Each ball moves in the section of its track, the inner body (screw, inner ring, carriage) by its free motions u, the
outer one stands. The arc of groove i has its centre at d_i from the ball's: with the ball displaced by p and the inner
body by u,

    d_i = reach n_i + p - (rows u on the inner body's grooves),   approach_i = |d_i| - reach + interference_i,

and the forces C_i^(-3/2) approach_i^(3/2) along d_i balance the given ones where the energy
sum 2/5 C_i^(-3/2) approach_i^(5/2) - pull u - push p is least. Angles follow the loads.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, root

from rollbench.hifi.rolling.balls import Choices, RollingResult, solve_rolling, touching, without_meetings
from rollbench.hifi.rolling.scenes import Layout, Material, scene_of
from rollbench.meshes.arrays import Array

#: Newton's steps that follow the search, and force out of balance over the sum of contact forces that counts as balance.
POLISH, BALANCED = 30, 1e-9


@dataclass(frozen=True)
class Cell:
    """N balls with k grooves each: directions ``(N, k, 2)`` of the unloaded contacts in the section, reach [m] (groove
    radius less ball radius), interference ``(N, k)`` [m], Hertz constants C ``(N, k)`` [m/N^(2/3)], which grooves are
    the inner body's ``(k,)``, its motion in the section ``(N, 2, m)`` per free motion, displacement given to it ``(N,
    2)`` [m], forces on it ``(m,)`` and on the balls ``(N, 2)`` [N]."""

    normals: Array
    reach: float
    interference: Array
    C: Array
    inner: NDArray[np.bool_]
    rows: Array
    offset: Array
    pull: Array
    push: Array


@dataclass(frozen=True)
class Loads:
    """Contact forces ``(N, k)`` [N], their directions from the ball ``(N, k, 2)``, places of balls ``(N, 2)`` and inner
    body ``(m,)`` [m]; force out of balance over the sum of the contact forces, and whether that is balance."""

    force: Array
    normal: Array
    ball: Array
    body: Array
    left: float

    @property
    def converged(self) -> bool:
        """Whether the forces balance."""
        return self.left <= BALANCED


def cell_loads(cell: Cell) -> Loads:
    """Loads of a cell; a cell that cannot be held does not converge, and says so."""
    N, m = cell.normals.shape[0], cell.pull.size
    size = float(np.abs(cell.pull).sum() + np.abs(cell.push).sum())
    stiff = cell.C.mean()
    squeezed = float(np.abs(cell.interference).max(initial=0.0) + np.abs(cell.offset).max(initial=0.0))
    size = max(size, (squeezed / stiff) ** 1.5)
    unit = stiff * size ** (2.0 / 3.0)
    start = np.concatenate([np.zeros(2 * N), cell.pull / size * 4.0])
    if m:
        start[: 2 * N] = 0.5 * np.einsum("nim,m->ni", cell.rows, start[2 * N :]).ravel()

    def energy(x: Array) -> tuple[float, Array]:
        e, g, _ = _evaluate(cell, x * unit)
        return e / (size * unit), g / size

    def bend(x: Array) -> Array:
        return np.asarray(_evaluate(cell, x * unit)[2] * (unit / size)) + 1e-9 * np.eye(x.size)

    x = minimize(energy, start, jac=True, hess=bend, method="trust-exact", options={"gtol": 1e-8, "maxiter": 500}).x
    best = x
    for _ in range(POLISH):
        g = energy(x)[1]
        if np.linalg.norm(g) < np.linalg.norm(energy(best)[1]):
            best = x
        x = x - np.linalg.solve(bend(x), g)
    force, normal, _ = _contacts(cell, best * unit)
    left = float(np.abs(energy(best)[1]).max()) * size / max(float(force.sum()), 1e-300)
    if np.any((force > 0.0) & ((normal * cell.normals).sum(axis=2) <= 0.0)):  # a ball that left its groove for the far side
        left = np.inf
    return Loads(force, normal, best[: 2 * N].reshape(N, 2) * unit, best[2 * N :] * unit, left)


def _contacts(cell: Cell, x: Array) -> tuple[Array, Array, Array]:
    """Forces [N], directions, and lengths of d [m] at places x."""
    N = cell.normals.shape[0]
    p, u = x[: 2 * N].reshape(N, 2), x[2 * N :]
    body = cell.rows @ u + cell.offset if u.size else cell.offset
    d = cell.reach * cell.normals + p[:, None] - cell.inner[None, :, None] * body[:, None]
    length = np.linalg.norm(d, axis=2)
    approach = np.maximum(length - cell.reach + cell.interference, 0.0)
    return (approach / cell.C) ** 1.5, d / length[:, :, None], length


def _evaluate(cell: Cell, x: Array) -> tuple[float, Array, Array]:
    """Energy, gradient and Hessian at places x."""
    N, m = cell.normals.shape[0], cell.pull.size
    force, n, length = _contacts(cell, x)
    approach = cell.C * np.cbrt(force) ** 2
    e = float((0.4 * force * approach).sum() - cell.push.ravel() @ x[: 2 * N] - cell.pull @ x[2 * N :])
    g = np.concatenate([-cell.push.ravel(), -cell.pull])
    H = np.zeros((x.size, x.size))
    stiff = np.divide(1.5 * force, approach, out=np.zeros_like(force), where=approach > 0.0)
    for i in range(N):
        for k in range(cell.inner.size):
            T = np.zeros((2, x.size))
            T[:, 2 * i : 2 * i + 2] = np.eye(2)
            if m and cell.inner[k]:
                T[:, 2 * N :] = -cell.rows[i]
            nn = np.outer(n[i, k], n[i, k])
            g += force[i, k] * (T.T @ n[i, k])
            H += T.T @ (stiff[i, k] * nn + force[i, k] / length[i, k] * (np.eye(2) - nn)) @ T
    return e, g, H


# --- loads and rolling together: friction and neighbours push the balls across the track, which changes the contact forces


#: Difference of the force that friction exerts and the one that the loads are for, over the largest load, that is none.
AGREED = 1e-7
#: Search by Anderson's acceleration of the alternation of loads and friction.
SEARCH = {"fatol": 0.1 * AGREED, "maxiter": 40, "line_search": None, "jac_options": {"M": 4, "alpha": 1.0, "w0": 1e-6}}
#: Grid on which loads and friction are brought together first.
COARSE = (10, 10)


def hold(cell: Cell, loads: Loads) -> Cell:
    """The cell with its inner body held where it settled."""
    moved = cell.rows @ loads.body if cell.pull.size else 0.0
    return replace(cell, offset=cell.offset + moved, rows=np.zeros((*cell.rows.shape[:2], 0)), pull=np.zeros(0))


def solve_loaded(layout: Layout, material: Material, cell: Cell, choices: Choices, *, meet: bool) -> tuple[Loads, bool]:
    """Loads of a cell whose balls are moved by friction too while the inner body stays where it settled, and whether loads
    and friction agree (`AGREED`) and both are solved.

    The force that friction exerts across the track is found by Anderson's acceleration, first on a coarse grid.
    """
    loads = cell_loads(cell)
    held = hold(cell, loads)
    scale, last = float(loads.force.max()), dict[tuple[int, int], RollingResult]()

    def exerted(push: Array, grid: Choices) -> tuple[Loads, RollingResult, Array]:
        pushed = cell_loads(replace(held, push=cell.push + push))
        rolling = _roll(layout, material, pushed, grid, meet, last.get(grid.shape))
        last[grid.shape] = rolling
        return pushed, rolling, (rolling.wrench[:, :3] + rolling.between) @ layout.section.T

    def missing(push: Array, grid: Choices) -> Array:
        two = push.reshape(-1, 2) * scale
        return np.asarray((exerted(two, grid)[2] - two).ravel() / scale)

    push = np.zeros(2 * len(cell.push))
    for shape in (COARSE, choices.shape):
        grid = replace(choices, shape=shape)
        push = root(lambda x, grid=grid: missing(x, grid), push, method="anderson", options=SEARCH).x
    pushed, rolling, force = exerted(push.reshape(-1, 2) * scale, choices)
    agree = np.abs(force / scale - push.reshape(-1, 2)).max() <= AGREED
    return pushed, bool(agree and pushed.converged and rolling.converged)


def _roll(
    layout: Layout, material: Material, loads: Loads, choices: Choices, meet: bool, near: RollingResult | None = None
) -> RollingResult:
    """Rolling under the loads, from the last solution if the same contacts are loaded."""
    scene = scene_of(layout, material, loads.normal, loads.force)
    loaded = [(b, k) for b, k, _ in touching(scene)]
    alike = near is not None and [(c.ball, c.touch) for c in near.contacts] == loaded
    return solve_rolling(scene if meet else without_meetings(scene), choices, near if alike else None)
