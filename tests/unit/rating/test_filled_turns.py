"""Turns without balls add nothing to a rating: gaps of circuits, arcs, listed azimuths, sets, preload by a share of C."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.template import ball_screw_text
from rollbench.lowfi.rating.life import basic_rating_life, contact_capacity, dynamic_rating, filled_turns
from rollbench.lowfi.rating.rigidity import axial_compliance_of_bodies
from rollbench.meshes.parts import Scene

#: SFU 2505 of a maker: 96 balls in four turns.
SCREW = """
title = "SFU 2505"
[material]
name = "bearing steel"
[track]
pitch_diameter = "25.698 mm"
lead = "5 mm"
contact_angle = "45 deg"
[screw]
length = "500 mm"
outer_diameter = "25 mm"
conformity = 0.525
[nut]
position = "250 mm"
length = "200 mm"
outer_diameter = "40 mm"
conformity = 0.525
[balls]
diameter = "3.175 mm"
{balls}
[[supports]]
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]
"""
WHOLE = "count = 96\nturns = 4"


def screw(balls: str, more: str = "") -> Scene:
    return scene_file.scene_from_text(SCREW.format(balls=balls) + more, "my.toml")


def turned(*turns: float) -> str:
    return "[" + ", ".join(f'"{float(360.0 * x)!r} deg"' for x in turns) + "]"


def circuits(number: int, gap: float) -> str:
    return f"count = 96\nturns = {4 / number}\ncircuits = {number}\ncircuit_gap = {gap}"


SAME = [circuits(number, gap) for number in (2, 4, 8) for gap in (0.0, 0.01, 1 / 24, 0.25, 0.5, 1.0, 5.0)]
SAME += [
    "count = 96\narcs = [" + ", ".join((turned(-6, -3.5), turned(-1, 0), turned(0.75, 1.25))) + "]",
    "azimuths = " + turned(*(np.arange(96) / 24 + np.repeat([-3.0, 0.0, 0.2], [10, 70, 16]))),
    "azimuths = " + turned(*np.random.default_rng(1).permutation(np.arange(96) / 24)),
]


@pytest.mark.parametrize("balls", SAME)
def test_the_same_filled_turns_have_the_same_rating_and_life(balls: str) -> None:
    scene, whole = screw(balls), screw(WHOLE)
    load = np.full((96, 4), 60.0)
    assert filled_turns(scene) == pytest.approx(4.0, rel=1e-12)
    assert dynamic_rating(scene) == pytest.approx(dynamic_rating(whole), rel=1e-9)
    assert dynamic_rating(scene) == pytest.approx(15127.0, rel=1e-4)  # by hand, exponents of the standard rounded
    assert basic_rating_life(scene, load).revolutions == pytest.approx(basic_rating_life(whole, load).revolutions, rel=1e-9)
    np.testing.assert_allclose(contact_capacity(scene), contact_capacity(whole), rtol=1e-9)
    assert axial_compliance_of_bodies(scene) == pytest.approx(axial_compliance_of_bodies(whole), rel=1e-9)


def test_a_hand_calculation_by_ISO_3408_5() -> None:
    """C_a = C_i i^0.86, C_i = C_s (1 + (C_s/C_n)^(10/3))^-0.3, four turns of 24 balls of 3.175 mm, grooves of 0.525."""
    g, root = 3.175 * 0.5**0.5 / 25.698, 1.0 - 0.5**0.5 / 3.0
    sides = [
        9.32 * 10.0 * root * 21.0**0.41 * g**0.3 * (1 - s * g) ** 1.39 / (1 + s * g) ** (1 / 3)
        * 0.5**0.43 * 24.0 ** (2 / 3) * 3.175**1.8 * np.cos(np.arctan(5.0 / (pi * 25.698))) ** 1.3
        for s in (1.0, -1.0)
    ]  # fmt: skip
    assert sum(x ** (-10 / 3) for x in sides) ** -0.3 * 4.0**0.86 == pytest.approx(
        dynamic_rating(screw(circuits(4, 0.5))), rel=1e-3
    )


@pytest.mark.parametrize(("times", "factor"), [(2, 2.0**0.86), (3, 3.0**0.86)])
def test_more_circuits_raise_the_rating_by_the_power_of_the_standard(times: int, factor: float) -> None:
    one = screw("count = 60\nturns = 2.5")
    more = screw(f"count = {60 * times}\nturns = 2.5\ncircuits = {times}\ncircuit_gap = 0.5")
    assert dynamic_rating(more) / dynamic_rating(one) == pytest.approx(factor, rel=1e-9)


def test_unequal_distances_fill_what_the_median_fills_and_no_jump_comes_of_a_moved_ball() -> None:
    whole = screw(WHOLE)
    places = np.array(whole.balls.azimuths)

    def of(azimuths: np.ndarray) -> Scene:
        return replace(whole, balls=replace(whole.balls, azimuths=tuple(azimuths)))

    piled = places - np.where(np.arange(96) % 24 == 23, 1e-3, 0.0)  # clearance behind one ball of every turn
    assert dynamic_rating(of(piled)) == pytest.approx(dynamic_rating(whole), rel=1e-9)
    spread = np.sort(places + np.random.default_rng(0).uniform(-0.02, 0.02, 96))
    assert filled_turns(of(spread)) == pytest.approx(96 * np.median(np.diff(spread)) / (2 * pi))
    assert dynamic_rating(of(spread)) == pytest.approx(dynamic_rating(whole), rel=0.01)
    moved = spread.copy()
    for step in np.linspace(0.0, 0.1, 50):
        moved[50] = spread[50] + step
        assert dynamic_rating(of(moved)) == pytest.approx(dynamic_rating(of(spread)), rel=2e-3)
    assert filled_turns(of(places[:1])) == 1.0


def test_a_preload_by_a_share_of_the_rating_does_not_depend_on_gaps() -> None:
    more = '[preload]\nforce = "5 % of C"\n'
    found = {screw(balls, more).errors.balls.oversize for balls in (WHOLE, circuits(4, 0.25), circuits(4, 5.0))}
    assert max(found) == pytest.approx(min(found), rel=1e-9)
    assert min(found) > 0.0


def test_a_size_s_scene_is_rated_by_its_filled_turns() -> None:
    scene = scene_file.scene_from_text(ball_screw_text("40x10"), "my.toml")
    assert filled_turns(scene) == pytest.approx(3.0, rel=1e-9)
