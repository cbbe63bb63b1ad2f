"""Meshes of the parts in scikit-fem: made from arrays in gmsh's node order and read back, with named boundaries; quality.

P1, P2 tetrahedra and Q1, Q2 hexahedra are MeshTet1, MeshTet2, MeshHex1 and MeshHex2; those of second order map with their
curved cells. Boundaries go by name in ``mesh.boundaries``. Degree of freedom 3 * node + component of the vector space on
a mesh's element belongs to the node ``mesh.doflocs[:, node]``.

Quality is the scaled Jacobian of curved cells, and the distance of nodes from the exact surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from skfem import ElementVector, Mesh, MeshHex1, MeshHex2, MeshTet1, MeshTet2
from skfem.assembly import Dofs
from skfem.element import Element

from rollbench.meshes.arrays import Array, Index

MESHES: dict[str, Any] = {"P1": MeshTet1, "P2": MeshTet2, "Q1": MeshHex1, "Q2": MeshHex2}

# Place k of scikit-fem's cell holds gmsh's local node; by matching coordinates (see the tests).
_SKFEM: dict[str, tuple[int, ...]] = {
    "P1": tuple(range(4)),
    "P2": (0, 1, 2, 3, 4, 5, 6, 7, 9, 8),
    "Q1": (6, 2, 5, 7, 1, 3, 4, 0),
    "Q2": (6, 2, 5, 7, 1, 3, 4, 0, 14, 18, 19, 11, 13, 12, 16, 15, 17, 8, 9, 10, 23, 25, 24, 21, 20, 22, 26),
}


def mesh_of(points: Array, cells: Index, kind: str, boundaries: Mapping[str, Index] | None = None) -> tuple[Mesh, Index]:
    """Mesh of points and cells in gmsh's node order.

    scikit-fem renumbers the nodes of second-order meshes, vertices first.

    Parameters
    ----------
    points : (n, 3) Array
        Nodes [m].
    cells : (m, nodes) Index
        Nodes of the cells, in gmsh's order.
    kind : str
        P1, P2, Q1 or Q2.
    boundaries : dict of (k, 3 or more) Index, optional, default None
        Faces by name, their corners first.

    Returns
    -------
    mesh : Mesh
        The mesh, boundaries named.
    number : (n,) Index
        New number of every point; -1 for points of no cell.

    Raises
    ------
    ValueError
        Unknown kind, cells of another kind, or a boundary with a face that no cell has.
    """
    if kind not in MESHES:
        raise ValueError(f"element {kind!r} is unknown; one of {', '.join(MESHES)}")
    order = np.array(_SKFEM[kind])
    if cells.ndim != 2 or cells.shape[1] != len(order):
        raise ValueError(f"cells have shape {cells.shape}, element {kind} needs (m, {len(order)})")
    ordered = cells[:, order]
    mesh = MESHES[kind](np.ascontiguousarray(points.T), np.ascontiguousarray(ordered.T))
    number = np.full(len(points), -1, dtype=np.int64)
    number[ordered] = mesh.dofs.element_dofs.T
    return with_faces(mesh, {name: number[f[:, : len(mesh.facets)]] for name, f in (boundaries or {}).items()}), number


def with_faces(mesh: Mesh, faces: Mapping[str, Index]) -> Mesh:
    """Add boundaries to a mesh, given by the corners of their faces.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    faces : dict of (k, 3 or 4) Index
        Corners of the faces by name, in any order.

    Returns
    -------
    Mesh
        Copy with these boundaries added.

    Raises
    ------
    ValueError
        A boundary has a face that no cell has, or none at all.
    """
    count = mesh.doflocs.shape[1]
    known = _facet_keys(np.sort(mesh.facets.T), count)
    order = np.argsort(known)
    facets = {}
    for name, corners in faces.items():
        wanted = _facet_keys(np.sort(corners), count)
        place = order[np.minimum(np.searchsorted(known, wanted, sorter=order), len(order) - 1)]
        lost = int(np.count_nonzero(known[place] != wanted))
        if lost:
            raise ValueError(f"boundary {name!r} lost: {lost} of {len(wanted)} faces belong to no cell")
        facets[name] = np.unique(place)
    return with_boundaries(mesh, facets)


def with_boundaries(mesh: Mesh, facets: Mapping[str, Index]) -> Mesh:
    """Add boundaries to a mesh, given by the numbers of their facets.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    facets : dict of (k,) Index
        Facets by name.

    Returns
    -------
    Mesh
        Copy with these boundaries added.

    Raises
    ------
    ValueError
        A boundary is empty.
    """
    for name, numbers in facets.items():
        if not len(numbers):
            raise ValueError(f"boundary {name!r} is empty")
    added = {name: np.asarray(numbers, dtype=np.int32) for name, numbers in facets.items()}
    return _with_attributes(mesh, _boundaries={**(mesh.boundaries or {}), **added})


def _facet_keys(corners: Index, count: int) -> Index:
    """Key each edge or face by its ascending corners ``(k, 2 or more)``; keys sort like the corners.

    Three corners identify a face of a mesh.
    """
    if count >= 2**21:
        raise ValueError(f"{count} points: face keys hold fewer than {2**21}")
    low = corners[:, :3].astype(np.int64)
    return np.asarray(low @ count ** np.arange(low.shape[1] - 1, -1, -1))


def kind_of(mesh: Mesh) -> str:
    """Kind of a mesh's cells: P1, P2, Q1 or Q2.

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return next(kind for kind, mesh_class in MESHES.items() if mesh.elem is mesh_class.elem)


def points_of(mesh: Mesh) -> Array:
    """Nodes of a mesh ``(n, 3)`` [m].

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return np.asarray(mesh.doflocs.T)


def cells_of(mesh: Mesh) -> Index:
    """Nodes of a mesh's cells ``(m, nodes)``, in gmsh's order.

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return np.asarray(mesh.dofs.element_dofs.T[:, np.argsort(_SKFEM[kind_of(mesh)])], dtype=np.int64)


class Meshed:
    """Base of records that hold the mesh of a body."""

    #: The mesh, as scikit-fem has it.
    mesh: Mesh

    @property
    def points(self) -> Array:
        """Nodes ``(n, 3)`` [m]."""
        return points_of(self.mesh)

    @property
    def cells(self) -> Index:
        """Nodes of the cells ``(m, nodes)``, in gmsh's order."""
        return cells_of(self.mesh)


def faces_of(mesh: Mesh, name: str) -> Index:
    """Nodes of a boundary's faces.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    name : str
        Boundary.

    Returns
    -------
    (k, nodes of a face) Index
        Corners counter-clockwise seen from outside, then the middles of the edges from each corner to the next, then
        the middle of the face.
    """
    facets = mesh.boundaries[name]
    corners = mesh.facets[:, facets]
    parts = [corners]
    if len(mesh.dofs.edge_dofs):
        parts.append(mesh.dofs.edge_dofs[0, mesh.f2e[:, facets]])
    if len(mesh.dofs.facet_dofs):
        parts.append(mesh.dofs.facet_dofs[:, facets])
    faces = np.vstack(parts).T.astype(np.int64)
    x, cell = mesh.doflocs[:, corners], mesh.doflocs[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1)
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], axis=0)
    inward = (normal * (x.mean(axis=1) - cell)).sum(axis=0) < 0.0
    n = len(corners)
    back = [0, *range(n - 1, 0, -1), *range(2 * n - 1, n - 1, -1), 2 * n][: faces.shape[1]]
    faces[inward] = faces[inward][:, back]
    return faces


def nodes_on(mesh: Mesh, *names: str) -> Index:
    """Nodes of named boundaries, ascending.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    *names : str
        Boundaries.

    Returns
    -------
    (k,) Index
        Nodes.
    """
    return _freedoms_of_boundary(mesh.dofs, mesh, names)


def freedoms_on(mesh: Mesh, *names: str) -> Index:
    """Degrees of freedom of the vector space on named boundaries, ascending.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    *names : str
        Boundaries.

    Returns
    -------
    (k,) Index
        Degrees of freedom 3 * node + component.
    """
    return _freedoms_of_boundary(Dofs(mesh, ElementVector(mesh.elem())), mesh, names)


def _freedoms_of_boundary(dofs: Dofs, mesh: Mesh, names: tuple[str, ...]) -> Index:
    freedoms = [dofs.get_facet_dofs(mesh.boundaries[name]).flatten() for name in names]
    return np.unique(np.concatenate(freedoms)).astype(np.int64)


def tensor_grid(x: Array, y: Array, z: Array, kind: str, *, left_handed: bool = False) -> Mesh:
    """Hexahedra between the grid lines of three axes.

    Parameters
    ----------
    x, y, z : Array
        Ascending coordinates of the corners [m].
    kind : str
        Q1 or Q2.
    left_handed : bool, default False
        Number cells for a map that mirrors them.

    Returns
    -------
    Mesh
        The mesh.
    """
    mirrored = MeshHex1.init_tensor(x, y, z)  # left-handed
    grid = MeshHex1(mirrored.doflocs, mirrored.t if left_handed else mirrored.t[[3, 5, 6, 0, 7, 1, 2, 4]])
    return grid if kind == "Q1" else second_order(grid)


def second_order(mesh: Mesh) -> Mesh:
    """Make straight second-order cells of a mesh, on the same vertices; boundaries are lost.

    Parameters
    ----------
    mesh : Mesh
        P1 or Q1 cells.

    Returns
    -------
    Mesh
        P2 or Q2 cells.
    """
    quadratic = MESHES[{"P1": "P2", "Q1": "Q2"}[kind_of(mesh)]].from_mesh(mesh)
    known = {name: value for name, value in vars(mesh).items() if name in ("_facets", "_t2f", "_f2t", "_edges", "_t2e")}
    return _with_attributes(quadratic, **known)


def with_points(mesh: Mesh, points: Array) -> Mesh:
    """Put the nodes of a mesh at other points; boundaries are kept.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    points : (n, 3) Array
        New nodes [m].

    Returns
    -------
    Mesh
        Copy with these nodes.
    """
    return _with_attributes(mesh, doflocs=np.ascontiguousarray(points.T))


def _with_attributes(mesh: Mesh, **fields: Any) -> Mesh:
    """Copy of a mesh with other attributes and unchanged cells, so that edges and faces keep their numbers."""
    changed = copy(mesh)
    for name in ("_cached_mapping", "_cached_tree"):
        changed.__dict__.pop(name, None)
    changed.__dict__.update(fields)
    return changed


#: Cells measured at once.
CHUNK = 8192


@dataclass(frozen=True)
class Quality:
    """Size and quality of a mesh."""

    #: Number of cells.
    cells: int
    #: Number of nodes.
    nodes: int
    #: Smallest scaled Jacobian.
    smallest: float
    #: Median of the cells' smallest scaled Jacobians.
    median: float
    #: Number of the worst cell.
    worst: int
    #: Centre of the worst cell [m].
    where: tuple[float, float, float]


def node_slopes(element: Element, at: Array | None = None) -> Array:
    """Gradients of an element's shape functions at its nodes, or at other places, in the reference cell.

    Parameters
    ----------
    element : Element
        The element.
    at : (3, q) Array or None, default None
        The places; None: the nodes.

    Returns
    -------
    (q, n, 3) Array
        At place q, of shape function n.
    """
    nodes = element.doflocs.T
    at = nodes if at is None else at
    return np.stack([element.lbasis(at, k)[1] for k in range(nodes.shape[1])], axis=1).transpose(2, 1, 0)


def scaled_jacobians(mesh: Mesh) -> Array:
    """Smallest scaled Jacobian of every cell over its nodes; 1 for the regular tetrahedron and the cube.

    Hexahedra: det J over the product of the lengths of its columns. Tetrahedra: sqrt(2) det J over the largest product of
    the three edges that meet in a corner, J taken as that of a straight tetrahedron. Curved cells count as they are,
    where pyvista's cell quality sees only their corners.

    Returns
    -------
    (m,) Array
        One value for each cell.

    References
    ----------
    Stimpson et al. (2007), The Verdict Library Reference Manual, SAND2007-1751.

    Examples
    --------
    >>> edge = np.array([0.0, 1.0])
    >>> scaled_jacobians(tensor_grid(edge, edge, edge, "Q1")).round(12).tolist()
    [1.0]
    """
    return _of_cells(mesh, mesh.dofs.element_dofs.T)


def _of_cells(mesh: Mesh, cells: Index, at: Array | None = None) -> Array:
    """Smallest scaled Jacobian ``(c,)`` of some cells ``(c, nodes)`` of a mesh at their nodes, or ``at`` other places."""
    points, table = mesh.doflocs.T, node_slopes(mesh.elem(), at)
    result = np.empty(len(cells))
    for k in range(0, len(cells), CHUNK):
        result[k : k + CHUNK] = _smallest_scaled_jacobians(points[cells[k : k + CHUNK]], table).min(axis=1)
    return result


def _smallest_scaled_jacobians(x: Array, table: Array) -> Array:
    """Scaled Jacobians of cells at given nodes.

    Parameters
    ----------
    x : (m, n, 3) Array
        Nodes of the cells [m].
    table : (q, n, 3) Array
        Reference gradients of the shape functions at q places.

    Returns
    -------
    (m, q) Array
        Scaled Jacobian of each cell at each place.
    """
    u, v, w = np.einsum("cnx,qnd->dcqx", x, table, optimize=["einsum_path", (0, 1)])
    normal = np.stack([u[..., i] * v[..., j] - u[..., j] * v[..., i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    det = np.einsum("cqx,cqx->cq", normal, w)
    if x.shape[1] in (8, 27):
        size = np.sqrt(np.prod([np.einsum("cqx,cqx->cq", a, a) for a in (u, v, w)], axis=0))
    else:
        a, b, c, d, e, f = (np.einsum("cqx,cqx->cq", t, t) for t in (u, v, w, v - u, w - u, w - v))
        size = np.sqrt(0.5 * np.max([a * b * c, a * d * e, b * d * f, c * e * f], axis=0))
    return np.asarray(det / np.maximum(size, np.finfo(float).tiny))


def measure_quality(mesh: Mesh) -> Quality:
    """Size and quality of a mesh."""
    jacobians = scaled_jacobians(mesh)
    worst = int(jacobians.argmin())
    x, y, z = mesh.doflocs[:, mesh.dofs.element_dofs[:, worst]].mean(axis=1)
    return Quality(
        mesh.nelements,
        mesh.doflocs.shape[1],
        float(jacobians[worst]),
        float(np.median(jacobians)),
        worst,
        (float(x), float(y), float(z)),
    )


def refuse_bad(quality: Quality, name: str) -> None:
    """Raise ValueError where the worst cell of a mesh is turned inside out.

    Parameters
    ----------
    quality : Quality
        Quality of the mesh.
    name : str
        Body, for the message.
    """
    if quality.smallest > 0.0:
        return
    r, z = np.hypot(*quality.where[:2]), quality.where[2]
    raise ValueError(
        f"mesh of the {name}: cell {quality.worst} of {quality.cells} at r = {1e3 * r:.4g} mm, z = {1e3 * z:.4g} mm is "
        f"turned inside out (scaled Jacobian {quality.smallest:.2g}, must exceed 0): choose smaller element sizes"
    )


#: Places inside a tetrahedron, in reference coordinates ``(3, 8)``: a curved cell that is good at its nodes may be turned
#: inside out there, where stiffnesses are integrated (`hifi.elements.forms.rule`).
INSIDE = np.hstack(
    [np.hstack([np.full((3, 1), a), a + (1.0 - 4.0 * a) * np.eye(3)]) for a in (0.1080472498984286, 0.3281633025163817)]
)

#: Scaled Jacobian below which a curved cell is untangled, and below which its edges are straightened, though the surface
#: becomes less exact.
BENT, STRAIGHTENED = 0.05, 0.01


def untangle(mesh: Mesh, surface: Index, at: Array | None = None) -> Mesh:
    """Move inner mid-edge nodes of badly curved P2 tetrahedra until the cells are better.

    A curved edge of the surface may cut into its cell; the inner edges of that cell are then curved too. One node after
    the other moves to the place where the worst cell around it is best, out of steps in 26 directions that shrink.

    Parameters
    ----------
    mesh : Mesh
        Second-order tetrahedra.
    surface : Index
        Nodes that stay.
    at : (3, q) Array or None, default None
        Places of a cell, in reference coordinates, where it is judged; None: its nodes.

    Returns
    -------
    Mesh
        Copy with moved nodes.
    """
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.zeros(len(points), dtype=bool)
    free[cells[:, 4:]] = True
    free[surface] = False
    table = node_slopes(mesh.elem(), at)
    steps = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    size = 0.2
    near = cells
    for _ in range(12):
        bad = near[_of_cells(with_points(mesh, points), near, at) < BENT]
        node = np.unique(bad[:, 4:])
        node = node[free[node]]
        if not len(node):
            break
        near = cells[np.isin(cells[:, 4:], node).any(axis=1)]
        for n in node:
            ring = near[(near == n).any(axis=1)]
            x = points[ring]
            length = size * np.linalg.norm(x[:, 1] - x[:, 0], axis=1).min()
            trial = np.repeat(x[None], len(steps), axis=0)
            trial[:, ring == n] = (points[n] + length * steps)[:, None]
            worst = (
                _smallest_scaled_jacobians(trial.reshape(-1, 10, 3), table).min(axis=1).reshape(len(steps), -1).min(axis=1)
            )
            if worst.max() > worst[13] + 1e-12:  # 13: no step
                points[n] = points[n] + length * steps[int(worst.argmax())]
        size *= 0.8
    return with_points(mesh, points)


def straighten(mesh: Mesh, keep: Index, at: Array | None = None) -> tuple[Mesh, int]:
    """Straighten the edges of badly curved P2 tetrahedra.

    Parameters
    ----------
    mesh : Mesh
        Second-order tetrahedra.
    keep : Index
        Nodes that stay.
    at : (3, q) Array or None, default None
        Places of a cell, in reference coordinates, where it is judged; None: its nodes.

    Returns
    -------
    mesh : Mesh
        Copy with straightened edges.
    moved : int
        Number of nodes that moved.
    """
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.ones(len(points), dtype=bool)
    free[keep.ravel()] = False
    changed = np.zeros_like(free)
    near = cells
    for _ in range(8):
        bad = near[_of_cells(with_points(mesh, points), near, at) < STRAIGHTENED]
        before = int(changed.sum())
        for k, (i, j) in enumerate(mesh.refdom.edges):
            middle = 0.5 * (points[bad[:, i]] + points[bad[:, j]])
            node = bad[:, 4 + k]
            move = free[node] & (np.abs(points[node] - middle).max(axis=1, initial=0.0) > 0.0)
            points[node[move]] = middle[move]
            changed[node[move]] = True
        if int(changed.sum()) == before:
            break
        near = cells[changed[cells].any(axis=1)]
    return with_points(mesh, points), int(changed.sum())


def improve_cells(mesh: Mesh, name: str, surface: Index, keep: Index) -> tuple[Mesh, int, Quality]:
    """Improve the cells of a body's mesh: `untangle`, then `straighten`.

    Parameters
    ----------
    mesh : Mesh
        Second-order tetrahedra.
    name : str
        Body, for the message.
    surface : Index
        Nodes that stay in the first step.
    keep : Index
        Nodes that stay in the second step, in which other nodes of the surface may leave it.

    Returns
    -------
    mesh : Mesh
        Improved mesh.
    moved : int
        Number of nodes that the second step moved.
    quality : Quality
        Its quality.

    Raises
    ------
    ValueError
        A cell remains turned inside out.
    """
    found, straight = straighten(untangle(mesh, surface), keep)
    if (_of_cells(found, found.dofs.element_dofs.T, INSIDE) <= 0.0).any():
        everywhere = np.hstack([mesh.elem.doflocs.T, INSIDE])
        found, straight = straighten(untangle(mesh, surface, everywhere), keep, everywhere)
    mesh, quality = found, measure_quality(found)
    refuse_bad(quality, name)
    return mesh, straight, quality


def arc_deviation(x3: Array, z3: Array, centre: Array, radius: float) -> float:
    """Largest distance of section points from a groove's circle.

    Parameters
    ----------
    x3, z3 : Array
        Section coordinates of the points [m].
    centre : (2,) Array
        Centre of the arc [m].
    radius : float
        Radius of the arc [m].

    Returns
    -------
    float
        [m]; 0 without points.

    Examples
    --------
    >>> arc_deviation(np.array([3.0, 0.0]), np.array([0.0, 3.5]), np.zeros(2), 3.0)
    0.5
    """
    return float(np.abs(np.hypot(x3 - centre[0], z3 - centre[1]) - radius).max(initial=0.0))
