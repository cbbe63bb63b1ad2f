"""Axial equilibrium of the balls between screw and nut: force of one ball, Newton's method, many screws with errors.

Three interpretations of Liu's equation of the contact angle are implemented. Newton's method starts from the solution for
rigid bodies; each step solves a tridiagonal system.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.jit import kernel

#: Array of floats.
Array = NDArray[Any]

#: Numbers of the laws of the contact angle: constant; by Liu's implicit equation (10); by the exact geometry of the groove
#: centres.
CONSTANT, IMPLICIT, EXACT = 0, 1, 2


@kernel
def _implicit_approach(v: float, error: float, p: Array) -> tuple[float, float, float]:
    """Return a ball's approach [m], sine of its contact angle, and d(approach)/dv, by Liu's equations (10) and (14).

    The equation solved is approach = error + v sin(angle(approach)). v: axial motion of the groove times the cosine of the
    lead angle [m]; error: oversize of the ball [m]; p (5,): Hertz stiffness [N/m^1.5], distance A of the groove centres
    [m], sine and cosine of the unloaded contact angle, cosine of the lead angle.
    """
    a = p[1] - error
    approach = error + v * p[2]
    sine, rate = p[2], 0.0
    for _ in range(8):
        grown = a + approach
        cosine = a * p[3] / grown
        sine = sqrt(1.0 - cosine * cosine)
        rate = cosine * cosine / (sine * grown)
        step = (approach - error - v * sine) / (1.0 - v * rate)
        approach -= step
        if abs(step) <= 1e-15 * p[1]:
            break
    return approach, sine, sine / (1.0 - v * rate)


@kernel
def _exact_approach(v: float, error: float, p: Array) -> tuple[float, float, float]:
    """Return a ball's approach [m], sine of its contact angle, and d(approach)/dv, by the exact groove geometry.

    The approach follows from the distance of the groove centres, whose offset across the axis is constant. v: axial motion
    of the groove times the cosine of the lead angle [m]; error: oversize of the ball [m]; p (5,): Hertz stiffness
    [N/m^1.5], distance A of the groove centres [m], sine and cosine of the unloaded contact angle, cosine of the lead
    angle.
    """
    along, across = p[1] * p[2] + v, p[1] * p[3]
    distance = sqrt(along * along + across * across)
    sine = along / distance
    # distance - A without cancellation
    grown = v * (2.0 * p[1] * p[2] + v) / (distance + p[1])
    return grown + error, sine, sine


@kernel
def ball_force(u: float, error: float, law: int, p: Array) -> tuple[float, float, float]:
    """Return one ball's contact load [N], axial force [N], and the derivative of the axial force by its motion u [N/m].

    u: axial motion of the groove [m]; error: oversize of the ball [m]; law: number of the rule by which the contact angle
    changes under load (``CONSTANT``, ``IMPLICIT`` or ``EXACT``); p (5,): Hertz stiffness [N/m^1.5], distance A of the
    groove centres [m], sine and cosine of the unloaded contact angle, cosine of the lead angle. All three results are zero
    without contact.
    """
    v = u * p[4]
    approach, sine, slope = error + v * p[2], p[2], p[2]
    if law == EXACT:
        approach, sine, slope = _exact_approach(v, error, p)
    elif law == IMPLICIT and approach > 0.0:
        # in (10) the approach has the sign of that at a constant angle
        approach, sine, slope = _implicit_approach(v, error, p)
    if approach <= 0.0:
        return 0.0, 0.0, 0.0
    # d(sine)/dv, the groove centres being A - error + approach apart
    turn = (1.0 - sine * sine) * slope / (sine * (p[1] - error + approach)) if law != CONSTANT else 0.0
    root = sqrt(approach)
    load = p[0] * approach * root
    return load, load * sine * p[4], (1.5 * p[0] * root * slope * sine + load * turn) * p[4] * p[4]


#: Number of Newton steps after which the iteration ends without convergence.
MAX_ITERATIONS = 60

#: Largest error of a ball's axial force, as a ratio to the axial load of the screw, that counts as converged.
TOLERANCE = 1e-10


@kernel
def _motion_of_rigid_bodies(errors: Array, load: float, p: Array) -> float:
    """Return the axial motion of the nut [m] if screw and nut are rigid and the contact angle is constant.

    At this motion the axial forces of the balls add up to the load or at most 1 % more, so that at least one ball is
    loaded. errors (M,): oversize of the balls [m]; load: axial load [N]; p: constants as in `ball_force`.
    """
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
def solve_by_newton(
    errors: Array, load: float, segments: Array, law: int, p: Array, u: Array, work: Array
) -> tuple[int, float, float]:
    """Solve the axial equilibrium of all balls of one screw by Newton's method (equations of `lowfi.random_errors.chain`).

    errors (M,): oversize of the balls [m]; load: axial load [N]; segments (M,): compliance of screw and nut between each
    ball and the preceding one [m/N]; law, p: as in `ball_force`; u (M,): axial motions at the balls [m], the result; work
    (3, M): work arrays, the first with the contact loads [N] at the end. Returns the number of steps; the residual, which
    is the largest unbalanced axial force on a ball as a fraction of the load; and the stiffness [N/m], the derivative of
    the load by the axial motion at ball 1.
    """
    m = errors.size
    loads, s, t = work[0], work[1], work[2]
    u[m - 1] = _motion_of_rigid_bodies(errors, load, p)
    for j in range(m - 1, 0, -1):
        # the motion of rigid bodies plus the stretch if all balls carried the same load
        u[j - 1] = u[j] + segments[j] * load * (m - j) / m
    forces = np.empty(m)
    worst = np.inf
    for iteration in range(MAX_ITERATIONS + 1):
        behind_s, behind_t = 0.0, 0.0
        worst = 0.0
        for j in range(m - 1, -1, -1):
            load_j, force, rate = ball_force(u[j], errors[j], law, p)
            if iteration > 0:
                worst = max(worst, abs(force - forces[j]))
            loads[j] = load_j
            s[j] = rate + behind_s
            t[j] = force - rate * u[j] + behind_t
            forces[j] = force
            soft = 1.0 / (1.0 + segments[j] * s[j])
            behind_s, behind_t = s[j] * soft, t[j] * soft
        if (iteration > 0 and worst <= TOLERANCE * load) or iteration == MAX_ITERATIONS:
            break
        # forward: the motion of ball 1 from the whole load, then ball by ball; forces becomes what the step expects
        tail = load
        moved = (load - t[0]) / s[0]
        for j in range(m):
            rest, soft = 0.0, 0.0
            if j + 1 < m:
                soft = segments[j + 1]
                rest = (s[j + 1] * moved + t[j + 1]) / (1.0 + soft * s[j + 1])
            u[j] = moved
            forces[j] = tail - rest
            tail = rest
            moved -= soft * rest
    return iteration, worst / load, s[0]


@kernel
def solve_batch(errors: Array, loads: Array, segments: Array, law: int, p: Array, out: Array) -> None:
    """Solve n screws with errors of their M balls under each of L axial loads, and write the results to ``out``.

    errors (n, M): oversize of the balls [m]; loads (L,) [N]; segments (M,): compliance of screw and nut between each ball
    and the preceding one [m/N]; law, p: as in `ball_force`. out (n, L, 7): smallest and largest contact load [N], number of
    loaded balls, axial motion at ball 1 and at the first loaded ball [m], derivative of the load by the motion at ball 1
    [N/m], and largest unbalanced axial force on a ball as a fraction of the load.
    """
    n, m = errors.shape
    u, work = np.empty(m), np.empty((3, m))
    for i in range(n):
        for k in range(loads.size):
            _, residual, stiffness = solve_by_newton(errors[i], loads[k], segments, law, p, u, work)
            q = work[0]
            first, count = -1, 0
            for j in range(m):
                if q[j] > 0.0:
                    count += 1
                    if first < 0:
                        first = j
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = q.min(), q.max(), count
            out[i, k, 3], out[i, k, 4] = u[0], u[first]
            out[i, k, 5], out[i, k, 6] = stiffness, residual
