"""Tables with a title and rules, for the terminal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rollbench.comparison.commands.printing import Column, cell

if TYPE_CHECKING:
    from rich.table import Table

    from rollbench.reports.quantity import Quantity


def ruled(title: str, headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str] = ()) -> Table:
    """Texts as a table with a title and rules, flush right but for the columns whose headings are ``left``."""
    from rich.table import Table as Made

    out = Made(title=title, title_justify="left")
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left else "right")
    for row in rows:
        out.add_row(*row)
    return out


def plain(headings: Sequence[str], rows: Iterable[Iterable[str]], left: Collection[str] = (), *, apart: int = 1) -> Table:
    """Texts as a table without rules, ``apart`` columns from one another; for the rest see `ruled`."""
    from rich.table import Table as Made

    out = Made(box=None, pad_edge=False, padding=(0, apart, 0, 0))
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left else "right", no_wrap=True)
    for row in rows:
        out.add_row(*row)
    return out


def listed(title: str, columns: Sequence[Column], rows: Iterable[Mapping[str, Any]]) -> Table:
    """Rows as a table with a title and rules; columns: key of the row, heading, format."""
    texts = ([cell(row[name], form) for name, _, form in columns] for row in rows)
    return ruled(title, [heading for _, heading, _ in columns], texts)


def told(title: str, quantities: Sequence[Quantity], found: Iterable[Any]) -> Table:
    """Quantities of records as a table with a title and rules, their sets numbered from 1."""
    rows = ([str(i), *(cell(q.value(one), q.format) for q in quantities)] for i, one in enumerate(found, 1))
    return ruled(title, ["set", *(f"{q.label} {q.unit}".strip() for q in quantities)], rows)
