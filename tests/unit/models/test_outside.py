"""Where answers leave what the models mean: said just beyond each line, and not on it."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.answers import validity_warnings
from rollbench.lowfi.rating.life import dynamic_rating

SCENE = small_screw()


def said(safety, preload):
    loads = SimpleNamespace(safety=None if safety is None else SimpleNamespace(factor=safety))
    return [(warned.kind, str(warned)) for warned in validity_warnings(SCENE, loads, preload)]


@pytest.mark.parametrize("safety", [None, 1.0, 5.0])
def test_nothing_is_said_up_to_the_lines(safety):
    assert said(safety, 0.0) == said(safety, dynamic_rating(SCENE)) == []


def test_each_line_is_said_just_beyond_it():
    C = dynamic_rating(SCENE)
    below, above = np.nextafter(1.0, 0.0), np.nextafter(C, np.inf)
    (dent,), (heavy,) = said(below, C), said(1.0, above)
    assert dent[0] == "safety"
    assert "static safety of 1, below 1" in dent[1]
    assert heavy[0] == "preload"
    assert f"preload of {above:.4g} N, above the dynamic load rating of {C:.4g} N" in heavy[1]
    assert [kind for kind, _ in said(0.5, 2.0 * C)] == ["safety", "preload"]
