"""STEP files of a scene's parts by gmsh's OpenCASCADE, lengths in mm.

Balls and bodies of revolution are exact solids, flanks of helical grooves B-spline surfaces through exact arcs: a flank
is a loft through its arcs, `SECTIONS` to a turn. An arc lies in the plane normal to the helix, so that its ends at apex
and land are on the surface too. `largest_distance` measures how far the loft deviates between its sections.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import asin, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout, layout_at, reduced_lead
from rollbench.meshes.parts import SIDE_SIGNS, SIDES, Scene
from rollbench.meshes.shell import gmsh_session
from rollbench.meshes.solid import solid_dimensions

#: Sections of a loft to a turn of the helix.
SECTIONS = 48
MM = 1e3


class PlacedSet(NamedTuple):
    """Parts of one rolling set, and where they are."""

    #: Parts of the set.
    scene: Scene
    #: Shift of its nut along z [m].
    shift: float
    #: Ends of its stretch of shaft [m].
    ends: tuple[float, float]


def write_step(path: Path, sets: Sequence[PlacedSet]) -> dict[Path, float]:
    """Write shaft, nuts and balls as STEP files.

    Where grooves are helical, their flanks are surfaces in a second file, ``NAME-grooves.step``; the bodies are without
    grooves.

    Parameters
    ----------
    path : Path
        File of the bodies.
    sets : Sequence[PlacedSet]
        Parts of each set.

    Returns
    -------
    dict[Path, float]
        Largest distance [m] of each file's surfaces from the exact ones; 0 where they are exact.

    Raises
    ------
    OSError
        A file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with _gmsh_model() as gmsh:
        for scene, shift, ends in sets:
            body = _add_ring if scene.track.lead == 0.0 else _add_tube
            for radius, centre in _add_balls(scene):
                gmsh.model.occ.addSphere(*(MM * centre), MM * radius)
            body(gmsh, scene, ends, screw=True)
            body(gmsh, scene, _face_positions(scene, shift), screw=False)
        gmsh.model.occ.synchronize()
        _write_model(gmsh, path)
    if all(scene.track.lead == 0.0 for scene, _, _ in sets):
        return {path: 0.0}
    grooves, worst = path.with_name(f"{path.stem}-grooves.step"), 0.0
    with _gmsh_model() as gmsh:
        for scene, shift, ends in sets:
            for side in range(len(SIDES)):
                faces = ends if side < 2 else _face_positions(scene, shift)
                worst = max(worst, _add_flank(gmsh, scene, side, faces, shift if side >= 2 else 0.0))
        _write_model(gmsh, grooves)
    return {path: 0.0, grooves: worst}


@contextmanager
def _gmsh_model() -> Iterator[Any]:
    with gmsh_session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.model.add("step")
        yield gmsh


def _write_model(gmsh: Any, path: Path) -> None:
    """Write the model's file, and suppress the output of OpenCASCADE."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        gmsh.write(str(path))
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def _add_balls(scene: Scene) -> Iterator[tuple[float, Array]]:
    layout = ball_layout(scene)
    yield from zip(specimen(scene, layout).ball_radius.tolist(), layout.centre, strict=True)


def _face_positions(scene: Scene, shift: float) -> tuple[float, float]:
    half = scene.nut.length / 2.0
    return scene.nut.position - half + shift, scene.nut.position + half + shift


def _wall_radii(scene: Scene, *, screw: bool) -> tuple[float, float]:
    """Radii of the land and of the other side of the wall [m]."""
    dims = solid_dimensions(scene)
    if screw:
        return scene.screw.outer_diameter / 2.0, scene.screw.bore / 2.0 or dims.hole
    return dims.land, scene.nut.outer_diameter / 2.0


def _add_tube(gmsh: Any, scene: Scene, ends: tuple[float, float], *, screw: bool) -> None:
    """Add a tube without its groove."""
    occ, (low, high) = gmsh.model.occ, ends
    inner, outer = sorted(_wall_radii(scene, screw=screw))
    tubes = [(3, occ.addCylinder(0, 0, MM * low, 0, 0, MM * (high - low), MM * r)) for r in (outer, inner)]
    occ.cut(tubes[:1], tubes[1:])


def _add_ring(gmsh: Any, scene: Scene, ends: tuple[float, float], *, screw: bool) -> None:
    """Add a ring with its groove, by turning its half section."""
    occ, (land, wall), z = gmsh.model.occ, _wall_radii(scene, screw=screw), scene.nut.position
    left, right = (
        _flank_points(scene, side, np.array([apex_angle(scene, side), land_angle(scene, side, land)]))
        for side in _flanks_of_body(screw)
    )
    R = scene.track.pitch_radius

    def point(r: float, at: float) -> int:
        return int(occ.addPoint(MM * r, 0.0, MM * at))

    corners = [point(wall, ends[0]), point(land, ends[0]), point(R + left[1, 0], z + left[1, 1])]
    apex = point(R + left[0, 0], z + left[0, 1])
    corners += [apex, point(R + right[1, 0], z + right[1, 1]), point(land, ends[1]), point(wall, ends[1])]
    middles = [point(R + x, z + y) for x, y in specimen(scene, ball_layout(scene)).centre[0, list(_flanks_of_body(screw))]]
    lines = [occ.addLine(corners[0], corners[1]), occ.addLine(corners[1], corners[2])]
    lines += [occ.addCircleArc(corners[2], middles[0], apex), occ.addCircleArc(apex, middles[1], corners[4])]
    lines += [occ.addLine(a, b) for a, b in ((corners[4], corners[5]), (corners[5], corners[6]), (corners[6], corners[0]))]
    section = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2.0 * pi)


def _flanks_of_body(screw: bool) -> tuple[int, int]:
    return (0, 1) if screw else (2, 3)


def _flank_points(scene: Scene, side: int, gamma: Array) -> Array:
    """Points ``(k, 2)`` (x3, z3) [m] of a flank at angles gamma ``(k,)`` [rad]."""
    drawn = specimen(scene, ball_layout(scene))
    (sx, sz), c = SIDE_SIGNS[side], drawn.centre[0, side]
    return np.asarray(c + drawn.radius[side] * np.column_stack([sx * np.cos(gamma), sz * np.sin(gamma)]))


def apex_angle(scene: Scene, side: int) -> float:
    """Section angle at which a flank meets the other one, at z3 = 0 [rad]."""
    drawn = specimen(scene, ball_layout(scene))
    return asin(-float(drawn.centre[0, side, 1]) * SIDE_SIGNS[side][1] / float(drawn.radius[side]))


def land_angle(scene: Scene, side: int, land: float) -> float:
    """Section angle at which a flank meets the land.

    Parameters
    ----------
    scene : Scene
        Parts.
    side : int
        Flank 0 to 3.
    land : float
        Radius of the land [m].

    Returns
    -------
    float
        [rad].
    """
    sign = SIDE_SIGNS[side][0]
    low, high = apex_angle(scene, side), pi / 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        point = _flank_points_at_azimuth(scene, side, np.array([middle]), 0.0, 0.0)[0]
        low, high = (middle, high) if sign * (np.hypot(point[0], point[1]) - land) > 0.0 else (low, middle)
    return low


def _flank_points_at_azimuth(scene: Scene, side: int, gamma: Array, azimuth: float, shift: float) -> Array:
    """Points ``(k, 3)`` [m] of a flank in the section at an azimuth [rad]; shift: of the nut along z [m]."""
    z = scene.nut.position + shift + reduced_lead(scene.track) * (azimuth - scene.track.phase)
    at = layout_at(scene.track, np.array([azimuth]), np.array([z]))
    x3, z3 = _flank_points(scene, side, gamma).T
    return np.asarray(at.centre + x3[:, None] * at.radial + z3[:, None] * at.binormal)


def _add_flank(gmsh: Any, scene: Scene, side: int, ends: tuple[float, float], shift: float) -> float:
    """Add a flank's loft between the sections through two ends; returns its largest distance [m] from the exact surface."""
    occ, lead = gmsh.model.occ, reduced_lead(scene.track)
    land = _wall_radii(scene, screw=side < 2)[0]
    gamma = np.linspace(apex_angle(scene, side), land_angle(scene, side, land), 3)
    first, last = sorted(scene.track.phase + (z - scene.nut.position - shift) / lead for z in ends)
    wires = []
    for azimuth in np.linspace(first, last, 1 + int(np.ceil((last - first) / (2.0 * pi) * SECTIONS))):
        points = [occ.addPoint(*(MM * p)) for p in _flank_points_at_azimuth(scene, side, gamma, float(azimuth), shift)]
        wires.append(occ.addWire([occ.addCircleArc(*points, center=False)]))
    surfaces = [tag for dim, tag in occ.addThruSections(wires, makeSolid=False, maxDegree=3) if dim == 2]
    occ.synchronize()
    return max(largest_distance(gmsh, scene, side, tag, shift) for tag in surfaces)


def largest_distance(gmsh: Any, scene: Scene, side: int, tag: int, shift: float, along: int = 120) -> float:
    """Largest distance of a surface of gmsh's model from a flank's exact surface.

    Parameters
    ----------
    gmsh : Any
        gmsh with the model.
    scene : Scene
        Parts.
    side : int
        Flank 0 to 3.
    tag : int
        The surface.
    shift : float
        Shift of the nut along z [m].
    along : int, default 120
        Points along each parameter.

    Returns
    -------
    float
        [m].
    """
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, tag)
    u, v = np.meshgrid(np.linspace(u0, u1, along), np.linspace(v0, v1, along))
    p = np.reshape(gmsh.model.getValue(2, tag, np.column_stack([u.ravel(), v.ravel()]).ravel()), (-1, 3)) / MM
    return float(np.abs(distances_from_flank(scene, side, p, shift)).max())


def distances_from_flank(scene: Scene, side: int, points: Array, shift: float) -> Array:
    """Distances of points from a flank, each measured in its section normal to the helix.

    Parameters
    ----------
    scene : Scene
        Parts.
    side : int
        Flank 0 to 3.
    points : (k, 3) Array
        Points [m].
    shift : float
        Shift of the nut along z [m].

    Returns
    -------
    (k,) Array
        Signed distances [m], positive beyond the arc's radius.
    """
    track, lead = scene.track, reduced_lead(scene.track)
    z0 = scene.nut.position + shift
    turn = np.arctan2(points[:, 1], points[:, 0])
    rough = track.phase + (points[:, 2] - z0) / lead
    azimuth = turn + 2.0 * pi * np.round((rough - turn) / (2.0 * pi))
    for _ in range(20):
        at = layout_at(track, azimuth, z0 + lead * (azimuth - track.phase))
        away = points - at.centre
        azimuth = azimuth + np.einsum("ij,ij->i", away, at.tangent) / np.hypot(track.pitch_radius, lead)
    drawn = specimen(scene, ball_layout(scene))
    x3, z3 = (np.einsum("ij,ij->i", away, axis) for axis in (at.radial, at.binormal))
    return np.asarray(np.hypot(x3 - drawn.centre[0, side, 0], z3 - drawn.centre[0, side, 1]) - drawn.radius[side])
