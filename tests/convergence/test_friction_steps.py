"""Order of a transient simulation: second while nothing begins or ends, and across events, at which steps are cut."""

from itertools import pairwise

import numpy as np
import pytest
from tests.friction_runs import crowded, setting, sparse

from rollbench.lowfi.friction.screw import travel
from rollbench.lowfi.together import solve_alone

pytestmark = pytest.mark.xdist_group("steps of friction")


def test_smooth_motion_is_of_second_order():
    runs = [travel.simulate(setting(sparse()), 0.5, n) for n in (8, 16, 32, 64)]
    changes = [travel.mean_torque_difference(a.mean_torque_per_step, b.mean_torque_per_step) for a, b in pairwise(runs)]
    orders = np.log2(np.array(changes[:-1]) / changes[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.35)
    assert travel.estimate_time_step_errors(runs[1:]).errors_by_quantity["torque"].order == pytest.approx(2.0, abs=0.35)


@pytest.fixture(scope="module")
def meeting():
    s = setting(crowded())
    return [travel.simulate(s, 0.3, n) for n in (12, 24, 48, 192)]


def test_the_estimates_hold_where_balls_meet_enter_and_leave(meeting):
    assert all(h.fully_converged for h in meeting)
    assert meeting[-1].presses_on_next.any()
    assert len({tuple(row) for row in meeting[-1].loaded}) > 1
    found, used, fine = travel.estimate_time_step_errors(meeting[:3]), meeting[2], meeting[3]
    off = {name: abs(value - used.torque_statistics[name]) for name, value in fine.torque_statistics.items()}
    off["torque"] = travel.mean_torque_difference(used.mean_torque_per_step, fine.mean_torque_per_step)
    off = {name: error / fine.torque_statistics["mean"] for name, error in off.items()}
    off["share"] = abs(fine.largest_ball_to_groove_ratio - used.largest_ball_to_groove_ratio)
    assert set(off) == set(found.errors_by_quantity)
    for name, error in off.items():
        assert error <= found.errors_by_quantity[name].error


def test_largest_and_least_torque_are_those_on_either_side_of_events(meeting):
    """A few steps see the torque just before and after a ball has entered or left, as many do; equal steps may miss it."""

    def missed(scheme, steps):
        found = solve_alone(travel.travel(setting(crowded()), 0.3, steps, scheme))
        return max(abs(end(found.torque) - end(fine)) for end in (np.max, np.min)) / np.ptp(fine)

    fine = meeting[-1].torque
    assert max(missed("located", n) for n in (5, 8, 11)) < 0.02
    assert max(missed("equal", n) for n in (5, 8, 11)) > 0.1


def test_steps_that_are_not_given_reach_the_goal():
    found, error = travel.simulate_with_step_errors(setting(sparse()), 0.2, None, 1e-3)
    assert error.all_errors_within(1e-3)
    assert found.steps == error.step_counts[-1]
    finer = travel.simulate(setting(sparse()), 0.2, 8 * found.steps)
    difference = travel.mean_torque_difference(found.mean_torque_per_step, finer.mean_torque_per_step)
    assert difference < 1e-3 * found.torque_statistics["mean"]
