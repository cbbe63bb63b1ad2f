"""The commands ``rollbench mesh-study`` and ``rollbench compare``."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from compare.commands.compare_output import (
    Beside,
    answers_json,
    answers_table,
    compared,
    contact_rows,
    verdict,
    write_files,
)
from compare.commands.compare_output import table as compared_table
from compare.errors import InputError, Refusal
from compare.models.comparison import compared_models, finest_bodies, rows, suited
from compare.models.mesh_study import closing, level_rows, studied, study_table
from compare.reference.estimate import Reference, reference
from compare.reference.jobs import Engine, all_variants, ensure, plan
from compare.reference.levels import LEVELS, SOURCE_LEVEL, STUDIED
from compare.reference.store import Run, shipped_store
from compare.scenes import catalogue
from compare.writing import replace_file
from meshes.parts import Scene
from reports.html import harmless

Show = Callable[..., None]


def on_terminal(text: str) -> None:
    """A line of progress, on standard error."""
    print(text, file=sys.stderr, flush=True)


def run_mesh_study(
    names: Sequence[str],
    levels: int,
    store: Path,
    engine: Engine,
    *,
    spread: bool,
    source: bool,
    json_out: bool,
    show: Show,
    print_json: Callable[[Any], None],
    fresh: bool = False,
) -> int:
    """Compute what is missing (fresh: everything anew), print the table, write it as CSV and SVG into the store.

    Raises Refusal for a scene of which no run converged.
    """
    if not 1 <= levels <= len(LEVELS):
        raise InputError("command line", "--levels", str(levels), f"1 to {len(LEVELS)}", "three levels give an order")
    scenes = [catalogue.scene(name) for name in names]
    tasks = plan(scenes, range(1, levels + 1), source=source)
    if spread:
        tasks += [t for s in scenes for t in plan([s], (), all_variants())]
    stores = (store,) if fresh else (store, shipped_store())
    failed = ensure(tasks, store, engine, on_terminal, stores[1:], fresh=fresh)
    found = {scene.name: studied(scene, stores, levels) for scene in scenes}
    tables = {scene.name: study_table(scene, stores, levels) for scene in scenes}
    for name, whole in found.items():
        if whole is None:
            raise unconverged(name, failed)
        table = tables[name]
        columns = list(dict.fromkeys(k for row in table for k in row))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows({k: harmless(v) if isinstance(v, str) else v for k, v in row.items()} for row in table)
        replace_file(store / f"{name}-mesh-study.csv", text.getvalue())
        _figure(name, table, whole, store)
        if not json_out:
            show(f"mesh study of {name}", "", _aligned(level_rows(whole)), "", _aligned(_extremes(table)), "")
            show(closing(whole), f"every contact: {store / name}-mesh-study.csv and .svg written")
    if json_out:
        print_json(tables)
    return 0


def unconverged(name: str, failed: Sequence[Run]) -> Refusal:
    """What is said of a scene without a converged run: what became of its runs."""
    why = [f"level {run.level}: {run.status}" for run in failed if run.scene == name]
    reason = f"no run of the 3D reference converged ({'; '.join(why)})" if why else "no converged run of the 3D reference"
    return Refusal(name, "3D reference", reason, "change what the status names, or solve it with a low-order model")


def _figure(name: str, table: Sequence[dict[str, Any]], found: Reference, store: Path) -> None:
    from compare.sections.study_figure import study_figure
    from reports.figures import draw

    figure = study_figure(name, table, found)
    if figure is not None:
        replace_file(store / f"{name}-mesh-study.svg", draw(figure))


def _extremes(table: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows and columns of the terminal: no single balls, uncertainty in the quantity's unit alone."""
    return [
        {k: v for k, v in row.items() if k not in ("uncertainty_percent", "kind")}
        for row in table
        if "load of ball" not in row["quantity"]
    ]


def _aligned(rows: Sequence[dict[str, Any]]) -> Any:
    """Rows as a table, numbers flush right; no column without a value."""
    from rich.table import Table

    out = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    kept = [column for column in rows[0] if any(row[column] is not None for row in rows)]
    for column in kept:
        words = isinstance(rows[0][column], str)
        out.add_column(column.replace("_", " ").replace("percent", "%"), justify="left" if words else "right")
    for row in rows:
        values = [row[column] for column in kept]
        out.add_row(*("–" if v is None else f"{v:.4g}" if isinstance(v, float) else str(v) for v in values))
    return out


def parse_levels(text: str) -> tuple[int, ...]:
    """Levels of ``--levels``: ``3`` (levels 1 to 3), ``1,3``, ``source,1,2,3``. Raises InputError."""
    allowed = f"a number from 1 to {len(LEVELS)}, or some of source, {', '.join(map(str, LEVELS))} with commas"
    if text in [str(k) for k in LEVELS]:
        return tuple(range(1, int(text) + 1))
    names = {"source": SOURCE_LEVEL} | {str(k): k for k in LEVELS}
    parts = [part.strip() for part in text.split(",")]
    if any(part not in names for part in parts):
        raise InputError("command line", "--levels", f'"{text}"', allowed, "3 computes levels 1, 2 and 3")
    return tuple(sorted({names[part] for part in parts}))


def run_compare(
    names: Sequence[str],
    models: Sequence[str],
    levels: tuple[int, ...] | None,
    store: Path,
    engine: Engine,
    *,
    json_out: bool,
    show: Show,
    print_json: Callable[[Any], None],
    fresh: bool = False,
    balls: bool = False,
) -> int:
    """Verdict, answers, table and files of every scene, models beside the reference; what is not stored is computed first.

    JSON: verdict and answers of every scene, and rows of every quantity and model, the reference's coarser runs among
    them. balls: also print every contact.
    levels: None for the best stored reference (levels `STUDIED` are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    own = compared_models(tuple(models))
    scenes = [catalogue.scene(name) for name in names]
    stores = (store, shipped_store())
    without = [s for s in scenes if reference(s, stores) is None] if levels is None and not fresh else scenes
    failed: list[Run] = []
    if without:
        wanted = levels or STUDIED
        tasks = plan(without, [k for k in wanted if k != SOURCE_LEVEL], source=SOURCE_LEVEL in wanted)
        failed = ensure(tasks, store, engine, on_terminal, stores, fresh=fresh)
    told, out = [], []
    for name, scene in zip(names, scenes, strict=True):
        found = reference(scene, stores)
        if found is None:
            raise unconverged(scene.name, failed)
        whole = compared(scene, own or suited(scene), found, stores)
        if json_out:
            told.append(answers_json(whole, found))
            out += [row.as_json() for b in whole.models for row in rows(scene, b.answer, found)]
            continue
        show(f"{scene.name}: {verdict(whole, found)}", "", answers_table(whole), "")
        show(compared_table(whole.models, whole.itself), "")
        if balls:
            show(_contacts(scene, whole.models, found), "")
        bodies = finest_bodies(scene, found, stores)
        if bodies is not None:
            show(f"preload, 6 x 6 stiffness, friction by the 3D bodies: rollbench solve {name} --condensed {bodies}")
        show(write_files(scene, whole.models, found, store))
    if json_out:
        print_json({"scenes": told, "rows": out})
    return 0


def _contacts(scene: Scene, models: Sequence[Beside], found: Reference) -> Any:
    from rich.table import Table

    own = contact_rows(scene, models, found)
    out = Table(title=f"{scene.name}: contact loads / N", title_justify="left", box=None, pad_edge=False)
    for column in list(own[0])[1:]:
        out.add_column(column.removesuffix("_N"), justify="right")
    for row in own:
        cells = list(row.values())[1:]
        out.add_row(*("–" if v is None else f"{v:.2f}" if isinstance(v, float) else str(v) for v in cells))
    return out
