"""Kernels of the chain of balls in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .chain import TOLERANCE, ball, batch, newton

__all__ = ["TOLERANCE", "ball", "batch", "newton"]
