"""Output of a command: text and tables that fit the width of the terminal, or one JSON value."""

from __future__ import annotations

import json
import re
import shutil
import sys
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import escape_unprintable
from rollbench.compare.quantities import format_range
from rollbench.compare.running import clear_progress_line

if TYPE_CHECKING:
    from rich.table import Column as RichColumn
    from rich.table import Table


@dataclass(frozen=True)
class CommandOutput:
    """Output of a command, as texts and tables or as JSON, with its exit code.

    data: value to print as JSON, or a function that returns it, which is called only for JSON output. texts_and_tables:
    texts and tables (of the package rich) to print otherwise, in this order. wrap_always: whether texts are wrapped to
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

    If the output is no terminal, texts are not wrapped unless ``folded``, and tables are printed without rules, at least
    160 characters wide.
    """
    terminal = sys.stdout.isatty()
    for part in parts:
        if not isinstance(part, str):
            _print_table(part, terminal)
            continue
        text = wrap_lines(part, text_width()) if folded else part
        text = "\n".join(map(escape_unprintable, text.split("\n")))  # file names may contain control characters
        with guard_standard_output():
            print(wrap_lines(text, text_width()) if terminal else text)


def _print_table(table: Any, terminal: bool) -> None:
    """Print a table of the package rich; on a terminal, it is split into tables that fit the width.

    ``terminal``: whether standard output is a terminal.
    """
    from rich.console import Console

    console = Console(width=None if terminal else 160, soft_wrap=True, highlight=False, markup=False)
    tables = split_to_width(table, text_width()) if terminal else [table]
    if not terminal:
        table.box, table.pad_edge = None, False
        console.width = max(160, table_width_without_breaks(table))
    with guard_standard_output():
        console.print(*tables, sep="\n")


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


#: Smallest width to which lines are wrapped, and width of a column in which words may be broken [characters].
LEAST, FOLDED = 40, 8

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


def split_to_width(table: Table, width: int) -> list[Table]:
    """Split a table of texts into tables that are at most ``width`` characters wide, without breaking a number.

    Columns that do not fit are moved to a further table, which repeats the columns that identify a row.
    """
    limits = [_smallest_and_full_width(column, _padding_width(table)) for column in table.columns]
    if sum(natural for _, natural in limits) + 1 <= width:
        return [table]
    rows = list(zip(*([str(cell) for cell in column.cells] for column in table.columns), strict=True))
    keys = next((k for k in range(1, len(limits)) if len({row[:k] for row in rows}) == len(rows)), 1)
    room = width - 1 - sum(least for least, _ in limits[:keys])
    groups: list[list[int]] = [[]]
    for k in range(keys, len(limits)):
        if groups[-1] and sum(limits[i][0] for i in groups[-1]) + limits[k][0] > room:
            groups.append([])
        groups[-1].append(k)
    parts = [_table_of_columns(table, [*range(keys), *group], rows, limits, width) for group in groups]
    parts[0].title, parts[-1].caption = table.title, table.caption
    return parts


def table_width_without_breaks(table: Table) -> int:
    """Return the width [characters] that a table needs so that no word is broken."""
    widths = []
    for column in table.columns:
        column.no_wrap = column.no_wrap or column.overflow == "fold"
        least, natural = _smallest_and_full_width(replace(column, overflow="ellipsis"), _padding_width(table))
        widths.append(max(least, min(natural, LEAST)))
    return sum(widths)


def _padding_width(table: Table) -> int:
    """Return the width [characters] that padding and vertical rule add to each column."""
    _, right, _, left = table.padding
    return int(left) + int(right) + (table.box is not None)


def _smallest_and_full_width(column: RichColumn, around: int) -> tuple[int, int]:
    """Return the smallest width of a table column that breaks no word, and the width at which no text is wrapped.

    ``around``: width of padding and rule, which is added to both [characters].
    """
    texts = [str(column.header), *map(str, column.cells)]
    natural = max(map(len, texts))
    least = natural if column.no_wrap else max((len(word) for text in texts for word in text.split()), default=0)
    return (min(least, FOLDED) if column.overflow == "fold" else least) + around, natural + around


def _table_of_columns(
    table: Table, columns: Sequence[int], rows: Sequence[tuple[str, ...]], limits: Sequence[tuple[int, int]], width: int
) -> Table:
    """Return a table with some columns of another table, at most ``width`` characters wide.

    ``columns``: numbers of these columns, from 0. ``rows``: texts of all rows of the other table. ``limits``: for each of
    its columns, the smallest width that breaks no word and the width at which no text is wrapped. The width that remains is
    given to the columns with the longest texts.
    """
    from rich.table import Table as Made

    wide = [limits[k][0] for k in columns]
    for _ in range(width - 1 - sum(wide)):
        at = max(range(len(wide)), key=lambda n: limits[columns[n]][1] - wide[n])
        wide[at] += limits[columns[at]][1] > wide[at]
    headings = [
        replace(table.columns[k].copy(), width=w - _padding_width(table)) for k, w in zip(columns, wide, strict=True)
    ]
    out = Made(*headings, title_justify="left", box=table.box, padding=table.padding, pad_edge=table.pad_edge)
    for row in rows:
        out.add_row(*(row[k] for k in columns))
    return out


def ruled_table(
    title: str, headings: Iterable[str], rows: Iterable[Iterable[str]], left_aligned: Collection[str] = ()
) -> Table:
    """Return a table of texts with title and rules.

    Columns are right-aligned, except those with the headings ``left_aligned``.
    """
    return _new_table(headings, rows, left_aligned, title=title)


def plain_table(
    headings: Sequence[str], rows: Iterable[Iterable[str]], left_aligned: Collection[str] = (), *, blanks: int = 1
) -> Table:
    """Return a table of texts without rules and without wrapping, with ``blanks`` spaces between columns.

    Columns are right-aligned, except those with the headings ``left_aligned``.
    """
    out = _new_table(headings, rows, left_aligned, box=None, pad_edge=False, padding=(0, blanks, 0, 0))
    for column in out.columns:
        column.no_wrap = True
    return out


def table_of_records(rows: Sequence[Mapping[str, Any]], digits: str = ".4g", title: str | None = None) -> Table:
    """Return a table without rules from rows of values, whose keys become the headings.

    ``digits``: number format of Python for all numbers; a list of two numbers is shown as a range. ``title``: title of the
    table; None: no title. Columns without values are left out; columns of texts are left-aligned.
    """
    keys = dict.fromkeys(key for row in rows for key in row)
    known = [key for key in keys if any(row.get(key) is not None for row in rows)]
    kept = {key: key.replace("_", " ").replace("percent", "%") for key in known}
    left = [heading for key, heading in kept.items() if isinstance(rows[0].get(key), str)]
    texts = ([_format_record_value(row.get(key), digits) for key in kept] for row in rows)
    return _new_table(kept.values(), texts, left, title=title, box=None, pad_edge=False, padding=(0, 1, 0, 0))


def _format_record_value(value: Any, digits: str) -> str:
    """Format a value of a record: a list of two numbers as a range; ``digits``: number format of a single number."""
    return (
        format_range(value) if isinstance(value, list) else format_cell(value, digits if isinstance(value, float) else "s")
    )


def _new_table(headings: Iterable[str], rows: Iterable[Iterable[str]], left_aligned: Collection[str], **look: Any) -> Table:
    """Return a table with headings and rows of texts; ``look``: further arguments for the table class of rich."""
    from rich.table import Table as Made

    out = Made(title_justify="left", **look)
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left_aligned else "right")
    for row in rows:
        out.add_row(*row)
    return out
