"""The last rows of a sparse factor against a dense Cholesky factor."""

import datetime

import numpy as np
import pytest
import scipy.sparse as sp
from cvxopt import cholmod, matrix, spmatrix

from hifi.factor_view import trailing


def grid(n, seed=0):
    """Stiffness of a cube of springs with ``n`` nodes on an edge, and a few full rows at its end, positive definite."""
    line = sp.diags([2.2 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1])
    one = sp.identity(n)
    K = sp.kron(sp.kron(line, one), one) + sp.kron(sp.kron(one, line), one) + sp.kron(sp.kron(one, one), line)
    B = 0.1 * np.random.default_rng(seed).standard_normal((7, n**3))
    return sp.bmat([[K, B.T], [B, 10.0 * np.eye(7)]]).tocoo()


@pytest.fixture
def supernodal():
    """CHOLMOD's options for a factor by dense blocks near the matrix's own order, put back afterwards."""
    before = dict(cholmod.options)
    cholmod.options.update(supernodal=2, nmethods=1)
    yield
    cholmod.options.clear()
    cholmod.options.update(before)


def factored(K):
    lower = sp.tril(K).tocoo()
    A = spmatrix(matrix(lower.data), matrix(lower.row.astype(int)), matrix(lower.col.astype(int)), K.shape, tc="d")
    F = cholmod.symbolic(A, p=matrix(np.arange(K.shape[0])))
    cholmod.numeric(A, F)
    order = matrix(np.arange(float(K.shape[0])))
    cholmod.solve(F, order, sys=7)  # it sorts the rows of the tree that it eliminates
    own = np.array(order).ravel().astype(int)
    return F, np.linalg.cholesky(K.toarray()[np.ix_(own, own)])


@pytest.mark.usefixtures("supernodal")
@pytest.mark.parametrize("count", [1, 3, 7, 12, 60])
def test_like_a_dense_factor(count):
    """Fewer rows than the last dense block of columns has, as many, and more than one block."""
    factor, whole = factored(grid(5))
    found = trailing(factor, len(whole), count)
    assert found is not None
    wanted = whole[-count:, -count:]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())


@pytest.mark.usefixtures("supernodal")
def test_whole():
    factor, whole = factored(grid(4))
    np.testing.assert_allclose(trailing(factor, len(whole), len(whole)), whole, rtol=0, atol=1e-13)


@pytest.mark.usefixtures("supernodal")
def test_another_size_or_kind_of_factor_is_refused():
    factor, whole = factored(grid(4))
    assert trailing(factor, len(whole) + 1, 3) is None
    cholmod.options["supernodal"] = 0  # L D L^T, column by column
    factor, whole = factored(grid(4))
    assert trailing(factor, len(whole), 3) is None


def test_another_capsule_is_refused():
    assert trailing(datetime.datetime_CAPI, 3, 1) is None
