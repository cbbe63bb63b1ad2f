"""Ensembles: the fast path gives the loads of ``solve_static`` member by member, and hides nothing."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import with_ingredients

from rollbench.compare.scenes.catalogue import scene as shipped
from rollbench.compare.studies.members import ensemble
from rollbench.lowfi.compliance.parts import LADDER
from rollbench.lowfi.statics.members import can_share_equations
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import BallErrors, FourierTerm, Load, SideErrors

BASE = shipped("lin-random")
PITCH = SideErrors(pitch=(FourierTerm(1.0, sigma=2e-6), FourierTerm(3.0, cos=1e-6)), pitch_along="axis")
ROUND = SideErrors(pitch=(FourierTerm(2.0, sigma=1e-6),), roundness=(FourierTerm(2.0, sin=1e-6, sigma=1e-6),))
OFFSET = SideErrors(profile=(1e-6,))


def with_errors(sigma, oversize=0.0, distribution="normal", **others):
    drawn = BallErrors(oversize=oversize, sigma=sigma, distribution=distribution)
    return replace(BASE, errors=replace(BASE.errors, balls=drawn, **others))


WITH_PITCH = with_errors(1e-6, SL=PITCH)


def assert_same_loads(scene, result, members, first=0):
    for m in range(members):
        single = solve_static(scene, member=first + m)
        assert result.statuses[m] == single.status
        np.testing.assert_allclose(result.loads[m], single.load, rtol=0, atol=1e-9 * np.nanmax(single.load))


SCENES = [
    pytest.param(BASE, 0, id="random"),
    pytest.param(with_errors(12e-6, distribution="uniform", SR=OFFSET), 6, id="some balls lost, idle flanks touch"),
    pytest.param(with_errors(5e-6, 7e-6), 6, id="preloaded"),
    pytest.param(with_errors(2e-6, -5e-6), 0, id="clearance"),
    pytest.param(replace(with_errors(2e-6), loads=()), 6, id="no load"),
    pytest.param(replace(BASE, loads=(Load(0.0, (0.0, 0.0, -3000.0)),)), 0, id="pushed the other way"),
    pytest.param(with_ingredients(BASE, screw="rigid"), 0, id="rigid screw"),
    pytest.param(with_ingredients(BASE, partition="source"), 0, id="15 mm elements"),
    pytest.param(with_errors(1e-6, SL=SideErrors(pitch=(FourierTerm(1.0, sin=3e-6),))), 0, id="with pitch error"),
    pytest.param(with_errors(1e-6, SL=PITCH, NR=ROUND), 0, id="random pitch and roundness"),
    pytest.param(replace(with_errors(0.0, 7e-6, SL=PITCH), loads=()), 6, id="preloaded, random pitch"),
    pytest.param(with_ingredients(WITH_PITCH, partition="source"), 0, id="random pitch on 15 mm elements"),
    pytest.param(with_ingredients(WITH_PITCH, screw="rigid"), 0, id="random pitch of a rigid screw"),
]


@pytest.mark.parametrize(("scene", "all_sides"), SCENES)
def test_fast_path_equals_single_solves(scene, all_sides):
    result = ensemble.solve_random_draws(scene, 6)
    assert (result.all_flanks_count, result.singly_solved_count) == (all_sides, 0)
    assert_same_loads(scene, result, 6)


def test_fast_path_serves_exact_arcs_only():
    term = (FourierTerm(2.0, sigma=1e-6),)
    arcs = SideErrors(), SideErrors(profile=(1e-6,)), SideErrors(pitch=term), SideErrors(roundness=term)
    others = SideErrors(profile=(1e-6, 1e-6)), SideErrors(profile_sigma=(1e-6,))
    for errors in (*arcs, *others):
        assert can_share_equations(with_errors(1e-6, NR=errors), LADDER["lin"]) is (errors in arcs)
    scene = with_errors(1e-6, SL=others[1])
    result = ensemble.solve_random_draws(scene, 3)
    assert (result.all_flanks_count, result.singly_solved_count) == (0, 3)
    assert_same_loads(scene, result, 3)


def test_members_without_equilibrium_are_reported():
    result = ensemble.solve_random_draws(replace(BASE, supports=()), 2)
    assert not result.converged.any()
    assert all(s.startswith("not held: screw motion along the helix") for s in result.statuses)
    assert np.isnan(result.loads).all()


def test_members_from_a_number_on_as_many_as_the_scene_says():
    result = ensemble.solve_random_draws(replace(BASE, members=4), first=4)
    assert len(result.statuses) == 4
    assert_same_loads(BASE, result, 4, first=4)
