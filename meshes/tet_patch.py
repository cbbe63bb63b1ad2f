"""Local first-order tetrahedra of a fine patch by gmsh, as the source meshed its contacts, and first-order coarse bodies.

A patch's box is meshed in its local coordinates (gamma, depth, azimuth) scaled to lengths, with a body of influence about
the contact. The contact zone is a separate surface, so that the patches of ball and groove have the same contact nodes
even where their sockets are triangulated differently. Units inside: mm (gmsh), metres outside.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.shell import MM, gmsh_session
from rollbench.meshes.sockets import SocketMesh

#: Edge of gmsh's Delaunay tetrahedra over the one asked for (cube root of mean volumes).
LARGER = 1.22
#: Options of gmsh.
OPTIONS = {
    "General.NumThreads": 1,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
}
#: The four triangles that the nodes of a second-order triangle make: three at the corners, one in the middle.
SUB_TRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


@dataclass(frozen=True)
class TetBox:
    """Box of a patch, and the sizes of its cells."""

    #: Half widths across the groove (gamma) and along it (azimuth) [m].
    width: tuple[float, float]
    #: Depth [m].
    depth: float
    #: Half widths of the contact zone across and along, in local units.
    zone: tuple[float, float]
    #: Semi-axes across and along of the box of cells of edge ``fine`` about the contact, and its depth [m].
    influence: tuple[float, float, float]
    #: Edge of the cells in that box [m].
    fine: float
    #: Largest edge [m].
    far: float
    #: Growth of the edge per unit of distance from that box.
    growth: float = 0.2


@dataclass(frozen=True)
class LocalTets:
    """First-order tetrahedra of a patch in its local coordinates."""

    #: Nodes ``(n, 3)``: gamma and azimuth in [-1, 1], depth in [0, 1].
    xi: Array
    #: Tetrahedra ``(m, 4)``.
    tets: Index
    #: Triangles of the face of depth 0 ``(t, 3)``.
    top: Index
    #: Nodes of the contact zone ``(c,)``, in the order of gamma, then azimuth.
    contact: Index
    #: Time that gmsh took [s].
    seconds: float


def source_box(
    width: tuple[float, float], depth: float, zone: tuple[float, float], fine: float = 0.08e-3, far: float = 0.5e-3
) -> TetBox:
    """Box with cells as in the source: of equal edge throughout the contact zone.

    Parameters
    ----------
    width, depth, zone
        As the fields of `TetBox`.
    fine : float, default 8e-05
        Edge in the contact zone, and down to a depth of the zone's short half width [m].
    far : float, default 0.0005
        Largest edge [m].

    Returns
    -------
    TetBox
        The box.
    """
    across, along = zone[0] * width[0], zone[1] * width[1]
    return TetBox(width, depth, zone, (across, along, min(across, along)), fine, far)


def build_tets(box: TetBox, socket: SocketMesh | None = None) -> LocalTets:
    """Mesh the box of a patch with gmsh.

    Parameters
    ----------
    box : TetBox
        Dimensions and sizes.
    socket : SocketMesh, optional, default None
        Its first-order triangles (four of every second-order one) are kept or divided, so that a first-order patch
        conforms to a first-order coarse body; None: five plane faces.

    Returns
    -------
    LocalTets
        The tetrahedra.

    Raises
    ------
    ValueError
        The contact zone leaves no room, or the socket's faces do not leave one open rim.
    """
    if not (0.0 < max(box.zone) < 1.0 and min(box.zone) > 0.0):
        raise ValueError(f"contact zone of half widths {box.zone} in a patch of 1 x 1: must lie between 0 and 1")
    begin = perf_counter()
    with gmsh_session(OPTIONS) as gmsh:
        gmsh.model.add("patch")
        inner, ring = _add_geometry(gmsh, box, socket)
        _set_sizes(gmsh, box)
        gmsh.model.mesh.generate(3)
        return _collect_arrays(gmsh, box, inner, ring, begin)


def _set_sizes(gmsh: Any, box: TetBox) -> None:
    """Element sizes: `fine` within the body of influence, growing with the distance from it; smaller on request."""
    across, along, depth = (MM * length for length in box.influence)
    away = "+".join(f"Max(0,Abs({x})-{half:.17g})^2" for x, half in (("x", across), ("y", depth), ("z", along)))
    edge = f"Min({MM * box.far:.17g},{MM * box.fine:.17g}+{box.growth:.17g}*Sqrt({away}))"
    field = gmsh.model.mesh.field
    on_faces, within, inside, finest = (field.add(name) for name in ("MathEval", "MathEval", "Restrict", "Min"))
    field.setString(on_faces, "F", edge)
    field.setString(within, "F", f"{edge}/{LARGER}")
    field.setNumber(inside, "InField", within)
    field.setNumbers(inside, "VolumesList", [tag for _, tag in gmsh.model.getEntities(3)])
    field.setNumber(inside, "IncludeBoundary", 0)
    field.setNumbers(finest, "FieldsList", [on_faces, inside])
    field.setAsBackgroundMesh(finest)


def _socket_faces(socket: SocketMesh | None) -> tuple[Array, list[list[int]]]:
    """Corners in local coordinates and polygons of the faces towards the body."""
    if socket is None:
        corners = np.array([[a, d, b] for a in (-1.0, 1.0) for d in (0.0, 1.0) for b in (-1.0, 1.0)])
        return corners, [[0, 1, 3, 2], [4, 5, 7, 6], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    triangles = [[int(tri[k]) for k in sub] for tri in socket.triangles for sub in SUB_TRIANGLES]
    return socket.xi, triangles


def _rim_corners(corners: Array, polygons: list[list[int]]) -> list[int]:
    """Corners around the open top, in order."""
    sides: dict[tuple[int, int], int] = {}
    for p in polygons:
        for i, j in zip(p, [*p[1:], p[0]], strict=True):
            sides[min(i, j), max(i, j)] = sides.get((min(i, j), max(i, j)), 0) + 1
    near: dict[int, list[int]] = {}
    for (i, j), count in sides.items():
        if count == 1:
            near.setdefault(i, []).append(j)
            near.setdefault(j, []).append(i)
    if not near or any(len(ends) != 2 or abs(corners[i, 1]) > 1e-9 for i, ends in near.items()):
        raise ValueError("the faces of a socket do not leave one open rim at its top")
    loop = [min(near)]
    loop.append(near[loop[0]][0])
    while (following := next(i for i in near[loop[-1]] if i != loop[-2])) != loop[0]:
        loop.append(following)
    if len(loop) != len(near):
        raise ValueError("the faces of a socket do not leave one open rim at its top")
    return loop


def _add_geometry(gmsh: Any, box: TetBox, socket: SocketMesh | None) -> tuple[int, int]:
    """Bound the box by plane faces; returns the surfaces of the contact zone and of the ring around it."""
    geo = gmsh.model.geo
    corners, polygons = _socket_faces(socket)
    scale = MM * np.array([box.width[0], box.depth, box.width[1]])
    points = {i: geo.addPoint(*(scale * corners[i])) for i in sorted({i for p in polygons for i in p})}
    lines: dict[tuple[int, int], int] = {}

    def line(i: int, j: int) -> int:
        """Line between two corners, made once; negative where it is reversed."""
        if (j, i) in lines:
            return -lines[j, i]
        if (i, j) not in lines:
            lines[i, j] = geo.addLine(points[i], points[j])
        return lines[i, j]

    def loop(p: list[int]) -> int:
        return int(geo.addCurveLoop([line(i, j) for i, j in zip(p, [*p[1:], p[0]], strict=True)]))

    a, b = scale[0] * box.zone[0], scale[2] * box.zone[1]
    square = [geo.addPoint(x, 0.0, z) for x, z in ((-a, -b), (a, -b), (a, b), (-a, b))]
    zone = geo.addCurveLoop([geo.addLine(square[k], square[(k + 1) % 4]) for k in range(4)])
    inner, ring = geo.addPlaneSurface([zone]), geo.addPlaneSurface([loop(_rim_corners(corners, polygons)), zone])
    shell = [inner, ring, *(geo.addPlaneSurface([loop(p)]) for p in polygons)]
    geo.addVolume([geo.addSurfaceLoop(shell)])
    geo.synchronize()
    return inner, ring


def _collect_arrays(gmsh: Any, box: TetBox, inner: int, ring: int, begin: float) -> LocalTets:
    """Arrays of the mesh in local coordinates."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    index[tags.astype(np.int64)] = np.arange(tags.size)
    xi = xyz.reshape(-1, 3) / (MM * np.array([box.width[0], box.depth, box.width[1]]))

    def cells(kind: int, dimension: int, entity: int = -1) -> Index:
        nodes = gmsh.model.mesh.getElementsByType(kind, entity)[1]
        return np.asarray(index[nodes.astype(np.int64)].reshape(-1, dimension + 1), dtype=np.int64)

    tets, zone = cells(4, 3), cells(2, 2, inner)
    contact = np.unique(zone)
    place = np.round(xi[contact], 9)
    contact = contact[np.lexsort((place[:, 2], place[:, 0]))]
    return LocalTets(xi, tets, np.concatenate([zone, cells(2, 2, ring)]), contact, perf_counter() - begin)


def signed_volumes(points: Array, tets: Index) -> Array:
    """Volumes of tetrahedra, negative for those turned inside out.

    Parameters
    ----------
    points : (n, 3) Array
        Nodes [m].
    tets : (m, 4) Index
        Corners of the tetrahedra.

    Returns
    -------
    (m,) Array
        Volumes [m3].

    Examples
    --------
    >>> signed_volumes(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2, 3]])).round(4).tolist()
    [0.1667]
    """
    corner = points[tets]
    return np.asarray(np.linalg.det(corner[:, 1:] - corner[:, :1]) / 6.0)


#: Nodes of a 10-node tetrahedron (gmsh order): four first-order ones at its corners, and the octahedron that is left about
#: each of its three diagonals (ends first, then the ring of the other four), all positively oriented.
_CORNERS = np.array([[0, 4, 6, 7], [4, 1, 5, 9], [6, 5, 2, 8], [7, 9, 8, 3]])
_DIAGONALS = ((4, 8, (5, 6, 7, 9)), (5, 7, (4, 9, 8, 6)), (6, 9, (4, 5, 8, 7)))
_OCTAHEDRON = np.array([[[p, q, ring[k], ring[(k + 1) % 4]] for k in range(4)] for p, q, ring in _DIAGONALS])


def split_second_order(points: Array, cells: Index) -> Index:
    """Divide each second-order tetrahedron into eight first-order ones on its nodes.

    Parameters
    ----------
    points : (n, 3) Array
        Nodes [m].
    cells : (m, 10) Index
        Second-order tetrahedra, in gmsh's order.

    Returns
    -------
    (8 m, 4) Index
        First-order tetrahedra, cell after cell.

    Raises
    ------
    ValueError
        A cell is so strongly curved that no division works.
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
