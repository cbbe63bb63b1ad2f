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


@dataclass(frozen=True)
class Extrapolation:
    """Loads ``(n, 4)`` [N] extrapolated, what that is worth ``(n, 4)`` [N], orders of h and g, RMS misfit [N], and the
    changes ``(n, 4)`` [N] from the limit by h, g and 1/k in the run nearest to it."""

    load: Array
    uncertainty: Array
    orders: tuple[float, float]
    misfit: float
    by_size: Array
    by_growth: Array
    by_stiffness: Array


def extrapolate(runs: Sequence[CrossRun]) -> Extrapolation:
    """Limit of the runs with small displacements.

    The uncertainty of a contact is the largest change of its limit over all credible pairs of orders, and its own RMS
    misfit. Raises ValueError with fewer than two sizes, growths and stiffnesses, or five runs.
    """
    own = [r for r in runs if not r.nlgeom]
    for name in ("b_over_h", "growth", "stiffness"):
        if len({getattr(r, name) for r in own}) < 2:
            raise ValueError(f"one {name} only: two are needed to extrapolate")
    if len(own) < 5:
        raise ValueError(f"{len(own)} runs: five are needed to extrapolate")
    h = np.array([1.0 / r.b_over_h for r in own])
    g = np.array([r.growth for r in own])
    c = np.array([1.0 / r.stiffness for r in own])
    h, g, c = h / h.min(), g / g.min(), c / c.max()
    loads = np.stack([r.load.ravel() for r in own])
    fits = []
    for p, q in product(ORDERS, ORDERS):
        design = np.stack([np.ones_like(h), h**p, g**q, c], axis=1)
        found = np.linalg.lstsq(design, loads, rcond=None)[0]
        misfit = loads - design @ found
        fits.append((float(np.sqrt((misfit**2).mean())), (p, q), found, misfit))
    best = min(fits, key=lambda x: x[0])
    shape = own[0].load.shape
    credible = np.stack([f[2][0] for f in fits if f[0] <= CREDIBLE * best[0]])
    spread = np.abs(credible - best[2][0]).max(axis=0)
    uncertainty = np.hypot(spread, np.sqrt((best[3] ** 2).mean(axis=0)))
    # the finest of all runs, in the fit's own measure
    p, q = best[1]
    near = int(np.argmin(h**p + g**q + c))
    return Extrapolation(
        best[2][0].reshape(shape), uncertainty.reshape(shape), best[1], best[0],
        (best[2][1] * h[near] ** p).reshape(shape), (best[2][2] * g[near] ** q).reshape(shape),
        (best[2][3] * c[near]).reshape(shape),
    )  # fmt: skip
