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
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import ContactLoadSolution
from rollbench.lowfi.friction.contact.normal_force import ON_INNER, BallContactArrays, normal_forces
from rollbench.lowfi.friction.screw import joint
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.chain import (
    SPEEDS,
    BalanceSearch,
    ChainMotion,
    screw_ball_chain,
    search_motion_of_chain,
    solve_motion_of_chain,
)
from rollbench.lowfi.friction.screw.groove import scaled_groove
from rollbench.lowfi.friction.screw.joint import LoadsAndMotionSystem, LoadsAndMotionUnknowns
from rollbench.lowfi.friction.screw.path import ON_PATH, PathPoint, follow_path
from rollbench.lowfi.friction.together import Search
from rollbench.meshes.arrays import Array

#: Number of rounds, in which contact loads and friction are solved in turn, after which both are solved as one system.
PATIENCE = 26

#: Residual aimed at at both ends of a path of loads and friction, over the largest friction bound of a ball; largest number
#: of Newton steps there, and along one path.
COUPLED_GOAL, COUPLED_STEPS, MOST = 1e-13, 80, 2000


@dataclass(frozen=True)
class LoadsAndMotionSolution:
    """Positions, motions and forces of N balls and the screw, with contact loads and friction solved as one system."""

    #: Displacements of the balls along x3, z3 ``(N, 2)`` [m].
    ball_displacements: Array
    #: Displacement of the screw along each of the m motions in which it is free ``(m,)`` [m].
    screw_displacements: Array
    #: Motions of the balls: orbit and rotations about x3, y3, z3 ``(N, 4)`` [rad/s].
    q: Array
    #: Force of ball k on ball k + 1 ``(N,)`` [N].
    ball_force: Array
    #: Forces along x3, z3 that friction and neighbours exert on each ball, balanced by its contact loads ``(N, 2)`` [N].
    ball_friction_forces: Array
    #: Forces of friction on the screw along each of its m motions, balanced by the contact loads ``(m,)`` [N].
    screw_friction_forces: Array
    #: Whether the search arrived at the full friction; if not, the other fields hold the state in which it ended.
    reached_full_friction: bool
    #: Number of Newton steps.
    steps: int


def solve_loads_and_motion(
    cell: screw_motion.BallsBetweenGrooves, slack: Array, start: tuple[Array, Array]
) -> LoadsAndMotionSolution:
    """Return contact loads and motion of balls with friction, solved as one system of equations.

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
    scales = _Scales.at_positions(bare, slack, screw_motion.arrays_for_contact_loads(bare), *start)
    moved, s = solve_motion_of_chain(scales.search.chain), scales.search
    at = LoadsAndMotionUnknowns(*start, moved.q * s.units / s.speed, moved.ball_force / s.bound)
    here, steps, done = _LoadsAndMotionPoint(scales, laws[0], at, 0.0), 0, True
    for law in laws:
        here, done, used = _LoadsAndMotionPoint(here.scales, law, here.unknowns, 0.0).polished()
        steps += used
        if done:
            here, done, used = follow_path(here, MOST)
            steps += used
        if not done:
            break
    else:
        here, done, used = here.polished()
        steps += used
    (p, u, x, f), s = here.unknowns, here.scales.search
    F, _, n, _ = normal_forces(here.scales.arrays, p, u)
    push = F[..., None] * n
    on_screw = push[:, ON_INNER].sum(axis=1)
    drag = -cell.external_screw_force - np.einsum("kim,ki->m", cell.section_displacement_maps, on_screw)
    return LoadsAndMotionSolution(p, u, x * s.speed / s.units, f * s.bound, push.sum(axis=1), drag, done, steps)


def loads_and_motion_system(
    arrays: BallContactArrays, cell: screw_motion.BallsBetweenGrooves, search: BalanceSearch
) -> LoadsAndMotionSystem:
    """Return the data with which contact loads and motions of balls are solved as one system of equations.

    ``arrays``: geometry and loads of the balls ``cell`` between screw and nut; ``search``: arrays of the chain of these
    balls, scaled at the present contact loads.
    """
    pair, total = cell.groove.pair, float(search.chain.force[search.loaded].sum())
    length = float(np.max(cell.groove.contact_hertz_constants.C)) * max(total, 1e-30) ** (2.0 / 3.0)
    return LoadsAndMotionSystem(
        cell=arrays,
        groove=scaled_groove(cell.groove),
        balls=search.balls,
        groove_mu=cell.groove.mu or 1.0,
        force_unit=search.bound,
        position_unit=length,
        ball_force_directions=pair.force_directions[:, [0, 2]],
        tangent_directions=pair.tangent_directions[..., [0, 2]],
        screw_displacement_maps=cell.screw_displacement_maps,
    )


class _Scales(NamedTuple):
    """System of equations of loads and motion of some balls, scaled at given contact loads."""

    #: Balls between screw and nut.
    cell: screw_motion.BallsBetweenGrooves
    #: Largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s].
    slack: Array
    #: Geometry and loads of the balls in ``cell``.
    arrays: BallContactArrays
    #: Chain of the balls under these contact loads, and its scales.
    search: BalanceSearch
    #: The system.
    system: LoadsAndMotionSystem

    @classmethod
    def at_positions(
        cls, cell: screw_motion.BallsBetweenGrooves, slack: Array, arrays: BallContactArrays, ball: Array, screw: Array
    ) -> _Scales:
        """Return the system scaled at the contact loads after displacements of balls and screw [m]."""
        at = normal_forces(arrays, ball, screw)
        search = BalanceSearch(screw_ball_chain(cell.groove, at.force, np.insert(at.normal, 1, 0.0, axis=-1), slack))
        return cls(cell, slack, arrays, search, loads_and_motion_system(arrays, cell, search))

    @property
    def units(self) -> Array:
        """Units of all unknowns of the system and of the part of the way ``(7 N + m + 1,)``."""
        n, m = self.slack.size, self.cell.screw_displacement_maps.shape[2]
        length, force = self.system.position_unit, self.system.force_unit
        unknowns = LoadsAndMotionUnknowns(np.ones((n, 2)), np.ones(m), np.ones((n, 4)), np.full(n, force))
        return np.append(unknowns.in_units(1.0 / length), 1.0)


class _LoadsAndMotionPoint(PathPoint):
    """Equations of loads and motion on the path along which friction rises or its regularising speed falls."""

    def __init__(
        self,
        scales: _Scales,
        law: tuple[tuple[float, float], tuple[float, float]],
        unknowns: LoadsAndMotionUnknowns,
        way: float,
    ) -> None:
        """Compute the equations at some unknowns and a part of the way.

        ``law``: at the beginning and at the end of the path, the fraction of the friction that acts on the loads, and the
        natural logarithm of the regularising speed over the nut's speed along the path.
        """
        self.scales, self.law, self.unknowns = scales, law, unknowns
        self.point = np.append(unknowns.in_units(scales.system.position_unit), way)
        share, log_speed = (a + way * (b - a) for a, b in zip(*law, strict=True))
        self.share, self.speed = share, float(np.exp(log_speed))
        self.now = joint.loads_and_motion_equations(scales.system, unknowns, self.share, self.speed)
        self.residual = self.now.residual

    def at(self, point: Array) -> _LoadsAndMotionPoint:
        """Return the equations at another point ``(7 N + m + 1,)``."""
        unit = self.scales.system.position_unit
        unknowns = LoadsAndMotionUnknowns.from_units(point[:-1], self.scales.slack.size, unit)
        return _LoadsAndMotionPoint(self.scales, self.law, unknowns, float(point[-1]))

    def solve(self, sides: Array) -> Array:
        """Solve the linear system with the Jacobian for c right-hand sides ``(7 N + m, c)``."""
        return joint.solve_linear_equations(self.scales.system, self.unknowns, self.now, sides)

    def rescaled(self) -> tuple[_LoadsAndMotionPoint, Array]:
        """Return the same state in the scales of its contact loads, and the old units of the point over the new ones."""
        old = self.scales
        new = _Scales.at_positions(old.cell, old.slack, old.arrays, self.unknowns.ball, self.unknowns.screw)
        force = self.unknowns.ball_force * (old.search.bound / new.search.bound)
        unknowns = self.unknowns._replace(ball_force=force)
        return _LoadsAndMotionPoint(new, self.law, unknowns, float(self.point[-1])), old.units / new.units

    def polished(self) -> tuple[_LoadsAndMotionPoint, bool, int]:
        """Return the solution near this point at its part of the way, whether there is one, and the number of steps."""
        found, left, used = joint.solve_loads_and_motion_by_newton(
            self.scales.system, self.unknowns, self.share, self.speed, COUPLED_GOAL, COUPLED_STEPS
        )
        return _LoadsAndMotionPoint(self.scales, self.law, found, float(self.point[-1])), left <= ON_PATH, used


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
            if both.reached_full_friction:
                push, drag = both.ball_friction_forces, both.screw_friction_forces
                place, start = (both.ball_displacements, both.screw_displacements), (both.q, both.ball_force)
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
