"""Reference elements of the 3D model: P1, P2 tetrahedra, Q1, Q2 hexahedra and their faces, nodes ordered as in gmsh.

Tetrahedra and triangles live on the unit simplex, hexahedra and quadrilaterals on [-1, 1]^d (gmsh's own coordinates,
`gmsh.model.mesh.getElementProperties`), so node arrays taken from gmsh need no permutation.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Element:
    """Lagrange element on its reference cell.

    name: key in `ELEMENTS`; gmsh_type: gmsh's element type; nodes: number of nodes n; order: polynomial order k;
    face: name of the face element (None for faces); local: reference coordinates of the nodes, shape (n, d);
    degree: default degree of `rule`. That degree passes the patch test on curved cells (the cofactors of the map times
    the gradients are integrated exactly) and integrates the stiffness of an affine cell exactly.
    """

    name: str
    gmsh_type: int
    nodes: int
    order: int
    face: str | None
    local: FloatArray
    degree: int

    @property
    def dimension(self) -> int:
        """Dimension d of the reference cell, 2 or 3."""
        return int(self.local.shape[1])

    @property
    def simplex(self) -> bool:
        """True for triangles and tetrahedra."""
        return bool(self.local.min() == 0.0)

    @property
    def corners(self) -> int:
        """Number of corner nodes; they come first."""
        return self.dimension + 1 if self.simplex else 2**self.dimension

    def shape(self, points: FloatArray) -> FloatArray:
        """Shape functions, shape (q, n), at reference points, shape (q, d)."""
        points = np.asarray(points, dtype=float)
        if not self.simplex:
            values: FloatArray = np.prod(self._factors(points)[0], axis=2)
            return values
        bary = np.column_stack([1.0 - points.sum(axis=1), points])
        if self.order == 1:
            return bary
        i, j = self._edges()
        return np.hstack([bary * (2.0 * bary - 1.0), 4.0 * bary[:, i] * bary[:, j]])

    def gradient(self, points: FloatArray) -> FloatArray:
        """Reference gradients of the shape functions, shape (q, n, d), at reference points, shape (q, d)."""
        points = np.asarray(points, dtype=float)
        d = self.dimension
        if not self.simplex:
            value, slope = self._factors(points)
            parts = [
                np.prod([slope[..., k] if k == axis else value[..., k] for k in range(d)], axis=0) for axis in range(d)
            ]
            return np.stack(parts, axis=2)
        bary = np.column_stack([1.0 - points.sum(axis=1), points])
        dbary = np.vstack([-np.ones(d), np.eye(d)])
        if self.order == 1:
            return np.broadcast_to(dbary, (len(points), d + 1, d)).copy()
        i, j = self._edges()
        corner = (4.0 * bary - 1.0)[:, :, None] * dbary
        edge = 4.0 * (bary[:, i, None] * dbary[j] + bary[:, j, None] * dbary[i])
        return np.concatenate([corner, edge], axis=1)

    def rule(self, degree: int | None = None) -> tuple[FloatArray, FloatArray]:
        """Quadrature points (q, d) and positive weights (q,) exact for polynomials of the given degree.

        Simplices: total degree; symmetric rules up to degree 6 (tetrahedra) or 5 (triangles), products of Gauss-Jacobi
        rules above. Hexahedra and quadrilaterals: degree in each coordinate, Gauss tensor products.
        Raises ValueError for a negative degree. Without a degree, the element's default.
        """
        degree = self.degree if degree is None else degree
        if degree < 0:
            raise ValueError(f"quadrature degree {degree}: must be zero or more")
        if not self.simplex:
            return _gauss(degree, self.dimension)
        table = _TETRAHEDRON if self.dimension == 3 else _TRIANGLE
        for exact in sorted(table):
            if degree <= exact:
                return _orbits(table[exact], self.dimension)
        return _conical(degree, self.dimension)

    def face_nodes(self) -> IntArray:
        """Local nodes of every face, shape (faces, m), in the face element's order, normals outward."""
        if self.face is None:
            raise ValueError(f"element {self.name} has no face element")
        face = ELEMENTS[self.face]
        linear = ELEMENTS["triangle3" if self.simplex else "quad4"].shape(face.local)
        corners = _TETRAHEDRON_FACES if self.simplex else _HEXAHEDRON_FACES
        where = np.einsum("ma,fad->fmd", linear, self.local[corners])
        distance = np.linalg.norm(where[:, :, None] - self.local, axis=3)
        nearest: IntArray = distance.argmin(axis=2)
        return nearest

    def _edges(self) -> tuple[IntArray, IntArray]:
        """Corner pairs (i, j) of the mid-edge nodes of a second-order simplex."""
        corners = self.local[: self.corners]
        middle = 0.5 * (corners[:, None] + corners)
        pairs = []
        for node in self.local[self.corners :]:
            i, j = np.argwhere(np.abs(middle - node).max(axis=2) < 1e-12)[0]
            pairs.append((i, j))
        i, j = np.array(pairs, dtype=np.int64).T
        return i, j

    def _factors(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """One-dimensional Lagrange factors and slopes, shape (q, n, d), of the tensor elements."""
        x, a = points[:, None, :], self.local[None]
        if self.order == 1:
            return 0.5 * (1.0 + a * x), np.broadcast_to(0.5 * a, np.broadcast_shapes(a.shape, x.shape))
        value = np.where(a == 0.0, 1.0 - x * x, 0.5 * x * (x + a))
        return value, np.where(a == 0.0, -2.0 * x, x + 0.5 * a)


def element_of(element: Element | str) -> Element:
    """The element itself, or the one of that name; raises ValueError for an unknown name."""
    if isinstance(element, Element):
        return element
    if element not in ELEMENTS:
        raise ValueError(f"element {element!r} is unknown; one of {', '.join(ELEMENTS)}")
    return ELEMENTS[element]


# Symmetric rules with positive weights: barycentric generator of each orbit and weight of each of its points, for unit
# volume. Degree 3: 8 interior points; 5: Walkington, 14 points; 6: Keast (1986), 24 points.
_TETRAHEDRON: dict[int, list[tuple[tuple[float, ...], float]]] = {
    1: [((0.25, 0.25, 0.25, 0.25), 1.0)],
    2: [(((5 + 3 * 5**0.5) / 20,) + 3 * ((5 - 5**0.5) / 20,), 0.25)],
    3: [
        (3 * (0.3281633025163817,) + (1 - 3 * 0.3281633025163817,), 0.1362178425370874),
        (3 * (0.1080472498984286,) + (1 - 3 * 0.1080472498984286,), 0.1137821574629126),
    ],
    5: [
        (3 * (0.31088591926330060980,) + (1 - 3 * 0.31088591926330060980,), 0.11268792571801585080),
        (3 * (0.092735250310891226402,) + (1 - 3 * 0.092735250310891226402,), 0.073493043116361949544),
        (2 * (0.045503704125649649492,) + 2 * (0.5 - 0.045503704125649649492,), 0.042546020777081466438),
    ],
    6: [
        (3 * (0.214602871259152029,) + (1 - 3 * 0.214602871259152029,), 6 * 0.00665379170969464506),
        (3 * (0.0406739585346113531,) + (1 - 3 * 0.0406739585346113531,), 6 * 0.00167953517588677382),
        (3 * (0.322337890142275510,) + (1 - 3 * 0.322337890142275510,), 6 * 0.00922619692394239843),
        (2 * (0.0636610018750175253,) + (0.269672331458315808, 0.603005664791649141), 27 / 560),
    ],
}
_TRIANGLE: dict[int, list[tuple[tuple[float, ...], float]]] = {
    1: [((1 / 3, 1 / 3, 1 / 3), 1.0)],
    2: [((2 / 3, 1 / 6, 1 / 6), 1 / 3)],
    5: [  # Radon 1948, 7 points
        ((1 / 3, 1 / 3, 1 / 3), 9 / 40),
        (2 * ((6 - 15**0.5) / 21,) + ((9 + 2 * 15**0.5) / 21,), (155 - 15**0.5) / 1200),
        (2 * ((6 + 15**0.5) / 21,) + ((9 - 2 * 15**0.5) / 21,), (155 + 15**0.5) / 1200),
    ],
}


def _orbits(table: list[tuple[tuple[float, ...], float]], dimension: int) -> tuple[FloatArray, FloatArray]:
    """Points and weights of a symmetric simplex rule from its orbits."""
    points, weights = [], []
    for generator, weight in table:
        orbit = sorted(set(permutations(generator)))
        points += [p[1:] for p in orbit]
        weights += [weight] * len(orbit)
    return np.array(points), np.array(weights) / (6.0 if dimension == 3 else 2.0)


def _gauss(degree: int, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Gauss tensor rule on [-1, 1]^d."""
    x, w = np.polynomial.legendre.leggauss(degree // 2 + 1)
    points = np.stack(np.meshgrid(*dimension * [x], indexing="ij"), axis=-1).reshape(-1, dimension)
    weights = np.prod(np.stack(np.meshgrid(*dimension * [w], indexing="ij"), axis=-1).reshape(-1, dimension), axis=1)
    return points, weights


def _conical(degree: int, dimension: int) -> tuple[FloatArray, FloatArray]:
    """Product of Gauss-Jacobi rules collapsed onto the simplex: any degree, positive weights, not symmetric."""
    from scipy.special import roots_jacobi

    count = degree // 2 + 1
    points, weights = np.zeros((1, 0)), np.ones(1)
    rest = np.ones(1)  # what the coordinates already placed leave of the unit length
    for power in range(dimension - 1, -1, -1):
        t, w = roots_jacobi(count, power, 0)
        t, w = 0.5 * (1.0 + t), w / 2.0 ** (power + 1)
        new = np.outer(rest, t)
        points = np.column_stack([np.repeat(points, count, axis=0), new.ravel()])
        weights = np.outer(weights, w).ravel()
        rest = np.outer(rest, 1.0 - t).ravel()
    return points, weights


_TETRAHEDRON_FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
_HEXAHEDRON_FACES = np.array([[0, 3, 2, 1], [0, 1, 5, 4], [0, 4, 7, 3], [1, 2, 6, 5], [2, 3, 7, 6], [4, 5, 6, 7]])

_Nodes = list[list[float]]
_TET: _Nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_TET10: _Nodes = [*_TET, [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0], [0, 0, 0.5], [0, 0.5, 0.5], [0.5, 0, 0.5]]
_HEX: _Nodes = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
_HEX_EDGES: _Nodes = [[0, -1, -1], [-1, 0, -1], [-1, -1, 0], [1, 0, -1], [1, -1, 0], [0, 1, -1]]
_HEX_EDGES += [[1, 1, 0], [-1, 1, 0], [0, -1, 1], [-1, 0, 1], [1, 0, 1], [0, 1, 1]]
_HEX_FACES: _Nodes = [[0, 0, -1], [0, -1, 0], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
_TRI: _Nodes = [[0, 0], [1, 0], [0, 1]]
_QUAD: _Nodes = [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def _element(name: str, gmsh_type: int, order: int, face: str | None, local: _Nodes, degree: int) -> Element:
    array = np.array(local, dtype=float)
    array.setflags(write=False)
    return Element(name, gmsh_type, len(array), order, face, array, degree)


ELEMENTS: dict[str, Element] = {
    e.name: e
    for e in (
        _element("P1", 4, 1, "triangle3", _TET, 1),
        _element("P2", 11, 2, "triangle6", _TET10, 3),
        _element("Q1", 5, 1, "quad4", _HEX, 3),
        _element("Q2", 12, 2, "quad9", [*_HEX, *_HEX_EDGES, *_HEX_FACES, [0, 0, 0]], 5),
        _element("triangle3", 2, 1, None, _TRI, 2),
        _element("triangle6", 9, 2, None, [*_TRI, [0.5, 0], [0.5, 0.5], [0, 0.5]], 5),
        _element("quad4", 3, 1, None, _QUAD, 3),
        _element("quad9", 10, 2, None, [*_QUAD, [0, -1], [1, 0], [0, 1], [-1, 0], [0, 0]], 7),
    )
}
