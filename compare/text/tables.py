"""Tables with a title and rules, for the terminal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rollbench.compare.text.printing import Column, cell

if TYPE_CHECKING:
    from rich.table import Table


def ruled(title: str, headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str] = ()) -> Table:
    """Texts as a table with a title and rules, flush right but for the columns whose headings are ``left``."""
    return _filled(headings, rows, left, title=title)


def plain(headings: Sequence[str], rows: Iterable[Iterable[str]], left: Collection[str] = (), *, apart: int = 1) -> Table:
    """Texts as a table without rules, ``apart`` columns from one another, none wrapped; for the rest see `ruled`."""
    out = _filled(headings, rows, left, box=None, pad_edge=False, padding=(0, apart, 0, 0))
    for column in out.columns:
        column.no_wrap = True
    return out


def aligned(rows: Sequence[Mapping[str, Any]], digits: str = ".4g", title: str | None = None) -> Table:
    """Rows as a table without rules, numbers flush right; no column without a value."""
    kept = {k: k.replace("_", " ").replace("percent", "%") for k in rows[0] if any(row[k] is not None for row in rows)}
    left = [heading for key, heading in kept.items() if isinstance(rows[0][key], str)]
    texts = ([cell(row[k], digits if isinstance(row[k], float) else "s") for k in kept] for row in rows)
    return _filled(kept.values(), texts, left, title=title, box=None, pad_edge=False, padding=(0, 1, 0, 0))


def _filled(headings: Iterable[str], rows: Iterable[Iterable[str]], left: Collection[str], **look: Any) -> Table:
    from rich.table import Table as Made

    out = Made(title_justify="left", **look)
    for heading in headings:
        out.add_column(heading, justify="left" if heading in left else "right")
    for row in rows:
        out.add_row(*row)
    return out


def listed(title: str, columns: Sequence[Column], rows: Iterable[Mapping[str, Any]]) -> Table:
    """Rows as a table with a title and rules; columns: key of the row, heading, format."""
    texts = ([cell(row[name], form) for name, _, form in columns] for row in rows)
    return ruled(title, [heading for _, heading, _ in columns], texts)
