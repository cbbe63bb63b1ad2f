"""``rollbench verify``: the hashes of a page or a report computed again, and what moved between two pages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rollbench.comparison.commands.printing import Answer
from rollbench.comparison.commands.reporting import moved as report_moved
from rollbench.comparison.commands.reporting.checked import Checked
from rollbench.comparison.commands.reporting.scene_page import make_page
from rollbench.comparison.errors import InputError
from rollbench.comparison.measure import error_percent
from rollbench.comparison.provenance import SOURCES, sources_hash
from rollbench.comparison.reference.store import shipped_store
from rollbench.reports.manifest import page_text, sha256
from rollbench.reports.scene_page import read_page, results_hash, without_manifest

#: Change [%] of a number up to which it is round-off.
ROUND_OFF = 1e-6


def page_file(report: Path) -> Path:
    """The page of a report: itself, or the index of its folder."""
    return report / "index.html" if report.is_dir() else report


def read(report: Path) -> tuple[str, dict[str, Any]]:
    """Text of a page and its blocks. Raises InputError for a file that is no such page."""
    path = page_file(report)
    try:
        html = page_text(path)
        return html, read_page(html)
    except (OSError, ValueError) as error:
        advice = "pages with a manifest are written by: rollbench report SCENE --out DIR"
        raise InputError(str(path), "file", str(error), "a page with a manifest", advice) from None


def checked(html: str, blocks: dict[str, Any], stores: Sequence[Path]) -> Iterator[Checked]:
    """Every hash of a manifest beside the one computed now: of the page, what it carries, sources, stored files."""
    manifest = blocks["manifest"]
    hashes = {
        "page": sha256(without_manifest(html)),
        "scene": sha256(blocks["scene"]),
        "results": results_hash(blocks["results"]),
    }
    for name, computed in hashes.items():
        stated = str(manifest.get(name, ""))
        yield Checked(name, "ok" if stated == computed else "changed", stated, "" if stated == computed else computed)
    for name, stated in dict(manifest.get("files", {})).items():
        paths = [p for store in stores if (p := store / Path(name).name).is_file()]
        computed = sources_hash() if name == SOURCES else sha256(paths[0].read_bytes()) if paths else ""
        state = "missing" if not computed else "ok" if computed == stated else "changed"
        yield Checked(name, state, str(stated), "" if state == "ok" else computed)


def run_verify(report: Path, store: Path) -> Answer:
    """Every hash's state; exit code 1 where one differs. Raises InputError for a file that is no page with a
    manifest."""
    stores = (store, shipped_store())
    whole = report_moved.is_whole(report)
    rows = list(report_moved.checked(report, stores) if whole else checked(*read(report), stores))
    shown = [row for row in rows if not whole or row.state != "ok"]  # a whole report has hundreds
    wrong = sum(row.state != "ok" for row in rows)
    count = f"{len(rows) - wrong} of {len(rows)} hashes hold: {'the same inputs and code' if not wrong else 'see above'}"
    return Answer(parts=[*(row.line for row in shown), count], code=1 if wrong else 0)


def run_page(scene: str, out: Path, store: Path, against: Path | None, reference: Path | None = None) -> Answer:
    """Write the page of a scene, and list what moved against an earlier one; exit code 1 where a load case did not
    converge. Raises InputError as `make_page`, `read`."""
    before = None if against is None else read(against)[1]
    page = make_page(scene, out, store, reference)
    parts = [*(f"WARNING: {warning}" for warning in page.warnings), page.verdict, f"page: {out / 'index.html'}"]
    if before is not None:
        after = read(out)[1]
        lines = [
            *moved(_inputs(before["manifest"]), _inputs(after["manifest"])),
            *moved(_stable(before["results"]), _stable(after["results"])),
        ]
        parts += lines or ["nothing moved"]
    return Answer(parts=parts, code=int(page.results["status"] != "converged"))


def _inputs(manifest: dict[str, Any]) -> dict[str, Any]:
    """A manifest without what differs in every run: the date, and the hashes of what holds the solver's seconds."""
    kept = {key: value for key, value in manifest.items() if key not in ("page", "results")}
    return kept | {"provenance": {k: v for k, v in manifest["provenance"].items() if k != "date"}}


def _stable(results: dict[str, Any]) -> dict[str, Any]:
    """Results without what differs in every run: the solver's seconds."""
    kept = {key: value for key, value in results.items() if key != "solver"}
    return kept | ({"cases": [_stable(one) for one in results["cases"]]} if "cases" in results else {})


def moved(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """What differs between two results, a line each: numbers beyond round-off with their change, and all else."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in dict.fromkeys((*old, *new)):
            yield from moved(old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(old, new, strict=True)):
            yield from moved(a, b, f"{path}[{k + 1}]")
    elif _number(old) and _number(new):
        change = float(error_percent(new, old)) if old else float("inf") if new else 0.0
        if abs(change) > ROUND_OFF:
            yield f"{path}: {old:.6g} became {new:.6g} ({change:+.3g} %)"
    elif old != new:
        yield f"{path}: {_short(old)} became {_short(new)}"


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: Any) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= 60 else text[:57] + "..."
