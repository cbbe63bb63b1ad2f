"""Unilateral contact: against brute force, nnls and dense algebra; loose bodies; degenerate and impossible scenes."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import nnls

from hifi.active_set import ActiveSystem
from hifi.compliance import coupled, uncoupled
from hifi.contact import solve_contact


def spd(rng, n, spread=30.0):
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    return (q * np.geomspace(1.0, spread, n)) @ q.T


def energy(matrix, gap, forces):
    return 0.5 * forces @ matrix @ forces + gap @ forces


def brute_force(matrix, gap, directions, load):
    """Forces of least energy over every closed set, or None: the definition, without the method."""
    n, k = directions.shape
    best = None
    for flags in product((False, True), repeat=n):
        a = np.flatnonzero(flags)
        system = np.block([[matrix[np.ix_(a, a)], -directions[a]], [directions[a].T, np.zeros((k, k))]])
        solution = np.linalg.lstsq(system, np.concatenate([-gap[a], load]), rcond=None)[0]
        if np.abs(system @ solution - np.concatenate([-gap[a], load])).max(initial=0.0) > 1e-9:
            continue
        forces = np.zeros(n)
        forces[a] = solution[: len(a)]
        if (forces >= -1e-10).all() and (best is None or energy(matrix, gap, forces) < energy(matrix, gap, best)):
            best = forces
    return best


def patches(rng, sizes=(7, 5, 9), ranks=(2, 3, 2), shared=False):
    """A random coupled compliance whose patches may share columns."""
    rank = max(ranks) + 2 if shared else sum(ranks)
    columns = [rng.permutation(rank)[:r] for r in ranks] if shared else None
    modes = [rng.normal(size=(n, r)) for n, r in zip(sizes, ranks, strict=True)]
    return coupled([spd(rng, n) for n in sizes], modes, spd(rng, rank, 5.0) / 3.0, columns)


@pytest.mark.parametrize("seed", range(25))
def test_without_motions_agrees_with_nonnegative_least_squares(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    matrix, gap = spd(rng, n), rng.normal(size=n)
    factor = np.linalg.cholesky(matrix)
    expected, _ = nnls(factor.T, -np.linalg.solve(factor, gap))
    found = solve_contact(uncoupled(matrix), gap, np.zeros((n, 0)), np.zeros(0))
    assert found.converged
    np.testing.assert_allclose(found.forces, expected, atol=1e-10 * max(expected.max(initial=0.0), 1.0))
    assert found.complementarity < 1e-12


@pytest.mark.parametrize("seed", range(40))
def test_with_free_bodies_agrees_with_brute_force(seed):
    rng = np.random.default_rng(100 + seed)
    n, k = int(rng.integers(3, 9)), int(rng.integers(1, 3))
    matrix, gap = spd(rng, n), rng.normal(size=n)
    directions = rng.normal(size=(n, k))
    load = directions.T @ np.maximum(rng.normal(size=n), 0.0)  # can be held
    expected = brute_force(matrix, gap, directions, load)
    found = solve_contact(uncoupled(matrix), gap, directions, load)
    assert found.converged, found.status
    np.testing.assert_allclose(found.forces, expected, atol=1e-8)
    assert np.abs(directions.T @ found.forces - load).max() < 1e-12 * (np.abs(directions.T) @ found.forces).max()
    assert found.equilibrium < 1e-12
    assert found.complementarity < 1e-10


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_coupling_at_low_rank_equals_the_dense_matrix(seed, shared):
    rng = np.random.default_rng(200 + seed)
    low = patches(rng, shared=shared)
    n = low.size
    gap, directions = rng.normal(size=n), rng.normal(size=(n, 3))
    directions[:7, 2] = 0.0  # a motion that one patch does not feel
    load = directions.T @ rng.uniform(0.5, 1.0, n)
    a = solve_contact(low, gap, sparse.csc_array(directions), load)
    b = solve_contact(uncoupled(low.dense()), gap, directions, load)
    assert a.converged
    assert b.converged
    assert 0 < (a.forces > 0.0).sum() < n
    np.testing.assert_allclose(low.apply(a.forces), low.dense() @ a.forces, rtol=1e-13, atol=1e-12)
    np.testing.assert_allclose(a.forces, b.forces, rtol=0.0, atol=1e-12 * b.forces.max())
    np.testing.assert_allclose(a.motions, b.motions, rtol=0.0, atol=1e-12 * np.abs(b.motions).max())
    assert max(a.equilibrium, b.equilibrium) < 1e-12
    assert max(a.complementarity, b.complementarity) < 1e-12


def test_coupling_a_million_times_softer_than_the_patches_keeps_twelve_digits():
    rng = np.random.default_rng(5)
    low = patches(rng)
    soft = coupled(low.blocks, low.modes, 1e6 * low.coupling)
    directions = np.ones((low.size, 1))
    forces = rng.uniform(0.5, 1.0, low.size)
    gap = -soft.apply(forces)  # closed by exactly these forces
    found = solve_contact(soft, gap, directions, np.array([forces.sum()]))
    assert found.converged
    np.testing.assert_allclose(found.forces, forces, rtol=0.0, atol=1e-8)  # as the rounded gaps allow
    assert found.complementarity < 1e-14
    assert abs(found.forces.sum() / forces.sum() - 1.0) < 1e-14


def test_weakly_held_motions_and_small_units_are_not_taken_for_loose_ones():
    nearly = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-4]])  # two motions that only a small difference tells apart
    expected = np.array([1.0, 2.0])
    for scale in (1.0, 1e-9):  # of the second motion's unit
        directions = nearly * [1.0, scale]
        found = solve_contact(uncoupled(np.eye(2)), np.zeros(2), directions, directions.T @ expected)
        assert found.converged
        np.testing.assert_allclose(found.forces, expected, rtol=1e-7)


def test_prescribed_motion_gives_the_load_that_drives_it_back():
    rng = np.random.default_rng(7)
    low = patches(rng)
    gap, directions = rng.uniform(0.0, 1.0, low.size), np.column_stack([np.ones(low.size), np.arange(low.size) % 3])
    held = solve_contact(low, gap, directions, np.zeros(2), prescribed=np.array([3.0, np.nan]))
    assert held.converged
    assert held.motions[0] == 3.0
    reaction = directions.T @ held.forces
    assert abs(reaction[1]) < 1e-12 * reaction[0]
    free = solve_contact(low, gap, directions, np.array([reaction[0], 0.0]))
    np.testing.assert_allclose(free.motions, held.motions, rtol=1e-10)
    np.testing.assert_allclose(free.forces, held.forces, atol=1e-10 * held.forces.max())


def test_answer_does_not_depend_on_where_it_starts_and_a_good_start_is_quick():
    rng = np.random.default_rng(11)
    low = patches(rng)
    gap, directions = rng.normal(size=low.size), np.ones((low.size, 1))
    cold = solve_contact(low, gap, directions, np.array([5.0]))
    for start in (np.zeros(low.size, bool), rng.random(low.size) < 0.5):
        other = solve_contact(low, gap, directions, np.array([5.0]), start=start)
        assert other.converged
        np.testing.assert_allclose(other.forces, cold.forces, atol=1e-11 * cold.forces.max())
    assert solve_contact(low, gap, directions, np.array([5.0]), start=cold.forces > 0.0).iterations == 1


def test_body_out_of_touch_is_moved_until_its_load_is_carried():
    gap = np.array([1.0, 1.0, 2.0, 0.7])
    directions = np.array([[1.0], [1.0], [1.0], [-1.0]])  # a ball with play between two sides
    found = solve_contact(uncoupled(0.01 * np.eye(4)), gap, directions, np.array([2.0]))
    assert found.converged
    np.testing.assert_allclose(found.forces, [1.0, 1.0, 0.0, 0.0], atol=1e-12)
    assert found.motions[0] == pytest.approx(1.01, rel=1e-12)


def test_unloaded_body_with_play_stays_where_it_is():
    found = solve_contact(uncoupled(np.eye(2)), np.array([0.3, 0.4]), np.array([[1.0], [-1.0]]), np.zeros(1))
    assert found.converged
    assert not found.forces.any()
    assert (found.gaps >= 0.0).all()
    assert found.equilibrium == 0.0


def test_motion_that_changes_no_gap_stays_zero():
    directions = np.array([[1.0, 0.0], [1.0, 0.0]])
    found = solve_contact(uncoupled(np.eye(2)), np.zeros(2), directions, np.array([2.0, 0.0]))
    assert found.converged
    assert found.motions[1] == 0.0


@pytest.mark.parametrize("load", [[-1.0], [-1e-9]])
def test_load_that_pulls_the_body_away_is_refused(load):
    found = solve_contact(uncoupled(np.eye(3)), np.zeros(3), np.ones((3, 1)), np.array(load))
    assert not found.converged
    assert found.status.startswith("not held")
    assert found.equilibrium > 0.99


def test_scene_that_cannot_be_held_is_told_from_one_that_needs_more_iterations():
    directions = np.column_stack([np.ones(3), [-1.0, 0.0, 1.0]])  # sinking, tipping
    tipped = solve_contact(uncoupled(np.eye(3)), np.zeros(3), directions, np.array([1.0, 1.1]), max_iterations=1)
    assert tipped.status.startswith("not held")


def test_load_that_tips_the_body_over_its_edge_is_refused():
    directions = np.column_stack([np.ones(3), [-1.0, 0.0, 1.0]])  # sinking, tipping
    held = solve_contact(uncoupled(np.eye(3)), np.zeros(3), directions, np.array([1.0, 0.9]))
    tipped = solve_contact(uncoupled(np.eye(3)), np.zeros(3), directions, np.array([1.0, 1.1]))
    assert held.converged
    assert not tipped.converged
    assert tipped.status.startswith("not held")


def test_load_on_a_motion_without_contact_names_the_motion():
    directions = np.array([[1.0, 0.0], [1.0, 0.0]])
    found = solve_contact(uncoupled(np.eye(2)), np.zeros(2), directions, np.array([2.0, 1.0]))
    assert found.status.startswith("not held")
    assert "motion 1" in found.status


def test_too_few_iterations_are_told_with_the_remedy():
    rng = np.random.default_rng(3)
    n = 30
    found = solve_contact(
        uncoupled(spd(rng, n)), rng.normal(size=n), np.ones((n, 1)), np.array([1.0]), max_iterations=1
    )
    assert not found.converged
    assert "max_iterations" in found.status


def test_cycling_is_broken():
    """Changing all wrong pairs at once comes back to an earlier set on some problems; one at a time does not."""
    rng = np.random.default_rng(0)
    repeats = 0
    for _ in range(300):
        tough, gap = spd(rng, 6, 1e4), rng.normal(size=6)
        repeats += _plain_repeats(tough, gap)
        assert solve_contact(uncoupled(tough), gap, np.zeros((6, 0)), np.zeros(0)).converged
    assert repeats > 0


def _plain_repeats(matrix, gap):
    """Whether the unguarded active set comes back to a set it has left."""
    closed, seen = np.ones(len(gap), bool), set()
    while closed.tobytes() not in seen:
        seen.add(closed.tobytes())
        forces = np.zeros(len(gap))
        forces[closed] = np.linalg.solve(matrix[np.ix_(closed, closed)], -gap[closed])
        wrong = np.where(closed, forces < 0.0, gap + matrix @ forces < -1e-12)
        if not wrong.any():
            return False
        closed = closed ^ wrong
    return True


def test_indefinite_compliance_is_told_by_block():
    found = solve_contact(uncoupled(np.eye(2), -np.eye(2)), np.zeros(4), np.ones((4, 1)), np.array([1.0]))
    assert not found.converged
    assert "block 1" in found.status


def test_bad_shapes_and_values_are_refused():
    good = uncoupled(np.eye(2))
    with pytest.raises(ValueError, match="pairs and motions must agree"):
        solve_contact(good, np.zeros(3), np.ones((2, 1)), np.ones(1))
    with pytest.raises(ValueError, match="one flag for each"):
        solve_contact(good, np.zeros(2), np.ones((2, 1)), np.ones(1), start=np.ones(3, bool))
    with pytest.raises(ValueError, match="finite"):
        solve_contact(good, np.array([0.0, np.nan]), np.ones((2, 1)), np.ones(1))
    with pytest.raises(ValueError, match="not symmetric"):
        uncoupled(np.array([[1.0, 0.5], [0.0, 1.0]]))
    with pytest.raises(ValueError, match="coupling is not symmetric"):
        coupled([np.eye(2)], [np.ones((2, 2))], np.array([[1.0, 1.0], [0.0, 1.0]]))
    with pytest.raises(ValueError, match="modes of block 0"):
        coupled([np.eye(2)], [np.ones((3, 1))], np.eye(1))
    with pytest.raises(ValueError, match="different numbers"):
        coupled([np.eye(2)], [np.ones((2, 2))], np.eye(2), [np.array([1, 1])])


def test_factors_of_unchanged_patches_are_kept():
    rng = np.random.default_rng(13)
    low = patches(rng)
    system = ActiveSystem(low, np.zeros(low.size), np.ones((low.size, 1)), np.ones(1), None)
    closed = np.ones(low.size, bool)
    system.solve(closed, np.zeros(1))
    before = list(system._factors)
    closed[0] = False
    system.solve(closed, np.zeros(1))
    assert system._factors[0] is not before[0]
    assert system._factors[1] is before[1]
