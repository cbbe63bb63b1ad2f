"""Oracles of the friction tests: one ball of a screw coupled to its loads, and Lin (3.32)."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import ellipe

from rollbench.lowfi.friction.contact.equilibrium import ContactLoadSolution
from rollbench.lowfi.friction.contact.laws import EllipticalContacts
from rollbench.lowfi.friction.screw import motion
from rollbench.lowfi.friction.screw.coupled import PATIENCE, solve_loads_and_motion
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.arrays import Array


def pure_spin_moment(at: EllipticalContacts) -> Array:
    """Moment (n,) [N m] that resists spin about the centre, (3/8) mu F a E(e) (Lin 3.32)."""
    return np.asarray(0.375 * at.friction_bound * at.a * ellipe(1.0 - (at.b / at.a) ** 2))


def ball_cell(
    groove: ScrewGroove, deviation: Array, oversize: float, free: str, force: Array
) -> motion.BallsBetweenGrooves:
    """One ball at azimuth 0: deviations (4,) of its groove angles [rad], oversize of its radius [m], free, force (m,)."""
    angle = np.asarray(groove.contact_angle + deviation, dtype=float)[None, :]
    rows, pull = motion.screw_displacement_maps(groove, np.zeros(1), free), np.asarray(force, dtype=float)
    return motion.balls_without_friction(groove, angle, np.full((1, 4), float(oversize)), rows, pull)


class CoupledBall(NamedTuple):
    """Loads and motion that agree, and whether they and the parts are converged."""

    load: ContactLoadSolution
    motion: motion.BallMotion
    converged: bool


def coupled_ball(cell: motion.BallsBetweenGrooves, coupling: motion.Coupling = "ball and screw") -> CoupledBall:
    """Loads and motion of the one ball of a cell in agreement, with rest and slip exact; see ``coupled_chain``.

    Failure is data: see ``converged``.
    """
    load = motion.solve_screw_contact_loads(cell)
    if coupling == "ball":
        cell = motion.balls_with_fixed_screw(cell, load)
        load = motion.solve_screw_contact_loads(cell, (load.ball_displacements, np.zeros(0)))
    bare, mixer = (load.ball_displacements, load.inner_body_displacements), motion.AndersonAcceleration()
    push, drag, start, rounds = cell.ball_friction_forces, cell.screw_friction_forces, None, 0
    while True:
        moved = motion.solve_ball_motion(cell.groove, load.force[0], load.angle[0], start=start)
        x = np.append(push, drag)
        g = np.append(*motion.friction_on_balls_and_screw(cell, moved.wrench[None], np.zeros((1, 2)), coupling))
        change, allowed = float(np.max(np.abs(g - x))), motion.AGREED * float(np.sum(load.force))
        rounds += 1
        if change <= allowed or rounds == motion.ROUNDS:
            good = load.converged and moved.motion.status != "failed" and change <= allowed
            return CoupledBall(load, moved, good)
        joint = solve_loads_and_motion(cell, np.full(1, np.inf), bare) if rounds == PATIENCE else None
        if joint is not None and joint.reached_full_friction:
            push, drag = joint.ball_friction_forces, joint.screw_friction_forces
            displacements = joint.ball_displacements, joint.screw_displacements
        else:
            x = mixer.next_iterate(x, g)
            push, drag = x[:2].reshape(1, 2), x[2:]
            displacements = load.ball_displacements, load.inner_body_displacements
        with_friction = replace(cell, ball_friction_forces=push, screw_friction_forces=drag)
        load, start = motion.solve_screw_contact_loads(with_friction, displacements), moved.motion.unknown_velocities
