"""Kernels of the chain of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .ball import ball
from .batch import batch
from .newton import TOLERANCE, newton

__all__ = ["TOLERANCE", "ball", "batch", "newton"]
