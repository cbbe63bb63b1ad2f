"""Motion of many balls of a ball screw with friction; ball-to-ball contact is a complementarity problem.

On every ball the friction at its grooves is in balance with the forces of its neighbours. These are a force F with 0 <= F,
0 <= rate at which the gap may still close, F rate = 0, and sliding friction mu F between balls (Lin 3.73-3.77). A
semismooth Newton method solves for motions and forces together while the regularising speed of friction falls
(`solve_motion_of_chain`).

`solve_coupled_chain` lets the contact loads agree with the motion (section 3.4.1 of Lin's thesis): friction and
ball-to-ball forces in the plane of the groove's section change the contact loads, and changed loads change the friction.
Loads and friction are solved in turn in accelerated rounds. Friction that wedges a ball between grooves changes the loads
by many times as much as it changes itself, so that these rounds run away. Loads and friction are then solved as one system
(`solve_loads_and_motion`), in which the contact angles follow the ball's position. Newton's method follows the solution of
this system from zero friction, strongly smoothed, to the full friction, hardly smoothed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import ContactLoadSolution, zero_contact_state_arrays
from rollbench.lowfi.friction.screw import groove as screw_groove
from rollbench.lowfi.friction.screw import kernel_types
from rollbench.lowfi.friction.screw import motion as screw_motion
from rollbench.lowfi.jit import CONTACT, SCREW, load_kernel_package
from rollbench.meshes.arrays import Array

#: Regularising speeds of friction as fractions of the nut's speed along the path, from the first (cold start) to the last.
SPEEDS = tuple(10.0 ** (-0.5 * k) for k in range(2, 15))

#: Fractions of the friction between balls with which the equations are solved one after the other, all at the first
#: regularising speed.
PARTS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)

#: Force out of balance, as a fraction of the largest friction bound (mu times load) of a ball: value aimed at (root of the
#: sum of squares), and value up to which a result counts as converged (largest force out of balance, relative to the
#: largest ball-to-ball force where this is larger than the bound).
GOAL, ACCEPTED = 1e-12, 2e-9

#: Residual aimed at for all regularising speeds but the last (in the unit of ``GOAL``), largest number of Newton steps at
#: one regularising speed, and largest number in the first attempt.
COARSE, STEPS, SHORT = 1e-10, 60, 15

#: Residual above which the solution of a stage (a fraction of the friction between balls at one regularising speed) counts
#: as failed, and largest number of stages that are inserted half way.
MISSED, DEPTH = 1e-8, 12

#: Stiffness of weak springs that draw the motion of a ball to the nominal motion, in units of the largest friction bound of
#: a ball: for loaded balls, then for unloaded balls.
HOLD, HOLD_IDLE = 1e-13, 1e-10

#: Balls whose load is less than this fraction of the largest load of a ball count as unloaded.
NEGLIGIBLE = 1e-7


@dataclass(frozen=True)
class FrictionContacts:
    """Ellipses, friction bounds and kinematics of the contacts of N balls with the grooves.

    In each contact the axis x lies along the semi-axis a, z along the semi-axis b, and y along the normal into the
    ball.
    """

    #: Semi-axes a >= b [m] and friction bound mu F [N] (coefficient of friction times load) of each contact, ``(N, 4, 3)``.
    semi_axes_and_bound: Array
    #: Sliding vx, vz [m/s] and spin [rad/s] at each contact per unit of the ball's motion (orbit and three spins [rad/s]),
    #: ``(N, 4, 3, 4)``.
    contact_motion_maps: Array
    #: Sliding vx, vz [m/s] and spin [rad/s] at each contact while the ball is at rest and screw and nut move, ``(N, 4,
    #: 3)``.
    imposed_contact_motions: Array


@dataclass(frozen=True)
class BallChain(ABC):
    """Abstract class for N balls of one track, in the order of azimuth, with their contact loads.

    An unloaded ball rolls at the nominal speed unless its neighbours push it. Between its neighbours it turns without
    friction, as a spacer ball does.
    """

    #: Grooves of screw and nut in motion.
    groove: screw_groove.GroovesInMotion
    #: Forces at the contacts of the balls with the grooves ``(N, 4)`` [N].
    force: Array
    #: Unit vectors from each ball's centre to its contacts in x3, y3, z3 ``(N, 4, 3)``.
    normals: Array
    #: Largest rate at which the difference of the azimuths of balls k and k + 1 may decrease ``(N,)`` [rad/s]; inf where
    #: they cannot touch. The last element is for the last ball and the first one of a closed track.
    allowed_closing_rate: Array

    @property
    @abstractmethod
    def friction_contacts(self) -> FrictionContacts:
        """Ellipses, friction bounds and kinematics of the contacts of all N balls with the grooves."""

    @property
    @abstractmethod
    def mu_balls(self) -> float:
        """Coefficient of friction between touching balls."""

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

    @property
    def friction_contacts(self) -> FrictionContacts:
        """Ellipses, friction bounds and kinematics of the contacts of all N balls with the grooves."""
        at = screw_motion.contact_ellipses_of_screw(self.groove, self.force)
        maps, drives = self.groove.contact_kinematics(self.normals)
        shape = np.stack([at.a, at.b, at.friction_bound], axis=1).reshape(-1, 4, 3)
        return FrictionContacts(shape, maps, np.broadcast_to(drives, (*maps.shape[:2], 3)))

    @property
    def mu_balls(self) -> float:
        """Coefficient of friction between touching balls."""
        return self.groove.ball_to_ball_mu

    def input_power(self, wrench: Array) -> float:
        """Return the power [W] that the motions of screw and nut supply against friction.

        ``wrench``: force (first three components) and moment of friction on the balls at each contact in x3 (radial),
        y3 (along the track), z3 (binormal) ``(N, 4, 6)`` [N, N m].
        """
        return screw_motion.power_of_helical_motion(self.groove, self.normals, wrench)


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


class BalanceSearch:
    """Search for motions and ball-to-ball forces that balance the friction on all balls of one chain, in scaled units.

    The scaled motions x ``(N, 4)`` are surface speeds (orbit, and spins times the ball radius) divided by ``speed``
    [m/s], which is the nut's speed along the path. The scaled forces f ``(N,)`` act from ball k on ball k + 1 and are
    divided by ``bound`` [N], the largest friction bound of a ball: coefficient of friction mu times its load. The
    motion does not depend on the size of the grooves' mu, and all friction forces are proportional to it. Without
    friction (mu = 0) the bound is computed with mu = 1, so that the motion is the limit for a mu that tends to zero.
    """

    def __init__(self, chain: BallChain, fast: bool = True) -> None:
        """Scale contacts and kinematics of the balls of ``chain`` for the kernels.

        Balls with less than ``NEGLIGIBLE`` times the largest load of a ball get no friction. ``fast``: whether to use
        compiled kernels.
        """
        g, contacts = chain.groove, chain.friction_contacts
        total = chain.force.sum(axis=1)
        loaded = total > NEGLIGIBLE * float(total.max())
        self.chain, self.count, self.loaded = chain, chain.force.shape[0], loaded
        self.kernels = load_kernel_package(SCREW, compiled=fast)
        floats = screw_groove.contiguous_floats
        self.units = screw_groove.surface_speed_levers(g)
        self.speed = screw_groove.nut_speed_along_path(g)
        self.groove = screw_groove.kernel_groove_arrays(g)
        shape = contacts.semi_axes_and_bound
        self.rubbing = bool(np.any(shape[..., 2] > 0.0))
        if not self.rubbing:
            shape = np.concatenate([shape[..., :2], chain.force[..., None]], axis=-1)
        self.bound = max(float(shape[..., 2].sum(axis=1).max()), 1e-30)
        self.allowed = np.isfinite(chain.allowed_closing_rate)
        slack = np.where(self.allowed, chain.allowed_closing_rate, 0.0) * g.pair.closing_speed_factor / self.speed
        self.mu = np.where(loaded & np.append(loaded[1:], loaded[:1]), chain.mu_balls, 0.0)
        ones = np.ones(self.count)
        self.balls = kernel_types.BallArrays(
            force=floats(np.where(loaded[:, None], chain.force, 0.0)),
            normal=floats(chain.normals[..., [0, 2]]),
            holding_stiffness=np.where(loaded, HOLD, HOLD_IDLE),
            allowed_closing_rate=slack,
            can_touch_next=self.allowed.astype(float),
            mu=self.mu,
            scaled_groove_mu=(g.mu or 1.0) / self.bound,
            semi_axes_and_bound=floats(shape * np.stack([ones, ones, loaded / self.bound], axis=1)[:, None]),
            contact_motion_maps=floats(contacts.contact_motion_maps / self.units),
            imposed_contact_motions=floats(contacts.imposed_contact_motions / self.speed),
        )
        n = self.count  # unbalanced forces and their derivatives, written by kernels
        self.parts = kernel_types.BalanceResiduals(*map(np.zeros, ((n, 4), n, (n, 2), (n, 4, 4))))

    def motions_without_neighbours(self) -> Array:
        """Return the scaled motions ``(N, 4)`` of the balls if neighbours exert no forces on each other.

        Loaded balls move with least dissipation, unloaded balls with the nominal motion.
        """
        x = np.tile(self.groove.nominal, (self.count, 1))
        self.kernels.write_motions_without_neighbours(self.balls, x)
        return x

    def solve_force_balance(
        self, x: Array, f: Array, eps: float, goal: float, limit: int
    ) -> tuple[Array, Array, float, int]:
        """Solve the force balance of all balls by Newton's method at one regularising speed of friction.

        ``x``: scaled motions ``(N, 4)`` and ``f``: scaled ball-to-ball forces ``(N,)`` to begin from; ``eps``:
        regularising speed divided by ``speed``; ``goal``: residual at which the iteration ends; ``limit``: largest
        number of Newton steps. Returns the scaled motions, the scaled forces, the residual (root of the sum of squares
        of the unbalanced forces) and the number of steps.
        """
        x, f = screw_groove.contiguous_floats(x).copy(), screw_groove.contiguous_floats(f).copy()
        size, steps = self.kernels.solve_force_balance_of_balls(
            self.groove, self.balls, x, f, eps, goal, ACCEPTED, limit, self.parts
        )
        return x, f, float(size), int(steps)

    def is_converged(self, f: Array) -> bool:
        """Return whether the last result of `solve_force_balance` balances the forces on all balls.

        ``f``: scaled ball-to-ball forces ``(N,)`` of this result; if the largest force is above one, the tolerance is
        multiplied by this force.
        """
        return bool(self.kernels.largest_residual(self.parts) <= ACCEPTED * max(1.0, float(np.max(f))))

    def solve_at_smallest_regularising_speed(self, x: Array, f: Array) -> tuple[Array, Array, bool, int]:
        """Solve the force balance at the smallest regularising speed of friction, with up to ``SHORT`` Newton steps.

        If the forces are in balance after exactly ``SHORT`` steps, the search goes on for higher accuracy. ``x``,
        ``f``: scaled motions ``(N, 4)`` and ball-to-ball forces ``(N,)`` to begin from. Returns the scaled motions, the
        scaled forces, whether they are in balance, and the number of Newton steps.
        """
        x, f, _, steps = self.solve_force_balance(x, f, SPEEDS[-1], GOAL, SHORT)
        good = self.is_converged(f)
        if good and steps == SHORT:
            x, f, _, further = self.solve_force_balance(x, f, SPEEDS[-1], GOAL, STEPS)
            steps += further
        return x, f, good, steps

    def solve_force_balance_by_stages(self, x: Array) -> tuple[Array, Array, int]:
        """Solve the force balance in stages of rising friction between balls, then of falling regularising speed.

        The friction between balls rises from zero at the first, largest regularising speed; then this speed falls to
        the last one. If a stage fails, a stage half way to it is inserted, at most ``DEPTH`` times in all. ``x``:
        scaled motions ``(N, 4)`` to begin from, without forces between balls. Returns the scaled motions, the scaled
        ball-to-ball forces ``(N,)``, and the number of Newton steps.
        """
        f, full, total = np.zeros(self.count), self.mu, 0
        goals = [(share, SPEEDS[0]) for share in PARTS] + [(1.0, eps) for eps in SPEEDS[1:]]
        goals.reverse()
        at, tries = goals[-1], 0
        while goals:
            share, eps = goals[-1]
            self.balls = self.balls._replace(mu=share * full)
            x_new, f_new, size, steps = self.solve_force_balance(x, f, eps, COARSE if eps > SPEEDS[-1] else GOAL, STEPS)
            total += steps
            if size > MISSED and tries < DEPTH and at != goals[-1]:
                tries += 1
                goals.append((0.5 * (at[0] + share), float(np.sqrt(at[1] * eps))))
                continue
            x, f, at = x_new, f_new, goals.pop()
        return x, f, total


def solve_motion_of_chain(
    chain: BallChain, start: tuple[Array, Array] | None = None, fast: bool = True, warm: bool = False
) -> ChainMotion:
    """Return motions and ball-to-ball forces of the balls of one track at given contact loads.

    The search begins from ``start`` if balls press on each other there (with ``warm`` also if none do), then from the
    motions that the balls have without neighbours, both by Newton's method at the last, smallest regularising speed. If
    both searches fail, friction between balls is raised and the regularising speed lowered by stages. A closed track
    needs a gap somewhere: in a track that is full of balls the forces between them are not determined.

    Parameters
    ----------
    chain
        Balls with their contact loads and the largest rates at which neighbours may approach each other.
    start
        Motions ``(N, 4)`` [rad/s] (orbit and three spins) and ball-to-ball forces ``(N,)`` [N] of a similar
        chain; None if none is known.
    fast
        Whether to use compiled kernels.
    warm
        Whether to begin from ``start`` even if no ball presses on the next one there.

    References
    ----------
    Lin (2019), 3.73 to 3.77.
    """
    s = BalanceSearch(chain, fast)
    total = 0
    if start is not None and (warm or np.any(start[1] > 0.0)):
        x, f, good, total = s.solve_at_smallest_regularising_speed(start[0] * s.units / s.speed, start[1] / s.bound)
        if good:
            return _chain_motion_in_si_units(s, x, f, total, True)
    alone = s.motions_without_neighbours()
    x, f, good, steps = s.solve_at_smallest_regularising_speed(alone, np.zeros(s.count))
    total += steps
    if not good:
        x, f, steps = s.solve_force_balance_by_stages(alone)
        total += steps
    return _chain_motion_in_si_units(s, x, f, total)


def _chain_motion_in_si_units(s: BalanceSearch, x: Array, f: Array, steps: int, from_start: bool = False) -> ChainMotion:
    """Return motion, forces and losses of the balls in SI units, from the scaled solution of a search.

    ``s``: the search with its scales; ``x``: scaled motions ``(N, 4)``; ``f``: scaled ball-to-ball forces ``(N,)``;
    ``steps``: number of Newton steps of the search; ``from_start``: whether the start that the caller gave led to the
    solution.
    """
    chain, n, eps, g = s.chain, s.count, SPEEDS[-1], s.chain.groove
    good, bound = s.is_converged(f), s.bound if s.rubbing else 0.0
    left, pair = float(np.max(np.abs(s.parts.unbalanced_forces))) * bound, g.pair
    ahead = np.append(x[1:, 0], x[0, 0])
    gap = np.where(s.allowed, s.groove.closing_rate_factor * (ahead - x[:, 0]) + s.balls.allowed_closing_rate, 0.0)
    ball_force = bound * np.where(s.allowed & (f > gap), np.maximum(f, 0.0), 0.0)
    motion = np.empty((n, 4, 3))
    pull = np.empty((n, 4, 3))
    loss = np.empty((n, 4))
    push = np.zeros((n, 3))
    ball_loss = np.zeros(n)
    s.kernels.write_contact_friction(s.balls, x, eps, motion, pull, loss)
    wrench = chain.contact_wrenches(bound * pull)
    s.kernels.write_neighbour_forces(
        s.groove, s.balls, x, ball_force, eps, pair.force_directions, pair.tangent_directions, push, ball_loss
    )
    return ChainMotion(
        q=x * s.speed / s.units,
        ball_force=ball_force,
        wrench=wrench,
        contact_motions=s.speed * motion,
        contact_friction=bound * pull,
        neighbour_forces=push,
        groove_loss=bound * s.speed * loss,
        ball_loss=ball_loss,
        closing_loss=ball_force * pair.closing_speed_factor * s.speed / g.radius * (x[:, 0] - ahead),
        input_power=chain.input_power(wrench),
        largest_unbalanced_force=left,
        largest_gap_violation=max(0.0, -float(np.min(gap))) * s.speed / pair.closing_speed_factor,
        steps=steps,
        converged=good,
        found_from_given_start=from_start,
    )


#: Number of rounds, in which contact loads and friction are solved in turn, after which both are solved as one system.
PATIENCE = 26

#: Residual aimed at when loads and friction are solved as one system, and residual up to which a stage of rising friction
#: is accepted, both over the largest friction bound of a ball.
COUPLED_GOAL, PASSED = 1e-13, 1e-9

#: Largest numbers of Newton steps in one stage of rising friction and in all stages; number of steps up to which a stage is
#: easy, so that the next one is longer.
COUPLED_STEPS, MOST, EASY = 80, 800, 8

#: Regularising speeds, as fractions of the nut's speed along the path, at which friction rises; they are tried in turn,
#: because the path of solutions may turn back at a fold.
SMOOTH = (SPEEDS[0], 1e-2, 1e-3)

#: Lengths of the first and of the shortest stage of rising friction, as fractions of the whole change of friction.
FIRST, SHORTEST = 1.0 / 32.0, 1e-5


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
    cell: screw_motion.BallsBetweenGrooves,
    slack: Array,
    start: tuple[Array, Array],
    similar_start: tuple[Array, Array] | None = None,
    fast: bool = True,
) -> LoadsAndMotionSolution:
    """Return contact loads and motion of balls with friction, solved as one system of equations.

    The search begins at positions in balance without friction and raises friction step by step. Where several states
    exist, the result is the one that develops from the state without friction.

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
    similar_start
        Displacements of balls and screw, as in ``start``, in a similar state with friction; the search begins from them if
        it fails from ``start``. None if no such state is known.
    fast
        Whether to use compiled kernels.
    """
    bare = replace(
        cell,
        ball_friction_forces=np.zeros_like(cell.ball_friction_forces),
        screw_friction_forces=np.zeros_like(cell.screw_friction_forces),
    )
    sharp, steps = float(np.log(SPEEDS[-1])), 0
    ways = [(start, eps, 0.0) for eps in SMOOTH]
    if similar_start is not None:
        ways += [(similar_start, eps, 1.0) for eps in reversed(SMOOTH)]
    for place, eps, share in ways:
        path, smooth = _LoadsAndMotionPath(bare, slack, place, fast), float(np.log(eps))
        done = share == 1.0 or path.follow_solution((share, smooth), (1.0, smooth))
        done = done and path.follow_solution((1.0, smooth), (1.0, sharp))
        steps += path.steps
        if done:
            break
    push, drag = path.state.ball_unbalanced_forces, path.state.inner_unbalanced_forces
    return LoadsAndMotionSolution(path.ball, path.screw, path.q, path.ball_force, push, drag, done, steps)


def kernel_arrays_for_loads_and_motion(
    cell: screw_motion.BallsBetweenGrooves, search: BalanceSearch
) -> kernel_types.LoadsAndMotionSystem:
    """Return the arrays with which the kernels solve contact loads and motions of balls as one system of equations.

    ``cell``: balls between screw and nut; ``search``: arrays of the chain of these balls, scaled at the present contact
    loads.
    """
    pair, total, floats = cell.groove.pair, float(search.balls.force.sum()), screw_groove.contiguous_floats
    length = float(np.max(cell.groove.contact_hertz_constants.C)) * max(total, 1e-30) ** (2.0 / 3.0)
    return kernel_types.LoadsAndMotionSystem(
        cell=screw_motion.kernel_arrays_for_contact_loads(cell),
        groove=search.groove,
        balls=search.balls,
        force_unit=search.bound,
        position_unit=length,
        ball_force_directions=floats(pair.force_directions[:, [0, 2]]),
        tangent_directions=floats(pair.tangent_directions[..., [0, 2]]),
        screw_displacement_maps=floats(cell.screw_displacement_maps),
    )


class _LoadsAndMotionPath:
    """Solution of contact loads and ball motion as one system, followed while friction rises or its regularisation fades.

    `follow_solution` moves the solution; the attributes ``ball`` and ``screw`` (displacements [m]), ``q`` (motions) and
    ``ball_force`` become fields of `LoadsAndMotionSolution`.
    """

    def __init__(
        self, cell: screw_motion.BallsBetweenGrooves, slack: Array, start: tuple[Array, Array], fast: bool
    ) -> None:
        """Begin at given positions, with the motion of the balls at the contact loads there.

        ``cell``: balls between screw and nut; ``slack``: largest rate at which ball k may approach ball k + 1 ``(N,)``
        [rad/s]; ``start``: displacements of the balls ``(N, 2)`` and of the screw ``(m,)`` [m]; ``fast``: whether to use
        compiled kernels.
        """
        self.cell, self.slack, self.fast, self.steps = cell, slack, fast, 0
        self.ball, self.screw = start
        self.compute_loads_and_scales()
        moved = solve_motion_of_chain(self.search.chain, None, fast)
        self.q, self.ball_force = moved.q, moved.ball_force

    def compute_loads_and_scales(self) -> None:
        """Compute and store the contact loads at the present positions, and the scales of the equations there."""
        g, arrays = self.cell.groove, screw_motion.kernel_arrays_for_contact_loads(self.cell)
        self.state = zero_contact_state_arrays(arrays)
        load_kernel_package(CONTACT, compiled=self.fast).contact_energy(arrays, self.ball, self.screw, self.state)
        n = self.state.normal
        normals = np.stack([n[..., 0], np.zeros_like(n[..., 0]), n[..., 1]], axis=-1)
        self.search = BalanceSearch(ScrewBallChain(g, self.state.force, normals, self.slack), self.fast)
        self.system = kernel_arrays_for_loads_and_motion(self.cell, self.search)

    def follow_solution(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Follow the solution while friction and its regularising speed change; return whether it arrived at ``end``.

        ``start``, ``end``: two parameters at the beginning and at the end: the fraction of the friction that acts on
        the contact loads (0 to 1), and the natural logarithm of the regularising speed divided by the nut's speed along
        the path.
        """
        way, step = 0.0, FIRST
        last: tuple[float, kernel_types.LoadsAndMotionUnknowns] | None = None
        while way < 1.0 and step >= SHORTEST and self.steps < MOST:
            goal, here = min(1.0, way + step), self.present_unknowns()
            guess = here
            if last is not None:
                p, u, x, f = (a + (goal - way) / (way - last[0]) * (a - b) for a, b in zip(here, last[1], strict=True))
                guess = kernel_types.LoadsAndMotionUnknowns(p, u, x, f)
            share, eps = start[0] + goal * (end[0] - start[0]), np.exp(start[1] + goal * (end[1] - start[1]))
            used = self.solve_at_fraction_of_friction(guess, float(share), float(eps))
            if used is None:
                step *= 0.5
                continue
            last, way = (way, here), goal
            step *= 1.5 if used <= EASY else 1.0
        return way >= 1.0

    def present_unknowns(self) -> kernel_types.LoadsAndMotionUnknowns:
        """Return the present displacements [m], scaled ball motions and ball-to-ball forces [N].

        Motions are surface speeds divided by the nut's speed along the path. The forces are not scaled, because the
        unit of force of the kernels changes with the contact loads.
        """
        motions = self.q * self.search.units / self.search.speed
        return kernel_types.LoadsAndMotionUnknowns(self.ball, self.screw, motions, self.ball_force)

    def solve_at_fraction_of_friction(
        self, guess: kernel_types.LoadsAndMotionUnknowns, share: float, eps: float
    ) -> int | None:
        """Solve contact loads and motion by Newton's method at one fraction of the friction and one regularising speed.

        ``guess``: unknowns to begin from, as by `present_unknowns`; ``share``: fraction of the friction that acts on
        the loads; ``eps``: regularising speed divided by the nut's speed along the path. Returns the number of Newton
        steps and stores the new solution in this object. If the steps do not converge, None is returned and the stored
        solution is not changed.
        """
        s = self.search
        p, u, x, f = (screw_groove.contiguous_floats(a).copy() for a in guess)
        f /= s.bound
        start = kernel_types.LoadsAndMotionUnknowns(p, u, x, f)
        left, used = s.kernels.solve_loads_and_motion_by_newton(self.system, start, share, eps, COUPLED_GOAL, COUPLED_STEPS)
        self.steps += int(used)
        if not left <= PASSED:
            return None
        self.ball, self.screw, self.q, self.ball_force = p, u, x * s.speed / s.units, f * s.bound
        self.compute_loads_and_scales()
        return int(used)


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


def solve_coupled_chain(
    cell: screw_motion.BallsBetweenGrooves,
    slack: Array,
    coupling: screw_motion.Coupling,
    similar: CoupledChainSolution | None = None,
    rounds: int = screw_motion.ROUNDS,
    guess: IterationStart | None = None,
) -> CoupledChainSolution:
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
    bare = screw_motion.solve_screw_contact_loads(
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
            load = screw_motion.solve_screw_contact_loads(
                replace(held, ball_friction_forces=push, screw_friction_forces=drag), place
            )
        balls = ScrewBallChain(cell.groove, load.force, cell.groove.normals(load.angle), slack)
        moved = solve_motion_of_chain(balls, start)
        new_push, new_drag = screw_motion.friction_on_balls_and_screw(
            held, moved.wrench, moved.neighbour_forces[:, [0, 2]], coupling
        )
        x, g = np.append(push, drag), np.append(new_push, new_drag)
        change, count = float(np.max(np.abs(g - x))), count + 1
        agreed = change <= screw_motion.AGREED * float(np.sum(load.force))
        if agreed or count == rounds:
            return CoupledChainSolution(bare, load, moved, change, count, agreed and load.converged and moved.converged)
        if count == PATIENCE:
            like = None if similar is None else similar.loads_with_friction.displacements
            joint = solve_loads_and_motion(held, slack, (bare.ball_displacements, bare.inner_body_displacements[:m]), like)
            if joint.reached_full_friction:
                push = joint.ball_friction_forces
                drag = joint.screw_friction_forces
                place = (joint.ball_displacements, joint.screw_displacements)
                start = (joint.q, joint.ball_force)
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
