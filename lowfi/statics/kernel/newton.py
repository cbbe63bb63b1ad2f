"""Regularised Newton with line search on the convex energy of screw and balls (seed audit; Lin 2.23-2.25).

E(q) = beam(q) - f q + sum over balls of min over the centre of the contact energies. One unknown motion (6) per node;
banded Cholesky, so the cost is linear in the number of balls.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from rollbench.lowfi.jit import driver_of, kernel
from rollbench.lowfi.statics.records import (
    Array,
    AxisArrays,
    BeamArrays,
    BeamContacts,
    BeamRoom,
    BeamSlopes,
    BeamState,
    BeamSystem,
    Options,
    Outcome,
    RowRoom,
    Rows,
    RowState,
)

from .ball import FORCE, MX, MZ, SIZE, USE, WX, WZ, ball_mismatch, flank_hessian, settle_ball
from .banded import factor_band, substitute_band
from .beam import force_of

#: Residual over the one before from which on, near the end, the stiffness is factored anew; below, the last factor serves.
KEPT = 1e-3
#: Least shift of the stiffness over the beam's: below it a motion that nothing resists has the stiffness of round-off.
ROUND_OFF = 1e-17


@kernel
def flank_shift(contacts: BeamContacts, motion: Array, i: int, m: int, shift: Array) -> None:
    """Motions [m] of the screw's flanks at ball i by the nodal motions (6 n,); shift (4, 2)."""
    B = contacts.B
    for s in range(2):
        if contacts.geometry[i, s, USE] != 0.0:
            start = 6 * contacts.node[i, s]
            x, z = 0.0, 0.0
            for k in range(m):
                x += B[i, s, 0, k] * motion[start + k]
                z += B[i, s, 1, k] * motion[start + k]
            shift[s, 0], shift[s, 1] = x, z


@kernel
def pull(gradient: Array, B: Array, i: int, s: int, m: int, start: int, fx: float, fz: float) -> None:
    """Add what the force (fx, fz) [N] of ball i on flank s does to the gradient (6 n,)."""
    for k in range(m):
        gradient[start + k] -= fx * B[i, s, 0, k] + fz * B[i, s, 1, k]


@kernel
def evaluate_beam(beam: BeamArrays | AxisArrays, q: Array, d: Array, gradient: Array) -> tuple[float, float]:
    """Fill the nodes' motions q (n, 6) from the first node's and the element deformations d, and the gradient (n, 6) of the
    energy of beam and loads; returns that energy and the largest force of either. Rows beyond the nodes are left alone."""
    last, energy, scale = d.shape[0], 0.0, 0.0
    fx, fy, fz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z, a, b, c = q[0, 0], q[0, 1], q[0, 2], q[0, 3], q[0, 4], q[0, 5]
    for i in range(last + 1):
        p, g = beam.load[i], gradient[i]
        energy -= p[0] * x + p[1] * y + p[2] * z + p[3] * a + p[4] * b + p[5] * c
        scale = max(scale, abs(p[0]), abs(p[1]), abs(p[2]))
        g[0], g[1], g[2], g[3], g[4], g[5] = fx - p[0], fy - p[1], fz - p[2], mx - p[3], my - p[4], mz - p[5]
        if i < last:
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
def evaluate(beam: BeamArrays, contacts: BeamContacts, state: BeamState, out: BeamSlopes) -> tuple[float, float]:
    """Energy and gradient at the state; fills out; returns energy and scale.

    The scale [N] is the largest force met: applied, in an element, or of a contact.
    """
    node, B, geometry, closure, r_ball, profile, tiny = contacts
    q, d, p, contact = state
    gradient, hessians = out
    energy, scale = evaluate_beam(beam, q, d, gradient)
    shift = np.zeros((4, 2))
    flat = q.ravel()
    grad = gradient.ravel()
    m = B.shape[3]
    for i in range(r_ball.shape[0]):
        if m == 6:  # by its number: the compiler then unrolls the loops
            flank_shift(contacts, flat, i, 6, shift)
        else:
            flank_shift(contacts, flat, i, m, shift)
        energy += settle_ball(p[i], shift, geometry[i], closure[i], r_ball[i], profile, tiny, contact[i])
        flank_hessian(contact[i], hessians[i])
        for s in range(4):
            scale = max(scale, contact[i, s, FORCE])
        for s in range(2):
            f = contact[i, s, FORCE]
            if f > 0.0:
                fx, fz = f * contact[i, s, MX], f * contact[i, s, MZ]
                if m == 6:
                    pull(grad, B, i, s, 6, 6 * node[i, s], fx, fz)
                else:
                    pull(grad, B, i, s, m, 6 * node[i, s], fx, fz)
    return energy, scale


@kernel
def add_own(band: Array, b: Array, h: tuple[float, float, float], start: int, m: int, room: Array) -> None:
    """Add b^T h b, of one flank's motion b (2, m) and its stiffness h (xx, xz, zz), to the lower band; room (2, m)."""
    for k in range(m):
        room[0, k] = h[0] * b[0, k] + h[1] * b[1, k]
        room[1, k] = h[1] * b[0, k] + h[2] * b[1, k]
    for k in range(m):
        x, z = room[0, k], room[1, k]
        for j in range(k, m):
            band[start + k, j - k] += x * b[0, j] + z * b[1, j]


@kernel
def add_between(band: Array, b: Array, c: Array, h: Array, rows: int, columns: int, room: Array) -> None:
    """Add b^T h c, of the motions b, c (2, m) of a ball's two flanks and the stiffness h (2, 2) between them, to the lower
    band from ``rows`` and ``columns`` on; room (2, m)."""
    m = b.shape[1]
    for a in range(2):
        for k in range(m):
            room[a, k] = h[a, 0] * c[0, k] + h[a, 1] * c[1, k]
    for j in range(m):
        x, z = b[0, j], b[1, j]
        for k in range(min(m, rows - columns + j + 1)):
            band[columns + k, rows - columns + j - k] += x * room[0, k] + z * room[1, k]


@kernel
def assemble(band: Array, beam: BeamArrays, contacts: BeamContacts, hessians: Array, shift: float, arm: float) -> None:
    """Hessian of the energy in the lower band, plus ``shift`` [N/m] (times arm^2 for rotations) on the diagonal."""
    fixed, node, B = beam.fixed, contacts.node, contacts.B
    whole, given = band.ravel(), beam.band.ravel()
    for i in range(whole.size):
        whole[i] = given[i]
    m = B.shape[3]
    room = np.empty((2, m))
    for i in range(node.shape[0]):
        for s in range(2):
            o, t = 2 * s, 2 - 2 * s
            stiffness = hessians[i, o, o], hessians[i, o, o + 1], hessians[i, o + 1, o + 1]
            if stiffness[0] == 0.0 and stiffness[2] == 0.0:
                continue
            if m == 6:  # by its number: the compiler then unrolls the loops
                add_own(band, B[i, s], stiffness, 6 * node[i, s], 6, room)
            else:
                add_own(band, B[i, s], stiffness, 6 * node[i, s], m, room)
            if hessians[i, o, t] != 0.0 or hessians[i, o + 1, t + 1] != 0.0:
                between, rows, columns = hessians[i, o : o + 2, t : t + 2], 6 * node[i, s], 6 * node[i, 1 - s]
                add_between(band, B[i, s], B[i, 1 - s], between, rows, columns, room)
    for i in range(fixed.shape[0]):
        for k in range(6):
            band[6 * i + k, 0] += shift if k < 3 else shift * arm * arm
            if fixed[i, k]:
                hold(band, 6 * i + k)


@kernel
def hold(band: Array, i: int) -> None:
    """Take the unknown i out of the equations."""
    width = band.shape[1]
    for w in range(width):
        band[i, w] = 0.0
    for w in range(1, min(width, i + 1)):
        band[i - w, w] = 0.0
    band[i, 0] = 1.0


@kernel
def advance(q: Array, d: Array, lengths: Array, q0: Array, d0: Array, step: Array, t: float) -> None:
    """State at q0 + t step, in element deformations: the strain of the step is taken from the step alone."""
    for k in range(6):
        q[0, k] = q0[k] + t * step[0, k]
    for e in range(d.shape[0]):
        x = lengths[e]
        d[e, 0] = d0[e, 0] + t * (step[e + 1, 0] - step[e, 0] - x * step[e, 4])
        d[e, 1] = d0[e, 1] + t * (step[e + 1, 1] - step[e, 1] + x * step[e, 3])
        for k in range(2, 6):
            d[e, k] = d0[e, k] + t * (step[e + 1, k] - step[e, k])


@kernel
def energy_at(given: BeamSystem, state: BeamState, room: BeamRoom) -> tuple[float, float]:
    """``evaluate``, for the driver."""
    return evaluate(given.shaft, given.contacts, state, room.slopes)


@kernel
def find_step(given: BeamSystem, state: BeamState, options: Options, room: BeamRoom, shift: float, fresh: bool) -> bool:
    """Newton's step, by the factor of the stiffness in the room or, ``fresh``, a new one."""
    beam, band, step = given.shaft, room.band, room.step
    if fresh:
        least = ROUND_OFF * max(0.0, beam.band[:, 0].max())
        assemble(band, beam, given.contacts, room.slopes.hessians, max(shift, least), options.arm)
        if not factor_band(band):
            return False
    for i in range(step.shape[0]):
        for k in range(6):
            step[i, k] = 0.0 if beam.fixed[i, k] else -room.slopes.gradient[i, k]
    substitute_band(band, step.ravel())
    return True


@kernel
def residual_at(given: Rows, state: RowState, options: Options, room: RowRoom, scale: float) -> float:
    """Largest free component of the gradient over the scale [N]; moments divided by the arm."""
    gradient, worst = room.slopes.gradient, 0.0
    for i in range(gradient.shape[0]):
        for k in range(6):
            if not given.shaft.fixed[i, k]:
                worst = max(worst, abs(gradient[i, k]) / (1.0 if k < 3 else options.arm))
    return worst / scale if scale > 0.0 else worst


@kernel
def slope_along(given: Rows, state: RowState, room: RowRoom) -> float:
    """Slope of the energy along the step."""
    gradient, step, total = room.slopes.gradient, room.step, 0.0
    for i in range(step.shape[0]):
        for k in range(6):
            if not given.shaft.fixed[i, k]:
                total += gradient[i, k] * step[i, k]
    return total


@kernel
def reach_of(given: BeamSystem, room: BeamRoom) -> float:
    """Largest motion [m] of a flank by the step."""
    return flank_reach(given.contacts, room.step.ravel())


@kernel
def keep(state: BeamState, room: BeamRoom) -> None:
    """Note where the step begins."""
    room.q0[:], room.d0[:] = state.q[0], state.d


@kernel
def move(given: BeamSystem, state: BeamState, room: BeamRoom, t: float) -> None:
    """State t steps from where the step begins."""
    advance(state.q, state.d, given.shaft.lengths, room.q0, room.d0, room.step, t)


@kernel
def finish(given: Rows, state: RowState, room: RowRoom) -> None:
    """Nothing is left to find anew."""


@kernel
def least_force(given: Rows, state: RowState, options: Options) -> float:
    """Least force [N] that residuals are measured by: a screw bent by moments alone, or pushed off its last contact, has no
    force left to compare with."""
    floor, f = options.floor, np.empty(6)
    for e in range(state.d.shape[0]):
        c = given.shaft.constants[e]
        force_of(state.d[e], (c[0], c[1], c[2], c[3], c[4]), f)
        for k in range(3, 6):
            floor = max(floor, abs(f[k]) / options.arm)
    return floor


@kernel
def furthest(given: Rows, state: RowState) -> float:
    """Furthest motion [m] of a row."""
    q, moved = state.q, 0.0
    for i in range(q.shape[0]):
        moved = max(moved, q[i, 0] ** 2 + q[i, 1] ** 2 + q[i, 2] ** 2)
    return sqrt(moved)


@kernel
def unbalanced(state: RowState, scale: float) -> float:
    """Largest net force on a ball over ``scale`` [N]."""
    return ball_mismatch(state.contact, scale)


minimise: Callable[..., Outcome] = driver_of(__name__, "descent").minimise


@kernel
def room_for(state: BeamState, half_band: int) -> BeamRoom:
    """Room for an iteration."""
    n = state.q.shape[0]
    slopes = BeamSlopes(np.empty((n, 6)), np.zeros((state.contact.shape[0], 4, 4)))
    return BeamRoom(slopes, np.empty((6 * n, half_band + 1)), np.empty((n, 6)), np.empty(6), np.empty(state.d.shape))


@kernel
def solve_beam(beam: BeamArrays, contacts: BeamContacts, state: BeamState, options: Options, history: Array) -> Outcome:
    """Minimise the energy from the given state; history (most + 1,): residual per step."""
    room = room_for(state, beam.band.shape[1] - 1)
    return minimise(BeamSystem(beam, contacts), state, options, history, room)


@kernel
def linear_start(beam: BeamArrays, contacts: BeamContacts, state: BeamState, options: Options, band: Array) -> bool:
    """Start of the iteration: equilibrium of the screw on linear springs in place of contacts; band (6 n, half bandwidth +
    1): room.

    Overwrites the motions and element deformations of ``state``; False (untouched) where they cannot be found. No flank
    goes further than the largest ball's radius: springs of fixed direction say nothing of contacts that must turn first, as
    those of a contact angle near zero under an axial load.
    """
    lengths, fixed, load = beam.lengths, beam.fixed, beam.load
    geometry, limit = contacts.geometry, options.furthest
    q, d = state.q, state.d
    stiffness, arm = options.stiffness, options.arm
    n, count = q.shape[0], contacts.node.shape[0]
    hessians = np.zeros((count, 4, 4))
    step = np.zeros((n, 6))
    f = np.empty(6)
    for i in range(n):
        for k in range(6):
            step[i, k] = load[i, k]
    for e in range(lengths.shape[0]):
        c = beam.constants[e]
        force_of(d[e], (c[0], c[1], c[2], c[3], c[4]), f)
        for k in range(6):
            step[e, k] += f[k]
            step[e + 1, k] -= f[k]
        step[e, 3] -= lengths[e] * f[1]
        step[e, 4] += lengths[e] * f[0]
    for i in range(count):
        for s in range(2):
            if geometry[i, s, USE] != 0.0:
                wx, wz = geometry[i, s, WX], geometry[i, s, WZ]
                size = max(geometry[i, s, SIZE], 1e-30)
                hessians[i, 2 * s, 2 * s] = stiffness * wx * wx / (size * size)
                hessians[i, 2 * s, 2 * s + 1] = stiffness * wx * wz / (size * size)
                hessians[i, 2 * s + 1, 2 * s] = hessians[i, 2 * s, 2 * s + 1]
                hessians[i, 2 * s + 1, 2 * s + 1] = stiffness * wz * wz / (size * size)
    assemble(band, beam, contacts, hessians, 1e-9 * stiffness, arm)
    for i in range(n):
        for k in range(6):
            if fixed[i, k]:
                step[i, k] = 0.0
    if not factor_band(band):
        return False
    substitute_band(band, step.ravel())
    reach = flank_reach(contacts, step.ravel())
    advance(q, d, lengths, q[0].copy(), d.copy(), step, 1.0 if reach <= limit else limit / reach)
    return True


@kernel
def start_and_solve(
    beam: BeamArrays, contacts: BeamContacts, state: BeamState, options: Options, history: Array
) -> Outcome:
    """Linear start, then Newton: one call, because handing over the arrays takes as long as evaluating the contacts."""
    room = room_for(state, beam.band.shape[1] - 1)
    linear_start(beam, contacts, state, options, room.band)
    return minimise(BeamSystem(beam, contacts), state, options, history, room)


@kernel
def flank_reach(contacts: BeamContacts, motion: Array) -> float:
    """Largest displacement [m] of a flank by the nodal motions (6 n,)."""
    m, geometry = contacts.B.shape[3], contacts.geometry
    largest, shift = 0.0, np.zeros((4, 2))
    for i in range(geometry.shape[0]):
        if m == 6:
            flank_shift(contacts, motion, i, 6, shift)
        else:
            flank_shift(contacts, motion, i, m, shift)
        for s in range(2):
            largest = max(largest, shift[s, 0] ** 2 + shift[s, 1] ** 2)
    return sqrt(largest)
