"""What condensed bodies know of each contact's own approach: contacts by active sets, the fitted law; the grid's wave."""

import numpy as np
import pytest

from rollbench.hifi.bodies.grid_wave import GridWave, approaches
from rollbench.meshes.condensed import CondensedBodies

FORCES = np.geomspace(40.0, 600.0, 16)
C = 1.4e-7


def bodies(local):
    """Two sides of a ring whose own approaches are given."""
    k = len(local)
    return CondensedBodies(
        "none",
        1,
        np.array([0.0, 3.0]),
        0.0,
        np.eye(2),
        np.eye(2),
        np.eye(k),
        np.array(local),
        np.tile(FORCES, (k, 1)),
        np.array([C, 2.0 * C]),
    )


def test_the_law_of_a_side_is_found_again_whatever_the_force():
    law = [(-2e-9, 9e-12), (1e-10, -3e-11)]
    found = bodies([e + h * np.cbrt(FORCES) for e, h in law])
    for side, expected in zip((0, 3), law, strict=True):
        assert found.own_law(side) == pytest.approx(expected, rel=1e-9)
        assert found.scatter(side) < 1e-12


def test_scatter_is_a_share_of_the_approach():
    wave = 0.002 * np.where(np.arange(FORCES.size) % 2, 1.0, -1.0) * C * np.cbrt(1.0 / FORCES)
    found = bodies([-2e-9 + wave, -2e-9 + wave])
    assert found.scatter(0) == pytest.approx(0.002, rel=0.05)
    assert found.scatter(3) == pytest.approx(0.001, rel=0.05)  # its approach is twice as large
    e, h = found.own_law(0)
    law = e + h * np.cbrt(FORCES)
    assert np.abs(law + 2e-9).max() < 0.5 * np.abs(wave).max()


def test_contacts_on_springs():
    """Springs of their own: each carries what the approach closes beyond its gap."""
    rng = np.random.default_rng(3)
    n = 40
    springs, gap, close = rng.uniform(1e-9, 2e-9, n), rng.uniform(0.0, 2e-6, n), rng.uniform(0.9, 1.0, n)
    loads = np.geomspace(1.0, 1e4, 5)
    found, closed = approaches(np.diag(springs), gap, close, loads)
    for load, approach, pairs in zip(loads, found, closed, strict=True):
        carried = np.maximum(approach * close - gap, 0.0) / springs @ close
        assert carried == pytest.approx(load, rel=1e-10)
        np.testing.assert_array_equal(pairs, approach * close > gap)
    again, same = approaches(np.diag(springs), gap, close, loads, closed[::-1])
    assert again == pytest.approx(found, rel=1e-12)
    np.testing.assert_array_equal(same, closed)


def test_the_wave_is_periodic_in_the_place_and_follows_hertz_beyond_its_forces():
    x, y = np.meshgrid(np.arange(8) / 8, np.arange(12) / 12, indexing="ij")
    loads = np.geomspace(10.0, 1000.0, 48)
    table = 1e-9 * (np.cos(2.0 * np.pi * x) + 0.3 * np.sin(2.0 * np.pi * y))[..., None] * np.log(loads / 5.0)
    directions, cell = np.array([[0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]), np.array([40e-6, 15e-6])
    wave = GridWave(loads, table, cell, np.array([1.0, 2.0, 3.0]), directions)
    force = np.array([40.0, 40.0, 40.0, 90.0, 0.0])
    places = np.array([[0.3, 0.1], [7.3, -0.9], [-0.7, 4.1], [0.3, 0.6], [0.3, 0.1]])
    centres = wave.middle + (places * cell) @ directions
    found = wave.at(force, centres)
    expected = 1e-9 * (np.cos(0.6 * np.pi) + 0.3 * np.sin(0.2 * np.pi)) * np.log(8.0)
    assert found[:3] == pytest.approx(np.full(3, expected), abs=4e-3 * 1e-9 * np.log(8.0))
    other = 1e-9 * (np.cos(0.6 * np.pi) - 0.3 * np.sin(0.2 * np.pi)) * np.log(18.0)
    assert found[3] == pytest.approx(other, abs=4e-3 * 1e-9 * np.log(18.0))
    assert found[4] == 0.0
    off = centres + 3e-3 * np.array([1.0, 0.0, 0.0])  # along the normal: the same place
    assert wave.at(force, off) == pytest.approx(found, rel=1e-9)
    far = wave.at(np.array([1.25, 8000.0]), np.tile(wave.middle, (2, 1)))
    assert far == pytest.approx(1e-9 * np.array([np.log(2.0) / 4.0, 4.0 * np.log(200.0)]), rel=1e-9)
