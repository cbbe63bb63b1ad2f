"""Motion of a chain of balls: without friction between balls, then with all of it."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.linear.kernel_types import Array, ChainArrays, ChainPoint, Smoothing, Work
from rollbench.lowfi.jit import kernel

from .equations import copied, rebuild, reopen, restore, solve_banded
from .newton import leap, semismooth_newton
from .path import FIRST, convex_sign, trace

#: Stiffness towards nominal rolling per creeping speed, until the last: motions without resistance stay in place.
SPRING = 1e-3
#: Force times rate of a gap from which the order of the balls is sought.
ROUND = 1e-3
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
def _order(chain: ChainArrays, point: ChainPoint, work: Work) -> int:
    """The one solution without friction between balls at creeping speed ``FIRST``, from any drift; Newton steps."""
    rebuild(chain, point)
    total = 0
    for smooth in (ROUND, 0.0):
        law = Smoothing(FIRST, 0.0, smooth, SPRING * FIRST)
        used, _ = semismooth_newton(chain, point, law, work, 1e-10, int(np.int64(200)), FIRMEST)
        total += used
    return total


@kernel
def _supported(contacts: Array) -> bool:
    """Whether every ball has at least ``SUPPORTS`` loaded contacts."""
    return bool(np.min((contacts[:, :, 3] > 0.0).sum(axis=1)) >= SUPPORTS)


@kernel
def _descend_eps(
    chain: ChainArrays, point: ChainPoint, work: Work, eps_end: float, share: float, limit: int
) -> tuple[int, bool]:
    """Equations at creeping speeds from ``FIRST`` to ``eps_end``, with a share of the friction between balls.

    Returns Newton steps and whether all went well: a determinant of the other sign tells of another branch.
    """
    total, eps = 0, FIRST
    while True:
        reopen(point, eps)
        used, left = semismooth_newton(chain, point, Smoothing(eps, share, 0.0, SPRING * eps), work, COARSE, limit, 0.0)
        total += used
        if not left <= COARSE:
            return total, False
        if eps <= eps_end:
            break
        eps = max(eps_end, 0.1 * eps)
    return total, solve_banded(work.K, work.factors, work.step, work.other) == convex_sign(point)


@kernel
def chain_motion(
    chain: ChainArrays, point: ChainPoint, work: Work, eps: float, tolerance: float, limit: int
) -> tuple[int, float]:
    """Motion of the balls and forces between them, from the drift of the point; returns iterations and largest residual.

    The first step has no ball-to-ball friction, so that only a convex problem decides where the answer starts from.
    Where friction between balls may bring further solutions, and where Newton's method does not follow from there at
    once while creeping speeds fall, the path by ``trace`` decides, unless the balls all part without that friction.
    """
    total = _order(chain, point, work)
    first = copied(point)
    share = chain.mu * sqrt(point.z.shape[0])
    good = chain.mu == 0.0 or (share <= LARGE and _supported(chain.contacts))
    if good:
        used, good = _descend_eps(chain, point, work, eps, 1.0, FEW if share > SLIGHT else MANY)
        total += used
    if not good:
        restore(point, first)
        used, good = _descend_eps(chain, point, work, eps, 0.0, int(np.int64(MANY)))
        total += used
        good = good and not np.any(point.z > 0.0)
    if not good:
        restore(point, first)
        used, _ = trace(chain, point, eps, work, limit)
        total += used
        reopen(point, eps)
    used, residual = _settle(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def other_motion(
    chain: ChainArrays, point: ChainPoint, work: Work, eps: float, tolerance: float, limit: int, start: int
) -> tuple[int, float]:
    """As ``chain_motion``, from another of ``STARTS`` starts: the end of the path, the balls as they are without friction
    between them, all pairs pressed together."""
    total = _order(chain, point, work)
    if start == 0:
        used, _ = trace(chain, point, eps, work, limit)
    elif start == 1:
        used, _ = _descend_eps(chain, point, work, eps, 0.0, int(np.int64(MANY)))
    else:
        point.z[:] = PRESSED * chain.closed
        used, _ = _descend_eps(chain, point, work, eps, 1.0, int(np.int64(MANY)))
    total += used
    reopen(point, eps)
    used, residual = _settle(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def motion_from(chain: ChainArrays, point: ChainPoint, work: Work, eps: float, tolerance: float) -> tuple[int, float]:
    """As ``chain_motion``, by Newton's method only, from the state given, one of a similar chain."""
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
