"""Brent's method is that of scipy, digit for digit; near points are found alike with a tree and without."""

import numpy as np
import pytest
from scipy import optimize

from rollbench.meshes import numerics


def test_roots_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    compared = 0
    while compared < 60:
        c, (low, high) = rng.normal(size=5), np.sort(rng.normal(size=2))
        tolerance = 10.0 ** rng.uniform(-20.0, -6.0)

        def f(x: float, c: np.ndarray = c) -> float:
            return float(np.polyval(c, x) + c[0] * np.exp(x))

        if f(low) * f(high) < 0.0:
            theirs = optimize.brentq(f, low, high, xtol=tolerance, maxiter=300)
            assert numerics.brentq(f, low, high, xtol=tolerance) == theirs
            compared += 1


def test_a_step_is_bisected_and_one_sign_is_refused() -> None:
    f = lambda x: -1.0 if x < 0.3 else 1.0  # noqa: E731
    assert numerics.brentq(f, 0.0, 1.0) == optimize.brentq(f, 0.0, 1.0)
    with pytest.raises(ValueError, match="different signs"):
        numerics.brentq(lambda x: x + 2.0, 0.0, 1.0)
