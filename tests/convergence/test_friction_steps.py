"""Order of a run in time: second while nothing begins or ends, first across contacts and balls that enter and leave."""

from itertools import pairwise

import numpy as np
import pytest
from tests.friction_runs import crowded, setting, sparse

from rollbench.lowfi.friction.screw.steps import change, step_error
from rollbench.lowfi.friction.whole.run import resolved, simulate
from rollbench.meshes.parts import Time


def test_smooth_motion_is_of_second_order():
    levels = [simulate(setting(sparse()), 0.5, n).torque for n in (8, 16, 32, 64)]
    changes = [change(a, b)[0] for a, b in pairwise(levels)]
    orders = np.log2(np.array(changes[:-1]) / changes[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.35)
    assert step_error(levels[1:]).used == 2.0


def test_meeting_and_leaving_balls_leave_first_order_and_the_estimate_holds():
    s = setting(crowded())
    levels = [simulate(s, 0.3, n) for n in (12, 24, 48, 192)]
    assert all(h.good for h in levels)
    assert (levels[-1].ball_force > 0.0).any()
    assert len({tuple(row) for row in levels[-1].loaded}) > 1
    found = step_error([h.torque for h in levels[:3]])
    fine = levels[3].torque.reshape(48, 4).mean(axis=1)
    error = float(np.mean(np.abs(fine - levels[2].torque)) / fine.mean())
    assert error < 2.0 * found.torque
    assert found.torque < 20.0 * error
    paths = [h.azimuth[-1, 0] + 0.5 * h.span / h.steps * h.omega[-1, 0] for h in levels]
    off = np.abs(np.array(paths[:3]) - paths[3])
    assert off[2] < off[0]


def test_steps_that_are_not_given_reach_the_goal():
    found, error = resolved(setting(sparse()), Time(angle=2.0, goal=1e-3))
    assert error.small(1e-3)
    assert found.steps == error.steps[-1]
    finer = simulate(setting(sparse()), 0.2, 8 * found.steps)
    means = finer.torque.reshape(-1, 8).mean(axis=1)
    assert np.mean(np.abs(means - found.torque)) < 1e-3 * found.torque.mean()
