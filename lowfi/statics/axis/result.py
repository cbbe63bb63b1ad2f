"""Result of several rolling sets on one shaft: each set's own, and sums of the whole."""

from __future__ import annotations

from dataclasses import dataclass

from lowfi.statics.result import Equilibrium, SolverReport, StaticResult
from meshes.arrays import Array
from meshes.axis import RollingSet


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


@dataclass(frozen=True)
class HousingResult:
    """Motion (6,) of a housing at its station; what the frame does to it there: wrench (6,) [N, N m] of what holds it and
    of its springs; residual: unbalanced force and moment over the largest force."""

    name: str
    motion: Array
    wrench: Array
    residual: float


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
    warnings: tuple[str, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"
