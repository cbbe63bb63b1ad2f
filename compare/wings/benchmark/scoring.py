"""The score of a program: its contact loads, and angles, approaches and pressures where it gives them, against the answers.

Tolerances: of a load the uncertainty of the answer and `LOAD` per cent of the problem's mean load; of an approach and of a
pressure `SHAPE` per cent of it and what the load's tolerance changes in it (exponents 2/3 and 1/3 of Hertz); of an angle
`ANGLE` degrees. Those three are judged where the answer's load is `HEAVY` of the mean load and more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.loads_file import Rows, comma_or, number_of
from rollbench.comparison.measure import error_percent
from rollbench.comparison.wings.benchmark.answers import BESIDE, Answers, Contact, mean_load
from rollbench.comparison.wings.benchmark.problems import NAME, problem

#: Tolerances: load [% of the mean load], approach and pressure [% of themselves], angle [deg].
LOAD, SHAPE, ANGLE = 1.0, 3.0, 0.5
#: Part of the mean load from which on angle, approach and pressure are judged.
HEAVY = 0.1
#: Exponent of the load in approach and pressure.
EXPONENT = {"approach_um": 2.0 / 3.0, "pressure_MPa": 1.0 / 3.0}
NEEDED = ("problem", "contact", "load_N")
EXAMPLE = "write a first line problem,contact,load_N and rows such as two-balls,1 SL,498.1"
#: Contacts that are named of those beyond their tolerance, and of those that are missing.
NAMED = 5


@dataclass(frozen=True)
class Given:
    """A contact in a scored file: its load [N], and its other values by column."""

    load: float
    beside: Mapping[str, float]


@dataclass(frozen=True)
class Miss:
    """A value beyond its tolerance: contact, column, value, answer, tolerance."""

    contact: str
    column: str
    value: float
    answer: float
    tolerance: float

    @property
    def times(self) -> float:
        """Its error over the tolerance."""
        return abs(self.value - self.answer) / self.tolerance

    @property
    def text(self) -> str:
        """In words."""
        name, _, unit = self.column.rpartition("_")
        return f"{self.contact}: {name} {self.value:.5g} {unit}, answer {self.answer:.5g} +- {self.tolerance:.2g}"


@dataclass(frozen=True)
class Score:
    """Of one problem: contacts that carry load in the answer; error of the worst load [% of the mean load], its contact;
    missing contacts; values beyond their tolerance, the worst first."""

    problem: str
    contacts: int
    worst_percent: float
    worst: str
    missing: tuple[str, ...]
    misses: tuple[Miss, ...]

    @property
    def passed(self) -> bool:
        """Whether every contact is there and within its tolerance."""
        return not self.missing and not self.misses

    def as_json(self) -> dict[str, Any]:
        """JSON-ready."""
        beyond = [vars(m) for m in self.misses]
        values = {k: v for k, v in vars(self).items() if k not in ("missing", "misses")}
        return values | {"missing": list(self.missing), "beyond": beyond, "passed": self.passed}


def score(name: str, answers: Answers, given: Mapping[str, Given]) -> Score:
    """The score of one problem. A contact without load in the answer may be left out."""
    mean = mean_load(answers)
    missing = tuple(c for c, a in answers.items() if a.load > 0.0 and c not in given)
    errors = {c: float(error_percent(given[c].load, a.load, mean)) for c, a in answers.items() if c in given}
    worst = max(errors, key=lambda c: abs(errors[c]), default="")
    misses = [m for c, a in answers.items() if c in given for m in _misses(c, a, given[c], mean)]
    loaded = sum(a.load > 0.0 for a in answers.values())
    order = tuple(sorted(misses, key=lambda m: -m.times))
    return Score(name, loaded, errors.get(worst, 0.0), worst, missing, order)


def _misses(contact: str, answer: Contact, given: Given, mean: float) -> list[Miss]:
    """Values of a contact beyond their tolerances."""
    loads = answer.uncertainty + 0.01 * LOAD * mean
    judged = [("load_N", given.load, answer.load, loads)]
    if answer.load >= HEAVY * mean:
        for column, value in given.beside.items():
            expected = answer.beside[column]
            share = EXPONENT.get(column, 0.0) * loads / answer.load + 0.01 * SHAPE
            judged.append((column, value, expected, ANGLE if column == "angle_deg" else share * expected))
    return [Miss(contact, *j) for j in judged if not abs(j[1] - j[2]) <= j[3]]


def read(path: Path, answers: Mapping[str, Answers], only: str = "") -> dict[str, dict[str, Given]]:
    """Contacts of a file by problem; only: the one problem whose rows count.

    Raises InputError for an unknown problem or contact, one that stands twice, and a value that is no number.
    """
    file = Rows.read(path, NEEDED, EXAMPLE, tuple(BESIDE))
    out: dict[str, dict[str, Given]] = {}
    for line, cells in file.rows:
        name = problem(cells.get("problem", "")).name
        if only and name != only:
            continue
        contact = " ".join(cells.get("contact", "").upper().split())
        where = f"line {line}: contact"
        if contact not in answers[name]:
            allowed = f"ball 1 to {len(answers[name]) // 4} and flank, such as 1 SL"
            raise InputError(str(path), where, contact or "nothing", allowed, "flanks are SL, SR, NL and NR")
        if contact in out.setdefault(name, {}):
            raise InputError(str(path), where, f"{name}, {contact} again", "each contact once", "keep one of the rows")
        values = {}
        for column in ("load_N", *BESIDE):
            text = cells.get(column.lower(), "")
            if not text and column != "load_N":
                continue
            values[column] = number_of(text, decimal_comma=file.decimal_comma)
            if not 0.0 <= values[column] < float("inf"):
                advice = comma_or("a contact that is lost has a load of 0", text)
                raise InputError(str(path), f"line {line}: {column}", text or "nothing", "a number from 0", advice)
        out[name][contact] = Given(values.pop("load_N"), values)
    if not out:
        raise InputError(str(path), "rows", "no contacts", f"contacts of {only or NAME}", EXAMPLE)
    return out


def named(names: Sequence[str]) -> str:
    """The first names, and how many there are beside them."""
    rest = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {rest} more" if rest > 0 else "")
