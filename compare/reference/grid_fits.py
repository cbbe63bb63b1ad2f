"""Least-squares fits of quantities over cell sizes: phi_0 + alpha h^p with a searched, a given or a fixed order p.

Quantities ``(levels, m)`` share the powers of h; limit and coefficients are each quantity's own (variable projection: for
a given p they follow by linear least squares, so that only p is searched). Sizes are over the finest: h falls to 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_ratio

from rollbench.meshes.arrays import Array

#: Orders that are looked for, negative ones (values that drift off) among them.
SEARCH = (-4.0, 12.0)
#: Of the F test for orders that the data allow.
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Fit:
    """A fit: ``form`` as text, ``order`` (None where it was not fitted), ``weighted`` by 1 / h (Eca and Hoekstra's
    weights), limits ``(m,)`` at h = 0 (nan for orders at which there is none), residuals ``(levels, m)``, standard
    deviation of all, and of each ``(m,)``; both are zero where no degree of freedom is left."""

    form: str
    order: float | None
    weighted: bool
    limit: Array
    residual: Array
    deviation: float
    own: Array


def searched(y: Array, h: Array, weighted: bool = False) -> Fit:
    """Fit of one order to all quantities, the best in ``SEARCH``; by zooms, because squares have several minima."""
    w = weights(h, weighted)
    low, high = SEARCH
    at, step = 0.0, 1.0
    while step > 1e-11:
        p = np.linspace(low, high, 161)
        at, step = float(p[_squares(y, h, w, p).argmin()]), float(p[1] - p[0])
        low, high = max(SEARCH[0], at - 1.5 * step), min(SEARCH[1], at + 1.5 * step)
    return given(y, h, at, weighted)


def given(y: Array, h: Array, p: float, weighted: bool) -> Fit:
    """Fit of an order p that was searched or is varied: it counts as one parameter of all quantities together."""
    x = _box(h, np.array([p]))[0]
    finest, slope, residual = _linear(y, x[:, None], weights(h, weighted))
    limit = finest - slope[0] / p if p > 0.0 else np.full_like(finest, np.nan)  # x is -1 / p at h = 0
    return _fit(f"order {p:.2f}", p, weighted, h, limit, residual, 2, 1)


def fixed(y: Array, h: Array, *, both: bool) -> list[Fit]:
    """Fits of first and of second order, each without and with weights; ``both``: of the two together too, which takes
    more than three levels."""
    forms: dict[str, tuple[float, ...]] = {"first order": (1.0,), "second order": (2.0,)}
    if both and len(h) > 3:
        forms["first and second order"] = (1.0, 2.0)
    out = []
    for form, powers in forms.items():
        columns = np.stack([h**p for p in powers], axis=1)
        for weighted in (False, True):
            limit, _, residual = _linear(y, columns, weights(h, weighted))
            out.append(_fit(form, None, weighted, h, limit, residual, len(powers) + 1, 0))
    return out


def allowed(y: Array, h: Array, best: Fit) -> tuple[float, float]:
    """Interval of orders about that of the ``searched`` fit whose squares exceed its own by no more than chance allows (F
    test, ``CONFIDENCE``); all of ``SEARCH`` where the fit has no degree of freedom."""
    n, m = y.shape
    freedom = (n - 2) * m - 1
    if freedom < 1 or best.order is None:
        return SEARCH
    w = weights(h, best.weighted)
    least = float(_squares(y, h, w, np.array([best.order]))[0])
    limit = least * (1.0 + float(f_ratio.ppf(CONFIDENCE, 1, freedom)) / freedom)
    ends = []
    for end in SEARCH:
        p = np.linspace(best.order, end, 801)
        beyond = np.flatnonzero(_squares(y, h, w, p) > limit * (1.0 + 1e-9))
        ends.append(float(p[max(int(beyond[0]) - 1, 0)]) if beyond.size else end)
    return ends[0], ends[1]


def weights(h: Array, weighted: bool) -> Array:
    """Weights of the levels, of sum one: equal, or as 1 / h."""
    w = 1.0 / h if weighted else np.ones_like(h)
    return np.asarray(w / w.sum())


def _squares(y: Array, h: Array, w: Array, p: Array) -> Array:
    """Weighted squares of the residuals of all quantities for every order of ``p``, limits and slopes fitted."""
    centred = y - w @ y
    x = _box(h, p)
    x = x - (x @ w)[:, None]
    slope = np.einsum("gn,n,nm->gm", x, w, centred) / ((x * x) @ w)[:, None]
    left = centred[None] - x[:, :, None] * slope[:, None, :]
    return np.asarray(np.einsum("n,gnm->g", w, left * left))


def _box(h: Array, p: Array) -> Array:
    """(h^p - 1) / p ``(orders, levels)``: h^p but for a constant and a factor, and ln h at p = 0."""
    safe = np.where(p == 0.0, 1.0, p)[:, None]
    return np.where(p[:, None] == 0.0, np.log(h), np.expm1(safe * np.log(h)) / safe)


def _linear(y: Array, columns: Array, w: Array) -> tuple[Array, Array, Array]:
    """Constants ``(m,)``, coefficients ``(k, m)`` and residuals ``(levels, m)`` of weighted linear least squares."""
    root = np.sqrt(w)[:, None]
    basis = np.column_stack([np.ones(len(w)), columns])
    coefficients = np.linalg.lstsq(root * basis, root * y, rcond=None)[0]
    return np.asarray(coefficients[0]), np.asarray(coefficients[1:]), np.asarray(y - basis @ coefficients)


def _fit(
    form: str, order: float | None, weighted: bool, h: Array, limit: Array, residual: Array, of_each: int, of_all: int
) -> Fit:
    """The record of a fit with ``of_each`` parameters of each quantity and ``of_all`` of all of them."""
    n, m = residual.shape
    squares = n * (weights(h, weighted) @ (residual * residual))
    freedom = (n - of_each) * m - of_all
    deviation = float(np.sqrt(squares.sum() / freedom)) if freedom > 0 else 0.0
    single = np.sqrt(squares / (n - of_each)) if n > of_each else np.zeros(m)
    return Fit(form, order, weighted, limit, residual, deviation, np.asarray(single))
