"""Static equilibrium with elastic bodies: Newton on the contact forces, the bodies' compliance between all contacts given.

The flanks move by v = v_0 + G phi + R a: G the compliance of the bodies, R motions that nothing but the contacts resists.
Every ball takes the forces f(v) on its flanks; at the solution phi = f(v). With the stiffness S^T S of all balls, factored
ball by ball, a step solves (I + S G S^T) u = S (G (f - phi) + R da), R^T (f - S^T u) + work = 0: Newton on the convex
energy phi G phi/2 - work a + balls(v), whose unknowns never are the beam's nodes. Few balls are factored whole; many take
the modes of the bodies that are softer than a contact exactly and iterate on the rest (``modes``).
"""

from collections.abc import Callable

import numpy as np

from rollbench.lowfi.jit import driver_of, kernel
from rollbench.lowfi.statics.records import (
    Array,
    BallContacts,
    BallRows,
    Bodies,
    BodyRoom,
    BodyState,
    BodySystem,
    Factors,
    ForceStep,
    Options,
    Outcome,
    SearchStart,
)

from .ball import ball_mismatch
from .coupling import apply_rows, body_motion, border, cholesky_lower, couple, forces_of_rows, triangular
from .elastic_balls import ball_rows, evaluate_balls
from .modes import gradients, soft_factor

#: Residual asked of the linear equations, as a fraction of that of the contact forces: a tenth keeps Newton's own order.
FORCING = 0.1
STRICT = 1e-8  # of it, once a search has found nothing: a step that is not exact may not go down
#: See ``descent``: under a contact that vanishes, rows and factors of a step before are too stiff.
KEPT = 0.5


@kernel
def solve_rows(
    bodies: Bodies,
    S: Array,
    counts: Array,
    starts: Array,
    factors: Factors,
    fresh: bool,
    target: Array,
    hold: float,
    wanted: float,
    u: Array,
    a: Array,
) -> bool:
    """Solve (I + S G S^T) u - S R a = u (given), (S R)^T u + hold a = target; False where the matrix is not positive.

    Where the bodies' modes are given, W and C of the factors serve conjugate gradients (to ``wanted``), else the whole
    factor does. fresh: factor anew.
    """
    M, W, C = factors
    total, R = u.shape[0], bodies.R
    given = u
    if bodies.soft_first.shape[0]:
        modes = (bodies.soft_first, bodies.soft_second)
        soft = W[:total]
        if fresh and not soft_factor(modes, S, counts, starts, soft, C):
            return False
        given = u.copy()
        if gradients(bodies, S, counts, starts, (soft, C), target, hold, wanted, u, a) >= 0:
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
    bodies: Bodies,
    contacts: BallContacts,
    state: BodyState,
    f: Array,
    hold: float,
    wanted: float,
    fresh: bool,
    rows: BallRows,
    factors: Factors,
    out: ForceStep,
) -> bool:
    """Step of forces and free motions, written to ``out``; False where the matrix is not positive.

    hold [N/m]: stiffness that keeps free motions from running away where no contact holds them; wanted: relative residual
    of the linear equations; fresh: find rows and factors anew, else those given serve.
    """
    R, phi = bodies.R, state.phi
    dphi, dv, da = out
    S, counts, starts = rows
    k = R.shape[2]
    if fresh:
        ball_rows(contacts, state.contact, S, counts)
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
    target = bodies.work.copy()
    for c in range(k):
        for i in range(f.shape[0]):
            for a in range(f.shape[1]):
                target[c] += R[i, a, c] * f[i, a]
    if not solve_rows(bodies, S, counts, starts, factors, fresh, target, hold, wanted, u, da):
        return False
    forces_of_rows(S, counts, starts, u, dphi)
    body_motion(bodies, dphi, dv)
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            for c in range(k):
                dv[i, a] += R[i, a, c] * da[c]
    return True


@kernel
def mismatch(bodies: Bodies, phi: Array, f: Array, arms: Array, scale: float) -> float:
    """Largest difference of assumed and true flank forces, and unbalanced load on a free motion, over ``scale`` [N]."""
    R, work = bodies.R, bodies.work
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
def slope_of(bodies: Bodies, f: Array, g: Array, step: ForceStep) -> float:
    """Directional derivative of the energy at forces f of the balls and body motions g = G phi."""
    dphi, dv, da = step
    total = 0.0
    for i in range(f.shape[0]):
        for a in range(f.shape[1]):
            total += dphi[i, a] * g[i, a] - f[i, a] * dv[i, a]
    for c in range(da.shape[0]):
        total -= bodies.work[c] * da[c]
    return total


@kernel
def shift_state(
    bodies: Bodies, state: BodyState, begin: SearchStart, step: ForceStep, t: float, g: Array, v: Array
) -> None:
    """State, body motions g and flank motions v at ``begin`` plus t times the step."""
    dphi, dv, da = step
    R, phi, amplitude = bodies.R, state.phi, state.a
    for c in range(da.shape[0]):
        amplitude[c] = begin.a[c] + t * da[c]
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            phi[i, a] = begin.phi[i, a] + t * dphi[i, a]
            v[i, a] = begin.v[i, a] + t * dv[i, a]
            by_bodies = dv[i, a]
            for c in range(da.shape[0]):
                by_bodies -= R[i, a, c] * da[c]
            g[i, a] = begin.g[i, a] + t * by_bodies


@kernel
def stored(bodies: Bodies, state: BodyState, g: Array) -> float:
    """Energy of the bodies less the work of the loads on the free motions."""
    phi, amplitude = state.phi, state.a
    total = 0.0
    for i in range(phi.shape[0]):
        for a in range(phi.shape[1]):
            total += 0.5 * phi[i, a] * g[i, a]
    for c in range(amplitude.shape[0]):
        total -= bodies.work[c] * amplitude[c]
    return total


@kernel
def place_flanks(bodies: Bodies, state: BodyState, g: Array, v: Array) -> None:
    """Fill g = G phi and v = v0 + g + R a from the state."""
    R, v0 = bodies.R, bodies.v0
    body_motion(bodies, state.phi, g)
    for i in range(v.shape[0]):
        for a in range(v.shape[1]):
            v[i, a] = v0[i, a] + g[i, a]
            for c in range(R.shape[2]):
                v[i, a] += R[i, a, c] * state.a[c]


@kernel
def apart(v: Array) -> float:
    """Largest motion [m] of a flank of the first body against that of the second; v (N, d): of the flanks, d = 2 where it
    is of both against one another."""
    largest, half = 0.0, v.shape[1] // 2
    for i in range(v.shape[0]):
        if half == 1:
            largest = max(largest, abs(v[i, 0]), abs(v[i, 1]))
        else:
            for a in range(half):
                largest = max(largest, abs(v[i, a] - v[i, half + a]))
    return largest


@kernel
def room_for_factors(bodies: Bodies, rows: int) -> Factors:
    """Room for the factors of that many rows: the whole one, or those of the soft modes where they are given."""
    soft = bodies.soft_first.shape[1] + bodies.soft_second.shape[1]
    whole = rows**2 if bodies.soft_first.shape[0] == 0 else 0
    return Factors(np.empty(whole), np.empty((rows, soft)), np.empty((soft, soft)))


@kernel
def unbalanced(state: BodyState, scale: float) -> float:
    """Largest net contact force on a ball over ``scale`` [N]; none on balls between two opposite arcs, by closed form."""
    return 0.0 if state.contact.shape[1] == 1 else ball_mismatch(state.contact, scale)


@kernel
def energy_at(given: BodySystem, state: BodyState, room: BodyRoom) -> tuple[float, float]:
    """Energy of bodies and balls, and the largest contact force; fills the forces on the flanks."""
    energy, scale = evaluate_balls(room.v, given.contacts, state, room.f)
    return energy + stored(given.bodies, state, room.g), scale


@kernel
def find_step(
    given: BodySystem,
    state: BodyState,
    options: Options,
    room: BodyRoom,
    shift: float,
    residual: float,
    fresh: bool,
    stuck: int,
) -> bool:
    """Newton's step, its linear equations as exact as the residual wants it."""
    wanted = max(FORCING * min(0.1, residual), 0.01 * options.tolerance / residual) * (STRICT if stuck else 1.0)
    bodies, contacts = given.bodies, given.contacts
    return newton_forces(bodies, contacts, state, room.f, shift, wanted, fresh, room.rows, room.factors, room.step)


@kernel
def residual_at(given: BodySystem, state: BodyState, options: Options, room: BodyRoom, scale: float) -> float:
    """``mismatch``, for the driver."""
    return mismatch(given.bodies, state.phi, room.f, given.arms, scale)


@kernel
def slope_along(given: BodySystem, state: BodyState, room: BodyRoom) -> float:
    """Slope of the energy along the step."""
    return slope_of(given.bodies, room.f, room.g, room.step)


@kernel
def reach_of(given: BodySystem, room: BodyRoom) -> float:
    """Largest motion [m] by the step of a flank of the first body against that of the second."""
    return apart(room.step.dv)


@kernel
def keep(state: BodyState, room: BodyRoom) -> None:
    """Note where the step begins."""
    room.begin.phi[:], room.begin.a[:], room.begin.g[:], room.begin.v[:] = state.phi, state.a, room.g, room.v


@kernel
def move(given: BodySystem, state: BodyState, room: BodyRoom, t: float) -> None:
    """State t steps from where the step begins."""
    shift_state(given.bodies, state, room.begin, room.step, t, room.g, room.v)


@kernel
def finish(given: BodySystem, state: BodyState, room: BodyRoom) -> None:
    """Contacts at the state itself, without the round-off of the steps to it."""
    place_flanks(given.bodies, state, room.g, room.v)
    evaluate_balls(room.v, given.contacts, state, room.f)


@kernel
def least_force(given: BodySystem, state: BodyState, options: Options) -> float:
    """Least force [N] that residuals are measured by."""
    return options.floor


@kernel
def furthest(given: BodySystem, state: BodyState) -> float:
    """Furthest free motion [m]."""
    moved = 0.0
    for c in range(state.a.shape[0]):
        moved = max(moved, abs(state.a[c]) / given.arms[c])
    return moved


minimise: Callable[..., Outcome] = driver_of(__name__, "descent").minimise


@kernel
def solve_forces(
    bodies: Bodies, contacts: BallContacts, state: BodyState, options: Options, arms: Array, history: Array
) -> Outcome:
    """Minimise the energy from the given forces; arms (k,): see `lowfi.statics.shaft`; history: residual per step."""
    balls, d = state.phi.shape
    width, shape = 2 if d == 2 else 6, state.phi.shape
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    rows, factors = BallRows(np.zeros((balls, width, d)), counts, starts), room_for_factors(bodies, width * balls)
    step = ForceStep(np.empty(shape), np.empty(shape), np.zeros(state.a.shape[0]))
    begin = SearchStart(np.empty(shape), np.empty(state.a.shape[0]), np.empty(shape), np.empty(shape))
    room = BodyRoom(np.empty(shape), np.empty(shape), np.empty(shape), step, begin, rows, factors)
    place_flanks(bodies, state, room.g, room.v)
    return minimise(BodySystem(bodies, contacts, arms), state, options, history, room)


@kernel
def start_forces(bodies: Bodies, state: BodyState, springs: Array, options: Options) -> bool:
    """Start of the iteration: the bodies on one linear spring between opposite flanks in place of two contacts.

    springs (N, w, d): rows sqrt(stiffness) x direction, zero where there is none. Overwrites phi and a. No flank goes
    further from its opposite than ``options.furthest``, as in ``newton.linear_start``, unless the loads alone carry it
    there: a shaft that only contacts hold is far away without their forces.
    """
    phi, amplitude = state.phi, state.a
    balls, width = springs.shape[0], springs.shape[1]
    v0, work = bodies.v0, bodies.work
    counts, starts = np.full(balls, width, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    for i in range(balls):
        starts[i] = width * i
    factors = room_for_factors(bodies, width * balls)
    u = np.empty(width * balls)
    apply_rows(springs, counts, starts, v0, u)
    if not solve_rows(
        bodies, springs, counts, starts, factors, bool(np.bool_(True)), work, 1e-9 * options.stiffness, 0.01, u, amplitude
    ):
        return False
    phi[:, :] = 0.0
    forces_of_rows(springs, counts, starts, u, phi)
    g, v = np.empty(phi.shape), np.empty(phi.shape)
    place_flanks(bodies, state, g, v)
    if apart(v) > options.furthest and apart(v0) <= options.furthest:
        reach = max(apart(v - v0), options.furthest)
        phi *= options.furthest / reach
        amplitude *= options.furthest / reach
    return True
