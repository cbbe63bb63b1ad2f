"""Meshes of a tapered roller and of its raceways: a section meshed by gmsh is extruded along rays from the cones' apex.

The cones of roller and raceways have a common apex. So the section, meshed where the roller has its mean diameter and fine
at the contact, is scaled to every distance from the apex, and bodies in contact have the same nodes there. By symmetry only
the half y >= 0 of a body is meshed; of the roller only the quarter towards one raceway.

Coordinates of the section: y [m] across the contact line, z [m] from there into the body. Coordinates of the body: z along
the axis of its cone, from the apex; x from this axis towards the contact line; y across. Boundaries: "contact" (the zone of
possible contact), "y = 0", "side" (on a raceway, the plane half-way to the next roller; on the roller x = 0), "base" (depth
of a raceway), "end" (large end of the roller).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import MeshedBody, build_mesh
from rollbench.meshes.shell import gmsh_session, set_element_size_formula, take_nodes_and_cells

#: Number of equally thick layers of cells below the zone of contact, each as thick as its cells are wide.
DEEP = 2
#: The two corners of each edge of a hexahedron, in gmsh's order of the edges.
_EDGES = ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7))


@dataclass(frozen=True)
class RollerContactZone:
    """Strip along the contact line in which roller and raceway may touch, and the sizes of the cells in it."""

    #: Half width of the strip across the contact line [m].
    half_width: float
    #: Number of cells across the half width.
    cells_across: int
    #: Increase of the cells' edge length per unit of distance from the strip.
    growth_per_distance: float


@dataclass(frozen=True)
class RollerSectionMesh:
    """Plane mesh of the cross-section of a roller or raceway: second-order quadrilaterals."""

    #: Coordinates y (across the contact line) and z (into the body) of the nodes ``(n, 2)`` [m].
    points: Array
    #: Nodes of the cells ``(m, 9)``, in gmsh's order.
    cells: Index


@dataclass(frozen=True)
class ExtrudedRollerBody(MeshedBody):
    """Mesh of half a raceway or of a quarter of a tapered roller, with the nodes in the zone of possible contact."""

    #: Nodes in the zone of possible contact ``(rows, columns)``: one row for each distance from the apex, with columns from
    #: the contact line outwards.
    contact_nodes: Index
    #: Distance of each column of nodes from the contact line, where the roller has its mean diameter ``(columns,)`` [m].
    distances_from_contact_line: Array
    #: Distance of each row of nodes from the apex ``(rows,)`` [m].
    distances_from_apex: Array
    #: Unit normals into the body at the nodes in the zone of contact ``(rows, columns, 3)``.
    inward_normals: Array


def mesh_roller_or_raceway_section(
    zone: RollerContactZone, width: float, depth: float, *, is_roller: bool
) -> RollerSectionMesh:
    """Mesh the cross-section of a raceway (half of a rectangle) or of a roller (a quarter of a disc) by gmsh.

    Parameters
    ----------
    zone
        Strip along the contact line in which roller and raceway may touch, and its cells.
    width, depth
        Half width and depth of the raceway's section [m]; for a roller both are its radius.
    is_roller
        Whether the section is a quarter of a disc.

    Raises
    ------
    ImportError
        gmsh, or a system library that it needs, is missing.
    """
    cell, unit = zone.half_width / zone.cells_across, depth
    w, d, wide = zone.half_width / unit, DEEP * cell / unit, width / unit
    top = 1.0 - np.sqrt(1.0 - w**2) if is_roller else 0.0
    with gmsh_session({"Mesh.SubdivisionAlgorithm": 1, "Mesh.Algorithm": 6}) as gmsh:
        gmsh.model.add("section")
        geo = gmsh.model.geo
        places = ((0.0, 0.0), (w, top), (w, top + d), (0.0, d), (wide, 1.0 if is_roller else 0.0), (0.0, 1.0), (wide, 1.0))
        start, edge, low, under, far_edge, bottom, corner = (geo.addPoint(*at, 0.0) for at in places)
        if is_roller:  # arcs about the bottom point, the disc's centre
            strip, beyond = (geo.addCircleArc(a, bottom, b) for a, b in ((start, edge), (edge, far_edge)))
            path = [far_edge, bottom, under]
        else:
            strip, beyond = geo.addLine(start, edge), geo.addLine(edge, far_edge)
            path = [far_edge, corner, bottom, under]
        near = [strip, *(geo.addLine(a, b) for a, b in ((edge, low), (low, under), (under, start)))]
        rest = [beyond, *(geo.addLine(a, b) for a, b in pairwise(path))]
        block = geo.addPlaneSurface([geo.addCurveLoop(near)])
        far = geo.addPlaneSurface([geo.addCurveLoop([*rest, -near[2], -near[1]])])
        for curve, count in zip(near, (zone.cells_across, DEEP, zone.cells_across, DEEP), strict=True):
            geo.mesh.setTransfiniteCurve(curve, count // 2 + 1)
        geo.mesh.setTransfiniteSurface(block, cornerTags=[start, edge, low, under])
        geo.synchronize()
        for surface in (block, far):
            gmsh.model.mesh.setRecombine(2, surface)
        away = f"Sqrt(Max(0,x-{w!r})^2+Max(0,y-{d!r})^2)"
        set_element_size_formula(gmsh, f"2*({cell / unit!r}+{zone.growth_per_distance!r}*{away})")
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        xyz, cells = take_nodes_and_cells(gmsh, 10, 9)
    used, cells = np.unique(cells, return_inverse=True)
    points = unit * xyz[used, :2]
    on = np.flatnonzero(np.abs(_depth_below_surface(points, depth, is_roller)) < 1e-6 * depth)
    strip_nodes = on[points[on, 0] < zone.half_width + 0.25 * cell]  # equal steps of y, the same on roller and raceway
    y = np.rint(points[strip_nodes, 0] / cell * 2.0) * cell / 2.0
    points[strip_nodes, 0] = y
    points[strip_nodes, 1] = depth - np.sqrt(depth**2 - y**2) if is_roller else 0.0
    return RollerSectionMesh(points, cells.reshape(-1, 9))


def _depth_below_surface(points: Array, depth: float, is_roller: bool) -> Array:
    """Return the depths of points in a cross-section below the surface of the raceway or roller ``(n,)`` [m].

    ``points``: section coordinates y, z ``(n, 2)`` [m]; ``depth``: depth of the section, for a roller its radius [m];
    ``is_roller``: whether it is the section of a roller, a quarter of a disc.
    """
    return depth - np.hypot(points[:, 0], depth - points[:, 1]) if is_roller else points[:, 1]


def _sweep_section_to_hexahedra(section: RollerSectionMesh, layer_distances: Array) -> tuple[Index, Array, Index]:
    """Extrude a plane mesh along rays from the apex to layers of hexahedra between given distances from the apex [m].

    Returns three arrays: for each node of the hexahedra its node of the section, and its distance from the apex [m]; then
    the nodes of each hexahedron, in gmsh's order.
    """
    along = np.interp(np.arange(2 * len(layer_distances) - 1) / 2.0, np.arange(len(layer_distances)), layer_distances)
    n = len(section.points)
    node, place = np.tile(np.arange(n), len(along)), np.repeat(along, n)
    quad = section.cells
    corners = quad[:, :4]

    def layer_nodes(members: Index, step: int) -> Index:
        return members + n * step

    columns = [*(layer_nodes(corners[:, k], 0) for k in range(4)), *(layer_nodes(corners[:, k], 2) for k in range(4))]
    for a, b in _EDGES:
        if b == a + 4:
            columns.append(layer_nodes(corners[:, a], 1))
        else:
            i, j = sorted((a % 4, b % 4))
            middle = quad[:, 4 + (3 if (i, j) == (0, 3) else i)]
            columns.append(layer_nodes(middle, 0 if a < 4 else 2))
    centres = ((8, 0), *((k, 1) for k in (4, 7, 5, 6)), (8, 2), (8, 1))
    columns += [layer_nodes(quad[:, k], step) for k, step in centres]
    first = np.stack(columns, axis=1)
    return np.asarray(node), np.asarray(place), np.concatenate([first + 2 * n * k for k in range(len(layer_distances) - 1)])


def _corners_of_boundary_faces(cells: Index, boundary_nodes: Array) -> Index:
    """Return the corners ``(k, 4)`` of those faces of hexahedra whose four corners all belong to a set of nodes.

    ``cells``: nodes of the hexahedra ``(m, 27)``; ``boundary_nodes``: for each node of the mesh, whether it belongs to the
    set.
    """
    corners = cells[:, :8]
    quads = np.array([(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7)])
    faces = corners[:, quads].reshape(-1, 4)
    return np.asarray(faces[boundary_nodes[faces].all(axis=1)])


def build_extruded_roller_body(
    section: RollerSectionMesh,
    zone: RollerContactZone,
    layer_distances: Array,
    zone_ends: tuple[float, float],
    point_map: Callable[[Array, Array], Array],
    *,
    is_roller: bool = False,
    mirrored: bool = False,
) -> ExtrudedRollerBody:
    """Mesh a tapered roller or a raceway: its plane section mesh is extruded along rays from the cones' apex.

    Parameters
    ----------
    section
        Mesh of the section.
    zone
        Strip along the contact line in which roller and raceway may touch.
    layer_distances
        Distances from the apex at which layers of cells begin and end, ascending ``(k,)`` [m].
    zone_ends
        Distances from the apex at which the zone of contact begins and ends, two values of ``layer_distances`` [m].
    point_map
        Function that maps nodes ``(n, 2)`` of the section, and their distances ``(n,)`` from the apex, to points ``(n, 3)``
        of the body [m]: `roller_point_map` or `raceway_point_map`.
    is_roller
        Whether the section is a quarter of a disc (roller).
    mirrored
        Whether ``point_map`` reverses the orientation, as for a cup.
    """
    turned = RollerSectionMesh(section.points, section.cells[:, [0, 3, 2, 1, 7, 6, 5, 4, 8]]) if mirrored else section
    node, along, cells = _sweep_section_to_hexahedra(turned, layer_distances)
    points, at = point_map(section.points[node], along), section.points[node]
    depth, tiny = section.points[:, 1].max(), 1e-9 * section.points[:, 1].max()
    on_top = np.abs(_depth_below_surface(at, depth, is_roller)) < tiny
    strip = on_top & (at[:, 0] <= zone.half_width + tiny) & (along >= zone_ends[0] - tiny) & (along <= zone_ends[1] + tiny)
    nodes = {
        "contact": strip,
        "y = 0": at[:, 0] < tiny,
        "side": at[:, 1] > depth - tiny if is_roller else at[:, 0] > at[:, 0].max() - tiny,
        "end" if is_roller else "base": along > along.max() - tiny if is_roller else at[:, 1] > depth - tiny,
    }
    faces = {name: _corners_of_boundary_faces(cells, of_boundary) for name, of_boundary in nodes.items()}
    mesh, number = build_mesh(points, cells, "Q2", faces)
    held = np.flatnonzero(strip)
    held = held[np.lexsort((at[held, 0], along[held]))]
    rows = np.unique(along[held])
    grid = held.reshape(len(rows), -1)
    near = 1e-6 * depth  # a little deeper
    shifted = at[held] + near * _inward_normals_of_section(at[held], depth, is_roller)
    inward = point_map(shifted, along[held]) - points[held]
    inward /= np.linalg.norm(inward, axis=1)[:, None]
    return ExtrudedRollerBody(mesh, number[grid], at[grid[0], 0], rows, inward.reshape(*grid.shape, 3))


def _inward_normals_of_section(at: Array, depth: float, is_roller: bool) -> Array:
    """Return the unit normals into the body at points on the contour of a cross-section ``(n, 2)``.

    ``at``: section coordinates y, z ``(n, 2)`` [m]; ``depth``: depth of the section, for a roller its radius [m];
    ``is_roller``: whether it is the section of a roller, a quarter of a disc.
    """
    inward = np.column_stack([-at[:, 0], depth - at[:, 1]]) / depth
    return np.asarray(inward if is_roller else np.tile([0.0, 1.0], (len(at), 1)))


def roller_point_map(
    radius: float, roller_half_angle: float, profile_drop: Callable[[Array], Array]
) -> Callable[[Array, Array], Array]:
    """Return the function that maps points of the section, at distances from the apex, to points of a tapered roller.

    Parameters
    ----------
    radius
        Mean radius of the roller [m].
    roller_half_angle
        Half included angle of the roller [rad].
    profile_drop
        Function that returns the profile drop, the decrease of the radius by crowning [m], at distances from the apex [m].
    """

    def section_to_roller(at: Array, along: Array) -> Array:
        ray = np.column_stack([radius - at[:, 1], at[:, 0], np.full(len(at), radius / np.tan(roller_half_angle))])
        out = along[:, None] * ray / np.linalg.norm(ray, axis=1)[:, None]
        out[:, :2] *= 1.0 - (profile_drop(along) / radius)[:, None]
        return np.asarray(out)

    return section_to_roller


def raceway_point_map(
    true_size_distance: float, cone_half_angle: float, outward_sign: float
) -> Callable[[Array, Array], Array]:
    """Return the function that maps points of the section, at distances from the apex, to points of a raceway's ring.

    Parameters
    ----------
    true_size_distance
        Distance from the apex at which the section has its true size [m].
    cone_half_angle
        Half included angle of the raceway's cone [rad].
    outward_sign
        1 for the cup, whose body is outside its raceway; -1 for the cone (inner ring).
    """

    def section_to_raceway(at: Array, along: Array) -> Array:
        phi = np.arcsin(at[:, 0] / (true_size_distance * np.sin(cone_half_angle)))
        radial = along * np.sin(cone_half_angle) + outward_sign * at[:, 1] * np.cos(cone_half_angle)
        axial = along * np.cos(cone_half_angle) - outward_sign * at[:, 1] * np.sin(cone_half_angle)
        return np.column_stack([radial * np.cos(phi), radial * np.sin(phi), axial])

    return section_to_raceway
