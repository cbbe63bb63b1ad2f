"""A scene's reference in a few numbers: its discretisation's uncertainty in per cent of the mean load."""

from __future__ import annotations

from rollbench.compare.measure import error_percent
from rollbench.compare.reference.estimate import Reference


def uncertainty_percent(reference: Reference) -> float:
    """What discretisation leaves uncertain in any contact load of a reference at most, in per cent of its mean load."""
    return float(error_percent(reference.uncertainty.max(), 0.0, reference.mean)) if reference.parts.bar else 0.0
