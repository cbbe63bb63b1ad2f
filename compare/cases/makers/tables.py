"""Reader of makers' printed tables: CSV files that begin with ``# key: value`` (maker, origin, format)."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent / "tables"
#: Factors from the printed units to SI.
UNITS = {"N": 1.0, "kN": 1e3, "kgf": 9.80665, "daN": 10.0, "N/um": 1e6, "kgf/um": 9.80665e6}


@dataclass(frozen=True)
class Table:
    """A table printed by a maker, from one CSV file.

    ``name``: name of the file without ``.csv``; ``head``: texts of the file's first lines by key (maker, origin, class,
    number format, remarks); ``rows``: for each row, the printed texts by name of the column.
    """

    name: str
    head: Mapping[str, str]
    rows: tuple[Mapping[str, str], ...]

    def number(self, text: str) -> float:
        """Convert a printed text to a number, with the table's decimal and thousands separators."""
        plain = re.sub(r"[\s\u00a0]", "", text).replace(self.head.get("thousands", " "), "")
        return float(plain.replace(self.head.get("decimal", "."), "."))

    def unit(self, key: str) -> float:
        """Return the factor to SI of a unit that the table's head states; ``key``: name of the line, as "load_unit"."""
        return UNITS[self.head[key]]

    def misprinted(self, what: str) -> bool:
        """Return whether the table's head lists an entry as a misprint.

        ``what``: name of the part, or name of the part and quantity, such as "SFE1632-3 rigidity". A name that is listed
        without a quantity stands for all quantities of the part.
        """
        return any(what.startswith(known) for known in self.head.get("misprints", "-").split("; "))


@cache
def read_table(name: str) -> Table:
    """Read a maker's table from the file ``tables/NAME.csv``; further calls return the same object."""
    lines = (FOLDER / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    remarks = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    return Table(name, {key: text for key, _, text in remarks if key != "note"}, tuple(body))


def read_tables(prefix: str) -> list[Table]:
    """Read all makers' tables whose file name begins with ``prefix``, sorted by name."""
    return [read_table(path.stem) for path in sorted(FOLDER.glob(f"{prefix}*.csv"))]


def half_step(text: str) -> float:
    """Return half a step of the last nonzero digit of a printed number: 5 for ``"2 150"``, 0.005 for ``"0.14"``."""
    plain = "".join(text.split()).replace(",", ".").lstrip("+-")
    places = len(plain.partition(".")[2])
    zeros = 0 if places else len(plain) - len(plain.rstrip("0"))
    return float(0.5 * 10.0 ** (zeros - places))
