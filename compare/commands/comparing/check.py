"""The command ``rollbench check``: the shipped gate, or a user's scenes against their 3D reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rollbench.comparison.commands.printing import Answer, on_terminal
from rollbench.comparison.errors import InputError
from rollbench.comparison.gate.publish import Outcome, of_row, of_verdict, publish
from rollbench.comparison.gate.user import Asked, check_scenes
from rollbench.comparison.gate.verdict import CODES, LARGEST, LIMIT, Verdict, worst_of
from rollbench.comparison.reference.jobs import Engine
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.scene_file import whole
from rollbench.meshes.axis import Assembly


@dataclass(frozen=True)
class Files:
    """Files that verdicts are written to besides."""

    junit: Path | None = None
    markdown: Path | None = None
    csv: Path | None = None

    def write(self, outcomes: Sequence[Outcome]) -> list[str]:
        """Write the files that are asked for; lines that say so."""
        written = publish(outcomes, junit_file=self.junit, markdown_file=self.markdown, csv_file=self.csv)
        return [f"{path} written" for path in written]


def run_check(names: Sequence[str], what: Asked, engine: Engine, files: Files) -> Answer:
    """Judge scenes, a line on each; the exit code is that of the gravest verdict."""
    described = [catalogue.any_scene(name) for name in names]
    for k, one in enumerate(described):
        if one.name in (s.name for s in described[:k]):
            advice = "verdicts and stored runs are told apart by the file's name: rename one"
            raise InputError(names[k], "name", one.name, "each scene once, under a name of its own", advice)
    scenes = [whole(x, name) for x, name in zip(described, names, strict=True) if not isinstance(x, Assembly)]
    verdicts = check_scenes(scenes, what, engine, on_terminal) if scenes else []
    verdicts += [_of_axis(x, what) for x in described if isinstance(x, Assembly)]
    gravest = worst_of([v.word for v in verdicts])
    written = files.write([of_verdict(v) for v in verdicts])
    data = {"verdict": gravest, "passed": gravest == "pass", "verdicts": [v.as_json() for v in verdicts]}
    counts = ", ".join(f"{n} {word}" for word in CODES if (n := sum(v.word == word for v in verdicts)))
    return Answer(data, [*(v.line() for v in verdicts), counts, *written], CODES[gravest])


def _of_axis(assembly: Assembly, what: Asked) -> Verdict:
    """Several sets have no 3D reference."""
    limit = LIMIT if what.max_error is None else what.max_error
    detail = f"{len(assembly.sets)} sets on one shaft: the 3D reference meshes one nut or ring with its balls"
    judged = what.model if what.loads is None else what.loads.name
    return Verdict(assembly.name, judged, LARGEST, "not covered", None, None, limit, detail=detail)


def run_shipped(max_error: float | None, files: Files) -> Answer:
    """The gate of what is shipped; exit code 1 where a row fails."""
    from rollbench.comparison.gate.gate import as_table, run_gate
    from rollbench.comparison.models.study import Study

    limit = LIMIT if max_error is None else max_error
    rows = run_gate(Study(members=0), limit)  # no screws are drawn: no claim on random errors is gated
    bad = [row for row in rows if not row.passed]
    written = files.write([of_row(row) for row in rows])
    data = {"max_error_percent": limit, "passed": not bad, "rows": [row.as_json() for row in rows]}
    words = [row.verdict for row in rows]
    others = "".join(f", {n} {word}" for word in ("undecided", "reported") if (n := words.count(word)))
    line = f"{words.count('ok')} passed, {len(bad)} failed{others}"
    return Answer(data, [as_table(rows), line, *written], 1 if bad else 0)
