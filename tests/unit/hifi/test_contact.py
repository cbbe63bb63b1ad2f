"""Unilateral contact: against brute force, nnls and dense algebra; free bodies; scenes that nothing holds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.optimize import nnls
from scipy.sparse import csr_matrix

from rollbench.hifi.contact import balls

#: Compliance [m/N] and gaps [m] of a real contact's size.
SOFT, GAP = 1e-8, 1e-6


def spd(rng, n, spread=30.0):
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    return SOFT * (q * np.geomspace(1.0, spread, n)) @ q.T


def energy(matrix, gap, forces):
    return 0.5 * forces @ matrix @ forces + gap @ forces


def brute_force(matrix, gap, directions, load):
    """Forces of least energy over every closed set that holds the load: the definition, without the method."""
    n, k = directions.shape
    held = []
    for flags in product((False, True), repeat=n):
        a, forces = np.flatnonzero(flags), np.zeros(n)
        system = np.block([[matrix[np.ix_(a, a)] / SOFT, -directions[a]], [directions[a].T, np.zeros((k, k))]])
        right = np.concatenate([-gap[a] / SOFT, load])
        solution = np.linalg.lstsq(system, right, rcond=None)[0]
        forces[a] = solution[: len(a)]
        if np.abs(system @ solution - right).max(initial=0.0) <= 1e-7 and (forces >= -1e-8).all():
            held.append(forces)
    return min(held, key=lambda forces: energy(matrix, gap, forces))


def patches(rng, sizes=(7, 5, 9), ranks=(2, 3, 2)):
    """A random coupled compliance."""
    modes = [rng.normal(size=(n, r)) for n, r in zip(sizes, ranks, strict=True)]
    return balls.contact_compliance_of_coupled_balls([spd(rng, n) for n in sizes], modes, spd(rng, sum(ranks), 5.0) / 3.0)


def dense(C):
    """The whole matrix of a compliance."""
    U = block_diag(*C.modes_by_ball)
    return block_diag(*(block.dense_compliance_matrix() for block in C.ball_compliances)) + U @ C.mode_compliance @ U.T


def solved(C, gap, directions, load, **start):
    return balls.solve_contacts_of_all_balls(C, gap, csr_matrix(directions), np.asarray(load, dtype=float), **start)[0]


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("spread", [30.0, 1e6])
def test_one_ball_agrees_with_nonnegative_least_squares(seed, spread):
    """Also where changing all wrong pairs at once comes back to an earlier set."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    matrix, gap = spd(rng, n, spread), GAP * rng.normal(size=n)
    factor = np.linalg.cholesky(matrix)
    expected, _ = nnls(factor.T, -np.linalg.solve(factor, gap), maxiter=100 * n)
    block, close = balls.ball_block_from_dense_matrix(matrix), max(expected.max(initial=0.0), 1.0)
    found = balls.solve_contacts_of_one_ball(block, gap, rng.random(n) < 0.5)
    np.testing.assert_allclose(found.forces, expected, atol=1e-7 * close)
    assert found.contact_energy == pytest.approx(-energy(matrix, gap, found.forces), rel=1e-9)
    again = balls.solve_contacts_of_one_ball(block, gap, found)
    np.testing.assert_allclose(again.forces, found.forces, rtol=1e-9, atol=1e-9 * close)


@pytest.mark.parametrize("seed", range(40))
def test_with_free_bodies_agrees_with_brute_force(seed):
    rng = np.random.default_rng(100 + seed)
    n, k = int(rng.integers(3, 9)), int(rng.integers(1, 3))
    matrix, gap = spd(rng, n), GAP * rng.normal(size=n)
    directions = rng.normal(size=(n, k))
    load = 100.0 * directions.T @ np.maximum(rng.normal(size=n), 0.05)  # can be held
    expected = brute_force(matrix, gap, directions, load)
    found = solved(balls.contact_compliance_of_single_ball(matrix), gap, directions, load)
    assert found.converged, found.status
    np.testing.assert_allclose(found.forces, expected, atol=1e-6 * expected.max())
    assert found.unbalanced_force_ratio < 1e-10
    assert found.gaps.min() > -1e-9 * GAP


@pytest.mark.parametrize("seed", range(10))
def test_coupling_at_low_rank_equals_the_dense_matrix(seed):
    rng = np.random.default_rng(200 + seed)
    low = patches(rng)
    n = sum(map(len, low.ball_compliances))
    gap, directions = GAP * rng.normal(size=n), np.abs(rng.normal(size=(n, 3)))
    directions[:7, 2] = 0.0  # a motion that one patch does not feel
    load = 100.0 * directions.T @ rng.uniform(0.5, 1.0, n)
    a, b = (solved(C, gap, directions, load) for C in (low, balls.contact_compliance_of_single_ball(dense(low))))
    assert {a.status, b.status} == {"converged"}
    assert 0 < (a.forces > 0.0).sum() < n
    gaps = gap + dense(low) @ a.forces - directions @ a.rigid_motions
    np.testing.assert_allclose(a.gaps, gaps, rtol=0.0, atol=1e-9 * GAP)
    np.testing.assert_allclose(a.forces, b.forces, rtol=0.0, atol=1e-7 * b.forces.max())
    np.testing.assert_allclose(a.rigid_motions, b.rigid_motions, rtol=0.0, atol=1e-7 * np.abs(b.rigid_motions).max())


def test_body_out_of_touch_is_moved_until_its_load_is_carried():
    gap = GAP * np.array([1.0, 1.0, 2.0, 0.7])
    directions = np.array([[1.0], [1.0], [1.0], [-1.0]])  # a ball with play between two sides
    found = solved(balls.contact_compliance_of_single_ball(1e-2 * SOFT * np.eye(4)), gap, directions, np.array([200.0]))
    assert found.converged
    np.testing.assert_allclose(found.forces, [100.0, 100.0, 0.0, 0.0], atol=1e-6)
    assert found.rigid_motions[0] == pytest.approx(1.01 * GAP, rel=1e-9)


@pytest.mark.parametrize(
    ("directions", "load"),
    [(np.ones((3, 1)), [-100.0]), (np.column_stack([np.ones(3), [-1.0, 0.0, 1.0]]), [100.0, 110.0])],
    ids=["pulled away", "tipped over its edge"],
)
def test_scenes_that_cannot_be_held_do_not_converge(directions, load):
    found = solved(balls.contact_compliance_of_single_ball(SOFT * np.eye(3)), np.zeros(3), directions, load)
    assert not found.converged
    assert found.status.startswith(("not converged", "stalled"))
