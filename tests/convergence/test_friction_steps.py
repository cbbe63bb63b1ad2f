"""Order of a transient simulation: second while nothing begins or ends, and across events, at which steps are cut."""

from itertools import pairwise

import numpy as np
import pytest
from tests.friction_runs import crowded, setting, sparse

from rollbench.lowfi.friction.screw.travel import (
    estimate_time_step_errors,
    mean_torque_difference,
    simulate,
    simulate_with_step_errors,
)


def test_smooth_motion_is_of_second_order():
    runs = [simulate(setting(sparse()), 0.5, n) for n in (8, 16, 32, 64)]
    changes = [mean_torque_difference(a.per_step, b.per_step) for a, b in pairwise(runs)]
    orders = np.log2(np.array(changes[:-1]) / changes[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.35)
    assert estimate_time_step_errors(runs[1:]).errors_by_quantity["torque"].order == pytest.approx(2.0, abs=0.35)


@pytest.fixture(scope="module")
def meeting():
    s = setting(crowded())
    return [simulate(s, 0.3, n) for n in (12, 24, 48, 192)]


def test_the_estimates_hold_where_balls_meet_enter_and_leave(meeting):
    assert all(h.good for h in meeting)
    assert meeting[-1].contact.any()
    assert len({tuple(row) for row in meeting[-1].loaded}) > 1
    found, fine, mean = estimate_time_step_errors(meeting[:3]), meeting[3], meeting[3].torques["mean"]
    off = {name: abs(fine.torques[name] - meeting[2].torques[name]) / mean for name in fine.torques}
    off |= {
        "torque": mean_torque_difference(meeting[2].per_step, fine.per_step) / mean,
        "share": abs(fine.share - meeting[2].share),
    }
    assert set(off) == set(found.errors_by_quantity)
    for name, error in off.items():
        assert error <= found.errors_by_quantity[name].error


def test_largest_and_least_torque_are_those_on_either_side_of_events(meeting):
    """A few steps see the torque just before and after a ball has entered or left, as many do; equal steps may miss it."""

    def missed(scheme, steps):
        found = simulate(setting(crowded()), 0.3, steps, scheme)
        return max(abs(end(found.torque) - end(fine)) for end in (np.max, np.min)) / np.ptp(fine)

    fine = meeting[-1].torque
    assert max(missed("located", n) for n in (5, 8, 11)) < 0.02
    assert max(missed("equal", n) for n in (5, 8, 11)) > 0.1


def test_steps_that_are_not_given_reach_the_goal():
    found, error = simulate_with_step_errors(setting(sparse()), 0.2, None, 1e-3)
    assert error.is_within(1e-3)
    assert found.steps == error.step_counts[-1]
    finer = simulate(setting(sparse()), 0.2, 8 * found.steps)
    assert mean_torque_difference(found.per_step, finer.per_step) < 1e-3 * found.torques["mean"]
