"""What one ball adds to the joint system at its place: forces out of balance and their derivatives."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.records import Array
from rollbench.lowfi.friction.screw.records import GrooveArrays, JointSystem
from rollbench.lowfi.jit import kernel

from .contacts import contact_map, dissipation, hertz_contact, seen

#: Contacts 0 and 1 of a ball are on the screw, 2 and 3 on the nut.
ON_SCREW = 2
#: Rows of a ball's own part: position, motion, force on the screw; columns: position, motion, place of the screw.
OWN_ROWS, OWN_COLUMNS = 9, 8


@kernel
def _law(groove: GrooveArrays, i: int, f: float, rows: Array, x: Array, eps: float, g: Array, h: Array) -> None:
    """Writes the gradient g (3,) of contact i's dissipation per mu F, its Hessian h[:3], and h[3]: F g derived by F.

    Semi-axes go with F^(1/3), and D(s a, s b, vx, vz, spin) = D(a, b, vx, vz, s spin).
    """
    cube = f ** (1.0 / 3.0)
    vx, vz, spin = seen(groove, i, rows, x)
    d = dissipation(groove.C_a[i] * cube, groove.C_b[i] * cube, vx, vz, spin, eps * groove.speed)
    g[0], g[1], g[2] = d.by_vx, d.by_vz, d.by_spin
    h[0, 0], h[0, 1], h[0, 2], h[1, 1], h[1, 2], h[2, 2] = d.xx, d.xz, d.x_spin, d.zz, d.z_spin, d.spin_spin
    h[1, 0], h[2, 0], h[2, 1] = d.xz, d.x_spin, d.z_spin
    for r in range(3):
        h[3, r] = g[r] + spin * h[r, 2] / 3.0
    h[3, 2] += g[2] / 3.0


@kernel
def _add_force(
    f: float, bound: float, n_x: float, n_z: float, rows: Array, g: Array, speed: float, share: float, on: bool, out: Array
) -> None:
    """Adds one contact to the ball's rows ``out`` (9,), see ``ball_rows``."""
    out[0] += f * n_x + share * bound * g[0] * n_z
    out[1] += f * n_z - share * bound * g[0] * n_x
    for j in range(4):
        out[2 + j] += bound * (rows[0, j] * g[0] + rows[1, j] * g[1] + rows[2, j] * g[2]) / speed
    if on:
        out[6] += f * n_x + share * bound * g[0] * n_z
        out[7] += share * bound * g[1]
        out[8] += f * n_z - share * bound * g[0] * n_x


@kernel
def _by_load(
    groove: GrooveArrays,
    i: int,
    f: float,
    mu: float,
    n_x: float,
    n_z: float,
    rows: Array,
    x: Array,
    g: Array,
    h: Array,
    share: float,
    by: Array,
) -> None:
    """Writes the derivatives (9, 3) of a contact's rows by its force and by n_x and n_z, taken apart."""
    affine, speed, bound = groove.affine, groove.speed, mu * f
    turned, own_turn = np.zeros((2, 3)), np.zeros((2, 4))
    for c in range(2):
        move = affine[1 + c] @ x - affine[1 + c, :, 0] * groove.ride[i]
        turned[c] = bound * (h[:3] @ move)
        own_turn[c] = bound * (g @ affine[1 + c])
    by[0, 0], by[1, 0] = n_x + share * mu * h[3, 0] * n_z, n_z - share * mu * h[3, 0] * n_x
    by[0, 1], by[1, 1] = f + share * turned[0, 0] * n_z, -share * (turned[0, 0] * n_x + bound * g[0])
    by[0, 2], by[1, 2] = share * (turned[1, 0] * n_z + bound * g[0]), f - share * turned[1, 0] * n_x
    for j in range(4):
        by[2 + j, 0] = mu * (rows[0, j] * h[3, 0] + rows[1, j] * h[3, 1] + rows[2, j] * h[3, 2]) / speed
        for c in range(2):
            through = rows[0, j] * turned[c, 0] + rows[1, j] * turned[c, 1] + rows[2, j] * turned[c, 2]
            by[2 + j, 1 + c] = (through + own_turn[c, j]) / speed
    by[6], by[8] = by[0], by[1]
    by[7, 0], by[7, 1], by[7, 2] = share * mu * h[3, 1], share * turned[0, 1], share * turned[1, 1]


@kernel
def _by_motion(
    bound: float, n_x: float, n_z: float, rows: Array, h: Array, speed: float, share: float, on: bool, by: Array
) -> None:
    """Adds the derivatives of a contact's rows by the ball's motion."""
    bent = bound * (h[:3] @ rows)
    for j in range(4):
        by[0, 2 + j] += share * bent[0, j] * n_z
        by[1, 2 + j] -= share * bent[0, j] * n_x
        for q in range(4):
            by[2 + q, 2 + j] += (rows[0, q] * bent[0, j] + rows[1, q] * bent[1, j] + rows[2, q] * bent[2, j]) / speed
        if on:
            by[6, 2 + j] += share * bent[0, j] * n_z
            by[7, 2 + j] += share * bent[1, j]
            by[8, 2 + j] -= share * bent[0, j] * n_x


@kernel
def ball_rows(
    system: JointSystem, k: int, p: Array, shift: Array, x: Array, share: float, eps: float, out: Array, by: Array
) -> None:
    """Writes out (9,) and its derivatives (9, 8) for ball k at p (2,) [m], motion x (4,), screw shifted by shift (2,).

    Rows: force out of balance in x3, z3 with ``share`` of the friction, the grooves' gradient by the motion, force of
    the ball on the screw in x3, y3, z3.
    """
    cell, groove, balls = system.cell, system.groove, system.balls
    start, interference, C = cell.start, cell.interference, cell.C
    speed, mu = groove.speed, balls.strength * system.unit
    rows, load, g, h = np.empty((3, 4)), np.empty((OWN_ROWS, 3)), np.zeros(3), np.zeros((4, 3))
    out[:] = 0.0
    by[:] = 0.0
    for i in range(4):
        on = i < ON_SCREW
        m_x, m_z = (p[0] - shift[0], p[1] - shift[1]) if on else (p[0], p[1])
        f, n_x, n_z, d, size = hertz_contact(start[k, i, 0], start[k, i, 1], m_x, m_z, interference[k, i], C[i])
        if f == 0.0:
            continue
        contact_map(groove, n_x, n_z, rows)
        g[:] = 0.0
        h[:] = 0.0
        if np.max(balls.force[k]) > 0.0:  # others count as unloaded
            _law(groove, i, f, rows, x, eps, g, h)
        _add_force(f, mu * f, n_x, n_z, rows, g, speed, share, on, out)
        _by_load(groove, i, f, mu, n_x, n_z, rows, x, g, h, share, load)
        _by_motion(mu * f, n_x, n_z, rows, h, speed, share, on, by)
        k_n = 1.5 * sqrt(d) / C[i]
        for r in range(OWN_ROWS if on else 6):
            along = (load[r, 2] * n_x - load[r, 1] * n_z) / size  # by a turn of the normal
            b_x, b_z = load[r, 0] * k_n * n_x - along * n_z, load[r, 0] * k_n * n_z + along * n_x
            by[r, 0] += b_x
            by[r, 1] += b_z
            if on:
                by[r, 6] -= b_x
                by[r, 7] -= b_z
