"""Oracle of chains in linear bearings: the path of solutions followed exactly, by equations of its own, in plain Python.

Friction regularised as a whole by the dissipation of a contact, a closed form inside its ellipse, and contact conditions in
one unknown each. Sliding at contacts is changed by increments, so that contacts that stick lose no accuracy.
There are N balls in a chain with C contacts each. Velocities are divided by the carriage's speed, forces by the largest
friction bound of a ball. The unknowns of a ball are its motion x = (v, R omega_x, R omega_y), with the ball radius R, and
one for its contact with the next ball (z of ``ChainSearchState``).
"""

from math import exp, log, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.lowfi.friction.contact.laws import cubic_friction_force_factor, linear_friction_force_factor
from rollbench.lowfi.friction.linear import bearing as linear_bearing

Array = NDArray[Any]


class ChainArrays(NamedTuple):
    """Contacts, friction and neighbours of N balls of one row in a linear bearing, with C contacts each."""

    #: Five values for each contact (N, C, 5): direction n_x, n_y from the ball's centre; speed of the body in contact, 0
    #: for the rail, 1 or -1 (the sign of its speed) for the carriage; friction bound; semi-axis a divided by the ball
    #: radius.
    contacts: Array
    #: Constants (b/a, q0, k1, k3) of the formulas for the friction of a contact (4,), see `contact_friction_constants`.
    friction_constants: Array
    #: 1 where balls k and k + 1 are near enough to touch, else 0 (N - 1,).
    can_touch_next: Array
    #: Coefficient of friction between two balls.
    mu: float
    #: Stiffness of weak springs that draw the motion of each ball to the nominal motion (N,).
    holding_stiffness: Array
    #: Motion (N, 3) of balls that roll at the nominal contact angle: velocity, and ball radius times two spins, divided by
    #: the carriage's speed.
    nominal_motion: Array


class ChainSearchState(NamedTuple):
    """Motion of N balls in a linear bearing during a search, sliding at their contacts, and forces between neighbours.

    All values are changed by increments, so that no accuracy is lost where contacts stick.
    """

    #: For each contact with the grooves: sliding speed along the track, and semi-axis a times spin (N, C, 2).
    groove_contact_slips: Array
    #: For balls k and k + 1: speed at which they approach each other, and two components of their sliding on each other (N
    #: - 1, 3).
    ball_to_ball_slips: Array
    #: Motion of the balls (velocity, and ball radius times two spins, divided by the carriage's speed) less the nominal
    #: motion (N, 3).
    motion_less_nominal: Array
    #: Unknown z of each ball-to-ball contact (N - 1,): where z > 0, the contact force; where z < 0, the rate at which the
    #: gap opens, with a minus sign.
    ball_to_ball_unknowns: Array


class EquationSmoothing(NamedTuple):
    """Parameters by which the equations are smoothed: Coulomb friction, and the contact condition of neighbours."""

    #: Regularising speed of friction: at sliding speeds far below it, friction is proportional to the sliding speed instead
    #: of equal to the friction bound.
    regularising_speed: float
    #: Fraction of the friction between balls that acts, 0 to 1.
    ball_friction_fraction: float
    #: Product of the force between two neighbouring balls and the opening rate of their gap; zero for exact
    #: complementarity.
    force_rate_product: float
    #: Stiffness of springs that draw the balls to nominal rolling, to which ``holding_stiffness`` of `ChainArrays` is
    #: added.
    spring_stiffness: float


class NewtonArrays(NamedTuple):
    """Work arrays for Newton's method on a row of N balls with four unknowns each."""

    #: Jacobian of the equations, stored as a band (4 N, 11).
    jacobian_band: Array
    #: Residual of the equations (4 N,).
    residual: Array
    #: Newton step of the unknowns (4 N,).
    step: Array
    #: Second right-hand side of the linear system with the Jacobian, which is solved together with the Newton step (4 N,).
    second_right_hand_side: Array


#: Half bandwidth of the Jacobian, and columns in which it is stored.
HALF, WIDTH = 5, 11


def solve_two_banded_systems(K: Array, x: Array, y: Array) -> float:
    """Solve two linear systems with one matrix (n, 11), in place; return the sign of its determinant."""
    n = x.size
    full = np.zeros((n, n))
    for k in range(WIDTH):
        i = np.arange(max(0, HALF - k), min(n, n + HALF - k))
        full[i, i + k - HALF] = K[i, k]
    sign = float(np.linalg.slogdet(full)[0])
    x[:], y[:] = np.linalg.solve(full, np.column_stack([x, y])).T
    return sign


def slide_and_spin_friction(s: float, w: float, shape: Array) -> tuple[float, float, float, float, float]:
    """Return force and moment of friction of one sliding and spinning elliptical contact, with their derivatives.

    s: sliding speed along the minor axis; w: semi-axis a times spin (s and w must not both be zero); shape (4,):
    constants (b/a, q0, k1, k3), see `contact_friction_constants`. All results are divided by the friction bound: the
    force f and the moment m over a, which are the derivatives of the dissipation s f + w m by s and by w, and then the
    second derivatives of the dissipation by s s, s w and w w.
    """
    ratio, q0, k1, k3 = shape
    if abs(s) >= abs(w):  # the centre of rotation lies outside the ellipse
        d = dissipation_ratio(1.0, ratio, np.array([0.0, s, w]), 0.0)
        return (
            float(d.gradient[1]),
            float(d.gradient[2]),
            float(d.hessian[1, 1]),
            float(d.hessian[1, 2]),
            float(d.hessian[2, 2]),
        )
    # t = c/a: closed form of `contact_friction_constants`, and its derivatives
    t, sign = s / w, 1.0 if w > 0.0 else -1.0
    h = (k1 - 3.0 * k3 * t * t) / abs(w)
    return sign * t * (k1 - k3 * t * t), sign * (q0 - t * t * (0.5 * k1 - 0.75 * k3 * t * t)), h, -h * t, h * t * t


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


def write_contact_slips(chain: ChainArrays, point: ChainSearchState) -> None:
    """Compute sliding and spin at all contacts from the motions of the balls, and write them to ``point``.

    chain: contacts and nominal motion of the N balls; point: search state, whose field ``motion_less_nominal`` gives
    the motions, and whose fields ``groove_contact_slips`` and ``ball_to_ball_slips`` are written.
    """
    point.groove_contact_slips[:, :, 0] = -chain.contacts[:, :, 2]
    point.groove_contact_slips[:, :, 1] = 0.0
    point.ball_to_ball_slips[:] = 0.0
    _add_contact_slips(chain.contacts, point, chain.nominal_motion + point.motion_less_nominal)


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


def reset_open_gaps(point: ChainSearchState, eps: float) -> None:
    """Set the unknown z of every open gap to minus the gap's opening rate divided by the regularising speed eps.

    The equations with exact complementarity need this unit; in the smoothed equations the rate is divided by the
    carriage's speed.
    """
    for k in range(point.ball_to_ball_unknowns.shape[0]):
        if point.ball_to_ball_unknowns[k] <= 0.0:
            point.ball_to_ball_unknowns[k] = min(0.0, point.ball_to_ball_slips[k, 0] / eps)


def copy_chain_state(point: ChainSearchState) -> ChainSearchState:
    """Return a copy of the motions and forces of the balls in ``point``."""
    return ChainSearchState(
        point.groove_contact_slips.copy(),
        point.ball_to_ball_slips.copy(),
        point.motion_less_nominal.copy(),
        point.ball_to_ball_unknowns.copy(),
    )


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


def largest_entry(x: Array) -> float:
    """Return the largest absolute value of the entries of x; nan if one of them is nan."""
    size = 0.0
    for i in range(x.shape[0]):
        if not abs(x[i]) <= size:
            size = abs(x[i])
    return size


def _largest_step_fraction(step: Array) -> float:
    """Return the largest fraction, up to 1, of a Newton step (4 N,) that changes no velocity by more than ``LONGEST``."""
    return float(LONGEST / max(LONGEST, np.max(np.abs(step.reshape(-1, 4)[:, :3]))))


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
    K, g, step, other = work
    write_chain_equations(chain, point, law, K, g)
    size, damping = sqrt(np.dot(g, g)), 0.0
    for iteration in range(limit):
        if largest_entry(g) <= tolerance:
            return iteration, largest_entry(g)
        for i in range(g.shape[0]):
            if i % 4 != 3:
                K[i, HALF] += damping
        step[:] = -g
        solve_two_banded_systems(K, step, other)
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


def solve_by_undamped_newton(
    chain: ChainArrays, point: ChainSearchState, law: EquationSmoothing, work: NewtonArrays, tolerance: float, limit: int
) -> tuple[int, float]:
    """Solve the equations of a row of balls by undamped Newton steps.

    Damping by the residual would fail at kinks, where the residual rises before it falls. ``point`` is the start and is
    overwritten; law: smoothing of the equations; ``work``: work arrays. The search ends when the largest residual is at
    most ``tolerance``, or after ``limit`` steps; if the residual is then not below that at the start, ``point`` is set
    back to the start. Returns the number of steps and the largest residual.
    """
    K, g, step, other = work
    write_chain_equations(chain, point, law, K, g)
    start, kept = largest_entry(g), copy_chain_state(point)
    for iteration in range(limit):
        step[:] = -g
        solve_two_banded_systems(K, step, other)
        apply_newton_step(chain, point, step, _largest_step_fraction(step))
        write_chain_equations(chain, point, law, K, g)
        if largest_entry(g) <= tolerance:
            return iteration + 1, largest_entry(g)
    if not largest_entry(g) < start:
        restore_chain_state(point, kept)
        return limit, start
    return limit, largest_entry(g)


#: Regularising speed of friction at the beginning of the solution path, divided by the carriage's speed.
FIRST = 0.1

#: Largest residual of the equations at a point that counts as on the solution path, and largest number of Newton steps from
#: a predicted point back to the path.
ON_PATH, STEPS = 1e-9, 7

#: Step of the path parameter s in the finite difference for derivatives of the residual by s.
DIFFERENCE = 1e-6

#: Distance by which a point may always be corrected towards the solution path, also for short steps along the path: at
#: folds, a point with the accepted residual may lie as far as this from the path.
NEAR = 1e-4

#: Length of the first step along the solution path; shortest length of a step; length below which the path may turn at a
#: kink.
LENGTH, SHORTEST, KINK = 0.05, 1e-9, 1e-5


def smoothing_on_solution_path(s: float, eps: float) -> EquationSmoothing:
    """Return how much the equations are smoothed at parameter s of the solution path, 0 to 1.

    As s increases, the friction between balls rises to its full value, early on the path, and the regularising speed of
    friction falls to ``eps``, which it reaches at s = 1. Balls that could move without resistance are held by weak springs,
    whose stiffness falls too.
    """
    rest = (1.0 - s) ** 4
    creep = FIRST * exp(s * log(eps / FIRST))
    return EquationSmoothing(creep, 1.0 - rest * rest, 1e-3 * exp(s * log(1e-11)), 1e-2 * exp(s * log(1e-7)))


def determinant_sign_without_ball_friction(point: ChainSearchState) -> float:
    """Return the sign of the Jacobian's determinant for a row of N balls without friction between them.

    The problem is then convex, and only the rows of the N - 1 gaps and the unused last row change the sign, each once.
    point: unknowns of the chain, which give N.
    """
    return 1.0 if point.motion_less_nominal.shape[0] % 2 == 0 else -1.0


def _write_path_tangent(
    chain: ChainArrays, point: ChainSearchState, s: float, eps: float, work: NewtonArrays, change: Array, tau: Array
) -> float:
    """Write the tangent of the solution path at a point to tau; return 1 if the path goes on along tau, -1 if against it.

    s: parameter of the path at the point; eps: regularising speed of friction at the end of the path, divided by the
    carriage's speed; tau (4 N + 1,): tangent of unit length, with four components for each ball and last that of s,
    which is positive; change (4 N,): derivative of the residual by s. tau and change are overwritten. ``work`` must
    contain the equations at the point.
    """
    K, g, _, other = work
    write_chain_equations(chain, point, smoothing_on_solution_path(s + DIFFERENCE, eps), K.copy(), other)
    n = g.shape[0]
    for i in range(n):
        change[i] = (other[i] - g[i]) / DIFFERENCE
        tau[i] = -change[i]
        other[i] = 0.0
    tau[n] = 1.0
    sign = solve_two_banded_systems(K, tau[:n], other)
    tau /= sqrt(np.dot(tau, tau))
    return sign * determinant_sign_without_ball_friction(point)


def _correct_to_solution_path(
    chain: ChainArrays,
    point: ChainSearchState,
    s: float,
    eps: float,
    work: NewtonArrays,
    change: Array,
    tau: Array,
    length: float,
    fixed: bool,
) -> tuple[bool, int, float]:
    """Move a predicted point back to the solution path by Newton steps.

    The steps are normal to the tangent tau or, if ``fixed``, at constant s. s: parameter of the path at the point; eps:
    regularising speed of friction at the end of the path, divided by the carriage's speed; change (4 N,): derivative of
    the residual by s; length: length of the step along the path that led to the point. The correction is given up where
    it exceeds most of this length, because it may lead to another path. Returns whether the point is on the path, the
    number of Newton steps, and the parameter s there.
    """
    K, g, step, other = work
    n, moved = g.shape[0], 0.0
    for newton in range(STEPS + 1):
        law = smoothing_on_solution_path(s, eps)
        write_chain_equations(chain, point, law, K, g)
        if largest_entry(g) <= max(ON_PATH, 1e-5 * law.regularising_speed):
            return True, newton, s
        step[:] = -g
        other[:] = -change
        solve_two_banded_systems(K, step, other)
        ds = 0.0 if fixed else -np.dot(tau[:n], step) / (tau[n] + np.dot(tau[:n], other))
        step += ds * other
        moved += sqrt(np.dot(step, step) + ds * ds)
        if newton == STEPS or not moved <= 0.7 * max(length, NEAR):
            break
        apply_newton_step(chain, point, step, 1.0)
        s += ds
    return False, STEPS, s


def _longest_path_step(tau: Array) -> float:
    """Return the longest step along the solution path that changes no velocity by more than 0.5, and s by no more than 0.1.

    tau (4 N + 1,): tangent of the path, with four components for each ball and the last one for the path parameter s.
    Velocities are divided by the carriage's speed.
    """
    n = tau.shape[0] - 1
    return float(1.0 / max(abs(tau[n]) / 0.1, np.max(np.abs(tau[:n].reshape(-1, 4)[:, :3])) / 0.5))


def follow_solution_path(
    chain: ChainArrays, point: ChainSearchState, eps: float, work: NewtonArrays, limit: int
) -> tuple[int, bool]:
    """Follow the path of solutions from a point near its beginning, while friction between balls rises to its full value.

    Returns the number of Newton steps, and whether the end of the path was reached. The parameter s of the path does
    not always rise along it: where s turns, the Jacobian's determinant changes sign, and this sign therefore tells in
    which direction the path goes on. ``point`` is overwritten; eps: regularising speed of friction at the end of the
    path, divided by the carriage's speed; limit: number of Newton steps after which no further step along the path is
    taken.
    """
    n: int = work.residual.shape[0]
    change, tau, ahead = np.zeros(n), np.zeros(n + 1), np.zeros(n + 1)
    total, left = solve_by_semismooth_newton(
        chain, point, smoothing_on_solution_path(0.0, eps), work, 0.1 * ON_PATH, 100, 1.0
    )
    if not left <= ON_PATH:
        return total, False
    _write_path_tangent(chain, point, 0.0, eps, work, change, tau)
    kept = copy_chain_state(point)
    s, length = 0.0, LENGTH
    while total < limit and length > SHORTEST:
        length = min(length, _longest_path_step(tau))
        last = s + length * tau[n] >= 1.0
        if last:
            length = (1.0 - s) / tau[n]
        apply_newton_step(chain, point, tau, length)
        good, used, found = _correct_to_solution_path(
            chain, point, s + length * tau[n], eps, work, change, tau, length, last
        )
        total += used
        if good and last:
            return total, True
        if good and -0.01 < found < 1.0:
            ahead *= _write_path_tangent(chain, point, found, eps, work, change, ahead)
            total += 1
            good = np.dot(tau, ahead) > 0.5 or length < KINK
        else:
            good = False
        if good:
            restore_chain_state(kept, point)
            tau[:], s = ahead, found
            length *= 2.0 if used < 3 else (1.3 if used == 3 else 0.8)
        else:
            restore_chain_state(point, kept)
            length *= 0.4
    return total, False


#: Stiffness of springs towards nominal rolling, divided by the regularising speed; they hold motions without resistance in
#: all solutions before the last one.
SPRING = 1e-3

#: Product of ball-to-ball force and opening rate of the gap in the first, smoothed solution, which shows which balls press
#: on each other.
ROUND = 1e-3

#: Friction between balls (coefficient times root of the number of contacts between balls): value up to which Newton's
#: method may be tried without following the solution path, and value up to which it may take more than ``FEW`` steps at one
#: regularising speed. Above these values Newton's method at times found another solution. Forces of N - 1 contacts that
#: push at random add up like the root of their number.
LARGE, SLIGHT = 0.8, 0.3

#: Number of loaded contacts of a ball below which it has a motion without resistance.
SUPPORTS = 3

#: Largest stiffness that damps velocities in the last solution, and largest number of undamped Newton steps there.
FIRMEST, LEAPS = 1.0, 20

#: Largest residual that counts as converged while the regularising speed falls, and largest number of Newton steps at each
#: such speed: where friction between balls is large, and where it is not.
COARSE, FEW, MANY = 1e-6, 8, 60


def _solve_without_ball_friction(chain: ChainArrays, point: ChainSearchState, work: NewtonArrays) -> int:
    """Solve for the motion of a row of balls without friction between them; return the number of Newton steps.

    The regularising speed of friction is ``FIRST``. The search begins from the ``motion_less_nominal`` of ``point``;
    ``point`` is overwritten by the solution.
    """
    write_contact_slips(chain, point)
    total = 0
    for smooth in (ROUND, 0.0):
        law = EquationSmoothing(FIRST, 0.0, smooth, SPRING * FIRST)
        used, _ = solve_by_semismooth_newton(chain, point, law, work, 1e-10, 200, FIRMEST)
        total += used
    return total


def _all_balls_supported(contacts: Array) -> bool:
    """Return whether every ball has at least ``SUPPORTS`` contacts with the grooves that carry load."""
    return bool(np.min((contacts[:, :, 3] > 0.0).sum(axis=1)) >= SUPPORTS)


def _solve_at_falling_regularising_speed(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps_end: float, share: float, limit: int
) -> tuple[int, bool]:
    """Solve for the motion of a row of balls while the regularising speed of friction falls from ``FIRST`` to ``eps_end``.

    Each solution is the start of the next. share: fraction of the friction between balls that acts, 0 to 1; limit: most
    Newton steps at one regularising speed. Returns the number of Newton steps, and whether the search converged at
    every regularising speed and the sign of the Jacobian's determinant at the end is that of the convex problem without
    friction between balls; another sign indicates another branch of solutions.
    """
    total, eps = 0, FIRST
    while True:
        reset_open_gaps(point, eps)
        used, left = solve_by_semismooth_newton(
            chain, point, EquationSmoothing(eps, share, 0.0, SPRING * eps), work, COARSE, limit, 0.0
        )
        total += used
        if not left <= COARSE:
            return total, False
        if eps <= eps_end:
            break
        eps = max(eps_end, 0.1 * eps)
    return total, solve_two_banded_systems(
        work.jacobian_band, work.step, work.second_right_hand_side
    ) == determinant_sign_without_ball_friction(point)


def solve_motion_of_ball_row(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps: float, tolerance: float, limit: int
) -> tuple[int, float]:
    """Solve for the motion of a row of balls in a linear bearing and the forces between them.

    ``point``: its ``motion_less_nominal`` gives the motions from which the search begins; ``point`` is overwritten by
    the solution. eps: regularising speed of friction in the result; tolerance: largest residual aimed at; limit:
    largest number of Newton steps in `follow_solution_path`. The first search is for the motion without friction
    between balls, a convex problem with one solution, from which all other searches start. Newton's method then finds
    the motion with this friction while the regularising speed falls. If friction between balls may cause several
    solutions, or if Newton's method does not converge, `follow_solution_path` is used instead, unless all balls
    separate without that friction. Returns the number of Newton steps and the largest residual.
    """
    total = _solve_without_ball_friction(chain, point, work)
    first = copy_chain_state(point)
    share = chain.mu * sqrt(point.ball_to_ball_unknowns.shape[0])
    good = chain.mu == 0.0 or (share <= LARGE and _all_balls_supported(chain.contacts))
    if good:
        used, good = _solve_at_falling_regularising_speed(chain, point, work, eps, 1.0, FEW if share > SLIGHT else MANY)
        total += used
    if not good:
        restore_chain_state(point, first)
        used, good = _solve_at_falling_regularising_speed(chain, point, work, eps, 0.0, MANY)
        total += used
        good = good and not np.any(point.ball_to_ball_unknowns > 0.0)
    if not good:
        restore_chain_state(point, first)
        used, _ = follow_solution_path(chain, point, eps, work, limit)
        total += used
        reset_open_gaps(point, eps)
    used, residual = _solve_exact_equations(chain, point, work, eps, tolerance)
    return total + used, residual


def _solve_exact_equations(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps: float, tolerance: float
) -> tuple[int, float]:
    """Solve the equations of a row of balls with all friction between balls and exact contact conditions, from ``point``.

    eps: regularising speed of friction; tolerance: largest residual at which the search ends. Returns the number of
    Newton steps and the largest residual.
    """
    exact = EquationSmoothing(eps, 1.0, 0.0, 0.0)
    total, residual = solve_by_semismooth_newton(chain, point, exact, work, tolerance, 100, FIRMEST)
    if residual > tolerance:
        used, residual = solve_by_undamped_newton(chain, point, exact, work, tolerance, LEAPS)
        total += used
    return total, residual


#: Regularising speed over the carriage's, residual aimed at, stiffness that holds free motions, largest number of steps.
CREEP, TOLERANCE, HOLD, LIMIT = 1e-8, 1e-12, 1e-11, 50_000


def contact_friction_constants(bearing: linear_bearing.LinearBearing) -> Array:
    """Constants (b/a, q0, k1, k3): force k1 t - k3 t^3, moment q0 - k1 t^2/2 + 3 k3 t^4/4 at the centre of rotation t a."""
    constants = bearing.contact_hertz_constants()
    ratio = float(constants.C_b / constants.C_a)
    q0 = 0.375 * linear_bearing.elliptic_integral_second_kind(ratio)
    return np.array([ratio, q0, linear_friction_force_factor(ratio), cubic_friction_force_factor(ratio)])


def chain_by_oracle(
    bearing: linear_bearing.LinearBearing, angles: Array, loads: Array, touching: Array
) -> tuple[Array, Array, float]:
    """Velocities over the carriage's (N,), forces over the largest friction bound of a ball (N-1,), and the residual."""
    count, sign = len(angles), float(np.sign(bearing.speed))
    bounds = loads / loads.sum(axis=1).max()
    contacts = np.empty((count, 4, 5))
    contacts[..., :2] = linear_bearing.contact_directions(angles)
    contacts[..., 2], contacts[..., 3] = linear_bearing.MOVING * sign, bounds
    contacts[..., 4] = linear_bearing.contact_semi_axes(bearing, loads)[0] / bearing.ball_radius
    nominal = np.tile(np.array([0.5, 0.5 / np.cos(bearing.contact_angle), 0.0]) * sign, (count, 1))
    shape, hold = contact_friction_constants(bearing), HOLD * np.maximum(bounds.sum(axis=1), HOLD)
    chain = ChainArrays(contacts, shape, touching.astype(float), bearing.mu_balls, hold, nominal)
    n = 4 * count
    point = ChainSearchState(np.zeros((count, 4, 2)), np.zeros((count - 1, 3)), np.zeros((count, 3)), np.zeros(count - 1))
    work = NewtonArrays(np.empty((n, WIDTH)), np.empty(n), np.empty(n), np.zeros(n))
    _, residual = solve_motion_of_ball_row(chain, point, work, CREEP, TOLERANCE, LIMIT)
    return (nominal + point.motion_less_nominal)[:, 0], np.maximum(point.ball_to_ball_unknowns, 0.0), residual
