"""Elimination front by front: equal to dense algebra and to solves with a factor that is held, to round-off."""

import numpy as np
import pytest
import scipy.sparse as sp

from rollbench.hifi.linear_algebra import solvers
from rollbench.hifi.linear_algebra.solvers import FactorError, gram


def body(count: int, held: float = 0.1) -> sp.csc_matrix:
    """Stiffness of a grid of count^3 nodes with three freedoms each, coupled, on soft ground."""
    chain = sp.diags([-np.ones(count - 1), 2.0 * np.ones(count), -np.ones(count - 1)], [-1, 0, 1])
    chain = chain.tolil()
    chain[0, 0] = chain[-1, -1] = 1.0
    one = sp.identity(count)
    grid = sum(
        sp.kron(sp.kron(*pair), last) for pair, last in (((chain, one), one), ((one, chain), one), ((one, one), chain))
    )
    coupled = np.array([[2.0, 0.3, 0.1], [0.3, 1.5, 0.2], [0.1, 0.2, 1.8]])
    return sp.csc_matrix(sp.kron(grid, coupled) + held * sp.identity(3 * count**3))


def loads(size: int, columns: int) -> sp.csc_matrix:
    return sp.random(size, columns, 0.01, random_state=3, format="csc")


@pytest.fixture
def _streamed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solvers, "SMALL", 0)


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("columns", [1, 40])
def test_it_is_dense_algebra(columns: int) -> None:
    K, B = body(6), loads(648, columns)
    dense = B.T @ np.linalg.solve(K.toarray(), B.toarray())
    np.testing.assert_allclose(gram(K, B), dense, atol=1e-12 * np.abs(dense).max())


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("seed", [5, 9])
def test_round_off_on_one_side_of_the_diagonal_goes_nowhere_else(seed: int) -> None:
    """Entries of products C^T K C cancel to zero on one side and to round-off on the other, where they have no row."""
    K, B = body(6), loads(648, 40)
    expected = gram(K, B)
    row, column = np.random.default_rng(seed).integers(648, size=(2, 4))
    one_sided = sp.csc_matrix((np.full(4, 1e-17), (row, column)), shape=K.shape)
    np.testing.assert_allclose(gram(K + one_sided, B), expected, atol=1e-12 * np.abs(expected).max())


def test_it_is_solves_with_a_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    K, B = body(9), loads(2187, 120)
    solved = gram(K, B)  # few freedoms
    monkeypatch.setattr(solvers, "factor", None)  # what follows must not take that way
    monkeypatch.setattr(solvers, "SMALL", 0)
    np.testing.assert_allclose(gram(K, B), solved, atol=1e-12 * np.abs(solved).max())


@pytest.mark.usefixtures("_streamed")
@pytest.mark.parametrize("held", [0.0, -0.5])
def test_a_body_that_is_not_held_is_refused(held: float) -> None:
    with pytest.raises(FactorError):
        gram(body(5, held), loads(375, 10))


@pytest.mark.usefixtures("_streamed")
def test_a_known_answer_that_is_missed_is_said_and_a_factor_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    K, B = body(5), loads(375, 12)
    expected = gram(K, B)
    real = solvers.gram_by_fronts
    monkeypatch.setattr(solvers, "gram_by_fronts", lambda *a: 1.001 * real(*a))
    with pytest.warns(RuntimeWarning, match="a known answer is missed by 0.001 front by front"):
        np.testing.assert_allclose(gram(K, B), expected, atol=1e-12 * np.abs(expected).max())
