"""Kalker's table of linear creep coefficients, by the 3D model of rolling on three grids."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.compare.evidence.record import Sheet
from rollbench.compare.models.study import Study
from rollbench.hifi.rolling.verification import linear_coefficients

#: Ratios of semi-axes and Poisson's ratios; grids of each ratio, cells along and across.
GRIDS = {"0.2": ((12, 24), (16, 32), (18, 36)), "1": ((20, 20), (28, 28), (36, 36)), "5": ((60, 12), (80, 16), (100, 20))}
POISSON = ("0", "0.25", "0.5")
NAMES = ("C11", "C22", "C23", "C33")


@dataclass(frozen=True)
class Coefficient:
    """A coefficient: its key, values by grid, and the answer: extrapolated where the grids come to it from one side in
    falling steps, in the first order of the cells, otherwise the finest grid's."""

    key: str
    values: tuple[float, ...]
    answer: float
    extrapolated: bool


@lru_cache(maxsize=1)
def coefficients() -> tuple[Coefficient, ...]:
    """All 36 coefficients."""
    return tuple(_solved())


def _solved() -> Iterator[Coefficient]:
    for ratio, shapes in GRIDS.items():
        cells = np.array([1.0 / s[1] for s in shapes])
        for poisson in POISSON:
            found = np.array([linear_coefficients(float(ratio), float(poisson), s) for s in shapes])
            limits = np.polyfit(cells, found, 1)[1]
            for name, values, limit in zip(NAMES, found.T, limits, strict=True):
                steps = np.diff(values)
                one_side = bool(steps[0] * steps[1] > 0.0 and abs(steps[1]) < abs(steps[0]))
                answer = float(limit if one_side else values[-1])
                yield Coefficient(f"{name}_{ratio}_{poisson}", tuple(map(float, values)), answer, one_side)


def table_e3(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Kalker's coefficients for a/b of 0.2, 1, 5 and nu of 0, 0.25, 0.5."""
    for one in coefficients():
        grids = ", ".join(f"{v:.4g}" for v in one.values)
        how = "extrapolated" if one.extrapolated else "the finest grid's"
        sheet.number(one.key, one.answer, f"grids {grids}; {how}")
