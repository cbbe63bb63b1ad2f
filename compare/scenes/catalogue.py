"""Access to scenes by name or path; the scenes that are included in rollbench are read only once."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rollbench.compare.case import find_file_of_other_packages, shipped_toml_files
from rollbench.compare.errors import InputError
from rollbench.compare.files import did_you_mean, similar_names
from rollbench.compare.scenes.duty_cycle import WHOLE
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.compare.scenes.duty_cycle import Described, FrictionScene
    from rollbench.meshes.axis import Assembly

#: Class of a kind of scenes: a shaft, or one for which only friction is computed.
Of = TypeVar("Of", bound="FrictionScene | Assembly")


@cache
def scene_names() -> tuple[str, ...]:
    """Return the names of the scenes of all kinds that are included in rollbench, sorted."""
    return tuple(shipped_toml_files("scenes"))


@cache
def top_level_keys(name: str) -> dict[str, Any]:
    """Return the keys before the first table in the file of a scene included in rollbench, such as title and kind.

    ``name``: name of the scene; InputError for an unknown name.
    """
    return tomllib.loads(shipped_scene_text(name).partition("\n[")[0])


def kind_of_shipped_scene(name: str) -> str:
    """Return the kind of the scene ``name`` that is included in rollbench, such as "ball screw" or "bearing"."""
    ring = re.search(r'(?m)^lead = "0 mm"', shipped_scene_text(name))
    return str(top_level_keys(name).get("kind", "bearing" if ring else "ball screw"))


@cache
def names_of_single_nut_scenes() -> tuple[str, ...]:
    """Return the sorted names of the scenes included in rollbench that have only one nut or bearing row."""
    return tuple(n for n in scene_names() if top_level_keys(n).get("kind") in (None, *WHOLE))


@cache
def names_of_scenes_with_role(role: str) -> tuple[str, ...]:
    """Return the sorted names of the scenes included in rollbench that have a given role in the validation report.

    ``role``: beginning of the role: "referenced" (case study with a 3D reference), "unseen" (scene not used when the models
    were developed), "unseen, changed parts" or "unseen, catalogue size".
    """
    return tuple(name for name in scene_names() if top_level_keys(name).get("role", "").startswith(role))


def shipped_scene_text(name: str) -> str:
    """Return the text of the file of the scene ``name`` that is included in rollbench; InputError for an unknown name."""
    path = shipped_toml_files("scenes").get(name) or find_file_of_other_packages("scenes", name)
    if path is None:
        raise _unknown_name_error(name)
    return path.read_text(encoding="utf-8")


@cache
def shipped_scene(name: str) -> Described:
    """Return the scene ``name``, of any kind, that is included in rollbench; InputError for an unknown name."""
    from rollbench.compare.scenes import scene_file

    return scene_file.parse_scene(shipped_scene_text(name), f"{name}.toml")


def shipped_scene_of_kind(name: str, kind: type[Of]) -> Of:
    """Return the scene ``name`` that is included in rollbench, if it is of a given kind; InputError otherwise.

    ``kind``: class of the scenes of this kind.
    """
    described = shipped_scene(name)
    if not isinstance(described, kind):
        from rollbench.compare.scenes import scene_file

        found = f'"{scene_file.kind_of_scene(described)}"'
        raise InputError(name, "kind", found, f'"{kind.kind}"', "choose a scene of this kind")
    return described


def scene_of_any_kind(name_or_path: str) -> Described:
    """Return a scene of any kind: one that is included in rollbench, by its name, or one read from a file.

    A text that is not the name of an included scene is a path if it ends in ``.toml``, contains a path separator, or names
    an existing file or folder.

    Parameters
    ----------
    name_or_path
        Name of a scene that is included in rollbench, or path of a scene file.

    Returns
    -------
    Scene, Assembly, DutyCycle or FrictionScene
        The scene.

    Raises
    ------
    InputError
        If there is no such scene; its subclass SceneError if the file is faulty.
    """
    if name_or_path in shipped_toml_files("scenes"):
        return shipped_scene(name_or_path)
    text, file_name = scene_text_and_file_name(name_or_path)
    from rollbench.compare.scenes import scene_file

    return scene_file.parse_scene(text, file_name)


def scene_text_and_file_name(name_or_path: str) -> tuple[str, str]:
    """Return the text of the file of a scene, and the name of the file for error messages.

    ``name_or_path``: name or path as for `scene_of_any_kind`; InputError if there is no such scene.
    """
    if name_or_path in shipped_toml_files("scenes"):
        return shipped_scene_text(name_or_path), f"{name_or_path}.toml"
    if not looks_like_path(name_or_path):
        raise _unknown_name_error(name_or_path)
    from rollbench.compare.scenes import scene_file

    return scene_file.read_scene_text(name_or_path), name_or_path


def scene(name_or_path: str) -> Scene:
    """Return a scene with only one nut or bearing row: a scene included in rollbench, by its name, or one from a file.

    InputError if there is no such scene, the file is faulty, or the scene is of another kind.
    """
    from rollbench.compare.scenes import scene_file

    return scene_file.single_nut_scene_or_raise(scene_of_any_kind(name_or_path), name_or_path)


def looks_like_path(text: str) -> bool:
    """Return whether a text denotes the path of a file rather than the name of a scene."""
    if text.endswith(".toml") or "/" in text or "\\" in text:
        return True
    try:
        return bool(text) and Path(text).exists()
    except (OSError, ValueError):
        return False


def _unknown_name_error(name: str) -> InputError:
    """Return an InputError for an unknown scene name, with similar names as advice."""
    names = scene_names()
    near = did_you_mean(similar_names(name, [*names, *(path.name for path in Path().glob("*.toml"))]))
    advice = near or "list the scenes of rollbench with: rollbench list"
    return InputError("scene", "name", f'"{name}"', f"one of {len(names)} names of included scenes, or a file", advice)
