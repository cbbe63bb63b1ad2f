"""Grid convergence after Celik et al. 2008, on sequences of known order and on their published example."""

import numpy as np
import pytest

from compare.convergence import observe


@pytest.mark.parametrize("order", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.0)])
def test_known_order_and_limit(order: float, sizes: tuple[float, float, float]) -> None:
    values = [5.0 + 0.3 * h**order for h in sizes]
    found = observe(values, sizes)
    assert found.monotone
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.extrapolated == pytest.approx(5.0, abs=1e-9)
    assert found.uncertainty == pytest.approx(1.25 * 0.3 * sizes[2] ** order, rel=1e-9)


def test_published_example() -> None:
    """Celik et al. 2008, Table 1, first column: r21 = 1.5, r32 = 1.333, phi = 6.063, 5.972, 5.863 give p = 1.53."""
    found = observe([5.863, 5.972, 6.063], [1.5 * 1.333, 1.5, 1.0])
    assert found.order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated == pytest.approx(6.1685, abs=2e-3)
    assert found.uncertainty / 6.063 == pytest.approx(0.022, abs=5e-4)


def test_scatter_gives_a_band() -> None:
    found = observe([1.0, 1.2, 1.1], [3.0, 2.0, 1.0])
    assert not found.monotone
    assert found.order is None
    assert found.extrapolated is None
    assert found.uncertainty == pytest.approx(0.2)


def test_equal_values_have_no_uncertainty() -> None:
    assert observe([2.0, 2.0, 2.0], [3.0, 2.0, 1.0]).uncertainty == 0.0
    assert np.isfinite(observe([2.0, 2.0, 2.1], [3.0, 2.0, 1.0]).uncertainty)
