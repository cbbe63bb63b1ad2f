"""Bodies that are their own mirror images in x: what moves alike on both sides, and oppositely, is solved apart.

Two matrices of half the freedoms take less than half of the time and memory of one.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from rollbench.hifi.linear_algebra.solvers import compliance
from rollbench.meshes.arrays import Array, Index

#: Distance of mirror images over the body's size, and parts of loads and forces that are of the other kind, that are
#: round-off.
ROUND_OFF = 1e-9


def compliance_by_halves(K: sp.csc_matrix, rows: sp.csr_matrix, points: Array, free: Index) -> Array:
    """`hifi.linear_algebra.response.compliance` ``(m, m)`` of K ``(f, f)`` for ``rows`` ``(m, f)`` on the freedoms ``free``
    ``(f,)`` of ``points`` ``(n, 3)`` [m]; by halves where points, free ones, stiffness and loads allow it.
    """
    halves = mirror_halves(points, free)
    if halves and not _apart(K, *halves):
        halves = []
    parts = [sp.csr_matrix(rows @ T) for T in halves]
    size = np.array([abs(half_rows).max(axis=1).toarray().ravel() for half_rows in parts])
    if not parts or np.any(size.min(axis=0) > ROUND_OFF * size.max(axis=0)):
        return compliance(K, rows)
    out = np.zeros((rows.shape[0],) * 2)
    for T, half_rows, of_half in zip(halves, parts, (size[0] >= size[1], size[0] < size[1]), strict=True):
        out[np.ix_(of_half, of_half)] = compliance(_on_one_side(K, T), half_rows[np.flatnonzero(of_half)])
    return out


def _apart(K: sp.csc_matrix, alike: sp.csc_matrix, opposite: sp.csc_matrix) -> bool:
    """Whether motions of one kind, of like energy in all freedoms, need no forces of the other: cells are mirror images."""
    weight = 1.0 / np.sqrt(K.diagonal())
    motion = alike @ (alike.T @ (weight * np.random.default_rng(3).standard_normal(weight.size)))
    forces = K @ motion
    return bool(np.abs(weight * (opposite @ (opposite.T @ forces))).max() <= ROUND_OFF * np.abs(weight * forces).max())


def _on_one_side(K: sp.csc_matrix, T: sp.csc_matrix) -> sp.csc_matrix:
    """T^T K T of a symmetric K that is its own mirror image: the columns of one side suffice."""
    rows, value = T.indices[T.indptr[:-1]], T.data[T.indptr[:-1]]
    half = sp.csc_matrix(T.T.tocsc() @ K[:, rows])
    half.data *= np.repeat(1.0 / value, np.diff(half.indptr))
    return half


def mirror_halves(points: Array, free: Index) -> list[sp.csc_matrix]:
    """Orthonormal motions ``(f, .)`` of the freedoms ``free`` alike on both sides of x = 0, and opposite ones; none where
    points or free ones are not mirror images."""
    apart, partner = KDTree(points).query(points * np.array([-1.0, 1.0, 1.0]))
    place = np.full(points.size, -1, dtype=np.int64)
    place[free] = np.arange(free.size)
    other = place[3 * partner[free // 3] + free % 3]
    if apart.max() > ROUND_OFF * np.abs(points).max() or other.min() < 0:
        return []
    out = []
    for sense in (1.0, -1.0):
        sign = np.where(free % 3 == 0, -sense, sense)
        index = np.arange(free.size)
        first = np.flatnonzero((index < other) | ((index == other) & (sign > 0.0)))
        second = first[other[first] != first]
        column, value = np.arange(first.size), np.where(other[first] != first, np.sqrt(0.5), 1.0)
        entries = np.concatenate([value, np.sqrt(0.5) * sign[second]])
        lines = np.concatenate([first, other[second]]), np.concatenate([column, column[other[first] != first]])
        out.append(sp.coo_matrix((entries, lines), (free.size, first.size)).tocsc())
    return out
