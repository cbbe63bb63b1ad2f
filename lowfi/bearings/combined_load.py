"""Tapered roller bearing under combined thrust and radial load, with the line contact of every roller.

The inner ring's axial and radial displacement compress the roller at azimuth psi by

    delta = delta_a sin(alpha) + delta_r cos(alpha) cos(psi).                                                           (1)

Equilibrium is the minimum of a convex energy in the two displacements. For comparison, ``solve_by_load_zone`` is Smith's
method (1994, 3.1-3.21) with load-zone integrals and a power law.

Sjovall's integrals: a roller (or ball) at azimuth psi is compressed by delta_n [1 - (1 - cos psi)/(2 eps)], with the load
zone parameter eps = (1 + (delta_a/delta_r) tan alpha)/2 (Smith 1994, 3.1-3.3). It carries the largest load times the n-th
power of that bracket. The integrals run over the loaded part of the circumference. They are written with w = 1/(2 eps),
which is 0 for pure thrust.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.rollers import TaperedBearing
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

# double-exponential quadrature on (0, 1), because at the end of the load zone the load is a fractional power of the angle
_T = np.arange(-3.6, 3.6001, 0.03)

_PLACES = 1.0 / (1.0 + np.exp(-np.pi * np.sinh(_T)))

_WEIGHTS = 0.03 * np.pi * np.cosh(_T) * _PLACES / (1.0 + np.exp(np.pi * np.sinh(_T)))


@dataclass(frozen=True)
class LoadZone:
    """Load zone, the loaded part of the circumference of a row of rolling elements, with Sjovall's integrals."""

    #: Load zone parameter: 1/2 if half of the circumference is loaded, infinite for pure thrust.
    eps: float
    #: Sjovall's integral J_a of the thrust, dimensionless.
    axial: float
    #: Sjovall's integral J_r of the radial load, dimensionless.
    radial: float
    #: Half of the angle over which the row is loaded [rad].
    half_angle: float


def load_zone(eps: float, exponent: float) -> LoadZone:
    """Return Sjovall's load-zone integrals J_a and J_r for a load zone parameter.

    They hold for infinitely many rolling elements; the relative accuracy is 1e-12.

    Parameters
    ----------
    eps
        Load zone parameter, above 0; infinite for pure thrust.
    exponent
        Exponent n of load ~ deflection^n: 1.1 for rollers, 1.5 for balls.

    Raises
    ------
    ValueError
        The load zone parameter is not positive.

    References
    ----------
    Smith (1994), 3.15 and 3.16.

    Examples
    --------
    Stribeck's factor of a radially loaded row of balls without clearance, 4.37:

    >>> round(1.0 / load_zone(0.5, 1.5).radial, 4)
    4.3701
    """
    if not eps > 0.0:
        raise ValueError("the load zone parameter eps must be above zero (1/2 for half of the circumference)")
    w = 0.5 / eps
    end = np.pi if w <= 0.5 else float(np.arccos(1.0 - 1.0 / w))
    psi = end * _PLACES
    lost = np.maximum(-2.0 * w * np.sin(0.5 * psi) ** 2, -1.0)
    with np.errstate(divide="ignore"):
        change = np.expm1(exponent * np.log1p(lost))  # load less a uniform load: no cancellation near pure thrust
    weights = end / np.pi * _WEIGHTS
    even = float(np.sin(end) / np.pi) if end < np.pi else 0.0
    return LoadZone(eps, end / np.pi + float(weights @ change), even + float(weights @ (change * np.cos(psi))), end)


def load_zone_of_forces(axial: float, radial: float, angle: float, exponent: float) -> LoadZone:
    """Return the load zone of a row of rolling elements under thrust and radial load.

    It is the load zone for which J_r/J_a = F_r tan(alpha)/F_a (Smith 1994, eq. 3.14).

    Parameters
    ----------
    axial, radial
        Forces F_a and F_r [N].
    angle
        Contact angle [rad].
    exponent
        Exponent n of load ~ deflection^n: 1.1 for rollers, 1.5 for balls.

    Raises
    ------
    ValueError
        The thrust is too small, F_a <= F_r tan(alpha), so that the rings separate, or the radial load is negative.
    """
    ratio = radial * np.tan(angle) / axial if axial > 0.0 else np.inf
    if not 0.0 <= ratio < 1.0:
        raise ValueError(
            "the load zone cannot be computed: the thrust must be larger than F_r tan(alpha), or the rings separate, "
            "and the radial load F_r must not be negative"
        )
    if ratio == 0.0:
        return load_zone(np.inf, exponent)

    def excess(log_eps: float) -> float:
        """Return the logarithm of J_r/J_a over the ratio that the forces require, for a logarithm of eps."""
        zone = load_zone(float(np.exp(log_eps)), exponent)
        return float(np.log(zone.radial / zone.axial / ratio))

    return load_zone(float(np.exp(brentq(excess, np.log(1e-8), np.log(exponent / ratio), xtol=1e-13))), exponent)


#: Exponent n of the power law q ~ delta^n by which the load varies over the load zone (Smith 1994, eq. 3.15).
EXPONENT = 1.1


@dataclass(frozen=True)
class CombinedState:
    """Equilibrium of a tapered roller bearing under thrust and radial load, with every roller as a line contact."""

    #: Axial displacement of the inner ring [m].
    axial: float
    #: Radial displacement of the inner ring [m].
    radial: float
    #: Load Q of either race on every roller ``(N,)`` [N].
    loads: Array
    #: Derivatives of the axial and radial force with respect to the axial and radial displacement ``(2, 2)`` [N/m].
    stiffness: Array
    #: Largest unbalanced force over the thrust.
    residual: float
    #: Whether the residual is below 1e-9.
    converged: bool


def roller_azimuths(bearing: TaperedBearing) -> Array:
    """Return the azimuths of the rollers ``(N,)`` [rad]; the radial load points at the first roller."""
    return 2.0 * np.pi * np.arange(bearing.rollers) / bearing.rollers


def energy_and_derivatives(bearing: TaperedBearing, displacement: Array) -> tuple[float, Array, Array, Array]:
    """Return strain energy, forces, stiffness and roller loads of a bearing at a displacement of its inner ring.

    Parameters
    ----------
    bearing
        The bearing.
    displacement
        Axial and radial displacement [m].

    Returns
    -------
    tuple[float, Array, Array, Array]
        Strain energy [J], axial and radial force ``(2,)`` [N], stiffness ``(2, 2)`` [N/m], roller loads ``(N,)`` [N].
    """
    direction = np.column_stack(
        [np.full(bearing.rollers, np.sin(bearing.cup_angle)), np.cos(bearing.cup_angle) * np.cos(roller_azimuths(bearing))]
    )
    law, length = bearing.law(), bearing.length
    q = law.line_load(direction @ displacement)
    energy, slope = length * law.energy(q), length * law.slope(q)
    return float(energy.sum()), length * (q @ direction), (direction.T * slope) @ direction, length * q


def combined_equilibrium(bearing: TaperedBearing, axial: float, radial: float) -> CombinedState:
    """Return the equilibrium of a bearing under thrust and radial load, by Newton's method on its convex energy.

    Parameters
    ----------
    bearing
        The bearing.
    axial, radial
        Forces F_a and F_r [N]; the radial force points at the first roller.

    Raises
    ------
    ValueError
        The thrust is too small, F_a <= F_r tan(alpha), so that the rings separate, or the radial load is negative.
    """
    start = solve_by_load_zone(bearing, axial, radial)
    force, x = np.array([axial, radial]), np.array([start.axial, start.radial])
    for _ in range(100):
        energy, inner, slope, loads = energy_and_derivatives(bearing, x)
        off = inner - force
        if np.abs(off).max() <= 1e-12 * axial:
            break
        # if only one roller is loaded, one direction has no stiffness: a small diagonal term keeps the step finite
        step = -np.linalg.solve(slope + 1e-9 * np.trace(slope) * np.eye(2), off)
        x = x + _damped_step(bearing, x, step, energy - float(force @ x), force) * step
    residual = float(np.abs(off).max() / axial)
    return CombinedState(float(x[0]), float(x[1]), loads, slope, residual, residual < 1e-9)


def _damped_step(bearing: TaperedBearing, x: Array, step: Array, level: float, force: Array) -> float:
    """Return the largest fraction 1, 1/2, 1/4, ... of a Newton step that does not raise the potential energy.

    Round-off is tolerated. ``x``, ``step``: displacement and Newton step, axial and radial ``(2,)`` [m]; ``level``:
    potential energy at ``x`` [J]; ``force``: external axial and radial force ``(2,)`` [N].
    """
    fraction = 1.0
    while fraction > 1e-6:
        trial = x + fraction * step
        if _elastic_energy(bearing, trial) - float(force @ trial) <= level + 1e-14 * abs(level):
            return fraction
        fraction *= 0.5
    return fraction


def _elastic_energy(bearing: TaperedBearing, x: Array) -> float:
    """Return the strain energy of the bearing [J]; infinite where a trial step leaves the range of the line contact.

    ``x``: axial and radial displacement of the inner ring ``(2,)`` [m].
    """
    try:
        return energy_and_derivatives(bearing, x)[0]
    except ValueError:
        return np.inf


@dataclass(frozen=True)
class ZoneState:
    """Displacements and largest load of a bearing under thrust and radial load, by load-zone integrals."""

    #: Axial displacement of the inner ring [m].
    axial: float
    #: Radial displacement of the inner ring [m].
    radial: float
    #: Largest roller load [N].
    greatest: float
    #: Load zone of the row.
    zone: LoadZone


def solve_by_load_zone(bearing: TaperedBearing, axial: float, radial: float) -> ZoneState:
    """Return displacements and largest load by Smith's load-zone method, with exact integrals and exact line contact.

    A power law distributes the load over the rollers, and the line contact of the most loaded roller gives its compression.
    The result is exact for pure thrust. Otherwise its accuracy depends on the exponent and on the number of rollers, taken
    as infinite. Arguments and errors are those of `combined_equilibrium`.

    References
    ----------
    Smith (1994), 3.14 to 3.21.
    """
    zone = load_zone_of_forces(axial, radial, bearing.cup_angle, EXPONENT)
    greatest = axial / (bearing.rollers * np.sin(bearing.cup_angle) * zone.axial)
    normal = float(bearing.law().approach(greatest / bearing.length))
    w = 0.5 / zone.eps
    return ZoneState(
        float((1.0 - w) * normal / np.sin(bearing.cup_angle)),
        float(w * normal / np.cos(bearing.cup_angle)),
        float(greatest),
        zone,
    )
