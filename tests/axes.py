"""Small shafts with several rolling sets, shared by the tests."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from tests.helpers import ALL_BUT_AXIAL, STEEL, small_screw

from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet, diagonal_stiffness
from rollbench.meshes.parts import Balls, Load, Nut, Scene, Screw, Support, Track

#: A shaft on a pair of bearings and a sliding one, and load cases for it.
ON_A_SHAFT = Path(__file__).parent / "scenes" / "bearings-on-a-shaft.toml"
CASES = """
[[cases]]
name = "case-1"
time = "20 s"
speed = "500 rpm"
[[cases.loads]]
at = "150 mm"
force = ["2 kN", "0 N", "0 N"]
[[cases]]
name = "case-2"
time = "80 s"
speed = "900 rpm"
[[cases.loads]]
at = "150 mm"
force = ["100 N", "-1 kN", "-500 N"]
moment = ["3 N m", "0 N m", "0 N m"]
"""
SHAFT = Screw(0.3, 32e-3, 3.254e-3, STEEL)
#: An angular-contact bearing of 14 balls at 60 degrees.
PITCH, ANGLE, BALL, GROOVE = 18e-3, np.radians(60.0), 3.5e-3, 0.52 * 7e-3
TURNING = Support(0.0, (("rz", 0.0),))
ROLLERS = RollerRow(12, 8e-3, 12e-3, np.radians(30.0), np.radians(4.0), 5e-3, STEEL, slices=7)


def bare(scene, screw=SHAFT):
    """The parts of a scene, without what holds and loads them, on a shaft."""
    grooved = replace(screw, groove_radius=scene.screw.groove_radius)
    return replace(scene, screw=grooved, supports=(), loads=())


def one_set(scene):
    """A scene of one set as an assembly."""
    nut = RollingSet("nut", "ball nut", replace(scene, supports=(), loads=()), scene.nut.position)
    same = {name: getattr(scene, name) for name in ("supports", "loads", "ingredients")}
    return Assembly("one", "one", scene.screw, (nut,), **same)


def nut(name, z, *, count=12, turns=1.5, lead=10e-3, hand="right", **options):
    """A ball nut at z."""
    parts = bare(small_screw(count=count, turns=turns, lead=lead, hand=hand))
    parts = replace(parts, nut=replace(parts.nut, position=z, length=40e-3))
    return RollingSet(name, "ball nut", parts, z, **options)


def bearing(name, z, thrust, *, count=14, screw=SHAFT, **options):
    """An angular-contact bearing at z that carries thrust one way."""
    azimuths = tuple(2.0 * np.pi * (np.arange(count) - (count - 1) / 2.0) / count)
    inner, outer = replace(screw, groove_radius=GROOVE, outer_diameter=33e-3), Nut(z, 15e-3, 62e-3, 0.53 * 7e-3, STEEL)
    parts = Scene(name, name, Track(PITCH, 0.0, ANGLE), inner, outer, Balls(BALL, STEEL, azimuths))
    return RollingSet(name, "bearing", parts, z, thrust=thrust, **options)


def assembly(*sets, **options):
    """A shaft with these sets."""
    return Assembly("axis", "axis", SHAFT, sets, **options)


def double_nut(offset=3e-6, force=800.0, **options):
    """Two nuts in one housing on springs, the shaft held but for its axis."""
    places = (("nut 1", 0.13, -offset), ("nut 2", 0.17, offset))
    sets = (nut(name, z, housing="h", offset=by, **options) for name, z, by in places)
    springs, support = diagonal_stiffness((4e8, 5e8, 6e8, 2e5, 3e5, 4e5)), Support(0.0, ALL_BUT_AXIAL)
    loads = (Load(0.0, (0.0, 0.0, force)),)
    return assembly(*sets, housings=(Housing("h", 0.14, (), springs),), supports=(support,), loads=loads)


def fixed_axis(force=(0.0, 0.0, 600.0), preload=4e-6):
    """Shaft between two preloaded pairs of bearings, with a nut in a carriage that slides along it."""
    places = (("left +", 0.02), ("left -", 0.035), ("right +", 0.265), ("right -", 0.28))
    pairs = (bearing(name, z, f"{name[-1]}z", offset=preload if name[-1] == "-" else -preload) for name, z in places)
    carriage = Housing("carriage", 0.12, ALL_BUT_AXIAL, None, force)
    return assembly(*pairs, nut("nut", 0.12, housing="carriage"), housings=(carriage,), supports=(TURNING,))


def solved(parts, **options):
    """Result of an assembly that must converge."""
    result = solve_assembly(parts, **options)
    assert result.status == "converged"
    return result


def mirrored(parts):
    """The assembly seen in a mirror across the shaft's middle: z, and rotations about x and y, change their signs."""
    length = SHAFT.length
    faces = {"left face": "right face", "right face": "left face"}

    def flip(s):
        track = replace(s.parts.track, hand="left" if s.parts.track.hand == "right" else "right")
        scene = replace(s.parts, track=track, nut=replace(s.parts.nut, position=length - s.position))
        if s.kind == "ball nut":
            held = faces[s.parts.solid.nut_held or "left face"]
            scene = replace(scene, solid=replace(scene.solid, nut_held=held))
        thrust = {"both": "both", "+z": "-z", "-z": "+z"}[s.thrust]
        return replace(s, parts=scene, position=length - s.position, offset=-s.offset, thrust=thrust)

    def turn(v, sign=1.0):
        return sign * v[0], sign * v[1], -sign * v[2]

    def housing(h):
        return replace(h, at=length - h.at, force=turn(h.force), moment=turn(h.moment, -1.0))

    supports = tuple(replace(s, at=length - s.at) for s in parts.supports)
    loads = tuple(Load(length - x.at, turn(x.force), turn(x.moment, -1.0)) for x in parts.loads)
    sets, housings = tuple(map(flip, parts.sets)), tuple(map(housing, parts.housings))
    return replace(parts, sets=sets, housings=housings, supports=supports, loads=loads)
