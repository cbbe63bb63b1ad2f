"""Where rows of rollers leave the range in which the models hold: one sentence for each, as of balls."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.rollers import slice_contacts, tapered
from rollbench.lowfi.statics.result import SetResult
from rollbench.lowfi.statics.validity import contact_warnings, rotation_warning, tilted
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow


def roller_warnings(s: SetResult, z: Array, motion: Array) -> tuple[Warned, ...]:
    """Warnings of a row of rollers; z ``(k,)`` [m] and motion ``(k, 6)`` [m, rad] of the shaft's centreline."""
    if not isinstance(s.of.parts, RollerRow) or s.line_loads is None:
        return ()
    bearing = tapered(s.of.parts)
    half_width, pressure = slice_contacts(bearing, s.line_loads)
    approach = float(bearing.law().approach(s.line_loads).max(initial=0.0))
    rx, ry = (float(np.interp(s.of.position, z, motion[:, k])) for k in (3, 4))
    return (
        *contact_warnings(pressure.max(axis=1), half_width.max(axis=1), 0.5 * bearing.diameter, "roller"),
        *tilted(float(np.hypot(rx, ry)), 0.5 * bearing.pitch_diameter, approach, "roller"),
        *rotation_warning(z, motion),
    )
