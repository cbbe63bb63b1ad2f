"""Displacements are compared beyond the nut, where a beam's section and a 3D one mean the same."""

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.comparison import finest_bodies, from_result, from_run
from rollbench.compare.models.model_form import SectionAnswer, pull, rigidity, section
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.reference.store import shipped_store
from rollbench.lowfi.statics.static import solve_static

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
    at_load = section(scene, from_result(result)).moved / section(scene, from_run(run, "")).moved - 1.0
    place, line = scene.nut.position, run.centreline
    inside = np.interp(place, result.centreline_z, result.centreline[:, 2]) / np.interp(place, line[:, 0], line[:, 3]) - 1.0
    assert (100.0 * at_load, 100.0 * inside) == (pytest.approx(outside, abs=0.05), pytest.approx(centre, abs=0.1))


@pytest.mark.parametrize("force", [900.0, -1400.0, 0.03])
@pytest.mark.parametrize("oversize", [0.0, 3e-6])
def test_contacts_pull_the_nut_by_the_load(force, oversize):
    """Axial equilibrium of the screw; contacts without load pull nothing, whatever angle they are given."""
    scene = small_screw(9, 1.5, force=(0.0, 0.0, force), oversize=oversize)
    result = solve_static(scene, discretisation=False)
    assert pull(scene, result.load, result.contact_angle) == pytest.approx(force, rel=1e-9)
    angle = np.where(result.load > 0.0, result.contact_angle, 1.0)
    assert pull(scene, result.load, angle) == pytest.approx(force, rel=1e-9)


def test_a_rigidity_is_the_load_s_step_over_the_motion_s():
    first, second = SectionAnswer(2e-6, 100.0), SectionAnswer(5e-6, 700.0)
    assert rigidity((first, second)) == rigidity((second, first)) == pytest.approx(200e6, rel=1e-12)
    assert rigidity((first, first)) is None
