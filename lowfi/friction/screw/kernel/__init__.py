"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import (
    contact_friction,
    largest_residual,
    move_without_neighbours,
    neighbour_forces,
    semi_axes,
    solve_force_balance_of_balls,
    write_force_balance_jacobian,
    write_force_balance_residual,
)
from .joint import solve_loads_and_motion_by_newton, write_loads_and_motion_equations

__all__ = [
    "contact_friction",
    "largest_residual",
    "move_without_neighbours",
    "neighbour_forces",
    "semi_axes",
    "solve_force_balance_of_balls",
    "solve_loads_and_motion_by_newton",
    "write_force_balance_jacobian",
    "write_force_balance_residual",
    "write_loads_and_motion_equations",
]
