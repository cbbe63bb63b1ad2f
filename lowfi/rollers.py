"""Tapered rollers: their line contact, a bearing's row, and a roller cut into slices.

The contact of a roller with a raceway is Hertz's line contact: b^2 = 4 q R / (pi E*), p_0 = 2 q / (pi b), q the load per
length, R the relative radius. The approach of a line contact is not a property of the contact: in plane strain it grows
with the logarithm of the depth to which it is measured. Here from the roller's centre (Johnson, Contact Mechanics, 1985,
5.57) to a depth in the ring (5.58),

    delta = q (1 - nu^2)/(pi E) [2 ln(4 R_1/b) - 1]  +  q (1 - nu^2)/(pi E) [2 ln(2 d/b) - nu/(1 - nu)],

at both races. With b ~ sqrt(q) that is delta = q (g - S ln q): not a power law, though its slope is near the exponents 1.1
and 10/9 that are used for rollers.

A bearing's row has rigid rings, its rollers seated on the rib, no friction, no tilt of one ring against the other. Every
cone of the bearing has its apex on the axis; at the mean generator's length l from it the roller, cup and cone have the
radii of curvature l tan(gamma), l tan(alpha), l tan(alpha - 2 gamma), so that no pitch diameter has to be given.

Balance of one roller along and across its own axis: the loads of both races are equal, Q, and the rib takes 2 Q sin(gamma).
The cone receives its thrust from race and rib together: Q sin(alpha - 2 gamma) + 2 Q sin(gamma) cos(alpha - gamma) =
Q sin(alpha). Smith's 3.23 leaves out the rib and makes the inner load larger by sin(alpha)/sin(alpha - 2 gamma).

Slices, for a roller with a crown: slice k of width L/n at x_k sees the approach delta less the profile's drop, and carries
the plane-strain line load of that approach by itself; the load is the sum. Slices do not feel one another (no edge stress):
with a profile that ends in no step that is within a few per cent; a sharp edge needs 3D.

All slices have the law of the middle: on one apex the radii of roller and races grow together along the roller, and b^2
with them, so that 2 ln(4 R_1/b) + 2 ln(2 d/b) is unchanged. A tapered roller without crown is loaded evenly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.numerics import brentq


def half_width(line_load: Array | float, curvature: Array | float, modulus: float) -> Array:
    """Half-width b [m] at a load per length [N/m], relative curvature 1/R_1 +- 1/R_2 [1/m], contact modulus E* [Pa].

    Mends Smith (1994) 3.24, 3.26: for steel b = 2.78e-4 in sqrt(lb) sqrt(q / curvature), with the curvatures of radii
    (2/D, not 1/D) and the exponent 1/2. Raises ValueError unless the curvature is positive.
    """
    k = np.asarray(curvature, dtype=float)
    if np.any(k <= 0.0):
        raise ValueError("relative curvature of a line contact must be positive")
    return np.sqrt(4.0 * np.asarray(line_load, dtype=float) / (np.pi * modulus * k))


def pressure(line_load: Array | float, width: Array | float) -> Array:
    """Greatest pressure 2 q / (pi b) [Pa] at a load per length [N/m] and half-width b [m] (Smith 3.28)."""
    return 2.0 * np.asarray(line_load, dtype=float) / (np.pi * np.asarray(width, dtype=float))


@dataclass(frozen=True)
class LineLaw:
    """delta = q (g - S ln q), q in N/m: g [m^2/N]; S [m^2/N].

    Increases up to q = exp(g/S - 1), where b would exceed the bodies; a roller of steel is far below.
    """

    g: Array
    s: float

    def approach(self, line_load: Array | float) -> Array:
        """Approach [m] at a load per length [N/m]; zero without load."""
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, q * (self.g - self.s * np.log(np.where(q > 0.0, q, 1.0))), 0.0)

    def line_load(self, approach: Array | float) -> Array:
        """Load per length [N/m] at an approach [m], zero where it is not positive; closed form by Lambert's W_-1.

        Raises ValueError beyond the greatest approach S exp(g/S - 1) of the law.
        """
        from scipy.special import lambertw  # loads slowly; pressures and `solve` do without

        delta = np.asarray(approach, dtype=float)
        inside = delta > 0.0
        argument = -np.where(inside, delta, self.s) / self.s * np.exp(-self.g / self.s)
        if np.any(inside & (argument < -np.exp(-1.0))):
            raise ValueError("approach is beyond what line contact of two thick bodies describes")
        return np.where(inside, delta / (-self.s * lambertw(argument, k=-1).real), 0.0)

    def slope(self, line_load: Array | float) -> Array:
        """Stiffness per length dq/d(delta) [N/m^2] at a load per length; zero without load."""
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, 1.0 / (self.g - self.s * (1.0 + np.log(np.where(q > 0.0, q, 1.0)))), 0.0)

    def energy(self, line_load: Array | float) -> Array:
        """Energy per length [J/m], the integral of q over the approach; zero without load."""
        q = np.asarray(line_load, dtype=float)
        safe = np.where(q > 0.0, q, 1.0)
        return np.where(q > 0.0, 0.5 * q**2 * (self.g - self.s * (0.5 + np.log(safe))), 0.0)


def between_races(
    roller_radius: Array | float,
    race_curvatures: tuple[Array | float, Array | float],
    depths: tuple[float, float],
    young: float,
    poisson: float,
) -> LineLaw:
    """Law of the approach of two raceways with a roller between them, all of one material.

    roller_radius [m]; race_curvatures: of inner (positive) and outer race (negative) [1/m]; depths [m]: to where the
    rings' deformation is counted, about their thickness. Doubling a depth adds 2 q (1 - nu^2) ln 2 / (pi E), some 7 %.
    """
    factor = (1.0 - poisson**2) / (np.pi * young)
    modulus = contact_modulus(young, poisson, young, poisson)
    r = np.asarray(roller_radius, dtype=float)
    g = np.zeros_like(r)
    for race, depth in zip(race_curvatures, depths, strict=True):
        b = half_width(1.0, 1.0 / r + race, modulus)
        g = g + factor * (2.0 * np.log(4.0 * r / b) - 1.0 + 2.0 * np.log(2.0 * depth / b) - poisson / (1.0 - poisson))
    return LineLaw(np.asarray(g), 4.0 * factor)


@dataclass(frozen=True)
class TaperedBearing:
    """One row; lengths [m], angles [rad], Young's modulus [Pa].

    rollers: number N; diameter: mean roller diameter D; length: effective contact length L; cup_angle: half included cup
    angle alpha; roller_angle: half included roller angle gamma; depth: of both rings, to which deformation is counted.
    Raises ValueError for an angle of the cone alpha - 2 gamma that is not positive, or numbers out of range.
    """

    rollers: int
    diameter: float
    length: float
    cup_angle: float
    roller_angle: float
    young: float
    poisson: float
    depth: float

    def __post_init__(self) -> None:
        """Refuse what is no tapered roller bearing."""
        if self.rollers < 1 or min(self.diameter, self.length, self.depth, self.young) <= 0.0:
            raise ValueError("rollers, diameter, length, depth and Young's modulus must be positive")
        if not 0.0 < 2.0 * self.roller_angle < self.cup_angle < 0.5 * np.pi or not 0.0 <= self.poisson < 0.5:
            raise ValueError("angles must satisfy 0 < 2 gamma < alpha < 90 degrees, Poisson's ratio lie in [0, 0.5)")

    @property
    def cone_angle(self) -> float:
        """Half included angle of the inner race, alpha - 2 gamma [rad]."""
        return self.cup_angle - 2.0 * self.roller_angle

    @property
    def apex_distance(self) -> float:
        """Length l [m] of the mean generator from the common apex."""
        return float(0.5 * self.diameter / np.sin(self.roller_angle))

    @property
    def pitch_diameter(self) -> float:
        """Diameter [m] of the circle of the rollers' mean centres, d_m = D sin(alpha - gamma)/tan(gamma)."""
        return float(self.diameter * np.sin(self.cup_angle - self.roller_angle) / np.tan(self.roller_angle))

    def radii(self, along: Array | float = 0.0) -> tuple[Array, Array, Array]:
        """Radii of curvature [m] of roller, cone and cup at a distance [m] outwards from the mean generator's middle."""
        reach = self.apex_distance + np.asarray(along, dtype=float)
        roller, cone, cup = (reach * np.tan(a) for a in (self.roller_angle, self.cone_angle, self.cup_angle))
        return roller, cone, cup

    def law(self, along: Array | float = 0.0) -> LineLaw:
        """Line contact of a roller between its races, at places [m] along the roller."""
        roller, cone, cup = self.radii(along)
        return between_races(roller, (1.0 / cone, -1.0 / cup), (self.depth, self.depth), self.young, self.poisson)


@dataclass(frozen=True)
class RollerContacts:
    """Contacts (inner, outer) of one roller: half-widths b [m], pressures [Pa], areas 2 b L [m^2]; rib load [N]."""

    half_widths: Array
    pressures: Array
    areas: Array
    rib_load: float


def roller_contacts(bearing: TaperedBearing, load: float) -> RollerContacts:
    """Line contacts of a roller at a race load Q [N], without tilt or crown.

    Mends Smith (1994) 3.23-3.27: his area pi a b is that of an ellipse, a line contact is 2 b L.
    """
    roller, cone, cup = bearing.radii()
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    q = load / bearing.length
    widths = half_width(q, np.array([1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup]), modulus)
    rib = float(2.0 * load * np.sin(bearing.roller_angle))
    return RollerContacts(widths, pressure(q, widths), 2.0 * widths * bearing.length, rib)


@dataclass(frozen=True)
class TaperedRow:
    """A tapered bearing as a row of a set under pure thrust: every roller is compressed by u sin(alpha)."""

    bearing: TaperedBearing

    def load(self, deflection: float) -> float:
        """Thrust [N] at an axial deflection [m]; zero where the row is loose."""
        b = self.bearing
        q = float(b.law().line_load(deflection * np.sin(b.cup_angle)))
        return float(b.rollers * b.length * q * np.sin(b.cup_angle))

    def stiffness(self, deflection: float) -> float:
        """Slope of the thrust [N/m]; zero where the row is loose."""
        b, law = self.bearing, self.bearing.law()
        slope = float(law.slope(law.line_load(deflection * np.sin(b.cup_angle))))
        return float(b.rollers * b.length * slope * np.sin(b.cup_angle) ** 2)

    def deflection(self, load: float) -> float:
        """Axial deflection [m] under a thrust [N], closed form. Raises ValueError for a negative load."""
        if load < 0.0:
            raise ValueError("a row of rollers carries thrust in one direction only: the load must not be negative")
        b = self.bearing
        sin = np.sin(b.cup_angle)
        return float(b.law().approach(load / (b.rollers * b.length * sin)) / sin)


def tapered(row: RollerRow) -> TaperedBearing:
    """The row as a bearing of `lowfi.rollers`. Raises ValueError where it is none."""
    young, poisson = row.material.youngs_modulus, row.material.poissons_ratio
    return TaperedBearing(row.count, row.diameter, row.length, row.cup_angle, row.roller_angle, young, poisson, row.depth)


@dataclass(frozen=True)
class SlicedRoller:
    """law: of every slice; places: x_k (n,) [m], outwards; length [m]; drop: lost approach (n,) [m], both contacts
    together."""

    law: LineLaw
    places: Array
    length: float
    drop: Array


@dataclass(frozen=True)
class SliceState:
    """Force [N], its slope against the approach [N/m], line loads (n,) [N/m]."""

    force: float
    stiffness: float
    line_loads: Array


def middles(length: float, slices: int) -> Array:
    """Middles (n,) [m] of equal slices of a roller, from -L/2 to L/2."""
    return length * ((np.arange(slices) + 0.5) / slices - 0.5)


def circular_crown(radius: float) -> Callable[[Array], Array]:
    """Drop x^2/(2 R) [m] of a crowned roller at both contacts together: x^2/R."""
    return lambda x: x**2 / radius


def sliced(bearing: TaperedBearing, slices: int, profile: Callable[[Array], Array] | None = None) -> SlicedRoller:
    """Roller of a bearing in n equal slices; profile: drop of both contacts together [m] at places [m], or none."""
    x = middles(bearing.length, slices)
    drop = np.zeros_like(x) if profile is None else np.asarray(profile(x))
    return SlicedRoller(bearing.law(), x, bearing.length, drop)


def slice_contacts(bearing: TaperedBearing, line_loads: Array) -> tuple[Array, Array]:
    """Half-widths b and largest pressures p ``(..., n, 2)`` [m, Pa] at cone and cup, of line loads q ``(..., n)`` [N/m] in
    equal slices from the small end of the roller to the large one.

    Hertz's line contact (Johnson 1985, 4.43 and 4.45) at each slice's own curvature 1/R = 1/R_roller +- 1/R_race:
    b^2 = 4 q R/(pi E*), p = 2 q/(pi b) = sqrt(q E*/(pi R)). Valid for b small against the roller's radius; without what the
    sharp end of a straight roller adds. Both are zero without load.
    """
    roller, cone, cup = bearing.radii(middles(bearing.length, line_loads.shape[-1]))
    curvature = np.stack([1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup], axis=-1)
    q = np.asarray(line_loads, dtype=float)[..., None]
    b = half_width(q, curvature, contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson))
    return b, pressure(q, np.where(q == 0.0, 1.0, b))


def slice_state(roller: SlicedRoller, approach: float) -> SliceState:
    """Loads at an approach of the raceways [m]."""
    q = roller.law.line_load(approach - roller.drop)
    width = roller.length / roller.places.size
    return SliceState(float(width * q.sum()), float(width * roller.law.slope(q).sum()), q)


def approach_of(roller: SlicedRoller, force: float) -> float:
    """Approach [m] of the raceways under a force [N], to round-off; the force grows with it.

    Raises ValueError unless the force is positive.
    """
    if force <= 0.0:
        raise ValueError("a roller carries compression only: the force must be positive")
    low = float(roller.drop.min())
    high = float(roller.law.approach(force / roller.length).max() + roller.drop.max()) * (1.0 + 1e-9)
    return float(brentq(lambda d: slice_state(roller, d).force - force, low, high, xtol=1e-22, rtol=8.9e-16))


@dataclass(frozen=True)
class SlicedRow:
    """A tapered bearing with sliced rollers as a row of a set under pure thrust."""

    bearing: TaperedBearing
    slices: int = 31
    profile: Callable[[Array], Array] | None = None
    roller: SlicedRoller = field(init=False)

    def __post_init__(self) -> None:
        """Cut the roller once."""
        object.__setattr__(self, "roller", sliced(self.bearing, self.slices, self.profile))

    def load(self, deflection: float) -> float:
        """Thrust [N] at an axial deflection [m]."""
        sin = np.sin(self.bearing.cup_angle)
        return float(self.bearing.rollers * sin * slice_state(self.roller, deflection * sin).force)

    def stiffness(self, deflection: float) -> float:
        """Slope of the thrust [N/m]."""
        sin = np.sin(self.bearing.cup_angle)
        return float(self.bearing.rollers * sin**2 * slice_state(self.roller, deflection * sin).stiffness)

    def deflection(self, load: float) -> float:
        """Axial deflection [m] under a thrust [N]. Raises ValueError unless it is positive."""
        sin = np.sin(self.bearing.cup_angle)
        return float(approach_of(self.roller, load / (self.bearing.rollers * sin)) / sin)
