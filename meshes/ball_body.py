"""Coarse mesh of a ball: second-order tetrahedra by gmsh, with a refinement box left free around every contact.

A refinement box of a ball is a truncated pyramid, which a finer mesh (the contact patch) fills. Each half of the sphere is
triangulated in a plane, by stereographic projection from the opposite pole; refinement boxes become holes, and no seam is
needed. The projection preserves angles, and scales lengths by a known factor between 1/2 and 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import cos, sin
from typing import Any

import numpy as np

from rollbench.meshes import shell, sockets
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import MeshedBody, MeshQuality
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDES

#: Distances from the refinement boxes between which the element size grows from that at the boxes to that far away, as
#: ratios to the ball's radius.
GROWTH = (0.072, 0.72)
#: SHALLOWER: ratio of the depth of a ball's refinement box to that of the groove's refinement box. CORNER: least depth of
#: the corners of a ball's refinement box, as a ratio to the ball's radius.
SHALLOWER, CORNER = 0.75, 0.12


@dataclass(frozen=True)
class BallRefinementBox:
    """Refinement box of a ball: the box around one contact that the ball's coarse mesh leaves free for a finer mesh."""

    #: Flank 0 to 3 with which the ball is in contact.
    side: int
    #: Size of the groove's refinement box at the same contact.
    groove_box_size: sockets.RefinementBoxSize
    #: Depth of the box's bottom below the ball's surface, along the contact normal [m].
    depth: float
    #: Fraction of the refinement box's length, about its middle, in which the rays from the ball's centre meet the groove's
    #: surface at the points with the same local coordinates (see `rays_from_ball_centre`).
    exact_length_fraction: float = 0.5


@dataclass(frozen=True)
class CoarseBallMesh(MeshedBody):
    """Coarse mesh of a ball with refinement boxes left free around its contacts; the ball's centre is the origin.

    Contacts are those of a ball at azimuth 0. Names of boundaries: "sphere"; and, for the faces of the refinement box at
    each contact, "socket SL" (screw left), "socket SR" (screw right), "socket NL" (nut left), "socket NR" (nut right).
    """

    #: Nodes on the inner faces of each refinement box, by flank 0 to 3.
    nodes_on_box_faces: dict[int, Index]
    #: Mesh of each refinement box's faces, by flank 0 to 3.
    box_faces: dict[int, sockets.RefinementBoxFaces]
    #: Number of cells and nodes of the mesh, and smallest scaled Jacobian of its cells.
    quality: MeshQuality


def contact_frame_vectors(m: GrooveMap, side: int) -> Array:
    """Return the unit vectors of the contact frame on a flank, for a ball at azimuth 0.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.

    Returns
    -------
    (3, 3) Array
        Rows: contact normal from ball to groove; direction of increasing section angle gamma; direction of increasing
        azimuth along the track.
    """
    sx, sz = m.signs[side]
    x3, y3, z3 = m.section_axes()
    c, s = cos(m.beta), sin(m.beta)
    return np.stack([sx * c * x3 + sz * s * z3, -sx * s * x3 + sz * c * z3, y3])


def rays_from_ball_centre(m: GrooveMap, box: BallRefinementBox, local_coordinates: Array) -> Array:
    """Return rays from a ball's centre through the points with given local coordinates in a refinement box of the ball.

    In the middle of the refinement box, each ray meets the groove's surface at the point with the same section angle and
    azimuth. Beyond the fraction ``box.exact_length_fraction`` of the length, rays are adjusted so that those at the ends of
    the refinement box lie in planes through the ball's centre. Without this adjustment the end faces would be concave in
    their middle.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    box : BallRefinementBox
        Refinement box of the ball.
    local_coordinates : (n, 3) Array
        Local coordinates in the refinement box: section angle in [-1, 1], depth in [0, 1], azimuth in [-1, 1].

    Returns
    -------
    (n, 3) Array
        Vectors along the rays, scaled so that their component along the contact normal is 1.
    """
    n, t1, t2 = contact_frame_vectors(m, box.side)

    def project_to_tangent_plane(at: Array) -> tuple[Array, Array]:
        on_surface = at * [1.0, 0.0, 1.0]
        x = sockets.points_in_box_at_azimuth_zero(m, box.groove_box_size, box.side, on_surface) - [m.R, 0.0, 0.0]
        return (x @ t1) / (x @ n), (x @ t2) / (x @ n)

    line = np.linspace(-1.0, 1.0, 9)
    end_lines = (np.stack([line, np.zeros(9), np.full(9, end)], axis=1) for end in (-1.0, 1.0))
    along = max(float(np.abs(project_to_tangent_plane(at)[1]).max()) for at in end_lines)
    s, t = project_to_tangent_plane(local_coordinates)
    u = np.clip((np.abs(local_coordinates[:, 2]) - box.exact_length_fraction) / (1.0 - box.exact_length_fraction), 0.0, 1.0)
    w = u * u * (3.0 - 2.0 * u)
    t = t * (1.0 - w) + w * along * local_coordinates[:, 2]
    return np.asarray(n[None, :] + s[:, None] * t1 + t[:, None] * t2)


def points_in_ball_refinement_box(m: GrooveMap, box: BallRefinementBox, xi: Array) -> Array:
    """Map local coordinates in a refinement box of a ball to points, which lie on rays from the ball's centre.

    Points at depth 0 are on the sphere, points at depth 1 on a plane normal to the contact normal.

    Parameters
    ----------
    m, box, xi
        Groove surfaces, refinement box of the ball and local coordinates, as for `rays_from_ball_centre`.

    Returns
    -------
    (n, 3) Array
        Coordinates relative to the ball's centre [m].
    """
    ray = rays_from_ball_centre(m, box, xi)
    outer = m.ball / np.linalg.norm(ray, axis=1)
    return np.asarray(ray * (outer + xi[:, 1] * (m.ball - box.depth - outer))[:, None])


def depth_of_ball_refinement_box(m: GrooveMap, groove_box_size: sockets.RefinementBoxSize, side: int) -> float:
    """Compute the depth of a ball's refinement box from the size of the groove's box at the same contact.

    It is `SHALLOWER` times the depth of the groove's box, or more where the corners of the box would otherwise be less than
    `CORNER` ball radii deep.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    groove_box_size : RefinementBoxSize
        Size of the groove's refinement box.
    side : int
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.

    Returns
    -------
    float
        Depth below the sphere [m].
    """
    corners = np.array([[a, 0.0, b] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    box = BallRefinementBox(side, groove_box_size, groove_box_size.depth)
    widest = float(np.linalg.norm(rays_from_ball_centre(m, box, corners), axis=1).max())
    return max(SHALLOWER * groove_box_size.depth, m.ball * (1.0 - (1.0 - CORNER) / widest))


def mesh_ball_with_refinement_boxes(
    m: GrooveMap,
    boxes: tuple[BallRefinementBox, ...],
    cell_size_at_boxes: float,
    cell_size_far_away: float,
    edge_divisions: tuple[int, int, int] = (2, 2, 2),
) -> CoarseBallMesh:
    """Mesh a ball coarsely, and leave a refinement box free around each contact for a finer mesh.

    The mesh on the faces of the box at a right flank is a rotated copy of the mesh at the left flank. Where two boxes are
    close to each other, gmsh may then fill the gap between them with flat cells; in this case each box is meshed
    independently.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    boxes : tuple[BallRefinementBox, ...]
        Refinement boxes of the ball, one for each contact.
    cell_size_at_boxes, cell_size_far_away : float
        Edge lengths of cells at the refinement boxes and far from them [m].
    edge_divisions : tuple[int, int, int], optional
        Number of equal parts into which the edges of the boxes are divided: across the groove, in depth and along the
        groove.

    Returns
    -------
    CoarseBallMesh
        The mesh of the ball.

    Raises
    ------
    ValueError
        No attempt of gmsh gives a good mesh.
    """

    def point_map_of_box(side: int) -> Callable[[Array], Array]:
        like = next(box for box in boxes if box.side // 2 == side // 2)
        return partial(points_in_ball_refinement_box, m, replace(like, side=side))

    sizes = cell_size_at_boxes, cell_size_far_away
    try:
        faces = [sockets.mesh_refinement_box_of_flank(point_map_of_box, box.side, edge_divisions) for box in boxes]
        return _mesh_ball_around_refinement_boxes(m, boxes, faces, *sizes)
    except ValueError:
        if not any(box.side % 2 for box in boxes):
            raise
    faces = [sockets.mesh_refinement_box_faces(point_map_of_box(box.side), edge_divisions) for box in boxes]
    return _mesh_ball_around_refinement_boxes(m, boxes, faces, *sizes)


def _mesh_ball_around_refinement_boxes(
    m: GrooveMap, boxes: tuple[BallRefinementBox, ...], faces: list[sockets.BulgingBoxFaces], fine: float, coarse: float
) -> CoarseBallMesh:
    """Mesh a ball around its refinement boxes, whose faces are meshed already.

    ``m``: groove surfaces of the track; ``boxes``: refinement boxes of the ball; ``faces``: the meshes of their faces;
    ``fine``, ``coarse``: edge lengths of cells at the refinement boxes and far from them [m].
    """
    pairs = list(zip(boxes, faces, strict=True))
    near = np.concatenate([points_in_ball_refinement_box(m, box, mesh.xi) for box, (mesh, _) in pairs])

    def mesh_once(gmsh: Any, plane: int, volume: int, share: float) -> tuple[CoarseBallMesh, float]:
        sizes = share * fine, share * coarse
        edge_length = shell.edge_length_growing_with_distance(near, *sizes, *(m.ball * g for g in GROWTH))
        surface = shell.ClosedSurfaceMesh(gmsh, edge_length, min(sizes), plane)
        corners = []
        for box, (mesh, raised) in pairs:
            places = (points_in_ball_refinement_box(m, box, xi) for xi in (mesh.xi, raised))
            corners.append(surface.add_refinement_box(f"socket {SIDES[box.side]}", mesh, *places))
        meshes = [mesh for mesh, _ in faces]
        rims = [c[sockets.rim_nodes_of_refinement_box(mesh)] for c, mesh in zip(corners, meshes, strict=True)]
        triangulate_sphere(m, surface, rims, share)
        filled = shell.mesh_inside_closed_surface(surface, volume)
        box_nodes = [filled.nodes_on_refinement_box(c, mesh) for c, mesh in zip(corners, meshes, strict=True)]
        ball, moved, quality = filled.improved_mesh(surface, "ball", np.concatenate(box_nodes))
        flanks = [box.side for box in boxes]
        by_flank = dict(zip(flanks, box_nodes, strict=True)), dict(zip(flanks, meshes, strict=True))
        body = CoarseBallMesh(ball, *by_flank, quality)
        return body, moved + max(0.0, shell.POOREST - quality.smallest_jacobian)

    return shell.best_mesh_of_attempts("ball", mesh_once)


def triangulate_sphere(m: GrooveMap, surface: shell.ClosedSurfaceMesh, box_rims: list[Index], edge_factor: float) -> None:
    """Triangulate the surface of a ball outside its refinement boxes, one hemisphere after the other.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track, with the ball's radius.
    surface : ClosedSurfaceMesh
        Surface mesh to which the faces are added.
    box_rims : list[Index]
        Corner nodes around the rim of each refinement box.
    edge_factor : float
        Factor on the default length of the longest edge.
    """
    axis, limit = normal_between_hemispheres(m), edge_factor * shell.BEND[1] * m.ball
    along = contact_frame_vectors(m, 0)[2]
    axes = np.stack([along, np.cross(axis, along)])
    equator = add_equator(surface, m.ball, axes, limit)
    for pole in (-axis, axis):
        closed = [np.append(r, r[0]) for r in box_rims if surface.points[r[0]] @ pole < 0.0]
        loops = []
        for nodes in (equator.nodes, *closed):
            x = surface.points[nodes]
            loops.append([(nodes, np.asarray(x @ axes.T / (1.0 - x @ pole / m.ball)[:, None]))])
        add_hemisphere(surface, m.ball, axes, pole, loops, limit)


def add_equator(surface: shell.ClosedSurfaceMesh, radius: float, axes: Array, limit: float) -> shell.DividedCurve:
    """Divide a great circle of a sphere about the origin into edges of at most ``limit`` [m].

    ``surface``: surface mesh to which the nodes are added; ``radius``: radius of the sphere [m]; ``axes``: two orthogonal
    unit vectors in the plane of the circle ``(2, 3)``.
    """

    def circle(t: Array) -> Array:
        return np.asarray(radius * (np.stack([np.cos(t), np.sin(t)], axis=1) @ axes))

    return surface.add_curve(circle, 0.0, 2.0 * np.pi, limit)


def add_hemisphere(
    surface: shell.ClosedSurfaceMesh, radius: float, axes: Array, pole: Array, loops: list[list[shell.Side]], limit: float
) -> None:
    """Triangulate half a sphere about the origin in the plane of its equator, by stereographic projection from a pole.

    Parameters
    ----------
    surface : ClosedSurfaceMesh
        Surface mesh to which the half sphere is added, as boundary "sphere".
    radius : float
        Radius of the sphere [m].
    axes : (2, 3) Array
        Two orthogonal unit vectors in the plane of the equator: the axes of the plane coordinates.
    pole : (3,) Array
        Unit vector to the pole of the other half, from which the sphere is projected.
    loops : list
        Boundary of the half sphere in plane coordinates: the equator, then holes.
    limit : float
        Length of the longest edge [m].
    """

    def plane_to_sphere(flat: Array) -> Array:
        square = np.sum((flat / radius) ** 2, axis=1)[:, None]
        return np.asarray((radius * (square - 1.0) * pole + 2.0 * flat @ axes) / (square + 1.0))

    def length_ratio_plane_to_sphere(flat: Array) -> Array:
        return np.asarray(0.5 * (1.0 + np.sum((flat / radius) ** 2, axis=1)))

    surface.add_face("sphere", loops, plane_to_sphere, limit, length_ratio_plane_to_sphere)


def normal_between_hemispheres(m: GrooveMap) -> Array:
    """Return the unit normal of the plane through the ball's centre in which its two hemispheres are meshed separately.

    It is far from all contacts. It separates the contacts on the screw from those on the nut up to a contact angle of 45
    deg; beyond, the contacts on left flanks from those on right flanks.

    Parameters
    ----------
    m
        Groove surfaces of the track.
    """
    _, t1, _ = contact_frame_vectors(m, 3)
    n = contact_frame_vectors(m, 3)[0]
    x3, z3 = cos(m.beta) * n - sin(m.beta) * t1, sin(m.beta) * n + cos(m.beta) * t1
    return np.asarray(x3 if m.beta <= np.pi / 4 else z3)
