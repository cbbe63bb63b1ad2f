"""Displacements are compared beyond the nut, where a beam's section and a 3D one mean the same."""

import numpy as np
import pytest

from rollbench.comparison.models.compared_point import SectionAnswer
from rollbench.comparison.models.comparison import finest_bodies
from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store

STUDY = Study()


@pytest.mark.parametrize(
    ("name", "model", "outside", "centre"),
    [
        ("unseen-40x10", "refined", 0.17, -2.52),
        ("unseen-40x10", "condensed", -0.01, -3.02),
        ("unseen-thin-nut", "refined", 0.15, 0.06),
        ("unseen-thin-nut", "condensed", -0.19, -0.51),
    ],
)
def test_at_the_nut_s_centre_the_same_bodies_seem_stiffer(name, model, outside, centre):
    """Errors [%] of the axial displacement, at the section of the load and at the nut's centre: those of 3D bodies differ
    there as those of kernels do."""
    scene, found = STUDY.scene(name), STUDY.reference(name)
    bodies = finest_bodies(scene, found, (shipped_store(),)) if model == "condensed" else None
    result, run = run_model(scene, model, Options(discretisation=False, condensed=bodies)), found.best
    at_load = SectionAnswer.of_result(scene, result).moved / SectionAnswer.of_run(scene, run).moved - 1.0
    place, line = scene.nut.position, run.centreline
    inside = np.interp(place, result.centreline_z, result.centreline[:, 2]) / np.interp(place, line[:, 0], line[:, 3]) - 1.0
    assert (100.0 * at_load, 100.0 * inside) == (pytest.approx(outside, abs=0.05), pytest.approx(centre, abs=0.1))
