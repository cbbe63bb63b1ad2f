"""Isotropic linear elasticity on isoparametric meshes: stiffness, loads, strains, rigid motions, cell quality.

Small strains, K_{ai,bj} = int lambda N_a,i N_b,j + mu (N_a,j N_b,i + delta_ij N_a,k N_b,k) dV. Freedoms are node-major,
3 * node + component. Points have shape (n, 3) [m], cells (m, nodes of the element) in gmsh's order. Nodes that no cell
uses get empty rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import scipy.sparse as sp

from hifi.elements import Element, FloatArray, IntArray, element_of

CHUNK_BYTES = 64e6
"""Memory of one chunk of element matrices [bytes]."""

Field = Callable[[FloatArray], FloatArray]


def lame(young: FloatArray | float, poisson: FloatArray | float) -> tuple[FloatArray, FloatArray]:
    """Lame constants lambda, mu [Pa] of Young's modulus [Pa] and Poisson's ratio.

    Raises ValueError outside E > 0, -1 < nu < 0.5.

    >>> [float(x) for x in lame(2.5, 0.25)]
    [1.0, 1.0]
    """
    e, nu = np.asarray(young, dtype=float), np.asarray(poisson, dtype=float)
    if not (np.all(e > 0.0) and np.all(nu > -1.0) and np.all(nu < 0.5)):
        raise ValueError(f"Young's modulus {young}, Poisson's ratio {poisson}: need E > 0 and -1 < nu < 0.5")
    return e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))


def stiffness(
    points: FloatArray,
    cells: IntArray,
    element: Element | str,
    young: FloatArray | float,
    poisson: FloatArray | float,
    *,
    degree: int | None = None,
) -> sp.csc_matrix:
    """Stiffness matrix [N/m], shape (3n, 3n), symmetric to round-off, indices sorted.

    young [Pa], poisson: one number or one per cell; degree: quadrature (default: the element's own).
    Raises ValueError for cells turned inside out at a quadrature point or indices outside the points.
    """
    element = element_of(element)
    points, cells = _checked(points, cells, element)
    lam, mu = (np.broadcast_to(c, len(cells)) for c in lame(young, poisson))
    n, count = element.nodes, len(points)
    indptr, indices = _node_pattern(cells, count)
    keys = np.repeat(np.arange(count, dtype=np.int64), np.diff(indptr)) * count + indices
    blocks = np.zeros((len(indices), 9))
    for part, gradients, volumes in _gradients(points, cells, element, degree, 9 * n * n):
        scaled = np.sqrt(volumes)[:, :, None, None] * gradients  # (c, q, n, 3)
        flat = scaled.reshape(len(scaled), -1, 3 * n)
        product = (flat.transpose(0, 2, 1) @ flat).reshape(-1, n, 3, n, 3)  # int N_a,i N_b,j
        local = np.empty((len(flat), n, n, 3, 3))
        first, second = lam[part, None, None], mu[part, None, None]
        trace = second * np.einsum("caibi->cab", product)
        for i in range(3):
            for j in range(3):
                local[..., i, j] = first * product[:, :, i, :, j] + second * product[:, :, j, :, i]
            local[..., i, i] += trace
        pairs = cells[part, :, None] * count + cells[part, None, :]
        _add_rows(blocks, np.searchsorted(keys, pairs.ravel()), local.reshape(-1, 9))
    rows = sp.bsr_matrix((blocks.reshape(-1, 3, 3), indices, indptr), shape=(3 * count, 3 * count)).tocsr()
    return sp.csc_matrix((rows.data, rows.indices, rows.indptr), shape=rows.shape)  # symmetric: rows are columns


def load_vector(
    points: FloatArray, cells: IntArray, element: Element | str, f: Field | FloatArray, *, degree: int | None = None
) -> FloatArray:
    """Nodal forces [N], shape (3n,), of a body force f [N/m3]: a vector (3,) or a function of x (m, 3) -> (m, 3).

    The default degree is two above the stiffness's own, for loads that are not polynomial.
    """
    element = element_of(element)
    points, cells = _checked(points, cells, element)
    degree = element.degree + 2 if degree is None else degree
    local, _ = element.rule(degree)
    shape = element.shape(local)
    result = np.zeros((len(points), 3))
    for part, _, volumes in _gradients(points, cells, element, degree, 9 * element.nodes * len(shape)):
        _add_field(result, points, cells[part], shape, volumes, f)
    return result.ravel()


def traction_vector(
    points: FloatArray,
    faces: IntArray,
    face_element: Element | str,
    t: Field | FloatArray,
    *,
    degree: int | None = None,
) -> FloatArray:
    """Nodal forces [N], shape (3n,), of a traction t [Pa] on faces (m, nodes).

    t: a vector (3,), or a function of x (m, 3) -> (m, 3) in the global frame.
    """
    element = element_of(face_element)
    points, faces = _checked(points, faces, element)
    local, areas = _face_measure(points, faces, element, degree)
    result = np.zeros((len(points), 3))
    _add_field(result, points, faces, element.shape(local), areas, t)
    return result.ravel()


def nodal_areas(
    points: FloatArray, faces: IntArray, face_element: Element | str, *, degree: int | None = None
) -> FloatArray:
    """Consistent nodal areas [m2], shape (n,): integrals of the shape functions over the curved faces (m, nodes).

    Their sum is the area. Corner areas of flat triangle6 faces vanish: such nodes carry no contact pressure.
    """
    element = element_of(face_element)
    points, faces = _checked(points, faces, element)
    local, areas = _face_measure(points, faces, element, degree)
    areas_of_nodes = np.zeros(len(points))
    np.add.at(areas_of_nodes, faces, areas @ element.shape(local))
    return areas_of_nodes


def strain_stress(
    points: FloatArray,
    cells: IntArray,
    element: Element | str,
    u: FloatArray,
    young: FloatArray | float,
    poisson: FloatArray | float,
    *,
    at: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Strain and stress [Pa], each of shape (cells, q, 6), in the order xx, yy, zz, yz, xz, xy with engineering shears.

    u: displacements [m], shape (3n,); at: reference points (q, 3), by default the quadrature points of the stiffness
    (`element.local` gives the nodes). Raises ValueError as `stiffness`.
    """
    element = element_of(element)
    points, cells = _checked(points, cells, element)
    lam, mu = (np.broadcast_to(c, len(cells))[:, None] for c in lame(young, poisson))
    at = element.rule()[0] if at is None else np.asarray(at, dtype=float)
    nodal = np.asarray(u, dtype=float).reshape(len(points), 3)
    strain = np.empty((len(cells), len(at), 6))
    for part, gradients, _ in _gradients(points, cells, element, None, 9 * element.nodes * len(at), at):
        slope = np.einsum("cqaj,cai->cqij", gradients, nodal[cells[part]], optimize=True)
        for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
            strain[part, :, k] = slope[..., i, j] + (slope[..., j, i] if i != j else 0.0)
    stress = np.empty_like(strain)
    stress[..., 3:] = mu[..., None] * strain[..., 3:]
    stress[..., :3] = 2.0 * mu[..., None] * strain[..., :3] + (lam * strain[..., :3].sum(axis=2))[..., None]
    return strain, stress


def rigid_modes(points: FloatArray, centre: FloatArray | None = None) -> FloatArray:
    """Three translations and three small rotations about the centre (default: the origin), shape (3n, 6)."""
    x = np.asarray(points, dtype=float) - (0.0 if centre is None else np.asarray(centre, dtype=float))
    modes = np.zeros((len(x), 3, 6))
    modes[:, :, :3] = np.eye(3)
    for k, axis in enumerate(np.eye(3)):
        modes[:, :, 3 + k] = np.cross(axis, x)
    return modes.reshape(-1, 6)


def check_jacobians(points: FloatArray, cells: IntArray, element: Element | str) -> FloatArray:
    """Smallest scaled Jacobian of every cell, shape (cells,), sampled at its nodes and quadrature points.

    Hexahedra: det J / (|J_1| |J_2| |J_3|). Tetrahedra: sqrt(2) det J / the largest product of the three edges that meet
    in a corner. 1 for the cube and the regular tetrahedron, <= 0 for a cell turned inside out (never raises for that).
    Source: Verdict library, Stimpson et al. (2007), SAND2007-1751, applied to J at the sample.
    """
    element = element_of(element)
    points, cells = _checked(points, cells, element)
    constant = element.order == 1 and element.simplex
    at = element.rule()[0] if constant else np.vstack([element.local, element.rule()[0]])
    table = element.gradient(at)
    step = max(1, int(CHUNK_BYTES / (8 * 30 * len(at))))
    result = np.empty(len(cells))
    for start in range(0, len(cells), step):
        part = slice(start, start + step)
        jacobian = np.einsum("cai,qaj->cqij", points[cells[part]], table, optimize=True)
        if element.simplex:
            corner = np.vstack([np.zeros(3), np.eye(3)])
            edges = [np.delete(corner, k, axis=0) - corner[k] for k in range(4)]
            lengths = [np.linalg.norm(jacobian @ e.T, axis=2).prod(axis=2) for e in edges]
            scale = np.max(lengths, axis=0) / np.sqrt(2.0)
        else:
            scale = np.linalg.norm(jacobian, axis=2).prod(axis=2)
        result[part] = (np.linalg.det(jacobian) / np.maximum(scale, np.finfo(float).tiny)).min(axis=1)
    return result


def _checked(points: FloatArray, cells: IntArray, element: Element) -> tuple[FloatArray, IntArray]:
    """Points and cells as contiguous arrays, once their shapes and indices are found right."""
    points, cells = np.ascontiguousarray(points, dtype=float), np.ascontiguousarray(cells, dtype=np.int64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points have shape {points.shape}, expected (n, 3)")
    if cells.ndim != 2 or cells.shape[1] != element.nodes:
        raise ValueError(f"cells have shape {cells.shape}, element {element.name} needs (m, {element.nodes})")
    if cells.size and not (cells.min() >= 0 and cells.max() < len(points)):
        raise ValueError(f"cells name nodes {cells.min()} to {cells.max()}, but there are {len(points)} points")
    return points, cells


def _node_pattern(cells: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Row pointers and sorted columns of the graph of nodes that share a cell."""
    n = cells.shape[1]
    incidence = sp.csr_matrix(
        (np.ones(cells.size, dtype=np.int32), cells.ravel(), np.arange(0, cells.size + 1, n)), shape=(len(cells), count)
    )
    graph = (incidence.T @ incidence).tocsr()
    graph.sort_indices()
    return graph.indptr, graph.indices


def _add_rows(target: FloatArray, rows: IntArray, values: FloatArray) -> None:
    """Add row i of values to row rows[i] of target; a sparse product does it in compiled code."""
    touched = np.zeros(len(target), dtype=bool)
    touched[rows] = True
    place = (np.cumsum(touched) - 1)[rows]
    used = np.flatnonzero(touched)
    scatter = sp.csc_matrix((np.ones(len(rows)), place, np.arange(len(rows) + 1)), shape=(len(used), len(rows)))
    target[used] += scatter @ values


def _gradients(
    points: FloatArray,
    cells: IntArray,
    element: Element,
    degree: int | None,
    numbers: int,
    at: FloatArray | None = None,
) -> Iterator[tuple[slice, FloatArray, FloatArray]]:
    """Chunks of cells: slice, gradients (c, q, n, 3) [1/m], volumes w det J (c, q) [m3]; `numbers` stored per cell."""
    local, weights = element.rule(degree)
    if at is not None:
        local, weights = at, np.ones(len(at))
    table = element.gradient(local)
    step = max(1, int(CHUNK_BYTES / (8 * max(numbers, 6 * element.nodes * len(local)))))
    for start in range(0, len(cells), step):
        part = slice(start, min(start + step, len(cells)))
        jacobian = np.einsum("cai,qaj->cqij", points[cells[part]], table, optimize=True)
        det = np.linalg.det(jacobian)
        if not np.all(det > 0.0):
            bad = start + int(np.argmin(det.min(axis=1)))
            raise ValueError(f"cell {bad} of type {element.name} is turned inside out (det J {det.min():.3g} m3)")
        yield part, table @ np.linalg.inv(jacobian), det * weights


def _face_measure(
    points: FloatArray, faces: IntArray, element: Element, degree: int | None
) -> tuple[FloatArray, FloatArray]:
    """Reference points (q, 2) and areas w |x_1 x x_2| (faces, q) [m2]."""
    local, weights = element.rule(degree)
    tangents = np.einsum("fai,qaj->fqij", points[faces], element.gradient(local), optimize=True)
    normal = np.cross(tangents[..., 0], tangents[..., 1])
    return local, np.linalg.norm(normal, axis=2) * weights


def _add_field(
    result: FloatArray,
    points: FloatArray,
    cells: IntArray,
    shape: FloatArray,
    measure: FloatArray,
    f: Field | FloatArray,
) -> None:
    """Add int N_a f to result (n, 3), f a vector or a function of x."""
    where = np.einsum("qa,cai->cqi", shape, points[cells], optimize=True)
    value = f(where.reshape(-1, 3)).reshape(where.shape) if callable(f) else np.broadcast_to(f, where.shape)
    forces = np.einsum("cq,qa,cqi->cai", measure, shape, value, optimize=True)
    np.add.at(result, cells, forces)
