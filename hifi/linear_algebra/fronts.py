"""Elimination of a sparse matrix front by front (multifrontal): what B^T K^-1 B needs, or a factor to be solved with.

The freedoms are eliminated in supernodes (`hifi.linear_algebra.dissection`). The front of a supernode is the dense matrix
of its rows, with the columns of B that load its subtree as a border; what its elimination leaves goes to its parent. (Duff
and Reid 1983.) For B^T K^-1 B the factor of K is never held, only the fronts under way: the border's share, Y^T Y with Y =
L^-1 B, goes straight into the result. Memory is that of K, of the result and of the fronts of one branch, where a bordered
factor holds L and Y whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from rollbench.hifi.linear_algebra.dissection import Supernodes
from rollbench.meshes.arrays import Array, Index

#: Columns of a front that are added at once: of what lies above the diagonal, half this many rows are added in vain.
WIDTH = 64


class Update(NamedTuple):
    """What a front leaves its parent: rows, columns of B, and their blocks ``(rows, rows)``, of which the lower triangle
    counts, and ``(columns, rows)``."""

    rows: Index
    border: Index
    block: Array
    loads: Array


class Eliminated(NamedTuple):
    """A front that is done: rows, its own columns first; columns of B; L ``(own, own)``, and L^-T multiplied into what
    stands below it ``(other rows, own)`` and into its border ``(columns of B, own)``."""

    rows: Index
    border: Index
    L: Array
    below: Array
    share: Array


def gram_by_fronts(K: sp.csc_array, B: sp.csr_array, nodes: Supernodes) -> Array:
    """B^T K^-1 B ``(m, m)`` for symmetric positive definite K ``(n, n)``, stored whole, and sparse B ``(n, m)``.

    Raises ArithmeticError where K is not positive definite.
    """
    total = np.zeros((B.shape[1], B.shape[1]))
    for front in _eliminated(K, B, nodes):
        if front.border.size:
            total[np.ix_(front.border, front.border)] += front.share @ front.share.T
    return total


def factor_by_fronts(K: sp.csc_array, nodes: Supernodes) -> Callable[[Array], Array]:
    """Solutions K^-1 rhs, ``(n,)`` or ``(n, k)``, for symmetric positive definite K ``(n, n)``, stored whole; L is held.

    Raises ArithmeticError where K is not positive definite.
    """
    size = K.shape[0]
    fronts = list(_eliminated(K, sp.csr_array((size, 0)), nodes))

    def solve(rhs: Array) -> Array:
        x = rhs[nodes.order].reshape(size, -1)
        for rows, _, L, below, _ in fronts:
            pivots, later = slice(rows[0], rows[0] + len(L)), rows[len(L) :]
            x[pivots] = dtrsm(1.0, L, x[pivots], lower=1)
            x[later] -= below @ x[pivots]
        for rows, _, L, below, _ in reversed(fronts):
            pivots, later = slice(rows[0], rows[0] + len(L)), rows[len(L) :]
            x[pivots] = dtrsm(1.0, L, x[pivots] - below.T @ x[later], lower=1, trans_a=1)
        out = np.empty_like(x)
        out[nodes.order] = x
        return out.reshape(rhs.shape)

    return solve


def _eliminated(K: sp.csc_array, B: sp.csr_array, nodes: Supernodes) -> Iterator[Eliminated]:
    """Fronts of K with columns of B as borders, one after another. Raises ArithmeticError as `gram_by_fronts` does."""
    place, local = np.empty((2, K.shape[0]), dtype=np.int64)  # of a freedom in the order, of a row in its front
    place[nodes.order] = np.arange(K.shape[0])
    owner = np.repeat(np.arange(nodes.first.size - 1), np.diff(nodes.first))
    waiting: dict[int, list[Update]] = {}
    for k in range(nodes.first.size - 1):
        low, high = int(nodes.first[k]), int(nodes.first[k + 1])
        count, freedoms = high - low, nodes.order[low:high]
        rows = nodes.rows[nodes.start[k] : nodes.start[k + 1]]
        local[rows] = np.arange(rows.size)
        children = waiting.pop(k, [])
        loaded, load_of, loads = _entries(B, freedoms)
        border = np.unique(np.concatenate([loaded, *(child.border for child in children)]))
        left = rows.size - count
        panel, block, bordering = (
            np.zeros(shape, order="F") for shape in ((rows.size, count), (left, left), (border.size, rows.size))
        )
        coupled, column, stiffness = _entries(K, freedoms)
        at = place[coupled]
        kept = at >= low
        panel[local[at[kept]], column[kept]] = stiffness[kept]
        bordering[np.searchsorted(border, loaded), load_of] = loads
        for child in children:
            down = local[child.rows]
            split = int(np.searchsorted(down, count))
            _add_lower(panel, down, child.block[:, :split])
            _add_lower(block, down[split:] - count, child.block[split:, split:])
            if child.border.size:
                bordering[np.ix_(np.searchsorted(border, child.border), down)] += child.loads
        children.clear()
        done, update = _eliminate(panel, block, bordering, rows, border)
        if left:
            waiting.setdefault(int(owner[rows[count]]), []).append(update)
        yield done


def _entries(A: sp.csc_array | sp.csr_array, lines: Index) -> tuple[Index, Index, Array]:
    """Entries of columns ``lines`` of a csc matrix, or of rows of a csr one: row or column, place in ``lines``, value."""
    begin = A.indptr[lines]
    count = A.indptr[lines + 1] - begin
    of = np.repeat(np.arange(lines.size), count)
    at = np.arange(of.size) + np.repeat(begin - np.cumsum(count) + count, count)
    return A.indices[at].astype(np.int64), of, A.data[at]


def _add_lower(target: Array, places: Index, block: Array) -> None:
    """Add the first columns of a child's block, from the diagonal down, to the rows ``places`` of an array in Fortran's
    order and as many columns of these places, ``WIDTH`` at once."""
    flat, start = target.ravel(order="K"), places * target.shape[0]
    for k in range(0, block.shape[1], WIDTH):
        strip = block[k:, k : k + WIDTH]
        np.add.at(flat, (start[k : k + strip.shape[1], None] + places[k:]).ravel(), strip.ravel(order="F"))


def _eliminate(panel: Array, block: Array, bordering: Array, rows: Index, border: Index) -> tuple[Eliminated, Update]:
    """Eliminate a front's own columns, its ``panel`` ``(rows, own)``, out of the block of its other rows and of its border
    ``(columns of B, rows)``, both in place."""
    count = panel.shape[1]
    L, fault = dpotrf(panel[:count], lower=1)
    if fault:
        raise ArithmeticError(int(rows[0]) + int(fault) - 1)
    below, share, loads = panel[count:], bordering[:, :count], bordering[:, count:]
    if below.size:
        below = dtrsm(1.0, L, below, side=1, lower=1, trans_a=1)
        block = dsyrk(-1.0, below, 1.0, block, lower=1, overwrite_c=1)
    if share.size:
        share = dtrsm(1.0, L, share, side=1, lower=1, trans_a=1, overwrite_b=1)
        loads = dgemm(-1.0, share, below, 1.0, loads, trans_b=1, overwrite_c=1) if below.size else loads
    return Eliminated(rows, border, L, below, share), Update(rows[count:], border, block, loads)
