"""Friction of single parts: two balls of a screw, a screw over time, one ball of a bearing, two bearings.

Linear bearings are in ``linear_friction``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import radians
from typing import Any

import numpy as np

from rollbench.compare.cases.lin.kinds.bearings import BearingBallScene, BearingPairScene
from rollbench.compare.cases.lin.kinds.linear_friction import solve_friction_of_linear_bearing
from rollbench.compare.cases.lin.kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.compare.results import friction_parts as parts
from rollbench.compare.results.friction import Friction, FrictionBall
from rollbench.compare.studies.friction import answer
from rollbench.compare.studies.friction import run as friction_run
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.contact import equilibrium
from rollbench.lowfi.friction.contact.equilibrium import BodyMotion as BallMotion
from rollbench.lowfi.friction.contact.laws import ContactFriction, EllipticalContacts, friction_forces
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import contact_ellipses_of_screw, lin_sigmoid_law
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


def two_screw_balls(result: ScrewPairSolution) -> tuple[FrictionBall, ...]:
    """Return the two balls of a screw twice: first with the balls far apart, then with touching balls.

    Each has contact loads and motion of the ball, and its friction loss in the grooves. ``result``: solution of the two
    balls.
    """
    return tuple(
        FrictionBall(
            index=k + 1,
            state=state,
            **answer.ball_loads(SIDES, chain.loads_with_friction.force[k], chain.loads_with_friction.angle[k]),
            **answer.ball_motion(chain.motion.q[k]),
            groove_loss=float(chain.motion.groove_loss[k].sum()),
            keys=("index", "state", *answer.LOAD_KEYS, *answer.MOTION_KEYS, "groove_loss_mW"),
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


#: Keys of the JSON of two balls of a screw.
PAIR_KEYS = (
    *("law", "hertz", "coupling", "coupled", "deviation_deg", "oversize_um", "balls", "pairs", "load_sum_N"),
    *answer.CONTACT_EFFECT_KEYS,
    *("solver.load_imbalance_N", "solver.friction_imbalance_N", "solver.feedback_change_N", "solver.rounds"),
)


def solve_friction_of_two_screw_balls(scene: ScrewPairScene) -> parts.FrictionOfTwoBalls:
    """Solve two balls of a ball screw; return forces, losses, and how contact between the balls changes the friction."""
    pair = scene.pair
    r = solve_pair_of_screw_balls(pair)
    m, chains = r.touching.motion, (r.apart, r.touching)
    bound, ball_loss = full_sliding_loss(pair.groove, r.touching.loads_with_friction.force), float(m.ball_loss.sum())
    contact = parts.BallPair(balls="1-2", gap=0.0, force=r.force, loss=ball_loss, closing_apart=r.approach_speed_when_apart)
    return answer.friction_of_parts(
        parts.FrictionOfTwoBalls,
        scene,
        status_of_two_screw_balls(r),
        r.converged,
        PAIR_KEYS,
        law="coulomb",
        hertz=answer.scene_word_for_hertz_constants(pair.groove.hertz),
        coupling=pair.coupling,
        coupled=pair.coupling != "none",
        deviation=tuple(map(float, pair.theta)),
        oversize=pair.oversize,
        balls=two_screw_balls(r),
        pairs=(contact,),
        load_sums=r.ball_loads.tolist(),
        **answer.ball_to_ball_contact_effect(m.input_power, m.loss, r.apart.motion.loss, ball_loss, bound),
        load_imbalance=max(c.loads_with_friction.largest_unbalanced_force for c in chains),
        friction_imbalance=max(c.motion.largest_unbalanced_force for c in chains),
        friction_change=max(c.last_friction_change for c in chains) if pair.coupling != "none" else 0.0,
        rounds=max(c.rounds for c in chains),
        warnings=tuple(contact_size_warnings_of_screw(pair.groove, r.touching.loads_with_friction.force)),
    )


# --- a whole screw


def balls_keep_their_order(history: TravelHistory) -> bool:
    """Return whether no ball of a simulated screw ever passes or overlaps the next one on its closed track."""
    azimuths, setting = history.azimuths_at_piece_ends, history.setting
    ahead = np.diff(np.column_stack([azimuths, azimuths[:, 0] + setting.ring]), axis=1)
    return bool(ahead.min() >= setting.groove.pair.spacing - TOUCHING)


def contacts_over_time(history: TravelHistory) -> parts.ScrewRunContacts:
    """Return contacts between balls and mean torques of a screw's simulation over time.

    ``history``: history of the simulation.
    """
    s, touch = summarise_screw_run(history), np.any(history.presses_on_next, axis=1)
    met, groove = bool(touch.any()), history.setting.groove
    return parts.ScrewRunContacts(
        largest_ratio=s.largest_ball_to_groove_ratio,
        angle_of_largest=radians(s.nut_angle_of_largest_ratio) if met else None,
        begins=float(history.nut_angle[np.argmax(touch)]) if met else None,
        ends=radians(s.nut_angle_without_contact) if met else None,
        ends_within=abs(groove.speed) * history.span / history.steps if met else None,
        groups=s.most_touching_groups,
        torque=history.mean_over_time(history.torque),
        groove_torque=history.mean_over_time(history.groove_torque),
        ball_torque=history.mean_over_time(history.ball_torque + history.closing_torque),
        closing_torque=history.mean_over_time(history.closing_torque),
        variation=s.groove_variation,
        ball_force=float(history.ball_force.max()),
        order_kept=balls_keep_their_order(history),
        gap=groove.radius * float(history.gap.min()),
        occupation=history.setting.track_occupation,
    )


#: Keys of the JSON of a screw over time.
RUN_KEYS = (
    *("law", "hertz", "coupling", "coupled", "ball_count", "steps", "duration_s", "amplitude_deg", "oversize_um"),
    *("summary", *answer.BALANCE_KEYS_WITH_PERCENT, "energy.largest_step_balance_percent", "series"),
    *("solver.failed_steps", "solver.feedback_change_N", "step_error", "run"),
)


def simulate_screw_over_time(scene: ScrewRunScene) -> parts.FrictionOfScrewRun:
    """Simulate a whole screw over time; return contacts between balls, torques and energy."""
    run, time = scene.run, scene.time
    in_time = friction_run.simulate_with_several_step_sizes(run, Motion(run.groove.speed), time, scene.name)
    h = in_time.history
    bound = full_sliding_loss(run.groove, h.load) / h.time.size
    loss = h.torque * abs(run.groove.speed)
    power, mean_loss = h.mean_over_time(loss * (1.0 + h.imbalance)), h.mean_over_time(loss)
    spent = answer.power_balance_with_percent(power, mean_loss, bound)
    largest = answer.zero_if_round_off(float(np.abs(h.imbalance).max()), 1.0)
    return answer.friction_of_parts(
        parts.FrictionOfScrewRun,
        scene,
        in_time.status,
        in_time.converged,
        RUN_KEYS,
        law="coulomb",
        hertz=answer.scene_word_for_hertz_constants(run.groove.hertz),
        coupling=run.coupling,
        coupled=run.coupling != "none",
        ball_count=run.count,
        duration=run.duration,
        amplitude=run.amplitude,
        oversize=run.oversize,
        summary=contacts_over_time(h),
        **spent,
        largest_imbalance=None if spent["power_balance_percent"] is None else largest,
        friction_change=float(h.change.max()) if run.coupling != "none" else 0.0,
        run=in_time,
        warnings=tuple(contact_size_warnings_of_screw(run.groove, h.load)),
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
        law = partial(friction_forces, regularising_speed=scene.creep)
        return equilibrium.motion_by_root(problem, law, first.unknown_velocities)
    sigmoid = lin_sigmoid_law(scene.bearing, scene.sharpness, scene.map_step)
    return equilibrium.motion_by_sigmoid(problem, sigmoid, first.unknown_velocities)


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
        **answer.ball_loads(bearing.SIDES, load.force, load.angle),
        semi_axes_across=answer.contact_values(bearing.SIDES, at.a),
        semi_axes_along=answer.contact_values(bearing.SIDES, at.b),
        keys=BEARING_BALL_KEYS,
    )


#: Keys of the JSON of one ball of a bearing.
BEARING_BALL_KEYS = (
    *("index", *answer.LOAD_KEYS, "semi_axis_across_um", "semi_axis_along_um", *answer.MOTION_KEYS),
    *answer.CONTACT_KEYS,
)

#: Keys of the JSON of the friction of one ball of a bearing.
BEARING_KEYS = (
    *("law", "hertz", "coupled", "balls", "load_sum_N"),
    *("torque.friction_torque_Nmm", "torque.driving_torque_on_screw_Nmm", *answer.BALANCE_KEYS_WITH_PERCENT),
    *("solver.load_imbalance_N", "solver.friction_imbalance_N", "solver.load_steps", "solver.motion_steps"),
    "solver.motion",
)


def solve_friction_of_bearing_ball(scene: BearingBallScene) -> parts.FrictionOfBearingBall:
    """Solve contact loads and friction of one ball of a bearing; also return losses and torque on the inner ring."""
    b = scene.bearing
    load = bearing.contact_loads_of_ball(b, scene.force, scene.displacement)
    rough = replace(b, mu=b.mu or 1.0)
    at = contact_ellipses_of_screw(rough, load.force)
    motion = bearing_ball_motion(scene, bearing.ball_motion_problem(rough, load, at))
    if b.mu == 0.0:
        f = motion.friction
        none = ContactFriction(np.zeros_like(f.force), np.zeros_like(f.moment), np.zeros_like(f.loss))
        motion = replace(motion, friction=none, imbalance=0.0)
    held = load.force > 0.0
    converged = bool(held.any()) and load.converged and motion.status != "failed"
    speed, torque = b.screw_speed, bearing.inner_ring_torque(b, load, motion)
    bound = float(at.friction_bound.sum()) * abs(speed) * b.pitch_radius
    return answer.friction_of_parts(
        parts.FrictionOfBearingBall,
        scene,
        status_of_bearing_ball(bool(held.any()), load.converged, motion.status),
        converged,
        BEARING_KEYS,
        law=scene.law,
        hertz=answer.scene_word_for_hertz_constants(b.hertz),
        coupled=False,
        balls=(ball_of_bearing(load, at, motion),),
        load_sum=float(load.force.sum()),
        torque=motion.loss / abs(speed) if speed != 0.0 else None,
        driving_torque_on_screw=torque,
        **answer.power_balance_with_percent(torque * speed, motion.loss, bound),
        load_imbalance=load.largest_unbalanced_force,
        friction_imbalance=motion.imbalance,
        load_steps=load.steps,
        motion_steps=motion.steps,
        motion=motion.status,
        warnings=tuple(contact_size_warnings(at.a[held], b.ball_radius)),
    )


# --- two designs of a bearing


def has_friction_loss(case: bearing.BearingCase, states: bearing.BearingStates) -> list[bool]:
    """Return whether the friction loss of a bearing is more than round-off, for each load angle.

    ``case``: bearing with its coefficient of friction; ``states``: its solution at the load angles.
    """
    bounds = [answer.NOTHING * full_sliding_loss(case.groove, force) for force in states.force]
    return [float(loss.sum()) > bound for loss, bound in zip(states.loss, bounds, strict=True)]


def torques_of_bearing(case: bearing.BearingCase, states: bearing.BearingStates) -> parts.TorquesOfBearing:
    """Return the friction torque of a bearing at each load angle, and the ratio of the largest to the smallest.

    ``states``: solution for the load angles. The ratio is None if a solution has no friction loss.
    """
    torque = states.torque.tolist()
    return parts.TorquesOfBearing(
        torque=torque,
        beyond=states.balls_beyond_two_contacts.tolist(),
        variation=max(torque) / min(torque) if all(has_friction_loss(case, states)) else None,
        converged=states.converged.tolist(),
    )


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


#: Keys of the JSON of two bearings that are known before the solution, then those of the solution.
GIVEN_KEYS = ("law", "hertz", "coupled", "force_N", "tilt", "load_angle_deg")
TORQUE_KEYS = (
    *("four_point", "double_row", "four_over_double", *answer.BALANCE_KEYS_WITH_PERCENT),
    "solver.load_imbalance_N",
)


def solve_friction_of_two_bearings(scene: BearingPairScene) -> parts.FrictionOfTwoBearings:
    """Solve a four-point and a double-row bearing for several angles of the load; return torques and losses.

    Input power and friction loss are means over all load angles and both bearings.
    """
    case = scene.four_point
    given: dict[str, Any] = {
        "law": "coulomb",
        "hertz": answer.scene_word_for_hertz_constants(case.groove.hertz),
        "coupled": False,
        "force": case.force,
        "tilt": case.tilt,
        "load_angle": scene.angle.tolist(),
    }
    mechanisms = unresisted_motions(scene)
    if mechanisms:
        others = f" (and {len(mechanisms) - 1} more)" if len(mechanisms) > 1 else ""
        status = f"no equilibrium: {mechanisms[0]}{others}"
        return answer.friction_of_parts(parts.FrictionOfTwoBearings, scene, status, False, GIVEN_KEYS, **given)
    cases = scene.four_point, scene.double_row
    by_case = [bearing.solve_bearing(case, scene.angle) for case in cases]
    four, double = (torques_of_bearing(case, states) for case, states in zip(cases, by_case, strict=True))
    good = [f and d for f, d in zip(four.converged, double.converged, strict=True)]
    status = "converged" if all(good) else f"{good.count(False)} of {len(good)} load angles did not converge"
    rubs, by_angle = has_friction_loss(cases[1], by_case[1]), zip(*(s.torque for s in by_case), strict=True)
    power = float(np.mean([s.input_power for s in by_case]))
    loss = float(np.mean([s.loss.sum(axis=(1, 2)) for s in by_case]))
    bound = float(np.mean([full_sliding_loss(c.groove, f) for c, s in zip(cases, by_case, strict=True) for f in s.force]))
    large = [
        w.with_part_name(name)
        for name, c, one in zip(("four-point", "double row"), cases, by_case, strict=True)
        for w in contact_size_warnings_of_screw(c.groove, one.force)
    ]
    return answer.friction_of_parts(
        parts.FrictionOfTwoBearings,
        scene,
        status,
        all(good),
        (*GIVEN_KEYS, *TORQUE_KEYS),
        **given,
        four_point=four,
        double_row=double,
        ratio=tuple(float(f / d) if rub else None for (f, d), rub in zip(by_angle, rubs, strict=True)),
        **answer.power_balance_with_percent(power, loss, bound),
        load_imbalance=max(load.largest_unbalanced_force for s in by_case for load in s.load),
        warnings=tuple(large),
    )


#: Functions that solve a scene of single parts, by the kind of the scene.
SOLVERS: dict[str, Callable[[Any], Friction]] = {
    "bearing ball": solve_friction_of_bearing_ball,
    "bearing pair": solve_friction_of_two_bearings,
    "linear pair": solve_friction_of_linear_bearing,
    "linear chain": solve_friction_of_linear_bearing,
    "screw pair": solve_friction_of_two_screw_balls,
    "screw run": simulate_screw_over_time,
}
