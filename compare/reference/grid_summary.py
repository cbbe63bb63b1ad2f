"""A scene's reference in a few numbers: its discretisation's uncertainty in per cent of the mean load."""

from __future__ import annotations

from rollbench.comparison.measure import error_percent
from rollbench.comparison.reference.estimate import Reference
from rollbench.meshes.loads import mean_load


def uncertainty_percent(found: Reference) -> float:
    """What discretisation leaves uncertain in any contact load of a reference at most, in per cent of its mean load."""
    return float(error_percent(found.uncertainty.max(), 0.0, mean_load(found.load))) if found.parts.bar else 0.0
