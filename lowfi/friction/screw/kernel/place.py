"""What one ball adds to the joint system at its place: forces out of balance and their derivatives."""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.friction.screw.kernel_types import GrooveArrays, JointSystem
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
def _acts(
    n_x: float, n_z: float, rows: Array, speed: float, share: float, along: float, on: bool, load: Array, pull: Array
) -> None:
    """Writes how a contact's normal force (9,) and friction per component (9, 3) act on the rows of ``ball_rows``.

    rows: its map (3, 4); along: share of the friction along the path. Linear in (n_x, n_z, rows, along).
    """
    load[:] = 0.0
    pull[:] = 0.0
    pull[2:6] = rows.T / speed
    load[0], load[1], pull[0, 0], pull[1, 0] = n_x, n_z, share * n_z, -share * n_x
    if on:
        load[6], load[8], pull[6, 0], pull[8, 0], pull[7, 1] = n_x, n_z, share * n_z, -share * n_x, along


@kernel
def ball_rows(
    system: JointSystem, k: int, p: Array, shift: Array, x: Array, share: float, eps: float, out: Array, by: Array
) -> None:
    """Writes out (9,) and its derivatives (9, 8) for ball k at p (2,) [m], motion x (4,), screw shifted by shift (2,).

    Rows: force out of balance in x3, z3 with ``share`` of the friction, the grooves' gradient by the motion, force of
    the ball on the screw in x3, y3, z3.
    """
    cell, groove, balls = system.cell, system.groove, system.balls
    start, interference, C, affine = cell.start, cell.interference, cell.C, groove.affine
    speed, mu = groove.speed, balls.strength * system.unit
    rows, g, h, turned = np.empty((3, 4)), np.zeros(3), np.zeros((4, 3)), np.empty((2, OWN_ROWS))
    load, pull, d_load, d_pull = np.empty(OWN_ROWS), np.empty((OWN_ROWS, 3)), np.empty(OWN_ROWS), np.empty((OWN_ROWS, 3))
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
        _acts(n_x, n_z, rows, speed, share, share, on, load, pull)
        out += f * load + mu * f * (pull @ g)
        by[:, 2:6] += mu * f * (pull @ (h[:3] @ rows))
        for c in range(2):  # by n_x and n_z, taken apart
            _acts(1.0 - c, float(c), affine[1 + c], speed, share, 0.0, on, d_load, d_pull)
            seen_more = affine[1 + c] @ x - affine[1 + c, :, 0] * groove.ride[i]
            turned[c] = f * d_load + mu * f * (d_pull @ g + pull @ (h[:3] @ seen_more))
        by_force = (1.5 * sqrt(d) / C[i]) * (load + mu * (pull @ h[3]))
        across = (turned[1] * n_x - turned[0] * n_z) / size  # by a turn of the normal
        b_x, b_z = by_force * n_x - across * n_z, by_force * n_z + across * n_x
        by[:, 0] += b_x
        by[:, 1] += b_z
        if on:
            by[:, 6] -= b_x
            by[:, 7] -= b_z
