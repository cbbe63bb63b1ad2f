"""Writing of verdicts on scenes to files: JUnit XML for test servers, Markdown for summaries, CSV for spreadsheets.

The module also lists the verdicts that changed since an earlier file of ``rollbench check --csv`` or ``--json``.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias
from xml.etree import ElementTree

from rollbench.compare.errors import InputError, one_line
from rollbench.compare.files import read_text_file, reason_without_figure, replace_file, write_figure, written_together
from rollbench.compare.gate.verdict import VerdictRow, subject_text
from rollbench.compare.models.loads_file import MAX_BYTES
from rollbench.reports.cells import escape_formula

if TYPE_CHECKING:
    from rollbench.compare.gate.gate import GateCheck
    from rollbench.reports.content import Figure


#: What a row of verdicts in a file is made of: the verdict on a user's scene, or a check of the shipped data.
Outcome: TypeAlias = "VerdictRow | GateCheck"

#: Environment variable by which a continuous-integration service passes the path of a job's summary file.
SUMMARY = "GITHUB_STEP_SUMMARY"

#: Column headings of the table of verdicts in CSV and Markdown files.
NUMBERS = ("error %", "uncertainty %", "limit %")
HEADINGS = ("verdict", "scene or check", "judged", "quantity", *NUMBERS, "ball", "flank", "note")


def number_cell_text(value: float | None, unit: str) -> str:
    """Return a number as text with four digits for a table cell, with its unit unless that is per cent; "" for None."""
    return "" if value is None else f"{value:.4g}{'' if unit == '%' else f' {unit}'}"


def outcome_cells(o: Outcome) -> tuple[str, ...]:
    """Return the texts of a row of the table of verdicts, in the order of `HEADINGS`; numbers without unit are per cent."""
    numbers = (number_cell_text(x, o.unit) for x in (o.error, o.uncertainty, o.limit))
    ball = "" if o.ball is None else str(o.ball)
    cells = (str(o.judgement), o.subject, o.judged, o.quantity, *numbers, ball, o.side or "", o.note)
    return tuple(one_line(cell, 2000) for cell in cells)


def outcome_text(o: Outcome) -> str:
    """Return a row without its verdict as one line of text: "heading: cell" for each cell that is not empty."""
    return "; ".join(f"{head}: {cell}" for head, cell in zip(HEADINGS[1:], outcome_cells(o)[1:], strict=True) if cell)


def junit_xml(outcomes: Sequence[Outcome], notes: Sequence[str] = ()) -> str:
    """Return rows of verdicts as JUnit XML: a test case for each row, and the notes as properties.

    ``outcomes``: rows of verdicts; ``notes``: notes on the whole table. A row that did not pass is a failure, whose type is
    its verdict.
    """
    bad = [o for o in outcomes if not o.passed]
    counts = {"tests": str(len(outcomes)), "failures": str(len(bad)), "errors": "0", "skipped": "0"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": "rollbench check"} | counts)
    if notes:
        properties = ElementTree.SubElement(suite, "properties")
        for note in notes:
            ElementTree.SubElement(properties, "property", {"name": "note", "value": note})
    for o in outcomes:
        cells, words = outcome_cells(o), outcome_text(o)
        name = ", ".join(cell for cell in cells[1:4] if cell)
        case = ElementTree.SubElement(suite, "testcase", {"classname": f"rollbench.{cells[1]}", "name": name})
        if o.passed:
            ElementTree.SubElement(case, "system-out").text = f"{o.judgement}; {words}"
        else:
            ElementTree.SubElement(case, "failure", {"type": o.judgement, "message": words}).text = words
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def markdown_text(outcomes: Sequence[Outcome], notes: Sequence[str] = ()) -> str:
    """Return rows of verdicts as Markdown: counts, notes, a table, and a chart of loads around the ball of largest error.

    ``outcomes``: rows of verdicts, of which those that did not pass come first; ``notes``: notes on the whole table. The
    chart is written in Mermaid, which GitHub, GitLab, Forgejo and Gitea draw, because a comment there cannot contain an
    image file.
    """
    counts: dict[str, int] = {}
    for o in outcomes:
        counts[o.judgement] = counts.get(o.judgement, 0) + 1
    head = ", ".join(f"{n} {word}" for word, n in counts.items())
    lines = [f"### rollbench check: {head}", *(f"- {_escape_markup(note)}" for note in notes), ""]
    lines += [_table_line(HEADINGS), _table_line(["---"] * len(HEADINGS))]
    lines += [_table_line(outcome_cells(o)) for o in sorted(outcomes, key=lambda o: o.passed)]
    return "\n".join([*lines, *_load_chart_lines(row_for_load_chart(outcomes))]) + "\n"


def row_for_load_chart(outcomes: Sequence[Outcome]) -> Outcome | None:
    """Return the row of verdicts whose contact is drawn in the chart: largest error among failed rows, else among all.

    Only rows with loads of the balls around the judged contact count. None if there is no such row.
    """
    shown = [o for o in outcomes if o.near]
    return min(shown, key=lambda o: (o.passed, -abs(o.error or 0.0)), default=None)


def _chart_title(o: Outcome) -> str:
    """Return the title of the chart of contact loads around a ball: scene, ball, error and limit of the row ``o``."""
    name = one_line(o.subject, 2000).replace('"', "'")
    return f"{name}, ball {o.ball} {o.side}: error {abs(o.error or 0.0):.2f} {o.unit}, limit {o.limit:.4g} {o.unit}"


def _load_chart_lines(o: Outcome | None) -> list[str]:
    """Return Markdown lines of a Mermaid chart of the contact loads around a ball; no lines if ``o`` is None.

    ``o``: row of verdicts whose ball is drawn.
    """
    if o is None:
        return []
    balls, loads, reference, _ = zip(*o.near, strict=True)
    top = 1.1 * max(*loads, *reference)
    series = [", ".join(f"{x:.4g}" for x in of) for of in (reference, loads)]
    return [
        "",
        f"Contact loads around the ball with the largest error: bars show the reference, the line shows "
        f"{_escape_markup(o.judged)}.",
        "",
        "```mermaid",
        "xychart-beta",
        f'    title "{_chart_title(o)}"',
        f'    x-axis "number of the ball" [{", ".join(map(str, balls))}]',
        f'    y-axis "contact load / N" 0 --> {top:.4g}',
        f"    bar [{series[0]}]",
        f"    line [{series[1]}]",
        "```",
    ]


def worst_ball_figure(o: Outcome) -> Figure:
    """Return a figure of judged and reference contact loads around the ball that determines the verdict of row ``o``."""
    from rollbench.reports.content import Figure, Panel, Series

    balls, loads, reference, bars = (list(x) for x in zip(*o.near, strict=True))
    low, high = ([r + sign * b for r, b in zip(reference, bars, strict=True)] for sign in (-1.0, 1.0))
    series = (
        Series("reference", balls, reference, "markers", bold=True, error_bars=(low, high)),
        Series(o.judged, balls, loads, "line+markers"),
    )
    panel = Panel(
        f"contacts on flank {o.side}", "number_of_ball", "contact_load", series, include_zero=True, integer_x=True
    )
    return Figure("worst-ball", _chart_title(o), (panel,))


def _table_line(cells: Sequence[str]) -> str:
    """Return the texts of cells as one row of a Markdown table."""
    return f"| {' | '.join(map(_escape_markup, cells))} |"


#: Characters that are markup in Markdown; an underscore is none inside a word, ">" only at the start.
_MARKUP = re.compile(r"[\\`*\[\]<|~$&]|\A>|(?<![^\W_])_|_(?![^\W_])")
#: What GitHub, GitLab, Gitea or Forgejo turn into links, even where it is escaped: mentions of people, references to
#: issues and the like, addresses.
_LINKING = re.compile(r"[@#!~%$&](?=\w)|\bGH-(?=\d)|\bwww(?=\.)|\b(?:https?|ftp):(?=//)", re.IGNORECASE)
#: Character without width, which ends no line and takes part in no link.
_JOINER = "\u2060"


def _escape_markup(text: str) -> str:
    """Return a text as Markdown that shows it as it is, also in a table: no markup, link, mention or reference."""
    plain = _LINKING.sub(lambda found: found[0] + _JOINER, text)
    return _MARKUP.sub(lambda found: {"<": "&lt;", "&": "&amp;"}.get(found[0], f"\\{found[0]}"), plain)


def verdicts_csv(outcomes: Sequence[Outcome]) -> str:
    """Return rows of verdicts as CSV text, with a line of column headings."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(HEADINGS)
    writer.writerows([escape_formula(cell) for cell in outcome_cells(o)] for o in outcomes)
    return text.getvalue()


@written_together()
def write_verdicts(
    outcomes: Sequence[Outcome],
    notes: Sequence[str] = (),
    *,
    junit_file: Path | None = None,
    markdown_file: Path | None = None,
    csv_file: Path | None = None,
) -> list[Path]:
    """Write rows of verdicts to files, and append the Markdown text to the summary of a continuous-integration job.

    A figure of the loads around the ball with the largest error is written as SVG next to the Markdown file.

    Parameters
    ----------
    outcomes
        Rows of verdicts.
    notes
        Notes that apply to the whole table.
    junit_file, markdown_file, csv_file
        Path of the file of each format; None: this format is not written.

    Returns
    -------
    list[Path]
        Paths of the files that were written.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    written = []
    texts = ((junit_file, junit_xml), (markdown_file, markdown_text), (csv_file, lambda rows, _: verdicts_csv(rows)))
    for file, text_of in texts:
        if file is not None:
            replace_file(file, text_of(outcomes, notes))
            written.append(file)
    shown = row_for_load_chart(outcomes)
    if markdown_file is not None and shown is not None and not reason_without_figure():
        written.append(markdown_file.with_suffix(".svg"))
        write_figure(written[-1], worst_ball_figure(shown))
    if markdown_file is not None and (summary := os.environ.get(SUMMARY)):
        written.append(_append_to_file(Path(summary), markdown_text(outcomes, notes)))
    return written


def _append_to_file(path: Path, text: str) -> Path:
    """Append a text to a file and return its path; InputError if it cannot be written."""
    try:
        with open(path, "a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        reason = error.strerror or str(error)
        advice = f"check the path in the environment variable {SUMMARY}"
        raise InputError(str(path), "summary", reason, "a file that can be written", advice) from None
    return path


#: Names that identify a row of verdicts: of the scene or check, and of the quantity.
Label = tuple[str, str]


class RoundedVerdict(NamedTuple):
    """Verdict with error and limit as texts, for comparison with an earlier file."""

    #: Verdict as text, such as "pass".
    verdict: str
    #: Absolute error with two decimals, with its unit unless per cent; empty if there is none.
    error: str
    #: Limit of the error with four digits, with its unit unless per cent; empty if there is none.
    limit: str
    #: Unit of error and limit.
    unit: str


class VerdictChange(NamedTuple):
    """Change of one verdict since an earlier file of verdicts."""

    #: Name of the scene or check.
    scene: str
    #: Name of the quantity.
    quantity: str
    #: Verdict in the earlier file; None if the file has none on this quantity.
    before: RoundedVerdict | None
    #: Present verdict; None if this quantity is no longer judged.
    after: RoundedVerdict | None

    @property
    def limit(self) -> str:
        """Present limit with its unit as text, else the earlier one; empty if there is none."""
        return next((row.limit for row in (self.after, self.before) if row and row.limit), "")

    def as_json(self) -> dict[str, Any]:
        """Return the change as a dictionary for JSON: scene, quantity, verdict and error before and after, limit."""
        rows = self.before, self.after
        return {
            "scene": self.scene,
            "quantity": self.quantity,
            "verdict": [row and row.verdict for row in rows],
            "error": [row and row.error for row in rows],
            "limit": self.limit,
        }

    def line(self) -> str:
        """Return the change as one line of text.

        For example ``two-balls: largest error of a contact load 5.10 -> 6.80 %, limit 7, pass -> undecided``.
        """
        head, before, after = f"{self.scene}: {self.quantity}", self.before, self.after
        if after is None:
            return f"{head}: removed, was {before.verdict if before else ''}"
        if before is None:
            return f"{head}: new, {after.verdict}"
        sizes = " -> ".join(dict.fromkeys(row.error or "no error" for row in (before, after)))
        unit = " %" if after.unit == "%" else ""
        words = f", {before.verdict} -> {after.verdict}" if before.verdict != after.verdict else ""
        return f"{head} {sizes}{unit}{f', limit {self.limit}' if self.limit else ''}{words}"


def verdict_changes_since_file(path: Path, outcomes: Sequence[Outcome]) -> list[VerdictChange]:
    """Return the changes of verdicts since an earlier file: other verdict or error, new rows, removed rows.

    Parameters
    ----------
    path
        Earlier file of verdicts, CSV or JSON.
    outcomes
        Present rows of verdicts.

    Returns
    -------
    list[VerdictChange]
        Earlier and present verdict of each row that changed.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    before = _read_earlier_verdicts(path)
    after = {
        (one_line(o.subject, 2000), one_line(o.quantity, 2000)): _rounded_verdict(
            str(o.judgement), o.error, o.limit, o.unit
        )
        for o in outcomes
    }
    pairs = {label: (before.get(label), after.get(label)) for label in (*before, *after)}
    return [
        VerdictChange(*label, old, new) for label, (old, new) in pairs.items() if (old and old[:2]) != (new and new[:2])
    ]


def _rounded_verdict(verdict: str, error: float | None, limit: float | None, unit: str) -> RoundedVerdict:
    """Return a verdict with its error and limit as texts, first rounded to four digits as in the files of verdicts."""
    size = "" if error is None else f"{abs(float(f'{error:.4g}')):.2f}{'' if unit == '%' else f' {unit}'}"
    return RoundedVerdict(verdict, size, number_cell_text(limit, unit), unit)


def _read_earlier_verdicts(path: Path) -> dict[Label, RoundedVerdict]:
    """Read an earlier file of verdicts (CSV or JSON) and return its verdicts by scene and quantity.

    Raises InputError for a file that does not contain verdicts.
    """
    text = read_text_file(path, "CSV file", MAX_BYTES)
    try:
        if not text.lstrip().startswith("{"):
            return dict(_verdicts_in_csv(text))
        data = json.loads(text)
        return dict(map(_verdict_from_json, data["verdicts"] if "verdicts" in data else data["rows"]))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        value, advice = "a file without verdicts", "write a file of verdicts with `csv=gate.csv` and compare with that"
        raise InputError(str(path), "file", value, "a CSV or JSON file written by rollbench check", advice) from None


def _verdicts_in_csv(text: str) -> Iterator[tuple[Label, RoundedVerdict]]:
    """Yield the names of scene and quantity, and the verdict, of each line of a CSV text; ValueError for other headings."""
    headings, *rows = csv.reader(text.splitlines())
    if tuple(headings) != HEADINGS:
        raise ValueError(headings)
    for row in rows:
        cells = dict(zip(HEADINGS, row, strict=True))
        (error, unit), (limit, other) = _number_and_unit(cells["error %"]), _number_and_unit(cells["limit %"])
        label = cells["scene or check"], cells["quantity"]
        yield label, _rounded_verdict(cells["verdict"], error, limit, unit or other or "%")


def _number_and_unit(cell: str) -> tuple[float | None, str]:
    """Split a table cell written by `number_cell_text` into its number (None if the cell is empty) and its unit."""
    number, _, unit = cell.partition(" ")
    return float(number) if number else None, unit


def _verdict_from_json(row: Mapping[str, Any]) -> tuple[Label, RoundedVerdict]:
    """Return the names of scene and quantity, and the verdict, of one JSON record of ``rollbench check``.

    The unit of error and limit is the ending of their keys.
    """
    if "kind" in row:
        label, verdict = (row["name"], row["kind"]), row["verdict"]
    else:
        case = f"case {row['case']}" if "case" in row else None
        label, verdict = (subject_text(row["scene"], case, row.get("set")), row["quantity"]), row["word"]
    endings = [key.removeprefix("limit_") for key in row if key.startswith("limit_") and row[key] is not None]
    unit = next(iter(endings), "percent")
    error, limit = row.get(f"error_{unit}"), row.get(f"limit_{unit}")
    return label, _rounded_verdict(verdict, error, limit, "%" if unit == "percent" else unit)
