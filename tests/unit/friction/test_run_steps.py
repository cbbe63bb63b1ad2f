"""Error of the steps of a run: torques whose exact values are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from rollbench.lowfi.friction.screw.steps import MOST, REFUSED, StepError, solve_steps, step_error


def middles(steps):
    return (np.arange(steps) + 0.5) / steps


def smooth(steps, size=0.5):
    """A torque whose values err by a part of the square of the step."""
    t = middles(steps)
    return 2.0 + np.sin(t) + size / steps**2 * (4.0 + np.cos(t))


def jump(steps, at=0.37):
    """A torque that jumps: a step takes it from the start of the jump's step on."""
    return np.where(middles(steps) + 0.5 / steps > at, 3.0, 1.0)


def test_smooth_runs_are_of_second_order_and_the_estimate_is_their_error():
    found = step_error([smooth(n) for n in (256, 512, 1024)])
    exact = 2.0 + np.sin(middles(1024))
    error = float(np.mean(np.abs(smooth(1024) - exact))) / smooth(1024).mean()
    assert found.order == pytest.approx(2.0, abs=0.1)
    assert found.used == 2.0
    assert found.torque == pytest.approx(error, rel=0.2)
    assert found.mean == pytest.approx(error, rel=0.2)
    assert found.steps == (256, 512, 1024)


@pytest.mark.parametrize("at", [0.37, 0.5001, 0.123, 0.9])
@pytest.mark.parametrize("most", [32, 64, 256])
def test_jumps_are_bounded_by_the_estimate(at, most):
    levels = [jump(n, at) for n in (most // 4, most // 2, most)]
    found = step_error(levels)
    exact = jump(2**14, at).reshape(most, -1).mean(axis=1)
    error = float(np.mean(np.abs(levels[-1] - exact)) / levels[-1].mean())
    assert found.torque >= 0.5 * error
    assert found.torque <= 8.0 / most
    assert found.used in (0.5, 1.0) or 0.5 <= found.used <= 1.0


def test_two_levels_tell_no_order():
    found = step_error([smooth(64), smooth(128)])
    assert np.isnan(found.order)
    assert found.used == 1.0


def test_a_torque_of_zero_and_one_without_change_have_no_error():
    assert step_error([np.zeros(4), np.zeros(8), np.zeros(16)]).torque == 0.0
    same = step_error([np.ones(4), np.ones(8), np.ones(16)])
    assert same.torque == 0.0
    assert np.isnan(same.order)


@dataclass
class Fake:
    torque: np.ndarray
    good: bool = True


def test_steps_are_doubled_until_the_error_is_small():
    tried = []

    def simulate(steps):
        tried.append(steps)
        return Fake(smooth(steps, 10.0))

    found, error = solve_steps(simulate, None, 8, 1e-3)
    assert tried == [8 * 2**k for k in range(len(tried))]
    assert found.torque.size == tried[-1]
    assert error.small(1e-3)
    assert not step_error([smooth(n, 10.0) for n in tried[-4:-1]]).small(1e-3)


def test_given_steps_are_solved_with_half_and_a_quarter():
    tried = []

    def simulate(steps):
        tried.append(steps)
        return Fake(smooth(steps))

    found, error = solve_steps(simulate, 40, 8, 1e-9)
    assert tried == [10, 20, 40]
    assert found.torque.size == 40
    assert error.steps == (10, 20, 40)
    with pytest.raises(ValueError, match="multiple of 4"):
        solve_steps(simulate, 42, 8, 1e-9)


def test_a_run_that_ends_early_has_no_error():
    found, error = solve_steps(lambda _: Fake(np.ones(3), False), None, 8, 0.01)
    assert error is None
    assert not found.good


def test_steps_end_at_a_limit_and_large_errors_are_refused():
    tried = []

    def noisy(steps):
        tried.append(steps)
        return Fake(1.0 + (-1.0) ** len(tried) * np.ones(steps) * 0.5)

    _, error = solve_steps(noisy, None, 5000, 0.01)
    assert tried == [5000, 10000, 20000]
    assert tried[-1] <= MOST
    assert error.refused
    assert StepError(REFUSED, 0.0, 1.0, 1.0, ()).refused is False
    assert StepError(float("nan"), 0.0, 1.0, 1.0, ()).refused
