"""Rib and friction torque of tapered rollers: closed forms, a balance of forces, work, and limits."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS

from rollbench.lowfi.bearings import tapered_roller
from rollbench.lowfi.bearings.torque import HYSTERESIS, film_rolling_resistance, hysteresis_torque, roller_bearing_torque
from rollbench.lowfi.rollers import tapered_bearing_of_row
from rollbench.meshes.parts import Lubricant

BEARING = tapered_bearing_of_row(ROLLERS)
APEX = BEARING.apex_distance + 0.5 * ROLLERS.length
RIB_HEIGHT = tapered_roller.rib_height(ROLLERS)
OIL = Lubricant(50e-6)


def torque_under(line_load, speed=100.0, oil=OIL, **changes):
    """Torque of the row whose rollers all carry one load per length [N/m]."""
    loads = np.full((ROLLERS.count, ROLLERS.slices), line_load)
    return roller_bearing_torque(replace(ROLLERS, **changes), loads, speed, oil)


def test_a_sphere_about_the_apex_fits_its_rib():
    near = tapered_roller.rib_relative_curvatures(BEARING, APEX * (1.0 - 1e-9), RIB_HEIGHT)
    assert abs(near[0] * APEX) < 1e-6


def test_pressure_is_that_of_hamrock_and_dowson_s_fits():
    """Their fits of the elliptic integrals (1977), within 3 per cent."""
    row = replace(ROLLERS, end_radius=0.7 * APEX)
    found = tapered_roller.rib_contact(row, np.full(row.count, 1000.0))
    along, across = tapered_roller.rib_relative_curvatures(BEARING, row.end_radius, RIB_HEIGHT)
    modulus = row.material.youngs_modulus / (1.0 - row.material.poissons_ratio**2)
    k, e = 1.0339 * (across / along) ** 0.636, 1.0003 + 0.5968 * along / across
    a = (6.0 * k**2 * e * found.load / (along + across) / np.pi / modulus) ** (1.0 / 3.0)
    assert found.pressure == pytest.approx(1.5 * found.load / (np.pi * a * a / k), rel=0.03)
    assert (found.a, found.b) == (pytest.approx(a, rel=0.03), pytest.approx(a / k, rel=0.03))


def test_load_of_the_rib_balances_the_roller_along_its_axis():
    """Normals of both races lean by gamma against the roller's axis, each pushes it with Q sin(gamma)."""
    found = tapered_roller.rib_contact(ROLLERS, np.array([10.0, 500.0, 20.0]))
    assert (found.roller, found.load) == (2, pytest.approx(1000.0 * np.sin(BEARING.roller_angle)))
    assert found.pressure is None
    assert tapered_roller.rib_contact(ROLLERS, np.zeros(3)) is None


@pytest.mark.parametrize("radius", [0.5 * APEX * np.sin(BEARING.roller_angle), 1.1 * APEX])
def test_a_sphere_that_does_not_reach_the_rib_or_fits_it_is_refused(radius):
    with pytest.raises(ValueError, match="mm"):
        tapered_roller.rib_relative_curvatures(BEARING, radius, RIB_HEIGHT)


def test_mean_distance_of_a_round_contact_about_its_middle():
    """int p r dA/F = 3 pi a/16 of a Hertzian circle about its own centre; the height where it is small."""
    for size, height, expected, within in ((1e-3, 0.0, 3e-3 * np.pi / 16.0, 1e-4), (1e-9, 2e-4, 2e-4, 1e-6)):
        found = tapered_roller.mean_distance_of_rib_pressure(np.array(size), np.array(size), height)
        assert float(found) == pytest.approx(expected, rel=within)


def test_rollers_roll_without_sliding():
    """Speeds of a roller against cone and cup, from which both races move alike at their contact lines."""
    on_cone, on_cup = tapered_roller.roller_speed_ratios(BEARING)
    assert on_cone * np.sin(BEARING.cone_angle) == pytest.approx(on_cup * np.sin(BEARING.cup_angle))


def test_torque_is_the_work_of_its_parts_and_grows_with_the_coefficient():
    q = np.full((ROLLERS.count, ROLLERS.slices), 1e5)
    one, two = (torque_under(1e5, oil=None, rib_friction=mu) for mu in (0.05, 0.1))
    assert two.rib == pytest.approx(2.0 * one.rib)
    assert one.torque == pytest.approx(one.rib + one.hysteresis)
    assert (one.film, one.low, torque_under(0.0, oil=None)) == (None, None, None)
    force = q.mean(axis=1).sum() * ROLLERS.length
    on_rib = 2.0 * np.sin(BEARING.roller_angle) * force
    assert one.rib == pytest.approx(0.05 * on_rib * RIB_HEIGHT * tapered_roller.roller_speed_ratios(BEARING)[0], rel=1e-9)
    assert HYSTERESIS * 2e-3 < hysteresis_torque(BEARING, q) / (force * ROLLERS.diameter) < 1.0 * HYSTERESIS


def test_film_grows_with_speed_and_viscosity_by_the_law_of_its_regime():
    slow, quick, back = (torque_under(1e5, speed) for speed in (50.0, 100.0, -100.0))
    assert quick.film / slow.film == pytest.approx(2.0**0.658, rel=1e-9)
    thin, thick = (film_rolling_resistance(1e5, 2.0, 0.01, oil, 2.3e11) for oil in (OIL, Lubricant(100e-6)))
    assert thick == pytest.approx(2.0**0.658 * thin)
    assert back.torque == pytest.approx(quick.torque)


def test_both_formulations_agree_in_size_on_a_running_row():
    """Work in the contacts and Timken's empirical formula, for thrust alone, within a factor of three."""
    found = torque_under(5e4, torque_factor=40.0, rib_friction=0.03)
    assert 1.0 / 3.0 < found.torque / found.timken < 3.0
