"""Lin 3.2 and 3.3 under several sets of assumptions: balance of power of the rotary cases, loads of the linear pair."""

from __future__ import annotations

from itertools import product

from rollbench.comparison.measure import error_percent
from rollbench.comparison.printed.printed_data import entry
from rollbench.comparison.sources.lin.evidence.rotary_linear import CASES, LOADS, ROTARY, WORST, as_printed, pair, right
from rollbench.lowfi.friction.bearing.rotary import inner_torque
from rollbench.reports.records import Quantity, Row


def balance_rows() -> list[Row]:
    """Cases I to III: torque [N mm], power in and out [W], contacts at rest, by three sets of assumptions."""
    rows: list[Row] = []
    for case in CASES:
        for label, s in (
            ("right", right(case)),
            ("least dissipation at the loads as printed", right(case, "as printed")),
            ("as printed", as_printed(case)),
        ):
            torque = inner_torque(ROTARY, s.load, s.motion)
            power = torque * ROTARY.speed
            rows.append(
                {
                    "case": case,
                    "model": label,
                    Quantity("force", "sum of forces", "N", ".3f"): float(s.load.force.sum()),
                    Quantity("torque", "friction's moment on the ring", "N mm", ".4f"): 1e3 * torque,
                    Quantity("input", "power in", "W", ".6f"): power,
                    Quantity("loss", "dissipation", "W", ".6f"): s.motion.loss,
                    Quantity("balance", "power in against dissipation", "%", "g2"): float(
                        error_percent(power, s.motion.loss)
                    ),
                    Quantity("rest", "contacts at rest", "", "s"): int(s.motion.rest.sum()),
                    "status": s.motion.status,
                }
            )
    return rows


def sensitivity_rows() -> list[Row]:
    """The linear pair under each assumption on loads and on friction between the balls: deviations and changes in per cent,
    force in N."""
    rows: list[Row] = []
    printed = entry("lin-3.5", "a_force_numerical")
    against = f"against the printed {printed.printed} N"
    for loads, mu in product(LOADS, (0.1, 0.0)):
        r, worst = pair(loads=loads, mu_balls=mu), pair(WORST, loads, mu_balls=mu)
        increase = float(error_percent(worst.touching.loss, worst.free.loss))
        rows.append(
            {
                "loads": loads,
                Quantity("mu", "friction between balls", "", "g2"): mu,
                Quantity("eps1", "ε₁, θ = 2°", "%", ".3f"): 100.0 * float(r.free.deviation[0]),
                Quantity("eps2", "ε₂, θ = 2°", "%", ".3f"): 100.0 * float(r.free.deviation[1]),
                Quantity("force", "force, θ = 2°", "N", ".3f"): r.force,
                Quantity("error", against, "%", ".2f"): float(error_percent(r.force, printed.value or 0.0)),
                Quantity("ratio", "total over baseline, θ = 3°", "%", ".1f"): 100.0 * worst.rubbing_ratio,
                Quantity("increase", "increase of all losses, θ = 3°", "%", ".1f"): increase,
                "status": r.touching.status,
            }
        )
    return rows
