"""Section on what the models are fit for, from all scenes that were compared with the 3D reference.

A figure shows the range of each descriptor, the compared scenes in it, and a given scene.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.compare.gate import judged
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.models.applicability import DESCRIPTORS, Descriptor, compared_values, descriptors_in_range
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.model_form import Point, shipped_points
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Names of the errors, with their headings in tables.
NAMES = {
    "gate_percent": "worst contact load",
    "percent": "worst contact load",
    "rms_percent": "RMS of the contact loads",
    "displacement_percent": "axial displacement",
    "rigidity_percent": "axial tangent rigidity",
    "pressure_percent": "largest pressure",
}

WORDS = (
    NAMES
    | {key: f"{NAMES[key]}, of the mean load" for key in ("percent", "rms_percent")}
    | {"gate_percent": "worst contact load, by the gate's rule"}
)

#: Limits [%] of the errors: the gate's, which does not judge errors of the mean load.
LIMITS = {"gate_percent": LIMIT} | {
    f"{q.name}_percent": q.times * LIMIT for q in (judged.DISPLACEMENT, judged.RIGIDITY, judged.PRESSURE)
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


@dataclass(frozen=True)
class Fit:
    """Absolute errors of a model in one quantity."""

    #: Quantity, a key of ``NAMES``.
    key: str
    #: Name of the model.
    model: str
    #: Errors, (n,) [%].
    errors: Array

    @property
    def within(self) -> float | None:
        """Share of scenes whose error is within the gate's limit; None if the quantity has no limit."""
        return float(np.mean(self.errors <= LIMITS[self.key])) if self.key in LIMITS else None

    @property
    def good(self) -> bool | None:
        """Whether 95 % of the scenes are within the gate's limit; None if the quantity has no limit."""
        return None if self.within is None else self.within >= 0.95

    @property
    def table_row(self) -> Row:
        """Return the table row of the errors: median, 95th percentile, largest, gate limit, share within it."""
        share, good = self.within, self.good
        return {
            "quantity": WORDS[self.key],
            "model": self.model,
            Quantity("scenes", "scenes", "", "s"): int(self.errors.size),
            Quantity("median", "median", "%", ".2f"): float(np.median(self.errors)),
            Quantity("p95", "95 of 100", "%", ".2f"): float(np.percentile(self.errors, 95)),
            Quantity("largest", "largest", "%", ".1f"): float(self.errors.max()),
            Quantity("limit", "the gate's limit", "%", ".3g"): LIMITS.get(self.key),
            Quantity("within", "within it", "%", ".0f"): None if share is None else 100.0 * share,
            "verdict": None if good is None else "yes" if good else "no",
        }


def errors_by_quantity(points: Sequence[Point]) -> list[Fit]:
    """Return the errors of every model in every compared quantity."""
    found = []
    for model in dict.fromkeys(p.model for p in points):
        for key in NAMES:
            errors = np.array([abs(v) for p in points if p.model == model and (v := getattr(p, key)) is not None])
            if errors.size:
                found.append(Fit(key, model, errors))
    return found


def fitness_sentence(found: Sequence[Fit]) -> str:
    """Return a sentence on which model is fit, and which is not, for which quantities."""
    good = [NAMES[x.key] for x in found if x.model == DEFAULT and x.good]
    bad = [NAMES[x.key] for x in found if x.model == "lin" and x.good is False]
    held = " The gate's limits hold there on at least 95 of 100 compared scenes."
    fit = f"is fit for the {_join_names(good)}.{held}" if good else "is not shown to be fit."
    unfit = f" lin is not fit for the {_join_names(bad)}." if bad else ""
    return f"On ordinary screws the model {DEFAULT} {fit}{unfit}"


def _join_names(names: Sequence[str]) -> str:
    """Return names as a list in a sentence."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def make_section(study: Study, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Return the section of the report."""
    step("all compared scenes")
    found = errors_by_quantity(shipped_points())
    note = (
        "All shipped and surveyed scenes, each against the 3D reference. Verdict: at least 95 of 100 scenes within the "
        f"gate's limit, {LIMIT:g} % of contact loads {RULE}, and of other quantities what loads off by that much make of "
        "them. No error of the mean load has a limit. Of the gate's rule there are the scenes whose record has it."
    )
    table = Table.of(
        "fit-for", "Errors of each model over all compared scenes, by quantity", [x.table_row for x in found], note
    )
    return Section(
        "fit",
        "Quantities for which each model is accurate enough",
        (table, Text(NOT_FIT, bullets=True)),
        conclusion=fitness_sentence(found),
    )


def range_table(scene: Scene | None = None) -> Table:
    """Return the table of the descriptors' compared ranges, with the values of a scene if one is given."""
    rows: list[Row] = []
    placed = {} if scene is None else {p.descriptor.name: p for p in descriptors_in_range(scene)}
    ring = scene is not None and scene.track.lead == 0.0
    for d in DESCRIPTORS:
        values = compared_values(d, ring=ring)
        row: Row = {
            Quantity("name", "what describes a scene", "", "s"): d.name,
            "unit": d.unit or "–",
            Quantity("low", "compared from", "", "g4"): min(values),
            Quantity("high", "to", "", "g4"): max(values),
        }
        if scene is not None and d.name in placed:
            place = placed[d.name]
            inside = place.low <= place.value <= place.high
            where = "inside" if inside else "OUTSIDE" if place.outside else "at the edge"
            row |= {Quantity("own", scene.name): place.value, Quantity("where", "where it lies", "", "s"): where}
        rows.append(row)
    kind = "rings" if ring else "screws"
    note = (
        f"Of {len(values)} {kind}, shipped or drawn, that were compared with the 3D reference. Beyond a range by less "
        "than its margin a scene still counts as covered; further out, a result says that its error is not covered."
    )
    return Table.of(
        "applicability", "Range of screw sizes and features that were compared with the 3D reference", rows, note
    )


def range_figure(scene: Scene | None = None) -> Figure:
    """Draw the compared scenes by pairs of descriptors, with a scene marked if one is given."""
    pairs = ((0, 1), (2, 4), (6, 3), (5, 7))
    ring = scene is not None and scene.track.lead == 0.0
    panels = []
    for a, b in (tuple(DESCRIPTORS[k] for k in pair) for pair in pairs):
        series = [Series("compared", compared_values(a, ring=ring), compared_values(b, ring=ring), "markers")]
        if scene is not None:
            series.append(Series(scene.name, [a.value(scene)], [b.value(scene)], "markers", emphasis=True))
        panels.append(Panel("", _descriptor_label(a), _descriptor_label(b), tuple(series)))
    return Figure(
        "applicability", "Range of screw sizes and features that were compared with the 3D reference", tuple(panels)
    )


def _descriptor_label(d: Descriptor) -> str:
    return f"{d.name} / {d.unit}" if d.unit else d.name


def range_items(study: Study) -> tuple[Table | Figure, ...]:  # noqa: ARG001 - as every part of a section
    """Return table and figure of the compared ranges, without marking a scene."""
    return range_table(), range_figure()
