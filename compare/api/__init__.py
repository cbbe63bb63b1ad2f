"""The library: what ``import rollbench`` gives. Reads scenes, solves them, and sets models beside the 3D reference."""

from compare.api.calls import check, compare, friction, read, solve
from compare.api.results import Friction, Judged, Result, Solution

__all__ = ["Friction", "Judged", "Result", "Solution", "check", "compare", "friction", "read", "solve"]
