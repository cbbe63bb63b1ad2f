"""The mean contact load that percentages of loads are of, and which contacts count in it."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array, Mask

#: Share of the largest contact load below which a contact carries nothing that a nominal screw's contacts would: a flank
#: that is barely touched beside those that bear the load.
BARELY = 0.01


def bearing(load: Array) -> Mask:
    """Which contacts bear the load: those with more than ``BARELY`` of the largest."""
    return np.asarray(load > BARELY * load.max(initial=0.0))


def mean_load(load: Array) -> float:
    """Sum of contact loads [N] of any shape over the number of those contacts that bear the load; zero without load.

    Those are the contacts of `bearing`, as all have that a screw without errors loads: one
    more that is barely touched moves the mean by what it carries, and not by a contact's share.

    >>> mean_load(np.array([358.0, 358.0, 0.2, 0.0]))
    358.1
    """
    if not (load > 0.0).any():
        return 0.0
    return float(load[load > 0.0].sum() / np.count_nonzero(bearing(load)))
