"""Parts of a set-up: what the cache keeps, what other processes make, and which are another one turned."""

import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.two_balls import SMALL, two_balls

from rollbench.hifi import setup
from rollbench.hifi.side_by_side import Job, make
from rollbench.meshes.cache import Cache, key_of
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.solid import dimensions

pytestmark = pytest.mark.xdist_group("helped by processes")


def test_a_prepared_geometry_comes_whole_from_the_cache(small, small_cache):
    """Also what depends on records that came from the cache themselves."""
    again = Cache(small_cache.root)
    found = setup.prepare(two_balls(), (0, 3), SMALL, cache=again)
    assert small_cache.hits == again.misses == 0
    assert small_cache.misses == again.hits > 5
    assert found.seconds == pytest.approx(small.seconds, rel=0.1), "those of making its stages, not of reading"
    assert min(found.seconds.values()) > 0.0
    np.testing.assert_array_equal(found.ball.G, small.ball.G)
    np.testing.assert_array_equal(found.patches[0].local, small.patches[0].local)
    np.testing.assert_array_equal(found.screw.stretch.F, small.screw.stretch.F)


def test_the_shaft_is_kept_whatever_nut_and_stations_are():
    """Its section costs a fifth of a coarse set-up, and depends on the screw alone."""

    def keys(scene, stations, sizes=SMALL):
        parts = setup._shaft_jobs(scene, GrooveMap.of(scene), dimensions(scene), sizes, stations)
        assert {part.stage for part in parts} == {"shaft section"}
        return {key_of(part.build, part.arguments, part.type_) for part in parts}

    plain, ends = two_balls(), (0.0, 60e-3)
    scene = replace(plain, solid=replace(plain.solid, shaft_diameter=None))
    known = keys(scene, ends)
    assert len(known) == 4, "the section, and the shafts of three lengths"
    thicker = replace(scene, nut=replace(scene.nut, outer_diameter=scene.nut.outer_diameter + 1e-3))
    assert keys(thicker, ends) == known == keys(scene, (0.0, 55e-3, 60e-3))
    other = replace(scene, screw=replace(scene.screw, bore=4e-3))
    assert not keys(other, ends) & known
    finer = keys(scene, ends, replace(SMALL, cell=8e-3))
    assert len(finer & known) == 1, "the section has cells of its own"
    assert not keys(scene, (30e-3,)) & known


def test_a_set_up_in_two_processes_is_the_same(small, small_cache, tmp_path):
    given = small.scene, small.sides, replace(SMALL, element="P1", tet=0.35e-3, modes=16, ball_modes=16)
    here = setup.prepare(*given, cache=Cache(small_cache.root))
    shared = setup.prepare(*given, cache=Cache(tmp_path), processes=2)
    assert shared.others_MB > 100.0
    assert list(shared.seconds) == list(here.seconds)
    parts = [(*(x.patches[s].local for s in small.sides), x.nut.G, x.screw.stretch.F) for x in (shared, here)]
    for one, other in zip(*parts, strict=True):
        np.testing.assert_array_equal(one, other)
    again = Cache(tmp_path)
    setup.prepare(*given, cache=again)
    assert again.misses == 0


def test_a_process_that_is_ended_from_outside_is_a_lack_of_memory():
    ended = f"__import__('os')._exit(1) if __import__('os').getpid() != {os.getpid()} else __import__('time').sleep(1)"
    part = Job("any", eval, (ended,), type(None))
    with pytest.raises(MemoryError, match="ended from outside"):
        make([part, part], Cache(None), 2)


@pytest.mark.parametrize("processes", [1, 2])
def test_parts_are_told_as_they_are_made(processes):
    parts = [Job("any", eval, (text,), int) for text in ("1", "2", "(__import__('time').sleep(0.5), 1 // 0)[1]")]
    heard = {}
    with pytest.raises(ZeroDivisionError):
        make(parts, Cache(None), processes, lambda k, one: heard.update({k: one.value}))
    assert heard == {0: 1, 1: 2}


def test_parts_are_made_here_and_by_others_in_their_order():
    parts = [Job("any", eval, (f"({k}, __import__('time').sleep(0.5))[0]",), int) for k in range(4)]
    found = make(parts, Cache(None), 2)
    assert [one.value for one in found] == [0, 1, 2, 3]
    assert len({one.process for one in found}) == 2
    assert os.getpid() in {one.process for one in found}
    with pytest.raises(ZeroDivisionError):
        make([*parts, Job("any", eval, ("1 / 0",), int)], Cache(None), 2)


@pytest.mark.parametrize(
    ("sides", "condensed"), [((0, 1, 2, 3), {0, 2}), ((0, 3), {0, 3}), ((1, 2), {1, 2}), ((0, 1), {0}), ((0, 1, 3), {0, 3})]
)
def test_a_right_flank_whose_left_one_is_there_is_not_made_again(sides, condensed, monkeypatch):
    monkeypatch.setattr(setup, "_same_boxes", lambda *_: True)
    monkeypatch.setattr(setup, "side_of", lambda *_: ())
    m = GrooveMap.of(two_balls())
    assert set(setup._patch_jobs(None, m, None, None, sides, SimpleNamespace(element="Q2"))) == condensed
    assert set(setup._patch_jobs(None, m, None, None, sides, SimpleNamespace(element="P2"))) == set(sides)
