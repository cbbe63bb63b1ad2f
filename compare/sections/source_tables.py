"""Report tables in the layout of a publication's own tables, with the computed value next to each printed number.

The file ``layout.toml`` of a publication describes each printed table: number, title, columns, and rows with a label and a
key for each column. A table of results is shown twice: in the printed layout, and with a row for each number.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from rollbench.compare.case import CASES, Case
from rollbench.compare.errors import InputError
from rollbench.compare.evidence import (
    PrintedEntryComparison,
    all_computations,
    count_entries_by_verdict,
    join_remarks,
    publication_title_of,
    reproduction_sentence,
)
from rollbench.compare.measure import error_percent
from rollbench.compare.printed import VERDICT_NAMES, load_printed_table, printed_entry
from rollbench.compare.sections.verdicts import error_for_table_cell, misprints_table
from rollbench.reports.content import Figure, Row, Section, Table, TableColumn, Text

#: Further cells of table rows, by name of the row's printed number ("table:key").
More = Mapping[str, Row]


@dataclass(frozen=True)
class PrintedLayout:
    """Layout of one table of a publication: title, columns, and the name of the printed number in each cell."""

    #: Short name of the publication, such as "lin".
    case: str
    #: Number of the table in the publication.
    number: str
    #: Short description of the printed table's contents, such as "inputs of the rotary bearing".
    short: str
    #: Title of the table in the report.
    title: str
    #: Name of the file of printed numbers that has most numbers of this table.
    printed: str
    #: Kind of the numbers: ``"inputs"``, ``"results"``, or ``"sentences"`` for those in the publication's text.
    kind: str
    #: Headings of the columns, as printed.
    columns: tuple[str, ...]
    #: Rows: printed label, and for each column the name of a printed number ("table:key"; empty for an empty cell).
    rows: tuple[tuple[str, tuple[str, ...]], ...]

    @property
    def names(self) -> list[str]:
        """Names ("table:key") of the printed numbers in the table, row by row, without empty cells."""
        return [name for _, names in self.rows for name in names if name]

    def stem(self, what: str = "") -> str:
        """Return the file name, without ending, that this table has in the report.

        ``what``: text such as "compared" that is appended to the name.
        """
        return "-".join(filter(None, (self.case, self.number, what)))

    @property
    def heading(self) -> str:
        """Heading of the table in the report: its number in the publication and a short description."""
        return self.short if self.kind == "sentences" or self.number[:1].islower() else f"Table {self.number}: {self.short}"

    @property
    def significant_digits(self) -> int:
        """Largest number of significant digits of a printed number in the table, but at least five."""
        texts = (printed_entry(*name.split(":")).number_as_printed.partition("e")[0] for name in self.names)
        return max(5, *(len(text.replace(".", "").lstrip("-0")) for text in texts))


def read_table_layouts(case: Case) -> list[PrintedLayout]:
    """Read the layouts of the printed tables of a publication, in the order of its file ``layout.toml``.

    ``case``: the publication. Raises InputError if a layout names a printed number that does not exist.
    """
    path = case.folder / "layout.toml"
    return [_layout_from_record(case.name, str(path), one) for one in tomllib.loads(path.read_text("utf-8"))["table"]]


def _layout_from_record(case: str, path: str, record: Mapping[str, Any]) -> PrintedLayout:
    """Return the layout of one printed table, made of its record in the file ``layout.toml``.

    ``case``: short name of the publication. ``path``: path of the file, for error messages. ``record``: the record. Raises
    InputError if the record names a printed number that does not exist.
    """
    rows = []
    for label, *keys in record["rows"]:
        names = tuple(key if ":" in key or not key else f"{record['printed']}:{key}" for key in keys)
        for name in filter(None, names):
            try:
                printed_entry(*name.split(":"))
            except KeyError as error:
                advice = "correct this key in the file of table layouts"
                allowed = "the key of a number that is stored from a table of the publication"
                raise InputError(path, record["number"], name, allowed, advice) from error
        rows.append((label, names))
    texts = {key: record[key] for key in ("number", "short", "title", "printed", "kind")}
    return PrintedLayout(case, **texts, columns=tuple(record["columns"]), rows=tuple(rows))


def format_like_printed_number(value: float | None, printed: str) -> str:
    """Return a computed value as text with as many decimals as the text ``printed`` of a printed number; a dash for None.

    Examples
    --------
    >>> [format_like_printed_number(*x) for x in ((1.81234e-7, "1.812e-7"), (2.3456, "2.30"), (None, "1"))]
    ['1.812e-7', '2.35', '–']
    """
    if value is None:
        return "–"
    if "e" in printed:
        mantissa = printed.partition("e")[0]
        digits, _, power = f"{value:.{len(mantissa.partition('.')[2])}e}".partition("e")
        return f"{digits}e{int(power)}"
    text = f"{value:.{max(0, -int(Decimal(printed).as_tuple().exponent))}f}"
    return text.removeprefix("-") if not float(text) else text


#: Ends of the column headings of `printed_and_computed_table_in_layout`.
IN_LAYOUT = {
    "printed": "printed",
    "follows": "follows from other printed numbers",
    "ours": "computed here",
    "repeated": "computed here, with the publication's mistake repeated",
    "right": "computed here, without the publication's mistake",
}


def printed_and_computed_table_in_layout(
    layout: PrintedLayout, evidence_by_name: Mapping[str, PrintedEntryComparison], replacing_texts: Mapping[str, str]
) -> Table:
    """Return a table in the publication's layout, with the computed value next to each printed number.

    The computed value has as many decimals as the printed number. If the computed value repeats an error of the
    publication, the correct value is added.

    Parameters
    ----------
    layout
        Layout of the table.
    evidence_by_name
        Printed and computed values, by name of the printed number.
    replacing_texts
        Texts that replace computed values, such as measured run times, by name of the printed number.
    """
    rows: list[Row] = []
    across_names = [names for _, names in layout.rows]
    has_labels, columns = any(label for label, _ in layout.rows), list(zip(*across_names, strict=True))
    across, down = ([_printed_units(names, evidence_by_name) for names in by] for by in (across_names, columns))
    of_row, of_column = (all(len(several) == 1 for several in by) for by in (across, down))  # else a unit with each number
    filled = [[evidence_by_name[name] for name in names if name] for names in columns]
    shown = {
        "right": [any(f.as_printed is not None for f in fs) for fs in filled],
        "follows": [any(f.follows is not None for f in fs) for fs in filled],
    }
    for (label, names), several in zip(layout.rows, across, strict=True):
        row: Row = {"printed_row": label} if has_labels else {}
        if of_row and any("".join(units) for units in across):
            row["unit"] = next(iter(several))
        for k, (head, name) in enumerate(zip(layout.columns, names, strict=True)):
            heading = next(iter(down[k])) if of_column and not of_row else ""
            unit = "" if of_row or of_column or not name else evidence_by_name[name].printed.unit
            texts = {"printed": "", "follows": "", "ours": "", "right": ""}
            if name:
                f, p = evidence_by_name[name], evidence_by_name[name].printed
                texts["printed"], texts["ours"] = p.number_as_printed or p.claim, computed_value_text(f)
                if f.follows is not None:
                    texts["follows"] = format_like_printed_number(f.follows, p.number_as_printed)
                if f.as_printed is not None and f.value is not None:
                    texts["right"] = format_like_printed_number(f.value, p.number_as_printed)
                texts = {key: f"{text} {unit}".rstrip() if text not in ("", "–") else text for key, text in texts.items()}
                texts["ours"] = replacing_texts.get(name, texts["ours"])
            for key, text in texts.items():
                if key not in shown or shown[key][k]:
                    ending = IN_LAYOUT["repeated" if key == "ours" and shown["right"][k] else key]
                    row[TableColumn(f"{key}-{k}", f"{head}, {ending}", heading, "s")] = text
        rows.append(row)
    note = (
        "Computed here: by the low-order model. Where a mistake of the publication changes numbers of a column, two "
        "columns show the value with this mistake repeated, and the correct value."
    )
    if any(shown["follows"]):
        note += " What follows from other printed numbers, such as a sum, tests no model; dash: no model gives it."
    if any(f.reference is not None for f in map(evidence_by_name.__getitem__, layout.names)):
        note += " Beside numbers by ANSYS, the value computed here is that of the 3D reference."
    return Table.from_rows(layout.stem(), layout.title, rows, note, unfolded=True)


def _printed_units(names: Iterable[str], evidence_by_name: Mapping[str, PrintedEntryComparison]) -> set[str]:
    """Return the units of the printed numbers called ``names``, each once; claims in words are left out.

    ``evidence_by_name``: printed and computed values, by name of the printed number.
    """
    return {evidence_by_name[name].printed.unit for name in names if name and not evidence_by_name[name].printed.claim}


def computed_value_text(evidence: PrintedEntryComparison) -> str:
    """Return the computed value of a printed number as text, with as many decimals as the printed one.

    ``evidence``: the printed number with its computed values. The text shows the value computed with the publication's
    mistake repeated; if there is none, the correct value; if there is none either, the value by the 3D reference. For a
    claim in words the text states whether the claim holds.
    """
    if evidence.printed.claim:
        return "–" if evidence.claim_is_true is None else "holds" if evidence.claim_is_true else "does not hold"
    values = (evidence.as_printed, evidence.value, evidence.reference)
    return format_like_printed_number(next((v for v in values if v is not None), None), evidence.printed.number_as_printed)


def printed_and_computed_table(
    layout: PrintedLayout,
    evidence_by_name: Mapping[str, PrintedEntryComparison],
    further_cells: More,
    reasons_without_3d_value: Mapping[str, str],
    names_without_row: Sequence[str] = (),
    note: str = "",
) -> Table:
    """Return the table that compares each number of a printed table with the computed values, with a row per number.

    Rows are in printed order; columns without values are left out.

    Parameters
    ----------
    layout
        Layout of the printed table.
    evidence_by_name
        Printed and computed values, by name of the printed number.
    further_cells
        Further cells that are added to the rows, by name of the printed number.
    reasons_without_3d_value
        Reason why no value by the 3D reference is shown, by name of the printed number.
    names_without_row
        Names of printed numbers that ``further_cells`` shows in cells of other rows; they get no row of their own.
    note
        Note below the table.
    """
    further = dict.fromkeys(q for cells in further_cells.values() for q in cells)
    rows: list[Row] = []
    remarks: dict[str, int] = {}
    for label, names in layout.rows:
        for head, name in zip(layout.columns, names, strict=True):
            if name and name not in names_without_row and evidence_by_name[name].printed.entry_class != "input":
                f = evidence_by_name[name]
                base = _printed_and_computed_row(layout, f, reasons_without_3d_value.get(name, ""))
                row = base | {q: None for q in further if q not in base} | further_cells.get(name, {})
                p = f.printed
                band = "" if None in (p.low, p.high) else f"Tolerance band: {p.low:g} to {p.high:g}. {p.origin_of_limits}"
                reason = join_remarks(f.reason, band)
                remark = remarks.setdefault(reason, len(remarks) + 1) if reason else None
                first: Row = {"printed_quantity": label or f.printed.label}
                first["printed_column"] = "" if head == "Value" or not label else head
                last: Row = {"verdict": VERDICT_NAMES[f.verdict], "how": f"how-{f.printed.table}"}
                rows.append(first | row | last | {"remark": remark})
    notes = [note, *(f"{number}: {text}" for text, number in remarks.items())]
    title = f"{layout.heading}: printed and computed value of every number"
    text = "\n".join(filter(None, notes))
    return Table.from_rows(layout.stem("compared"), title, _drop_empty_columns(rows), text, unfolded=True)


def _printed_and_computed_row(layout: PrintedLayout, evidence: PrintedEntryComparison, reason_without_3d_value: str) -> Row:
    """Return the row of one printed number: printed value, computed values, and errors of the computed values [%].

    ``layout``: layout of the printed table, which sets the number of digits. ``evidence``: the printed number with its
    computed values; their errors are against the printed value, one also against the 3D value. ``reason_without_3d_value``:
    text that is shown if there is no value by the 3D reference.
    """
    p, digits = evidence.printed, str(layout.significant_digits)
    identity = evidence.follows is not None
    value, as_printed, solid = evidence.value, evidence.as_printed, _zero_if_round_off(evidence.reference)
    by_inferred = evidence.reading
    return {
        "printed": f"{p.number_as_printed or p.claim} {p.unit}".rstrip(),
        "follows": f"{evidence.follows:.{digits}g}" if identity else "",
        ("value_low_order", digits): _zero_if_round_off(value),
        ("value_as_printed", digits): _zero_if_round_off(as_printed),
        ("value_by_inferred", digits): by_inferred,
        "value_3d_text": reason_without_3d_value if solid is None else f"{solid:.{digits}g}",
        "off_printed": _percent_error_or_none(value, p.value),
        "off_faulty": _percent_error_or_none(as_printed, p.value),
        "off_reading": _percent_error_or_none(by_inferred, p.value),
        "off_solid": _percent_error_or_none(evidence.reference, p.value),
        "off_reference": _percent_error_or_none(value, evidence.reference),
    }


def _percent_error_or_none(value: float | None, reference: float | None) -> float | None:
    """Return the error of a value against a reference [%]; None if one is None, or if both are zero up to round-off."""
    if value is None or reference is None or max(abs(value), abs(reference)) < 1e-9:
        return None
    return error_for_table_cell(float(error_percent(value, reference)))


def _zero_if_round_off(value: float | None) -> float | None:
    """Return zero for a value below 1e-9, which is round-off, and any other value unchanged."""
    return 0.0 if value is not None and abs(value) < 1e-9 else value


def _drop_empty_columns(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a table without the columns in which every cell is empty."""
    filled = {q for row in rows for q, value in row.items() if value not in (None, "")}
    order = dict.fromkeys(q for row in rows for q in row)
    return [{q: row.get(q) for q in order if q in filled} for row in rows]


def printed_input_table(layout: PrintedLayout, evidence_by_name: Mapping[str, PrintedEntryComparison]) -> Table:
    """Return the table of the inputs in a printed table: printed value, value used in the scene, remark.

    Parameters
    ----------
    layout
        Layout of the printed table.
    evidence_by_name
        Printed values and values used in the scene, by name of the printed number.
    """
    rows: list[Row] = [
        {
            "parameter": label,
            "printed": f.printed.number_as_printed,
            "unit": f.printed.unit,
            "value_used": format_like_printed_number(f.value, f.printed.number_as_printed),
            "parameter_scenes": ", ".join(all_computations()[f.printed.table].scenes_or_reason(f.printed)[0]),
            "verdict": VERDICT_NAMES[f.verdict],
            "how": f"how-{f.printed.table}",
            "remark": f.reason,
        }
        for label, (name,) in layout.rows
        for f in (evidence_by_name[name],)
    ]
    return Table.from_rows(layout.stem(), layout.title, rows, unfolded=True)


def tables_on_computation_of_numbers(file_names: Iterable[str]) -> Iterator[Table]:
    """Yield, for each file of printed numbers, a table that states how the numbers are computed.

    Each table names the scenes, the function, the test and the command. ``file_names``: names of the files.
    """
    for name in file_names:
        one = all_computations()[name]
        places = ", ".join(
            sorted({row.place.partition(", ")[2] for row in load_printed_table(name)}, key=_sort_key_of_place)
        )
        rows: list[Row] = [
            {
                "entry_keys": pattern,
                "scenes_solved": behind if isinstance(behind, str) else ", ".join(behind),
                "function": one.function_name,
                "test_file": one.test_file or "–",
                "command_to_compute": f"rollbench check --printed --only {name}",
            }
            for pattern, behind in one.scenes_or_reason_by_key_pattern
        ]
        yield Table.from_rows(f"how-{name}", f"How the printed numbers of the file {name} are computed ({places})", rows)


def _sort_key_of_place(place: str) -> tuple[bool, list[int], str]:
    """Return the key by which places in a publication, such as "Table 2.1", are sorted.

    They are sorted by chapter, tables before sections; appendices come last.
    """
    in_text, text = "Table" not in place, place.rpartition(", ")[2]
    letter = re.match(r"\D*\b([A-Z])\b", text)
    numbers = [ord(letter[1])] if letter else [int(n) for n in re.findall(r"\d+", text)]
    return letter is not None, [*numbers[:1], int(in_text), *numbers[1:]], text


def counts_of_reproduced_numbers_table(entries: Sequence[PrintedEntryComparison], name: str = "printed-by-table") -> Table:
    """Return the table that counts the printed and the reproduced numbers of each table and section of publications.

    Parameters
    ----------
    entries
        Printed and computed values.
    name
        File name of the table in the report.
    """
    groups: dict[str, list[PrintedEntryComparison]] = {}
    for f in entries:
        groups.setdefault(publication_title_of(f.printed), []).append(f)
    rows = []
    for title, of_source in groups.items():
        rows.append(_reproduced_counts_row(f"{title}, all", of_source))
        places: dict[str, list[PrintedEntryComparison]] = {}
        for f in of_source:
            places.setdefault(f.printed.place, []).append(f)
        rows += [_reproduced_counts_row(place, places[place]) for place in sorted(places, key=_sort_key_of_place)]
    note = (
        "A result is a printed number that is neither an input nor an identity (follows from other printed numbers, or "
        "is zero by symmetry or definition); only results can be reproduced. The table printed shows every number."
    )
    title = "Number of printed values in each table and section of the publications, and how many are reproduced"
    return Table.from_rows(name, title, rows, note)


def _reproduced_counts_row(place: str, entries: Sequence[PrintedEntryComparison]) -> Row:
    """Return the row of `counts_of_reproduced_numbers_table` for one table or section of a publication.

    ``place``: text in the first cell. ``entries``: printed numbers and claims of the table or section, with their verdicts.
    """
    numbers = [f for f in entries if not f.printed.claim]
    claims = [f for f in entries if f.printed.claim]
    tally = Counter(f.verdict for f in numbers)
    borne = sum(f.verdict in ("reproduced", "band") for f in claims)
    return {
        "publication_place": place,
        "printed_values": len(numbers),
        "printed_inputs": tally["input"],
        "printed_identities": tally["identity"],
        "printed_results": len(numbers) - tally["input"] - tally["identity"],
        "results_reproduced": tally["reproduced"],
        "results_as_printed": tally["only as printed"],
        "results_in_band": tally["band"],
        "results_contradicted": tally["contradicted"],
        "results_not_determined": tally["not identifiable"],
        "claims_confirmed": f"{borne} of {len(claims)}" if claims else "",
    }


def tables_of_printed_numbers(
    number_files: Sequence[str], layouts: Sequence[PrintedLayout], evidence_by_name: Mapping[str, PrintedEntryComparison]
) -> Iterator[Table]:
    """Yield the report's tables on those numbers of a publication that are in certain files of printed numbers.

    Each table of the publication with a layout is yielded in this layout and with a row per number; then follow the numbers
    and claims of the publication's text.

    Parameters
    ----------
    number_files
        Names of the files of printed numbers.
    layouts
        Layouts of the publication's printed tables.
    evidence_by_name
        Printed and computed values, by name of the printed number.
    """
    for layout in layouts:
        if layout.printed in number_files:
            yield printed_and_computed_table_in_layout(layout, evidence_by_name, {})
            if any(evidence_by_name[name].printed.entry_class != "input" for name in layout.names):
                yield replace(printed_and_computed_table(layout, evidence_by_name, {}, {}), unfolded=False)
    laid = {name for layout in layouts for name in layout.names}
    rest = [f.printed for f in evidence_by_name.values() if f.printed.table in number_files and f.printed.name not in laid]
    for what in ("inputs", "numbers and claims"):
        of = [p for p in rest if (p.entry_class == "input") == (what == "inputs")]
        rows = tuple((f"{p.label} ({p.place.partition(', ')[2]})", (p.name,)) for p in of)
        if rows:
            title = f"{what[:1].upper()}{what[1:]} of the text"
            layout = PrintedLayout(number_files[-1], "text", title, title, number_files[-1], "sentences", ("Value",), rows)
            yield (
                printed_input_table(layout, evidence_by_name)
                if what == "inputs"
                else printed_and_computed_table(layout, evidence_by_name, {}, {})
            )


def publication_sections(
    case_name: str,
    label: str,
    title: str,
    about: Sequence[str],
    chapters: Mapping[str, tuple[str, Sequence[str]]],
    found: Sequence[PrintedEntryComparison],
    drawn: Mapping[str, Sequence[Table | Figure]],
    *others: Section,
) -> tuple[Section, ...]:
    """Return the report's sections on a publication: how far it is reproduced, its chapters, its misprints.

    Parameters
    ----------
    case_name
        Name of the publication's case.
    label
        Name of the publication in titles, such as "Smith (1994)".
    title
        Title of the first section.
    about
        Paragraphs of the first section.
    chapters
        Title and names of the files of printed numbers, by name of the section.
    found
        Printed and computed values of all chapters.
    drawn
        Further tables and figures, by name of the section.
    *others
        Further sections, before that on misprints.
    """
    by_name = {f.printed.name: f for f in found}
    layouts = read_table_layouts(next(case for case in CASES if case.name == case_name))
    tables = {name: tables_of_printed_numbers(files, layouts, by_name) for name, (_, files) in chapters.items()}
    conclusion = reproduction_sentence(count_entries_by_verdict(found)[0])
    audited = tables_on_computation_of_numbers(name for _, files in chapters.values() for name in files)
    return (
        Section(case_name, title, (Text(about, bullets=True),), conclusion=conclusion),
        *(Section(name, words, (*tables[name], *drawn.get(name, ()))) for name, (words, _) in chapters.items()),
        *others,
        Section(
            f"{case_name}-audit",
            f"{label}: misprints, and how each of the printed numbers is recomputed",
            (misprints_table(case_name), *audited),
        ),
    )
