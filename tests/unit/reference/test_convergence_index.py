"""Grid convergence by least squares, alone and pooled: known orders, labels, and the share of truths that U holds."""

import numpy as np
import pytest

from compare.reference.convergence import (
    HELD,
    MONOTONE,
    NOT_MONOTONE,
    OUT_OF_RANGE,
    TOO_FEW,
    common_order,
    observe,
    pool,
    representative_size,
)
from compare.reference.grid_fits import fixed, searched

SIZES = {3: 1.0 / np.array([1.6, 2.2, 3.0]), 4: 1.0 / np.array([1.6, 2.2, 3.0, 4.1])}


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.0), (3.0, 2.2, 1.4, 1.0)])
def test_known_order_and_limit(order: float, sizes: tuple[float, ...]) -> None:
    truth, values = 5.0, [5.0 + 0.3 * h**order for h in sizes]
    found = observe(values, sizes)
    assert (found.label, found.text) == (MONOTONE, f"monotone, order {order:.2f}")
    assert found.order == pytest.approx(order, rel=1e-6)
    assert found.extrapolated == pytest.approx(truth, abs=1e-7)
    assert found.uncertainty >= 1.25 * (values[-1] - truth) * (1.0 - 1e-6)
    together = pool(np.column_stack([values, np.array(values) * -2.0 + 1.0]), sizes)
    assert together.order == pytest.approx(order, rel=1e-6)
    assert [c.uncertainty for c in together.each] == pytest.approx([1.25 * 0.3, 1.25 * 0.6], rel=1e-5)
    assert together.each[1].extrapolated == pytest.approx(1.0 - 2.0 * truth, abs=1e-7)


def test_units_scale_and_offset_change_nothing_else() -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(size=(4, 6)) * 0.1 + SIZES[4][:, None] ** 1.5
    plain, moved = pool(values, SIZES[4]), pool(4e-6 - 1e-6 * values, 7.0 * SIZES[4])
    assert moved.order == pytest.approx(plain.order, rel=1e-4)
    for a, b in zip(plain.each, moved.each, strict=True):
        assert b.uncertainty == pytest.approx(1e-6 * a.uncertainty, rel=1e-4)
    one, other = observe(values[:, 0], SIZES[4]), observe(3.0 - 2.0 * values[:, 0], SIZES[4])
    assert other.uncertainty == pytest.approx(2.0 * one.uncertainty, rel=1e-6)


def test_published_orders() -> None:
    """Celik et al. 2008, Table 1, first column: r = 1.5, 1.333, phi = 6.063, 5.972, 5.863 give p = 1.53, 6.1685."""
    found = observe([5.863, 5.972, 6.063], [1.5 * 1.333, 1.5, 1.0])
    assert found.order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated == pytest.approx(6.1685, abs=2e-3)
    assert found.uncertainty >= 0.022 * 6.063


@pytest.mark.parametrize(
    ("values", "label", "text"),
    [
        ([1.0, 1.2, 1.1], NOT_MONOTONE, "not monotone"),
        ([1.0, 1.4, 1.42], OUT_OF_RANGE, "order out of range (p = 7.27)"),
        ([1.0, 1.4, 1.4 + 1e-5], OUT_OF_RANGE, "order out of range (p above 12)"),
        ([1.0, 1.1, 1.3], OUT_OF_RANGE, "order out of range (p = -1.18)"),
        ([0.0, 0.0, 0.0], HELD, "held (zero by a support or no load)"),
        ([2.0, 2.0, 2.0], HELD, "held (zero by a support or no load)"),
        ([2.0, 2.1], TOO_FEW, "fewer than three levels"),
    ],
)
def test_labels_say_why_there_is_no_order(values: list[float], label: str, text: str) -> None:
    sizes = [3.0, 2.0, 1.4][-len(values) :] if len(values) < 3 else [2.0, 1.5, 1.0]
    found = observe(values, sizes)
    if text.startswith("order out of range (p ="):
        shown = float(found.text.split("=")[1].rstrip(")"))
        expected = searched(np.array(values)[:, None], np.array(sizes)).order
        assert shown == pytest.approx(expected, abs=0.006)
        assert not 0.5 <= shown <= 2.0
    else:
        assert found.text == text
    assert found.label == label
    assert found.order is None
    assert pool(np.array(values)[:, None], sizes).labels == {label: 1}
    if label == HELD:
        assert found.uncertainty == 0.0
    else:
        assert found.uncertainty > abs(values[-1] - values[-2])


def test_few_levels() -> None:
    assert observe([2.0, 2.5], [2.0, 1.0]).uncertainty == pytest.approx(1.5)
    assert observe([2.0], [1.0]).uncertainty is None
    two = pool([[1.0, 5.0, 3.0], [1.3, 5.0 + 1e-3, 3.0]], [2.0, 1.0])
    rms = np.sqrt((0.3**2 + 1e-3**2) / 2.0)
    assert [c.uncertainty for c in two.each] == pytest.approx([0.9, 3.0 * rms, 0.0])
    assert (two.order, two.interval, two.text) == (None, None, "fewer than three levels")
    assert [c.uncertainty for c in pool([[1.0, 2.0]], [1.0]).each] == [None, None]
    held = pool(np.ones((3, 2)), [3.0, 2.0, 1.0])
    assert (held.labels, held.order, held.text) == ({HELD: 2}, None, HELD)


@pytest.mark.parametrize(
    ("values", "sizes"), [([1.0, 2.0], [1.0, 2.0]), ([1.0, 2.0], [1.0]), ([1.0, np.nan], [2.0, 1.0]), ([], [])]
)
def test_what_does_not_go_together_is_refused(values: list[float], sizes: list[float]) -> None:
    with pytest.raises(ValueError, match="sizes"):
        observe(values, sizes)


def test_fixed_orders_fit_their_own() -> None:
    h = SIZES[4] / SIZES[4][-1]
    y = np.column_stack([1.0 + h, 2.0 - 3.0 * h**2, 0.5 * h + h**2])
    found = {(f.form, f.weighted): f for f in fixed(y, h, both=True)}
    assert len(found) == 6
    for weighted in (False, True):
        for k, form in enumerate(("first order", "second order", "first and second order")):
            assert np.abs(found[form, weighted].residual[:, k]).max() < 1e-12
            assert found[form, weighted].limit[k] == pytest.approx((1.0, 2.0, 0.0)[k], abs=1e-9)
    assert len(fixed(y[1:], h[1:], both=True)) == 4


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
                held += [abs(c.values[-1]) <= c.uncertainty for c in pool(y, h).each]
            shares.append(np.mean(held))
            assert shares[-1] > 0.88, (order, noise)
    assert np.mean(shares) > 0.95


@pytest.mark.parametrize("levels", [3, 4])
def test_with_the_method_s_order_scatter_makes_no_errors_of_low_order(levels: int) -> None:
    """Little but scatter: the method's order gives a bar of some scatter that holds the truth; own orders a larger one."""
    rng = np.random.default_rng(26)
    for order in (2.0, 3.0):
        ratio, held, taken = [], [], []
        for _ in range(10):
            y, h = drawn(rng, levels, order, 4.0, 64)
            own, given = pool(y, h), pool(y, h, (2.0, 3.5))
            held += [abs(c.values[-1]) <= c.uncertainty for c in given.each]
            ratio.append(max(c.uncertainty for c in given.each) / max(c.uncertainty for c in own.each))
            taken.append(given.by_method)
            assert given.interval == own.interval
            assert ("of the method" in given.text) == given.by_method
        assert np.mean(held) > 0.9
        assert any(taken)
        assert max(ratio) <= 1.0 + 1e-9
        assert np.mean(ratio) < 0.9


def test_values_that_contradict_the_method_s_order_keep_their_own() -> None:
    """Contacts of a scene count as one quantity in that test: clean values contradict, scatter that they share does not."""
    rng = np.random.default_rng(27)
    y, h = drawn(rng, 4, 1.0, 0.02, 64)
    given = pool(y, h, (2.0, 3.5))
    assert not given.by_method
    assert given == pool(y, h)
    shared = y + 0.2 * np.ptp(y) * np.array([[0.0], [0.0], [1.0], [0.0]])
    assert pool(shared, h, (2.0, 3.5)).by_method


def test_common_order_of_many_scenes() -> None:
    """Two scenes in which single contacts say nothing; held quantities take no part; nothing that moves is refused."""
    rng = np.random.default_rng(28)
    y, h = drawn(rng, 3, 2.5, 0.3, 400)
    order, (low, high) = common_order(np.hstack([y, np.full((3, 9), 7.0)]), h)
    assert low < 2.5 < high
    assert abs(order - 2.5) < 0.4
    with pytest.raises(ValueError, match="moving"):
        common_order(np.ones((3, 2)), h)
    with pytest.raises(ValueError, match="levels"):
        common_order(y[1:], h[1:])


@pytest.mark.parametrize("levels", [3, 4])
def test_a_single_quantity_s_uncertainty_holds_the_truth(levels: int) -> None:
    rng = np.random.default_rng(21)
    shares = []
    for order in (1.0, 1.5, 2.0, 3.0):
        for noise in (0.1, 0.5, 2.0, np.inf):
            y, h = drawn(rng, levels, order, noise, 40)
            found = [observe(column, h) for column in y.T]
            shares.append(np.mean([abs(c.values[-1]) <= c.uncertainty for c in found]))
            assert shares[-1] > 0.8, (order, noise)
    assert np.mean(shares) > 0.94


@pytest.mark.parametrize("levels", [3, 4])
def test_scatter_alone_does_not_let_the_uncertainty_collapse(levels: int) -> None:
    """Every contact keeps the scatter of all, however close its own values happen to lie; no order is quoted."""
    rng = np.random.default_rng(22)
    for _ in range(10):
        y, h = drawn(rng, levels, 1.0, np.inf, 64)
        found = pool(y, h)
        assert min(c.uncertainty for c in found.each) > 0.8
        assert all(c.extrapolated is None for c in found.each)


def test_pooling_finds_the_order_that_single_contacts_hide() -> None:
    rng = np.random.default_rng(23)
    y, h = drawn(rng, 4, 1.5, 0.3, 64)
    found = pool(y, h)
    own = np.array([c.order for c in found.each if c.order is not None])
    assert abs(found.order - 1.5) < 0.2 < np.std(own)
    assert found.interval[0] < 1.5 < found.interval[1]
    assert found.labels[NOT_MONOTONE] > 5
    truth = np.array([c.extrapolated for c in found.each])
    assert np.sqrt((truth**2).mean()) < 0.6 * np.sqrt((y[-1] ** 2).mean())


def test_an_order_above_the_range_counts_as_second() -> None:
    h = SIZES[4] / SIZES[4][-1]
    rng = np.random.default_rng(24)
    alpha = rng.normal(size=30)
    found = pool(alpha * h[:, None] ** 3.5, h)
    assert found.order is None
    assert found.fitted_order == pytest.approx(3.5, rel=1e-6)
    assert all(c.uncertainty > 2.0 * abs(a) for a, c in zip(alpha, found.each, strict=True))
    assert "out of range" in found.text


def test_size_of_a_level() -> None:
    assert representative_size({"b_over_h": 2.0, "fine": 1.0}) == 0.5
