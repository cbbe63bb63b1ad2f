"""Newton's method on the equations of a chain."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.linear.kernel_types import Array, ChainArrays, ChainPoint, Smoothing, Work
from rollbench.lowfi.jit import kernel

from .equations import HALF, assemble, copied, restore, shift, solve_banded

#: Longest step of a velocity: longer ones, back and forth in the line search, would cost digits.
LONGEST = 2.0
#: Least damping of velocities.
SOFTEST = 1e-14


@kernel
def largest(x: Array) -> float:
    """Largest size of an entry; nan where there is one."""
    size = 0.0
    for i in range(x.shape[0]):
        if not abs(x[i]) <= size:
            size = abs(x[i])
    return size


@kernel
def _reach(step: Array) -> float:
    """Part of the step after which no velocity has changed by more than ``LONGEST``."""
    return float(LONGEST / max(LONGEST, np.max(np.abs(step.reshape(-1, 4)[:, :3]))))


@kernel
def semismooth_newton(
    chain: ChainArrays, point: ChainPoint, law: Smoothing, work: Work, tolerance: float, limit: int, firmest: float
) -> tuple[int, float]:
    """Semismooth Newton's method on the coupled equations, steps halved until the residual falls.

    Where it does not, velocities are damped by up to ``firmest``: steps of motions without resistance are noise.
    Returns iterations and the largest residual; leaves ``work`` as assembled at the point.
    """
    K, factors, g, step, other = work
    assemble(chain, point, law, K, g)
    size, damping = sqrt(np.dot(g, g)), 0.0
    for iteration in range(limit):
        if largest(g) <= tolerance:
            return iteration, largest(g)
        for i in range(g.shape[0]):
            if i % 4 != 3:
                K[i, HALF] += damping
        step[:] = -g
        solve_banded(K, factors, step, other)
        t, at, trial = _reach(step), 0.0, size
        for _ in range(12):
            shift(chain, point, step, t - at)
            at = t
            assemble(chain, point, law, K, g)
            trial = sqrt(np.dot(g, g))
            if trial < (1.0 - 0.1 * t) * size:
                break
            t *= 0.5
        if trial < size:
            size = trial
            if t > 0.2 or firmest == 0.0:
                damping *= 0.1
            else:
                damping = min(firmest, max(SOFTEST, 100.0 * damping))
            continue
        shift(chain, point, step, -at)
        assemble(chain, point, law, K, g)
        damping = max(SOFTEST, 100.0 * damping)
        if not damping <= firmest:
            return iteration, largest(g)
    return limit, largest(g)


@kernel
def leap(
    chain: ChainArrays, point: ChainPoint, law: Smoothing, work: Work, tolerance: float, limit: int
) -> tuple[int, float]:
    """Undamped Newton steps on the coupled equations: at kinks the residual rises before it falls.

    Returns iterations and the largest residual; the point is left where it was if that has not fallen.
    """
    K, factors, g, step, other = work
    assemble(chain, point, law, K, g)
    start, kept = largest(g), copied(point)
    for iteration in range(limit):
        step[:] = -g
        solve_banded(K, factors, step, other)
        shift(chain, point, step, _reach(step))
        assemble(chain, point, law, K, g)
        if largest(g) <= tolerance:
            return iteration + 1, largest(g)
    if not largest(g) < start:
        restore(point, kept)
        return limit, start
    return limit, largest(g)
