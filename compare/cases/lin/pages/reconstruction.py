"""Report section on the origin of the model errors printed in Lin 2.4.1: two explanations, and what each misses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare.cases.lin.evidence.chapter_2 import END_SUPPORTS
from rollbench.compare.cases.lin.reconstruction import explanations
from rollbench.compare.cases.lin.reconstruction.explanations import ERRORS, FINER, PENALTY_LEVEL, SOFT, ExplanationResult
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import load_stored_run, shipped_store
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling import runs as rolling
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, Text

#: Number of balls that count as "the last few".
LAST = 3
FORCE = "force 1-2 N"
#: Ball-to-ball forces: printed table, keys of the low-order and the ANSYS value, scene.
FORCES = {
    "3.5 (a)": ("lin-3.5", "a_force_numerical", "a_force_ansys", "lin-pair-a"),
    "3.7 (a)": ("lin-3.7", "force_a", "ansys_a", "lin-screw-pair-a"),
    "3.7 (a), inferred oversize": ("lin-3.7", "force_a", "ansys_a", "lin-screw-pair-a-inferred"),
    "3.7 (b)": ("lin-3.7", "force_b", "ansys_b", "lin-screw-pair-b"),
    "3.7 (b), inferred oversize": ("lin-3.7", "force_b", "ansys_b", "lin-screw-pair-b-inferred"),
}


def model_comparison_statements_table(cache: SceneResultCache) -> Table:
    """Return the table of further comparisons of Lin's model with ANSYS in his text, with computed values and verdicts.

    ``cache``: gives solved scenes and stored 3D references.
    """
    rows = [
        _run_time_row(cache),
        _lateral_displacement_row(cache),
        *(_case_3_support_row(cache, model) for model in ("lin", DEFAULT)),
        *map(_ball_force_row, FORCES),
    ]
    title = "Other statements in which Lin compares his model with ANSYS, and computed values"
    return Table.from_rows("reconstruction-others", title, rows)


def _row_of_lin_statement(location: str, printed: str, computed: str, verdict: str) -> Row:
    """Return the table row of one statement in Lin's thesis.

    ``location``: section, table or figure of the statement; ``printed``: the statement; ``computed``: what is computed for
    it; ``verdict``: conclusion.
    """
    return {"thesis_place": location, "thesis_statement": printed, "computed_here": computed, "conclusion": verdict}


def _run_time_row(cache: SceneResultCache) -> Row:
    """Return the table row on run times: printed for ANSYS, beside the size of a 3D model with cells of equal size.

    ``cache``: gives the scene of this 3D model.
    """
    run = load_stored_run(cache.built_in_scene("lin-case1"), SOURCE_LEVEL, stores=[shipped_store()])
    hours, elements = (printed_value("lin-2.2", key) for key in ("time_ansys_1", "elements_ansys"))
    size = "no stored run" if run is None else f"{run.unknowns:,} unknowns, time in table reference-time"
    return _row_of_lin_statement(
        "Table 2.2",
        f"{hours:g} h with {elements:,.0f} elements",
        f"a 3D model of the same cells, condensed by contacts: {size}",
        "not judged, because times depend on machine and method; 6800 follows from the printed times",
    )


def _lateral_displacement_row(cache: SceneResultCache) -> Row:
    """Return the table row on Lin's Figure 2.10: largest lateral displacement of the screw's axis, low-order and in 3D.

    ``cache``: gives solved scenes and stored 3D references.
    """
    low, found = cache.solve_once("lin-case1"), cache.stored_reference("lin-case1")
    assert found is not None
    z, *motion = found.best.centreline.T
    there = [np.interp(z, low.centreline_z, low.centreline[:, k]) for k in range(2)]
    ours, theirs = (float(1e6 * np.hypot(x, y).max()) for x, y in (there, motion[:2]))
    off = 1e6 * float(np.hypot(there[0] - motion[0], there[1] - motion[1]).max())
    share = float(error_percent(off, 0.0, theirs))
    return _row_of_lin_statement(
        "Figure 2.10",
        '"good agreement in predicting the presence of lateral deformation"',
        f"largest {ours:.2f} um by the low-order model, {theirs:.2f} um in 3D, {off:.2f} um apart ({share:.0f} %)",
        "the presence comes out; in amount the two differ by that much",
    )


def _case_3_support_row(cache: SceneResultCache, model: str) -> Row:
    """Return the table row on Lin's case 3, in which the right end of the screw is displaced laterally.

    The row lists the supports of this end with which the displacement changes the contact loads as Lin describes.
    ``model``: name of the model by which the contact loads are computed. ``cache``: gives the solved scenes.
    """
    largest, right = [], []
    for reading in END_SUPPORTS:
        change = cache.solve_once(reading.offset_scene, model).load - cache.solve_once(reading.plain_scene, model).load
        ball, side = (int(k) for k in np.unravel_index(int(np.abs(change).argmax()), change.shape))
        shaped = rises_most_at_last_balls(change)
        right += [reading.restraint] if shaped else []
        largest.append(f"{reading.restraint}: most at {ball + 1} {SIDES[side]} ({change[ball, side]:+.0f} N)")
    return _row_of_lin_statement(
        "2.4.1.3, case 3",
        "the offset raises SR and NL of the last few balls most",
        f"{model}: {'; '.join(largest)}",
        f"the printed shape has: {', '.join(right) or 'none'}",
    )


def rises_most_at_last_balls(change: Array) -> bool:
    """Return whether the largest change of a contact load is a rise on flank SR or NL of one of the last balls.

    ``change``: changes of the contact loads (n, 4) [N] of n balls on the flanks SL, SR, NL and NR (screw or nut, left or
    right).
    """
    ball, side = np.unravel_index(int(np.abs(change).argmax()), change.shape)
    return bool(side in (1, 2) and ball >= len(change) - LAST and change[ball, side] > 0.0)


def _ball_force_row(case: str) -> Row:
    """Return the table row on a ball-to-ball force that Lin prints for his model and for ANSYS.

    The row contains the difference of both forces, and the computed effects of elastic bodies and of the cell size.
    ``case``: key of `FORCES`.
    """
    table, low_key, ansys_key, name = FORCES[case]
    low, ansys = (printed_value(table, key) for key in (low_key, ansys_key))
    scene = shipped_scene_of_kind(name, FrictionScene)
    coarse, fine = (rolling.load_rolling_run(scene, level, [shipped_store()]) for level in (SOURCE_LEVEL, 3))
    printed = f"{low:g} N, ANSYS {ansys:g} N: {float(error_percent(low, ansys)):.2f} %"
    if coarse is None or fine is None:
        return _row_of_lin_statement(f"Table {case}", printed, "no stored run", "not judged")
    value = fine.values[FORCE]
    bodies = float(error_percent(value, fine.limit[FORCE]))
    cells = float(error_percent(coarse.elastic[FORCE], value))
    needed = float(error_percent(ansys, low))
    enough = abs(needed) <= abs(cells) + abs(bodies)
    verdict = (
        "elements of that size do as much: may be its mesh"
        if enough
        else "neither bodies nor elements of that size do as much: the load state, which is not printed, or the solver"
    )
    computed = f"{value:.3f} N; elastic bodies change it by {bodies:+.2f} %, elements of Lin's size by {cells:+.1f} %"
    return _row_of_lin_statement(
        f"Table {case}", f"{printed}, that is {needed:+.2f} % of the low-order force", computed, verdict
    )


# --- origin of the printed errors of 2.4.1: two explanations


ABOUT_IT = (
    'What Lin did is not known. For both models he prints a largest load of "about 1.34" times the smallest, and '
    "four errors of his model against ANSYS. Each explanation is shown with its deviations from these six numbers. "
    "3D results are computed on the coarsest mesh, those with a contact penalty on the next finer one."
)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the origin of the model errors printed in section 2.4.1 of Lin's thesis.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("explanations of the errors in Lin's section 2.4.1")
    found = cache.compute_once(explanations.evaluate_explanations)
    return Section(
        "reconstruction",
        "Lin 2.4.1: possible origin of the model error of 5.38 % that the thesis prints",
        (
            Text((origin_of_error_paragraph(found), ABOUT_IT, contact_penalty_paragraph(cache))),
            ratios_and_errors_by_explanation_table(found),
            deviations_from_print_table(found),
            explanations_figure(found),
            model_comparison_statements_table(cache),
        ),
        conclusion=origin_of_error_conclusion(found),
    )


def error_fall_and_rise_to_case_2(errors: Sequence[float]) -> tuple[float, float]:
    """Return the fall of the largest error, then the rise of the RMS error, from Lin's case 1 to his case 2.

    Both are in percentage points. ``errors``: errors [%] of the low-order model's contact loads against those in 3D:
    largest and RMS error of case 1, then of case 2.
    """
    return errors[0] - errors[2], errors[3] - errors[1]


def origin_of_error_conclusion(found: list[ExplanationResult]) -> str:
    """Return the conclusion that the origin of the largest error that Lin prints, 5.38 %, is not identified.

    The error is that of his low-order contact loads against ANSYS in case 1. ``found``: results of all explanations, of
    which the first has all choices by default.
    """
    errors = [c.errors_percent[0] for c in found]
    missed = min(float(np.sqrt(np.mean(c.deviations_from_print**2))) for c in found)
    return (
        f"The origin of the largest model error that Lin prints, {explanations.printed_errors_percent()[0]:.2f} %, is not "
        f"identified. Computed on level {explanations.LEVEL} of the 3D mesh, this error is {errors[0]:.2f} % by default, "
        f"{min(errors):.2f} to {max(errors):.2f} % by the explanations (table lin-sentences-compared: finest mesh). The "
        f"nearest one misses the two ratios and four errors that are printed by {missed:.2f} % (root mean square)."
    )


def origin_of_error_paragraph(found: list[ExplanationResult]) -> str:
    """Return the paragraph on the origin of the printed errors, and on two explanations that nearly yield them.

    The errors are those of Lin's low-order contact loads against ANSYS. ``found``: results of all explanations.
    """
    default, near, *soft = found
    errors = ", ".join(
        f"{label} {_first_to_last_in_words([c.errors_percent[k] for c in soft])} %"
        for k, label in enumerate(("largest", "RMS", "largest of case 2", "its RMS"))
    )
    return (
        "Where does 5.38 % come from? It is not identified. Printed are errors of "
        f"{_errors_in_words(explanations.printed_errors_percent())}, largest / "
        f"RMS, and a ratio of largest to smallest load of about {explanations.printed_load_ratio():g} in both models. Two "
        f"explanations come near, and each misses a part. The first ({near.of.low_order}; {near.of.in_3d}) has "
        f"{_ratios_and_errors_in_words(near)}. Contacts of the 3D model that a penalty makes softer, all else by default, "
        f"have a ratio of {_first_to_last_in_words([c.ratio_in_3d for c in soft], 3)} with {soft[0].low_order_ratio:.3f} "
        f"in the low-order model, {errors}, and "
        f"{_first_to_last_in_words([_error_fall_over_printed_percent(c) for c in soft], 0)} % of the printed fall. By "
        f"default: {_ratios_and_errors_in_words(default)}."
    )


def _errors_in_words(values: Sequence[float]) -> str:
    """Return in words four errors [%] of low-order against 3D loads: largest and RMS of Lin's case 1, then of case 2."""
    return f"{values[0]:.2f} / {values[1]:.2f} % (case 1) and {values[2]:.2f} / {values[3]:.2f} % (case 2)"


def _ratios_and_errors_in_words(result: ExplanationResult) -> str:
    """Return in words load ratios and model errors of an explanation, and how much of the printed fall it gives."""
    return (
        f"ratios of {result.low_order_ratio:.3f} and {result.ratio_in_3d:.3f}, errors of "
        f"{_errors_in_words(result.errors_percent)}, {_error_fall_over_printed_percent(result):.0f} % of the printed fall"
    )


def _error_fall_over_printed_percent(result: ExplanationResult) -> float:
    """Return the fall of the largest error from case 1 to case 2, in per cent of the fall that Lin prints."""
    falls = (error_fall_and_rise_to_case_2(x)[0] for x in (result.errors_percent, explanations.printed_errors_percent()))
    return 100.0 * next(falls) / next(falls)


def _first_to_last_in_words(values: Sequence[float], digits: int = 2) -> str:
    """Return in words the first and the last of ``values``, as in "1.21 to 1.34"; ``digits``: number of decimals."""
    return f"{values[0]:.{digits}f} to {values[-1]:.{digits}f}"


def contact_penalty_paragraph(cache: SceneResultCache) -> str:
    """Return the paragraph on 3D contacts with a penalty: how much softer they are than Hertz contacts; effect of the mesh.

    ``cache``: gives solved scenes.
    """
    soft = [(e.in_3d.partition(": ")[2], explanations.penalty_over_hertz_approach(e)) for e in SOFT]
    sizes = ", ".join(f"{size}: {100.0 * x / (1.0 + x):.0f} %" for size, x in soft)
    in_3d = [explanations.runs_in_3d(FINER, level) for level in (PENALTY_LEVEL, PENALTY_LEVEL + 1)]
    coarse, fine = (np.array(explanations.low_order_errors_percent(cache, FINER, runs)) for runs in in_3d)
    ratios = [explanations.load_ratio(runs[0].load) for runs in in_3d]
    return (
        "Of the contacts, the text only prints their formulation, an augmented Lagrangian, with all other settings by "
        "default. This formulation leaves a penetration below a tolerance, as a penalty does, so that contacts are softer. "
        "Size of the penalty and tolerance are not printed. In 3D, the penalty is computed as a compliance in series at "
        "every pair of nodes. Under the mean load, the stiffness of a contact is lower by the following fractions: "
        f"{sizes}. The next mesh level changes the errors with a quarter of E/h by "
        f"{np.abs(fine - coarse).max():.2f} points at most and the ratio from {ratios[0]:.3f} to {ratios[1]:.3f}."
    )


def ratios_and_errors_by_explanation_table(found: list[ExplanationResult]) -> Table:
    """Return the table of load ratio and model errors: printed by Lin, and by each explanation of these numbers.

    Load ratio: largest over smallest load of case 1; model errors: of the low-order loads against the 3D loads.
    ``found``: results of all explanations.
    """
    ratio = explanations.printed_load_ratio()
    printed = "printed", (ratio, ratio, *explanations.printed_errors_percent())
    given = [(c.of.name, (c.low_order_ratio, c.ratio_in_3d, *c.errors_percent)) for c in found]
    rows: list[Row] = [
        {"possible_explanation": name, **_ratio_and_error_cells(values)} for name, values in (printed, *given)
    ]
    title = "Ratio of largest to smallest load, and model errors: printed in Lin 2.4.1, and by each possible explanation"
    return Table.from_rows("reconstruction", title, rows)


def deviations_from_print_table(found: list[ExplanationResult]) -> Table:
    """Return the table of deviations from the printed load ratio and model errors, a row for each possible explanation.

    Load ratio: largest over smallest load of case 1; model errors: of the low-order loads against the 3D loads.
    ``found``: results of all explanations.
    """
    printed = error_fall_and_rise_to_case_2(explanations.printed_errors_percent())
    rows: list[Row] = []
    for c in found:
        fall, rise = np.subtract(error_fall_and_rise_to_case_2(c.errors_percent), printed)
        rows.append(
            {
                "possible_explanation": c.of.name,
                "reading_low_order": c.of.low_order,
                "reading_3d": c.of.in_3d,
                **_ratio_and_error_cells(tuple(c.deviations_from_print), "_off"),
                "error_fall_off": float(fall),
                "error_rise_off": float(rise),
            }
        )
    note = "Deviations of the load ratios: in per cent of the printed ratio; of the model errors: in percentage points."
    title = "Ratio of largest to smallest load, and model errors: deviations from Lin 2.4.1 by each possible explanation"
    return Table.from_rows("reconstruction-missed", title, rows, note)


def _ratio_and_error_cells(values: Sequence[float], suffix: str = "") -> Row:
    """Return table cells: ratio of largest to smallest load by both models, four errors of the low-order model against 3D.

    ``values``: load ratio of the low-order and of the 3D model, then the errors `ERRORS`, or the deviations of all six from
    the printed numbers; ``suffix``: end of the columns' names, "_off" for deviations.
    """
    row: Row = {
        (f"load_ratio_by{suffix}", "low-order model"): float(values[0]),
        (f"load_ratio_by{suffix}", "3D model"): float(values[1]),
    }
    for key, value in zip(ERRORS, values[2:], strict=True):
        case, kind, _ = key.split("_")
        row[f"error_in_case{suffix}", "largest" if kind == "max" else "RMS", case.removeprefix("case")] = float(value)
    return row


def explanations_figure(found: list[ExplanationResult]) -> Figure:
    """Draw ratios of largest to smallest load and model errors by all explanations, and as printed.

    ``found``: results of the explanations.
    """
    ratio, printed = explanations.printed_load_ratio(), explanations.printed_errors_percent()

    def scatter_series(points: Sequence[tuple[float, float]], aim: tuple[float, float]) -> tuple[Series, Series]:
        """Return markers for all explanations and one for the printed values; abscissa and ordinate of each."""
        names = [c.of.name for c in found]
        shown = Series("explanations", [x for x, _ in points], [y for _, y in points], "markers", point_names=names)
        return shown, Series("printed", [aim[0]], [aim[1]], style="markers", bold=True)

    ratios = scatter_series([(c.low_order_ratio, c.ratio_in_3d) for c in found], (ratio, ratio))
    panels = [Panel("Ratio of largest to smallest load, case 1", "low-order model", "3D model", ratios)]
    for k in range(2):
        points = [(c.errors_percent[2 * k + 1], c.errors_percent[2 * k]) for c in found]
        series = scatter_series(points, (printed[2 * k + 1], printed[2 * k]))
        title = f"Errors of the low-order model in case {k + 1}, % of each load"
        panels.append(Panel(title, "RMS error [%]", "largest error [%]", series))
    title = "Ratio of largest to smallest load, and model errors (Lin 2.4.1), by each possible explanation"
    return Figure("reconstruction", title, tuple(panels), columns=3)
