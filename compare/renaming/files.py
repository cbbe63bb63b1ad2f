"""Renames the files of a store one by one: each is proved to be what its old name says, and to be found by its new one."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from rollbench.comparison.errors import InputError
from rollbench.comparison.reference import store
from rollbench.comparison.reference.body_names import HALF_SPACE
from rollbench.comparison.reference.sealing import unsealed
from rollbench.comparison.renaming import old_keys
from rollbench.comparison.scenes.kinds import KindScene
from rollbench.comparison.wings.rolling import runs
from rollbench.meshes.condensed import geometry_digest, load_condensed
from rollbench.meshes.parts import Scene

#: Why a file keeps its name.
UNKNOWN = "the key of no scene that is known: give its scene file"
TAKEN = "another file has the name that it is to get"
DAMAGED = "damaged"
ALONE = "no run that it belongs to is here"
#: What reading a damaged file raises.
FAULTS = (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, InputError)


@dataclass
class Renamed:
    """Names of files that were renamed (their new ones), that had the new name, and that keep theirs, with the reason."""

    done: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)
    left: dict[str, str] = field(default_factory=dict)

    def note(self, path: Path, treat: Callable[..., tuple[Path, str]], *arguments: object) -> None:
        """Treat a file, which gives its path and why it was left, if it was."""
        try:
            now, reason = treat(path, *arguments)
        except FAULTS:
            now, reason = path, DAMAGED
        if reason:
            self.left[path.name] = reason
        else:
            (self.new if now == path else self.done).append(now.name)


def rename(folder: Path, scenes: Sequence[object]) -> Renamed:
    """Give the stored runs and condensed bodies of some scenes the names of today.

    Nothing is lost whenever this ends, and it may be repeated: bodies, which hold the digest of their geometry, are written
    anew before the old ones go, and before the runs by which they are found.
    """
    found = Renamed()
    whole = [scene for scene in scenes if isinstance(scene, Scene)]
    kinds = [scene for scene in scenes if isinstance(scene, KindScene)]
    for path in sorted(folder.glob("*-level*-*.json")):
        if path.name.startswith("rolling-"):
            found.note(path, _rolling, kinds)
        else:
            found.note(path, _run, whole, found)
    told = {*found.done, *found.new, *found.left}
    for path in sorted(folder.glob("*.npz")):
        if path.name not in told:
            found.note(path, _named_by_hand, whole)
    return found


def _run(path: Path, scenes: Sequence[Scene], found: Renamed) -> tuple[Path, str]:
    """A run of the static reference; its bodies first."""
    data = unsealed(path)
    level, variant, settings, sides, made_by = (data[x] for x in ("level", "variant", "settings", "sides", "versions"))
    if "sets" in settings:  # several sets on one shaft had no run then
        return path, ""
    bodies = f"bodies-{{}}-level{level}-{{}}.npz"
    for scene in scenes:
        stem = f"{scene.name}-level{level}-{f'{variant}-' if variant else ''}"
        new = path.with_name(f"{stem}{store.key_of(scene, variant, settings, sides, made_by)}.json")
        if path.name not in (new.name, f"{stem}{old_keys.run_key(scene, variant, settings, sides, made_by)}.json"):
            continue
        old_parts, parts = old_keys.geometry_digest(scene), geometry_digest(scene)
        old = path.with_name(bodies.format(old_parts, old_keys.bodies_key(scene, settings, sides, made_by)))
        own = path.with_name(bodies.format(parts, store.bodies_key(scene, settings, sides, made_by)))
        if old.exists():
            found.note(old, _bodies, own, old_parts, parts)
        elif own.exists() and own.name not in (*found.done, *found.new):
            found.note(own, _bodies, own, parts, parts)
        return _moved(path, new, partial(store.read, new, scene, level, variant))
    return path, UNKNOWN


def _rolling(path: Path, scenes: Sequence[KindScene]) -> tuple[Path, str]:
    """A run of rolling."""
    data = json.loads(path.read_text(encoding="utf-8"))
    level, bodies = data["level"], data.get("bodies", HALF_SPACE)
    for scene in scenes:
        new = runs.path_in(path.parent, scene, level, bodies)
        old = f"{new.stem[:-16]}{old_keys.rolling_key(scene, level, bodies)}.json"
        if path.name in (new.name, old):
            return _moved(path, new, partial(runs.load, scene, level, (path.parent,), bodies))
    return path, UNKNOWN


def _moved(path: Path, new: Path, read: Callable[[], object]) -> tuple[Path, str]:
    """A file under its new name, by which it must be found."""
    if path == new:
        return new, DAMAGED if read() is None else ""
    if new.exists() and new.read_bytes() != path.read_bytes():
        return path, TAKEN
    os.replace(path, new)
    if read() is None:
        os.replace(new, path)
        return path, DAMAGED
    return new, ""


def _bodies(path: Path, new: Path, old_parts: str, parts: str) -> tuple[Path, str]:
    """Condensed bodies under their new name, with the new digest of their geometry; all else as it was."""
    held = load_condensed(path)
    if held.geometry == parts and path == new:
        return new, ""
    if held.geometry != old_parts:
        return path, DAMAGED
    if path != new and new.exists():
        if load_condensed(new).geometry != parts:
            return path, TAKEN
    else:
        replace(held, geometry=parts).save(new)
    if load_condensed(new).geometry == parts and path != new:
        path.unlink()
    return new, ""


def _named_by_hand(path: Path, scenes: Sequence[Scene]) -> tuple[Path, str]:
    """Condensed bodies that were given a name, by the geometry that they hold."""
    if path.name.startswith("bodies-"):
        return path, ALONE
    held = load_condensed(path).geometry
    for scene in scenes:
        old, parts = old_keys.geometry_digest(scene), geometry_digest(scene)
        if held in (old, parts):
            return _bodies(path, path, old, parts)
    return path, UNKNOWN
