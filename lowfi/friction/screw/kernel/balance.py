"""Force balance of many moving balls with friction and ball-to-ball contact, solved by Newton's method.

The module also computes the relative motion at the contacts of balls with grooves and with each other, friction and losses.
Motions x (N, 4) are the balls' surface speeds (orbit, and spins about x3, y3, z3) over the speed of the nut along the path;
eps is the regularising speed over the same speed. Ball-to-ball forces f (N,) act from ball k on ball k + 1, in the unit of
force of ``BallArrays``.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.friction.screw.kernel_types import BalanceResiduals, BallArrays, GrooveArrays
from rollbench.lowfi.jit import CONTACT, is_compiled_module, kernel, load_kernel_package

# the kernels of one contact, compiled where these are
_OTHER = load_kernel_package(CONTACT, compiled=is_compiled_module(__name__))

dissipation, least_dissipation = _OTHER.dissipation, _OTHER.least_dissipation

evaluate_dissipation = _OTHER.evaluate_dissipation

hertz_contact, solve_with_pivots, ROLLING = _OTHER.hertz_contact, _OTHER.solve_with_pivots, _OTHER.ROLLING


@kernel
def write_semi_axes(force: Array, C_a: Array, C_b: Array, a: Array, b: Array) -> None:
    """Write the semi-axes of the Hertz contact ellipses of N balls to a and b (N, 4) [m].

    force (N, 4): contact forces [N]; C_a, C_b (4,): Hertz constants of the semi-axes [m/N^(1/3)]. A contact without
    load gets an ellipse of vanishing, but not zero size.
    """
    least = max(1e-9 * np.max(force), 1e-30)
    for k in range(force.shape[0]):
        for i in range(4):
            cube = max(force[k, i], least) ** (1.0 / 3.0)
            a[k, i], b[k, i] = C_a[i] * cube, C_b[i] * cube


@kernel
def write_contact_map(groove: GrooveArrays, n_x: float, n_z: float, out: Array) -> None:
    """Write to out (3, 4) the matrix that converts a ball's motion to sliding and spin at one contact.

    Rows: sliding vx across the groove and vz along the path [m/s], and spin [rad/s]. Columns: motion of the ball (orbit
    and three spins) as surface speeds divided by the nut's speed along the path. groove: geometry of the grooves; n_x,
    n_z: contact normal along x3 (radial) and z3 (binormal).
    """
    affine = groove.contact_map_coefficients
    for r in range(3):
        for j in range(4):
            out[r, j] = affine[0, r, j] + n_x * affine[1, r, j] + n_z * affine[2, r, j]


@kernel
def relative_contact_motion(groove: GrooveArrays, i: int, rows: Array, x: Array) -> tuple[float, float, float]:
    """Return sliding vx, vz [m/s] and spin [rad/s] of a ball relative to the groove at its contact i.

    vx is across the groove, vz along the path. groove: geometry of the grooves; i: number of the contact; rows (3, 4):
    map of the contact (`write_contact_map`); x (4,): motion of the ball, surface speeds divided by the nut's speed
    along the path.
    """
    orbit = x[0] - groove.body_rotation[i]
    return (
        rows[0, 0] * orbit + rows[0, 1] * x[1] + rows[0, 2] * x[2] + rows[0, 3] * x[3],
        rows[1, 0] * orbit + rows[1, 1] * x[1] + rows[1, 2] * x[2] + rows[1, 3] * x[3],
        rows[2, 0] * orbit + rows[2, 1] * x[1] + rows[2, 2] * x[2] + rows[2, 3] * x[3],
    )


@kernel
def write_contact_friction(balls: BallArrays, x: Array, eps: float, motion: Array, pull: Array, loss: Array) -> None:
    """Write relative motion, friction and loss at every contact of N balls with the grooves, for given ball motions.

    x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along the path;
    eps: regularising speed divided by the same speed. Written are motion (N, 4, 3), sliding along x, z and spin about y
    in the contacts' axes, divided by the same speed; pull (N, 4, 3), friction on the balls along and about the same
    axes, in the unit of force of ``balls``; loss (N, 4), force times motion in these units.
    """
    shape, maps, drives = balls.semi_axes_and_bound, balls.contact_motion_maps, balls.imposed_contact_motions
    for k in range(x.shape[0]):
        for i in range(4):
            strength = shape[k, i, 2]
            for r in range(3):
                motion[k, i, r], pull[k, i, r] = drives[k, i, r], 0.0
                for j in range(4):
                    motion[k, i, r] += maps[k, i, r, j] * x[k, j]
            loss[k, i] = 0.0
            if strength == 0.0:
                continue
            vx, vz, spin = motion[k, i, 0], motion[k, i, 1], motion[k, i, 2]
            d = dissipation(shape[k, i, 0], shape[k, i, 1], vx, vz, spin, eps)
            pull[k, i, 0], pull[k, i, 1], pull[k, i, 2] = -strength * d.by_vx, -strength * d.by_vz, -strength * d.by_spin
            loss[k, i] = strength * (d.value - eps * d.by_speed)


@kernel
def ball_on_ball_sliding(groove: GrooveArrays, this: Array, other: Array, eps: float) -> tuple[float, float, float]:
    """Return the velocity u, v at which a ball slides on the next one, then the regularised speed sqrt(u^2 + v^2 + eps^2).

    u, v: components along two tangents of the contact. All speeds are divided by the nut's speed along the path.
    groove: geometry of the contact of two balls; this (4,): motion of the ball; other (4,): motion of the next one;
    eps: regularising speed.
    """
    first, second = groove.first_ball_surface_speeds, groove.second_ball_surface_speeds
    u, v = 0.0, 0.0
    for j in range(4):
        u += first[0, j] * this[j] - second[0, j] * other[j]
        v += first[1, j] * this[j] - second[1, j] * other[j]
    return u, v, sqrt(u * u + v * v + eps * eps)


@kernel
def write_neighbour_forces(
    groove: GrooveArrays,
    balls: BallArrays,
    x: Array,
    f: Array,
    eps: float,
    push: Array,
    slide: Array,
    on_ball: Array,
    loss: Array,
) -> None:
    """Write the forces of neighbours on N balls to on_ball (N, 3) [N], and the losses between them to loss (N,) [W].

    on_ball is in x3 (radial), y3 (along the track), z3 (binormal) and includes friction; loss[k] is that between balls
    k and k + 1. x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along
    the path; f (N,): force of ball k on ball k + 1 [N]; eps: regularising speed of friction divided by the nut's speed;
    push (2, 3), slide (2, 2, 3): directions of the force and of the two tangents as in `TouchingBallsGeometry`.
    """
    n = f.shape[0]
    on_ball[:] = 0.0
    for k in range(n):
        ahead = (k + 1) % n
        u, v, size = ball_on_ball_sliding(groove, x[k], x[ahead], eps)
        bite = balls.mu[k] * f[k] / size
        loss[k] = bite * (u * u + v * v) * groove.speed
        for r in range(3):
            on_ball[k, r] += f[k] * push[0, r] - bite * (u * slide[0, 0, r] + v * slide[0, 1, r])
            on_ball[ahead, r] += f[k] * push[1, r] + bite * (u * slide[1, 0, r] + v * slide[1, 1, r])


@kernel
def write_motions_without_neighbours(balls: BallArrays, x: Array) -> None:
    """Overwrite the motions x (N, 4) of loaded balls by those of least dissipation without forces of neighbours.

    x: orbit and three spins as surface speeds divided by the nut's speed along the path. The motions of unloaded balls
    are not changed. balls: contacts of the balls under known loads.
    """
    forces, rest, bounds, none, start = np.empty((4, 3)), np.empty(4), np.empty(2), np.zeros(4), int(np.int64(ROLLING))
    for k in range(x.shape[0]):
        if np.sum(balls.semi_axes_and_bound[k, :, 2]) > 0.0:
            least_dissipation(
                balls.semi_axes_and_bound[k],
                balls.contact_motion_maps[k],
                balls.imposed_contact_motions[k],
                none,
                start,
                x[k],
                forces,
                rest,
                bounds,
            )


#: Half bandwidth of the Jacobian, which has a block of five rows for each ball: its motion (4) and its force on the next
#: ball.
HALF = 9

#: Largest Newton step of a ball's surface speeds, as a fraction of the nut's speed along the path: farther away, friction
#: no longer gives the direction of the step.
REACH = 0.3


@kernel
def remaining_closing_rate(groove: GrooveArrays, balls: BallArrays, x: Array, k: int) -> float:
    """Return the allowed less the actual closing rate of the gap after ball k, divided by the nut's speed along the path.

    The result is the largest allowed closing rate (``balls.allowed_closing_rate``) less the actual rate at the motions
    x (N, 4), which are surface speeds divided by the nut's speed along the path.
    """
    ahead = (k + 1) % x.shape[0]
    return float(groove.closing_rate_factor * (x[ahead, 0] - x[k, 0]) + balls.allowed_closing_rate[k])


@kernel
def write_force_balance_residual(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, eps: float, parts: BalanceResiduals
) -> float:
    """Write the residuals of force balance and contact conditions to ``parts``; return the root of their sum of squares.

    x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along the path; f
    (N,): force of ball k on ball k + 1, divided by the unit of force of ``balls``; eps: regularising speed of friction
    divided by the nut's speed. Force f and remaining closing rate g of a gap (`remaining_closing_rate`) are complementary
    where Fischer-Burmeister's function f + g - sqrt(f^2 + g^2) is zero. Derivatives are written to ``parts``, too.
    """
    hold = balls.holding_stiffness
    shape = balls.semi_axes_and_bound
    maps = balls.contact_motion_maps
    drives = balls.imposed_contact_motions
    nominal = groove.nominal
    first = groove.first_ball_surface_speeds
    second = groove.second_ball_surface_speeds
    closing = groove.closing_rate_factor
    balance, comp, slopes, hessian = parts
    n = f.shape[0]
    none = np.zeros(4)
    for k in range(n):
        evaluate_dissipation(shape[k], maps[k], drives[k], none, eps, x[k], balance[k], hessian[k])
        for j in range(4):
            balance[k, j] += hold[k] * (x[k, j] - nominal[j])
            hessian[k, j, j] += hold[k]
            for q in range(j):
                hessian[k, q, j] = hessian[k, j, q]
    # what neighbours add: sliding friction and the force along the path (Lin 3.73-3.75)
    for k in range(n):
        ahead = (k + 1) % n
        u, v, size = ball_on_ball_sliding(groove, x[k], x[ahead], eps)
        bite = balls.mu[k] * max(f[k], 0.0) / size
        for j in range(4):
            balance[k, j] += bite * (u * first[0, j] + v * first[1, j])
            balance[ahead, j] -= bite * (u * second[0, j] + v * second[1, j])
        balance[k, 0] += closing * f[k]
        balance[ahead, 0] -= closing * f[k]
        comp[k], slopes[k, 0], slopes[k, 1] = f[k], 1.0, 0.0
        if balls.can_touch_next[k] > 0.0:
            left = remaining_closing_rate(groove, balls, x, k)
            size = max(sqrt(f[k] * f[k] + left * left), 1e-300)
            comp[k], slopes[k, 0], slopes[k, 1] = f[k] + left - size, 1.0 - f[k] / size, 1.0 - left / size
    return float(sqrt(np.sum(balance * balance) + np.sum(comp * comp)))


@kernel
def largest_residual(parts: BalanceResiduals) -> float:
    """Return the largest absolute value of all unbalanced forces and complementarity functions in ``parts``."""
    return float(max(np.max(np.abs(parts.unbalanced_forces)), np.max(np.abs(parts.complementarity))))


@kernel
def write_ball_to_ball_derivatives(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, slopes: Array, eps: float, k: int, out: Array
) -> None:
    """Write the derivatives of the forces between ball k and the next ball to ``out``, four blocks (4, 5, 5).

    The rows and columns of a block are a ball's motion and its force on the next ball. The blocks are those on the
    diagonal at ball k, right of it, below it, and on the diagonal at the next ball. x (N, 4): motions of the balls
    (orbit and three spins), surface speeds divided by the nut's speed along the path; f (N,): force of ball k on ball k
    + 1, divided by the unit of force of ``balls``; slopes (N, 2): derivatives of the complementarity function by force
    and by closing rate; eps: regularising speed of friction divided by the nut's speed.
    """
    first, second, closing = groove.first_ball_surface_speeds, groove.second_ball_surface_speeds, groove.closing_rate_factor
    u, v, size = ball_on_ball_sliding(groove, x[k], x[(k + 1) % f.shape[0]], eps)
    u, v = u / size, v / size
    bite = balls.mu[k] * max(f[k], 0.0) / size
    sliding = balls.mu[k] if f[k] > 0.0 else 0.0
    out[:] = 0.0
    for j in range(4):
        one, two = u * first[0, j] + v * first[1, j], u * second[0, j] + v * second[1, j]
        for q in range(4):
            r_one, r_two = u * first[0, q] + v * first[1, q], u * second[0, q] + v * second[1, q]
            # I - t t^T between the sliding directions, t the direction of sliding: by the motion of first and second
            ff = first[0, j] * first[0, q] + first[1, j] * first[1, q] - one * r_one
            fs = first[0, j] * second[0, q] + first[1, j] * second[1, q] - one * r_two
            sf = second[0, j] * first[0, q] + second[1, j] * first[1, q] - two * r_one
            ss = second[0, j] * second[0, q] + second[1, j] * second[1, q] - two * r_two
            out[0, j, q], out[1, j, q], out[2, j, q], out[3, j, q] = bite * ff, -bite * fs, -bite * sf, bite * ss
        out[0, j, 4], out[2, j, 4] = sliding * one, -sliding * two  # column 4: by the force between the balls
    out[0, 0, 4] += closing
    out[2, 0, 4] -= closing
    # row 4: Fischer-Burmeister function by gap and force
    out[0, 4, 0], out[1, 4, 0] = -closing * slopes[k, 1], closing * slopes[k, 1]
    out[0, 4, 4] = slopes[k, 0]


@kernel
def write_force_balance_jacobian(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, parts: BalanceResiduals, eps: float, start: int, K: Array
) -> None:
    """Write the banded Jacobian of the force balance of N balls to K (5 N, 3 HALF + 1), half bandwidth HALF.

    x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along the path; f
    (N,): force of ball k on ball k + 1, divided by the unit of force of ``balls``; eps: regularising speed of friction
    divided by the nut's speed; parts: derivatives that `write_force_balance_residual` has written at x and f; start: ball
    whose rows come first. The closed track is cut open before ball start: its coupling with the last ball is left out. K
    has the form that `solve_with_pivots` needs.
    """
    n, out = f.shape[0], np.empty((4, 5, 5))
    K[:] = 0.0
    for k in range(n):
        row = 5 * ((k - start) % n)
        for i in range(4):
            for j in range(4):
                K[row + i, HALF + j - i] += parts.dissipation_hessian[k, i, j]
        write_ball_to_ball_derivatives(groove, balls, x, f, parts.complementarity_slopes, eps, k, out)
        last = row == 5 * (n - 1)
        other = 0 if last else row + 5
        for i in range(5):
            for j in range(5):
                K[row + i, HALF + j - i] += out[0, i, j]
                K[other + i, HALF + j - i] += out[3, i, j]
                if not last:
                    K[row + i, HALF + 5 + j - i] += out[1, i, j]
                    K[other + i, HALF - 5 + j - i] += out[2, i, j]


@kernel
def ball_after_open_gap(groove: GrooveArrays, balls: BallArrays, x: Array, f: Array) -> int:
    """Return the number of the ball after the widest open gap, where the equations of a closed track are cut open.

    For this gap the remaining closing rate (`remaining_closing_rate`) exceeds the ball-to-ball force by the largest amount,
    both in the scaled units of the kernels. x (N, 4): motions of the balls (orbit and three spins), surface speeds divided
    by the nut's speed along the path; f (N,): force of ball k on ball k + 1, divided by the unit of force of ``balls``.
    """
    start, most = 0, -np.inf
    for k in range(f.shape[0]):
        left = remaining_closing_rate(groove, balls, x, k) - f[k] if balls.can_touch_next[k] > 0.0 else np.inf
        if left > most:
            start, most = (k + 1) % f.shape[0], left
    return start


@kernel
def write_balance_newton_step(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, parts: BalanceResiduals, eps: float, dx: Array, df: Array
) -> None:
    """Write Newton's step of the ball motions to dx (N, 4) and of the ball-to-ball forces to df (N,).

    x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along the path; f
    (N,): force of ball k on ball k + 1, divided by the unit of force of ``balls``; eps: regularising speed of friction
    divided by the nut's speed; parts: residuals and derivatives that `write_force_balance_residual` has written at x and f.
    """
    n, start = f.shape[0], ball_after_open_gap(groove, balls, x, f)
    K, side = np.empty((5 * n, 3 * HALF + 1)), np.empty((5 * n, 1))
    write_force_balance_jacobian(groove, balls, x, f, parts, eps, start, K)
    for k in range(n):
        row = 5 * ((k - start) % n)
        for j in range(4):
            side[row + j, 0] = -parts.unbalanced_forces[k, j]
        side[row + 4, 0] = -parts.complementarity[k]
    solve_with_pivots(K, side, HALF)
    for k in range(n):
        row = 5 * ((k - start) % n)
        for j in range(4):
            dx[k, j] = side[row + j, 0]
        df[k] = side[row + 4, 0]


@kernel
def solve_force_balance_of_balls(
    groove: GrooveArrays,
    balls: BallArrays,
    x: Array,
    f: Array,
    eps: float,
    goal: float,
    near: float,
    limit: int,
    parts: BalanceResiduals,
) -> tuple[float, int]:
    """Solve the force balance of N balls by Newton's method at one regularising speed; return residual and number of steps.

    x (N, 4): motions of the balls (orbit and three spins), surface speeds divided by the nut's speed along the path; f
    (N,): force of ball k on ball k + 1, divided by the unit of force of ``balls``; x and f are the start and are
    overwritten by the solution; eps: regularising speed of friction divided by the nut's speed; ``parts`` is
    overwritten by residuals and derivatives at the solution. A step is halved until the residual falls. The iteration
    ends when the residual (root of the sum of squares) is at most ``goal``, after ``limit`` steps, or when no step lets
    the residual fall; below a residual of ``near``, where round-off may be the reason, few halvings are tried.
    """
    n, dx, df = f.shape[0], np.empty_like(x), np.empty_like(f)
    size = write_force_balance_residual(groove, balls, x, f, eps, parts)
    trial = BalanceResiduals(np.empty((n, 4)), np.empty(n), np.empty((n, 2)), np.empty((n, 4, 4)))
    for count in range(limit):
        if size <= goal:
            return size, count
        write_balance_newton_step(groove, balls, x, f, parts, eps, dx, df)
        length, new, better = min(1.0, REACH / max(np.max(np.abs(dx)), 1e-300)), size, False
        for _ in range(3 if size <= near else 25):
            new = write_force_balance_residual(groove, balls, x + length * dx, f + length * df, eps, trial)
            if new < (1.0 - 0.1 * length) * size:
                better = True
                break
            length *= 0.5
        if not better:
            return size, count + 1
        x += length * dx
        f += length * df
        size = new
        parts.unbalanced_forces[:], parts.complementarity[:] = trial.unbalanced_forces, trial.complementarity
        parts.complementarity_slopes[:] = trial.complementarity_slopes
        parts.dissipation_hessian[:] = trial.dissipation_hessian
    return size, limit
