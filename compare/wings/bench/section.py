"""Run times: ratios to the source's formulation in the same process, with seconds, and the times that the source
reports."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry, load_table
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.registration import offered
from rollbench.comparison.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.comparison.wings.bench.bench import run_bench
from rollbench.comparison.wings.bench.costs.kept import save_rows
from rollbench.comparison.wings.bench.costs.timing import Job
from rollbench.comparison.wings.bench.growth import scaling
from rollbench.comparison.wings.bench.waits import TYPED, kept, now_and_here, spent_table
from rollbench.reports.records import Quantity, Row, Section, Table, Text

#: File of a store that holds the jobs of this section.
JOBS = "jobs.json"


def jobs_now(step: Callable[[str], None]) -> Iterator[Job]:
    """Every job, measured now."""
    for one in TYPED:
        step(one.job)
        yield one.measured()
    yield from run_bench(step)
    yield from (job for added in offered("timing jobs") for job in added())
    yield from axis_jobs(5)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    stores = [*(study.stores or ()), shipped_store()]
    done = [] if study.timed else kept(stores, JOBS)
    if not done:
        done = [replace(job, when=now_and_here()) for job in jobs_now(step)]
        if study.stores:
            save_rows(study.stores[0], JOBS, done)
    rows: list[dict[str, Any]] = [asdict(job) for job in done]
    printed: list[Row] = [
        {
            Quantity("label", "quantity", "", "s"): p.label,
            "printed": p.printed,
            "unit": p.unit,
            "class": p.cls,
            "remark": p.remark,
        }
        for p in load_table("lin-2.2")
    ]
    reported = entry("lin-2.2", "time_proposed_1")
    return Section(
        "timing",
        "Run times",
        (
            Text(
                (
                    (
                        "Ratios: seconds of the source's formulation over those of the solver here, for the "
                        f"same task in the same process. The source reports {reported.printed} s for case 1 on "
                        "its own machine and in its own language; this is shown below, not compared."
                    ),
                )
            ),
            spent_table([*done, *kept(stores)]),
            *scaling(study),
            Table(
                "timing-jobs",
                "Jobs",
                (
                    Quantity("job", "job", "", "s"),
                    Quantity("seconds", "seconds", "s", "g3"),
                    Quantity("ratio", "ratio", "", "g3"),
                    Quantity("unknowns", "unknowns", "", "s"),
                    Quantity("peak_MB", "peak memory", "MB", ".0f"),
                    Quantity("note", "what is included", "", "s"),
                    Quantity("when", "measured", "", "s"),
                ),
                rows,
            ),
            *(table for added in offered("timing") for table in added(step)),
            Table.of("timing-printed", "Table 2.2 as printed", printed),
        ),
        conclusion=conclusion(done),
    )


def conclusion(done: Sequence[Job]) -> str:
    """Time of case 1, and its ratio to the source's Newton from a good guess."""
    job = next(job for job in done if job.job == "cold solve, case 1")
    if job.seconds is None or job.ratio is None:
        return ""
    return (
        f"A cold solve of case 1 takes {1e6 * job.seconds:.0f} µs, the source's formulation {job.ratio:.0f} times as long."
    )
