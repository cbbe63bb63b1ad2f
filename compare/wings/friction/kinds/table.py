"""All kinds of scenes in one table, and the one JSON Schema of a scene file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.comparison.scenes.axis_schema import AxisKeys
from rollbench.comparison.scenes.fault import Fault
from rollbench.comparison.scenes.keys import AXIS, FRICTION_ONLY, without_null
from rollbench.comparison.scenes.schema import SceneKeys
from rollbench.comparison.wings.friction.kinds import bearing_ball, bearing_pair, linear, screw_balls
from rollbench.comparison.wings.friction.kinds.bearing_ball import BearingBallKeys
from rollbench.comparison.wings.friction.kinds.bearing_pair import BearingPairKeys
from rollbench.comparison.wings.friction.kinds.common import KindKeys, KindScene
from rollbench.comparison.wings.friction.kinds.linear import LinearChainKeys, LinearPairKeys
from rollbench.comparison.wings.friction.kinds.screw_balls import ScrewPairKeys, ScrewRunKeys


@dataclass(frozen=True)
class Kind:
    """A kind of friction scene: its keys, what they may not describe, the record of faultless ones."""

    keys: type[KindKeys]
    faults: Callable[[KindKeys], Iterator[Fault]]
    record: Callable[[KindKeys, str], KindScene]


KINDS = {
    "bearing ball": Kind(BearingBallKeys, bearing_ball.faults, bearing_ball.record),
    "bearing pair": Kind(BearingPairKeys, bearing_pair.faults, bearing_pair.record),
    "linear pair": Kind(LinearPairKeys, linear.faults, linear.record),
    "linear chain": Kind(LinearChainKeys, linear.faults, linear.record),
    "screw pair": Kind(ScrewPairKeys, screw_balls.faults, screw_balls.pair_record),
    "screw run": Kind(ScrewRunKeys, screw_balls.faults, screw_balls.run_record),
}
assert tuple(KINDS) == FRICTION_ONLY


def _tag(value: Any) -> str:
    found = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if found == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return found if found in KINDS else "whole"


AnyKeys = Annotated[
    Annotated[SceneKeys, Tag("whole")]
    | Annotated[BearingBallKeys, Tag("bearing ball")]
    | Annotated[BearingPairKeys, Tag("bearing pair")]
    | Annotated[LinearPairKeys, Tag("linear pair")]
    | Annotated[LinearChainKeys, Tag("linear chain")]
    | Annotated[ScrewPairKeys, Tag("screw pair")]
    | Annotated[ScrewRunKeys, Tag("screw run")]
    | Annotated[AxisKeys, Tag("axis")],
    Discriminator(_tag),
]


def json_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a scene file of any kind, with description, unit, range and example of every key."""
    found: dict[str, Any] = without_null(TypeAdapter[Any](AnyKeys).json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "rollbench scene"} | found
