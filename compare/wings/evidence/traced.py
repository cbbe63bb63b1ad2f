"""The command ``rollbench list --trace``: where every printed number comes from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.wings.evidence.registry import Trace, traces

if TYPE_CHECKING:
    from rich.table import Table


def traced(table: str = "") -> Answer:
    """Every printed entry of one table, or of all: table, key, as printed, class, scenes or why none, computation
    (``module:function``), test. Raises InputError for an unknown table."""
    entries = list(traces(table))
    return Answer([asdict(trace) for trace in entries], _trace_tables(entries))


def _trace_tables(traces: Sequence[Trace]) -> Iterator[Table]:
    from rich.table import Table

    out = Table(title="every printed number: scenes, computation, test", title_justify="left")
    for heading in ("table", "key", "printed", "class", "scenes, or why none", "computed by", "test"):
        out.add_column(heading, overflow="ellipsis" if heading == "printed" else "fold")
    for t in traces:
        test = t.test.removeprefix("tests/sources/")
        out.add_row(t.table, t.key, t.printed, t.cls, ", ".join(t.scenes) or t.no_scene, t.computation, test or "–")
    yield out
