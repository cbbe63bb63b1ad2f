"""Kernels of ball screws with friction in a subset of Python that numba compiles; see ``lowfi.jit``."""

from .balance import friction, jacobian, meeting, move_without_neighbours, newton, residual, semi_axes, worst
from .joint import assemble, newton_joint

__all__ = [
    "assemble",
    "friction",
    "jacobian",
    "meeting",
    "move_without_neighbours",
    "newton",
    "newton_joint",
    "residual",
    "semi_axes",
    "worst",
]
