"""Keys of stored files as version 0.4.4 and those before made them; frozen: they name what is there."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass, replace
from typing import Any

import numpy as np

from rollbench.comparison.reference.store import BODIES, SCHEMA, versions
from rollbench.comparison.reference.tasks import plain
from rollbench.comparison.scenes.kinds import KindScene
from rollbench.comparison.wings.rolling.runs import BODIES as ROLLING_BODIES
from rollbench.comparison.wings.rolling.runs import LEVELS, MESHED, QUADRATURES, SOURCE_SIZE
from rollbench.comparison.wings.rolling.runs import SCHEMA as ROLLING_SCHEMA
from rollbench.hifi.rolling.balls import NEARLY_RIGID
from rollbench.meshes.canonical import canonical
from rollbench.meshes.frozen_defaults import FROZEN
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

#: Fields of every record that counted, in their order.
FIELDS = {
    "BallErrors": "oversize listed sigma distribution",
    "BallRow": "place contacts",
    "Balls": "radius material azimuths",
    "Bearing": "ball_radius groove_radius pitch_radius contact_angle young poisson mu speed clearance",
    "BearingBallScene": "name title source assumed bearing force displacement hertz law creep sharpness map_step",
    "BearingCase": "groove count rows force clearance tilt phase arm",
    "BearingPairScene": "name title source assumed four_point double_row angle",
    "Dimensions": "land hole shaft shaft_radius nut_held screw_held held_radii groove_ends assumed",
    "Errors": "balls SL SR NL NR seed lead_offset",
    "FourierTerm": "harmonic sin cos sigma",
    "Ingredients": "hertz screw partition element_length section arm",
    "LinearBearing": "ball_radius conformity contact_angle speed mu mu_balls young poisson",
    "LinearChainScene": "name title source assumed bearing angles vertical side distribution gap",
    "LinearPairScene": "name title source assumed bearing angles vertical side distribution gap deviation",
    "Load": "at force moment",
    "Material": "youngs_modulus poissons_ratio",
    "Nut": "position length outer_diameter groove_radius material azimuth",
    "Pair": "groove theta pattern oversize free force coupling",
    "Scene": "name title track screw nut balls errors supports loads ingredients solid source assumed members",
    "Screw": "length outer_diameter groove_radius material bore",
    "ScrewGroove": "ball_radius groove_radius pitch_radius lead contact_angle young poisson mu nut_speed screw_speed"
    " mu_balls hertz",
    "ScrewPairScene": "name title source assumed pair",
    "SideErrors": "profile profile_sigma pitch pitch_along roundness",
    "Sizes": "cells growth margin degree bar opening patches",
    "Solid": "nut_inner_diameter hole_diameter shaft shaft_diameter nut_held screw_held nut nut_groove",
    "Support": "at fixed",
    "Track": "pitch_radius lead contact_angle hand starts phase",
}
#: Fields that keys did not show: those of a scene that say nothing about static loads, and a lead offset of zero.
HIDDEN = ("friction", "motion", "role", "circulation", "time", "gate")


def run_key(
    scene: Scene, variant: str, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None = None
) -> str:
    """Key of a run of the static reference; programs: versions that it names, or else those installed."""
    bare = replace(scene, name="", title="", source="", assumed=(), members=1)
    return _digest(SCHEMA, bare, _solid(scene), variant, _mesh(settings), tuple(sides), 0, _programs(programs))


def bodies_key(
    scene: Scene, settings: Mapping[str, Any], sides: Sequence[int], programs: Mapping[str, str] | None = None
) -> str:
    """Key of condensed bodies; programs: as for `run_key`."""
    made_by = _programs(programs)
    return _digest(SCHEMA, BODIES, geometry_digest(scene), _solid(scene), _mesh(settings), tuple(sides), made_by)


def _programs(named: Mapping[str, str] | None) -> list[tuple[str, str]]:
    return sorted((versions() if named is None else {name: named.get(name, "") for name in versions()}).items())


def geometry_digest(scene: Scene) -> str:
    """Digest of the parts, as files of condensed bodies held it."""
    return _digest((scene.track, scene.screw, scene.nut, scene.balls, scene.solid, scene.ingredients.screw))


def rolling_key(scene: KindScene, level: int, bodies: str) -> str:
    """Key of a run of rolling."""
    told = [ROLLING_SCHEMA, _tree(scene), level, LEVELS.get(level), SOURCE_SIZE.get(scene.kind), QUADRATURES, NEARLY_RIGID]
    sizes = ROLLING_BODIES[bodies]
    if sizes is not None:
        told += [_tree(sizes), MESHED]
    return hashlib.sha256(json.dumps(told, default=repr).encode()).hexdigest()[:16]


def _solid(scene: Scene) -> object:
    return replace(dimensions(scene), assumed=())


def _mesh(settings: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return sorted(plain(settings).items())


def _digest(*parts: object) -> str:
    return hashlib.sha256("|".join(map(_text, parts)).encode()).hexdigest()[:16]


def _fields(record: Any) -> dict[str, object]:
    """Fields of a record that counted, and later ones that are not as usual: with these no old key fits."""
    name = type(record).__name__
    old, usual = FIELDS[name].split(), FROZEN.get(name, {})
    later = [f for f in vars(record) if f not in (*old, *HIDDEN)]
    return {f: getattr(record, f) for f in (*old, *(f for f in later if canonical(getattr(record, f)) != usual.get(f)))}


def _text(value: object) -> str:
    if is_dataclass(value):
        shown = {f: v for f, v in _fields(value).items() if f != "lead_offset" or v}
        return f"{type(value).__name__}({', '.join(f'{f}={_text(v)}' for f, v in shown.items())})"
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))}{',' * (len(value) == 1)})"
    return repr(value)


def _tree(value: Any) -> Any:
    if is_dataclass(value):
        return {f: _tree(v) for f, v in _fields(value).items()}
    if isinstance(value, tuple | list):
        return [_tree(v) for v in value]
    return value.tolist() if isinstance(value, np.ndarray) else value
