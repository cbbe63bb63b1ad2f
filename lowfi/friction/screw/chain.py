"""Motion of many balls of a ball screw with friction; ball-to-ball contact is a complementarity problem.

On every ball the friction at its grooves is in balance with the forces of its neighbours. These are a force F with 0 <= F,
0 <= rate at which the gap may still close, F rate = 0, and sliding friction mu F between balls (Lin 3.73-3.77). A
semismooth Newton method solves for motions and forces together while the regularising speed of friction falls
(`solve_motion_of_chain`). The module ``coupled`` lets the contact loads agree with the motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from rollbench.lowfi.friction.contact.least_dissipation import FrictionalBodies, motions_of_least_dissipation
from rollbench.lowfi.friction.screw import balance, neighbours
from rollbench.lowfi.friction.screw import groove as screw_groove
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.friction.screw.neighbours import ScaledBalls
from rollbench.lowfi.friction.screw.path import follow_path
from rollbench.lowfi.together import Search, Task, solve_alone
from rollbench.meshes.arrays import Array, Mask

#: Regularising speeds of friction as fractions of the speed of the moving groove, from the first to the last.
SPEEDS = tuple(10.0 ** (-0.5 * k) for k in range(2, 15))

#: Smoothing of the equations of the result.
EXACT = balance.Smoothing(SPEEDS[-1])

#: Force out of balance, as a fraction of the largest friction bound (mu times load) of a ball: value aimed at (root of the
#: sum of squares), and value up to which a result counts as converged (largest force out of balance, relative to the
#: largest ball-to-ball force where this is larger than the bound).
GOAL, ACCEPTED = 1e-15, 2e-9

#: Residual above which a solution at one regularising speed counts as failed.
MISSED = 1e-8

#: Largest numbers of Newton steps in the first attempt, at one smoothing, and along the path of solutions.
SHORT, STEPS, MOST = 15, 60, 20_000

#: Friction between balls, its coefficient times the root of the number of pairs that can touch: up to the first value the
#: first attempt finds the same state as the path of solutions; up to the second, solutions at falling regularising speeds
#: do, with few Newton steps each. Forces that push at random add up like the root of their number.
SLIGHT, LARGE, FEW = 0.3, 0.8, 8

#: Number of loaded contacts of a ball below which it has a motion without resistance.
SUPPORTS = 3

#: Stiffness of weak springs that draw the motion of a ball to the nominal motion, in units of the largest friction bound of
#: a ball: for loaded balls, then for unloaded balls.
HOLD, HOLD_IDLE = 1e-13, 1e-10

#: Balls whose load is less than this fraction of the largest load of a ball count as unloaded.
NEGLIGIBLE = 1e-7


@dataclass(frozen=True)
class BallChain(ABC):
    """Abstract class for N balls of one track, in the order of azimuth, with their contact loads.

    An unloaded ball rolls at the nominal speed unless its neighbours push it. Between its neighbours it turns without
    friction, as a spacer ball does.
    """

    #: Grooves of screw and nut in motion.
    groove: screw_groove.TrackInMotion
    #: Forces at the contacts of the balls with the grooves ``(N, 4)`` [N].
    force: Array
    #: Unit vectors from each ball's centre to its contacts in x3, y3, z3 ``(N, 4, 3)``.
    normals: Array
    #: Largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s]; inf where
    #: they cannot touch. The last element is for the last ball and the first one of a closed track.
    allowed_closing_rate: Array

    #: Ellipses, friction bounds and kinematics of the contacts of all N balls with the grooves.
    friction_contacts: FrictionalBodies
    #: Coefficient of friction between touching balls.
    mu_balls: float

    def contact_wrenches(self, pull: Array) -> Array:
        """Return force, then moment of friction on the balls at each contact, along x3, y3, z3 each ``(N, 4, 6)`` [N, N m].

        x3 is radial, y3 along the track and z3 the binormal. ``pull``: friction on the balls in the axes of each
        contact ``(N, 4, 3)``: force along x and along z [N], moment about y [N m].
        """
        return screw_motion.friction_wrench_at_contacts(self.normals, pull[..., :2], pull[..., 2])

    @abstractmethod
    def input_power(self, wrench: Array) -> float:
        """Return the power [W] that the motions of screw and nut supply against friction.

        ``wrench``: force (first three components) and moment of friction on the balls at each contact in x3 (radial),
        y3 (along the track), z3 (binormal) ``(N, 4, 6)`` [N, N m].
        """


@dataclass(frozen=True)
class ScrewBallChain(BallChain):
    """Balls of equal size and their contact loads in the grooves of one screw and nut, in the order of azimuth."""

    #: Grooves of screw and nut with their speeds.
    groove: screw_groove.ScrewGroove

    def input_power(self, wrench: Array) -> float:
        """Return the power [W] that the motions of screw and nut supply against friction.

        ``wrench``: force (first three components) and moment of friction on the balls at each contact in x3 (radial),
        y3 (along the track), z3 (binormal) ``(N, 4, 6)`` [N, N m].
        """
        return screw_motion.power_of_helical_motion(self.groove, self.normals, wrench)


def screw_ball_chain(groove: screw_groove.ScrewGroove, force: Array, normals: Array, slack: Array) -> ScrewBallChain:
    """Return balls of equal size under given contact loads in the grooves of one screw and nut.

    ``force`` ``(N, 4)`` [N], ``normals`` ``(N, 4, 3)``, ``slack`` ``(N,)`` [rad/s]: fields of `BallChain`.
    """
    at, (maps, drives) = screw_motion.contact_ellipses_of_screw(groove, force), groove.contact_kinematics(normals)
    a, b, bound = (values.reshape(-1, 4) for values in (at.a, at.b, at.friction_bound))
    contacts = FrictionalBodies(a, b, bound, maps, drives, np.zeros_like(a))
    return ScrewBallChain(groove, force, normals, slack, contacts, groove.ball_to_ball_mu)


@dataclass(frozen=True)
class ChainMotion:
    """Motion, friction forces and losses of the N balls of one track of a screw."""

    #: Motions of the balls ``(N, 4)`` [rad/s]: orbit and rotations about x3, y3, z3.
    q: Array
    #: Force of ball k on ball k + 1 ``(N,)`` [N].
    ball_force: Array
    #: Force and moment of friction on the balls at each contact, in x3, y3, z3 ``(N, 4, 6)`` [N, N m].
    wrench: Array
    #: Motion of the ball relative to the groove at each contact: sliding along x and z [m/s], spin about y [rad/s] ``(N, 4,
    #: 3)``.
    contact_motions: Array
    #: Friction on the balls in the axes of each contact: force along x and z [N], moment about y [N m] ``(N, 4, 3)``.
    contact_friction: Array
    #: Sum of the forces from neighbours on each ball, friction included, in x3, y3, z3 ``(N, 3)`` [N].
    neighbour_forces: Array
    #: Friction loss at each contact with the grooves ``(N, 4)`` [W].
    groove_loss: Array
    #: Power lost where balls k and k + 1 slide on each other ``(N,)`` [W].
    ball_loss: Array
    #: Power lost where balls k and k + 1 press on each other while the gap between them still closes within a time step
    #: ``(N,)`` [W].
    closing_loss: Array
    #: Power that screw and nut supply [W].
    input_power: float
    #: Largest unbalanced force on a ball [N].
    largest_unbalanced_force: float
    #: Largest excess of the rate at which a ball approaches the next one over the rate that their gap allows [rad/s]; 0 if
    #: no ball exceeds it.
    largest_gap_violation: float
    #: Number of Newton steps of the search.
    steps: int
    #: Whether the forces on all balls are in balance.
    converged: bool
    #: Whether the search from the starting values that the caller passed led to this solution, rather than a search from
    #: other values.
    found_from_given_start: bool = False

    @property
    def losses_by_cause(self) -> tuple[float, float, float]:
        """Power lost in the grooves, then by balls that slide on each other, then by gaps that close under force [W]."""
        return float(self.groove_loss.sum()), float(self.ball_loss.sum()), float(self.closing_loss.sum())

    @property
    def loss(self) -> float:
        """Power lost by friction of the balls, with grooves and with each other [W]."""
        return sum(self.losses_by_cause)


class LeastDissipationTask(Task):
    """Task of a search: motions of least dissipation of the loaded balls of a chain (`motions_of_least_dissipation`)."""

    likeness = None

    def __init__(self, bodies: FrictionalBodies, start: Array) -> None:
        """Ask for the motions of ``bodies``; ``start``: scaled motions from which the search begins ``(K, 4)``."""
        self.bodies, self.start = bodies, start

    @classmethod
    def solve(cls, tasks: Sequence[Self]) -> list[Array]:
        """Return the scaled motions of the balls of each task ``(K, 4)``."""
        bodies, start = balance.joined([task.bodies for task in tasks]), np.concatenate([task.start for task in tasks])
        found = motions_of_least_dissipation(bodies, SPEEDS[::4], start)
        return np.split(found, np.cumsum([len(task.start) for task in tasks])[:-1])


class BalanceSearch:
    """Search for motions and ball-to-ball forces that balance the friction on all balls of one chain, in scaled units.

    The scaled motions x ``(N, 4)`` are surface speeds (orbit, and spins times the ball radius) divided by ``speed``
    [m/s], which is the nut's speed along the path. The scaled forces f ``(N,)`` act from ball k on ball k + 1 and are
    divided by ``bound`` [N], the largest friction bound of a ball: coefficient of friction mu times its load. The
    motion does not depend on the size of the grooves' mu, and all friction forces are proportional to it. Without
    friction (mu = 0) the bound is computed with mu = 1, so that the motion is the limit for a mu that tends to zero.
    """

    def __init__(self, chain: BallChain) -> None:
        """Scale contacts and kinematics of the balls of ``chain``.

        Balls with less than ``NEGLIGIBLE`` times the largest load of a ball get no friction.
        """
        g, contacts = chain.groove, chain.friction_contacts
        total = chain.force.sum(axis=1)
        loaded = total > NEGLIGIBLE * float(total.max())
        self.chain, self.count, self.loaded = chain, chain.force.shape[0], loaded
        self.units, self.speed, self.track = g.levers, g.speed_along_path, g.scaled
        bound = contacts.bound
        self.rubbing = bool(np.any(bound > 0.0))
        if not self.rubbing:
            bound = chain.force
        self.bound = max(float(bound.sum(axis=1).max()), 1e-30)
        self.allowed = np.isfinite(chain.allowed_closing_rate)
        slack = np.where(self.allowed, chain.allowed_closing_rate, 0.0) * g.pair.closing_speed_factor / self.speed
        self.mu = np.where(loaded & np.roll(loaded, -1), chain.mu_balls, 0.0)
        self.balls = ScaledBalls(
            neighbour_offsets=neighbours.neighbours_in_a_ring(self.count),
            nominal=np.tile(g.nominal_motion * self.units / self.speed, (self.count, 1)),
            loaded=loaded,
            holding_stiffness=np.where(loaded, HOLD, HOLD_IDLE),
            can_touch_next=self.allowed,
            mu=self.mu,
            a=contacts.a,
            b=contacts.b,
            bound=bound * loaded[:, None] / self.bound,
            contact_motion_maps=contacts.maps / self.units,
            motion=np.zeros((self.count, 4)),
            contact_motions=contacts.drives / self.speed,
            sliding_on_next=np.zeros((self.count, 2)),
            remaining_closing_rate=slack,
        )

    def in_motion(self, x: Array) -> ScaledBalls:
        """Return the balls in scaled motions x ``(N, 4)``."""
        return self.balls.moved(self.track, x)

    def motions_without_neighbours(self, start: Array | None = None) -> Search[Array]:
        """Return the scaled motions ``(N, 4)`` of the balls if neighbours exert no forces on each other.

        Loaded balls move with least dissipation, unloaded balls with the nominal motion. ``start``: scaled motions ``(N,
        4)`` from which this convex search begins, at the smallest regularising speed at once; None, and for balls that do
        not arrive there, those nearest to rolling and falling speeds.
        """
        x, balls, on = self.balls.nominal.copy(), self.balls, self.balls.bound.sum(axis=1) > 0.0
        if on.any():
            shape, maps, drives = (balls.a, balls.b, balls.bound), balls.contact_motion_maps, balls.contact_motions
            bodies = FrictionalBodies(*shape, maps, drives, np.zeros((self.count, 4))).take(on)
            alone = np.full((len(bodies.a), 4), np.nan) if start is None else start[on]
            x[on] = yield LeastDissipationTask(bodies, alone)
        return x

    def solve_force_balance(
        self, balls: ScaledBalls, f: Array, law: balance.Smoothing, limit: int, goal: float = GOAL
    ) -> Search[balance.BalancedMotion]:
        """Solve the force balance of all balls by Newton's method under one smoothing.

        ``balls``: balls in motion and ``f``: scaled ball-to-ball forces ``(N,)`` to begin from; ``limit``: largest number
        of Newton steps; ``goal``: residual at which the search ends.
        """
        return balance.search_force_balance(self.track, balls, f, law, goal, ACCEPTED, limit)

    @staticmethod
    def is_converged(found: balance.BalancedMotion) -> bool:
        """Return whether the forces on all balls are in balance; a largest ball-to-ball force above one is the unit."""
        return found.residuals.largest <= ACCEPTED * max(1.0, float(np.max(found.ball_force)))

    def solve_at_smallest_regularising_speed(
        self, balls: ScaledBalls, f: Array, share: float = 1.0
    ) -> Search[balance.BalancedMotion]:
        """Solve the force balance at the smallest regularising speed of friction, with up to ``SHORT`` Newton steps.

        If the forces are in balance after exactly ``SHORT`` steps, the search goes on for higher accuracy.
        ``balls``, ``f``: balls in motion and scaled ball-to-ball forces ``(N,)`` to begin from; ``share``: fraction of the
        friction between balls that acts.
        """
        law = EXACT._replace(share=share)
        found = yield from self.solve_force_balance(balls, f, law, SHORT)
        if found.steps < SHORT or not self.is_converged(found):
            return found
        more = yield from self.solve_force_balance(found.balls, found.ball_force, law, STEPS)
        return more._replace(steps=found.steps + more.steps)

    def solve_cold(self, start: Array | None = None) -> Search[balance.BalancedMotion]:
        """Solve the force balance from nothing but the contact loads.

        The motion without friction between balls is a convex problem with one solution. Balls that all part in it also part
        with that friction. Little friction is solved from there at once; more of it at falling regularising speeds, where
        the sign of the determinant must stay that of the convex problem; much of it, and what fails, along the path of
        solutions. ``start``: see `motions_without_neighbours`.
        """
        if not self.balls.contact_motions.any():  # grooves at rest move no ball
            return (yield from self.solve_force_balance(self.balls, np.zeros(self.count), EXACT, 0))
        slippery, total = yield from self.solve_without_friction_between_balls(start)
        apart = self.is_converged(slippery) and not np.any(self.pressing(slippery))
        share = float(self.mu.max()) * float(np.sqrt(self.allowed.sum()))
        if share == 0.0 and self.is_converged(slippery):
            return slippery
        if apart or share <= SLIGHT:
            found = yield from self.solve_at_smallest_regularising_speed(slippery.balls, slippery.ball_force)
            total += found.steps
            if self.is_converged(found):
                return found._replace(steps=total)
        supported = (self.balls.bound > 0.0).sum(axis=1) >= SUPPORTS
        if share <= LARGE and np.all(supported | ~self.loaded):
            found = yield from self.solve_at_falling_speeds(slippery.balls, slippery.ball_force, FEW)
            total += found.steps
            both = ((slippery, EXACT._replace(share=0.0)), (found, EXACT))
            if self.is_converged(found) and len({balance.determinant_sign(self.track, *at) for at in both}) == 1:
                return found._replace(steps=total)
        found = yield from self.solve_by_path((yield from self.motions_without_neighbours(start)))
        return found._replace(steps=total + found.steps)

    def solve_without_friction_between_balls(self, start: Array | None) -> Search[tuple[balance.BalancedMotion, int]]:
        """Solve the convex problem without friction between balls; return its solution and the number of Newton steps.

        ``start``: see `motions_without_neighbours`.
        """
        alone, none = self.in_motion((yield from self.motions_without_neighbours(start))), np.zeros(self.count)
        found = yield from self.solve_at_smallest_regularising_speed(alone, none, share=0.0)
        if self.is_converged(found):
            return found, found.steps
        more = yield from self.solve_at_falling_speeds(alone, none, STEPS, share=0.0)
        return more, found.steps + more.steps

    def pressing(self, found: balance.BalancedMotion) -> Mask:
        """Return which balls press on the next one ``(N,)``: the force exceeds the closing rate left, both scaled."""
        gap = np.where(self.allowed, found.balls.remaining_closing_rate, 0.0)
        return self.allowed & (found.ball_force > gap)

    def solve_at_falling_speeds(
        self, balls: ScaledBalls, f: Array, limit: int, share: float = 1.0
    ) -> Search[balance.BalancedMotion]:
        """Solve the force balance at regularising speeds that fall from the first to the last, until one is not solved.

        ``balls``, ``f``: balls in motion and scaled ball-to-ball forces ``(N,)`` to begin from; ``limit``: largest number
        of Newton steps at one speed; ``share``: fraction of the friction between balls that acts.
        """
        total = 0
        for eps in SPEEDS[::2]:
            goal = GOAL if eps == SPEEDS[-1] else MISSED
            found = yield from self.solve_force_balance(balls, f, balance.Smoothing(eps, share), limit, goal)
            balls, f, total = found.balls, found.ball_force, total + found.steps
            if found.residuals.size > MISSED:
                break
        return found._replace(steps=total)

    def solve_by_path(self, x: Array) -> Search[balance.BalancedMotion]:
        """Solve the force balance by the path of solutions along which friction between balls rises and smoothing falls.

        The path begins at the one solution without friction between balls, smoothed, and is followed round its folds. A
        force between balls is a sum of friction forces on balls, so that no force on the path exceeds the sum of the
        friction bounds; the path therefore has another end, with the whole friction (Leray and Schauder). ``x``: scaled
        motions ``(N, 4)`` to begin from.
        """
        smooth = balance.smoothing_on_path(0.0)
        first = yield from self.solve_force_balance(self.in_motion(x), np.zeros(self.count), smooth, STEPS)
        point = np.append(np.column_stack([first.balls.motion, first.ball_force]), 0.0)
        end, _, steps = follow_path(balance.BalancePoint(self.track, first.balls, point), MOST)
        last = yield from self.solve_force_balance(end.balls, end.ball_force, EXACT, STEPS)
        return last._replace(steps=first.steps + steps + last.steps)


def search_motion_of_chain(
    chain: BallChain, start: tuple[Array, Array] | None = None, warm: bool = False
) -> Search[ChainMotion]:
    """Return motions and ball-to-ball forces of the balls of one track at given contact loads.

    The search begins from ``start`` if balls press on each other there (with ``warm`` also if none do), then from the
    motions that the balls have without neighbours, both by Newton's method at the last, smallest regularising speed. If
    both fail, or where much friction between balls could lead the second to another state, the result is the end of the
    path of solutions along which this friction rises from zero. A closed track needs a gap somewhere: in a track that is
    full of balls the forces between them are not determined.

    Parameters
    ----------
    chain
        Balls with their contact loads and the largest rates at which neighbours may approach each other.
    start
        Motions ``(N, 4)`` [rad/s] (orbit and three spins) and ball-to-ball forces ``(N,)`` [N] of a similar
        chain; None if none is known.
    warm
        Whether to begin from ``start`` even if no ball presses on the next one there.

    References
    ----------
    Lin (2019), 3.73 to 3.77.
    """
    s = BalanceSearch(chain)
    if start is None:
        return chain_motion_in_si_units(s, (yield from s.solve_cold()))
    x, total = start[0] * s.units / s.speed, 0
    if warm or np.any(start[1] > 0.0):
        found = yield from s.solve_at_smallest_regularising_speed(s.in_motion(x), start[1] / s.bound)
        total = found.steps
        if s.is_converged(found):
            return chain_motion_in_si_units(s, found, True)
    found = yield from s.solve_cold(x)
    return chain_motion_in_si_units(s, found._replace(steps=total + found.steps))


def solve_motion_of_chain(chain: BallChain, start: tuple[Array, Array] | None = None, warm: bool = False) -> ChainMotion:
    """Return motions and ball-to-ball forces of the balls of one track; arguments: see `search_motion_of_chain`."""
    return solve_alone(search_motion_of_chain(chain, start, warm))


def chain_motion_in_si_units(s: BalanceSearch, found: balance.BalancedMotion, from_start: bool = False) -> ChainMotion:
    """Return motion, forces and losses of the balls in SI units, from the scaled solution of a search.

    ``s``: the search with its scales; ``found``: its solution; ``from_start``: whether the start that the caller gave led
    to the solution.
    """
    chain, pair, at = s.chain, s.chain.groove.pair, found.residuals
    balls, f, bound = found.balls, found.ball_force, s.bound if s.rubbing else 0.0
    gap = np.where(s.allowed, balls.remaining_closing_rate, 0.0)
    ball_force = bound * np.where(s.pressing(found), np.maximum(f, 0.0), 0.0)
    pull = -bound * balls.bound[..., None] * at.dissipation.gradient
    wrench = chain.contact_wrenches(pull)
    bite = (s.balls.mu * ball_force)[:, None]
    push = ball_force[:, None] * pair.force_directions[:, None]  # on the first, then on the second ball of each pair
    rub = bite * at.sliding.direction @ pair.tangent_directions
    return ChainMotion(
        q=balls.motion * s.speed / s.units,
        ball_force=ball_force,
        wrench=wrench,
        contact_motions=s.speed * balls.contact_motions,
        contact_friction=pull,
        neighbour_forces=push[0] - rub[0] + np.roll(push[1] + rub[1], 1, axis=0),
        groove_loss=-s.speed * (pull * balls.contact_motions).sum(axis=-1),
        ball_loss=(bite * at.sliding.direction * at.sliding.velocity).sum(axis=1) * s.speed,
        closing_loss=ball_force * s.speed * (s.balls.remaining_closing_rate - balls.remaining_closing_rate),
        input_power=chain.input_power(wrench),
        largest_unbalanced_force=float(np.abs(at.forces).max()) * bound,
        largest_gap_violation=max(0.0, -float(np.min(gap))) * s.speed / pair.closing_speed_factor,
        steps=found.steps,
        converged=s.is_converged(found),
        found_from_given_start=from_start,
    )
