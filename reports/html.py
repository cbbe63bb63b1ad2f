"""A report as a folder: a first page, a page for each section, tables as CSV, figures as files, an index for the search."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from rollbench.meshes.leftovers import temporary
from rollbench.reports.content import Report, Table, Text
from rollbench.reports.manifest import FILE as MANIFEST
from rollbench.reports.pages import MARKER, SEARCH, Progress, write_pages

_FOLDERS = {"tables": (".csv",), "figures": (".svg", ".png")}
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def write(report: Report, out: Path, progress: Progress | None = None) -> Path:
    """Write a report into the directory ``out``, which then holds nothing else.

    Everything is drawn into a directory beside ``out`` first, and that directory takes the place of ``out``
    only when it is whole: an error or an interrupt leaves an earlier report as it was.

    Args:
        report: the records to draw.
        out: a directory that does not exist, is empty, or holds an earlier report and nothing else.
        progress: called with one line before each section, and when a picture has to be left out.

    Returns:
        The path of ``index.html``.

    Raises:
        ValueError: ``out`` holds what no report wrote or cannot be replaced; a name is unfit for a file or
            given twice; a figure's data are inconsistent.
    """
    out = Path(out).resolve()
    check_target(out)
    _check_names(report)
    say = progress or (lambda _: None)
    out.parent.mkdir(parents=True, exist_ok=True)
    fresh = temporary(out, "new")
    try:
        for folder in (fresh, fresh / "tables", fresh / "figures"):
            folder.mkdir()
        write_pages(report, fresh, say)
        _swap(fresh, out)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return out / "index.html"


def check_target(out: Path) -> None:
    """Raise ValueError unless a report may replace the directory ``out``."""
    if not out.exists():
        return
    if not out.is_dir():
        raise ValueError(f"{out} is a file; give a directory for the report")
    entries = sorted(out.rglob("*"))
    index = out / "index.html"
    if entries and not (index.is_file() and MARKER in index.read_text(encoding="utf-8", errors="replace")):
        raise ValueError(f"{out} is not empty and holds no rollbench report; choose another directory")
    for entry in entries:
        top = entry.relative_to(out).parts
        folder = len(top) == 1 and top[0] in _FOLDERS and entry.is_dir()
        file = len(top) == 2 and entry.is_file() and entry.suffix in _FOLDERS.get(top[0], ())
        if not (folder or file or (len(top) == 1 and _is_page(entry))):
            raise ValueError(f"{entry} was not written by a report and would be lost; move it elsewhere first")


def _is_page(entry: Path) -> bool:
    """Whether a file is a page of a report, the index of its search, its manifest, or the PDF of releases
    up to 0.14."""
    if not entry.is_file():
        return False
    return entry.name in (SEARCH, MANIFEST, "first-pages.pdf") or (
        entry.suffix == ".html" and MARKER in entry.read_text(encoding="utf-8", errors="replace")
    )


def _check_names(report: Report) -> None:
    """Names become files and anchors: refuse unfit ones and repeated ones."""
    seen: set[tuple[str, str]] = {("page", "index")}
    for page in report.pages:
        if not _NAME.fullmatch(page.name) or ("page", page.name) in seen:
            raise ValueError(f"page name {page.name!r} is unfit for a file or given twice")
        seen.add(("page", page.name))
    for section in report.sections:
        items = [item for item in section.items if not isinstance(item, Text)]
        named = [("table" if isinstance(item, Table) else "figure", item.name) for item in items]
        if section.summary:
            named += [("figure", figure.name) for figure in (section.summary.figure, section.summary.narrow)]
        for kind, name in [("section", section.name), *named]:
            if not _NAME.fullmatch(name):
                raise ValueError(f"{kind} name {name!r}: use letters, digits, dot, dash and underscore only")
            if (kind, name.lower()) in seen:
                raise ValueError(f"{kind} name {name!r} is given twice")
            seen.add((kind, name.lower()))


def _swap(fresh: Path, out: Path) -> None:
    """Let ``fresh`` take the place of ``out``; whatever happens in between, one of the two is there."""
    if not out.exists():
        fresh.rename(out)
        return
    old = fresh.with_suffix(".old")
    try:
        out.rename(old)
        fresh.rename(out)
    except BaseException as error:
        if old.exists() and not out.exists():
            old.rename(out)
        if isinstance(error, OSError):
            raise ValueError(f"{out} cannot be replaced ({error.strerror}); give a directory below it") from error
        raise
    shutil.rmtree(old, ignore_errors=True)
