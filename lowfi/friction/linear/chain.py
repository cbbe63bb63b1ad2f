"""Chains of balls in a linear bearing: a straight track, on which the carriage moves along the rail.

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
problem with smoothed friction, and along which that friction rises and smoothing falls (`solve_motion_of_chain`).
`find_second_equilibrium` looks for other solutions.

Axes of a ball: x3 is y (up), y3 the track's z, z3 is x (across), so that x3 x y3 = z3. Two balls under opposite side forces
are the case study of section 3.3.4 of Lin's thesis, by this model and by the formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rollbench.lowfi.friction.contact.least_dissipation import FrictionalBodies
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.linear.bearing import LinearBearing, Loads
from rollbench.lowfi.friction.screw.chain import (
    STEPS,
    BalanceSearch,
    BallChain,
    ChainMotion,
    chain_motion_in_si_units,
    search_motion_of_chain,
    solve_motion_of_chain,
)
from rollbench.lowfi.friction.screw.groove import TouchingBallsGeometry, TrackInMotion, contact_axes
from rollbench.lowfi.together import Search, solve_together
from rollbench.meshes.arrays import Array, Mask

#: Least difference of the ball-to-ball forces by which two equilibria of a row count as different, divided by the largest
#: friction bound of a ball.
ANOTHER = 1e-3

#: Coefficients of friction between balls, above the actual one, at which a search for an equilibrium with jammed balls
#: begins, and the factor by which the coefficient is then reduced step by step.
RISEN, FALLING = (0.3, 1.0), 0.85

#: Force that presses all pairs together at the start of one search for another equilibrium, over the largest friction bound
#: of a ball.
PRESSED = 3.0

#: Least ratio b/a of the semi-axes of a contact ellipse that is allowed, because the friction formulas lose accuracy below
#: it.
NARROWEST = 1e-3


@dataclass(frozen=True)
class StraightTrack(TrackInMotion):
    """Track of a linear bearing: the carriage moves along the rail; a ball's first motion is its velocity [m/s]."""

    #: Bearing with the speed of its carriage.
    bearing: LinearBearing

    @property
    def levers(self) -> Array:
        """One for the velocity, then three times the ball radius [m] ``(4,)``."""
        radius = self.bearing.ball_radius
        return np.array([1.0, radius, radius, radius])

    @property
    def speed_along_path(self) -> float:
        """Speed of the carriage [m/s], positive; 1 m/s for a carriage at rest."""
        return abs(self.bearing.speed) or 1.0

    @property
    def nominal_motion(self) -> Array:
        """Half the carriage's velocity [m/s], and the spin about x of a ball that rolls at the contact angle ``(4,)``."""
        half, lever = 0.5 * self.bearing.speed, self.bearing.ball_radius * np.cos(self.bearing.contact_angle)
        return np.array([half, 0.0, 0.0, half / lever])

    @cached_property
    def pair(self) -> TouchingBallsGeometry:
        """Geometry of two touching balls; the tangents of their contact are x (z3) and y (x3)."""
        radius = self.bearing.ball_radius
        first = radius * np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0]])
        tangents = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
        return TouchingBallsGeometry(
            spacing=2.0 * radius,
            closing_speed_factor=1.0,
            first_ball_surface_speeds=first,
            second_ball_surface_speeds=-first,
            force_directions=np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]),
            tangent_directions=np.stack([tangents, tangents]),
        )

    def contact_kinematics(self, normals: Array) -> tuple[Array, Array]:
        """Return sliding vx, vz and spin at the contacts per unit of the ball's motion, then those of a resting ball.

        ``normals``: directions from the ball's centre to the contacts in x3, y3, z3 ``(N, 4, 3)``. Returns ``(N, 4, 3,
        4)`` and ``(N, 4, 3)`` (Lin 3.22-3.24).
        """
        surface = np.zeros((*normals.shape, 4))
        surface[..., 1, 0] = 1.0
        surface[..., 1:] = self.bearing.ball_radius * np.stack([np.cross(t, normals) for t in np.eye(3)], axis=-1)
        maps = contact_axes(normals) @ surface
        maps[..., 2, :] = np.concatenate([np.zeros((*normals.shape[:-1], 1)), -normals], axis=-1)
        return maps, -self.bearing.speed * linear_bearing.MOVING[:, None] * maps[..., 0]


@dataclass(frozen=True)
class LinearBallChain(BallChain):
    """Balls of one row in a linear bearing under given contact loads; contacts in the order BL, BR, TR, TL."""

    #: Straight track of the bearing.
    groove: StraightTrack

    @property
    def bearing(self) -> LinearBearing:
        """Bearing with the speed of its carriage and the coefficients of friction."""
        return self.groove.bearing

    @property
    def largest_friction_bound(self) -> float:
        """Largest sum of the friction bounds of a ball's contacts [N]; that for a coefficient of 1 without friction."""
        return (self.bearing.mu or 1.0) * float(self.force.sum(axis=1).max())

    @property
    def touching(self) -> Mask:
        """Whether balls k and k + 1 can press on each other ``(N-1,)``."""
        return np.isfinite(self.allowed_closing_rate[:-1])

    def input_power(self, wrench: Array) -> float:
        """Return the power [W] that the carriage supplies; ``wrench``: friction on the balls ``(N, 4, 6)`` [N, N m]."""
        return self.bearing.speed * carriage_drive_force(wrench)


def carriage_drive_force(wrench: Array) -> float:
    """Return the force on the carriage along the track that keeps its speed [N]; ``wrench``: friction ``(N, 4, 6)`` [N]."""
    return float((wrench[..., 1] * linear_bearing.MOVING).sum())


def velocity_deviations(bearing: LinearBearing, motion: ChainMotion) -> Array:
    """Return the deviation of each ball's velocity from half the carriage's, divided by that half (Lin 3.42) ``(N,)``."""
    return np.asarray(2.0 * motion.q[:, 0] / bearing.speed - 1.0)


def prepare_linear_chain(
    bearing: LinearBearing, angles: Array, loads: Array, touching: Mask | bool = True
) -> LinearBallChain:
    """Return a row of N balls in a linear bearing under given contact loads; `solve_motion_of_chain` solves it.

    A first ball motion is a velocity along the track [m/s]; the three others are angular velocities [rad/s], about x3,
    y3, z3. For a carriage at rest, or a row without load, motion and friction forces are returned as zero, although any
    friction force below its bound would be in balance. A ball with less than three loaded contacts can move in some
    direction without resistance: its forces are determined, but this motion only roughly. Tested for 2 to 200 balls at
    mu_balls 0 to 0.5, contacts without load included (Lin 3.25 to 3.31, with exact Coulomb friction in place of 3.20).

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
        Arrays of other shapes, infinite angles or loads, negative loads, or contact ellipses narrower than 1e-3.
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
    constants = bearing.contact_hertz_constants()
    ratio = float(constants.C_b / constants.C_a)
    if not ratio >= NARROWEST:
        raise ValueError(f"the ratio b/a of the contacts' semi-axes must lie in [{NARROWEST}, 1], got {ratio}")
    slack = np.append(np.where(np.broadcast_to(np.asarray(touching, dtype=bool), (count - 1,)), 0.0, np.inf), np.inf)
    n = linear_bearing.contact_directions(angles)
    normals = np.stack([n[..., 1], np.zeros_like(angles), n[..., 0]], axis=-1)
    least = max(1e-9 * float(loads.max(initial=0.0)), 1e-30)
    ellipses, track = linear_bearing.contact_semi_axes(bearing, np.maximum(loads, least)), StraightTrack(bearing)
    contacts = FrictionalBodies(*ellipses, bearing.mu * loads, *track.contact_kinematics(normals), np.zeros((count, 4)))
    return LinearBallChain(track, loads, normals, slack, contacts, bearing.mu_balls)


def may_have_several_equilibria(chain: LinearBallChain) -> bool:
    """Return whether a row of balls may have several equilibria: neighbours touch, and there is friction between them."""
    loaded = chain.force.any() and chain.bearing.speed != 0.0
    return bool(chain.mu_balls > 0.0 and chain.touching.any() and loaded)


def find_second_equilibrium(chain: LinearBallChain, known: ChainMotion) -> ChainMotion | None:
    """Return an equilibrium of a row of balls other than a known one; None if none is found, though one may exist.

    The search begins from several states: the end of the path of solutions along which the friction between balls rises to
    its full value, the motion of the balls without neighbours, and all pairs pressed together. It also begins from the end
    of the path for higher coefficients of friction between balls (``RISEN``), and follows that state while the coefficient
    falls to that of the chain. If there are several states, the one with the largest ball-to-ball force is returned.
    Without friction between balls there is only one state.

    Parameters
    ----------
    chain
        Chain of balls under given contact loads.
    known
        Known state of the chain, as `solve_motion_of_chain` returns it.
    """

    def at_once(force: float) -> Search[ChainMotion]:
        """Search from the motion without neighbours and from forces of ``force`` between all balls that can touch."""
        s = BalanceSearch(chain)
        alone = s.in_motion((yield from s.motions_without_neighbours()))
        return chain_motion_in_si_units(s, (yield from s.solve_at_falling_speeds(alone, force * s.allowed, STEPS)))

    def from_friction(mu: float) -> Search[ChainMotion | None]:
        """Search from the end of the path for the friction ``mu``, which then falls; None if the balls part on the way."""
        s = BalanceSearch(replace(chain, mu_balls=mu))
        alone = yield from s.motions_without_neighbours()
        at = chain_motion_in_si_units(s, (yield from s.solve_by_path(alone)))
        while mu > chain.mu_balls and at.converged and at.ball_force.max() > 0.0:
            mu = max(mu * FALLING, chain.mu_balls)
            at = yield from search_motion_of_chain(replace(chain, mu_balls=mu), (at.q, at.ball_force), warm=True)
        return at if mu == chain.mu_balls else None

    if not may_have_several_equilibria(chain):
        return None
    risen = (from_friction(mu) for mu in RISEN if mu > chain.mu_balls)
    states = solve_together([from_friction(chain.mu_balls), at_once(0.0), at_once(PRESSED), *risen])
    good = (other for other in states if other is not None and other.converged)
    others = [s for s in good if np.abs(s.ball_force - known.ball_force).max() > ANOTHER * chain.largest_friction_bound]
    return max(others, key=lambda other: float(other.ball_force.max()), default=None)


@dataclass(frozen=True)
class LinearPairSolution:
    """Motion and forces of two balls in a linear bearing (Lin's case study), without and with contact between them."""

    #: State of the two balls if they are too far apart to touch.
    apart: ChainMotion
    #: State of the two balls at a distance of one ball diameter, where they press on each other or separate.
    touching: ChainMotion
    #: Deviations epsilon of Lin's Table 3.4, of the balls too far apart to touch ``(2,)``, see `velocity_deviations`.
    velocity_deviation: Array

    @property
    def ball_to_ball_force(self) -> float:
        """Force between the two balls at a distance of one ball diameter [N]; zero if they separate."""
        return float(self.touching.ball_force[0])

    @property
    def velocity_deviation_difference(self) -> float:
        """Relative velocity deviation of ball 1 less that of ball 2, without contact; if positive, the balls approach."""
        return float(self.velocity_deviation[0] - self.velocity_deviation[1])

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
    """
    angles, force = pair_angles_and_loads(bearing, theta, side_force_ratio, vertical, mated=mated, loads=loads)
    apart, together = (
        solve_motion_of_chain(prepare_linear_chain(bearing, angles, force, touching)) for touching in (False, True)
    )
    return LinearPairSolution(apart, together, velocity_deviations(bearing, apart))


def pair_results_over_grid(
    bearing: LinearBearing, theta: Array, rho: Array, vertical: float, k_f: float
) -> tuple[Array, Array]:
    """Return the results for two balls by the numerical model, then by closed formulas, over T angles theta and R ratios.

    The contact angles on the bottom groove differ from the nominal one by theta. The results are those in Figures 3.14 and
    3.15 of Lin's thesis: difference epsilon_1 - epsilon_2 of the relative deviations of both balls' velocities from the
    nominal velocity, without ball-to-ball contact; force between the balls [N]; one plus the ratio of the loss between the
    balls to the loss at the grooves without ball-to-ball contact. Each array is ``(3, T, R)``; nan where the numerical
    model did not converge.

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
    numerical, formula = np.full((2, 3, len(theta), len(rho)), np.nan)
    for i, j in np.ndindex(len(theta), len(rho)):
        at = bearing, float(theta[i]), float(rho[j]), vertical
        result = solve_pair_of_linear_balls(*at)
        if result.apart.converged and result.touching.converged:
            losses = result.groove_and_ball_loss_ratio
            numerical[:, i, j] = result.velocity_deviation_difference, result.ball_to_ball_force, losses
        formula[:, i, j] = pair_results_by_formulas(*at, k_f)
    return numerical, formula


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
