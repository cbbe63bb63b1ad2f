"""Writes a report as a folder: first page, a page for each `Page` record, tables as CSV, figures, search index."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from rollbench.meshes.leftovers import temporary_name
from rollbench.reports import field3d, figures, scene3d, sketch, view
from rollbench.reports.cells import cell_view, filled_table, is_number, micro_sign, typeset_text, write_csv
from rollbench.reports.content import (
    FieldPicture,
    Figure,
    LoadedScrew,
    Page,
    PressureMap,
    Report,
    Section,
    Sketch,
    Summary,
    Table,
    Text,
)
from rollbench.reports.manifest import FILE as MANIFEST
from rollbench.reports.manifest import write_manifest
from rollbench.reports.view import MARKER

#: Search index: a script, because a page opened from a file may load no data.
SEARCH = "search.js"

#: Number of characters of a table or text in the search index.
KNOWN = 4000

#: Number of rows from which on a page folds a table.
LONG = 20

#: Number of columns from which on a table is set narrower.
WIDE = 8

#: Number of characters up to which the first sentence of a conclusion is a heading.
HEADLINE = 170

#: Key of a column that a page does not show: the name of the table, figure or section that a row's verdict leads to.
HOW = "how"

_NAMED = re.compile(r"\b([Tt]ables?|[Ff]igures?|[Ss]ections?) ([a-z0-9][\w.-]*\w)")

Progress = Callable[[str], None]

Item = Text | Table | Figure | Sketch | LoadedScrew | FieldPicture | PressureMap


@dataclass
class _Writer:
    """State while a report is written: folder, link targets by name, and entries of the search index."""

    #: Folder of the report.
    folder: Path
    #: Called with lines of progress.
    say: Progress
    #: Addresses by name.
    places: dict[str, str]
    #: Entries of the search index.
    entries: list[dict[str, str]] = field(default_factory=list)

    def linked(self, text: str) -> Markup:
        """Return a text in which names of tables, figures and sections are links."""

        def link(found: re.Match[str]) -> str:
            place = self.places.get(found[2])
            return found[0] if place is None else f'{found[1]} <a href="{place}">{found[2]}</a>'

        return Markup(_NAMED.sub(link, str(escape(typeset_text(text)))))


def load_templates() -> Environment:
    """Return the Jinja environment with the page templates; texts are escaped."""
    loader = PackageLoader("rollbench.reports")
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def write_pages(report: Report, folder: Path, say: Progress) -> None:
    """Draw all items of a report and write pages, tables, figures and the search index.

    Parameters
    ----------
    report
        The report.
    folder
        Folder with the subfolders ``tables`` and ``figures``.
    say
        Called with lines of progress.
    """
    environment = load_templates()
    writer = _Writer(folder, say, _item_places(report))
    environment.filters.update(typeset=typeset_text, linked=writer.linked, place=lambda name: writer.places.get(name, ""))
    pages = [_render_page(page, number, len(report.pages), writer) for number, page in enumerate(report.pages, 1)]
    common = {"report": report, "pages": pages, "marker": Markup(MARKER)}
    turns = zip(pages, [None, *pages[:-1]], [*pages[1:], None], strict=True)
    for page, before, after in turns:
        of_page = {"page": page, "current": page["name"], "before": before, "after": after}
        heading = f"{page['title']} – {report.title}"
        _write_text(
            folder / page["file"], environment.get_template("page.html.j2").render(**common, **of_page, heading=heading)
        )
    summary = next((section.summary for section in report.sections if section.summary), None)
    first = None if summary is None else _render_summary(summary, writer)
    text = environment.get_template("index.html.j2").render(**common, summary=first, current="", heading=report.title)
    _write_text(folder / "index.html", text)
    lines = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in writer.entries)
    _write_text(folder / SEARCH, f"window.rollbenchSearch = [\n{lines}\n];\n")
    if report.origin:
        write_manifest(folder, report.origin)


def _item_places(report: Report) -> dict[str, str]:
    """Return the addresses of sections, tables and figures by name."""
    found = {}
    for page in report.pages:
        for section in page.sections:
            found[section.name] = f"{page.name}.html#section-{section.name}"
            named = (item for item in section.items if not isinstance(item, Text))
            found |= {item.name: f"{page.name}.html#{_item_kind(item)}-{item.name}" for item in named}
    return found


def _item_kind(item: Item) -> str:
    """Return the kind of an item in addresses: ``table`` or ``figure``."""
    return "table" if isinstance(item, Table) else "figure"


def _write_text(path: Path, text: str) -> None:
    """Write a text as UTF-8 with line feeds."""
    path.write_text(text, encoding="utf-8", newline="\n")


def _render_page(page: Page, number: int, total: int, writer: _Writer) -> dict[str, Any]:
    """Return a page's data for the templates; writes the files of its items."""
    writer.say(f"report: [{number}/{total}] {page.title}")
    file = f"{page.name}.html"
    sections = [_section_data(section, file, writer) for section in page.sections]
    writer.entries.insert(0, _contents_entry(page.title, file, "page", page.conclusion))
    heading, rest = page_headline(page.conclusion, page.title)
    for one in sections:
        shown = "" if one["conclusion"] == page.conclusion else one["conclusion"]
        one["heading"], one["conclusion"] = page_headline(shown, one["title"])
    data = {"name": page.name, "title": page.title, "heading": heading, "conclusion": rest}
    return data | {"file": file, "sections": sections, "statement": page.conclusion}


def page_headline(conclusion: str, title: str) -> tuple[str, str]:
    """Split a conclusion into the heading of a page or section and the remaining sentences.

    The heading is the conclusion's first sentence; the title if there is none or it is too long.

    Examples
    --------
    >>> page_headline("All 174 scenes are solved. The other method solves 145.", "Stability")
    ('All 174 scenes are solved', 'The other method solves 145.')
    >>> page_headline("", "Stability")
    ('Stability', '')
    """
    first, *rest = re.split(r"(?<=[^A-Z]{2})\. (?=[A-Z])", conclusion.removesuffix("."), maxsplit=1)
    if not first or len(first) > HEADLINE:
        return title, conclusion
    return first, f"{rest[0]}." if rest else ""


def _section_data(section: Section, file: str, writer: _Writer) -> dict[str, Any]:
    """Return a section's data for the templates; writes the files of its items."""
    items = [_render_item(item, file, writer) for item in section.items]
    words = [p for item in section.items if isinstance(item, Text) for p in item.paragraphs]
    writer.entries.append(_contents_entry(section.title, f"{file}#section-{section.name}", "section", " ".join(words)))
    for item in items:
        if item["kind"] != "text":
            record = item[item["kind"]]
            under = f"{item['kind']} {record.name}, {section.title}"
            writer.entries.append(
                _contents_entry(record.title, f"{file}#{item['kind']}-{record.name}", under, _searchable_text(record))
            )
    return {"name": section.name, "title": section.title, "conclusion": section.conclusion, "items": items}


def _contents_entry(title: str, place: str, under: str, text: str) -> dict[str, str]:
    """Return an entry of the search index: title, address, where it stands, and text to search."""
    return {"t": micro_sign(title), "h": place, "s": under, "x": micro_sign(re.sub(r"\s+", " ", text))[:KNOWN]}


def _searchable_text(record: Any) -> str:
    """Return the text of a table (headings, note, cells, each once) or figure (caption) for the search index."""
    if not isinstance(record, Table):
        return str(record.caption)
    texts = [str(row[c.key]) for row in record.rows for c in record.columns if isinstance(row.get(c.key), str)]
    return " ".join(dict.fromkeys([*(c.label for c in record.columns), record.note, *texts]))


def _render_summary(summary: Summary, writer: _Writer) -> dict[str, Any]:
    """Return the first page's data for the templates, with its figure for wide and for narrow screens."""
    wide, narrow = figures.draw_figure(summary.figure), figures.draw_figure(summary.narrow)
    _write_text(writer.folder / "figures" / f"{summary.figure.name}.svg", wide)
    writer.entries.insert(
        0, _contents_entry(summary.question, "index.html", "page", " ".join((*summary.coverage, *summary.limits)))
    )
    items = [_render_item(item, "index.html", writer) for item in summary.items]
    return {"record": summary, "items": items, "wide": inline_svg(wide), "narrow": inline_svg(narrow)}


def _render_item(item: Item, page: str, writer: _Writer) -> dict[str, Any]:
    """Return an item's data for the templates; writes the item's file."""
    if isinstance(item, Text):
        return {"kind": "text", "text": item}
    if isinstance(item, Table):
        return table_view(item, writer.folder)
    view: dict[str, Any] = {"kind": "figure", "figure": item}
    view |= dict.fromkeys(("file", "drawing", "narrow", "image", "missing", "turned"))
    name = f"figures/{item.name}"
    if isinstance(item, Figure | PressureMap | Sketch):
        narrow = ""
        if isinstance(item, Sketch):
            svg = sketch.draw_sketch(item)
        elif isinstance(item, Figure):
            svg, narrow = figures.draw_figure(item), figures.draw_figure(figures.narrow_figure(item))
        else:
            svg, narrow = figures.draw_map(item), figures.draw_map(replace(item, columns=1, width=figures.PHONE))
        if narrow:
            view["narrow"] = f"{name}-narrow.svg"
            _write_text(writer.folder / view["narrow"], narrow)
        _write_text(writer.folder / f"{name}.svg", svg)
        return {**view, "file": f"{name}.svg", "drawing": inline_svg(svg)}
    return view | _render_picture(item, f"{name}.png", f"{page}#figure-{item.name}", writer)


def _render_picture(item: LoadedScrew | FieldPicture, name: str, back: str, writer: _Writer) -> dict[str, Any]:
    """Write a 3D picture as a file and return its data, or why it is missing; ``back``: link back to the report."""
    path = writer.folder / name
    try:
        if isinstance(item, LoadedScrew):
            scene3d.draw_loaded_screw(item, path)
        else:
            field3d.draw_field(item, path)
    except RuntimeError as error:
        path.unlink(missing_ok=True)
        writer.say(f"WARNING: picture left out. {error}")
        return {"missing": str(error)}
    turned = None
    if isinstance(item, LoadedScrew) and item.view is not None:
        turned = f"view-{item.name}.html"
        _write_text(writer.folder / turned, view.view_page(item.view, back))
    return {"file": name, "image": name, "turned": turned}


def inline_svg(svg: str) -> Markup:
    """Return an SVG document as an element of a page, without prologue, metadata and title.

    Ink, paper and curves take the colours of the page, which change in dark mode.
    """
    element = re.sub(r"\s*<(metadata|title)>.*?</\1>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    colour = re.compile(r"#[0-9a-fA-F]{6}\b|(?<=fill: )white\b")
    theme = figures.THEME
    return Markup(colour.sub(lambda c: f"var(--{theme[c[0].lower()]}, {c[0]})" if c[0].lower() in theme else c[0], element))


def table_view(table: Table, folder: Path) -> dict[str, Any]:
    """Return a table's data for the templates, without empty columns, folded if long; writes its CSV file."""
    write_csv(table, folder / "tables" / f"{table.name}.csv")
    shown, empty = filled_table(table)
    shown = [c for c in shown if c.key != HOW and c.key not in table.csv_only]
    numbers = [is_number(column, table) for column in shown]
    heads: Sequence[dict[str, str]] = [
        {"label": c.label, "unit": c.unit, "align": "num" if number else "text"}
        for c, number in zip(shown, numbers, strict=True)
    ]
    cells = [
        [cell_view(c, row.get(c.key), number=number) for c, number in zip(shown, numbers, strict=True)]
        for row in table.rows
    ]
    for row, record in zip(cells, table.rows, strict=True):
        for cell in row:
            cell["link"] = str(record.get(HOW) or "") if cell["mark"].startswith("verdict") else ""
    remark = f"No row has an entry under: {'; '.join(empty)}." if empty else ""
    further = ", ".join(c.label for c in table.columns if c.key in table.csv_only)
    note = "\n".join(filter(None, [table.note, remark, further and f"In the CSV file also: {further}."]))
    form = {"wide": len(shown) > WIDE, "folded": len(cells) > LONG and not table.unfolded}
    return {"kind": "table", "table": table, "columns": heads, "rows": cells, "note": note, **form}


_FOLDERS = {"tables": (".csv",), "figures": (".svg", ".png")}

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def write_report(report: Report, out: Path, progress: Progress | None = None) -> Path:
    """Write a report into a folder, which then holds nothing else.

    Everything is first drawn into a new folder next to it, which replaces it only when complete: an error or an interrupt
    leaves an earlier report as it was.

    Parameters
    ----------
    report
        The records to draw.
    out
        Folder that does not exist, is empty, or holds an earlier report and nothing else.
    progress
        Called with a line before each section, and when a picture has to be left out.

    Returns
    -------
    Path
        Path of ``index.html``.

    Raises
    ------
    ValueError
        If ``out`` holds other files or cannot be replaced, a name is not fit for a file or given twice, or the data of a
        figure are inconsistent.
    """
    _check_names(report)

    def make(folder: Path) -> None:
        for name in ("tables", "figures"):
            (folder / name).mkdir()
        write_pages(report, folder, progress or (lambda _: None))

    return replace_folder(out, make) / "index.html"


def replace_folder(out: Path, make: Callable[[Path], None]) -> Path:
    """Replace a report's folder by a new one that ``make`` fills, completely or not at all; return its path.

    ValueError if the folder holds other files (`check_target`) or cannot be replaced.
    """
    out = Path(out).resolve()
    check_target(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    fresh = temporary_name(out, "new")
    try:
        fresh.mkdir()
        make(fresh)
        _swap_folders(fresh, out)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return out


def check_target(out: Path) -> None:
    """Raise ValueError unless ``out`` is missing, empty or an earlier report that a new one may replace."""
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
    """Return whether a file is a page of a report, its search index, its manifest, or the PDF of releases up to 0.14."""
    if not entry.is_file():
        return False
    return entry.name in (SEARCH, MANIFEST, "first-pages.pdf") or (
        entry.suffix == ".html" and MARKER in entry.read_text(encoding="utf-8", errors="replace")
    )


def _check_names(report: Report) -> None:
    """Raise ValueError for names in a report that are repeated or not fit for files and anchors."""
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


def _swap_folders(fresh: Path, out: Path) -> None:
    """Replace the folder ``out`` by ``fresh``; if that fails, the old folder is restored."""
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
