"""Kernels of chains of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .law import regularised
from .motion import solve

__all__ = ["regularised", "solve"]
