"""A scene's reference in a few numbers: its grid uncertainty in per cent of the mean load, and its orders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compare.measure import error_percent
from compare.reference.convergence import Pooled
from compare.reference.estimate import Reference


@dataclass(frozen=True)
class GridSummary:
    """Grid uncertainty of a scene's contact loads: number of levels, mean load [N], largest uncertainty and RMS over the
    loaded contacts [% of the mean load], ball (from 1) and side index of the largest; what the extrapolation moves at most
    [% of the mean load]; pooled order and contacts by label. Numbers that the levels do not give are None."""

    scene: str
    levels: int
    mean: float
    largest: float | None
    rms: float | None
    ball: int | None
    side: int | None
    extrapolation: float | None
    pooled: Pooled | None

    @property
    def labels(self) -> dict[str, int]:
        """Number of loaded or once loaded contacts by label."""
        return {} if self.pooled is None else self.pooled.labels


def mean_load(found: Reference) -> float:
    """Mean load of the loaded contacts [N]."""
    return float(found.load[found.load > 0.0].mean())


def summarise(found: Reference) -> GridSummary:
    """The summary of a reference."""
    mean = mean_load(found)
    if found.uncertainty is None:
        return GridSummary(found.scene, len(found.runs), mean, None, None, None, None, None, found.pooled)
    percent = np.abs(error_percent(found.uncertainty, 0.0, mean))
    loaded = np.stack([run.load for run in found.runs]).max(axis=0) > 0.0
    ball, side = np.unravel_index(int(percent.argmax()), percent.shape)
    moved = None
    if found.extrapolated is not None:
        moved = float(np.abs(error_percent(found.extrapolated, found.load, mean)).max())
    return GridSummary(
        found.scene,
        len(found.runs),
        mean,
        float(percent.max()),
        float(np.sqrt((percent[loaded] ** 2).mean())),
        int(ball) + 1,
        int(side),
        moved,
        found.pooled,
    )


def uncertainty_percent(found: Reference) -> float | None:
    """Largest grid uncertainty of any contact load of a reference, in per cent of its mean load; None with one level."""
    return summarise(found).largest
