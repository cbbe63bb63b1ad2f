"""Washers of a thrust ball bearing: flat rings whose grooves open in their faces, not in a cylinder.

At contact angles near 90 deg a cylindrical land would end the groove before its contact. The land of a washer is its flat
face, and the washer lies on its back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import asin, degrees, pi, sqrt

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Scene, UnfitKey, Washers
from rollbench.meshes.section import screw_groove_section

#: Contact angle [deg] above which a bearing is a thrust bearing (ISO 281), and above which its rings may be washers.
THRUST_ABOVE = 45.0
#: Assumed dimensions over the ball's diameter, near those of catalogued bearings: distance of either edge from the pitch
#: circle, thickness under the groove, and depth of the groove.
EDGE, FLOOR, DEPTH = 0.79, 0.55, 0.25


@dataclass(frozen=True)
class Washer:
    """Cross-section of a washer, in the section through the bearing's axis, for the flank at positive z."""

    #: Radii of the bore and of the outer edge [m].
    bore: float
    outer: float
    #: Axial positions of the face with the groove and of the back, from the ball's centre [m].
    face: float
    back: float
    #: Centre of the groove's arc: distance from the bearing's axis, axial position from the ball's centre [m].
    centre: tuple[float, float]
    #: Radius of the groove's arc [m].
    groove_radius: float
    #: Dimensions that were assumed, as a sentence; empty if all are given.
    assumed: str

    @property
    def section_angles(self) -> tuple[float, float]:
        """Section angles at which the arc leaves the face [rad], from the radial direction around the arc's centre."""
        low = asin((self.face - self.centre[1]) / self.groove_radius)
        return low, pi - low


@lru_cache(maxsize=64)
def has_washers(scene: Scene) -> bool:
    """Return whether the rings of a scene are washers.

    They are those of a bearing above 45 deg that states a dimension of them (`meshes.parts.Washers`), or whose contacts lie
    beyond the edge at which a cylindrical land would end the groove.
    """
    if scene.track.lead != 0.0 or degrees(scene.track.contact_angle) <= THRUST_ABOVE + 1e-9:
        return False
    return scene.track.washers != Washers() or scene.track.contact_angle > screw_groove_section(scene).edge_angle


@lru_cache(maxsize=64)
def washer_of_ring(scene: Scene, inner: bool) -> Washer:
    """Return the shaft washer (``inner``) or the housing washer of a thrust ball bearing.

    Raises UnfitKey if a dimension leaves no groove or no wall. ``scene``: bearing with washers (`has_washers`).
    """
    given, m, D = scene.track.washers, GrooveMap.from_scene(scene), 2.0 * scene.balls.radius
    side = 1 if inner else 3
    centre, radius = (m.R + float(m.centre[side, 0]), float(m.centre[side, 1])), float(m.radius[side])
    depth = DEPTH * D if given.groove_depth is None else given.groove_depth
    if not depth < radius:
        raise _unfit("groove_depth", f"below the groove's radius, {1e3 * radius:.4g} mm")
    bore = 2.0 * (m.R - EDGE * D) if given.bore is None else given.bore
    outer = 2.0 * (m.R + EDGE * D) if given.outer_diameter is None else given.outer_diameter
    thickness = FLOOR * D + depth if given.thickness is None else given.thickness
    half = sqrt(radius**2 - (radius - depth) ** 2)
    least, most = 2.0 * (centre[0] - half), 2.0 * (centre[0] + half)
    if not 0.0 < bore < least:
        raise _unfit("bore", f"above 0 mm, below the groove's inner edge, {1e3 * least:.4g} mm")
    if not outer > most:
        raise _unfit("outer_diameter", f"above the groove's outer edge, {1e3 * most:.4g} mm")
    if not thickness > depth:
        raise _unfit("thickness", f"above the groove's depth, {1e3 * depth:.4g} mm")
    values = {
        "a bore": (given.bore, bore),
        "an outer diameter": (given.outer_diameter, outer),
        "a thickness": (given.thickness, thickness),
        "a groove depth": (given.groove_depth, depth),
    }
    missing = [f"{name} of {1e3 * value:.4g} mm" for name, (given, value) in values.items() if given is None]
    assumed = f"Washers with {', '.join(missing)}." if missing else ""
    face = centre[1] + radius - depth
    return Washer(bore / 2.0, outer / 2.0, face, face + thickness, centre, radius, assumed)


def _unfit(name: str, allowed: str) -> UnfitKey:
    """Return the error of a dimension of washers that is not in its allowed range."""
    return UnfitKey(f"track.washers.{name}", f"track.washers.{name} must be {allowed}")


def section_angle_limits(scene: Scene) -> tuple[Array, Array]:
    """Return the smallest and the largest section angle of each flank of a bearing with washers, ``(4,)`` each [rad]."""
    low, high = zip(*(washer_of_ring(scene, inner).section_angles for inner in (True, False)), strict=True)
    return np.repeat(low, 2), np.repeat(high, 2)
