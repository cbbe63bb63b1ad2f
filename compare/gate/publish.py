"""Verdicts for other programs: JUnit XML for test servers, Markdown for summaries, CSV for spreadsheets."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from rollbench.comparison.errors import InputError, one_line
from rollbench.comparison.gate.verdict import Verdict
from rollbench.comparison.writing import replace_file
from rollbench.reports.cells import harmless

if TYPE_CHECKING:
    from rollbench.comparison.gate.gate import GateRow  # brings all evidence with it

#: Variables of the environment in which services of continuous integration name the file of a job's summary.
SUMMARIES = ("GITHUB_STEP_SUMMARY",)
HEADS = ("verdict", "scene or check", "judged", "quantity", "error %", "uncertainty %", "limit %", "ball", "flank", "note")


@dataclass(frozen=True)
class Outcome:
    """One row of a published table: whether it is green, its verdict in a word, and its cells in the order of HEADS."""

    good: bool
    cells: tuple[str, ...]

    @property
    def word(self) -> str:
        """The verdict."""
        return self.cells[0]

    def text(self) -> str:
        """All but the verdict, as ``heading: cell`` with semicolons."""
        return "; ".join(f"{head}: {cell}" for head, cell in zip(HEADS[1:], self.cells[1:], strict=True) if cell)


def of_verdict(v: Verdict) -> Outcome:
    """The row of a verdict on a user's scene."""
    at = ("", "") if v.ball is None else (str(v.ball), v.flank or "")
    numbers = (v.error_percent, v.uncertainty_percent, v.limit_percent)
    cells = (v.word, v.of, v.judged, v.quantity, *map(_number, numbers), *at, v.detail)
    return Outcome(v.word == "pass", tuple(one_line(cell, 2000) for cell in cells))


def of_row(row: GateRow) -> Outcome:
    """The row of a check of the shipped gate."""
    numbers = (row.error_percent, row.uncertainty_percent, row.limit_percent)
    cells = (row.verdict, row.name, "", row.kind, *map(_number, numbers), "", "", row.detail)
    return Outcome(row.passed, tuple(one_line(cell, 2000) for cell in cells))


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def junit(outcomes: Sequence[Outcome]) -> str:
    """JUnit XML: one test case a row. Everything that is not green is a failure of the type of its verdict."""
    bad = [o for o in outcomes if not o.good]
    counts = {"tests": str(len(outcomes)), "failures": str(len(bad)), "errors": "0", "skipped": "0"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": "rollbench check"} | counts)
    for o in outcomes:
        name = ", ".join(cell for cell in o.cells[1:4] if cell)
        case = ElementTree.SubElement(suite, "testcase", {"classname": f"rollbench.{o.cells[1]}", "name": name})
        if o.good:
            ElementTree.SubElement(case, "system-out").text = f"{o.word}; {o.text()}"
        else:
            ElementTree.SubElement(case, "failure", {"type": o.word, "message": o.text()}).text = o.text()
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def markdown(outcomes: Sequence[Outcome]) -> str:
    """A heading with the counts and a table, rows that are not green first."""
    counts: dict[str, int] = {}
    for o in outcomes:
        counts[o.word] = counts.get(o.word, 0) + 1
    head = ", ".join(f"{n} {word}" for word, n in counts.items())
    lines = [f"### rollbench check: {head}", "", _line(HEADS), _line(["---"] * len(HEADS))]
    lines += [_line(o.cells) for o in sorted(outcomes, key=lambda o: o.good)]
    return "\n".join(lines) + "\n"


def _line(cells: Sequence[str]) -> str:
    safe = (c.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;") for c in cells)
    return f"| {' | '.join(safe)} |"


def table(outcomes: Sequence[Outcome]) -> str:
    """CSV with a line of headings."""

    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(HEADS)
    writer.writerows([harmless(cell) for cell in o.cells] for o in outcomes)
    return text.getvalue()


def publish(
    outcomes: Sequence[Outcome],
    *,
    junit_file: Path | None = None,
    markdown_file: Path | None = None,
    csv_file: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> list[Path]:
    """Write what is asked for; the Markdown is also added to the summary that a service of continuous integration names.

    Returns the files written. Raises InputError where one cannot be.
    """
    named = os.environ if environment is None else environment
    written = []
    for file, made in ((junit_file, junit), (markdown_file, markdown), (csv_file, table)):
        if file is not None:
            replace_file(file, made(outcomes))
            written.append(file)
    summaries = [named[name] for name in SUMMARIES if named.get(name)] if markdown_file is not None else []
    return written + [_added(Path(name), markdown(outcomes)) for name in summaries]


def _added(path: Path, text: str) -> Path:
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        reason = error.strerror or str(error)
        advice = f"the environment names it: {', '.join(SUMMARIES)}"
        raise InputError(str(path), "summary", reason, "a file that can be written", advice) from None
    return path
