"""The supernodes that CHOLMOD shows against the pattern of a dense Cholesky factor."""

import datetime

import numpy as np
import pytest
import scipy.sparse as sp
from cvxopt import cholmod, matrix, spmatrix

from hifi.factor_view import structure


def grid(n):
    """Pattern of a cube of springs with ``n`` nodes on an edge, positive definite."""
    line = sp.diags([2.2 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1])
    one = sp.identity(n)
    return sp.kron(sp.kron(line, one), one) + sp.kron(sp.kron(one, line), one) + sp.kron(sp.kron(one, one), line)


@pytest.fixture
def supernodal():
    """CHOLMOD's options for a factor by dense blocks near the matrix's own order, put back afterwards."""
    before = dict(cholmod.options)
    cholmod.options.update(supernodal=2, nmethods=1)
    yield
    cholmod.options.clear()
    cholmod.options.update(before)


def symbolic(K):
    lower = sp.tril(K).tocoo()
    A = spmatrix(matrix(lower.data), matrix(lower.row.astype(int)), matrix(lower.col.astype(int)), K.shape, tc="d")
    return cholmod.symbolic(A, p=matrix(np.arange(K.shape[0])))


@pytest.mark.usefixtures("supernodal")
def test_the_supernodes_hold_the_factor():
    K = grid(5)
    order, first, start, rows = structure(symbolic(K), K.shape[0])
    assert sorted(order) == list(range(K.shape[0]))
    L = np.linalg.cholesky(K.toarray()[np.ix_(order, order)])
    held = np.zeros(L.shape, dtype=bool)
    for k in range(first.size - 1):
        own = rows[start[k] : start[k + 1]]
        assert list(own[: first[k + 1] - first[k]]) == list(range(first[k], first[k + 1]))
        held[np.ix_(own, np.arange(first[k], first[k + 1]))] = True
    assert not np.any(L[~held])
    assert held.mean() < 0.5


@pytest.mark.usefixtures("supernodal")
def test_another_size_or_kind_of_factor_is_refused():
    K = grid(4)
    assert structure(symbolic(K), K.shape[0] + 1) is None
    cholmod.options["supernodal"] = 0  # L D L^T, column by column
    assert structure(symbolic(K), K.shape[0]) is None


def test_another_capsule_is_refused():
    assert structure(datetime.datetime_CAPI, 3) is None
