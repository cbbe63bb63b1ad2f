"""The kind "bearing pair": a four-point bearing against a double-row one, over the angle of the load (Lin 4.3.1)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, pi
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from rollbench.comparison.scenes.fault import Fault
from rollbench.comparison.scenes.keys import BallSizeKeys, CoulombKeys, GrooveKeys, PathKeys, Size, SpeedKeys, Table
from rollbench.comparison.scenes.kinds import KindKeys, KindScene, head_of
from rollbench.comparison.scenes.quantity import Quantity, key
from rollbench.comparison.wings.friction.kinds.common import (
    Body,
    HertzKeys,
    Pressing,
    SharedErrorKeys,
    body_faults,
    elastic,
    material_faults,
)
from rollbench.comparison.wings.friction.kinds.screw_balls import hertz_faults
from rollbench.lowfi.friction.bearing.pairs import ALL, DIAGONAL, OTHER, BallRow, BearingCase
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.arrays import Array

LoadAngle = Annotated[float, Quantity("angle", "0 deg", "90 deg", "18 deg")]


class RowBallKeys(BallSizeKeys):
    """Balls of one row, evenly spread."""

    count: Annotated[int, Field(ge=1, le=1000)] = key("balls in a row", example=9)


class RingKeys(Table):
    """A rotary bearing; the inner ring turns, the outer one is held."""

    track: PathKeys = key("path of the ball centres, of zero lead")
    screw: GrooveKeys = key("groove of the inner ring", example={"groove_radius": "6.75 mm"})
    nut: GrooveKeys = key("groove of the outer ring; the same section", example={"groove_radius": "6.75 mm"})
    balls: RowBallKeys = key("balls of each row")
    errors: SharedErrorKeys = key("geometric errors", SharedErrorKeys(), {"balls": {"oversize": "1 um"}})


class RowKeys(Table):
    """Two rows of balls."""

    distance: Size = key("axial distance of the rows", example="12 mm")
    arrangement: Literal["back to back", "face to face"] = key("of the rows", "back to back", "back to back")


class DoubleRowKeys(RingKeys):
    """A double-row angular-contact bearing."""

    rows: RowKeys = key("the rows")


class BearingLoadKeys(Table):
    """Force on the inner ring, midway between the rows."""

    force: Pressing = key("size of the force")
    angles: Annotated[list[LoadAngle], Field(min_length=2, max_length=500)] = key(
        "angles of the force from the axis, in ascending order", example=["0 deg", "10 deg", "18 deg"]
    )
    tilt: bool = key("inner ring free to tilt", True, True)


class BearingPairKeys(KindKeys):
    """A four-point bearing and a double-row one under the same force."""

    kind: Literal["bearing pair"] = key("what the scene describes", example="bearing pair")
    four_point: RingKeys = key("the four-point bearing")
    double_row: DoubleRowKeys = key("the double-row bearing")
    load: BearingLoadKeys = key("force on the inner ring")
    motion: SpeedKeys = key("motion of the inner ring")
    friction: CoulombKeys = key("friction")
    ingredients: HertzKeys = key("parts of the low-order model", HertzKeys(), {"hertz": "nominal"})


@dataclass(frozen=True)
class BearingPairScene(KindScene):
    """Two bearings under the same force at angles (n,) [rad] from the axis."""

    kind: ClassVar[str] = "bearing pair"
    four_point: BearingCase
    double_row: BearingCase
    angle: Array


def _body(b: RingKeys, table: str) -> Body:
    return Body(b.track, b.screw, b.nut, b.balls, b.errors.balls.oversize, f"{table}.")


def faults(keys: KindKeys) -> Iterator[Fault]:
    """Contradictory choices and bodies that the model cannot treat."""
    assert isinstance(keys, BearingPairKeys)
    wrong = list(material_faults(keys.material))
    yield from wrong
    if wrong:
        return
    for table, b in (("four_point", keys.four_point), ("double_row", keys.double_row)):
        wrong = list(body_faults(_body(b, table), ring=True))
        yield from wrong
        if not wrong:
            most = int(pi / asin(b.balls.radius / b.track.pitch_radius))
            if b.balls.count > most:
                advice = "the balls would overlap: fewer or smaller balls"
                yield Fault((f"{table}.balls.count",), f"1 to {most}", advice)
            yield from hertz_faults(_bearing(keys, b, table).groove, f"{table}.")
    if np.any(np.diff(keys.load.angles) <= 0.0):
        advice = "each state starts the next: sort the angles and give each once"
        yield Fault(("load.angles",), "angles in ascending order", advice)
    if keys.motion.speed == 0.0:
        yield Fault(("motion.speed",), "not zero", "a friction torque needs a ring that turns")


def _bearing(keys: BearingPairKeys, b: RingKeys, table: str) -> BearingCase:
    body = _body(b, table)
    groove = ScrewGroove(
        b.balls.radius,
        body.groove,
        b.track.pitch_radius,
        0.0,
        b.track.contact_angle,
        *elastic(keys.material),
        keys.friction.coefficient,
        0.0,
        keys.motion.speed,
        hertz=keys.ingredients.mode,
    )
    rows: tuple[BallRow, ...] = (BallRow(0.0, ALL),)
    if isinstance(b, DoubleRowKeys):
        half = 0.5 * b.rows.distance
        first, second = (OTHER, DIAGONAL) if b.rows.arrangement == "back to back" else (DIAGONAL, OTHER)
        rows = (BallRow(-half, first), BallRow(half, second))
    return BearingCase(groove, b.balls.count, rows, keys.load.force, 0.0 - body.oversize, keys.load.tilt)


def record(keys: KindKeys, name: str) -> BearingPairScene:
    """The scene of faultless keys."""
    assert isinstance(keys, BearingPairKeys)
    four = _bearing(keys, keys.four_point, "four_point")
    double = _bearing(keys, keys.double_row, "double_row")
    return BearingPairScene(*head_of(keys, name), four, double, np.array(keys.load.angles))
