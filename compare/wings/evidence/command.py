"""The commands ``rollbench audit``, and ``rollbench list --trace``: where every printed number comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import tables
from rollbench.compare.text.printing import Answer, cell
from rollbench.compare.text.tables import ruled
from rollbench.compare.wings.evidence.audit import (
    APART,
    VERDICTS,
    Audited,
    as_stored,
    audit,
    changes,
    counts,
    left_out,
    misprints,
    trust,
)
from rollbench.compare.wings.evidence.registry import traces
from rollbench.compare.writing import replace_file


def run_audit(only: Sequence[str], *, write: Path | None) -> Answer:
    """Judge every printed entry: counts, entries, misprints, what is left out; exit code 1 where a verdict differs from
    the stored list. Raises InputError for an unknown table."""
    unknown = [name for name in only if name not in tables()]
    if unknown:
        raise ArgumentError("only", unknown[0], ", ".join(tables()), "see: rollbench list")
    rows = audit(Study(), *only)
    if write is not None:
        replace_file(write, as_stored(rows))
    changed = changes(rows)
    return Answer(as_json(rows, changed), as_table(rows, changed), 1 if changed else 0)


def as_json(rows: Sequence[Audited], changed: Sequence[str]) -> dict[str, Any]:
    """JSON-ready."""
    return {
        "counts": counts(rows),
        "entries": [row.as_json() for row in rows],
        "misprints": misprints(),
        "left_out": left_out(),
        "changed_verdicts": list(changed),
    }


def as_table(rows: Sequence[Audited], changed: Sequence[str]) -> list[Any]:
    """The same for the terminal; misprints and what is left out as counts."""
    from rich.table import Table

    headings = [name + (" (apart)" if name in APART else "") for name in ("source", *VERDICTS, "judged", "all")]
    table = ruled("printed entries by verdict", headings, (map(str, row.values()) for row in counts(rows)))
    entries = Table(title="entries", title_justify="left")
    for heading in ("entry", "printed", "as printed", "right", "3D", "error %", "verdict", "reason"):
        entries.add_column(heading, overflow="fold")
    for one in rows:
        data = one.as_json()
        numbers = (cell(data[k], ".5g") for k in ("as_printed", "right", "reference_3d", "error_percent"))
        entries.add_row(one.name, f"{data['printed']} {data['unit']}".rstrip(), *numbers, one.verdict, one.reason)
    lines = [trust(row) for row in counts(rows)]
    lines.append(f"{len(misprints())} misprints with a command and a test each, {len(left_out())} groups left out: --json")
    return [table, *lines, entries, *(f"changed: {line}" for line in changed)]


def traced(table: str = "") -> Answer:
    """Every printed entry of one table, or of all: table, key, as printed, class, scenes or why none, computation
    (``module:function``), test. Raises InputError for an unknown table."""
    from rich.table import Table

    entries = list(traces(table))
    shown = Table(title="every printed number: scenes, computation, test", title_justify="left")
    for heading in ("table", "key", "printed", "class", "scenes, or why none", "computed by", "test"):
        shown.add_column(heading, overflow="ellipsis" if heading == "printed" else "fold")
    for t in entries:
        test = t.test.removeprefix("tests/sources/")
        shown.add_row(t.table, t.key, t.printed, t.cls, ", ".join(t.scenes) or t.no_scene, t.computation, test or "–")
    return Answer([asdict(trace) for trace in entries], [shown])
