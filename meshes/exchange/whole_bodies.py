"""Meshes of screws, nuts, rings and balls for other FE programs: second-order tetrahedra, fine near the contacts.

The other programs find the contacts themselves, so that these meshes have no holes (refinement boxes) at contacts. Rings
and balls may also be cut in halves at a plane of symmetry. The surfaces are the exact ones of ``meshes.grooved_body`` and
``meshes.ball_body``; element sizes grow linearly with the distance from the expected contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rollbench.meshes import groove, shell
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import add_equator, add_hemisphere, contact_frame_vectors, triangulate_sphere
from rollbench.meshes.fem import MeshedBody, MeshQuality, nodes_on_boundaries
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import FLANK, GroovedBodySurface
from rollbench.meshes.parts import SIDES
from rollbench.meshes.sockets import ContactPosition, RefinementBoxSize, points_in_refinement_box

#: Azimuths [rad] of the two plane cut surfaces of half a bearing ring.
CUT = (0.0, np.pi)
#: Edges of the cross-section of a ring that are flanks of its groove.
FLANKS = (3, 4)


def use_requested_element_sizes(surface: shell.ClosedSurfaceMesh) -> None:
    """Make gmsh use the requested element sizes inside faces, instead of extending the sizes on a face's boundary."""
    surface.gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)


class HalfRingSurface:
    """Closed surface of one half of a bearing ring, from azimuth 0 to 180 deg; the plane y = 0 is its boundary "cut".

    Two rings with balls at 0 and 180 deg, displaced within the plane y = 0, deform symmetrically about this plane. So the
    half at y >= 0 is enough, and needs half the nodes of a mesh of the same fineness. Nodes lie on the exact surfaces of
    the ring, as in ``meshes.grooved_body``.

    The section has seven edges, numbered from 0: the bore or outside, high end, land, flank, flank, land, low end.
    """

    def __init__(
        self, surface: shell.ClosedSurfaceMesh, m: GrooveMap, spec: groove.GroovedBodySpec, share: float = 1.0
    ) -> None:
        """Build the surface: divide the curves between the faces of the half ring into edges, and triangulate the faces.

        Parameters
        ----------
        surface : ClosedSurfaceMesh
            Surface mesh to which the half ring is added.
        m : GrooveMap
            Groove surfaces of the track.
        spec : GroovedBodySpec
            Dimensions of the ring.
        share : float, default 1.0
            Factor on the default lengths of the longest edges on curved faces.

        Raises
        ------
        ValueError
            The body is a screw or nut, it has no bore, its groove has one arc, or its groove leaves no land or wall.
        """
        if m.rg or spec.inner_radius <= 0.0 or m.has_single_arc:
            raise ValueError("only a bearing ring with a bore and a groove of two arcs can be cut in halves")
        self.surface, self.section, self.spec = surface, groove.GrooveCrossSection.from_body(m, spec), spec
        use_requested_element_sizes(surface)
        g, line, (low, high) = self.section, m.z0, (spec.z_low, spec.z_high)
        self.flank_limit = share * min(shell.BEND[0] * float(m.radius[g.sides[0]]), FLANK * spec.cell_size_far_away)
        self.land_limit = share * shell.BEND[1] * g.land_radius
        self.behind_limit = min(share * shell.BEND[1] * g.back_radius, max(shell.WALL * g.wall_thickness, surface.fine))
        r, zeta = g.profile_points(g.sides[0], np.array([g.apex_angle]))
        corners = np.array(
            [
                (g.back_radius, low),
                (g.back_radius, high),
                (g.land_radius, high),
                (g.land_radius, line + g.opening_half_width),
                (float(r[0]), line + float(zeta[0])),
                (g.land_radius, line - g.opening_half_width),
                (g.land_radius, low),
            ]
        )
        limits = [self.behind_limit, self.behind_limit, *[self.land_limit] * 5]
        limits[3:6] = [min(self.land_limit, self.flank_limit)] * 3
        nodes = [surface.add_nodes(groove.points_from_cylindrical(corners[:, 0], phi, corners[:, 1])) for phi in CUT]
        self.arcs = [
            surface.add_curve(groove.circle_in_space(*corners[k]), *CUT, limits[k], (int(nodes[0][k]), int(nodes[1][k])))
            for k in range(7)
        ]
        self.corners, self.line = corners, line
        self.cuts = [
            [self._divide_section_edge(k, phi, ends) for k in range(7)] for phi, ends in zip(CUT, nodes, strict=True)
        ]
        self._triangulate_faces()

    def _divide_section_edge(self, k: int, phi: float, nodes: NDArray[np.int64]) -> shell.DividedCurve:
        """Divide edge k of the ring's section, from corner k to the next, into mesh edges, at the azimuth ``phi`` [rad].

        ``k``: number of the edge, 0 to 6; ``nodes``: numbers of the nodes at the seven corners of this cross-section.
        """
        limit = self.flank_limit if k in FLANKS else self.behind_limit if k == 0 else self.land_limit
        ends = int(nodes[k]), int(nodes[(k + 1) % 7])
        return self.surface.add_curve(lambda t: self._points_on_edge(k, t, phi), *self._ends_of_edge(k), limit, ends)

    def _ends_of_edge(self, k: int) -> tuple[float, float]:
        """Return the parameter of edge ``k`` at its two corners: the section angle of a flank [rad], else 0 and 1."""
        angles = self.section.edge_angle, self.section.apex_angle
        return (angles if k == FLANKS[0] else angles[::-1]) if k in FLANKS else (0.0, 1.0)

    def _flank_of_edge(self, k: int) -> int:
        """Return the number of the flank (0 to 3) that edge ``k`` (3 or 4) of the cross-section belongs to."""
        return self.section.sides[1 if k == FLANKS[0] else 0]

    def _edge_coordinates(self, k: int, t: Array) -> Array:
        """Return radius and z ``(n, 2)`` [m] of points along edge k of the cross-section.

        ``t``: for the two flanks (edges 3 and 4), the section angles of the points [rad]; for a straight edge, their
        positions as fractions of its length ``(n,)``.
        """
        if k in FLANKS:
            r, zeta = self.section.profile_points(self._flank_of_edge(k), t)
            return np.stack([r, self.line + zeta], axis=1)
        return np.asarray(self.corners[k] + t[:, None] * (self.corners[(k + 1) % 7] - self.corners[k]))

    def _points_on_edge(self, k: int, t: Array, phi: float | Array) -> Array:
        """Return points ``(n, 3)`` [m] on edge k, given by ``t`` as in `_edge_coordinates`, at azimuths ``phi`` [rad]."""
        r, z = self._edge_coordinates(k, t).T
        return groove.points_from_cylindrical(r, phi, z)

    def _triangulate_faces(self) -> None:
        """Triangulate the curved faces, the two flat ends, and the two cut surfaces of the half ring."""
        for k, name in ((0, "bore" if self.spec.groove_outside else "outside"), (2, "land"), (5, "land")):
            r = float(self.corners[k, 0])
            limit = self.behind_limit if k == 0 else self.land_limit

            def arc_length_and_z(phi: Array, at: Array, r: float = r) -> Array:
                return np.stack([r * phi, at[:, 1]], axis=1)

            self._triangulate_swept_face(name, k, arc_length_and_z, groove.cylinder_point_map(r), limit)
        for k in FLANKS:
            side = self._flank_of_edge(k)
            scale = np.array([self.corners[4, 0], float(self.section.groove_map.radius[side])])

            def arc_lengths(phi: Array, at: Array, scale: Array = scale) -> Array:
                return np.stack([phi, at[:, 0]], axis=1) * scale

            def points_on_flank(x: Array, k: int = k, scale: Array = scale) -> Array:
                return self._points_on_edge(k, x[:, 1] / scale[1], x[:, 0] / scale[0])

            self._triangulate_swept_face(f"flank {SIDES[side]}", k, arc_lengths, points_on_flank, self.flank_limit)

        def x_and_y(phi: Array, at: Array) -> Array:
            sine = np.sin(phi) * (np.ptp(phi) > 0.0)  # exactly 0 along the cut
            return np.asarray(at[:, :1] * np.stack([np.cos(phi), sine], axis=1))

        for k, name in ((1, "high end"), (6, "low end")):
            self._triangulate_swept_face(name, k, x_and_y, groove.point_map_at_z(float(self.corners[k, 1])), np.inf)
        for phi, cut in zip(CUT, self.cuts, strict=True):
            loop = [cut[k].side(partial(self._edge_coordinates, k)) for k in range(7)]
            self.surface.add_face("cut", [loop], partial(_points_in_axial_plane, phi), np.inf)

    def _triangulate_swept_face(
        self, name: str, k: int, plane: Callable[[Array, Array], Array], space: shell.Placing, limit: float
    ) -> None:
        """Triangulate the face that edge k of the cross-section generates about the axis.

        ``name``: name of the boundary to which the face belongs; ``plane``: function that returns the plane coordinates
        ``(n, 2)`` of points, from their azimuths [rad] and their places on the edge: section angles ``(n, 1)`` [rad] on a
        flank, else radii and z ``(n, 2)`` [m]; ``space``: function that maps plane coordinates to points ``(n, 3)`` [m];
        ``limit``: length of the longest edge [m].
        """
        begin, end = np.array(self._ends_of_edge(k))[:, None] if k in FLANKS else self.corners[[k, (k + 1) % 7]]
        first, last = (cut[k] for cut in self.cuts)

        def on_cut(phi: float, t: Array) -> Array:
            return plane(np.full(t.size, phi), t[:, None] if k in FLANKS else self._edge_coordinates(k, t))

        loop = [
            self.arcs[k].side(lambda phi: plane(phi, np.tile(begin, (phi.size, 1)))),
            last.side(partial(on_cut, CUT[1])),
            self.arcs[(k + 1) % 7].reversed_side(lambda phi: plane(phi, np.tile(end, (phi.size, 1)))),
            first.reversed_side(partial(on_cut, CUT[0])),
        ]
        self.surface.add_face(name, [loop], space, limit)


def _points_in_axial_plane(phi: float, x: Array) -> Array:
    """Return the points in the axial plane at the azimuth ``phi`` [rad] with the coordinates (radius, z) ``x`` [m]."""
    return groove.points_from_cylindrical(x[:, 0], phi, x[:, 1])


def triangulate_half_sphere(radius: float, surface: shell.ClosedSurfaceMesh, edge_factor: float, sign: float) -> None:
    """Triangulate the surface of half a ball about the origin, cut at the plane y = 0: boundaries "sphere" and "cut".

    Parameters
    ----------
    radius : float
        Radius of the ball [m].
    surface : ClosedSurfaceMesh
        Surface mesh to which the faces are added.
    edge_factor : float
        Factor on the default length of the longest edge.
    sign : float
        1 for the half at y >= 0, -1 for the half at y <= 0.
    """
    use_requested_element_sizes(surface)
    limit = edge_factor * shell.BEND[1] * radius
    axes, pole = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, -sign, 0.0])
    nodes = add_equator(surface, radius, axes, limit).nodes
    rim: list[list[shell.Side]] = [[(nodes, surface.points[nodes] @ axes.T)]]  # the projection keeps the equator
    add_hemisphere(surface, radius, axes, pole, rim, limit)
    surface.add_face("cut", rim, lambda at: at @ axes, np.inf)


@dataclass(frozen=True)
class ElementSizesNearPoints:
    """Edge lengths of a mesh: fine at given points, and growing linearly with the distance from the nearest of them."""

    #: Points around which the mesh is fine ``(k, 3)`` [m].
    fine_points: Array
    #: Edge length at the fine points [m].
    edge_length_at_points: float
    #: Growth of the edge length per unit of distance from the nearest fine point.
    growth_per_distance: float
    #: Largest edge length [m].
    largest_edge_length: float

    def edge_length_function(self, share: float = 1.0) -> shell.Placing:
        """Return the function for the edge lengths ``(n,)`` [m] at points ``(n, 3)`` [m], multiplied by ``share``."""
        tree = cKDTree(self.fine_points)
        return lambda x: (
            share
            * np.minimum(self.edge_length_at_points + self.growth_per_distance * tree.query(x)[0], self.largest_edge_length)
        )


@dataclass(frozen=True)
class ExportedBodyMesh(MeshedBody):
    """Mesh of a whole or half body for another FE program, with named boundaries."""

    #: Number of cells and nodes of the mesh, and smallest scaled Jacobian of its cells.
    quality: MeshQuality

    @cached_property
    def nodes_of_boundaries(self) -> dict[str, Index]:
        """Numbers of the nodes on each boundary, by the boundary's name."""
        return {name: nodes_on_boundaries(self.mesh, name) for name in sorted(self.mesh.boundaries)}


def grid_points_in_ellipse(semi_axes: tuple[float, float], step: float) -> Array:
    """Return points that fill an ellipse about the origin: those of a rectangular grid, and some on the ellipse itself.

    Parameters
    ----------
    semi_axes : tuple[float, float]
        Semi-axes of the ellipse [m].
    step : float
        Largest distance between neighbouring points of the grid [m].

    Returns
    -------
    (k, 2) Array
        Coordinates of the points [m].
    """
    counts = [max(1, int(np.ceil(x / step))) for x in semi_axes]
    x, y = np.meshgrid(*(np.linspace(-1.0, 1.0, 2 * n + 1) for n in counts), indexing="ij")
    inside = x**2 + y**2 <= 1.0
    turn = np.linspace(0.0, 2.0 * np.pi, 8 * max(counts), endpoint=False)
    x, y = np.concatenate([x[inside], np.cos(turn)]), np.concatenate([y[inside], np.sin(turn)])
    return np.stack([semi_axes[0] * x, semi_axes[1] * y], axis=1)


def points_on_groove(m: GrooveMap, ball_position: ContactPosition, distances: Array) -> Array:
    """Return the points on a groove's surface that lie at given distances from the nominal contact point with a ball.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    ball_position : ContactPosition
        Azimuth [rad] and axial position [m] of the ball; and the flank: 0 and 1 are left and right on the screw, 2 and 3 on
        the nut.
    distances : (k, 2) Array
        Signed distances from the nominal contact point, across and along the groove [m].

    Returns
    -------
    (k, 3) Array
        Points [m].
    """
    radius = float(m.radius[ball_position[2]])
    xi = np.stack([distances[:, 0] / radius, np.zeros(len(distances)), distances[:, 1] / m.R], axis=1)
    return points_in_refinement_box(m, RefinementBoxSize(1.0, radius, 1.0), ball_position, xi)


def points_on_ball_surface(m: GrooveMap, side: int, radius: float, distances: Array) -> Array:
    """Return the points on the surface of a ball at azimuth 0 that lie at given distances from its nominal contact point.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    side : int
        Flank that the ball contacts: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
    radius : float
        Radius of the ball [m].
    distances : (k, 2) Array
        Signed distances from the nominal contact point, across and along the groove [m].

    Returns
    -------
    (k, 3) Array
        Coordinates of the points relative to the ball's centre [m].
    """
    n, t1, t2 = contact_frame_vectors(m, side)
    ray = n + distances[:, :1] / radius * t1 + distances[:, 1:] / radius * t2
    return np.asarray(radius * ray / np.linalg.norm(ray, axis=1)[:, None])


def move_to_ball_position(m: GrooveMap, ball_position: tuple[float, float], points: Array) -> Array:
    """Convert points of a ball at azimuth 0, relative to its centre, to points of a ball in the screw or bearing.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    ball_position : tuple[float, float]
        Azimuth [rad] and axial position [m] of the ball.
    points : (n, 3) Array
        Coordinates relative to the centre of a ball at azimuth 0 [m].

    Returns
    -------
    (n, 3) Array
        Coordinates in the frame of the screw [m].
    """
    c, s = np.cos(ball_position[0]), np.sin(ball_position[0])
    out = points + np.array([m.R, 0.0, 0.0])
    return np.asarray(out @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + np.array([0.0, 0.0, ball_position[1]]))


def mesh_whole_body(m: GrooveMap, spec: groove.GroovedBodySpec, refinement: ElementSizesNearPoints) -> ExportedBodyMesh:
    """Mesh a whole screw, nut or ring for another FE program; its boundaries have the names of `meshes.grooved_body`.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    spec : GroovedBodySpec
        Dimensions. Its refinement boxes are used only to find where a groove ends inside the body; its element sizes are
        not used.
    refinement : ElementSizesNearPoints
        Element sizes.

    Returns
    -------
    ExportedBodyMesh
        The mesh; no refinement boxes are left free in it.

    Raises
    ------
    ValueError
        The groove leaves no land or wall, or no attempt of gmsh gives a good mesh.
    """
    plain, section = replace(spec, contact_positions=()), groove.GrooveCrossSection.from_body(m, spec)

    def triangulate(surface: shell.ClosedSurfaceMesh, share: float) -> GroovedBodySurface:
        return GroovedBodySurface(surface, plain, section, share)

    return _mesh_inside_surface(spec.part_name, triangulate, refinement)


def mesh_whole_ball(m: GrooveMap, radius: float, refinement: ElementSizesNearPoints) -> ExportedBodyMesh:
    """Mesh a whole ball, with its centre at the origin, for another FE program.

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    radius : float
        Radius of the ball [m].
    refinement : ElementSizesNearPoints
        Element sizes, around the contacts of a ball at azimuth 0.

    Returns
    -------
    ExportedBodyMesh
        The mesh.

    Raises
    ------
    ValueError
        No attempt of gmsh gives a good mesh.
    """
    ball_map = replace(m, ball=radius)
    return _mesh_inside_surface("ball", lambda surface, share: triangulate_sphere(ball_map, surface, [], share), refinement)


def mesh_half_ring(m: GrooveMap, spec: groove.GroovedBodySpec, refinement: ElementSizesNearPoints) -> ExportedBodyMesh:
    """Mesh the half of a bearing ring at y >= 0 for another FE program; the plane y = 0 is its boundary "cut".

    Parameters
    ----------
    m : GrooveMap
        Groove surfaces of the track.
    spec : GroovedBodySpec
        Dimensions of the ring.
    refinement : ElementSizesNearPoints
        Element sizes.

    Returns
    -------
    ExportedBodyMesh
        The mesh.

    Raises
    ------
    ValueError
        As for `mesh_whole_body`; and where the body is a screw or nut, or a ring without bore.
    """
    name = "inner ring" if spec.groove_outside else "outer ring"
    return _mesh_inside_surface(name, lambda surface, share: HalfRingSurface(surface, m, spec, share), refinement)


def mesh_half_ball(radius: float, refinement: ElementSizesNearPoints, sign: float) -> ExportedBodyMesh:
    """Mesh half a ball with its centre at the origin for another FE program; the plane y = 0 is its boundary "cut".

    Parameters
    ----------
    radius : float
        Radius of the ball [m].
    refinement : ElementSizesNearPoints
        Element sizes.
    sign : float
        1 for the half at y >= 0, -1 for the half at y <= 0.

    Returns
    -------
    ExportedBodyMesh
        The mesh.

    Raises
    ------
    ValueError
        No attempt of gmsh gives a good mesh.
    """
    triangulate = partial(triangulate_half_sphere, radius, sign=sign)
    return _mesh_inside_surface("ball", triangulate, refinement)


def _mesh_inside_surface(
    name: str, triangulate: Callable[[shell.ClosedSurfaceMesh, float], object], refinement: ElementSizesNearPoints
) -> ExportedBodyMesh:
    """Mesh the body inside a closed surface for another FE program; edges that would invert cells are straightened.

    ``name``: name of the body, for messages; ``triangulate``: function that triangulates the surface in a
    `ClosedSurfaceMesh`, with a factor on the element sizes; ``refinement``: element sizes.
    """

    def mesh_once(gmsh: Any, plane: int, volume: int, share: float) -> tuple[ExportedBodyMesh, float]:
        edge_length, smallest = refinement.edge_length_function(share), share * refinement.edge_length_at_points
        surface = shell.ClosedSurfaceMesh(gmsh, edge_length, smallest, plane)
        triangulate(surface, share)
        filled = shell.mesh_inside_closed_surface(surface, volume)
        mesh, moved, quality = filled.improved_mesh(surface, name, np.zeros(0, dtype=np.int64))
        return ExportedBodyMesh(mesh, quality), moved + max(0.0, shell.POOREST - quality.smallest_jacobian)

    return shell.best_mesh_of_attempts(name, mesh_once)
