"""Angular-contact ball bearing under thrust: contact angle, axial deflection, load and stiffness.

Rigid rings, equal balls, no radial load, no inertia. The centres of the two grooves are A = r_i + r_o - D apart; an axial
displacement u of the inner ring stretches that line from A to

    s = sqrt((A sin alpha_0 + u)^2 + (A cos alpha_0)^2),    tan alpha = (A sin alpha_0 + u) / (A cos alpha_0),

and a ball carries Q = ((s - A) / (C_i + C_o))^(3/2), C the constants of exact Hertz contact at both races. So everything
is explicit in u, and nothing is iterated but the displacement to a given load. Equivalent to Smith (1994), 2.1-2.23, where
the contact angle is iterated; u = A sin(alpha - alpha_0) / cos(alpha) is his 2.23.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.hertz import (
    HertzConstants,
    contact_approach,
    contact_force,
    contact_modulus,
    contact_slope,
    hertz_constants,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

#: Conformities among which one is looked for.
CONFORMITIES = (0.503, 0.65)
#: Steps at most, the relative step at which they end, and the displacement over the ball's diameter where they begin.
STEPS, ENOUGH, BEGINS = 40, 1e-10, 1e-4


@dataclass(frozen=True)
class BallBearing:
    """One row of balls between two grooves; lengths [m], Young's modulus [Pa].

    balls: number Z; ball_diameter: D; inner_raceway, outer_raceway: diameters d_i, d_o at the bottoms of the grooves;
    inner_groove, outer_groove: groove radii r_i, r_o in an axial section; same material throughout.
    Raises ValueError where a groove is not wider than the ball, the rings leave no clearance angle, or a number is
    out of range.
    """

    balls: int
    ball_diameter: float
    inner_raceway: float
    outer_raceway: float
    inner_groove: float
    outer_groove: float
    young: float
    poisson: float

    def __post_init__(self) -> None:
        """Refuse what has no contact angle or no Hertz contact."""
        if self.balls < 1 or self.ball_diameter <= 0.0 or self.young <= 0.0 or not 0.0 <= self.poisson < 0.5:
            raise ValueError("balls, ball diameter and Young's modulus must be positive, Poisson's ratio in [0, 0.5)")
        if min(self.inner_groove, self.outer_groove) <= 0.5 * self.ball_diameter:
            raise ValueError("groove radii must exceed the ball's radius")
        if not -1e-12 * self.ball_diameter <= self.clearance <= 2.0 * self.centre_distance:
            raise ValueError("diametral clearance must lie between 0 and twice the distance of the groove centres")

    @property
    def pitch_diameter(self) -> float:
        """d_m [m] (Smith 2.10)."""
        return 0.5 * (self.inner_raceway + self.outer_raceway)

    @property
    def centre_distance(self) -> float:
        """Distance A = B D [m] of the groove centres with the ball just touching both (Smith 2.3)."""
        return self.inner_groove + self.outer_groove - self.ball_diameter

    @property
    def clearance(self) -> float:
        """Diametral clearance P_d [m] (Smith 2.4)."""
        return self.outer_raceway - self.inner_raceway - 2.0 * self.ball_diameter

    @property
    def free_angle(self) -> float:
        """Contact angle alpha_0 [rad] without load (Smith 2.2)."""
        return float(np.arccos(min(1.0 - 0.5 * self.clearance / self.centre_distance, 1.0)))


def of_angle(
    balls: int,
    ball_diameter: float,
    pitch_diameter: float,
    conformity: tuple[float, float],
    angle: float,
    young: float,
    poisson: float,
) -> BallBearing:
    """Bearing of a free contact angle [rad] and conformities r/D of inner and outer groove, lengths [m].

    The clearance that makes the angle is taken half from each raceway, as in a catalogue drawing.
    """
    inner, outer = (c * ball_diameter for c in conformity)
    play = (inner + outer - ball_diameter) * (1.0 - np.cos(angle))
    return BallBearing(
        balls,
        ball_diameter,
        pitch_diameter - ball_diameter - play,
        pitch_diameter + ball_diameter + play,
        inner,
        outer,
        young,
        poisson,
    )


@dataclass(frozen=True)
class AngleRows:
    """Bearings given as catalogues do, many at once: numbers of balls, diameters of ball and pitch circle [m], conformities
    (groove radius over ball diameter, of both grooves), contact angles without load [rad], arrays of one shape."""

    balls: Array
    ball_diameter: Array
    pitch_diameter: Array
    conformity: Array
    free_angle: Array
    young: float
    poisson: float

    @property
    def inner_groove(self) -> Array:
        """Radii of both grooves [m]."""
        return np.asarray(self.conformity * self.ball_diameter)

    outer_groove = inner_groove

    @property
    def centre_distance(self) -> Array:
        """Distances of the groove centres [m]."""
        return np.asarray((2.0 * self.conformity - 1.0) * self.ball_diameter)


#: What thrust needs of a bearing, or of many at once: then arrays, of a shape to go with the displacements.
BallRows = BallBearing | AngleRows


@dataclass(frozen=True)
class ThrustState:
    """A bearing at axial displacements of its inner ring, each field of their shape.

    displacement: u [m]; angle: contact angle [rad]; approach: sum at both races [m]; ball_load: Q [N];
    load: thrust Z Q sin alpha [N]; stiffness: dF/du [N/m]; inner, outer: Hertz constants.
    """

    displacement: Array
    angle: Array
    approach: Array
    ball_load: Array
    load: Array
    stiffness: Array
    inner: HertzConstants
    outer: HertzConstants

    def areas(self) -> tuple[Array, Array]:
        """Areas pi a b [m^2] of one inner and one outer contact ellipse (Smith 2.27)."""
        grown = np.pi * np.cbrt(self.ball_load) ** 2
        return grown * self.inner.C_a * self.inner.C_b, grown * self.outer.C_a * self.outer.C_b


def curvatures(bearing: BallRows, angle: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Relative curvatures [1/m] (across the groove, along the track) of the inner and of the outer contact.

    Along the track the raceway is the cone that the contact angle [rad] cuts: radius d_m/(2 cos alpha) less or more the
    ball's radius (Smith, figures 2-5 and 2-6). Any contact angle up to a right one, where the raceway is a flat disc.
    """
    d, across = bearing.ball_diameter, 2.0 / bearing.ball_diameter
    c, dm = np.cos(angle), bearing.pitch_diameter
    inner = (across - 1.0 / bearing.inner_groove + 0.0 * c, across + 2.0 * c / (dm - d * c))
    outer = (across - 1.0 / bearing.outer_groove + 0.0 * c, across - 2.0 * c / (dm + d * c))
    return inner, outer


def thrust_state(bearing: BallRows, displacement: Array | float) -> ThrustState:
    """State at axial displacements u [m] of any shape; zero load where the balls are loose (u <= 0).

    No other shoulder is there for balls that are pushed back beyond their clearance, and contacts lie inside their
    raceway. The stiffness counts the turning contact angle and the change of the Hertz constants with it; for those,
    dC/d(curvature along a semi-axis) = (semi-axis constant)^2 / 6 exactly, because the approach is the derivative of the
    least energy of the contact by its force.

    >>> b = of_angle(16, 22.23e-3, 125.26e-3, (0.5232, 0.5232), np.radians(40.0), 206e9, 0.3)
    >>> round(float(thrust_state(b, 36e-6).load))
    17727
    """
    u = np.asarray(displacement, dtype=float)
    a, rest = bearing.centre_distance, bearing.free_angle
    axial, radial = a * np.sin(rest) + u, a * np.cos(rest)
    s = np.hypot(axial, radial)
    angle = np.arctan2(axial, radial)
    # s - A without cancellation
    approach = np.where(u > 0.0, u * (2.0 * a * np.sin(rest) + u) / (s + a), 0.0)
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    inner, outer = (hertz_constants(*pair, modulus) for pair in curvatures(bearing, angle))
    c = inner.C + outer.C
    q = contact_force(approach, c)
    sin, cos = np.sin(angle), np.cos(angle)
    # dQ/du: by the approach, sin(alpha) per u, and by the angle, cos(alpha)/s per u
    by_angle = _compliance_by_angle(bearing, angle, inner, outer)
    slope = contact_slope(approach, c) * (sin - approach * by_angle / c * cos / s)
    load, stiffness = bearing.balls * q * sin, bearing.balls * (slope * sin + q * cos**2 / s)
    return ThrustState(u, angle, approach, q, load, stiffness, inner, outer)


def _compliance_by_angle(bearing: BallRows, angle: Array, inner: HertzConstants, outer: HertzConstants) -> Array:
    """d(C_i + C_o)/d(alpha): only the curvature along the track depends on the angle."""
    d, dm, sin, cos = bearing.ball_diameter, bearing.pitch_diameter, np.sin(angle), np.cos(angle)
    bends = (-2.0 * dm * sin / (dm - d * cos) ** 2, 2.0 * dm * sin / (dm + d * cos) ** 2)
    total = np.zeros_like(sin)
    for (across, along), h, bend in zip(curvatures(bearing, angle), (inner, outer), bends, strict=True):
        axis = np.where(along >= across, h.C_b, h.C_a)  # the greater curvature belongs to the minor semi-axis
        total = total + axis**2 / 6.0 * bend
    return np.asarray(total)


def contact_parameters(difference: float) -> tuple[float, float, float]:
    """Dimensionless approach and semi-axes delta*, a*, b* of a curvature difference F in [0, 1), exact (Smith, table 2-1).

    a = a* (3 Q/(2 E* S))^(1/3), delta = delta* (3 Q/(2 E* S))^(2/3) S/2 with S the sum of curvatures; his 2.19-2.21, with
    the limit of the elliptic integrals (2.14, 2.15) put right to pi/2. Raises ValueError outside [0, 1): F = 1 is a line.

    >>> [round(v, 4) for v in contact_parameters(0.90999)]
    [0.6636, 3.2327, 0.4499]
    """
    if not 0.0 <= difference < 1.0:
        raise ValueError("the curvature difference must lie in [0, 1)")
    h = hertz_constants(np.array(1.0 - difference), np.array(1.0 + difference), 1.0)
    unit = float(np.cbrt(4.0 / 3.0))
    return float(h.C) * unit**2, float(h.C_a) * unit, float(h.C_b) * unit


@dataclass(frozen=True)
class BallRow:
    """A bearing as a row of a set: thrust and tangent stiffness at an axial deflection."""

    bearing: BallBearing

    def load(self, deflection: float) -> float:
        """Thrust [N] at a deflection [m]; zero where the row is loose."""
        return float(thrust_state(self.bearing, deflection).load)

    def stiffness(self, deflection: float) -> float:
        """dF/du [N/m]; zero where the row is loose."""
        return float(thrust_state(self.bearing, deflection).stiffness)

    def deflection(self, load: float) -> float:
        """Deflection [m] under a thrust [N], to round-off."""
        return displacement(self.bearing, load)


def displacement(bearing: BallBearing, load: float) -> float:
    """Axial displacement u [m] under a thrust [N], to round-off; 0 without load.

    The load grows monotonically with u. Raises ValueError for a negative load, or one that would need a displacement
    beyond the ball's diameter: such a load is no contact problem of small patches any more.
    """
    if load < 0.0:
        raise ValueError("a row of balls carries thrust in one direction only: the load must not be negative")
    if load == 0.0:
        return 0.0
    high = 1e-9 * bearing.ball_diameter
    while float(thrust_state(bearing, high).load) < load:
        high *= 4.0
        if high > bearing.ball_diameter:
            raise ValueError(f"thrust of {load:.3g} N is beyond what Hertz contact describes for this bearing")

    def excess(u: float) -> float:
        return float(thrust_state(bearing, u).load) - load

    return float(brentq(excess, 0.0, high, xtol=1e-22, rtol=8.9e-16))


def state_under(bearings: BallRows, load: Array) -> ThrustState:
    """State under thrusts [N] above zero, of a shape that the bearings' fields go with: Newton's method on F^(2/3), which
    is nearly linear in u. Raises ValueError for a thrust that needs displacements beyond Hertz contact."""
    first = BEGINS * bearings.ball_diameter
    u = contact_approach(load / thrust_state(bearings, first).load, first)
    for _ in range(STEPS):
        state = thrust_state(bearings, u)
        step = 1.5 * (np.cbrt(load / state.load) ** 2 - 1.0) * state.load / state.stiffness
        u = np.maximum(u + step, 0.2 * u)
        if float(np.abs(step / u).max()) < ENOUGH and bool(np.all(u < bearings.ball_diameter)):
            return state
    raise ValueError(f"thrust of {float(np.max(load)):.3g} N is beyond what Hertz contact describes for this bearing")


def conformity_of_pair(bearings: AngleRows, preload: Array, rigidity: Array) -> Array:
    """Conformities, the same of both grooves, at which two equal bearings pressed against one another by a preload [N] have
    a tangent rigidity [N/m], 2 dF/du of either; the bearings' own conformities are where the search begins.

    The rigidity falls as the conformity c grows, nearly as a power of c - 1/2: secants on the logarithms. Raises ValueError
    where none in `CONFORMITIES` gives it.
    """
    low, high = np.log(np.array(CONFORMITIES) - 0.5)

    def excess(x: Array) -> Array:
        state = state_under(replace(bearings, conformity=0.5 + np.exp(x)), preload)
        return np.asarray(np.log(2.0 * state.stiffness / rigidity))

    old = np.log(bearings.conformity - 0.5)
    value, slope = excess(old), np.full_like(old, -0.2)
    for _ in range(STEPS):
        new = np.clip(old - value / slope, low, high)
        if float(np.abs(new - old).max()) < ENOUGH:
            break
        fresh = excess(new)
        moved = new != old
        slope = np.where(moved, np.minimum((fresh - value) / np.where(moved, new - old, 1.0), -0.02), slope)
        old, value = new, fresh
    if float(np.abs(value).max()) > 1e-6:
        raise ValueError("no conformity of {:g} to {:g} gives a pair of these balls that rigidity".format(*CONFORMITIES))
    return np.asarray(0.5 + np.exp(old))
