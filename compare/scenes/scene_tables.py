"""From the tables of a scene file to the scene, with one-line errors for what cannot be built."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import SceneError, escaped
from rollbench.compare.scenes.body_checks import contact_faults, geometry_faults
from rollbench.compare.scenes.duty_cycle import AXIS, KINDS, WHOLE, Described, DutyCycle
from rollbench.compare.scenes.fault import Fault, refusal, refuse, sound, spoken, validated
from rollbench.compare.scenes.from_keys import case_faults, in_cases, preloaded, scene_of
from rollbench.compare.scenes.key_checks import choice_faults
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.one_arc import as_one_arc
from rollbench.meshes.parts import Scene
from rollbench.meshes.units import show

if TYPE_CHECKING:
    from rollbench.compare.scenes.schema import AxisKeys

#: Tables that no ball screw or bearing has: with them, a missing kind is reported.
FOREIGN = {"load", "angles", "grooves", "chain", "four_point", "double_row"}


def read_tables(raw: dict[str, Any], origin: str) -> Described:
    """Return the scene of any kind from the tables of a file; SceneError for faults."""
    kind = raw.get("kind")
    if _is_axis(raw):
        from rollbench.compare.scenes.axis_file import read_axis

        return read_axis(_axis_keys(raw, origin), raw, origin, Path(origin).stem)
    nut = raw.get("nut")
    bodies = isinstance(nut, dict) and "length" in nut  # a whole scene with a key misspelt
    if kind is None and FOREIGN & raw.keys() and not bodies:
        name = sorted(FOREIGN & raw.keys())[0]
        advice = f"[{name}] belongs to a kind that only friction solves: name it, as the files of rollbench new do"
        raise SceneError(origin, "kind", "nothing", ", ".join(map(show, KINDS)), advice)
    if kind is None or kind in WHOLE:
        return of_tables(raw, origin)
    if kind not in KINDS:
        near = difflib.get_close_matches(str(kind), (*WHOLE, *KINDS), n=1, cutoff=0.5)
        advice = f"did you mean {show(near[0])}?" if near else "leave it out for a whole screw or bearing"
        raise SceneError(origin, "kind", show(kind), ", ".join(map(show, (*WHOLE, *KINDS))), advice)
    from rollbench.compare.scenes.friction_kinds.table import kind_named

    of = kind_named(kind)
    keys = sound(raw, of.keys, origin)
    refuse(origin, raw, list(of.faults(keys)))
    return of.record(keys, escaped(Path(origin).stem))


def keys_of(raw: dict[str, Any], origin: str) -> SceneKeys | AxisKeys:
    """Return the validated keys of a ball screw, a bearing, or several sets on one shaft; SceneError for faults."""
    return _axis_keys(raw, origin) if _is_axis(raw) else sound(raw, SceneKeys, origin)


def _axis_keys(raw: dict[str, Any], origin: str) -> AxisKeys:
    from rollbench.compare.scenes.schema import AxisKeys

    return sound(raw, AxisKeys, origin)


def _is_axis(raw: dict[str, Any]) -> bool:
    return "sets" in raw or raw.get("kind") == AXIS


def of_tables(raw: dict[str, Any], origin: str) -> Scene | DutyCycle:
    """Return the ball screw or bearing of the tables ``raw``, in one load case or several.

    SceneError, for the file ``origin``, with all faults that can be found before the first are corrected.
    """
    keys, broken = validated(raw, SceneKeys)
    said = list(broken.said)
    if keys is not None:
        faults = (*choice_faults(keys), *case_faults(keys))
        said += spoken(raw, [fault for fault in faults if broken.leaves(fault.keys)])
    if keys is None or not broken.bodies or len(said) > len(broken.said):
        raise refusal(origin, said)
    scene = scene_of(keys, escaped(Path(origin).stem))
    said += spoken(raw, _body_faults(scene))
    if said:
        raise refusal(origin, said)
    if keys.preload is not None:
        scene = preloaded(scene, keys.preload)
        refuse(origin, raw, _body_faults(scene))
    return in_cases(as_one_arc(scene), keys.cases, raw, origin, _body_faults)


def _body_faults(scene: Scene) -> list[Fault]:
    """Return faults of bodies that cannot be built; without any, of contacts that cannot be solved."""
    return list(geometry_faults(scene)) or list(contact_faults(scene))
