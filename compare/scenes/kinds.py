"""What the kinds of scenes share that only friction solves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from rollbench.compare.errors import escaped
from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.keys import MATERIAL, HeadKeys, MaterialKeys, key
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
        from rollbench.compare.scenes.kind_table import kind_named  # which has all kinds

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
