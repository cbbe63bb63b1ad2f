"""Another program's loads extrapolated to elements of no size and to rigid contact, with what that is worth.

Element size at the contacts h, growth of the elements away from them g and contact compliance 1/k change every load
smoothly, F = F0 + A h^p + B g^q + C / k: the compliance enters to first order (an overclosure in series with the
contact's own approach), the orders p and q are those that fit all contacts of all runs best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from compare.crosscheck_data import CrossRun

Array = NDArray[np.float64]

#: Orders tried.
ORDERS = tuple(np.arange(1.0, 4.01, 0.25).tolist())
#: Orders whose misfit is up to this many times the smallest are as credible as the best.
CREDIBLE = 2.0
#: Misfits of this share of the largest load are none.
EXACT = 1e-9


@dataclass(frozen=True)
class Extrapolation:
    """Loads ``(n, 4)`` [N] extrapolated, what that is worth ``(n, 4)`` [N], orders of h and g (None: not varied), RMS
    misfit [N], and what h, g and 1/k add to the limit in the run nearest to it ``(n, 4)`` [N]; choices not varied."""

    load: Array
    uncertainty: Array
    orders: tuple[float, float | None]
    misfit: float
    by_size: Array
    by_growth: Array
    by_stiffness: Array
    fixed: tuple[str, ...]


def extrapolate(runs: Sequence[CrossRun]) -> Extrapolation:
    """Limit of the runs with small displacements in all choices that they vary.

    The uncertainty of a contact is the largest change of its limit over all credible pairs of orders, joined by root of
    squares with its own scatter about the fit. Where the runs are as many as the unknowns every order fits, and the
    uncertainty is the whole range of limits. Raises ValueError with one element size only or fewer runs than unknowns.
    """
    own = [r for r in runs if not r.nlgeom]
    h = np.array([1.0 / r.b_over_h for r in own])
    g = np.array([r.growth for r in own])
    c = np.array([1.0 / r.stiffness for r in own])
    varied = [bool(np.ptp(x) > 0.0) for x in (h, g, c)]
    if not varied[0]:
        raise ValueError("one element size at the contacts only: two are needed to extrapolate")
    if len(own) < 1 + sum(varied):
        raise ValueError(f"{len(own)} runs: {1 + sum(varied)} are needed to extrapolate what they vary")
    h, g, c = h / h.min(), g / g.min(), c / c.max()
    loads = np.stack([r.load.ravel() for r in own])
    fits = [_fit(loads, [h**p, g**q, c], varied, (p, q)) for p, q in product(ORDERS, ORDERS if varied[1] else (1.0,))]
    best = min(fits, key=lambda fit: fit.misfit)
    credible = [f for f in fits if f.misfit <= CREDIBLE * best.misfit + EXACT * float(np.abs(loads).max())]
    spread = np.abs(np.stack([f.limit for f in credible]) - best.limit).max(axis=0)
    scatter = np.sqrt((best.residual**2).sum(axis=0) / max(1, len(own) - 1 - sum(varied)))
    near = int(np.argmin(sum(x for x, on in zip(best.terms, varied, strict=True) if on)))
    shape = own[0].load.shape
    by = [(best.factors[k] * best.terms[k][near]).reshape(shape) for k in range(3)]
    names = ("element size", "growth", "contact stiffness")
    return Extrapolation(
        best.limit.reshape(shape), np.hypot(spread, scatter).reshape(shape),
        (best.orders[0], best.orders[1] if varied[1] else None), best.misfit, by[0], by[1],
        by[2], tuple(n for n, on in zip(names, varied, strict=True) if not on),
    )  # fmt: skip


@dataclass(frozen=True)
class _Fit:
    """Least squares with one pair of orders: RMS misfit, orders, limit, factors ``(3, contacts)``, residuals, terms."""

    misfit: float
    orders: tuple[float, float]
    limit: Array
    factors: Array
    residual: Array
    terms: list[Array]


def _fit(loads: Array, terms: list[Array], varied: list[bool], orders: tuple[float, float]) -> _Fit:
    used = [k for k in range(3) if varied[k]]
    design = np.stack([np.ones(len(loads)), *(terms[k] for k in used)], axis=1)
    found = np.linalg.lstsq(design, loads, rcond=None)[0]
    factors = np.zeros((3, loads.shape[1]))
    factors[used] = found[1:]
    residual = loads - design @ found
    return _Fit(float(np.sqrt((residual**2).mean())), orders, found[0], factors, residual, terms)
