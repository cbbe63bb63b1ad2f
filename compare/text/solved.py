"""Texts and tables in which the terminal shows solved scenes, load cases, load curves and results over parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import mean_load
from rollbench.compare.models.programs import model_title
from rollbench.compare.models.registry import has_random_errors
from rollbench.compare.quantities import (
    count_with_noun,
    format_by_error,
    format_range,
    json_number,
    quantities_of_record,
    quantity_value,
    record_as_json,
)
from rollbench.compare.results.base import format_table_as_text, known_values
from rollbench.compare.results.load_curve import LoadCurve
from rollbench.compare.results.rows import bearing_and_nut_rows, duty_cycle_rows, expected_error_sentence, nested_records
from rollbench.compare.results.side_by_side import NUMBERS, Alternative, SideBySide
from rollbench.compare.results.solved import CycleResult, Result
from rollbench.compare.results.table import ERROR_OF, Table, TableRow
from rollbench.compare.text import printing
from rollbench.lowfi.statics.result import HEAT, AxisResult, Equilibrium, SolverReport, motion_in_um_and_mrad
from rollbench.lowfi.statics.tangent import TangentStiffness
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import FREEDOMS, SIDES

#: Headings in the table of a load curve, for keys that are too long for it.
OF_CURVE = {
    "nut_displacement_um": "nut um",
    "nut_tangent_N_per_um": "nut N/um",
    "load_point_displacement_um": "point um",
    "load_point_tangent_N_per_um": "point N/um",
}

#: Ratio of a force component to the largest component of the force, below which the component counts as round-off.
ROUND_OFF = 1e-9


def solved_case_parts(found: Result, *, balls: bool = False, details: bool = False, stiffness: bool = False) -> list[Any]:
    """Return the texts and tables that the terminal shows for a solved scene.

    These are the status, warnings, results, and the error to expect. ``balls``: also a table of all balls. ``details``:
    also further quantities, force balance, solver, assumptions and neglected effects; they are always shown if the scene
    has no equilibrium. ``stiffness``: also the stiffness of a shaft with several nuts or bearings.
    """
    result, title, scene = found.solution, [], found.described
    above_all, measured = join_brief_warnings(result.warnings), ""
    heat: list[str] = []
    behind = [] if result.equilibrium is None else _force_balance_lines(result.equilibrium, several=not found.only)
    details = details or not found.converged
    if isinstance(scene, Assembly):
        drawn, title = f", {count_with_noun(len(scene.sets), 'set')}", [scene.title]
        heat = [f"note: left out is the {HEAT}"] if scene.thermal_strain and not details else []
    else:
        drawn = f", specimen {found.member} of its random errors" if has_random_errors(scene) else ""
        grid = found.discretisation_percent
        measured = "" if grid is None else f" (discretisation error {grid:.1e} % of the mean load)"
    tables = _nut_bearing_and_housing_tables(found, stiffness=details or stiffness)
    tables += _ball_and_roller_tables(found) if balls else []
    if answers := found.rows(details=details):
        table = format_table_as_text(answers, printing.text_width())
        tables = ["", table, "", *tables, expected_error_sentence(found.expected_error)]
    behind += solver_lines(result.solver, measured)
    notes = [f"note: {line}" for line in result.solver.notes]
    return [
        f"{found.scene}{drawn}, model {model_title(found.model)}: {result.status}",
        *title,
        *([above_all] if above_all else []),
        *tables,
        *heat,
        *warning_and_note_lines(result.warnings, behind, found.assumed, found.left_out, details=details, notes=notes),
    ]


def warning_and_note_lines(
    warnings: Sequence[str],
    solution_lines: Sequence[str],
    assumed: Sequence[str],
    left_out: Sequence[str],
    *,
    details: bool,
    notes: Sequence[str] = (),
) -> list[str]:
    """Return the last lines on a solution: warnings, then force balance, solver, notes, assumptions and neglected effects.

    Without ``details``, all lines but the warnings are replaced by one line, which names the option that shows them.
    ``solution_lines``: lines on force balance and solver; ``assumed``, ``left_out``: assumptions and neglected effects.
    """
    remarks = (isinstance(line, ResultWarning) and not line.brief for line in warnings)
    warned = [f"{'note' if remark else 'warning'}: {line}" for remark, line in zip(remarks, warnings, strict=True)]
    if not details:
        counted = f"{count_with_noun(len(assumed), 'assumption')}, {count_with_noun(len(left_out), 'neglected effect')}"
        return [*warned, f"--verbose also shows: {counted}, force balance, solver, further quantities"]
    headed = ("assumed", assumed), ("left out", left_out)
    return [*solution_lines, *warned, *notes, *(f"{heading}: {line}" for heading, lines in headed for line in lines)]


def solver_lines(solver_report: SolverReport, measured: str = "") -> list[str]:
    """Return a line with solver, iterations, system size and time; with the time only if no solution was attempted.

    ``solver_report``: record of the solver. ``measured``: text on the discretisation error, which is added to the line.
    """
    r = solver_report
    if not math.isfinite(r.residual):
        return [f"solver: the scene was rejected before a solution was attempted, in {r.seconds:.3g} s"]
    counted = f"{count_with_noun(r.iterations, 'iteration')}, residual {r.residual:.1e}"
    system = f"{count_with_noun(r.unknowns, 'unknown')}, {count_with_noun(r.elements, 'beam element')}"
    return [f"solver: {r.formulation}; {counted}, {system}{measured}, {r.seconds:.3g} s"]


def load_curve_parts(curve: LoadCurve, *, details: bool = False) -> list[Any]:
    """Return the texts and the table in which the terminal shows a load curve: backlash, stiffness, and the points.

    ``details``: also the assumptions.
    """
    x, y, z = curve.direction
    way = next((name for name, on in zip("xyz", curve.direction, strict=True) if on == 1.0), f"({x:.3g}, {y:.3g}, {z:.3g})")

    def size(value: float | None, factor: float, unit: str) -> str:
        """Return ``value`` times ``factor`` as text, followed by the name ``unit`` of the unit; "unknown" for None."""
        return "unknown" if value is None else f"{format_by_error(factor * value)} {unit}"

    lash = f"not known: {curve.lash_words}" if curve.lash_words else size(curve.lash, 1e6, "um")
    sides = ((curve.backward, "below"), (curve.forward, "above"))
    stiff = " and ".join(f"{size(value, 1e-6, 'N/um')} {words}" for value, words in sides if value is not None)
    without = ["status"] if all(point.status == "converged" for point in curve.points) else []
    points = (record_as_json(point, *without) for point in curve.points)
    rows = [{OF_CURVE.get(key, key): value for key, value in point.items()} for point in points]
    return [
        f"{curve.scene}, model {model_title(curve.model)}: load along {way} at {curve.at}, {len(curve.points)} points",
        *([curve.above] if curve.above else []),
        f"lash (backlash between loads of both signs): {lash}; displacement from end to end of the curve "
        f"{size(curve.peak_to_peak, 1e6, 'um')}",
        *([f"stiffness from the ends of the lash to the ends of the curve: {stiff}"] if stiff else []),
        "displacement and tangent of the nut or bearing without its shaft, and of the load's point to ground",
        printing.table_of_records(rows, ".5g"),
        *(f"warning: {line}" for line in curve.warnings),
        *([f"assumed: {line}" for line in curve.assumed] if details else []),
    ]


def side_by_side_parts(side_by_side: SideBySide) -> list[Any]:
    """Return the texts and the table that the terminal shows for scenes side by side.

    The table has a column for each scene, with the difference from the first scene in per cent.
    """
    rows = []
    for key, one in side_by_side.numbers.items():
        off = side_by_side.difference_percent(key)
        shown = ["", *("" if x is None else f"  {x:+.1f} %" for x in off[1:])]
        cells = [number_or_range_text(one.value(x)) + text for x, text in zip(side_by_side.scenes, shown, strict=True)]
        rows.append([f"{one.label} [{one.unit}]" if one.unit else one.label, *cells])
    if any(one.shortest for one in side_by_side.scenes):
        rows.append(["set with the shortest life", *(one.shortest or "–" for one in side_by_side.scenes)])
    warned = [(one.scene, join_brief_warnings(one.warnings)) for one in side_by_side.scenes]
    every = quantities_of_record(Alternative)
    unknown = [f"{every[key].label} [{every[key].unit}]" for key in NUMBERS if key not in side_by_side.numbers]
    title, headings = f"model {side_by_side.model}: scenes side by side", ["", *(one.scene for one in side_by_side.scenes)]
    return [
        *(f"{name}: {line}" for name, line in warned if line),
        *(f"{one.scene}: {one.status}" for one in side_by_side.scenes if one.status != "converged"),
        printing.TextTable(headings, rows, title),
        side_by_side.inputs_in_words,
        *([f"not computed: {', '.join(unknown)}; rollbench solve SCENE shows why"] if unknown else []),
        "per cent: difference from the first scene; rollbench solve SCENE shows all results",
    ]


def number_or_range_text(value: Any) -> str:
    """Format a number, or a list of two numbers as a range; None becomes a dash."""
    return "–" if value is None else format_range(value, 4) if isinstance(value, list) else format_by_error(value)


def _force_balance_lines(equilibrium: Equilibrium, *, several: bool) -> list[str]:
    """Return lines for the terminal on the residuals of the force and moment balance of a screw or shaft.

    ``equilibrium``: the residuals. ``several``: whether the scene is a shaft with several nuts or bearings.
    """
    sums = f"force {equilibrium.force_residual:.1e}, moment {equilibrium.moment_residual:.1e}"
    if several:
        return [f"balance of the shaft: {sums} (relative)"]
    screw = f"balance of the screw: {sums} (relative, summed over loads, reactions and contacts)"
    lines = [f"{screw}; balance of the balls: {equilibrium.ball_residual:.1e}"]
    if equilibrium.pin_share > 0.0:
        share = f"{100.0 * equilibrium.pin_share:.2g} % of the largest force or moment"
        pin = "no support of the scene prevents one motion: an added pin does"
        lines.append(f"{pin}, and carries {share}, by which loads and supports are not in balance")
    return lines


def _ball_and_roller_tables(found: Result) -> list[Any]:
    """Return the tables of balls with loads and angles on the loaded groove flanks, of these flanks, and of rollers.

    Loads are rounded to the digits that their expected error justifies.
    """
    numbered = [({} if found.only else {"set": str(k)}, s) for k, s in enumerate(found.sets.values(), 1)]
    of_balls = [ball.load for _, s in numbered for ball in s.ball_rows()]
    loaded = [side for k, side in enumerate(SIDES) if any(load[k] > 0.0 for load in of_balls)]
    balls, flanks, rollers = (list[dict[str, Any]]() for _ in range(3))
    for head, s in numbered:
        expected, error = None if found.expected_error is None else found.expected_error.loads, None
        if expected is not None and s.loads is not None:
            error = mean_load(s.loads, s.nominal_contacts) * expected / 100.0
        for ball in s.ball_rows() if loaded else ():
            row = head | {"ball": str(ball.index), "deg": math.degrees(ball.azimuth), "z mm": 1e3 * ball.z}
            for side, load, angle in zip(SIDES, ball.load, ball.angle, strict=True):
                if side in loaded:
                    shown = json_number(math.degrees(angle)) if load > 0.0 else None
                    row |= {f"{side} N": format_by_error(load, error), f"{side} angle": shown}
            balls.append(row)
        for side, x in (s.load_of_flanks or {}).items():
            ends = {"max N": x.largest, "min N": x.smallest, "max/min": x.ratio}
            counts = {"loaded": x.loaded_contacts, "unloaded": x.unloaded_contacts}
            flanks.append(head | {"flank": side} | {key: format_by_error(v, error) for key, v in ends.items()} | counts)
        rollers += [head | known_values(record_as_json(roller)) for roller in s.roller_rows()]
    tables = ((balls, ".2f"), (flanks, ".4g"), (rollers, ".5g"))
    return [part for rows, digits in tables if rows for part in (printing.table_of_records(rows, digits), "")]


def tangent_stiffness_parts(tangent: TangentStiffness) -> list[Any]:
    """Return the text and the table that show the 6 x 6 stiffness at a cross-section of the screw, in N, m and rad.

    ``tangent``: the stiffness, with its axial position; without a solution, the text states the reason.
    """
    if tangent.status != "converged":
        return [f"stiffness at {1e3 * tangent.station:.6g} mm: {tangent.status}"]
    rows = [(name, *(f"{x:.4g}" for x in row)) for name, row in zip(FREEDOMS, tangent.matrix, strict=True)]
    head = (
        f"tangent stiffness of the screw's cross-section at {1e3 * tangent.station:.6g} mm with the nut fixed, without the "
        "screw's supports: forces and moments (rows) by displacements and rotations (columns), in N, m, rad"
    )
    return ["", head, printing.TextTable(("", *FREEDOMS), rows)]


def _nut_bearing_and_housing_tables(found: Result, *, stiffness: bool) -> list[Any]:
    """Return the tables and lines in which the terminal shows the nuts, bearings and housings of a shaft.

    ``stiffness``: also the stiffness of the shaft.
    """
    if not found.converged or not isinstance(found.solution, AxisResult):
        return []
    result, rows = found.solution, bearing_and_nut_rows(found.sets)
    cells = [[*row.values()] for row in rows]
    out: list[Any] = [printing.TextTable([*rows[0]], cells), ""]
    for h in result.housings:
        motion = {n.partition("_"): x for n, x in motion_in_um_and_mrad(h.motion).items() if x}
        moved = ", ".join(f"{freedom} {x:.4g} {unit}" for (freedom, _, unit), x in motion.items())
        least = ROUND_OFF * np.abs(h.wrench[:3]).max()
        force = ", ".join(format_by_error(x) if abs(x) > least else "0" for x in h.wrench[:3])
        reaction = f"force of the frame on it ({force}) N; relative residual of its balance {h.residual:.1e}"
        out.append(f"{h.name}: {moved or 'does not move'}; {reaction}")
    return [*out, *(_axis_stiffness_lines(result) if stiffness else [])]


def _axis_stiffness_lines(result: AxisResult) -> list[str]:
    """Return lines with a shaft's stiffness in each degree of freedom: with the five others fixed, and with them free."""
    if result.stiffness is None:
        return []
    d = np.diag(result.stiffness)
    words = [f"{n} {1e-6 * x:.5g} N/um" for n, x in zip(FREEDOMS[:3], d[:3], strict=True) if np.isfinite(x)]
    words += [f"{n} {1e-3 * x:.5g} kN m/rad" for n, x in zip(FREEDOMS[3:], d[3:], strict=True) if np.isfinite(x)]
    with np.errstate(all="ignore"):
        free = np.isfinite(d)
        C = np.linalg.inv(result.stiffness[np.ix_(free, free)])
    alone = dict(zip(np.array(FREEDOMS)[free], 1.0 / np.diag(C), strict=True))
    lone = [f"{n} {1e-6 * alone[n]:.5g} N/um" for n in FREEDOMS[:3] if n in alone]
    return [
        f"tangent stiffness of the whole axis, {result.stiffness_at}, other degrees of freedom fixed: {', '.join(words)}",
        f"tangent stiffness of the whole axis, other degrees of freedom free: {', '.join(lone)}",
    ]


#: Columns of the table of load cases: heading, record in the results of a case, key of its quantity.
COLUMNS = (
    ("largest contact load N", "loads", "max_N"),
    ("axial force N", "axial", "force_N"),
    ("peak pressure MPa", "worst_contact", "pressure_MPa"),
    ("static safety", "static_safety", "factor"),
    ("life L10 1e6 rev", "life", "L10_million_revolutions"),
    ("life L10r 1e6 rev", "reference_life", "L10r_million_revolutions"),
)


def duty_cycle_parts(
    found: CycleResult, *, balls: bool = False, details: bool = False, stiffness: bool = False
) -> list[Any]:
    """Return the texts and tables for a duty cycle: results over all load cases, a table of load cases, then each case.

    ``found``: results of the load cases, and extremes and lives over all cases. ``balls``, ``details``, ``stiffness``: see
    `solved_case_parts`.
    """
    cases = found.cycle.cases
    parts: list[Any] = [
        f"{found.scene}, model {found.model}: {count_with_noun(len(cases), 'load case')}, {found.reason or 'converged'}",
        "",
    ]
    parts += [format_table_as_text(duty_cycle_rows(found.together), printing.text_width()), ""]
    parts += [printing.table_of_records([*load_case_rows(found)]), ""]
    shown: set[str] = set()
    for case, one in zip(cases, found.cases.values(), strict=True):
        lines = solved_case_parts(one, balls=balls, details=details, stiffness=stiffness)
        lines = [x for x in lines if not (isinstance(x, str) and x in shown)]
        shown |= {x for x in lines if isinstance(x, str) and x.startswith(("assumed: ", "left out: "))}
        stiff = tangent_stiffness_parts(one.tangent) if one.tangent else []
        parts += [f"case {case.name}, share {case.share:.4g}", *lines, *stiff, ""]
    return parts


def load_case_rows(found: CycleResult) -> Iterator[dict[str, Any]]:
    """Yield a table row for each load case, by the headings of the table.

    ``found``: results of the load cases.
    """
    for case, one in zip(found.cycle.cases, found.cases.values(), strict=True):
        records = {} if one.worst_set is None else nested_records(one.worst_set)
        records |= nested_records(one)
        row: dict[str, Any] = {"case": case.name, "share": case.share}
        row |= {heading: quantity_value(records.get(group), key) for heading, group, key in COLUMNS}
        yield row | {"expected error %": None if one.expected_error is None else one.expected_error.loads}


#: Largest number of printed reasons why combinations of parameter values have no results.
REASONS = 5


def parameter_table_parts(table: Table) -> list[Any]:
    """Return the texts and tables in which the terminal shows results over values of scene parameters.

    These are the table of quantities with their expected errors, then lines on the combinations of values without results.
    """
    whole = printing.table_of_records(_parameter_table_rows(table))
    return [whole.text(printing.text_width()), "", *_parameter_table_summary_lines(table)]


def _parameter_table_rows(found: Table) -> list[dict[str, Any]]:
    """Return a row for each combination of parameter values: the values, the computed quantities and their expected errors.

    The keys of a row are the headings of the table. ``found``: results over values of scene parameters.
    """
    named, rows = quantities_of_record(TableRow), []
    for row, place in zip(found.rows, found.places, strict=True):
        shown: dict[str, Any] = {f"{x.key} {x.unit}".rstrip(): place[x.column] for x in found.over}
        for key, field in ERROR_OF.items():
            value = named[key].value(row)
            shown[f"{named[key].label} {named[key].unit}"] = value
            if field not in ("", "load_error"):
                shown[f"{named[key].label} ± %"] = None if value is None else _round_percent(getattr(row, field))
        rows.append(shown | {"loads ± %": _round_percent(row.load_error)})
    return rows


def _round_percent(percent: float | None) -> float | None:
    """Round an error [%] to two significant digits; None stays None."""
    return None if percent is None else float(f"{percent:.2g}")


def _parameter_table_summary_lines(found: Table) -> Iterator[str]:
    """Yield lines on how many combinations of parameter values have results, why others have none, and on unknown errors.

    ``found``: results over values of scene parameters.
    """
    matrix = any(row.stiffness is not None for row in found.rows)
    further = "; ±: error to expect" if any(row.load_error is not None for row in found.rows) else ""
    further += "; --json and --out have the 6 x 6 stiffness" if matrix else ""
    yield f"{found.converged} of {len(found.rows)} rows have results{further}"
    yield from missing_result_lines(found)
    yield from dict.fromkeys(f"expected error not known: {row.error_words}" for row in found.rows if row.error_words)


def missing_result_lines(found: Table) -> Iterator[str]:
    """Yield a line for each of the first five reasons for missing results, with the parameter values concerned.

    ``found``: results over values of scene parameters.
    """
    reasons = list(found.failures.items())
    for reason, places in reasons[:REASONS]:
        others = f" and {count_with_noun(len(places) - 1, 'further row')}" if places[1:] else ""
        yield f"{places[0]}{others}: {reason}"
    if reasons[REASONS:]:
        yield f"{count_with_noun(len(reasons) - REASONS, 'further reason')}: see the status of the rows"
