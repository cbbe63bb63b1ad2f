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
the plane-strain line load of that approach; the load is the sum. Slices do not interact (no edge stress):
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
    """Return the half-width b of a line contact, b^2 = 4 q/(pi E* k).

    Parameters
    ----------
    line_load
        Load per length q [N/m]; shapes broadcast.
    curvature
        Relative curvature k = 1/R_1 + 1/R_2 [1/m], a concave radius negative.
    modulus
        Contact modulus E* [Pa] (`rollbench.lowfi.hertz.contact_modulus`).

    Returns
    -------
    Array
        b [m]; valid for b small against both radii.

    Raises
    ------
    ValueError
        A relative curvature that is not positive.

    References
    ----------
    Johnson (1985), 4.43. Corrects Smith (1994), 3.24 and 3.26: for steel b = 2.78e-4 sqrt(q/k) in inches and pounds, with
    curvatures 2/D (not 1/D) and the exponent 1/2.

    Examples
    --------
    A steel cylinder of 10 mm on a flat under 100 N/mm:

    >>> b = half_width(1e5, 1 / 5e-3, contact_modulus(210e9, 0.3, 210e9, 0.3))
    >>> round(float(b) * 1e6, 2), round(float(pressure(1e5, b)) / 1e6, 1)
    (74.28, 857.1)
    """
    k = np.asarray(curvature, dtype=float)
    if np.any(k <= 0.0):
        raise ValueError("relative curvature of a line contact must be positive")
    return np.sqrt(4.0 * np.asarray(line_load, dtype=float) / (np.pi * modulus * k))


def pressure(line_load: Array | float, width: Array | float) -> Array:
    """Return the largest pressure of a line contact, 2 q/(pi b) [Pa].

    Parameters
    ----------
    line_load
        Load per length q [N/m]; shapes broadcast.
    width
        Half-width b [m] (`half_width`).

    References
    ----------
    Johnson (1985), 4.45; Smith (1994), 3.28.
    """
    return 2.0 * np.asarray(line_load, dtype=float) / (np.pi * np.asarray(width, dtype=float))


@dataclass(frozen=True)
class LineLaw:
    """Approach of two raceways with a roller between them, delta = q (g - S ln q), q the load per length in N/m.

    The approach increases with q up to q = exp(g/S - 1), where b would exceed the bodies; steel rollers stay far below.
    """

    #: [m^2/N], with q in N/m under the logarithm; an array for several places along a roller.
    g: Array
    #: S = 4 (1 - nu^2)/(pi E) [m^2/N] of two equal contacts.
    s: float

    def approach(self, line_load: Array | float) -> Array:
        """Return the approach [m] at a load per length [N/m]; zero without load."""
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, q * (self.g - self.s * np.log(np.where(q > 0.0, q, 1.0))), 0.0)

    def line_load(self, approach: Array | float) -> Array:
        """Return the load per length [N/m] at an approach [m], by Lambert's W_-1; zero for a gap.

        Raises
        ------
        ValueError
            An approach beyond the largest one of the law, S exp(g/S - 1).
        """
        from scipy.special import lambertw  # loads slowly; pressures and `solve` do without

        delta = np.asarray(approach, dtype=float)
        inside = delta > 0.0
        argument = -np.where(inside, delta, self.s) / self.s * np.exp(-self.g / self.s)
        if np.any(inside & (argument < -np.exp(-1.0))):
            raise ValueError("approach is beyond what line contact of two thick bodies describes")
        return np.where(inside, delta / (-self.s * lambertw(argument, k=-1).real), 0.0)

    def slope(self, line_load: Array | float) -> Array:
        """Return the stiffness per length dq/d(delta) [N/m^2] at a load per length [N/m]; zero without load."""
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, 1.0 / (self.g - self.s * (1.0 + np.log(np.where(q > 0.0, q, 1.0)))), 0.0)

    def energy(self, line_load: Array | float) -> Array:
        """Return the strain energy per length [J/m] at a load per length [N/m], the integral of q over the approach."""
        q = np.asarray(line_load, dtype=float)
        safe = np.where(q > 0.0, q, 1.0)
        return np.where(q > 0.0, 0.5 * q**2 * (self.g - self.s * (0.5 + np.log(safe))), 0.0)


def approach_law_of_races(
    roller_radius: Array | float,
    race_curvatures: tuple[Array | float, Array | float],
    depths: tuple[float, float],
    young: float,
    poisson: float,
) -> LineLaw:
    """Return the law of approach of two raceways with a roller between them, all of one material.

    The sum over both races of q (1 - nu^2)/(pi E) [2 ln(4 R_1/b) - 1 + 2 ln(2 d/b) - nu/(1 - nu)].

    Parameters
    ----------
    roller_radius
        R_1 [m].
    race_curvatures
        Curvatures of inner race (positive) and outer race (negative) [1/m].
    depths
        Depths d [m] in both rings to which deformation is counted, about their thickness. Doubling one adds
        2 q (1 - nu^2) ln 2/(pi E), some 7 %.
    young, poisson
        Young's modulus [Pa] and Poisson's ratio.

    References
    ----------
    Johnson (1985), 5.57 and 5.58.

    Examples
    --------
    A roller of 10 mm between races of radii 30 and 40 mm, 100 N/mm: the approach [um].

    >>> law = approach_law_of_races(5e-3, (1 / 30e-3, -1 / 40e-3), (8e-3, 8e-3), 210e9, 0.3)
    >>> round(float(law.approach(1e5)) * 1e6, 3), round(float(law.line_load(law.approach(1e5))), 6)
    (5.663, 100000.0)
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
    """Single-row tapered roller bearing; every cone's apex lies on the bearing's axis.

    Raises
    ------
    ValueError
        A number out of range, or angles for which the cone's angle alpha - 2 gamma is not positive.
    """

    #: Number of rollers N.
    rollers: int
    #: Mean roller diameter D [m].
    diameter: float
    #: Effective contact length L [m].
    length: float
    #: Half the included angle of the cup, alpha [rad].
    cup_angle: float
    #: Half the included angle of a roller, gamma [rad].
    roller_angle: float
    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float
    #: Depth in both rings to which deformation is counted [m].
    depth: float

    def __post_init__(self) -> None:
        """Refuse numbers that describe no tapered roller bearing."""
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
        """Distance l [m] of the roller's mean section from the common apex, along the generator."""
        return float(0.5 * self.diameter / np.sin(self.roller_angle))

    @property
    def pitch_diameter(self) -> float:
        """Diameter of the circle through the rollers' mean centres, D sin(alpha - gamma)/tan(gamma) [m]."""
        return float(self.diameter * np.sin(self.cup_angle - self.roller_angle) / np.tan(self.roller_angle))

    def radii(self, along: Array | float = 0.0) -> tuple[Array, Array, Array]:
        """Return the radii of curvature of roller, cone and cup [m].

        Parameters
        ----------
        along
            Distance along the roller from its middle [m], positive towards the large end.
        """
        reach = self.apex_distance + np.asarray(along, dtype=float)
        roller, cone, cup = (reach * np.tan(a) for a in (self.roller_angle, self.cone_angle, self.cup_angle))
        return roller, cone, cup

    def law(self, along: Array | float = 0.0) -> LineLaw:
        """Return the law of approach of a roller between its races, at distances [m] along the roller from its middle."""
        roller, cone, cup = self.radii(along)
        return approach_law_of_races(roller, (1.0 / cone, -1.0 / cup), (self.depth, self.depth), self.young, self.poisson)


@dataclass(frozen=True)
class RollerContacts:
    """Contacts of one roller without tilt and crown; arrays in the order inner race, outer race."""

    #: Half-widths b [m].
    half_widths: Array
    #: Largest pressures [Pa].
    pressures: Array
    #: Contact areas 2 b L [m^2].
    areas: Array
    #: Force of the rib on the roller's large end [N].
    rib_load: float


def roller_contacts(bearing: TaperedBearing, load: float) -> RollerContacts:
    """Return the line contacts of a roller at both races, without tilt and crown.

    Parameters
    ----------
    bearing
        The bearing.
    load
        Force Q of each race on the roller [N].

    References
    ----------
    Corrects Smith (1994), 3.23 to 3.27: his area pi a b is that of an ellipse, a line contact has 2 b L; the rib takes
    2 Q sin(gamma), which he leaves out.
    """
    roller, cone, cup = bearing.radii()
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    q = load / bearing.length
    widths = half_width(q, np.array([1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup]), modulus)
    rib = float(2.0 * load * np.sin(bearing.roller_angle))
    return RollerContacts(widths, pressure(q, widths), 2.0 * widths * bearing.length, rib)


@dataclass(frozen=True)
class TaperedRow:
    """Tapered roller bearing under pure thrust: every roller is compressed by u sin(alpha) at an axial deflection u."""

    #: The bearing.
    bearing: TaperedBearing

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]; zero where the rollers are loose."""
        b = self.bearing
        q = float(b.law().line_load(deflection * np.sin(b.cup_angle)))
        return float(b.rollers * b.length * q * np.sin(b.cup_angle))

    def stiffness(self, deflection: float) -> float:
        """Return the axial stiffness [N/m] at an axial deflection [m]; zero where the rollers are loose."""
        b, law = self.bearing, self.bearing.law()
        slope = float(law.slope(law.line_load(deflection * np.sin(b.cup_angle))))
        return float(b.rollers * b.length * slope * np.sin(b.cup_angle) ** 2)

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N], in closed form.

        Raises
        ------
        ValueError
            A negative load: a row of tapered rollers carries thrust in one direction only.
        """
        if load < 0.0:
            raise ValueError("a row of rollers carries thrust in one direction only: the load must not be negative")
        b = self.bearing
        sin = np.sin(b.cup_angle)
        return float(b.law().approach(load / (b.rollers * b.length * sin)) / sin)


def tapered_bearing(row: RollerRow) -> TaperedBearing:
    """Return a scene's row of rollers as a `TaperedBearing`; raises ValueError where its numbers describe none.

    Parameters
    ----------
    row
        Row of rollers of a scene.
    """
    young, poisson = row.material.youngs_modulus, row.material.poissons_ratio
    return TaperedBearing(row.count, row.diameter, row.length, row.cup_angle, row.roller_angle, young, poisson, row.depth)


@dataclass(frozen=True)
class SlicedRoller:
    """Roller cut into equal slices, for a crowned profile."""

    #: Law of approach of every slice.
    law: LineLaw
    #: Middles x_k of the slices ``(n,)`` [m], from the roller's middle.
    places: Array
    #: Effective length of the roller [m].
    length: float
    #: Approach lost to the profile at both contacts together ``(n,)`` [m].
    drop: Array


@dataclass(frozen=True)
class SliceState:
    """Loads of a sliced roller at one approach."""

    #: Force of the roller [N].
    force: float
    #: Derivative of the force with respect to the approach [N/m].
    stiffness: float
    #: Load per length of each slice ``(n,)`` [N/m].
    line_loads: Array


def slice_middles(length: float, slices: int) -> Array:
    """Return the middles of equal slices of a roller ``(n,)`` [m], between -L/2 and L/2.

    Parameters
    ----------
    length
        L [m].
    slices
        Number n of slices.
    """
    return length * ((np.arange(slices) + 0.5) / slices - 0.5)


def circular_crown(radius: float) -> Callable[[Array], Array]:
    """Return the profile of a circular crown: the drop at both contacts together, x^2/R [m], as a function of x [m].

    At each contact the drop is x^2/(2 R), for x small against the crown's radius R [m].

    Parameters
    ----------
    radius
        Radius R of the crown [m].
    """
    return lambda x: x**2 / radius


def slice_roller(bearing: TaperedBearing, slices: int, profile: Callable[[Array], Array] | None = None) -> SlicedRoller:
    """Cut a bearing's roller into equal slices.

    Parameters
    ----------
    bearing
        The bearing.
    slices
        Number of slices.
    profile
        Drop of the profile at both contacts together [m] as a function of the distance from the roller's middle [m]; None
        for
        a straight roller.
    """
    x = slice_middles(bearing.length, slices)
    drop = np.zeros_like(x) if profile is None else np.asarray(profile(x))
    return SlicedRoller(bearing.law(), x, bearing.length, drop)


def slice_contacts(bearing: TaperedBearing, line_loads: Array) -> tuple[Array, Array]:
    """Return half-widths and largest pressures of every slice at cone and cup, by Hertz's line contact.

    b^2 = 4 q R/(pi E*), p = 2 q/(pi b) = sqrt(q E*/(pi R)), with each slice's curvature 1/R = 1/R_roller +- 1/R_race. Valid
    for b small against the roller's radius; the peak at the sharp end of a straight roller is not included.

    Parameters
    ----------
    bearing
        The bearing.
    line_loads
        Loads per length q ``(..., n)`` [N/m] of equal slices, from the roller's small end to its large one.

    Returns
    -------
    tuple[Array, Array]
        Half-widths b [m] and pressures p [Pa], ``(..., n, 2)`` each, zero without load.

    References
    ----------
    Johnson (1985), 4.43 and 4.45.
    """
    roller, cone, cup = bearing.radii(slice_middles(bearing.length, line_loads.shape[-1]))
    curvature = np.stack([1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup], axis=-1)
    q = np.asarray(line_loads, dtype=float)[..., None]
    b = half_width(q, curvature, contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson))
    return b, pressure(q, np.where(q == 0.0, 1.0, b))


def slice_state(roller: SlicedRoller, approach: float) -> SliceState:
    """Return force, stiffness and line loads of a sliced roller at an approach of the raceways [m]."""
    q = roller.law.line_load(approach - roller.drop)
    width = roller.length / roller.places.size
    return SliceState(float(width * q.sum()), float(width * roller.law.slope(q).sum()), q)


def approach_under_force(roller: SlicedRoller, force: float) -> float:
    """Return the approach of the raceways [m] under a force on a sliced roller [N], to round-off.

    Raises
    ------
    ValueError
        A force that is not positive.
    """
    if force <= 0.0:
        raise ValueError("a roller carries compression only: the force must be positive")
    low = float(roller.drop.min())
    high = float(roller.law.approach(force / roller.length).max() + roller.drop.max()) * (1.0 + 1e-9)
    return float(brentq(lambda d: slice_state(roller, d).force - force, low, high, xtol=1e-22, rtol=8.9e-16))


@dataclass(frozen=True)
class SlicedRow:
    """Tapered roller bearing with sliced rollers under pure thrust."""

    #: The bearing.
    bearing: TaperedBearing
    #: Number of equal slices of a roller.
    slices: int = 31
    #: Drop at both contacts together [m] over the distance from the roller's middle [m]; None for a straight roller.
    profile: Callable[[Array], Array] | None = None
    #: The sliced roller, made from the fields above.
    roller: SlicedRoller = field(init=False)

    def __post_init__(self) -> None:
        """Slice the roller once."""
        object.__setattr__(self, "roller", slice_roller(self.bearing, self.slices, self.profile))

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]."""
        sin = np.sin(self.bearing.cup_angle)
        return float(self.bearing.rollers * sin * slice_state(self.roller, deflection * sin).force)

    def stiffness(self, deflection: float) -> float:
        """Return the axial stiffness [N/m] at an axial deflection [m]."""
        sin = np.sin(self.bearing.cup_angle)
        return float(self.bearing.rollers * sin**2 * slice_state(self.roller, deflection * sin).stiffness)

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N].

        Raises
        ------
        ValueError
            A thrust that is not positive.
        """
        sin = np.sin(self.bearing.cup_angle)
        return float(approach_under_force(self.roller, load / (self.bearing.rollers * sin)) / sin)
