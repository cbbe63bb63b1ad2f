"""The first two pages of a report as a PDF: question, answer and figure; then the table and what limits it.

Set by typst, which is a wheel of its own; a report without it is written without this file.
"""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rollbench.meshes.libraries import EXTRAS
from rollbench.reports.cells import filled, format_cell, is_number, typeset
from rollbench.reports.content import Report, Summary, Table

#: Name of the file in the folder of a report.
FILE = "first-pages.pdf"
#: What installs typst.
REMEDY = EXTRAS["typst"][1]
_TEMPLATE = "first_pages.typ"


def write_first_pages(report: Report, summary: Summary, figure: str, folder: Path) -> None:
    """Write the PDF into ``folder``; figure: the summary's figure as an SVG document.

    Raises ImportError where typst is not installed, RuntimeError where it refuses the document.
    """
    import typst
    from matplotlib import get_data_path

    template = resources.files("rollbench.reports").joinpath("templates", _TEMPLATE).read_bytes()
    with TemporaryDirectory() as place:
        root = Path(place)
        (root / _TEMPLATE).write_bytes(template)
        (root / "figure.svg").write_text(figure, encoding="utf-8")
        typst.compile(
            root / _TEMPLATE,
            output=folder / FILE,
            root=root,
            font_paths=[Path(get_data_path(), "fonts", "ttf")],
            sys_inputs={"data": json.dumps(_data(report, summary))},
        )


def _data(report: Report, summary: Summary) -> dict[str, Any]:
    """Data of the template."""
    table = summary.table or Table("", "", (), ())
    columns, _ = filled(table)
    facts = report.provenance
    origin = [f"{name} {facts[name]}" for name in ("rollbench", "date") if name in facts]
    return {
        "title": report.title,
        "origin": ", ".join(origin) or report.title,
        "question": typeset(summary.question),
        "answer": typeset(summary.answer),
        "caption": typeset(f"{summary.figure.title}. {summary.figure.caption}"),
        "coverage": [typeset(line) for line in summary.coverage],
        "limits": [typeset(line) for line in summary.limits],
        "table": typeset(table.title),
        "note": typeset(table.note),
        "columns": [
            {"label": typeset(c.label), "unit": f"[{typeset(c.unit)}]" if c.unit else "", "number": is_number(c, table)}
            for c in columns
        ],
        "rows": [[typeset(format_cell(row.get(c.key), c.format)) for c in columns] for row in table.rows],
    }
