"""Kernels of the static model in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines.

A module is imported when a kernel of it is first asked for: no solve needs those of beams, elastic bodies and whole axes.
"""

from typing import Any

from rollbench.lowfi.jit import part_of

#: Kernels that are called from outside, by their module.
KERNELS = {
    "axis": ("evaluate_axis", "solve_axis", "solve_lines", "tangent"),
    "axis_matrix": ("add_axis",),
    "ball": ("settle_ball",),
    "beam": ("assemble_beam",),
    "contact": ("contact_law",),
    "elastic": ("solve_forces",),
    "elastic_balls": ("ball_rows", "evaluate_balls"),
    "newton": ("ensemble", "evaluate", "solve_beam"),
    "rollers": ("roller_forces",),
}
__all__ = [name for names in KERNELS.values() for name in names]


def __getattr__(name: str) -> Any:
    globals()[name] = found = part_of(__name__, KERNELS, name)
    return found
