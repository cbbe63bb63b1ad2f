"""Which parts of a set-up are made, and which are another one turned."""

from types import SimpleNamespace

import pytest

from rollbench.comparison.scenes import catalogue
from rollbench.hifi import setup
from rollbench.meshes.groove_map import GrooveMap

SCENE = catalogue.scene("lin-case1")


@pytest.mark.parametrize(
    ("sides", "condensed"), [((0, 1, 2, 3), {0, 2}), ((0, 3), {0, 3}), ((1, 2), {1, 2}), ((0, 1), {0}), ((0, 1, 3), {0, 3})]
)
def test_a_right_flank_whose_left_one_is_there_is_not_made_again(sides, condensed, monkeypatch):
    monkeypatch.setattr(setup, "_same_boxes", lambda *_: True)
    monkeypatch.setattr(setup, "side_of", lambda *_: ())
    m = GrooveMap.of(SCENE)
    assert set(setup._patch_jobs(SCENE, m, None, None, sides, SimpleNamespace(element="Q2"))) == condensed
    assert set(setup._patch_jobs(SCENE, m, None, None, sides, SimpleNamespace(element="P2"))) == set(sides)
