"""Figure of a mesh study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from compare.measure import error_percent
from reports.records import Figure, Panel, Series


def study_figure(name: str, table: Sequence[Mapping[str, Any]]) -> Figure | None:
    """Largest and smallest loads over the mesh levels, as change from the finest; None with fewer than two levels."""
    keys = sorted({k for row in table for k in row if k.startswith("level ")})
    if len(keys) < 2:
        return None
    loads = [row for row in table if "est load" in row["quantity"]]
    line = [row for row in table if row["quantity"].startswith("centreline")]
    panels = []
    for title, own in (("contact loads", loads), ("centreline", line)):
        series = []
        for row in own:
            finest = row[keys[-1]]
            if abs(finest) < 1e-9:
                continue
            change = [float(error_percent(row[k], finest)) for k in keys]
            series.append(Series(row["quantity"], [float(k.split()[1]) for k in keys], change, "line+markers"))
        if series:
            panels.append(Panel(title, "mesh level", "change from the finest / %", tuple(series[:8]), integer_x=True))
    if not panels:
        return None
    return Figure(f"mesh-study-{name}", f"{name}: mesh study", tuple(panels))
