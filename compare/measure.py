"""The one definition of error that every percentage of the project goes through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rollbench.meshes.arrays import Array
from rollbench.meshes.loads import mean_load
from rollbench.meshes.parts import SIDES


def error_percent(value: ArrayLike, reference: ArrayLike, scale: ArrayLike | None = None) -> Array:
    """Error in per cent: 100 (value - reference) / |scale|, the scale being the reference itself unless given.

    Zero where value and reference are equal (even both zero); nan where the scale is zero and they differ, because a
    percentage of nothing means nothing.
    """
    v, r = np.broadcast_arrays(np.asarray(value, float), np.asarray(reference, float))
    base = np.abs(r if scale is None else np.broadcast_to(np.asarray(scale, float), r.shape))
    difference = v - r
    with np.errstate(divide="ignore", invalid="ignore"):
        percent = 100.0 * difference / base
    return np.asarray(np.where(difference == 0.0, 0.0, np.where(base > 0.0, percent, np.nan)))


#: A contact whose reference load is below this share of the mean load is judged in per cent of the mean load [-].
SMALL = 0.1


def gate_scale(reference: ArrayLike, mean: float) -> Array:
    """What the gate takes errors of contact loads in per cent of [N]: each contact's own ``reference`` load, or the mean
    load where that is below ``SMALL`` of it."""
    own = np.asarray(reference, float)
    return np.asarray(np.where(own >= SMALL * mean, own, mean))


@dataclass(frozen=True)
class LoadError:
    """Difference of two load distributions in per cent.

    max_percent, rms_percent: of the reference's mean load (`meshes.loads.mean_load`), over all contacts loaded in either;
    own_max_percent, own_rms_percent: each contact against its own reference load (as the source does), over the contacts
    loaded in the reference; ball (from 1) and side: where max_percent is met; gate_percent: largest by the gate's rule
    (`gate_scale`), over all contacts loaded in either.
    """

    max_percent: float
    rms_percent: float
    own_max_percent: float
    own_rms_percent: float
    ball: int
    side: str
    gate_percent: float


def load_error(value: Array, reference: Array, contacts: int = 0) -> LoadError:
    """Errors of the loads ``value`` (n, 4) [N] against ``reference`` (n, 4) [N]; contacts: see `meshes.loads.mean_load`."""
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
        gate_percent=float(np.abs(error_percent(value, reference, gate_scale(reference, mean))[either]).max()),
    )
