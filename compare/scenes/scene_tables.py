"""Build a scene from the tables of its file, with one-line errors for faulty keys and parts that cannot be built."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import SceneError, escape_unprintable
from rollbench.compare.scenes.body_checks import geometry_faults, hertz_constant_faults
from rollbench.compare.scenes.duty_cycle import AXIS, KINDS, WHOLE, Described, DutyCycle
from rollbench.compare.scenes.fault import (
    Fault,
    combined_scene_error,
    fault_texts,
    raise_faults,
    validate_beyond_faults,
    validate_or_raise,
)
from rollbench.compare.scenes.from_keys import load_case_faults, scene_from_keys, with_load_cases, with_preload_as_oversize
from rollbench.compare.scenes.key_checks import conflicting_key_faults
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.one_arc import with_single_arc_grooves
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import toml_text

if TYPE_CHECKING:
    from rollbench.compare.scenes.schema import AxisKeys

#: Tables that only scenes of the friction kinds have: if a file has one of them, it must name its kind.
FOREIGN = {"load", "angles", "grooves", "chain", "four_point", "double_row"}


def scene_from_tables(tables: dict[str, Any], file_name: str) -> Described:
    """Return the scene, of any kind, that the tables of a scene file describe.

    Parameters
    ----------
    tables
        Tables of the file.
    file_name
        Name of the file, for errors and for the scene's name.

    Raises
    ------
    SceneError
        For faulty keys, and for parts that cannot be built.
    """
    kind = tables.get("kind")
    if _describes_several_sets(tables):
        from rollbench.compare.scenes.axis_file import build_axis_scene

        return build_axis_scene(_validated_axis_keys(tables, file_name), tables, file_name, Path(file_name).stem)
    nut = tables.get("nut")
    bodies = isinstance(nut, dict) and "length" in nut  # a ball screw or bearing with a misspelt key
    if kind is None and FOREIGN & tables.keys() and not bodies:
        name = sorted(FOREIGN & tables.keys())[0]
        advice = f'write e.g. kind = "{KINDS[0]}"; the table [{name}] exists only in kinds that rollbench friction solves'
        raise SceneError(file_name, "kind", "nothing", ", ".join(map(toml_text, KINDS)), advice)
    if kind is None or kind in WHOLE:
        return single_set_scene_from_tables(tables, file_name)
    if kind not in KINDS:
        near = difflib.get_close_matches(str(kind), (*WHOLE, *KINDS), n=1, cutoff=0.5)
        advice = f"did you mean {toml_text(near[0])}?" if near else "leave the key out for a whole ball screw or bearing"
        raise SceneError(file_name, "kind", toml_text(kind), ", ".join(map(toml_text, (*WHOLE, *KINDS))), advice)
    from rollbench.compare.scenes.friction_kinds.table import scene_kind_by_name

    of = scene_kind_by_name(kind)
    keys = validate_or_raise(tables, of.keys, file_name)
    raise_faults(file_name, tables, list(of.faults(keys)))
    return of.record(keys, escape_unprintable(Path(file_name).stem))


def validated_keys(tables: dict[str, Any], file_name: str) -> SceneKeys | AxisKeys:
    """Return the validated keys of the scene file of a ball screw, bearing or shaft with several; SceneError for faults.

    ``tables``: tables of the file; ``file_name``: name of the file, for messages.
    """
    return (
        _validated_axis_keys(tables, file_name)
        if _describes_several_sets(tables)
        else validate_or_raise(tables, SceneKeys, file_name)
    )


def _validated_axis_keys(tables: dict[str, Any], file_name: str) -> AxisKeys:
    """Return the validated keys of the scene file of a shaft with nuts and bearings; SceneError for faulty keys."""
    from rollbench.compare.scenes.schema import AxisKeys

    return validate_or_raise(tables, AxisKeys, file_name)


def _describes_several_sets(tables: dict[str, Any]) -> bool:
    """Return whether the tables of a scene file describe a shaft with several nuts or bearings (``[[sets]]``)."""
    return "sets" in tables or tables.get("kind") == AXIS


def single_set_scene_from_tables(tables: dict[str, Any], file_name: str) -> Scene | DutyCycle:
    """Return the ball screw or bearing that the tables of a scene file describe, in one load case or several.

    ``tables``: the tables; ``file_name``: name of the file, for messages. SceneError for faults; it lists all that can be
    detected before the first ones are corrected.
    """
    keys, key_faults = validate_beyond_faults(tables, SceneKeys)
    texts = list(key_faults.texts)
    if keys is not None:
        faults = (*conflicting_key_faults(keys), *load_case_faults(keys))
        texts += fault_texts(tables, [fault for fault in faults if key_faults.are_in_file(fault.keys)])
    if keys is None or not key_faults.bodies_unchanged or len(texts) > len(key_faults.texts):
        raise combined_scene_error(file_name, texts)
    scene = scene_from_keys(keys, escape_unprintable(Path(file_name).stem))
    texts += fault_texts(tables, _geometry_or_contact_faults(scene))
    if texts:
        raise combined_scene_error(file_name, texts)
    if keys.preload is not None:
        scene = with_preload_as_oversize(scene, keys.preload)
        raise_faults(file_name, tables, _geometry_or_contact_faults(scene))
    return with_load_cases(with_single_arc_grooves(scene), keys.cases, tables, file_name, _geometry_or_contact_faults)


def _geometry_or_contact_faults(scene: Scene) -> list[Fault]:
    """Return the faults of a scene's dimensions; if there are none, those of contacts without Hertz constants."""
    return list(geometry_faults(scene)) or list(hertz_constant_faults(scene))
