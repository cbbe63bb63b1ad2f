"""Idealisation of screw and nut between their contacts, by backend: grooved sections, smooth bodies, where they are fixed.

Everything here depends only on a scene's geometry. Finite elements are imported where a geometry is not cached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from rollbench.lowfi.compliance.beyond_hertz import Flank
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import Ingredients, Scene
from rollbench.meshes.section import BeamSection, screw_section, tube_section
from rollbench.meshes.solid import dimensions

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.tube import Tube

#: Least width of the kernels' patch over the ball's radius, for steep contact angles.
LEAST = 0.5
#: Left and right flank of a groove.
BOTH = (0, 1)
#: Fixings of the nut by the name of the scene's key.
HELD = {
    "left face": "low",
    "right face": "high",
    "both faces": "both",
    "outer surface": "outer",
    "flange face": "flange",
    "flange face and centring": "flange",
}
#: Those with a beam's clamped end.
CLAMPED = ("low", "high", "both", "flange")


@dataclass(frozen=True)
class Backend:
    """Model of the compliance of screw, nut and balls beyond Hertz's contacts."""

    #: Section of the screw's beam, the scene's (Lin C.8) or the grooved cell's.
    section: Literal["scene", "cell"] = "cell"
    #: Screw as a beam, or also with the Fourier kernel beyond it.
    screw: Literal["beam", "kernel"] = "kernel"
    #: Nut rigid beyond its contacts, as a beam, or with the Fourier kernel.
    nut: Literal["rigid", "beam", "kernel"] = "kernel"
    #: Ball as two half spaces (Hertz) or as an elastic sphere.
    ball: Literal["half space", "sphere"] = "sphere"
    #: Standard deviation of the kernels' patch over half the distance of the two flanks' contacts across the groove.
    width: float = 1.0
    #: Nut's grooves as a ``"layer"`` softer along the axis than around it, or a plain bore that keeps the mean wall^3
    #: (``"ring"``) or the ``"volume"``, or lies at the lands (``"land"``).
    bore: Literal["layer", "ring", "volume", "land"] = "layer"
    #: Number of harmonics as a multiple of the chosen one.
    harmonics: float = 1.0
    #: Fineness of the elements as a multiple of the chosen one.
    mesh: float = 1.0
    #: Whether each contact has its own flank; otherwise a half space at the smooth surface.
    flank: bool = True


#: The refined model and the steps that lead to it from the source's.
REFINED = Backend()
LADDER = {
    "lin": Backend("scene", "beam", "rigid", "half space", flank=False),
    "lin-cell": Backend("cell", "beam", "rigid", "half space", flank=False),
    "lin-nut": Backend("cell", "beam", "beam", "half space", flank=False),
    "refined": REFINED,
}
#: Statement for a body without compliance.
RIGID = "rigid apart from the Hertzian contacts"


def idealisation_statements(backend: Backend, scene: Scene) -> tuple[str, ...]:
    """Return statements on how a backend idealises a scene's bodies; raises ValueError as `meshes.solid.dimensions`."""
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
        screw = nut = "a body of revolution with its groove, held as the scene says"
    elif scene.ingredients.screw == "rigid":
        screw = f"on a rigid axis{smooth}" if backend.screw == "kernel" else RIGID
    if fixed_surface(scene, True) == "rigid":
        screw = RIGID
    if fixed_surface(scene, False) == "rigid":
        nut = RIGID
    ball = "half spaces at their contacts" if backend.ball == "half space" else "elastic spheres"
    return f"the screw or inner ring is {screw}", f"the nut or outer ring is {nut}", f"balls are {ball}"


@lru_cache(maxsize=64)
def geometry_only(scene: Scene) -> Scene:
    """Return the scene with only what the bodies' compliance depends on: no loads, supports, errors, names and choices."""
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
def with_balls(scene: Scene) -> tuple[Scene, Array]:
    """Return the scene with only the parts and the balls' positions, and their azimuths ``(N,)`` [rad]."""
    return replace(geometry_only(scene), balls=scene.balls), ball_layout(scene).azimuth


@lru_cache(maxsize=64)
def groove_of_body(scene: Scene, screw: bool) -> Flank:
    """Return the groove of screw or nut on half a lead, or half a ring's width; ValueError for impossible dimensions."""
    dims = dimensions(scene)
    m = GrooveMap.of(scene)
    low, high = dims.ends(scene)
    width = min(scene.nut.length, high - low) if screw else scene.nut.length
    half = np.pi * abs(m.rg) / m.starts if m.rg != 0.0 else 0.5 * width
    land = scene.screw.outer_diameter / 2.0 if screw else dims.land
    far = scene.screw.bore / 2.0 if screw else scene.nut.outer_diameter / 2.0
    return Flank(m, land, far, screw, float(half), (scene.screw if screw else scene.nut).material)


@lru_cache(maxsize=64)
def fixed_surface(scene: Scene, screw: bool) -> str:
    """Return where the smooth body is fixed (see `Tube`); "rigid" where the body does not move beyond its contacts."""
    dims = dimensions(scene)
    if not screw:
        return "rigid" if scene.solid.nut == "rigid" else HELD[dims.nut_held.partition(", ")[0]]
    if dims.screw_held == "bore":
        return "bore"
    return "rigid" if scene.ingredients.screw == "rigid" else "section"


@lru_cache(maxsize=64)
def grooved_section(geometry: Scene, screw: bool) -> BeamSection:
    """Return section constants of the grooved screw or nut (`cell_section`); of the plain body for a track without lead."""
    if geometry.track.lead == 0.0 and screw:
        return screw_section(geometry)
    return section_of(groove_of_body(geometry, screw))


@lru_cache(maxsize=64)
@kept(BeamSection)
def section_of(flank: Flank) -> BeamSection:
    """Return the section constants of a grooved body, cached for scenes whose other body differs."""
    from rollbench.lowfi.compliance.groove import smooth_radius
    from rollbench.lowfi.compliance.tube import cell_section

    if flank.map.rg == 0.0:
        return tube_section(2.0 * flank.far, 2.0 * smooth_radius(flank, 2), flank.material)
    return cell_section(flank.map, flank.land, flank.far, flank.screw, flank.material).section


def smooth_body(geometry: Scene, screw: bool, backend: Backend) -> Tube:
    """Return the smooth body of revolution that represents screw or nut."""
    from rollbench.lowfi.compliance.groove import groove_layer, smooth_radius
    from rollbench.lowfi.compliance.tube import Tube

    flank = groove_of_body(geometry, screw)
    low, high = dimensions(geometry).ends(geometry)
    half, position = geometry.nut.length / 2.0, geometry.nut.position
    if screw:
        bore, outer, ends = flank.far, smooth_radius(flank, 2), (low, high)
    else:
        bore = (
            smooth_radius(flank, 3 if backend.bore == "ring" else 2) if backend.bore in ("ring", "volume") else flank.land
        )
        outer, ends = flank.far, (position - half, position + half)
    layer = None if screw or backend.bore != "layer" else groove_layer(flank, grooved_section(geometry, False))
    radius = flank.contact()[0]
    width = backend.width * geometry.balls.radius * max(float(np.cos(geometry.track.contact_angle)), LEAST)
    count = int(np.ceil(backend.harmonics * 2.2 * radius / width))
    size = (1.6 * width / backend.mesh, 0.75 * width / backend.mesh)
    flange = None if screw else geometry.nut.flange
    return Tube(
        bore, outer, ends, fixed_surface(geometry, screw), radius, float(width), count, size, flank.material, layer, flange
    )


def is_ring(geometry: Scene, screw: bool) -> bool:
    """Return whether a body is a ring with one groove around it, and so a body of revolution itself."""
    return geometry.track.lead == 0.0 and fixed_surface(geometry, screw) not in ("rigid", "section")


def nut_beam_ends(tube: Tube) -> tuple[tuple[float, float], str]:
    """Return the ends [m] of the beam that represents a nut, and which of them are clamped.

    A flange clamps it at its face, or where its bonded fit ends, and deforms as the smooth body does.
    """
    if tube.held != "flange" or tube.flange is None:
        return tube.ends, tube.held
    base = tube.flange.stations(*tube.ends)[2 if tube.flange.bonded else 1]
    return (base, base), "low"


def of_flanks(G: Array, flanks: Sequence[int]) -> Array:
    """Return rows and columns of some flanks ``(2 c, 2 c)`` of a matrix of both ``(4 N, 4 N)``."""
    if len(flanks) == len(BOTH):
        return G
    half = len(G) // 2
    return np.concatenate([np.concatenate([G[i * half :][:half, j * half :][:, :half] for j in flanks], 1) for i in flanks])
