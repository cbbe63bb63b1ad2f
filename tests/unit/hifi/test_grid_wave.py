"""The law of the force that takes the place of an approach that waves."""

import numpy as np
import pytest

from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.bodies.grid_wave import POWERS, smooth

LOADS = np.geomspace(20.0, 600.0, 64)


def law(loads):
    """Hertz's approach, with some of every power that `smooth` knows."""
    parts = zip((0.3, 1.0, 0.02, -0.004), POWERS, strict=True)
    return 1e-8 * sum(factor * loads ** (2.0 / 3.0 + power) for factor, power in parts)


def test_a_law_of_its_own_powers_stays():
    assert smooth(LOADS, law(LOADS)) == pytest.approx(law(LOADS), rel=1e-12)


def test_waves_go_and_the_law_stays():
    """Nodes that the ellipse's edge passes come at equal steps of F^(1/3): of a wave of 0.1 % a twentieth is left."""
    wave = 1e-3 * np.sin(2.0 * np.pi * 2.5 * np.cbrt(LOADS))
    found = smooth(LOADS, law(LOADS) * (1.0 + wave)) / law(LOADS) - 1.0
    inner = slice(6, -6)
    assert np.abs(found[inner]).max() < 5e-5
    assert np.abs(np.diff(found)[inner]).max() < 0.02 * np.abs(np.diff(wave)).max()


def test_what_changes_from_cell_to_cell_is_no_wave(monkeypatch):
    """A compliance that rises across and falls along the zone, and a wave with the cells and their nodes: only the wave is
    periodic, the mean is the approach in the middle without it, and each place begins with its neighbour's closed pairs."""
    begun = []

    def wave(x, y):
        return 1e-3 * np.cos(2.0 * np.pi * x) + 5e-4 * np.cos(4.0 * np.pi * y) * np.cos(2.0 * np.pi * x)

    def approach(*given, **_):
        loads, (x, y), start = given[4:]
        begun.append((start, (x, y)))
        return loads ** (2.0 / 3.0) * (1.0 + 4e-3 * x - 1e-3 * y + wave(x, y)), (x, y)

    monkeypatch.setattr(grid_wave, "approaches_at", approach)
    table = grid_wave.periodic_approaches(None, 0, None, None, LOADS, (4, 8))[0] / LOADS ** (2.0 / 3.0)
    x, y = np.meshgrid(np.arange(4) / 4, np.arange(8) / 8, indexing="ij")
    np.testing.assert_allclose(table, (1.0 + wave(x, y))[..., None] * np.ones(LOADS.size), rtol=0, atol=1e-12)
    assert table.mean(axis=(0, 1)) == pytest.approx(np.ones(LOADS.size), abs=1e-12)
    apart = [np.abs(np.subtract(start, place)).max() for start, place in begun[5:]]
    assert sorted(apart)[-2] <= 0.25


def test_the_mean_over_a_cell_takes_the_wave_out(monkeypatch):
    waving = lambda *given, **_: (np.sqrt(given[4]) * (2.0 + np.cos(2.0 * np.pi * sum(given[5]))), None)  # noqa: E731
    monkeypatch.setattr(grid_wave, "approaches_at", waving)
    assert grid_wave.mean_approaches(None, 0, None, None, LOADS) == pytest.approx(2.0 * np.sqrt(LOADS), rel=1e-12)
