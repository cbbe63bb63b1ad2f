"""Tables of a source as it prints them, with the computed value of each number.

``layout.toml`` of a case has the layout: number, title, columns, rows with their label and a key for each column. A table
of results is shown twice: in the source's layout, printed and computed next to each other, and with a row for each number.
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
from rollbench.compare.evidence import Evidence, computations, joined_remarks, source
from rollbench.compare.measure import error_percent
from rollbench.compare.printed import Printed, entry, load_table
from rollbench.compare.sections.verdicts import shown_error
from rollbench.reports.content import Quantity, Row, Table

#: Further cells of a row, by printed entry ("table:key").
More = Mapping[str, Row]


@dataclass(frozen=True)
class Layout:
    """A table as its source prints it."""

    #: Name of the case.
    case: str
    #: Number of the table.
    number: str
    #: Short description of its contents.
    short: str
    #: Title.
    title: str
    #: Printed table with most of its numbers.
    printed: str
    #: ``inputs_table``, ``results`` or ``sentences``.
    kind: str
    #: Headings of the columns.
    columns: tuple[str, ...]
    #: Rows: label, and for each column the name of a printed entry ("table:key"; empty for an empty cell).
    rows: tuple[tuple[str, tuple[str, ...]], ...]

    @property
    def names(self) -> list[str]:
        """Names of its printed entries, row by row, without empty cells."""
        return [name for _, names in self.rows for name in names if name]

    @property
    def across(self) -> list[tuple[str, ...]]:
        """Names of its printed entries as rows of columns; an empty name for an empty cell."""
        return [names for _, names in self.rows]

    def stem(self, what: str = "") -> str:
        """Return the name of the report's table for this layout; ``what``: suffix for what it shows."""
        return "-".join(filter(None, (self.case, self.number, what)))

    @property
    def heading(self) -> str:
        """Number and short description, as a heading."""
        return self.short if self.kind == "sentences" or self.number[:1].islower() else f"Table {self.number}: {self.short}"

    @property
    def digits(self) -> int:
        """Number of significant digits that shows all printed ones; at least five."""
        texts = (entry(*name.split(":")).printed.partition("e")[0] for name in self.names)
        return max(5, *(len(text.replace(".", "").lstrip("-0")) for text in texts))


def read_layouts(case: Case) -> list[Layout]:
    """Return the layouts of a case, in order; InputError for a wrong row."""
    path = case.folder / "layout.toml"
    return [_read_layout(case.name, str(path), one) for one in tomllib.loads(path.read_text("utf-8"))["table"]]


def _read_layout(case: str, path: str, one: Mapping[str, Any]) -> Layout:
    """Return a layout from its tables in ``layout.toml``; raises InputError for an unknown entry."""
    rows = []
    for label, *keys in one["rows"]:
        names = tuple(key if ":" in key or not key else f"{one['printed']}:{key}" for key in keys)
        for name in filter(None, names):
            try:
                entry(*name.split(":"))
            except KeyError as error:
                raise InputError(path, one["number"], name, "a printed entry", "mend the layout") from error
        rows.append((label, names))
    texts = {key: one[key] for key in ("number", "short", "title", "printed", "kind")}
    return Layout(case, **texts, columns=tuple(one["columns"]), rows=tuple(rows))


def as_printed_digits(value: float | None, printed: str) -> str:
    """Return a value with the digits of a printed number.

    Examples
    --------
    >>> as_printed_digits(1.81234e-7, "1.812e-7"), as_printed_digits(2.3456, "2.30"), as_printed_digits(None, "1")
    ('1.812e-7', '2.35', '–')
    """
    if value is None:
        return "–"
    if "e" in printed:
        mantissa = printed.partition("e")[0]
        digits, _, power = f"{value:.{len(mantissa.partition('.')[2])}e}".partition("e")
        return f"{digits}e{int(power)}"
    text = f"{value:.{max(0, -int(Decimal(printed).as_tuple().exponent))}f}"
    return text.removeprefix("-") if not float(text) else text


def in_layout(layout: Layout, found: Mapping[str, Evidence], ours: Mapping[str, str]) -> Table:
    """Return the table in the source's layout, with printed and computed number next to each other.

    The computed number has the printed digits. If it repeats a fault of the source, the correct value is added.
    ``ours``: texts that replace other computed values, such as times.
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
                texts["right"] = "" if right is None else f"{as_printed_digits(right, p.printed)} {unit}".rstrip()
            for key, text in texts.items():
                if key != "right" or faulty[k]:
                    row[Quantity(f"{key}-{k}", f"{head}, {key}", heading, "s")] = text
        rows.append(row)
    note = "Ours: by the low-order model, with the source's faults repeated where they change it, then the right value too"
    note += (
        "; of ANSYS numbers by 3D." if any(f.reference is not None for f in map(found.__getitem__, layout.names)) else "."
    )
    return Table.of(layout.stem(), layout.title, rows, note, unfolded=True)


def _printed_units(names: Iterable[str], found: Mapping[str, Evidence]) -> set[str]:
    """Return the units of the printed numbers among some entries."""
    return {found[name].printed.unit for name in names if name and not found[name].printed.claim}


def computed_value_text(f: Evidence) -> str:
    """Return the computed value of an entry as text, with the printed digits.

    The first that exists: value with the source's faults, correct value, 3D value.
    """
    if f.printed.claim:
        return "–" if f.holds is None else "holds" if f.holds else "does not hold"
    values = (f.as_printed, f.value, f.reference)
    return as_printed_digits(next((v for v in values if v is not None), None), f.printed.printed)


#: Columns of a row of a printed number, besides the computed values.
PRINTED, SOLID = Quantity("printed", "printed", "", "s"), Quantity("solid", "3D, ours", "", "s")
OFF = {
    "right": Quantity("off", "ours against printed", "%", "+.2f"),
    "faulty": Quantity("off_faulty", "with faults against printed", "%", "+.2f"),
    "reading": Quantity("off_reading", "inferred against printed", "%", "+.2f"),
    "solid": Quantity("off_solid", "3D against printed", "%", "+.2f"),
}
AGAINST = Quantity("against", "low-order against 3D, ours", "%", "+.2f")
SCENES = Quantity("scenes", "scenes, or why none", "", "s")


def compared_table(
    layout: Layout,
    found: Mapping[str, Evidence],
    more: More,
    why: Mapping[str, str],
    columns: Sequence[str] = (),
    note: str = "",
) -> Table:
    """Return the table of a layout's results, one row each in printed order; empty columns are left out.

    Parameters
    ----------
    layout
        The layout.
    found
        Evidence by name of the entry.
    more
        Further cells by entry.
    why
        Reason why there is no 3D value, by entry.
    columns
        Entries that are in cells of other rows.
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
                base = _compared_row(layout, f, why.get(name, ""))
                row = base | {q: None for q in further if q not in base} | more.get(name, {})
                reason = joined_remarks(f.reason, _band_text(f.printed))
                remark = remarks.setdefault(reason, len(remarks) + 1) if reason else None
                first: Row = {Quantity("label", "number", "", "s"): label or f.printed.label}
                first[Quantity("column", "column", "", "s")] = "" if head == "Value" or not label else head
                last: Row = {"verdict": f.verdict, "how": f"how-{f.printed.table}"}
                rows.append(first | row | last | {Quantity("remark", "remark", "", "s"): remark})
    notes = [note, *(f"{number}: {text}" for text, number in remarks.items())]
    title = f"{layout.heading}, every number printed and computed"
    text = "\n".join(filter(None, notes))
    return Table.of(layout.stem("compared"), title, _drop_empty_columns(rows), text, unfolded=True)


def _compared_row(layout: Layout, f: Evidence, why: str) -> Row:
    """Return the row of one result: printed, computed, and errors."""
    p, form = f.printed, f"g{layout.digits}"
    values = {"right": f.value, "faulty": f.as_printed, "reading": f.reading, "solid": f.reference}
    off = {key: _error_or_none(value, p.value) for key, value in values.items()}
    return {
        PRINTED: f"{p.printed or p.claim} {p.unit}".rstrip(),
        Quantity("right", "low-order, ours", "", form): _round_off(f.value),
        Quantity("faulty", "with the source's faults", "", form): _round_off(f.as_printed),
        Quantity("reading", "inferred reading", "", form): f.reading,
        SOLID: f"{_round_off(f.reference) or 0.0:.{layout.digits}g}" if f.reference is not None else why,
        OFF["right"]: off["right"],
        OFF["faulty"]: off["faulty"],
        OFF["reading"]: off["reading"],
        OFF["solid"]: off["solid"],
        AGAINST: _error_or_none(f.value, f.reference),
    }


def _band_text(p: Printed) -> str:
    """Return ends and origin of a band in words; empty for another class."""
    return f"Band: {p.low:g} to {p.high:g}. {p.origin}" if p.low is not None and p.high is not None else ""


def _error_or_none(value: float | None, reference: float | None) -> float | None:
    """Return the error [%] of a value; None without one of the two, or if both are round-off."""
    if value is None or reference is None or max(abs(value), abs(reference)) < 1e-9:
        return None
    return shown_error(float(error_percent(value, reference)))


def _round_off(value: float | None) -> float | None:
    """Return zero for round-off, else the value."""
    return 0.0 if value is not None and abs(value) < 1e-9 else value


def _drop_empty_columns(rows: Sequence[Row]) -> list[Row]:
    """Return rows without columns that none of them fills."""
    filled = {q for row in rows for q, value in row.items() if value not in (None, "")}
    order = dict.fromkeys(q for row in rows for q in row)
    return [{q: row.get(q) for q in order if q in filled} for row in rows]


def inputs_table(layout: Layout, found: Mapping[str, Evidence]) -> Table:
    """Return the table of a layout's inputs: printed value, value in the scene, remark."""
    rows: list[Row] = [
        {
            Quantity("label", "parameter (symbol)", "", "s"): label,
            Quantity("printed", "printed value", "", "s"): f.printed.printed,
            Quantity("unit", "unit", "", "s"): f.printed.unit,
            Quantity("scene", "scene", "", "s"): as_printed_digits(f.value, f.printed.printed),
            Quantity("name", "in scene", "", "s"): ", ".join(computations()[f.printed.table].origin(f.printed)[0]),
            "verdict": f.verdict,
            "how": f"how-{f.printed.table}",
            Quantity("remark", "remark", "", "s"): f.reason,
        }
        for label, (name,) in layout.rows
        for f in (found[name],)
    ]
    return Table.of(layout.stem(), layout.title, rows, unfolded=True)


def computation_tables(tables: Iterable[str]) -> Iterator[Table]:
    """Yield, for each printed table, how its numbers are computed: scenes, function, test, command."""
    for name in tables:
        one = computations()[name]
        places = ", ".join(sorted({row.place.partition(", ")[2] for row in load_table(name)}, key=_in_order))
        rows: list[Row] = [
            {
                Quantity("keys", "entries", "", "s"): pattern,
                SCENES: behind if isinstance(behind, str) else ", ".join(behind),
                Quantity("function", "computed by", "", "s"): one.function,
                Quantity("test", "asserted in", "", "s"): one.test or "–",
                Quantity("command", "again by", "", "s"): f"rollbench check --printed --only {name}",
            }
            for pattern, behind in one.behind
        ]
        yield Table.of(f"how-{name}", f"How the numbers of {name} are computed ({places})", rows)


def _in_order(place: str) -> tuple[bool, list[int], str]:
    """Return the sort key of a place in a source: by chapter, tables before sections; appendices last."""
    in_text, text = "Table" not in place, place.rpartition(", ")[2]
    letter = re.match(r"\D*\b([A-Z])\b", text)
    numbers = [ord(letter[1])] if letter else [int(n) for n in re.findall(r"\d+", text)]
    return letter is not None, [*numbers[:1], int(in_text), *numbers[1:]], text


def by_place(found: Sequence[Evidence], name: str = "printed-by-table", *, unfolded: bool = False) -> Table:
    """Return the table of counts by place: printed numbers, results among them, reproduced ones."""
    groups: dict[str, list[Evidence]] = {}
    for f in found:
        groups.setdefault(source(f.printed), []).append(f)
    rows = []
    for title, of_source in groups.items():
        rows.append(_count_row(f"{title}, all", of_source))
        places: dict[str, list[Evidence]] = {}
        for f in of_source:
            places.setdefault(f.printed.place, []).append(f)
        rows += [_count_row(place, places[place]) for place in sorted(places, key=_in_order)]
    note = (
        "A result is a printed number that is no input, identity or zero by symmetry: only these can be reproduced. Table "
        "printed has every entry."
    )
    return Table.of(
        name,
        "Printed values by table and section of the thesis, and how many are reproduced",
        rows,
        note,
        unfolded=unfolded,
    )


def _count_row(place: str, found: Sequence[Evidence]) -> Row:
    """Return the row of `by_place` for one place."""
    numbers = [f for f in found if not f.printed.claim]
    claims = [f for f in found if f.printed.claim]
    tally = Counter(f.verdict for f in numbers)
    borne = sum(f.verdict in ("reproduced", "band") for f in claims)
    return {
        Quantity("place", "source, table or section", "", "s"): place,
        Quantity("printed", "printed values", "", "s"): len(numbers),
        Quantity("inputs", "inputs", "", "s"): tally["input"],
        Quantity("identities", "identities, zeros by symmetry", "", "s"): tally["identity"],
        Quantity("results", "results", "", "s"): len(numbers) - tally["input"] - tally["identity"],
        Quantity("reproduced", "come out", "", "s"): tally["reproduced"],
        Quantity("faulty", "only with the source's fault", "", "s"): tally["only as printed"],
        Quantity("band", "within a band", "", "s"): tally["band"],
        Quantity("contradicted", "contradicted", "", "s"): tally["contradicted"],
        Quantity("open", "not identifiable", "", "s"): tally["not identifiable"],
        Quantity("claims", "claims borne out", "", "s"): f"{borne} of {len(claims)}" if claims else "",
    }


def shown_tables(printed: Sequence[str], listed: Sequence[Layout], found: Mapping[str, Evidence]) -> Iterator[Table]:
    """Yield all printed values of some tables of a case: in the source's layout and row by row, then others."""
    for layout in listed:
        if layout.printed in printed:
            yield in_layout(layout, found, {})
            if any(found[name].printed.cls != "input" for name in layout.names):
                yield replace(compared_table(layout, found, {}, {}), unfolded=False)
    laid = {name for layout in listed for name in layout.names}
    rest = [f.printed for f in found.values() if f.printed.table in printed and f.printed.name not in laid]
    for what in ("inputs", "numbers and claims"):
        of = [p for p in rest if (p.cls == "input") == (what == "inputs")]
        rows = tuple((f"{p.label} ({p.place.partition(', ')[2]})", (p.name,)) for p in of)
        if rows:
            title = f"{what[:1].upper()}{what[1:]} of the text"
            layout = Layout(printed[-1], "text", title, title, printed[-1], "sentences", ("Value",), rows)
            yield inputs_table(layout, found) if what == "inputs" else compared_table(layout, found, {}, {})
