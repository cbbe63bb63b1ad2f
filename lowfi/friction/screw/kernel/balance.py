"""Balance of many balls in motion with ball-to-ball contact as a complementarity problem, and Newton's method on it.

Also relative motion at the contacts of balls with grooves and with each other, friction and losses.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.friction.screw.kernel_types import BalanceParts, BallArrays, GrooveArrays
from rollbench.lowfi.jit import CONTACT, is_compiled, kernel, kernels

_OTHER = kernels(CONTACT, compiled=is_compiled(__name__))  # the kernels of one contact, compiled where these are

dissipation, least_dissipation = _OTHER.dissipation, _OTHER.least_dissipation

evaluate_dissipation = _OTHER.evaluate_dissipation

hertz_contact, solve_with_pivots, ROLLING = _OTHER.hertz_contact, _OTHER.solve_with_pivots, _OTHER.ROLLING


@kernel
def semi_axes(force: Array, C_a: Array, C_b: Array, a: Array, b: Array) -> None:
    """Write semi-axes (N, 4) [m] of Hertz contacts of forces (N, 4) [N]; unloaded ones keep a vanishing ellipse."""
    least = max(1e-9 * np.max(force), 1e-30)
    for k in range(force.shape[0]):
        for i in range(4):
            cube = max(force[k, i], least) ** (1.0 / 3.0)
            a[k, i], b[k, i] = C_a[i] * cube, C_b[i] * cube


@kernel
def contact_map(groove: GrooveArrays, n_x: float, n_z: float, out: Array) -> None:
    """Write the map (3, 4) of a contact in direction (n_x, n_z)."""
    affine = groove.affine
    for r in range(3):
        for j in range(4):
            out[r, j] = affine[0, r, j] + n_x * affine[1, r, j] + n_z * affine[2, r, j]


@kernel
def seen(groove: GrooveArrays, i: int, rows: Array, x: Array) -> tuple[float, float, float]:
    """Return the motion (vx, vz, spin) of contact i with the map ``rows`` (3, 4) in the ball's motion x (4,)."""
    orbit = x[0] - groove.ride[i]
    return (
        rows[0, 0] * orbit + rows[0, 1] * x[1] + rows[0, 2] * x[2] + rows[0, 3] * x[3],
        rows[1, 0] * orbit + rows[1, 1] * x[1] + rows[1, 2] * x[2] + rows[1, 3] * x[3],
        rows[2, 0] * orbit + rows[2, 1] * x[1] + rows[2, 2] * x[2] + rows[2, 3] * x[3],
    )


@kernel
def friction(balls: BallArrays, x: Array, eps: float, motion: Array, pull: Array, loss: Array) -> None:
    """Write relative motions (N, 4, 3), friction on the balls (N, 4, 3) and losses (N, 4) at motions x (N, 4).

    In the contacts' axes: along x, z, about y. Motions as parts of ``speed``, forces in the unit of ``BallArrays``.
    """
    shape, maps, drives = balls.shape, balls.maps, balls.drives
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
def rubbing(groove: GrooveArrays, this: Array, other: Array, eps: float) -> tuple[float, float, float]:
    """Return the sliding (2) of a ball of motion (4,) on the next one, and its size above ``eps``."""
    first, second = groove.first, groove.second
    u, v = 0.0, 0.0
    for j in range(4):
        u += first[0, j] * this[j] - second[0, j] * other[j]
        v += first[1, j] * this[j] - second[1, j] * other[j]
    return u, v, sqrt(u * u + v * v + eps * eps)


@kernel
def meeting(
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
    """Write forces of neighbours on balls (N, 3) [N] and the losses (N,) [W] where ball k slides on k + 1.

    f (N,): forces between them [N]; push (2, 3), slide (2, 2, 3): as in ``screw_groove.PairGeometry``.
    """
    n = f.shape[0]
    on_ball[:] = 0.0
    for k in range(n):
        ahead = (k + 1) % n
        u, v, size = rubbing(groove, x[k], x[ahead], eps)
        bite = balls.mu[k] * f[k] / size
        loss[k] = bite * (u * u + v * v) * groove.speed
        for r in range(3):
            on_ball[k, r] += f[k] * push[0, r] - bite * (u * slide[0, 0, r] + v * slide[0, 1, r])
            on_ball[ahead, r] += f[k] * push[1, r] + bite * (u * slide[1, 0, r] + v * slide[1, 1, r])


@kernel
def move_without_neighbours(balls: BallArrays, x: Array) -> None:
    """Overwrite the motions (N, 4) of loaded balls by those of least dissipation without neighbours."""
    forces, rest, bounds, none, start = np.empty((4, 3)), np.empty(4), np.empty(2), np.zeros(4), int(np.int64(ROLLING))
    for k in range(x.shape[0]):
        if np.sum(balls.shape[k, :, 2]) > 0.0:
            least_dissipation(balls.shape[k], balls.maps[k], balls.drives[k], none, start, x[k], forces, rest, bounds)


#: Half bandwidth with a ball's motion and the force on the next in one block of five.
HALF = 9

#: Largest step of a ball's surface speeds, as a fraction of its nominal speed: further off, friction no longer gives the
#: direction.
REACH = 0.3


@kernel
def slack_left(groove: GrooveArrays, balls: BallArrays, x: Array, k: int) -> float:
    """Return the rest of the slack between ball k and the next, scaled."""
    ahead = (k + 1) % x.shape[0]
    return float(groove.closing * (x[ahead, 0] - x[k, 0]) + balls.slack[k])


@kernel
def residual(groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, eps: float, parts: BalanceParts) -> float:
    """Write ``parts`` at motions x (N, 4) and forces f (N,) from ball k to k + 1; return the root of the sum of squares.

    Complementarity by Fischer-Burmeister's function f + gap - sqrt(f^2 + gap^2).
    """
    hold, shape, maps, drives = balls.hold, balls.shape, balls.maps, balls.drives
    nominal, first, second, closing = groove.nominal, groove.first, groove.second, groove.closing
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
        u, v, size = rubbing(groove, x[k], x[ahead], eps)
        bite = balls.mu[k] * max(f[k], 0.0) / size
        for j in range(4):
            balance[k, j] += bite * (u * first[0, j] + v * first[1, j])
            balance[ahead, j] -= bite * (u * second[0, j] + v * second[1, j])
        balance[k, 0] += closing * f[k]
        balance[ahead, 0] -= closing * f[k]
        comp[k], slopes[k, 0], slopes[k, 1] = f[k], 1.0, 0.0
        if balls.allowed[k] > 0.0:
            left = slack_left(groove, balls, x, k)
            size = max(sqrt(f[k] * f[k] + left * left), 1e-300)
            comp[k], slopes[k, 0], slopes[k, 1] = f[k] + left - size, 1.0 - f[k] / size, 1.0 - left / size
    return float(sqrt(np.sum(balance * balance) + np.sum(comp * comp)))


@kernel
def worst(parts: BalanceParts) -> float:
    """Return the largest entry of balance and complementarity."""
    return float(max(np.max(np.abs(parts.balance)), np.max(np.abs(parts.complementarity))))


@kernel
def couple(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, slopes: Array, eps: float, k: int, out: Array
) -> None:
    """Write the four blocks (4, 5, 5) of the matrix for ball k and the next ball.

    Order: diagonal of k, right of it, below it, diagonal of the next.
    """
    first, second, closing = groove.first, groove.second, groove.closing
    u, v, size = rubbing(groove, x[k], x[(k + 1) % f.shape[0]], eps)
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
def jacobian(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, parts: BalanceParts, eps: float, start: int, K: Array
) -> None:
    """Write the banded Jacobian (see ``band``) of motions and forces with ball ``start`` first, cut open before it."""
    n, out = f.shape[0], np.empty((4, 5, 5))
    K[:] = 0.0
    for k in range(n):
        row = 5 * ((k - start) % n)
        for i in range(4):
            for j in range(4):
                K[row + i, HALF + j - i] += parts.hessian[k, i, j]
        couple(groove, balls, x, f, parts.slopes, eps, k, out)
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
def opening(groove: GrooveArrays, balls: BallArrays, x: Array, f: Array) -> int:
    """Return the ball after the contact that is most clearly open: there a closed track may be cut."""
    start, most = 0, -np.inf
    for k in range(f.shape[0]):
        left = slack_left(groove, balls, x, k) - f[k] if balls.allowed[k] > 0.0 else np.inf
        if left > most:
            start, most = (k + 1) % f.shape[0], left
    return start


@kernel
def step(
    groove: GrooveArrays, balls: BallArrays, x: Array, f: Array, parts: BalanceParts, eps: float, dx: Array, df: Array
) -> None:
    """Write Newton's step (N, 4), (N,)."""
    n, start = f.shape[0], opening(groove, balls, x, f)
    K, side = np.empty((5 * n, 3 * HALF + 1)), np.empty((5 * n, 1))
    jacobian(groove, balls, x, f, parts, eps, start, K)
    for k in range(n):
        row = 5 * ((k - start) % n)
        for j in range(4):
            side[row + j, 0] = -parts.balance[k, j]
        side[row + 4, 0] = -parts.complementarity[k]
    solve_with_pivots(K, side, HALF)
    for k in range(n):
        row = 5 * ((k - start) % n)
        for j in range(4):
            dx[k, j] = side[row + j, 0]
        df[k] = side[row + 4, 0]


@kernel
def newton(
    groove: GrooveArrays,
    balls: BallArrays,
    x: Array,
    f: Array,
    eps: float,
    goal: float,
    near: float,
    limit: int,
    parts: BalanceParts,
) -> tuple[float, int]:
    """Iterate by Newton's method from (x, f), overwritten, at one regularising speed.

    Steps are halved until the residual falls.

    Ends at ``goal``, after ``limit`` steps, or where round-off lets the residual, below ``near``, fall no more.
    Returns its size and the steps; ``parts`` are those of the end.
    """
    n, dx, df = f.shape[0], np.empty_like(x), np.empty_like(f)
    size = residual(groove, balls, x, f, eps, parts)
    trial = BalanceParts(np.empty((n, 4)), np.empty(n), np.empty((n, 2)), np.empty((n, 4, 4)))
    for count in range(limit):
        if size <= goal:
            return size, count
        step(groove, balls, x, f, parts, eps, dx, df)
        length, new, better = min(1.0, REACH / max(np.max(np.abs(dx)), 1e-300)), size, False
        for _ in range(3 if size <= near else 25):
            new = residual(groove, balls, x + length * dx, f + length * df, eps, trial)
            if new < (1.0 - 0.1 * length) * size:
                better = True
                break
            length *= 0.5
        if not better:
            return size, count + 1
        x += length * dx
        f += length * df
        size = new
        parts.balance[:], parts.complementarity[:] = trial.balance, trial.complementarity
        parts.slopes[:], parts.hessian[:] = trial.slopes, trial.hessian
    return size, limit
