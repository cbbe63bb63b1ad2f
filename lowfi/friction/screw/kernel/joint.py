"""Contact loads, motions and ball-to-ball forces as one system of equations, solved by Newton's method.

Unknowns of a ball, in this order: position p (x3, z3) in units of ``position_unit``, motion x (4,), force f on the next
ball; after all balls the screw's displacements u (m,), also in units of ``position_unit``. Forces are in the unit of
``BallArrays``.

`write_ball_equations` computes what one ball adds to the equations: forces out of balance and their derivatives. In all
functions x (4,) are a ball's surface speeds over the nut's speed along the path, ``eps`` is the regularising speed over the
same speed, and ``share`` is the fraction of the friction that acts on the loads, by which the search approaches the
solution.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.friction.screw.kernel_types import (
    GrooveArrays,
    LoadsAndMotionMatrix,
    LoadsAndMotionSystem,
    LoadsAndMotionUnknowns,
)
from rollbench.lowfi.jit import kernel

from .balance import (
    REACH,
    ball_after_open_gap,
    ball_on_ball_sliding,
    dissipation,
    hertz_contact,
    relative_contact_motion,
    remaining_closing_rate,
    solve_with_pivots,
    write_ball_to_ball_derivatives,
    write_contact_map,
)

#: Contacts 0 and 1 of a ball are on the screw, 2 and 3 on the nut.
ON_SCREW = 2

#: Rows of the equations to which a ball contributes: forces on it (2), gradient by its motion (4), its force on the screw
#: (3); columns: its position (2), its motion (4), displacement of the screw in its section (2).
OWN_ROWS, OWN_COLUMNS = 9, 8


@kernel
def _write_dissipation_derivatives(
    groove: GrooveArrays, i: int, f: float, rows: Array, x: Array, eps: float, g: Array, h: Array
) -> None:
    """Write derivatives of D, the power dissipated in contact i divided by its friction bound mu F, to g (3,), h (4, 3).

    Written are the gradient g of D by the sliding vx across the groove and vz along the path and by the spin, the
    Hessian in h[:3], and in h[3] the derivative of the product F g by F. The latter is needed because the semi-axes
    grow with F^(1/3); it follows from D(s a, s b, vx, vz, spin) = D(a, b, vx, vz, s spin) for any factor s of the
    semi-axes a and b. groove: geometry and Hertz constants; f: contact force F [N]; rows (3, 4): map of the contact
    (`write_contact_map`); x (4,): motion of the ball, surface speeds divided by the nut's speed; eps: regularising
    speed divided by the nut's speed.
    """
    cube = f ** (1.0 / 3.0)
    vx, vz, spin = relative_contact_motion(groove, i, rows, x)
    d = dissipation(groove.C_a[i] * cube, groove.C_b[i] * cube, vx, vz, spin, eps * groove.speed)
    g[0], g[1], g[2] = d.by_vx, d.by_vz, d.by_spin
    # rows 0 to 2: Hessian by (vx, vz, spin)
    h[0, 0], h[0, 1], h[0, 2], h[1, 1], h[1, 2], h[2, 2] = d.xx, d.xz, d.x_spin, d.zz, d.z_spin, d.spin_spin
    h[1, 0], h[2, 0], h[2, 1] = d.xz, d.x_spin, d.z_spin
    # row 3: d(F g)/dF = g + F dg/dF; with semi-axes ~ F^(1/3) dg/dF = d(g)/d(spin) spin/(3 F), and g_spin ~ a more
    for r in range(3):
        h[3, r] = g[r] + spin * h[r, 2] / 3.0
    h[3, 2] += g[2] / 3.0


@kernel
def _write_force_effects(
    n_x: float, n_z: float, rows: Array, speed: float, share: float, along: float, on: bool, load: Array, pull: Array
) -> None:
    """Write the effects of a contact's normal force and friction on the nine equations of its ball.

    The equations are the force on the ball in x3 and z3 (2), the gradient of the dissipation by the ball's motion (4) and
    the force on the screw in x3, y3, z3 (3). load (9,) is the effect of a unit normal force, pull (9, 3) that of each
    component (vx, vz, spin) of the friction. n_x, n_z: contact normal; rows (3, 4): contact's sliding by the ball's motion
    (`write_contact_map`); speed: speed of the nut along the path [m/s]; share: 0 to 1, by which friction is multiplied in
    the force equations, raised during the search; along: the same for the friction along the path on the screw (0 in
    derivatives by the normal); on: whether the contact is on the screw. The result is linear in (n_x, n_z, rows, along).
    """
    load[:] = 0.0
    pull[:] = 0.0
    # rows 0, 1: force on the ball in x3, z3; rows 2 to 5: gradient by its motion; rows 6 to 8: force on the screw
    pull[2:6] = rows.T / speed
    load[0], load[1], pull[0, 0], pull[1, 0] = n_x, n_z, share * n_z, -share * n_x
    if on:
        load[6], load[8], pull[6, 0], pull[8, 0], pull[7, 1] = n_x, n_z, share * n_z, -share * n_x, along


@kernel
def write_ball_equations(
    system: LoadsAndMotionSystem, k: int, p: Array, shift: Array, x: Array, share: float, eps: float, out: Array, by: Array
) -> None:
    """Write what ball k adds to the equations of loads and motion to out (9,) [N], and its derivatives to by (9, 8).

    Rows: force on the ball in x3 (radial) and z3 (binormal) with a fraction of the friction (2), gradient of the
    grooves' dissipation by the motion (4), force of the ball on the screw in x3, y3, z3 (3). Columns of ``by``:
    derivatives by p (2), x (4), shift (2). system: data of all balls; p (2,): displacement of the ball [m]; shift (2,):
    displacement of the screw in the ball's section [m]; x (4,): motion of the ball, surface speeds divided by the nut's
    speed; share: fraction of the friction that acts on the loads; eps: regularising speed divided by the nut's speed.
    """
    cell, groove, balls = system.cell, system.groove, system.balls
    start, interference, C, affine = cell.groove_to_ball_vectors, cell.interference, cell.C, groove.contact_map_coefficients
    speed, mu = groove.speed, balls.scaled_groove_mu * system.force_unit
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
        write_contact_map(groove, n_x, n_z, rows)
        g[:] = 0.0
        h[:] = 0.0
        if np.max(balls.force[k]) > 0.0:  # others count as unloaded
            _write_dissipation_derivatives(groove, i, f, rows, x, eps, g, h)
        _write_force_effects(n_x, n_z, rows, speed, share, share, on, load, pull)
        out += f * load + mu * f * (pull @ g)
        by[:, 2:6] += mu * f * (pull @ (h[:3] @ rows))  # columns 2 to 5: by the ball's motion
        for c in range(2):  # derivatives by n_x and by n_z, taken as independent
            _write_force_effects(1.0 - c, float(c), affine[1 + c], speed, share, 0.0, on, d_load, d_pull)
            seen_more = affine[1 + c] @ x - affine[1 + c, :, 0] * groove.body_rotation[i]
            turned[c] = f * d_load + mu * f * (d_pull @ g + pull @ (h[:3] @ seen_more))
        # by the position: dF/d(approach) along the normal, and the turn of the normal across it
        by_force = (1.5 * sqrt(d) / C[i]) * (load + mu * (pull @ h[3]))
        across = (turned[1] * n_x - turned[0] * n_z) / size
        b_x, b_z = by_force * n_x - across * n_z, by_force * n_z + across * n_x
        # columns 0, 1: ball's position; columns 6, 7: screw's, of the opposite sign
        by[:, 0] += b_x
        by[:, 1] += b_z
        if on:
            by[:, 6] -= b_x
            by[:, 7] -= b_z


#: Number of unknowns of a ball, and half bandwidth of the matrix.
SIZE, HALF = 7, 12

#: Longest Newton step of positions, as a fraction of the distance of groove centre and ball centre.
LONGEST_STEP = 0.1


@kernel
def _add_ball_to_ball_contact(
    system: LoadsAndMotionSystem,
    at: LoadsAndMotionUnknowns,
    k: int,
    share: float,
    eps: float,
    start: int,
    matrix: LoadsAndMotionMatrix,
) -> None:
    """Add force and friction between ball k and the next ball, with derivatives, to the equations in ``matrix``.

    system: data of all balls; at: present unknowns; k: number of the ball; share: fraction of the friction that acts on
    the loads; eps: regularising speed divided by the nut's speed; start: ball whose rows come first, before which a
    closed track is cut open.
    """
    groove, balls = system.groove, system.balls
    first, second, closing = groove.first_ball_surface_speeds, groove.second_ball_surface_speeds, groove.closing_rate_factor
    x, f = at.motion, at.ball_force
    side, K = matrix.ball_residual, matrix.ball_band
    n, ahead = f.shape[0], (k + 1) % f.shape[0]
    row, other = SIZE * ((k - start) % n), SIZE * ((ahead - start) % n)
    last = row == SIZE * (n - 1)
    u, v, size = ball_on_ball_sliding(groove, x[k], x[ahead], eps)
    u, v = u / size, v / size
    mu = balls.mu[k]
    bite = mu * max(f[k], 0.0)
    # sliding friction between the balls and their force along the path (Lin 3.73-3.75)
    for j in range(4):
        side[row + 2 + j] += bite * (u * first[0, j] + v * first[1, j])
        side[other + 2 + j] -= bite * (u * second[0, j] + v * second[1, j])
    side[row + 2] += closing * f[k]
    side[other + 2] -= closing * f[k]
    slopes, blocks = np.zeros((n, 2)), np.empty((4, 5, 5))
    # row 6: complementarity of force and gap, Fischer-Burmeister
    side[row + 6], slopes[k, 0] = f[k], 1.0
    if balls.can_touch_next[k] > 0.0:
        left = remaining_closing_rate(groove, balls, x, k)
        root = max(sqrt(f[k] * f[k] + left * left), 1e-300)
        side[row + 6] = f[k] + left - root
        slopes[k, 0], slopes[k, 1] = 1.0 - f[k] / root, 1.0 - left / root
    write_ball_to_ball_derivatives(groove, balls, x, f, slopes, eps, k, blocks)
    # blocks: ball k with itself, the next ball with itself, k with next, next with k
    for i in range(5):
        for j in range(5):
            K[row + 2 + i, HALF + j - i] += blocks[0, i, j]
            K[other + 2 + i, HALF + j - i] += blocks[3, i, j]
            if not last:
                K[row + 2 + i, HALF + SIZE + j - i] += blocks[1, i, j]
                K[other + 2 + i, HALF - SIZE + j - i] += blocks[2, i, j]
    for which in range(2):
        _add_ball_to_ball_force(system, which, row, other, (u, v, size), f[k], mu, share, matrix)


@kernel
def _add_ball_to_ball_force(
    system: LoadsAndMotionSystem,
    which: int,
    row: int,
    other: int,
    rub: tuple[float, float, float],
    f: float,
    mu: float,
    share: float,
    matrix: LoadsAndMotionMatrix,
) -> None:
    """Add the force between two balls to the force balance of one of them in the plane of its groove section.

    system: data of all balls; which: 0 for the first ball, 1 for the second; row: first row of the first ball in
    ``matrix``; other: first row of the second ball; rub: direction (u, v) of the sliding of the first on the second
    ball, and size of this sliding; f: force between the two balls; mu: coefficient of friction; share: fraction of this
    force and its friction that acts on the loads.
    """
    first = system.groove.first_ball_surface_speeds
    second = system.groove.second_ball_surface_speeds
    push = system.ball_force_directions
    slide = system.tangent_directions
    side, K = matrix.ball_residual, matrix.ball_band
    u, v, size = rub
    bite, sliding, joined = mu * max(f, 0.0), mu if f > 0.0 else 0.0, other > row
    for c in range(2):
        at, sign = (row + c, -1.0) if which == 0 else (other + c, 1.0)
        s_u, s_v = sign * slide[which, 0, c], sign * slide[which, 1, c]
        along = s_u * u + s_v * v
        side[at] -= share * (f * push[which, c] + bite * along)
        if which == 0 or joined:
            K[at, HALF + row + 6 - at] -= share * (push[which, c] + sliding * along)
        for j in range(4):
            # derivative of the sliding direction by the motions of the first and the second ball
            one = s_u * first[0, j] + s_v * first[1, j] - along * (u * first[0, j] + v * first[1, j])
            two = s_u * second[0, j] + s_v * second[1, j] - along * (u * second[0, j] + v * second[1, j])
            if which == 0 or joined:
                K[at, HALF + row + 2 + j - at] -= share * bite / size * one
            if which == 1 or joined:
                K[at, HALF + other + 2 + j - at] += share * bite / size * two


@kernel
def write_loads_and_motion_equations(
    system: LoadsAndMotionSystem,
    at: LoadsAndMotionUnknowns,
    share: float,
    eps: float,
    start: int,
    matrix: LoadsAndMotionMatrix,
) -> float:
    """Write residual and Jacobian of the equations for contact loads and motion to ``matrix``; return the residual's norm.

    The norm is the root of the sum of squares. system: data of all balls; at: present unknowns; share: fraction of the
    friction that acts on the loads; eps: regularising speed divided by the nut's speed; start: ball whose rows come
    first, before which a closed track is cut open. The external forces on the screw are those in ``system.cell``.
    """
    cell, unit, length, rows = system.cell, system.force_unit, system.position_unit, system.screw_displacement_maps
    hold, nominal = system.balls.holding_stiffness, system.groove.nominal
    p, u, x, f = at
    side, side_u, K, columns, lines, corner = matrix
    n = f.shape[0]
    m = u.shape[0]
    section = cell.inner_displacement_maps
    offset = cell.given_inner_displacement
    pull = cell.inner_body_forces
    out, by, shift = np.empty(OWN_ROWS), np.empty((OWN_ROWS, OWN_COLUMNS)), np.empty(2)
    side[:], K[:], columns[:], lines[:], corner[:] = 0.0, 0.0, 0.0, 0.0, 0.0
    for q in range(m):
        side_u[q] = -pull[q] / unit
    for k in range(n):
        row = SIZE * ((k - start) % n)
        for c in range(2):
            shift[c] = offset[k, c]
            for q in range(m):
                shift[c] += section[k, c, q] * u[q]
        write_ball_equations(system, k, p[k], shift, x[k], share, eps, out, by)
        # ball's rows: residual, its position and motion, columns of the screw
        for i in range(6):
            side[row + i] += out[i] / unit
            for j in range(6):
                K[row + i, HALF + j - i] += by[i, j] * (length if j < 2 else 1.0) / unit
            for q in range(m):
                for c in range(2):
                    columns[row + i, q] += by[i, 6 + c] * section[k, c, q] * length / unit
        for j in range(4):
            side[row + 2 + j] += hold[k] * (x[k, j] - nominal[j])
            K[row + 2 + j, HALF] += hold[k]
        # screw's rows: forces of the ball on it, projected on its free motions
        for q in range(m):
            for r in range(3):
                side_u[q] -= rows[k, r, q] * out[6 + r] / unit
                for j in range(6):
                    lines[q, row + j] -= rows[k, r, q] * by[6 + r, j] * (length if j < 2 else 1.0) / unit
                for c in range(2):
                    for o in range(m):
                        corner[q, o] -= rows[k, r, q] * by[6 + r, 6 + c] * section[k, c, o] * length / unit
    for k in range(n):
        _add_ball_to_ball_contact(system, at, k, share, eps, start, matrix)
    return float(sqrt(np.sum(side * side) + np.sum(side_u * side_u)))


@kernel
def write_loads_and_motion_newton_step(
    matrix: LoadsAndMotionMatrix, start: int, length: float, d: LoadsAndMotionUnknowns
) -> None:
    """Write Newton's step of all unknowns of contact loads and motion to d, with positions in m.

    matrix: residual and Jacobian from `write_loads_and_motion_equations`, which are overwritten by the factors; start: ball
    whose rows come first; length: unit of positions [m]. Positions that no contact resists do not move.
    """
    side, side_u, K, columns, lines, corner = matrix
    n, m = d.ball_force.shape[0], side_u.shape[0]
    top = 0.0  # stiffest position: a tiny part of it keeps free positions where they are
    for k in range(n):
        top = max(top, K[SIZE * k, HALF], K[SIZE * k + 1, HALF])
    for k in range(n):
        K[SIZE * k, HALF] += 1e-12 * top
        K[SIZE * k + 1, HALF] += 1e-12 * top
    both = np.empty((SIZE * n, m + 1))
    both[:, :m] = columns
    both[:, m] = -side
    solve_with_pivots(K, both, HALF)
    if m > 0:  # Schur complement of the balls for the screw's motions
        small, right = np.zeros((m, 3 * m + 1)), np.empty((m, 1))
        for q in range(m):
            right[q, 0] = -side_u[q] - np.sum(lines[q] * both[:, m])
            for o in range(m):
                small[q, m + o - q] = corner[q, o] - np.sum(lines[q] * both[:, o])
            small[q, m] += 1e-12 * top
        solve_with_pivots(small, right, m)
        for q in range(m):
            d.screw[q] = right[q, 0] * length
            both[:, m] -= both[:, q] * right[q, 0]
    for k in range(n):
        row = SIZE * ((k - start) % n)
        d.ball[k, 0], d.ball[k, 1] = both[row, m] * length, both[row + 1, m] * length
        for j in range(4):
            d.motion[k, j] = both[row + 2 + j, m]
        d.ball_force[k] = both[row + 6, m]


@kernel
def solve_loads_and_motion_by_newton(
    system: LoadsAndMotionSystem, at: LoadsAndMotionUnknowns, share: float, eps: float, goal: float, limit: int
) -> tuple[float, int]:
    """Solve contact loads and motion of the balls as one system by Newton's method; return residual and number of steps.

    A step is halved until the residual falls. ``system``: data of all balls; ``at``: unknowns from which the search
    begins, overwritten by the solution; ``share``: fraction of the friction that acts on the loads; ``eps``:
    regularising speed divided by the nut's speed. The iteration ends when the residual (root of the sum of squares) is
    at most ``goal``, after ``limit`` steps, or when no step lets the residual fall.
    """
    p, u, x, f = at
    n, m, length, reach = f.shape[0], u.shape[0], system.position_unit, system.cell.groove_ball_centre_distance
    matrix = LoadsAndMotionMatrix(
        np.empty(SIZE * n),
        np.empty(m),
        np.empty((SIZE * n, 3 * HALF + 1)),
        np.empty((SIZE * n, m)),
        np.empty((m, SIZE * n)),
        np.empty((m, m)),
    )
    d = LoadsAndMotionUnknowns(np.empty_like(p), np.empty_like(u), np.empty_like(x), np.empty_like(f))
    start = ball_after_open_gap(system.groove, system.balls, x, f)
    size = write_loads_and_motion_equations(system, at, share, eps, start, matrix)
    for count in range(limit):
        if size <= goal:
            return size, count
        write_loads_and_motion_newton_step(matrix, start, length, d)
        moved = max(np.max(np.abs(d.ball)), np.max(np.abs(d.screw)) if m > 0 else 0.0)
        part_of = min(1.0, REACH / max(np.max(np.abs(d.motion)), 1e-300), LONGEST_STEP * reach / max(moved, 1e-300))
        better = False
        for _ in range(30):
            trial = LoadsAndMotionUnknowns(
                p + part_of * d.ball, u + part_of * d.screw, x + part_of * d.motion, f + part_of * d.ball_force
            )
            start = ball_after_open_gap(system.groove, system.balls, trial.motion, trial.ball_force)
            new = write_loads_and_motion_equations(system, trial, share, eps, start, matrix)
            if new < (1.0 - 0.1 * part_of) * size:
                better = True
                break
            part_of *= 0.5
        if not better:
            return size, count + 1
        p[:], u[:], x[:], f[:] = trial
        size = new
    return size, limit
