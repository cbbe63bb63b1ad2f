"""Table of the kinds of scenes for which only friction is computed, and conversion of their records to scene files."""

from __future__ import annotations

from typing import Annotated, Any, Union

import numpy as np
from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.scenes.duty_cycle import AXIS, KINDS
from rollbench.compare.scenes.friction_kinds import bearings, screw_balls
from rollbench.compare.scenes.friction_kinds.bearings import (
    BearingBallKeys,
    BearingBallScene,
    BearingPairKeys,
    BearingPairScene,
    Creep,
    LinearChainKeys,
    LinearPairKeys,
    LinearPairScene,
    LinearScene,
    Speed,
)
from rollbench.compare.scenes.friction_kinds.common import KindScene, SceneKind, Theta
from rollbench.compare.scenes.friction_kinds.screw_balls import (
    FREE_TRANSLATION,
    ScrewPairKeys,
    ScrewPairScene,
    ScrewRunKeys,
    ScrewRunScene,
)
from rollbench.compare.scenes.keys import without_null
from rollbench.compare.scenes.schema import AxisKeys, SceneKeys
from rollbench.lowfi.friction.bearing import DIAGONAL, BearingCase
from rollbench.lowfi.friction.linear.bearing import angle_deviations
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.ranges import (
    Azimuth,
    Clearance,
    ContactAngle,
    Deviation,
    Force,
    Lead,
    Modulus,
    Radius,
    Size,
    Turning,
    quantity_of,
)
from rollbench.meshes.scene_text import given_keys, groove_table, table_of, text_of

TABLE = {
    "bearing ball": SceneKind(BearingBallKeys, bearings.bearing_ball_faults, bearings.bearing_ball_record),
    "bearing pair": SceneKind(BearingPairKeys, bearings.bearing_pair_faults, bearings.bearing_pair_record),
    "linear pair": SceneKind(LinearPairKeys, bearings.linear_bearing_faults, bearings.linear_bearing_record),
    "linear chain": SceneKind(LinearChainKeys, bearings.linear_bearing_faults, bearings.linear_bearing_record),
    "screw pair": SceneKind(ScrewPairKeys, screw_balls.ball_screw_faults, screw_balls.screw_pair_record),
    "screw run": SceneKind(ScrewRunKeys, screw_balls.ball_screw_faults, screw_balls.screw_run_record),
}


def kind_named(name: str) -> SceneKind:
    """Return keys, check and maker of the record of a kind of scenes; ``name``: one of `duty_cycle.KINDS`."""
    return TABLE[name]


def _kind_tag(value: Any) -> str:
    """Return the name of the kind by which the JSON Schema distinguishes scenes; "whole" for ball screws and bearings."""
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in KINDS else "whole"


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files of all kinds, with description, unit and range of every key."""
    by_tag = {"whole": SceneKeys} | {name: kind_named(name).keys for name in KINDS} | {AXIS: AxisKeys}
    every: Any = Annotated[Union[tuple(Annotated[of, Tag(name)] for name, of in by_tag.items())], Discriminator(_kind_tag)]  # noqa: UP007
    schema: dict[str, Any] = without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # any name is allowed if both constants are given
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema


Table = dict[str, Any]


def scene_tables(scene: KindScene) -> Table:
    """Return the keys and tables of a scene file from the record of a scene for friction."""
    head = given_keys(title=scene.title, source=scene.source, assumed=[*scene.assumed]) | {"kind": scene.kind}
    match scene:
        case BearingBallScene():
            return head | _ball_tables(scene)
        case BearingPairScene():
            return head | _bearing_pair_tables(scene)
        case LinearScene():
            return head | _linear_tables(scene)
        case ScrewPairScene():
            angles = {"deviations": [text_of(Theta, x) for x in scene.pair.theta], "pattern": [*scene.pair.pattern[0]]}
            return head | _screw_tables(scene.pair.groove, scene.pair, angles)
        case ScrewRunScene():
            return head | _screw_run_tables(scene)
    raise AssertionError(scene.kind)


def _material_table(young: float, poisson: float) -> Table:
    """Return the table of a material from Young's modulus [Pa] and Poisson's ratio."""
    return {"youngs_modulus": text_of(Modulus, young), "poissons_ratio": poisson}


def _body_tables(groove: ScrewGroove, oversize: float) -> Table:
    """Return the tables of ball path, grooves and balls; ``oversize``: oversize of the ball radius [m]."""
    section = groove_table(groove.groove_radius, groove.ball_radius)
    hand = {"hand": "left"} if groove.lead < 0.0 else {}
    path = {"pitch_radius": text_of(Radius, groove.pitch_radius), "lead": text_of(Lead, abs(groove.lead)), **hand}
    return {
        "track": path | {"contact_angle": text_of(ContactAngle, groove.contact_angle)},
        "screw": section,
        "nut": section,
        "balls": {"radius": text_of(Radius, groove.ball_radius)},
        **({"errors": {"balls": {"oversize": text_of(Deviation, oversize)}}} if oversize else {}),
    }


def _hertz_table(groove: ScrewGroove) -> Table:
    """Return the table that chooses the printed Hertz constants; empty for the nominal constants."""
    return {"ingredients": {"hertz": "as printed"}} if groove.hertz == "as printed" else {}


def _ball_tables(scene: BearingBallScene) -> Table:
    """Return the tables of a scene of one bearing ball."""
    b = scene.bearing
    creep = text_of(Creep, scene.creep) if scene.creep else None
    law = given_keys(law=scene.law, creep=creep, sharpness=scene.sharpness or None, map_step=scene.map_step)
    return {
        "material": _material_table(b.young, b.poisson),
        **_body_tables(b, 0.0 - b.clearance),
        **_hertz_table(b),
        "load": {"axial_force": text_of(Force, scene.force), "radial_displacement": text_of(Deviation, scene.displacement)},
        "motion": {"speed": text_of(Turning, b.screw_speed)},
        "friction": {"coefficient": b.mu, **law},
    }


def _bearing_pair_tables(scene: BearingPairScene) -> Table:
    """Return the tables of a scene of a four-point and a double-row bearing."""
    four, double = scene.four_point, scene.double_row
    groove = four.groove
    first, second = double.rows
    arrangement = "face to face" if first.contacts == DIAGONAL else "back to back"
    rows = {"distance": text_of(Size, second.place - first.place), "arrangement": arrangement}
    load = {"force": text_of(Force, four.force), "angles": [text_of(ContactAngle, float(x)) for x in scene.angle]}
    return {
        "material": _material_table(groove.young, groove.poisson),
        "four_point": _ring_tables(four),
        "double_row": _ring_tables(double) | {"rows": rows},
        "load": load | {"tilt": four.tilt},
        "motion": {"speed": text_of(Turning, groove.screw_speed)},
        "friction": {"coefficient": groove.mu},
        **_hertz_table(groove),
    }


def _ring_tables(case: BearingCase) -> Table:
    """Return the tables of ball path, grooves and balls of one of the two bearings of a scene."""
    bodies = _body_tables(case.groove, 0.0 - case.clearance)
    return bodies | {"balls": bodies["balls"] | {"count": case.count}}


def _linear_tables(scene: LinearScene) -> Table:
    """Return the tables of a scene of balls in a linear bearing."""
    b = scene.bearing
    load = {"vertical_force": text_of(Force, scene.vertical), "distribution": scene.distribution}
    table = {
        "material": _material_table(b.young, b.poisson),
        "track": {"contact_angle": text_of(ContactAngle, b.contact_angle)},
        "grooves": {"conformity": b.conformity},
        "balls": {"radius": text_of(Radius, b.ball_radius)},
        "motion": {"carriage": text_of(Speed, b.speed)},
        "friction": {"coefficient": b.mu} | ({} if b.mu_balls == b.mu else {"balls": b.mu_balls}),
    }
    if isinstance(scene, LinearPairScene):
        mated = b.contact_angle + angle_deviations(np.full(2, scene.deviation), mated=True)
        angles = {"deviation": text_of(Theta, scene.deviation), "mated": bool(np.array_equal(mated, scene.angles))}
        return table | {"angles": angles, "load": load | {"side_force_ratio": float(scene.side[0])}}
    chain = [
        {
            "side_force_ratio": float(side),
            "angle_deviations": [quantity_of(Theta).written(float(x) - b.contact_angle, b.contact_angle) for x in row],
            "gap": text_of(Clearance, float(gap)),
        }
        for side, row, gap in zip(scene.side, scene.angles, [*scene.gap, 0.0], strict=True)
    ]
    return table | {"load": load, "chain": chain}


def _screw_tables(groove: ScrewGroove, of: Any, angles: Table) -> Table:
    """Return those tables of a scene file that two balls of a screw and a simulation of a whole screw have in common.

    ``of``: record of the pair or run, with oversize, force, free direction and coupling.
    """
    by_nut = groove.nut_speed != 0.0
    speed = {"speed": text_of(Turning, groove.nut_speed if by_nut else groove.screw_speed)}
    direction = next(name for name, letter in FREE_TRANSLATION.items() if letter == of.free)
    return {
        "material": _material_table(groove.young, groove.poisson),
        **_body_tables(groove, of.oversize),
        "angles": angles,
        **_hertz_table(groove),
        "load": {"force": text_of(Force, of.force[0]), "direction": direction},
        "motion": speed | ({"turns": "nut"} if by_nut else {}),
        "friction": {"coefficient": groove.mu, **given_keys(balls=groove.mu_balls), "coupling": of.coupling},
    }


def _screw_run_tables(scene: ScrewRunScene) -> Table:
    """Return the tables of the scene file for a transient simulation of a whole ball screw."""
    run = scene.run
    angles: Table = {"amplitude": text_of(Theta, run.amplitude), "cycles_per_turn": run.cycles}
    angles |= {"phase": text_of(Azimuth, run.phase), "pattern": [*run.pattern], "follows": run.follows}
    table, radius = _screw_tables(run.groove, run, angles), run.groove.radius
    lengths = (float(f"{run.tube * radius:.{digits}g}") for digits in range(1, 18))
    tube = next((length for length in lengths if length / radius == run.tube), run.tube * radius)
    table["balls"] |= {"count": run.count, "turns": run.turns}
    table["circulation"] = {"return_tube": text_of(Clearance, tube), "first_ball": run.first}
    return table | {"time": table_of(scene.time) | {"rounds": run.rounds}}
