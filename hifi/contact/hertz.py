"""Hertz's elliptical contact in closed form, against which the 3D reference is verified.

Derived from Johnson, Contact Mechanics (1985), section 3.3, with the integrals by quadrature. It is independent of the
Hertz formulas of the low-order models, so that neither can hide an error of the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

#: Smallest axis ratio b/a of the contact ellipse for which the quadrature is accurate.
THINNEST = 1e-3


@dataclass(frozen=True)
class HertzSolution:
    """Solution of Hertz's contact of two bodies: approach, ellipse and pressure under a normal force."""

    #: Approach of distant points of the bodies [m].
    approach: float
    #: Semi-axis of the contact ellipse along x [m].
    semi_x: float
    #: Semi-axis of the contact ellipse along y [m].
    semi_y: float
    #: Largest contact pressure p0, at the centre of the ellipse [Pa].
    pole_pressure: float
    #: Normal force F [N].
    normal_force: float

    def pressure(self, x: Array, y: Array) -> Array:
        """Compute the contact pressure at points of the contact plane [Pa]; zero outside the ellipse.

        Parameters
        ----------
        x, y : Array
            Coordinates from the contact's centre [m].

        Returns
        -------
        Array
            Pressure p0 sqrt(1 - (x/a)^2 - (y/b)^2) [Pa].
        """
        inside = np.maximum(1.0 - (x / self.semi_x) ** 2 - (y / self.semi_y) ** 2, 0.0)
        return np.asarray(self.pole_pressure * np.sqrt(inside))


def solve_hertz(load: float, radius_x: float, radius_y: float, young: float, poisson: float) -> HertzSolution:
    """Solve Hertz's contact of two bodies of one material with the gap x^2/(2 radius_x) + y^2/(2 radius_y).

    With m = 1 - b^2/a^2, the pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2) displaces a surface of contact modulus E* by p0 b / E*
    (K - D x^2/a^2 - H y^2/a^2), where K, D, H are the integrals of `_elliptic_integrals`. Matching the gap gives the ratio
    of curvatures D / H, then a^3 = 3 F D / (2 pi E* A) with A = 1/(2 radius_x), and the approach p0 b K / E*. Valid for
    smooth half-spaces, small strain, no friction, and ellipses not thinner than `THINNEST`.

    Parameters
    ----------
    load : float
        Normal force F [N], > 0.
    radius_x, radius_y : float
        Relative radii of curvature [m], > 0, in any order.
    young : float
        Young's modulus of both bodies [Pa]; 1/E* = 2 (1 - nu^2)/E.
    poisson : float
        Poisson's ratio of both bodies.

    Returns
    -------
    HertzSolution
        Approach, semi-axes and largest pressure in closed form.

    Raises
    ------
    ValueError
        Load, radii or modulus are not positive, or the ellipse is thinner than `THINNEST`.

    References
    ----------
    Johnson, Contact Mechanics (1985), section 3.3.

    Examples
    --------
    >>> sphere = solve_hertz(225.0, 2.778e-3, 2.778e-3, 210e9, 0.28)
    >>> f"{1e6 * sphere.approach:.5f} um, {1e3 * sphere.semi_x:.6f} mm, {1e-6 * sphere.pole_pressure:.2f} MPa"
    '9.24316 um, 0.160242 mm, 4183.80 MPa'
    """
    if min(load, radius_x, radius_y, young) <= 0.0:
        raise ValueError(
            "load, relative radii and Young's modulus of a Hertzian contact must be > 0, "
            f"got {load:.4g} N, {radius_x:.4g} m, {radius_y:.4g} m and {young:.4g} Pa"
        )
    if radius_x < radius_y:
        turned = solve_hertz(load, radius_y, radius_x, young, poisson)
        return HertzSolution(turned.approach, turned.semi_y, turned.semi_x, turned.pole_pressure, load)
    modulus = young / (2.0 * (1.0 - poisson**2))
    low = 0.5 / radius_x
    ratio = _axis_ratio_of_contact_ellipse(radius_y / radius_x)
    k, d, _ = _elliptic_integrals(ratio)
    a = (1.5 * load * d / (np.pi * modulus * low)) ** (1.0 / 3.0)  # a^3 = 3 F D / (2 pi E* A)
    b = ratio * a
    pole = 1.5 * load / (np.pi * a * b)  # p0 of the semi-ellipsoid with the load F
    return HertzSolution(float(pole * b * k / modulus), float(a), float(b), float(pole), load)


def _axis_ratio_of_contact_ellipse(curvature_ratio: float) -> float:
    """Find the ratio b/a of the contact ellipse's semi-axes a >= b from the ratio of the relative curvatures.

    ``curvature_ratio``: relative curvature along the long semi-axis a over that along the short one b, at most 1.
    """
    if curvature_ratio > 1.0 - 1e-15:
        return 1.0

    def mismatch_of_curvatures(log_ratio: float) -> float:
        """Return ln(D/H) less the logarithm of the given curvature ratio, for the ellipse b/a = exp(log_ratio).

        D/H: curvature ratio of this ellipse, from the integrals D and H of `_elliptic_integrals`.
        """
        _, d, h = _elliptic_integrals(float(np.exp(log_ratio)))
        return float(np.log(d / h / curvature_ratio))

    thinnest = float(np.log(THINNEST))
    if mismatch_of_curvatures(thinnest) > 0.0:
        raise ValueError(f"the Hertzian contact ellipse is thinner than b/a = {THINNEST}: treat it as a line contact")
    return float(np.exp(brentq(mismatch_of_curvatures, thinnest, 0.0, xtol=1e-15, rtol=1e-15)))


def _elliptic_integrals(ratio: float) -> tuple[float, float, float]:
    """Compute the elliptic integrals K, D, H of Hertz's theory for a contact ellipse of axis ratio b/a = ``ratio``.

    They are the integrals over (0, pi/2) of 1/q, sin^2/q and sin^2/q^3 with q^2 = 1 - m sin^2, m = 1 - ratio^2. K is
    the complete integral of the first kind; D = (K - E)/m and H = (E/(1 - m) - K)/m, with that of the second kind E, are
    thus computed without cancellation at m = 0. The quadrature with equal steps converges exponentially on these periodic
    functions, with about 20 points times 1/ratio.
    """
    count = 32 + int(np.ceil(24.0 / ratio))
    theta = (np.arange(count) + 0.5) * (0.5 * np.pi / count)
    sine2 = np.sin(theta) ** 2
    q2 = np.cos(theta) ** 2 + ratio**2 * sine2
    weight = 0.5 * np.pi / count
    K, D, H = (float(weight * np.sum(x)) for x in (q2**-0.5, sine2 * q2**-0.5, sine2 * q2**-1.5))
    return K, D, H
