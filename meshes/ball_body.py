"""Coarse mesh of a ball by gmsh: second-order tetrahedra with a socket, a truncated pyramid, at every contact."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshes.groove_map import GrooveMap
from meshes.grooved_body import MM, SocketMesh, face_triangles, match_socket, standard_socket, straighten

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class BallSocket:
    """Socket of one side: half widths of the pyramid's base (tangents of its angles), depth below the surface [m]."""

    side: int
    across: float
    along: float
    depth: float


@dataclass(frozen=True)
class BallBody:
    """Mesh of a ball about its centre in the frame of azimuth 0: points ``(n, 3)`` [m], second-order tetrahedra, per
    socket its nodes and its faces' mesh."""

    points: Array
    cells: Index
    socket_nodes: dict[int, Index]
    sockets: dict[int, SocketMesh]
    seconds: float


def directions(m: GrooveMap, side: int) -> Array:
    """Rows: contact direction, direction of growing gamma, direction of growing azimuth, at azimuth 0, ``(3, 3)``."""
    sx, sz = m.signs[side]
    x3, y3 = np.array([1.0, 0.0, 0.0]), np.array([0.0, cos(m.alpha), sin(m.alpha)])
    z3 = np.array([0.0, -sin(m.alpha), cos(m.alpha)])
    c, s = cos(m.beta), sin(m.beta)
    return np.stack([sx * c * x3 + sz * s * z3, -sx * s * x3 + sz * c * z3, y3])


def pyramid_points(m: GrooveMap, socket: BallSocket, s: Array, t: Array, depth: Array) -> Array:
    """Points ``(n, 3)`` [m] on the rays n + s t1 + t t2: depth 0 on the sphere, 1 on the inner plane."""
    n, t1, t2 = directions(m, socket.side)
    ray = n[None, :] + s[:, None] * t1 + t[:, None] * t2
    outer = m.ball / np.linalg.norm(ray, axis=1)
    return np.asarray(ray * (outer + depth * (m.ball - socket.depth - outer))[:, None])


def build_ball(m: GrooveMap, sockets: tuple[BallSocket, ...], fine: float, coarse: float, cuts: int = 2) -> BallBody:
    """Mesh a ball with a socket for each contact. Raises ValueError where sockets overlap or the mesh is bad."""
    import gmsh

    begin = perf_counter()
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("ball")
        faces = _geometry(gmsh, m, sockets)
        _sizes(gmsh, faces, fine, coarse, cuts)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        return _collect(gmsh, m, sockets, faces, perf_counter() - begin)
    finally:
        gmsh.finalize()


def _geometry(gmsh: Any, m: GrooveMap, sockets: tuple[BallSocket, ...]) -> list[list[int]]:
    occ = gmsh.model.occ
    ball = [(3, occ.addSphere(0, 0, 0, MM * m.ball))]
    occ.rotate(ball, 0, 0, 0, 0, 0, 1, float(np.pi / 2))  # the seam of the sphere must not run through a socket
    boxes = []
    for socket in sockets:
        n, t1, t2 = directions(m, socket.side)
        corners = []
        for height in (m.ball - socket.depth, 1.2 * m.ball):
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                x = MM * height * (n + a * socket.across * t1 + b * socket.along * t2)
                corners.append(occ.addPoint(*[float(v) for v in x]))
        loops = []
        for k in (0, 4):
            lines = [occ.addLine(corners[k + i], corners[k + (i + 1) % 4]) for i in range(4)]
            loops.append(occ.addWire(lines))
        boxes += occ.addThruSections(loops, makeSolid=True, makeRuled=True)
    boxes = [x for x in boxes if x[0] == 3]
    pieces, origin = occ.fragment(ball, boxes)
    own = set(origin[0])
    inside = [[x for x in found if x in own] for found in origin[1:]]
    if any(len(x) != 1 for x in inside):
        raise ValueError("a contact patch does not fit the ball: make the sockets smaller")
    taken = {x[0] for x in inside}
    main = [x for x in own if x not in taken]
    occ.remove([x for x in pieces if x not in own], recursive=True)
    occ.synchronize()
    shared = {abs(t) for _, t in gmsh.model.getBoundary(main, oriented=False)}
    faces = [[abs(t) for _, t in gmsh.model.getBoundary(x, oriented=False) if abs(t) in shared] for x in inside]
    if any(len(f) != 5 for f in faces):
        raise ValueError("two contact patches of a ball overlap: make the sockets smaller")
    occ.remove(sorted(taken), recursive=False)
    occ.synchronize()
    return faces


def _sizes(gmsh: Any, sockets: list[list[int]], fine: float, coarse: float, cuts: int) -> None:
    mesh = gmsh.model.mesh
    curves: set[int] = set()
    for faces in sockets:
        for f in faces:
            curves |= {abs(c) for _, c in gmsh.model.getBoundary([(2, f)], oriented=False)}
    for c in curves:
        mesh.setTransfiniteCurve(c, cuts + 1)
    for faces in sockets:
        for f in faces:
            mesh.setTransfiniteSurface(f, "Left")
    for name in ("Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints", "Mesh.MeshSizeFromCurvature"):
        gmsh.option.setNumber(name, 0)
    field = mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", sorted(curves))
    field.setNumber(distance, "Sampling", 5)
    size = field.add("Threshold")
    for key, value in (
        ("InField", distance), ("SizeMin", MM * fine), ("SizeMax", MM * coarse), ("DistMin", 0.2), ("DistMax", 2.0),
    ):  # fmt: skip
        field.setNumber(size, key, value)
    field.setAsBackgroundMesh(size)


def _collect(
    gmsh: Any, m: GrooveMap, sockets: tuple[BallSocket, ...], faces: list[list[int]], seconds: float
) -> BallBody:
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    index[tags.astype(np.int64)] = np.arange(tags.size)
    points = xyz.reshape(-1, 3) / MM
    types, _, nodes = gmsh.model.mesh.getElements(3)
    cells = index[nodes[list(types).index(11)].astype(np.int64).reshape(-1, 10)]
    rows: dict[int, Index] = {}
    meshes: dict[int, SocketMesh] = {}
    for own_faces, socket in zip(faces, sockets, strict=True):
        triangles, owner = face_triangles(gmsh, own_faces)
        local = index[triangles]
        corner = np.unique(local[:, :3])
        xi = ball_coordinates(m, socket, points[corner])
        standard = standard_socket(xi, corner, local, owner)
        own, _ = match_socket(standard, xi, corner, local)
        points[own] = pyramid_points(
            m, socket, socket.across * standard.xi[:, 0], socket.along * standard.xi[:, 2], standard.xi[:, 1]
        )
        rows[socket.side], meshes[socket.side] = own, standard
    used = np.unique(cells)
    new = np.full(points.shape[0], -1, dtype=np.int64)
    new[used] = np.arange(used.size)
    keep = np.concatenate([new[r] for r in rows.values()])
    placed = straighten(points[used], new[cells], keep)
    return BallBody(placed, new[cells], {s: new[r] for s, r in rows.items()}, meshes, seconds)


def ball_coordinates(m: GrooveMap, socket: BallSocket, points: Array) -> Array:
    """Local coordinates xi ``(n, 3)`` of points in a socket: across and along in [-1, 1], depth in [0, 1]."""
    n, t1, t2 = directions(m, socket.side)
    height = points @ n
    s, t = (points @ t1) / height, (points @ t2) / height
    outer = m.ball / np.sqrt(1.0 + s * s + t * t)
    return np.stack([s / socket.across, (outer - height) / (outer - (m.ball - socket.depth)), t / socket.along], axis=1)
