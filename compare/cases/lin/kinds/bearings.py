"""Scene files for friction in rotary and linear bearings: keys, faults and records (Lin 3.2, 3.3 and 4.3.1).

"bearing ball" is one ball of a rotary bearing, "bearing pair" a four-point and a double-row bearing under the same force.
"linear pair" and "linear chain" are two or more balls of a linear bearing, which may touch each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, degrees, pi, tan
from typing import Annotated, ClassVar, Literal

import numpy as np

from rollbench.compare.cases.lin.kinds import common
from rollbench.compare.scenes import keys as scenes_keys
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.keys import SceneFileTable
from rollbench.compare.scenes.kinds import FrictionSceneKeys
from rollbench.lowfi.friction.bearing import ALL, DIAGONAL, OTHER, BallRow, Bearing, BearingCase
from rollbench.lowfi.friction.linear.bearing import LinearBearing, Loads, contact_angle_deviations
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes import ranges
from rollbench.meshes.arrays import Array
from rollbench.meshes.ranges import ContactAngle, Force, ListLength, Plain, QuantityRange, Size, Switch
from rollbench.meshes.record_keys import scene_key
from rollbench.meshes.scene_text import Table, with_unit, without_empty_values

#: Name of a friction law.
Law = Literal["coulomb", "regularised", "sigmoid"]

#: Sliding speed [m/s] below which friction is reduced.
Creep = Annotated[float, QuantityRange("speed", "0 m/s", "1 m/s", "0.1 mm/s", lower_limit_excluded=True)]

#: Displacement of the inner ring [m].
Move = Annotated[float, QuantityRange("length", "-1 mm", "1 mm", "5 um")]

#: Axial force on the inner ring [N].
Axial = Annotated[float, QuantityRange("force", "-1 MN", "1 MN", "100 N")]

#: Parameter k_S of the sigmoid friction law.
Sharpness = Annotated[float, QuantityRange("number", 0, 1_000_000, 100, lower_limit_excluded=True)]

#: Step of friction tables in c/a, centre of rotation over semi-axis.
MapStep = Annotated[float, QuantityRange("number", 0, 1, 0.08, lower_limit_excluded=True)]


class InnerRingLoadKeys(SceneFileTable):
    """Axial force and radial displacement of the inner ring."""

    axial_force: Axial = scene_key("force on the inner ring along its axis")
    radial_displacement: Move = scene_key("radial displacement of the inner ring towards the ball", "5 um", default=0.0)


class FrictionLawKeys(scenes_keys.CoulombFrictionKeys):
    """Coefficient of friction between ball and grooves, and the friction law."""

    law: Law = scene_key(
        "friction law: Coulomb's; Coulomb's, reduced at small sliding speeds (regularised); or the sigmoid of Lin (3.20)",
        "coulomb",
        default="coulomb",
    )
    creep: Creep | None = scene_key('sliding speed below which friction is reduced, for law = "regularised"', default=None)
    sharpness: Sharpness | None = scene_key('parameter k_S of the law "sigmoid"', default=None)
    map_step: MapStep | None = scene_key(
        'step of c/a in the friction tables of law = "sigmoid" (c: distance of the centre of rotation from the '
        "centre of the contact; a: semi-axis of the contact); if left out, exact integrals instead of tables",
        default=None,
    )


class BearingBallKeys(common.HertzSceneKeys, common.EqualGrooveKeys):
    """One ball of a rotary bearing; the inner ring turns, the outer ring is fixed."""

    kind: Literal["bearing ball"] = scene_key("what the scene describes", "bearing ball")
    load: InnerRingLoadKeys = scene_key("force and displacement of the inner ring")
    motion: scenes_keys.RingSpeedKeys = scene_key("motion of the inner ring")
    friction: FrictionLawKeys = scene_key("friction")


@dataclass(frozen=True)
class BearingBallScene(FrictionScene):
    """Scene of one ball in a rotary bearing, under an axial force and a radial displacement of the inner ring."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "bearing ball"
    #: Geometry, motion and friction of the bearing.
    bearing: Bearing
    #: Axial force on the inner ring [N].
    force: float
    #: Radial displacement of the inner ring towards the ball [m].
    displacement: float
    #: Friction law.
    law: Law
    #: Sliding speed [m/s] below which the law "regularised" reduces friction.
    creep: float
    #: Parameter k_S of the law "sigmoid".
    sharpness: float
    #: Step of the tables of the law "sigmoid" in c/a, the distance of the centre of rotation from the contact's centre
    #: divided by the semi-axis a; None: exact integrals instead of tables.
    map_step: float | None

    def file_tables(self) -> Table:
        """Return the tables of the scene file of one bearing ball."""
        b = self.bearing
        creep = with_unit(Creep, self.creep) if self.creep else None
        law = without_empty_values(law=self.law, creep=creep, sharpness=self.sharpness or None, map_step=self.map_step)
        return {
            "material": common.material_table(b.young, b.poisson),
            **common.track_and_groove_tables(b, 0.0 - b.clearance),
            **common.hertz_table(b),
            "load": {
                "axial_force": with_unit(Force, self.force),
                "radial_displacement": with_unit(ranges.Deviation, self.displacement),
            },
            "motion": {"speed": with_unit(ranges.Turning, b.screw_speed)},
            "friction": {"coefficient": b.mu, **law},
        }


def bearing_ball_faults(keys: BearingBallKeys) -> Iterator[Fault]:
    """Yield the faults of a scene file of one bearing ball: contradictory keys, and geometry the model does not cover."""
    wrong = [*common.material_faults(keys.material), *common.groove_and_path_faults(keys, is_bearing=True)]
    yield from wrong
    if wrong:
        return
    reach = keys.screw.radius_for(keys.balls.radius) - keys.balls.radius
    yield from common.displacement_faults(reach, keys.load.radial_displacement, "load.radial_displacement")
    yield from _friction_law_faults(keys.friction, keys.motion.speed)


def _friction_law_faults(friction: FrictionLawKeys, speed: float) -> Iterator[Fault]:
    """Yield the faults of a friction law's keys: parameters of another law or missing, or a ring at rest with the sigmoid.

    ``friction``: keys of the friction law; ``speed``: angular speed of the inner ring [rad/s].
    """
    for name, law in (("creep", "regularised"), ("sharpness", "sigmoid"), ("map_step", "sigmoid")):
        if getattr(friction, name) is not None and friction.law != law:
            yield Fault((f"friction.{name}",), f'only with law = "{law}"', f'remove the key, or set law = "{law}"')
    if friction.law == "regularised" and friction.creep is None:
        advice = 'add creep = "0.1 mm/s", the sliding speed below which friction is reduced'
        yield Fault(("friction.creep",), "above 0 m/s", advice, "nothing")
    if friction.law == "sigmoid" and friction.sharpness is None:
        yield Fault(("friction.sharpness",), "above 0", "add sharpness = 100, the k_S of the sigmoid", "nothing")
    if friction.law == "sigmoid" and speed == 0.0:
        advice = "let the ring turn, or choose another law; the sigmoid refers to the ring's speed"
        yield Fault(("motion.speed",), "not zero for the sigmoid", advice)


def bearing_ball_scene(keys: BearingBallKeys, name: str) -> BearingBallScene:
    """Return the scene ``name`` of one bearing ball from the validated keys of its file."""
    f, clearance = keys.friction, 0.0 - keys.errors.balls.oversize
    return BearingBallScene(
        *common.head_of_scene(keys, name),
        common.grooves_from_keys(Bearing, keys, keys, 0.0, (0.0, keys.motion.speed), clearance=clearance),
        keys.load.axial_force,
        keys.load.radial_displacement,
        f.law,
        f.creep or 0.0,
        f.sharpness or 0.0,
        f.map_step,
    )


# --- the kind "bearing pair": comparison of a four-point and a double-row bearing over the angle of the load (Lin 4.3.1)


#: Angle of a force from the axis [rad].
LoadAngle = Annotated[float, QuantityRange("angle", "0 deg", "90 deg", "18 deg")]


class BearingRowBallKeys(scenes_keys.BallSizeKeys):
    """Evenly spaced balls of one bearing row: their size and number."""

    count: Annotated[int, Plain("int", 1, 1000)] = scene_key("balls in a row", 9)


class RotaryBearingKeys(common.EqualGrooveKeys):
    """Rotary bearing whose inner ring turns and whose outer ring is fixed."""

    balls: BearingRowBallKeys = scene_key("balls of each row")


class BearingRowsKeys(SceneFileTable):
    """Distance and arrangement of the two rows of balls of a double-row bearing."""

    distance: Size = scene_key("axial distance of the rows", "12 mm")
    arrangement: Literal["back to back", "face to face"] = scene_key(
        "arrangement of the rows", "back to back", default="back to back"
    )


class DoubleRowBearingKeys(RotaryBearingKeys):
    """Double-row angular-contact bearing."""

    rows: BearingRowsKeys = scene_key("the rows")


class InnerRingForceKeys(SceneFileTable):
    """Force on the inner ring through the bearing's centre, at several angles to the axis; whether the ring may tilt."""

    force: common.Pressing = scene_key("magnitude of the force on the inner ring")
    angles: Annotated[tuple[LoadAngle, ...], ListLength(2, 500)] = scene_key(
        "angles between the force and the bearing axis, in ascending order", ["0 deg", "10 deg", "18 deg"]
    )
    tilt: Switch = scene_key("whether the inner ring is free to tilt", True, default=True)


class BearingPairKeys(common.HertzSceneKeys):
    """Four-point bearing and double-row bearing under the same force."""

    kind: Literal["bearing pair"] = scene_key("what the scene describes", "bearing pair")
    four_point: RotaryBearingKeys = scene_key("the four-point bearing")
    double_row: DoubleRowBearingKeys = scene_key("the double-row bearing")
    load: InnerRingForceKeys = scene_key("force on the inner ring")
    motion: scenes_keys.RingSpeedKeys = scene_key("motion of the inner ring")
    friction: scenes_keys.CoulombFrictionKeys = scene_key("friction")


@dataclass(frozen=True)
class BearingPairScene(FrictionScene):
    """Scene of a four-point and a double-row bearing under the same force."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "bearing pair"
    #: Four-point bearing with load and friction.
    four_point: BearingCase
    #: Double-row bearing with load and friction.
    double_row: BearingCase
    #: Angles between the force and the bearing axis ``(n,)`` [rad]; the scene is solved for each of them.
    angle: Array

    def file_tables(self) -> Table:
        """Return the tables of the scene file of a four-point and a double-row bearing."""
        four, double = self.four_point, self.double_row
        groove = four.groove
        first, second = double.rows
        arrangement = "face to face" if first.contacts == DIAGONAL else "back to back"
        rows = {"distance": with_unit(Size, second.place - first.place), "arrangement": arrangement}
        load = {"force": with_unit(Force, four.force), "angles": [with_unit(ContactAngle, float(x)) for x in self.angle]}
        return {
            "material": common.material_table(groove.young, groove.poisson),
            "four_point": _tables_of_one_bearing(four),
            "double_row": _tables_of_one_bearing(double) | {"rows": rows},
            "load": load | {"tilt": four.tilt},
            "motion": {"speed": with_unit(ranges.Turning, groove.screw_speed)},
            "friction": {"coefficient": groove.mu},
            **common.hertz_table(groove),
        }


def bearing_pair_faults(keys: BearingPairKeys) -> Iterator[Fault]:
    """Yield the faults of a scene file of two bearings: contradictory keys, and geometry the model does not cover."""
    wrong = list(common.material_faults(keys.material))
    yield from wrong
    if wrong:
        return
    for table, b in (("four_point", keys.four_point), ("double_row", keys.double_row)):
        wrong = list(common.groove_and_path_faults(b, f"{table}.", is_bearing=True))
        yield from wrong
        if not wrong:
            most = int(pi / asin(b.balls.radius / b.track.pitch_radius))
            if b.balls.count > most:
                advice = "choose fewer or smaller balls, which do not overlap"
                yield Fault((f"{table}.balls.count",), f"1 to {most}", advice)
            yield from common.missing_hertz_constant_faults(_bearing_case_from_keys(keys, b).groove, f"{table}.")
    if np.any(np.diff(keys.load.angles) <= 0.0):
        advice = "sort the angles and give each once; each solution starts from the one at the previous angle"
        yield Fault(("load.angles",), "angles in ascending order", advice)
    if keys.motion.speed == 0.0:
        yield Fault(("motion.speed",), "not zero", "let the inner ring turn; friction torque is computed for a moving ring")


def _bearing_case_from_keys(keys: BearingPairKeys, ring: RotaryBearingKeys) -> BearingCase:
    """Return one of the two bearings of a scene, with load and friction; ``ring``: keys of this bearing."""
    groove = common.grooves_from_keys(ScrewGroove, keys, ring, 0.0, (0.0, keys.motion.speed))
    rows: tuple[BallRow, ...] = (BallRow(0.0, ALL),)
    if isinstance(ring, DoubleRowBearingKeys):
        half = 0.5 * ring.rows.distance
        first, second = (OTHER, DIAGONAL) if ring.rows.arrangement == "back to back" else (DIAGONAL, OTHER)
        rows = (BallRow(-half, first), BallRow(half, second))
    return BearingCase(groove, ring.balls.count, rows, keys.load.force, 0.0 - ring.errors.balls.oversize, keys.load.tilt)


def bearing_pair_scene(keys: BearingPairKeys, name: str) -> BearingPairScene:
    """Return the scene ``name`` of a four-point and a double-row bearing from the validated keys of its file."""
    four, double = (_bearing_case_from_keys(keys, b) for b in (keys.four_point, keys.double_row))
    return BearingPairScene(*common.head_of_scene(keys, name), four, double, np.array(keys.load.angles))


#: Speed of the carriage [m/s].
Speed = Annotated[float, QuantityRange("speed", "-1000 m/s", "1000 m/s", "10 mm/s")]

#: Side force on a ball divided by the vertical force.
SideRatio = Annotated[float, QuantityRange("number", -10, 10, -0.6)]


class LinearTrackKeys(SceneFileTable):
    """Contact angle of a linear bearing, whose ball centres move on a straight path."""

    contact_angle: ContactAngle = scene_key("nominal angle between contact normals and vertical force")


class CarriageForceKeys(SceneFileTable):
    """Vertical force of the carriage on each ball of a linear bearing, and how contact loads follow from it."""

    vertical_force: common.Pressing = scene_key("vertical force of the carriage on each ball")
    distribution: Loads = scene_key(
        "how the four contact loads of a ball follow from the forces on it: equilibrium at fixed contact angles; "
        "equal loads at opposite contacts (one diagonal); or elastic contacts with changing angles",
        "elastic",
        default="balanced",
    )


class CarriageForceOnPairKeys(CarriageForceKeys):
    """Force of the carriage on two balls of a linear bearing; the side forces on the two balls are opposite."""

    side_force_ratio: SideRatio = scene_key("side force on the first ball divided by vertical_force")


class CarriageSpeedKeys(SceneFileTable):
    """Speed of the carriage of a linear bearing."""

    carriage: Speed = scene_key("speed of the carriage along the track")


class BottomAngleDeviationKeys(SceneFileTable):
    """Contact angles at the bottom groove: smaller than nominal on the left, larger by the same amount on the right."""

    deviation: common.Theta = scene_key(
        "theta: contact angles are the nominal angle minus theta at bottom left, plus theta at bottom right"
    )
    mated: Switch = scene_key(
        "whether the contact angles at the top groove deviate too, so that the two contacts on each diagonal of a "
        "ball stay diametrically opposite (Lin 3.3.4.2)",
        False,
        default=False,
    )


class BallOfChainKeys(SceneFileTable):
    """One ball in a chain of balls of a linear bearing: side force, contact angles, and gap to the next ball."""

    side_force_ratio: SideRatio = scene_key("side force divided by vertical_force", default=0.0)
    angle_deviations: Annotated[tuple[common.Theta, ...], ListLength(4, 4)] = scene_key(
        "deviations of the contact angles from the nominal angle, at bottom left, bottom right, top right, top left",
        ["-2 deg", "2 deg", "0 deg", "0 deg"],
        default=(0.0, 0.0, 0.0, 0.0),
    )
    gap: common.Gap = scene_key("gap to the next ball; 0: the two balls may touch", "0.5 mm", default=0.0)


class LinearBearingKeys(FrictionSceneKeys):
    """Linear bearing with balls between equal gothic-arch grooves at bottom and top."""

    track: LinearTrackKeys = scene_key("path of the ball centres")
    grooves: scenes_keys.GrooveKeys = scene_key("cross-section of both grooves", {"conformity": 0.56})
    balls: scenes_keys.BallSizeKeys = scene_key("the balls")
    motion: CarriageSpeedKeys = scene_key("motion of the carriage")
    friction: common.BallFrictionKeys = scene_key("friction")


class LinearPairKeys(LinearBearingKeys):
    """Two balls of a linear bearing, which may touch each other."""

    kind: Literal["linear pair"] = scene_key("what the scene describes", "linear pair")
    angles: BottomAngleDeviationKeys = scene_key("contact angles")
    load: CarriageForceOnPairKeys = scene_key("force of the carriage")


class LinearChainKeys(LinearBearingKeys):
    """Chain of balls in a linear bearing, which may touch each other."""

    kind: Literal["linear chain"] = scene_key("what the scene describes", "linear chain")
    load: CarriageForceKeys = scene_key("force of the carriage")
    chain: Annotated[tuple[BallOfChainKeys, ...], ListLength(1, 500)] = scene_key("balls in order along the track")


@dataclass(frozen=True)
class LinearBearingScene(FrictionScene):
    """Scene of N balls in a linear bearing."""

    #: Geometry, motion and friction of the bearing.
    bearing: LinearBearing
    #: Contact angles (N, 4) [rad] before loading, at bottom left, bottom right, top right and top left.
    angles: Array
    #: Vertical force on each ball [N].
    vertical: float
    #: Side force on each ball divided by the vertical force (N,).
    side: Array
    #: How the contact loads follow from the forces, a value of the key ``load.distribution``.
    distribution: Loads
    #: Gaps between neighbouring balls (N-1,) [m].
    gap: Array

    def file_tables(self) -> Table:
        """Return the tables of the scene file of balls in a linear bearing."""
        b = self.bearing
        load = {"vertical_force": with_unit(Force, self.vertical), "distribution": self.distribution}
        table = {
            "material": common.material_table(b.young, b.poisson),
            "track": {"contact_angle": with_unit(ContactAngle, b.contact_angle)},
            "grooves": {"conformity": b.conformity},
            "balls": {"radius": with_unit(ranges.Radius, b.ball_radius)},
            "motion": {"carriage": with_unit(Speed, b.speed)},
            "friction": {"coefficient": b.mu} | ({} if b.mu_balls == b.mu else {"balls": b.mu_balls}),
        }
        if isinstance(self, LinearPairScene):
            mated = b.contact_angle + contact_angle_deviations(np.full(2, self.deviation), mated=True)
            angles = {
                "deviation": with_unit(common.Theta, self.deviation),
                "mated": bool(np.array_equal(mated, self.angles)),
            }
            return table | {"angles": angles, "load": load | {"side_force_ratio": float(self.side[0])}}
        chain = [
            {
                "side_force_ratio": float(side),
                "angle_deviations": [with_unit(common.Theta, float(x) - b.contact_angle, b.contact_angle) for x in row],
                "gap": with_unit(ranges.Clearance, float(gap)),
            }
            for side, row, gap in zip(self.side, self.angles, [*self.gap, 0.0], strict=True)
        ]
        return table | {"load": load, "chain": chain}


@dataclass(frozen=True)
class LinearPairScene(LinearBearingScene):
    """Scene of two balls in a linear bearing whose contact angles at the bottom groove deviate from the nominal one."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "linear pair"
    #: Deviation of the contact angles at the bottom groove [rad].
    deviation: float


@dataclass(frozen=True)
class LinearChainScene(LinearBearingScene):
    """Scene of a chain of balls in a linear bearing."""

    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "linear chain"


# --- faults of keys


def linear_bearing_faults(keys: LinearPairKeys | LinearChainKeys) -> Iterator[Fault]:
    """Yield the faults of a scene file of a linear bearing: contradictory keys, and geometry the model does not cover."""
    wrong = [*common.material_faults(keys.material), *common.groove_radius_faults(keys.grooves, keys.balls, "grooves")]
    yield from wrong or _linear_ball_faults(keys)


def _linear_ball_faults(keys: LinearPairKeys | LinearChainKeys) -> Iterator[Fault]:
    """Yield the faults of the keys for gaps, contact angles and side forces of the balls of a linear bearing."""
    angles, side, gap = _ball_angles_and_gaps(keys)
    chain = isinstance(keys, LinearChainKeys)
    if gap[-1] != 0.0:
        where = f"chain[{len(gap) - 1}].gap"
        yield Fault((where,), "no gap for the last ball", "remove the gap, because no ball follows")
    for i, row in enumerate(angles):
        if row.min() <= 0.0 or row.max() >= 0.5 * pi:
            where = f"chain[{i}].angle_deviations" if chain else "angles.deviation"
            advice = f"choose smaller deviations; the nominal contact angle is {degrees(keys.track.contact_angle):.6g} deg"
            yield Fault((where,), "contact angles above 0 deg, below 90 deg", advice)
            return
        low, high = allowed_side_force_ratios(row, keys.track.contact_angle, keys.load.distribution)
        if not low <= side[i] <= high:
            where = f"chain[{i}].side_force_ratio" if chain else "load.side_force_ratio"
            least, most = (low, high) if chain or i == 0 else (-high, -low)
            advice = 'reduce the ratio: a contact would have to carry tension; or write distribution = "elastic"'
            yield Fault((where,), f"{least:.4g} to {most:.4g} at these contact angles", advice)
            return


def allowed_side_force_ratios(
    contact_angles: Array, nominal_contact_angle: float, distribution: Loads
) -> tuple[float, float]:
    """Return the smallest and largest ratio of side to vertical force on a ball for which no contact is in tension.

    ``contact_angles``: contact angles (4,) [rad] at bottom left, bottom right, top right and top left;
    ``nominal_contact_angle``: nominal contact angle [rad]; ``distribution``: how the contact loads follow from the forces,
    a value of the key ``load.distribution``. The ratios are infinite for "elastic", where contacts may separate.
    """
    if distribution == "elastic":
        return -np.inf, np.inf
    if distribution == "diagonal":
        return -tan(nominal_contact_angle), tan(nominal_contact_angle)
    bl, br, tr, tl = (tan(float(a)) for a in contact_angles)
    return -min(bl, tr), min(br, tl)


# --- records


def _ball_angles_and_gaps(keys: LinearPairKeys | LinearChainKeys) -> tuple[Array, Array, Array]:
    """Return the contact angles, side force ratios and gaps of the N balls of a linear bearing, from its keys.

    These are the contact angles (N, 4) [rad] at bottom left, bottom right, top right and top left; the ratios of side force
    to vertical force (N,); and the gaps to the next ball (N,) [m].
    """
    if isinstance(keys, LinearPairKeys):
        two = np.full(2, keys.angles.deviation)
        turned, rho = contact_angle_deviations(two, mated=keys.angles.mated), keys.load.side_force_ratio
        return keys.track.contact_angle + turned, np.array([rho, -rho]), np.zeros(2)
    turned = np.array([b.angle_deviations for b in keys.chain])
    side, gap = (np.array([getattr(b, name) for b in keys.chain]) for name in ("side_force_ratio", "gap"))
    return keys.track.contact_angle + turned, side, gap


def linear_bearing_scene(keys: LinearPairKeys | LinearChainKeys, name: str) -> LinearBearingScene:
    """Return the scene ``name`` of balls in a linear bearing from the validated keys of its file."""
    f, radius = keys.friction, keys.balls.radius
    bearing = LinearBearing(
        radius,
        keys.grooves.conformity or 0.5 * keys.grooves.radius_for(keys.balls.radius) / radius,
        keys.track.contact_angle,
        keys.motion.carriage,
        f.coefficient,
        f.coefficient if f.balls is None else f.balls,
        *common.elastic_constants(keys.material),
    )
    angles, side, gap = _ball_angles_and_gaps(keys)
    head, force, how = common.head_of_scene(keys, name), keys.load.vertical_force, keys.load.distribution
    if isinstance(keys, LinearPairKeys):
        return LinearPairScene(*head, bearing, angles, force, side, how, gap[:-1], keys.angles.deviation)
    return LinearChainScene(*head, bearing, angles, force, side, how, gap[:-1])


def _tables_of_one_bearing(case: BearingCase) -> Table:
    """Return the scene-file tables of ball path, grooves and balls for one of the two bearings of a scene."""
    bodies = common.track_and_groove_tables(case.groove, 0.0 - case.clearance)
    return bodies | {"balls": bodies["balls"] | {"count": case.count}}
