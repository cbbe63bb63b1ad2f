"""Mean contact load, to which percentages of loads refer, and the number of contacts over which it is taken."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array, Mask

#: Ratio to the largest contact load up to which a contact counts as unloaded, where only the loads are known. It excludes
#: flanks that barely touch the balls.
BARELY = 0.01


def loaded_contacts(load: Array) -> Mask:
    """Find the contacts that carry more than `BARELY` (1 %) of the largest load.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].

    Returns
    -------
    Mask of that shape
        True where the contact counts as loaded.

    Examples
    --------
    >>> loaded_contacts(np.array([358.0, 358.0, 0.2, 0.0])).tolist()
    [True, True, False, False]
    """
    return np.asarray(load > BARELY * load.max(initial=0.0))


def count_contacts(load: Array, contacts: int = 0) -> int:
    """Return the number of contacts over which the mean load is taken; see `mean_load`.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        Number of contacts if it is known, else 0.

    Returns
    -------
    int
        ``contacts``, or the number of `loaded_contacts` if ``contacts`` is 0.
    """
    return contacts or int(np.count_nonzero(loaded_contacts(load)))


def mean_load(load: Array, contacts: int = 0) -> float:
    """Return the sum of the contact loads divided by the number of contacts that carry load in the error-free screw.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        Number of loaded contacts in the error-free screw (`lowfi.statics.nominal.nominal_contacts`), the same for all
        models, meshes and specimens of a scene. 0 where it is not known: for loads without a scene, for one of several nuts
        on a shaft, or where only geometric errors load the screw. Then the number of `loaded_contacts` is used.

    Returns
    -------
    float
        Mean load [N]; 0 without load.

    Examples
    --------
    >>> mean_load(np.array([358.0, 358.0, 0.2, 0.0]))
    358.1
    >>> mean_load(np.array([358.0, 358.0, 10.0, 0.0]), 2)
    363.0
    """
    return float(load[load > 0.0].sum() / count_contacts(load, contacts)) if (load > 0.0).any() else 0.0
