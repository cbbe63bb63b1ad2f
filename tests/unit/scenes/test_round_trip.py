"""Scenes written as files in SI units and read again."""

import json
import math
import re
from dataclasses import fields, is_dataclass

import pytest

from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.template import template
from rollbench.meshes.parts import SIDES, FourierTerm, Scene

NAMES = catalogue.whole_names()


#: Units of fields that are no lengths in metres, and fields without unit.
UNITS = dict.fromkeys(("contact_angle", "phase", "azimuth", "azimuths", "angle", "rx", "ry", "rz"), "rad")
UNITS |= {"force": "N", "moment": "N m", "speed": "rad/s", "duration": "s", "youngs_modulus": "Pa"}
PLAIN = {"poissons_ratio", "harmonic", "coefficient", "nut", "balls", "turns", "filling", "goal"}


def fields_of(part, *left_out: str) -> dict:
    return {x.name: getattr(part, x.name) for x in fields(part) if x.name not in left_out}


def written(name: str, value) -> str:
    """A value as TOML: floats by ``repr``, so nothing is lost."""
    if isinstance(value, tuple):
        return f"[{', '.join(written(name, x) for x in value)}]"
    if is_dataclass(value):
        value = fields_of(value)
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{k} = {written(k, x)}' for k, x in value.items())} }}"
    has_unit = isinstance(value, float) and name not in PLAIN
    return f'"{value!r} {UNITS.get(name, "m")}"' if has_unit else json.dumps(value)


def to_toml(scene: Scene) -> str:
    """The scene in SI units, every key written, azimuths listed."""
    errors, flange, at = scene.errors, scene.nut.flange, scene.solid.nut_held
    held = {} if at is None else {"at": at}
    if at == "flange face":
        held |= dict(zip(("inner_diameter", "outer_diameter"), (2.0 * r for r in flange.seat), strict=True))
        held |= {"centring": "bonded" if flange.bonded else "free", "bolts": flange.bolts}
    tables = [("", {name: getattr(scene, name) for name in ("title", "source", "assumed", "members")})]
    tables += [(name, fields_of(getattr(scene, name), "flange", "arcs")) for name in ("track", "screw", "nut", "balls")]
    tables += [("nut.flange", {} if flange is None else fields_of(flange, "seat", "bonded", "bolts")), ("nut.held", held)]
    listed = {str(k): v for k, v in errors.balls.listed}
    tables += [("errors", {"seed": errors.seed}), ("errors.balls", fields_of(errors.balls) | {"listed": listed})]
    tables += [(f"errors.{name}", fields_of(errors.side(name))) for name in SIDES]
    tables += [("[supports]", {"at": support.at, "displace": dict(support.fixed)}) for support in scene.supports]
    tables += [("[loads]", fields_of(load)) for load in scene.loads]
    if scene.friction is not None:
        tables += [("friction", {"coefficient": scene.friction.screw} | fields_of(scene.friction, "screw"))]
    further = {name: getattr(scene, name) for name in ("ingredients", "solid", "motion", "circulation", "time")}
    tables += [(name, fields_of(part, "nut_held")) for name, part in further.items() if part is not None]
    lines = []
    for head, table in tables:
        lines += [f"[{head}]"] if head and table else []
        lines += [f"{key} = {written(key, value)}" for key, value in table.items() if value is not None]
    return "\n".join(lines)


@pytest.mark.parametrize("name", NAMES)
def test_round_trip_in_si_units(name):
    scene = catalogue.scene(name)
    assert scene_file.loads(to_toml(scene), f"{name}.toml") == scene


def test_round_trip_of_every_key():
    full = re.sub(r"(?m)^# (?=\[|\w+ = )", "", template())
    full = full.replace('hand = "right"', 'hand = "left"').replace('bore = "0 mm"', 'bore = "5 mm"')
    full = full.replace('azimuth = "0 deg"', 'azimuth = "30 deg"').replace('"0 N m", "0 N m"]', '"1 N m", "2 N mm"]')
    full = full.replace('sin = "5 um"', 'sin = "5 um", cos = "1 um", sigma = "2 um"').replace('["0.1 um', '["0.2 um')
    full = full.replace('hertz = "nominal"', 'hertz = "as printed"').replace('section = "groove"', 'section = "full"')
    cycle = scene_file.read(full, "full.toml")
    scene = cycle.parts  # without its load case
    assert (cycle.cases[0].scene.errors.balls.oversize, scene.errors.NR.profile) == (3e-6, (2e-6, -0.25e-6))
    assert scene.supports[1].fixed == (("ux", 3e-4), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0))
    assert (scene.track.hand, scene.screw.bore, scene.nut.azimuth) == ("left", 5e-3, math.pi / 6)
    assert scene.loads[0].moment == (0.0, 1.0, 2e-3)
    assert scene.errors.SL.profile_sigma == (2e-7, 0.0)
    assert scene.errors.SL.roundness[0] == FourierTerm(2.0, 5e-6, 1e-6, 2e-6)
    assert (scene.ingredients.hertz, scene.ingredients.section) == ("as printed", "full")
    assert scene_file.loads(to_toml(scene), "full.toml") == scene
