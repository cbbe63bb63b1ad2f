"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import (
    balance_jacobian,
    balance_residual,
    contact_friction,
    largest_residual,
    move_without_neighbours,
    neighbour_forces,
    semi_axes,
    solve_balance,
)
from .joint import assemble_joint, newton_joint

__all__ = [
    "assemble_joint",
    "balance_jacobian",
    "balance_residual",
    "contact_friction",
    "largest_residual",
    "move_without_neighbours",
    "neighbour_forces",
    "newton_joint",
    "semi_axes",
    "solve_balance",
]
