"""Writes verdicts as files: JUnit XML for test servers, Markdown for summaries, CSV for spreadsheets.

Also finds changes against an earlier file of ``rollbench check --csv`` or ``--json``.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree

from rollbench.compare.errors import InputError, one_line
from rollbench.compare.files import replace_file, why_no_figure, write_figure
from rollbench.compare.gate.verdict import Verdict, judged_subject
from rollbench.compare.models.loads_file import read_table
from rollbench.reports.cells import escape_formula

if TYPE_CHECKING:
    from rollbench.compare.gate.gate import GateRow
    from rollbench.reports.content import Figure


#: Environment variables in which services of continuous integration give the file of a job's summary.
SUMMARIES = ("GITHUB_STEP_SUMMARY",)

HEADINGS = (
    "verdict",
    "scene or check",
    "judged",
    "quantity",
    "error %",
    "uncertainty %",
    "limit %",
    "ball",
    "flank",
    "note",
)


@dataclass(frozen=True)
class Outcome:
    """One row of a published table of verdicts, from a user's scene or the shipped gate."""

    #: Whether the row is shown as passed.
    good: bool
    #: Verdict.
    word: str
    #: Name of the scene or check.
    scene: str
    #: Model or file whose values are judged.
    judged: str
    #: Name of the quantity.
    quantity: str
    #: Error in ``unit``; None if there is none.
    error: float | None
    #: Uncertainty of the reference in ``unit``; None if not known.
    uncertainty: float | None
    #: Limit in ``unit``; None if there is none.
    limit: float | None
    unit: str = "%"
    #: Ball that decides, from 1.
    ball: int | None = None
    #: Flank that decides.
    flank: str = ""
    note: str = ""
    #: Neighbouring balls, as in `Verdict`.
    near: tuple[tuple[int, float, float, float], ...] = ()

    @property
    def cells(self) -> tuple[str, ...]:
        """Return the texts of the row, in the order of HEADINGS; units other than per cent follow the number."""
        numbers = (cell_text(x, self.unit) for x in (self.error, self.uncertainty, self.limit))
        ball = "" if self.ball is None else str(self.ball)
        cells = (self.word, self.scene, self.judged, self.quantity, *numbers, ball, self.flank, self.note)
        return tuple(one_line(cell, 2000) for cell in cells)

    def text(self) -> str:
        """Return all cells but the verdict as ``heading: cell``, joined by semicolons; empty cells are left out."""
        return "; ".join(f"{head}: {cell}" for head, cell in zip(HEADINGS[1:], self.cells[1:], strict=True) if cell)


def cell_text(value: float | None, unit: str) -> str:
    """Return a number as the text of a cell, with its unit unless that is per cent; empty for None."""
    return "" if value is None else f"{value:.4g}{'' if unit == '%' else f' {unit}'}"


def outcome_of_verdict(v: Verdict) -> Outcome:
    """Return the published row for a verdict on a user's scene."""
    note = "; ".join(filter(None, (v.pair_text.strip(", "), v.detail)))
    numbers = v.error, v.uncertainty, v.limit, v.unit
    return Outcome(v.word == "pass", v.word, v.subject, v.judged, v.quantity, *numbers, v.ball, v.flank or "", note, v.near)


def outcome_of_check(row: GateRow) -> Outcome:
    """Return the published row for a check of the shipped gate."""
    numbers = (row.error_percent, row.uncertainty_percent, row.limit_percent)
    return Outcome(row.passed, row.verdict, row.name, "", row.kind, *numbers, note=row.detail)


def junit_xml(outcomes: Sequence[Outcome], notes: Sequence[str] = ()) -> str:
    """Return JUnit XML with a test case for each row and notes as properties.

    A row that did not pass is a failure, whose type is its verdict.
    """
    bad = [o for o in outcomes if not o.good]
    counts = {"tests": str(len(outcomes)), "failures": str(len(bad)), "errors": "0", "skipped": "0"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": "rollbench check"} | counts)
    if notes:
        properties = ElementTree.SubElement(suite, "properties")
        for note in notes:
            ElementTree.SubElement(properties, "property", {"name": "note", "value": note})
    for o in outcomes:
        cells = o.cells
        name = ", ".join(cell for cell in cells[1:4] if cell)
        case = ElementTree.SubElement(suite, "testcase", {"classname": f"rollbench.{cells[1]}", "name": name})
        if o.good:
            ElementTree.SubElement(case, "system-out").text = f"{o.word}; {o.text()}"
        else:
            ElementTree.SubElement(case, "failure", {"type": o.word, "message": o.text()}).text = o.text()
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def markdown_text(outcomes: Sequence[Outcome], notes: Sequence[str] = ()) -> str:
    """Return Markdown: a heading with the counts, notes, a table and a chart of the worst ball and its neighbours.

    Rows that did not pass come first. The chart is Mermaid, which GitHub, GitLab, Forgejo and Gitea draw, because a
    comment cannot show an image file.
    """
    counts: dict[str, int] = {}
    for o in outcomes:
        counts[o.word] = counts.get(o.word, 0) + 1
    head = ", ".join(f"{n} {word}" for word, n in counts.items())
    lines = [f"### rollbench check: {head}", *(f"- {_escape_markup(note)}" for note in notes), ""]
    lines += [_table_line(HEADINGS), _table_line(["---"] * len(HEADINGS))]
    lines += [_table_line(o.cells) for o in sorted(outcomes, key=lambda o: o.good)]
    return "\n".join([*lines, *_load_chart_lines(worst_outcome(outcomes))]) + "\n"


def worst_outcome(outcomes: Sequence[Outcome]) -> Outcome | None:
    """Return the row whose ball the picture shows: rows that did not pass first, then by error; None without any."""
    shown = [o for o in outcomes if o.near]
    return min(shown, key=lambda o: (o.good, -abs(o.error or 0.0)), default=None)


def _chart_title(o: Outcome) -> str:
    """Return the title of chart or picture: scene, worst ball, its error and the limit."""
    name = one_line(o.scene, 2000).replace('"', "'")
    return f"{name}, ball {o.ball} {o.flank}: {abs(o.error or 0.0):.2f} {o.unit}, limit {o.limit:.4g} {o.unit}"


def _load_chart_lines(o: Outcome | None) -> list[str]:
    """Return the Markdown lines of a Mermaid chart of the loads around the worst ball; empty without a row."""
    if o is None:
        return []
    balls, loads, reference, _ = zip(*o.near, strict=True)
    top = 1.1 * max(*loads, *reference)
    series = [", ".join(f"{x:.4g}" for x in of) for of in (reference, loads)]
    return [
        "",
        f"Worst ball: bars are the reference, the line is {_escape_markup(o.judged)}.",
        "",
        "```mermaid",
        "xychart-beta",
        f'    title "{_chart_title(o)}"',
        f'    x-axis "ball" [{", ".join(map(str, balls))}]',
        f'    y-axis "contact load / N" 0 --> {top:.4g}',
        f"    bar [{series[0]}]",
        f"    line [{series[1]}]",
        "```",
    ]


def worst_ball_figure(o: Outcome) -> Figure:
    """Return a figure of judged and reference loads around a row's worst ball, with the reference's uncertainty."""
    from rollbench.reports.content import Figure, Panel, Series

    balls, loads, reference, bars = (list(x) for x in zip(*o.near, strict=True))
    ends = [r - b for r, b in zip(reference, bars, strict=True)], [r + b for r, b in zip(reference, bars, strict=True)]
    series = (
        Series("reference", balls, reference, "markers", emphasis=True, bars=ends),
        Series(o.judged, balls, loads, "line+markers"),
    )
    panel = Panel(f"flank {o.flank}", "ball", "contact load / N", series, zero=True, integer_x=True)
    return Figure("worst-ball", _chart_title(o), (panel,))


def _table_line(cells: Sequence[str]) -> str:
    """Return cells as a row of a Markdown table."""
    return f"| {' | '.join(map(_escape_markup, cells))} |"


def _escape_markup(text: str) -> str:
    """Return a text with the characters escaped that are markup in a Markdown table."""
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")


def verdicts_csv(outcomes: Sequence[Outcome]) -> str:
    """Return the rows of verdicts as CSV text, with a line of headings."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(HEADINGS)
    writer.writerows([escape_formula(cell) for cell in o.cells] for o in outcomes)
    return text.getvalue()


def publish(
    outcomes: Sequence[Outcome],
    notes: Sequence[str] = (),
    *,
    junit_file: Path | None = None,
    markdown_file: Path | None = None,
    csv_file: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> list[Path]:
    """Write verdicts as files, and append the Markdown to the summary of a continuous-integration job.

    The picture of the worst ball is written next to the Markdown file as SVG.

    Parameters
    ----------
    outcomes
        Rows to publish.
    notes
        Notes that belong to no row.
    junit_file, markdown_file, csv_file
        Files to write; None: none.
    environment
        Environment variables; None: those of the process.

    Returns
    -------
    list of Path
        Files that were written.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    named = os.environ if environment is None else environment
    written = []
    texts = ((junit_file, junit_xml), (markdown_file, markdown_text), (csv_file, lambda rows, _: verdicts_csv(rows)))
    for file, text_of in texts:
        if file is not None:
            replace_file(file, text_of(outcomes, notes))
            written.append(file)
    shown = worst_outcome(outcomes)
    if markdown_file is not None and shown is not None and not why_no_figure():
        written.append(markdown_file.with_suffix(".svg"))
        write_figure(written[-1], worst_ball_figure(shown))
    summaries = [named[name] for name in SUMMARIES if named.get(name)] if markdown_file is not None else []
    return written + [_append_to_file(Path(name), markdown_text(outcomes, notes)) for name in summaries]


def _append_to_file(path: Path, text: str) -> Path:
    """Append a text to a file and return its path; InputError if it cannot be written."""
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        reason = error.strerror or str(error)
        advice = f"the environment names it: {', '.join(SUMMARIES)}"
        raise InputError(str(path), "summary", reason, "a file that can be written", advice) from None
    return path


#: Identity of a row: scene or check, and quantity.
Label = tuple[str, str]


class RoundedVerdict(NamedTuple):
    """Published row, for comparison with another file: verdict, error and limit to four digits, and their unit."""

    verdict: str
    error: float | None
    limit: float | None
    unit: str

    @property
    def size(self) -> str:
        """Absolute error as text with two decimals, and its unit unless that is per cent; empty without error."""
        return "" if self.error is None else f"{abs(self.error):.2f}{'' if self.unit == '%' else f' {self.unit}'}"


class Change(NamedTuple):
    """Change of one published row against an earlier file."""

    #: Name of the scene or check.
    scene: str
    #: Name of the quantity.
    quantity: str
    #: Earlier row; None if it is new.
    before: RoundedVerdict | None
    #: Present row; None if it was removed.
    after: RoundedVerdict | None

    def as_json(self) -> dict[str, Any]:
        """Return the change as JSON: scene, quantity, verdict and error before and after, and the limit."""
        rows = self.before, self.after
        limits = [cell_text(row.limit, row.unit) for row in reversed(rows) if row is not None and row.limit is not None]
        return {
            "scene": self.scene,
            "quantity": self.quantity,
            "verdict": [row and row.verdict for row in rows],
            "error": [row and row.size for row in rows],
            "limit": limits[0] if limits else "",
        }

    def line(self) -> str:
        """Return the change as a line of text.

        Such as ``two-balls: largest error of a contact load 5.10 -> 6.80 %, limit 7, pass -> undecided``.
        """
        head, before, after = f"{self.scene}: {self.quantity}", self.before, self.after
        if after is None:
            return f"{head}: no more, {before.verdict if before else ''}"
        if before is None:
            return f"{head}: new, {after.verdict}"
        sizes = " -> ".join(dict.fromkeys(row.size or "no error" for row in (before, after)))
        unit, limit = " %" if after.unit == "%" else "", self.as_json()["limit"]
        words = f", {before.verdict} -> {after.verdict}" if before.verdict != after.verdict else ""
        return f"{head} {sizes}{unit}{f', limit {limit}' if limit else ''}{words}"


def changes_against_file(path: Path, outcomes: Sequence[Outcome]) -> list[Change]:
    """Return the changes of verdict or error against an earlier file, including new and removed rows.

    Parameters
    ----------
    path
        Earlier file, CSV or JSON.
    outcomes
        Present rows.

    Returns
    -------
    list of Change
        The changes.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    before, after = _read_earlier_verdicts(path), dict(map(_labelled_verdict, outcomes))
    pairs = {label: (before.get(label), after.get(label)) for label in (*before, *after)}
    return [Change(*label, old, new) for label, (old, new) in pairs.items() if _compared_part(old) != _compared_part(new)]


def _compared_part(row: RoundedVerdict | None) -> tuple[str, str] | None:
    """Return the part of a row that decides whether it changed: verdict and error with two decimals."""
    return None if row is None else (row.verdict, row.size)


def _rounded_verdict(verdict: str, error: float | None, limit: float | None, unit: str) -> RoundedVerdict:
    """Return a row with error and limit rounded to four digits, as they are published."""
    error, limit = (None if x is None else float(f"{x:.4g}") for x in (error, limit))
    return RoundedVerdict(verdict, error, limit, unit)


def _labelled_verdict(o: Outcome) -> tuple[Label, RoundedVerdict]:
    """Return label and rounded row of a present outcome."""
    return (one_line(o.scene, 2000), one_line(o.quantity, 2000)), _rounded_verdict(o.word, o.error, o.limit, o.unit)


def _read_earlier_verdicts(path: Path) -> dict[Label, RoundedVerdict]:
    """Return the rows of an earlier file of verdicts, CSV or JSON, by label; InputError for anything else."""
    text = read_table(path)
    try:
        return dict(
            map(_verdict_from_json, _verdicts_in_json(json.loads(text)))
            if text.lstrip().startswith("{")
            else _verdicts_in_csv(text)
        )
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        advice = "keep one of an earlier run: check with `csv=gate.csv`"
        raise InputError(str(path), "file", "something else", "verdicts that check wrote as CSV or JSON", advice) from None


def _verdicts_in_csv(text: str) -> Iterator[tuple[Label, RoundedVerdict]]:
    """Yield label and row for each line of a CSV text; ValueError for other headings."""
    headings, *rows = csv.reader(text.splitlines())
    if tuple(headings) != HEADINGS:
        raise ValueError(headings)
    for row in rows:
        cells = dict(zip(HEADINGS, row, strict=True))
        (error, unit), (limit, other) = _number_and_unit(cells["error %"]), _number_and_unit(cells["limit %"])
        label = cells["scene or check"], cells["quantity"]
        yield label, _rounded_verdict(cells["verdict"], error, limit, unit or other or "%")


def _number_and_unit(cell: str) -> tuple[float | None, str]:
    """Return number (None if empty) and unit of a cell that `cell_text` wrote."""
    number, _, unit = cell.partition(" ")
    return float(number) if number else None, unit


def _verdicts_in_json(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the verdicts of scenes, or the checks of the gate, in the JSON of ``rollbench check``."""
    return list(data["verdicts"] if "verdicts" in data else data["rows"])


def _verdict_from_json(row: Mapping[str, Any]) -> tuple[Label, RoundedVerdict]:
    """Return label and row from the JSON of a verdict; the ending of the limit's key gives the unit."""
    if "kind" in row:
        label, verdict = (row["name"], row["kind"]), row["verdict"]
    else:
        case = f"case {row['case']}" if "case" in row else None
        label, verdict = (judged_subject(row["scene"], case, row.get("set")), row["quantity"]), row["word"]
    endings = [key.removeprefix("limit_") for key in row if key.startswith("limit_") and row[key] is not None]
    unit = next(iter(endings), "percent")
    error, limit = row.get(f"error_{unit}"), row.get(f"limit_{unit}")
    return label, _rounded_verdict(verdict, error, limit, "%" if unit == "percent" else unit)
