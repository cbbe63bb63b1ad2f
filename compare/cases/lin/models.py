"""Model "source": the equations and the Newton iteration of Lin's thesis."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rollbench.compare.errors import InputError
from rollbench.compare.models.model import C_8, Model, has_beam_screw

if TYPE_CHECKING:
    from rollbench.compare.models.model import ModelOptions
    from rollbench.lowfi.statics.result import StaticResult
    from rollbench.meshes.parts import Scene


def _solve_by_thesis_equations(scene: Scene, options: ModelOptions) -> StaticResult:
    """Solve a scene by the model "source", the equations and Newton iteration of Lin's thesis.

    InputError if the scene has a rigid screw.
    """
    from rollbench.lowfi.as_source.newton import solve_lin_equations_as_static_result

    if scene.ingredients.screw == "rigid":
        advice = "use the model lin; the equations of Lin's thesis describe a beam"
        raise InputError(scene.name, "ingredients.screw", '"rigid"', '"beam"', advice)
    return solve_lin_equations_as_static_result(scene, everything=options.include_ineffective_terms, member=options.member)


#: Models with which the publication computes.
MODELS = (
    Model(
        "source",
        "lin by the equations of Lin's thesis and plain Newton iteration, started from a designer's guess",
        "equations and iteration of Lin's thesis",
        C_8,
        _solve_by_thesis_equations,
        "the equations of Lin's thesis describe a single fixed nut",
        covers_scene=has_beam_screw,
        model_with_same_errors="lin",
    ),
)
