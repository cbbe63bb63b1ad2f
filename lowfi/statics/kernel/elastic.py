"""Static equilibrium with elastic bodies: Newton on the contact loads, the bodies' compliance between all contacts given.

The flanks move by v = v_0 + G phi + R a: G the compliance of the bodies, R motions that nothing but the contacts resists.
Every ball takes the forces f(v) on its flanks; at the solution phi = f(v). With the stiffness S^T S of all balls, factored
ball by ball, a step solves

    (I + S G S^T) u = S (G (f - phi) + R da),    R^T (f - S^T u) + work = 0:                                           (1)

Newton on the convex energy phi G phi/2 - work a + balls(v), whose unknowns never are the beam's nodes.

A ball has its centre and one amplitude of its body's deformation for unknowns, eliminated inside, and every contact has
parts e F and h F^(4/3) besides Hertz's C F^(2/3). Where only two opposite flanks carry load, a ball depends only on their
relative motion, and has a closed form.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel, load_driver
from rollbench.lowfi.statics.kernel_types import (
    Array,
    BallContacts,
    BallRows,
    Bodies,
    BodyState,
    BodySystem,
    BodyWorkspace,
    ForceStep,
    Options,
    Outcome,
    SearchStart,
)

from .ball import BODY, FORCE, KN, KT, MX, MZ, ball_mismatch, settle_ball
from .contact import contact_law
from .rollers import roller_elements, roller_rows


@kernel
def body_motion(bodies: Bodies, phi: Array, out: Array) -> None:
    """Write out (N, d) = G phi: first and second body act on the first and second half of the flanks (one body: on all)."""
    first, second = bodies.first, bodies.second
    n, d = phi.shape
    if second.shape[0] == 0:
        out.ravel()[:] = np.dot(first, phi.ravel())
        return
    h = d // 2
    out[:, :h] = np.dot(first, np.ascontiguousarray(phi[:, :h]).ravel()).reshape(n, h)
    out[:, h:] = np.dot(second, np.ascontiguousarray(phi[:, h:]).ravel()).reshape(n, h)


@kernel
def couple(bodies: Bodies, rows: BallRows, M: Array) -> None:
    """Write M (q, q) = I + S G S^T of (1)."""
    half = rows.S.shape[2] // (2 if bodies.second.shape[0] else 1)
    M[:] = np.eye(M.shape[0])
    add_body(bodies.first, rows, 0, half, M)
    if bodies.second.shape[0]:
        add_body(bodies.second, rows, half, half, M)


@kernel
def add_body(G: Array, rows: BallRows, first: int, width: int, M: Array) -> None:
    """Add S G S^T of a body whose flanks' motions are ``width`` of each ball's, from ``first`` on."""
    S, counts, starts = rows
    moved = np.empty((M.shape[0], G.shape[0]))
    for i in range(S.shape[0]):
        of_ball = np.ascontiguousarray(S[i, : counts[i], first : first + width])
        moved[starts[i] : starts[i] + counts[i]] = np.dot(of_ball, G[width * i : width * (i + 1)])
    for i in range(S.shape[0]):
        of_ball = np.ascontiguousarray(S[i, : counts[i], first : first + width].T)
        by_ball = np.ascontiguousarray(moved[:, width * i : width * (i + 1)])
        M[:, starts[i] : starts[i] + counts[i]] += np.dot(by_ball, of_ball)


@kernel
def cholesky_lower(M: Array) -> bool:
    """Overwrite M (its lower triangle given) by its Cholesky factor (LAPACK); False where M is not positive definite."""
    try:
        M[:, :] = np.linalg.cholesky(M)
    except Exception:  # the only one that numba can name; LinAlgError is all that a finite matrix can raise
        return False
    return True


@kernel
def triangular(M: Array, b: Array) -> None:
    """Overwrite b by (L L^T)^-1 b, L in the lower triangle of M."""
    for j in range(b.shape[0]):
        b[j] = (b[j] - np.sum(M[j, :j] * b[:j])) / M[j, j]
    for j in range(b.shape[0] - 1, -1, -1):
        b[j] /= M[j, j]
        b[:j] -= b[j] * M[j, :j]


@kernel
def apply_rows(rows: BallRows, x: Array, out: Array) -> None:
    """Write out (q,) = S x for motions x (N, d)."""
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[starts[i] + p] = np.sum(S[i, p] * x[i])


@kernel
def forces_of_rows(rows: BallRows, u: Array, out: Array) -> None:
    """Subtract S^T u from out (N, d)."""
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[i] -= S[i, p] * u[starts[i] + p]


@kernel
def border(R: Array, rows: BallRows, L: Array, u: Array, target: Array, hold: float, out: Array) -> bool:
    """Return whether the free motions are resisted; write their amplitudes out (k,), and u with them.

    Amplitudes a of the free motions R (N, d, k) with (S R)^T u = target (k,). u holds M^-1 b on entry and M^-1 (b + S R a)
    on return, L the factor of M; hold [N/m]: stiffness added to the free motions.
    """
    k, total = R.shape[2], u.shape[0]
    plain, Z = np.empty((k, total)), np.empty((k, total))
    for c in range(k):
        apply_rows(rows, R[:, :, c], plain[c])
        Z[c] = plain[c]
        triangular(L, Z[c])
    # Schur complement of the bordered system: (S R)^T M^-1 (S R)
    schur = np.dot(plain, Z.T) + hold * np.eye(k)
    if not cholesky_lower(schur):
        return False
    out[:] = target - np.dot(plain, u)
    triangular(schur, out)
    u += np.dot(out, Z)
    return True


@kernel
def flank_rows(contact: Array, local: Array, rows: Array) -> int:
    """Write rows S (6, 8) with S^T S the ball's Hessian by the motions of its flanks; return how many.

    The square roots sqrt(k) d of the contacts' stiffnesses by the flanks are orthogonalised (Householder) against those by
    centre and amplitude: no difference of large numbers.
    """
    A = np.zeros((9, 3))
    B = np.zeros((9, 8))
    n = 0
    for s in range(4):
        if contact[s, FORCE] <= 0.0:
            continue
        mx, mz = contact[s, MX], contact[s, MZ]
        for tangential in range(2):
            k = sqrt(contact[s, KN] if tangential == 0 else contact[s, KT])
            dx, dz = (mx, mz) if tangential == 0 else (-mz, mx)
            # columns of A: centre x, z and amplitude; of B: motions of the flanks
            A[n, 0], A[n, 1] = k * dx, k * dz
            A[n, 2] = -k * local[s, BODY] if tangential == 0 else 0.0
            B[n, 2 * s], B[n, 2 * s + 1] = k * dx, k * dz
            n += 1
    if n == 0:
        return 0
    A[n, 2] = 1.0  # the amplitude's stiffness
    n += 1
    used = min(3, n)
    for c in range(used):  # what is left of B below A's triangle is orthogonal to centre and amplitude
        norm = 0.0
        for i in range(c, n):
            norm += A[i, c] * A[i, c]
        norm = sqrt(norm)
        if A[c, c] > 0.0:
            norm = -norm
        A[c, c] -= norm
        size = 0.0
        for i in range(c, n):
            size += A[i, c] * A[i, c]
        if size == 0.0:
            continue
        for j in range(c + 1, 3):
            reflect(A[:, c], A[:, j], c, n, size)
        for j in range(8):
            reflect(A[:, c], B[:, j], c, n, size)
    for i in range(used, n):
        for j in range(8):
            rows[i - used, j] = B[i, j]
    return n - used


@kernel
def reflect(direction: Array, x: Array, first: int, last: int, size: float) -> None:
    """Apply the Householder reflection of x[first:last] by ``direction`` of squared length ``size``."""
    dot = 0.0
    for i in range(first, last):
        dot += direction[i] * x[i]
    dot *= 2.0 / size
    for i in range(first, last):
        x[i] -= dot * direction[i]


@kernel
def full_balls(v: Array, contacts: BallContacts, inner: Array, contact: Array, f: Array) -> tuple[float, float]:
    """Write the forces f (N, 8) of all balls on their flanks at motions v (N, 8); return energy and largest force.

    Fills inner (N, 3) and contact (N, 4, 5). Rollers come after the balls.
    """
    geometry, closure, local, r_ball, profile = contacts[:5]
    energy, scale, tiny = 0.0, 0.0, contacts.tiny
    balls = r_ball.shape[0]
    for i in range(balls):
        shift = v[i].reshape(4, 2)
        energy += settle_ball(inner[i], shift, geometry[i], closure[i], local[i], r_ball[i], profile[i], tiny, contact[i])
        for s in range(4):
            force = contact[i, s, FORCE]
            scale = max(scale, force)
            f[i, 2 * s] = force * contact[i, s, MX] if force > 0.0 else 0.0
            f[i, 2 * s + 1] = force * contact[i, s, MZ] if force > 0.0 else 0.0
    stored, largest = roller_elements(v[balls:], contacts.rollers, contact[balls:], f[balls:], tiny)
    return energy + stored, max(scale, largest)


@kernel
def pair_balls(v: Array, contacts: BallContacts, contact: Array, f: Array) -> tuple[float, float]:
    """Compute forces and energy, as `full_balls`, for balls between two opposite arcs a and b.

    v (N, 2): motion of a less that of b. The ball's centre lies on the line of the arcs' centres D + v, and the
    interference is its nominal value plus |D + v| - |D|; the two contacts are one law in series. pair (N, 7): D, |D|,
    nominal interference, C, e and h of both contacts together; contact (N, 5) as one contact on flank a.
    """
    pair = contacts.pair
    energy, scale = 0.0, 0.0
    for i in range(v.shape[0]):
        dx, dz, size0 = pair[i, 0], pair[i, 1], pair[i, 2]
        vx, vz = v[i, 0], v[i, 1]
        x, z = dx + vx, dz + vz
        size = sqrt(x * x + z * z)
        contact[i, FORCE] = 0.0
        f[i, 0], f[i, 1] = 0.0, 0.0
        if size <= 1e-30:
            continue
        delta = pair[i, 3] + (vx * (dx + x) + vz * (dz + z)) / (size + size0)
        contact[i, MX], contact[i, MZ] = -x / size, -z / size
        if delta > 0.0:
            force, slope, work = contact_law(delta, pair[i, 4], pair[i, 5], pair[i, 6])
            if force > contacts.tiny:
                energy += work
                scale = max(scale, force)
                contact[i, FORCE], contact[i, KN], contact[i, KT] = force, slope, force / size
                f[i, 0], f[i, 1] = force * contact[i, MX], force * contact[i, MZ]
    return energy, scale


@kernel
def evaluate_balls(v: Array, contacts: BallContacts, state: BodyState, f: Array) -> tuple[float, float]:
    """Write the forces of all balls at motions v, by `pair_balls` or `full_balls`; return energy and largest force."""
    if v.shape[1] == 2:
        return pair_balls(v, contacts, state.contact[:, 0], f)
    return full_balls(v, contacts, state.inner, state.contact, f)


@kernel
def ball_rows(contacts: BallContacts, contact: Array, S: Array, counts: Array) -> int:
    """Write rows S (N, 6 or 2, d) of all balls and rollers, and their numbers; return the total."""
    total = 0
    d = S.shape[2]
    for i in range(S.shape[0]):
        if i >= contacts.r_ball.shape[0]:
            counts[i] = roller_rows(contact[i], S[i])
        elif d == 8:
            counts[i] = flank_rows(contact[i], contacts.local[i], S[i])
        elif contact[i, 0, FORCE] > 0.0:
            mx, mz = contact[i, 0, MX], contact[i, 0, MZ]
            # rows along the normal and the tangent
            kn, kt = sqrt(contact[i, 0, KN]), sqrt(contact[i, 0, KT])
            S[i, 0, 0], S[i, 0, 1] = kn * mx, kn * mz
            S[i, 1, 0], S[i, 1, 1] = -kt * mz, kt * mx
            counts[i] = 2
        else:
            counts[i] = 0
        total += counts[i]
    return total


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
    """Return the energy of the bodies less the work of the loads on the free motions."""
    return float(0.5 * np.sum(state.phi * g) - np.sum(bodies.work * state.a))


@kernel
def place_flanks(bodies: Bodies, state: BodyState, g: Array, v: Array) -> None:
    """Fill g = G phi and v = v0 + g + R a from the state."""
    body_motion(bodies, state.phi, g)
    v[:] = bodies.v0 + g
    add_free(bodies.R, state.a, v)


@kernel
def apart(v: Array) -> float:
    """Return the largest motion [m] of a flank of the first body against that of the second.

    v (N, d): of the flanks, d = 2 where it is of both against one another.
    """
    half = v.shape[1] // 2
    return float(np.max(np.abs(v)) if half == 1 else np.max(np.abs(v[:, :half] - v[:, half:])))


@kernel
def unbalanced(state: BodyState, scale: float) -> float:
    """Return the largest net contact load on a ball over ``scale`` [N].

    None on balls between two opposite arcs, by closed form.
    """
    return 0.0 if state.contact.shape[1] == 1 else ball_mismatch(state.contact, scale)


@kernel
def energy_at(given: BodySystem, state: BodyState, workspace: BodyWorkspace) -> tuple[float, float]:
    """Return the energy of bodies and balls, and the largest contact load; fill the forces on the flanks."""
    energy, scale = evaluate_balls(workspace.v, given.contacts, state, workspace.f)
    return energy + stored(given.bodies, state, workspace.g), scale


@kernel
def find_step(
    given: BodySystem, state: BodyState, options: Options, workspace: BodyWorkspace, shift: float, fresh: bool
) -> bool:
    """Write Newton's step of forces and free motions.

    shift [N/m]: stiffness that limits free motions where no contact resists them.
    """
    bodies, rows, f = given.bodies, workspace.rows, workspace.f
    R, counts, starts = bodies.R, rows.counts, rows.starts
    dphi, dv, da = workspace.step
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
def residual_at(given: BodySystem, state: BodyState, options: Options, workspace: BodyWorkspace, scale: float) -> float:
    """Return the largest difference of assumed and true flank forces over ``scale`` [N].

    And of the unbalanced loads on free motions.
    """
    bodies = given.bodies
    worst = float(np.max(np.abs(workspace.f - state.phi)))
    for c in range(bodies.work.shape[0]):
        worst = max(worst, abs(bodies.work[c] + np.sum(bodies.R[:, :, c] * workspace.f)))
    return worst / scale if scale > 0.0 else worst


@kernel
def slope_along(given: BodySystem, state: BodyState, workspace: BodyWorkspace) -> float:
    """Return the slope of the energy along the step."""
    step = workspace.step
    return float(np.sum(step.dphi * workspace.g) - np.sum(workspace.f * step.dv) - np.sum(given.bodies.work * step.da))


@kernel
def reach_of(given: BodySystem, workspace: BodyWorkspace) -> float:
    """Return the largest motion [m] by the step of a flank of the first body against that of the second."""
    return apart(workspace.step.dv)


@kernel
def keep(state: BodyState, workspace: BodyWorkspace) -> None:
    """Store where the step begins."""
    workspace.begin.phi[:], workspace.begin.a[:], workspace.begin.g[:], workspace.begin.v[:] = (
        state.phi,
        state.a,
        workspace.g,
        workspace.v,
    )


@kernel
def move(given: BodySystem, state: BodyState, workspace: BodyWorkspace, t: float) -> None:
    """Set the state to t steps from where the step begins, with the motions of bodies and flanks there."""
    begin, step = workspace.begin, workspace.step
    state.phi[:], state.a[:] = begin.phi + t * step.dphi, begin.a + t * step.da
    workspace.v[:], workspace.g[:] = begin.v + t * step.dv, begin.g + t * step.dv
    add_free(given.bodies.R, -t * step.da, workspace.g)


@kernel
def finish(given: BodySystem, state: BodyState, options: Options, workspace: BodyWorkspace) -> None:
    """Compute the contacts at the state, without the round-off of the steps to it where that is the larger one.

    Bodies that bend much under contact loads which almost cancel have the larger round-off in G phi.
    """
    v, residual = workspace.v.copy(), residual_at(given, state, options, workspace, 1.0)
    place_flanks(given.bodies, state, workspace.g, workspace.v)
    evaluate_balls(workspace.v, given.contacts, state, workspace.f)
    if residual_at(given, state, options, workspace, 1.0) > residual:
        workspace.v[:] = v
        evaluate_balls(workspace.v, given.contacts, state, workspace.f)


@kernel
def least_force(given: BodySystem, state: BodyState, options: Options) -> float:
    """Return the least force [N] that residuals are measured by."""
    return options.floor


@kernel
def furthest(given: BodySystem, state: BodyState) -> float:
    """Return the furthest free motion [m]."""
    return float(np.max(np.abs(state.a))) if state.a.size else 0.0


minimise: Callable[..., Outcome] = load_driver(__name__, "descent").minimise


@kernel
def solve_forces(given: BodySystem, state: BodyState, options: Options, start: bool) -> Outcome:
    """Minimise the energy, from the linear start or from the given forces."""
    balls, d = state.phi.shape
    width, shape = 2 if d == 2 else 6, state.phi.shape
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    rows = BallRows(np.zeros((balls, width, d)), counts, starts)
    step = ForceStep(np.empty(shape), np.empty(shape), np.zeros(state.a.shape[0]))
    begin = SearchStart(np.empty(shape), np.empty(state.a.shape[0]), np.empty(shape), np.empty(shape))
    workspace = BodyWorkspace(np.empty(shape), np.empty(shape), np.empty(shape), step, begin, rows)
    if start:
        start_on_springs(given, state, options, workspace)
    place_flanks(given.bodies, state, workspace.g, workspace.v)
    return minimise(given, state, options, workspace)


@kernel
def start_on_springs(given: BodySystem, state: BodyState, options: Options, workspace: BodyWorkspace) -> None:
    """Go to the equilibrium of the bodies on one linear spring between opposite flanks in place of two contacts.

    Where it can be found. No flank goes further from its opposite than ``options.furthest``, as in ``beam``, unless the
    loads carry it there: a shaft that only contacts support is far away without their forces.
    """
    bodies, springs, v = given.bodies, given.springs, workspace.v
    balls, width = springs.shape[0], springs.shape[1]
    rows = BallRows(springs, np.full(balls, width, dtype=np.int64), width * np.arange(balls))
    u = np.empty(width * balls)
    apply_rows(rows, bodies.v0, u)
    if not solve_rows(bodies, rows, bodies.work, 1e-9 * options.stiffness, u, state.a):
        return
    state.phi[:, :] = 0.0
    forces_of_rows(rows, u, state.phi)
    place_flanks(bodies, state, workspace.g, v)
    if apart(v) > options.furthest and apart(bodies.v0) <= options.furthest:
        shorter = options.furthest / max(apart(v - bodies.v0), options.furthest)
        state.phi[:] *= shorter
        state.a[:] *= shorter
