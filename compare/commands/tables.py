"""Tables with a title and rules, for the terminal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rollbench.comparison.commands.printing import Column, cell

if TYPE_CHECKING:
    from rich.table import Table


def ruled(title: str, headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str] = ()) -> Table:
    """Texts as a table with a title and rules, flush right but for the columns whose headings are ``left``."""
    from rich.table import Table as Made

    out = Made(title=title, title_justify="left")
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left else "right")
    for row in rows:
        out.add_row(*row)
    return out


def listed(title: str, columns: Sequence[Column], rows: Iterable[Mapping[str, Any]]) -> Table:
    """Rows as a table with a title and rules; columns: key of the row, heading, format."""
    texts = ([cell(row[name], form) for name, _, form in columns] for row in rows)
    return ruled(title, [heading for _, heading, _ in columns], texts)
