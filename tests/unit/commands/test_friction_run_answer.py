"""The command ``rollbench friction`` for scenes with [time]: values, histories, verdicts, refusals."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from tests.friction_runs import MU, TURN, crowded, setting, sparse
from tests.helpers import small_screw

from rollbench.compare.errors import InputError
from rollbench.compare.studies.friction.run import lines_on_simulation, simulation_with_status, transient_simulation_as_json
from rollbench.compare.studies.friction.whole import FrictionChoices, solve_friction_of_screw_or_bearing
from rollbench.lowfi.friction.screw.travel import TimeStepErrorEstimate, TimeStepErrors, simulate
from rollbench.meshes.parts import Time

pytestmark = pytest.mark.xdist_group("run in time")


def with_time(scene, **time):
    return replace(scene, friction=MU, motion=TURN, time=Time(**time))


@pytest.fixture(scope="module")
def answer():
    return solve_friction_of_screw_or_bearing(with_time(crowded(), angle=1.0, steps=20), FrictionChoices("lin"))


def test_run_follows_the_instant_and_holds_the_torque_with_its_parts(answer):
    run = answer.data["run"]
    assert answer.converged
    assert answer.data["torque"]["friction_torque_Nmm"] > 0.0
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
    json.dumps(answer.data, allow_nan=False)


def test_error_of_the_steps_stands_in_every_result(answer):
    error = answer.data["run"]["step_error"]
    assert error["steps"] == [5, 10, 20]
    assert error["torque_percent"] > 0.0
    for name in ("mean", "most", "least"):
        assert 0.0 <= error[f"{name}_torque_percent"] < 1.0
    assert "error of the time steps" in answer.text
    assert "mean absolute error" in error["quantity"]
    # and steps are chosen where none are given
    found = solve_friction_of_screw_or_bearing(
        with_time(sparse(), angle=0.5, output="torque"), FrictionChoices("lin")
    ).data["run"]
    assert (found["step_error"]["small"], found["steps"]) == (True, found["step_error"]["steps"][-1])
    assert "balls" not in found


def test_an_error_above_the_goal_or_that_nobody_knows_has_not_converged_in_the_step():
    history, names = simulate(setting(sparse()), 0.02, 4), ("torque", "mean", "largest", "least", "share")
    for name, size in product(names, (0.005, 0.02, 2.2)):
        found = {key: TimeStepErrorEstimate(size if key == name else 0.001) for key in names}
        run = simulation_with_status(history, TimeStepErrors(found, (1, 2, 4)), Time(angle=0.2, steps=4))
        assert run.converged is (size < 0.01)
        if not run.converged:
            assert run.status.startswith("not converged in the time step: the error of 4 steps is some ")
            assert run.status.endswith("more than the goal of 1 %: take more steps")
    run = simulation_with_status(simulate(setting(sparse()), 0.02, 3), None, Time(angle=0.2, steps=3))
    assert run.status.startswith("not converged in the time step")
    assert transient_simulation_as_json(run)["step_error_unknown"] == "fewer than 4 steps"


def test_a_run_that_failed_says_so():
    scene = replace(small_screw(6, 0.6, force=(0.0, 0.0, 100.0), screw="rigid"), supports=())
    history = simulate(setting(scene), 0.01, 4)
    run = simulation_with_status(history, None, Time(angle=0.1))
    assert not run.converged
    assert transient_simulation_as_json(run)["converged"] is False
    assert "contact loads" in lines_on_simulation(run)[0][1]


def test_a_run_that_stopped_says_where_and_sums_over_what_it_ran():
    whole = setting(sparse())

    def solve(met, at):
        found = whole.solve_contact_loads(met, at)
        return found if len(tries) < 4 and not tries.append(at) else replace(found, status="none")

    tries = []
    full, history = simulate(whole, 0.02, 4), simulate(replace(whole, solve_contact_loads=solve), 0.02, 4)
    run, degrees = simulation_with_status(history, None, Time(angle=0.2, steps=4)), np.degrees(0.2)
    data, lines = transient_simulation_as_json(run), lines_on_simulation(run)
    assert (data["steps"], data["complete"]) == (3, False)
    assert (data["reached_deg"], data["asked_deg"]) == pytest.approx((0.75 * degrees, degrees))
    assert lines[0][1].startswith(f"stopped at {0.75 * degrees:.6g} deg of {degrees:.6g} deg, in 3 steps")
    assert "unknown, the run stopped before its end" in lines[1][1]
    assert data["step_error_unknown"] == "the run stopped before its end"
    assert data["energy"]["loss_J"] == pytest.approx(0.005 * float((full.torque[:3] * TURN.speed).sum()))


def test_zero_friction_runs_without_loss_and_models_that_cannot_run_in_time_are_refused():
    with pytest.raises(InputError, match=r"model: .*lin or refined"):
        solve_friction_of_screw_or_bearing(
            with_time(small_screw(4, 0.5, force=(0.0, 0.0, 300.0)), angle=0.1, steps=4), FrictionChoices("mei")
        )
    scene = replace(with_time(sparse(), angle=0.1, steps=4), friction=replace(MU, screw=0.0, nut=0.0))
    found = solve_friction_of_screw_or_bearing(scene, FrictionChoices("lin"))
    assert found.converged
    torque = found.data["run"]["torque"]
    assert (torque["mean_Nmm"], torque["ball_to_ball_most_percent_of_groove"]) == (0.0, None)
