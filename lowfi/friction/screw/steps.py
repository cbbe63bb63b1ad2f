"""How far a run in time is from converged steps: its torques at halved steps, and how many steps keep errors below a goal.

Quantities: the friction torque over the angle, in the mean of its absolute difference, its mean, its largest and its least
value, and the largest share of ball-to-ball contact in it. All errors are parts of the mean torque, that of the share is a
difference of shares.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rollbench.meshes.arrays import Array

if TYPE_CHECKING:
    from rollbench.lowfi.friction.screw.travel import History

#: Orders of smooth motion and of jumps; factor of the change between levels where no order is seen, and the order below
#: which Richardson's extrapolation has that factor too.
SMOOTH, OF_JUMPS, UNCLEAR = 2.0, 1.0, 10.0
LEAST = float(np.log2(1.0 + 1.0 / UNCLEAR))
#: Safety factor on an extrapolated error.
SAFETY = 1.25
#: Most steps of a run.
MOST = 20_000
#: Change between levels, as a part of the mean torque, below which its ratios are round-off and tell no order.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class Observed:
    """Error of one quantity, a part of the mean torque; order seen over three levels, nan where the change is round-off,
    and used, nan where none is clear."""

    error: float
    order: float = float("nan")
    used: float = SMOOTH

    @property
    def unclear(self) -> bool:
        """Whether no order is seen."""
        return bool(np.isnan(self.used))


@dataclass(frozen=True)
class StepError:
    """Estimated errors by finite steps: of ``torque`` over the angle, of torques by name and of ``share``; steps of the
    levels."""

    quantities: dict[str, Observed]
    steps: tuple[int, ...]

    @property
    def torque(self) -> float:
        """Mean absolute error of the torque over the run."""
        return self.quantities["torque"].error

    @property
    def largest(self) -> float:
        """The largest error of all quantities."""
        return max(q.error for q in self.quantities.values())

    @property
    def unclear(self) -> tuple[str, ...]:
        """Quantities of which no order is seen."""
        return tuple(name for name, q in self.quantities.items() if q.unclear)

    def small(self, goal: float) -> bool:
        """Whether every error is at most ``goal``."""
        return self.largest <= goal


def change(coarse: Array, fine: Array) -> float:
    """Mean absolute difference of torques (T,) and (T',), T' >= T: means of the finer one over the coarser steps."""
    at = np.arange(coarse.size + 1) * (fine.size / coarse.size)
    work = np.interp(at, np.arange(fine.size + 1), np.concatenate([[0.0], np.cumsum(fine)]))
    return float(np.mean(np.abs(np.diff(work) * (coarse.size / fine.size) - coarse)))


def observed(before: float, last: float, jumps: bool = False) -> Observed:
    """Error from the changes of a quantity between three levels, each with half the steps of the one before.

    Richardson's extrapolation by the order seen, at most that of smooth motion, and where ``jumps`` are possible that of
    jumps unless it is near the former. Changes that grow, keep their size, or turn their sign tell no order: the error is
    then UNCLEAR times the largest of them.
    """
    most = max(abs(before), abs(last), abs(before + last))
    if most <= ROUND_OFF:
        return Observed(most)
    order = float(np.log2(max(abs(before), 1e-300) / max(abs(last), 1e-300)))
    if before * last < 0.0 or order < LEAST:
        return Observed(UNCLEAR * most, order, float("nan"))
    used = min(order, SMOOTH if not jumps or order > SMOOTH - 0.5 else OF_JUMPS)
    return Observed(SAFETY * max(abs(last), abs(before) / 2.0**used) / (2.0**used - 1.0), order, used)


def step_error(levels: Sequence[History]) -> StepError | None:
    """Errors of the last of three runs, each with twice the steps of the one before; None for fewer.

    Levels may agree by chance on a wrong time of a jump in the torque: its error is never below the largest jump between
    two steps for half a step.
    """
    steps = tuple(level.per_step.size for level in levels[-3:])
    if len(steps) < 3 or not steps[0] < steps[1] < steps[2]:
        return None
    one, two, three = (level.per_step for level in levels[-3:])
    size = abs(float(three.mean()))
    if size == 0.0:
        return StepError({"torque": Observed(0.0)}, steps)
    over = observed(change(one, two) / size, change(two, three) / size, jumps=True)
    least = 0.5 * float(np.abs(np.diff(three)).max(initial=0.0)) / (steps[-1] * size)
    errors = {"torque": replace(over, error=max(over.error, least))}
    numbers = [{name: value / size for name, value in x.torques.items()} | {"share": x.share} for x in levels[-3:]]
    for name, value in numbers[-1].items():
        if not np.isnan(value):
            errors[name] = observed(numbers[1][name] - numbers[0][name], value - numbers[1][name])
    return StepError(errors, steps)


def solve_steps(
    simulate: Callable[[int], History], steps: int | None, first: int, goal: float
) -> tuple[History, StepError | None]:
    """The run at given steps, with about half and a quarter of them; without, at doubled steps until the errors are small.

    first: steps to begin with where none are given. No error (None) where a run ended early, or for fewer than four steps.
    """
    if steps is not None:
        counts = sorted({max(1, steps // 4), max(1, steps // 2), steps})
    else:
        counts = [first * 2**k for k in range(20) if first * 2**k <= MOST]
    levels: list[History] = []
    error: StepError | None = None
    for count in counts:
        levels.append(simulate(count))
        if not levels[-1].good:
            return levels[-1], None
        error = step_error(levels)
        if steps is None and error is not None and error.small(goal):
            break
    return levels[-1], error
