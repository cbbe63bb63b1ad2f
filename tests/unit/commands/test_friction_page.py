"""The section of friction on the page of one's own screw."""

from dataclasses import replace

import pytest
from tests.friction_runs import MU, TURN
from tests.helpers import small_screw

from rollbench.compare.models.registry import DEFAULT, ModelOptions, run_model
from rollbench.compare.report import scene_page as page
from rollbench.compare.studies.friction import run, whole
from rollbench.meshes.parts import Time

pytestmark = pytest.mark.xdist_group("run in time")
SCENE = replace(small_screw(6, 0.6, force=(0.0, 0.0, 400.0)), friction=MU, motion=TURN, time=Time(angle=0.1, steps=4))


def test_the_page_shows_torque_over_turn_coefficient_and_play():
    found = page.friction_section(SCENE, run_model(SCENE, DEFAULT, ModelOptions()), ModelOptions())
    turn, coefficient, play = found.items[1].panels
    given = whole.solve_friction_of_screw_or_bearing(replace(SCENE, time=None), whole.FrictionChoices()).data
    torque = given["torque"]["friction_torque_Nmm"]
    assert turn.series[0].y[0] == pytest.approx(torque, rel=2e-2)
    assert coefficient.series[0].x[-1] == pytest.approx(0.1)
    assert coefficient.series[0].y[-1] == pytest.approx(torque, rel=1e-9)
    assert coefficient.series[0].y[0] == pytest.approx(given["band"]["friction_torque_Nmm"][0], rel=1e-9)
    (series,) = play.series
    assert series.y[page.PLAY.index(0.0)] == pytest.approx(torque, rel=1e-9)
    assert series.y[page.PLAY.index(-5e-6)] == pytest.approx(given["play"]["friction_torque_Nmm"], rel=1e-9)
    losses = found.items[2].rows
    assert sum(row["loss_W"] for row in losses[:-1]) == pytest.approx(losses[-1]["loss_W"])
    assert losses[-1]["loss_W"] == pytest.approx(given["losses"]["total_W"])


def test_a_scene_without_coefficient_has_no_such_section():
    assert (
        page.friction_section(replace(SCENE, friction=None), run_model(SCENE, DEFAULT, ModelOptions()), ModelOptions())
        is None
    )


@pytest.mark.parametrize(("error", "digits"), [(None, 3), (2.0, 3), (0.3, 3), (0.01, 4), (1e-4, 6), (0.0, 6)])
def test_at_most_two_digits_more_than_are_sure(error, digits):
    assert run.digits_for_relative_error(error) == digits
