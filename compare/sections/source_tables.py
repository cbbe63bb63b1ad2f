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

from rollbench.compare.case import Case
from rollbench.compare.errors import InputError
from rollbench.compare.evidence import Evidence, all_computations, join_remarks, publication_title_of
from rollbench.compare.measure import error_percent
from rollbench.compare.printed import Printed, load_table, printed_entry
from rollbench.compare.sections.verdicts import finite_error_or_none
from rollbench.reports.content import Quantity, Row, Table

#: Further cells of table rows, by name of the row's printed number ("table:key").
More = Mapping[str, Row]


@dataclass(frozen=True)
class PrintedLayout:
    """Layout of one table of a publication: title, columns, and the name of the printed number in each cell."""

    #: Name of the publication's case, such as "lin".
    case: str
    #: Number of the table in the publication.
    number: str
    #: Short description of the table's contents.
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

    @property
    def across(self) -> list[tuple[str, ...]]:
        """Names of the printed numbers of each row, in the order of the columns; an empty text for an empty cell."""
        return [names for _, names in self.rows]

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
        """Number of significant digits of the printed number with most digits, but at least five."""
        texts = (printed_entry(*name.split(":")).printed.partition("e")[0] for name in self.names)
        return max(5, *(len(text.replace(".", "").lstrip("-0")) for text in texts))


def read_layouts(case: Case) -> list[PrintedLayout]:
    """Read the layouts of the printed tables of a publication, in the order of its file ``layout.toml``.

    ``case``: the publication. Raises InputError if a layout names a printed number that does not exist.
    """
    path = case.folder / "layout.toml"
    return [_layout_from_record(case.name, str(path), one) for one in tomllib.loads(path.read_text("utf-8"))["table"]]


def _layout_from_record(case: str, path: str, one: Mapping[str, Any]) -> PrintedLayout:
    """Return the layout of one printed table, made of its record in the file ``layout.toml``.

    ``case``: name of the publication's case. ``path``: path of the file, for error messages. ``one``: the record. Raises
    InputError if the record names a printed number that does not exist.
    """
    rows = []
    for label, *keys in one["rows"]:
        names = tuple(key if ":" in key or not key else f"{one['printed']}:{key}" for key in keys)
        for name in filter(None, names):
            try:
                printed_entry(*name.split(":"))
            except KeyError as error:
                advice = "correct this key in the file of table layouts"
                raise InputError(path, one["number"], name, "the key of an existing printed number", advice) from error
        rows.append((label, names))
    texts = {key: one[key] for key in ("number", "short", "title", "printed", "kind")}
    return PrintedLayout(case, **texts, columns=tuple(one["columns"]), rows=tuple(rows))


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


def side_by_side_table_of_layout(layout: PrintedLayout, found: Mapping[str, Evidence], ours: Mapping[str, str]) -> Table:
    """Return a table in the publication's layout, with the computed value next to each printed number.

    The computed value has as many decimals as the printed number. If it repeats an error of the publication, the correct
    value is added.

    Parameters
    ----------
    layout
        Layout of the table.
    found
        Printed and computed values, by name of the printed number.
    ours
        Texts that replace computed values, such as measured run times, by name of the printed number.
    """
    rows: list[Row] = []
    across, down = (
        [_printed_units(names, found) for names in by] for by in (layout.across, zip(*layout.across, strict=True))
    )
    of_row, of_column = (all(len(several) == 1 for several in by) for by in (across, down))  # else a unit with each number
    faulty = [
        any(name and found[name].as_printed is not None for name in names) for names in zip(*layout.across, strict=True)
    ]
    for (label, names), several in zip(layout.rows, across, strict=True):
        row: Row = {Quantity("label", "", "", "s"): label} if any(label for label, _ in layout.rows) else {}
        if of_row and any("".join(units) for units in across):
            row[Quantity("unit", "unit", "", "s")] = next(iter(several))
        for k, (head, name) in enumerate(zip(layout.columns, names, strict=True)):
            heading = next(iter(down[k])) if of_column and not of_row else ""
            unit = "" if of_row or of_column or not name else found[name].printed.unit
            texts = {"printed": "", "ours": "", "right": ""}
            if name:
                p, right = found[name].printed, found[name].value if found[name].as_printed is not None else None
                texts = {"printed": p.printed or p.claim, "ours": ours.get(name, computed_value_text(found[name]))}
                texts = {
                    key: text if key == "ours" and name in ours else f"{text} {unit}".rstrip()
                    for key, text in texts.items()
                }
                texts["right"] = "" if right is None else f"{format_like_printed_number(right, p.printed)} {unit}".rstrip()
            for key, text in texts.items():
                if key != "right" or faulty[k]:
                    row[Quantity(f"{key}-{k}", f"{head}, {key}", heading, "s")] = text
        rows.append(row)
    note = (
        "Ours: computed by the low-order model. Where an error of the publication changes the number, the error is "
        "repeated and the correct value is shown as well."
    )
    if any(f.reference is not None for f in map(found.__getitem__, layout.names)):
        note += " Numbers by ANSYS are compared with the 3D reference."
    return Table.of(layout.stem(), layout.title, rows, note, unfolded=True)


def _printed_units(names: Iterable[str], found: Mapping[str, Evidence]) -> set[str]:
    """Return the set of units of several printed numbers, given by their names; claims in words are left out.

    ``found``: printed and computed values, by name of the printed number.
    """
    return {found[name].printed.unit for name in names if name and not found[name].printed.claim}


def computed_value_text(evidence: Evidence) -> str:
    """Return the computed value of a printed number as text, with as many decimals as the printed one.

    ``evidence``: the printed number with its computed values. The text shows the first of these values that exists:
    computed with the error of the publication repeated, correct, by the 3D reference. For a claim in words the text states
    whether it holds.
    """
    if evidence.printed.claim:
        return "–" if evidence.holds is None else "holds" if evidence.holds else "does not hold"
    values = (evidence.as_printed, evidence.value, evidence.reference)
    return format_like_printed_number(next((v for v in values if v is not None), None), evidence.printed.printed)


#: Columns of the table of all printed numbers: values, their errors against the printed number, and scenes.
PRINTED, SOLID = Quantity("printed", "printed", "", "s"), Quantity("solid", "3D, ours", "", "s")
OFF = {
    "right": Quantity("off", "error: ours against printed", "%", "+.2f"),
    "faulty": Quantity("off_faulty", "error: with the publication's errors, against printed", "%", "+.2f"),
    "reading": Quantity("off_reading", "error: with inferred assumption, against printed", "%", "+.2f"),
    "solid": Quantity("off_solid", "error: 3D against printed", "%", "+.2f"),
}
AGAINST = Quantity("against", "error: low-order against 3D, both ours", "%", "+.2f")
SCENES = Quantity("scenes", "scenes, or why there are none", "", "s")


def printed_and_computed_table(
    layout: PrintedLayout,
    found: Mapping[str, Evidence],
    more: More,
    why: Mapping[str, str],
    columns: Sequence[str] = (),
    note: str = "",
) -> Table:
    """Return the table that compares each number of a printed table with the computed values, with a row per number.

    Rows are in printed order; columns without values are left out.

    Parameters
    ----------
    layout
        Layout of the printed table.
    found
        Printed and computed values, by name of the printed number.
    more
        Further cells that are added to the rows, by name of the printed number.
    why
        Reason why no value by the 3D reference is shown, by name of the printed number.
    columns
        Names of printed numbers that ``more`` shows in cells of other rows; they get no row of their own.
    note
        Note below the table.
    """
    further = dict.fromkeys(q for cells in more.values() for q in cells)
    rows: list[Row] = []
    remarks: dict[str, int] = {}
    for label, names in layout.rows:
        for head, name in zip(layout.columns, names, strict=True):
            if name and name not in columns and found[name].printed.cls != "input":
                f = found[name]
                base = _printed_and_computed_row(layout, f, why.get(name, ""))
                row = base | {q: None for q in further if q not in base} | more.get(name, {})
                reason = join_remarks(f.reason, _tolerance_band_text(f.printed))
                remark = remarks.setdefault(reason, len(remarks) + 1) if reason else None
                first: Row = {Quantity("label", "number", "", "s"): label or f.printed.label}
                first[Quantity("column", "column", "", "s")] = "" if head == "Value" or not label else head
                last: Row = {"verdict": f.verdict, "how": f"how-{f.printed.table}"}
                rows.append(first | row | last | {Quantity("remark", "remark", "", "s"): remark})
    notes = [note, *(f"{number}: {text}" for text, number in remarks.items())]
    title = f"{layout.heading}: printed and computed value of every number"
    text = "\n".join(filter(None, notes))
    return Table.of(layout.stem("compared"), title, _drop_empty_columns(rows), text, unfolded=True)


def _printed_and_computed_row(layout: PrintedLayout, evidence: Evidence, why: str) -> Row:
    """Return the row of one printed number: printed value, computed values, and their errors against it [%].

    ``evidence``: the printed number with its computed values. ``why``: text that is shown if there is no value by the 3D
    reference.
    """
    p, form = evidence.printed, f"g{layout.significant_digits}"
    values = {
        "right": evidence.value,
        "faulty": evidence.as_printed,
        "reading": evidence.reading,
        "solid": evidence.reference,
    }
    off = {key: _percent_error_or_none(value, p.value) for key, value in values.items()}
    return {
        PRINTED: f"{p.printed or p.claim} {p.unit}".rstrip(),
        Quantity("right", "low-order, ours", "", form): _zero_if_round_off(evidence.value),
        Quantity("faulty", "with the publication's errors", "", form): _zero_if_round_off(evidence.as_printed),
        Quantity("reading", "with inferred assumption", "", form): evidence.reading,
        SOLID: f"{_zero_if_round_off(evidence.reference) or 0.0:.{layout.significant_digits}g}"
        if evidence.reference is not None
        else why,
        OFF["right"]: off["right"],
        OFF["faulty"]: off["faulty"],
        OFF["reading"]: off["reading"],
        OFF["solid"]: off["solid"],
        AGAINST: _percent_error_or_none(evidence.value, evidence.reference),
    }


def _tolerance_band_text(printed_number: Printed) -> str:
    """Return as text the tolerance band of a printed number and the origin of the band; empty without a band."""
    return (
        f"Tolerance band: {printed_number.low:g} to {printed_number.high:g}. {printed_number.origin}"
        if printed_number.low is not None and printed_number.high is not None
        else ""
    )


def _percent_error_or_none(value: float | None, reference: float | None) -> float | None:
    """Return the error of a value against a reference [%]; None if one of them is None, or if both are round-off."""
    if value is None or reference is None or max(abs(value), abs(reference)) < 1e-9:
        return None
    return finite_error_or_none(float(error_percent(value, reference)))


def _zero_if_round_off(value: float | None) -> float | None:
    """Return zero for a value below 1e-9, which is round-off, and any other value unchanged."""
    return 0.0 if value is not None and abs(value) < 1e-9 else value


def _drop_empty_columns(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a table without the columns in which every cell is empty."""
    filled = {q for row in rows for q, value in row.items() if value not in (None, "")}
    order = dict.fromkeys(q for row in rows for q in row)
    return [{q: row.get(q) for q in order if q in filled} for row in rows]


def input_data_table(layout: PrintedLayout, found: Mapping[str, Evidence]) -> Table:
    """Return the table of the inputs in a printed table: printed value, value used in the scene, remark.

    Parameters
    ----------
    layout
        Layout of the printed table.
    found
        Printed values and values used in the scene, by name of the printed number.
    """
    rows: list[Row] = [
        {
            Quantity("label", "parameter (symbol)", "", "s"): label,
            Quantity("printed", "printed value", "", "s"): f.printed.printed,
            Quantity("unit", "unit", "", "s"): f.printed.unit,
            Quantity("scene", "value in the scene", "", "s"): format_like_printed_number(f.value, f.printed.printed),
            Quantity("name", "scene", "", "s"): ", ".join(all_computations()[f.printed.table].origin(f.printed)[0]),
            "verdict": f.verdict,
            "how": f"how-{f.printed.table}",
            Quantity("remark", "remark", "", "s"): f.reason,
        }
        for label, (name,) in layout.rows
        for f in (found[name],)
    ]
    return Table.of(layout.stem(), layout.title, rows, unfolded=True)


def computation_tables(tables: Iterable[str]) -> Iterator[Table]:
    """Yield, for each file of printed numbers, a table that states how the numbers are computed.

    It has scenes, function, test and command. ``tables``: names of the files.
    """
    for name in tables:
        one = all_computations()[name]
        places = ", ".join(sorted({row.place.partition(", ")[2] for row in load_table(name)}, key=_sort_key_of_place))
        rows: list[Row] = [
            {
                Quantity("keys", "keys of printed numbers", "", "s"): pattern,
                SCENES: behind if isinstance(behind, str) else ", ".join(behind),
                Quantity("function", "computed by", "", "s"): one.function_name,
                Quantity("test", "tested in", "", "s"): one.test or "–",
                Quantity("command", "recomputed by", "", "s"): f"rollbench check --printed --only {name}",
            }
            for pattern, behind in one.behind
        ]
        yield Table.of(f"how-{name}", f"How the numbers of {name} are computed ({places})", rows)


def _sort_key_of_place(place: str) -> tuple[bool, list[int], str]:
    """Return the key by which places in a publication, such as "Table 2.1", are sorted.

    They are sorted by chapter, tables before sections; appendices come last.
    """
    in_text, text = "Table" not in place, place.rpartition(", ")[2]
    letter = re.match(r"\D*\b([A-Z])\b", text)
    numbers = [ord(letter[1])] if letter else [int(n) for n in re.findall(r"\d+", text)]
    return letter is not None, [*numbers[:1], int(in_text), *numbers[1:]], text


def reproduced_counts_table(found: Sequence[Evidence], name: str = "printed-by-table", *, unfolded: bool = False) -> Table:
    """Return the table that counts, for each table and section of the publications, printed and reproduced numbers.

    Parameters
    ----------
    found
        Printed and computed values.
    name
        File name of the table in the report.
    unfolded
        Whether the table is shown in full length.
    """
    groups: dict[str, list[Evidence]] = {}
    for f in found:
        groups.setdefault(publication_title_of(f.printed), []).append(f)
    rows = []
    for title, of_source in groups.items():
        rows.append(_reproduced_counts_row(f"{title}, all", of_source))
        places: dict[str, list[Evidence]] = {}
        for f in of_source:
            places.setdefault(f.printed.place, []).append(f)
        rows += [_reproduced_counts_row(place, places[place]) for place in sorted(places, key=_sort_key_of_place)]
    note = (
        "A result is a printed number that is neither an input, nor an identity, nor zero by symmetry; only results can be "
        "reproduced. The table printed shows every number."
    )
    return Table.of(
        name,
        "Number of printed values in each table and section of the publications, and how many are reproduced",
        rows,
        note,
        unfolded=unfolded,
    )


def _reproduced_counts_row(place: str, found: Sequence[Evidence]) -> Row:
    """Return the row of `reproduced_counts_table` for one table or section of a publication.

    ``place``: text in the first cell. ``found``: printed numbers and claims of the table or section, with their verdicts.
    """
    numbers = [f for f in found if not f.printed.claim]
    claims = [f for f in found if f.printed.claim]
    tally = Counter(f.verdict for f in numbers)
    borne = sum(f.verdict in ("reproduced", "band") for f in claims)
    return {
        Quantity("place", "publication, table or section", "", "s"): place,
        Quantity("printed", "printed values", "", "s"): len(numbers),
        Quantity("inputs", "inputs", "", "s"): tally["input"],
        Quantity("identities", "identities, zeros by symmetry", "", "s"): tally["identity"],
        Quantity("results", "results", "", "s"): len(numbers) - tally["input"] - tally["identity"],
        Quantity("reproduced", "reproduced", "", "s"): tally["reproduced"],
        Quantity("faulty", "only with the publication's error", "", "s"): tally["only as printed"],
        Quantity("band", "within a tolerance band", "", "s"): tally["band"],
        Quantity("contradicted", "contradicted", "", "s"): tally["contradicted"],
        Quantity("open", "not identifiable", "", "s"): tally["not identifiable"],
        Quantity("claims", "claims confirmed", "", "s"): f"{borne} of {len(claims)}" if claims else "",
    }


def tables_of_printed_numbers(
    printed: Sequence[str], listed: Sequence[PrintedLayout], found: Mapping[str, Evidence]
) -> Iterator[Table]:
    """Yield the report's tables of all numbers of a publication that certain files of printed numbers contain.

    Each table of the publication with a layout is yielded in this layout and with a row per number; then follow the numbers
    and claims of the publication's text.

    Parameters
    ----------
    printed
        Names of the files of printed numbers.
    listed
        Layouts of the publication's printed tables.
    found
        Printed and computed values, by name of the printed number.
    """
    for layout in listed:
        if layout.printed in printed:
            yield side_by_side_table_of_layout(layout, found, {})
            if any(found[name].printed.cls != "input" for name in layout.names):
                yield replace(printed_and_computed_table(layout, found, {}, {}), unfolded=False)
    laid = {name for layout in listed for name in layout.names}
    rest = [f.printed for f in found.values() if f.printed.table in printed and f.printed.name not in laid]
    for what in ("inputs", "numbers and claims"):
        of = [p for p in rest if (p.cls == "input") == (what == "inputs")]
        rows = tuple((f"{p.label} ({p.place.partition(', ')[2]})", (p.name,)) for p in of)
        if rows:
            title = f"{what[:1].upper()}{what[1:]} of the text"
            layout = PrintedLayout(printed[-1], "text", title, title, printed[-1], "sentences", ("Value",), rows)
            yield input_data_table(layout, found) if what == "inputs" else printed_and_computed_table(layout, found, {}, {})
