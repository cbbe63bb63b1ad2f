"""Weak forms of the 3D reference, their fast evaluation, and basis functions of the contact pressure.

Displacements u, virtual ones v [m]; small strains; isotropic elasticity of constant Young's modulus and Poisson's ratio.

scikit-fem could evaluate the forms itself, but as six scalar forms it takes three to four times as long, as one vector form
twenty to forty times (the report's table "reference-assembly" measures both).

A form int c_ikjl u_i,k v_j,l dV is probed with unit gradients for its tensor c; scikit-fem's Basis gives the gradients of
the shape functions, one matrix product for each cell their integrals, and these are scattered node by node.
The result equals scikit-fem's `form.assemble(basis)` of the vector space at the points of `stiffness_quadrature`, as the
tests verify.

The nodes of a 9-node face carry 1 : 4 : 16 of its area, so that nodal forces would make the force law of a contact
oscillate. The pressure is therefore bilinear between all nodes of the contact's grid: its nodal basis functions phat_k
("hat functions" on the faces' halves) give nodal forces f = W^T p and weighted gaps W g with W_ki = int phat_k N_i dA
over the contact zone, N_i the traces of the displacement's shape functions.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
import skfem
from skfem import Basis, FacetBasis, LinearForm, Mesh
from skfem.mapping import MappingIsoparametric
from skfem.models.elasticity import lame_parameters, linear_stress
from skfem.quadrature import get_quadrature

from rollbench.meshes.arrays import Array, Index

Stress = Callable[[Any], Any]


def isotropic_stress_law(young: float, poisson: float) -> Stress:
    """Return the function of isotropic linear elasticity that computes stresses from strains.

    Parameters
    ----------
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    callable
        Function that returns the stress tensor [Pa] of a strain tensor, both in scikit-fem's representation.

    Raises
    ------
    ValueError
        E > 0 and -1 < nu < 0.5 do not both hold.
    """
    if not (young > 0.0 and -1.0 < poisson < 0.5):
        raise ValueError(
            f"linear elasticity needs Young's modulus > 0 and -1 < Poisson's ratio < 0.5, got {young} Pa and {poisson}"
        )
    law: Stress = linear_stress(*lame_parameters(young, poisson))
    return law


def nodal_volume_form(axis: int | None = None) -> Any:
    """Return the linear form int N_i dA or int N_i dV of the shape functions N_i: area or volume of each node i.

    Parameters
    ----------
    axis : int | None, default None
        Axis of a first moment int x_axis N_i; None: the area or volume itself.

    Returns
    -------
    skfem.LinearForm
        The form.
    """
    return LinearForm(lambda v, w: v if axis is None else w.x[axis] * v)


#: Memory of one chunk of element matrices [bytes].
CHUNK_BYTES = 32e6

#: Degree of the quadrature of the stiffness, by the element of the mesh.
_DEGREE = {skfem.ElementTetP1: 1, skfem.ElementHex1: 3, skfem.ElementHex2: 5}

#: Degree of the quadrature on faces, by their number of corners.
_FACE_DEGREE = {3: 5, 4: 7}


class CachedIsoparametricMap(MappingIsoparametric):  # type: ignore[misc]
    """Isoparametric map of scikit-fem that locates face points in their cells without Newton's method, and caches results.

    The map shortens an assembly by a fifth to a third. The position of a face's point in its cell follows from the corners
    of face and cell. Scikit-fem finds it by Newton's method to an absolute error of 1e-12, which is below round-off for
    cells of 10 um at 16 mm from the origin. Faces are mapped as parts of their cells.
    """

    def __init__(self, mesh: Mesh) -> None:
        """Map the cells of a mesh with the shape functions of its element."""
        super().__init__(mesh, mesh.elem(), mesh.bndelem)
        self._cached: dict[str, tuple[Any, Any, Any]] = {}

    def _cached_result(self, name: str, X: Any, entities: Any, compute: Callable[[], Any]) -> Any:
        """Return the cached result for points X in cells or faces ``entities``; compute it if X or ``entities`` changed.

        ``name``: key of the result in the cache; ``compute``: function that computes it.
        """
        known = self._cached.get(name)
        if known is None or known[0] is not X or not (known[1] is entities or np.array_equal(known[1], entities)):
            known = self._cached[name] = (X, entities, compute())
        return known[2]

    def _shape_values(self, X: Array) -> tuple[Array, Array]:
        """Evaluate the n shape functions ``(n, ...)`` and their reference gradients ``(n, 3, ...)`` at the points X."""

        def evaluate_shape_functions() -> tuple[Array, Array]:
            functions = [self.elem.lbasis(X, k) for k in range(len(self.elem.doflocs))]
            return np.array([value for value, _ in functions]), np.array([slope for _, slope in functions])

        found: tuple[Array, Array] = self._cached_result("shapes", X, None, evaluate_shape_functions)
        return found

    def _interpolate_nodes(self, i: int, table: Array, tind: Any) -> Array:
        """Interpolate the nodal coordinates i (0, 1, 2: x, y, z) at q points in each of the cells ``tind`` ``(cells, q)``.

        ``table``: values of the n shape functions at the points (n, q), or (n, cells, q) if they differ between cells.
        """
        nodes = self.mesh.dofs.element_dofs
        x = self.mesh.doflocs[i, nodes if tind is None else nodes[:, tind]]
        return np.asarray(x.T @ table if table.ndim == 2 else np.einsum("nc,ncq->cq", x, table))

    def Fmap(self, i: int, X: Array, tind: Any = None) -> Array:
        """Return coordinate i (0, 1, 2: x, y, z) of the points at the reference coordinates X in the cells ``tind``."""
        return self._interpolate_nodes(i, self._shape_values(X)[0], tind)

    def J(self, i: int, j: int, X: Array, tind: Any = None) -> Array:
        """Return entry (i, j) of the Jacobian dx_i/dX_j at the reference coordinates X in the cells ``tind``."""

        def jacobian_entries() -> list[list[Array]]:
            slopes = self._shape_values(X)[1]
            return [[self._interpolate_nodes(row, slopes[:, column], tind) for column in range(3)] for row in range(3)]

        return np.asarray(self._cached_result("J", X, tind, jacobian_entries)[i][j])

    def detDF(self, X: Array, tind: Any = None, J: Any = None) -> Array:
        """Compute the determinants of the Jacobians at the reference coordinates X in the cells ``tind``."""
        return np.asarray(self._cached_result("detDF", X, tind, partial(super().detDF, X, tind, J)))

    def invDF(self, X: Array, tind: Any = None) -> Array:
        """Compute the inverse Jacobians at the reference coordinates X in the cells ``tind``."""
        return np.asarray(self._cached_result("invDF", X, tind, partial(super().invDF, X, tind)))

    def _face_corners(self, find: Any) -> Array:
        """Find the reference coordinates of the corners of faces, in the first cell of each face.

        ``find``: indices of the faces. The result is ``(3, k, f)`` for f faces of k corners, or ``(3, k, 1)`` if all faces
        have the same corners in their cells.
        """
        faces_, cells_ = self.mesh.facets[:, find], self.mesh.t[:, self.mesh.f2t[0, find]]
        corner = (cells_ == faces_[:, None]).argmax(axis=1)
        return np.asarray(self.mesh.refdom.p[:, corner[:, :1] if (corner == corner[:, :1]).all() else corner])

    def _reference_points(self, X: Array, find: Any) -> Array:
        """Find the reference coordinates, in the first cell of each face, of points X given on the reference face.

        ``find``: indices of the faces. The result is ``(3, f, q)`` for q points on f faces, or ``(3, q)`` if it is the same
        for all faces.
        """

        def map_points_to_cells() -> Array:
            corners = self._face_corners(find)
            flat = skfem.ElementTriP1() if corners.shape[1] == 3 else skfem.ElementQuad1()
            shapes = np.array([flat.lbasis(X, k)[0] for k in range(corners.shape[1])])
            places = np.einsum("kq,dkf->dfq", shapes, corners)
            return np.asarray(places[:, 0] if corners.shape[2] == 1 else places)

        return np.asarray(self._cached_result("places", X, find, map_points_to_cells))

    def G(self, X: Array, find: Any = None) -> Array:
        """Map the coordinates X on the reference face to points in space on the faces of indices ``find``."""
        x: Array = self.F(self._reference_points(X, find), self.mesh.f2t[0, find])
        self._cached["faces"] = (x, find, X)
        return x

    def invF(self, x: Array, tind: Any = None) -> Array:
        """Return the reference coordinates, in the cells ``tind``, of the face points x that `G` returned last."""
        known, find, X = self._cached.get("faces", (None, None, None))
        if known is not x or not np.array_equal(tind, self.mesh.f2t[0, find]):
            raise ValueError(
                "the reference coordinates of these points are not known: they are kept only for the points on faces that "
                "`CachedIsoparametricMap.G` returned last, in the first cell of each face; compute the points by it first"
            )
        return self._reference_points(X, find)

    def detDG(self, X: Array, find: Any = None) -> Array:
        """Compute the area ratio of the faces ``find`` to the reference face, at its coordinates X."""
        tind, corners = self.mesh.f2t[0, find], self._face_corners(find)
        sides = np.broadcast_to(corners[:, [1, -1]] - corners[:, :1], (3, 2, len(tind)))
        u, v = np.einsum("ijfq,jaf->aifq", self.DF(self._reference_points(X, find), tind), sides)
        return np.asarray(np.linalg.norm(np.cross(u, v, axis=0), axis=0))


def stiffness_quadrature(mesh: Mesh) -> tuple[Array, Array]:
    """Return the quadrature rule for the stiffness of a mesh, in the reference coordinates of a cell.

    The rule passes the patch test on curved cells (the cofactors of the map times the gradients are integrated exactly) and
    integrates the stiffness of a plane-faced cell exactly. (scikit-fem's rule of degree 3 on tetrahedra has a negative
    weight.)

    Parameters
    ----------
    mesh : Mesh
        The mesh.

    Returns
    -------
    points : (3, q) Array
        Reference coordinates of the q quadrature points.
    weights : (q,) Array
        Weights of the points, all positive.
    """
    if mesh.elem is not skfem.ElementTetP2:
        points, weights = get_quadrature(mesh.elem.refdom, _DEGREE[mesh.elem])
        return np.asarray(points), np.asarray(weights)
    near = np.array([0.3281633025163817, 0.1080472498984286])  # barycentric: three equal ones, and the fourth
    bary = np.repeat(near, 4)[:, None] + np.tile(np.eye(4), (2, 1)) * np.repeat(1.0 - 4.0 * near, 4)[:, None]
    return bary[:, 1:].T.copy(), np.repeat([0.1362178425370874, 0.1137821574629126], 4) / 6.0


def cell_basis(mesh: Mesh, **options: Any) -> Basis:
    """Create the scalar finite-element space on a mesh's cells, evaluated at the points of `stiffness_quadrature`.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    **options
        Further arguments of `skfem.Basis`.

    Returns
    -------
    Basis
        The space.
    """
    defaults = {"quadrature": stiffness_quadrature(mesh), "mapping": CachedIsoparametricMap(mesh), "dofs": mesh.dofs}
    return Basis(mesh, mesh.elem(), **{**defaults, "disable_doflocs": True, **options})


def face_basis(mesh: Mesh, boundary: str, *, element: Any = None, **options: Any) -> FacetBasis:
    """Create the scalar finite-element space on a named boundary of a mesh.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    boundary : str
        Name of the boundary.
    element : Any, default None
        Element of the space; None: the element of the mesh.
    **options
        Further arguments of `skfem.FacetBasis`.

    Returns
    -------
    FacetBasis
        The space.
    """
    defaults = {"quadrature": get_quadrature(mesh.brefdom, _FACE_DEGREE[len(mesh.facets)]), "disable_doflocs": True}
    defaults |= {"mapping": CachedIsoparametricMap(mesh)} if "mapping" not in options else {}
    defaults |= {"dofs": mesh.dofs} if element is None else {}
    return FacetBasis(mesh, mesh.elem() if element is None else element, facets=boundary, **{**defaults, **options})


def face_mass_matrix(u: FacetBasis, v: FacetBasis) -> sp.csr_array:
    """Assemble the mass matrix int v_i u_j dA between the shape functions of two scalar spaces on the same faces.

    Parameters
    ----------
    u, v : FacetBasis
        The spaces of the shape functions u_j and v_i.

    Returns
    -------
    (v.N, u.N) sparse array
        Mass matrix with rows i and columns j [m2].
    """
    left, right = (np.stack([np.asarray(phi[0]) for phi in space.basis], axis=1) for space in (v, u))  # (face, function, q)
    local = (left * v.dx[:, None]) @ right.transpose(0, 2, 1)
    rows, columns = (space.element_dofs.T.astype(np.int64) for space in (v, u))
    at = (np.repeat(rows, right.shape[1], axis=1).ravel(), np.tile(columns, left.shape[1]).ravel())
    return sp.csr_array((local.ravel(), at), (v.N, u.N))


def nodal_areas(mesh: Mesh, boundary: str) -> Array:
    """Compute the consistent nodal areas of a boundary: integrals of the shape functions over its curved faces.

    The sum of the nodal areas is the area of the boundary. The areas of the corner nodes of flat 6-node triangles vanish:
    these nodes carry no contact pressure.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    boundary : str
        Name of the boundary.

    Returns
    -------
    (n,) Array
        Areas of all nodes [m2].
    """
    return np.asarray(nodal_volume_form().assemble(face_basis(mesh, boundary)))


def elastic_stiffness(mesh: Mesh, young: float, poisson: float) -> sp.csc_array:
    """Assemble the stiffness matrix of linear elasticity, int C(eps(u)) : eps(v) dV.

    Parameters
    ----------
    mesh : Mesh
        The mesh of n nodes.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (3 n, 3 n) sparse array
        Matrix with sorted indices; degrees of freedom are 3 * node + component of ``mesh.doflocs``.

    Raises
    ------
    ValueError
        A cell is turned inside out at a quadrature point, Young's modulus is not positive, or Poisson's ratio is not
        between -1 and 0.5.
    """
    law = isotropic_stress_law(young, poisson)
    stress = np.array([law(0.5 * (slope + slope.T)) for slope in np.eye(9).reshape(9, 3, 3)])  # of each slope u_i,k
    c = stress.reshape(3, 3, 3, 3).transpose(0, 2, 1, 3).reshape(9, 9)
    nodes = np.asarray(mesh.dofs.element_dofs.T)
    count, n = mesh.doflocs.shape[1], nodes.shape[1]
    graph = _node_graph(nodes, count)
    blocks = np.zeros((9, graph.nnz))
    points, mapping = stiffness_quadrature(mesh), CachedIsoparametricMap(mesh)
    step = max(1, int(CHUNK_BYTES / (8 * max(9 * n * n, 6 * n * len(points[1])))))
    for first in range(0, len(nodes), step):
        chunk = np.arange(first, min(first + step, len(nodes)))
        basis = cell_basis(mesh, quadrature=points, elements=chunk, mapping=mapping)
        volume = basis.mapping.detDF(basis.X, basis.tind)
        if not np.all(volume > 0.0):
            bad = first + int(volume.min(axis=1).argmin())
            raise ValueError(
                f"cell {bad} of {len(nodes)} of a mesh is turned inside out: its Jacobian is {volume.min():.3g} m3 and "
                "must be > 0"
            )
        slopes = np.stack([phi[0].grad for phi in basis.basis], axis=2) * np.sqrt(basis.dx)[:, None]  # (k, cell, a, q)
        product = slopes[:, None] @ slopes.swapaxes(2, 3)  # int N_a,k N_b,l
        cell_nodes = nodes[chunk]
        at = np.asarray(graph[np.repeat(cell_nodes, n, axis=1).ravel(), np.tile(cell_nodes, n).ravel()]).ravel()
        for block, added in zip(blocks, c @ product.reshape(9, -1), strict=True):
            np.add.at(block, at, added)
    blocks = blocks.T.reshape(-1, 3, 3)
    rows = sp.bsr_array((blocks, graph.indices, graph.indptr), shape=(3 * count, 3 * count)).tocsr()
    return sp.csc_array((rows.data, rows.indices, rows.indptr), shape=rows.shape)  # block (a, b) is that of (b, a) turned


def _node_graph(nodes: Index, count: int) -> sp.csr_array:
    """Build the sparse graph of the nodes that share a cell; the value of each entry is its number, from 0, row by row.

    ``nodes``: indices of the nodes of each cell (cells, n); ``count``: number of all nodes.
    """
    n = nodes.shape[1]
    ones, starts = np.ones(nodes.size, dtype=np.int32), np.arange(0, nodes.size + 1, n)
    incidence = sp.csr_array((ones, nodes.ravel(), starts), shape=(len(nodes), count))
    graph = (incidence.T @ incidence).tocsr()
    graph.sort_indices()
    graph.data = np.arange(graph.nnz)
    return graph


class ElementHexPressure(skfem.ElementHex2):  # type: ignore[misc]
    """Basis functions of the contact pressure on a 27-node hexahedron, trilinear on each of its eight octants.

    There is one function for each node of ElementHex2.
    """

    maxdeg = 3

    def lbasis(self, X: Array, i: int) -> tuple[Array, Array]:
        """Return the value and the reference gradient of basis function i at the reference coordinates X."""
        away = np.asarray(X) - self.doflocs[i].reshape((3,) + (1,) * (np.ndim(X) - 1))
        value = np.maximum(1.0 - 2.0 * np.abs(away), 0.0)
        slope = np.where(value > 0.0, -2.0 * np.sign(away), 0.0)
        gradient = [np.prod([slope[k] if k == axis else value[k] for k in range(3)], axis=0) for axis in range(3)]
        return np.prod(value, axis=0), np.array(gradient)


def quarter_square_quadrature(refdom: Any, degree: int) -> tuple[Array, Array]:
    """Build a quadrature rule of the unit square from a Gauss rule on each of its four quarters.

    Parameters
    ----------
    refdom : Any
        Reference square of scikit-fem.
    degree : int
        Degree of the rule.

    Returns
    -------
    points : (2, q) Array
        Coordinates of the q quadrature points in the unit square.
    weights : (q,) Array
        Weights of the points, whose sum is 1.
    """
    points, weights = get_quadrature(refdom, degree)
    shifts = [(i, j) for i in (0.0, 0.5) for j in (0.0, 0.5)]
    return np.hstack([0.5 * points + np.array(s)[:, None] for s in shifts]), np.tile(0.25 * weights, 4)


def pressure_function_integrals(mesh: Mesh, contact: Index) -> sp.csr_array:
    """Compute the integrals W_ki = int phat_k N_i dA over the contact zone, the boundary "contact" of a mesh.

    phat_k are the nodal basis functions of the contact pressure, N_i the shape functions of the displacement. W gives nodal
    forces W^T p from nodal pressures p, and integrals W g of gaps g weighted by the pressure functions. Row sums are the
    areas of the pressure functions, column sums those of the shape functions. On 27-node hexahedra the pressure functions
    are bilinear on each quarter of a face. First-order tetrahedra, which represent the mesh of Lin's thesis, have
    concentrated nodal forces: W is diagonal (consistent weights would make such a coarse contact even stiffer).

    Parameters
    ----------
    mesh : Mesh
        Mesh of the patch.
    contact : (c,) Index
        Nodes of the contact zone, in the order of rows and columns.

    Returns
    -------
    (c, c) sparse array
        Weights W [m2]: pressure functions as rows, shape functions of the displacement as columns.
    """
    if mesh.elem is not skfem.ElementHex2:
        return sp.csr_array(sp.diags_array(nodal_volume_form().assemble(face_basis(mesh, "contact"))[contact]))
    rule = quarter_square_quadrature(mesh.brefdom, 7)
    u = face_basis(mesh, "contact", quadrature=rule)
    p = face_basis(mesh, "contact", element=ElementHexPressure(), quadrature=rule, mapping=u.mapping, dofs=u.dofs)
    W = face_mass_matrix(u, p)
    return sp.csr_array(W[contact][:, contact])


def normalise_weight_rows(weights: sp.csr_array) -> sp.csr_array:
    """Scale each row of a matrix of integration weights to the sum one, so that it gives weighted means, not integrals.

    Parameters
    ----------
    weights : (c, c) sparse array
        Weights of c pressure basis functions (rows) at nodal values (columns) [m2], of `pressure_function_integrals`.

    Returns
    -------
    (c, c) sparse array
        The weights with rows of sum one.
    """
    return sp.csr_array(sp.diags_array(1.0 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)
