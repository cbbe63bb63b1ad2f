"""First page of the validation report: errors of low-order models against the 3D reference, and their run times."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from rollbench.compare.case import all_cases
from rollbench.compare.evidence import all_computations, evidence
from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.measure import SMALL, load_scale_of_check_errors
from rollbench.compare.models.comparison import REFERENCED, RULE
from rollbench.compare.models.model_form import MeasuredModelErrors, model_errors_on_random_screws
from rollbench.compare.models.modelling import UNSEEN, solve_refinement_sequence_on_all_scenes
from rollbench.compare.models.modelling import model_errors_on_built_in_scenes as compared_points
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import CONTACTS, uncertainty_of_loads
from rollbench.compare.reference.estimate import Reference, largest_uncertainty_percent
from rollbench.compare.report.error_over_time import (
    caption_of_panel,
    error_over_time_panel,
    measured_on_drawn_screws,
    run_time_sentence,
)
from rollbench.compare.sections import reference_time
from rollbench.compare.sections.source_tables import counts_of_reproduced_numbers_table
from rollbench.compare.sections.u_val import tables_of_errors
from rollbench.compare.studies import extremes, survey
from rollbench.compare.studies.survey_models import LoadErrorsAndTimes
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Summary, Table, Text

QUESTION = "How accurate are low-order models of ball screws, and how much run time does a more accurate model take?"
TITLE = "Contact-load errors of the models on all compared screws"
#: Column of the median over the scenes of the largest error [% of the mean load].
MEDIAN = "largest_load_error_over_scenes_median"
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


def model_accuracy_table(points: Mapping[str, Sequence[reference_time.ErrorAndRunTime]]) -> Table:
    """Return the table of load errors of every model and 3D mesh level over all shipped scenes; least accurate first.

    For the finest mesh level, which is the reference, its mesh uncertainty takes the place of the error.

    Parameters
    ----------
    points
        Errors and run time of each model and mesh level, by name of the scene.
    """
    found: dict[str, list[tuple[str, reference_time.ErrorAndRunTime]]] = {}
    for scene, several in points.items():
        for point in several:
            if point.status == "converged" and max(point.error, point.high) > 0.0:
                found.setdefault(point.label, []).append((scene, point))
    rows: list[Row] = []
    for label, group in found.items():
        each = [point for _, point in group]
        errors, rms = [p.error or p.high for p in each], [p.rms for p in each]
        k = int(np.argmax(errors))
        rows.append(
            {
                "model_or_level": each[0].name,
                "long_name": label,
                "scenes": len(group),
                MEDIAN: float(np.median(errors)),
                "largest_load_error_over_scenes": errors[k],
                "scene_of_largest_error": group[k][0],
                "rms_error_over_scenes_median": float(np.median(rms)),
                "rms_error_over_scenes": max(rms),
                "check_error_median": float(np.median([p.gate_error or p.gate_high for p in each])),
                ("scenes_within", f"{LIMIT:g}"): sum(p.gate_high <= LIMIT for p in each),
            }
        )
    note = (
        "Errors against the finest mesh level of the 3D reference, on the example screws and bearings of rollbench; the "
        f"table reference-time has the values of each. Rule of rollbench check: errors {RULE}; a contact load is within "
        "the limit if its error plus uncertainty is. The finest mesh level is the reference: its mesh uncertainty is "
        "shown as its error, and its RMS error is zero by definition."
    )
    title = "Errors of each model and 3D mesh level on the example screws and bearings"
    table = Table.from_rows("overview-models", title, sorted(rows, key=lambda row: -row[MEDIAN]), note)  # type: ignore[operator]
    return replace(table, csv_only=("long_name", "rms_error_over_scenes_median", "rms_error_over_scenes"))


def error_distribution_and_time_figure(largest_errors: Mapping[str, Array], timed: Sequence[LoadErrorsAndTimes]) -> Figure:
    """Draw the distribution of load errors over all compared screws and, if measured, load error over run time.

    Compared screws are those with a 3D reference.

    Parameters
    ----------
    largest_errors
        Largest contact-load error on each screw, in ascending order [% of the mean load], by model.
    timed
        Errors and run times of each model and mesh level on the same drawn screws; empty: not measured.
    """
    counts = " and ".join(sorted({str(errors.size) for errors in largest_errors.values()}))
    title, panels = TITLE, [error_distribution_panel(largest_errors)]
    caption = f"Share of {counts} screws whose largest contact-load error is below the abscissa value."
    if timed:
        title += ", and contact-load error of each model and 3D mesh level, plotted against its run time"
        panels.append(error_over_time_panel(timed))
        caption = f"First panel: {caption} Second panel: {caption_of_panel(timed)}"
    return Figure("error-time", title, panels, caption, columns=1)


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
        Number of screws compared with the 3D reference before the models last changed.
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
        f"{_mesh_uncertainty_clause(mesh_uncertainties)}{whole}. "
        f"{compared_screw_count} other screws were compared before the models last changed. "
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
    """Return the sentences on the models' errors on screws that were drawn after their last change, Lin's model first."""
    records = survey.built_in_survey("new screw")["scenes"]
    found = {name: survey.model_accuracy_on_random_screws(records, name) for name in reversed(survey.MODELS)}
    texts = [
        f"{WHOSE[name]}: {one.median_error:.2g} % of the mean load in the median, at most {one.percentile_95:.2g} % on 19 "
        f"of 20 screws, at most {one.largest_error:.2g} % on all"
        for name, one in found.items()
        if one.screw_count
    ]
    return (
        f"Largest error of a contact load on {found[DEFAULT].screw_count} screws drawn after the models last changed and "
        f"solved once. {'. '.join(texts)}."
    )


def stability_sentence(records: Sequence[extremes.Record]) -> str:
    """Return the sentence on drawn extreme screws and axes of the newest version."""
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
)


def largest_error_bar_chart(table: Table) -> Figure:
    """Draw the largest load error of each model and 3D mesh level: its median over the scenes as a bar, and its maximum.

    ``table``: `model_accuracy_table`.
    """
    median, largest = table.columns[MEDIAN], table.columns["largest_load_error_over_scenes"]
    rows = [float(k) for k in range(1, len(median) + 1)]
    series = (
        Series("median over the scenes", median, rows, "bars"),  # type: ignore[arg-type]
        Series("maximum over the scenes", largest, rows, "markers"),  # type: ignore[arg-type]
    )
    medians = dict(zip(table.columns["model_or_level"], median, strict=True))
    names = [f"{name}: {error:.2g} %" for name, error in medians.items()]
    panel = Panel("", "largest error of a contact load / % of the mean load", "", series, ordinate_names=names)
    title = ", ".join(f"{medians[model]:.2g} % with {NAMES[model]}" for model in KINDS if model in medians)
    caption = (
        "Errors on the example screws and bearings of rollbench, against the finest mesh level of the 3D reference. Bars: "
        "medians; markers: maxima."
    )
    size = (7.6, 1.2 + 0.26 * len(rows))
    title = f"Largest contact-load error on a screw or bearing, in per cent of the mean load: median {title}"
    return Figure("overview-bars", title, (panel,), caption, columns=1, size=size)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's first section: model errors, scenes with a 3D reference, limits of validity, figures and tables.

    ``step`` is called with each line of progress.
    """
    step("error against run time, every model and mesh on every scene")
    points = cache.compute_once(reference_time.errors_and_times_of_all_scenes, step)
    title = "Contact-load errors of each model and 3D mesh level on the example screws and bearings"
    if not points:
        return Section("overview", title, (Text(("No run of the 3D reference is stored.",)),))
    found = cache.stored_references(tuple(points))
    bars = [largest_uncertainty_percent(ref) for ref in found.values()]
    rungs = cache.compute_once(solve_refinement_sequence_on_all_scenes)
    compared = [*compared_points(cache, rungs), *model_errors_on_random_screws()]
    screws, drawn = largest_load_errors_on_screws(compared), len({p.scene for p in model_errors_on_random_screws()})
    covered = [
        random_screws_paragraph(drawn),
        *compared_scenes_paragraphs({name: cache.built_in_scene(name) for name in points}, found),
    ]
    count = max((errors.size for errors in screws.values()), default=0)
    total = largest_total_uncertainty(cache, found)
    told = answers(count, largest_check_errors_on_screws(compared), bars, total)
    timed = measured_on_drawn_screws(cache)
    told.append(("Run time", run_time_sentence(timed)))
    table = model_accuracy_table(points)
    step("every model on every quantity")
    step("printed values by table and section")
    folders = {name: one.case.folder for name, one in all_computations().items()}
    laid = [f for f in evidence(cache, *sorted(all_computations())) if (folders[f.printed.table] / "layout.toml").is_file()]
    items = (
        *error_tables_of_all_quantities(cache),
        computed_over_reference_load_figure(cache, found),
        counts_of_reproduced_numbers_table(laid, "printed-values"),
    )
    summary = Summary(QUESTION, told, error_distribution_and_time_figure(screws, timed), covered, LIMITS, table, items)
    shown: list[Table | Figure] = [largest_error_bar_chart(table), table]
    return Section("overview", title, shown, conclusion=told[0][1], summary=summary)


def largest_total_uncertainty(cache: SceneResultCache, references: Mapping[str, Reference]) -> float | None:
    """Return the largest total uncertainty of the 3D contact loads in Lin's case studies [% of the mean load].

    It combines the uncertainties by mesh, modelling choices and input tolerances. ``references``: 3D reference of each
    scene, by name of the scene; if no case study is among them, None is returned.
    """
    cases = {name: ref for name, ref in references.items() if name in REFERENCED}
    totals = (uncertainty_of_loads(cache.built_in_scene(name), ref).total for name, ref in cases.items())
    return max(totals, default=None)


def error_tables_of_all_quantities(cache: SceneResultCache) -> tuple[Table, Table]:
    """Return the tables of bias and scatter of each computed quantity.

    The first is against the 3D reference, by model, from the tables of the section u-val; the second against values that
    others publish or measured.
    """
    errors, scatters = cache.compute_once(tables_of_errors)
    cells: list[Row] = []
    for row in scatters.rows:
        if row["model"] not in KINDS:
            continue
        of_row = [one for one in errors.rows if (one["model"], one["quantity"]) == (row["model"], row["quantity"])]
        name = f"{row['quantity']}, in per cent of the mean load" if row["quantity"] == CONTACTS else row["quantity"]
        copied: Row = {column: row[column] for column in ("model", "bias", "scatter")}
        worst = max(abs(float(one["error_against_reference"] or 0.0)) for one in of_row)
        cells.append({"quantity": name, **copied, "largest_error": worst, "scenes": row["scenes"]})
    published: list[Row] = []
    for case in all_cases():
        rows_of_case = case.import_object(case.published_errors)(cache) if case.published_errors else {}
        published += [{"quantity": quantity} | row for quantity, row in rows_of_case.items()]
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
