"""The commands ``rollbench mesh-study`` and ``rollbench compare``."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from compare import catalogue
from compare.comparison import as_json, rows
from compare.convergence import observe
from compare.errors import InputError
from compare.measure import error_percent
from compare.reference import LEVELS, VARIANTS, Run, compute, load, reference, save, shipped_store
from compare.writing import replace_file
from meshes.parts import SIDES, Scene

Show = Callable[..., None]


def ensure(
    scenes: Sequence[Scene], levels: int, store: Path, step: Callable[[str], None], variants: Sequence[str] = ()
) -> None:
    """Compute the runs that no store holds yet, level after level; each is stored when it is done."""
    tasks = [(level, "") for level in range(1, levels + 1)] + [(1, v) for v in variants]
    for level, variant in tasks:
        missing = [s for s in scenes if load(s, level, variant, stores=(store,)) is None]
        if not missing:
            continue
        step(f"level {level}{' ' + VARIANTS[variant][0] if variant else ''}: {', '.join(s.name for s in missing)}")
        for run, scene in zip(compute(missing, level, variant, step), missing, strict=True):
            save(store, scene, run)


def _extreme(side: int, sign: float, run: Run) -> float:
    return float(sign * (sign * run.load[:, side]).max())


def _single(ball: int, side: int, run: Run) -> float:
    return float(run.load[ball, side])


def study_table(scene: Scene, store: Path, levels: int) -> list[dict[str, Any]]:
    """Per quantity: value on each level, observed order, extrapolated value, grid uncertainty, modelling spread."""
    runs = [r for k in range(1, levels + 1) if (r := load(scene, k, stores=(store,))) is not None]
    quantities: list[tuple[str, Callable[[Run], float]]] = []
    for s, side in enumerate(SIDES):
        if runs and (runs[-1].load[:, s] > 0.0).any():
            quantities += [
                (f"largest load, {side}", partial(_extreme, s, 1.0)),
                (f"smallest load, {side}", partial(_extreme, s, -1.0)),
            ]
            quantities += [
                (f"load of ball {i + 1}, {side}", partial(_single, i, s)) for i in range(len(runs[-1].load))
            ]
    base = load(scene, 1, stores=(store,))
    changed = {v: r for v in VARIANTS if (r := load(scene, 1, v, stores=(store,))) is not None and v != "rigid-nut"}
    table = []
    for name, take in quantities:
        values = [take(r) for r in runs]
        row: dict[str, Any] = {"quantity": name, **{f"level {r.level}": v for r, v in zip(runs, values, strict=True)}}
        if len(values) >= 3:
            found = observe(values[-3:], [1.0 / r.settings["b_over_h"] for r in runs[-3:]])
            row |= {
                "order": found.order, "extrapolated": found.extrapolated, "uncertainty_N": found.uncertainty,
                "uncertainty_percent": float(error_percent(found.uncertainty, 0.0, values[-1])),
                "kind": "grid convergence index" if found.monotone else "band: not monotone",
            }  # fmt: skip
        if base is not None and changed:
            spread = max(abs(take(r) - take(base)) for r in changed.values())
            row["modelling_spread_N"] = spread
        table.append(row)
    return table


def run_mesh_study(
    names: Sequence[str], levels: int, store: Path, *, spread: bool, json_out: bool, show: Show,
    print_json: Callable[[Any], None],
) -> int:  # fmt: skip
    """Compute what is missing, print the table, write it as CSV into the store."""
    if not 1 <= levels <= len(LEVELS):
        raise InputError("command line", "--levels", str(levels), f"1 to {len(LEVELS)}", "three levels give an order")
    scenes = [catalogue.scene(name) for name in names]
    import sys

    def step(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    ensure(scenes, levels, store, step, tuple(VARIANTS) if spread else ())
    tables = {scene.name: study_table(scene, store, levels) for scene in scenes}
    for name, table in tables.items():
        columns = list(dict.fromkeys(k for row in table for k in row))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns)
        writer.writeheader()
        writer.writerows(table)
        replace_file(store / f"{name}-mesh-study.csv", text.getvalue())
        if not json_out:
            show(_terminal(name, columns, table))
    if json_out:
        print_json(tables)
    return 0


def _terminal(name: str, columns: Sequence[str], table: Sequence[dict[str, Any]]) -> Any:
    from rich.table import Table

    out = Table(title=f"mesh study of {name}", title_justify="left")
    for column in columns:
        out.add_column(column)
    for row in table:
        out.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v or "–") for v in (row.get(c) for c in columns)))
    return out


def run_compare(
    names: Sequence[str], models: Sequence[str], levels: int, store: Path, *, json_out: bool, show: Show,
    print_json: Callable[[Any], None],
) -> int:  # fmt: skip
    """Rows of every scene and model against the stored reference, computed first where there is none."""
    import sys

    def step(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    out = []
    for name in names:
        scene = catalogue.scene(name)
        if reference(scene, (store, shipped_store())) is None:
            ensure([scene], levels, store, step)
        found = reference(scene, (store, shipped_store()))
        if found is None:
            raise InputError(scene.name, "3D reference", "not converged", "a converged reference", "see the run's status")
        for model in models:
            out += rows(scene, model, found)
    if json_out:
        print_json([as_json(row) for row in out])
        return 0
    from rich.table import Table

    table = Table(title="low-order models against the 3D reference", title_justify="left")
    for column in ("scene", "model", "quantity", "ball", "side", "value", "reference", "+-", "error %"):
        table.add_column(column)

    def cell(value: float | int | str | None, form: str = "") -> str:
        return "–" if value is None or (isinstance(value, float) and np.isnan(value)) else format(value, form)

    for row in out:
        table.add_row(
            row.scene, row.model, row.quantity, cell(row.ball), cell(row.side), cell(row.value, ".2f"),
            cell(row.reference, ".2f"), cell(row.reference_error, ".2f"), cell(row.error_percent, "+.2f"),
        )  # fmt: skip
    show(table)
    return 0
