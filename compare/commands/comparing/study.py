"""The commands ``rollbench mesh-study`` and ``rollbench compare``."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.comparison.commands.comparing.compare_output import (
    Beside,
    Comparison,
    answers_json,
    answers_table,
    compared,
    contact_rows,
    start_lines,
    verdict,
    write_files,
)
from rollbench.comparison.commands.comparing.compare_output import table as compared_table
from rollbench.comparison.commands.printing import Answer, on_terminal
from rollbench.comparison.commands.wrapping import aligned
from rollbench.comparison.errors import InputError, Refusal
from rollbench.comparison.models.comparison import compared_models, finest_bodies, rows, suited
from rollbench.comparison.models.mesh_study import closing, level_rows, studied, study_table
from rollbench.comparison.reference.estimate import Reference, reference, reference_of
from rollbench.comparison.reference.jobs import Engine, all_variants, ensure, plan
from rollbench.comparison.reference.levels import ADVISED, LEVELS, SOURCE_LEVEL
from rollbench.comparison.reference.store import Run, load, shipped_store
from rollbench.comparison.reference.tasks import Task
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.writing import no_figure, replace_file, write_figure
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.parts import Scene
from rollbench.reports.cells import harmless

#: Exit code where a reference has loads that did not settle.
NOT_SETTLED = 5


def run_mesh_study(
    names: Sequence[str], levels: int, store: Path, engine: Engine, *, spread: bool, source: bool, fresh: bool = False
) -> Answer:
    """Compute what is missing (fresh: everything anew), answer with the table, write it as CSV and SVG into the store.

    Raises Refusal for a scene of which no run converged.
    """
    scenes = [catalogue.scene(name) for name in names]
    stores = (store,) if fresh else (store, shipped_store())
    found = compute_study(scenes, levels, stores, engine, on_terminal, spread=spread, source=source, fresh=fresh)
    tables = {scene.name: study_table(scene, stores, levels) for scene in scenes}
    for name, whole in found.items():
        table = tables[name]
        columns = list(dict.fromkeys(k for row in table for k in row))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows({k: harmless(v) if isinstance(v, str) else v for k, v in row.items()} for row in table)
        replace_file(store / f"{name}-mesh-study.csv", text.getvalue())
        _figure(name, table, whole, store)
    return Answer(tables, _study_parts(found, tables, store), code_of(found.values()))


def _study_parts(
    found: Mapping[str, Reference], tables: Mapping[str, Sequence[dict[str, Any]]], store: Path
) -> Iterator[Any]:
    for name, whole in found.items():
        yield from (f"mesh study of {name}", "", aligned(level_rows(whole)), "", aligned(_extremes(tables[name])), "")
        yield from (closing(whole), *([whole.unsettled] if whole.unsettled else []))
        yield f"every contact: {store / name}-mesh-study.csv and {no_figure() or '.svg'}"


def compute_study(
    scenes: Sequence[Scene],
    levels: int,
    stores: Sequence[Path],
    engine: Engine,
    step: Callable[[str], None],
    *,
    spread: bool = False,
    source: bool = False,
    fresh: bool = False,
) -> dict[str, Reference]:
    """Runs of the scenes on levels 1 to ``levels``, by name; what the stores lack is computed and kept in the first.

    spread, source, fresh: as the options of ``rollbench mesh-study``. Raises InputError for other levels, Refusal for a
    scene of which no run converged.
    """
    if not 1 <= levels <= len(LEVELS):
        raise InputError("command line", "--levels", str(levels), f"1 to {len(LEVELS)}", "three levels give an order")
    tasks = plan(scenes, range(1, levels + 1), source=source)
    if spread:
        tasks += [t for s in scenes for t in plan([s], (), all_variants())]

    def first(task: Task) -> None:
        """Say what the coarsest level found while finer ones are computed."""
        for scene in task.scenes if task.level == min(LEVELS) and not task.variant else ():
            table = _extremes(study_table(scene, stores[:1], task.level))
            values = (f"{row['quantity']} {row[f'level {task.level}']:.4g} {row['unit']}" for row in table)
            step(f"{scene.name}, by level {task.level} alone: {'; '.join(values)}")

    failed = ensure(tasks, stores[0], engine, step, stores[1:], fresh=fresh, stored=first)
    found = {}
    for scene in scenes:
        whole = studied(scene, stores, levels)
        if whole is None:
            raise unconverged(scene.name, failed)
        found[scene.name] = whole
    return found


def code_of(found: Iterable[Reference]) -> int:
    """Exit code of a command that shows references: `NOT_SETTLED` where the loads of one did not settle, else 0."""
    return NOT_SETTLED if any(reference.unsettled for reference in found) else 0


def unconverged(name: str, failed: Sequence[Run]) -> Refusal:
    """What is said of a scene without a converged run: what became of its runs."""
    why = [f"level {run.level}: {run.status}" for run in failed if run.scene == name]
    reason = f"no run of the 3D reference converged ({'; '.join(why)})" if why else "no converged run of the 3D reference"
    return Refusal(name, "3D reference", reason, "change what the status names, or solve it with a low-order model")


def _figure(name: str, table: Sequence[dict[str, Any]], found: Reference, store: Path) -> None:
    from rollbench.comparison.sections.study_figure import study_figure

    figure = study_figure(name, table, found)
    if figure is not None:
        write_figure(store / f"{name}-mesh-study.svg", figure)


def _extremes(table: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows and columns of the terminal: no single balls, uncertainty in the quantity's unit alone."""
    return [
        {k: v for k, v in row.items() if k not in ("uncertainty_percent", "kind")}
        for row in table
        if "load of ball" not in row["quantity"]
    ]


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
    fresh: bool = False,
    balls: bool = False,
) -> Answer:
    """Verdict, answers, table and files of every scene, models beside the reference; what is not stored is computed first.

    JSON: verdict and answers of every scene, and rows of every quantity and model, the reference's coarser runs among
    them. balls: also print every contact.
    levels: None for the best stored reference (levels `ADVISED` are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    own = compared_models(tuple(models))
    scenes = [catalogue.scene(name) for name in names]
    stores = (store, shipped_store())
    without = [s for s in scenes if reference(s, stores) is None] if levels is None and not fresh else scenes
    failed: list[Run] = []
    if without:
        wanted = levels or ADVISED
        tasks = plan(without, [k for k in wanted if k != SOURCE_LEVEL], source=SOURCE_LEVEL in wanted)

        def first(task: Task) -> None:
            """Print the verdict by the coarsest level while finer ones are computed."""
            for scene in task.scenes if task.level == min(set(wanted) - {SOURCE_LEVEL}) else ():
                run = load(scene, task.level, stores=(store,))
                if run is not None:
                    one = reference_of(scene.name, (run,), contacts=nominal_contacts(scene))
                    whole = compared(scene, (own or suited(scene))[:1], one, stores)
                    on_terminal(f"{scene.name}, by level {task.level} alone: {verdict(whole, one)}")

        failed = ensure(tasks, store, engine, on_terminal, stores, fresh=fresh, stored=first)
    found = [reference(scene, stores) for scene in scenes]

    def each() -> Iterator[tuple[Reference, Comparison]]:
        """References and what is compared with them, as they are asked for."""
        for scene, one in zip(scenes, found, strict=True):
            if one is None:
                raise unconverged(scene.name, failed)
            yield one, compared(scene, own or suited(scene), one, stores)

    def parts() -> Iterator[Any]:
        for name, scene, (one, whole) in zip(names, scenes, each(), strict=True):
            yield from (f"{scene.name}: {verdict(whole, one)}", "", *filter(None, [whole.total.beside]))
            yield from (answers_table(whole), *start_lines(whole), "", compared_table(whole.models, whole.itself), "")
            if balls:
                yield from (_contacts(scene, whole.models, one), "")
            bodies = finest_bodies(scene, one, stores)
            if bodies is not None:
                yield f"preload, 6 x 6 stiffness, friction by the 3D bodies: rollbench solve {name} --condensed {bodies}"
            yield write_files(scene, whole.models, one, store)

    def data() -> dict[str, Any]:
        pairs = list(each())
        answers = [(scene, one, b.answer) for scene, (one, whole) in zip(scenes, pairs, strict=True) for b in whole.models]
        listed = [row.as_json() for scene, one, answer in answers for row in rows(scene, answer, one)]
        return {"scenes": [answers_json(whole, one) for one, whole in pairs], "rows": listed}

    return Answer(data, parts(), code_of(one for one in found if one is not None))


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
