"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import jacobian, newton, residual, worst
from .contacts import alone, friction, meeting, semi_axes
from .joint import assemble, newton_joint

__all__ = [
    "alone",
    "assemble",
    "friction",
    "jacobian",
    "meeting",
    "newton",
    "newton_joint",
    "residual",
    "semi_axes",
    "worst",
]
