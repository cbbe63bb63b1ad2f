"""Sections on numerical stability (stiff and extreme scenes) and on screws drawn at random."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.cases.lin.extremes import table_section_items
from rollbench.compare.models.applicability import KNOWN_SCREWS
from rollbench.compare.models.study import Study
from rollbench.compare.report.overview import passed_text
from rollbench.compare.sections.fit import WORDS
from rollbench.compare.studies import survey as survey
from rollbench.compare.studies.extremes import (
    ENERGY,
    FORMULATIONS,
    campaign_rows,
    count_outcomes,
    rows_by_case,
    shipped_campaigns,
    solve_cases,
)
from rollbench.compare.studies.survey import MODELS
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Errors of a scene in the report's table.
SHORT = {"largest": "largest_percent", "RMS": "rms_percent", "expected": "expected_percent"}
#: Bins of the histogram, and distance from a face that counts as near [ball radii].
BINS, NEAR = 24, 2.0


def survey_section(study: Study, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Return the section on drawn catalogue screws: error histogram, errors near a face, status, each screw."""
    step("stored survey")
    every = survey.shipped_survey()["scenes"]
    scenes = [r for r in every if r["number"] < KNOWN_SCREWS]
    title = "Screws drawn at random"
    if not scenes:
        return Section("survey", title, (Text(("No survey is stored.",)),))
    good = len(scenes) - len(survey.unsolved_records(scenes))
    versions = Counter(str(r["version"]) for r in scenes)
    by = ", ".join(f"{count} by {version}" for version, count in sorted(versions.items()))
    about = (
        "Ordinary catalogue screws of 16x5 to 80x20, drawn by one seed without redraws (sizes, starts, "
        "hand, preload or clearance, tolerance classes, offsets, tilts, moments, last balls from 1 ball "
        f"radius of the nut's face), on level 1 of the 3D reference: {good} of {len(scenes)} have a settled "
        "answer. Errors are absolute values in per cent, those of loads relative to the mean load; rigidity "
        f"is the tangent, by 5 % more load. Records are by the version that solved them: {by}."
    )
    errors = {f"{model} {short}": (model, key) for model in MODELS for short, key in SHORT.items()}
    rows: list[dict[str, Any]] = [
        {"scene": r["number"], "screw": r["title"].partition(": ")[2], "contacts": r.get("contacts"), "status": r["status"]}
        | {name: r.get("models", {}).get(model, {}).get(key) for name, (model, key) in errors.items()}
        for r in every
    ]
    gate = {
        model: [r["models"][model].get("gate_percent") for r in scenes if model in r.get("models", {})] for model in MODELS
    }
    passed = passed_text({model: np.array([e for e in errors if e is not None]) for model, errors in gate.items()})
    items = (
        survey_figure(scenes),
        Text((about,)),
        Table(
            "stability-survey",
            "Errors of the models on the drawn screws",
            tuple(Quantity(name, name, "", "s" if name in survey.SUMS[:3] else ".2f") for name in survey.SUMS),
            [row | {"error": WORDS[row["error"].removeprefix("largest_")]} for row in survey.summary_rows(scenes)],
        ),
        *_unseen(scenes, [r for r in every if r["number"] >= KNOWN_SCREWS]),
        Table(
            "stability-survey-scenes",
            "Every drawn screw",
            (
                *(Quantity(name, name, "", "s") for name in ("scene", "screw", "contacts", "status")),
                *(Quantity(name, name, "% of mean", ".2f") for name in errors),
            ),
            rows,
            csv_only=[f"{model} expected" for model in MODELS],
        ),
    )
    return Section("survey", title, items, conclusion=f"{passed}.")


def _unseen(first: list[dict[str, Any]], further: list[dict[str, Any]]) -> tuple[Text | Table, ...]:
    """Return text and table of the refined model's errors on first and on further screws; empty without further."""
    if not further:
        return ()
    found = {"first screws": survey.model_accuracy(first), "further screws": survey.model_accuracy(further)}
    aims = f"within {survey.WORST_AIM:g} % at the worst contact and {survey.RMS_AIM:g} % RMS"
    about = (
        "The further screws are drawn by the same seed and were judged once, after the refined model's last change. Their "
        "errors are not among those that the expected error is made from."
    )
    rows: list[Row] = [
        {"judged": f"{aims}, of the mean load", **{name: f"{a.within} of {a.screws}" for name, a in found.items()}},
        {
            "judged": "largest error of a contact / % of the mean load",
            **{name: f"{a.largest:.2f}" for name, a in found.items()},
        },
        {
            "judged": "largest error not above the expected one",
            **{name: f"{a.as_expected} of {a.screws}" for name, a in found.items()},
        },
    ]
    return Text((about,)), Table.of("stability-unseen", "The refined model on the first screws and on further ones", rows)


def _errors(scenes: Sequence[Mapping[str, Any]], model: str) -> Array:
    """Return (n, 2): distance of the outermost ball from a face [ball radii], largest error [% of mean load]."""
    rows = [
        (min(r["low_face_radii"], r["high_face_radii"]), found["largest_percent"])
        for r in scenes
        if (found := r.get("models", {}).get(model)) is not None
    ]
    return np.array(rows).reshape(-1, 2)


def survey_figure(scenes: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw the histogram of the largest errors, and the errors over the distance of the outermost ball from a face."""
    found = {model: errors for model in MODELS if (errors := _errors(scenes, model)).size}
    every = np.concatenate([errors[:, 1] for errors in found.values()])
    edges = np.geomspace(0.999 * every.min(), 1.001 * every.max(), BINS + 1)
    bars = [Series(m, edges.tolist(), np.histogram(e[:, 1], edges)[0].tolist(), "steps") for m, e in found.items()]
    points = [Series(m, e[:, 0].tolist(), e[:, 1].tolist(), "markers") for m, e in found.items()]
    error = "largest error / % of the mean load"
    panels = (
        Panel("How often", error, "screws", bars, log="x", zero=True),
        Panel("Near a face", "distance of the outermost ball from a face / ball radii", error, points, log="y"),
    )
    near = "; ".join(f"{name}: {_near(errors)}" for name, errors in found.items())
    title = f"The error grows towards the faces of the nut: median within and beyond {NEAR:g} ball radii, {near}"
    return Figure("survey", title, panels, f"{len(scenes)} drawn screws, {BINS} bins of equal ratio.")


def _near(errors: Array) -> str:
    """Return the median errors of screws whose outermost ball is near a face, and of the others."""
    near = errors[:, 0] < NEAR
    return " and ".join(f"{np.median(errors[one, 1]):.2g} %" for one in (near, ~near) if one.any())


def make_section(study: Study, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Return the section of the report."""

    def progress(done: int, total: int, case: str) -> None:
        if done % 10 == 0 or done == total:
            step(f"{done} of {total} cases ({case})")

    rows = solve_cases(progress)
    counts = count_outcomes(rows)
    summary: list[Row] = [
        {"formulation": name, "solved": solved, "tried": tried, "cases": total}
        for name, (solved, tried, total) in counts.items()
    ]
    columns = (
        Quantity("case", "case", "", "s"),
        Quantity(ENERGY, "energy solver", "", "s"),
        Quantity("iterations", "iterations", "", "s"),
        Quantity("residual", "residual", "", "g2"),
        Quantity("bound", "round-off bound", "", "g2"),
        Quantity("difference", "loads by contact forces", "% of largest", "g2"),
        *(Quantity(name, name, "", "s") for name in FORMULATIONS[1:]),
    )
    solved, _, total = counts[ENERGY]
    return Section(
        "stability",
        "Numerical stability on stiff and extreme scenes",
        (
            Text(
                (
                    "Each case is solved by the convex energy from a cold start; by the force formulation of the same "
                    "equations, whose loads must be the same; by the models with elastic bodies; and, of one set, by the "
                    "source's plain Newton from three starts. Axes have nuts, bearings of balls and of tapered rollers. A "
                    "case without equilibrium counts as solved when the mechanism is named. Residuals are the largest "
                    "unbalanced force over the largest force; the bound is what double precision leaves at best.",
                )
            ),
            Table.of("stability-summary", "Cases solved", summary),
            Table("stability-cases", "Every stiff or extreme scene", columns, rows_by_case(rows)),
            *table_section_items(),
            Text(
                (
                    "Random extreme screws and bearings, mutated files and killed processes, each outcome judged by "
                    "a check of its own: balance summed from printed numbers, refusals proven by rank or a linear program, "
                    "small scenes with a rigid screw compared with plain minimisation. Random axes (--axes) of one to five "
                    "sets are judged node by node: beam, springs, Hertz' law, every ball.",
                )
            ),
            Table.of("stability-campaign", "The campaigns", campaign_rows(shipped_campaigns())),
        ),
        conclusion=f"The energy solver solves {solved} of {total} stiff and extreme scenes from a cold start; the source's "
        f"iteration {max(counts[name][0] for name in FORMULATIONS[1:])} at best.",
    )
