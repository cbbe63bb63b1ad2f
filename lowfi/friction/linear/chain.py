"""Chains of balls in a linear bearing: quasi-static motion with friction, ball-to-ball contact as complementarity.

Each ball moves so that the dissipation at its grooves is least (a convex function, of which Lin 3.25 is the gradient).
Neighbours that touch add 0 <= F, 0 <= v_(k+1) - v_k, F (v_(k+1) - v_k) = 0 (Lin 3.30, 3.31): this is the constraint v_k <=
v_(k+1) of that minimisation, and the ball-to-ball force F is its multiplier. Only the sliding friction mu F between balls
is not the gradient of an energy, because its bound is the multiplier.

A solution always exists: F_k is the sum of the axial friction on balls 1 to k, no larger than the sum B of their bounds
whatever friction the balls exert on each other, so that the multipliers F(G) of the convex problem with friction bounds
mu G map [0, B]^(N-1) continuously into itself and have a fixed point F(G) = G (Brouwer). No chain jams with growing
force. But there may be several solutions (two balls in two-point contact may part or jam, many in four-point contact have
other states too): friction between balls makes the very forces that cause it.
The result then is the end of the path that begins without friction between balls, at the one solution of the convex
problem with smoothed friction, and along which that friction rises and smoothing falls
(``kernel.motion.follow_solution_path``). Balls that all part without this friction also part with it.
`find_second_equilibrium` looks for other solutions.

Two balls under opposite side forces are the case study of section 3.3.4 of Lin's thesis, by this model and by the formulas.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.laws import cubic_friction_force_factor, linear_friction_force_factor
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.linear.bearing import LinearBearing, Loads
from rollbench.lowfi.friction.linear.kernel import FILLED, WIDTH
from rollbench.lowfi.friction.linear.kernel_types import ChainArrays, ChainSearchState, NewtonArrays
from rollbench.lowfi.jit import LINEAR, load_kernel_package
from rollbench.meshes.arrays import Array, Mask

#: Outcome of the search for the motion of a row of balls, see `LinearChainSolution.status`.
Status = Literal["converged", "not converged"]

#: Regularising speed of friction, at which contacts that stick creep under a force, divided by the carriage's speed.
CREEP = 1e-8

#: Largest unbalanced force on a ball, divided by the largest friction bound of a ball, at which the search ends.
TOLERANCE = 1e-12

#: Stiffness of a weak spring that draws the motion of a ball to nominal rolling, divided by the ball's friction bound; the
#: spring fixes motions that no friction resists.
HOLD = 1e-11

#: Largest unbalanced force on a ball, divided by the largest friction bound of a ball, up to which a result counts as
#: converged; where contacts stick, round-off limits the accuracy.
ACCEPTED = 1e-9

#: Least difference of the ball-to-ball forces by which two equilibria of a row count as different, divided by the largest
#: friction bound of a ball.
ANOTHER = 1e-3

#: Coefficients of friction between balls, above the actual one, at which a search for an equilibrium with jammed balls
#: begins, and the factor by which the coefficient is then reduced step by step.
RISEN, FALLING = (0.3, 1.0), 0.85

#: Largest number of Newton steps in the search for the motion of a row of balls.
STEPS = 50_000

#: Least ratio b/a of the semi-axes of a contact ellipse that is allowed, because the friction formulas lose accuracy below
#: it.
NARROWEST = 1e-3


@dataclass(frozen=True)
class LinearChainSolution:
    """Motion, forces and losses of a row of N balls in a linear bearing."""

    #: Velocities of the balls along the track ``(N,)`` [m/s].
    velocity: Array
    #: Angular velocities omega_x, omega_y of the balls about the two axes across the track ``(N, 2)`` [rad/s].
    rotation: Array
    #: Sliding speed along the track at the contacts with the grooves ``(N, 4)`` [m/s].
    sliding: Array
    #: Spin about the normal at the contacts with the grooves ``(N, 4)`` [rad/s].
    spin: Array
    #: Friction force on the ball along the track at each contact ``(N, 4)`` [N].
    friction: Array
    #: Friction loss at the contacts with the grooves ``(N, 4)`` [W].
    groove_loss: Array
    #: Force between balls k and k + 1 ``(N-1,)`` [N].
    ball_force: Array
    #: Friction loss between balls k and k + 1 ``(N-1,)`` [W].
    ball_loss: Array
    #: Force on the carriage along the track that keeps its speed [N].
    carriage_drive_force: float
    #: Speed of the carriage [m/s].
    carriage_speed: float
    #: Number of Newton steps of the search.
    iterations: int
    #: Largest unbalanced force on a ball, divided by the largest friction bound of a ball.
    largest_imbalance_ratio: float
    #: Largest speed at which balls that press on each other approach or separate, divided by the regularising speed of
    #: friction; ideally 0.
    largest_closing_speed_ratio: float
    #: "converged" if forces are in balance and balls that press on each other stay together, else "not converged".
    status: Status

    @property
    def velocity_deviation(self) -> Array:
        """Deviation of each ball's velocity from half the carriage's, divided by that half (Lin 3.42) ``(N,)``."""
        return np.asarray(2.0 * self.velocity / self.carriage_speed - 1.0)

    @property
    def loss(self) -> float:
        """Power lost by friction of the balls, with grooves and with each other [W]."""
        return float(self.groove_loss.sum() + self.ball_loss.sum())

    @property
    def power(self) -> float:
        """Input power [W]: force that drives the carriage times its speed."""
        return self.carriage_drive_force * self.carriage_speed


@dataclass(frozen=True)
class LinearChain:
    """Row of balls in a linear bearing under given contact loads, with its arrays in the scaled units of the kernels.

    The motion does not depend on the grooves' coefficient of friction mu, and forces and losses are proportional to it.
    Without friction (mu = 0) the unit of force is the one for mu = 1, so that the motion is the limit for a mu that
    tends to zero.
    """

    #: Bearing with the speed of its carriage and the coefficients of friction.
    bearing: LinearBearing
    #: Contacts and neighbours of the balls; speeds are in units of the carriage's speed, forces in units of ``force_unit``.
    kernel_arrays: ChainArrays
    #: Largest friction bound of a ball, the sum of mu F over its contacts [N].
    force_unit: float
    #: Sign of the carriage's speed.
    carriage_speed_sign: float

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.kernel_arrays.contacts.shape[0])


def prepare_linear_chain(bearing: LinearBearing, angles: Array, loads: Array, touching: Mask | bool = True) -> LinearChain:
    """Return a row of N balls in a linear bearing under given contact loads, prepared for `solve_linear_chain`.

    Parameters
    ----------
    bearing
        Bearing with speed and coefficients of friction.
    angles
        Contact angles ``(N, 4)`` [rad].
    loads
        Normal loads of the contacts ``(N, 4)`` [N]; zero for a contact that is open.
    touching
        Whether the distance of balls k and k + 1 is at most a ball diameter, so that they can press on each other
        ``(N-1,)``; or one value for all pairs.

    Raises
    ------
    ValueError
        Arrays of other shapes, infinite angles or loads, or negative loads.
    """
    angles, loads = np.atleast_2d(np.asarray(angles, float)), np.atleast_2d(np.asarray(loads, float))
    count = angles.shape[0]
    if angles.shape != (count, 4) or loads.shape != (count, 4):
        raise ValueError(
            "contact angles and contact loads must both have the shape (number of balls, 4 contacts of each ball), "
            f"got {angles.shape} and {loads.shape}"
        )
    if not (np.all(np.isfinite(angles)) and np.all(np.isfinite(loads)) and np.all(loads >= 0.0)):
        raise ValueError("contact angles must be finite, and contact loads finite and not negative")
    closed = np.broadcast_to(np.asarray(touching, dtype=bool), (count - 1,)).astype(float)
    bounds = (bearing.mu or 1.0) * loads
    scale = float(bounds.sum(axis=1).max())
    sign = float(np.sign(bearing.speed))
    n = linear_bearing.contact_directions(angles)
    a, _ = linear_bearing.contact_semi_axes(bearing, loads)
    contacts = np.empty((count, 4, 5))
    contacts[..., :2] = n
    contacts[..., 2] = linear_bearing.MOVING * sign
    contacts[..., 3] = bounds / scale if scale > 0.0 else 0.0
    contacts[..., 4] = a / bearing.ball_radius
    hold = HOLD * np.maximum(contacts[..., 3].sum(axis=1), HOLD)
    nominal = np.tile(np.array([0.5, 0.5 / np.cos(bearing.contact_angle), 0.0]) * sign, (count, 1))
    arrays = ChainArrays(contacts, contact_friction_constants(bearing), closed, float(bearing.mu_balls), hold, nominal)
    return LinearChain(bearing, arrays, scale, sign)


def contact_friction_constants(bearing: LinearBearing) -> Array:
    """Return the constants (b/a, q0, k1, k3) of formulas for the friction of the bearing's contacts ``(4,)``.

    b/a is the ratio of the semi-axes of the contact ellipse. Consider a contact with load F and coefficient of friction
    1 that turns about a point on its semi-axis a, at the distance c = t a from the centre. The friction force of this
    contact is f = F (k1 t - k3 t^3), and the moment about the centre M = a F (q0 - k1 t^2/2 + 3 k3 t^4/4). q0 = 3
    E(e)/8, with the complete elliptic integral E, is that of eq. (3.32) of Lin's thesis. ``bearing``: the bearing with
    its Hertz constants.

    Raises
    ------
    ValueError
        Ratio b/a of the semi-axes below 1e-3.
    """
    constants = bearing.contact_hertz_constants()
    ratio = float(constants.C_b / constants.C_a)
    if not ratio >= NARROWEST:
        raise ValueError(f"the ratio b/a of the contacts' semi-axes must lie in [{NARROWEST}, 1], got {ratio}")
    q0 = 0.375 * linear_bearing.elliptic_integral_second_kind(ratio)
    return np.array([ratio, q0, linear_friction_force_factor(ratio), cubic_friction_force_factor(ratio)])


def solve_linear_chain(chain: LinearChain, start: Array | None = None, fast: bool = True) -> LinearChainSolution:
    """Return motion, forces and losses of a row of balls in a linear bearing.

    For a carriage at rest, or a row without load, motion and friction forces are returned as zero, although any
    friction force below its bound would be in balance. A ball with less than three loaded contacts can move in some
    direction without resistance: its forces are determined, but this motion only roughly.

    Parameters
    ----------
    chain
        Chain of balls under given contact loads.
    start
        Motions from which the search begins, divided by the carriage's speed ``(N, 3)``: velocity v of each ball and, times
        the ball radius, its spins about the two axes across the track; they do not influence the result. None for nominal
        rolling.
    fast
        Whether to use compiled kernels.

    Returns
    -------
    LinearChainSolution
        Motion, forces and losses; the ``status`` says whether the forces are in balance.

    References
    ----------
    Lin (2019), 3.25 to 3.31, with exact Coulomb friction in place of the sigmoid 3.20. Tested for 2 to 200 balls at
    mu_balls 0 to 0.5, contacts without load included.
    """
    point, work = _starting_point_and_work_arrays(chain)
    if start is not None:
        point.motion_less_nominal[:] = np.asarray(start, dtype=float) - chain.kernel_arrays.nominal_motion
    if chain.force_unit == 0.0 or chain.carriage_speed_sign == 0.0:
        return _solution_in_si_units(chain, point, (0, 0.0), fast)
    kernels = load_kernel_package(LINEAR, compiled=fast)
    done = kernels.solve_motion_of_ball_row(chain.kernel_arrays, point, work, CREEP, TOLERANCE, STEPS)
    return _solution_in_si_units(chain, point, done, fast)


def may_have_several_equilibria(chain: LinearChain) -> bool:
    """Return whether a row of balls may have several equilibria: neighbours touch, and there is friction between them.

    Parameters
    ----------
    chain
        Chain of balls under given contact loads.
    """
    return bool(
        chain.bearing.mu_balls > 0.0
        and chain.kernel_arrays.can_touch_next.any()
        and chain.force_unit > 0.0
        and chain.carriage_speed_sign != 0.0
    )


def find_second_equilibrium(
    chain: LinearChain, known: LinearChainSolution, fast: bool = True
) -> LinearChainSolution | None:
    """Return an equilibrium of a row of balls other than a known one; None if none is found, though one may exist.

    The search begins from several states: the end of the path of solutions along which the friction between balls rises
    to its full value, the motion without this friction, and all pairs pressed together. The search also begins from the
    end of the path for higher coefficients of friction between balls (``RISEN``), and follows that state while the
    coefficient falls to that of the chain. If there are several states, the one with the largest ball-to-ball force is
    returned. Without friction between balls there is only one state.

    Parameters
    ----------
    chain
        Chain of balls under given contact loads.
    known
        Known state of the chain, as `solve_linear_chain` returns it.
    fast
        Whether to use compiled kernels.
    """
    engine = load_kernel_package(LINEAR, compiled=fast)

    def equilibria_from_all_starts() -> Iterator[LinearChainSolution]:
        """Yield the solutions, converged or not, to which the searches from all starts lead."""
        for start in range(engine.STARTS):
            point, work = _starting_point_and_work_arrays(chain)
            done = engine.solve_motion_from_other_start(chain.kernel_arrays, point, work, CREEP, TOLERANCE, STEPS, start)
            yield _solution_in_si_units(chain, point, done, fast)
        for mu in (mu for mu in RISEN if mu > chain.bearing.mu_balls):
            point, work = _starting_point_and_work_arrays(chain)
            at = chain.kernel_arrays._replace(mu=mu)
            done = engine.solve_motion_from_other_start(at, point, work, CREEP, TOLERANCE, STEPS, 0)
            while at.mu > chain.bearing.mu_balls and done[1] <= ACCEPTED and point.ball_to_ball_unknowns.max() > 0.0:
                at = at._replace(mu=max(at.mu * FALLING, chain.bearing.mu_balls))
                done = engine.motion_from_state(at, point, work, CREEP, TOLERANCE)
            if at.mu == chain.bearing.mu_balls:
                yield _solution_in_si_units(chain, point, done, fast)

    if not may_have_several_equilibria(chain):
        return None
    good = (other for other in equilibria_from_all_starts() if other.status == "converged")
    others = [s for s in good if np.abs(s.ball_force - known.ball_force).max() > ANOTHER * chain.force_unit]
    return max(others, key=lambda other: float(other.ball_force.max()), default=None)


def _starting_point_and_work_arrays(chain: LinearChain) -> tuple[ChainSearchState, NewtonArrays]:
    """Return the nominal motion without ball-to-ball forces as the start of a search, and Newton's work arrays."""
    count, n = chain.count, 4 * chain.count
    point = ChainSearchState(np.zeros((count, 4, 2)), np.zeros((count - 1, 3)), np.zeros((count, 3)), np.zeros(count - 1))
    return point, NewtonArrays(np.empty((n, WIDTH)), np.empty((n, FILLED)), np.empty(n), np.empty(n), np.zeros(n))


def _solution_in_si_units(
    chain: LinearChain, point: ChainSearchState, steps_and_residual: tuple[int, float], fast: bool
) -> LinearChainSolution:
    """Return motion, forces and losses of a row of balls in SI units at the ``point`` where a search ended.

    ``steps_and_residual``: number of Newton steps of the search, and its largest unbalanced force divided by the
    chain's ``force_unit``; ``fast``: whether to use compiled kernels.
    """
    contacts, shape, _, mu_balls, _, nominal = chain.kernel_arrays
    slips, pair, drift, push = point
    speed = abs(chain.bearing.speed)
    x = (nominal + drift) * speed
    force, moment = np.zeros(slips.shape[:2]), np.zeros(slips.shape[:2])
    law = load_kernel_package(LINEAR, compiled=fast).regularised_friction
    for j, i in np.ndindex(*force.shape):
        force[j, i], moment[j, i], *_ = law(slips[j, i, 0], slips[j, i, 1], shape, CREEP)
    scale = chain.force_unit if chain.bearing.mu > 0.0 else 0.0
    bound = scale * contacts[..., 3]
    rub = np.hypot(pair[:, 1], pair[:, 2])
    bite = np.divide(rub, np.hypot(rub, CREEP))
    radius = chain.bearing.ball_radius
    lam = np.maximum(push, 0.0)
    iterations, residual = steps_and_residual
    spin = np.divide(slips[..., 1], contacts[..., 4], out=np.zeros_like(force), where=contacts[..., 3] > 0.0)
    lag = float(np.max(np.abs(pair[lam > 0.0, 0]), initial=0.0)) / CREEP
    good = max(residual, lag) <= ACCEPTED
    return LinearChainSolution(
        velocity=x[:, 0],
        rotation=x[:, 1:] / radius,
        sliding=slips[..., 0] * speed,
        spin=spin * speed / radius,
        friction=-bound * force,
        groove_loss=bound * (slips[..., 0] * force + slips[..., 1] * moment) * speed,
        ball_force=scale * lam,
        ball_loss=mu_balls * scale * lam * bite * rub * speed,
        carriage_drive_force=float(-(bound * force * linear_bearing.MOVING).sum()),
        carriage_speed=chain.bearing.speed,
        iterations=iterations,
        largest_imbalance_ratio=residual,
        largest_closing_speed_ratio=lag,
        status="converged" if good else "not converged",
    )


@dataclass(frozen=True)
class LinearPairSolution:
    """Motion and forces of two balls in a linear bearing (Lin's case study), without and with contact between them.

    The deviations epsilon of Lin's Table 3.4 are ``apart.velocity_deviation``.
    """

    #: State of the two balls if they are too far apart to touch.
    apart: LinearChainSolution
    #: State of the two balls at a distance of one ball diameter, where they press on each other or separate.
    touching: LinearChainSolution

    @property
    def ball_to_ball_force(self) -> float:
        """Force between the two balls at a distance of one ball diameter [N]; zero if they separate."""
        return float(self.touching.ball_force[0])

    @property
    def velocity_deviation_difference(self) -> float:
        """Relative velocity deviation of ball 1 less that of ball 2, without contact; if positive, the balls approach."""
        return float(self.apart.velocity_deviation[0] - self.apart.velocity_deviation[1])

    @property
    def friction_increase(self) -> float:
        """Relative increase of the friction losses, and of the drive force, by contact of the two balls with each other."""
        return self.touching.loss / self.apart.loss - 1.0

    @property
    def groove_and_ball_loss_ratio(self) -> float:
        """One plus the ratio of the loss between the balls to the loss at the grooves (Lin Figure 3.15 (c)).

        The loss at the grooves is computed without ball-to-ball contact.
        """
        return 1.0 + float(self.touching.ball_loss[0]) / self.apart.loss


def pair_angles_and_loads(
    bearing: LinearBearing,
    theta: float,
    side_force_ratio: float,
    vertical: float,
    *,
    mated: bool = False,
    loads: Loads = "balanced",
) -> tuple[Array, Array]:
    """Return the contact angles [rad], then the contact loads [N] of the two balls of Lin's case study, ``(2, 4)`` each.

    Both balls are under the vertical force N_y. The side force on the first ball is rho N_y, with rho the
    ``side_force_ratio``, and that on the second ball -rho N_y.

    Parameters
    ----------
    bearing
        Bearing with the Hertz constants of its contacts.
    theta
        Angle theta by which the contact angles on the bottom groove differ from the nominal one: by -theta at the left, by
        +theta at the right contact [rad].
    side_force_ratio
        Ratio N_x/N_y of side force to vertical force.
    vertical
        Vertical force N_y on each ball [N].
    mated
        Whether the contact angles on the top groove differ from the nominal one by the same amounts as those opposite to
        them on the bottom groove, design (b) of section 3.3.4.2 of Lin's thesis; otherwise they are the nominal one.
    loads
        How the contact loads are computed, see `solve_pair_of_linear_balls`.
    """
    angles = bearing.contact_angle + linear_bearing.contact_angle_deviations(np.array([theta, theta]), mated=mated)
    side = np.array([side_force_ratio, -side_force_ratio])
    if loads == "diagonal":
        return angles, linear_bearing.loads_equal_on_diagonals(vertical, side, bearing.contact_angle)
    if loads == "balanced":
        return angles, linear_bearing.loads_in_equilibrium(angles, vertical, side)
    force, turned = linear_bearing.loads_of_elastic_contacts(bearing, angles, vertical, side)
    return turned, force


def solve_pair_of_linear_balls(
    bearing: LinearBearing,
    theta: float,
    side_force_ratio: float,
    vertical: float,
    *,
    mated: bool = False,
    loads: Loads = "balanced",
    fast: bool = True,
) -> LinearPairSolution:
    """Return the states of two balls of a linear bearing without and with contact (section 3.3.4 of Lin's thesis).

    Parameters
    ----------
    bearing
        Bearing with speed and coefficients of friction.
    theta
        Angle theta by which the contact angles on the bottom groove differ from the nominal one: by -theta at the left, by
        +theta at the right contact [rad].
    side_force_ratio
        Ratio N_x/N_y of side force to vertical force on the first ball; the second has the opposite side force.
    vertical
        Vertical force N_y on each ball [N].
    mated
        Whether the contact angles on the top groove differ from the nominal one by the same amounts as those opposite to
        them on the bottom groove, design (b) of section 3.3.4.2 of Lin's thesis; otherwise they are the nominal one.
    loads
        How the contact loads are computed. ``"balanced"``: from equilibrium at the given contact angles, which yields the
        deviations epsilon printed in Lin's Table 3.4; ``"diagonal"``: equal loads on each diagonal as in Lin's text before
        eq. (3.54), with which the epsilons of the two balls are equal and opposite; ``"elastic"``: contact angles follow
        the loads.
    fast
        Whether to use compiled kernels.
    """
    angles, force = pair_angles_and_loads(bearing, theta, side_force_ratio, vertical, mated=mated, loads=loads)
    apart, together = (prepare_linear_chain(bearing, angles, force, touching) for touching in (False, True))
    return LinearPairSolution(solve_linear_chain(apart, fast=fast), solve_linear_chain(together, fast=fast))


class ModelAndFormula(NamedTuple):
    """One quantity by the numerical model and by a closed formula, for T angles theta and R side force ratios rho.

    theta is the angle by which the contact angles on the bottom groove differ from the nominal one, rho the ratio of side
    force to vertical force.
    """

    #: Quantity by the numerical model ``(T, R)``.
    numerical: Array
    #: Quantity by the closed formula ``(T, R)``.
    formula: Array

    @property
    def error(self) -> Array:
        """Error of the formula: its value less that of the numerical model ``(T, R)``, in the quantity's unit."""
        return np.asarray(self.formula - self.numerical)


@dataclass(frozen=True)
class LinearPairResultsOverGrid:
    """Results for two balls over a grid of T angles theta and R side force ratios rho (Lin Figures 3.14 and 3.15).

    theta is the angle by which the contact angles on the bottom groove differ from the nominal one, rho the ratio of side
    force to vertical force.
    """

    #: Angles theta by which the contact angles on the bottom groove differ from the nominal one ``(T,)`` [rad].
    contact_angle_deviation: Array
    #: Ratios of side force to vertical force ``(R,)``.
    side_force_ratio: Array
    #: Difference epsilon_1 - epsilon_2 of the relative deviations of the first and the second ball's velocities from the
    #: nominal velocity, without ball-to-ball contact.
    velocity_deviation_difference: ModelAndFormula
    #: Force between the two balls [N].
    force: ModelAndFormula
    #: One plus the ratio of the loss between the balls to the loss at the grooves without ball-to-ball contact.
    groove_and_ball_loss_ratio: ModelAndFormula
    #: Number of solutions of the numerical model, without or with ball-to-ball contact, that did not converge.
    unconverged_state_count: int


def pair_results_over_grid(
    bearing: LinearBearing, theta: Array, rho: Array, vertical: float, k_f: float
) -> LinearPairResultsOverGrid:
    """Return the results of numerical model and closed formulas for two balls, for T angles theta and R side force ratios.

    The contact angles on the bottom groove differ from the nominal one by theta. The results are those in Figures 3.14 and
    3.15 of Lin's thesis.

    Parameters
    ----------
    bearing
        Bearing with speed and coefficients of friction.
    theta
        Angles theta by which the contact angles on the bottom groove differ from the nominal one ``(T,)`` [rad].
    rho
        Ratios of side force to vertical force on the first ball ``(R,)``; the second has the opposite side force.
    vertical
        Vertical force N_y on each ball [N].
    k_f
        Slope of the friction force, divided by mu F (coefficient of friction times contact load), per c/a in the
        formulas; c is the distance of the centre of rotation from the centre of the contact ellipse along its semi-axis
        a.
    """
    values, failures = np.empty((3, 2, len(theta), len(rho))), 0
    for i, j in np.ndindex(len(theta), len(rho)):
        result = solve_pair_of_linear_balls(bearing, float(theta[i]), float(rho[j]), vertical)
        failures += sum(r.status != "converged" for r in (result.apart, result.touching))
        losses = result.groove_and_ball_loss_ratio
        values[:, 0, i, j] = result.velocity_deviation_difference, result.ball_to_ball_force, losses
        values[:, 1, i, j] = pair_results_by_formulas(bearing, float(theta[i]), float(rho[j]), vertical, k_f)
    difference, force, ratio = (ModelAndFormula(*both) for both in values)
    return LinearPairResultsOverGrid(theta, rho, difference, force, ratio, failures)


def pair_results_by_formulas(
    bearing: LinearBearing, theta: float, side_force_ratio: float, vertical: float, k_f: float, *, mated: bool = False
) -> tuple[float, float, float]:
    """Return the results of Lin's closed formulas for two balls, with equal contact loads on each diagonal.

    Parameters
    ----------
    bearing
        Bearing with speed and coefficients of friction.
    theta
        Angle theta by which the contact angles on the bottom groove differ from the nominal one: by -theta at the left, by
        +theta at the right contact [rad].
    side_force_ratio
        Ratio of side force to vertical force on the first ball; the second has the opposite side force.
    vertical
        Vertical force N_y on each ball [N].
    k_f
        Slope of the friction force, divided by mu F (coefficient of friction times contact load), per c/a, which Lin
        reads off a figure; c is the distance of the centre of rotation from the centre of the contact ellipse along its
        semi-axis a.
    mated
        Whether the contact angles on the top groove differ from the nominal one by the same amounts as those opposite to
        them on the bottom groove, design (b) of section 3.3.4.2 of Lin's thesis; otherwise they are the nominal one.

    Returns
    -------
    tuple[float, float, float]
        Difference epsilon_1 - epsilon_2 of the relative deviations of the balls' velocities, ball-to-ball force [N], and
        ratio of groove loss plus loss between balls to groove loss.

    References
    ----------
    Lin (2019), 3.43, 3.51 and 3.53 at the loads of the text before 3.54.
    """
    side = np.array([side_force_ratio, -side_force_ratio])
    loads = linear_bearing.loads_equal_on_diagonals(vertical, side, bearing.contact_angle)
    turn = linear_bearing.contact_angle_deviations(np.array([theta, theta]), mated=mated)
    epsilon = linear_bearing.relative_velocity_deviation(bearing.contact_angle, turn, loads[:, 0], loads[:, 1])
    difference = float(epsilon[0] - epsilon[1])
    force = linear_bearing.ball_force_by_formula(bearing, loads[:, :2], np.array(difference), k_f)
    baseline = float(linear_bearing.groove_spin_loss(bearing, loads).sum())
    return difference, float(force), 1.0 + float(linear_bearing.ball_to_ball_loss(bearing, force)) / baseline
