"""Grid convergence after Celik et al. (J. Fluids Eng. 130 (2008) 078001) of quantities on three mesh levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

#: Safety factor of the grid convergence index on three grids.
SAFETY = 1.25
#: Observed orders outside this range mean nothing: three grids that differ by scatter can give any number.
ORDERS = (0.5, 6.0)


@dataclass(frozen=True)
class Convergence:
    """One quantity: values coarse to fine, ``monotone``, observed order, extrapolated value, and its uncertainty.

    uncertainty (in the quantity's unit): 1.25 |fine - medium| / (r^p - 1) where the sequence is monotone with a
    meaningful order; otherwise the band of the three values. order and extrapolated are None in that case.
    """

    values: tuple[float, float, float]
    monotone: bool
    order: float | None
    extrapolated: float | None
    uncertainty: float


def observe(values: ArrayLike, sizes: ArrayLike) -> Convergence:
    """Convergence of three ``values`` on cells of ``sizes``, coarse to fine.

    Solves p = |ln|e32/e21| + q(p)| / ln r21 by fixed point for unequal refinement ratios (Celik, steps 3 to 5).
    """
    f3, f2, f1 = (float(v) for v in np.asarray(values, float))
    h3, h2, h1 = (float(h) for h in np.asarray(sizes, float))
    e32, e21 = f3 - f2, f2 - f1
    band = max(f1, f2, f3) - min(f1, f2, f3)
    three = (f3, f2, f1)
    if e21 == 0.0 or e32 == 0.0 or e32 / e21 <= 0.0:
        return Convergence(three, False, None, None, band)
    r21, r32 = h2 / h1, h3 / h2
    p = abs(np.log(abs(e32 / e21))) / np.log(r21)
    for _ in range(100):
        below, above = r21**p - 1.0, r32**p - 1.0
        new = abs(np.log(abs(e32 / e21)) + (np.log(below / above) if below > 0.0 and above > 0.0 else 0.0)) / np.log(r21)
        if abs(new - p) < 1e-12:
            break
        p = new
    if not ORDERS[0] <= p <= ORDERS[1]:
        return Convergence(three, False, None, None, band)
    gain = r21**p - 1.0
    return Convergence(three, True, float(p), f1 + (f1 - f2) / gain, SAFETY * abs(e21) / gain)
