"""Scenes of rolling balls in the commands compare and mesh-study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.reference.body_names import HALF_SPACE
from rollbench.compare.running import need_packages
from rollbench.compare.text.printing import Answer, on_terminal
from rollbench.compare.text.tables import aligned, ruled

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import RollingRow
    from rollbench.compare.studies.rolling.runs import RollingRun


def runs_of(
    scene: KindScene, levels: Sequence[int], store: Path, engine: Engine, *, fresh: bool, bodies: str = HALF_SPACE
) -> list[RollingRun]:
    """Runs of the levels in order, stored ones where there are; each is stored when it is done.

    Raises Refusal for a scene that is beyond the 3D model, and where a run did not converge.
    """
    from rollbench.compare.reference.parallel import as_done
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.studies.rolling.runs import compute, load, save

    stores = (store, shipped_store())
    found = {} if fresh else {k: run for k in levels if (run := load(scene, k, stores, bodies)) is not None}
    missing = [k for k in levels if k not in found]
    jobs = [(compute, (scene, k, bodies, engine.processes)) for k in missing]
    for number, run in as_done(jobs, engine.backend, engine.scheduler, engine.workers, engine.wait):
        save(store, scene, run)
        found[missing[number]] = run
        on_terminal(f"{scene.name}: level {run.level}, {run.shape[0]} x {run.shape[1]} cells, {run.all_seconds:.1f} s")
    bad = next((found[k] for k in levels if not found[k].converged), None)
    if bad is not None:
        raise Refusal(scene.name, f"level {bad.level}", bad.status, "try another level")
    return [found[k] for k in levels]


def known_levels(levels: Sequence[int]) -> list[int]:
    """The levels as they are. Raises InputError for one that rolling balls do not have."""
    from rollbench.compare.studies.rolling.runs import LEVELS, SOURCE_LEVEL

    other = [k for k in levels if k not in LEVELS]
    if other:
        got = ", ".join("source" if k == SOURCE_LEVEL else str(k) for k in other)
        advice = "mesh-study with `source_mesh=True` shows the source's size"
        raise ArgumentError("levels", got, f"1 to {len(LEVELS)} for scenes of friction", advice)
    return list(levels)


def run_rolling_compare(
    names: Sequence[str],
    levels: tuple[int, ...] | None,
    store: Path,
    engine: Engine,
    *,
    fresh: bool,
    bodies: str = HALF_SPACE,
) -> Answer:
    """Low-order models beside the 3D model of rolling; all its levels unless given."""
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import rows
    from rollbench.compare.studies.rolling.runs import LEVELS

    wanted = known_levels(levels or tuple(LEVELS))
    out: list[RollingRow] = []
    for name in names:
        scene = catalogue.any_scene(name)
        assert isinstance(scene, KindScene)
        found = runs_of(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        beside = None if bodies == HALF_SPACE else runs_of(scene, wanted[-1:], store, Engine(), fresh=False)[0]
        out += rows(scene, found, beside)
    shown = dict.fromkeys(row.scene for row in out)
    tables = (_table(name, [row for row in out if row.scene == name]) for name in shown)
    return Answer({"rows": [finite(row.as_json()) for row in out]}, tables)


def finite(row: dict[str, Any]) -> dict[str, Any]:
    """A row without infinity."""
    return {k: None if isinstance(v, float) and abs(v) == float("inf") else v for k, v in row.items()}


#: Columns of the table after the quantity: attribute of a row, heading, format.
COLUMNS = (
    ("low", "low-order", ".5g"),
    ("reference", "3D", ".5g"),
    ("uncertainty", "+-", ".2g"),
    ("error_percent", "error %", ".2f"),
    ("uncertainty_percent", "+- %", ".2f"),
    ("printed", "printed", ".5g"),
    ("printed_ansys", "ANSYS", ".5g"),
    ("flat", "3D flat", ".5g"),
    ("rigid", "3D rigid", ".5g"),
    ("half_space", "3D half space", ".5g"),
)


def _cell(value: float | None, form: str) -> str:
    return "–" if value is None or abs(value) == float("inf") else format(value, form)


def _table(name: str, rows: Sequence[RollingRow]) -> Any:
    from rollbench.compare.studies.rolling.rows import UNSTATED

    state = f" ({rows[0].load_state} load state{UNSTATED})" if rows[0].load_state else ""
    title = f"{name}{state}: low-order model against the 3D model of rolling"
    cells = ([f"{r.quantity} [{r.unit}]", *(_cell(getattr(r, key), form) for key, _, form in COLUMNS)] for r in rows)
    table = ruled(title, ["quantity", *(heading for _, heading, _ in COLUMNS)], cells, ["quantity"])
    table.caption = f"low-order: {1e3 * rows[0].low_seconds:.2f} ms now; 3D on the finest grid: {rows[0].seconds:.2f} s, "
    table.caption += f"measured with {rows[0].measured_with}"
    return table


def run_rolling_study(
    names: Sequence[str],
    levels: int | None,
    store: Path,
    engine: Engine,
    *,
    source: bool,
    fresh: bool,
    bodies: str = HALF_SPACE,
) -> Answer:
    """Every quantity on every grid, all of them unless given, as it is and on top of the rigid limit, and its uncertainty
    from them all."""
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene
    from rollbench.compare.studies.rolling.rows import uncertainty
    from rollbench.compare.studies.rolling.runs import LEVELS, SOURCE_LEVEL, SOURCE_SIZE

    levels = len(LEVELS) if levels is None else levels
    if not 1 <= levels <= len(LEVELS):
        raise ArgumentError("levels", str(levels), f"1 to {len(LEVELS)}", "three levels give a scatter")
    out: list[dict[str, Any]] = []
    for name in names:
        scene = catalogue.any_scene(name)
        assert isinstance(scene, KindScene)
        wanted = [*([SOURCE_LEVEL] if source and scene.kind in SOURCE_SIZE else []), *range(1, levels + 1)]
        runs = runs_of(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        grids = [run for run in runs if run.level != SOURCE_LEVEL]
        for key in runs[-1].values:
            share = finite({"uncertainty": uncertainty(grids, key)})
            out += [study_row(scene.name, run, key) | share for run in runs]
    return Answer(out, _study_parts(out))


def _study_parts(out: Sequence[dict[str, Any]]) -> Iterator[Any]:
    for name in dict.fromkeys(row["scene"] for row in out):
        rows_of = [{k: v for k, v in row.items() if k != "scene"} for row in out if row["scene"] == name]
        yield from (f"mesh study of {name}", "", aligned(rows_of, ".6g"))


def study_row(name: str, run: RollingRun, key: str) -> dict[str, Any]:
    """A quantity on a grid: with limit and elasticity apart, and the grid's own number."""
    from rollbench.compare.studies.rolling.rows import load_state
    from rollbench.compare.studies.rolling.runs import SOURCE_LEVEL

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


def all_rolling(names: Sequence[str], bodies: str, means_nothing: Mapping[str, bool]) -> bool:
    """Whether scenes are all of kinds that only friction solves; False for whole screws and bearings.

    means_nothing: arguments that rolling balls do not know, and whether each was given. Raises InputError
    where some are and some are not, for an unknown name of bodies, for finite bodies under whole screws, and for such an
    option.
    """
    from rollbench.compare.reference.body_names import FINITE
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.friction_kinds.common import KindScene

    kinds = [isinstance(catalogue.any_scene(name), KindScene) for name in names]
    if any(kinds) and not all(kinds):
        allowed = "whole screws and bearings, or scenes of friction"
        raise ArgumentError("scenes", " ".join(names), allowed, "name them apart")
    if bodies not in (HALF_SPACE, FINITE):
        raise ArgumentError("bodies", bodies, f"{HALF_SPACE} or {FINITE}", "half spaces are the faster ones")
    if not any(kinds):
        if bodies != HALF_SPACE:
            advice = "the static reference is of finite bodies"
            raise ArgumentError("bodies", bodies, "scenes of friction", advice)
        return False
    need_packages("scikit-fem")
    for argument in (name for name, given in means_nothing.items() if given):
        advice = "leave it out: it would change nothing"
        raise ArgumentError(argument, "scenes of friction", "whole screws and bearings", advice)
    return True
