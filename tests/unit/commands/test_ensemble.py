"""Ensembles: the fast path gives the loads of ``solve_static`` member by member, and hides nothing."""

from dataclasses import replace

import numpy as np
import pytest

from compare.models.ensemble import (
    GENERAL_PATH,
    RADII_PATH,
    _radii,
    bands,
    load_ratios,
    only_radii_differ,
    run_ensemble,
    share_touching,
)
from compare.scenes.catalogue import scene as shipped
from lowfi.statics.static import solve_static
from meshes.errors import specimen
from meshes.helix import ball_layout
from meshes.parts import BallErrors, FourierTerm, Load, SideErrors

BASE = shipped("lin-random")


def with_errors(sigma, oversize=0.0, distribution="normal", **more):
    drawn = BallErrors(oversize=oversize, sigma=sigma, distribution=distribution)
    return replace(BASE, errors=replace(BASE.errors, balls=drawn, **more))


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
    ],
)
def test_fast_path_equals_single_solves(scene, all_sides):
    result = run_ensemble(scene, 6)
    assert (result.path, result.general) == (RADII_PATH, 0)
    assert result.all_sides == all_sides
    assert_same_loads(scene, result, 6)


def test_radii_are_those_of_the_specimens():
    scene = with_errors(3e-6, distribution="uniform")
    layout = ball_layout(scene)
    for m in (0, 7):
        np.testing.assert_array_equal(_radii(scene, m), specimen(scene, layout, m).ball_radius)


@pytest.mark.parametrize(
    ("change", "fast"),
    [
        ({}, True),
        ({"profile": (1e-6,)}, True),
        ({"profile": (1e-6, 1e-6)}, False),
        ({"profile_sigma": (1e-6,)}, False),
        ({"pitch": (FourierTerm(1.0, sigma=1e-6),)}, False),
        ({"roundness": (FourierTerm(2.0, sigma=1e-6),)}, False),
    ],
)
def test_fast_path_serves_random_radii_only(change, fast):
    assert only_radii_differ(with_errors(1e-6, NR=SideErrors(**change))) is fast


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_general_path(n_jobs):
    scene = with_errors(1e-6, SL=SideErrors(pitch=(FourierTerm(1.0, sigma=1e-6),)))
    result = run_ensemble(scene, 3, n_jobs=n_jobs, backend="loky" if n_jobs == 2 else "sequential")
    assert (result.path, result.general) == (GENERAL_PATH, 3)
    assert_same_loads(scene, result, 3)


def test_members_without_equilibrium_are_reported():
    result = run_ensemble(replace(BASE, supports=()), 2)
    assert not result.converged.any()
    assert all(s.startswith("not held: screw motion along the helix") for s in result.statuses)
    assert np.isnan(result.loads).all()
    with pytest.raises(ValueError, match="no member of lin-random converged"):
        bands(result)


def test_number_of_members():
    assert len(run_ensemble(replace(BASE, members=4)).statuses) == 4
    with pytest.raises(ValueError, match="allowed: 1 or more"):
        run_ensemble(BASE, 0)


def test_bands_ratios_and_touching_share():
    result = run_ensemble(with_errors(5e-6), 40)
    low, mid, high = bands(result)
    assert low.shape == (32, 4)
    assert np.all(low <= mid)
    assert np.all(mid <= high)
    assert float(high[:, 0].max()) > 1.2 * float(mid[:, 0].max())
    by_hand = [float((x[:, 1:3] > 0.0).any()) for x in result.loads]
    assert share_touching(result) == pytest.approx(np.mean(by_hand))
    assert share_touching(result, ("SL", "NR")) == 1.0
    ratios = load_ratios(result)
    assert ratios.shape == (40,)
    m = int(np.argmin(ratios))
    assert ratios[m] == pytest.approx(result.loads[m, :, 0].max() / result.loads[m, :, 0].min())
    lost = (result.loads[:, :, 0] == 0.0).any(axis=1)
    assert lost.any()
    assert np.isinf(ratios[lost]).all()
