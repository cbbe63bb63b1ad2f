"""Balls between flanks of elastic bodies: forces on the flanks by their motions, and the square roots of the stiffness.

A ball has its centre and one amplitude of its own body for unknowns, eliminated inside, and every contact has parts e F and
h F^(4/3) besides Hertz's C F^(2/3). Where only two opposite flanks carry load, a ball knows only their relative motion, and
has a closed form.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array, BallContacts, BodyState

from .ball import BODY, FORCE, KN, KT, MX, MZ, settle_ball
from .contact import contact_law
from .rollers import roller_elements, roller_rows


@kernel
def flank_rows(contact: Array, local: Array, rows: Array) -> int:
    """Rows S (6, 8) with S^T S the ball's Hessian by the motions of its flanks; returns how many.

    The square roots sqrt(k) d of the contacts' stiffnesses by the flanks are orthogonalised (Householder) against those by
    centre and amplitude: no difference of large numbers.
    """
    A = np.zeros((9, 3))
    B = np.zeros((9, 8))
    n = 0
    for s in range(4):
        if contact[s, FORCE] <= 0.0:
            continue
        mx, mz = contact[s, MX], contact[s, MZ]
        for tangential in range(2):
            k = sqrt(contact[s, KN] if tangential == 0 else contact[s, KT])
            dx, dz = (mx, mz) if tangential == 0 else (-mz, mx)
            A[n, 0], A[n, 1] = k * dx, k * dz
            A[n, 2] = -k * local[s, BODY] if tangential == 0 else 0.0
            B[n, 2 * s], B[n, 2 * s + 1] = k * dx, k * dz
            n += 1
    if n == 0:
        return 0
    A[n, 2] = 1.0
    n += 1
    used = min(3, n)
    for c in range(used):
        norm = 0.0
        for i in range(c, n):
            norm += A[i, c] * A[i, c]
        norm = sqrt(norm)
        if A[c, c] > 0.0:
            norm = -norm
        A[c, c] -= norm
        size = 0.0
        for i in range(c, n):
            size += A[i, c] * A[i, c]
        if size == 0.0:
            continue
        for j in range(c + 1, 3):
            reflect(A[:, c], A[:, j], c, n, size)
        for j in range(8):
            reflect(A[:, c], B[:, j], c, n, size)
    for i in range(used, n):
        for j in range(8):
            rows[i - used, j] = B[i, j]
    return n - used


@kernel
def reflect(direction: Array, x: Array, first: int, last: int, size: float) -> None:
    """Householder reflection of x[first:last] by ``direction`` of squared length ``size``."""
    dot = 0.0
    for i in range(first, last):
        dot += direction[i] * x[i]
    dot *= 2.0 / size
    for i in range(first, last):
        x[i] -= dot * direction[i]


@kernel
def full_balls(v: Array, contacts: BallContacts, inner: Array, contact: Array, f: Array) -> tuple[float, float]:
    """Forces f (N, 8) of all balls on their flanks at motions v (N, 8); returns energy and the largest contact force.

    Fills inner (N, 3) and contact (N, 4, 5). Rollers come after the balls.
    """
    geometry, closure, local, r_ball, profile = contacts[:5]
    energy, scale, tiny = 0.0, 0.0, contacts.tiny
    balls = r_ball.shape[0]
    for i in range(balls):
        shift = v[i].reshape(4, 2)
        energy += settle_ball(inner[i], shift, geometry[i], closure[i], local[i], r_ball[i], profile[i], tiny, contact[i])
        for s in range(4):
            force = contact[i, s, FORCE]
            scale = max(scale, force)
            f[i, 2 * s] = force * contact[i, s, MX] if force > 0.0 else 0.0
            f[i, 2 * s + 1] = force * contact[i, s, MZ] if force > 0.0 else 0.0
    stored, largest = roller_elements(v[balls:], contacts.rollers, contact[balls:], f[balls:], tiny)
    return energy + stored, max(scale, largest)


@kernel
def pair_balls(v: Array, contacts: BallContacts, contact: Array, f: Array) -> tuple[float, float]:
    """As ``full_balls`` for balls between two opposite arcs a and b, v (N, 2) the motion of a less that of b.

    The ball's centre lies on the line of the arcs' centres D + v, and the interference is its nominal value plus
    |D + v| - |D|; the two contacts are one law in series. pair (N, 7): D, |D|, nominal interference, C, e and h of
    both contacts together; contact (N, 5) as one contact on flank a.
    """
    pair = contacts.pair
    energy, scale = 0.0, 0.0
    for i in range(v.shape[0]):
        dx, dz, size0 = pair[i, 0], pair[i, 1], pair[i, 2]
        vx, vz = v[i, 0], v[i, 1]
        x, z = dx + vx, dz + vz
        size = sqrt(x * x + z * z)
        contact[i, FORCE] = 0.0
        f[i, 0], f[i, 1] = 0.0, 0.0
        if size <= 1e-30:
            continue
        delta = pair[i, 3] + (vx * (dx + x) + vz * (dz + z)) / (size + size0)
        contact[i, MX], contact[i, MZ] = -x / size, -z / size
        if delta > 0.0:
            force, slope, work = contact_law(delta, pair[i, 4], pair[i, 5], pair[i, 6])
            if force > contacts.tiny:
                energy += work
                scale = max(scale, force)
                contact[i, FORCE], contact[i, KN], contact[i, KT] = force, slope, force / size
                f[i, 0], f[i, 1] = force * contact[i, MX], force * contact[i, MZ]
    return energy, scale


@kernel
def evaluate_balls(v: Array, contacts: BallContacts, state: BodyState, f: Array) -> tuple[float, float]:
    """Forces of all balls at motions v, by ``pair_balls`` or ``full_balls``."""
    if v.shape[1] == 2:
        return pair_balls(v, contacts, state.contact[:, 0], f)
    return full_balls(v, contacts, state.inner, state.contact, f)


@kernel
def ball_rows(contacts: BallContacts, contact: Array, S: Array, counts: Array) -> int:
    """Rows S (N, 6 or 2, d) of all balls and rollers, and their numbers; returns the total."""
    total = 0
    d = S.shape[2]
    for i in range(S.shape[0]):
        if i >= contacts.r_ball.shape[0]:
            counts[i] = roller_rows(contact[i], S[i])
        elif d == 8:
            counts[i] = flank_rows(contact[i], contacts.local[i], S[i])
        elif contact[i, 0, FORCE] > 0.0:
            mx, mz = contact[i, 0, MX], contact[i, 0, MZ]
            kn, kt = sqrt(contact[i, 0, KN]), sqrt(contact[i, 0, KT])
            S[i, 0, 0], S[i, 0, 1] = kn * mx, kn * mz
            S[i, 1, 0], S[i, 1, 1] = -kt * mz, kt * mx
            counts[i] = 2
        else:
            counts[i] = 0
        total += counts[i]
    return total
