"""The source's elimination ends where the minimum is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.random_errors.test_chain import LONG as CHAIN

from rollbench.lowfi.as_source.liu.chain import LAWS, solve_ball_screw
from rollbench.lowfi.as_source.liu.elimination import solve_by_elimination


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10**6),
    st.integers(1, 60),
    st.sampled_from([20.0, 200.0, 1500.0]),
    st.sampled_from([0.5, 2.0, 4.0]),
    st.sampled_from([1e-12, 4e-12, 1e-10, 1e-9]),
    st.sampled_from(LAWS),
)
def test_same_active_set_and_loads(seed, balls, load, half_range_um, compliance, law):
    chain = replace(CHAIN, balls=balls, compliance=compliance, law=law)
    errors = 1e-6 * np.random.default_rng(seed).uniform(-half_range_um, half_range_um, balls)
    ours, other = solve_ball_screw(chain, errors, load), solve_by_elimination(chain, errors, load)
    assert (ours.converged, other.converged) == (True, True)
    edge = 1e-6 * ours.load.max()
    assert np.array_equal(ours.load > edge, other.contact_loads > edge)
    assert other.contact_loads == pytest.approx(ours.load, rel=1e-6, abs=1e-6 * ours.load.max())


def test_several_rounds_are_needed_and_rigid_bodies_are_refused():
    errors = np.random.default_rng(0).uniform(-2e-6, 2e-6, 78)
    assert solve_by_elimination(CHAIN, errors, 100.0).rounds > 2
    assert solve_by_elimination(CHAIN, errors, 5000.0).rounds == 1
    for chain, load, words in ((replace(CHAIN, compliance=0.0), 100.0, "compliance"), (CHAIN, 0.0, "load")):
        with pytest.raises(ValueError, match=words):
            solve_by_elimination(chain, errors, load)
