"""Rows of the stability table: one per case, and how many cases each formulation solves."""

from __future__ import annotations

from collections.abc import Sequence

from rollbench.comparison.wings.extremes.static import CONVERGED, ENERGY, FORMULATIONS, SAME, Attempt
from rollbench.reports.records import Cell


def wide_rows(rows: Sequence[Attempt]) -> list[dict[str, Cell]]:
    """One row per case, one status per formulation."""
    by_case: dict[str, dict[str, Cell]] = {}
    for row in rows:
        line = by_case.setdefault(row.case, {"case": row.case, "group": row.group})
        line[row.formulation] = short(row)
        if row.formulation == ENERGY:
            line |= {
                "iterations": row.iterations,
                "residual": row.residual,
                "bound": row.round_off_bound,
                "seconds": row.seconds,
                "unknowns": row.unknowns,
            }
    return list(by_case.values())


def short(row: Attempt) -> str:
    """Status for a table: how it ended, with iterations and residual where it converged."""
    if row.status == CONVERGED:
        apart = row.difference_percent
        other = f", another root ({apart:.2g} % off)" if apart is not None and apart > SAME else ""
        return f"converged, {row.iterations} it.{other}"
    return row.status.split(" (")[0]


def tally(rows: Sequence[Attempt]) -> dict[str, tuple[int, int, int]]:
    """Per formulation: cases solved (or its mechanism named), cases tried, cases."""
    out = {}
    for formulation in FORMULATIONS:
        attempts = [r for r in rows if r.formulation == formulation]
        tried = [r for r in attempts if not r.status.startswith("not attempted")]
        out[formulation] = (sum(r.status == r.expected for r in tried), len(tried), len(attempts))
    return out
