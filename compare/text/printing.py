"""The answer of a command, and its output: text and tables as wide as the terminal, or one JSON value."""

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

from rollbench.compare.errors import escaped
from rollbench.compare.running import clear_progress_line

if TYPE_CHECKING:
    from rich.table import Column as RichColumn
    from rich.table import Table


#: A column of a table on the terminal: key of the row, heading, format.
Column = tuple[str, str, str]


@dataclass(frozen=True)
class Answer:
    """What a command prints.

    data: JSON-ready value, or a function that returns it, called only for JSON; parts: texts and tables of rich,
    printed in this order; code: exit code; folded: whether texts are wrapped to `text_width` even without a terminal.
    """

    data: Any = None
    parts: Iterable[Any] = ()
    code: int = 0
    folded: bool = False


def print_answer(answer: Answer, as_json: bool = False) -> int:
    """Print an answer on standard output and return its exit code. Raises OutputLost."""
    clear_progress_line()
    if as_json:
        print_json(answer.data() if callable(answer.data) else answer.data)
    else:
        _print_parts(answer.parts, folded=answer.folded)
    return answer.code


class OutputLost(Exception):
    """Standard output cannot be written: disc full, or closed."""


@contextmanager
def guard_standard_output() -> Iterator[None]:
    """Raise OutputLost for a failure to write to standard output, except for a pipe without reader."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputLost(error.strerror or str(error)) from error


def print_json(value: Any) -> None:
    """Print one JSON value on standard output. Raises ValueError for a number that is not finite, OutputLost."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with guard_standard_output():
        sys.stdout.write(text)


def _print_parts(parts: Iterable[Any], *, folded: bool) -> None:
    """Print texts and tables, at the width of a terminal if there is one.

    Elsewhere texts are printed as they are unless ``folded``, and tables without rules, 160 columns wide or wider if a
    word needs it.
    """
    terminal = sys.stdout.isatty()
    for part in parts:
        if not isinstance(part, str):
            _show_table(part, terminal)
            continue
        text = wrap_lines(part, text_width()) if folded else part
        text = "\n".join(map(escaped, text.split("\n")))  # names of files
        with guard_standard_output():
            print(wrap_lines(text, text_width()) if terminal else text)


def _show_table(table: Any, terminal: bool) -> None:
    """Print a table of rich, which is imported here only."""
    from rich.console import Console

    console = Console(width=None if terminal else 160, soft_wrap=True, highlight=False, markup=False)
    tables = split_to_width(table, text_width()) if terminal else [table]
    if not terminal:
        table.box, table.pad_edge = None, False
        console.width = max(160, unbroken_width(table))
    with guard_standard_output():
        console.print(*tables, sep="\n")


def text_width() -> int:
    """Return the width of running text: that of the terminal, else 100."""
    return shutil.get_terminal_size((100, 24)).columns if sys.stdout.isatty() else 100


def cell(value: Any, form: str) -> str:
    """Return a value as text; a number rounded to zero has no minus sign.

    Examples
    --------
    >>> cell(-0.001, ".2f"), cell(-0.001, "+.2f"), cell(-0.001, ".2g"), cell(-3, "d"), cell(None, "s")
    ('0.00', '+0.00', '-0.001', '-3', '–')
    """
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if form == "s" or not isinstance(value, float):
        return str(value) if form == "s" else format(value, form)
    sign = form[:1] if form[:1] in "+- " else ""
    return format(value, f"{sign}z{form.removeprefix(sign)}")


#: Width below which lines are not wrapped, and that of a column whose words may be broken.
LEAST, FOLDED = 40, 8

#: A command at the end of a line, to be copied.
COMMAND = re.compile(
    r"(?<= )(rollbench (solve .*--condensed|check SCENE --loads) (\S*'.*'|\S+)|(apt-get|pip) install [\w .+-]+)$"
)


def wrap_lines(text: str, width: int) -> str:
    """Return a text with its lines wrapped at words.

    Continuation lines are indented to the text after a label, or by two. Paths, and a command at the end of a line, are
    not broken, so that they can be copied.

    Examples
    --------
    >>> print(wrap_lines("ok    a sentence that is too long for a terminal of forty", 40))
    ok    a sentence that is too long for a
          terminal of forty
    """
    return "\n".join(_wrap_one_line(line, max(width, LEAST)) for line in text.split("\n"))


def _wrap_one_line(line: str, width: int) -> str:
    """Return one line wrapped at words, for `wrap_lines`."""
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
    """Split a table of texts into tables no wider than ``width``, without cutting a number.

    Columns that do not fit go to a further table, which repeats the columns that identify a row.
    """
    limits = [_column_widths(column, _padding_width(table)) for column in table.columns]
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
    parts = [_table_part(table, [*range(keys), *group], rows, limits, width) for group in groups]
    parts[0].title, parts[-1].caption = table.title, table.caption
    return parts


def unbroken_width(table: Table) -> int:
    """Return the width at which no word is broken; see `split_to_width` for columns that it may break."""
    widths = []
    for column in table.columns:
        column.no_wrap = column.no_wrap or column.overflow == "fold"
        least, natural = _column_widths(replace(column, overflow="ellipsis"), _padding_width(table))
        widths.append(max(least, min(natural, LEAST)))
    return sum(widths)


def _padding_width(table: Table) -> int:
    """Return the width that a column needs in addition to its text: padding and rule."""
    _, right, _, left = table.padding
    return int(left) + int(right) + (table.box is not None)


def _column_widths(column: RichColumn, around: int) -> tuple[int, int]:
    """Return two widths of a column: below the first words are cut, from the second on no text is wrapped."""
    texts = [str(column.header), *map(str, column.cells)]
    natural = max(map(len, texts))
    least = natural if column.no_wrap else max((len(word) for text in texts for word in text.split()), default=0)
    return (min(least, FOLDED) if column.overflow == "fold" else least) + around, natural + around


def _table_part(
    table: Table, columns: Sequence[int], rows: Sequence[tuple[str, ...]], limits: Sequence[tuple[int, int]], width: int
) -> Table:
    """Return some columns of a table, each wide enough for its words; the remaining width goes to the longest texts."""
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


def ruled_table(title: str, headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str] = ()) -> Table:
    """Return texts as a table with title and rules, right-aligned but for the columns with the headings ``left``."""
    return _fill_table(headings, rows, left, title=title)


def plain_table(
    headings: Sequence[str], rows: Iterable[Iterable[str]], left: Collection[str] = (), *, apart: int = 1
) -> Table:
    """Return texts as a table without rules and without wrapping, ``apart`` blanks between columns; see `ruled_table`."""
    out = _fill_table(headings, rows, left, box=None, pad_edge=False, padding=(0, apart, 0, 0))
    for column in out.columns:
        column.no_wrap = True
    return out


def aligned_table(rows: Sequence[Mapping[str, Any]], digits: str = ".4g", title: str | None = None) -> Table:
    """Return rows as a table without rules, numbers right-aligned; columns without a value are dropped."""
    kept = {k: k.replace("_", " ").replace("percent", "%") for k in rows[0] if any(row[k] is not None for row in rows)}
    left = [heading for key, heading in kept.items() if isinstance(rows[0][key], str)]
    texts = ([cell(row[k], digits if isinstance(row[k], float) else "s") for k in kept] for row in rows)
    return _fill_table(kept.values(), texts, left, title=title, box=None, pad_edge=False, padding=(0, 1, 0, 0))


def _fill_table(headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str], **look: Any) -> Table:
    """Return a table with headings and rows; ``look``: further arguments of the table of rich."""
    from rich.table import Table as Made

    out = Made(title_justify="left", **look)
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left else "right")
    for row in rows:
        out.add_row(*row)
    return out


def listed_table(title: str, columns: Sequence[Column], rows: Iterable[Mapping[str, Any]]) -> Table:
    """Return rows as a table with title and rules; columns: key of the row, heading, format."""
    texts = ([cell(row[name], form) for name, _, form in columns] for row in rows)
    return ruled_table(title, [heading for _, heading, _ in columns], texts)
