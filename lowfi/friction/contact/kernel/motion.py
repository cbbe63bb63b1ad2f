"""Motion of least dissipation with contacts at rest: a falling regularising speed, then rest imposed exactly."""

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.jit import kernel

from .dissipation import dissipation
from .minimum import column_units, descend, drive_speed, evaluate, residual, rolling_start, speeds_at

#: Status: rest and slip exact; regularised only (a contact on the verge of slip); nothing drives the body.
EXACT, REGULARISED, AT_REST = 0, 1, 2
#: What a search begins from: rolling as nearly as possible, a motion given, or one that is near the minimum.
ROLLING, GIVEN, NEAR = 0, 1, 2


@kernel
def friction_of(shape: Array, motion: Array, speed: float, forces: Array) -> None:
    """Writes strength times the derivative of D by (vx, vz, spin) to forces (m, 3): friction is its opposite."""
    for i in range(shape.shape[0]):
        f = shape[i, 2]
        d = dissipation(shape[i, 0], shape[i, 1], motion[i, 0], motion[i, 1], motion[i, 2], speed)
        forces[i, 0], forces[i, 1], forces[i, 2] = f * d.by_vx, f * d.by_vz, f * d.by_spin


@kernel
def holds(shape: Array, force: Array) -> bool:
    """Whether one contact, shape (1, 3), holds the generalised force (3,) at rest.

    It does where D(v; 1 m/s) - force . v has a minimum: the force is then a gradient of D, inside the limit surface.
    """
    maps, q = np.eye(3).reshape(1, 3, 3), np.zeros(3)
    _, _, left, _ = descend(shape, maps, np.zeros((1, 3)), force, 1.0, q, 1e-9, int(np.int64(100)), 1e9)
    return bool(left <= 1e-6 * shape[0, 2])


@kernel
def free_motion(slipping: Array, maps: Array, drives: Array, push: Array, basis: Array, q: Array, reach: float) -> int:
    """Minimise without regularisation over q + span of the rows of ``basis`` (f, n); overwrites q (n,); steps."""
    reduced = np.empty((maps.shape[0], 3, basis.shape[0]))
    for i in range(maps.shape[0]):
        reduced[i] = maps[i] @ basis.T
    y, (motion, _) = np.zeros(basis.shape[0]), speeds_at(slipping, maps, drives, q)
    _, _, _, count = descend(slipping, reduced, motion, basis @ push, 0.0, y, 1e-13, int(np.int64(60)), reach)
    q += y @ basis
    return count


@kernel
def reactions(
    slipping: Array,
    maps: Array,
    drives: Array,
    push: Array,
    resting: Array,
    units: Array,
    inverse: Array,
    q: Array,
    forces: Array,
) -> float:
    """Completes ``forces`` by what rest needs for balance; inverse (n, 3k): pseudo-inverse of the rows of the k contacts
    at rest, numbers ``resting``.

    Where the reactions are not unique they are those nearest to the forces given. Returns what stays out of balance.
    """
    n = maps.shape[2]
    out, hess, held = np.zeros(n), np.zeros((n, n)), forces[resting]
    evaluate(slipping, maps, drives, push, 0.0, q, out, hess)
    friction_of(slipping, speeds_at(slipping, maps, drives, q)[0], 0.0, forces)
    for k in range(resting.shape[0]):
        out += held[k] @ maps[resting[k]]
    change = -(out / units) @ inverse
    for k in range(resting.shape[0]):
        i = resting[k]
        forces[i] = held[k] + change[3 * k : 3 * k + 3] * np.array([1.0, 1.0, slipping[i, 0]])
    out[:] = -push
    for i in range(maps.shape[0]):
        out += forces[i] @ maps[i]
    return residual(out, units)


@kernel
def rest_space(rows: Array, units: Array) -> tuple[Array, Array]:
    """Pseudo-inverse (n, 3k) of the resting rows (3k, n), and the motions (f, n) that leave those contacts at rest."""
    n = rows.shape[1]
    left, size, right = np.linalg.svd(rows, True)
    rank = 0
    while rank < min(n, rows.shape[0]) and size[rank] > 1e-9 * size[0]:
        rank += 1
    inverse = np.ascontiguousarray(right[:rank].T / size[:rank]) @ np.ascontiguousarray(left[:, :rank].T)
    return inverse, np.ascontiguousarray(right[rank:] / units)


@kernel
def lock(
    shape: Array, maps: Array, drives: Array, push: Array, q: Array, forces: Array, rest: Array, still: float
) -> tuple[bool, float, int]:
    """Impose rest on contacts slower than ``still`` [m/s] and minimise over the others; overwrites q, forces, rest.

    Returns whether that is the least dissipation (rest possible, every reaction inside its limit surface), the largest
    force out of balance [N], and the steps.
    """
    n, units, count = maps.shape[2], column_units(shape, maps), 0
    (motion, size), slipping = speeds_at(shape, maps, drives, q), shape.copy()
    rest[:] = np.where((shape[:, 2] > 0.0) & (size < still), 1.0, 0.0)
    slipping[:, 2] *= 1.0 - rest
    resting = np.flatnonzero(rest)
    inverse, basis = np.zeros((n, 0)), np.eye(n)
    if resting.size > 0:
        rows, seen = np.empty((3 * resting.size, n)), np.empty(3 * resting.size)
        for k in range(3 * resting.size):
            i, r = resting[k // 3], k % 3
            unit = shape[i, 0] if r == 2 else 1.0
            rows[k], seen[k] = unit * maps[i, r] / units, unit * motion[i, r]
        inverse, basis = rest_space(rows, units)
        q -= inverse @ seen / units
    if basis.shape[0] > 0:
        count = free_motion(slipping, maps, drives, push, basis, q, 1e9 * still)
    balance = reactions(slipping, maps, drives, push, resting, units, inverse, q, forces)
    _, size = speeds_at(shape, maps, drives, q)
    good = balance <= 1e-9 * np.sum(shape[:, 2])
    for i in resting:
        good = good and size[i] <= 1e-6 * still and holds(shape[i : i + 1], forces[i])
    return bool(good), balance, count


@kernel
def least_dissipation(
    shape: Array, maps: Array, drives: Array, push: Array, start: int, q: Array, forces: Array, rest: Array, bounds: Array
) -> tuple[int, float, int]:
    """Motion of least dissipation; arguments as in ``evaluate``; writes q (n,), forces (m, 3), rest (m,), bounds (2,).

    A regularising speed falls from a tenth of the drive's to 1e-6 times it (further, to 1e-10, where a contact is on
    the verge of slip), each minimum the start of the next; then contacts at rest are locked. bounds: the least
    dissipation less the work of push lies between them, by joint convexity in motion and speed. start: ``ROLLING``, or
    ``GIVEN``: q, or ``NEAR``: q, which is so near the minimum that the speed is 1e-6 at once, and ``ROLLING`` if it is not.
    Returns the status, the largest force out of balance [N], and the Newton steps.
    """
    top = drive_speed(shape, drives)
    if top == 0.0 and np.sum(np.abs(push)) == 0.0:
        q[:] = 0.0
        forces[:] = 0.0
        rest[:] = 1.0
        bounds[:] = 0.0
        return AT_REST, 0.0, 0
    if top == 0.0:
        top = 1.0  # [m/s]: nothing but push drives, and no other speed is known
    if start == ROLLING:
        q[:] = rolling_start(shape, maps, drives)
    n = q.shape[0]
    grad, hess = np.empty(n), np.empty((n, n))
    ratio, count, balance, near = 0.1, 0, 0.0, start == NEAR
    if near:
        ratio = 1e-6
    while ratio > 1e-10:
        at_end = ratio <= 1.0001e-6
        goal = 1e-11 if at_end else 1e-3
        limit = int(np.int64(20 if near else 200))
        value, excess, balance, steps = descend(shape, maps, drives, push, ratio * top, q, goal, limit, 1e9 * top)
        count += steps
        if near and balance > goal * np.sum(shape[:, 2]):
            ratio, near = 0.1, False
            q[:] = rolling_start(shape, maps, drives)
            continue
        near = False
        if at_end:
            bounds[0] = value - excess
            friction_of(shape, speeds_at(shape, maps, drives, q)[0], ratio * top, forces)
            exact_q, exact_forces = q.copy(), forces.copy()
            good, left, steps = lock(shape, maps, drives, push, exact_q, exact_forces, rest, 100.0 * ratio * top)
            count += steps
            if good:
                q[:] = exact_q
                forces[:] = exact_forces
                bounds[1], _ = evaluate(shape, maps, drives, push, 0.0, q, grad, hess)
                return EXACT, left, count
        ratio *= 0.1
    rest[:] = 0.0
    bounds[1], _ = evaluate(shape, maps, drives, push, 0.0, q, grad, hess)
    return REGULARISED, balance, count


@kernel
def least_dissipation_many(
    shape: Array, maps: Array, drives: Array, q: Array, forces: Array, rest: Array, outcome: Array
) -> None:
    """``least_dissipation`` of N bodies without push: shape (N, m, 3), maps (N, m, 3, n), drives (N, m, 3).

    q (N, n): motions of a similar state, nan where none is known. Writes q, forces (N, m, 3), rest (N, m), outcome (N, 2):
    status and largest force out of balance [N].
    """
    none, bounds = np.zeros(q.shape[1]), np.empty(2)
    for k in range(q.shape[0]):
        start = ROLLING if np.isnan(q[k, 0]) else NEAR
        status, left, _ = least_dissipation(shape[k], maps[k], drives[k], none, start, q[k], forces[k], rest[k], bounds)
        outcome[k, 0], outcome[k, 1] = status, left
