"""The command ``rollbench mesh-study``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.models.comparison import Referenced, referenced
from rollbench.compare.reference.jobs import Engine, all_variants, ensure, plan
from rollbench.compare.reference.levels import ADVISED, LEVELS
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import Solvable, Task
from rollbench.compare.results.comparison import named, unconverged
from rollbench.compare.studies.mesh_study.table import closing, level_rows, quantity_table, study_table
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


def levels_of(count: int | None) -> tuple[int, ...]:
    """Levels of a mesh study: `ADVISED`, or 1 to ``count``. Raises InputError where there are fewer."""
    if count is None:
        return ADVISED
    if not 1 <= count <= len(LEVELS):
        raise ArgumentError("levels", str(count), f"1 to {len(LEVELS)}", "three levels give an order")
    return tuple(range(1, count + 1))


def table_of(one: Referenced, stores: Sequence[Path], levels: Sequence[int]) -> list[dict[str, Any]]:
    """The table of a mesh study; of one of several sets without the effect of modelling choices: none is varied there."""
    return study_table(one.scene, stores, levels) if one.of is None else quantity_table(one.found, None, {})


def compute_study(
    scenes: Sequence[Solvable],
    levels: Sequence[int],
    stores: Sequence[Path],
    engine: Engine,
    step: Callable[[str], None],
    *,
    spread: bool = False,
    source: bool = False,
    fresh: bool = False,
) -> list[Referenced]:
    """References of the scenes by all runs on some levels, set by set; what the stores lack is computed and kept
    in the first.

    spread, source, fresh: as the options of ``rollbench mesh-study``. Raises InputError for spread of several sets on one
    shaft, Refusal for a scene of which no run converged.
    """
    tasks = plan(scenes, levels, source=source)
    several = next((s.name for s in scenes if isinstance(s, Assembly)), None) if spread else None
    if several is not None:
        raise ArgumentError("spread", f"with {several}", "scenes of one set", "leave it out")
    if spread:
        tasks += [t for s in scenes for t in plan([s], (), all_variants())]

    def first(task: Task) -> None:
        """Say what the coarsest level found while finer ones are computed."""
        for scene in task.scenes if task.level == min(LEVELS) and not task.variant else ():
            for one in referenced(scene, stores[:1], (task.level,)):
                table = extremes(table_of(one, stores[:1], (task.level,)))
                values = (f"{row['quantity']} {row[f'level {task.level}']:.4g} {row['unit']}" for row in table)
                step(f"{one.found.scene}, by level {task.level} alone: {'; '.join(values)}")

    failed = ensure(tasks, stores[0], engine, step, stores[1:], fresh=fresh, stored=first)
    references = []
    for scene in scenes:
        sets = referenced(scene, stores, tuple(levels), fitted=len(levels))
        if not sets:
            raise unconverged(scene.name, failed)
        references += sets
    return references


def extremes(table: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows and columns of the terminal: no single balls, uncertainty in the quantity's unit alone."""
    return [
        {k: v for k, v in row.items() if k not in ("uncertainty_percent", "kind")}
        for row in table
        if "load of ball" not in row["quantity"]
    ]


def library(
    target: Solvable, levels: int | None, step: Callable[[str], None], *, spread: bool, store: Path
) -> tuple[dict[str, Any], str, tuple[str, ...]]:
    """What `rollbench.mesh_study` returns of a scene: JSON-ready, key of the table that is shown, closing lines.
    step: takes lines of progress."""
    from rollbench.meshes.cache import default_root

    stores, wanted = (store, shipped_store()), levels_of(levels)
    references = compute_study([target], wanted, stores, Engine(cache=default_root()), step, spread=spread)
    results = [
        {"scene": target.name, "levels": level_rows(x.found), "quantities": table_of(x, stores, wanted)} | named(x)
        for x in references
    ]
    lines = tuple(closing(one.found) for one in references)
    if isinstance(target, Scene):
        return results[0], "levels", lines
    return {"scene": target.name, "sets": results}, "sets", lines
