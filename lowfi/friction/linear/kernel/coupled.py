"""Equations of a chain with friction between balls that the contact force itself bounds.

A contact's unknown z is its force where it is positive and, turned round, the rate of its gap where it is negative:
F = max(z, 0), rate = max(-z, 0) are complementary by themselves. Smoothed, F rate = ``smooth`` instead of zero. Exact,
the rate is in units of eps, what sticking contacts yield to a force, so that Newton's method passes z = 0 with ease.
"""

from math import sqrt

from rollbench.lowfi.friction.linear.records import Array, ChainArrays, ChainPoint, ChainState, Smoothing
from rollbench.lowfi.jit import kernel

from .band import HALF
from .energy import add_contacts, move


@kernel
def push_and_rate(z: float, smooth: float) -> tuple[float, float, float]:
    """Contact force, rate of the gap, and the force's slope; force - rate = z, force times rate = ``smooth``."""
    if smooth == 0.0:
        return max(z, 0.0), max(-z, 0.0), 1.0 if z > 0.0 else 0.0
    root = sqrt(z * z + 4.0 * smooth)
    larger = 0.5 * (abs(z) + root)
    if z > 0.0:
        return larger, smooth / larger, larger / root
    return smooth / larger, larger, smooth / (larger * root)


@kernel
def _add_rubbing(eps: float, bound: float, slope: float, k: int, pair: Array, K: Array, g: Array) -> None:
    """Friction between balls k and k+1 that slide at ``pair[k, 1:]``; slope: growth of its bound with z."""
    i, tx, ty = 4 * k, pair[k, 1], pair[k, 2]
    eta = sqrt(tx * tx + ty * ty + eps * eps)
    across = (tx / eta, ty / eta)
    for a in range(2):
        for row in (i + 1 + a, i + 5 + a):
            g[row] += bound * across[a]
            K[row, HALF + i + 3 - row] += slope * across[a]
            for b in range(2):
                h = bound * ((1.0 if a == b else 0.0) - across[a] * across[b]) / eta
                for column in (i + 1 + b, i + 5 + b):
                    K[row, HALF + column - row] += h


@kernel
def assemble(chain: ChainArrays, point: ChainPoint, law: Smoothing, K: Array, g: Array) -> None:
    """Forces out of balance and gaps' equations g ``(4N,)``, and their Jacobian K ``(4N, 11)``."""
    slip, pair, drift, z = point
    eps, share, smooth, spring = law
    closed, mu, hold = chain.closed, chain.mu, chain.hold
    K[:] = 0.0
    for j in range(drift.shape[0]):
        stiffness = hold[j] + spring
        for k in range(3):
            g[4 * j + k] = stiffness * drift[j, k]
            K[4 * j + k, HALF] = stiffness
        g[4 * j + 3] = 0.0
        K[4 * j + 3, HALF] = -1.0
    add_contacts(chain, ChainState(slip, pair, drift), eps, K, g)
    for k in range(closed.shape[0]):
        i = 4 * k + 3
        if closed[k] == 0.0:
            g[i] = -z[k]
            continue
        force, rate, slope = push_and_rate(z[k], smooth)
        g[i - 3] += force
        g[i + 1] -= force
        K[i - 3, HALF + 3] += slope
        K[i + 1, HALF - 1] -= slope
        stiff, scale = 1.0, 1.0
        if smooth == 0.0:
            stiff, scale = 1.0 / eps, 1.0 / (1.0 + rate)
        g[i] = scale * (stiff * pair[k, 0] + rate)
        K[i, HALF - 3] = scale * stiff
        K[i, HALF + 1] = -scale * stiff
        K[i, HALF] = scale * (slope - 1.0)
        if share * mu > 0.0:
            _add_rubbing(eps, mu * share * force, mu * share * slope, k, pair, K, g)


@kernel
def shift(chain: ChainArrays, point: ChainPoint, step: Array, t: float) -> None:
    """Add t times the step of the unknowns, four a ball, to the point."""
    slip, pair, drift, z = point
    move(chain, ChainState(slip, pair, drift), step, t)
    for k in range(z.shape[0]):
        z[k] += t * step[4 * k + 3]


@kernel
def reopen(point: ChainPoint, eps: float) -> None:
    """Take z of open gaps from their rates, in the units of exact complementarity at ``eps``."""
    for k in range(point.z.shape[0]):
        if point.z[k] <= 0.0:
            point.z[k] = min(0.0, point.pair[k, 0] / eps)


@kernel
def copied(point: ChainPoint) -> ChainPoint:
    """A copy of the point."""
    return ChainPoint(point.slip.copy(), point.pair.copy(), point.drift.copy(), point.z.copy())


@kernel
def restore(point: ChainPoint, kept: ChainPoint) -> None:
    """Overwrite the point by ``kept``: moving back by increments would leave round-off in the slips."""
    point.slip[:], point.pair[:], point.drift[:], point.z[:] = kept
