"""Closed formulas of a ball-screw axis, and the equilibrium of rows of bearings on one shaft.

Axis: stretch, heat, loads of the supports, stiffness over position, torque.

A screw shaft of axial stiffness EA/L between two supports, the nut at x from the left one. All springs are linear and all
rings rigid. These formulas are the baseline that scenes with beams, rolling sets and their contacts are compared with; they
are no substitute for them where a row unloads or the stiffness changes with load.

Topology: the nut's force leaves through *both* ends, each a spring of support and piece of screw in series, side by side:

    k_l = 1/(1/k_1 + x/EA),  k_r = 1/(1/k_2 + (L - x)/EA),  1/k = 1/k_nut + 1/(k_l + k_r).

A support without axial stiffness makes it fixed-supported. Smith (1994), 4.6, adds both supports in series with the whole
screw between two rigid walls (`lowfi.bearings.as_printed.series_stiffness`).

Rows of bearings on one shaft: equilibrium of any arrangement under preload and external thrust.

All inner rings move together by u against the outer ones. A row j that faces direction s_j = +1 or -1 is deflected by
s_j u + g_j, where g_j is its share of the ground gaps that the locknut closes, and carries F_j >= 0 (nothing once it is
loose). Equilibrium is

    sum_j s_j F_j(s_j u + g_j) = F,

whose left side grows with u: it is the derivative of a convex energy, so one root, found by bracketing.
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


def shaft_inertia(density: float, diameter: float, length: float, bore: float = 0.0) -> float:
    """Moment of inertia [kg m^2] of a (hollow) cylinder, pi rho (D^4 - d^4) Z/32 (Smith 4.14, in lb in^2 there); density
    [kg/m^3]."""
    return float(np.pi * density * (diameter**4 - bore**4) * length / 32.0)


def screw_inertia(shaft: Assembly, density: float) -> float:
    """Moment of inertia [kg m^2] of a shaft of a density [kg/m^3]: plain stretches by (4.14), the rest with the diameter
    of the same volume as the thread of its first nut (Lin C.8). Rings and nuts are left out.

    Smith takes the root's diameter: less, by (d/D)^4 of the thread's depth.
    """
    nut = next((s.parts for s in shaft.sets if isinstance(s.parts, Scene) and s.parts.track.lead), None)
    ratio = 1.0 if nut is None else float(np.sqrt(volume_ratio(nut)))
    thread = shaft_inertia(density, ratio * shaft.screw.outer_diameter, 1.0, shaft.screw.bore)
    plain = sum(p.end - p.start for p in shaft.segments)
    stretches = (shaft_inertia(density, p.diameter, p.end - p.start, p.bore) for p in shaft.segments)
    return thread * (shaft.screw.length - plain) + sum(stretches)


def reflected_inertia(mass: float, lead: float, efficiency: float = 1.0) -> float:
    """Moment of inertia [kg m^2] that a mass [kg] on the nut adds to the screw's: m (p/(2 pi))^2/e (Smith 4.15); e: share
    of the screw's work that reaches the nut, 1 for the inertia itself, which stores energy m v^2/2."""
    return float(mass * (lead / (2.0 * np.pi)) ** 2 / efficiency)


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


class Row(Protocol):
    """What a set needs of a row: thrust law, its slope and its inverse; all zero where the row is loose."""

    def load(self, deflection: float) -> float:
        """Thrust [N] at a deflection [m]."""

    def stiffness(self, deflection: float) -> float:
        """Slope [N/m] at a deflection [m]."""

    def deflection(self, load: float) -> float:
        """Deflection [m] under a thrust [N]."""


@dataclass(frozen=True)
class PointRow:
    """A row of point contacts whose angle stands still: thrust k u^(3/2), k [N/m^(3/2)]."""

    k: float = 1.0

    @property
    def C(self) -> float:
        """Constant of the row as one contact [m/N^(2/3)]."""
        return float(self.k ** (-2.0 / 3.0))

    def load(self, deflection: float) -> float:
        """Thrust [N] at a deflection [m]; zero where the row is loose."""
        return float(contact_force(deflection, self.C))

    def stiffness(self, deflection: float) -> float:
        """dF/du [N/m]; zero where the row is loose."""
        return float(contact_slope(deflection, self.C))

    def deflection(self, load: float) -> float:
        """Deflection [m] under a thrust [N]."""
        return float(contact_approach(load, self.C))


@dataclass(frozen=True)
class BearingSet:
    """Rows, directions (+1 takes thrust along +) and gap closings g_j [m], one each.

    Tandem rows have the same direction; face to face or back to back makes no difference under pure thrust.
    """

    rows: tuple[Row, ...]
    directions: tuple[int, ...]
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse lists that do not fit together."""
        if not self.rows or not len(self.rows) == len(self.directions) == len(self.offsets):
            raise ValueError("a set needs at least one row, and a direction and an offset for each")
        if any(s not in (1, -1) for s in self.directions):
            raise ValueError("directions are +1 or -1")


@dataclass(frozen=True)
class SetState:
    """Displacement [m], thrust of each row [N] (positive), stiffness of each row and of the set [N/m]."""

    displacement: float
    loads: Array
    row_stiffness: Array

    @property
    def stiffness(self) -> float:
        """Tangent stiffness of the set [N/m]: the rows stand side by side between shaft and housing."""
        return float(self.row_stiffness.sum())


def _of_rows(bearings: BearingSet, displacement: float, law: Callable[[Row, float], float]) -> Array:
    """Load [N] or stiffness [N/m] of each row at a displacement [m]; the rows of a set are often one and deflect alike."""
    known, values = dict[tuple[int, float], float](), []
    for row, s, g in zip(bearings.rows, bearings.directions, bearings.offsets, strict=True):
        at = id(row), s * displacement + g
        if at not in known:
            known[at] = law(row, at[1])
        values.append(known[at])
    return np.array(values)


def _loads(bearings: BearingSet, displacement: float) -> Array:
    """Thrust of each row [N]."""
    return _of_rows(bearings, displacement, lambda row, d: row.load(d))


def state_at(bearings: BearingSet, displacement: float) -> SetState:
    """State at a displacement u [m] of the inner rings."""
    stiffness = _of_rows(bearings, displacement, lambda row, d: row.stiffness(d))
    return SetState(displacement, _loads(bearings, displacement), stiffness)


def equilibrium(bearings: BearingSet, force: float = 0.0) -> SetState:
    """State in which the rows balance an external thrust [N] on the inner rings, to round-off.

    Rows that lose contact carry nothing; the displacement is where they say, not a linear extrapolation. Raises
    ValueError where no row faces the force.
    """
    s = np.array(bearings.directions)
    if force != 0.0 and not np.any(s == np.sign(force)):
        raise ValueError("no row of the set takes thrust in the direction of the force")
    if force == 0.0 and np.unique(s).size == 1:
        return state_at(bearings, -s[0] * max(bearings.offsets))

    def excess(u: float) -> float:
        return float(s @ _loads(bearings, u)) - force

    # between the displacement at which every row facing one way is loose and where it carries all
    step = max(max(abs(g) for g in bearings.offsets), 1e-9)
    low, high = -step, step
    while excess(low) > 0.0:
        low *= 2.0
    while excess(high) < 0.0:
        high *= 2.0
    return state_at(bearings, float(brentq(excess, low, high, xtol=1e-22, rtol=8.9e-16)))


def arrangement(row: Row, directions: Sequence[int], gap: float) -> BearingSet:
    """Set of equal rows, each ground with the same gap [m]: closing it deflects opposed rows by twice the gap in all."""
    return BearingSet((row,) * len(directions), tuple(directions), (gap,) * len(directions))


def preloaded(row: Row, directions: Sequence[int], force: float) -> BearingSet:
    """Set of equal rows in which the rows of each direction carry ``force`` [N] in all, without external thrust.

    The displacement counts from that state. Raises ValueError unless rows face both ways.
    """
    forward, back = sum(s == 1 for s in directions), sum(s == -1 for s in directions)
    if not forward or not back:
        raise ValueError("preload needs rows in both directions")
    depth = {1: row.deflection(force / forward), -1: row.deflection(force / back)}
    return BearingSet((row,) * len(directions), tuple(directions), tuple(depth[s] for s in directions))


def lift_off_force(bearings: BearingSet) -> float:
    """External thrust [N] along + at which the rows facing the other way have all become loose.

    2^n times the preload for two equal opposed rows of load ~ deflection^n: 2.83 for balls of fixed contact angle.
    """
    others = [g for g, s in zip(bearings.offsets, bearings.directions, strict=True) if s == -1]
    if not others:
        raise ValueError("no row faces the other way")
    state = state_at(bearings, max(others))
    return float(np.array(bearings.directions) @ state.loads)
