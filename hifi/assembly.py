"""Fast evaluation of weak forms that scikit-fem could evaluate itself, some five to ten times slower.

A form of the kind int c_ikjl u_i,k v_j,l dV is probed with unit gradients for its tensor c; scikit-fem's Basis gives the
gradients of the shape functions, one matrix product for each cell their integrals, and these are scattered node by node.
`form.assemble(basis)` of the vector space at the points of `rule` is the same matrix, and the test of this module.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from skfem import Basis, ElementHex1, ElementHex2, ElementQuad1, ElementTetP1, ElementTetP2, ElementTriP1, FacetBasis, Mesh
from skfem.element import DiscreteField
from skfem.mapping import MappingIsoparametric
from skfem.quadrature import get_quadrature

from hifi.forms import share
from meshes.arrays import Array, Index

CHUNK_BYTES = 32e6
"""Memory of one chunk of element matrices [bytes]."""
_DEGREE = {ElementTetP1: 1, ElementHex1: 3, ElementHex2: 5}
#: Degree of the quadrature on faces, by their number of corners.
_FACE_DEGREE = {3: 5, 4: 7}


class CurvedMap(MappingIsoparametric):  # type: ignore[misc]
    """scikit-fem's isoparametric map without Newton's method on faces, and without repetition.

    Where a point of a face lies in its cell is known from their corners. scikit-fem looks for it by Newton's method to an
    absolute 1e-12, which is below round-off in cells of 10 um 16 mm from the origin. The shape functions and inverse
    Jacobians last asked for are kept.
    """

    def __init__(self, mesh: Mesh) -> None:
        """Map of a mesh's own element."""
        super().__init__(mesh, mesh.elem(), mesh.bndelem)
        self._at: tuple[Any, Array, Array] | None = None
        self._inverse: tuple[Any, Any, Array] | None = None
        self._face: tuple[Array, Array, Any] | None = None

    def _shapes(self, X: Array) -> tuple[Array, Array]:
        """Shape functions ``(n, ...)`` and reference gradients ``(n, 3, ...)`` at X."""
        if self._at is None or self._at[0] is not X:
            own = [self.elem.lbasis(X, k) for k in range(len(self.elem.doflocs))]
            self._at = (X, np.array([value for value, _ in own]), np.array([slope for _, slope in own]))
        return self._at[1:]

    def _sum(self, i: int, table: Array, tind: Any) -> Array:
        """Component i of the nodes of the cells tind times a table ``(n, q)`` or ``(n, cells, q)``: ``(cells, q)``."""
        nodes = self.mesh.dofs.element_dofs
        x = self.mesh.doflocs[i, nodes if tind is None else nodes[:, tind]]
        return np.asarray(x.T @ table if table.ndim == 2 else np.einsum("nc,ncq->cq", x, table))

    def Fmap(self, i: int, X: Array, tind: Any = None) -> Array:
        """Component i of the places of X."""
        return self._sum(i, self._shapes(X)[0], tind)

    def J(self, i: int, j: int, X: Array, tind: Any = None) -> Array:
        """Entry (i, j) of the Jacobian at X."""
        return self._sum(i, self._shapes(X)[1][:, j], tind)

    def G(self, X: Array, find: Any = None) -> Array:
        """Points of the faces find at X."""
        x: Array = super().G(X, find)
        self._face = (x, X, find)
        return x

    def invF(self, x: Array, tind: Any = None) -> Array:
        """Places in the cells tind of points x, as they came from `G`: corner k of a face is one of its cell's corners."""
        if self._face is None or self._face[0] is not x:
            raise ValueError("only points of faces have a place in a cell")
        _, X, find = self._face
        corners = self.mesh.facets[:, find]
        flat = ElementTriP1() if len(corners) == 3 else ElementQuad1()
        own = (self.mesh.t[:, tind] == corners[:, None]).argmax(axis=1)
        shapes = np.array([flat.lbasis(X, k)[0] for k in range(len(corners))])
        return np.asarray(np.einsum("kq,dkf->dfq", shapes, self.mesh.refdom.p[:, own]))

    def invDF(self, X: Array, tind: Any = None) -> Array:
        """Inverse Jacobians at X in the cells tind."""
        if self._inverse is None or self._inverse[0] is not X or self._inverse[1] is not tind:
            self._inverse = (X, tind, super().invDF(X, tind))
        return self._inverse[2]


def rule(mesh: Mesh) -> tuple[Array, Array]:
    """Quadrature points ``(3, q)`` and positive weights ``(q,)`` of a stiffness on the mesh's own element.

    It passes the patch test on curved cells (the cofactors of the map times the gradients are integrated exactly) and
    integrates the stiffness of a plane-faced cell exactly. (scikit-fem's rule of degree 3 on tetrahedra has one below 0.)
    """
    if mesh.elem is not ElementTetP2:
        points, weights = get_quadrature(mesh.elem.refdom, _DEGREE[mesh.elem])
        return np.asarray(points), np.asarray(weights)
    near = np.array([0.3281633025163817, 0.1080472498984286])  # barycentric: three alike, and the rest
    bary = np.repeat(near, 4)[:, None] + np.tile(np.eye(4), (2, 1)) * np.repeat(1.0 - 4.0 * near, 4)[:, None]
    return bary[:, 1:].T.copy(), np.repeat([0.1362178425370874, 0.1137821574629126], 4) / 6.0


def cells(mesh: Mesh, **options: Any) -> Basis:
    """Scalar space on the mesh's own element, at the points of `rule`. options: of `skfem.Basis`."""
    own = {"quadrature": rule(mesh), "mapping": CurvedMap(mesh), "dofs": mesh.dofs, "disable_doflocs": True}
    return Basis(mesh, mesh.elem(), **{**own, **options})


def faces(mesh: Mesh, name: str, *, element: Any = None, **options: Any) -> FacetBasis:
    """A space (scalar on the mesh's own element unless given) on a named boundary. options: of `skfem.FacetBasis`."""
    element = mesh.elem() if element is None else element
    degree = _FACE_DEGREE[len(mesh.facets)]
    quadrature = get_quadrature(mesh.brefdom, degree)
    return FacetBasis(mesh, element, facets=name, **{"mapping": CurvedMap(mesh), "quadrature": quadrature, **options})


def nodal_areas(mesh: Mesh, name: str) -> Array:
    """Consistent nodal areas [m2] of a boundary, ``(n,)``: integrals of the shape functions over its curved faces.

    Their sum is the area. Corner areas of flat 6-node triangles vanish: such nodes carry no contact pressure.
    """
    return np.asarray(share().assemble(faces(mesh, name)))


def tensor(form: Any) -> Array:
    """c[i, k, j, l] of a form c_ikjl u_i,k v_j,l. Raises ValueError for one that depends on more than gradients."""
    unknown = np.full((3, 1, 1), np.nan)
    unit = [DiscreteField(value=unknown, grad=g.reshape(3, 3, 1, 1)) for g in np.eye(9)]
    found = np.array([[np.ravel(form.form(u, v, None))[0] for v in unit] for u in unit]).reshape(3, 3, 3, 3)
    if not np.isfinite(found).all():
        raise ValueError("the form depends on displacements, not on their gradients alone: assemble it with scikit-fem")
    return found


def assemble(form: Any, mesh: Mesh) -> sp.csc_matrix:
    """Sparse matrix ``(3n, 3n)`` of a form in the gradients alone, of constant coefficients; sorted indices.

    Freedoms are 3 * node + component of `mesh.doflocs`. Raises ValueError for cells turned inside out at a quadrature
    point and for other forms.
    """
    c = tensor(form).transpose(1, 3, 0, 2).reshape(9, 9)
    nodes = np.asarray(mesh.dofs.element_dofs.T, dtype=np.int64)
    count, n = mesh.doflocs.shape[1], nodes.shape[1]
    indptr, indices = _pattern(nodes, count)
    keys = np.repeat(np.arange(count, dtype=np.int64), np.diff(indptr)) * count + indices
    blocks = np.zeros((len(indices), 9))
    points = rule(mesh)
    step = max(1, int(CHUNK_BYTES / (8 * max(9 * n * n, 6 * n * len(points[1])))))
    for first in range(0, len(nodes), step):
        some = np.arange(first, min(first + step, len(nodes)))
        part = cells(mesh, quadrature=points, elements=some)
        volume = part.mapping.detDF(part.X, part.tind)
        if not np.all(volume > 0.0):
            bad = first + int(volume.min(axis=1).argmin())
            raise ValueError(f"cell {bad} of {len(nodes)} is turned inside out (det J {volume.min():.3g} m3)")
        slopes = np.stack([phi[0].grad for phi in part.basis]).transpose(2, 3, 0, 1)  # (cell, q, a, k)
        flat = (slopes * np.sqrt(part.dx)[:, :, None, None]).reshape(len(some), -1, 3 * n)
        product = (flat.transpose(0, 2, 1) @ flat).reshape(-1, n, 3, n, 3)  # int N_a,k N_b,l
        local = product.transpose(0, 1, 3, 2, 4).reshape(-1, 9) @ c
        own = nodes[some]
        _add_rows(blocks, np.searchsorted(keys, (own[:, :, None] * count + own[:, None, :]).ravel()), local)
    rows = sp.bsr_matrix((blocks.reshape(-1, 3, 3), indices, indptr), shape=(3 * count, 3 * count)).tocsr()
    return sp.csc_matrix((rows.data, rows.indices, rows.indptr), shape=rows.shape)  # block (a, b) is that of (b, a) turned


def _pattern(nodes: Index, count: int) -> tuple[Index, Index]:
    """Row pointers and sorted columns of the graph of nodes that share a cell."""
    n = nodes.shape[1]
    incidence = sp.csr_matrix(
        (np.ones(nodes.size, dtype=np.int32), nodes.ravel(), np.arange(0, nodes.size + 1, n)), shape=(len(nodes), count)
    )
    graph = (incidence.T @ incidence).tocsr()
    graph.sort_indices()
    return graph.indptr, graph.indices


def _add_rows(target: Array, rows: Index, values: Array) -> None:
    """Add row i of values to row rows[i] of target; a sparse product does it in compiled code."""
    touched = np.zeros(len(target), dtype=bool)
    touched[rows] = True
    place = (np.cumsum(touched) - 1)[rows]
    used = np.flatnonzero(touched)
    scatter = sp.csc_matrix((np.ones(len(rows)), place, np.arange(len(rows) + 1)), shape=(len(used), len(rows)))
    target[used] += scatter @ values
