"""Ensembles: the same screws however they are cut, each as solved alone; moments, percentiles and their errors."""

from dataclasses import replace

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
