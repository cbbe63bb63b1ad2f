"""Mesh study of the 3D reference: extreme and single loads and the centreline, level by level."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from compare.measure import error_percent, load_error
from compare.models.modelling import base_run
from compare.reference import grid_order
from compare.reference.convergence import observe
from compare.reference.estimate import Reference, reference_of
from compare.reference.grid_summary import mean_load
from compare.reference.levels import LEVELS
from compare.reference.store import Run, load, shipped_store
from compare.reference.variants import VARIANTS
from meshes.parts import SIDES, Scene

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


def studied(scene: Scene, stores: Sequence[Path] | None, levels: int = len(LEVELS)) -> Reference | None:
    """The reference of all stored runs on levels 1 to ``levels``; None without any."""
    runs = tuple(r for k in range(1, levels + 1) if (r := load(scene, k, stores=stores)) is not None)
    order = grid_order.load((*(stores or ()), shipped_store()))
    return reference_of(scene.name, runs, None if order is None else order.interval) if runs else None


def level_rows(found: Reference) -> list[dict[str, Any]]:
    """Per level, coarsest first: cell size over the finest's, unknowns of the equivalent monolithic mesh, own seconds,
    largest difference of a contact load from the finest and `enough`, in per cent of the mean load."""
    return [
        {
            "level": run.level,
            "cell_size": size / found.sizes[-1],
            "unknowns": run.unknowns,
            "seconds": run.setup_seconds + run.solve_seconds,
            "difference_percent": load_error(run.load, found.load).max_percent,
            "enough_for_percent": enough(run, found),
        }
        for run, size in zip(found.runs, found.sizes, strict=True)
    ]


def enough(run: Run, found: Reference) -> float | None:
    """What a run's contact loads are good for [% of the mean load]: the largest difference from the finest run with that
    run's uncertainty added; None with one level."""
    if found.uncertainty is None:
        return None
    return float(error_percent(np.abs(run.load - found.load) + found.uncertainty, 0.0, mean_load(found)).max())


def closing(found: Reference) -> str:
    """Which level is enough for what, in one sentence.

    Per cents are rounded up.
    """
    rows = level_rows(found)
    if rows[-1]["enough_for_percent"] is None:
        return "One level does not say what it is enough for: take two or more."
    first, *others = [(r["level"], f"{_up(r['enough_for_percent'])} %", f"{r['seconds']:.0f} s") for r in rows]
    rest = "".join(f", level {level} for {percent} ({time})" for level, percent, time in others)
    return f"Level {first[0]} is enough for {first[1]} of the mean contact load ({first[2]}){rest}."


def _up(percent: float) -> str:
    """Rounded up to two digits.

    >>> _up(1.21), _up(0.031), _up(2.0)
    ('1.3', '0.031', '2')
    """
    unit = 10.0 ** (math.floor(math.log10(percent)) - 1) if percent > 0.0 else 1.0
    return f"{math.ceil(percent / unit - 1e-9) * unit:.2g}"


def study_table(scene: Scene, stores: Sequence[Path] | None, levels: int = len(LEVELS)) -> list[dict[str, Any]]:
    """Per quantity that is not held at zero: value on each level, its own order, extrapolated value, grid uncertainty and
    why it has an order or none; modelling uncertainty (root of squares over the choices that were varied) and the effect of
    the scene's own ones.

    Loads of single contacts, extremes that every level finds at the same ball among them, have the uncertainty of the fit
    with one order for all contacts, the others that of their own.
    """
    found = studied(scene, stores, levels)
    if found is None:
        return []
    runs = found.runs
    coarsest = min(LEVELS)
    base = base_run(scene, coarsest, stores)
    others = [v for v, variant in VARIANTS.items() if v != "base" and not variant.refined]
    changed = {v: r for v in others if (r := load(scene, coarsest, v, stores)) is not None}
    table = []
    for name, unit, take in quantities(runs[-1]):
        values = [take(r) for r in runs]
        if not any(values):
            continue
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
