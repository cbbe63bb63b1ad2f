"""Ensembles: the fast path gives the loads of ``solve_static`` member by member, and hides nothing."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.comparison.scenes.catalogue import scene as shipped
from rollbench.comparison.wings.members.ensemble import one_pass, run_ensemble, work_of
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.errors import specimen, specimens
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, FourierTerm, Load, SideErrors

BASE = shipped("lin-random")
PITCH = SideErrors(pitch=(FourierTerm(1.0, sigma=2e-6), FourierTerm(3.0, cos=1e-6)), pitch_along="axis")
ROUND = SideErrors(pitch=(FourierTerm(2.0, sigma=1e-6),), roundness=(FourierTerm(2.0, sin=1e-6, sigma=1e-6),))


def with_errors(sigma, oversize=0.0, distribution="normal", **others):
    drawn = BallErrors(oversize=oversize, sigma=sigma, distribution=distribution)
    return replace(BASE, errors=replace(BASE.errors, balls=drawn, **others))


def assert_same_loads(scene, result, members):
    for m in range(members):
        single = solve_static(scene, engine="compiled", member=m)
        assert result.statuses[m] == single.status
        np.testing.assert_allclose(result.loads[m], single.load, rtol=0, atol=1e-9 * np.nanmax(single.load))


@pytest.mark.parametrize(
    ("scene", "all_sides"),
    [
        pytest.param(BASE, 0, id="random"),
        pytest.param(with_errors(12e-6, distribution="uniform"), 6, id="some balls lost, idle flanks touch"),
        pytest.param(with_errors(5e-6, 7e-6), 6, id="preloaded"),
        pytest.param(with_errors(2e-6, -5e-6), 0, id="clearance"),
        pytest.param(replace(with_errors(2e-6), loads=()), 6, id="no load"),
        pytest.param(replace(BASE, loads=(Load(0.0, (0.0, 0.0, -3000.0)),)), 0, id="pushed the other way"),
        pytest.param(replace(BASE, ingredients=replace(BASE.ingredients, screw="rigid")), 0, id="rigid screw"),
        pytest.param(replace(BASE, ingredients=replace(BASE.ingredients, partition="source")), 0, id="15 mm elements"),
        pytest.param(with_errors(1e-6, SL=SideErrors(pitch=(FourierTerm(1.0, sin=3e-6),))), 0, id="with pitch error"),
        pytest.param(with_errors(1e-6, SL=PITCH, NR=ROUND), 0, id="random pitch and roundness"),
        pytest.param(replace(with_errors(0.0, 7e-6, SL=PITCH), loads=()), 6, id="preloaded, random pitch"),
        pytest.param(
            replace(with_errors(1e-6, SL=PITCH), ingredients=replace(BASE.ingredients, partition="source")),
            0,
            id="random pitch on 15 mm elements",
        ),
        pytest.param(
            replace(with_errors(1e-6, SL=PITCH), ingredients=replace(BASE.ingredients, screw="rigid")),
            0,
            id="random pitch of a rigid screw",
        ),
    ],
)
def test_fast_path_equals_single_solves(scene, all_sides):
    result = run_ensemble(scene, 6)
    assert (result.all_sides, result.general) == (all_sides, 0)
    assert_same_loads(scene, result, 6)


def test_two_specimens_have_lever_arms_of_their_own():
    """Random pitch moves the contact points; two are the fewest that differ; with clearance one diagonal bears."""
    scene = with_errors(1e-6, -8e-6, SL=PITCH, NR=ROUND)
    result = run_ensemble(scene, 2)
    assert result.all_sides == 0
    assert_same_loads(scene, result, 2)


@pytest.mark.parametrize("distribution", ["normal", "uniform"])
def test_many_specimens_are_those_drawn_one_by_one(distribution):
    scene = with_errors(3e-6, 1e-6, distribution, SL=PITCH, NR=ROUND, SR=SideErrors(profile=(1e-6,)))
    layout = ball_layout(scene)
    many = specimens(scene, layout, 6, 3)
    for k in range(3):
        one = specimen(scene, layout, 6 + k)
        np.testing.assert_array_equal(many.ball_radius[k], one.ball_radius)
        np.testing.assert_allclose(many.centre[k], one.centre, rtol=0, atol=1e-19)
        np.testing.assert_array_equal(many.radius, one.radius)
    assert np.ptp(many.centre[:, :, 0, 1], axis=0).max() > 1e-7


def test_numbers_do_not_depend_on_threads():
    scene = with_errors(2e-6, SL=PITCH)
    one, two = (run_ensemble(scene, 40, threads=n) for n in (1, 3))
    # products of matrices may round by a member's place among those solved side by side
    np.testing.assert_allclose(one.loads, two.loads, rtol=0, atol=1e-13 * one.loads.max())
    np.testing.assert_allclose(one.works, two.works, rtol=1e-13)


@pytest.mark.parametrize(
    ("change", "fast"),
    [
        ({}, True),
        ({"profile": (1e-6,)}, True),
        ({"profile": (1e-6, 1e-6)}, False),
        ({"profile_sigma": (1e-6,)}, False),
        ({"pitch": (FourierTerm(1.0, sigma=1e-6),)}, True),
        ({"roundness": (FourierTerm(2.0, sigma=1e-6),)}, True),
    ],
)
def test_fast_path_serves_exact_arcs_only(change, fast):
    assert one_pass(with_errors(1e-6, NR=SideErrors(**change))) is fast


def test_general_path():
    scene = with_errors(1e-6, SL=SideErrors(profile_sigma=(1e-6,)))
    result = run_ensemble(scene, 3)
    assert (result.all_sides, result.general) == (0, 3)
    assert_same_loads(scene, result, 3)


def test_members_without_equilibrium_are_reported():
    result = run_ensemble(replace(BASE, supports=()), 2)
    assert not result.converged.any()
    assert all(s.startswith("not held: screw motion along the helix") for s in result.statuses)
    assert np.isnan(result.loads).all()


def test_number_of_members():
    assert len(run_ensemble(replace(BASE, members=4)).statuses) == 4


def test_members_from_a_number_on_and_their_work():
    result = run_ensemble(BASE, 2, first=4)
    for k, member in enumerate((4, 5)):
        single = solve_static(BASE, engine="compiled", member=member)
        np.testing.assert_allclose(result.loads[k], single.load, rtol=0, atol=1e-9 * single.load.max())
        assert result.works[k] == pytest.approx(work_of(BASE, single), rel=1e-9)
