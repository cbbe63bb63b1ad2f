"""Contact loads of a ball screw in agreement with the friction of its moving balls (section 3.4.1 of Lin's thesis).

Friction and ball-to-ball forces in the plane of the groove's section change the contact loads, and changed loads change the
friction. Loads and friction are solved in turn in accelerated rounds (`search_coupled_chain`). Friction that wedges a ball
between grooves changes the loads by many times as much as it changes itself, so that these rounds run away. Loads and
friction are then solved as one system (`solve_loads_and_motion`), in which the contact angles follow the ball's position.
Its solution is followed from zero friction, strongly smoothed, to the full friction, hardly smoothed, by the arc length of
its path: at a fold no state is near any more in which balls and screw could stay as friction rises. A real ball moves on
there until it is held again, while the path turns back and, past the unstable states, rises once more, through the
states in which a ball is held again. The answer is the state at the end of the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import ContactLoadSolution
from rollbench.lowfi.friction.contact.normal_force import ON_INNER, normal_forces
from rollbench.lowfi.friction.screw import joint
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.balance import REACH
from rollbench.lowfi.friction.screw.chain import (
    SPEEDS,
    ChainMotion,
    screw_ball_chain,
    search_motion_of_chain,
    solve_motion_of_chain,
)
from rollbench.lowfi.friction.screw.joint import LoadsAndMotionSystem, LoadsAndMotionUnknowns
from rollbench.lowfi.friction.screw.path import ON_PATH, PathPoint, follow_path
from rollbench.lowfi.together import Search
from rollbench.meshes.arrays import Array

#: Number of rounds, in which contact loads and friction are solved in turn, after which both are solved as one system.
PATIENCE = 26

#: Residual aimed at at both ends of a path of loads and friction, over the largest friction bound of a ball; largest number
#: of Newton steps there, and along one path.
COUPLED_GOAL, COUPLED_STEPS, MOST = 1e-13, 80, 2000

#: Longest Newton step of positions, as a fraction of the distance of groove centre and ball centre.
LONGEST_STEP = 0.1


@dataclass(frozen=True)
class IterationStart:
    """Friction forces and motions of N balls from which the iteration of contact loads and friction begins."""

    #: Forces of friction and neighbours on the balls along x3, z3 ``(N, 2)`` [N].
    ball_friction_forces: Array
    #: Forces of friction on the screw along each of the m motions in which it is free ``(m,)`` [N]; not used where friction
    #: does not move the screw.
    screw_friction_forces: Array
    #: Motions of the balls: orbit and rotations about x3, y3, z3 ``(N, 4)`` [rad/s].
    ball_motions: Array
    #: Force of ball k on ball k + 1 ``(N,)`` [N].
    ball_force: Array


def solve_loads_and_motion(
    cell: screw_motion.BallsBetweenGrooves, slack: Array, start: tuple[Array, Array]
) -> tuple[IterationStart, tuple[Array, Array]] | None:
    """Return contact loads and motion of balls with friction, solved as one system of equations.

    The result holds friction forces, motions and forces between the balls, then the displacements of the balls ``(N, 2)``
    and of the screw ``(m,)`` [m]; None if the search does not arrive at the full friction.

    The search begins at positions in balance without friction and raises friction step by step. Where several states
    exist, the result is the one to which the path of solutions leads from the state without friction, round its folds.

    Parameters
    ----------
    cell
        Balls between screw and nut with the external loads; its forces of friction (``ball_friction_forces``,
        ``screw_friction_forces``) are not used, because they are unknown.
    slack
        Largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s], inf where
        they cannot touch.
    start
        Displacements of the balls ``(N, 2)`` and of the screw ``(m,)`` [m] in balance without friction; m: number of
        motions in which the screw is free.
    """
    bare = replace(
        cell,
        ball_friction_forces=np.zeros_like(cell.ball_friction_forces),
        screw_friction_forces=np.zeros_like(cell.screw_friction_forces),
    )
    smooth, sharp = float(np.log(SPEEDS[0])), float(np.log(SPEEDS[-1]))
    laws = ((0.0, smooth), (1.0, smooth)), ((1.0, smooth), (1.0, sharp))
    system = LoadsAndMotionSystem.at_positions(bare, slack, *start)
    moved, s = solve_motion_of_chain(system.search.chain), system.search
    at = LoadsAndMotionUnknowns(*start, moved.q * s.units / s.speed, moved.ball_force / s.bound)
    here = _LoadsAndMotionPoint(system, laws[0], at, 0.0)
    for law in laws:
        here = _LoadsAndMotionPoint(here.system, law, here.unknowns, 0.0).polished()
        here, done, _ = follow_path(here, MOST) if here.now.size <= ON_PATH else (here, False, 0)
        if not done:
            return None
    here = here.polished()
    if here.now.size > ON_PATH:
        return None
    (p, u, x, f), s = here.unknowns, here.system.search
    F, _, n, _ = normal_forces(here.system.arrays, p, u)
    push = F[..., None] * n
    on_screw = push[:, ON_INNER].sum(axis=1)
    drag = -cell.external_screw_force - np.einsum("kim,ki->m", cell.section_displacement_maps, on_screw)
    return IterationStart(push.sum(axis=1), drag, x * s.speed / s.units, f * s.bound), (p, u)


class _LoadsAndMotionPoint(PathPoint):
    """Equations of loads and motion on the path along which friction rises or its regularising speed falls."""

    def __init__(
        self,
        system: LoadsAndMotionSystem,
        law: tuple[tuple[float, float], tuple[float, float]],
        unknowns: LoadsAndMotionUnknowns,
        way: float,
    ) -> None:
        """Compute the equations at some unknowns and a part of the way.

        ``law``: at the beginning and at the end of the path, the fraction of the friction that acts on the loads, and the
        natural logarithm of the regularising speed over the nut's speed along the path.
        """
        self.system, self.law, self.unknowns = system, law, unknowns
        self.point = np.append(unknowns.in_units(system.position_unit), way)
        share, log_speed = (a + way * (b - a) for a, b in zip(*law, strict=True))
        self.now = joint.loads_and_motion_equations(system, unknowns, share, float(np.exp(log_speed)))
        self.residual = self.now.residual

    def at(self, point: Array) -> _LoadsAndMotionPoint:
        """Return the equations at another point ``(7 N + m + 1,)``."""
        unknowns = LoadsAndMotionUnknowns.from_units(point[:-1], self.system.search.count, self.system.position_unit)
        return _LoadsAndMotionPoint(self.system, self.law, unknowns, float(point[-1]))

    def solve(self, sides: Array) -> Array:
        """Solve the linear system with the Jacobian for c right-hand sides ``(7 N + m, c)``."""
        return joint.solve_linear_equations(self.system, self.unknowns, self.now, sides)

    def rescaled(self) -> tuple[_LoadsAndMotionPoint, Array]:
        """Return the same state in the scales of its contact loads, and the old units of the point over the new ones."""
        old, slack = self.system, self.system.search.chain.allowed_closing_rate
        new = LoadsAndMotionSystem.at_positions(old.cell, slack, self.unknowns.ball, self.unknowns.screw)
        force = self.unknowns.ball_force * (old.force_unit / new.force_unit)
        unknowns = self.unknowns._replace(ball_force=force)
        return _LoadsAndMotionPoint(new, self.law, unknowns, float(self.point[-1])), old.units / new.units

    def polished(self) -> _LoadsAndMotionPoint:
        """Return the solution near this point at its part of the way, by Newton's method.

        Steps are halved until the residual falls. Where no solution is found, the residual of the returned point is large.
        """
        here, reach = self, self.system.arrays.groove_ball_centre_distance
        for _ in range(COUPLED_STEPS):
            if here.now.size <= COUPLED_GOAL:
                break
            step = joint.newton_step(self.system, here.unknowns, here.now)
            moved = max(float(np.abs(step.ball).max()), float(np.abs(step.screw).max(initial=0.0)))
            turned = float(np.abs(step.motion).max())
            length = min(1.0, REACH / max(turned, 1e-300), LONGEST_STEP * reach / max(moved, 1e-300))
            for _ in range(30):
                trial = _LoadsAndMotionPoint(
                    self.system, self.law, here.unknowns.moved(step, length), float(self.point[-1])
                )
                if trial.now.size < (1.0 - 0.1 * length) * here.now.size:
                    break
                length *= 0.5
            else:
                break
            here = trial
        return here


@dataclass(frozen=True)
class CoupledChainSolution:
    """Contact loads and motion of the balls of a track, with the loads in balance with the friction of this motion."""

    #: Contact loads without friction. If friction may not move the screw, the screw stays at its position in this solution.
    loads_without_friction: ContactLoadSolution
    #: Contact loads with friction.
    loads_with_friction: ContactLoadSolution
    #: Motion of the balls, friction on them and ball-to-ball forces.
    motion: ChainMotion
    #: Largest change, in the last round, of a friction force that acts on the contact loads [N].
    last_friction_change: float
    #: Number of rounds in which contact loads and friction were solved in turn.
    rounds: int
    #: Whether ``last_friction_change`` is negligible (at most ``AGREED`` times the sum of contact loads), and the forces
    #: are in balance for contact loads and for ball motions.
    converged: bool


def search_coupled_chain(
    cell: screw_motion.BallsBetweenGrooves,
    slack: Array,
    coupling: screw_motion.Coupling,
    similar: CoupledChainSolution | None = None,
    rounds: int = screw_motion.ROUNDS,
    guess: IterationStart | None = None,
) -> Search[CoupledChainSolution]:
    """Return contact loads and motion of N balls, with the loads in balance with friction and ball-to-ball forces.

    The solution is not always unique: a ball that bears little or no load without friction may either be loose or be
    wedged between the grooves by its own friction. Which of these states is found depends on where the search begins.

    Parameters
    ----------
    cell
        Balls between screw and nut, with the external loads.
    slack
        Largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s], inf where
        they cannot touch.
    coupling
        What friction and ball-to-ball forces may change. ``"none"``: nothing; ``"ball"``: the contact loads of the balls,
        while the screw stays where it is without these forces (section 3.4.1 of Lin's thesis); ``"ball and screw"``: also
        the position of the screw, which is then in equilibrium with these forces.
    similar
        Solution of a similar chain from which the search begins; None to begin from loads without friction.
    rounds
        Largest number of rounds, in each of which the loads are solved at given friction, then the friction at these loads.
    guess
        Forces and motions to begin from, in place of those of ``similar``; None to use these.

    Returns
    -------
    CoupledChainSolution
        The solution; if no agreement is found, its ``converged`` is False.
    """
    bare = yield from screw_motion.search_screw_contact_loads(
        cell, None if similar is None else similar.loads_without_friction.displacements
    )
    held = screw_motion.balls_with_fixed_screw(cell, bare) if coupling == "ball" else cell
    m = held.screw_displacement_maps.shape[2]
    if guess is None:
        guess = _starting_forces_and_motion(held, coupling, similar)
    push, drag, start = guess.ball_friction_forces, guess.screw_friction_forces[:m], (guess.ball_motions, guess.ball_force)
    place, mixer, count = (
        (bare.ball_displacements, bare.inner_body_displacements[:m]),
        screw_motion.AndersonAcceleration(),
        0,
    )
    while True:
        same_push = np.array_equal(push, cell.ball_friction_forces)
        if held is cell and same_push and np.array_equal(drag, cell.screw_friction_forces):
            load = bare
        else:
            load = yield from screw_motion.search_screw_contact_loads(
                replace(held, ball_friction_forces=push, screw_friction_forces=drag), place
            )
        balls = screw_ball_chain(cell.groove, load.force, cell.groove.normals(load.angle), slack)
        moved = yield from search_motion_of_chain(balls, start)
        new_push, new_drag = screw_motion.friction_on_balls_and_screw(
            held, moved.wrench, moved.neighbour_forces[:, [0, 2]], coupling
        )
        x, g = np.append(push, drag), np.append(new_push, new_drag)
        change, count = float(np.max(np.abs(g - x))), count + 1
        agreed = change <= screw_motion.AGREED * float(np.sum(load.force))
        if agreed or count == rounds:
            return CoupledChainSolution(bare, load, moved, change, count, agreed and load.converged and moved.converged)
        if count == PATIENCE:
            both = solve_loads_and_motion(held, slack, (bare.ball_displacements, bare.inner_body_displacements[:m]))
            if both is not None:
                of, place = both
                push, drag, start = of.ball_friction_forces, of.screw_friction_forces, (of.ball_motions, of.ball_force)
                continue
        x = mixer.next_iterate(x, g)
        push, drag = x[: push.size].reshape(push.shape), x[push.size :]
        # no friction on a ball without load: what the mixer makes of it would push the ball about
        push = np.where(np.any(moved.wrench != 0.0, axis=(1, 2))[:, None], push, new_push)
        place, start = load.displacements, (moved.q, moved.ball_force)


def _starting_forces_and_motion(
    cell: screw_motion.BallsBetweenGrooves, coupling: screw_motion.Coupling, near: CoupledChainSolution | None
) -> IterationStart:
    """Return the friction forces and motions from which the iteration of contact loads and friction begins.

    ``cell``: balls between screw and nut; ``coupling``: what friction may change; ``near``: solution of a similar
    chain, whose friction and motions are returned. If ``near`` is None, the forces are those of ``cell`` and all
    motions are zero.
    """
    n = cell.angle.shape[0]
    if near is None:
        return IterationStart(cell.ball_friction_forces, cell.screw_friction_forces, np.zeros((n, 4)), np.zeros(n))
    push, drag = cell.ball_friction_forces, cell.screw_friction_forces
    if coupling != "none":
        neighbour_forces = near.motion.neighbour_forces[:, [0, 2]]
        push, drag = screw_motion.friction_on_balls_and_screw(cell, near.motion.wrench, neighbour_forces, coupling)
    return IterationStart(push, drag, near.motion.q, near.motion.ball_force)
