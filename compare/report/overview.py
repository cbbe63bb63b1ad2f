"""First page of the validation report: errors of low-order models against the 3D reference, and their run times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.evidence import all_computations, evidence_of_all_tables
from rollbench.compare.gate.verdict import LIMIT, Limits, judge_contact_loads
from rollbench.compare.measure import SMALL, scale_of_gate_errors
from rollbench.compare.models.comparison import REFERENCED, RULE
from rollbench.compare.models.model_form import Point, errors_on_drawn_screws
from rollbench.compare.models.modelling import UNSEEN, Rung, ladder
from rollbench.compare.models.modelling import model_errors_on_shipped_scenes as compared_points
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import CONTACTS, bias_and_scatter, uncertainty_of_loads
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.sections.reference_time import (
    FLOOR,
    LargestError,
    TimePoint,
    measurement_conditions_sentence,
    points_of_all_scenes,
)
from rollbench.compare.sections.source_tables import reproduced_counts_table
from rollbench.compare.sections.u_val import validated_errors_of_models
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Summary, Table, Text

QUESTION = "How accurate are low-order models of ball screws, and how much run time does a more accurate model take?"
TITLE = "Contact-load errors of the models on all compared screws, and error of each model and 3D mesh over its run time"
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
#: Columns of the table of bias, scatter and largest error.
BIAS, SCATTER = Quantity("bias", "bias", "%", "+.2f"), Quantity("scatter", "scatter", "%", ".2f")
LARGEST = Quantity("largest", "largest error", "%", ".1f")
#: Models that represent their family in figures and tables.
KINDS = {DEFAULT: "refined", "lin": "lin"}
#: Names of these models in a sentence.
NAMES = {DEFAULT: "the refined model", "lin": "Lin's model"}


@dataclass(frozen=True)
class ModelAccuracy:
    """Contact-load errors and run time of one model or 3D mesh level, summarised over the shipped scenes.

    For the finest mesh level, which is the reference, its mesh uncertainty takes the place of the error.
    """

    #: Short name of the model or mesh level, for figures.
    name: str
    #: Name of the model or mesh level in tables.
    label: str
    #: Family of the model, which determines its colour: one of `FAMILIES` or all 3D meshes.
    family: str
    #: Number of scenes on which the model or mesh converged.
    scenes: int
    #: Largest error of a contact load over all scenes [% of the mean load].
    worst: float
    #: Name of the scene with this error.
    worst_scene: str
    #: Median over the scenes of the largest error [% of the mean load].
    median: float
    #: Median over the scenes of the RMS error of the contact loads [% of the mean load].
    rms: float
    #: Largest RMS error over the scenes [% of the mean load].
    worst_rms: float
    #: Median time in a new process with empty caches [s] (cold start); None: not measured.
    cold: float | None
    #: Median over the scenes of the largest error as ``rollbench check`` judges it [%], and of the ends of its range.
    gate: LargestError
    #: Number of scenes that pass ``rollbench check`` with its default limit.
    passed: int


def model_family(point: TimePoint) -> str:
    """Return the name of the family to which the model or 3D mesh of a measured point belongs.

    ``point``: error and run time of the model on a scene. Families of models are those of `FAMILIES`; a model that is in
    none of them forms its own family, named by its label. All 3D meshes form one family.
    """
    if point.kind != "model":
        return SOLID
    return next((family for family, names in FAMILIES if point.name in names), point.label)


def error_or_uncertainty(point: TimePoint) -> float:
    """Return the largest contact-load error of a model or 3D mesh on a scene [% of the mean load].

    ``point``: its errors and run time. For the finest mesh level, which is the reference, its mesh uncertainty is returned.
    """
    return point.high if point.error == 0.0 and point.high is not None else point.error


def error_by_gate(point: TimePoint) -> LargestError:
    """Return the largest contact-load error of a model or 3D mesh on a scene as ``rollbench check`` judges it [%].

    ``point``: its errors and run time. For the finest mesh level, which is the reference, its mesh uncertainty takes the
    place of the error.
    """
    return replace(point.gate, error=point.gate.high) if point.gate.error == 0.0 else point.gate


def errors_by_model(points: Mapping[str, Sequence[TimePoint]]) -> list[ModelAccuracy]:
    """Return errors and run times of every model and 3D mesh level, summarised over the scenes; least accurate first.

    Parameters
    ----------
    points
        Errors and run time of each model and mesh level, by name of the scene.
    """
    found: dict[str, list[tuple[str, TimePoint]]] = {}
    for scene, several in points.items():
        for point in several:
            if point.status == "converged" and error_or_uncertainty(point) > 0.0:
                found.setdefault(point.label, []).append((scene, point))
    return sorted((_accuracy_of_model(label, group) for label, group in found.items()), key=lambda s: -s.median)


def _accuracy_of_model(label: str, group: Sequence[tuple[str, TimePoint]]) -> ModelAccuracy:
    """Return the errors and run time of one model or mesh level, as medians and maxima over the scenes.

    ``label``: its name in tables. ``group``: pairs of a scene's name, and errors and run time on this scene.
    """
    first = group[0][1]
    errors = [error_or_uncertainty(p) for _, p in group]
    k = int(np.argmax(errors))
    times = [p.cold for _, p in group if p.cold is not None]
    gate = [error_by_gate(p) for _, p in group]
    return ModelAccuracy(
        name=first.name,
        label=label,
        family=model_family(first),
        scenes=len(group),
        worst=errors[k],
        worst_scene=group[k][0],
        median=float(np.median(errors)),
        rms=float(np.median([p.rms for _, p in group])),
        worst_rms=max(p.rms for _, p in group),
        cold=float(np.median(times)) if times else None,
        gate=LargestError(
            *(float(np.median(ends)) for ends in zip(*((g.error, g.low, g.high) for g in gate), strict=True))
        ),
        passed=sum(g.high <= LIMIT for g in gate),
    )


def pareto_front(found: Sequence[ModelAccuracy]) -> list[ModelAccuracy]:
    """Return the Pareto-optimal models and mesh levels, fastest first: no other is both faster and more accurate.

    ``found``: errors and run times of all models and mesh levels. Compared are the median of the largest error, as
    ``rollbench check`` judges it, and the time of a cold start.
    """
    best: list[ModelAccuracy] = []
    for one in sorted((s for s in found if s.cold is not None), key=lambda s: (s.cold, s.gate.error)):
        if not best or one.gate.error < best[-1].gate.error:
            best.append(one)
    return best


def error_distribution_and_time_figure(
    screws: Mapping[str, Array],
    points: Mapping[str, Sequence[TimePoint]],
    name: str,
    size: tuple[float, float],
    *,
    all_names: bool = True,
) -> Figure:
    """Draw two panels: distribution of load errors over all compared screws, and load error over cold-start time.

    Parameters
    ----------
    screws
        Largest error on each screw [% of the mean load], by model.
    points
        Errors and run time of each model and mesh level, by name of the scene.
    name
        File name of the figure.
    size
        Width and height [inches].
    all_names
        Whether all models and mesh levels are named; if not, only the representative models and the Pareto front are.
    """
    points = {name: [p for p in several if p.cold is not None] for name, several in points.items()}
    time = _error_over_time_panel(points, errors_by_model(points), "run time of a cold start / s", all_names=all_names)
    counts = " and ".join(sorted({str(errors.size) for errors in screws.values()}))
    caption = (
        f"First panel: share of {counts} screws whose largest contact-load error is below the abscissa. Second panel: "
        f"{TIMED} Cold start: a new process with empty caches."
    )
    panels = (error_distribution_panel(screws), time)
    return Figure(name, TITLE, panels, caption, columns=2 if all_names else 1, size=size)


#: Caption of a panel of errors over run time.
TIMED = (
    f"Largest error on each scene, {RULE}; horizontal line: {LIMIT:g} %, the default limit of rollbench check. Light "
    "points: single scenes. Dark markers: medians; bars: range due to the mesh uncertainty of the 3D reference. The finest "
    "mesh is the reference, drawn at its own uncertainty. The time of the condensed model excludes its 3D run."
)


def error_distribution_panel(screws: Mapping[str, Array]) -> Panel:
    """Return the panel of the cumulative distribution of the largest contact-load error over all compared screws.

    Parameters
    ----------
    screws
        Largest error on each screw, in ascending order [% of the mean load], by model.
    """
    series = []
    for model, errors in screws.items():
        share = 100.0 * np.arange(1, errors.size + 1) / max(errors.size, 1)
        series.append(Series(model, errors.tolist(), share.tolist(), "line", emphasis=True))
    x, y = "largest error / % of the mean load", "share of screws up to this error / %"
    return Panel("", x, y, series, log="x", zero=True)


def further_load_case_figure(points: Mapping[str, Sequence[TimePoint]]) -> Figure:
    """Draw the largest load error of each model and 3D mesh level over the time of a further load case of a known geometry.

    ``points``: errors and run times of each model and mesh level, by name of the scene.
    """
    warm = {name: [replace(p, cold=p.warm) for p in several if p.warm is not None] for name, several in points.items()}
    panel = _error_over_time_panel(warm, errors_by_model(warm), "run time of a further load case / s", all_names=True)
    return Figure(
        "error-time-further",
        "Largest contact-load error of each model and 3D mesh level over the run time of a further load case",
        (panel,),
        TIMED,
        columns=1,
    )


def largest_errors_on_screws(points: Sequence[Point]) -> dict[str, Array]:
    """Return the largest contact-load error on each compared screw, in ascending order [% of the mean load], by model.

    ``points``: one record for each model and scene. Bearings (scenes without lead) are left out.
    """
    of_screws = [p for p in points if p.features["lead"] > 0.0]
    return {model: np.sort([p.percent for p in of_screws if p.model == model]) for model in KINDS}


def gate_errors_on_screws(points: Sequence[Point]) -> dict[str, Array]:
    """Return the largest load error on each compared screw as ``rollbench check`` judges it [%], by model.

    ``points``: one record for each model and scene. Bearings (scenes without lead) are left out.
    """
    known = [(p.model, p.gate_percent) for p in points if p.features["lead"] > 0.0 and p.gate_percent is not None]
    return {model: np.array([error for name, error in known if name == model]) for model in KINDS}


def _error_over_time_panel(
    points: Mapping[str, Sequence[TimePoint]], found: Sequence[ModelAccuracy], label: str, *, all_names: bool
) -> Panel:
    """Return the panel of load errors over run time: a point per scene and model, medians, and the Pareto front.

    The errors are the largest of each scene, as ``rollbench check`` judges them.

    Parameters
    ----------
    points
        Errors and run times of each model and mesh level, by name of the scene; the field ``cold`` is the drawn time [s].
    found
        Medians over the scenes, for each model and mesh level.
    label
        Label of the time axis.
    all_names
        Whether the medians of all models are labelled; if not, only those of `KINDS` and of the Pareto front.
    """
    others = [model_family(p) for several in points.values() for p in several]
    families = list(dict.fromkeys([*(family for family, _ in FAMILIES), SOLID, *others]))
    series = []
    for family in families:
        drawn = [(scene, p) for scene, several in points.items() for p in several if _is_drawn_with_family(p, family)]
        shown = [(scene, p, p.cold) for scene, p in drawn if p.cold is not None]
        series.append(
            Series(
                family,
                [cold for *_, cold in shown],
                [max(error_by_gate(p).error, FLOOR) for _, p, _ in shown],
                "markers",
                light=True,
                names=[f"{p.name}, {scene}" for scene, p, _ in shown],
            )
        )
    edge = pareto_front(found)
    line = ([s.cold for s in edge if s.cold is not None], [max(s.gate.error, FLOOR) for s in edge])
    series.append(Series("Pareto front of the medians", *line, "line", names=[s.name for s in edge]))
    for family in families:
        mids = [s for s in found if s.family == family]
        bars = ([max(s.gate.low, FLOOR) for s in mids], [max(s.gate.high, FLOOR) for s in mids])
        series.append(
            Series(
                family,
                [s.cold for s in mids if s.cold is not None],
                [max(s.gate.error, FLOOR) for s in mids],
                "markers",
                emphasis=True,
                bars=bars,
                texts=[s.name if all_names or s in edge or s.name in KINDS else "" for s in mids],
                names=[f"{s.name}, median of {s.scenes} scenes" for s in mids],
            )
        )
    series = [s for s in series if len(s.x)]
    times = [p.cold for several in points.values() for p in several if p.cold is not None]
    if times:
        series.append(Series(f"the gate's {LIMIT:g} %", [min(times), max(times)], [LIMIT, LIMIT], "line"))
    return Panel("", label, "largest error by the gate's rule / %", tuple(series), log="xy")


def _is_drawn_with_family(point: TimePoint, family: str) -> bool:
    """Return whether a point of the error-over-time figure is drawn in the colour of a family of models.

    ``point``: error and run time of a model on a scene. It is drawn if the model belongs to ``family`` and converged, and
    if the error is above zero.
    """
    return point.status == "converged" and error_or_uncertainty(point) > 0.0 and model_family(point) == family


def accuracy_sentence(
    screws: Mapping[str, Array], gate: Mapping[str, Array], drawn: int, bars: Sequence[float], total: float | None = None
) -> str:
    """Return the sentences on the models' load errors on all compared screws, and on the accuracy of the 3D reference.

    Parameters
    ----------
    screws
        Largest error on each screw [% of the mean load], by model.
    gate
        Largest error on each screw as ``rollbench check`` judges it [%], by model.
    drawn
        Number of randomly drawn screws among them.
    bars
        Mesh uncertainty of the 3D reference for each scene [% of the mean load].
    total
        Largest total uncertainty of the 3D reference [% of the mean load], modelling choices and input tolerances included.
    """
    largest = []
    for model, errors in screws.items():
        if errors.size:
            median, most = np.percentile(errors, [50, 95])
            largest.append(f"{median:.1f} and {most:.1f} % by {NAMES[model]}")
    whole = "" if total is None else f", up to {total:.1f} % with modelling choices and input tolerances"
    return (
        f"{screws_within_limit_text(gate)}. Median and 95th percentile of the largest error: {', '.join(largest)}, of the "
        "mean contact "
        f"load; {drawn} of the screws were drawn at random. Grid uncertainty of the 3D reference: "
        f"{_grid_uncertainty_range_text(bars)}{whole}."
    )


def screws_within_limit_text(errors: Mapping[str, Array]) -> str:
    """Return the clause on the number of screws on which each model's loads are within the limit of ``rollbench check``.

    Parameters
    ----------
    errors
        Largest load error on each screw as ``rollbench check`` judges it [%], by model; if empty, the clause is empty.
    """
    found = {NAMES[model]: of_model for model, of_model in errors.items() if of_model.size}
    counts = [f"{name} on {(e <= LIMIT).sum()} of {e.size}" for name, e in found.items()]
    return (
        f"Every contact load is within {LIMIT:g} % of the 3D reference: by {', by '.join(counts)} screws" if counts else ""
    )


def _grid_uncertainty_range_text(bars: Sequence[float]) -> str:
    """Return as text the range of the mesh uncertainty [%]; ``bars``: the uncertainty of each scene."""
    if not bars:
        return "unknown (one mesh level only)"
    low, high = f"{min(bars):.1f}", f"{max(bars):.1f}"
    return f"{low} %" if low == high else f"{low} to {high} %"


def random_screws_paragraph(drawn: int) -> str:
    """Return the paragraph on the randomly drawn screws that were compared in 3D; ``drawn`` is their number."""
    return (
        f"{drawn} catalogue screws, drawn at random with a fixed seed, none replaced, were compared with mesh level 1 of "
        "the 3D reference (section survey). Finer mesh levels, run times and verdicts of rollbench check (the gate) are "
        "shown for the shipped scenes:"
    )


def compared_scenes_paragraphs(scenes: Mapping[str, Scene], found: Mapping[str, Reference]) -> list[str]:
    """Return paragraphs on the compared scenes: their number, origin, and ranges of lead, diameter and number of balls.

    Parameters
    ----------
    scenes
        Scenes by name.
    found
        3D reference of each scene.
    """
    if not scenes:
        return []
    every = list(scenes.values())

    def span(values: Sequence[float], unit: str) -> str:
        low, high = f"{min(values):.4g}", f"{max(values):.4g}"
        return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"

    cases, unseen = sum(name in REFERENCED for name in scenes), sum(name in UNSEEN for name in scenes)
    contacts = [int((ref.load > 0.0).sum()) for ref in found.values()]
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
        "in a scene. Its grid uncertainty is that of the mesh only; the effect of dimensions that the publication does not "
        'print and of idealisations is stated separately (page "Uncertainty of the 3D reference").'
    ),
    "For a screw outside this range the models still compute results, with the note that their error is not known.",
    (
        "A cold start is a new process with empty caches, library imports included; a further load case takes a "
        "small part of this time."
    ),
)


def largest_error_figure(found: Sequence[ModelAccuracy]) -> Figure:
    """Draw the largest load error of each model and 3D mesh level: its median over the scenes as a bar, and its maximum.

    ``found``: errors of each model and mesh level over the shipped scenes.
    """
    rows = [float(k) for k in range(1, len(found) + 1)]
    series = (
        Series("median over the scenes", [s.median for s in found], rows, "bars"),
        Series("maximum over the scenes", [s.worst for s in found], rows, "markers"),
    )
    panel = Panel(
        "",
        "largest error of a contact load / % of the mean load",
        "",
        series,
        row_names=[f"{s.name}: {s.median:.2g} %" for s in found],
    )
    medians = {s.name: s.median for s in found}
    title = ", ".join(f"{medians[model]:.2g} % by {NAMES[model]}" for model in KINDS if model in medians)
    caption = "Errors against the finest mesh level of the 3D reference. Bars: medians; markers: maxima."
    size = (7.6, 1.2 + 0.26 * len(found))
    title = f"Median over the shipped scenes of the largest contact-load error, of the mean load: {title}"
    return Figure("overview-bars", title, (panel,), caption, columns=1, size=size)


def model_accuracy_table(found: Sequence[ModelAccuracy]) -> Table:
    """Return the table of load errors and run times of each model and 3D mesh level over the shipped scenes.

    ``found``: errors and run times of each model and mesh level.
    """
    rows: list[Row] = [
        {
            "name": s.name,
            Quantity("label", "model or mesh", "", "s"): s.label,
            "scenes": s.scenes,
            Quantity("median", "largest error, median", "% of mean", ".2f"): s.median,
            Quantity("worst", "largest error, maximum", "% of mean", ".2f"): s.worst,
            Quantity("at", "scene of the maximum", "", "s"): s.worst_scene,
            Quantity("rms", "RMS error, median", "% of mean", ".2f"): s.rms,
            Quantity("worst_rms", "largest RMS error", "% of mean", ".2f"): s.worst_rms,
            Quantity("gate", "largest error by the gate's rule, median", "%", ".2f"): s.gate.error,
            Quantity("passed", f"scenes that pass the gate's {LIMIT:g} %", "", "s"): s.passed,
            Quantity("cold", "cold start, median", "s", "g3"): s.cold,
        }
        for s in found
    ]
    note = (
        "Errors against the finest mesh level of the 3D reference of each shipped scene; the table of error over run time "
        f"has the values of each scene. By the gate's rule: {RULE}. A scene passes if error plus uncertainty is within the "
        "limit on every contact. The finest mesh level is the reference: as its error its grid uncertainty is shown, and "
        "its RMS error is zero by definition."
    )
    table = Table.of(
        "overview-models", "Errors and run times of each model and 3D mesh level on the shipped scenes", rows, note
    )
    return replace(table, csv_only=("label", "rms", "worst_rms"))


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section with the report's summary: errors of the models, compared scenes, limits, main figures and tables.

    ``step`` is called with each line of progress.
    """
    step("error against run time, every model and mesh on every scene")
    points = study.compute_once(points_of_all_scenes, step)
    title = "Contact-load errors of each model and 3D mesh level on the shipped scenes"
    if not points:
        return Section("overview", title, (Text(("No run of the 3D reference is stored.",)),))
    found = study.references(tuple(points))
    bars = [largest_uncertainty_percent(ref) for ref in found.values()]
    compared = [*compared_points(study, study.compute_once(ladder)), *errors_on_drawn_screws()]
    screws, drawn = largest_errors_on_screws(compared), len({p.scene for p in errors_on_drawn_screws()})
    wide = error_distribution_and_time_figure(screws, points, "error-time", (11.0, 4.1))
    narrow = error_distribution_and_time_figure(screws, points, "error-time-narrow", (3.75, 6.6), all_names=False)
    covered = [
        random_screws_paragraph(drawn),
        *compared_scenes_paragraphs({name: study.scene(name) for name in points}, found),
    ]
    sentence = accuracy_sentence(
        screws, gate_errors_on_screws(compared), drawn, bars, largest_total_uncertainty(study, found)
    )
    limits = (*LIMITS, measurement_conditions_sentence(study, step))
    table = model_accuracy_table(errors_by_model(points))
    step("every model on every quantity")
    step("printed values by table and section")
    laid = [
        f
        for f in evidence_of_all_tables(study)
        if (all_computations()[f.printed.table].case.folder / "layout.toml").is_file()
    ]
    items = (
        quantity_error_table(study),
        computed_over_reference_figure(study, found),
        reproduced_counts_table(laid, "printed-values", unfolded=True),
    )
    summary = Summary(QUESTION, sentence, wide, narrow, covered, limits, table, items)
    shown = (largest_error_figure(errors_by_model(points)), table, further_load_case_figure(points))
    return Section("overview", title, shown, conclusion=sentence, summary=summary)


def largest_total_uncertainty(study: Study, found: Mapping[str, Reference]) -> float | None:
    """Return the largest total uncertainty of the 3D contact loads in Lin's case studies [% of the mean load].

    It combines the uncertainties by mesh, modelling choices and input tolerances. ``found``: 3D reference of each scene, by
    name of the scene; if no case study is among them, None is returned.
    """
    totals = [uncertainty_of_loads(study.scene(name), ref).percent for name, ref in found.items() if name in REFERENCED]
    return max(totals, default=None)


def quantity_error_table(study: Study) -> Table:
    """Return the table of bias, scatter and largest error of the models in each computed quantity.

    The errors are against the 3D reference and, in the last rows, against values that others have printed or measured.
    """
    rungs = study.compute_once(ladder)
    rows = validated_errors_of_models(study, rungs)
    from rollbench.compare.cases.makers.page import first_page

    outside = first_page(study)
    cells: list[Row] = []
    for model in KINDS:
        of_model = [r for r in rungs if r.model == model]
        words = [gate_verdict_word(study, rung) for rung in of_model]
        passed = words.count("pass")
        cells.append(
            {
                "quantity": "worst contact load by the gate's rule",
                "model": model,
                BIAS: None,
                SCATTER: None,
                LARGEST: max(r.error.gate_percent for r in of_model),
                "scenes": len(of_model),
                Quantity("passed", f"pass the gate's {LIMIT:g} %", "", "s"): f"{passed} of {len(of_model)}",
                "verdict": "yes" if passed == len(of_model) else "no",
            }
        )
    for s in bias_and_scatter(rows):
        if s.model not in KINDS:
            continue
        worst = [abs(row.error) for row in rows if (row.model, row.quantity) == (s.model, s.quantity)]
        name = f"{s.quantity}, of the mean load" if s.quantity == CONTACTS else s.quantity
        cells.append(
            {"quantity": name, "model": s.model, BIAS: s.bias, SCATTER: s.scatter, LARGEST: max(worst), "scenes": s.scenes}
        )
    columns = {q.label: q for q in (BIAS, SCATTER)}
    for quantity, row in outside.items():
        known: Row = {
            columns.get(column.label, Quantity("values", "values of others", "", "s")): v for column, v in row.items()
        }
        cells.append({"quantity": quantity, "model": "against values of others", **known})
    note = (
        f"First rows: the gate's verdict on every scene, {RULE}. Then: errors against the finest mesh level of the 3D "
        "reference of each scene. Last rows: errors against values that others have printed or measured (section outside)."
    )
    return Table.of("quantities", "Bias, scatter and largest error of each model in each computed quantity", cells, note)


def gate_verdict_word(study: Study, rung: Rung) -> str:
    """Return the verdict "pass", "fail" or "undecided" of ``rollbench check`` on a model's contact loads on a scene.

    ``rung``: solution of the scene by the model. The error limit is the default.
    """
    reference = study.reference(rung.scene)
    assert reference is not None  # a rung stands against one
    return judge_contact_loads(rung.model, rung.result.load, reference, Limits())[0].word


def computed_over_reference_figure(study: Study, found: Mapping[str, Reference]) -> Figure:
    """Draw, for every contact, the load by a low-order model over the load by the 3D reference.

    Both are divided by the mean load. ``found``: 3D reference of each scene, by name of the scene.
    """
    series = []
    for model in KINDS:
        x, y, names = [], [], []
        for rung in study.compute_once(ladder):
            if rung.model == model and rung.scene in found:
                ref = found[rung.scene]
                value, truth = rung.result.load / ref.mean, ref.load / ref.mean
                at = np.argwhere((value > 0.0) | (truth > 0.0))
                x += [float(truth[i, s]) for i, s in at]
                y += [float(value[i, s]) for i, s in at]
                names += [f"{rung.scene}, {i + 1} {SIDES[s]}" for i, s in at]
        series.append(Series(model, x, y, "markers", names=names))
    end = max((max(s.x, default=1.0) for s in series), default=1.0)
    truths = np.array([0.0, np.nextafter(SMALL, 0.0), SMALL, end])  # a step, where the gate's rule changes
    allowed = 0.01 * LIMIT * scale_of_gate_errors(truths, 1.0)
    lines = np.concatenate([truths - allowed, [np.nan], truths + allowed])
    series.append(Series("equal loads", [0.0, end], [0.0, end], "line"))
    series.append(Series(f"the gate's ±{LIMIT:g} %", [*truths, end, *truths], lines.tolist(), "line"))
    panel = Panel("", "load by the 3D reference / mean load", "load by the model / mean load", tuple(series))
    caption = f"{len(series[0].x)} contacts of {len(found)} scenes. Outer lines: {LIMIT:g} %, the limit of rollbench check."
    return Figure(
        "contacts",
        "Load of each contact by the low-order models over its load by the 3D reference",
        (panel,),
        caption,
        columns=1,
        size=(7.0, 5.0),
    )
