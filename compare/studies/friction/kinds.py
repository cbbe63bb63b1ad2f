"""Friction of single parts: two balls of a screw, a screw over time, one ball of a bearing, two bearings.

Linear bearings are in ``linear_kinds``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import degrees
from typing import Any

import numpy as np

from rollbench.compare.quantities import json_number
from rollbench.compare.results.data import FrictionBall
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.scenes.friction_kinds.bearings import BearingBallScene, BearingPairScene
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.compare.studies.friction import answer
from rollbench.compare.studies.friction import run as friction_run
from rollbench.compare.studies.friction.answer import FrictionAnswer, from_fields
from rollbench.compare.studies.friction.linear_kinds import solve_friction_of_linear_bearing
from rollbench.compare.text.printing import Column, format_cell
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.contact import equilibrium
from rollbench.lowfi.friction.contact.equilibrium import BodyMotion as BallMotion
from rollbench.lowfi.friction.contact.laws import EllipticalContacts, RegularisedCoulombLaw
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import lin_sigmoid_law
from rollbench.lowfi.friction.screw.run import ScrewPairSolution, solve_pair_of_screw_balls, summarise_screw_run
from rollbench.lowfi.friction.screw.travel import TravelHistory
from rollbench.lowfi.statics.validity import contact_size_warnings
from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES, Motion

#: Largest overlap of neighbouring balls along the track that counts as round-off [rad].
TOUCHING = 1e-9


def full_sliding_loss(groove: ScrewGroove, force: Array) -> float:
    """Return the friction loss [W] of a screw if all contacts slid at the groove's speed.

    ``groove``: groove with its coefficient of friction, speed and radius; ``force``: contact loads [N], of any shape. A
    computed loss that is tiny compared with this one is round-off; for a groove at rest the value is infinite, because any
    computed loss is round-off then.
    """
    if groove.speed == 0.0:
        return np.inf
    return groove.mu * float(force.sum()) * abs(groove.speed) * groove.radius


def contact_size_warnings_of_screw(groove: ScrewGroove, force: Array) -> list[ResultWarning]:
    """Return warnings on contact ellipses that are large compared with the ball.

    ``groove``: groove and ball; ``force``: contact loads (..., 4) [N] of each ball on the four flanks.
    """
    return contact_size_warnings((groove.contact_hertz_constants.C_a * np.cbrt(force)).ravel(), groove.ball_radius)


# --- two balls


#: Entries of the JSON of a ball that are its motion.
_MOTION = from_fields(*answer.MOTION_KEYS)


def two_screw_balls(result: ScrewPairSolution) -> tuple[FrictionBall, ...]:
    """Return the two balls of a screw four times: two with the balls far apart, then two with touching balls.

    Each has contact loads and motion of the ball, and its friction loss in the grooves. ``result``: solution of the two
    balls.
    """
    return tuple(
        FrictionBall(
            index=k + 1,
            **answer.ball_motion(chain.motion.q[k]),
            entries={
                "index": ...,
                "state": state,
                **answer.ball_loads_json(SIDES, chain.loads_with_friction.force[k], chain.loads_with_friction.angle[k]),
                **_MOTION,
                "groove_loss_mW": json_number(1e3 * chain.motion.groove_loss[k].sum()),
            },
        )
        for state, chain in (("apart", result.apart), ("touching", result.touching))
        for k in range(2)
    )


def status_of_two_screw_balls(result: ScrewPairSolution) -> str:
    """Return "converged" for two balls of a screw, or what failed: a balance, or the agreement of loads and friction."""
    if result.converged:
        return "converged"
    if all(c.loads_with_friction.converged and c.motion.converged for c in (result.apart, result.touching)):
        return "loads and friction do not agree"
    return "no balance of the loads or of friction found"


def solve_friction_of_two_screw_balls(scene: ScrewPairScene) -> FrictionAnswer:
    """Solve two balls of a ball screw; return forces, losses, and how contact between the balls changes the friction."""
    pair = scene.pair
    r = solve_pair_of_screw_balls(pair)
    m, apart, balls, chains = r.touching.motion, r.apart.motion.loss, two_screw_balls(r), (r.apart, r.touching)
    bound, ball_loss = full_sliding_loss(pair.groove, r.touching.loads_with_friction.force), float(m.ball_loss.sum())
    between = {"balls": "1-2", "gap_um": 0.0, "force_N": json_number(r.force), "loss_mW": json_number(1e3 * ball_loss)}
    loads = max(c.loads_with_friction.largest_unbalanced_force for c in chains)
    friction, rounds = max(c.motion.largest_unbalanced_force for c in chains), max(c.rounds for c in chains)
    change = max(c.last_friction_change for c in chains) if pair.coupling != "none" else 0.0
    record = answer.friction_of_parts(
        scene,
        status_of_two_screw_balls(r),
        r.converged,
        {
            "law": "coulomb",
            "hertz": answer.scene_word_for_hertz_constants(pair.groove.hertz),
            "coupling": pair.coupling,
            "coupled": pair.coupling != "none",
            "deviation_deg": [json_number(degrees(t)) for t in pair.theta],
            "oversize_um": json_number(1e6 * pair.oversize),
            "balls": ...,
            "pairs": [between | {"closing_apart_rad_s": json_number(r.approach_speed_when_apart)}],
            "load_sum_N": [json_number(f) for f in r.ball_loads],
            **answer.ball_to_ball_contact_effect(m.input_power, m.loss, apart, ball_loss, bound),
            "solver.load_imbalance_N": json_number(loads),
            "solver.friction_imbalance_N": json_number(friction),
            "solver.feedback_change_N": json_number(change),
            "solver.rounds": rounds,
        },
        pair.coupling,
        loss=m.loss,
        balls=balls,
        warnings=tuple(contact_size_warnings_of_screw(pair.groove, r.touching.loads_with_friction.force)),
    )
    rise = answer.loss_increase_percent(m.loss, apart, bound)
    force = f"{r.force:.6g} N from ball to ball, loss there {ball_loss:.6g} W"
    lines = [
        ("force", force + ("" if rise is None else f"; contact changes all losses by {rise:+.4g} %")),
        ("closing", f"when apart the balls close in at {r.approach_speed_when_apart:.6g} rad/s of azimuth"),
        answer.line_on_energy_balance(m.input_power, m.loss),
        answer.line_on_solver_residuals(loads, friction, f", {rounds} rounds"),
        line_on_friction_law(pair.groove, pair.coupling),
    ]
    table = "per ball", PAIR_COLUMNS, [answer.terminal_ball_row(SIDES, ball.as_json()) for ball in balls]
    return FrictionAnswer(record, [table], lines)


def line_on_friction_law(groove: ScrewGroove, coupling: str) -> answer.Line:
    """Return a terminal line (label, text) on friction law, Hertz constants, and the effect of friction on contact loads.

    ``coupling``: the scene's word for this effect.
    """
    hertz = answer.scene_word_for_hertz_constants(groove.hertz)
    return "law", f"coulomb, Hertz constants {hertz}, coupling of friction to loads: {coupling}"


#: Columns of the terminal's table of two screw balls, apart and touching.
PAIR_COLUMNS: tuple[Column, ...] = (
    ("index", "ball", "s"),
    ("state", "state", "s"),
    *((f"{s} N", f"{s} N", ".3f") for s in SIDES),
    ("orbit_rad_s", "orbit rad/s", ".6f"),
    *((f"omega {n}", f"omega_{n} rad/s", ".4f") for n in "xyz"),
    ("groove_loss_mW", "groove loss mW", ".5f"),
)


# --- a whole screw


def balls_keep_their_order(history: TravelHistory) -> bool:
    """Return whether no ball of a simulated screw ever passes or overlaps the next one on its closed track."""
    azimuths, setting = history.azimuths_at_piece_ends, history.setting
    ahead = np.diff(np.column_stack([azimuths, azimuths[:, 0] + setting.ring]), axis=1)
    return bool(ahead.min() >= setting.groove.pair.spacing - TOUCHING)


def screw_run_summary_json(history: TravelHistory) -> dict[str, Any]:
    """Return a summary of a screw's simulation over time as JSON values, whose names end in the units.

    ``history``: history of the simulation. "largest_ball_to_groove_percent" is the largest value over time of the friction
    torque by contact between balls, in per cent of the friction torque by contact with the grooves.
    """
    s, touch, nut = summarise_screw_run(history), np.any(history.presses_on_next, axis=1), np.degrees(history.nut_angle)
    met, groove = bool(touch.any()), history.setting.groove
    step = degrees(abs(groove.speed) * history.span / history.steps)
    torques = {
        "mean_torque_Nmm": history.torque,
        "mean_groove_torque_Nmm": history.groove_torque,
        "mean_ball_torque_Nmm": history.ball_torque + history.closing_torque,
        "mean_closing_torque_Nmm": history.closing_torque,
    }
    return {
        "largest_ball_to_groove_percent": json_number(100.0 * s.largest_ball_to_groove_ratio),
        "largest_at_deg": json_number(s.nut_angle_of_largest_ratio) if met else None,
        "contact_begins_deg": json_number(nut[np.argmax(touch)]) if met else None,
        "contact_ends_deg": json_number(s.nut_angle_without_contact) if met else None,
        "contact_ends_within_deg": json_number(step) if met else None,
        "largest_groups": s.most_touching_groups,
        **{name: json_number(1e3 * history.mean_over_time(values)) for name, values in torques.items()},
        "groove_variation_percent": json_number(100.0 * s.groove_variation),
        "largest_ball_force_N": json_number(history.ball_force.max()),
        "order_kept": balls_keep_their_order(history),
        "smallest_gap_um": json_number(1e6 * groove.radius * history.gap.min()),
        "occupation_percent": json_number(100.0 * history.setting.track_occupation),
    }


def screw_run_series_json(history: TravelHistory) -> dict[str, list[Any]]:
    """Return the time series of a screw's simulation as JSON, with one value per time step.

    ``history``: history of the simulation. Time and nut angle are those of the middle of a step.
    """
    values = {
        "time_s": history.time,
        "nut_angle_deg": np.degrees(history.nut_angle),
        "groove_torque_Nmm": 1e3 * history.groove_torque,
        "ball_torque_Nmm": 1e3 * (history.ball_torque + history.closing_torque),
        "ball_to_groove_percent": 100.0 * history.ball_to_groove_ratio,
        "largest_ball_force_N": history.ball_force.max(axis=1),
        "smallest_gap_um": 1e6 * history.setting.groove.radius * history.gap.min(axis=1),
        "balance_percent": 100.0 * history.imbalance,
    }
    out: dict[str, list[Any]] = {name: [json_number(v) for v in row] for name, row in values.items()}
    out |= {"contacts": history.presses_on_next.sum(axis=1).tolist(), "groups": history.touching_group_counts.tolist()}
    return out | {"converged": history.converged.tolist()}


def simulate_screw_over_time(scene: ScrewRunScene) -> FrictionAnswer:
    """Simulate a whole screw over time; return contacts between balls, torques and energy."""
    run, time = scene.run, scene.time
    in_time = friction_run.simulate_with_several_step_sizes(run, Motion(run.groove.speed), time, scene.name)
    h, speed = in_time.history, abs(run.groove.speed)
    bound = full_sliding_loss(run.groove, h.load) / h.time.size
    loss = h.torque * speed
    power, mean_loss = h.mean_over_time(loss * (1.0 + h.imbalance)), h.mean_over_time(loss)
    spent = answer.power_balance_with_percent(power, mean_loss, bound)
    known = spent["energy.balance_percent"] is not None
    largest = answer.zero_if_round_off(float(np.abs(h.imbalance).max()), 1.0)
    summary, failed = screw_run_summary_json(h), int(np.sum(~h.converged))
    found = friction_run.transient_simulation_as_json(in_time)
    record = answer.friction_of_parts(
        scene,
        in_time.status,
        in_time.converged,
        {
            "law": "coulomb",
            "hertz": answer.scene_word_for_hertz_constants(run.groove.hertz),
            "coupling": run.coupling,
            "coupled": run.coupling != "none",
            "ball_count": run.count,
            "steps": h.steps,
            "duration_s": json_number(run.duration),
            "amplitude_deg": json_number(degrees(run.amplitude)),
            "oversize_um": json_number(1e6 * run.oversize),
            "summary": summary,
            **spent,
            "energy.largest_step_balance_percent": json_number(100.0 * largest) if known else None,
            "series": screw_run_series_json(h),
            "solver.failed_steps": failed,
            "solver.feedback_change_N": json_number(h.change.max()) if run.coupling != "none" else 0.0,
            "step_error": found["step_error"],
            "run": found,
        },
        run.coupling,
        loss=mean_loss,
        warnings=tuple(contact_size_warnings_of_screw(run.groove, h.load)),
    )
    label, text = answer.line_on_energy_balance(power, mean_loss)
    lines = [
        *friction_run.lines_on_simulation(in_time),
        ("balls", f"{run.count} over {run.duration:.6g} s"),
        (label, f"{text}, at most {largest:.1e} of the loss out of balance at an instant" if largest else text),
        ("solver", f"{failed} of {h.time.size} instants failed"),
        line_on_friction_law(run.groove, run.coupling),
    ]
    shown = [{"quantity": label, "value": format_cell(summary[name], form)} for name, label, form in RUN_LINES]
    return FrictionAnswer(record, [("summary", RUN_COLUMNS, shown)], lines)


#: Columns of the terminal's table on a simulation over time.
RUN_COLUMNS = (("quantity", "quantity with its unit", "s"), ("value", "value in this unit", "s"))

#: Rows of this table: key in the summary, quantity with its unit, and number format.
RUN_LINES = (
    ("largest_ball_to_groove_percent", "largest ratio of torque by ball-to-ball contact to torque of the grooves %", ".4g"),
    ("largest_at_deg", "nut angle at this largest ratio deg", ".4g"),
    ("contact_begins_deg", "nut angle where contact begins deg", ".4g"),
    ("contact_ends_deg", "nut angle where contact first ends after the largest ratio deg", ".4g"),
    ("contact_ends_within_deg", "uncertainty of the nut angle where contact ends deg", ".4g"),
    ("largest_groups", "largest number of groups of touching balls", "d"),
    ("mean_torque_Nmm", "mean torque N mm", ".5g"),
    ("mean_groove_torque_Nmm", "part of the grooves in the mean torque N mm", ".5g"),
    ("mean_ball_torque_Nmm", "part of ball-to-ball contact in the mean torque N mm", ".5g"),
    ("mean_closing_torque_Nmm", "part of closing gaps between balls in the mean torque N mm", ".3g"),
    ("groove_variation_percent", "variation of the grooves' torque %", ".4g"),
    ("largest_ball_force_N", "largest ball-to-ball force N", ".5g"),
    ("order_kept", "order of balls kept", "s"),
    ("smallest_gap_um", "smallest gap um", ".3g"),
    ("occupation_percent", "loaded track filled by all balls %", ".4g"),
)


def bearing_ball_motion(scene: BearingBallScene, problem: equilibrium.BodyMotionProblem) -> BallMotion:
    """Return the motion of one ball of a bearing under the friction law that the scene chooses.

    ``problem``: equations of the ball's balance of friction forces and moments. For Coulomb friction the motion is that of
    least dissipation. For other laws it is the root of the equations that the solver finds if it starts from that motion.
    """
    first = equilibrium.least_dissipation(problem)
    if scene.law == "coulomb":
        return first
    if scene.law == "regularised":
        return equilibrium.motion_by_root(problem, RegularisedCoulombLaw(scene.creep), first.unknown_velocities)
    law = lin_sigmoid_law(scene.bearing, scene.sharpness, scene.map_step)
    found = equilibrium.motion_by_root(problem, law, first.unknown_velocities)
    if found.status == "exact":
        return found
    return equilibrium.motion_by_sharpened_sigmoids(problem, law, first.unknown_velocities)


def status_of_bearing_ball(loaded: bool, balanced: bool, motion: str) -> str:
    """Return the status of the solution for one ball of a bearing: "converged", or what failed.

    ``loaded``: whether a contact of the ball carries load; ``balanced``: whether the contact loads are in equilibrium;
    ``motion``: status of the friction solver, which is "failed" if it found no balance.
    """
    if not loaded:
        return "no contact: nothing presses the ball"
    if not balanced:
        return "no balance of the loads found"
    return "no balance of friction found" if motion == "failed" else "converged"


def ball_of_bearing(load: equilibrium.ContactLoadSolution, at: EllipticalContacts, motion: BallMotion) -> FrictionBall:
    """Return one ball of a bearing: contact loads and ellipses, motion, friction and losses.

    ``load``: contact loads; ``at``: contact ellipses; ``motion``: motion of the ball with its friction. The axes x and z of
    a contact lie across and along its groove. The rotation of the ball about the direction of its path is zero by
    symmetry.
    """
    f = motion.friction
    return FrictionBall(
        index=1,
        **answer.ball_motion(np.append(motion.unknown_velocities, 0.0)),
        **answer.sliding_and_friction(
            bearing.SIDES, motion.contact_motions, f.force, f.moment, f.loss, motion.sticking_contacts
        ),
        entries={
            "index": ...,
            **answer.ball_loads_json(bearing.SIDES, load.force, load.angle),
            "semi_axis_across_um": answer.contact_values_json(bearing.SIDES, 1e6 * at.a),
            "semi_axis_along_um": answer.contact_values_json(bearing.SIDES, 1e6 * at.b),
            **_MOTION,
            **from_fields(*answer.CONTACT_KEYS),
        },
    )


def rows_of_loaded_contacts(ball: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a row of the terminal table for each loaded contact of a ball.

    ``ball``: JSON of `ball_of_bearing`.
    """
    size = ("load_N", "contact_angle_deg", "semi_axis_across_um", "semi_axis_along_um")
    names = (*size, "spin_rad_s", "moment_Nmm", "loss_mW", "at_rest")
    return [
        {"side": s, "slide": ball["sliding_mm_s"][s][1], "along": ball["friction_N"][s][1]} | {n: ball[n][s] for n in names}
        for s in bearing.SIDES
        if ball["load_N"][s] > 0.0
    ]


#: Columns of the terminal's table of the loaded contacts of one ball; a and b are the semi-axes of the contact ellipse
#: across and along the groove.
CONTACT_COLUMNS = (
    ("side", "contact", "s"),
    ("load_N", "force N", ".4f"),
    ("contact_angle_deg", "angle deg", ".4f"),
    ("semi_axis_across_um", "a um", ".1f"),
    ("semi_axis_along_um", "b um", ".1f"),
    ("slide", "sliding mm/s", ".4f"),
    ("spin_rad_s", "spin rad/s", ".4f"),
    ("along", "friction N", ".5f"),
    ("moment_Nmm", "moment N mm", ".5f"),
    ("loss_mW", "loss mW", ".4f"),
    ("at_rest", "at rest", "s"),
)


def solve_friction_of_bearing_ball(scene: BearingBallScene) -> FrictionAnswer:
    """Solve contact loads and friction of one ball of a bearing; also return losses and torque on the inner ring."""
    b = scene.bearing
    load = bearing.contact_loads_of_ball(b, scene.force, scene.displacement)
    rough = replace(b, mu=b.mu or 1.0)
    at = bearing.ball_contacts(rough, load)
    motion = bearing_ball_motion(scene, bearing.ball_motion_problem(rough, load, at))
    if b.mu == 0.0:
        motion = equilibrium.motion_without_friction_forces(motion)
    held = load.force > 0.0
    converged = bool(held.any()) and load.converged and motion.status != "failed"
    ball, speed = ball_of_bearing(load, at, motion), b.screw_speed
    torque = bearing.inner_ring_torque(b, load, motion)
    bound = float(at.friction_bound.sum()) * abs(speed) * b.pitch_radius
    by_loss = motion.loss / abs(speed) if speed != 0.0 else None
    status = status_of_bearing_ball(bool(held.any()), load.converged, motion.status)
    record = answer.friction_of_parts(
        scene,
        status,
        converged,
        {
            "law": scene.law,
            "hertz": answer.scene_word_for_hertz_constants(b.hertz),
            "coupled": False,
            "balls": ...,
            "load_sum_N": json_number(load.force.sum()),
            **from_fields("torque.friction_torque_Nmm", "torque.driving_torque_on_screw_Nmm"),
            **answer.power_balance_with_percent(torque * speed, motion.loss, bound),
            "solver.load_imbalance_N": json_number(load.largest_unbalanced_force),
            "solver.friction_imbalance_N": json_number(motion.imbalance),
            "solver.load_steps": load.steps,
            "solver.motion_steps": motion.steps,
            "solver.motion": motion.status,
        },
        torque=by_loss,
        driving_torque_on_screw=torque,
        loss=motion.loss,
        balls=(ball,),
        warnings=tuple(contact_size_warnings(at.a[held], b.ball_radius)),
    )
    orbit, x, y = motion.unknown_velocities
    turn = f"{1e3 * torque:.6g} N mm turn the inner ring"
    lines = [
        ("torque", turn + ("" if by_loss is None else f" (dissipation over speed: {1e3 * by_loss:.6g} N mm)")),
        ("loads", f"sum of contact loads {load.force.sum():.6g} N; they do not depend on friction"),
        ("ball", f"orbit {orbit:.6g} rad/s, omega_x {x:.6g} rad/s, omega_y {y:.6g} rad/s"),
        answer.line_on_energy_balance(torque * speed, motion.loss),
        answer.line_on_solver_residuals(load.largest_unbalanced_force, motion.imbalance),
        ("law", f"{scene.law}, Hertz constants {answer.scene_word_for_hertz_constants(b.hertz)}"),
    ]
    table = "per contact", CONTACT_COLUMNS, rows_of_loaded_contacts(ball.as_json())
    return FrictionAnswer(record, [table], lines)


# --- two designs of a bearing


def has_friction_loss(case: bearing.BearingCase, state: bearing.BearingState) -> bool:
    """Return whether the friction loss of a bearing is more than round-off.

    ``case``: bearing with its coefficient of friction; ``state``: its solution at one load angle.
    """
    return float(state.loss.sum()) > answer.NOTHING * full_sliding_loss(case.groove, state.load.force)


def bearing_torques_json(case: bearing.BearingCase, states: list[bearing.BearingState]) -> dict[str, Any]:
    """Return the friction torque [N mm] of a bearing at each load angle, and the ratio of the largest to the smallest.

    ``states``: solution for each load angle. The JSON values also have, for each load angle, the number of balls with
    more than two contacts, and whether the solution converged. The ratio is null if a solution has no friction loss.
    """
    torque = [1e3 * s.torque for s in states]
    all_rub = all(has_friction_loss(case, s) for s in states)
    return {
        "friction_torque_Nmm": [json_number(t) for t in torque],
        "balls_beyond_two_contacts": [int(np.sum(s.loaded_contact_counts > 2)) for s in states],
        "largest_over_smallest": json_number(max(torque) / min(torque)) if all_rub else None,
        "converged": [s.converged for s in states],
    }


def unresisted_motions(scene: BearingPairScene) -> list[str]:
    """Return sentences on rigid motions of the inner ring that the load drives and that no contact resists.

    There is one sentence for each bearing (four-point, double-row) and load angle with such a motion.
    """
    out = []
    for name, case in (("four-point", scene.four_point), ("double row", scene.double_row)):
        for angle in scene.angle:
            free = bearing.describe_unresisted_motion(case, float(angle))
            if free:
                where = f"load at {np.degrees(angle):.4g} deg"
                out.append(f"{name} bearing, {where}: {free}: no contact resists it, and the force drives it")
    return out


def solve_friction_of_two_bearings(scene: BearingPairScene) -> FrictionAnswer:
    """Solve a four-point and a double-row bearing for several angles of the load; return torques and losses.

    Input power and friction loss are means over all load angles and both bearings.
    """
    case, angle = scene.four_point, [json_number(a) for a in np.degrees(scene.angle)]
    common = {
        "law": "coulomb",
        "hertz": answer.scene_word_for_hertz_constants(case.groove.hertz),
        "coupled": False,
        "force_N": json_number(case.force),
        "tilt": case.tilt,
        "load_angle_deg": angle,
    }
    mechanisms = unresisted_motions(scene)
    if mechanisms:
        others = f" (and {len(mechanisms) - 1} more)" if len(mechanisms) > 1 else ""
        status = f"no equilibrium: {mechanisms[0]}{others}"
        return FrictionAnswer(answer.friction_of_parts(scene, status, False, common))
    return _answer_on_two_bearings(scene, common)


def _answer_on_two_bearings(scene: BearingPairScene, common: dict[str, Any]) -> FrictionAnswer:
    """Return the friction of a four-point and a double-row bearing over the load angle.

    ``common``: JSON entries that are known before the solution, such as the load angles.
    """
    cases = scene.four_point, scene.double_row
    by_case = [bearing.solve_bearing_over_force_angles(case, scene.angle) for case in cases]
    four, double = (bearing_torques_json(case, states) for case, states in zip(cases, by_case, strict=True))
    good = [f and d for f, d in zip(four["converged"], double["converged"], strict=True)]
    status = "converged" if all(good) else f"{good.count(False)} of {len(good)} load angles did not converge"
    ratios = [
        json_number(f.torque / d.torque) if has_friction_loss(cases[1], d) else None for f, d in zip(*by_case, strict=True)
    ]
    states = [(c, s) for c, one in zip(cases, by_case, strict=True) for s in one]
    powers = [(s.input_power, s.loss.sum(), full_sliding_loss(c.groove, s.load.force)) for c, s in states]
    power, loss, bound = (float(np.mean(column)) for column in zip(*powers, strict=True))
    large = [
        w.with_part_name(name)
        for name, c, one in zip(("four-point", "double row"), cases, by_case, strict=True)
        for w in contact_size_warnings_of_screw(c.groove, np.stack([s.load.force for s in one]))
    ]
    left = max(s.load.largest_unbalanced_force for _, s in states)
    record = answer.friction_of_parts(
        scene,
        status,
        all(good),
        {
            **common,
            "four_point": four,
            "double_row": double,
            "four_over_double": ratios,
            **answer.power_balance_with_percent(power, loss, bound),
            "solver.load_imbalance_N": json_number(left),
        },
        loss=loss,
        warnings=tuple(large),
    )
    torques, beyond = [one["friction_torque_Nmm"] for one in (four, double)], four["balls_beyond_two_contacts"]
    columns = zip(common["load_angle_deg"], *torques, ratios, beyond, good, strict=True)
    rows = [dict(zip((name for name, _, _ in BEARING_COLUMNS), row, strict=True)) for row in columns]
    variations = (format_cell(one["largest_over_smallest"], ".5g") for one in (four, double))
    label, text = answer.line_on_energy_balance(power, loss)
    ring = "free to tilt" if common["tilt"] else "kept from tilting"
    lines = [
        ("torque", "largest over smallest: four-point {}, double row {}".format(*variations)),
        (label, f"{text}, mean over the angles"),
        ("solver", f"loads out of balance by {left:.1e} N"),
        ("law", f"coulomb, Hertz constants {common['hertz']}, inner ring {ring}"),
    ]
    return FrictionAnswer(record, [("over the load's angle", BEARING_COLUMNS, rows)], lines)


#: Columns of the terminal's table of friction torques of both bearings over the angle of the load.
BEARING_COLUMNS = (
    ("angle", "load angle deg", ".4g"),
    ("four", "four-point N mm", ".5g"),
    ("double", "double row N mm", ".5g"),
    ("over", "four-point over double row", ".4g"),
    ("beyond", "balls of the four-point beyond two contacts", "d"),
    ("converged", "converged", "s"),
)

#: Functions that solve a scene of single parts, by the kind of the scene.
SOLVERS: dict[str, Callable[[Any], FrictionAnswer]] = {
    "bearing ball": solve_friction_of_bearing_ball,
    "bearing pair": solve_friction_of_two_bearings,
    "linear pair": solve_friction_of_linear_bearing,
    "linear chain": solve_friction_of_linear_bearing,
    "screw pair": solve_friction_of_two_screw_balls,
    "screw run": simulate_screw_over_time,
}


def solve_friction_of_single_parts(scene: FrictionScene) -> FrictionAnswer:
    """Compute the friction of a scene of single parts: two balls, one ball, bearing, linear bearing, or screw over time.

    Parameters
    ----------
    scene
        Friction scene of one of these kinds.

    Returns
    -------
    FrictionAnswer
        Its friction, with tables and text lines.
    """
    return SOLVERS[scene.kind](scene)
