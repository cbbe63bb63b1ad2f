"""The kinds of scenes that only friction solves, in one table."""

from __future__ import annotations

from typing import Annotated, Any, Union

from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.scenes.axis_schema import AxisKeys
from rollbench.compare.scenes.friction_kinds import bearings, linear, screw_balls
from rollbench.compare.scenes.friction_kinds.bearings import BearingBallKeys, BearingPairKeys
from rollbench.compare.scenes.friction_kinds.linear import LinearChainKeys, LinearPairKeys
from rollbench.compare.scenes.friction_kinds.screw_balls import ScrewPairKeys, ScrewRunKeys
from rollbench.compare.scenes.friction_kinds.written import tables
from rollbench.compare.scenes.keys import without_null
from rollbench.compare.scenes.kinds import Kind
from rollbench.compare.scenes.names import AXIS, KINDS
from rollbench.compare.scenes.schema import SceneKeys

TABLE = {
    "bearing ball": Kind(BearingBallKeys, bearings.ball_faults, bearings.ball_record, tables),
    "bearing pair": Kind(BearingPairKeys, bearings.pair_faults, bearings.pair_record, tables),
    "linear pair": Kind(LinearPairKeys, linear.faults, linear.record, tables),
    "linear chain": Kind(LinearChainKeys, linear.faults, linear.record, tables),
    "screw pair": Kind(ScrewPairKeys, screw_balls.faults, screw_balls.pair_record, tables),
    "screw run": Kind(ScrewRunKeys, screw_balls.faults, screw_balls.run_record, tables),
}


def kind_named(name: str) -> Kind:
    """The kind of that name, one of `names.KINDS`."""
    return TABLE[name]


def _tag(value: Any) -> str:
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in KINDS else "whole"


def json_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a scene file of any kind, with description, unit, range and example of every key."""
    by_tag = {"whole": SceneKeys} | {name: kind_named(name).keys for name in KINDS} | {AXIS: AxisKeys}
    every: Any = Annotated[Union[tuple(Annotated[of, Tag(name)] for name, of in by_tag.items())], Discriminator(_tag)]  # noqa: UP007
    schema: dict[str, Any] = without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # beside both values `with_material` takes any
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema
