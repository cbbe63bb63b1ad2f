"""Static equilibrium of a shaft with several bearings or nuts: Newton's method on the energy of shaft, bodies and balls.

    E(q) = (shaft) + (springs) - f q + (contact energy of all balls) + (contact energy of all rollers).

The contact energy of a ball is its minimum over the position of the ball's centre. The unknowns q are the motions of the
shaft's nodes and of the rigid bodies on it, such as nuts and bearing rings; f are the loads on them. The stiffness matrix
is stored as an envelope (see ``matrices``), so that the cost is linear in the number of bearing rows and nuts. See ``beam``
for the simpler case of one screw in a fixed nut.
"""

from collections.abc import Callable
from itertools import product
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import is_compiled_module, kernel, load_solver_copy
from rollbench.lowfi.statics.kernel_types import (
    Array,
    AxisArrays,
    AxisBalls,
    AxisRollers,
    AxisSystem,
    EnergyDerivatives,
    MotionState,
    MotionWorkspace,
    NewtonOptions,
    Outcome,
)

from .ball import FORCE, MX, MZ, SIZE, USE, WX, WZ, find_ball_equilibrium, write_ball_stiffness
from .beam import (  # noqa: F401 - some are only looked up by ``descent``
    add_element_stiffness,
    complete_final_state,
    energy_slope_along_step,
    evaluate_beam,
    largest_displacement,
    largest_relative_net_ball_force,
    least_residual_force_scale,
    move_along_step,
    relative_residual,
    save_line_search_start,
    shorten_first_step,
)
from .matrices import factor, substitute
from .rollers import add_roller_forces


@kernel
def add_stiffness_block(values: Array, axis: AxisArrays, a: int, b: int, block: Array) -> None:
    """Add a stiffness block (6, 6), which couples the motions of two bodies (or nodes) a and b, to the stiffness matrix.

    Only the lower triangle of the matrix is stored, as an envelope in ``values``: for each row the coefficients from the
    first one that can differ from zero to the diagonal (`kernel.matrices`). ``axis`` holds the positions of the rows. For
    a = b only the lower half of the block is added.
    """
    if axis.body_order[a] >= axis.body_order[b]:
        rows, columns = 6 * axis.body_order[a], 6 * axis.body_order[b]
        for i in range(6):
            at = axis.row_offsets[rows + i] + columns
            for j in range(i + 1 if a == b else 6):
                values[at + j] += block[i, j]
    else:
        rows, columns = 6 * axis.body_order[b], 6 * axis.body_order[a]
        for i in range(6):
            at = axis.row_offsets[rows + i] + columns
            for j in range(6):
                values[at + j] += block[j, i]


@kernel
def add_structure_stiffness(values: Array, axis: AxisArrays) -> None:
    """Add the stiffness of the shaft's beam elements, and of the springs between bodies, to the matrix ``values``.

    ``values``: stiffness matrix of the bodies' motions, stored as an envelope (`kernel.matrices`). ``axis``: arrays of
    shaft and springs.
    """
    band, block = np.empty((12, 12)), np.empty((6, 6))
    for e in range(axis.lengths.shape[0]):
        band[:, :] = 0.0
        add_element_stiffness(band, 0, axis.lengths[e], axis.sections[e])
        for half in range(3):
            first, second = (0, 0) if half == 0 else ((6, 0) if half == 1 else (6, 6))
            for i in range(6):
                for j in range(6):
                    row, column = max(first + i, second + j), min(first + i, second + j)
                    block[i, j] = band[column, row - column]
            add_stiffness_block(values, axis, e + first // 6, e + second // 6, block)
    for k in range(axis.spring_bodies.shape[0]):
        ends = axis.spring_end_matrices[k]
        for i in range(2):
            for j in range(i + 1):
                if axis.spring_bodies[k, i] >= 0 and axis.spring_bodies[k, j] >= 0:
                    block[:, :] = 0.0
                    for a in range(6):
                        for b in range(6):
                            for c in range(6):
                                for d in range(6):
                                    block[a, b] += ends[i, c, a] * axis.springs[k, c, d] * ends[j, d, b]
                    add_stiffness_block(values, axis, axis.spring_bodies[k, i], axis.spring_bodies[k, j], block)


@kernel
def add_ball_stiffness_in_loops(values: Array, axis: AxisArrays, balls: AxisBalls, hessians: Array) -> None:
    """Add the contact stiffness of all balls to the stiffness matrix ``values``, stored as an envelope, ball by ball.

    Each ball adds B_s^T h B_t for its flanks s and t that can move. B gives the motion of a flank by the motions of the
    nodes or bodies that carry it, and h (2, 2) is a block of the ball's stiffness ``hessians`` (N, 8, 8) [N/m]. ``axis``:
    positions of the rows in the envelope.
    """
    spans, block = balls.B.shape[3] // 6, np.empty((6, 6))
    for i in range(balls.first_bodies.shape[0]):
        for s in range(4):
            row = balls.first_bodies[i, s]
            if row < 0 or (hessians[i, 2 * s, 2 * s] == 0.0 and hessians[i, 2 * s + 1, 2 * s + 1] == 0.0):
                continue
            for t in range(s + 1):
                column = balls.first_bodies[i, t]
                if column < 0 or (hessians[i, 2 * t, 2 * t] == 0.0 and hessians[i, 2 * t + 1, 2 * t + 1] == 0.0):
                    continue
                h = hessians[i, 2 * s : 2 * s + 2, 2 * t : 2 * t + 2]
                for a in range(spans):
                    for b in range(a + 1 if s == t else spans):
                        write_coupling_block(balls.B[i, s, :, 6 * a :], h, balls.B[i, t, :, 6 * b :], block)
                        if s != t and row + a == column + b:  # both halves of a block on the diagonal
                            for j in range(6):
                                for k in range(j):
                                    block[j, k] += block[k, j]
                                block[j, j] *= 2.0
                        add_stiffness_block(values, axis, row + a, column + b, block)


@kernel
def write_coupling_block(left: Array, h: Array, right: Array, block: Array) -> None:
    """Write to ``block`` the part left^T h right (6, 6) of a ball's stiffness that couples the motions of two bodies.

    left, right (2, 6 or more): motion of a groove flank by the motion of its body (or shaft node), in the first six
    columns; h (2, 2): stiffness of the ball between these two flanks [N/m].
    """
    for j in range(6):
        x = left[0, j] * h[0, 0] + left[1, j] * h[1, 0]
        z = left[0, j] * h[0, 1] + left[1, j] * h[1, 1]
        for k in range(6):
            block[j, k] = x * right[0, k] + z * right[1, k]


@kernel
def add_roller_stiffness(values: Array, axis: AxisArrays, rollers: AxisRollers, slices: Array) -> None:
    """Add the contact stiffness of all roller slices to the stiffness matrix ``values``, stored as an envelope.

    rollers: coefficients of the slices' approaches; slices (M, 2): force [N] and stiffness [N/m] of each slice. ``axis``:
    positions of the rows in the envelope.
    """
    block = np.empty((6, 6))
    for i in range(slices.shape[0]):
        if slices[i, 1] == 0.0:
            continue
        for s in range(2):
            for t in range(s + 1):
                if rollers.ring_bodies[i, s] >= 0 and rollers.ring_bodies[i, t] >= 0:
                    for j in range(6):
                        for k in range(6):
                            block[j, k] = slices[i, 1] * rollers.B[i, s, j] * rollers.B[i, t, k]
                    add_stiffness_block(values, axis, rollers.ring_bodies[i, s], rollers.ring_bodies[i, t], block)


@kernel
def fix_prescribed_motions(values: Array, axis: AxisArrays, shift: Array) -> None:
    """Fix the motions that supports prescribe: replace their rows and columns of a stiffness matrix by unit ones.

    Before that, ``shift`` (6,) [N/m, N m] is added to the diagonal of the matrix ``values`` for every node and body.
    ``axis``: which motions are fixed, and the positions of the rows in ``values``, which stores the matrix as an envelope.
    """
    n = axis.first_columns.shape[0]
    for i in range(axis.fixed.shape[0]):
        for k in range(6):
            line = 6 * axis.body_order[i] + k
            values[axis.row_offsets[line] + line] += shift[k]
            if not axis.fixed[i, k]:
                continue
            for j in range(axis.first_columns[line], line):
                values[axis.row_offsets[line] + j] = 0.0
            values[axis.row_offsets[line] + line] = 1.0
            for other in range(line + 1, n):
                if axis.first_columns[other] <= line:
                    values[axis.row_offsets[other] + line] = 0.0


def _add_ball_stiffness_by_numpy(values: Array, axis: AxisArrays, balls: AxisBalls, hessians: Array) -> None:
    """Add the contact stiffness of all balls to the stiffness matrix ``values`` by numpy, without loops over the balls.

    It does the same as `add_ball_stiffness_in_loops` and is used without compilation. ``axis``: positions of the rows
    in ``values``, which stores the matrix as an envelope. hessians (N, 8, 8): stiffness of the balls [N/m].
    """
    six, spans = np.arange(6), range(balls.B.shape[3] // 6)
    for s, t, a, b in product(range(4), range(4), spans, spans):
        both = np.flatnonzero((balls.first_bodies[:, s] >= 0) & (balls.first_bodies[:, t] >= 0))
        left, right = balls.B[both, s][:, :, 6 * a : 6 * a + 6], balls.B[both, t][:, :, 6 * b : 6 * b + 6]
        h = hessians[both, 2 * s : 2 * s + 2, 2 * t : 2 * t + 2]
        K = np.einsum("nai,nab,nbj->nij", left, h, right)
        lines = (6 * axis.body_order[balls.first_bodies[both, s] + a])[:, None, None] + six[None, :, None]
        columns = (6 * axis.body_order[balls.first_bodies[both, t] + b])[:, None, None] + six[None, None, :]
        lower = (lines >= columns) & (K != 0.0)
        np.add.at(values, (axis.row_offsets[lines] + columns)[lower], K[lower])


add_balls = add_ball_stiffness_in_loops if is_compiled_module(__name__) else _add_ball_stiffness_by_numpy

#: Ratio of the residual to the smallest one so far above which the stiffness is factored again, see ``descent``. Zero:
#: the stiffness is factored in every step.
KEPT = 0.0


@kernel
def evaluate_axis(given: AxisSystem, state: MotionState, out: EnergyDerivatives) -> tuple[float, float]:
    """Compute energy of shaft, bodies and balls with its derivatives; return energy [J] and largest force in the model [N].

    Writes the nodal motions, ball centres, contacts and roller slices to ``state``, and the gradient of the energy and the
    stiffness of the balls to ``out``. ``given``: arrays of shaft, bodies, springs, balls and rollers.
    """
    axis, balls, rollers = given
    q, _, p, contact, slices = state
    gradient, hessians = out
    energy, scale = evaluate_structure(axis, state, gradient)
    shift, rigid = np.zeros((4, 2)), np.zeros((0, 3))
    flat, m = gradient.ravel(), balls.B.shape[3]
    for i in range(balls.r_ball.shape[0]):
        write_flank_motions_of_ball(balls, q, i, shift)
        ball = balls.geometry[i], balls.interference[i], rigid, balls.r_ball[i], balls.profile[i]
        energy += find_ball_equilibrium(p[i], shift, *ball, balls.unloaded_force_limit, contact[i])
        write_ball_stiffness(contact[i], hessians[i])
        for s in range(4):
            force, row = contact[i, s, FORCE], balls.first_bodies[i, s]
            scale = max(scale, force)
            if force > 0.0 and row >= 0:
                fx, fz = force * contact[i, s, MX], force * contact[i, s, MZ]
                for k in range(m):
                    flat[6 * row + k] -= fx * balls.B[i, s, 0, k] + fz * balls.B[i, s, 1, k]
    stored, largest = add_roller_forces(rollers, q, slices, gradient)
    return energy + stored, max(scale, largest)


@kernel
def evaluate_structure(axis: AxisArrays, state: MotionState, gradient: Array) -> tuple[float, float]:
    """Return the energy [J] of shaft, bodies and springs without rolling elements, and the largest force in them [N].

    Writes the derivatives of this energy by the motions of nodes and bodies to ``gradient`` (r, 6). ``axis``: arrays of
    shaft, bodies, springs and loads; ``state``: motions q and element deformations d.
    """
    load, q = axis.load, state.q
    energy, scale = evaluate_beam(axis, q, state.d, gradient)
    for i in range(state.d.shape[0] + 1, q.shape[0]):
        for k in range(6):
            gradient[i, k] = -load[i, k]
            energy -= load[i, k] * q[i, k]
            if k < 3:
                scale = max(scale, abs(load[i, k]))
    return energy + add_spring_forces(axis, q, gradient), scale


@kernel
def add_spring_forces(axis: AxisArrays, q: Array, gradient: Array) -> float:
    """Add the spring forces on the r nodes and bodies to ``gradient`` (r, 6) [N, N m]; return the springs' energy [J].

    q (r, 6): motions of the nodes and bodies [m, rad]. ``axis``: ends, lever arms and stiffness of the springs.
    """
    energy = 0.0
    e, f = np.empty(6), np.empty(6)
    for k in range(axis.spring_bodies.shape[0]):
        e[:] = 0.0
        for end in range(2):
            row = axis.spring_bodies[k, end]
            if row >= 0:
                for a in range(6):
                    for b in range(6):
                        e[a] += axis.spring_end_matrices[k, end, a, b] * q[row, b]
        for a in range(6):
            f[a] = 0.0
            for b in range(6):
                f[a] += axis.springs[k, a, b] * e[b]
            energy += 0.5 * f[a] * e[a]
        for end in range(2):
            row = axis.spring_bodies[k, end]
            if row >= 0:
                for a in range(6):
                    for b in range(6):
                        gradient[row, b] += axis.spring_end_matrices[k, end, a, b] * f[a]
    return energy


@kernel
def write_flank_motions_of_ball(balls: AxisBalls, q: Array, i: int, shift: Array) -> None:
    """Compute the motions of the four groove flanks at ball i from the motions q (r, 6) of nodes and bodies.

    The flank motions are written to ``shift`` (4, 2) [m]: for each flank (screw left, screw right, nut left, nut right) the
    radial component and the one along the helix's binormal. ``balls``: coefficients and prescribed offsets of the flanks'
    motions.
    """
    flat = q.ravel()
    for s in range(4):
        row = balls.first_bodies[i, s]
        for a in range(2):
            x = balls.v0[i, s, a]
            if row >= 0:
                for k in range(balls.B.shape[3]):
                    x += balls.B[i, s, a, k] * flat[6 * row + k]
            shift[s, a] = x


@kernel
def factor_tangent_stiffness(
    given: AxisSystem, state: MotionState, hessians: Array, base: Array, values: Array, shift: Array
) -> bool:
    """Assemble and factor the tangent stiffness matrix of shaft, bodies and rolling elements.

    Writes the factor to ``values``; returns False if the matrix is not positive definite. base: stiffness of shaft and
    springs, from `add_structure_stiffness`; hessians (N, 8, 8): stiffness of the balls [N/m]; ``state``: holds the
    stiffness of the roller slices; shift (6,) [N/m, N m]: stiffness added to the diagonal; ``given``: arrays of shaft,
    bodies, springs, balls and rollers.
    """
    axis, balls, rollers = given
    values[:] = base
    add_balls(values, axis, balls, hessians)
    add_roller_stiffness(values, axis, rollers, state.slices)
    fix_prescribed_motions(values, axis, shift)
    return bool(factor(values, axis.first_columns, axis.row_offsets))


@kernel
def solve_for_motions(axis: AxisArrays, values: Array, loads: Array, step: Array) -> None:
    """Solve for the motions ``step`` (r, 6) [m, rad] of nodes and bodies under loads (r, 6) [N, N m].

    values: factored stiffness matrix, from `factor_tangent_stiffness`. Fixed motions are zero. ``axis``: which motions are
    fixed, and the positions of the rows in ``values``.
    """
    b = np.zeros(6 * loads.shape[0])
    for i in range(loads.shape[0]):
        for k in range(6):
            if not axis.fixed[i, k]:
                b[6 * axis.body_order[i] + k] = loads[i, k]
    substitute(values, axis.first_columns, axis.row_offsets, b)
    for i in range(loads.shape[0]):
        for k in range(6):
            step[i, k] = 0.0 if axis.fixed[i, k] else b[6 * axis.body_order[i] + k]


@kernel
def energy_and_largest_force(given: AxisSystem, state: MotionState, workspace: MotionWorkspace) -> tuple[float, float]:
    """Return the energy [J] of shaft, bodies and rolling elements at the state, and the largest force in the model [N].

    ``given``: arrays of shaft, bodies, springs, balls and rollers. The derivatives of the energy are written to the
    ``workspace`` (`evaluate_axis`).
    """
    return evaluate_axis(given, state, workspace.derivatives)


@kernel
def write_newton_step(
    given: AxisSystem, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace, shift: float, fresh: bool
) -> bool:
    """Write Newton's step of the motions of nodes and bodies to the workspace; return False if it cannot be solved.

    shift [N/m]: stiffness added to the diagonal, multiplied by the square of ``options.moment_arm`` for rotations.
    ``given``: arrays of shaft, bodies, springs, balls and rollers. ``fresh`` is not used: the stiffness is factored in
    every step. The ``workspace`` holds the derivatives of the energy at the ``state``.
    """
    diagonal = np.full(6, shift)
    diagonal[3:] *= options.moment_arm * options.moment_arm
    hessians, base, matrix = workspace.derivatives.ball_hessians, workspace.base, workspace.matrix
    if not factor_tangent_stiffness(given, state, hessians, base, matrix, diagonal):
        return False
    solve_for_motions(given.shaft, workspace.matrix, -workspace.derivatives.gradient, workspace.step)
    return True


@kernel
def largest_flank_motion_in_step(given: AxisSystem, workspace: MotionWorkspace) -> float:
    """Return the largest displacement [m] of two opposite flanks of a ball relative to each other in the full Newton step.

    The ``workspace`` holds the step. ``given``: arrays of shaft, bodies, springs, balls and rollers.
    """
    balls, largest, shift = given.balls, 0.0, np.zeros((4, 2))
    for i in range(balls.first_bodies.shape[0]):
        write_flank_motions_of_ball(balls, workspace.step, i, shift)
        for s in range(2):
            if balls.geometry[i, s, USE] != 0.0:
                o = 3 - s
                x = shift[s, 0] - balls.v0[i, s, 0] - shift[o, 0] + balls.v0[i, o, 0]
                z = shift[s, 1] - balls.v0[i, s, 1] - shift[o, 1] + balls.v0[i, o, 1]
                largest = max(largest, x * x + z * z)
    return sqrt(largest)


minimise: Callable[..., Outcome] = load_solver_copy(__name__, "descent").minimise


@kernel
def start_from_springs(given: AxisSystem, state: MotionState, options: NewtonOptions, workspace: MotionWorkspace) -> None:
    """Set the state to a first guess: the equilibrium with linear springs in place of balls and rollers.

    Leaves the state unchanged if the stiffness matrix with these springs is not positive definite. The step is shortened
    such that no flank moves further than ``options.max_flank_step`` [m]. ``given``: arrays of shaft, bodies,
    springs, balls and rollers; ``workspace``: work arrays, changed.
    """
    gradient, hessians = workspace.derivatives
    hessians[:] = 0.0
    for i in range(hessians.shape[0]):
        for a in range(2):
            add_spring_of_flank_pair(given.balls.geometry[i], a, options.stiffness, hessians[i])
    state.slices[:, 0] = 0.0
    state.slices[:, 1] = options.stiffness
    evaluate_structure(given.shaft, state, gradient)
    if write_newton_step(given, state, options, workspace, 1e-9 * options.stiffness, bool(np.bool_(True))):
        shorten_first_step(given, state, options, workspace, largest_flank_motion_in_step(given, workspace))


@kernel
def add_spring_of_flank_pair(geometry: Array, a: int, stiffness: float, out: Array) -> None:
    """Add a linear spring between flank a and the opposite flank 3 - a to the stiffness ``out`` (8, 8) [N/m] of a ball.

    The spring, of this stiffness [N/m], acts along the nominal contact direction. It replaces the ball's two contacts in a
    first guess. geometry (4, 9): contact data of the ball, see `kernel.ball`.
    """
    b = 3 - a
    if geometry[a, USE] == 0.0 or geometry[b, USE] == 0.0:
        return
    size = max(geometry[a, SIZE], 1e-30)
    w = np.empty(4)
    w[0], w[1] = geometry[a, WX] / size, geometry[a, WZ] / size
    w[2], w[3] = -w[0], -w[1]
    for i in range(4):
        row = 2 * a + i if i < 2 else 2 * b + i - 2
        for j in range(4):
            out[row, 2 * a + j if j < 2 else 2 * b + j - 2] += stiffness * w[i] * w[j]


@kernel
def solve_axis(given: AxisSystem, state: MotionState, options: NewtonOptions, start: bool) -> Outcome:
    """Find the static equilibrium of a shaft with its bodies, springs, balls and rollers.

    With ``start`` the iteration begins at the solution with linear springs as rolling elements, otherwise at ``state``,
    which holds the solution on return. ``given``: arrays of shaft, bodies, springs, balls and rollers; ``options``:
    tolerance and limits of the iteration.
    """
    r, size = state.q.shape[0], given.shaft.row_offsets[-1]
    slopes, base = EnergyDerivatives(np.empty((r, 6)), np.zeros((given.balls.first_bodies.shape[0], 8, 8))), np.zeros(size)
    add_structure_stiffness(base, given.shaft)
    workspace = MotionWorkspace(slopes, base, np.empty(size), np.empty((r, 6)), np.empty((r, 6)), np.empty(state.d.shape))
    if start:
        start_from_springs(given, state, options, workspace)
    return minimise(given, state, options, workspace)
