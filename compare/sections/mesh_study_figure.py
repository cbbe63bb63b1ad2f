"""Figure of a mesh study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference.estimate import Reference
from rollbench.reports.content import Figure, Panel, Series

#: Curves of a panel.
MOST = 8


def study_figure(name: str, table: Sequence[Mapping[str, Any]], found: Reference) -> Figure | None:
    """Largest and smallest loads, and the centreline, over the cell size, as difference from the finest level in per cent
    of the panel's largest value; bars at the finest, extrapolation to cells of no size. None with fewer than two levels."""
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
        series = [s for row in rows[:MOST] for s in _curves(row, keys, sizes, scale)]
        if series:
            label = f"difference from the finest / % of {scale:.3g} {rows[0]['unit']}"
            panels.append(Panel(title, "cell size over the finest's", label, tuple(series)))
    if not panels:
        return None
    caption = "Bars: uncertainty of the finest level. Lines that end at cell size zero: accepted extrapolations."
    return Figure(f"mesh-study-{name}", f"{name}: mesh study", tuple(panels), caption)


def _curves(row: Mapping[str, Any], keys: Sequence[str], sizes: Sequence[float], scale: float) -> list[Series]:
    """Values of one quantity over the cell size, and the power law from the finest to cells of no size."""
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
