"""The law of the force that takes the place of an approach that waves."""

import numpy as np
import pytest

from hifi import grid_wave
from hifi.grid_wave import POWERS, smooth

LOADS = np.geomspace(20.0, 600.0, 64)


def law(loads):
    """Hertz's approach, with some of every power that `smooth` knows."""
    parts = zip((0.3, 1.0, 0.02, -0.004), POWERS, strict=True)
    return 1e-8 * sum(part * loads ** (2.0 / 3.0 + power) for part, power in parts)


def test_a_law_of_its_own_powers_stays():
    assert smooth(LOADS, law(LOADS)) == pytest.approx(law(LOADS), rel=1e-12)


def test_waves_go_and_the_law_stays():
    """Nodes that the ellipse's edge passes come at equal steps of F^(1/3): of a wave of 0.1 % a twentieth is left."""
    wave = 1e-3 * np.sin(2.0 * np.pi * 2.5 * np.cbrt(LOADS))
    found = smooth(LOADS, law(LOADS) * (1.0 + wave)) / law(LOADS) - 1.0
    inner = slice(6, -6)
    assert np.abs(found[inner]).max() < 5e-5
    assert np.abs(np.diff(found)[inner]).max() < 0.02 * np.abs(np.diff(wave)).max()


def test_what_changes_from_node_to_node_is_no_wave(monkeypatch):
    """A compliance that rises across and falls along the zone, and a wave with the nodes: only the wave is periodic, and
    the mean is the approach in the middle without it."""

    def approach(*given):
        loads, (x, y) = given[4:]
        trend = 1.0 + 4e-3 * x - 2e-3 * x * x - 1e-3 * y + 3e-3 * y * y
        return loads ** (2.0 / 3.0) * (trend + 1e-3 * np.cos(2.0 * np.pi * x) + 5e-4 * np.cos(2.0 * np.pi * y))

    monkeypatch.setattr(grid_wave, "approaches_at", approach)
    found = grid_wave.PeriodicApproach.of(None, 0, None, None, LOADS)
    hertz = LOADS ** (2.0 / 3.0)
    for place, same in (((0.3, 0.1), (-0.7, 0.1)), ((-0.5, 0.0), (0.5, 0.0)), ((0.2, 0.4), (0.2, -0.6))):
        assert found.at(place) / hertz == pytest.approx(found.at(same) / hertz, abs=1e-12)
    assert found.mean() / hertz == pytest.approx(np.ones(LOADS.size), abs=1e-12)
