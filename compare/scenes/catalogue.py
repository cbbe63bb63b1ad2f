"""What the package ships: scenes by name, and the names of the printed tables."""

from __future__ import annotations

import difflib
from importlib import resources
from pathlib import Path

from compare.errors import InputError
from compare.printed import printed_data
from compare.scenes import scene_file
from meshes.parts import Scene


def scene_names() -> list[str]:
    """Names of the shipped scenes, sorted."""
    files = resources.files("compare").joinpath("scenes").iterdir()
    return sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml"))


def scene_text(name: str) -> str:
    """Text of a shipped scene. Raises InputError for an unknown name."""
    if name not in scene_names():
        raise _unknown(name)
    return resources.files("compare").joinpath("scenes", f"{name}.toml").read_text(encoding="utf-8")


def scene(name_or_path: str) -> Scene:
    """A shipped scene by name, or the scene of a file.

    What is no shipped name is a path if it ends in ``.toml``, holds a path separator, or names an existing
    file or folder. Raises InputError (SceneError for a faulty file).
    """
    if name_or_path in scene_names():
        return scene_file.loads(scene_text(name_or_path), f"{name_or_path}.toml")
    if looks_like_path(name_or_path):
        return scene_file.load(name_or_path)
    raise _unknown(name_or_path)


def looks_like_path(text: str) -> bool:
    """Whether ``text`` is meant as a path rather than as the name of a shipped scene."""
    if text.endswith(".toml") or "/" in text or "\\" in text:
        return True
    try:
        return bool(text) and Path(text).exists()
    except (OSError, ValueError):
        return False


def printed_tables() -> list[str]:
    """Names of the printed tables, sorted; ``compare.printed.printed_data.load_table`` reads one."""
    return printed_data.tables()


def _unknown(name: str) -> InputError:
    names = scene_names()
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.4)
    advice = f"did you mean {' or '.join(near)}?" if near else "list the shipped scenes with: rollbench list"
    return InputError("scene", "name", f'"{name}"', f"one of {len(names)} shipped names, or a file", advice)
