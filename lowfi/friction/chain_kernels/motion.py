"""Motion of a chain of balls: order of the velocities, ball-to-ball friction."""

from math import sqrt
from typing import Any

import numpy as np

from lowfi.jit import kernel

from .energy import Problem, State, rebuild
from .law import Array
from .newton import descend, polish

#: Above this factor the steps of the continuation in eps are not shortened any more.
SHORTEST = 0.85


@kernel
def _push(problem: Problem, state: State, lam: Array, rho: float) -> float:
    """Take the augmented multipliers as contact forces ``lam``; returns the largest change."""
    change = 0.0
    for k in range(lam.shape[0]):
        push = max(0.0, lam[k] + rho * state[1][k, 0]) if problem[3][k] != 0.0 else 0.0
        change = max(change, abs(push - lam[k]))
        lam[k] = push
    return change


@kernel
def _order(
    problem: Problem, state: State, eps: float, lam: Array, grip: Array, rho: float, work: Any, tolerance: float,
    rounds: int,
) -> tuple[int, float]:  # fmt: skip
    """Minimum of the energy under v_k <= v_(k+1) at given friction bounds, multipliers in ``lam``.

    Returns iterations and the largest force out of balance or last change of a multiplier.
    """
    total, residual = 0, 0.0
    for _ in range(rounds):
        used, residual = descend(problem, state, eps, lam, grip, rho, work, tolerance, 200)
        total += used
        change = _push(problem, state, lam, rho)
        residual = max(residual, change)
        if change <= tolerance:
            break
    return total, residual


@kernel
def _couple(
    problem: Problem, state: State, eps: float, lam: Array, grip: Array, rho: float, work: Any, tolerance: float
) -> tuple[int, bool]:
    """Try ``polish`` from the present state; on success its forces become ``lam`` and ``grip``."""
    total = 0
    for _ in range(4):
        used, residual = polish(problem, state, eps, lam, rho, work, tolerance, 30)
        total += used
        if residual > tolerance:
            return total, False
        change = _push(problem, state, lam, rho)
        grip[:] = lam
        if change <= tolerance:
            break
    return total, True


@kernel
def _gap(lam: Array, grip: Array) -> float:
    size = 0.0
    for k in range(lam.shape[0]):
        size = max(size, abs(lam[k] - grip[k]))
    return size


@kernel
def _regrip(lam: Array, grip: Array, memory: Array, top: float, halve: bool) -> None:
    """Next friction bounds: per pair a secant step on lam(grip) = grip, kept in the bracket, now and then its middle.

    memory ``(4, N-1)``: grip and lam of the last round, lower and upper end of the bracket. lam falls where friction
    grows, steeply where balls near two-point contact begin to stick to each other: repetition would not settle there.
    """
    for k in range(lam.shape[0]):
        excess, d_grip = lam[k] - grip[k], grip[k] - memory[0, k]
        if excess > 0.0:
            memory[2, k] = grip[k]
        else:
            memory[3, k] = grip[k]
        low, high = memory[2, k], memory[3, k]
        if high - low <= 4e-16 * top and abs(excess) > 0.0:  # neighbours have moved the root out of its bracket
            low, high = max(0.0, grip[k] - 10.0 * abs(excess)), min(top, grip[k] + 10.0 * abs(excess))
            memory[2, k], memory[3, k] = low, high
        slope = (lam[k] - memory[1, k]) / d_grip if d_grip != 0.0 else 0.0
        memory[0, k], memory[1, k] = grip[k], lam[k]
        new = grip[k] + (excess / (1.0 - slope) if slope < 0.9 else excess)
        if excess != 0.0:
            grip[k] = new if low < new < high and not (halve and high < top) else 0.5 * (low + high)


@kernel
def _continue(problem: Problem, state: State, lam: Array, grip: Array, work: Any, eps_end: float) -> int:
    """Bring state, forces and friction bounds from smooth friction (eps 0.1) to just above ``eps_end``.

    Steps in eps are shortened where the coupled equations do not follow; where no step helps, the bounds lag.
    """
    drift = state[2]
    kept, kept_lam, kept_grip = drift.copy(), lam.copy(), grip.copy()
    total, eps, factor = 0, 1.0, 0.1
    while factor * eps > eps_end:
        rebuild(problem, state)
        rho = 100.0 / (factor * eps)  # stiffer than sticking contacts, else the multipliers creep
        used, _ = _order(problem, state, factor * eps, lam, grip, rho, work, 1e-6, 1)
        total += used
        done = True
        if problem[4] > 0.0 and lam.shape[0] > 0:
            used, done = _couple(problem, state, factor * eps, lam, grip, rho, work, 1e-6)
            total += used
        if done or factor > SHORTEST:
            eps *= factor
            factor = max(0.1, factor * factor) if done else 0.1
            kept[:], kept_lam[:], kept_grip[:] = drift, lam, grip
        else:
            factor = sqrt(factor)
            drift[:], lam[:], grip[:] = kept, kept_lam, kept_grip
    return total


@kernel
def solve(
    problem: Problem, state: State, lam: Array, grip: Array, work: Any, eps: float, tolerance: float, rounds: int
) -> tuple[int, float, float]:
    """Motion of all balls at creeping speed ``eps``: order by multipliers, ball-to-ball friction coupled or lagged.

    The first step has no ball-to-ball friction, so that a convex problem alone decides where the answer starts from:
    at high mu a jammed state may exist beside the one that develops from there.
    lam ``(N-1,)``: contact forces out; grip: the forces that bound the friction. Returns Newton iterations, largest
    force out of balance, and largest difference of contact force and friction bound, both per unit bound.
    """
    rho, residual, top = 100.0 / eps, 1.0, float(problem[0].shape[0])
    memory = np.zeros((4, lam.shape[0]))
    memory[3] = top
    total = _continue(problem, state, lam, grip, work, eps)
    rebuild(problem, state)
    for i in range(rounds):
        used, residual = _order(problem, state, eps, lam, grip, rho, work, tolerance, 20)
        total += used
        if _gap(lam, grip) <= tolerance:
            break
        if i % 8 == 1:
            used, done = _couple(problem, state, eps, lam, grip, rho, work, tolerance)
            total += used
            if done:
                continue
        _regrip(lam, grip, memory, top, i % 3 == 2)
    return total, residual, _gap(lam, grip)
