"""Scenes of friction in a ball screw and in bearings in pairs: two balls, a whole screw in time, torque over load."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, degrees, pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from compare.scenes.checks import Fault, mm
from compare.scenes.friction_keys import (
    Coefficient,
    CommonKeys,
    Gap,
    HertzKeys,
    LinearBearingKeys,
    Play,
    Pressing,
    Rubbing,
    Turning,
)
from compare.scenes.friction_scene import FrictionScene, groove_faults, groove_radius
from compare.scenes.quantity import Quantity, Rate, key
from compare.scenes.schema import Azimuth, Size, Table, Turns
from lowfi.friction.bearing.pairs import ALL, DIAGONAL, OTHER, BearingCase, Row
from lowfi.friction.linear.bearing import Array
from lowfi.friction.screw.groove import ScrewGroove
from lowfi.friction.screw.motion import Coupling
from lowfi.friction.screw.pair import Pair
from lowfi.friction.screw.run import Run

Advance = Annotated[float, Quantity("length", "0 mm", "1 m", "20 mm", above=True)]
AxialLoad = Annotated[float, Quantity("force", "-1 MN", "1 MN", "50 N")]
Theta = Annotated[float, Quantity("angle", "-15 deg", "15 deg", "2 deg")]
Share = Annotated[float, Quantity("number", -1, 1, 1)]
Pattern = Annotated[list[Share], Field(min_length=4, max_length=4)]
Part = Annotated[float, Quantity("number", 0, 1, 0.5)]
Cycles = Annotated[float, Quantity("number", 0, 1000, 2)]
Duration = Annotated[float, Rate("time", "0 s", "1e6 s", "2 s", above=True)]
LoadAngle = Annotated[float, Quantity("angle", "0 deg", "90 deg", "18 deg")]
Direction = Literal["axial", "radial"]
#: Most balls times steps of a run: its results are kept whole.
MOST = 5_000_000
#: Letters of the screw's free translations.
FREE: dict[Direction, str] = {"axial": "z", "radial": "r"}
_PATTERN = "how much of the deviation the contact angles at SL, SR, NL, NR (screw or nut, left or right) take"


class ScrewKeys(LinearBearingKeys):
    """A ball screw with gothic grooves."""

    pitch_radius: Size = key("radius of the helix of ball centres", example="16.5 mm")
    lead: Advance = key("advance of the helix per turn")
    hand: Literal["right", "left"] = key("hand of the helix", "right", "right")
    oversize: Play = key("excess of the ball radius along each contact normal; negative: clearance", "0 um", "1.7 um")


class ScrewLoadKeys(Table):
    """What is done to the screw; the nut stands against it."""

    force: AxialLoad = key("force on the screw")
    direction: Direction = key("along the axis, or radially at every ball; the screw moves that way only", "axial", "axial")


class ScrewMotionKeys(Table):
    """Motion along the helix; only the difference matters."""

    nut: Turning = key("angular speed of the nut")
    screw: Turning = key("angular speed of the screw", "0 rps", "0 rps")


class ScrewFrictionKeys(Table):
    """Coulomb friction of grooves and balls."""

    coefficient: Coefficient = key("friction coefficient of the grooves")
    between_balls: Rubbing | None = key("friction coefficient of ball on ball; as the grooves if left out", None)
    coupling: Coupling = key("what friction moves: nothing, the balls, or balls and screw", "none", "ball")


class PairAngleKeys(Table):
    """Contact angles of two balls."""

    deviations: Annotated[list[Theta], Field(min_length=2, max_length=2)] = key(
        "deviation theta at the ball behind and at the one ahead", example=["0 deg", "2 deg"]
    )
    pattern: Pattern = key(_PATTERN, [1, 1, 0, 0], [1, 1, 0, 0])


class RunAngleKeys(Table):
    """Contact angles along the screw: theta = amplitude sin(cycles azimuth + phase)."""

    amplitude: Theta = key("amplitude of the deviation theta")
    cycles_per_turn: Cycles = key("periods of theta in a turn of the screw", 2, 2)
    phase: Azimuth = key("phase of theta", "0 deg", "90 deg")
    pattern: Pattern = key(_PATTERN, [1, 1, 0, 0], [1, 1, 0, 0])


class TrackKeys(Table):
    """Closed track of the balls."""

    balls: Annotated[int, Field(ge=2, le=1000)] = key("number of balls", example=37)
    turns: Turns = key("loaded turns of the nut")
    return_tube: Gap = key("length of the return tube, whose balls bear no load", "0 mm", "5.6 mm")
    first_ball: Part = key("place of the first ball at the start, as a fraction of the distance between balls", 0.5, 0.5)


class TimeKeys(Table):
    """Steps in time."""

    duration: Duration = key("time simulated", example="2 s")
    steps: Annotated[int, Field(ge=1, le=100_000)] = key("number of equal steps", example=200)
    rounds: Annotated[int, Field(ge=1, le=100)] = key(
        "rounds of loads and friction in a step; one: loads with the friction of the step before", 1, 1
    )


class RowBearingKeys(LinearBearingKeys):
    """A rotary bearing; the inner ring turns, the outer one is held."""

    pitch_radius: Size = key("radius of the circle of ball centres", example="35 mm")
    balls: Annotated[int, Field(ge=1, le=1000)] = key("balls in a row", example=9)
    clearance: Play = key("play of the ball along each contact normal; negative: preload", "0 um", "-1 um")


class DoubleRowKeys(RowBearingKeys):
    """A double-row angular-contact bearing."""

    row_distance: Size = key("axial distance of the rows", example="12 mm")
    arrangement: Literal["back to back", "face to face"] = key("of the rows", "back to back", "back to back")


class BearingLoadKeys(Table):
    """Force on the inner ring, midway between the rows."""

    force: Pressing = key("size of the force")
    angles: Annotated[list[LoadAngle], Field(min_length=2, max_length=500)] = key(
        "angles of the force from the axis, in ascending order", example=["0 deg", "10 deg", "18 deg"]
    )
    tilt: bool = key("inner ring free to tilt", True, True)


class BearingMotionKeys(Table):
    """Motion of the inner ring."""

    inner_ring: Turning = key("angular speed about the axis")


class BearingFrictionKeys(Table):
    """Coulomb friction of the grooves."""

    coefficient: Coefficient = key("friction coefficient")


class ScrewPairKeys(HertzKeys):
    """Two balls of a ball screw in touch."""

    screw: ScrewKeys = key("geometry")
    angles: PairAngleKeys = key("contact angles")
    loads: ScrewLoadKeys = key("loads")
    motion: ScrewMotionKeys = key("motion")
    friction: ScrewFrictionKeys = key("friction")


class ScrewRunKeys(HertzKeys):
    """A whole ball screw in time."""

    screw: ScrewKeys = key("geometry")
    track: TrackKeys = key("closed track")
    angles: RunAngleKeys = key("contact angles")
    loads: ScrewLoadKeys = key("loads")
    motion: ScrewMotionKeys = key("motion")
    time: TimeKeys = key("time")
    friction: ScrewFrictionKeys = key("friction")


class BearingPairKeys(HertzKeys):
    """A four-point bearing against a double-row one."""

    four_point: RowBearingKeys = key("geometry of the four-point bearing")
    double_row: DoubleRowKeys = key("geometry of the double-row bearing")
    loads: BearingLoadKeys = key("loads")
    motion: BearingMotionKeys = key("motion")
    friction: BearingFrictionKeys = key("friction")


KINDS: dict[str, type[CommonKeys]] = {
    "screw pair": ScrewPairKeys,
    "screw run": ScrewRunKeys,
    "bearing pair": BearingPairKeys,
}


@dataclass(frozen=True)
class ScrewPairScene(FrictionScene):
    """Two balls of a ball screw."""

    pair: Pair


@dataclass(frozen=True)
class ScrewRunScene(FrictionScene):
    """A whole ball screw in time."""

    run: Run


@dataclass(frozen=True)
class BearingPairScene(FrictionScene):
    """Two bearings under the same force at angles (n,) [rad] from the axis."""

    four_point: BearingCase
    double_row: BearingCase
    angle: Array


# --- what a scene may not describe


def faults(keys: CommonKeys) -> Iterator[Fault]:
    """Contradictory choices and bodies that the models cannot treat."""
    if isinstance(keys, BearingPairKeys):
        yield from _bearing_faults(keys)
        return
    assert isinstance(keys, (ScrewPairKeys, ScrewRunKeys))
    wrong = list(_body_faults(keys.screw, "screw", "oversize"))
    if not wrong:
        wrong = list(_screw_faults(keys))
    if not wrong and isinstance(keys, ScrewRunKeys):
        wrong = list(_run_faults(keys))
    yield from wrong


def _body_faults(b: ScrewKeys | RowBearingKeys, table: str, play: str) -> Iterator[Fault]:
    wrong = list(groove_faults(b, table))
    if wrong:
        yield from wrong
        return
    groove = groove_radius(b)
    if b.pitch_radius <= groove:
        advice = "the balls run on a circle larger than the groove's section"
        yield Fault((f"{table}.pitch_radius",), f"above {mm(groove)}", advice)
    reach = groove - b.ball_radius
    if abs(getattr(b, play)) >= reach:
        advice = "the ball's centre would leave its groove's section: the models hold for small displacements"
        allowed = f"between -{mm(reach)} and {mm(reach)}, groove radius less ball radius"
        yield Fault((f"{table}.{play}",), allowed, advice)


def _screw_faults(keys: ScrewPairKeys | ScrewRunKeys) -> Iterator[Fault]:
    pair = isinstance(keys, ScrewPairKeys)
    where = "angles.deviations" if pair else "angles.amplitude"
    largest = max(map(abs, keys.angles.deviations)) if isinstance(keys, ScrewPairKeys) else abs(keys.angles.amplitude)
    nominal = keys.screw.contact_angle
    room = min(nominal, 0.5 * pi - nominal)
    if largest * max(map(abs, keys.angles.pattern)) >= room:
        advice = f"the nominal contact angle is {degrees(nominal):.6g} deg; take a smaller deviation"
        yield Fault((where,), "contact angles above 0 deg, below 90 deg", advice)
    try:
        _ = _screw_groove(keys).pair
    except ValueError:
        advice = "two balls cannot touch within a quarter of a turn: take smaller balls"
        yield Fault(("screw.ball_radius",), f"small against the pitch radius, {mm(keys.screw.pitch_radius)}", advice)
    yield from _hertz_faults(_screw_groove(keys), "screw")
    if keys.loads.force == 0.0 and keys.screw.oversize <= 0.0:
        advice = "nothing presses the balls: give a force, or an oversize above 0 um"
        yield Fault(("loads.force",), "not zero for balls without oversize", advice)


def _hertz_faults(groove: ScrewGroove, table: str) -> Iterator[Fault]:
    try:
        with np.errstate(invalid="ignore"):
            if np.all(np.isfinite(groove.constants.C)):
                return
    except ValueError:
        pass
    if groove.hertz == "as printed":
        advice = "the source's constants do not exist there, mostly because the helix is too steep"
        yield Fault(("hertz",), '"right" for these grooves', advice)
        return
    keys = (f"{table}.groove_radius", f"{table}.conformity")
    yield Fault(keys, "a groove that does not conform to its ball", "take a wider groove")


def _run_faults(keys: ScrewRunKeys) -> Iterator[Fault]:
    if keys.motion.nut == keys.motion.screw:
        advice = "a torque needs nut and screw to turn against each other"
        yield Fault(("motion.nut",), "another speed than the screw's", advice)
    groove = _screw_groove(keys)
    ring = 2.0 * pi * keys.track.turns + keys.track.return_tube / groove.radius
    most = int(np.ceil(ring / groove.pair.spacing)) - 1
    if keys.track.balls > most:
        advice = "the balls need some free length on the track: fewer balls, more turns or a return tube"
        yield Fault(("track.balls",), f"2 to {most} on this track" if most > 1 else "a longer track", advice)
    if keys.track.balls * keys.time.steps > MOST:
        advice = "results of all steps are kept: take fewer steps, or fewer balls"
        yield Fault(("time.steps",), f"1 to {MOST // keys.track.balls} with {keys.track.balls} balls", advice)


def _bearing_faults(keys: BearingPairKeys) -> Iterator[Fault]:
    for table, b in (("four_point", keys.four_point), ("double_row", keys.double_row)):
        wrong = list(_body_faults(b, table, "clearance"))
        yield from wrong
        if not wrong:
            most = int(pi / asin(b.ball_radius / b.pitch_radius))
            if b.balls > most:
                yield Fault((f"{table}.balls",), f"1 to {most}", "the balls would overlap: fewer or smaller balls")
            yield from _hertz_faults(_bearing(keys, b).groove, table)
    if np.any(np.diff(keys.loads.angles) <= 0.0):
        advice = "each state starts the next: sort the angles and give each once"
        yield Fault(("loads.angles",), "angles in ascending order", advice)
    if keys.motion.inner_ring == 0.0:
        yield Fault(("motion.inner_ring",), "not zero", "a friction torque needs a ring that turns")


# --- records


def _screw_groove(keys: ScrewPairKeys | ScrewRunKeys) -> ScrewGroove:
    s, f, m = keys.screw, keys.friction, keys.material
    lead = -s.lead if s.hand == "left" else s.lead
    return ScrewGroove(
        s.ball_radius,
        groove_radius(s),
        s.pitch_radius,
        lead,
        s.contact_angle,
        m.youngs_modulus,
        m.poissons_ratio,
        f.coefficient,
        keys.motion.nut,
        keys.motion.screw,
        f.between_balls,
        keys.hertz,
    )


def _bearing(keys: BearingPairKeys, b: RowBearingKeys) -> BearingCase:
    m = keys.material
    groove = ScrewGroove(
        b.ball_radius,
        groove_radius(b),
        b.pitch_radius,
        0.0,
        b.contact_angle,
        m.youngs_modulus,
        m.poissons_ratio,
        keys.friction.coefficient,
        0.0,
        keys.motion.inner_ring,
        hertz=keys.hertz,
    )
    rows: tuple[Row, ...] = (Row(0.0, ALL),)
    if isinstance(b, DoubleRowKeys):
        first, second = (OTHER, DIAGONAL) if b.arrangement == "back to back" else (DIAGONAL, OTHER)
        rows = (Row(-0.5 * b.row_distance, first), Row(0.5 * b.row_distance, second))
    return BearingCase(groove, b.balls, rows, keys.loads.force, b.clearance, keys.loads.tilt)


def _run(keys: ScrewRunKeys) -> Run:
    groove, t, a = _screw_groove(keys), keys.track, keys.angles
    return Run(
        groove,
        t.balls,
        t.turns,
        (keys.loads.force,),
        FREE[keys.loads.direction],
        keys.time.duration,
        keys.time.steps,
        keys.screw.oversize,
        a.amplitude,
        a.cycles_per_turn,
        a.phase,
        tuple(a.pattern),
        t.return_tube / groove.radius,
        t.first_ball,
        keys.friction.coupling,
        keys.time.rounds,
    )


def record(keys: CommonKeys, name: str) -> FrictionScene:
    """The scene of faultless keys."""
    head = (name, keys.title, keys.source, tuple(keys.assumed))
    if isinstance(keys, ScrewRunKeys):
        return ScrewRunScene(*head, _run(keys))
    if isinstance(keys, BearingPairKeys):
        four, double = (_bearing(keys, b) for b in (keys.four_point, keys.double_row))
        return BearingPairScene(*head, four, double, np.array(keys.loads.angles))
    assert isinstance(keys, ScrewPairKeys)
    first, second = keys.angles.deviations
    pattern = tuple(keys.angles.pattern)
    pair = Pair(
        _screw_groove(keys),
        (first, second),
        (pattern, pattern),
        keys.screw.oversize,
        FREE[keys.loads.direction],
        (keys.loads.force,),
        keys.friction.coupling,
    )
    return ScrewPairScene(*head, pair)
