"""Dimensions of the parts that only the 3D reference needs: as the scene gives them, or assumed.

Each assumption is stated in a sentence, for the report.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.fields import keyed, usual
from rollbench.meshes.helix import groove_radii, nominal_groove_centres
from rollbench.meshes.parts import Scene, UnfitKey

#: Hole assumed along the axis of a solid screw, over the pitch radius: the mesh needs one; its effect is part of the
#: modelling spread.
HOLE = 1.0 / 11.0
#: Distance [m] below which stations count as one.
SAME = 1e-9
#: 3D stretch of shaft assumed beyond each face of the nut, over the pitch radius.
SHAFT = 1.5
#: Of a nut's groove that is filled beyond the loaded balls: length of whole groove beyond the middle of the outermost ball,
#: and of the run-out there, in ball diameters.
WHOLE, RUN_OUT = 1.0, 1.0


@keyed
@dataclass(frozen=True)
class Dimensions:
    """Dimensions of the solid parts, given or assumed."""

    #: Radius of the nut's lands [m].
    land: float
    #: Radius of the hole along the screw [m].
    hole: float
    #: Length of 3D shaft beyond each face of the nut [m].
    shaft: float
    #: Radius of the shaft beyond that [m]; None: the homogenised grooved shaft.
    shaft_radius: float | None
    #: Surface by which the nut is fixed.
    nut_held: str
    #: Whether supports and loads reach the screw through its ``"ends"`` or through a stiff shaft in its ``"bore"``.
    screw_held: str
    #: Radii between which a face of the nut is fixed [m].
    held_radii: tuple[float, float]
    #: Whether the nut's groove ends beyond its loaded balls.
    groove_ends: bool
    #: All assumptions, as sentences.
    assumed: tuple[str, ...]
    #: Those assumptions that only a mesh needs.
    mesh_only: tuple[str, ...] = usual(())

    def ends(self, scene: Scene) -> tuple[float, float]:
        """Stations of the flat ends of the 3D stretch of the screw.

        A support or load within `SAME` of an end is at that end, though their numbers differ by rounding: what acts on
        the whole flat end would otherwise act on the hole's surface just inside it.

        Parameters
        ----------
        scene : Scene
            Gives nut, screw, supports and loads.

        Returns
        -------
        low, high : float
            Stations [m].
        """
        half = scene.nut.length / 2.0 + self.shaft
        ends = max(scene.nut.position - half, 0.0), min(scene.nut.position + half, scene.screw.length)
        stations = [*(s.at for s in scene.supports), *(x.at for x in scene.loads)]
        low, high = (next((z for z in stations if abs(z - end) <= SAME), end) for end in ends)
        return low, high


def groove_depths(scene: Scene) -> tuple[float, float]:
    """Depths of the nominal grooves below the pitch cylinder, at their bottoms.

    The bottom is where both arcs meet, or that of one arc. In a wide groove the depth is far less than the groove's
    radius.

    Parameters
    ----------
    scene : Scene
        Gives radii and contact angle.

    Returns
    -------
    screw, nut : float
        Depths [m].

    Examples
    --------
    >>> import rollbench
    >>> [round(1e3 * x, 3) for x in groove_depths(rollbench.read("lin-case1"))]  # mm
    [2.9, 2.9]
    """
    radial, across = np.abs(nominal_groove_centres(scene)).T
    screw, nut = (np.sqrt(groove_radii(scene) ** 2 - across**2) - radial)[[0, 3]]
    return float(screw), float(nut)


def _check_lands(scene: Scene, land: float, depth: float) -> None:
    """Raise ValueError, naming the scene's key, where lands of radius ``land`` [m] leave the nut no groove or no wall.

    depth: of the nut's groove below the pitch cylinder [m].
    """
    pitch, outer = 2e3 * scene.track.pitch_radius, 1e3 * scene.screw.outer_diameter
    most = pitch + 2e3 * depth
    diameter = 2e3 * land
    if diameter >= 1e3 * scene.nut.outer_diameter and pitch < diameter < most:
        wall = f"the nut's lands of {diameter:.4g} mm diameter leave no wall"
        raise UnfitKey("nut.outer_diameter", f"nut.outer_diameter of {1e3 * scene.nut.outer_diameter:.4g} mm: {wall}")
    if pitch < diameter < most:
        return
    if scene.solid.nut_inner_diameter is not None:
        between = f"it must lie between the pitch diameter {pitch:.4g} mm and {most:.4g} mm"
        raise UnfitKey(
            "solid.nut_inner_diameter", f"solid.nut_inner_diameter of {diameter:.4g} mm leaves no groove: {between}"
        )
    raise UnfitKey(
        "screw.outer_diameter",
        f"screw.outer_diameter of {outer:.4g} mm with a pitch diameter of {pitch:.4g} mm leaves no groove: the nut's lands "
        f"mirror the screw's, which must lie between {pitch - 2e3 * depth:.4g} mm and the pitch diameter; mend one of the "
        "two, or give the nut's lands by solid.nut_inner_diameter",
    )


def solid_dimensions(scene: Scene) -> Dimensions:
    """Dimensions of a scene's solid parts; what the scene leaves out is assumed.

    Parameters
    ----------
    scene : Scene
        Screw or bearing.

    Returns
    -------
    Dimensions
        Dimensions, with the assumptions as sentences.

    Raises
    ------
    UnfitKey
        Land or hole leave no groove or no wall, or keys of ``[solid]`` contradict the parts.
    """
    solid, assumed, mesh_only = scene.solid, [], []
    R, outer = scene.track.pitch_radius, scene.screw.outer_diameter / 2.0
    if solid.nut_inner_diameter is None:
        land = 2.0 * R - outer
        assumed.append(f"Nut lands of {2e3 * land:.4g} mm diameter: the screw's lands mirrored about the pitch cylinder.")
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
        assumed.append(f"The nut is held at its {held}.")
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
        if screw_held == "bore":
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
                'solid.nut_groove of "loaded" needs a lead: the groove of a ring does not end; leave it out',
            )
        assumed.append("Flat ends of the rings, without chamfers.")
    elif groove_ends:
        assumed.append(
            f"The nut's groove is whole up to {WHOLE:.3g} ball diameter beyond its outermost balls and filled from "
            f"{WHOLE + RUN_OUT:.3g} on; that of the screw runs through its whole 3D stretch; flat nut faces."
        )
    else:
        assumed.append("The groove runs through the whole nut and the whole 3D stretch of the screw; flat nut faces.")
    of_screw, of_nut = groove_depths(scene)
    _check_lands(scene, land, of_nut)
    if not 0.0 < hole < R - of_screw:
        raise UnfitKey(
            "solid.hole_diameter",
            f"the hole of {2e3 * hole:.4g} mm diameter along the screw leaves no wall under the groove, which needs it "
            f"below {2e3 * (R - of_screw):.4g} mm: set solid.hole_diameter",
        )
    return Dimensions(
        land,
        hole,
        shaft,
        None if solid.shaft_diameter is None else solid.shaft_diameter / 2.0,
        held,
        screw_held,
        held_radii,
        groove_ends,
        tuple(assumed),
        tuple(mesh_only),
    )
