"""Motion of a chain of balls: first without friction between balls, then with the whole of this friction.

The solution is followed along a path from the one state to the other, round the folds of the path. The path parameter s
rises from 0, without friction between balls, to 1, with all of it. The speed eps that regularises friction is in units of
the carriage's speed.

A ball-to-ball force is the sum of the axial friction on the balls behind it, so that no force on the path can exceed the
sum of the friction bounds of these balls, and the path begins at the one solution of a convex problem. The path can neither
run off to infinity nor come back: its other end is a solution with the whole friction (Leray and Schauder), whatever folds
lie between.
"""

from math import exp, log, sqrt

import numpy as np

from rollbench.lowfi.friction.linear.kernel_types import (
    Array,
    ChainArrays,
    ChainSearchState,
    EquationSmoothing,
    NewtonArrays,
)
from rollbench.lowfi.jit import kernel

from .equations import (
    apply_newton_step,
    copy_chain_state,
    largest_entry,
    reset_open_gaps,
    restore_chain_state,
    solve_by_semismooth_newton,
    solve_by_undamped_newton,
    solve_two_banded_systems,
    write_chain_equations,
    write_contact_slips,
)

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


@kernel
def smoothing_on_solution_path(s: float, eps: float) -> EquationSmoothing:
    """Return how much the equations are smoothed at parameter s of the solution path, 0 to 1.

    As s increases, the friction between balls rises to its full value, early on the path, and the regularising speed of
    friction falls to ``eps``, which it reaches at s = 1. Balls that could move without resistance are held by weak springs,
    whose stiffness falls too.
    """
    rest = (1.0 - s) ** 4
    creep = FIRST * exp(s * log(eps / FIRST))
    return EquationSmoothing(creep, 1.0 - rest * rest, 1e-3 * exp(s * log(1e-11)), 1e-2 * exp(s * log(1e-7)))


@kernel
def determinant_sign_without_ball_friction(point: ChainSearchState) -> float:
    """Return the sign of the Jacobian's determinant for a row of N balls without friction between them.

    The problem is then convex, and only the rows of the N - 1 gaps and the unused last row change the sign, each once.
    point: unknowns of the chain, which give N.
    """
    return 1.0 if point.motion_less_nominal.shape[0] % 2 == 0 else -1.0


@kernel
def _write_path_tangent(
    chain: ChainArrays, point: ChainSearchState, s: float, eps: float, work: NewtonArrays, change: Array, tau: Array
) -> float:
    """Write the tangent of the solution path at a point to tau; return 1 if the path goes on along tau, -1 if against it.

    s: parameter of the path at the point; eps: regularising speed of friction at the end of the path, divided by the
    carriage's speed; tau (4 N + 1,): tangent of unit length, with four components for each ball and last that of s,
    which is positive; change (4 N,): derivative of the residual by s. tau and change are overwritten. ``work`` must
    contain the equations at the point.
    """
    K, factors, g, _, other = work
    write_chain_equations(chain, point, smoothing_on_solution_path(s + DIFFERENCE, eps), factors, other)
    n = g.shape[0]
    for i in range(n):
        change[i] = (other[i] - g[i]) / DIFFERENCE
        tau[i] = -change[i]
        other[i] = 0.0
    tau[n] = 1.0
    sign = solve_two_banded_systems(K, factors, tau[:n], other)
    tau /= sqrt(np.dot(tau, tau))
    return sign * determinant_sign_without_ball_friction(point)


@kernel
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
    K, factors, g, step, other = work
    n, moved = g.shape[0], 0.0
    for newton in range(STEPS + 1):
        law = smoothing_on_solution_path(s, eps)
        write_chain_equations(chain, point, law, K, g)
        if largest_entry(g) <= max(ON_PATH, 1e-5 * law.regularising_speed):
            return True, newton, s
        step[:] = -g
        other[:] = -change
        solve_two_banded_systems(K, factors, step, other)
        ds = 0.0 if fixed else -np.dot(tau[:n], step) / (tau[n] + np.dot(tau[:n], other))
        step += ds * other
        moved += sqrt(np.dot(step, step) + ds * ds)
        if newton == STEPS or not moved <= 0.7 * max(length, NEAR):
            break
        apply_newton_step(chain, point, step, 1.0)
        s += ds
    return False, STEPS, s


@kernel
def _longest_path_step(tau: Array) -> float:
    """Return the longest step along the solution path that changes no velocity by more than 0.5, and s by no more than 0.1.

    tau (4 N + 1,): tangent of the path, with four components for each ball and the last one for the path parameter s.
    Velocities are divided by the carriage's speed.
    """
    n = tau.shape[0] - 1
    return float(1.0 / max(abs(tau[n]) / 0.1, np.max(np.abs(tau[:n].reshape(-1, 4)[:, :3])) / 0.5))


@kernel
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
        chain, point, smoothing_on_solution_path(0.0, eps), work, 0.1 * ON_PATH, int(np.int64(100)), 1.0
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

#: Number of starts of the search for other solutions, and force that presses pairs of balls together in one of them, over
#: the largest friction bound of a ball.
STARTS, PRESSED = 3, 3.0


@kernel
def _solve_without_ball_friction(chain: ChainArrays, point: ChainSearchState, work: NewtonArrays) -> int:
    """Solve for the motion of a row of balls without friction between them; return the number of Newton steps.

    The regularising speed of friction is ``FIRST``. The search begins from the ``motion_less_nominal`` of ``point``;
    ``point`` is overwritten by the solution.
    """
    write_contact_slips(chain, point)
    total = 0
    for smooth in (ROUND, 0.0):
        law = EquationSmoothing(FIRST, 0.0, smooth, SPRING * FIRST)
        used, _ = solve_by_semismooth_newton(chain, point, law, work, 1e-10, int(np.int64(200)), FIRMEST)
        total += used
    return total


@kernel
def _all_balls_supported(contacts: Array) -> bool:
    """Return whether every ball has at least ``SUPPORTS`` contacts with the grooves that carry load."""
    return bool(np.min((contacts[:, :, 3] > 0.0).sum(axis=1)) >= SUPPORTS)


@kernel
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
        work.jacobian_band, work.factors, work.step, work.second_right_hand_side
    ) == determinant_sign_without_ball_friction(point)


@kernel
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
        used, good = _solve_at_falling_regularising_speed(chain, point, work, eps, 0.0, int(np.int64(MANY)))
        total += used
        good = good and not np.any(point.ball_to_ball_unknowns > 0.0)
    if not good:
        restore_chain_state(point, first)
        used, _ = follow_solution_path(chain, point, eps, work, limit)
        total += used
        reset_open_gaps(point, eps)
    used, residual = _solve_exact_equations(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def solve_motion_from_other_start(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps: float, tolerance: float, limit: int, start: int
) -> tuple[int, float]:
    """Solve for motions and forces of a row of balls as `solve_motion_of_ball_row`, from one of ``STARTS`` other starts.

    eps: regularising speed of friction in the result; tolerance: largest residual aimed at; limit: largest number of
    Newton steps in `follow_solution_path`; start: 0 for the end of the path that this function follows, 1 for the balls
    as they move without friction between them, 2 for all pairs pressed together. Returns the number of Newton steps and
    the largest residual.
    """
    total = _solve_without_ball_friction(chain, point, work)
    if start == 0:
        used, _ = follow_solution_path(chain, point, eps, work, limit)
    elif start == 1:
        used, _ = _solve_at_falling_regularising_speed(chain, point, work, eps, 0.0, int(np.int64(MANY)))
    else:
        point.ball_to_ball_unknowns[:] = PRESSED * chain.can_touch_next
        used, _ = _solve_at_falling_regularising_speed(chain, point, work, eps, 1.0, int(np.int64(MANY)))
    total += used
    reset_open_gaps(point, eps)
    used, residual = _solve_exact_equations(chain, point, work, eps, tolerance)
    return total + used, residual


@kernel
def motion_from_state(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps: float, tolerance: float
) -> tuple[int, float]:
    """Solve for motions and forces of a row of balls by Newton's method, starting from the state of a similar row.

    ``point``: this state, which is overwritten by the solution; eps: regularising speed of friction; tolerance: largest
    residual aimed at. Returns the number of Newton steps and the largest residual.
    """
    reset_open_gaps(point, eps)
    return _solve_exact_equations(chain, point, work, eps, tolerance)


@kernel
def _solve_exact_equations(
    chain: ChainArrays, point: ChainSearchState, work: NewtonArrays, eps: float, tolerance: float
) -> tuple[int, float]:
    """Solve the equations of a row of balls with all friction between balls and exact contact conditions, from ``point``.

    eps: regularising speed of friction; tolerance: largest residual at which the search ends. Returns the number of
    Newton steps and the largest residual.
    """
    exact = EquationSmoothing(eps, 1.0, 0.0, 0.0)
    total, residual = solve_by_semismooth_newton(chain, point, exact, work, tolerance, int(np.int64(100)), FIRMEST)
    if residual > tolerance:
        used, residual = solve_by_undamped_newton(chain, point, exact, work, tolerance, LEAPS)
        total += used
    return total, residual
