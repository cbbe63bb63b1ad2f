"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .equations import FILLED, WIDTH, regularised_friction
from .motion import STARTS, motion_from_state, solve_motion_from_other_start, solve_motion_of_ball_row

__all__ = [
    "FILLED",
    "STARTS",
    "WIDTH",
    "motion_from_state",
    "regularised_friction",
    "solve_motion_from_other_start",
    "solve_motion_of_ball_row",
]
