"""What every source's section of the report is held to: rows as the entries are filed, figures that can be drawn."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from rollbench.compare.printed import load_table
from rollbench.reports.content import Figure, Section, Table
from rollbench.reports.figures import draw


def tables(section: Section) -> dict[str, Table]:
    """Tables of a section by name."""
    return {item.name: item for item in section.items if isinstance(item, Table)}


def figures(section: Section) -> list[Figure]:
    """Figures of a section."""
    return [item for item in section.items if isinstance(item, Figure)]


def shows_entries(table: Table, name: str) -> None:
    """A table has a row for every entry of a printed one, with class, verdict and number; inputs are a note."""
    judged = [p for p in load_table(name) if p.kind != "input" or p.cls == "open"]
    given = len(load_table(name)) - len(judged)
    assert not given or f"Inputs, {given} of them" in table.note
    for row, printed in zip(table.rows, judged, strict=True):
        assert set(row) == {c.key for c in table.columns}
        assert (row["class"], row["printed"]) == (printed.cls, printed.printed or "–")
        assert row["verdict"]


def drawn(shown: Iterable[Figure], finite: float = 1.0) -> None:
    """Figures with data, of whose values at least the share ``finite`` is finite, and that can be drawn."""
    for figure in shown:
        assert 1 <= len(figure.panels) <= 6
        series: list[Any] = [s for panel in figure.panels for s in panel.series]
        assert series
        for one in series:
            assert len(one.x) == len(one.y) >= 1
            assert np.isfinite(one.y).mean() >= finite
        assert draw(figure).startswith("<?xml")
