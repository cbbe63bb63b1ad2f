"""Ensembles: the same screws however they are cut, each as solved alone; moments, percentiles and their errors."""

from dataclasses import replace

import numpy as np
import pytest
from tests.unit.random_errors.test_chain import LONG as CHAIN

from rollbench.lowfi.as_source.liu import chain as chains
from rollbench.lowfi.as_source.liu import ensemble

LOADS = [100.0, 1000.0]


@pytest.mark.parametrize("law", chains.LAWS)
def test_every_member_as_solved_alone(law):
    chain = replace(CHAIN, law=law)
    found = ensemble.solve_ensemble(chain, 2e-6, LOADS, 6, seed=7)
    for i, errors in enumerate(ensemble.draw_uniform_errors(7, 0, 6, 78, 2e-6)):
        for load in LOADS:
            s = chains.solve_ball_screw(chain, errors, load)
            alone = (s.load.min(), s.load.max(), s.loaded_balls, s.displacement, s.displacement_first_loaded, s.stiffness)
            together = [found.values_at(name, load)[i] for name in ensemble.QUANTITIES]
            assert together == pytest.approx(alone, rel=1e-10, abs=1e-14)
    assert found.failed == 0 <= found.residual < 1e-10


def test_moments_to_first_order():
    """Small errors against the approach: rigid bodies carry Q (1 + 1.5 (e - mean e)/d), so the mean square is closed."""
    chain = replace(CHAIN, compliance=0.0, law="constant")
    half, load = 1e-8, 5000.0
    state = chains.solve_ball_screw(chain, np.zeros(78), load)
    share, approach = state.load[0], (state.load[0] / chain.stiffness) ** (2 / 3)
    errors = ensemble.draw_uniform_errors(5, 0, 500, 78, half)
    loads = chains.solve_screws(chain, errors, np.full(500, load)).load
    deviation = share * 1.5 / approach * half / np.sqrt(3.0) * np.sqrt(77 / 78)
    assert loads.std() == pytest.approx(deviation, rel=0.02)
    found = ensemble.solve_ensemble(chain, half, [load], 500, seed=5)
    touch = found.values_at("displacement", load) - errors.max(axis=1) / chain.approach_per_motion
    # motion: that without errors less the mean error
    assert touch == pytest.approx(state.motion[0] - errors.mean(axis=1) / chain.approach_per_motion, rel=1e-5)
