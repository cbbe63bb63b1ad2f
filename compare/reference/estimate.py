"""The 3D reference of a scene: loads of its finest stored run, their uncertainty by grid convergence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compare.reference import grid_order
from compare.reference.convergence import Convergence, Pooled, pool, representative_size
from compare.reference.levels import LEVELS
from compare.reference.store import Run, load, shipped_store
from meshes.arrays import Array
from meshes.parts import Scene

#: Levels that a scene's uncertainty is taken from, the finest: the coarsest of more lie furthest from what a power of the
#: cell size says (lightly loaded contacts of two-balls: `rollbench mesh-study two-balls`).
FITTED = 4


@dataclass(frozen=True)
class Reference:
    """The 3D reference of a scene: runs coarse to fine, loads of the finest ``(n, 4)`` [N], their uncertainty ``(n, 4)``
    [N] by grid convergence (three times the difference of two levels; None with one), the convergence of every contact's
    load, and of all of them with one order; loads extrapolated to cells of no size, None where no order is believed."""

    scene: str
    runs: tuple[Run, ...]
    load: Array
    uncertainty: Array | None
    convergence: tuple[tuple[Convergence, ...], ...] | None
    pooled: Pooled | None
    extrapolated: Array | None

    @property
    def best(self) -> Run:
        """The finest run."""
        return self.runs[-1]

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs."""
        return tuple(representative_size(run.settings) for run in self.runs)

    @property
    def estimate(self) -> Array:
        """Best estimate of the loads ``(n, 4)`` [N]: extrapolated, or else those of the finest level."""
        return self.load if self.extrapolated is None else self.extrapolated


def reference(scene: Scene, stores: Sequence[Path] | None = None) -> Reference | None:
    """Best stored reference of a scene, its `FITTED` finest runs, or None."""
    runs = tuple(run for level in LEVELS if (run := load(scene, level, stores=stores)) is not None)
    runs = tuple(run for run in runs if run.status == "converged")[-FITTED:]
    if not runs:
        return None
    order = grid_order.load((shipped_store(),) if stores is None else (*stores, shipped_store()))
    return reference_of(scene.name, runs, None if order is None else order.interval)


def reference_of(scene: str, runs: tuple[Run, ...], order: tuple[float, float] | None = None) -> Reference:
    """Reference of converged runs, coarse to fine; order: interval of the method's (`compare.reference.grid_order`)."""
    best = runs[-1]
    if len(runs) < 2:
        return Reference(scene, runs, best.load, None, None, None, None)
    shape = best.load.shape
    sizes = [representative_size(run.settings) for run in runs]
    pooled = pool(np.stack([run.load.ravel() for run in runs]), sizes, order)
    each = pooled.each
    uncertainty = np.array([c.uncertainty for c in each], dtype=float).reshape(shape)
    rows = tuple(each[i * shape[1] : (i + 1) * shape[1]] for i in range(shape[0]))
    extrapolated = None
    if all(c.extrapolated is not None for c in each):
        extrapolated = np.maximum(np.array([c.extrapolated for c in each], dtype=float).reshape(shape), 0.0)
    return Reference(scene, runs, best.load, uncertainty, rows, pooled, extrapolated)
