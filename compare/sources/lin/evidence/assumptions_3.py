"""Lin 3.2 and 3.3 under several sets of assumptions: balance of power of the rotary cases, loads of the linear pair."""

from __future__ import annotations

from itertools import product

from rollbench.comparison.measure import error_percent
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.sources.lin.evidence.rotary_linear import CASES, LOADS, ROTARY, WORST, as_printed, pair, right
from rollbench.lowfi.friction.bearing.rotary import inner_torque
from rollbench.reports.records import Cell


def balance_rows() -> list[dict[str, Cell]]:
    """Cases I to III: torque [N mm], power in and out [W], contacts at rest, by three sets of assumptions."""
    rows: list[dict[str, Cell]] = []
    for case in CASES:
        for label, s in (
            ("right", right(case)),
            ("least dissipation at the loads as printed", right(case, "as printed")),
            ("as printed", as_printed(case)),
        ):
            torque = inner_torque(ROTARY, s.load, s.motion)
            rows.append(
                {
                    "case": case,
                    "model": label,
                    "force": float(s.load.force.sum()),
                    "torque": 1e3 * torque,
                    "input": torque * ROTARY.speed,
                    "loss": s.motion.loss,
                    "balance": float(error_percent(torque * ROTARY.speed, s.motion.loss)),
                    "rest": int(s.motion.rest.sum()),
                    "status": s.motion.status,
                }
            )
    return rows


def sensitivity_rows() -> list[dict[str, Cell]]:
    """The linear pair under each assumption on loads and on friction between the balls: deviations and changes in per cent,
    force in N."""
    rows: list[dict[str, Cell]] = []
    target = entry("lin-3.5", "a_force_numerical").value or 0.0
    for loads, mu in product(LOADS, (0.1, 0.0)):
        r, worst = pair(loads=loads, mu_balls=mu), pair(WORST, loads, mu_balls=mu)
        rows.append(
            {
                "loads": loads,
                "mu": mu,
                "eps1": 100.0 * float(r.free.deviation[0]),
                "eps2": 100.0 * float(r.free.deviation[1]),
                "force": r.force,
                "error": float(error_percent(r.force, target)),
                "ratio": 100.0 * worst.rubbing_ratio,
                "increase": float(error_percent(worst.touching.loss, worst.free.loss)),
                "status": r.touching.status,
            }
        )
    return rows
