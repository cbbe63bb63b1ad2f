"""The elastic sphere: Lur'e's series against its sum, against finite elements, and its limits."""

import numpy as np
import pytest
from scipy.special import eval_legendre

from rollbench.lowfi.compliance import beyond_hertz
from rollbench.meshes.parts import Material

STEEL, RADIUS = Material(210e9, 0.28), 2.778e-3
UNIT = 8.0 * np.pi * STEEL.shear_modulus * RADIUS
POISSON = (0.0, 0.28, 0.45)


def summed(cosine, poisson, terms=4000):
    """Sum of (2 n + 1) c_n P_n by second means, which converge where the series does not; their 1/terms extrapolated."""
    n = np.arange(2 * terms)
    x = (2 * n + 1) * beyond_hertz.sphere_series_coefficients(n, poisson) * eval_legendre(n, cosine)

    def mean(count):
        return float(x[:count] @ ((1.0 - n[:count] / count) * (1.0 - n[:count] / (count + 1.0))))

    return 2.0 * mean(2 * terms) - mean(terms)


@pytest.mark.parametrize("poisson", POISSON)
@pytest.mark.parametrize("angle", [5.0, 20.0, 90.0, 120.0, 180.0])
def test_series_against_its_sum(angle, poisson):
    material = Material(210e9, poisson)
    cosine = np.cos(np.radians(angle))
    unit = 8.0 * np.pi * material.shear_modulus * RADIUS
    found = unit * beyond_hertz.sphere_compliance(cosine, RADIUS, material)
    assert found == pytest.approx(summed(cosine, poisson), rel=1e-5, abs=2e-5)


def test_small_angle_is_the_half_space():
    """(1 - nu^2)/(pi E d) at a distance d, and the logarithm of curvature beyond it."""
    nu, E = STEEL.poissons_ratio, STEEL.youngs_modulus
    a, b = beyond_hertz.sphere_series_expansion(nu)
    rest = []
    for angle in (1e-2, 1e-3, 1e-4):
        distance = 2.0 * RADIUS * np.sin(0.5 * angle)
        found = beyond_hertz.sphere_compliance(np.cos(angle), RADIUS, STEEL)
        space = (1 - nu**2) / (np.pi * E * distance)
        assert found == pytest.approx(space, rel=2.0 * angle * np.log(1.0 / angle), abs=0.0)
        rest.append(UNIT * (found - space) + (a + 2 * b) * np.log(0.5 * angle))
    assert rest[1] == pytest.approx(rest[2], abs=2e-2)
    assert rest[0] == pytest.approx(rest[2], abs=2e-1)


def disc_average(radius, count=24):
    """Mean of ``sphere_compliance`` beyond the half space over two points of a round Hertz pressure, by quadrature."""
    x, w = np.polynomial.legendre.leggauss(count)
    s, ws = 0.5 * (x + 1.0), 0.5 * w
    density = 3.0 * s * np.sqrt(1.0 - s * s) * ws
    turn = (np.arange(4 * count) + 0.5) * 2.0 * np.pi / (4 * count)
    a, b, t = np.meshgrid(s, s, turn, indexing="ij")
    distance = radius * np.sqrt(a * a + b * b - 2.0 * a * b * np.cos(t)).ravel()
    nu, E = STEEL.poissons_ratio, STEEL.youngs_modulus
    table = np.geomspace(distance.min(), distance.max(), 60)
    cosines = 1.0 - 0.5 * (table / RADIUS) ** 2
    found = np.array([beyond_hertz.sphere_compliance(x, RADIUS, STEEL) for x in cosines])
    value = found - (1 - nu**2) / (np.pi * E * table)
    assert cosines.min() > 0.9
    beyond = np.interp(np.log(distance), np.log(table), value).reshape(a.shape).mean(axis=2)
    return float(density @ beyond @ density)


@pytest.mark.parametrize("share", [0.05, 0.1])
def test_own_compliance_is_the_mean_over_the_contact(share):
    size = share * RADIUS
    axes = ((size, size), (1.2 * size, 0.8 * size), (2.0 * size, 2.0 * size))
    one, oblong, double = (beyond_hertz.sphere_self_compliance(semi, RADIUS, STEEL) for semi in axes)
    assert one == pytest.approx(disc_average(size), rel=0.02, abs=0.0)
    assert oblong == pytest.approx(one, rel=1e-12, abs=0.0)
    a, b = beyond_hertz.sphere_series_expansion(STEEL.poissons_ratio)
    assert UNIT * (one - double) == pytest.approx((a + 2 * b) * np.log(2.0), rel=1e-12, abs=0.0)
