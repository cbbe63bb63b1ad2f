"""Solvers against dense algebra, and their refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import cube, distorted, freedoms, stiffness

from rollbench.hifi.linear_algebra import solvers
from rollbench.hifi.linear_algebra.response import compliance
from rollbench.hifi.linear_algebra.solvers import FactorError, factor, gram

pytestmark = pytest.mark.xdist_group("solvers")

METHODS = ["fronts", "splu"]


@pytest.fixture(scope="module")
def held():
    """Stiffness of a cube held on one face."""
    points, cells = cube("Q2", 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    return stiffness(distorted(points), cells, "Q2", 210e9, 0.3).tocsr()[loose][:, loose].tocsc()


@pytest.mark.parametrize("method", METHODS)
def test_solution_is_the_dense_one(held, method):
    K = held
    rhs = np.random.default_rng(0).standard_normal((K.shape[0], 3))
    f = factor(K, method=method)
    x = f.solve(rhs)
    assert np.linalg.norm(K @ x - rhs) < 1e-13 * np.linalg.norm(rhs)
    np.testing.assert_allclose(x, np.linalg.solve(K.toarray(), rhs), atol=1e-8 * abs(x).max())
    assert f.solve(rhs[:, 1]).shape == (K.shape[0],)
    np.testing.assert_allclose(f.solve(rhs[:, 1]), x[:, 1], atol=1e-8 * abs(x).max())
    assert f.solve(rhs[:, :0]).shape == (K.shape[0], 0)
    assert (f.method, f.size) == (method, K.shape[0])
    with pytest.raises(ValueError, match="right-hand side has shape"):
        f.solve(rhs[:-1])


def test_automatic_choice(held, monkeypatch):
    assert factor(held).method == "splu"
    monkeypatch.setattr(solvers, "SMALL", 100)
    assert factor(held).method == "fronts"


@pytest.mark.parametrize("method", ["fronts", "splu"])
def test_matrices_that_are_not_positive_definite_are_refused(held, method):
    K = held
    shifted = K - 0.01 * K.diagonal().max() * sp.identity(K.shape[0])
    with pytest.raises(FactorError, match="not positive definite"):
        factor(shifted, method=method)
    points, cells = cube("P1", 3)
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        factor(stiffness(points, cells, "P1", 210e9, 0.3), method=method)
    unused = sp.block_diag([K, sp.csc_matrix((3, 3))])
    with pytest.raises(FactorError, match=f"diagonal entry {K.shape[0]} is 0"):
        factor(unused, method=method)


def test_unknown_method_and_shape_are_refused(held):
    with pytest.raises(ValueError, match="one of auto, fronts"):
        factor(held, method="pardiso")
    with pytest.raises(ValueError, match="square"):
        factor(held[:5])


@pytest.mark.parametrize("small", [0, 3_000])
def test_gram_is_dense_algebra(held, small, monkeypatch):
    monkeypatch.setattr(solvers, "SMALL", small)
    B = sp.random(held.shape[0], 40, 0.05, random_state=1, format="csc")
    exact = B.T @ np.linalg.solve(held.toarray(), B.toarray())
    np.testing.assert_allclose(gram(held, B), exact, atol=1e-12 * abs(exact).max())
    with pytest.raises(FactorError, match="not positive definite"):
        gram(held - 0.01 * held.diagonal().max() * sp.identity(held.shape[0]), B)


@pytest.mark.parametrize("count", [3, 12])
def test_compliance_is_dense_algebra_and_needs_a_held_body(held, count):
    rows = sp.random(count, held.shape[0], 0.05, random_state=2, format="csr")
    exact = rows @ np.linalg.solve(held.toarray(), rows.toarray().T)
    np.testing.assert_allclose(compliance(held, rows), exact, atol=1e-12 * abs(exact).max())
    free = stiffness(*cube("P1", 3), "P1", 210e9, 0.3)
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        compliance(free, sp.random(count, free.shape[0], 0.05, random_state=2, format="csr"))
