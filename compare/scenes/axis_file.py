"""From the keys of a scene with ``[[sets]]`` to its record, with one-line errors for parts that cannot be built.

Sets of equal bearings by name, ``arrangement = "DBD"``, are one row per bearing, ground to equal gaps.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rollbench.compare.errors import InputError
from rollbench.compare.scenes.body_checks import geometry_faults
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.compare.scenes.fault import TOLERANCE, Fault, mm, refuse
from rollbench.compare.scenes.from_keys import (
    case_faults,
    force_of,
    friction_of,
    in_cases,
    material_of,
    scene_of,
    support_of,
)
from rollbench.compare.scenes.key_checks import choice_faults, friction_choice_faults, motion_faults
from rollbench.compare.scenes.schema import (
    AxisKeys,
    CaseHousingKeys,
    HousingKeys,
    RollerKeys,
    SceneKeys,
    ScrewKeys,
    SetKeys,
    StiffKeys,
)
from rollbench.meshes.axis import (
    ARRANGEMENTS,
    Assembly,
    Drive,
    Housing,
    Joint,
    RollerRow,
    RollingSet,
    Stiffness,
    diagonal_stiffness,
    full_stiffness,
)
from rollbench.meshes.one_arc import as_one_arc, is_one_arc
from rollbench.meshes.parts import FREEDOMS, Ingredients, Material, Scene, Screw
from rollbench.meshes.ranges import ShareOfRating

#: Directions of thrust of a row that carries in one direction only.
ONE_WAY = ("+z", "-z")
#: Start value of a conformity that follows from a rigidity.
USUAL = 0.52
#: Springs of zero stiffness.
NONE = diagonal_stiffness((0.0,) * 6)


def read_axis(keys: AxisKeys, raw: Mapping[str, Any], origin: str, name: str) -> Assembly | Scene | DutyCycle:
    """Make the record of a scene with several sets, or of its load cases.

    A single set of balls whose outer part stands and is not preloaded by an offset is a plain scene. SceneError for faults.

    Parameters
    ----------
    keys
        Validated keys.
    raw
        Tables of the file.
    origin
        File for errors.
    name
        Name of the scene.

    Returns
    -------
    Assembly, Scene or DutyCycle
        The record.
    """
    return in_cases(_parts(keys, raw, origin, name), keys.cases, raw, origin, _body_faults)


def _body_faults(scene: Scene | Assembly) -> Iterator[Fault]:
    """Yield faults of bodies of sets that cannot be built in a load case."""
    for one in (scene,) if isinstance(scene, Scene) else (s.parts for s in scene.sets):
        if isinstance(one, Scene):
            yield from geometry_faults(one)


def _parts(keys: AxisKeys, raw: Mapping[str, Any], origin: str, name: str) -> Assembly | Scene:
    """Return shaft, sets and housings, under the scene's loads."""
    refuse(origin, raw, [*_choice_faults(keys), *case_faults(keys)])
    sets = tuple(_set(keys, i, raw, origin) for i in range(len(keys.sets)))
    refuse(origin, raw, list(_place_faults(keys, sets)))
    if _single(keys):
        shared = {
            n: getattr(keys, n) for n in ("source", "assumed", "supports", "loads", "friction", "motion", "lubricant")
        }
        whole = _scene_keys(keys, keys.sets[0]).model_copy(update=shared)
        refuse(origin, raw, list(choice_faults(whole)))
        return scene_of(whole, name)
    heat, ask, shaft = keys.heat, keys.stiffness, keys.screw
    length, diameter = shaft.length, shaft.outer_diameter
    return Assembly(
        name=name,
        title=keys.title,
        screw=Screw(length, diameter, shaft.groove_radius or 0.0, material_of(shaft.material, keys.material), shaft.bore),
        sets=tuple(row for one, whole in zip(keys.sets, sets, strict=True) for row in bearings_of(whole, one, len(sets))),
        segments=tuple(shaft.plain),
        housings=tuple(map(_housing, keys.housings)),
        joints=tuple(Joint(j.between[0], j.between[1], j.at, _stiffness(j) or NONE) for j in keys.joints),
        supports=tuple(support_of(s) for s in keys.supports),
        loads=tuple(keys.loads),
        ingredients=Ingredients(**keys.ingredients.model_dump()),
        source=keys.source,
        assumed=(*keys.assumed, *_rated(keys, sets)),
        friction=None if keys.friction is None else friction_of(keys.friction),
        motion=keys.motion,
        lubricant=keys.lubricant,
        stiffness_at=ask.housing if ask.housing is not None else ask.at,
        thermal_strain=0.0 if heat is None else heat.warming * heat.expansion,
        drive=keys.drive,
    )


def _rated(keys: AxisKeys, sets: Sequence[RollingSet]) -> Iterator[str]:
    """Yield assumptions on conformities from rigidities, and on preloads given as a share of a rating."""
    for one, whole in zip(keys.sets, sets, strict=True):
        if isinstance(whole.parts, Scene):
            yield from whole.parts.assumed
            if isinstance(one.preload, ShareOfRating):
                yield f"{whole.name}: preload of {whole.preload:g} N{force_of(whole.parts, one.preload)[1]}"


def _housing(h: HousingKeys) -> Housing:
    """Return the record of a housing."""
    return Housing(h.name, h.at, support_of(h).fixed, _stiffness(h), h.force, h.moment)


def _single(keys: AxisKeys) -> bool:
    """Return whether the scene could be described without ``[[sets]]``."""
    one = keys.sets[0]
    more = keys.housings or keys.screw.plain or keys.heat or one.carrier or one.offset or one.preload or one.arrangement
    more = more or one.seals or keys.drive != Drive()
    return len(keys.sets) == 1 and not more and one.balls is not None and one.thrust in (None, "both")


def kind_of_set(one: SetKeys) -> str:
    """Return the kind of a set, by its tables."""
    if one.rollers is not None:
        return "tapered roller bearing"
    return "bearing" if one.track is not None and one.track.lead == 0.0 else "ball nut"


def _choice_faults(keys: AxisKeys) -> Iterator[Fault]:
    """Yield faults of sets, housings, joints and their names, of the drive, and of friction without coefficient."""
    yield from friction_choice_faults(keys.friction)
    yield from motion_faults(keys.motion)
    yield from _drive_faults(keys)
    for i, one in enumerate(keys.sets):
        yield from _set_faults(keys, i, one)
    names = [h.name for h in keys.housings]
    of_cases = [(f"cases[{k}].housings", [h.name for h in case.housings]) for k, case in enumerate(keys.cases)]
    for table, given in (("sets", [s.name for s in keys.sets]), ("housings", names), *of_cases):
        for i, label in enumerate(given):
            if label in given[:i]:
                yield Fault((f"{table}[{i}].name",), "a unique name", "results are identified by it: rename one")
    known = ", ".join(names) or "none is described"
    named: list[tuple[str, str | None]] = [(f"sets[{i}].housing", s.housing) for i, s in enumerate(keys.sets)]
    named += [(f"sets[{i}].carrier", s.carrier) for i, s in enumerate(keys.sets)]
    named += [(f"joints[{i}].between", name) for i, j in enumerate(keys.joints) for name in j.between]
    named += [(f"{table}[{i}].name", name) for table, given in of_cases for i, name in enumerate(given)]
    named.append(("stiffness.housing", keys.stiffness.housing))
    for where, name in named:
        if name is not None and name not in names:
            yield Fault((where,), f"a name under [[housings]]: {known}", "add the housing, or mend the name")
    if keys.stiffness.housing is not None and keys.stiffness.at is not None:
        yield Fault(("stiffness.at",), "either at or housing", "leave one out", "both")
    for i, h in enumerate(keys.housings):
        yield from _stiffness_faults(h, f"housings[{i}]")
        twice = set(h.fix) & h.displace.given.keys()
        if twice:
            yield Fault((f"housings[{i}].fix",), "each freedom once", "it is displaced too: keep one of the two")
    for i, j in enumerate(keys.joints):
        yield from _stiffness_faults(j, f"joints[{i}]")
        if j.springs is None and j.matrix is None:
            yield Fault((f"joints[{i}].springs",), "springs or a matrix", "a joint is its stiffness", "nothing")
        if j.between[0] == j.between[1]:
            yield Fault((f"joints[{i}].between",), "two housings", "a housing is rigid: name another one")


def _drive_faults(keys: AxisKeys) -> Iterator[Fault]:
    """Yield faults of the drive.

    A lubricant without bearings, a mass without nut, an acceleration to zero speed, an efficiency of zero.
    """
    leads = {one.track.lead for one in keys.sets if one.track is not None and one.track.lead}
    if keys.lubricant is not None and all(kind_of_set(one) == "ball nut" for one in keys.sets):
        advice = "friction of nuts goes by [friction]: leave the table out"
        yield Fault(("lubricant",), "a set that is a bearing", advice, "nuts only")
    if keys.drive.mass and len(leads) != 1:
        found = "no nut" if not leads else f"leads of {', '.join(mm(x) for x in sorted(leads))}"
        yield Fault(("drive.mass",), "nuts of one lead, which move it", "add the nut, or leave the mass out", found)
    if keys.drive.time is not None and keys.motion is None:
        yield Fault(("drive.time",), "with [motion]", 'add the speed that is reached, e.g. speed = "600 rpm"')
    if keys.drive.efficiency is not None and not (keys.drive.mass and keys.drive.time):
        advice = "it counts for a mass that is accelerated: add both, or leave it out"
        yield Fault(("drive.efficiency",), "with mass and time", advice)


def _set_faults(keys: AxisKeys, i: int, one: SetKeys) -> Iterator[Fault]:
    """Yield faults of keys of set number ``i`` that exclude or need each other."""
    at = f"sets[{i}]"
    yield from arrangement_faults(at, one)
    balls = {n: getattr(one, n) for n in ("track", "nut", "balls")}
    if one.rollers is not None:
        given = [n for n, x in balls.items() if x is not None]
        if given:
            yield Fault((f"{at}.{given[0]}",), "rollers or balls", "a set has one kind of them: make two sets", "both")
        if one.carrier is not None:
            yield Fault((f"{at}.carrier",), "nothing for rollers", "their inner ring sits on the shaft: leave it out")
        if one.position is None:
            yield Fault((f"{at}.position",), "a station", 'write e.g. position = "30 mm"', "nothing")
        if one.thrust not in ONE_WAY:
            advice = "a tapered row carries thrust one way: write the way that it keeps the shaft from going"
            yield Fault((f"{at}.thrust",), '"+z" or "-z"', advice, "nothing" if one.thrust is None else "")
        if one.rollers.roller_angle * 2.0 >= one.rollers.cup_angle:
            yield Fault((f"{at}.rollers.roller_angle",), "below half the cup's angle", "the cone's angle is what is left")
        else:
            yield from _end_faults(f"{at}.rollers", one.rollers)
    else:
        for name, table in balls.items():
            if table is None:
                yield Fault((f"{at}.{name}",), "a table", f"add [sets.{name}], or [sets.rollers]", "nothing")
        if one.position is not None:
            yield Fault((f"{at}.position",), "nothing", "the position of a nut or ring is nut.position")
    found_kind = kind_of_set(one)
    if one.kind not in (None, found_kind):
        yield Fault((f"{at}.kind",), f'"{found_kind}" with these tables', "mend kind, or track.lead")
    if one.preload and one.thrust not in ONE_WAY and one.arrangement is None:
        advice = (
            f'write {at}.thrust = "+z" or "-z", the way of the thrust on the shaft that this set is preloaded to carry, as '
            "each nut of a double nut; what carries it both ways is preloaded by errors.balls.oversize, a pair by offset"
        )
        yield Fault((f"{at}.preload",), 'a set with thrust = "+z" or "-z"', advice)
    if one.preload and one.offset != 0.0:
        yield Fault((f"{at}.preload",), "either preload or offset", "the force sets the shift: leave offset out", "both")
    if one.thrust == "both" and one.track is not None and one.track.clearance is not None:
        advice = (
            "a clearance is that of grooves of one arc each: leave thrust out for a deep-groove row, or write its one way"
        )
        yield Fault((f"{at}.thrust",), '"deep groove", "+z" or "-z" with track.clearance', advice)
    if one.rollers is not None and isinstance(one.preload, ShareOfRating):
        yield Fault((f"{at}.preload",), "a force", "the rating of rollers is not computed: write the force")
    if one.carrier is not None and one.carrier == one.housing:
        yield Fault((f"{at}.carrier",), "another housing than its outer part's", "a rigid body cannot roll on itself")
    if keys.material.youngs_modulus is None or keys.material.poissons_ratio is None:
        yield Fault(("material",), "youngs_modulus and poissons_ratio", "give both under [material]")


def _end_faults(at: str, r: RollerKeys) -> Iterator[Fault]:
    """Yield faults of the ends of rollers: a rounding, a large end that does not touch a rib; the angles are valid."""
    if r.edge_radius is not None and not 0.005 <= r.edge_radius / r.diameter <= 0.25:
        allowed = f"{mm(0.005 * r.diameter)} to {mm(0.25 * r.diameter)}, 0.005 to 0.25 of the diameter"
        yield Fault((f"{at}.edge_radius",), allowed, "rollers usually have a tenth of their diameter")
    if r.rib_height is not None and r.rib_height >= 0.5 * r.diameter:
        advice = (
            "the rib touches the end between the cone's race and the roller's axis, usually 0.05 to 0.2 of its diameter"
        )
        yield Fault((f"{at}.rib_height",), f"below {mm(0.5 * r.diameter)}", advice)
    elif r.end_radius is not None:
        from rollbench.lowfi.bearings.rib import rib_geometry, rib_height
        from rollbench.lowfi.rollers import tapered_bearing

        row = _row(r, Material(2e11, 0.3))  # whose moduli the geometry does not need
        try:
            rib_geometry(tapered_bearing(row), r.end_radius, rib_height(row))
        except ValueError as error:
            yield Fault((f"{at}.end_radius",), str(error), "makers take 0.8 to 0.95 of the distance from the apex")


def _stiffness_faults(keys: StiffKeys, where: str) -> Iterator[Fault]:
    """Yield faults of a stiffness given by both springs and matrix, or by an invalid matrix."""
    if keys.springs is not None and keys.matrix is not None:
        yield Fault((f"{where}.matrix",), "either springs or matrix", "leave one out", "both")
    if keys.matrix is not None:
        try:
            full_stiffness(np.array(keys.matrix))
        except ValueError as error:
            yield Fault((f"{where}.matrix",), "symmetric, without negative eigenvalues", str(error), "another matrix")


def _stiffness(keys: StiffKeys) -> Stiffness | None:
    """Return the stiffness of a housing or joint in six freedoms; None without springs or matrix."""
    if keys.matrix is not None:
        return full_stiffness(np.array(keys.matrix))
    return None if keys.springs is None else diagonal_stiffness(tuple(keys.springs.model_dump().values()))


def _scene_keys(keys: AxisKeys, one: SetKeys) -> SceneKeys:
    """Return the keys of a scene with one set: the shaft carries this set's inner groove."""
    shaft = keys.screw
    fields: dict[str, Any] = {n: getattr(shaft, n) for n in ScrewKeys.model_fields}
    if one.screw is not None:
        fields["material"] = one.screw.material or fields["material"]
        fields["outer_diameter"] = one.screw.outer_diameter or fields["outer_diameter"]
        fields |= {"groove_radius": one.screw.groove_radius, "conformity": one.screw.conformity}
    nut = one.nut
    if one.pair_rigidity is not None and nut is not None:  # until it is known
        fields |= {"groove_radius": None, "conformity": USUAL}
        nut = nut.model_copy(update={"conformity": USUAL})
    ingredients = Ingredients(**keys.ingredients.model_dump())
    return SceneKeys.model_construct(
        title=keys.title,
        material=keys.material,
        track=one.track,
        screw=ScrewKeys.model_construct(**fields),
        nut=nut,
        balls=one.balls,
        errors=one.errors,
        ingredients=ingredients,
    )


def _set(keys: AxisKeys, i: int, raw: Mapping[str, Any], origin: str) -> RollingSet:
    """Return the record of a set; SceneError for its faults."""
    one = keys.sets[i]
    thrust = one.thrust or "both"
    shared = (one.name, kind_of_set(one))
    if one.rollers is not None:
        row = _row(one.rollers, material_of(None, keys.material))
        of_rollers = (one.housing, one.offset, one.preload, thrust)
        return RollingSet(*shared, row, one.position or 0.0, *of_rollers, seals=one.seals)  # type: ignore[arg-type]
    scene_keys = _scene_keys(keys, one)
    if "seed" not in one.errors.model_fields_set:  # sets without a seed of their own do not draw the same errors
        scene_keys = scene_keys.model_copy(update={"errors": one.errors.model_copy(update={"seed": i})})
    refuse(origin, raw, [_blamed(f, i, raw) for f in choice_faults(scene_keys)])
    scene = with_conformity(scene_of(scene_keys, one.name), one, origin, f"sets[{i}]")
    refuse(origin, raw, [_blamed(f, i, raw) for f in geometry_faults(scene)])
    if one.thrust is None and is_one_arc(scene):
        scene, thrust = as_one_arc(scene), "deep groove"
    scene = _of_arcs(scene, thrust)
    own_place = (one.housing, one.offset, force_of(scene, one.preload)[0], thrust, one.carrier, one.seals)
    return RollingSet(*shared, scene, scene.nut.position, *own_place)  # type: ignore[arg-type]


def _row(r: RollerKeys, material: Material) -> RollerRow:
    row = RollerRow(r.count, r.diameter, r.length, r.cup_angle, r.roller_angle, r.ring_depth, material)
    names = ("slices", "edge_radius", "end_radius", "rib_height", "rib_friction", "torque_factor")
    given = {name: getattr(r, name) for name in names}
    return replace(row, **given, crown=float("inf") if r.crown is None else r.crown)


def _of_arcs(scene: Scene, thrust: str) -> Scene:
    """Return the parts of a bearing with one arc per groove, if its thrust says so; a nut keeps its two arcs."""
    if scene.track.lead != 0.0 or thrust == "both":
        return scene
    return replace(scene, track=replace(scene.track, arcs="-z" if thrust == "-z" else "+z"))


def _blamed(fault: Fault, i: int, raw: Mapping[str, Any]) -> Fault:
    """Return a fault of a set's scene with the keys of the axis file, where those of the shaft are shared."""
    inner = "screw" in raw["sets"][i]
    keys = []
    for k in fault.keys:
        of_set = k.split(".")[0] in ("track", "nut", "balls", "errors") or (k.startswith("screw") and inner)
        keys.append(f"sets[{i}].{k}" if of_set else k)
    return replace(fault, keys=tuple(keys))


def _place_faults(keys: AxisKeys, sets: Sequence[RollingSet]) -> Iterator[Fault]:
    """Yield faults of stations beyond the shaft, overlapping plain stretches, and loaded housings that cannot move."""
    length = keys.screw.length
    stations = [
        (f"{n}[{i}].at", x.at) for n in ("supports", "loads", "housings", "joints") for i, x in enumerate(getattr(keys, n))
    ]
    stations += [(f"cases[{k}].loads[{i}].at", x.at) for k, c in enumerate(keys.cases) for i, x in enumerate(c.loads or ())]
    stations += [(f"sets[{i}].position", s.position) for i, s in enumerate(sets) if s.kind == "tapered roller bearing"]
    stations += [(f"screw.plain[{i}].end", p.end) for i, p in enumerate(keys.screw.plain)]
    if keys.stiffness.at is not None:
        stations.append(("stiffness.at", keys.stiffness.at))
    for where, at in stations:
        if at > length + TOLERANCE:
            yield Fault((where,), f"0 mm to {mm(length)}", "stations are measured from the shaft's left end and lie on it")
    end = 0.0
    for i, p in enumerate(keys.screw.plain):
        if p.start < end - TOLERANCE or p.end <= p.start:
            yield Fault((f"screw.plain[{i}].start",), f"from {mm(end)}, below its end", "list stretches from left to right")
        if p.bore >= p.diameter:
            yield Fault((f"screw.plain[{i}].bore",), f"below {mm(p.diameter)}", "leave material around the hole")
        end = max(end, p.end)
    stands = {h.name for h in keys.housings if set(h.fix) == set(FREEDOMS)}
    tables: list[tuple[str, Sequence[HousingKeys | CaseHousingKeys]]] = [("housings", keys.housings)]
    tables += [(f"cases[{k}].housings", c.housings) for k, c in enumerate(keys.cases)]
    for table, housings in tables:
        for i, h in enumerate(housings):
            if h.name in stands and (any(h.force) or any(h.moment)):
                allowed = "no load on a housing that is held"
                yield Fault((f"{table}[{i}].force",), allowed, "free a freedom, or leave it out")
    for i, one in enumerate(keys.sets):
        if one.carrier in stands:
            yield Fault((f"sets[{i}].carrier",), "a housing that can move", "free a freedom of it, or leave the set out")
    held = [(s, n) for s in keys.supports for n in s.held]
    for i, s in enumerate(keys.supports):
        if not s.held:
            advice = "delete the support, or say what it holds"
            yield Fault((f"supports[{i}].fix",), "at least one freedom", advice, "nothing")
    for k, (s, n) in enumerate(held):
        if any(n == m and abs(s.at - t.at) <= 1e-5 for t, m in held[:k]):
            yield Fault((f"supports[{keys.supports.index(s)}].fix",), "each freedom once per station", f"{n} is held twice")


# --- sets of bearings by name


def arrangement_faults(at: str, one: SetKeys) -> Iterator[Fault]:
    """Yield faults of keys that need an arrangement, or exclude one."""
    given = one.arrangement is not None
    if one.pair_preload and not given:
        yield Fault((f"{at}.pair_preload",), "with an arrangement", 'write e.g. arrangement = "DB", or preload')
    if one.pair_preload and one.preload:
        advice = "one follows from the other: leave one out"
        yield Fault((f"{at}.preload",), "either preload or pair_preload", advice, "both")
    if one.pair_rigidity is not None:
        if not one.pair_preload:
            yield Fault((f"{at}.pair_rigidity",), "with pair_preload", "write the preload of the pair that has it")
        if any(x is not None and (x.conformity or x.groove_radius) for x in (one.screw, one.nut)):
            advice = "leave conformity and groove_radius out"
            yield Fault((f"{at}.pair_rigidity",), "in place of the grooves of the set", advice)
        if one.track is not None and one.track.clearance is not None:
            advice = "both follow from the grooves: write the contact angle in place of the clearance"
            yield Fault((f"{at}.pair_rigidity",), "a track with contact_angle", advice)
    if not given:
        return
    if one.rollers is not None or (one.track is not None and one.track.lead != 0.0):
        yield Fault((f"{at}.arrangement",), "a ball bearing", "rollers and nuts are written row by row: leave it out")
    for key, written in (("thrust", one.thrust is not None), ("offset", one.offset != 0.0)):
        if written:
            advice = "the arrangement says it of every row: leave it out"
            yield Fault((f"{at}.{key}",), "nothing with an arrangement", advice)
    if (one.preload or one.pair_preload) and len(set(ARRANGEMENTS[one.arrangement or ""])) == 1:
        advice = "bearings in tandem press against nothing: leave it out, or name another arrangement"
        yield Fault((f"{at}.{'preload' if one.preload else 'pair_preload'}",), "rows that face both ways", advice)


def preload_of_set(name: str, pair: float) -> float:
    """Return the preload [N] of a set of bearings ground to the gaps of a pair, on either side in total.

    The gaps of a pair close by twice the deflection of a bearing; so do those of opposite rows in any set, where a side of
    n rows shares its load: P^(2/3) (n_1^(-2/3) + n_2^(-2/3)) = 2 F^(2/3), at a constant contact angle.

    Parameters
    ----------
    name
        Arrangement, such as ``DBD``.
    pair
        Preload F of the pair [N].
    """
    ways = ARRANGEMENTS[name]
    shared = sum(ways.count(way) ** (-2.0 / 3.0) for way in set(ways))
    return float(pair * (2.0 / shared) ** 1.5)


def bearings_of(whole: RollingSet, one: SetKeys, seeds: int) -> Iterator[RollingSet]:
    """Yield the rows of a set in its arrangement, next to each other around its position; the set itself without one.

    ``seeds``: step between the seeds of their errors.
    """
    if one.arrangement is None or not isinstance(whole.parts, Scene):
        yield whole
        return
    ways, parts = ARRANGEMENTS[one.arrangement], whole.parts
    total = preload_of_set(one.arrangement, one.pair_preload) if one.pair_preload else whole.preload
    for k, way in enumerate(ways):
        name, at = f"{whole.name} {k + 1}", whole.position + (k - 0.5 * (len(ways) - 1)) * parts.nut.length
        errors = replace(parts.errors, seed=parts.errors.seed + seeds * k)
        row = _of_arcs(replace(parts, name=name, nut=replace(parts.nut, position=at), errors=errors), way)
        share = total / ways.count(way) if len(set(ways)) == 2 else 0.0
        yield replace(whole, name=name, parts=row, position=at, thrust=way, preload=share)


def conformity(parts: Scene, preload: float, rigidity: float) -> float:
    """Return the conformity of both grooves of a bearing, for which a pair has an axial rigidity under its preload.

    Parameters
    ----------
    parts
        Bearing, whose conformity is replaced.
    preload
        Preload of the pair [N].
    rigidity
        Axial rigidity of the pair [N/m].

    Raises
    ------
    ValueError
        If no conformity gives it.
    """
    from rollbench.lowfi.bearings.angular_contact import CatalogueBearings, conformity_of_pair

    steel, track = parts.nut.material, parts.track
    rows = CatalogueBearings(
        balls=np.array([float(parts.ball_count)]),
        ball_diameter=np.array([2.0 * parts.balls.radius]),
        pitch_diameter=np.array([2.0 * track.pitch_radius]),
        conformity=np.array([USUAL]),
        free_angle=np.array([track.contact_angle]),
        young=steel.youngs_modulus,
        poisson=steel.poissons_ratio,
    )
    return float(conformity_of_pair(rows, np.array([preload]), np.array([rigidity]))[0])


def with_conformity(parts: Scene, one: SetKeys, origin: str, at: str) -> Scene:
    """Return the parts with the conformity that a pair's rigidity implies, if one is given; InputError if none does."""
    if one.pair_rigidity is None:
        return parts
    given = f"{1e-6 * one.pair_rigidity:g} N/um at {one.pair_preload:g} N"
    try:
        implied = conformity(parts, one.pair_preload, one.pair_rigidity)
    except ValueError as error:
        raise InputError(origin, f"{at}.pair_rigidity", given, str(error), "mend balls, preload or rigidity") from None
    groove = 2.0 * implied * parts.balls.radius
    text = f"{parts.name}: conformity {implied:.4f} of both grooves, from the rigidity of a pair, {given}."
    screw, nut = replace(parts.screw, groove_radius=groove), replace(parts.nut, groove_radius=groove)
    return replace(parts, screw=screw, nut=nut, assumed=(*parts.assumed, text))
