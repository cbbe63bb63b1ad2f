"""First page of the validation report: errors of low-order models against the 3D reference, and their run times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.evidence import all_computations, evidence_of_all_tables
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import SMALL, load_scale_of_check_errors
from rollbench.compare.models.comparison import REFERENCED, RULE
from rollbench.compare.models.model_form import MeasuredModelErrors, model_errors_on_random_screws
from rollbench.compare.models.modelling import UNSEEN, solve_refinement_sequence_on_all_scenes
from rollbench.compare.models.modelling import model_errors_on_built_in_scenes as compared_points
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import CONTACTS, bias_and_scatter, uncertainty_of_loads
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.sections import reference_time
from rollbench.compare.sections.source_tables import counts_of_reproduced_numbers_table
from rollbench.compare.sections.u_val import validated_errors_of_models
from rollbench.compare.studies import extremes, survey
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Summary, Table, TableColumn, Text, text_column

QUESTION = "How accurate are low-order models of ball screws, and how much run time does a more accurate model take?"
TITLE = (
    "Contact-load errors of the models on all compared screws, and contact-load error of each model and 3D mesh level, "
    "plotted against its run time"
)
#: Families of models, which share a colour, with the names of their models.
FAMILIES = (
    ("refined", ("refined",)),
    (
        "Lin's model and extensions of it",
        ("lin", "lin-source-partition", "lin-printed-hertz", "lin-cell", "lin-nut", "source"),
    ),
    ("axial bars", ("mei", "mei-nut", "liu")),
    ("bodies condensed from 3D", ("condensed",)),
)
#: Family name of all 3D meshes.
SOLID = "3D reference"
#: Columns of the table of the models' errors in every quantity: mean error, scatter and largest error.
BIAS = TableColumn("bias", "mean error (bias) of the model", "%", "+.2f")
SCATTER = TableColumn("scatter", "standard deviation (scatter) of the error", "%", ".2f")
LARGEST = TableColumn("largest", "largest error on a screw or bearing", "%", ".1f")
#: Columns of the table of models and mesh levels: field of `ModelAccuracy`, key, heading, unit, and number format.
ACCURACY_COLUMNS = (
    ("name", "name", "model or mesh level", "", "s"),
    ("label", "label", "long name of the model or mesh level", "", "s"),
    ("scene_count", "scenes", "number of screws and bearings", "", "s"),
    ("median_error_percent", "median", "largest contact-load error, median over the scenes", "% of mean load", ".2f"),
    ("largest_error_percent", "worst", "largest contact-load error, maximum over the scenes", "% of mean load", ".2f"),
    ("scene_of_largest_error", "at", "screw or bearing with the largest contact-load error", "", "s"),
    ("median_rms_error_percent", "rms", "RMS error of the contact loads, median over the scenes", "% of mean load", ".2f"),
    (
        "largest_rms_error_percent",
        "worst_rms",
        "RMS error of the contact loads, maximum over the scenes",
        "% of mean load",
        ".2f",
    ),
    (
        "median_gate_error.error",
        "gate",
        "largest contact-load error relative to contact's load (if small: mean load), median",
        "%",
        ".2f",
    ),
    (
        "passed_scene_count",
        "passed",
        f"number of screws and bearings with all contact-load errors within {LIMIT:g} %",
        "",
        "s",
    ),
    ("cold_start_seconds", "cold", "run time of a cold start, median", "s", "g3"),
)
#: Models that represent their family in figures and tables.
KINDS = {DEFAULT: "refined", "lin": "lin"}
#: Names of these models in a sentence.
NAMES = {DEFAULT: "the refined model", "lin": "Lin's model"}
#: How the first page introduces them.
WHOSE = {
    DEFAULT: "The refined model, rollbench's default (elastic screw, nut and balls)",
    "lin": "Lin's model, as in the thesis (beam, rigid nut, Hertz springs)",
}
#: What no model computes.
LEFT_OUT = (
    "No model computes a lubrication film, plastic deformation, wear or the dynamics of the balls' return. Static loads "
    "are without friction; friction of the balls is computed on request."
)


@dataclass(frozen=True)
class ModelAccuracy:
    """Contact-load errors and run time of one model or 3D mesh level, summarised over the shipped scenes.

    For the finest mesh level, which is the reference, its mesh uncertainty takes the place of the error.
    """

    #: Short name of the model or mesh level, for figures.
    name: str
    #: Name of the model or mesh level in tables.
    label: str
    #: Name of the family of models to which the model or mesh level belongs; it determines the colour (see
    #: `model_family`).
    family: str
    #: Number of scenes on which the model or mesh converged.
    scene_count: int
    #: Largest error of a contact load on any of the scenes [% of the mean load of that scene].
    largest_error_percent: float
    #: Name of the scene with the largest contact-load error of the model or mesh level.
    scene_of_largest_error: str
    #: Median over the scenes of the largest error [% of the mean load].
    median_error_percent: float
    #: Median over the scenes of the RMS error of the contact loads [% of the mean load].
    median_rms_error_percent: float
    #: Largest RMS error over the scenes [% of the mean load].
    largest_rms_error_percent: float
    #: Median over the scenes of the time of a solution in a new process with empty caches (cold start) [s]; None: not
    #: measured.
    cold_start_seconds: float | None
    #: Median over the scenes of the largest error as ``rollbench check`` judges it, in per cent of the contact's load
    #: (for nearly unloaded contacts, of the mean load), and medians of the ends of its range.
    median_gate_error: reference_time.LargestErrorWithRange
    #: Number of scenes that pass ``rollbench check`` with its default limit.
    passed_scene_count: int


def model_family(point: reference_time.ErrorAndRunTime) -> str:
    """Return the name of the family of models to which a low-order model or 3D mesh belongs.

    ``point``: error and run time of this model or mesh on a scene. Families of models are those of `FAMILIES`; a model that
    is in none of them forms its own family, named by its label. All 3D meshes form one family.
    """
    if point.kind != "model":
        return SOLID
    return next((family for family, names in FAMILIES if point.name in names), point.label)


def largest_error_or_mesh_uncertainty(point: reference_time.ErrorAndRunTime) -> float:
    """Return the largest contact-load error of a model or 3D mesh on a scene [% of the mean load].

    ``point``: errors and run time of the model or mesh. For the finest mesh level, which is the reference, its mesh
    uncertainty is returned.
    """
    return point.high if point.error == 0.0 and point.high is not None else point.error


def check_error_or_mesh_uncertainty(point: reference_time.ErrorAndRunTime) -> reference_time.LargestErrorWithRange:
    """Return the largest contact-load error of a model or 3D mesh on a scene as ``rollbench check`` judges it [%].

    The error is in per cent of the contact's reference load or, for a nearly unloaded contact, of the mean contact load.
    ``point``: errors and run time of the model or mesh. For the finest mesh level, which is the reference, its mesh
    uncertainty takes the place of the error.
    """
    return replace(point.gate, error=point.gate.high) if point.gate.error == 0.0 else point.gate


def summarise_accuracy_by_model(points: Mapping[str, Sequence[reference_time.ErrorAndRunTime]]) -> list[ModelAccuracy]:
    """Return errors and run times of every model and 3D mesh level, summarised over the scenes; least accurate first.

    Parameters
    ----------
    points
        Errors and run time of each model and mesh level, by name of the scene.
    """
    found: dict[str, list[tuple[str, reference_time.ErrorAndRunTime]]] = {}
    for scene, several in points.items():
        for point in several:
            if point.status == "converged" and largest_error_or_mesh_uncertainty(point) > 0.0:
                found.setdefault(point.label, []).append((scene, point))
    every = (_summarise_model_accuracy(label, group) for label, group in found.items())
    return sorted(every, key=lambda s: -s.median_error_percent)


def _summarise_model_accuracy(
    label: str, points_by_scene: Sequence[tuple[str, reference_time.ErrorAndRunTime]]
) -> ModelAccuracy:
    """Return the errors and run time of one model or mesh level, as medians and maxima over the scenes.

    ``label``: name of the model or mesh level in tables. ``points_by_scene``: pairs of a scene's name, and errors and run
    time on this scene.
    """
    first = points_by_scene[0][1]
    errors = [largest_error_or_mesh_uncertainty(p) for _, p in points_by_scene]
    k = int(np.argmax(errors))
    times = [p.cold for _, p in points_by_scene if p.cold is not None]
    gate = [check_error_or_mesh_uncertainty(p) for _, p in points_by_scene]
    return ModelAccuracy(
        name=first.name,
        label=label,
        family=model_family(first),
        scene_count=len(points_by_scene),
        largest_error_percent=errors[k],
        scene_of_largest_error=points_by_scene[k][0],
        median_error_percent=float(np.median(errors)),
        median_rms_error_percent=float(np.median([p.rms for _, p in points_by_scene])),
        largest_rms_error_percent=max(p.rms for _, p in points_by_scene),
        cold_start_seconds=float(np.median(times)) if times else None,
        median_gate_error=reference_time.LargestErrorWithRange(
            *(float(np.median(ends)) for ends in zip(*((g.error, g.low, g.high) for g in gate), strict=True))
        ),
        passed_scene_count=sum(g.high <= LIMIT for g in gate),
    )


def pareto_optimal_models(accuracies: Sequence[ModelAccuracy]) -> list[ModelAccuracy]:
    """Return the Pareto-optimal models and mesh levels, fastest first: no other is both faster and more accurate.

    ``accuracies``: errors and run times of all models and mesh levels. The compared error is the median over the scenes of
    the largest contact-load error, as ``rollbench check`` judges it. The compared time is that of a cold start (new process
    with empty caches).
    """
    best: list[ModelAccuracy] = []
    timed = (s for s in accuracies if s.cold_start_seconds is not None)
    for one in sorted(timed, key=lambda s: (s.cold_start_seconds, s.median_gate_error.error)):
        if not best or one.median_gate_error.error < best[-1].median_gate_error.error:
            best.append(one)
    return best


def error_distribution_and_time_figure(
    largest_errors: Mapping[str, Array],
    points: Mapping[str, Sequence[reference_time.ErrorAndRunTime]],
    name: str,
    size: tuple[float, float],
    *,
    label_all_models: bool = True,
) -> Figure:
    """Draw two panels: distribution of load errors over all compared screws, and load error over cold-start time.

    Compared screws are those with a 3D reference. A cold start is a solution in a new process with empty caches.

    Parameters
    ----------
    largest_errors
        Largest contact-load error on each screw, in ascending order [% of the mean load], by model.
    points
        Errors and run time of each model and mesh level, by name of the scene.
    name
        File name of the figure.
    size
        Width and height [inches].
    label_all_models
        Whether all models and mesh levels are labelled; if not, only those of `KINDS` and of the Pareto front.
    """
    points = {name: [p for p in several if p.cold is not None] for name, several in points.items()}
    time = _error_over_time_panel(points, "run time of a cold start / s", label_all_models=label_all_models)
    counts = " and ".join(sorted({str(errors.size) for errors in largest_errors.values()}))
    caption = (
        f"First panel: share of {counts} screws whose largest contact-load error is below the abscissa value. Second "
        f"panel: error against run time. {TIMED} Cold start: a new process with empty caches."
    )
    panels = (error_distribution_panel(largest_errors), time)
    return Figure(name, TITLE, panels, caption, columns=2 if label_all_models else 1, size=size)


#: Caption of a panel of errors over run time.
TIMED = (
    f"The error is the largest contact-load error on a screw or bearing, {RULE}. Horizontal line: {LIMIT:g} %, the "
    "default limit of the command rollbench check. Light points: one screw or bearing each; dark markers: their medians; "
    "bars: range due to the mesh uncertainty of the 3D reference. The finest mesh level is the reference itself, drawn at "
    "its own uncertainty. Condensed model: stiffness of screw and nut from a 3D computation, its run time not included."
)


def error_distribution_panel(largest_errors: Mapping[str, Array]) -> Panel:
    """Return the panel of the cumulative distribution of the largest contact-load error over all screws with a reference.

    Parameters
    ----------
    largest_errors
        Largest error on each screw, in ascending order [% of the mean load], by model.
    """
    series = []
    for model, errors in largest_errors.items():
        share = 100.0 * np.arange(1, errors.size + 1) / max(errors.size, 1)
        series.append(Series(model, errors.tolist(), share.tolist(), "line", bold=True))
    x, y = "largest contact-load error / % of the mean contact load", "share of screws up to this error / %"
    return Panel("", x, y, series, log_axes="x", include_zero=True)


def error_over_further_load_case_time_figure(points: Mapping[str, Sequence[reference_time.ErrorAndRunTime]]) -> Figure:
    """Draw the largest load error of each model and 3D mesh level over the time of a further load case of a known geometry.

    ``points``: errors and run times of each model and mesh level, by name of the scene.
    """
    warm = {name: [replace(p, cold=p.warm) for p in several if p.warm is not None] for name, several in points.items()}
    panel = _error_over_time_panel(warm, "run time of a further load case / s", label_all_models=True)
    title = "Largest contact-load error of each model and 3D mesh level against the run time of a further load case"
    return Figure("error-time-further", title, (panel,), TIMED, columns=1)


def largest_load_errors_on_screws(points: Sequence[MeasuredModelErrors]) -> dict[str, Array]:
    """Return the largest contact-load error on each compared screw, in ascending order [% of the mean load], by model.

    ``points``: errors against the 3D reference, one record for each model and compared scene. Bearings (scenes without
    lead) are left out.
    """
    of_screws = [p for p in points if p.features["lead"] > 0.0]
    return {model: np.sort([p.percent for p in of_screws if p.model == model]) for model in KINDS}


def largest_check_errors_on_screws(points: Sequence[MeasuredModelErrors]) -> dict[str, Array]:
    """Return the largest load error on each compared screw as ``rollbench check`` judges it [%], by model.

    The error is in per cent of the contact's reference load or, for a nearly unloaded contact, of the mean contact load.
    ``points``: errors against the 3D reference, one record for each model and compared scene. Bearings (scenes without
    lead) are left out.
    """
    known = [(p.model, p.gate_percent) for p in points if p.features["lead"] > 0.0 and p.gate_percent is not None]
    return {model: np.array([error for name, error in known if name == model]) for model in KINDS}


def _error_over_time_panel(
    points: Mapping[str, Sequence[reference_time.ErrorAndRunTime]], label: str, *, label_all_models: bool
) -> Panel:
    """Return the panel of load errors over run time: a point per scene and model, medians, and the Pareto front.

    The errors are the largest on each scene as ``rollbench check`` judges them: in per cent of the contact's reference
    load or, for a nearly unloaded contact, of the mean contact load.

    Parameters
    ----------
    points
        Errors and run times of each model and mesh level, by name of the scene; the field ``cold`` is the drawn time [s].
    label
        Label of the time axis.
    label_all_models
        Whether the medians of all models are labelled; if not, only those of `KINDS` and of the Pareto front.
    """

    def drawn(errors: Iterable[float]) -> list[float]:
        """Return errors [%] as ordinates of the logarithmic panel; errors below its range are set to its lower end."""
        return [max(error, reference_time.FLOOR) for error in errors]

    accuracies = summarise_accuracy_by_model(points)
    others = [model_family(p) for several in points.values() for p in several]
    families = list(dict.fromkeys([*(family for family, _ in FAMILIES), SOLID, *others]))
    series = []
    for family in families:
        of_family = [(name, p) for name, several in points.items() for p in several if _is_drawn_in_family(p, family)]
        shown = [(scene, p, p.cold) for scene, p in of_family if p.cold is not None]
        times, names = [cold for *_, cold in shown], [f"{p.name}, {scene}" for scene, p, _ in shown]
        errors = drawn(check_error_or_mesh_uncertainty(p).error for _, p, _ in shown)
        series.append(Series(family, times, errors, "markers", pale=True, point_names=names))
    edge = pareto_optimal_models(accuracies)
    times = [s.cold_start_seconds for s in edge if s.cold_start_seconds is not None]
    errors, names = drawn(s.median_gate_error.error for s in edge), [s.name for s in edge]
    series.append(Series("Pareto front of the medians", times, errors, "line", point_names=names))
    for family in families:
        mids = [s for s in accuracies if s.family == family]
        bars = drawn(s.median_gate_error.low for s in mids), drawn(s.median_gate_error.high for s in mids)
        series.append(
            Series(
                family,
                [s.cold_start_seconds for s in mids if s.cold_start_seconds is not None],
                drawn(s.median_gate_error.error for s in mids),
                "markers",
                bold=True,
                error_bars=bars,
                point_labels=[s.name if label_all_models or s in edge or s.name in KINDS else "" for s in mids],
                point_names=[f"{s.name}, median of {s.scene_count} scenes" for s in mids],
            )
        )
    series = [s for s in series if len(s.x)]
    times = [p.cold for several in points.values() for p in several if p.cold is not None]
    if times:
        series.append(Series(f"limit of {LIMIT:g} %", [min(times), max(times)], [LIMIT, LIMIT], "line"))
    return Panel("", label, "largest contact-load error as judged by rollbench check / %", tuple(series), log_axes="xy")


def _is_drawn_in_family(point: reference_time.ErrorAndRunTime, family: str) -> bool:
    """Return whether the error-over-time figure shows the result of a model on a scene in the colour of a model family.

    ``point``: error and run time of the model on the scene. It is shown if the model belongs to ``family`` and converged,
    and if the error is above zero.
    """
    return point.status == "converged" and largest_error_or_mesh_uncertainty(point) > 0.0 and model_family(point) == family


def answers(
    compared_screw_count: int,
    gate_errors: Mapping[str, Array],
    mesh_uncertainties: Sequence[float],
    total_uncertainty: float | None = None,
) -> list[tuple[str, str]]:
    """Return the answers on the first page, each with its heading.

    Parameters
    ----------
    compared_screw_count
        Number of screws compared with the 3D reference.
    gate_errors
        Largest error on each screw as ``rollbench check`` judges it, by model [% of the contact's reference load or, for a
        nearly unloaded contact, of the mean load].
    mesh_uncertainties
        Mesh uncertainty of the 3D reference for each scene [% of the mean load].
    total_uncertainty
        Largest uncertainty of a 3D contact load in Lin's case studies by mesh, modelling choices and input tolerances
        together [% of the mean load]; None: not known.
    """
    whole = (
        ""
        if total_uncertainty is None
        else f"; with modelling choices and the tolerances of the input added, at most {total_uncertainty:.1f} % on Lin's "
        "case studies"
    )
    known = (
        "Each contact load is compared with that of a 3D elastic-contact reference, which shares no code with the models. "
        f"{_mesh_uncertainty_clause(mesh_uncertainties)}{whole}. In all, {compared_screw_count} screws were compared. "
        f"{screws_within_limit_text(gate_errors)}."
    )
    found = {
        "How wrong": errors_on_screws_drawn_later_text(),
        "How that is known": known,
        "Stiff and extreme cases": stability_sentence(extremes.built_in_campaign_records()),
        "Left out": LEFT_OUT,
    }
    return [(heading, text) for heading, text in found.items() if text]


def errors_on_screws_drawn_later_text() -> str:
    """Return the sentences on the models' errors on screws that were drawn after their last change, Lin's model first.

    They are empty if no such screw is stored.
    """
    records = survey.records_of_screws_drawn_later()
    found = {name: survey.model_accuracy_on_random_screws(records, name) for name in reversed(survey.MODELS)}
    texts = [
        f"{WHOSE[name]}: {one.median_error:.2g} % of the mean load in the median, at most {one.percentile_95:.2g} % on 19 "
        f"of 20 screws, at most {one.largest_error:.2g} % on all"
        for name, one in found.items()
        if one.screw_count
    ]
    if not texts:
        return ""
    return (
        f"Largest error of a contact load on {found[DEFAULT].screw_count} screws with a flanged nut, drawn after the "
        f"models last changed and solved once. {'. '.join(texts)}."
    )


def stability_sentence(records: Sequence[extremes.Record]) -> str:
    """Return the sentence on drawn extreme screws and axes of the newest version; empty without records of campaigns."""
    if not records:
        return ""
    newest = [r for r in records if r["version"] == records[-1]["version"]]
    counts = [r["scenes"] for r in newest]
    judged = {v: sum(c.get(v, 0) for c in counts) for v in (*extremes.GOOD, *extremes.BAD)}
    bad, right = sum(judged[v] for v in extremes.BAD), judged[extremes.RIGHT]
    mended = sum(one.get("again", {}).get("verdict") in extremes.GOOD for r in newest for one in r["bad"])
    return (
        f"Of {sum(judged.values())} screws and axes drawn at random from far beyond what is built (version "
        f"{newest[-1]['version']}), {right} are solved, each judged by Hertz's law and the balance of forces computed by "
        f"other code; {sum(judged.values()) - right - bad} are refused, as impossible input or with a proof; {bad} "
        f"{'was' if bad == 1 else 'were'} wrong or ended without a reason"
        + (f", {mended} of them mended since." if mended else ".")
    )


def screws_within_limit_text(gate_errors: Mapping[str, Array]) -> str:
    """Return the clause on the number of screws on which all load errors of a model are within the default limit of 7 %.

    Parameters
    ----------
    gate_errors
        Largest load error on each screw as ``rollbench check`` judges it, by model [% of the contact's reference load or,
        for a nearly unloaded contact, of the mean load]; if empty, the clause is empty.
    """
    found = {NAMES[model]: of_model for model, of_model in gate_errors.items() if of_model.size}
    counts = [f"{(e <= LIMIT).sum()} of {e.size} with {name}" for name, e in found.items()]
    return f"Every contact load is within {LIMIT:g} %, {RULE}, on {', '.join(counts)}" if counts else ""


def _mesh_uncertainty_clause(mesh_uncertainties: Sequence[float]) -> str:
    """Return the clause on the uncertainty of the 3D contact loads by the mesh alone, as a range over the scenes.

    ``mesh_uncertainties``: mesh uncertainty of each scene [% of the mean load].
    """
    if not mesh_uncertainties:
        return "The uncertainty of the 3D reference by its mesh is unknown (one mesh level only)"
    low, high = f"{min(mesh_uncertainties):.1f}", f"{max(mesh_uncertainties):.1f}"
    text = low if low == high else f"{low} to {high}"
    return f"The mesh makes the reference uncertain by {text} % of the mean load"


def random_screws_paragraph(random_screw_count: int) -> str:
    """Return the paragraph on the randomly drawn screws that were compared with the 3D reference.

    ``random_screw_count`` is their number.
    """
    return (
        f"{random_screw_count} catalogue screws, drawn at random with a fixed seed, none replaced, were compared with mesh "
        "level 1 of the 3D reference (section survey of the page on contact-load errors). Finer mesh levels, run times and "
        "results of rollbench check are shown for the shipped scenes:"
    )


def compared_scenes_paragraphs(scenes: Mapping[str, Scene], references: Mapping[str, Reference]) -> list[str]:
    """Return paragraphs on the scenes with a 3D reference: number, origin, ranges of lead, diameter and number of balls.

    Parameters
    ----------
    scenes
        Scenes by name.
    references
        3D reference of each scene.
    """
    if not scenes:
        return []
    every = list(scenes.values())

    def span(values: Sequence[float], unit: str) -> str:
        low, high = f"{min(values):.4g}", f"{max(values):.4g}"
        return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"

    cases, unseen = sum(name in REFERENCED for name in scenes), sum(name in UNSEEN for name in scenes)
    contacts = [int((ref.load > 0.0).sum()) for ref in references.values()]
    screws = [s for s in every if s.track.lead != 0.0]
    fixed = (
        f", and {unseen} screws and bearings that were chosen before any of them was solved in 3D. Two corrections of the "
        "refined model, for nut faces and short lands, were developed after the errors on these were known"
    )
    leads = f"{len(screws)} screws of lead {span([1e3 * abs(s.track.lead) for s in screws], 'mm')}" if screws else ""
    bearings = f"bearings: {len(every) - len(screws)}" if len(every) > len(screws) else ""
    return [
        f"{cases} case studies of Lin's thesis{fixed if unseen else ''}.",
        f"{', '.join(filter(None, [leads, bearings]))}; "
        f"pitch diameters {span([2e3 * s.track.pitch_radius for s in every], 'mm')}, "
        f"{span([s.ball_count for s in every], 'balls')}, {span(contacts, 'loaded contacts')}.",
        (
            "Friction, ball motion, support bearings, balls pushing each other in the return, and several nuts or bearings "
            "on one shaft are compared with printed numbers, closed forms and second solvers on other pages."
        ),
    ]


LIMITS = (
    (
        "The 3D reference is linear elastic and frictionless, with nominal geometry apart from the geometric errors stated "
        "in a scene. Its mesh uncertainty is that of the mesh only; the effect of dimensions that the publication does not "
        'print and of idealisations is stated separately (page "Uncertainty of the contact loads of the 3D reference").'
    ),
    "For a screw outside this range the models still compute results, with the note that their error is not known.",
    (
        "A cold start is a new process with empty caches, library imports included; a further load case takes a "
        "small part of this time."
    ),
)


def largest_error_bar_chart(accuracies: Sequence[ModelAccuracy]) -> Figure:
    """Draw the largest load error of each model and 3D mesh level: its median over the scenes as a bar, and its maximum.

    ``accuracies``: errors of each model and mesh level over the shipped scenes.
    """
    rows = [float(k) for k in range(1, len(accuracies) + 1)]
    series = (
        Series("median over the scenes", [s.median_error_percent for s in accuracies], rows, "bars"),
        Series("maximum over the scenes", [s.largest_error_percent for s in accuracies], rows, "markers"),
    )
    names = [f"{s.name}: {s.median_error_percent:.2g} %" for s in accuracies]
    panel = Panel("", "largest error of a contact load / % of the mean load", "", series, ordinate_names=names)
    medians = {s.name: s.median_error_percent for s in accuracies}
    title = ", ".join(f"{medians[model]:.2g} % with {NAMES[model]}" for model in KINDS if model in medians)
    caption = (
        "Errors on the example screws and bearings of rollbench, against the finest mesh level of the 3D reference. Bars: "
        "medians; markers: maxima."
    )
    size = (7.6, 1.2 + 0.26 * len(accuracies))
    title = f"Largest contact-load error on a screw or bearing, in per cent of the mean load: median {title}"
    return Figure("overview-bars", title, (panel,), caption, columns=1, size=size)


def model_accuracy_table(accuracies: Sequence[ModelAccuracy]) -> Table:
    """Return the table of load errors and run times of each model and 3D mesh level over the shipped scenes.

    ``accuracies``: errors and run times of each model and mesh level.
    """
    columns = {field: TableColumn(key, label, unit, form) for field, key, label, unit, form in ACCURACY_COLUMNS}
    rows: list[Row] = [{column: attrgetter(field)(s) for field, column in columns.items()} for s in accuracies]
    note = (
        "Errors against the finest mesh level of the 3D reference, on the example screws and bearings of rollbench; the "
        f"table reference-time has the values of each. Rule of rollbench check: errors {RULE}; a contact load is within "
        "the limit if its error plus uncertainty is. The finest mesh level is the reference: its mesh uncertainty is "
        "shown as its error, and its RMS error is zero by definition."
    )
    title = "Errors and run times of each model and 3D mesh level on the example screws and bearings"
    table = Table.from_rows("overview-models", title, rows, note)
    return replace(table, csv_only=("label", "rms", "worst_rms"))


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's first section: model errors, scenes with a 3D reference, limits of validity, figures and tables.

    ``step`` is called with each line of progress.
    """
    step("error against run time, every model and mesh on every scene")
    points = cache.compute_once(reference_time.errors_and_times_of_all_scenes, step)
    title = "Contact-load errors and run times of each model and 3D mesh level on the example screws and bearings"
    if not points:
        return Section("overview", title, (Text(("No run of the 3D reference is stored.",)),))
    found = cache.stored_references(tuple(points))
    bars = [largest_uncertainty_percent(ref) for ref in found.values()]
    rungs = cache.compute_once(solve_refinement_sequence_on_all_scenes)
    compared = [*compared_points(cache, rungs), *model_errors_on_random_screws()]
    screws, drawn = largest_load_errors_on_screws(compared), len({p.scene for p in model_errors_on_random_screws()})
    wide = error_distribution_and_time_figure(screws, points, "error-time", (11.0, 4.1))
    narrow = error_distribution_and_time_figure(screws, points, "error-time-narrow", (3.75, 6.6), label_all_models=False)
    covered = [
        random_screws_paragraph(drawn),
        *compared_scenes_paragraphs({name: cache.built_in_scene(name) for name in points}, found),
    ]
    count = max((errors.size for errors in screws.values()), default=0)
    total = largest_total_uncertainty(cache, found)
    told = answers(count, largest_check_errors_on_screws(compared), bars, total)
    limits = (*LIMITS, reference_time.run_time_conditions_sentence(cache, step))
    table = model_accuracy_table(summarise_accuracy_by_model(points))
    step("every model on every quantity")
    step("printed values by table and section")
    folders = {name: one.case.folder for name, one in all_computations().items()}
    laid = [f for f in evidence_of_all_tables(cache) if (folders[f.printed.table] / "layout.toml").is_file()]
    items = (
        *error_tables_of_all_quantities(cache),
        computed_over_reference_load_figure(cache, found),
        counts_of_reproduced_numbers_table(laid, "printed-values"),
    )
    summary = Summary(QUESTION, told, wide, narrow, covered, limits, table, items)
    shown = (
        largest_error_bar_chart(summarise_accuracy_by_model(points)),
        table,
        error_over_further_load_case_time_figure(points),
    )
    return Section("overview", title, shown, conclusion=told[0][1], summary=summary)


def largest_total_uncertainty(cache: SceneResultCache, references: Mapping[str, Reference]) -> float | None:
    """Return the largest total uncertainty of the 3D contact loads in Lin's case studies [% of the mean load].

    It combines the uncertainties by mesh, modelling choices and input tolerances. ``references``: 3D reference of each
    scene, by name of the scene; if no case study is among them, None is returned.
    """
    cases = {name: ref for name, ref in references.items() if name in REFERENCED}
    totals = (uncertainty_of_loads(cache.built_in_scene(name), ref).percent for name, ref in cases.items())
    return max(totals, default=None)


def error_tables_of_all_quantities(cache: SceneResultCache) -> tuple[Table, Table]:
    """Return the tables of bias and scatter of each computed quantity.

    The first is against the 3D reference, by model; the second against values that others publish or measured.
    """
    rows = validated_errors_of_models(cache, cache.compute_once(solve_refinement_sequence_on_all_scenes))
    cells: list[Row] = []
    for s in bias_and_scatter(rows):
        if s.model not in KINDS:
            continue
        worst = [abs(row.error) for row in rows if (row.model, row.quantity) == (s.model, s.quantity)]
        name = f"{s.quantity}, in per cent of the mean load" if s.quantity == CONTACTS else s.quantity
        cells.append(
            {
                "quantity": name,
                "model": s.model,
                BIAS: s.bias,
                SCATTER: s.scatter,
                LARGEST: max(worst),
                text_column("scenes", "number of screws and bearings"): s.scenes,
            }
        )
    columns = {q.key: q for q in (BIAS, SCATTER)}
    published: list[Row] = []
    for case in all_cases():
        rows_of_case = case.import_object(case.published_errors)(cache) if case.published_errors else {}
        for quantity, row in rows_of_case.items():
            known: Row = {columns.get(c.key, text_column("values", "number of values")): v for c, v in row.items()}
            published.append({"quantity": quantity, **known})
    note = "Errors against the finest mesh level of the 3D reference of each screw or bearing."
    against = (
        "Values that makers, measurements and other programs state, each computed by the model or formula that the table "
        "of these values names (section outside)."
    )
    return (
        Table.from_rows("quantities", "Errors of the models in each quantity, against the 3D reference", cells, note),
        Table.from_rows(
            "published-values", "Errors in each quantity, against published and measured values", published, against
        ),
    )


def computed_over_reference_load_figure(cache: SceneResultCache, references: Mapping[str, Reference]) -> Figure:
    """Draw, for every contact, the load by a low-order model, plotted against the load by the 3D reference.

    All loads of a scene are divided by the mean contact load of its 3D reference. ``references``: 3D reference of each
    scene, by name of the scene.
    """
    series = []
    for model in KINDS:
        x, y, names = [], [], []
        for rung in cache.compute_once(solve_refinement_sequence_on_all_scenes):
            if rung.model == model and rung.scene in references:
                ref = references[rung.scene]
                value, truth = rung.result.load / ref.mean, ref.load / ref.mean
                at = np.argwhere((value > 0.0) | (truth > 0.0))
                x += [float(truth[i, s]) for i, s in at]
                y += [float(value[i, s]) for i, s in at]
                names += [f"{rung.scene}, {i + 1} {SIDES[s]}" for i, s in at]
        series.append(Series(model, x, y, "markers", point_names=names))
    end = max((max(s.x, default=1.0) for s in series), default=1.0)
    truths = np.array([0.0, np.nextafter(SMALL, 0.0), SMALL, end])  # a step, where the rule of rollbench check changes
    allowed = 0.01 * LIMIT * load_scale_of_check_errors(truths, 1.0)
    lines = np.concatenate([truths - allowed, [np.nan], truths + allowed])
    series.append(Series("equal loads", [0.0, end], [0.0, end], "line"))
    series.append(Series(f"limit of ±{LIMIT:g} %", [*truths, end, *truths], lines.tolist(), "line"))
    panel = Panel("", "load by the 3D reference / mean load", "load by the model / mean load", tuple(series))
    caption = (
        f"{len(series[0].x)} contacts of {len(references)} screws and bearings. Outer lines: a load error of {LIMIT:g} %, "
        "the default limit of the command rollbench check."
    )
    title = "Load of each contact by the low-order models, plotted against its load by the 3D reference"
    return Figure("contacts", title, (panel,), caption, columns=1, size=(7.0, 5.0))
