"""``rollbench verify``: recomputes the hashes of a page or report, and lists changes between two of them."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, InputError, escape_unprintable
from rollbench.compare.measure import error_percent
from rollbench.compare.provenance import SCENE, SOURCES, inputs, sources_hash
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report.several import INDEX, make_pages
from rollbench.compare.scenes import catalogue
from rollbench.compare.text.printing import Answer
from rollbench.reports.manifest import FILE, file_hashes, page_text, read_manifest, sha256
from rollbench.reports.scene_page import read_page, results_hash, without_manifest

#: Change [%] of a number up to which it is round-off, between pages and (or what a solver's tolerance leaves) reports.
ROUND_OFF, SAME = 1e-6, 1e-3
#: Units of measured numbers, which differ from run to run.
MEASURED = ("[s]", "[ms]", "[µs]", "[MB]")
#: Largest number of changes that are listed for a table.
MOST = 6

Tables = Mapping[str, list[dict[str, str]]]


def read_tables(report: Path) -> Tables:
    """Return all tables of a report by name, from its CSV files; InputError for a folder that is no report."""
    if not (report / "index.html").is_file() or not (report / "tables").is_dir():
        advice = "reports are written by: rollbench report"
        raise ArgumentError("against", "no report", "the folder of a report", advice, str(report))
    by_name = {}
    for path in sorted((report / "tables").glob("*.csv")):
        with open(path, encoding="utf-8", newline="") as stream:
            by_name[path.stem] = list(csv.DictReader(stream))
        damaged = next((k for k, row in enumerate(by_name[path.stem]) if None in (*row, *row.values())), None)
        if damaged is not None:
            allowed = "a cell for each heading"
            raise InputError(str(path), f"row {damaged + 1}", "another number", allowed, "write the report again")
    return by_name


def moved_tables(old: Tables, new: Tables) -> Iterator[str]:
    """Yield a line for each difference between the tables of two reports.

    Rows are matched by their texts, else by their position; measured seconds and memory are left out.
    """
    for name in dict.fromkeys((*old, *new)):
        if name not in old or name not in new:
            yield f"{name}: {'new table' if name not in old else 'no longer there'}"
            continue
        lines = list(_table_differences(old[name], new[name]))
        yield from (f"{name}: {line}" for line in lines[:MOST])
        if len(lines) > MOST:
            yield f"{name}: and {len(lines) - MOST} more"


def _table_differences(old: Sequence[dict[str, str]], new: Sequence[dict[str, str]]) -> Iterator[str]:
    """Yield a line for each difference between two tables."""
    before, after = _rows_by_text(old), _rows_by_text(new)
    if before.keys() != after.keys() and len(old) == len(new):
        before, after = ({f"row {k + 1}": row for k, row in enumerate(rows)} for rows in (old, new))
    for key in dict.fromkeys((*before, *after)):
        if key not in before or key not in after:
            yield f"{key}: {'new row' if key not in before else 'row no longer there'}"
            continue
        for column in dict.fromkeys((*before[key], *after[key])):
            if not column.endswith(MEASURED):
                yield from _cell_difference(f"{key}, {column}", before[key].get(column), after[key].get(column))


def _rows_by_text(rows: Sequence[dict[str, str]]) -> dict[str, dict[str, str]]:
    """Return rows by their text cells, numbered where those are equal."""
    by_text: dict[str, dict[str, str]] = {}
    for row in rows:
        texts = [cell for cell in row.values() if cell and _number_or_text(cell) is None]
        key = ", ".join(text if len(text) <= 40 else f"{text[:37]}..." for text in texts[:3]) or "row"
        count = sum(known == key or known.startswith(f"{key} (") for known in by_text)
        by_text[f"{key} ({count + 1})" if count else key] = row
    return by_text


def _number_or_text(text: str) -> float | None:
    with suppress(ValueError):
        return float(text)
    return None


def _cell_difference(where: str, old: str | None, new: str | None) -> Iterator[str]:
    """Yield a line if two cells differ by more than round-off."""
    if old == new:
        return
    if old is None or new is None:
        yield f"{where}: {'new column' if old is None else 'column no longer there'}"
        return
    a, b = _number_or_text(old), _number_or_text(new)
    if a is None or b is None:
        yield f"{where}: {old[:60] or 'nothing'} became {new[:60] or 'nothing'}"
        return
    change = float(error_percent(b, a)) if a else float("inf")
    if not abs(change) <= SAME and abs(b - a) > 1e-12:
        yield f"{where}: {a:.6g} became {b:.6g} ({change:+.3g} %)"


@dataclass(frozen=True)
class Checked:
    """One input or file of a page or report with its stated and its present hash."""

    #: Name.
    name: str
    #: Hash in the manifest.
    stated: str
    #: Hash now.
    found: str

    @property
    def state(self) -> str:
        """Result of the check: ok, changed, missing, or added."""
        if not self.stated:
            return "added"
        return "missing" if not self.found else "ok" if self.found == self.stated else "changed"

    @property
    def line(self) -> str:
        """Line for the terminal."""
        now = f", now {self.found[:16]}" if self.state == "changed" else ""
        return f"{self.state:8} {escape_unprintable(self.name)} {escape_unprintable(self.stated[:16])}{now}"


def report_folder(report: Path) -> Path:
    """Return the folder of a report, given by that folder or by its first page."""
    return report if report.is_dir() else report.parent


def checked_report(report: Path, stores: Sequence[Path]) -> Iterator[Checked]:
    """Yield every hash of a report's manifest with the one computed now, of its files and inputs.

    InputError for a damaged manifest.
    """
    folder = report_folder(report)
    try:
        manifest = read_manifest(folder)
    except (OSError, ValueError) as error:
        raise InputError(str(folder / FILE), "file", str(error), "a manifest", "write the report again") from None
    names = [name.removeprefix(SCENE) for name in manifest["inputs"] if name.startswith(SCENE)]
    texts = {name: catalogue.scene_text(name) for name in names if name in catalogue.scene_names()}
    files = file_hashes(folder)
    for stated, computed in ((manifest["files"], files), (manifest["inputs"], inputs(stores, texts))):
        yield from (Checked(name, value, computed.get(name, "")) for name, value in stated.items())
    yield from (Checked(name, "", files[name]) for name in files.keys() - manifest["files"].keys())


def read_first_page(report: Path) -> tuple[str, dict[str, Any]]:
    """Return text and data blocks of a page, or of the first one of a folder; InputError for another file."""
    path = report / "index.html" if report.is_dir() else report
    try:
        html = page_text(path)
        return html, read_page(html)
    except (OSError, ValueError) as error:
        advice = "pages with a manifest are written by: rollbench report SCENE"
        raise InputError(str(path), "file", str(error), "a page with a manifest", advice) from None


def checked_page(html: str, blocks: dict[str, Any], stores: Sequence[Path]) -> Iterator[Checked]:
    """Yield every hash of a page's manifest with the present one: page, scene, results, sources, stored runs."""
    manifest = blocks["manifest"]
    carried = {
        "page": sha256(without_manifest(html)),
        "scene": sha256(blocks["scene"]),
        "results": results_hash(blocks["results"]),
    }
    yield from (Checked(name, str(manifest.get(name) or "none"), computed) for name, computed in carried.items())
    for name, stated in dict(manifest.get("files", {})).items():
        paths = [p for store in stores if (p := store / Path(name).name).is_file()]
        yield Checked(name, stated, sources_hash() if name == SOURCES else sha256(paths[0].read_bytes()) if paths else "")


def run_verify(report: Path, store: Path) -> Answer:
    """Check every hash; exit code 1 if one differs. Raises InputError for a file without manifest."""
    stores = (store, shipped_store(), report_folder(report))  # the last one: pages of several scenes
    whole = (report_folder(report) / FILE).is_file()
    rows = list(checked_report(report, stores) if whole else checked_page(*read_first_page(report), stores))
    shown = [row for row in rows if not whole or row.state != "ok"]  # a whole report has hundreds
    wrong = sum(row.state != "ok" for row in rows)
    count = f"{len(rows) - wrong} of {len(rows)} hashes hold: {'the same inputs and code' if not wrong else 'see above'}"
    return Answer(parts=[*(row.line for row in shown), count], code=1 if wrong else 0)


def run_pages(
    scenes: Sequence[str], out: Path, store: Path, against: Path | None = None, reference: Path | None = None
) -> Answer:
    """Write the page of a scene, or of several with a table, and list changes against an earlier page of one scene.

    Exit code 1 if a load case did not converge. InputError as `make_pages`, `read_page`.
    """
    before = None if against is None else read_first_page(against)[1]
    pages = make_pages(scenes, out, store, reference)
    parts = []
    for name, page in zip(scenes, pages, strict=True):
        said = f"{name}: " if len(pages) > 1 else ""
        parts += [*(f"WARNING: {said}{warning}" for warning in page.warnings), f"{said}{page.verdict}"]
    parts.append(f"page: {out / INDEX}")
    if before is not None:
        after = read_first_page(out)[1]
        lines = [
            *result_differences(_manifest_inputs(before["manifest"]), _manifest_inputs(after["manifest"])),
            *result_differences(_results_without_times(before["results"]), _results_without_times(after["results"])),
        ]
        parts += lines or ["nothing moved"]
    return Answer(parts=parts, code=int(any(page.results["status"] != "converged" for page in pages)))


def _manifest_inputs(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return a manifest without what differs in every run: date, hashes of page and results."""
    kept = {key: value for key, value in manifest.items() if key not in ("page", "results")}
    return kept | {"provenance": {k: v for k, v in manifest["provenance"].items() if k != "date"}}


def _results_without_times(results: dict[str, Any]) -> dict[str, Any]:
    """Return results without the solver's report, which has run times."""
    kept = {key: value for key, value in results.items() if key != "solver"}
    return kept | ({"cases": [_results_without_times(one) for one in results["cases"]]} if "cases" in results else {})


def result_differences(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Yield a line for each difference between two results; numbers count if they differ beyond round-off."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys((*old, *new)):
            yield from result_differences(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from result_differences(a, b, f"{path}[{k + 1}]")
    elif _number_or_none(old) and _number_or_none(new):
        change = float(error_percent(new, old)) if old else float("inf") if new else 0.0
        if abs(change) > ROUND_OFF:
            yield f"{path}: {old:.6g} became {new:.6g} ({change:+.3g} %)"
    elif old != new:
        yield f"{path}: {_shorten(old)} became {_shorten(new)}"


def _number_or_none(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shorten(value: Any) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= 60 else text[:57] + "..."
