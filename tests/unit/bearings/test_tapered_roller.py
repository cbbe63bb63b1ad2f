"""Tapered roller bearing: load zone, geometry on one apex, balance with the rib, combined load, slices."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import beta, gamma
from tests.tapered_row_oracle import solve_by_smith_load_zone, solve_thrust_and_radial_equilibrium

from rollbench.lowfi import rollers
from rollbench.lowfi.bearings.axis import equal_rows_with_preload, solve_bearing_row_equilibrium
from rollbench.lowfi.bearings.tapered_roller import load_zone_integrals
from rollbench.lowfi.hertz import contact_modulus

B = rollers.TaperedBearing(16, 8.38e-3, 12.4e-3, np.radians(30.8), np.radians(4.0), 207e9, 0.3, 5e-3)
ROW, THRUST = rollers.TaperedRow(B), 9e3

# --- load zone


@pytest.mark.parametrize("exponent", [1.0, 1.1, 1.5])
@pytest.mark.parametrize("eps", [0.02, 0.3, 0.4999, 0.6, 3.0])
def test_load_zone_against_plain_quadrature(eps, exponent):
    z = load_zone_integrals(eps, exponent)

    def share(psi):
        return max(1.0 - 0.5 / eps * (1.0 - np.cos(psi)), 0.0) ** exponent

    ends = {"epsabs": 1e-13, "limit": 400}
    assert z.thrust_integral == pytest.approx(quad(share, 0.0, z.half_angle, **ends)[0] / np.pi, rel=1e-9)
    radial = quad(lambda p: share(p) * np.cos(p), 0.0, z.half_angle, **ends)[0] / np.pi
    assert z.radial_integral == pytest.approx(radial, rel=1e-9)


@pytest.mark.parametrize("n", [1.0, 1.1, 10.0 / 9.0, 1.5])
def test_half_full_and_even_zone_in_closed_form(n):
    """eps = 1/2: the bracket is cos(psi) over half the circumference, J_a = B((n+1)/2, 1/2)/2 pi, J_r with n + 1.
    eps = 1: the bracket is cos^2(psi/2), so J_a = Gamma(n + 1/2)/(sqrt(pi) Gamma(n + 1)), J_r = J_a n/(n + 1).
    Nearly pure thrust: J_r = n w/2, w = 1/(2 eps)."""
    half, full, near, even = (load_zone_integrals(eps, n) for eps in (0.5, 1.0, 1e9, np.inf))
    assert half.thrust_integral == pytest.approx(beta((n + 1) / 2, 0.5) / (2 * np.pi), rel=1e-12)
    assert half.radial_integral == pytest.approx(beta((n + 2) / 2, 0.5) / (2 * np.pi), rel=1e-12)
    assert full.thrust_integral == pytest.approx(gamma(n + 0.5) / (np.sqrt(np.pi) * gamma(n + 1)), rel=1e-12)
    assert full.radial_integral / full.thrust_integral == pytest.approx(n / (n + 1), rel=1e-12)
    assert near.radial_integral == pytest.approx(n / 4e9, rel=1e-8)
    assert (even.thrust_integral, even.radial_integral, even.half_angle) == (1.0, 0.0, np.pi)


# --- one roller


def test_cones_share_one_apex():
    """Radii of curvature by finite geometry: distance from the axis over the cosine of the cone's angle."""
    for along in (-6e-3, 0.0, 6e-3):
        reach = B.apex_distance + along
        for radius, angle in zip(B.curvature_radii(along), (B.roller_angle, B.cone_angle, B.cup_angle), strict=True):
            assert float(radius) == pytest.approx(reach * np.sin(angle) / np.cos(angle), rel=1e-14)
    assert 2.0 * B.apex_distance * np.sin(B.roller_angle) == pytest.approx(B.diameter)
    axis_radius = B.apex_distance * np.cos(B.roller_angle) * np.sin(B.cup_angle - B.roller_angle)
    assert B.pitch_diameter == pytest.approx(2.0 * axis_radius, rel=1e-14)


def test_balance_of_the_roller_with_its_rib():
    """Forces on the roller in an axial plane: cup, cone, rib; and thrust on the cone from race and rib together."""
    q = 1000.0
    rib = 2.0 * q * np.sin(B.roller_angle)
    cup = -q * np.array([np.sin(B.cup_angle), np.cos(B.cup_angle)])  # (axial, radial)
    cone = q * np.array([np.sin(B.cone_angle), np.cos(B.cone_angle)])
    along = B.cup_angle - B.roller_angle
    push = rib * np.array([np.cos(along), -np.sin(along)])
    np.testing.assert_allclose(cup + cone + push, 0.0, atol=1e-9)
    assert cone[0] + push[0] == pytest.approx(q * np.sin(B.cup_angle), rel=1e-12)


def test_contacts_are_hertz_lines():
    widths, pressures = (x[0] for x in rollers.half_widths_and_pressures_of_slices(B, np.array([1100.0 / B.length])))
    roller, cone, cup = (float(r) for r in B.curvature_radii())
    modulus = contact_modulus(207e9, 0.3, 207e9, 0.3)
    for i, k in enumerate((1 / roller + 1 / cone, 1 / roller - 1 / cup)):
        b = np.sqrt(4 * 1100.0 / B.length / (np.pi * modulus * k))
        assert widths[i] == pytest.approx(b, rel=1e-14)
        assert 0.5 * np.pi * b * pressures[i] * B.length == pytest.approx(1100.0, rel=1e-12)


def test_row_under_thrust_and_a_preloaded_pair():
    """The pair is nearly straight, so its stiffness is twice that of a row and stays within 2 % up to half the lift-off."""
    u = ROW.deflection(THRUST)
    assert ROW.thrust(u) == pytest.approx(THRUST, rel=1e-12)
    h = 1e-5 * u
    assert ROW.stiffness(u) == pytest.approx((ROW.thrust(u + h) - ROW.thrust(u - h)) / (2 * h), rel=1e-7)
    assert ROW.thrust(-1e-6) == ROW.stiffness(0.0) == ROW.deflection(0.0) == 0.0
    pair = equal_rows_with_preload(ROW, (1, -1), 6e3)
    k = [solve_bearing_row_equilibrium(pair, f).stiffness for f in (0.0, 3e3, 6e3)]
    assert k[0] == pytest.approx(2.0 * ROW.stiffness(ROW.deflection(6e3)), rel=1e-9)
    assert max(k) / min(k) < 1.02


# --- combined load


def test_pure_thrust_is_the_row():
    s, zone = solve_thrust_and_radial_equilibrium(B, THRUST, 0.0), solve_by_smith_load_zone(B, THRUST, 0.0)
    assert s.axial_displacement == pytest.approx(ROW.deflection(THRUST), rel=1e-10)
    assert s.radial_displacement == pytest.approx(0.0, abs=1e-15)
    assert zone.axial_displacement == pytest.approx(s.axial_displacement, rel=1e-12)


@pytest.mark.parametrize("count", [16, 64])
@pytest.mark.parametrize("radial", [1e3, 4e3, 9e3])
def test_load_zone_integrals_meet_the_rollers(radial, count):
    """The source's route with exponent 1.1: greatest load within 1 %, deflections within 3 %, for many rollers too."""
    b = replace(B, rollers=count)
    s, z = (f(b, THRUST, radial) for f in (solve_thrust_and_radial_equilibrium, solve_by_smith_load_zone))
    assert z.largest_roller_load == pytest.approx(s.roller_loads.max(), rel=0.01)
    assert z.axial_displacement == pytest.approx(s.axial_displacement, rel=0.03)
    assert z.radial_displacement == pytest.approx(s.radial_displacement, rel=0.03)


# --- slices


@pytest.mark.parametrize("slices", [1, 2, 7, 40])
def test_plain_roller_is_a_line_contact_for_any_number_of_slices(slices):
    row, law, sine = rollers.TaperedRow(B, slices), B.approach_law(), np.sin(B.cup_angle)
    thrust, u = 1100.0 * B.rollers * sine, float(law.approach(1100.0 / B.length)) / sine
    assert row.thrust(u) == pytest.approx(thrust, rel=1e-12)
    assert row.deflection(thrust) == pytest.approx(u, rel=1e-12)
    stiffness = B.rollers * B.length * float(law.stiffness_per_length(1100.0 / B.length)) * sine**2
    assert row.stiffness(u) == pytest.approx(stiffness, rel=1e-12)


def test_a_roller_on_one_apex_is_loaded_evenly():
    """All radii grow with the distance from the apex, and the law of the pair of contacts stays the same."""
    g = B.approach_law(np.linspace(-6e-3, 6e-3, 5)).g
    np.testing.assert_allclose(g, float(B.approach_law().g), rtol=1e-13)


def test_slices_converge_with_second_order():
    """Fully loaded crowned roller: the midpoint rule of a smooth load, so halving the slices cuts the error by four."""
    law, half, crown = B.approach_law(), 0.5 * B.length, rollers.circular_crown_profile(20.0)
    exact = quad(lambda x: float(law.line_load(2e-5 - x**2 / 20.0)), -half, half, epsrel=1e-12)[0]
    u, rows = 2e-5 / np.sin(B.cup_angle), [rollers.TaperedRow(B, n, crown) for n in (10, 20, 40)]
    off = [B.length * row.line_loads(u).mean() - exact for row in rows]
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.02)
    assert off[1] / off[2] == pytest.approx(4.0, rel=0.01)
    assert abs(off[2]) < 1e-4 * exact


# --- refusals
