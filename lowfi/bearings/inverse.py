"""Inverses of bearings under thrust: their state under given loads, and the conformity that a printed rigidity implies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.lowfi.bearings.angular_contact import BallRows, ThrustState, thrust_state
from rollbench.lowfi.hertz import contact_approach
from rollbench.meshes.arrays import Array

#: Conformities among which one is looked for.
CONFORMITIES = (0.503, 0.65)
#: Steps at most, the relative step at which they end, and the displacement over the ball's diameter where they begin.
STEPS, ENOUGH, BEGINS = 40, 1e-10, 1e-4


@dataclass(frozen=True)
class AngleRows:
    """Bearings given as catalogues do, many at once: numbers of balls, diameters of ball and pitch circle [m], conformities
    (groove radius over ball diameter, of both grooves), contact angles without load [rad], arrays of one shape."""

    balls: Array
    ball_diameter: Array
    pitch_diameter: Array
    conformity: Array
    free_angle: Array
    young: float
    poisson: float

    @property
    def inner_groove(self) -> Array:
        """Radii of both grooves [m]."""
        return np.asarray(self.conformity * self.ball_diameter)

    outer_groove = inner_groove

    @property
    def centre_distance(self) -> Array:
        """Distances of the groove centres [m]."""
        return np.asarray((2.0 * self.conformity - 1.0) * self.ball_diameter)


def state_under(bearings: BallRows, load: Array) -> ThrustState:
    """State under thrusts [N] above zero, of a shape that the bearings' fields go with: Newton's method on F^(2/3), which
    is nearly linear in u. Raises ValueError for a thrust that needs displacements beyond Hertz contact."""
    first = BEGINS * bearings.ball_diameter
    u = contact_approach(load / thrust_state(bearings, first).load, first)
    for _ in range(STEPS):
        state = thrust_state(bearings, u)
        step = 1.5 * (np.cbrt(load / state.load) ** 2 - 1.0) * state.load / state.stiffness
        u = np.maximum(u + step, 0.2 * u)
        if float(np.abs(step / u).max()) < ENOUGH and bool(np.all(u < bearings.ball_diameter)):
            return state
    raise ValueError(f"thrust of {float(np.max(load)):.3g} N is beyond what Hertz contact describes for this bearing")


def conformity_of_pair(bearings: AngleRows, preload: Array, rigidity: Array) -> Array:
    """Conformities, the same of both grooves, at which two equal bearings pressed against one another by a preload [N] have
    a tangent rigidity [N/m], 2 dF/du of either; the bearings' own conformities are where the search begins.

    The rigidity falls as the conformity c grows, nearly as a power of c - 1/2: secants on the logarithms. Raises ValueError
    where none in `CONFORMITIES` gives it.
    """
    low, high = np.log(np.array(CONFORMITIES) - 0.5)

    def excess(x: Array) -> Array:
        state = state_under(replace(bearings, conformity=0.5 + np.exp(x)), preload)
        return np.asarray(np.log(2.0 * state.stiffness / rigidity))

    old = np.log(bearings.conformity - 0.5)
    value, slope = excess(old), np.full_like(old, -0.2)
    for _ in range(STEPS):
        new = np.clip(old - value / slope, low, high)
        if float(np.abs(new - old).max()) < ENOUGH:
            break
        fresh = excess(new)
        moved = new != old
        slope = np.where(moved, np.minimum((fresh - value) / np.where(moved, new - old, 1.0), -0.02), slope)
        old, value = new, fresh
    if float(np.abs(value).max()) > 1e-6:
        raise ValueError("no conformity of {:g} to {:g} gives a pair of these balls that rigidity".format(*CONFORMITIES))
    return np.asarray(0.5 + np.exp(old))
