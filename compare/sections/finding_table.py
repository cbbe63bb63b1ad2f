"""The one table of printed numbers and claims with what is computed for them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from rollbench.compare.evidence import Evidence, sentences
from rollbench.reports.content import Cell, Quantity, Table

#: Remarks that more rows than this share are numbered and stand once, in the note.
SHARED = 2
#: Error [%] below which it is round-off and shown as zero.
ROUND_OFF = 1e-9
FAULTS = "As printed: computed with the source's faults repeated; empty where no fault changes the number."


def printed_table(
    name: str, title: str, found: Sequence[Evidence], note: str = "", *, digits: int = 5, place: bool = False
) -> Table:
    """Printed entries, each with its computed values, error, class, verdict and remark.

    Columns of values with the faults repeated and under an inferred reading are there where an entry has one; place: every
    entry, with a column of places (else without inputs, which test no model, and an entry from elsewhere than most says
    so in its label).
    """
    given = 0 if place else sum(f.verdict == "input" for f in found)
    found = [f for f in found if f.verdict != "input"] if given else found
    columns = _columns(found, digits, place)
    usual = Counter(f.printed.place for f in found).most_common(1)[0][0]
    keys = [c.key for c in columns]
    rows = [{key: cells[key] for key in keys} for cells in (_cells(f, usual, place) for f in found)]
    common = _number_remarks(rows)
    notes = [note, FAULTS if "as_printed" in keys else ""]
    notes += [f"Inputs, {given} of them, stand in table printed."] if given else []
    notes += [f"Remark {i}: {text}" for i, text in enumerate(common, 1)]
    return Table(name, title, columns, rows, " ".join(sentence for sentence in notes if sentence))


def _columns(found: Sequence[Evidence], digits: int, place: bool) -> tuple[Quantity, ...]:
    form = f"g{digits}"
    faulty, inferred = any(f.as_printed is not None for f in found), any(f.reading is not None for f in found)
    wanted = (
        (True, Quantity("label", "quantity or claim", "", "s")),
        (place, Quantity("place", "place", "", "s")),
        (True, Quantity("verdict", "verdict", "", "s")),
        (True, Quantity("class", "class", "", "s")),
        (True, Quantity("unit", "unit", "", "s")),
        (True, Quantity("printed", "printed", "", "s")),
        (faulty, Quantity("as_printed", "as printed, computed", "", form)),
        (inferred, Quantity("reading", "inferred reading", "", form)),
        (True, Quantity("right", "right (plain reading)" if inferred else "right", "", form)),
        (inferred, Quantity("reading_error", "inferred against printed", "%", ".2f")),
        (True, Quantity("error", "error", "%", "g3")),
        (True, Quantity("remark", "remark", "", "s")),
    )
    return tuple(column for shown, column in wanted if shown)


def _cells(f: Evidence, usual: str, place: bool) -> dict[str, Cell]:
    p = f.printed
    section = p.place.removeprefix("Lin (2019), ")
    where = "" if place or p.place == usual else f" ({section})"
    return {
        "label": (p.claim or p.label) + where,
        "place": section,
        "unit": p.unit,
        "printed": p.printed or "–",
        "as_printed": f.as_printed,
        "reading": f.reading,
        "right": 0.0 if p.value == 0.0 and abs(f.value or 0.0) < ROUND_OFF and f.value is not None else f.value,
        "reading_error": shown_error(f.reading_error_percent),
        "error": shown_error(f.error_percent),
        "class": p.cls,
        "verdict": f.verdict,
        "remark": sentences(f.words, p.remark, p.origin and f"Band: {p.origin}"),
    }


def shown_error(error: float | None) -> float | None:
    """Error [%] for a cell: None where it is infinite (the printed number is zero), zero where it is round-off."""
    if error is None or not np.isfinite(error):
        return None
    return error if abs(error) > ROUND_OFF else 0.0


def _number_remarks(rows: Sequence[dict[str, Cell]]) -> list[str]:
    """Replace remarks that rows share by their number; returns these remarks in order."""
    count = Counter(str(row["remark"]) for row in rows)
    common = [text for text, times in count.items() if text and times > SHARED]
    for row in rows:
        if row["remark"] in common:
            row["remark"] = f"remark {common.index(str(row['remark'])) + 1}"
    return common
