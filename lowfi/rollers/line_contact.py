"""Line contact of a roller between two raceways: half-width, pressure, approach and its closed-form inverse.

The contact itself is Hertz's: b^2 = 4 q R / (pi E*), p_0 = 2 q / (pi b), q the load per length, R the relative radius. The
approach of a line contact is not a property of the contact: in plane strain it grows with the logarithm of the depth to
which it is measured. Here from the roller's centre (Johnson, Contact Mechanics, 1985, 5.57) to a depth in the ring (5.58),

    delta = q (1 - nu^2)/(pi E) [2 ln(4 R_1/b) - 1]  +  q (1 - nu^2)/(pi E) [2 ln(2 d/b) - nu/(1 - nu)],

at both races. With b ~ sqrt(q) that is delta = q (g - S ln q): not a power law, though its slope is near the exponents 1.1
and 10/9 that are used for rollers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_modulus
from rollbench.meshes.arrays import Array


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
