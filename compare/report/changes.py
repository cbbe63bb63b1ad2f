"""Changes between two reports, or between two pages of a scene, as lines of text."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.compare.measure import error_percent
from rollbench.compare.report.several import INDEX, write_scene_pages
from rollbench.compare.text.printing import CommandOutput
from rollbench.reports.manifest import read_report_file
from rollbench.reports.scene_html import read_page_data

#: Relative changes of a number [%] that are ignored: between two pages as round-off, between two reports as solver
#: tolerance.
ROUND_OFF, SAME = 1e-6, 1e-3
#: Units of measured run times and memory, which differ from run to run.
MEASURED = ("[s]", "[ms]", "[µs]", "[MB]")
#: Largest number of changed cells listed for each table.
MOST = 6

#: Tables of a report by name: their rows, each with the text of every cell by the heading of its column.
Tables = Mapping[str, list[dict[str, str]]]


def read_report_tables(folder: Path) -> Tables:
    """Read all tables of a report from its CSV files, and return their rows by name of the table.

    ``folder``: folder of the report. A row has the text of each cell by the heading of its column. Raises
    InputError for a folder that does not contain a report, or a damaged file.
    """
    if not (folder / "index.html").is_file() or not (folder / "tables").is_dir():
        advice = "write a report to compare with: rollbench report"
        raise ArgumentError("against", "a folder without a report", "the folder of a report", advice, str(folder))
    by_name = {}
    for path in sorted((folder / "tables").glob("*.csv")):
        with open(path, encoding="utf-8", newline="") as stream:
            by_name[path.stem] = list(csv.DictReader(stream))
        damaged = next((k for k, row in enumerate(by_name[path.stem]) if None in (*row, *row.values())), None)
        if damaged is not None:
            value, allowed = "more or fewer cells than columns", "one cell for each column heading"
            raise InputError(str(path), f"row {damaged + 1}", value, allowed, "write the report again")
    return by_name


def report_differences(old: Tables, new: Tables) -> Iterator[str]:
    """Yield a line of text for each difference between the tables of an old and a new report.

    ``old``, ``new``: rows of each table, by name of the table. Rows are matched by the texts of their cells, or by their
    position if the texts differ. Measured run times and memory are not compared.
    """
    for name in dict.fromkeys((*old, *new)):
        if name not in old or name not in new:
            yield f"{name}: {'new table' if name not in old else 'table removed'}"
            continue
        lines = list(_table_differences(old[name], new[name]))
        yield from (f"{name}: {line}" for line in lines[:MOST])
        if len(lines) > MOST:
            yield f"{name}: and {len(lines) - MOST} more"


def _table_differences(old: Sequence[dict[str, str]], new: Sequence[dict[str, str]]) -> Iterator[str]:
    """Yield a line of text for each difference between the old and the new version of a table.

    ``old``, ``new``: rows of the table, with the text of each cell by the heading of its column.
    """
    before, after = _rows_by_text(old), _rows_by_text(new)
    if before.keys() != after.keys() and len(old) == len(new):
        before, after = ({f"row {k + 1}": row for k, row in enumerate(rows)} for rows in (old, new))
    for key in dict.fromkeys((*before, *after)):
        if key not in before or key not in after:
            yield f"{key}: {'new row' if key not in before else 'row removed'}"
            continue
        for column in dict.fromkeys((*before[key], *after[key])):
            if not column.endswith(MEASURED):
                yield from _cell_difference(f"{key}, {column}", before[key].get(column), after[key].get(column))


def _rows_by_text(rows: Sequence[dict[str, str]]) -> dict[str, dict[str, str]]:
    """Return the rows of a table by a key that consists of a row's first three cells with text; equal keys are numbered."""
    by_text: dict[str, dict[str, str]] = {}
    for row in rows:
        texts = [cell for cell in row.values() if cell and _number_in_cell(cell) is None]
        key = ", ".join(text if len(text) <= 40 else f"{text[:37]}..." for text in texts[:3]) or "row"
        count = sum(known == key or known.startswith(f"{key} (") for known in by_text)
        by_text[f"{key} ({count + 1})" if count else key] = row
    return by_text


def _number_in_cell(text: str) -> float | None:
    """Return the number in a table cell; None if the cell contains text."""
    with suppress(ValueError):
        return float(text)
    return None


def _cell_difference(row_and_column: str, old: str | None, new: str | None) -> Iterator[str]:
    """Yield a line of text if a cell has changed; numbers count as changed beyond the tolerance `SAME`.

    ``row_and_column``: row and column of the cell, for the line. A text of None means that the column does not exist.
    """
    if old == new:
        return
    if old is None or new is None:
        yield f"{row_and_column}: {'new column' if old is None else 'column removed'}"
        return
    a, b = _number_in_cell(old), _number_in_cell(new)
    if a is None or b is None:
        yield f"{row_and_column}: {old[:60] or 'nothing'} became {new[:60] or 'nothing'}"
        return
    change = float(error_percent(b, a)) if a else float("inf")
    if not abs(change) <= SAME and abs(b - a) > 1e-12:
        yield f"{row_and_column}: {a:.6g} became {b:.6g} ({change:+.3g} %)"


def read_scene_page(report: Path) -> dict[str, Any]:
    """Return the data that a page contains that `rollbench report SCENE` wrote.

    ``report``: path of the page or of its folder. The data are manifest, scene file and results, by the names "manifest",
    "scene" and "results". Raises InputError for a file that is no such page.
    """
    path = report / "index.html" if report.is_dir() else report
    try:
        return read_page_data(read_report_file(path))
    except (OSError, ValueError) as error:
        advice = "write a page with a manifest: rollbench report SCENE"
        raise InputError(str(path), "file", f"an unusable file: {error}", "a page with a manifest", advice) from None


def write_and_compare_pages(
    scenes: Sequence[str], out: Path, store: Path, against: Path | None = None, reference: Path | None = None
) -> CommandOutput:
    """Write the result page of one scene, or pages of several scenes with a table of all; list changes from an old page.

    Parameters
    ----------
    scenes
        Names or files of the scenes.
    out
        Folder in which the pages are written.
    store
        Folder with stored runs of the 3D reference.
    against
        Earlier page of the scene, of which changes are listed; None: no comparison.
    reference
        CSV file with contact loads that replaces the 3D reference.

    Returns
    -------
    CommandOutput
        Lines for the terminal, and the exit code: 1 if a load case did not converge.

    Raises
    ------
    InputError
        If a scene, the earlier page or the file of loads cannot be used.
    """
    before = None if against is None else read_scene_page(against)
    pages = write_scene_pages(scenes, out, store, reference)
    parts = []
    for name, page in zip(scenes, pages, strict=True):
        said = f"{name}: " if len(pages) > 1 else ""
        parts += [*(f"WARNING: {said}{warning}" for warning in page.warnings), f"{said}{page.verdict}"]
    parts.append(f"page: {out / INDEX}")
    if before is not None:
        after = read_scene_page(out)
        compared = {"manifest": _manifest_without_date, "results": _results_without_solver_report}
        lines = [line for key, kept in compared.items() for line in result_differences(kept(before[key]), kept(after[key]))]
        parts += lines or ["nothing changed"]
    return CommandOutput(
        texts_and_tables=parts, exit_code=int(any(page.results["status"] != "converged" for page in pages))
    )


def _manifest_without_date(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return a page's manifest without the date, which changes in every run."""
    return manifest | {"provenance": {k: v for k, v in manifest["provenance"].items() if k != "date"}}


def _results_without_solver_report(results: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON results of a scene without the entries on the solver, which contain run times."""
    kept = {key: value for key, value in results.items() if key != "solver"}
    if "cases" in results:
        kept["cases"] = [_results_without_solver_report(one) for one in results["cases"]]
    return kept


def result_differences(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Yield a line of text for each difference between old and new JSON results; differences by round-off are ignored.

    ``path``: keys that lead to the compared values, joined by dots; the lines begin with it.
    """
    if isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys((*old, *new)):
            yield from result_differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from result_differences(a, b, f"{path}[{k + 1}]")
    elif _is_number(old) and _is_number(new):
        change = float(error_percent(new, old)) if old else float("inf") if new else 0.0
        if abs(change) > ROUND_OFF:
            yield f"{path}: {old:.6g} became {new:.6g} ({change:+.3g} %)"
    elif old != new:
        yield f"{path}: {_shortened_json_text(old)} became {_shortened_json_text(new)}"


def _is_number(value: Any) -> bool:
    """Return whether a JSON value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shortened_json_text(value: Any) -> str:
    """Return a JSON value as text of at most 60 characters."""
    text = "nothing" if value is None else str(value)
    return text if len(text) <= 60 else text[:57] + "..."
