"""Definitions of errors in per cent and of the mean contact load, by which all commands and pages compute them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.parts import SIDES

#: Ratio of a contact load to the largest contact load, up to which the contact counts as unloaded if nothing but the
#: loads is known; flanks that barely touch the balls are thus left out.
BARELY = 0.01


def error_percent(value: ArrayLike, reference: ArrayLike, scale: ArrayLike | None = None) -> Array:
    """Return the error 100 (value - reference) / abs(scale) in per cent.

    Parameters
    ----------
    value, reference
        Numbers of any shapes that broadcast.
    scale
        Number by which the difference is divided; None: the reference.

    Returns
    -------
    Array
        Error [%]; zero if value and reference are equal (even if both are zero), nan if they differ and the scale is zero.

    Examples
    --------
    >>> error_percent([102.0, 0.0, 1.0], [100.0, 0.0, 0.0]).tolist()
    [2.0, 0.0, nan]
    """
    v, r = np.broadcast_arrays(np.asarray(value, float), np.asarray(reference, float))
    base = np.abs(r if scale is None else np.broadcast_to(np.asarray(scale, float), r.shape))
    difference = v - r
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = 100.0 * difference / base
    return np.asarray(np.where(difference == 0.0, 0.0, np.where(base > 0.0, percent, np.nan)))


#: Ratio of a contact's reference load to the mean load, below which its error is judged in per cent of the mean load [1].
SMALL = 0.1


def load_scale_of_check_errors(reference: ArrayLike, mean: float) -> Array:
    """Return for each contact the load [N] by which `rollbench check` divides the error of the contact load.

    Parameters
    ----------
    reference
        Contact loads of the reference, any shape [N].
    mean
        Mean contact load [N].

    Returns
    -------
    Array
        Reference load of each contact, or the mean load if the reference load is below ``SMALL`` times the mean.

    Examples
    --------
    >>> load_scale_of_check_errors([150.0, 5.0], 100.0).tolist()
    [150.0, 100.0]
    """
    own = np.asarray(reference, float)
    return np.asarray(np.where(own >= SMALL * mean, own, mean))


@dataclass(frozen=True)
class LoadError:
    """Errors of all contact loads of a screw or bearing against those of a reference, in per cent."""

    #: Largest error over all contacts that are loaded in the judged result or in the reference [% of the reference's
    #: mean contact load].
    max_percent: float
    #: Root mean square error over the same contacts as ``max_percent`` [% of the reference's mean contact load].
    rms_percent: float
    #: Largest error over the contacts that are loaded in the reference [% of the reference load of each contact], as in
    #: Lin's thesis.
    own_max_percent: float
    #: Root mean square error over the contacts that are loaded in the reference [% of the reference load of each
    #: contact].
    own_rms_percent: float
    #: Number of the ball with the largest error, from 1.
    ball: int
    #: Groove flank with the largest error: SL, SR, NL, NR.
    side: str
    #: Largest error as `rollbench check` judges it, over the same contacts as ``max_percent`` [% of each contact's
    #: reference load, or of the mean load if the reference load is small; see `load_scale_of_check_errors`].
    gate_percent: float


def load_error(value: Array, reference: Array, contacts: int = 0) -> LoadError:
    """Compute the errors of contact loads against those of a reference.

    Parameters
    ----------
    value
        Contact loads of n balls on 4 flanks (SL, SR, NL, NR: left and right flank of screw and nut), (n, 4) [N].
    reference
        Contact loads of the reference, (n, 4) [N].
    contacts
        Number of contacts over which the mean load is taken; 0: not known (see `mean_load`).

    Returns
    -------
    LoadError
        The errors; all zero if no contact of the reference is loaded.

    Examples
    --------
    >>> found = load_error(np.array([[103.0, 0.0, 0.0, 97.0]]), np.array([[100.0, 0.0, 0.0, 100.0]]))
    >>> round(found.max_percent, 9), found.ball, found.side
    (3.0, 1, 'SL')
    """
    either = (value > 0.0) | (reference > 0.0)
    loaded = reference > 0.0
    if not either.any() or not loaded.any():
        return LoadError(0.0, 0.0, 0.0, 0.0, 0, "", 0.0)
    mean = mean_load(reference, contacts)
    of_mean = np.where(either, error_percent(value, reference, mean), 0.0)
    relative = error_percent(value[loaded], reference[loaded])
    ball, side = np.unravel_index(int(np.abs(of_mean).argmax()), of_mean.shape)
    return LoadError(
        max_percent=float(np.abs(of_mean).max()),
        rms_percent=float(np.sqrt((of_mean[either] ** 2).mean())),
        own_max_percent=float(np.abs(relative).max()),
        own_rms_percent=float(np.sqrt((relative**2).mean())),
        ball=int(ball) + 1,
        side=SIDES[int(side)],
        gate_percent=float(
            np.abs(error_percent(value, reference, load_scale_of_check_errors(reference, mean))[either]).max()
        ),
    )


def mask_of_loaded_contacts(load: Array) -> Mask:
    """Return which contacts carry more than 1 % of the largest contact load.

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
    >>> mask_of_loaded_contacts(np.array([358.0, 358.0, 0.2, 0.0])).tolist()
    [True, True, False, False]
    """
    return np.asarray(load > BARELY * load.max(initial=0.0))


def count_contacts(load: Array, contacts: int = 0) -> int:
    """Return the number of contacts over which the mean contact load is taken; see `mean_load`.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        Number of contacts that carry load in the error-free screw; 0: not known.

    Returns
    -------
    int
        ``contacts``, or the number of loaded contacts by `mask_of_loaded_contacts` if ``contacts`` is 0.
    """
    return contacts or int(np.count_nonzero(mask_of_loaded_contacts(load)))


def mean_load(load: Array, contacts: int = 0) -> float:
    """Return the sum of the contact loads divided by the number of contacts that carry load in the error-free screw.

    Parameters
    ----------
    load : Array of any shape
        Contact loads [N].
    contacts : int, default 0
        Number of loaded contacts in the error-free screw (`lowfi.statics.nominal.count_nominal_contacts`), the same for all
        models, meshes and specimens of a scene. 0 where it is not known: for loads without a scene, for one of several nuts
        on a shaft, or where only geometric errors load the screw. Then the contacts of `mask_of_loaded_contacts` are
        counted.

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
