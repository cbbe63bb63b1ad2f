"""Lin's method for a ball screw, for comparison: root finding of contact loads, of balls, and of balls over time.

Numbers of sections and equations in this module are those of Lin's thesis (2019); the method is described in section 3.4.

Contact loads without friction: the unknowns are the position of each ball in its groove section (2), its contact angles
gamma (4), and the screw's motions. For a rigid screw, this is the state of chapter 2 (equations 2.11 to 2.25), which is
searched by the hybrid method.

Contact loads coupled with friction (sections 3.4.1 and 3.4.2): loads and motion of balls are the root of one system. The
unknowns of a ball, named above equation 3.71, are its position in the groove section (2), its contact angles gamma (4) and
its motion (4); two touching balls add the force between them. The loads without friction and the screw's position are
computed first, and this position is then held.

A whole ball screw over time (section 3.4.4): in each step the loads are found as a root, then the motion of every ball
separately, then the motion of groups of balls which are near enough to touch and approach each other (equation 3.77). The
positions advance with these speeds. The method does not prevent negative gaps; the property
`ScrewHistoryByLin.largest_overlap` gives the largest overlap of balls.

To count failures, the root is searched from several starts: from rolling balls, and from random deviations from rollbench's
own solution. Every search yields the motion that it found, or None if Lin's method finds no contact loads to begin with.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from rollbench.lowfi.as_source import balls as lin
from rollbench.lowfi.friction.contact.equilibrium import HYBRID, ContactLoadSolution
from rollbench.lowfi.friction.contact.laws import FrictionLaw, SigmoidLaw
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.chain import ChainMotion, ScrewBallChain, solve_motion_of_chain
from rollbench.lowfi.friction.screw.groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove
from rollbench.lowfi.friction.screw.run import Pair, Run, ScrewPairSolution, balls_at_instant
from rollbench.lowfi.hertz import contact_force
from rollbench.meshes.arrays import Array, Mask


@dataclass(frozen=True)
class BallPositions:
    """Displacements and contact angles of N balls between their grooves, and displacement of the screw in m motions."""

    #: Displacement of the balls along x3, z3 ``(N, 2)`` [m].
    ball_displacements: Array
    #: Contact angles gamma of the balls ``(N, 4)`` [rad].
    contact_angles: Array
    #: Displacement of the screw in each of its m motions ``(m,)`` [m].
    screw_displacements: Array


def contact_loads_at_positions(
    cell: screw_motion.BallsBetweenGrooves, positions: BallPositions
) -> tuple[Array, Array, Array]:
    """Return the contact loads of N balls in given positions, and the residuals of the conditions for the contact angles.

    Loads and residuals follow from the contact conditions in chapter 2 of Lin's thesis: at the contact angle gamma, the
    tangent of the groove is perpendicular to the line of centres. ``cell``: the balls and their grooves; ``positions``:
    positions of balls and screw.

    Returns
    -------
    tuple
        Contact loads ``(N, 4)`` [N]; scalar product of the line of centres and the groove's tangent, divided by the
        distance of the centres, which is zero if the contact angle satisfies its condition ``(N, 4)``; unit normals of
        the contacts ``(N, 4, 2)``.
    """
    g, c, s = cell.groove, np.cos(positions.contact_angles), np.sin(positions.contact_angles)
    screw = (cell.section_displacement_maps @ positions.screw_displacements + cell.given_screw_displacement)[:, None, :]
    line = g.groove_ball_centre_distance * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    line = line + positions.ball_displacements[:, None, :] - np.where(ON_SCREW[:, None], screw, 0.0)
    normal, tangent = np.stack([SIGN_X * c, SIGN_Z * s], axis=-1), np.stack([-SIGN_X * s, SIGN_Z * c], axis=-1)
    approach = np.sum(line * normal, axis=-1) - g.groove_ball_centre_distance + cell.interference
    miss = np.sum(line * tangent, axis=-1) / g.groove_ball_centre_distance
    return contact_force(approach, g.contact_hertz_constants.C), miss, normal


def load_per_ball_and_its_approach(cell: screw_motion.BallsBetweenGrooves) -> tuple[float, float]:
    """Return the load on the screw per ball [N], then the approach of a ball and a groove under this load [m].

    Forces and displacements in the equations of `solve_contact_loads_by_root` are divided by these values.
    """
    share = max(float(np.linalg.norm(cell.external_screw_force)) / cell.angle.shape[0], 1e-300)
    return share, float(np.max(cell.groove.contact_hertz_constants.C)) * share ** (2.0 / 3.0)


def starting_positions(cell: screw_motion.BallsBetweenGrooves) -> BallPositions:
    """Return the positions of balls and screw from which Lin's search for the contact loads starts.

    The screw is displaced along its load by four times the approach of a ball under an equal part of the load on the
    screw, plus the clearance; the balls are displaced half as far. The nominal state, from which Lin's text starts, has
    no stiffness without preload. The function `solve_screw_contact_loads` starts from the same positions if ``cell``
    gives no displacement of the screw in addition to its free motions. ``cell``: the balls and their grooves.
    """
    total, (_, size) = float(np.linalg.norm(cell.external_screw_force)), load_per_ball_and_its_approach(cell)
    size += max(0.0, -float(np.min(cell.interference)))
    screw = np.zeros(cell.external_screw_force.size) if total == 0.0 else 4.0 * size * cell.external_screw_force / total
    at_balls = cell.section_displacement_maps @ screw + cell.given_screw_displacement
    return BallPositions(0.5 * at_balls, cell.angle.copy(), screw)


def solve_contact_loads_by_root(
    cell: screw_motion.BallsBetweenGrooves, start: BallPositions | None = None
) -> ContactLoadSolution:
    """Return the contact loads of N balls without friction, as the root of 6 N + m equations for a screw with m motions.

    The unknowns are two coordinates and four contact angles of each ball, and the screw's displacements. ``start``:
    positions from which the search starts; None: `starting_positions`. In the result, ``largest_unbalanced_force`` is
    the largest force out of balance [N], ``steps`` the number of evaluations of the equations, and ``converged`` is
    False if no root was found.
    """
    n = cell.angle.shape[0]
    scale, size = load_per_ball_and_its_approach(cell)
    at = starting_positions(cell) if start is None else start

    def positions_from_unknowns(x: Array) -> BallPositions:
        """Return positions of balls and screw from the scaled unknowns x."""
        return BallPositions(x[: 2 * n].reshape(n, 2) * size, x[2 * n : 6 * n].reshape(n, 4), x[6 * n :] * size)

    def residual(x: Array) -> Array:
        """Return the residuals of the equations: scaled forces on the balls, contact conditions, forces on the screw."""
        force, bent, normal = contact_loads_at_positions(cell, positions_from_unknowns(x))
        pull = force[..., None] * normal
        on_screw = np.einsum("nim,ni->m", cell.section_displacement_maps, pull[:, ON_SCREW].sum(axis=1))
        on_screw = on_screw + cell.external_screw_force + cell.screw_friction_forces
        on_balls = cell.ball_friction_forces - pull.sum(axis=1)
        return np.concatenate([(on_balls / scale).ravel(), bent.ravel(), on_screw / (n * scale)])

    x = np.concatenate([(at.ball_displacements / size).ravel(), at.contact_angles.ravel(), at.screw_displacements / size])
    solution = root(residual, x, method="hybr", options=HYBRID)
    places = positions_from_unknowns(solution.x)
    force, _, _ = contact_loads_at_positions(cell, places)
    left = float(np.max(np.abs(solution.fun))) * scale
    good = left <= lin.ACCEPTED * (scale * n + float(force.sum()))
    return ContactLoadSolution(
        force, places.contact_angles, places.ball_displacements, places.screw_displacements, left, int(solution.nfev), good
    )


def ball_to_ball_contact_of_screw(groove: ScrewGroove) -> lin.BallToBallContact:
    """Return kinematics and friction of touching balls of a screw, on the exact helix.

    The unknowns of a ball are its angular speeds omega_B around the axis and omega_x, omega_y, omega_z [rad/s]. The exact
    helix corrects equations 3.73 to 3.75 of Lin's thesis.
    """
    p, r = groove.pair, groove.ball_radius
    return lin.BallToBallContact(
        p.first_ball_surface_speeds,
        p.second_ball_surface_speeds,
        p.closing_speed_factor,
        groove.ball_to_ball_mu,
        np.array([groove.radius, r, r, r]),
        least_sliding_motion(groove),
    )


def least_sliding_motion(groove: ScrewGroove) -> Array:
    """Return the motion of a ball that slides least at its four contacts at the nominal contact angle ``(4,)`` [rad/s].

    The four values are the angular speeds omega_B around the axis and omega_x, omega_y, omega_z. Searches start from this
    motion, which is an assumption, because Lin's text does not say where they start.
    """
    maps, drives = groove.contact_kinematics(groove.normals(np.full(4, groove.contact_angle)))
    units = np.array([groove.radius, *[groove.ball_radius] * 3])
    x = np.linalg.lstsq((maps[:, :2] / units).reshape(8, 4), -drives[:, :2].ravel(), rcond=None)[0]
    return np.asarray(x / units)


def balls_of_screw(groove: ScrewGroove, force: Array, angle: Array) -> lin.LoadedBalls:
    """Return N balls of a screw at given contact loads, with the kinematics of their contacts.

    ``force``: contact loads ``(N, 4)`` [N]; ``angle``: contact angles ``(N, 4)`` [rad], both in the order SL, SR, NL, NR
    (screw or nut, left or right).
    """
    maps, drives = groove.contact_kinematics(groove.normals(angle))
    ellipses = screw_motion.contact_ellipses_of_screw(groove, force)
    return lin.LoadedBalls(ellipses, maps, drives, ball_to_ball_contact_of_screw(groove))


@dataclass(frozen=True)
class BallStateByLin:
    """Positions, contact loads and motions of N balls, as a start or result of searches by the method of Lin's thesis."""

    #: Positions of balls and screw, with the contact angles.
    positions: BallPositions
    #: Forces at the contacts of the balls with the grooves ``(N, 4)`` [N].
    contact_forces: Array
    #: Motions of the balls: orbit and three rotations ``(N, 4)`` [rad/s].
    ball_motions: Array
    #: Force of each ball on the next one ``(N-1,)`` [N].
    ball_force: Array
    #: Largest residual of the scaled equations of the search: unbalanced forces, contact conditions, and speed differences
    #: of touching balls; 0 for a state that was not searched.
    largest_residual: float
    #: Number of evaluations of the equations in the search.
    calls: int


@dataclass(frozen=True)
class ScrewSolutionByLin:
    """Contact loads and motions of N balls of a screw by the method of Lin's thesis."""

    #: Contact forces with friction ``(N, 4)`` [N].
    force: Array
    #: Contact angles with friction ``(N, 4)`` [rad].
    angle: Array
    #: Motions of the balls under friction, and forces between touching balls.
    motion: lin.BallMotionsByLin


def solve_loads_and_motion_of_group(
    cell: screw_motion.BallsBetweenGrooves, law: FrictionLaw, start: BallStateByLin, reference_load: float
) -> BallStateByLin:
    """Return contact loads and motions of N touching balls from one system of equations, with the screw fixed.

    The equations are 3.71 and 3.75 to 3.77 of Lin's thesis. ``cell``: the balls and their grooves; ``law``: friction
    law; ``start``: state from which the search starts, which also gives the position of the screw; ``reference_load``:
    sum of the contact loads of one ball [N], a scale by which forces are divided.
    """
    g, pair = cell.groove, ball_to_ball_contact_of_screw(cell.groove)
    n, turn = cell.angle.shape[0], pair.surface_speed_per_unit / pair.speed
    size, bound = float(np.max(g.contact_hertz_constants.C)) * reference_load ** (2.0 / 3.0), g.mu * reference_load or 1.0

    def positions_motions_and_forces(x: Array) -> tuple[BallPositions, Array, Array]:
        """Return positions, then motions, then forces between the balls, from the scaled unknowns x."""
        by_ball = x[: 10 * n].reshape(n, 10)
        positions = BallPositions(by_ball[:, :2] * size, by_ball[:, 2:6], start.positions.screw_displacements)
        return positions, by_ball[:, 6:] / turn, x[10 * n :] * bound

    def residual(x: Array) -> Array:
        """Return the residuals of the scaled equations of all balls, then the differences of the speeds of neighbours."""
        if not np.all(np.isfinite(x)):
            return np.full_like(x, 1e3)
        places, q, between = positions_motions_and_forces(x)
        force, bent, normal = contact_loads_at_positions(cell, places)
        rolling = lin.ball_forces_and_losses(balls_of_screw(g, force, places.contact_angles), law, q, between)
        normals = g.normals(places.contact_angles)
        friction = screw_motion.friction_wrench_at_contacts(normals, rolling.force, rolling.moment)[..., [0, 2]]
        pull = cell.ball_friction_forces + (friction - force[..., None] * normal).sum(axis=1)
        bite = (pair.mu * between)[:, None] * rolling.sliding_directions
        pull[:-1] += (between[:, None] * g.pair.force_directions[0] - bite @ g.pair.tangent_directions[0])[:, [0, 2]]
        pull[1:] += (between[:, None] * g.pair.force_directions[1] + bite @ g.pair.tangent_directions[1])[:, [0, 2]]
        unbalanced = rolling.unbalanced_forces / (pair.surface_speed_per_unit * bound)
        equations = np.concatenate([pull / reference_load, bent, unbalanced], axis=1)
        return np.append(equations.ravel(), np.diff(q[:, 0]) * turn[0])

    at = start.positions
    unknowns = np.concatenate([at.ball_displacements / size, at.contact_angles, start.ball_motions * turn], axis=1)
    x = np.append(unknowns.ravel(), start.ball_force / bound)
    solution = root(residual, x, method="hybr", options=HYBRID)
    at, q, between = positions_motions_and_forces(solution.x)
    force, _, _ = contact_loads_at_positions(cell, at)
    return BallStateByLin(at, force, q, between, float(np.max(np.abs(solution.fun))), int(solution.nfev))


def solve_loads_and_motion_of_groups(
    cell: screw_motion.BallsBetweenGrooves, law: FrictionLaw, touching: Mask, start: BallStateByLin, reference_load: float
) -> BallStateByLin:
    """Return contact loads and motions of all N balls for known pairs of touching balls, with the screw fixed.

    Each group of touching balls is solved separately. ``cell``: the balls and their grooves; ``law``: friction law;
    ``touching``: whether each ball touches the next one ``(N-1,)``; ``start``: state of all balls from which the
    searches start; ``reference_load``: sum of the contact loads of one ball [N], a scale by which forces are divided.
    """
    n = cell.angle.shape[0]
    ball = start.positions.ball_displacements.copy()
    gamma = start.positions.contact_angles.copy()
    q = start.ball_motions.copy()
    force, between, left, calls = np.zeros((n, 4)), np.zeros(n - 1), 0.0, 0
    for group in lin.index_ranges_of_touching_groups(touching):
        inner = slice(group.start, group.stop - 1)
        group_cell = replace(
            cell,
            angle=cell.angle[group],
            interference=cell.interference[group],
            screw_displacement_maps=cell.screw_displacement_maps[group],
            given_screw_displacement=cell.given_screw_displacement[group],
            ball_friction_forces=cell.ball_friction_forces[group],
        )
        at = BallPositions(ball[group], gamma[group], start.positions.screw_displacements)
        begin = BallStateByLin(at, force[group], q[group], start.ball_force[inner], 0.0, 0)
        solved = solve_loads_and_motion_of_group(group_cell, law, begin, reference_load)
        ball[group] = solved.positions.ball_displacements
        gamma[group] = solved.positions.contact_angles
        force[group] = solved.contact_forces
        q[group], between[inner] = solved.ball_motions, solved.ball_force
        left, calls = max(left, solved.largest_residual), calls + solved.calls
    return BallStateByLin(BallPositions(ball, gamma, start.positions.screw_displacements), force, q, between, left, calls)


def lin_start_from_rollbench_solution(result: ScrewPairSolution, touching: bool) -> BallStateByLin:
    """Return rollbench's solution for two balls of a screw as a state from which searches by Lin's method start.

    ``result``: solution by rollbench; ``touching``: True for its state with contact of the two balls with each other, False
    for its state without.
    """
    solution = result.touching if touching else result.apart
    at = BallPositions(solution.loads_with_friction.ball_displacements, solution.loads_with_friction.angle, np.zeros(0))
    return BallStateByLin(at, solution.loads_with_friction.force, solution.motion.q, solution.motion.ball_force[:1], 0.0, 0)


def solve_motion_of_separate_balls(
    cell: screw_motion.BallsBetweenGrooves, load: ContactLoadSolution, law: FrictionLaw
) -> BallStateByLin:
    """Return the motions of balls that do not touch each other, at contact loads without friction.

    The motions are found by a search from nominal rolling. Searches for loads and motion together start from this state
    if no other start is given. ``cell``: the balls and their grooves; ``load``: their contact loads without friction;
    ``law``: friction law.
    """
    n, pair = cell.angle.shape[0], ball_to_ball_contact_of_screw(cell.groove)
    none, first = np.zeros(n - 1), np.tile(pair.nominal_rolling_motion, (n, 1))
    balls = balls_of_screw(cell.groove, load.force, load.angle)
    q, _, left, calls = lin.solve_touching_groups(balls, law, none > 0.0, (first, none))
    return BallStateByLin(BallPositions(load.ball_displacements, load.angle, np.zeros(0)), load.force, q, none, left, calls)


def solve_loads_and_motion_by_root(
    cell: screw_motion.BallsBetweenGrooves,
    load: ContactLoadSolution,
    may_touch: Mask,
    law: FrictionLaw,
    start: BallStateByLin | None = None,
    touching: BallStateByLin | None = None,
) -> ScrewSolutionByLin:
    """Return the contact loads and motions of N balls whose friction changes their contact loads, by Lin's method.

    Balls that approach each other when they are computed separately form groups that touch (equations 3.76 and 3.77 of
    Lin's thesis). Lin's text does not say where the searches start.

    Parameters
    ----------
    cell, load
        The balls with their grooves, and their contact loads without friction.
    may_touch
        Whether each ball is near enough to the next one to touch it ``(N-1,)``.
    law
        Friction law.
    start
        State from which the search for balls without contact with each other starts; None: their motion at the contact
        loads without friction.
    touching
        State from which the search for touching balls starts; None: the result for balls without contact with each other.
    """
    held, pair = screw_motion.balls_with_fixed_screw(cell, load), ball_to_ball_contact_of_screw(cell.groove)
    scale = max(float(load.force.sum(axis=1).max()), 1e-300)
    begin = solve_motion_of_separate_balls(cell, load, law) if start is None else start
    none = np.zeros(cell.angle.shape[0] - 1)
    free = solved = solve_loads_and_motion_of_groups(held, law, none > 0.0, replace(begin, ball_force=none), scale)
    calls = begin.calls + free.calls
    touch = np.asarray(may_touch, dtype=bool) & lin.neighbours_not_separating(pair, free.ball_motions)
    if free.largest_residual <= lin.ACCEPTED and np.any(touch):
        solved = solve_loads_and_motion_of_groups(held, law, touch, free if touching is None else touching, scale)
        calls += solved.calls
    balls = balls_of_screw(cell.groove, solved.contact_forces, solved.positions.contact_angles)
    sums = lin.ball_forces_and_losses(balls, law, solved.ball_motions, solved.ball_force)
    left, q, between = solved.largest_residual, solved.ball_motions, solved.ball_force
    status = lin.status_of_solution(pair, left, q, between, cell.groove.mu * scale, may_touch & ~touch)
    motion = lin.BallMotionsByLin(q, free.ball_motions, between, sums.groove_loss, sums.ball_loss, left, calls, status)
    return ScrewSolutionByLin(solved.contact_forces, solved.positions.contact_angles, motion)


def solve_screw_pair_by_root(
    pair: Pair, law: FrictionLaw | None = None, start: BallStateByLin | None = None, touching: BallStateByLin | None = None
) -> ScrewSolutionByLin:
    """Return the loads and motions of two balls of a screw that are near enough to touch, by Lin's method (section 3.4.3).

    The contact loads without friction are found first. If the coupling of the pair is "none", the motion is solved at these
    loads, otherwise loads and motion together. ``law``: friction law; None: Lin's sigmoid with the sharpness ``SHARPNESS``.
    ``start``, ``touching``: states from which the searches for balls without and with contact with each other start; None
    as in `solve_loads_and_motion_by_root`.

    Raises
    ------
    ValueError
        The coupling "ball and screw", which Lin does not have.
    RuntimeError
        No loads are found.
    """
    if pair.coupling == "ball and screw":
        raise ValueError(
            'Lin\'s method for two balls: coupling (effect of friction) must be "none" or "ball" (the contact loads), '
            'got "ball and screw": the method keeps the screw in its position without friction'
        )
    cell = pair.balls_with_loads()
    law = screw_motion.lin_sigmoid_law(pair.groove, lin.SHARPNESS) if law is None else law
    load, reach = solve_contact_loads_by_root(cell), np.array([True])
    if not load.converged:
        raise RuntimeError(
            f"root finding of the contact loads failed: {load.largest_unbalanced_force:.1e} N are out of balance after "
            f"{load.steps} evaluations"
        )
    if pair.coupling == "ball":
        return solve_loads_and_motion_by_root(cell, load, reach, law, start, touching)
    balls, first = balls_of_screw(pair.groove, load.force, load.angle), None if start is None else start.ball_motions
    second = None if touching is None else (touching.ball_motions, touching.ball_force)
    motion = lin.solve_motions_of_balls_by_root(balls, law, reach, first, second)
    return ScrewSolutionByLin(load.force, load.angle, motion)


@dataclass(frozen=True)
class ScrewHistoryByLin:
    """Simulation over time of N balls of a screw by Lin's method in T steps.

    Ball k pushes ball k + 1; the last one pushes the first.
    """

    #: Angle of the nut at the beginning of each step ``(T,)`` [rad].
    nut_angle: Array
    #: Gap between each ball and the next one at the end of each step, as an azimuth ``(T, N)`` [rad]; zero if the two
    #: touch, negative if they overlap.
    gap: Array
    #: Force of each ball on the next one ``(T, N)`` [N].
    ball_force: Array
    #: Angular speed of each ball's centre about the axis, relative to the screw ``(T, N)`` [rad/s].
    omega: Array
    #: Friction torque due to losses at the contacts of balls and grooves ``(T,)`` [N m].
    groove_torque: Array
    #: Friction torque due to losses at the contacts between balls ``(T,)`` [N m].
    ball_torque: Array
    #: Status of the solution for the motion in each step (`BallMotionsByLin.status`); ``"failed"`` also if no contact loads
    #: were found. After a failure the speeds of the previous step continue.
    status: tuple[str, ...]

    @property
    def failed_step_count(self) -> int:
        """Number of steps for which no root was found."""
        return self.status.count("failed")

    @property
    def overlapping_step_count(self) -> int:
        """Number of steps with an impossible root: separate balls approach, or touching balls pull each other."""
        return self.status.count("overlapping")

    @property
    def largest_overlap(self) -> float:
        """Largest angle by which two neighbouring balls overlap, over all steps [rad]; 0 without overlap."""
        return max(0.0, -float(self.gap.min()))


@dataclass
class _PreviousStep:
    """Positions, motions and forces of N balls in the previous time step, from which searches start."""

    #: Positions of balls and screw in the previous step.
    positions: BallPositions
    #: Motions that the balls would have without forces on each other ``(N, 4)`` [rad/s].
    motions_without_ball_forces: Array
    #: Motions of the balls under the forces that they exert on each other ``(N, 4)`` [rad/s].
    ball_motions: Array
    #: Force of each ball on the next one ``(N,)`` [N].
    force: Array


def simulate_by_root(run: Run, steps: int | None = None) -> ScrewHistoryByLin:
    """Return the first time steps of a transient simulation of a screw by Lin's method with his sigmoid friction law.

    The balls are spread evenly at the beginning. Every search starts from the result of the previous step, the first one
    from nominal rolling; this is an assumption, because Lin's text does not say where they start.

    Parameters
    ----------
    run
        Ball screw with the settings of its simulation.
    steps
        Number of time steps to simulate; None: all steps of ``run``.

    Raises
    ------
    ValueError
        ``run`` has a return tube, or friction is to change its contact loads: this simulation covers neither.
    """
    if run.tube > 0.0 or run.coupling != "none":
        raise ValueError(
            "a simulation by Lin's method needs a track without return tube (tube = 0) and contact loads without influence "
            'of friction (coupling = "none")'
        )
    g, n, dt = run.groove, run.count, run.duration / run.steps
    law = screw_motion.lin_sigmoid_law(g, lin.SHARPNESS)
    azimuth = run.ring * (np.arange(n) + run.first) / n - np.pi * run.turns
    gap = np.full(n, run.ring / n - g.pair.spacing)
    before: _PreviousStep | None = None
    omega, rows, status = np.zeros(n), list[tuple[Array, Array, Array, float, float]](), list[str]()
    for k in range(steps or run.steps):
        turned = g.speed * dt * k
        azimuths, loaded = run.fold_into_track(azimuth, turned)
        cell = balls_at_instant(run, azimuths, loaded, turned)
        load = solve_contact_loads_by_root(cell, None if before is None else before.positions)
        at = BallPositions(load.ball_displacements, load.angle, load.inner_body_displacements)
        motion, order = _solve_motion_of_step(run, load.force, load.angle, gap <= 0.0, law, before)
        good = load.converged and motion.status != "failed"
        force, q, free = np.zeros(n), np.empty((n, 4)), np.empty((n, 4))
        force[order[:-1]] = motion.ball_force
        q[order] = motion.ball_motions
        free[order] = motion.motions_without_ball_forces
        if good:
            before, omega = _PreviousStep(at, free, q, force), q[:, 0] - g.screw_speed
        gap = gap + dt * (np.roll(omega, -1) - omega)
        speed = abs(g.speed)
        rows.append((gap, force, omega, float(motion.groove_loss.sum()) / speed, float(motion.ball_loss.sum()) / speed))
        status.append(motion.status if good else "failed")
        azimuth = azimuth + dt * omega
    gaps, forces, speeds, groove, ball = (np.array(c, dtype=float) for c in zip(*rows, strict=True))
    nut_angle = np.array([g.speed * dt * k for k in range(len(rows))])
    return ScrewHistoryByLin(nut_angle, gaps, forces, speeds, groove, ball, tuple(status))


def _solve_motion_of_step(
    run: Run, force: Array, angle: Array, may_touch: Mask, law: FrictionLaw, previous: _PreviousStep | None
) -> tuple[lin.BallMotionsByLin, NDArray[np.intp]]:
    """Return the motion of the balls in one time step, and the indices of the balls in the order of this motion ``(N,)``.

    The order begins after a ball that cannot touch the next one: there the ring of balls is cut open. ``force`` [N],
    ``angle`` [rad]: contact loads and angles ``(N, 4)``; ``may_touch``: whether each ball is near enough to the next one to
    touch it ``(N,)``; ``law``: friction law; ``previous``: state in the previous step, from which the searches start, None
    for nominal rolling. Raises RuntimeError if every ball may touch the next one.
    """
    if np.all(may_touch):
        raise RuntimeError(
            "the motion of the balls cannot be solved because every ball touches the next one; leave at least one gap"
        )
    order = np.roll(np.arange(run.count), -int(np.argmin(may_touch)) - 1)
    balls = balls_of_screw(run.groove, force[order], angle[order])
    near = may_touch[order[:-1]]
    if previous is None:
        return lin.solve_motions_of_balls_by_root(balls, law, near), order
    free = previous.motions_without_ball_forces[order]
    touching = (previous.ball_motions[order], previous.force[order[:-1]])
    motion = lin.solve_motions_of_balls_by_root(balls, law, near, free, touching, nearby=True)
    return (motion if motion.status != "failed" else lin.solve_motions_of_balls_by_root(balls, law, near, free)), order


def randomly_perturbed_motions(q: Array, units: Array, rng: np.random.Generator, largest_deviation: float) -> Array:
    """Return motions of N balls with random relative deviations, from which searches start.

    ``q``: motions, n unknowns for each ball ``(N, n)``; ``units``: surface speed per unit of each unknown ``(n,)``;
    ``rng``: generator of random numbers; ``largest_deviation``: largest deviation of an unknown, as a fraction of its
    value or, if this is more, of 1 % of the ball's largest surface speed. The result has the shape of ``q``.
    """
    x = q * units
    size = np.maximum(np.abs(x), 0.01 * np.max(np.abs(x), axis=1, keepdims=True))
    return np.asarray((x + largest_deviation * rng.uniform(-1.0, 1.0, q.shape) * size) / units)


def linear_solutions_from_starts(
    bearing: LinearBearing, angles: Array, loads: Array, rng: np.random.Generator, count: int, largest_deviation: float
) -> Iterator[lin.BallMotionsByLin]:
    """Yield motions of N balls of a linear bearing by Lin's method, from nominal rolling and then from random starts.

    All neighbours are near enough to touch. The random starts are motions that deviate from the solution by rollbench,
    and the ball-to-ball forces of this solution multiplied by random factors from 0 to 2.

    Parameters
    ----------
    bearing
        The linear bearing.
    angles
        Contact angles, ``(N, 4)`` [rad].
    loads
        Contact loads, ``(N, 4)`` [N].
    rng
        Generator of the random numbers.
    count
        Number of random starts.
    largest_deviation
        Largest relative deviation of each motion of a start from the motion in the solution by rollbench
        (`randomly_perturbed_motions`).
    """
    apart, together = (
        solve_motion_of_chain(prepare_linear_chain(bearing, angles, loads, touching)) for touching in (False, True)
    )
    balls = lin.balls_of_linear_bearing(bearing, angles, loads)
    law = lin.linear_bearing_friction_law(bearing, lin.SHARPNESS) if bearing.speed else SigmoidLaw(lin.SHARPNESS, 1.0)
    reach, units = np.ones(balls.count - 1, dtype=bool), balls.ball_to_ball_contact.surface_speed_per_unit
    motions = [r.q[:, [0, 3, 1]] for r in (apart, together)]
    yield lin.solve_motions_of_balls_by_root(balls, law, reach)
    for _ in range(count):
        free, near = (randomly_perturbed_motions(q, units, rng, largest_deviation) for q in motions)
        force = together.ball_force[:-1] * rng.uniform(0.0, 2.0, balls.count - 1)
        yield lin.solve_motions_of_balls_by_root(balls, law, reach, free, (near, force))


def sigmoid_of_moving_or_resting_screw(groove: ScrewGroove, sharpness: float = lin.SHARPNESS) -> SigmoidLaw:
    """Return Lin's sigmoid friction law for a screw, also for a screw at rest.

    For a screw at rest the reference spin of the sigmoid would be zero; it is then set to 1 rad/s.

    Parameters
    ----------
    groove
        Grooves and balls of a screw.
    sharpness
        Sharpness k_S of the sigmoid.
    """
    return screw_motion.lin_sigmoid_law(groove, sharpness) if groove.speed else SigmoidLaw(sharpness, 1.0)


def pair_solutions_from_starts(
    pair: Pair, solved: ScrewPairSolution, rng: np.random.Generator, count: int, largest_deviation: float
) -> Iterator[lin.BallMotionsByLin | None]:
    """Yield motions of two balls of a screw by Lin's method, from nominal rolling and then from random starts.

    None is yielded where the method finds no contact loads. The random starts are states that deviate from the solution by
    rollbench.

    Parameters
    ----------
    pair
        Two balls of a screw.
    solved
        Solution of the pair by rollbench.
    rng
        Generator of the random numbers.
    count
        Number of random starts.
    largest_deviation
        Largest relative deviation of each motion of a start from the motion in the solution by rollbench
        (`randomly_perturbed_motions`).
    """
    free = lin_start_from_rollbench_solution(solved, False)
    touching = lin_start_from_rollbench_solution(solved, True)
    units = ball_to_ball_contact_of_screw(pair.groove).surface_speed_per_unit
    starts: list[tuple[BallStateByLin | None, BallStateByLin | None]] = [(None, None)]
    for _ in range(count):
        force = touching.ball_force * rng.uniform(0.0, 2.0, 1)
        q_near = randomly_perturbed_motions(touching.ball_motions, units, rng, largest_deviation)
        q_free = randomly_perturbed_motions(free.ball_motions, units, rng, largest_deviation)
        starts.append((replace(free, ball_motions=q_free), replace(touching, ball_motions=q_near, ball_force=force)))
    for start in starts:
        try:
            yield solve_screw_pair_by_root(pair, sigmoid_of_moving_or_resting_screw(pair.groove), *start).motion
        except RuntimeError:
            yield None


def chain_motions_from_random_starts(
    chain: ScrewBallChain, angle: Array, solved: ChainMotion, rng: np.random.Generator, count: int, largest_deviation: float
) -> Iterator[lin.BallMotionsByLin]:
    """Yield motions of an open chain of balls of a screw by Lin's method, from nominal rolling and then from random starts.

    The contact loads are known. Only neighbours without a gap count as near enough to touch: if a gap closes within a
    time step, the balls come into contact in the method of rollbench, but overlap in Lin's.

    Parameters
    ----------
    chain
        Open chain of balls.
    angle
        Contact angles, ``(N, 4)`` [rad].
    solved
        Solution of the chain by rollbench.
    rng
        Source of the random starts.
    count
        Number of random starts.
    largest_deviation
        Largest relative deviation of each motion of a start from the motion in the solution by rollbench
        (`randomly_perturbed_motions`).
    """
    alone = solve_motion_of_chain(replace(chain, allowed_closing_rate=np.full(chain.allowed_closing_rate.shape, np.inf)))
    balls, law = balls_of_screw(chain.groove, chain.force, angle), sigmoid_of_moving_or_resting_screw(chain.groove)
    reach, units = chain.allowed_closing_rate[:-1] <= 0.0, balls.ball_to_ball_contact.surface_speed_per_unit
    yield lin.solve_motions_of_balls_by_root(balls, law, reach)
    for _ in range(count):
        free, near = (randomly_perturbed_motions(q, units, rng, largest_deviation) for q in (alone.q, solved.q))
        force = solved.ball_force[:-1] * rng.uniform(0.0, 2.0, solved.ball_force.size - 1)
        yield lin.solve_motions_of_balls_by_root(balls, law, reach, free, (near, force))
