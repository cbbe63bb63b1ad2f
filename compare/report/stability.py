"""Report sections on numerical stability in stiff and extreme scenes, and on errors on randomly drawn screws."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.report.error_over_time import error_and_time_items
from rollbench.compare.report.overview import NAMES, screws_within_limit_text
from rollbench.compare.sections.fit import WORDS
from rollbench.compare.studies import extremes, survey
from rollbench.compare.studies.survey import MODELS
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Cell, ColumnKey, Figure, Panel, Row, Section, Series, Table, Text

#: Keys, in the stored records, of the errors in the table of all screws, by the descriptions in its column headings.
SHORT = {
    "largest contact-load error": "largest_percent",
    "RMS error of the contact loads": "rms_percent",
    "expected largest error": "expected_percent",
}
#: Number of bins of the histogram, and distance up to which a ball counts as near a nut face [ball radii].
BINS, NEAR = 24, 2.0


def survey_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on contact-load errors of the low-order models on randomly drawn catalogue screws.

    It has the histogram of errors, errors near nut faces, errors over run time, and a table of all screws.

    ``step`` is called with each line of progress.
    """
    step("stored results of the randomly drawn screws")
    every = scenes = survey.built_in_survey()["scenes"]
    title = "Contact-load errors of the models on randomly drawn catalogue screws"
    good = len(scenes) - len(survey.records_without_converged_loads(scenes))
    versions = Counter(str(r["version"]) for r in scenes)
    by = ", ".join(f"{count} by {version}" for version, count in sorted(versions.items()))
    about = (
        "Ordinary catalogue screws from 16x5 to 80x20, drawn at random with a fixed seed; no drawn screw was replaced. "
        "Drawn were size, number of starts, hand, preload or clearance, tolerance class, offset, tilt, moment, and the "
        "distance of the outermost balls from the nut faces, from 1 ball radius on. Each screw was compared with mesh "
        f"level 1 of the 3D reference, which converged for {good} of {len(scenes)}. Errors are absolute values in per "
        "cent, those of loads relative to the mean load; rigidity is the tangent, from a load increased by 5 %. Versions "
        f"of the program that solved the screws: {by}."
    )
    errors = {("error_of_model", model, short): (model, key) for model in MODELS for short, key in SHORT.items()}
    columns: dict[ColumnKey, Sequence[Cell]] = {
        "screw_number": [r["number"] for r in every],
        "screw": [r["title"].partition(": ")[2] for r in every],
        "contacts": [r.get("contacts") for r in every],
        "status": [r["status"] for r in every],
    }
    for column, (model, key) in errors.items():
        columns[column] = [r.get("models", {}).get(model, {}).get(key) for r in every]
    gate = {
        model: [r["models"][model].get("gate_percent") for r in scenes if model in r.get("models", {})] for model in MODELS
    }
    passed = screws_within_limit_text({m: np.array([e for e in each if e is not None]) for m, each in gate.items()})
    summary: list[Row] = [
        {
            "model": row["model"],
            "error_quantity": WORDS[row["error"].removeprefix("largest_")],
            "screws": row["scenes"],
            "median_error": row["median"],
            "error_p95": row["p95"],
            "largest_error_f2": row["largest"],
        }
        for row in survey.error_summary_rows_of_all_models(scenes)
    ]
    items = (
        random_screw_error_figure(scenes),
        Text((about,)),
        Table.from_rows(
            "stability-survey",
            "Median, 95th percentile and maximum of the models' errors on all randomly drawn screws",
            summary,
        ),
        *error_and_time_items(cache),
        *_items_on_screws_drawn_later(scenes, survey.built_in_survey("new screw")["scenes"]),
        *double_nut_items(),
        Table(
            "stability-survey-scenes",
            "Contact-load errors of the refined model and Lin's model on each randomly drawn screw",
            columns,
            csv_only=[("error_of_model", model, "expected largest error") for model in MODELS],
        ),
    )
    return Section("survey", title, items, conclusion=f"Randomly drawn {passed[:1].lower()}{passed[1:]}.")


def _items_on_screws_drawn_later(
    screws_known_before: list[dict[str, Any]], screws_drawn_later: list[dict[str, Any]]
) -> tuple[Text | Table, ...]:
    """Return text and table of the models' errors on screws drawn before and after their last change.

    Parameters
    ----------
    screws_known_before
        Stored results of the screws that were known while the model was developed.
    screws_drawn_later
        Stored results of the screws drawn after its last change.
    """
    about = (
        f"The screws drawn later are of another seed, {survey.NEW_TUBES} with a tube as nut, others with a flange. They "
        "were compared once, after the last change of the models, and nothing was fitted or calibrated with them; their "
        "errors are those of a new screw. The last column counts by the error to expect, as the program gives it for a "
        "new screw."
    )
    groups = {"drawn before the last change": screws_known_before, "drawn later": screws_drawn_later}
    rows: list[Row] = []
    for model in MODELS:
        for name, records in groups.items():
            found = survey.model_accuracy_on_random_screws(records, model)
            rows.append(
                {
                    "model": model,
                    "screw_group": name,
                    "screws": found.screw_count,
                    "largest_load_error_median": found.median_error,
                    "largest_load_error_p95": found.percentile_95,
                    "largest_load_error_of_screw": found.largest_error,
                    ("within_aims", f"{survey.WORST_AIM:g}", f"{survey.RMS_AIM:g}"): found.within_aims,
                    "within_expected_error": found.within_expected_error,
                }
            )
    title = "Contact-load errors of the models on screws drawn before and after their last change"
    return Text((about,)), Table.from_rows("stability-unseen", title, rows)


def double_nut_items() -> tuple[Text | Table, ...]:
    """Return text and table of the models' errors on the drawn double nuts and the shipped one; empty without records."""
    records = survey.built_in_survey("double nut")["scenes"]
    good = [r for r in records if r.get("models")]
    sums = {m: survey.model_accuracy_on_random_screws(good, m) for m in MODELS if any(m in r["models"] for r in good)}
    words = "; ".join(
        f"{NAMES[model]}: median {one.median_error:.2f} %, largest {one.largest_error:.2f} %" for model, one in sums.items()
    )
    about = (
        f"{len(records)} double nuts, two equal nuts braced against each other, were drawn with the seed of the screws and "
        f"compared with mesh level 1 of the 3D reference, which converged for {len(good)}. The error is that of the worst "
        f"contact of both nuts, in per cent of the mean load of its nut: {words}. The shipped double nut has finer mesh "
        "levels and is not among these figures. The drawn ones calibrate the error to expect of a double nut."
    )
    rows: list[Row] = []
    for r in [*survey.errors_on_shipped_double_nut(), *records]:
        bars = r.get("uncertainty_percent")
        row: Row = {"double_nut": r["number"], "nut_size": r.get("title", "").partition(": ")[2], "status": r["status"]}
        for model in MODELS:
            found = r.get("models", {}).get(model, {})
            row |= {
                ("error_of_model", model, "largest contact-load error"): found.get("largest_percent"),
                ("at_error_of_model", model): found.get("at", ""),
                ("error_of_model", model, "expected largest error"): found.get("expected_percent"),
            }
        row["mesh_uncertainty"] = None if bars is None else max(bars)
        rows.append(row)
    title = "Contact-load errors of the models on drawn double nuts and on the shipped one"
    return Text((about,)), Table.from_rows("double-nuts", title, rows)


def _nut_face_distances_and_errors(screw_records: Sequence[Mapping[str, Any]], model: str) -> Array:
    """Return, for n random screws, the distance of the outermost ball from a nut face and a model's largest load error.

    ``screw_records``: stored results of the screws. ``model``: name of the model. The array is (n, 2): distance [ball
    radii], and largest contact-load error [% of the mean load].
    """
    rows = [
        (min(r["low_face_radii"], r["high_face_radii"]), found["largest_percent"])
        for r in screw_records
        if (found := r.get("models", {}).get(model)) is not None
    ]
    return np.array(rows).reshape(-1, 2)


def random_screw_error_figure(screw_records: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw the histogram of the largest contact-load errors, and these errors over the distance of a ball from a nut face.

    ``screw_records``: stored results of the randomly drawn screws, with one largest error per screw and model. The distance
    is measured from the outermost ball.
    """
    found = {model: errors for model in MODELS if (errors := _nut_face_distances_and_errors(screw_records, model)).size}
    every = np.concatenate([errors[:, 1] for errors in found.values()])
    edges = np.geomspace(0.999 * every.min(), 1.001 * every.max(), BINS + 1)
    bars = [Series(m, edges.tolist(), np.histogram(e[:, 1], edges)[0].tolist(), "steps") for m, e in found.items()]
    points = [Series(m, e[:, 0].tolist(), e[:, 1].tolist(), "markers") for m, e in found.items()]
    error = "largest contact-load error / % of the mean load"
    distance = "distance of the outermost ball from a nut face / ball radii"
    panels = (
        Panel("Distribution of the error", error, "screws", bars, log_axes="x", include_zero=True),
        Panel("Error near a nut face", distance, error, points, log_axes="y"),
    )
    medians = []
    for name, errors in found.items():
        near = errors[:, 0] < NEAR
        texts = (f"{np.median(errors[one, 1]):.2g} %" for one in (near, ~near) if one.any())
        medians.append(f"{' and '.join(texts)} with {NAMES.get(name, name)}")
    title = f"Median of the largest contact-load error on a screw, in per cent of the mean load: {'; '.join(medians)}"
    return Figure(
        "survey",
        title,
        panels,
        f"{len(screw_records)} randomly drawn screws. Of the two medians of each model, the first is for screws with a "
        f"ball closer than {NEAR:g} ball radii to a nut face, the second for the other screws. First panel: histogram of "
        "the errors on a logarithmic abscissa.",
    )


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Return the section on numerical stability: which formulations of the equations solve each stiff or extreme scene.

    ``cache`` is not used. ``step`` is called with each line of progress.
    """

    def progress(done: int, total: int, case: str) -> None:
        if done % 10 == 0 or done == total:
            step(f"{done} of {total} cases ({case})")

    rows = extremes.solve_all_hard_scenes(progress)
    counts = extremes.count_expected_outcomes(rows)
    summary: list[Row] = [
        {"formulation": name, "cases_solved": solved, "cases_tried": tried, "cases": total}
        for name, (solved, tried, total) in counts.items()
    ]
    keys: dict[ColumnKey, str] = {
        "extreme_case": "case",
        ("status_of", extremes.ENERGY): extremes.ENERGY,
        "energy_iterations": "iterations",
        "residual": "residual",
        "round_off_limit": "bound",
        **{("status_of", name): name for name in extremes.formulations()[1:]},
    }
    cases = extremes.stability_table_rows(rows)
    solved, _, total = counts[extremes.ENERGY]
    newton, applicable, _ = max(counts[name] for name in extremes.formulations_of_cases())
    return Section(
        "stability",
        "Numerical stability of the solvers on stiff and extreme cases",
        (
            Text(
                (
                    "Each case is solved by minimising the convex energy from a cold start, and by the models with elastic "
                    "bodies. A test compares the loads of cases with up to 40 balls with those of dense equations in the "
                    "motions of the shaft, which share no code with the solver. "
                    "Cases with one set of balls are also solved by Lin's plain Newton method from three start vectors. "
                    "Shafts with several sets have nuts, ball bearings and tapered roller bearings. A case without "
                    "equilibrium counts as solved if the solver names the mechanism. The largest "
                    "unbalanced force over the largest force is the residual of the solution; the next column is the "
                    "smallest residual that double precision allows.",
                )
            ),
            Table.from_rows("stability-summary", "Number of stiff and extreme cases solved by each formulation", summary),
            Table(
                "stability-cases",
                "Solver status of each formulation of the equations on each stiff or extreme case",
                {column: [row.get(key) for row in cases] for column, key in keys.items()},
            ),
            *(item for case in all_cases() if case.stability for item in case.import_object(case.stability)()),
            Text(
                (
                    "The program was also run on random extreme screws and bearings, on scene files with random faults, "
                    "and with processes that were killed. Every outcome is checked by independent means: the forces of a "
                    "solution are summed from the printed numbers; that a refused scene has no equilibrium is proven by "
                    "the rank of its equations or by a linear program; small scenes with a rigid screw are also solved by "
                    "plain minimisation of the energy. Random shafts (--axes) with one to five sets of balls "
                    "or rollers are checked node by node: beam, springs, Hertz' law, every ball. What a campaign found "
                    "wrong stays in its row. The last column says what it was, and what a later state of the program gives "
                    "for the same case (python -m tests.campaign --again compare/studies/campaign.json).",
                )
            ),
            Table.from_rows(
                "stability-campaign",
                "Outcomes of solving random extreme screws, bearings and shafts",
                extremes.campaign_table_rows(extremes.built_in_campaign_records()),
            ),
        ),
        conclusion=f"Energy minimisation solves {solved} of {total} stiff and extreme cases from a cold start; "
        f"Newton's method as in Lin's thesis, from the best of three start vectors, solves {newton} of the {applicable} to "
        "which it applies.",
    )
