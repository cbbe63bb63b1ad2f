"""Every start leads to the same forces: the energy is convex."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.helpers import FLANK_ERRORS, relative, small_screw
from tests.static_problems import SCENES, elastic_equations

from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.equilibrium import find_equilibrium
from rollbench.lowfi.statics.static import solve_static
from rollbench.lowfi.together import solve_alone

HELD = (("ux", 0.0), ("uz", 0.0), ("rx", 0.0))


@pytest.mark.parametrize("case", SCENES)
@settings(max_examples=5, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), exponent=st.floats(-3.0, 1.0))
def test_random_starts_reach_the_same_forces(case, seed, exponent):
    ready, rng = elastic_equations(SCENES[case], LADDER["lin"]), np.random.default_rng(seed)
    assert solve_alone(ready.solve_by_newton()).residual <= 1e-10
    phi, a, size = ready.state.phi, ready.state.a, 10.0**exponent
    start = phi + size * np.abs(phi).max() * rng.normal(size=phi.shape), a + 1e-5 * size * rng.normal(size=a.shape)
    found, outcome = find_equilibrium(ready.system, start)
    assert outcome.residual[0] <= 1e-10
    assert relative(found.forces.contacts.force, ready.state.forces.contacts.force) < 1e-8


@pytest.mark.parametrize("uneven", [False, True], ids=["arcs", "uneven"])
def test_clearance_with_uneven_flanks(uneven):
    """The gap closes from a cold start whether the flanks are arcs or not, at nearly the same loads."""
    scene = small_screw(13, lead=0.0, beta=0.64, oversize=-7.3e-6, force=(0.0, -870.0, 0.0), fixed=HELD)
    if uneven:
        scene = replace(scene, errors=replace(FLANK_ERRORS, balls=scene.errors.balls))
    result = solve_static(scene)
    assert result.status == "converged"
    assert 150.0 < result.load.max() < 300.0
