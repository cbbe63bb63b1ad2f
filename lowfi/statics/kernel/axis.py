"""Newton's method on the energy of a shaft, the bodies beside it and the rolling elements between them.

E(q) = shaft + springs - f q + sum over balls of min over the centre of their contact energies + sum over rollers. The
unknowns are the motions of the shaft's nodes and of the bodies; the matrix is held in its envelope (``skyline``), so that
the cost is linear in the number of sets. See ``newton`` for the case of one set whose nut stands.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import driver_of, kernel
from rollbench.lowfi.statics.records import (
    Array,
    AxisArrays,
    AxisBalls,
    AxisRollers,
    AxisRoom,
    AxisSlopes,
    AxisState,
    AxisSystem,
    Options,
    Outcome,
)

from .axis_matrix import add_axis, add_balls, add_rollers, hold
from .ball import FORCE, MX, MZ, USE, flank_hessian, settle_ball
from .newton import evaluate_beam, finish, furthest, least_force, residual_at, slope_along, unbalanced  # noqa: F401 - for the driver
from .rollers import roller_forces
from .skyline import factor, substitute

#: See ``descent``: the stiffness is factored anew for each step.
KEPT = 0.0


@kernel
def evaluate_axis(
    axis: AxisArrays, balls: AxisBalls, rollers: AxisRollers, state: AxisState, out: AxisSlopes
) -> tuple[float, float]:
    """Energy and gradient at the state; fills out; returns energy and the largest force met [N]."""
    load = axis.load
    q, d, p, contact, _ = state
    gradient, hessians = out
    energy, scale = evaluate_beam(axis, q, d, gradient)
    for i in range(d.shape[0] + 1, q.shape[0]):
        for k in range(6):
            gradient[i, k] = -load[i, k]
            energy -= load[i, k] * q[i, k]
            if k < 3:
                scale = max(scale, abs(load[i, k]))
    energy += spring_forces(axis, q, gradient)
    shift, flat, m = np.zeros((4, 2)), gradient.ravel(), balls.B.shape[3]
    for i in range(balls.r_ball.shape[0]):
        ball_shift(balls, q, i, shift)
        energy += settle_ball(
            p[i], shift, balls.geometry[i], balls.closure[i], balls.r_ball[i], balls.profile[i], balls.tiny, contact[i]
        )
        flank_hessian(contact[i], hessians[i])
        for s in range(4):
            force, row = contact[i, s, FORCE], balls.row[i, s]
            scale = max(scale, force)
            if force > 0.0 and row >= 0:
                fx, fz = force * contact[i, s, MX], force * contact[i, s, MZ]
                for k in range(m):
                    flat[6 * row + k] -= fx * balls.B[i, s, 0, k] + fz * balls.B[i, s, 1, k]
    stored, largest = roller_forces(rollers, q, state.slices, gradient)
    return energy + stored, max(scale, largest)


@kernel
def spring_forces(axis: AxisArrays, q: Array, gradient: Array) -> float:
    """Add the springs' forces to the gradient; returns their energy [J]."""
    energy = 0.0
    e, f = np.empty(6), np.empty(6)
    for k in range(axis.ends.shape[0]):
        e[:] = 0.0
        for end in range(2):
            row = axis.ends[k, end]
            if row >= 0:
                for a in range(6):
                    for b in range(6):
                        e[a] += axis.reach[k, end, a, b] * q[row, b]
        for a in range(6):
            f[a] = 0.0
            for b in range(6):
                f[a] += axis.springs[k, a, b] * e[b]
            energy += 0.5 * f[a] * e[a]
        for end in range(2):
            row = axis.ends[k, end]
            if row >= 0:
                for a in range(6):
                    for b in range(6):
                        gradient[row, b] += axis.reach[k, end, a, b] * f[a]
    return energy


@kernel
def ball_shift(balls: AxisBalls, q: Array, i: int, shift: Array) -> None:
    """Motions (4, 2) [m] of the flanks of ball i."""
    flat = q.ravel()
    for s in range(4):
        row = balls.row[i, s]
        for a in range(2):
            x = balls.v0[i, s, a]
            if row >= 0:
                for k in range(balls.B.shape[3]):
                    x += balls.B[i, s, a, k] * flat[6 * row + k]
            shift[s, a] = x


@kernel
def balls_reach(balls: AxisBalls, step: Array) -> float:
    """Largest motion [m] by a step of the rows (r, 6) of a flank that is used, against its opposite."""
    largest, shift = 0.0, np.zeros((4, 2))
    for i in range(balls.row.shape[0]):
        ball_shift(balls, step, i, shift)
        for s in range(2):
            if balls.geometry[i, s, USE] != 0.0:
                o = 3 - s
                x = shift[s, 0] - balls.v0[i, s, 0] - shift[o, 0] + balls.v0[i, o, 0]
                z = shift[s, 1] - balls.v0[i, s, 1] - shift[o, 1] + balls.v0[i, o, 1]
                largest = max(largest, x * x + z * z)
    return sqrt(largest)


@kernel
def advance_axis(axis: AxisArrays, state: AxisState, q0: Array, d0: Array, step: Array, t: float) -> None:
    """State at (q0, d0) plus t step, the shaft in element deformations: the strain of the step is taken from the step."""
    q, d, lengths = state.q, state.d, axis.lengths
    n = d.shape[0] + 1
    for k in range(6):
        q[0, k] = q0[0, k] + t * step[0, k]
        for i in range(n, q.shape[0]):
            q[i, k] = q0[i, k] + t * step[i, k]
    for e in range(d.shape[0]):
        x = lengths[e]
        d[e, 0] = d0[e, 0] + t * (step[e + 1, 0] - step[e, 0] - x * step[e, 4])
        d[e, 1] = d0[e, 1] + t * (step[e + 1, 1] - step[e, 1] + x * step[e, 3])
        for k in range(2, 6):
            d[e, k] = d0[e, k] + t * (step[e + 1, k] - step[e, k])


@kernel
def tangent(
    axis: AxisArrays,
    balls: AxisBalls,
    rollers: AxisRollers,
    state: AxisState,
    hessians: Array,
    base: Array,
    values: Array,
    shift: Array,
) -> bool:
    """Factor (in ``values``) of the Hessian of the energy plus ``shift`` (6,) on the diagonal; False where not positive.

    base: stiffness of shaft and springs, of ``add_axis``.
    """
    values[:] = base
    add_balls(values, axis, balls, hessians)
    add_rollers(values, axis, rollers, state.slices)
    hold(values, axis, shift)
    return bool(factor(values, axis.first, axis.start))


@kernel
def solve_lines(axis: AxisArrays, values: Array, loads: Array, step: Array) -> None:
    """Motions (r, 6) by loads (r, 6) from the factor; held freedoms do not move."""
    b = np.zeros(6 * loads.shape[0])
    for i in range(loads.shape[0]):
        for k in range(6):
            if not axis.fixed[i, k]:
                b[6 * axis.place[i] + k] = loads[i, k]
    substitute(values, axis.first, axis.start, b)
    for i in range(loads.shape[0]):
        for k in range(6):
            step[i, k] = 0.0 if axis.fixed[i, k] else b[6 * axis.place[i] + k]


@kernel
def energy_at(given: AxisSystem, state: AxisState, room: AxisRoom) -> tuple[float, float]:
    """``evaluate_axis``, for the driver."""
    return evaluate_axis(given.shaft, given.balls, given.rollers, state, room.slopes)


@kernel
def find_step(given: AxisSystem, state: AxisState, options: Options, room: AxisRoom, shift: float, fresh: bool) -> bool:
    """Newton's step."""
    diagonal = np.full(6, shift)
    diagonal[3:] *= options.arm * options.arm
    out = room.slopes
    if not tangent(given.shaft, given.balls, given.rollers, state, out.hessians, room.base, room.values, diagonal):
        return False
    solve_lines(given.shaft, room.values, -out.gradient, room.step)
    return True


@kernel
def reach_of(given: AxisSystem, room: AxisRoom) -> float:
    """Largest motion [m] by the step of a flank against its opposite."""
    return balls_reach(given.balls, room.step)


@kernel
def keep(state: AxisState, room: AxisRoom) -> None:
    """Note where the step begins."""
    room.q0[:], room.d0[:] = state.q, state.d


@kernel
def move(given: AxisSystem, state: AxisState, room: AxisRoom, t: float) -> None:
    """State t steps from where the step begins."""
    advance_axis(given.shaft, state, room.q0, room.d0, room.step, t)


minimise: Callable[..., Outcome] = driver_of(__name__, "descent").minimise


@kernel
def solve_axis(
    axis: AxisArrays, balls: AxisBalls, rollers: AxisRollers, state: AxisState, options: Options, history: Array
) -> Outcome:
    """Minimise the energy from the given state; history (most + 1,): residual per step."""
    r, size = state.q.shape[0], axis.start[-1]
    slopes, base = AxisSlopes(np.empty((r, 6)), np.zeros((balls.row.shape[0], 8, 8))), np.zeros(size)
    add_axis(base, axis)
    room = AxisRoom(slopes, base, np.empty(size), np.empty((r, 6)), np.empty((r, 6)), np.empty(state.d.shape))
    return minimise(AxisSystem(axis, balls, rollers), state, options, history, room)
