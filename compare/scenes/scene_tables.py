"""Convert the tables of a scene file to the scene, with one-line errors for faulty keys and parts that cannot be built."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import SceneError, escape_unprintable
from rollbench.compare.scenes.body_checks import contact_faults, geometry_faults
from rollbench.compare.scenes.duty_cycle import AXIS, KINDS, WHOLE, Described, DutyCycle
from rollbench.compare.scenes.fault import (
    Fault,
    fault_texts,
    raise_faults,
    scene_error,
    validate_leniently,
    validate_or_raise,
)
from rollbench.compare.scenes.from_keys import case_faults, scene_of, with_load_cases, with_preload
from rollbench.compare.scenes.key_checks import choice_faults
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.one_arc import as_one_arc
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import toml_text

if TYPE_CHECKING:
    from rollbench.compare.scenes.schema import AxisKeys

#: Tables that only scenes of the friction kinds have: if a file has one of them, it must name its kind.
FOREIGN = {"load", "angles", "grooves", "chain", "four_point", "double_row"}


def read_tables(raw: dict[str, Any], origin: str) -> Described:
    """Return the scene, of any kind, that the tables of a file describe.

    Parameters
    ----------
    raw
        Tables of the file.
    origin
        Name of the file, for errors and for the scene's name.

    Raises
    ------
    SceneError
        For faulty keys, and for parts that cannot be built.
    """
    kind = raw.get("kind")
    if _is_axis(raw):
        from rollbench.compare.scenes.axis_file import read_axis

        return read_axis(_axis_keys(raw, origin), raw, origin, Path(origin).stem)
    nut = raw.get("nut")
    bodies = isinstance(nut, dict) and "length" in nut  # a ball screw or bearing with a misspelt key
    if kind is None and FOREIGN & raw.keys() and not bodies:
        name = sorted(FOREIGN & raw.keys())[0]
        advice = f'write e.g. kind = "{KINDS[0]}"; the table [{name}] exists only in kinds that rollbench friction solves'
        raise SceneError(origin, "kind", "nothing", ", ".join(map(toml_text, KINDS)), advice)
    if kind is None or kind in WHOLE:
        return single_set_scene(raw, origin)
    if kind not in KINDS:
        near = difflib.get_close_matches(str(kind), (*WHOLE, *KINDS), n=1, cutoff=0.5)
        advice = f"did you mean {toml_text(near[0])}?" if near else "leave the key out for a whole ball screw or bearing"
        raise SceneError(origin, "kind", toml_text(kind), ", ".join(map(toml_text, (*WHOLE, *KINDS))), advice)
    from rollbench.compare.scenes.friction_kinds.table import kind_named

    of = kind_named(kind)
    keys = validate_or_raise(raw, of.keys, origin)
    raise_faults(origin, raw, list(of.faults(keys)))
    return of.record(keys, escape_unprintable(Path(origin).stem))


def keys_of(raw: dict[str, Any], origin: str) -> SceneKeys | AxisKeys:
    """Return the validated keys of a ball screw, a bearing, or a shaft with several of them; SceneError for faulty keys.

    ``raw``: tables of the file; ``origin``: name of the file, for messages.
    """
    return _axis_keys(raw, origin) if _is_axis(raw) else validate_or_raise(raw, SceneKeys, origin)


def _axis_keys(raw: dict[str, Any], origin: str) -> AxisKeys:
    """Return the validated keys of a shaft with several nuts or bearings; SceneError for faulty keys."""
    from rollbench.compare.scenes.schema import AxisKeys

    return validate_or_raise(raw, AxisKeys, origin)


def _is_axis(raw: dict[str, Any]) -> bool:
    """Return whether the tables of a file describe a shaft with several nuts or bearings."""
    return "sets" in raw or raw.get("kind") == AXIS


def single_set_scene(raw: dict[str, Any], origin: str) -> Scene | DutyCycle:
    """Return the ball screw or bearing that the tables ``raw`` describe, in one load case or several.

    SceneError for a faulty file ``origin``; it lists all faults that can be detected before the first ones are corrected.
    """
    keys, key_faults = validate_leniently(raw, SceneKeys)
    texts = list(key_faults.texts)
    if keys is not None:
        faults = (*choice_faults(keys), *case_faults(keys))
        texts += fault_texts(raw, [fault for fault in faults if key_faults.stem_from_file(fault.keys)])
    if keys is None or not key_faults.bodies_unchanged or len(texts) > len(key_faults.texts):
        raise scene_error(origin, texts)
    scene = scene_of(keys, escape_unprintable(Path(origin).stem))
    texts += fault_texts(raw, _geometry_or_contact_faults(scene))
    if texts:
        raise scene_error(origin, texts)
    if keys.preload is not None:
        scene = with_preload(scene, keys.preload)
        raise_faults(origin, raw, _geometry_or_contact_faults(scene))
    return with_load_cases(as_one_arc(scene), keys.cases, raw, origin, _geometry_or_contact_faults)


def _geometry_or_contact_faults(scene: Scene) -> list[Fault]:
    """Return the faults of bodies that cannot be built; if there are none, those of contacts that cannot be solved."""
    return list(geometry_faults(scene)) or list(contact_faults(scene))
