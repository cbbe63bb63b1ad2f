"""``rollbench verify``: compare the hashes of a report's files and inputs with the hashes in its manifest.

The module also lists the changes between two reports or between two pages.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, InputError, escape_unprintable
from rollbench.compare.measure import error_percent
from rollbench.compare.provenance import SCENE, SOURCES, hashes_of_report_inputs, sources_hash
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.several import INDEX, write_scene_pages
from rollbench.compare.scenes import catalogue
from rollbench.compare.text.printing import CommandOutput
from rollbench.reports.manifest import FILE, hashes_of_report_files, read_manifest, read_report_file, sha256
from rollbench.reports.scene_page import html_without_manifest, read_page_data, results_hash

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


@dataclass(frozen=True)
class HashCheck:
    """SHA-256 of one input or file of a report, as its manifest states it and as computed now."""

    #: Name of the input or file in the manifest.
    name: str
    #: Hash in the manifest; empty: the manifest does not name the file.
    hash_in_manifest: str
    #: Hash computed now; empty: the file is missing.
    hash_now: str

    @property
    def comparison_result(self) -> str:
        """Result of the comparison: "ok", "changed", "missing" or "added"."""
        if not self.hash_in_manifest:
            return "added"
        return "missing" if not self.hash_now else "ok" if self.hash_now == self.hash_in_manifest else "changed"

    @property
    def terminal_line(self) -> str:
        """Line for the terminal: result of the comparison, name and hash."""
        now = f", now {self.hash_now[:16]}" if self.comparison_result == "changed" else ""
        name, stated = escape_unprintable(self.name), escape_unprintable(self.hash_in_manifest[:16])
        return f"{self.comparison_result:8} {name} {stated}{now}"


def report_folder(report: Path) -> Path:
    """Return the folder of a report, given the path of this folder or of the report's first page."""
    return report if report.is_dir() else report.parent


def check_report_hashes(report: Path, stores: Sequence[Path]) -> Iterator[HashCheck]:
    """Compare every hash in a report's manifest, of its files and inputs, with the hash computed now.

    ``report``: folder or first page of the report. ``stores``: folders with runs of the 3D reference. Files that the
    manifest does not name are also yielded. Raises InputError for a damaged manifest.
    """
    folder = report_folder(report)
    try:
        manifest = read_manifest(folder)
    except (OSError, ValueError) as error:
        value = f"an unusable file: {error}"
        raise InputError(str(folder / FILE), "file", value, "a report's manifest", "write the report again") from None
    names = [name.removeprefix(SCENE) for name in manifest["inputs"] if name.startswith(SCENE)]
    texts = {name: catalogue.shipped_scene_text(name) for name in names if name in catalogue.scene_names()}
    files = hashes_of_report_files(folder)
    for stated, computed in ((manifest["files"], files), (manifest["inputs"], hashes_of_report_inputs(stores, texts))):
        yield from (HashCheck(name, value, computed.get(name, "")) for name, value in stated.items())
    yield from (HashCheck(name, "", files[name]) for name in files.keys() - manifest["files"].keys())


def read_scene_page(report: Path) -> tuple[str, dict[str, Any]]:
    """Read a page that `rollbench report SCENE` wrote: return its HTML text and the data that it contains.

    ``report``: path of the page or of its folder. The data are manifest, scene file and results, by the names "manifest",
    "scene" and "results". Raises InputError for a file that is no such page.
    """
    path = report / "index.html" if report.is_dir() else report
    try:
        html = read_report_file(path)
        return html, read_page_data(html)
    except (OSError, ValueError) as error:
        advice = "write a page with a manifest: rollbench report SCENE"
        raise InputError(str(path), "file", f"an unusable file: {error}", "a page with a manifest", advice) from None


def check_page_hashes(html: str, page_data: dict[str, Any], stores: Sequence[Path]) -> Iterator[HashCheck]:
    """Compare every hash in a page's manifest (page, scene, results, code, stored runs) with the hash computed now.

    ``html``: text of the page. ``page_data``: its manifest, scene file and results by these names. ``stores``: folders with
    runs of the 3D reference.
    """
    manifest = page_data["manifest"]
    carried = {
        "page": sha256(html_without_manifest(html)),
        "scene": sha256(page_data["scene"]),
        "results": results_hash(page_data["results"]),
    }
    yield from (HashCheck(name, str(manifest.get(name) or "none"), computed) for name, computed in carried.items())
    for name, stated in dict(manifest.get("files", {})).items():
        paths = [p for store in stores if (p := store / Path(name).name).is_file()]
        yield HashCheck(name, stated, sources_hash() if name == SOURCES else sha256(paths[0].read_bytes()) if paths else "")


def verify_report_hashes(report: Path, store: Path) -> CommandOutput:
    """Check all hashes of a report or page; return lines for the terminal and the exit code: 1 if any hash differs, else 0.

    ``report``: folder or first page of the report. ``store``: folder with runs of the 3D reference, used besides the
    shipped runs. Raises InputError for a file without manifest.
    """
    stores = (store, shipped_store(), report_folder(report))  # the last one: pages of several scenes
    whole = (report_folder(report) / FILE).is_file()
    rows = list(check_report_hashes(report, stores) if whole else check_page_hashes(*read_scene_page(report), stores))
    shown = [row for row in rows if not whole or row.comparison_result != "ok"]  # a whole report has hundreds
    wrong = sum(row.comparison_result != "ok" for row in rows)
    count = f"{len(rows) - wrong} of {len(rows)} hashes hold: {'the same inputs and code' if not wrong else 'see above'}"
    return CommandOutput(texts_and_tables=[*(row.terminal_line for row in shown), count], exit_code=1 if wrong else 0)


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
    before = None if against is None else read_scene_page(against)[1]
    pages = write_scene_pages(scenes, out, store, reference)
    parts = []
    for name, page in zip(scenes, pages, strict=True):
        said = f"{name}: " if len(pages) > 1 else ""
        parts += [*(f"WARNING: {said}{warning}" for warning in page.warnings), f"{said}{page.verdict}"]
    parts.append(f"page: {out / INDEX}")
    if before is not None:
        after = read_scene_page(out)[1]
        compared = {"manifest": _manifest_without_run_specifics, "results": _results_without_solver_report}
        lines = [line for key, kept in compared.items() for line in result_differences(kept(before[key]), kept(after[key]))]
        parts += lines or ["nothing changed"]
    return CommandOutput(
        texts_and_tables=parts, exit_code=int(any(page.results["status"] != "converged" for page in pages))
    )


def _manifest_without_run_specifics(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return a page's manifest without the entries that change in every run: date, and hashes of page and results."""
    kept = {key: value for key, value in manifest.items() if key not in ("page", "results")}
    return kept | {"provenance": {k: v for k, v in manifest["provenance"].items() if k != "date"}}


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
