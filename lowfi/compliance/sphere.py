"""The ball as an elastic sphere: what contacts do to one another through it, beyond Hertz's half space (Lur'e's series).

A point load P presses the surface in by u(t) = P/(8 pi G R) sum (2 n + 1) c_n P_n(cos t), n = 1 left out: that term is the
rigid motion, which the ball's equilibrium takes out again. With c_n = A/n + B/n^2 + ... the half space is A/sin(t/2) and a
logarithm is left, averaged over the contact for its own term.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Material

#: Mean logarithm of the distance of two points of a round Hertz pressure over its radius, 11/12 - H(3/2).
MEAN_LOG = 2.0 * np.log(2.0) - 1.75
TERMS = 400


def legendre_compliance(n: Array, poisson: float) -> Array:
    """c_n of a sphere: u = c_n (R / 2 G) p_n inward under the pressure p_n P_n(cos t), no shear; 0 for n = 1."""
    n = np.asarray(n, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        top = n * (n**2 + 2.0 * n - 1.0 + 2.0 * poisson) / (n - 1.0) - (n + 1.0) * (n - 2.0 + 4.0 * poisson)
        c = top / (2.0 * (n**2 + n + 1.0 + poisson * (2.0 * n + 1.0)))
    return np.where(n == 0.0, (1.0 - 2.0 * poisson) / (1.0 + poisson), np.where(n == 1.0, 0.0, c))


def expansion(poisson: float) -> tuple[float, float]:
    """A = 2 (1 - nu) and B of c_n = A/n + B/n^2 + O(n^-3)."""
    a = 2.0 * (1.0 - poisson)
    # top = a' n + b' + ..., a' = 4 - 4 nu, b' = 4 - 2 nu; bottom = 2 n^2 (1 + (1 + 2 nu)/n)
    return a, 2.0 - poisson - a * (1.0 + 2.0 * poisson)


@lru_cache(maxsize=64)
def smooth_part(cosine: float, poisson: float) -> float:
    """Series at angle arccos(cosine) without its first two terms' sums in closed form (both vanish at the contact)."""
    from numpy.polynomial.legendre import legval

    a, b = expansion(poisson)
    n = np.arange(2.0, TERMS)
    terms = (2 * n + 1) * legendre_compliance(n, poisson) - 2.0 * a - (a + 2.0 * b) / n
    total = float(legval(cosine, np.append([0.0, 0.0], terms)))
    # n = 0 and 1 of the closed sums: 2 A sum P_n over n >= 0, (A + 2 B) sum P_n / n over n >= 1
    total += float(legendre_compliance(np.array(0.0), poisson)) - 2.0 * a - (2.0 * a + a + 2.0 * b) * cosine
    return total


def sphere_compliance(cosine: float, radius: float, material: Material) -> float:
    """Motion inward [m/N] at an angle from a unit point load on a ball of ``radius`` [m]."""
    nu = material.poissons_ratio
    a, b = expansion(nu)
    s = np.sqrt(0.5 * (1.0 - cosine))
    series = smooth_part(cosine, nu) + a / s - (a + 2.0 * b) * np.log(s * (1.0 + s))
    return float(series / (8.0 * np.pi * material.shear_modulus * radius))


def own_slope(radius: float, material: Material) -> float:
    """Change of `own_compliance` with the logarithm of a contact's size [m/N]."""
    a, b = expansion(material.poissons_ratio)
    return float(-(a + 2.0 * b) / (8.0 * np.pi * material.shear_modulus * radius))


def own_compliance(semi_axes: tuple[float, float], radius: float, material: Material) -> float:
    """Motion of a contact of ``semi_axes`` [m] by its own unit load beyond that of a half space [m/N] (mean over Hertz's
    pressure)."""
    log = np.log(0.5 * (semi_axes[0] + semi_axes[1]) / (2.0 * radius)) + MEAN_LOG
    smooth = smooth_part(1.0, material.poissons_ratio) / (8.0 * np.pi * material.shear_modulus * radius)
    return smooth + own_slope(radius, material) * float(log)
