"""What the package ships: scenes of all kinds by name, each read once."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rollbench.compare.case import file_of, shipped_files
from rollbench.compare.errors import InputError
from rollbench.compare.files import alike, question
from rollbench.compare.scenes.duty_cycle import AXIS, KINDS
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.compare.scenes.duty_cycle import Described
    from rollbench.compare.scenes.friction_kinds.common import KindScene

Of = TypeVar("Of", bound="KindScene")


@cache
def scene_names() -> tuple[str, ...]:
    """Names of the shipped scenes of all kinds, sorted."""
    return tuple(shipped_files("scenes"))


@cache
def heading(name: str) -> dict[str, Any]:
    """What the file of a shipped scene says above its first table: title, kind, role. Raises InputError for an unknown
    name."""
    return tomllib.loads(scene_text(name).partition("\n[")[0])


def kind(name: str) -> str:
    """Kind of a shipped scene, as ``scene_file.kind_of`` says it of the scene that is read."""
    ring = re.search(r'(?m)^lead = "0 mm"', scene_text(name))
    return str(heading(name).get("kind", "bearing" if ring else "ball screw"))


@cache
def whole_names() -> tuple[str, ...]:
    """Names of the shipped whole screws and bearings, sorted: neither axes nor kinds that only friction solves."""
    return tuple(n for n in scene_names() if heading(n).get("kind") not in (AXIS, *KINDS))


@cache
def with_role(role: str) -> tuple[str, ...]:
    """Names of the shipped scenes whose role begins with ``role``, sorted: "referenced", "unseen", "unseen, changed"."""
    return tuple(name for name in scene_names() if heading(name).get("role", "").startswith(role))


def scene_text(name: str) -> str:
    """Text of a scene that is shipped or of another package's case. Raises InputError for an unknown name."""
    path = file_of("scenes", name)
    if path is None:
        raise _unknown(name)
    return path.read_text(encoding="utf-8")


@cache
def shipped(name: str) -> Described:
    """The shipped scene of that name, of any kind. Raises InputError for an unknown name."""
    from rollbench.compare.scenes import scene_file

    return scene_file.read(scene_text(name), f"{name}.toml")


def case(name: str, of: type[Of]) -> Of:
    """The shipped scene of that name, of the kind with the record ``of``. Raises InputError where it is another."""
    described = shipped(name)
    if not isinstance(described, of):
        from rollbench.compare.scenes import scene_file

        raise InputError(name, "kind", f'"{scene_file.kind_of(described)}"', f'"{of.kind}"', "name a scene of that kind")
    return described


def any_scene(name_or_path: str) -> Described:
    """A shipped scene by name, or the scene of a file, of any kind.

    A name that is not shipped is a path if it ends in ``.toml``, holds a path separator, or names an existing
    file or folder. Raises InputError (SceneError for a faulty file).
    """
    if name_or_path in scene_names():
        return shipped(name_or_path)
    if looks_like_path(name_or_path):
        from rollbench.compare.scenes import scene_file

        return scene_file.read(scene_file.read_text(name_or_path), name_or_path)
    raise _unknown(name_or_path)


def scene(name_or_path: str) -> Scene:
    """A whole screw or bearing, shipped or of a file, as ``any_scene`` finds it.

    Raises InputError (SceneError for a faulty file, and for a scene of a kind that only friction solves).
    """
    from rollbench.compare.scenes import scene_file

    return scene_file.whole(any_scene(name_or_path), name_or_path)


def looks_like_path(text: str) -> bool:
    """Whether ``text`` is meant as a path rather than as the name of a shipped scene."""
    if text.endswith(".toml") or "/" in text or "\\" in text:
        return True
    try:
        return bool(text) and Path(text).exists()
    except (OSError, ValueError):
        return False


def _unknown(name: str) -> InputError:
    names = scene_names()
    near = question(alike(name, [*names, *(path.name for path in Path().glob("*.toml"))]))
    advice = near or "list the shipped scenes with: rollbench list"
    return InputError("scene", "name", f'"{name}"', f"one of {len(names)} shipped names, or a file", advice)
