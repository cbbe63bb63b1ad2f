"""Why loads of another program may disagree with the reference as a whole: another unit, other numbers of the balls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.comparison.measure import error_percent
from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES

#: Newtons of other units of force.
UNITS = {"kilonewtons": 1e3, "pounds": 4.4482216152605, "kiloponds": 9.80665, "millinewtons": 1e-3}
#: Relative distance from a unit within which the sums of loads look like it.
NEAR = 0.2


def looks(load: Array, reference: Array, flanks: Sequence[str], limit: float) -> str:
    """Words on loads ``(n, 4)`` [N] beyond the limit [%] that would be within it in another unit or on other balls; empty
    where there is no such reason. flanks: those that are judged."""
    sides = [SIDES.index(side) for side in flanks]
    given, right = load[:, sides], reference[:, sides]
    mean = mean_load(right)
    if mean == 0.0 or not given.any() or _largest(given, right, mean) <= limit:
        return ""
    for name, newton in UNITS.items():
        if abs(float(given.sum()) * newton / float(right.sum()) - 1.0) < NEAR:
            return f"the loads look like {name}: in newtons they are {newton:g} times as large"
    if _largest(np.sort(given, axis=0), np.sort(right, axis=0), mean) <= limit:
        reverse = "the other way round" if _largest(given[::-1], right, mean) <= limit else "otherwise"
        return (
            f"the same loads stand on other balls, which look numbered {reverse}: add the columns azimuth_deg and z_mm, by "
            "which balls are matched"
        )
    swapped = {"SL": "SR", "SR": "SL", "NL": "NR", "NR": "NL"}
    other = reference[:, [SIDES.index(swapped[side]) for side in flanks]]
    if other.any() and _largest(given, other, mean_load(other)) <= limit:
        return "the loads look like those of the other flanks: left and right are seen along +z"
    return ""


def _largest(given: Array, right: Array, mean: float) -> float:
    return float(np.abs(error_percent(given, right, mean)).max())
