"""How good a mesh is: scaled Jacobians of its curved cells, distances from the exact surface; mending, refusal."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from skfem import Mesh
from skfem.element import Element

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import moved

#: Cells measured at once.
CHUNK = 8192


@dataclass(frozen=True)
class Quality:
    """Cells and nodes of a mesh, smallest and median scaled Jacobian, the worst cell and where it is (its middle, [m])."""

    cells: int
    nodes: int
    smallest: float
    median: float
    worst: int
    where: tuple[float, float, float]


def node_slopes(element: Element) -> Array:
    """Reference gradients ``(q, n, 3)`` of an element's shape functions at its own nodes."""
    at = element.doflocs.T
    return np.stack([element.lbasis(at, k)[1] for k in range(at.shape[1])], axis=1).transpose(2, 1, 0)


def scaled_jacobians(mesh: Mesh) -> Array:
    """Smallest scaled Jacobian of every cell ``(m,)`` over its nodes; 1 for the regular tetrahedron and the cube.

    Hexahedra: det J over the product of the lengths of its columns. Tetrahedra: sqrt(2) det J over the largest product of
    the three edges that meet in a corner, J taken as that of a straight tetrahedron (Stimpson et al. 2007, SAND2007-1751).
    Curved cells count as they are; pyvista's cell quality sees their corners only.
    """
    return _of_cells(mesh, mesh.dofs.element_dofs.T)


def _of_cells(mesh: Mesh, cells: Index) -> Array:
    """The same for cells ``(m, nodes)`` of the mesh in scikit-fem's order."""
    points, table = mesh.doflocs.T, node_slopes(mesh.elem())
    result = np.empty(len(cells))
    for k in range(0, len(cells), CHUNK):
        result[k : k + CHUNK] = _smallest(points[cells[k : k + CHUNK]], table).min(axis=1)
    return result


def _smallest(x: Array, table: Array) -> Array:
    """Scaled Jacobians ``(m, q)`` of cells with nodes at x ``(m, n, 3)``; table: reference gradients ``(q, n, 3)``."""
    u, v, w = np.einsum("cnx,qnd->dcqx", x, table, optimize=["einsum_path", (0, 1)])
    normal = np.stack([u[..., i] * v[..., j] - u[..., j] * v[..., i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    det = np.einsum("cqx,cqx->cq", normal, w)
    if x.shape[1] in (8, 27):
        size = np.sqrt(np.prod([np.einsum("cqx,cqx->cq", a, a) for a in (u, v, w)], axis=0))
    else:
        a, b, c, d, e, f = (np.einsum("cqx,cqx->cq", t, t) for t in (u, v, w, v - u, w - u, w - v))
        size = np.sqrt(0.5 * np.max([a * b * c, a * d * e, b * d * f, c * e * f], axis=0))
    return np.asarray(det / np.maximum(size, np.finfo(float).tiny))


def measure(mesh: Mesh) -> Quality:
    """Quality of a mesh."""
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
    """Raise ValueError where the worst cell is turned inside out."""
    if quality.smallest > 0.0:
        return
    r, z = np.hypot(*quality.where[:2]), quality.where[2]
    raise ValueError(
        f"mesh of the {name}: cell {quality.worst} of {quality.cells} at r = {1e3 * r:.4g} mm, z = {1e3 * z:.4g} mm is "
        f"turned inside out (scaled Jacobian {quality.smallest:.2g}, must exceed 0): choose smaller element sizes"
    )


#: Scaled Jacobian below which a curved cell is mended, and below which its edges are straightened, though the surface
#: suffers.
BENT, STRAIGHTENED = 0.05, 0.01


def untangle(mesh: Mesh, surface: Index) -> Mesh:
    """The mesh with inner mid-edge nodes of badly curved P2 tetrahedra moved; surface: nodes that stay.

    A bent edge of the surface may cut into its cell; the cell's inner edges are then bent too. One node after the other
    goes where the worst cell around it is best, out of steps in 26 directions that shrink.
    """
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.zeros(len(points), dtype=bool)
    free[cells[:, 4:]] = True
    free[surface] = False
    table = node_slopes(mesh.elem())
    steps = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    size = 0.2
    near = cells
    for _ in range(12):
        bad = near[_of_cells(moved(mesh, points), near) < BENT]
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
            worst = _smallest(trial.reshape(-1, 10, 3), table).min(axis=1).reshape(len(steps), -1).min(axis=1)
            if worst.max() > worst[13] + 1e-12:  # 13: no step
                points[n] = points[n] + length * steps[int(worst.argmax())]
        size *= 0.8
    return moved(mesh, points)


def straighten(mesh: Mesh, keep: Index) -> tuple[Mesh, int]:
    """The mesh with straightened edges of badly curved P2 tetrahedra, how many nodes moved; nodes ``keep`` stay."""
    cells = mesh.dofs.element_dofs.T
    points = mesh.doflocs.T.copy()
    free = np.ones(len(points), dtype=bool)
    free[keep.ravel()] = False
    changed = np.zeros_like(free)
    near = cells
    for _ in range(8):
        bad = near[_of_cells(moved(mesh, points), near) < STRAIGHTENED]
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
    return moved(mesh, points), int(changed.sum())


def mended(mesh: Mesh, name: str, surface: Index, keep: Index) -> tuple[Mesh, int, Quality]:
    """The mesh of a body with its cells untangled, nodes of the surface staying, then straightened, nodes ``keep`` staying;
    how many nodes that moved; its quality. Raises ValueError where a cell stays turned inside out."""
    mesh, straight = straighten(untangle(mesh, surface), keep)
    quality = measure(mesh)
    refuse_bad(quality, name)
    return mesh, straight, quality


def arc_deviation(x3: Array, z3: Array, centre: Array, radius: float) -> float:
    """Largest distance [m] of section points (x3, z3) [m] from the circle of a groove: centre ``(2,)``, radius [m]."""
    return float(np.abs(np.hypot(x3 - centre[0], z3 - centre[1]) - radius).max(initial=0.0))
