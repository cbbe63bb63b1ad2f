"""A scene's reference in a few numbers: its discretisation's uncertainty in per cent of the mean load."""

from __future__ import annotations

from rollbench.comparison.measure import error_percent
from rollbench.comparison.reference.estimate import Reference


def uncertainty_percent(found: Reference) -> float:
    """What discretisation leaves uncertain in any contact load of a reference at most, in per cent of its mean load."""
    return float(error_percent(found.uncertainty.max(), 0.0, found.mean)) if found.parts.bar else 0.0
