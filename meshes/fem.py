"""Meshes of the parts as scikit-fem has them: made from arrays in gmsh's node order, names kept, and back.

P1, P2 tetrahedra and Q1, Q2 hexahedra are MeshTet1, MeshTet2, MeshHex1 and MeshHex2; those of second order map with their
curved cells. Faces go by names in `mesh.boundaries`. Freedom 3 * node + component of the vector space on a mesh's own
element belongs to the node `mesh.doflocs[:, node]`.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any

import numpy as np
from skfem import ElementVector, Mesh, MeshHex1, MeshHex2, MeshTet1, MeshTet2
from skfem.assembly import Dofs

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
    """Mesh of points ``(n, 3)`` [m] and cells ``(m, nodes)`` in gmsh's order, and the new number of every point ``(n,)``.

    scikit-fem renumbers the nodes of second-order meshes, vertices first; points of no cell get -1 there.
    boundaries: faces ``(k, 3 or more)`` by name, their corners first.
    Raises ValueError for an unknown kind, cells of another, or a boundary that has a face which no cell has.
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
    """The mesh with further boundaries: corners ``(k, 3 or 4)`` of their faces by name, in any order.

    Raises ValueError for a boundary that has a face which no cell has, or none at all.
    """
    count = mesh.doflocs.shape[1]
    known = _keys(np.sort(mesh.facets.T), count)
    order = np.argsort(known)
    facets = {}
    for name, corners in faces.items():
        wanted = _keys(np.sort(corners), count)
        place = order[np.minimum(np.searchsorted(known, wanted, sorter=order), len(order) - 1)]
        lost = int(np.count_nonzero(known[place] != wanted))
        if lost:
            raise ValueError(f"boundary {name!r} lost: {lost} of {len(wanted)} faces belong to no cell")
        facets[name] = np.unique(place)
    return named(mesh, facets)


def named(mesh: Mesh, facets: Mapping[str, Index]) -> Mesh:
    """The mesh with further boundaries: numbers of its facets by name. Raises ValueError for an empty one."""
    for name, numbers in facets.items():
        if not len(numbers):
            raise ValueError(f"boundary {name!r} is empty")
    added = {name: np.asarray(numbers, dtype=np.int32) for name, numbers in facets.items()}
    return _changed(mesh, _boundaries={**(mesh.boundaries or {}), **added})


def _keys(corners: Index, count: int) -> Index:
    """One number for each edge or face by its ascending corners ``(k, 2 or more)``, three of which name a face of a mesh;
    in the order of the corners."""
    if count >= 2**21:
        raise ValueError(f"{count} points: face keys hold fewer than {2**21}")
    low = corners[:, :3].astype(np.int64)
    return np.asarray(low @ count ** np.arange(low.shape[1] - 1, -1, -1))


def kind_of(mesh: Mesh) -> str:
    """P1, P2, Q1 or Q2."""
    return next(kind for kind, mesh_class in MESHES.items() if mesh.elem is mesh_class.elem)


def points_of(mesh: Mesh) -> Array:
    """Nodes ``(n, 3)`` [m]."""
    return np.asarray(mesh.doflocs.T)


def cells_of(mesh: Mesh) -> Index:
    """Nodes of the cells ``(m, nodes)`` in gmsh's order."""
    return np.asarray(mesh.dofs.element_dofs.T[:, np.argsort(_SKFEM[kind_of(mesh)])], dtype=np.int64)


class Meshed:
    """Properties of records that hold the mesh of a body."""

    mesh: Mesh

    @property
    def points(self) -> Array:
        """Nodes ``(n, 3)`` [m]."""
        return points_of(self.mesh)

    @property
    def cells(self) -> Index:
        """Nodes of the cells ``(m, nodes)`` in gmsh's order."""
        return cells_of(self.mesh)


def faces_of(mesh: Mesh, name: str) -> Index:
    """Nodes of a boundary's faces ``(k, nodes of a face)``: corners turning left seen from outside, then the middles of the
    edges from each to the next, then the face's own."""
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
    """Nodes of named boundaries, ascending."""
    return _on(mesh.dofs, mesh, names)


def freedoms_on(mesh: Mesh, *names: str) -> Index:
    """Freedoms of the vector space on named boundaries, ascending."""
    return _on(Dofs(mesh, ElementVector(mesh.elem())), mesh, names)


def _on(dofs: Dofs, mesh: Mesh, names: tuple[str, ...]) -> Index:
    freedoms = [dofs.get_facet_dofs(mesh.boundaries[name]).flatten() for name in names]
    return np.unique(np.concatenate(freedoms)).astype(np.int64)


def tensor_grid(x: Array, y: Array, z: Array, kind: str, *, left_handed: bool = False) -> Mesh:
    """Q1 or Q2 hexahedra between ascending coordinates x, y, z of their corners; left_handed: for maps that mirror them."""
    mirrored = MeshHex1.init_tensor(x, y, z)  # left-handed
    grid = MeshHex1(mirrored.doflocs, mirrored.t if left_handed else mirrored.t[[3, 5, 6, 0, 7, 1, 2, 4]])
    return grid if kind == "Q1" else second_order(grid)


def second_order(mesh: Mesh) -> Mesh:
    """The mesh with straight cells of second order, whose edges and faces need not be numbered again."""
    quadratic = MESHES[{"P1": "P2", "Q1": "Q2"}[kind_of(mesh)]].from_mesh(mesh)
    known = {name: value for name, value in vars(mesh).items() if name in ("_facets", "_t2f", "_f2t", "_edges", "_t2e")}
    return _changed(quadratic, **known)


def moved(mesh: Mesh, points: Array) -> Mesh:
    """The mesh with its nodes at points ``(n, 3)`` [m], names kept."""
    return _changed(mesh, doflocs=np.ascontiguousarray(points.T))


def _changed(mesh: Mesh, **fields: Any) -> Mesh:
    """The mesh with other fields and the same cells; its edges and faces need not be numbered again."""
    changed = copy(mesh)
    for name in ("_cached_mapping", "_cached_tree"):
        changed.__dict__.pop(name, None)
    changed.__dict__.update(fields)
    return changed
