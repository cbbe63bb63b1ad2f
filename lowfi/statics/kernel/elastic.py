"""Static equilibrium with elastic bodies: Newton on the contact forces, the bodies' compliance between all contacts given.

The flanks move by v = v_0 + G phi + R a: G the compliance of the bodies, R motions that nothing but the contacts resists.
Every ball takes the forces f(v) on its flanks; at the solution phi = f(v). With the stiffness S^T S of all balls, factored
ball by ball, a step solves (I + S G S^T) u = S (G (f - phi) + R da), R^T (f - S^T u) + work = 0: Newton on the convex
energy phi G phi/2 - work a + balls(v), whose unknowns never are the beam's nodes.
"""

from collections.abc import Callable

import numpy as np

from rollbench.lowfi.jit import driver_of, kernel
from rollbench.lowfi.statics.kernel_types import (
    Array,
    BallRows,
    Bodies,
    BodyRoom,
    BodyState,
    BodySystem,
    ForceStep,
    Options,
    Outcome,
    SearchStart,
)

from .ball import ball_mismatch
from .coupling import apply_rows, body_motion, border, cholesky_lower, couple, forces_of_rows, triangular
from .elastic_balls import ball_rows, evaluate_balls

#: See ``descent``: under a contact that vanishes, rows of a step before are too stiff.
KEPT = 0.0


@kernel
def solve_rows(bodies: Bodies, rows: BallRows, target: Array, hold: float, u: Array, a: Array) -> bool:
    """Solve (I + S G S^T) u - S R a = u (given), (S R)^T u + hold a = target; False where the matrix is not positive."""
    M = np.empty((u.shape[0], u.shape[0]))
    couple(bodies, rows, M)
    if not cholesky_lower(M):
        return False
    triangular(M, u)
    return bodies.R.shape[2] == 0 or border(bodies.R, rows, M, u, target, hold, a)


@kernel
def add_free(R: Array, a: Array, out: Array) -> None:
    """Add R a, the motions of the flanks by free motions a (k,), to ``out`` (N, d)."""
    for c in range(a.shape[0]):
        out += a[c] * R[:, :, c]


@kernel
def stored(bodies: Bodies, state: BodyState, g: Array) -> float:
    """Energy of the bodies less the work of the loads on the free motions."""
    return float(0.5 * np.sum(state.phi * g) - np.sum(bodies.work * state.a))


@kernel
def place_flanks(bodies: Bodies, state: BodyState, g: Array, v: Array) -> None:
    """Fill g = G phi and v = v0 + g + R a from the state."""
    body_motion(bodies, state.phi, g)
    v[:] = bodies.v0 + g
    add_free(bodies.R, state.a, v)


@kernel
def apart(v: Array) -> float:
    """Largest motion [m] of a flank of the first body against that of the second; v (N, d): of the flanks, d = 2 where it
    is of both against one another."""
    half = v.shape[1] // 2
    return float(np.max(np.abs(v)) if half == 1 else np.max(np.abs(v[:, :half] - v[:, half:])))


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
def find_step(given: BodySystem, state: BodyState, options: Options, room: BodyRoom, shift: float, fresh: bool) -> bool:
    """Newton's step of forces and free motions; shift [N/m]: stiffness that keeps free motions from running away where no
    contact holds them."""
    bodies, rows, f = given.bodies, room.rows, room.f
    R, counts, starts = bodies.R, rows.counts, rows.starts
    dphi, dv, da = room.step
    ball_rows(given.contacts, state.contact, rows.S, counts)
    starts[1:] = np.cumsum(counts)[:-1]
    dphi[:] = f - state.phi
    body_motion(bodies, dphi, dv)
    u = np.empty(starts[-1] + counts[-1])
    apply_rows(rows, dv, u)
    target = bodies.work.copy()
    for c in range(R.shape[2]):
        target[c] += np.sum(R[:, :, c] * f)
    if not solve_rows(bodies, rows, target, shift, u, da):
        return False
    forces_of_rows(rows, u, dphi)
    body_motion(bodies, dphi, dv)
    add_free(R, da, dv)
    return True


@kernel
def residual_at(given: BodySystem, state: BodyState, options: Options, room: BodyRoom, scale: float) -> float:
    """Largest difference of assumed and true flank forces, and unbalanced load on a free motion, over ``scale`` [N]."""
    bodies, arms = given.bodies, given.arms
    worst = float(np.max(np.abs(room.f - state.phi)))
    for c in range(arms.shape[0]):
        worst = max(worst, abs(bodies.work[c] + np.sum(bodies.R[:, :, c] * room.f)) * arms[c])
    return worst / scale if scale > 0.0 else worst


@kernel
def slope_along(given: BodySystem, state: BodyState, room: BodyRoom) -> float:
    """Slope of the energy along the step."""
    step = room.step
    return float(np.sum(step.dphi * room.g) - np.sum(room.f * step.dv) - np.sum(given.bodies.work * step.da))


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
    """State t steps from where the step begins, with the motions of bodies and flanks there."""
    begin, step = room.begin, room.step
    state.phi[:], state.a[:] = begin.phi + t * step.dphi, begin.a + t * step.da
    room.v[:], room.g[:] = begin.v + t * step.dv, begin.g + t * step.dv
    add_free(given.bodies.R, -t * step.da, room.g)


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
    return float(np.max(np.abs(state.a) / given.arms)) if state.a.size else 0.0


minimise: Callable[..., Outcome] = driver_of(__name__, "descent").minimise


@kernel
def solve_forces(given: BodySystem, state: BodyState, options: Options, start: bool) -> Outcome:
    """Minimise the energy, from the linear start or from the given forces."""
    balls, d = state.phi.shape
    width, shape = 2 if d == 2 else 6, state.phi.shape
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    rows = BallRows(np.zeros((balls, width, d)), counts, starts)
    step = ForceStep(np.empty(shape), np.empty(shape), np.zeros(state.a.shape[0]))
    begin = SearchStart(np.empty(shape), np.empty(state.a.shape[0]), np.empty(shape), np.empty(shape))
    room = BodyRoom(np.empty(shape), np.empty(shape), np.empty(shape), step, begin, rows)
    if start:
        start_on_springs(given, state, options, room)
    place_flanks(given.bodies, state, room.g, room.v)
    return minimise(given, state, options, room)


@kernel
def start_on_springs(given: BodySystem, state: BodyState, options: Options, room: BodyRoom) -> None:
    """Go to the equilibrium of the bodies on one linear spring between opposite flanks in place of two contacts, where it
    can be found.

    No flank goes further from its opposite than ``options.furthest``, as in ``newton``, unless the loads alone carry it
    there: a shaft that only contacts hold is far away without their forces.
    """
    bodies, springs, v = given.bodies, given.springs, room.v
    balls, width = springs.shape[0], springs.shape[1]
    rows = BallRows(springs, np.full(balls, width, dtype=np.int64), width * np.arange(balls))
    u = np.empty(width * balls)
    apply_rows(rows, bodies.v0, u)
    if not solve_rows(bodies, rows, bodies.work, 1e-9 * options.stiffness, u, state.a):
        return
    state.phi[:, :] = 0.0
    forces_of_rows(rows, u, state.phi)
    place_flanks(bodies, state, room.g, v)
    if apart(v) > options.furthest and apart(bodies.v0) <= options.furthest:
        shorter = options.furthest / max(apart(v - bodies.v0), options.furthest)
        state.phi[:] *= shorter
        state.a[:] *= shorter
