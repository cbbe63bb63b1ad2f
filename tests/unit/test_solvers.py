"""Solvers against dense algebra, their refusals, and eliminations by C^T K C."""

import numpy as np
import pytest
import scipy.sparse as sp

from hifi import solvers
from hifi.constraints import Rows, expand, reduce
from hifi.elasticity import rigid_modes, stiffness
from hifi.elements import ELEMENTS
from hifi.solvers import FactorError, factor, nested_dissection
from tests.fe_meshes import cube, distorted, freedoms

METHODS = ["cholmod", "splu", "amg"]


@pytest.fixture(scope="module")
def held():
    """Stiffness of a cube held on one face, and the rigid-body modes of its free freedoms."""
    points, cells = cube("Q2", 3)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    K = stiffness(distorted(points), cells, "Q2", 210e9, 0.3).tocsr()[loose][:, loose]
    return K.tocsc(), rigid_modes(distorted(points))[loose]


@pytest.mark.parametrize("method", METHODS)
def test_solution_is_the_dense_one(held, method):
    K, modes = held
    rhs = np.random.default_rng(0).standard_normal((K.shape[0], 3))
    f = factor(K, method=method, modes=modes)
    x = f.solve(rhs)
    assert np.linalg.norm(K @ x - rhs) < (1e-10 if method == "amg" else 1e-13) * np.linalg.norm(rhs)
    np.testing.assert_allclose(x, np.linalg.solve(K.toarray(), rhs), atol=1e-8 * abs(x).max())
    assert f.solve(rhs[:, 1]).shape == (K.shape[0],)
    np.testing.assert_allclose(f.solve(rhs[:, 1]), x[:, 1], atol=1e-8 * abs(x).max())
    assert f.solve(rhs[:, :0]).shape == (K.shape[0], 0)
    assert (f.method, f.size) == (method, K.shape[0])
    assert f.seconds > 0.0
    assert f.nonzeros > K.nnz // 2
    np.testing.assert_allclose(f.solve(rhs), x, atol=1e-8 * abs(x).max())  # counting leaves the factor whole
    with pytest.raises(ValueError, match="right-hand side has shape"):
        f.solve(rhs[:-1])


def test_automatic_choice(held, monkeypatch):
    K, modes = held
    assert factor(K).method == "splu"
    monkeypatch.setattr(solvers, "SMALL", 100)
    assert factor(K).method == "cholmod"
    monkeypatch.setattr(solvers, "LARGE", 200)
    assert factor(K, modes=modes, columns=3).method == "amg"
    assert factor(K, modes=modes, columns=300).method == "cholmod"
    monkeypatch.setattr(solvers, "find_spec", lambda name: None if name == "cvxopt" else True)
    assert factor(K, modes=modes).method == "amg"
    assert factor(K).method == "splu"


def elimination_fill(K, order):
    """Entries of the Cholesky factor of the nodes in that order, by eliminating one after the other."""
    nodes = list(dict.fromkeys((np.asarray(order) // 3).tolist()))
    graph = sp.csr_matrix((np.ones(K.nnz), (K.tocoo().row // 3, K.tocoo().col // 3)))
    neighbours = [
        set(graph.indices[a:b]) - {k} for k, (a, b) in enumerate(zip(graph.indptr, graph.indptr[1:], strict=False))
    ]
    total = 0
    for k in nodes:
        rest = neighbours[k]
        total += 1 + len(rest)
        for other in rest:
            neighbours[other] |= rest
            neighbours[other] -= {k, other}
    return total


def test_nested_dissection_orders_whole_nodes_and_saves_fill():
    points, cells = cube("P2", 5)
    loose = freedoms(np.flatnonzero(points[:, 2] > 0.0))
    K = stiffness(points, cells, "P2", 1.0, 0.3).tocsr()[loose][:, loose].tocsc()
    order = nested_dissection(K)
    np.testing.assert_array_equal(np.sort(order), np.arange(K.shape[0]))
    assert np.all(np.ptp(order.reshape(-1, 3) // 3, axis=1) == 0)
    # CHOLMOD tries AMD beside the given order, so the fill of an order is counted here.
    fill = [elimination_fill(K, p) for p in (order, np.arange(K.shape[0]), np.argsort(order))]
    assert fill[0] < 0.8 * min(fill[1:])


@pytest.mark.parametrize("method", ["cholmod", "splu"])
def test_matrices_that_are_not_positive_definite_are_refused(held, method):
    K, _ = held
    shifted = K - 0.01 * K.diagonal().max() * sp.identity(K.shape[0])
    with pytest.raises(FactorError, match="not positive definite"):
        factor(shifted, method=method)
    points, cells = cube("P1", 3)
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        factor(stiffness(points, cells, "P1", 210e9, 0.3), method=method)
    unused = sp.block_diag([K, sp.csc_matrix((3, 3))])
    with pytest.raises(FactorError, match=f"diagonal entry {K.shape[0]} is 0"):
        factor(unused, method=method)


def test_multigrid_refuses_without_modes_and_gives_up_loudly(held):
    K, modes = held
    with pytest.raises(ValueError, match="rigid-body modes"):
        factor(K, method="amg")
    with pytest.raises(FactorError, match="conjugate gradients"):
        factor(K, method="amg", modes=modes, tolerance=1e-30).solve(np.ones(K.shape[0]))


def test_unknown_method_and_shape_are_refused(held):
    with pytest.raises(ValueError, match="one of auto, cholmod"):
        factor(held[0], method="pardiso")
    with pytest.raises(ValueError, match="square"):
        factor(held[0][:5])


def stacked(weights_of):
    """Two Q1 cubes, the upper one with a finer grid, tied at z = 1; returns points, K, slaves, masters, weights."""
    lower, lower_cells = cube("Q1", 2)
    upper, upper_cells = cube("Q1", 4)
    points = np.vstack([lower, upper + np.array([0.0, 0.0, 1.0])])
    K = sp.block_diag(
        [stiffness(lower, lower_cells, "Q1", 1.0, 0.3), stiffness(upper, upper_cells, "Q1", 1.0, 0.3)], format="csr"
    )
    slaves = len(lower) + np.flatnonzero(upper[:, 2] < 1e-12)
    masters, weights = [], []
    for x, y, _ in points[slaves]:
        i, j = min(int(2 * x), 1), min(int(2 * y), 1)
        square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        masters.append([9 * a + 3 * b + 2 for a, b in square])
        weights.append(ELEMENTS["quad4"].shape(np.array([[4 * x - 2 * i - 1, 4 * y - 2 * j - 1]]))[0])
    return points, K, slaves, np.array(masters), weights_of(np.array(weights))


def test_tied_grids_pass_the_patch_test():
    points, K, slaves, masters, weights = stacked(lambda w: w)
    exact = (points @ (1e-3 * np.arange(1.0, 10.0).reshape(3, 3))).ravel()
    rows = Rows(3 * len(points))
    rows.tie(slaves, masters, weights)
    outer = np.any((points[:, :2] < 1e-12) | (points[:, :2] > 1 - 1e-12), axis=1)
    outer |= (points[:, 2] < 1e-12) | (points[:, 2] > 2 - 1e-12)
    outer[slaves] = False
    held = freedoms(np.flatnonzero(outer))
    rows.fix(held, exact[held])
    c = rows.constraint()
    small, load = reduce(K, None, c)
    assert abs(small - small.T).max() == 0.0
    np.testing.assert_allclose(expand(factor(small).solve(load), c), exact, atol=1e-15)
    force = np.random.default_rng(0).standard_normal(len(exact))
    np.testing.assert_allclose(reduce(K, force, c)[1], c.basis.T @ (force - K @ c.constant), atol=1e-15)


def test_tie_refuses_weights_that_strain_rigid_motion():
    points, _, slaves, masters, weights = stacked(lambda w: 1.001 * w)
    with pytest.raises(ValueError, match=r"miss the sum 1 by 0\.001"):
        Rows(3 * len(points)).tie(slaves, masters, weights)


def test_rigid_section_carries_force_and_moment():
    """Bar under tension on a rigid section; bending by a moment: rotation and reaction against the full system."""
    points, cells = cube("Q2", 2)
    K = stiffness(points, cells, "Q2", 1.0, 0.0)
    end, centre = np.flatnonzero(points[:, 2] > 1 - 1e-12), np.array([0.5, 0.5, 1.0])
    rows = Rows(3 * len(points))
    section = rows.rigid(points, end, centre)
    rows.fix(freedoms(np.flatnonzero(points[:, 2] < 1e-12)))
    rows.fix(section[5:])  # a chain: nodes follow the section, its twist is prescribed
    c = rows.constraint()
    small, load = reduce(K, np.zeros(3 * len(points)), c)
    y = np.array([factor(small).solve(load + 1e-3 * (c.free == freedom)) for freedom in section[[2, 3]]]).T
    u = expand(y, c)
    stretch = y[c.free == section[2], 0]
    assert stretch == pytest.approx(1e-3, rel=1e-12)  # F L / (E A), exact without Poisson's ratio
    turn = y[c.free == section[3], 1]
    expected = turn[0] * np.cross([1.0, 0.0, 0.0], points[end] - centre) + y[np.isin(c.free, section[:3]), 1]
    np.testing.assert_allclose(u[:, 1].reshape(-1, 3)[end], expected, atol=1e-15)
    modes = rigid_modes(points[end], centre)
    reaction = modes.T @ (K @ u)[freedoms(end)]
    np.testing.assert_allclose(reaction[:5, 1], [0.0, 0.0, 0.0, 1e-3, 0.0], atol=1e-14)
    assert turn == pytest.approx(12e-3, rel=0.03)  # M L / (E I), warping held at both ends


def test_chains_are_substituted_and_loops_refused():
    rows = Rows(4)
    rows.eliminate([0], sp.csr_matrix([[0.0, 2.0, 0.0, 0.0]]), 1.0)
    rows.eliminate([1], sp.csr_matrix([[0.0, 0.0, 3.0, 0.0]]), 10.0)
    rows.eliminate([2], sp.csr_matrix([[0.0, 0.0, 0.0, 5.0]]), 100.0)
    c = rows.constraint()
    np.testing.assert_array_equal(c.free, [3])
    np.testing.assert_allclose(expand(np.array([7.0]), c), [2 * (3 * 135 + 10) + 1, 3 * 135 + 10, 135, 7])
    rows.eliminate([3], sp.csr_matrix([[0.5, 0.0, 0.0, 0.0]]))
    with pytest.raises(ValueError, match="loop"):
        rows.constraint()
    rows = Rows(2)
    rows.fix([0])
    rows.fix([0])
    with pytest.raises(ValueError, match="enslaved twice"):
        rows.constraint()
