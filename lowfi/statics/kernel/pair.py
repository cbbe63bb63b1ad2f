"""Balls that one diagonal pair of exact arcs can hold, and no other flank: closed form, with its stiffness.

The interference of the pair is total = closure + |D + v| - |D|, D between the groove centres and v the motion of the
screw's flank (the nut's stands); its energy is 2/5 total^(5/2) / (C_a + C_b)^(3/2). Force and stiffness are its derivatives
by v.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, BeamContacts, BeamSlopes, BeamState

from .ball import APPROACH, FORCE, HERTZ, KN, KT, MX, MZ, SIZE, USE, WX, WZ

#: Distance of two groove centres [m] below which the line through them says nothing.
APART = 1e-12


@kernel
def pair_alone(contacts: BeamContacts) -> int:
    """The only diagonal pair (0: SL and NR, 1: SR and NL) whose flanks take part, -1 where there is none, a profile, or
    groove centres that coincide."""
    geometry = contacts.geometry
    if contacts.profile.shape[1] > 0 or geometry.shape[0] == 0:
        return -1
    pair = 0 if geometry[0, 0, USE] != 0.0 else 1
    for i in range(geometry.shape[0]):
        for s in range(4):
            if (geometry[i, s, USE] != 0.0) != (s == pair or s == 3 - pair):
                return -1
        dx, dz = geometry[i, 3 - pair, WX] - geometry[i, pair, WX], geometry[i, 3 - pair, WZ] - geometry[i, pair, WZ]
        if dx * dx + dz * dz < APART * APART:
            return -1
    return pair


@kernel
def stretched(line: tuple[float, float, float], vx: float, vz: float) -> tuple[float, float, float, float]:
    """The line between the groove centres of a pair, with its length, after the motion (vx, vz) of its end: direction now,
    1 over its length now, and by how much it has grown."""
    dx, dz, before = line
    x, z = dx + vx, dz + vz
    now = max(sqrt(x * x + z * z), APART)
    inverse = 1.0 / now
    return x * inverse, z * inverse, inverse, (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (now + before)


@kernel
def stand(
    line: tuple[float, float, float],
    v: tuple[float, float],
    now: tuple[float, float, float, float],
    offset: tuple[float, float, float],
    more: float,
) -> tuple[float, float]:
    """Centre of a ball from its nominal place: from the nut's groove centre along the pair's line (``now``: see
    ``stretched``) by the nominal distance and ``more`` [m]; offset: w of the nut's flank and its size.

    By the change of the line's direction: no difference of unit vectors.
    """
    dx, dz, before = line
    nx, nz, inverse, change = now
    turned = offset[2] / before
    x = nx * more + (v[0] * before - dx * change) * inverse * turned + (dx * turned - offset[0])
    z = nz * more + (v[1] * before - dz * change) * inverse * turned + (dz * turned - offset[1])
    return x, z


@kernel
def add_pairs(
    contacts: BeamContacts, state: BeamState, out: BeamSlopes, a: int, energy: float, scale: float
) -> tuple[float, float]:
    """Add the balls that the pair a holds to energy [J] and slopes; fills centres and contacts as `ball.settle_ball` does.

    A ball without load stands so that both flanks have their share of the gap. Returns the energy and the largest force
    met [N]. Six freedoms a flank.
    """
    node, B, geometry, closure, _, _, tiny = contacts
    p, contact, hessians, b = state.p, state.contact, out.hessians, 3 - a
    motion, gradient, o = state.q.ravel(), out.gradient.ravel(), 2 * a
    for i in range(node.shape[0]):
        start = 6 * node[i, a]
        vx, vz = 0.0, 0.0
        for k in range(6):
            vx += B[i, a, 0, k] * motion[start + k]
            vz += B[i, a, 1, k] * motion[start + k]
        ca, cb = geometry[i, a, HERTZ], geometry[i, b, HERTZ]
        wx, wz, size = geometry[i, b, WX], geometry[i, b, WZ], geometry[i, b, SIZE]
        dx, dz = wx - geometry[i, a, WX], wz - geometry[i, a, WZ]
        line = dx, dz, sqrt(dx * dx + dz * dz)
        nx, nz, inverse, change = now = stretched(line, vx, vz)
        part = (closure[i, a] + change) / (ca + cb)
        more = part * cb - geometry[i, b, APPROACH]
        p[i, 0], p[i, 1] = stand(line, (vx, vz), now, (wx, wz, size), more)
        root = sqrt(max(part, 0.0))
        force, stiff = part * root, 1.5 * root
        if force <= tiny:  # free between the flanks, which share the gap
            for s in range(4):
                contact[i, s, FORCE] = 0.0
            for s in range(2):
                hessians[i, o + s, o], hessians[i, o + s, o + 1] = 0.0, 0.0
            continue
        contact[i, a, FORCE], contact[i, a, MX], contact[i, a, MZ] = force, -nx, -nz
        contact[i, b, FORCE], contact[i, b, MX], contact[i, b, MZ] = force, nx, nz
        contact[i, a, KN], contact[i, b, KN] = stiff / ca, stiff / cb
        contact[i, a, KT] = force / (geometry[i, a, SIZE] + ca * part - geometry[i, a, APPROACH])
        contact[i, b, KT] = force / (size + more)
        along, across = stiff / (ca + cb), force * inverse
        hessians[i, o, o] = along * nx * nx + across * nz * nz
        hessians[i, o, o + 1] = (along - across) * nx * nz
        hessians[i, o + 1, o] = hessians[i, o, o + 1]
        hessians[i, o + 1, o + 1] = along * nz * nz + across * nx * nx
        energy += 0.4 * (ca + cb) * part * force
        scale = max(scale, force)
        fx, fz = force * nx, force * nz
        for k in range(6):
            gradient[start + k] += fx * B[i, a, 0, k] + fz * B[i, a, 1, k]
    return energy, scale


@kernel
def even_pairs(contacts: BeamContacts, a: int, load: Array, motion: Array, hessians: Array, step: Array) -> bool:
    """Pairs a linearised where all balls carry the same force, the one that balances most of the forces of load (n, 6).

    Fills the stiffness hessians (N, 4, 4) [N/m] and takes what the linear law has at motion (6 n,) from step (6 n,). False,
    and nothing done, where that force would be none. Six freedoms a flank.
    """
    node, B, geometry, b, o = contacts.node, contacts.B, contacts.geometry, 3 - a, 2 * a
    count = node.shape[0]
    line, whole, applied = np.empty((count, 3)), np.zeros(3), np.zeros(3)
    for i in range(count):
        dx, dz = geometry[i, b, WX] - geometry[i, a, WX], geometry[i, b, WZ] - geometry[i, a, WZ]
        line[i, 2] = sqrt(dx * dx + dz * dz)
        line[i, 0], line[i, 1] = dx / line[i, 2], dz / line[i, 2]
        for k in range(3):
            whole[k] += line[i, 0] * B[i, a, 0, k] + line[i, 1] * B[i, a, 1, k]
    for j in range(load.shape[0]):
        for k in range(3):
            applied[k] += load[j, k]
    force, size = 0.0, 0.0
    for k in range(3):
        force += applied[k] * whole[k]
        size += whole[k] * whole[k]
    if not force > 0.0:
        return False
    force /= size
    root = np.cbrt(force)
    for i in range(count):
        nx, nz, start = line[i, 0], line[i, 1], 6 * node[i, a]
        total = (geometry[i, a, HERTZ] + geometry[i, b, HERTZ]) * root * root
        along, across = 1.5 * force / total, force / line[i, 2]
        h = hessians[i]
        h[o, o], h[o + 1, o + 1] = along * nx * nx + across * nz * nz, along * nz * nz + across * nx * nx
        h[o, o + 1] = (along - across) * nx * nz
        h[o + 1, o] = h[o, o + 1]
        fx, fz = force * nx, force * nz
        given = contacts.closure[i, a] - total
        vx, vz = given * nx, given * nz
        for k in range(6):
            vx += B[i, a, 0, k] * motion[start + k]
            vz += B[i, a, 1, k] * motion[start + k]
        fx += h[o, o] * vx + h[o, o + 1] * vz
        fz += h[o + 1, o] * vx + h[o + 1, o + 1] * vz
        for k in range(6):
            step[start + k] -= fx * B[i, a, 0, k] + fz * B[i, a, 1, k]
    return True
