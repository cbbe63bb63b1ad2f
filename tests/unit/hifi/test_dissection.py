"""Order, elimination tree and supernodes of sparse matrices, against the pattern of a dense elimination."""

import signal

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import cube, freedoms, stiffness

from rollbench.hifi import linear_algebra
from rollbench.hifi.linear_algebra import find_elimination_order


def grid(n: int) -> sp.csc_matrix:
    """A cube of springs with ``n`` nodes on an edge, three freedoms each, all coupled."""
    line = sp.diags([2.2 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1])
    return sp.csc_matrix(sp.kron(sp.kronsum(sp.kronsum(line, line), line), np.eye(3) + 0.2))


def body() -> sp.csc_matrix:
    """Stiffness of a cube of second-order tetrahedra held on one face."""
    points, cells = cube("P2", 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    return stiffness(points, cells, "P2", 1.0, 0.3).tocsr()[loose][:, loose].tocsc()


def apart() -> sp.csc_matrix:
    """Two bodies that do not touch, and three freedoms alone."""
    return sp.csc_matrix(sp.block_diag([grid(3), grid(4), sp.identity(3)]))


def filled(K: sp.csc_matrix, order: np.ndarray) -> np.ndarray:
    """Which entries of the Cholesky factor of a matrix in that order are not zero, by eliminating one after the other."""
    pattern = K[order][:, order].toarray() != 0.0
    for k in range(len(pattern)):
        below = k + 1 + np.flatnonzero(pattern[k + 1 :, k])
        pattern[np.ix_(below, below)] = True
    return np.tril(pattern)


@pytest.mark.parametrize("leaf", [1, 6, 32])
@pytest.mark.parametrize("matrix", [grid(5), body(), apart()], ids=["grid", "body", "apart"])
def test_the_supernodes_hold_the_factor_and_little_more(matrix, leaf, monkeypatch):
    monkeypatch.setattr(linear_algebra, "LEAF", leaf)
    nodes = find_elimination_order(matrix)
    n = matrix.shape[0]
    np.testing.assert_array_equal(np.sort(nodes.elimination_order), np.arange(n))
    assert np.all(np.ptp(nodes.elimination_order.reshape(-1, 3) // 3, axis=1) == 0)  # whole nodes
    assert (nodes.first_columns[0], nodes.first_columns[-1], nodes.row_starts[-1]) == (0, n, nodes.rows_of_supernodes.size)
    held = np.zeros((n, n), dtype=bool)
    for k in range(nodes.first_columns.size - 1):
        low, high = nodes.first_columns[k : k + 2]
        rows = nodes.rows_of_supernodes[nodes.row_starts[k] : nodes.row_starts[k + 1]]
        assert np.all(np.diff(rows) > 0)
        np.testing.assert_array_equal(rows[: high - low], np.arange(low, high))
        held[np.ix_(rows, np.arange(low, high))] = True
    factor = filled(matrix, nodes.elimination_order)
    held = np.tril(held)
    assert not np.any(factor & ~held)
    assert held.sum() <= {1: 1.05, 6: 1.8, 32: 3.0}[leaf] * factor.sum()


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals of POSIX")
def test_term_during_the_ordering_ends_as_elsewhere(monkeypatch) -> None:
    """METIS turns SIGTERM into an error of its own and leaves it blocked."""
    calls = []

    def metis(*args: object, **_: object) -> tuple[np.ndarray, np.ndarray]:
        calls.append(args)
        if len(calls) == 1:
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
            raise RuntimeError("Caught an unknown exception!")
        return np.arange(125), np.arange(125)

    def ended(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pymetis.nested_dissection", metis)
    before = signal.signal(signal.SIGTERM, ended)
    try:
        with pytest.raises(KeyboardInterrupt):
            find_elimination_order(grid(5))
    finally:
        signal.signal(signal.SIGTERM, before)
        assert signal.SIGTERM not in signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    assert len(calls) == 2
