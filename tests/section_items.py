"""What every source's section of the report is held to: figures that can be drawn."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from rollbench.reports.content import Figure, Section, Table
from rollbench.reports.figures import draw_figure


def tables(section: Section) -> dict[str, Table]:
    """Tables of a section by name."""
    return {item.name: item for item in section.items if isinstance(item, Table)}


def figures(section: Section) -> list[Figure]:
    """Figures of a section."""
    return [item for item in section.items if isinstance(item, Figure)]


def drawn(shown: Iterable[Figure], finite: float = 1.0) -> None:
    """Figures with data, of whose values at least the share ``finite`` is finite, and that can be drawn."""
    for figure in shown:
        assert 1 <= len(figure.panels) <= 6
        series: list[Any] = [s for panel in figure.panels for s in panel.series]
        assert series
        for one in series:
            assert len(one.x) == len(one.y) >= 1
            assert np.isfinite(one.y).mean() >= finite
        assert draw_figure(figure).startswith("<?xml")
