"""Life by ISO 281 and ISO/TS 16281: rows of rollers against printed factors, formulas written out and laws of scaling, of
slices; balls in limits of ISO 281."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.axes import ROLLERS

import rollbench
from rollbench.lowfi import rollers
from rollbench.lowfi.rating import iso_lives, roller_life
from rollbench.lowfi.rating.life import basic_rating_life, damage_equivalent_loads, dynamic_rating

LEVEL = replace(ROLLERS, cup_angle=np.radians(15.0))
#: f_c of ISO 281 (radial roller bearings) by gamma = D cos(alpha)/D_pw.
FACTORS = {0.10: 84.2, 0.14: 87.7, 0.20: 88.7, 0.26: 86.4, 0.30: 83.8}


@pytest.mark.parametrize("gamma", FACTORS)
def test_rating_is_b_m_f_c_of_the_standard(gamma):
    def gamma_of(angle):
        row = replace(LEVEL, roller_angle=angle)
        return row.diameter * np.cos(row.cup_angle) / rollers.tapered_bearing_of_row(row).pitch_diameter

    row = replace(LEVEL, roller_angle=brentq(lambda angle: gamma_of(angle) - gamma, 1e-3, 0.12))
    size = (1e3 * row.length * np.cos(row.cup_angle)) ** (7 / 9) * row.count**0.75 * (1e3 * row.diameter) ** (29 / 27)
    assert roller_life.dynamic_rating_of_row(row) / (1.1 * size) == pytest.approx(FACTORS[gamma], rel=2e-3)


def test_L10_of_a_row_is_C_over_its_equivalent_load_and_knows_no_distribution():
    """own-taper: P = 0.4 F_r + 0.4 cot(16 deg) F_a, (C/P)^(10/3) = 2,810 million revolutions."""
    angles = {"cup_angle": np.radians(16.0), "roller_angle": np.radians(2.0)}
    row = replace(ROLLERS, count=21, diameter=9e-3, length=15e-3, **angles)
    forces = np.array([752.6, 0.0, 5067.0]), np.array([0.0, -752.6, -5067.0])
    one, two = (roller_life.life_of_row_by_equivalent_loads(row, [1.0], [k * forces[0]]) for k in (1.0, 2.0))
    assert one.rating == pytest.approx(79_798.95, rel=1e-6)
    assert one.equivalent_load == pytest.approx(0.4 * 752.6 + 0.4 / np.tan(np.radians(16.0)) * 5067.0)
    assert one.revolutions == pytest.approx(2810.0, rel=1e-3)
    assert one.revolutions / two.revolutions == pytest.approx(2.0 ** (10.0 / 3.0), rel=1e-12)
    assert (one.standard, two.raceways) == ("ISO 281", {})
    both = roller_life.life_of_row_by_equivalent_loads(row, [0.3, 0.7], forces)
    assert both.revolutions == pytest.approx(one.revolutions, rel=1e-12)
    assert roller_life.life_of_row_by_equivalent_loads(row, [1.0], [np.zeros(3)]) is None
    thrust = replace(row, cup_angle=np.radians(60.0), roller_angle=np.radians(3.0))
    assert roller_life.life_of_row_by_equivalent_loads(thrust, [1.0], forces[:1]).standard == "ISO 281 (thrust bearing)"


def life_of(line_loads, turning="inner"):
    """Millions of revolutions by ISO/TS 16281 under line loads [N/m] of the slices of all rollers."""
    return iso_lives.roller_reference_life(ROLLERS, line_loads, turning).revolutions


def test_cases_alike_live_as_each_and_shares_count():
    q = np.full((ROLLERS.count, 5), 1e5)
    alike = life_of(damage_equivalent_loads([q, q], [0.3, 0.7], roller_life.TURNING))
    mixed = life_of(damage_equivalent_loads([q, 0.0 * q], [0.5, 0.5], roller_life.TURNING))
    assert alike == pytest.approx(life_of(q))
    assert mixed / alike == pytest.approx(2.0, rel=1e-9), "means of order 4, life to the 4"


def test_the_ring_that_turns_meets_all_rollers_and_the_one_that_stands_its_most_loaded():
    """ISO/TS 16281: the mean is of order 4 on the turning race, of order 9/2 on the standing one, which it wears more."""
    q = 2e5 * np.outer(np.arange(ROLLERS.count) < ROLLERS.count / 2, np.ones(30))
    stress, races = iso_lives.edge_stress_factors(30), {}
    reduced = roller_life.race_capacities(ROLLERS) / 0.83
    for turning, orders in (("inner", (4.0, 4.5)), ("outer", (4.5, 4.0))):
        damage = 0.0
        for Q, order in zip(reduced, orders, strict=True):
            mean = stress * 2e5 * ROLLERS.length / 30 * 0.5 ** (1.0 / order)
            damage += ((mean / (Q * 30 ** (-7 / 9))) ** 4.5).sum()
        races[turning] = damage ** (-8 / 9)
        assert life_of(q, turning) == pytest.approx(races[turning], rel=1e-9)
    assert races["inner"] > 1.02 * races["outer"], "the inner race is the weaker one"
    assert iso_lives.roller_reference_life(ROLLERS, q, "none") is None


def test_equivalent_load_by_hand():
    e = 1.5 * np.tan(np.radians(15.0))
    assert roller_life.equivalent_load_of_row(LEVEL, 1000.0, 0.9 * e * 1000.0) == 1000.0
    assert roller_life.equivalent_load_of_row(LEVEL, 0.0, 1000.0) == pytest.approx(0.4 / np.tan(np.radians(15.0)) * 1000.0)


ROW = replace(LEVEL, roller_angle=np.radians(2.0))
RING = rollbench.read("external-masta-radial").sets[0].parts


def uneven(slices: int) -> np.ndarray:
    """Line loads [N/m] of half the rollers, more at their large ends."""
    share = np.maximum(np.cos(2.0 * np.pi * np.arange(ROW.count) / ROW.count), 0.0)
    return 1e5 * np.outer(share, 1.0 + 0.4 * rollers.slice_middles(2.0, slices))


def test_rollers_by_the_standards_formulas_written_out_lamina_by_lamina():
    """From C_r, with the standard's rounded 0.378, 0.364 and 1.038."""
    n, Z, q = 32, ROW.count, uneven(32) * ROW.length / 32
    C, alpha = roller_life.dynamic_rating_of_row(ROW), ROW.cup_angle
    g = ROW.diameter * np.cos(alpha) / rollers.tapered_bearing_of_row(ROW).pitch_diameter
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
    assert found.equivalent_load == pytest.approx(C * found.revolutions**-0.3)


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
    inner, outer = roller_life.race_capacities(row)
    C, Q = roller_life.dynamic_rating_of_row(row), 1e5 * row.length
    P = C * Q * (inner**-4.5 + outer**-4.5) ** (2.0 / 9.0)  # the load of ISO 281's rating for equally loaded rollers
    assert iso_lives.roller_reference_life(row, even).revolutions == pytest.approx((reduced * P / C) ** -4, rel=1e-9)


def test_few_slices_are_divided_and_a_profile_that_unloads_the_edges_makes_their_number_indifferent():
    even = [iso_lives.roller_reference_life(ROW, np.full((ROW.count, n), 1e5)).revolutions for n in (15, 30)]
    assert even[0] == even[1]
    bearing = rollers.tapered_bearing_of_row(ROW)
    lives = []
    for n in (40, 80, 160):
        q = rollers.TaperedRow(bearing, n, rollers.circular_crown_profile(2.0)).line_loads(8e-6 / np.sin(bearing.cup_angle))
        assert q[0] == q[-1] == 0.0
        lives.append(iso_lives.roller_reference_life(ROW, np.tile(q, (ROW.count, 1))).revolutions)
    assert np.ptp(lives) < 0.01 * lives[0]


def test_radial_load_without_clearance_has_the_life_of_ISO_281():
    """L = (C/F_r)^3: ISO 281's factors 0.407 and 0.389 are those of a load over half the circumference."""
    phi = 2.0 * np.pi * np.arange(4000) / 4000
    ring = replace(RING, balls=replace(RING.balls, azimuths=tuple(phi)))
    load = np.zeros((4000, 4))
    load[:, 0] = load[:, 3] = np.maximum(np.cos(phi), 0.0) ** 1.5
    force = float(load[:, 0] @ np.cos(phi))
    found = iso_lives.ball_reference_life(ring, basic_rating_life(ring, load))
    assert found.revolutions == pytest.approx((dynamic_rating(ring) / force) ** 3, rel=5e-3)
    assert found.equivalent_load == pytest.approx(force, rel=2e-3)


def test_axial_load_on_a_thrust_bearing_has_the_life_of_ISO_281():
    ring = replace(RING, track=replace(RING.track, contact_angle=np.radians(60.0)))
    load = np.zeros((ring.ball_count, 4))
    load[:, [0, 3]] = 100.0
    thrust = 100.0 * ring.ball_count * np.sin(np.radians(60.0))
    found = iso_lives.ball_reference_life(ring, basic_rating_life(ring, load))
    assert (found.revolutions, found.equivalent_load) == pytest.approx(
        ((dynamic_rating(ring) / thrust) ** 3, thrust), rel=1e-9
    )
    assert found.loads == pytest.approx({"SL": 100.0, "NR": 100.0})
    screw = rollbench.read("lin-case1")
    assert iso_lives.ball_reference_life(screw, basic_rating_life(screw, np.ones((32, 4)))) is None
