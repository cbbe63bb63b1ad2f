"""Corrections of Hertz's half space for contacts of balls and grooves: the elastic sphere, and the flank's curvature.

Sphere (Lur'e's series): a point load P moves the surface inward by u(t) = P/(8 pi G R) sum (2 n + 1) c_n P_n(cos t) at the
angle t. The term n = 1 is left out: it is a rigid motion, which equilibrium of the ball cancels. With c_n = A/n + B/n^2 +
..., the half space is the term A/sin(t/2). A logarithmic term remains; for the loaded contact itself it is averaged over
the contact area.

Flank: geometry of the groove, and the compliance that the curvature of its surface adds, as a function of contact size.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.tube import HalfGroove
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Material

#: Mean of ln(distance/contact radius) over pairs of points of a circular contact, weighted by Hertz pressure: 11/12 -
#: H(3/2).
MEAN_LOG = 2.0 * np.log(2.0) - 1.75

#: Number of terms of Lur'e's series.
TERMS = 400


def sphere_series_coefficients(n: Array, poisson: float) -> Array:
    """Return the coefficients c_n of Lur'e's series for the motion of an elastic sphere's surface; 0 for n = 1.

    The pressure p_n P_n(cos t) without shear, with the Legendre polynomial P_n and the angle t from the axis of symmetry,
    moves the surface inward by c_n (R/2 G) p_n P_n(cos t), with the sphere's radius R and shear modulus G.

    ``n``: orders of the Legendre polynomials; ``poisson``: Poisson's ratio nu.
    """
    n = np.asarray(n, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        top = n * (n**2 + 2.0 * n - 1.0 + 2.0 * poisson) / (n - 1.0) - (n + 1.0) * (n - 2.0 + 4.0 * poisson)
        c = top / (2.0 * (n**2 + n + 1.0 + poisson * (2.0 * n + 1.0)))
    return np.where(n == 0.0, (1.0 - 2.0 * poisson) / (1.0 + poisson), np.where(n == 1.0, 0.0, c))


def sphere_series_expansion(poisson: float) -> tuple[float, float]:
    """Return the constants A = 2 (1 - nu) and B of the expansion c_n = A/n + B/n^2 + O(n^-3) of Lur'e's coefficients.

    The coefficients are those of `sphere_series_coefficients`.

    ``poisson``: Poisson's ratio nu.
    """
    a = 2.0 * (1.0 - poisson)
    # top = a' n + b' + ..., a' = 4 - 4 nu, b' = 4 - 2 nu; bottom = 2 n^2 (1 + (1 + 2 nu)/n)
    return a, 2.0 - poisson - a * (1.0 + 2.0 * poisson)


@lru_cache(maxsize=64)
def sphere_series_remainder(cosine: float, poisson: float) -> float:
    """Return Lur'e's series for a sphere at an angle from the load, less the closed sums of two of its terms.

    The terms are A/n and B/n^2 with the constants of `sphere_series_expansion`; their sums are singular at the load.
    ``cosine``: cosine of the angle between load and point; ``poisson``: Poisson's ratio. The result is dimensionless.
    """
    from numpy.polynomial.legendre import legval

    a, b = sphere_series_expansion(poisson)
    n = np.arange(2.0, TERMS)
    terms = (2 * n + 1) * sphere_series_coefficients(n, poisson) - 2.0 * a - (a + 2.0 * b) / n
    total = float(legval(cosine, np.append([0.0, 0.0], terms)))
    # n = 0 and 1 of the closed sums: 2 A sum P_n over n >= 0, (A + 2 B) sum P_n / n over n >= 1
    return total + (float(sphere_series_coefficients(np.array(0.0), poisson)) - 2.0 * a - (2.0 * a + a + 2.0 * b) * cosine)


def sphere_compliance(cosine: float, radius: float, material: Material) -> float:
    """Return the inward motion of a point on an elastic ball by a unit point load elsewhere on it [m/N] (Lur'e's series).

    Parameters
    ----------
    cosine
        Cosine of the angle between load and point.
    radius
        Radius of the ball [m].
    material
        Material of the ball.
    """
    nu = material.poissons_ratio
    a, b = sphere_series_expansion(nu)
    s = np.sqrt(0.5 * (1.0 - cosine))
    series = sphere_series_remainder(cosine, nu) + a / s - (a + 2.0 * b) * np.log(s * (1.0 + s))
    return float(series / (8.0 * np.pi * material.shear_modulus * radius))


def sphere_self_compliance_slope(radius: float, material: Material) -> float:
    """Return the derivative of `sphere_self_compliance` by the logarithm of the contact's mean semi-axis [m/N].

    That function gives the motion of a contact on a ball by a unit load on it, less that on a half space. ``radius``:
    radius of the ball [m]; ``material``: material of the ball.
    """
    a, b = sphere_series_expansion(material.poissons_ratio)
    return float(-(a + 2.0 * b) / (8.0 * np.pi * material.shear_modulus * radius))


def sphere_self_compliance(semi_axes: tuple[float, float], radius: float, material: Material) -> float:
    """Return the motion of a contact on an elastic sphere by a unit load on it, less the same on a half space [m/N].

    The motion is averaged over the Hertz pressure.

    Parameters
    ----------
    semi_axes
        Semi-axes of the contact ellipse [m].
    radius
        Radius of the ball [m].
    material
        Material of the ball.
    """
    log = np.log(0.5 * (semi_axes[0] + semi_axes[1]) / (2.0 * radius)) + MEAN_LOG
    smooth = sphere_series_remainder(1.0, material.poissons_ratio) / (8.0 * np.pi * material.shear_modulus * radius)
    return smooth + sphere_self_compliance_slope(radius, material) * float(log)


#: Standard deviation of the narrow load patch on the grooved body's flank, over the ball's radius.
NARROW = 0.18

#: ln of the standard deviation of a circular Gaussian patch with the same mean logarithmic distance as a Hertz pressure of
#: unit mean semi-axis: 2 ln 2 - 7/4 - (ln 2 - gamma/2).
GAUSSIAN = float(np.log(2.0) - 1.75 + 0.5 * np.euler_gamma)


def half_space_compliance(patch_width: float, material: Material) -> float:
    """Return the mean motion of a half space under a circular Gaussian patch of unit normal load [m/N].

    It is (1 - nu^2)/(2 sqrt(pi) E s) with the standard deviation s of the patch.

    Parameters
    ----------
    patch_width
        Standard deviation s of the patch [m].
    material
        Material of the half space.

    Examples
    --------
    >>> round(half_space_compliance(0.1e-3, Material(210e9, 0.3)) * 1e9, 4)  # nm/N
    12.2241
    """
    return float((1.0 - material.poissons_ratio**2) / (2.0 * np.sqrt(np.pi) * material.youngs_modulus * patch_width))


def flank_curvatures(flank: HalfGroove) -> tuple[float, float]:
    """Return the principal curvatures of a groove flank at the nominal contact [1/m], across the groove and along it.

    Convex curvatures are positive.
    """
    m = flank.groove_map
    along = np.cos(m.beta) / flank.contact_position()[0] * (1.0 if flank.is_screw else -1.0)
    return -1.0 / float(m.radius[flank.flank_number]), float(along)


def contact_size_correction_slope(flank: HalfGroove) -> float:
    """Return the derivative of `contact_size_correction` by the logarithm of the contact's mean semi-axis [m/N].

    The derivative is proportional to the mean curvature of the flank. ``flank``: groove of the body.
    """
    a, b = sphere_series_expansion(flank.material.poissons_ratio)
    return float(-(a + 2.0 * b) / (16.0 * np.pi * flank.material.shear_modulus) * sum(flank_curvatures(flank)))


def contact_size_correction(flank: HalfGroove, semi_axes: tuple[float, float]) -> float:
    """Return a flank's compliance at a contact of given size less that at a narrow circular load patch [m/N].

    ``flank``: groove of the body; ``semi_axes``: semi-axes of the contact ellipse, across the groove and along it [m].
    """
    a, b = semi_axes
    nu, G = flank.material.poissons_ratio, flank.material.shear_modulus
    across, along = flank_curvatures(flank)
    shape = (1.0 - 2.0 * nu) * (3.0 - 2.0 * nu) / (16.0 * np.pi * G) * (across - along) * (a - b) / (a + b)
    return float(
        contact_size_correction_slope(flank) * (np.log(0.5 * (a + b) / (NARROW * flank.groove_map.ball)) + GAUSSIAN) + shape
    )
