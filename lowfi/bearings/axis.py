"""Closed formulas of a ball-screw axis, and the equilibrium of rows of bearings on one shaft.

Axis: stretch, heat, loads of the supports, stiffness over position, torque.

A screw shaft of axial stiffness EA/L between two supports, the nut at x from the left one. All springs are linear and all
rings rigid. These formulas are the baseline that scenes with beams, rolling sets and their contacts are compared with; they
are no substitute for them where a row unloads or the stiffness changes with load.

Topology: the nut's force leaves through *both* ends, each a spring of support and piece of screw in series, both in
parallel:

    k_l = 1/(1/k_1 + x/EA),  k_r = 1/(1/k_2 + (L - x)/EA),  1/k = 1/k_nut + 1/(k_l + k_r).                              (1)

A support without axial stiffness makes it fixed-supported. Smith (1994), 4.6, adds both supports in series with the whole
screw between two rigid walls (`lowfi.bearings.as_printed.series_stiffness`).

Rows of bearings on one shaft: equilibrium of any arrangement under preload and external thrust.

All inner rings move together by u against the outer ones. A row j that faces direction s_j = +1 or -1 is deflected by
s_j u + g_j, where g_j is its share of the ground gaps that the locknut closes, and carries F_j >= 0 (nothing once it is
loose). Equilibrium is

    sum_j s_j F_j(s_j u + g_j) = F,                                                                                    (2)

whose left side grows with u: it is the derivative of a convex energy, so there is one root, found by bracketing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rollbench.lowfi.hertz import contact_approach, contact_force, contact_slope
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import volume_ratio


@dataclass(frozen=True)
class Axis:
    """Screw shaft between two supports, as linear springs.

    Raises
    ------
    ValueError
        A length, area or modulus that is not positive, a negative stiffness, or two free ends.
    """

    #: Distance between the supports [m].
    length: float
    #: Cross-section at the bottom of the groove [m^2].
    area: float
    #: Young's modulus [Pa].
    young: float
    #: Axial stiffness of the left support [N/m]; infinite is rigid, zero is free to slide.
    left: float = np.inf
    #: Axial stiffness of the right support [N/m], likewise.
    right: float = np.inf

    def __post_init__(self) -> None:
        """Refuse an axis that cannot carry a load."""
        if min(self.length, self.area, self.young) <= 0.0:
            raise ValueError("length, area and Young's modulus must be positive")
        if min(self.left, self.right) < 0.0 or max(self.left, self.right) == 0.0:
            raise ValueError("stiffnesses must not be negative, and one end must be held")


def _series_stiffness(*stiffness: float | Array) -> Array:
    """Return the stiffness of springs in series; one of stiffness zero makes the whole zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / sum(1.0 / np.asarray(k, dtype=float) for k in stiffness))


def branch_stiffnesses(axis: Axis, position: Array | float) -> tuple[Array, Array]:
    """Return the stiffness of both paths from the nut to the frame, k_l and k_r of (1) [N/m].

    Parameters
    ----------
    axis
        The axis.
    position
        Distance x of the nut from the left support [m].

    Raises
    ------
    ValueError
        A position outside the supports.
    """
    x = np.asarray(position, dtype=float)
    if np.any(x < 0.0) or np.any(x > axis.length):
        raise ValueError("the nut's position must lie between the supports")
    ea = axis.young * axis.area
    with np.errstate(divide="ignore"):
        return _series_stiffness(axis.left, ea / x), _series_stiffness(axis.right, ea / (axis.length - x))


def shaft_stiffness(axis: Axis, position: Array | float) -> Array:
    """Return the axial stiffness of shaft and supports at the nut, k_l + k_r [N/m].

    Between rigid supports EA L/(x (L - x)) (Smith 4.7), with one free end EA/x (Smith 4.8).

    Parameters
    ----------
    axis
        The axis.
    position
        Distance x of the nut from the left support [m].

    Raises
    ------
    ValueError
        A position outside the supports.

    Examples
    --------
    >>> rigid = Axis(1.0, 1e-3, 210e9)
    >>> float(shaft_stiffness(rigid, 0.5)) == 4.0 * 210e9 * 1e-3 / 1.0
    True
    """
    left, right = branch_stiffnesses(axis, position)
    return np.asarray(left + right)


def axis_stiffness(axis: Axis, position: Array | float, nut: float) -> Array:
    """Return the stiffness of the carriage against the frame, k of (1) [N/m].

    Parameters
    ----------
    axis
        The axis.
    position
        Distance x of the nut from the left support [m].
    nut
        Axial stiffness of the nut [N/m].

    Examples
    --------
    >>> axis = Axis(1.0, 1e-3, 210e9, left=500e6, right=500e6)
    >>> (axis_stiffness(axis, np.array([0.1, 0.5]), 400e6) * 1e-6).round(1).tolist()  # N/um
    [233.8, 213.2]
    """
    return _series_stiffness(nut, shaft_stiffness(axis, position))


def support_loads(axis: Axis, position: float, force: float, tension: float = 0.0) -> tuple[float, float]:
    """Return the axial forces of the shaft on the left and the right support [N], positive towards the other support.

    The left support takes the part k_l/(k_l + k_r) of the force and is pulled inwards more, the right one less by the rest:
    left - right = force.

    Parameters
    ----------
    axis
        The axis.
    position
        Distance x of the nut from the left support [m].
    force
        Axial force on the nut [N], positive towards the right support.
    tension
        Tension of the shaft without the force [N].

    Examples
    --------
    >>> support_loads(Axis(1.0, 1e-3, 210e9), 0.25, 1e3, tension=5e3)
    (5750.0, 4750.0)
    """
    left, right = (float(k) for k in branch_stiffnesses(axis, position))
    share = float(np.isinf(left)) if np.isinf(left) or np.isinf(right) else left / (left + right)
    return tension + share * force, tension - (1.0 - share) * force


def shaft_tension(axis: Axis, stretch: float, expansion: float = 0.0, warming: float = 0.0) -> float:
    """Return the tension of the shaft after a stretch of its ends and a uniform warming [N]; negative is compression.

    F = E A (eps - alpha dT): the elastic strain is the total one less the thermal one. With elastic supports the stretch is
    shared with them. Both ends carry the whole tension, as it is one shaft.

    Parameters
    ----------
    axis
        The axis.
    stretch
        Increase of the distance of the supports [m].
    expansion
        Coefficient of thermal expansion [1/K].
    warming
        Uniform rise of temperature [K].

    References
    ----------
    Corrects Smith (1994), 4.3 and 4.4.

    Examples
    --------
    >>> round(shaft_tension(Axis(1.0, 1e-3, 210e9), 50e-6, expansion=12e-6, warming=3.0), 6)
    2940.0
    """
    springs = _series_stiffness(axis.left, axis.young * axis.area / axis.length, axis.right)
    return float(springs * (stretch - expansion * warming * axis.length))


def unloading_warming(axis: Axis, stretch: float, expansion: float) -> float:
    """Return the uniform warming at which the shaft's tension vanishes [K], whatever the supports' stiffness.

    Parameters
    ----------
    axis
        The axis.
    stretch
        Increase of the distance of the supports [m].
    expansion
        Coefficient of thermal expansion [1/K].

    References
    ----------
    Smith (1994), 4.1 and 4.2.
    """
    return stretch / (axis.length * expansion)


# --- torque


def angular_speed(speed: float, lead: float) -> float:
    """Return the angular speed of the screw, 2 pi v/lead [rad/s].

    Parameters
    ----------
    speed
        Of the carriage v [m/s].
    lead
        [m].

    References
    ----------
    Smith (1994), 4.12.
    """
    return 2.0 * np.pi * speed / lead


def shaft_inertia(density: float, diameter: float, length: float, bore: float = 0.0) -> float:
    """Return the moment of inertia of a solid or hollow cylinder, pi rho (D^4 - d^4) L/32 [kg m^2].

    Parameters
    ----------
    density
        [kg/m^3].
    diameter, length, bore
        [m].

    References
    ----------
    Smith (1994), 4.14, there in lb in^2.

    Examples
    --------
    >>> round(shaft_inertia(7850.0, 40e-3, 1.0) * 1e4, 3)  # kg cm^2
    19.729
    """
    return float(np.pi * density * (diameter**4 - bore**4) * length / 32.0)


def screw_inertia(shaft: Assembly, density: float) -> float:
    """Return the moment of inertia of a whole shaft [kg m^2], without rings and nuts.

    Plain segments by Smith's 4.14, the rest with the diameter whose cylinder has the volume of the thread of the shaft's
    first nut (Lin C.8). Smith takes the root diameter instead: less, by the fourth power of root over mean diameter.

    Parameters
    ----------
    shaft
        The shaft.
    density
        [kg/m^3].
    """
    nut = next((s.parts for s in shaft.sets if isinstance(s.parts, Scene) and s.parts.track.lead), None)
    ratio = 1.0 if nut is None else float(np.sqrt(volume_ratio(nut)))
    thread = shaft_inertia(density, ratio * shaft.screw.outer_diameter, 1.0, shaft.screw.bore)
    plain = sum(p.end - p.start for p in shaft.segments)
    stretches = (shaft_inertia(density, p.diameter, p.end - p.start, p.bore) for p in shaft.segments)
    return thread * (shaft.screw.length - plain) + sum(stretches)


def reflected_inertia(mass: float, lead: float, efficiency: float = 1.0) -> float:
    """Return the moment of inertia that a mass on the nut adds to the screw's, m (lead/(2 pi))^2/e [kg m^2].

    Parameters
    ----------
    mass
        [kg].
    lead
        [m].
    efficiency
        Part e of the screw's work that reaches the nut; 1 for the inertia itself, which stores the energy m v^2/2.

    References
    ----------
    Smith (1994), 4.15.

    Examples
    --------
    >>> round(reflected_inertia(200.0, 10e-3) * 1e4, 3)  # kg cm^2
    5.066
    """
    return float(mass * (lead / (2.0 * np.pi)) ** 2 / efficiency)


@dataclass(frozen=True)
class TorqueBudget:
    """Torques on the screw of an axis [N m]."""

    #: Torque by the load of the ball screw.
    screw: float
    #: Friction of the nut.
    nut: float
    #: Friction of each support.
    supports: tuple[float, ...]
    #: Torque by acceleration.
    acceleration: float

    @property
    def constant_speed(self) -> float:
        """Torque at constant speed [N m] (Smith 4.10)."""
        return self.screw + self.nut + sum(self.supports)

    @property
    def start_up(self) -> float:
        """Largest torque, with acceleration [N m] (Smith 4.11)."""
        return self.constant_speed + self.acceleration


def acceleration_torque(inertias: Sequence[float], speed: float, time: float) -> float:
    """Return the torque of an even acceleration from rest, sum(J) omega/t [N m].

    Parameters
    ----------
    inertias
        Moments of inertia J [kg m^2].
    speed
        Angular speed omega that is reached [rad/s].
    time
        t [s].

    References
    ----------
    Smith (1994), 4.11.
    """
    return sum(inertias) * speed / time


class Row(Protocol):
    """Row of rolling elements in a set of bearings: thrust over axial deflection; zero where the row is loose."""

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]."""

    def stiffness(self, deflection: float) -> float:
        """Return the stiffness [N/m] at an axial deflection [m]."""

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N]."""


@dataclass(frozen=True)
class PointRow:
    """Row of point contacts with a constant contact angle: thrust k u^(3/2)."""

    #: [N/m^(3/2)].
    k: float = 1.0

    @property
    def C(self) -> float:
        """Constant of the row taken as one contact [m/N^(2/3)], k^(-2/3)."""
        return float(self.k ** (-2.0 / 3.0))

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]; zero where the row is loose."""
        return float(contact_force(deflection, self.C))

    def stiffness(self, deflection: float) -> float:
        """Return the stiffness dF/du [N/m] at an axial deflection [m]; zero where the row is loose."""
        return float(contact_slope(deflection, self.C))

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N]."""
        return float(contact_approach(load, self.C))


@dataclass(frozen=True)
class BearingSet:
    """Rows of bearings on one shaft.

    Tandem rows have the same direction; face to face and back to back are the same under pure thrust.
    """

    #: The rows.
    rows: tuple[Row, ...]
    #: Directions of each row, +1 if it takes thrust along +, else -1.
    directions: tuple[int, ...]
    #: Offsets of each row the deflection g_j by the gaps that the locknut closes [m].
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse lists of different lengths, and directions other than +1 and -1."""
        if not self.rows or not len(self.rows) == len(self.directions) == len(self.offsets):
            raise ValueError("a set needs at least one row, and a direction and an offset for each")
        if any(s not in (1, -1) for s in self.directions):
            raise ValueError("directions are +1 or -1")


@dataclass(frozen=True)
class SetState:
    """Set of bearings at one displacement of its inner rings."""

    #: Axial displacement u [m].
    displacement: float
    #: Thrust of each row [N], not negative.
    loads: Array
    #: Stiffness of each row [N/m].
    row_stiffness: Array

    @property
    def stiffness(self) -> float:
        """Tangent stiffness of the set [N/m]: its rows act in parallel between shaft and housing."""
        return float(self.row_stiffness.sum())


def _evaluate_rows(bearings: BearingSet, displacement: float, law: Callable[[Row, float], float]) -> Array:
    """Return load [N] or stiffness [N/m] of each row at a displacement [m]; equal rows of a set are evaluated once."""
    known, values = dict[tuple[int, float], float](), []
    for row, s, g in zip(bearings.rows, bearings.directions, bearings.offsets, strict=True):
        at = id(row), s * displacement + g
        if at not in known:
            known[at] = law(row, at[1])
        values.append(known[at])
    return np.array(values)


def _thrust_of_rows(bearings: BearingSet, displacement: float) -> Array:
    """Return the thrust of each row [N]."""
    return _evaluate_rows(bearings, displacement, lambda row, d: row.thrust(d))


def bearing_set_state(bearings: BearingSet, displacement: float) -> SetState:
    """Return loads and stiffness of a set at an axial displacement of the inner rings [m]."""
    stiffness = _evaluate_rows(bearings, displacement, lambda row, d: row.stiffness(d))
    return SetState(displacement, _thrust_of_rows(bearings, displacement), stiffness)


def equilibrium(bearings: BearingSet, force: float = 0.0) -> SetState:
    """Return the state of a set that balances an external thrust on the inner rings, (2), to round-off.

    Rows that lose contact carry nothing; the displacement follows from the remaining ones without linearisation.

    Parameters
    ----------
    bearings
        The set.
    force
        External thrust [N], positive along +.

    Raises
    ------
    ValueError
        No row faces the force.

    Examples
    --------
    Two opposed rows with 1 kN preload under 1 kN: each is deflected by the same amount.

    >>> pair = preloaded_rows(PointRow(1e10), (1, -1), 1e3)
    >>> equilibrium(pair, 1e3).loads.round(1).tolist(), round(lift_off_force(pair), 1)
    ([1542.4, 542.4], 2828.4)
    """
    s = np.array(bearings.directions)
    if force != 0.0 and not np.any(s == np.sign(force)):
        raise ValueError("no row of the set takes thrust in the direction of the force")
    if force == 0.0 and np.unique(s).size == 1:
        return bearing_set_state(bearings, -s[0] * max(bearings.offsets))

    def excess(u: float) -> float:
        return float(s @ _thrust_of_rows(bearings, u)) - force

    # between the displacement at which every row facing one way is loose and where it carries all
    step = max(max(abs(g) for g in bearings.offsets), 1e-9)
    low, high = -step, step
    while excess(low) > 0.0:
        low *= 2.0
    while excess(high) < 0.0:
        high *= 2.0
    return bearing_set_state(bearings, float(brentq(excess, low, high, xtol=1e-22, rtol=8.9e-16)))


def equal_rows(row: Row, directions: Sequence[int], gap: float) -> BearingSet:
    """Return a set of equal rows, each ground with the same gap.

    Closing the gap deflects two opposed rows by twice the gap together.

    Parameters
    ----------
    row
        The row.
    directions
        Of each row, +1 if it takes thrust along +, else -1.
    gap
        [m].
    """
    return BearingSet((row,) * len(directions), tuple(directions), (gap,) * len(directions))


def preloaded_rows(row: Row, directions: Sequence[int], force: float) -> BearingSet:
    """Return a set of equal rows with a preload; displacements count from that state.

    Parameters
    ----------
    row
        The row.
    directions
        Of each row, +1 or -1.
    force
        Total thrust of the rows of each direction [N], without external thrust.

    Raises
    ------
    ValueError
        All rows face the same direction.
    """
    forward, back = sum(s == 1 for s in directions), sum(s == -1 for s in directions)
    if not forward or not back:
        raise ValueError("preload needs rows in both directions")
    depth = {1: row.deflection(force / forward), -1: row.deflection(force / back)}
    return BearingSet((row,) * len(directions), tuple(directions), tuple(depth[s] for s in directions))


def lift_off_force(bearings: BearingSet) -> float:
    """Return the external thrust along + at which the rows that face the other way have all become loose [N].

    2^n times the preload for two equal opposed rows of load ~ deflection^n: 2.83 for balls with a constant contact angle.

    Parameters
    ----------
    bearings
        Bearings with their preload.

    Raises
    ------
    ValueError
        No row faces the other way.
    """
    others = [g for g, s in zip(bearings.offsets, bearings.directions, strict=True) if s == -1]
    if not others:
        raise ValueError("no row faces the other way")
    state = bearing_set_state(bearings, max(others))
    return float(np.array(bearings.directions) @ state.loads)
