"""Compliance of one ball's contacts: own parts and coupling modes against dense algebra."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from tests.helpers import relative

from rollbench.hifi.contact.balls import BallBlock, coupled, plain, uncoupled

pytestmark = pytest.mark.xdist_group("ball of blocks")

SIZES, MODES = (5, 7, 4), (2, 3, 1)


@pytest.fixture(scope="module")
def block():
    rng = np.random.default_rng(3)

    def definite(n):
        B = rng.standard_normal((n, n + 3))
        return B @ B.T + 0.1 * np.eye(n)

    return BallBlock(
        tuple(definite(n) for n in SIZES),
        tuple(rng.standard_normal((n, k)) for n, k in zip(SIZES, MODES, strict=True)),
        definite(sum(MODES)),
    )


@pytest.fixture(scope="module")
def dense(block):
    V = np.zeros((sum(SIZES), sum(MODES)))
    V[:5, :2], V[5:12, 2:5], V[12:, 5:] = block.modes
    return block_diag(*block.local) + V @ block.coupling @ V.T


def picks():
    """Active pairs: all, some of each side, one side open, one pair alone."""
    rng = np.random.default_rng(5)
    some = rng.random(16) < 0.5
    without = some.copy()
    without[5:12] = False
    return [np.ones(16, dtype=bool), some, without, np.arange(16) == 13]


def dense_solve(dense, active, rhs):
    out = np.zeros(rhs.shape)
    out[active] = np.linalg.solve(dense[np.ix_(active, active)], rhs[active])
    return out


def test_dense_and_applied(block, dense):
    assert len(block) == 16
    assert block.sides == (slice(0, 5), slice(5, 12), slice(12, 16))
    assert relative(block.dense(), dense) < 1e-14
    force = np.random.default_rng(1).standard_normal(16)
    assert relative(block.apply(force), dense @ force) < 1e-13


@pytest.mark.parametrize("active", picks())
@pytest.mark.parametrize("shape", [(16,), (16, 3)])
def test_solved_on_the_active_pairs(block, dense, active, shape):
    rhs = np.random.default_rng(2).standard_normal(shape)
    found = block.factor(active).solve(rhs)
    assert found.shape == shape
    assert (found[~active] == 0.0).all()
    assert relative(found, dense_solve(dense, active, rhs)) < 1e-11


def test_what_is_known_of_a_side_is_taken_over(block, dense):
    """Sides whose pairs stay keep their very factor; what changes is as if factored again, also sides that open or close. A
    factor does not follow later changes of the flags."""
    rhs = np.random.default_rng(4).standard_normal(16)
    all_pairs, some, without, _ = picks()
    flags = some.copy()
    known = block.factor(flags)
    flags[:] = True
    assert relative(known.solve(rhs), dense_solve(dense, some, rhs)) < 1e-11
    for active in (without, all_pairs, some):
        found = block.factor(active, known)
        for s, (i, j) in enumerate(((0, 5), (5, 12), (12, 16))):
            if np.array_equal(active[i:j], known.active[i:j]):
                assert found.sides[s] is known.sides[s]
            else:
                assert found.sides[s].cholesky is not known.sides[s].cholesky
        assert relative(found.solve(rhs), dense_solve(dense, active, rhs)) < 1e-11
        known = found


def test_one_matrix_is_a_block_without_modes_and_congruent_balls_share_a_block(block, dense):
    one = plain(dense)
    active, rhs = picks()[1], np.arange(16.0)
    assert relative(one.apply(rhs), dense @ rhs) < 1e-14
    assert relative(one.factor(active).solve(rhs), dense_solve(dense, active, rhs)) < 1e-11
    U = [np.random.default_rng(6).standard_normal((16, 2))] * 2
    C = coupled([block, block], U, np.eye(4))
    assert C.blocks[0] is C.blocks[1]
    force = np.arange(32.0)
    assert relative(C.amplitude(force), np.concatenate([U[0].T @ force[:16], U[1].T @ force[16:]])) < 1e-14


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"local": (np.triu(np.ones((5, 5))), np.eye(7), np.eye(4))}, "not symmetric"),
        ({"coupling": np.full((6, 6), np.nan)}, "not finite"),
    ],
)
def test_a_block_of_no_elastic_body_is_refused(block, changes, message):
    with pytest.raises(ValueError, match=message):
        uncoupled(replace(block, **changes))
