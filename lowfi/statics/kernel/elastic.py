"""Static equilibrium with elastic bodies: Newton on the contact forces, the bodies' compliance between all contacts given.

The flanks move by v = v_0 + G phi + R a: G the compliance of the bodies, R motions that nothing but the contacts resists.
Every ball takes the forces f(v) on its flanks; at the solution phi = f(v). With the stiffness S^T S of all balls, factored
ball by ball, a step solves (I + S G S^T) u = S (G (f - phi) + R da), R^T (f - S^T u) + work = 0: Newton on the convex
energy phi G phi/2 - work a + balls(v), whose unknowns never are the beam's nodes. Few balls are factored whole; many take
the modes of the bodies that are softer than a contact exactly and iterate on the rest (``modes``).
"""

import numpy as np

from lowfi.jit import kernel

from .arrays import Array, Arrays, Contacts
from .coupling import apply_rows, body_motion, border, cholesky_lower, couple, forces_of_rows, triangular
from .elastic_balls import ball_rows, evaluate_balls
from .modes import gradients, soft_factor
from .newton import CONVERGED, ITERATIONS, NOT_HELD, SINGULAR

#: Residual asked of the linear equations, as a fraction of that of the contact forces: a tenth keeps Newton's own order.
FORCING = 0.1


@kernel
def solve_rows(
    bodies: Arrays,
    S: Array,
    counts: Array,
    starts: Array,
    factors: Arrays,
    fresh: bool,
    target: Array,
    hold: float,
    wanted: float,
    u: Array,
    a: Array,
) -> bool:
    """Solve (I + S G S^T) u - S R a = u (given), (S R)^T u + hold a = target; False where the matrix is not positive.

    factors = (M, W, C): where the bodies' modes are given, W and C serve conjugate gradients (to ``wanted``), else M holds
    the whole factor. fresh: factor anew.
    """
    M, W, C = factors
    total = u.shape[0]
    R, modes = bodies[2], (bodies[5], bodies[6])
    given = u
    if modes[0].shape[0]:
        part = W[:total]
        if fresh and not soft_factor(modes, S, counts, starts, part, C):
            return False
        given = u.copy()
        if gradients(bodies, S, counts, starts, (part, C), target, hold, wanted, u, a) >= 0:
            return True
        u[:] = given
    whole = M[: total * total].reshape(total, total) if M.size else np.empty((total, total))
    if fresh or not M.size:
        couple(bodies, S, counts, starts, whole)
        if not cholesky_lower(whole):
            return False
    triangular(whole, u)
    return R.shape[2] == 0 or border(R, S, counts, starts, whole, u, target, hold, a)


@kernel
def newton_forces(
    bodies: Arrays,
    contacts: Contacts,
    state: Arrays,
    f: Array,
    hold: float,
    wanted: float,
    fresh: bool,
    cache: Arrays,
    out: Arrays,
) -> bool:
    """Step of forces and free motions: out = (dphi (N, d), dv (N, d), da (k,)); False where the matrix is not positive.

    bodies = (G first, G second, R (N, d, k), v0 (N, d), work (k,), U first, U second), the last two empty or the modes of
    `modes.soft_rows`; hold [N/m]: stiffness that keeps free motions from running away where no contact holds them;
    wanted: relative residual of the linear equations; fresh: factor anew, else by ``cache`` = (M, W, C, S, counts, starts).
    """
    R, work = bodies[2], bodies[4]
    phi = state[0]
    dphi, dv, da = out
    M, W, C, S, counts, starts = cache
    k = R.shape[2]
    if fresh:
        ball_rows(contacts, state[3], S, counts)
        first = 0
        for i in range(S.shape[0]):
            starts[i] = first
            first += counts[i]
    total = starts[-1] + counts[-1]
    for i in range(phi.shape[0]):
        for a in range(phi.shape[1]):
            dphi[i, a] = f[i, a] - phi[i, a]
    body_motion(bodies, dphi, dv)
    u = np.empty(total)
    apply_rows(S, counts, starts, dv, u)
    target = work.copy()
    for c in range(k):
        for i in range(f.shape[0]):
            for a in range(f.shape[1]):
                target[c] += R[i, a, c] * f[i, a]
    if not solve_rows(bodies, S, counts, starts, (M, W, C), fresh, target, hold, wanted, u, da):
        return False
    forces_of_rows(S, counts, starts, u, dphi)
    body_motion(bodies, dphi, dv)
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            for c in range(k):
                dv[i, a] += R[i, a, c] * da[c]
    return True


@kernel
def mismatch(bodies: Arrays, phi: Array, f: Array, arms: Array, scale: float) -> float:
    """Largest difference of assumed and true flank forces, and unbalanced load on a free motion, over ``scale`` [N]."""
    R, work = bodies[2], bodies[4]
    worst = 0.0
    for i in range(f.shape[0]):
        for a in range(f.shape[1]):
            worst = max(worst, abs(f[i, a] - phi[i, a]))
    for c in range(R.shape[2]):
        total = work[c]
        for i in range(f.shape[0]):
            for a in range(f.shape[1]):
                total += R[i, a, c] * f[i, a]
        worst = max(worst, abs(total) * arms[c])
    return worst / scale if scale > 0.0 else worst


@kernel
def slope_of(bodies: Arrays, f: Array, g: Array, step: Arrays) -> float:
    """Directional derivative of the energy at forces f of the balls and body motions g = G phi."""
    dphi, dv, da = step
    total = 0.0
    for i in range(f.shape[0]):
        for a in range(f.shape[1]):
            total += dphi[i, a] * g[i, a] - f[i, a] * dv[i, a]
    for c in range(da.shape[0]):
        total -= bodies[4][c] * da[c]
    return total


@kernel
def shift_state(bodies: Arrays, state: Arrays, begin: Arrays, step: Arrays, t: float, g: Array, v: Array) -> None:
    """State, body motions g and flank motions v at ``begin`` = (phi, a, g, v) plus t times the step."""
    dphi, dv, da = step
    R = bodies[2]
    phi, amplitude = state[0], state[1]
    for c in range(da.shape[0]):
        amplitude[c] = begin[1][c] + t * da[c]
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            phi[i, a] = begin[0][i, a] + t * dphi[i, a]
            v[i, a] = begin[3][i, a] + t * dv[i, a]
            own = dv[i, a]
            for c in range(da.shape[0]):
                own -= R[i, a, c] * da[c]
            g[i, a] = begin[2][i, a] + t * own


@kernel
def stored(bodies: Arrays, state: Arrays, g: Array) -> float:
    """Energy of the bodies less the work of the loads on the free motions."""
    phi, amplitude = state[0], state[1]
    total = 0.0
    for i in range(phi.shape[0]):
        for a in range(phi.shape[1]):
            total += 0.5 * phi[i, a] * g[i, a]
    for c in range(amplitude.shape[0]):
        total -= bodies[4][c] * amplitude[c]
    return total


@kernel
def search_forces(
    bodies: Arrays,
    contacts: Contacts,
    state: Arrays,
    f: Array,
    g: Array,
    v: Array,
    step: Arrays,
    energy: float,
    slope: float,
    tiny: float,
) -> tuple[float, float, int]:
    """Step length along a step, as ``newton.line_search``; state, f, g and v are left at the accepted point."""
    begin = (state[0].copy(), state[1].copy(), g.copy(), v.copy())
    low, high, t = 0.0, 0.0, 1.0
    new, scale = energy, 0.0
    evaluations = 0
    while evaluations < 60:
        shift_state(bodies, state, begin, step, t, g, v)
        own, scale = evaluate_balls(v, contacts, state, f, tiny)
        new = own + stored(bodies, state, g)
        evaluations += 1
        ahead = slope_of(bodies, f, g, step)
        if ahead > 0.0:
            if ahead <= 0.5 * abs(slope) and new <= energy:
                break
            if new <= energy + 1e-4 * t * slope and ahead <= 0.9 * abs(slope):
                break
            high = t
            t = low + (0.5 if low > 0.0 else 0.35) * (high - low)
        else:
            if ahead >= 0.9 * slope or high > 0.0 or t > 1e12:
                break
            low = t
            t *= 4.0
    return new, scale, evaluations


@kernel
def place_flanks(bodies: Arrays, state: Arrays, g: Array, v: Array) -> None:
    """Fill g = G phi and v = v0 + g + R a from the state."""
    R, v0 = bodies[2], bodies[3]
    body_motion(bodies, state[0], g)
    for i in range(v.shape[0]):
        for a in range(v.shape[1]):
            v[i, a] = v0[i, a] + g[i, a]
            for c in range(R.shape[2]):
                v[i, a] += R[i, a, c] * state[1][c]


@kernel
def solve_forces(
    bodies: Arrays, contacts: Contacts, state: Arrays, options: Array, arms: Array, history: Array
) -> tuple[int, int, int, float, float, float]:
    """Minimise the energy from the given forces; returns status, iterations, evaluations, residual, energy, scale.

    state = (phi (N, d) [N], a (k,), inner (N, 3), contact (N, 4 or 1, 5)); options (7,): tolerance, largest number of
    iterations, reference stiffness [N/m], force [N] below which a contact carries none, largest free motion [m] before the
    screw counts as not held, least force [N] that residuals are measured by, furthest start [m] of a flank. arms (k,): see
    `lowfi.statics.shaft`.
    """
    tolerance, most, stiffness, tiny, bound, floor = (
        options[0],
        int(options[1]),
        options[2],
        options[3],
        options[4],
        options[5],
    )
    phi, amplitude = state[0], state[1]
    balls, d = phi.shape
    f, g, v = np.empty((balls, d)), np.empty((balls, d)), np.empty((balls, d))
    step = (np.empty((balls, d)), np.empty((balls, d)), np.zeros(amplitude.shape[0]))
    width = 2 if d == 2 else 6
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    soft = bodies[5].shape[1] + bodies[6].shape[1]
    whole = (width * balls) ** 2 if bodies[5].shape[0] == 0 else 0
    factors = np.empty(whole), np.empty((width * balls, soft)), np.empty((soft, soft))
    cache = (*factors, np.zeros((balls, width, d)), counts, starts)
    place_flanks(bodies, state, g, v)
    own, scale = evaluate_balls(v, contacts, state, f, tiny)
    energy = own + stored(bodies, state, g)
    if floor == 0.0:
        floor = 1e-3 * scale
    scale = max(scale, floor)
    residual = mismatch(bodies, phi, f, arms, scale)
    history[0] = residual
    evaluations, stalled, factor, best = 1, 0, 1e-3, residual
    status, it, fresh = ITERATIONS, 0, True
    if residual <= tolerance:
        return CONVERGED, 0, 1, residual, energy, scale
    for it in range(1, most + 1):
        solved = False
        for _ in range(12):
            hold = factor * stiffness * min(1.0, residual)
            wanted = max(FORCING * min(0.1, residual), 0.01 * tolerance / residual)
            solved = newton_forces(bodies, contacts, state, f, hold, wanted, fresh, cache, step)
            if solved:
                break
            factor *= 100.0
            fresh = True
        if not solved:
            status = SINGULAR
            break
        if residual < 1e-7:
            begin = (phi.copy(), amplitude.copy(), g.copy(), v.copy())
            shift_state(bodies, state, begin, step, 1.0, g, v)
            own, scale = evaluate_balls(v, contacts, state, f, tiny)
            energy = own + stored(bodies, state, g)
            evaluations += 1
        else:
            slope = slope_of(bodies, f, g, step)
            energy, scale, used = search_forces(bodies, contacts, state, f, g, v, step, energy, slope, tiny)
            evaluations += used
        scale = max(scale, floor)
        residual = mismatch(bodies, phi, f, arms, scale)
        history[it] = residual
        factor = max(1e-3, factor * 0.1)
        if residual <= tolerance:
            status = CONVERGED
            break
        moved = 0.0
        for c in range(amplitude.shape[0]):
            moved = max(moved, abs(amplitude[c]) / arms[c])
        if moved > bound:
            status = NOT_HELD
            break
        stalled = stalled + 1 if residual >= 0.5 * best else 0
        best = min(best, residual)
        if stalled >= 2 and residual <= 1e-9:
            break
        fresh = residual > 1e-7 or stalled > 0
    place_flanks(bodies, state, g, v)
    evaluate_balls(v, contacts, state, f, tiny)
    return status, it, evaluations, residual, energy, scale


@kernel
def start_forces(bodies: Arrays, state: Arrays, springs: Array, options: Array) -> bool:
    """Start of the iteration: the bodies on one linear spring between opposite flanks in place of two contacts.

    springs (N, w, d): rows sqrt(stiffness) x direction, zero where there is none. Overwrites phi and a. No flank goes
    further than options[6], as in ``newton.linear_start``.
    """
    phi, amplitude = state[0], state[1]
    balls, width = springs.shape[0], springs.shape[1]
    v0, work = bodies[3], bodies[4]
    counts, starts = np.full(balls, width, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    for i in range(balls):
        starts[i] = width * i
    soft = bodies[5].shape[1] + bodies[6].shape[1]
    whole = (width * balls) ** 2 if bodies[5].shape[0] == 0 else 0
    factors = (np.empty(whole), np.empty((width * balls, soft)), np.empty((soft, soft)))
    u = np.empty(width * balls)
    apply_rows(springs, counts, starts, v0, u)
    if not solve_rows(bodies, springs, counts, starts, factors, True, work, 1e-9 * options[2], 0.01, u, amplitude):
        return False
    phi[:, :] = 0.0
    forces_of_rows(springs, counts, starts, u, phi)
    g, v = np.empty(phi.shape), np.empty(phi.shape)
    place_flanks(bodies, state, g, v)
    reach = np.abs(v - v0).max()
    if reach > options[6]:
        phi *= options[6] / reach
        amplitude *= options[6] / reach
    return True
