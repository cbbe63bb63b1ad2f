"""Kernels of the static model in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .ball import settle
from .newton import ensemble, evaluate, linear_start, solve

__all__ = ["ensemble", "evaluate", "linear_start", "settle", "solve"]
