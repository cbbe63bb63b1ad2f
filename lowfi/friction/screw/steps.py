"""How far a run in time is from converged steps: the torque at halved steps, and how many steps keep that below a goal.

Quantity: the friction torque over the angle, in the mean of its absolute difference. Contacts between balls, and balls that
enter the loaded arc, make it jump; the time of a jump is wrong by a part of a step, so that the largest difference would
not fall at all, while the mean one falls with the step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from rollbench.meshes.arrays import Array

#: Least order that is believed; the ones of jumps and of smooth motion.
LOWEST, OF_JUMPS, SMOOTH = 0.5, 1.0, 2.0
#: Most steps of a run, and the error beyond which its result is refused, as a part of the mean torque.
MOST, REFUSED = 20_000, 0.1
#: Change between levels, as a part of the mean torque, below which its ratios are round-off and tell no order.
ROUND_OFF = 1e-9


class Stepped(Protocol):
    """A run: friction torque (T,) [N m] at the middles of equal steps, and whether every step converged."""

    @property
    def torque(self) -> Array:
        """Friction torque (T,) [N m]."""

    @property
    def good(self) -> bool:
        """Whether every step converged."""


R = TypeVar("R", bound=Stepped)


@dataclass(frozen=True)
class StepError:
    """Estimated errors by finite steps, as parts of the mean friction torque.

    torque: mean absolute error of the torque over the run; mean: error of its mean; order: observed over three levels, nan
    where there are fewer or the change is round-off; used: order that the estimates take; steps: of the levels solved.
    """

    torque: float
    mean: float
    order: float
    used: float
    steps: tuple[int, ...]

    def small(self, goal: float) -> bool:
        """Whether the error is at most ``goal``."""
        return self.torque <= goal

    @property
    def refused(self) -> bool:
        """Whether it is too large to use the run."""
        return not self.torque <= REFUSED


def change(coarse: Array, fine: Array) -> tuple[float, float]:
    """Mean absolute difference of torques (T,) and (2 T,), these in means of two steps, and difference of the means."""
    both = fine.reshape(-1, 2).mean(axis=1)
    return float(np.mean(np.abs(both - coarse))), float(abs(fine.mean() - coarse.mean()))


def step_error(levels: list[Array]) -> StepError:
    """Error of the last of two or more runs, each with twice the steps of the one before (Richardson's extrapolation).

    Where the order observed over three levels is that of smooth motion (2, within 0.5), the change between the last two
    over 2^2 - 1. Otherwise jumps rule, whose errors fall irregularly: the larger one of that change and half of the one
    before, over 2^p - 1, p the order observed but at most 1. Levels may agree on a wrong time of a jump by chance: the
    estimate is never below the torque's largest jump for half a step.
    """
    steps = tuple(t.size for t in levels)
    size = abs(float(levels[-1].mean()))
    last, mean = change(levels[-2], levels[-1])
    if size == 0.0:
        return StepError(0.0, 0.0, float("nan"), OF_JUMPS, steps)
    order, before = float("nan"), (0.0, 0.0)
    if len(levels) > 2 and last > ROUND_OFF * size:
        before = change(levels[-3], levels[-2])
        order = float(np.log2(max(before[0], 1e-300) / last))
    used = OF_JUMPS if np.isnan(order) else float(np.clip(order, LOWEST, OF_JUMPS))
    if abs(order - SMOOTH) < 0.5:
        used, before = SMOOTH, (0.0, 0.0)
    scale = size * (2.0**used - 1.0)
    least = 0.5 * float(np.abs(np.diff(levels[-1])).max(initial=0.0)) / (steps[-1] * size)
    torque, average = max(last, 0.5 * before[0]) / scale, max(mean, 0.5 * before[1]) / scale
    return StepError(max(torque, least), max(average, least), order, used, steps)


def solve_steps(simulate: Callable[[int], R], steps: int | None, first: int, goal: float) -> tuple[R, StepError | None]:
    """The run at given steps, a multiple of 4, with those at half and a quarter of them; without, at doubled steps until
    the error is small.

    first: steps to begin with where none are given. No error (None) where a run ended early.
    """
    if steps is not None:
        counts = [steps // 4, steps // 2, steps]
    else:
        counts = [first * 2**k for k in range(20) if first * 2**k <= MOST]
    if not counts or counts[0] * (4 if steps is not None else 1) not in (steps, first):
        raise ValueError("steps must be a multiple of 4")
    levels: list[Array] = []
    found: R | None = None
    error: StepError | None = None
    for count in counts:
        found = simulate(count)
        if not found.good:
            return found, None
        levels.append(found.torque)
        if len(levels) > 2 or (len(levels) == 2 and steps is None):
            error = step_error(levels)
            if steps is None and len(levels) > 2 and error.small(goal):
                break
    if found is None:
        raise ValueError("need at least one step")
    return found, error
