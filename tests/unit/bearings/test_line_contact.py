"""Line contact: Hertz, and approach and compression against integrals of the stresses below the contact."""

import numpy as np
import pytest
from scipy.integrate import quad
from tests.tapered_row_oracle import energy_per_length

from rollbench.lowfi.hertz import contact_modulus, hertz_constants
from rollbench.lowfi.rollers import LineContactLaw, approach_law_of_races, line_contact_half_width, line_contact_pressure

YOUNG, POISSON = 207e9, 0.3
MODULUS = contact_modulus(YOUNG, POISSON, YOUNG, POISSON)
LAW = approach_law_of_races(4e-3, (1.0 / 20e-3, -1.0 / 28e-3), (5e-3, 5e-3), YOUNG, POISSON)


def test_half_width_is_the_limit_of_long_ellipses():
    """An ellipse of ratio 1e-5 under the same load per length at its middle has the same minor axis."""
    k = 300.0
    h = hertz_constants(np.array(1e-8 * k), np.array(k), MODULUS)
    force = 1e3
    a, b = float(h.C_a) * np.cbrt(force), float(h.C_b) * np.cbrt(force)
    peak = 1.5 * force / (np.pi * a * b)
    line = 0.5 * np.pi * b * peak
    assert float(line_contact_half_width(line, k, MODULUS)) == pytest.approx(b, rel=1e-5)
    assert float(line_contact_pressure(line, b)) == pytest.approx(peak, rel=1e-12)


def test_source_s_constant_of_the_half_width():
    """b = 2.78e-4 sqrt(q/curvature) in lb and in, for 30e6 psi and 0.3."""
    inch, pound = 0.0254, 4.4482216152605
    psi = contact_modulus(*(30e6 * pound / inch**2, 0.3) * 2)
    assert float(line_contact_half_width(pound / inch, 1.0 / inch, psi)) / inch == pytest.approx(2.78e-4, rel=1e-3)
    with pytest.raises(ValueError, match="must be positive"):
        line_contact_half_width(1.0, 0.0, MODULUS)


def strain(stress_x, stress_z):
    return ((1.0 - POISSON**2) * stress_z - POISSON * (1.0 + POISSON) * stress_x) / YOUNG


def downwards(f, b: float, depth: float) -> float:
    """Integral of f from 0 to the depth, with z = b sinh(t): even steps from the contact's scale to the body's."""
    return quad(lambda t: f(b * np.sinh(t)) * b * np.cosh(t), 0.0, np.arcsinh(depth / b), epsrel=1e-12)[0]


def ring(q: float, b: float, depth: float) -> float:
    """Compression of a half space below a Hertz line contact down to a depth."""
    peak = 2.0 * q / (np.pi * b)

    def below(z):
        root = np.hypot(b, z)
        return strain(-peak * b**3 / ((root + z) ** 2 * root), -peak * b / root)

    return -downwards(below, b, depth)


def half_roller(q: float, b: float, radius: float) -> float:
    """Compression of a cylinder between two opposite contacts, from one to its centre (Johnson 1985, 5.55, 5.56).

    The differences of nearly equal terms are written out: (b^2 + 2 z^2)/(b^2 r) - 2 z/b^2 = b^2/((r + z)^2 r).
    """

    def inside(z):
        root = np.hypot(b, z)
        sx = q / np.pi * (1.0 / radius - 2.0 * b**2 / ((root + z) ** 2 * root))
        sz = q / np.pi * (1.0 / radius - 2.0 / root - 2.0 / (2.0 * radius - z))
        return strain(sx, sz)

    return -downwards(inside, b, radius)


@pytest.mark.parametrize("q", [1e3, 3e4, 2e5])
def test_approach_is_the_integral_of_the_strains(q):
    """The closed form drops terms of the order (b/R)^2 ln: it meets the integrals to that."""
    total, size = 0.0, 0.0
    for curvature in (1 / 4e-3 + 1 / 20e-3, 1 / 4e-3 - 1 / 28e-3):
        b = float(line_contact_half_width(q, curvature, MODULUS))
        total += ring(q, b, 5e-3) + half_roller(q, b, 4e-3)
        size = max(size, b / 4e-3)
    assert float(LAW.approach(q)) == pytest.approx(total, rel=0.2 * size**2)


def test_coefficient_is_the_one_of_the_source():
    """8.89e-8 in 3.19 is S ln 10 for 30e6 psi and 0.3: two line contacts, four bodies."""
    inch, pound = 0.0254, 4.4482216152605
    law = approach_law_of_races(4e-3, (0.0, 0.0), (5e-3, 5e-3), 30e6 * pound / inch**2, 0.3)
    assert law.s * np.log(10.0) * pound / inch**2 == pytest.approx(8.89e-8, rel=1e-3)


def test_lambert_inverse_to_round_off():
    q = np.concatenate([[0.0], np.geomspace(1e-6, 1e6, 25)])
    np.testing.assert_allclose(LAW.line_load(LAW.approach(q)), q, rtol=1e-12)
    assert float(LAW.line_load(-1e-6)) == 0.0
    top = LAW.s * np.exp(float(LAW.g) / LAW.s - 1.0)
    assert float(LAW.approach(LAW.line_load(0.999 * top))) == pytest.approx(0.999 * top, rel=1e-9)
    with pytest.raises(ValueError, match="line contact"):
        LAW.line_load(1.001 * top)


@pytest.mark.parametrize("q", [1e2, 1e5])
def test_slope_and_energy(q):
    h = 1e-4 * q
    slope = 2.0 * h / float(LAW.approach(q + h) - LAW.approach(q - h))
    assert float(LAW.stiffness_per_length(q)) == pytest.approx(slope, rel=1e-7)
    work = quad(lambda d: float(LAW.line_load(d)), 0.0, float(LAW.approach(q)), epsrel=1e-10)[0]
    assert float(energy_per_length(LAW, np.array(q))) == pytest.approx(work, rel=1e-8)
    assert LAW.stiffness_per_length(0.0) == energy_per_length(LAW, np.zeros(1))[0] == LAW.approach(0.0) == 0.0


def test_local_exponent_is_near_the_usual_ones():
    q = np.geomspace(1e4, 3e5, 20)
    exponent = LAW.stiffness_per_length(q) * LAW.approach(q) / q
    assert exponent.min() > 1.07
    assert exponent.max() < 1.14


def test_similar_bodies_are_similar():
    """Twice the size under the same pressure, twice the approach: what 3.19 of the source is not."""
    twice = approach_law_of_races(8e-3, (1.0 / 40e-3, -1.0 / 56e-3), (10e-3, 10e-3), YOUNG, POISSON)
    assert float(twice.approach(2e5)) == pytest.approx(2.0 * float(LAW.approach(1e5)), rel=1e-13)
    assert isinstance(twice, LineContactLaw)
