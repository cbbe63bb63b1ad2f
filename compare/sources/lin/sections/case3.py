"""Case study 3 of Lin 2.4.1: the readings of the right end compared."""

from __future__ import annotations

from rollbench.comparison.measure import load_error
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.lin.evidence.loads_2_4_1 import READINGS
from rollbench.reports.records import Quantity, Row, Table


def reference_words(study: Study, name: str) -> str:
    """Text that says which 3D reference a scene has."""
    found = study.reference(name)
    return "none stored" if found is None else f"level {found.runs[-1].level}"


def readings_table(study: Study) -> Table:
    """Extremes of every reading and what it changes against the first, by the source's and the default model."""
    rows: list[Row] = []
    for reading in READINGS:
        for name, first in ((reading.plain, READINGS[0].plain), (reading.offset, READINGS[0].offset)):
            row: Row = {
                "scene": name,
                Quantity("held", "right end", "", "s"): reading.label,
                Quantity("text", "text's reading", "", "s"): "yes" if reading.of_text else "no",
                Quantity("reference", "3D reference", "", "s"): reference_words(study, name),
            }
            for model, words in (("lin", "source's model"), (DEFAULT, "refined model")):
                result = study.solve(name, model)
                e = load_error(result.load, study.solve(first, model).load)
                where = f"{e.ball} {e.side}" if e.max_percent > 0.0 else "–"
                row |= {
                    Quantity(f"{model}_max", f"max, {words}", "N", ".1f"): float(result.load.max()),
                    Quantity(f"{model}_min", f"min, {words}", "N", ".1f"): float(result.load.min()),
                    Quantity(f"{model}_change", f"largest change, {words}", "% of mean", ".2f"): e.max_percent,
                    Quantity(f"{model}_where", f"at ball, {words}", "", "s"): where,
                }
            rows.append(row)
    note = (
        "The text sets only the x-displacement of the last node (2.4.1.3). A bearing there holds the y-displacement too, "
        "which is what the 3D reference was computed for; whether it holds rotations is open. Changes are against the "
        "first reading."
    )
    return Table.of("cases-readings", "Case 3: readings of the right end", rows, note)
