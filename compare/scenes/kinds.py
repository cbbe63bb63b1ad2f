"""Kinds of scenes for which only friction is computed, which cases bring, and the JSON Schema of all kinds of scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import TypeAdapter

from rollbench.compare.case import brought_by_cases
from rollbench.compare.scenes import keys as scenes_keys
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.keys import reader_of_tables, schema_without_null
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


def scene_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files of all kinds, with description, unit and range of every key."""
    kinds = friction_scene_kinds().values()
    classes: list[type] = [SceneKeys, *(kind.key_class for kind in kinds), ShaftSceneKeys]
    schemas, definitions = TypeAdapter.json_schemas([(of, "validation", reader_of_tables(of)) for of in classes])
    schema: dict[str, Any] = schema_without_null(definitions | {"oneOf": [*schemas.values()]})
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # any name is allowed if both constants are given
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema
