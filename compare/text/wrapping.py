"""Lines wrapped, and tables taken apart, to the width of a terminal."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Column, Table

#: Width below which lines are not wrapped, and that of a column whose words may be broken.
LEAST, FOLDED = 40, 8
#: A command at the end of a line, to be copied.
COMMAND = re.compile(
    r"(?<= )(rollbench (solve .*--condensed|check SCENE --loads) (\S*'.*'|\S+)|(apt-get|pip) install [\w .+-]+)$"
)


def wrapped(text: str, width: int) -> str:
    """A text whose lines are wrapped at words; what follows stands below the text behind a label, or is indented by two.
    Paths, and a command at the end, stay whole, so that they can be copied.

    >>> print(wrapped("ok    a sentence that is too long for a terminal of forty", 40))
    ok    a sentence that is too long for a
          terminal of forty
    """
    return "\n".join(_wrapped(line, max(width, LEAST)) for line in text.split("\n"))


def _wrapped(line: str, width: int) -> str:
    if len(line) <= width:
        return line
    label = re.match(r" *\S+  +(?=\S)", line)
    indent = len(label[0]) if label and len(label[0]) <= width // 2 else len(line) - len(line.lstrip()) + 2
    command = COMMAND.search(line)
    words = line if command is None else line[: command.start()]
    options = {"subsequent_indent": " " * indent, "break_on_hyphens": False, "break_long_words": False}
    parts = textwrap.wrap(words, width, **options)  # type: ignore[arg-type]
    return "\n".join([*parts, *([] if command is None else [" " * indent + command[0]])])


def fitted(table: Table, width: int) -> list[Table]:
    """A table of texts as one or several that are no wider than ``width``, no number cut: columns that do not fit go to a
    further one, with those that tell its rows apart repeated."""
    limits = [_limits(column, _around(table)) for column in table.columns]
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
    parts = [_part(table, [*range(keys), *group], rows, limits, width) for group in groups]
    parts[0].title, parts[-1].caption = table.title, table.caption
    return parts


def unbroken(table: Table) -> int:
    """Width at which no word is broken where ``fitted`` may break it: such columns are no longer wrapped, others at 40."""
    widths = []
    for column in table.columns:
        column.no_wrap = column.no_wrap or column.overflow == "fold"
        least, natural = _limits(replace(column, overflow="ellipsis"), _around(table))
        widths.append(max(least, min(natural, LEAST)))
    return sum(widths)


def _around(table: Table) -> int:
    """What a column takes beside its words: padding and rule."""
    _, right, _, left = table.padding
    return int(left) + int(right) + (table.box is not None)


def _limits(column: Column, around: int) -> tuple[int, int]:
    """Width of a column below which its words are cut, and that at which none of its texts is wrapped."""
    texts = [str(column.header), *map(str, column.cells)]
    natural = max(map(len, texts))
    least = natural if column.no_wrap else max((len(word) for text in texts for word in text.split()), default=0)
    return (min(least, FOLDED) if column.overflow == "fold" else least) + around, natural + around


def _part(
    table: Table, columns: Sequence[int], rows: Sequence[tuple[str, ...]], limits: Sequence[tuple[int, int]], width: int
) -> Table:
    """Some columns of a table, each as wide as its words need, the widest texts given what is left of the width."""
    from rich.table import Table as Made

    wide = [limits[k][0] for k in columns]
    for _ in range(width - 1 - sum(wide)):
        at = max(range(len(wide)), key=lambda n: limits[columns[n]][1] - wide[n])
        wide[at] += limits[columns[at]][1] > wide[at]
    heads = [replace(table.columns[k].copy(), width=w - _around(table)) for k, w in zip(columns, wide, strict=True)]
    out = Made(*heads, title_justify="left", box=table.box, padding=table.padding, pad_edge=table.pad_edge)
    for row in rows:
        out.add_row(*(row[k] for k in columns))
    return out
