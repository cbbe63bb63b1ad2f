"""Kernels of ball motion in a linear bearing, in a subset of Python that numba compiles; see ``linear_engine``.

Velocities are in units of the carriage's speed, forces in units of the largest friction bound of a ball. Unknowns of a
ball: axial velocity and ball radius times the two spin components across the track, x = (v, R omega_x, R omega_y).
"""

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lowfi.jit import kernel

Array = NDArray[Any]
#: (contacts (N, C, 5), shapes (N, C, 4), nodes (2, m), closed (N-1,), mu, hold (N,), nominal (N, 3)).
Problem = Any
#: (slip (N, C, 2), pair (N-1, 3), drift (N, 3)): slips, differences of neighbours, deviation from the nominal motion:
#: linear in the unknowns, moved by increments so that nothing cancels where contacts stick.
State = Any
#: Columns of the banded matrix: half a band, the diagonal, half a band. A ball has four rows: x and, last, the force
#: towards the next ball, so that elimination adds compliances and nothing cancels.
HALF = 5
WIDTH = 11
#: Longest step of a velocity: longer ones, back and forth in the line search, would cost digits.
LONGEST = 2.0


@kernel
def slide_and_spin(s: float, w: float, shape: Array, nodes: Array) -> tuple[float, float, float, float, float]:
    """Friction of one elliptical contact sliding at s along its minor axis and spinning at w / a, per unit bound.

    shape: (b2/a2, q0, k1, k3) of ``contact_shape``; nodes: squared sines and weights, ``(2, m)``. Returns force and
    moment / a (gradient of the dissipation phi = s f + w m, a norm), phi, and (h, side): the Hessian is h n n^T with
    n = (kappa, -1) outside the ellipse (side 1, kappa = w/s), n = (1, -t) inside it (side 0, t = s/w).
    """
    size_s, size_w = abs(s), abs(w)
    if size_s + size_w == 0.0:
        return 0.0, 0.0, 0.0, 0.0, -1.0
    sign_s = 1.0 if s > 0.0 else -1.0
    sign_w = 1.0 if w > 0.0 else -1.0
    if size_s < size_w:
        t = s / w
        t2 = t * t
        f = sign_w * t * (shape[2] - shape[3] * t2)
        m = sign_w * (shape[1] - t2 * (0.5 * shape[2] - 0.75 * shape[3] * t2))
        return f, m, s * f + w * m, (shape[2] - 3.0 * shape[3] * t2) / size_w, 0.0
    kappa = w / s
    k2, flat = kappa * kappa, 1.0 - shape[0]
    force, moment, bend = 0.0, 0.0, 0.0
    for i in range(nodes.shape[1]):
        y2, weight = nodes[0, i], nodes[1, i]
        top, bottom = 1.0 - k2 * y2, 1.0 - flat * k2 * y2
        ratio = sqrt(top / bottom)
        part = weight * (1.0 - y2)
        force += part * ratio
        part *= ratio / (top * bottom)
        moment += part * (1.0 - y2)
        bend += part * y2
    f = sign_s * 1.5 * force
    m = sign_s * kappa * 0.375 * shape[0] * moment
    return f, m, s * f + w * m, 1.5 * shape[0] * bend / size_s, 1.0


@kernel
def regularised(
    s: float, w: float, shape: Array, nodes: Array, eps: float
) -> tuple[float, float, float, float, float, float]:
    """Energy sqrt(phi2 + eps2) - eps per unit bound, its gradient (2) and Hessian (3: ss, sw, ww) by (s, w).

    Convex; the force is phi / sqrt(phi2 + eps2) times Coulomb's, so contacts stick at creeping speeds below eps.
    """
    f, m, phi, h, side = slide_and_spin(s, w, shape, nodes)
    eta = sqrt(phi * phi + eps * eps)
    if side < 0.0:
        return 0.0, 0.0, 0.0, 1.0 / eps, 0.0, shape[1] * shape[1] / eps
    n_s, n_w = 1.0, 0.0
    if side > 0.5:
        n_s, n_w = w / s, -1.0
    else:
        n_w = -s / w
    a = phi / eta * h
    b = (eps / eta) * (eps / eta) / eta
    c = phi / eta
    return (
        phi * phi / (eta + eps), c * f, c * m,
        a * n_s * n_s + b * f * f, a * n_s * n_w + b * f * m, a * n_w * n_w + b * m * m,
    )  # fmt: skip


@kernel
def _add_contacts(problem: Problem, state: State, eps: float, K: Array, g: Array) -> float:
    """Contacts' part of energy, gradient g ``(4N,)`` and banded Hessian K ``(4N, 11)``."""
    contacts, shapes, nodes, _, _, _, _ = problem
    slip, _, _ = state
    energy = 0.0
    for j in range(contacts.shape[0]):
        for i in range(contacts.shape[1]):
            bound = contacts[j, i, 3]
            if bound == 0.0:
                continue
            s, w = slip[j, i, 0], slip[j, i, 1]
            e, f, m, ss, sw, ww = regularised(s, w, shapes[j, i], nodes, eps)
            energy += bound * e
            nx, ny, arm = contacts[j, i, 0], contacts[j, i, 1], contacts[j, i, 4]
            rows = ((1.0, 0.0), (ny, arm * nx), (-nx, arm * ny))
            for k in range(3):
                a, b = rows[k]
                g[4 * j + k] += bound * (a * f + b * m)
                left, right = a * ss + b * sw, a * sw + b * ww
                for q in range(3):
                    c, d = rows[q]
                    K[4 * j + k, HALF + q - k] += bound * (left * c + right * d)
    return energy


@kernel
def _add_rubbing(eps: float, bound: float, slope: float, k: int, pair: Array, K: Array, g: Array) -> float:
    """Friction between balls k and k+1 that slide at ``pair[k, 1:]``; slope: growth of its bound with their force."""
    i, tx, ty = 4 * k, pair[k, 1], pair[k, 2]
    size2 = tx * tx + ty * ty
    eta = sqrt(size2 + eps * eps)
    across = (tx / eta, ty / eta)
    for a in range(2):
        for row in (i + 1 + a, i + 5 + a):
            g[row] += bound * across[a]
            K[row, HALF + i + 3 - row] += slope * across[a]
            for b in range(2):
                h = bound * ((1.0 if a == b else 0.0) - across[a] * across[b]) / eta
                for column in (i + 1 + b, i + 5 + b):
                    K[row, HALF + column - row] += h
    return float(bound * size2 / (eta + eps))


@kernel
def _add_pairs(
    problem: Problem, state: State, eps: float, lam: Array, grip: Array, rho: float, coupled: bool, K: Array, g: Array
) -> float:
    """Ball-to-ball part: augmented Lagrangian of the order of the velocities, and friction bounded by mu ``grip``.

    coupled: bounded by mu times the contact force itself instead, which makes K unsymmetric.
    """
    _, _, _, closed, mu, _, _ = problem
    _, pair, _ = state
    energy = 0.0
    for k in range(closed.shape[0]):
        i = 4 * k + 3
        push = lam[k] + rho * pair[k, 0]
        active = closed[k] != 0.0 and push > 0.0
        if active:
            energy += 0.5 * push * push / rho
            g[i - 3] += push
            g[i + 1] -= push
            K[i, HALF] = -1.0 / rho
            K[i, HALF - 3] = 1.0
            K[i, HALF + 1] = -1.0
            K[i - 3, HALF + 3] = 1.0
            K[i + 1, HALF - 1] = -1.0
        else:
            push = 0.0
        bound = mu * (push if coupled else grip[k])
        if bound > 0.0:
            energy += _add_rubbing(eps, bound, mu if coupled else 0.0, k, pair, K, g)
    return energy


@kernel
def assemble(
    problem: Problem, state: State, eps: float, lam: Array, grip: Array, rho: float, coupled: bool, K: Array, g: Array
) -> float:
    """Energy of the chain (convex unless coupled), its gradient g ``(4N,)`` and the banded matrix of Newton's step."""
    drift, hold = state[2], problem[5]
    K[:] = 0.0
    g[:] = 0.0
    energy = 0.0
    for j in range(drift.shape[0]):
        for k in range(3):
            energy += 0.5 * hold[j] * drift[j, k] * drift[j, k]
            g[4 * j + k] = hold[j] * drift[j, k]
            K[4 * j + k, HALF] = hold[j]
        K[4 * j + 3, HALF] = -1.0
    energy += _add_contacts(problem, state, eps, K, g)
    energy += _add_pairs(problem, state, eps, lam, grip, rho, coupled, K, g)
    return energy


@kernel
def solve_banded(K: Array, x: Array) -> None:
    """Solve K y = x in place by elimination without pivoting; K ``(n, 11)`` is overwritten by its factors."""
    n = x.shape[0]
    for i in range(n):
        for r in range(i + 1, min(n, i + HALF + 1)):
            factor = K[r, HALF + i - r] / K[i, HALF]
            if factor != 0.0:
                for c in range(i + 1, min(n, i + HALF + 1)):
                    K[r, HALF + c - r] -= factor * K[i, HALF + c - i]
                x[r] -= factor * x[i]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, min(n, i + HALF + 1)):
            x[i] -= K[i, HALF + c - i] * x[c]
        x[i] /= K[i, HALF]


@kernel
def rebuild(problem: Problem, state: State) -> None:
    """Slips and differences of neighbours from the deviation ``state[2]`` of the motion."""
    contacts, nominal = problem[0], problem[6]
    slip, pair, drift = state
    for j in range(contacts.shape[0]):
        v, p, q = nominal[j, 0] + drift[j, 0], nominal[j, 1] + drift[j, 1], nominal[j, 2] + drift[j, 2]
        for i in range(contacts.shape[1]):
            nx, ny = contacts[j, i, 0], contacts[j, i, 1]
            slip[j, i, 0] = v + ny * p - nx * q - contacts[j, i, 2]
            slip[j, i, 1] = contacts[j, i, 4] * (nx * p + ny * q)
        if j > 0:
            pair[j - 1, 0] = nominal[j - 1, 0] + drift[j - 1, 0] - v
            pair[j - 1, 1] = nominal[j - 1, 1] + drift[j - 1, 1] + p
            pair[j - 1, 2] = nominal[j - 1, 2] + drift[j - 1, 2] + q


@kernel
def move(problem: Problem, state: State, step: Array, t: float) -> None:
    """Add t times the step ``(4N,)`` of the unknowns to everything that depends on them."""
    contacts = problem[0]
    slip, pair, drift = state
    for j in range(contacts.shape[0]):
        dv, dp, dq = t * step[4 * j], t * step[4 * j + 1], t * step[4 * j + 2]
        drift[j, 0] += dv
        drift[j, 1] += dp
        drift[j, 2] += dq
        for i in range(contacts.shape[1]):
            nx, ny = contacts[j, i, 0], contacts[j, i, 1]
            slip[j, i, 0] += dv + ny * dp - nx * dq
            slip[j, i, 1] += contacts[j, i, 4] * (nx * dp + ny * dq)
        if j > 0:
            pair[j - 1, 0] -= dv
            pair[j - 1, 1] += dp
            pair[j - 1, 2] += dq
        if j < contacts.shape[0] - 1:
            pair[j, 0] += dv
            pair[j, 1] += dp
            pair[j, 2] += dq


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
def solve(
    problem: Problem, state: State, lam: Array, grip: Array, work: Any, eps_end: float, tolerance: float, rounds: int
) -> tuple[int, float, float]:
    """Motion of all balls: friction by continuation in eps, order by multipliers, ball-to-ball friction lagged.

    The first round has no ball-to-ball friction, so that its convex problem alone decides where the answer starts from:
    at high mu a jammed state may exist beside the one that develops from there.
    lam ``(N-1,)``: contact forces out; grip: the forces that bound the friction. Returns Newton iterations, largest
    force out of balance, and largest difference of contact force and friction bound, both per unit bound.
    """
    total, eps, residual, top = 0, 1.0, 1.0, float(problem[0].shape[0])
    memory = np.zeros((4, lam.shape[0]))
    memory[3] = top
    while eps > eps_end:
        rebuild(problem, state)
        eps = max(eps_end, 0.1 * eps)
        rho = 100.0 / eps  # stiffer than sticking contacts, else the multipliers creep
        if eps > eps_end:
            used, residual = _order(problem, state, eps, lam, grip, rho, work, 1e-3, 1)
            total += used
            if problem[4] > 0.0:
                used, _ = _couple(problem, state, eps, lam, grip, rho, work, 1e-6)
                total += used
    for i in range(rounds):
        used, residual = _order(problem, state, eps, lam, grip, 100.0 / eps, work, tolerance, 20)
        total += used
        if _gap(lam, grip) <= tolerance:
            break
        if i % 8 == 1:
            used, done = _couple(problem, state, eps, lam, grip, 100.0 / eps, work, tolerance)
            total += used
            if done:
                continue
        _regrip(lam, grip, memory, top, i % 3 == 2)
    return total, residual, _gap(lam, grip)
