"""Texts beside the points of a panel, moved apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from rollbench.reports.records import Series

#: Distance between lines of text, and from a text to the points it belongs to [points of 1/72 inch].
LINE, AWAY = 10.0, 10.0
#: Width of a letter of these texts, about [points].
LETTER = 4.1
#: Share of a panel's width whose points have their texts on the left.
LEFT = 0.4


def apart(heights: Sequence[float], gap: float, low: float, high: float) -> NDArray[np.float64]:
    """Heights moved as little as their order allows so that they are ``gap`` apart, within low to high where that is
    possible.

    >>> apart([1.0, 1.0, 5.0], 2.0, 0.0, 10.0).tolist()
    [0.0, 2.0, 5.0]
    """
    order = np.argsort(heights, kind="stable")
    rank = gap * np.arange(len(order))
    wanted = np.asarray(heights, float)[order] - rank
    rising = isotonic_regression(wanted).x if len(wanted) else wanted
    level = np.clip(rising, low, max(low, high - gap * (len(order) - 1)))
    out = np.empty(len(order))
    out[order] = level + rank
    return out


def place_texts(axes: Any, series: Sequence[Series]) -> None:
    """Write the texts of all curves in two columns, to the left of all points and to their right, with a thin line to each
    point; a point's side is the nearer one. The abscissa grows as far as the texts need."""
    points = [(x, y, text) for s in series for x, y, text in zip(s.x, s.y, s.texts, strict=False) if text]
    if not points:
        return
    spread = [float(x) for s in series for x in s.x]
    ends = [(min(spread), points[0][1], ""), (max(spread), points[0][1], "")]
    place, width, _ = _places(axes, [*points, *ends])
    left = place[:-2, 0] < LEFT * width
    long = np.array([LETTER * len(text) + 2.0 * AWAY for *_, text in points])
    room = np.array([long.max(initial=0.0, where=left), long.max(initial=0.0, where=~left)])
    _widen(axes, place[-2:, 0] / width, room / width, np.array([True, False]))
    place, _, height = _places(axes, [*points, *ends])
    for side, column, align in ((left, place[-2, 0] - AWAY, "right"), (~left, place[-1, 0] + AWAY, "left")):
        heights = apart(place[:-2][side, 1].tolist(), LINE, 0.5 * LINE, height - 0.5 * LINE)
        for at, up in zip(np.flatnonzero(side), heights, strict=True):
            x, y, text = points[at]
            axes.annotate(
                text,
                (x, y),
                (column, up),
                textcoords="axes points",
                ha=align,
                va="center",
                fontsize=8.0,
                zorder=4.0,
                annotation_clip=False,
                in_layout=False,
                arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": "#8a8f98", "shrinkA": 0.0, "shrinkB": 2.0},
            )


def _places(axes: Any, points: Sequence[tuple[float, float, str]]) -> tuple[NDArray[np.float64], float, float]:
    """Points ``(n, 2)`` in the panel, its width and height [points]."""
    scale, box = 72.0 / axes.figure.dpi, axes.get_window_extent()
    place = axes.transData.transform([(x, y) for x, y, _ in points]) - (box.x0, box.y0)
    return scale * place, scale * box.width, scale * box.height


def _widen(axes: Any, at: NDArray[np.float64], room: NDArray[np.float64], left: NDArray[np.bool_]) -> None:
    """Move the ends of the abscissa out until every text has its room; places and room are shares of the width."""
    scale = axes.xaxis.get_transform()
    low, high = scale.transform(np.asarray(axes.get_xlim(), float))
    where = low + at * (high - low)
    for _ in range(3):  # each end takes from the room of the other
        ends = [(x - share * high) / (1.0 - share) for x, share in zip(where[left], room[left], strict=True)]
        low = min([low, *ends])
        ends = [(x - share * low) / (1.0 - share) for x, share in zip(where[~left], room[~left], strict=True)]
        high = max([high, *ends])
    axes.set_xlim(*scale.inverted().transform(np.array([low, high])))
