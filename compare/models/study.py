"""Results of scenes and models, each solved once per report or gate."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from compare.models.registry import Options, run_model
from compare.scenes import catalogue
from lowfi.statics.result import StaticResult
from meshes.parts import Ingredients, Scene


@dataclass
class Study:
    """A cache of solved scenes. Scenes are named as shipped; ``changed`` makes variants of them."""

    scenes: dict[str, Scene] = field(default_factory=dict)
    results: dict[tuple[Scene, str, int], StaticResult] = field(default_factory=dict)

    def scene(self, name: str) -> Scene:
        """Shipped scene by name."""
        if name not in self.scenes:
            self.scenes[name] = catalogue.scene(name)
        return self.scenes[name]

    def changed(self, name: str, **ingredients: Any) -> Scene:
        """Shipped scene with other ingredients (see ``meshes.parts.Ingredients``)."""
        scene = self.scene(name)
        return replace(scene, ingredients=replace(scene.ingredients, **ingredients))

    def solve(self, scene: Scene | str, model: str = "lin", member: int = 0) -> StaticResult:
        """Result of a model on a scene, the source's unless named; solved on first use."""
        parts = self.scene(scene) if isinstance(scene, str) else scene
        key = (parts, model, member)
        if key not in self.results:
            self.results[key] = run_model(parts, model, Options(member=member, discretisation=False, estimate=False))
        return self.results[key]


def with_groove(scene: Scene, conformity: float) -> Scene:
    """The scene with both groove radii set to ``conformity`` times the ball's diameter."""
    radius = 2.0 * conformity * scene.balls.radius
    return replace(scene, screw=replace(scene.screw, groove_radius=radius), nut=replace(scene.nut, groove_radius=radius))


__all__ = ["Ingredients", "Study", "with_groove"]
