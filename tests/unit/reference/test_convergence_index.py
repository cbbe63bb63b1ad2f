"""Grid convergence by least squares, alone and pooled: known orders, labels, and the share of truths that U holds."""

import numpy as np
import pytest

from rollbench.compare.reference import convergence

SIZES = {3: 1.0 / np.array([1.6, 2.2, 3.0]), 4: 1.0 / np.array([1.6, 2.2, 3.0, 4.1])}


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.0), (3.0, 2.2, 1.4, 1.0)])
def test_known_order_and_limit(order: float, sizes: tuple[float, ...]) -> None:
    truth, values = 5.0, [5.0 + 0.3 * h**order for h in sizes]
    found = convergence.grid_convergence(values, sizes)
    assert (found.kind, found.kind_text) == (convergence.MONOTONE, f"monotone, order {order:.2f}")
    assert found.credible_order == pytest.approx(order, rel=1e-6)
    assert found.extrapolated_value == pytest.approx(truth, abs=1e-7)
    assert found.uncertainty >= 1.25 * (values[-1] - truth) * (1.0 - 1e-6)
    together = convergence.pooled_grid_uncertainty(np.column_stack([values, np.array(values) * -2.0 + 1.0]), sizes)
    assert together == pytest.approx([1.25 * 0.3, 1.25 * 0.6], rel=1e-5)


@pytest.mark.parametrize(("order", "believed"), [(0.498, False), (0.502, True), (1.998, True), (2.002, False)])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 2.2, 1.4, 1.0)])
def test_orders_from_a_half_to_two_are_believed(order: float, believed: bool, sizes: tuple[float, ...]) -> None:
    found = convergence.grid_convergence([5.0 + 0.3 * h**order for h in sizes], sizes)
    assert (found.kind == convergence.MONOTONE) is believed
    assert found.fitted_order == pytest.approx(order, abs=1e-5)
    assert (found.extrapolated_value is not None) is believed


def test_units_scale_and_offset_change_nothing_else() -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(size=(4, 6)) * 0.1 + SIZES[4][:, None] ** 1.5
    plain, moved = (
        convergence.pooled_grid_uncertainty(values, SIZES[4]),
        convergence.pooled_grid_uncertainty(4e-6 - 1e-6 * values, 7.0 * SIZES[4]),
    )
    assert moved == pytest.approx(1e-6 * plain, rel=1e-4)
    one, other = (
        convergence.grid_convergence(values[:, 0], SIZES[4]),
        convergence.grid_convergence(3.0 - 2.0 * values[:, 0], SIZES[4]),
    )
    assert other.uncertainty == pytest.approx(2.0 * one.uncertainty, rel=1e-6)


def test_published_orders() -> None:
    """Celik et al. 2008, Table 1, first column: r = 1.5, 1.333, phi = 6.063, 5.972, 5.863 give p = 1.53, 6.1685."""
    found = convergence.grid_convergence([5.863, 5.972, 6.063], [1.5 * 1.333, 1.5, 1.0])
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
    sizes = [2.0, 1.5, 1.0] if len(values) > 2 else [2.0, 1.4]
    found = convergence.grid_convergence(values, sizes)
    if text.endswith("(p = "):
        searched = convergence.fit_searched_order(np.array(values)[:, None], np.array(sizes)).order
        assert not 0.5 <= searched <= 2.0
        text += f"{searched:.2f})"
    assert (found.kind_text, found.kind, found.credible_order) == (text, label, None)
    assert found.uncertainty == 0.0 if label == convergence.HELD else found.uncertainty > abs(values[-1] - values[-2])


def test_few_levels_and_the_size_of_one() -> None:
    assert convergence.relative_cell_size({"b_over_h": 2.0, "fine": 1.0}) == 0.5
    assert convergence.grid_convergence([2.0, 2.5], [2.0, 1.0]).uncertainty == pytest.approx(1.5)
    assert convergence.grid_convergence([2.0], [1.0]).uncertainty is None
    two = convergence.pooled_grid_uncertainty([[1.0, 5.0, 3.0], [1.3, 5.0 + 1e-3, 3.0]], [2.0, 1.0])
    rms = np.sqrt((0.3**2 + 1e-3**2) / 2.0)
    assert two == pytest.approx([0.9, 3.0 * rms, 0.0])
    assert np.isnan(convergence.pooled_grid_uncertainty([[1.0, 2.0]], [1.0])).all()
    for sizes in ([3.0, 2.0, 1.0], [2.0, 1.0]):
        assert convergence.pooled_grid_uncertainty(np.ones((len(sizes), 2)), sizes) == pytest.approx([0.0, 0.0])


UNLIKE = [([1.0, 2.0], [1.0, 2.0]), ([1.0, 2.0], [1.0]), ([1.0, np.nan], [2.0, 1.0]), ([], [])]


@pytest.mark.parametrize(("values", "sizes"), UNLIKE)
def test_what_does_not_go_together_is_refused(values: list[float], sizes: list[float]) -> None:
    with pytest.raises(ValueError, match="sizes"):
        convergence.grid_convergence(values, sizes)


def test_fixed_orders_fit_their_own() -> None:
    h = SIZES[4] / SIZES[4][-1]
    y = np.column_stack([1.0 + h, 2.0 - 3.0 * h**2, 0.5 * h + h**2])
    found = {
        (f.fitted_function, f.weighted_by_cell_size): f for f in convergence.fit_fixed_orders(y, h, with_mixed_order=True)
    }
    assert len(found) == 6
    for weighted in (False, True):
        for k, form in enumerate(("first order", "second order", "first and second order")):
            assert np.abs(found[form, weighted].residuals[:, k]).max() < 1e-12
            assert found[form, weighted].limits[k] == pytest.approx((1.0, 2.0, 0.0)[k], abs=1e-9)
    assert len(convergence.fit_fixed_orders(y[1:], h[1:], with_mixed_order=True)) == 4


def drawn(rng: np.random.Generator, levels: int, order: float, noise: float, m: int) -> tuple[np.ndarray, np.ndarray]:
    """Values with truth 0: random alpha, scatter as a multiple of the typical step between the finest levels."""
    h = SIZES[levels] / SIZES[levels][-1]
    alpha = rng.normal(size=m) if np.isfinite(noise) else np.zeros(m)
    scatter = noise * (h[-2] ** order - 1.0) if np.isfinite(noise) else 1.0
    return alpha * h[:, None] ** order + scatter * rng.normal(size=(levels, m)), h


@pytest.mark.parametrize("levels", [3, 4])
def test_pooled_uncertainty_holds_the_truth(levels: int) -> None:
    """In 95 % of all contacts over orders and scatter; nowhere in fewer than 90 %."""
    rng = np.random.default_rng(20)
    shares = []
    for order in (0.8, 1.0, 1.5, 2.0, 3.0):
        for noise in (0.1, 0.5, 2.0, np.inf):
            held = []
            for _ in range(4):
                y, h = drawn(rng, levels, order, noise, 64)
                held += list(np.abs(y[-1]) <= convergence.pooled_grid_uncertainty(y, h))
            shares.append(np.mean(held))
            assert shares[-1] > 0.88, (order, noise)
    assert np.mean(shares) > 0.95


@pytest.mark.parametrize("levels", [3, 4])
def test_a_single_quantity_s_uncertainty_holds_the_truth(levels: int) -> None:
    rng = np.random.default_rng(21)
    shares = []
    for order in (1.0, 1.5, 2.0, 3.0):
        for noise in (0.1, 0.5, 2.0, np.inf):
            y, h = drawn(rng, levels, order, noise, 40)
            found = [convergence.grid_convergence(column, h) for column in y.T]
            shares.append(np.mean([abs(c.values_by_level[-1]) <= c.uncertainty for c in found]))
            assert shares[-1] > 0.8, (order, noise)
    assert np.mean(shares) > 0.94


@pytest.mark.parametrize("levels", [3, 4])
def test_scatter_alone_does_not_let_the_uncertainty_collapse(levels: int) -> None:
    """Every quantity keeps the scatter of all, however close its own values happen to lie."""
    rng = np.random.default_rng(22)
    for _ in range(10):
        y, h = drawn(rng, levels, 1.0, np.inf, 64)
        assert convergence.pooled_grid_uncertainty(y, h).min() > 0.8
