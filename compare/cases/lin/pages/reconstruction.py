"""Report section on the origin of the model errors printed in Lin 2.4.1: combined interpretations of the text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from rollbench.compare.cases.lin.evidence.chapter_2 import END_SUPPORTS
from rollbench.compare.cases.lin.reconstruction import readings
from rollbench.compare.measure import error_percent, mean_load
from rollbench.compare.models.registry import DEFAULT
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.levels import SOURCE_LEVEL
from rollbench.compare.reference.store import load_stored_run, shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.rolling import runs as rolling
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table, TableColumn, Text

if TYPE_CHECKING:
    from rollbench.compare.scenes.friction_kinds.common import FrictionScene

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
    return {
        TableColumn("place", "section, table or figure of the thesis", "", "s"): location,
        TableColumn("printed", "statement of the thesis", "", "s"): printed,
        "computed here": computed,
        TableColumn("verdict", "conclusion", "", "s"): verdict,
    }


def _run_time_row(cache: SceneResultCache) -> Row:
    """Return the table row on run times: printed for ANSYS, and measured for a 3D model with cells of equal size.

    ``cache``: gives the scene whose stored 3D result has this time.
    """
    run = load_stored_run(cache.built_in_scene("lin-case1"), SOURCE_LEVEL, stores=[shipped_store()])
    hours, elements = (printed_value("lin-2.2", key) for key in ("time_ansys_1", "elements_ansys"))
    time = "no stored run"
    if run is not None:
        seconds = run.setup_seconds + run.solve_seconds
        time = f"{seconds:.0f} s with {run.unknowns:,} unknowns, measured with {run.measured}"
    return _row_of_lin_statement(
        "Table 2.2",
        f"{hours:g} h with {elements:,.0f} elements",
        f"a 3D model of the same cells, condensed by contacts: {time}",
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
    scene = cast("FrictionScene", catalogue.shipped_scene(name))
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


# --- origin of the printed errors of 2.4.1: combined interpretations of inputs that the text leaves open


#: Columns with the interpretations of both models.
LOW_ORDER_READINGS = TableColumn("low order", "how the text is interpreted in the low-order model", "", "s")
READINGS_IN_3D = TableColumn("3D", "how the text is interpreted in the 3D model", "", "s")
#: Definitions of errors in words.
WORDS: dict[readings.Definition, str] = {"own": "of the contact's load", "mean": "of the mean load"}
#: Assumed scatters [%] of the approach, besides the measured one.
TRIED = (1.0, 2.0, 3.0)
ABOUT_IT = (
    'What Lin did is not known. For both models he prints a largest load of "about 1.34" times the smallest, and '
    "four errors of his model against ANSYS. Interpretations of what his text leaves open are combined, and each "
    "combination is shown with its deviations from these six numbers; no tolerance decides between the combinations. "
    "3D results are computed on the coarsest mesh, those with a contact penalty on the next finer one."
)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> Section:
    """Return the report's section on the origin of the model errors printed in section 2.4.1 of Lin's thesis.

    ``cache``: gives solved scenes and stored 3D references; ``step``: function that receives a message before each step.
    """
    step("combined interpretations of Lin's section 2.4.1")
    found = cache.compute_once(readings.evaluate_combinations)
    return Section(
        "reconstruction",
        "Lin 2.4.1: possible origin of the model error of 5.38 % that the thesis prints",
        (
            Text(
                (
                    origin_of_error_paragraph(found),
                    ABOUT_IT,
                    contact_penalty_paragraph(cache),
                    mesh_scatter_paragraph(cache, found),
                    friction_in_3d_paragraph(cache),
                )
            ),
            ratios_and_errors_by_explanation_table(found),
            deviations_from_print_table(found),
            combinations_figure(found),
            single_interpretation_table(found),
            combination_table(found),
            model_comparison_statements_table(cache),
        ),
        conclusion=origin_of_error_conclusion(found),
    )


def combination_in_words(combination: readings.Combination) -> str:
    """Return in words a combination of interpretations of Lin's text, such as "Hertz constants: as printed; ..."."""
    return "; ".join(f"{r.modelling_choice}: {r.description}" for r in combination) or "as by default"


def _errors_in_words(values: Sequence[float]) -> str:
    """Return in words four errors [%] of low-order against 3D loads: largest and RMS of Lin's case 1, then of case 2."""
    return f"{values[0]:.2f} / {values[1]:.2f} % (case 1) and {values[2]:.2f} / {values[3]:.2f} % (case 2)"


def error_fall_and_rise_to_case_2(errors: Sequence[float]) -> tuple[float, float]:
    """Return the fall of the largest error, then the rise of the RMS error, from Lin's case 1 to his case 2.

    Both are in percentage points. ``errors``: errors [%] of the low-order model's contact loads against those in 3D:
    largest and RMS error of case 1, then of case 2.
    """
    return errors[0] - errors[2], errors[3] - errors[1]


def origin_of_error_conclusion(found: list[readings.CombinationResult]) -> str:
    """Return the conclusion that the origin of the largest error that Lin prints, 5.38 %, is not identified.

    The error is that of his low-order contact loads against ANSYS in case 1. The conclusion states the range of the
    computed error over all combinations of interpretations of the text. ``found``: results of all combinations, of which
    the first has all choices by default.
    """
    errors = [c.errors_percent["own"][0] for c in found if not c.contradicts_text]
    missed = float(np.sqrt(np.mean(readings.combination_nearest_to_print(found).deviations_from_print ** 2)))
    return (
        f"The origin of the largest model error that Lin prints, {readings.printed_errors_percent()[0]:.2f} %, is not "
        f"identified. Computed on level {readings.LEVEL} of the 3D mesh, this error is "
        f"{found[0].errors_percent['own'][0]:.2f} % by default, and {min(errors):.2f} to {max(errors):.2f} % by "
        f"{len(errors)} combinations of interpretations of what the text leaves open; {len(found) - len(errors)} further "
        "combinations contradict the text (table lin-sentences-compared: finest mesh). The nearest combination misses the "
        f"two ratios and four errors that are printed by {missed:.2f} % (root mean square)."
    )


def origin_of_error_paragraph(found: list[readings.CombinationResult]) -> str:
    """Return the paragraph on the origin of the printed errors, and on two explanations that nearly yield them.

    The errors are those of Lin's low-order contact loads against ANSYS.
    ``found``: results of all combinations of interpretations, of which the first has all choices by default.
    """
    printed, shown = readings.printed_errors_percent(), readings.explanations_shown_in_report(found)
    near = shown["nearest in the ratio, no penalty"]
    penalties = (c for c in shown.values() if not c.low_order_readings)
    soft = [c for c in penalties if any(r.relative_penalty for r in c.readings_in_3d)]
    errors = ", ".join(
        f"{label} {_first_to_last_in_words([c.errors_percent['own'][k] for c in soft])} %"
        for k, label in enumerate(("largest", "RMS", "largest of case 2", "its RMS"))
    )
    best = shown["nearest in all six"]
    return (
        f"Where does 5.38 % come from? It is not identified. Printed are errors of {_errors_in_words(printed)}, largest / "
        f"RMS, and a ratio of largest to smallest load of about {readings.printed_load_ratio():g} in both models. Two "
        "explanations come near, and each misses a part. The interpretations nearest to this ratio "
        f"({combination_in_words(near.low_order_readings)}; {combination_in_words(near.readings_in_3d)}) have "
        f"{_ratios_and_errors_in_words(near)}. Contacts of the 3D model that a penalty makes softer, all else by default, "
        f"have a ratio of {_first_to_last_in_words([c.ratio_in_3d for c in soft], 3)} with {soft[0].low_order_ratio:.3f} "
        f"in the low-order model, {errors}, and "
        f"{_first_to_last_in_words([_error_fall_over_printed_percent(c) for c in soft], 0)} % of the printed fall. By "
        f"default: {_ratios_and_errors_in_words(found[0])}. Nearest in all six numbers "
        f"({combination_in_words(best.low_order_readings)}; {combination_in_words(best.readings_in_3d)}): "
        f"{_ratios_and_errors_in_words(best)}."
    )


def _ratios_and_errors_in_words(result: readings.CombinationResult) -> str:
    """Return in words load ratios and model errors of a combination of interpretations, ``result``.

    The load ratio is the largest load of case 1 divided by its smallest load, by the low-order and by the 3D model; the
    errors are those of the low-order loads against the 3D loads.
    """
    return (
        f"ratios of {result.low_order_ratio:.3f} and {result.ratio_in_3d:.3f}, errors of "
        f"{_errors_in_words(result.errors_percent['own'])}, {_error_fall_over_printed_percent(result):.0f} % of the "
        "printed fall"
    )


def _error_fall_over_printed_percent(result: readings.CombinationResult) -> float:
    """Return the fall of the largest error from case 1 to case 2, in per cent of the fall that Lin prints.

    The error is that of low-order against 3D contact loads; ``result``: errors of a combination of interpretations.
    """
    computed, printed = result.errors_percent["own"], readings.printed_errors_percent()
    return 100.0 * error_fall_and_rise_to_case_2(computed)[0] / error_fall_and_rise_to_case_2(printed)[0]


def _first_to_last_in_words(values: Sequence[float], digits: int = 2) -> str:
    """Return in words the first and the last of ``values``, as in "1.21 to 1.34"; ``digits``: number of decimals."""
    return f"{values[0]:.{digits}f} to {values[-1]:.{digits}f}"


def contact_penalty_paragraph(cache: SceneResultCache) -> str:
    """Return the paragraph on 3D contacts with a penalty: how much softer they are than Hertz contacts; effect of the mesh.

    ``cache``: gives solved scenes and stored 3D results.
    """
    soft = [(r, readings.penalty_over_hertz_approach(cache, (r,))) for r in readings.SOLID if r.relative_penalty]
    sizes = ", ".join(f"{r.description}: {100.0 * x / (1.0 + x):.0f} %" for r, x in soft)
    levels = readings.PENALTY_LEVEL, readings.PENALTY_LEVEL + 1
    low = readings.low_order_loads(cache, ())
    in_3d = [readings.required_loads_in_3d(cache, readings.FINER, level) for level in levels]
    coarse, fine = (np.array(readings.low_order_errors_percent(low, loads)["own"]) for loads in in_3d)
    ratios = [readings.load_ratio(loads[0]) for loads in in_3d]
    return (
        "Of the contacts, the text only prints their formulation, an augmented Lagrangian, with all other settings by "
        "default. This formulation leaves a penetration below a tolerance, as a penalty does, so that contacts are softer. "
        "Size of the penalty and tolerance are not printed. In 3D, the penalty is computed as a compliance in series at "
        "every pair of nodes. Under the mean load, the stiffness of a contact is lower by the following fractions: "
        f"{sizes}. The next mesh level changes the errors with {readings.FINER[0].description} by "
        f"{np.abs(fine - coarse).max():.2f} points at most and the ratio from {ratios[0]:.3f} to {ratios[1]:.3f}."
    )


def mesh_scatter_paragraph(cache: SceneResultCache, found: list[readings.CombinationResult]) -> str:
    """Return the paragraph on whether a contact stiffness that differs between meshes can cause the printed errors.

    The paragraph states, for several sizes of the scatter, the probability that the errors of the low-order model change
    from case 1 to case 2 by at least half of the printed change. ``cache``: gives solved scenes and stored 3D results;
    ``found``: results of all combinations of interpretations.
    """
    falls, rises = error_fall_and_rise_to_case_2(readings.printed_errors_percent())
    best = readings.combination_nearest_to_print(readings.combinations_without_penalty(found), 2)
    low = readings.low_order_loads(cache, best.low_order_readings)
    in_3d = readings.required_loads_in_3d(cache, best.readings_in_3d)
    odds = {}
    for s in (readings.SCATTER, *TRIED):
        errors = readings.low_order_errors_on_random_meshes(low, in_3d, s)
        odds[s] = readings.fraction_of_meshes_with_fall_and_rise(errors, 0.5 * falls, 0.5 * rises)
    chances = ", ".join(f"{s:g} %: {100.0 * p:.1f} %" for s, p in odds.items())
    return (
        f"From case 1 to case 2 the printed largest error falls by {falls:.2f} and the RMS rises by {rises:.2f} points. "
        "With the interpretations nearest to the load ratio, one oversize ball changes both models alike. Tetrahedra of "
        f"about 0.08 mm make a contact {-readings.BIAS:g} % too stiff, and its approach scatters by {readings.SCATTER:g} % "
        "from mesh to mesh. If both cases have different meshes, half of this fall and of this rise occurs with the "
        f"following probability, for each scatter of the approach: {chances}. The mesh explains fall and rise only if this "
        "scatter is several times the one measured on one contact."
    )


def friction_in_3d_paragraph(cache: SceneResultCache) -> str:
    """Return the paragraph on the effect of the printed coefficient of friction in 3D, for rolling and sliding balls.

    ``cache``: gives solved scenes and stored 3D results.
    """
    scene, base = cache.built_in_scene(readings.CASES[0]), readings.required_loads_in_3d(cache, ())
    friction = [r for r in readings.SOLID if r.modelling_choice == readings.FRICTION]
    changed = {r.short_name: readings.required_loads_in_3d(cache, (r,)) for r in friction}
    ratio = readings.load_ratio
    moved = {key: float(error_percent(ratio(loads[0]), ratio(base[0]))) for key, loads in changed.items()}
    pairs = zip(changed["off-line"], base, strict=True)
    most = max(float(np.abs(error_percent(a, b, mean_load(b))).max()) for a, b in pairs)
    mean = {key: float(error_percent(mean_load(loads[0]), mean_load(base[0]))) for key, loads in changed.items()}
    worst = 100.0 * readings.largest_relative_rise_by_friction(scene, lambda s: ratio(cache.solve_once(s, "lin").load))
    slope = float(np.abs(cache.solve_once(scene, "lin").centreline[:, 3:5]).max())
    return (
        f"Friction of {readings.MU:g} is computed, too. Two contact forces act on a ball, along the line through its "
        "contacts. On a rolling ball friction acts only if the ball lies beside the line through the arcs' centres; it "
        f"shifts both forces and turns neither. If all balls lie as far beside as {readings.MU:g} can hold them, they "
        f"change no load by more than {most:.3f} % of the mean and the ratio by {moved['off-line']:+.3f} %; only those "
        f"that raise the ratio change it by {worst:+.1f} % (low order). For this, the grooves would have to tilt by "
        f"{1e3 * readings.tilt_at_onset_of_sliding(scene):.1f} mrad against each other, but the shaft's largest slope is "
        f"{1e3 * slope:.2f} mrad: friction hardly acts on rolling balls. In a model whose balls cannot turn, grooves slide "
        f"on them. Friction then bears {-mean['sliding']:.2f} % of the load where the screw is pushed on, and adds "
        f"{mean['sliding-back']:.2f} % where it moves back; the ratio changes by {moved['sliding']:+.2f} and "
        f"{moved['sliding-back']:+.2f} %, less than the 0.5 % from which interpretations are combined."
    )


def ratios_and_errors_by_explanation_table(found: list[readings.CombinationResult]) -> Table:
    """Return the table of load ratio and model errors: printed by Lin, and by each possible explanation of these numbers.

    Load ratio: largest over smallest load of case 1; model errors: of the low-order loads against the 3D loads.
    ``found``: results of all combinations of interpretations.
    """
    printed = readings.printed_load_ratio(), readings.printed_load_ratio(), *readings.printed_errors_percent()
    given = {
        name: (c.low_order_ratio, c.ratio_in_3d, *c.errors_percent["own"])
        for name, c in readings.explanations_shown_in_report(found).items()
    }
    rows: list[Row] = [
        {TableColumn("explanation", "possible explanation", "", "s"): name, **_ratio_and_error_cells(values, ".3f", ".2f")}
        for name, values in [("printed", printed), *given.items()]
    ]
    title = "Ratio of largest to smallest load, and model errors: printed in Lin 2.4.1, and by each possible explanation"
    return Table.from_rows("reconstruction", title, rows)


def deviations_from_print_table(found: list[readings.CombinationResult]) -> Table:
    """Return the table of deviations from the printed load ratio and model errors, a row for each possible explanation.

    Load ratio: largest over smallest load of case 1; model errors: of the low-order loads against the 3D loads.
    ``found``: results of all combinations of interpretations.
    """
    printed = error_fall_and_rise_to_case_2(readings.printed_errors_percent())
    rows: list[Row] = []
    for name, c in readings.explanations_shown_in_report(found).items():
        computed = error_fall_and_rise_to_case_2(c.errors_percent["own"])
        fall, rise = (float(a - b) for a, b in zip(computed, printed, strict=True))
        row: Row = {
            TableColumn("explanation", "possible explanation", "", "s"): name,
            LOW_ORDER_READINGS: combination_in_words(c.low_order_readings),
            READINGS_IN_3D: combination_in_words(c.readings_in_3d),
        }
        row |= _ratio_and_error_cells(tuple(c.deviations_from_print), "+.1f", "+.2f", "%")
        row[
            TableColumn(
                "fall_off",
                "fall of the largest error from case 1 to 2, computed minus printed",
                "percentage points",
                "+.2f",
            )
        ] = fall
        row[
            TableColumn(
                "rise_off", "rise of the RMS error from case 1 to 2, computed minus printed", "percentage points", "+.2f"
            )
        ] = rise
        rows.append(row)
    note = "Deviations of the load ratios: in per cent of the printed ratio; of the model errors: in percentage points."
    title = "Ratio of largest to smallest load, and model errors: deviations from Lin 2.4.1 by each possible explanation"
    return Table.from_rows("reconstruction-missed", title, rows, note)


def _error_in_words(key: str) -> str:
    """Return the model error of a key of `ERRORS` in words, such as "RMS error in case 1" for "case1_rms_error"."""
    case, kind, _ = key.split("_")
    return f"{'largest' if kind == 'max' else 'RMS'} error in {case.replace('case', 'case ')}"


def _ratio_and_error_cells(values: Sequence[float], ratio: str, error: str, unit: str = "") -> Row:
    """Return table cells: ratio of largest to smallest load by both models, four errors of the low-order model against 3D.

    ``values``: load ratio of the low-order and of the 3D model, then the errors `ERRORS`, or the deviations of all six from
    the printed numbers; ``ratio``, ``error``: number formats of ratios and errors; ``unit``: empty for the values, "%" for
    deviations.
    """
    start = "deviation from the printed " if unit else ""
    heading = f"{start}ratio of largest to smallest load"
    row: Row = {
        TableColumn("low_ratio", f"{heading}, low-order model", unit, ratio): float(values[0]),
        TableColumn("solid_ratio", f"{heading}, 3D model", unit, ratio): float(values[1]),
    }
    for key, value in zip(readings.ERRORS, values[2:], strict=True):
        heading = f"{start}{_error_in_words(key)}"
        row[TableColumn(f"own_{key}", heading, "percentage points" if unit else f"% {WORDS['own']}", error)] = float(value)
    return row


def _ratio_cells_and_errors_by_definition(result: readings.CombinationResult) -> Row:
    """Return table cells of a combination of interpretations: ratio of largest to smallest load by both models, errors.

    The errors of the low-order loads against the 3D loads are in per cent of each load, then in per cent of the mean load.
    """
    row: Row = {
        TableColumn("low_ratio", "ratio of largest to smallest load, low-order model", "", ".3f"): result.low_order_ratio,
        TableColumn("solid_ratio", "ratio of largest to smallest load, 3D model", "", ".3f"): result.ratio_in_3d,
    }
    for definition in readings.DEFINITIONS:
        for key, value in zip(readings.ERRORS, result.errors_percent[definition], strict=True):
            row[TableColumn(f"{definition}_{key}", _error_in_words(key), f"% {WORDS[definition]}", ".2f")] = value
    return row


def single_interpretation_table(found: list[readings.CombinationResult]) -> Table:
    """Return the table of load ratios and model errors with one interpretation at a time, all other choices by default.

    ``found``: results of all combinations of interpretations, of which the first has all choices by default.
    """
    base, rows = found[0], []
    for c in found:
        if len(c.low_order_readings) + len(c.readings_in_3d) > 1:
            continue
        low_order = bool(c.low_order_readings)
        ratio, before = (one.low_order_ratio if low_order else one.ratio_in_3d for one in (c, base))
        reading = (*c.low_order_readings, *c.readings_in_3d)
        model = "low order" if low_order else "3D" if reading else "both"
        against, change = reading[0].contradiction if reading else "", float(error_percent(ratio, before))
        row: Row = {
            TableColumn("model", "model that is changed by the interpretation", "", "s"): model,
            TableColumn("reading", "interpretation", "", "s"): combination_in_words(reading),
            TableColumn("text", "why Lin's text contradicts the interpretation", "", "s"): against,
            TableColumn(
                "moves", "change of the ratio of largest to smallest load by the interpretation", "%", "+.2f"
            ): change,
        }
        rows.append(row | _ratio_cells_and_errors_by_definition(c))
    title = "Ratio of largest to smallest load, and model errors (Lin 2.4.1), with one interpretation changed at a time"
    return Table.from_rows("reconstruction-alone", title, rows)


def combination_table(found: list[readings.CombinationResult]) -> Table:
    """Return the table of all combinations of interpretations, with the RMS of their deviations from the printed numbers.

    ``found``: results of all combinations.
    """
    text = TableColumn("text", "whether Lin's text contradicts the combination", "", "s")
    missed = TableColumn("missed", "RMS of the deviations from the six printed numbers", "", ".2f")
    rows = []
    for c in found:
        rms = float(np.sqrt(np.mean(c.deviations_from_print**2)))
        rows.append(_combination_row(c) | {text: "against it" if c.contradicts_text else "silent", missed: rms})
    note = "Short names of interpretations, in the order of the preceding table; base: all choices by default. Six "
    note += "printed numbers: two load ratios (deviations in per cent) and four model errors (in percentage points)."
    title = (
        f"Ratio of largest to smallest load, and model errors (Lin 2.4.1) for all {len(found)} combinations of "
        "interpretations"
    )
    return Table.from_rows("reconstruction-combinations", title, rows, note)


def _combination_row(result: readings.CombinationResult) -> Row:
    """Return the table row of a combination of interpretations: short names, load ratios by both models, model errors."""
    row: Row = {
        LOW_ORDER_READINGS: readings.combination_name(result.low_order_readings),
        READINGS_IN_3D: readings.combination_name(result.readings_in_3d),
    }
    return row | _ratio_cells_and_errors_by_definition(result)


def combinations_figure(found: list[readings.CombinationResult]) -> Figure:
    """Draw ratios of largest to smallest load and model errors for all combinations of interpretations, and as printed.

    ``found``: results of the combinations.
    """
    shown, aim = [*readings.explanations_shown_in_report(found).values()], readings.printed_load_ratio()
    others = [c for c in found if c not in shown]
    printed_errors = readings.printed_errors_percent()

    def scatter_series(
        abscissa_and_ordinate: Callable[[readings.CombinationResult], tuple[float, float]], printed: tuple[float, float]
    ) -> tuple[Series, ...]:
        """Return markers for all combinations of interpretations, and a marker for the printed values.

        ``abscissa_and_ordinate``: function that returns abscissa and ordinate of a combination; ``printed``: abscissa and
        ordinate of the printed values.
        """
        out = []
        for label, of, light in (("other combinations", others, True), ("explanations", shown, False)):
            points = [abscissa_and_ordinate(c) for c in of]
            out.append(Series(label, [x for x, _ in points], [y for _, y in points], style="markers", pale=light))
        return (*out, Series("printed", [printed[0]], [printed[1]], style="markers", bold=True))

    def rms_and_largest_error_of_case(k: int) -> Callable[[readings.CombinationResult], tuple[float, float]]:
        """Return a function that returns RMS and largest error [%] of the low-order loads in Lin's case ``k`` + 1.

        The errors are against the 3D loads. The returned function takes a combination of interpretations.
        """
        return lambda c: (c.errors_percent["own"][2 * k + 1], c.errors_percent["own"][2 * k])

    panels = (
        Panel(
            "Ratio of largest to smallest load, case 1",
            "low-order model",
            "3D model",
            scatter_series(lambda c: (c.low_order_ratio, c.ratio_in_3d), (aim, aim)),
        ),
        *(
            Panel(
                f"Errors of the low-order model in case {k + 1}, % of each load",
                "RMS error [%]",
                "largest error [%]",
                scatter_series(rms_and_largest_error_of_case(k), (printed_errors[2 * k + 1], printed_errors[2 * k])),
            )
            for k in range(2)
        ),
    )
    title = (
        "Ratio of largest to smallest load, and model errors (Lin 2.4.1), for all combinations of interpretations of the "
        "text"
    )
    return Figure("reconstruction", title, panels, columns=3)
