"""Curves of figures from arrays and results."""

from __future__ import annotations

from rollbench.compare.models.comparison import Loads
from rollbench.compare.reference.estimate import Reference
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Panel, Series


def numbers(values: Array, factor: float = 1.0) -> list[float]:
    """Plain numbers for a record, times a factor."""
    return [factor * float(v) for v in values]


def lateral(
    stations: Array, moved: Array, name: str = "u_{}", style: str = "line", *, emphasis: bool = False
) -> tuple[Series, Series]:
    """Curves of the two lateral displacements [um] of a centreline ``(k, 2 or more)`` [m] over its stations ``(k,)`` [mm];
    name: with a place for the axis."""
    z = numbers(stations, 1e3)
    x, y = (
        Series(name.format(axis), z, numbers(moved[:, k], 1e6), style, emphasis=emphasis) for k, axis in enumerate("xy")
    )
    return x, y


def load_panel(title: str, *series: Series, zero: bool = False) -> Panel:
    """Contact loads over the balls."""
    return Panel(title, "ball", "contact load / N", series, zero=zero, integer_x=True)


def loads(
    label: str,
    result: StaticResult | Loads | Reference,
    side: int,
    style: str = "line+markers",
    *,
    emphasis: bool = False,
    bar: Array | None = None,
) -> Series:
    """Curve of the loads of one side over the ball number, 1 to n; bar ``(n, 4)`` [N]: what they are uncertain by."""
    load = result.load[:, side]
    balls = [float(i + 1) for i in range(load.size)]
    ends = None if bar is None else (numbers(load - bar[:, side]), numbers(load + bar[:, side]))
    return Series(label, balls, numbers(load), style, emphasis=emphasis, bars=ends)
