"""Build the record of a shaft with several ball nuts and bearings from the keys of its scene file; errors for faulty keys.

A table ``[[sets]]`` of a file describes one ball nut, one bearing, or equal bearings in an arrangement such as "DBD". Each
bearing of an arrangement becomes one row; all rows are ground to equal gaps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, replace
from itertools import chain
from math import pi
from typing import Any

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import from_keys, key_checks, schema
from rollbench.compare.scenes.body_checks import geometry_faults, position_beyond_end_faults
from rollbench.compare.scenes.fault import TOLERANCE, Fault, length_text, raise_scene_error_for_faults
from rollbench.compare.scenes.keys import record_from_keys
from rollbench.lowfi.rollers import tapered_bearing_of_row
from rollbench.meshes import axis
from rollbench.meshes.one_arc import has_single_arc_grooves, with_single_arc_grooves
from rollbench.meshes.parts import FREEDOMS, Ingredients, Material, Scene, Screw, Support
from rollbench.meshes.ranges import ShareOfLoadRating

#: Values of ``thrust`` for a bearing row that carries axial force in one direction only.
ONE_WAY = ("+z", "-z")
#: Conformity (groove radius over ball diameter) with which the search for a conformity from a rigidity starts.
USUAL_CONFORMITY = 0.52
#: Material of rollers where only their geometry matters, which does not depend on the moduli.
ANY = Material(2e11, 0.3)
#: Least share of the pitch circle that the diameters of tapered rollers fill; usual is 0.75 to 0.95.
LEAST_FILL = 0.1
#: 6 x 6 stiffness matrix of zeros.
NO_STIFFNESS = axis.diagonal_stiffness((0.0,) * 6)


def geometry_faults_of_nuts_and_bearings(scene: Scene | axis.Assembly) -> Iterator[Fault]:
    """Yield the faults of dimensions with which nuts or ball bearings of a scene cannot be built."""
    for one in (scene,) if isinstance(scene, Scene) else (s.parts for s in scene.sets):
        if isinstance(one, Scene):
            yield from geometry_faults(one)


def shaft_scene_from_keys(
    keys: schema.ShaftSceneKeys, raw: Mapping[str, Any], origin: str, name: str
) -> axis.Assembly | Scene:
    """Return the shaft with nuts and bearings that a scene file describes outside its load cases; SceneError for faults.

    If the file describes a single nut or ball bearing that needs no table ``[[sets]]``, a `Scene` is returned.

    Parameters
    ----------
    keys
        Validated keys of the scene file.
    raw
        Tables of the file as read from TOML, for the faulty values in messages.
    origin
        Name of the file, for messages.
    name
        Name of the scene.

    Returns
    -------
    Assembly or Scene
        Record of the shaft.
    """
    raise_scene_error_for_faults(origin, raw, list(_conflicting_key_faults(keys, raw)))
    sets = tuple(_rolling_set_from_keys(keys, i, raw, origin) for i in range(len(keys.sets)))
    raise_scene_error_for_faults(origin, raw, list(_position_faults(keys, sets)))
    if _describes_one_nut_or_bearing(keys):
        names = ("source", "assumed", "supports", "loads", "friction", "motion", "lubricant")
        shared = {name: getattr(keys, name) for name in names}
        whole = replace(_scene_keys_of_nut_or_bearing(keys, keys.sets[0]), **shared)
        raise_scene_error_for_faults(origin, raw, list(key_checks.conflicting_key_faults(whole, raw)))
        return from_keys.scene_from_keys(whole, name)
    heat, ask, shaft = keys.heat, keys.stiffness, keys.screw
    material = from_keys.material_from_keys(shaft.material, keys.material)
    screw = record_from_keys(Screw, shaft, groove_radius=shaft.groove_radius or 0.0, material=material)
    rows = (bearings_of_arrangement(whole, one, len(sets)) for one, whole in zip(keys.sets, sets, strict=True))
    return record_from_keys(
        axis.Assembly,
        keys,
        name=name,
        screw=screw,
        sets=tuple(chain.from_iterable(rows)),
        segments=shaft.plain,
        housings=tuple(record_from_keys(axis.Housing, h, stiffness=_stiffness_from_keys(h)) for h in keys.housings),
        joints=tuple(
            axis.Joint(j.between[0], j.between[1], j.at, _stiffness_from_keys(j) or NO_STIFFNESS) for j in keys.joints
        ),
        supports=tuple(record_from_keys(Support, support) for support in keys.supports),
        ingredients=record_from_keys(Ingredients, keys.ingredients),
        assumed=(*keys.assumed, *_assumptions_on_nuts_and_bearings(keys, sets)),
        friction=None if keys.friction is None else from_keys.friction_from_keys(keys.friction),
        stiffness_at=ask.housing if ask.housing is not None else ask.at,
        thermal_strain=0.0 if heat is None else heat.warming * heat.expansion,
    )


def _assumptions_on_nuts_and_bearings(keys: schema.ShaftSceneKeys, sets: Sequence[axis.RollingSet]) -> Iterator[str]:
    """Yield a sentence on each assumption about a nut or bearing, such as a preload computed from the load rating.

    ``keys``: keys of the scene file; ``sets``: nuts and bearings built from ``keys.sets``, in the same order.
    """
    for one, whole in zip(keys.sets, sets, strict=True):
        if isinstance(whole.parts, Scene):
            yield from whole.parts.assumed
            if isinstance(one.preload, ShareOfLoadRating):
                _, rating = from_keys.preload_force_and_rating_text(whole.parts, one.preload)
                yield f"{whole.name}: preload of {whole.preload:g} N{rating}"


def _describes_one_nut_or_bearing(keys: schema.ShaftSceneKeys) -> bool:
    """Return whether a scene file describes only one nut or ball bearing, and could do so without a table ``[[sets]]``."""
    one = keys.sets[0]
    more = keys.housings or keys.screw.plain or keys.heat or one.carrier or one.offset or one.preload or one.arrangement
    more = more or one.seals or keys.drive != axis.Drive()
    return len(keys.sets) == 1 and not more and one.balls is not None and one.thrust in (None, "both")


def kind_of_nut_or_bearing(set_keys: schema.NutOrBearingKeys) -> str:
    """Return what a table ``[[sets]]`` of a scene file describes: "ball nut", "bearing" or "tapered roller bearing"."""
    if set_keys.rollers is not None:
        return "tapered roller bearing"
    return "bearing" if set_keys.track is not None and set_keys.track.lead == 0.0 else "ball nut"


def _conflicting_key_faults(keys: schema.ShaftSceneKeys, tables: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield faults of a shaft's scene file: keys that exclude or need each other, and names that are missing or used twice.

    These are keys of friction, motion, drive, nuts, bearings, housings and joints, and names of housings to which other
    keys refer.
    """
    if keys.friction is not None:
        yield from key_checks.conflicting_friction_key_faults(keys.friction, tables)
    if keys.motion is not None:
        yield from key_checks.zero_speed_faults(keys.motion)
    yield from _drive_faults(keys)
    for i, one in enumerate(keys.sets):
        yield from _nut_or_bearing_faults(i, one)
    if keys.material.youngs_modulus is None or keys.material.poissons_ratio is None:
        yield Fault(("material",), "youngs_modulus and poissons_ratio", "give both under [material]")
    names = [h.name for h in keys.housings]
    of_cases = [(f"cases[{k}].housings", [h.name for h in case.housings]) for k, case in enumerate(keys.cases)]
    for table, given in (("sets", [s.name for s in keys.sets]), ("housings", names), *of_cases):
        for i, label in enumerate(given):
            if label in given[:i]:
                yield Fault((f"{table}[{i}].name",), "a unique name", "rename one of the two: the name identifies results")
    known = ", ".join(names) or "none is described"
    named: list[tuple[str, str | None]] = [(f"sets[{i}].housing", s.housing) for i, s in enumerate(keys.sets)]
    named += [(f"sets[{i}].carrier", s.carrier) for i, s in enumerate(keys.sets)]
    named += [(f"joints[{i}].between", name) for i, j in enumerate(keys.joints) for name in j.between]
    named += [(f"{table}[{i}].name", name) for table, given in of_cases for i, name in enumerate(given)]
    named.append(("stiffness.housing", keys.stiffness.housing))
    for where, name in named:
        if name is not None and name not in names:
            yield Fault((where,), f"a name under [[housings]] ({known})", "add the housing, or correct the name")
    if keys.stiffness.housing is not None and keys.stiffness.at is not None:
        yield Fault(("stiffness.at",), "either at or housing", "leave one of the two out", "both at and housing")
    for i, h in enumerate(keys.housings):
        yield from _stiffness_faults(h, f"housings[{i}]")
        twice = set(h.fix) & h.displace.given.keys()
        if twice:
            advice = f"leave {', '.join(sorted(twice))} out of fix or of displace"
            yield Fault((f"housings[{i}].fix",), "each degree of freedom once, in fix or in displace", advice)
    for i, j in enumerate(keys.joints):
        yield from _stiffness_faults(j, f"joints[{i}]")
        if j.springs is None and j.matrix is None:
            advice = "add springs or matrix: a joint needs a stiffness"
            yield Fault((f"joints[{i}].springs",), "springs or a matrix", advice, "nothing")
        if j.between[0] == j.between[1]:
            yield Fault(
                (f"joints[{i}].between",), "two different housings", "name another housing: a joint connects two housings"
            )
    if keys.cases:
        yield from from_keys.load_case_faults(keys)


def _drive_faults(keys: schema.ShaftSceneKeys) -> Iterator[Fault]:
    """Yield the faults of the tables [drive] and [lubricant] of a shaft's scene file.

    Faults are a lubricant without bearings; a mass without a nut, or with nuts of different leads; a time of acceleration
    without the speed to be reached; and an efficiency without mass and time of the acceleration.
    """
    leads = {one.track.lead for one in keys.sets if one.track is not None and one.track.lead}
    if keys.lubricant is not None and all(kind_of_nut_or_bearing(one) == "ball nut" for one in keys.sets):
        advice = "leave [lubricant] out: the friction of nuts is given by [friction]"
        yield Fault(("lubricant",), "only together with a bearing among [[sets]]", advice, "a lubricant for nuts only")
    if keys.drive.mass and len(leads) != 1:
        found = f"nuts with leads of {', '.join(map(length_text, sorted(leads)))}" if leads else "a mass without nut"
        advice = "add the nut that moves the mass, or leave the mass out"
        yield Fault(("drive.mass",), "only together with nuts of equal lead", advice, found)
    if keys.drive.time is not None and keys.motion is None:
        advice = 'add the speed that is reached, e.g. speed = "600 rpm" under [motion]'
        yield Fault(("drive.time",), "only together with [motion]", advice)
    if keys.drive.efficiency is not None and not (keys.drive.mass and keys.drive.time):
        advice = "add mass and time of the acceleration, or leave the efficiency out"
        yield Fault(("drive.efficiency",), "only together with drive.mass and drive.time", advice)


def _nut_or_bearing_faults(number: int, set_keys: schema.NutOrBearingKeys) -> Iterator[Fault]:
    """Yield faults of one table ``[[sets]]``, a nut or bearing: keys that exclude or need each other.

    ``set_keys``: keys of the nut or bearing; ``number``: its index, from 0, in the list ``sets`` of the file.
    """
    at = f"sets[{number}]"
    yield from arrangement_faults(at, set_keys)
    balls = {n: getattr(set_keys, n) for n in ("track", "nut", "balls")}
    if set_keys.rollers is not None:
        given = [n for n, x in balls.items() if x is not None]
        if given:
            advice, found = "describe rollers and balls in two [[sets]]", f"both `rollers` and `{given[0]}`"
            yield Fault((f"{at}.{given[0]}",), "either rollers or balls", advice, found)
        if set_keys.carrier is not None:
            advice = "leave carrier out: the inner ring of tapered rollers sits on the shaft"
            yield Fault((f"{at}.carrier",), "no carrier for rollers", advice)
        if set_keys.position is None:
            yield Fault((f"{at}.position",), "a position along the shaft", 'write e.g. position = "30 mm"', "nothing")
        if set_keys.thrust not in ONE_WAY:
            advice = "write the direction of the axial force on the shaft that the row carries"
            yield Fault((f"{at}.thrust",), '"+z" or "-z"', advice, "nothing" if set_keys.thrust is None else "")
        if set_keys.rollers.roller_angle * 2.0 >= set_keys.rollers.cup_angle:
            advice = "check both half angles: the half angle of the cone is cup_angle minus twice roller_angle"
            yield Fault((f"{at}.rollers.roller_angle",), "below half the cup_angle", advice)
        elif (circle := tapered_bearing_of_row(_roller_row_from_keys(set_keys.rollers, ANY)).pitch_diameter) > (
            most := set_keys.rollers.count * set_keys.rollers.diameter / (LEAST_FILL * pi)
        ):
            allowed = f"an angle that gives a pitch circle of at most {length_text(most)}"
            advice = (
                f"correct it, or cup_angle or count: the pitch circle would be {length_text(circle)}, of which the rollers "
                f"fill less than {LEAST_FILL:.0%}"
            )
            yield Fault((f"{at}.rollers.roller_angle",), allowed, advice)
        else:
            yield from _roller_end_faults(f"{at}.rollers", set_keys.rollers)
    else:
        for name, table in balls.items():
            if table is None:
                advice = f"add [sets.{name}], or [sets.rollers] for tapered rollers"
                yield Fault((f"{at}.{name}",), "a table", advice, "nothing")
        if set_keys.position is not None:
            yield Fault((f"{at}.position",), "only together with rollers", "write nut.position for a nut or a ring")
    found_kind = kind_of_nut_or_bearing(set_keys)
    if set_keys.kind not in (None, found_kind):
        yield Fault((f"{at}.kind",), f'"{found_kind}" with these tables', "correct kind, or track.lead")
    if set_keys.preload and set_keys.thrust not in ONE_WAY and set_keys.arrangement is None:
        advice = (
            f'write {at}.thrust = "+z" or "-z", the direction of the axial force of the preload on the shaft, as for each '
            "nut of a double nut; to preload one row in both directions, write errors.balls.oversize instead"
        )
        yield Fault((f"{at}.preload",), 'only together with thrust = "+z" or "-z"', advice)
    if set_keys.preload and set_keys.offset != 0.0:
        advice = "leave offset out: it follows from the preload"
        yield Fault((f"{at}.preload",), "either preload or offset", advice, "both preload and offset")
    if set_keys.thrust == "both" and set_keys.track is not None and set_keys.track.clearance is not None:
        advice = (
            "leave thrust out for a deep-groove bearing, or write the one direction that the row carries: track.clearance "
            "needs grooves of one arc each"
        )
        yield Fault((f"{at}.thrust",), '"deep groove", "+z" or "-z" with track.clearance', advice)
    if set_keys.rollers is not None and isinstance(set_keys.preload, ShareOfLoadRating):
        yield Fault((f"{at}.preload",), "a force", "write the force: the load rating of rollers is not computed")
    if set_keys.carrier is not None and set_keys.carrier == set_keys.housing:
        yield Fault((f"{at}.carrier",), f"another housing than {at}.housing", "name another housing in one of the two keys")


def _roller_end_faults(table_path: str, rollers: schema.TaperedRollerKeys) -> Iterator[Fault]:
    """Yield the faults of keys for the ends of tapered rollers: edge rounding, rib height, and contact with the rib.

    ``table_path``: path of the table of rollers in the file, such as ``sets[0].rollers``; ``rollers``: its keys, of which
    the angles of cup and rollers are checked already.
    """
    if rollers.edge_radius is not None and not 0.005 <= rollers.edge_radius / rollers.diameter <= 0.25:
        low, high = (length_text(share * rollers.diameter) for share in (0.005, 0.25))
        allowed = f"{low} to {high}, 0.005 to 0.25 of the diameter"
        yield Fault((f"{table_path}.edge_radius",), allowed, "check the unit: usual is a tenth of the diameter")
    if rollers.rib_height is not None and rollers.rib_height >= 0.5 * rollers.diameter:
        advice = "write the height of the rib contact above the cone's race, usually 0.05 to 0.2 of the roller's diameter"
        yield Fault((f"{table_path}.rib_height",), f"below {length_text(0.5 * rollers.diameter)}", advice)
    elif rollers.end_radius is not None:
        from rollbench.lowfi.bearings.tapered_roller import rib_height, rib_relative_curvatures

        row = _roller_row_from_keys(rollers, ANY)
        try:
            rib_relative_curvatures(tapered_bearing_of_row(row), rollers.end_radius, rib_height(row))
        except ValueError as error:
            advice = "correct end_radius or rib_height; usual radii are 0.8 to 0.95 of the distance from the apex"
            yield Fault((f"{table_path}.end_radius",), str(error), advice)


def _stiffness_faults(keys: schema.StiffnessKeys, where: str) -> Iterator[Fault]:
    """Yield the faults of a housing's or joint's stiffness: both springs and matrix given, or an invalid matrix.

    ``where``: path of the housing's or joint's table in the file, such as ``joints[0]``.
    """
    if keys.springs is not None and keys.matrix is not None:
        yield Fault((f"{where}.matrix",), "either springs or matrix", "leave one of the two out", "both springs and matrix")
    if keys.matrix is not None:
        try:
            axis.checked_stiffness(np.array(keys.matrix))
        except ValueError as error:
            allowed = "a symmetric matrix without negative eigenvalues"
            advice = f"correct its rows: {str(error)[:1].lower()}{str(error)[1:]}"
            yield Fault((f"{where}.matrix",), allowed, advice, "an invalid matrix")


def _stiffness_from_keys(keys: schema.StiffnessKeys) -> axis.Stiffness | None:
    """Return the 6 x 6 stiffness of a housing or joint from its keys; None if neither springs nor a matrix are given."""
    if keys.matrix is not None:
        return axis.checked_stiffness(np.array(keys.matrix))
    return None if keys.springs is None else axis.diagonal_stiffness(astuple(keys.springs))


def _scene_keys_of_nut_or_bearing(keys: schema.ShaftSceneKeys, set_keys: schema.NutOrBearingKeys) -> schema.SceneKeys:
    """Return the keys of a scene with only one nut or bearing of a shaft, and with the shaft as its screw.

    ``keys``: keys of the shaft's file; ``set_keys``: keys of the nut or bearing, which take precedence for groove, diameter
    and material of the screw. The scene has no supports or loads.
    """
    ring, shaft, nut = set_keys.screw, record_from_keys(schema.ScrewKeys, keys.screw), set_keys.nut
    if ring is not None:
        shaft = replace(
            shaft,
            material=ring.material or shaft.material,
            outer_diameter=ring.outer_diameter or shaft.outer_diameter,
            groove_radius=ring.groove_radius,
            conformity=ring.conformity,
        )
    if set_keys.pair_rigidity is not None and nut is not None:
        # a start value; the rigidity determines the conformity later
        shaft = replace(shaft, groove_radius=None, conformity=USUAL_CONFORMITY)
        nut = replace(nut, conformity=USUAL_CONFORMITY)
    shared: dict[str, Any] = {name: getattr(keys, name) for name in ("title", "material")}
    shared |= {name: getattr(set_keys, name) for name in ("track", "balls", "errors", "rating")}
    shared |= {"screw": shaft, "nut": nut, "ingredients": record_from_keys(Ingredients, keys.ingredients)}
    return schema.SceneKeys(**shared)


def _rolling_set_from_keys(keys: schema.ShaftSceneKeys, i: int, raw: Mapping[str, Any], origin: str) -> axis.RollingSet:
    """Return the nut or bearing that the table ``sets[i]`` of a scene file describes; SceneError for its faults.

    ``keys``: keys of the whole file; ``raw``: tables of the file, for the faulty values in messages; ``origin``: name of
    the file, for messages.
    """
    one = keys.sets[i]
    thrust = one.thrust or "both"
    shared = one.name, kind_of_nut_or_bearing(one)
    if one.rollers is not None:
        row = _roller_row_from_keys(one.rollers, from_keys.material_from_keys(None, keys.material))
        row = replace(row, rating=one.rating)
        of_rollers = (one.housing, one.offset, one.preload, thrust)
        return axis.RollingSet(*shared, row, one.position or 0.0, *of_rollers, seals=one.seals)  # type: ignore[arg-type]
    scene_keys = _scene_keys_of_nut_or_bearing(keys, one)
    if "seed" not in raw["sets"][i].get("errors", {}):  # without a seed in the file, each set draws different errors
        scene_keys = replace(scene_keys, errors=replace(one.errors, seed=i))

    def raise_for(faults: Iterable[Fault]) -> None:
        raise_scene_error_for_faults(origin, raw, [_fault_with_keys_of_shaft_file(f, i, raw) for f in faults])

    raise_for(key_checks.conflicting_key_faults(scene_keys, raw["sets"][i]))
    scene = with_groove_radii_from_rigidity(from_keys.scene_from_keys(scene_keys, one.name), one, origin, f"sets[{i}]")
    raise_for(geometry_faults(scene))
    if one.thrust is None and has_single_arc_grooves(scene):
        scene, thrust = with_single_arc_grooves(scene), "deep groove"
    scene = _with_single_arcs_for_thrust(scene, thrust)
    preload, _ = from_keys.preload_force_and_rating_text(scene, one.preload)
    own_place = one.housing, one.offset, preload, thrust, one.carrier, one.seals
    return axis.RollingSet(*shared, scene, scene.nut.position, *own_place)  # type: ignore[arg-type]


def _roller_row_from_keys(rollers: schema.TaperedRollerKeys, material: Material) -> axis.RollerRow:
    """Return a row of tapered rollers from its keys ``rollers``; ``material``: material of rollers and rings."""
    crown = float("inf") if rollers.crown is None else rollers.crown
    return record_from_keys(axis.RollerRow, rollers, depth=rollers.ring_depth, material=material, crown=crown)


def _with_single_arcs_for_thrust(scene: Scene, thrust: str) -> Scene:
    """Return a ball bearing with one arc per groove; a bearing with ``thrust`` "both", or a nut, is returned unchanged.

    ``thrust``: direction of the axial force on the shaft that the bearing carries: "+z", "-z", "both" or "deep groove".
    """
    if scene.track.lead != 0.0 or thrust == "both":
        return scene
    return replace(scene, track=replace(scene.track, arcs="-z" if thrust == "-z" else "+z"))


def _fault_with_keys_of_shaft_file(fault: Fault, i: int, raw: Mapping[str, Any]) -> Fault:
    """Return a fault of one nut or bearing with its keys named as in the shaft's file, most with the prefix ``sets[i].``.

    ``fault``: fault of a scene that contains only the nut or bearing with the index ``i``; ``raw``: tables of the file.
    """
    inner = "screw" in raw["sets"][i]
    keys = []
    for k in fault.keys:
        of_set = k.split(".")[0] in ("track", "nut", "balls", "errors") or (k.startswith("screw") and inner)
        keys.append(f"sets[{i}].{k}" if of_set else k)
    return replace(fault, keys=tuple(keys))


def _position_faults(keys: schema.ShaftSceneKeys, sets: Sequence[axis.RollingSet]) -> Iterator[Fault]:
    """Yield the faults of positions along a shaft, of its supports, and of loads on housings that cannot move.

    Positions must lie on the shaft, its plain sections (without groove) must not overlap, and each support must fix a
    degree of freedom that no other support at its position fixes. ``sets``: records of the nuts and bearings, in the order
    of ``keys.sets``.
    """
    tables_at = ("supports", "loads", "housings", "joints")
    stations = [(f"{name}[{i}].at", x.at) for name in tables_at for i, x in enumerate(getattr(keys, name))]
    stations += [(f"cases[{k}].loads[{i}].at", x.at) for k, c in enumerate(keys.cases) for i, x in enumerate(c.loads or ())]
    stations += [(f"sets[{i}].position", s.position) for i, s in enumerate(sets) if s.kind == "tapered roller bearing"]
    stations += [(f"screw.plain[{i}].end", p.end) for i, p in enumerate(keys.screw.plain)]
    if keys.stiffness.at is not None:
        stations.append(("stiffness.at", keys.stiffness.at))
    yield from position_beyond_end_faults(stations, keys.screw.length, "shaft")
    end = 0.0
    for i, p in enumerate(keys.screw.plain):
        if p.start < end - TOLERANCE or p.end <= p.start:
            allowed = f"from {length_text(end)} to below {length_text(p.end)}, the end of this section"
            advice = "list the plain sections from left to right, without overlap"
            yield Fault((f"screw.plain[{i}].start",), allowed, advice)
        if p.bore >= p.diameter:
            yield Fault((f"screw.plain[{i}].bore",), f"below {length_text(p.diameter)}", "leave material around the hole")
        end = max(end, p.end)
    stands = {h.name for h in keys.housings if set(h.fix) == set(FREEDOMS)}
    tables: list[tuple[str, Sequence[schema.HousingKeys | schema.LoadCaseHousingKeys]]] = [("housings", keys.housings)]
    tables += [(f"cases[{k}].housings", c.housings) for k, c in enumerate(keys.cases)]
    for table, housings in tables:
        for i, h in enumerate(housings):
            if h.name in stands and (any(h.force) or any(h.moment)):
                allowed = "no load on a housing whose six degrees of freedom are all fixed"
                advice = "remove a degree of freedom from `fix`, or leave the load out"
                yield Fault((f"{table}[{i}].force",), allowed, advice)
    for i, one in enumerate(keys.sets):
        if one.carrier in stands:
            advice = "remove a degree of freedom from the housing's `fix`, or leave this entry out"
            yield Fault((f"sets[{i}].carrier",), "a housing that can move", advice)
    yield from key_checks.support_faults(keys.supports)


# --- arrangements of bearings, such as "DBD"


def arrangement_faults(set_path: str, set_keys: schema.NutOrBearingKeys) -> Iterator[Fault]:
    """Yield the faults of keys of a bearing that are allowed only with an arrangement such as "DBD", or only without one.

    ``set_path``: path of the bearing's table in the file, such as ``sets[0]``; ``set_keys``: the keys of this table.
    """
    given = set_keys.arrangement is not None
    if set_keys.pair_preload and not given:
        advice = 'write e.g. arrangement = "DB", or give preload in its place'
        yield Fault((f"{set_path}.pair_preload",), "only together with arrangement", advice)
    if set_keys.pair_preload and set_keys.preload:
        advice = "leave one of the two out: one follows from the other"
        yield Fault((f"{set_path}.preload",), "either preload or pair_preload", advice, "both preload and pair_preload")
    if set_keys.pair_rigidity is not None:
        if not set_keys.pair_preload:
            advice = "write the preload at which the pair has this rigidity"
            yield Fault((f"{set_path}.pair_rigidity",), "only together with pair_preload", advice)
        if any(x is not None and (x.conformity or x.groove_radius) for x in (set_keys.screw, set_keys.nut)):
            advice = "leave conformity and groove_radius out: they follow from the rigidity"
            yield Fault((f"{set_path}.pair_rigidity",), "only without conformity and groove_radius of this bearing", advice)
        if set_keys.track is not None and set_keys.track.clearance is not None:
            advice = "write contact_angle in place of clearance: rigidity and clearance both follow from the grooves"
            yield Fault((f"{set_path}.pair_rigidity",), "only together with track.contact_angle", advice)
    if not given:
        return
    if set_keys.rollers is not None or (set_keys.track is not None and set_keys.track.lead != 0.0):
        advice = "leave arrangement out: describe each row of rollers and each nut as a set"
        yield Fault((f"{set_path}.arrangement",), "only for ball bearings", advice)
    for key, written in (("thrust", set_keys.thrust is not None), ("offset", set_keys.offset != 0.0)):
        if written:
            advice = f"leave {key} out: it follows from the arrangement for every row"
            yield Fault((f"{set_path}.{key}",), "only without arrangement", advice)
    if (set_keys.preload or set_keys.pair_preload) and len(set(axis.ARRANGEMENTS[set_keys.arrangement or ""])) == 1:
        advice = "leave the preload out, or name another arrangement: tandem bearings have no opposite row to press against"
        key = "preload" if set_keys.preload else "pair_preload"
        yield Fault((f"{set_path}.{key}",), "only in an arrangement whose rows carry in both directions", advice)


def preload_of_arrangement(arrangement: str, pair_preload: float) -> float:
    """Return the preload P [N] of an arrangement of equal bearings, from the preload F of a pair of them.

    P is the axial force in each of the two directions. Mounting a pair closes a gap of twice the deflection of one bearing.
    In an arrangement the gap between opposite rows is as large as in a pair; the n_1 rows of one direction carry P
    together, and so do the n_2 rows of the other direction: P^(2/3) (n_1^(-2/3) + n_2^(-2/3)) = 2 F^(2/3), at a constant
    contact angle.

    Parameters
    ----------
    arrangement
        Name of an arrangement with rows in both directions, a key of `ARRANGEMENTS`, such as ``DBD``.
    pair_preload
        Preload F of a pair of these bearings [N].
    """
    ways = axis.ARRANGEMENTS[arrangement]
    shared = sum(ways.count(way) ** (-2.0 / 3.0) for way in set(ways))
    return float(pair_preload * (2.0 / shared) ** 1.5)


def bearings_of_arrangement(
    single_bearing: axis.RollingSet, set_keys: schema.NutOrBearingKeys, seed_step: int
) -> Iterator[axis.RollingSet]:
    """Yield each bearing of an arrangement, side by side about the position of the arrangement.

    Without an arrangement, only ``single_bearing`` is yielded.

    Parameters
    ----------
    single_bearing
        One bearing of the arrangement, at the position of the arrangement's middle; or a nut.
    set_keys
        Keys of the table ``[[sets]]`` that describes the arrangement or the nut.
    seed_step
        Difference between the seeds of the random errors of successive bearings.
    """
    if set_keys.arrangement is None or not isinstance(single_bearing.parts, Scene):
        yield single_bearing
        return
    ways, parts = axis.ARRANGEMENTS[set_keys.arrangement], single_bearing.parts
    total = single_bearing.preload
    if set_keys.pair_preload:
        total = preload_of_arrangement(set_keys.arrangement, set_keys.pair_preload)
    for k, way in enumerate(ways):
        name = f"{single_bearing.name} {k + 1}"
        at = single_bearing.position + (k - 0.5 * (len(ways) - 1)) * parts.nut.length
        errors = replace(parts.errors, seed=parts.errors.seed + seed_step * k)
        row = replace(parts, name=name, nut=replace(parts.nut, position=at), errors=errors)
        row = _with_single_arcs_for_thrust(row, way)
        share = total / ways.count(way) if len(set(ways)) == 2 else 0.0
        yield replace(single_bearing, name=name, parts=row, position=at, thrust=way, preload=share)


def with_groove_radii_from_rigidity(
    bearing: Scene, set_keys: schema.NutOrBearingKeys, file_name: str, set_path: str
) -> Scene:
    """Return a bearing with the groove radii that follow from the axial rigidity stated for a pair of such bearings.

    ``bearing``: the bearing, returned unchanged if no rigidity is given; ``set_keys``: its keys, with rigidity and preload
    of the pair; ``file_name``: name of the file, for messages; ``set_path``: path of the bearing's table in the file, such
    as ``sets[0]``. InputError if no groove radius gives the rigidity.
    """
    if set_keys.pair_rigidity is None:
        return bearing
    from rollbench.lowfi.bearings.angular_contact import bearing_with_contact_angle, conformity_from_pair_rigidity

    steel, track = bearing.nut.material, bearing.track
    rows = bearing_with_contact_angle(
        bearing.ball_count,
        2.0 * bearing.balls.radius,
        2.0 * track.pitch_radius,
        (USUAL_CONFORMITY, USUAL_CONFORMITY),
        track.contact_angle,
        steel.youngs_modulus,
        steel.poissons_ratio,
    )
    preload, rigidity = np.array(set_keys.pair_preload), np.array(set_keys.pair_rigidity)
    given = f"{1e-6 * set_keys.pair_rigidity:g} N/um at {set_keys.pair_preload:g} N"
    try:
        implied = float(conformity_from_pair_rigidity(rows, preload, rigidity))
    except ValueError as error:
        allowed = (
            "a rigidity that the pair can have with a possible conformity (groove radius over ball diameter), which is "
            "computed from it"
        )
        advice = f"correct balls, preload or rigidity: {error}"
        raise InputError(file_name, f"{set_path}.pair_rigidity", given, allowed, advice) from None
    groove = 2.0 * implied * bearing.balls.radius
    text = f"{bearing.name}: conformity {implied:.4f} of both grooves, from the rigidity of a pair, {given}."
    screw, nut = replace(bearing.screw, groove_radius=groove), replace(bearing.nut, groove_radius=groove)
    return replace(bearing, screw=screw, nut=nut, assumed=(*bearing.assumed, text))
