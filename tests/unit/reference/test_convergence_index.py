"""Grid convergence by least squares, alone and pooled: known orders, labels, and the share of truths that U holds."""

from itertools import product

import numpy as np
import pytest

from rollbench.compare.reference import convergence
from rollbench.compare.reference.convergence import grid_convergence, pooled_grid_uncertainty

SIZES = {3: 1.0 / np.array([1.6, 2.2, 3.0]), 4: 1.0 / np.array([1.6, 2.2, 3.0, 4.1])}


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.0), (3.0, 2.2, 1.4, 1.0)])
def test_known_order_and_limit(order: float, sizes: tuple[float, ...]) -> None:
    truth, values = 5.0, [5.0 + 0.3 * h**order for h in sizes]
    found = grid_convergence(values, sizes)
    assert (found.kind, found.kind_text) == (convergence.MONOTONE, f"monotone, order {order:.2f}")
    assert found.credible_order == pytest.approx(order, rel=1e-6)
    assert found.extrapolated_value == pytest.approx(truth, abs=1e-7)
    assert found.uncertainty >= 1.25 * (values[-1] - truth) * (1.0 - 1e-6)
    together = pooled_grid_uncertainty(np.column_stack([values, np.array(values) * -2.0 + 1.0]), sizes)
    assert together == pytest.approx([1.25 * 0.3, 1.25 * 0.6], rel=1e-5)


@pytest.mark.parametrize(("order", "believed"), [(0.498, False), (0.502, True), (1.998, True), (2.002, False)])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 2.2, 1.4, 1.0)])
def test_orders_from_a_half_to_two_are_believed(order: float, believed: bool, sizes: tuple[float, ...]) -> None:
    found = grid_convergence([5.0 + 0.3 * h**order for h in sizes], sizes)
    assert (found.kind == convergence.MONOTONE) is believed
    assert found.fitted_order == pytest.approx(order, abs=1e-5)
    assert (found.extrapolated_value is not None) is believed


def test_published_orders() -> None:
    """Celik et al. 2008, Table 1, first column: r = 1.5, 1.333, phi = 6.063, 5.972, 5.863 give p = 1.53, 6.1685."""
    found = grid_convergence([5.863, 5.972, 6.063], [1.5 * 1.333, 1.5, 1.0])
    assert found.credible_order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated_value == pytest.approx(6.1685, abs=2e-3)
    assert found.uncertainty >= 0.022 * 6.063


LABELLED = [
    ([1.0, 1.2, 1.1], convergence.NOT_MONOTONE, "not monotone"),
    ([1.0, 1.4, 1.42], convergence.OUT_OF_RANGE, "order out of range (p = "),
    ([1.0, 1.4, 1.4 + 1e-5], convergence.OUT_OF_RANGE, "order out of range (p above 12)"),
    ([1.0, 1.1, 1.3], convergence.OUT_OF_RANGE, "order out of range (p = "),
    ([0.0, 0.0, 0.0], convergence.HELD, "held (zero by a support or no load)"),
    ([2.0, 2.0, 2.0], convergence.HELD, "held (zero by a support or no load)"),
    ([2.0, 2.1], convergence.TOO_FEW, "fewer than three levels"),
]


@pytest.mark.parametrize(("values", "label", "text"), LABELLED)
def test_labels_say_why_there_is_no_order(values: list[float], label: str, text: str) -> None:
    found = grid_convergence(values, [2.0, 1.5, 1.0] if len(values) > 2 else [2.0, 1.4])
    assert found.kind_text.startswith(text)
    assert (found.kind, found.credible_order) == (label, None)
    assert found.uncertainty == 0.0 if label == convergence.HELD else found.uncertainty > abs(values[-1] - values[-2])


def test_few_levels_and_the_size_of_one() -> None:
    assert convergence.relative_cell_size({"b_over_h": 2.0, "fine": 1.0}) == 0.5
    assert grid_convergence([2.0, 2.5], [2.0, 1.0]).uncertainty == pytest.approx(1.5)
    assert grid_convergence([2.0], [1.0]).uncertainty is None
    two = pooled_grid_uncertainty([[1.0, 5.0, 3.0], [1.3, 5.0 + 1e-3, 3.0]], [2.0, 1.0])
    rms = np.sqrt((0.3**2 + 1e-3**2) / 2.0)
    assert two == pytest.approx([0.9, 3.0 * rms, 0.0])
    assert np.isnan(pooled_grid_uncertainty([[1.0, 2.0]], [1.0])).all()
    for sizes in ([3.0, 2.0, 1.0], [2.0, 1.0]):
        assert pooled_grid_uncertainty(np.ones((len(sizes), 2)), sizes) == pytest.approx([0.0, 0.0])


def drawn(rng: np.random.Generator, levels: int, order: float, noise: float, m: int) -> tuple[np.ndarray, np.ndarray]:
    """Values with truth 0: random alpha, scatter as a multiple of the typical step between the finest levels."""
    h = SIZES[levels] / SIZES[levels][-1]
    if np.isinf(noise):
        return rng.normal(size=(levels, m)), h
    alpha = rng.normal(size=m)
    return alpha * h[:, None] ** order + noise * (h[-2] ** order - 1.0) * rng.normal(size=(levels, m)), h


def shares_held(rng: np.random.Generator, levels: int, orders, count: int, repeats: int, bars) -> list[float]:
    """Shares of truths within their bars for each order and scatter, of quantities that are drawn ``count`` at a time."""
    shares = []
    for order, noise in product(orders, (0.1, 0.5, 2.0, np.inf)):
        drawings = [drawn(rng, levels, order, noise, count) for _ in range(repeats)]
        shares.append(np.mean([np.abs(y[-1]) <= bars(y, h) for y, h in drawings]))
    return shares


@pytest.mark.slow
@pytest.mark.parametrize("levels", [3, 4])
def test_pooled_uncertainty_holds_the_truth(levels: int) -> None:
    """In 95 % of all contacts over orders and scatter; nowhere in fewer than 88 %. 64 contacts share an order."""
    orders = 0.8, 1.0, 1.5, 2.0, 3.0
    shares = shares_held(np.random.default_rng(20), levels, orders, 64, 4, pooled_grid_uncertainty)
    assert min(shares) > 0.88
    assert np.mean(shares) > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("levels", [3, 4])
def test_a_single_quantity_s_uncertainty_holds_the_truth(levels: int) -> None:
    def bars(values, sizes):
        return [grid_convergence(column, sizes).uncertainty for column in values.T]

    shares = shares_held(np.random.default_rng(21), levels, (1.0, 1.5, 2.0, 3.0), 40, 1, bars)
    assert min(shares) > 0.8
    assert np.mean(shares) > 0.94
