"""The 3D reference against another program: contact by contact, each at its meshes, with both errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.studies.crosscheck.data import CrossData, CrossRun
from rollbench.compare.studies.crosscheck.fit import Extrapolation, extrapolate
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Cell, Quantity

#: Agreement aimed at, in per cent of the mean load.
TARGET = 0.5
PLACE = (Quantity("ball", "ball", "", "s"), Quantity("side", "side", "", "s"))
#: The comparison of a contact: the reference's finest level, the other program extrapolated.
COMPARED = (
    Quantity("ours", "reference", "N", ".2f"),
    Quantity("ours_percent", "uncertainty, reference", "% of mean", ".2f"),
    Quantity("theirs", "CalculiX", "N", ".2f"),
    Quantity("theirs_percent", "uncertainty, CalculiX", "% of mean", ".2f"),
    Quantity("difference", "difference", "% of mean", "+.2f"),
)
COLUMNS = (*PLACE, *COMPARED)


@dataclass(frozen=True)
class ContactRow:
    """One contact: ball (from 1), side, loads [N] on every mesh of the reference and of the other program by name, the
    reference's finest and the other's extrapolated, their uncertainties and differences in per cent of the
    mean load of the reference."""

    ball: int
    side: str
    meshes: Mapping[str, float]
    ours: float
    ours_percent: float
    theirs: float
    theirs_percent: float
    difference: float

    def cells(self) -> dict[str, Cell]:
        """The row of a table."""
        compared: dict[str, Cell] = {q.key: getattr(self, q.key) for q in COMPARED}
        return {"ball": str(self.ball), "side": self.side, **self.meshes, **compared}


def series(data: CrossData) -> list[CrossRun]:
    """The runs with small displacements and the contact stiffness of most, fewest nodes first."""
    linear = [r for r in data.runs if not r.nlgeom]
    alike = [sum(r.stiffness == one.stiffness for r in linear) for one in linear]
    most = linear[int(np.argmax(alike))].stiffness
    return sorted((r for r in linear if r.stiffness == most), key=lambda r: r.nodes)


def deck_label(run: CrossRun) -> str:
    """Short name of a deck in a series: elements across the short half axis, growth, half or equal balls."""
    return f"b/h {run.b_over_h:g}, g {run.growth:g}" + ", half" * run.half + ", equal balls" * run.alike


def contact_rows(data: CrossData, ours: Reference, limit: Extrapolation | None = None) -> list[ContactRow]:
    """Rows of all contacts that either program finds loaded."""
    limit = limit or extrapolate(data.runs)
    best, mean, rows = ours.load, ours.mean, []
    meshes = {f"level {r.level}": r.load for r in ours.runs} | {deck_label(r): r.load for r in series(data)}
    for i, s in zip(*np.nonzero((best > 0.0) | (limit.load > 1e-3 * mean)), strict=True):
        uncertainty = float(error_percent(ours.uncertainty[i, s], 0.0, mean))
        rows.append(
            ContactRow(
                int(i) + 1,
                SIDES[s],
                {name: float(load[i, s]) for name, load in meshes.items()},
                float(best[i, s]),
                uncertainty,
                float(limit.load[i, s]),
                float(error_percent(limit.uncertainty[i, s], 0.0, mean)),
                float(error_percent(best[i, s], limit.load[i, s], mean)),
            )
        )
    return rows


def mesh_columns(data: CrossData, ours: Reference) -> list[Quantity]:
    """Columns of the loads on every mesh of both programs."""
    return [
        *PLACE,
        *(Quantity(f"level {r.level}", f"reference, level {r.level}", "N", ".2f") for r in ours.runs),
        *(Quantity(deck_label(r), f"CalculiX, {deck_label(r)}", "N", ".2f") for r in series(data)),
    ]


def agreement(name: str, rows: Sequence[ContactRow]) -> str:
    """Sentence on the worst and RMS difference, and on whether they are more than both programs' uncertainties."""
    worst = max(rows, key=lambda r: abs(r.difference))
    rms = float(np.sqrt(np.mean([r.difference**2 for r in rows])))
    met = "within" if abs(worst.difference) <= TARGET else "NOT within"
    theirs = max(r.theirs_percent for r in rows)
    beyond = sum(abs(r.difference) > np.hypot(r.theirs_percent, r.ours_percent) for r in rows)
    return (
        f"{name}: the 3D reference differs from CalculiX by at most {worst.difference:+.2f} % of the mean load (ball "
        f"{worst.ball} {worst.side}; RMS {rms:.2f} %), {met} {TARGET} %; CalculiX's own uncertainty is up to "
        f"{theirs:.2f} %, and {beyond} of {len(rows)} contacts differ by more than both uncertainties."
    )
