"""List of the kinds of scenes for which only friction is computed, and the JSON Schema of all kinds of scenes."""

from __future__ import annotations

from typing import Annotated, Any, Union

from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.scenes.duty_cycle import AXIS, KINDS
from rollbench.compare.scenes.friction_kinds import bearings, screw_balls
from rollbench.compare.scenes.friction_kinds.common import FrictionSceneKind
from rollbench.compare.scenes.keys import schema_without_null
from rollbench.compare.scenes.schema import SceneKeys, ShaftSceneKeys

#: How the file of each kind of friction scene is read, by the name of the kind (`duty_cycle.KINDS`).
TABLE = {
    "bearing ball": FrictionSceneKind(bearings.BearingBallKeys, bearings.bearing_ball_faults, bearings.bearing_ball_scene),
    "bearing pair": FrictionSceneKind(bearings.BearingPairKeys, bearings.bearing_pair_faults, bearings.bearing_pair_scene),
    "linear pair": FrictionSceneKind(
        bearings.LinearPairKeys, bearings.linear_bearing_faults, bearings.linear_bearing_scene
    ),
    "linear chain": FrictionSceneKind(
        bearings.LinearChainKeys, bearings.linear_bearing_faults, bearings.linear_bearing_scene
    ),
    "screw pair": FrictionSceneKind(screw_balls.ScrewPairKeys, screw_balls.ball_screw_faults, screw_balls.screw_pair_scene),
    "screw run": FrictionSceneKind(
        screw_balls.ScrewSimulationKeys, screw_balls.ball_screw_faults, screw_balls.screw_run_scene
    ),
}


def _schema_tag_of_kind(value: Any) -> str:
    """Return the kind of a scene for the choice of its JSON Schema; "whole" for a ball screw or bearing.

    ``value``: tables of a scene file, or its validated keys.
    """
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in KINDS else "whole"


def scene_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files of all kinds, with description, unit and range of every key."""
    by_tag = {"whole": SceneKeys} | {name: TABLE[name].key_class for name in KINDS} | {AXIS: ShaftSceneKeys}
    every: Any = Annotated[
        Union[tuple(Annotated[of, Tag(name)] for name, of in by_tag.items())],  # noqa: UP007
        Discriminator(_schema_tag_of_kind),
    ]
    schema: dict[str, Any] = schema_without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # any name is allowed if both constants are given
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema
