"""Kernels of friction in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .band import solve_with_pivots
from .dissipation import dissipation, dissipation_many
from .motion import GIVEN, ROLLING, descend, evaluate, least_dissipation, least_dissipation_many, speeds_at
from .rings import hertz_contact, minimise_each, minimise_energy, press

__all__ = [
    "GIVEN",
    "ROLLING",
    "descend",
    "dissipation",
    "dissipation_many",
    "evaluate",
    "hertz_contact",
    "least_dissipation",
    "least_dissipation_many",
    "minimise_each",
    "minimise_energy",
    "press",
    "solve_with_pivots",
    "speeds_at",
]
