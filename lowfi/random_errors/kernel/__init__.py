"""Kernels for balls with random errors between screw and nut, in the subset of Python that numba compiles (`lowfi.jit`)."""

from .chain import TOLERANCE, ball_force, solve_batch, solve_by_newton

__all__ = ["TOLERANCE", "ball_force", "solve_batch", "solve_by_newton"]
