"""Reading of scene files: a TOML file describes one scene, with one load case or several; faults become one-line errors."""

from __future__ import annotations

import hashlib
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any, cast

from rollbench.compare.case import shipped_toml_files
from rollbench.compare.errors import SceneError
from rollbench.compare.files import read_text_file
from rollbench.compare.quantities import count_with_noun
from rollbench.compare.scenes.duty_cycle import WHOLE, Described, DutyCycle, FrictionScene
from rollbench.meshes.axis import Assembly
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import number_advice

#: Largest number of parts of a dotted key, because time and memory of the TOML reader grow with its square.
MAX_PARTS = 32
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DOTTED = re.compile(rf"""(?<![\w\-."'])(?:{_PART}[ \t]*+\.[ \t]*+){{{MAX_PARTS}}}""")
#: Largest size of a scene file [bytes], and longest line [characters] (100 000 azimuths on one line have 2 MB).
MAX_BYTES, MAX_LINE = 4_000_000, 2_500_000


def scene_from_text(text: str, file_name: str) -> Scene:
    """Return the ball screw or bearing that the text of a scene file describes.

    Parameters
    ----------
    text
        Text of a scene file.
    file_name
        Name of the file, for error messages.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    SceneError
        If the text has faults, or describes a scene of another kind.
    """
    return single_nut_scene_or_raise(parse_scene(text, file_name), file_name)


def scene_or_shaft_or_raise(scene: Described, file_name: str) -> Scene | Assembly:
    """Return ``scene`` if it is a ball screw, a bearing, or a shaft with several of them; SceneError for other kinds.

    ``file_name``: name of the file, for messages.
    """
    return scene if isinstance(scene, Assembly) else single_nut_scene_or_raise(scene, file_name)


def scenes_to_solve(scene: Described, file_name: str) -> list[Scene] | list[Assembly]:
    """Return the scenes to solve: one for each load case, in order; or only ``scene`` if it has no load cases.

    ``file_name``: name of the file, for messages. SceneError for kinds of scenes of which only friction is computed.
    """
    if isinstance(scene, DutyCycle):
        return [case.scene for case in scene.cases]  # type: ignore[return-value]
    single = scene_or_shaft_or_raise(scene, file_name)
    return [single]  # type: ignore[return-value]


def single_nut_scene_or_raise(scene: Described, file_name: str) -> Scene:
    """Return ``scene`` if it is a screw with one nut or a bearing with one row of balls; SceneError for other kinds.

    ``file_name``: name of the file, for messages.
    """
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, DutyCycle):
        advice = "delete the cases, or use solve, compare, check, friction, sweep or report, which accept them"
        raise SceneError(file_name, "cases", count_with_noun(len(scene.cases), "case"), "a scene without [[cases]]", advice)
    if isinstance(scene, Assembly):
        allowed = "one set (a nut or a bearing with its balls), whose nut or outer ring is fixed"
        advice = "describe a single nut or bearing, or use solve, view, compare, check, friction or sweep"
        raise SceneError(file_name, "sets", count_with_noun(len(scene.sets), "set"), allowed, advice)
    raise friction_only_error(scene, file_name)


def friction_only_error(scene: FrictionScene, file_name: str) -> SceneError:
    """Return the error that only friction is computed for this kind of scene; ``file_name``: its file, for messages."""
    advice = f"use the command that solves this kind: rollbench friction {shlex.quote(file_name)}"
    return SceneError(file_name, "kind", f'"{scene.kind}"', ", ".join(f'"{kind}"' for kind in WHOLE), advice)


@cached_on_disk(cast("type[Described]", object))
def parse_scene(text: str, file_name: str) -> Described:
    """Return the scene, of any kind, that the text of a scene file describes, from the cache on disk if it was read before.

    Parameters
    ----------
    text
        Text of a scene file.
    file_name
        Name of the file, for error messages.

    Returns
    -------
    Scene, Assembly, DutyCycle or FrictionScene
        The scene.

    Raises
    ------
    SceneError
        If the text has faults.
    """
    from rollbench.compare.scenes.scene_tables import scene_from_tables  # heavy import, not needed for a cached text

    return scene_from_tables(parse_toml(text, file_name), file_name)


def kind_of_scene(scene: Described) -> str:
    """Return the kind of a scene as its file names it, such as "ball screw", "bearing" or "axis"."""
    scene = scene.parts if isinstance(scene, DutyCycle) else scene
    if not isinstance(scene, Scene):
        return scene.kind
    return "bearing" if scene.track.lead == 0.0 else "ball screw"


def read_scene_text(path: str | Path) -> str:
    """Return the text of a scene file; SceneError if the file cannot be read, is not text, or is too large."""
    others, advice = shipped_toml_files("scenes"), "check the path, or list the scenes of rollbench with: rollbench list"
    text = read_text_file(path, "TOML file", MAX_BYTES, others, advice, SceneError)
    longest = max(map(len, text.splitlines()), default=0)
    if longest > MAX_LINE:
        allowed = f"lines of up to {MAX_LINE} characters"
        advice = "check whether this is a scene file"
        raise SceneError(str(path), "file", f"a line of {longest} characters", allowed, advice)
    return text


def hash_of_scene_text(text: str) -> str:
    """Return a hash of a scene file's text without the line of the key ``role``: 16 hexadecimal digits of SHA-256."""
    described = re.sub(r"(?m)^role = .*\n", "", text)
    return hashlib.sha256(described.encode("utf-8", "surrogatepass")).hexdigest()[:16]


def parse_toml(text: str, file_name: str) -> dict[str, Any]:
    """Return the tables and keys of a TOML text; SceneError if it is not valid (``file_name``: name of the file)."""
    if long := _DOTTED.search(text):
        row = text.count("\n", 0, long.start()) + 1
        advice = "use the keys that rollbench schema lists, which have up to four names"
        allowed = f"a key of up to {MAX_PARTS} names joined by dots"
        raise SceneError(file_name, f"line {row}", f"{long[0][:40]}...", allowed, advice)
    try:
        return tomllib.loads(text)
    except RecursionError:
        place, reason = "file", "brackets are nested too deeply"
    except ValueError as error:  # TOMLDecodeError, and integers of thousands of digits
        match = re.search(r"\s*\(at (.*)\)$", str(error))
        place = match[1] if match else "file"
        reason = str(error)[: match.start()] if match else str(error)
    numbered = re.match(r"line (\d+)", place)
    line = text.splitlines()[int(numbered[1]) - 1].strip() if numbered else "text that is not TOML"
    advice = f'correct the line ({reason[:1].lower()}{reason[1:]}); put texts in double quotes, e.g. length = "800 mm"'
    advice = number_advice(line.partition("=")[2], advice)
    raise SceneError(file_name, place, line or "an empty line", "TOML: [table] and key = value lines", advice)
