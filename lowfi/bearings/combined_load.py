"""Tapered roller bearing under thrust and radial load together: every roller by its own line contact.

The ring's displacement (axial, radial) compresses the roller at azimuth psi by
delta_a sin(alpha) + delta_r cos(alpha) cos(psi); equilibrium is the minimum of a convex energy in the two displacements.
Smith's route (1994, 3.1-3.21) by the load-zone integrals and a power law stands beside it as ``by_load_zone``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.bearings.load_zone import LoadZone, zone_of_load
from rollbench.lowfi.rollers.tapered_roller import TaperedBearing
from rollbench.meshes.arrays import Array

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
