"""How the source's way enters the stability table: failures and overlaps counted."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence.source_cases import inferred, plain
from rollbench.compare.cases.lin.extremes import (
    BALLS,
    MU,
    SOURCE_BALLS,
    UNLOADED,
    Tally,
    chain_group,
    linear_chain,
    linear_pair,
    patchy_chain,
    screw_ball,
    screw_pairs,
)
from rollbench.lowfi.friction.as_source.chain import SourceMotion
from rollbench.lowfi.friction.as_source.screw import from_linear_starts, from_pair_starts, shaken
from rollbench.lowfi.friction.contact.motion import balance_by_root, least_dissipation
from rollbench.lowfi.friction.screw.run import solve_pair

pytestmark = pytest.mark.xdist_group("ways of the source")

TWO = np.radians(2.0)


def motion(force, status) -> SourceMotion:
    n = len(force) + 1
    zero = np.zeros((n, 3))
    return SourceMotion(zero, zero, np.array(force), np.zeros((n, 4)), np.zeros(n - 1), 0.0, 1, status)


def test_roots_are_counted_by_what_they_are():
    tally = Tally()
    ours = np.array([1.0])
    roots = ([9.0], "failed"), ([1.0], "exact"), ([1.2], "exact"), ([0.0], "overlapping")
    for root in (None, *(motion(*root) for root in roots)):
        tally.theirs(root, ours, 10.0)
    record = tally.record("group", "model")
    assert (record.source, record.source_tries) == (2, 5)
    assert "roots of the source's that let balls overlap: 1" in record.note
    assert "roots of the source's that differ from the answer found here: 1" in record.note


def test_linear_groups_try_rolling_and_random_starts():
    record = chain_group("group", [linear_pair(2.0, -0.6), linear_pair(-2.0, -0.6)])
    assert record.ours == record.tries == 8
    assert record.source_tries == 8
    assert record.source >= 2
    longer = chain_group("group", [linear_chain(20, 0.1)])
    assert longer.source == 0
    assert "overlap" in longer.note


def test_friction_of_rough_chains_is_that_asked_for():
    rough = linear_chain(5, 0.5)
    assert rough.bearing.mu == rough.bearing.mu_balls == 0.5
    assert rough.chain().count == 5
    np.testing.assert_array_equal(rough.loads, linear_chain(5).loads)
    assert rough.chain().scale == pytest.approx(5.0 * linear_chain(5).chain().scale)


def test_relative_offsets_do_not_mix_units():
    q, units = np.array([[1e-3, 2.0, 0.0]]), np.array([1.0, 1e-3, 1e-3])
    drawn = np.array([shaken(q, units, np.random.default_rng(k), 0.5)[0] for k in range(200)])
    span = np.abs(drawn - q).max(axis=0)
    np.testing.assert_allclose(span, [0.5e-3, 1.0, 0.5 * 0.01 * 2.0], rtol=0.05)


def test_screw_pairs_count_the_source():
    record, wedged = (screw_pairs("group", [pair]) for pair in (inferred(TWO), replace(plain(TWO), oversize=-5e-6)))
    assert record.source_tries == 4
    assert record.source >= 1
    assert wedged.source < wedged.source_tries


def test_one_ball_from_near_and_from_nowhere():
    ball = screw_ball(inferred(TWO))
    q = least_dissipation(ball.problem, fast=True).q
    assert balance_by_root(ball.problem, ball.law, 1.001 * q, fast=True).status == "exact"
    assert balance_by_root(ball.problem, ball.law, 1e3 * q, fast=True).status == "failed"


class Middle:
    """A generator that always draws the middle: nothing is shaken, forces are those of the solution."""

    def uniform(self, low, high, size):
        """The middle, of the shape asked for."""
        return np.full(size, 0.5 * (low + high))


def test_random_starts_are_about_the_solutions_apart_and_in_contact():
    """Without any offset the search has nothing left to find: a Jacobian (4 calls a ball, 8 a pair) and a few steps."""
    case, pair = linear_pair(2.0, -0.6), inferred(TWO)
    linear = from_linear_starts(case.bearing, case.angles, case.loads, Middle(), 1, 0.5)
    for rolling, near in (linear, from_pair_starts(pair, solve_pair(pair), Middle(), 1, 0.5)):
        assert rolling.status == near.status == "exact"
        assert near.ball_force == pytest.approx(rolling.ball_force, rel=1e-9)
        assert near.calls < 0.62 * rolling.calls
        assert near.calls < 40


def test_chains_over_friction_lack_some_contacts_and_go_to_200_balls():
    assert (min(BALLS), max(BALLS)) == (2, 200)
    assert (min(MU), max(MU)) == (1e-3, 0.5)
    case = patchy_chain(50, 0.3)
    assert case.bearing.mu == case.bearing.mu_balls == 0.3
    idle = case.loads == 0.0
    assert idle.mean() == pytest.approx(UNLOADED, abs=0.06)
    assert np.ptp(case.loads[~idle] / linear_chain(50).loads[~idle]) > 1.2


def test_long_chains_are_not_asked_of_the_source():
    cases = [linear_chain(2), linear_chain(5)]
    found = chain_group("group", cases, "model", 1, 2, "a note")
    assert (found.cases, found.tries, found.source_tries) == (2, 4, 2)
    assert found.note.startswith("a note")
    assert max(BALLS) > SOURCE_BALLS
