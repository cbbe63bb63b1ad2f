"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import alone, friction, jacobian, meeting, newton, residual, semi_axes, worst
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
