"""Extreme cases of one ball at given loads, in a rotary bearing and in a ball screw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import radians

import numpy as np

from rollbench.comparison.sources.lin.evidence.rotary_linear import AXIAL, CASES, ROTARY
from rollbench.comparison.sources.lin.evidence.source_cases import inferred, plain, table_3_6
from rollbench.comparison.sources.lin.extremes.tally import (
    ANGLES,
    CLEARANCE,
    FAR_START,
    LOADS,
    MU,
    NEAR_START,
    SHARPNESS,
    STARTS,
    Record,
    Tally,
)
from rollbench.lowfi.friction.bearing.rotary import Bearing, Mode, solve_ball, source_law
from rollbench.lowfi.friction.contact.laws import Sigmoid
from rollbench.lowfi.friction.contact.motion import Problem, balance_by_root, least_dissipation
from rollbench.lowfi.friction.screw.motion import screw_contacts
from rollbench.lowfi.friction.screw.motion import source_law as screw_law
from rollbench.lowfi.friction.screw.pair import Pair, solve_pair
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class OneBall:
    """A ball at given loads: its problem, speed that drives it [rad/s], the source's law."""

    problem: Problem
    law: Sigmoid
    power: Callable[[Array], float]


def rotary_ball(bearing: Bearing, axial: float, u_y: float, sharpness: float = 100.0, hertz: Mode = "right") -> OneBall:
    """Rotary bearing at an axial load [N] and a radial displacement [m]."""
    s = solve_ball(bearing, axial, u_y, hertz, fast=True)
    law = source_law(bearing, sharpness, None) if bearing.speed else Sigmoid(sharpness, 1.0)
    return OneBall(s.problem, law, lambda f: _drive_power(s.problem, f))


def screw_ball(pair: Pair, force: Array | None = None, sharpness: float = 100.0) -> OneBall:
    """Second ball of a pair without contact, or with contact forces (4,) [N] at the nominal angles."""
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


def try_ball(tally: Tally, ball: OneBall, rng: np.random.Generator, off: float) -> None:
    """Least dissipation and the source's root from the same random starts, each unknown off by up to ``off``."""
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
    """A group of single balls; off: how far random starts are off, relative."""
    rng, tally = np.random.default_rng(1), Tally()
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
    for off, k in product((NEAR_START, FAR_START), SHARPNESS):
        note = f"starts within {off:.0%}"
        printed = [rotary_ball(ROTARY, AXIAL, u, k, "as printed") for u in CASES.values()]
        rows.append(ball_group(f"k_S {k:g}", "rotary, cases I to III as printed", printed, note, off))
        pairs = [screw_ball(p(two), None, k) for p in (plain, inferred)]
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
            [screw_ball(replace(plain(two), oversize=-c, coupling="none")) for c in CLEARANCE],
        ),
        ball_group(
            "zero speed",
            "rotary",
            [rotary_ball(replace(ROTARY, speed=0.0), AXIAL, u) for u in CASES.values()],
            "nothing turns",
        ),
        ball_group("zero speed", "screw", [screw_ball(replace(inferred(two), groove=rest))], "nothing turns"),
    ]
    return rows
