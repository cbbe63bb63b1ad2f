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
    loads = chains.solve_screws(chain, errors, np.full(500, load)).contact_load
    deviation = share * 1.5 / approach * half / np.sqrt(3.0) * np.sqrt(77 / 78)
    assert loads.std() == pytest.approx(deviation, rel=0.02)
    found = ensemble.solve_ensemble(chain, half, [load], 500, seed=5)
    touch = found.values_at("displacement", load) - errors.max(axis=1) / chain.approach_per_motion
    # motion: that without errors less the mean error
    assert touch == pytest.approx(state.motion[0] - errors.mean(axis=1) / chain.approach_per_motion, rel=1e-5)


def test_percentiles_have_the_sampling_error_of_repeated_samples():
    sample = np.arange(1000.0)
    inside, beyond = (ensemble.percentile_rank(sample, value) for value in (249.5, 5000.0))
    places = inside, beyond, ensemble.percentile_rank(np.zeros(100), 0.0)
    assert [(p.percent, p.tail_probability) for p in places] == [(25.0, 0.25), (100.0, 0.0), (50.0, 1.0)]
    assert inside.standard_error == pytest.approx(100 * np.sqrt(0.25 * 0.75 / 1000), rel=1e-2)
    assert beyond.standard_error > 0.0
    assert beyond.tail_bound == pytest.approx(2.7 / 1000, rel=0.01)
    assert ensemble.percentile_rank(sample, 10.0, 0.5).tail_probability == 0.011
    rng = np.random.default_rng(0)
    places = [ensemble.percentile_rank(rng.random(400), 0.9).percent for _ in range(400)]
    assert np.std(places) == pytest.approx(ensemble.percentile_rank(rng.random(400), 0.9).standard_error, rel=0.2)
