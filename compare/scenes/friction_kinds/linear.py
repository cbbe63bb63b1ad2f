"""The kinds "linear pair" and "linear chain": balls of a linear bearing in reach of each other (Lin 3.3)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi, tan
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from rollbench.compare.scenes.fault import Fault
from rollbench.compare.scenes.friction_kinds import common
from rollbench.compare.scenes.keys import BallSizeKeys, GrooveKeys, Table, key
from rollbench.compare.scenes.kinds import KindKeys, KindScene, head_of
from rollbench.lowfi.friction.linear.bearing import LinearBearing, Loads, deviations
from rollbench.meshes.arrays import Array
from rollbench.meshes.ranges import ContactAngle, Quantity, Rate

Speed = Annotated[float, Rate("speed", "-1000 m/s", "1000 m/s", "10 mm/s")]
SideRatio = Annotated[float, Quantity("number", -10, 10, -0.6)]


class StraightKeys(Table):
    """Straight path of the ball centres."""

    contact_angle: ContactAngle = key("nominal angle of the contact normals against the pressing direction")


class ChainLoadKeys(Table):
    """Force of the carriage on every ball."""

    vertical_force: common.Pressing = key("force that presses on each ball")
    distribution: Loads = key(
        "loads in balance at the angles, equal on each diagonal, or with angles that follow", "balanced", "elastic"
    )


class PairLoadKeys(ChainLoadKeys):
    """Force of the carriage on each ball; the side force acts on the second ball in the opposite sense."""

    side_force_ratio: SideRatio = key("side force on the first ball over vertical_force")


class CarriageKeys(Table):
    """Motion of the carriage."""

    carriage: Speed = key("speed along the track")


class LinearAngleKeys(Table):
    """Contact angles of the pair: bottom left less, bottom right more by the deviation."""

    deviation: common.Theta = key("deviation theta of the bottom groove's contact angles")
    mated: bool = key("top groove made to match (Lin 3.3.4.2)", False, False)


class ChainBallKeys(Table):
    """One ball of a chain, in order along the track."""

    side_force_ratio: SideRatio = key("side force over vertical_force", 0.0)
    angle_deviations: Annotated[list[common.Theta], Field(min_length=4, max_length=4)] = key(
        "deviations of the contact angles at BL, BR, TR, TL",
        ["0 deg", "0 deg", "0 deg", "0 deg"],
        ["-2 deg", "2 deg", "0 deg", "0 deg"],
    )
    gap: common.Gap = key("gap to the next ball; none: in reach of each other", "0 mm", "0.5 mm")


class LinearKeys(KindKeys):
    """Balls of a linear bearing, the same gothic groove at bottom and top."""

    track: StraightKeys = key("path of the ball centres")
    grooves: GrooveKeys = key("section of both grooves", example={"conformity": 0.56})
    balls: BallSizeKeys = key("the balls")
    motion: CarriageKeys = key("motion of the carriage")
    friction: common.RubbingKeys = key("friction")


class LinearPairKeys(LinearKeys):
    """Two balls of a linear bearing."""

    kind: Literal["linear pair"] = key("what the scene describes", example="linear pair")
    angles: LinearAngleKeys = key("contact angles")
    load: PairLoadKeys = key("force of the carriage")


class LinearChainKeys(LinearKeys):
    """A chain of balls in a linear bearing."""

    kind: Literal["linear chain"] = key("what the scene describes", example="linear chain")
    load: ChainLoadKeys = key("force of the carriage")
    chain: Annotated[list[ChainBallKeys], Field(min_length=1, max_length=500)] = key("balls in order along the track")


@dataclass(frozen=True)
class LinearScene(KindScene):
    """N balls: contact angles (N, 4) [rad] before loading, vertical force [N], side force ratios (N,).

    gap (N-1,) [m] between neighbours.
    """

    bearing: LinearBearing
    angles: Array
    vertical: float
    side: Array
    distribution: Loads
    gap: Array


@dataclass(frozen=True)
class LinearPairScene(LinearScene):
    """Two balls whose bottom contact angles are off by ``deviation`` [rad]."""

    kind: ClassVar[str] = "linear pair"
    deviation: float


@dataclass(frozen=True)
class LinearChainScene(LinearScene):
    """A chain of balls."""

    kind: ClassVar[str] = "linear chain"


# --- what a scene may not describe


def faults(keys: LinearPairKeys | LinearChainKeys) -> Iterator[Fault]:
    """Contradictory choices and bodies that the model cannot treat."""
    wrong = [*common.material_faults(keys.material), *common.groove_faults(keys.grooves, keys.balls, "grooves")]
    yield from wrong or _linear_faults(keys)


def _linear_faults(keys: LinearPairKeys | LinearChainKeys) -> Iterator[Fault]:
    angles, side, gap = _balls(keys)
    chain = isinstance(keys, LinearChainKeys)
    if gap[-1] != 0.0:
        where = f"chain[{len(gap) - 1}].gap"
        yield Fault((where,), "none for the last ball", "the last ball has no next one: remove its gap")
    for i, row in enumerate(angles):
        if row.min() <= 0.0 or row.max() >= 0.5 * pi:
            where = f"chain[{i}].angle_deviations" if chain else "angles.deviation"
            advice = f"the nominal contact angle is {degrees(keys.track.contact_angle):.6g} deg"
            yield Fault((where,), "contact angles above 0 deg, below 90 deg", advice)
            return
        low, high = side_range(row, keys.track.contact_angle, keys.load.distribution)
        if not low <= side[i] <= high:
            where = f"chain[{i}].side_force_ratio" if chain else "load.side_force_ratio"
            least, most = (low, high) if chain or i == 0 else (-high, -low)
            advice = 'a contact would have to pull: take less, or distribution = "elastic"'
            yield Fault((where,), f"{least:.4g} to {most:.4g} at these contact angles", advice)
            return


def side_range(angles: Array, nominal: float, distribution: Loads) -> tuple[float, float]:
    """Least and greatest side force ratio of a ball at contact angles (4,) without a contact that pulls."""
    if distribution == "elastic":
        return -np.inf, np.inf
    if distribution == "diagonal":
        return -tan(nominal), tan(nominal)
    bl, br, tr, tl = (tan(float(a)) for a in angles)
    return -min(bl, tr), min(br, tl)


# --- records


def _balls(keys: LinearPairKeys | LinearChainKeys) -> tuple[Array, Array, Array]:
    """Contact angles (N, 4) [rad], side force ratios (N,), gaps after each ball (N,) [m]."""
    if isinstance(keys, LinearPairKeys):
        two = np.full(2, keys.angles.deviation)
        turned, rho = deviations(two, mated=keys.angles.mated), keys.load.side_force_ratio
        return keys.track.contact_angle + turned, np.array([rho, -rho]), np.zeros(2)
    turned = np.array([b.angle_deviations for b in keys.chain])
    side, gap = (np.array([getattr(b, name) for b in keys.chain]) for name in ("side_force_ratio", "gap"))
    return keys.track.contact_angle + turned, side, gap


def record(keys: LinearPairKeys | LinearChainKeys, name: str) -> LinearScene:
    """The scene of faultless keys."""
    f, radius = keys.friction, keys.balls.radius
    bearing = LinearBearing(
        radius,
        keys.grooves.conformity or 0.5 * common.groove_radius(keys.grooves, keys.balls) / radius,
        keys.track.contact_angle,
        keys.motion.carriage,
        f.coefficient,
        f.coefficient if f.balls is None else f.balls,
        *common.elastic(keys.material),
    )
    angles, side, gap = _balls(keys)
    force, how, head = keys.load.vertical_force, keys.load.distribution, head_of(keys, name)
    if isinstance(keys, LinearPairKeys):
        return LinearPairScene(*head, bearing, angles, force, side, how, gap[:-1], keys.angles.deviation)
    return LinearChainScene(*head, bearing, angles, force, side, how, gap[:-1])
