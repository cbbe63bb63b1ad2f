"""Sections on every printed entry with its verdict, and on how reliable each source is.

Tables of printed numbers and claims with their computed values are made here for all pages.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare.evidence import APART, Evidence, audit, counts, joined_remarks, misprints, numbers_left_out, trust
from rollbench.compare.evidence import counts as audited_counts
from rollbench.compare.models.study import Study
from rollbench.compare.printed import KINDS, VERDICTS
from rollbench.reports.content import Cell, Quantity, Row, Section, Table, Text

#: Remarks that more rows than this share are numbered and given once, in the note.
SHARED = 2

#: Error [%] below which it is round-off and shown as zero.
ROUND_OFF = 1e-9

FAULTS = "As printed: computed with the source's faults repeated; empty where no fault changes the number."


def printed_table(
    name: str, title: str, found: Sequence[Evidence], note: str = "", *, digits: int = 5, place: bool = False
) -> Table:
    """Return the table of printed entries, each with computed values, error, class, verdict and remark.

    Values with the source's faults, and values under an inferred assumption, have columns if an entry has any.

    Parameters
    ----------
    name
        Name of the table.
    title
        Title of the table.
    found
        The entries.
    note
        Note below the table.
    digits
        Significant digits.
    place
        Whether every entry is listed, with a column of places; else inputs, which test no model, are left out, and an entry
        from another place than most says so in its label.
    """
    given = 0 if place else sum(f.verdict == "input" for f in found)
    found = [f for f in found if f.verdict != "input"] if given else found
    columns = _verdict_columns(found, digits, place)
    usual = Counter(f.printed.place for f in found).most_common(1)[0][0]
    keys = [c.key for c in columns]
    rows = [{key: cells[key] for key in keys} for cells in (_verdict_cells(f, usual, place) for f in found)]
    common = _number_remarks(rows)
    notes = [note, FAULTS if "as_printed" in keys else ""]
    notes += [f"Inputs, {given} of them, stand in table printed."] if given else []
    notes += [f"Remark {i}: {text}" for i, text in enumerate(common, 1)]
    return Table(name, title, columns, rows, " ".join(sentence for sentence in notes if sentence))


def _verdict_columns(found: Sequence[Evidence], digits: int, place: bool) -> tuple[Quantity, ...]:
    """Return the columns of `printed_table` that its entries need."""
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
        (True, Quantity("right", "right (plain reading)" if inferred else "right", "", form)),
        (True, Quantity("error", "error", "%", "g3")),
        (inferred, Quantity("reading", "inferred reading", "", form)),
        (inferred, Quantity("reading_error", "inferred against printed", "%", ".2f")),
        (True, Quantity("remark", "remark", "", "s")),
    )
    return tuple(column for shown, column in wanted if shown)


def _verdict_cells(f: Evidence, usual: str, place: bool) -> dict[str, Cell]:
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
        "remark": joined_remarks(f.words, p.remark, p.origin and f"Band: {p.origin}"),
    }


def shown_error(error: float | None) -> float | None:
    """Return an error [%] for a cell: None if infinite (the printed number is zero), zero if it is round-off."""
    if error is None or not np.isfinite(error):
        return None
    return error if abs(error) > ROUND_OFF else 0.0


def _number_remarks(rows: Sequence[dict[str, Cell]]) -> list[str]:
    """Replace remarks that several rows share by references to a numbered list; return the list."""
    count = Counter(str(row["remark"]) for row in rows)
    common = [text for text, times in count.items() if text and times > SHARED]
    for row in rows:
        if row["remark"] in common:
            row["remark"] = f"remark {common.index(str(row['remark'])) + 1}"
    return common


PLURALS = {"computed number": "computed numbers", "claim in words": "claims in words"}

#: What was inferred from printed results, and from which.
INFERRED = (
    "the screw's outer diameter of 32 mm (from the groove range of 2.4.2); the helix phase (from the last balls of case "
    "3); u_y of 5.2 and 8.0 um, k_S = 100 and the map step of 0.08 (from Table 3.2); theta and the side force ratio of "
    "the worst case (from 185.2 % in 3.3.4.1); the balls' oversize of 1.7 um (from Table 3.7), used in 3.4.4 too"
)


def total_text(rows: Sequence[Evidence]) -> str:
    """Return a sentence with the number of entries by verdict, and the kinds of those that are reproduced."""
    total = audited_counts(rows)[-1]
    kinds = Counter(r.printed.kind for r in rows if r.verdict == "reproduced")
    parts = " and ".join(f"{n} {PLURALS.get(KINDS[kind], KINDS[kind])}" for kind, n in kinds.most_common())
    words = ", ".join(f"{total[v]} {v}" for v in VERDICTS)
    return f"Of {total['all']} printed entries: {words}. Those reproduced are {parts}."


def kinds_table(rows: Sequence[Evidence]) -> Table:
    """Return the table of the number of entries by kind and verdict."""
    tally = Counter((r.printed.kind, r.verdict) for r in rows)
    cells: list[Row] = [
        {
            "kind": words,
            **{str(v): tally[kind, v] for v in VERDICTS},
            Quantity("all", "entries", "", "s"): sum(tally[kind, v] for v in VERDICTS),
        }
        for kind, words in KINDS.items()
    ]
    return Table.of("kinds", "Printed entries by kind and verdict", cells)


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section of the report."""
    step("every printed number and claim")
    audited = audit(study)
    tally: dict[tuple[str, str], int] = Counter((r.printed.cls, r.verdict) for r in audited)
    rows: list[Row] = [
        {"class": c, "verdict": v, Quantity("count", "entries", "", "s"): n} for (c, v), n in sorted(tally.items())
    ]
    return Section(
        "verdicts",
        "Numbers and claims that the publications print, and whether they are reproduced",
        (
            Text(
                (
                    (
                        "What a scene needs and the source does not print was inferred from printed results, "
                        f"and therefore confirms none of them: {INFERRED}."
                    ),
                )
            ),
            Table.of("verdicts", "Printed entries of all sources by class and verdict of the audit", rows),
            kinds_table(audited),
            printed_table(
                "printed",
                "Each number and claim that a publication prints, with the computed value and the verdict",
                audited,
                place=True,
            ),
        ),
        conclusion=total_text(audited),
    )


def _verdict_texts(*columns: tuple[str, str]) -> tuple[Quantity, ...]:
    return tuple(Quantity(key, label, "", "s") for key, label in columns)


def counts_table(rows: Sequence[Evidence]) -> Table:
    """Return the table of the number of entries by source and verdict."""
    headings = [(v, f"{v}, apart" if v in APART else v) for v in VERDICTS]
    columns = _verdict_texts(("source", "source"), *headings, ("judged", "judged"), ("all", "all"))
    note = "Judged: without inputs and identities, which say nothing of a model."
    return Table("audit-counts", "Printed entries by source and verdict", columns, counts(rows), note)


def misprints_table(case: str = "") -> Table:
    """Return the table of misprints and faults, of one case or of all sources."""
    columns = _verdict_texts(
        *(() if case else (("source", "source"),)),
        ("place", "place"),
        ("wrong", "as printed"),
        ("right", "right"),
        ("evidence", "evidence"),
        ("command", "command that shows it"),
        ("test", "test"),
    )
    rows = [row for row in misprints() if row["source"] == case or not case]
    return Table(
        f"{case or 'audit'}-misprints",
        "Misprints in the publications, each with a command that shows it and a test that checks it",
        columns,
        rows,
    )


def audit_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section that audits every printed entry, by source."""
    step("every printed entry")
    rows = audit(study)
    words = [trust(row) for row in counts(rows)]
    meanings = [f"{verdict}: {text}." for verdict, text in VERDICTS.items()]
    missing = _verdict_texts(
        ("source", "source"), ("place", "place"), ("what", "what"), ("count", "numbers, about"), ("reason", "why left out")
    )
    items = (
        Text(words),
        counts_table(rows),
        Text(meanings, bullets=True),
        misprints_table(),
        Table("audit-left-out", "Printed numbers that are no entries, and why", missing, numbers_left_out()),
    )
    return Section("audit", "Misprints and contradictions found in each publication", items)
