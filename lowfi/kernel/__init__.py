"""Kernels of the static model in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .ball import ball
from .newton import ensemble, evaluate, linear_start, solve

__all__ = ["ball", "ensemble", "evaluate", "linear_start", "solve"]
