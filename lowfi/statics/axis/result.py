"""Result of several rolling sets on one shaft: each set's own, and sums of the whole."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollbench.lowfi.statics.result import Equilibrium, SolverReport, StaticResult, unknown
from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollingSet


@dataclass(frozen=True)
class SetResult:
    """One set. force, moment (3,): of its elements on the shaft, the moment about the axis at the set's position [N, N m];
    reaction (6,): what they do to the outer part there, the opposite but for arms that grow with the displacements;
    stiffness (6, 6): of the set alone, tangent, its inner part moved at its position and the outer one held [N/m, N, N m];
    outer (6,): motion of the outer part there, with its offset [m, rad]; balls: contacts as of a scene of one set, without
    ``equilibrium``, None for rollers; rollers (count, 2): azimuth [rad] and load [N] of each, line_loads
    (count, slices) [N/m].
    """

    of: RollingSet
    force: Array
    moment: Array
    reaction: Array
    stiffness: Array
    outer: Array
    balls: StaticResult | None = None
    rollers: Array | None = None
    line_loads: Array | None = None

    def without_answers(self) -> SetResult:
        """The set of a result that did not converge: places and numbers of its elements, and nan."""
        rollers = None if self.rollers is None else np.column_stack([self.rollers[:, 0], unknown(self.rollers[:, 1])])
        lines = None if self.line_loads is None else unknown(self.line_loads)
        balls = None if self.balls is None else self.balls.without_answers()
        names = ("force", "moment", "reaction", "stiffness", "outer")
        each: dict[str, Any] = {name: unknown(getattr(self, name)) for name in names}
        return replace(self, **each, balls=balls, rollers=rollers, line_loads=lines)


@dataclass(frozen=True)
class HousingResult:
    """Motion (6,) of a housing at its station; what the frame does to it there: wrench (6,) [N, N m] of what holds it and
    of its springs; residual: unbalanced force and moment over the largest force."""

    name: str
    motion: Array
    wrench: Array
    residual: float

    def without_answers(self) -> HousingResult:
        """The housing in a result that did not converge."""
        return HousingResult(self.name, unknown(self.motion), unknown(self.wrench), float("nan"))


@dataclass(frozen=True)
class AxisResult:
    """Static equilibrium of an assembly. stiffness (6, 6): tangent stiffness of the whole where ``stiffness_at`` says
    [N/m, N, N m], None where that is held; centreline: stations (k,) [m] and motions (k, 6)."""

    model: str
    status: str
    sets: tuple[SetResult, ...]
    housings: tuple[HousingResult, ...]
    centreline_z: Array
    centreline: Array
    equilibrium: Equilibrium | None
    stiffness_at: str
    stiffness: Array | None
    solver: SolverReport
    assumed: tuple[str, ...]
    left_out: tuple[str, ...]
    warnings: tuple[Warned, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"

    def answers(self) -> AxisResult:
        """Itself where it converged; else without loads, motions, stiffness and balance."""
        if self.converged:
            return self
        return replace(
            self,
            sets=tuple(s.without_answers() for s in self.sets),
            housings=tuple(h.without_answers() for h in self.housings),
            centreline=unknown(self.centreline),
            equilibrium=None,
            stiffness=None,
        )
