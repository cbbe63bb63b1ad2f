"""Write the parts of a scene as STEP files, by OpenCASCADE in gmsh; lengths are in mm.

Balls and bodies of revolution are exact solids. Flanks of helical grooves are B-spline surfaces: lofts through exact arcs,
`SECTIONS` of them for each turn. Each arc lies in a plane normal to the helix and ends at apex and land.
`largest_distance_from_flank` measures how far the loft deviates from the exact flank between its arcs.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from math import asin, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.groove import points_from_cylindrical
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.shell import gmsh_session
from rollbench.meshes.solid import dimensions_of_3d_parts

#: Number of arcs through which a flank is lofted, for each turn of the helix.
SECTIONS = 48
#: Number of points along each of a surface's two parameters at which its distance from the exact flank is measured.
SAMPLES = 120
#: Millimetres per metre.
MM = 1e3


class PlacedNutOrBearing(NamedTuple):
    """Parts of one ball nut or bearing for a STEP file, and their axial positions on the shaft."""

    #: Parts of the ball nut or bearing.
    scene: Scene
    #: Displacement of the nut or outer ring along z, from its position in ``scene`` [m].
    nut_displacement: float
    #: Axial positions of the two ends of the shaft segment that is written with this nut or bearing [m].
    shaft_segment_ends: tuple[float, float]


def write_step(path: Path, nuts_and_bearings: Sequence[PlacedNutOrBearing]) -> dict[Path, float]:
    """Write shaft, nuts or rings, and balls as STEP files.

    Bodies with helical grooves are written without grooves. The flanks of these grooves are surfaces in a second file,
    ``NAME-grooves.step``.

    Parameters
    ----------
    path : Path
        File of the solid bodies.
    nuts_and_bearings : Sequence[PlacedNutOrBearing]
        Parts of each ball nut or bearing.

    Returns
    -------
    dict[Path, float]
        For each file written, the largest distance [m] of its surfaces from the exact surfaces; 0 where they are exact.

    Raises
    ------
    OSError
        A file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with _new_gmsh_model() as gmsh:
        for scene, shift, ends in nuts_and_bearings:
            body = _add_grooved_ring if scene.track.lead == 0.0 else _add_tube_without_groove
            layout = ball_layout(scene)
            radii = draw_geometry_with_errors(scene, layout).ball_radii.tolist()
            for radius, centre in zip(radii, layout.centre, strict=True):
                gmsh.model.occ.addSphere(*(MM * centre), MM * radius)
            body(gmsh, scene, ends, screw=True)
            body(gmsh, scene, _nut_face_positions(scene, shift), screw=False)
        gmsh.model.occ.synchronize()
        _write_model(gmsh, path)
    if all(scene.track.lead == 0.0 for scene, _, _ in nuts_and_bearings):
        return {path: 0.0}
    grooves, worst = path.with_name(f"{path.stem}-grooves.step"), 0.0
    with _new_gmsh_model() as gmsh:
        for scene, shift, ends in nuts_and_bearings:
            for side in range(len(SIDES)):
                faces = ends if side < 2 else _nut_face_positions(scene, shift)
                worst = max(worst, _add_helical_flank(gmsh, scene, side, faces, shift if side >= 2 else 0.0))
        _write_model(gmsh, grooves)
    return {path: 0.0, grooves: worst}


@contextmanager
def _new_gmsh_model() -> Iterator[Any]:
    """Create an empty gmsh model with lengths in mm for a ``with`` block; yields the module gmsh."""
    with gmsh_session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.model.add("step")
        yield gmsh


def _write_model(gmsh: Any, path: Path) -> None:
    """Write gmsh's model to the file ``path``, and suppress the messages that OpenCASCADE prints meanwhile."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        gmsh.write(str(path))
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def _nut_face_positions(scene: Scene, shift: float) -> tuple[float, float]:
    """Return the axial positions of the two faces of the nut or outer ring [m].

    ``shift``: displacement of the nut or outer ring along z [m].
    """
    half = scene.nut.length / 2.0
    return scene.nut.position - half + shift, scene.nut.position + half + shift


def _land_and_back_radii(scene: Scene, *, screw: bool) -> tuple[float, float]:
    """Return the radius of the lands, and that of the surface behind the groove: screw's bore or nut's outside [m].

    ``screw``: whether they are those of the screw (or inner ring), or of the nut (or outer ring).
    """
    dims = dimensions_of_3d_parts(scene)
    if screw:
        return scene.screw.outer_diameter / 2.0, scene.screw.bore / 2.0 or dims.hole
    return dims.land, scene.nut.outer_diameter / 2.0


def _add_tube_without_groove(gmsh: Any, scene: Scene, ends: tuple[float, float], *, screw: bool) -> None:
    """Add a screw or its nut to gmsh's model, as a tube without the helical groove.

    ``ends``: axial positions of the tube's ends [m]; ``screw``: whether to add the screw (True) or the nut (False).
    """
    occ, (low, high) = gmsh.model.occ, ends
    inner, outer = sorted(_land_and_back_radii(scene, screw=screw))
    tubes = [(3, occ.addCylinder(0, 0, MM * low, 0, 0, MM * (high - low), MM * r)) for r in (outer, inner)]
    occ.cut(tubes[:1], tubes[1:])


def _add_grooved_ring(gmsh: Any, scene: Scene, ends: tuple[float, float], *, screw: bool) -> None:
    """Add a bearing ring with its groove to gmsh's model, as a solid of revolution of its cross-section.

    ``ends``: axial positions of its two faces [m]; ``screw``: whether to add the inner (True) or outer ring (False).
    """
    occ, (land, wall), m = gmsh.model.occ, _land_and_back_radii(scene, screw=screw), groove_map_with_errors(scene)
    sides = (0, 1) if screw else (2, 3)

    def add_point_in_section(radius: float, z: float) -> int:
        """Add a point in the plane y = 0 at a radius and an axial position [m], and return its number in gmsh."""
        return int(occ.addPoint(MM * radius, 0.0, MM * z))

    flanks = []
    for side in sides:
        radial, across = m.polar_to_section(side, np.array(section_angles_of_edges(m, side, land)), m.radius[side])
        flanks.append(np.column_stack([m.R + radial, m.z0 + across]))
    (apex, left), (_, right) = flanks
    outline = ((wall, ends[0]), (land, ends[0]), left, apex, right, (land, ends[1]), (wall, ends[1]))
    corners = [add_point_in_section(*point) for point in outline]
    middles = [add_point_in_section(m.R + x, m.z0 + y) for x, y in m.centre[list(sides)]]
    lines = [occ.addLine(corners[0], corners[1]), occ.addLine(corners[1], corners[2])]
    lines += [occ.addCircleArc(a, middle, b) for (a, b), middle in zip(pairwise(corners[2:5]), middles, strict=True)]
    lines += [occ.addLine(a, b) for a, b in pairwise([*corners[4:], corners[0]])]
    section = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2.0 * pi)


def groove_map_with_errors(scene: Scene, shift: float = 0.0) -> GrooveMap:
    """Return the groove surfaces of a scene with the errors at its first ball.

    ``shift``: displacement of the nut or outer ring along z [m].
    """
    drawn, nominal = draw_geometry_with_errors(scene, ball_layout(scene)), GrooveMap.from_scene(scene)
    return replace(nominal, centre=drawn.groove_centres[0], radius=drawn.groove_radii, z0=nominal.z0 + shift)


def section_angles_of_edges(m: GrooveMap, side: int, land: float) -> tuple[float, float]:
    """Return the section angles at which a flank meets the other flank of its groove (apex), and the land.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    land : float
        Radius of the land [m].

    Returns
    -------
    apex, edge : float
        Angles around the arc of the flank, from the radial direction [rad].
    """
    sx, sz = m.signs[side]
    apex = asin(-float(m.centre[side, 1]) * sz / float(m.radius[side]))
    low, high = apex, pi / 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = sx * (float(m.flank_to_unrolled(side, np.array(middle))[0]) - land) > 0.0
        low, high = (middle, high) if inside else (low, middle)
    return apex, low


def _add_helical_flank(gmsh: Any, scene: Scene, side: int, ends: tuple[float, float], shift: float) -> float:
    """Add the surface of a helical flank to gmsh's model, as a loft through exact arcs.

    ``side``: flank 0 to 3; ``ends``: axial positions between which it extends [m]; ``shift``: displacement of the nut along
    z [m]. Returns the largest distance [m] between the loft and the exact flank.
    """
    occ, m = gmsh.model.occ, groove_map_with_errors(scene, shift)
    gamma = np.linspace(*section_angles_of_edges(m, side, _land_and_back_radii(scene, screw=side < 2)[0]), 3)
    r, zeta, turn = m.flank_to_unrolled(side, gamma)
    first, last = sorted(m.phase + (z - m.z0) / m.rg for z in ends)
    wires = []
    for azimuth in np.linspace(first, last, 1 + int(np.ceil((last - first) / (2.0 * pi) * SECTIONS))):
        phi = azimuth + turn
        arc = points_from_cylindrical(r, phi, m.z0 + zeta + m.rg * (phi - m.phase))
        wires.append(occ.addWire([occ.addCircleArc(*(occ.addPoint(*(MM * p)) for p in arc), center=False)]))
    surfaces = [tag for dim, tag in occ.addThruSections(wires, makeSolid=False, maxDegree=3) if dim == 2]
    occ.synchronize()
    return max(largest_distance_from_flank(gmsh, m, side, tag) for tag in surfaces)


def largest_distance_from_flank(gmsh: Any, m: GrooveMap, side: int, tag: int) -> float:
    """Return the largest distance between a surface in gmsh's model and the exact surface of a groove flank.

    Parameters
    ----------
    gmsh : Any
        The module gmsh, with the model.
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    tag : int
        Number of the surface in the model.

    Returns
    -------
    float
        Largest distance [m], at `SAMPLES` points along each of the surface's two parameters.
    """
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, tag)
    u, v = np.meshgrid(np.linspace(u0, u1, SAMPLES), np.linspace(v0, v1, SAMPLES))
    p = np.reshape(gmsh.model.getValue(2, tag, np.column_stack([u.ravel(), v.ravel()]).ravel()), (-1, 3)) / MM
    return float(np.abs(m.distances_from_flank(side, p)).max())
