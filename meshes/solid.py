"""Dimensions of screw and nut that only the 3D finite-element reference needs: from the scene file, or assumed.

Each assumption is stated in a sentence for the report.
"""

from __future__ import annotations

import numpy as np

from rollbench.meshes.helix import nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.record_keys import frozen_default, frozen_record
from rollbench.meshes.washers import has_washers, washer_of_ring

#: Radius of the hole that is assumed along the axis of a solid screw, as a ratio to the pitch radius. The mesh needs a
#: hole; its effect is part of the modelling uncertainty.
HOLE = 1.0 / 11.0
#: Distance [m] below which two axial positions count as one.
SAME = 1e-9
#: Length of the shaft beyond each face of the nut that is assumed to be meshed in 3D, as a ratio to the pitch radius.
SHAFT = 1.5
#: For a nut's groove that ends beyond the loaded balls, in ball diameters: WHOLE, length of the groove of full depth beyond
#: the centre of the outermost ball; RUN_OUT, length over which its depth then decreases to zero.
WHOLE, RUN_OUT = 1.0, 1.0


@frozen_record
class Dimensions:
    """Dimensions and fixed surfaces of screw and nut in the 3D model, with sentences on those that had to be assumed."""

    #: Radius of the nut's lands [m].
    land: float
    #: Radius of the hole along the screw [m].
    hole: float
    #: Length over which the shaft is meshed in 3D beyond each face of the nut [m].
    shaft: float
    #: Radius of the shaft beyond the 3D mesh [m]; None for a homogenised grooved shaft.
    shaft_radius: float | None
    #: Surface at which the nut is fixed.
    nut_held: str
    #: Where supports and loads act on the screw: at its ``"ends"``, or by a stiff shaft in its ``"bore"``.
    screw_held: str
    #: Inner and outer radius of the annulus that is fixed on a face of the nut [m].
    held_radii: tuple[float, float]
    #: Whether the nut's groove ends shortly beyond the loaded balls (True), or runs through the whole nut.
    groove_ends: bool
    #: All assumptions, as sentences.
    assumed: tuple[str, ...]
    #: Assumptions in ``assumed`` that only the meshing needs, as sentences.
    mesh_only: tuple[str, ...] = frozen_default(())

    def ends_of_meshed_screw(self, scene: Scene) -> tuple[float, float]:
        """Return the axial positions between which the screw is meshed in 3D; there it has flat ends.

        An end closer than `SAME` to a support or load is moved to it, because the two may differ by rounding. Otherwise the
        load would act on the surface of the screw's axial hole just inside the end, instead of the whole flat end.

        Parameters
        ----------
        scene : Scene
            Scene with nut, screw, supports and loads.

        Returns
        -------
        low, high : float
            Axial positions [m].
        """
        half = scene.nut.length / 2.0 + self.shaft
        ends = max(scene.nut.position - half, 0.0), min(scene.nut.position + half, scene.screw.length)
        low, high = (next((z for z in scene.stations if abs(z - end) <= SAME), end) for end in ends)
        return low, high


def largest_groove_depths(scene: Scene) -> tuple[float, float]:
    """Return the depths of the nominal grooves of screw and nut at their deepest points, from the pitch cylinder.

    The deepest point is where both arcs meet, or the bottom of a single arc. For a wide groove the depth is much smaller
    than the groove radius.

    Parameters
    ----------
    scene : Scene
        Scene with radii and contact angle.

    Returns
    -------
    screw, nut : float
        Depths of the grooves in screw and nut [m].

    Examples
    --------
    >>> import rollbench
    >>> [round(1e3 * x, 3) for x in largest_groove_depths(rollbench.read("lin-case1"))]  # mm
    [2.9, 2.9]
    """
    radial, across = np.abs(nominal_groove_centres(scene)).T
    screw, nut = (np.sqrt(nominal_groove_radii(scene) ** 2 - across**2) - radial)[[0, 3]]
    return float(screw), float(nut)


def _check_nut_land(scene: Scene, land: float, depth: float) -> None:
    """Raise UnfitKey where the radius of the nut's lands leaves no groove, or no wall around it.

    ``land``: radius of the nut's lands [m]; ``depth``: depth of the nut's groove, measured from the pitch cylinder [m].
    """
    pitch, outer = 2e3 * scene.track.pitch_radius, 1e3 * scene.screw.outer_diameter
    most = pitch + 2e3 * depth
    diameter = 2e3 * land
    if diameter >= 1e3 * scene.nut.outer_diameter and pitch < diameter < most:
        outside = f"nut.outer_diameter of {1e3 * scene.nut.outer_diameter:.4g} mm leaves no wall"
        raise UnfitKey("nut.outer_diameter", f"{outside} outside the nut's lands of {diameter:.4g} mm diameter")
    if pitch < diameter < most:
        return
    if scene.solid.nut_inner_diameter is not None:
        between = f"it must lie between the pitch diameter {pitch:.4g} mm and {most:.4g} mm"
        raise UnfitKey(
            "solid.nut_inner_diameter", f"solid.nut_inner_diameter of {diameter:.4g} mm leaves no groove: {between}"
        )
    raise UnfitKey(
        "screw.outer_diameter",
        f"screw.outer_diameter of {outer:.4g} mm with a pitch diameter of {pitch:.4g} mm leaves no groove in the nut. Its "
        "lands are assumed as far outside the pitch cylinder as the screw's are inside it: give screw.outer_diameter "
        f"between {pitch - 2e3 * depth:.4g} mm and the pitch diameter, or the nut's lands by solid.nut_inner_diameter",
    )


def dimensions_of_3d_parts(scene: Scene) -> Dimensions:
    """Return the dimensions of screw and nut for the 3D model; those that the scene does not give are assumed.

    Parameters
    ----------
    scene : Scene
        Scene with a screw or bearing.

    Returns
    -------
    Dimensions
        Dimensions, with the assumptions as sentences.

    Raises
    ------
    UnfitKey
        The radius of the lands or of the screw's axial hole leaves no groove or no wall, or keys of ``[solid]`` contradict
        the parts.
    """
    solid, assumed, mesh_only, washers = scene.solid, [], [], has_washers(scene)
    R, outer = scene.track.pitch_radius, scene.screw.outer_diameter / 2.0
    if solid.nut_inner_diameter is None:
        land = 2.0 * R - outer
        if not washers:
            line = f"Nut lands of {2e3 * land:.4g} mm diameter: the screw's lands mirrored about the pitch cylinder."
            assumed.append(line)
    else:
        land = solid.nut_inner_diameter / 2.0
    if solid.hole_diameter is not None:
        hole = solid.hole_diameter / 2.0
    elif scene.screw.bore > 0.0:
        hole = scene.screw.bore / 2.0
    else:
        hole = HOLE * R
        mesh_only.append(f"A hole of {2e3 * hole:.3g} mm diameter along the axis of the meshed screw; the scene has none.")
        assumed.append(mesh_only[-1])
    held: str | None = solid.nut_held
    flange = scene.nut.flange
    if held is None:
        held = "flange face" if flange else "outer surface" if scene.track.lead == 0.0 else "left face"
        assumed.append("The washers are held at their backs." if washers else f"The nut is held at its {held}.")
    held, _, half = held.partition(", ")
    wall = scene.nut.outer_diameter / 2.0
    if flange and held in (f"{flange.side} face", "both faces"):
        wall = flange.diameter / 2.0
    middle = 0.5 * (land + wall)
    held_radii = {"": (land, wall), "inner half": (land, middle), "outer half": (middle, wall)}[half]
    if held == "flange face":
        if flange is None:
            raise UnfitKey("nut.held.at", 'nut.held.at of "flange face" needs a flange: give [nut.flange]')
        held_radii = flange.seat
        place = f"in {flange.bolts} circles as wide as its annulus" if flange.bolts else "all over its annulus"
        assumed.append(
            f"The face of the nut's flange is bonded to a rigid housing {place}, {2e3 * flange.seat[0]:.4g} to "
            f"{2e3 * flange.seat[1]:.4g} mm in diameter, and does not gape"
            f"{'; low-order models hold the whole annulus' if flange.bolts else ''}."
        )
        held += (" and centring" if flange.bonded else "") + (f", {flange.bolts} bolts" if flange.bolts else "")
    screw_held = solid.screw_held
    if screw_held is None:
        screw_held = "bore" if scene.ingredients.screw == "rigid" and scene.screw.bore > 0.0 else "ends"
        if screw_held == "bore" and not washers:
            assumed.append("The bore of the inner ring moves as a rigid shaft.")
    shaft = solid.shaft
    if screw_held == "bore":
        shaft = 0.0 if shaft is None else shaft
    elif shaft is None:
        shaft = SHAFT * R
        mesh_only.append(f"The screw is three-dimensional up to {1e3 * shaft:.3g} mm beyond each face of the nut.")
        assumed.append(mesh_only[-1])
    groove_ends = solid.nut_groove == "loaded"
    if scene.track.lead == 0.0:
        if groove_ends:
            raise UnfitKey(
                "solid.nut_groove",
                'solid.nut_groove of "loaded" ends the groove of a nut beyond its balls; the groove of a ring has no ends: '
                "remove solid.nut_groove",
            )
        lines = (washer_of_ring(scene, inner).assumed for inner in (True, False)) if washers else ()
        assumed.extend(dict.fromkeys(line for line in lines if line))
        assumed.append("Flat ends of the rings, without chamfers.")
    elif groove_ends:
        assumed.append(
            f"The nut's groove is whole up to {WHOLE:.3g} ball diameter beyond its outermost balls and filled from "
            f"{WHOLE + RUN_OUT:.3g} on; that of the screw runs through its whole 3D stretch; flat nut faces."
        )
    else:
        assumed.append("The groove runs through the whole nut and the whole 3D stretch of the screw; flat nut faces.")
    of_screw, of_nut = largest_groove_depths(scene)
    if not washers:
        _check_nut_land(scene, land, of_nut)
    if not 0.0 < hole < R - of_screw:
        raise UnfitKey(
            "solid.hole_diameter",
            f"the hole of {2e3 * hole:.4g} mm diameter along the screw leaves no wall under the groove: give "
            f"solid.hole_diameter below {2e3 * (R - of_screw):.4g} mm",
        )
    radius = None if solid.shaft_diameter is None else solid.shaft_diameter / 2.0
    return Dimensions(
        land, hole, shaft, radius, held, screw_held, held_radii, groove_ends, tuple(assumed), tuple(mesh_only)
    )
