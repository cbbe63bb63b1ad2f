"""The command ``rollbench stability``."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from compare.extremes.rows import tally, wide_rows
from compare.extremes.static import FORMULATIONS, failures, table


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
