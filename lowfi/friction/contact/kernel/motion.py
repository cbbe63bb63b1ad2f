"""Motion of least dissipation of a body on elliptical contacts, some of which may stick.

The unknown is the motion q (n,) of the body. Contact i has (vx, vz, spin) = ``maps[i] @ q + drives[i]`` and the friction
bound strength_i = mu F. The convex function sum_i strength_i D_i(v_i; speed) - push . q is minimised by Newton's method for
a sequence of decreasing regularising speeds. Then contacts that nearly stand still are set to rest exactly.

The functions of this module have these arguments in common. m: number of contacts, n: number of unknowns. shape (m, 3):
semi-axes a, b [m] and friction bound mu F [N] of the contacts; maps (m, 3, n): motion vx, vz [m/s], spin [rad/s] of the
contacts by unit of each unknown; drives (m, 3): motion of the contacts at q = 0, which the drive imposes; push (n,):
generalised forces other than friction [W per unit of the unknown]; units (n,): surface speed per unit of each unknown
(`surface_speed_per_unknown`); speed: regularising speed [m/s].
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.jit import kernel

from .dissipation import dissipation


@kernel
def evaluate_dissipation(
    shape: Array, maps: Array, drives: Array, push: Array, speed: float, q: Array, grad: Array, hess: Array
) -> tuple[float, float]:
    """Return friction power less power of other forces [W] at a motion q, then the excess of friction power over loss [W].

    The excess, which is due to regularisation, is the sum over the contacts of mu F speed dD/dspeed, where D is the
    dissipated power divided by the friction bound mu F (`dissipation`). q (n,): motion of the body; grad (n,), hess (n,
    n): gradient by q and lower triangle of the Hessian, which are written. shape (m, 3): semi-axes a, b [m] and
    friction bound mu F [N] of m contacts; maps (m, 3, n): motion of the contacts per unit of each of n unknowns,
    sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s]; drives (m, 3): motion of the contacts at q = 0,
    which the drive imposes; push (n,): generalised forces other than friction; speed: regularising speed [m/s].
    """
    n = q.shape[0]
    value, excess = 0.0, 0.0
    for j in range(n):
        value -= push[j] * q[j]
        grad[j] = -push[j]
        for k in range(n):
            hess[j, k] = 0.0
    for i in range(shape.shape[0]):
        f = shape[i, 2]
        if f == 0.0:
            continue
        vx, vz, spin = drives[i, 0], drives[i, 1], drives[i, 2]
        for j in range(n):
            vx += maps[i, 0, j] * q[j]
            vz += maps[i, 1, j] * q[j]
            spin += maps[i, 2, j] * q[j]
        d, d_x, d_z, d_s, d_e, xx, xz, zz, xs, zs, ss = dissipation(shape[i, 0], shape[i, 1], vx, vz, spin, speed)
        value += f * d
        excess += f * speed * d_e
        for j in range(n):
            mx, mz, ms = f * maps[i, 0, j], f * maps[i, 1, j], f * maps[i, 2, j]
            grad[j] += mx * d_x + mz * d_z + ms * d_s
            h_x, h_z, h_s = mx * xx + mz * xz + ms * xs, mx * xz + mz * zz + ms * zs, mx * xs + mz * zs + ms * ss
            for k in range(j + 1):
                hess[j, k] += h_x * maps[i, 0, k] + h_z * maps[i, 1, k] + h_s * maps[i, 2, k]
    return value, excess


@kernel
def write_motion_newton_step(hess: Array, grad: Array, units: Array, step: Array) -> None:
    """Write Newton's step of the unknown motion to ``step`` (n,), by a Cholesky factorisation with pivots bounded below.

    hess (n, n): Hessian of the dissipation, of which the lower triangle is overwritten by its factors; grad (n,):
    gradient; units (n,): surface speed per unit of each unknown (`surface_speed_per_unknown`).
    """
    n = grad.shape[0]
    top = 0.0
    for j in range(n):
        top = max(top, hess[j, j] / (units[j] * units[j]))
    for j in range(n):
        floor = 1e-13 * top * units[j] * units[j]
        pivot = hess[j, j] + floor
        for k in range(j):
            pivot -= hess[j, k] * hess[j, k]
        hess[j, j] = sqrt(max(pivot, floor, 1e-300))
        for i in range(j + 1, n):
            for k in range(j):
                hess[i, j] -= hess[i, k] * hess[j, k]
            hess[i, j] /= hess[j, j]
    for j in range(n):
        step[j] = -grad[j]
        for k in range(j):
            step[j] -= hess[j, k] * step[k]
        step[j] /= hess[j, j]
    for j in range(n - 1, -1, -1):
        for k in range(j + 1, n):
            step[j] -= hess[k, j] * step[k]
        step[j] /= hess[j, j]


@kernel
def surface_speed_per_unknown(shape: Array, maps: Array) -> Array:
    """Return the surface speed of the loaded contacts per unit of each of n unknown velocities of a body ``(n,)``.

    The surface speed is the root of the sum of squares of vx, vz and a times spin over the contacts; 1 for an unknown
    that moves no loaded contact. shape (m, 3): semi-axes a >= b [m] and friction bound [N] of m contacts; maps (m, 3,
    n): motion of the contacts per unit of each unknown, sliding vx, vz along the semi-axes a, b, and spin.
    """
    n = maps.shape[2]
    units = np.empty(n)
    for j in range(n):
        total = 0.0
        for i in range(shape.shape[0]):
            if shape[i, 2] > 0.0:
                turn = shape[i, 0] * maps[i, 2, j]
                total += maps[i, 0, j] * maps[i, 0, j] + maps[i, 1, j] * maps[i, 1, j] + turn * turn
        units[j] = sqrt(total) if total > 0.0 else 1.0
    return units


@kernel
def largest_imbalance(grad: Array, units: Array) -> float:
    """Return the largest unbalanced force on a body [N], from the gradient ``grad`` of its dissipation.

    grad (n,): gradient of the dissipation by the n unknown velocities; units (n,): surface speed per unit of each
    unknown (`surface_speed_per_unknown`), by which the entries of grad are divided.
    """
    worst = 0.0
    for j in range(grad.shape[0]):
        worst = max(worst, abs(grad[j]) / units[j])
    return worst


@kernel
def minimise_dissipation(
    shape: Array,
    maps: Array,
    drives: Array,
    push: Array,
    speed: float,
    q: Array,
    tolerance: float,
    limit: int,
    reach: float,
) -> tuple[float, float, float, int]:
    """Find the motion q of a body with least dissipation at one regularising speed of friction, by Newton's method.

    q (n,): motion from which the search begins, overwritten by the result. shape, maps, drives, push, speed: contacts,
    kinematics, other forces and regularising speed, arguments of `evaluate_dissipation`. The iteration ends if the
    largest unbalanced force is below ``tolerance`` times the sum of the friction bounds, after ``limit`` steps, or at a
    surface speed above ``reach`` [m/s], where the other forces exceed friction. Returns the friction power less the
    power of other forces [W], its excess over the friction loss [W], the largest unbalanced force [N] and the number of
    steps.
    """
    n = q.shape[0]
    grad, step, trial, next_grad = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    hess, next_hess = np.empty((n, n)), np.empty((n, n))
    units = surface_speed_per_unknown(shape, maps)
    goal = tolerance * np.sum(shape[:, 2])
    value, excess = evaluate_dissipation(shape, maps, drives, push, speed, q, grad, hess)
    count = 0
    while count < limit and largest_imbalance(grad, units) > goal and np.max(np.abs(q) * units) <= reach:
        count += 1
        write_motion_newton_step(hess, grad, units, step)
        slope = 0.0
        for j in range(n):
            slope += grad[j] * step[j]
        length, better = 1.0, False
        for _ in range(40):
            for j in range(n):
                trial[j] = q[j] + length * step[j]
            new, new_excess = evaluate_dissipation(shape, maps, drives, push, speed, trial, next_grad, next_hess)
            small = -slope <= 1e-13 * abs(value)  # the change of the value is round-off: compare gradients
            if small and largest_imbalance(next_grad, units) < 0.5 * largest_imbalance(grad, units):
                better = True
                break
            if not small and new <= value + 1e-4 * length * slope:
                better = True
                break
            length *= 0.5
        if not better:
            break
        value, excess = new, new_excess
        q[:] = trial
        grad[:] = next_grad
        hess[:] = next_hess
    return value, excess, largest_imbalance(grad, units), count


@kernel
def motion_nearest_to_rolling(shape: Array, maps: Array, drives: Array) -> Array:
    """Return the motion q (n,) of a body that is nearest to pure rolling in its m contacts.

    The sum of squared surface speeds of the contacts, weighted by their friction bounds, is least. This motion is the
    solution of a linear system, and unique except for motions without surface speed. shape (m, 3): semi-axes a, b [m]
    and friction bound mu F [N] of m contacts; maps (m, 3, n): motion of the contacts per unit of each of n unknowns,
    sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s]; drives (m, 3): motion of the contacts at q = 0,
    which the drive imposes.
    """
    n = maps.shape[2]
    grad, hess, q = np.zeros(n), np.zeros((n, n)), np.empty(n)
    for i in range(shape.shape[0]):
        for r in range(3):
            w = shape[i, 2] * (shape[i, 0] * shape[i, 0] if r == 2 else 1.0)
            for j in range(n):
                grad[j] += w * maps[i, r, j] * drives[i, r]
                for k in range(j + 1):
                    hess[j, k] += w * maps[i, r, j] * maps[i, r, k]
    write_motion_newton_step(hess, grad, surface_speed_per_unknown(shape, maps), q)
    return q


@kernel
def largest_imposed_speed(shape: Array, drives: Array) -> float:
    """Return the largest surface speed [m/s] that the drive imposes on a loaded contact of a body at rest.

    shape (m, 3): semi-axes a, b [m] and friction bound [N] of m contacts; drives (m, 3): motion that the drive imposes
    on them, sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s].
    """
    top = 0.0
    for i in range(shape.shape[0]):
        if shape[i, 2] > 0.0:
            turn = shape[i, 0] * drives[i, 2]
            top = max(top, drives[i, 0] * drives[i, 0] + drives[i, 1] * drives[i, 1] + turn * turn)
    return sqrt(top)


@kernel
def contact_speeds(shape: Array, maps: Array, drives: Array, q: Array) -> tuple[Array, Array]:
    """Return sliding and spin of m contacts (m, 3) at the body's motion q (n,), then their surface speeds (m,) [m/s].

    Sliding vx, vz [m/s] is along the semi-axes a, b; spin is in rad/s; a surface speed is the root of vx^2 + vz^2 + (a
    spin)^2. shape (m, 3): semi-axes a, b [m] and friction bound mu F [N] of m contacts; maps (m, 3, n): sliding and
    spin of the contacts per unit of each of n unknowns; drives (m, 3): motion of the contacts at q = 0, which the drive
    imposes.
    """
    m, n = shape.shape[0], q.shape[0]
    motion, size = drives.copy(), np.empty(m)
    for i in range(m):
        for r in range(3):
            for j in range(n):
                motion[i, r] += maps[i, r, j] * q[j]
        turn = shape[i, 0] * motion[i, 2]
        size[i] = sqrt(motion[i, 0] * motion[i, 0] + motion[i, 1] * motion[i, 1] + turn * turn)
    return motion, size


#: Status of a solution: each contact rests or slips exactly; friction is regularised, because a contact is on the verge of
#: slip; every contact rests, because there is neither drive nor force.
EXACT, REGULARISED, AT_REST = 0, 1, 2

#: Where a search starts: the motion nearest to pure rolling, the caller's motion, or the caller's motion if it is near the
#: minimum.
ROLLING, GIVEN, NEAR = 0, 1, 2


@kernel
def write_friction_gradients(shape: Array, motion: Array, speed: float, forces: Array) -> None:
    """Write the negative friction force and moment of each of m contacts to forces (m, 3): the gradient of the dissipation.

    shape (m, 3): semi-axes a, b [m] and friction bound [N]; motion (m, 3): sliding vx, vz along the semi-axes a, b
    [m/s] and spin [rad/s] of the contacts; speed: regularising speed [m/s]; forces: components along the semi-axes [N]
    and moment about the normal [N m].
    """
    for i in range(shape.shape[0]):
        f = shape[i, 2]
        d = dissipation(shape[i, 0], shape[i, 1], motion[i, 0], motion[i, 1], motion[i, 2], speed)
        forces[i, 0], forces[i, 1], forces[i, 2] = f * d.by_vx, f * d.by_vz, f * d.by_spin


@kernel
def contact_can_stick(shape: Array, force: Array) -> bool:
    """Return whether friction in one contact can transmit a given force and moment without sliding.

    shape (1, 3): semi-axes [m] and friction bound [N]; force (3,): components along the semi-axes [N] and moment about
    the normal [N m]. The contact can stick if the dissipated power D(v), regularised with a speed of 1 m/s, less the
    power force . v has a minimum over the sliding and spin v: the force is then a gradient of D and lies inside the
    limit surface of friction.
    """
    maps, q = np.eye(3).reshape(1, 3, 3), np.zeros(3)
    _, _, left, _ = minimise_dissipation(shape, maps, np.zeros((1, 3)), force, 1.0, q, 1e-9, int(np.int64(100)), 1e9)
    return bool(left <= 1e-6 * shape[0, 2])


@kernel
def minimise_over_free_motions(
    slipping: Array, maps: Array, drives: Array, push: Array, basis: Array, q: Array, reach: float
) -> int:
    """Minimise the dissipation over those motions of a body at which its sticking contacts remain at rest.

    The motion q (n,) is overwritten by q plus the best linear combination of the rows of basis (f, n), the f motions at
    which these contacts remain at rest. Friction is not regularised. slipping (m, 3): semi-axes [m] and friction bounds
    [N] of the contacts, the bounds of sticking contacts being zero; maps, drives, push: as in `evaluate_dissipation`;
    reach: surface speed [m/s] at which the search is given up. Returns the number of Newton steps.
    """
    reduced = np.empty((maps.shape[0], 3, basis.shape[0]))
    for i in range(maps.shape[0]):
        reduced[i] = maps[i] @ basis.T
    y, (motion, _) = np.zeros(basis.shape[0]), contact_speeds(slipping, maps, drives, q)
    _, _, _, count = minimise_dissipation(slipping, reduced, motion, basis @ push, 0.0, y, 1e-13, int(np.int64(60)), reach)
    q += y @ basis
    return count


@kernel
def write_sticking_reactions(
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
    """Write the reactions of sticking contacts that balance the body, and the friction of slipping ones, to forces (m, 3).

    All entries have the opposite sign of the friction on the body [N, N m]. slipping (m, 3): semi-axes and friction
    bounds of the contacts, the bounds of sticking ones being zero; maps, drives, push, q: as in `evaluate_dissipation`;
    resting (k,): numbers of the sticking contacts, whose previous reactions are read from ``forces``; units: see
    `surface_speed_per_unknown`; inverse (n, 3k): see `kinematic_inverse_and_null_space`. Returns the largest unbalanced
    force that remains [N].
    """
    n = maps.shape[2]
    out, hess, held = np.zeros(n), np.zeros((n, n)), forces[resting]
    evaluate_dissipation(slipping, maps, drives, push, 0.0, q, out, hess)
    write_friction_gradients(slipping, contact_speeds(slipping, maps, drives, q)[0], 0.0, forces)
    for k in range(resting.shape[0]):
        out += held[k] @ maps[resting[k]]
    change = -(out / units) @ inverse
    for k in range(resting.shape[0]):
        i = resting[k]
        forces[i] = held[k] + change[3 * k : 3 * k + 3] * np.array([1.0, 1.0, slipping[i, 0]])
    out[:] = -push
    for i in range(maps.shape[0]):
        out += forces[i] @ maps[i]
    return largest_imbalance(out, units)


@kernel
def kinematic_inverse_and_null_space(rows: Array, units: Array) -> tuple[Array, Array]:
    """Return the pseudo-inverse (n, 3k), then the null space (f, n), of the conditions that k contacts of a body stick.

    rows (3k, n): surface speeds of these contacts per unit of each of the n unknown velocities, divided by its entry of
    ``units`` (`surface_speed_per_unknown`). The rows of the null space are the f motions of the body, in its unknowns,
    at which these contacts remain at rest.
    """
    n = rows.shape[1]
    left, size, right = np.linalg.svd(rows, True)
    rank = 0
    while rank < min(n, rows.shape[0]) and size[rank] > 1e-9 * size[0]:
        rank += 1
    inverse = np.ascontiguousarray(right[:rank].T / size[:rank]) @ np.ascontiguousarray(left[:, :rank].T)
    return inverse, np.ascontiguousarray(right[rank:] / units)


@kernel
def set_slow_contacts_to_rest(
    shape: Array, maps: Array, drives: Array, push: Array, q: Array, forces: Array, rest: Array, still: float
) -> tuple[bool, float, int]:
    """Let contacts slower than ``still`` [m/s] stick, and minimise the dissipation of the other contacts.

    shape, maps, drives, push: as in `evaluate_dissipation`. Overwrites the motion q (n,), the negative friction and
    reactions forces (m, 3) [N, N m], and rest (m,), which becomes 1 for sticking contacts and 0 for slipping ones.
    Returns whether the result is the least dissipation (sticking is kinematically possible, and every reaction lies
    inside its limit surface), the largest unbalanced force [N], and the number of steps.
    """
    n, units, count = maps.shape[2], surface_speed_per_unknown(shape, maps), 0
    (motion, size), slipping = contact_speeds(shape, maps, drives, q), shape.copy()
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
        inverse, basis = kinematic_inverse_and_null_space(rows, units)
        q -= inverse @ seen / units
    if basis.shape[0] > 0:
        count = minimise_over_free_motions(slipping, maps, drives, push, basis, q, 1e9 * still)
    balance = write_sticking_reactions(slipping, maps, drives, push, resting, units, inverse, q, forces)
    _, size = contact_speeds(shape, maps, drives, q)
    good = balance <= 1e-9 * np.sum(shape[:, 2])
    for i in resting:
        good = good and size[i] <= 1e-6 * still and contact_can_stick(shape[i : i + 1], forces[i])
    return bool(good), balance, count


@kernel
def least_dissipation(
    shape: Array, maps: Array, drives: Array, push: Array, start: int, q: Array, forces: Array, rest: Array, bounds: Array
) -> tuple[int, float, int]:
    """Compute the motion of least dissipation of one body on m contacts with given normal loads.

    Written are the motion q (n,), the negative friction and reactions forces (m, 3) [N, N m], rest (m,), which is 1 for
    sticking contacts and 0 for slipping ones, and bounds (2,): lower and upper bound [W] of the least dissipation less
    the power of ``push``, by joint convexity in motion and speed. shape, maps, drives, push: contacts, kinematics and
    other forces, see `evaluate_dissipation`. The regularising speed decreases from 0.1 to 1e-6 times the drive's speed
    (to 1e-10 if a contact is on the verge of slip); each minimum is the start of the next. Then contacts that stand
    still are set to rest. start: ``ROLLING``, ``GIVEN`` (start from q), or ``NEAR`` (start from q with the speed 1e-6
    at once, and from ``ROLLING`` if this fails). Returns the status (``EXACT``, ``REGULARISED``, ``AT_REST``), the
    largest unbalanced force [N], and the number of steps.
    """
    top = largest_imposed_speed(shape, drives)
    if top == 0.0 and np.sum(np.abs(push)) == 0.0:
        q[:] = 0.0
        forces[:] = 0.0
        rest[:] = 1.0
        bounds[:] = 0.0
        return AT_REST, 0.0, 0
    if top == 0.0:
        top = 1.0  # [m/s]: only ``push`` acts, and no other speed is known
    if start == ROLLING:
        q[:] = motion_nearest_to_rolling(shape, maps, drives)
    n = q.shape[0]
    grad, hess = np.empty(n), np.empty((n, n))
    ratio, count, balance, near = 0.1, 0, 0.0, start == NEAR
    if near:
        ratio = 1e-6
    while ratio > 1e-10:
        at_end = ratio <= 1.0001e-6
        goal = 1e-11 if at_end else 1e-3
        limit = int(np.int64(20 if near else 200))
        value, excess, balance, steps = minimise_dissipation(
            shape, maps, drives, push, ratio * top, q, goal, limit, 1e9 * top
        )
        count += steps
        if near and balance > goal * np.sum(shape[:, 2]):
            ratio, near = 0.1, False
            q[:] = motion_nearest_to_rolling(shape, maps, drives)
            continue
        near = False
        if at_end:
            bounds[0] = value - excess
            write_friction_gradients(shape, contact_speeds(shape, maps, drives, q)[0], ratio * top, forces)
            exact_q, exact_forces = q.copy(), forces.copy()
            good, left, steps = set_slow_contacts_to_rest(
                shape, maps, drives, push, exact_q, exact_forces, rest, 100.0 * ratio * top
            )
            count += steps
            if good:
                q[:] = exact_q
                forces[:] = exact_forces
                bounds[1], _ = evaluate_dissipation(shape, maps, drives, push, 0.0, q, grad, hess)
                return EXACT, left, count
        ratio *= 0.1
    rest[:] = 0.0
    bounds[1], _ = evaluate_dissipation(shape, maps, drives, push, 0.0, q, grad, hess)
    return REGULARISED, balance, count


@kernel
def least_dissipation_of_bodies(
    shape: Array, maps: Array, drives: Array, q: Array, forces: Array, rest: Array, outcome: Array
) -> None:
    """Compute the motions of least dissipation of N independent bodies (balls) on which no forces other than friction act.

    shape (N, m, 3), maps (N, m, 3, n), drives (N, m, 3) have the arguments of `least_dissipation` for each body; q (N,
    n): motions in a similar state to begin from, nan if none is known. Writes q, forces (N, m, 3) and rest (N, m) as
    `least_dissipation`, and outcome (N, 2): the status of each body and the largest unbalanced force [N].
    """
    none, bounds = np.zeros(q.shape[1]), np.empty(2)
    for k in range(q.shape[0]):
        start = ROLLING if np.isnan(q[k, 0]) else NEAR
        status, left, _ = least_dissipation(shape[k], maps[k], drives[k], none, start, q[k], forces[k], rest[k], bounds)
        outcome[k, 0], outcome[k, 1] = status, left
