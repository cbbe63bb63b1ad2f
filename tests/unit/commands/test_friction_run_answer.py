"""The command ``rollbench friction`` for scenes with [time]: values, histories, verdicts, refusals; its section on
the page of one's own screw."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from tests.friction_runs import MU, TURN, crowded, setting, sparse
from tests.helpers import small_screw

from rollbench.compare.errors import InputError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import DEFAULT, run_model
from rollbench.compare.report import scene_page as page
from rollbench.compare.results.friction_run import transient_simulation_as_json
from rollbench.compare.studies.friction import run as runs
from rollbench.compare.studies.friction import whole
from rollbench.lowfi.friction.screw.travel import TimeStepErrorEstimate, TimeStepErrors, simulate
from rollbench.meshes.parts import Time

pytestmark = pytest.mark.xdist_group("run in time")
SCENE = replace(small_screw(6, 0.6, force=(0.0, 0.0, 400.0)), friction=MU, motion=TURN, time=Time(angle=0.1, steps=4))


def solved(scene, model="lin", friction=MU, **time):
    parts = replace(scene, friction=friction, motion=TURN, time=Time(**time))
    return whole.solve_friction_of_screw_or_bearing(parts, whole.FrictionChoices(model))


@pytest.fixture(scope="module")
def answer():
    return solved(crowded(), angle=1.0, steps=20)


def test_run_follows_the_instant_and_holds_the_torque_with_its_parts(answer):
    run = answer.as_json()["run"]
    assert answer.converged
    assert answer.as_json()["torque"]["friction_torque_Nmm"] > 0.0
    over = run["over_angle"]
    parts = [np.array(over[k]) for k in ("groove_Nmm", "ball_sliding_Nmm", "ball_closing_Nmm")]
    assert sum(parts) == pytest.approx(np.array(over["torque_Nmm"]), rel=1e-12)
    assert sum(over["covers_deg"]) == pytest.approx(np.degrees(1.0))
    assert run["torque"]["mean_Nmm"] == pytest.approx(np.average(over["torque_Nmm"], weights=over["covers_deg"]))
    assert run["torque"]["largest_ball_force_N"] > 0.0
    ends = np.cumsum(over["covers_deg"])
    assert np.array(over["angle_deg"]) == pytest.approx(ends - 0.5 * np.array(over["covers_deg"]))
    energy = run["energy"]
    assert max(energy["largest_imbalance"], energy["largest_torque_imbalance"]) < 1e-8
    assert energy["torque_work_J"] + energy["load_work_J"] == pytest.approx(energy["loss_J"], rel=1e-8)
    assert abs(energy["balance_J"]) < 1e-8 * energy["loss_J"]
    json.dumps(answer.as_json(), allow_nan=False)


def test_error_of_the_steps_stands_in_every_result_and_steps_are_chosen_where_none_are_given(answer):
    error = answer.as_json()["run"]["step_error"]
    assert error["steps"] == [5, 10, 20]
    assert error["torque_percent"] > 0.0
    assert all(0.0 <= error[f"{name}_torque_percent"] < 1.0 for name in ("mean", "most", "least"))
    assert ("over time: step error, torque", "%") in [(row.quantity, row.unit) for row in answer.rows(details=True)]
    found = solved(sparse(), angle=0.5, output="torque").as_json()["run"]
    assert (found["step_error"]["small"], found["steps"]) == (True, found["step_error"]["steps"][-1])
    assert "balls" not in found


def test_an_error_above_the_goal_or_that_nobody_knows_has_not_converged_in_the_step():
    history, names = simulate(setting(sparse()), 0.02, 4), ("torque", "mean", "largest", "least", "share")
    for name, size in product(names, (0.005, 0.02, 2.2)):
        found = {key: TimeStepErrorEstimate(size if key == name else 0.001) for key in names}
        run = runs.simulation_with_status(history, TimeStepErrors(found, (1, 2, 4)), Time(angle=0.2, steps=4))
        assert run.converged is (size < 0.01)
        assert run.converged or run.status.startswith("not converged in the time step: the error of 4 steps is some ")
    run = runs.simulation_with_status(simulate(setting(sparse()), 0.02, 3), None, Time(angle=0.2, steps=3))
    assert run.status.startswith("not converged in the time step")
    assert transient_simulation_as_json(run)["step_error_unknown"] == "fewer than 4 steps"


def test_a_run_that_stopped_says_where_and_sums_over_what_it_ran():
    whole = setting(sparse())

    def solve(met, at):
        found = whole.solve_contact_loads(met, at)
        return found if len(tries) < 4 and not tries.append(at) else replace(found, status="none")

    tries = []
    full, history = simulate(whole, 0.02, 4), simulate(replace(whole, solve_contact_loads=solve), 0.02, 4)
    run, degrees = runs.simulation_with_status(history, None, Time(angle=0.2, steps=4)), np.degrees(0.2)
    data = transient_simulation_as_json(run)
    assert (data["steps"], data["complete"]) == (3, False)
    assert (data["reached_deg"], data["asked_deg"]) == pytest.approx((0.75 * degrees, degrees))
    assert data["step_error_unknown"] == "the run stopped before its end"
    assert data["energy"]["loss_J"] == pytest.approx(0.005 * float((full.torque[:3] * TURN.speed).sum()))


def test_zero_friction_runs_without_loss_and_models_that_cannot_run_in_time_are_refused():
    with pytest.raises(InputError, match=r"model: .*lin or refined"):
        solved(small_screw(4, 0.5, force=(0.0, 0.0, 300.0)), "mei", angle=0.1, steps=4)
    found = solved(sparse(), friction=replace(MU, screw=0.0, nut=0.0), angle=0.1, steps=4)
    assert found.converged
    torque = found.as_json()["run"]["torque"]
    assert (torque["mean_Nmm"], torque["ball_to_ball_most_percent_of_groove"]) == (0.0, None)


def section(scene):
    return page.friction_section(scene, run_model(scene, DEFAULT, ModelOptions()), ModelOptions())


def test_the_page_shows_torque_over_turn_coefficient_and_play():
    found = section(SCENE)
    turn, coefficient, play, lost = (panel.series[0] for panel in found.items[1].panels)
    assert lost.x[-1] == pytest.approx(sum(lost.x[:-1])), "the last bar is the sum over the flanks"
    given = whole.solve_friction_of_screw_or_bearing(replace(SCENE, time=None), whole.FrictionChoices()).as_json()
    torque = given["torque"]["friction_torque_Nmm"]
    assert turn.y[0] == pytest.approx(torque, rel=2e-2)
    assert coefficient.x[-1] == pytest.approx(0.1)
    assert coefficient.y[-1] == pytest.approx(torque, rel=1e-9)
    assert coefficient.y[0] == pytest.approx(given["band"]["friction_torque_Nmm"][0], rel=1e-9)
    assert play.y[page.PLAY.index(0.0)] == pytest.approx(torque, rel=1e-9)
    assert play.y[page.PLAY.index(-5e-6)] == pytest.approx(given["play"]["friction_torque_Nmm"], rel=1e-9)
    losses = found.items[2].columns["friction_loss_whole"]
    assert [sum(losses[:-1]), losses[-1]] == pytest.approx([given["losses"]["total_W"]] * 2)
    assert section(replace(SCENE, friction=None)) is None, "no coefficient"
