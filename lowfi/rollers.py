"""Tapered rollers: line contact with the races, a bearing under pure thrust, and a crowned roller cut into slices.

The contact of a roller with a raceway is Hertz's line contact: b^2 = 4 q R / (pi E*), p_0 = 2 q / (pi b), q the load per
length, R the relative radius. The approach of a line contact is not a property of the contact alone: in plane strain it
grows with the logarithm of the depth to which it is measured. Here it is measured from the roller's centre (Johnson,
Contact Mechanics, 1985, 5.57) to a depth d in the ring (5.58),

    delta = q (1 - nu^2)/(pi E) [2 ln(4 R_1/b) - 1]  +  q (1 - nu^2)/(pi E) [2 ln(2 d/b) - nu/(1 - nu)],

summed over both races. With b ~ sqrt(q) that is delta = q (g - S ln q), g and S constant. This is not a power law, but its
slope is near the exponents 1.1 and 10/9 that are used for rollers.

The bearing has rigid rings, rollers that touch the rib, no friction, and no tilt of one ring against the other. All cones
of the bearing (roller, cup, cone) have their apex in one point of the axis. At the distance l from it along the generator
roller, cup and cone have the radii of curvature l tan(gamma), l tan(alpha), l tan(alpha - 2 gamma), so that no pitch
diameter has to be given. alpha is half the included angle of the cup, gamma that of the roller.

Equilibrium of one roller along and across its axis: both races press with the same load Q, and the rib with 2 Q sin(gamma).
The cone receives its thrust from race and rib together: Q sin(alpha - 2 gamma) + 2 Q sin(gamma) cos(alpha - gamma) =
Q sin(alpha). Smith's 3.23 neglects the rib, which makes the inner load larger by sin(alpha)/sin(alpha - 2 gamma).

A roller with a crown is cut into slices: slice k of width L/n at x_k is compressed by the approach delta less the drop of
the profile, and carries the line load of plane strain at that approach; the roller's load is the sum. Slices do not
interact (no edge stress). This is accurate within a few per cent if the profile ends without a step; a sharp edge needs a
3D model.

All slices have the approach law of the middle: along the roller the radii of roller and races grow in proportion to the
distance from the common apex, and b^2 with them, so that 2 ln(4 R_1/b) + 2 ln(2 d/b) does not change. A tapered roller
without crown is therefore loaded evenly along its length.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.numerics import brentq


def line_contact_half_width(line_load: Array | float, curvature: Array | float, modulus: float) -> Array:
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
        A relative curvature is not positive.

    References
    ----------
    Johnson (1985), 4.43. Corrects Smith (1994), 3.24 and 3.26: for steel b = 2.78e-4 sqrt(q/k) in inches and pounds, with
    curvatures 2/D (not 1/D) and the exponent 1/2.

    Examples
    --------
    A steel cylinder of 10 mm on a flat under 100 N/mm:

    >>> b = line_contact_half_width(1e5, 1 / 5e-3, contact_modulus(210e9, 0.3, 210e9, 0.3))
    >>> round(float(b) * 1e6, 2), round(float(line_contact_pressure(1e5, b)) / 1e6, 1)
    (74.28, 857.1)
    """
    k = np.asarray(curvature, dtype=float)
    if np.any(k <= 0.0):
        raise ValueError(f"the relative curvature of a line contact must be positive, got {float(k.min()):g} 1/m")
    return np.sqrt(4.0 * np.asarray(line_load, dtype=float) / (np.pi * modulus * k))


def line_contact_pressure(line_load: Array | float, width: Array | float) -> Array:
    """Return the largest pressure of Hertz's line contact, p_0 = 2 q/(pi b) [Pa].

    Parameters
    ----------
    line_load
        Load per length q [N/m]; shapes broadcast.
    width
        Half-width b [m] (`line_contact_half_width`).

    References
    ----------
    Johnson (1985), 4.45; Smith (1994), 3.28.
    """
    return 2.0 * np.asarray(line_load, dtype=float) / (np.pi * np.asarray(width, dtype=float))


@dataclass(frozen=True)
class LineContactLaw:
    """Law delta = q (g - S ln q) between the approach delta [m] of two raceways and the line load q [N/m] of the roller.

    The roller lies between the raceways. S: constant of the material [m^2/N]; g: constant of material and radii [m^2/N].
    The approach increases with q up to q = exp(g/S - 1). There the half-width b of the contact would exceed the size of the
    bodies; steel rollers stay far below.
    """

    #: Constant g of material and radii [m^2/N], valid with the line load q in N/m in the logarithm; an array for several
    #: positions along a roller.
    g: Array
    #: Constant S = 4 (1 - nu^2)/(pi E) [m^2/N], for both contacts together.
    s: float

    def approach(self, line_load: Array | float) -> Array:
        """Return the approach of the raceways [m] under a load per length ``line_load`` [N/m]; zero without load."""
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, q * (self.g - self.s * np.log(np.where(q > 0.0, q, 1.0))), 0.0)

    def line_load(self, approach: Array | float) -> Array:
        """Return the load per length [N/m] at an approach of the raceways [m], by Lambert's function W_-1.

        Zero for an approach that is negative (a gap) or zero.

        Raises
        ------
        ValueError
            The approach is larger than the largest one of the law, S exp(g/S - 1).
        """
        from scipy.special import lambertw  # loads slowly; pressures and `solve` do without

        delta = np.asarray(approach, dtype=float)
        inside = delta > 0.0
        argument = -np.where(inside, delta, self.s) / self.s * np.exp(-self.g / self.s)
        if np.any(inside & (argument < -np.exp(-1.0))):
            raise ValueError(
                "the approach of the raceways is too large for the law of a line contact: the half-width of the contact "
                "would exceed the dimensions of roller and rings"
            )
        return np.where(inside, delta / (-self.s * lambertw(argument, k=-1).real), 0.0)

    def stiffness_per_length(self, line_load: Array | float) -> Array:
        """Return the stiffness per length dq/d(delta) [N/m^2] under a load per length ``line_load`` q [N/m].

        delta is the approach of the raceways. Zero without load.
        """
        q = np.asarray(line_load, dtype=float)
        return np.where(q > 0.0, 1.0 / (self.g - self.s * (1.0 + np.log(np.where(q > 0.0, q, 1.0)))), 0.0)


def approach_law_of_races(
    roller_radius: Array | float,
    race_curvatures: tuple[Array | float, Array | float],
    depths: tuple[float, float],
    young: float,
    poisson: float,
) -> LineContactLaw:
    """Return the approach law of two raceways with a roller between them, all of one material.

    The approach is the sum over both races of q (1 - nu^2)/(pi E) [2 ln(4 R_1/b) - 1 + 2 ln(2 d/b) - nu/(1 - nu)].

    Parameters
    ----------
    roller_radius
        Radius R_1 of the roller [m].
    race_curvatures
        Curvatures of inner race (positive) and outer race (negative) [1/m].
    depths
        Depths d [m] below both raceways down to which deformation is counted, about the thickness of the rings. Doubling
        one of them adds 2 q (1 - nu^2) ln 2/(pi E) to the approach, some 7 %.
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
        b = line_contact_half_width(1.0, 1.0 / r + race, modulus)
        g = g + factor * (2.0 * np.log(4.0 * r / b) - 1.0 + 2.0 * np.log(2.0 * depth / b) - poisson / (1.0 - poisson))
    return LineContactLaw(np.asarray(g), 4.0 * factor)


@dataclass(frozen=True)
class TaperedBearing:
    """Single-row tapered roller bearing; roller, cup and cone have one common apex on the bearing's axis.

    Raises
    ------
    ValueError
        A value is out of range, or the cone's half angle, ``cup_angle`` - 2 ``roller_angle``, is not positive.
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
    #: Depth below both raceways down to which deformation is counted [m].
    depth: float

    def __post_init__(self) -> None:
        """Check that the values describe a tapered roller bearing; raise ValueError otherwise."""
        if self.rollers < 1 or min(self.diameter, self.length, self.depth, self.young) <= 0.0:
            raise ValueError(
                "tapered roller bearing: number, diameter and length of the rollers, depth below the raceways down to "
                "which deformation is counted, and Young's modulus must be positive"
            )
        if not 0.0 < 2.0 * self.roller_angle < self.cup_angle < 0.5 * np.pi or not 0.0 <= self.poisson < 0.5:
            raise ValueError(
                "half angles of roller (gamma) and cup (alpha) must satisfy 0 < 2 gamma < alpha < 90 deg, and Poisson's "
                "ratio must lie in [0, 0.5)"
            )

    @property
    def cone_angle(self) -> float:
        """Half the included angle of the inner race [rad]: that of the cup less the full included angle of a roller."""
        return self.cup_angle - 2.0 * self.roller_angle

    @property
    def apex_distance(self) -> float:
        """Distance l [m] of the roller's mean section from the common apex, along the generator."""
        return float(0.5 * self.diameter / np.sin(self.roller_angle))

    @property
    def pitch_diameter(self) -> float:
        """Diameter of the circle through the middles of the rollers' axes [m], D sin(alpha - gamma)/tan(gamma).

        D: mean roller diameter; alpha, gamma: half the included angles of cup and roller.
        """
        return float(self.diameter * np.sin(self.cup_angle - self.roller_angle) / np.tan(self.roller_angle))

    def curvature_radii(self, along: Array | float = 0.0) -> tuple[Array, Array, Array]:
        """Return the radii of curvature of roller, cone and cup normal to the contact line [m], all of them positive.

        Parameters
        ----------
        along
            Distance along the roller from its middle [m], positive towards the large end; any shape.
        """
        reach = self.apex_distance + np.asarray(along, dtype=float)
        roller, cone, cup = (reach * np.tan(a) for a in (self.roller_angle, self.cone_angle, self.cup_angle))
        return roller, cone, cup

    def approach_law(self, along: Array | float = 0.0) -> LineContactLaw:
        """Return the approach law of a roller between its races, at distances ``along`` from the roller's middle [m]."""
        roller, cone, cup = self.curvature_radii(along)
        return approach_law_of_races(roller, (1.0 / cone, -1.0 / cup), (self.depth, self.depth), self.young, self.poisson)


def tapered_bearing_of_row(row: RollerRow) -> TaperedBearing:
    """Convert a row of rollers of a scene to a `TaperedBearing`.

    Parameters
    ----------
    row
        Row of rollers of a scene.

    Raises
    ------
    ValueError
        The values describe no tapered roller bearing.
    """
    young, poisson = row.material.youngs_modulus, row.material.poissons_ratio
    return TaperedBearing(row.count, row.diameter, row.length, row.cup_angle, row.roller_angle, young, poisson, row.depth)


def slice_middles(length: float, slices: int) -> Array:
    """Return the positions of the middles of a roller's n equal slices ``(n,)`` [m], between -L/2 and L/2.

    Parameters
    ----------
    length
        Length L of the roller [m].
    slices
        Number n of slices.
    """
    return length * ((np.arange(slices) + 0.5) / slices - 0.5)


def circular_crown_profile(radius: float) -> Callable[[Array], Array]:
    """Return the function that gives the profile drop x^2/R [m] of a circular crown at the distance x from the middle.

    It is the sum of the drops x^2/(2 R) at both contacts, valid for x small against the radius R of the crown.

    Parameters
    ----------
    radius
        Radius R of the crown [m].
    """
    return lambda x: x**2 / radius


def half_widths_and_pressures_of_slices(bearing: TaperedBearing, line_loads: Array) -> tuple[Array, Array]:
    """Return half-width and largest pressure of the line contacts of every roller slice with cone and cup.

    They follow from Hertz's line contact, b^2 = 4 q R/(pi E*), p = 2 q/(pi b) = sqrt(q E*/(pi R)), with each slice's
    curvature 1/R = 1/R_roller +- 1/R_race. Valid for b small against the roller's radius; the peak at the sharp end of a
    straight roller is not included.

    Parameters
    ----------
    bearing
        The bearing.
    line_loads
        Loads per length q ``(..., n)`` [N/m] of equal slices, from the roller's small end to its large one.

    Returns
    -------
    tuple[Array, Array]
        Half-widths b [m] and largest pressures p [Pa], ``(..., n, 2)`` each, for cone, then cup; zero without load.

    References
    ----------
    Johnson (1985), 4.43 and 4.45.
    """
    roller, cone, cup = bearing.curvature_radii(slice_middles(bearing.length, line_loads.shape[-1]))
    curvature = np.stack([1.0 / roller + 1.0 / cone, 1.0 / roller - 1.0 / cup], axis=-1)
    q = np.asarray(line_loads, dtype=float)[..., None]
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    b = line_contact_half_width(q, curvature, modulus)
    return b, line_contact_pressure(q, np.where(q == 0.0, 1.0, b))


@dataclass(frozen=True)
class TaperedRow:
    """Load-deflection law of a tapered roller bearing under pure thrust, whose rollers are cut into n equal slices.

    An axial deflection u of one ring compresses every roller in its middle by u sin(alpha), with half the included angle
    alpha of the cup. One slice is enough for straight rollers.
    """

    #: Dimensions and material of the bearing.
    bearing: TaperedBearing
    #: Number n of equal slices of a roller.
    slices: int = 1
    #: Drop of the profile [m], the sum for both contacts, as a function of the distance from the roller's middle [m]; by
    #: default rollers are straight.
    profile: Callable[[Array], Array] = np.zeros_like

    @cached_property
    def law(self) -> LineContactLaw:
        """Law between approach and line load, the same for every slice."""
        return self.bearing.approach_law()

    @cached_property
    def drops(self) -> Array:
        """Drop of the profile at each slice ``(n,)`` [m], the sum for both contacts."""
        return np.asarray(self.profile(slice_middles(self.bearing.length, self.slices)))

    @property
    def thrust_per_line_load(self) -> float:
        """Thrust of the row per mean load per length of a roller [m]."""
        return float(self.bearing.rollers * self.bearing.length * np.sin(self.bearing.cup_angle))

    def line_loads(self, deflection: float) -> Array:
        """Return the load per length of each slice of a roller ``(n,)`` [N/m] at an axial deflection [m]."""
        return self.law.line_load(deflection * np.sin(self.bearing.cup_angle) - self.drops)

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]; zero where the rollers are loose."""
        return self.thrust_per_line_load * float(self.line_loads(deflection).mean())

    def stiffness(self, deflection: float) -> float:
        """Return the axial stiffness [N/m] at an axial deflection [m]; zero where the rollers are loose."""
        slope = self.law.stiffness_per_length(self.line_loads(deflection)).mean()
        return float(self.thrust_per_line_load * np.sin(self.bearing.cup_angle) * slope)

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N].

        Raises
        ------
        ValueError
            The load is negative: a row of tapered rollers carries thrust in one direction only.
        """
        if load < 0.0:
            raise ValueError(
                f"a row of tapered rollers carries thrust in one direction only: it must not be negative, got {load:g} N"
            )
        sin, straight = np.sin(self.bearing.cup_angle), float(self.law.approach(load / self.thrust_per_line_load))
        low, high = float(self.drops.min() / sin), float((straight + self.drops.max()) / sin) * (1.0 + 1e-9)
        return float(brentq(lambda u: self.thrust(u) - load, low, high, xtol=1e-22, rtol=8.9e-16))
