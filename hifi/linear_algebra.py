"""Sparse stiffness matrices: elimination order, factorisation, and compliance under many loads.

Elimination order: degrees of freedom whose columns have the same pattern (the three of a node) form one vertex, and
METIS orders the vertices by nested dissection. In the elimination tree vertex i is an ancestor of j < i if vertices up
to i connect the two (Liu, SIAM J. Matrix Anal. Appl. 11, 1990). A minimum spanning tree preserves these connections if
each edge weighs as much as the later of its ends, so that the elimination tree follows from n - 1 edges. The supernodes
are the subtrees of at most ``LEAF`` vertices and, above them, the chains of vertices with a single child, which are the
separators.

Multifrontal elimination (Duff and Reid 1983) computes B^T K^-1 B, or a factor of K for later solutions. The front of a
supernode is the dense matrix of its rows, bordered by the columns of B that load its subtree. The Schur complement left
by its elimination is added to the front of its parent. For B^T K^-1 B the factor of K is never stored, only the active
fronts: the contribution Y^T Y of the border, with Y = L^-1 B, is added to the result at once. The memory needed is that
of K, of the result and of the fronts of one branch, whereas a bordered factor would store all of L and Y.

Large matrices get this Cholesky factor, small ones scipy's SuperLU.
"""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree
from scipy.sparse.linalg import splu

from rollbench.meshes.arrays import Array, Index

#: Largest number of vertices of a subtree that is eliminated at once, as a dense matrix.
LEAF = 32


class SymbolicFactor(NamedTuple):
    """Symbolic Cholesky factor of a sparse matrix: elimination order, and rows and columns of the supernodes.

    A supernode is a group of consecutive columns of the factor with the same pattern of rows.
    """

    #: Number of the degree of freedom that each of the n elimination steps eliminates ``(n,)``.
    elimination_order: Index
    #: First column of each supernode, in the elimination order; n comes last.
    first_columns: Index
    #: Index in ``rows_of_supernodes`` at which the rows of each supernode begin; the number of all rows comes last.
    row_starts: Index
    #: Rows of each supernode in the elimination order, supernode after supernode; those of its diagonal block come first.
    rows_of_supernodes: Index


def find_elimination_order(K: sp.csc_array) -> SymbolicFactor:
    """Compute the elimination order and the supernodes of a sparse matrix from its pattern, whatever its values.

    ``K``: sparse matrix of symmetric pattern (n, n).
    """
    graph, group = graph_of_equal_columns(K)
    dissected = _nested_dissection(graph, group)
    tree = _elimination_tree(graph[dissected][:, dissected])
    order = dissected[(later := _postorder_of_tree(tree))]
    first = _first_columns_of_supernodes(_renumbered_parents(tree, later))
    rows = _supernode_rows(graph[order][:, order], first)
    # from vertices to their degrees of freedom
    freedoms, weights = np.argsort(group, kind="stable"), np.bincount(group)
    begin = np.concatenate([[0], np.cumsum(weights)])
    place = np.concatenate([[0], np.cumsum(weights[order])])
    at = np.concatenate(rows)
    starts = np.concatenate([[0], np.cumsum(weights[order[at]])])
    return SymbolicFactor(
        freedoms[_concatenate_ranges(begin[order], weights[order])],
        place[first],
        starts[np.concatenate([[0], np.cumsum([row.size for row in rows])])],
        _concatenate_ranges(place[at], weights[order[at]]),
    )


def graph_of_equal_columns(K: sp.csc_array) -> tuple[sp.csr_array, Index]:
    """Build the compressed graph of a matrix: degrees of freedom whose columns have the same pattern form one vertex.

    The graph has no edge from a vertex to itself. It is symmetric, as elimination needs it, even if round-off
    left an entry on only one side of the diagonal.

    Parameters
    ----------
    K : (n, n) sparse array
        The matrix.

    Returns
    -------
    graph : (v, v) sparse array
        Adjacency matrix of the v vertices.
    group : (n,) Index
        Vertex to which each degree of freedom belongs.
    """
    size, pointers = K.shape[0], K.indptr
    weights = np.random.default_rng(0).random(size)
    pattern = sp.csr_array((np.ones(K.nnz, dtype=np.int8), K.indices, pointers), shape=K.shape)
    _, first, group = np.unique(pattern @ weights, return_index=True, return_inverse=True)  # equal columns, equal sums
    count = len(first)
    compressed = pattern[first]  # one row for each vertex
    rows = np.repeat(np.arange(count), np.diff(compressed.indptr))
    one_sided = sp.csr_array((np.ones(len(rows)), (rows, group[compressed.indices])), shape=(count, count))
    graph = (one_sided + one_sided.T).tocsr()
    graph.setdiag(0)
    graph.eliminate_zeros()
    return graph, group


def _nested_dissection(graph: sp.csr_array, group: Index) -> Index:
    """Order the v vertices of a compressed graph by nested dissection ``(v,)``.

    ``group``: vertex to which each degree of freedom belongs (n,).
    METIS reports the signal SIGTERM as an internal error and leaves the signal blocked. After an error METIS is
    therefore called a second time. If it fails again, its error is raised; if it succeeds, the first error was the signal,
    which is unblocked and raised again.
    """
    import pymetis

    if graph.nnz == 0:
        return np.arange(graph.shape[0])
    adjacency, weights = pymetis.CSRAdjacency(graph.indptr, graph.indices), np.bincount(group)
    try:
        order, _ = pymetis.nested_dissection(adjacency, vweights=weights)
    except RuntimeError:
        order, _ = pymetis.nested_dissection(adjacency, vweights=weights)
        if hasattr(signal, "pthread_sigmask"):  # not on Windows
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
        signal.raise_signal(signal.SIGTERM)
    return np.asarray(order, dtype=np.int64)


def _elimination_tree(graph: sp.csr_array) -> Index:
    """Return the parent of each of the n vertices of a graph in the elimination tree ``(n,)``; n for a root.

    The vertices are eliminated in their order.

    >>> _elimination_tree(sp.csr_array(np.array([[0, 0, 1, 0], [0, 0, 1, 1], [1, 1, 0, 0], [0, 1, 0, 0]])))
    array([2, 2, 3, 4])
    """
    n = graph.shape[0]
    edges = sp.tril(graph, -1).tocoo()
    spanning = minimum_spanning_tree(_sparse_adjacency_matrix(edges.row.astype(float), edges.row, edges.col, n)).tocoo()
    parent, top = [n] * n, list(range(n))  # top: ancestor, compressed towards the highest vertex that is connected so far
    ascending = np.argsort(spanning.row, kind="stable")
    for i, j in zip(spanning.row[ascending].tolist(), spanning.col[ascending].tolist(), strict=True):
        while top[j] != j:
            top[j] = top[top[j]]
            j = top[j]
        parent[j] = top[j] = i
    return np.array(parent, dtype=np.int64)


def _sparse_adjacency_matrix(weights: Array, rows: Index, columns: Index, n: int) -> sp.csr_array:
    """Make the sparse matrix ``(n, n)`` of a graph, with the entries ``weights`` at ``rows`` and ``columns``.

    The indices of the matrix have 32 bits, because csgraph of scipy 1.15 takes no others.
    """
    return sp.csr_array((weights, (rows.astype(np.int32), columns.astype(np.int32))), (n, n))


def _postorder_of_tree(parent: Index) -> Index:
    """Order the n vertices of a tree so that every subtree is contiguous and its root comes last ``(n,)``.

    ``parent``: parent of each vertex (n,), n for a root.
    """
    n = parent.size
    down = _sparse_adjacency_matrix(np.ones(n), parent, np.arange(n), n + 1)
    return np.asarray(depth_first_order(down, n, return_predecessors=False)[:0:-1], dtype=np.int64)


def _renumbered_parents(parent: Index, order: Index) -> Index:
    """Return the parent of each vertex of a tree ``(n,)`` after the vertices are renumbered in a new order.

    ``parent``: parent of each vertex (n,), n for a root; ``order``: old number of each vertex, in the new order (n,).
    """
    place = np.empty(parent.size + 1, dtype=np.int64)
    place[order], place[-1] = np.arange(order.size), order.size
    return np.asarray(place[parent[order]])


def _first_columns_of_supernodes(parent: Index) -> Index:
    """Find the first vertex of each supernode of an elimination tree; the number of all vertices comes last.

    ``parent``: parent of each vertex (n,), n for a root; the vertices are in postorder.
    """
    n = parent.size
    size = [1] * n + [0]
    for j, above in enumerate(parent.tolist()):
        size[above] += size[j]
    sizes = np.array(size)
    sizes[n] = n + LEAF  # no subtree is as small
    small = sizes <= LEAF
    roots = small[:n] & ~small[parent]  # roots of the largest small subtrees
    inside = small[1:n] & small[: n - 1] & ~roots[:-1]
    chained = ~small[1:n] & ~small[: n - 1] & (sizes[1:n] == sizes[: n - 1] + 1)
    return np.concatenate([[0], 1 + np.flatnonzero(~(inside | chained)), [n]])


def _supernode_rows(graph: sp.csr_array, first: Index) -> list[Index]:
    """List the rows that each supernode has in the factor: its vertices, their neighbours, and rows filled by elimination.

    ``graph``: adjacency matrix of the vertices in elimination order; ``first``: first vertex of each supernode.
    """
    owner = np.repeat(np.arange(first.size - 1), np.diff(first))
    left: list[list[Index]] = [[] for _ in first[1:]]
    rows = []
    for k, (low, high) in enumerate(pairwise(first)):
        met = np.concatenate([graph.indices[graph.indptr[low] : graph.indptr[high]], *left[k]])
        after = np.unique(met[met >= high])
        rows.append(np.concatenate([np.arange(low, high), after]))
        if after.size:
            left[owner[after[0]]].append(after)
    return rows


def _concatenate_ranges(first: Index, count: Index) -> Index:
    """Concatenate ranges of ``count`` consecutive numbers that begin at each of ``first``.

    >>> _concatenate_ranges(np.array([4, 1]), np.array([3, 2]))
    array([4, 5, 6, 1, 2])
    """
    ends = np.cumsum(count)
    return np.arange(ends[-1] if ends.size else 0) + np.repeat(first - ends + count, count)


#: Number of columns of a front that are added at once.
WIDTH = 64


class FrontUpdate(NamedTuple):
    """Contribution (Schur complement) of an eliminated front to the front of its parent in the elimination tree."""

    #: Rows of the matrix to which the Schur complement is added.
    rows: Index
    #: Indices of those columns of the load matrix B that have entries in the rows of the front.
    load_columns: Index
    #: Schur complement ``(rows, rows)``, of which only the lower triangle is used.
    schur_complement: Array
    #: Entries of these columns of B in ``rows``, after the elimination of the front's pivots ``(columns of B, rows)``.
    load_block: Array


class EliminatedFront(NamedTuple):
    """Result of eliminating one supernode's front: columns of the Cholesky factor L, and rows of L^-1 B.

    B: matrix with one load case in each column. The rows of L^-1 B are those of the front's pivots.
    """

    #: Rows of the front, its pivots first.
    rows: Index
    #: Indices of those columns of the load matrix B that have entries in the rows of the front.
    load_columns: Index
    #: Cholesky factor of the pivot block ``(pivots, pivots)``.
    pivot_factor: Array
    #: Rows of the Cholesky factor below the pivot block ``(other rows, pivots)``.
    factor_below_pivots: Array
    #: Rows of L^-1 B that belong to the pivots, transposed ``(columns of B, pivots)``.
    solved_loads: Array


def compliance_by_elimination(K: sp.csc_array, B: sp.csr_array, symbolic_factor: SymbolicFactor) -> Array:
    """Compute the compliance B^T K^-1 B between loads B by multifrontal elimination, without storing the factor of K.

    Parameters
    ----------
    K : (n, n) sparse array
        Symmetric positive definite matrix, both triangles stored.
    B : (n, m) sparse array
        m loads as columns.
    symbolic_factor : SymbolicFactor
        Symbolic factor of K.

    Returns
    -------
    (m, m) Array
        B^T K^-1 B.

    Raises
    ------
    ArithmeticError
        K is not positive definite.
    """
    total = np.zeros((B.shape[1], B.shape[1]))
    for front in _eliminate_fronts(K, B, symbolic_factor):
        if front.load_columns.size:
            total[np.ix_(front.load_columns, front.load_columns)] += front.solved_loads @ front.solved_loads.T
    return total


def factorise_by_elimination(K: sp.csc_array, symbolic_factor: SymbolicFactor) -> Callable[[Array], Array]:
    """Factorise a sparse positive definite matrix by multifrontal elimination, and return its solver.

    Parameters
    ----------
    K : (n, n) sparse array
        Symmetric positive definite matrix, both triangles stored.
    symbolic_factor : SymbolicFactor
        Symbolic factor of K.

    Returns
    -------
    callable
        Function that returns the solution x of K x = rhs for an array ``rhs`` of shape ``(n,)`` or ``(n, k)``; it keeps the
        factor in memory.

    Raises
    ------
    ArithmeticError
        K is not positive definite.
    """
    size = K.shape[0]
    fronts = list(_eliminate_fronts(K, sp.csr_array((size, 0)), symbolic_factor))

    def solve_right_hand_sides(rhs: Array) -> Array:
        x = rhs[symbolic_factor.elimination_order].reshape(size, -1)
        for rows, _, L, below, _ in fronts:
            pivots, later = slice(rows[0], rows[0] + len(L)), rows[len(L) :]
            x[pivots] = dtrsm(1.0, L, x[pivots], lower=1)
            x[later] -= below @ x[pivots]
        for rows, _, L, below, _ in reversed(fronts):
            pivots, later = slice(rows[0], rows[0] + len(L)), rows[len(L) :]
            x[pivots] = dtrsm(1.0, L, x[pivots] - below.T @ x[later], lower=1, trans_a=1)
        out = np.empty_like(x)
        out[symbolic_factor.elimination_order] = x
        return out.reshape(rhs.shape)

    return solve_right_hand_sides


def _eliminate_fronts(K: sp.csc_array, B: sp.csr_array, symbolic_factor: SymbolicFactor) -> Iterator[EliminatedFront]:
    """Eliminate a sparse matrix supernode by supernode, and yield the front (dense matrix) of each after its elimination.

    ``K``: matrix (n, n); ``B``: loads (n, m), which the elimination transforms to L^-1 B; ``symbolic_factor``: symbolic
    factor of K. Raises ArithmeticError if K is not positive definite.
    """
    place, local = np.empty((2, K.shape[0]), dtype=np.int64)  # of a freedom in the order, of a row in its front
    place[symbolic_factor.elimination_order] = np.arange(K.shape[0])
    owner = np.repeat(np.arange(symbolic_factor.first_columns.size - 1), np.diff(symbolic_factor.first_columns))
    waiting: dict[int, list[FrontUpdate]] = {}
    for k in range(symbolic_factor.first_columns.size - 1):
        low, high = int(symbolic_factor.first_columns[k]), int(symbolic_factor.first_columns[k + 1])
        count, freedoms = high - low, symbolic_factor.elimination_order[low:high]
        rows = symbolic_factor.rows_of_supernodes[symbolic_factor.row_starts[k] : symbolic_factor.row_starts[k + 1]]
        local[rows] = np.arange(rows.size)
        children = waiting.pop(k, [])
        loaded, load_of, loads = _entries_of_rows_or_columns(B, freedoms)
        border = np.unique(np.concatenate([loaded, *(child.load_columns for child in children)]))
        left = rows.size - count
        shapes = (rows.size, count), (left, left), (border.size, rows.size)
        panel, block, bordering = (np.zeros(shape, order="F") for shape in shapes)
        coupled, column, stiffness = _entries_of_rows_or_columns(K, freedoms)
        at = place[coupled]
        kept = at >= low
        panel[local[at[kept]], column[kept]] = stiffness[kept]
        bordering[np.searchsorted(border, loaded), load_of] = loads
        for child in children:
            down = local[child.rows]
            split = int(np.searchsorted(down, count))
            _add_lower_triangle(panel, down, child.schur_complement[:, :split])
            _add_lower_triangle(block, down[split:] - count, child.schur_complement[split:, split:])
            if child.load_columns.size:
                bordering[np.ix_(np.searchsorted(border, child.load_columns), down)] += child.load_block
        children.clear()
        done, update = _eliminate_front(panel, block, bordering, rows, border)
        if left:
            waiting.setdefault(int(owner[rows[count]]), []).append(update)
        yield done


def _entries_of_rows_or_columns(A: sp.csc_array | sp.csr_array, lines: Index) -> tuple[Index, Index, Array]:
    """List the entries of some columns of a csc matrix, or of some rows of a csr matrix.

    ``lines``: indices of these columns or rows. Returns, for each entry, the index of its row (csc) or column (csr), the
    position in ``lines`` of the column or row to which it belongs, and its value.
    """
    begin = A.indptr[lines]
    count = A.indptr[lines + 1] - begin
    of = np.repeat(np.arange(lines.size), count)
    at = _concatenate_ranges(begin, count)
    return A.indices[at].astype(np.int64), of, A.data[at]


def _add_lower_triangle(target: Array, places: Index, block: Array) -> None:
    """Add the lower triangle of a front's Schur complement (block) to the block of its parent front, in place.

    ``target``: block of the parent, in Fortran order, which is changed; ``places``: indices of the rows of ``target`` to
    which the rows of ``block`` are added. Column j of ``block`` is added to the column of ``target`` with the index
    ``places[j]``. `WIDTH` columns are added at once.
    """
    flat, start = target.ravel(order="K"), places * target.shape[0]
    for k in range(0, block.shape[1], WIDTH):
        strip = block[k:, k : k + WIDTH]
        np.add.at(flat, (start[k : k + strip.shape[1], None] + places[k:]).ravel(), strip.ravel(order="F"))


def _eliminate_front(
    panel: Array, block: Array, bordering: Array, rows: Index, border: Index
) -> tuple[EliminatedFront, FrontUpdate]:
    """Eliminate the pivots of a front, and return its factor and its contribution to the front of its parent.

    ``panel``: columns of the pivots (rows, pivots); ``block``: block of the other rows, overwritten by its Schur
    complement; ``bordering``: loads on the rows of the front, transposed (columns of B, rows), overwritten; ``rows``: rows
    of the front, its pivots first; ``border``: indices of those columns of the load matrix B that act on the front. Raises
    ArithmeticError if the pivot block is not positive definite.
    """
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
    return EliminatedFront(rows, border, L, below, share), FrontUpdate(rows[count:], border, block, loads)


T = TypeVar("T")

Solve = Callable[[Array], Array]

#: Number of degrees of freedom below which SuperLU is as fast as multifrontal elimination for one right-hand side.
SMALL = 3_000

#: Number of entries of all right-hand sides below which SuperLU is as fast as multifrontal elimination for them.
FEW = 100_000

#: Response to a unit load, of the matrix scaled to a unit diagonal, above which the matrix counts as singular.
SINGULAR = 1e13

#: Largest relative error of a known solution by multifrontal elimination: soft bodies lose up to half the digits.
CHECKED = 1e-5


class FactorError(ArithmeticError):
    """Raised for a matrix that cannot be factorised: it is not positive definite, or singular to working precision."""


def factorise_positive_definite(K: sp.sparray) -> Solve:
    """Factorise a symmetric positive definite matrix, and return a function that solves for right-hand sides.

    Whether K is positive definite is checked, whether it is symmetric is not.

    Parameters
    ----------
    K : (n, n) sparse array
        Stiffness matrix.

    Returns
    -------
    callable
        Function that returns the solution x of K x = rhs for an array ``rhs`` of shape ``(n,)`` or ``(n, k)``.

    Raises
    ------
    FactorError
        K is not positive definite, or singular (an unconstrained body).

    Examples
    --------
    >>> factorise_positive_definite(sp.csc_array(np.diag([2.0, 4.0])))(np.array([2.0, 2.0])).tolist()
    [1.0, 0.5]
    """
    matrix = sp.csc_array(K)
    diagonal = _checked_positive_diagonal(matrix)
    if matrix.shape[0] > SMALL:
        solve = _eliminate_or_raise_factor_error(lambda: factorise_by_elimination(matrix, find_elimination_order(matrix)))
    else:
        solve = _superlu_solver(matrix)
    _check_response_to_random_load(solve, diagonal)
    return solve


def symmetric_compliance_of_loads(K: sp.sparray, load_rows: sp.sparray) -> Array:
    """Compute the compliance R K^-1 R^T between several load cases R of a constrained body, made exactly symmetric.

    Parameters
    ----------
    K : (n, n) sparse array
        Stiffness matrix.
    load_rows : (m, n) sparse array
        Nodal forces R of m load cases, one in each row.

    Returns
    -------
    (m, m) Array
        Compliance between the loads.

    Raises
    ------
    FactorError
        The body is not constrained, or the factorisation fails for another reason.

    Examples
    --------
    >>> symmetric_compliance_of_loads(sp.csc_array(np.diag([2.0, 4.0])), sp.csr_array(np.eye(2))).tolist()
    [[0.5, 0.0], [0.0, 0.25]]
    """
    F = compliance_of_load_columns(K, sp.csr_array(load_rows).T) if load_rows.shape[0] else np.zeros((0, 0))
    return np.asarray(0.5 * (F + F.T))


def compliance_of_load_columns(K: sp.sparray, B: sp.sparray) -> Array:
    """Compute the matrix B^T K^-1 B for a stiffness K and loads B; a large K is eliminated without storing its factor.

    The result is checked by an additional column K x with a known solution x. If the check fails, a warning is given, and
    the system is solved with the whole factor, which reports what is wrong with the matrix. Small problems, up to `SMALL`
    degrees of freedom and `FEW` entries of B, are solved by the whole factor without a warning.

    Parameters
    ----------
    K : (n, n) sparse array
        Stiffness matrix.
    B : (n, m) sparse array
        m loads as columns.

    Returns
    -------
    (m, m) Array
        B^T K^-1 B.

    Raises
    ------
    FactorError
        K is not positive definite, or singular (an unconstrained body).
    """
    inner, columns = sp.csc_array(K), sp.csc_array(B)
    diagonal = _checked_positive_diagonal(inner)
    if inner.shape[0] > SMALL or B.shape[0] * B.shape[1] > FEW:
        known = np.random.default_rng(2).standard_normal(inner.shape[0]) / np.sqrt(diagonal)
        loads = sp.hstack([columns, sp.csc_array((inner @ known)[:, None])]).tocsr()
        order = find_elimination_order(inner)
        solved = _eliminate_or_raise_factor_error(lambda: compliance_by_elimination(inner, loads, order))
        answer = columns.T @ known
        off = np.linalg.norm(solved[:-1, -1] - answer)
        if off <= CHECKED * np.linalg.norm(answer):
            return np.asarray(solved[:-1, :-1])
        missed = f"multifrontal elimination misses a known solution by {off / np.linalg.norm(answer):.1g} of its norm"
        message = f"{missed}; the whole factor is stored instead, which takes several times the memory and time"
        warnings.warn(message, RuntimeWarning, stacklevel=3)
    return np.asarray(columns.T @ factorise_positive_definite(inner)(columns.toarray()))


def _checked_positive_diagonal(matrix: sp.csc_array) -> Array:
    """Return the diagonal ``(n,)`` of a matrix ``(n, n)``; raise FactorError unless all its entries are positive."""
    diagonal: Array = matrix.diagonal()
    if not np.all(diagonal > 0.0):  # also NaN
        bad = int(np.argmin(np.where(np.isnan(diagonal), -np.inf, diagonal)))
        raise FactorError(
            f"the matrix is not positive definite: diagonal entry {bad} is {diagonal[bad]:.3g} (is its node in no cell?)"
        )
    return diagonal


def _check_response_to_random_load(solve: Solve, diagonal: Array) -> None:
    """Raise FactorError if a factorised matrix is singular to working precision, found by its response to a random load.

    ``solve``: function that solves for a right-hand side with the factorised matrix; ``diagonal``: its diagonal (n,).
    """
    root = np.sqrt(diagonal)
    load = np.random.default_rng(1).standard_normal(len(root))
    with np.errstate(all="ignore"):
        response = root * solve(root * load)
        ratio = float(np.linalg.norm(response) / np.linalg.norm(load))
    if not ratio < SINGULAR:
        raise FactorError(
            "the stiffness matrix is singular to working precision (scaled to a unit diagonal, it gives displacements of "
            f"{ratio:.1e} under unit forces; allowed: below {SINGULAR:.0e}): check that every body is fixed"
        )


def _eliminate_or_raise_factor_error(eliminate: Callable[[], T]) -> T:
    """Call a function that eliminates a matrix; turn its ArithmeticError into a FactorError that names the failed column.

    ``eliminate``: function without arguments, whose result is returned.
    """
    try:
        return eliminate()
    except ArithmeticError as error:
        column = error.args[0]
        raise FactorError(f"the matrix is not positive definite: elimination breaks down at column {column}") from error


def _superlu_solver(matrix: sp.csc_array) -> Solve:
    """Factorise a matrix K by SuperLU, and return a function that gives the solution x of K x = rhs.

    Raises FactorError if a pivot is not positive.
    """
    try:
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise FactorError(f"the matrix is not positive definite: SuperLU reports {error}") from error
    if not (np.array_equal(lu.perm_r, lu.perm_c) and np.all(lu.U.diagonal() > 0.0)):
        raise FactorError("the matrix is not positive definite: SuperLU met a pivot that is not positive")
    return lambda rhs: np.asarray(lu.solve(rhs))
