"""Kinds of scenes that wings add: what they share, each one's record, and the one JSON Schema of a scene file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Union

from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.errors import escaped
from rollbench.compare.registration import kinds, load
from rollbench.compare.scenes.axis_schema import AxisKeys
from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.keys import MATERIAL, HeadKeys, MaterialKeys, key, without_null
from rollbench.compare.scenes.names import AXIS
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.scene_text import to_toml


class KindKeys(HeadKeys):
    """What every kind has."""

    kind: str = key("what the scene describes")
    material: MaterialKeys = key("material of all parts", example=MATERIAL)


@dataclass(frozen=True)
class KindScene:
    """What the scene of every kind has. ``assumed``: statements about what the source leaves open."""

    kind: ClassVar[str]
    name: str
    title: str
    source: str
    assumed: tuple[str, ...]

    def to_toml(self) -> str:
        """Text of a scene file that is read as this scene."""
        return to_toml(kind_named(self.kind).tables(self))


Head = tuple[str, str, str, tuple[str, ...]]


def head_of(keys: KindKeys, name: str) -> Head:
    """The first fields of a record: name, title, source, assumptions."""
    return name, escaped(keys.title), escaped(keys.source), tuple(map(escaped, keys.assumed))


@dataclass(frozen=True)
class Kind:
    """A kind of scene: its keys, what they may not describe, the record of faultless ones, tables of a record."""

    keys: type[KindKeys]
    faults: Callable[[Any], Iterator[Fault]]
    record: Callable[[Any, str], KindScene]
    tables: Callable[[Any], dict[str, Any]]


def kind_named(name: str) -> Kind:
    """The kind of that name, one of `registration.kinds`."""
    kind: Kind = load(kinds()[name])[name]
    return kind


def _tag(value: Any) -> str:
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in kinds() else "whole"


def json_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a scene file of any kind, with description, unit, range and example of every key."""
    tables = {"whole": SceneKeys} | {name: kind_named(name).keys for name in kinds()} | {AXIS: AxisKeys}
    every: Any = Annotated[Union[tuple(Annotated[of, Tag(name)] for name, of in tables.items())], Discriminator(_tag)]  # noqa: UP007
    schema: dict[str, Any] = without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # beside both values `with_material` takes any
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema
