"""The command ``rollbench bench``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from rollbench.compare.commands.printing import Answer, cell, on_terminal
from rollbench.compare.commands.tables import ruled
from rollbench.compare.registration import offered
from rollbench.compare.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.compare.wings.bench.bench import run_bench
from rollbench.compare.wings.bench.costs.timing import Job
from rollbench.compare.wings.bench.waits import CATALOGUED, TYPED, long_jobs

if TYPE_CHECKING:
    from rich.table import Table


def run_bench_command() -> Answer:
    """Measure. A job that could not be measured says so in its note."""
    jobs = [_told(one.measured()) for one in (*TYPED, *CATALOGUED)]
    jobs += run_bench(on_terminal)
    for job in (*axis_jobs(5), *(job for added in offered("bench") for job in added())):
        on_terminal(job.job)
        jobs.append(job)
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def run_long(names: Sequence[str], store: Path | None) -> Answer:
    """Measure what takes minutes, and keep it in a store. Raises InputError for an unknown name."""
    jobs = [_told(job) for job in long_jobs(names, store)]
    return Answer([asdict(job) for job in jobs], _tables(jobs))


def _told(job: Job) -> Job:
    on_terminal(f"{job.job}: {job.note}" if job.seconds is None else f"{job.job}: {job.seconds:.3g} s")
    return job


def _tables(jobs: Sequence[Job]) -> Iterator[Table]:
    forms = {"seconds": ".3g", "aim": ".3g", "floor": ".3g", "ratio": ".4g", "unknowns": "d", "peak_MB": ".0f"}
    rows = ([job.job, *(cell(getattr(job, name), form) for name, form in forms.items()), job.note] for job in jobs)
    headings = ("job", "seconds", "aim", "floor", "ratio", "unknowns", "peak MB", "what is included")
    yield ruled("bench", headings, rows, ("job", "what is included"))
