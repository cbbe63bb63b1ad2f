"""Another program's loads extrapolated to elements of no size and to rigid contact, with its uncertainty.

Elements of a deck are h at the contacts and grow by g per distance d from them. With c the length over which the field of
a contact changes, their size over the distance in which the field changes there is (h + g d) / (c + d), and the energy
of the field, F^2 / (c + d)^2 per distance, is spread evenly over x = c / (c + d). An error of order p of the elements'
relative size thus changes a load in proportion to

    e = int_0^1 (x h / c + (1 - x) g)^p dx,

and the compliance 1 / k of the contact law to first order (an overclosure in series with the contact's own approach):

    F = F0 + A e + B / k,  c = lambda b,  b the short half axis of the contact's own load.

A and B are each contact's own; lambda and p are common to all contacts of a scene and fitted to all runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from compare.crosscheck.data import CrossRun

Array = NDArray[np.float64]

#: Orders tried: second-order elements have 4 where the field is smooth and 3 at the rim of a contact, whose pressure falls
#: like a root; coarse ones may show as little as first-order elements have, 2.
ORDERS = tuple(np.arange(2.0, 4.01, 0.25).tolist())
#: Lengths tried, over the short half axis: up to the long one of a slender ellipse.
LENGTHS = tuple(np.geomspace(0.5, 6.0, 26).tolist())
#: Pairs whose misfit is up to this many times the smallest are as credible as the best.
CREDIBLE = 1.5
#: Misfits of this share of the largest load are none.
EXACT = 1e-9


@dataclass(frozen=True)
class Extrapolation:
    """Loads ``(n, 4)`` [N] extrapolated, their uncertainty ``(n, 4)`` [N], order p and length lambda, RMS misfit [N], and
    what elements and contact law add to the limit in the run nearest to it ``(n, 4)`` [N]; choices that no run varies."""

    load: Array
    uncertainty: Array
    order: float
    length: float
    misfit: float
    by_elements: Array
    by_stiffness: Array
    fixed: tuple[str, ...]


def element_error(size: Array, growth: Array, order: float) -> Array:
    """e of the module's head for sizes h / c and growths, by Gauss' rule.

    >>> element_error(np.array([1.0, 0.0]), np.array([0.0, 0.5]), 2.0).round(6).tolist()
    [0.333333, 0.083333]
    """
    x, w = np.polynomial.legendre.leggauss(8)
    at = 0.5 * (x + 1.0)
    return np.asarray((np.multiply.outer(size, at) + np.multiply.outer(growth, 1.0 - at)) ** order @ (0.5 * w))


def extrapolate(runs: Sequence[CrossRun]) -> Extrapolation:
    """Limit of the runs with small displacements.

    The uncertainty of a contact is the largest change of its limit over all credible pairs of order and length, joined by
    root of squares with its own scatter about the fit. Where the runs are as many as the unknowns, every pair fits and
    the uncertainty is the whole range of limits. Raises ValueError with one mesh only, or fewer runs than unknowns.
    """
    own = [r for r in runs if not r.nlgeom]
    h, g = np.array([1.0 / r.b_over_h for r in own]), np.array([r.growth for r in own])
    c = np.array([1.0 / r.stiffness for r in own])
    varied = bool(np.ptp(c) > 0.0)
    if len(set(zip(h.tolist(), g.tolist(), strict=True))) < 2:
        raise ValueError("one mesh only: two are needed to extrapolate")
    if len(own) < 2 + varied:
        raise ValueError(f"{len(own)} runs: {2 + varied} are needed to extrapolate what they vary")
    loads = np.stack([r.load.ravel() for r in own])
    typical = loads.mean(axis=0)
    half = np.cbrt(np.maximum(typical / typical[typical > 0.0].mean(), 1e-3))  # own half axis over that at mean load
    fits = [_fit(loads, h, g, c / c.max(), half, p, s, varied) for p, s in product(ORDERS, LENGTHS)]
    best = min(fits, key=lambda fit: fit.misfit)
    credible = [f for f in fits if f.misfit <= CREDIBLE * best.misfit + EXACT * float(np.abs(loads).max())]
    spread = np.abs(np.stack([f.limit for f in credible]) - best.limit).max(axis=0)
    scatter = np.sqrt((best.residual**2).sum(axis=0) / max(1, len(own) - 2 - varied))
    near = int(np.argmin(np.abs(best.elements).sum(axis=1)))
    shape = own[0].load.shape
    uniform = [name for name, x in (("element size", h), ("growth", g), ("contact stiffness", c)) if np.ptp(x) == 0.0]
    return Extrapolation(
        best.limit.reshape(shape),
        np.hypot(spread, scatter).reshape(shape),
        best.order,
        best.length,
        best.misfit,
        best.elements[near].reshape(shape),
        best.law[near].reshape(shape),
        tuple(uniform),
    )


@dataclass(frozen=True)
class _Fit:
    """Least squares with one order and length: RMS misfit; limit ``(contacts,)``; what elements and contact law add, and
    residuals, ``(runs, contacts)`` [N]."""

    order: float
    length: float
    misfit: float
    limit: Array
    elements: Array
    law: Array
    residual: Array


def _fit(loads: Array, h: Array, g: Array, c: Array, half: Array, order: float, length: float, varied: bool) -> _Fit:
    limit, elements, law = np.zeros(loads.shape[1]), np.zeros_like(loads), np.zeros_like(loads)
    for k in range(loads.shape[1]):
        terms = [np.ones_like(h), element_error(h / (length * half[k]), g, order), *([c] if varied else [])]
        found = np.linalg.lstsq(np.stack(terms, axis=1), loads[:, k], rcond=None)[0]
        limit[k], elements[:, k] = found[0], found[1] * terms[1]
        law[:, k] = found[2] * c if varied else 0.0
    residual = loads - limit - elements - law
    return _Fit(order, length, float(np.sqrt((residual**2).mean())), limit, elements, law, residual)
