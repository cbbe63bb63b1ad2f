"""Robustness of the friction solvers on extreme cases, beside how often the root finding of Lin's thesis solved them.

The cases are single balls, pairs, rows of neighbouring balls, and bearings with clearance, with inputs far from those of
the thesis. Every case is solved from the solver's default start and from random ones. Each solution must converge, balance
power input and dissipation, and agree with the first one. How often Lin's root finding solved the same cases was counted
once; the counts are stored in ``root-finding.toml``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from math import radians
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.cases.lin.evidence.rotary_linear import AXIAL, CASES, LINEAR, ROTARY, VERTICAL
from rollbench.compare.cases.lin.evidence.source_cases import (
    four_point_bearing,
    oversized_pair,
    pair_as_printed,
    screw_groove,
)
from rollbench.compare.files import read_shipped_toml
from rollbench.lowfi.friction.bearing import solve_ball_of_bearing, solve_bearing
from rollbench.lowfi.friction.contact.equilibrium import BodyMotionProblem, least_dissipation, least_dissipations
from rollbench.lowfi.friction.linear import chain as linear_chain
from rollbench.lowfi.friction.linear.bearing import contact_angle_deviations, loads_in_equilibrium
from rollbench.lowfi.friction.linear.chain import LinearBallChain
from rollbench.lowfi.friction.screw.chain import ChainMotion, ScrewBallChain, screw_ball_chain, solve_motion_of_chain
from rollbench.lowfi.friction.screw.motion import contact_ellipses_of_screw
from rollbench.lowfi.friction.screw.run import Pair, solve_pair_of_screw_balls
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Cell, ColumnKey, Table, Text

#: Values of k_S, the sharpness of Lin's sigmoid friction law, for which his root finding was tried; 100 in other cases.
SHARPNESSES = (100.0, 1e3, 1e4)

#: Number of random starts for one ball and for several, besides the solver's default start; largest relative distances
#: of near and far random starts from the solution.
STARTS, CHAIN_STARTS, NEAR_START, FAR_START = 12, 3, 0.01, 0.5

#: Smallest values by which errors and starts are scaled: dissipation [W] in the balance of power; ball-to-ball force over
#: the friction bound in random starts.
NO_POWER, NO_FORCE = 1e-13, 0.01

#: Varied values: deviations theta of the contact angle from nominal [deg], friction coefficients, loads [N].
ANGLES, MU, LOADS = (-5.0, -1.0, 1e-3, 2.0, 5.0), (1e-3, 0.01, 0.1, 0.3, 0.5), (1e-3, 0.1, 10.0, 1e3, 1e5)

#: Varied values: side force over vertical load on two balls of the linear bearing, clearances [m].
RHO, CLEARANCE = (-0.999, -0.9, -0.3, 0.3, 0.9, 0.999), (1e-7, 1e-6, 5e-6, 1e-5)

#: Small axial loads [N] on two balls of a screw that has clearance in its grooves.
SMALL = (1e-3, 1e-2, 0.1, 0.3)

#: Numbers of neighbouring balls in a linear bearing and in a ball screw.
BALLS = (2, 5, 10, 20, 50, 100, 200)

#: Fraction of contacts without load, in the cases with unloaded contacts.
UNLOADED = 0.25


class RootFindingCount(NamedTuple):
    """How often Lin's root finding solved a group of cases, as it was counted once."""

    #: Number of solutions in which no balls overlap.
    solved: int
    #: Number of starts.
    tries: int
    #: Number of roots with overlapping balls.
    overlapping: int = 0
    #: Number of solutions with ball-to-ball forces that differ from this package's solution.
    other_forces: int = 0


@cache
def root_finding_counts() -> dict[tuple[str, str, str], RootFindingCount]:
    """Return the stored counts of Lin's root finding, by group, model and note of `ExtremeGroup`."""
    rows = [dict(row) for row in read_shipped_toml("cases/lin/root-finding.toml")["counts"]]
    keys = [(row.pop("varied"), row.pop("model"), row.pop("note", "")) for row in rows]
    return {key: RootFindingCount(**row) for key, row in zip(keys, rows, strict=True)}


@dataclass
class ExtremeGroup:
    """Running counts and largest errors of the solutions of one group of extreme cases; each solution updates them."""

    #: Inputs that are varied in the group, in words.
    group: str
    #: Name of the friction model with the kind of bearing or screw, such as "screw pair".
    model: str
    #: Remark on the group; empty for none.
    note: str = ""
    #: Number of cases in the group.
    cases: int = 0
    #: Number of solution runs by this package's solvers that converged.
    ours: int = 0
    #: Number of solution runs by this package's solvers, converged or not.
    tries: int = 0
    #: Largest difference of power input and dissipation in any solution, divided by the dissipation.
    energy: float = 0.0
    #: Largest difference between the results of one case from several starting points. For one ball: of its friction loss,
    #: divided by the loss; for several balls: of the ball-to-ball force, divided by the largest possible friction force.
    spread: float = 0.0
    #: Number of random starts from which the solver converged without falling back on its default start.
    converged_from_random_starts: int = 0
    #: Number of random starts.
    random_starts: int = 0

    def count_own_solution(self, converged: bool, power: float, loss: float, relative_difference: float) -> None:
        """Count one solution of this package's friction solver, and update the largest errors.

        ``converged``: whether this solution converged; ``power``: power [W] put in by the driven surfaces; ``loss``: power
        [W] dissipated by friction; ``relative_difference``: relative difference of this solution's loss or ball-to-ball
        forces from those of the first solution of the same case.
        """
        self.tries += 1
        self.ours += converged
        self.energy = max(self.energy, abs(power - loss) / max(loss, NO_POWER))
        self.spread = max(self.spread, relative_difference)

    @property
    def counted(self) -> RootFindingCount | None:
        """Stored count of Lin's root finding on the same cases; None if it was not tried on them."""
        return root_finding_counts().get((self.group, self.model, self.note))

    @property
    def remark(self) -> str:
        """Remark for the table: `note`, then those on random starts and on roots of Lin's method that are no solutions."""
        remarks = [self.note] if self.note else []
        if self.random_starts:
            remarks.append(
                f"{self.converged_from_random_starts} of {self.random_starts} random starts led there by themselves"
            )
        if self.counted is not None and self.counted.overlapping:
            remarks.append(f"roots by Lin's method that let balls overlap: {self.counted.overlapping}")
        if self.counted is not None and self.counted.other_forces:
            remarks.append(f"roots by Lin's method that differ from the solution found here: {self.counted.other_forces}")
        return "; ".join(remarks)


def screw_ball_problem(pair: Pair, force: Array | None = None) -> BodyMotionProblem:
    """Return the problem of finding how one ball of a ball screw slides and spins, given the loads of its contacts.

    The ball is the second of a pair whose balls do not touch each other.

    ``pair``: both balls with their grooves; ``force``: loads (4,) [N] of the ball's contacts SL, SR, NL and NR (screw or
    nut, left or right) at the nominal contact angle; None: loads and contact angles of the solved pair.
    """
    g = pair.groove
    angle = np.full(4, g.contact_angle)
    if force is None:
        load = solve_pair_of_screw_balls(pair).apart.loads_with_friction
        force, angle = load.force[1], load.angle[1]
    maps, drives = g.contact_kinematics(g.normals(angle))
    return BodyMotionProblem(contact_ellipses_of_screw(g, force), maps, drives, np.zeros(4))


def solve_ball_group(
    group: str, model: str, balls: Sequence[BodyMotionProblem], note: str = "", start_distance: float = FAR_START
) -> ExtremeGroup:
    """Solve a group of single balls by least dissipation, also from random starts, and return the group's results.

    ``group``: name of the inputs that are varied; ``model``: name of the model; ``balls``: motion problems; ``note``:
    remark for the table; ``start_distance``: largest relative distance of the random starts from the solution.
    """
    rng, tally = np.random.default_rng(1), ExtremeGroup(group, model, note, len(balls))
    for ball in balls:
        first = least_dissipation(ball)
        motion = first.unknown_velocities
        size = float(np.max(np.abs(motion))) or 1.0
        largest = np.maximum(np.abs(motion), 0.01 * size)
        starts = [motion + start_distance * rng.uniform(-1.0, 1.0, motion.size) * largest for _ in range(STARTS)]
        for m in (first, *least_dissipations([ball] * STARTS, np.array(starts))):
            wrench = np.column_stack([m.friction.force, m.friction.moment])  # friction on the ball at each contact
            power = -float(np.sum(wrench * ball.imposed_contact_motions))  # that the driven surfaces supply [W]
            apart = abs(m.loss - first.loss) / first.loss if first.loss > 0.0 else abs(m.loss)
            tally.count_own_solution(m.status != "failed", power, m.loss, apart)
    return tally


def solve_all_single_ball_groups() -> list[ExtremeGroup]:
    """Solve all groups of single balls under given contact loads, and return the results of each group.

    The sharpness k_S is that of Lin's method alone: the groups for several values have the same solutions here.
    """
    two, cases = radians(2.0), CASES.values()
    oversized, printed = oversized_pair(two), pair_as_printed(two)

    def rotary(axial: float = AXIAL, u_y: float = 0.0, **changes: Any) -> BodyMotionProblem:
        """Return the motion problem of the rotary bearing's ball, with changed fields of the bearing."""
        return solve_ball_of_bearing(replace(ROTARY, **changes), axial, u_y).problem

    def screw(pair: Pair, **changes: Any) -> BodyMotionProblem:
        """Return the motion problem of a ball of the pair ``pair``, with changed fields of the pair."""
        return screw_ball_problem(replace(pair, **changes))

    as_printed = [rotary(u_y=u, hertz="as printed") for u in cases]
    of_table = [screw_ball_problem(pair) for pair in (printed, oversized)]
    rows = []
    for off in (NEAR_START, FAR_START):
        kinds = ("rotary, cases I to III as printed", as_printed), ("screw, pair of Table 3.7", of_table)
        found = [solve_ball_group("", model, balls, f"starts within {off:.0%}", off) for model, balls in kinds]
        rows += [replace(tally, group=f"k_S {k:g}") for k in SHARPNESSES for tally in found]

    # contact loads SL, SR, NL, NR [N] of a screw's ball, whose second diagonal (SR and NL) is loaded less and less
    diagonals = [100.0 * np.array([1.0, 10.0**-k, 10.0**-k, 1.0]) for k in range(13)]
    around, mu, loads = 1e-6 * np.linspace(4.2, 4.5, 13), "mu 0.001 to 0.5", "loads 1e-3 to 1e5 N"
    transition, loose, still = "two-point transition", "clearance to 10 µm", "zero speed"
    groups: tuple[tuple[str, str, list[BodyMotionProblem], str], ...] = (
        ("theta to ±5°", "screw", [screw(oversized_pair(radians(t))) for t in ANGLES], ""),
        (mu, "screw", [screw(oversized, groove=screw_groove(mu=m)) for m in MU], ""),
        (mu, "rotary", [rotary(u_y=u, mu=m) for m, u in product(MU, cases)], ""),
        (transition, "rotary", [rotary(u_y=float(u)) for u in around], "radial displacement 4.2 to 4.5 µm"),
        (
            transition,
            "screw",
            [screw_ball_problem(oversized_pair(0.0), force) for force in diagonals],
            "load of the second diagonal down to 1e-12 of the first",
        ),
        (loads, "rotary", [rotary(f, u) for f, u in product(LOADS, cases)], ""),
        (loads, "screw", [screw(oversized, force=(f,)) for f in LOADS], ""),
        (loose, "rotary", [rotary(u_y=u, clearance=c) for c, u in product(CLEARANCE, (0.0, 5.2e-6, 20e-6))], ""),
        (loose, "screw", [screw(printed, oversize=-c, coupling="none") for c in CLEARANCE], ""),
        (still, "rotary", [rotary(u_y=u, screw_speed=0.0) for u in cases], "nothing turns"),
        (still, "screw", [screw(oversized, groove=screw_groove(nut_speed=0.0))], "nothing turns"),
    )
    return rows + [solve_ball_group(*group) for group in groups]


# --- extreme cases of two and more neighbouring balls in a linear bearing and a ball screw, and of a bearing with clearance


def solve_linear_group(
    group: str,
    cases: Sequence[LinearBallChain],
    model: str = "linear pair",
    random_starts: int = CHAIN_STARTS,
    note: str = "",
) -> ExtremeGroup:
    """Solve neighbouring balls of a linear bearing by least dissipation, and return the group's results.

    ``group``: name of the inputs that are varied; ``cases``: rows of balls; ``model``: name of the model;
    ``random_starts``: number of random starts in addition to the solver's default start; ``note``: remark for the table.
    """
    rng, tally = np.random.default_rng(2), ExtremeGroup(group, model, note, len(cases))
    for c in cases:
        first = solve_motion_of_chain(c).ball_force
        for k in range(random_starts + 1):
            q = c.groove.nominal_motion * rng.uniform(-3.0, 3.0, (len(c.force), 4)) if k else None
            start = None if q is None else (q, np.zeros(len(q)))
            r = solve_motion_of_chain(c, start)
            apart = float(np.max(np.abs(r.ball_force - first))) / (c.largest_friction_bound or 1.0)
            tally.count_own_solution(r.converged, r.input_power, r.loss, apart)
    return tally


def linear_pair(
    theta: float, rho: float, vertical: float = VERTICAL, mu: float = LINEAR.mu, speed: float = LINEAR.speed
) -> LinearBallChain:
    """Return two neighbouring balls of the linear bearing of section 3.3 of Lin's thesis, with their contact loads.

    ``theta``: deviation of the contact angle from nominal [deg]; ``rho``: side force divided by vertical load;
    ``vertical``: vertical load on each ball [N]; ``mu``: friction coefficient of grooves and of touching balls;
    ``speed``: speed of the carriage [m/s].
    """
    bearing = replace(LINEAR, mu=mu, mu_balls=mu, speed=speed)
    angles, loads = linear_chain.pair_angles_and_loads(bearing, radians(theta), rho, vertical, loads="elastic")
    return linear_chain.prepare_linear_chain(bearing, angles, loads)


def random_linear_balls(count: int, mu: float = LINEAR.mu, *, unloaded: bool = False) -> LinearBallChain:
    """Return neighbouring balls of the linear bearing of Lin's section 3.3 with random contact angles and loads.

    The loads balance the vertical load and a random side force of each ball. ``count``: number of balls, also the seed of
    the random numbers; ``mu``: friction coefficient of grooves and of touching balls; ``unloaded``: whether about a quarter
    of the contact loads are zero, and those of a ball are not in equilibrium.
    """
    rng = np.random.default_rng(count)
    angles = LINEAR.contact_angle + contact_angle_deviations(np.radians(rng.uniform(-3.0, 3.0, count)))
    loads = loads_in_equilibrium(angles, VERTICAL, rng.uniform(-0.6, 0.6, count))
    if unloaded:
        rng = np.random.default_rng(1000 + count)
        loads = loads * rng.uniform(0.2, 1.8, loads.shape)
        loads = np.where(rng.uniform(size=loads.shape) < UNLOADED, 0.0, loads)
    return linear_chain.prepare_linear_chain(replace(LINEAR, mu=mu, mu_balls=mu), angles, loads)


def solve_screw_group(
    tally: ExtremeGroup, solved: Iterable[tuple[bool, ScrewBallChain, ChainMotion]], seed: int, start_distance: float
) -> ExtremeGroup:
    """Count solved rows of neighbouring balls of a screw in ``tally``, and solve them from random starts too.

    ``solved``: whether a case converged, its balls with their contact loads, and its solution, with whose ball-to-ball
    forces those from random starts are compared; ``seed``: of the random starts; ``start_distance``: largest relative
    distance of the starting motion from the solution. Returns ``tally``.
    """
    rng = np.random.default_rng(seed)
    for converged, chain, known in solved:
        tally.count_own_solution(converged, known.input_power, known.loss, 0.0)
        bound = chain.groove.mu * float(chain.force.sum(axis=1).max())
        size = np.maximum(known.ball_force, NO_FORCE * bound)
        for _ in range(CHAIN_STARTS):
            q = known.q * rng.uniform(1.0 - start_distance, 1.0 + start_distance, known.q.shape)
            m = solve_motion_of_chain(chain, (q, size * rng.uniform(0.0, 2.0, size.size)))
            apart = float(np.max(np.abs(m.ball_force - known.ball_force))) / bound
            tally.count_own_solution(m.converged, m.input_power, m.loss, apart)
            tally.random_starts += 1
            tally.converged_from_random_starts += m.found_from_given_start
    return tally


def solved_pair(pair: Pair) -> tuple[bool, ScrewBallChain, ChainMotion]:
    """Solve loads and motions of two touching balls of a screw: converged or not, the loaded balls, their motion."""
    r = solve_pair_of_screw_balls(pair)
    load, slack = r.touching.loads_with_friction, np.array([0.0, np.inf])
    chain = screw_ball_chain(pair.groove, load.force, pair.groove.normals(load.angle), slack)
    return r.converged, chain, r.touching.motion


def random_screw_balls(count: int) -> ScrewBallChain:
    """Return neighbouring balls of a screw with random contact loads, contact angles and permitted closing rates.

    ``count``: number of balls, also the seed of the random numbers. The permitted closing rate is the largest rate [rad/s]
    at which a ball may gain on the next one; it is infinite for the last ball.
    """
    g, rng = screw_groove(), np.random.default_rng(count)
    force = rng.uniform(20.0, 60.0, (count, 4))
    angle = g.contact_angle + np.radians(rng.uniform(-3.0, 3.0, (count, 4)))
    slack = np.where(rng.uniform(size=count) < 0.7, 0.0, rng.uniform(0.0, 0.05, count))
    return screw_ball_chain(g, force, g.normals(angle), np.append(slack[:-1], np.inf))


def solve_bearing_clearance_group() -> ExtremeGroup:
    """Solve the four-point bearing of Lin's Table 4.2 with several clearances, and return the results of all cases.

    Loads and motions are solved under a load at 12 deg to the axis, for an inner ring that is free to tilt and one that
    is not.
    """
    tally = ExtremeGroup("clearance to 10 µm", "four-point bearing, 9 balls", "one start each", 2 * len(CLEARANCE))
    for c, tilt in product(CLEARANCE, (False, True)):
        s = solve_bearing(four_point_bearing(clearance=c, tilt=tilt), radians(12.0))
        tally.count_own_solution(bool(s.converged[0]), float(s.input_power[0]), float(s.loss.sum()), 0.0)
    return tally


def solve_all_groups_of_touching_balls() -> list[ExtremeGroup]:
    """Solve all groups of two and more neighbouring balls, and of a bearing with clearance; return each group's results."""
    two, counts = radians(2.0), f"{', '.join(map(str, BALLS))} balls"
    base, printed = oversized_pair(two), pair_as_printed(two)
    mu, loads, sides = "mu 0.001 to 0.5", "loads 1e-3 to 1e5 N", (-0.6, -0.999)
    linear: tuple[tuple[str, list[LinearBallChain]], ...] = (
        ("rho to ±0.999, theta to ±5°", [linear_pair(t, r) for t, r in product(ANGLES, RHO)]),
        (mu, [linear_pair(2.0, r, VERTICAL, m) for r, m in product(sides, MU)]),
        (loads, [linear_pair(2.0, r, f) for r, f in product(sides, LOADS)]),
        ("two-point transition", [linear_pair(2.0, -1.0 + 10.0**-k) for k in range(1, 13)]),
        ("zero speed", [linear_pair(2.0, -0.6, speed=0.0)]),
    )
    few = 1, "one random start; Lin's method up to 20 balls"
    balls = [random_linear_balls(n, m) for n, m in product(BALLS, MU)]
    unloaded = [random_linear_balls(n, m, unloaded=True) for n, m in product(BALLS, MU)]
    pairs: tuple[tuple[str, list[Pair], str], ...] = (
        ("theta to ±5°", [oversized_pair(radians(t)) for t in ANGLES], ""),
        (mu, [replace(base, groove=screw_groove(mu=m)) for m in MU], ""),
        (loads, [replace(base, force=(f,)) for f in LOADS], ""),
        (
            "two-point transition",
            [replace(base, oversize=o) for o in 1e-6 * np.linspace(0.8, 1.1, 13)],
            "oversize 0.8 to 1.1 µm",
        ),
        ("clearance to 10 µm", [replace(printed, oversize=-c, coupling="none") for c in CLEARANCE], "loads not coupled"),
        ("clearance to 10 µm", [replace(printed, oversize=-c) for c in CLEARANCE], "friction moves the balls"),
        (
            "small loads and clearance",
            [replace(printed, oversize=-c, force=(f,)) for c, f in product(CLEARANCE[1:], SMALL)],
            "friction moves the balls; 1e-3 to 0.3 N, 1 to 10 µm",
        ),
        ("zero speed", [replace(base, groove=screw_groove(nut_speed=0.0))], ""),
    )
    screws = [random_screw_balls(n) for n in BALLS]
    chains = ((m.converged, chain, m) for chain in screws for m in (solve_motion_of_chain(chain),))
    return [
        *(solve_linear_group(*group) for group in linear),
        solve_linear_group("chains", [random_linear_balls(n) for n in BALLS], f"linear, {counts}"),
        solve_linear_group(f"chains, {mu}", balls, f"linear, {counts}", *few),
        solve_linear_group(f"chains, {mu}", unloaded, "the same, a quarter of the contacts unloaded", *few),
        *(
            solve_screw_group(ExtremeGroup(group, "screw pair", note, len(of)), map(solved_pair, of), 3, FAR_START)
            for group, of, note in pairs
        ),
        solve_screw_group(ExtremeGroup("chains", f"screw, {counts}", "", len(BALLS)), chains, 4, NEAR_START),
        solve_bearing_clearance_group(),
    ]


def solve_all_extreme_groups() -> list[ExtremeGroup]:
    """Solve all groups of extreme cases of the friction models, and return the results of each group."""
    return [*solve_all_single_ball_groups(), *solve_all_groups_of_touching_balls()]


def root_finding_success_in_words(found: Sequence[ExtremeGroup]) -> str:
    """Return in words from how many starts Lin's root finding found a solution, for each model, the lowest fraction first.

    ``found``: results of groups of cases; those that Lin's method was not tried on are left out.
    """
    counts: dict[str, Array] = {}
    for r in found:
        if r.counted is not None:
            counts[r.model] = counts.get(r.model, np.zeros(2, dtype=int)) + r.counted[:2]
    worst_first = sorted(counts.items(), key=lambda item: item[1][0] / item[1][1])
    return "; ".join(f"{model}: {solved} of {tries}" for model, (solved, tries) in worst_first)


def extreme_cases_text_and_table(found: Sequence[ExtremeGroup] | None = None) -> tuple[Text | Table, ...]:
    """Return text and table of the report on all extreme cases of the friction models.

    ``found``: results of all groups of cases; None: all cases are solved here.
    """
    found = solve_all_extreme_groups() if found is None else found
    counts = [r.counted for r in found]
    tried = [count for count in counts if count is not None]
    columns: dict[ColumnKey, Sequence[Cell]] = {
        "varied_input": [r.group for r in found],
        "friction_model": [r.model for r in found],
        "cases": [r.cases for r in found],
        "solved_here": [f"{r.ours} of {r.tries}" for r in found],
        "largest_power_error": [r.energy for r in found],
        "result_spread": [r.spread for r in found],
        "solved_by_lin": ["–" if count is None else f"{count.solved} of {count.tries}" for count in counts],
        "remark": [r.remark for r in found],
    }
    text = (
        f"This package's solvers find {sum(r.ours for r in found)} of {sum(r.tries for r in found)} solutions. Lin's root "
        f"finding found {sum(c.solved for c in tried)} of {sum(c.tries for c in tried)}, as it was counted once, with "
        f"version 0.16.0. By model, the worst first: {root_finding_success_in_words(found)}. Lin's method decides which "
        "balls touch from their motions without contact (Lin 3.31, 3.77), so "
        "that its roots for longer rows of balls may let balls overlap; these do not count as solved.",
    )
    note = (
        "Each case is solved from the solver's default start and from random ones. Difference between starts: of the loss "
        "of one ball, or of ball-to-ball forces over the largest friction bound. Lin's method (stored counts): a root of "
        "the force balance under his sigmoid friction law (sharpness k_S = 100 unless varied), by MINPACK's hybrid "
        f"method with a short first step. Random starts: for one ball {STARTS} within {FAR_START:.0%} of the solution "
        f"unless stated otherwise; for pairs and chains {CHAIN_STARTS} within {FAR_START:.0%} ({NEAR_START:.0%} for chains "
        "of a screw). A chain of a screw that Newton's method does not solve from a random start is restarted from the "
        "default start. Where friction between balls permits more than one state (jammed or apart), the state reached by "
        "continuation from zero friction is reported. A nearly unloaded ball of a screw with clearance may also float or "
        "be wedged by its own friction; its restarts keep the loads found first."
    )
    title = "Extreme cases: solutions from all starting points, by this package's friction solvers and Lin's method"
    return Text(text), Table("friction-extremes", title, columns, note)
