"""Stability of friction and ball motion at extremes: the source's root finding against least dissipation and chains.

The cases are single balls, pairs, chains, and bearings with clearance, varied far from the printed cases; further
runs start around these. Every case is solved here from the solver's start and from random ones: each solution must
converge, balance power input and dissipation, and agree with the first. The source's method finds a root of the force
balance under its sigmoid friction law from random starts: for one ball at the loads of the same case, for several
balls as ``lowfi.friction.as_source.screw`` does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from math import radians

import numpy as np

from rollbench.compare.cases.lin.evidence.rotary_linear import AXIAL, CASES, LINEAR, ROTARY, VERTICAL, solve_rotary
from rollbench.compare.cases.lin.evidence.source_cases import case_as_printed, four_point, inferred, table_3_6
from rollbench.lowfi.friction.as_source.chain import SHARPNESS, SourceMotion
from rollbench.lowfi.friction.as_source.screw import (
    linear_solutions_from_starts,
    pair_solutions_from_starts,
    screw_sigmoid,
    screw_solutions_from_starts,
)
from rollbench.lowfi.friction.bearing import Bearing, solve_ball, solve_bearing
from rollbench.lowfi.friction.contact.laws import Sigmoid
from rollbench.lowfi.friction.contact.motion import Problem, balance_by_root, least_dissipation
from rollbench.lowfi.friction.linear.bearing import LinearBearing, angle_deviations, balanced_loads
from rollbench.lowfi.friction.linear.chain import Chain, pair_angles_and_loads, prepare_chain, solve_linear_chain
from rollbench.lowfi.friction.screw.chain import Chain as ScrewChain
from rollbench.lowfi.friction.screw.chain import ChainMotion, solve_chain
from rollbench.lowfi.friction.screw.motion import screw_contacts, source_law
from rollbench.lowfi.friction.screw.run import Pair, solve_pair
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Cell, Quantity, Row, Table, Text

#: Sharpness of the source's sigmoid, Lin's k_S, in its own formulation; 100 where it is not what is varied.
SHARPNESSES = (100.0, 1e3, 1e4)

#: Random starts of one ball and of chains, besides the solver's own; how far they are off the solution, relative.
STARTS, CHAIN_STARTS, NEAR_START, FAR_START = 12, 3, 0.01, 0.5

#: Power [W] and, over the friction bound, ball-to-ball force below which random starts and balances are not scaled.
NO_POWER, NO_FORCE = 1e-13, 0.01

ANGLES, MU, LOADS = (-5.0, -1.0, 1e-3, 2.0, 5.0), (1e-3, 0.01, 0.1, 0.3, 0.5), (1e-3, 0.1, 10.0, 1e3, 1e5)

RHO, CLEARANCE = (-0.999, -0.9, -0.3, 0.3, 0.9, 0.999), (1e-7, 1e-6, 5e-6, 1e-5)

#: Small axial loads [N] of pairs of a screw with clearance.
SMALL = (1e-3, 1e-2, 0.1, 0.3)

#: Sizes of the chains, of a linear bearing and of a ball screw.
BALLS = (2, 5, 10, 20, 50, 100, 200)

#: Largest chain that the source's method is tried on, in the groups of chains over friction.
SOURCE_BALLS = 20

#: Fraction of the contacts without load in the chains that lack some.
UNLOADED = 0.25

#: Difference of ball-to-ball force over the friction bound from which a root of the source's is another answer.
OTHER = 1e-3


@dataclass(frozen=True)
class Record:
    """Results of one group of cases."""

    #: Name of the group.
    group: str
    #: Model.
    model: str
    #: Number of cases.
    cases: int
    #: Number of solutions of the solvers here that converged.
    ours: int
    #: Number of solutions that were tried.
    tries: int
    #: Largest relative excess of power in over dissipation.
    energy: float
    #: Largest relative difference of the results from several starts (loss of one ball, ball-to-ball forces of several).
    spread: float
    #: Number of roots found by the source's method; None if it has no such model.
    source: int | None = None
    #: Number of its searches.
    source_tries: int | None = None
    #: Remark.
    note: str = ""


@dataclass
class Tally:
    """Running counts for one group, updated with each solved case."""

    cases: int = 0
    ours: int = 0
    tries: int = 0
    energy: float = 0.0
    spread: float = 0.0
    source: int = 0
    source_tries: int = 0
    direct: int = 0
    restarts: int = 0
    overlapping: int = 0
    other: int = 0

    def theirs(self, found: SourceMotion | None, force: Array, bound: float) -> None:
        """Count one run of the source's method against the ball-to-ball forces found here [N].

        ``found`` is None if that method found no loads; ``bound``: friction bound [N], the scale of differences. A
        run counts as solved if its root has no balls that overlap or pull; ``other`` counts such roots with other
        forces than ``force``.
        """
        self.source_tries += 1
        if found is None or found.status == "failed":
            return
        self.overlapping += found.status == "overlapping"
        if found.status == "exact":
            self.source += 1
            self.other += float(np.max(np.abs(found.ball_force - force), initial=0.0)) > OTHER * (bound or 1.0)

    def add(self, good: bool, power: float, loss: float, apart: float) -> None:
        """Count one solution: whether it converged, power in and loss [W], relative difference from the first."""
        self.tries += 1
        self.ours += good
        self.energy = max(self.energy, abs(power - loss) / max(loss, NO_POWER))
        self.spread = max(self.spread, apart)

    def record(self, group: str, model: str, note: str = "") -> Record:
        """Return the group's record."""
        tried = self.source_tries or None
        if self.restarts:
            led = f"{self.direct} of {self.restarts} random starts led there by themselves"
            note = f"{note}; {led}" if note else led
        for count, what in ((self.overlapping, "let balls overlap"), (self.other, "differ from the answer found here")):
            if count:
                roots = f"roots of the source's that {what}: {count}"
                note = f"{note}; {roots}" if note else roots
        return Record(
            group,
            model,
            self.cases,
            self.ours,
            self.tries,
            self.energy,
            self.spread,
            self.source if tried else None,
            tried,
            note,
        )


@dataclass(frozen=True)
class OneBall:
    """One ball at given loads: its problem, the source's friction law, and the power [W] that drives it."""

    problem: Problem
    law: Sigmoid
    power: Callable[[Array], float]


def rotary_ball(bearing: Bearing, axial: float, u_y: float, sharpness: float = SHARPNESS) -> OneBall:
    """Return a ball of the rotary bearing at an axial load [N] and a radial displacement [m]."""
    s = solve_ball(bearing, axial, u_y, fast=True)
    return OneBall(s.problem, screw_sigmoid(bearing, sharpness), lambda f: _drive_power(s.problem, f))


def screw_ball(pair: Pair, force: Array | None = None, sharpness: float = SHARPNESS) -> OneBall:
    """Return the second ball of a separate screw pair at its loads, or at given contact loads (4,) [N]."""
    g = pair.groove
    angle = np.full(4, g.contact_angle)
    if force is None:
        load = solve_pair(pair).free.load
        force, angle = load.force[1], load.angle[1]
    maps, drives = g.maps(g.normals(angle))
    problem = Problem(screw_contacts(g, force), maps, drives, np.zeros(4))
    return OneBall(problem, screw_sigmoid(g, sharpness), lambda f: _drive_power(problem, f))


def _drive_power(problem: Problem, wrench: Array) -> float:
    """Return the power [W] that the driven surfaces put in against the friction force (m, 3) on the ball."""
    return -float(np.sum(wrench * problem.drives))


def try_ball(tally: Tally, ball: OneBall, rng: np.random.Generator, off: float) -> None:
    """Solve a ball by least dissipation and by the source's root finding from random starts up to ``off`` away."""
    tally.cases += 1
    first = least_dissipation(ball.problem, fast=True)
    size = float(np.max(np.abs(first.q))) or 1.0
    starts = [
        first.q + off * rng.uniform(-1.0, 1.0, first.q.size) * np.maximum(np.abs(first.q), 0.01 * size)
        for _ in range(STARTS)
    ]
    for m in (first, *(least_dissipation(ball.problem, q, fast=True) for q in starts)):
        wrench = np.column_stack([m.friction.force, m.friction.moment])
        apart = abs(m.loss - first.loss) / first.loss if first.loss > 0.0 else abs(m.loss)
        tally.add(m.status != "failed", ball.power(wrench), m.loss, apart)
    for q in starts:
        tally.source += balance_by_root(ball.problem, ball.law, q, fast=True).status == "exact"
        tally.source_tries += 1


def ball_group(group: str, model: str, balls: Sequence[OneBall], note: str = "", off: float = FAR_START) -> Record:
    """Solve a group of single balls and return its record; ``off``: largest relative distance of random starts."""
    rng, tally = np.random.default_rng(1), Tally()
    for ball in balls:
        try_ball(tally, ball, rng, off)
    return tally.record(group, model, note)


def screw_share(share: float) -> OneBall:
    """Return a screw ball whose second diagonal carries a given share of the load of the first."""
    return screw_ball(inferred(0.0), 100.0 * np.array([1.0, share, share, 1.0]))


def ball_rows() -> list[Record]:
    """Return the records of all groups of single balls at given loads."""
    two, rest = radians(2.0), table_3_6(nut_speed=0.0)
    around = 1e-6 * np.linspace(4.2, 4.5, 13)
    loose = [replace(ROTARY, clearance=c) for c in CLEARANCE]
    rows = []
    for off, k in product((NEAR_START, FAR_START), SHARPNESSES):
        note = f"starts within {off:.0%}"
        printed = [rotary_ball(replace(ROTARY, hertz="as printed"), AXIAL, u, k) for u in CASES.values()]
        rows.append(ball_group(f"k_S {k:g}", "rotary, cases I to III as printed", printed, note, off))
        pairs = [screw_ball(p(two), None, k) for p in (case_as_printed, inferred)]
        rows.append(ball_group(f"k_S {k:g}", "screw, pair of Table 3.7", pairs, note, off))
    rows += [
        ball_group("theta to ±5°", "screw", [screw_ball(inferred(radians(t))) for t in ANGLES]),
        ball_group("mu 0.001 to 0.5", "screw", [screw_ball(replace(inferred(two), groove=table_3_6(mu=m))) for m in MU]),
        ball_group(
            "mu 0.001 to 0.5",
            "rotary",
            [rotary_ball(replace(ROTARY, mu=m), AXIAL, u) for m, u in product(MU, CASES.values())],
        ),
        ball_group(
            "two-point transition",
            "rotary",
            [rotary_ball(ROTARY, AXIAL, float(u)) for u in around],
            "radial displacement 4.2 to 4.5 µm",
        ),
        ball_group(
            "two-point transition",
            "screw",
            [screw_share(10.0**-k) for k in range(13)],
            "load of the second diagonal down to 1e-12 of the first",
        ),
        ball_group("loads 1e-3 to 1e5 N", "rotary", [rotary_ball(ROTARY, f, u) for f, u in product(LOADS, CASES.values())]),
        ball_group("loads 1e-3 to 1e5 N", "screw", [screw_ball(replace(inferred(two), force=(f,))) for f in LOADS]),
        ball_group(
            "clearance to 10 µm", "rotary", [rotary_ball(b, AXIAL, u) for b, u in product(loose, (0.0, 5.2e-6, 20e-6))]
        ),
        ball_group(
            "clearance to 10 µm",
            "screw",
            [screw_ball(replace(case_as_printed(two), oversize=-c, coupling="none")) for c in CLEARANCE],
        ),
        ball_group(
            "zero speed",
            "rotary",
            [rotary_ball(replace(ROTARY, screw_speed=0.0), AXIAL, u) for u in CASES.values()],
            "nothing turns",
        ),
        ball_group("zero speed", "screw", [screw_ball(replace(inferred(two), groove=rest))], "nothing turns"),
    ]
    return rows


# --- extreme cases of pairs and chains of balls, in a linear bearing and in a ball screw, and of a bearing with clearance


@dataclass(frozen=True)
class LinearCase:
    """Linear bearing with balls close enough to touch each other: contact angles [rad] and loads [N], (N, 4)."""

    bearing: LinearBearing
    angles: Array
    loads: Array

    def chain(self) -> Chain:
        """Return the balls prepared for the chain solver."""
        return prepare_chain(self.bearing, self.angles, self.loads)


def chain_group(
    group: str,
    cases: Sequence[LinearCase],
    model: str = "linear pair",
    starts: int = CHAIN_STARTS,
    most: int = 200,
    note: str = "",
) -> Record:
    """Solve chains of the linear bearing by both methods and return the record of the group.

    ``starts``: number of random starts besides the solver's; ``most``: largest number of balls for the source's
    method.
    """
    rng, tally = np.random.default_rng(2), Tally()
    for case in cases:
        tally.cases += 1
        c = case.chain()
        first = solve_linear_chain(c).ball_force
        for k in range(starts + 1):
            r = solve_linear_chain(c, None if k == 0 else c.problem.nominal * rng.uniform(-3.0, 3.0, (c.count, 3)))
            apart = float(np.max(np.abs(r.ball_force - first))) / (c.scale or 1.0)
            tally.add(r.status == "converged", r.power, r.loss, apart)
        if c.count > most:
            continue
        for found in linear_solutions_from_starts(case.bearing, case.angles, case.loads, rng, starts, FAR_START):
            tally.theirs(found, first, c.scale)
    return tally.record(group, model, note)


def linear_pair(
    theta: float, rho: float, vertical: float = VERTICAL, mu: float = LINEAR.mu, speed: float = LINEAR.speed
) -> LinearCase:
    """Return a linear pair; theta [deg], side force ratio, load [N], friction coefficient, speed [m/s]."""
    bearing = replace(LINEAR, mu=mu, mu_balls=mu, speed=speed)
    return LinearCase(bearing, *pair_angles_and_loads(bearing, radians(theta), rho, vertical, loads="elastic"))


def chain_state(count: int) -> tuple[Array, Array]:
    """Return random contact angles [rad] and loads [N] of a linear chain, (N, 4), with deviations and side forces."""
    rng = np.random.default_rng(count)
    angles = LINEAR.contact_angle + angle_deviations(np.radians(rng.uniform(-3.0, 3.0, count)))
    return angles, balanced_loads(angles, VERTICAL, rng.uniform(-0.6, 0.6, count))


def linear_chain(count: int, mu: float = LINEAR.mu) -> LinearCase:
    """Return a linear chain with random angles and side forces; ``mu``: friction coefficient of all contacts."""
    return LinearCase(replace(LINEAR, mu=mu, mu_balls=mu), *chain_state(count))


def patchy_chain(count: int, mu: float) -> LinearCase:
    """Return a linear chain with random contact loads, not in equilibrium and zero at some contacts."""
    case, rng = linear_chain(count, mu), np.random.default_rng(1000 + count)
    loads = case.loads * rng.uniform(0.2, 1.8, case.loads.shape)
    return replace(case, loads=np.where(rng.uniform(size=loads.shape) < UNLOADED, 0.0, loads))


def relieved_pair(share: float) -> LinearCase:
    """Return a linear pair whose balls nearly lose one diagonal's load: side force ratio -1 + ``share``."""
    return linear_pair(2.0, -1.0 + share)


def screw_pairs(group: str, pairs: Sequence[Pair], note: str = "") -> Record:
    """Solve screw pairs with loads and motions together, then their chains from random starts; return the record."""
    rng, tally = np.random.default_rng(3), Tally()
    for p in pairs:
        tally.cases += 1
        r = solve_pair(p)
        m = r.touching.motion
        tally.add(r.converged, m.input_power, m.loss, 0.0)
        load = r.touching.load
        chain = ScrewChain(p.groove, load.force, p.groove.normals(load.angle), np.array([0.0, np.inf]))
        restart(tally, chain, m, rng, FAR_START)
        bound = p.groove.mu * float(r.ball_loads.max())
        for found in pair_solutions_from_starts(p, r, rng, CHAIN_STARTS, FAR_START):
            tally.theirs(found, m.ball_force[:1], bound)
    return tally.record(group, "screw pair", note)


def restart(tally: Tally, chain: ScrewChain, first: ChainMotion, rng: np.random.Generator, off: float) -> None:
    """Solve a screw chain from randomly changed motions and forces; count differences from a known solution."""
    bound = chain.groove.mu * float(chain.force.sum(axis=1).max())
    size = np.maximum(first.ball_force, NO_FORCE * bound)
    for _ in range(CHAIN_STARTS):
        q = first.q * rng.uniform(1.0 - off, 1.0 + off, first.q.shape)
        m = solve_chain(chain, (q, size * rng.uniform(0.0, 2.0, size.size)))
        apart = float(np.max(np.abs(m.ball_force - first.ball_force))) / bound
        tally.add(m.converged, m.input_power, m.loss, apart)
        tally.restarts += 1
        tally.direct += m.from_start


def screw_chain_state(count: int) -> tuple[Array, Array, Array]:
    """Return random loads [N] and angles [rad], (N, 4), and slack (N,) [rad/s] of a chain with an open end."""
    g, rng = table_3_6(), np.random.default_rng(count)
    force = rng.uniform(20.0, 60.0, (count, 4))
    angle = g.contact_angle + np.radians(rng.uniform(-3.0, 3.0, (count, 4)))
    slack = np.where(rng.uniform(size=count) < 0.7, 0.0, rng.uniform(0.0, 0.05, count))
    return force, angle, np.append(slack[:-1], np.inf)


def screw_chain(count: int) -> ScrewChain:
    """Return a screw's chain of balls with random loads, angles and slack, open at its end."""
    g, (force, angle, slack) = table_3_6(), screw_chain_state(count)
    return ScrewChain(g, force, g.normals(angle), slack)


def screw_chains() -> Record:
    """Solve chains of a screw of several sizes and return their record."""
    rng, tally = np.random.default_rng(4), Tally()
    for count in BALLS:
        tally.cases += 1
        chain = screw_chain(count)
        m = solve_chain(chain)
        tally.add(m.converged, m.input_power, m.loss, 0.0)
        restart(tally, chain, m, rng, NEAR_START)
        bound = chain.groove.mu * float(chain.force.sum(axis=1).max())
        for found in screw_solutions_from_starts(chain, screw_chain_state(count)[1], m, rng, CHAIN_STARTS, NEAR_START):
            tally.theirs(found, m.ball_force[:-1], bound)
    return tally.record("chains", f"screw, {', '.join(map(str, BALLS))} balls")


def bearing_clearance() -> Record:
    """Solve the whole four-point bearing of Table 4.2 for loads and motions with clearance; return the record."""
    tally = Tally()
    for c, tilt in product(CLEARANCE, (False, True)):
        tally.cases += 1
        s = solve_bearing(four_point(clearance=c, tilt=tilt), radians(12.0))
        tally.add(s.converged, s.input_power, float(s.loss.sum()), 0.0)
    return tally.record("clearance to 10 µm", "four-point bearing, 9 balls", "one start each")


def chain_rows() -> list[Record]:
    """Return the records of all groups of pairs and chains."""
    two = radians(2.0)
    base, few = inferred(two), f"one random start; source up to {SOURCE_BALLS} balls"
    return [
        chain_group("rho to ±0.999, theta to ±5°", [linear_pair(t, r) for t, r in product(ANGLES, RHO)]),
        chain_group("mu 0.001 to 0.5", [linear_pair(2.0, r, VERTICAL, m) for r, m in product((-0.6, -0.999), MU)]),
        chain_group("loads 1e-3 to 1e5 N", [linear_pair(2.0, r, f) for r, f in product((-0.6, -0.999), LOADS)]),
        chain_group("two-point transition", [relieved_pair(10.0**-k) for k in range(1, 13)]),
        chain_group("zero speed", [linear_pair(2.0, -0.6, speed=0.0)]),
        chain_group("chains", [linear_chain(n) for n in BALLS], f"linear, {', '.join(map(str, BALLS))} balls"),
        chain_group(
            "chains, mu 0.001 to 0.5",
            [linear_chain(n, m) for n, m in product(BALLS, MU)],
            f"linear, {', '.join(map(str, BALLS))} balls",
            1,
            SOURCE_BALLS,
            few,
        ),
        chain_group(
            "chains, mu 0.001 to 0.5",
            [patchy_chain(n, m) for n, m in product(BALLS, MU)],
            "the same, a quarter of the contacts unloaded",
            1,
            SOURCE_BALLS,
            few,
        ),
        screw_pairs("theta to ±5°", [inferred(radians(t)) for t in ANGLES]),
        screw_pairs("mu 0.001 to 0.5", [replace(base, groove=table_3_6(mu=m)) for m in MU]),
        screw_pairs("loads 1e-3 to 1e5 N", [replace(base, force=(f,)) for f in LOADS]),
        screw_pairs(
            "two-point transition",
            [replace(base, oversize=o) for o in 1e-6 * np.linspace(0.8, 1.1, 13)],
            "oversize 0.8 to 1.1 µm",
        ),
        screw_pairs(
            "clearance to 10 µm",
            [replace(case_as_printed(two), oversize=-c, coupling="none") for c in CLEARANCE],
            "loads not coupled",
        ),
        screw_pairs(
            "clearance to 10 µm",
            [replace(case_as_printed(two), oversize=-c) for c in CLEARANCE],
            "friction moves the balls",
        ),
        screw_pairs(
            "small loads and clearance",
            [replace(case_as_printed(two), oversize=-c, force=(f,)) for c, f in product(CLEARANCE[1:], SMALL)],
            "friction moves the balls; 1e-3 to 0.3 N, 1 to 10 µm",
        ),
        screw_pairs("zero speed", [replace(base, groove=table_3_6(nut_speed=0.0))]),
        screw_chains(),
        bearing_clearance(),
    ]


# --- extremes around the printed cases of Lin 3.2 and 3.3: the linear pair, and starts of the rotary bearing's ball


#: Random starts of root finding, near and far.
ROOT_STARTS = 8


def pair_extremes() -> list[tuple[str, list[Chain]]]:
    """Return groups of extreme linear pairs, each a chain ready to solve."""

    def make(theta: float, rho: float, vertical: float, mu: float) -> Chain:
        bearing = replace(LINEAR, mu=mu, mu_balls=mu)
        return prepare_chain(bearing, *pair_angles_and_loads(bearing, radians(theta), rho, vertical, loads="elastic"))

    return [
        (
            "rho to ±0.999, theta to ±5 deg",
            [make(t, r, 100.0, 0.1) for t, r in product((-5.0, -0.1, 2.0, 5.0), (-0.999, -0.9, -0.3, 0.3, 0.9, 0.999))],
        ),
        (
            "friction coefficient 0.001 to 0.5",
            [make(2.0, r, 100.0, mu) for r, mu in product((-0.6, -0.999), (1e-3, 0.01, 0.1, 0.3, 0.5))],
        ),
        ("loads 1e-3 to 1e5 N", [make(2.0, r, f, 0.1) for r, f in product((-0.6, -0.999), (1e-3, 0.1, 10.0, 1e3, 1e5))]),
    ]


def pair_rows() -> list[Row]:
    """Return the rows of extreme pairs, each solved from the nominal start and two random ones."""
    rng, rows = np.random.default_rng(3), list[Row]()
    for group, chains in pair_extremes():
        solved, energy, spread, residual = 0, 0.0, 0.0, 0.0
        for c in chains:
            starts = [None, *(c.problem.nominal * rng.uniform(-3.0, 3.0, (c.count, 3)) for _ in range(2))]
            found = [solve_linear_chain(c, start) for start in starts]
            solved += sum(r.status == "converged" for r in found)
            energy = max(energy, *(abs(r.power / r.loss - 1.0) for r in found))
            spread = max(spread, *(float(abs(r.ball_force[0] - found[0].ball_force[0])) / c.scale for r in found))
            residual = max(residual, *(max(r.residual, r.lag) for r in found))
        rows.append(
            {
                Quantity("group", "what is varied", "", "s"): group,
                "cases": len(chains),
                Quantity("solved", "solved from three starts", "", "s"): f"{solved} of {3 * len(chains)}",
                Quantity("residual", "largest residual", "", "g2"): residual,
                Quantity("energy", "relative excess of power in over dissipation", "", "g2"): energy,
                Quantity("spread", "spread of the force over the starts", "", "g2"): spread,
            }
        )
    return rows


def root_rows() -> list[Row]:
    """Return rows that compare the source's root finding and least dissipation on cases I to III from random starts."""
    rng, rows = np.random.default_rng(5), list[Row]()
    first = {case: solve_rotary(case, "as printed") for case in CASES}
    for case, sharpness in product(CASES, (100.0, 1e3, 1e4)):
        s, law = first[case], source_law(ROTARY, sharpness)
        row: Row = {"case": case, Quantity("sharpness", "k_S", "", "g3"): sharpness}
        for key, words, off in (("near", "1 % of the solution", 0.01), ("far", "50 %", 0.5)):
            begin = [s.motion.q * rng.uniform(1.0 - off, 1.0 + off, 3) for _ in range(ROOT_STARTS)]
            by_root = sum(balance_by_root(s.problem, law, q, fast=True).status == "exact" for q in begin)
            heading = f"root finding, starts within {words}"
            row[Quantity(key, heading, "", "s")] = f"{by_root} of {ROOT_STARTS}"
        least = [least_dissipation(s.problem, q, fast=True) for q in begin]
        good = sum(m.status == "exact" and abs(m.loss / s.motion.loss - 1.0) < 1e-8 for m in least)
        ours = Quantity("ours", "least dissipation, starts within 50 %", "", "s")
        rows.append(row | {ours: f"{good} of {ROOT_STARTS}"})
    return rows


def all_rows() -> list[Record]:
    """Return the whole table."""
    return [*ball_rows(), *chain_rows()]


COLUMNS = (
    Quantity("group", "what is varied", "", "s"),
    Quantity("model", "model", "", "s"),
    Quantity("cases", "cases", "", "s"),
    Quantity("ours", "solved here from all starts", "", "s"),
    Quantity("energy", "relative excess of power in over dissipation", "", "g2"),
    Quantity("spread", "spread over the starts", "", "g2"),
    Quantity("source", "source's root finding, solved", "", "s"),
    Quantity("note", "note", "", "s"),
)


def by_model(tried: Sequence[Record]) -> str:
    """Return the number of starts that the source's root finding solves, by model, the worst first."""
    counts: dict[str, tuple[int, int]] = {}
    for r in tried:
        solved, tries = counts.get(r.model, (0, 0))
        counts[r.model] = solved + (r.source or 0), tries + (r.source_tries or 0)
    worst_first = sorted(counts.items(), key=lambda item: item[1][0] / max(item[1][1], 1))
    return "; ".join(f"{model}: {solved} of {tries}" for model, (solved, tries) in worst_first)


def table_section_items(found: Sequence[Record] | None = None) -> tuple[Text | Table, ...]:
    """Return table and conclusion for a section of the report; ``found``: records if computed before."""
    found = all_rows() if found is None else found
    cells = list[dict[str, Cell]]()
    for r in found:
        theirs = "–" if r.source is None else f"{r.source} of {r.source_tries}"
        cells.append(asdict(r) | {"ours": f"{r.ours} of {r.tries}", "source": theirs})
    shown = [{c.key: row[c.key] for c in COLUMNS} for row in cells]
    tried = [r for r in found if r.source is not None]
    text = (
        f"Solved here: {sum(r.ours for r in found)} of {sum(r.tries for r in found)}; the source's root finding "
        f"{sum(r.source or 0 for r in tried)} of {sum(r.source_tries or 0 for r in tried)}. Model by model, the worst "
        f"first: {by_model(tried)}. It decides which balls touch from their motions without contact (Lin 3.31, 3.77), so "
        "that roots of longer chains may let balls overlap; these do not count as solved.",
    )
    note = (
        "Each case is solved from the solver's own start and from random ones. Spread: of the loss of one ball, or of "
        "ball-to-ball forces over the largest friction bound. The source's method: a root of the force balance under its "
        "sigmoid, k_S = 100 unless varied, by MINPACK's hybrid method with a short first step, which finds more roots "
        f"than its default; one ball: {STARTS} starts within {FAR_START:.0%} of the solution unless said otherwise; pairs "
        f"and chains: rolling and {CHAIN_STARTS} starts within {FAR_START:.0%} ({NEAR_START:.0%} for chains of a screw). A "
        "chain of a screw that Newton does not reach from a random start is restarted from the solver's own. Where "
        "friction between balls leaves more than one state (jammed or apart), the branch reached by continuation from zero "
        "friction is reported; "
        "a ball of a screw that carries almost no load in clearance may also float or be wedged by its own friction, and "
        "where the search begins decides: there the restarts keep the loads that were found."
    )
    return (Text(text), Table("friction-extremes", "Friction and ball motion: extreme cases", COLUMNS, shown, note))
