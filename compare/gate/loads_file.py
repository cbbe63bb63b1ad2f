"""Contact loads as a CSV file with the columns ball, flank, newton, and where the balls are: read and written."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rollbench.comparison.errors import InputError
from rollbench.comparison.writing import replace_file
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene

COLUMNS = ("ball", "flank", "newton")
#: Where a ball is; given both, they say which ball a row is of, however the file numbers it.
PLACE = ("azimuth_deg", "z_mm")
#: Largest file [bytes]: four loads of 100 000 balls.
MAX_BYTES = 16_000_000
EXAMPLE = "write a first line ball,flank,newton and rows such as 1,SL,225.4"


@dataclass(frozen=True)
class GivenLoads:
    """Loads ``(n, 4)`` [N] in the order of SIDES, zero on the flanks that the file does not name, the named flanks, and
    how many balls have another number in the file than in the scene."""

    load: Array
    flanks: tuple[str, ...]
    renumbered: int = 0


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


def write_loads(path: Path, rows: Sequence[Mapping[str, str]]) -> str:
    """Write rows of `loads_csv`, of several sets with a column ``set`` first; a line that says so."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    replace_file(path, text.getvalue())
    return f"wrote {path}: {len(rows)} contact loads, for: rollbench check SCENE --loads {path}"


@dataclass(frozen=True)
class Rows:
    """A CSV file: its headings in small letters, whether numbers have a decimal comma, its rows with their line numbers."""

    heads: tuple[str, ...]
    decimal_comma: bool
    rows: tuple[tuple[int, dict[str, str]], ...]

    @classmethod
    def read(cls, path: Path, columns: Sequence[str], example: str) -> Rows:
        """A file with some columns, in any order, among others, separated by commas, semicolons or tabs (a decimal comma is
        read where they are not commas). Raises InputError, with an example."""
        lines = _text(path).splitlines()
        if not lines or not lines[0].strip():
            raise InputError(str(path), "line 1", "nothing", ", ".join(columns), example)
        separator = next((c for c in ";\t" if c in lines[0]), ",")
        rows = csv.reader(lines, delimiter=separator)
        heads = tuple(head.strip().lower() for head in next(rows))
        for name in columns:
            if name.lower() not in heads:
                raise InputError(str(path), "line 1", lines[0], f"a column {name}", example)
        cells = ((number, [cell.strip() for cell in row]) for number, row in enumerate(rows, 2))
        kept = tuple((number, dict(zip(heads, row, strict=False))) for number, row in cells if any(row))
        return cls(heads, separator != ",", kept)


def read_loads(path: Path, balls: int, scene: Scene | None = None) -> GivenLoads:
    """Loads of a file for a scene of ``balls`` balls.

    scene: whose balls are told by azimuth and station where the file has both columns of `PLACE`, else by their numbers.

    Every ball must be given on every flank that is named, 0 where it carries nothing: a row
    that was lost is not taken for a contact without load. Raises InputError.
    """
    given = Rows.read(path, COLUMNS, EXAMPLE)
    heads, decimal_comma = given.heads, given.decimal_comma
    find = None if scene is None or not set(PLACE) <= set(heads) else _Places(scene)
    load = np.full((balls, len(SIDES)), np.nan)
    cases, renumbered = set(), set()
    for number, cells in given.rows:
        cases.add(cells.get("case", ""))
        if len(cases) > 1:
            advice = "a scene is one load case: split the file, or delete the others"
            raise InputError(str(path), f"line {number}: case", cells["case"], "one case", advice)
        own = cells.get("ball", "")
        if find is not None:
            cells["ball"] = find.number(path, number, cells, decimal_comma=decimal_comma)
            renumbered |= {own} if own != cells["ball"] else set()
        ball, side, force = _row(path, number, cells, balls, decimal_comma=decimal_comma)
        if not np.isnan(load[ball, side]):
            value = f"ball {ball + 1} {SIDES[side]} again"
            raise InputError(str(path), f"line {number}", value, "each contact once", "keep one of the rows")
        load[ball, side] = force
    return replace(_whole(path, load), renumbered=len(renumbered))


class _Places:
    """Which ball of a scene is at an azimuth and a station."""

    def __init__(self, scene: Scene) -> None:
        layout = ball_layout(scene)
        self._azimuth, self._z = layout.azimuth, layout.z
        self._pitch, self._near = scene.track.pitch_radius, scene.balls.radius

    def number(self, path: Path, line: int, cells: Mapping[str, str], *, decimal_comma: bool) -> str:
        """Number, from 1, of the ball at the place of a row. Raises InputError where none is within a ball's radius."""
        values = []
        for name in PLACE:
            text = cells.get(name, "")
            values.append(number_of(text, decimal_comma=decimal_comma))
            if not np.isfinite(values[-1]):
                where = f"line {line}: {name}"
                raise InputError(str(path), where, text or "nothing", "a number", "or leave the column out")
        turn = np.angle(np.exp(1j * (self._azimuth - np.radians(values[0]))))
        away = np.hypot(self._pitch * turn, self._z - 1e-3 * values[1])
        ball = int(away.argmin())
        if away[ball] > self._near:
            found = f"{values[0]:g} deg, {values[1]:g} mm"
            allowed = f"the place of a ball; the nearest, {ball + 1}, is {1e3 * away[ball]:.3g} mm away"
            advice = "places are those of rollbench solve SCENE --loads-csv FILE; without the columns, numbers count"
            raise InputError(str(path), f"line {line}: {PLACE[0]}, {PLACE[1]}", found, allowed, advice)
        return str(ball + 1)


def number_of(text: str, *, decimal_comma: bool) -> float:
    """A number; nan for anything else."""
    try:
        return float(text.replace(",", ".") if decimal_comma else text)
    except ValueError:
        return float("nan")


def _text(path: Path) -> str:
    allowed, advice = "a readable CSV file", "check the path"
    try:
        if not path.is_file():
            raise InputError(str(path), "file", "no regular file" if path.exists() else "no such file", allowed, advice)
        if path.stat().st_size > MAX_BYTES:
            most = f"up to {MAX_BYTES // 1_000_000} MB"
            raise InputError(str(path), "file", "a larger one", most, "is this a table of loads?")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(str(path), "file", error.strerror or str(error), allowed, advice) from None
    except ValueError as error:
        raise InputError(str(path), "file", str(error), allowed, "save the table as CSV in UTF-8") from None


def _row(path: Path, number: int, cells: dict[str, str], balls: int, *, decimal_comma: bool) -> tuple[int, int, float]:
    """Indices of ball and side, and the load [N], of a row."""
    where = f"line {number}"
    ball, flank, text = (cells.get(name, "") for name in COLUMNS)
    if not (ball.isascii() and ball.isdecimal() and len(ball) < 10 and 1 <= int(ball) <= balls):
        first = "the file's seem to begin with 0: " if ball == "0" else ""
        advice = f"{first}balls are numbered from 1, all balls of start 1 first"
        raise InputError(str(path), f"{where}: ball", ball or "nothing", f"a ball number from 1 to {balls}", advice)
    if flank.upper() not in SIDES:
        advice = "SL and SR: left and right flank of the screw, NL and NR: of the nut"
        raise InputError(str(path), f"{where}: flank", flank or "nothing", ", ".join(SIDES), advice)
    force = number_of(text, decimal_comma=decimal_comma)
    if not 0.0 <= force < float("inf"):
        advice = "write the size of the contact force in newton, 0 where contact is lost, without unit"
        raise InputError(str(path), f"{where}: newton", text or "nothing", "a number from 0", advice)
    return int(ball) - 1, SIDES.index(flank.upper()), force


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
