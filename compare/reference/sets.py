"""What is asked of the 3D reference of several sets on one shaft: the sets that are prepared together, their mesh settings,
and the run that all of them are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.comparison.errors import Refusal
from rollbench.comparison.reference.levels import SOURCE_LEVEL, scaled
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.hifi.meshing.expected import ExpectedContacts
    from rollbench.hifi.meshing.settings import Settings


@dataclass(frozen=True)
class SetUp:
    """A set-up that equal sets share: their bodies in stations of their own, sides that are prepared, mesh settings, places
    of the sets in the assembly."""

    bodies: Scene
    sides: tuple[int, ...]
    settings: Settings
    sets: tuple[int, ...]


def balls_of(assembly: Assembly) -> list[slice]:
    """Balls of each set among those of all."""
    ends = np.cumsum([0, *(s.parts.ball_count for s in assembly.sets if isinstance(s.parts, Scene))])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def stations(assembly: Assembly) -> tuple[float, ...]:
    """Stations [m] of supports and loads: the 3D shaft has freedoms there."""
    return tuple(sorted({*(x.at for x in assembly.supports), *(x.at for x in assembly.loads)}))


def _expected(assembly: Assembly, bodies: Sequence[Scene]) -> tuple[ExpectedContacts, ...]:
    """Contacts to expect of each set; of one that carries nothing as of a tenth of the mean contact load of the others.
    Raises Refusal where none can be expected."""
    from rollbench.hifi.meshing.expected import carrying, expected_by_set

    try:
        expected = expected_by_set(assembly)
        carried = np.concatenate([e.load[e.load > 0.0] for e in expected])
        light = 0.1 * float(carried.mean()) if carried.size else 0.0
        return tuple(e if e.load.any() else carrying(body, e, light) for body, e in zip(bodies, expected, strict=True))
    except ValueError as error:
        raise refused(assembly, error) from error


def set_ups(assemblies: Sequence[Assembly], level: int) -> tuple[SetUp, ...]:
    """The set-ups on a mesh level that load cases of the same sets share. Raises Refusal for sets without 3D bodies, and
    where no contacts can be expected."""
    from rollbench.hifi.meshing.settings import Settings, rounded
    from rollbench.hifi.several_sets import bodies_of

    try:
        bodies = [b.bodies for b in bodies_of(assemblies[0])]
    except ValueError as error:
        raise refused(assemblies[0], error) from error
    expected = [*zip(*(_expected(assembly, bodies) for assembly in assemblies), strict=True)]
    shared: dict[tuple[Scene, tuple[int, ...]], list[int]] = {}
    for k, body in enumerate(bodies):
        sides = tuple(sorted({side for e in expected[k] for touching in e.sides() for side in (touching, 3 - touching)}))
        shared.setdefault((body, sides), []).append(k)
    out = []
    for (body, sides), sets in shared.items():
        sizes = scaled(level, body.balls.radius, ())
        semi, reach = ([rounded(getattr(e, name)()) for k in sets for e in expected[k]] for name in ("semi", "reach"))
        sizes["semi"] = (min(a for a, _ in semi), min(b for _, b in semi))
        sizes["reach"] = (max(a for a, _ in reach), max(b for _, b in reach))
        sizes["element"] = "P1" if level == SOURCE_LEVEL else "Q2"
        out.append(SetUp(body, sides, Settings(**sizes), tuple(sets)))
    return tuple(out)


def refused(described: Scene | Assembly, error: ValueError) -> Refusal:
    """The refusal of what has no equilibrium, bodies or mesh."""
    advice = "change what it names, or solve it with a low-order model"
    return Refusal(described.name, "3D reference", str(error), advice)


def recorded(ups: Sequence[SetUp]) -> dict[str, Any]:
    """Settings of a run of several sets: those of each set, with its prepared sides; cells across a contact."""
    by_set = {k: asdict(up.settings) | {"sides": up.sides} for up in ups for k in up.sets}
    return {"b_over_h": ups[0].settings.b_over_h, "sets": tuple(by_set[k] for k in sorted(by_set))}


def serves_sets(assembly: Assembly, level: int, settings: Mapping[str, Any]) -> bool:
    """Whether the meshes of a run serve an assembly: cells at least as fine, patches as large, all sides that may touch."""
    try:
        wanted = recorded(set_ups([assembly], level))["sets"]
    except Refusal:
        return False
    meshed = settings.get("sets", ())
    return len(meshed) == len(wanted) and all(_serves(kept, need) for kept, need in zip(meshed, wanted, strict=True))


def _serves(meshed: Mapping[str, Any], wanted: Mapping[str, Any]) -> bool:
    sized = ("semi", "reach", "sides")
    return (
        all(meshed.get(k) == v for k, v in wanted.items() if k not in sized)
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
