"""Balls between their grooves under friction: each ball's place and its motion of least dissipation, in agreement."""

import numpy as np

from rollbench.lowfi.friction.contact.records import Array, RubArrays, SeatArrays
from rollbench.lowfi.jit import kernel

from .motion import COLD, EXACT, WARM, least_dissipation

#: Force out of balance as a part of all forces; Newton steps and halvings; longest step as a part of the reach.
GOAL, STEPS, HALVINGS, FAR = 1e-13, 60, 40, 0.3
#: Force out of balance as a part of the contact forces from which on a ball did not settle.
UNSETTLED = 1e-8
#: Differences that Anderson's acceleration keeps, and rounds after which it begins anew with half the step.
KEPT, PATIENCE = 2, 40


@kernel
def contact_forces(seat: SeatArrays, k: int, x: Array, force: Array, normal: Array, length: Array) -> None:
    """Writes forces (4,) [N], normals (4, 2) and lengths (4,) [m] of ball k after shifts x (3,) of ball and screw [m]."""
    for s in range(4):
        by_screw = x[2] if s < 2 else 0.0
        across = seat.away[k, s, 0] + x[0] - by_screw * seat.axis[0]
        along = seat.away[k, s, 1] + x[1] - by_screw * seat.axis[2]
        length[s] = np.hypot(across, along)
        normal[s, 0], normal[s, 1] = across / length[s], along / length[s]
        force[s] = (max(length[s] - seat.reach[k, s], 0.0) / seat.C[k, s]) ** 1.5


@kernel
def out_of_balance(axis: Array, force: Array, normal: Array, given: Array, left: Array) -> float:
    """Writes what contact forces leave of given forces (3,) on ball and screw to left (3,) [N]; the largest of them."""
    left[:] = -given
    for s in range(4):
        left[0] += force[s] * normal[s, 0]
        left[1] += force[s] * normal[s, 1]
        if s < 2:
            left[2] -= force[s] * (normal[s, 0] * axis[0] + normal[s, 1] * axis[2])
    return float(np.max(np.abs(left)))


@kernel
def energy_of(C: Array, force: Array, given: Array, x: Array) -> float:
    """Elastic energy of four contacts less the work of the given forces [J]."""
    return float(0.4 * np.sum(C * force ** (5.0 / 3.0)) - np.sum(given * x))


@kernel
def stiffness_of(seat: SeatArrays, k: int, force: Array, normal: Array, length: Array) -> Array:
    """Second derivatives (3, 3) of the energy [N/m], with a floor for a ball that floats."""
    full, row, stiffest = np.zeros((3, 3)), np.zeros((2, 3)), 1.0
    for s in range(4):
        k_n, k_t = 1.5 * np.cbrt(force[s]) / seat.C[k, s], force[s] / length[s]
        stiffest = max(stiffest, k_n)
        row[0, 0], row[1, 1] = 1.0, 1.0
        row[0, 2] = -seat.axis[0] if s < 2 else 0.0
        row[1, 2] = -seat.axis[2] if s < 2 else 0.0
        for i in range(3):
            for j in range(3):
                one = normal[s, 0] * row[0, i] + normal[s, 1] * row[1, i]
                two = normal[s, 0] * row[0, j] + normal[s, 1] * row[1, j]
                full[i, j] += (k_n - k_t) * one * two + k_t * (row[0, i] * row[0, j] + row[1, i] * row[1, j])
    for i in range(3):
        full[i, i] += 1e-12 * stiffest
    return full


@kernel
def settle(seat: SeatArrays, k: int, given: Array, x: Array, force: Array, normal: Array) -> float:
    """Shifts x (3,) of ball k and screw [m] at which its contacts balance given forces (3,) [N]: the minimum of a convex
    energy, by Newton from x; writes forces (4,), normals (4, 2). Returns the largest force out of balance [N]."""
    length, left = np.empty(4), np.empty(3)
    contact_forces(seat, k, x, force, normal, length)
    worst = out_of_balance(seat.axis, force, normal, given, left)
    for _ in range(STEPS):
        if worst <= GOAL * (np.sum(force) + np.sum(np.abs(given))):
            break
        step = -np.linalg.solve(stiffness_of(seat, k, force, normal, length), left)
        scale = min(1.0, FAR * np.min(seat.reach[k]) / max(np.max(np.abs(step)), 1e-300))
        energy, slope = energy_of(seat.C[k], force, given, x), np.sum(left * step)
        before, falls = worst, False
        for _ in range(HALVINGS):
            trial = x + scale * step
            contact_forces(seat, k, trial, force, normal, length)
            worst = out_of_balance(seat.axis, force, normal, given, left)
            falls = energy_of(seat.C[k], force, given, trial) <= energy + 1e-4 * scale * slope or worst < 0.5 * before
            if falls:
                break
            scale *= 0.5
        if not falls:  # round-off: stay
            contact_forces(seat, k, x, force, normal, length)
            return out_of_balance(seat.axis, force, normal, given, left)
        x[:] = trial
    return worst


@kernel
def rub(rubs: RubArrays, k: int, force: Array, normal: Array, shape: Array, maps: Array, drives: Array) -> None:
    """Writes what friction sees of the contacts of ball k: shape (4, 3), maps (4, 3, 4), drives (4, 3), x along the long
    semi-axis; see ``HelicalMotion.maps``."""
    turns, size, least = rubs.turns, rubs.radius[k], max(1e-9 * np.max(force), 1e-30)
    for s in range(4):
        cube = np.cbrt(max(force[s], least))
        shape[s, 0], shape[s, 1], shape[s, 2] = (
            rubs.axes[k, s, 0] * cube,
            rubs.axes[k, s, 1] * cube,
            rubs.part[s] * force[s],
        )
        for j in range(4):
            across = size * turns[j, 1]
            along = size * (turns[j, 2] * normal[s, 0] - turns[j, 0] * normal[s, 1])
            along += rubs.rate if j == 0 else 0.0
            maps[s, 0, j], maps[s, 1, j] = (across, along) if rubs.across[k, s] > 0.0 else (along, -across)
            maps[s, 2, j] = -(normal[s, 0] * turns[j, 0] + normal[s, 1] * turns[j, 2])
        for r in range(3):
            drives[s, r] = -rubs.body[s] * maps[s, r, 0]


@kernel
def friction_on(rubs: RubArrays, k: int, axis: Array, normal: Array, forces: Array, answer: Array) -> None:
    """Writes friction on ball k along x3, z3 and on the screw along its axis [N] to answer (3,)."""
    answer[:] = 0.0
    for s in range(4):
        turned = rubs.across[k, s] == 0.0
        across = rubs.top * (forces[s, 1] if turned else -forces[s, 0])
        along = -rubs.top * (forces[s, 0] if turned else forces[s, 1])
        answer[0] += across * normal[s, 1]
        answer[1] -= across * normal[s, 0]
        if s < 2:
            answer[2] -= across * (normal[s, 1] * axis[0] - normal[s, 0] * axis[2]) + along * axis[1]


@kernel
def accelerated(x: Array, g: Array, rounds: int, kept: int, xs: Array, rs: Array) -> int:
    """Anderson's next iterate of x = g(x), x (3,) overwritten; xs, rs (KEPT + 1, 3): the last places and changes, of which
    ``kept`` are. Returns how many are kept."""
    if rounds % PATIENCE == 0:
        kept = 0
    part = 0.5 ** (rounds // PATIENCE)
    if kept > KEPT:
        kept = KEPT
        for i in range(KEPT):
            xs[i], rs[i] = xs[i + 1], rs[i + 1]
    xs[kept], rs[kept] = x, g - x
    change = part * rs[kept]
    if kept > 0:
        columns = np.ascontiguousarray((rs[1 : kept + 1] - rs[:kept]).T)
        share = np.linalg.lstsq(columns, rs[kept].copy(), 1e-8)[0]
        for i in range(kept):
            change = change - share[i] * (xs[i + 1] - xs[i] + part * (rs[i + 1] - rs[i]))
    x += change
    return kept + 1


@kernel
def feed_back_many(
    seat: SeatArrays,
    rubs: RubArrays,
    near: bool,
    goal: float,
    most: int,
    force: Array,
    normal: Array,
    guess: Array,
    q: Array,
    forces: Array,
    rest: Array,
    outcome: Array,
) -> int:
    """Place and friction of N balls in agreement, each for itself, to ``goal`` of its contact forces in ``most`` rounds.

    force (N, 4), normal (N, 4, 2): contacts without friction, overwritten; guess (N, 3): what friction pushes balls and
    screw with [N], begun with if ``near``; q (N, 4): motions, begun with where they are numbers. Writes forces (N, 4, 3),
    rest (N, 4) as ``least_dissipation_many``, outcome (N, 3): its status and force out of balance, and 1 where a ball
    did not settle. Returns the most rounds of a ball.
    """
    shape, maps, drives = np.empty((4, 3)), np.empty((4, 3, 4)), np.empty((4, 3))
    still, answer, none, bounds = np.empty(3), np.empty(3), np.zeros(4), np.empty(2)
    xs, rs, cold, warm = np.empty((KEPT + 1, 3)), np.empty((KEPT + 1, 3)), bool(np.bool_(False)), bool(np.bool_(True))
    longest = 0
    for k in range(q.shape[0]):
        given, x, kept, failed, rounds = np.zeros(3), np.zeros(3), 0, False, 0
        bare = np.sum(force[k])
        out_of_balance(seat.axis, force[k], normal[k], given, still)
        if near:
            settle(seat, k, still + guess[k], x, force[k], normal[k])
        while True:
            rub(rubs, k, force[k], normal[k], shape, maps, drives)
            status, left = -1, 0.0
            if not np.isnan(q[k, 0]):
                status, left, _ = least_dissipation(shape, maps, drives, none, warm, WARM, q[k], forces[k], rest[k], bounds)
            if status != EXACT:
                status, left, _ = least_dissipation(shape, maps, drives, none, cold, COLD, q[k], forces[k], rest[k], bounds)
            friction_on(rubs, k, seat.axis, normal[k], forces[k], answer)
            agreed = np.max(np.abs(answer - guess[k])) <= goal * np.sum(force[k]) and not failed
            if agreed or rounds == most:
                break
            kept = accelerated(guess[k], answer, rounds, kept, xs, rs)
            rounds += 1
            off = settle(seat, k, still + guess[k], x, force[k], normal[k])
            failed = off > UNSETTLED * max(np.sum(force[k]), bare)
        outcome[k, 0], outcome[k, 1], outcome[k, 2] = status, left, 1.0 if failed else 0.0
        longest = max(longest, rounds)
    return longest
