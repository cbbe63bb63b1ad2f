"""Case study 3 of Lin 2.4.1: the readings of the right end compared."""

from __future__ import annotations

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.lin.evidence.loads_2_4_1 import READINGS
from rollbench.reports.records import Cell, Column, Table


def reference_words(study: Study, name: str) -> str:
    """Text that says which 3D reference a scene has."""
    found = study.reference(name)
    return "none stored" if found is None else f"level {found.runs[-1].level}"


def readings_table(study: Study) -> Table:
    """Extremes of every reading and what it changes against the first, by the source's and the default model."""
    rows: list[dict[str, Cell]] = []
    for reading in READINGS:
        for name, first in ((reading.plain, READINGS[0].plain), (reading.offset, READINGS[0].offset)):
            row: dict[str, Cell] = {
                "scene": name,
                "held": reading.label,
                "text": "yes" if reading.of_text else "no",
                "reference": reference_words(study, name),
            }
            for model, key in (("lin", "lin"), (DEFAULT, "refined")):
                result = study.solve(name, model)
                e = load_error(result.load, study.solve(first, model).load)
                row |= {
                    f"{key}_max": float(result.load.max()),
                    f"{key}_min": float(result.load.min()),
                    f"{key}_change": e.max_percent,
                    f"{key}_where": f"{e.ball} {e.side}" if e.max_percent > 0.0 else "–",
                }
            rows.append(row)
    columns = [
        Column("scene", "scene", "", "s"),
        Column("held", "right end", "", "s"),
        Column("text", "text's reading", "", "s"),
        Column("reference", "3D reference", "", "s"),
    ]
    for key, words in (("lin", "source's model"), ("refined", "refined model")):
        columns += [
            Column(f"{key}_max", f"max, {words}", "N", ".1f"),
            Column(f"{key}_min", f"min, {words}", "N", ".1f"),
            Column(f"{key}_change", f"largest change, {words}", "% of mean", ".2f"),
            Column(f"{key}_where", f"at ball, {words}", "", "s"),
        ]
    note = (
        "The text sets only the x-displacement of the last node (2.4.1.3). A bearing there holds the y-displacement too, "
        "which is what the 3D reference was computed for; whether it holds rotations is open. Changes are against the "
        "first reading."
    )
    return Table("cases-readings", "Case 3: readings of the right end", columns, rows, note)
