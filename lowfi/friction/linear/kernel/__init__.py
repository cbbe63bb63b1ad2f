"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .law import regularised
from .motion import chain_motion

__all__ = ["chain_motion", "regularised"]
