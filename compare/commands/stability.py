"""The command ``rollbench stability`` and the rows that it and the report share."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from compare.extremes.static import CONVERGED, FORMULATIONS, OURS, SAME, Row, failures, table
from reports.records import Cell


def wide_rows(rows: Sequence[Row]) -> list[dict[str, Cell]]:
    """One row per case, one status per formulation."""
    by_case: dict[str, dict[str, Cell]] = {}
    for row in rows:
        line = by_case.setdefault(row.case, {"case": row.case, "group": row.group})
        line[row.formulation] = short(row)
        if row.formulation == OURS:
            line |= {
                "iterations": row.iterations,
                "residual": row.residual,
                "bound": row.round_off_bound,
                "seconds": row.seconds,
                "unknowns": row.unknowns,
            }
    return list(by_case.values())


def short(row: Row) -> str:
    """Status for a table: how it ended, with iterations and residual where it converged."""
    if row.status == CONVERGED:
        apart = row.difference_percent
        other = f", another root ({apart:.2g} % off)" if apart is not None and apart > SAME else ""
        return f"converged, {row.iterations} it.{other}"
    return row.status.split(" (")[0]


def tally(rows: Sequence[Row]) -> dict[str, tuple[int, int, int]]:
    """Per formulation: cases solved (or its mechanism named), cases tried, cases."""
    out = {}
    for formulation in FORMULATIONS:
        own = [r for r in rows if r.formulation == formulation]
        tried = [r for r in own if not r.status.startswith("not attempted")]
        out[formulation] = (sum(r.status == r.expected for r in tried), len(tried), len(own))
    return out


def run_stability(*, as_json: bool, show: Callable[..., None], print_json: Callable[[Any], None]) -> int:
    """Run the table; print it; 1 where our solver fails on any case, else 0."""

    def progress(done: int, total: int, case: str) -> None:
        if sys.stderr.isatty() or not as_json:
            line = f"[{done}/{total}] {case}"
            sys.stderr.write(f"\r\033[K{line}" if sys.stderr.isatty() else f"{line}\n")

    rows = table(progress)
    if sys.stderr.isatty():
        sys.stderr.write("\r\033[K")
    bad = failures(rows)
    if as_json:
        print_json({"failures": len(bad), "rows": [asdict(r) for r in rows]})
        return 1 if bad else 0
    from rich.table import Table as Terminal

    out = Terminal(title="stability: cases by formulations", title_justify="left")
    for heading in ("case", *FORMULATIONS, "residual"):
        out.add_column(heading)
    for line in wide_rows(rows):
        residual = line["residual"]
        out.add_row(
            str(line["case"]), *(str(line[f]) for f in FORMULATIONS), "–" if residual is None else f"{residual:.1e}"
        )
    show(out)
    for name, (solved, tried, total) in tally(rows).items():
        show(f"{name}: {solved} of {tried} tried ({total} cases)")
    for row in bad:
        show(f"FAILED: {row.case}: {row.status}; expected: {row.expected}")
    return 1 if bad else 0
