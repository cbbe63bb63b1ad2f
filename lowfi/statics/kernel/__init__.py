"""Numerical kernels of the static models: equilibrium of balls and rollers with rigid, beam-like and elastic bodies.

They are written in the subset of Python that numba compiles, and run with or without compilation; see ``lowfi.jit``, which
loads this package. Models find the kernels as attributes of the loaded module.
"""

# ruff: noqa: F401
from .axis import add_structure_stiffness, evaluate_axis, factor_tangent_stiffness, solve_axis, solve_for_motions
from .ball import find_ball_equilibrium
from .beam import assemble_beam_stiffness, evaluate_screw, solve_beam, solve_specimens
from .contact import contact_law
from .elastic import evaluate_balls, solve_forces, write_stiffness_factors
from .rollers import add_roller_forces
