"""The whole report against an earlier one, and its hashes computed again."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from rollbench.comparison.commands.reporting.checked import Checked
from rollbench.comparison.errors import InputError
from rollbench.comparison.measure import error_percent
from rollbench.comparison.provenance import SCENE, inputs
from rollbench.comparison.scenes import catalogue
from rollbench.reports.manifest import FILE, hashes, read_manifest

#: Change [%] of a number up to which it is round-off, or what a solver's tolerance leaves.
SAME = 1e-3
#: Units of numbers that another machine, or the same one later, measures otherwise.
MEASURED = ("[s]", "[ms]", "[µs]", "[MB]")
#: Changes that are told of one table.
MOST = 6

Tables = Mapping[str, list[dict[str, str]]]


def tables(report: Path) -> Tables:
    """All tables of a report by name, as its CSV files have them. Raises InputError for what is no report's folder."""
    if not (report / "index.html").is_file() or not (report / "tables").is_dir():
        advice = "reports are written by: rollbench report --out DIR"
        raise InputError(str(report), "--against", "no report", "the folder of a report", advice)
    by_name = {}
    for path in sorted((report / "tables").glob("*.csv")):
        with open(path, encoding="utf-8", newline="") as stream:
            by_name[path.stem] = list(csv.DictReader(stream))
    return by_name


def moved(old: Tables, new: Tables) -> Iterator[str]:
    """What differs between the tables of two reports: lines. Rows are matched by their texts, else by their place; measured
    seconds and memory are left out."""
    for name in dict.fromkeys((*old, *new)):
        if name not in old or name not in new:
            yield f"{name}: {'new table' if name not in old else 'no longer there'}"
            continue
        lines = list(_moved(old[name], new[name]))
        yield from (f"{name}: {line}" for line in lines[:MOST])
        if len(lines) > MOST:
            yield f"{name}: and {len(lines) - MOST} more"


def _moved(old: Sequence[dict[str, str]], new: Sequence[dict[str, str]]) -> Iterator[str]:
    before, after = _keyed(old), _keyed(new)
    if before.keys() != after.keys() and len(old) == len(new):
        before, after = ({f"row {k + 1}": row for k, row in enumerate(rows)} for rows in (old, new))
    for key in dict.fromkeys((*before, *after)):
        if key not in before or key not in after:
            yield f"{key}: {'new row' if key not in before else 'row no longer there'}"
            continue
        for column in dict.fromkeys((*before[key], *after[key])):
            if not column.endswith(MEASURED):
                yield from _cell(f"{key}, {column}", before[key].get(column), after[key].get(column))


def _keyed(rows: Sequence[dict[str, str]]) -> dict[str, dict[str, str]]:
    """Rows by their texts; those of the same texts are counted."""
    by_text: dict[str, dict[str, str]] = {}
    for row in rows:
        texts = [cell for cell in row.values() if cell and _number(cell) is None]
        key = ", ".join(text if len(text) <= 40 else f"{text[:37]}..." for text in texts[:3]) or "row"
        count = sum(known == key or known.startswith(f"{key} (") for known in by_text)
        by_text[f"{key} ({count + 1})" if count else key] = row
    return by_text


def _number(text: str) -> float | None:
    with suppress(ValueError):
        return float(text)
    return None


def _cell(where: str, old: str | None, new: str | None) -> Iterator[str]:
    if old == new:
        return
    if old is None or new is None:
        yield f"{where}: {'new column' if old is None else 'column no longer there'}"
        return
    a, b = _number(old), _number(new)
    if a is None or b is None:
        yield f"{where}: {old[:60] or 'nothing'} became {new[:60] or 'nothing'}"
        return
    change = float(error_percent(b, a)) if a else float("inf")
    if not abs(change) <= SAME and abs(b - a) > 1e-12:
        yield f"{where}: {a:.6g} became {b:.6g} ({change:+.3g} %)"


def is_whole(report: Path) -> bool:
    """Whether a path is the folder, or the first page, of a whole report with a manifest."""
    return (folder_of(report) / FILE).is_file()


def folder_of(report: Path) -> Path:
    """Folder of a report that is named by it or by its first page."""
    return report if report.is_dir() else report.parent


def checked(report: Path, stores: Sequence[Path]) -> Iterator[Checked]:
    """Every hash of a whole report's manifest beside the one computed now: its files, and what it rests on.

    Raises InputError for a damaged manifest.
    """
    folder = folder_of(report)
    try:
        manifest = read_manifest(folder)
    except (OSError, ValueError) as error:
        raise InputError(str(folder / FILE), "file", str(error), "a manifest", "write the report again") from None
    names = [name.removeprefix(SCENE) for name in manifest["inputs"] if name.startswith(SCENE)]
    texts = {name: catalogue.scene_text(name) for name in names if name in catalogue.scene_names()}
    for stated, computed in ((manifest["files"], hashes(folder)), (manifest["inputs"], inputs(stores, texts))):
        for name, value in stated.items():
            present = computed.get(name, "")
            state = "missing" if not present else "ok" if present == value else "changed"
            yield Checked(name, state, str(value), "" if state == "ok" else present)
    for name in hashes(folder).keys() - manifest["files"].keys():
        yield Checked(name, "added", "", "")
