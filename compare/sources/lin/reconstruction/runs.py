"""3D runs of the readings: computed where none is stored, kept in this folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rollbench.comparison.reference.computing import compute
from rollbench.comparison.reference.store import load, save
from rollbench.comparison.reference.tasks import Task
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.lin.reconstruction.readings import (
    CASES,
    SOLID,
    Combination,
    key_of,
    level_of,
    solid_scene,
    together,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene

#: Folder of the runs.
RUNS = Path(__file__).parent / "runs"
#: Readings that move largest over smallest load by more than 0.5 % and that the text does not speak against: these are
#: combined in 3D (tests/sources/lin/literature/test_reconstruction.py).
MOVERS = ("plain", "runout", "outer-half", "tetrahedra")


def wanted() -> list[Combination]:
    """Combinations of the 3D model that have runs: none, every reading alone, all pairs and triples of `MOVERS`."""
    movers = tuple(r for r in SOLID if r.key in MOVERS)
    return [*together(SOLID, 1), *(c for c in together(movers, 3) if len(c) > 1)]


def scenes(readings: Combination) -> tuple[Scene, ...]:
    """The cases by a combination, which share a set-up; named after both."""
    return tuple(replace(solid_scene(catalogue.scene(c), readings), name=f"{c}-{key_of(readings)}") for c in CASES)


def stored(readings: Combination) -> tuple[Array, ...] | None:
    """Loads ``(n, 4)`` [N] of the cases; None where a run is missing."""
    found = [load(scene, level_of(readings), stores=[RUNS]) for scene in scenes(readings)]
    loads = tuple(run.load for run in found if run is not None and run.status == "converged")
    return loads if len(loads) == len(CASES) else None


def complete(step: Callable[[str], None], cache: Path | None = None) -> None:
    """Compute and keep the runs that are missing. Raises ValueError for one that does not converge."""
    for readings in wanted():
        if stored(readings) is not None:
            continue
        step(f"3D: {key_of(readings)}")
        pair = scenes(readings)
        runs = compute(Task(pair, level_of(readings), cache=cache))
        sliding = sum(r.sliding for r in readings)
        if sliding:
            from rollbench.comparison.sources.lin.reconstruction.dragging import with_sliding

            runs = with_sliding(pair, runs, sliding, cache)
        for scene, run in zip(pair, runs, strict=True):
            save(RUNS, scene, run)
