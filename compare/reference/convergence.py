"""Grid convergence by least squares after Eca and Hoekstra (J. Comput. Phys. 262 (2014) 104-130).

`grid_convergence` fits one quantity; `pooled_grid_uncertainty` fits many quantities with a common order of convergence.
Both are used for displacements, angles and friction. Contact loads do not converge with an order
(`compare.reference.estimate`).

A quantity phi on cells of size h is fitted by phi_0 + alpha h^p, with its limit phi_0, a coefficient alpha and the order p,
once with equal weights and once with weights 1 / h; the fit with the smaller standard deviation is used. If its order p is
outside `ORDERS`, it is replaced by the best of the following fits: phi_0 + alpha h, phi_0 + alpha h^2, and, if the order is
below the range and there are four levels or more, phi_0 + alpha_1 h + alpha_2 h^2 with two coefficients. With phi_1 the
value of the finest level, delta = phi_1 - phi_0 its error by the fit, sigma the standard deviation of the fit, r_1 the
residual of the finest level and Delta = (max - min) / (levels - 1), the uncertainty of phi_1 is

    U = F |delta| + sigma + |r_1|                        if sigma < Delta,
    U = 3 (sigma / Delta) (|delta| + sigma + |r_1|)      otherwise,

with F = 1.25 for an order within the range, else 3. Deviations from this method are stated in `grid_convergence` and
`pooled_grid_uncertainty`. For both, tests count the share of noisy sequences whose true value lies within U.

Quantities ``(levels, m)`` that are fitted together have the same powers of h but different limits and coefficients. Only
the order p is searched; for a given p, limits and coefficients follow by linear least squares (variable projection). Cell
sizes are relative to the finest, so that h falls to 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rollbench.meshes.arrays import Array

#: Range of credible orders of convergence (Eca and Hoekstra). Below it the cells are too coarse; above it the fitted order
#: is due to scatter.
ORDERS = (0.5, 2.0)
#: Safety factor F of the uncertainty, with a credible order and without one.
SAFE, CAREFUL = 1.25, 3.0
#: Ratio of the change of a quantity between mesh levels to its largest value, up to which the change is due to rounding
#: [1].
ROUND_OFF = 1e-6
#: Number of orders in the allowed interval for which `pooled_grid_uncertainty` computes the uncertainty.
STEPS = 16

#: Range in which the order of convergence is searched, including negative orders (values that diverge).
SEARCH = (-4.0, 12.0)
#: Confidence of the F test for orders that the data allow.
CONFIDENCE = 0.95

#: Kinds of convergence of a quantity over the mesh levels, and reasons why it has no order of convergence.
MONOTONE = "monotone"
NOT_MONOTONE = "not monotone"
OUT_OF_RANGE = "order out of range"
HELD = "held (zero by a support or no load)"
TOO_FEW = "fewer than three levels"


@dataclass(frozen=True)
class Convergence:
    """Convergence of one quantity over mesh levels of decreasing cell size: order, extrapolated value, uncertainty."""

    #: Kind of convergence, such as `MONOTONE`, or the reason why there is no credible order.
    kind: str
    #: Order fitted to the values, credible or not; None if the values do not change monotonically.
    fitted_order: float | None
    #: Value extrapolated to zero cell size; None without a credible order.
    extrapolated_value: float | None
    #: Uncertainty of the finest value, in the unit of the quantity; None with one level.
    uncertainty: float | None

    @property
    def credible_order(self) -> float | None:
        """Observed order of convergence; None if it is not credible."""
        return self.fitted_order if self.kind == MONOTONE else None

    @property
    def kind_text(self) -> str:
        """Kind of convergence as text, such as "monotone, order 1.85"."""
        if self.fitted_order is None:
            return self.kind
        if self.kind == MONOTONE:
            return f"monotone, order {self.fitted_order:.2f}"
        return f"order out of range (p {_order_text(self.fitted_order)})"


def _order_text(p: float) -> str:
    """Return the convergence order ``p`` as text: "= 1.50"; at an end of the searched range "below -4" or "above 12"."""
    low, high = SEARCH
    return f"below {low:g}" if p <= low else f"above {high:g}" if p >= high else f"= {p:.2f}"


def relative_cell_size(settings: Mapping[str, Any]) -> float:
    """Return the relative cell size of a mesh level: 1 / (number of cells per short semi-axis of a contact ellipse)."""
    return 1.0 / float(settings["b_over_h"])


def grid_convergence(values: ArrayLike, sizes: ArrayLike) -> Convergence:
    """Estimate order of convergence, extrapolated value and uncertainty of one quantity on several mesh levels.

    The method deviates from that of Eca and Hoekstra (2014) as follows. A few noisy values often show too high an order.
    Therefore the uncertainty is at least that of a fit of first order with the safety factor 1.25, unless an F test rejects
    first order. With three levels, for which Eca and Hoekstra give no estimate, the fit of an order leaves no degree of
    freedom, so its standard deviation is not known; the smallest standard deviation of the fits with fixed order replaces
    it. With two levels, the uncertainty is three times the difference of both values.

    Parameters
    ----------
    values
        Values of the quantity, coarse to fine.
    sizes
        Cell sizes; only their ratios count.

    Returns
    -------
    Convergence
        Order, extrapolated value and uncertainty.

    Raises
    ------
    ValueError
        If the sizes do not decrease, or their number differs from that of the values.
    """
    y, h = _check_values_and_cell_sizes(values, sizes)
    n, column = len(h), y[:, 0]
    if n <= 2:
        return Convergence(TOO_FEW, None, None, CAREFUL * float(np.ptp(column)) if n == 2 else None)
    if _is_equal_on_all_levels(column):
        return Convergence(HELD, None, float(column[-1]), 0.0)
    label, order = _kind_of_convergence(column, h)
    free = [fit_searched_order(y, h, weighted) for weighted in (False, True)]
    good = [f for f in free if f.order is not None and ORDERS[0] <= f.order <= ORDERS[1]]
    best = min(free, key=lambda f: f.standard_deviation)
    others = fit_fixed_orders(y, h, with_mixed_order=best.order is not None and best.order < ORDERS[0])
    fit = min(good or others, key=lambda f: f.standard_deviation)
    sigma = fit.standard_deviation if n > 3 or not good else min(f.standard_deviation for f in others)
    spread = float(np.ptp(column)) / (n - 1)
    uncertainty = float(_uncertainty_of_finest(y, fit, sigma, SAFE if good else CAREFUL, spread)[0])
    low, high = range_of_compatible_orders(y, h, best)
    if low <= 1.0 <= high:
        first = min((f for f in others if f.fitted_function == "first order"), key=lambda f: f.standard_deviation)
        uncertainty = max(uncertainty, float(_uncertainty_of_finest(y, first, sigma, SAFE, spread)[0]))
    limit = float(fit.limits[0]) if good and label == MONOTONE else None
    return Convergence(label, order, limit, uncertainty)


def pooled_grid_uncertainty(values: ArrayLike, sizes: ArrayLike) -> Array:
    """Estimate the grid uncertainty of many similar quantities that converge with one common order.

    Each quantity is fitted by limit + coefficient h^p over the cell size h, with a limit and a coefficient for each
    quantity, and with one order p for all. An F test (95 %) gives the interval of orders that the data allow. On the finest
    level, delta is the value less the fitted limit, and r_1 the residual of the fit; sigma is the standard deviation of the
    residuals. With so many degrees of freedom sigma is well known, and the formula of Eca and Hoekstra (2014) is changed:
    the uncertainty is the largest value of 1.25 |delta| + sigma + |r_1| over the allowed orders in the credible range
    `ORDERS`, 0.5 to 2. If all allowed orders are above this range, order 2 is used, with which delta is larger than with
    the fitted order. If all are below, the best fit with fixed orders is used with the factor 3 instead of 1.25, as by Eca
    and Hoekstra. For each quantity, sigma is the standard deviation of its residuals or that of the residuals of all
    quantities, whichever is larger, because one or two residuals are often small by chance.

    With two levels, the uncertainty is three times the difference of both values, or three times the RMS difference of all
    quantities if that is larger. Quantities that are equal on all levels have no uncertainty.

    Parameters
    ----------
    values
        Values of the quantities, (levels, m), coarse to fine.
    sizes
        Cell sizes; only their ratios count.

    Returns
    -------
    Array
        Uncertainties of the values on the finest level, (m,); nan with one level.

    Raises
    ------
    ValueError
        If the sizes do not decrease, or their number differs from that of the levels.
    """
    y, h = _check_values_and_cell_sizes(values, sizes)
    bars = np.zeros(y.shape[1])
    moving = np.array([not _is_equal_on_all_levels(column) for column in y.T], dtype=bool)
    data = y[:, moving]
    if len(h) == 1:
        return np.full(y.shape[1], np.nan)
    if len(h) == 2:
        difference = np.abs(data[1] - data[0])
        bars[moving] = CAREFUL * np.maximum(difference, np.sqrt((difference**2).sum() / max(difference.size, 1)))
    elif moving.any():
        bars[moving] = _pooled_uncertainties(data, h)
    return bars


def _pooled_uncertainties(data: Array, h: Array) -> Array:
    """Return the grid uncertainties (m,) of m quantities with a common order of convergence, on three or more levels.

    ``data``: values (levels, m), none of them equal on all levels; ``h``: cell sizes.
    """
    free = min((fit_searched_order(data, h, weighted) for weighted in (False, True)), key=lambda f: f.standard_deviation)
    low, high = range_of_compatible_orders(data, h, free)
    if high < ORDERS[0]:
        fits, factor = [min(fit_fixed_orders(data, h, with_mixed_order=True), key=lambda f: f.standard_deviation)], CAREFUL
    else:
        low, high = (min(max(p, ORDERS[0]), ORDERS[1]) for p in (low, high))
        orders = np.linspace(low, high, STEPS)
        fits, factor = [fit_given_order(data, h, float(p), free.weighted_by_cell_size) for p in orders], SAFE
    sigmas = [np.maximum(f.standard_deviations, f.standard_deviation) for f in fits]
    pairs = zip(fits, sigmas, strict=True)
    return np.asarray(np.max([_uncertainty_of_finest(data, f, sigma, factor) for f, sigma in pairs], axis=0))


def _check_values_and_cell_sizes(values: ArrayLike, sizes: ArrayLike) -> tuple[Array, Array]:
    """Check values and cell sizes of several mesh levels, and return them as arrays.

    Returns the values of m quantities (levels, m), then the cell sizes relative to the finest (levels,).

    ``values``: (levels, m), or (levels,) for one quantity; ``sizes``: cell sizes, coarse to fine. ValueError if a value is
    not finite, the number of values differs from that of the sizes, or the sizes do not decrease.
    """
    y, h = np.asarray(values, float), np.asarray(sizes, float)
    y = y[:, None] if y.ndim == 1 else y
    if h.ndim != 1 or len(y) != len(h) or not len(h) or not np.isfinite(y).all():
        got = f"got {len(y)} levels and {h.size} sizes"
        raise ValueError(f"grid convergence needs finite values and a cell size for each level; {got}")
    if not (np.diff(h) < 0.0).all() or h[-1] <= 0.0:
        raise ValueError("cell sizes must be positive and decrease from the coarse to the fine mesh level")
    return y, h / h[-1]


def _is_equal_on_all_levels(column: Array) -> bool:
    """Return whether a quantity is equal on all mesh levels, up to rounding; ``column``: its values, (levels,)."""
    return float(np.ptp(column)) <= ROUND_OFF * float(np.abs(column).max())


def _kind_of_convergence(column: Array, h: Array) -> tuple[str, float | None]:
    """Return the kind of convergence of a quantity as text, and its fitted order.

    ``column``: values on three or more mesh levels, coarse to fine, (levels,); ``h``: relative cell sizes, (levels,). The
    text is `MONOTONE`, `OUT_OF_RANGE` or `NOT_MONOTONE`; in the last case the order is None.
    """
    steps = np.diff(column)
    if not ((steps > 0.0).all() or (steps < 0.0).all()):
        return NOT_MONOTONE, None
    p = fit_searched_order(column[:, None], h).order
    assert p is not None
    return (MONOTONE if ORDERS[0] <= p <= ORDERS[1] else OUT_OF_RANGE), p


def _uncertainty_of_finest(
    y: Array, fit: ConvergenceFit, sigma: Array | float, factor: float, mean_change: float = np.inf
) -> Array:
    """Return the uncertainty U of each quantity's value on the finest level, (m,), from a fit over all levels.

    U = F |delta| + sigma + |r_1| if sigma < Delta, else 3 (sigma / Delta) (|delta| + sigma + |r_1|); delta: value less its
    fitted limit; r_1: residual; both on the finest level. ``y``: values (levels, m), coarse to fine; ``fit``: fit to these
    values; ``sigma``: standard deviation of the fit, a number or (m,); ``factor``: safety factor F; ``mean_change``: Delta,
    the mean change between levels; infinite: always the first formula.
    """
    error, off = np.abs(y[-1] - fit.residuals[-1] - fit.limits), np.abs(fit.residuals[-1])
    if np.max(sigma) < mean_change:
        return np.asarray(factor * error + sigma + off)
    return np.asarray(CAREFUL * sigma / mean_change * (error + sigma + off))


@dataclass(frozen=True)
class ConvergenceFit:
    """Least-squares fit of one or several quantities, computed on several mesh levels, as functions of the cell size h."""

    #: Description of the fitted function, such as "order 1.50".
    fitted_function: str
    #: Order p; None for a fit with fixed orders.
    order: float | None
    #: Whether the fit weights each mesh level by 1 / h, as by Eca and Hoekstra; otherwise the weights are equal.
    weighted_by_cell_size: bool
    #: Limits of the quantities for h = 0, (m,); nan for a fitted function that has no limit there (order zero or below).
    limits: Array
    #: Differences of the values of m quantities from the fitted function on each mesh level, (levels, m).
    residuals: Array
    #: Standard deviation of the residuals of all quantities; zero if the fit leaves no degree of freedom.
    standard_deviation: float
    #: Standard deviation of the residuals of each quantity, (m,); zero if the fit leaves no degree of freedom.
    standard_deviations: Array


def fit_searched_order(y: Array, h: Array, weighted: bool = False) -> ConvergenceFit:
    """Fit m quantities by limit + slope h^p, with the common order p that makes the sum of squared residuals least.

    ``y``: values (levels, m); ``h``: relative cell sizes (levels,); ``weighted``: whether the levels have weights 1 / h
    instead of equal ones. The best order is searched on grids over shrinking intervals.
    """
    w = weights_of_mesh_levels(h, weighted)
    low, high = SEARCH
    at, step = 0.0, 1.0
    while step > 1e-11:
        p = np.linspace(low, high, 161)
        at, step = float(p[_residual_squares(y, h, w, p).argmin()]), float(p[1] - p[0])
        low, high = max(SEARCH[0], at - 1.5 * step), min(SEARCH[1], at + 1.5 * step)
    return fit_given_order(y, h, at, weighted)


def fit_given_order(y: Array, h: Array, p: float, weighted: bool) -> ConvergenceFit:
    """Fit m quantities by limit + slope h^p, for a given order p.

    ``y``: values (levels, m); ``h``: relative cell sizes (levels,); ``p``: the order; ``weighted``: whether the levels have
    weights 1 / h instead of equal ones. In the standard deviation of the fit, the order counts as one fitted parameter,
    common to all quantities.
    """
    return _fit_levels(f"order {p:.2f}", p, weighted, y, h, _box_cox_transform(h, np.array([p])).T)


def fit_fixed_orders(y: Array, h: Array, *, with_mixed_order: bool) -> list[ConvergenceFit]:
    """Fit m quantities by functions of first and of second order in the cell size h, with equal weights and weights 1 / h.

    ``y``: values (levels, m); ``h``: relative cell sizes (levels,); ``with_mixed_order``: whether, with four levels or
    more, fits by both h and h^2 at once are added.
    """
    forms: dict[str, tuple[float, ...]] = {"first order": (1.0,), "second order": (2.0,)}
    if with_mixed_order and len(h) > 3:
        forms["first and second order"] = (1.0, 2.0)
    return [
        _fit_levels(form, None, weighted, y, h, np.stack([h**p for p in powers], axis=1))
        for form, powers in forms.items()
        for weighted in (False, True)
    ]


def range_of_compatible_orders(y: Array, h: Array, best: ConvergenceFit) -> tuple[float, float]:
    """Return the lowest and the highest order of convergence that are compatible with the data.

    ``y``: values (levels, m); ``h``: relative cell sizes (levels,); ``best``: fit with the best order. The criterion is an
    F test of the sums of squared residuals with the confidence `CONFIDENCE`. If the best fit leaves no degree of freedom,
    or combines fixed orders (so that its order is None), the whole range of searched orders, `SEARCH`, is returned.
    """
    from scipy.stats import f as f_ratio

    n, m = y.shape
    freedom = (n - 2) * m - 1
    if freedom < 1 or best.order is None:
        return SEARCH
    w = weights_of_mesh_levels(h, best.weighted_by_cell_size)
    least = float(_residual_squares(y, h, w, np.array([best.order]))[0])
    limit = least * (1.0 + float(f_ratio.ppf(CONFIDENCE, 1, freedom)) / freedom)
    ends = []
    for end in SEARCH:
        p = np.linspace(best.order, end, 801)
        beyond = np.flatnonzero(_residual_squares(y, h, w, p) > limit * (1.0 + 1e-9))
        ends.append(float(p[max(int(beyond[0]) - 1, 0)]) if beyond.size else end)
    return ends[0], ends[1]


def weights_of_mesh_levels(h: Array, weighted: bool) -> Array:
    """Return the weights of the mesh levels in a fit, (levels,): equal, or proportional to 1 over the cell size; sum 1.

    ``weighted``: whether they are proportional to 1 / h; ``h``: relative cell sizes (levels,).
    """
    w = 1.0 / h if weighted else np.ones_like(h)
    return np.asarray(w / w.sum())


def _residual_squares(y: Array, h: Array, w: Array, p: Array) -> Array:
    """Return, for each order in ``p``, the weighted sum of squared residuals of m quantities fitted by limit + slope h^p.

    ``y``: values (levels, m); ``h``: relative cell sizes (levels,); ``w``: weights of the levels.
    """
    centred = y - w @ y
    x = _box_cox_transform(h, p)
    x = x - (x @ w)[:, None]
    slope = np.einsum("gn,n,nm->gm", x, w, centred) / ((x * x) @ w)[:, None]
    left = centred[None] - x[:, :, None] * slope[:, None, :]
    return np.asarray(np.einsum("n,gnm->g", w, left * left))


def _box_cox_transform(h: Array, p: Array) -> Array:
    """Return the Box-Cox transform (h^p - 1) / p of relative cell sizes h for several orders p, (orders, levels).

    ``h``: relative cell sizes (levels,); ``p``: orders (orders,). Fits with a constant are the same as with h^p, but at p =
    0 the function is ln h.
    """
    safe = np.where(p == 0.0, 1.0, p)[:, None]
    return np.where(p[:, None] == 0.0, np.log(h), np.expm1(safe * np.log(h)) / safe)


def _fit_levels(form: str, order: float | None, weighted: bool, y: Array, h: Array, columns: Array) -> ConvergenceFit:
    """Fit the values on all mesh levels by least squares, as linear functions of given columns, and return the fit.

    Parameters
    ----------
    form
        Name of the fitted function.
    order
        Order of convergence, one for all quantities; None: the columns have fixed orders.
    weighted
        Whether finer mesh levels have larger weights.
    y
        Values of m quantities on n mesh levels, (n, m).
    h
        Relative cell sizes, (n,).
    columns
        Functions of the cell size that are fitted in addition to a constant, (n, k).
    """
    (n, m), w = y.shape, weights_of_mesh_levels(h, weighted)
    root, basis = np.sqrt(w)[:, None], np.column_stack([np.ones(n), columns])
    coefficients = np.linalg.lstsq(root * basis, root * y, rcond=None)[0]
    limit, residual, of_each = coefficients[0], y - basis @ coefficients, basis.shape[1]
    if order is not None:  # the column is -1 / order at h = 0
        limit = limit - coefficients[1] / order if order > 0.0 else np.full_like(limit, np.nan)
    squares = n * (w @ (residual * residual))
    freedom = (n - of_each) * m - (order is not None)
    deviation = float(np.sqrt(squares.sum() / freedom)) if freedom > 0 else 0.0
    single = np.sqrt(squares / (n - of_each)) if n > of_each else np.zeros(m)
    return ConvergenceFit(form, order, weighted, limit, residual, deviation, np.asarray(single))
