"""In which order, and in which dense blocks, a sparse matrix is eliminated.

Freedoms whose columns have the same pattern (the three of a node) are one vertex, and METIS orders the vertices by nested
dissection. In the elimination tree i stands above j < i where only vertices up to i connect them (Liu, SIAM J. Matrix
Anal. Appl. 11, 1990). A minimum spanning tree of edges that weigh as much as the later of their ends keeps these
connections, so that the elimination tree follows from n - 1 edges. Supernodes are its subtrees of at most ``LEAF`` vertices
and, above them, its chains of only children, which are the separators.
"""

from __future__ import annotations

import signal
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree

from rollbench.meshes.arrays import Index

#: Vertices of a subtree that is eliminated at once, as dense as it then is.
LEAF = 32


class Supernodes(NamedTuple):
    """Symbolic factor: ``order[i]`` is the i-th freedom to eliminate; supernode k has the columns ``first[k]`` to
    ``first[k + 1]`` and the rows ``rows[start[k]:start[k + 1]]``, sorted, its own columns first."""

    order: Index
    first: Index
    start: Index
    rows: Index


def supernodes(K: sp.csc_array) -> Supernodes:
    """Supernodes of a matrix of symmetric pattern, shape (n, n)."""
    graph, group = vertices(K)
    dissected = _dissected(graph, group)
    tree = _elimination_tree(graph[dissected][:, dissected])
    order = dissected[(later := _postorder(tree))]
    first = _first_columns(_renamed(tree, later))
    rows = _rows(graph[order][:, order], first)
    # from vertices to their freedoms
    freedoms, weights = np.argsort(group, kind="stable"), np.bincount(group)
    begin = np.concatenate([[0], np.cumsum(weights)])
    place = np.concatenate([[0], np.cumsum(weights[order])])
    at = np.concatenate(rows)
    starts = np.concatenate([[0], np.cumsum(weights[order[at]])])
    return Supernodes(
        freedoms[_ranges(begin[order], weights[order])],
        place[first],
        starts[np.concatenate([[0], np.cumsum([row.size for row in rows])])],
        _ranges(place[at], weights[order[at]]),
    )


def vertices(K: sp.csc_array) -> tuple[sp.csr_array, Index]:
    """Compressed graph of a matrix, without its diagonal, and the vertex of every freedom, shape (n,).

    The graph is symmetric, as elimination needs it, also where round-off left an entry on only one side of the diagonal.
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


def _dissected(graph: sp.csr_array, group: Index) -> Index:
    """Order of the vertices of a compressed graph by nested dissection.

    METIS takes SIGTERM for an error of its own, and leaves it blocked. So it is asked a second time after an error: what
    recurs is an error and is raised, else the signal is unblocked and given back.
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
    """Parents of vertices that are eliminated in their order, ``(n,)``; n for a root.

    >>> _elimination_tree(sp.csr_array(np.array([[0, 0, 1, 0], [0, 0, 1, 1], [1, 1, 0, 0], [0, 1, 0, 0]])))
    array([2, 2, 3, 4])
    """
    n = graph.shape[0]
    edges = sp.tril(graph, -1).tocoo()
    spanning = minimum_spanning_tree(sp.csr_array((edges.row.astype(float), (edges.row, edges.col)), (n, n))).tocoo()
    parent, top = [n] * n, list(range(n))  # top: on the way to the highest vertex that is connected so far
    ascending = np.argsort(spanning.row, kind="stable")
    for i, j in zip(spanning.row[ascending].tolist(), spanning.col[ascending].tolist(), strict=True):
        while top[j] != j:
            top[j] = top[top[j]]
            j = top[j]
        parent[j] = top[j] = i
    return np.array(parent, dtype=np.int64)


def _postorder(parent: Index) -> Index:
    """Order of the vertices in which every subtree stands together, its root last."""
    n = parent.size
    down = sp.csr_array((np.ones(n), (parent, np.arange(n))), (n + 1, n + 1))
    return np.asarray(depth_first_order(down, n, return_predecessors=False)[:0:-1], dtype=np.int64)


def _renamed(parent: Index, order: Index) -> Index:
    """Parents by places in an order."""
    place = np.empty(parent.size + 1, dtype=np.int64)
    place[order], place[-1] = np.arange(order.size), order.size
    return np.asarray(place[parent[order]])


def _first_columns(parent: Index) -> Index:
    """First vertices of the supernodes of a tree in postorder, and the number of all vertices at the end."""
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


def _rows(graph: sp.csr_array, first: Index) -> list[Index]:
    """Rows of every supernode: its own, those of its graph's edges, and what its children leave."""
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


def _ranges(first: Index, count: Index) -> Index:
    """Ranges of ``count`` numbers from each of ``first`` on, one after another.

    >>> _ranges(np.array([4, 1]), np.array([3, 2]))
    array([4, 5, 6, 1, 2])
    """
    ends = np.cumsum(count)
    return np.arange(ends[-1] if ends.size else 0) + np.repeat(first - ends + count, count)
