"""Reading and writing contact loads as CSV files with the columns ball, flank, newton and further contact quantities.

Such files come from users, other programs or ``rollbench solve --csv``.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.files import read_text_file
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.units import (
    DIMENSIONS,
    UnitError,
    number_advice,
    number_of_text,
    parse_quantity,
    standard_unit_spelling,
)

#: Usual headings of the columns for the ball's number, the flank, and the contact load [N].
COLUMNS = ("ball", "flank", "newton")

#: Columns that contain text instead of numbers.
WORDS = ("ball", "flank", "case", "set")

#: Numeric columns: for the beginning of a heading, the name of the quantity and its dimension. The heading must end with a
#: unit.
NAMES = {
    "contact_angle": ("angle", "angle"),
    "contact_load": ("load", "force"),
    "peak_pressure": ("pressure", "pressure"),
    "uncertainty": ("uncertainty", "force"),
    "approach": ("approach", "length"),
    "pressure": ("pressure", "pressure"),
    "azimuth": ("azimuth", "angle"),
    "angle": ("angle", "angle"),
    "force": ("load", "force"),
    "load": ("load", "force"),
    "z": ("z", "length"),
}

#: Units by their spelling in lower case; ``mn`` is omitted because it may be MN or mN.
FOLDED = {unit.lower(): unit for units, _ in DIMENSIONS.values() for unit in units if unit != "MN"}

FOLDED |= {"newton": "N", "newtons": "N"}

#: First line of a file in which Excel states the separator.
SEPARATOR = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)

#: Columns with the position of a ball. A file that has both identifies balls by position instead of by number.
PLACE = {"azimuth", "z"}

#: Contact quantities besides the load that a file may give, by the names of `NAMES`.
FURTHER = ("angle", "approach", "pressure", "uncertainty", "uncertain share")

#: Filter for the rows of a CSV file: for some columns, the accepted texts; only rows with an accepted text are read.
#: Messages show the first text.
Only = Mapping[str, Sequence[str]]

#: Filter that accepts every row.
EVERY: Only = {}

#: Largest size of a file [bytes], enough for four loads on each of 100 000 balls.
MAX_BYTES = 16_000_000

#: Advice with an example of a file, for error messages.
EXAMPLE = "write a first line ball,flank,newton and rows such as 1,SL,225.4"


class Column(NamedTuple):
    """Contact quantity of a column of a CSV file, and the factor from the unit of the column to SI units."""

    #: Name of the quantity as in `WORDS` or `NAMES`; ``uncertain share`` for the uncertainty of a load as a fraction of
    #: this load; empty if the quantity is unknown.
    name: str
    #: Factor that converts the numbers of the column to SI units.
    factor: float = 1.0


def parse_heading(heading: str) -> Column:
    """Return which contact quantity a column of a CSV file holds, and in which unit, from the heading of the column.

    A heading that is only a unit of force, such as ``newton``, is the contact load.

    Parameters
    ----------
    heading
        Heading: name of the quantity with its unit.

    Returns
    -------
    Column
        Name and factor to SI; the name is empty if the quantity is unknown or its unit has another dimension.

    Examples
    --------
    >>> parse_heading("approach_um"), parse_heading("Contact angle [deg]").name
    (Column(name='approach', factor=1e-06), 'angle')
    >>> parse_heading("load / kN"), parse_heading("note")
    (Column(name='load', factor=1000.0), Column(name='', factor=1.0))
    """
    text = heading.strip()
    plain = text.lower().replace(" ", "_")
    if plain in WORDS:
        return Column(plain)
    for start, (name, dimension) in NAMES.items():
        if plain.startswith(start):
            return _column_from_unit(name, text[len(start) :], dimension)
    return _column_from_unit("load", text, "force")


def _column_from_unit(name: str, unit_text: str, dimension: str) -> Column:
    """Return the quantity of a CSV column and the factor from the unit in its heading to SI units.

    ``name``: name of the quantity; ``unit_text``: rest of the heading, which states the unit; ``dimension``: required
    dimension of the unit, such as "force". The name of the returned column is empty if the unit has another dimension.
    """
    unit = standard_unit_spelling(unit_text.strip(" _[]()/"))
    if name == "uncertainty" and unit in ("%", "percent"):
        return Column("uncertain share", 0.01)
    for spelt in (FOLDED.get(unit.lower(), unit), unit.lower()):
        with suppress(UnitError):
            return Column(name, parse_quantity(f"1 {spelt}", dimension))
    return Column("")


@dataclass(frozen=True)
class ContactLoadsFromFile:
    """Contact loads of a scene as read from a user's CSV file, with further contact quantities and notes of the file."""

    #: Contact loads (n, 4) [N]; zero on flanks without rows in the file.
    load: Array
    #: Flanks that have rows in the file.
    flanks_with_rows: tuple[str, ...]
    #: Number of balls that have another number in the file than in the scene, and were matched by position.
    renumbered_ball_count: int = 0
    #: Further quantities of each contact, such as pressure, by the names of `FURTHER`, (n, 4) in SI units; nan: empty cell.
    further_quantities: Mapping[str, Array] = field(default_factory=dict)
    #: Headings of the file whose quantity or unit is not known.
    unknown_headings: tuple[str, ...] = ()
    #: Notes of the file (lines ``# name: text`` above the headings): text by name.
    notes: Mapping[str, str] = field(default_factory=dict)


def load_rows_for_csv(load: Array, azimuth: Array, z: Array) -> list[dict[str, str]]:
    """Return the rows of a CSV file with contact loads and ball positions, one row for each contact.

    Parameters
    ----------
    load
        Contact loads of n balls on 4 flanks, (n, 4) [N].
    azimuth
        Azimuths of the balls, (n,) [rad].
    z
        Axial positions of the balls, (n,) [m].

    Returns
    -------
    list of dict
        Text of each cell by its heading.
    """
    return [
        {
            "ball": str(i + 1),
            "flank": side,
            "newton": repr(float(load[i, s]) + 0.0),
            "azimuth_deg": f"{np.degrees(azimuth[i]):.9g}",
            "z_mm": f"{1e3 * z[i]:.9g}",
        }
        for i in range(len(load))
        for s, side in enumerate(SIDES)
    ]


@dataclass(frozen=True)
class CsvTable:
    """Headings, rows and notes of a user's CSV file."""

    #: Headings as written.
    headings: tuple[str, ...]
    #: Number of the line with the headings.
    heading_line: int
    #: Whether numbers have a decimal comma.
    decimal_comma: bool
    #: Rows: number of the line in the file, and text of each cell by its heading in lower case.
    numbered_rows: tuple[tuple[int, dict[str, str]], ...]
    #: Notes (lines ``# name: text`` above the headings): text by name.
    notes: Mapping[str, str]

    @classmethod
    def from_csv(cls, path: Path, columns: Sequence[str], example: str, optional: Sequence[str] = ()) -> CsvTable:
        """Read a CSV file that has at least the columns ``columns``, in any order.

        The separator is a comma, semicolon or tab, or the character in a first line such as ``sep=;``. Unless the separator
        is a comma, numbers may have a decimal comma.

        Parameters
        ----------
        path
            Path of the file.
        columns
            Headings that the file must have.
        example
            Advice with an example of such a file, which error messages show.
        optional
            Headings that the file may have, each once.

        Returns
        -------
        CsvTable
            Headings, rows and notes of the file.

        Raises
        ------
        InputError
            If the file cannot be read, lacks a column, or a row does not fit the headings.
        """
        lines = read_text_file(path, "CSV file", MAX_BYTES).splitlines()
        says = SEPARATOR.fullmatch(lines[0]) if lines else None
        begin = 0 if says is None else 1
        above = next((k for k, line in enumerate(lines) if k >= begin and not line.startswith("#")), len(lines))
        first, title = f"line {above + 1}", lines[above] if above < len(lines) else ""
        if not title.strip():
            raise InputError(str(path), first, "nothing", ", ".join(columns), example)
        separator = next((c for c in ";\t" if c in title), ",") if says is None else says[1]
        rows = _numbered_rows(path, lines[above:], above, separator)
        titles = tuple(next(rows)[1])
        heads = [head.lower() for head in titles]
        for name in columns:
            if name.lower() not in heads:
                raise InputError(str(path), first, title, f"a column {name}", example)
        for name in (*columns, *optional):
            if heads.count(name.lower()) > 1:
                raise InputError(str(path), first, title, f"only one column {name}", "delete the others")
        kept = []
        for number, row in rows:
            if any(row):
                _check_cells_are_headed(path, number, titles, row, separator)
                cells = dict(zip_longest(heads, row[: len(heads)], fillvalue=""))
                short = next((name for name in columns if heads.index(name.lower()) >= len(row)), None)
                if short is not None:
                    value, allowed = f"no cell after {separator.join(row)}", "a cell in every required column"
                    advice = "complete the row, or check whether the file was truncated"
                    raise InputError(str(path), f"line {number}: {short}", value, allowed, advice)
                kept.append((number, cells))
        comments = (line.strip("#;, \t").partition(":") for line in lines[begin:above])  # spreadsheets add separators
        notes = {name.strip().lower(): text.strip() for name, _, text in comments}
        return cls(titles, above + 1, separator != ",", tuple(kept), notes)


def _numbered_rows(path: Path, lines: Sequence[str], above: int, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of a CSV table as pairs: number of the line in the file, texts of the cells.

    ``path``: the file, for error messages; ``lines``: lines of the table; ``above``: number of lines of the file
    before them; ``separator``: character between two cells. InputError for a quotation mark without its partner.
    """
    reader = csv.reader(lines, delimiter=separator, strict=True)
    try:
        for row in reader:
            yield above + reader.line_num, [cell.strip() for cell in row]
    except csv.Error as error:
        line, advice = f"line {above + reader.line_num}", "close every quotation mark, or remove them"
        raise InputError(str(path), line, str(error), "cells as in a CSV file", advice) from None


def _check_cells_are_headed(path: Path, line: int, headings: Sequence[str], cells: Sequence[str], separator: str) -> None:
    """Raise InputError if a row of a CSV file has text in a column that has no heading.

    The first column may lack a heading, as spreadsheets write row numbers there. ``path`` and ``line``: file, and
    number of the line, for the message; ``headings``: headings; ``cells``: texts of the cells; ``separator``: character
    between cells.
    """
    if not any(cell and not title for cell, title in [*zip_longest(cells, headings, fillvalue="")][1:]):
        return
    value = f"{sum(map(bool, cells))} cells: {separator.join(cells)}"
    advice = "give every column a heading, or put a cell that contains the separator into quotation marks"
    if separator == ",":
        advice = "write numbers with a decimal point, or separate cells by semicolons if numbers have a decimal comma; "
        advice += "else give every column a heading"
    raise InputError(str(path), f"line {line}", value, f"{sum(map(bool, headings))}, one for each heading", advice)


def read_loads(path: Path, scene: Scene, row_filter: Only = EVERY) -> ContactLoadsFromFile:
    """Read contact loads and other contact quantities (angle, pressure, approach) of one load case from a CSV file.

    Headings state the units (`parse_heading`). On each flank that the file contains, every ball must have a row, with load
    0 if the contact carries none: a missing row is an error.

    Parameters
    ----------
    path
        Path of the file.
    scene
        Scene. If the file has both azimuth and axial position of the balls, the rows are matched by position to the balls
        of this scene; if one column is missing, by the numbers of the balls.
    row_filter
        Accepted texts of the columns ``case`` (name of the load case) and ``set`` (name of the nut or bearing); rows with
        other texts are skipped.

    Returns
    -------
    ContactLoadsFromFile
        Loads and other quantities of each contact.

    Raises
    ------
    InputError
        If the file cannot be read or does not fit the scene.
    """
    table = CsvTable.from_csv(path, COLUMNS[:2], EXAMPLE)
    columns = _columns_by_heading(path, table)
    placed, layout = PLACE.issubset(c.name for c in columns.values()), ball_layout(scene)
    values = {name: np.full((scene.ball_count, len(SIDES)), np.nan) for name in ("load", *FURTHER)}
    cases, renumbered = set(), set()
    for number, row in table.numbered_rows:
        named = {c.name: (head, c.factor, row.get(head.lower(), "")) for head, c in columns.items()}
        cells = _ContactLoadRow(path, f"line {number}", named, decimal_comma=table.decimal_comma)
        if any(cells.text_in_column(name) not in words for name, words in row_filter.items()):
            if empty := [name for name in row_filter if name in named and not cells.text_in_column(name)]:
                advice = "fill in the empty cell, or delete the row"
                raise cells.cell_error(empty[0], "", f"in each row, a name in the column {empty[0]}", advice)
            continue
        cases.add(cells.text_in_column("case"))
        if len(cases) > 1:
            advice = "split the file by load case, or delete the rows of other cases"
            raise cells.cell_error("case", cells.text_in_column("case"), "one load case in all rows", advice)
        ball = cells.index_of_placed_ball(scene, layout) if placed else cells.ball_index(scene.ball_count)
        side = cells.flank_index()
        renumbered |= {ball} if placed and cells.text_in_column("ball") != str(ball + 1) else set()
        if not np.isnan(values["load"][ball, side]):
            value = f"a second row of ball {ball + 1} {SIDES[side]}"
            raise InputError(str(path), f"line {number}", value, "one row for each contact", "delete one of the rows")
        for name, of in values.items():
            of[ball, side] = cells.value(name)
    if row_filter and not cases:
        which = " and ".join(row_filter)
        value = " of ".join(f"{name} {words[0]}" for name, words in reversed([*row_filter.items()]))
        advice = f"add the rows; `solve` with `loads_csv=FILE` writes a complete file with the column {which}"
        raise InputError(str(path), which, f"no rows of {value}", f"rows of every {which} of the scene", advice)
    unknown = tuple(f'"{head}"' for head, c in columns.items() if not c.name)
    further = {name: of for name, of in values.items() if name != "load" and name in {c.name for c in columns.values()}}
    load, flanks = _complete_loads(path, values["load"])
    for name in further.keys() - {"uncertainty", "uncertain share"}:
        gaps = np.argwhere(np.isnan(further[name]) & (load > 0.0))
        if gaps.size:
            value = f"no {name} of ball {gaps[0][0] + 1} {SIDES[gaps[0][1]]}"
            advice = f"add the missing {name}, or delete the column"
            raise InputError(str(path), "rows", value, f"the {name} of every contact that carries load", advice)
    return ContactLoadsFromFile(load, flanks, len(renumbered), further, unknown, table.notes)


def _columns_by_heading(path: Path, table: CsvTable) -> dict[str, Column]:
    """Return quantity and unit of each column of a CSV file by its heading.

    ``path``: the file, for error messages. InputError if no column has contact loads, or if two columns have one quantity.
    """
    columns = {head: parse_heading(head) for head in table.headings}
    where, names = f"line {table.heading_line}", [parse_heading(head).name for head in table.headings]
    if "load" not in names:
        raise InputError(str(path), where, ", ".join(table.headings), f"a column {COLUMNS[2]}", EXAMPLE)
    twice = next((head for k, head in enumerate(table.headings) if names[k] and names[k] in names[:k]), None)
    if twice is not None:
        value = f"a second column for the same quantity, {twice}"
        raise InputError(str(path), where, value, "one column for each quantity", "delete one of the columns")
    return columns


class _ContactLoadRow:
    """One row of a CSV file with contact loads; cells are read by the name of a column, such as "ball"."""

    def __init__(self, path: Path, line: str, cells: Mapping[str, tuple[str, float, str]], *, decimal_comma: bool) -> None:
        """Store the cells of a row.

        ``path`` and ``line``: file and line of the row, for error messages; ``cells``: heading, factor to SI units, and
        text of the cell, by name of the column; ``decimal_comma``: whether numbers have a decimal comma.
        """
        self._path, self._line, self._cells, self._comma = path, line, cells, decimal_comma

    def cell_error(self, name: str, value: str, allowed: str, advice: str) -> InputError:
        """Return the InputError for a cell of this row that cannot be used.

        ``name``: column of the cell; ``value``: its text; ``allowed``: allowed texts or range; ``advice``: what to do.
        """
        return InputError(str(self._path), f"{self._line}: {name}", value or "nothing", allowed, advice)

    def text_in_column(self, name: str) -> str:
        """Return the text of this row's cell in the column ``name``; empty if the file has no such column."""
        return self._cells.get(name, ("", 1.0, ""))[2]

    def ball_index(self, balls: int) -> int:
        """Return the index (from 0) of the ball whose number (from 1) is in the row; ``balls``: number of balls."""
        ball = self.text_in_column("ball")
        if not (ball.isascii() and ball.isdecimal() and len(ball) < 10 and 1 <= int(ball) <= balls):
            advice = "add 1 to all numbers" if ball == "0" else "check the number"
            advice += ": balls are numbered from 1; in a screw with several thread starts, the balls of the first start "
            advice += "have the lowest numbers"
            raise self.cell_error("ball", ball, f"a ball number from 1 to {balls}", advice)
        return int(ball) - 1

    def flank_index(self) -> int:
        """Return the index of the flank in the row: 0 to 3 for left and right flank of the screw, then of the nut."""
        flank = self.text_in_column("flank")
        if flank.upper() not in SIDES:
            advice = "write SL or SR for the left or right flank of the screw, NL or NR for those of the nut"
            raise self.cell_error("flank", flank, ", ".join(SIDES), advice)
        return SIDES.index(flank.upper())

    def index_of_placed_ball(self, scene: Scene, layout: BallLayout) -> int:
        """Return the index of the ball at the position in the row; InputError if no ball centre is within a ball radius.

        ``layout``: positions of the balls of the scene.
        """
        azimuth, z = self.value("azimuth"), self.value("z")
        turn = np.angle(np.exp(1j * (layout.azimuth - azimuth)))
        away = np.hypot(scene.track.pitch_radius * turn, layout.z - z)
        ball = int(away.argmin())
        if away[ball] > scene.balls.radius:
            place = f"{np.degrees(azimuth):g} deg, {1e3 * z:g} mm"
            allowed = f"the position of a ball; the nearest, ball {ball + 1}, is {1e3 * away[ball]:.3g} mm away"
            advice = "use the positions that `solve` with `loads_csv=FILE` writes, or delete both columns to identify "
            advice += "balls by their numbers"
            raise self.cell_error("azimuth, z", place, allowed, advice)
        return ball

    def value(self, name: str) -> float:
        """Return this row's value of the quantity ``name`` in SI units; nan for an empty cell.

        InputError if the text of the cell is not a number, if a number other than a position (`PLACE`) is below 0, or if
        the contact load or a position is missing.
        """
        head, factor, text = self._cells.get(name, ("", 1.0, ""))
        if not text and name not in ("load", *PLACE):
            return float("nan")
        value = number_of_text(text.replace(",", ".") if self._comma else text)
        if not np.isfinite(value) or (value < 0.0 and name not in PLACE):
            allowed, advice = "a number", "write a number, or delete the column"
            if name not in PLACE:
                allowed = "a number, at least 0"
                advice = "write a number without unit (the heading states the unit), and 0 for a contact without load"
            raise self.cell_error(head, text, allowed, number_advice(text, advice))
        return value * factor


def _complete_loads(path: Path, load: Array) -> tuple[Array, tuple[str, ...]]:
    """Check that contact loads read from a CSV file are complete; return them with 0 for missing rows, and their flanks.

    ``path``: the file, for error messages; ``load``: contact loads of n balls, (n, 4) [N]; nan: no row in the file.
    InputError if there is no load at all, or if a ball has none on a flank on which other balls have one.
    """
    given = ~np.isnan(load)
    if not given.any():
        raise InputError(str(path), "file", "no loads", "a row for every contact", EXAMPLE)
    named = given.any(axis=0)
    gaps = np.argwhere(~given & named)
    if gaps.size:
        ball, side = (int(k) for k in gaps[0])
        more = f" and {len(gaps) - 1} more contacts" if len(gaps) > 1 else ""
        value = f"no load of ball {ball + 1} {SIDES[side]}{more}"
        advice = "write 0 for a contact that carries nothing, or delete all rows of the flank"
        raise InputError(str(path), "rows", value, "a row for every ball on each flank of the file", advice)
    return np.where(given, load, 0.0), tuple(SIDES[k] for k in np.flatnonzero(named))
