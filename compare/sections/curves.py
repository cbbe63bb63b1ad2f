"""Curves of figures from arrays and results."""

from __future__ import annotations

from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.records import Panel, Series


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


def load_panel(title: str, *series: Series) -> Panel:
    """Contact loads over the balls."""
    return Panel(title, "ball", "contact load / N", series, integer_x=True)


def loads(label: str, result: StaticResult, side: int, *, emphasis: bool = False) -> Series:
    """Curve of the loads of one side over the ball number, 1 to n."""
    balls = [float(i + 1) for i in range(result.z.size)]
    return Series(label, balls, numbers(result.load[:, side]), emphasis=emphasis)
