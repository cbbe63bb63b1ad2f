"""Oracles of the friction tests: one ball of a screw coupled to its loads, and formulas of Lin 3.3.3 and 3.32."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ellipe

from rollbench.lowfi.friction.contact.equilibrium import ContactLoadSolution
from rollbench.lowfi.friction.contact.laws import EllipticalContacts
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.screw import motion
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.chain import PATIENCE, solve_loads_and_motion
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.arrays import Array


def dense(band: Array, half: int) -> Array:
    """Square matrix of rows stored as ``band[i, half + j - i]``, all columns up to ``half`` away from the diagonal."""
    full = np.zeros((len(band), len(band)))
    for i, j in np.ndindex(full.shape):
        full[i, j] = band[i, half + j - i] if abs(j - i) <= half else 0.0
    return full


_FORCE_SENSE = np.array([1.0, 1.0, -1.0, -1.0])
_SPIN_SENSE = np.array([1.0, -1.0, -1.0, 1.0])


def ball_velocity(angles: Array) -> Array:
    """Velocity of a ball over that of the carriage from the angles gamma ``(..., 4)`` of its points of no slip.

    Mends (3.41): sin(BL+BR) / (sin(BL+BR) + sin(BL+TL) + sin(BR-TL)); the fourth angle must fit (``mismatch`` zero).
    """
    bl, br, _, tl = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    return np.asarray(np.sin(bl + br) / (np.sin(bl + br) + np.sin(bl + tl) + np.sin(br - tl)))


def mismatch(angles: Array) -> Array:
    """Left minus right side of (3.38): zero where one rigid motion has its points of no slip at gamma ``(..., 4)``."""
    bl, br, tr, tl = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    return np.asarray(np.sin(bl + tl) + np.sin(br - tl) - np.sin(br + tr) - np.sin(bl - tr))


def shifts(bearing: LinearBearing, deviation: Array, loads: Array, force: float = 0.0, *, k_f: float) -> Array:
    """Shifts Delta eta + Delta zeta ``(4,)`` [rad] of the points of no slip, loads of the four contacts unequal.

    Solves (3.37) or (3.45), mended, with (3.40), (3.47): force and moments in balance with an axial ``force`` [N]
    against the ball's motion, and one rigid motion. deviation ``(4,)``: Delta beta [rad].
    """
    beta = bearing.contact_angle + np.asarray(deviation, dtype=float)
    constants, radius = bearing.contact_hertz_constants(), bearing.ball_radius
    a = constants.C_a * np.cbrt(loads)
    stiff = _FORCE_SENSE * k_f * bearing.mu * loads * radius / a
    ellip = float(ellipe(1.0 - float(constants.C_b / constants.C_a) ** 2))
    moment = -_SPIN_SENSE * 0.375 * bearing.mu * loads * a * ellip / radius
    c, s = np.cos(beta), np.sin(beta)
    up = np.array([-1.0, -1.0, 1.0, 1.0])
    side = np.array([1.0, -1.0, -1.0, 1.0])
    rigid = np.array([1.0, -1.0, -1.0, 1.0])
    matrix = np.array([stiff, up * c * stiff, side * s * stiff, rigid * stiff.max()])
    load = np.array([force, -(side * s) @ moment, up @ (c * moment), -stiff.max() * (rigid @ deviation)])
    return np.linalg.solve(matrix, load)


def deviation_from_shifts(bearing: LinearBearing, deviation: Array, shift: Array) -> float:
    """Deviation epsilon of the ball's velocity from half the carriage's, relative to it: (3.42) with tan beta_0."""
    moved = np.asarray(deviation, dtype=float) + shift
    return float(0.5 * np.tan(bearing.contact_angle) * (moved[3] - moved[1]))


def pure_spin_moment(at: EllipticalContacts) -> Array:
    """Moment (n,) [N m] that resists spin about the centre, (3/8) mu F a E(e) (Lin 3.32)."""
    return np.asarray(0.375 * at.friction_bound * at.a * ellipe(1.0 - (at.b / at.a) ** 2))


def ball_cell(
    groove: ScrewGroove, deviation: Array, oversize: float, free: str, force: Array
) -> screw_motion.BallsBetweenGrooves:
    """One ball at azimuth 0: deviations (4,) of its groove angles [rad], oversize of its radius [m], free, force (m,)."""
    angle = np.asarray(groove.contact_angle + deviation, dtype=float)[None, :]
    rows, pull = screw_motion.screw_displacement_maps(groove, np.zeros(1), free), np.asarray(force, dtype=float)
    return screw_motion.balls_without_friction(groove, angle, np.full((1, 4), float(oversize)), rows, pull)


@dataclass(frozen=True)
class CoupledBall:
    """Loads and motion that agree. change: last change of the friction fed back [N]; converged: also the parts are."""

    load: ContactLoadSolution
    motion: motion.BallMotion
    change: float
    rounds: int
    converged: bool


def coupled_ball(
    cell: screw_motion.BallsBetweenGrooves, coupling: motion.Coupling = "ball and screw", fast: bool = True
) -> CoupledBall:
    """Loads and motion of the one ball of a cell in agreement, with rest and slip exact; see ``coupled_chain``.

    Failure is data: see ``converged``.
    """
    load = screw_motion.solve_screw_contact_loads(cell)
    if coupling == "ball":
        cell = motion.balls_with_fixed_screw(cell, load)
        load = screw_motion.solve_screw_contact_loads(cell, (load.ball_displacements, np.zeros(0)))
    groove, mixer, bare = (
        cell.groove,
        motion.AndersonAcceleration(),
        (load.ball_displacements, load.inner_body_displacements),
    )
    push, drag, start = cell.ball_friction_forces, cell.screw_friction_forces, None
    rounds, change, good = 0, np.inf, False
    while True:
        moved = motion.solve_ball_motion(groove, load.force[0], load.angle[0], start=start, fast=fast)
        new_push, new_drag = motion.friction_on_balls_and_screw(cell, moved.wrench[None], np.zeros((1, 2)), coupling)
        x, g = np.append(push, drag), np.append(new_push, new_drag)
        change = float(np.max(np.abs(g - x)))
        good = load.converged and moved.motion.status != "failed"
        rounds += 1
        if change <= motion.AGREED * float(np.sum(load.force)) or rounds == motion.ROUNDS:
            break
        joint = solve_loads_and_motion(cell, np.full(1, np.inf), bare, None, fast) if rounds == PATIENCE else None
        if joint is not None and joint.reached_full_friction:
            push, drag = joint.ball_friction_forces, joint.screw_friction_forces
            with_friction = replace(cell, ball_friction_forces=push, screw_friction_forces=drag)
            load = screw_motion.solve_screw_contact_loads(
                with_friction, (joint.ball_displacements, joint.screw_displacements)
            )
        else:
            x = mixer.next_iterate(x, g)
            push, drag = x[:2].reshape(1, 2), x[2:]
            load = screw_motion.solve_screw_contact_loads(
                replace(cell, ball_friction_forces=push, screw_friction_forces=drag),
                (load.ball_displacements, load.inner_body_displacements),
            )
        start = moved.motion.unknown_velocities
    return CoupledBall(load, moved, change, rounds, good and change <= motion.AGREED * float(np.sum(load.force)))
