"""List of the kinds of scenes for which only friction is computed, and conversion of such scenes to scene files."""

from __future__ import annotations

from typing import Annotated, Any, Union

import numpy as np
from pydantic import Discriminator, Tag, TypeAdapter

from rollbench.compare.scenes.duty_cycle import AXIS, KINDS
from rollbench.compare.scenes.friction_kinds import bearings, screw_balls
from rollbench.compare.scenes.friction_kinds.common import FrictionScene, FrictionSceneKind, Theta
from rollbench.compare.scenes.keys import schema_without_null
from rollbench.compare.scenes.schema import SceneKeys, ShaftSceneKeys
from rollbench.lowfi.friction.bearing import DIAGONAL, BearingCase
from rollbench.lowfi.friction.linear.bearing import contact_angle_deviations
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.ranges import Azimuth, Clearance, ContactAngle, Deviation, Force, Lead, Modulus, Radius, Size, Turning
from rollbench.meshes.scene_text import groove_table, keys_of_record, with_unit, without_empty_values

#: How the file of each kind of friction scene is read, by the name of the kind (`duty_cycle.KINDS`).
TABLE = {
    "bearing ball": FrictionSceneKind(bearings.BearingBallKeys, bearings.bearing_ball_faults, bearings.bearing_ball_scene),
    "bearing pair": FrictionSceneKind(bearings.BearingPairKeys, bearings.bearing_pair_faults, bearings.bearing_pair_scene),
    "linear pair": FrictionSceneKind(
        bearings.LinearPairKeys, bearings.linear_bearing_faults, bearings.linear_bearing_scene
    ),
    "linear chain": FrictionSceneKind(
        bearings.LinearChainKeys, bearings.linear_bearing_faults, bearings.linear_bearing_scene
    ),
    "screw pair": FrictionSceneKind(screw_balls.ScrewPairKeys, screw_balls.ball_screw_faults, screw_balls.screw_pair_scene),
    "screw run": FrictionSceneKind(
        screw_balls.ScrewSimulationKeys, screw_balls.ball_screw_faults, screw_balls.screw_run_scene
    ),
}


def _schema_tag_of_kind(value: Any) -> str:
    """Return the kind of a scene for the choice of its JSON Schema; "whole" for a ball screw or bearing.

    ``value``: tables of a scene file, or its validated keys.
    """
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    if kind == AXIS or (isinstance(value, dict) and "sets" in value):
        return AXIS
    return str(kind) if kind in KINDS else "whole"


def scene_json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files of all kinds, with description, unit and range of every key."""
    by_tag = {"whole": SceneKeys} | {name: TABLE[name].key_class for name in KINDS} | {AXIS: ShaftSceneKeys}
    every: Any = Annotated[
        Union[tuple(Annotated[of, Tag(name)] for name, of in by_tag.items())],  # noqa: UP007
        Discriminator(_schema_tag_of_kind),
    ]
    schema: dict[str, Any] = schema_without_null(TypeAdapter[Any](every).json_schema())
    name = schema["$defs"]["MaterialKeys"]["properties"]["name"]  # any name is allowed if both constants are given
    name["anyOf"] = [{"enum": name.pop("enum")}, {"type": "string"}]
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, "$id": "urn:rollbench:scene", "title": "rollbench scene"} | schema


#: Keys and values of a scene file or of one of its tables.
Table = dict[str, Any]


def scene_file_tables_of_friction_scene(scene: FrictionScene) -> Table:
    """Return the keys and tables of the scene file of a scene for which only friction is computed."""
    head = without_empty_values(title=scene.title, source=scene.source, assumed=[*scene.assumed]) | {"kind": scene.kind}
    match scene:
        case bearings.BearingBallScene():
            return head | _bearing_ball_tables(scene)
        case bearings.BearingPairScene():
            return head | _bearing_pair_tables(scene)
        case bearings.LinearBearingScene():
            return head | _linear_bearing_tables(scene)
        case screw_balls.ScrewPairScene():
            angles = {"deviations": [with_unit(Theta, x) for x in scene.pair.theta], "pattern": [*scene.pair.pattern[0]]}
            return head | _shared_screw_tables(scene.pair.groove, scene.pair, angles)
        case screw_balls.ScrewRunScene():
            return head | _screw_run_tables(scene)
    raise AssertionError(scene.kind)


def _material_table(young: float, poisson: float) -> Table:
    """Return the table ``material`` of a scene file from Young's modulus [Pa] and Poisson's ratio."""
    return {"youngs_modulus": with_unit(Modulus, young), "poissons_ratio": poisson}


def _track_and_groove_tables(groove: ScrewGroove, oversize: float) -> Table:
    """Return the tables of ball path, grooves and balls of a scene file.

    ``groove``: grooves and balls; ``oversize``: oversize of the ball radius [m].
    """
    section = groove_table(groove.groove_radius, groove.ball_radius)
    path = {"pitch_radius": with_unit(Radius, groove.pitch_radius), "lead": with_unit(Lead, abs(groove.lead))}
    path |= {"hand": "left"} if groove.lead < 0.0 else {}
    return {
        "track": path | {"contact_angle": with_unit(ContactAngle, groove.contact_angle)},
        "screw": section,
        "nut": section,
        "balls": {"radius": with_unit(Radius, groove.ball_radius)},
        **({"errors": {"balls": {"oversize": with_unit(Deviation, oversize)}}} if oversize else {}),
    }


def _hertz_table(groove: ScrewGroove) -> Table:
    """Return the table of a scene file that chooses Lin's printed Hertz constants; empty for the nominal constants."""
    return {"ingredients": {"hertz": "as printed"}} if groove.hertz == "as printed" else {}


def _bearing_ball_tables(scene: bearings.BearingBallScene) -> Table:
    """Return the tables of the scene file of one bearing ball."""
    b = scene.bearing
    creep = with_unit(bearings.Creep, scene.creep) if scene.creep else None
    law = without_empty_values(law=scene.law, creep=creep, sharpness=scene.sharpness or None, map_step=scene.map_step)
    return {
        "material": _material_table(b.young, b.poisson),
        **_track_and_groove_tables(b, 0.0 - b.clearance),
        **_hertz_table(b),
        "load": {
            "axial_force": with_unit(Force, scene.force),
            "radial_displacement": with_unit(Deviation, scene.displacement),
        },
        "motion": {"speed": with_unit(Turning, b.screw_speed)},
        "friction": {"coefficient": b.mu, **law},
    }


def _bearing_pair_tables(scene: bearings.BearingPairScene) -> Table:
    """Return the tables of the scene file of a four-point and a double-row bearing."""
    four, double = scene.four_point, scene.double_row
    groove = four.groove
    first, second = double.rows
    arrangement = "face to face" if first.contacts == DIAGONAL else "back to back"
    rows = {"distance": with_unit(Size, second.place - first.place), "arrangement": arrangement}
    load = {"force": with_unit(Force, four.force), "angles": [with_unit(ContactAngle, float(x)) for x in scene.angle]}
    return {
        "material": _material_table(groove.young, groove.poisson),
        "four_point": _tables_of_one_bearing(four),
        "double_row": _tables_of_one_bearing(double) | {"rows": rows},
        "load": load | {"tilt": four.tilt},
        "motion": {"speed": with_unit(Turning, groove.screw_speed)},
        "friction": {"coefficient": groove.mu},
        **_hertz_table(groove),
    }


def _tables_of_one_bearing(case: BearingCase) -> Table:
    """Return the scene-file tables of ball path, grooves and balls for one of the two bearings of a scene."""
    bodies = _track_and_groove_tables(case.groove, 0.0 - case.clearance)
    return bodies | {"balls": bodies["balls"] | {"count": case.count}}


def _linear_bearing_tables(scene: bearings.LinearBearingScene) -> Table:
    """Return the tables of the scene file of balls in a linear bearing."""
    b = scene.bearing
    load = {"vertical_force": with_unit(Force, scene.vertical), "distribution": scene.distribution}
    table = {
        "material": _material_table(b.young, b.poisson),
        "track": {"contact_angle": with_unit(ContactAngle, b.contact_angle)},
        "grooves": {"conformity": b.conformity},
        "balls": {"radius": with_unit(Radius, b.ball_radius)},
        "motion": {"carriage": with_unit(bearings.Speed, b.speed)},
        "friction": {"coefficient": b.mu} | ({} if b.mu_balls == b.mu else {"balls": b.mu_balls}),
    }
    if isinstance(scene, bearings.LinearPairScene):
        mated = b.contact_angle + contact_angle_deviations(np.full(2, scene.deviation), mated=True)
        angles = {"deviation": with_unit(Theta, scene.deviation), "mated": bool(np.array_equal(mated, scene.angles))}
        return table | {"angles": angles, "load": load | {"side_force_ratio": float(scene.side[0])}}
    chain = [
        {
            "side_force_ratio": float(side),
            "angle_deviations": [with_unit(Theta, float(x) - b.contact_angle, b.contact_angle) for x in row],
            "gap": with_unit(Clearance, float(gap)),
        }
        for side, row, gap in zip(scene.side, scene.angles, [*scene.gap, 0.0], strict=True)
    ]
    return table | {"load": load, "chain": chain}


def _shared_screw_tables(groove: ScrewGroove, pair_or_run: Any, angles: Table) -> Table:
    """Return the tables that scene files of two balls of a screw and of a simulated whole screw have in common.

    ``groove``: grooves, balls, speeds and friction; ``pair_or_run``: record of the two balls or of the simulation, with
    ball oversize, force on the screw, direction in which the screw can move, and bodies that friction displaces;
    ``angles``: table of the contact angles.
    """
    by_nut = groove.nut_speed != 0.0
    speed = {"speed": with_unit(Turning, groove.nut_speed if by_nut else groove.screw_speed)}
    direction = next(name for name, letter in screw_balls.FREE_TRANSLATION.items() if letter == pair_or_run.free)
    return {
        "material": _material_table(groove.young, groove.poisson),
        **_track_and_groove_tables(groove, pair_or_run.oversize),
        "angles": angles,
        **_hertz_table(groove),
        "load": {"force": with_unit(Force, pair_or_run.force[0]), "direction": direction},
        "motion": speed | ({"turns": "nut"} if by_nut else {}),
        "friction": {
            "coefficient": groove.mu,
            **without_empty_values(balls=groove.mu_balls),
            "coupling": pair_or_run.coupling,
        },
    }


def _screw_run_tables(scene: screw_balls.ScrewRunScene) -> Table:
    """Return the tables of the scene file for a transient simulation of a whole ball screw."""
    run = scene.run
    angles: Table = {"amplitude": with_unit(Theta, run.amplitude), "cycles_per_turn": run.cycles}
    angles |= {"phase": with_unit(Azimuth, run.phase), "pattern": [*run.pattern], "follows": run.follows}
    table, radius = _shared_screw_tables(run.groove, run, angles), run.groove.radius
    lengths = (float(f"{run.tube * radius:.{digits}g}") for digits in range(1, 18))
    tube = next((length for length in lengths if length / radius == run.tube), run.tube * radius)
    table["balls"] |= {"count": run.count, "turns": run.turns}
    table["circulation"] = {"return_tube": with_unit(Clearance, tube), "first_ball": run.first}
    return table | {"time": keys_of_record(scene.time) | {"rounds": run.rounds}}
