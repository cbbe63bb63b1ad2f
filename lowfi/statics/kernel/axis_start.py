"""Where Newton's method begins on several rolling sets: balls and rollers as linear springs."""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, AxisArrays, AxisBalls, AxisRollers, AxisSlopes, AxisState, Options

from .axis import advance_axis, balls_reach, evaluate_axis, solve_lines, tangent
from .axis_matrix import add_axis
from .ball import SIZE, USE, WX, WZ


@kernel
def start_axis(axis: AxisArrays, balls: AxisBalls, rollers: AxisRollers, state: AxisState, options: Options) -> bool:
    """Start of the iteration: equilibrium on linear springs (reference stiffness) in place of balls and rollers.

    Overwrites motions and deformations of ``state``; False (state untouched) where it cannot be found. No flank goes
    further from its opposite than the largest ball's radius.
    """
    count, r = balls.row.shape[0], state.q.shape[0]
    hessians = np.zeros((count, 8, 8))
    for i in range(count):
        for a in range(2):
            spring_of_pair(balls.geometry[i], a, options.stiffness, hessians[i])
    state.slices[:, 0] = 0.0
    state.slices[:, 1] = options.stiffness
    out = AxisSlopes(np.zeros((r, 6)), np.zeros((0, 8, 8)))
    none = AxisBalls(
        balls.row[:0],
        balls.B[:0],
        balls.v0[:0],
        balls.geometry[:0],
        balls.closure[:0],
        balls.r_ball[:0],
        balls.profile[:0],
        0.0,
    )
    bare = AxisRollers(rollers.row[:0], rollers.B[:0], rollers.drop[:0], rollers.width[:0], rollers.g[:0], rollers.s[:0])
    evaluate_axis(axis, none, bare, state, out)
    values, base, step = np.empty(axis.start[-1]), np.zeros(axis.start[-1]), np.zeros((r, 6))
    add_axis(base, axis)
    shift = 1e-9 * options.stiffness * np.ones(6)
    for k in range(3, 6):
        shift[k] *= options.arm * options.arm
    if not tangent(axis, balls, rollers, state, hessians, base, values, shift):
        return False
    solve_lines(axis, values, -out.gradient, step)
    reach, limit = balls_reach(balls, step), (balls.r_ball.max() if count else 0.0)
    advance_axis(axis, state, state.q.copy(), state.d.copy(), step, 1.0 if reach <= limit else limit / reach)
    return True


@kernel
def spring_of_pair(geometry: Array, a: int, stiffness: float, out: Array) -> None:
    """Add a spring between flank a and its opposite, along the nominal contact direction, to a ball's Hessian (8, 8)."""
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
