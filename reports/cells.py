"""Convert the values of table cells to text, for web pages and CSV files, and choose the alignment of columns."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.reports.content import Cell, Table, TableColumn

#: Number of characters above which a cell's text gets a wide column, and up to which it is kept on one line ("31 SL").
LONG, SHORT = 90, 9
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_NUMBER = re.compile(r"[+−-]?\d[\d., ]*(?:[eE][+-]?\d+)?")


def write_csv(table: Table, path: Path) -> None:
    """Write a table to a CSV file (RFC 4180).

    The heading of a column is ``label [unit]``. Numbers are written with ten digits, and ``None`` as an empty cell.

    Parameters
    ----------
    table
        Table to write.
    path
        CSV file to write.
    """
    with open(path, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        heads = (f"{c.label} [{replace_um_by_micrometre(c.unit)}]" if c.unit else c.label for c in table.heads.values())
        writer.writerow(escape_formula(head) for head in heads)
        writer.writerows(map(_format_csv_cell, cells) for cells in zip(*table.columns.values(), strict=True))


def format_cell(value: Cell, number_format: str = "g4") -> str:
    """Return the value of a table cell as text for a web page.

    Parameters
    ----------
    value
        Value of the cell. ``None`` becomes a dash, a boolean "yes" or "no", and an integer is written with all digits.
    number_format
        Number format: ``"g4"`` for four significant digits (or another number after the g), ``"s"`` for text that is not
        changed, or a format specification of Python such as ``".2f"``.

    Returns
    -------
    str
        Text of the cell, with typographic minus and powers of ten.

    Examples
    --------
    >>> format_cell(225.0), format_cell(1.5e-7), format_cell(-3.14159, ".2f"), format_cell(None)
    ('225.0', '1.500×10⁻⁷', '−3.14', '–')
    """
    value = _python_number(value)
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if not math.isfinite(value):
        return "n/a" if math.isnan(value) else "∞" if value > 0.0 else "−∞"
    if number_format == "s":
        text = str(value)
    elif re.fullmatch(r"g\d+", number_format):
        text = str(value) if isinstance(value, int) else _significant_digits(value, int(number_format[1:]))
    else:
        text = format(value, number_format)
    if text[:1] in ("-", "+") and not re.search("[1-9]", text):
        text = text[1:]  # a rounded zero has no sign
    return text.replace("-", "−") if "×" not in text else text


def _significant_digits(value: float, digits: int) -> str:
    """Return a number as text with ``digits`` significant digits; a very small or large number with a power of ten."""
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < max(digits, 6):
        return f"{value:.{max(digits - 1 - power, 0)}f}"
    return mantissa.replace("-", "−") + "×10" + str(power).translate(_SUPERSCRIPT)


def _python_number(value: Any) -> Any:
    """Return the Python number of a numpy scalar, and any other value unchanged."""
    return value.item() if hasattr(value, "item") else value


def _format_csv_cell(value: Cell) -> str:
    """Return the value of a table cell as text for a CSV file: ten digits, ``true`` or ``false``, empty for None."""
    value = _python_number(value)
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(f"{value:.10g}")) if isinstance(value, float) else escape_formula(str(value))


def escape_formula(text: str) -> str:
    """Return the text of a CSV cell, with an apostrophe in front if a spreadsheet would otherwise run it as a formula.

    Examples
    --------
    >>> escape_formula("=1+1"), escape_formula("-3.5"), escape_formula("+ nut")
    ("'=1+1", '-3.5', "'+ nut")
    """
    number = re.fullmatch(r"[+-]?[0-9.]+([eE][+-]?[0-9]+)?( [%\w/]+){0,2}", text)
    return f"'{text}" if text[:1] in tuple("=+-@\t\r") and not number else text


def replace_um_by_micrometre(text: str) -> str:
    """Return a text in which the unit "um" is replaced by "µm".

    Examples
    --------
    >>> replace_um_by_micrometre("2 um larger, in N/um; the sum")
    '2 µm larger, in N/µm; the sum'
    """
    return re.sub(r"\bum\b", "µm", text)


def with_typographic_signs(text: str) -> str:
    """Return a text with typographic signs for a web page: µm for um, − for a minus, ± for +-, a no-break space before %.

    Examples
    --------
    >>> with_typographic_signs("-0.3 to 5 um, +-2 N")
    '−0.3 to 5 µm, ±2 N'
    """
    text = re.sub(r"(?<![^\s(=])-(?=\d)", "−", replace_um_by_micrometre(text).replace("+-", "±"))
    return re.sub(r"(?<=\d) ?%", "\xa0%", text)


def is_number_column(column: TableColumn, cells: Sequence[Cell]) -> bool:
    """Return whether all non-empty cells of a table column are numbers; such a column is right-aligned."""
    if column.format != "s":
        return True
    filled = [str(cell) for cell in map(_python_number, cells) if cell not in (None, "", "–")]
    return bool(filled) and all(map(_NUMBER.fullmatch, filled))


def is_empty_cell(value: Cell) -> bool:
    """Return whether a table cell has no value."""
    return _python_number(value) in (None, "")


def cell_text_and_css_classes(column: TableColumn, value: Cell, *, right_aligned: bool) -> dict[str, str]:
    """Return the text of a table cell and its CSS classes: ``align`` for the alignment, ``mark`` for a coloured label.

    Only cells of columns with a mark have a label. ``right_aligned``: whether the column contains numbers, which are
    right-aligned.
    """
    text = format_cell(value, column.format)
    align = "num" if right_aligned else "text long" if len(text) > LONG else "text short" if len(text) <= SHORT else "text"
    mark = ""
    if column.mark == "class" and value is not None:
        mark = "tag tag-" + (text if text in ("hard", "as-printed", "band", "open", "input") else "other")
    elif column.mark == "verdict" and value is not None:
        mark = "verdict verdict-" + colour_class_of_verdict(text)
    return {"text": text, "align": f"{align} marked" if mark else align, "mark": mark}


def colour_class_of_verdict(text: str) -> str:
    """Return the colour class of a verdict, such as "reproduced" or "contradicted", by the first word of the verdict.

    The classes are ``good``, ``bad``, ``open`` and ``other``.
    """
    if text == "not identifiable" or text.startswith("not determined"):
        return "open"
    first = re.split(r"\W", text.strip().lower(), maxsplit=1)[0]
    kinds = {
        "good": ("reproduced", "band", "in", "within", "converged", "agrees", "passed", "reached", "yes"),
        "bad": ("contradicted", "not", "no", "above", "below", "failed", "fails", "diverged", "differs", "beyond"),
        "open": ("open", "partly", "mechanism"),
    }
    return next((kind for kind, words in kinds.items() if first in words), "other")
