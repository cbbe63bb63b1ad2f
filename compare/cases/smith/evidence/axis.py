"""Smith (1994), chapters 4 and 5: stiffness of a ball-screw axis with its support bearings, tests, reduced preload.

Several layouts of the axis are also solved as scenes over the nut's position, and compared with closed formulas and with
Smith's formula for springs in series.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from rollbench.compare.cases.smith.evidence import bearings
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.bearings import as_printed, axis
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.units import parse_quantity

#: Axial position of the middle of the left support [m]; positions of the nut over the length between the supports.
FIRST, PLACES = 2.0 * bearings.INCH, (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class SupportBearingLayout:
    """An arrangement of support bearings at both ends of the screw in Smith's thesis.

    ``scene_name``: name of its scene; ``description``: in words; ``bearing_kind``: "ball" or "taper";
    ``left_row_directions``, ``right_row_directions``: for each bearing row of an end, +1 if tension of the screw loads the
    row, -1 if compression does; empty if the end is free to slide.
    """

    scene_name: str
    description: str
    bearing_kind: str
    left_row_directions: tuple[int, ...]
    right_row_directions: tuple[int, ...]

    def bearing_rows_at(self, end: str) -> axis.BearingRows:
        """Return the bearing rows of one end with their load-deflection laws; ``end``: "left" or "right"."""
        directions = self.left_row_directions if end == "left" else self.right_row_directions
        if directions == bearings.DIRECTIONS[self.bearing_kind][end]:
            return bearings.bearing_rows_at_end(self.bearing_kind, end)
        return axis.equal_rows_with_gap(bearings.smith_ball_bearing(), directions, 0.0)


TRIPLEX = SupportBearingLayout("smith-axis", "triplex, fixed-fixed", "ball", *bearings.DIRECTIONS["ball"].values())

SUPPORTED = SupportBearingLayout(
    "smith-axis-supported", "triplex, fixed-supported", "ball", bearings.DIRECTIONS["ball"]["left"], ()
)

TANDEM = SupportBearingLayout("smith-axis-tandem", "tandem pairs, fixed-fixed", "ball", (1, 1), (1, 1))

TAPERED = SupportBearingLayout(
    "smith-axis-taper", "two-row tapered, fixed-fixed", "taper", *bearings.DIRECTIONS["taper"].values()
)

LAYOUTS = TRIPLEX, SUPPORTED, TANDEM, TAPERED


@dataclass(frozen=True)
class EndThrustsAndAxisStiffness:
    """Thrust on both end supports of a ball-screw axis, and axial stiffness of the axis at the nut.

    ``left_thrust``, ``right_thrust``: thrust on the left and right supports, positive in tension of the screw [N];
    ``axis_stiffness``: axial stiffness of screw and supports at the nut [N/m], without the stiffness of the nut.
    """

    left_thrust: float
    right_thrust: float
    axis_stiffness: float


@cache
def solve_by_formulas(
    layout: SupportBearingLayout, nut_position: float, load_on_nut: float = bearings.APPLIED
) -> EndThrustsAndAxisStiffness:
    """Return the thrust on both end supports and the stiffness of a screw axis, by closed formulas.

    All bearing rows of an end are at one position.

    ``layout``: support bearings of the axis; ``nut_position``: position of the nut over the length between the supports;
    ``load_on_nut``: axial load on the nut, towards the left end [N]. The screw is stretched as in Smith's thesis, and the
    bearing rows are preloaded.
    """
    a, first = bearings.screw_bar(), layout.bearing_rows_at("left")
    bars = np.array([nut_position, 1.0 - nut_position]) * a.length / (a.young * a.area)
    if not layout.right_row_directions:
        k = axis.solve_bearing_row_equilibrium(first, -load_on_nut).stiffness
        return EndThrustsAndAxisStiffness(-load_on_nut, 0.0, 1.0 / (1.0 / k + float(bars[0])))
    second = layout.bearing_rows_at("right")

    def stretch_error(left: float) -> float:
        """Return the elongation [m] of supports and screw under a thrust [N] on the left end, less the imposed stretch."""
        forces = left, left + load_on_nut
        loaded = zip((first, second), forces, strict=True)
        moved = sum(axis.solve_bearing_row_equilibrium(rows, f).displacement for rows, f in loaded)
        return moved + float(bars @ forces) - bearings.STRETCH

    low = 1e-3 if min(layout.left_row_directions) > 0 else -2e4  # tandem rows carry tension only
    left = float(brentq(stretch_error, low, 4e4, xtol=1e-6))
    right = left + load_on_nut
    ends = [axis.solve_bearing_row_equilibrium(rows, f).stiffness for rows, f in ((first, left), (second, right))]
    stiffness = sum(1.0 / (1.0 / k + float(b)) for k, b in zip(ends, bars, strict=True))
    return EndThrustsAndAxisStiffness(left, right, stiffness)


def solve_by_beam_model(
    cache: SceneResultCache,  # noqa: ARG001 - `compute_once` passes it
    layout: SupportBearingLayout,
    nut_position: float,
) -> EndThrustsAndAxisStiffness:
    """Return the thrust on both end supports and the stiffness of a screw axis, by a beam model with contacts.

    Each bearing row acts at its actual axial position. ``layout``: support bearings of the axis; ``nut_position``: position
    of the nut over the length between the supports; ``cache``: not used here. AssertionError without convergence.
    """
    found = catalogue.shipped_scene_of_kind(layout.scene_name, Assembly)
    at = FIRST + nut_position * bearings.screw_bar().length
    loads = tuple(replace(x, at=at, force=(0.0, 0.0, -bearings.APPLIED)) for x in found.loads)
    result = run_model(replace(found, loads=loads, stiffness_at=at), "lin", ModelOptions())
    assert result.converged, f"{layout.scene_name}: {result.status}"
    assert result.stiffness is not None
    thrust = {end: sum(float(s.force[2]) for s in result.sets if s.of.name.startswith(end)) for end in ("left", "right")}
    return EndThrustsAndAxisStiffness(-thrust["left"], thrust["right"], float(result.stiffness[2, 2]))


def axis_stiffness_by_sum_in_series(layout: SupportBearingLayout) -> float:
    """Return the axis stiffness [N/m] without the nut by Smith's equation (4.6) for springs in series.

    The springs are both supports and the whole screw. ``layout``: support bearings of the axis; the result is nan if the
    screw is fixed at one end only, for which Smith gives no formula.
    """
    if not layout.right_row_directions:
        return float("nan")
    a, force = bearings.screw_bar(), solve_by_formulas(layout, 0.5, 0.0).left_thrust
    ends = [axis.solve_bearing_row_equilibrium(layout.bearing_rows_at(end), force).stiffness for end in ("left", "right")]
    return as_printed.axis_stiffness_as_printed(
        ends, float(axis.shaft_and_support_stiffness(a, 0.5 * a.length)), float("inf")
    )


def results_in_words(cache: SceneResultCache, layout: SupportBearingLayout) -> str:
    """Return in words the thrust on both end supports and the stiffness of a screw axis, by beam model and formulas.

    The nut is at mid-length.

    ``cache``: gives the solved scenes; ``layout``: support bearings of the axis.
    """
    scene, closed = cache.compute_once(solve_by_beam_model, layout, 0.5), solve_by_formulas(layout, 0.5)
    ends = [f"{x.left_thrust / bearings.POUND:.0f} and {x.right_thrust / bearings.POUND:.0f} lbf" for x in (scene, closed)]
    stiff = [f"{x.axis_stiffness / bearings.POUND_PER_INCH / 1e6:.3f}e6 lbf/in" for x in (scene, closed)]
    return f"by the beam model the ends carry {ends[0]} ({stiff[0]} without the nut), by formulas {ends[1]} ({stiff[1]})"


#: Lead [m] and rapid traverse [m/s] of the tested axis, section 5.1 of Smith's thesis.
LEAD, TRAVERSE = parse_quantity("14 mm", "length"), 800.0 * bearings.INCH / 60.0

#: Encoder counts per turn, motor torque [in-lbf], and the reduced preload of section 5.3 [N].
COUNTS, MOTOR, REDUCED = 40000.0, 159.0, parse_quantity("750 lbf", "force")

#: Density of steel [kg/m^3] for the screw's moment of inertia, which Smith does not print.
STEEL = 7850.0

KINDS = ("ball", "taper")


def screw_tension() -> float:
    """Return the tension [N] of the stretched screw between rigid supports."""
    return axis.shaft_tension(bearings.screw_bar(), bearings.STRETCH)


@cache
def bearing_set_state(kind: str, end: str, state: str, preload: float = bearings.PRELOAD) -> axis.BearingRowsState:
    """Return the equilibrium of the bearing rows at one end of the screw axis, under preload, stretch or applied load.

    ``kind``: "ball" or "taper"; ``end``: "left" or "right"; ``state``: "preload": only the preload acts; "stretch": the
    screw is stretched, too; "applied": the carriage's load of Smith's section 4.2 acts as well; ``preload``: preload [N] as
    in `bearings.bearing_rows_at_end`.
    """
    rows = bearings.bearing_rows_at_end(kind, end, preload)
    if state == "preload":
        return axis.solve_bearing_row_equilibrium(rows)
    bar, applied = bearings.screw_bar(), bearings.APPLIED if state == "applied" else 0.0
    left, right = axis.support_loads(bar, 0.5 * bar.length, -applied, screw_tension())
    return axis.solve_bearing_row_equilibrium(rows, left if end == "left" else right)


def row_loads_by_smith_rule_lbf(kind: str, end: str, state: str, preload: tuple[float, ...]) -> list[float]:
    """Return the loads [lbf] of the bearing rows at one end of the axis by Smith's rule, which violates equilibrium.

    By this rule, half of the screw's tension and half of the carriage's load act at each end. They are added to the
    preloads of the rows that they load, and subtracted from the preloads of the rows of opposite direction. ``kind``:
    "ball" or "taper"; ``end``: "left" or "right"; ``state``: "stretch" or "applied"; ``preload``: preload of each row
    [lbf].
    """
    directions = bearings.DIRECTIONS[kind][end]
    half_tension = 0.5 * round(screw_tension() / bearings.POUND, -1)
    loads = as_printed.bearing_row_loads_as_printed(preload, directions, half_tension)
    if state == "applied":
        half_load = (-0.5 if end == "left" else 0.5) * bearings.APPLIED / bearings.POUND
        loads = as_printed.bearing_row_loads_as_printed(list(loads), directions, half_load)
    return [float(v) for v in loads]


def section_4_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the stretch of the screw and the warming that relieves it: section 4.1 of Smith (1994).

    ``findings``: receives the computed value to compare with each printed number. ``cache``: not used here.
    """
    a = bearings.screw_bar()
    diameter = 2.0 * float(np.sqrt(a.area / np.pi))
    findings.numbers(
        {
            "L": a.length / bearings.INCH,
            "d": diameter / bearings.INCH,
            "stretch": bearings.STRETCH / bearings.INCH,
            "expansion": bearings.EXPANSION * bearings.DEG_F,
            "E": a.young / bearings.PSI,
            "dT": axis.warming_that_removes_tension(a, bearings.STRETCH, bearings.EXPANSION) / bearings.DEG_F,
        }
    )
    findings.follow({"eps": bearings.STRETCH / a.length})
    stiff = {kind: bearing_set_state(kind, "left", "stretch").stiffness for kind in KINDS}
    elastic = [axis.shaft_tension(bearings.screw_bar(k, k), bearings.STRETCH) / bearings.POUND for k in stiff.values()]
    words = f"{elastic[0]:.0f} and {elastic[1]:.0f} lbf if the stretch is of the ends and the bearings give way"
    tension = screw_tension() / bearings.POUND
    findings.add_number("F", tension, words)
    findings.add_number("F_end", tension, as_printed=0.5 * round(tension, -1))


def section_4_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute loads and stiffness of support bearings and axis: section 4.2 of Smith (1994).

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds;
    ``cache``: gives the solved scenes.
    """
    for kind in KINDS:
        for end in bearings.DIRECTIONS[kind]:
            _compute_bearing_row_loads(findings, kind, end)
    a = bearings.screw_bar()
    least = float(axis.shaft_and_support_stiffness(a, 0.5 * a.length))
    findings.numbers({"screw": least / bearings.POUND_PER_INCH, "nut": bearings.NUT / bearings.POUND_PER_INCH})
    findings.add_number("applied", bearings.APPLIED / bearings.POUND)
    ours = {kind: bearing_set_state(kind, "left", "stretch").stiffness / bearings.POUND_PER_INCH for kind in KINDS}
    findings.add_number("package_ball", ours["ball"])
    findings.add_number("package_taper", ours["taper"], follows=2.0 * findings.printed("taper_left_stiffness_1"))
    for kind in KINDS:
        findings.follow({f"rows_{kind}": 2.0 * sum(len(rows) for rows in bearings.DIRECTIONS[kind].values())})
    _compute_axis_stiffness(findings, "ball", results_in_words(cache, TRIPLEX))
    _compute_axis_stiffness(findings, "taper", results_in_words(cache, TAPERED))
    places = np.linspace(0.0, a.length, 53)[1:-1]
    both_ends, one = (axis.shaft_and_support_stiffness(bar, places) for bar in (a, bearings.screw_bar(right=0.0)))
    at = float(places[int(np.argmin(both_ends))] / a.length)
    findings.add_claim("middle", abs(at - 0.5) < 0.01, f"least at {at:.2f} L")
    ratio = both_ends / one
    middle = float(ratio[ratio.size // 2])
    scenes = [cache.compute_once(solve_by_beam_model, x, 0.5).axis_stiffness for x in (TRIPLEX, SUPPORTED)]
    words = f"ratio {ratio.min():.2f} to {ratio.max():.0f}, {middle:.1f} in the middle"
    words += f"; by the beam model, fixed at both ends over fixed at one, {scenes[0] / scenes[1]:.2f} in the middle"
    findings.add_claim("supported", bool(np.all(ratio > 1.0)), words)


def _compute_bearing_row_loads(findings: ComputedEntryValues, kind: str, end: str) -> None:
    """Compute loads and stiffness of the bearing rows at one end of the axis; ``findings`` receives the results.

    ``kind``: "ball" or "taper"; ``end``: "left" or "right".
    """
    count = len(bearings.DIRECTIONS[kind][end])
    preload = tuple(findings.printed(f"{kind}_{end}_preload_{i + 1}") for i in range(count))
    for state in ("preload", "stretch", "applied"):
        ours = bearing_set_state(kind, end, state)
        printed = None if state == "preload" else row_loads_by_smith_rule_lbf(kind, end, state, preload)
        for i in range(count):
            thrust, by_smith = float(ours.row_thrusts[i]) / bearings.POUND, None if printed is None else printed[i]
            findings.add_number(f"{kind}_{end}_{state}_{i + 1}", thrust, as_printed=by_smith)
    ours = bearing_set_state(kind, end, "applied")
    for i in range(count):
        findings.add_number(f"{kind}_{end}_stiffness_{i + 1}", float(ours.row_stiffness[i]) / bearings.POUND_PER_INCH)
    total = sum(findings.printed(f"{kind}_{end}_stiffness_{i + 1}") for i in range(count))
    words = "computed from the equilibrium of the rows"
    findings.add_number(f"{kind}_{end}_package", ours.stiffness / bearings.POUND_PER_INCH, words, follows=total)


def stiffness_at_mid_length(support_stiffness: float) -> float:
    """Return the axial stiffness [N/m] of the axis with the nut at mid-length, both halves of the screw in parallel.

    ``support_stiffness``: stiffness of each support [N/m].
    """
    a = bearings.screw_bar(support_stiffness, support_stiffness)
    return float(axis.carriage_to_frame_stiffness(a, 0.5 * a.length, bearings.NUT))


def _compute_axis_stiffness(findings: ComputedEntryValues, kind: str, beam_model_remark: str) -> None:
    """Compute the axis stiffness by Smith's formula for springs in series, and with both halves of the screw in parallel.

    ``kind``: "ball" or "taper"; ``beam_model_remark``: remark with the thrust on both end supports and the axis stiffness
    by the beam model. ``findings``: receives the results.
    """
    package, screw, nut = (findings.printed(k) for k in (f"package_{kind}", "screw", "nut"))
    printed = as_printed.axis_stiffness_as_printed((package, package), screw, nut)
    right = stiffness_at_mid_length(package * bearings.POUND_PER_INCH) / bearings.POUND_PER_INCH
    ours = stiffness_at_mid_length(bearing_set_state(kind, "left", "stretch").stiffness) / bearings.POUND_PER_INCH
    off = float(error_percent(printed, right))
    words = (
        "computed: both halves of the screw in parallel, with the computed stiffness of the bearings; follows: with the "
    )
    words += f"printed one, from which the formula for springs in series is {off:+.0f} % off"
    findings.add_number(f"total_{kind}", ours, f"{words}; {beam_model_remark}", as_printed=printed, follows=right)


def section_4_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the torque that the motor must supply: section 4.3 of Smith (1994).

    ``findings``: receives the computed value to compare with each printed number. ``cache``: not used here.
    """
    rows = {"ball": (3, printed_value("smith-2.3", "M")), "taper": (2, printed_value("smith-3", "M"))}
    findings.add_number("nut", 18.0)
    shaft = axis.shaft_inertia(STEEL, 2.0 * float(np.sqrt(bearings.screw_bar().area / np.pi)), bearings.screw_bar().length)
    alone = axis.acceleration_torque([shaft], axis.screw_angular_speed(TRAVERSE, LEAD), 1.0) / bearings.INCH_POUND
    words = f"the screw's own inertia takes {alone:.2f} in-lb in 1 s; the rest is not printed"
    findings.add_number("acceleration", None, words)
    for kind, (count, torque) in rows.items():
        ends = (count * torque,) * 2
        ours = count * sum(bearings.torque_of_ball_bearing_row()) if kind == "ball" else None
        screw, nut, start = (findings.printed(key) for key in ("screw", "nut", "acceleration"))
        constant = screw + nut + sum(ends)
        findings.add_number(f"bearings_{kind}", ours, follows=ends[0])
        sums = {"constant": constant, "start": constant + start}
        findings.follow({f"{when}_{kind}": total for when, total in sums.items()})


# --- chapter 5


def _record_axis_and_drive_data(findings: ComputedEntryValues) -> None:
    """Compute speed, encoder resolution and further data of the tested axis and its drive: section 5.1 of Smith (1994).

    ``findings``: receives the results.
    """
    warming = axis.warming_that_removes_tension(bearings.screw_bar(), bearings.STRETCH, bearings.EXPANSION) / bearings.DEG_F
    findings.numbers(
        {
            "lead": 1e3 * LEAD,
            "speed": 60.0 * TRAVERSE / bearings.INCH,
            "base": 35.0,
            "counts": COUNTS,
            "motor": MOTOR,
            "preload_750": REDUCED / bearings.POUND,
        }
    )
    rpm = axis.screw_angular_speed(TRAVERSE, LEAD) / bearings.RPM
    findings.follow({"rpm": rpm, "resolution": 1e6 * LEAD / COUNTS / bearings.INCH})
    findings.add_claim("five", 4.5 < warming < 5.0, f"{warming:.2f} degF")


def _compare_torque_tests(findings: ComputedEntryValues) -> None:
    """Compare predicted torques of the axis (sums of printed contributions) with the tests: section 5.2.1 of Smith (1994).

    ``findings``: receives the results.
    """
    off = {}
    for kind in KINDS:
        for when in ("start", "constant"):
            key = f"{when}_{kind}"
            predicted = printed_value("smith-4.3", key)
            off[key] = float(error_percent(predicted, findings.printed(key)))
            findings.add_number(key, None, "follows: the source's prediction, a sum of printed parts", follows=predicted)
        findings.follow({f"used_{kind}": 100.0 * findings.printed(f"start_{kind}") / MOTOR})
    words = ", ".join(f"{v:+.1f} %" for v in off.values())
    findings.add_claim("torque_10", all(abs(v) <= 10.0 for v in off.values()), words)
    single = [float(error_percent(printed_value(t, "M"), printed_value(t, "M_test"))) for t in ("smith-2.3", "smith-3")]
    findings.add_claim("torque_10_single", all(abs(v) <= 10.0 for v in single), ", ".join(f"{v:+.0f} %" for v in single))
    ball, taper = (printed_value(t, "M_test") for t in ("smith-2.3", "smith-3"))
    findings.add_claim("four_times", 3.5 <= taper / ball <= 4.0, f"{taper / ball:.1f} times")
    rpm = findings.printed("rpm") * bearings.RPM
    rib = bearings.rib_speed_ft_per_min(rpm)
    findings.add_remark("rib_speed", f"at the traverse of his axis the rib runs at {rib:.0f} ft/min")
    findings.add_number("disparity", None, f"measured {2.0 * taper / (3.0 * ball):.2f}", follows=4.0 * 2.0 / 3.0)


def _compare_stiffness_tests(findings: ComputedEntryValues) -> None:
    """Compare the computed stiffness of the axis with the tests: section 5.2.2 of Smith (1994).

    ``findings``: receives the results.
    """
    off, ours = [], []
    for kind in KINDS:
        right = stiffness_at_mid_length(bearing_set_state(kind, "left", "stretch").stiffness) / bearings.POUND_PER_INCH
        measured, predicted = findings.printed(f"S_{kind}"), printed_value("smith-4.2", f"total_{kind}")
        off.append(float(error_percent(predicted, measured)))
        ours.append(right)
        parallel = float(error_percent(right, measured))
        words = f"printed prediction {off[-1]:+.2f} %, both halves of the screw in parallel {parallel:+.0f} %"
        findings.add_number(f"S_{kind}", right, words)
    findings.add_claim("within_2.5", all(abs(v) <= 2.5 for v in off), ", ".join(f"{v:+.2f} %" for v in off))
    follows = float(error_percent(findings.printed("S_ball"), findings.printed("S_taper")))
    findings.add_number("six", float(error_percent(*ours)), follows=follows)


def _compare_temperature_rises(findings: ComputedEntryValues) -> None:
    """Compare measured temperature rises with the friction torques that cause them: section 5.2.4 of Smith (1994).

    ``findings``: receives the results.
    """
    torque = {
        "rise_ball": printed_value("smith-2.3", "M_test_3"),
        "rise_nut": printed_value("smith-4.3", "nut"),
        "rise_taper": printed_value("smith-3", "M_test_2"),
    }
    a_pound = {key: findings.printed(key) / value for key, value in torque.items()}
    spread = float(error_percent(max(a_pound.values()), min(a_pound.values())))
    findings.add_claim("rise_order", spread < 15.0, f"degF per in-lb alike to {spread:.0f} %")
    ratio = findings.printed("rise_taper") / findings.printed("rise_ball")
    findings.add_claim("three_times", 2.5 <= ratio <= 3.5, f"{ratio:.2f}")


def carriage_load_that_unloads_row(preload: float) -> float:
    """Return the load [N] on the carriage at mid-length that unloads the outer tapered-bearing row of one end of the axis.

    ``preload``: preload of the bearing rows [N]. The screw is stretched. The row is unloaded when the fraction of the
    carriage's load that acts on this end equals the lift-off load of its bearing rows less the tension of the screw.
    """
    bar = bearings.screw_bar()
    share = axis.support_loads(bar, 0.5 * bar.length, 1.0)[0]
    lift_off = axis.lift_off_force(bearings.bearing_rows_at_end("taper", "left", preload))
    return (lift_off - screw_tension()) / share


def tapered_row_torques() -> list[tuple[str, float, float, tuple[float, float]]]:
    """Return the torques that Smith prints of rows of tapered rollers, each with our band.

    Each entry has the key of the printed number, the thrust on the row [lbf] as computed from equilibrium, the printed
    torque and our band (low, high) [in-lbf].
    """
    found = [(key, "smith-3", bearings.TAPER_TORQUE_LOAD) for key in ("M", "M_test")]
    for load, preload in (("750", REDUCED), ("1500", bearings.PRELOAD)):
        for end in ("left", "right"):
            state = bearing_set_state("taper", end, "stretch", preload)
            found += [(f"t{load}_{end}_{i}", "smith-5", float(state.row_thrusts[i - 1])) for i in (1, 2)]
    return [
        (key, thrust / bearings.POUND, printed_value(table, key), bearings.torque_of_tapered_row_in_lbf(thrust))
        for key, table, thrust in found
    ]


def _compute_loads_at_reduced_preload(findings: ComputedEntryValues) -> None:
    """Compute the bearing loads with the reduced preload of 750 lbf: section 5.3 of Smith (1994).

    ``findings``: receives the results.
    """
    for end in ("left", "right"):
        printed = row_loads_by_smith_rule_lbf("taper", end, "stretch", (REDUCED / bearings.POUND,) * 2)
        ours = bearing_set_state("taper", end, "stretch", REDUCED)
        for i in range(2):
            thrust = float(ours.row_thrusts[i]) / bearings.POUND
            findings.add_number(f"{end}_stretch_{i + 1}", thrust, as_printed=printed[i])
        for load, closed in (("750", REDUCED), ("1500", bearings.PRELOAD)):
            thrusts = bearing_set_state("taper", end, "stretch", closed).row_thrusts
            for i in (1, 2):
                findings.add_number(f"t{load}_{end}_{i}", None, bearings.torque_band_words(float(thrusts[i - 1])))
            total = sum(findings.printed(f"t{load}_{end}_{i}") for i in (1, 2))
            findings.follow({f"t{load}_{end}": total})
    findings.follow({"rise_750": findings.printed("t750_left") / findings.printed("t1500_left") * 20.0})
    least = findings.printed("left_stretch_1")
    words = f"load on the carriage in the middle; {bearings.APPLIED / bearings.POUND:.0f} lbf is applied in 4.2"
    findings.add_number("unseat", carriage_load_that_unloads_row(REDUCED) / bearings.POUND, words, as_printed=2.0 * least)


def chapter_5(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in chapter 5 of Smith (1994), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    _record_axis_and_drive_data(findings)
    _compare_torque_tests(findings)
    _compare_stiffness_tests(findings)
    _compare_temperature_rises(findings)
    _compute_loads_at_reduced_preload(findings)
