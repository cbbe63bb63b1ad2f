"""The worst line contact of a row of tapered rollers, and its static safety."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.rating.contacts import StaticSafety
from rollbench.lowfi.rollers.roller_slices import middles, slice_contacts, tapered
from rollbench.lowfi.rollers.tapered_roller import roller_contacts
from rollbench.lowfi.statics.validity import ROLLER_DENT_PRESSURE
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.quantity import quantity, record

#: Raceways of a roller, inner (cone) and outer (cup).
RACES = ("inner", "outer")


@record
class RollerContact:
    """Line contact of the highest pressure.

    roller from 1; race: of `RACES`; force: the roller's load on either race [N]; place [m]: along the roller from its
    middle, outwards, where line_load [N/m], half_width b [m] and pressure [Pa] are; other: the greatest pressure on the
    other race of that roller [Pa]; middle: at the middle of the roller under its load evenly spread [Pa].
    """

    roller: int = quantity("roller", "roller of the highest pressure")
    race: str = quantity("race", "its race: inner or outer")
    force: float = quantity("force_N")
    place: float = quantity("place_mm", "that place, from the roller's middle, positive to its large end")
    line_load: float = quantity(
        "line_load_N_mm",
        "load per length q where the pressure is highest",
        error="without what the ends of straight rollers add",
    )
    half_width: float = quantity(
        "half_width_mm", "half-width b of the strip there, sqrt(4 q R/(pi E*))", error="half that of the line load"
    )
    pressure: float = quantity("pressure_MPa", heading="peak pressure", form=".0f")
    other: float = quantity(
        "other_race_pressure_MPa", "largest pressure of that roller on its other race", error="half that of the line load"
    )
    middle: float = quantity(
        "middle_pressure_MPa",
        "pressure at the roller's middle diameter if its load were spread evenly along it",
        error="half that of the load",
    )


def race_pressures(row: RollerRow, line_loads: Array) -> Array:
    """Greatest pressures ``(count, 2)`` [Pa] along every roller at inner and outer race; line_loads ``(count, slices)``
    [N/m]."""
    return np.asarray(slice_contacts(tapered(row), line_loads)[1].max(axis=1))


def worst_roller(row: RollerRow, line_loads: Array) -> RollerContact | None:
    """The place of the highest pressure of a row, None without load; line_loads ``(count, slices)`` [N/m].

    Equations and range: `lowfi.rollers.roller_slices.slice_contacts`. Under an even line load the place is the small end,
    where the curvatures are greatest.
    """
    bearing = tapered(row)
    half_width, pressure = slice_contacts(bearing, line_loads)
    if not (pressure > 0.0).any():
        return None
    i, k, race = (int(x) for x in np.unravel_index(int(pressure.argmax()), pressure.shape))
    force = float(line_loads[i].mean()) * row.length
    return RollerContact(
        roller=i + 1,
        race=RACES[race],
        force=force,
        place=float(middles(row.length, row.slices)[k]),
        line_load=float(line_loads[i, k]),
        half_width=float(half_width[i, k, race]),
        pressure=float(pressure[i, k, race]),
        other=float(pressure[i, :, 1 - race].max()),
        middle=float(roller_contacts(bearing, force).pressures[race]),
    )


def roller_safety(worst: RollerContact) -> StaticSafety:
    """Static safety of a line contact of hardened bearing steel: ISO 76 rates those of roller bearings at the load of 4000
    MPa, and pressure grows with the root of the load."""
    return StaticSafety((ROLLER_DENT_PRESSURE / worst.pressure) ** 2, ROLLER_DENT_PRESSURE)
