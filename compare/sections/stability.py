"""Numerical stability on stiff and extreme scenes."""

from __future__ import annotations

from collections.abc import Callable

from compare.extremes.campaign.record import rows as campaign_rows
from compare.extremes.campaign.record import shipped
from compare.extremes.friction import table_section_items
from compare.extremes.rows import tally, wide_rows
from compare.extremes.static import ENERGY, FORMULATIONS, table
from compare.models.study import Study
from reports.records import Cell, Column, Section, Table, Text


def section(study: Study, step: Callable[[str], None]) -> Section:  # noqa: ARG001 - every section takes the study
    """Section of the report, with its headline."""

    def progress(done: int, total: int, case: str) -> None:
        if done % 10 == 0 or done == total:
            step(f"{done} of {total} cases ({case})")

    rows = table(progress)
    counts = tally(rows)
    summary: list[dict[str, Cell]] = [
        {"formulation": name, "solved": solved, "tried": tried, "cases": total}
        for name, (solved, tried, total) in counts.items()
    ]
    columns = (
        Column("case", "case", "", "s"),
        Column(ENERGY, "energy solver", "", "s"),
        Column("iterations", "iterations", "", "s"),
        Column("residual", "residual", "", "g2"),
        Column("bound", "round-off bound", "", "g2"),
        *(Column(name, name, "", "s") for name in FORMULATIONS[1:]),
    )
    solved, _, total = counts[ENERGY]
    return Section(
        "stability",
        "Numerical stability on stiff and extreme scenes",
        (
            Text(
                (
                    "Each case is solved by the convex energy from a cold start, and by the source's plain Newton from "
                    "three starts on the same equations. A case without equilibrium counts as solved when the "
                    "mechanism is named. Residuals are the largest unbalanced force over the largest force; the "
                    "bound is what double precision leaves at best.",
                )
            ),
            Table(
                "stability-summary",
                "Cases solved",
                (
                    Column("formulation", "formulation", "", "s"),
                    Column("solved", "solved", "", "s"),
                    Column("tried", "tried", "", "s"),
                    Column("cases", "cases", "", "s"),
                ),
                summary,
            ),
            Table("stability-cases", "Case by case", columns, wide_rows(rows)),
            *table_section_items(),
            Text(
                (
                    "Random extreme screws and bearings, mutated files and killed processes, each outcome judged by "
                    "a check of its own: balance summed from printed numbers, refusals proven by rank or a linear program, "
                    "small scenes with a rigid screw compared with plain minimisation. The counts are the named command's.",
                )
            ),
            Table(
                "stability-campaign",
                "The campaign",
                (
                    Column("command", "command", "", "s"),
                    Column("what", "what", "", "s"),
                    Column("outcome", "outcome", "", "s"),
                    Column("count", "count", "", "s"),
                ),
                campaign_rows(shipped()),
            ),
        ),
        (("extreme scenes solved", f"{solved} of {total}"),),
    )
