"""Newton's method of one chain of balls: start with rigid bodies, then a tridiagonal system a step."""

from __future__ import annotations

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel

from .ball import Array, ball

#: Newton steps after which a chain is given up.
MAX_ITERATIONS = 60
#: Largest error of a ball's force against the load of the screw.
TOLERANCE = 1e-10


@kernel
def _rigid(errors: Array, load: float, p: Array) -> float:
    """Motion [m] of rigid bodies, constant contact angle, to a hundredth of the load from above: some ball is loaded."""
    slope = p[2] * p[4]
    u = ((load / (slope * p[0] * errors.size)) ** (2.0 / 3.0) - errors.min()) / slope
    for _ in range(MAX_ITERATIONS):
        force, rate = 0.0, 0.0
        for error in errors:
            approach = error + slope * u
            if approach > 0.0:
                root = sqrt(approach)
                force += approach * root
                rate += root
        excess = slope * p[0] * force - load
        if excess <= 0.01 * load:
            break
        u -= excess / (1.5 * slope * slope * p[0] * rate)
    return float(u)


@kernel
def newton(
    errors: Array, load: float, compliance: float, law: int, p: Array, u: Array, work: Array
) -> tuple[int, float, float]:
    """Solve one chain; see ``lowfi.random_errors.chain`` for the equations.

    errors (M,): [m]; load: positive [N]; compliance: of a segment [m/N]; u (M,): result, motions [m]; work (3, M): its
    first row returns the contact loads [N], the others the affine law of the balls behind, T = s u + t.
    Returns Newton steps, the largest error of a ball's force over the load, and the stiffness dF/du_1 [N/m].
    """
    m = errors.size
    loads, s, t = work[0], work[1], work[2]
    u[m - 1] = _rigid(errors, load, p)
    for j in range(m - 1, 0, -1):
        # the stretch under equal shares, laid on the rigid motion
        u[j - 1] = u[j] + compliance * load * (m - j) / m
    forces = np.empty(m)
    worst = np.inf
    for iteration in range(MAX_ITERATIONS + 1):
        behind_s, behind_t = 0.0, 0.0
        worst = 0.0
        for j in range(m - 1, -1, -1):
            load_j, force, rate = ball(u[j], errors[j], law, p)
            if iteration > 0:
                worst = max(worst, abs(force - forces[j]))
            loads[j] = load_j
            s[j] = rate + behind_s
            t[j] = force - rate * u[j] + behind_t
            forces[j] = force
            soft = 1.0 / (1.0 + compliance * s[j])
            behind_s, behind_t = s[j] * soft, t[j] * soft
        if (iteration > 0 and worst <= TOLERANCE * load) or iteration == MAX_ITERATIONS:
            break
        # forward: the motion of ball 1 from the whole load, then ball by ball; forces becomes what the step expects
        tail = load
        moved = (load - t[0]) / s[0]
        for j in range(m):
            rest = (s[j + 1] * moved + t[j + 1]) / (1.0 + compliance * s[j + 1]) if j + 1 < m else 0.0
            u[j] = moved
            forces[j] = tail - rest
            tail = rest
            moved -= compliance * rest
    return iteration, worst / load, s[0]
