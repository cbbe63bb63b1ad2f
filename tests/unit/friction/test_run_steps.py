"""Errors of the steps of a run: torques whose exact values are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from rollbench.lowfi.friction.screw.travel import UNCLEAR, estimate_time_step_errors, simulate_until_accurate


@dataclass
class Fake:
    mean_torque_per_step: np.ndarray
    fully_converged: bool = True
    largest_ball_to_groove_ratio: float = float("nan")

    @property
    def torque_statistics(self):
        torque = self.mean_torque_per_step
        return {"mean": torque.mean(), "largest": torque.max(), "least": torque.min()}


def error_of(torques):
    return estimate_time_step_errors([Fake(t) for t in torques])


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
    found = error_of([smooth(n) for n in (256, 512, 1024)])
    exact = 2.0 + np.sin(middles(1024))
    error = float(np.mean(np.abs(smooth(1024) - exact))) / smooth(1024).mean()
    for name in ("torque", "mean"):
        assert found.errors_by_quantity[name].order == pytest.approx(2.0, abs=0.1)
        assert error < found.errors_by_quantity[name].error < 1.5 * error
    assert found.step_counts == (256, 512, 1024)


@pytest.mark.parametrize("at", [0.37, 0.5001, 0.123, 0.9])
@pytest.mark.parametrize("most", [32, 64, 256])
def test_jumps_are_bounded_by_the_estimate(at, most):
    levels = [jump(n, at) for n in (most // 4, most // 2, most)]
    exact = jump(2**14, at).reshape(most, -1).mean(axis=1)
    error = float(np.mean(np.abs(levels[-1] - exact)) / levels[-1].mean())
    assert 0.5 * error <= error_of(levels).errors_by_quantity["torque"].error <= UNCLEAR * 4.0 / most


@pytest.mark.parametrize("steps", [40, 42, 7, 4])
def test_given_steps_are_solved_with_half_and_a_quarter(steps):
    found, error = simulate_until_accurate(lambda n: Fake(smooth(n)), steps, 8, 1e-9)
    assert found.mean_torque_per_step.size == steps
    assert error.step_counts == (steps // 4, steps // 2, steps)


def test_a_run_that_ends_early_has_no_error():
    found, error = simulate_until_accurate(lambda _: Fake(np.ones(3), False), None, 8, 0.01)
    assert error is None
    assert not found.fully_converged
