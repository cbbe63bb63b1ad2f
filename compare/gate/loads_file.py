"""Contact loads of another program: a CSV file with the columns ball, flank, newton."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compare.errors import InputError
from meshes.arrays import Array
from meshes.parts import SIDES

COLUMNS = ("ball", "flank", "newton")
#: Largest file [bytes]: four loads of 100 000 balls.
MAX_BYTES = 16_000_000
EXAMPLE = "write a first line ball,flank,newton and rows such as 1,SL,225.4"


@dataclass(frozen=True)
class GivenLoads:
    """Loads ``(n, 4)`` [N] in the order of SIDES, zero on the flanks that the file does not name, and the named flanks."""

    load: Array
    flanks: tuple[str, ...]


def read_loads(path: Path, balls: int) -> GivenLoads:
    """Loads of a file for a scene of ``balls`` balls.

    Columns are separated by commas, semicolons or tabs (a decimal comma is read where they are not commas), in any order;
    further columns are ignored. Every ball must be given on every flank that is named, 0 where it carries nothing: a row
    that was lost is not taken for a contact without load. Raises InputError.
    """
    lines = _text(path).splitlines()
    if not lines or not lines[0].strip():
        raise InputError(str(path), "line 1", "nothing", ", ".join(COLUMNS), EXAMPLE)
    separator = next((c for c in ";\t" if c in lines[0]), ",")
    rows = csv.reader(lines, delimiter=separator)
    heads = [head.strip().lower() for head in next(rows)]
    for name in COLUMNS:
        if name not in heads:
            raise InputError(str(path), "line 1", lines[0], f"a column {name}", EXAMPLE)
    load = np.full((balls, len(SIDES)), np.nan)
    for number, row in enumerate(rows, 2):
        if not any(cell.strip() for cell in row):
            continue
        cells = dict(zip(heads, (cell.strip() for cell in row), strict=False))
        ball, side, force = _row(path, number, cells, balls, decimal_comma=separator != ",")
        if not np.isnan(load[ball, side]):
            value = f"ball {ball + 1} {SIDES[side]} again"
            raise InputError(str(path), f"line {number}", value, "each contact once", "keep one of the rows")
        load[ball, side] = force
    return _whole(path, load)


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
        advice = "balls are numbered from 1, all balls of start 1 first"
        raise InputError(str(path), f"{where}: ball", ball or "nothing", f"a ball number from 1 to {balls}", advice)
    if flank.upper() not in SIDES:
        advice = "SL and SR: left and right flank of the screw, NL and NR: of the nut"
        raise InputError(str(path), f"{where}: flank", flank or "nothing", ", ".join(SIDES), advice)
    try:
        force = float(text.replace(",", ".") if decimal_comma else text)
    except ValueError:
        force = float("nan")
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
