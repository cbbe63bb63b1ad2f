"""Kernels for balls with random errors between screw and nut, in the subset of Python that numba compiles (`lowfi.jit`)."""

# ruff: noqa: F401
from .chain import TOLERANCE, ball_force, solve_batch, solve_by_newton
