"""What is asked of the 3D reference: scenes that share one set-up, sides that may touch, mesh settings of a level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.comparison.errors import InputError
from rollbench.comparison.reference.levels import LEVELS, SOURCE_LEVEL, scaled
from rollbench.comparison.reference.sets import refused, serves_sets, stations
from rollbench.comparison.reference.variants import VARIANTS
from rollbench.meshes.axis import Assembly
from rollbench.meshes.canonical import Fields, canonical
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import Settings

#: What the 3D reference solves: one set, or several on one shaft.
Solvable = Scene | Assembly


def needed_sides(scene: Scene) -> tuple[int, ...]:
    """Sides that may touch, by `hifi.meshing.expected`, and those opposite, which press a ball against them. Raises Refusal
    where that finds no equilibrium."""
    from rollbench.hifi.meshing.expected import expected_contacts

    try:
        return tuple(sorted({side for touching in expected_contacts(scene).sides() for side in (touching, 3 - touching)}))
    except ValueError as error:
        raise refused(scene, error) from error


def geometry_of(scene: Solvable) -> tuple[Any, ...]:
    """What scenes must share to share a set-up."""
    if isinstance(scene, Assembly):
        each = (
            (s.parts if not isinstance(s.parts, Scene) else geometry_of(s.parts), s.position, s.carrier) for s in scene.sets
        )
        return (*each, scene.screw, scene.thermal_strain, stations(scene))
    return scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw


def groups(scenes: Sequence[Solvable]) -> list[list[Solvable]]:
    """Scenes of one geometry together, in order."""
    alike: dict[object, list[Solvable]] = {}
    for scene in scenes:
        alike.setdefault(geometry_of(scene), []).append(scene)
    return list(alike.values())


def settings_of(scenes: Sequence[Scene], level: int, variant: str = "") -> Settings:
    """Mesh settings that serve ``scenes`` of one geometry on a level with a modelling variant.

    Raises InputError for an unknown level, Refusal where no contacts can be expected.
    """
    from rollbench.hifi.meshing.settings import Settings, expected_reach, expected_semi_axes

    if level not in (SOURCE_LEVEL, *LEVELS):
        raise InputError("command line", "--levels", str(level), f"1 to {len(LEVELS)}", "choose fewer levels")
    sizes = scaled(level, scenes[0].balls.radius, VARIANTS[variant].refined if variant else ())
    axes, reach = [], []
    for scene in scenes:
        try:
            axes.append(expected_semi_axes(scene))
            reach.append(expected_reach(scene))
        except ValueError as error:
            raise refused(scene, error) from error
    sizes["semi"] = (min(a for a, _ in axes), min(b for _, b in axes))
    sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
    sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
    return Settings(**sizes)


def serves(scene: Solvable, level: int, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> bool:
    """Whether a mesh of a level serves a scene: cells at least as fine, patches as large, all sides that may touch."""
    if isinstance(scene, Assembly):
        return serves_sets(scene, level, settings)
    changed = VARIANTS[variant].change(scene) if variant else scene
    try:
        wanted, needed = asdict(settings_of([changed], level, variant)), needed_sides(changed)
    except InputError:
        return False
    meshed = plain(settings)
    alike = _but_sizes({k: v for k, v in meshed.items() if k in wanted}) == _but_sizes(wanted)
    fits = {"semi", "reach"} <= set(meshed) and set(needed) <= set(sides)
    return bool(
        alike
        and fits
        and all(x <= y for x, y in zip(meshed["semi"], wanted["semi"], strict=True))
        and all(x >= y for x, y in zip(meshed["reach"], wanted["reach"], strict=True))
    )


def _but_sizes(settings: Mapping[str, Any]) -> str:
    """Settings that must be alike, as a text."""
    return canonical(Fields("Settings", {k: v for k, v in settings.items() if k not in ("semi", "reach")}))


def plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as they come back from a file: lists are tuples."""

    def as_tuples(value: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(map(as_tuples, value))
        return plain(value) if isinstance(value, dict) else value

    return {name: as_tuples(value) for name, value in settings.items()}


@dataclass(frozen=True)
class Task:
    """One set-up and its load cases: scenes of one geometry, of one set or several, on one level, with a variant;
    ``ablate``: also leave out every ingredient in turn; ``cache``: folder of the mesh cache; ``processes`` that one set-up
    may use; ``cut_cells``: element size of the shafts that say what a cut does, over the level's."""

    scenes: tuple[Solvable, ...]
    level: int
    variant: str = ""
    ablate: bool = False
    cache: Path | None = None
    processes: int = 1
    cut_cells: float = 1.0

    @property
    def assemblies(self) -> tuple[Assembly, ...]:
        """Its scenes of several sets on one shaft."""
        return tuple(scene for scene in self.scenes if isinstance(scene, Assembly))

    @property
    def single(self) -> tuple[Scene, ...]:
        """Its scenes of one set."""
        return tuple(scene for scene in self.scenes if isinstance(scene, Scene))

    @property
    def label(self) -> str:
        """What it is, for the terminal."""
        mesh = "the source's mesh" if self.level == SOURCE_LEVEL else f"level {self.level}"
        tail = f", {VARIANTS[self.variant].label}" if self.variant else ""
        return f"{', '.join(s.name for s in self.scenes)}: {mesh}{tail}"
