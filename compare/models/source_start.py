"""The source's Newton from the start that serves it best, for comparison with the energy solver."""

from __future__ import annotations

from typing import Literal

from rollbench.lowfi.as_source.static import SourceSolution, solve_source
from rollbench.meshes.parts import Scene


def best_start(scene: Scene, kinematics: Literal["arc", "source"]) -> SourceSolution:
    """The source's Newton from its designer's guess, or by load steps where that fails."""
    solution = solve_source(scene, kinematics=kinematics, start="guess")
    if solution.converged:
        return solution
    return solve_source(scene, kinematics=kinematics, start="load steps")
