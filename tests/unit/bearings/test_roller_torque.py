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
OIL = Lubricant(50e-6)


def test_a_sphere_about_the_apex_fits_its_rib():
    near = tapered_roller.rib_contact_geometry(BEARING, APEX * (1.0 - 1e-9), tapered_roller.rib_height(ROLLERS))
    assert abs(near.relative_curvatures[0] * APEX) < 1e-6


def test_pressure_is_that_of_hamrock_and_dowson_s_fits():
    """Their fits of the elliptic integrals (1977), within 3 per cent."""
    row = replace(ROLLERS, end_radius=0.7 * APEX)
    found = tapered_roller.rib_contact(row, np.full(row.count, 1000.0))
    along, across = tapered_roller.rib_contact_geometry(
        BEARING, row.end_radius, tapered_roller.rib_height(row)
    ).relative_curvatures
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


@pytest.mark.parametrize("radius", [0.5, 1.1])
def test_a_sphere_that_does_not_reach_the_rib_or_fits_it_is_refused(radius):
    wrong = {0.5: 0.5 * APEX * np.sin(BEARING.roller_angle), 1.1: 1.1 * APEX}[radius]
    with pytest.raises(ValueError, match="mm"):
        tapered_roller.rib_contact_geometry(BEARING, wrong, tapered_roller.rib_height(ROLLERS))


def test_mean_distance_of_a_round_contact_about_its_middle():
    """int p r dA/F = 3 pi a/16 of a Hertzian circle about its own centre; the height where it is small."""
    assert float(tapered_roller.mean_distance_of_rib_pressure(np.array(1e-3), np.array(1e-3), 0.0)) == pytest.approx(
        3e-3 * np.pi / 16.0, rel=1e-4
    )
    assert float(tapered_roller.mean_distance_of_rib_pressure(np.array(1e-9), np.array(1e-9), 2e-4)) == pytest.approx(
        2e-4, rel=1e-6
    )


def test_rollers_roll_without_sliding():
    """Speeds of a roller against cone and cup, from which both races move alike at their contact lines."""
    on_cone, on_cup = tapered_roller.roller_speed_ratios(BEARING)
    assert on_cone * np.sin(BEARING.cone_angle) == pytest.approx(on_cup * np.sin(BEARING.cup_angle))


def test_torque_is_the_work_of_its_parts_and_grows_with_the_coefficient():
    q = np.full((ROLLERS.count, ROLLERS.slices), 1e5)
    one, two = (roller_bearing_torque(replace(ROLLERS, rib_friction=mu), q, 100.0, None) for mu in (0.05, 0.1))
    assert two.rib == pytest.approx(2.0 * one.rib)
    assert one.torque == pytest.approx(one.rib + one.hysteresis)
    assert (one.film, one.low, roller_bearing_torque(ROLLERS, 0.0 * q, 100.0, None)) == (None, None, None)
    force = q.mean(axis=1) * ROLLERS.length
    work = (
        0.05
        * 2.0
        * np.sin(BEARING.roller_angle)
        * force.sum()
        * tapered_roller.rib_height(ROLLERS)
        * tapered_roller.roller_speed_ratios(BEARING)[0]
    )
    assert one.rib == pytest.approx(work, rel=1e-9)
    assert HYSTERESIS * 2e-3 < hysteresis_torque(BEARING, q) / (force.sum() * ROLLERS.diameter) < 1.0 * HYSTERESIS


def test_film_grows_with_speed_and_viscosity_by_the_law_of_its_regime():
    q = np.full((ROLLERS.count, ROLLERS.slices), 1e5)
    films = [roller_bearing_torque(ROLLERS, q, speed, OIL).film for speed in (50.0, 100.0)]
    assert films[1] / films[0] == pytest.approx(2.0**0.658, rel=1e-9)
    assert film_rolling_resistance(1e5, 2.0, 0.01, Lubricant(100e-6), 2.3e11) == pytest.approx(
        2.0**0.658 * film_rolling_resistance(1e5, 2.0, 0.01, OIL, 2.3e11)
    )
    assert roller_bearing_torque(ROLLERS, q, -100.0, OIL).torque == pytest.approx(
        roller_bearing_torque(ROLLERS, q, 100.0, OIL).torque
    )


def test_both_formulations_agree_in_size_on_a_running_row():
    """Work in the contacts and Timken's empirical formula, for thrust alone, within a factor of three."""
    q = np.full((ROLLERS.count, ROLLERS.slices), 5e4)
    found = roller_bearing_torque(replace(ROLLERS, torque_factor=40.0, rib_friction=0.03), q, 100.0, OIL)
    assert 1.0 / 3.0 < found.torque / found.timken < 3.0
