"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .law import regularised
from .motion import STARTS, chain_motion, motion_from, other_motion

__all__ = ["STARTS", "chain_motion", "motion_from", "other_motion", "regularised"]
