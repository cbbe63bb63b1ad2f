"""Members with elastic bodies on one system are those that are solved one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.lowfi.statics.members import SpecimensOfScene, can_share_equations
from rollbench.meshes.parts import Load, Scene

RANDOM = catalogue.scene("lin-random")
SCENES = {
    "four sides": RANDOM,
    # so that the idle diagonal is left out
    "all balls loose": replace(RANDOM, errors=replace(RANDOM.errors, balls=replace(RANDOM.errors.balls, oversize=-12e-6))),
    # held at its left end and pulled at its right one
    "section forces under the balls": replace(RANDOM, loads=(Load(RANDOM.screw.length, (100.0, 0.0, 5000.0)),)),
    "errors that press more than the load": with_scaled_loads(RANDOM, 0.02),
}


def check_motions(found, k, scene, alone, accuracy):
    """Motions of the sections at the nut and at the load, and the force on the nut, are those of the single solution."""
    for motion, at in zip(found.motions[k], places(scene), strict=True):
        expected = motion_at(alone, at)
        for some in (slice(3), slice(3, 6)):
            assert np.abs(motion[some] - expected[some]).max() <= accuracy * np.abs(expected[some]).max()
    assert found.forces[k] == pytest.approx(axial_force(alone), rel=accuracy)


def places(scene):
    return scene.nut.position, scene.loads[0].at


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_members_on_one_system_are_those_solved_one_by_one(scene: Scene, model: str) -> None:
    assert can_share_equations(scene, LADDER[model])
    found = SpecimensOfScene(scene, LADDER[model], sections=places(scene)).solve(3, 3)
    assert not np.isnan(found.residuals).any()
    for k in range(3):
        alone = run_model(scene, model, ModelOptions(member=3 + k, estimate_beam_mesh_error=False))
        assert np.abs(found.loads[k] - alone.load).max() <= 1e-11 * alone.load.max()
        check_motions(found, k, scene, alone, 1e-10)


def test_members_with_grooves_of_their_own_are_those_solved_one_by_one() -> None:
    """Errors of pitch and roundness move each groove: every specimen has lever arms of its own."""
    scene = catalogue.scene("lin-case3-tolerances")
    assert can_share_equations(scene, LADDER["lin"])
    assert not can_share_equations(scene, LADDER["refined"])
    found = SpecimensOfScene(scene, LADDER["lin"], sections=places(scene)).solve(2, 3)
    for k in range(3):
        alone = run_model(scene, "lin", ModelOptions(member=2 + k, estimate_beam_mesh_error=False))
        assert np.abs(found.loads[k] - alone.load).max() <= 1e-10 * alone.load.max()
        check_motions(found, k, scene, alone, 1e-9)
