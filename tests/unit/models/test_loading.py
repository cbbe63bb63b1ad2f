"""A scene over its load."""

import pytest
from tests.helpers import small_screw

from rollbench.compare.models import loading
from rollbench.compare.models.registry import Options, run_model
from rollbench.lowfi.rating.rigidity import axial_displacement

SCENE, OPTIONS = small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), Options(discretisation=False)


def test_displacements_are_counted_from_the_scene_without_loads_where_that_is_solved():
    at = {f: axial_displacement(SCENE, run_model(loading.scaled(SCENE, f), "lin", OPTIONS)) for f in (0.0, 0.5, 1.0)}
    alone = loading.curve(SCENE, (0.5, 1.0), "lin", OPTIONS)
    assert [p.displacement for p in alone] == pytest.approx([at[0.5], at[1.0]], rel=1e-9)
    whole = loading.curve(SCENE, (0.0, 0.5, 1.0), "lin", OPTIONS)
    assert [p.displacement for p in whole] == pytest.approx([0.0, at[0.5] - at[0.0], at[1.0] - at[0.0]], rel=1e-9)
