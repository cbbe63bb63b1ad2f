"""Run times of friction and ball motion against their targets, and the source's formulation in the same process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import radians

import numpy as np

from compare.bench import timed
from compare.findings import entry
from compare.sections.friction_values import AXIAL, CASES, LINEAR, ROTARY, SIDE, THETA, VERTICAL
from lowfi.friction.chain import prepare, solve
from lowfi.friction.ellipse import about_point
from lowfi.friction.engine import engine
from lowfi.friction.linear_pair import pair_state
from lowfi.friction.linear_pair import solve_pair as solve_linear_pair
from lowfi.friction.motion import Motion, balance_by_root, least_dissipation
from lowfi.friction.rotary import solve_ball, source_law
from lowfi.friction.screw_motion import ball_motion, ball_motion_by_root
from lowfi.friction.screw_motion import source_law as screw_law
from lowfi.friction.screw_pair import Pair, inferred, plain, solve_pair
from lowfi.friction.screw_run import lin_3_4_4, simulate

#: Contacts in one call that a single one is timed with.
MANY = 2000
#: Targets [s]: contact call, ball at given loads, linear pair, screw pair, whole run.
CONTACT, BALL, LINEAR_PAIR, SCREW_PAIR, WHOLE = 1e-6, 0.15e-3, 1e-3, 20e-3, 3.0
NO_SOURCE = "the source's way is not here to compare"


@dataclass(frozen=True)
class Row:
    """One job: median seconds, target [s], the source's formulation over ours in this process (None: it has none)."""

    name: str
    seconds: float
    target: float
    ratio: float | None
    note: str

    @property
    def reached(self) -> bool:
        """Whether the target is reached on this machine."""
        return self.seconds <= self.target


def against_root(name: str, ours: Callable[[], object], theirs: Callable[[], Motion], repeats: int) -> Row:
    """A ball at given loads beside the source's root finding from the solution; no ratio where that finds no root."""
    seconds = timed(ours, 20 * repeats)
    if theirs().status != "exact":
        return Row(name, seconds, BALL, None, "given loads; the source's root finding fails even from the solution")
    note = "given loads; ratio: the source's root finding, started from the solution, over ours"
    return Row(name, seconds, BALL, timed(theirs, 5 * repeats) / seconds, note)


def contact_jobs(repeats: int) -> Iterator[Row]:
    """One contact: friction with first and second derivatives."""
    shape = np.full(MANY, 1e-3), np.full(MANY, 2e-4)
    motion = about_point(np.ones(MANY), np.linspace(-2e-3, 2e-3, MANY), np.full(MANY, 1e-4))
    out, call = np.empty((MANY, 11)), engine(True).dissipation_many
    seconds = timed(lambda: call(*shape, motion, 0.0, out), 2 * repeats) / MANY
    note = f"friction, first and second derivatives; mean of {MANY} in a call; {NO_SOURCE}"
    yield Row("one contact", seconds, CONTACT, None, note)


def rotary_job(case: str, repeats: int) -> Row:
    """One ball of the rotary bearing."""
    s = solve_ball(ROTARY, AXIAL, CASES[case], fast=True)
    law, start = source_law(ROTARY, map_spacing=None), s.motion.q
    return against_root(
        f"ball of the rotary bearing, case {case}", lambda: least_dissipation(s.problem, fast=True),
        lambda: balance_by_root(s.problem, law, start, fast=True), repeats,
    )  # fmt: skip


def screw_job(name: str, pair: Pair, repeats: int) -> Row:
    """Second ball of a pair of the screw, apart."""
    g, load = pair.groove, solve_pair(pair).free.load
    one, law = ball_motion(g, load.force[1], load.angle[1]), screw_law(pair.groove)
    return against_root(
        f"ball of the screw, {name}", lambda: ball_motion(g, load.force[1], load.angle[1]),
        lambda: ball_motion_by_root(one, law, one.motion.q), repeats,
    )  # fmt: skip


def ball_jobs(repeats: int) -> Iterator[Row]:
    """One ball at given loads."""
    for case in CASES:
        yield rotary_job(case, repeats)
    for make in (plain, inferred):
        yield screw_job(f"{make.__name__} reading", make(radians(2.0)), repeats)


def pair_jobs(repeats: int) -> Iterator[Row]:
    """Two balls, apart and in contact, with their loads."""
    chain = prepare(LINEAR, *pair_state(LINEAR, THETA, SIDE, VERTICAL))
    printed = entry("lin-3.5", "a_time_numerical").printed, entry("lin-3.7", "time_a").printed
    note = f"prepared, in contact; {NO_SOURCE}"
    yield Row("linear pair, given loads", timed(lambda: solve(chain), 10 * repeats), LINEAR_PAIR, None, note)
    seconds = timed(lambda: solve_linear_pair(LINEAR, THETA, SIDE, VERTICAL), 10 * repeats)
    note = f"loads, apart and in contact; the source prints {printed[0]} s on another machine"
    yield Row("linear pair, all of it", seconds, LINEAR_PAIR, None, note)
    for make, words in ((inferred, "loads not coupled"), (plain, "friction moves the balls")):
        pair = make(radians(2.0))
        seconds = timed(partial(solve_pair, pair), 2 * repeats)
        note = f"loads ({words}), apart and in contact; the source prints {printed[1]} s on another machine"
        yield Row(f"screw pair, {make.__name__} reading", seconds, SCREW_PAIR, None, note)


def run_jobs(repeats: int) -> Iterator[Row]:
    """The whole screw over 200 steps."""
    run = lin_3_4_4()
    seconds = timed(lambda: simulate(run), max(1, repeats // 5))
    note = f"{run.steps} steps, {run.count} balls, theta of 3 deg, loads not coupled; {NO_SOURCE}"
    yield Row("whole screw", seconds, WHOLE, None, note)


def jobs(repeats: int = 5) -> Iterator[Row]:
    """All jobs, compiled kernels, medians of ``repeats`` or a multiple of it."""
    for group in (contact_jobs, ball_jobs, pair_jobs, run_jobs):
        yield from group(repeats)
