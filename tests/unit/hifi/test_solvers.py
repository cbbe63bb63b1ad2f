"""Sparse matrices: order and supernodes against the pattern of a dense elimination, solvers against dense algebra,
multifrontal elimination against solutions with a stored factor, and refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import cube, distorted, freedoms, stiffness

from rollbench.hifi import linear_algebra
from rollbench.hifi.linear_algebra import FactorError, compliance_of_load_columns, factorise_positive_definite

pytestmark = pytest.mark.xdist_group("solvers")


def springs(count: int, held: float = 0.1) -> sp.csc_matrix:
    """Stiffness of a grid of count^3 nodes with three freedoms each, coupled, on soft ground."""
    links = sp.diags([-np.ones(count - 1), np.ones(count - 1)], [0, 1], shape=(count - 1, count))
    chain = links.T @ links
    grid = sp.kronsum(sp.kronsum(chain, chain), chain)
    coupled = np.array([[2.0, 0.3, 0.1], [0.3, 1.5, 0.2], [0.1, 0.2, 1.8]])
    return sp.csc_matrix(sp.kron(grid, coupled) + held * sp.identity(3 * count**3))


def loads(size: int, columns: int, density: float = 0.05) -> sp.csc_matrix:
    return sp.random(size, columns, density, random_state=1, format="csc")


def body(kind: str) -> sp.csc_matrix:
    """Stiffness of a cube with curved sides, held on one face."""
    points, cells = cube(kind, 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    return stiffness(distorted(points), cells, kind, 210e9, 0.3).tocsr()[loose][:, loose].tocsc()


@pytest.fixture(scope="module")
def held():
    return body("Q2")


@pytest.fixture(scope="module")
def refused(held):
    """Matrices that are not positive definite, and why: negative eigenvalues, a free body, nodes without a cell."""
    below = held - 0.01 * held.diagonal().max() * sp.identity(held.shape[0])
    return (
        (below, "not positive definite"),
        (stiffness(*cube("P1", 3), "P1", 210e9, 0.3), r"singular|not positive definite"),
        (sp.block_diag([held, sp.csc_matrix((3, 3))]), f"diagonal entry {held.shape[0]} is 0"),
        (springs(5, 0.0), r"singular|not positive definite"),
    )


@pytest.fixture(params=["fronts", "splu"])
def _method(request, monkeypatch):
    """How matrices of any size are solved."""
    monkeypatch.setattr(linear_algebra, "SMALL", 0 if request.param == "fronts" else 10**6)


@pytest.fixture
def _streamed(monkeypatch):
    monkeypatch.setattr(linear_algebra, "SMALL", 0)


@pytest.mark.usefixtures("_method")
def test_solution_is_the_dense_one_and_matrices_that_are_not_positive_definite_are_refused(held, refused):
    rhs = np.random.default_rng(0).standard_normal((held.shape[0], 3))
    solve = factorise_positive_definite(held)
    x = solve(rhs)
    assert np.linalg.norm(held @ x - rhs) < 1e-13 * np.linalg.norm(rhs)
    np.testing.assert_allclose(x, np.linalg.solve(held.toarray(), rhs), atol=1e-8 * abs(x).max())
    np.testing.assert_allclose(solve(rhs[:, 1]), x[:, 1], atol=1e-8 * abs(x).max())
    for bad, why in refused:
        with pytest.raises(FactorError, match=why):
            factorise_positive_definite(bad)


@pytest.mark.usefixtures("_method")
@pytest.mark.parametrize("columns", [1, 12, 40])
def test_compliance_of_loads_is_dense_algebra_and_needs_a_held_body(held, refused, columns, monkeypatch):
    B = loads(held.shape[0], columns)
    exact = B.T @ np.linalg.solve(held.toarray(), B.toarray())
    with monkeypatch.context() as patch:
        if linear_algebra.SMALL == 0:
            patch.setattr(linear_algebra, "factorise_positive_definite", None)  # front by front no factor is held
        found = compliance_of_load_columns(held, B), linear_algebra.symmetric_compliance_of_loads(held, B.T)
    np.testing.assert_allclose(found, [exact, exact], atol=1e-12 * abs(exact).max())
    assert linear_algebra.symmetric_compliance_of_loads(held, B.T[:0]).shape == (0, 0)
    for bad, why in refused:
        with pytest.raises(FactorError, match=why):
            compliance_of_load_columns(bad, loads(bad.shape[0], columns))


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("seed", [5, 9])
def test_round_off_on_one_side_of_the_diagonal_goes_nowhere_else(seed):
    """Entries of products C^T K C cancel to zero on one side and to round-off on the other, where they have no row."""
    K, B = springs(6), loads(648, 40, 0.01)
    expected = compliance_of_load_columns(K, B)
    row, column = np.random.default_rng(seed).integers(648, size=(2, 4))
    one_sided = sp.csc_matrix((np.full(4, 1e-17), (row, column)), shape=K.shape)
    np.testing.assert_allclose(compliance_of_load_columns(K + one_sided, B), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.usefixtures("_streamed")
def test_a_known_answer_that_is_missed_is_said_and_a_factor_serves(monkeypatch):
    K, B = springs(5), loads(375, 12, 0.01)
    expected = compliance_of_load_columns(K, B)
    real = linear_algebra.compliance_by_elimination
    monkeypatch.setattr(linear_algebra, "compliance_by_elimination", lambda *a: 1.001 * real(*a))
    with pytest.warns(RuntimeWarning, match="misses a known solution by 0.001"):
        np.testing.assert_allclose(compliance_of_load_columns(K, B), expected, atol=1e-12 * np.abs(expected).max())
