"""Equilibrium of one row of tapered rollers, as the minimum of its energy in two displacements of a ring that cannot tilt.

It is a second formulation of what `lowfi.statics.axis` solves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.bearings.tapered_roller import load_zone_under_thrust_and_radial_load
from rollbench.lowfi.rollers import LineContactLaw, TaperedBearing
from rollbench.meshes.arrays import Array

#: Exponent n of the power law q ~ delta^n by which the load varies over the load zone (Smith 1994, eq. 3.15).
EXPONENT = 1.1


@dataclass(frozen=True)
class LoadZoneSolution:
    """Displacements and largest roller load of a bearing under thrust and radial load, by load-zone integrals."""

    #: Axial displacement of the inner ring [m].
    axial_displacement: float
    #: Radial displacement of the inner ring [m].
    radial_displacement: float
    #: Contact load of the most heavily loaded roller, the same on inner and outer race [N].
    largest_roller_load: float


def solve_by_smith_load_zone(bearing: TaperedBearing, axial: float, radial: float) -> LoadZoneSolution:
    """Return displacements and largest roller load of a bearing by Smith's load-zone method.

    The load is distributed over the rollers by a power law, load ~ deflection^1.1; the compression of the most loaded
    roller then follows from the law of its line contact. The integrals over the load zone and the law of the line contact
    are evaluated exactly. The result is exact for pure thrust. Otherwise its accuracy depends on the exponent and on the
    number of rollers, taken as infinite.

    Parameters
    ----------
    bearing
        The bearing.
    axial, radial
        Thrust F_a and radial force F_r [N]; the radial force points at the first roller.

    Raises
    ------
    ValueError
        The thrust is too small, F_a <= F_r tan(alpha) with the half angle alpha of the cup, so that the rings separate, or
        the radial load is negative.

    References
    ----------
    Smith (1994), 3.14 to 3.21.
    """
    zone = load_zone_under_thrust_and_radial_load(axial, radial, bearing.cup_angle, EXPONENT)
    greatest = axial / (bearing.rollers * np.sin(bearing.cup_angle) * zone.thrust_integral)
    normal = float(bearing.approach_law().approach(greatest / bearing.length))
    w = 0.5 / zone.eps
    axial_displacement = float((1.0 - w) * normal / np.sin(bearing.cup_angle))
    return LoadZoneSolution(axial_displacement, float(w * normal / np.cos(bearing.cup_angle)), float(greatest))


@dataclass(frozen=True)
class ThrustAndRadialState:
    """Displacements, roller loads and stiffness of a tapered roller bearing in equilibrium under thrust and radial load."""

    #: Axial displacement of the inner ring [m].
    axial_displacement: float
    #: Radial displacement of the inner ring [m].
    radial_displacement: float
    #: Contact load of each of the N rollers, the same on inner and outer race ``(N,)`` [N].
    roller_loads: Array
    #: Derivatives of the axial and radial force with respect to the axial and radial displacement ``(2, 2)`` [N/m].
    stiffness: Array
    #: Whether the largest unbalanced force on the inner ring is below 1e-9 of the thrust.
    converged: bool


def roller_azimuths(bearing: TaperedBearing) -> Array:
    """Return the azimuths of the rollers ``(N,)`` [rad]; the radial load points at the first roller."""
    return 2.0 * np.pi * np.arange(bearing.rollers) / bearing.rollers


def energy_per_length(law: LineContactLaw, line_load: Array) -> Array:
    """Integral of the load per length over the approach of both raceways, up to ``line_load`` [N/m]: an energy [J/m]."""
    safe = np.where(line_load > 0.0, line_load, 1.0)
    return np.where(line_load > 0.0, 0.5 * line_load**2 * (law.g - law.s * (0.5 + np.log(safe))), 0.0)


def strain_energy_and_derivatives(bearing: TaperedBearing, displacement: Array) -> tuple[float, Array, Array, Array]:
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
    sin, cos = np.sin(bearing.cup_angle), np.cos(bearing.cup_angle)
    direction = np.column_stack([np.full(bearing.rollers, sin), cos * np.cos(roller_azimuths(bearing))])
    law, length = bearing.approach_law(), bearing.length
    q = law.line_load(direction @ displacement)
    energy, slope = length * energy_per_length(law, q), length * law.stiffness_per_length(q)
    return float(energy.sum()), length * (q @ direction), (direction.T * slope) @ direction, length * q


def solve_thrust_and_radial_equilibrium(bearing: TaperedBearing, axial: float, radial: float) -> ThrustAndRadialState:
    """Solve for the equilibrium of a tapered roller bearing under thrust and radial load, by Newton's method on its energy.

    Parameters
    ----------
    bearing
        The bearing.
    axial, radial
        Thrust F_a and radial force F_r [N]; the radial force points at the first roller.

    Raises
    ------
    ValueError
        The thrust is too small, F_a <= F_r tan(alpha) with the half angle alpha of the cup, so that the rings separate, or
        the radial load is negative.
    """
    start = solve_by_smith_load_zone(bearing, axial, radial)
    force, x = np.array([axial, radial]), np.array([start.axial_displacement, start.radial_displacement])

    def potential(at: Array) -> float:
        try:
            return strain_energy_and_derivatives(bearing, at)[0] - float(force @ at)
        except ValueError:  # too large for Hertz's line contact
            return np.inf

    for _ in range(100):
        energy, inner, slope, loads = strain_energy_and_derivatives(bearing, x)
        off = inner - force
        if np.abs(off).max() <= 1e-12 * axial:
            break
        # if only one roller is loaded, one direction has no stiffness: a small diagonal term keeps the step finite
        step, now = -np.linalg.solve(slope + 1e-9 * np.trace(slope) * np.eye(2), off), energy - float(force @ x)
        steps = (0.5**k * step for k in range(20))
        x = x + next((one for one in steps if potential(x + one) <= now + 1e-14 * abs(now)), 1e-6 * step)
    return ThrustAndRadialState(float(x[0]), float(x[1]), loads, slope, bool(np.abs(off).max() < 1e-9 * axial))
