"""The mean contact load that percentages of loads are of, and which contacts count in it."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array, Mask

#: Share of the largest contact load below which a contact carries nothing, where nothing but loads is known: a flank that
#: is barely touched beside those that bear the load.
BARELY = 0.01


def bearing(load: Array) -> Mask:
    """Which contacts bear the load: those with more than ``BARELY`` of the largest."""
    return np.asarray(load > BARELY * load.max(initial=0.0))


def counted(load: Array, contacts: int = 0) -> int:
    """Over how many contacts the sum of loads of any shape is shared out in their mean; see ``mean_load``."""
    return contacts or int(np.count_nonzero(bearing(load)))


def mean_load(load: Array, contacts: int = 0) -> float:
    """Sum of contact loads [N] of any shape over the number of contacts that the nominal screw loads; zero without load.

    contacts: that number (`lowfi.statics.nominal.nominal_contacts`), the same for all models, meshes and specimens of a
    scene. Zero where it is not known, as of loads without a scene, of a set on a shaft, or of a screw that only its errors
    press: then the contacts of `bearing` count, so that one that is barely touched moves the mean by what it carries.

    >>> mean_load(np.array([358.0, 358.0, 0.2, 0.0]))
    358.1
    >>> mean_load(np.array([358.0, 358.0, 10.0, 0.0]), 2)
    363.0
    """
    return float(load[load > 0.0].sum() / counted(load, contacts)) if (load > 0.0).any() else 0.0
