"""Tasks of the 3D reference: scenes that share set-ups, flanks that may touch, and mesh settings of a level.

A scene with one set has one set-up; equal sets on one shaft share a set-up.
"""

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

#: Scenes that the 3D reference solves: one set, or several on one shaft.
Solvable = Scene | Assembly
#: Settings in which a stored mesh may differ, with cells at least as fine, patches at least as large and all flanks.
_SIZED = ("semi", "reach", "sides")


@dataclass(frozen=True)
class SetUp:
    """Description of a set-up that equal sets share: bodies, meshed flanks, mesh settings."""

    #: Bodies of the set as a scene; with several sets, stations are relative to the set.
    bodies: Scene
    #: Flanks that are meshed.
    sides: tuple[int, ...]
    #: Mesh settings.
    settings: Settings
    #: Numbers of its sets in the assembly.
    sets: tuple[int, ...] = (0,)


def stations(*cases: Solvable) -> tuple[float, ...]:
    """Return the stations of supports and loads of load cases [m], where the 3D shaft has degrees of freedom."""
    return tuple(sorted({x.at for case in cases for given in (case.supports, case.loads) for x in given}))


def balls_of(described: Solvable) -> list[slice]:
    """Return, for each set of balls, the slice of its balls in arrays of all balls."""
    sets = [described] if isinstance(described, Scene) else [s.parts for s in described.sets if isinstance(s.parts, Scene)]
    ends = np.cumsum([0, *(scene.ball_count for scene in sets)])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def refused(described: Solvable, error: ValueError) -> Refusal:
    """Return the Refusal for a scene that the 3D reference cannot solve, with the reason in ``error``."""
    advice = "change what it names, or solve it with a low-order model"
    return Refusal(described.name, "3D reference", str(error), advice)


def _bodies(case: Solvable) -> list[Scene]:
    """Return the meshed bodies of each set; Refusal for a set without a 3D body."""
    if isinstance(case, Scene):
        return [case]
    from rollbench.hifi.several_sets import meshed_bodies

    try:
        return [of_set.bodies for of_set in meshed_bodies(case)]
    except ValueError as error:
        raise refused(case, error) from error


def _expected(case: Solvable, bodies: Sequence[Scene]) -> tuple[ExpectedContacts, ...]:
    """Return the expected contacts (loads, angles) of each set; Refusal if they cannot be estimated.

    For a set without load, a tenth of the mean contact load of the other sets is assumed.
    """
    from rollbench.hifi.meshing.settings import contacts_under_assumed_load, expected_by_set, expected_contacts

    try:
        if isinstance(case, Scene):
            return (expected_contacts(case),)
        expected = expected_by_set(case)
        carried = np.concatenate([e.load[e.load > 0.0] for e in expected])
        light = 0.1 * float(carried.mean()) if carried.size else 0.0
        return tuple(
            e if e.load.any() else contacts_under_assumed_load(body, e, light)
            for body, e in zip(bodies, expected, strict=True)
        )
    except ValueError as error:
        raise refused(case, error) from error


def _pressed(expected: Sequence[ExpectedContacts]) -> tuple[int, ...]:
    """Return the numbers of the flanks that may touch, and of the flanks opposite them across the ball."""
    return tuple(sorted({side for e in expected for touching in e.sides() for side in (touching, 3 - touching)}))


def needed_sides(scene: Scene) -> tuple[int, ...]:
    """Return the numbers of a scene's flanks that may touch (`hifi.meshing.settings`), and of the opposite flanks.

    Refusal if no equilibrium is found.
    """
    return _pressed(_expected(scene, ()))


def set_ups(cases: Sequence[Solvable], level: int, variant: str = "") -> tuple[SetUp, ...]:
    """Return the set-ups that load cases of the same parts share on a mesh level.

    Parameters
    ----------
    cases
        Load cases.
    level
        Mesh level.
    variant
        Modelling variant.

    Returns
    -------
    tuple of SetUp
        The set-ups.

    Raises
    ------
    InputError
        If the level is unknown; as Refusal if a set has no 3D body, or no contacts can be expected.
    """
    from rollbench.hifi.meshing.settings import Settings, round_up_lengths

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
        semi, reach = (
            [round_up_lengths(getattr(e, name)()) for k in sets for e in expected[k]] for name in ("semi", "reach")
        )
        sizes["semi"] = (min(a for a, _ in semi), min(b for _, b in semi))
        sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
        sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
        out.append(SetUp(body, sides, Settings(**sizes), tuple(sets)))
    return tuple(out)


def settings_of(scenes: Sequence[Scene], level: int, variant: str = "") -> Settings:
    """Return the mesh settings for scenes of one geometry on a level, with a variant; raises errors as `set_ups`."""
    return set_ups(scenes, level, variant)[0].settings


def recorded(ups: Sequence[SetUp]) -> dict[str, Any]:
    """Return the mesh settings to store for a run of several sets: cells across a contact, and settings by set."""
    by_set = {k: asdict(up.settings) | {"sides": up.sides} for up in ups for k in up.sets}
    return {"b_over_h": ups[0].settings.b_over_h, "sets": tuple(by_set[k] for k in sorted(by_set))}


def meshes_suit(scene: Solvable, level: int, variant: str, settings: Mapping[str, Any], sides: Sequence[int]) -> bool:
    """Return whether a run's meshes suit a scene: fine enough cells, large enough patches, all touching flanks."""
    changed = VARIANTS[variant].change(scene) if variant and isinstance(scene, Scene) else scene
    try:
        wanted = recorded(set_ups([changed], level, variant))["sets"]
    except InputError:
        return False
    meshed = settings.get("sets", ({**settings, "sides": sides},))
    return len(meshed) == len(wanted) and all(_serves(plain(kept), need) for kept, need in zip(meshed, wanted, strict=True))


def _serves(meshed: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    """Return whether the mesh of a stored run can be used where another mesh is wanted."""
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


def relevant_to_statics(assembly: Assembly, unsaid: Mapping[str, Any]) -> Assembly:
    """Return the assembly with all fields reset that do not affect static loads; ``unsaid``: values for sets."""
    bare = [
        replace(s, name="", parts=replace(s.parts, **unsaid)) if isinstance(s.parts, Scene) else s for s in assembly.sets
    ]
    words: dict[str, Any] = {"name": "", "title": "", "source": "", "assumed": ()}
    return replace(assembly, sets=tuple(bare), friction=None, motion=None, stiffness_at=None, **words)


def geometry_of(scene: Solvable) -> tuple[Any, ...]:
    """Return the parts of a scene that must be equal for scenes to share a set-up."""
    if isinstance(scene, Assembly):
        each = (
            (s.parts if not isinstance(s.parts, Scene) else geometry_of(s.parts), s.position, s.carrier) for s in scene.sets
        )
        return (*each, scene.screw, scene.thermal_strain, stations(scene))
    return scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw


def groups(scenes: Sequence[Solvable]) -> list[list[Solvable]]:
    """Return the scenes in groups of equal geometry, in order of first occurrence."""
    alike: dict[object, list[Solvable]] = {}
    for scene in scenes:
        alike.setdefault(geometry_of(scene), []).append(scene)
    return list(alike.values())


def plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with JSON lists turned back into tuples."""

    def as_tuples(value: Any) -> Any:
        if isinstance(value, list | tuple):
            return tuple(map(as_tuples, value))
        return plain(value) if isinstance(value, dict) else value

    return {name: as_tuples(value) for name, value in settings.items()}


@dataclass(frozen=True)
class Task:
    """Load cases that share set-ups, on one mesh level."""

    #: Scenes of one geometry, with one set or several.
    scenes: tuple[Solvable, ...]
    #: Mesh level.
    level: int
    #: Modelling variant; empty: base.
    variant: str = ""
    #: Whether scenes are also solved without each model ingredient in turn.
    ablate: bool = False
    #: Folder of the mesh cache; None: no cache.
    cache: Path | None = None
    #: Number of processes for one set-up.
    processes: int = 1
    #: Cell size for the cut ends of the shaft, over that of the level.
    cut_cells: float = 1.0

    @property
    def single(self) -> tuple[Scene, ...]:
        """Scenes of the task that have one set."""
        return tuple(scene for scene in self.scenes if isinstance(scene, Scene))

    @property
    def label(self) -> str:
        """Description of the task for the terminal: scenes, mesh level, variant."""
        mesh = "the source's mesh" if self.level == SOURCE_LEVEL else f"level {self.level}"
        tail = f", {VARIANTS[self.variant].label}" if self.variant else ""
        return f"{', '.join(s.name for s in self.scenes)}: {mesh}{tail}"
