"""Dissipation of a body that touches others at elliptical contacts, and Newton's method for its minimum.

Unknown is the motion q (n,). Contact i sees (vx, vz, spin) = ``maps[i] @ q + drives[i]`` and has friction strength
mu F. The convex function is sum_i strength_i D_i(v_i; speed) - push . q.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.jit import kernel

from .dissipation import dissipation


@kernel
def evaluate(
    shape: Array, maps: Array, drives: Array, push: Array, speed: float, q: Array, grad: Array, hess: Array
) -> tuple[float, float]:
    """Value of the function at q and its part from the speed; writes gradient (n,) and Hessian (n, n).

    shape (m, 3): semi-axes a, b [m] and strength mu F [N]; maps (m, 3, n); drives (m, 3); push (n,).
    The second value is sum_i strength_i speed dD_i/dspeed, the excess of the function over the friction loss.
    """
    n = q.shape[0]
    value, excess = 0.0, 0.0
    for j in range(n):
        value -= push[j] * q[j]
        grad[j] = -push[j]
        for k in range(n):
            hess[j, k] = 0.0
    for i in range(shape.shape[0]):
        f = shape[i, 2]
        if f == 0.0:
            continue
        vx, vz, spin = drives[i, 0], drives[i, 1], drives[i, 2]
        for j in range(n):
            vx += maps[i, 0, j] * q[j]
            vz += maps[i, 1, j] * q[j]
            spin += maps[i, 2, j] * q[j]
        d, d_x, d_z, d_s, d_e, xx, xz, zz, xs, zs, ss = dissipation(shape[i, 0], shape[i, 1], vx, vz, spin, speed)
        value += f * d
        excess += f * speed * d_e
        for j in range(n):
            mx, mz, ms = f * maps[i, 0, j], f * maps[i, 1, j], f * maps[i, 2, j]
            grad[j] += mx * d_x + mz * d_z + ms * d_s
            h_x, h_z, h_s = mx * xx + mz * xz + ms * xs, mx * xz + mz * zz + ms * zs, mx * xs + mz * zs + ms * ss
            for k in range(j + 1):
                hess[j, k] += h_x * maps[i, 0, k] + h_z * maps[i, 1, k] + h_s * maps[i, 2, k]
    return value, excess


@kernel
def newton_step(hess: Array, grad: Array, units: Array, step: Array) -> None:
    """Writes the step (n,) of the lower triangle ``hess`` by Cholesky, pivots kept above a tiny fraction of the largest."""
    n = grad.shape[0]
    top = 0.0
    for j in range(n):
        top = max(top, hess[j, j] / (units[j] * units[j]))
    for j in range(n):
        floor = 1e-13 * top * units[j] * units[j]
        pivot = hess[j, j] + floor
        for k in range(j):
            pivot -= hess[j, k] * hess[j, k]
        hess[j, j] = sqrt(max(pivot, floor, 1e-300))
        for i in range(j + 1, n):
            for k in range(j):
                hess[i, j] -= hess[i, k] * hess[j, k]
            hess[i, j] /= hess[j, j]
    for j in range(n):
        step[j] = -grad[j]
        for k in range(j):
            step[j] -= hess[j, k] * step[k]
        step[j] /= hess[j, j]
    for j in range(n - 1, -1, -1):
        for k in range(j + 1, n):
            step[j] -= hess[k, j] * step[k]
        step[j] /= hess[j, j]


@kernel
def column_units(shape: Array, maps: Array) -> Array:
    """Speed of contact surfaces per unit of each unknown (n,): root of the sum of squares of vx, vz and a spin."""
    n = maps.shape[2]
    units = np.empty(n)
    for j in range(n):
        total = 0.0
        for i in range(shape.shape[0]):
            if shape[i, 2] > 0.0:
                turn = shape[i, 0] * maps[i, 2, j]
                total += maps[i, 0, j] * maps[i, 0, j] + maps[i, 1, j] * maps[i, 1, j] + turn * turn
        units[j] = sqrt(total) if total > 0.0 else 1.0
    return units


@kernel
def residual(grad: Array, units: Array) -> float:
    """Largest component of the gradient as a force [N]."""
    worst = 0.0
    for j in range(grad.shape[0]):
        worst = max(worst, abs(grad[j]) / units[j])
    return worst


@kernel
def descend(
    shape: Array,
    maps: Array,
    drives: Array,
    push: Array,
    speed: float,
    q: Array,
    tolerance: float,
    limit: int,
    reach: float,
) -> tuple[float, float, float, int]:
    """Minimise at one regularising speed, from q (n,) onwards, which is overwritten; arguments as in ``evaluate``.

    Ends where no generalised force is out of balance by more than ``tolerance`` times the sum of the strengths, or
    after ``limit`` steps, or beyond the surface speed ``reach`` [m/s], where push exceeds friction. Returns value,
    excess, largest force out of balance [N], steps.
    """
    n = q.shape[0]
    grad, step, trial, next_grad = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    hess, next_hess = np.empty((n, n)), np.empty((n, n))
    units = column_units(shape, maps)
    goal = tolerance * np.sum(shape[:, 2])
    value, excess = evaluate(shape, maps, drives, push, speed, q, grad, hess)
    count = 0
    while count < limit and residual(grad, units) > goal and np.max(np.abs(q) * units) <= reach:
        count += 1
        newton_step(hess, grad, units, step)
        slope = 0.0
        for j in range(n):
            slope += grad[j] * step[j]
        length, better = 1.0, False
        for _ in range(40):
            for j in range(n):
                trial[j] = q[j] + length * step[j]
            new, new_excess = evaluate(shape, maps, drives, push, speed, trial, next_grad, next_hess)
            small = -slope <= 1e-13 * abs(value)  # then only the gradient still tells one point from another
            if small and residual(next_grad, units) < 0.5 * residual(grad, units):
                better = True
                break
            if not small and new <= value + 1e-4 * length * slope:
                better = True
                break
            length *= 0.5
        if not better:
            break
        value, excess = new, new_excess
        q[:] = trial
        grad[:] = next_grad
        hess[:] = next_hess
    return value, excess, residual(grad, units), count


@kernel
def rolling_start(shape: Array, maps: Array, drives: Array) -> Array:
    """Motion (n,) of least squared surface speed, weighted by the strengths: linear, unique up to idle motions."""
    n = maps.shape[2]
    grad, hess, q = np.zeros(n), np.zeros((n, n)), np.empty(n)
    for i in range(shape.shape[0]):
        for r in range(3):
            w = shape[i, 2] * (shape[i, 0] * shape[i, 0] if r == 2 else 1.0)
            for j in range(n):
                grad[j] += w * maps[i, r, j] * drives[i, r]
                for k in range(j + 1):
                    hess[j, k] += w * maps[i, r, j] * maps[i, r, k]
    newton_step(hess, grad, column_units(shape, maps), q)
    return q


@kernel
def drive_speed(shape: Array, drives: Array) -> float:
    """Largest surface speed [m/s] that the drives impose on a loaded contact."""
    top = 0.0
    for i in range(shape.shape[0]):
        if shape[i, 2] > 0.0:
            turn = shape[i, 0] * drives[i, 2]
            top = max(top, drives[i, 0] * drives[i, 0] + drives[i, 1] * drives[i, 1] + turn * turn)
    return sqrt(top)


@kernel
def speeds_at(shape: Array, maps: Array, drives: Array, q: Array) -> tuple[Array, Array]:
    """Contact motions (m, 3) at q and their surface speeds (m,) [m/s]."""
    m, n = shape.shape[0], q.shape[0]
    motion, size = drives.copy(), np.empty(m)
    for i in range(m):
        for r in range(3):
            for j in range(n):
                motion[i, r] += maps[i, r, j] * q[j]
        turn = shape[i, 0] * motion[i, 2]
        size[i] = sqrt(motion[i, 0] * motion[i, 0] + motion[i, 1] * motion[i, 1] + turn * turn)
    return motion, size
