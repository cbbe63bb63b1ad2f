"""Contact patches of first-order tetrahedra by gmsh, meshed as in Lin's thesis, and coarse bodies of first order.

A contact patch is the fine mesh in a box around a contact. It is meshed in its local coordinates (section angle gamma,
depth, azimuth), scaled to lengths; the cells are finest in a region around the contact (gmsh's body of influence). The
contact zone is a separate surface, so that the patches of ball and groove have the same contact nodes even where the boxes
are triangulated differently. Lengths are in metres; only gmsh gets millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.shell import MM, gmsh_session, number_elements
from rollbench.meshes.sockets import RefinementBoxFaces, rim_nodes_of_refinement_box

#: Ratio of the edge length of gmsh's Delaunay tetrahedra to the requested one, by the cube root of mean volumes.
LARGER = 1.22
#: gmsh's options: one thread; element sizes follow only from the size field of the patch.
OPTIONS = {
    "General.NumThreads": 1,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
}

#: The four first-order triangles on the nodes of a second-order triangle: three at its corners, one in its middle.
SUB_TRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


@dataclass(frozen=True)
class TetrahedralPatchSizes:
    """Dimensions of a contact patch, a box of fine tetrahedra around a contact, and edge lengths of the tetrahedra."""

    #: Half widths of the patch: across the groove (along the section angle), and along the groove (azimuth) [m].
    half_widths: tuple[float, float]
    #: Depth of the patch [m].
    depth: float
    #: Half widths, across and along the groove, of the zone in which the bodies may touch, as fractions of those of the
    #: patch.
    contact_zone_fractions: tuple[float, float]
    #: Half widths across and along the groove, and depth, of the inner box at the contact that has the finest cells [m].
    fine_box: tuple[float, float, float]
    #: Edge length of the cells in the inner box [m].
    smallest_edge_length: float
    #: Largest edge length of the cells [m].
    largest_edge_length: float
    #: Increase of the edge length per unit of distance from the inner box.
    growth_per_distance: float = 0.2


@dataclass(frozen=True)
class TetrahedralPatchMesh:
    """Mesh of a contact patch, a box around a contact: first-order tetrahedra in the box's local coordinates."""

    #: Local coordinates of the nodes ``(n, 3)``: section angle gamma in [-1, 1], depth in [0, 1], azimuth in [-1, 1].
    xi: Array
    #: Nodes of the tetrahedra ``(m, 4)``.
    tetrahedra: Index
    #: Nodes of the triangles on the face at depth 0, the groove's or ball's surface ``(t, 3)``.
    top_triangles: Index
    #: Nodes in the zone of possible contact ``(c,)``, sorted by section angle, then by azimuth.
    contact_nodes: Index


def patch_as_in_thesis(
    width: tuple[float, float],
    depth: float,
    zone: tuple[float, float],
    contact_size: float = 0.08e-3,
    edge_size: float = 0.5e-3,
) -> TetrahedralPatchSizes:
    """Return the dimensions of a contact patch, and the cell sizes of Lin's thesis: equal in the whole contact zone.

    A contact patch is a box of fine tetrahedra around a contact.

    Parameters
    ----------
    width, depth, zone
        Half widths of the patch across and along the groove [m], its depth [m], and the half widths of the contact zone as
        fractions of those of the patch, as the fields of `TetrahedralPatchSizes`.
    contact_size : float, default 8e-05
        Edge length in the contact zone, down to a depth of the shorter half width of the zone [m].
    edge_size : float, default 0.0005
        Largest edge length [m].

    Returns
    -------
    TetrahedralPatchSizes
        Dimensions of the patch, and sizes of its cells.
    """
    across, along = zone[0] * width[0], zone[1] * width[1]
    return TetrahedralPatchSizes(width, depth, zone, (across, along, min(across, along)), contact_size, edge_size)


def mesh_patch_with_tetrahedra(sizes: TetrahedralPatchSizes, box_faces: RefinementBoxFaces) -> TetrahedralPatchMesh:
    """Mesh a contact patch, the box of fine cells around a contact, with first-order tetrahedra by gmsh.

    Parameters
    ----------
    sizes : TetrahedralPatchSizes
        Dimensions of the patch, and sizes of its cells.
    box_faces : RefinementBoxFaces
        Face mesh of the refinement box in the coarse body that the patch fills. Its triangles, each split into four
        first-order ones, bound the patch, so that the patch conforms to a first-order coarse body.

    Returns
    -------
    TetrahedralPatchMesh
        The mesh of the patch.
    """
    with gmsh_session(OPTIONS) as gmsh:
        gmsh.model.add("patch")
        inner, ring = _add_patch_volume(gmsh, sizes, box_faces)
        _set_element_sizes(gmsh, sizes)
        gmsh.model.mesh.generate(3)
        return _read_patch_mesh(gmsh, sizes, inner, ring)


def _set_element_sizes(gmsh: Any, box: TetrahedralPatchSizes) -> None:
    """Set gmsh's element sizes: ``box.smallest_edge_length`` in the inner box at the contact, larger sizes outside.

    Inside the volume, sizes are divided by `LARGER`, because gmsh's tetrahedra are larger than requested.
    """
    across, along, depth = (MM * length for length in box.fine_box)
    away = "+".join(f"Max(0,Abs({x})-{half:.17g})^2" for x, half in (("x", across), ("y", depth), ("z", along)))
    smallest, largest = MM * box.smallest_edge_length, MM * box.largest_edge_length
    edge = f"Min({largest:.17g},{smallest:.17g}+{box.growth_per_distance:.17g}*Sqrt({away}))"
    field = gmsh.model.mesh.field
    on_faces, within, inside, finest = (field.add(name) for name in ("MathEval", "MathEval", "Restrict", "Min"))
    field.setString(on_faces, "F", edge)
    field.setString(within, "F", f"{edge}/{LARGER}")
    field.setNumber(inside, "InField", within)
    field.setNumbers(inside, "VolumesList", [tag for _, tag in gmsh.model.getEntities(3)])
    field.setNumber(inside, "IncludeBoundary", 0)
    field.setNumbers(finest, "FieldsList", [on_faces, inside])
    field.setAsBackgroundMesh(finest)


def _add_patch_volume(gmsh: Any, box: TetrahedralPatchSizes, box_faces: RefinementBoxFaces) -> tuple[int, int]:
    """Add a contact patch, a box of fine cells around a contact, to gmsh's model, as a volume bounded by plane faces.

    ``box``: dimensions of the patch; ``box_faces``: face mesh of the refinement box that it fills. Returns the numbers of
    two surfaces at depth 0 in gmsh's model: the contact zone, and the ring around it.
    """
    geo = gmsh.model.geo
    corners, triangles = box_faces.xi, box_faces.triangles[:, np.array(SUB_TRIANGLES)].reshape(-1, 3).tolist()
    scale = MM * np.array([box.half_widths[0], box.depth, box.half_widths[1]])
    points = {i: geo.addPoint(*(scale * corners[i])) for i in np.unique(box_faces.triangles).tolist()}
    lines: dict[tuple[int, int], int] = {}

    def add_line(i: int, j: int) -> int:
        """Return the number of the line between two corners, which is created once; negative for the reverse direction."""
        if (j, i) in lines:
            return -lines[j, i]
        if (i, j) not in lines:
            lines[i, j] = geo.addLine(points[i], points[j])
        return lines[i, j]

    def add_plane_face(outline: list[int], *holes: int) -> int:
        """Return the number of the plane face with a closed outline through corners; ``holes``: loops of its holes."""
        loop = geo.addCurveLoop([add_line(i, j) for i, j in pairwise([*outline, outline[0]])])
        return int(geo.addPlaneSurface([loop, *holes]))

    a, b = scale[0] * box.contact_zone_fractions[0], scale[2] * box.contact_zone_fractions[1]
    square = [geo.addPoint(x, 0.0, z) for x, z in ((-a, -b), (a, -b), (a, b), (-a, b))]
    zone = geo.addCurveLoop([geo.addLine(square[k], square[(k + 1) % 4]) for k in range(4)])
    rim, middles = rim_nodes_of_refinement_box(box_faces).tolist(), box_faces.midside_node_of_edge
    rim = [node for a, b in pairwise([*rim, rim[0]]) for node in (a, middles[min(a, b), max(a, b)])]
    inner, ring = geo.addPlaneSurface([zone]), add_plane_face(rim, zone)
    shell = [inner, ring, *map(add_plane_face, triangles)]
    geo.addVolume([geo.addSurfaceLoop(shell)])
    geo.synchronize()
    return inner, ring


def _read_patch_mesh(gmsh: Any, box: TetrahedralPatchSizes, inner: int, ring: int) -> TetrahedralPatchMesh:
    """Read the mesh of a contact patch from gmsh's model, and convert its nodes to local coordinates.

    A contact patch is a box of fine cells around a contact; ``box``: its dimensions; ``inner``, ``ring``: numbers of the
    model's surfaces for the contact zone and for the ring around it.
    """
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    xi = xyz.reshape(-1, 3) / (MM * np.array([box.half_widths[0], box.depth, box.half_widths[1]]))
    tets, (zone, around) = number_elements(gmsh, 4, tags, 4), (number_elements(gmsh, 2, tags, 3, x) for x in (inner, ring))
    contact = np.unique(zone)
    place = np.round(xi[contact], 9)
    contact = contact[np.lexsort((place[:, 2], place[:, 0]))]
    return TetrahedralPatchMesh(xi, tets, np.concatenate([zone, around]), contact)


def signed_volumes(points: Array, tetrahedra: Index) -> Array:
    """Compute the volumes of tetrahedra; the volume of an inverted tetrahedron is negative.

    Parameters
    ----------
    points : (n, 3) Array
        Coordinates of the nodes [m].
    tetrahedra : (m, 4) Index
        Corner nodes of the tetrahedra.

    Returns
    -------
    (m,) Array
        Volumes [m3].

    Examples
    --------
    >>> signed_volumes(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]])).round(4).tolist()
    [0.1667]
    """
    corner = points[tetrahedra]
    return np.asarray(np.linalg.det(corner[:, 1:] - corner[:, :1]) / 6.0)


#: Division of a ten-node tetrahedron (gmsh's node order) into first-order ones with positive volume: four at its corners,
#: and four around one of the three diagonals of the remaining octahedron. A diagonal is given by its two end nodes and the
#: ring of the other four nodes.
_CORNERS = np.array([[0, 4, 6, 7], [4, 1, 5, 9], [6, 5, 2, 8], [7, 9, 8, 3]])
_DIAGONALS = ((4, 8, (5, 6, 7, 9)), (5, 7, (4, 9, 8, 6)), (6, 9, (4, 5, 8, 7)))
_OCTAHEDRON = np.array([[[p, q, ring[k], ring[(k + 1) % 4]] for k in range(4)] for p, q, ring in _DIAGONALS])


def split_into_linear_tetrahedra(points: Array, cells: Index) -> Index:
    """Divide each second-order tetrahedron into eight first-order tetrahedra on its ten nodes.

    Parameters
    ----------
    points : (n, 3) Array
        Coordinates of the nodes [m].
    cells : (m, 10) Index
        Nodes of the second-order tetrahedra, in gmsh's order.

    Returns
    -------
    (8 m, 4) Index
        Nodes of the first-order tetrahedra: eight rows for each cell, cell by cell.

    Raises
    ------
    ValueError
        A cell is so strongly curved that each division has an inverted tetrahedron.
    """
    volume = signed_volumes(points, cells[:, _CORNERS].reshape(-1, 4)).reshape(-1, 4).min(axis=1)
    ends = np.array([[p, q] for p, q, _ in _DIAGONALS])
    length = np.linalg.norm(points[cells[:, ends[:, 0]]] - points[cells[:, ends[:, 1]]], axis=2)
    middle = signed_volumes(points, cells[:, _OCTAHEDRON].reshape(-1, 4)).reshape(-1, 3, 4).min(axis=2)
    choice = np.where(middle > 0.0, length, np.inf).argmin(axis=1)
    worst = np.minimum(volume, np.take_along_axis(middle, choice[:, None], 1)[:, 0])
    if not np.all(worst > 0.0):
        raise ValueError(
            f"{int((worst <= 0.0).sum())} of {len(cells)} second-order cells are too curved to be split: refine the mesh"
        )
    parts = np.concatenate([np.broadcast_to(_CORNERS, (len(cells), 4, 4)), _OCTAHEDRON[choice]], axis=1)
    return np.take_along_axis(cells, parts.reshape(len(cells), 32), axis=1).reshape(-1, 4)
