"""Kernels for friction and loads of contacts, in the subset of Python that numba compiles (``lowfi.jit``)."""

from .dissipation import dissipation, dissipation_of_contacts
from .motion import (
    GIVEN,
    ROLLING,
    contact_speeds,
    evaluate_dissipation,
    least_dissipation,
    least_dissipation_of_bodies,
    minimise_dissipation,
)
from .rings import contact_energy, hertz_contact, minimise_energy, minimise_energy_of_each_ball, solve_with_pivots

__all__ = [
    "GIVEN",
    "ROLLING",
    "contact_energy",
    "contact_speeds",
    "dissipation",
    "dissipation_of_contacts",
    "evaluate_dissipation",
    "hertz_contact",
    "least_dissipation",
    "least_dissipation_of_bodies",
    "minimise_dissipation",
    "minimise_energy",
    "minimise_energy_of_each_ball",
    "solve_with_pivots",
]
