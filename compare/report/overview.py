"""First screen of the report: accuracy of low-order models, by errors and run times against the 3D reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.evidence import audit, computations
from rollbench.compare.gate.verdict import LIMIT, Limits, judge
from rollbench.compare.measure import SMALL, gate_scale
from rollbench.compare.models.comparison import REFERENCED, RULE
from rollbench.compare.models.model_form import Point, points_of_drawn_screws
from rollbench.compare.models.modelling import UNSEEN, Rung, ladder
from rollbench.compare.models.modelling import points as compared_points
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import Study
from rollbench.compare.models.uncertainty import CONTACTS, scatter, total
from rollbench.compare.reference.estimate import Reference, uncertainty_percent
from rollbench.compare.sections.reference_time import FLOOR, Largest, TimePoint, all_points, when_measured
from rollbench.compare.sections.source_tables import by_place
from rollbench.compare.sections.u_val import rows_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Summary, Table, Text

QUESTION = "How far can a low-order model of a ball screw be trusted, and what does a better answer cost?"
TITLE = "Errors of all screws compared, and of every model and mesh against run time"
#: Families that share a colour, by models: the refined one, the source's and steps from it, axial bars, condensed bodies.
FAMILIES = (
    ("refined", ("refined",)),
    (
        "the source's model and steps from it",
        ("lin", "lin-source-partition", "lin-printed-hertz", "lin-cell", "lin-nut", "source"),
    ),
    ("axial bars", ("mei", "mei-nut", "liu")),
    ("bodies from 3D", ("condensed",)),
)
SOLID = "3D reference"
#: Models that represent their family, with their names in the answer.
BIAS, SCATTER = Quantity("bias", "bias", "%", "+.2f"), Quantity("scatter", "scatter", "%", ".2f")
LARGEST = Quantity("largest", "largest error", "%", ".1f")
KINDS = {DEFAULT: "refined", "lin": "lin"}
#: The same in a sentence.
NAMES = {DEFAULT: "the refined model", "lin": "Lin's model"}


@dataclass(frozen=True)
class Standing:
    """Errors and run time of one model or mesh over the shipped scenes.

    The finest level has its grid uncertainty as error.
    """

    #: Short name.
    name: str
    #: Name in tables.
    label: str
    #: Family of the model.
    family: str
    #: Number of scenes.
    scenes: int
    #: Largest error [% of the mean load].
    worst: float
    #: Scene with this error.
    worst_scene: str
    #: Median of the largest errors.
    median: float
    #: Median of the RMS errors.
    rms: float
    #: Largest RMS error.
    worst_rms: float
    #: Median time of a cold start [s]; None: not measured.
    cold: float | None
    #: Median of the largest errors as the gate takes them, with the ends of their uncertainty.
    gate: Largest
    #: Number of scenes that pass the gate at `LIMIT`.
    passed: int


def model_family(point: TimePoint) -> str:
    """Return the family of a model; all 3D meshes are one family."""
    if point.kind != "model":
        return SOLID
    return next((family for family, names in FAMILIES if point.name in names), point.label)


def error_or_uncertainty(point: TimePoint) -> float:
    """Return the largest error of a point [% of the mean load]; of the finest level its grid uncertainty."""
    return point.high if point.error == 0.0 and point.high is not None else point.error


def by_gate(point: TimePoint) -> Largest:
    """Return the largest error as the gate takes it; of the finest level its grid uncertainty."""
    return replace(point.gate, error=point.gate.high) if point.gate.error == 0.0 else point.gate


def median_errors(points: Mapping[str, Sequence[TimePoint]]) -> list[Standing]:
    """Return errors and times of every model and mesh over its scenes, largest median error first."""
    found: dict[str, list[tuple[str, TimePoint]]] = {}
    for scene, several in points.items():
        for point in several:
            if point.status == "converged" and error_or_uncertainty(point) > 0.0:
                found.setdefault(point.label, []).append((scene, point))
    return sorted((_median_error_of(label, group) for label, group in found.items()), key=lambda s: -s.median)


def _median_error_of(label: str, group: Sequence[tuple[str, TimePoint]]) -> Standing:
    """Return errors and times of one model or mesh over its scenes."""
    first = group[0][1]
    errors = [error_or_uncertainty(p) for _, p in group]
    k = int(np.argmax(errors))
    times = [p.cold for _, p in group if p.cold is not None]
    gate = [by_gate(p) for _, p in group]
    return Standing(
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
        gate=Largest(*(float(np.median(ends)) for ends in zip(*((g.error, g.low, g.high) for g in gate), strict=True))),
        passed=sum(g.high <= LIMIT for g in gate),
    )


def pareto_front(found: Sequence[Standing]) -> list[Standing]:
    """Return the models and meshes that no other one beats in both median gate error and time, fastest first."""
    best: list[Standing] = []
    for one in sorted((s for s in found if s.cold is not None), key=lambda s: (s.cold, s.gate.error)):
        if not best or one.gate.error < best[-1].gate.error:
            best.append(one)
    return best


def first_figure(
    screws: Mapping[str, Array],
    points: Mapping[str, Sequence[TimePoint]],
    name: str,
    size: tuple[float, float],
    *,
    all_names: bool = True,
) -> Figure:
    """Draw the errors of all compared screws, and error over the time of a cold start.

    Parameters
    ----------
    screws
        Errors of all screws by model.
    points
        Errors and times by scene.
    name
        Name of the figure.
    size
        Width and height [inches].
    all_names
        Whether all points are named; else levels, one model of each family and those of the front.
    """
    points = {name: [p for p in several if p.cold is not None] for name, several in points.items()}
    time = _time_panel(points, median_errors(points), "run time of a cold start / s", all_names=all_names)
    counts = " and ".join(sorted({str(errors.size) for errors in screws.values()}))
    caption = (
        f"Share of screws: by the largest error of a contact load on each of {counts}. {TIMED} A cold start is a new "
        "process with empty caches, Python's imports included."
    )
    panels = (screw_panel(screws), time)
    return Figure(name, TITLE, panels, caption, columns=2 if all_names else 1, size=size)


#: Contents of a panel of errors over time.
TIMED = (
    f"Error against run time: by the gate's rule, {RULE}; the line is the gate's {LIMIT:g} %. Light points: shipped "
    "scenes. Markers: medians; bars: the range left by the reference's grid uncertainty. The finest level itself is drawn "
    "at its uncertainty. The condensed model reads bodies from a 3D run, whose time is not included. All times are of one "
    "measuring run; what it did not measure is left out."
)


def screw_panel(screws: Mapping[str, Array]) -> Panel:
    """Return the panel of the share of compared screws up to a largest error, by model."""
    series = []
    for model, errors in screws.items():
        share = 100.0 * np.arange(1, errors.size + 1) / max(errors.size, 1)
        series.append(Series(model, errors.tolist(), share.tolist(), "line", emphasis=True))
    return Panel("", "largest error / % of the mean load", "share of screws with no more / %", series, log="x", zero=True)


def further_figure(points: Mapping[str, Sequence[TimePoint]]) -> Figure:
    """Draw the error over the time of a further solution."""
    warm = {name: [replace(p, cold=p.warm) for p in several if p.warm is not None] for name, several in points.items()}
    panel = _time_panel(warm, median_errors(warm), "time of a further solve / s", all_names=True)
    return Figure(
        "error-time-further",
        "Largest error of each model and mesh level over the time of a further load case",
        (panel,),
        TIMED,
        columns=1,
    )


def screw_errors(points: Sequence[Point]) -> dict[str, Array]:
    """Return the sorted largest errors of all compared screws [% of the mean load], by model of `KINDS`."""
    of_screws = [p for p in points if p.features["lead"] > 0.0]
    return {model: np.sort([p.percent for p in of_screws if p.model == model]) for model in KINDS}


def gate_errors(points: Sequence[Point]) -> dict[str, Array]:
    """Return the largest errors of all compared screws by the gate's rule [%], by model of `KINDS`."""
    known = [(p.model, p.gate_percent) for p in points if p.features["lead"] > 0.0 and p.gate_percent is not None]
    return {model: np.array([error for name, error in known if name == model]) for model in KINDS}


def _time_panel(
    points: Mapping[str, Sequence[TimePoint]], found: Sequence[Standing], label: str, *, all_names: bool
) -> Panel:
    """Return the panel of gate error over time: every scene, medians by family, and the Pareto front of medians."""
    families = [family for family, _ in FAMILIES] + [SOLID]
    series = []
    for family in families:
        drawn = [(scene, p) for scene, several in points.items() for p in several if _is_drawn(p, family)]
        shown = [(scene, p, p.cold) for scene, p in drawn if p.cold is not None]
        series.append(
            Series(
                family,
                [cold for *_, cold in shown],
                [max(by_gate(p).error, FLOOR) for _, p, _ in shown],
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


def _is_drawn(point: TimePoint, family: str) -> bool:
    """Return whether a point is drawn: converged, with an error, and of the family."""
    return point.status == "converged" and error_or_uncertainty(point) > 0.0 and model_family(point) == family


def accuracy_sentence(
    screws: Mapping[str, Array], gate: Mapping[str, Array], drawn: int, bars: Sequence[float], total: float | None = None
) -> str:
    """Return the sentence on the errors of representative models on all screws, and the accuracy of the reference.

    Parameters
    ----------
    screws
        Errors of all screws [% of the mean load] by model.
    gate
        The same by the gate's rule [%].
    drawn
        Number of drawn screws among them.
    bars
        Grid uncertainties of the scenes [%].
    total
        Largest total uncertainty of the reference [%], modelling choices and input included.
    """
    largest = []
    for model, errors in screws.items():
        if errors.size:
            median, most = np.percentile(errors, [50, 95])
            largest.append(f"{median:.1f} and {most:.1f} % by {NAMES[model]}")
    whole = "" if total is None else f", {total:.1f} % with unprinted choices and tolerances"
    return (
        f"{passed_text(gate)}. Median and 95th percentile of the largest error: {', '.join(largest)}, of the mean contact "
        f"load; {drawn} of the screws were drawn at random. Uncertainty of the 3D reference: {_range_text(bars)}{whole}."
    )


def passed_text(errors: Mapping[str, Array]) -> str:
    """Return a sentence on the number of screws that pass the gate's `LIMIT`; empty without errors.

    Parameters
    ----------
    errors
        Largest errors of the screws [%] by the gate's rule, by model.
    """
    found = {NAMES[model]: of_model for model, of_model in errors.items() if of_model.size}
    counts = [f"{name} on {(e <= LIMIT).sum()} of {e.size}" for name, e in found.items()]
    return f"Within the gate's {LIMIT:g} % of every contact load: {', '.join(counts)} screws" if counts else ""


def _range_text(bars: Sequence[float]) -> str:
    """Return the range of uncertainties as text."""
    if not bars:
        return "unknown (one mesh level only)"
    low, high = f"{min(bars):.1f}", f"{max(bars):.1f}"
    return f"{low} %" if low == high else f"{low} to {high} %"


def drawn_words(drawn: int) -> str:
    """Return a sentence that describes the drawn screws."""
    return (
        f"{drawn} catalogue screws, drawn by one seed without redraws and compared on level 1 of the 3D reference (section "
        "survey); finer levels, run times and the gate are shown of the shipped scenes:"
    )


def describe_coverage(scenes: Mapping[str, Scene], found: Mapping[str, Reference]) -> list[str]:
    """Return paragraphs on how many scenes there are, and on the ranges of their inputs."""
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
        f", and {unseen} screws and bearings fixed before any of them was solved in 3D. Only the refined "
        "model's corrections for nut faces and short lands were developed with their errors known"
    )
    leads = f"{len(screws)} screws of lead {span([1e3 * abs(s.track.lead) for s in screws], 'mm')}" if screws else ""
    bearings = f"bearings: {len(every) - len(screws)}" if len(every) > len(screws) else ""
    return [
        f"{cases} case studies of the source{fixed if unseen else ''}.",
        f"{', '.join(filter(None, [leads, bearings]))}; "
        f"pitch diameters {span([2e3 * s.track.pitch_radius for s in every], 'mm')}, "
        f"{span([s.ball_count for s in every], 'balls')}, {span(contacts, 'loaded contacts')}.",
        (
            "Friction, ball motion, support bearings, ball chains and several sets on one shaft are compared "
            "with printed numbers, closed forms and second solvers on their own pages."
        ),
    ]


LIMITS = (
    (
        "The reference is linear elastic, frictionless, and nominal in shape apart from the errors of a scene. "
        "Its uncertainty is that of its mesh; the effect of unprinted dimensions and idealisations is stated "
        'separately (page "Uncertainty of the 3D reference").'
    ),
    ("For a screw outside this range the models still answer, and the result says that its error is not covered."),
    (
        "A cold start is a new process with empty caches, library imports included; a further solve costs a "
        "small part of it."
    ),
)


def models_figure(found: Sequence[Standing]) -> Figure:
    """Draw the largest error by model and mesh: median of the scenes as bar, largest of them as mark."""
    rows = [float(k) for k in range(1, len(found) + 1)]
    series = (
        Series("median of the scenes", [s.median for s in found], rows, "bars"),
        Series("largest of all scenes", [s.worst for s in found], rows, "markers"),
    )
    panel = Panel(
        "",
        "largest error of a contact load / % of the mean",
        "",
        series,
        row_names=[f"{s.name}: {s.median:.2g} %" for s in found],
    )
    medians = {s.name: s.median for s in found}
    title = ", ".join(f"{medians[model]:.2g} % in {NAMES[model]}" for model in KINDS if model in medians)
    caption = "Against the finest level of the 3D reference on the shipped scenes."
    size = (7.6, 1.2 + 0.26 * len(found))
    return Figure("overview-bars", f"The median error is {title}", (panel,), caption, columns=1, size=size)


def standing_table(found: Sequence[Standing]) -> Table:
    """Return the table of errors and times by model and mesh."""
    rows: list[Row] = [
        {
            "name": s.name,
            Quantity("label", "model or mesh", "", "s"): s.label,
            "scenes": s.scenes,
            Quantity("median", "largest error, median", "% of mean", ".2f"): s.median,
            Quantity("worst", "largest of all", "% of mean", ".2f"): s.worst,
            Quantity("at", "on", "", "s"): s.worst_scene,
            Quantity("rms", "RMS error, median", "% of mean", ".2f"): s.rms,
            Quantity("worst_rms", "largest RMS error", "% of mean", ".2f"): s.worst_rms,
            Quantity("gate", "by the gate's rule, median", "%", ".2f"): s.gate.error,
            Quantity("passed", f"scenes that pass the gate's {LIMIT:g} %", "", "s"): s.passed,
            Quantity("cold", "cold start, median", "s", "g3"): s.cold,
        }
        for s in found
    ]
    note = (
        "Against the finest level of the 3D reference of each shipped scene; the table of error against run time "
        f"has every point. By the gate's rule: {RULE}; a scene passes where error and uncertainty of every contact are "
        "together within the limit. The error of the finest level itself is its grid uncertainty, and its RMS error is "
        "zero by definition."
    )
    table = Table.of("overview-models", "Errors of each model and mesh level on the shipped scenes", rows, note)
    return replace(table, csv_only=("label", "rms", "worst_rms"))


def make_section(study: Study, step: Callable[[str], None]) -> Section:
    """Return the section with the first screen of the report."""
    step("error against run time, every model and mesh on every scene")
    points = study.once(all_points, step)
    title = "Errors of each model and mesh level on the shipped scenes"
    if not points:
        return Section("overview", title, (Text(("No run of the 3D reference was found.",)),))
    found = study.references(tuple(points))
    bars = [uncertainty_percent(ref) for ref in found.values()]
    compared = [*compared_points(study, study.once(ladder)), *points_of_drawn_screws()]
    screws, drawn = screw_errors(compared), len({p.scene for p in points_of_drawn_screws()})
    wide = first_figure(screws, points, "error-time", (11.0, 4.1))
    narrow = first_figure(screws, points, "error-time-narrow", (3.75, 6.6), all_names=False)
    covered = [drawn_words(drawn), *describe_coverage({name: study.scene(name) for name in points}, found)]
    sentence = accuracy_sentence(screws, gate_errors(compared), drawn, bars, largest_total(study, found))
    limits = (*LIMITS, when_measured(study, step))
    table = standing_table(median_errors(points))
    step("every model on every quantity")
    step("printed values by table and section")
    laid = [f for f in audit(study) if (computations()[f.printed.table].case.folder / "layout.toml").is_file()]
    items = (quantity_table(study), contact_figure(study, found), by_place(laid, "printed-values", unfolded=True))
    summary = Summary(QUESTION, sentence, wide, narrow, covered, limits, table, items)
    shown = (models_figure(median_errors(points)), table, further_figure(points))
    return Section("overview", title, shown, conclusion=sentence, summary=summary)


def largest_total(study: Study, found: Mapping[str, Reference]) -> float | None:
    """Return the largest total uncertainty of a case study's reference [%]: mesh, modelling choices, input."""
    totals = [total(study.scene(name), ref).percent for name, ref in found.items() if name in REFERENCED]
    return max(totals, default=None)


def quantity_table(study: Study) -> Table:
    """Return the table of bias, scatter and largest error by quantity, against 3D and against outside values."""
    rungs = study.once(ladder)
    rows = rows_of(study, rungs)
    from rollbench.compare.cases.makers.page import first_page

    outside = first_page(study)
    cells: list[Row] = []
    for model in KINDS:
        of_model = [r for r in rungs if r.model == model]
        words = [gate_word(study, rung) for rung in of_model]
        passed = words.count("pass")
        cells.append(
            {
                "quantity": "worst contact load, by the gate's rule",
                "model": model,
                BIAS: None,
                SCATTER: None,
                LARGEST: max(r.error.gate_percent for r in of_model),
                "scenes": len(of_model),
                Quantity("passed", f"pass the gate's {LIMIT:g} %", "", "s"): f"{passed} of {len(of_model)}",
                "verdict": "yes" if passed == len(of_model) else "no",
            }
        )
    for s in scatter(rows):
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
            columns.get(column.label, Quantity("values", "outside values", "", "s")): v for column, v in row.items()
        }
        cells.append({"quantity": quantity, "model": "against outside values", **known})
    note = (
        f"First rows: the gate's verdict on every scene, {RULE}. Then: errors against the finest level of the 3D reference "
        "of each scene. Last rows: against values that others print or measure (section outside)."
    )
    return Table.of("quantities", "Every quantity and model", cells, note)


def gate_word(study: Study, rung: Rung) -> str:
    """Return the gate's verdict on a model's loads on a scene, at its default limit."""
    reference = study.reference(rung.scene)
    assert reference is not None  # a rung stands against one
    return judge(rung.model, rung.result.load, reference, Limits())[0].word


def contact_figure(study: Study, found: Mapping[str, Reference]) -> Figure:
    """Draw computed over reference load for every contact of every scene, both over the scene's mean load."""
    series = []
    for model in KINDS:
        x, y, names = [], [], []
        for rung in study.once(ladder):
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
    allowed = 0.01 * LIMIT * gate_scale(truths, 1.0)
    lines = np.concatenate([truths - allowed, [np.nan], truths + allowed])
    series.append(Series("equal", [0.0, end], [0.0, end], "line"))
    series.append(Series(f"the gate's ±{LIMIT:g} %", [*truths, end, *truths], lines.tolist(), "line"))
    panel = Panel("", "3D reference / mean load", "computed / mean load", tuple(series))
    caption = f"{len(series[0].x)} contacts of {len(found)} scenes. Lines: the gate's {LIMIT:g} %."
    return Figure(
        "contacts",
        "Contact load by the models over that of the 3D reference, for each contact",
        (panel,),
        caption,
        columns=1,
        size=(7.0, 5.0),
    )
