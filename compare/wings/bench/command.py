"""The command ``rollbench bench``."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.costs.timing import Job
from rollbench.comparison.sources.lin.bench import jobs as friction_jobs
from rollbench.comparison.sources.liu.bench import jobs as chain_jobs
from rollbench.comparison.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.comparison.wings.bench.bench import run_bench
from rollbench.comparison.wings.rolling.bench import jobs as rolling_jobs

if TYPE_CHECKING:
    from rich.table import Table


def run_bench_command() -> Answer:
    """Measure. A job that could not be measured says so in its note."""
    jobs = run_bench(lambda text: print(text, file=sys.stderr, flush=True))
    jobs += [
        Job(f"friction: {row.name}", row.seconds, row.ratio, None, None, f"{row.note}; target {row.target:g} s")
        for row in friction_jobs(5)
    ]
    jobs += [*chain_jobs(5), *axis_jobs(5), *rolling_jobs(3)]
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def _tables(jobs: Sequence[Job]) -> Iterator[Table]:
    from rich.table import Table

    table = Table(title="bench", title_justify="left")
    for heading in ("job", "seconds", "ratio", "unknowns", "peak MB", "what is included"):
        table.add_column(heading, justify="left" if heading in ("job", "what is included") else "right")

    def cell(value: float | None, form: str) -> str:
        return "–" if value is None else format(value, form)

    for job in jobs:
        table.add_row(
            job.job,
            cell(job.seconds, ".3g"),
            cell(job.ratio, ".4g"),
            cell(job.unknowns, "d"),
            cell(job.peak_MB, ".0f"),
            job.note,
        )
    yield table
