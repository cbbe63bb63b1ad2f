"""Kernels of friction in a subset of Python that numba compiles; see ``lowfi.jit`` for the two engines."""

from .band import solve_with_pivots
from .dissipation import dissipation, dissipation_many
from .minimum import descend, evaluate, speeds_at
from .motion import GIVEN, ROLLING, least_dissipation, least_dissipation_many
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
