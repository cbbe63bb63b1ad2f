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
from numpy.typing import NDArray
from skfem import Mesh

from rollbench.meshes import shell as meshes_shell
from rollbench.meshes import sockets as meshes_sockets
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import MeshedBody, MeshQuality, improve_curved_cells
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDES

#: Array of truth values, such as whether each of several points is inside a cone.
Flags = NDArray[np.bool_]

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
    groove_box_size: meshes_sockets.RefinementBoxSize
    #: Depth of the bottom below the sphere, along the contact normal [m].
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

    #: Mesh of second-order tetrahedra.
    mesh: Mesh
    #: Nodes on the inner faces of each refinement box, by flank 0 to 3.
    nodes_on_box_faces: dict[int, Index]
    #: Mesh of each refinement box's faces, by flank 0 to 3.
    box_faces: dict[int, meshes_sockets.RefinementBoxFaces]
    #: Number of cells and nodes of the mesh, and smallest and median scaled Jacobian of its cells.
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
    the refinement box lie in planes through the ball's centre. Otherwise the end faces would be concave in their middle.

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
        x = meshes_sockets.points_in_box_at_azimuth_zero(m, box.groove_box_size, box.side, at * [1.0, 0.0, 1.0]) - np.array(
            [m.R, 0.0, 0.0]
        )
        return (x @ t1) / (x @ n), (x @ t2) / (x @ n)

    line = np.linspace(-1.0, 1.0, 9)
    along = max(
        float(np.abs(project_to_tangent_plane(np.stack([line, 0.0 * line, end + 0.0 * line], axis=1))[1]).max())
        for end in (-1.0, 1.0)
    )
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


def depth_of_ball_refinement_box(m: GrooveMap, groove_box_size: meshes_sockets.RefinementBoxSize, side: int) -> float:
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
    widest = float(
        np.linalg.norm(
            rays_from_ball_centre(m, BallRefinementBox(side, groove_box_size, groove_box_size.depth), corners), axis=1
        ).max()
    )
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
        There is no refinement box, refinement boxes overlap, or no attempt of gmsh gives a good mesh.
    """

    def point_map_of_box(side: int) -> Callable[[Array], Array]:
        like = next(socket for socket in boxes if socket.side // 2 == side // 2)
        return partial(points_in_ball_refinement_box, m, replace(like, side=side))

    _check_refinement_boxes_of_ball(m, boxes)
    try:
        return _mesh_ball_around_refinement_boxes(
            m,
            boxes,
            [
                meshes_sockets.mesh_refinement_box_of_flank(point_map_of_box, socket.side, edge_divisions)
                for socket in boxes
            ],
            cell_size_at_boxes,
            cell_size_far_away,
        )
    except ValueError:
        if not any(socket.side % 2 for socket in boxes):
            raise
    return _mesh_ball_around_refinement_boxes(
        m,
        boxes,
        [meshes_sockets.mesh_refinement_box_faces(point_map_of_box(socket.side), edge_divisions) for socket in boxes],
        cell_size_at_boxes,
        cell_size_far_away,
    )


def _mesh_ball_around_refinement_boxes(
    m: GrooveMap,
    sockets: tuple[BallRefinementBox, ...],
    boxes: list[tuple[meshes_sockets.RefinementBoxFaces, Array]],
    fine: float,
    coarse: float,
) -> CoarseBallMesh:
    """Mesh a ball around its refinement boxes, whose faces are meshed already.

    ``m``: groove surfaces of the track; ``sockets``: refinement boxes of the ball; ``boxes``: for each of them the mesh of
    its faces, and the local coordinates of its corner nodes in the bulging shape that the faces have while gmsh fills the
    ball; ``fine``, ``coarse``: edge lengths of cells at the refinement boxes and far from them [m].
    """
    near = np.concatenate(
        [points_in_ball_refinement_box(m, socket, box.xi) for socket, (box, _) in zip(sockets, boxes, strict=True)]
    )

    def mesh_once(gmsh: Any, plane: int, volume: int, share: float) -> tuple[CoarseBallMesh, float]:
        sizes = share * fine, share * coarse
        shell = meshes_shell.ClosedSurfaceMesh(
            gmsh,
            meshes_shell.edge_length_growing_with_distance(near, *sizes, *(m.ball * g for g in GROWTH)),
            min(sizes),
            plane,
        )
        corners = []
        for socket, (box, raised) in zip(sockets, boxes, strict=True):
            places = (points_in_ball_refinement_box(m, socket, xi) for xi in (box.xi, raised))
            corners.append(shell.add_refinement_box(f"socket {SIDES[socket.side]}", box, *places))
        triangulate_sphere(
            m,
            shell,
            [c[meshes_sockets.rim_nodes_of_refinement_box(box)] for c, (box, _) in zip(corners, boxes, strict=True)],
            share,
        )
        filled = meshes_shell.mesh_inside_closed_surface(shell, volume)
        box_nodes = [filled.nodes_on_refinement_box(c, box) for c, (box, _) in zip(corners, boxes, strict=True)]
        kept = np.concatenate(box_nodes)
        mesh, moved, quality = improve_curved_cells(
            filled.with_named_boundaries(shell), "ball", filled.nodes_of_triangles(shell.triangles_on_boundary()), kept
        )
        nodes = {socket.side: n for socket, n in zip(sockets, box_nodes, strict=True)}
        meshes = {socket.side: box for socket, (box, _) in zip(sockets, boxes, strict=True)}
        body = CoarseBallMesh(mesh, nodes, meshes, quality)
        return body, moved + max(0.0, meshes_shell.POOREST - quality.smallest_jacobian)

    return meshes_shell.best_mesh_of_attempts("ball", mesh_once)


def triangulate_sphere(
    m: GrooveMap, shell: meshes_shell.ClosedSurfaceMesh, box_rims: list[Index], edge_factor: float
) -> None:
    """Triangulate the surface of a ball outside its refinement boxes, one hemisphere after the other.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track, with the ball's radius.
    shell : ClosedSurfaceMesh
        Surface mesh to which the faces are added.
    box_rims : list[Index]
        Corner nodes around the rim of each refinement box.
    edge_factor : float
        Factor on the default length of the longest edge.
    """
    axis, limit = normal_between_hemispheres(m), edge_factor * meshes_shell.BEND[1] * m.ball
    along = contact_frame_vectors(m, 0)[2]
    middle = np.stack([along, np.cross(axis, along)])
    equator = shell.add_divided_curve(
        lambda t: m.ball * (np.stack([np.cos(t), np.sin(t)], axis=1) @ middle), 0.0, 2.0 * np.pi, limit
    )

    def length_ratio_plane_to_sphere(flat: Array) -> Array:
        return np.asarray(0.5 * (1.0 + np.sum((flat / m.ball) ** 2, axis=1)))

    for pole in (-axis, axis):

        def sphere_to_plane(x: Array, pole: Array = pole) -> Array:
            return np.asarray(x @ middle.T / (1.0 - x @ pole / m.ball)[:, None])

        def plane_to_sphere(flat: Array, pole: Array = pole) -> Array:
            square = np.sum((flat / m.ball) ** 2, axis=1)[:, None]
            return np.asarray((m.ball * (square - 1.0) * pole + 2.0 * flat @ middle) / (square + 1.0))

        closed = [np.append(r, r[0]) for r in box_rims if shell.points[r[0]] @ pole < 0.0]
        loops = [[(n, sphere_to_plane(shell.points[n]))] for n in (equator.nodes, *closed)]
        shell.add_face("sphere", loops, plane_to_sphere, limit, length_ratio_plane_to_sphere)


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


def _check_refinement_boxes_of_ball(m: GrooveMap, sockets: tuple[BallRefinementBox, ...]) -> None:
    """Raise ValueError unless there are refinement boxes (``sockets``), and all fit into the ball without overlap."""
    if not sockets:
        raise ValueError("a ball mesh without contacts: give a refinement box for at least one contact")
    remedy = "make the refinement boxes smaller (the module rollbench.meshes.sockets computes a size that fits)"
    a, b = np.linspace(-1.0, 1.0, 41)[:-1], np.ones(40)
    around = np.concatenate([np.stack(x, 1) for x in ((a, 0 * a, -b), (b, 0 * a, a), (-a, 0 * a, b), (-b, 0 * a, -a))])
    outlines = {socket.side: points_in_ball_refinement_box(m, socket, 1.02 * around) for socket in sockets}
    for socket in sockets:
        name = f"refinement box at flank {SIDES[socket.side]} of a ball of {1e3 * m.ball:.4g} mm radius"
        if not 0.0 < socket.depth < 0.8 * m.ball:
            raise ValueError(f"the {name} is {1e3 * socket.depth:.4g} mm deep, not between 0 and 0.8 ball radii: {remedy}")
        points = points_in_ball_refinement_box(m, socket, around)
        if np.linalg.norm(rays_from_ball_centre(m, socket, around), axis=1).max() * (m.ball - socket.depth) >= m.ball:
            raise ValueError(f"the {name} is wider than its depth of {1e3 * socket.depth:.4g} mm allows: {remedy}")
        if np.ptp(np.sign(points @ normal_between_hemispheres(m))) > 0.0:
            raise ValueError(f"the {name} extends beyond one half of the ball: {remedy}")
        for other in sockets:
            if (
                other is not socket
                and _are_inside_cone(outlines[other.side], points, contact_frame_vectors(m, other.side)).any()
            ):
                raise ValueError(f"the {name} and that at flank {SIDES[other.side]} overlap: {remedy}")


def _are_inside_cone(outline: Array, points: Array, frame: Array) -> Flags:
    """Return whether each point is inside the cone from the ball's centre through a closed outline ``(n,)``.

    ``outline``: points of the outline in order ``(k, 3)``; ``points``: points to test ``(n, 3)``; ``frame``: unit vectors
    in its rows ``(3, 3)``: the normal of a plane, and two axes in the plane. Points and outline are projected from the
    ball's centre onto this plane; a point is inside the cone where the outline winds around it.
    """
    before = points @ frame[0] > 0.0
    turn = np.zeros(len(points))
    flat = outline @ frame[1:].T / (outline @ frame[0])[:, None]
    at = points[before] @ frame[1:].T / (points[before] @ frame[0])[:, None]
    arms = flat[None] - at[:, None]
    angle = np.unwrap(np.arctan2(arms[..., 1], arms[..., 0])[:, [*range(len(flat)), 0]], axis=1)
    turn[before] = np.abs(angle[:, -1] - angle[:, 0])
    return np.asarray(turn > np.pi)
