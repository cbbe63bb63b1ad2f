"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .equations import FILLED, WIDTH, regularised
from .motion import STARTS, chain_motion, motion_from, other_motion

__all__ = ["FILLED", "STARTS", "WIDTH", "chain_motion", "motion_from", "other_motion", "regularised"]
