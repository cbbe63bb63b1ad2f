"""Loads and rolling together: friction and neighbours push the balls across the track, which changes the contact forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import root

from rollbench.hifi.rolling.balls import Choices, RollingResult, solve_rolling, touching, without_meetings
from rollbench.hifi.rolling.loads import Cell, Loads, cell_loads
from rollbench.hifi.rolling.scenes import Layout, Material, scene_of
from rollbench.meshes.arrays import Array

#: Difference of the force that friction exerts and the one that the loads are for, over the largest load, that is none.
AGREED = 1e-7
#: Search by Anderson's acceleration of the alternation of loads and friction.
SEARCH = {"fatol": 0.1 * AGREED, "maxiter": 40, "line_search": None, "jac_options": {"M": 4, "alpha": 1.0, "w0": 1e-6}}
#: Grid on which loads and friction are brought together first.
COARSE = (10, 10)


@dataclass(frozen=True)
class Fed:
    """Loads and rolling that agree; push on the balls across the track ``(N, 2)`` [N]; evaluations; difference of loads and
    friction over the largest load."""

    loads: Loads
    rolling: RollingResult
    push: Array
    rounds: int
    change: float

    @property
    def converged(self) -> bool:
        """Whether loads and friction agree, and both are solved."""
        return self.loads.converged and self.rolling.converged and self.change <= AGREED


def hold(cell: Cell, loads: Loads) -> Cell:
    """The cell with its inner body held where it settled."""
    moved = cell.rows @ loads.body if cell.pull.size else 0.0
    return replace(cell, offset=cell.offset + moved, rows=np.zeros((*cell.rows.shape[:2], 0)), pull=np.zeros(0))


def solve_loaded(
    layout: Layout, material: Material, cell: Cell, choices: Choices, *, feedback: bool, meet: bool = True
) -> Fed:
    """Loads of a cell and rolling under them; feedback: friction moves the balls, the inner body stays where it settled.

    The force that friction exerts across the track is found by Anderson's acceleration, first on a coarse grid.
    """
    loads = cell_loads(cell)
    if not feedback:
        return Fed(loads, _roll(layout, material, loads, choices, meet), np.zeros((len(cell.push), 2)), 1, 0.0)
    held, count = hold(cell, loads), 0
    scale, last = float(loads.force.max()), dict[tuple[int, int], RollingResult]()

    def exerted(push: Array, grid: Choices) -> tuple[Loads, RollingResult, Array]:
        nonlocal count
        count += 1
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
    change = float(np.abs(force / scale - push.reshape(-1, 2)).max())
    return Fed(pushed, rolling, push.reshape(-1, 2) * scale, count, change)


def _roll(
    layout: Layout, material: Material, loads: Loads, choices: Choices, meet: bool, near: RollingResult | None = None
) -> RollingResult:
    """Rolling under the loads, from the last solution if the same contacts are loaded."""
    scene = scene_of(layout, material, loads.normal, loads.force)
    loaded = [(b, k) for b, k, _ in touching(scene)]
    alike = near is not None and [(c.ball, c.touch) for c in near.contacts] == loaded
    return solve_rolling(scene if meet else without_meetings(scene), choices, near if alike else None)
