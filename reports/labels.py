"""Texts beside the points of a panel, moved apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.records import Series

#: Distance between lines of text, and from a text to the points it belongs to [points of 1/72 inch].
LINE, AWAY = 11.0, 12.0


def apart(heights: Sequence[float], gap: float, low: float, high: float) -> NDArray[np.float64]:
    """Heights moved as little as their order allows so that they are ``gap`` apart, within low to high where that is
    possible.

    >>> apart([1.0, 1.0, 5.0], 2.0, 0.0, 10.0).tolist()
    [0.0, 2.0, 5.0]
    """
    order = np.argsort(heights, kind="stable")
    rank = gap * np.arange(len(order))
    wanted = np.asarray(heights, float)[order] - rank
    level = _rising(np.clip(wanted, low, max(low, high - gap * (len(order) - 1))))
    out = np.empty(len(order))
    out[order] = level + rank
    return out


def _rising(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest sequence that does not fall (pools of neighbours that would)."""
    pools: list[list[float]] = []
    for value in values:
        pools.append([value])
        while len(pools) > 1 and np.mean(pools[-2]) > np.mean(pools[-1]):
            pools[-2] += pools.pop()
    return np.concatenate([np.full(len(pool), np.mean(pool)) for pool in pools]) if pools else values


def place_texts(axes: Any, series: Sequence[Series]) -> None:
    """Write the texts of all curves: of points in the left half of the panel as a column to their left, with a thin line
    to each, of the others to their right."""
    scale = 72.0 / axes.figure.dpi
    box = axes.get_window_extent()
    points = [(x, y, text) for s in series for x, y, text in zip(s.x, s.y, s.texts, strict=False) if text]
    if not points:
        return
    place = scale * (axes.transData.transform([(x, y) for x, y, _ in points]) - (box.x0, box.y0))
    left = place[:, 0] < 0.5 * scale * box.width
    for side, sign in ((left, -1.0), (~left, 1.0)):
        if not side.any():
            continue
        heights = apart(place[side, 1].tolist(), LINE, 0.5 * LINE, scale * box.height - 0.5 * LINE)
        column = place[side, 0].min() - AWAY
        for at, height in zip(np.flatnonzero(side), heights, strict=True):
            x, y, text = points[at]
            across = column if sign < 0.0 else place[at, 0] + 0.6 * AWAY
            axes.annotate(
                text,
                (x, y),
                (across, height),
                textcoords="axes points",
                ha="right" if sign < 0.0 else "left",
                va="center",
                fontsize=8.0,
                zorder=4.0,
                arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": "#8a8f98", "shrinkA": 0.0, "shrinkB": 2.0},
            )
