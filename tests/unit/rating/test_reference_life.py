"""Life by ISO/TS 16281: of equal loads, of the standard's formulas written out, of slices; balls in limits of ISO 281."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
from tests.axes import ROLLERS

import rollbench
from rollbench.lowfi import rollers as lowfi_rollers
from rollbench.lowfi.rating import iso_lives, roller_life
from rollbench.lowfi.rating.life import basic_rating_life, dynamic_rating

ROW = replace(ROLLERS, cup_angle=np.radians(15.0), roller_angle=np.radians(2.0))


def uneven(slices: int) -> np.ndarray:
    """Line loads [N/m] of half the rollers, more at their large ends."""
    rollers = np.maximum(np.cos(2.0 * np.pi * np.arange(ROW.count) / ROW.count), 0.0)
    return 1e5 * np.outer(rollers, 1.0 + 0.4 * lowfi_rollers.slice_middles(2.0, slices))


def test_rollers_by_the_standards_formulas_written_out_lamina_by_lamina():
    """From C_r, with the standard's rounded 0.378, 0.364 and 1.038."""
    n, Z, q = 32, ROW.count, uneven(32) * ROW.length / 32
    C, alpha = roller_life.dynamic_rating_of_row(ROW), ROW.cup_angle
    g = ROW.diameter * np.cos(alpha) / lowfi_rollers.tapered_bearing_of_row(ROW).pitch_diameter
    ratio = 1.038 * ((1 - g) / (1 + g)) ** (143 / 108)
    Q_ci = C / (0.83 * 0.378 * Z * np.cos(alpha)) * (1 + ratio ** (9 / 2)) ** (2 / 9)
    Q_ce = C / (0.83 * 0.364 * Z * np.cos(alpha)) * (1 + ratio ** (-9 / 2)) ** (2 / 9)
    total = 0.0
    for k in range(1, n + 1):
        f = 1 - 0.01 / log(1.985 * abs((2 * k - n - 1) / (2 * n - 2)))
        q_ei = (sum((f * q[j, k - 1]) ** 4 for j in range(Z)) / Z) ** (1 / 4)
        q_ee = (sum((f * q[j, k - 1]) ** 4.5 for j in range(Z)) / Z) ** (1 / 4.5)
        total += (Q_ci * n ** (-7 / 9) / q_ei) ** (-9 / 2) + (Q_ce * n ** (-7 / 9) / q_ee) ** (-9 / 2)
    found = iso_lives.roller_reference_life(ROW, uneven(n))
    assert found.revolutions == pytest.approx(total ** (-8 / 9), rel=2e-2), "the fourth power of the rounded factors"
    assert found.capacities["inner"] == pytest.approx(Q_ci, rel=4e-3)
    assert found.capacities["outer"] == pytest.approx(Q_ce, rel=4e-3)
    assert found.equivalent == pytest.approx(C * found.revolutions**-0.3)


def test_life_of_rollers_falls_with_the_fourth_power_of_the_load():
    lives = [iso_lives.roller_reference_life(ROW, k * uneven(30)).revolutions for k in (1.0, 2.0)]
    assert lives[0] / lives[1] == pytest.approx(16.0, rel=1e-12)
    assert iso_lives.roller_reference_life(ROW, 0.0 * uneven(30)) is None


@pytest.mark.parametrize(("angle", "reduced"), [(15.0, 0.83), (60.0, 0.73)])
def test_without_the_edges_an_even_load_has_ISO_281s_load_times_the_reduction(monkeypatch, angle, reduced):
    """L = (lambda P/C)^-4: what ISO 281 takes off the capacity for ends and uneven loads is not taken off twice."""
    monkeypatch.setattr(iso_lives, "edge_stress_factors", np.ones)
    row = replace(ROW, cup_angle=np.radians(angle))
    even = np.full((row.count, 15), 1e5)
    P, C = roller_life.basic_rating_life_of_row(row, even).equivalent, roller_life.dynamic_rating_of_row(row)
    assert iso_lives.roller_reference_life(row, even).revolutions == pytest.approx((reduced * P / C) ** -4, rel=1e-9)


def test_few_slices_are_divided_and_a_profile_that_unloads_the_edges_makes_their_number_indifferent():
    even = [iso_lives.roller_reference_life(ROW, np.full((ROW.count, n), 1e5)).revolutions for n in (15, 30)]
    assert even[0] == even[1]
    bearing = lowfi_rollers.tapered_bearing_of_row(ROW)
    lives = []
    for n in (40, 80, 160):
        roller = lowfi_rollers.slice_roller(bearing, n, lowfi_rollers.circular_crown_profile(2.0))
        q = lowfi_rollers.sliced_roller_state_at_approach(roller, 8e-6).line_loads
        assert q[0] == q[-1] == 0.0
        lives.append(iso_lives.roller_reference_life(ROW, np.tile(q, (ROW.count, 1))).revolutions)
    assert np.ptp(lives) < 0.01 * lives[0]


def test_tilted_rollers_live_shorter_than_straight_ones():
    level = iso_lives.roller_reference_life(ROW, np.full((ROW.count, 30), 1e5)).revolutions
    tilted = iso_lives.roller_reference_life(
        ROW, np.full((ROW.count, 1), 1e5) * (1.0 + 0.4 * lowfi_rollers.slice_middles(2.0, 30))
    ).revolutions
    assert tilted < 0.9 * level


def test_radial_load_without_clearance_has_the_life_of_ISO_281():
    """L = (C/F_r)^3: ISO 281's factors 0.407 and 0.389 are those of a load over half the circumference."""
    ring = rollbench.read("external-masta-radial").sets[0].parts
    many = 4000
    phi = 2.0 * np.pi * np.arange(many) / many
    ring = replace(ring, balls=replace(ring.balls, azimuths=tuple(phi)))
    load = np.zeros((many, 4))
    load[:, 0] = load[:, 3] = np.maximum(np.cos(phi), 0.0) ** 1.5
    force = float(load[:, 0] @ np.cos(phi))
    found = iso_lives.ball_reference_life(ring, basic_rating_life(ring, load))
    assert found.revolutions == pytest.approx((dynamic_rating(ring) / force) ** 3, rel=5e-3)
    assert found.equivalent == pytest.approx(force, rel=2e-3)


def test_axial_load_on_a_thrust_bearing_has_the_life_of_ISO_281():
    ring = rollbench.read("external-masta-radial").sets[0].parts
    ring = replace(ring, track=replace(ring.track, contact_angle=np.radians(60.0)))
    load = np.zeros((ring.ball_count, 4))
    load[:, [0, 3]] = 100.0
    thrust = 100.0 * ring.ball_count * np.sin(np.radians(60.0))
    found = iso_lives.ball_reference_life(ring, basic_rating_life(ring, load))
    assert (found.revolutions, found.equivalent) == pytest.approx(((dynamic_rating(ring) / thrust) ** 3, thrust), rel=1e-9)
    assert found.loads == pytest.approx({"SL": 100.0, "NR": 100.0})
    assert (
        iso_lives.ball_reference_life(
            rollbench.read("lin-case1"), basic_rating_life(rollbench.read("lin-case1"), np.ones((32, 4)))
        )
        is None
    )
