"""Numerical kernels of the static models: equilibrium of balls and rollers with rigid, beam-like and elastic bodies.

They are written in the subset of Python that numba compiles, and run with or without compilation; see ``lowfi.jit``.
"""

from .axis import add_axis, evaluate_axis, solve_axis, solve_lines, tangent
from .ball import settle_ball
from .beam import assemble_beam, ensemble, evaluate, solve_beam
from .contact import contact_law
from .elastic import ball_rows, evaluate_balls, solve_forces
from .rollers import roller_forces

__all__ = [
    "add_axis",
    "assemble_beam",
    "ball_rows",
    "contact_law",
    "ensemble",
    "evaluate",
    "evaluate_axis",
    "evaluate_balls",
    "roller_forces",
    "settle_ball",
    "solve_axis",
    "solve_beam",
    "solve_forces",
    "solve_lines",
    "tangent",
]
