"""What condensed bodies know of each contact's own approach: contacts by active sets, the fitted law; the grid's wave, and
the law of the force that takes the place of an approach that waves."""

import numpy as np
import pytest

from rollbench.hifi.bodies.grid_wave import POWERS, GapCorrectionTable, fit_smooth_force_law, solve_unilateral_contact
from rollbench.meshes.condensed import CondensedBodies

FORCES = np.geomspace(40.0, 600.0, 16)
C = 1.4e-7
LOADS = np.geomspace(20.0, 600.0, 64)


def bodies(local):
    """Two sides of a ring whose own approaches are given."""
    given = np.array(local), np.tile(FORCES, (len(local), 1)), np.array([C, 2.0 * C])
    return CondensedBodies("none", 1, np.array([0.0, 3.0]), 0.0, np.eye(2), np.eye(2), np.eye(len(local)), *given)


def test_the_law_of_a_side_is_found_again_whatever_the_force_and_scatter_is_a_share_of_the_approach():
    law = [(-2e-9, 9e-12), (1e-10, -3e-11)]
    found = bodies([e + h * np.cbrt(FORCES) for e, h in law])
    for side, expected in zip((0, 3), law, strict=True):
        assert found.fit_local_approach_over_load(side) == pytest.approx(expected, rel=1e-9)
        assert found.relative_deviation_of_fit(side) < 1e-12
    wave = 0.002 * np.where(np.arange(FORCES.size) % 2, 1.0, -1.0) * C * np.cbrt(1.0 / FORCES)
    found = bodies([-2e-9 + wave, -2e-9 + wave])
    assert found.relative_deviation_of_fit(0) == pytest.approx(0.002, rel=0.05)
    assert found.relative_deviation_of_fit(3) == pytest.approx(0.001, rel=0.05)  # its approach is twice as large
    e, h = found.fit_local_approach_over_load(0)
    law = e + h * np.cbrt(FORCES)
    assert np.abs(law + 2e-9).max() < 0.5 * np.abs(wave).max()


def test_contacts_on_springs():
    """Springs of their own: each carries what the approach closes beyond its gap."""
    rng = np.random.default_rng(3)
    springs, gap, close = (rng.uniform(*ends, 40) for ends in ((1e-9, 2e-9), (0.0, 2e-6), (0.9, 1.0)))
    loads = np.geomspace(1.0, 1e4, 5)
    found, closed = solve_unilateral_contact(np.diag(springs), gap, close, loads)
    for load, approach, pairs in zip(loads, found, closed, strict=True):
        carried = np.maximum(approach * close - gap, 0.0) / springs @ close
        assert carried == pytest.approx(load, rel=1e-10)
        np.testing.assert_array_equal(pairs, approach * close > gap)
    again, same = solve_unilateral_contact(np.diag(springs), gap, close, loads, closed[::-1])
    assert again == pytest.approx(found, rel=1e-12)
    np.testing.assert_array_equal(same, closed)


def test_the_wave_is_periodic_in_the_place_and_follows_hertz_beyond_its_forces():
    x, y = np.meshgrid(np.arange(8) / 8, np.arange(12) / 12, indexing="ij")
    loads = np.geomspace(10.0, 1000.0, 48)
    table = 1e-9 * (np.cos(2.0 * np.pi * x) + 0.3 * np.sin(2.0 * np.pi * y))[..., None] * np.log(loads / 5.0)
    directions, cell = np.array([[0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]), np.array([40e-6, 15e-6])
    wave = GapCorrectionTable(loads, table, cell, np.array([1.0, 2.0, 3.0]), directions)
    force = np.array([40.0, 40.0, 40.0, 90.0, 0.0])
    places = np.array([[0.3, 0.1], [7.3, -0.9], [-0.7, 4.1], [0.3, 0.6], [0.3, 0.1]])
    centres = wave.middle_node + (places * cell) @ directions
    found = wave.interpolate(force, centres)
    for k, sign, grown in ((slice(3), 1.0, np.log(8.0)), (slice(3, 4), -1.0, np.log(18.0))):
        expected = 1e-9 * (np.cos(0.6 * np.pi) + sign * 0.3 * np.sin(0.2 * np.pi)) * grown
        assert found[k] == pytest.approx(np.full(len(found[k]), expected), abs=4e-3 * 1e-9 * grown)
    assert found[4] == 0.0
    off = centres + 3e-3 * np.array([1.0, 0.0, 0.0])  # along the normal: the same place
    assert wave.interpolate(force, off) == pytest.approx(found, rel=1e-9)
    far = wave.interpolate(np.array([1.25, 8000.0]), np.tile(wave.middle_node, (2, 1)))
    assert far == pytest.approx(1e-9 * np.array([np.log(2.0) / 4.0, 4.0 * np.log(200.0)]), rel=1e-9)


def law(loads):
    """Hertz's approach, with some of every power that `fit_smooth_force_law` knows."""
    parts = zip((0.3, 1.0, 0.02, -0.004), POWERS, strict=True)
    return 1e-8 * sum(factor * loads ** (2.0 / 3.0 + power) for factor, power in parts)


def test_waves_go_and_the_law_stays():
    """Nodes that the ellipse's edge passes come at equal steps of F^(1/3): of a wave of 0.1 % a twentieth is left."""
    assert fit_smooth_force_law(LOADS, law(LOADS)) == pytest.approx(law(LOADS), rel=1e-12)
    wave = 1e-3 * np.sin(2.0 * np.pi * 2.5 * np.cbrt(LOADS))
    found = fit_smooth_force_law(LOADS, law(LOADS) * (1.0 + wave)) / law(LOADS) - 1.0
    inner = slice(6, -6)
    assert np.abs(found[inner]).max() < 5e-5
    assert np.abs(np.diff(found)[inner]).max() < 0.02 * np.abs(np.diff(wave)).max()
