"""Coarse mesh of a screw or nut by gmsh: second-order tetrahedra of the unrolled body, with a socket at every contact.

The body is unrolled to (u, z, w), u = R_p phi, w = R_p log(r / R_p): cylinders become planes, the flat ends stay planes,
the groove becomes a straight prism, and angles in the cross-section are kept down to a small bore (the map is conformal).
A socket is a box around a contact, bounded by surfaces of constant angle gamma, depth and azimuth; its five
inner faces carry the same structured triangulation on every contact, so that one fine patch fits them all. The seam is
meshed periodically and closed after the map to space. Units inside: mm (gmsh), metres outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial import cKDTree

from meshes.groove_map import GrooveMap

Array = NDArray[np.float64]
Index = NDArray[np.int64]
MM = 1e3


@dataclass(frozen=True)
class SocketSize:
    """Half width in gamma [rad], depth below the groove [m], half width in azimuth [rad], edges' subdivisions (3,)."""

    gamma: float
    depth: float
    phi: float
    cuts: tuple[int, int, int] = (2, 2, 2)


@dataclass(frozen=True)
class BodySpec:
    """A grooved tube between radii r_in < r_out [m] and flat ends z_low < z_high [m] (z absolute).

    outer: whether the groove is cut from outside (screw) or from inside (nut); sockets: (azimuth of the ball's section
    including its start [rad], z of the ball [m], side) of every contact; fine, coarse: element sizes near and away from
    the sockets [m].
    """

    r_in: float
    r_out: float
    z_low: float
    z_high: float
    outer: bool
    sockets: tuple[tuple[float, float, int], ...]
    size: SocketSize
    fine: float
    coarse: float


@dataclass(frozen=True)
class SocketMesh:
    """Inner faces of a socket: local coordinates xi ``(k, 3)`` of the nodes (gamma and azimuth in [-1, 1], depth in
    [0, 1]), second-order triangles ``(t, 6)``, the face each lies on, and the midpoint of every edge of corners."""

    xi: Array
    triangles: Index
    face: Index
    edges: dict[tuple[int, int], int]


@dataclass(frozen=True)
class GroovedBody:
    """Mesh: points ``(n, 3)`` [m], second-order tetrahedra ``(m, 10)``; per socket the nodes of its inner faces in the
    order of its side's ``sockets`` mesh ``(count, k)``; nodes of the flat ends; how far gmsh's socket corners were from
    their standard places (in units of the socket) before they were put there."""

    points: Array
    cells: Index
    socket_nodes: Index
    sockets: dict[int, SocketMesh]
    low_end: Index
    high_end: Index
    deviation: float
    seconds: float


def deep(m: GrooveMap, r: float | Array) -> Any:
    """Third unrolled coordinate of a radius [m], in mm."""
    return MM * m.R * np.log(np.asarray(r) / m.R)


def socket_centre(m: GrooveMap, side: int) -> tuple[float, float, float]:
    """(r, zeta, psi) of the nominal contact point of a side."""
    x3, z3 = m.section(side, np.array(m.beta), np.array(m.radius[side]))
    r, zeta, psi = m.unroll(x3, z3)
    return float(r), float(zeta), float(psi)


def seam_path(m: GrooveMap, spec: BodySpec) -> list[tuple[float, float]]:
    """Points (phi, z) of a seam that passes every groove turn midway between two sockets."""
    lines = groove_lines(m, spec, -np.pi, -np.pi)
    path: list[tuple[float, float]] = []
    occupied = [(phi + socket_centre(m, side)[2], z - m.rg * phi, z) for phi, z, side in spec.sockets]
    for offset in sorted(lines):
        own = np.array([p for p, o, _ in occupied if abs(o - offset) < 1e-6 or m.rg == 0.0])
        want = -np.pi
        best = want
        if own.size:
            shifted = np.sort(np.unique(np.round(np.mod(own - want + np.pi, 2.0 * np.pi) - np.pi, 9)))
            ring = np.concatenate([[shifted[-1] - 2.0 * np.pi], shifted, [shifted[0] + 2.0 * np.pi]])
            middles = 0.5 * (ring[1:] + ring[:-1])
            room = np.diff(ring)
            middles = middles[room > 2.2 * spec.size.phi]
            if middles.size:
                best = want + float(middles[np.abs(middles).argmin()])
        path.append((best, offset + m.rg * best))
    if not path:
        path = [(-np.pi, 0.5 * (spec.z_low + spec.z_high))]
    path.sort(key=lambda x: x[1])
    inside = [x for x in path if spec.z_low < x[1] < spec.z_high] or [path[len(path) // 2]]
    return [(inside[0][0], spec.z_low), *inside, (inside[-1][0], spec.z_high)]


def groove_lines(m: GrooveMap, spec: BodySpec, phi_low: float, phi_high: float) -> list[float]:
    """Offsets z - rg phi [m] of all groove lines that meet the body for azimuths phi_low to phi_high + 2 pi."""
    offsets: list[float] = []
    for start in range(m.starts):
        base = m.z0 - m.rg * (m.phase + 2.0 * np.pi * start / m.starts)
        if m.rg == 0.0:
            offsets.append(base)
            continue
        pitch = 2.0 * np.pi * m.rg
        reach = float(m.radius.max())
        values = base + pitch * np.arange(-400, 401)
        ends = np.stack([values + m.rg * phi_low, values + m.rg * (phi_high + 2.0 * np.pi)])
        keep = (ends.max(axis=0) > spec.z_low - reach) & (ends.min(axis=0) < spec.z_high + reach)
        offsets += [float(v) for v in values[keep]]
    return sorted(set(offsets))


def build_body(m: GrooveMap, spec: BodySpec) -> GroovedBody:
    """Mesh a grooved body. Raises ValueError where a socket does not fit or the mesh is bad."""
    from time import perf_counter

    import gmsh

    begin = perf_counter()
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("body")
        sockets, path = _geometry(gmsh, m, spec)
        _sizes(gmsh, m, spec, sockets, path)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        return _collect(gmsh, m, spec, sockets, perf_counter() - begin)
    finally:
        gmsh.finalize()


def _spline(occ: Any, rows: Sequence[tuple[float, float, float]]) -> tuple[int, list[int]]:
    points = [occ.addPoint(*row) for row in rows]
    return occ.addBSpline(points), points


def _geometry(gmsh: Any, m: GrooveMap, spec: BodySpec) -> tuple[list[list[int]], list[tuple[float, float]]]:
    """Cut the channel, fragment with the sockets; returns the inner faces of every socket and the seam."""
    occ = gmsh.model.occ
    path = seam_path(m, spec)
    polygon = [(p, z) for p, z in path] + [(p + 2.0 * np.pi, z) for p, z in reversed(path)]
    corners = [occ.addPoint(MM * m.R * p, MM * z, float(deep(m, spec.r_in))) for p, z in polygon]
    edges = [occ.addLine(corners[i], corners[(i + 1) % len(corners)]) for i in range(len(corners))]
    face = occ.addPlaneSurface([occ.addCurveLoop(edges)])
    body = [x for x in occ.extrude([(2, face)], 0, 0, float(deep(m, spec.r_out) - deep(m, spec.r_in))) if x[0] == 3]
    phis = [p for p, _ in path]
    channels = _channels(occ, m, spec, min(phis) - 0.4, max(phis) + 0.4)
    if channels:
        body, _ = occ.cut(body, channels)
    boxes = [_socket(occ, m, spec, path, s) for s in spec.sockets]
    if not boxes:
        occ.synchronize()
        return [], path
    pieces, origin = occ.fragment(body, boxes)
    own = set(origin[0])
    inside = [[x for x in found if x in own] for found in origin[len(body) :]]
    if any(len(x) != 1 for x in inside):
        raise ValueError("a contact patch does not fit its groove: make the sockets smaller")
    taken = {x[0] for x in inside}
    main = [x for x in own if x not in taken]
    occ.remove([x for x in pieces if x not in own], recursive=True)
    occ.synchronize()
    shared = {abs(t) for _, t in gmsh.model.getBoundary(main, oriented=False)}
    faces = [
        [abs(t) for _, t in gmsh.model.getBoundary(x, oriented=False) if abs(t) in shared] for x in inside
    ]
    if any(len(f) != 5 for f in faces):
        raise ValueError("two contact patches overlap, or one reaches the seam or an end: make the sockets smaller")
    occ.remove(sorted(taken), recursive=False)
    occ.synchronize()
    return faces, path


def _channels(occ: Any, m: GrooveMap, spec: BodySpec, phi_low: float, phi_high: float) -> list[tuple[int, int]]:
    """Prisms of the groove, one per turn that meets the body."""
    pair = (0, 1) if spec.outer else (2, 3)
    land = spec.r_out if spec.outer else spec.r_in
    beyond = land + (0.3e-3 if spec.outer else -0.3e-3)
    rows = []
    for side in pair:
        slack = m.radius[side] - m.ball
        apex = float(np.arcsin(slack * np.sin(m.beta) / m.radius[side]))

        def excess(gamma: float, side: int = side) -> float:
            x3, z3 = m.section(side, np.array(gamma), np.array(m.radius[side]))
            return float(m.unroll(x3, z3)[0]) - beyond

        edge = float(brentq(excess, 0.35, np.pi / 2 + 0.6))
        gamma = np.linspace(edge, apex, 25) if side == pair[0] else np.linspace(apex, edge, 25)
        r, zeta, _ = m.unroll(*m.section(side, gamma, np.full(25, m.radius[side])))
        rows.append((r, zeta))
    span = phi_high + 2.0 * np.pi - phi_low
    made = []
    for offset in groove_lines(m, spec, phi_low, phi_high):
        z = offset + m.rg * phi_low

        def place(r: Array, zeta: Array, z: float = z) -> list[tuple[float, float, float]]:
            return [(MM * m.R * phi_low, MM * (z + b), float(deep(m, a))) for a, b in zip(r, zeta, strict=True)]

        first, p1 = _spline(occ, place(*rows[0]))
        points = [p1[-1]] + [occ.addPoint(*x) for x in place(*rows[1])[1:]]
        second = occ.addBSpline(points)
        loop = occ.addCurveLoop([first, second, occ.addLine(points[-1], p1[0])])
        face = occ.addPlaneSurface([loop])
        made += [x for x in occ.extrude([(2, face)], MM * m.R * span, MM * m.rg * span, 0) if x[0] == 3]
    return made


def _at_seam(path: list[tuple[float, float]], z: float) -> float:
    return float(np.interp(z, [p[1] for p in path], [p[0] for p in path]))


def _socket(
    occ: Any, m: GrooveMap, spec: BodySpec, path: list[tuple[float, float]], socket: tuple[float, float, int]
) -> tuple[int, int]:
    """Box of one contact, reaching a little into the channel so that its rim is cut by the groove itself."""
    phi, z, side = socket
    size = spec.size
    _, zeta0, psi0 = socket_centre(m, side)
    total = phi + psi0
    offset = z - m.rg * phi
    low = _at_seam(path, offset + m.rg * total + zeta0)
    total = total - 2.0 * np.pi * np.floor((total - low) / (2.0 * np.pi))
    turns = np.round((phi + psi0 - total) / (2.0 * np.pi))
    base_phi = total - size.phi
    base_z = offset + m.rg * (base_phi + 2.0 * np.pi * turns)
    gammas = np.linspace(m.beta - size.gamma, m.beta + size.gamma, 9)
    rhos = m.radius[side] + np.linspace(-0.25 * size.depth, size.depth, 7)

    def row(gamma: Array, rho: Array) -> list[tuple[float, float, float]]:
        r, zeta, _ = m.unroll(*m.section(side, gamma, rho))
        return [(MM * m.R * base_phi, MM * (base_z + b), float(deep(m, a))) for a, b in zip(r, zeta, strict=True)]

    inner = [occ.addPoint(*x) for x in row(gammas, np.full(9, rhos[0]))]
    outer = [occ.addPoint(*x) for x in row(gammas, np.full(9, rhos[-1]))]
    left = [inner[0]] + [occ.addPoint(*x) for x in row(np.full(7, gammas[0]), rhos)[1:-1]] + [outer[0]]
    right = [inner[-1]] + [occ.addPoint(*x) for x in row(np.full(7, gammas[-1]), rhos)[1:-1]] + [outer[-1]]
    curves = [occ.addBSpline(x) for x in (inner, right, outer, left)]
    loop = occ.addCurveLoop([curves[0], curves[1], -curves[2], -curves[3]])
    face = occ.addPlaneSurface([loop])
    made = occ.extrude([(2, face)], MM * m.R * 2.0 * size.phi, MM * m.rg * 2.0 * size.phi, 0)
    return next((x[0], x[1]) for x in made if x[0] == 3)


def _sizes(
    gmsh: Any, m: GrooveMap, spec: BodySpec, sockets: list[list[int]], path: list[tuple[float, float]]
) -> None:
    """Structured triangles on the sockets, a periodic seam, and sizes growing away from the sockets."""
    mesh = gmsh.model.mesh
    curves: set[int] = set()
    for faces in sockets:
        for f in faces:
            curves |= {abs(c) for _, c in gmsh.model.getBoundary([(2, f)], oriented=False)}
    for c in curves:
        mesh.setTransfiniteCurve(c, spec.size.cuts[0] + 1)
    for faces in sockets:
        for f in faces:
            mesh.setTransfiniteSurface(f, "Left")
    _periodic(gmsh, m, path)
    field = mesh.field
    for name in ("Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints", "Mesh.MeshSizeFromCurvature"):
        gmsh.option.setNumber(name, 0)
    if curves:
        distance = field.add("Distance")
        field.setNumbers(distance, "CurvesList", sorted(curves))
        field.setNumber(distance, "Sampling", 5)
        size = field.add("Threshold")
        for key, value in (
            ("InField", distance), ("SizeMin", MM * spec.fine), ("SizeMax", MM * spec.coarse), ("DistMin", 0.5),
            ("DistMax", 8.0),
        ):  # fmt: skip
            field.setNumber(size, key, value)
    else:
        size = field.add("MathEval")
        field.setString(size, "F", str(MM * spec.coarse))
    field.setAsBackgroundMesh(size)


def _periodic(gmsh: Any, m: GrooveMap, path: list[tuple[float, float]]) -> None:
    """Make the right side of the seam a copy of the left."""
    step = 2.0 * np.pi * m.R * MM

    def faces_on(shift: float) -> list[tuple[int, tuple[float, ...]]]:
        found = []
        for _, tag in gmsh.model.getEntities(2):
            box = gmsh.model.getBoundingBox(2, tag)
            centre = gmsh.model.occ.getCenterOfMass(2, tag)
            want = MM * m.R * _at_seam(path, centre[1] / MM) + shift
            width = abs(box[3] - box[0])
            normal = gmsh.model.getType(2, tag) == "Plane"
            if normal and abs(centre[0] - want) < 1e-4 * step and width < 0.2 * step and box[5] - box[2] > 1e-3:
                found.append((tag, tuple(np.round([centre[1], centre[2], box[1], box[4]], 4))))
        return sorted(found, key=lambda x: x[1])

    left, right = faces_on(0.0), faces_on(step)
    if len(left) != len(right) or not left or any(a[1] != b[1] for a, b in zip(left, right, strict=True)):
        raise ValueError("the two sides of the seam do not match")
    shift = [1, 0, 0, step, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    gmsh.model.mesh.setPeriodic(2, [t for t, _ in right], [t for t, _ in left], shift)


def _collect(gmsh: Any, m: GrooveMap, spec: BodySpec, sockets: list[list[int]], seconds: float) -> GroovedBody:
    """Arrays of the mesh, mapped to space, the seam closed."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    index[tags.astype(np.int64)] = np.arange(tags.size)
    unrolled = xyz.reshape(-1, 3) / MM
    phi, z, r = unrolled[:, 0] / m.R, unrolled[:, 1], m.R * np.exp(unrolled[:, 2] / m.R)
    points = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    types, _, nodes = gmsh.model.mesh.getElements(3)
    cells = index[nodes[list(types).index(11)].astype(np.int64).reshape(-1, 10)]
    socket_rows, standards, deviation = [], {}, 0.0
    placed = points.copy()
    for faces, socket in zip(sockets, spec.sockets, strict=True):
        triangles, owner = face_triangles(gmsh, faces)
        local = index[triangles]
        corner = np.unique(local[:, :3])
        xi = socket_coordinates(m, spec, socket, phi[corner], z[corner], r[corner])
        if socket[2] not in standards:
            standards[socket[2]] = standard_socket(xi, corner, local, owner)
        standard = standards[socket[2]]
        own, apart = match_socket(standard, xi, corner, local)
        deviation = max(deviation, apart)
        socket_rows.append(own)
        placed[own] = socket_points(m, spec, socket, standard.xi)
    cells, placed, socket_nodes = _close_seam(cells, points, placed, np.array(socket_rows, dtype=np.int64))
    low = np.flatnonzero(np.abs(placed[:, 2] - spec.z_low) < 1e-9)
    high = np.flatnonzero(np.abs(placed[:, 2] - spec.z_high) < 1e-9)
    placed = straighten(placed, cells, socket_nodes)
    return GroovedBody(placed, cells, socket_nodes, standards, low, high, deviation, seconds)


def _close_seam(cells: Index, points: Array, placed: Array, socket_nodes: Index) -> tuple[Index, Array, Index]:
    """Merge the nodes of both sides of the seam and drop unused ones."""
    merged = np.arange(points.shape[0])
    pairs = cKDTree(points).query_pairs(1e-9, output_type="ndarray")
    merged[pairs.max(axis=1)] = pairs.min(axis=1)
    used = np.unique(merged[cells])
    new = np.full(points.shape[0], -1, dtype=np.int64)
    new[used] = np.arange(used.size)
    final = new[merged]
    return final[cells], placed[used], final[socket_nodes]


def standard_socket(xi: Array, corner: Index, local: Index, owner: Index) -> SocketMesh:
    """Node order of the inner faces: corners, then edge midpoints, with their local coordinates."""
    lookup = {int(n): k for k, n in enumerate(corner)}
    edges: dict[tuple[int, int], int] = {}
    rows = []
    for tri in local:
        v = [lookup[int(n)] for n in tri[:3]]
        for i, j in ((0, 1), (1, 2), (2, 0)):
            edges.setdefault((min(v[i], v[j]), max(v[i], v[j])), len(corner) + len(edges))
        mids = [edges[(min(v[i], v[j]), max(v[i], v[j]))] for i, j in ((0, 1), (1, 2), (2, 0))]
        rows.append(v + mids)
    snapped = np.round(xi / np.array([1e-2, 1e-2, 1e-2])) * 1e-2
    snapped = np.where(np.abs(xi - snapped) < 5e-3, snapped, xi)
    middle = np.array([0.5 * (snapped[i] + snapped[j]) for i, j in edges])
    return SocketMesh(np.concatenate([snapped, middle]), np.array(rows), owner, edges)


def match_socket(standard: SocketMesh, xi: Array, corner: Index, local: Index) -> tuple[Index, float]:
    """Nodes of one socket in the standard order, and how far its corners are from their standard places."""
    count = len(corner)
    distance, order = cKDTree(standard.xi[:count]).query(xi)
    if np.unique(order).size != count or count != len(standard.xi) - len(standard.edges):
        raise ValueError("the sockets' triangulations differ")
    lookup = {int(n): int(k) for n, k in zip(corner, order, strict=True)}
    own = np.full(len(standard.xi), -1, dtype=np.int64)
    own[order] = corner
    for tri in local:
        v = [lookup[int(n)] for n in tri[:3]]
        for (i, j), node in zip(((0, 1), (1, 2), (2, 0)), tri[3:], strict=True):
            key = (min(v[i], v[j]), max(v[i], v[j]))
            if key not in standard.edges:
                raise ValueError("the sockets' triangulations differ")
            own[standard.edges[key]] = node
    if np.any(own < 0):
        raise ValueError("the sockets' triangulations differ")
    return own, float(distance.max())


def socket_points(m: GrooveMap, spec: BodySpec, socket: tuple[float, float, int], xi: Array) -> Array:
    """Points ``(n, 3)`` [m] of local socket coordinates; inverse of ``socket_coordinates``."""
    phi, z, side = socket
    local = local_points(m, spec.size, side, xi)
    c, s = np.cos(phi), np.sin(phi)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(local @ turn + np.array([0.0, 0.0, z]))


def local_points(m: GrooveMap, size: SocketSize, side: int, xi: Array) -> Array:
    """Points ``(n, 3)`` [m] of local socket coordinates for a ball at azimuth 0, z = 0."""
    gamma = m.beta + size.gamma * xi[:, 0]
    rho = m.radius[side] + size.depth * xi[:, 1]
    r, zeta, _ = m.unroll(*m.section(side, gamma, rho))
    return m.space(r, zeta, socket_centre(m, side)[2] + size.phi * xi[:, 2])


def straighten(points: Array, cells: Index, keep: Index, threshold: float = 0.1) -> Array:
    """Straighten edges of badly curved second-order tetrahedra, except at ``keep``; raises ValueError if any stays bad."""
    edges = ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))
    free = np.ones(points.shape[0], dtype=bool)
    free[keep.ravel()] = False
    points = points.copy()
    for _ in range(8):
        bad = cells[corner_jacobians(points, cells) < threshold]
        if not bad.size:
            break
        for k, (i, j) in enumerate(edges):
            node = bad[:, 4 + k]
            move = free[node]
            points[node[move]] = 0.5 * (points[bad[move, i]] + points[bad[move, j]])
    worst = float(corner_jacobians(points, cells).min())
    if worst <= 0.0:
        raise ValueError(f"the mesh holds inverted elements (scaled Jacobian {worst:.2g}): refine it")
    return points


def corner_jacobians(points: Array, cells: Index) -> Array:
    """Smallest Jacobian of each second-order tetrahedron over corners and edge midpoints, relative to its size."""
    from itertools import product

    bary = np.array([row for row in product((0.0, 0.5, 1.0), repeat=3) if sum(row) <= 1.0])
    x, y, z = bary.T
    w = 1.0 - x - y - z
    zero = np.zeros_like(x)
    grad = np.stack(
        [
            np.stack([1.0 - 4.0 * w] * 3, -1),
            np.stack([4.0 * x - 1.0, zero, zero], -1),
            np.stack([zero, 4.0 * y - 1.0, zero], -1),
            np.stack([zero, zero, 4.0 * z - 1.0], -1),
            np.stack([4.0 * (w - x), -4.0 * x, -4.0 * x], -1),
            np.stack([4.0 * y, 4.0 * x, zero], -1),
            np.stack([-4.0 * y, 4.0 * (w - y), -4.0 * y], -1),
            np.stack([-4.0 * z, -4.0 * z, 4.0 * (w - z)], -1),
            np.stack([zero, 4.0 * z, 4.0 * y], -1),
            np.stack([4.0 * z, zero, 4.0 * x], -1),
        ],
        axis=1,
    )
    jac = np.einsum("qkd,ckx->cqxd", grad, points[cells])
    det = np.linalg.det(jac)
    size = np.linalg.norm(jac, axis=2).prod(axis=2)
    return np.asarray((det / size).min(axis=1))


def face_triangles(gmsh: Any, faces: list[int]) -> tuple[Index, Index]:
    """Second-order triangles of a socket's inner faces (node tags) and the face each lies on."""
    rows, owner = [], []
    for k, f in enumerate(faces):
        types, _, nodes = gmsh.model.mesh.getElements(2, f)
        found = nodes[list(types).index(9)].astype(np.int64).reshape(-1, 6)
        rows.append(found)
        owner.append(np.full(len(found), k))
    return np.concatenate(rows), np.concatenate(owner)


def socket_coordinates(
    m: GrooveMap, spec: BodySpec, socket: tuple[float, float, int], phi: Array, z: Array, r: Array
) -> Array:
    """Local coordinates xi ``(n, 3)`` of unrolled points: gamma and azimuth in [-1, 1], depth in [0, 1]."""
    ball_phi, ball_z, side = socket
    _, _, psi0 = socket_centre(m, side)
    centre = ball_phi + psi0
    total = phi + 2.0 * np.pi * np.round((centre - phi) / (2.0 * np.pi))
    zeta = z - (ball_z - m.rg * ball_phi) - m.rg * total
    gamma, rho = m.polar(side, *m.roll(r, zeta))
    return np.stack(
        [(gamma - m.beta) / spec.size.gamma, (rho - m.radius[side]) / spec.size.depth, (total - centre) / spec.size.phi],
        axis=1,
    )
