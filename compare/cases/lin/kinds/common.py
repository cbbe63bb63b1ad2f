"""Keys, records and checks shared by all kinds of scenes for which only friction is computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal, TypeVar

import numpy as np

from rollbench.compare.errors import escape_unprintable
from rollbench.compare.scenes import keys as scenes_keys
from rollbench.compare.scenes.fault import Fault, length_text
from rollbench.compare.scenes.key_checks import groove_definition_faults
from rollbench.compare.scenes.keys import SceneFileTable
from rollbench.compare.scenes.kinds import FrictionSceneKeys
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.meshes.ranges import Coefficient, ContactAngle, Deviation, Lead, Modulus, QuantityRange, Radius
from rollbench.meshes.record_keys import scene_key
from rollbench.meshes.scene_text import Table, with_unit
from rollbench.meshes.stated import groove_table

#: Name, title, source of the data, and assumptions of a scene.
Head = tuple[str, str, str, tuple[str, ...]]


def head_of_scene(keys: FrictionSceneKeys, name: str) -> Head:
    """Return the first fields of the record of a friction scene: ``name``, title, source of the data, and assumptions."""
    assumed = tuple(map(escape_unprintable, keys.assumed))
    return name, escape_unprintable(keys.title), escape_unprintable(keys.source), assumed


#: Force that presses a part onto balls [N], above zero.
Pressing = Annotated[float, QuantityRange("force", "0 N", "1 MN", "100 N", lower_limit_excluded=True)]

#: Force on the screw [N].
AxialLoad = Annotated[float, QuantityRange("force", "-1 MN", "1 MN", "50 N")]

#: Gap between neighbouring balls, or length of a return tube [m].
Gap = Annotated[float, QuantityRange("length", "0 mm", "1 m", "0.5 mm")]

#: Deviation theta of a contact angle from the nominal one [rad].
Theta = Annotated[float, QuantityRange("angle", "-15 deg", "15 deg", "2 deg")]


class BallRadiusErrorKeys(SceneFileTable):
    """Manufacturing errors of the balls: here only an oversize, which all ball radii have in common."""

    balls: scenes_keys.BallOversizeKeys = scene_key(
        "errors of the ball radii", {"oversize": "1.7 um"}, default=scenes_keys.BallOversizeKeys()
    )


class HertzConstantKeys(SceneFileTable):
    """Source of the Hertz constants of the contacts: exact calculation, or Lin's Table B.1 with its errors."""

    hertz: Literal["nominal", "as printed"] = scene_key(
        "Hertz constants: exact at the nominal contact angle, or as printed with the errors of Lin's Table B.1",
        "nominal",
        default="nominal",
    )


class BallFrictionKeys(scenes_keys.CoulombFrictionKeys):
    """Coulomb friction between balls and grooves, and between neighbouring balls."""

    balls: Coefficient | None = scene_key(
        "coefficient of friction between balls; if left out, that between balls and grooves", default=None
    )


class EqualGrooveKeys(SceneFileTable):
    """Ball path, balls, and grooves of equal radius on both parts of a bearing or screw."""

    track: scenes_keys.BallPathKeys = scene_key("path of the ball centres, of zero lead")
    screw: scenes_keys.GrooveKeys = scene_key("groove of the screw, or of the inner ring", {"conformity": 0.54})
    nut: scenes_keys.GrooveKeys = scene_key(
        "groove of the nut, or of the outer ring, with the same radius", {"conformity": 0.54}
    )
    balls: scenes_keys.BallSizeKeys = scene_key("size of the balls")
    errors: BallRadiusErrorKeys = scene_key(
        "geometric errors", {"balls": {"oversize": "1.7 um"}}, default=BallRadiusErrorKeys()
    )


class HertzSceneKeys(FrictionSceneKeys):
    """Scene for which only friction is computed, with a choice of the Hertz constants."""

    ingredients: HertzConstantKeys = scene_key(
        "options of the low-order model", {"hertz": "nominal"}, default=HertzConstantKeys()
    )


def material_faults(material: scenes_keys.MaterialKeys) -> Iterator[Fault]:
    """Yield a fault for a material in a scene file without Young's modulus or without Poisson's ratio."""
    for name, text in (("youngs_modulus", '"210 GPa"'), ("poissons_ratio", "0.28")):
        if getattr(material, name) is None:
            yield Fault((f"material.{name}",), "a value", f"write {name} = {text} under [material]", "nothing")


def elastic_constants(material: scenes_keys.MaterialKeys) -> tuple[float, float]:
    """Return Young's modulus [Pa] and Poisson's ratio from the validated keys of a material."""
    return material.youngs_modulus or 0.0, material.poissons_ratio or 0.0


def groove_radius_faults(groove: scenes_keys.GrooveKeys, balls: scenes_keys.BallSizeKeys, table: str) -> Iterator[Fault]:
    """Yield a fault for a groove whose radius is stated twice, not at all, or not above the ball radius.

    ``groove``, ``balls``: tables with the keys of the groove and of the balls; ``table``: name of the groove's table in the
    file.
    """
    wrong = list(groove_definition_faults(groove, table))
    yield from wrong
    if not wrong and groove.radius_for(balls.radius) <= balls.radius:
        advice = "choose a groove radius above the ball's radius"
        yield Fault((f"{table}.groove_radius", f"{table}.conformity"), f"above {length_text(balls.radius)}", advice)


#: Class of the record of the grooves of a screw or bearing.
Grooves = TypeVar("Grooves", bound=ScrewGroove)


def grooves_from_keys(
    record: type[Grooves], keys: Any, part: EqualGrooveKeys, lead: float, speeds: tuple[float, float], **more: Any
) -> Grooves:
    """Return grooves, balls, speeds and friction of a ball screw or bearing as a ``record`` of the friction solvers.

    ``keys``: keys of the whole scene, with material, friction and Hertz constants; ``part``: tables of the screw or
    bearing; ``lead``: its lead, 0 for a bearing, negative for a left-hand helix [m]; ``speeds``: angular speeds of nut and
    screw, or outer and inner ring [rad/s]; ``more``: further fields of the record.
    """
    return record(
        part.balls.radius,
        part.screw.radius_for(part.balls.radius),
        part.track.pitch_radius,
        lead,
        part.track.contact_angle,
        *elastic_constants(keys.material),
        keys.friction.coefficient,
        *speeds,
        hertz="right" if keys.ingredients.hertz == "nominal" else "as printed",
        **more,
    )


def groove_and_path_faults(keys: EqualGrooveKeys, prefix: str = "", *, is_bearing: bool) -> Iterator[Fault]:
    """Yield the faults of the keys for grooves, ball path and ball oversize of a bearing or screw.

    Parameters
    ----------
    keys
        Tables of the bearing or screw.
    prefix
        Prefix of the names of its tables, such as ``four_point.``.
    is_bearing
        Whether it is a bearing, whose lead must be zero; else the lead must be positive.
    """
    track, radius = keys.track, keys.screw.radius_for(keys.balls.radius)
    for name, groove in (("screw", keys.screw), ("nut", keys.nut)):
        wrong = list(groove_radius_faults(groove, keys.balls, prefix + name))
        yield from wrong
        if wrong:
            return
    if abs(keys.nut.radius_for(keys.balls.radius) / radius - 1.0) > 1e-12:
        advice = 'give both grooves the same radius: only the kinds "ball screw" and "bearing" allow different ones'
        where = (f"{prefix}nut.groove_radius", f"{prefix}nut.conformity")
        yield Fault(where, f"{length_text(radius)}, as for the groove of the screw or inner ring", advice)
    if is_bearing and track.lead != 0.0:
        yield Fault((f"{prefix}track.lead",), '"0 mm"', "write 0 mm; this kind describes bearing rings, which have no lead")
    if not is_bearing and track.lead == 0.0:
        yield Fault((f"{prefix}track.lead",), "above 0 mm", "give the lead; this kind describes a ball screw")
    if track.pitch_radius <= radius:
        advice = "correct the radius; the pitch circle is larger than the groove radius"
        yield Fault((f"{prefix}track.pitch_radius",), f"above {length_text(radius)}", advice)
    yield from displacement_faults(radius - keys.balls.radius, keys.errors.balls.oversize, f"{prefix}errors.balls.oversize")


def displacement_faults(limit: float, displacement: float, key_name: str) -> Iterator[Fault]:
    """Yield a fault if a ball oversize, or a displacement of the inner ring, reaches groove radius minus ball radius.

    ``limit``: groove radius minus ball radius [m]; ``displacement``: the oversize or displacement [m]; ``key_name``: key of
    the scene file that states it.
    """
    if abs(displacement) >= limit:
        advice = "choose a smaller value; the models hold for small displacements of the ball's centre"
        allowed = f"between -{length_text(limit)} and {length_text(limit)}, groove radius less ball radius"
        yield Fault((key_name,), allowed, advice)


def missing_hertz_constant_faults(groove: ScrewGroove, prefix: str = "") -> Iterator[Fault]:
    """Yield a fault for grooves with dimensions for which no Hertz constants exist.

    ``prefix``: prefix of the names of the grooves' tables in the file, such as ``four_point.``.
    """
    try:
        with np.errstate(invalid="ignore"):
            if np.all(np.isfinite(groove.contact_hertz_constants.C)):
                return
    except ValueError:
        pass
    if groove.hertz == "as printed":
        advice = (
            "choose nominal constants; the printed formulas have no solution here, usually because the helix is too steep"
        )
        yield Fault(("ingredients.hertz",), '"nominal" for these grooves', advice)
        return
    keys = (f"{prefix}screw.groove_radius", f"{prefix}screw.conformity")
    yield Fault(keys, "a groove radius clearly above the ball's radius", "choose a larger groove radius")


def material_table(young: float, poisson: float) -> Table:
    """Return the table ``material`` of a scene file from Young's modulus [Pa] and Poisson's ratio."""
    return {"youngs_modulus": with_unit(Modulus, young), "poissons_ratio": poisson}


def track_and_groove_tables(groove: ScrewGroove, oversize: float) -> Table:
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


def hertz_table(groove: ScrewGroove) -> Table:
    """Return the table of a scene file that chooses Lin's printed Hertz constants; empty for the nominal constants."""
    return {"ingredients": {"hertz": "as printed"}} if groove.hertz == "as printed" else {}
