"""The pages of a report: the first one, one for each section, and the index that the search of every page reads."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from rollbench.reports import field3d, figures, first_pages, scene3d, view3d
from rollbench.reports.cells import cell_view, filled, is_number, micro, write_csv
from rollbench.reports.manifest import write_manifest
from rollbench.reports.panels import draw_parts, themed
from rollbench.reports.records import FieldPicture, Figure, LoadedScrew, PressureMap, Report, Section, Summary, Table, Text

#: What marks pages as written by a report, and their folder as its to replace.
MARKER = '<meta name="generator" content="rollbench">'
#: The index of the search: a script, because a page opened from a file may load no data.
SEARCH = "search.js"
#: Characters of a table or text that the search knows.
KNOWN = 4000

Progress = Callable[[str], None]
Item = Text | Table | Figure | LoadedScrew | FieldPicture | PressureMap


@dataclass
class _Writer:
    """Where files go, running numbers of figures and tables, and the entries of the search so far."""

    folder: Path
    say: Progress
    figures: int = 0
    tables: int = 0
    entries: list[dict[str, str]] = field(default_factory=list)


def write_pages(report: Report, folder: Path, say: Progress) -> None:
    """Draw everything and write pages, tables, figures and the index of the search into ``folder``, which has the folders
    ``tables`` and ``figures``."""
    environment = Environment(
        loader=PackageLoader("rollbench.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["micro"] = micro
    writer = _Writer(folder, say)
    sections = [
        _section(section, number, len(report.sections), writer) for number, section in enumerate(report.sections, 1)
    ]
    common = {"report": report, "sections": sections, "marker": Markup(MARKER)}
    turns = zip(sections, [None, *sections[:-1]], [*sections[1:], None], strict=True)
    for section, before, after in turns:
        own = {"section": section, "current": section["name"], "before": before, "after": after}
        heading = f"{section['title']} – {report.title}"
        page = environment.get_template("section.html.j2").render(**common, **own, heading=heading)
        _write(folder / section["file"], page)
    summary = next((section.summary for section in report.sections if section.summary), None)
    first = None if summary is None else _summary(report, summary, writer)
    page = environment.get_template("index.html.j2").render(**common, summary=first, current="", heading=report.title)
    _write(folder / "index.html", page)
    lines = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in writer.entries)
    _write(folder / SEARCH, f"window.rollbenchSearch = [\n{lines}\n];\n")
    if report.origin:
        write_manifest(folder, report.origin)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _section(section: Section, number: int, total: int, writer: _Writer) -> dict[str, Any]:
    """What the templates need of a section; writes the files of its items."""
    writer.say(f"report: {number}/{total} {section.title}")
    file = f"{section.name}.html"
    items = [_item(item, file, writer) for item in section.items]
    words = [p for item in section.items if isinstance(item, Text) for p in item.paragraphs]
    writer.entries.append(_entry(section.title, file, "page", " ".join(words)))
    marks = []
    for item in items:
        if item["kind"] == "text":
            continue
        record = item[item["kind"]]
        mark = {"anchor": f"{item['kind']}-{record.name}", "title": record.title}
        label = f"{item['kind'].capitalize()} {item['number']}"
        marks.append(mark)
        writer.entries.append(_entry(record.title, f"{file}#{mark['anchor']}", f"{label}, {section.title}", _words(record)))
    view = {"number": number, "name": section.name, "title": section.title, "file": file, "appendix": section.appendix}
    return {**view, "headline": section.headline, "items": items, "marks": marks}


def _entry(title: str, place: str, under: str, text: str) -> dict[str, str]:
    """One entry of the search: title, address, where it stands, text."""
    return {"t": micro(title), "h": place, "s": under, "x": micro(re.sub(r"\s+", " ", text))[:KNOWN]}


def _words(record: Any) -> str:
    """What the search reads of a table (headings, note, texts of cells, each once) or of a figure (caption)."""
    if not isinstance(record, Table):
        return str(record.caption)
    texts = [str(row[c.key]) for row in record.rows for c in record.columns if isinstance(row.get(c.key), str)]
    return " ".join(dict.fromkeys([*(c.label for c in record.columns), record.note, *texts]))


def _summary(report: Report, summary: Summary, writer: _Writer) -> dict[str, Any]:
    """The first screen, its figure drawn for wide and for narrow screens; writes the PDF of it where typst is installed."""
    wide, narrow = draw_parts(summary.figure), draw_parts(summary.narrow)
    _write(writer.folder / "figures" / f"{summary.figure.name}.svg", wide.whole)
    writer.entries.insert(0, _entry(summary.question, "index.html", "page", " ".join((*summary.coverage, *summary.limits))))
    view = {"record": summary, "wide": Markup(wide.panels[0]), "narrow": Markup(narrow.panels[0])}
    try:
        first_pages.write_first_pages(report, summary, wide.whole, writer.folder)
    except (ImportError, RuntimeError) as error:
        writer.say(f"report: {first_pages.FILE} left out ({error}); {first_pages.REMEDY}")
        return view | {"pdf": None}
    return view | {"pdf": first_pages.FILE}


def _item(item: Item, page: str, writer: _Writer) -> dict[str, Any]:
    """What the templates need of one item of a page; writes the item's file."""
    if isinstance(item, Text):
        return {"kind": "text", "text": item}
    if isinstance(item, Table):
        writer.tables += 1
        return _table(item, writer)
    writer.figures += 1
    view: dict[str, Any] = {"kind": "figure", "figure": item, "number": writer.figures}
    view |= {"file": None, "panels": (), "legend": "", "across": 1, "image": None, "missing": None, "turned": None}
    name = f"figures/{item.name}"
    if isinstance(item, Figure):
        drawn = draw_parts(item)
        _write(writer.folder / f"{name}.svg", drawn.whole)
        across = max(1, min(item.columns, len(item.panels), 3))
        panels = [Markup(panel) for panel in drawn.panels]
        return {**view, "file": f"{name}.svg", "panels": panels, "legend": Markup(drawn.legend), "across": across}
    if isinstance(item, PressureMap):
        svg = figures.draw_map(item)
        _write(writer.folder / f"{name}.svg", svg)
        return {**view, "file": f"{name}.svg", "panels": [Markup(themed(_inline(svg)))]}
    return view | _picture(item, f"{name}.png", f"{page}#figure-{item.name}", writer)


def _picture(item: LoadedScrew | FieldPicture, name: str, back: str, writer: _Writer) -> dict[str, Any]:
    """A 3D picture as a file of its own, or why it is missing; back: address of where it stands."""
    path = writer.folder / name
    try:
        if isinstance(item, LoadedScrew):
            scene3d.draw_loaded_screw(item, path)
        else:
            field3d.draw_field(item, path)
    except RuntimeError as error:
        path.unlink(missing_ok=True)
        writer.say(f"report: picture left out. {error}")
        return {"missing": str(error)}
    turned = _turned(item, back, writer) if isinstance(item, LoadedScrew) and item.turns else None
    return {"file": name, "image": name, "turned": turned}


def _turned(item: LoadedScrew, back: str, writer: _Writer) -> str | None:
    """Name of the page on which a loaded screw can be turned; None where none can be made here."""
    name = view3d.view_file(item)
    try:
        view3d.write_view(item, writer.folder / name, MARKER, back)
    except (ImportError, RuntimeError) as error:
        writer.say(f"report: {name} left out ({error}); {view3d.REMEDY}")
        return None
    return name


def _inline(svg: str) -> str:
    """An SVG document as an element of a page: without prologue, metadata and title of its own."""
    return re.sub(r"\s*<(metadata|title)>.*?</\1>", "", svg[svg.index("<svg") :], flags=re.DOTALL)


def _table(table: Table, writer: _Writer) -> dict[str, Any]:
    """A table as the page shows it, without columns that are empty; its CSV has all of them."""
    write_csv(table, writer.folder / "tables" / f"{table.name}.csv")
    columns, empty = filled(table)
    numbers = [is_number(column, table) for column in columns]
    heads: Sequence[dict[str, str]] = [
        {"label": c.label, "unit": c.unit, "align": "num" if number else "text"}
        for c, number in zip(columns, numbers, strict=True)
    ]
    rows = [
        [cell_view(c, row.get(c.key), number=number) for c, number in zip(columns, numbers, strict=True)]
        for row in table.rows[: table.shown]
    ]
    every = "" if table.shown is None else f"The first {len(rows)} of {len(table.rows)} rows; the CSV file has all."
    without = f"No row has an entry under: {'; '.join(empty)}." if empty else ""
    note = "\n".join(part for part in (table.note, every, without) if part)
    return {"kind": "table", "table": table, "number": writer.tables, "columns": heads, "rows": rows, "note": note}
