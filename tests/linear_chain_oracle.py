"""Oracle of chains in linear bearings: the path of solutions followed exactly, by equations of its own.

Friction regularised as a whole by the dissipation of a contact, a closed form inside its ellipse, and contact conditions in
one unknown each. Sliding at contacts is changed by increments, so that contacts that stick lose no accuracy.

There are N balls in a chain with four contacts each, M = 4 N with the grooves. Velocities are divided by the carriage's
speed, forces by the largest friction bound of a ball. The unknowns are the motions x = (v, R omega_x, R omega_y) of the
balls, with the ball radius R, and one unknown z for each contact of two neighbours: where z > 0, the force; where z < 0,
the rate at which the gap opens, with a minus sign.
"""

from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.lowfi.friction.contact.laws import cubic_friction_force_factor, linear_friction_force_factor
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.meshes.arrays import Array

#: Regularising speed of friction, product of force and opening rate of a gap, and stiffness of springs that draw balls to
#: nominal rolling: at the beginning of the path, and at its end.
CREEP, SMOOTH, SPRING = (0.1, 1e-8), (1e-3, 1e-14), (1e-2, 1e-9)
#: Residual of a point on the path, and of the last one; most Newton steps back to the path, and of the first point.
ON_PATH, CLOSE, BACK, FIRST = 1e-9, 1e-12, 7, 100
#: Length of the first step along the path, of the shortest, and below which the path may turn at a kink; distance by which
#: a point may always be corrected.
LENGTH, SHORTEST, KINK, NEAR = 0.05, 1e-9, 1e-5, 1e-4
#: Largest change of a velocity in a step of the first point, and in one along the path; largest one of its parameter.
JUMP, FAR, AHEAD = 2.0, 0.5, 0.1
#: Step of the path's parameter in differences.
DIFFERENCE = 1e-6


class Chain(NamedTuple):
    """Sliding by the motions of all balls, and what acts at it."""

    #: Sliding speed ``(M, 3 N)`` along the track at the contacts with the grooves, and their semi-axes times spin.
    slide: Array
    spin: Array
    #: Speed ``(N - 1, 3 N)`` at which neighbours approach, and both components of their sliding on each other.
    closing: Array
    rub: tuple[Array, Array]
    #: Friction bounds at the grooves ``(M,)``, and constants of a contact, see `contact_friction_constants`.
    bounds: Array
    shape: Array
    mu: float

    def slips(self, x: Array) -> list[Array]:
        """All sliding by motions x ``(3 N,)``."""
        return [way @ x for way in (self.slide, self.spin, self.closing, *self.rub)]


class Point(NamedTuple):
    """Sliding, motions less those of nominal rolling and unknowns z."""

    slips: list[Array]
    drift: Array
    z: Array

    def moved(self, chain: Chain, step: Array) -> "Point":
        """The point after a step of all unknowns."""
        dx, dz = np.split(step, [self.drift.size])
        slips = [old + new for old, new in zip(self.slips, chain.slips(dx), strict=True)]
        return Point(slips, self.drift + dx, self.z + dz)


def slide_and_spin_friction(s: Array, w: Array, shape: Array, eps: float) -> tuple[Array, ...]:
    """Force, moment over a and their derivatives by s s, s w and w w, over the friction bound, of contacts that slide by s
    along the minor axis and spin by w over a: of sqrt(phi^2 + eps^2) with Coulomb's dissipation phi(s, w), so that contacts
    that stick creep."""
    ratio, q0, k1, k3 = shape
    d = dissipation_ratio(1.0, ratio, np.stack([0.0 * s, s, w], axis=1), 0.0)
    outside = d.gradient[:, 1], d.gradient[:, 2], d.hessian[:, 1, 1], d.hessian[:, 1, 2], d.hessian[:, 2, 2]
    # inside the ellipse: closed form of `contact_friction_constants` at t = c/a, and its derivatives
    inner = np.abs(s) < np.abs(w)
    turn = np.where(inner, w, 1.0)
    t, sign = np.where(inner, s, 0.0) / turn, np.sign(turn)
    h = (k1 - 3.0 * k3 * t * t) / np.abs(turn)
    inside = sign * t * (k1 - k3 * t * t), sign * (q0 - t * t * (0.5 * k1 - 0.75 * k3 * t * t)), h, -h * t, h * t * t
    f, m, ss, sw, ww = (np.where(inner, one, other) for one, other in zip(inside, outside, strict=True))
    phi = s * f + w * m
    eta = np.hypot(phi, eps)
    c, b = phi / eta, (eps / eta) ** 2 / eta
    return c * f, c * m, c * ss + b * f * f, c * sw + b * f * m, c * ww + b * m * m


def equations(chain: Chain, point: Point, s: float) -> tuple[Array, Array]:
    """Residual and Jacobian at parameter s of the path, 0 to 1.

    As s increases, the friction between balls rises to its full value, early on the path, while the regularising speed, the
    smoothing of contact conditions and the springs that hold free motions fall.
    """
    eps, smooth, spring = (first * (last / first) ** s for first, last in (CREEP, SMOOTH, SPRING))
    (slide, spin, closing, *rubs), z = point.slips, point.z
    f, m, ss, sw, ww = (chain.bounds * part for part in slide_and_spin_friction(slide, spin, chain.shape, eps))
    by_x = chain.slide.T * ss @ chain.slide + chain.spin.T * ww @ chain.spin + spring * np.eye(point.drift.size)
    by_x += (cross := chain.slide.T * sw @ chain.spin) + cross.T
    # force - rate = z, force times rate = smooth (Lin 3.30, 3.31), without the difference of nearly equal numbers
    root = np.sqrt(z * z + 4.0 * smooth)
    larger = 0.5 * (np.abs(z) + root)
    force, rate = np.where(z > 0.0, [larger, smooth / larger], [smooth / larger, larger])
    slope, share = force / root, chain.mu * (1.0 - (1.0 - s) ** 8)
    eta = np.sqrt(rubs[0] ** 2 + rubs[1] ** 2 + eps * eps)
    across = np.stack(rubs) / eta
    rubbing = sum(way.T * part for way, part in zip(chain.rub, across, strict=True))
    by_x += sum(way.T * (share * force / eta) @ way for way in chain.rub) - rubbing * (share * force / eta) @ rubbing.T
    # balance of the balls (Lin 3.25), and the rate of each gap
    balance = (
        spring * point.drift + chain.slide.T @ f + chain.spin.T @ m + chain.closing.T @ force + rubbing @ (share * force)
    )
    by_z = (chain.closing.T + share * rubbing) * slope
    return np.append(balance, closing + rate), np.block([[by_x, by_z], [chain.closing, np.diag(slope - 1.0)]])


def longest(step: Array, balls: int) -> float:
    """Largest change of a velocity in a step."""
    return float(np.abs(step[: 3 * balls]).max())


def start_of_path(chain: Chain, point: Point, balls: int) -> Point:
    """Solution without friction between balls, a convex problem, by Newton steps halved until the residual falls."""
    for _ in range(FIRST):
        g, J = equations(chain, point, 0.0)
        if np.abs(g).max() <= 0.1 * ON_PATH:
            break
        step = -np.linalg.solve(J, g)
        step *= min(1.0, JUMP / longest(step, balls))
        for _ in range(12):
            trial = point.moved(chain, step)
            if np.linalg.norm(equations(chain, trial, 0.0)[0]) < np.linalg.norm(g):
                break
            step *= 0.5
        point = trial
    return point


def tangent(chain: Chain, point: Point, s: float) -> tuple[Array, Array, float]:
    """Tangent of the path of unit length, last its component of s, which is positive; derivative of the residual by s; sign
    of the Jacobian's determinant, which changes where s turns."""
    g, J = equations(chain, point, s)
    change = (equations(chain, point, s + DIFFERENCE)[0] - g) / DIFFERENCE
    tau = np.append(-np.linalg.solve(J, change), 1.0)
    return tau / np.linalg.norm(tau), change, float(np.linalg.slogdet(J)[0])


def corrected(
    chain: Chain, point: Point, s: float, tau: Array, change: Array, reach: float, fixed: bool
) -> tuple[Point, float, int] | None:
    """The point back on the path by Newton steps normal to its tangent, or at constant s; None where it goes too far, as it
    may be led to another path."""
    gone = 0.0
    for newton in range(BACK + 1):
        g, J = equations(chain, point, s)
        if np.abs(g).max() <= max(ON_PATH, 1e-5 * CREEP[0] * (CREEP[1] / CREEP[0]) ** s):
            return point, s, newton
        step, other = np.linalg.solve(J, np.column_stack([-g, -change])).T
        ds = 0.0 if fixed else -float(tau[:-1] @ step / (tau[-1] + tau[:-1] @ other))
        step = step + ds * other
        gone += np.hypot(np.linalg.norm(step), ds)
        if not gone <= 0.7 * max(reach, NEAR):
            return None
        point, s = point.moved(chain, step), s + ds
    return None


def follow_path(chain: Chain, point: Point, balls: int) -> Point:
    """The point at s = 1, along the path of solutions from s = 0, on which s may turn."""
    point, s, length = start_of_path(chain, point, balls), 0.0, LENGTH
    tau, change, first = tangent(chain, point, s)
    while length > SHORTEST:
        length = min(length, 1.0 / max(abs(tau[-1]) / AHEAD, longest(tau, balls) / FAR))
        last = s + length * tau[-1] >= 1.0
        length = (1.0 - s) / tau[-1] if last else length
        found = corrected(
            chain, point.moved(chain, length * tau[:-1]), s + length * tau[-1], tau, change, length, fixed=last
        )
        if found and last:
            return found[0]
        if found and -0.01 < found[1] < 1.0:
            ahead, by_s, sign = tangent(chain, *found[:2])
            ahead *= sign * first
            if tau @ ahead > 0.5 or length < KINK:
                point, s, used = found
                tau, change = ahead, by_s
                length *= 2.0 if used < 3 else 1.3 if used == 3 else 0.8
                continue
        length *= 0.4
    raise AssertionError(f"the path is lost at {s}")


def contact_friction_constants(bearing: linear_bearing.LinearBearing) -> Array:
    """Constants (b/a, q0, k1, k3): force k1 t - k3 t^3, moment q0 - k1 t^2/2 + 3 k3 t^4/4 at the centre of rotation t a."""
    constants = bearing.contact_hertz_constants()
    ratio = float(constants.C_b / constants.C_a)
    q0 = 0.375 * linear_bearing.elliptic_integral_second_kind(ratio)
    return np.array([ratio, q0, linear_friction_force_factor(ratio), cubic_friction_force_factor(ratio)])


def chain_by_oracle(bearing: linear_bearing.LinearBearing, angles: Array, loads: Array) -> tuple[Array, Array, float]:
    """Velocities over the carriage's (N,), forces over the largest friction bound of a ball (N-1,), and the residual."""
    count, sign = len(angles), float(np.sign(bearing.speed))
    nx, ny = np.moveaxis(linear_bearing.contact_directions(angles), -1, 0)
    arm = linear_bearing.contact_semi_axes(bearing, loads)[0] / bearing.ball_radius
    # sliding and spin by v, R omega_x, R omega_y (Lin 3.22-3.24)
    slide, spin = np.zeros((2, count, 4, count, 3))
    each = np.arange(count)
    slide[each, :, each] = np.stack([np.ones_like(nx), ny, -nx], axis=-1)
    spin[each, :, each] = np.stack([np.zeros_like(nx), arm * nx, arm * ny], axis=-1)
    v, p, q = (np.kron(np.eye(count), unit) for unit in np.eye(3))
    rub = tuple(turn[:-1] + turn[1:] for turn in (p, q))
    bounds = (loads / loads.sum(axis=1).max()).ravel()
    ways = slide.reshape(4 * count, -1), spin.reshape(4 * count, -1), v[:-1] - v[1:], rub
    chain = Chain(*ways, bounds, contact_friction_constants(bearing), bearing.mu_balls)
    nominal = np.tile(np.array([0.5, 0.5 / np.cos(bearing.contact_angle), 0.0]) * sign, count)
    slips = chain.slips(nominal)
    slips[0] = slips[0] - np.tile(linear_bearing.MOVING * sign, count)
    point = follow_path(chain, Point(slips, np.zeros(3 * count), np.zeros(count - 1)), count)
    for _ in range(BACK):
        g, J = equations(chain, point, 1.0)
        if np.abs(g).max() <= CLOSE:
            break
        point = point.moved(chain, -np.linalg.solve(J, g))
    return (nominal + point.drift)[::3], np.maximum(point.z, 0.0), float(np.abs(g).max())
