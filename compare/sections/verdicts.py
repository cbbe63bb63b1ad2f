"""Report sections on the numbers and claims that publications print, whether they are reproduced, and on misprints.

The tables that compare printed with computed values are made here for all pages.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare import evidence as compare_evidence
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import KINDS, VERDICT_NAMES, VERDICTS
from rollbench.reports.content import ColumnKey, Row, Section, Table, Text

#: Number of table rows above which a common remark is stated once, in the note below the table, and replaced by its number.
SHARED = 2

#: Note on the tolerance bands.
BANDS = "Tolerance bands: the table of all printed numbers states the origin of each in its column of remarks."

#: Error [%] of a computed value below which it is round-off and shown as zero.
ROUND_OFF = 1e-9

#: Note on the column of values that are computed with the mistakes of the publication.
FAULTS = "Computed with the publication's mistake repeated: empty where no mistake of the publication changes the number."


def printed_numbers_table(
    name: str, title: str, entries: Sequence[compare_evidence.PrintedEntryComparison], *, with_place: bool = False
) -> Table:
    """Return the table of printed numbers and claims, each with computed values, error, class, verdict and remark.

    Values computed with the errors of the publication, or under an inferred assumption, get columns if there are any.

    Parameters
    ----------
    name
        File name of the table in the report.
    title
        Title of the table.
    entries
        Printed and computed values.
    with_place
        Whether all numbers are listed, with a column for their place in the publication. If not, inputs, which test no
        model, are left out, and the place is added to the label only where it differs from that of most numbers.
    """
    given = 0 if with_place else sum(f.verdict == "input" for f in entries)
    entries = [f for f in entries if f.verdict != "input"] if given else entries
    usual = Counter(f.printed.place for f in entries).most_common(1)[0][0]
    rows = [_row_of_printed_number(f, usual, with_place) for f in entries]
    faulty = any(f.as_printed is not None for f in entries)
    inferred = any(f.reading is not None for f in entries)
    wanted: dict[ColumnKey, bool] = {
        "place": with_place,
        "follows_g5": any(f.follows is not None for f in entries),
        ("value_as_printed", "5"): faulty,
        "value_3d": any(f.reference is not None for f in entries),
        ("value_by_inferred", "5"): inferred,
        "reading_error": inferred,
    }
    rows = [{key: cell for key, cell in row.items() if wanted.get(key, True)} for row in rows]
    common = _replace_remarks_by_numbers(rows)
    notes = [FAULTS] if faulty else []
    notes += [f"The {given} inputs are listed in the table printed."] if given else []
    notes += [f"Remark {i}: {text}" for i, text in enumerate(common, 1)]
    return Table.from_rows(name, title, rows, " ".join(notes))


def _row_of_printed_number(evidence: compare_evidence.PrintedEntryComparison, usual_place: str, with_place: bool) -> Row:
    """Return the row of `printed_numbers_table` for one printed number or claim.

    ``evidence``: the printed number with its computed values. ``usual_place``: place in the publication of most numbers; a
    different place is added to the label. ``with_place``: whether the table has a column for the place.
    """
    p = evidence.printed
    section = p.place.removeprefix("Lin (2019), ")
    where = "" if with_place or p.place == usual_place else f" ({section})"
    zero = p.value == 0.0 and abs(evidence.value or 0.0) < ROUND_OFF and evidence.value is not None
    return {
        "entry": (p.claim or p.label) + where,
        "place": section,
        "verdict": VERDICT_NAMES[evidence.verdict],
        "class": p.entry_class,
        "unit": p.unit,
        "printed": p.number_as_printed or "–",
        "follows_g5": evidence.follows,
        ("value_as_printed", "5"): evidence.as_printed,
        "value_correct": 0.0 if zero else evidence.value,
        "value_3d": evidence.reference,
        "error_against_printed": error_for_table_cell(evidence.error_percent),
        ("value_by_inferred", "5"): evidence.reading,
        "reading_error": error_for_table_cell(evidence.reading_error_percent),
        "remark": compare_evidence.join_remarks(
            evidence.remark, p.remark, p.origin_of_limits and f"Tolerance band: {p.origin_of_limits}"
        ),
    }


def error_for_table_cell(error: float | None) -> float | None:
    """Return an error [%] for a table cell: None if it is infinite (printed number of 0), and 0 if it is round-off."""
    if error is None or not np.isfinite(error):
        return None
    return error if abs(error) > ROUND_OFF else 0.0


def _replace_remarks_by_numbers(rows: Sequence[Row]) -> list[str]:
    """Replace remarks that occur in more than `SHARED` table rows by references such as "remark 1", in place.

    ``rows``: cells of each row by key of the column; the cells "remark" are changed. Returns the texts of the replaced
    remarks, in the order of their numbers, for the note below the table.
    """
    count = Counter(str(row["remark"]) for row in rows)
    common = [text for text, times in count.items() if text and times > SHARED]
    number = {text: f"remark {k}" for k, text in enumerate(common, 1)}
    for row in rows:
        row["remark"] = number.get(str(row["remark"]), row["remark"])
    return common


#: Plurals of the kinds of printed entries, for sentences.
PLURALS = {"computed number": "computed numbers", "claim in words": "claims in words"}

#: Inputs that were inferred from printed results of the publications, each with the result.
INFERRED = (
    "the screw's outer diameter of 32 mm (from the groove range of 2.4.2); the helix phase (from the last balls of case "
    "3); u_y of 5.2 and 8.0 um, k_S = 100 and the map step of 0.08 (from Table 3.2); theta and the side force ratio of "
    "the worst case (from 185.2 % in 3.3.4.1); the balls' oversize of 1.7 um (from Table 3.7), used in 3.4.4 too; the "
    "stiffness between two balls of Liu's screw (from the load ratio of 4.1)"
)


def reproduced_number_counts_sentence(entries: Sequence[compare_evidence.PrintedEntryComparison]) -> str:
    """Return the sentences that count the numbers and claims in publications by verdict, and reproduced ones by kind.

    ``entries``: printed numbers and claims with their verdicts.
    """
    total = compare_evidence.count_entries_by_verdict(entries)[-1]
    kinds = Counter(r.printed.kind for r in entries if r.verdict == "reproduced")
    parts = " and ".join(f"{n} {PLURALS.get(KINDS[kind], KINDS[kind])}" for kind, n in kinds.most_common())
    words = ", ".join(f"{total[v]} {VERDICT_NAMES[v]}" for v in VERDICTS)
    return f"Of {total['all']} numbers and claims printed in publications: {words}. Among the reproduced ones are {parts}."


def printed_entry_counts_by_kind_table(entries: Sequence[compare_evidence.PrintedEntryComparison]) -> Table:
    """Return the table that counts the printed numbers and claims by kind and verdict.

    Kinds are computed numbers, claims in words, arithmetic on printed numbers, zeros by symmetry, and inputs. ``entries``:
    printed numbers and claims with their verdicts.
    """
    tally = Counter((r.printed.kind, r.verdict) for r in entries)
    cells: list[Row] = [
        {
            "entry_kind": words,
            **{f"entries_{v}": tally[kind, v] for v in VERDICTS},
            "entries": sum(tally[kind, v] for v in VERDICTS),
        }
        for kind, words in KINDS.items()
    ]
    title = "Count of the numbers and claims printed in publications, by kind and by whether they are reproduced"
    return Table.from_rows("kinds", title, cells, BANDS)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that lists every printed number and claim with its computed value and verdict.

    ``step`` is called with each line of progress.
    """
    step("every printed number and claim")
    audited = compare_evidence.evidence(cache, *sorted(compare_evidence.all_computations()))
    tally = Counter((r.printed.entry_class, r.verdict) for r in audited)
    rows: list[Row] = [{"class": c, "verdict": VERDICT_NAMES[v], "entries": n} for (c, v), n in sorted(tally.items())]
    text = (
        "Some inputs that the publications do not print were inferred from printed results; these results are therefore no "
        f"confirmation: {INFERRED}."
    )
    counts = "Count of the numbers and claims printed in publications, by class and by whether they are reproduced"
    every = "Each number and claim that a publication prints, with the computed value, and whether it is reproduced"
    return Section(
        "verdicts",
        "Numbers and claims that the publications print, and whether they are reproduced",
        (
            Text((text,)),
            Table.from_rows("verdicts", counts, rows),
            printed_entry_counts_by_kind_table(audited),
            printed_numbers_table("printed", every, audited, with_place=True),
        ),
        conclusion=reproduced_number_counts_sentence(audited),
    )


def printed_entry_counts_by_publication_table(entries: Sequence[compare_evidence.PrintedEntryComparison]) -> Table:
    """Return the table that counts the printed numbers and claims by publication and verdict.

    ``entries``: printed numbers and claims with their verdicts.
    """
    rows = [
        {"publication": counts["source"]}
        | {f"entries_{v}": counts[v] for v in VERDICTS}
        | {"entries_judged": counts["judged"], "entries": counts["all"]}
        for counts in compare_evidence.count_entries_by_verdict(entries)
    ]
    identities = "identities (arithmetic on printed numbers, or zero by symmetry or definition)"
    note = f"Inputs, and {identities}, test no model. {BANDS}"
    title = "Count of the numbers and claims printed in each publication, by whether they are reproduced"
    return Table.from_rows("audit-counts", title, rows, note)


def misprints_table(case_name: str = "") -> Table:
    """Return the table of misprints and errors in one publication or in all publications.

    ``case_name``: short name of the publication, such as "lin"; empty: all publications.
    """
    columns = {"place": "place", "misprint": "wrong", "correction": "right", "misprint_shown_by": "evidence"}
    columns |= {"command_to_show": "command", "misprint_test": "test"}
    rows = [
        ({} if case_name else {"publication": row["source"]}) | {c: row[key] for c, key in columns.items()}
        for row in compare_evidence.misprint_rows()
        if row["source"] == case_name or not case_name
    ]
    title = "Misprints in the publications, each with a command that shows it and a test that checks it"
    return Table.from_rows(f"{case_name or 'audit'}-misprints", title, rows)


def misprints_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section that counts reproduced and contradicted numbers of each publication, and lists all misprints.

    ``step`` is called with each line of progress.
    """
    step("every printed number and claim, by publication")
    rows = compare_evidence.evidence(cache, *sorted(compare_evidence.all_computations()))
    words = [compare_evidence.reproduction_sentence(row) for row in compare_evidence.count_entries_by_verdict(rows)]
    meanings = [f"{VERDICT_NAMES[verdict]}: {text}." for verdict, text in VERDICTS.items()]
    missing = [
        {"publication": row["source"], "place": row["place"], "quantities_left_out": row["what"]}
        | {"values_not_compared": row["count"], "why_not_compared": row["reason"]}
        for row in compare_evidence.uncompared_number_rows()
    ]
    title = "Printed numbers that are not compared with computed ones, with the reason"
    items = (
        Text(words),
        printed_entry_counts_by_publication_table(rows),
        Text(meanings, bullets=True),
        misprints_table(),
        Table.from_rows("audit-left-out", title, missing),
    )
    return Section("audit", "Misprints and contradictions found in each publication", items)
