"""Extremes around the printed cases of Lin 3.2 and 3.3: the linear pair, and starts of the rotary bearing's ball."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import radians

import numpy as np

from rollbench.comparison.sources.lin.evidence.rotary_linear import CASES, LINEAR, ROTARY, right
from rollbench.lowfi.friction.bearing.rotary import source_law
from rollbench.lowfi.friction.contact.motion import balance_by_root, least_dissipation
from rollbench.lowfi.friction.linear.chain import Chain, prepare, solve_linear_chain
from rollbench.lowfi.friction.linear.pair import pair_state
from rollbench.reports.records import Quantity, Row

#: Random starts of root finding, near and far.
ROOT_STARTS = 8


def pair_extremes() -> list[tuple[str, list[Chain]]]:
    """Groups of extreme linear pairs, each a chain ready to solve."""

    def make(theta: float, rho: float, vertical: float, mu: float) -> Chain:
        bearing = replace(LINEAR, mu=mu, mu_balls=mu)
        return prepare(bearing, *pair_state(bearing, radians(theta), rho, vertical, loads="elastic"))

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
    """Extreme pairs from the nominal start and from two random ones: solved, energy balance, spread of the answers."""
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
    """The source's root finding on cases I to III and least dissipation, from the same random starts."""
    rng, rows = np.random.default_rng(5), list[Row]()
    first = {case: right(case, "as printed") for case in CASES}
    for case, sharpness in product(CASES, (100.0, 1e3, 1e4)):
        s, law = first[case], source_law(ROTARY, sharpness, None)
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
