"""The kind "bearing ball": one ball of a rotary bearing under a given force and displacement (Lin 3.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from rollbench.comparison.scenes.fault import Fault
from rollbench.comparison.scenes.keys import BallSizeKeys, CoulombKeys, PathKeys, SpeedKeys, Table
from rollbench.comparison.scenes.kinds import KindKeys, KindScene, head_of
from rollbench.comparison.scenes.quantity import Quantity, Rate, key
from rollbench.comparison.wings.friction.kinds.common import (
    Body,
    SectionKeys,
    body_faults,
    elastic,
    material_faults,
    play_faults,
)
from rollbench.lowfi.friction.bearing.rotary import Bearing, Mode

Law = Literal["coulomb", "regularised", "sigmoid"]
Creep = Annotated[float, Rate("speed", "0 m/s", "1 m/s", "0.1 mm/s", above=True)]
Move = Annotated[float, Quantity("length", "-1 mm", "1 mm", "5 um")]
Axial = Annotated[float, Quantity("force", "-1 MN", "1 MN", "100 N")]
Sharpness = Annotated[float, Quantity("number", 0, 1_000_000, 100, above=True)]
MapStep = Annotated[float, Quantity("number", 0, 1, 0.08, above=True)]


class RingLoadKeys(Table):
    """What is done to the inner ring."""

    axial_force: Axial = key("force along the axis")
    radial_displacement: Move = key("displacement towards the ball", "0 um", "5 um")


class LawKeys(CoulombKeys):
    """Friction of the contacts, and the law it follows."""

    law: Law = key("Coulomb's, Coulomb's regularised, or the sigmoid of Lin 3.20", "coulomb", "coulomb")
    creep: Creep | None = key('speed that regularises, for law = "regularised"', None)
    sharpness: Sharpness | None = key('k_S, for law = "sigmoid"', None)
    map_step: MapStep | None = key("step in c/a of the source's maps; exact integrals if left out", None)


class BearingBallKeys(SectionKeys):
    """One ball of a rotary bearing; the inner ring turns, the outer one is held."""

    kind: Literal["bearing ball"] = key("what the scene describes", example="bearing ball")
    track: PathKeys = key("path of the ball centres, of zero lead")
    balls: BallSizeKeys = key("the ball")
    load: RingLoadKeys = key("force and displacement of the inner ring")
    motion: SpeedKeys = key("motion of the inner ring")
    friction: LawKeys = key("friction")


@dataclass(frozen=True)
class BearingBallScene(KindScene):
    """One ball: bearing, axial force [N], radial displacement [m], Hertz constants, law with its parameters.

    creep [m/s] for "regularised"; sharpness k_S and map_step in c/a (None: exact integrals) for "sigmoid".
    """

    kind: ClassVar[str] = "bearing ball"
    bearing: Bearing
    force: float
    displacement: float
    hertz: Mode
    law: Law
    creep: float
    sharpness: float
    map_step: float | None


def faults(keys: KindKeys) -> Iterator[Fault]:
    """Contradictory choices and bodies that the model cannot treat."""
    assert isinstance(keys, BearingBallKeys)
    wrong = [*material_faults(keys.material), *body_faults(_body(keys), ring=True)]
    yield from wrong
    if wrong:
        return
    reach = _body(keys).groove - keys.balls.radius
    yield from play_faults(reach, keys.load.radial_displacement, "load.radial_displacement")
    yield from _law_faults(keys.friction, keys.motion.speed)


def _law_faults(f: LawKeys, speed: float) -> Iterator[Fault]:
    for name, law in (("creep", "regularised"), ("sharpness", "sigmoid"), ("map_step", "sigmoid")):
        if getattr(f, name) is not None and f.law != law:
            yield Fault((f"friction.{name}",), f'only with law = "{law}"', f'remove it, or set law = "{law}"')
    if f.law == "regularised" and f.creep is None:
        advice = 'add creep = "0.1 mm/s", the speed that regularises'
        yield Fault(("friction.creep",), "above 0 m/s", advice, "nothing")
    if f.law == "sigmoid" and f.sharpness is None:
        yield Fault(("friction.sharpness",), "above 0", "add sharpness = 100, the k_S of the sigmoid", "nothing")
    if f.law == "sigmoid" and speed == 0.0:
        advice = "the sigmoid's spin is relative to the ring's speed: let it turn, or take another law"
        yield Fault(("motion.speed",), "not zero for the sigmoid", advice)


def _body(keys: BearingBallKeys) -> Body:
    return Body(keys.track, keys.screw, keys.nut, keys.balls, keys.errors.balls.oversize)


def record(keys: KindKeys, name: str) -> BearingBallScene:
    """The scene of faultless keys."""
    assert isinstance(keys, BearingBallKeys)
    f, body = keys.friction, _body(keys)
    bearing = Bearing(
        keys.balls.radius,
        body.groove,
        keys.track.pitch_radius,
        keys.track.contact_angle,
        *elastic(keys.material),
        f.coefficient,
        keys.motion.speed,
        0.0 - body.oversize,
    )
    return BearingBallScene(
        *head_of(keys, name),
        bearing,
        keys.load.axial_force,
        keys.load.radial_displacement,
        keys.ingredients.mode,
        f.law,
        f.creep or 0.0,
        f.sharpness or 0.0,
        f.map_step,
    )
