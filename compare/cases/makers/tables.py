"""The tables as printed: comma-separated files with their origin in lines ``# key: value`` before the headings."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent / "tables"
#: SI units of what the tables print.
UNITS = {"N": 1.0, "kN": 1e3, "kgf": 9.80665, "daN": 10.0, "N/um": 1e6, "kgf/um": 9.80665e6}


@dataclass(frozen=True)
class Table:
    """One file of a maker's table: ``head`` (maker, origin, class, number format, remarks) and ``rows`` of texts."""

    name: str
    head: Mapping[str, str]
    rows: tuple[Mapping[str, str], ...]

    def number(self, text: str) -> float:
        """Return a printed number: blanks between thousands, and the table's signs for decimals and thousands."""
        plain = re.sub(r"[\s\u00a0]", "", text).replace(self.head.get("thousands", " "), "")
        return float(plain.replace(self.head.get("decimal", "."), "."))

    def unit(self, key: str) -> float:
        """Return the factor from the table's unit of load or rigidity to SI."""
        return UNITS[self.head[key]]

    def misprinted(self, what: str) -> bool:
        """Return whether an entry is listed as a misprint, by itself or with its whole row."""
        return any(what.startswith(known) for known in self.head.get("misprints", "-").split("; "))


@cache
def read_table(name: str) -> Table:
    """Return the file ``tables/NAME.csv``, read once."""
    lines = (FOLDER / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    remarks = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    return Table(name, {key: text for key, _, text in remarks if key != "note"}, tuple(body))


def tables(prefix: str) -> list[Table]:
    """Return all files whose name begins so, sorted."""
    return [read_table(path.stem) for path in sorted(FOLDER.glob(f"{prefix}*.csv"))]


def half_step(text: str) -> float:
    """Return half a step of the last nonzero printed digit: 5 for ``"2 150"``, 0.005 for ``"0.14"``."""
    plain = "".join(text.split()).replace(",", ".").lstrip("+-")
    places = len(plain.partition(".")[2])
    zeros = 0 if places else len(plain) - len(plain.rstrip("0"))
    return float(0.5 * 10.0 ** (zeros - places))
