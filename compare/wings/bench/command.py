"""The command ``rollbench bench``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from rollbench.comparison.commands.printing import Answer, cell, on_terminal
from rollbench.comparison.commands.tables import ruled
from rollbench.comparison.costs.timing import Job
from rollbench.comparison.registration import offered
from rollbench.comparison.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.comparison.wings.bench.bench import run_bench
from rollbench.comparison.wings.bench.typed import as_typed

if TYPE_CHECKING:
    from rich.table import Table


def run_bench_command() -> Answer:
    """Measure. A job that could not be measured says so in its note."""
    jobs = []
    for one in as_typed():
        on_terminal(f"{one.timed.job}: {one.whole or 0.0:.3g} s of a processor")
        jobs.append(one.timed)
    jobs += run_bench(on_terminal)
    for job in (*axis_jobs(5), *(job for added in offered("bench") for job in added())):
        on_terminal(job.job)
        jobs.append(job)
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def _tables(jobs: Sequence[Job]) -> Iterator[Table]:
    forms = {"seconds": ".3g", "ratio": ".4g", "unknowns": "d", "peak_MB": ".0f"}
    rows = ([job.job, *(cell(getattr(job, name), form) for name, form in forms.items()), job.note] for job in jobs)
    headings = ("job", "seconds", "ratio", "unknowns", "peak MB", "what is included")
    yield ruled("bench", headings, rows, ("job", "what is included"))
