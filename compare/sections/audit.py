"""The audit in the report: every printed entry with its verdict, and how much of each source can be trusted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rollbench.compare.evidence import APART, Evidence, audit, counts, left_out, misprints, trust
from rollbench.compare.models.study import Study
from rollbench.compare.printed import VERDICTS
from rollbench.reports.content import Quantity, Section, Table, Text


def _texts(*columns: tuple[str, str]) -> tuple[Quantity, ...]:
    return tuple(Quantity(key, label, "", "s") for key, label in columns)


def counts_table(rows: Sequence[Evidence]) -> Table:
    """Entries by source and verdict."""
    heads = [(v, f"{v}, apart" if v in APART else v) for v in VERDICTS]
    columns = _texts(("source", "source"), *heads, ("judged", "judged"), ("all", "all"))
    note = "Judged: without inputs and identities, which say nothing of a model."
    return Table("audit-counts", "Printed entries by source and verdict", columns, counts(rows), note)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("every printed entry")
    rows = audit(study)
    words = [trust(row) for row in counts(rows)]
    meanings = [f"{verdict}: {text}." for verdict, text in VERDICTS.items()]
    shown = _texts(
        ("source", "source"),
        ("place", "place"),
        ("wrong", "as printed"),
        ("right", "right"),
        ("evidence", "evidence"),
        ("command", "command that shows it"),
        ("test", "test"),
    )
    missing = _texts(
        ("source", "source"), ("place", "place"), ("what", "what"), ("count", "numbers, about"), ("reason", "why left out")
    )
    items = (
        Text(words),
        counts_table(rows),
        Text(meanings, bullets=True),
        Table("audit-misprints", "Misprints, each with a command that shows it and a test", shown, misprints()),
        Table("audit-left-out", "Printed numbers that are no entries, and why", missing, left_out()),
    )
    return Section("audit", "Audit: how much of each source can be trusted", items)
