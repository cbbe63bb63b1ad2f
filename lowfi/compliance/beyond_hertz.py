"""Corrections of Hertz's half space: the ball as an elastic sphere, the flank by its curvature.

Sphere (Lur'e's series): a point load P presses the surface in by u(t) = P/(8 pi G R) sum (2 n + 1) c_n P_n(cos t), n = 1
left out: that term is the rigid motion, which the ball's equilibrium takes out again. With c_n = A/n + B/n^2 + ... the half
space is A/sin(t/2) and a logarithm is left, averaged over the contact for its own term.

Flank: its geometry, and what its curvature adds, by the size of the contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.fourier import Grid


#: Mean logarithm of the distance of two points of a round Hertz pressure over its radius, 11/12 - H(3/2).
MEAN_LOG = 2.0 * np.log(2.0) - 1.75

TERMS = 400


def legendre_compliance(n: Array, poisson: float) -> Array:
    """Return c_n of a sphere, u = c_n (R/2 G) p_n inward under the pressure p_n P_n(cos t) without shear; 0 for n = 1."""
    n = np.asarray(n, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        top = n * (n**2 + 2.0 * n - 1.0 + 2.0 * poisson) / (n - 1.0) - (n + 1.0) * (n - 2.0 + 4.0 * poisson)
        c = top / (2.0 * (n**2 + n + 1.0 + poisson * (2.0 * n + 1.0)))
    return np.where(n == 0.0, (1.0 - 2.0 * poisson) / (1.0 + poisson), np.where(n == 1.0, 0.0, c))


def harmonic_expansion(poisson: float) -> tuple[float, float]:
    """Return A = 2 (1 - nu) and B of c_n = A/n + B/n^2 + O(n^-3)."""
    a = 2.0 * (1.0 - poisson)
    # top = a' n + b' + ..., a' = 4 - 4 nu, b' = 4 - 2 nu; bottom = 2 n^2 (1 + (1 + 2 nu)/n)
    return a, 2.0 - poisson - a * (1.0 + 2.0 * poisson)


@lru_cache(maxsize=64)
def smooth_part(cosine: float, poisson: float) -> float:
    """Return series at an angle arccos(cosine) without closed sums of its first two terms; both vanish at the contact."""
    from numpy.polynomial.legendre import legval

    a, b = harmonic_expansion(poisson)
    n = np.arange(2.0, TERMS)
    terms = (2 * n + 1) * legendre_compliance(n, poisson) - 2.0 * a - (a + 2.0 * b) / n
    total = float(legval(cosine, np.append([0.0, 0.0], terms)))
    # n = 0 and 1 of the closed sums: 2 A sum P_n over n >= 0, (A + 2 B) sum P_n / n over n >= 1
    total += float(legendre_compliance(np.array(0.0), poisson)) - 2.0 * a - (2.0 * a + a + 2.0 * b) * cosine
    return total


def sphere_compliance(cosine: float, radius: float, material: Material) -> float:
    """Return the motion inward at an angle from a unit point load on an elastic ball [m/N] (Lur'e's series).

    Parameters
    ----------
    cosine
        Of the angle between load and point.
    radius
        Of the ball [m].
    material
        Of the ball.
    """
    nu = material.poissons_ratio
    a, b = harmonic_expansion(nu)
    s = np.sqrt(0.5 * (1.0 - cosine))
    series = smooth_part(cosine, nu) + a / s - (a + 2.0 * b) * np.log(s * (1.0 + s))
    return float(series / (8.0 * np.pi * material.shear_modulus * radius))


def own_slope(radius: float, material: Material) -> float:
    """Return the change of `own_compliance` with the logarithm of a contact's size [m/N]."""
    a, b = harmonic_expansion(material.poissons_ratio)
    return float(-(a + 2.0 * b) / (8.0 * np.pi * material.shear_modulus * radius))


def own_compliance(semi_axes: tuple[float, float], radius: float, material: Material) -> float:
    """Return the motion of a contact under unit load beyond that of a half space [m/N], averaged over the pressure.

    Parameters
    ----------
    semi_axes
        Of the contact [m].
    radius
        Of the ball [m].
    material
        Of the ball.
    """
    log = np.log(0.5 * (semi_axes[0] + semi_axes[1]) / (2.0 * radius)) + MEAN_LOG
    smooth = smooth_part(1.0, material.poissons_ratio) / (8.0 * np.pi * material.shear_modulus * radius)
    return smooth + own_slope(radius, material) * float(log)


#: Standard deviation of the narrow patch over the ball's radius, and elements of its mesh (flank, land, depth).
NARROW = 0.18

MESH = (8, 4, 10)

#: ln of the standard deviation of a round Gaussian with the same mean logarithmic distance as a Hertz pressure of unit
#: mean semi-axis: 2 ln 2 - 7/4 - (ln 2 - gamma/2).
GAUSSIAN = float(np.log(2.0) - 1.75 + 0.5 * np.euler_gamma)


@dataclass(frozen=True)
class Flank:
    """Groove of one body on half a lead."""

    #: Geometry of the groove.
    map: GrooveMap
    #: Radius of the lands [m].
    land: float
    #: Radius of the plain surface, bore or outer radius [m].
    far: float
    #: Whether it is the screw's; otherwise the nut's.
    screw: bool
    #: Half a lead, or half a ring's width [m].
    half: float
    #: Material of the body.
    material: Material

    @property
    def side(self) -> int:
        """Flank that is computed, SR or NR; the other one is its mirror image."""
        return 1 if self.screw else 3

    def grid(self, mesh: tuple[int, int, int] | None = None) -> Grid:
        """Return the finite-element grid of half a lead with its groove."""
        from rollbench.lowfi.compliance.tube import cell_grid  # finite elements: for bodies that are not known yet

        return cell_grid(self.map, self.land, self.far, self.screw, mesh or MESH, self.half)

    def contact(self) -> tuple[float, float]:
        """Return the nominal contact point (r, zeta) [m]."""
        m = self.map
        x3, z3 = m.ball * m.signs[self.side] * np.array([np.cos(m.beta), np.sin(m.beta)])
        r, zeta, _ = m.unroll(np.array(x3), np.array(z3))
        return float(r), float(zeta)


def half_space(width: float, material: Material) -> float:
    """Return mean motion of a round Gaussian patch on a half space by its normal load, (1 - nu^2)/(2 sqrt(pi) E s) [m/N].

    Parameters
    ----------
    width
        Standard deviation s of the patch [m].
    material
        Of the half space.

    Examples
    --------
    >>> round(half_space(0.1e-3, Material(210e9, 0.3)) * 1e9, 4)  # nm/N
    12.2241
    """
    return float((1.0 - material.poissons_ratio**2) / (2.0 * np.sqrt(np.pi) * material.youngs_modulus * width))


def flank_curvatures(flank: Flank) -> tuple[float, float]:
    """Return principal curvatures of the flank at the contact, across the groove and along it, convex positive [1/m]."""
    m = flank.map
    along = np.cos(m.beta) / flank.contact()[0] * (1.0 if flank.screw else -1.0)
    return -1.0 / float(m.radius[flank.side]), float(along)


def size_slope(flank: Flank) -> float:
    """Return the change of `at_size` with the logarithm of a contact's size [m/N], by the flank's mean curvature."""
    a, b = harmonic_expansion(flank.material.poissons_ratio)
    return float(-(a + 2.0 * b) / (16.0 * np.pi * flank.material.shear_modulus) * sum(flank_curvatures(flank)))


def at_size(flank: Flank, semi_axes: tuple[float, float]) -> float:
    """Return the effect of size and shape of a contact on the correction for the narrow round patch [m/N]."""
    a, b = semi_axes
    nu, G = flank.material.poissons_ratio, flank.material.shear_modulus
    across, along = flank_curvatures(flank)
    shape = (1.0 - 2.0 * nu) * (3.0 - 2.0 * nu) / (16.0 * np.pi * G) * (across - along) * (a - b) / (a + b)
    return float(size_slope(flank) * (np.log(0.5 * (a + b) / (NARROW * flank.map.ball)) + GAUSSIAN) + shape)
