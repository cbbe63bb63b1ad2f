"""Friction torque: units, powers, and the equality of two forms of Palmgren's formula."""

import numpy as np
import pytest

from rollbench.compare.cases.makers.bearings import single_row_bearing_scene
from rollbench.compare.scenes.makers import read_maker_tables
from rollbench.lowfi.bearings import torque
from rollbench.lowfi.rating.contacts import permissible_contact_force

RPM = np.pi / 30.0
INCH_POUND = 0.0254 * 4.4482216152605


def test_viscous_torque_in_its_own_units():
    """1e-8 kg f (nu n)^(2/3) d^3 in mm, counted by hand for 27000 mm^2/s rpm, whose power 2/3 is 900."""
    found = torque.load_independent_torque(2.0, 50e-3, 27e-6, 1000.0 * RPM)
    assert found == pytest.approx(1e-8 * 2.0 * 900.0 * 125000.0 * 9.80665e-3, rel=1e-12)


@pytest.mark.parametrize(("nu", "rpm"), [(40e-6, 10.0), (40e-6, 50.0), (40e-6, -3000.0), (500e-6, 8000.0)])
def test_viscous_torque_is_that_of_skf_s_and_of_a_program_s_form(nu, rpm):
    """SKF: 1e-7 f (nu n)^(2/3) d^3 N mm, and 160e-7 f d^3 below 2000 mm2/s rpm. the program Thermca (`bearing.heat_loss`,
    by Jungnickel): 36008 f r^3 (nu omega)^0.666 N m."""
    d, f, film = 62e-3, 3.3, nu * 1e6 * abs(rpm)
    skf = 1e-7 * f * max(film ** (2 / 3), 160.0 * (film < 2000.0)) * (1e3 * d) ** 3
    found = torque.load_independent_torque(f, d, nu, rpm * RPM)
    assert 1e3 * found == pytest.approx(skf, rel=0.03)
    if film >= 2000.0:
        assert found == pytest.approx(36008.0 * f * (0.5 * d) ** 3 * (nu * abs(rpm) * RPM) ** 0.666, rel=0.03)


def test_rows_of_balls_take_lowest_to_highest_coefficients():
    """By hand: 1 kN on a row whose largest contact is at an eighth of its rating, 50 mm: z 0.5 1 kN 50 mm."""
    loads = (1000.0, 0.0, 0.125)
    of_60 = torque.ball_bearing_torque("angular contact", np.radians(60.0), 50e-3, loads, (0.01, 0.02))
    assert of_60.load == pytest.approx((0.0008 * 25.0, 0.0013 * 25.0))
    assert of_60.starting == pytest.approx((0.0016 * 25.0, 0.0026 * 25.0))
    assert of_60.running == pytest.approx((0.01 + 0.0008 * 25.0, 0.02 + 0.0013 * 25.0))
    of_40 = torque.ball_bearing_torque("angular contact", np.radians(40.0), 50e-3, loads, None)
    assert (of_40.load[0], of_40.running) == (pytest.approx(0.0010 * 25.0), None)
    radial = torque.ball_bearing_torque("deep groove", np.radians(9.0), 50e-3, (0.0, 1000.0, 0.125), None)
    assert radial.load == pytest.approx((0.0004 * 0.125**0.55 * 50.0, 0.0009 * 0.125**0.55 * 50.0))


@pytest.mark.parametrize(
    ("size", "balls", "ball", "pitch"), [("30TAC62B", 17, 7.144e-3, 46e-3), ("35TAC72B", 18, 8.731e-3, 55e-3)]
)
def test_starting_torques_that_nsk_prints_lie_in_the_range(size, balls, ball, pitch):
    """Of pairs at their preload, halved; balls of 30TAC62B as the template assumes them, of 35TAC72B those of Fafnir's
    bearing of the same bore, outside diameter and width."""
    printed = [
        (table.parse_number(row["preload_N"]), table.parse_number(row["starting_torque_N_m"]))
        for table in read_maker_tables("nsk-tac")
        for row in table.rows
        if row["bearing"] == size and row["arrangement"].startswith("DB or")
    ]
    assert printed
    for preload, pair in printed:
        rated = permissible_contact_force(single_row_bearing_scene(balls, ball, pitch, np.radians(60.0)))
        loads = preload, 0.0, preload / (balls * np.sin(np.radians(60.0)) * rated)
        low, high = torque.ball_bearing_torque("angular contact", np.radians(60.0), pitch, loads, None).starting
        assert low < 0.5 * pair < high


def test_both_forms_agree_with_the_exponent_two_thirds_only():
    """2.31: f p d^3 (eta omega/p)^x in kg, mm, s, p one atmosphere, oil of 900 kg/m3, against 2.32."""
    nu, n, dm = 27.0, 1450.0, 55.086
    atmosphere = 101325.0 / torque.KILOGRAM_FORCE * 1e-6
    eta = nu * 1e-6 * 900.0 / torque.KILOGRAM_FORCE * 1e-6

    def pressure_form(x):
        return 2.0 * atmosphere * dm**3 * (eta * n * RPM / atmosphere) ** x * torque.KILOGRAM_FORCE * 1e-3

    ours = torque.load_independent_torque(2.0, dm * 1e-3, nu * 1e-6, n * RPM)
    assert pressure_form(2.0 / 3.0) == pytest.approx(ours, rel=0.03)
    assert pressure_form(1.5) < 1e-3 * ours


def test_static_rating_and_load_torque():
    across, along = 1.0 / 0.1, 1.0 / 4e-3
    c = torque.palmgren_static_rating(2, 18, 8e-3, np.radians(60.0), across, along)
    k = 2.8 / (8.0 * np.sqrt(across * along) * 1e-3)  # kg/mm^2
    assert c == pytest.approx(k * 2 * 18 * np.sin(np.radians(60.0)) * 64.0 * torque.KILOGRAM_FORCE, rel=1e-12)
    t = torque.load_dependent_torque(4e3, 1e3, 55e-3, c)
    assert t.equivalent_load == pytest.approx(0.5 * 1e3 + 0.3 * 4e3)
    assert t.factor == pytest.approx(0.0013 * (t.equivalent_load / c) ** (1 / 3))
    assert t.torque == pytest.approx(t.factor * 4e3 * 55e-3)
    low, high = (torque.load_dependent_torque(load, 0.0, 55e-3, c).torque for load in (1e3, 8e3))
    assert high / low == pytest.approx(16.0), "without radial load it grows with the 4/3 power"


def test_taper_torque_in_its_own_units():
    """1000 rpm, 10 cP, 1000 lb, G_1 = 100: 3.54e-3 (1e4)^0.62 1000^0.3 in-lb."""
    state = 10e-3, 1000.0 * RPM, 1000.0 * 4.4482216152605
    found = torque.timken_running_torque(100.0, *state)
    assert found / INCH_POUND == pytest.approx(3.54e-3 * 1e4**0.62 * 1000.0**0.3, rel=1e-12)
    assert torque.timken_factor_from_torque(found, *state) == pytest.approx(100.0, rel=1e-12)
