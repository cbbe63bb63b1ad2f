"""Kernels of the static model in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .axis import evaluate_axis, solve_axis, solve_lines, tangent
from .axis_matrix import add_axis
from .axis_start import start_axis
from .ball import settle_ball
from .beam import assemble_beam
from .elastic import solve_forces, start_forces
from .elastic_balls import ball_rows, contact_law, evaluate_balls, rest
from .flanks import flank_members
from .members import answers, ensemble
from .newton import evaluate, solve_beam, start_and_solve
from .rollers import roller_forces

__all__ = [
    "add_axis",
    "answers",
    "assemble_beam",
    "ball_rows",
    "contact_law",
    "ensemble",
    "evaluate",
    "evaluate_axis",
    "evaluate_balls",
    "flank_members",
    "rest",
    "roller_forces",
    "settle_ball",
    "solve_axis",
    "solve_beam",
    "solve_forces",
    "solve_lines",
    "start_and_solve",
    "start_axis",
    "start_forces",
    "tangent",
]
