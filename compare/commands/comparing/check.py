"""The command ``rollbench check``: the shipped gate, or a user's scenes against their 3D reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.comparison.commands.printing import Answer, on_terminal
from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.baseline import Change, changes
from rollbench.comparison.gate.further import not_judged
from rollbench.comparison.gate.publish import Outcome, of_row, of_verdict, publish
from rollbench.comparison.gate.user import Asked, check_scenes
from rollbench.comparison.gate.verdict import CODES, LIMIT, worst_of
from rollbench.comparison.reference.jobs import Engine
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.scene_file import solvable


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
        """That in words; nothing without a baseline."""
        if self.baseline is None:
            return []
        return [f"since {self.baseline.name}: {change.line()}" for change in changed] or [
            f"since {self.baseline.name}: nothing changed"
        ]

    def write(self, outcomes: Sequence[Outcome], notes: Sequence[str]) -> list[str]:
        """Write the files that are asked for; lines that say so."""
        written = publish(outcomes, notes, junit_file=self.junit, markdown_file=self.markdown, csv_file=self.csv)
        return [f"{path} written" for path in written]


def run_check(names: Sequence[str], what: Asked, engine: Engine, files: Files) -> Answer:
    """Judge scenes, a line on each; the exit code is that of the gravest verdict."""
    described = [catalogue.any_scene(name) for name in names]
    for k, one in enumerate(described):
        if one.name in (s.name for s in described[:k]):
            advice = "verdicts and stored runs are told apart by the file's name: rename one"
            raise InputError(names[k], "name", one.name, "each scene once, under a name of its own", advice)
    scenes = [solvable(x, name) for x, name in zip(described, names, strict=True)]
    warnings: list[str] = []
    verdicts = check_scenes(scenes, what, engine, on_terminal, warnings.append)
    gravest, outcomes = worst_of([v.word for v in verdicts]), [of_verdict(v) for v in verdicts]
    left = not_judged(verdicts) if what.loads or what.values else []
    changed = files.changed(outcomes)
    above = [f"WARNING: {warning}" for warning in warnings]
    below = [f"not judged, because not given or not held by the reference: {', '.join(left)}"] if left else []
    below += files.since(changed)
    written = files.write(outcomes, [*above, *below])
    data: dict[str, Any] = {
        "verdict": gravest,
        "passed": gravest == "pass",
        "verdicts": [v.as_json() for v in verdicts],
        "warnings": warnings,
        "not_judged": left,
    }
    data |= {} if files.baseline is None else {"changed": [change._asdict() for change in changed]}
    counts = ", ".join(f"{n} {word}" for word in CODES if (n := sum(v.word == word for v in verdicts)))
    return Answer(data, [*above, *(v.line() for v in verdicts), *below, counts, *written], CODES[gravest])


def run_shipped(max_error: float | None, files: Files) -> Answer:
    """The gate of what is shipped; exit code 1 where a row fails."""
    from rollbench.comparison.gate.gate import as_table, run_gate
    from rollbench.comparison.models.study import Study

    limit = LIMIT if max_error is None else max_error
    rows = run_gate(Study(members=0), limit)  # no screws are drawn: no claim on random errors is gated
    bad = [row for row in rows if not row.passed]
    outcomes = [of_row(row) for row in rows]
    changed = files.changed(outcomes)
    written = [*files.since(changed), *files.write(outcomes, files.since(changed))]
    data = {"max_error_percent": limit, "passed": not bad, "rows": [row.as_json() for row in rows]}
    data |= {} if files.baseline is None else {"changed": [change._asdict() for change in changed]}
    words = [row.verdict for row in rows]
    others = "".join(f", {n} {word}" for word in ("undecided", "reported") if (n := words.count(word)))
    line = f"{words.count('ok')} passed, {len(bad)} failed{others}"
    return Answer(data, [as_table(rows), line, *written], 1 if bad else 0)
