"""Kinds of scenes for which only friction is computed, which cases bring, and the JSON Schema of all kinds of scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Union

from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.case import brought_by_cases
from rollbench.compare.scenes import keys as scenes_keys
from rollbench.compare.scenes.duty_cycle import AXIS, FrictionScene
from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.keys import schema_without_null
from rollbench.compare.scenes.schema import SceneKeys, ShaftSceneKeys
from rollbench.meshes.record_keys import scene_key


class FrictionSceneKeys(scenes_keys.TitleKeys):
    """Keys in the file of every scene for which only friction is computed: kind, material, title."""

    kind: str = scene_key("what the scene describes")
    material: scenes_keys.MaterialKeys = scene_key("material of all parts", scenes_keys.MATERIAL)


@dataclass(frozen=True)
class FrictionSceneKind:
    """Kind of scene for which only friction is computed: how its file is read."""

    #: Class of the keys of the scene file.
    key_class: type[FrictionSceneKeys]
    #: Function that yields the faults of the keys.
    faults_of_keys: Callable[[Any], Iterator[Fault]]
    #: Function that returns the scene from its keys and its name.
    scene_from_keys: Callable[[Any, str], FrictionScene]
    #: Name of the included scene from which a new file of this kind takes its values.
    example: str


def friction_scene_kinds() -> dict[str, FrictionSceneKind]:
    """Return the kinds of scenes for which only friction is computed, by name, as the cases bring them."""
    return brought_by_cases("scene_kinds")


def _schema_tag_of_kind(value: Any) -> str:
    """Return the kind of a scene for the choice of its JSON Schema; "whole" for a ball screw or bearing.

    ``value``: tables of a scene file, or its validated keys.
    """
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in friction_scene_kinds() else "whole"


def scene_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files of all kinds, with description, unit and range of every key."""
    of_friction = {name: kind.key_class for name, kind in friction_scene_kinds().items()}
    by_tag = {"whole": SceneKeys} | of_friction | {AXIS: ShaftSceneKeys}
    every: Any = Annotated[
        Union[tuple(Annotated[of, Tag(name)] for name, of in by_tag.items())],  # noqa: UP007
        Discriminator(_schema_tag_of_kind),
    ]
    schema: dict[str, Any] = schema_without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # any name is allowed if both constants are given
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema
