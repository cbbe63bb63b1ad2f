"""Idealised screw and nut for the compliance between contacts: beam sections, smooth bodies, fixed surfaces.

Everything here depends only on the geometry of a scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from rollbench.lowfi.compliance import groove, tube
from rollbench.lowfi.compliance.tube import HalfGroove
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Ingredients, Scene
from rollbench.meshes.section import BeamSection, screw_section, tube_section
from rollbench.meshes.solid import dimensions_of_3d_parts
from rollbench.meshes.washers import has_washers

#: Least standard deviation of the load patch on smooth bodies, over the ball's radius; it applies to steep contact angles.
LEAST = 0.5
#: Numbers of the left and the right flank of a groove.
BOTH = (0, 1)
#: Fixed surface of the nut (`lowfi.compliance.tube.SmoothBody.held`) by the value of the scene's key.
HELD = {
    "left face": "low",
    "right face": "high",
    "both faces": "both",
    "outer surface": "outer",
    "flange face": "flange",
    "flange face and centring": "flange",
}
#: Fixed surfaces for which the nut, as a beam, has a clamped end.
CLAMPED = ("low", "high", "both", "flange")


@dataclass(frozen=True)
class ComplianceModel:
    """Models for the elastic compliance of screw, nut and balls in addition to Hertz contact."""

    #: Stiffnesses of the screw's beam: from the cross-section in the scene (``"scene"``, eq. C.8 of Lin's thesis), or by
    #: finite elements of half a lead with its groove (``"cell"``).
    section: Literal["scene", "cell"] = "cell"
    #: Model of the screw: a beam only, or (``"kernel"``) a beam with an elastic body of revolution added, solved by Fourier
    #: harmonics.
    screw: Literal["beam", "kernel"] = "kernel"
    #: Model of the nut: rigid apart from its contacts, a beam, or (``"kernel"``) a beam with an elastic body of revolution
    #: added.
    nut: Literal["rigid", "beam", "kernel"] = "kernel"
    #: Model of a ball: two half spaces (Hertz) or an elastic sphere.
    ball: Literal["half space", "sphere"] = "sphere"
    #: Standard deviation of the Gaussian load patch by which a contact loads the smooth body without grooves, divided by
    #: the radial distance of the contact from the ball's centre.
    width: float = 1.0
    #: Model of the nut's grooves: a ``"layer"`` that is softer along the axis than around it, or a smooth bore that gives
    #: the nut the same mean cube of the wall thickness (``"ring"``) or the same ``"volume"`` as with grooves, or that has
    #: the radius of the lands (``"land"``).
    bore: Literal["layer", "ring", "volume", "land"] = "layer"
    #: Number of Fourier harmonics around the axis, as a multiple of the default number.
    harmonics: float = 1.0
    #: Fineness of the finite elements as a multiple of the default fineness.
    mesh: float = 1.0
    #: Whether the local compliance of the flank at each contact is added to Hertz's law; if not, the flank deforms as a
    #: half space.
    flank: bool = True


#: The refined model, and the models between that of Lin's thesis and the refined one, by name.
REFINED = ComplianceModel()
LADDER = {
    "lin": ComplianceModel("scene", "beam", "rigid", "half space", flank=False),
    "lin-cell": ComplianceModel("cell", "beam", "rigid", "half space", flank=False),
    "lin-nut": ComplianceModel("cell", "beam", "beam", "half space", flank=False),
    "refined": REFINED,
}
#: Statement in reports on a body without compliance.
RIGID = "rigid apart from the Hertzian contacts"


def idealisation_statements(backend: ComplianceModel, scene: Scene) -> tuple[str, ...]:
    """Return three phrases that say how a compliance model idealises the screw, the nut and the balls of a scene.

    ``backend``: model of the bodies' compliance. Raises ValueError, as `meshes.solid.dimensions_of_3d_parts`, if the
    dimensions are impossible.
    """
    ring = scene.track.lead == 0.0
    section = "Lin C.8" if backend.section == "scene" else "half a lead of its groove"
    smooth = "; beyond that, a smooth body of revolution with each contact's own flank"
    nut = {
        "rigid": RIGID,
        "beam": "a Timoshenko tube of its grooved section",
        "kernel": f"a Timoshenko tube of its grooved section{smooth}",
    }[backend.nut]
    screw = f"a Timoshenko beam with the section of {section}{smooth if backend.screw == 'kernel' else ''}"
    if ring and backend.nut == "kernel":
        screw = nut = "a body of revolution with its groove, fixed as the scene says"
    elif scene.ingredients.screw == "rigid":
        screw = f"on a rigid axis{smooth}" if backend.screw == "kernel" else RIGID
    if fixed_surface(scene, True) == "rigid":
        screw = RIGID
    if fixed_surface(scene, False) == "rigid":
        nut = RIGID
    ball = "half spaces at their contacts" if backend.ball == "half space" else "elastic spheres"
    return f"the screw or inner ring is {screw}", f"the nut or outer ring is {nut}", f"balls are {ball}"


@lru_cache(maxsize=64)
def reduce_to_compliance_geometry(scene: Scene) -> Scene:
    """Return a scene reduced to the geometry and materials on which the compliance of screw and nut depends.

    Loads, supports, manufacturing errors, names and settings of solvers are removed, so that equal geometries share cached
    results.
    """
    return Scene(
        "",
        "",
        scene.track,
        scene.screw,
        scene.nut,
        replace(scene.balls, azimuths=(scene.track.phase,)),
        solid=scene.solid,
        ingredients=Ingredients(screw=scene.ingredients.screw),
    )


@lru_cache(maxsize=64)
def compliance_geometry_with_balls(scene: Scene) -> tuple[Scene, Array]:
    """Return the scene reduced to what its compliance depends on, with all N balls, and their azimuths ``(N,)`` [rad]."""
    return replace(reduce_to_compliance_geometry(scene), balls=scene.balls), ball_layout(scene).azimuth


@lru_cache(maxsize=64)
def half_groove_of_body(scene: Scene, screw: bool) -> HalfGroove:
    """Return half a groove with the body below it: half a lead of screw or nut, or half the width of a bearing ring.

    ``screw``: whether the body is the screw (True) or the nut. Raises ValueError for impossible dimensions.
    """
    dims = dimensions_of_3d_parts(scene)
    m = GrooveMap.from_scene(scene)
    low, high = dims.ends_of_meshed_screw(scene)
    width = min(scene.nut.length, high - low) if screw else scene.nut.length
    half = np.pi * abs(m.rg) / m.starts if m.rg != 0.0 else 0.5 * width
    land = scene.screw.outer_diameter / 2.0 if screw else dims.land
    far = scene.screw.bore / 2.0 if screw else scene.nut.outer_diameter / 2.0
    return HalfGroove(m, land, far, screw, float(half), (scene.screw if screw else scene.nut).material)


@lru_cache(maxsize=64)
def fixed_surface(scene: Scene, screw: bool) -> str:
    """Return the name of the surface at which screw or nut is fixed, such as "bore" or "flange"; "rigid" for a rigid body.

    The names are those of `SmoothBody.held`. ``screw``: whether the body is the screw (True) or the nut.
    """
    dims, washers = dimensions_of_3d_parts(scene), has_washers(scene)
    if not screw:
        return "rigid" if scene.solid.nut == "rigid" else "back" if washers else HELD[dims.nut_held.partition(", ")[0]]
    if washers:
        return "back"
    if dims.screw_held == "bore":
        return "bore"
    return "rigid" if scene.ingredients.screw == "rigid" else "section"


@lru_cache(maxsize=64)
def grooved_section(geometry: Scene, screw: bool) -> BeamSection:
    """Return the beam section (stiffnesses) of the grooved screw or nut, or of the plain shaft if the track has no lead.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw (True) or the nut.
    """
    if geometry.track.lead == 0.0 and screw:
        return screw_section(geometry)
    return grooved_body_section(half_groove_of_body(geometry, screw))


@lru_cache(maxsize=64)
@cached_on_disk(BeamSection)
def grooved_body_section(flank: HalfGroove) -> BeamSection:
    """Return the beam section (stiffnesses) of a grooved screw or nut, computed by finite elements of half a lead.

    The result is cached on disk for each groove, so that scenes with the same screw but another nut share it.
    """
    if flank.groove_map.rg == 0.0:
        return tube_section(2.0 * flank.plain_radius, 2.0 * groove.equivalent_cylinder_radius(flank, 2), flank.material)
    return tube.grooved_beam_section(flank)


def smooth_body(geometry: Scene, screw: bool, backend: ComplianceModel) -> tube.SmoothBody:
    """Return the smooth body of revolution, without grooves, that represents screw or nut.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw (True) or the nut;
    ``backend``: model of the bodies.
    """
    flank = half_groove_of_body(geometry, screw)
    low, high = dimensions_of_3d_parts(geometry).ends_of_meshed_screw(geometry)
    half, position = geometry.nut.length / 2.0, geometry.nut.position
    layer = None
    if screw:
        bore, outer, ends = flank.plain_radius, groove.equivalent_cylinder_radius(flank, 2), (low, high)
    else:
        bore, outer, ends = flank.land_radius, flank.plain_radius, (position - half, position + half)
        if backend.bore in ("ring", "volume"):
            bore = groove.equivalent_cylinder_radius(flank, 3 if backend.bore == "ring" else 2)
        elif backend.bore == "layer":
            layer = groove.groove_layer(flank, grooved_section(geometry, False))
    radius = flank.contact_position()[0]
    width = backend.width * geometry.balls.radius * max(float(np.cos(geometry.track.contact_angle)), LEAST)
    count = int(np.ceil(backend.harmonics * 2.2 * radius / width))
    size = (1.6 * width / backend.mesh, 0.75 * width / backend.mesh)
    flange = None if screw else geometry.nut.flange
    return tube.SmoothBody(
        bore, outer, ends, fixed_surface(geometry, screw), radius, float(width), count, size, flank.material, layer, flange
    )


def is_elastic_bearing_ring(geometry: Scene, screw: bool) -> bool:
    """Return whether a body is a bearing ring that is elastic and, with its groove, a body of revolution.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw or inner ring (True),
    or the nut or outer ring.
    """
    return geometry.track.lead == 0.0 and fixed_surface(geometry, screw) not in ("rigid", "section")


def nut_beam_ends_and_clamps(body: tube.SmoothBody) -> tuple[tuple[float, float], str]:
    """Return the axial positions of both ends of the beam that represents a nut [m], then which of them are clamped.

    The clamped ends are "low", "high" or "both", as for `clamped_beam_compliance`. ``body``: smooth body of the nut. A nut
    with a flange is clamped at the flange's face, or where its bonded fit ends. The deformation of the flange belongs to
    the smooth body.
    """
    if body.held != "flange" or body.flange is None:
        return body.ends, body.held
    base = body.flange.stations(*body.ends)[2 if body.flange.bonded else 1]
    return (base, base), "low"


def compliance_block_of_flanks(G: Array, flanks: Sequence[int]) -> Array:
    """Return the block ``(2 c, 2 c)`` of a compliance matrix that belongs to the c contacts on given flanks.

    ``G``: matrix for both flanks of N balls (4 N, 4 N), left flank first; ``flanks``: flanks of the result, 0 left, 1
    right.
    """
    if len(flanks) == len(BOTH):
        return G
    half, chosen = len(G) // 2, list(flanks)
    return G.reshape(2, half, 2, half)[chosen][:, :, chosen].reshape((half * len(chosen),) * 2)
