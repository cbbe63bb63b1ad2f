"""The command ``rollbench check``: the shipped gate, or a user's scenes against their 3D reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import InputError
from rollbench.compare.gate.publish import Change, Outcome, changes, of_row, of_verdict, publish
from rollbench.compare.gate.user import Asked, as_shares
from rollbench.compare.gate.verdict import CODES, LIMIT, Limits
from rollbench.compare.reference.jobs import Engine
from rollbench.compare.results.base import with_schema
from rollbench.compare.results.verdict import verdict_of
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.scene_file import each_case
from rollbench.compare.text.printing import Answer, cell, on_terminal
from rollbench.compare.text.tables import ruled

if TYPE_CHECKING:
    from rich.table import Table

    from rollbench.compare.gate.gate import GateRow


@dataclass(frozen=True)
class Files:
    """Files that verdicts are written to besides, and an earlier one to hold them against."""

    junit: Path | None = None
    markdown: Path | None = None
    csv: Path | None = None
    baseline: Path | None = None

    def changed(self, outcomes: Sequence[Outcome]) -> list[Change]:
        """What changed since the verdicts of the baseline. Raises InputError."""
        return [] if self.baseline is None else changes(self.baseline, outcomes)

    def since(self, changed: Sequence[Change]) -> list[str]:
        """The changes in words; none without a baseline."""
        if self.baseline is None:
            return []
        return [f"since {self.baseline.name}: {change.line()}" for change in changed] or [
            f"since {self.baseline.name}: nothing changed"
        ]

    def write(self, outcomes: Sequence[Outcome], notes: Sequence[str]) -> list[str]:
        """Write the files that are asked for; lines that say so."""
        written = publish(outcomes, notes, junit_file=self.junit, markdown_file=self.markdown, csv_file=self.csv)
        return [f"{path} written" for path in written]


def run_check(names: Sequence[str], request: Asked, engine: Engine, files: Files) -> Answer:
    """Judge scenes, a line on each, or on each of its load cases; the exit code is that of the gravest verdict."""
    described = [catalogue.any_scene(name) for name in names]
    taken: dict[str, str] = {}
    for one, name in zip(described, names, strict=True):
        for scene in each_case(one, name):
            if scene.name in taken:
                advice = "verdicts differ by the name of file and case: rename one"
                raise InputError(name, "name", scene.name, "each scene once, under a name of its own", advice)
            taken[scene.name] = name
    found = verdict_of(described, names, request, engine, on_terminal)
    verdicts, left = found.judged, found.not_judged
    outcomes = [of_verdict(v) for v in verdicts]
    changed = files.changed(outcomes)
    above = [f"WARNING: {warning}" for warning in found.warnings]
    below = [f"not judged, because not given or not held by the reference: {', '.join(left)}"] if left else []
    below += files.since(changed)
    written = files.write(outcomes, [*above, *below])
    counts = ", ".join(f"{n} {word}" for word in CODES if (n := sum(v.word == word for v in verdicts)))
    data: dict[str, Any] = found.to_dict()
    data |= {} if files.baseline is None else {"changed": [change.as_json() for change in changed]}
    worst = [f"the worst of {x['scene']}: case {x['case']}, {x['verdict']}" for x in data.get("worst_cases", ())]
    return Answer(data, [*above, *(v.line() for v in verdicts), *worst, *below, counts, *written], CODES[data["verdict"]])


def run_shipped(max_error: float | None, files: Files) -> Answer:
    """The gate of what is shipped; exit code 1 where a row fails."""
    from rollbench.compare.commands.check import run_gate
    from rollbench.compare.models.study import Study

    limit = LIMIT if max_error is None else max_error
    rows = run_gate(Study(members=0), limit)  # no screws are drawn: no claim on random errors is gated
    bad = [row for row in rows if not row.passed]
    outcomes = [of_row(row) for row in rows]
    changed = files.changed(outcomes)
    written = [*files.since(changed), *files.write(outcomes, files.since(changed))]
    warnings = [*as_shares(Limits(limit))]
    data = with_schema(
        {"max_error_percent": limit, "passed": not bad, "rows": [row.as_json() for row in rows], "warnings": warnings}
    )
    data |= {} if files.baseline is None else {"changed": [change.as_json() for change in changed]}
    words = [row.verdict for row in rows]
    others = "".join(f", {n} {word}" for word in ("undecided", "reported") if (n := words.count(word)))
    line = f"{words.count('ok')} passed, {len(bad)} failed{others}"
    above = [f"WARNING: {warning}" for warning in warnings]
    return Answer(data, [*above, gate_table(rows), line, *written], 1 if bad else 0)


def gate_table(rows: Sequence[GateRow]) -> Table:
    """Rows of the gate, those that fail first; none reads "ok" whose figure is over its line."""
    texts = (
        (
            row.verdict,
            row.name + (f" ({row.detail})" if row.detail and not row.passed else ""),
            row.kind,
            *(cell(x, ".6g") for x in (row.value, row.reference)),
            *(cell(x, ".3g") for x in (row.error_percent, row.limit_percent)),
        )
        for row in sorted(rows, key=lambda row: row.passed)
    )
    return ruled("gate", ("", "check", "kind", "value", "reference", "error %", "limit %"), texts, ("", "check", "kind"))
