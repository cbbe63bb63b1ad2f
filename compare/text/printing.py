"""Output of a command: text and tables that fit the width of the terminal, or one JSON value."""

from __future__ import annotations

import json
import re
import shutil
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rollbench.compare.errors import escape_unprintable
from rollbench.compare.quantities import format_range
from rollbench.compare.results.base import format_table_as_text
from rollbench.compare.running import clear_progress_line


@dataclass(frozen=True)
class CommandOutput:
    """Output of a command, as texts and tables or as JSON, with its exit code.

    data: value to print as JSON, or a function that returns it, which is called only for JSON output. texts_and_tables:
    texts and tables (`TextTable`) to print otherwise, in this order. wrap_always: whether texts are wrapped to
    `text_width` even if the output is no terminal.
    """

    data: Any = None
    texts_and_tables: Iterable[Any] = ()
    exit_code: int = 0
    wrap_always: bool = False


def print_command_output(answer: CommandOutput, as_json: bool = False) -> int:
    """Print the output of a command on standard output, and return its exit code.

    ``answer``: the output; ``as_json``: whether its data are printed as JSON, instead of its texts and tables. Raises
    StandardOutputError if standard output cannot be written.
    """
    clear_progress_line()
    if as_json:
        print_json(answer.data() if callable(answer.data) else answer.data)
    else:
        _print_parts(answer.texts_and_tables, folded=answer.wrap_always)
    return answer.exit_code


class StandardOutputError(Exception):
    """Error for a standard output that cannot be written, because the disc is full or the output is closed."""


@contextmanager
def guard_standard_output() -> Iterator[None]:
    """Raise StandardOutputError if the ``with`` block cannot write to standard output.

    A pipe whose reader has ended still raises BrokenPipeError.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise StandardOutputError(error.strerror or str(error)) from error


def print_json(value: Any) -> None:
    """Print one JSON value on standard output, with an indent of two.

    Raises ValueError for a number that is not finite, StandardOutputError if standard output cannot be written.
    """
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with guard_standard_output():
        sys.stdout.write(text)


def _print_parts(parts: Iterable[Any], *, folded: bool) -> None:
    """Print texts and tables, wrapped to the width of the terminal.

    If the output is no terminal, texts are not wrapped unless ``folded``, and tables are as wide as they need.
    """
    terminal = sys.stdout.isatty()
    for part in parts:
        if isinstance(part, TextTable):
            text = part.text(text_width() if terminal else None)
        else:
            text = wrap_lines(part, text_width()) if folded or terminal else part
        text = "\n".join(map(escape_unprintable, text.split("\n")))  # file names may contain control characters
        with guard_standard_output():
            print(text)


def text_width() -> int:
    """Return the width to which texts are wrapped [characters]: the width of the terminal, or 100 without one."""
    return shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else 100


def format_cell(value: Any, number_format: str) -> str:
    """Format a value as the text of a table cell; a number that is rounded to zero gets no minus sign.

    ``number_format``: number format of Python, such as ".2f"; "s" for text. None becomes a dash, and a boolean "yes" or
    "no".

    Examples
    --------
    >>> [format_cell(-0.001, form) for form in (".2f", "+.2f", ".2g")], format_cell(-3, "d"), format_cell(None, "s")
    (['0.00', '+0.00', '-0.001'], '-3', '–')
    """
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if number_format == "s" or not isinstance(value, float):
        return str(value) if number_format == "s" else format(value, number_format)
    sign = number_format[:1] if number_format[:1] in "+- " else ""
    return format(value, f"{sign}z{number_format.removeprefix(sign)}")


#: Smallest width to which lines are wrapped [characters].
LEAST = 40

#: Pattern of a command at the end of a line, which must stay on one line so that users can copy it.
COMMAND = re.compile(
    r"(?<= )(rollbench (solve .*--condensed|check SCENE --loads) (\S*'.*'|\S+)|(apt-get|pip) install [\w .+-]+)$"
)


def wrap_lines(text: str, width: int) -> str:
    """Wrap the lines of a text at words, to a width in characters.

    Continuation lines are indented by two, or as far as the text after a label. Paths, and a command at the end of a line,
    are not broken, so that users can copy them.

    Examples
    --------
    >>> print(wrap_lines("ok    a sentence that is too long for a terminal of forty", 40))
    ok    a sentence that is too long for a
          terminal of forty
    """
    return "\n".join(_wrap_one_line(line, max(width, LEAST)) for line in text.split("\n"))


def _wrap_one_line(line: str, width: int) -> str:
    """Wrap one line at words; see `wrap_lines`."""
    if len(line) <= width:
        return line
    label = re.match(r" *\S+  +(?=\S)", line)
    indent = len(label[0]) if label and len(label[0]) <= width // 2 else len(line) - len(line.lstrip()) + 2
    command = COMMAND.search(line)
    words = line if command is None else line[: command.start()]
    options = {"subsequent_indent": " " * indent, "break_on_hyphens": False, "break_long_words": False}
    parts = textwrap.wrap(words, width, **options)  # type: ignore[arg-type]
    return "\n".join([*parts, *([] if command is None else [" " * indent + command[0]])])


@dataclass(frozen=True)
class TextTable:
    """Table of texts that a command prints; a heading may have several lines."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    caption: str = ""

    def text(self, width: int | None = None) -> str:
        """Return the table as text, in parts that are at most ``width`` characters wide if a width is given.

        Columns that do not fit are moved to a further part, which repeats the columns that identify a row. Headings are
        broken at blanks where the width requires it, numbers never.
        """
        headings, count = self.headings, len(self.headings)
        groups, wide = [[*range(count)]], [max(map(len, column)) + 2 for column in zip(headings, *self.rows, strict=True)]
        if width is not None and sum(wide) > width + 2:
            wide = [max(map(len, (*head.split(), *cells))) + 2 for head, *cells in zip(headings, *self.rows, strict=True)]
            headings = [textwrap.fill(head, room - 2) for head, room in zip(headings, wide, strict=True)]
            keys = next((k for k in range(1, count) if len({tuple(row[:k]) for row in self.rows}) == len(self.rows)), 1)
            groups = [[*range(keys)]]
            for k in range(keys, count):
                if len(groups[-1]) > keys and sum(wide[i] for i in (*groups[-1], k)) > width + 2:
                    groups.append([*range(keys)])
                groups[-1].append(k)
        parts = (([[row[k] for k in group] for row in self.rows], [headings[k] for k in group]) for group in groups)
        tables = [format_table_as_text(rows, width or 10_000, heads) for rows, heads in parts]
        return "\n".join(filter(None, [self.title, *tables, self.caption]))


def table_of_records(rows: Sequence[Mapping[str, Any]], digits: str = ".4g", title: str = "") -> TextTable:
    """Return a table from rows of values, whose keys become the headings.

    ``digits``: number format of Python for all numbers; a list of two numbers is shown as a range. Columns without values
    are left out.
    """
    keys = dict.fromkeys(key for row in rows for key in row)
    known = [key for key in keys if any(row.get(key) is not None for row in rows)]
    texts = [[_format_record_value(row.get(key), digits) for key in known] for row in rows]
    return TextTable([key.replace("_", " ").replace("percent", "%") for key in known], texts, title)


def _format_record_value(value: Any, digits: str) -> str:
    """Format a value of a record: a list of two numbers as a range; ``digits``: number format of a single number."""
    return (
        format_range(value) if isinstance(value, list) else format_cell(value, digits if isinstance(value, float) else "s")
    )
