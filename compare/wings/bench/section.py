"""Run times: ratios to the source's formulation in the same process, with seconds, and the times that the source
reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from rollbench.comparison.costs.timing import Job
from rollbench.comparison.models.study import Study
from rollbench.comparison.printed.printed_data import entry, load_table
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.registration import offered
from rollbench.comparison.wings.bench.axis_bench import jobs as axis_jobs
from rollbench.comparison.wings.bench.bench import run_bench
from rollbench.comparison.wings.bench.long import kept
from rollbench.comparison.wings.bench.typed import as_typed, scaling, spent_table
from rollbench.reports.records import Quantity, Row, Section, Table, Text


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    commands = []
    for one in as_typed():
        step(one.job)
        commands.append(one)
    done = [*commands, *run_bench(step), *(job for added in offered("timing jobs") for job in added()), *axis_jobs(5)]
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
            spent_table([*done, *kept([*(study.stores or ()), shipped_store()])]),
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
