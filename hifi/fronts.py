"""B^T K^-1 B front by front (multifrontal elimination): the factor of K is never held, only the fronts under way.

The freedoms are eliminated in the supernodes of CHOLMOD's symbolic factor. The front of a supernode is the dense matrix of
its rows, with the columns of B that load its subtree as a border; what its elimination leaves goes to its parent, and the
border's share, Y^T Y with Y = L^-1 B, straight into the result. (Duff and Reid 1983.) Memory is that of K, of the result
and of the fronts of one branch, where a bordered factor holds L and Y whole.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from meshes.arrays import Array, Index

#: Columns of a front that are added at once: of what lies above the diagonal, half this many rows are added in vain.
WIDTH = 64


class Supernodes(NamedTuple):
    """Symbolic factor: ``order[i]`` is the i-th freedom to eliminate; supernode k has the columns ``first[k]`` to
    ``first[k + 1]`` and the rows ``rows[start[k]:start[k + 1]]``, sorted, its own columns first."""

    order: Index
    first: Index
    start: Index
    rows: Index


class Update(NamedTuple):
    """What a front leaves its parent: rows, columns of B, and the block ``(rows + columns, rows)``."""

    rows: Index
    border: Index
    block: Array


def gram_by_fronts(K: sp.csc_matrix, B: sp.csr_matrix, nodes: Supernodes) -> Array:
    """B^T K^-1 B ``(m, m)`` for symmetric positive definite K ``(n, n)``, stored whole, and sparse B ``(n, m)``.

    Raises ArithmeticError where K is not positive definite.
    """
    n, m = B.shape
    place = np.empty(n, dtype=np.int64)
    place[nodes.order] = np.arange(n)
    owner = np.repeat(np.arange(nodes.first.size - 1), np.diff(nodes.first))
    waiting: dict[int, list[Update]] = {}
    found = np.zeros((m, m))
    for k in range(nodes.first.size - 1):
        low, high = int(nodes.first[k]), int(nodes.first[k + 1])
        own = nodes.order[low:high]
        rows = nodes.rows[nodes.start[k] : nodes.start[k + 1]]
        children = waiting.pop(k, [])
        loaded, load_of, loads = _entries(B, own)
        border = np.unique(np.concatenate([loaded, *(child.border for child in children)]))
        front = np.zeros((rows.size + border.size, rows.size), order="F")
        coupled, column, stiffness = _entries(K, own)
        at = place[coupled]
        kept = at >= low
        front[np.searchsorted(rows, at[kept]), column[kept]] = stiffness[kept]
        front[rows.size + np.searchsorted(border, loaded), load_of] = loads
        for child in children:
            down = np.searchsorted(rows, child.rows)
            all_ = np.concatenate([down, rows.size + np.searchsorted(border, child.border)])
            _extend_add(front, all_, down, child.block)
        children.clear()
        _eliminate(front, high - low, rows, border, found, waiting, owner)
    return found


def _entries(A: sp.csc_matrix | sp.csr_matrix, own: Index) -> tuple[Index, Index, Array]:
    """Entries of the columns ``own`` of a csc matrix, or rows of a csr one: row or column, place in ``own``, value."""
    begin = A.indptr[own]
    count = A.indptr[own + 1] - begin
    of = np.repeat(np.arange(own.size), count)
    at = np.arange(of.size) + np.repeat(begin - np.cumsum(count) + count, count)
    return A.indices[at].astype(np.int64), of, A.data[at]


def _extend_add(front: Array, rows: Index, columns: Index, block: Array) -> None:
    """Add a child's block to its rows and columns of a front, columns ``WIDTH`` by ``WIDTH`` from the diagonal down."""
    flat, start = front.ravel(order="K"), columns * front.shape[0]
    for k in range(0, columns.size, WIDTH):
        own = slice(k, k + WIDTH)
        np.add.at(flat, (start[own, None] + rows[k:]).ravel(), block[k:, own].ravel(order="F"))


def _eliminate(
    front: Array, count: int, rows: Index, border: Index, found: Array, waiting: dict[int, list[Update]], owner: Index
) -> None:
    """Eliminate the first ``count`` columns of a front: its border's share into ``found``, the rest to its parent."""
    L, fault = dpotrf(front[:count, :count], lower=1)
    if fault:
        raise ArithmeticError(int(rows[0]) + int(fault) - 1)
    if front.shape[0] == count:
        return
    below = dtrsm(1.0, L, front[count:, :count], side=1, lower=1, trans_a=1)
    inner = rows.size - count
    share = below[inner:]
    if border.size:
        found[np.ix_(border, border)] += share @ share.T
    if inner:  # of the rows' own block the lower triangle counts
        rest = np.empty((below.shape[0], inner), order="F")
        rest[:inner] = dsyrk(-1.0, below[:inner], 1.0, front[count : rows.size, count:], lower=1)
        if border.size:
            rest[inner:] = dgemm(-1.0, share, below[:inner], 1.0, front[rows.size :, count:], trans_b=1)
        waiting.setdefault(int(owner[rows[count]]), []).append(Update(rows[count:], border, rest))
