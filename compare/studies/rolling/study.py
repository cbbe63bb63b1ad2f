"""Comparisons and grid studies of scenes of rolling balls, from stored runs or from new ones, which are then stored."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.reference.jobs import Engine
from rollbench.compare.reference.levels import HALF_SPACE
from rollbench.compare.reference.parallel import as_done
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.running import on_terminal
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.studies.rolling import runs
from rollbench.compare.studies.rolling.rows import RollingRow, load_state, quantity_uncertainty, scene_rows
from rollbench.compare.studies.rolling.runs import SOURCE_LEVEL, SOURCE_SIZE, RollingRun


def find_or_compute_runs(
    scene: KindScene, levels: Sequence[int], store: Path, engine: Engine, *, fresh: bool, bodies: str = "half-space"
) -> list[RollingRun]:
    """Return the runs of a scene on several grids, stored ones where they exist; each new run is stored when it is done.

    ``levels``: levels of the grids; ``store``: folder for new runs; ``engine``: where they are computed; ``fresh``: whether
    stored runs are computed again; ``bodies``: kind of the bodies. Refusal if a run did not converge.
    """
    stores = (store, shipped_store())
    found = {} if fresh else {k: run for k in levels if (run := runs.load_run(scene, k, stores, bodies)) is not None}
    missing = [k for k in levels if k not in found]
    jobs = [(runs.compute_run, (scene, k, bodies, engine.processes)) for k in missing]
    for number, run in as_done(jobs, engine.backend, engine.scheduler, engine.workers, engine.wait):
        runs.save_run(store, scene, run)
        found[missing[number]] = run
        on_terminal(f"{scene.name}: level {run.level}, {run.shape[0]} x {run.shape[1]} cells, {run.all_seconds:.1f} s")
    bad = next((found[k] for k in levels if not found[k].converged), None)
    if bad is not None:
        raise Refusal(scene.name, f"level {bad.level}", bad.status, "try another level")
    return [found[k] for k in levels]


def check_levels(levels: Sequence[int]) -> list[int]:
    """Return the levels as a list; InputError for a level that scenes of rolling balls do not have."""
    other = [k for k in levels if k not in runs.LEVELS]
    if other:
        got = ", ".join("source" if k == SOURCE_LEVEL else str(k) for k in other)
        advice = "choose other levels; mesh-study with `source_mesh=True` shows the element size of Lin's thesis"
        raise ArgumentError("levels", got, f"1 to {len(runs.LEVELS)} for scenes of friction", advice)
    return list(levels)


def rolling_comparison(
    scenes: Sequence[KindScene], levels: tuple[int, ...] | None, store: Path, engine: Engine, *, fresh: bool, bodies: str
) -> list[RollingRow]:
    """Compare low-order models of rolling balls with the 3D model; missing runs are computed and stored in the store.

    ``levels``: levels of the grids, None for all; ``fresh``: whether stored runs are computed again; ``bodies``: kind of
    the bodies. Raises InputError for an unknown level, Refusal if a run did not converge.
    """
    wanted = check_levels(levels or tuple(runs.LEVELS))
    out: list[RollingRow] = []
    for scene in scenes:
        found = find_or_compute_runs(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        half_space = (
            None if bodies == HALF_SPACE else find_or_compute_runs(scene, wanted[-1:], store, Engine(), fresh=False)[0]
        )
        out += scene_rows(scene, found, half_space)
    return out


def rolling_mesh_study(
    scenes: Sequence[KindScene], levels: int | None, store: Path, engine: Engine, *, source: bool, fresh: bool, bodies: str
) -> list[dict[str, Any]]:
    """Return every quantity on every grid, with and without the rigid limit, and its uncertainty from all grids.

    ``levels``: number of grids from the coarsest on, None for all; ``source``: whether the grid with the element size of
    Lin's thesis is added; ``fresh``: whether stored runs are computed again; ``bodies``: kind of the bodies. Raises
    InputError for a number of grids out of range, Refusal if a run did not converge.
    """
    levels = len(runs.LEVELS) if levels is None else levels
    if not 1 <= levels <= len(runs.LEVELS):
        raise ArgumentError("levels", str(levels), f"1 to {len(runs.LEVELS)}", "take three levels, which show the scatter")
    out: list[dict[str, Any]] = []
    for scene in scenes:
        wanted = [*([SOURCE_LEVEL] if source and scene.kind in SOURCE_SIZE else []), *range(1, levels + 1)]
        found = find_or_compute_runs(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        grids = [run for run in found if run.level != SOURCE_LEVEL]
        for key in found[-1].values:
            share = without_infinity({"uncertainty": quantity_uncertainty(grids, key)})
            out += [study_row(scene.name, run, key) | share for run in found]
    return out


def without_infinity(row: dict[str, Any]) -> dict[str, Any]:
    """Return a table row with None in place of infinite values."""
    return {k: None if isinstance(v, float) and abs(v) == float("inf") else v for k, v in row.items()}


def study_row(name: str, run: RollingRun, key: str) -> dict[str, Any]:
    """Return a table row with one quantity of a run: value, rigid limit, and effect of elasticity on the grid.

    ``name``: name of the scene; ``key``: name of the quantity with its unit.
    """
    return {
        "scene": name,
        "load_state": load_state(name),
        "quantity": key,
        "level": "source" if run.level == SOURCE_LEVEL else str(run.level),
        "cells": f"{run.shape[0]} x {run.shape[1]}",
        "value": run.values[key],
        "grid_alone": run.elastic[key],
        "elasticity": run.elastic[key] - run.near_rigid[key],
        "rigid_limit": run.limit[key],
        "energy_lost_percent": 100.0 * run.upwind,
        "seconds": run.seconds,
    }
