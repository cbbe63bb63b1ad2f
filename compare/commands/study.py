"""The commands ``rollbench mesh-study`` and ``rollbench compare``."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from compare.errors import InputError, Refusal
from compare.measure import error_percent
from compare.models.comparison import CONTENDERS, contenders, from_model, reference_answers, rows, suited
from compare.models.modelling import base_run
from compare.reference import grid_order
from compare.reference.convergence import observe
from compare.reference.jobs import Engine, all_variants, ensure, plan
from compare.reference.levels import LEVELS, SOURCE_LEVEL
from compare.reference.runs import Run, load, reference, reference_of, shipped_store
from compare.reference.variants import VARIANTS
from compare.scenes import catalogue
from compare.writing import replace_file
from meshes.parts import SIDES, Scene

Show = Callable[..., None]
Take = partial[float]


def _extreme(side: int, sign: float, run: Run) -> float:
    return float(sign * (sign * run.load[:, side]).max())


def _single(ball: int, side: int, run: Run) -> float:
    return float(run.load[ball, side])


def _line(station: int, axis: int, run: Run) -> float:
    """Displacement [um] at one of the stations that every level shares."""
    return float(1e6 * run.centreline[station, 1 + axis])


def quantities(run: Run) -> list[tuple[str, str, Take]]:
    """What a mesh study follows: name, unit, how to take it from a run."""
    out: list[tuple[str, str, Take]] = []
    for s, side in enumerate(SIDES):
        if (run.load[:, s] > 0.0).any():
            out += [
                (f"largest load, {side}", "N", partial(_extreme, s, 1.0)),
                (f"smallest load, {side}", "N", partial(_extreme, s, -1.0)),
            ]
            out += [(f"load of ball {i + 1}, {side}", "N", partial(_single, i, s)) for i in range(len(run.load))]
    for k in sorted({0, len(run.centreline) // 2}):
        for axis, name in enumerate("xyz"):
            z = 1e3 * run.centreline[k, 0]
            out.append((f"centreline u{name} at {z:.4g} mm", "um", partial(_line, k, axis)))
    return out


def study_table(scene: Scene, stores: Sequence[Path] | None, levels: int = len(LEVELS)) -> list[dict[str, Any]]:
    """Per quantity: value on each level, its own order, extrapolated value, grid uncertainty and why it has an order or
    none; modelling uncertainty (root of squares over the choices that were varied) and the effect of the scene's own ones.

    Loads of single contacts, extremes that every level finds at the same ball among them, have the uncertainty of the fit
    with one order for all contacts, the others that of their own.
    """
    runs = tuple(r for k in range(1, levels + 1) if (r := load(scene, k, stores=stores)) is not None)
    if not runs:
        return []
    order = grid_order.load((*(stores or ()), shipped_store()))
    found = reference_of(scene.name, runs, None if order is None else order.interval)
    coarsest = min(LEVELS)
    base = base_run(scene, coarsest, stores)
    others = [v for v, variant in VARIANTS.items() if v != "base" and not variant.refined]
    changed = {v: r for v in others if (r := load(scene, coarsest, v, stores)) is not None}
    table = []
    for name, unit, take in quantities(runs[-1]):
        values = [take(r) for r in runs]
        row: dict[str, Any] = {"quantity": name, "unit": unit}
        row |= {f"level {r.level}": v for r, v in zip(runs, values, strict=True)}
        if len(runs) >= 2:
            contact = _contact(take, runs)
            pooled = found.convergence is not None and contact is not None
            c = found.convergence[contact[0]][contact[1]] if pooled else observe(values, found.sizes)  # type: ignore[index]
            row |= {
                "order": c.order,
                "extrapolated": c.extrapolated,
                "uncertainty": c.uncertainty,
                "uncertainty_percent": _percent(c.uncertainty, values[-1]),
                "kind": c.text,
            }
        if base is not None and changed:
            moves = {v: abs(take(r) - take(base)) for v, r in changed.items()}
            row["modelling_spread"] = _root_of_squares(moves)
            row["scene_choices"] = max((m for v, m in moves.items() if VARIANTS[v].kind == "scene"), default=None)
        table.append(row)
    return table


def _contact(take: Take, runs: Sequence[Run]) -> tuple[int, int] | None:
    """Ball and side of the contact whose load a quantity is on every level, if it is that of one contact."""
    if take.func is _single:
        return take.args[0], take.args[1]
    if take.func is not _extreme:
        return None
    side, sign = take.args
    balls = {int((sign * run.load[:, side]).argmax()) for run in runs}
    return (balls.pop(), side) if len(balls) == 1 else None


def _percent(value: float | None, of: float) -> float | None:
    """A number in per cent of another; None where there is none, or nothing to compare it with."""
    if value is None or (of == 0.0 and value != 0.0):
        return None
    return float(error_percent(value, 0.0, of))


def _root_of_squares(moves: Mapping[str, float]) -> float | None:
    """Root of squares over modelling choices, each by the larger of its variants; None where none was varied."""
    by_choice: dict[str, float] = {}
    for name, move in moves.items():
        variant = VARIANTS[name]
        if variant.kind == "modelling":
            by_choice[variant.choice] = max(move, by_choice.get(variant.choice, 0.0))
    return float(np.linalg.norm(list(by_choice.values()))) if by_choice else None


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
    failed = ensure(tasks, store, engine, on_terminal, fresh=fresh)
    tables = {scene.name: study_table(scene, (store,), levels) for scene in scenes}
    for name, table in tables.items():
        if not table:
            raise unconverged(name, failed)
    for name, table in tables.items():
        columns = list(dict.fromkeys(k for row in table for k in row))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows(table)
        replace_file(store / f"{name}-mesh-study.csv", text.getvalue())
        _figure(name, table, store)
        if not json_out:
            show(_terminal(name, columns, table), f"{store / name}-mesh-study.csv and .svg written")
    if json_out:
        print_json(tables)
    return 0


def unconverged(name: str, failed: Sequence[Run]) -> Refusal:
    """What is said of a scene without a converged run: what became of its runs."""
    why = [f"level {run.level}: {run.status}" for run in failed if run.scene == name]
    reason = f"no run of the 3D reference converged ({'; '.join(why)})" if why else "no converged run of the 3D reference"
    return Refusal(name, "3D reference", reason, "change what the status names, or solve it with a low-order model")


def _figure(name: str, table: Sequence[dict[str, Any]], store: Path) -> None:
    from compare.sections.reference import study_figure
    from reports.figures import draw

    figure = study_figure(name, table)
    if figure is not None:
        replace_file(store / f"{name}-mesh-study.svg", draw(figure))


def _terminal(name: str, columns: Sequence[str], table: Sequence[dict[str, Any]]) -> Any:
    from rich.table import Table

    out = Table(title=f"mesh study of {name}", title_justify="left")
    for column in columns:
        out.add_column(column)
    for row in table:
        out.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v or "–") for v in (row.get(c) for c in columns)))
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
) -> int:
    """Rows of every scene and model against the reference; what is not stored is computed first.

    levels: None for the best stored reference (all levels are computed where there is none); else just those. fresh:
    compute them even where they are stored. Raises Refusal for a scene of which no run converged.
    """
    own = contenders(tuple(models))
    scenes = [catalogue.scene(name) for name in names]
    stores = (store, shipped_store())
    without = [s for s in scenes if reference(s, stores) is None] if levels is None and not fresh else scenes
    failed: list[Run] = []
    if without:
        wanted = levels or tuple(LEVELS)
        tasks = plan(without, [k for k in wanted if k != SOURCE_LEVEL], source=SOURCE_LEVEL in wanted)
        failed = ensure(tasks, store, engine, on_terminal, stores, fresh=fresh)
    out = []
    for scene in scenes:
        found = reference(scene, stores)
        if found is None:
            raise unconverged(scene.name, failed)
        answers = [from_model(c, scene) for c in (own or suited(scene))]
        answers += reference_answers(found, load(scene, SOURCE_LEVEL, stores=stores))
        for answer in answers:
            out += rows(scene, answer, found)
    if json_out:
        print_json([row.as_json() for row in out])
        return 0
    for scene in scenes:
        show(_summary(scene, [row for row in out if row.scene == scene.name]))
        show(_contacts(scene, [row for row in out if row.scene == scene.name]))
    return 0


def _cell(value: float | int | str | None, form: str = "") -> str:
    return "–" if value is None or (isinstance(value, float) and not np.isfinite(value)) else format(value, form)


def _summary(scene: Scene, own: Sequence[Any]) -> Any:
    from rich.table import Table

    table = Table(title=f"{scene.name}: models against the finest 3D reference", title_justify="left")
    for column in ("model", "quantity", "value", "reference", "printed", "reference's uncertainty", "seconds"):
        table.add_column(column)
    for row in own:
        if row.ball is None and not row.quantity.startswith("centreline"):
            table.add_row(
                _label(row.model),
                row.quantity,
                _cell(row.value, ".3f") + f" {row.unit}",
                _cell(row.reference, ".3f"),
                _cell(row.printed),
                _cell(row.reference_error, ".2f"),
                _cell(row.seconds, ".3g"),
            )
    return table


def _label(name: str) -> str:
    return CONTENDERS[name].label if name in CONTENDERS else name


def _contacts(scene: Scene, own: Sequence[Any]) -> Any:
    from rich.table import Table

    models = list(dict.fromkeys(row.model for row in own))
    table = Table(title=f"{scene.name}: contact loads / N", title_justify="left")
    for column in ("ball", "side", *(_label(m) for m in models), "reference", "+-"):
        table.add_column(column)
    cells: dict[tuple[int, str], dict[str, Any]] = {}
    for row in own:
        if row.quantity == "load":
            cells.setdefault((row.ball, row.side), {})[row.model] = row
    for (ball, side), found in sorted(cells.items(), key=lambda x: (x[0][0], SIDES.index(x[0][1]))):
        first = next(iter(found.values()))
        values = [_cell(found[m].value if m in found else 0.0, ".1f") for m in models]
        table.add_row(str(ball), side, *values, _cell(first.reference, ".1f"), _cell(first.reference_error, ".2f"))
    return table
