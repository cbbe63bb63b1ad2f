"""Solvers against dense algebra, multifrontal elimination against solutions with a stored factor, and refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import cube, distorted, freedoms, stiffness

from rollbench.hifi import linear_algebra
from rollbench.hifi.linear_algebra import (
    FactorError,
    compliance_of_load_columns,
    factorise_positive_definite,
    symmetric_compliance_of_loads,
)

pytestmark = pytest.mark.xdist_group("solvers")


@pytest.fixture(params=["fronts", "splu"])
def _method(request, monkeypatch):
    """How matrices of any size are solved."""
    monkeypatch.setattr(linear_algebra, "SMALL", 0 if request.param == "fronts" else 10**6)


@pytest.fixture(scope="module")
def held():
    """Stiffness of a cube held on one face."""
    points, cells = cube("Q2", 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    return stiffness(distorted(points), cells, "Q2", 210e9, 0.3).tocsr()[loose][:, loose].tocsc()


def shifted(K):
    """A matrix with negative eigenvalues."""
    return K - 0.01 * K.diagonal().max() * sp.identity(K.shape[0])


@pytest.mark.usefixtures("_method")
def test_solution_is_the_dense_one_and_matrices_that_are_not_positive_definite_are_refused(held):
    K = held
    rhs = np.random.default_rng(0).standard_normal((K.shape[0], 3))
    solve = factorise_positive_definite(K)
    x = solve(rhs)
    assert np.linalg.norm(K @ x - rhs) < 1e-13 * np.linalg.norm(rhs)
    np.testing.assert_allclose(x, np.linalg.solve(K.toarray(), rhs), atol=1e-8 * abs(x).max())
    np.testing.assert_allclose(solve(rhs[:, 1]), x[:, 1], atol=1e-8 * abs(x).max())
    for bad, why in (
        (shifted(K), "not positive definite"),
        (stiffness(*cube("P1", 3), "P1", 210e9, 0.3), r"singular|not positive definite"),
        (sp.block_diag([K, sp.csc_matrix((3, 3))]), f"diagonal entry {K.shape[0]} is 0"),
    ):
        with pytest.raises(FactorError, match=why):
            factorise_positive_definite(bad)


@pytest.mark.parametrize("small", [0, 3_000])
@pytest.mark.parametrize("columns", [1, 40])
def test_gram_is_dense_algebra(held, small, columns, monkeypatch):
    monkeypatch.setattr(linear_algebra, "SMALL", small)
    B = sp.random(held.shape[0], columns, 0.05, random_state=1, format="csc")
    exact = B.T @ np.linalg.solve(held.toarray(), B.toarray())
    with monkeypatch.context() as patch:
        if small == 0:
            patch.setattr(linear_algebra, "factorise_positive_definite", None)  # front by front no factor is held
        np.testing.assert_allclose(compliance_of_load_columns(held, B), exact, atol=1e-12 * abs(exact).max())
    with pytest.raises(FactorError, match="not positive definite"):
        compliance_of_load_columns(shifted(held), B)


@pytest.mark.parametrize("count", [3, 12])
def test_compliance_is_dense_algebra_and_needs_a_held_body(held, count):
    rows = sp.random(count, held.shape[0], 0.05, random_state=2, format="csr")
    exact = rows @ np.linalg.solve(held.toarray(), rows.toarray().T)
    np.testing.assert_allclose(symmetric_compliance_of_loads(held, rows), exact, atol=1e-12 * abs(exact).max())
    assert symmetric_compliance_of_loads(held, rows[:0]).shape == (0, 0)
    free = stiffness(*cube("P1", 3), "P1", 210e9, 0.3)
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        symmetric_compliance_of_loads(free, sp.random(count, free.shape[0], 0.05, random_state=2, format="csr"))


def body(count, held=0.1):
    """Stiffness of a grid of count^3 nodes with three freedoms each, coupled, on soft ground."""
    links = sp.diags([-np.ones(count - 1), np.ones(count - 1)], [0, 1], shape=(count - 1, count))
    chain = links.T @ links
    grid = sp.kronsum(sp.kronsum(chain, chain), chain)
    coupled = np.array([[2.0, 0.3, 0.1], [0.3, 1.5, 0.2], [0.1, 0.2, 1.8]])
    return sp.csc_matrix(sp.kron(grid, coupled) + held * sp.identity(3 * count**3))


def loads(size, columns):
    return sp.random(size, columns, 0.01, random_state=3, format="csc")


@pytest.fixture
def _streamed(monkeypatch):
    monkeypatch.setattr(linear_algebra, "SMALL", 0)


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("seed", [5, 9])
def test_round_off_on_one_side_of_the_diagonal_goes_nowhere_else(seed):
    """Entries of products C^T K C cancel to zero on one side and to round-off on the other, where they have no row."""
    K, B = body(6), loads(648, 40)
    expected = compliance_of_load_columns(K, B)
    row, column = np.random.default_rng(seed).integers(648, size=(2, 4))
    one_sided = sp.csc_matrix((np.full(4, 1e-17), (row, column)), shape=K.shape)
    np.testing.assert_allclose(compliance_of_load_columns(K + one_sided, B), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("held", [0.0, -0.5])
def test_a_body_that_is_not_held_is_refused(held):
    with pytest.raises(FactorError):
        compliance_of_load_columns(body(5, held), loads(375, 10))


@pytest.mark.usefixtures("_streamed")
def test_a_known_answer_that_is_missed_is_said_and_a_factor_serves(monkeypatch):
    K, B = body(5), loads(375, 12)
    expected = compliance_of_load_columns(K, B)
    real = linear_algebra.compliance_by_elimination
    monkeypatch.setattr(linear_algebra, "compliance_by_elimination", lambda *a: 1.001 * real(*a))
    with pytest.warns(RuntimeWarning, match="misses a known solution by 0.001"):
        np.testing.assert_allclose(compliance_of_load_columns(K, B), expected, atol=1e-12 * np.abs(expected).max())
