"""Elastic energy of balls between the grooves of two rigid bodies, and Newton's method for its minimum.

The bodies are screw and nut, inner and outer ring (a screw of zero lead), or rail and carriage. The last function solves
the banded linear systems of Newton's method for balls that push each other with friction.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array, BallContactArrays, BallContactState
from rollbench.lowfi.jit import kernel

#: Number of a ball's contacts on the inner body, which come first; the others are on the outer body.
ON_INNER = 2
#: Longest Newton step, as a fraction of the distance of the grooves' centres of curvature from the ball's centre.
LONGEST_STEP = 0.3


@kernel
def hertz_contact(
    start_x: float, start_z: float, move_x: float, move_z: float, interference: float, C: float
) -> tuple[float, float, float, float, float]:
    """Return the contact force and the contact normal of a ball and a groove after a relative displacement of the ball.

    start_x, start_z: vector from the groove's centre of curvature to the ball's centre before the displacement [m];
    move_x, move_z: displacement [m]; interference: interference of ball and groove before the displacement [m]; C:
    Hertz constant of the approach C F^(2/3) [m/N^(2/3)]. Returns the force [N], the unit vector (x, z) from the ball's
    centre to the contact, the approach divided by C [N^(2/3)], and the distance of the centres of groove and ball [m].
    """
    x, z = start_x + move_x, start_z + move_z
    size = sqrt(x * x + z * z)
    # change of the distance, computed without cancellation
    grown = (move_x * (start_x + x) + move_z * (start_z + z)) / (size + sqrt(start_x * start_x + start_z * start_z))
    d = max(grown + interference, 0.0) / C
    return d * sqrt(d), x / size, z / size, d, size


@kernel
def contact_energy(cell: BallContactArrays, p: Array, u: Array, state: BallContactState) -> float:
    """Return the elastic contact energy [J] of N balls at given displacements; write its derivatives to ``state``.

    cell: geometry, stiffness and applied forces; p (N, 2): displacements of the balls; u (m,): displacements of the
    inner body in the m motions in which it is free [m]. The energy is sum (2/5) C^(-3/2) <approach>^(5/2), with
    <approach> the approach where positive. Contact forces, normals, stiffness and gradient are written to ``state``.
    The gradient is that of the energy less the work push . p + pull . u of the applied forces, a convex function.
    """
    start, interference, C, section, offset, push, pull, _ = cell
    ball, inner, stiff, force, normal = state
    energy = 0.0
    for j in range(u.shape[0]):
        inner[j] = -pull[j]
    for k in range(p.shape[0]):
        shift_x, shift_z = offset[k, 0], offset[k, 1]
        for j in range(u.shape[0]):
            shift_x += section[k, 0, j] * u[j]
            shift_z += section[k, 1, j] * u[j]
        ball[k, 0], ball[k, 1] = -push[k, 0], -push[k, 1]
        for i in range(4):
            x, z = p[k, 0], p[k, 1]
            if i < ON_INNER:
                x, z = x - shift_x, z - shift_z
            f, n_x, n_z, d, size = hertz_contact(start[k, i, 0], start[k, i, 1], x, z, interference[k, i], C[i])
            k_n, k_t = 1.5 * sqrt(d) / C[i], f / size
            force[k, i], normal[k, i, 0], normal[k, i, 1] = f, n_x, n_z
            stiff[k, i, 0] = k_t + (k_n - k_t) * n_x * n_x
            stiff[k, i, 1] = (k_n - k_t) * n_x * n_z
            stiff[k, i, 2] = k_t + (k_n - k_t) * n_z * n_z
            energy += 0.4 * C[i] * d * f
            ball[k, 0] += f * n_x
            ball[k, 1] += f * n_z
            if i < ON_INNER:
                for j in range(u.shape[0]):
                    inner[j] -= f * (n_x * section[k, 0, j] + n_z * section[k, 1, j])
    return energy


@kernel
def write_position_newton_step(
    cell: BallContactArrays, state: BallContactState, floor: float, dp: Array, du: Array
) -> None:
    """Write Newton's step of the ball positions to dp (N, 2) and of the inner body to du (m,) [m].

    The equations of the balls are eliminated first. cell: geometry of balls and inner body; state: gradient and
    stiffness that `contact_energy` has written; floor: stiffness that is added on the diagonal [N/m], so that balls
    without contact have a finite step.
    """
    section = cell.inner_displacement_maps
    ball = state.ball_unbalanced_forces
    inner = state.inner_unbalanced_forces
    stiff = state.stiffness
    n, m = ball.shape[0], inner.shape[0]
    schur, solved, right = np.zeros((m, m)), np.empty((n, 2, m)), -inner
    for j in range(m):
        schur[j, j] = floor
    for k in range(n):
        least = floor
        if np.max(state.force[k]) == 0.0:  # limits the step of a ball without contact, which would shorten all steps
            least = max(
                floor,
                sqrt(ball[k, 0] * ball[k, 0] + ball[k, 1] * ball[k, 1]) / (LONGEST_STEP * cell.groove_ball_centre_distance),
            )
        xx, xz, zz, s_xx, s_xz, s_zz = least, 0.0, least, 0.0, 0.0, 0.0
        for i in range(4):
            xx, xz, zz = xx + stiff[k, i, 0], xz + stiff[k, i, 1], zz + stiff[k, i, 2]
            if i < ON_INNER:
                s_xx, s_xz, s_zz = s_xx + stiff[k, i, 0], s_xz + stiff[k, i, 1], s_zz + stiff[k, i, 2]
        det = xx * zz - xz * xz
        dp[k, 0] = -(zz * ball[k, 0] - xz * ball[k, 1]) / det
        dp[k, 1] = -(xx * ball[k, 1] - xz * ball[k, 0]) / det
        for j in range(m):
            c_x = s_xx * section[k, 0, j] + s_xz * section[k, 1, j]
            c_z = s_xz * section[k, 0, j] + s_zz * section[k, 1, j]
            solved[k, 0, j], solved[k, 1, j] = (zz * c_x - xz * c_z) / det, (xx * c_z - xz * c_x) / det
            right[j] += c_x * dp[k, 0] + c_z * dp[k, 1]
            for q in range(m):
                schur[q, j] += section[k, 0, q] * c_x + section[k, 1, q] * c_z
        for j in range(m):
            c_x = s_xx * section[k, 0, j] + s_xz * section[k, 1, j]
            c_z = s_xz * section[k, 0, j] + s_zz * section[k, 1, j]
            for q in range(m):
                schur[j, q] -= c_x * solved[k, 0, q] + c_z * solved[k, 1, q]
    if m == 0:
        return
    du[:] = np.linalg.solve(schur, right)
    for k in range(n):
        for j in range(m):
            dp[k, 0] += solved[k, 0, j] * du[j]
            dp[k, 1] += solved[k, 1, j] * du[j]


@kernel
def copy_contact_state(source: BallContactState, to: BallContactState) -> None:
    """Copy contact forces, normals, stiffness and unbalanced forces from the state ``source`` to the state ``to``."""
    to.ball_unbalanced_forces[:] = source.ball_unbalanced_forces
    to.inner_unbalanced_forces[:] = source.inner_unbalanced_forces
    to.stiffness[:] = source.stiffness
    to.force[:], to.normal[:] = source.force, source.normal


@kernel
def largest_entry(balls: Array, inner: Array) -> float:
    """Return the largest absolute value in ``balls`` (N, 2) and ``inner`` (m,), such as the largest unbalanced force."""
    size = 0.0
    for k in range(balls.shape[0]):
        size = max(size, abs(balls[k, 0]), abs(balls[k, 1]))
    for j in range(inner.shape[0]):
        size = max(size, abs(inner[j]))
    return size


@kernel
def minimise_energy(
    cell: BallContactArrays, load: float, p: Array, u: Array, state: BallContactState, goal: float, limit: int
) -> int:
    """Find the displacements of balls and inner body at the minimum of elastic energy; return the number of Newton steps.

    cell: geometry, stiffness and applied forces; p (N, 2): displacements of the balls, u (m,): displacements of the
    inner body [m] from which the search begins; p, u and ``state`` are overwritten by the result. load: sum of the
    magnitudes of the applied forces [N]. The iteration ends when the largest unbalanced force is below ``goal`` times
    the sum of all forces, after ``limit`` steps, or when round-off prevents a further decrease of energy and imbalance.
    """
    reach = cell.groove_ball_centre_distance
    dp, du = np.zeros_like(p), np.zeros_like(u)
    stiff, force, normal = np.zeros_like(state.stiffness), np.zeros_like(state.force), np.zeros_like(state.normal)
    trial = BallContactState(np.zeros_like(p), np.zeros_like(u), stiff, force, normal)
    energy, steps = contact_energy(cell, p, u, state), 0
    worst = largest_entry(state.ball_unbalanced_forces, state.inner_unbalanced_forces)
    while steps < limit and worst > goal * (load + np.sum(state.force)):
        steps += 1
        floor = 1e-12 * np.max(state.stiffness) + 1e-12 * max(load, 1e-9) / reach
        write_position_newton_step(cell, state, floor, dp, du)
        length = min(1.0, LONGEST_STEP * reach / max(largest_entry(dp, du), 1e-300))
        slope = np.sum(state.ball_unbalanced_forces * dp) + np.sum(state.inner_unbalanced_forces * du)
        work = np.sum(cell.ball_forces * dp) + np.sum(cell.inner_body_forces * du)
        moved = False
        for _ in range(50):
            new = contact_energy(cell, p + length * dp, u + length * du, trial)
            # the work of the step is added separately, which is precise also for nearly unloaded balls; if round-off still
            # hides the decrease of the energy, the imbalance decides
            flat = -length * slope <= 1e-12 * energy
            off = largest_entry(trial.ball_unbalanced_forces, trial.inner_unbalanced_forces)
            if off < worst if flat else new - energy - length * work <= 1e-4 * length * slope:
                moved = True
                break
            length *= 0.5
        if not moved:
            break
        p += length * dp
        u += length * du
        energy, worst = new, off
        copy_contact_state(trial, state)
    return steps


@kernel
def minimise_energy_of_each_ball(
    start: Array,
    interference: Array,
    C: Array,
    along: Array,
    given: Array,
    x: Array,
    force: Array,
    normal: Array,
    left: Array,
    goal: float,
    limit: int,
) -> None:
    """Minimise the elastic energy of N independent balls, each with its own inner body that moves in one direction only.

    start (N, 4, 2): vectors from the grooves' centres of curvature to the ball's centre along x, z [m]; interference
    (N, 4): interference of ball and groove [m], both before any displacement; C (N, 4): Hertz constants [m/N^(2/3)];
    along (2,): direction in which the inner bodies move; given (N, 3): applied forces on the ball along x, z and on the
    inner body [N]; goal: largest unbalanced force over the sum of all forces; limit: largest number of Newton steps. x
    (N, 3): displacements of ball and inner body [m] from which the search begins, overwritten by the result. Writes
    contact forces to force (N, 4) [N], contact normals to normal (N, 4, 2), and the largest unbalanced force to left
    (N,) [N].
    """
    section, offset, stiff = along.copy().reshape(1, 2, 1), np.zeros((1, 2)), np.zeros((1, 4, 3))
    for k in range(x.shape[0]):
        reach = sqrt(np.min(np.sum(start[k] * start[k], axis=1)))
        push, pull = given[k : k + 1, :2].copy(), given[k, 2:].copy()
        cell = BallContactArrays(start[k : k + 1], interference[k : k + 1], C[k], section, offset, push, pull, reach)
        state = BallContactState(np.zeros((1, 2)), np.zeros(1), stiff, force[k : k + 1], normal[k : k + 1])
        ball, inner = x[k : k + 1, :2].copy(), x[k, 2:].copy()
        minimise_energy(cell, float(np.sum(np.abs(given[k]))), ball, inner, state, goal, limit)
        x[k, :2] = ball[0]
        x[k, 2:] = inner
        left[k] = largest_entry(state.ball_unbalanced_forces, state.inner_unbalanced_forces)


@kernel
def solve_with_pivots(K: Array, x: Array, half: int) -> float:
    """Solve a banded linear system by Gaussian elimination with row exchange; return the sign of the matrix's determinant.

    Entry (i, j) of the matrix is K[i, half + j - i], with the half bandwidth ``half``; K (n, 3 half + 1) has room for
    entries that row exchange adds. The right-hand sides x (n, c) are overwritten by the solutions, K by its factors.
    For a singular K the solutions are huge. Row exchange is needed because friction between balls makes the matrix
    unsymmetric and, beyond a fold of the solution, indefinite.
    """
    n, sign = x.shape[0], 1.0
    for c in range(n):
        low, right, top = min(n, c + half + 1), min(n, c + 2 * half + 1), c
        for r in range(c + 1, low):
            if abs(K[r, half + c - r]) > abs(K[top, half + c - top]):
                top = r
        if top != c:
            sign = -sign
            for j in range(c, right):
                K[c, half + j - c], K[top, half + j - top] = K[top, half + j - top], K[c, half + j - c]
            for q in range(x.shape[1]):
                x[c, q], x[top, q] = x[top, q], x[c, q]
        if K[c, half] == 0.0:
            K[c, half] = 1e-300
        if K[c, half] < 0.0:
            sign = -sign
        for r in range(c + 1, low):
            ratio = K[r, half + c - r] / K[c, half]
            if ratio != 0.0:
                for j in range(c + 1, right):
                    K[r, half + j - r] -= ratio * K[c, half + j - c]
                for q in range(x.shape[1]):
                    x[r, q] -= ratio * x[c, q]
    for c in range(n - 1, -1, -1):
        for q in range(x.shape[1]):
            for j in range(c + 1, min(n, c + 2 * half + 1)):
                x[c, q] -= K[c, half + j - c] * x[j, q]
            x[c, q] /= K[c, half]
    return sign
