"""Lin's method for balls that may touch, at given contact loads, for comparison: root finding.

Numbers of sections and equations in this module are those of Lin's thesis (2019): 3.25 to 3.31 and 3.75 to 3.77.

The motion of every ball is computed separately first. Neighbours that are near enough to touch and approach each other then
count as touching. Each group of touching balls is one system of equations: the force balance of all its balls and equal
velocities of neighbours, with the ball-to-ball forces as further unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.friction.contact import laws
from rollbench.lowfi.friction.contact.equilibrium import HYBRID
from rollbench.meshes.arrays import Array, Index, Mask

#: Outcome of a search by Lin's method, see `BallMotionsByLin.status`.
Status = Literal["exact", "overlapping", "failed"]

#: Values accepted as zero: largest unbalanced force on a ball, divided by a ball's friction bound, and largest closing
#: speed of neighbours, divided by the nominal speed.
ACCEPTED = 1e-8

#: Newton's method for all balls without neighbours at once, from near motions: residual aimed at, and number of steps.
NEARBY, NEARBY_STEPS = 1e-13, 8

#: Sharpness k_S of Lin's sigmoid in searches for touching balls, for which his thesis prints no value.
SHARPNESS = 100.0


@dataclass(frozen=True)
class BallToBallContact:
    """Kinematics and friction of the contact of two neighbouring balls that touch.

    A ball has n unknowns of motion, the first of which is its motion along the track.
    """

    #: Velocity of the first ball's surface at its contact with the second ball, along two tangents, per unit of each of the
    #: first ball's unknowns ``(2, n)``.
    first_ball_surface_speeds: Array
    #: Velocity of the second ball's surface at its contact with the first ball, along the same tangents, per unit of each
    #: of the second ball's unknowns ``(2, n)``.
    second_ball_surface_speeds: Array
    #: Speed at which two balls approach each other, per unit of difference of their motions along the track (first
    #: unknowns).
    closing_speed_factor: float
    #: Coefficient of friction between two balls.
    mu: float
    #: Surface speed of a ball per unit of each unknown ``(n,)``, by which the unknowns are scaled.
    surface_speed_per_unit: Array
    #: Unknowns of a ball that rolls at the nominal contact angle ``(n,)``, from which searches begin.
    nominal_rolling_motion: Array

    @property
    def speed(self) -> float:
        """Nominal speed of a ball along the track [m/s]; 1 m/s for a track at rest, because speeds are divided by it."""
        return abs(float(self.nominal_rolling_motion[0] * self.surface_speed_per_unit[0])) or 1.0


@dataclass(frozen=True)
class LoadedBalls:
    """N balls in order along the track at given contact loads, with the kinematics of their contacts.

    A ball has four contacts and n unknowns of motion.
    """

    #: Contacts of all balls with the grooves, the four of each ball in succession ``(4 N,)``.
    contacts: laws.EllipticalContacts
    #: Sliding along x and z [m/s] and spin [rad/s] of each contact per unit of its ball's unknowns ``(N, 4, 3, n)``.
    contact_motion_maps: Array
    #: Sliding [m/s] and spin [rad/s] of each contact while the balls rest and the grooves move ``(N, 4, 3)``.
    imposed_contact_motions: Array
    #: Kinematics and friction of two neighbouring balls that touch.
    ball_to_ball_contact: BallToBallContact

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.contact_motion_maps.shape[0])

    @property
    def largest_friction_bound(self) -> float:
        """Largest sum of friction bounds (coefficient of friction times load) of the four contacts of a ball [N]."""
        return max(float(self.contacts.friction_bound.reshape(-1, 4).sum(axis=1).max()), 1e-300)

    def subset(self, chosen: Index) -> LoadedBalls:
        """Return some of the balls, given by their numbers, with their contacts."""
        at = self.contacts.take((4 * chosen[:, None] + np.arange(4)).ravel())
        maps, drives = self.contact_motion_maps[chosen], self.imposed_contact_motions[chosen]
        return LoadedBalls(at, maps, drives, self.ball_to_ball_contact)


@dataclass(frozen=True)
class BallForcesAndLosses:
    """Unbalanced forces, friction and losses of N balls in given motions, with n unknowns for each ball."""

    #: Unbalanced generalised forces on each ball ``(N, n)``, one for each of its n unknown speeds: power per unit of speed.
    unbalanced_forces: Array
    #: Friction on the balls along the axes x and z of each contact ``(N, 4, 2)`` [N].
    force: Array
    #: Moment of friction on the balls about the normal of each contact ``(N, 4)`` [N m].
    moment: Array
    #: Power lost in each contact with the grooves ``(N, 4)`` [W].
    groove_loss: Array
    #: Power lost between each ball and the next one ``(N-1,)`` [W].
    ball_loss: Array
    #: Direction in which ball k slides on ball k + 1, as unit vectors with components along two tangents of their contact
    #: ``(N-1, 2)``.
    sliding_directions: Array


@dataclass(frozen=True)
class BallMotionsByLin:
    """Motion of N balls by the method of Lin's thesis, with n unknowns for each ball."""

    #: Motions of the balls under the forces that touching balls exert on each other ``(N, n)``.
    ball_motions: Array
    #: Motions that the balls would have without forces on each other ``(N, n)``.
    motions_without_ball_forces: Array
    #: Force of each ball on the next one ``(N-1,)`` [N].
    ball_force: Array
    #: Power lost in each contact with the grooves ``(N, 4)`` [W].
    groove_loss: Array
    #: Power lost between each ball and the next one ``(N-1,)`` [W].
    ball_loss: Array
    #: Largest residual of the scaled equations: unbalanced force on a ball divided by the largest friction bound of a ball,
    #: or difference of the speeds of touching balls divided by the nominal speed.
    largest_residual: float
    #: Number of evaluations of the force balance in all searches by MINPACK.
    calls: int
    #: ``"exact"``: a root was found; ``"failed"``: no root was found; ``"overlapping"``: a root was found, but balls that
    #: do not count as touching approach each other, or touching balls pull each other. This may occur because the method
    #: decides first which balls touch (equation 3.31 of Lin's thesis).
    status: Status

    @property
    def loss(self) -> float:
        """Power lost by friction in all contacts, with the grooves and between balls [W]."""
        return float(self.groove_loss.sum() + self.ball_loss.sum())


def ball_forces_and_losses(balls: LoadedBalls, law: laws.FrictionLaw, q: Array, ball_force: Array) -> BallForcesAndLosses:
    """Return the unbalanced forces, friction and losses of N balls in given motions.

    ``balls``: the balls with their contacts; ``law``: friction law of the contacts with the grooves; ``q``: motions, n
    unknowns for each ball ``(N, n)``; ``ball_force``: force of each ball k on ball k + 1 ``(N-1,)`` [N].

    References
    ----------
    Lin (2019), 3.25 with 3.26 to 3.29, and 3.69 with 3.73 to 3.75.
    """
    n, pair = balls.count, balls.ball_to_ball_contact
    motion = balls.imposed_contact_motions + (balls.contact_motion_maps @ q[:, None, :, None])[..., 0]
    f = law(balls.contacts, motion.reshape(-1, 3))
    wrench = np.column_stack([f.force, f.moment]).reshape(n, 4, 3)
    left = np.einsum("ncr,ncrj->nj", wrench, balls.contact_motion_maps)
    slide = q[:-1] @ pair.first_ball_surface_speeds.T - q[1:] @ pair.second_ball_surface_speeds.T
    size = np.sqrt(np.sum(slide * slide, axis=1))
    rub = slide / np.where(size > 0.0, size, 1.0)[:, None]
    bite = pair.mu * ball_force
    left[:-1, 0] -= pair.closing_speed_factor * ball_force
    left[1:, 0] += pair.closing_speed_factor * ball_force
    left[:-1] -= bite[:, None] * (rub @ pair.first_ball_surface_speeds)
    left[1:] += bite[:, None] * (rub @ pair.second_ball_surface_speeds)
    return BallForcesAndLosses(left, wrench[..., :2], wrench[..., 2], f.loss.reshape(n, 4), bite * size, rub)


def index_ranges_of_touching_groups(touching: Mask) -> list[slice]:
    """Return the index range of each group of touching balls; a ball that touches no other one forms a group of one.

    ``touching``: whether each ball touches the next one ``(N-1,)``.
    """
    ends = [0, *(np.flatnonzero(~touching) + 1).tolist(), touching.size + 1]
    return [slice(a, b) for a, b in pairwise(ends)]


def solve_touching_group(
    balls: LoadedBalls, law: laws.FrictionLaw, q: Array, ball_force: Array
) -> tuple[Array, Array, float, int]:
    """Return the motions of a group of N touching balls and the forces between them, from one system of equations.

    The scaled equations are solved by MINPACK's hybrid method with a Jacobian by finite differences, as by Matlab's
    fsolve. ``balls``: the balls of this group; ``law``: friction law of their contacts with the grooves; ``q``: motions
    from which the search starts, n unknowns for each ball ``(N, n)``; ``ball_force``: forces of each ball on the next
    one from which the search starts ``(N-1,)`` [N].

    Returns
    -------
    tuple
        Motions ``(N, n)``; forces of each ball on the next one ``(N-1,)`` [N]; largest residual of the scaled equations, to
        be compared with ``ACCEPTED``; number of evaluations.
    """
    n, pair, bound = balls.count, balls.ball_to_ball_contact, balls.largest_friction_bound
    turn = pair.surface_speed_per_unit / pair.speed

    def motions_and_forces(x: Array) -> tuple[Array, Array]:
        """Return motions ``(N, n)``, then ball-to-ball forces ``(N-1,)`` [N], converted from the scaled unknowns x."""
        return x[: q.size].reshape(q.shape) / turn, x[q.size :] * bound

    def residual(x: Array) -> Array:
        """Return the scaled unbalanced forces on the balls, then the differences of the speeds of neighbours."""
        motions, forces = motions_and_forces(x)
        left = ball_forces_and_losses(balls, law, motions, forces).unbalanced_forces / (pair.surface_speed_per_unit * bound)
        return np.append(left.ravel(), np.diff(x[: q.size].reshape(q.shape)[:, 0]))

    start = np.append((q * turn).ravel(), ball_force[: n - 1] / bound)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        solution = root(residual, start, method="hybr", options=HYBRID)
        worst = float(np.max(np.abs(solution.fun)))
    return *motions_and_forces(solution.x), worst if np.isfinite(worst) else np.inf, int(solution.nfev)


def solve_single_balls_nearby(balls: LoadedBalls, law: laws.FrictionLaw, q: Array) -> tuple[Array, Array]:
    """Return motions ``(N, n)`` of balls without neighbours by Newton's method from near ones, and residuals ``(N,)``.

    All balls are solved at the same time, with a Jacobian by finite differences of the steps that MINPACK takes. Residuals
    are scaled as in `solve_touching_group`. ``balls``: N balls; ``law``: friction law of their contacts with the grooves;
    ``q``: motions from which the search starts ``(N, n)``.
    """
    pair, (count, n) = balls.ball_to_ball_contact, q.shape
    turn, contacts = pair.surface_speed_per_unit / pair.speed, balls.contacts.take(np.tile(np.arange(4 * count), n + 1))
    unit = pair.surface_speed_per_unit * balls.contacts.friction_bound.reshape(count, 4).sum(axis=1)[:, None]

    def residuals(x: Array) -> Array:
        """Return the scaled unbalanced forces on the balls at n + 1 scaled motions of each ``(n + 1, N, n)``."""
        motion = balls.imposed_contact_motions + (balls.contact_motion_maps @ (x / turn)[:, :, None, :, None])[..., 0]
        f = law(contacts, motion.reshape(-1, 3))
        wrench = np.column_stack([f.force, f.moment]).reshape(motion.shape)
        return np.asarray(np.einsum("tkcr,kcrj->tkj", wrench, balls.contact_motion_maps) / unit)

    x = q * turn
    best, worst = x, np.full(count, np.inf)
    for _ in range(NEARBY_STEPS):
        step = np.sqrt(np.finfo(float).eps) * np.where(x != 0.0, np.abs(x), 1.0)
        at, *moved = residuals(x + np.concatenate([np.zeros((1, count, n)), np.eye(n)[:, None] * step]))
        size = np.abs(at).max(axis=1)
        best, worst = np.where((size < worst)[:, None], x, best), np.fmin(size, worst)
        if worst.max() <= NEARBY:
            break
        jacobian = (np.stack(moved, axis=-1) - at[..., None]) / step[:, None, :]
        x = x - (np.linalg.pinv(jacobian) @ at[..., None])[..., 0]
    return best / turn, worst


def solve_touching_groups(
    balls: LoadedBalls, law: laws.FrictionLaw, touching: Mask, start: tuple[Array, Array], nearby: bool = False
) -> tuple[Array, Array, float, int]:
    """Return the motions of N balls and the forces between them, for known pairs of touching balls.

    Each group of touching balls is solved separately. ``balls``: the balls; ``law``: friction law of the contacts with
    the grooves; ``touching``: whether each ball touches the next one ``(N-1,)``; ``start``: motions, n unknowns for
    each ball ``(N, n)``, and forces of each ball on the next one ``(N-1,)`` [N], from which the search starts;
    ``nearby``: whether ``start`` is near the solution, as the instant before: balls that touch no other one are then
    solved together by Newton's method, and by MINPACK only where this fails.

    Returns
    -------
    tuple
        Motions ``(N, n)``; forces of each ball on the next one ``(N-1,)`` [N]; largest residual of all groups; number of
        evaluations.
    """
    q, force = start[0].copy(), np.zeros(balls.count - 1)
    groups, worst, calls = index_ranges_of_touching_groups(touching), 0.0, 0
    single = np.array([group.start for group in groups if group.stop - group.start == 1], dtype=int)
    if nearby and single.size:
        motions, residuals = solve_single_balls_nearby(balls.subset(single), law, start[0][single])
        done = residuals <= NEARBY
        q[single[done]] = motions[done]
        solved = set(single[done].tolist())
        groups = [group for group in groups if group.stop - group.start > 1 or group.start not in solved]
    for group in groups:
        inner, chosen = slice(group.start, group.stop - 1), np.arange(group.start, group.stop)
        found = solve_touching_group(balls.subset(chosen), law, start[0][group], start[1][inner])
        q[group], force[inner], left, further = found
        worst, calls = max(worst, left), calls + further
    return q, force, worst, calls


def neighbours_not_separating(pair: BallToBallContact, q: Array, tolerance: float = 0.0) -> Mask:
    """Return whether each ball approaches the next one or keeps its distance from it ``(N-1,)``.

    ``pair``: kinematics of touching balls; ``q``: motions of the balls, n unknowns each ``(N, n)``; ``tolerance``: least
    speed of approach for which the result is True, as a fraction of the nominal speed; with 0, it is also True for
    neighbours of equal speed.
    """
    rate = (q[:-1, 0] - q[1:, 0]) * pair.surface_speed_per_unit[0] / pair.speed
    return np.asarray(rate >= tolerance)


def status_of_solution(
    pair: BallToBallContact, residual: float, q: Array, ball_force: Array, friction_bound: float, near_but_apart: Mask
) -> Status:
    """Return the outcome of a search by Lin's method, as explained at `BallMotionsByLin.status`.

    ``pair``: kinematics of touching balls; ``residual``: largest residual of the scaled equations; ``q``: motions of the
    balls ``(N, n)``; ``ball_force``: force of each ball on the next one ``(N-1,)`` [N]; ``friction_bound``: largest
    friction bound of a ball [N]; ``near_but_apart``: whether each ball is near enough to the next one to touch it, but does
    not count as touching it ``(N-1,)``.
    """
    if not residual <= ACCEPTED:
        return "failed"
    pulls = np.any(ball_force < -ACCEPTED * friction_bound)
    return "overlapping" if pulls or np.any(near_but_apart & neighbours_not_separating(pair, q, ACCEPTED)) else "exact"


def solve_motions_of_balls_by_root(
    balls: LoadedBalls,
    law: laws.FrictionLaw,
    may_touch: Mask,
    start: Array | None = None,
    touching: tuple[Array, Array] | None = None,
    nearby: bool = False,
) -> BallMotionsByLin:
    """Return the motions of a row of balls and the forces between them by the method of Lin's thesis.

    The status of the result is "failed" for a friction law with which the equations have no root, such as Coulomb's if
    a contact sticks. Lin's text does not say from which motions the searches start.

    Parameters
    ----------
    balls
        The N balls.
    law
        Friction law of the contacts with the grooves.
    may_touch
        Whether each ball is near enough to the next one to touch it ``(N-1,)``.
    start
        Motions ``(N, n)`` from which the search for balls without forces between them starts; None: nominal rolling.
    touching
        Motions ``(N, n)`` and forces ``(N-1,)`` [N] from which the search for touching balls starts; None: the motions
        found for balls without forces between them, and no forces.
    nearby
        Whether the starts are near the solution, see `solve_touching_groups`.
    """
    pair = balls.ball_to_ball_contact
    none = np.zeros(balls.count - 1)
    first = np.tile(pair.nominal_rolling_motion, (balls.count, 1)) if start is None else np.asarray(start, dtype=float)
    free, _, left, calls = solve_touching_groups(balls, law, none > 0.0, (first, none), nearby)
    touch = np.asarray(may_touch, dtype=bool) & neighbours_not_separating(pair, free)
    q, force = free, none
    if left <= ACCEPTED and np.any(touch):
        begin = (free, none) if touching is None else touching
        q, force, left, further = solve_touching_groups(balls, law, touch, begin, nearby)
        calls += further
    balanced = ball_forces_and_losses(balls, law, q, force)
    status = status_of_solution(pair, left, q, force, balls.largest_friction_bound, may_touch & ~touch)
    return BallMotionsByLin(q, free, force, balanced.groove_loss, balanced.ball_loss, left, calls, status)
