"""Motion of many balls of a ball screw with friction and ball-to-ball contact as a complementarity problem.

Every ball's motion is in balance with the friction at its grooves and the forces of its neighbours: 0 <= F, 0 <= rate
at which the gap may still close, F rate = 0, and sliding friction mu F between balls (Lin 3.73-3.77). Semismooth
Newton on motions and forces together, with a falling regularising speed of friction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from .ellipse import Array, Contacts, dissipation
from .motion import Problem, least_dissipation
from .screw_groove import ScrewGroove, contact_axes
from .screw_load import Cell, ScrewLoad, settle
from .screw_motion import AGREED, ROUNDS, Coupling, Mixer, feedback, helical_power, hold_screw, screw_contacts

#: Regularising speeds as parts of the balls' speed, from the first (cold start) to the last.
SPEEDS = tuple(10.0 ** (-0.5 * k) for k in range(2, 15))
#: Parts of the friction between balls, one after the other at the first of these speeds.
PARTS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
#: Largest step of a ball's surface speeds, as part of its nominal speed: far off, friction no longer tells the way.
REACH = 0.3
#: Force out of balance, as part of the largest friction bound of a ball: aimed at (root of the sum of squares), and
#: what counts as converged (largest, relative to the largest ball-to-ball force where that is larger).
GOAL, ACCEPTED = 1e-12, 2e-9
#: The same between regularising speeds; most Newton steps, and those of first tries.
COARSE, STEPS, SHORT = 1e-10, 60, 15
#: A stage has failed where more than this is left; most halvings of stages.
MISSED, DEPTH = 1e-8, 12
#: Springs to the nominal motion per friction bound, for balls with contacts and without.
HOLD, HOLD_IDLE = 1e-13, 1e-9
#: Balls with less than this part of the largest load count as unloaded.
NEGLIGIBLE = 1e-7
#: Half bandwidth of the Jacobian with a ball's motion and the force on the next in one block of five.
BAND = 9


@dataclass(frozen=True)
class Chain:
    """N balls in order of azimuth: contact forces and normals (N, 4), (N, 4, 3), and how neighbours may approach.

    slack (N,): largest rate [rad/s] at which ball k may gain on ball k + 1, inf where they cannot touch; the last entry
    is for the last ball against the first of a closed track. Balls without loads roll along at the nominal speed unless
    pushed, and turn freely between their neighbours as spacers do: without friction there.
    """

    groove: ScrewGroove
    force: Array
    normals: Array
    slack: Array


@dataclass(frozen=True)
class ChainMotion:
    """Motions q (N, 4) [rad/s]; ball_force (N,) [N] of ball k on k + 1; friction on the balls (N, 4, 6) [N, N m].

    ball_push (N, 3): all forces from neighbours on each ball in x3, y3, z3 [N]; groove_loss (N, 4), ball_loss (N,) by
    sliding and closing_loss (N,) by gaps that close under force [W]; input_power [W]; left: largest force out of
    balance [N]; violation: largest rate beyond the slack [rad/s].
    """

    q: Array
    ball_force: Array
    wrench: Array
    ball_push: Array
    groove_loss: Array
    ball_loss: Array
    closing_loss: Array
    input_power: float
    left: float
    violation: float
    steps: int
    converged: bool

    @property
    def loss(self) -> float:
        """Total dissipation [W]."""
        return float(self.groove_loss.sum() + self.ball_loss.sum() + self.closing_loss.sum())


@dataclass(frozen=True)
class _Parts:
    balance: Array
    comp: Array
    by_force: Array
    by_gap: Array
    hessian: Array


class _Solver:
    """Arrays of one chain, cut open where the track closes, and Newton's method on them."""

    def __init__(self, chain: Chain) -> None:
        """Scale everything by the largest friction bound of a ball and the balls' nominal speed."""
        g, pair = chain.groove, chain.groove.pair
        total = chain.force.sum(axis=1)
        loaded = total > NEGLIGIBLE * float(total.max())
        self.chain, self.count = chain, chain.force.shape[0]
        self.at: Contacts = screw_contacts(g, np.where(loaded[:, None], chain.force, 0.0))
        self.loaded = loaded
        self.maps, self.drives = g.maps(chain.normals)
        self.speed = abs(g.speed) * g.radius or 1.0
        self.bound = max(g.mu * float(total.max()), 1e-30)
        self.units = np.array([g.radius, g.ball_radius, g.ball_radius, g.ball_radius])
        self.first, self.second = pair.first / self.units, pair.second / self.units
        self.closing = pair.closing / g.radius
        self.allowed = np.isfinite(chain.slack)
        self.slack = np.where(self.allowed, chain.slack, 0.0) * pair.closing / self.speed
        self.nominal = np.array([g.nominal_orbit, 0.0, 0.0, 0.0]) * self.units / self.speed
        rub = loaded & np.roll(loaded, -1)
        self.mu = np.where(rub, g.mu if g.mu_balls is None else g.mu_balls, 0.0)
        self.hold = np.where(loaded[:, None], HOLD, HOLD_IDLE) * np.ones(4)
        self.scaled = (self.maps / self.units * self.speed).reshape(self.count, 12, 4)
        self.flat_drives = self.drives.reshape(-1, 3)
        self.places = _band_places(self.count)
        self.ahead, self.behind = np.roll(np.arange(self.count), -1), np.roll(np.arange(self.count), 1)

    def alone(self) -> Array:
        """Scaled motions (N, 4) of the balls without neighbours."""
        x = np.tile(self.nominal, (self.count, 1))
        for k in np.flatnonzero(self.loaded):
            own = slice(4 * k, 4 * k + 4)
            at = Contacts(self.at.a[own], self.at.b[own], self.at.load[own], self.at.mu[own])
            problem = Problem(at, self.maps[k], self.drives[k], np.zeros(4))
            x[k] = least_dissipation(problem, fast=True).q * self.units / self.speed
        return x

    def grooves(self, x: Array, eps: float) -> tuple[Array, Array]:
        """Gradient (N, 4) and Hessian (N, 4, 4) of the balls' scaled dissipation at scaled motions x."""
        n, maps = self.count, self.scaled
        motion = self.flat_drives + (maps @ x[:, :, None]).reshape(-1, 3)
        d = dissipation(self.at, motion, eps * self.speed, fast=True)
        scale, turned = 1.0 / (self.bound * self.speed), maps.transpose(0, 2, 1)
        gradient = (turned @ d.gradient.reshape(n, 12, 1))[:, :, 0] * scale
        bent = (d.hessian @ maps.reshape(4 * n, 3, 4)).reshape(n, 12, 4)
        hessian = (turned @ bent) * scale
        gradient += self.hold * (x - self.nominal)
        hessian[:, range(4), range(4)] += self.hold
        return gradient, hessian

    def rubbing(self, x: Array, eps: float) -> tuple[Array, Array, Array]:
        """Direction of sliding (N, 2) of ball k on k + 1, its derivative (N, 2, 2), speed times direction (N,)."""
        w = x @ self.first.T - x[self.ahead] @ self.second.T
        size = np.sqrt(np.sum(w * w, axis=1) + eps * eps)
        unit = w / size[:, None]
        turn = (np.eye(2) - unit[:, :, None] * unit[:, None, :]) / size[:, None, None]
        return unit, turn, np.sum(w * unit, axis=1)

    def residual(self, x: Array, f: Array, eps: float) -> _Parts:
        """Balance (N, 4), Fischer-Burmeister's function of forces and gaps (N,), its slopes, the grooves' Hessian."""
        gradient, hessian = self.grooves(x, eps)
        unit, _, _ = self.rubbing(x, eps)
        bite = self.mu * np.maximum(f, 0.0)
        gradient[:, 0] += self.closing * (f - f[self.behind])
        gradient += bite[:, None] * (unit @ self.first)
        gradient -= (bite[:, None] * (unit @ self.second))[self.behind]
        left = self.gaps(x)
        size = np.maximum(np.hypot(f, left), 1e-300)
        by_force = np.where(self.allowed, 1.0 - f / size, 1.0)
        by_gap = np.where(self.allowed, 1.0 - left / size, 0.0)
        comp = np.where(self.allowed, f + left - size, f)
        return _Parts(gradient, comp, by_force, by_gap, hessian)

    def gaps(self, x: Array) -> Array:
        """What is left of the slack (N,), scaled."""
        return np.asarray(self.closing * (x[self.ahead, 0] - x[:, 0]) + self.slack)

    def blocks(self, x: Array, f: Array, parts: _Parts, eps: float) -> tuple[Array, Array, Array]:
        """Blocks (N, 5, 5) of the Jacobian: diagonal, right of it, and below; ball k and its force to k + 1."""
        unit, turn, _ = self.rubbing(x, eps)
        bite = self.mu * np.maximum(f, 0.0)
        turn = turn * bite[:, None, None]
        mid, right, below = (np.zeros((self.count, 5, 5)) for _ in range(3))
        mid[:, :4, :4] = parts.hessian + self.first.T @ turn @ self.first
        mid[:, :4, :4] += (self.second.T @ turn @ self.second)[self.behind]
        right[:, :4, :4] = -self.first.T @ turn @ self.second
        below[:, :4, :4] = -self.second.T @ turn @ self.first
        sliding = np.where(f > 0.0, self.mu, 0.0)[:, None]
        mid[:, :4, 4] = sliding * (unit @ self.first)
        mid[:, 0, 4] += self.closing
        below[:, :4, 4] = -sliding * (unit @ self.second)
        below[:, 0, 4] -= self.closing
        mid[:, 4, 0] = -self.closing * parts.by_gap
        right[:, 4, 0] = self.closing * parts.by_gap
        mid[:, 4, 4] = parts.by_force
        return mid, right, below

    def step(self, x: Array, f: Array, parts: _Parts, eps: float) -> tuple[Array, Array]:
        """Newton step; the closed track is cut at the contact that is most clearly open."""
        mid, right, below = self.blocks(x, f, parts, eps)
        start = int(np.argmax(np.where(self.allowed, self.gaps(x) - f, np.inf))) + 1
        order = np.roll(np.arange(self.count), -start)
        band = np.zeros((2 * BAND + 1, 5 * self.count))
        for part, place in zip((mid[order], right[order][:-1], below[order][:-1]), self.places, strict=True):
            band[place] = part
        side = -np.concatenate([parts.balance, parts.comp[:, None]], axis=1)[order].ravel()
        found = solve_banded((BAND, BAND), band, side, overwrite_ab=True, check_finite=False).reshape(-1, 5)
        out = np.empty_like(found)
        out[order] = found
        return out[:, :4], out[:, 4]

    def solve(self, x: Array, f: Array, eps: float, goal: float, limit: int) -> tuple[Array, Array, float, int]:
        """Newton from (x, f) at one regularising speed, steps halved until the residual falls; its size and steps.

        Ends at ``goal``, after ``limit`` steps, or where round-off lets the residual fall no more.
        """
        parts = self.residual(x, f, eps)
        size = _size(parts)
        for steps in range(limit):
            if size <= goal:
                return x, f, size, steps
            dx, df = self.step(x, f, parts, eps)
            length, best = min(1.0, REACH / max(float(np.max(np.abs(dx))), 1e-300)), None
            for _ in range(3 if size <= ACCEPTED else 25):
                trial = self.residual(x + length * dx, f + length * df, eps)
                if _size(trial) < (1.0 - 0.1 * length) * size:
                    best = trial
                    break
                length *= 0.5
            if best is None:
                return x, f, size, steps + 1
            x, f, parts, size = x + length * dx, f + length * df, best, _size(best)
        return x, f, size, limit

    def balanced(self, x: Array, f: Array) -> bool:
        """Whether (x, f) counts as converged."""
        return _balanced(self.residual(x, f, SPEEDS[-1]), f)

    def by_stages(self, x: Array) -> tuple[Array, Array, int]:
        """Newton from motions x, friction between balls rising at the first regularising speed, then that falling.

        A stage that fails is halved, DEPTH times in all.
        """
        f, full, total = np.zeros(self.count), self.mu, 0
        goals = [(part, SPEEDS[0]) for part in PARTS] + [(1.0, eps) for eps in SPEEDS[1:]]
        goals.reverse()
        at, tries = goals[-1], 0
        while goals:
            part, eps = goals[-1]
            self.mu = part * full
            x_new, f_new, size, steps = self.solve(x, f, eps, COARSE if eps > SPEEDS[-1] else GOAL, STEPS)
            total += steps
            if size > MISSED and tries < DEPTH and at != goals[-1]:
                tries += 1
                goals.append((0.5 * (at[0] + part), float(np.sqrt(at[1] * eps))))
                continue
            x, f, at = x_new, f_new, goals.pop()
        return x, f, total


def _size(parts: _Parts) -> float:
    return float(np.sqrt(np.sum(parts.balance**2) + np.sum(parts.comp**2)))


def _balanced(parts: _Parts, f: Array) -> bool:
    worst = max(float(np.max(np.abs(parts.balance))), float(np.max(np.abs(parts.comp))))
    return worst <= ACCEPTED * max(1.0, float(np.max(f)))


@cache
def _band_places(count: int) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]:
    """Rows and columns in the band of the blocks on the diagonal, right of it and below it."""
    base = 5 * np.arange(count, dtype=np.int64)
    i, j = np.meshgrid(np.arange(5), np.arange(5), indexing="ij")
    out: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    for rows, columns in ((base, base), (base[:-1], base[1:]), (base[1:], base[:-1])):
        r, c = rows[:, None, None] + i, columns[:, None, None] + j
        out.append((BAND + r - c, c))
    return tuple(out)


def solve_chain(chain: Chain, start: tuple[Array, Array] | None = None) -> ChainMotion:
    """Motions and ball-to-ball forces; start: motions (N, 4) [rad/s] and forces (N,) [N] of a similar chain.

    Newton at the last regularising speed from a start with contacts, then from the balls' motions without neighbours,
    and where both fail by stages. A closed track needs a gap somewhere: one filled by its balls is not determined.
    """
    s = _Solver(chain)
    total = 0
    if start is not None and np.any(start[1] > 0.0):
        x, f, size, total = s.solve(start[0] * s.units / s.speed, start[1] / s.bound, SPEEDS[-1], GOAL, SHORT)
        if size <= ACCEPTED or s.balanced(x, f):
            return _result(s, x, f, total)
    alone, none = s.alone(), np.zeros(s.count)
    x, f, _, steps = s.solve(alone, none, SPEEDS[-1], GOAL, SHORT)
    total += steps
    if not s.balanced(x, f):
        x, f, steps = s.by_stages(alone)
        total += steps
    return _result(s, x, f, total)


def _result(s: _Solver, x: Array, f: Array, steps: int) -> ChainMotion:
    """Forces and losses at the solution, in SI."""
    chain, n, eps = s.chain, s.count, SPEEDS[-1]
    parts, gap = s.residual(x, f, eps), s.gaps(x)
    good = _balanced(parts, f)
    f = np.where(s.allowed & (f > gap), np.maximum(f, 0.0), 0.0)
    q = x * s.speed / s.units
    motion = s.flat_drives + (s.scaled @ x[:, :, None]).reshape(-1, 3)
    d = dissipation(s.at, motion, eps * s.speed, fast=True)
    axes = contact_axes(chain.normals)
    force = np.einsum("ncr,ncri->nci", -d.gradient[:, :2].reshape(n, 4, 2), axes[..., :2, :])
    wrench = np.concatenate([force, -d.gradient[:, 2].reshape(n, 4, 1) * axes[..., 2, :]], axis=-1)
    unit, _, sliding = s.rubbing(x, eps)
    ball_force = s.bound * f
    bite = (s.mu * ball_force)[:, None] * unit
    pair = chain.groove.pair
    push = ball_force[:, None] * pair.push[0] - bite @ pair.slide[0]
    push += (ball_force[:, None] * pair.push[1] + bite @ pair.slide[1])[s.behind]
    gap = np.where(s.allowed, gap, 0.0)
    return ChainMotion(
        q=q,
        ball_force=ball_force,
        wrench=wrench,
        ball_push=push,
        groove_loss=(d.value - d.excess).reshape(n, 4),
        ball_loss=s.mu * ball_force * sliding * s.speed,
        closing_loss=ball_force * pair.closing * (q[:, 0] - q[s.ahead, 0]),
        input_power=helical_power(chain.groove, chain.normals, wrench),
        left=float(np.max(np.abs(parts.balance))) * s.bound,
        violation=max(0.0, -float(np.min(gap))) * s.speed / pair.closing,
        steps=steps,
        converged=good,
    )


@dataclass(frozen=True)
class CoupledChain:
    """Loads and motion of a chain that agree; change: last change of the friction fed back [N]."""

    load: ScrewLoad
    motion: ChainMotion
    change: float
    rounds: int
    converged: bool


def coupled_chain(
    cell: Cell, slack: Array, coupling: Coupling, near: CoupledChain | None = None, rounds: int = ROUNDS
) -> CoupledChain:
    """Loads and motion of N balls in agreement, ball-to-ball forces included; ``near``: solution of a similar chain.

    slack: see ``Chain``. "ball": the screw stays where it is without friction and ball-to-ball forces.
    """
    same = near is not None and near.load.screw.shape == cell.force.shape
    load = settle(cell, (near.load.ball, near.load.screw) if near is not None and same else None)
    if coupling == "ball":
        cell = hold_screw(cell, load)
    push, drag, mixer = cell.push, cell.drag, Mixer()
    if near is not None and coupling != "none":
        push, drag = feedback(cell, near.motion.wrench, near.motion.ball_push[:, [0, 2]], coupling)
    start = None if near is None else (near.motion.q, near.motion.ball_force)
    count = 0
    while True:
        load = settle(replace(cell, push=push, drag=drag), (load.ball, load.screw[: cell.rows.shape[2]]))
        moved = solve_chain(Chain(cell.groove, load.force, cell.groove.normals(load.angle), slack), start)
        new_push, new_drag = feedback(cell, moved.wrench, moved.ball_push[:, [0, 2]], coupling)
        x, g = np.append(push, drag), np.append(new_push, new_drag)
        change, count = float(np.max(np.abs(g - x))), count + 1
        agreed = change <= AGREED * float(np.sum(load.force))
        if agreed or count == rounds:
            return CoupledChain(load, moved, change, count, agreed and load.converged and moved.converged)
        x = mixer.next(x, g)
        push, drag = x[: push.size].reshape(push.shape), x[push.size :]
        start = (moved.q, moved.ball_force)
