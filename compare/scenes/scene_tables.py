"""Build a scene from the tables of its file, with one-line errors for faulty keys and parts that cannot be built."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

from rollbench.compare.errors import SceneError, escape_unprintable
from rollbench.compare.scenes import fault
from rollbench.compare.scenes.body_checks import geometry_faults, hertz_constant_faults, printed_hertz_constant_faults
from rollbench.compare.scenes.duty_cycle import AXIS, WHOLE, Described, DutyCycle
from rollbench.compare.scenes.from_keys import scene_from_keys, with_load_cases, with_preload_as_oversize
from rollbench.compare.scenes.key_checks import conflicting_key_faults
from rollbench.compare.scenes.kinds import friction_scene_kinds
from rollbench.compare.scenes.schema import SceneKeys, ShaftSceneKeys
from rollbench.meshes.one_arc import with_single_arc_grooves
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import toml_text

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
    if "sets" in tables or kind == AXIS:
        from rollbench.compare.scenes.axis_file import geometry_faults_of_nuts_and_bearings, shaft_scene_from_keys

        keys = fault.validate_or_raise(tables, ShaftSceneKeys, file_name)
        shaft = shaft_scene_from_keys(keys, tables, file_name, Path(file_name).stem)
        if not keys.cases:
            return shaft
        return with_load_cases(shaft, keys.cases, tables, file_name, geometry_faults_of_nuts_and_bearings)
    nut = tables.get("nut")
    bodies = isinstance(nut, dict) and "length" in nut  # a ball screw or bearing with a misspelt key
    if kind is None and FOREIGN & tables.keys() and not bodies:
        kinds = friction_scene_kinds()
        if meant := [key for key, value in tables.items() if isinstance(value, str) and value in kinds]:
            raise SceneError(file_name, meant[0], toml_text(tables[meant[0]]), "kind", "unknown key; did you mean kind?")
        name = sorted(FOREIGN & tables.keys())[0]
        first = toml_text(next(iter(kinds)))
        advice = f"write e.g. kind = {first}; the table [{name}] exists only in kinds that rollbench friction solves"
        raise SceneError(file_name, "kind", "nothing", ", ".join(map(toml_text, kinds)), advice)
    if kind is None or kind in WHOLE:
        return single_nut_scene_from_tables(tables, file_name)
    kinds = friction_scene_kinds()
    if kind not in kinds:
        near = difflib.get_close_matches(str(kind), (*WHOLE, *kinds), n=1, cutoff=0.5)
        advice = f"did you mean {toml_text(near[0])}?" if near else "leave the key out for a whole ball screw or bearing"
        raise SceneError(file_name, "kind", toml_text(kind), ", ".join(map(toml_text, (*WHOLE, *kinds))), advice)
    of = kinds[kind]
    read = fault.validate_or_raise(tables, of.key_class, file_name)
    fault.raise_scene_error_for_faults(file_name, tables, list(of.faults_of_keys(read)))
    return of.scene_from_keys(read, escape_unprintable(Path(file_name).stem))


def validated_keys(tables: dict[str, Any], file_name: str) -> SceneKeys | ShaftSceneKeys:
    """Return the validated keys of the scene file of a ball screw, bearing or shaft with several; SceneError for faults.

    ``tables``: tables of the file; ``file_name``: name of the file, for messages.
    """
    if "sets" in tables or tables.get("kind") == AXIS:
        return fault.validate_or_raise(tables, ShaftSceneKeys, file_name)
    return fault.validate_or_raise(tables, SceneKeys, file_name)


def single_nut_scene_from_tables(tables: dict[str, Any], file_name: str) -> Scene | DutyCycle:
    """Return the ball screw or bearing that the tables of a scene file describe, in one load case or several.

    ``tables``: the tables; ``file_name``: name of the file, for messages. Raises a SceneError that lists all faults that
    can be detected in one reading of the file.
    """
    keys, messages, replaced = fault.validate_and_collect_faults(tables, SceneKeys)
    faults = [] if keys is None else list(conflicting_key_faults(keys, tables))
    scene = None
    if keys is not None and not faults and replaced <= fault.INDEPENDENT_TABLES:
        scene = scene_from_keys(keys, escape_unprintable(Path(file_name).stem))
        faults = _geometry_or_contact_faults(scene)
    if keys is None or scene is None or faults or messages:
        # a fault that an example may have caused, which replaced a value, is not told
        told = [one for one in faults if not any(key.replace("[", ".").split(".")[0] in replaced for key in one.keys)]
        raise fault.scene_error_of_all_faults(file_name, [*messages, *fault.messages_of_faults(tables, told)])
    if keys.preload is not None:
        scene = with_preload_as_oversize(scene, keys.preload)
        fault.raise_scene_error_for_faults(file_name, tables, _geometry_or_contact_faults(scene))
    if scene.track.lead == 0.0:
        scene = with_single_arc_grooves(scene)
    if not keys.cases:
        return scene
    return with_load_cases(scene, keys.cases, tables, file_name, _geometry_or_contact_faults)


def _geometry_or_contact_faults(scene: Scene) -> list[fault.Fault]:
    """Return the faults of a scene's dimensions; if there are none, a fault for each contact without Hertz constants."""
    faults = list(geometry_faults(scene))
    if faults:
        return faults
    if scene.ingredients.hertz == "as printed":
        return list(printed_hertz_constant_faults(scene))
    flanks = scene.errors.SL, scene.errors.SR, scene.errors.NL, scene.errors.NR
    uneven = scene.errors.balls.sigma > 0.0 or any(flank.profile or flank.profile_sigma for flank in flanks)
    large = scene.balls.radius + scene.errors.balls.oversize >= scene.track.pitch_radius or scene.errors.balls.listed
    return list(hertz_constant_faults(scene)) if uneven or large else []  # a smaller ball is more curved than its grooves
