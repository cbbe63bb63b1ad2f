"""A report as one self-contained HTML file, with its tables as CSV and its figures as files in the same folder."""

from __future__ import annotations

import base64
import csv
import math
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from meshes.leftovers import temporary
from reports import field3d, figures, scene3d
from reports.records import Cell, Column, FieldPicture, Figure, LoadedScrew, PressureMap, Report, Table, Text

#: Characters of a text from which its column is made wide.
LONG = 90
#: What marks a directory's ``index.html`` as written by :func:`write`, and the directory as its to replace.
MARKER = '<meta name="generator" content="rollbench">'

Progress = Callable[[str], None]
Item = Text | Table | Figure | LoadedScrew | FieldPicture | PressureMap

_KNOWN = {"index.html": (), "tables": (".csv",), "figures": (".svg", ".png")}
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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
        page = _page(report, fresh, say)
        (fresh / "index.html").write_text(page, encoding="utf-8", newline="\n")
        _swap(fresh, out)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return out / "index.html"


def write_csv(table: Table, path: Path) -> None:
    """Write a table as CSV (RFC 4180): header ``label [unit]``, numbers in full, ``None`` as nothing."""
    with open(path, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(harmless(f"{c.label} [{c.unit}]" if c.unit else c.label) for c in table.columns)
        writer.writerows([_csv_cell(row.get(c.key)) for c in table.columns] for row in table.rows)


def format_cell(value: Cell, form: str = "g4") -> str:
    """Text of a cell for reading.

    Args:
        value: ``None`` becomes a dash, booleans yes or no; whole numbers given as integers keep all digits.
        form: ``"g4"`` for four significant digits (any number after the g), ``"s"`` for text as it is, or a
            format specification of Python such as ``".2f"``.

    >>> format_cell(225.0), format_cell(1.5e-7), format_cell(-3.14159, ".2f"), format_cell(None)
    ('225.0', '1.500×10⁻⁷', '−3.14', '–')
    """
    value = _plain(value)
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "n/a" if math.isnan(value) else "∞" if value > 0.0 else "−∞"
    if form == "s":
        text = str(value)
    elif re.fullmatch(r"g\d+", form):
        text = str(value) if isinstance(value, int) else _significant(value, int(form[1:]))
    else:
        text = format(value, form)
    return text.replace("-", "−") if "×" not in text else text


def _significant(value: float, digits: int) -> str:
    """``value`` to so many significant digits; a power of ten below 0.001 and from a million on."""
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < max(digits, 6):
        return f"{value:.{max(digits - 1 - power, 0)}f}"
    return mantissa.replace("-", "−") + "×10" + str(power).translate(_SUPERSCRIPT)


def _plain(value: Any) -> Any:
    """A scalar of numpy as Python's own."""
    return value.item() if hasattr(value, "item") else value


def _csv_cell(value: Cell) -> str:
    """Text of a cell for machines."""
    value = _plain(value)
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else harmless(str(value))


def harmless(text: str) -> str:
    """Text of a CSV cell with an apostrophe before what a spreadsheet would run as a formula.

    >>> harmless("=1+1"), harmless("-3.5"), harmless("+ nut")
    ("'=1+1", '-3.5', "'+ nut")
    """
    number = re.fullmatch(r"[+-]?[0-9.]+([eE][+-]?[0-9]+)?( [%\w/]+)?", text)
    return f"'{text}" if text[:1] in tuple("=+-@\t\r") and not number else text


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
        folder = len(top) == 1 and (entry.is_dir() if top[0] != "index.html" else entry.is_file())
        file = len(top) == 2 and entry.is_file() and entry.suffix in _KNOWN.get(top[0], ())
        if top[0] not in _KNOWN or not (folder or file):
            raise ValueError(f"{entry} was not written by a report and would be lost; move it elsewhere first")


def _check_names(report: Report) -> None:
    """Names become files and anchors: refuse unfit ones and repeated ones."""
    seen: set[tuple[str, str]] = set()
    for section in report.sections:
        items = [item for item in section.items if not isinstance(item, Text)]
        named = [("table" if isinstance(item, Table) else "figure", item.name) for item in items]
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


@dataclass
class _Counter:
    """Running numbers of figures and tables."""

    figures: int = 0
    tables: int = 0


def _page(report: Report, folder: Path, say: Progress) -> str:
    """Draw everything, write the files of tables and figures into ``folder``, and return the page."""
    environment = Environment(
        loader=PackageLoader("reports"), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    counter = _Counter()
    sections = []
    for number, section in enumerate(report.sections, start=1):
        say(f"report: {number}/{len(report.sections)} {section.title}")
        items = [_item(item, folder, counter, say) for item in section.items]
        sections.append({"number": number, "name": section.name, "title": section.title, "items": items})
    template = environment.get_template("report.html.j2")
    return template.render(report=report, sections=sections, marker=Markup(MARKER))


def _item(item: Item, folder: Path, counter: _Counter, say: Progress) -> dict[str, Any]:
    """What the template needs for one item; writes the item's file."""
    if isinstance(item, Text):
        return {"kind": "text", "text": item}
    if isinstance(item, Table):
        counter.tables += 1
        write_csv(item, folder / "tables" / f"{item.name}.csv")
        return {"kind": "table", "table": item, "number": counter.tables, "rows": list(_rows(item))}
    counter.figures += 1
    view: dict[str, Any] = {"kind": "figure", "figure": item, "number": counter.figures}
    view |= {"file": None, "svg": None, "png": None, "missing": None}
    if isinstance(item, Figure | PressureMap):
        svg = figures.draw(item) if isinstance(item, Figure) else figures.draw_map(item)
        (folder / "figures" / f"{item.name}.svg").write_text(svg, encoding="utf-8", newline="\n")
        return {**view, "file": f"figures/{item.name}.svg", "svg": _inline(svg)}
    path = folder / "figures" / f"{item.name}.png"
    try:
        if isinstance(item, LoadedScrew):
            scene3d.draw_loaded_screw(item, path)
        else:
            field3d.draw_field(item, path)
    except RuntimeError as error:
        path.unlink(missing_ok=True)
        say(f"report: picture left out. {error}")
        return {**view, "missing": str(error)}
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return {**view, "file": f"figures/{item.name}.png", "png": data}


def _inline(svg: str) -> Markup:
    """An SVG document as an element of the page: without prologue, metadata and title of its own."""
    body = svg[svg.index("<svg") :]
    return Markup(re.sub(r"\s*<(metadata|title)>.*?</\1>", "", body, flags=re.DOTALL))


def _rows(table: Table) -> Iterator[list[dict[str, str]]]:
    """Cells of a table: text, and the classes that set it."""
    for row in table.rows:
        yield [_cell(column, row.get(column.key)) for column in table.columns]


def _cell(column: Column, value: Cell) -> dict[str, str]:
    """Text and style of one cell; ``mark`` is the kind of tag or verdict, empty for plain cells."""
    text = format_cell(value, column.format)
    align = "num" if column.format != "s" else "text long" if len(text) > LONG else "text"
    mark = ""
    if column.key == "class" and value is not None:
        mark = "tag tag-" + (text if text in ("hard", "as-printed", "band", "open", "input") else "other")
    elif column.key == "verdict" and value is not None:
        mark = "verdict verdict-" + _verdict(text)
    return {"text": text, "align": f"{align} marked" if mark else align, "mark": mark}


def _verdict(text: str) -> str:
    """``good``, ``bad``, ``open`` or ``other``, by the first word of a verdict."""
    first = re.split(r"\W", text.strip().lower(), maxsplit=1)[0]
    kinds = {
        "good": ("reproduced", "within", "converged", "agrees", "passed", "yes"),
        "bad": ("not", "no", "failed", "fails", "diverged", "differs"),
        "open": ("open", "partly", "mechanism"),
    }
    return next((kind for kind, words in kinds.items() if first in words), "other")
