"""Tapered roller bearing under thrust and radial load together: every roller by its own line contact.

The ring's displacement (axial, radial) compresses the roller at azimuth psi by
delta_a sin(alpha) + delta_r cos(alpha) cos(psi); equilibrium is the minimum of a convex energy in the two displacements.
Smith's route (1994, 3.1-3.21) by the load-zone integrals and a power law stands beside it as ``by_load_zone``.

Sjovall's integrals and their inverse: a roller (or ball) at azimuth psi is compressed by delta_n [1 - (1 - cos psi)/(2
eps)], with the load zone parameter eps = (1 + (delta_a/delta_r) tan alpha)/2 (Smith 1994, 3.1-3.3), and carries the
greatest load times that bracket to the n. The integrals run over the loaded part of the circumference. Written with w =
1/(2 eps), pure thrust is w = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.rollers import TaperedBearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

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


#: Exponent of the power law q ~ delta^n that spreads the load over the zone (Smith 3.15).
EXPONENT = 1.1


@dataclass(frozen=True)
class CombinedState:
    """axial, radial: displacements [m]; loads: Q of every roller (N,) [N]; stiffness: (2, 2) [N/m]; residual: largest
    unbalanced force over the applied one; converged: whether that is round-off."""

    axial: float
    radial: float
    loads: Array
    stiffness: Array
    residual: float
    converged: bool


def azimuths(bearing: TaperedBearing) -> Array:
    """Azimuths (N,) [rad] of the rollers, the first under the radial load."""
    return 2.0 * np.pi * np.arange(bearing.rollers) / bearing.rollers


def state_at(bearing: TaperedBearing, displacement: Array) -> tuple[float, Array, Array, Array]:
    """Energy [J], force (2,) [N], stiffness (2, 2) [N/m] and roller loads (N,) [N] at (axial, radial) displacements [m]."""
    direction = np.column_stack(
        [np.full(bearing.rollers, np.sin(bearing.cup_angle)), np.cos(bearing.cup_angle) * np.cos(azimuths(bearing))]
    )
    law, length = bearing.law(), bearing.length
    q = law.line_load(direction @ displacement)
    energy, slope = length * law.energy(q), length * law.slope(q)
    return float(energy.sum()), length * (q @ direction), (direction.T * slope) @ direction, length * q


def combined(bearing: TaperedBearing, axial: float, radial: float) -> CombinedState:
    """Equilibrium under thrust and radial load [N], by Newton's method with line search on the convex energy.

    Raises ValueError unless 0 <= F_r tan(alpha) < F_a. The first roller stands under the radial load.
    """
    start = by_load_zone(bearing, axial, radial)
    force, x = np.array([axial, radial]), np.array([start.axial, start.radial])
    for _ in range(100):
        energy, inner, slope, loads = state_at(bearing, x)
        off = inner - force
        if np.abs(off).max() <= 1e-12 * axial:
            break
        # a loaded zone of one roller leaves one direction soft: a touch of the diagonal keeps the step finite
        step = -np.linalg.solve(slope + 1e-9 * np.trace(slope) * np.eye(2), off)
        x = x + _damped(bearing, x, step, energy - float(force @ x), force) * step
    residual = float(np.abs(off).max() / axial)
    return CombinedState(float(x[0]), float(x[1]), loads, slope, residual, residual < 1e-9)


def _damped(bearing: TaperedBearing, x: Array, step: Array, level: float, force: Array) -> float:
    """Largest halving of the step that does not raise the energy; round-off near the minimum counts as none."""
    fraction = 1.0
    while fraction > 1e-6:
        trial = x + fraction * step
        if _energy(bearing, trial) - float(force @ trial) <= level + 1e-14 * abs(level):
            return fraction
        fraction *= 0.5
    return fraction


def _energy(bearing: TaperedBearing, x: Array) -> float:
    """Energy [J], infinite where a trial step leaves the range of the line contact."""
    try:
        return state_at(bearing, x)[0]
    except ValueError:
        return np.inf


@dataclass(frozen=True)
class ZoneState:
    """Displacements [m], greatest roller load [N] and load zone by the integrals."""

    axial: float
    radial: float
    greatest: float
    zone: LoadZone


def by_load_zone(bearing: TaperedBearing, axial: float, radial: float) -> ZoneState:
    """Smith 3.14-3.21 with exact integrals and the right line contact at the most loaded roller.

    The power law spreads the load, the line contact gives its compression: exact for pure thrust, otherwise as good as
    the exponent and the continuum of rollers. Raises ValueError as `combined`.
    """
    zone = zone_of_load(axial, radial, bearing.cup_angle, EXPONENT)
    greatest = axial / (bearing.rollers * np.sin(bearing.cup_angle) * zone.axial)
    normal = float(bearing.law().approach(greatest / bearing.length))
    w = 0.5 / zone.eps
    return ZoneState(
        float((1.0 - w) * normal / np.sin(bearing.cup_angle)),
        float(w * normal / np.cos(bearing.cup_angle)),
        float(greatest),
        zone,
    )
