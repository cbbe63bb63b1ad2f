"""Liu's screw as a scene, and the chain that is compared with it."""

import re

import numpy as np
import pytest

from rollbench.compare.cases.liu import evidence, page
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.as_source.liu.chain import solve_ball_screw
from rollbench.meshes.parts import Scene

SCENE = catalogue.shipped_scene_of_kind(page.SCENE, Scene)


def test_an_error_is_the_diameter_of_a_ball():
    found = page.with_ball_errors_and_axial_load(SCENE, evidence.ball_errors_with_faulty_ball_33(2e-6), 1000.0)
    assert found.errors.balls.listed == ((33, 1e-6),)
    assert found.loads[0].force == (0.0, 0.0, 1000.0)


def test_chain_shares_the_load_as_the_beam_does_on_average():
    errors = np.zeros(evidence.ball_count())
    beam = SceneResultCache().solve_once(page.with_ball_errors_and_axial_load(SCENE, errors, 5000.0)).load[:, 0]
    axial = solve_ball_screw(page.axial_model_inputs_with_rigid_nut(SCENE).liu_chain, errors, 5000.0).load
    assert beam.mean() == pytest.approx(axial.mean(), rel=2e-3)
    turns, chain = (load.reshape(3, 26).mean(axis=1) for load in (beam, axial))
    assert turns == pytest.approx(chain, rel=0.01)
    cells = page.difference_from_axial_cells("beam", beam, axial)
    most, ball = re.fullmatch(r"([+-][\d.]+) \(ball (\d+)\)", cells["largest_difference_from_axial", "beam"]).groups()
    assert 0.0 < cells["rms_difference_from_axial", "beam"] < abs(float(most)) < 5.0
    assert 1 <= int(ball) <= evidence.ball_count()
