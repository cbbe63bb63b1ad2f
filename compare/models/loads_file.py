"""Contact loads as CSV files, read and written: the columns ball, flank, newton, where the balls are, and more of the
contacts; of a user, of another program, of `solve`."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.files import ENCODING, NoText, like_path, text_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.units import COMMA, COMMON, UnitError, has_comma, parse, tidy

COLUMNS = ("ball", "flank", "newton")

#: Words of a row.
WORDS = ("ball", "flank", "case", "set")

#: Numbers of a row by the name that headings have for them: the name here, and its dimension; none goes without unit.
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

#: Units as they are spelt in headings without capitals; ``mn`` may mean two.
FOLDED = {unit.lower(): unit for units in COMMON.values() for unit in units if unit != "MN"}

FOLDED |= {"newton": "N", "newtons": "N"}

#: First line by which Excel says its separator.
SEPARATOR = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)

#: Where a ball is; given both, they say which ball a row is of, however the file numbers it.
PLACE = {"azimuth", "z"}

#: What a file may say of contacts besides, by the names of `NAMES`.
FURTHER = ("angle", "approach", "pressure", "uncertainty", "uncertain share")

#: Which rows of a file are read: by column the words that they have there, the usual one first.
Only = Mapping[str, Sequence[str]]

EVERY: Only = {}

#: Largest file [bytes]: four loads of 100 000 balls.
MAX_BYTES = 16_000_000

EXAMPLE = "write a first line ball,flank,newton and rows such as 1,SL,225.4"


class Column(NamedTuple):
    """What a heading names, as `WORDS` and `NAMES` have it, or ``uncertain share``, of a load (empty: nothing known, or no
    unit that fits), and the factor of its numbers to SI."""

    name: str
    factor: float = 1.0


def column(head: str) -> Column:
    """What a heading names: ``newton`` or any unit of force is the load, others are a name with its unit.

    >>> column("approach_um"), column("Contact angle [deg]").name, column("load / kN"), column("note")
    (Column(name='approach', factor=1e-06), 'angle', Column(name='load', factor=1000.0), Column(name='', factor=1.0))
    """
    text = head.strip()
    plain = text.lower().replace(" ", "_")
    if plain in WORDS:
        return Column(plain)
    for start, (name, dimension) in NAMES.items():
        if plain.startswith(start):
            return _with_unit(name, text[len(start) :], dimension)
    return _with_unit("load", text, "force")


def _with_unit(name: str, text: str, dimension: str) -> Column:
    unit = tidy(text.strip(" _[]()/"))
    if name == "uncertainty" and unit in ("%", "percent"):
        return Column("uncertain share", 0.01)
    for spelt in (FOLDED.get(unit.lower(), unit), unit.lower()):
        with suppress(UnitError):
            return Column(name, parse(f"1 {spelt}", dimension))
    return Column("")


@dataclass(frozen=True)
class GivenLoads:
    """Loads ``(n, 4)`` [N] in the order of SIDES, zero on the flanks that the file does not name, the named flanks, and
    how many balls have another number in the file than in the scene; further: what else the file says of contacts
    ``(n, 4)`` in SI, nan in empty cells, by the names of `FURTHER`; unknown: headings that nothing is known of; notes."""

    load: Array
    flanks: tuple[str, ...]
    renumbered: int = 0
    further: Mapping[str, Array] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)


def loads_csv(load: Array, azimuth: Array, z: Array) -> list[dict[str, str]]:
    """Rows of a file with every contact: loads ``(n, 4)`` [N], azimuths ``(n,)`` [rad], stations ``(n,)`` [m]."""
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
class Rows:
    """A CSV file: its headings as written, the number of their line, whether numbers have a decimal
    comma, its rows with their line numbers, and its notes: lines above the headings, ``# name: text``."""

    titles: tuple[str, ...]
    line: int
    decimal_comma: bool
    rows: tuple[tuple[int, dict[str, str]], ...]
    notes: Mapping[str, str]

    @classmethod
    def read(cls, path: Path, columns: Sequence[str], example: str, optional: Sequence[str] = ()) -> Rows:
        """A file with some columns, in any order, among others, separated by commas, semicolons or tabs, or by what a first
        line ``sep=;`` says (a decimal comma is read where they are not commas). optional: columns that are read where there
        are any. Raises InputError, with an example, also for a row whose cells do not fit the headings."""
        lines = read_table(path).splitlines()
        says = SEPARATOR.fullmatch(lines[0]) if lines else None
        begin = 0 if says is None else 1
        above = next((k for k, line in enumerate(lines) if k >= begin and not line.startswith("#")), len(lines))
        first, title = f"line {above + 1}", lines[above] if above < len(lines) else ""
        if not title.strip():
            raise InputError(str(path), first, "nothing", ", ".join(columns), example)
        separator = next((c for c in ";\t" if c in title), ",") if says is None else says[1]
        rows = _cells(path, lines[above:], above, separator)
        titles = tuple(next(rows)[1])
        heads = [head.lower() for head in titles]
        for name in columns:
            if name.lower() not in heads:
                raise InputError(str(path), first, title, f"a column {name}", example)
        for name in (*columns, *optional):
            if heads.count(name.lower()) > 1:
                raise InputError(str(path), first, title, f"one column {name}", "delete the others")
        kept = []
        for number, row in rows:
            if any(row):
                _check_cells(path, number, titles, row, separator)
                cells = dict(zip_longest(heads, row[: len(heads)], fillvalue=""))
                short = next((name for name in columns if heads.index(name.lower()) >= len(row)), None)
                if short is not None:
                    value, allowed = f"nothing after {separator.join(row)}", "a cell for every heading that is read"
                    raise InputError(str(path), f"line {number}: {short}", value, allowed, "was the file cut off?")
                kept.append((number, cells))
        notes = dict(_note(line) for line in lines[begin:above])
        return cls(titles, above + 1, separator != ",", tuple(kept), notes)


def _cells(path: Path, lines: Sequence[str], above: int, separator: str) -> Iterator[tuple[int, list[str]]]:
    """Cells of every row, with the number of its line. Raises InputError for quotes that do not fit."""
    reader = csv.reader(lines, delimiter=separator, strict=True)
    try:
        for row in reader:
            yield above + reader.line_num, [cell.strip() for cell in row]
    except csv.Error as error:
        advice = "close every quote, or leave quotes out"
        raise InputError(str(path), f"line {above + reader.line_num}", str(error), "cells of a CSV file", advice) from None


def _check_cells(path: Path, number: int, titles: Sequence[str], row: Sequence[str], separator: str) -> None:
    """Raises InputError for a row with a filled cell that has no heading; the first may be one, where row numbers stand."""
    if not any(cell and not title for cell, title in [*zip_longest(row, titles, fillvalue="")][1:]):
        return
    value = f"{sum(map(bool, row))} cells: {separator.join(row)}"
    advice = "give every column a heading, or put a cell that holds a separator into quotes"
    if separator == ",":
        advice = "is it a decimal comma? write a point, or separate cells by semicolons; else give every column a heading"
    raise InputError(str(path), f"line {number}", value, f"{sum(map(bool, titles))}, one for each heading", advice)


def read_loads(path: Path, balls: int, scene: Scene | None = None, only: Only = EVERY) -> GivenLoads:
    """Loads of a file for a scene of ``balls`` balls, and what else it says of their contacts.

    scene: whose balls are told by azimuth and station where the file has both columns of `PLACE`, else by their numbers;
    only: which rows are read, by their words in the columns case and set; those of one case where it says none.

    Headings say the units (`column`). Every ball must be given on every flank that is named, 0 where it carries
    nothing: a row that was lost is not taken for a contact without load. Raises InputError.
    """
    table = Rows.read(path, COLUMNS[:2], EXAMPLE)
    columns = _columns(path, table)
    find = None if scene is None or not PLACE.issubset(c.name for c in columns.values()) else _Places(scene)
    values = {name: np.full((balls, len(SIDES)), np.nan) for name in ("load", *FURTHER)}
    cases, renumbered = set(), set()
    for number, row in table.rows:
        named = {c.name: (head, c.factor, row.get(head.lower(), "")) for head, c in columns.items()}
        cells = _Row(path, f"line {number}", named, decimal_comma=table.decimal_comma)
        if any(cells.word(name) not in words for name, words in only.items()):
            if empty := [name for name in only if name in named and not cells.word(name)]:
                raise cells.fault(empty[0], "", "the word that the row is of", "fill the cell, or delete the row")
            continue
        cases.add(cells.word("case"))
        if len(cases) > 1:
            advice = "a scene is one load case: split the file, or delete the others"
            raise InputError(str(path), f"line {number}: case", cells.word("case"), "one case", advice)
        ball, side = cells.ball(balls) if find is None else find.number(cells), cells.side()
        renumbered |= {ball} if find is not None and cells.word("ball") != str(ball + 1) else set()
        if not np.isnan(values["load"][ball, side]):
            value = f"ball {ball + 1} {SIDES[side]} again"
            raise InputError(str(path), f"line {number}", value, "each contact once", "keep one of the rows")
        for name, of in values.items():
            of[ball, side] = cells.amount(name)
    if only and not cases:
        which, value = " and ".join(only), " of ".join(f"{name} {words[0]}" for name, words in reversed([*only.items()]))
        advice = f"solve with `loads_csv=FILE` writes all, told apart by the column {which}"
        raise InputError(str(path), which, f"no rows of {value}", f"rows of every {which} of the scene", advice)
    unknown = tuple(f'"{head}"' for head, c in columns.items() if not c.name)
    further = {name: of for name, of in values.items() if name != "load" and name in {c.name for c in columns.values()}}
    loads = _whole(path, values["load"])
    for name in further.keys() - {"uncertainty", "uncertain share"}:
        gaps = np.argwhere(np.isnan(further[name]) & (loads.load > 0.0))
        if gaps.size:
            value = f"no {name} of ball {gaps[0][0] + 1} {SIDES[gaps[0][1]]}"
            raise InputError(str(path), "rows", value, "one of every contact that carries load", "or leave the column out")
    return replace(loads, renumbered=len(renumbered), further=further, unknown=unknown, notes=table.notes)


def _note(line: str) -> tuple[str, str]:
    """Name and text of a line of notes, which a spreadsheet may have filled up with separators."""
    name, _, text = line.strip("#;, \t").partition(":")
    return name.strip().lower(), text.strip()


def _columns(path: Path, table: Rows) -> dict[str, Column]:
    """What the headings name. Raises InputError where one is missing, or two name the same."""
    columns = {head: column(head) for head in table.titles}
    where, names = f"line {table.line}", [column(head).name for head in table.titles]
    if "load" not in names:
        raise InputError(str(path), where, ", ".join(table.titles), f"a column {COLUMNS[2]}", EXAMPLE)
    twice = next((head for k, head in enumerate(table.titles) if names[k] and names[k] in names[:k]), None)
    if twice is not None:
        raise InputError(str(path), where, twice, "each quantity once", "delete one of the columns")
    return columns


class _Row:
    """A row of a file, by what its columns name."""

    def __init__(self, path: Path, line: str, cells: Mapping[str, tuple[str, float, str]], *, decimal_comma: bool) -> None:
        self._path, self._line, self._cells, self._comma = path, line, cells, decimal_comma

    def fault(self, name: str, value: str, allowed: str, advice: str) -> InputError:
        """The refusal of a cell."""
        return InputError(str(self._path), f"{self._line}: {name}", value or "nothing", allowed, advice)

    def word(self, name: str) -> str:
        """The text of a cell, empty where there is none."""
        return self._cells.get(name, ("", 1.0, ""))[2]

    def ball(self, balls: int) -> int:
        """Index of the ball by its number."""
        ball = self.word("ball")
        if not (ball.isascii() and ball.isdecimal() and len(ball) < 10 and 1 <= int(ball) <= balls):
            first = "the file's seem to begin with 0: " if ball == "0" else ""
            advice = f"{first}balls are numbered from 1, all balls of start 1 first"
            raise self.fault("ball", ball, f"a ball number from 1 to {balls}", advice)
        return int(ball) - 1

    def side(self) -> int:
        """Index of the flank."""
        flank = self.word("flank")
        if flank.upper() not in SIDES:
            advice = "SL and SR: left and right flank of the screw, NL and NR: of the nut"
            raise self.fault("flank", flank, ", ".join(SIDES), advice)
        return SIDES.index(flank.upper())

    def place(self, name: str) -> float:
        """An azimuth [rad] or a station [m]."""
        value, factor, text = self._number(name)
        if not np.isfinite(value):
            raise self.fault(self._cells[name][0], text, "a number", comma_or("or leave the column out", text))
        return value * factor

    def amount(self, name: str) -> float:
        """A number of zero or more, in SI. Of any column but the load: nan where the cell is empty, or the file has no such
        column."""
        value, factor, text = self._number(name)
        if not text and name != "load":
            return float("nan")
        if not 0.0 <= value < float("inf"):
            advice = "write the size without unit, which the heading says, and 0 where contact is lost"
            raise self.fault(self._cells[name][0], text, "a number from 0", comma_or(advice, text))
        return value * factor

    def _number(self, name: str) -> tuple[float, float, str]:
        """A cell as it is, nan for anything but a number; the factor to SI; the text."""
        _, factor, text = self._cells.get(name, ("", 1.0, ""))
        return number_of(text, decimal_comma=self._comma), factor, text


class _Places:
    """Which ball of a scene is at an azimuth and a station."""

    def __init__(self, scene: Scene) -> None:
        layout = ball_layout(scene)
        self._azimuth, self._z = layout.azimuth, layout.z
        self._pitch, self._near = scene.track.pitch_radius, scene.balls.radius

    def number(self, row: _Row) -> int:
        """Index of the ball at the place of a row. Raises InputError where none is within a ball's radius."""
        azimuth, z = row.place("azimuth"), row.place("z")
        turn = np.angle(np.exp(1j * (self._azimuth - azimuth)))
        away = np.hypot(self._pitch * turn, self._z - z)
        ball = int(away.argmin())
        if away[ball] > self._near:
            place = f"{np.degrees(azimuth):g} deg, {1e3 * z:g} mm"
            allowed = f"the place of a ball; the nearest, {ball + 1}, is {1e3 * away[ball]:.3g} mm away"
            advice = "places are those of solve with `loads_csv=FILE`; without the columns, numbers count"
            raise row.fault("azimuth, z", place, allowed, advice)
        return ball


def number_of(text: str, *, decimal_comma: bool) -> float:
    """A number; nan for anything else."""
    try:
        return float(text.replace(",", ".") if decimal_comma else text)
    except ValueError:
        return float("nan")


def comma_or(advice: str, text: str) -> str:
    """What to do about a cell that is no number: with a decimal comma its name, else some advice.

    >>> comma_or("write a number", "489,5"), comma_or("write a number", "x")
    ('is it a decimal comma? write a point, and nothing between thousands', 'write a number')
    """
    return COMMA if has_comma(text) else advice


def read_table(path: Path) -> str:
    """The text of a file. Raises InputError where it cannot be read, is no text, or is too large."""
    allowed, advice = "a readable CSV file", "check the path"
    try:
        if not path.is_file():
            value, near = ("no regular file", "") if path.exists() else ("no such file", like_path(path))
            raise InputError(str(path), "file", value, allowed, near or advice)
        if path.stat().st_size > MAX_BYTES:
            most = f"up to {MAX_BYTES // 1_000_000} MB"
            raise InputError(str(path), "file", "a larger one", most, "is this a table of loads?")
        return text_of(path.read_bytes())
    except OSError as error:
        raise InputError(str(path), "file", error.strerror or str(error), allowed, advice) from None
    except NoText as error:
        raise InputError(str(path), "file", error.value, f"a CSV file, {ENCODING}", error.advice) from None
    except ValueError as error:
        raise InputError(str(path), "file", str(error), allowed, advice) from None


def _whole(path: Path, load: Array) -> GivenLoads:
    given = ~np.isnan(load)
    if not given.any():
        raise InputError(str(path), "file", "no loads", "a row for every contact", EXAMPLE)
    named = given.any(axis=0)
    gaps = np.argwhere(~given & named)
    if gaps.size:
        ball, side = (int(k) for k in gaps[0])
        value = f"no load of ball {ball + 1} {SIDES[side]}" + (f" and {len(gaps) - 1} more" if len(gaps) > 1 else "")
        advice = "write 0 for a contact that carries nothing, or leave out the whole flank"
        raise InputError(str(path), "rows", value, "every ball on every flank that is named", advice)
    flanks = tuple(SIDES[k] for k in np.flatnonzero(named))
    return GivenLoads(np.where(given, load, 0.0), flanks)
