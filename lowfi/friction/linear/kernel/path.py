"""Solutions followed from no friction between balls to the whole of it, round the folds of their path.

A contact force is the sum of the axial friction on the balls behind it, so that no force on the path can exceed the
sum of their bounds, and the path begins at the one solution of a convex problem. It cannot run off to infinity nor
come back: its other end is a solution with the whole friction (Leray and Schauder), whatever folds lie between.
"""

from math import exp, log, sqrt

import numpy as np

from rollbench.lowfi.friction.linear.kernel_types import Array, ChainArrays, ChainPoint, Smoothing, Work
from rollbench.lowfi.jit import kernel

from .equations import assemble, copied, restore, shift, solve_banded
from .newton import largest, semismooth_newton

#: Creeping speed at the beginning of the path.
FIRST = 0.1
#: Residual that counts as being on the path, and most Newton steps back to it.
ON_PATH, STEPS = 1e-9, 7
#: Step of the parameter to differentiate by it.
DIFFERENCE = 1e-6
#: Distance of points that belong to the same path whatever the step's length: what the residual leaves open at folds.
NEAR = 1e-4
#: First and shortest length of a step, and the one below which a kink may turn the path.
LENGTH, SHORTEST, KINK = 0.05, 1e-9, 1e-5


@kernel
def stage(s: float, eps: float) -> Smoothing:
    """Law at parameter s of the path, 0 to 1: friction between balls comes early, creeping speeds fall to ``eps``.

    Springs keep motions without resistance in place where forces are known to no more than ``ON_PATH``.
    """
    rest = (1.0 - s) ** 4
    creep = FIRST * exp(s * log(eps / FIRST))
    return Smoothing(creep, 1.0 - rest * rest, 1e-3 * exp(s * log(1e-11)), 1e-2 * exp(s * log(1e-7)))


@kernel
def convex_sign(point: ChainPoint) -> float:
    """Sign of the Jacobian's determinant without friction between balls: each force and the idle row turn it."""
    return 1.0 if point.drift.shape[0] % 2 == 0 else -1.0


@kernel
def _tangent(chain: ChainArrays, point: ChainPoint, s: float, eps: float, work: Work, change: Array, tau: Array) -> float:
    """Tangent tau of the path, four entries a ball and last s, unit length, s rising; 1 if the path goes on so, or -1.

    Needs ``work`` as assembled at the point; change: the residual's derivative by s.
    """
    K, factors, g, _, other = work
    assemble(chain, point, stage(s + DIFFERENCE, eps), factors, other)
    n = g.shape[0]
    for i in range(n):
        change[i] = (other[i] - g[i]) / DIFFERENCE
        tau[i] = -change[i]
        other[i] = 0.0
    tau[n] = 1.0
    sign = solve_banded(K, factors, tau[:n], other)
    tau /= sqrt(np.dot(tau, tau))
    return sign * convex_sign(point)


@kernel
def _correct(
    chain: ChainArrays,
    point: ChainPoint,
    s: float,
    eps: float,
    work: Work,
    change: Array,
    tau: Array,
    length: float,
    fixed: bool,
) -> tuple[bool, int, float]:
    """Newton steps back to the path, across tau or, fixed, at the same s; whether they arrived, how many, and s.

    Given up where they lead farther than most of the step's ``length``: it may be another path.
    """
    K, factors, g, step, other = work
    n, moved = g.shape[0], 0.0
    for newton in range(STEPS + 1):
        law = stage(s, eps)
        assemble(chain, point, law, K, g)
        if largest(g) <= max(ON_PATH, 1e-5 * law.eps):
            return True, newton, s
        step[:] = -g
        other[:] = -change
        solve_banded(K, factors, step, other)
        ds = 0.0 if fixed else -np.dot(tau[:n], step) / (tau[n] + np.dot(tau[:n], other))
        step += ds * other
        moved += sqrt(np.dot(step, step) + ds * ds)
        if newton == STEPS or not moved <= 0.7 * max(length, NEAR):
            break
        shift(chain, point, step, 1.0)
        s += ds
    return False, STEPS, s


@kernel
def _cap(tau: Array) -> float:
    """Longest step: what moves no velocity by more than 0.5 and s by more than 0.1."""
    n = tau.shape[0] - 1
    return float(1.0 / max(abs(tau[n]) / 0.1, np.max(np.abs(tau[:n].reshape(-1, 4)[:, :3])) / 0.5))


@kernel
def trace(chain: ChainArrays, point: ChainPoint, eps: float, work: Work, limit: int) -> tuple[int, bool]:
    """Follow the path from a point near its beginning; returns Newton steps and whether its end was reached.

    The determinant's sign tells which way is on: it changes where s turns.
    """
    n: int = work.g.shape[0]
    change, tau, ahead = np.zeros(n), np.zeros(n + 1), np.zeros(n + 1)
    total, left = semismooth_newton(chain, point, stage(0.0, eps), work, 0.1 * ON_PATH, int(np.int64(100)), 1.0)
    if not left <= ON_PATH:
        return total, False
    _tangent(chain, point, 0.0, eps, work, change, tau)
    kept = copied(point)
    s, length = 0.0, LENGTH
    while total < limit and length > SHORTEST:
        length = min(length, _cap(tau))
        last = s + length * tau[n] >= 1.0
        if last:
            length = (1.0 - s) / tau[n]
        shift(chain, point, tau, length)
        good, used, found = _correct(chain, point, s + length * tau[n], eps, work, change, tau, length, last)
        total += used
        if good and last:
            return total, True
        if good and -0.01 < found < 1.0:
            ahead *= _tangent(chain, point, found, eps, work, change, ahead)
            total += 1
            good = np.dot(tau, ahead) > 0.5 or length < KINK
        else:
            good = False
        if good:
            restore(kept, point)
            tau[:], s = ahead, found
            length *= 2.0 if used < 3 else (1.3 if used == 3 else 0.8)
        else:
            restore(point, kept)
            length *= 0.4
    return total, False
