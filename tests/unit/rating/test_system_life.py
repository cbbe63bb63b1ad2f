"""Life of several sets together: closed forms, the probabilities that it is made of, and drawn lives."""

import numpy as np
import pytest

from rollbench.lowfi.rating.life import SLOPE, life_of_parts_in_series


def test_equal_slopes_have_a_closed_form():
    assert life_of_parts_in_series([(80.0, SLOPE)] * 5) == pytest.approx(80.0 * 5.0 ** (-1.0 / SLOPE), rel=1e-10)
    lives = np.array([80.0, 120.0, 1e5])
    both = (lives**-SLOPE).sum() ** (-1.0 / SLOPE)
    assert life_of_parts_in_series([(x, SLOPE) for x in lives]) == pytest.approx(both, rel=1e-10)
    assert life_of_parts_in_series([(80.0, SLOPE)]) == 80.0


def test_nine_of_ten_reach_it_and_it_is_below_the_shortest():
    parts = [(100.0, 10 / 9), (150.0, 9 / 8), (160.0, 9 / 8), (1e4, 10 / 9)]
    life = life_of_parts_in_series(parts)
    assert life < 100.0
    assert np.prod([0.9 ** ((life / x) ** slope) for x, slope in parts]) == pytest.approx(0.9, rel=1e-10)
    rng, first = np.random.default_rng(4), np.full(400_000, np.inf)
    for x, slope in parts:
        scale = x / (-np.log(0.9)) ** (1.0 / slope)
        first = np.minimum(first, scale * rng.weibull(slope, first.size))
    assert np.quantile(first, 0.1) == pytest.approx(life, rel=0.01)
