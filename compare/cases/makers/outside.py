"""Computed values compared with values that makers, programs and textbooks print or measured; bias and scatter of many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.cases.makers.tables import Table as Printed
from rollbench.compare.cases.makers.tables import half_step
from rollbench.compare.evidence import by_table, evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.reports.content import Cell, Quantity, Table

MAKER, MEASURED, PROGRAM = "printed by a maker", "measured", "another program"


class Band(NamedTuple):
    """A computed value, with its range due to inputs that are rounded or not printed."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float], slack: float = 0.0) -> Band:
        """Return the first value with the range of all values, widened by ``slack`` at each end."""
        every = [float(x) for x in values]
        return cls(every[0], min(every) - slack, max(every) + slack)

    @classmethod
    def within(cls, value: float, share: float) -> Band:
        """Return a value with a range of plus or minus a share of it."""
        return cls.of((value,), abs(value) * share)


@dataclass(frozen=True)
class Outside:
    """One value that a maker, program or textbook prints or measures, with the computed value.

    quantity, law: what it is, and what computes it; maker, item, cls, origin: who prints it, for which part, in which
    class, and where; value, rounding: in ``unit``, and half of its last digit's step; computed: in the same unit;
    scale: reference value of the percentages (0: the value itself); practice: computed value after the maker's
    practice; left: reason why it is not judged, such as a formula in disguise or a misprint, else empty.
    """

    quantity: str
    law: str
    maker: str
    item: str
    cls: str
    origin: str
    unit: str
    value: float
    rounding: float
    computed: Band
    scale: float = 0.0
    practice: float | None = None
    left: str = ""

    @property
    def group(self) -> str:
        """Group of values that share a row: one maker, or all programs and textbooks compared with one model."""
        return self.maker if self.law != "the model of its table" or self.cls == MAKER else "programs and textbooks"

    @property
    def verdict(self) -> str:
        """Position of the printed interval relative to the computed band, or the reason why it is not judged."""
        if self.left:
            return self.left
        if self.value + self.rounding < self.computed.low:
            return "below the band"
        return "above the band" if self.value - self.rounding > self.computed.high else "in the band"

    @property
    def error_percent(self) -> float:
        """Error of the computed value, in per cent of the outside one or of its scale."""
        return float(error_percent(self.computed.value, self.value, self.scale or None))


def of_row(
    source: Printed,
    row: Mapping[str, str],
    line: str,
    column: str,
    what: tuple[str, str, str, str],
    computed: Band,
    **others: Any,
) -> Outside:
    """Return one printed number of a table row as an outside value.

    ``what``: quantity, law, item and unit; ``line``: column with the line of the row.
    """
    quantity, law, item, unit = what
    fields: dict[str, Any] = {"maker": source.head["maker"], "rounding": half_step(row[column])} | others
    if source.misprinted(f"{item} {quantity}"):
        fields["left"] = "a misprint"
    origin, value = f"{source.name}.csv, line {row[line]} of its origin", source.number(row[column])
    return Outside(
        quantity=quantity,
        law=law,
        item=item,
        cls=source.head["class"],
        origin=origin,
        unit=unit,
        value=value,
        computed=computed,
        **fields,
    )


@dataclass(frozen=True)
class Standing:
    """Statistics of the differences between computed values and printed or measured ones of one kind."""

    number: int
    bias: float
    scatter: float
    inside: int
    width: float
    practice: float | None


def bias_and_scatter(found: Sequence[Outside]) -> Standing | None:
    """Return bias and scatter of the values that are judged; None if there are none."""
    judged = [x for x in found if not x.left]
    if not judged:
        return None
    errors = np.array([x.error_percent for x in judged])
    widths = [float(error_percent(x.computed.high, x.computed.low, x.scale or x.computed.value)) for x in judged]
    after = [float(error_percent(x.practice, x.value)) for x in judged if x.practice is not None]
    inside = sum(x.verdict == "in the band" for x in judged)
    mean = float(np.mean(after)) if after else None
    return Standing(len(judged), float(errors.mean()), float(errors.std()), inside, float(np.median(widths)), mean)


def group_values(found: Iterable[Outside], *keys: str) -> dict[tuple[str, ...], list[Outside]]:
    """Return the values grouped by some of their fields, in order of first occurrence."""
    groups: dict[tuple[str, ...], list[Outside]] = {}
    for one in found:
        groups.setdefault(tuple(getattr(one, key) for key in keys), []).append(one)
    return groups


BIAS = Quantity("bias", "bias", "%", "+.1f")

SCATTER = Quantity("scatter", "scatter", "%", ".1f")

NUMBER = Quantity("number", "outside values", "", ".0f")


def by_quantity(found: Sequence[Outside]) -> dict[str, dict[Quantity, Cell]]:
    """Return the number of outside values, bias and scatter, by quantity."""
    rows = {key: bias_and_scatter(values) for (key,), values in group_values(found, "quantity").items()}
    return {key: {NUMBER: s.number, BIAS: s.bias, SCATTER: s.scatter} for key, s in rows.items() if s is not None}


def summary(found: Sequence[Outside]) -> Table:
    """Return the table of bias and scatter, with one row for each quantity, law and maker."""
    rows: list[dict[Quantity | str, Cell]] = []
    without: list[str] = []
    for (quantity, law, group), values in group_values(found, "quantity", "law", "group").items():
        left = [x.left for x in values if x.left]
        words = "; ".join(f"{left.count(why)}: {why}" for why in dict.fromkeys(left))
        s = bias_and_scatter(values)
        if s is None:
            without.append(f"{quantity} of {group}, {words}")
            continue
        rows.append(
            {
                "quantity": quantity,
                "against": group,
                "computed by": law,
                NUMBER: s.number,
                BIAS: s.bias,
                SCATTER: s.scatter,
                Quantity("inside", "in their band", "", ".0f"): s.inside,
                Quantity("width", "width of the band, median", "%", ".1f"): s.width,
                Quantity("practice", "bias of 80 % of it", "%", "+.1f"): s.practice,
                "not judged": words,
            }
        )
    note = (
        "Bias and scatter: mean and standard deviation of the errors of the computed value. Bands carry the rounding of "
        "what is printed through, and the usual range of what is not. Errors of clearances are in per cent of the "
        "displacement under the measuring load, those of contact loads by CalculiX of the mean load. 80 %: what makers "
        f"advise to take of a computed rigidity of a nut. Not judged at all: {'; '.join(without)}."
    )
    return Table.of("outside-summary", "Outside values by quantity, law and maker", rows, note)


def all_values(found: Sequence[Outside]) -> Table:
    """Return the table of all outside values, one row each."""
    rows: list[dict[Quantity | str, Cell]] = [
        {
            "quantity": x.quantity,
            "maker": x.maker,
            "class": x.cls,
            "item": x.item,
            Quantity("value", "value", "", "g6"): x.value,
            "unit": x.unit,
            Quantity("computed", "computed", "", "g6"): x.computed.value,
            Quantity("low", "band from", "", "g6"): x.computed.low,
            Quantity("high", "band to", "", "g6"): x.computed.high,
            Quantity("error", "error", "%", ".2f"): x.error_percent,
            "verdict": x.verdict,
            "law": x.law,
            "origin": x.origin,
        }
        for x in found
    ]
    note = (
        "Makers' tables stand in compare/cases/makers/tables; the first lines of each name repository, commit and file "
        "of its origin."
    )
    return Table.of("outside", "Outside values beside the computed ones", rows, note)


#: Tables of the external sources that are judged here: who, and of which class. Those of THK stand among the nuts.
PRINTED = {
    "external-masta": ("MASTA", PROGRAM),
    "external-nsk": ("NSK's programs", PROGRAM),
    "external-contact": ("CONTACT", PROGRAM),
    "external-vm63": ("Ansys", PROGRAM),
    "external-harris": ("Jones and Harris", PROGRAM),
    "external-sjovall": ("NSK", MAKER),
    "external-gmn": ("GMN", MAKER),
}

#: Quantity of an entry by its unit; those without unit are ratios of loads.
QUANTITIES = {
    "um": "displacement",
    "mrad": "displacement",
    "mm": "contact patch",
    "deg": "contact patch",
    "MPa": "pressure",
    "N": "contact load",
    "": "contact load",
    "balls": "contact load",
    "N/um": "rigidity",
    "N mm": "contact patch",
    "1e6 rev": "life",
}

#: Entries whose unit says something else.
OTHERS = {("external-contact", "approach"): "displacement"}


def printed_elsewhere(study: Study) -> Iterator[Outside]:
    """Yield every number of the tables in `PRINTED` that is computed; open ones are not judged."""
    for name, (maker, cls) in PRINTED.items():
        if name not in by_table():
            continue
        for e in evidence(study, name):
            p = e.printed
            if p.value is None or e.value is None:
                continue
            patch = "contact patch" if name == "external-contact" and not p.unit else QUANTITIES[p.unit]
            quantity = OTHERS.get((name, p.key), patch)
            rounding = p.tolerance if p.cls == "hard" else max(p.value - (p.low or p.value), (p.high or p.value) - p.value)
            yield Outside(
                quantity,
                "the model of its table",
                maker,
                f"{name}: {p.label}",
                cls,
                p.place,
                p.unit,
                p.value,
                rounding,
                Band.of((e.value,)),
                left="" if p.cls in ("hard", "band") else "open: what it rests on is not printed",
            )


def calculix(study: Study) -> Iterator[Outside]:
    """Yield CalculiX's contact loads, extrapolated over its meshes, with those of the 3D reference.

    Errors are in per cent of the mean load.
    """
    from rollbench.compare.studies.crosscheck.results import contact_rows, load_results, result_path, shipped
    from rollbench.compare.studies.crosscheck.study import STUDIES

    for name in STUDIES:
        data, ours = load_results(shipped(), name), study.reference(name)
        if data is None or ours is None:
            continue
        mean = float(ours.mean)
        for row in contact_rows(data, ours):
            off = 0.01 * row.ours_percent * mean
            words = ("contact load", "3D reference", "CalculiX", f"{name}: ball {row.ball} {row.side}", PROGRAM)
            value = (row.theirs, 0.01 * row.theirs_percent * mean, Band.of((row.ours,), off), mean)
            yield Outside(
                *words, f"stored run, compare/studies/crosscheck/{result_path(shipped(), name).name}", "N", *value
            )
