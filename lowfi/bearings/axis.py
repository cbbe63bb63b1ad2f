"""Closed formulas of a ball-screw axis: stretch, heat, loads of the supports, stiffness over position, torque.

A screw shaft of axial stiffness EA/L between two supports, the nut at x from the left one. All springs are linear and all
rings rigid. These formulas are the baseline that scenes with beams, rolling sets and their contacts are compared with; they
are no substitute for them where a row unloads or the stiffness changes with load.

Topology: the nut's force leaves through *both* ends, each a spring of support and piece of screw in series, side by side:

    k_l = 1/(1/k_1 + x/EA),  k_r = 1/(1/k_2 + (L - x)/EA),  1/k = 1/k_nut + 1/(k_l + k_r).

A support without axial stiffness makes it fixed-supported. Smith (1994), 4.6, adds both supports in series with the whole
screw between two rigid walls (`lowfi.bearings.as_printed.series_stiffness`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Axis:
    """Shaft and supports: length between supports [m], area [m^2] at the groove's bottom, Young's modulus [Pa], axial
    stiffness of the left and right support [N/m]; infinite is rigid, zero is free to slide. Raises ValueError for a length,
    area or modulus that is not positive, a negative stiffness, or two free ends."""

    length: float
    area: float
    young: float
    left: float = np.inf
    right: float = np.inf

    def __post_init__(self) -> None:
        """Refuse what cannot carry a load."""
        if min(self.length, self.area, self.young) <= 0.0:
            raise ValueError("length, area and Young's modulus must be positive")
        if min(self.left, self.right) < 0.0 or max(self.left, self.right) == 0.0:
            raise ValueError("stiffnesses must not be negative, and one end must be held")


def _series(*stiffness: float | Array) -> Array:
    """Springs one after the other; a spring of stiffness zero makes all of them zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / sum(1.0 / np.asarray(k, dtype=float) for k in stiffness))


def branches(axis: Axis, position: Array | float) -> tuple[Array, Array]:
    """Stiffness [N/m] of either way from the nut at x [m] to the frame: piece of screw and support in series.

    Raises ValueError for a position outside the supports.
    """
    x = np.asarray(position, dtype=float)
    if np.any(x < 0.0) or np.any(x > axis.length):
        raise ValueError("the nut's position must lie between the supports")
    ea = axis.young * axis.area
    with np.errstate(divide="ignore"):
        return _series(axis.left, ea / x), _series(axis.right, ea / (axis.length - x))


def shaft_stiffness(axis: Axis, position: Array | float) -> Array:
    """Axial stiffness [N/m] that the nut sees of shaft and supports at x [m].

    Between rigid supports EA L/(x (L - x)) (Smith 4.7), with one free end EA/x (4.8).
    """
    left, right = branches(axis, position)
    return np.asarray(left + right)


def axis_stiffness(axis: Axis, position: Array | float, nut: float) -> Array:
    """Stiffness [N/m] of the carriage against the frame: nut in series with both branches."""
    return _series(nut, shaft_stiffness(axis, position))


def support_loads(axis: Axis, position: float, force: float, tension: float = 0.0) -> tuple[float, float]:
    """Thrust [N] of the shaft's tension on the left and the right support, positive towards the other support.

    force: on the nut, positive towards the right support; tension: of the shaft without it. The left support takes the part
    k_l/(k_l + k_r) of the force and is pulled inwards more, the right one less by the rest: left - right = force.
    """
    left, right = (float(k) for k in branches(axis, position))
    share = float(np.isinf(left)) if np.isinf(left) or np.isinf(right) else left / (left + right)
    return tension + share * force, tension - (1.0 - share) * force


def tension(axis: Axis, stretch: float, expansion: float = 0.0, warming: float = 0.0) -> float:
    """Tension [N] of the shaft after a stretch [m] of its ends, and a uniform warming [K] at an expansion [1/K].

    Mends Smith 4.3, 4.4: the elastic strain is the total one *less* the thermal one, F = E A (eps - alpha dT). With elastic
    supports the stretch is shared with them. Both ends carry the whole tension: it is one shaft. Negative is compression.
    """
    springs = _series(axis.left, axis.young * axis.area / axis.length, axis.right)
    return float(springs * (stretch - expansion * warming * axis.length))


def unloading_warming(axis: Axis, stretch: float, expansion: float) -> float:
    """Uniform warming [K] at which the stretch [m] is used up, whatever the supports' stiffness (Smith 4.1, 4.2)."""
    return stretch / (axis.length * expansion)


# --- torque


def angular_speed(speed: float, lead: float) -> float:
    """Angular speed [rad/s] of the screw at a carriage speed [m/s] (Smith 4.12)."""
    return 2.0 * np.pi * speed / lead


def shaft_inertia(density: float, diameter: float, length: float) -> float:
    """Moment of inertia [kg m^2] of a cylinder, pi rho D^4 Z/32 (Smith 4.14, in lb in^2 there); density [kg/m^3]."""
    return float(np.pi * density * diameter**4 * length / 32.0)


@dataclass(frozen=True)
class TorqueBudget:
    """Torques [N m] of an axis: screw, nut, supports (one entry each), acceleration."""

    screw: float
    nut: float
    supports: tuple[float, ...]
    acceleration: float

    @property
    def constant_speed(self) -> float:
        """Sum at constant speed (Smith 4.10)."""
        return self.screw + self.nut + sum(self.supports)

    @property
    def start_up(self) -> float:
        """Greatest torque, with acceleration (Smith 4.11)."""
        return self.constant_speed + self.acceleration


def acceleration_torque(inertias: Sequence[float], speed: float, time: float) -> float:
    """Torque [N m] that brings inertias [kg m^2] to an angular speed [rad/s] in a time [s], evenly (Smith 4.11)."""
    return sum(inertias) * speed / time
