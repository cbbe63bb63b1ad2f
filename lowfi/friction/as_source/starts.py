"""The source's root finding from several starts, rolling and at random about our solution: to count its failures.

Every search yields what it found, None where the source finds no loads to begin with.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from rollbench.lowfi.friction.as_source.chain import SHARPNESS, SourceMotion, solve_by_root
from rollbench.lowfi.friction.as_source.linear import linear_balls, linear_law
from rollbench.lowfi.friction.as_source.screw import SourceState, neighbours, screw_balls, screw_pair_by_root, state_of
from rollbench.lowfi.friction.contact.laws import Sigmoid
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare, solve_linear_chain
from rollbench.lowfi.friction.screw.chain import Chain, ChainMotion, solve_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import source_law
from rollbench.lowfi.friction.screw.pair import Pair, PairResult
from rollbench.meshes.arrays import Array


def shaken(q: Array, units: Array, rng: np.random.Generator, off: float) -> Array:
    """Motions (N, n), each unknown off by up to ``off`` of itself, at least of 1 % of the ball's largest surface speed.

    units (n,): surface speed per unknown.
    """
    x = q * units
    size = np.maximum(np.abs(x), 0.01 * np.max(np.abs(x), axis=1, keepdims=True))
    return np.asarray((x + off * rng.uniform(-1.0, 1.0, q.shape) * size) / units)


def from_linear_starts(
    bearing: LinearBearing, angles: Array, loads: Array, rng: np.random.Generator, count: int, off: float
) -> Iterator[SourceMotion]:
    """Balls of a linear bearing, all in reach: angles [rad], loads [N], (N, 4); forces at random up to doubled."""
    apart, together = (solve_linear_chain(prepare(bearing, angles, loads, touching)) for touching in (False, True))
    balls = linear_balls(bearing, angles, loads)
    law = linear_law(bearing, SHARPNESS) if bearing.speed else Sigmoid(SHARPNESS, 1.0)
    reach, units = np.ones(balls.count - 1, dtype=bool), balls.pair.units
    yield solve_by_root(balls, law, reach)
    for _ in range(count):
        free, near = (shaken(np.column_stack([r.velocity, r.rotation]), units, rng, off) for r in (apart, together))
        force = together.ball_force * rng.uniform(0.0, 2.0, together.ball_force.size)
        yield solve_by_root(balls, law, reach, free, (near, force))


def screw_sigmoid(groove: ScrewGroove, sharpness: float = SHARPNESS) -> Sigmoid:
    """The source's law; at rest, where its reference is zero, with a spin of 1 rad/s."""
    return source_law(groove, sharpness) if groove.speed else Sigmoid(sharpness, 1.0)


def from_pair_starts(
    pair: Pair, solved: PairResult, rng: np.random.Generator, count: int, off: float
) -> Iterator[SourceMotion | None]:
    """A pair of a screw with its loads; places as in our solution ``solved``."""
    free, touching, units = state_of(solved, False), state_of(solved, True), neighbours(pair.groove).units
    starts: list[tuple[SourceState | None, SourceState | None]] = [(None, None)]
    for _ in range(count):
        force = touching.ball_force * rng.uniform(0.0, 2.0, 1)
        near = replace(touching, q=shaken(touching.q, units, rng, off), ball_force=force)
        starts.append((replace(free, q=shaken(free.q, units, rng, off)), near))
    for start in starts:
        try:
            yield screw_pair_by_root(pair, screw_sigmoid(pair.groove), *start).motion
        except RuntimeError:
            yield None


def from_screw_starts(
    chain: Chain, angle: Array, solved: ChainMotion, rng: np.random.Generator, count: int, off: float
) -> Iterator[SourceMotion]:
    """An open chain of a screw at given loads; angle (N, 4) [rad]: its contact angles; solved: our solution.

    Only closed gaps are in reach: one that closes within a step comes to contact in the solver here and overlaps in the
    source's.
    """
    alone = solve_chain(replace(chain, slack=np.full(chain.slack.shape, np.inf)))
    balls, law = screw_balls(chain.groove, chain.force, angle), screw_sigmoid(chain.groove)
    reach, force = chain.slack[:-1] <= 0.0, solved.ball_force[:-1]
    yield solve_by_root(balls, law, reach)
    for _ in range(count):
        free, near = (shaken(q, balls.pair.units, rng, off) for q in (alone.q, solved.q))
        yield solve_by_root(balls, law, reach, free, (near, force * rng.uniform(0.0, 2.0, force.size)))
