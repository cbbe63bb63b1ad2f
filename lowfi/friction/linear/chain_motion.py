"""Balls with gaps between them, in time: velocities are constant between events, an event is a gap that closes.

The transient of a contact is left out as in Lin 3.3.2: balls that meet move on together, or part again, at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lowfi.friction.linear.bearing import Array, LinearBearing
from lowfi.friction.linear.chain import ChainResult, prepare, solve

#: Relative speed of neighbours, over the carriage's, that counts as none.
STILL = 1e-10


@dataclass(frozen=True)
class ChainMotion:
    """Events of a chain: time ``(E,)`` [s], gap ``(E, N-1)`` [m] between surfaces, result from that time on, E of them.

    The last entry is the end of the run.
    """

    time: Array
    gap: Array
    results: tuple[ChainResult, ...]

    def gap_at(self, time: float) -> Array:
        """Gaps ``(N-1,)`` [m] at a time within the run."""
        return np.array([np.interp(time, self.time, column) for column in self.gap.T])


def run(bearing: LinearBearing, angles: Array, loads: Array, gap: Array, duration: float, fast: bool = True) -> ChainMotion:
    """Motion over ``duration`` [s] from gaps ``(N-1,)`` >= 0 [m]; angles and loads ``(N, 4)`` do not change.

    Generalises Lin Figure 3.16. Order is kept exactly: a gap never becomes negative. Raises ValueError for bad gaps.
    """
    gap = np.array(gap, dtype=float)
    if gap.shape != (len(angles) - 1,) or not np.all(gap >= 0.0) or not duration >= 0.0:
        raise ValueError("gaps must be N-1 numbers not below zero, the duration not negative")
    now, still = 0.0, STILL * abs(bearing.speed)
    times, gaps, results = [], [], []
    while True:
        result = solve(prepare(bearing, angles, loads, gap <= 0.0), fast=fast)
        times.append(now)
        gaps.append(gap.copy())
        results.append(result)
        if now >= duration:
            return ChainMotion(np.array(times), np.array(gaps), tuple(results))
        rate = np.diff(result.velocity)
        rate[(np.abs(rate) <= still) | ((gap <= 0.0) & (rate < 0.0))] = 0.0
        left = np.full(gap.shape, np.inf)
        closing = (rate < 0.0) & (gap > 0.0)
        left[closing] = gap[closing] / -rate[closing]
        step = min(duration - now, float(left.min(initial=np.inf)))
        gap = np.where(left <= step, 0.0, np.maximum(gap + step * rate, 0.0))
        now = duration if step >= duration - now else now + step
