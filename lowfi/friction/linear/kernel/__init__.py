"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .equations import FILLED, WIDTH, regularised_friction
from .motion import STARTS, chain_motion, motion_from_other_start, motion_from_state

__all__ = [
    "FILLED",
    "STARTS",
    "WIDTH",
    "chain_motion",
    "motion_from_other_start",
    "motion_from_state",
    "regularised_friction",
]
