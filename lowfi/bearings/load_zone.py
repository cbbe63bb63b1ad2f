"""Load zone of one row under thrust and radial load: Sjovall's integrals and their inverse.

A roller (or ball) at azimuth psi is compressed by delta_n [1 - (1 - cos psi)/(2 eps)], with the load zone parameter
eps = (1 + (delta_a/delta_r) tan alpha)/2 (Smith 1994, 3.1-3.3), and carries the greatest load times that bracket to the n.
The integrals run over the loaded part of the circumference. Written with w = 1/(2 eps), pure thrust is w = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.roots import brentq

# double-exponential quadrature on (0, 1): the load ends as a broken power where the zone does
_T = np.arange(-3.6, 3.6001, 0.03)
_PLACES = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(_T)))
_WEIGHTS = 0.03 * np.pi * np.cosh(_T) * _PLACES / (1.0 + np.exp(np.pi * np.sinh(_T)))


@dataclass(frozen=True)
class LoadZone:
    """eps, the integrals J_a and J_r, and the half angle [rad] of the loaded part."""

    eps: float
    axial: float
    radial: float
    half_angle: float


def load_zone(eps: float, exponent: float) -> LoadZone:
    """Integrals J_a, J_r (Smith 3.15, 3.16) for eps > 0, infinite for pure thrust; exponent 1.1 for rollers, 1.5 for balls.

    With infinitely many rolling elements; a relative accuracy of 1e-12. Raises ValueError for eps <= 0.

    >>> round(1.0 / load_zone(0.5, 1.5).radial, 4)
    4.3701
    """
    if not eps > 0.0:
        raise ValueError("the load zone parameter must be positive")
    w = 0.5 / eps
    end = np.pi if w <= 0.5 else float(np.arccos(1.0 - 1.0 / w))
    psi = end * _PLACES
    lost = np.maximum(-2.0 * w * np.sin(0.5 * psi) ** 2, -1.0)
    with np.errstate(divide="ignore"):
        change = np.expm1(exponent * np.log1p(lost))  # the load less an even one: no cancellation near pure thrust
    weights = end / np.pi * _WEIGHTS
    even = float(np.sin(end) / np.pi) if end < np.pi else 0.0
    return LoadZone(eps, end / np.pi + float(weights @ change), even + float(weights @ (change * np.cos(psi))), end)


def zone_of_load(axial: float, radial: float, angle: float, exponent: float) -> LoadZone:
    """Zone of a row of contact angle [rad] under thrust and radial load [N]: J_r/J_a = F_r tan(alpha)/F_a (Smith 3.14).

    Raises ValueError unless 0 <= F_r tan(alpha) < F_a: with less thrust the row comes apart.
    """
    ratio = radial * np.tan(angle) / axial if axial > 0.0 else np.inf
    if not 0.0 <= ratio < 1.0:
        raise ValueError("a row needs a thrust above F_r tan(alpha) to stay together, and a radial load of at least 0")
    if ratio == 0.0:
        return load_zone(np.inf, exponent)

    def excess(log_eps: float) -> float:
        zone = load_zone(float(np.exp(log_eps)), exponent)
        return float(np.log(zone.radial / zone.axial / ratio))

    return load_zone(float(np.exp(brentq(excess, np.log(1e-8), np.log(exponent / ratio), xtol=1e-13))), exponent)
