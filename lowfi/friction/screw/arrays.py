"""A ball screw as its friction kernels take it: arrays and units of its grooves."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rollbench.lowfi.friction.screw.groove import Grooved
from rollbench.lowfi.friction.screw.path import ON_SCREW, HelicalMotion
from rollbench.lowfi.friction.screw.records import GrooveArrays
from rollbench.meshes.arrays import Array


@lru_cache(maxsize=64)
def groove_arrays(groove: Grooved) -> GrooveArrays:
    """The grooves as the kernels take them, motions scaled to surface speeds per nominal speed (see ``units``)."""
    unit, speed, pair, h = units(groove), nominal_speed(groove), groove.pair, groove.constants
    scale = speed / unit
    ends = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    at = groove.maps(np.repeat(ends[:, None, :], 4, axis=1))[0][:, 0] * scale
    middle = 0.5 * (at[0] + at[1])  # maps are affine in the normal, so that three directions tell them
    affine = np.stack([middle, at[0] - middle, at[2] - middle])
    ride = np.where(ON_SCREW, groove.screw_speed, groove.nut_speed) / scale[0]
    nominal = np.array([groove.nominal_orbit, 0.0, 0.0, 0.0]) / scale
    affine, ride, C_a, C_b, nominal, first, second = map(
        plain_array, (affine, ride, h.C_a, h.C_b, nominal, pair.first / unit, pair.second / unit)
    )
    closing = float(pair.closing / groove.radius)
    return GrooveArrays(affine, ride, C_a, C_b, nominal, first, second, closing, float(speed))


def plain_array(values: Array) -> Array:
    """Contiguous floats: machine code is made for each kind of array that comes along."""
    return np.ascontiguousarray(values, dtype=float)


def units(groove: HelicalMotion) -> Array:
    """Levers (4,) [m] from omega_B, omega_x, omega_y, omega_z to speeds."""
    return np.array([groove.radius, groove.ball_radius, groove.ball_radius, groove.ball_radius])


def nominal_speed(groove: HelicalMotion) -> float:
    """Speed of the nut along the path relative to the screw [m/s]; one at rest."""
    return float(abs(groove.speed) * groove.radius) or 1.0
