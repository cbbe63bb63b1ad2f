"""Tapered roller bearing: geometry on one apex, ribs, thrust and combined load, contact areas.

Rigid rings, roller seated on the rib, no friction, no tilt of one ring against the other. Every cone of the bearing has its
apex on the axis; at the mean generator's length l from it the roller, cup and cone have the radii of curvature
l tan(gamma), l tan(alpha), l tan(alpha - 2 gamma), so that no pitch diameter has to be given.

Balance of one roller along and across its own axis: the loads of both races are equal, Q, and the rib takes 2 Q sin(gamma).
The cone receives its thrust from race and rib together: Q sin(alpha - 2 gamma) + 2 Q sin(gamma) cos(alpha - gamma) =
Q sin(alpha). Smith's 3.23 leaves out the rib and makes the inner load larger by sin(alpha)/sin(alpha - 2 gamma).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.lowfi.rollers.line_contact import LineLaw, between_races, half_width, pressure
from rollbench.meshes.arrays import Array


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
class RollerRow:
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
