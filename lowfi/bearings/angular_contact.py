"""Angular-contact ball bearing under thrust: contact angle, axial deflection, load and stiffness.

Assumptions: rigid rings, equal balls, no radial load, no inertia. The centres of the two grooves are A = r_i + r_o - D
apart; an axial displacement u of the inner ring increases their distance from A to

    s = sqrt((A sin alpha_0 + u)^2 + (A cos alpha_0)^2),    tan alpha = (A sin alpha_0 + u) / (A cos alpha_0),           (1)

and a ball carries

    Q = ((s - A) / (C_i + C_o))^(3/2),                                                                                  (2)

with the constants C of exact Hertz contact at both races. All quantities are explicit in u; only the displacement under a
given load is iterated. Equivalent to Smith (1994), 2.1-2.23, who iterates the contact angle: his eq. 2.23 is
u = A sin(alpha - alpha_0) / cos(alpha).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rollbench.lowfi import hertz
from rollbench.meshes.arrays import Array

#: Range of conformities (groove radius over ball diameter) in which `conformity_from_pair_rigidity` searches.
CONFORMITIES = (0.503, 0.65)
#: Iterations: largest number of steps, relative size of a step at which they end, and displacement over ball diameter from
#: which they start.
STEPS, ENOUGH, BEGINS = 40, 1e-10, 1e-4

#: Message of a thrust [N] beyond the range of Hertz's theory.
TOO_LARGE = (
    "a thrust of {:.3g} N is too large for Hertz contact in a bearing: it would displace the inner ring by more than the "
    "ball's diameter"
)


@dataclass(frozen=True)
class BallBearing:
    """Angular-contact ball bearing, or many at once: a single row of balls between two grooves, all of one material.

    The dimensions are numbers, or arrays of one common shape for many bearings; arrays of displacements or loads must then
    broadcast with them.

    Raises
    ------
    ValueError
        A groove radius does not exceed the ball's, the rings give no contact angle, or a value is out of range.
    """

    #: Number of balls Z.
    balls: Any
    #: Ball diameter D [m].
    ball_diameter: Any
    #: Diameter d_i at the bottom of the inner groove [m].
    inner_raceway: Any
    #: Diameter d_o at the bottom of the outer groove [m].
    outer_raceway: Any
    #: Radius r_i of the inner groove in an axial section [m].
    inner_groove: Any
    #: Radius r_o of the outer groove in an axial section [m].
    outer_groove: Any
    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float

    def __post_init__(self) -> None:
        """Check that the dimensions give a contact angle and a Hertz contact; raise ValueError otherwise."""
        d, young, poisson = self.ball_diameter, self.young, self.poisson
        if np.min(self.balls) < 1 or np.min(d) <= 0.0 or young <= 0.0 or not 0.0 <= poisson < 0.5:
            given = f"{np.min(self.balls)} balls of {np.min(d):g} m, Young's modulus {young:g} Pa"
            raise ValueError(
                f"ball bearing: got {given}, Poisson's ratio {poisson:g}; allowed: values above 0, Poisson's ratio 0 "
                "to below 0.5"
            )
        if np.any(np.minimum(self.inner_groove, self.outer_groove) <= 0.5 * d):
            radii = f"groove radii of {np.min(self.inner_groove):g} and {np.min(self.outer_groove):g} m"
            raise ValueError(f"ball bearing: got {radii}; allowed: more than the ball's radius of {0.5 * np.max(d):g} m")
        most = 2.0 * self.centre_distance
        if not np.all((-1e-12 * d <= self.clearance) & (self.clearance <= most)):
            raise ValueError(
                f"ball bearing: got a diametral clearance of {np.min(self.clearance):g} m; allowed: 0 to "
                f"{np.min(most):g} m, twice the distance of the groove centres"
            )

    @property
    def pitch_diameter(self) -> Any:
        """Pitch diameter d_m [m] (Smith 1994, eq. 2.10)."""
        return 0.5 * (self.inner_raceway + self.outer_raceway)

    @property
    def centre_distance(self) -> Any:
        """Distance A of the groove centres when the unloaded ball just touches both grooves [m] (Smith 1994, eq. 2.3)."""
        return self.inner_groove + self.outer_groove - self.ball_diameter

    @property
    def clearance(self) -> Any:
        """Diametral clearance P_d [m] (Smith 1994, eq. 2.4)."""
        return self.outer_raceway - self.inner_raceway - 2.0 * self.ball_diameter

    @property
    def free_angle(self) -> Any:
        """Contact angle alpha_0 without load [rad] (Smith 1994, eq. 2.2)."""
        return np.arccos(np.minimum(1.0 - 0.5 * self.clearance / self.centre_distance, 1.0))

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]; zero where the balls are loose."""
        return float(bearing_state_at_displacement(self, deflection).thrust)

    def stiffness(self, deflection: float) -> float:
        """Return the slope of the thrust over the axial deflection [N/m] at a deflection [m]; zero if balls are loose."""
        return float(bearing_state_at_displacement(self, deflection).stiffness)

    def deflection(self, load: float) -> float:
        """Return the axial displacement u of the inner ring [m] under a thrust [N], to round-off.

        Parameters
        ----------
        load
            Thrust [N].

        Raises
        ------
        ValueError
            The load is negative, or so large that it needs a displacement of more than the ball's diameter, for which Hertz
            contact is not valid.

        Examples
        --------
        >>> b = bearing_with_contact_angle(16, 22.23e-3, 125.26e-3, (0.5232, 0.5232), np.radians(40.0), 206e9, 0.3)
        >>> round(b.deflection(17727.0) * 1e6, 3)
        36.0
        """
        if load < 0.0:
            raise ValueError(
                f"thrust on a row of balls: got {load:g} N; allowed: at least 0 N, it carries one direction only"
            )
        if load == 0.0:
            return 0.0
        state = bearing_states_under_thrust(self, np.array(load))
        return float(state.displacement + (load - state.thrust) / state.stiffness)


def bearing_with_contact_angle(
    balls: Any,
    ball_diameter: Any,
    pitch_diameter: Any,
    conformity: tuple[Any, Any],
    angle: Any,
    young: float,
    poisson: float,
) -> BallBearing:
    """Return the ball bearing with a given contact angle and given conformities, as a catalogue describes it.

    The diametral clearance that gives the angle is divided equally between both raceways.

    Parameters
    ----------
    balls
        Number of balls.
    ball_diameter, pitch_diameter
        Diameters of balls and pitch circle [m].
    conformity
        Groove radius over ball diameter of inner and outer groove.
    angle
        Contact angle without load [rad].
    young, poisson
        Young's modulus [Pa] and Poisson's ratio.
    """
    grooves = [c * ball_diameter for c in conformity]
    play = (sum(grooves) - ball_diameter) * (1.0 - np.cos(angle))
    raceways = pitch_diameter - ball_diameter - play, pitch_diameter + ball_diameter + play
    return BallBearing(balls, ball_diameter, *raceways, grooves[0], grooves[1], young, poisson)


@dataclass(frozen=True)
class BallBearingThrustState:
    """Contact angle, loads and stiffness of a ball bearing at axial displacements of its inner ring.

    Each field has the shape of the displacements.
    """

    #: Axial displacement u of the inner ring [m].
    displacement: Array
    #: Contact angle alpha under load [rad].
    contact_angle: Array
    #: Sum of the Hertz approaches of a ball at both races [m].
    approach: Array
    #: Contact force Q of a ball [N].
    ball_load: Array
    #: Thrust Z Q sin(alpha) [N].
    thrust: Array
    #: Axial stiffness dF/du of the bearing, F being the thrust [N/m].
    stiffness: Array
    #: Hertz constants of a ball on the inner race.
    inner_hertz: hertz.HertzConstants
    #: Hertz constants of a ball on the outer race.
    outer_hertz: hertz.HertzConstants

    def contact_areas(self) -> tuple[Array, Array]:
        """Return the areas pi a b of a ball's contact ellipses with inner and outer race [m^2]; a, b: semi-axes.

        They follow Smith (1994), eq. 2.27.
        """
        grown = np.pi * np.cbrt(self.ball_load) ** 2
        return grown * self.inner_hertz.C_a * self.inner_hertz.C_b, grown * self.outer_hertz.C_a * self.outer_hertz.C_b


def relative_curvatures(bearing: BallBearing, angle: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the relative curvatures of a ball with inner and outer race [1/m], each a pair (across, along the track).

    Along the track the raceway is taken for the cone that touches it at the contact: its radius of curvature is d_m/(2 cos
    alpha) less (inner) or plus (outer) the ball's radius, with the pitch diameter d_m and the contact angle alpha. Valid up
    to a contact angle of 90 deg, where the raceway is a flat disc.

    Parameters
    ----------
    bearing
        One bearing or many.
    angle
        Contact angle [rad].

    References
    ----------
    Smith (1994), figures 2-5 and 2-6.
    """
    d, across = bearing.ball_diameter, 2.0 / bearing.ball_diameter
    c, dm = np.cos(angle), bearing.pitch_diameter
    inner = (across - 1.0 / bearing.inner_groove + 0.0 * c, across + 2.0 * c / (dm - d * c))
    outer = (across - 1.0 / bearing.outer_groove + 0.0 * c, across - 2.0 * c / (dm + d * c))
    return inner, outer


def bearing_state_at_displacement(bearing: BallBearing, displacement: Array | float) -> BallBearingThrustState:
    """Return contact angle, ball load, thrust and stiffness of a bearing at axial displacements of its inner ring.

    The state follows in closed form from the geometry of the grooves and Hertz's law, eqs. (1) and (2) in the docstring of
    this module.

    The stiffness includes the change of the contact angle, and of the Hertz constants with it. With the approach C F^(2/3)
    and the semi-axis C_a F^(1/3) under the force F, the derivative of C by the curvature along that semi-axis is C_a^2/6.
    This is exact, because the approach is the derivative of the contact's least energy with respect to its force.

    Parameters
    ----------
    bearing
        One bearing or many.
    displacement
        Axial displacements u [m], an array of any shape; the load is zero where the balls are loose, u <= 0.

    Returns
    -------
    BallBearingThrustState
        The state. Valid if the contact ellipses lie inside the raceways. Thrust in the opposite direction is not modelled:
        balls pushed back beyond their clearance stay loose.

    References
    ----------
    Smith (1994), 2.1 to 2.23.

    Examples
    --------
    >>> b = bearing_with_contact_angle(16, 22.23e-3, 125.26e-3, (0.5232, 0.5232), np.radians(40.0), 206e9, 0.3)
    >>> round(float(bearing_state_at_displacement(b, 36e-6).thrust))
    17727
    """
    u = np.asarray(displacement, dtype=float)
    a, rest = bearing.centre_distance, bearing.free_angle
    axial, radial = a * np.sin(rest) + u, a * np.cos(rest)
    s = np.hypot(axial, radial)
    angle = np.arctan2(axial, radial)
    # s - A without cancellation
    approach = np.where(u > 0.0, u * (2.0 * a * np.sin(rest) + u) / (s + a), 0.0)
    modulus = hertz.contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    inner, outer = (hertz.hertz_constants(*pair, modulus) for pair in relative_curvatures(bearing, angle))
    c = inner.C + outer.C
    q = hertz.contact_force(approach, c)
    sin, cos = np.sin(angle), np.cos(angle)
    # dQ/du: by the approach, sin(alpha) per u, and by the angle, cos(alpha)/s per u
    by_angle = _slope_of_hertz_constants_by_angle(bearing, angle, inner, outer)
    slope = hertz.contact_stiffness_at_approach(approach, c) * (sin - approach * by_angle / c * cos / s)
    load, stiffness = bearing.balls * q * sin, bearing.balls * (slope * sin + q * cos**2 / s)
    return BallBearingThrustState(u, angle, approach, q, load, stiffness, inner, outer)


def _slope_of_hertz_constants_by_angle(
    bearing: BallBearing, angle: Array, inner: hertz.HertzConstants, outer: hertz.HertzConstants
) -> Array:
    """Return the derivative of the sum C_i + C_o of both races' Hertz constants with respect to the contact angle alpha.

    Of the curvatures, only the one along the track depends on alpha. ``angle``: contact angle alpha [rad]; ``inner``,
    ``outer``: Hertz constants of the contacts with inner and outer race.
    """
    d, dm, sin, cos = bearing.ball_diameter, bearing.pitch_diameter, np.sin(angle), np.cos(angle)
    bends = (-2.0 * dm * sin / (dm - d * cos) ** 2, 2.0 * dm * sin / (dm + d * cos) ** 2)
    total = np.zeros_like(sin)
    for (across, along), h, bend in zip(relative_curvatures(bearing, angle), (inner, outer), bends, strict=True):
        axis = np.where(along >= across, h.C_b, h.C_a)  # the greater curvature belongs to the minor semi-axis
        total = total + axis**2 / 6.0 * bend
    return np.asarray(total)


def dimensionless_hertz_parameters(curvature_difference: float) -> tuple[float, float, float]:
    """Return the dimensionless approach delta* and semi-axes a*, b* of elliptical Hertz contact, from exact integrals.

    a = a* (3 Q/(2 E* S))^(1/3), the same for b, and delta = delta* (3 Q/(2 E* S))^(2/3) S/2, with the load Q, the contact
    modulus E* and the sum S of the curvatures.

    Parameters
    ----------
    curvature_difference
        Ratio F of curvature difference to curvature sum, in [0, 1).

    Raises
    ------
    ValueError
        The difference is outside [0, 1); F = 1 is a line contact.

    References
    ----------
    Smith (1994), Table 2-1 and 2.19 to 2.21, with the limit of his elliptic integrals 2.14 and 2.15 corrected to pi/2.

    Examples
    --------
    >>> [round(v, 4) for v in dimensionless_hertz_parameters(0.90999)]
    [0.6636, 3.2327, 0.4499]
    """
    if not 0.0 <= curvature_difference < 1.0:
        raise ValueError(
            f"ratio of curvature difference to sum: got {curvature_difference:g}; allowed: 0 to below 1 (1 is a line "
            "contact)"
        )
    h = hertz.hertz_constants(np.array(1.0 - curvature_difference), np.array(1.0 + curvature_difference), 1.0)
    unit = float(np.cbrt(4.0 / 3.0))
    return float(h.C) * unit**2, float(h.C_a) * unit, float(h.C_b) * unit


def bearing_states_under_thrust(bearings: BallBearing, load: Array) -> BallBearingThrustState:
    """Return contact angle, displacement and stiffness of many ball bearings under given thrusts.

    Newton's method is applied to F^(2/3), which is nearly linear in the displacement u.

    Parameters
    ----------
    bearings
        One bearing or many.
    load
        Thrusts F [N] above zero, of a shape that broadcasts with the bearings' fields.

    Raises
    ------
    ValueError
        A thrust needs a displacement of more than the ball's diameter, for which Hertz contact is not valid.
    """
    first = BEGINS * bearings.ball_diameter
    u = hertz.contact_approach(load / bearing_state_at_displacement(bearings, first).thrust, first)
    for _ in range(STEPS):
        state = bearing_state_at_displacement(bearings, u)
        step = 1.5 * (np.cbrt(load / state.thrust) ** 2 - 1.0) * state.thrust / state.stiffness
        u = np.maximum(u + step, 0.2 * u)
        if float(np.abs(step / u).max()) < ENOUGH and bool(np.all(u < bearings.ball_diameter)):
            return state
    raise ValueError(TOO_LARGE.format(float(np.max(load))))


def conformity_from_pair_rigidity(bearings: BallBearing, preload: Array, rigidity: Array) -> Array:
    """Return the conformities (groove radius over ball diameter) at which preloaded bearing pairs have given stiffnesses.

    A pair consists of two equal bearings. Its axial stiffness falls with the conformity c, nearly as a power of c - 1/2, so
    the secant method is applied to the logarithms.

    Parameters
    ----------
    bearings
        The bearings; the search starts from the conformities of their inner grooves.
    preload
        Force [N] that presses the two bearings of a pair against each other.
    rigidity
        Axial stiffness of the pair [N/m], twice that of either bearing under the preload.

    Returns
    -------
    Array
        Groove radius over ball diameter, the same for both grooves.

    Raises
    ------
    ValueError
        No conformity within `CONFORMITIES` gives the stiffness.
    """
    low, high = np.log(np.array(CONFORMITIES) - 0.5)

    def logarithm_of_stiffness_ratio(x: Array) -> Array:
        """Return the logarithm of computed over given stiffness of the bearing pairs, for x = log(conformity - 1/2)."""
        size, conformity = (bearings.balls, bearings.ball_diameter, bearings.pitch_diameter), 0.5 + np.exp(x)
        angle, steel = bearings.free_angle, (bearings.young, bearings.poisson)
        state = bearing_states_under_thrust(bearing_with_contact_angle(*size, (conformity,) * 2, angle, *steel), preload)
        return np.asarray(np.log(2.0 * state.stiffness / rigidity))

    old = np.log(bearings.inner_groove / bearings.ball_diameter - 0.5)
    value, slope = logarithm_of_stiffness_ratio(old), np.full_like(old, -0.2)
    for _ in range(STEPS):
        new = np.clip(old - value / slope, low, high)
        if float(np.abs(new - old).max()) < ENOUGH:
            break
        fresh = logarithm_of_stiffness_ratio(new)
        moved = new != old
        slope = np.where(moved, np.minimum((fresh - value) / np.where(moved, new - old, 1.0), -0.02), slope)
        old, value = new, fresh
    if float(np.abs(value).max()) > 1e-6:
        raise ValueError(
            "no groove conformity between {:g} and {:g} gives the bearing pairs their stiffness".format(*CONFORMITIES)
        )
    return np.asarray(0.5 + np.exp(old))
