"""Kinds of scenes, and duty cycles: load cases of the same parts with their shares of the revolutions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from rollbench.meshes import ranges
from rollbench.meshes.arrays import RecordWithArrays
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Load, Scene, Support
from rollbench.meshes.quantity import quantity_field, result_record
from rollbench.meshes.scene_text import (
    Table,
    displacements_with_unit,
    keys_of_record,
    toml_of_tables,
    with_unit,
    without_empty_values,
)

#: Classes of all kinds of scenes that a file may describe.
Described: TypeAlias = "Scene | FrictionScene | Assembly | DutyCycle"


@dataclass(frozen=True)
class FrictionScene(RecordWithArrays):
    """Scene for which only friction is computed; base class of all such kinds."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str]
    #: Name of the scene.
    name: str
    #: Title of the scene, in one line.
    title: str
    #: Publication from which the data are taken.
    source: str
    #: Assumptions where the publication gives no value, as sentences.
    assumed: tuple[str, ...]

    def to_toml(self) -> str:
        """Return the scene as the text of a scene file."""
        head = without_empty_values(title=self.title, source=self.source, assumed=[*self.assumed]) | {"kind": self.kind}
        return toml_of_tables(head | self.file_tables())

    def file_tables(self) -> Table:
        """Return the keys and tables of the scene file that belong to this kind of scene; each kind defines its own."""
        raise NotImplementedError(self.kind)  # no scene is of this base class


@result_record
class LoadCase:
    """One load case of a duty cycle: screw, bearing or shaft under its loads, and its fraction of all revolutions."""

    #: Name of the load case.
    name: str = quantity_field("case", "name of the load case")
    #: Fraction of all revolutions of the duty cycle that occur in this load case; 0 for a load case without revolutions,
    #: which counts only for static safety.
    share: float = quantity_field(
        "share", "fraction of all revolutions of the duty cycle that occur in this load case; 0: static check only"
    )
    #: Angular speed of the rotating part [rad/s]; None if the file gives fractions of the revolutions instead of times and
    #: speeds.
    speed: float | None
    #: Screw, bearing or shaft with the loads, support displacements and ball oversize of this load case.
    scene: Scene | Assembly
    #: Duration of the load case in one cycle [s]; None if the file gives fractions of the revolutions instead of times and
    #: speeds.
    time: float | None = None

    def file_keys(self, before: Scene | Assembly) -> Table:
        """Return the keys of the load case in a scene file: only values that differ from the scene without load cases.

        ``before``: the scene without load cases.
        """
        after = self.scene
        table: Table = {"share": self.share} if self.time is None else {"time": with_unit(ranges.Duration, self.time)}
        table |= {} if self.speed is None else {"speed": with_unit(ranges.Turning, self.speed)}
        table |= {} if after.loads == before.loads else {"loads": [*map(keys_of_record, after.loads)]}
        oversizes = _ball_oversizes(after)
        table |= {} if oversizes == _ball_oversizes(before) else {"oversize": with_unit(ranges.Deviation, oversizes[0])}
        if isinstance(before, Assembly) and isinstance(after, Assembly):
            loaded = [b for a, b in zip(before.housings, after.housings, strict=True) if a != b]
            forces = (keys_of_record(Load(0.0, h.force, h.moment), "at") for h in loaded)
            table |= without_empty_values(housings=[{"name": h.name} | f for h, f in zip(loaded, forces, strict=True)])
        supports = [_displaced_support_keys(*pair) for pair in zip(before.supports, after.supports, strict=True)]
        return table | without_empty_values(supports=[x for x in supports if x])


def _ball_oversizes(parts: Scene | Assembly) -> list[float]:
    """Return the oversize of the ball radii [m] of each ball nut and ball bearing of a scene."""
    scenes = [parts] if isinstance(parts, Scene) else [s.parts for s in parts.sets if isinstance(s.parts, Scene)]
    return [scene.errors.balls.oversize for scene in scenes]


def _displaced_support_keys(before: Support, after: Support) -> Table:
    """Return the keys of a support whose prescribed displacement changes in a load case; empty where none changes.

    ``before``: the support in the scene without load cases; ``after``: the same support in the load case.
    """
    moved = displacements_with_unit((name, x) for name, x in after.fixed if dict(before.fixed)[name] != x)
    return {"at": with_unit(ranges.Station, after.at), "displace": moved} if moved else {}


@dataclass(frozen=True)
class DutyCycle:
    """Duty cycle: several load cases of one ball screw, bearing or shaft, in the order of the scene file."""

    #: Screw, bearing or shaft with the loads that the file states outside its load cases.
    parts: Scene | Assembly
    #: Load cases, in the order of the file.
    cases: tuple[LoadCase, ...]
    #: Mean absolute angular speed of the rotating part over the cycle [rad/s]; None if the file states no speed.
    speed: float | None

    def to_toml(self) -> str:
        """Return the duty cycle as the text of a scene file."""
        prefix = f"{self.parts.name}-"
        cases = [{"name": c.scene.name.removeprefix(prefix), **c.file_keys(self.parts)} for c in self.cases]
        return toml_of_tables(self.parts.file_tables() | {"cases": cases})

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.parts.name

    @property
    def title(self) -> str:
        """Title of the scene."""
        return self.parts.title

    @property
    def assumed(self) -> tuple[str, ...]:
        """Assumptions of the scene."""
        return self.parts.assumed

    @property
    def sets(self) -> dict[str, Scene | RollerRow]:
        """Geometry and materials of each nut or bearing row, by its name; the name is empty if there is only one."""
        if isinstance(self.parts, Scene):
            return {"": self.parts}
        return {s.name: s.parts for s in self.parts.sets}

    @property
    def revolution_shares(self) -> tuple[float, ...]:
        """Fraction of the duty cycle's revolutions that occur in each load case; the sum is 1."""
        return tuple(case.share for case in self.cases)


@dataclass(frozen=True)
class LoadCaseOfDutyCycle:
    """One load case together with the duty cycle (scene with several load cases) to which it belongs."""

    #: Duty cycle to which the load case belongs.
    duty_cycle: DutyCycle
    #: Load case of the duty cycle.
    load_case: LoadCase

    @property
    def identifying_values(self) -> dict[str, Any]:
        """Names and values that identify the load case in every row of JSON results: scene, case, share."""
        return {"scene": self.duty_cycle.name, "case": self.load_case.name, "share": self.load_case.share}


def load_cases_by_scene_name(scenes: Iterable[object]) -> dict[str, LoadCaseOfDutyCycle]:
    """Return the load cases of all duty cycles among the scenes ``scenes``, by the names SCENE-CASE of their scenes."""
    cycles = [cycle for cycle in scenes if isinstance(cycle, DutyCycle)]
    return {case.scene.name: LoadCaseOfDutyCycle(cycle, case) for cycle in cycles for case in cycle.cases}


#: Kinds of scenes with a single nut or bearing row, which every command solves.
WHOLE = ("ball screw", "bearing")

#: Kind of scenes with several nuts or bearing rows on one shaft.
AXIS = "axis"
