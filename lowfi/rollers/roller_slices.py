"""Roller between two raceways cut into slices: crown.

Slice k of width L/n at x_k sees the approach delta less the profile's drop, and carries the plane-strain line load of that
approach by itself; the load is the sum. Slices do not feel one another (no edge stress): with a profile that ends in no
step that is within a few per cent; a sharp edge needs 3D.

All slices have the law of the middle: on one apex the radii of roller and races grow together along the roller, and b^2
with them, so that 2 ln(4 R_1/b) + 2 ln(2 d/b) is unchanged. A tapered roller without crown is loaded evenly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.lowfi.rollers.line_contact import LineLaw, half_width, pressure
from rollbench.lowfi.rollers.tapered_roller import TaperedBearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.roots import brentq


def tapered(row: RollerRow) -> TaperedBearing:
    """The row as a bearing of `lowfi.rollers.tapered_roller`. Raises ValueError where it is none."""
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
