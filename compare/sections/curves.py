"""Curves of figures from arrays and results, and the figure of a mesh study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import Loads
from rollbench.compare.reference.estimate import Reference
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Series


def plain_numbers(values: Array, factor: float = 1.0) -> list[float]:
    """Return plain numbers for a record, times a factor."""
    return [factor * float(v) for v in values]


def lateral_displacement_curves(
    stations: Array, moved: Array, name: str = "u_{}", style: str = "line", *, emphasis: bool = False
) -> tuple[Series, Series]:
    """Return curves of both lateral displacements [um] of an axis over its stations.

    Parameters
    ----------
    stations
        Stations, (k,) [mm].
    moved
        Displacements, (k, 2 or more) [m].
    name
        Label, with a placeholder for the direction.
    style
        Style of the curves.
    emphasis
        Whether they are drawn bold.
    """
    z = plain_numbers(stations, 1e3)
    x, y = (
        Series(name.format(axis), z, plain_numbers(moved[:, k], 1e6), style, emphasis=emphasis)
        for k, axis in enumerate("xy")
    )
    return x, y


def load_panel(title: str, *series: Series, zero: bool = False) -> Panel:
    """Return a panel for contact loads over the balls."""
    return Panel(title, "ball", "contact load / N", series, zero=zero, integer_x=True)


def load_curve(
    label: str,
    result: StaticResult | Loads | Reference,
    side: int,
    style: str = "line+markers",
    *,
    emphasis: bool = False,
    bar: Array | None = None,
) -> Series:
    """Return the curve of the loads of one flank over the number of the ball, with uncertainty ``bar`` (n, 4) [N]."""
    load = result.load[:, side]
    balls = [float(i + 1) for i in range(load.size)]
    ends = None if bar is None else (plain_numbers(load - bar[:, side]), plain_numbers(load + bar[:, side]))
    return Series(label, balls, plain_numbers(load), style, emphasis=emphasis, bars=ends)


#: Curves of a panel.
MOST = 8


def study_figure(name: str, table: Sequence[Mapping[str, Any]], found: Reference) -> Figure | None:
    """Draw extreme loads and displacements over the relative cell size, as differences from the finest level.

    In per cent of the panel's largest value, with the uncertainty at the finest level and the extrapolation to zero
    cell size. None with fewer than two levels.
    """
    if len(found.runs) < 2:
        return None
    sizes = [size / found.sizes[-1] for size in found.sizes]
    keys = [f"level {run.level}" for run in found.runs]
    panels = []
    for title, rows in (
        ("contact loads", [row for row in table if "est load" in row["quantity"]]),
        ("centreline", [row for row in table if row["quantity"].startswith("centreline")]),
    ):
        scale = max((abs(row[keys[-1]]) for row in rows), default=0.0)
        series = [s for row in rows[:MOST] for s in _curve_and_power_law(row, keys, sizes, scale)]
        if series:
            label = f"difference from the finest / % of {scale:.3g} {rows[0]['unit']}"
            panels.append(Panel(title, "cell size over the finest's", label, tuple(series)))
    if not panels:
        return None
    caption = "Bars: uncertainty of the finest level. Lines that end at cell size zero: accepted extrapolations."
    return Figure(f"mesh-study-{name}", f"{name}: mesh study", tuple(panels), caption)


def _curve_and_power_law(row: Mapping[str, Any], keys: Sequence[str], sizes: Sequence[float], scale: float) -> list[Series]:
    """Return the curve of one quantity over cell size, and its power law down to zero cell size."""
    finest, bar = row[keys[-1]], row["uncertainty"] or 0.0
    if scale == 0.0:
        return []

    def off(value: Any) -> Any:
        return error_percent(value, finest, scale)

    y = [float(off(row[key])) for key in keys]
    ends = (*y[:-1], float(off(finest - bar))), (*y[:-1], float(off(finest + bar)))
    out = [Series(row["quantity"], sizes, y, "line+markers", bars=ends)]
    if row["extrapolated"] is not None and row["order"]:
        h = np.linspace(0.0, 1.0, 21)
        line = off(row["extrapolated"] + (finest - row["extrapolated"]) * h ** row["order"])
        out.append(Series(row["quantity"], h.tolist(), np.asarray(line, float).tolist(), "line", light=True))
    return out
