"""What is asked of the 3D reference: scenes that share set-ups, sides that may touch, mesh settings of a level. A scene of
one set has one set-up; of several sets on one shaft, equal ones share theirs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, Refusal
from rollbench.compare.reference.levels import LEVELS, SOURCE_LEVEL, scaled
from rollbench.compare.reference.variants import VARIANTS
from rollbench.meshes.axis import Assembly
from rollbench.meshes.canonical import Fields, canonical
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import ExpectedContacts, Settings

#: What the 3D reference solves: one set, or several on one shaft.
Solvable = Scene | Assembly
#: Settings that another scene's mesh may have otherwise: cells as fine, patches as large, sides as many.
_SIZED = ("semi", "reach", "sides")


@dataclass(frozen=True)
class SetUp:
    """A set-up that equal sets share: their bodies (of one set: its scene; of several: in stations of their own), sides
    that are prepared, mesh settings, places of the sets in the assembly."""

    bodies: Scene
    sides: tuple[int, ...]
    settings: Settings
    sets: tuple[int, ...] = (0,)


def stations(*cases: Solvable) -> tuple[float, ...]:
    """Stations [m] of supports and loads of load cases: the 3D shaft has freedoms there."""
    return tuple(sorted({x.at for case in cases for given in (case.supports, case.loads) for x in given}))


def balls_of(described: Solvable) -> list[slice]:
    """Balls of each set among those of all."""
    sets = [described] if isinstance(described, Scene) else [s.parts for s in described.sets if isinstance(s.parts, Scene)]
    ends = np.cumsum([0, *(scene.ball_count for scene in sets)])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def refused(described: Solvable, error: ValueError) -> Refusal:
    """The refusal of what has no equilibrium, bodies or mesh."""
    advice = "change what it names, or solve it with a low-order model"
    return Refusal(described.name, "3D reference", str(error), advice)


def _bodies(case: Solvable) -> list[Scene]:
    """What is meshed of each set. Raises Refusal for one without a 3D body."""
    if isinstance(case, Scene):
        return [case]
    from rollbench.hifi.several_sets import bodies_of

    try:
        return [of_set.bodies for of_set in bodies_of(case)]
    except ValueError as error:
        raise refused(case, error) from error


def _expected(case: Solvable, bodies: Sequence[Scene]) -> tuple[ExpectedContacts, ...]:
    """Contacts to expect of each set; of one of several that carries nothing as of a tenth of the mean contact load of the
    others. Raises Refusal where none can be expected."""
    from rollbench.hifi.meshing.settings import carrying, expected_by_set, expected_contacts

    try:
        if isinstance(case, Scene):
            return (expected_contacts(case),)
        expected = expected_by_set(case)
        carried = np.concatenate([e.load[e.load > 0.0] for e in expected])
        light = 0.1 * float(carried.mean()) if carried.size else 0.0
        return tuple(e if e.load.any() else carrying(body, e, light) for body, e in zip(bodies, expected, strict=True))
    except ValueError as error:
        raise refused(case, error) from error


def _pressed(expected: Sequence[ExpectedContacts]) -> tuple[int, ...]:
    """Sides that may touch, and those opposite, which press a ball against them."""
    return tuple(sorted({side for e in expected for touching in e.sides() for side in (touching, 3 - touching)}))


def needed_sides(scene: Scene) -> tuple[int, ...]:
    """Sides of a scene that may touch, by `hifi.meshing.settings`, and those opposite. Raises Refusal where that finds no
    equilibrium."""
    return _pressed(_expected(scene, ()))


def set_ups(cases: Sequence[Solvable], level: int, variant: str = "") -> tuple[SetUp, ...]:
    """The set-ups on a mesh level, with a modelling variant, that load cases of the same parts share.

    Raises InputError for an unknown level, Refusal for sets without 3D bodies, and where no contacts can be expected.
    """
    from rollbench.hifi.meshing.settings import Settings, rounded

    if level not in (SOURCE_LEVEL, *LEVELS):
        raise ArgumentError("levels", str(level), f"1 to {len(LEVELS)}", "choose fewer levels")
    bodies = _bodies(cases[0])
    expected = [*zip(*(_expected(case, bodies) for case in cases), strict=True)]
    shared: dict[tuple[Scene, tuple[int, ...]], list[int]] = {}
    for k, body in enumerate(bodies):
        shared.setdefault((body, _pressed(expected[k])), []).append(k)
    out = []
    for (body, sides), sets in shared.items():
        sizes = scaled(level, body.balls.radius, VARIANTS[variant].refined if variant else ())
        semi, reach = ([rounded(getattr(e, name)()) for k in sets for e in expected[k]] for name in ("semi", "reach"))
        sizes["semi"] = (min(a for a, _ in semi), min(b for _, b in semi))
        sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
        sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
        out.append(SetUp(body, sides, Settings(**sizes), tuple(sets)))
    return tuple(out)


def settings_of(scenes: Sequence[Scene], level: int, variant: str = "") -> Settings:
    """Mesh settings that serve ``scenes`` of one geometry on a level with a modelling variant. Raises as `set_ups`."""
    return set_ups(scenes, level, variant)[0].settings


def recorded(ups: Sequence[SetUp]) -> dict[str, Any]:
    """Settings of a run of several sets: those of each set, with its prepared sides; cells across a contact."""
    by_set = {k: asdict(up.settings) | {"sides": up.sides} for up in ups for k in up.sets}
    return {"b_over_h": ups[0].settings.b_over_h, "sets": tuple(by_set[k] for k in sorted(by_set))}


def serves(scene: Solvable, level: int, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> bool:
    """Whether the meshes of a run serve a scene: cells at least as fine, patches as large, all sides that may touch."""
    changed = VARIANTS[variant].change(scene) if variant and isinstance(scene, Scene) else scene
    try:
        wanted = recorded(set_ups([changed], level, variant))["sets"]
    except InputError:
        return False
    meshed = settings.get("sets", ({**settings, "sides": sides},))
    return len(meshed) == len(wanted) and all(_serves(plain(kept), need) for kept, need in zip(meshed, wanted, strict=True))


def _serves(meshed: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    from rollbench.hifi.meshing.settings import Settings

    def others(mesh: Mapping[str, Any]) -> str:
        return canonical(Fields(Settings, {name: mesh[name] for name in wanted.keys() & mesh.keys() - _SIZED}))

    return (
        others(meshed) == others(wanted)
        and {"semi", "reach"} <= meshed.keys()
        and all(x <= y for x, y in zip(meshed["semi"], wanted["semi"], strict=True))
        and all(x >= y for x, y in zip(meshed["reach"], wanted["reach"], strict=True))
        and set(wanted["sides"]) <= set(meshed["sides"])
    )


def meant(assembly: Assembly, unsaid: Mapping[str, Any]) -> Assembly:
    """The assembly without what has no effect on static loads."""
    bare = [
        replace(s, name="", parts=replace(s.parts, **unsaid)) if isinstance(s.parts, Scene) else s for s in assembly.sets
    ]
    words: dict[str, Any] = {"name": "", "title": "", "source": "", "assumed": ()}
    return replace(assembly, sets=tuple(bare), friction=None, motion=None, stiffness_at=None, **words)


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


def plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as they come back from a file: lists are tuples."""

    def as_tuples(value: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(map(as_tuples, value))
        return plain(value) if isinstance(value, dict) else value

    return {name: as_tuples(value) for name, value in settings.items()}


@dataclass(frozen=True)
class Task:
    """Load cases that share set-ups: scenes of one geometry, of one set or several, on one level, with a variant;
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
    def single(self) -> tuple[Scene, ...]:
        """Its scenes of one set."""
        return tuple(scene for scene in self.scenes if isinstance(scene, Scene))

    @property
    def label(self) -> str:
        """What it is, for the terminal."""
        mesh = "the source's mesh" if self.level == SOURCE_LEVEL else f"level {self.level}"
        tail = f", {VARIANTS[self.variant].label}" if self.variant else ""
        return f"{', '.join(s.name for s in self.scenes)}: {mesh}{tail}"
