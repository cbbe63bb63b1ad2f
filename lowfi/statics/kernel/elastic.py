"""Static equilibrium of rolling elements between elastic bodies, by Newton's method on the contact forces.

The input is the compliance matrix G of the bodies (for example screw and nut), which gives the motion of the groove flank
at every contact by the force on every other contact. The flanks move by v = v_0 + G phi + R a. Here v_0 is the motion by
the applied loads, phi are the forces on the flanks, and a are the amplitudes of the free motions R: motions of a body that
only the contacts resist. A ball exerts the forces f(v) on its flanks; at the solution phi = f(v). The stiffness of all
balls is written as S^T S, one block of rows S for each ball. A Newton step solves for u

    (I + S G S^T) u = S (G (f - phi) + R da),    R^T (f - S^T u) + work = 0.                                           (1)

This minimises the convex energy phi G phi/2 - work a + (energy of the balls at v). Nodal motions of a beam are not among
the unknowns.

The unknowns of a ball are the position of its centre and one amplitude of the deformation of its body; they are eliminated
ball by ball. The approach at a contact of force F is C F^(2/3) (Hertz) + e F + h F^(4/3). Where only two opposite flanks
carry load, the forces of a ball depend on the relative motion of these flanks only and have a closed form.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel, load_solver_copy
from rollbench.lowfi.statics.kernel_types import (
    Array,
    BallContacts,
    BodySystem,
    BodyWorkspace,
    ElasticBodies,
    ForceState,
    ForceStep,
    LineSearchStart,
    NewtonOptions,
    Outcome,
    StiffnessFactors,
)

from .ball import BODY, FORCE, KN, KT, MX, MZ, find_ball_equilibrium, largest_net_ball_force
from .contact import contact_law
from .rollers import compute_roller_forces, write_stiffness_factors_of_roller


@kernel
def flank_motions_by_forces(bodies: ElasticBodies, phi: Array, out: Array) -> None:
    """Compute the motions G phi [m] of the groove flanks by the contact forces ``phi`` (N, d) [N] on the elastic bodies.

    The motions are written to ``out`` (N, d). Each ball has d motions of its flanks. With two bodies (screw and nut), the
    first half of these columns belongs to the first body and the second half to the second one. With one body, all columns
    belong to it. G: compliance matrix of the bodies.
    """
    first, second = bodies.first_compliance, bodies.second_compliance
    n, d = phi.shape
    if second.shape[0] == 0:
        out.ravel()[:] = np.dot(first, phi.ravel())
        return
    h = d // 2
    out[:, :h] = np.dot(first, np.ascontiguousarray(phi[:, :h]).ravel()).reshape(n, h)
    out[:, h:] = np.dot(second, np.ascontiguousarray(phi[:, h:]).ravel()).reshape(n, h)


@kernel
def assemble_newton_matrix(bodies: ElasticBodies, rows: StiffnessFactors, M: Array) -> None:
    """Write the matrix M (q, q) = I + S G S^T, with which a Newton step for the contact forces is solved.

    G is the compliance matrix of the elastic ``bodies``. S is the matrix of the q ``rows`` of factors with which S^T S is
    the stiffness matrix of the balls.
    """
    half = rows.S.shape[2] // (2 if bodies.second_compliance.shape[0] else 1)
    M[:] = np.eye(M.shape[0])
    add_body_compliance_to_newton_matrix(bodies.first_compliance, rows, 0, half, M)
    if bodies.second_compliance.shape[0]:
        add_body_compliance_to_newton_matrix(bodies.second_compliance, rows, half, half, M)


@kernel
def add_body_compliance_to_newton_matrix(G: Array, rows: StiffnessFactors, first: int, width: int, M: Array) -> None:
    """Add S G S^T of one elastic body to the matrix M of the Newton step for the contact forces.

    G [m/N] is the body's compliance matrix. S is the matrix of the ``rows`` of factors with which S^T S is the stiffness
    matrix of the balls. Of the flank motions of each ball, those with the indices ``first`` to ``first + width - 1`` are
    motions of this body.
    """
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
    """Replace the symmetric matrix M by its lower Cholesky factor; return False if M is not positive definite.

    Only the lower triangle of M is read.
    """
    try:
        M[:, :] = np.linalg.cholesky(M)
    except Exception:  # the only one that numba can name; LinAlgError is all that a finite matrix can raise
        return False
    return True


@kernel
def cholesky_substitute(M: Array, b: Array) -> None:
    """Solve M x = b with M = L L^T and write x over b.

    ``M``: matrix whose lower triangle holds the Cholesky factor L, from `cholesky_lower`; ``b`` (q,): right-hand side.
    """
    for j in range(b.shape[0]):
        b[j] = (b[j] - np.sum(M[j, :j] * b[:j])) / M[j, j]
    for j in range(b.shape[0] - 1, -1, -1):
        b[j] /= M[j, j]
        b[:j] -= b[j] * M[j, :j]


@kernel
def multiply_by_stiffness_rows(rows: StiffnessFactors, x: Array, out: Array) -> None:
    """Write the product S x of the balls' stiffness factors S with the motions x (N, d) [m] of their flanks to ``out``.

    S^T S is the stiffness matrix of the balls; ``rows`` holds the q rows of S ball by ball; ``out``: array (q,).
    """
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[starts[i] + p] = np.sum(S[i, p] * x[i])


@kernel
def subtract_flank_forces(rows: StiffnessFactors, u: Array, out: Array) -> None:
    """Subtract from the ball forces ``out`` (N, d) [N] on the flanks their change S^T u in a Newton step.

    S is the matrix of the q ``rows`` of factors with which S^T S is the stiffness of the balls; u (q,): solution of
    `solve_newton_equations`.
    """
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[i] -= S[i, p] * u[starts[i] + p]


@kernel
def solve_free_motions(
    R: Array, rows: StiffnessFactors, L: Array, u: Array, target: Array, added_stiffness: float, out: Array
) -> bool:
    """Solve for the amplitudes of the free motions of the bodies, which only the contacts resist, in a Newton step.

    M is the matrix of the Newton step without free motions, from `assemble_newton_matrix`; S is the matrix of the ``rows``
    of factors of the balls' stiffness S^T S; R (N, d, k) are the motions of the flanks per metre of each free motion.
    Writes the amplitudes a (k,) [m] of the free motions to ``out``, such that (S R)^T u + added_stiffness a = target (k,)
    [N]. On entry u is M^-1 b, with the right-hand side b of `solve_newton_equations`; on return it is M^-1 (b + S R a). L
    is the Cholesky factor of M; ``added_stiffness`` [N/m] limits the free motions. Returns False if some free motion meets
    no resistance.
    """
    k, total = R.shape[2], u.shape[0]
    plain, Z = np.empty((k, total)), np.empty((k, total))
    for c in range(k):
        multiply_by_stiffness_rows(rows, R[:, :, c], plain[c])
        Z[c] = plain[c]
        cholesky_substitute(L, Z[c])
    # Schur complement of the bordered system: (S R)^T M^-1 (S R)
    schur = np.dot(plain, Z.T) + added_stiffness * np.eye(k)
    if not cholesky_lower(schur):
        return False
    out[:] = target - np.dot(plain, u)
    cholesky_substitute(schur, out)
    u += np.dot(out, Z)
    return True


@kernel
def write_stiffness_factors_of_ball(contact: Array, local: Array, rows: Array) -> int:
    """Write factors S of a ball's stiffness S^T S against motions of its four flanks; return the number of rows of S used.

    S is written to ``rows`` (6, 8). Each contact gives rows sqrt(k) d, with its normal or tangential stiffness k and
    direction d. A Householder transformation makes the flank columns of these rows orthogonal to the columns of ball centre
    and body deformation, which eliminates these unknowns without subtracting large numbers. ``contact`` (4, 5): forces,
    normals and stiffnesses; ``local`` (4, 3): compliance terms of the contacts, see `kernel.ball`.
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
    for c in range(used):  # afterwards the rows of B below the triangle of A are orthogonal to centre and amplitude
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
            reflect_by_householder(A[:, c], A[:, j], c, n, size)
        for j in range(8):
            reflect_by_householder(A[:, c], B[:, j], c, n, size)
    for i in range(used, n):
        for j in range(8):
            rows[i - used, j] = B[i, j]
    return n - used


@kernel
def reflect_by_householder(direction: Array, x: Array, first: int, last: int, size: float) -> None:
    """Reflect the elements x[first:last] of a vector at the plane normal to ``direction`` (Householder transformation).

    size: squared length of ``direction``.
    """
    dot = 0.0
    for i in range(first, last):
        dot += direction[i] * x[i]
    dot *= 2.0 / size
    for i in range(first, last):
        x[i] -= dot * direction[i]


@kernel
def solve_balls_of_four_flanks(
    v: Array, contacts: BallContacts, inner: Array, contact: Array, f: Array
) -> tuple[float, float]:
    """Find the equilibrium of each ball between four flanks, and the forces of each roller, at known flank motions.

    v (N, 8): motions of the flanks [m] of N balls and rollers; the rollers come after the balls. Writes the forces f (N, 8)
    [N] on the flanks, the ball centres [m] and deformation amplitudes ``inner`` (N, 3), and ``contact`` (N, 4, 5): force,
    unit normal and stiffnesses of each contact. Returns the energy [J] and the largest contact force [N]. ``contacts``:
    contact data of all balls and rollers.
    """
    geometry, closure, local, r_ball, profile = contacts[:5]
    energy, scale, tiny = 0.0, 0.0, contacts.unloaded_force_limit
    balls = r_ball.shape[0]
    for i in range(balls):
        shift = v[i].reshape(4, 2)
        ball = geometry[i], closure[i], local[i], r_ball[i], profile[i]
        energy += find_ball_equilibrium(inner[i], shift, *ball, tiny, contact[i])
        for s in range(4):
            force = contact[i, s, FORCE]
            scale = max(scale, force)
            f[i, 2 * s] = force * contact[i, s, MX] if force > 0.0 else 0.0
            f[i, 2 * s + 1] = force * contact[i, s, MZ] if force > 0.0 else 0.0
    stored, largest = compute_roller_forces(v[balls:], contacts.rollers, contact[balls:], f[balls:], tiny)
    return energy + stored, max(scale, largest)


@kernel
def solve_balls_of_flank_pair(v: Array, contacts: BallContacts, contact: Array, f: Array) -> tuple[float, float]:
    """Compute forces and energy of balls between two opposite circular flanks a and b, in closed form.

    v (N, 2): motion of flank a minus that of flank b [m]. The vector from the centre of arc b to that of arc a is D
    nominally and D + v in the deformed state; the centre of the ball lies on its line. The interference is the nominal
    value plus |D + v| - |D|. The two contacts act in series: their approaches add up to C F^(2/3) + e F + h F^(4/3) under
    the force F. The rows of ``contacts.flank_pair_data`` (N, 7) hold D (two components), |D|, the nominal interference, C,
    e and h. Writes the forces f (N, 2) [N] on flank a, and ``contact`` (N, 5) as one contact on flank a. Returns the energy
    [J] and the largest contact force [N].
    """
    pair = contacts.flank_pair_data
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
            if force > contacts.unloaded_force_limit:
                energy += work
                scale = max(scale, force)
                contact[i, FORCE], contact[i, KN], contact[i, KT] = force, slope, force / size
                f[i, 0], f[i, 1] = force * contact[i, MX], force * contact[i, MZ]
    return energy, scale


@kernel
def evaluate_balls(v: Array, contacts: BallContacts, state: ForceState, f: Array) -> tuple[float, float]:
    """Write the forces f [N] of all rolling elements for flank motions v [m]; return energy [J] and largest force [N].

    Uses the closed form `solve_balls_of_flank_pair` where v has two columns (one pair of flanks per ball), otherwise
    `solve_balls_of_four_flanks`. ``contacts``: contact data of balls and rollers. Ball centres and contacts are written to
    ``state``.
    """
    if v.shape[1] == 2:
        return solve_balls_of_flank_pair(v, contacts, state.contact[:, 0], f)
    return solve_balls_of_four_flanks(v, contacts, state.ball_unknowns, state.contact, f)


@kernel
def write_stiffness_factors(contacts: BallContacts, contact: Array, S: Array, counts: Array) -> int:
    """Write factors S (N, 6 or 2, d) of the stiffness matrix S^T S of each ball and roller; return the number of rows used.

    Writes the number of rows of each element to ``counts`` (N,) and returns their sum. ``contacts``: data of balls and
    rollers; ``contact``: their forces, normals and stiffnesses, from `evaluate_balls`.
    """
    total = 0
    d = S.shape[2]
    for i in range(S.shape[0]):
        if i >= contacts.r_ball.shape[0]:
            counts[i] = write_stiffness_factors_of_roller(contact[i], S[i])
        elif d == 8:
            counts[i] = write_stiffness_factors_of_ball(contact[i], contacts.compliance_terms[i], S[i])
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


#: Ratio of the residual to the smallest one so far above which the stiffness is factored again, see ``descent``. Zero: it
#: is factored in every step, because the stiffness of the previous step is too large after a contact opens.
KEPT = 0.0


@kernel
def solve_newton_equations(
    bodies: ElasticBodies, rows: StiffnessFactors, target: Array, added_stiffness: float, u: Array, a: Array
) -> bool:
    """Solve the equations of a Newton step for the contact forces and the free motions of the elastic bodies.

    G is the compliance matrix of the ``bodies``; S is the matrix of the ``rows`` of factors of the balls' stiffness S^T S;
    R are the flank motions per metre of the free motions (which only the contacts resist), and a (k,) [m] their amplitudes.
    The equations are

        (I + S G S^T) u - S R a = b,    (S R)^T u + added_stiffness a = target.

    The new contact forces are f - S^T u, where f are the forces of the balls before the step. ``u`` holds b on entry and
    the solution on return; ``a`` gets the amplitudes; ``added_stiffness`` [N/m] limits the free motions; ``target`` (k,)
    [N]: net load on each free motion before the step. Returns False if the matrix is not positive definite.
    """
    M = np.empty((u.shape[0], u.shape[0]))
    assemble_newton_matrix(bodies, rows, M)
    if not cholesky_lower(M):
        return False
    cholesky_substitute(M, u)
    return bodies.R.shape[2] == 0 or solve_free_motions(bodies.R, rows, M, u, target, added_stiffness, a)


@kernel
def add_flank_motions_by_free_motions(R: Array, a: Array, out: Array) -> None:
    """Add the flank motions R a by the bodies' free rigid motions, which only the contacts resist, to ``out`` (N, d) [m].

    R (N, d, k): motions of the flanks per metre of each free motion; a (k,): amplitudes [m].
    """
    for c in range(a.shape[0]):
        out += a[c] * R[:, :, c]


@kernel
def energy_of_bodies(bodies: ElasticBodies, state: ForceState, g: Array) -> float:
    """Return the elastic energy phi G phi/2 of the bodies minus the work of the loads on their free motions [J].

    phi: contact forces of the state; G: compliance matrix of the bodies; g (N, d): motions G phi of the flanks [m]. Free
    motions are rigid motions of a body that only the contacts resist.
    """
    return float(0.5 * np.sum(state.phi * g) - np.sum(bodies.work_on_free_motions * state.a))


@kernel
def write_flank_motions(bodies: ElasticBodies, state: ForceState, g: Array, v: Array) -> None:
    """Compute the elastic motions g = G phi and the total motions v = v0 + g + R a of the flanks (N, d) [m].

    phi: contact forces of the state; G: compliance matrix of the bodies; v0: motions by external loads; R a: motions by the
    bodies' free motions, which only the contacts resist.
    """
    flank_motions_by_forces(bodies, state.phi, g)
    v[:] = bodies.v0 + g
    add_flank_motions_by_free_motions(bodies.R, state.a, v)


@kernel
def largest_relative_flank_motion(v: Array) -> float:
    """Return the largest relative motion [m] between a flank of the first body and the opposite flank of the second.

    v (N, d): motions of the flanks, two components each. d = 8: four flanks of each ball. d = 2: one pair of flanks,
    and v is already the motion of one relative to the other.
    """
    half = v.shape[1] // 2
    return float(np.max(np.abs(v)) if half == 1 else np.max(np.abs(v[:, :half] - v[:, half:])))


@kernel
def largest_relative_net_ball_force(state: ForceState, scale: float) -> float:
    """Return the largest net force on a ball as a fraction of ``scale`` [N].

    It is zero where each ball touches two opposite flanks only, as the closed-form solution then keeps balls in
    equilibrium. ``state``: forces and normals of all contacts.
    """
    return 0.0 if state.contact.shape[1] == 1 else largest_net_ball_force(state.contact, scale)


@kernel
def energy_and_largest_force(given: BodySystem, state: ForceState, workspace: BodyWorkspace) -> tuple[float, float]:
    """Return the energy of bodies and balls [J] and the largest contact force [N] at the state.

    Writes the forces of the balls on the flanks to ``workspace.f``, and ball centres and contacts to ``state``. The flank
    motions in the workspace must be those of the state. ``given``: arrays of bodies, balls and rollers.
    """
    energy, scale = evaluate_balls(workspace.v, given.contacts, state, workspace.f)
    return energy + energy_of_bodies(given.bodies, state, workspace.g), scale


@kernel
def write_newton_step(
    given: BodySystem, state: ForceState, options: NewtonOptions, workspace: BodyWorkspace, shift: float, fresh: bool
) -> bool:
    """Write Newton's step of contact forces and free motions to the workspace; return False if it cannot be solved.

    Free motions are rigid motions of a body that only the contacts resist. shift [N/m]: stiffness added to them, which
    limits them where no contact resists. ``options`` and ``fresh`` are not used: the stiffness is factored in every step.
    ``given``: arrays of bodies, balls and rollers; ``state``: present forces and contacts.
    """
    bodies, rows, f = given.bodies, workspace.stiffness_factors, workspace.f
    R, counts, starts = bodies.R, rows.counts, rows.starts
    dphi, dv, da = workspace.step
    write_stiffness_factors(given.contacts, state.contact, rows.S, counts)
    starts[1:] = np.cumsum(counts)[:-1]
    dphi[:] = f - state.phi
    flank_motions_by_forces(bodies, dphi, dv)
    u = np.empty(starts[-1] + counts[-1])
    multiply_by_stiffness_rows(rows, dv, u)
    target = bodies.work_on_free_motions.copy()
    for c in range(R.shape[2]):
        target[c] += np.sum(R[:, :, c] * f)
    if not solve_newton_equations(bodies, rows, target, shift, u, da):
        return False
    subtract_flank_forces(rows, u, dphi)
    flank_motions_by_forces(bodies, dphi, dv)
    add_flank_motions_by_free_motions(R, da, dv)
    return True


@kernel
def relative_residual(
    given: BodySystem, state: ForceState, options: NewtonOptions, workspace: BodyWorkspace, scale: float
) -> float:
    """Return the largest unbalanced force as a fraction of ``scale`` [N].

    It is the larger of two values: the largest difference between a flank force of the state and the force that the ball
    exerts on this flank, and the largest net load on a free motion of the bodies. If ``scale`` is zero, the result is in
    newtons. The ``workspace`` holds the forces that the balls exert; ``given``: arrays of bodies, balls and rollers.
    ``options`` is not used.
    """
    bodies = given.bodies
    worst = float(np.max(np.abs(workspace.f - state.phi)))
    for c in range(bodies.work_on_free_motions.shape[0]):
        worst = max(worst, abs(bodies.work_on_free_motions[c] + np.sum(bodies.R[:, :, c] * workspace.f)))
    return worst / scale if scale > 0.0 else worst


@kernel
def energy_slope_along_step(given: BodySystem, state: ForceState, workspace: BodyWorkspace) -> float:
    """Return the derivative [J] of the energy by the step length, along the Newton step in the workspace.

    The ``workspace`` also holds the present flank motions and ball forces; ``state`` is not used.
    ``given``: arrays of bodies, balls and rollers.
    """
    step, work = workspace.step, given.bodies.work_on_free_motions
    return float(np.sum(step.dphi * workspace.g) - np.sum(workspace.f * step.dv) - np.sum(work * step.da))


@kernel
def largest_flank_motion_in_step(given: BodySystem, workspace: BodyWorkspace) -> float:
    """Return the largest relative motion [m] of two opposite flanks of a ball in the full Newton step (step length 1).

    The ``workspace`` holds the step; ``given`` is not used.
    """
    return largest_relative_flank_motion(workspace.step.dv)


@kernel
def save_line_search_start(state: ForceState, workspace: BodyWorkspace) -> None:
    """Store the current forces and motions in the workspace as the start of the line search.

    ``state``: contact forces and free motions of the bodies.
    """
    start = workspace.search_start
    start.phi[:], start.a[:], start.g[:], start.v[:] = state.phi, state.a, workspace.g, workspace.v


@kernel
def move_along_step(given: BodySystem, state: ForceState, workspace: BodyWorkspace, t: float) -> None:
    """Set forces and motions to the start of the line search plus ``t`` times the Newton step.

    The results are written to ``state``, and the flank motions to the ``workspace``, which holds start and step.
    ``given``: arrays of bodies, balls and rollers.
    """
    begin, step = workspace.search_start, workspace.step
    state.phi[:], state.a[:] = begin.phi + t * step.dphi, begin.a + t * step.da
    workspace.v[:], workspace.g[:] = begin.v + t * step.dv, begin.g + t * step.dv
    add_flank_motions_by_free_motions(given.bodies.R, -t * step.da, workspace.g)


@kernel
def complete_final_state(given: BodySystem, state: ForceState, options: NewtonOptions, workspace: BodyWorkspace) -> None:
    """Compute the contacts at the solution from those flank motions that have less round-off.

    The motions are known in two ways: summed over all Newton steps, and computed anew from the contact forces as G phi. The
    motions G phi have more round-off where the bodies bend much under contact forces that almost cancel. The motions that
    give the smaller residual are used. The contacts are written to ``state``. ``given``: arrays of bodies, balls and
    rollers.
    """
    v, residual = workspace.v.copy(), relative_residual(given, state, options, workspace, 1.0)
    write_flank_motions(given.bodies, state, workspace.g, workspace.v)
    evaluate_balls(workspace.v, given.contacts, state, workspace.f)
    if relative_residual(given, state, options, workspace, 1.0) > residual:
        workspace.v[:] = v
        evaluate_balls(workspace.v, given.contacts, state, workspace.f)


@kernel
def least_residual_force_scale(given: BodySystem, state: ForceState, options: NewtonOptions) -> float:
    """Return the lower bound of the force [N] by which unbalanced forces are divided for relative residuals.

    It is ``options.least_force_scale``; ``given`` and ``state`` are not used.
    """
    return options.least_force_scale


@kernel
def largest_displacement(given: BodySystem, state: ForceState) -> float:
    """Return the largest amplitude [m] of those rigid motions of the bodies that only the contacts resist; 0 without any.

    ``state``: amplitudes of the free motions; ``given`` is not used.
    """
    return float(np.max(np.abs(state.a))) if state.a.size else 0.0


minimise: Callable[..., Outcome] = load_solver_copy(__name__, "descent").minimise


@kernel
def solve_forces(given: BodySystem, state: ForceState, options: NewtonOptions, start: bool) -> Outcome:
    """Find the equilibrium of elastic bodies and rolling elements: minimise the energy over the contact forces.

    With ``start`` the iteration begins at the solution with linear springs as contacts, otherwise at the forces in
    ``state``, which holds the solution on return. ``given``: arrays of bodies, balls and rollers; ``options``: tolerance
    and limits of the iteration.
    """
    balls, d = state.phi.shape
    width, shape = 2 if d == 2 else 6, state.phi.shape
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    rows = StiffnessFactors(np.zeros((balls, width, d)), counts, starts)
    step = ForceStep(np.empty(shape), np.empty(shape), np.zeros(state.a.shape[0]))
    begin = LineSearchStart(np.empty(shape), np.empty(state.a.shape[0]), np.empty(shape), np.empty(shape))
    workspace = BodyWorkspace(np.empty(shape), np.empty(shape), np.empty(shape), step, begin, rows)
    if start:
        start_from_springs(given, state, options, workspace)
    write_flank_motions(given.bodies, state, workspace.g, workspace.v)
    return minimise(given, state, options, workspace)


@kernel
def start_from_springs(given: BodySystem, state: ForceState, options: NewtonOptions, workspace: BodyWorkspace) -> None:
    """Set the state to a first guess: the equilibrium with a linear spring between opposite flanks in place of each ball.

    Leaves the state unchanged if the equations cannot be solved. The solution is scaled down such that no flank moves
    further from the opposite one than ``options.max_flank_step`` [m]. It is not scaled if the loads without
    contact forces already move flanks further than that, as they do for a shaft that only the contacts support. ``given``:
    arrays of bodies, balls and rollers, with the springs; ``workspace``: work arrays, changed.
    """
    bodies, springs, v = given.bodies, given.springs, workspace.v
    balls, width = springs.shape[0], springs.shape[1]
    rows = StiffnessFactors(springs, np.full(balls, width, dtype=np.int64), width * np.arange(balls))
    u = np.empty(width * balls)
    multiply_by_stiffness_rows(rows, bodies.v0, u)
    if not solve_newton_equations(bodies, rows, bodies.work_on_free_motions, 1e-9 * options.stiffness, u, state.a):
        return
    state.phi[:, :] = 0.0
    subtract_flank_forces(rows, u, state.phi)
    write_flank_motions(bodies, state, workspace.g, v)
    limit = options.max_flank_step
    if largest_relative_flank_motion(v) > limit and largest_relative_flank_motion(bodies.v0) <= limit:
        shorter = limit / max(largest_relative_flank_motion(v - bodies.v0), limit)
        state.phi[:] *= shorter
        state.a[:] *= shorter
