"""The source's method for balls that may touch, at given loads, kept for comparison: a root (Lin 3.25-3.31, 3.75-3.77).

First every ball by itself; neighbours in reach that close in then count as touching; each group of touching balls is one
system of equations: force balance of all, equal velocities of neighbours, with the ball-to-ball forces as unknowns.

Balls in a linear bearing (Lin 3.3.1, 3.3.2) are chains too: a root at given loads.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.friction.contact.laws import Contacts, Coulomb, Law, Sigmoid, contacts
from rollbench.lowfi.friction.contact.motion import HYBRID
from rollbench.lowfi.friction.linear.bearing import MOVING, LinearBearing, directions, semi_axes
from rollbench.lowfi.friction.linear.chain import pair_state
from rollbench.meshes.arrays import Array, Mask

Status = Literal["exact", "overlapping", "failed"]

#: Force out of balance over a ball's friction bound, and closing speed over the nominal, that count as none.
ACCEPTED = 1e-8

#: k_S of the source's sigmoid in its searches for touching balls, for which the text prints none.
SHARPNESS = 100.0


@dataclass(frozen=True)
class Neighbours:
    """How balls in touch act on each other, n unknowns of motion a ball, the first of them along the track.

    first, second (2, n): sliding of each ball's surface at the contact by its motion [m]; closing: closing velocity per
    difference of the first unknowns; mu; units (n,): surface speed per unknown; nominal (n,): motion to start from.
    """

    first: Array
    second: Array
    closing: float
    mu: float
    units: Array
    nominal: Array

    @property
    def speed(self) -> float:
        """Nominal speed along the track [m/s], one at rest."""
        return abs(float(self.nominal[0] * self.units[0])) or 1.0


@dataclass(frozen=True)
class Balls:
    """N balls in order at given loads: contacts (4 N,), maps (N, 4, 3, n), drives (N, 4, 3), and how neighbours act."""

    at: Contacts
    maps: Array
    drives: Array
    pair: Neighbours

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.maps.shape[0])

    @property
    def bound(self) -> float:
        """Largest friction bound of a ball [N]."""
        return max(float(self.at.strength.reshape(-1, 4).sum(axis=1).max()), 1e-300)

    def subset(self, chosen: slice) -> Balls:
        """Some of the balls."""
        rows = slice(4 * chosen.start, 4 * chosen.stop)
        at = Contacts(self.at.a[rows], self.at.b[rows], self.at.load[rows], self.at.mu[rows])
        return Balls(at, self.maps[chosen], self.drives[chosen], self.pair)


@dataclass(frozen=True)
class Balance:
    """Generalised forces (N, n) out of balance [W per unknown]; friction on the balls: force (N, 4, 2) along the
    contacts' x and z, moment (N, 4); losses (N, 4) at the grooves and (N-1,) between balls [W]; rub (N-1, 2): direction
    in which ball k slides on ball k + 1.
    """

    left: Array
    force: Array
    moment: Array
    groove_loss: Array
    ball_loss: Array
    rub: Array


@dataclass(frozen=True)
class SourceMotion:
    """Motions q (N, n) of the balls, free (N, n): before contact; ball_force (N-1,) [N]; losses (N, 4), (N-1,) [W].

    left: largest force out of balance over the friction bound; calls of the balance; status: "exact", "failed" (no
    root), or "overlapping": a root whose neighbours close in nevertheless or pull at each other, since what touches was
    decided before (Lin 3.31).
    """

    q: Array
    free: Array
    ball_force: Array
    groove_loss: Array
    ball_loss: Array
    left: float
    calls: int
    status: Status

    @property
    def loss(self) -> float:
        """Total dissipation [W]."""
        return float(self.groove_loss.sum() + self.ball_loss.sum())


def balance(balls: Balls, law: Law, q: Array, ball_force: Array) -> Balance:
    """Balance of N balls in motions q (N, n) under friction ``law`` and forces (N-1,) [N] of ball k on ball k + 1.

    Lin 3.25 with 3.26-3.29, and 3.69 with 3.73-3.75.
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


def blocks(touching: Mask) -> list[slice]:
    """Groups of balls that touch, from marks (N-1,); a single ball is a group too."""
    ends = [0, *(np.flatnonzero(~touching) + 1).tolist(), touching.size + 1]
    return [slice(a, b) for a, b in pairwise(ends)]


def root_of_block(balls: Balls, law: Law, q: Array, ball_force: Array) -> tuple[Array, Array, float, int]:
    """Motions, forces, what is left (see ``ACCEPTED``) and calls of a group of N touching balls, from a start.

    MINPACK's hybrid method with a Jacobian by differences, as Matlab's fsolve, on scaled equations.
    """
    n, pair, bound = balls.count, balls.pair, balls.bound
    turn = pair.units / pair.speed

    def split(x: Array) -> tuple[Array, Array]:
        return x[: q.size].reshape(q.shape) / turn, x[q.size :] * bound

    def residual(x: Array) -> Array:
        motions, forces = split(x)
        left = balance(balls, law, motions, forces).left / (pair.units * bound)
        return np.append(left.ravel(), np.diff(x[: q.size].reshape(q.shape)[:, 0]))

    start = np.append((q * turn).ravel(), ball_force[: n - 1] / bound)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        solution = root(residual, start, method="hybr", options=HYBRID)
        worst = float(np.max(np.abs(solution.fun)))
    return *split(solution.x), worst if np.isfinite(worst) else np.inf, int(solution.nfev)


def roots(balls: Balls, law: Law, touching: Mask, start: tuple[Array, Array]) -> tuple[Array, Array, float, int]:
    """Motions (N, n), forces (N-1,), worst left and calls, for given contacts (N-1,), from motions and forces."""
    q, force = start[0].copy(), np.zeros(balls.count - 1)
    worst, calls = 0.0, 0
    for group in blocks(touching):
        inner = slice(group.start, group.stop - 1)
        q[group], force[inner], left, further = root_of_block(balls.subset(group), law, start[0][group], start[1][inner])
        worst, calls = max(worst, left), calls + further
    return q, force, worst, calls


def closing_in(pair: Neighbours, q: Array, tolerance: float = 0.0) -> Mask:
    """Which neighbours (N-1,) are not leaving each other in motions q (N, n); tolerance: over the nominal speed."""
    rate = (q[:-1, 0] - q[1:, 0]) * pair.units[0] / pair.speed
    return np.asarray(rate >= tolerance)


def solve_by_root(
    balls: Balls, law: Law, reach: Mask, start: Array | None = None, touching: tuple[Array, Array] | None = None
) -> SourceMotion:
    """Motion and ball-to-ball forces as the source finds them; reach (N-1,): neighbours near enough to touch.

    start (N, n): motions from which the balls alone are searched, nominal rolling where None; touching: motions and
    forces (N-1,) [N] from which those in contact are, the balls alone and no force where None. The text leaves both
    starts open. A law without a root, such as Coulomb's where a contact rests, leaves "failed".
    """
    pair = balls.pair
    none = np.zeros(balls.count - 1)
    first = np.tile(pair.nominal, (balls.count, 1)) if start is None else np.asarray(start, dtype=float)
    free, _, left, calls = roots(balls, law, none > 0.0, (first, none))
    touch = np.asarray(reach, dtype=bool) & closing_in(pair, free)
    q, force = free, none
    if left <= ACCEPTED and np.any(touch):
        q, force, left, further = roots(balls, law, touch, (free, none) if touching is None else touching)
        calls += further
    balanced = balance(balls, law, q, force)
    wrong = bool(np.any(force < -ACCEPTED * balls.bound) or np.any(reach & ~touch & closing_in(pair, q, ACCEPTED)))
    status: Status = "failed" if not left <= ACCEPTED else "overlapping" if wrong else "exact"
    return SourceMotion(q, free, force, balanced.groove_loss, balanced.ball_loss, left, calls, status)


def neighbours(bearing: LinearBearing) -> Neighbours:
    """Balls of a linear bearing in touch (Lin 3.26-3.29); unknowns v, omega_x, omega_y."""
    r, v = bearing.ball_radius, bearing.speed
    turns = np.array([[0.0, 0.0, r], [0.0, -r, 0.0]])
    nominal = np.array([0.5 * v, 0.5 * v / (r * np.cos(bearing.contact_angle)), 0.0])
    return Neighbours(turns, -turns, 1.0, bearing.mu_balls, np.array([1.0, r, r]), nominal)


def linear_balls(bearing: LinearBearing, angles: Array, loads: Array) -> Balls:
    """N balls with contact angles [rad] and normal loads [N], both (N, 4), in the order BL, BR, TR, TL.

    Contact motions by Lin 3.22-3.24. Raises ValueError for loads that are negative.
    """
    angles, loads = np.atleast_2d(np.asarray(angles, dtype=float)), np.atleast_2d(np.asarray(loads, dtype=float))
    r, n = bearing.ball_radius, directions(angles)
    a, b = semi_axes(bearing, np.maximum(loads, max(1e-9 * float(loads.max()), 1e-30)))
    at = contacts(a.ravel(), b.ravel(), loads.ravel(), bearing.mu)
    maps = np.zeros((*loads.shape, 3, 3))
    maps[..., 1, 0] = 1.0
    maps[..., 1, 1], maps[..., 1, 2] = r * n[..., 1], -r * n[..., 0]
    maps[..., 2, 1], maps[..., 2, 2] = n[..., 0], n[..., 1]
    drives = np.zeros((*loads.shape, 3))
    drives[..., 1] = -MOVING * bearing.speed
    return Balls(at, maps, drives, neighbours(bearing))


def linear_law(bearing: LinearBearing, sharpness: float | None = SHARPNESS) -> Law:
    """Sigmoid of Lin 3.20 with k_S = ``sharpness`` and the nominal spin v tan(beta) / (2 R_B); None: Coulomb.

    The reference is an assumption: 3.25 prints no sigmoid, and the rotary bearing's (difference of the rings' spins)
    is zero between grooves that do not turn.
    """
    if sharpness is None:
        return Coulomb()
    return Sigmoid(sharpness, 0.5 * abs(bearing.speed) * float(np.tan(bearing.contact_angle)) / bearing.ball_radius)


def solve_linear_by_root(
    bearing: LinearBearing, angles: Array, loads: Array, reach: Mask | bool = True, law: Law | None = None
) -> SourceMotion:
    """Balls in a linear bearing as the source solves them (Lin 3.25-3.31); law: Coulomb's, as 3.25 prints it, if None.

    angles [rad], loads [N]: (N, 4); reach (N-1,): neighbours near enough to touch.
    """
    balls = linear_balls(bearing, angles, loads)
    near = np.broadcast_to(np.asarray(reach, dtype=bool), (balls.count - 1,))
    return solve_by_root(balls, Coulomb() if law is None else law, near)


def linear_pair_by_root(
    bearing: LinearBearing, theta: float, rho: float, vertical: float, law: Law | None = None
) -> SourceMotion:
    """Case study of Lin 3.3.4 by the source's method: theta [rad], side force ratio rho, N_y [N] on each ball, in reach.

    Loads in equilibrium at the given angles, in closed form as in the linear pair here.
    """
    return solve_linear_by_root(bearing, *pair_state(bearing, theta, rho, vertical), True, law)
