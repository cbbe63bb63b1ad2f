"""Kernels of friction in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .dissipation import dissipation, dissipation_many
from .minimum import descend, speeds_at
from .motion import least_dissipation

__all__ = ["descend", "dissipation", "dissipation_many", "least_dissipation", "speeds_at"]
