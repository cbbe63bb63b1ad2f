"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import (
    largest_residual,
    solve_force_balance_of_balls,
    write_contact_friction,
    write_force_balance_jacobian,
    write_force_balance_residual,
    write_motions_without_neighbours,
    write_neighbour_forces,
    write_semi_axes,
)
from .joint import solve_loads_and_motion_by_newton, write_loads_and_motion_equations

__all__ = [
    "largest_residual",
    "solve_force_balance_of_balls",
    "solve_loads_and_motion_by_newton",
    "write_contact_friction",
    "write_force_balance_jacobian",
    "write_force_balance_residual",
    "write_loads_and_motion_equations",
    "write_motions_without_neighbours",
    "write_neighbour_forces",
    "write_semi_axes",
]
