"""A fine groove or ball patch of 27-node hexahedra, condensed once onto its socket and its contact normals.

With the freedoms of the socket's inner faces tied to the coarse trace q and unit forces f along the contact normals:
displacement of the contact nodes along their normals u_c = A f + H q, reaction on the socket r = S q - H^T f.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from hifi.elasticity import nodal_areas, stiffness
from hifi.elements import ELEMENTS
from hifi.solvers import factor
from meshes.grooved_body import SocketMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Lines:
    """Element boundaries of a patch in its local coordinates: across (gamma), depth, along (azimuth)."""

    across: Array
    depth: Array
    along: Array


@dataclass(frozen=True)
class PatchMesh:
    """Nodes ``(n, 3)`` [m], 27-node cells, nodes of the contact zone and of the interface, tie of the interface to the
    socket's nodes ``(interface nodes, socket nodes)``."""

    points: Array
    cells: Index
    contact: Index
    contact_shape: tuple[int, int]
    interface: Index
    tie: sp.csr_matrix
    areas: Array


@dataclass(frozen=True)
class CondensedPatch:
    """A ``(c, c)``, H ``(c, 3k)``, S ``(3k, 3k)`` for c contact nodes and k socket nodes; contact points and normals
    ``(c, 3)``, tributary areas ``(c,)``, unknowns and seconds it took."""

    A: Array
    H: Array
    S: Array
    points: Array
    normals: Array
    areas: Array
    shape: tuple[int, int]
    unknowns: int
    seconds: float


def graded(inner: float, step: float, count_hint: float = 1.7) -> Array:
    """Boundaries on [-1, 1]: equal steps over [-inner, inner], growing by about ``count_hint`` towards the ends."""
    cells = max(1, round(2.0 * inner / step))
    core = np.linspace(-inner, inner, cells + 1)
    return np.concatenate([-growing(inner, 1.0, 2.0 * inner / cells, count_hint)[:0:-1], core,
                           growing(inner, 1.0, 2.0 * inner / cells, count_hint)[1:]])  # fmt: skip


def growing(start: float, end: float, first: float, ratio: float) -> Array:
    """Boundaries from start to end, the first step about ``first`` times ratio, each next one larger by ``ratio``."""
    steps = [first * ratio]
    while sum(steps) < end - start:
        steps.append(steps[-1] * ratio)
    widths = np.array(steps) * (end - start) / sum(steps)
    return start + np.concatenate([[0.0], np.cumsum(widths)])


def tensor_cells(shape: tuple[int, int, int], *, mirrored: bool = False) -> Index:
    """27-node cells (gmsh order) of a node grid of odd ``shape``, nodes numbered in C order; mirrored: axis 0 turned."""
    local = np.round(ELEMENTS["Q2"].local).astype(int) + 1
    if mirrored:
        local[:, 0] = 2 - local[:, 0]
    start = np.stack(np.meshgrid(*[np.arange(0, n - 1, 2) for n in shape], indexing="ij"), -1).reshape(-1, 1, 3)
    node = start + local[None, :, :]
    return np.asarray((node[..., 0] * shape[1] + node[..., 1]) * shape[2] + node[..., 2], dtype=np.int64)


def refined(boundaries: Array) -> Array:
    """Boundaries and midpoints: the node lines of second-order elements."""
    out = np.empty(2 * boundaries.size - 1)
    out[::2] = boundaries
    out[1::2] = 0.5 * (boundaries[:-1] + boundaries[1:])
    return out


def build_patch(
    lines: Lines, zone: tuple[float, float], place: Callable[[Array], Array], socket: SocketMesh
) -> PatchMesh:
    """Patch mesh: ``place`` maps local coordinates ``(n, 3)`` to points; ``zone``: half widths of the contact zone.

    The interface nodes are put onto the socket's second-order triangles, so that rigid motions of the socket strain
    nothing. Raises ValueError where an interface node lies on no triangle.
    """
    axes = [refined(lines.across), refined(lines.depth), refined(lines.along)]
    shape = (axes[0].size, axes[1].size, axes[2].size)
    xi = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_face = (np.abs(np.abs(xi[:, 0]) - 1.0) < 1e-9) | (np.abs(np.abs(xi[:, 2]) - 1.0) < 1e-9)
    on_face |= np.abs(xi[:, 1] - 1.0) < 1e-9
    interface = np.flatnonzero(on_face)
    tie = tie_matrix(xi[interface], socket)
    points = place(xi)
    points[interface] = tie @ place(socket.xi)
    top = np.abs(xi[:, 1]) < 1e-12
    inside = (np.abs(xi[:, 0]) <= zone[0] + 1e-9) & (np.abs(xi[:, 2]) <= zone[1] + 1e-9)
    contact = np.flatnonzero(top & inside)
    counts = (int((np.abs(axes[0]) <= zone[0] + 1e-9).sum()), int((np.abs(axes[2]) <= zone[1] + 1e-9).sum()))
    cells = tensor_cells(shape)
    corner = points[[0, shape[1] * shape[2], shape[2], 1]]
    if np.linalg.det(corner[1:] - corner[0]) < 0.0:  # a left-handed map: mirror every cell
        cells = tensor_cells(shape, mirrored=True)
    local = ELEMENTS["Q2"].local
    face = np.flatnonzero(np.abs(local[:, 1] + 1.0) < 1e-9)
    quads = ELEMENTS["Q2"].face
    assert quads is not None
    order = _face_order(local[face][:, [0, 2]], ELEMENTS[quads].local)
    topmost = cells[np.abs(xi[cells[:, face[0]], 1]) < 1e-12]
    areas = nodal_areas(points, topmost[:, face[order]], quads)
    return PatchMesh(points, cells, contact, counts, interface, tie, areas[contact])


def _face_order(found: Array, wanted: Array) -> Index:
    return np.array([int(np.abs(found - w).sum(axis=1).argmin()) for w in wanted], dtype=np.int64)


def tie_matrix(xi: Array, socket: SocketMesh) -> sp.csr_matrix:
    """Interpolation of points on the socket's inner faces from its nodes, ``(n, k)``; second-order triangles."""
    planes = [(0, -1.0), (0, 1.0), (1, 1.0), (2, -1.0), (2, 1.0)]
    rows, columns, values = [], [], []
    done = np.zeros(len(xi), dtype=bool)
    for axis, value in planes:
        flat = [k for k in range(3) if k != axis]
        own = np.flatnonzero(~done & (np.abs(xi[:, axis] - value) < 1e-9))
        on_plane = np.all(np.abs(socket.xi[socket.triangles[:, :3], axis] - value) < 1e-6, axis=1)
        for tri in socket.triangles[on_plane]:
            a, b, c = socket.xi[tri[:3]][:, flat]
            t = np.linalg.solve(np.column_stack([b - a, c - a]), (xi[own][:, flat] - a).T).T
            bary = np.column_stack([1.0 - t.sum(axis=1), t])
            inside = np.flatnonzero((bary > -1e-7).all(axis=1) & ~done[own])
            w = bary[inside]
            n = np.column_stack(
                [w[:, 0] * (2 * w[:, 0] - 1), w[:, 1] * (2 * w[:, 1] - 1), w[:, 2] * (2 * w[:, 2] - 1),
                 4 * w[:, 0] * w[:, 1], 4 * w[:, 1] * w[:, 2], 4 * w[:, 2] * w[:, 0]]
            )  # fmt: skip
            rows.append(np.repeat(own[inside], 6))
            columns.append(np.tile(tri, inside.size))
            values.append(n.ravel())
            done[own[inside]] = True
    if not done.all():
        raise ValueError("a patch node lies on no triangle of its socket")
    matrix = sp.coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (len(xi), len(socket.xi))
    )
    return matrix.tocsr()


def condense_patch(mesh: PatchMesh, normals: Array, young: float, poisson: float) -> CondensedPatch:
    """Exact condensation of a patch; ``normals`` ``(c, 3)``: directions of the contact forces and displacements."""
    begin = perf_counter()
    K = stiffness(mesh.points, mesh.cells, "Q2", young, poisson)
    n = mesh.points.shape[0]
    held = np.zeros(n, dtype=bool)
    held[mesh.interface] = True
    inner = np.flatnonzero(np.repeat(~held, 3))
    outer = (3 * mesh.interface[:, None] + np.arange(3)).ravel()
    position = np.full(3 * n, -1, dtype=np.int64)
    position[inner] = np.arange(inner.size)
    free = ~held[mesh.contact]
    contact = mesh.contact[free]
    rows = position[(3 * contact[:, None] + np.arange(3)).ravel()]
    P = sp.csc_matrix(
        (normals[free].ravel(), (rows, np.repeat(np.arange(contact.size), 3))), (inner.size, contact.size)
    )
    T = sp.kron(mesh.tie, sp.identity(3), format="csc")
    K_ii = K[inner][:, inner].tocsc()
    coupling = (K[inner][:, outer] @ T).tocsc()
    boundary = (T.T @ (K[outer][:, outer] @ T)).toarray()
    solver = factor(K_ii)
    X = solver.solve(np.hstack([P.toarray(), coupling.toarray()]))
    c = contact.size
    A = P.T @ X[:, :c]
    H = -(P.T @ X[:, c:])
    S = boundary - coupling.T @ X[:, c:]
    return CondensedPatch(
        A=0.5 * (A + A.T), H=H, S=0.5 * (S + S.T), points=mesh.points[contact], normals=normals[free],
        areas=mesh.areas[free], shape=mesh.contact_shape, unknowns=int(inner.size), seconds=perf_counter() - begin,
    )  # fmt: skip
