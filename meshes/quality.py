"""How good a mesh is: scaled Jacobians, distances from the exact surface, elements across a contact; mending, refusal."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Share of cells below this scaled Jacobian is counted.
POOR = 0.1
#: Cells measured at once.
CHUNK = 8192
#: Edges of a tetrahedron in the order of gmsh's mid-edge nodes.
TET_EDGES = ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))
_HEX_CORNERS = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
#: Corners whose mean each further node of gmsh's 27-node hexahedron is.
_HEX_MEANS = (
    (0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7),
    (0, 1, 2, 3), (0, 1, 4, 5), (0, 3, 4, 7), (1, 2, 5, 6), (2, 3, 6, 7), (4, 5, 6, 7), tuple(range(8)),
)  # fmt: skip


@dataclass(frozen=True)
class Quality:
    """Cells and nodes of a mesh, smallest and median scaled Jacobian, share of cells below 0.1, the worst cell and where
    it is (its middle, [m])."""

    cells: int
    nodes: int
    smallest: float
    median: float
    poor: float
    worst: int
    where: tuple[float, float, float]


def reference_nodes(kind: str) -> Array:
    """Reference coordinates ``(n, 3)`` of an element's nodes in gmsh's order; kind: P1, P2, Q1 or Q2."""
    tet = np.vstack([np.zeros(3), np.eye(3)])
    corners = np.array(_HEX_CORNERS, dtype=float)
    found = {
        "P1": tet,
        "P2": np.vstack([tet, [0.5 * (tet[i] + tet[j]) for i, j in TET_EDGES]]),
        "Q1": corners,
        "Q2": np.vstack([corners, [corners[list(mean)].mean(axis=0) for mean in _HEX_MEANS]]),
    }
    if kind not in found:
        raise ValueError(f"element {kind!r} is unknown; one of {', '.join(found)}")
    return found[kind]


def _gradients(kind: str, at: Array) -> Array:
    """Reference gradients ``(q, n, 3)`` of the shape functions, from the monomials that they span."""
    order = 2 if kind[1] == "2" else 1
    powers = np.array([p for p in product(range(order + 1), repeat=3) if kind[0] == "Q" or sum(p) <= order])
    slopes = []
    for axis in range(3):
        less = np.maximum(powers - np.eye(3, dtype=int)[axis], 0)
        slopes.append(powers[:, axis] * np.prod(at[:, None, :] ** less, axis=2))
    spans = np.prod(reference_nodes(kind)[:, None, :] ** powers, axis=2)
    return np.asarray(np.stack([s @ np.linalg.inv(spans) for s in slopes], axis=2))


def scaled_jacobians(points: Array, cells: Index, kind: str) -> Array:
    """Smallest scaled Jacobian of every cell ``(m,)`` over its nodes; 1 for the regular tetrahedron and the cube.

    Hexahedra: det J over the product of the lengths of its columns. Tetrahedra: sqrt(2) det J over the largest product of
    the three edges that meet in a corner, J taken as that of a straight tetrahedron (Stimpson et al. 2007, SAND2007-1751).
    """
    nodes = reference_nodes(kind)
    if cells.ndim != 2 or cells.shape[1] != len(nodes):
        raise ValueError(f"cells have shape {cells.shape}, element {kind} needs (m, {len(nodes)})")
    table = _gradients(kind, nodes if kind != "P1" else nodes[:1])
    result = np.empty(len(cells))
    for k in range(0, len(cells), CHUNK):
        result[k : k + CHUNK] = _smallest(points[cells[k : k + CHUNK]], table, kind).min(axis=1)
    return result


def _smallest(x: Array, table: Array, kind: str) -> Array:
    """Scaled Jacobians ``(m, q)`` of cells with nodes at x ``(m, n, 3)``; table: reference gradients ``(q, n, 3)``."""
    u, v, w = np.einsum("cnx,qnd->dcqx", x, table, optimize=True)
    det = np.einsum("cqx,cqx->cq", np.cross(u, v), w)
    if kind[0] == "Q":
        size = np.sqrt(np.prod([np.einsum("cqx,cqx->cq", a, a) for a in (u, v, w)], axis=0))
    else:
        a, b, c, d, e, f = (np.einsum("cqx,cqx->cq", t, t) for t in (u, v, w, v - u, w - u, w - v))
        size = np.sqrt(0.5 * np.max([a * b * c, a * d * e, b * d * f, c * e * f], axis=0))
    return np.asarray(det / np.maximum(size, np.finfo(float).tiny))


def measure(points: Array, cells: Index, kind: str) -> Quality:
    """Quality of a mesh: points ``(n, 3)`` [m], cells ``(m, nodes)`` in gmsh's order, kind P1, P2, Q1 or Q2."""
    if not len(cells):
        raise ValueError("the mesh has no cells")
    found = scaled_jacobians(points, cells, kind)
    worst = int(found.argmin())
    x, y, z = points[cells[worst]].mean(axis=0)
    return Quality(
        len(cells), len(points), float(found[worst]), float(np.median(found)), float((found < POOR).mean()), worst,
        (float(x), float(y), float(z)),
    )  # fmt: skip


def refuse_bad(quality: Quality, name: str, least: float = 0.0) -> None:
    """Raise ValueError where the worst cell's scaled Jacobian is not above ``least``."""
    if quality.smallest > least:
        return
    r, z = np.hypot(*quality.where[:2]), quality.where[2]
    state = "turned inside out" if quality.smallest <= 0.0 else "too flat"
    raise ValueError(
        f"mesh of the {name}: cell {quality.worst} of {quality.cells} at r = {1e3 * r:.4g} mm, z = {1e3 * z:.4g} mm is "
        f"{state} (scaled Jacobian {quality.smallest:.2g}, must exceed {least:g}): choose smaller element sizes"
    )


def untangle(points: Array, cells: Index, surface: Index, threshold: float = 0.05) -> Array:
    """Points with inner mid-edge nodes of badly curved P2 tetrahedra moved; surface: nodes that stay.

    A bent edge of the surface may cut into its cell; the cell's inner edges are then bent too. One node after the other
    goes where the worst cell around it is best, out of steps in 26 directions that shrink.
    """
    free = np.zeros(len(points), dtype=bool)
    free[cells[:, 4:]] = True
    free[surface] = False
    points = points.copy()
    table = _gradients("P2", reference_nodes("P2"))
    steps = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    size = 0.2
    near = cells
    for _ in range(12):
        bad = near[scaled_jacobians(points, near, "P2") < threshold]
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
            worst = _smallest(trial.reshape(-1, 10, 3), table, "P2").min(axis=1).reshape(len(steps), -1).min(axis=1)
            if worst.max() > worst[13] + 1e-12:  # 13: no step
                points[n] = points[n] + length * steps[int(worst.argmax())]
        size *= 0.8
    return points


def straighten(points: Array, cells: Index, keep: Index, threshold: float = 0.1) -> tuple[Array, int]:
    """Points with straightened edges of badly curved P2 tetrahedra, and how many nodes moved; nodes ``keep`` stay."""
    free = np.ones(points.shape[0], dtype=bool)
    free[keep.ravel()] = False
    moved = np.zeros_like(free)
    points = points.copy()
    near = cells
    for _ in range(8):
        bad = near[scaled_jacobians(points, near, "P2") < threshold]
        before = int(moved.sum())
        for k, (i, j) in enumerate(TET_EDGES):
            middle = 0.5 * (points[bad[:, i]] + points[bad[:, j]])
            node = bad[:, 4 + k]
            move = free[node] & (np.abs(points[node] - middle).max(axis=1, initial=0.0) > 0.0)
            points[node[move]] = middle[move]
            moved[node[move]] = True
        if int(moved.sum()) == before:
            break
        near = cells[moved[cells].any(axis=1)]
    return points, int(moved.sum())


def arc_deviation(x3: Array, z3: Array, centre: Array, radius: float) -> float:
    """Largest distance [m] of section points (x3, z3) [m] from the circle of a groove: centre ``(2,)``, radius [m]."""
    return float(np.abs(np.hypot(x3 - centre[0], z3 - centre[1]) - radius).max(initial=0.0))


def elements_across(boundaries: Array, semi: float) -> float:
    """Elements, whole and part, along a semi-axis [m] of a contact; boundaries: ascending [m] from its centre.

    The mean over both sides, so that uneven grids count fairly.

    >>> elements_across(np.array([-4e-4, -1e-4, -5e-5, 0.0, 5e-5, 1e-4, 4e-4]), 1e-4)
    2.0
    """
    if np.any(np.diff(boundaries) <= 0.0) or not boundaries[0] < 0.0 < boundaries[-1]:
        raise ValueError("element boundaries must ascend through zero, the contact's centre")
    if not 0.0 < semi <= min(-boundaries[0], boundaries[-1]):
        raise ValueError(
            f"semi-axis of {1e3 * semi:.4g} mm in a zone from {1e3 * boundaries[0]:.4g} to {1e3 * boundaries[-1]:.4g} mm: "
            "make the zone larger"
        )
    number = np.interp([-semi, semi], boundaries, np.arange(boundaries.size))
    return float(0.5 * (number[1] - number[0]))
