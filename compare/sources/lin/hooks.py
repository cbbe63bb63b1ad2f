"""What the thesis adds to the commands and sections of wings: run times, extremes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from rollbench.compare.registration import registered
from rollbench.reports.content import Cell, Quantity, Table, Text

if TYPE_CHECKING:
    from rollbench.compare.wings.bench.costs.timing import Job


def bench_jobs() -> Iterator[Job]:
    """Friction and ball motion as jobs of ``rollbench bench``."""
    if "friction" in registered():
        from rollbench.compare.sources.lin.bench import jobs
        from rollbench.compare.wings.bench.costs.timing import Job

        for row in jobs(5):
            text = f"{row.note}; target {row.target:g} s"
            yield Job(f"friction: {row.name}", row.seconds, row.ratio, None, None, text)


def timing_tables(step: Callable[[str], None]) -> Iterator[Table]:
    """Tables of the report's section on run times."""
    if "friction" in registered():
        yield friction_table(step)


def stability_items() -> Iterator[Text | Table]:
    """What the report's section on stability says of friction."""
    if "friction" in registered():
        from rollbench.compare.sources.lin.extremes.items import table_section_items

        yield from table_section_items()


def friction_table(step: Callable[[str], None]) -> Table:
    """Friction and ball motion against their targets."""
    from rollbench.compare.sources.lin.bench import jobs

    step("friction")
    rows: list[dict[str, Cell]] = [asdict(row) | {"reached": "yes" if row.reached else "no"} for row in jobs(5)]
    columns = (
        Quantity("name", "job", "", "s"),
        Quantity("seconds", "seconds", "s", "g3"),
        Quantity("target", "target", "s", "g3"),
        Quantity("reached", "reached", "", "s"),
        Quantity("ratio", "ratio", "", "g3"),
        Quantity("note", "what is included", "", "s"),
    )
    return Table("timing-friction", "Friction and ball motion, compiled", columns, rows)
