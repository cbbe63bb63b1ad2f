"""Report section on the quantities in which each model is accurate enough, by comparison with the 3D reference.

It also makes table and figure of the range of compared scenes: their sizes, contact angle, load and other descriptors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np

from rollbench.compare.gate import judged
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.models import applicability
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.model_form import MeasuredModelErrors, model_errors_on_compared_scenes
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.meshes.parts import Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: Names of the quantities whose errors are compared, for sentences, by name of the field of `MeasuredModelErrors` that has
#: the error.
NAMES = {
    "gate_percent": "contact loads",
    "percent": "contact loads",
    "rms_percent": "contact loads",
    "displacement_percent": "axial displacement",
    "rigidity_percent": "axial tangent rigidity",
    "pressure_percent": "largest pressure",
}

#: Descriptions of the errors of these quantities, for tables.
WORDS = NAMES | {
    "gate_percent": "largest contact-load error by the rule of rollbench check",
    "percent": "largest error of a contact load, in per cent of the mean load",
    "rms_percent": "RMS error of the contact loads, in per cent of the mean load",
}

#: Default error limits of ``rollbench check`` [%]; errors in per cent of the mean load have no limit.
LIMITS = {"gate_percent": LIMIT} | {
    f"{q.name}_percent": q.default_limit_ratio * LIMIT for q in (judged.DISPLACEMENT, judged.RIGIDITY, judged.PRESSURE)
}

#: Title of the table and of the figure of the range of compared scenes.
RANGE_TITLE = "Range of the sizes, angles and loads of the screws that were compared with the 3D reference"

#: Limits of the models' accuracy and of their validation.
NOT_FIT = (
    (
        "Larger errors occur for balls within about 1.4 ball radii of a nut face, for short nuts fixed by a flange, and "
        "for shaft ends displaced by many times the contact approach under a light load. The largest errors in the table "
        "are of this kind."
    ),
    (
        "The models do not describe lubrication films, plastic contact, the dynamics of the recirculation, and temperature "
        "fields other than prescribed temperatures. The friction torque is known only within a band that corresponds to "
        "the uncertainty of the friction coefficient."
    ),
    "The models are not validated for screws beyond the compared range; results there state that their error is not known.",
)


def accuracy_rows(points: Sequence[MeasuredModelErrors]) -> Iterator[Row]:
    """Yield table rows on the absolute errors of every model in every compared quantity, over all scenes.

    Each row has the median, 95th percentile and largest error, the limit of ``rollbench check``, and the share of scenes
    within it. A model is accurate enough if at least 95 % of the scenes are. ``points``: errors against the 3D reference,
    one record for each model and scene, with the errors in all quantities.
    """
    for model, key in product(dict.fromkeys(p.model for p in points), NAMES):
        errors = np.array([abs(v) for p in points if p.model == model and (v := getattr(p, key)) is not None])
        if errors.size:
            limit = LIMITS.get(key)
            share = None if limit is None else float(np.mean(errors <= limit))
            yield {
                "quantity": WORDS[key],
                "model": model,
                "scenes": int(errors.size),
                "median_error": float(np.median(errors)),
                "error_p95": float(np.percentile(errors, 95)),
                "largest_error": float(errors.max()),
                "check_limit": limit,
                "share_within_limit": None if share is None else 100.0 * share,
                "accurate_enough": None if share is None else "yes" if share >= 0.95 else "no",
            }


def sentences_on_accurate_quantities(rows: Sequence[Row]) -> str:
    """Return sentences that name the quantities for which the default model is accurate enough, and Lin's model is not.

    A model is accurate enough for a quantity if its error is within the limit of ``rollbench check`` on at least 95 % of
    the compared scenes. ``rows``: `accuracy_rows`.
    """
    name_of = {words: NAMES[key] for key, words in WORDS.items()}
    found = [(name_of[row["quantity"]], (row["model"], row["accurate_enough"])) for row in rows]
    good, bad = ([name for name, of in found if of == wanted] for wanted in ((DEFAULT, "yes"), ("lin", "no")))
    held = " Accurate enough: error within the limit of rollbench check on at least 95 % of the screws and bearings."
    fit = f"is accurate enough for the {_join_with_and(good)}." if good else "is not shown to be accurate enough."
    unfit = f" The model lin is not accurate enough for the {_join_with_and(bad)}." if bad else ""
    return f"On the compared screws, the {DEFAULT} model {fit}{unfit}{held}"


def _join_with_and(names: Sequence[str]) -> str:
    """Return the names as text, joined by commas and, before the last, by "and"."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Return the section on the quantities for which each model is accurate enough.

    ``cache`` is not used. ``step`` is called with each line of progress.
    """
    step("all compared scenes")
    rows = list(accuracy_rows(model_errors_on_compared_scenes()))
    note = (
        "Errors against the 3D reference on all example and all randomly drawn screws and bearings. Accurate enough: at "
        f"least 95 % of them are within the error limit of rollbench check. This is {LIMIT:g} % for contact loads {RULE}; "
        "for other quantities it is the error that follows from load errors of this size. Errors in per cent of the mean "
        "load have no limit. The error by the rule of rollbench check is not stored for all of them."
    )
    title = "Errors of each model against the 3D reference over all compared screws and bearings, by quantity"
    table = Table.from_rows("fit-for", title, rows, note)
    items, conclusion = (table, Text(NOT_FIT, bullets=True)), sentences_on_accurate_quantities(rows)
    return Section("fit", "Quantities for which each model is accurate enough", items, conclusion=conclusion)


def validated_range_table(scene: Scene | None = None) -> Table:
    """Return the table of the range of sizes, angles and loads over the scenes compared with the 3D reference.

    ``scene``: scene whose values are added, with a statement whether they lie inside the ranges; None: no scene.
    """
    rows: list[Row] = []
    placed = {} if scene is None else {p.descriptor.name: p for p in applicability.descriptors_with_ranges(scene)}
    ring = scene is not None and scene.track.lead == 0.0
    for d in applicability.DESCRIPTORS:
        values = applicability.descriptor_values_of_compared_scenes(d, of_bearings=ring)
        row: Row = {"parameter_of_scene": d.name, "unit": d.unit or "–"}
        row |= {"smallest_value": min(values), "largest_value": max(values)}
        if scene is not None and d.name in placed:
            place = placed[d.name]
            inside = place.low <= place.value <= place.high
            where = "inside" if inside else "OUTSIDE" if place.outside else "at the edge"
            row |= {("value_of_scene", scene.name): place.value, "place_in_range": where}
        rows.append(row)
    kind = "rings" if ring else "screws"
    note = (
        f"Ranges of {len(values)} {kind}, shipped or randomly drawn, that were compared with the 3D reference. A scene "
        "outside a range by less than a margin (at the edge) still counts as covered; further outside, results state that "
        "their error is not known."
    )
    return Table.from_rows("applicability", RANGE_TITLE, rows, note)


def validated_range_figure(scene: Scene | None = None) -> Figure:
    """Draw the scenes compared with the 3D reference as points in diagrams, each of two of their sizes, angles or loads.

    ``scene``: scene that is marked in the diagrams; None: no scene.
    """
    pairs = ((0, 1), (2, 4), (6, 3), (5, 7))
    ring = scene is not None and scene.track.lead == 0.0
    panels = []
    for a, b in (tuple(applicability.DESCRIPTORS[k] for k in pair) for pair in pairs):
        x, y = (applicability.descriptor_values_of_compared_scenes(d, of_bearings=ring) for d in (a, b))
        series = [Series("compared scenes", x, y, "markers")]
        if scene is not None:
            series.append(Series(scene.name, [a.value_of_scene(scene)], [b.value_of_scene(scene)], "markers", bold=True))
        panels.append(Panel("", _descriptor_label(a), _descriptor_label(b), tuple(series)))
    return Figure("applicability", RANGE_TITLE, tuple(panels))


def _descriptor_label(descriptor: applicability.Descriptor) -> str:
    """Return the axis label of a descriptor (a number that describes a scene, such as a size ratio): its name and unit."""
    return f"{descriptor.name} / {descriptor.unit}" if descriptor.unit else descriptor.name
