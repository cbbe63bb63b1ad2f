"""Scenes, results and references, each made once per report, gate or test module."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.reference.estimate import Reference, reference
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import SIDES, Scene

T = TypeVar("T")

if TYPE_CHECKING:
    from rollbench.compare.scenes.duty_cycle import Described


@dataclass
class Study:
    """What a report, a gate or a test works on: scenes by name, results, ensembles and stored 3D references.

    stores: folders of runs of the 3D reference, in the order they are searched (None: those of the package); members:
    drawn screws of an ensemble (None: as many as the scene says; 0: no ensemble is made, and what needs one stays open);
    quick: coarse meshes only; timed: run times are measured, not taken from those that are kept; cache: folder of
    meshes and condensed parts (None: none); others:
    scenes of a kind that only friction solves, whose results the evidence itself keeps.
    """

    stores: Sequence[Path] | None = None
    members: int | None = None
    quick: bool = False
    timed: bool = False
    cache: Path | None = None
    scenes: dict[str, Scene] = field(default_factory=dict)
    others: dict[str, Described] = field(default_factory=dict)
    results: dict[tuple[Scene, str, int], StaticResult] = field(default_factory=dict)
    computed: dict[Any, Any] = field(default_factory=dict)

    def scene(self, name: str) -> Scene:
        """Shipped scene by name."""
        if name not in self.scenes:
            self.scenes[name] = catalogue.scene(name)
        return self.scenes[name]

    def uses(self, names: Sequence[str]) -> None:
        """Note that results rest on these shipped scenes, of whatever kind."""
        for name in names:
            scene = catalogue.shipped(name)
            if isinstance(scene, Scene):
                self.scenes.setdefault(name, scene)
            else:
                self.others.setdefault(name, scene)

    @property
    def used(self) -> dict[str, Described]:
        """All scenes used so far, by name, sorted."""
        scenes: dict[str, Described] = {**self.scenes, **self.others}
        return dict(sorted(scenes.items()))

    def changed(self, name: str, **ingredients: Any) -> Scene:
        """Shipped scene with other ingredients (see ``meshes.parts.Ingredients``)."""
        scene = self.scene(name)
        return replace(scene, ingredients=replace(scene.ingredients, **ingredients))

    def solve(self, scene: Scene | str, model: str = "lin", member: int = 0) -> StaticResult:
        """Result of a model on a scene, the source's unless named; solved on first use."""
        parts = self.scene(scene) if isinstance(scene, str) else scene
        key = (parts, model, member)
        if key not in self.results:
            flanks = [parts.errors.side(side) for side in SIDES]
            uneven = any(flank.profile or flank.profile_sigma for flank in flanks)
            engine = "auto" if uneven else "interpreted"  # a few solves do not repay compiling
            self.results[key] = run_model(parts, model, Options(member=member, discretisation=False, engine=engine))
        return self.results[key]

    def once(self, make: Callable[..., T], *args: Any) -> T:
        """``make(study, *args)``, computed on first use; the arguments must be hashable."""
        key = (make, *args)
        if key not in self.computed:
            self.computed[key] = make(self, *args)
        return cast(T, self.computed[key])

    def reference(self, name: str) -> Reference | None:
        """Stored 3D reference of a shipped scene with its grid convergence; None where no store has a converged run."""
        return self.once(_reference, name)

    def references(self, names: Sequence[str]) -> dict[str, Reference]:
        """Stored 3D references of those of the scenes that have one."""
        references = {name: self.reference(name) for name in names}
        return {name: ref for name, ref in references.items() if ref is not None}


def _reference(study: Study, name: str) -> Reference | None:
    return reference(study.scene(name), study.stores)


def with_groove(scene: Scene, conformity: float) -> Scene:
    """The scene with both groove radii set to ``conformity`` times the ball's diameter."""
    radius = 2.0 * conformity * scene.balls.radius
    return replace(scene, screw=replace(scene.screw, groove_radius=radius), nut=replace(scene.nut, groove_radius=radius))


def with_balls(base: Scene, count: int) -> Scene:
    """The screw of ``base`` with ``count`` balls at the same spacing; nut and screw grow with them [m]."""
    step = (base.balls.azimuths[-1] - base.balls.azimuths[0]) / (len(base.balls.azimuths) - 1)
    azimuths = tuple((i - (count - 1) / 2.0) * step for i in range(count))
    length = max(base.nut.length, base.track.lead * count * step / (2.0 * math.pi) + 14e-3)
    total = base.screw.length - base.nut.length + length
    nut = replace(base.nut, length=length, position=total / 2.0)
    screw = replace(base.screw, length=total)
    return replace(base, balls=replace(base.balls, azimuths=azimuths), nut=nut, screw=screw)
