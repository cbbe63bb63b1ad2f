"""Members with elastic bodies on one system are those that are solved one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models.loading import with_scaled_loads
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.members.ensemble import work_done_by_loads
from rollbench.lowfi import jit
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.elastic import SpecimensWithSharedEquations, can_share_equations
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


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_members_on_one_system_are_those_solved_one_by_one(scene: Scene) -> None:
    assert can_share_equations(scene)
    kernels = jit.load_kernel_package(jit.STATICS, compiled=False)
    loads, residuals, works = SpecimensWithSharedEquations(scene, LADDER["refined"], kernels).solve(3, 3)
    assert not np.isnan(residuals).any()
    for k in range(3):
        alone = run_model(scene, "refined", ModelOptions(member=3 + k, estimate_beam_mesh_error=False))
        assert np.abs(loads[k] - alone.load).max() <= 1e-11 * alone.load.max()
        assert works[k] == pytest.approx(work_done_by_loads(scene, alone), rel=1e-11)


def test_grooves_with_random_errors_are_solved_one_by_one() -> None:
    assert not can_share_equations(catalogue.scene("lin-combined"))
