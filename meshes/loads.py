"""Mean contact load, to which percentages of loads refer, and the contacts that count in it."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array, Mask

#: Share of the largest contact load below which a contact carries nothing, where nothing but loads is known: a flank that
#: barely touches, next to those that carry the load.
BARELY = 0.01


def loaded_contacts(load: Array) -> Mask:
    """Mask of the contacts that carry more than `BARELY` (1 %) of the largest load.

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
    """Count the contacts that a mean load is taken over; see `mean_load`.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        The number if it is known, else 0.

    Returns
    -------
    int
        ``contacts``, or the number of `loaded_contacts` contacts.
    """
    return contacts or int(np.count_nonzero(loaded_contacts(load)))


def mean_load(load: Array, contacts: int = 0) -> float:
    """Sum of the contact loads over the number of contacts that the nominal screw loads.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        That number (`lowfi.statics.nominal.nominal_contacts`), the same for all models, meshes and specimens of a
        scene. 0 where it is not known: loads without a scene, a set on a shaft, a screw that only its errors load.
        Then the contacts of `loaded_contacts` count, so that a lightly loaded one changes the mean only by its own load.

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
