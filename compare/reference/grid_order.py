"""The order of the reference's discretisation, from the contacts of many scenes together.

An order belongs to the method, not to a scene: all scenes are meshed by the same levels. A single scene whose loads hardly
change any more from level to level allows almost any order, because only scatter is left; all scenes together do not.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from compare.measure import error_percent
from compare.reference.convergence import common_order
from compare.writing import replace_file
from meshes.arrays import Array

FILE = "grid_order.json"


class HasLoad(Protocol):
    """A run with loads ``(n, 4)`` [N]."""

    @property
    def load(self) -> Array:
        """Loads ``(n, 4)`` [N]."""
        ...


class OnLevels(HasLoad, Protocol):
    """A reference (`compare.reference.estimate.Reference`): loads of the finest level and of every run, relative sizes."""

    @property
    def scene(self) -> str:
        """Name of the scene."""
        ...

    @property
    def runs(self) -> Sequence[HasLoad]:
        """Runs, coarse to fine."""
        ...

    @property
    def sizes(self) -> tuple[float, ...]:
        """Relative cell sizes of the runs."""
        ...


@dataclass(frozen=True)
class GridOrder:
    """Order p of the contact loads over the cell size, the interval that the data allow (F test, 95 %), relative cell sizes
    of the levels, scenes, and how many contacts they have together."""

    order: float
    interval: tuple[float, float]
    sizes: tuple[float, ...]
    scenes: tuple[str, ...]
    contacts: int


def measured(found: Sequence[OnLevels]) -> GridOrder | None:
    """Order of references on the same levels, loads in per cent of each scene's mean; None where none has three levels.

    Of references with unlike levels those with the most common ones count.
    """
    sizes = [tuple(round(size / ref.sizes[-1], 9) for size in ref.sizes) for ref in found]
    usable = [s for s in sizes if len(s) >= 3]
    if not usable:
        return None
    common = max(sorted(set(usable)), key=usable.count)
    own = [ref for ref, s in zip(found, sizes, strict=True) if s == common]
    loads = []
    for ref in own:
        mean = float(ref.load[ref.load > 0.0].mean())
        loads.append(np.stack([error_percent(run.load.ravel(), 0.0, mean) for run in ref.runs]))
    y = np.hstack(loads)
    order, interval = common_order(y, common)
    moving = int((np.ptp(y, axis=0) > 0.0).sum())
    return GridOrder(order, interval, common, tuple(ref.scene for ref in own), moving)


def save(store: Path, order: GridOrder) -> None:
    """Write the record of a store. Raises OSError where that cannot be done."""
    replace_file(store / FILE, json.dumps(asdict(order), indent=1) + "\n")


def load(stores: Sequence[Path]) -> GridOrder | None:
    """The record of the first store that has one; None without, or if it is damaged."""
    for store in stores:
        try:
            data = json.loads((store / FILE).read_text(encoding="utf-8"))
            low, high = (float(p) for p in data["interval"])
            sizes = tuple(float(s) for s in data["sizes"])
            return GridOrder(float(data["order"]), (low, high), sizes, tuple(data["scenes"]), int(data["contacts"]))
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None
