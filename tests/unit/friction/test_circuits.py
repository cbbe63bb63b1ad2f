"""Circuits of the balls: lengths of arcs and returns, which balls they hold, and what is refused."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi.friction.whole.circuit import CircuitError, circuits_of_scene
from rollbench.meshes.parts import Circulation


def screw(**circulation):
    return replace(small_screw(12, 0.75), circulation=Circulation(**circulation))


def test_without_a_table_balls_fill_their_arc_evenly_whatever_their_order_and_a_bearing_its_turn():
    scene = small_screw(12, 1.5)
    (one,) = circuits_of_scene(scene)
    assert one.track.arc == pytest.approx(3.0 * np.pi, rel=1e-12)
    assert one.track.ring == one.track.arc
    assert np.allclose(np.diff(one.azimuth), one.track.arc / 12)
    assert one.azimuth[0] - one.track.loaded_arc_start == pytest.approx(0.5 * one.track.arc / 12)
    balls = scene.balls
    shuffled = replace(balls, azimuths=(*balls.azimuths[5:], *balls.azimuths[:5]))
    assert circuits_of_scene(replace(scene, balls=shuffled))[0].ball_numbers.tolist() == [*range(7, 12), *range(7)]
    (bearing,) = circuits_of_scene(small_screw(9, 8.0 / 9.0, lead=0.0))
    assert (bearing.track.arc, bearing.track.ring) == (2.0 * np.pi, 2.0 * np.pi)


def test_without_a_table_a_gap_parts_two_circuits_of_any_size():
    base = small_screw(12, 1.5)
    step = np.pi / 4.0
    azimuths = (*(step * np.arange(5)), *(4.0 * np.pi + step * np.arange(7)))
    scene = replace(base, track=replace(base.track, starts=2), balls=replace(base.balls, azimuths=azimuths))
    found = circuits_of_scene(scene)
    assert [c.track.start for c in found] == [0, 0, 1, 1]
    assert [c.ball_numbers.tolist() for c in found] == [[*range(5)], [*range(5, 12)], [*range(12, 17)], [*range(17, 24)]]
    assert [c.track.arc for c in found[:2]] == pytest.approx([5.0 * step, 7.0 * step])
    assert [c.track.loaded_arc_start for c in found[:2]] == pytest.approx([-0.5 * step, 4.0 * np.pi - 0.5 * step])


def test_filling_and_gap_say_the_same():
    a = circuits_of_scene(screw(returning=5, filling=0.8))[0]
    assert a.azimuth.size == 17
    assert a.ball_numbers.tolist() == [*range(12), -1, -1, -1, -1, -1]
    assert 17 * a.track.spacing / a.track.ring == pytest.approx(0.8, rel=1e-12)
    scene = screw(returning=5)
    radius = float(np.hypot(scene.track.pitch_radius, scene.track.lead / (2.0 * np.pi)))
    b = circuits_of_scene(screw(returning=5, gap=(a.track.ring / 17 - a.track.spacing) * radius))[0]
    assert b.track.ring == pytest.approx(a.track.ring, rel=1e-12)
    assert np.all(a.azimuth[12:] > a.track.loaded_arc_start + a.track.arc)
    assert np.all(a.azimuth[12:] < a.track.loaded_arc_start + a.track.ring)


def test_circuits_share_the_balls_of_every_start():
    base = small_screw(12, 1.5)
    scene = replace(base, track=replace(base.track, starts=2), circulation=Circulation(circuits=3, returning=2))
    found = circuits_of_scene(scene)
    assert [c.track.start for c in found] == [0, 0, 0, 1, 1, 1]
    assert sorted(int(b) for c in found for b in c.ball_numbers if b >= 0) == list(range(24))
    for c, d in pairwise(found[:3]):
        assert c.track.loaded_arc_start + c.track.arc == pytest.approx(d.track.loaded_arc_start, abs=1e-12)
    assert sum(c.track.arc for c in found[:3]) == pytest.approx(3.0 * np.pi)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"circuits": 5}, "circuits"),
        ({"turns": 0.6}, "turns"),
        ({"turns": 1.5, "circuits": 2}, "turns"),
        ({"filling": 1.0}, "filling"),
        ({"returning": 3, "gap": 0.0}, "gap"),
    ],
)
def test_what_cannot_be_names_its_key(change, key):
    with pytest.raises(CircuitError) as caught:
        circuits_of_scene(screw(**change))
    assert caught.value.key == key
