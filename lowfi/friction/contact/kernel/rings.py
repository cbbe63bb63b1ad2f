"""Energy of balls pressed between grooves of two rigid bodies, and Newton's method for its minimum.

The bodies are screw and nut, rings (a screw of zero lead), or rail and carriage.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array, CellArrays, CellState
from rollbench.lowfi.jit import kernel

#: Contacts 0 and 1 of a ball are on the inner body, 2 and 3 on the outer one.
ON_INNER = 2
#: Longest step as a fraction of the distance of the grooves' centres from the ball.
LONGEST_STEP = 0.3


@kernel
def hertz_contact(
    start_x: float, start_z: float, move_x: float, move_z: float, interference: float, C: float
) -> tuple[float, float, float, float, float]:
    """Return Hertz force [N], its direction (x3, z3) on the groove, approach/C and distance [m] after a ball's move."""
    x, z = start_x + move_x, start_z + move_z
    size = sqrt(x * x + z * z)
    # growth of the distance, built as a change so that its round-off is that of the motion
    grown = (move_x * (start_x + x) + move_z * (start_z + z)) / (size + sqrt(start_x * start_x + start_z * start_z))
    d = max(grown + interference, 0.0) / C
    return d * sqrt(d), x / size, z / size, d, size


@kernel
def contact_energy(cell: CellArrays, p: Array, u: Array, state: CellState) -> float:
    """Return the elastic energy [J] at positions of balls (N, 2) and inner body (m,) [m]; write ``state``.

    sum (2/5) C^(-3/2) <approach>^(5/2); less push . p + pull . u, which ``state`` derives too, it is convex.
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
def newton_step(cell: CellArrays, state: CellState, floor: float, dp: Array, du: Array) -> None:
    """Write Newton's step of balls (N, 2) and inner body (m,); the balls are eliminated."""
    section, ball, inner, stiff = cell.section, state.ball, state.inner, state.stiffness
    n, m = ball.shape[0], inner.shape[0]
    schur, solved, right = np.zeros((m, m)), np.empty((n, 2, m)), -inner
    for j in range(m):
        schur[j, j] = floor
    for k in range(n):
        least = floor
        if np.max(state.force[k]) == 0.0:  # a ball that floats would ask for a step that makes those of others tiny
            least = max(floor, sqrt(ball[k, 0] * ball[k, 0] + ball[k, 1] * ball[k, 1]) / (LONGEST_STEP * cell.reach))
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
def copy_state(source: CellState, to: CellState) -> None:
    """Overwrite ``to`` by ``source``."""
    to.ball[:], to.inner[:], to.stiffness[:] = source.ball, source.inner, source.stiffness
    to.force[:], to.normal[:] = source.force, source.normal


@kernel
def largest_entry(balls: Array, inner: Array) -> float:
    """Return the largest entry in size of (N, 2) and (m,)."""
    size = 0.0
    for k in range(balls.shape[0]):
        size = max(size, abs(balls[k, 0]), abs(balls[k, 1]))
    for j in range(inner.shape[0]):
        size = max(size, abs(inner[j]))
    return size


@kernel
def minimise_energy(cell: CellArrays, load: float, p: Array, u: Array, state: CellState, goal: float, limit: int) -> int:
    """Minimise the energy from (p, u), which are overwritten as ``state`` is; return the steps.

    load: sum of the sizes of the given forces [N]. Ends where nothing is out of balance by more than ``goal`` of the
    sum of all forces, or where round-off lets neither energy nor imbalance fall.
    """
    reach = cell.reach
    dp, du = np.zeros_like(p), np.zeros_like(u)
    stiff, force, normal = np.zeros_like(state.stiffness), np.zeros_like(state.force), np.zeros_like(state.normal)
    trial = CellState(np.zeros_like(p), np.zeros_like(u), stiff, force, normal)
    energy, steps = contact_energy(cell, p, u, state), 0
    worst = largest_entry(state.ball, state.inner)
    while steps < limit and worst > goal * (load + np.sum(state.force)):
        steps += 1
        floor = 1e-12 * np.max(state.stiffness) + 1e-12 * max(load, 1e-9) / reach
        newton_step(cell, state, floor, dp, du)
        length = min(1.0, LONGEST_STEP * reach / max(largest_entry(dp, du), 1e-300))
        slope = np.sum(state.ball * dp) + np.sum(state.inner * du)
        work = np.sum(cell.push * dp) + np.sum(cell.pull * du)
        moved = False
        for _ in range(50):
            new = contact_energy(cell, p + length * dp, u + length * du, trial)
            # the work is that of the step, to keep precision for nearly unloaded balls, which would otherwise drift; where
            # round-off still hides the fall of the energy, the forces must tell
            flat = -length * slope <= 1e-12 * energy
            off = largest_entry(trial.ball, trial.inner)
            if off < worst if flat else new - energy - length * work <= 1e-4 * length * slope:
                moved = True
                break
            length *= 0.5
        if not moved:
            break
        p += length * dp
        u += length * du
        energy, worst = new, off
        copy_state(trial, state)
    return steps


@kernel
def minimise_each(
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
    """Minimise the energy of N balls, each with an inner body that moves along ``along`` (2,); see `minimise_energy`.

    start, interference as in ``CellArrays``; C (N, 4); given (N, 3): forces on ball and inner body [N]. Overwrites
    positions x (N, 3) [m], forces (N, 4), normals (N, 4, 2), and writes the largest force out of balance left (N,) [N].
    """
    section, offset, stiff = along.copy().reshape(1, 2, 1), np.zeros((1, 2)), np.zeros((1, 4, 3))
    for k in range(x.shape[0]):
        reach = sqrt(np.min(np.sum(start[k] * start[k], axis=1)))
        push, pull = given[k : k + 1, :2].copy(), given[k, 2:].copy()
        cell = CellArrays(start[k : k + 1], interference[k : k + 1], C[k], section, offset, push, pull, reach)
        state = CellState(np.zeros((1, 2)), np.zeros(1), stiff, force[k : k + 1], normal[k : k + 1])
        ball, inner = x[k : k + 1, :2].copy(), x[k, 2:].copy()
        minimise_energy(cell, float(np.sum(np.abs(given[k]))), ball, inner, state, goal, limit)
        x[k, :2], x[k, 2:], left[k] = ball[0], inner, largest_entry(state.ball, state.inner)
