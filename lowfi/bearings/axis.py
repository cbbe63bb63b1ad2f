"""Closed formulas for a ball-screw axis, and the equilibrium of several bearings on one shaft.

The formulas for the axis give the shaft's tension by stretching and heating, the loads of the supports, the stiffness as a
function of the nut's position, and the torque.

A screw shaft of axial stiffness EA/L lies between two supports, the nut at the distance x from the left one. All springs
are linear and all rings rigid. Results of models with beams and contacts are compared with these formulas; the formulas
cannot replace them where a bearing unloads or the stiffness changes with the load.

The nut's force flows through *both* ends of the shaft. Each end is a support in series with a piece of the screw, and the
two ends are in parallel:

    k_l = 1/(1/k_1 + x/EA),  k_r = 1/(1/k_2 + (L - x)/EA),  1/k = 1/k_nut + 1/(k_l + k_r).                              (1)

A support without axial stiffness is a floating bearing. Smith (1994), 4.6, adds both supports in series to the whole screw
between two rigid walls (`lowfi.bearings.as_printed.axis_stiffness_as_printed`).

Several bearings on one shaft, in any arrangement, are in equilibrium under preload and external thrust as follows.

All inner rings move together by u against the outer ones. Bearing row j takes thrust in the direction s_j = +1 or -1. It
is deflected by s_j u + g_j, where g_j is its part of the gaps between the rings that the locknut closes, and carries
F_j >= 0 (zero when it is loose). Equilibrium is

    sum_j s_j F_j(s_j u + g_j) = F.                                                                                    (2)

The left side increases with u, as it is the derivative of a convex energy, so there is one root, found by bracketing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from rollbench.lowfi.hertz import contact_approach, contact_force, contact_stiffness_at_approach
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import grooved_volume_ratio


@dataclass(frozen=True)
class ScrewShaftSprings:
    """Screw shaft between two supports, with shaft and supports as linear axial springs.

    Raises
    ------
    ValueError
        A length, area or modulus is not positive, a stiffness is negative, or both ends are free to slide.
    """

    #: Distance between the supports [m].
    length: float
    #: Area of the shaft's cross-section at the bottom of the groove [m^2].
    area: float
    #: Young's modulus of the shaft [Pa].
    young: float
    #: Axial stiffness of the left support [N/m]; infinite is rigid, zero is free to slide.
    left: float = np.inf
    #: Axial stiffness of the right support [N/m]; infinite is rigid, zero is free to slide.
    right: float = np.inf

    def __post_init__(self) -> None:
        """Check that the axis can carry a load; raise ValueError otherwise."""
        if min(self.length, self.area, self.young) <= 0.0:
            given = f"a length of {self.length:g} m, an area of {self.area:g} m^2 and a modulus of {self.young:g} Pa"
            raise ValueError(f"screw shaft: got {given}; allowed: values above 0")
        if min(self.left, self.right) < 0.0 or max(self.left, self.right) == 0.0:
            given = f"stiffnesses of {self.left:g} and {self.right:g} N/m"
            raise ValueError(f"supports of the screw shaft: got {given}; allowed: none below 0, at least one above 0")


def _series_stiffness(*stiffness: float | Array) -> Array:
    """Return the stiffness of springs in series [N/m]; it is zero if one of them is zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / sum(1.0 / np.asarray(k, dtype=float) for k in stiffness))


def stiffnesses_from_nut_to_frame(axis: ScrewShaftSprings, position: Array | float) -> tuple[Array, Array]:
    """Return the axial stiffnesses from the nut to the frame [N/m], through the left and through the right support.

    They are k_l = 1/(1/k_1 + x/(E A)) and k_r = 1/(1/k_2 + (L - x)/(E A)), with the stiffnesses k_1 and k_2 of the supports
    and the shaft's length L, area A and modulus E.

    Parameters
    ----------
    axis
        Screw shaft and its supports.
    position
        Distance x of the nut from the left support [m].

    Raises
    ------
    ValueError
        A position outside the supports.
    """
    x = np.asarray(position, dtype=float)
    if np.any(x < 0.0) or np.any(x > axis.length):
        given = f"positions from {float(x.min()):g} to {float(x.max()):g} m"
        raise ValueError(f"position of the nut: got {given}; allowed: 0 to {axis.length:g} m, between the supports")
    ea = axis.young * axis.area
    with np.errstate(divide="ignore"):
        return _series_stiffness(axis.left, ea / x), _series_stiffness(axis.right, ea / (axis.length - x))


def shaft_and_support_stiffness(axis: ScrewShaftSprings, position: Array | float) -> Array:
    """Return the axial stiffness k_l + k_r of shaft and supports together, as the nut sees it [N/m].

    k_l and k_r are the stiffnesses from the nut to the frame through the left and through the right support. For a shaft of
    length L, cross-section A and Young's modulus E the sum is E A L/(x (L - x)) with rigid supports (Smith 1994, eq. 4.7),
    and E A/x with a rigid left support and a free right end (eq. 4.8).

    Parameters
    ----------
    axis
        Screw shaft and its supports.
    position
        Distance x of the nut from the left support [m].

    Raises
    ------
    ValueError
        A position outside the supports.

    Examples
    --------
    >>> rigid = ScrewShaftSprings(1.0, 1e-3, 210e9)
    >>> float(shaft_and_support_stiffness(rigid, 0.5)) == 4.0 * 210e9 * 1e-3 / 1.0
    True
    """
    left, right = stiffnesses_from_nut_to_frame(axis, position)
    return np.asarray(left + right)


def carriage_to_frame_stiffness(axis: ScrewShaftSprings, position: Array | float, nut_stiffness: float) -> Array:
    """Return the axial stiffness between carriage and frame through nut, shaft and supports [N/m].

    It is 1/(1/k_nut + 1/(k_l + k_r)): the nut of stiffness k_nut in series with the two ends of the shaft, which have the
    stiffnesses k_l and k_r between nut and frame (`stiffnesses_from_nut_to_frame`).

    Parameters
    ----------
    axis
        Screw shaft and its supports.
    position
        Distance x of the nut from the left support [m].
    nut_stiffness
        Axial stiffness of the nut [N/m].

    Examples
    --------
    >>> axis = ScrewShaftSprings(1.0, 1e-3, 210e9, left=500e6, right=500e6)
    >>> (carriage_to_frame_stiffness(axis, np.array([0.1, 0.5]), 400e6) * 1e-6).round(1).tolist()  # N/um
    [233.8, 213.2]
    """
    return _series_stiffness(nut_stiffness, shaft_and_support_stiffness(axis, position))


def support_loads(axis: ScrewShaftSprings, position: float, force: float, tension: float = 0.0) -> tuple[float, float]:
    """Return the axial forces of the shaft on left and right support [N], positive if the shaft pulls the support inwards.

    A force to the right on the nut raises the pull on the left support by the fraction k_l/(k_l + k_r) of the force, and
    lowers the pull on the right support by the rest. k_l and k_r are the stiffnesses from the nut to the frame through the
    left and through the right support (`stiffnesses_from_nut_to_frame`).

    Parameters
    ----------
    axis
        Screw shaft and its supports.
    position
        Distance x of the nut from the left support [m].
    force
        Axial force on the nut [N], positive towards the right support.
    tension
        Tension of the shaft without force on the nut [N].

    Examples
    --------
    >>> support_loads(ScrewShaftSprings(1.0, 1e-3, 210e9), 0.25, 1e3, tension=5e3)
    (5750.0, 4750.0)
    """
    left, right = (float(k) for k in stiffnesses_from_nut_to_frame(axis, position))
    share = float(np.isinf(left)) if np.isinf(left) or np.isinf(right) else left / (left + right)
    return tension + share * force, tension - (1.0 - share) * force


def shaft_tension(axis: ScrewShaftSprings, stretch: float, expansion: float = 0.0, warming: float = 0.0) -> float:
    """Return the tension of the shaft after a stretch of its ends and a uniform warming [N]; negative is compression.

    With rigid supports the tension is E A (eps - alpha dT), because the elastic strain is the total strain less the thermal
    strain. E A is Young's modulus times the shaft's cross-section, eps the stretch over the shaft's length, alpha the
    coefficient of thermal expansion, and dT the warming. Elastic supports take up a part of the stretch. Each support
    carries the whole tension.

    Parameters
    ----------
    axis
        Screw shaft and its supports.
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
    >>> round(shaft_tension(ScrewShaftSprings(1.0, 1e-3, 210e9), 50e-6, expansion=12e-6, warming=3.0), 6)
    2940.0
    """
    springs = _series_stiffness(axis.left, axis.young * axis.area / axis.length, axis.right)
    return float(springs * (stretch - expansion * warming * axis.length))


def warming_that_removes_tension(axis: ScrewShaftSprings, stretch: float, expansion: float) -> float:
    """Return the uniform rise of temperature at which a stretched shaft loses its tension [K].

    It does not depend on the stiffness of the supports.

    Parameters
    ----------
    axis
        Screw shaft and its supports.
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


def screw_angular_speed(speed: float, lead: float) -> float:
    """Return the angular speed of the screw, 2 pi v/lead [rad/s].

    Parameters
    ----------
    speed
        Speed v of the carriage [m/s].
    lead
        Lead of the thread [m].

    References
    ----------
    Smith (1994), 4.12.
    """
    return 2.0 * np.pi * speed / lead


def shaft_inertia(density: float, diameter: float, length: float, bore: float = 0.0) -> float:
    """Return the moment of inertia of a solid or hollow shaft about its axis, pi rho (D^4 - d^4) L/32 [kg m^2].

    Parameters
    ----------
    density
        Density rho [kg/m^3].
    diameter, length, bore
        Outer diameter D, length L and diameter d of the bore [m].

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
    """Return the moment of inertia of a whole screw shaft about its axis [kg m^2], without bearing rings and nuts.

    The inertia of plain segments follows Smith (1994), 4.14. The threaded length is taken for a cylinder of the same volume
    as the thread of the shaft's first nut (eq. C.8 of Lin's thesis). Smith takes a cylinder of the root diameter instead:
    for a solid shaft his inertia is lower by the fourth power of the ratio of the two cylinders' diameters.

    Parameters
    ----------
    shaft
        Screw shaft with nuts and bearings.
    density
        Density of the shaft [kg/m^3].
    """
    nut = next((s.parts for s in shaft.sets if isinstance(s.parts, Scene) and s.parts.track.lead), None)
    ratio = 1.0 if nut is None else float(np.sqrt(grooved_volume_ratio(nut)))
    thread = shaft_inertia(density, ratio * shaft.screw.outer_diameter, 1.0, shaft.screw.bore)
    plain = sum(p.end - p.start for p in shaft.segments)
    stretches = (shaft_inertia(density, p.diameter, p.end - p.start, p.bore) for p in shaft.segments)
    return thread * (shaft.screw.length - plain) + sum(stretches)


def reflected_inertia(mass: float, lead: float, efficiency: float = 1.0) -> float:
    """Return the moment of inertia about the screw's axis that a mass moved by the nut adds, m (lead/(2 pi))^2/e [kg m^2].

    Parameters
    ----------
    mass
        Mass m of carriage and load [kg].
    lead
        Lead of the thread [m].
    efficiency
        Efficiency e of the screw in acceleration; 1 gives the inertia without losses, whose kinetic energy is that of the
        moving mass.

    References
    ----------
    Smith (1994), 4.15.

    Examples
    --------
    >>> round(reflected_inertia(200.0, 10e-3) * 1e4, 3)  # kg cm^2
    5.066
    """
    return float(mass * (lead / (2.0 * np.pi)) ** 2 / efficiency)


def acceleration_torque(inertias: Sequence[float], speed: float, time: float) -> float:
    """Return the torque that a uniform acceleration from rest needs, sum(J) omega/t [N m].

    Parameters
    ----------
    inertias
        Moments of inertia J about the screw's axis [kg m^2].
    speed
        Angular speed omega after the acceleration [rad/s].
    time
        Duration t of the acceleration [s].

    References
    ----------
    Smith (1994), 4.11.
    """
    return sum(inertias) * speed / time


class BearingRowLaw(Protocol):
    """Interface of the load-deflection laws of bearing rows on a shaft; a row that has lost contact has no thrust."""

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]."""

    def stiffness(self, deflection: float) -> float:
        """Return the axial stiffness dF/du [N/m] at an axial deflection [m]."""

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N]."""


@dataclass(frozen=True)
class HertzPowerLawRow:
    """Bearing row with a constant contact angle: its thrust at the axial deflection u is k u^(3/2), by Hertz's law."""

    #: Constant k of the thrust k u^(3/2) at the axial deflection u [N/m^(3/2)].
    thrust_constant: float = 1.0

    @property
    def C(self) -> float:
        """Constant C = k^(-2/3) of the axial deflection C F^(2/3) of the row under the thrust F [m/N^(2/3)]."""
        return float(self.thrust_constant ** (-2.0 / 3.0))

    def thrust(self, deflection: float) -> float:
        """Return the thrust [N] at an axial deflection [m]; zero where the row is loose."""
        return float(contact_force(deflection, self.C))

    def stiffness(self, deflection: float) -> float:
        """Return the axial stiffness dF/du [N/m] at an axial deflection [m]; zero where the row is loose."""
        return float(contact_stiffness_at_approach(deflection, self.C))

    def deflection(self, load: float) -> float:
        """Return the axial deflection [m] under a thrust [N]."""
        return float(contact_approach(load, self.C))


@dataclass(frozen=True)
class BearingRows:
    """Bearing rows on one shaft, with their directions and preload.

    Tandem rows have the same direction. Face-to-face and back-to-back arrangements are the same under pure thrust.
    """

    #: Load-deflection law of each row.
    row_laws: tuple[BearingRowLaw, ...]
    #: Direction of each row: +1 if it takes thrust in the positive direction, else -1.
    directions: tuple[int, ...]
    #: Axial deflection of each row [m] when the locknut closes the gap between its rings, at displacement 0 of the inner
    #: rings.
    preload_deflections: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check that the fields have the same length and directions are +1 or -1; raise ValueError otherwise."""
        rows, *others = len(self.row_laws), len(self.directions), len(self.preload_deflections)
        if not rows or others != [rows, rows]:
            counts = f"{rows} rows, {others[0]} directions and {others[1]} preload deflections"
            raise ValueError(
                f"bearing rows: got {counts}; allowed: at least one row, and for each row one direction and one preload "
                "deflection (the gap between its rings that the locknut closes)"
            )
        if any(s not in (1, -1) for s in self.directions):
            raise ValueError(f"directions of bearing rows: got {list(self.directions)}; allowed: +1 and -1")


@dataclass(frozen=True)
class BearingRowsState:
    """Loads and stiffness of the bearings on a shaft at one displacement of their inner rings."""

    #: Axial displacement u of the inner rings [m].
    displacement: float
    #: Thrust of each row [N], not negative.
    row_thrusts: Array
    #: Axial stiffness of each row [N/m].
    row_stiffness: Array

    @property
    def stiffness(self) -> float:
        """Axial tangent stiffness of all bearing rows together [N/m]; the rows act in parallel from shaft to housing."""
        return float(self.row_stiffness.sum())


def _evaluate_row_laws(bearings: BearingRows, displacement: float, quantity: Literal["thrust", "stiffness"]) -> Array:
    """Return a quantity of every row at an axial displacement [m] of the inner rings; equal rows are computed once."""
    rows = zip(bearings.row_laws, bearings.directions, bearings.preload_deflections, strict=True)
    at = [(row, s * displacement + g) for row, s, g in rows]
    known = {(row, deflection): getattr(row, quantity)(deflection) for row, deflection in set(at)}
    return np.array([known[row] for row in at])


def state_of_bearing_rows(bearings: BearingRows, displacement: float) -> BearingRowsState:
    """Return loads and stiffness of the bearings on a shaft at a given axial displacement of their inner rings.

    ``displacement``: axial displacement u [m], in the positive direction of the rows.
    """
    thrusts, stiffness = (_evaluate_row_laws(bearings, displacement, name) for name in ("thrust", "stiffness"))
    return BearingRowsState(displacement, thrusts, stiffness)


def solve_bearing_row_equilibrium(bearings: BearingRows, force: float = 0.0) -> BearingRowsState:
    """Solve for the axial displacement at which the bearings on a shaft balance an external thrust on their inner rings.

    In equilibrium the thrusts of the rows, each with the sign of its direction, add up to the external thrust. Rows that
    lose contact carry no load. The displacement is solved for without linearisation, to round-off.

    Parameters
    ----------
    bearings
        Bearing rows on the shaft.
    force
        External thrust [N], with sign.

    Raises
    ------
    ValueError
        No row takes thrust in the direction of the force.

    Examples
    --------
    Two opposed rows with a preload of 1 kN, under an external thrust of 1 kN: loads of the rows and lift-off force [N].

    >>> pair = equal_rows_with_preload(HertzPowerLawRow(1e10), (1, -1), 1e3)
    >>> solve_bearing_row_equilibrium(pair, 1e3).row_thrusts.round(1).tolist(), round(lift_off_force(pair), 1)
    ([1542.4, 542.4], 2828.4)
    """
    s = np.array(bearings.directions)
    if force != 0.0 and not np.any(s == np.sign(force)):
        raise ValueError(
            f"external thrust: got {force:g} N, but no row takes thrust in that direction; allowed: the opposite sign"
        )
    if force == 0.0 and np.unique(s).size == 1:
        return state_of_bearing_rows(bearings, -s[0] * max(bearings.preload_deflections))

    def thrust_sum_above_external(u: float) -> float:
        """Return the sum of the rows' forces on the shaft less the external thrust [N] at a displacement u [m]."""
        return float(s @ _evaluate_row_laws(bearings, u, "thrust")) - force

    # bracket: one end where the rows of one direction are loose, the other where they carry the whole force
    step = max(max(abs(g) for g in bearings.preload_deflections), 1e-9)
    low, high = -step, step
    while thrust_sum_above_external(low) > 0.0:
        low *= 2.0
    while thrust_sum_above_external(high) < 0.0:
        high *= 2.0
    return state_of_bearing_rows(bearings, float(brentq(thrust_sum_above_external, low, high, xtol=1e-22, rtol=8.9e-16)))


def equal_rows_with_gap(row: BearingRowLaw, directions: Sequence[int], gap: float) -> BearingRows:
    """Return equal bearing rows on a shaft that are preloaded because a locknut closes a gap between the rings of each row.

    Closing the gaps of two opposed rows deflects them by amounts that add up to twice the gap of one row.

    Parameters
    ----------
    row
        Load-deflection law of each row.
    directions
        Direction of each row: +1 if it takes thrust in the positive direction, else -1.
    gap
        Gap of one row [m].
    """
    return BearingRows((row,) * len(directions), tuple(directions), (gap,) * len(directions))


def equal_rows_with_preload(row: BearingRowLaw, directions: Sequence[int], force: float) -> BearingRows:
    """Return equal bearing rows on a shaft with a given preload; displacements are measured from the preloaded state.

    Parameters
    ----------
    row
        Load-deflection law of each row.
    directions
        Direction of each row: +1 if it takes thrust in the positive direction, else -1.
    force
        Preload [N]: total thrust of all rows of one direction without external thrust.

    Raises
    ------
    ValueError
        All rows have the same direction.
    """
    forward, back = sum(s == 1 for s in directions), sum(s == -1 for s in directions)
    if not forward or not back:
        raise ValueError(
            f"preload: got bearing rows with thrust directions {list(directions)}; allowed: rows for both directions"
        )
    depth = {1: row.deflection(force / forward), -1: row.deflection(force / back)}
    return BearingRows((row,) * len(directions), tuple(directions), tuple(depth[s] for s in directions))


def lift_off_force(bearings: BearingRows) -> float:
    """Return the external thrust [N] in the positive direction at which all rows of negative direction lose contact.

    For two equal opposed rows with load ~ deflection^n it is 2^n times the preload: 2.83 times for balls with a constant
    contact angle.

    Parameters
    ----------
    bearings
        Bearing rows with their preload.

    Raises
    ------
    ValueError
        No row has the direction -1.
    """
    others = [g for g, s in zip(bearings.preload_deflections, bearings.directions, strict=True) if s == -1]
    if not others:
        raise ValueError("lift-off force: got bearing rows of direction +1 only; allowed: at least one row of direction -1")
    state = state_of_bearing_rows(bearings, max(others))
    return float(np.array(bearings.directions) @ state.row_thrusts)
