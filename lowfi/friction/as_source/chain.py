"""Lin's method for balls that may touch, at given loads, for comparison: a root (Lin 3.25-3.31, 3.75-3.77).

First every ball separately; neighbours in reach that approach then count as touching; each group of touching balls is one
system of equations: force balance of all, equal velocities of neighbours, with the ball-to-ball forces as unknowns.

Balls in a linear bearing (Lin 3.3.1, 3.3.2) are chains too: a root at given loads.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.friction.contact.laws import Contacts, Coulomb, Law, Sigmoid, equal_contacts
from rollbench.lowfi.friction.contact.motion import HYBRID
from rollbench.lowfi.friction.linear.bearing import MOVING, LinearBearing, contact_directions, semi_axes
from rollbench.lowfi.friction.linear.chain import pair_angles_and_loads
from rollbench.meshes.arrays import Array, Mask

Status = Literal["exact", "overlapping", "failed"]

#: Force out of balance over a ball's friction bound, and closing speed over the nominal, that count as none.
ACCEPTED = 1e-8

#: k_S of the source's sigmoid in its searches for touching balls, for which the text prints none.
SHARPNESS = 100.0


@dataclass(frozen=True)
class NeighbourInteraction:
    """Forces between touching balls, with n unknowns of motion a ball, the first of them along the track."""

    #: Sliding of the first ball's surface at the contact by its motion ``(2, n)`` [m].
    first: Array
    #: Likewise of the second ball.
    second: Array
    #: Closing velocity per difference of the first unknowns.
    closing: float
    #: Coefficient of friction.
    mu: float
    #: Surface speed per unknown ``(n,)``.
    units: Array
    #: Motion to start from ``(n,)``.
    nominal: Array

    @property
    def speed(self) -> float:
        """Nominal speed along the track [m/s], one at rest."""
        return abs(float(self.nominal[0] * self.units[0])) or 1.0


@dataclass(frozen=True)
class Balls:
    """N balls in order at given loads."""

    #: Contacts ``(4 N,)``.
    at: Contacts
    #: Motion of the contacts by the unknowns ``(N, 4, 3, n)``.
    maps: Array
    #: Motion of the contacts without them ``(N, 4, 3)``.
    drives: Array
    #: Forces between neighbours.
    pair: NeighbourInteraction

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.maps.shape[0])

    @property
    def bound(self) -> float:
        """Largest friction bound of a ball [N]."""
        return max(float(self.at.strength.reshape(-1, 4).sum(axis=1).max()), 1e-300)

    def subset(self, chosen: slice) -> Balls:
        """Return some of the balls."""
        rows = slice(4 * chosen.start, 4 * chosen.stop)
        at = Contacts(self.at.a[rows], self.at.b[rows], self.at.load[rows], self.at.mu[rows])
        return Balls(at, self.maps[chosen], self.drives[chosen], self.pair)


@dataclass(frozen=True)
class Balance:
    """Forces and losses of N balls in given motions."""

    #: Generalised forces out of balance ``(N, n)`` [W per unknown].
    left: Array
    #: Friction on the balls along the contacts' x and z ``(N, 4, 2)`` [N].
    force: Array
    #: ``(N, 4)`` [N m].
    moment: Array
    #: ``(N, 4)`` [W].
    groove_loss: Array
    #: ``(N-1,)`` [W].
    ball_loss: Array
    #: Direction in which ball k slides on ball k + 1 ``(N-1, 2)``.
    rub: Array


@dataclass(frozen=True)
class SourceMotion:
    """Motion of N balls by Lin's method."""

    #: Motions ``(N, n)``.
    q: Array
    #: Motions before contact ``(N, n)``.
    free: Array
    #: ``(N-1,)`` [N].
    ball_force: Array
    #: ``(N, 4)`` [W].
    groove_loss: Array
    #: ``(N-1,)`` [W].
    ball_loss: Array
    #: Largest force out of balance over the friction bound.
    left: float
    #: Calls of the balance.
    calls: int
    #: ``"exact"``, ``"failed"`` (no root), or ``"overlapping"``: a root whose neighbours approach nevertheless or pull at
    #: each other, since what touches was decided before (Lin 3.31).
    status: Status

    @property
    def loss(self) -> float:
        """Total dissipation [W]."""
        return float(self.groove_loss.sum() + self.ball_loss.sum())


def force_balance(balls: Balls, law: Law, q: Array, ball_force: Array) -> Balance:
    """Return balance of N balls in motions q ``(N, n)`` under a friction law and forces ``(N-1,)`` [N] of ball k on k + 1.

    References
    ----------
    Lin (2019), 3.25 with 3.26 to 3.29, and 3.69 with 3.73 to 3.75.
    """
    n, pair = balls.count, balls.pair
    motion = balls.drives + (balls.maps @ q[:, None, :, None])[..., 0]
    f = law.friction(balls.at, motion.reshape(-1, 3), True)
    wrench = np.column_stack([f.force, f.moment]).reshape(n, 4, 3)
    left = np.einsum("ncr,ncrj->nj", wrench, balls.maps)
    if n == 1:
        none = np.zeros(0)
        return Balance(left, wrench[..., :2], wrench[..., 2], f.loss.reshape(1, 4), none, none.reshape(0, 2))
    slide = q[:-1] @ pair.first.T - q[1:] @ pair.second.T
    size = np.sqrt(np.sum(slide * slide, axis=1))
    rub = slide / np.where(size > 0.0, size, 1.0)[:, None]
    bite = pair.mu * ball_force
    left[:-1, 0] -= pair.closing * ball_force
    left[1:, 0] += pair.closing * ball_force
    left[:-1] -= bite[:, None] * (rub @ pair.first)
    left[1:] += bite[:, None] * (rub @ pair.second)
    return Balance(left, wrench[..., :2], wrench[..., 2], f.loss.reshape(n, 4), bite * size, rub)


def touching_groups(touching: Mask) -> list[slice]:
    """Return groups of balls that touch, from marks ``(N-1,)``; a single ball is a group too."""
    ends = [0, *(np.flatnonzero(~touching) + 1).tolist(), touching.size + 1]
    return [slice(a, b) for a, b in pairwise(ends)]


def solve_touching_group(balls: Balls, law: Law, q: Array, ball_force: Array) -> tuple[Array, Array, float, int]:
    """Return motions, forces, residual (see ``ACCEPTED``) and calls of a group of touching balls, from a start.

    MINPACK's hybrid method with a Jacobian by differences, as Matlab's fsolve, on scaled equations.
    """
    n, pair, bound = balls.count, balls.pair, balls.bound
    turn = pair.units / pair.speed

    def split(x: Array) -> tuple[Array, Array]:
        return x[: q.size].reshape(q.shape) / turn, x[q.size :] * bound

    def residual(x: Array) -> Array:
        motions, forces = split(x)
        left = force_balance(balls, law, motions, forces).left / (pair.units * bound)
        return np.append(left.ravel(), np.diff(x[: q.size].reshape(q.shape)[:, 0]))

    start = np.append((q * turn).ravel(), ball_force[: n - 1] / bound)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        solution = root(residual, start, method="hybr", options=HYBRID)
        worst = float(np.max(np.abs(solution.fun)))
    return *split(solution.x), worst if np.isfinite(worst) else np.inf, int(solution.nfev)


def solve_source_chain(
    balls: Balls, law: Law, touching: Mask, start: tuple[Array, Array]
) -> tuple[Array, Array, float, int]:
    """Return motions ``(N, n)``, forces ``(N-1,)``, worst residual and calls, for given contacts ``(N-1,)``.

    start: motions and forces.
    """
    q, force = start[0].copy(), np.zeros(balls.count - 1)
    worst, calls = 0.0, 0
    for group in touching_groups(touching):
        inner = slice(group.start, group.stop - 1)
        q[group], force[inner], left, further = solve_touching_group(
            balls.subset(group), law, start[0][group], start[1][inner]
        )
        worst, calls = max(worst, left), calls + further
    return q, force, worst, calls


def not_separating(pair: NeighbourInteraction, q: Array, tolerance: float = 0.0) -> Mask:
    """Return which neighbours ``(N-1,)`` do not separate in motions q. tolerance: relative to the nominal speed."""
    rate = (q[:-1, 0] - q[1:, 0]) * pair.units[0] / pair.speed
    return np.asarray(rate >= tolerance)


def solve_by_root(
    balls: Balls, law: Law, reach: Mask, start: Array | None = None, touching: tuple[Array, Array] | None = None
) -> SourceMotion:
    """Return motion and ball-to-ball forces as Lin finds them.

    A law without a root, such as Coulomb's where a contact rests, leaves "failed".

    Parameters
    ----------
    balls
        The balls.
    law
        Friction law.
    reach
        Whether neighbours are near enough to touch ``(N-1,)``.
    start
        Motions ``(N, n)`` from which separate balls are searched, nominal rolling where None; the text leaves it open.
    touching
        Motions and forces ``(N-1,)`` [N] from which those in contact are searched, separate balls and no force where None;
        the text leaves it open.
    """
    pair = balls.pair
    none = np.zeros(balls.count - 1)
    first = np.tile(pair.nominal, (balls.count, 1)) if start is None else np.asarray(start, dtype=float)
    free, _, left, calls = solve_source_chain(balls, law, none > 0.0, (first, none))
    touch = np.asarray(reach, dtype=bool) & not_separating(pair, free)
    q, force = free, none
    if left <= ACCEPTED and np.any(touch):
        q, force, left, further = solve_source_chain(balls, law, touch, (free, none) if touching is None else touching)
        calls += further
    balanced = force_balance(balls, law, q, force)
    wrong = bool(np.any(force < -ACCEPTED * balls.bound) or np.any(reach & ~touch & not_separating(pair, q, ACCEPTED)))
    status: Status = "failed" if not left <= ACCEPTED else "overlapping" if wrong else "exact"
    return SourceMotion(q, free, force, balanced.groove_loss, balanced.ball_loss, left, calls, status)


def neighbour_interaction(bearing: LinearBearing) -> NeighbourInteraction:
    """Return the interaction of balls of a linear bearing in touch (Lin 3.26-3.29); unknowns v, omega_x, omega_y."""
    r, v = bearing.ball_radius, bearing.speed
    turns = np.array([[0.0, 0.0, r], [0.0, -r, 0.0]])
    nominal = np.array([0.5 * v, 0.5 * v / (r * np.cos(bearing.contact_angle)), 0.0])
    return NeighbourInteraction(turns, -turns, 1.0, bearing.mu_balls, np.array([1.0, r, r]), nominal)


def linear_balls(bearing: LinearBearing, angles: Array, loads: Array) -> Balls:
    """Return N balls with contact angles [rad] and normal loads [N], both ``(N, 4)``, in the order BL, BR, TR, TL.

    Contact motions by Lin 3.22-3.24. Raises ValueError for loads that are negative.
    """
    angles, loads = np.atleast_2d(np.asarray(angles, dtype=float)), np.atleast_2d(np.asarray(loads, dtype=float))
    r, n = bearing.ball_radius, contact_directions(angles)
    a, b = semi_axes(bearing, np.maximum(loads, max(1e-9 * float(loads.max()), 1e-30)))
    at = equal_contacts(a.ravel(), b.ravel(), loads.ravel(), bearing.mu)
    maps = np.zeros((*loads.shape, 3, 3))
    maps[..., 1, 0] = 1.0
    maps[..., 1, 1], maps[..., 1, 2] = r * n[..., 1], -r * n[..., 0]
    maps[..., 2, 1], maps[..., 2, 2] = n[..., 0], n[..., 1]
    drives = np.zeros((*loads.shape, 3))
    drives[..., 1] = -MOVING * bearing.speed
    return Balls(at, maps, drives, neighbour_interaction(bearing))


def linear_law(bearing: LinearBearing, sharpness: float | None = SHARPNESS) -> Law:
    """Return sigmoid of Lin 3.20 with k_S = ``sharpness`` and the nominal spin v tan(beta)/(2 R_B); None: Coulomb's law.

    The reference is an assumption: 3.25 prints no sigmoid, and the rotary bearing's (difference of the rings' spins)
    is zero between grooves that do not turn.
    """
    if sharpness is None:
        return Coulomb()
    return Sigmoid(sharpness, 0.5 * abs(bearing.speed) * float(np.tan(bearing.contact_angle)) / bearing.ball_radius)


def solve_linear_by_root(
    bearing: LinearBearing, angles: Array, loads: Array, reach: Mask | bool = True, law: Law | None = None
) -> SourceMotion:
    """Return balls in a linear bearing by Lin's method (3.25-3.31). law: default Coulomb's law as printed in 3.25."""
    balls = linear_balls(bearing, angles, loads)
    near = np.broadcast_to(np.asarray(reach, dtype=bool), (balls.count - 1,))
    return solve_by_root(balls, Coulomb() if law is None else law, near)


def linear_pair_by_root(
    bearing: LinearBearing, theta: float, rho: float, vertical: float, law: Law | None = None
) -> SourceMotion:
    """Return Lin's case study 3.3.4 by his method: theta [rad], side force ratio rho, N_y [N] on each ball, in reach.

    Loads in equilibrium at the given angles, in closed form as in the linear pair here.
    """
    return solve_linear_by_root(bearing, *pair_angles_and_loads(bearing, theta, rho, vertical), True, law)
