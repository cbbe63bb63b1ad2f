"""The library: what ``import rollbench`` gives. Reads scenes, solves them, sets models beside the 3D reference."""

from rollbench.comparison.api.calls import check, compare, friction, mesh_study, read, report, solve, sweep
from rollbench.comparison.api.results import Friction, Judged, Result, Solution

__all__ = [
    "Friction",
    "Judged",
    "Result",
    "Solution",
    "check",
    "compare",
    "friction",
    "mesh_study",
    "read",
    "report",
    "solve",
    "sweep",
]
