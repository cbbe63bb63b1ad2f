"""Motion of a chain of balls: order of the velocities, ball-to-ball friction."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.linear.records import Array, ChainArrays, ChainPoint, ChainState, Smoothing, Work
from rollbench.lowfi.jit import kernel

from .band import solve_banded
from .coupled import copied, reopen, restore
from .energy import rebuild
from .newton import descend, leap, semismooth_newton
from .path import FIRST, convex_sign, trace

#: Stiffness towards nominal rolling per creeping speed, until the last: motions without resistance stay in place.
SPRING = 1e-3
#: Friction between balls, over that of the grooves, up to which Newton's method may try without the path, and up to
#: which it may take more than ``FEW`` steps at a creeping speed: beyond, the solution it found was at times another.
#: Forces of N - 1 contacts that push at random add up like the root of their number.
LARGE, SLIGHT = 0.8, 0.3
#: Contacts of a ball without which it has a motion that meets no resistance.
SUPPORTS = 3
#: Most damping of velocities at the end, and most whole steps.
FIRMEST, LEAPS = 1.0, 20
#: Residual that counts as converged between creeping speeds, and most Newton steps at one of them.
COARSE, FEW, MANY = 1e-6, 8, 60
#: Starts of the search for other solutions, and the force that presses pairs in one of them, over the largest friction
#: bound of a ball.
STARTS, PRESSED = 3, 3.0


@kernel
def _order(chain: ChainArrays, state: ChainState, lam: Array, work: Work) -> int:
    """Least energy under v_k <= v_(k+1) without friction between balls at eps ``FIRST``, multipliers in ``lam``."""
    total, rho = 0, 100.0 / FIRST
    for _ in range(20):
        used, _ = descend(chain, state, FIRST, lam, rho, work, 1e-10, 200)
        total += used
        change = 0.0
        for k in range(lam.shape[0]):
            push = max(0.0, lam[k] + rho * state.pair[k, 0]) if chain.closed[k] != 0.0 else 0.0
            change = max(change, abs(push - lam[k]))
            lam[k] = push
        if change <= COARSE:
            break
    return total


@kernel
def _supported(contacts: Array) -> bool:
    """Whether every ball has at least ``SUPPORTS`` loaded contacts."""
    for j in range(contacts.shape[0]):
        count = 0
        for i in range(contacts.shape[1]):
            if contacts[j, i, 3] > 0.0:
                count += 1
        if count < SUPPORTS:
            return False
    return True


@kernel
def _pressed(z: Array) -> int:
    """Number of contacts under force."""
    count = 0
    for k in range(z.shape[0]):
        if z[k] > 0.0:
            count += 1
    return count


@kernel
def _descend_eps(chain: ChainArrays, point: ChainPoint, work: Work, eps_end: float, limit: int) -> tuple[int, bool]:
    """Coupled equations at creeping speeds from ``FIRST`` to ``eps_end``, the whole friction from the beginning.

    Returns Newton steps and whether all went well: a determinant of the other sign tells of another branch.
    """
    total, eps = 0, FIRST
    while True:
        reopen(point, eps)
        used, left = semismooth_newton(chain, point, Smoothing(eps, 1.0, 0.0, SPRING * eps), work, COARSE, limit, 0.0)
        total += used
        if not left <= COARSE:
            return total, False
        if eps <= eps_end:
            break
        eps = max(eps_end, 0.1 * eps)
    return total, solve_banded(work.K, work.factors, work.step, work.other) == convex_sign(point)


@kernel
def chain_motion(
    chain: ChainArrays, state: ChainState, z: Array, work: Work, eps: float, tolerance: float, limit: int
) -> tuple[int, float]:
    """Motion of all balls at creeping speed ``eps`` and forces max(z, 0); Newton steps and largest residual.

    The first step has no ball-to-ball friction, so that a convex problem alone decides where the answer starts from.
    Where friction between balls may bring further solutions, and where Newton's method does not follow from there at
    once while creeping speeds fall, the path by ``trace`` decides, unless the balls all part without that friction.
    """
    point = ChainPoint(state.slip, state.pair, state.drift, z)
    contacts, shapes, nodes, closed, mu, hold, nominal = chain
    rebuild(chain, state)
    firm = ChainArrays(contacts, shapes, nodes, closed, mu, hold + SPRING * FIRST, nominal)
    total = _order(firm, state, z, work)
    first = copied(point)
    share = mu * sqrt(z.shape[0])
    good = mu == 0.0 or (share <= LARGE and _supported(contacts))
    if good:
        used, good = _descend_eps(chain, point, work, eps, FEW if share > SLIGHT else MANY)
        total += used
    if not good:
        restore(point, first)
        without = ChainArrays(contacts, shapes, nodes, closed, 0.0, hold, nominal)
        used, good = _descend_eps(without, point, work, eps, int(np.int64(MANY)))
        total += used
        good = good and _pressed(z) == 0
    if not good:
        restore(point, first)
        used, _ = trace(chain, point, eps, work, limit)
        total += used
        reopen(point, eps)
    used, residual = _settle(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def other_motion(
    chain: ChainArrays, state: ChainState, z: Array, work: Work, eps: float, tolerance: float, limit: int, start: int
) -> tuple[int, float]:
    """As ``chain_motion``, from another of ``STARTS`` starts: the end of the path, the balls as they are without friction
    between them, all pairs pressed together."""
    point = ChainPoint(state.slip, state.pair, state.drift, z)
    contacts, shapes, nodes, closed, _, hold, nominal = chain
    rebuild(chain, state)
    total = _order(ChainArrays(contacts, shapes, nodes, closed, 0.0, hold + SPRING * FIRST, nominal), state, z, work)
    if start == 0:
        used, _ = trace(chain, point, eps, work, limit)
    elif start == 1:
        without = ChainArrays(contacts, shapes, nodes, closed, 0.0, hold, nominal)
        used, _ = _descend_eps(without, point, work, eps, int(np.int64(MANY)))
    else:
        for k in range(z.shape[0]):
            z[k] = PRESSED * closed[k]
        used, _ = _descend_eps(chain, point, work, eps, int(np.int64(MANY)))
    total += used
    reopen(point, eps)
    used, residual = _settle(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def motion_from(
    chain: ChainArrays, state: ChainState, z: Array, work: Work, eps: float, tolerance: float
) -> tuple[int, float]:
    """As ``chain_motion``, by Newton's method alone from the state given, one of a similar chain."""
    point = ChainPoint(state.slip, state.pair, state.drift, z)
    reopen(point, eps)
    return _settle(chain, point, work, eps, tolerance)


@kernel
def _settle(chain: ChainArrays, point: ChainPoint, work: Work, eps: float, tolerance: float) -> tuple[int, float]:
    """Newton steps on the exact equations from the point, and the largest residual."""
    exact = Smoothing(eps, 1.0, 0.0, 0.0)
    total, residual = semismooth_newton(chain, point, exact, work, tolerance, int(np.int64(100)), FIRMEST)
    if residual > tolerance:
        used, residual = leap(chain, point, exact, work, tolerance, LEAPS)
        total += used
    return total, residual
