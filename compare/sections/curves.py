"""Curves of figures from arrays and results."""

from __future__ import annotations

from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.records import Series


def numbers(values: Array, factor: float = 1.0) -> list[float]:
    """Plain numbers for a record, times a factor."""
    return [factor * float(v) for v in values]


def loads(label: str, result: StaticResult, side: int, *, emphasis: bool = False) -> Series:
    """Curve of the loads of one side over the ball number, 1 to n."""
    balls = [float(i + 1) for i in range(result.z.size)]
    return Series(label, balls, numbers(result.load[:, side]), emphasis=emphasis)
