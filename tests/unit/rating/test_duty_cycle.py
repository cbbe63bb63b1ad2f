"""Life over several load cases: damage by place, and the equivalent loads of the standards; several sets
together."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.rating import life
from rollbench.lowfi.rating.life import SLOPE, life_of_parts_in_series
from rollbench.meshes.parts import Errors, Load

SCREW = replace(catalogue.scene("lin-case1"), friction=None)
RNG = np.random.default_rng(41)


def loads(*columns: int) -> np.ndarray:
    out = np.zeros((SCREW.ball_count, 4))
    out[:, columns] = RNG.uniform(50.0, 400.0, (SCREW.ball_count, len(columns)))
    return out


def life_of(cases: list[np.ndarray], shares: list[float]) -> life.Life:
    """The screw's life under contact loads of several cases."""
    return life.basic_rating_life(SCREW, life.damage_equivalent_loads(cases, shares))


def test_one_case_is_the_life_of_its_loads_to_the_last_digit() -> None:
    load = loads(0, 3)
    alone = life.basic_rating_life(SCREW, load)
    assert life_of([load], [1.0]) == alone
    assert life_of([0.0 * load], [1.0]) is None
    assert life_of([load, 9.0 * load], [1.0, 0.0]) == alone, "a static check wears nothing"
    assert life_of([load, load], [0.3, 0.7]).revolutions == pytest.approx(alone.revolutions, rel=1e-12)


def test_damage_adds_up_place_by_place() -> None:
    """Against Miner's rule and the product of survivals, place by place of the nut and all over the screw."""
    cases, shares = [loads(0, 3), loads(0, 1, 2, 3), loads(1, 2)], np.array([0.2, 0.5, 0.3])
    capacity, wear = life.contact_capacity(SCREW), 0.0
    for s in range(4):
        damage = sum(n * (load[:, s] / capacity[s]) ** 3 for n, load in zip(shares, cases, strict=True))
        places = damage if s > 1 else np.full_like(damage, damage.mean())
        wear += float(np.mean(places ** (10.0 / 9.0)))
    assert life_of(cases, list(shares)).revolutions == pytest.approx(wear**-0.9, rel=1e-12)


def test_a_nut_whose_places_take_turns_lives_longer_than_one_whose_places_do_not() -> None:
    first, second = np.zeros((2, SCREW.ball_count, 4))
    first[:16, 3], second[16:, 3] = 300.0, 300.0
    apart, same = (life_of([first, other], [0.5, 0.5]) for other in (second, first))
    assert apart.revolutions > 1.05 * same.revolutions


def standard(forces: list[float], shares: list[float], preload: float = 0.0, **fields: object):
    """Life under axial forces by the equivalent loads of ISO 3408-5."""
    axial = [(0.0, 0.0, force) for force in forces]
    scenes = [replace(SCREW, loads=(Load(0.0, force),), **fields) for force in axial]
    return life.life_by_equivalent_loads(scenes, shares, list(map(np.array, axial)), preload)


def test_equivalent_load_of_a_nut_with_play() -> None:
    C = life.dynamic_rating(SCREW)
    one = standard([2000.0], [1.0])
    assert one.revolutions == pytest.approx((C / 2000.0) ** 3, rel=1e-12)
    two = standard([2000.0, 4000.0], [0.75, 0.25])
    assert two.equivalent_loads == pytest.approx(((0.75 * 2000.0**3 + 0.25 * 4000.0**3) ** (1 / 3), 0.0))
    both = standard([2000.0, -2000.0], [0.5, 0.5])
    assert both.revolutions == pytest.approx(2.0 * 2.0**-0.9 * one.revolutions), "two pairs of flanks, half the damage each"


def test_equal_contacts_in_every_case_agree_with_the_equivalent_load() -> None:
    even = np.zeros((SCREW.ball_count, 4))
    even[:, [0, 3]] = 1.0
    force = life.basic_rating_life(SCREW, even).equivalent_load  # along the axis, of contacts of 1 N
    found = life_of([100.0 * even, 250.0 * even], [0.6, 0.4])
    by_standard = standard([100.0 * force, 250.0 * force], [0.6, 0.4])
    assert found.revolutions == pytest.approx(by_standard.revolutions, rel=1e-10)


def test_halves_part_at_the_lift_off_load_and_have_the_rating_of_their_turns() -> None:
    force = np.array([0.0, life.PARTING * 1000.0, -500.0, 5000.0])
    along, against = life.forces_on_nut_halves(force, 1000.0)
    assert along - against == pytest.approx(force)
    assert (along[0], against[1], along[3], against[3]) == pytest.approx((1000.0, 0.0, 5000.0, 0.0))
    assert against[2] == pytest.approx(1000.0 * (1.0 + 500.0 / 2828.427125) ** 1.5)
    alone = standard([0.0], [1.0], preload=1000.0, errors=Errors(lead_offset=10e-6))
    C = life.dynamic_rating(SCREW) * 0.5**0.86  # that of half the turns
    assert alone.revolutions == pytest.approx(2.0**-0.9 * (C / 1000.0) ** 3, rel=1e-9)


UNKNOWN = [
    ({"loads": (Load(0.0, (0.0, 10.0, 1e3)),)}, "radial force"),
    ({"loads": (Load(0.0, (0.0, 0.0, 1e3), (1.0, 0.0, 0.0)),)}, "moments"),
    ({"errors": replace(SCREW.errors, balls=replace(SCREW.errors.balls, oversize=1e-6))}, "four-point"),
]


@pytest.mark.parametrize(("fields", "said"), UNKNOWN)
def test_the_standard_says_what_it_does_not_know(fields: dict, said: str) -> None:
    with pytest.raises(ValueError, match=f"ISO 3408-5 does not cover.*{said}"):
        life.life_by_equivalent_loads([replace(SCREW, **fields)], [1.0], [np.array([0.0, 0.0, 1e3])], 0.0)


def of_ring(force: tuple[float, float, float], angle: float):
    ring = catalogue.scene("bearing-9")
    track = replace(ring.track, contact_angle=np.radians(angle))
    plain = replace(ring, track=track, loads=(), supports=(), errors=Errors())
    return plain, life.life_by_equivalent_loads([plain], [1.0], [np.array(force)], 0.0)


def test_rings_have_ISO_281_s_factors() -> None:
    for angle, force, load in (
        (25.0, (0.0, 1000.0, 0.0), 1000.0),
        (25.0, (0.0, 1000.0, 600.0), 1000.0),
        (25.0, (1000.0, 0.0, -1000.0), 1280.0),
        (40.0, (0.0, 1000.0, 2000.0), 350.0 + 1140.0),
        (60.0, (0.0, 0.0, 900.0), 900.0),
    ):
        ring, found = of_ring(force, angle)
        assert found.equivalent_loads[0] == pytest.approx(load)
        assert found.revolutions == pytest.approx((life.dynamic_rating(ring) / load) ** 3, rel=1e-9)
    for angle, words in ((15.0, "at least 20 deg"), (60.0, "thrust")):
        with pytest.raises(ValueError, match=words):
            of_ring((1000.0, 0.0, 100.0), angle)


def test_equal_slopes_have_a_closed_form():
    assert life_of_parts_in_series([(80.0, SLOPE)] * 5) == pytest.approx(80.0 * 5.0 ** (-1.0 / SLOPE), rel=1e-10)
    lives = np.array([80.0, 120.0, 1e5])
    both = (lives**-SLOPE).sum() ** (-1.0 / SLOPE)
    assert life_of_parts_in_series([(x, SLOPE) for x in lives]) == pytest.approx(both, rel=1e-10)
    assert life_of_parts_in_series([(80.0, SLOPE)]) == 80.0


def test_nine_of_ten_reach_it_and_it_is_below_the_shortest():
    parts = [(100.0, 10 / 9), (150.0, 9 / 8), (160.0, 9 / 8), (1e4, 10 / 9)]
    found = life_of_parts_in_series(parts)
    assert found < 100.0
    assert np.prod([0.9 ** ((found / x) ** slope) for x, slope in parts]) == pytest.approx(0.9, rel=1e-10)
    rng, first = np.random.default_rng(4), np.full(400_000, np.inf)
    for x, slope in parts:
        scale = x / (-np.log(0.9)) ** (1.0 / slope)
        first = np.minimum(first, scale * rng.weibull(slope, first.size))
    assert np.quantile(first, 0.1) == pytest.approx(found, rel=0.01)
