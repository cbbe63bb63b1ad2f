"""A scene over its load."""

import pytest
from tests.helpers import small_screw

from rollbench.comparison.models.loading import curve, scaled
from rollbench.comparison.models.registry import Options, run_model
from rollbench.lowfi.rating.rigidity import axial_displacement


def test_displacements_are_counted_from_the_scene_without_loads_where_that_is_solved():
    scene, options = small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), Options(discretisation=False)
    at = {f: axial_displacement(scene, run_model(scaled(scene, f), "lin", options)) for f in (0.0, 0.5, 1.0)}
    alone = curve(scene, (0.5, 1.0), "lin", options)
    assert [p.displacement for p in alone] == pytest.approx([at[0.5], at[1.0]], rel=1e-9)
    whole = curve(scene, (0.0, 0.5, 1.0), "lin", options)
    assert [p.displacement for p in whole] == pytest.approx([0.0, at[0.5] - at[0.0], at[1.0] - at[0.0]], rel=1e-9)
