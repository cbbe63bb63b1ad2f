"""The command ``rollbench friction`` for scenes with [time]: values, histories, verdicts, refusals."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.friction_runs import MU, TURN, crowded, setting, sparse
from tests.helpers import small_screw

from rollbench.comparison.errors import InputError
from rollbench.comparison.wings.friction.run import Run, judged, run_data, run_lines
from rollbench.comparison.wings.friction.whole import Choices, solve_scene
from rollbench.lowfi.friction.screw.steps import StepError
from rollbench.lowfi.friction.whole.run import simulate
from rollbench.meshes.parts import Time

pytestmark = pytest.mark.xdist_group("run in time")


def with_time(scene, **time):
    return replace(scene, friction=MU, motion=TURN, time=Time(**time))


@pytest.fixture(scope="module")
def answer():
    return solve_scene(with_time(crowded(), angle=1.0, steps=20), Choices("lin"))


def test_run_follows_the_instant_and_holds_the_torque_with_its_parts(answer):
    run = answer.data["run"]
    assert answer.converged
    assert answer.data["torque"]["friction_torque_Nmm"] > 0.0
    over = run["over_angle"]
    parts = [np.array(over[k]) for k in ("groove_Nmm", "ball_sliding_Nmm", "ball_closing_Nmm")]
    assert sum(parts) == pytest.approx(np.array(over["torque_Nmm"]), rel=1e-12)
    assert run["torque"]["mean_Nmm"] == pytest.approx(np.mean(over["torque_Nmm"]))
    assert run["torque"]["largest_ball_force_N"] > 0.0
    assert over["angle_deg"][0] == pytest.approx(np.degrees(1.0) / 40.0)
    energy = run["energy"]
    assert energy["largest_imbalance"] < 1e-8
    assert energy["largest_torque_imbalance"] < 1e-8
    assert energy["torque_work_J"] + energy["load_work_J"] == pytest.approx(energy["loss_J"], rel=1e-8)
    assert abs(energy["balance_J"]) < 1e-8 * energy["loss_J"]
    json.dumps(answer.data, allow_nan=False)


def test_figure_3_24_can_be_drawn_from_the_histories(answer):
    """Distances of neighbours over the angle, and dots where they touch; sums close the track."""
    run = answer.data["run"]
    balls, circuit = run["balls"], run["circuits"][0]
    assert [b["place"] for b in balls] == list(range(8))
    assert [b["next"] for b in balls] == [*range(1, 8), 0]
    assert [b["index"] for b in balls] == [1, 2, 3, 4, 5, 6, None, None]
    spacing, force = (np.array([b[k] for b in balls]) for k in ("spacing_deg", "force_on_next_N"))
    assert spacing.sum(axis=0) == pytest.approx(np.full(20, circuit["length_deg"]), abs=1e-9)
    touch = force > 0.0
    assert touch.any()
    assert not touch.all()
    assert np.ptp(spacing[touch]) < 0.05, "touching balls are their sizes apart"
    place = np.array([b["azimuth_deg"] for b in balls])
    assert np.all(np.diff(place, axis=1) > 0.0)
    loads, loaded = (np.array([b[k] for b in balls]) for k in ("load_N", "loaded"))
    assert np.all(loads[~loaded] == 0.0)


def test_error_of_the_steps_stands_in_every_result(answer):
    error = answer.data["run"]["step_error"]
    assert error["steps"] == [5, 10, 20]
    assert error["torque_percent"] > 0.0
    assert any("error of the steps" in line for line in answer.lines)
    assert "mean absolute error" in error["quantity"]


def test_steps_are_chosen_where_none_are_given():
    found = solve_scene(with_time(sparse(), angle=0.5, output="torque"), Choices("lin")).data["run"]
    assert found["step_error"]["small"] is True
    assert found["steps"] == found["step_error"]["steps"][-1]
    assert "balls" not in found


@pytest.mark.parametrize(
    ("size", "good", "words"),
    [(0.005, True, ""), (0.02, True, "more than the goal of 1 %"), (0.2, False, "more than 10 %: take more steps")],
)
def test_large_errors_are_warned_of_and_larger_ones_refused(size, good, words):
    history = simulate(setting(sparse()), 0.02, 4)
    run = judged(Time(angle=0.2, steps=4), history, StepError(size, size, 1.0, 1.0, (1, 2, 4)))
    assert run.converged is good
    assert words in "; ".join([*run.warnings, "" if good else run.status])
    assert bool(run.warnings) is (good and bool(words))


def test_a_run_that_failed_says_so():
    scene = replace(small_screw(6, 0.6, force=(0.0, 0.0, 100.0), screw="rigid"), supports=())
    history = simulate(setting(scene), 0.01, 4)
    run = judged(Time(angle=0.1), history, None)
    assert not run.converged
    assert run_data(run)["converged"] is False
    assert "contact loads" in run_lines(run)[0]
    assert isinstance(run, Run)


def test_a_run_that_stopped_says_where_and_sums_over_what_it_ran():
    whole = setting(sparse())

    def solve(met, at):
        found = whole.solve(met, at)
        return found if len(tries) < 4 and not tries.append(at) else replace(found, status="none")

    tries = []
    full, history = simulate(whole, 0.02, 4), simulate(replace(whole, solve=solve), 0.02, 4)
    run, degrees = judged(Time(angle=0.2, steps=4), history, None), np.degrees(0.2)
    data, lines = run_data(run), run_lines(run)
    assert (data["steps"], data["complete"]) == (3, False)
    assert (data["reached_deg"], data["asked_deg"]) == pytest.approx((0.75 * degrees, degrees))
    assert lines[0].startswith(f"stopped at {0.75 * degrees:.6g} deg of {degrees:.6g} deg, in 3 steps")
    assert "unknown, the run stopped before its end" in lines[1]
    assert data["step_error_unknown"] == "the run stopped before its end"
    assert data["energy"]["loss_J"] == pytest.approx(0.005 * float((full.torque[:3] * TURN.speed).sum()))


def test_models_that_cannot_run_in_time_are_refused():
    with pytest.raises(InputError, match=r"--model.*lin or refined"):
        solve_scene(with_time(small_screw(4, 0.5, force=(0.0, 0.0, 300.0)), angle=0.1, steps=4), Choices("mei"))


def test_zero_friction_runs_without_loss():
    scene = replace(with_time(sparse(), angle=0.1, steps=4), friction=replace(MU, screw=0.0, nut=0.0))
    found = solve_scene(scene, Choices("lin"))
    assert found.converged
    assert found.data["run"]["torque"]["mean_Nmm"] == 0.0
    assert found.data["run"]["torque"]["ball_to_ball_most_percent_of_groove"] is None
