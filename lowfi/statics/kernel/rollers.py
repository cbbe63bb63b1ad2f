"""Rollers as slices of line contacts: between rows of motions, or as elements between elastic bodies.

A roller of a row between elastic bodies has four motions, stored in place of a ball's flanks SL (cone) and NL (cup):
that of the ring along the normal of the roller's middle, and its slope along the roller times the roller's length [m].
"""

from math import exp, log, sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array, AxisRollers, RollerContacts

from .ball import FORCE, KN, KT, MX, MZ
from .contact import SETTLED

#: Flanks of a ball whose places a roller's cone and cup take.
CONE, CUP = 0, 2
#: Approach of a slice over the sum of the sizes of its terms up to which only round-off closes it: it counts as open.
ROUND_OFF = 2.0**-52


@kernel
def roller_law(delta: float, g: float, s: float) -> tuple[float, float, float]:
    """Return line load q [N/m], its slope by the approach, and energy [J/m], of delta = q (g - S ln q), delta > 0.

    Beyond exp(-3) of the load at which the law bends back, far above any real one, it goes on along its tangent, so that
    the energy stays convex.
    """
    edge = exp(g / s - 4.0)
    limit = edge * (g - s * log(edge))
    rest = delta - limit
    delta = min(delta, limit)
    q = delta / g
    for _ in range(60):
        step = (q * (g - s * log(q)) - delta) / (g - s * (1.0 + log(q)))
        new = q - step
        if new <= 0.0:
            new = 0.5 * q
        change, q = abs(new - q), new
        if change <= SETTLED * q:
            break
    slope = 1.0 / (g - s * (1.0 + log(q)))
    energy = 0.5 * q * q * (g - s * (0.5 + log(q)))
    if rest > 0.0:
        energy += rest * (q + 0.5 * slope * rest)
        q += slope * rest
    return q, slope, energy


@kernel
def roller_forces(rollers: AxisRollers, q: Array, slices: Array, gradient: Array) -> tuple[float, float]:
    """Write forces and stiffnesses of all slices and add them to the gradient; return energy and largest force."""
    energy, scale = 0.0, 0.0
    for i in range(rollers.drop.shape[0]):
        delta, terms = -rollers.drop[i], abs(rollers.drop[i])
        for end in range(2):
            row = rollers.row[i, end]
            if row >= 0:
                for k in range(6):
                    moved = rollers.B[i, end, k] * q[row, k]
                    delta, terms = delta + moved, terms + abs(moved)
        slices[i, 0], slices[i, 1] = 0.0, 0.0
        if delta <= ROUND_OFF * terms:
            continue
        load, slope, stored = roller_law(delta, rollers.g[i], rollers.s[i])
        force = rollers.width[i] * load
        slices[i, 0], slices[i, 1] = force, rollers.width[i] * slope
        energy += rollers.width[i] * stored
        scale = max(scale, force)
        for end in range(2):
            row = rollers.row[i, end]
            if row >= 0:
                for k in range(6):
                    gradient[row, k] += force * rollers.B[i, end, k]
    return energy, scale


@kernel
def roller_elements(v: Array, rollers: RollerContacts, contact: Array, f: Array, tiny: float) -> tuple[float, float]:
    """Write forces f (M, 8) of the rollers on their rings at motions v (M, 8); return energy [J] and the largest force [N].

    contact (M, 4, 5): force and direction as of a ball's contacts; the stiffness by the two relative motions is in KN
    and KT of the cone's (its first row) and KN of the cup's (the last entry).
    """
    energy, scale = 0.0, 0.0
    for i in range(v.shape[0]):
        contact[i, :, FORCE] = 0.0
        f[i, :] = 0.0
        approach, tilt = v[i, 2 * CONE] - v[i, 2 * CUP], v[i, 2 * CONE + 1] - v[i, 2 * CUP + 1]
        force, moment, kff, kfm, kmm, work = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(rollers.place.shape[1]):
            x, width = rollers.place[i, k], rollers.width[i, k]
            delta = approach + tilt * x - rollers.drop[i, k]
            if delta <= 0.0 or width == 0.0:
                continue
            load, slope, stored = roller_law(delta, rollers.g[i], rollers.s[i])
            force += width * load
            moment += width * load * x
            kff += width * slope
            kfm += width * slope * x
            kmm += width * slope * x * x
            work += width * stored
        if force <= tiny:
            continue
        energy += work
        scale = max(scale, force)
        size = sqrt(force * force + moment * moment)
        for flank, sign in ((CONE, -1.0), (CUP, 1.0)):
            contact[i, flank, FORCE] = size
            contact[i, flank, MX], contact[i, flank, MZ] = sign * force / size, sign * moment / size
            f[i, 2 * flank], f[i, 2 * flank + 1] = sign * force, sign * moment
        contact[i, CONE, KN], contact[i, CONE, KT], contact[i, CUP, KN] = kff, kfm, kmm
    return energy, scale


@kernel
def roller_rows(contact: Array, rows: Array) -> int:
    """Write rows S (6, 8) with S^T S roller's stiffness by the motions of its rings (of ``contact``); return how many."""
    if contact[CONE, FORCE] <= 0.0:
        return 0
    root = sqrt(contact[CONE, KN])
    side = contact[CONE, KT] / root
    rest = sqrt(max(0.0, contact[CUP, KN] - side * side))
    rows[:2, :] = 0.0
    for flank, sign in ((CONE, 1.0), (CUP, -1.0)):
        rows[0, 2 * flank], rows[0, 2 * flank + 1] = sign * root, sign * side
        rows[1, 2 * flank + 1] = sign * rest
    return 2
