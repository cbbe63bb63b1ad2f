"""One number that others print or measured, beside what is computed for it; bias and scatter of many."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.reports.records import Cell, Quantity, Table

MAKER, MEASURED, PROGRAM = "printed by a maker", "measured", "another program"


@dataclass(frozen=True)
class Outside:
    """One outside value.

    quantity, law: what it is, and what computes it; maker, item, cls, origin: who prints it, of what, as which class, and
    where; value, rounding: in ``unit``, and half of its last step; computed, low, high: the computed one and its band, from
    what is rounded or not printed, None where nothing can be computed; scale: what a difference is taken in per cent of
    (0: the value itself); practice: the computed value after the maker's practice; counts: whether it is judged, which a
    formula in disguise or a misprint is not, for the reason in ``why``.
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
    computed: float
    low: float
    high: float
    scale: float = 0.0
    practice: float | None = None
    counts: bool = True
    why: str = ""

    @property
    def verdict(self) -> str:
        """Where the printed interval lies against the computed band, or why it does not count."""
        if not self.counts:
            return self.why
        if self.value + self.rounding < self.low:
            return "below the band"
        return "above the band" if self.value - self.rounding > self.high else "in the band"

    @property
    def error_percent(self) -> float:
        """Error of the computed value, in per cent of the outside one or of its scale."""
        return float(error_percent(self.computed, self.value, self.scale or None))


@dataclass(frozen=True)
class Standing:
    """Outside values of one kind: number that counts, mean and standard deviation of the errors [%], how many lie in their
    bands, median width of the bands over the computed value [%], mean error [%] after the maker's practice."""

    number: int
    bias: float
    scatter: float
    inside: int
    width: float
    practice: float | None


def standing(found: Sequence[Outside]) -> Standing | None:
    """Bias and scatter of those that count; None where none does."""
    judged = [x for x in found if x.counts]
    if not judged:
        return None
    errors = np.array([x.error_percent for x in judged])
    widths = [float(error_percent(x.high, x.low, x.scale or x.computed)) for x in judged]
    after = [float(error_percent(x.practice, x.value)) for x in judged if x.practice is not None]
    inside = sum(x.verdict == "in the band" for x in judged)
    mean = float(np.mean(after)) if after else None
    return Standing(len(judged), float(errors.mean()), float(errors.std()), inside, float(np.median(widths)), mean)


def grouped(found: Iterable[Outside], *keys: str) -> dict[tuple[str, ...], list[Outside]]:
    """Values by some of their fields, in the order of their first."""
    groups: dict[tuple[str, ...], list[Outside]] = {}
    for one in found:
        groups.setdefault(tuple(getattr(one, key) for key in keys), []).append(one)
    return groups


BIAS = Quantity("bias", "bias", "%", "+.1f")
SCATTER = Quantity("scatter", "scatter", "%", ".1f")
NUMBER = Quantity("number", "outside values", "", ".0f")


def by_quantity(found: Sequence[Outside]) -> dict[str, dict[Quantity, Cell]]:
    """Number of outside values, bias and scatter, by quantity."""
    rows = {key: standing(own) for (key,), own in grouped(found, "quantity").items()}
    return {key: {NUMBER: s.number, BIAS: s.bias, SCATTER: s.scatter} for key, s in rows.items() if s is not None}


def summary(found: Sequence[Outside]) -> Table:
    """One row for each quantity, law and maker; values that do not count have a row of their own."""
    rows: list[dict[Quantity | str, Cell]] = []
    for (quantity, law, maker), own in grouped(found, "quantity", "law", "maker").items():
        s = standing(own)
        row: dict[Quantity | str, Cell] = {"quantity": quantity, "computed by": law, "maker": maker}
        if s is not None:
            row |= {NUMBER: s.number, BIAS: s.bias, SCATTER: s.scatter}
            row |= {
                Quantity("inside", "in their band", "", ".0f"): s.inside,
                Quantity("width", "width of the band, median", "%", ".1f"): s.width,
                Quantity("practice", "bias after the maker's practice", "%", "+.1f"): s.practice,
            }
        left = [x.why for x in own if not x.counts]
        row["not judged"] = "; ".join(f"{left.count(why)}: {why}" for why in dict.fromkeys(left))
        rows.append(row)
    note = (
        "Bias and scatter: mean and standard deviation of computed against printed. The band carries the rounding of what "
        "is printed through, and the usual range of what is not. Each value: outside.csv."
    )
    return Table.of("outside-summary", "Outside values by quantity, law and maker", rows, note)


def every(found: Sequence[Outside]) -> Table:
    """All values, one a row."""
    rows: list[dict[Quantity | str, Cell]] = [
        {
            "quantity": x.quantity,
            "maker": x.maker,
            "class": x.cls,
            "item": x.item,
            Quantity("value", "value", "", "g6"): x.value,
            "unit": x.unit,
            Quantity("computed", "computed", "", "g6"): x.computed,
            Quantity("low", "band from", "", "g6"): x.low,
            Quantity("high", "band to", "", "g6"): x.high,
            Quantity("error", "error", "%", ".2f"): x.error_percent,
            "verdict": x.verdict,
            "law": x.law,
            "origin": x.origin,
        }
        for x in found
    ]
    return Table.of("outside", "Every outside value beside the computed one", rows)
