"""Finite element meshes as objects of scikit-fem: built from arrays in gmsh's node order; named boundaries; mesh quality.

P1, P2 tetrahedra and Q1, Q2 hexahedra are MeshTet1, MeshTet2, MeshHex1 and MeshHex2; second-order cells are curved.
Boundaries have names, in ``mesh.boundaries``. In the vector space on a mesh's element, the degree of freedom
3 * node + component belongs to the node ``mesh.doflocs[:, node]``.

Two measures of quality: the scaled Jacobian of the curved cells, and the distance of nodes from the exact surface.
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

#: Mesh class of scikit-fem for each element type.
MESHES: dict[str, Any] = {"P1": MeshTet1, "P2": MeshTet2, "Q1": MeshHex1, "Q2": MeshHex2}

# Number, in gmsh's cell, of the node that is node k of scikit-fem's cell; found by comparing coordinates (see the tests).
_SKFEM: dict[str, tuple[int, ...]] = {
    "P1": tuple(range(4)),
    "P2": (0, 1, 2, 3, 4, 5, 6, 7, 9, 8),
    "Q1": (6, 2, 5, 7, 1, 3, 4, 0),
    "Q2": (6, 2, 5, 7, 1, 3, 4, 0, 14, 18, 19, 11, 13, 12, 16, 15, 17, 8, 9, 10, 23, 25, 24, 21, 20, 22, 26),
}


def build_mesh(
    points: Array, cells: Index, element_type: str, boundaries: Mapping[str, Index] | None = None
) -> tuple[Mesh, Index]:
    """Build a mesh of scikit-fem from points and cells in gmsh's node order.

    scikit-fem renumbers the nodes of second-order meshes: vertices come first.

    Parameters
    ----------
    points : (n, 3) Array
        Coordinates of the nodes [m].
    cells : (m, nodes) Index
        Nodes of each cell, in gmsh's order.
    element_type : str
        Type of the element: P1, P2, Q1 or Q2.
    boundaries : dict of (k, 3 or more) Index, optional, default None
        For the name of each boundary, the nodes of its k faces, as indices into ``points``; corners come first in a row.

    Returns
    -------
    mesh : Mesh
        The mesh with its named boundaries.
    number : (n,) Index
        Number of each point as a node of the mesh; -1 for points that belong to no cell.

    Raises
    ------
    ValueError
        The type is unknown, the cells have another number of nodes, or a face of a boundary belongs to no cell.
    """
    if element_type not in MESHES:
        raise ValueError(f"element type {element_type!r} is unknown; use one of {', '.join(MESHES)}")
    order = np.array(_SKFEM[element_type])
    if cells.ndim != 2 or cells.shape[1] != len(order):
        raise ValueError(
            f"the array of cells has the shape {cells.shape}, but element type {element_type} needs (m, {len(order)})"
        )
    ordered = cells[:, order]
    mesh = MESHES[element_type](np.ascontiguousarray(points.T), np.ascontiguousarray(ordered.T))
    number = np.full(len(points), -1, dtype=np.int64)
    number[ordered] = mesh.dofs.element_dofs.T
    corners = {name: number[f[:, : len(mesh.facets)]] for name, f in (boundaries or {}).items()}
    return with_boundaries_from_corners(mesh, corners), number


def with_boundaries_from_corners(mesh: Mesh, faces: Mapping[str, Index]) -> Mesh:
    """Add named boundaries to a mesh, each defined by the corner nodes of its faces.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    faces : dict of (k, 3 or 4) Index
        For the name of each boundary, the corner nodes of its k faces; the corners of a face are in any order.

    Returns
    -------
    Mesh
        Copy of the mesh with these boundaries added.

    Raises
    ------
    ValueError
        A face belongs to no cell, or a boundary has no faces.
    """
    count = mesh.doflocs.shape[1]
    known = _identifying_integers_of_faces(np.sort(mesh.facets.T), count)
    order = np.argsort(known)
    facets = {}
    for name, corners in faces.items():
        wanted = _identifying_integers_of_faces(np.sort(corners), count)
        place = order[np.minimum(np.searchsorted(known, wanted, sorter=order), len(order) - 1)]
        lost = int(np.count_nonzero(known[place] != wanted))
        if lost:
            raise ValueError(f"boundary {name!r} is incomplete: {lost} of its {len(wanted)} faces belong to no cell")
        facets[name] = np.unique(place)
    return with_boundaries_from_facets(mesh, facets)


def with_boundaries_from_facets(mesh: Mesh, facets: Mapping[str, Index]) -> Mesh:
    """Add named boundaries to a mesh, each defined by the numbers of its facets (faces of cells) in the mesh.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    facets : dict of (k,) Index
        For the name of each boundary, the numbers of its facets.

    Returns
    -------
    Mesh
        Copy of the mesh with these boundaries added.

    Raises
    ------
    ValueError
        A boundary has no facets.
    """
    for name, numbers in facets.items():
        if not len(numbers):
            raise ValueError(f"boundary {name!r} is empty: it has no facets")
    added = {name: np.asarray(numbers, dtype=np.int32) for name, numbers in facets.items()}
    return _mesh_with_attributes(mesh, _boundaries={**(mesh.boundaries or {}), **added})


def _identifying_integers_of_faces(corners: Index, count: int) -> Index:
    """Compute an integer that identifies each edge or face of a mesh by its corners ``(k,)``, for sorting and searching.

    ``corners``: numbers of the corners, ascending in each row ``(k, 2 or more)``; ``count``: number of nodes of the mesh.
    The integers sort like the rows of corners. Of a face with four corners only three are used, which identify it.
    """
    if count >= 2**21:
        raise ValueError(f"the mesh has {count} nodes; faces can be identified only in meshes of fewer than {2**21} nodes")
    low = corners[:, :3].astype(np.int64)
    return np.asarray(low @ count ** np.arange(low.shape[1] - 1, -1, -1))


def element_type_of_mesh(mesh: Mesh) -> str:
    """Return the element type of a mesh: P1, P2, Q1 or Q2.

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return next(kind for kind, mesh_class in MESHES.items() if mesh.elem is mesh_class.elem)


def node_coordinates(mesh: Mesh) -> Array:
    """Return the coordinates of a mesh's nodes ``(n, 3)`` [m].

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return np.asarray(mesh.doflocs.T)


def nodes_of_cells(mesh: Mesh) -> Index:
    """Return the nodes of each cell of a mesh ``(m, nodes)``, in gmsh's order.

    Parameters
    ----------
    mesh
        Mesh of scikit-fem.
    """
    return np.asarray(mesh.dofs.element_dofs.T[:, np.argsort(_SKFEM[element_type_of_mesh(mesh)])], dtype=np.int64)


@dataclass(frozen=True)
class MeshedBody:
    """Base class of records that contain the finite element mesh of a body."""

    #: The mesh, an object of scikit-fem.
    mesh: Mesh

    @property
    def points(self) -> Array:
        """Coordinates of the mesh's nodes ``(n, 3)`` [m]."""
        return node_coordinates(self.mesh)

    @property
    def cells(self) -> Index:
        """Nodes of each cell of the mesh ``(m, nodes)``, in gmsh's order."""
        return nodes_of_cells(self.mesh)


def nodes_of_boundary_faces(mesh: Mesh, name: str) -> Index:
    """Return the nodes of each face on a named boundary of a mesh.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    name : str
        Name of the boundary.

    Returns
    -------
    (k, nodes of a face) Index
        Nodes of each face: its corners, counter-clockwise seen from outside; then the midside nodes, the first one between
        the first and second corner; then the node at the face's centre. Linear elements have only corners.
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


def nodes_on_boundaries(mesh: Mesh, *names: str) -> Index:
    """Return the nodes on named boundaries of a mesh, in ascending order.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    *names : str
        Names of the boundaries.

    Returns
    -------
    (k,) Index
        Numbers of the nodes.
    """
    return _degrees_of_freedom_of_boundaries(mesh.dofs, mesh, names)


def degrees_of_freedom_on_boundaries(mesh: Mesh, *names: str) -> Index:
    """Return the displacement degrees of freedom of the nodes on named boundaries, in ascending order.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    *names : str
        Names of the boundaries.

    Returns
    -------
    (k,) Index
        Numbers 3 * node + component of the degrees of freedom.
    """
    return _degrees_of_freedom_of_boundaries(Dofs(mesh, ElementVector(mesh.elem())), mesh, names)


def _degrees_of_freedom_of_boundaries(dofs: Dofs, mesh: Mesh, names: tuple[str, ...]) -> Index:
    """Return the numbers of the degrees of freedom on the boundaries ``names`` of a mesh, in ascending order ``(k,)``.

    ``dofs``: numbering of the degrees of freedom by scikit-fem, of a scalar or of a vector field on the mesh.
    """
    freedoms = [dofs.get_facet_dofs(mesh.boundaries[name]).flatten() for name in names]
    return np.unique(np.concatenate(freedoms)).astype(np.int64)


def mesh_rectangular_grid(x: Array, y: Array, z: Array, element_type: str, *, left_handed: bool = False) -> Mesh:
    """Make a mesh of hexahedra on a rectangular grid, from its grid coordinates along three axes.

    Parameters
    ----------
    x, y, z : Array
        Ascending coordinates of the grid planes [m].
    element_type : str
        Type of the element: Q1 or Q2.
    left_handed : bool, default False
        Whether the nodes of each cell are in a left-handed order, for a mesh whose nodes are mirrored afterwards.

    Returns
    -------
    Mesh
        The mesh of hexahedra.
    """
    mirrored = MeshHex1.init_tensor(x, y, z)  # left-handed
    grid = MeshHex1(mirrored.doflocs, mirrored.t if left_handed else mirrored.t[[3, 5, 6, 0, 7, 1, 2, 4]])
    return grid if element_type == "Q1" else to_second_order_mesh(grid)


def to_second_order_mesh(mesh: Mesh) -> Mesh:
    """Convert a mesh of linear cells to second-order cells with the same vertices and straight edges.

    Named boundaries are not copied.

    Parameters
    ----------
    mesh : Mesh
        Mesh of P1 or Q1 cells.

    Returns
    -------
    Mesh
        Mesh of P2 or Q2 cells.
    """
    quadratic = MESHES[{"P1": "P2", "Q1": "Q2"}[element_type_of_mesh(mesh)]].from_mesh(mesh)
    known = {name: value for name, value in vars(mesh).items() if name in ("_facets", "_t2f", "_f2t", "_edges", "_t2e")}
    return _mesh_with_attributes(quadratic, **known)


def with_node_coordinates(mesh: Mesh, points: Array) -> Mesh:
    """Return a copy of a mesh with other coordinates of its nodes, and the same cells and boundaries.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    points : (n, 3) Array
        New coordinates of all nodes [m].

    Returns
    -------
    Mesh
        Copy of the mesh with these coordinates.
    """
    return _mesh_with_attributes(mesh, doflocs=np.ascontiguousarray(points.T))


def _mesh_with_attributes(mesh: Mesh, **fields: Any) -> Mesh:
    """Return a copy of a mesh of scikit-fem in which the attributes ``fields`` have new values; cells are unchanged."""
    changed = copy(mesh)
    for name in ("_cached_mapping", "_cached_tree"):
        changed.__dict__.pop(name, None)
    changed.__dict__.update(fields)
    return changed


#: Number of cells whose scaled Jacobians are computed at once.
CHUNK = 8192


@dataclass(frozen=True)
class MeshQuality:
    """Size and quality of a mesh: numbers of cells and nodes, and smallest scaled Jacobian of the cells."""

    #: Number of cells of the mesh.
    cell_count: int
    #: Number of nodes of the mesh.
    node_count: int
    #: Smallest scaled Jacobian of all cells.
    smallest_jacobian: float
    #: Number of the cell with the smallest scaled Jacobian.
    worst_cell: int
    #: Coordinates of the centre of the cell `worst_cell` [m].
    worst_cell_centre: tuple[float, float, float]


def shape_function_gradients(element: Element, reference_points: Array | None = None) -> Array:
    """Return the gradients of an element's shape functions at its nodes, or at other points of the reference cell.

    Parameters
    ----------
    element : Element
        Element type of scikit-fem.
    reference_points : (3, q) Array or None, default None
        Reference coordinates of the points; None for the element's nodes.

    Returns
    -------
    (q, n, 3) Array
        Gradient in reference coordinates of each of the n shape functions at each of the q points.
    """
    nodes = element.doflocs.T
    reference_points = nodes if reference_points is None else reference_points
    return np.stack([element.lbasis(reference_points, k)[1] for k in range(nodes.shape[1])], axis=1).transpose(2, 1, 0)


def scaled_jacobians(mesh: Mesh) -> Array:
    """Return, for each cell, the smallest scaled Jacobian at its nodes; 1 for the regular tetrahedron and the cube.

    For hexahedra it is det J divided by the product of the lengths of J's columns. For tetrahedra it is sqrt(2) det J
    divided by the largest product of three edges that meet in a corner; these edges are those of the straight tetrahedron
    with the same J. The curvature of second-order cells is included, which pyvista's cell quality ignores.

    Parameters
    ----------
    mesh : Mesh
        The mesh, of tetrahedra or hexahedra.

    Returns
    -------
    (m,) Array
        Smallest scaled Jacobian of each cell.

    References
    ----------
    Stimpson et al. (2007), The Verdict Library Reference Manual, SAND2007-1751.

    Examples
    --------
    >>> edge = np.array([0.0, 1.0])
    >>> scaled_jacobians(mesh_rectangular_grid(edge, edge, edge, "Q1")).round(12).tolist()
    [1.0]
    """
    return _smallest_jacobian_of_cells(mesh, mesh.dofs.element_dofs.T)


def _smallest_jacobian_of_cells(mesh: Mesh, cells: Index, at: Array | None = None) -> Array:
    """Return, for each of the given cells of a mesh, the smallest scaled Jacobian at some points ``(c,)``.

    ``cells``: nodes of the cells ``(c, nodes)``; ``at``: reference coordinates ``(3, q)`` of the points at which it is
    evaluated, None for the cells' nodes.
    """
    points, table = mesh.doflocs.T, shape_function_gradients(mesh.elem(), at)
    result = np.empty(len(cells))
    for k in range(0, len(cells), CHUNK):
        result[k : k + CHUNK] = _scaled_jacobians_at_points(points[cells[k : k + CHUNK]], table).min(axis=1)
    return result


def _scaled_jacobians_at_points(x: Array, gradients: Array) -> Array:
    """Return the scaled Jacobians of m cells at q points of the reference cell.

    Parameters
    ----------
    x : (m, n, 3) Array
        Coordinates of the n nodes of each cell [m].
    gradients : (q, n, 3) Array
        Gradients of the shape functions in reference coordinates, at the q points.

    Returns
    -------
    (m, q) Array
        Scaled Jacobian of each cell at each point.
    """
    u, v, w = np.einsum("cnx,qnd->dcqx", x, gradients, optimize=["einsum_path", (0, 1)])
    normal = np.stack([u[..., i] * v[..., j] - u[..., j] * v[..., i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    det = np.einsum("cqx,cqx->cq", normal, w)
    if x.shape[1] in (8, 27):
        size = np.sqrt(np.prod([np.einsum("cqx,cqx->cq", a, a) for a in (u, v, w)], axis=0))
    else:
        a, b, c, d, e, f = (np.einsum("cqx,cqx->cq", t, t) for t in (u, v, w, v - u, w - u, w - v))
        size = np.sqrt(0.5 * np.max([a * b * c, a * d * e, b * d * f, c * e * f], axis=0))
    return np.asarray(det / np.maximum(size, np.finfo(float).tiny))


def mesh_quality(mesh: Mesh) -> MeshQuality:
    """Return the quality of a mesh, from the smallest scaled Jacobian of each cell (`scaled_jacobians`)."""
    jacobians = scaled_jacobians(mesh)
    worst = int(jacobians.argmin())
    x, y, z = mesh.doflocs[:, mesh.dofs.element_dofs[:, worst]].mean(axis=1)
    centre = float(x), float(y), float(z)
    return MeshQuality(mesh.nelements, mesh.doflocs.shape[1], float(jacobians[worst]), worst, centre)


def check_no_inverted_cells(quality: MeshQuality, body_name: str) -> None:
    """Raise ValueError if a mesh has an inverted cell, that is, a cell whose scaled Jacobian is not positive.

    Parameters
    ----------
    quality : MeshQuality
        Quality of the mesh.
    body_name : str
        Name of the meshed body, for the message.
    """
    if quality.smallest_jacobian > 0.0:
        return
    r, z = np.hypot(*quality.worst_cell_centre[:2]), quality.worst_cell_centre[2]
    place = f"cell {quality.worst_cell} of {quality.cell_count} at r = {1e3 * r:.4g} mm, z = {1e3 * z:.4g} mm"
    raise ValueError(
        f"mesh of the {body_name}: {place} is turned inside out (its scaled Jacobian {quality.smallest_jacobian:.2g} must "
        "exceed 0): choose smaller element sizes"
    )


#: Reference coordinates ``(3, 8)`` of points inside a tetrahedron at which stiffnesses are integrated
#: (`hifi.elements.forms.rule`). A curved cell may be inverted there though it is not at its nodes.
INSIDE = np.hstack(
    [np.hstack([np.full((3, 1), a), a + (1.0 - 4.0 * a) * np.eye(3)]) for a in (0.1080472498984286, 0.3281633025163817)]
)

#: Scaled Jacobian below which the inner midside nodes of a curved cell are moved (`move_inner_midside_nodes`), and below
#: which its edges are straightened (`straighten_bent_edges`), though the mesh's surface becomes less exact then.
BENT, STRAIGHTENED = 0.05, 0.01


def move_inner_midside_nodes(mesh: Mesh, fixed_nodes: Index, reference_points: Array | None = None) -> Mesh:
    """Move the inner midside nodes of badly curved P2 tetrahedra until their scaled Jacobians are large enough.

    A curved edge on the surface may cut into its cell; this function then curves the inner edges of that cell too. It moves
    the midside nodes one after the other, each by a step in that one of 26 directions which most improves the worst cell at
    the node; the steps become shorter from pass to pass.

    Parameters
    ----------
    mesh : Mesh
        Mesh of second-order tetrahedra.
    fixed_nodes : Index
        Numbers of nodes that are not moved, such as those on the surface.
    reference_points : (3, q) Array or None, default None
        Reference coordinates of the points at which a cell's scaled Jacobian is computed; None for its nodes.

    Returns
    -------
    Mesh
        Copy of the mesh with moved nodes.
    """
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.zeros(len(points), dtype=bool)
    free[cells[:, 4:]] = True
    free[fixed_nodes] = False
    table = shape_function_gradients(mesh.elem(), reference_points)
    steps = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    size = 0.2
    near = cells
    for _ in range(12):
        bad = near[_smallest_jacobian_of_cells(with_node_coordinates(mesh, points), near, reference_points) < BENT]
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
            of_cells = _scaled_jacobians_at_points(trial.reshape(-1, 10, 3), table).min(axis=1)
            worst = of_cells.reshape(len(steps), -1).min(axis=1)
            if worst.max() > worst[13] + 1e-12:  # 13: no step
                points[n] = points[n] + length * steps[int(worst.argmax())]
        size *= 0.8
    return with_node_coordinates(mesh, points)


def straighten_bent_edges(mesh: Mesh, fixed_nodes: Index, reference_points: Array | None = None) -> tuple[Mesh, int]:
    """Straighten edges of badly curved P2 tetrahedra by moving their midside nodes to the middle between the corners.

    Parameters
    ----------
    mesh : Mesh
        Mesh of second-order tetrahedra.
    fixed_nodes : Index
        Numbers of nodes that are not moved.
    reference_points : (3, q) Array or None, default None
        Reference coordinates of the points at which a cell's scaled Jacobian is computed; None for its nodes.

    Returns
    -------
    mesh : Mesh
        Copy of the mesh with straightened edges.
    moved : int
        Number of nodes that were moved.
    """
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.ones(len(points), dtype=bool)
    free[fixed_nodes.ravel()] = False
    changed = np.zeros_like(free)
    near = cells
    for _ in range(8):
        bad = near[_smallest_jacobian_of_cells(with_node_coordinates(mesh, points), near, reference_points) < STRAIGHTENED]
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
    return with_node_coordinates(mesh, points), int(changed.sum())


def improve_curved_cells(
    mesh: Mesh, body_name: str, surface_nodes: Index, nodes_to_keep: Index
) -> tuple[Mesh, int, MeshQuality]:
    """Improve badly curved cells of a body's mesh: first by `move_inner_midside_nodes`, then by `straighten_bent_edges`.

    Parameters
    ----------
    mesh : Mesh
        Mesh of second-order tetrahedra.
    body_name : str
        Name of the body, for the error message.
    surface_nodes : Index
        Numbers of the nodes that `move_inner_midside_nodes` does not move: all nodes on the body's surface.
    nodes_to_keep : Index
        Numbers of the nodes that `straighten_bent_edges` does not move; it may move other midside nodes off the surface.

    Returns
    -------
    mesh : Mesh
        Improved mesh.
    moved : int
        Number of nodes that `straighten_bent_edges` moved.
    quality : MeshQuality
        Quality of the improved mesh.

    Raises
    ------
    ValueError
        A cell is still inverted after both steps.
    """
    found, straight = straighten_bent_edges(move_inner_midside_nodes(mesh, surface_nodes), nodes_to_keep)
    if (_smallest_jacobian_of_cells(found, found.dofs.element_dofs.T, INSIDE) <= 0.0).any():
        everywhere = np.hstack([mesh.elem.doflocs.T, INSIDE])
        moved = move_inner_midside_nodes(mesh, surface_nodes, everywhere)
        found, straight = straighten_bent_edges(moved, nodes_to_keep, everywhere)
    mesh, quality = found, mesh_quality(found)
    check_no_inverted_cells(quality, body_name)
    return mesh, straight, quality
