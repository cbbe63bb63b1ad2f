"""Cache of scenes, model results and stored 3D references that one report, error check or test module uses repeatedly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any, TypeVar, cast

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.stored_study import StoredStudies
from rollbench.compare.reference.estimate import Reference, reference_of_scene
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.parts import Scene

T = TypeVar("T")

if TYPE_CHECKING:
    from rollbench.compare.scenes.duty_cycle import Described


@dataclass
class SceneResultCache:
    """Cache of the scenes, model results and stored 3D references of one report or check; each is computed or read once."""

    #: Folders with runs of the 3D reference, in order of search; None: those included with rollbench.
    reference_folders: Sequence[Path] | None = None
    #: Number of random draws of the geometric errors of scenes with random errors; None: as many as the scene states;
    #: 0: results that need such draws are not computed.
    random_draw_count: int | None = None
    #: Whether only coarse meshes are used, to save time.
    quick: bool = False
    #: Whether run times are measured; else stored run times are used.
    measures_run_times: bool = False
    #: Folder of meshes and condensed parts; None: no cache.
    mesh_cache: Path | None = None
    #: Stored values of slow studies; None: every value is computed.
    stored_studies: StoredStudies | None = None
    #: Scenes that are no built-in ones, by name.
    scenes: dict[str, Scene] = field(default_factory=dict)
    #: Names of the scenes on which results depend so far.
    used_scene_names: set[str] = field(default_factory=set)
    #: Results of low-order models by scene and name of the model.
    static_results: dict[tuple[Scene, str], StaticResult] = field(default_factory=dict)
    #: Values that `compute_once` has computed, by function and arguments.
    computed_values: dict[Any, Any] = field(default_factory=dict)
    #: Names of the scenes on which each of these values depends.
    scenes_of_values: dict[Any, frozenset[str]] = field(default_factory=dict)
    #: Processor time in which each of these values was computed [s].
    seconds_of_values: dict[Any, float] = field(default_factory=dict)
    #: Those of these values that are used so far, by function and arguments.
    used_values: set[Any] = field(default_factory=set)
    #: Processor time [s] that was saved because they had been computed before.
    saved_seconds: float = 0.0

    def built_in_scene(self, name: str) -> Scene:
        """Return the scene ``name``: one of ``scenes``, or else the built-in one, read from its file on first use."""
        self.used_scene_names.add(name)
        if name in self.scenes:
            return self.scenes[name]
        return scene_file.single_nut_scene_or_raise(catalogue.shipped_scene(name), name)

    def record_used_scenes(self, names: Iterable[str]) -> None:
        """Record that results of this report or check depend on the built-in scenes ``names``."""
        self.used_scene_names.update(names)

    @property
    def used_scenes(self) -> dict[str, Described]:
        """All scenes on which results of this report or check depend so far, by name, sorted by name."""
        return {name: self.scenes.get(name) or catalogue.shipped_scene(name) for name in sorted(self.used_scene_names)}

    def value_with_scenes_and_seconds(self, compute: Callable[[SceneResultCache], T]) -> tuple[T, frozenset[str], float]:
        """Return the value of ``compute(self)``, the names of the built-in scenes on which it depends, and its time.

        The processor time [s] includes that of used values which `compute_once` had computed before.
        """
        scenes, self.used_scene_names = self.used_scene_names, set()
        values, self.used_values = self.used_values, set()
        start = process_time() + self.saved_seconds
        try:
            value = compute(self)
            return value, frozenset(self.used_scene_names), process_time() + self.saved_seconds - start
        finally:
            self.used_scene_names |= scenes
            self.used_values |= values

    def scene_with_options(self, name: str, **ingredients: Any) -> Scene:
        """Return a copy of the built-in scene ``name`` with changed modelling options.

        ``**ingredients``: new values of fields of `meshes.parts.Ingredients`, by name.
        """
        scene = self.built_in_scene(name)
        return replace(scene, ingredients=replace(scene.ingredients, **ingredients))

    def solve_once(self, scene: Scene | str, model: str = "lin") -> StaticResult:
        """Return the cached result of a model for a scene (of random errors, the first draw), solved on first use.

        ``scene``: the scene, or the name of a built-in scene; ``model``: name of the model.
        """
        parts = self.built_in_scene(scene) if isinstance(scene, str) else scene
        key = (parts, model)
        if key not in self.static_results:
            options = ModelOptions(estimate_beam_mesh_error=False)
            self.static_results[key] = run_model(parts, model, options)
        return self.static_results[key]

    def compute_once(self, function: Callable[..., T], *args: Any) -> T:
        """Return the value of ``function(self, *args)``, which is computed on first use and then cached.

        ``function``: function that takes this cache first; ``args``: its other arguments, which must be hashable.
        """
        key = (function, *args)
        if key not in self.computed_values:
            found = self.value_with_scenes_and_seconds(lambda cache: function(cache, *args))
            self.computed_values[key], self.scenes_of_values[key], self.seconds_of_values[key] = found
        elif key not in self.used_values:
            self.saved_seconds += self.seconds_of_values.get(key, 0.0)
        self.used_values.add(key)
        self.record_used_scenes(self.scenes_of_values.get(key, ()))
        return cast(T, self.computed_values[key])

    def without_values(self) -> SceneResultCache:
        """Return a cache with the same settings and stored studies that has solved and computed nothing yet."""
        return replace(
            self,
            used_scene_names=set(),
            static_results={},
            computed_values={},
            scenes_of_values={},
            seconds_of_values={},
            used_values=set(),
        )

    def stored_reference(self, name: str) -> Reference | None:
        """Return the stored 3D reference of the built-in scene ``name``; None without a converged run."""
        return self.compute_once(_stored_reference, name)

    def stored_references(self, names: Sequence[str]) -> dict[str, Reference]:
        """Return the stored 3D references of the built-in scenes ``names`` by name, without scenes that have none."""
        references = {name: self.stored_reference(name) for name in names}
        return {name: ref for name, ref in references.items() if ref is not None}


def _stored_reference(cache: SceneResultCache, name: str) -> Reference | None:
    """Return the stored 3D reference of a built-in scene; None without a converged run."""
    return reference_of_scene(cache.built_in_scene(name), cache.reference_folders)


def with_conformity(scene: Scene, conformity: float) -> Scene:
    """Return a copy of the scene with the given conformity of both grooves (groove radius over ball diameter)."""
    radius = 2.0 * conformity * scene.balls.radius
    return replace(scene, screw=replace(scene.screw, groove_radius=radius), nut=replace(scene.nut, groove_radius=radius))


def with_ball_count(base: Scene, count: int) -> Scene:
    """Return a copy of the ball screw ``base`` with ``count`` balls at the same spacing.

    If the nut is too short for the balls, nut and screw are lengthened by the same amount. In the copy, the nut is placed
    at the middle of the screw.
    """
    step = (base.balls.azimuths[-1] - base.balls.azimuths[0]) / (len(base.balls.azimuths) - 1)
    azimuths = tuple((i - (count - 1) / 2.0) * step for i in range(count))
    length = max(base.nut.length, base.track.lead * count * step / (2.0 * math.pi) + 14e-3)
    total = base.screw.length - base.nut.length + length
    nut = replace(base.nut, length=length, position=total / 2.0)
    screw = replace(base.screw, length=total)
    return replace(base, balls=replace(base.balls, azimuths=azimuths), nut=nut, screw=screw)
