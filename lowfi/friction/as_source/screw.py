"""The source's method for balls of a ball screw, kept for comparison: loads and motion as one root (Lin 3.4.1, 3.4.2).

Unknowns of a ball, as above Lin 3.71: place in the groove section (2), contact angles gamma (4), motion (4); of two
that touch: the force between them. First the loads without friction and the screw's place, which then stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import root

from rollbench.lowfi.friction.as_source.chain import (
    ACCEPTED,
    SHARPNESS,
    Balls,
    Neighbours,
    SourceMotion,
    Status,
    balance,
    blocks,
    closing_in,
    roots,
    solve_by_root,
)
from rollbench.lowfi.friction.as_source.loads import Places, contact_forces, loads_by_root
from rollbench.lowfi.friction.contact.laws import Law
from rollbench.lowfi.friction.contact.motion import HYBRID
from rollbench.lowfi.friction.contact.rings import Settled
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.load import Cell
from rollbench.lowfi.friction.screw.motion import contact_wrench, hold_screw, screw_contacts, source_law
from rollbench.lowfi.friction.screw.pair import Pair, PairResult
from rollbench.meshes.arrays import Array, Mask


def neighbours(groove: ScrewGroove) -> Neighbours:
    """Balls of a screw in touch, on the exact helix; unknowns omega_B, omega_x, omega_y, omega_z (mends 3.73-3.75)."""
    p, r = groove.pair, groove.ball_radius
    return Neighbours(p.first, p.second, p.closing, groove.between, np.array([groove.radius, r, r, r]), rolling(groove))


def rolling(groove: ScrewGroove) -> Array:
    """Motion (4,) [rad/s] of a ball that slides least at four contacts at the nominal angle: where searches begin.

    An assumption: the text names no start.
    """
    maps, drives = groove.maps(groove.normals(np.full(4, groove.contact_angle)))
    units = np.array([groove.radius, *[groove.ball_radius] * 3])
    x = np.linalg.lstsq((maps[:, :2] / units).reshape(8, 4), -drives[:, :2].ravel(), rcond=None)[0]
    return np.asarray(x / units)


def screw_balls(groove: ScrewGroove, force: Array, angle: Array) -> Balls:
    """N balls at given contact forces [N] and angles [rad], both (N, 4), in the order SL, SR, NL, NR."""
    maps, drives = groove.maps(groove.normals(angle))
    return Balls(screw_contacts(groove, force), maps, drives, neighbours(groove))


@dataclass(frozen=True)
class SourceState:
    """N balls with their loads: places, contact forces (N, 4) [N], motions (N, 4) [rad/s], forces between (N-1,) [N].

    left: largest residual of the scaled equations; calls of them.
    """

    at: Places
    force: Array
    q: Array
    ball_force: Array
    left: float
    calls: int


@dataclass(frozen=True)
class SourceScrew:
    """Balls of a screw by the source's method: loads without friction, then contact forces (N, 4) [N] with it, motion."""

    load: Settled
    force: Array
    angle: Array
    motion: SourceMotion


def coupled_block(cell: Cell, law: Law, start: SourceState, scale: float) -> SourceState:
    """N touching balls with their loads as one root; the screw stays where ``start`` has it (Lin 3.71, 3.75-3.77).

    scale [N]: sum of a ball's contact forces, by which the equations are scaled.
    """
    g, pair = cell.groove, neighbours(cell.groove)
    n, turn = cell.angle.shape[0], pair.units / pair.speed
    size, bound = float(np.max(g.constants.C)) * scale ** (2.0 / 3.0), g.mu * scale or 1.0

    def split(x: Array) -> tuple[Places, Array, Array]:
        by_ball = x[: 10 * n].reshape(n, 10)
        return Places(by_ball[:, :2] * size, by_ball[:, 2:6], start.at.screw), by_ball[:, 6:] / turn, x[10 * n :] * bound

    def residual(x: Array) -> Array:
        if not np.all(np.isfinite(x)):
            return np.full_like(x, 1e3)
        places, q, between = split(x)
        force, bent, normal = contact_forces(cell, places)
        rolling = balance(screw_balls(g, force, places.gamma), law, q, between)
        friction = contact_wrench(g.normals(places.gamma), rolling.force, rolling.moment)[..., [0, 2]]
        pull = cell.push + (friction - force[..., None] * normal).sum(axis=1)
        bite = (pair.mu * between)[:, None] * rolling.rub
        pull[:-1] += (between[:, None] * g.pair.push[0] - bite @ g.pair.slide[0])[:, [0, 2]]
        pull[1:] += (between[:, None] * g.pair.push[1] + bite @ g.pair.slide[1])[:, [0, 2]]
        equations = np.concatenate([pull / scale, bent, rolling.left / (pair.units * bound)], axis=1)
        return np.append(equations.ravel(), np.diff(q[:, 0]) * turn[0])

    unknowns = np.concatenate([start.at.ball / size, start.at.gamma, start.q * turn], axis=1)
    x = np.append(unknowns.ravel(), start.ball_force / bound)
    solution = root(residual, x, method="hybr", options=HYBRID)
    at, q, between = split(solution.x)
    force, _, _ = contact_forces(cell, at)
    return SourceState(at, force, q, between, float(np.max(np.abs(solution.fun))), int(solution.nfev))


def coupled_roots(cell: Cell, law: Law, touching: Mask, start: SourceState, scale: float) -> SourceState:
    """All N balls, group by group, for given contacts (N-1,)."""
    n = cell.angle.shape[0]
    ball, gamma, q = start.at.ball.copy(), start.at.gamma.copy(), start.q.copy()
    force, between, left, calls = np.zeros((n, 4)), np.zeros(n - 1), 0.0, 0
    for group in blocks(touching):
        inner = slice(group.start, group.stop - 1)
        group_cell = replace(
            cell,
            angle=cell.angle[group],
            interference=cell.interference[group],
            rows=cell.rows[group],
            offset=cell.offset[group],
            push=cell.push[group],
        )
        at = Places(start.at.ball[group], start.at.gamma[group], start.at.screw)
        begin = SourceState(at, force[group], start.q[group], start.ball_force[inner], 0.0, 0)
        solved = coupled_block(group_cell, law, begin, scale)
        ball[group], gamma[group], force[group] = solved.at.ball, solved.at.gamma, solved.force
        q[group], between[inner] = solved.q, solved.ball_force
        left, calls = max(left, solved.left), calls + solved.calls
    return SourceState(Places(ball, gamma, start.at.screw), force, q, between, left, calls)


def state_of(result: PairResult, touching: bool) -> SourceState:
    """A solution of the chain solver, balls in contact or not, as a start."""
    solution = result.touching if touching else result.free
    at = Places(solution.load.ball, solution.load.angle, np.zeros(0))
    return SourceState(at, solution.load.force, solution.motion.q, solution.motion.ball_force[:1], 0.0, 0)


def at_given_loads(cell: Cell, load: Settled, law: Law) -> SourceState:
    """Balls alone at loads without friction, searched from rolling: the start where no other is given."""
    n, pair = cell.angle.shape[0], neighbours(cell.groove)
    none, first = np.zeros(n - 1), np.tile(pair.nominal, (n, 1))
    q, _, left, calls = roots(screw_balls(cell.groove, load.force, load.angle), law, none > 0.0, (first, none))
    return SourceState(Places(load.ball, load.angle, np.zeros(0)), load.force, q, none, left, calls)


def coupled_by_root(
    cell: Cell, load: Settled, reach: Mask, law: Law, start: SourceState | None = None, touching: SourceState | None = None
) -> SourceScrew:
    """N balls whose friction changes their loads; load: without friction; reach (N-1,): neighbours near enough.

    start: where the balls alone are searched from, their motion at the loads without friction where None; touching:
    the same for balls in contact, the balls alone where None. The text names no starts. Groups of balls that touch are
    those that close in when alone (Lin 3.76, 3.77).
    """
    held, pair = hold_screw(cell, load), neighbours(cell.groove)
    scale = max(float(load.force.sum(axis=1).max()), 1e-300)
    begin = at_given_loads(cell, load, law) if start is None else start
    none = np.zeros(cell.angle.shape[0] - 1)
    free = solved = coupled_roots(held, law, none > 0.0, replace(begin, ball_force=none), scale)
    calls = begin.calls + free.calls
    touch = np.asarray(reach, dtype=bool) & closing_in(pair, free.q)
    if free.left <= ACCEPTED and np.any(touch):
        solved = coupled_roots(held, law, touch, free if touching is None else touching, scale)
        calls += solved.calls
    sums = balance(screw_balls(cell.groove, solved.force, solved.at.gamma), law, solved.q, solved.ball_force)
    bad = np.any(solved.ball_force < -ACCEPTED * cell.groove.mu * scale)
    wrong = bool(bad or np.any(reach & ~touch & closing_in(pair, solved.q, ACCEPTED)))
    status: Status = "failed" if not solved.left <= ACCEPTED else "overlapping" if wrong else "exact"
    motion = SourceMotion(solved.q, free.q, solved.ball_force, sums.groove_loss, sums.ball_loss, solved.left, calls, status)
    return SourceScrew(load, solved.force, solved.at.gamma, motion)


def screw_pair_by_root(
    pair: Pair, law: Law | None = None, start: SourceState | None = None, touching: SourceState | None = None
) -> SourceScrew:
    """Two balls of a screw in reach (Lin 3.4.3) by the source's method; law: its sigmoid with SHARPNESS where None.

    Loads by root finding first; the motion at these where the pair's coupling is "none", else both together, from
    starts as in ``coupled_by_root``. Raises ValueError for coupling "ball and screw", which the source has not, and
    RuntimeError where no loads are found.
    """
    if pair.coupling == "ball and screw":
        raise ValueError('the source holds the screw where it is without friction: coupling "none" or "ball"')
    cell, law = pair.cell(), source_law(pair.groove, SHARPNESS) if law is None else law
    load, reach = loads_by_root(cell), np.array([True])
    if not load.converged:
        raise RuntimeError(f"no root for the loads: {load.left:.1e} N left after {load.steps} calls")
    if pair.coupling == "ball":
        return coupled_by_root(cell, load, reach, law, start, touching)
    motion = solve_by_root(
        screw_balls(pair.groove, load.force, load.angle),
        law,
        reach,
        None if start is None else start.q,
        None if touching is None else (touching.q, touching.ball_force),
    )
    return SourceScrew(load, load.force, load.angle, motion)
