"""The law of the force that takes the place of an approach that waves."""

import numpy as np
import pytest

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
