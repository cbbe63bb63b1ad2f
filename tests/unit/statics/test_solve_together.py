"""Scenes that are solved together have the answers that they have alone."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.errors import InputError
from rollbench.compare.models.registry import run_model, run_model_on_scenes
from rollbench.meshes.cache import kept_by_content

#: Equal and different forms: numbers of balls, one or both flank pairs, free motions, and no load at all.
SCENES = [
    small_screw(12, force=(0.0, 0.0, 900.0)),
    small_screw(12, force=(0.0, 0.0, 1800.0)),
    small_screw(12, oversize=6e-6, force=(0.0, 0.0, 300.0)),
    small_screw(9, force=(0.0, 0.0, 900.0)),
    small_screw(12, oversize=-5e-6, force=(0.0, 0.0, 0.0)),
    small_screw(12, force=(0.0, 0.0, -700.0)),
]


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_scenes_together_have_the_loads_of_each_alone(model):
    together = run_model_on_scenes(SCENES, model)
    for scene, found in zip(SCENES, together, strict=True):
        alone = run_model(scene, model)
        assert found.status == alone.status
        assert found.solver.iterations == alone.solver.iterations
        np.testing.assert_allclose(found.load, alone.load, rtol=1e-11, atol=1e-12 * alone.load.max())
        np.testing.assert_allclose(found.centreline, alone.centreline, rtol=1e-9, atol=1e-15)


def test_a_refused_scene_has_its_error_and_the_others_their_loads():
    bad = replace(SCENES[0], screw=replace(SCENES[0].screw, outer_diameter=26e-3))
    good, refused = run_model_on_scenes([SCENES[0], bad], "refined")
    assert good.converged
    assert isinstance(refused, InputError)


def test_results_are_kept_by_the_content_of_their_arrays():
    calls = []

    @kept_by_content(2, lambda x: (x,))
    def doubled(x):
        calls.append(x.copy())
        return 2.0 * x

    x = np.arange(3.0)
    assert doubled(x) is doubled(x.copy())
    x[0] = 5.0
    assert doubled(x)[0] == 10.0
    doubled(np.zeros(3))  # the third of two that are kept
    doubled(np.arange(3.0))
    assert len(calls) == 4
    doubled.cache_clear()
    assert doubled(x)[0] == 10.0
    assert len(calls) == 5
