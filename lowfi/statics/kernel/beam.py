"""Static equilibrium of a screw, modelled as a Timoshenko beam, with its balls in a fixed nut.

Implements equations 2.23 to 2.25 of Lin's thesis, with corrections. The energy is

    E(q) = (strain energy of the beam) - f q + sum over the balls of the contact energy, minimised over the ball's centre,

with the motions q (3 displacements and 3 rotations) of the nodes and the loads f on them. E is convex and is minimised by a
regularised Newton method with line search. The banded Cholesky factorisation makes the cost linear in the number of balls.

The beam is described by the deformations of its elements, besides the motions of its nodes. The reason is round-off: the
difference of node motions of a long slender shaft can be 1e-12 of the motions themselves. An element from node 1 to node 2
has the deformation d = q_2 - T q_1, where T q_1 is the rigid-body motion of node 1 transferred to node 2.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel, load_solver_copy
from rollbench.lowfi.statics.kernel_types import (
    Array,
    AxisArrays,
    BeamArrays,
    BeamContacts,
    BeamSystem,
    EnergyDerivatives,
    MotionState,
    MotionWorkspace,
    NewtonOptions,
    Outcome,
    Rows,
    SpecimenArrays,
    SpecimenSolutions,
)

from .ball import FORCE, MX, MZ, SIZE, USE, WX, WZ, find_ball_equilibrium, largest_net_ball_force, write_ball_stiffness
from .matrices import factor_band, substitute_band


@kernel
def element_constants(length: float, section: Array) -> tuple[float, float, float, float, float]:
    """Return the stiffness constants of a Timoshenko beam element: k_uu, k_uu L/2, k_rr, EA/L, GJ/L.

    They relate the force and moment at the element's second node to its deformation, the motion of this node minus the
    rigid-body motion of the first node transferred to it. k_uu [N/m] (lateral force by displacement) is
    1/(L (L^2/(12 EI) + 1/(kappa G A))), k_rr [N m] (moment by rotation) is k_uu L^2/3 + k_uu EI/(kappa G A), and k_uu L/2
    [N] couples both. L: ``length`` [m]; section (4,): EA [N], EI [N m^2], GJ [N m^2], kappa G A [N]. Corrects equations D.1
    and D.2 of Lin's thesis.
    """
    kuu = 1.0 / (length * (length * length / (12.0 * section[1]) + 1.0 / section[3]))
    krr = kuu * (length * length / 3.0 + section[1] / section[3])
    return kuu, 0.5 * length * kuu, krr, section[0] / length, section[2] / length


@kernel
def write_element_force(d: Array, constants: tuple[float, float, float, float, float], out: Array) -> None:
    """Compute the force and moment (6,) [N, N m] at node 2 of a beam element that cause its deformation d (6,) [m, rad].

    The deformation is the motion of node 2 minus the rigid-body motion of node 1 transferred to it. constants: stiffnesses
    of the element, see `element_constants`. The result is written to ``out``.
    """
    # plane x-z: u_x with r_y; plane y-z: u_y with r_x, of the other sign; then axial force and torque
    kuu, kur, krr, ka, kt = constants
    out[0] = kuu * d[0] - kur * d[4]
    out[4] = krr * d[4] - kur * d[0]
    out[1] = kuu * d[1] + kur * d[3]
    out[3] = krr * d[3] + kur * d[1]
    out[2] = ka * d[2]
    out[5] = kt * d[5]


@kernel
def add_element_stiffness(band: Array, node: int, length: float, section: Array) -> None:
    """Add the stiffness of the beam element from ``node`` to the next node to the global stiffness matrix.

    band: lower band of the matrix, with A[i, j] = band[j, i - j] for i >= j. length [m]; section (4,): EA [N], EI [N m^2],
    GJ [N m^2], kappa G A [N] of the element.
    """
    kuu, kur, krr, ka, kt = element_constants(length, section)
    off = length * kur - krr  # between the rotations of both nodes
    i, j = 6 * node, 6 * node + 6
    # plane x-z (ux, ry): sign +; plane y-z (uy, rx): sign -
    for plane in range(2):
        sign = 1.0 if plane == 0 else -1.0
        u, r = (0, 4) if plane == 0 else (1, 3)
        # node 1 with itself, then node 1 with node 2 (columns j), then node 2 with itself
        band[i + u, 0] += kuu
        band[i + r, 0] += krr
        band[i + u, r - u] += sign * kur
        band[i + u, j - i] -= kuu
        band[i + u, j + r - i - u] += sign * kur
        band[i + r, j + u - i - r] -= sign * kur
        band[i + r, j - i] += off
        band[j + u, 0] += kuu
        band[j + r, 0] += krr
        band[j + u, r - u] -= sign * kur
    band[i + 2, 0] += ka
    band[i + 2, 6] -= ka
    band[j + 2, 0] += ka
    band[i + 5, 0] += kt
    band[i + 5, 6] -= kt
    band[j + 5, 0] += kt


@kernel
def assemble_beam_stiffness(lengths: Array, sections: Array, constants: Array, band: Array) -> None:
    """Compute the stiffness constants of all beam elements and add their stiffness to a stiffness matrix.

    lengths (n - 1,) [m]; sections (n - 1, 4): EA [N], EI [N m^2], GJ [N m^2], kappa G A [N] of each element. Writes the
    constants of `element_constants` to ``constants`` (n - 1, 5), and adds to ``band``, the lower band of the matrix.
    """
    for e in range(lengths.shape[0]):
        kuu, kur, krr, ka, kt = element_constants(lengths[e], sections[e])
        constants[e, 0], constants[e, 1], constants[e, 2], constants[e, 3], constants[e, 4] = kuu, kur, krr, ka, kt
        add_element_stiffness(band, e, lengths[e], sections[e])


#: Ratio of a residual to the smallest one so far above which the stiffness is factored again for the next Newton step.
#: Below it, convergence is fast enough with the last factor. Used near the solution only.
KEPT = 1e-3
#: Smallest stiffness added to the diagonal of the stiffness matrix, as a fraction of the beam's largest coefficient. With
#: less, a motion that nothing resists would have a stiffness of round-off only.
ROUND_OFF = 1e-17


@kernel
def write_screw_flank_motions(contacts: BeamContacts, motion: Array, i: int, m: int, shift: Array) -> None:
    """Compute the motions of the screw's two groove flanks at ball i from the nodal motions (6 n,) of the beam.

    m: number of nodal motions on which a flank depends, 6 or 12. Writes the motions [m] in the ball's section plane
    (radial, and along the helix's binormal) to the first two rows of ``shift`` (4, 2). contacts: arrays of the balls;
    motion: nodal motions [m, rad].
    """
    B = contacts.B
    for s in range(2):
        if contacts.geometry[i, s, USE] != 0.0:
            start = 6 * contacts.first_nodes[i, s]
            x, z = 0.0, 0.0
            for k in range(m):
                x += B[i, s, 0, k] * motion[start + k]
                z += B[i, s, 1, k] * motion[start + k]
            shift[s, 0], shift[s, 1] = x, z


@kernel
def add_contact_force(gradient: Array, B: Array, i: int, s: int, m: int, start: int, fx: float, fz: float) -> None:
    """Add the contact force (fx, fz) [N] of ball i on screw flank s to the nodal forces: the energy's gradient (6 n,).

    B (N, 2, 2, m): motions of the screw's flanks per unit motion of the nodes; m: number of nodal motions on which the
    flank depends; start: index of the first of them.
    """
    for k in range(m):
        gradient[start + k] -= fx * B[i, s, 0, k] + fz * B[i, s, 1, k]


@kernel
def evaluate_beam(beam: BeamArrays | AxisArrays, q: Array, d: Array, gradient: Array) -> tuple[float, float]:
    """Return the energy [J] of a shaft's beam with its loads, and the largest force [N] among element forces and loads.

    Writes the motions q (n, 6) [m, rad] of the nodes, which follow from q[0] and the element deformations d (n - 1, 6), and
    the gradient (n, 6) of the energy by them. Further rows of q and gradient (other bodies) are left unchanged.
    """
    last, energy, scale = d.shape[0], 0.0, 0.0
    fx, fy, fz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, a, b, c = q[0, 0], q[0, 1], q[0, 2], q[0, 3], q[0, 4], q[0, 5]
    for i in range(last + 1):
        p, g = beam.load[i], gradient[i]
        energy -= p[0] * x + p[1] * y + p[2] * z + p[3] * a + p[4] * b + p[5] * c
        scale = max(scale, abs(p[0]), abs(p[1]), abs(p[2]))
        g[0], g[1], g[2], g[3], g[4], g[5] = fx - p[0], fy - p[1], fz - p[2], mx - p[3], my - p[4], mz - p[5]
        if i < last:
            # deformation d of the element, the force k d at its end, and the motion of the next node, T q + d
            e, k, length = d[i], beam.constants[i], beam.lengths[i]
            dx, dy, dz, da, db, dc = e[0], e[1], e[2], e[3], e[4], e[5]
            fx, fy, fz = k[0] * dx - k[1] * db, k[0] * dy + k[1] * da, k[3] * dz
            mx, my, mz = k[2] * da + k[1] * dy, k[2] * db - k[1] * dx, k[4] * dc
            energy += 0.5 * (fx * dx + fy * dy + fz * dz + mx * da + my * db + mz * dc)
            scale = max(scale, abs(fx), abs(fy), abs(fz))
            g[0], g[1], g[2] = g[0] - fx, g[1] - fy, g[2] - fz
            g[3], g[4], g[5] = g[3] - mx + length * fy, g[4] - my - length * fx, g[5] - mz
            x, y, z, a, b, c = x + length * b + dx, y - length * a + dy, z + dz, a + da, b + db, c + dc
            r = q[i + 1]
            r[0], r[1], r[2], r[3], r[4], r[5] = x, y, z, a, b, c
    return energy, scale


@kernel
def evaluate_screw(given: BeamSystem, state: MotionState, out: EnergyDerivatives) -> tuple[float, float]:
    """Return the energy [J] of a screw's beam and its balls at the state, and the largest force [N] in the model.

    The largest force is a load, the force in a beam element, or a contact force. Writes the gradient of the energy and the
    stiffness matrices of the balls to ``out``. ``given``: arrays of the screw as a beam and of its balls.
    """
    beam, contacts = given
    node, B, geometry, closure, r_ball, profile, tiny = contacts
    q, d, p, contact, _ = state
    gradient, hessians = out
    energy, scale = evaluate_beam(beam, q, d, gradient)
    shift, rigid = np.zeros((4, 2)), np.zeros((0, 3))
    flat = q.ravel()
    grad = gradient.ravel()
    m = B.shape[3]
    for i in range(r_ball.shape[0]):
        if m == 6:  # the literal 6 lets the compiler unroll the loops
            write_screw_flank_motions(contacts, flat, i, 6, shift)
        else:
            write_screw_flank_motions(contacts, flat, i, m, shift)
        energy += find_ball_equilibrium(p[i], shift, geometry[i], closure[i], rigid, r_ball[i], profile, tiny, contact[i])
        write_ball_stiffness(contact[i], hessians[i])
        for s in range(4):
            scale = max(scale, contact[i, s, FORCE])
        for s in range(2):
            f = contact[i, s, FORCE]
            if f > 0.0:
                fx, fz = f * contact[i, s, MX], f * contact[i, s, MZ]
                if m == 6:
                    add_contact_force(grad, B, i, s, 6, 6 * node[i, s], fx, fz)
                else:
                    add_contact_force(grad, B, i, s, m, 6 * node[i, s], fx, fz)
    return energy, scale


@kernel
def add_contact_stiffness(band: Array, b: Array, h: tuple[float, float, float], start: int, m: int, work: Array) -> None:
    """Add the stiffness b^T h b of one contact with the screw to ``band``, the lower band of the beam's stiffness matrix.

    b (2, m): motion of the groove flank per unit of m nodal motions, the first of which has the index ``start``; h:
    stiffness (xx, xz, zz) of the contact [N/m]; work (2, m): work array.
    """
    for k in range(m):
        work[0, k] = h[0] * b[0, k] + h[1] * b[1, k]
        work[1, k] = h[1] * b[0, k] + h[2] * b[1, k]
    for k in range(m):
        x, z = work[0, k], work[1, k]
        for j in range(k, m):
            band[start + k, j - k] += x * b[0, j] + z * b[1, j]


@kernel
def add_stiffness_between_flanks(band: Array, b: Array, c: Array, h: Array, rows: int, columns: int, work: Array) -> None:
    """Add the stiffness b^T h c by which a ball couples the screw's two flanks to ``band``, the lower band of the matrix.

    b, c (2, m): motions of the two flanks per unit of m nodal motions each, the first of which have the indices ``rows``
    and ``columns``; h (2, 2): coupling stiffness of the ball [N/m]; work (2, m): work array.
    """
    m = b.shape[1]
    for a in range(2):
        for k in range(m):
            work[a, k] = h[a, 0] * c[0, k] + h[a, 1] * c[1, k]
    for j in range(m):
        x, z = b[0, j], b[1, j]
        for k in range(min(m, rows - columns + j + 1)):
            band[columns + k, rows - columns + j - k] += x * work[0, k] + z * work[1, k]


@kernel
def assemble_beam_and_ball_stiffness(
    band: Array, beam: BeamArrays, contacts: BeamContacts, hessians: Array, shift: float, arm: float
) -> None:
    """Write the stiffness matrix of beam and balls to ``band``, its lower band A[i, j] = band[j, i - j].

    hessians (N, 4, 4): stiffness of the balls against motions of the screw's flanks [N/m]; shift [N/m]: stiffness added to
    the diagonal, multiplied by arm^2 for rotations. Fixed nodal motions get the rows of a unit matrix. beam, contacts:
    arrays of the beam and of the balls.
    """
    fixed, node, B = beam.fixed, contacts.first_nodes, contacts.B
    band[:] = beam.band
    m = B.shape[3]
    work = np.empty((2, m))
    for i in range(node.shape[0]):
        for s in range(2):
            o, t = 2 * s, 2 - 2 * s  # rows of this flank and of the other one in the ball's Hessian
            stiffness = hessians[i, o, o], hessians[i, o, o + 1], hessians[i, o + 1, o + 1]
            if stiffness[0] == 0.0 and stiffness[2] == 0.0:
                continue
            if m == 6:  # the literal 6 lets the compiler unroll the loops
                add_contact_stiffness(band, B[i, s], stiffness, 6 * node[i, s], 6, work)
            else:
                add_contact_stiffness(band, B[i, s], stiffness, 6 * node[i, s], m, work)
            if hessians[i, o, t] != 0.0 or hessians[i, o + 1, t + 1] != 0.0:
                between, rows, columns = hessians[i, o : o + 2, t : t + 2], 6 * node[i, s], 6 * node[i, 1 - s]
                add_stiffness_between_flanks(band, B[i, s], B[i, 1 - s], between, rows, columns, work)
    for i in range(fixed.shape[0]):
        for k in range(6):
            band[6 * i + k, 0] += shift if k < 3 else shift * arm * arm
            if fixed[i, k]:
                fix_nodal_motion(band, 6 * i + k)


@kernel
def fix_nodal_motion(band: Array, i: int) -> None:
    """Fix the nodal motion with index i: replace its row and column of a stiffness matrix by those of a unit matrix.

    ``band``: lower band of the matrix, changed in place.
    """
    width = band.shape[1]
    for w in range(width):
        band[i, w] = 0.0
    for w in range(1, min(width, i + 1)):
        band[i - w, w] = 0.0
    band[i, 0] = 1.0


@kernel
def advance_along_step(
    shaft: BeamArrays | AxisArrays, state: MotionState, q0: Array, d0: Array, step: Array, t: float
) -> None:
    """Set nodal motions q and element deformations d to their values before a Newton step plus ``t`` times the step.

    q0, d0: values before the step; step (r, 6): change of the motions of nodes and bodies [m, rad] for t = 1. The change of
    the element deformations is computed from the step alone, not from the moved nodes, to avoid round-off. The new values
    are written to ``state``. shaft: arrays with the lengths of the elements.
    """
    q, d, lengths = state.q, state.d, shaft.lengths
    for k in range(6):
        q[0, k] = q0[0, k] + t * step[0, k]
        for i in range(d.shape[0] + 1, q.shape[0]):
            q[i, k] = q0[i, k] + t * step[i, k]
    for e in range(d.shape[0]):
        x = lengths[e]
        d[e, 0] = d0[e, 0] + t * (step[e + 1, 0] - step[e, 0] - x * step[e, 4])
        d[e, 1] = d0[e, 1] + t * (step[e + 1, 1] - step[e, 1] + x * step[e, 3])
        for k in range(2, 6):
            d[e, k] = d0[e, k] + t * (step[e + 1, k] - step[e, k])


@kernel
def energy_and_largest_force(given: BeamSystem, state: MotionState, workspace: MotionWorkspace) -> tuple[float, float]:
    """Return the energy [J] of a screw's beam and its balls at the state, and the largest force [N] in the model.

    ``given``: arrays of the screw as a beam and of its balls; the derivatives are written to the ``workspace``.
    """
    return evaluate_screw(given, state, workspace.derivatives)


@kernel
def write_newton_step(
    given: BeamSystem, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace, shift: float, fresh: bool
) -> bool:
    """Write Newton's step of the nodal motions to the workspace; return False if the stiffness is not positive definite.

    With ``fresh`` the stiffness is assembled and factored, with ``shift`` [N/m] added to its diagonal (times the square of
    ``options.moment_arm`` for rotations); otherwise the last factor is used. ``given``: arrays of the screw as a beam and
    of its balls; ``state`` is not used.
    """
    beam, band = given.shaft, workspace.matrix
    if fresh:
        least = ROUND_OFF * max(0.0, beam.band[:, 0].max())
        hessians = workspace.derivatives.ball_hessians
        assemble_beam_and_ball_stiffness(band, beam, given.contacts, hessians, max(shift, least), options.moment_arm)
        if not factor_band(band):
            return False
    solve_newton_step(given, workspace)
    return True


@kernel
def solve_newton_step(given: BeamSystem, workspace: MotionWorkspace) -> None:
    """Solve for Newton's step of the nodal motions with the factored stiffness matrix, and write it to the workspace.

    ``given``: arrays of the screw as a beam and of its balls; the ``workspace`` holds gradient and factor.
    """
    fixed, gradient, step = given.shaft.fixed, workspace.derivatives.gradient, workspace.step
    for i in range(step.shape[0]):
        for k in range(6):
            step[i, k] = 0.0 if fixed[i, k] else -gradient[i, k]
    substitute_band(workspace.matrix, step.ravel())


@kernel
def relative_residual(
    given: Rows, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace, scale: float
) -> float:
    """Return the largest unbalanced force of the equilibrium equations as a fraction of ``scale`` [N].

    Moments are divided by the length ``options.moment_arm``. Components of fixed motions do not count. If ``scale`` is
    0, the result is in newtons. ``given``: arrays of the screw as a beam and of its balls, or of a shaft with several
    nuts and bearings; the ``workspace`` holds the gradient of the energy, which is the unbalanced force.
    """
    gradient, worst = workspace.derivatives.gradient, 0.0
    for i in range(gradient.shape[0]):
        for k in range(6):
            if not given.shaft.fixed[i, k]:
                worst = max(worst, abs(gradient[i, k]) / (1.0 if k < 3 else options.moment_arm))
    return worst / scale if scale > 0.0 else worst


@kernel
def energy_slope_along_step(given: Rows, state: MotionState, workspace: MotionWorkspace) -> float:
    """Return the derivative [J] of the energy by the step length, along the step in the workspace.

    The ``workspace`` holds the gradient of the energy and the step; ``given`` tells which motions are fixed; ``state`` is
    not used.
    """
    gradient, step, total = workspace.derivatives.gradient, workspace.step, 0.0
    for i in range(step.shape[0]):
        for k in range(6):
            if not given.shaft.fixed[i, k]:
                total += gradient[i, k] * step[i, k]
    return total


@kernel
def largest_flank_motion_in_step(given: BeamSystem, workspace: MotionWorkspace) -> float:
    """Return the largest displacement [m] of a groove flank of the screw in the full Newton step (step length 1).

    ``given``: arrays of the screw as a beam and of its balls; the ``workspace`` holds the step.
    """
    contacts, motion = given.contacts, workspace.step.ravel()
    m, largest, shift = contacts.B.shape[3], 0.0, np.zeros((4, 2))
    for i in range(contacts.first_nodes.shape[0]):
        if m == 6:
            write_screw_flank_motions(contacts, motion, i, 6, shift)
        else:
            write_screw_flank_motions(contacts, motion, i, m, shift)
        for s in range(2):
            largest = max(largest, shift[s, 0] ** 2 + shift[s, 1] ** 2)
    return sqrt(largest)


@kernel
def save_line_search_start(state: MotionState, workspace: MotionWorkspace) -> None:
    """Store the current nodal motions and element deformations in the workspace as the start of the line search."""
    workspace.q0[:], workspace.d0[:] = state.q, state.d


@kernel
def move_along_step(given: Rows, state: MotionState, workspace: MotionWorkspace, t: float) -> None:
    """Set the state to the start of the line search plus ``t`` times the Newton step.

    ``given``: arrays of the screw as a beam and of its balls, or of a shaft with several nuts and bearings; the
    ``workspace`` holds start and step.
    """
    advance_along_step(given.shaft, state, workspace.q0, workspace.d0, workspace.step, t)


@kernel
def complete_final_state(given: Rows, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace) -> None:
    """Do nothing: the state is complete. Only the model with elastic bodies has something to compute at this point."""


@kernel
def least_residual_force_scale(given: Rows, state: MotionState, options: NewtonOptions) -> float:
    """Return the lower bound of the force [N] by which unbalanced forces are divided for relative residuals.

    It is the larger of ``options.least_force_scale`` and the largest element moment divided by ``options.moment_arm``.
    Without this limit, a screw that is bent by moments only, or that has lost its last contact, would have no force to
    compare with. ``given``: arrays of the shaft; ``state``: deformations of its elements.
    """
    floor, f = options.least_force_scale, np.empty(6)
    for e in range(state.d.shape[0]):
        c = given.shaft.constants[e]
        write_element_force(state.d[e], (c[0], c[1], c[2], c[3], c[4]), f)
        for k in range(3, 6):
            floor = max(floor, abs(f[k]) / options.moment_arm)
    return floor


@kernel
def largest_displacement(given: Rows, state: MotionState) -> float:
    """Return the largest displacement [m] of a node of the shaft, or of another body that the state contains.

    The displacement counts from the undeformed position; rotations do not count. ``given`` is not used.
    """
    q, moved = state.q, 0.0
    for i in range(q.shape[0]):
        moved = max(moved, q[i, 0] ** 2 + q[i, 1] ** 2 + q[i, 2] ** 2)
    return sqrt(moved)


@kernel
def largest_relative_net_ball_force(state: MotionState, scale: float) -> float:
    """Return the largest net force on a ball as a fraction of ``scale`` [N]; zero when all balls are in equilibrium.

    ``state``: contact forces and normals of all balls.
    """
    return largest_net_ball_force(state.contact, scale)


minimise: Callable[..., Outcome] = load_solver_copy(__name__, "descent").minimise


@kernel
def start_from_springs(given: BeamSystem, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace) -> None:
    """Set the state to a first guess: the equilibrium of the screw on linear springs in the nominal contact directions.

    Leaves the state unchanged if the stiffness matrix with these springs cannot be factored. No flank moves further than
    ``options.max_flank_step``, the radius of the largest ball: springs of fixed direction are wrong where the
    contact direction must turn first, for example at a contact angle near zero under an axial load. ``given``: arrays of
    the screw as a beam and of its balls; ``workspace``: work arrays, changed.
    """
    geometry, hessians, stiffness = given.contacts.geometry, workspace.derivatives.ball_hessians, options.stiffness
    evaluate_beam(given.shaft, state.q, state.d, workspace.derivatives.gradient)
    hessians[:] = 0.0
    for i in range(geometry.shape[0]):
        for s in range(2):
            if geometry[i, s, USE] != 0.0:
                wx, wz, own = geometry[i, s, WX], geometry[i, s, WZ], hessians[i, 2 * s : 2 * s + 2, 2 * s : 2 * s + 2]
                size = max(geometry[i, s, SIZE], 1e-30)
                own[0, 0], own[1, 1] = stiffness * wx * wx / (size * size), stiffness * wz * wz / (size * size)
                own[0, 1] = own[1, 0] = stiffness * wx * wz / (size * size)
    band, arm = workspace.matrix, options.moment_arm
    assemble_beam_and_ball_stiffness(band, given.shaft, given.contacts, hessians, 1e-9 * stiffness, arm)
    if factor_band(band):
        solve_newton_step(given, workspace)
        shorten_first_step(given, state, options, workspace, largest_flank_motion_in_step(given, workspace))


@kernel
def shorten_first_step(
    given: Rows, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace, reach: float
) -> None:
    """Take the first Newton step from the state, shortened such that no flank moves further than a limit [m].

    reach [m]: largest displacement of a flank in the full Newton step; the limit is ``options.max_flank_step``. ``given``:
    arrays of the screw and its balls, or of a shaft with several nuts and bearings. The ``workspace`` holds the step;
    ``state`` is changed.
    """
    save_line_search_start(state, workspace)
    limit = options.max_flank_step
    move_along_step(given, state, workspace, 1.0 if reach <= limit else limit / reach)


@kernel
def allocate_workspace(given: BeamSystem, state: MotionState) -> MotionWorkspace:
    """Return work arrays for the Newton iteration on a screw and its balls, of shapes that fit ``given`` and ``state``."""
    n, band = state.q.shape[0], given.shaft.band
    slopes = EnergyDerivatives(np.empty((n, 6)), np.zeros((state.contact.shape[0], 4, 4)))
    return MotionWorkspace(slopes, band, np.empty(band.shape), np.empty((n, 6)), np.empty((n, 6)), np.empty(state.d.shape))


@kernel
def solve_beam(given: BeamSystem, state: MotionState, options: NewtonOptions, start: bool) -> Outcome:
    """Find the static equilibrium of a screw (Timoshenko beam) and its balls in a fixed nut.

    With ``start`` the iteration begins at the solution with linear springs as contacts, otherwise at ``state``, which holds
    the solution on return. ``given``: arrays of the screw as a beam and of its balls; ``options``: tolerance and limits of
    the iteration.
    """
    workspace = allocate_workspace(given, state)
    if start:
        start_from_springs(given, state, options, workspace)
    return minimise(given, state, options, workspace)


@kernel
def solve_specimens(
    given: BeamSystem, begin: MotionState, options: NewtonOptions, members: SpecimenArrays, out: SpecimenSolutions
) -> None:
    """Solve the equilibrium of many specimens of one screw, which differ in ball radii, groove centres and lever arms.

    given: arrays of the nominal screw; members: arrays of the specimens; options: tolerance and limits of the
    iteration. Every specimen starts from ``begin``, the solution of the nominal screw, which is not changed, so that
    calls may run in parallel. The solutions are written to ``out``.
    """
    contacts = given.contacts
    state = MotionState(begin.q.copy(), begin.d.copy(), begin.p.copy(), begin.contact.copy(), begin.slices)
    workspace, shared = allocate_workspace(given, state), members.B.shape[0] == 1
    for m in range(members.r_ball.shape[0]):
        flanks = members.B[0 if shared else m], members.geometry[m], members.interference[m], members.r_ball[m]
        of_member = BeamContacts(contacts.first_nodes, *flanks, contacts.profile, contacts.unloaded_force_limit)
        for to, start in ((state.q, begin.q), (state.d, begin.d), (state.p, begin.p)):
            to[:] = start
        outcome = minimise(BeamSystem(given.shaft, of_member), state, options, workspace)
        out.status[m], out.residual[m] = outcome.status, outcome.residual
        out.q[m], out.p[m] = state.q, state.p
        out.force[m] = state.contact[:, :, FORCE]
