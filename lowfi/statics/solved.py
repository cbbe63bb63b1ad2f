"""The solved state that every static solver hands over, whatever its own unknowns were."""

from __future__ import annotations

from dataclasses import dataclass

from rollbench.lowfi.statics.problem import Problem
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class SolvedState:
    """Motions, contacts and reactions at the end of a solve, for ``n`` nodes and ``N`` balls.

    motion: of the nodes ``(n, 6)`` [m, rad]; centre: shifts of the balls in their sections ``(N, 2)`` [m]; force: of the
    contacts ``(N, 4)`` [N]; normal: unit vectors from ball to groove in the section ``(N, 4, 2)``; reactions: of the
    supports on the nodes ``(n, 6)`` [N, N m] (zero for a rigid screw, whose supports take what is left); shifts: motions
    of the flanks in the section ``(N, 4, 2)`` [m], None where all flanks are exact arcs and nothing asks for them;
    scale: largest force met [N].
    """

    problem: Problem
    motion: Array
    centre: Array
    force: Array
    normal: Array
    reactions: Array
    shifts: Array | None
    scale: float
