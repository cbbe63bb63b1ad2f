"""The command ``rollbench list``: what is shipped, and where every printed number comes from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.models.registry import AXIS_MODELS, MODELS
from rollbench.comparison.printed import printed_data
from rollbench.comparison.registration import kinds
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.names import AXIS, WHOLE

if TYPE_CHECKING:
    from rich.table import Table

    from rollbench.comparison.evidence.registry import Trace


def shipped() -> Answer:
    """Scenes, models and printed tables."""
    data = _shipped_json()
    return Answer(data, _lines(data))


def _shipped_json() -> dict[str, dict[str, Any]]:
    """Scenes by kind and models with their titles, printed tables with their number of rows."""
    titles = {name: catalogue.heading(name)["title"] for name in catalogue.scene_names()}
    return {
        "scenes": {k: {n: t for n, t in titles.items() if catalogue.kind(n) == k} for k in (*WHOLE, AXIS, *kinds())},
        "models": {model.name: model.about for model in MODELS.values()},
        "models of several sets on one shaft": {name: MODELS[name].label for name in AXIS_MODELS},
        "printed_tables": {name: len(printed_data.load_table(name)) for name in printed_data.tables()},
    }


def _lines(data: Mapping[str, Any]) -> Iterator[str]:
    """The same for the terminal."""
    groups = {f"scenes, {kind}": titles for kind, titles in data["scenes"].items()}
    groups |= {group: entries for group, entries in data.items() if group != "scenes"}
    width = max(len(name) for group in groups.values() for name in group)
    for group, entries in groups.items():
        yield group.replace("_", " ")
        for name, text in entries.items():
            yield f"  {name:{width}}  {f'{text} rows' if group == 'printed_tables' else text}"


def traced(table: str = "") -> Answer:
    """Every printed entry of one table, or of all: table, key, as printed, class, scenes or why none, computation
    (``module:function``), test. Raises InputError for an unknown table."""
    from rollbench.comparison.evidence.registry import traces

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
