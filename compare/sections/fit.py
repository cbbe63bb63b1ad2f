"""What the models are fit for and what not, from all scenes that were compared with the 3D reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rollbench.comparison.models.model_form import QUANTITIES, Point, shipped_points
from rollbench.comparison.models.registry import DEFAULT
from rollbench.comparison.models.study import Study
from rollbench.reports.records import Quantity, Row, Section, Table, Text

#: Limit [%] that a use is counted by, and words of the errors.
LIMIT = 7.0
WORDS = {
    "percent": "worst contact load, of the mean load",
    "rms_percent": "RMS of the contact loads, of the mean load",
    "displacement_percent": "axial displacement",
    "rigidity_percent": "axial tangent rigidity",
    "pressure_percent": "largest pressure",
}
NOT_FIT = (
    (
        "Less certain: balls within about 1.4 ball radii of a nut face, short nuts held by a flange, and shaft ends "
        "displaced by many times the contact approach under a light load. The largest errors in the table come from these."
    ),
    (
        "Not fit for: lubrication films, plastic contact, dynamics of the recirculation, and temperature fields "
        "other than a given temperature. Friction torque is a band, as wide as the friction coefficient is "
        "uncertain."
    ),
    "Not fit for screws beyond the compared range: there a result says that its error is not covered.",
)


def rows(points: Sequence[Point]) -> list[Row]:
    """Median, 95th percentile and largest error of every model, and the share within the limit."""
    found: list[Row] = []
    for model in dict.fromkeys(p.model for p in points):
        for key in QUANTITIES:
            errors = np.array([abs(v) for p in points if p.model == model and (v := getattr(p, key)) is not None])
            if errors.size:
                within = float(np.mean(errors <= LIMIT))
                found.append(
                    {
                        "quantity": WORDS[key],
                        "model": model,
                        Quantity("scenes", "scenes", "", "s"): int(errors.size),
                        Quantity("median", "median", "%", ".2f"): float(np.median(errors)),
                        Quantity("p95", "95 of 100", "%", ".2f"): float(np.percentile(errors, 95)),
                        Quantity("largest", "largest", "%", ".1f"): float(errors.max()),
                        Quantity("within", f"within {LIMIT:g} %", "%", ".0f"): 100.0 * within,
                        "verdict": "yes" if within >= 0.95 else "no",
                    }
                )
    return found


def conclusion(found: Sequence[Row]) -> str:
    """What 95 of 100 compared scenes are fit for."""
    good = [_plain(row) for row in found if row["model"] == DEFAULT and row["verdict"] == "yes"]
    bad = [_plain(row) for row in found if row["model"] == "lin" and row["verdict"] == "no"]
    fit = (
        f"is fit for the {_listed(good)}: within {LIMIT:g} % on at least 95 of 100" if good else "is not shown to be fit on"
    )
    unfit = f" lin is not fit for the {_listed(bad)}." if bad else ""
    return f"On ordinary screws {DEFAULT} {fit} compared scenes.{unfit}"


def _plain(row: Row) -> str:
    return str(row["quantity"]).removesuffix(", of the mean load")


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def section(study: Study, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Section of the report."""
    step("all compared scenes")
    found = rows(shipped_points())
    note = (
        "All shipped and surveyed scenes, each against the 3D reference. Verdict: at least 95 of 100 scenes "
        "within the limit."
    )
    table = Table.of("fit-for", "Errors of all compared scenes by quantity", found, note, shown=None)
    return Section("fit", "Fit for, not fit for", (table, Text(NOT_FIT, bullets=True)), conclusion=conclusion(found))
