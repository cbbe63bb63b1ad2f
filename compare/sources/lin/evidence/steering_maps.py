"""How the results of Lin 4.2 depend on what the source does not print: lash of 4.2.1, ratios of 4.2.2."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rollbench.comparison.sources.lin.evidence.lash_4_2_1 import TURNING, Lash, lash
from rollbench.comparison.sources.lin.evidence.steering_4_2 import REACH, at_angle, largest, ratios
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

#: Outer diameters [m], distances of the lateral force from the nut [m], restraints of the screw's left end.
DIAMETERS, REACHES = (26e-3, 28e-3, 30e-3), (0.1, 0.2, 0.3, 0.5)
RESTRAINTS = {
    "turning only": TURNING,
    "guided across": ("ux", "uy", "rz"),
    "clamped but for its axis": ("ux", "uy", "rx", "ry", "rz"),
}
#: Stations of the pinion [m], its restraints, offsets of the bearing from the nut's centre [m], angles [deg].
PINIONS = (0.35, 0.45, 0.55, 0.65, 0.75)
PINION_HOLDS = {"held but along the rack": ("ux", "uy", "rx", "ry", "rz"), "pinned across": ("ux", "uy", "rz")}
OFFSETS, ANGLES = (-0.02, 0.0, 0.02), (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0)


@dataclass(frozen=True)
class LashPoint:
    """Open inputs, and the differences [%] over the ball patterns that they give."""

    changed: str
    diameter: float
    position: float
    reach: float
    restraint: str
    found: Lash


def lash_map(scene: Scene) -> Iterator[LashPoint]:
    """Each open input of the lash tests changed by itself; the force stays on the longer side of the screw."""
    usual = scene.screw.outer_diameter, scene.nut.position, REACH, "turning only"
    cases = [("as taken", usual)]
    cases += [("outer diameter", (d, *usual[1:])) for d in DIAMETERS if d != usual[0]]
    cases += [("position of the nut", (usual[0], 0.5 * scene.screw.length, *usual[2:]))]
    cases += [("distance of the lateral force", (*usual[:2], x, usual[3])) for x in REACHES if x != usual[2]]
    cases += [("restraint", (*usual[:3], name)) for name in RESTRAINTS if name != usual[3]]
    for changed, (diameter, position, reach, restraint) in cases:
        screw, nut = replace(scene.screw, outer_diameter=diameter), replace(scene.nut, position=position)
        found = lash(replace(scene, screw=screw, nut=nut), reach, RESTRAINTS[restraint])
        yield LashPoint(changed, diameter, position, reach, restraint, found)


@dataclass(frozen=True)
class RatioPoint:
    """Layout of the steering gear, and largest loads at 18 deg over those at 0 deg of ball screw and bearing."""

    pinion: float
    hold: str
    opposed: bool
    offset: float
    screw: float
    bearing: float


def with_layout(gear: Assembly, pinion: float, hold: str, offset: float) -> Assembly:
    """The gear with its pinion at a station [m], held as named, its bearing by an offset [m] from the nut's centre."""
    (support,) = gear.supports
    held = replace(support, at=pinion, fixed=tuple((name, 0.0) for name in PINION_HOLDS[hold]))
    sets = []
    for s in gear.sets:
        at = s.position + offset
        if s.carrier is not None and isinstance(s.parts, Scene):
            s = replace(s, position=at, parts=replace(s.parts, nut=replace(s.parts.nut, position=at)))
        sets.append(s)
    return replace(gear, supports=(held,), sets=tuple(sets))


def ratio_map(gear: Assembly) -> Iterator[RatioPoint]:
    """Ratios over the pinion's station, for each restraint, sense of the side forces, and offset of the bearing.

    A pinion that holds the rack against tilting keeps the far end's side force from the nut: its sense is of no account.
    """
    for hold in PINION_HOLDS:
        for opposed in (False, True)[: 1 if "rx" in PINION_HOLDS[hold] else 2]:
            for offset in OFFSETS:
                for pinion in PINIONS:
                    layout = with_layout(gear, pinion, hold, offset)
                    yield RatioPoint(pinion, hold, opposed, offset, *ratios(layout, opposed=opposed))


def over_angles(gear: Assembly) -> list[tuple[float, float]]:
    """Largest loads [N] of ball screw and bearing at the tie-rod angles."""
    return [largest(at_angle(gear, angle)) for angle in ANGLES]
