"""Solvers against dense algebra, and their refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import cube, distorted, freedoms, stiffness

from rollbench.hifi.linear_algebra import solvers
from rollbench.hifi.linear_algebra.solvers import FactorError, compliance, factor, gram

pytestmark = pytest.mark.xdist_group("solvers")


@pytest.fixture(params=["fronts", "splu"])
def _method(request, monkeypatch):
    """How matrices of any size are solved."""
    monkeypatch.setattr(solvers, "SMALL", 0 if request.param == "fronts" else 10**6)


@pytest.fixture(scope="module")
def held():
    """Stiffness of a cube held on one face."""
    points, cells = cube("Q2", 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    return stiffness(distorted(points), cells, "Q2", 210e9, 0.3).tocsr()[loose][:, loose].tocsc()


@pytest.mark.usefixtures("_method")
def test_solution_is_the_dense_one(held):
    K = held
    rhs = np.random.default_rng(0).standard_normal((K.shape[0], 3))
    solve = factor(K)
    x = solve(rhs)
    assert np.linalg.norm(K @ x - rhs) < 1e-13 * np.linalg.norm(rhs)
    np.testing.assert_allclose(x, np.linalg.solve(K.toarray(), rhs), atol=1e-8 * abs(x).max())
    np.testing.assert_allclose(solve(rhs[:, 1]), x[:, 1], atol=1e-8 * abs(x).max())


@pytest.mark.usefixtures("_method")
def test_matrices_that_are_not_positive_definite_are_refused(held):
    K = held
    shifted = K - 0.01 * K.diagonal().max() * sp.identity(K.shape[0])
    with pytest.raises(FactorError, match="not positive definite"):
        factor(shifted)
    points, cells = cube("P1", 3)
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        factor(stiffness(points, cells, "P1", 210e9, 0.3))
    unused = sp.block_diag([K, sp.csc_matrix((3, 3))])
    with pytest.raises(FactorError, match=f"diagonal entry {K.shape[0]} is 0"):
        factor(unused)


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
