"""The library: what ``import rollbench`` gives. Reads scenes, solves them, sets models beside the 3D reference."""

from rollbench.compare.api.calls import check, compare_models, friction, mesh_study, read, report, solve, sweep
from rollbench.compare.api.results import Friction, Judged, Result, Solution

__all__ = [
    "Friction",
    "Judged",
    "Result",
    "Solution",
    "check",
    "compare_models",
    "friction",
    "mesh_study",
    "read",
    "report",
    "solve",
    "sweep",
]
