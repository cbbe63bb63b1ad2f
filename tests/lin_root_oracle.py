"""Lin's method where only tests use it: loads coupled with friction in a screw, and balls of a linear bearing.

Numbers of sections and equations are those of Lin's thesis (2019). Contact loads coupled with friction (sections 3.4.1 and
3.4.2): loads and motion of balls are the root of one system. The unknowns of a ball, named above equation 3.71, are its
position in the groove section (2), its contact angles gamma (4) and its motion (4); two touching balls add the force
between them. The loads without friction and the screw's position are computed first, and this position is then held.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.as_source import balls as lin
from rollbench.lowfi.as_source.screw import (
    BallPositions,
    ball_to_ball_contact_of_screw,
    balls_of_screw,
    contact_loads_at_positions,
    solve_contact_loads_by_root,
)
from rollbench.lowfi.friction.contact import laws
from rollbench.lowfi.friction.contact.equilibrium import HYBRID, ContactLoadSolution
from rollbench.lowfi.friction.contact.laws import FrictionLaw
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.run import Pair, ScrewPairSolution
from rollbench.meshes.arrays import Array, Mask

#: Unknowns of a ball of a linear bearing in Lin's thesis, among the four of `StraightTrack`: its speed v along the track
#: [m/s] and its angular speeds omega_x and omega_y about the two axes across the track [rad/s].
ACROSS = [0, 3, 1]


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


def balls_of_linear_bearing(bearing: LinearBearing, angles: Array, loads: Array) -> lin.LoadedBalls:
    """Return N balls of a linear bearing with the kinematics of their contacts, by equations 3.22 to 3.29 of Lin's thesis.

    ``bearing``: the bearing with its speed; ``angles``: contact angles ``(N, 4)`` [rad]; ``loads``: normal loads ``(N, 4)``
    [N], both in the order BL, BR, TR, TL (bottom or top, left or right). Raises ValueError if a load is negative.
    """
    chain = prepare_linear_chain(bearing, angles, loads)
    track, rubs = chain.groove, chain.friction_contacts
    first, second = track.pair.first_ball_surface_speeds[:, ACROSS], track.pair.second_ball_surface_speeds[:, ACROSS]
    units, nominal = track.levers[ACROSS], track.nominal_motion[ACROSS]
    between = lin.BallToBallContact(first, second, track.pair.closing_speed_factor, bearing.mu_balls, units, nominal)
    at = laws.contacts_from_values(rubs.a.ravel(), rubs.b.ravel(), chain.force.ravel(), bearing.mu)
    return lin.LoadedBalls(at, rubs.maps[..., ACROSS], rubs.drives, between)


def linear_bearing_friction_law(bearing: LinearBearing, sharpness: float | None = lin.SHARPNESS) -> FrictionLaw:
    """Return the sigmoid friction law of equation 3.20 of Lin's thesis for a linear bearing, or Coulomb's law.

    ``bearing``: bearing with carriage speed v, contact angle beta and ball radius R_B; ``sharpness``: factor k_S of the
    sigmoid; None: Coulomb's law. The reference spin of the sigmoid is the nominal spin v tan(beta)/(2 R_B). This is an
    assumption: equation 3.25 contains no sigmoid, and the reference for rotary bearings, the difference of the spins of
    both rings, is zero between grooves that do not turn.
    """
    if sharpness is None:
        return laws.CoulombLaw()
    return laws.SigmoidLaw(sharpness, 0.5 * abs(bearing.speed) * float(np.tan(bearing.contact_angle)) / bearing.ball_radius)
