"""Makers' catalogues: the printed tables of ball nuts and bearings, and a nut or bearing by its catalogue name.

The tables are CSV files that begin with lines ``# key: value`` (maker, origin, format). No model reads what they print.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from shlex import quote
from typing import NamedTuple

from rollbench.compare import files
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.template import BEYOND, PER_LEAD, STOCK

#: Folder of the tables in the package.
FOLDER = "scenes/maker_tables"

#: Factors from the printed units to SI.
UNITS = {"N": 1.0, "kN": 1e3, "kgf": 9.80665, "daN": 10.0, "N/um": 1e6, "kgf/um": 9.80665e6}

#: (Pitch diameter - root diameter)/ball diameter, for a ball at 45 deg in a gothic arch of usual conformity.
DEPTH = 1.03

#: Largest number of rows that the error for an ambiguous name lists.
LISTED = 6


@dataclass(frozen=True)
class MakerTable:
    """A table printed by a maker, from one CSV file.

    ``name``: name of the file without ``.csv``; ``header``: texts of the file's first lines by key (maker, origin, class,
    number format, remarks); ``rows``: for each row, the printed texts by name of the column.
    """

    name: str
    header: Mapping[str, str]
    rows: tuple[Mapping[str, str], ...]

    def parse_number(self, text: str) -> float:
        """Convert a printed text to a number, with the decimal and thousands separators that the table's header states."""
        plain = re.sub(r"[\s\u00a0]", "", text).replace(self.header.get("thousands", " "), "")
        return float(plain.replace(self.header.get("decimal", "."), "."))

    def relative_rounding(self, text: str) -> float:
        """Return half a unit of the last nonzero digit of a printed number, divided by the number; ``text``: as printed."""
        return half_step_of_last_digit(text) / self.parse_number(text)

    def unit_factor(self, key: str) -> float:
        """Return the factor from a printed unit to SI; ``key``: header key of that unit, such as "load_unit"."""
        return UNITS[self.header[key]]

    def is_listed_as_misprint(self, what: str) -> bool:
        """Return whether the header of the table lists a printed value as a misprint.

        ``what``: name of a nut or bearing, alone or with a quantity, such as "SFE1632-3 rigidity". A name that is listed
        without a quantity stands for all its quantities.
        """
        return any(f"{what} ".startswith(f"{known} ") for known in self.header.get("misprints", "-").split("; "))


@cache
def read_maker_table(name: str) -> MakerTable:
    """Read a maker's table from the file ``NAME.csv``; ``name``: NAME. Further calls return the same object."""
    lines = files.shipped_text(f"{FOLDER}/{name}.csv").splitlines()
    remarks = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    return MakerTable(name, {key: text for key, _, text in remarks if key != "note"}, tuple(body))


def read_maker_tables(prefix: str) -> list[MakerTable]:
    """Read all makers' tables whose file name begins with ``prefix``, such as "nuts-", sorted by name."""
    return [read_maker_table(path.stem) for path in sorted(files.shipped_path(FOLDER).glob(f"{prefix}*.csv"))]


def half_step_of_last_digit(text: str) -> float:
    """Return half a unit of the last nonzero digit of a printed number, such as 5 for ``"2 150"``, 0.005 for ``"0.14"``."""
    plain = "".join(text.split()).replace(",", ".").lstrip("+-")
    places = len(plain.partition(".")[2])
    zeros = 0 if places else len(plain) - len(plain.rstrip("0"))
    return float(0.5 * 10.0 ** (zeros - places))


class Circuits(NamedTuple):
    """Ball circuits of a nut in a catalogue: their number, the loaded turns of each, and whether each has its own start."""

    number: int
    turns: float
    on_starts: bool = False


def read_circuits(row: Mapping[str, str]) -> Circuits:
    """Return the ball circuits of a nut in a catalogue.

    ``row``: texts of the nut's row, by column. Makers print the number of turns in the nut's name: ``T4``, four circuits of
    one turn, or ``K4``, one circuit of four turns; as a product ``2x2.5`` (also without the x); as circuits and turns in
    separate columns; or as ``1,2x4``, 1.2 turns on each of four starts. One number alone: the turns of one circuit.
    """
    circuits, turns = row["circuits"], row["turns"].replace(",", ".")
    if "of the name" in turns:
        return Circuits(int(circuits), 1.0) if turns.startswith("T") else Circuits(1, float(circuits))
    if turns == "rows x turns":
        rows, each = circuits.split("x") if "x" in circuits else (circuits[0], circuits[1:])
        return Circuits(int(rows), float(each))
    if circuits == turns:  # 1x4: four circuits of one turn
        each, number = turns.split("x")
        return Circuits(int(number), float(each))
    if circuits:
        return Circuits(int(circuits), float(turns))
    each, _, starts = turns.partition("x")
    return Circuits(int(starts or 1), float(each), on_starts=bool(starts))


def ball_and_pitch_diameter(source: MakerTable, row: Mapping[str, str]) -> tuple[float, float]:
    """Return the diameters of the balls and of the pitch circle [mm] of a nut in a catalogue.

    ``source``: table of the catalogue; ``row``: texts of the nut's row, by column. If the ball diameter is not printed, it
    is that stock size, of those up to a usual part of the lead, which fits pitch and root diameter best. If the pitch
    diameter is not printed, it is the nominal diameter plus an amount that is usual for the ball diameter.
    """
    pitch = source.parse_number(row["pitch_mm"]) if row["pitch_mm"] else 0.0
    if row["ball_mm"]:
        ball = source.parse_number(row["ball_mm"])
    else:
        fits = (pitch - source.parse_number(row["root_mm"])) / DEPTH
        largest = max(STOCK[0], 1.01 * PER_LEAD * source.parse_number(row["lead_mm"]))
        ball = min((known for known in STOCK if known <= largest), key=lambda known: abs(known - fits))
    return ball, pitch or source.parse_number(row["diameter_mm"]) + 2.0 * BEYOND * ball


# --- nuts and bearings by their names


@dataclass(frozen=True)
class CataloguePart:
    """A row of a maker's table: a ball nut, or a bearing with one of its preloads.

    ``table``: the table; ``row``: printed texts by column; ``base``: the maker's name of the part, which several rows may
    share; ``label``: maker and a name that no other row has.
    """

    table: MakerTable
    row: Mapping[str, str]
    base: str
    label: str

    @property
    def maker(self) -> str:
        """Name of the maker."""
        return self.table.header["maker"]

    @property
    def is_nut(self) -> bool:
        """Whether it is a ball nut, not a bearing."""
        return "nut" in self.row

    @property
    def type(self) -> str:
        """Type of a nut: "single nut", "double nut" or "offset preload"; "bearing" for a bearing."""
        if not self.is_nut:
            return "bearing"
        return next((name for name in ("double nut", "offset preload") if name in self.row["type"]), "single nut")

    def number(self, column: str, factor: float = 1.0) -> float | None:
        """Return the number printed in a column, times ``factor``; None if nothing is printed."""
        text = self.row.get(column) or ""
        return factor * self.table.parse_number(text) if text else None

    def is_misprint(self, quantity: str) -> bool:
        """Return whether the table's header lists a quantity, such as "C0" or "rigidity", of this part as a misprint."""
        words = self.label.removeprefix(f"{self.maker} ") if not self.is_nut else self.base
        return self.table.is_listed_as_misprint(f"{words} {quantity}")


@cache
def nuts_in_catalogues() -> tuple[CataloguePart, ...]:
    """Return the ball nuts of all makers' tables."""
    found = []
    for table in read_maker_tables("nuts-"):
        same = Counter((row["nut"], row["type"]) for row in table.rows)
        singles = {row["nut"] for row in table.rows if row["type"] == "single nut"}
        for row in table.rows:
            label = f"{table.header['maker']} {row['nut']}"
            if row["type"] == "double nut" and row["nut"] in singles:
                label += " double nut"
            if same[row["nut"], row["type"]] > 1:
                label += f" ball {table.parse_number(row['ball_mm']):g}"
            found.append(CataloguePart(table, row, row["nut"], label))
    return tuple(found)


@cache
def bearings_in_catalogues() -> tuple[CataloguePart, ...]:
    """Return the bearings of all makers' tables, once for each printed preload."""
    found = []
    for table in read_maker_tables("nsk-") + read_maker_tables("snfa-"):
        for row in table.rows:
            words = [table.header["maker"], row["bearing"], row["preload_class"].strip("-")]
            if "arrangement" in row:
                words.append(arrangement_of_row(table, row))
            elif table.header["maker"] == "SNFA":
                words.insert(2, f"{row['angle_deg']} deg")
            found.append(CataloguePart(table, row, row["bearing"], " ".join(filter(None, words))))
    return tuple(found)


def arrangement_of_row(table: MakerTable, row: Mapping[str, str]) -> str:
    """Return the arrangement of bearings to which a row's preload and rigidity belong, such as "DBD"; a pair by default."""
    named = dict(entry.split("=") for entry in table.header.get("sets", "=DB").split("; "))
    return named[row.get("arrangement", "")]


def parts_named_like(words: str) -> list[CataloguePart]:
    """Return all nuts, then all bearings, whose maker, name and type contain every one of some words; case is ignored."""
    asked = [_plain(word) for word in words.split()]
    return [
        part
        for part in (*nuts_in_catalogues(), *bearings_in_catalogues())
        if all(word in _plain(f"{part.label} {part.type}") for word in asked)
    ]


def find_part(name: str, *, double: bool = False, argument: str = "like") -> CataloguePart:
    """Return the nut or bearing with a catalogue name.

    Parameters
    ----------
    name
        Name as in the catalogue, with or without the maker's; capital letters and blanks do not matter.
    double
        Whether to prefer the double nut where a maker prints a single and a double nut of the same name.
    argument
        Name of the argument that an error names.

    Returns
    -------
    CataloguePart
        The row of the maker's table.

    Raises
    ------
    InputError
        If no row, or more than one, has this name; it names these rows, or similar ones.
    """
    key, every = _plain(name), (*nuts_in_catalogues(), *bearings_in_catalogues())
    found = [p for p in every if key in map(_plain, (p.base, f"{p.maker} {p.base}", p.label, p.label.partition(" ")[2]))]
    wanted = [p for p in found if p.type in ("bearing", "double nut" if double else "single nut")] or found
    if len(wanted) > 1:
        wanted = [p for p in wanted if key in map(_plain, (p.label, p.label.partition(" ")[2]))] or wanted
    if len(wanted) == 1:
        return wanted[0]
    near = wanted or [p for p in every if key and key in _plain(p.label)]
    allowed = "a size such as 40x10, or a name of one nut or bearing that rollbench list --makers MAKER shows"
    if argument != "like":
        allowed = "words of a name, maker or type"
    if near:
        rows = ", ".join(f'"{p.label}"' for p in near[:LISTED])
        rest = f" ...; all {len(near)}: rollbench list --makers {quote(name)}" if len(near) > LISTED else ""
        raise ArgumentError(argument, f'"{name}"', allowed, f"write one of {rows}{rest}")
    advice = files.did_you_mean(files.similar_names(name, [p.label for p in every] + [p.base for p in every]))
    raise ArgumentError(
        argument, f'"{name}"', allowed, advice or "list those of a maker with: rollbench list --makers HIWIN"
    )


def preload_of_bearing(part: CataloguePart) -> float:
    """Return the printed preload [N] of a pair or set of bearings."""
    preload = part.number("preload_N") or part.number("preload_daN", UNITS["daN"])
    assert preload is not None
    return preload


def printed_values(part: CataloguePart) -> dict[str, str | float | None]:
    """Return what is printed of a nut or bearing, by names that end with the unit; None: not printed.

    The rigidity of a nut with several preloads is that at the highest one; of bearings, that of the pair or set.
    """
    if part.is_nut:
        load = 1e-3 * part.table.unit_factor("load_unit")
        circuits = read_circuits(part.row)
        return {
            "name": part.label,
            "type": part.type,
            "diameter_mm": part.number("diameter_mm"),
            "lead_mm": part.number("lead_mm"),
            "ball_mm": part.number("ball_mm"),
            "circuits": float(circuits.number),
            "turns": circuits.turns,
            "C_kN": part.number("C", load),
            "C0_kN": part.number("C0", load),
            "rigidity_N_per_um": rigidity_of_nut(part),
            "misprint": ", ".join(q for q in ("C", "C0", "rigidity") if part.is_misprint(q)) or None,
        }
    stiff = part.number("rigidity_N_per_um") or part.number("Ra_pair_daN_per_um", UNITS["daN"])
    return {
        "name": part.label,
        "bore_mm": part.number("bore_mm"),
        "outside_diameter_mm": part.number("outside_diameter_mm"),
        "angle_deg": float(part.row.get("angle_deg") or part.table.header["angle"]),
        "balls": part.number("balls"),
        "ball_mm": part.number("ball_diameter_mm"),
        "C_kN": part.number("Cr_kN") or part.number("C33_daN", 0.01),
        "C0_kN": part.number("C0r_kN") or part.number("C0_daN", 0.01),
        "preload_N": preload_of_bearing(part),
        "rigidity_N_per_um": stiff,
        "misprint": "rigidity" if part.is_misprint("rigidity") else None,
    }


def rigidity_of_nut(part: CataloguePart) -> float | None:
    """Return the printed rigidity of a nut [N/um], at its highest preload where it has several; None: not printed."""
    if part.row.get("rigidity"):
        return part.number("rigidity", 1e-6 * part.table.unit_factor("rigidity_unit"))
    return max(printed_rigidities_of_preloads(part), default=(0.0, None))[1]


def printed_rigidities_of_preloads(part: CataloguePart) -> list[tuple[float, float]]:
    """Return preloads [% of C] of a nut, each with the printed rigidity [N/um], by Rexroth's table of preloaded nuts.

    ``part``: a nut; the list is empty for other makers and for sizes that this table does not hold.
    """
    table = read_maker_table("rexroth-preload")
    rows = [r for r in table.rows if part.maker == table.header["maker"] and r["size"] == part.base]
    same = [r for r in rows if r["nut_kind"] == part.type]
    return [(table.parse_number(r["preload_percent_of_C"]), table.parse_number(r["Rnu_N_per_um"])) for r in same]


def _plain(text: str) -> str:
    """Return a name in small letters, without blanks, with a decimal point and x for the multiplication sign."""
    return re.sub(r"\s+", "", text.lower().replace("×", "x").replace(",", "."))
