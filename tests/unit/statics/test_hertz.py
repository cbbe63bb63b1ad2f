"""Elliptical Hertz contact against closed forms, tabulated cases and the classical equations."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipk, elliprd, elliprf
from tests.helpers import relative, solved, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.hertz import complete_elliptic_integrals, contact_modulus, ellipse_semi_axis_ratio, hertz_constants
from rollbench.lowfi.statics.contacts import hertz_at_contact_angles
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout

MODULUS = contact_modulus(210e9, 0.28, 210e9, 0.28)
RADIUS, FORCE = 2.778e-3, 225.0


def contact(along, across, force=FORCE, modulus=MODULUS):
    """Approach, semi-axes and pole pressure."""
    c = hertz_constants(along, across, modulus)
    return c.C * force ** (2 / 3), c.C_a * np.cbrt(force), c.C_b * np.cbrt(force), c.pressure(force)


def test_contact_modulus_of_unlike_bodies():
    assert contact_modulus(210e9, 0.28, 310e9, 0.26) == pytest.approx(1.0 / (0.9216 / 210e9 + 0.9324 / 310e9), rel=1e-15)
    assert contact_modulus(210e9, 0.28, np.inf, 0.3) == pytest.approx(210e9 / 0.9216, rel=1e-15)


def test_integrals_are_carlsons_from_the_circle_to_the_line_contact():
    k = np.geomspace(1e-6, 1.0, 200)
    expected = elliprf(0.0, 1.0, k**2), elliprd(0.0, k**2, 1.0), elliprd(0.0, 1.0, k**2)
    for found, exact in zip(complete_elliptic_integrals(k), expected, strict=True):
        assert found == pytest.approx(exact, rel=3e-15)


def test_sphere_on_flat():
    found = contact(1 / RADIUS, 1 / RADIUS)
    a = np.cbrt(3 * FORCE * RADIUS / (4 * MODULUS))
    expected = a**2 / RADIUS, a, a, np.cbrt(6 * FORCE * MODULUS**2 / (np.pi**3 * RADIUS**2))
    assert found == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(("ratio", "tolerance"), [(1e-4, 1e-3), (1e-6, 2e-5), (1e-8, 3e-7), (1e-10, 5e-9)])
def test_line_contact_limit(ratio, tolerance):
    """At the centre of a long ellipse: Hertz's line contact under the load per length found there."""
    across = 1 / RADIUS
    _, a, b, pressure = contact(ratio * across, across)
    per_length = 3 * FORCE / (4 * a)  # the integral of p0 sqrt(1 - y2/b2) over the width, p0 = 3F/(2 pi a b)
    assert b == pytest.approx(np.sqrt(4 * per_length * RADIUS / (np.pi * MODULUS)), rel=tolerance)
    assert pressure == pytest.approx(np.sqrt(per_length * MODULUS / (np.pi * RADIUS)), rel=tolerance)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-12])
def test_circle_is_approached_without_loss_of_digits(gap):
    """For A/B = 1 - gap: b/a = 1 - 2 gap / 3 and the approach of the mean curvature, both up to gap squared."""
    assert ellipse_semi_axis_ratio(1 - gap) == pytest.approx(1 - 2 * gap / 3, abs=gap**2 + 1e-15)
    found = contact((1 - gap) / RADIUS, 1 / RADIUS)
    circle = contact((1 - gap / 2) / RADIUS, (1 - gap / 2) / RADIUS)
    assert found[0] == pytest.approx(circle[0], rel=gap**2 + 1e-14)
    assert found[3] == pytest.approx(circle[3], rel=gap**2 + 1e-14)


@pytest.mark.parametrize("ratio", [0.9, 0.5, 0.2, 0.0467, 0.005])
def test_johnsons_equations_hold(ratio):
    """Johnson 1985, 4.26-4.28 with K and E of the eccentricity (Lin B.2, B.8 with the ratio the right way round)."""
    half_low, half_high = 0.5 * ratio / RADIUS, 0.5 / RADIUS
    approach, a, b, pressure = contact(2 * half_low, 2 * half_high)
    m = 1 - (b / a) ** 2
    k, e = ellipk(m), ellipe(m)
    assert half_high / half_low == pytest.approx(((a / b) ** 2 * e - k) / (k - e), rel=1e-11)
    root = np.sqrt(((a / b) ** 2 * e - k) * (k - e))
    assert np.sqrt(half_low * half_high) == pytest.approx(pressure / MODULUS * b / (a**2 * m) * root, rel=1e-11)
    assert approach == pytest.approx(pressure / MODULUS * b * k, rel=1e-11)
    assert pressure == pytest.approx(1.5 * FORCE / (np.pi * a * b), rel=1e-14)
    assert hertz_constants(ratio, 1.0, MODULUS).eccentricity == pytest.approx(np.sqrt(m), rel=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 0.3, 1e-5])
def test_scaling(ratio):
    """Approach as F^(2/3) E^(-2/3) kappa^(1/3), axes as F^(1/3) E^(-1/3) kappa^(-1/3), pressure as F^(1/3)."""
    one = hertz_constants(ratio / RADIUS, 1 / RADIUS, MODULUS)
    assert one.pressure(8 * FORCE) == pytest.approx(2 * one.pressure(FORCE), rel=1e-14)
    soft = hertz_constants(ratio / RADIUS, 1 / RADIUS, MODULUS / 8)
    small = hertz_constants(8 * ratio / RADIUS, 8 / RADIUS, MODULUS)
    for other, factors in ((soft, (4, 2, 2)), (small, (2, 0.5, 0.5))):
        assert (other.C / one.C, other.C_a / one.C_a, other.C_b / one.C_b) == pytest.approx(factors, rel=1e-13)


def test_hertz_at_the_actual_geometry_is_consistent_with_the_solution():
    """The constants are those of the surfaces at the contact angles found with them, and not those of error-free parts."""
    nominal = catalogue.scene("lin-case3-offset")
    scene = with_ingredients(nominal, hertz="actual")
    result = solved(scene)
    gamma = np.where(np.isnan(result.contact_angle), scene.track.contact_angle, result.contact_angle)
    expected = hertz_at_contact_angles(scene, draw_geometry_with_errors(scene, ball_layout(scene)), gamma).C
    assert result.hertz_C == pytest.approx(expected, rel=1e-12)
    assert 1e-4 < relative(result.load, solved(with_ingredients(nominal, hertz="error-free")).load) < 0.02
    assert 1e-7 < relative(result.load, solved(nominal).load) < 1e-4  # radii are most of it, contact angles the rest
