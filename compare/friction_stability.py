"""Stability of friction and ball motion at extremes: the source's root finding against least dissipation and chains.

Every case of ours is solved from its own start and from random ones; it must converge, balance power in and
dissipation, and give the same answer each time. The source's way is a root of the force balance under its sigmoid
(``balance_by_root``) from random starts, at the loads of the same case where one ball at given loads is the question.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from math import radians

import numpy as np

from compare.sections.friction_values import CASES, LINEAR, ROTARY
from lowfi.friction.bearing_pairs import four_point, solve_bearing
from lowfi.friction.chain import Chain, prepare, solve
from lowfi.friction.ellipse import Array
from lowfi.friction.laws import Sigmoid
from lowfi.friction.linear import deviations
from lowfi.friction.linear_loads import balanced_loads
from lowfi.friction.linear_pair import pair_state
from lowfi.friction.motion import Problem, balance_by_root, least_dissipation
from lowfi.friction.rotary import Bearing, Mode, solve_ball, source_law
from lowfi.friction.screw_chain import SHORT, ChainMotion, solve_chain
from lowfi.friction.screw_chain import Chain as ScrewChain
from lowfi.friction.screw_motion import screw_contacts
from lowfi.friction.screw_motion import source_law as screw_law
from lowfi.friction.screw_pair import Pair, inferred, plain, solve_pair, table_3_6
from reports.records import Cell, Column, Table, Text

#: Sharpness of the source's sigmoid, Lin's k_S, in its own formulation; 100 where it is not what is varied.
SHARPNESS = (100.0, 1e3, 1e4)
#: Random starts of one ball and of chains, besides the solver's own; how far they are off the solution, relative.
STARTS, CHAIN_STARTS, NEAR, FAR = 12, 3, 0.01, 0.5
#: Power [W] and, over the friction bound, ball-to-ball force below which random starts and balances are not scaled.
NO_POWER, NO_FORCE = 1e-13, 0.01
ANGLES, MU, LOADS = (-5.0, -1.0, 1e-3, 2.0, 5.0), (1e-3, 0.01, 0.1, 0.3, 0.5), (1e-3, 0.1, 10.0, 1e3, 1e5)
RHO, CLEARANCE = (-0.999, -0.9, -0.3, 0.3, 0.9, 0.999), (1e-7, 1e-6, 5e-6, 1e-5)
#: Sizes of the chains: linear bearing, ball screw.
LINEAR_BALLS, SCREW_BALLS = (2, 5, 10, 20, 50, 100, 200), (2, 5, 10, 20, 50, 100, 200)


@dataclass(frozen=True)
class Record:
    """One group of cases.

    ours, tries: solutions of ours that converged, and all that were tried; energy: largest power in over dissipation,
    less one; spread: largest difference of the answers from several starts, relative (loss of one ball, ball-to-ball
    forces of more); source, source_tries: roots found by the source's way and tried, None where it has no such model.
    """

    group: str
    model: str
    cases: int
    ours: int
    tries: int
    energy: float
    spread: float
    source: int | None = None
    source_tries: int | None = None
    note: str = ""


@dataclass
class _Tally:
    """Counts of a group as its cases are solved."""

    cases: int = 0
    ours: int = 0
    tries: int = 0
    energy: float = 0.0
    spread: float = 0.0
    source: int = 0
    source_tries: int = 0
    direct: int = 0
    restarts: int = 0

    def add(self, good: bool, power: float, loss: float, apart: float) -> None:
        """One solution: whether it converged, power in and dissipation [W], difference from the first, relative."""
        self.tries += 1
        self.ours += good
        self.energy = max(self.energy, abs(power - loss) / max(loss, NO_POWER))
        self.spread = max(self.spread, apart)

    def record(self, group: str, model: str, note: str = "") -> Record:
        """The group's record."""
        tried = self.source_tries or None
        if self.restarts:
            own = f"{self.direct} of {self.restarts} random starts led there by themselves"
            note = f"{note}; {own}" if note else own
        return Record(
            group, model, self.cases, self.ours, self.tries, self.energy, self.spread,
            self.source if tried else None, tried, note,
        )  # fmt: skip


# --- one ball at given loads


@dataclass(frozen=True)
class OneBall:
    """A ball at given loads: its problem, speed that drives it [rad/s], the source's law."""

    problem: Problem
    law: Sigmoid
    power: Callable[[Array], float]


def rotary_ball(
    bearing: Bearing, axial: float, u_y: float, sharpness: float = 100.0, hertz: Mode = "right"
) -> OneBall:  # fmt: skip
    """Rotary bearing at an axial load [N] and a radial displacement [m]."""
    s = solve_ball(bearing, axial, u_y, hertz, fast=True)
    law = source_law(bearing, sharpness, None) if bearing.speed else Sigmoid(sharpness, 1.0)
    return OneBall(s.problem, law, lambda f: _drive_power(s.problem, f))


def screw_ball(pair: Pair, force: Array | None = None, sharpness: float = 100.0) -> OneBall:
    """Second ball of a pair apart, or with contact forces (4,) [N] at the nominal angles."""
    g = pair.groove
    angle = np.full(4, g.contact_angle)
    if force is None:
        load = solve_pair(pair).free.load
        force, angle = load.force[1], load.angle[1]
    maps, drives = g.maps(g.normals(angle))
    problem = Problem(screw_contacts(g, force), maps, drives, np.zeros(4))
    law = screw_law(g, sharpness) if g.speed else Sigmoid(sharpness, 1.0)
    return OneBall(problem, law, lambda f: _drive_power(problem, f))


def _drive_power(problem: Problem, wrench: Array) -> float:
    """Power [W] of the driven surfaces against friction (m, 3) on the ball: what drives the contacts."""
    return -float(np.sum(wrench * problem.drives))


def try_ball(tally: _Tally, ball: OneBall, rng: np.random.Generator, off: float) -> None:
    """Least dissipation and the source's root from the same random starts, each unknown off by up to ``off``."""
    tally.cases += 1
    first = least_dissipation(ball.problem, fast=True)
    size = float(np.max(np.abs(first.q))) or 1.0
    starts = [first.q + off * rng.uniform(-1.0, 1.0, first.q.size) * np.maximum(np.abs(first.q), 0.01 * size)
              for _ in range(STARTS)]  # fmt: skip
    for m in (first, *(least_dissipation(ball.problem, q, fast=True) for q in starts)):
        wrench = np.column_stack([m.friction.force, m.friction.moment])
        apart = abs(m.loss - first.loss) / first.loss if first.loss > 0.0 else abs(m.loss)
        tally.add(m.status != "failed", ball.power(wrench), m.loss, apart)
    for q in starts:
        tally.source += balance_by_root(ball.problem, ball.law, q, fast=True).status == "exact"
        tally.source_tries += 1


def ball_group(group: str, model: str, balls: Sequence[OneBall], note: str = "", off: float = FAR) -> Record:
    """A group of single balls; off: how far random starts are off, relative."""
    rng, tally = np.random.default_rng(1), _Tally()
    for ball in balls:
        try_ball(tally, ball, rng, off)
    return tally.record(group, model, note)


def screw_share(share: float) -> OneBall:
    """Screw ball whose second diagonal bears a share of the first's load."""
    return screw_ball(inferred(0.0), 100.0 * np.array([1.0, share, share, 1.0]))


def ball_rows() -> list[Record]:
    """One ball at given loads."""
    two, rest = radians(2.0), table_3_6(nut_speed=0.0)
    around = 1e-6 * np.linspace(4.2, 4.5, 13)
    loose = [replace(ROTARY, clearance=c) for c in CLEARANCE]
    rows = []
    for off, k in product((NEAR, FAR), SHARPNESS):
        note = f"starts within {off:.0%}"
        printed = [rotary_ball(ROTARY, 100.0, u, k, "as printed") for u in CASES.values()]
        rows.append(ball_group(f"k_S {k:g}", "rotary, cases I to III as printed", printed, note, off))
        both = [screw_ball(p(two), None, k) for p in (plain, inferred)]
        rows.append(ball_group(f"k_S {k:g}", "screw, pair of Table 3.7", both, note, off))
    rows += [
        ball_group("theta to ±5°", "screw", [screw_ball(inferred(radians(t))) for t in ANGLES]),
        ball_group("mu 0.001 to 0.5", "screw",
                   [screw_ball(replace(inferred(two), groove=table_3_6(mu=m))) for m in MU]),
        ball_group("mu 0.001 to 0.5", "rotary",
                   [rotary_ball(replace(ROTARY, mu=m), 100.0, u) for m, u in product(MU, CASES.values())]),
        ball_group("two-point transition", "rotary", [rotary_ball(ROTARY, 100.0, float(u)) for u in around],
                   "radial displacement 4.2 to 4.5 µm"),
        ball_group("two-point transition", "screw", [screw_share(10.0**-k) for k in range(13)],
                   "load of the second diagonal down to 1e-12 of the first"),
        ball_group("loads 1e-3 to 1e5 N", "rotary",
                   [rotary_ball(ROTARY, f, u) for f, u in product(LOADS, CASES.values())]),
        ball_group("loads 1e-3 to 1e5 N", "screw", [screw_ball(replace(inferred(two), force=(f,))) for f in LOADS]),
        ball_group("clearance to 10 µm", "rotary",
                   [rotary_ball(b, 100.0, u) for b, u in product(loose, (0.0, 5.2e-6, 20e-6))]),
        ball_group("clearance to 10 µm", "screw",
                   [screw_ball(replace(plain(two), oversize=-c, coupling="none")) for c in CLEARANCE]),
        ball_group("zero speed", "rotary",
                   [rotary_ball(replace(ROTARY, speed=0.0), 100.0, u) for u in CASES.values()], "nothing turns"),
        ball_group("zero speed", "screw", [screw_ball(replace(inferred(two), groove=rest))], "nothing turns"),
    ]  # fmt: skip
    return rows


# --- pairs and chains


def chain_group(group: str, chains: Sequence[Chain], model: str = "linear pair") -> Record:
    """Chains of the linear bearing from their own start and random ones."""
    rng, tally = np.random.default_rng(2), _Tally()
    for c in chains:
        tally.cases += 1
        first: Array | None = None
        for k in range(CHAIN_STARTS + 1):
            r = solve(c, None if k == 0 else c.problem[6] * rng.uniform(-3.0, 3.0, (c.count, 3)))
            first = r.ball_force if first is None else first
            apart = float(np.max(np.abs(r.ball_force - first))) / (c.scale or 1.0)
            tally.add(r.status == "converged", r.power, r.loss, apart)
    return tally.record(group, model)


def linear_pair(theta: float, rho: float, vertical: float = 100.0, mu: float = 0.1, speed: float = 0.01) -> Chain:
    """Linear pair; theta [deg], side force ratio, load [N], friction coefficient, speed [m/s]."""
    bearing = replace(LINEAR, mu=mu, mu_balls=mu, speed=speed)
    return prepare(bearing, *pair_state(bearing, radians(theta), rho, vertical, loads="elastic"))


def linear_chain(count: int) -> Chain:
    """Linear chain with deviations and side forces at random, every neighbour in reach."""
    rng = np.random.default_rng(count)
    angles = LINEAR.contact_angle + deviations(np.radians(rng.uniform(-3.0, 3.0, count)))
    return prepare(LINEAR, angles, balanced_loads(angles, 100.0, rng.uniform(-0.6, 0.6, count)))


def relieved_pair(share: float) -> Chain:
    """Linear pair whose balls all but lose a diagonal: side force ratio 1 - share."""
    return linear_pair(2.0, -1.0 + share)


def screw_pairs(group: str, pairs: Sequence[Pair], note: str = "") -> Record:
    """Pairs of a screw: loads and motion in agreement; then the chain at these loads from random starts."""
    rng, tally = np.random.default_rng(3), _Tally()
    for p in pairs:
        tally.cases += 1
        r = solve_pair(p)
        m = r.touching.motion
        tally.add(r.converged, m.input_power, m.loss, 0.0)
        load = r.touching.load
        chain = ScrewChain(p.groove, load.force, p.groove.normals(load.angle), np.array([0.0, np.inf]))
        restart(tally, chain, m, rng, FAR)
    return tally.record(group, "screw pair", note)


def restart(tally: _Tally, chain: ScrewChain, first: ChainMotion, rng: np.random.Generator, off: float) -> None:
    """The chain of a screw from motions off by up to ``off`` and any forces, against what was found before."""
    bound = chain.groove.mu * float(chain.force.sum(axis=1).max())
    size = np.maximum(first.ball_force, NO_FORCE * bound)
    for _ in range(CHAIN_STARTS):
        q = first.q * rng.uniform(1.0 - off, 1.0 + off, first.q.shape)
        m = solve_chain(chain, (q, size * rng.uniform(0.0, 2.0, size.size)))
        apart = float(np.max(np.abs(m.ball_force - first.ball_force))) / bound
        tally.add(m.converged, m.input_power, m.loss, apart)
        tally.restarts += 1
        tally.direct += m.steps <= SHORT


def screw_chain(count: int) -> ScrewChain:
    """Chain of a screw with loads, angles and gaps at random, cut open at its end."""
    g, rng = table_3_6(), np.random.default_rng(count)
    force = rng.uniform(20.0, 60.0, (count, 4))
    normals = g.normals(g.contact_angle + np.radians(rng.uniform(-3.0, 3.0, (count, 4))))
    slack = np.where(rng.uniform(size=count) < 0.7, 0.0, rng.uniform(0.0, 0.05, count))
    return ScrewChain(g, force, normals, np.append(slack[:-1], np.inf))


def screw_chains() -> Record:
    """Chains of a screw of several sizes."""
    rng, tally = np.random.default_rng(4), _Tally()
    for count in SCREW_BALLS:
        tally.cases += 1
        chain = screw_chain(count)
        m = solve_chain(chain)
        tally.add(m.converged, m.input_power, m.loss, 0.0)
        restart(tally, chain, m, rng, NEAR)
    return tally.record("chains", f"screw, {', '.join(map(str, SCREW_BALLS))} balls")


def bearing_clearance() -> Record:
    """Whole four-point bearing of Table 4.2 with clearance: loads and motions."""
    tally = _Tally()
    for c, tilt in product(CLEARANCE, (False, True)):
        tally.cases += 1
        s = solve_bearing(four_point(clearance=c, tilt=tilt), radians(12.0))
        tally.add(s.converged, s.input_power, float(s.loss.sum()), 0.0)
    return tally.record("clearance to 10 µm", "four-point bearing, 9 balls", "one start each")


def chain_rows() -> list[Record]:
    """Pairs and chains."""
    two = radians(2.0)
    base = inferred(two)
    return [
        chain_group("rho to ±0.999, theta to ±5°", [linear_pair(t, r) for t, r in product(ANGLES, RHO)]),
        chain_group("mu 0.001 to 0.5", [linear_pair(2.0, r, 100.0, m) for r, m in product((-0.6, -0.999), MU)]),
        chain_group("loads 1e-3 to 1e5 N", [linear_pair(2.0, r, f) for r, f in product((-0.6, -0.999), LOADS)]),
        chain_group("two-point transition", [relieved_pair(10.0**-k) for k in range(1, 13)]),
        chain_group("zero speed", [linear_pair(2.0, -0.6, speed=0.0)]),
        chain_group("chains", [linear_chain(n) for n in LINEAR_BALLS],
                    f"linear, {', '.join(map(str, LINEAR_BALLS))} balls"),
        screw_pairs("theta to ±5°", [inferred(radians(t)) for t in ANGLES]),
        screw_pairs("mu 0.001 to 0.5", [replace(base, groove=table_3_6(mu=m)) for m in MU]),
        screw_pairs("loads 1e-3 to 1e5 N", [replace(base, force=(f,)) for f in LOADS]),
        screw_pairs("two-point transition",
                    [replace(base, oversize=o) for o in 1e-6 * np.linspace(0.8, 1.1, 13)], "oversize 0.8 to 1.1 µm"),
        screw_pairs("clearance to 10 µm", [replace(plain(two), oversize=-c, coupling="none") for c in CLEARANCE],
                    "loads not coupled"),
        screw_pairs("clearance to 10 µm", [replace(plain(two), oversize=-c) for c in CLEARANCE],
                    "friction moves the balls"),
        screw_pairs("zero speed", [replace(base, groove=table_3_6(nut_speed=0.0))]),
        screw_chains(),
        bearing_clearance(),
    ]  # fmt: skip


def rows() -> list[Record]:
    """The whole table."""
    return [*ball_rows(), *chain_rows()]


COLUMNS = (
    Column("group", "what is varied", "", "s"),
    Column("model", "model", "", "s"),
    Column("cases", "cases", "", "s"),
    Column("ours", "ours, solved from all starts", "", "s"),
    Column("energy", "power in over dissipation, less 1", "", "g2"),
    Column("spread", "spread over the starts", "", "g2"),
    Column("source", "source's root finding, solved", "", "s"),
    Column("note", "note", "", "s"),
)


def table_section_items(found: Sequence[Record] | None = None) -> tuple[Text | Table, ...]:
    """The table and what it says, for a section of the report; ``found``: rows made before."""
    found = rows() if found is None else found
    cells = list[dict[str, Cell]]()
    for r in found:
        theirs = "–" if r.source is None else f"{r.source} of {r.source_tries}"
        cells.append(asdict(r) | {"ours": f"{r.ours} of {r.tries}", "source": theirs})
    shown = [{c.key: row[c.key] for c in COLUMNS} for row in cells]
    tried = [r for r in found if r.source is not None]
    text = (
        f"Ours solved {sum(r.ours for r in found)} of {sum(r.tries for r in found)}; the source's root finding "
        f"{sum(r.source or 0 for r in tried)} of {sum(r.source_tries or 0 for r in tried)}. From far starts that "
        "mostly fails, whatever k_S is, and in the rotary bearing it mostly fails from within 1 % of the solution too; "
        "at rest there is nothing to find.",
    )
    note = (
        "Each case is solved from the solver's own start and from random ones. Spread: of the loss of one ball, or of "
        "ball-to-ball forces over the largest friction bound. The source's way: a root of the force balance under its "
        f"sigmoid, k_S = 100 unless varied, {STARTS} starts a case within {FAR:.0%} of the solution unless said "
        "otherwise; it has no pair or chain to compare. A chain of a screw that Newton does not reach from a random "
        "start is begun anew from the solver's own."
    )
    return (
        Text(text), Table("friction-extremes", "Friction and ball motion: extreme cases", COLUMNS, shown, note),
    )  # fmt: skip
