"""Newton's method on the energy of a chain and on its coupled equations."""

from typing import Any

from lowfi.jit import kernel

from .energy import HALF, Problem, State, assemble, move, solve_banded
from .law import Array

#: Longest step of a velocity: longer ones, back and forth in the line search, would cost digits.
LONGEST = 2.0


@kernel
def _largest(x: Array) -> float:
    size = 0.0
    for i in range(x.shape[0]):
        size = max(size, abs(x[i]))
    return size


@kernel
def _dot(x: Array, y: Array) -> float:
    """Product of the motions' rows; the rows of forces carry no residual."""
    total = 0.0
    for i in range(x.shape[0]):
        if i % 4 != 3:
            total += x[i] * y[i]
    return total


@kernel
def _direction(K: Array, factors: Array, g: Array, step: Array) -> float:
    """Newton's step by K, damped where round-off spoils it; returns the slope of the energy along it, negative."""
    damping, top = 0.0, 0.0
    for i in range(g.shape[0]):
        top = max(top, K[i, HALF])
    slope, longest = 0.0, 0.0
    for _ in range(9):
        factors[:] = K
        step[:] = -g
        for i in range(g.shape[0]):
            if i % 4 != 3:
                factors[i, HALF] += damping
        solve_banded(factors, step)
        slope = _dot(g, step)
        if slope < 0.0:
            break
        damping = max(1e-15 * top, 100.0 * damping)
    for i in range(g.shape[0]):
        if i % 4 != 3:
            longest = max(longest, abs(step[i]))
    if longest > LONGEST:
        step *= LONGEST / longest
        slope *= LONGEST / longest
    return slope


@kernel
def descend(
    problem: Problem, state: State, eps: float, lam: Array, grip: Array, rho: float, work: Any, tolerance: float,
    limit: int,
) -> tuple[int, float]:  # fmt: skip
    """Newton's method with line search on the convex energy; returns iterations and largest force out of balance."""
    K, factors, g, step = work
    energy = assemble(problem, state, eps, lam, grip, rho, False, K, g)
    for iteration in range(limit):
        residual = _largest(g)
        if residual <= tolerance:
            return iteration, residual
        slope = _direction(K, factors, g, step)
        if not slope < 0.0:
            return iteration, residual
        t, at = 1.0, 0.0
        for _ in range(60):
            move(problem, state, step, t - at)
            at = t
            trial = assemble(problem, state, eps, lam, grip, rho, False, K, g)
            if trial <= energy + 1e-4 * t * slope + 1e-14 * abs(energy):  # the last term is round-off
                break
            t *= min(0.7, max(0.1, slope / (slope - _dot(g, step))))
        energy = trial
    return limit, _largest(g)


@kernel
def polish(
    problem: Problem, state: State, eps: float, lam: Array, rho: float, work: Any, tolerance: float, limit: int
) -> tuple[int, float]:
    """Semismooth Newton's method on the coupled equations (friction bounded by the contact force itself).

    Goes on only while the force out of balance falls; returns iterations and that force.
    """
    K, factors, g, step = work
    assemble(problem, state, eps, lam, lam, rho, True, K, g)
    residual = _largest(g)
    for iteration in range(limit):
        if residual <= tolerance:
            return iteration, residual
        _direction(K, factors, g, step)
        t, at, trial = 1.0, 0.0, residual
        for _ in range(12):
            move(problem, state, step, t - at)
            at = t
            assemble(problem, state, eps, lam, lam, rho, True, K, g)
            trial = _largest(g)
            if trial < (1.0 - 0.1 * t) * residual:
                break
            t *= 0.5
        if not trial < residual:
            move(problem, state, step, -at)
            return iteration, residual
        residual = trial
    return limit, residual
