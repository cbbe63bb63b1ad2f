"""``rollbench friction``: whole screws and bearings, several sets on one shaft, and the kinds that only friction solves."""

from __future__ import annotations

from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.studies.friction.answer import FrictionAnswer
from rollbench.compare.studies.friction.whole import Choices, solve_scene
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


def solve_friction(name: str, choices: Choices) -> FrictionAnswer:
    """Solve a shipped scene or a file of any kind. Raises InputError."""
    scene = catalogue.any_scene(name)
    return solve_any(scene, choices, f"with {name}")


def solve_any(scene: Described, choices: Choices, origin: str) -> FrictionAnswer:
    """Friction of a scene of any kind; origin: what an error names. Raises InputError."""
    if isinstance(scene, Scene):
        return solve_scene(scene, choices)
    if isinstance(scene, DutyCycle):
        from rollbench.compare.studies.friction.cases import solve_cycle

        return solve_cycle(scene, choices)
    if isinstance(scene, Assembly):
        from rollbench.compare.studies.friction.axis import solve_axis

        return solve_axis(scene, choices)
    if choices != Choices():
        advice = "leave them out: such a scene holds its own loads and coefficients"
        given = "model, mu, member, condensed"
        raise ArgumentError(given, origin, "with the scene of a whole screw or bearing", advice)
    from rollbench.compare.studies.friction.kind_solvers import solve_kind

    return solve_kind(scene)


def library(scene: Described, mu: tuple[float, ...], model: str) -> dict[str, Any]:
    """JSON-ready answer on a scene; mu: coefficients in place of the scene's. Raises InputError."""
    return as_json(solve_any(scene, Choices(model, mu), f"with {scene.name}"))


def as_json(found: FrictionAnswer) -> dict[str, Any]:
    """JSON-ready answer, with what stands above it."""
    return found.data | {"warning": found.warning or None}
