"""Solvers for symmetric positive definite matrices behind one interface, chosen by size and what is installed.

`cholmod`: supernodal Cholesky factor (cvxopt) in a nested-dissection order (pymetis) of the nodes, found as freedoms
with equal columns. `splu`: SuperLU of scipy, for small matrices.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from hifi.factor_view import structure
from hifi.fronts import Supernodes, gram_by_fronts
from meshes.arrays import Array, Index

METHODS = ("auto", "cholmod", "splu")
SMALL = 3_000
"""Freedoms below which SuperLU is as fast as anything for one right-hand side."""
FEW = 100_000
"""Entries of all right-hand sides below which it is so for them."""
SINGULAR = 1e13
"""Response of the matrix scaled to a unit diagonal to a unit load, above which it counts as singular."""


CHUNK = 20_000
"""Columns of a matrix that are looked at together."""
CHECKED = 1e-5
"""Largest relative error of the known answer of such a sweep: soft bodies lose up to half the digits."""
HELD_WHOLE = "the factor is held whole, in several times the memory and time"


class FactorError(ArithmeticError):
    """The matrix cannot be factored: not positive definite, or singular to working precision."""


@dataclass(frozen=True)
class Factor:
    """A solver prepared for one matrix.

    method: 'cholmod' or 'splu'; size: number of freedoms n.
    """

    method: str
    size: int
    _apply: Callable[[Array], Array]

    def solve(self, rhs: Array) -> Array:
        """Solution of K x = rhs, of the shape of rhs, (n,) or (n, k); raises ValueError for another shape."""
        rhs = np.asarray(rhs, dtype=float)
        if rhs.ndim not in (1, 2) or len(rhs) != self.size:
            raise ValueError(f"right-hand side has shape {rhs.shape}, expected ({self.size},) or ({self.size}, k)")
        if rhs.size == 0:
            return rhs.copy()
        return self._apply(rhs.reshape(self.size, -1)).reshape(rhs.shape)


def factor(K: sp.spmatrix, *, method: str = "auto") -> Factor:
    """Prepare the solution of K x = b for symmetric positive definite K, shape (n, n); only symmetry is taken on trust.

    method: one of `METHODS`. Raises FactorError for a matrix that is not positive definite or singular (a body that nothing
    holds), ValueError for an unknown method or a matrix that is not square, ImportError for a method whose library is
    missing.
    """
    if method not in METHODS:
        raise ValueError(f"method {method!r}: one of {', '.join(METHODS)}")
    if K.shape[0] != K.shape[1]:
        raise ValueError(f"matrix has shape {K.shape}, expected a square one")
    matrix = sp.csc_matrix(K)
    size = matrix.shape[0]
    diagonal = _diagonal(matrix)
    chosen = ("splu" if size <= SMALL else "cholmod") if method == "auto" else method
    apply = _cholmod(matrix) if chosen == "cholmod" else _splu(matrix)
    _check_response(apply, diagonal)
    return Factor(chosen, size, apply)


def nested_dissection(K: sp.csc_matrix) -> Index:
    """Fill-reducing order of the freedoms, shape (n,), by METIS on the compressed graph.

    Freedoms whose columns have the same pattern (the three of a node) are one vertex, weighted by their number.
    """
    graph, group = _vertices(K)
    place = np.empty(graph.shape[0], dtype=np.int64)
    place[_dissected(graph, group)] = np.arange(graph.shape[0])
    return np.argsort(place[group], kind="stable")


def _vertices(K: sp.csc_matrix) -> tuple[sp.csr_matrix, Index]:
    """Compressed graph of a matrix, without its diagonal, and the vertex of every freedom, shape (n,).

    The graph is symmetric, as elimination needs it, also where round-off left an entry on one side of the diagonal alone.
    """
    size, pointers = K.shape[0], K.indptr
    weights = np.random.default_rng(0).random(size)
    signature = np.empty(size)  # equal columns, equal sums
    for low in range(0, size, CHUNK):
        part = slice(low, min(low + CHUNK, size))
        begin, end = pointers[part.start], pointers[part.stop]
        own = (np.ones(end - begin), K.indices[begin:end], pointers[part.start : part.stop + 1] - begin)
        signature[part] = sp.csr_matrix(own, shape=(part.stop - low, size)) @ weights
    _, first, group = np.unique(signature, return_index=True, return_inverse=True)
    count = len(first)
    pattern = sp.csr_matrix((np.ones(K.nnz, dtype=np.int8), K.indices, pointers), shape=K.shape)
    compressed = pattern[first]  # one row for each vertex
    rows = np.repeat(np.arange(count), np.diff(compressed.indptr))
    one_sided = sp.csr_matrix((np.ones(len(rows)), (rows, group[compressed.indices])), shape=(count, count))
    graph = (one_sided + one_sided.T).tocsr()
    graph.setdiag(0)
    graph.eliminate_zeros()
    return graph, group


def _dissected(graph: sp.csr_matrix, group: Index) -> Index:
    """Order of the vertices of a compressed graph by nested dissection."""
    import pymetis

    if graph.nnz == 0:
        return np.arange(graph.shape[0])
    adjacency = pymetis.CSRAdjacency(graph.indptr, graph.indices)
    order, _ = pymetis.nested_dissection(adjacency, vweights=np.bincount(group))
    return np.asarray(order, dtype=np.int64)


def supernodes(K: sp.csc_matrix) -> Supernodes | None:
    """CHOLMOD's supernodes of a matrix in nested-dissection order, found on its compressed graph; None where the library
    does not show them."""
    import cvxopt
    from cvxopt import cholmod

    graph, group = _vertices(K)
    count = graph.shape[0]
    lower = sp.tril(graph + sp.identity(count)).tocoo()
    sparse = cvxopt.spmatrix(lower.data, lower.row.astype(np.int64), lower.col.astype(np.int64), lower.shape, "d")
    with _options(supernodal=2, nmethods=1):
        found = structure(cholmod.symbolic(sparse, p=cvxopt.matrix(_dissected(graph, group).tolist(), tc="i")), count)
    if found is None:
        return None
    order, first, start, rows = found
    freedoms, weights = np.argsort(group, kind="stable"), np.bincount(group)
    begin = np.concatenate([[0], np.cumsum(weights)])
    place = np.concatenate([[0], np.cumsum(weights[order])])  # first place of every vertex in the order of freedoms
    widths = weights[order[rows]]
    starts = np.concatenate([[0], np.cumsum(widths)])
    return Supernodes(
        freedoms[_ranges(begin[order], weights[order])], place[first], starts[start], _ranges(place[rows], widths)
    )


def _ranges(first: Index, count: Index) -> Index:
    """Numbers from each of ``first`` on, so many as ``count`` says, one after another.

    >>> _ranges(np.array([4, 1]), np.array([3, 2]))
    array([4, 5, 6, 1, 2])
    """
    ends = np.cumsum(count)
    return np.arange(ends[-1] if ends.size else 0) + np.repeat(first - ends + count, count)


def gram(K: sp.spmatrix, B: sp.spmatrix) -> Array:
    """B^T K^-1 B, shape (m, m), for sparse B (n, m): front by front (`hifi.fronts`), without holding the factor.

    Checked by one column more, K x for a known x, whose answer is x. Where that fails, or the library does not show its
    supernodes, a warning says so, and a factor that is held whole is solved with, column by column: it says what is wrong
    with the matrix. So it does, without a warning, up to `SMALL` freedoms and `FEW` entries of B. Raises FactorError as
    `factor` does.
    """
    inner, columns = sp.csc_matrix(K), sp.csc_matrix(B)
    diagonal = _diagonal(inner)
    if inner.shape[0] > SMALL or B.shape[0] * B.shape[1] > FEW:
        nodes = supernodes(inner)
        if nodes is None:
            warnings.warn("the library does not show its supernodes; " + HELD_WHOLE, RuntimeWarning, stacklevel=3)
        else:
            known = np.random.default_rng(2).standard_normal(inner.shape[0]) / np.sqrt(diagonal)
            loads = sp.hstack([columns, sp.csc_matrix((inner @ known)[:, None])]).tocsr()
            try:
                found = gram_by_fronts(inner, loads, nodes)
            except ArithmeticError as error:
                raise FactorError(f"not positive definite: elimination breaks down at column {error.args[0]}") from error
            answer = columns.T @ known
            off = np.linalg.norm(found[:-1, -1] - answer)
            if off <= CHECKED * np.linalg.norm(answer):
                return np.asarray(found[:-1, :-1])
            missed = f"a known answer is missed by {off / np.linalg.norm(answer):.1g} front by front; "
            warnings.warn(missed + HELD_WHOLE, RuntimeWarning, stacklevel=3)
    solver = factor(inner)
    return np.asarray(columns.T @ solver.solve(columns.toarray()))


@contextmanager
def _options(**own: int) -> Iterator[None]:
    """CHOLMOD's options within a block."""
    from cvxopt import cholmod

    previous = dict(cholmod.options)
    cholmod.options.update(own)
    try:
        yield
    finally:
        cholmod.options.clear()
        cholmod.options.update(previous)


def _diagonal(matrix: sp.csc_matrix) -> Array:
    """Diagonal of the matrix; raises FactorError unless all of it is positive."""
    diagonal: Array = matrix.diagonal()
    if not np.all(diagonal > 0.0):  # also NaN
        bad = int(np.argmin(np.where(np.isnan(diagonal), -np.inf, diagonal)))
        raise FactorError(f"not positive definite: diagonal entry {bad} is {diagonal[bad]:.3g} (a node no cell uses?)")
    return diagonal


def _check_response(apply: Callable[[Array], Array], diagonal: Array) -> None:
    """Raise FactorError when the factor belongs to a matrix that is singular to working precision."""
    root = np.sqrt(diagonal)
    load = np.random.default_rng(1).standard_normal(len(root))
    with np.errstate(all="ignore"):
        response = root * apply((root * load)[:, None])[:, 0]
        ratio = float(np.linalg.norm(response) / np.linalg.norm(load))
    if not ratio < SINGULAR:
        raise FactorError(f"singular to working precision (response {ratio:.1e} to a unit load): is every body held?")


def _cholmod(matrix: sp.csc_matrix) -> Callable[[Array], Array]:
    import cvxopt
    from cvxopt import cholmod

    order = nested_dissection(matrix)
    lower = sp.tril(matrix).tocoo()
    sparse = cvxopt.spmatrix(lower.data, lower.row.astype(np.int64), lower.col.astype(np.int64), matrix.shape, "d")
    try:
        with _options(supernodal=2):  # the given order unless AMD's has less fill
            symbolic = cholmod.symbolic(sparse, p=cvxopt.matrix(order.astype(np.int64), tc="i"))
            cholmod.numeric(sparse, symbolic)
    except ArithmeticError as error:
        raise FactorError(f"not positive definite: Cholesky factor breaks down at column {error.args[0]}") from error

    def apply(rhs: Array) -> Array:
        dense = cvxopt.matrix(np.asfortranarray(rhs), tc="d")
        cholmod.solve(symbolic, dense)
        return np.array(dense)

    return apply


def _splu(matrix: sp.csc_matrix) -> Callable[[Array], Array]:
    from scipy.sparse.linalg import splu

    options = {"SymmetricMode": True}
    try:
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError as error:
        raise FactorError(f"not positive definite: SuperLU says {error}") from error
    if not (np.array_equal(lu.perm_r, lu.perm_c) and np.all(lu.U.diagonal() > 0.0)):
        raise FactorError("not positive definite: SuperLU met a pivot that is not positive")

    def apply(rhs: Array) -> Array:
        solution: Array = lu.solve(rhs)
        return solution

    return apply
