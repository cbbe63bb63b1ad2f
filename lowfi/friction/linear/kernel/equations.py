"""Equations of a chain of balls, with friction at the grooves and between balls that is bounded by the contact load.

Velocities are in units of the carriage's speed, forces in units of the largest friction bound of a ball. Unknowns of a
ball: axial velocity and ball radius times the two spin components across the track, x = (v, R omega_x, R omega_y), and
last z of the contact with the next ball: its force where z is positive, and minus the rate of its gap where it is
negative. F = max(z, 0), rate = max(-z, 0) are complementary by construction. In the smoothed equations F rate = ``smooth``
instead of zero. In the exact equations the rate is in units of the regularising speed eps, with which sticking contacts
yield to a force, so that Newton's method passes z = 0 with ease. Newton's method solves the equations.

Arrays of the whole chain: g (4 N,) is the residual, K (4 N, 11) its Jacobian as a band, of N balls with four unknowns each.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.linear.kernel_types import (
    Array,
    ChainArrays,
    ChainSearchState,
    EquationSmoothing,
    NewtonArrays,
)
from rollbench.lowfi.jit import CONTACT, is_compiled_module, kernel, load_kernel_package

_OTHER = load_kernel_package(CONTACT, compiled=is_compiled_module(__name__))

dissipation, solve_with_pivots = _OTHER.dissipation, _OTHER.solve_with_pivots

#: Half bandwidth of the Jacobian: number of elements of the banded matrix on either side of its diagonal.
HALF = 5

#: Columns in which the banded Jacobian is stored: half a band, the diagonal, half a band.
WIDTH = 11

#: Number of columns of the banded Jacobian while rows are exchanged, because the part right of the diagonal may then grow
#: to twice the half bandwidth.
FILLED = 16


@kernel
def solve_two_banded_systems(K: Array, A: Array, x: Array, y: Array) -> float:
    """Solve two linear systems with one banded matrix; return the sign of the matrix's determinant.

    K (n, 11): the matrix; A (n, 16): work array, to which the factors of K are written; x, y (n,): right-hand sides,
    which are overwritten by the solutions.
    """
    both = np.empty((x.size, 2))
    A[:, :WIDTH], A[:, WIDTH:] = K, 0.0
    both[:, 0], both[:, 1] = x, y
    sign: float = solve_with_pivots(A, both, HALF)
    x[:], y[:] = both[:, 0], both[:, 1]
    return sign


@kernel
def slide_and_spin_friction(s: float, w: float, shape: Array) -> tuple[float, float, float, float, float]:
    """Return force and moment of friction of one sliding and spinning elliptical contact, with their derivatives.

    s: sliding speed along the minor axis; w: semi-axis a times spin (s and w must not both be zero); shape (4,):
    constants (b/a, q0, k1, k3), see `contact_friction_constants`. All results are divided by the friction bound: the
    force f and the moment m over a, which are the derivatives of the dissipation s f + w m by s and by w, and then the
    second derivatives of the dissipation by s s, s w and w w.
    """
    ratio, q0, k1, k3 = shape
    if abs(s) >= abs(w):  # the centre of rotation lies outside the ellipse
        d = dissipation(1.0, ratio, 0.0, s, w, 0.0)
        return d.by_vz, d.by_spin, d.zz, d.z_spin, d.spin_spin
    # t = c/a: closed form of `contact_friction_constants`, and its derivatives
    t, sign = s / w, 1.0 if w > 0.0 else -1.0
    h = (k1 - 3.0 * k3 * t * t) / abs(w)
    return sign * t * (k1 - k3 * t * t), sign * (q0 - t * t * (0.5 * k1 - 0.75 * k3 * t * t)), h, -h * t, h * t * t


@kernel
def regularised_friction(s: float, w: float, shape: Array, eps: float) -> tuple[float, float, float, float, float]:
    """Return force and moment of regularised friction of one elliptical contact, with their derivatives.

    All results are divided by the friction bound. s: sliding speed; w: semi-axis a times spin; shape (4,): constants
    (b/a, q0, k1, k3), see `contact_friction_constants`; eps: regularising speed. Returns the force and the moment over
    a, which are the derivatives by s and by w of the convex function sqrt(phi^2 + eps^2) - eps with Coulomb's
    dissipation phi(s, w), and then its second derivatives by s s, s w and w w. The friction is phi/sqrt(phi^2 + eps^2)
    times Coulomb's, so that sticking contacts creep at speeds below eps.
    """
    if s == 0.0 and w == 0.0:
        return 0.0, 0.0, 1.0 / eps, 0.0, shape[1] * shape[1] / eps
    f, m, ss, sw, ww = slide_and_spin_friction(s, w, shape)
    phi = s * f + w * m
    eta = sqrt(phi * phi + eps * eps)
    c, b = phi / eta, (eps / eta) * (eps / eta) / eta
    return c * f, c * m, c * ss + b * f * f, c * sw + b * f * m, c * ww + b * m * m


@kernel
def force_and_gap_rate(z: float, smooth: float) -> tuple[float, float, float]:
    """Return the force between two balls, the opening rate of their gap, and the derivative of the force by the unknown z.

    z: unknown of the contact of the two balls; smooth: product of force and rate, zero for exact complementarity. The
    results satisfy force - rate = z and force times rate = ``smooth``; neither is negative.
    """
    if smooth == 0.0:
        return max(z, 0.0), max(-z, 0.0), 1.0 if z > 0.0 else 0.0
    root = sqrt(z * z + 4.0 * smooth)
    larger = 0.5 * (abs(z) + root)
    if z > 0.0:
        return larger, smooth / larger, larger / root
    return smooth / larger, larger, smooth / (larger * root)


@kernel
def _add_groove_friction(chain: ChainArrays, point: ChainSearchState, eps: float, K: Array, g: Array) -> None:
    """Add the friction at the grooves to the residual g (4 N,) of all equations and to its banded Jacobian K.

    chain: contacts of the N balls; point: present motions; eps: regularising speed of friction, divided by the
    carriage's speed.
    """
    contacts, slip = chain.contacts, point.groove_contact_slips
    for j in range(contacts.shape[0]):
        for i in range(contacts.shape[1]):
            bound = contacts[j, i, 3]
            if bound == 0.0:
                continue
            f, m, ss, sw, ww = regularised_friction(slip[j, i, 0], slip[j, i, 1], chain.friction_constants, eps)
            nx, ny, arm = contacts[j, i, 0], contacts[j, i, 1], contacts[j, i, 4]
            # slip and spin by v, R omega_x, R omega_y (Lin 3.22-3.24)
            rows = ((1.0, 0.0), (ny, arm * nx), (-nx, arm * ny))
            for k in range(3):
                a, b = rows[k]
                g[4 * j + k] += bound * (a * f + b * m)
                left, right = a * ss + b * sw, a * sw + b * ww
                for q in range(3):
                    c, d = rows[q]
                    K[4 * j + k, HALF + q - k] += bound * (left * c + right * d)


@kernel
def _add_ball_friction(eps: float, bound: float, slope: float, k: int, pair: Array, K: Array, g: Array) -> None:
    """Add the friction between balls k and k + 1 to the residual g (4 N,) of all equations and to its banded Jacobian K.

    pair (N - 1, 3): ``ball_to_ball_slips`` of `ChainSearchState`, whose last two columns are the sliding of balls k and
    k + 1 on each other; eps: regularising speed of friction, divided by the carriage's speed; bound: coefficient of
    friction times force; slope: derivative of the bound by the unknown z of the contact.
    """
    i, tx, ty = 4 * k, pair[k, 1], pair[k, 2]
    eta = sqrt(tx * tx + ty * ty + eps * eps)
    across = (tx / eta, ty / eta)
    for a in range(2):
        for row in (i + 1 + a, i + 5 + a):
            g[row] += bound * across[a]
            K[row, HALF + i + 3 - row] += slope * across[a]
            for b in range(2):
                # (I - t t^T)/|sliding|: turn of the sliding direction
                h = bound * ((1.0 if a == b else 0.0) - across[a] * across[b]) / eta
                for column in (i + 1 + b, i + 5 + b):
                    K[row, HALF + column - row] += h


@kernel
def write_chain_equations(chain: ChainArrays, point: ChainSearchState, law: EquationSmoothing, K: Array, g: Array) -> None:
    """Write the residual of all equations of a row of N balls to g (4 N,) and its Jacobian to K (4 N, 11).

    The rows of a ball are its three unbalanced forces and the equation of the gap to the next ball. chain: contacts of
    the balls; point: present unknowns; law: smoothing of friction and contact conditions.
    """
    pair, drift, z = point.ball_to_ball_slips, point.motion_less_nominal, point.ball_to_ball_unknowns
    eps, share, smooth, spring = law
    closed, mu, hold = chain.can_touch_next, chain.mu, chain.holding_stiffness
    K[:] = 0.0
    for j in range(drift.shape[0]):
        stiffness = hold[j] + spring
        for k in range(3):
            g[4 * j + k] = stiffness * drift[j, k]
            K[4 * j + k, HALF] = stiffness
        g[4 * j + 3] = 0.0
        K[4 * j + 3, HALF] = -1.0
    _add_groove_friction(chain, point, eps, K, g)
    for k in range(closed.shape[0]):
        i = 4 * k + 3
        if closed[k] == 0.0:
            g[i] = -z[k]
            continue
        force, rate, slope = force_and_gap_rate(z[k], smooth)
        # axial balance of balls k and k + 1 (Lin 3.25)
        g[i - 3] += force
        g[i + 1] -= force
        K[i - 3, HALF + 3] += slope
        K[i + 1, HALF - 1] -= slope
        stiff, scale = 1.0, 1.0
        if smooth == 0.0:
            stiff, scale = 1.0 / eps, 1.0 / (1.0 + rate)
        # v_(k+1) - v_k = rate of the gap (Lin 3.30, 3.31)
        g[i] = scale * (stiff * pair[k, 0] + rate)
        K[i, HALF - 3] = scale * stiff
        K[i, HALF + 1] = -scale * stiff
        K[i, HALF] = scale * (slope - 1.0)
        if share * mu > 0.0:
            _add_ball_friction(eps, mu * share * force, mu * share * slope, k, pair, K, g)


@kernel
def _add_contact_slips(contacts: Array, point: ChainSearchState, x: Array) -> None:
    """Add the sliding and spin that motions x of the balls cause to the values at all contacts in ``point``.

    These values are the fields ``groove_contact_slips`` and ``ball_to_ball_slips`` of the search state ``point``.
    contacts: field of `ChainArrays`; x (N, 3): velocity, and ball radius times two spins, of each ball, divided by the
    carriage's speed.
    """
    slip, pair, _, _ = point
    p, q, nx, ny = x[:, 1:2], x[:, 2:3], contacts[:, :, 0], contacts[:, :, 1]
    slip[:, :, 0] += x[:, 0:1] + ny * p - nx * q
    slip[:, :, 1] += contacts[:, :, 4] * (nx * p + ny * q)
    pair[:, 0] += x[:-1, 0] - x[1:, 0]
    pair[:, 1:] += x[:-1, 1:3] + x[1:, 1:3]


@kernel
def write_contact_slips(chain: ChainArrays, point: ChainSearchState) -> None:
    """Compute sliding and spin at all contacts from the motions of the balls, and write them to ``point``.

    chain: contacts and nominal motion of the N balls; point: search state, whose field ``motion_less_nominal`` gives
    the motions, and whose fields ``groove_contact_slips`` and ``ball_to_ball_slips`` are written.
    """
    point.groove_contact_slips[:, :, 0] = -chain.contacts[:, :, 2]
    point.groove_contact_slips[:, :, 1] = 0.0
    point.ball_to_ball_slips[:] = 0.0
    _add_contact_slips(chain.contacts, point, chain.nominal_motion + point.motion_less_nominal)


@kernel
def apply_newton_step(chain: ChainArrays, point: ChainSearchState, step: Array, t: float) -> None:
    """Add t times a Newton step to all unknowns in ``point``, and update the sliding at the contacts.

    chain: contacts of the N balls; point: motions of the balls and forces between them, which are changed; step (4 N,):
    three motions and the unknown z of each ball; t: factor of the step.
    """
    n = point.motion_less_nominal.shape[0]
    change = t * step[: 4 * n].reshape(n, 4)
    point.ball_to_ball_unknowns[:] += change[:-1, 3]
    point.motion_less_nominal[:] += change[:, :3]
    _add_contact_slips(chain.contacts, point, change)


@kernel
def reset_open_gaps(point: ChainSearchState, eps: float) -> None:
    """Set the unknown z of every open gap to minus the gap's opening rate divided by the regularising speed eps.

    The equations with exact complementarity need this unit; in the smoothed equations the rate is divided by the
    carriage's speed.
    """
    for k in range(point.ball_to_ball_unknowns.shape[0]):
        if point.ball_to_ball_unknowns[k] <= 0.0:
            point.ball_to_ball_unknowns[k] = min(0.0, point.ball_to_ball_slips[k, 0] / eps)


@kernel
def copy_chain_state(point: ChainSearchState) -> ChainSearchState:
    """Return a copy of the motions and forces of the balls in ``point``."""
    return ChainSearchState(
        point.groove_contact_slips.copy(),
        point.ball_to_ball_slips.copy(),
        point.motion_less_nominal.copy(),
        point.ball_to_ball_unknowns.copy(),
    )


@kernel
def restore_chain_state(point: ChainSearchState, kept: ChainSearchState) -> None:
    """Overwrite all motions and forces of ``point`` by the values in ``kept``, an earlier copy of it.

    Moving back by increments would leave round-off in the relative motions of sticking contacts.
    """
    (
        point.groove_contact_slips[:],
        point.ball_to_ball_slips[:],
        point.motion_less_nominal[:],
        point.ball_to_ball_unknowns[:],
    ) = kept


#: Largest change of a velocity in one Newton step, divided by the carriage's speed: longer steps, which the line search
#: takes back, would cost accuracy.
LONGEST = 2.0

#: Least stiffness that is added to the Jacobian's diagonal to damp velocities.
SOFTEST = 1e-14


@kernel
def largest_entry(x: Array) -> float:
    """Return the largest absolute value of the entries of x; nan if one of them is nan."""
    size = 0.0
    for i in range(x.shape[0]):
        if not abs(x[i]) <= size:
            size = abs(x[i])
    return size


@kernel
def _largest_step_fraction(step: Array) -> float:
    """Return the largest fraction, up to 1, of a Newton step (4 N,) that changes no velocity by more than ``LONGEST``."""
    return float(LONGEST / max(LONGEST, np.max(np.abs(step.reshape(-1, 4)[:, :3]))))


@kernel
def solve_by_semismooth_newton(
    chain: ChainArrays,
    point: ChainSearchState,
    law: EquationSmoothing,
    work: NewtonArrays,
    tolerance: float,
    limit: int,
    firmest: float,
) -> tuple[int, float]:
    """Solve the equations of a row of balls by a semismooth Newton method, with steps halved until the residual falls.

    Where the residual does not fall, velocities are damped by a stiffness of up to ``firmest``, because in motions
    without resistance Newton's steps are only noise. ``point`` is the start and is overwritten by the solution; law:
    smoothing of the equations. The search ends when the largest residual is at most ``tolerance``, or after ``limit``
    steps. Returns the number of steps and the largest residual; afterwards ``work`` contains the equations at the final
    unknowns.
    """
    K, factors, g, step, other = work
    write_chain_equations(chain, point, law, K, g)
    size, damping = sqrt(np.dot(g, g)), 0.0
    for iteration in range(limit):
        if largest_entry(g) <= tolerance:
            return iteration, largest_entry(g)
        for i in range(g.shape[0]):
            if i % 4 != 3:
                K[i, HALF] += damping
        step[:] = -g
        solve_two_banded_systems(K, factors, step, other)
        t, at, trial = _largest_step_fraction(step), 0.0, size
        for _ in range(12):
            apply_newton_step(chain, point, step, t - at)
            at = t
            write_chain_equations(chain, point, law, K, g)
            trial = sqrt(np.dot(g, g))
            if trial < (1.0 - 0.1 * t) * size:
                break
            t *= 0.5
        if trial < size:
            size = trial
            if t > 0.2 or firmest == 0.0:
                damping *= 0.1
            else:
                damping = min(firmest, max(SOFTEST, 100.0 * damping))
            continue
        apply_newton_step(chain, point, step, -at)
        write_chain_equations(chain, point, law, K, g)
        damping = max(SOFTEST, 100.0 * damping)
        if not damping <= firmest:
            return iteration, largest_entry(g)
    return limit, largest_entry(g)


@kernel
def solve_by_undamped_newton(
    chain: ChainArrays, point: ChainSearchState, law: EquationSmoothing, work: NewtonArrays, tolerance: float, limit: int
) -> tuple[int, float]:
    """Solve the equations of a row of balls by undamped Newton steps.

    Damping by the residual would fail at kinks, where the residual rises before it falls. ``point`` is the start and is
    overwritten; law: smoothing of the equations; ``work``: work arrays. The search ends when the largest residual is at
    most ``tolerance``, or after ``limit`` steps; if the residual is then not below that at the start, ``point`` is set
    back to the start. Returns the number of steps and the largest residual.
    """
    K, factors, g, step, other = work
    write_chain_equations(chain, point, law, K, g)
    start, kept = largest_entry(g), copy_chain_state(point)
    for iteration in range(limit):
        step[:] = -g
        solve_two_banded_systems(K, factors, step, other)
        apply_newton_step(chain, point, step, _largest_step_fraction(step))
        write_chain_equations(chain, point, law, K, g)
        if largest_entry(g) <= tolerance:
            return iteration + 1, largest_entry(g)
    if not largest_entry(g) < start:
        restore_chain_state(point, kept)
        return limit, start
    return limit, largest_entry(g)
