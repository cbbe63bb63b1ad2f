"""Report sections on numerical stability in stiff and extreme scenes, and on errors on randomly drawn screws."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.overview import NAMES, screws_within_limit_text
from rollbench.compare.sections.fit import WORDS
from rollbench.compare.studies import extremes, survey
from rollbench.compare.studies.survey import MODELS
from rollbench.compare.studies.survey_models import LoadErrorsAndTimes, errors_and_times_of_models, load_timed_level_runs
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, TableColumn, Text, load_percent_column

#: Keys, in the stored records, of the errors in the table of all screws, by the descriptions in its column headings.
SHORT = {
    "largest contact-load error": "largest_percent",
    "RMS error of the contact loads": "rms_percent",
    "expected largest error": "expected_percent",
}
#: Headings of the table of error statistics, by the keys `survey.SUMS` of its rows.
HEADINGS = {
    "model": "model",
    "error": "kind of error",
    "scenes": "number of screws",
    "median": "median error over the screws",
    "p95": "95th percentile of the error",
    "largest": "largest error on a screw",
}
#: Columns of the table of models and mesh levels: key, heading, unit, number format, and which percentile [%] of which
#: field of `LoadErrorsAndTimes` is shown.
STATISTICS = (
    (
        "median",
        "largest contact-load error relative to contact's load (if small: mean load), median",
        "%",
        ".2f",
        "gate_errors",
        50,
    ),
    (
        "p95",
        "largest contact-load error relative to contact's load (if small: mean load), 95th percentile",
        "%",
        ".2f",
        "gate_errors",
        95,
    ),
    ("mean_median", "largest contact-load error, median", "% of mean load", ".2f", "errors_of_mean_load", 50),
    ("mean_p95", "largest contact-load error, 95th percentile", "% of mean load", ".2f", "errors_of_mean_load", 95),
    ("seconds", "CPU time for a new screw, median", "s", "g3", "first_case_seconds", 50),
    ("slowest", "CPU time for a new screw, 95th percentile", "s", "g3", "first_case_seconds", 95),
    ("further", "CPU time for a further load case, median", "s", "g3", "further_case_seconds", 50),
)
#: Number of bins of the histogram, and distance up to which a ball counts as near a nut face [ball radii].
BINS, NEAR = 24, 2.0


def survey_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the section on contact-load errors of the low-order models on randomly drawn catalogue screws.

    It has the histogram of errors, errors near nut faces, errors over run time, and a table of all screws.

    ``step`` is called with each line of progress.
    """
    step("stored results of the randomly drawn screws")
    every = survey.built_in_survey()["scenes"]
    scenes = survey.records_of_screws_known_before()
    title = "Contact-load errors of the models on randomly drawn catalogue screws"
    if not scenes:
        return Section("survey", title, (Text(("No results of randomly drawn screws are stored.",)),))
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
    errors = {f"{model}: {short}": (model, key) for model in MODELS for short, key in SHORT.items()}
    rows: list[dict[str, Any]] = [
        {"scene": r["number"], "screw": r["title"].partition(": ")[2], "contacts": r.get("contacts"), "status": r["status"]}
        | {name: r.get("models", {}).get(model, {}).get(key) for name, (model, key) in errors.items()}
        for r in every
    ]
    gate = {}
    for model in MODELS:
        known = (r["models"][model].get("gate_percent") for r in scenes if model in r.get("models", {}))
        gate[model] = np.array([error for error in known if error is not None])
    passed = screws_within_limit_text(gate)
    texts, summary = survey.SUMS[:3], survey.error_summary_rows_of_all_models(scenes)
    items = (
        random_screw_error_figure(scenes),
        Text((about,)),
        Table(
            "stability-survey",
            "Median, 95th percentile and maximum of the models' errors on all randomly drawn screws",
            [TableColumn(key, HEADINGS[key], *(("", "s") if key in texts else ("%", ".2f"))) for key in survey.SUMS],
            [row | {"error": WORDS[row["error"].removeprefix("largest_")]} for row in summary],
        ),
        *error_and_run_time_items(cache, scenes),
        *_items_on_screws_drawn_later(scenes, survey.records_of_screws_drawn_later()),
        *double_nut_items(),
        Table(
            "stability-survey-scenes",
            "Contact-load errors of the refined model and Lin's model on each randomly drawn screw",
            (
                TableColumn("scene", "number of the screw", "", "s"),
                TableColumn("screw", "screw: outer diameter [mm] x lead [mm], kind of preload", "", "s"),
                TableColumn("contacts", "number of contacts", "", "s"),
                TableColumn("status", "solver status of the 3D reference", "", "s"),
                *(load_percent_column(name, name) for name in errors),
            ),
            rows,
            csv_only=[f"{model}: expected largest error" for model in MODELS],
        ),
    )
    return Section("survey", title, items, conclusion=f"Randomly drawn {passed[:1].lower()}{passed[1:]}.")


def error_and_run_time_items(
    cache: SceneResultCache, screw_records: Sequence[survey.Record]
) -> tuple[Text | Table | Figure, ...]:
    """Return figure, text and table of load errors and run times of models and 3D mesh levels on random screws.

    Parameters
    ----------
    cache
        Source of the stored runs of the 3D reference.
    screw_records
        Stored results of the randomly drawn screws.
    """
    kept = load_timed_level_runs((*(cache.reference_folders or ()), shipped_store()))
    if kept is None:
        text = "Run times of mesh levels on drawn screws are not stored; `rollbench bench --drawn` measures them."
        return (Text((text,)),)
    found = errors_and_times_of_models(kept.runs, screw_records)
    timed = [s for s in found if s.gate_errors.size]
    about = (
        f"Mesh level 2 of the 3D reference was solved on {len({run.number for run in kept.runs})} screws, chosen at random "
        "with a fixed seed. The error of level 1 is its difference from level 2; the error of level 2 is not known from "
        "these runs. Times are processor times of one core. For a new screw they count from its geometry to its loads, "
        "with an empty mesh cache and without start and imports of Python; then for a further load case of the same screw. "
        f"Times of the 3D reference were measured with {kept.measuring_conditions}, {kept.date}; those of the models when "
        "all drawn screws were solved."
    )
    rows: list[Row] = [
        {
            TableColumn("model", "model or mesh level", "", "s"): s.name,
            TableColumn("screws", "number of screws", "", "s"): s.first_case_seconds.size,
            TableColumn("against", "solution against which errors are computed", "", "s"): s.reference_level or "not known",
            **{
                TableColumn(key, heading, unit, form): _percentile(getattr(s, field), percent)
                for key, heading, unit, form, field, percent in STATISTICS
            },
        }
        for s in found
    ]
    keys = [(f"time_proposed_{case}", f"case{case}_max_error") for case in (1, 2)]
    lin = [(printed_value("lin-2.2", time), printed_value("lin-2.4.1", error)) for time, error in keys]
    panels = tuple(_error_over_time_panel(timed, name, lin) for name in ("new screw", "further load case"))
    coarse = next((s for s in timed if s.name.startswith("3D")), None)
    title = (
        "Contact-load errors of models and 3D mesh levels on randomly drawn screws, plotted against processor time"
        if coarse is None
        else "Largest difference of a contact load between 3D mesh levels 1 and 2 on a randomly drawn screw: median "
        f"{_percentile(coarse.gate_errors, 50):.2f} %; level 1 takes "
        f"{_percentile(coarse.first_case_seconds, 50):.0f} s per screw"
    )
    counts = {s.reference_level: s.first_case_seconds.size for s in timed}
    markers = " ".join(
        f"{shape}: {count} screws, errors against {by} of the 3D reference."
        for shape, (by, count) in zip(("Circles", "Squares"), counts.items(), strict=False)
    )
    caption = (
        f"Markers: median of the largest error on a screw, {RULE}; bars: up to the 95th percentile. {markers} Horizontal "
        f"line: {LIMIT:g} %, the default limit of the command rollbench check. Pale points: errors against ANSYS, and run "
        "times, that Lin's thesis prints."
    )
    return (
        Figure("survey-levels", title, panels, caption, columns=2),
        Text((about,)),
        Table.from_rows(
            "stability-levels",
            "Contact-load errors and run times of models and 3D mesh levels on randomly drawn screws",
            rows,
            f"Rule of rollbench check: errors {RULE}.",
        ),
    )


def _percentile(values: Array, percent: float) -> float | None:
    """Return a percentile of the numbers in ``values`` (``percent``: 0 to 100); None if the array is empty."""
    return float(np.percentile(values, percent)) if values.size else None


def _error_over_time_panel(
    models: Sequence[LoadErrorsAndTimes], time_kind: str, printed_by_lin: Sequence[tuple[float, float]]
) -> Panel:
    """Return the panel of largest contact-load errors of models and 3D mesh levels over processor time, on random screws.

    Parameters
    ----------
    models
        Errors and times of each model or mesh level.
    time_kind
        Abscissa: time for a "new screw" or for a "further load case" of a screw solved before.
    printed_by_lin
        Run time [s] and largest error [%] that Lin's thesis prints for its model, in case studies 1 and 2.
    """
    new = time_kind == "new screw"
    places = [
        (float(np.median(s.first_case_seconds if new else s.further_case_seconds)), float(np.median(s.gate_errors)), s)
        for s in models
    ]
    series = []
    for by in dict.fromkeys(s.reference_level for s in models):
        times, errors, shown = zip(*(place for place in places if place[2].reference_level == by), strict=True)
        bars = (errors, [float(np.percentile(s.gate_errors, 95)) for s in shown])
        label, names = f"{shown[0].first_case_seconds.size} screws, against {by}", [s.name for s in shown]
        series.append(Series(label, times, errors, "markers", bold=True, error_bars=bars, point_labels=names))
    edge: list[tuple[float, float]] = []
    for x, y, _ in sorted(places, key=lambda place: place[:2]):
        if not edge or y < edge[-1][1]:
            edge.append((x, y))
    series.append(Series("Pareto front", [x for x, _ in edge], [y for _, y in edge], "line"))
    if new:
        times, errors = zip(*printed_by_lin, strict=True)
        series.append(Series("Lin's thesis, printed", times, errors, "markers", pale=True))
    ends = [x for x, *_ in places]
    series.append(Series(f"limit of {LIMIT:g} %", [min(ends), max(ends)], [LIMIT, LIMIT], "line"))
    label = f"processor time of a {time_kind} / s"
    return Panel("", label, "largest contact-load error as judged by rollbench check / %", tuple(series), log_axes="xy")


def _items_on_screws_drawn_later(
    screws_known_before: list[dict[str, Any]], screws_drawn_later: list[dict[str, Any]]
) -> tuple[Text | Table, ...]:
    """Return text and table of the models' errors on screws drawn before and after their last change.

    Parameters
    ----------
    screws_known_before
        Stored results of the screws that were known while the model was developed.
    screws_drawn_later
        Stored results of the screws drawn after its last change; if there are none, the returned tuple is empty.
    """
    if not screws_drawn_later:
        return ()
    aims = f"load error within {survey.WORST_AIM:g} % on every contact and within {survey.RMS_AIM:g} % RMS"
    about = (
        "The screws drawn later are of the same seed, all with a nut fixed at its flange. They were compared once, after "
        "the last change of the models; their errors are those of a new screw of this kind. The last column counts by the "
        "error to expect as it was estimated then, from the screws drawn before by leave-one-out. The error to expect is "
        "now calibrated by split conformal prediction, with the screws drawn later among the calibrating ones."
    )
    groups = {"drawn before the last change": screws_known_before, "drawn later": screws_drawn_later}
    rows: list[Row] = []
    for model in MODELS:
        for name, records in groups.items():
            found = survey.model_accuracy_on_random_screws(records, model)
            rows.append(
                {
                    TableColumn("model", "model", "", "s"): model,
                    TableColumn("group", "screws", "", "s"): name,
                    TableColumn("screws", "number of screws", "", "s"): found.screw_count,
                    load_percent_column("median", "largest contact-load error, median"): found.median_error,
                    load_percent_column("p95", "largest contact-load error, 95th percentile"): found.percentile_95,
                    load_percent_column("largest", "largest contact-load error on a screw"): found.largest_error,
                    TableColumn("aims", aims, "", "s"): found.within_aims,
                    TableColumn(
                        "expected", "largest error not above the error expected then", "", "s"
                    ): found.within_expected_error,
                }
            )
    title = "Contact-load errors of the models on screws drawn before and after their last change"
    return Text((about,)), Table.from_rows("stability-unseen", title, rows)


def double_nut_items() -> tuple[Text | Table, ...]:
    """Return text and table of the models' errors on the drawn double nuts and the shipped one; empty without records."""
    records = survey.built_in_survey("double nut")["scenes"]
    if not records:
        return ()
    good = [r for r in records if r.get("models")]
    sums = {
        model: survey.model_accuracy_on_random_screws(good, model)
        for model in MODELS
        if any(model in r["models"] for r in good)
    }
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
        row: Row = {
            TableColumn("scene", "number of the drawn double nut, or name of the scene", "", "s"): r["number"],
            TableColumn("title", "size, kind of preload", "", "s"): r.get("title", "").partition(": ")[2],
            TableColumn("status", "solver status of the 3D reference", "", "s"): r["status"],
        }
        for model in MODELS:
            found = r.get("models", {}).get(model, {})
            row |= {
                load_percent_column(model, f"{model}: largest contact-load error"): found.get("largest_percent"),
                TableColumn(f"{model} at", f"{model}: nut, ball and flank", "", "s"): found.get("at", ""),
                load_percent_column(f"{model} expected", f"{model}: expected largest error"): found.get("expected_percent"),
            }
        row[load_percent_column("bar", "numerical uncertainty of the 3D reference")] = None if bars is None else max(bars)
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
        Panel("Distribution of the error", error, "number of screws", bars, log_axes="x", include_zero=True),
        Panel("Error near a nut face", distance, error, points, log_axes="y"),
    )
    near = "; ".join(
        f"{_median_errors_near_faces_text(errors)} with {NAMES.get(name, name)}" for name, errors in found.items()
    )
    title = f"Median of the largest contact-load error on a screw, in per cent of the mean load: {near}"
    return Figure(
        "survey",
        title,
        panels,
        f"{len(screw_records)} randomly drawn screws. Of the two medians of each model, the first is for screws with a "
        f"ball closer than {NEAR:g} ball radii to a nut face, the second for the other screws. First panel: histogram of "
        "the errors on a logarithmic abscissa.",
    )


def _median_errors_near_faces_text(errors: Array) -> str:
    """Return two median errors as text: of screws with a ball closer than `NEAR` to a nut face, and of the other screws.

    ``errors``: distance of the outermost ball [ball radii] and largest error [% of the mean load] of n screws, (n, 2).
    """
    near = errors[:, 0] < NEAR
    return " and ".join(f"{np.median(errors[one, 1]):.2g} %" for one in (near, ~near) if one.any())


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
        {
            TableColumn("formulation", "formulation of the equations", "", "s"): name,
            TableColumn("solved", "number of cases solved", "", "s"): solved,
            TableColumn("tried", "number of cases to which the formulation applies", "", "s"): tried,
            TableColumn("cases", "number of all cases", "", "s"): total,
        }
        for name, (solved, tried, total) in counts.items()
    ]
    columns = (
        TableColumn("case", "stiff or extreme case", "", "s"),
        TableColumn(extremes.ENERGY, "status of the energy solver", "", "s"),
        TableColumn("iterations", "iterations of the energy solver", "", "s"),
        TableColumn("residual", "largest unbalanced force / largest force", "", "g2"),
        TableColumn("bound", "round-off limit of unbalanced / largest force, in double precision", "", "g2"),
        *(TableColumn(name, f"status: {name}", "", "s") for name in extremes.formulations()[1:]),
    )
    solved, _, total = counts[extremes.ENERGY]
    newton, applicable, _ = max(counts[name] for name in extremes.formulations_of_cases())
    return Section(
        "stability",
        "Numerical stability of the solvers on stiff and extreme cases",
        (
            Text(
                (
                    "Each case is solved by minimising the convex energy from a cold start; by the formulation of the same "
                    "equations in contact forces, which must give the same loads; and by the models with elastic bodies. "
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
                columns,
                extremes.stability_table_rows(rows),
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
