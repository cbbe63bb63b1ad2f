"""Rows of bearings on one shaft: equilibrium of any arrangement under preload and external thrust.

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
from rollbench.meshes.roots import brentq


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
