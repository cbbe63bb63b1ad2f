"""Run times of friction and ball motion against their targets, and the source's formulation in the same process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np

from rollbench.compare.printed.printed_data import entry
from rollbench.compare.scenes.catalogue import scene as scene_of
from rollbench.compare.sources.lin.evidence.rotary_linear import AXIAL, CASES, LINEAR, ROTARY, SIDE, THETA, VERTICAL
from rollbench.compare.sources.lin.evidence.source_cases import inferred, lin_3_4_4, plain
from rollbench.compare.sources.lin.extremes.cases import chain_state
from rollbench.compare.wings.bench.costs.timing import timed
from rollbench.lowfi.friction.as_source.chain import SHARPNESS, SourceMotion
from rollbench.lowfi.friction.as_source.linear import linear_pair_by_root, solve_linear_by_root
from rollbench.lowfi.friction.as_source.run import simulate_by_root
from rollbench.lowfi.friction.as_source.screw import screw_pair_by_root, state_of
from rollbench.lowfi.friction.bearing.rotary import solve_ball
from rollbench.lowfi.friction.contact.ellipse import about_point
from rollbench.lowfi.friction.contact.motion import Motion, balance_by_root, least_dissipation
from rollbench.lowfi.friction.linear.chain import prepare, solve_linear_chain
from rollbench.lowfi.friction.linear.pair import pair_state
from rollbench.lowfi.friction.linear.pair import solve_pair as solve_linear_pair
from rollbench.lowfi.friction.screw.motion import ROUNDS, ball_motion, ball_motion_by_root, source_law
from rollbench.lowfi.friction.screw.pair import Pair, solve_pair
from rollbench.lowfi.friction.screw.run import equal_steps
from rollbench.lowfi.friction.screw.travel import simulate
from rollbench.lowfi.friction.whole.balls import balls_of
from rollbench.lowfi.friction.whole.contacts import contacts_of
from rollbench.lowfi.friction.whole.losses import ball_friction
from rollbench.lowfi.friction.whole.run import Setting
from rollbench.lowfi.friction.whole.travelling import AGAIN
from rollbench.lowfi.jit import CONTACT, kernels
from rollbench.lowfi.statics.nominal import ContactLoads
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, draw
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Contacts in one call that a single one is timed with.
MANY = 2000
#: Targets [s]: contact call, ball at given loads, linear pair, screw pair, whole run, all balls of a scene.
CONTACT_CALL, BALL, LINEAR_PAIR, SCREW_PAIR, WHOLE, ALL_BALLS = 1e-6, 0.15e-3, 1e-3, 20e-3, 3.0, 5e-3
#: Scene whose friction is timed, and steps of its run.
WHOLE_SCENE, RUN_STEPS = "lin-case1", 200
NO_SOURCE = "the source's method is not implemented here for comparison"
#: Balls of the timed chains of a linear bearing; steps of a whole run that are timed, for the source's method and for
#: scenes.
CHAINS, SOURCE_STEPS = (5, 20), 20
#: Difference of ball-to-ball force, relative, up to which the source's method counts as having found the same answer.
SAME = 1e-6


@dataclass(frozen=True)
class FrictionJob:
    """One job: median seconds, target [s], the source's formulation over the one here in this process (None: it has
    none)."""

    name: str
    seconds: float
    target: float
    ratio: float | None
    note: str

    @property
    def reached(self) -> bool:
        """Whether the target is reached on this machine."""
        return self.seconds <= self.target


def against_root(name: str, ours: Callable[[], object], theirs: Callable[[], Motion], repeats: int) -> FrictionJob:
    """A ball at given loads against the source's root finding from the solution; no ratio where that finds no root."""
    seconds = timed(ours, 20 * repeats)
    if theirs().status != "exact":
        return FrictionJob(name, seconds, BALL, None, "given loads; the source's root finding fails even from the solution")
    note = "given loads; ratio: the source's root finding, started from the solution, over least dissipation"
    return FrictionJob(name, seconds, BALL, timed(theirs, 5 * repeats) / seconds, note)


def contact_jobs(repeats: int) -> Iterator[FrictionJob]:
    """One contact: friction with first and second derivatives."""
    shape = np.full(MANY, 1e-3), np.full(MANY, 2e-4)
    motion = about_point(np.ones(MANY), np.linspace(-2e-3, 2e-3, MANY), np.full(MANY, 1e-4))
    out, call = np.empty((MANY, 11)), kernels(CONTACT, compiled=True).dissipation_many
    seconds = timed(lambda: call(*shape, motion, 0.0, out), 2 * repeats) / MANY
    note = f"friction, first and second derivatives; mean of {MANY} in a call; {NO_SOURCE}"
    yield FrictionJob("one contact", seconds, CONTACT_CALL, None, note)


def rotary_job(case: str, repeats: int) -> FrictionJob:
    """One ball of the rotary bearing."""
    s = solve_ball(ROTARY, AXIAL, CASES[case], fast=True)
    law, start = source_law(ROTARY, SHARPNESS), s.motion.q
    return against_root(
        f"ball of the rotary bearing, case {case}",
        lambda: least_dissipation(s.problem, fast=True),
        lambda: balance_by_root(s.problem, law, start, fast=True),
        repeats,
    )


def screw_job(name: str, pair: Pair, repeats: int) -> FrictionJob:
    """Second ball of a pair of the screw, without contact."""
    g, load = pair.groove, solve_pair(pair).free.load
    one, law = ball_motion(g, load.force[1], load.angle[1]), source_law(pair.groove, SHARPNESS)
    return against_root(
        f"ball of the screw, {name}",
        lambda: ball_motion(g, load.force[1], load.angle[1]),
        lambda: ball_motion_by_root(one, law, one.motion.q),
        repeats,
    )


def ball_jobs(repeats: int) -> Iterator[FrictionJob]:
    """One ball at given loads."""
    for case in CASES:
        yield rotary_job(case, repeats)
    for make in (plain, inferred):
        yield screw_job(f"{make.__name__} reading", make(), repeats)


def against_source(
    ours: float, theirs: Callable[[], SourceMotion], force: Array, repeats: int, begin: str = "from rolling"
) -> tuple[float | None, str]:
    """Ratio of the source's root finding to ``ours`` [s], None unless it finds the ball-to-ball forces found here (N-1,)
    [N]; what it is of, or why there is none (`worded`).

    begin: label of where the source's search starts.
    """
    found, largest = theirs(), float(force.max())
    off, way = float(np.max(np.abs(found.ball_force - force))) / largest, f"the source's root finding {begin}"
    if found.status == "failed":
        return None, f"{way} fails"
    if found.status == "overlapping":
        return None, (
            f"{way} lets balls overlap, as it decides from the motions without contact what touches (3.31); "
            f"ball-to-ball forces off by up to {off:.0%} of the largest"
        )
    if off > SAME:
        return None, f"{way} ends {off * largest:.3g} N off our ball-to-ball force"
    return timed(theirs, repeats) / ours, f"{way}, without and in contact"


def worded(ratio: float | None, how: str) -> str:
    """Basis of a ratio, or why there is none."""
    return f"{'no ratio' if ratio is None else 'ratio'}: {how}"


def linear_jobs(repeats: int) -> Iterator[FrictionJob]:
    """Two balls of a linear bearing, then chains: the source's roots without a sigmoid, as 3.25 prints them."""
    for count in (2, *CHAINS):
        state = pair_state(LINEAR, THETA, SIDE, VERTICAL) if count == 2 else chain_state(count)
        chain = prepare(LINEAR, *state)
        ours = timed(partial(solve_linear_chain, chain), 10 * repeats)
        theirs = partial(solve_linear_by_root, LINEAR, *state)
        ratio, how = against_source(ours, theirs, solve_linear_chain(chain).ball_force, 5 * repeats)
        how = worded(ratio, how + ", over the chain solver in contact only" if ratio else how)
        name = "linear pair, given loads" if count == 2 else f"linear chain, {count} balls"
        yield FrictionJob(name, ours, LINEAR_PAIR if count == 2 else count * BALL, ratio, f"prepared, in contact; {how}")
    case, printed = (LINEAR, THETA, SIDE, VERTICAL), entry("lin-3.5", "a_time_numerical").printed
    ours, force = timed(lambda: solve_linear_pair(*case), 10 * repeats), np.array([solve_linear_pair(*case).force])
    ratio, how = against_source(ours, lambda: linear_pair_by_root(*case), force, 5 * repeats)
    note = f"loads, without and in contact; {worded(ratio, how)}; the source prints {printed} s on another machine"
    yield FrictionJob("linear pair, all of it", ours, LINEAR_PAIR, ratio, note)


def pair_jobs(repeats: int) -> Iterator[FrictionJob]:
    """Two balls of a screw, without and in contact, with their loads."""
    printed = entry("lin-3.7", "time_a").printed
    for make, words in ((inferred, "loads not coupled"), (plain, "friction moves the balls")):
        pair = make()
        ratio, how = screw_ratio(pair, seconds := timed(partial(solve_pair, pair), 2 * repeats), 2 * repeats)
        note = f"loads ({words}), without and in contact; {worded(ratio, how)}; "
        note += f"the source prints {printed} s on another machine"
        yield FrictionJob(f"screw pair, {make.__name__} reading", seconds, SCREW_PAIR, ratio, note)


def screw_ratio(pair: Pair, ours: float, repeats: int) -> tuple[float | None, str]:
    """The same for a pair of a screw, from rolling and, where that does not lead to our answer, from the solution."""
    best = solve_pair(pair)
    force, near = np.array([best.force]), (state_of(best, False), state_of(best, True))
    try:
        ratio, how = against_source(ours, lambda: screw_pair_by_root(pair).motion, force, repeats)
        if ratio is not None:
            return ratio, how
        theirs = partial(screw_pair_by_root, pair, None, *near)
        again, how_again = against_source(ours, lambda: theirs().motion, force, repeats, "from the solution")
    except RuntimeError:
        return None, "the source's root finding finds no loads"
    return again, f"{how_again} ({how})"


def run_jobs(repeats: int) -> Iterator[FrictionJob]:
    """The whole screw over 200 steps; the source's method over the first of them."""
    run = lin_3_4_4()
    seconds = timed(lambda: equal_steps(run), max(1, repeats // 5))
    note = f"{run.steps} steps, {run.count} balls, theta of 3 deg, loads not coupled"
    begin = perf_counter()
    found = simulate_by_root(run, SOURCE_STEPS)
    theirs = (perf_counter() - begin) * run.steps / SOURCE_STEPS
    if found.failures:
        why = f"the source's root finding fails in {found.failures} of its first {SOURCE_STEPS} steps"
        yield FrictionJob("whole screw", seconds, WHOLE, None, f"{note}; {worded(None, why)}")
        return
    note += (
        f"; ratio: the source's root finding, {SOURCE_STEPS} steps times {run.steps / SOURCE_STEPS:g}, over the solver here"
    )
    note += f"; its rule (3.77) lets balls overlap in {found.overlapping} of these"
    yield FrictionJob("whole screw", seconds, WHOLE, theirs / seconds, note)
    agreed = replace(run, coupling="ball and screw", rounds=ROUNDS)
    seconds = timed(lambda: equal_steps(agreed), max(1, repeats // 5))
    note = "the same, friction moves balls and screw, to agreement of loads and friction in every step; the source's "
    yield FrictionJob("whole screw, coupled", seconds, WHOLE, None, note + "root finding is here for given loads only")


def whole_jobs(repeats: int) -> Iterator[FrictionJob]:
    """Friction of a shipped scene: its balls' motions after their loads, and a run in time with loads solved again."""
    scene, friction, drive = scene_of(WHOLE_SCENE), Friction(0.1, 0.1), Drive(2.0 * np.pi)
    at = contacts_of(scene, solve_static(scene, engine="compiled"))
    seconds = timed(lambda: ball_friction(scene, at, friction, drive, fast=True), 4 * repeats)
    note = f"{scene.ball_count} balls, after their loads; {NO_SOURCE}"
    yield FrictionJob(f"motions of all balls of {scene.name}", seconds, ALL_BALLS, None, note)
    drawn = draw(scene)
    balls = balls_of(scene, friction, drive, drawn)
    for model, loads in AGAIN.items():
        setting = Setting(scene, friction, drive, drawn, balls, partial(_compiled, loads, scene))
        simulate(setting, 0.01, 2)
        seconds = timed(partial(simulate, setting, SOURCE_STEPS / RUN_STEPS, SOURCE_STEPS), 1) * RUN_STEPS / SOURCE_STEPS
        note = f"{RUN_STEPS} steps of {scene.ball_count} balls, loads solved in every one by the model {model}; time of "
        note += f"{SOURCE_STEPS} steps times {RUN_STEPS / SOURCE_STEPS:g}; {NO_SOURCE}"
        yield FrictionJob(f"{scene.name} over a turn, {model}", seconds, WHOLE, None, note)


def _compiled(loads: Callable[..., ContactLoads], scene: Scene, met: Specimen, layout: BallLayout) -> ContactLoads:
    """Contact loads by compiled kernels."""
    return loads(scene, met, layout, "compiled")


def jobs(repeats: int = 5) -> Iterator[FrictionJob]:
    """All jobs, compiled kernels, medians of ``repeats`` or a multiple of it."""
    for group in (contact_jobs, ball_jobs, linear_jobs, pair_jobs, run_jobs, whole_jobs):
        yield from group(repeats)
