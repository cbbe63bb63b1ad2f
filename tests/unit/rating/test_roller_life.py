"""Ratings and life of rows of rollers: against ISO 281's printed factors, catalogue values, and laws of scaling."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.axes import ROLLERS

from rollbench.lowfi.rating import roller_life
from rollbench.lowfi.rollers import tapered_bearing_of_row

#: f_c of ISO 281 (radial roller bearings) by gamma = D cos(alpha)/D_pw.
FACTORS = {0.10: 84.2, 0.14: 87.7, 0.20: 88.7, 0.26: 86.4, 0.30: 83.8}


@pytest.mark.parametrize("gamma", FACTORS)
def test_rating_is_b_m_f_c_of_the_standard(gamma):
    def row_of(angle):
        return replace(ROLLERS, cup_angle=np.radians(15.0), roller_angle=angle)

    def gamma_of(row):
        return row.diameter * np.cos(row.cup_angle) / tapered_bearing_of_row(row).pitch_diameter

    row = row_of(brentq(lambda angle: gamma_of(row_of(angle)) - gamma, 1e-3, 0.12))
    assert gamma_of(row) == pytest.approx(gamma)
    size = (1e3 * row.length * np.cos(row.cup_angle)) ** (7 / 9) * row.count**0.75 * (1e3 * row.diameter) ** (29 / 27)
    assert roller_life.dynamic_rating_of_row(row) / (1.1 * size) == pytest.approx(FACTORS[gamma], rel=2e-3)


def test_life_falls_with_the_load_and_an_even_load_is_its_thrust_over_the_rating():
    row = replace(ROLLERS, cup_angle=np.radians(60.0), roller_angle=np.radians(3.0))
    q = np.full((row.count, 9), 1e5)
    one, two = (roller_life.basic_rating_life_of_row(row, k * q) for k in (1.0, 2.0))
    assert one.revolutions / two.revolutions == pytest.approx(2.0 ** (10.0 / 3.0), rel=1e-12)
    thrust = row.count * 1e5 * row.length * np.sin(row.cup_angle)
    assert one.revolutions == pytest.approx((roller_life.dynamic_rating_of_row(row) / thrust) ** (10.0 / 3.0), rel=1e-9)
    assert roller_life.basic_rating_life_of_row(row, 0.0 * q) is None


def test_life_does_not_depend_on_the_slices_of_an_even_load_and_an_uneven_one_lives_shorter():
    lives = [
        roller_life.basic_rating_life_of_row(ROLLERS, np.full((ROLLERS.count, n), 1e5)).revolutions for n in (1, 7, 30)
    ]
    assert lives == pytest.approx(lives[:1] * 3, rel=1e-12)
    tilted = 1e5 * (1.0 + 0.5 * np.linspace(-1.0, 1.0, 30)) * np.ones((ROLLERS.count, 1))
    assert roller_life.basic_rating_life_of_row(ROLLERS, tilted).revolutions < 0.9 * lives[0]
    half = 2e5 * np.outer(np.arange(ROLLERS.count) < ROLLERS.count / 2, np.ones(30))
    assert roller_life.basic_rating_life_of_row(ROLLERS, half).revolutions < lives[0]


def test_cases_alike_live_as_each_and_shares_count():
    q = np.full((ROLLERS.count, 5), 1e5)
    whole = roller_life.basic_rating_life_of_row(ROLLERS, q).revolutions
    assert roller_life.basic_rating_life_of_row(
        ROLLERS, roller_life.damage_equivalent_line_loads([q, q], [0.3, 0.7])
    ).revolutions == pytest.approx(whole)
    mixed = roller_life.basic_rating_life_of_row(
        ROLLERS, roller_life.damage_equivalent_line_loads([q, 0.0 * q], [0.5, 0.5])
    ).revolutions
    assert mixed / whole == pytest.approx(2.0 ** (10.0 / 12.0), rel=1e-9), "means of order 4, life to the 10/3"


def test_equivalent_load_by_hand():
    row = replace(ROLLERS, cup_angle=np.radians(15.0))
    e = 1.5 * np.tan(np.radians(15.0))
    assert roller_life.equivalent_load_of_row(row, 1000.0, 0.9 * e * 1000.0) == 1000.0
    assert roller_life.equivalent_load_of_row(row, 0.0, 1000.0) == pytest.approx(0.4 / np.tan(np.radians(15.0)) * 1000.0)
