"""Exact condensation against the monolithic matrix."""

import numpy as np
import pytest
import scipy.sparse as sp

from hifi import condense as module
from hifi.condense import condense
from hifi.elasticity import rigid_modes, stiffness
from hifi.solvers import FactorError, gram
from tests.fe_meshes import cube, distorted, freedoms


@pytest.fixture(scope="module", params=["P2", "Q2"])
def body(request):
    """Free body, freedoms of its lower face in shuffled order, loads normal to its upper face."""
    points, cells = cube(request.param, 3)
    K = stiffness(distorted(points), cells, request.param, 1.0, 0.3)
    keep = np.random.default_rng(0).permutation(freedoms(np.flatnonzero(points[:, 2] < 1e-12)))
    loaded = 3 * np.flatnonzero(points[:, 2] > 1 - 1e-12) + 2
    m = len(loaded)
    P = sp.csc_matrix((np.linspace(1.0, 2.0, m), (loaded, np.arange(m))), shape=(3 * len(points), m))
    return distorted(points), K, keep, P


def monolithic(K, keep, P, f, q):
    """Displacements and reactions of the full system with q prescribed."""
    n = K.shape[0]
    inside = np.setdiff1d(np.arange(n), keep)
    dense = K.toarray()
    u = np.zeros(n)
    u[keep] = q
    u[inside] = np.linalg.solve(dense[np.ix_(inside, inside)], (P @ f)[inside] - dense[np.ix_(inside, keep)] @ q)
    return u, (dense @ u)[keep]


@pytest.mark.parametrize(("method", "many"), [("cholmod", 0), ("cholmod", 10**6), ("splu", 0)])
def test_condensed_is_monolithic(body, method, many, monkeypatch):
    monkeypatch.setattr(module, "MANY", many)
    _, K, keep, P = body
    rng = np.random.default_rng(1)
    f, q = rng.standard_normal(P.shape[1]), rng.standard_normal(len(keep))
    u, r = monolithic(K, keep, P, f, q)
    c = condense(K, keep, P, method=method)
    assert c.method == method
    motion = c.compliance @ f + c.transfer @ q
    reaction = c.stiffness @ q - c.transfer.T @ f
    np.testing.assert_allclose(motion, P.T @ u, atol=1e-10 * abs(u).max())
    np.testing.assert_allclose(reaction, r, atol=1e-10 * abs(r).max())


def test_condensed_matrices_keep_their_properties(body):
    points, K, keep, P = body
    c = condense(K, keep, P)
    modes = rigid_modes(points)
    assert abs(c.stiffness - c.stiffness.T).max() < 1e-15
    np.testing.assert_allclose(c.stiffness @ modes[keep], 0.0, atol=1e-12)
    assert np.linalg.eigvalsh(c.stiffness)[6] > 1e-6
    np.testing.assert_allclose(c.transfer @ modes[keep], P.T @ modes, atol=1e-12)
    assert np.linalg.eigvalsh(c.compliance)[0] > 0.0


def test_two_condensed_bodies_are_the_monolithic_assembly():
    """Two halves of a bar, condensed on the shared face and on the held one, give the displacements of the whole."""
    points, cells = cube("Q2", 2)
    half = stiffness(points, cells, "Q2", 1.0, 0.3)
    low, high = (np.flatnonzero(np.abs(points[:, 2] - z) < 1e-12) for z in (0.0, 1.0))
    n = len(points)
    above = np.full(n, -1)
    above[low] = high  # nodes of the upper half that are nodes of the lower one
    above[above < 0] = n + np.arange(n - len(low))
    map_up = freedoms(above)
    total = 3 * (2 * n - len(low))
    place = sp.csr_matrix((np.ones(3 * n), (map_up, np.arange(3 * n))), shape=(total, 3 * n))
    whole = place @ half @ place.T + sp.block_diag([half, sp.csr_matrix((total - 3 * n,) * 2)])
    rng = np.random.default_rng(2)
    loaded = 3 * high + 2
    P = sp.csc_matrix((np.ones(len(loaded)), (loaded, np.arange(len(loaded)))), shape=(3 * n, len(loaded)))
    f = rng.standard_normal(len(loaded))
    loose = np.setdiff1d(np.arange(total), freedoms(low))
    u = np.zeros(total)
    u[loose] = np.linalg.solve(whole.toarray()[np.ix_(loose, loose)], (place @ (P @ f))[loose])
    lower = condense(half, np.concatenate([freedoms(low), freedoms(high)]))
    upper = condense(half, freedoms(low), P)
    k = 3 * len(low)
    q = np.linalg.solve(lower.stiffness[k:, k:] + upper.stiffness, upper.transfer.T @ f)
    np.testing.assert_allclose(q, u[freedoms(high)], atol=1e-10 * abs(u).max())
    motion = upper.compliance @ f + upper.transfer @ q
    np.testing.assert_allclose(motion, u[map_up[loaded]], atol=1e-10 * abs(u).max())


def test_forms_of_the_load_basis_and_chunks_agree(body, monkeypatch):
    _, K, keep, P = body
    whole = condense(K, keep, P)
    inside = np.setdiff1d(np.arange(K.shape[0]), keep)
    monkeypatch.setattr(module, "CHUNK_BYTES", 1.0)
    monkeypatch.setattr(module, "MANY", 10**6)
    for basis in (P.tocsr()[inside].toarray(), P.toarray()):
        other = condense(K, keep, basis)
        np.testing.assert_allclose(other.compliance, whole.compliance, atol=1e-13 * abs(whole.compliance).max())
        np.testing.assert_allclose(other.stiffness, whole.stiffness, atol=1e-13 * abs(whole.stiffness).max())
    none = condense(K, keep)
    assert none.compliance.shape == (0, 0)
    assert none.transfer.shape == (0, len(keep))


def test_bad_requests_are_refused(body):
    _, K, keep, P = body
    with pytest.raises(ValueError, match="kept twice"):
        condense(K, np.append(keep, keep[0]), P)
    with pytest.raises(ValueError, match="kept freedoms 0 to"):
        condense(K, np.array([0, K.shape[0]]), P)
    with pytest.raises(ValueError, match="acts on a kept freedom"):
        condense(K, np.append(keep, P.tocoo().row[0]), P)
    with pytest.raises(ValueError, match="load basis has 7 rows"):
        condense(K, keep, np.ones((7, 1)))
    with pytest.raises(FactorError, match=r"singular|not positive definite"):
        condense(K, keep[:2])


def test_bordered_factor_is_the_product_of_solves(body):
    _, K, keep, P = body
    inside = np.setdiff1d(np.arange(K.shape[0]), keep)
    inner = K.tocsr()[inside][:, inside]
    B = sp.hstack([K.tocsr()[inside][:, keep], P.tocsr()[inside]], format="csc")
    product, seconds = gram(inner, B)
    exact = B.T @ np.linalg.solve(inner.toarray(), B.toarray())
    np.testing.assert_allclose(product, exact, atol=1e-13 * abs(exact).max())
    assert seconds > 0.0
    with pytest.raises(FactorError, match="no bordered factor"):
        gram(inner - 0.01 * inner.diagonal().max() * sp.identity(len(inside)), B)
