"""Write a report to a folder: web pages, tables as CSV files, figures, and an index for the full-text search."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from rollbench.meshes.files import temporary_path
from rollbench.meshes.processes import single_thread_workers, without_restart_warnings
from rollbench.reports import cells as reports_cells
from rollbench.reports import content, field3d, figures, scene3d, sketch, view
from rollbench.reports.manifest import FILE as MANIFEST
from rollbench.reports.manifest import SUMS, write_manifest
from rollbench.reports.view import MARKER

#: File of the search index. It is a script because a browser does not load data files for a page opened from disk.
SEARCH = "search.js"

#: Largest number of characters that the search index stores for a table or text.
KNOWN = 4000

#: Number of rows above which a page shows a table folded.
LONG = 20

#: Number of columns above which a table is set in a narrower font.
WIDE = 8

#: Largest number of characters of a conclusion's first sentence that becomes a heading.
HEADLINE = 170

#: Key of a column that a page does not show: name of the table, figure or section to which the verdict in the row links.
HOW = "how"

#: References in a text to a table, figure or section of the report, by its name.
_NAMED = re.compile(r"\b([Tt]ables?|[Ff]igures?|[Ss]ections?) ([a-z0-9][\w.-]*\w)")

#: Name, width and height of each view of a panel in an SVG document.
_VIEW = re.compile(r'<view id="([^"]+)" viewBox="0 [\d.]+ ([\d.]+) ([\d.]+)"')

#: Number of drawn items from which on they are drawn by several processes, which take seconds to start.
WORTH_PROCESSES = 8

#: Items that are drawn as SVG documents.
Drawn = content.Figure | content.PressureMap | content.Sketch

#: Function that is called with each line of progress.
Progress = Callable[[str], None]


@dataclass
class _ReportWriter:
    """Data that the functions share while they write a report: its folder, link targets, and search index."""

    #: Folder of the report.
    folder: Path
    #: Function that is called with each line of progress.
    show_progress: Progress
    #: Link target of each table, figure and section, by its name.
    link_targets: dict[str, str]
    #: Names of the drawn items with their SVG documents, as they become ready.
    drawings: Iterator[tuple[str, list[str]]]
    #: SVG documents that are ready, by the name of the item.
    ready: dict[str, list[str]] = field(default_factory=dict)
    #: Entries of the search index, collected page by page.
    search_entries: list[dict[str, str]] = field(default_factory=list)

    def svg_documents(self, name: str) -> list[str]:
        """Return the SVG documents of the drawn item ``name``, as soon as they are ready."""
        while name not in self.ready:
            self.ready |= [next(self.drawings)]
        return self.ready.pop(name)

    def html_with_links(self, text: str) -> Markup:
        """Return a text as HTML, in which references such as "table NAME" or "figure NAME" are links."""

        def link_reference(found: re.Match[str]) -> str:
            place = self.link_targets.get(found[2])
            return found[0] if place is None else f'{found[1]} <a href="{place}">{found[2]}</a>'

        return Markup(_NAMED.sub(link_reference, str(escape(reports_cells.with_typographic_signs(text)))))


def load_templates() -> Environment:
    """Return the Jinja environment with the templates of the report's pages; it escapes texts for HTML."""
    loader = PackageLoader("rollbench.reports")
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def draw_forms(item: Drawn) -> tuple[str, list[str]]:
    """Return the name of an item and its SVG documents: one, or of a map one for a wide screen and one for a phone."""
    if isinstance(item, content.Sketch):
        return item.name, [sketch.draw_sketch(item)]
    if isinstance(item, content.Figure):
        return item.name, [figures.draw_panels_in_column(item)]
    forms = (replace(item, columns=1, width=figures.PHONE), item)  # one panel or two are drawn for a phone only
    return item.name, [figures.draw_pressure_map(form) for form in (forms[:1] if len(item.panels) <= 2 else forms[::-1])]


def _draw_all(report: content.Report, processes: int) -> Iterator[tuple[str, list[str]]]:
    """Yield the name and SVG documents of each drawn item of a report, in the order of the pages, the first page last.

    ``processes``: number of processes that draw.
    """
    items = [item for section in report.sections for item in section.items]
    items += _items_of_summary(_summary(report))
    drawn = [item for item in items if isinstance(item, Drawn)]
    if processes == 1 or len(drawn) < WORTH_PROCESSES:
        yield from map(draw_forms, drawn)
        return
    from joblib import Parallel, delayed

    with single_thread_workers():
        workers = Parallel(n_jobs=processes, return_as="generator")
    with without_restart_warnings():
        yield from workers(map(delayed(draw_forms), drawn))


def _summary(report: content.Report) -> content.Summary | None:
    """Return the contents of a report's first page, which one of the sections has; None without."""
    return next((section.summary for section in report.sections if section.summary), None)


def _items_of_summary(summary: content.Summary | None) -> list[content.Table | content.Figure]:
    """Return the tables and figures of a report's first page, the main figure first."""
    return [] if summary is None else [summary.figure, *summary.items]


def write_pages(report: content.Report, folder: Path, show_progress: Progress, processes: int = 1) -> None:
    """Write all files of a report: pages, tables, figures, search index, and manifest.

    Parameters
    ----------
    report
        Contents of the report.
    folder
        Existing folder with the subfolders ``tables`` and ``figures``.
    show_progress
        Function that is called with each line of progress.
    processes
        Number of processes that draw the figures.
    """
    environment = load_templates()
    writer = _ReportWriter(folder, show_progress, _link_targets(report), _draw_all(report, processes))
    environment.filters.update(
        typeset=reports_cells.with_typographic_signs,
        linked=writer.html_with_links,
        place=lambda name: writer.link_targets.get(name, ""),
    )
    pages = [_page_template_data(page, number, len(report.pages), writer) for number, page in enumerate(report.pages, 1)]
    common = {"report": report, "pages": pages, "marker": Markup(MARKER)}
    turns = zip(pages, [None, *pages[:-1]], [*pages[1:], None], strict=True)
    for page, before, after in turns:
        of_page = {"page": page, "current": page["name"], "before": before, "after": after}
        heading = f"{page['title']} – {report.title}"
        text = environment.get_template("page.html.j2").render(**common, **of_page, heading=heading)
        _write_page(folder / page["file"], text)
    summary = _summary(report)
    first = None if summary is None else _summary_template_data(summary, writer)
    text = environment.get_template("index.html.j2").render(**common, summary=first, current="", heading=report.title)
    _write_page(folder / "index.html", text)
    lines = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in writer.search_entries)
    _write_text(folder / SEARCH, f"window.rollbenchSearch = [\n{lines}\n];\n")
    if report.origin:
        write_manifest(folder, report.origin)


def _link_targets(report: content.Report) -> dict[str, str]:
    """Return the link target (``PAGE.html#ANCHOR``) of each section, table and figure of a report, by its name."""
    found = {}
    for page in report.pages:
        for section in page.sections:
            found[section.name] = f"{page.name}.html#section-{section.name}"
            for item in section.items:
                if not isinstance(item, content.Text):
                    prefix = "table" if isinstance(item, content.Table) else "figure"
                    found[item.name] = f"{page.name}.html#{prefix}-{item.name}"
    return found


def _write_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8, with line feeds as line ends on every system."""
    path.write_text(text, encoding="utf-8", newline="\n")


def _write_page(path: Path, text: str) -> None:
    """Write an HTML page, without the indentation of its tags."""
    _write_text(path, re.sub(r"\n\s+<", "\n<", text))


def _page_template_data(page: content.Page, number: int, total: int, writer: _ReportWriter) -> dict[str, Any]:
    """Write the figures and tables of one page to files, and return the data for the page's HTML template.

    ``number``, ``total``: number of the page, from 1, and number of pages, for the line of progress. Entries of the search
    index are added to ``writer``.
    """
    writer.show_progress(f"report: [{number}/{total}] {page.title}")
    file = f"{page.name}.html"
    sections = [_section_template_data(section, file, writer) for section in page.sections]
    writer.search_entries.insert(0, _search_index_entry(page.title, file, "page", page.conclusion))
    heading, rest = split_conclusion_into_heading(page.conclusion, page.title)
    for one in sections:
        shown = "" if one["conclusion"] == page.conclusion else one["conclusion"]
        one["heading"], one["conclusion"] = split_conclusion_into_heading(shown, one["title"])
    data = {"name": page.name, "title": page.title, "heading": heading, "conclusion": rest}
    return data | {"file": file, "sections": sections, "statement": page.conclusion}


def split_conclusion_into_heading(conclusion: str, title: str) -> tuple[str, str]:
    """Split the conclusion of a page or section into a heading and the remaining sentences; return both.

    The heading is the first sentence of the conclusion. If that is empty or too long, the heading is the title.

    Examples
    --------
    >>> split_conclusion_into_heading("All 174 scenes are solved. The other method solves 145.", "Stability")
    ('All 174 scenes are solved', 'The other method solves 145.')
    >>> split_conclusion_into_heading("", "Stability")
    ('Stability', '')
    """
    first, *rest = re.split(r"(?<=[^A-Z]{2})\. (?=[A-Z])", conclusion.removesuffix("."), maxsplit=1)
    if not first or len(first) > HEADLINE:
        return title, conclusion
    return first, f"{rest[0]}." if rest else ""


def _section_template_data(section: content.Section, file: str, writer: _ReportWriter) -> dict[str, Any]:
    """Write the figures and tables of one section to files, and return the section's data for its page's HTML template.

    ``file``: file name of the page. Entries of the search index are added to ``writer``.
    """
    items = [_item_template_data(item, file, writer) for item in section.items]
    words = [p for item in section.items if isinstance(item, content.Text) for p in item.paragraphs]
    found = [_search_index_entry(section.title, f"{file}#section-{section.name}", "section", " ".join(words))]
    for kind, record in ((item["kind"], item[item["kind"]]) for item in items if item["kind"] != "text"):
        link, under = f"{file}#{kind}-{record.name}", f"{kind} {record.name}, {section.title}"
        found.append(_search_index_entry(record.title, link, under, _searchable_text(record)))
    writer.search_entries.extend(found)
    return {"name": section.name, "title": section.title, "conclusion": section.conclusion, "items": items}


def _search_index_entry(title: str, link_target: str, location: str, text: str) -> dict[str, str]:
    """Return one entry of the search index, with the keys t (title), h (link target), s (location) and x (searched text).

    ``location``: location in words, such as "table NAME, SECTION".
    """
    return {
        "t": reports_cells.replace_um_by_micrometre(title),
        "h": link_target,
        "s": location,
        "x": reports_cells.replace_um_by_micrometre(re.sub(r"\s+", " ", text))[:KNOWN],
    }


def _searchable_text(record: Any) -> str:
    """Return the text by which the search finds a table (headings, note, texts of cells) or a figure (caption).

    ``record``: the table or figure.
    """
    if not isinstance(record, content.Table):
        return str(record.caption)
    texts = [cell for row in record.rows for cell in row.values() if isinstance(cell, str)]
    return " ".join(dict.fromkeys([*(head.label for head in record.heads.values()), record.note, *texts]))


def _summary_template_data(summary: content.Summary, writer: _ReportWriter) -> dict[str, Any]:
    """Write the figures and tables of the report's first page to files, and return the data for its HTML template."""
    text = " ".join((*summary.coverage, *summary.limits))
    writer.search_entries.insert(0, _search_index_entry(summary.question, "index.html", "page", text))
    first, *others = [_item_template_data(item, "index.html", writer) for item in _items_of_summary(summary)]
    return {"record": summary, "figure": first, "items": others}


def _item_template_data(item: content.Item, page: str, writer: _ReportWriter) -> dict[str, Any]:
    """Write one table or figure to its files, and return its data for the HTML template; a text needs no file.

    ``page``: file name of the page that contains the item. ``writer``: has the folder of the report.
    """
    if isinstance(item, content.Text):
        return {"kind": "text", "text": item}
    if isinstance(item, content.Table):
        return table_template_data(item, writer.folder)
    view: dict[str, Any] = {"kind": "figure", "figure": item}
    view |= dict.fromkeys(("file", "drawing", "narrow", "views", "image", "missing", "turned"))
    name = f"figures/{item.name}"
    if isinstance(item, Drawn):
        drawn = writer.svg_documents(item.name)
        forms = dict(zip(("file", "narrow"), (f"{name}.svg", f"{name}-narrow.svg"), strict=True))
        for form, svg in zip(forms, drawn, strict=False):
            _write_text(writer.folder / forms[form], svg)
            view[form] = forms[form]
        view["views"] = _VIEW.findall(drawn[0])
        return {**view, "drawing": "one" if len(drawn) == 1 and not isinstance(item, content.Sketch) else "wide"}
    if isinstance(item, content.Picture):
        item.png.tofile(writer.folder / f"{name}.png")
        return view | {"file": f"{name}.png", "image": f"{name}.png"}
    return view | _picture_template_data(item, f"{name}.png", f"{page}#figure-{item.name}", writer)


def _picture_template_data(
    item: content.LoadedScrew | content.FieldPicture, name: str, back_link: str, writer: _ReportWriter
) -> dict[str, Any]:
    """Write a 3D picture to the file ``name``, and return its data for the HTML template.

    ``back_link``: link from the picture's own 3D page to the report. ``writer``: has the folder of the report. If the
    picture cannot be drawn, the data contain the reason instead.
    """
    path = writer.folder / name
    try:
        if isinstance(item, content.LoadedScrew):
            scene3d.draw_loaded_screw(item, path)
        else:
            field3d.draw_field_picture(item, path)
    except RuntimeError as error:
        path.unlink(missing_ok=True)
        writer.show_progress(f"WARNING: the report lacks the picture {item.name!r}. {error}")
        return {"missing": str(error)}
    turned = None
    if isinstance(item, content.LoadedScrew) and item.view is not None:
        turned = f"view-{item.name}.html"
        _write_text(writer.folder / turned, view.viewer_page_html(item.view, back_link))
    return {"file": name, "image": name, "turned": turned}


def svg_as_html_element(svg: str) -> Markup:
    """Return an SVG document as an HTML element, without XML header, metadata and title.

    The colours of lines, background and curves are replaced by CSS variables of the page, which change in dark mode.
    """
    element = re.sub(r"\s*<(metadata|title)>.*?</\1>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    colour = re.compile(r"#[0-9a-fA-F]{6}\b|(?<=fill: )white\b")
    theme = figures.THEME
    return Markup(colour.sub(lambda c: f"var(--{theme[c[0].lower()]}, {c[0]})" if c[0].lower() in theme else c[0], element))


def table_template_data(table: content.Table, folder: Path) -> dict[str, Any]:
    """Write the CSV file of a table, and return the table's data for the HTML template.

    ``folder``: folder of the report. The data omit empty columns and say whether the table is folded, because it is long,
    or set in a narrower font.
    """
    reports_cells.write_csv(table, folder / "tables" / f"{table.name}.csv")
    heads = table.heads
    empty = [key for key, cells in table.columns.items() if cells and all(map(reports_cells.is_empty_cell, cells))]
    shown = [key for key in heads if key not in (*empty, *table.csv_only, HOW)]
    numbers = [reports_cells.is_number_column(heads[key], table.columns[key]) for key in shown]
    rows = list[list[dict[str, str]]]()
    for record in () if table.rows_csv_only else table.rows:
        row = [
            reports_cells.cell_text_and_css_classes(heads[key], record[key], right_aligned=number)
            for key, number in zip(shown, numbers, strict=True)
        ]
        for cell in row:
            cell["link"] = str(record.get(HOW) or "") if cell["mark"].startswith("verdict") else ""
        rows.append(row)
    remark = f"Not shown, because without entries: {'; '.join(heads[key].label for key in empty)}." if empty else ""
    further = ", ".join(head.label for key, head in heads.items() if key in table.csv_only)
    note = "\n".join(filter(None, [table.note, remark, further and f"Only in the CSV file: {further}."]))
    columns = [
        {"label": heads[key].label, "unit": heads[key].unit, "align": "num" if number else "text"}
        for key, number in zip(shown, numbers, strict=True)
    ]
    form = {"wide": len(shown) > WIDE, "folded": len(rows) > LONG and not table.unfolded}
    return {"kind": "table", "table": table, "columns": columns, "rows": rows, "note": note, **form}


#: Subfolders of a report, and the endings of the files in them.
_FOLDERS = {"tables": (".csv",), "figures": (".svg", ".png")}

#: Permitted names of pages, sections, tables and figures.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def write_report(report: content.Report, out: Path, progress: Progress | None = None, processes: int = 1) -> Path:
    """Write a report to a folder that contains nothing else afterwards.

    All files are first written to a temporary folder, which replaces ``out`` when it is complete. After an error or an
    interrupt, an earlier report in ``out`` is unchanged.

    Parameters
    ----------
    report
        Contents of the report.
    out
        Folder that does not exist, is empty, or contains an earlier report and nothing else.
    progress
        Function that is called with a line of text before each page, and when a picture cannot be drawn.
    processes
        Number of processes that draw the figures.

    Returns
    -------
    Path
        Path of ``index.html``.

    Raises
    ------
    ValueError
        If ``out`` contains other files or cannot be replaced, if a name in the report is not a valid file name or occurs
        twice, or if the data of a figure are inconsistent.
    """
    _check_report_names(report)

    def fill_folder(folder: Path) -> None:
        for name in ("tables", "figures"):
            (folder / name).mkdir()
        write_pages(report, folder, progress or (lambda _: None), processes)

    return replace_report_folder(out, fill_folder) / "index.html"


def replace_in_first_page(page: Path, old: str, new: str, origin: Mapping[str, object]) -> None:
    """Replace a text on the first page of a written report, and write its manifest again.

    ``page``: path of the first page; ``old``, ``new``: plain texts; ``origin``: inputs of the report for its manifest.
    """
    _write_text(page, page.read_text(encoding="utf-8").replace(str(escape(old)), str(escape(new))))
    write_manifest(page.parent, origin)


def replace_report_folder(out: Path, fill_folder: Callable[[Path], None]) -> Path:
    """Replace the folder of a report by a new one that ``fill_folder`` fills; return the path of the new one.

    If ``fill_folder`` fails, the old folder is unchanged. Raises ValueError if the folder contains files of other origin
    (see `check_report_folder`) or cannot be replaced.
    """
    out = Path(out).resolve()
    check_report_folder(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    fresh = temporary_path(out, "new")
    try:
        fresh.mkdir()
        fill_folder(fresh)
        _swap_folders(fresh, out)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return out


def check_report_folder(out: Path) -> None:
    """Raise ValueError if the folder ``out`` contains anything but an earlier report, which a new one may replace."""
    if not out.exists():
        return
    if not out.is_dir():
        raise ValueError(f"{out} is a file; give the report the name of a folder")
    entries = sorted(out.rglob("*"))
    index = out / "index.html"
    if entries and not (index.is_file() and MARKER in index.read_text(encoding="utf-8", errors="replace")):
        raise ValueError(f"{out} contains files but no rollbench report; choose another folder")
    for entry in entries:
        top = entry.relative_to(out).parts
        folder = len(top) == 1 and top[0] in _FOLDERS and entry.is_dir()
        file = len(top) == 2 and entry.is_file() and entry.suffix in _FOLDERS.get(top[0], ())
        if not (folder or file or (len(top) == 1 and _is_report_file(entry))):
            raise ValueError(f"{entry} does not belong to the earlier report and would be deleted; move it elsewhere")


def _is_report_file(entry: Path) -> bool:
    """Return whether a file belongs to a report: page, search index, manifest, checksums, PDF of releases up to 0.14."""
    if not entry.is_file():
        return False
    return entry.name in (SEARCH, MANIFEST, SUMS, "first-pages.pdf") or (
        entry.suffix == ".html" and MARKER in entry.read_text(encoding="utf-8", errors="replace")
    )


def _check_report_names(report: content.Report) -> None:
    """Raise ValueError if a name in a report occurs twice or cannot be part of a file name or link."""
    seen: set[tuple[str, str]] = {("page", "index")}
    for page in report.pages:
        if not _NAME.fullmatch(page.name) or ("page", page.name) in seen:
            raise ValueError(f"name {page.name!r} of a report page is not a valid file name or is used twice")
        seen.add(("page", page.name))
    for section in report.sections:
        items = [item for item in section.items if not isinstance(item, content.Text)]
        named = [("table" if isinstance(item, content.Table) else "figure", item.name) for item in items]
        if section.summary:
            named.append(("figure", section.summary.figure.name))
        for kind, name in [("section", section.name), *named]:
            if not _NAME.fullmatch(name):
                raise ValueError(f"{kind} name {name!r} in the report: use letters, digits, dot, dash and underscore only")
            if (kind, name.lower()) in seen:
                raise ValueError(f"{kind} name {name!r} is used twice in the report; choose another name")
            seen.add((kind, name.lower()))


def _swap_folders(fresh: Path, out: Path) -> None:
    """Replace the folder ``out`` by the folder ``fresh``; if that fails, restore the old one and raise an error."""
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
            reason = f"the folder {out} cannot be replaced ({error.strerror}); choose a folder inside it"
            raise ValueError(reason) from error
        raise
    shutil.rmtree(old, ignore_errors=True)
