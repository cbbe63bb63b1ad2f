"""Sections 3.4 and 4.3 of Lin's thesis: friction and ball-to-ball contact in a ball screw, torque of two bearings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import degrees, radians
from typing import Any, Literal

import numpy as np

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.cases.lin.kinds.screw_balls import ScrewPairScene
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind as case_of
from rollbench.lowfi.as_source.screw import simulate_by_root
from rollbench.lowfi.friction import bearing as friction_bearing
from rollbench.lowfi.friction.screw import travel
from rollbench.lowfi.friction.screw.groove import Mode
from rollbench.lowfi.friction.screw.motion import Coupling
from rollbench.lowfi.friction.screw.run import (
    SHIFTED,
    Pair,
    Run,
    ScrewPairSolution,
    ScrewRunSummary,
    load_implied_by_ball_force,
    simulate_equal_steps,
    simulate_runs_in_equal_steps,
    solve_pair_of_screw_balls,
    summarise_screw_run,
)
from rollbench.lowfi.friction.whole.circuit import ContactOnset, contact_onset
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Row

#: Deviations theta [deg] of the second ball's contact angle from nominal in Table 3.7, by case; amplitudes [deg] of theta
#: in the simulations of section 3.4.4, which the thesis does not print.
THETA = {name: degrees(source_cases.second_ball_angle_deviation(name)) for name in source_cases.PAIR_SCENES}
AMPLITUDES = tuple(source_cases.RUN_SCENES)
#: Angles [rad] of the load to the bearing's axis in section 4.3.1.
ANGLES = source_cases.four_point_and_double_row_scene().angle
#: Permitted error of the torque by the time step of a simulation, over the mean torque.
STEP_GOAL = 0.003
#: Scenes of section 4.3.2, by kind of geometric error.
SCREWS = {"pitch": "lin-pitch-4p1", "roundness": "lin-roundness-4p1", "none": "lin-nominal-4p1"}


# --- solutions, each computed once


@cache
def solve_screw_ball_pair(case: str, interpretation: Literal["plain", "inferred"]) -> ScrewPairSolution:
    """Solve loads and motions of two neighbouring balls of the screw in a case of Lin's Table 3.7.

    ``case``: "a" or "b"; ``interpretation``: "plain" for the text as printed, "inferred" for balls with the oversize that
    was inferred from the printed results. Returns the solutions with and without ball-to-ball contact.
    """
    name = source_cases.PAIR_SCENES[case] + "-inferred" * (interpretation == "inferred")
    return solve_pair_of_screw_balls(case_of(name, ScrewPairScene).pair)


@cache
def simulate_screw(amplitude: float) -> travel.TravelHistory:
    """Simulate the whole screw of Lin's section 3.4.4 over time, with a time-step error below 0.3 % of the mean torque.

    ``amplitude``: amplitude of theta, the deviation of the contact angles from nominal, 2 or 3 [deg]. Returns motions and
    torques at each time step.
    """
    return simulate_screw_with_step_errors(amplitude)[0]


@cache
def simulate_screw_with_step_errors(amplitude: float) -> tuple[travel.TravelHistory, travel.TimeStepErrors | None]:
    """Simulate the whole screw of Lin's section 3.4.4, with a time-step error below 0.3 %, and estimate this error.

    The permitted error, divided by the mean torque, is `STEP_GOAL`. ``amplitude``: amplitude of theta, the deviation of the
    contact angles from nominal, 2 or 3 [deg]. Returns the history of motions and torques, then the error by the time step
    over the mean torque, None if it is unknown.
    """
    run = source_cases.simulation_with_angle_deviation(amplitude)
    return travel.simulate_with_step_errors(run, run.duration, None, STEP_GOAL)


@cache
def simulate_screw_in_200_steps(amplitude: float) -> travel.TravelHistory:
    """Simulate the whole screw of section 3.4.4 of Lin's thesis in 200 equal time steps, as Lin does.

    During a step, loads and motions keep their values at the start of the step. ``amplitude``: amplitude of theta, the
    deviation of the contact angles from nominal, 2 or 3 [deg]. Returns motions and torques at each time step.
    """
    return simulate_equal_steps(source_cases.simulation_with_angle_deviation(amplitude))


@cache
def simulate_screw_without_oversize() -> travel.TravelHistory:
    """Simulate the whole screw of section 3.4.4 of Lin's thesis over time, with balls that are not oversized.

    Friction moves balls and screw and so changes the contact loads. The deviation theta of the contact angles has an
    amplitude of 3 deg. Returns motions and torques at each time step.
    """
    run = source_cases.simulation_with_angle_deviation(3.0)
    return simulate_equal_steps(replace(run, oversize=0.0, coupling="ball and screw"))


@cache
def torque_over_load_angle(bearing: str, free_to_tilt: bool) -> friction_bearing.BearingStates:
    """Compute the friction torque of a bearing of Lin's Table 4.2 over the angle between the load and the bearing's axis.

    ``bearing``: "4P" for the four-point, "DR" for the double-row bearing; ``free_to_tilt``: whether the inner ring is free
    to tilt. The load angles are `ANGLES`.
    """
    make = source_cases.four_point_bearing if bearing == "4P" else source_cases.double_row_bearing
    return friction_bearing.solve_bearing(make(tilt=free_to_tilt), ANGLES)


def largest_over_smallest_torque(found: friction_bearing.BearingStates, largest_angle: float) -> float:
    """Return the ratio of largest to smallest friction torque of a bearing for load angles of 0 to ``largest_angle`` [deg].

    ``found``: friction torque of the bearing over the angle between its load and its axis.
    """
    torque = found.torque[found.angle <= radians(largest_angle) * (1.0 + 1e-12)]
    return float(torque.max() / torque.min())


def loss_increase_percent(pair: ScrewPairSolution) -> float:
    """Return by how much ball-to-ball contact increases the friction loss of two balls, summed over all contacts [%].

    ``pair``: solutions for the two balls with ball-to-ball contact and without it.
    """
    return float(error_percent(pair.touching.motion.loss, pair.apart.motion.loss))


def compute_ball_contact_onset(
    cache: SceneResultCache, kind_of_error: str, unloaded_ball_speed_ratio: float
) -> ContactOnset:
    """Compute the nut angle at which neighbouring balls first touch in the screw of Lin's Table 4.1.

    ``cache``: gives the solved scenes; ``kind_of_error``: geometric error of the screw's grooves, "pitch", "roundness" or
    "none"; ``unloaded_ball_speed_ratio``: velocity of balls without load, divided by the nominal ball velocity.
    """
    name = SCREWS[kind_of_error]
    return contact_onset(cache.built_in_scene(name), cache.solve_once(name), unloaded_speed_ratio=unloaded_ball_speed_ratio)


# --- computed values for printed numbers


def given_3_6(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Record the inputs of the ball screw in Table 3.6 of Lin's thesis, as the scenes contain them.

    ``findings``: receives the value to compare with each number of the table, in the table's unit. ``cache``: not used
    here.
    """
    g = source_cases.screw_groove()
    findings.numbers(source_cases.groove_inputs(g))
    values = {
        "lead": 1e3 * g.lead,
        "omega_N": g.speed / np.pi,
        "force": source_cases.pair_as_printed(0.0).force[0],
        "theta_1": degrees(source_cases.pair_as_printed().theta[0]),
        "theta_2_a": THETA["a"],
        "theta_2_b": THETA["b"],
    }
    findings.numbers(values)
    _record_youngs_modulus(findings, g.young)


def _record_youngs_modulus(findings: ComputedEntryValues, young: float) -> None:
    """Record Young's modulus ``young`` [Pa] in ``findings``, shown in the misprinted unit of Lin's thesis."""
    findings.add_number("E", 1e-6 * young, f"taken as {1e-9 * young:g} kN/mm²; shown in the unit printed")


def table_3_7(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute ball-to-ball forces and loss increases of two balls of the screw: Table 3.7 of Lin's thesis.

    A loss increase is the rise of the balls' friction loss by ball-to-ball contact.
    ``findings``: receives the computed value to compare with each number of the table; ``cache``: gives stored results of
    the 3D rolling model.
    """
    for case in THETA:
        solid = source_cases.stored_3d_results(cache, source_cases.PAIR_SCENES[case])
        _compute_force_and_increase(findings, case, solid)
        force, ansys = (printed_value("lin-3.7", f"{what}_{case}") for what in ("force", "ansys"))
        findings.follow({f"difference_{case}": float(error_percent(force, ansys))})
        _compare_force_with_ansys(findings, cache, case)
        findings.add_remark(f"time_{case}", "another machine and language")
        findings.add_remark(f"time_ansys_{case}", "another machine and program")
    printed = [printed_value("lin-3.7", f"difference_{case}") for case in THETA]
    largest = max(printed_value("lin-3.5", "error_numerical"), *printed)
    findings.add_number("within", None, "the largest of the printed differences", follows=largest)


def _compute_force_and_increase(findings: ComputedEntryValues, case: str, results_in_3d: Mapping[str, float]) -> None:
    """Compute ball-to-ball force and loss increase in a case of Lin's Table 3.7, and record them in ``findings``.

    The loss increase is the rise of the balls' friction loss by ball-to-ball contact.
    ``case``: "a" or "b"; ``results_in_3d``: results of the 3D rolling model by name with unit, such as "force 1-2 N".
    """
    force, percent = (printed_value("lin-3.7", f"{what}_{case}") for what in ("force", "increase"))
    as_text, oversized = solve_screw_ball_pair(case, "plain"), solve_screw_ball_pair(case, "inferred")
    implied = load_implied_by_ball_force(source_cases.oversized_pair(radians(THETA[case])), force, 1e-2 * percent)
    off = [float(error_percent(r.force, force)) for r in (as_text, oversized)]
    findings.add_number(
        f"force_{case}",
        as_text.force,
        f"{_both_values_in_words(as_text.force, oversized.force)}; the text as printed does not give it ({off[0]:+.0f} %): "
        f"printed force and increase imply {implied:.0f} N of contact load a ball, plainly read it is "
        f"{as_text.ball_loads.mean():.0f} N, the inferred one {oversized.ball_loads.mean():.0f} N ({off[1]:+.1f} %)",
        reading=oversized.force,
        reference=results_in_3d.get("force 1-2 N"),
    )
    values = loss_increase_percent(as_text), loss_increase_percent(oversized)
    off = [float(error_percent(value, percent)) for value in values]
    words = f"{_both_values_in_words(*values)}; {off[0]:+.0f} % and {off[1]:+.1f} % off the printed increase"
    findings.add_number(f"increase_{case}", values[0], words, reading=values[1], reference=results_in_3d.get("increase %"))


def _compare_force_with_ansys(findings: ComputedEntryValues, cache: SceneResultCache, case: str) -> None:
    """Record the ball-to-ball force by the 3D rolling model in ``findings``, as the counterpart of Lin's ANSYS force.

    The remark states the force for both interpretations of the contact loads: the text as printed, and balls with the
    inferred oversize. ``cache``: gives the stored 3D results; ``case``: case of Lin's Table 3.7, "a" or "b".
    """
    scenes = source_cases.PAIR_SCENES[case], f"{source_cases.PAIR_SCENES[case]}-inferred"
    as_text, oversized = (source_cases.stored_3d_results(cache, scene).get("force 1-2 N") for scene in scenes)
    words = "no stored run" if as_text is None or oversized is None else _both_values_in_words(as_text, oversized)
    findings.add_number(f"ansys_{case}", None, f"3D rolling of elastic half spaces: {words}", reference=as_text)


def _both_values_in_words(as_text: float, with_oversize: float) -> str:
    """Return in words a value by two interpretations: of the text as printed, and of balls with the inferred oversize."""
    return f"text as printed {as_text:.4g}, inferred oversize {with_oversize:.4g}"


def groove_torque_variation(history: travel.TravelHistory) -> float:
    """Return (largest - smallest)/mean of the ball-to-groove friction torque during a simulation of the whole screw.

    The first time step is left out. ``history``: motions and torques at each time step.
    """
    torque = history.groove_torque[1:]
    return float(np.ptp(torque) / torque.mean())


def ball_contact_ends_and_begins_again(history: travel.TravelHistory) -> bool:
    """Return whether ball-to-ball contact begins, ends and begins again during a simulation of the whole screw.

    ``history``: motions, torques and touching balls at each time step.
    """
    touch = np.asarray(np.any(history.presses_on_next, axis=1), dtype=bool).reshape(-1)
    changes = touch[np.flatnonzero(np.diff(touch.astype(int)))[:3] + 1]
    return not bool(touch[0]) and changes.tolist() == [True, False, True]


def time_steps_in_words(amplitude: float) -> str:
    """Return in words the number of time steps of a simulation, its time-step error, and a result with Lin's 200 steps.

    The result is the largest friction torque by ball-to-ball contacts, divided by the torque by ball-to-groove contacts
    [%]. ``amplitude``: amplitude of theta, the deviation of the contact angles from nominal, 2 or 3 [deg].
    """
    (found, error), base = simulate_screw_with_step_errors(amplitude), simulate_screw_in_200_steps(amplitude)
    size = "unknown" if error is None else f"{100.0 * error.largest_error:.2g} %"
    few = 100.0 * summarise_screw_run(base).largest_ball_to_groove_ratio
    return f"in {found.steps} steps, whose error is {size} of the mean torque; Lin's {base.steps} steps give {few:.1f} %"


def section_3_4_4(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed on the simulation of the whole screw in Lin's section 3.4.4, and check the claims.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    base = source_cases.simulation_inputs()
    findings.numbers({"balls": base.count, "turns": base.turns, "force": base.force[0]})
    findings.numbers({"duration": base.duration, "steps": base.steps, "occupation": 100.0 * base.track_occupation})
    _compute_ball_contact_torque(findings)
    _check_simulation_claims(findings)


def _compute_ball_contact_torque(findings: ComputedEntryValues) -> None:
    """Compute the largest torque by ball-to-ball contact, and the nut angles at which it occurs and at which contact ends.

    The values are recorded in ``findings``: the torque by ball-to-ball contacts divided by the torque by ball-to-groove
    contacts [%], and the angles in degrees.
    """
    low, high = (summarise_screw_run(simulate_screw(a)) for a in AMPLITUDES)
    assumed = f"assumed: theta of 3 deg (with 2 deg {{}}), balls {1e6 * source_cases.inferred_oversize():g} µm oversize"
    words = (
        f"{assumed.format(f'{100.0 * low.largest_ball_to_groove_ratio:.1f} %')}: the printed number lies between; "
        f"{time_steps_in_words(3.0)}"
    )
    near = {key: f"; {nearest_in_words(key)}" for key in PRINTED_OF_RUN}
    findings.add_number("largest", 100.0 * high.largest_ball_to_groove_ratio, words + near["largest"])
    for key, angle in (("largest_at", "nut_angle_of_largest_ratio"), ("none_at", "nut_angle_without_contact")):
        findings.add_number(key, getattr(high, angle), assumed.format(f"{getattr(low, angle):.0f}°") + near[key])


def _check_simulation_claims(findings: ComputedEntryValues) -> None:
    """Check Lin's claims on the simulation of the whole screw, and record in ``findings`` whether they hold.

    The claims are on groups of touching balls, steady torque of the ball-to-groove contacts, and ball-to-ball contact
    that ends and begins again.
    """
    low, high = (summarise_screw_run(simulate_screw(a)) for a in AMPLITUDES)
    words = f"{low.most_touching_groups} groups with 2 deg, {high.most_touching_groups} with 3 deg"
    findings.add_claim("groups", low.most_touching_groups == high.most_touching_groups == 4, words)
    vary = [low.groove_variation, high.groove_variation]
    loose = simulate_screw_without_oversize()
    words = (
        f"largest less smallest over mean: {vary[0]:.1%} with 2 deg, {vary[1]:.1%} with 3 deg; without oversize, loads "
        f"coupled to friction, {groove_torque_variation(loose):.1%} from the second step on and "
        f"{summarise_screw_run(loose).groove_variation:.0%} with the first, whose loads are computed without friction: "
        "mostly the start, not third contacts that come and go"
    )
    findings.add_claim("groove_steady", max(vary) < 0.03, words)
    again = [ball_contact_ends_and_begins_again(simulate_screw(a)) for a in AMPLITUDES]
    findings.add_claim("none_then_again", all(again), "with 2 and with 3 deg")


def table_4_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Record the inputs of the four-point and the double-row bearing in Table 4.2 of Lin's thesis.

    ``findings``: receives the value to compare with each number of the table, in the table's unit. ``cache``: not used
    here.
    """
    four, double = source_cases.four_point_bearing(tilt=False), source_cases.double_row_bearing(tilt=False)
    g = four.groove
    values = {
        "pitch_diameter": 2e3 * g.pitch_radius,
        "beta": degrees(g.contact_angle),
        "nu": g.poisson,
        "force": four.force,
        "speed": g.screw_speed / (2.0 * np.pi),
    }
    for key, case in (("4p", four), ("dr", double)):
        values |= {f"ball_{key}": 1e3 * case.groove.ball_radius, f"groove_{key}": 1e3 * case.groove.groove_radius}
        values[f"balls_{key}"] = case.count
    findings.numbers(values)
    _record_youngs_modulus(findings, g.young)
    apart = 2e3 * (double.rows[1].place - double.rows[0].place)
    findings.add_number("thickness_dr", float(apart), "only twice the distance of the rows, an assumption")
    for key in ("outer_diameter", "inner_diameter", "thickness_4p"):
        findings.add_remark(key, "enters no model here: nothing to compare")


def section_4_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Recompute the bearing torques of Lin's section 4.3, and check the claims on torque and ball-to-ball contact.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds;
    ``cache``: gives the solved scenes.
    """
    _compute_bearing_torques(findings)
    onset = {(e, i): compute_ball_contact_onset(cache, e, i) for e in ("pitch", "roundness") for i in (0.0, 0.9)}
    first = {key: degrees(o.rotation_to_first_meeting) for key, o in onset.items()}
    lost = {e: int((onset[e, 0.0].contact_load_sums == 0.0).sum()) for e in ("pitch", "roundness")}
    words = (
        f"first meeting within {first['roundness', 0.0]:.1f} deg of the nut if lost balls stand, "
        f"{first['roundness', 0.9]:.0f} deg at 0.9 of the nominal velocity; with pitch error "
        f"{first['pitch', 0.0]:.0f} deg; {lost['roundness']} balls lost against {lost['pitch']}"
    )
    findings.add_claim("roundness_quicker", all(first["roundness", i] < first["pitch", i] for i in (0.0, 0.9)), words)


def _compute_bearing_torques(findings: ComputedEntryValues) -> None:
    """Compute the torque ratios of the four-point and the double-row bearing: section 4.3.1 of Lin's thesis.

    Each ratio is the largest friction torque for load angles up to 18 deg divided by the smallest. ``findings``: receives
    the ratios.
    """
    four, double = torque_over_load_angle("4P", True), torque_over_load_angle("DR", True)
    found = four, double, torque_over_load_angle("DR", False)
    ratios = [largest_over_smallest_torque(one, 18.0) for one in found]
    at_18 = int(four.balls_beyond_two_contacts[np.searchsorted(four.angle, radians(18.0) * (1.0 - 1e-12))])
    still = largest_over_smallest_torque(torque_over_load_angle("4P", False), 18.0)
    words = f"load angles of 0 to 18 deg, inner ring free to tilt; {still:.2f} where it cannot tilt"
    findings.add_number("ratio_4p", ratios[0], words)
    findings.add_claim("four_worse", ratios[0] > 3.0 * max(ratios[1:]), f"{ratios[0]:.2f} against {ratios[1]:.2f}")
    words = f"never more than two contacts a ball; ratio {ratios[1]:.2f} with tilt, {ratios[2]:.2f} without"
    findings.add_claim("dr_consistent", bool(np.all(double.balls_beyond_two_contacts == 0)) and ratios[1] < 1.28, words)
    words = (
        f"{int(four.balls_beyond_two_contacts[0])} balls beyond two contacts at 0 deg, "
        f"{at_18} of {source_cases.four_point_bearing().count} at 18 deg"
    )
    findings.add_claim("transition", bool(four.balls_beyond_two_contacts[0] == 0 and at_18 > 0), words)


#: Largest load angles [deg] of the ranges over which the torques of section 4.3.1 are compared (largest over smallest).
ENDS = (10.0, 18.0, 30.0)
#: Steps and duration [s] of the simulations in the sensitivity table: one turn of the nut, 7.2 degrees per step.
SHORT = {"steps": 50, "duration": 1.0}
#: Velocities of unloaded balls over the nominal velocity.
IDLE = (0.0, 0.5, 0.9, 1.0)
#: Labels of rows of the table of two balls, which the introduction of the report quotes.
AS_TEXT, UNCOUPLED = "text as it stands, friction moves the balls", "loads not coupled to friction"
AS_CASE, SOURCE_RULE = "as the case study", "Lin's rule by which neighbouring balls touch"
#: Oversizes [m] of the ball radius and axial loads [N] over which force and loss of two balls are computed.
OVERSIZE, AXIAL = tuple(np.linspace(-1e-6, 3e-6, 17)), (25.0, 50.0, 100.0, 200.0)


def oversize_in_words() -> str:
    """Return the inferred oversize of the ball radius with its unit as text, such as "1.7 µm".

    It is inferred from ball-to-ball force and friction loss in Lin's Table 3.7.
    """
    return f"{1e6 * source_cases.inferred_oversize():g} µm"


def label_of_inferred_oversize() -> str:
    """Return the label of the table row for balls with the inferred oversize and without influence of friction on loads."""
    return f"{oversize_in_words()} oversize, not coupled"


def contact_load_interpretations() -> list[tuple[str, str, Callable[[float], Pair]]]:
    """Return the interpretations of the contact loads of two balls that Lin's Table 3.7 leaves open.

    Each item of the list: short name, such as "plain"; assumptions in words; function that returns the ball pair for a
    deviation theta [rad] of the second ball's contact angle from nominal.
    """

    def changed(make_pair: Callable[[float], Pair], changes: dict[str, Any]) -> Callable[[float], Pair]:
        """Return a function of theta [rad] that makes a ball pair by ``make_pair``, with the pair's fields ``changes``."""
        return lambda theta: replace(make_pair(theta), **changes)

    oversize, size = source_cases.inferred_oversize(), oversize_in_words()
    both, one = "friction moves balls and screw", (1.0, 0.0, 0.0, 0.0)
    plain: dict[str, dict[str, Any]] = {
        UNCOUPLED: {"coupling": "none"},
        both: {"coupling": "ball and screw"},
        "50 N radially on each ball, not coupled": {"free": "r", "force": (100.0,), "coupling": "none"},
    }
    inferred: dict[str, dict[str, Any]] = {
        f"{size}, friction moves the balls": {"coupling": "ball"},
        f"{size}, {both}": {"coupling": "ball and screw"},
        "half the oversize": {"oversize": 0.5 * oversize},
        "one and a half times the oversize": {"oversize": 1.5 * oversize},
        f"{size}, 25 N instead of 50 N": {"force": (25.0,)},
        f"{size}, 100 N instead of 50 N": {"force": (100.0,)},
        f"{size}, theta on one contact of the screw": {"pattern": (one, one)},
        f"{size}, screw's groove shifted sideways": {"pattern": (SHIFTED, SHIFTED)},
        f"{size}, Hertz constants of Table B.1": {"groove": source_cases.screw_groove(hertz="as printed")},
    }
    as_printed, oversized = source_cases.pair_as_printed, source_cases.oversized_pair
    return [
        ("plain", AS_TEXT, as_printed),
        *(("plain, varied", words, changed(as_printed, changes)) for words, changes in plain.items()),
        ("inferred", label_of_inferred_oversize(), oversized),
        *(("inferred, varied", words, changed(oversized, changes)) for words, changes in inferred.items()),
    ]


def contact_load_interpretation_rows() -> Iterator[Row]:
    """Yield table rows for Lin's Table 3.7, one for each interpretation of the contact loads of the two balls.

    Columns for each case (a) and (b): ball-to-ball force [N], its error against the printed force [%], increase of the
    friction loss [%], contact load of a ball [N].
    """
    for kind, label, make in contact_load_interpretations():
        row: Row = {"interpretation": kind, "load_assumption": label}
        good = True
        for case, theta in THETA.items():
            r = solve_pair_of_screw_balls(make(radians(theta)))
            off = float(error_percent(r.force, printed_value("lin-3.7", f"force_{case}")))
            increase, load = loss_increase_percent(r), float(r.ball_loads.mean())
            row |= {
                ("ball_force_at", f"{theta:g}"): r.force,
                ("ball_force_error_at", f"{theta:g}"): off,
                ("loss_increase_at", f"{theta:g}"): increase,
                ("ball_load_at", f"{theta:g}"): load,
            }
            good = good and r.converged
        yield row | {"status": "converged" if good else "not converged"}


def contact_load_implied_by_table_3_7() -> float:
    """Return the contact load [N] of a ball implied by the printed force and loss increase of case (a), Lin's Table 3.7."""
    force, increase = (printed_value("lin-3.7", f"{what}_a") for what in ("force", "increase"))
    return load_implied_by_ball_force(source_cases.oversized_pair(radians(THETA["a"])), force, 1e-2 * increase)


@cache
def pair_results_over_oversize(case: str, coupling: Coupling) -> tuple[Array, Array]:
    """Compute ball-to-ball force and loss increase of two balls of the screw over the balls' oversize and the axial load.

    The loss increase is the rise of the balls' friction loss by ball-to-ball contact, as a fraction. Both arrays are
    ``(m, n)``, for the oversizes `OVERSIZE` [m] and the axial loads `AXIAL` [N]; nan without convergence. ``case``: case of
    Lin's Table 3.7, "a" or "b"; ``coupling``: which parts the friction displaces, so that it changes the contact loads:
    "none", "ball" or "ball and screw".
    """
    pair = replace(source_cases.oversized_pair(radians(THETA[case])), coupling=coupling)
    solved = [[solve_pair_of_screw_balls(replace(pair, oversize=o, force=(f,))) for f in AXIAL] for o in OVERSIZE]
    values = [[(r.force, r.friction_increase) if r.converged else (np.nan, np.nan) for r in row] for row in solved]
    force, increase = np.moveaxis(np.array(values), -1, 0)
    return force, increase


def simulation_input_variations() -> list[tuple[str, str, dict[str, object]]]:
    """Return the variations of inputs of the whole-screw simulation, one input changed at a time.

    Each entry: name of the input, label of its new value, and the changed fields of `Run` by name.
    """
    changes: list[tuple[str, str, dict[str, object]]] = [("theta", "3°, 7.2° of the nut a step", {})]
    changes += [("theta", f"{a:g}°", {"amplitude": radians(a)}) for a in (1.0, 2.0, 2.5, 4.0)]
    changes += [("axial force", f"{f:g} N", {"force": (f,)}) for f in (500.0, 3000.0)]
    changes += [("oversize", f"{o:g} µm", {"oversize": 1e-6 * o}) for o in (0.0, 1.0, 2.5)]
    changes += [
        ("oversize and coupling", "0 µm, friction moves balls and screw", {"oversize": 0.0, "coupling": "ball and screw"}),
        ("coupling", f"{oversize_in_words()}, friction moves balls and screw", {"coupling": "ball and screw"}),
        ("phase of theta", "90°", {"phase": 0.5 * np.pi}),
        ("phase of theta", "180°", {"phase": np.pi}),
        ("pattern", "groove shifted sideways", {"pattern": SHIFTED}),
        ("first ball", "an eighth of a distance back", {"first": 0.375}),
        ("return tube", "one ball long", {"tube": source_cases.screw_groove().pair.spacing}),
        ("time step", "3.6° of the nut", {"steps": 100}),
    ]
    return changes


#: Interpretations of inputs that 3.4.4 leaves open: the part that theta moves with (the azimuth of Figure 3.23 counts from
#: it), amplitude of theta [deg], oversize [um] and pattern. They are chosen to meet the printed numbers, so confirm none.
Interpretation = tuple[str, float, float, str]
TRIED: tuple[Interpretation, ...] = (
    ("screw", 2.6, 1.7, "both"),
    ("screw", 3.0, 1.7, "both"),
    ("nut", 1.5, 1.7, "both"),
    ("nut", 2.0, 1.7, "both"),
    ("nut", 2.25, 1.7, "both"),
    ("nut", 3.0, 1.7, "both"),
    ("nut", 2.25, 2.5, "both"),
    ("screw", 3.0, 1.7, "one"),
)
#: Part that theta moves with and amplitude of theta [deg], for the simulations with Lin's rule by which neighbouring balls
#: touch.
BY_SOURCE = (("screw", 3.0), ("nut", 2.5))


def inputs_of_interpretation(part_of_theta: str, amplitude: float, oversize: float, pattern: str) -> Run:
    """Return inputs of the whole-screw simulation of Lin's section 3.4.4, with assumptions where his text leaves them open.

    ``part_of_theta``: "screw" or "nut", with which the pattern of theta, the deviation of the contact angles from nominal,
    rotates; ``amplitude``: amplitude of theta [deg]; ``oversize``: oversize of the ball radius [um]; ``pattern``: whether
    theta acts on "one" or "both" of a ball's contacts with the screw.
    """
    flanks = (1.0, 0.0, 0.0, 0.0) if pattern == "one" else source_cases.simulation_inputs().pattern
    return source_cases.simulation_inputs(
        follows=part_of_theta, amplitude=radians(amplitude), oversize=1e-6 * oversize, pattern=flanks
    )


@cache
def interpretation_results() -> tuple[ScrewRunSummary, ...]:
    """Simulate the whole screw of Lin's section 3.4.4 for each interpretation of its unprinted inputs, listed in `TRIED`.

    Each simulation has 200 equal time steps. Returns a summary of each simulation, with the largest ball-to-ball torque and
    the nut angles at which it occurs and at which contact ends.
    """
    runs = simulate_runs_in_equal_steps([inputs_of_interpretation(*reading) for reading in TRIED])
    return tuple(map(summarise_screw_run, runs))


PRINTED_OF_RUN = ("largest", "largest_at", "none_at")


def _printed_results_of_run(s: ScrewRunSummary) -> tuple[float, float, float]:
    """Return the three results of a whole-screw simulation that Lin prints, in the order of `PRINTED_OF_RUN`.

    First: largest ratio of ball-to-ball to ball-to-groove torque [%]; second: nut angle [deg] at which it occurs; third:
    nut angle [deg] from which no balls touch.
    """
    return 100.0 * s.largest_ball_to_groove_ratio, s.nut_angle_of_largest_ratio, s.nut_angle_without_contact


def nearest_in_words(key: str) -> str:
    """Return in words the interpretation of Lin's text whose simulation comes closest to a printed number, with results.

    ``key``: key of the printed number in section 3.4.4 of Lin's thesis, one of `PRINTED_OF_RUN`.
    """
    results = interpretation_results()
    found = np.array([_printed_results_of_run(s)[PRINTED_OF_RUN.index(key)] for s in results])
    k = int(np.nanargmin(np.abs(found - printed_value("lin-3.4.4", key))))
    (follows, amplitude, oversize, pattern), (largest, at, none_at) = TRIED[k], _printed_results_of_run(results[k])
    text = f"theta of {amplitude:g} deg on {pattern} of the screw's contacts, with the {follows}, {oversize:g} um oversize"
    numbers = f"{largest:.1f} % at {at:.0f}°, no contact from {none_at:.0f}°"
    return f"nearest of {len(TRIED)} interpretations: {text}: {numbers} (table friction-run-readings)"


def simulation_interpretation_rows() -> Iterator[Row]:
    """Yield table rows of the whole-screw simulation, one for each interpretation of section 3.4.4 of Lin's thesis.

    Columns: rule that decides which neighbouring balls touch, interpretation, the three results that Lin prints, and the
    differences from the printed values. The last rows are computed with Lin's rule for contact between balls.
    """
    found: list[tuple[str, Interpretation, Sequence[Any]]] = [
        ("neighbours never overlap", reading, _printed_results_of_run(s))
        for reading, s in zip(TRIED, interpretation_results(), strict=True)
    ]
    for follows, amplitude in BY_SOURCE:
        reading = follows, amplitude, 1e6 * source_cases.inferred_oversize(), "both"
        of_source = simulation_row_by_lin_method(inputs_of_interpretation(*reading))
        found.append((SOURCE_RULE, reading, [of_source[q] for q in RUN[2:5]]))
    off = [f"{name}_off" for name in RUN[2:5]]
    printed = [printed_value("lin-3.4.4", key) for key in PRINTED_OF_RUN]
    for rule, reading, values in found:
        known = [None if v is None or not np.isfinite(v) else float(v) for v in values]
        missed = [None if v is None else v - p for v, p in zip(known, printed, strict=True)]
        yield dict(zip((*READING, *RUN[2:5], *off), (rule, *map(str, reading), *known, *missed), strict=True))


#: Columns on the interpretation of Lin's text in a simulation of the whole screw.
READING = ("touching_rule", "theta_body", "theta_amplitude", "ball_oversize", "theta_contacts")

#: Columns of the results of one whole-screw simulation.
RUN = (
    "varied_assumption",
    "assumed_value",
    "torque_ratio",
    "angle_of_largest_ratio",
    "angle_without_contact",
    "touching_groups",
    "torque_variation",
    "mean_torque",
    "time_steps_converged",
)


def simulation_result_row(label: str, assumed_value: str, history: travel.TravelHistory) -> Row:
    """Return the table row, with columns `RUN`, of the results of one simulation of the whole screw.

    ``label``: name of the assumption that is varied; ``assumed_value``: the assumption in words; ``history``: motions and
    torques at each time step.
    """
    s: ScrewRunSummary = summarise_screw_run(history)
    largest, at, none_at = _printed_results_of_run(s)
    known = (at, none_at if np.isfinite(none_at) else None) if largest > 0.0 else (None, None)
    steps = f"{int(history.converged.sum())} of {history.converged.size}"
    first = label, assumed_value, largest, *known, s.most_touching_groups
    return _row_with_groove_torque(first, history.groove_torque, steps)


def _row_with_groove_torque(first_cells: Sequence[Any], groove_torque: Array, steps: str) -> Row:
    """Return a table row with columns `RUN`: its first cells, variation and mean of the groove torque, and ``steps``.

    ``groove_torque``: of the ball-to-groove contacts at each time step [N m]; the first step does not count.
    """
    torque = groove_torque[1:]
    values = *first_cells, 100.0 * float(np.ptp(torque) / torque.mean()), 1e3 * float(torque.mean()), steps
    return dict(zip(RUN, values, strict=True))


def simulation_row_by_lin_method(run: Run) -> Row:
    """Return the table row, with columns `RUN`, of the results of a whole-screw simulation by Lin's method.

    By this method, the motions that the balls would have without ball-to-ball contact decide which balls touch. ``run``:
    inputs of the simulation.
    """
    r = simulate_by_root(run)
    ratio, touching = r.ball_torque / r.groove_torque, r.ball_force > 0.0
    top, angle = int(np.argmax(ratio)), np.degrees(r.nut_angle)
    later = np.flatnonzero(~touching.any(axis=1) & (np.arange(angle.size) > top))
    none_at = float(angle[later[0]]) if later.size else None
    overlap = 100.0 * r.largest_overlap / run.groove.pair.spacing
    value = (
        f"as the case study, 3°; balls overlap in {r.overlapping_step_count} steps, by up to {overlap:.1f} % of their size"
    )
    steps = f"{len(r.status) - r.failed_step_count} of {len(r.status)}"
    first = SOURCE_RULE, value, 100.0 * float(ratio[top]), float(angle[top]), none_at
    return _row_with_groove_torque((*first, int(np.max(travel.count_touching_groups(touching)))), r.groove_torque, steps)


def simulation_sensitivity_rows() -> list[Row]:
    """Return table rows of the whole-screw simulation of Lin's section 3.4.4 under varied assumptions.

    The columns are `RUN`. The first rows are the case study with each amplitude of theta in `AMPLITUDES`. The next row
    uses Lin's rule for contact between balls, and each further row one of `simulation_input_variations`.
    """
    rows = []
    for a in AMPLITUDES:
        history = simulate_screw(a)
        words = f"theta of {a:g}°, {oversize_in_words()}, {history.steps} steps"
        rows.append(simulation_result_row(AS_CASE, words, history))
    rows.append(simulation_row_by_lin_method(source_cases.simulation_inputs()))
    names, values, changes = zip(*simulation_input_variations(), strict=True)
    runs = simulate_runs_in_equal_steps([source_cases.simulation_inputs(**(SHORT | new)) for new in changes])
    return rows + list(map(simulation_result_row, names, values, runs))


def bearings_under_varied_assumptions() -> list[tuple[str, str, friction_bearing.BearingCase]]:
    """Return the bearings of section 4.3.1 of Lin's thesis under varied assumptions.

    Each entry: kind of bearing ("four-point" or "double row"); assumption in words; inputs of the friction model.
    """
    tilting, held = source_cases.four_point_bearing(tilt=True), source_cases.four_point_bearing(tilt=False)
    diagonal, other = friction_bearing.DIAGONAL, friction_bearing.OTHER
    face = friction_bearing.BallRow(-6e-3, diagonal), friction_bearing.BallRow(6e-3, other)
    faulty: Mode = "as printed"
    four = {
        "tilt free, no clearance": tilting,
        "tilt held": held,
        **{f"ball {100 * p:.0f} % of a distance off the load's plane": replace(tilting, phase=p) for p in (0.25, 0.5)},
        **{f"clearance {1e6 * c:g} µm": replace(tilting, clearance=c) for c in (-1e-6, 2e-6, 5e-6)},
        "Hertz constants as Table B.1": replace(tilting, groove=replace(tilting.groove, hertz=faulty)),
        "force 2 mm off the middle": replace(tilting, arm=2e-3),
    }
    double = {
        "tilt free, back to back": source_cases.double_row_bearing(tilt=True),
        "tilt held": source_cases.double_row_bearing(tilt=False),
        "tilt free, face to face": source_cases.double_row_bearing(tilt=True, rows=face),
    }
    kinds = {"four-point": four, "double row": double}
    return [(kind, words, case) for kind, cases in kinds.items() for words, case in cases.items()]


def bearing_torque_rows() -> Iterator[Row]:
    """Yield table rows of the friction torque of the bearings of Lin's section 4.3.1, one for each assumption.

    Columns: friction torque [N mm] at a load angle of 0 deg; then, for each angle of `ENDS`, the largest torque up to this
    load angle divided by the smallest.
    """
    for bearing, label, case in bearings_under_varied_assumptions():
        found = friction_bearing.solve_bearing(case, ANGLES)
        row: Row = {"bearing": bearing, "varied_assumption": label, "torque_at_0_deg": 1e3 * float(found.torque[0])}
        for end in ENDS:
            row["torque_ratio_to", f"{end:g}"] = largest_over_smallest_torque(found, end)
        upto = found.angle <= radians(18.0) * (1.0 + 1e-12)
        status = "converged" if found.converged.all() else "not converged"
        most = int(found.balls_beyond_two_contacts[upto].max())
        yield row | {"balls_with_third_contact": most, "status": status}


def ball_contact_onset_rows(cache: SceneResultCache) -> Iterator[Row]:
    """Yield table rows of the nut angle at which neighbouring balls first touch: section 4.3.2 of Lin's thesis.

    There is one row for each kind of geometric error and each velocity of unloaded balls. ``cache``: gives the solved
    scenes.
    """
    for errors in SCREWS:
        for idle in IDLE:
            o = compute_ball_contact_onset(cache, errors, idle)
            lost, approach = int((o.contact_load_sums == 0.0).sum()), np.isfinite(o.rotation_to_meeting)
            meet, first = f"{int(approach.sum())} of {approach.size}", degrees(o.rotation_to_first_meeting)
            yield {
                "error_kind": errors,
                "idle_speed": idle,
                "unloaded_balls": lost,
                "approaching_pairs": meet,
                "angle_of_first_touch": first if np.isfinite(first) else None,
                "status": "converged" if o.converged else "not converged",
            }
