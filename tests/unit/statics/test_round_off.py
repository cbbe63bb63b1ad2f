"""The residual that double precision cannot get below, by every solver: a force of round-off in the contacts' lengths."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import one_set
from tests.helpers import FLANK_ERRORS, NO_PROFILES, small_screw
from tests.slow import all_slow_but

from rollbench.lowfi.hertz import contact_stiffness_under_force
from rollbench.lowfi.statics.axis.solve import solve_assembly, solve_assembly_with_elastic_bodies
from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_elastic, solve_static

SOLVERS = {
    "beam": solve_static,
    "bodies": solve_elastic,
    "beam of several sets": solve_assembly,
    "bodies of several sets": solve_assembly_with_elastic_bodies,
}
EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("name", SOLVERS)
def test_uneven_flanks_are_met_in_lengths_of_the_ball_s_radius(name):
    """One ulp of a length r in the approach of the stiffest contact is a force of eps r k."""
    uneven = replace(small_screw(count=9, force=(0.0, 0.0, 1500.0)), errors=FLANK_ERRORS)
    even = replace(uneven, errors=replace(FLANK_ERRORS, **NO_PROFILES))
    bounds = []
    for scene in (uneven, even):
        several = name.endswith("sets")
        found = SOLVERS[name](one_set(scene) if several else scene)
        assert found.converged, found.status
        load = found.sets[0].balls.load if several else found.load
        stiffest = float(contact_stiffness_under_force(load.max(), hertz_without_errors(scene).C.min()))
        ulp = EPS * scene.balls.radius * stiffest / load.max()
        bounds.append(found.solver.round_off_bound / ulp)
    assert 1.0 < bounds[0] < 100.0  # some operations each, in more than one contact at a node
    assert 0.0 < bounds[1] < 0.1 * bounds[0]


@pytest.mark.parametrize("several", all_slow_but([False], [False, True]))
def test_newton_s_steps_on_a_long_shaft_with_many_balls_are_exact(several):
    """On 4,000 short elements the matrix of stiffness alone made steps of 1.8 times their length, which never converged."""
    short = small_screw(1000, 62.5, force=(0.0, 0.0, 156.25e3), load_at=0.0)
    nut = replace(short.nut, position=1.27, length=1.27, groove_radius=3.254e-3)
    long = replace(short, screw=replace(short.screw, length=2.54), nut=nut)
    found = solve_assembly(one_set(long)) if several else solve_static(long, refine=2)
    assert found.converged, found.status
    assert found.solver.iterations < 15
