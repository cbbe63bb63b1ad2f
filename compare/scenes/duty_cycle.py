"""What a scene file describes: names of the kinds, and load cases of one scene with their shares of the revolutions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import Scene
from rollbench.meshes.quantity import quantity, record

if TYPE_CHECKING:
    from rollbench.compare.scenes.friction_kinds.common import KindScene


#: What a scene file describes.
Described: TypeAlias = "Scene | KindScene | Assembly | DutyCycle"


@record
class LoadCase:
    """One load case. share: of the revolutions, 0 where it is checked statically only; speed: of the turning part [rad/s],
    None where the shares are given; scene: the parts, of one set or several, under its loads, supports and oversize; time:
    in one cycle [s], where shares follow from times."""

    name: str = quantity("case", "name of the load case")
    share: float = quantity("share", "part of the revolutions; 0 for a static check")
    speed: float | None
    scene: Scene | Assembly
    time: float | None = None


@dataclass(frozen=True)
class DutyCycle:
    """A scene with several load cases, in the order of the file. parts: the scene without them; speed: mean speed of the
    turning part [rad/s], None where neither the cases nor the scene give one."""

    parts: Scene | Assembly
    cases: tuple[LoadCase, ...]
    speed: float | None

    def to_toml(self) -> str:
        """Text of a scene file that is read as this cycle."""
        from rollbench.meshes.scene_text import axis_tables, case_table, scene_tables, to_toml

        parts = self.parts
        tables = scene_tables(parts) if isinstance(parts, Scene) else axis_tables(parts)
        cases = []
        for case in self.cases:
            table = case_table(case.share, case.time, case.speed, parts, case.scene)
            cases.append({"name": case.scene.name.removeprefix(f"{parts.name}-"), **table})
        return to_toml(tables | {"cases": cases})

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
        """Parts of each set by name; of the only one without a name."""
        if isinstance(self.parts, Scene):
            return {"": self.parts}
        return {s.name: s.parts for s in self.parts.sets}

    @property
    def shares(self) -> tuple[float, ...]:
        """Shares of the revolutions, in order; their sum is 1."""
        return tuple(case.share for case in self.cases)


@dataclass(frozen=True)
class CaseOf:
    """A load case of a cycle, told by the name of its scene."""

    cycle: DutyCycle
    case: LoadCase

    @property
    def keys(self) -> dict[str, Any]:
        """What every row of the case says of it in JSON."""
        return {"scene": self.cycle.name, "case": self.case.name, "share": self.case.share}


def cases_by_name(described: Iterable[object]) -> dict[str, CaseOf]:
    """The load cases among what is described, by the names of their scenes."""
    cycles = [cycle for cycle in described if isinstance(cycle, DutyCycle)]
    return {case.scene.name: CaseOf(cycle, case) for cycle in cycles for case in cycle.cases}


#: Whole screws and bearings, which every command solves.
WHOLE = ("ball screw", "bearing")

#: Several rolling sets on one shaft.
AXIS = "axis"

#: What only friction solves.
KINDS = ("bearing ball", "bearing pair", "linear pair", "linear chain", "screw pair", "screw run")
