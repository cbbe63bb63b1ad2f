"""Conversion of a REXS file to a scene of a shaft with several bearings, with a list of assumptions and omissions.

In REXS, u is the axis of the shaft and v, w are perpendicular to it; they are z, x and y of a scene, so that an angle
around u is measured from x. Each row of a bearing becomes a set of the scene; outer rings in a casing are fixed. If the
file lacks an attribute that a scene needs, the error names the attribute and the key with which the user can give its value
(``--set``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.fault import FaultMessage, scene_error_of_all_faults
from rollbench.compare.scenes.rexs_model import UNITS, RexsComponent, RexsModel, Value, read_rexs_file

#: REXS types of rolling bearings.
BEARINGS = ("rolling_bearing_with_detailed_geometry", "rolling_bearing_with_catalog_geometry")
#: Thrust of a row in a scene, for each value of the REXS attribute for the axial force on the inner ring that it carries.
THRUST = {"positive": "+z", "negative": "-z", "both_directions": "both"}
#: Value of the REXS attribute for the carried axial force, for a bearing whose outer ring slides in its seat.
FLOATS = "no_direction"
#: REXS types of radial ball bearings.
BALLS = ("radial_grooved_ball_bearing", "angular_contact_ball_bearing", "four_point_contact_ball_bearing")
#: REXS types of axial ball bearings.
BALLS_OF_THRUST = tuple(f"axial_{name}_ball_bearing" for name in ("grooved", "angular_contact", "four_point_contact"))
#: Degrees of freedom that the seat of a sliding outer ring fixes.
SEAT = ("ux", "uy", "rx", "ry", "rz")
#: REXS types of tapered roller bearings.
ROLLERS = ("radial_tapered_roller_bearing", "axial_tapered_roller_bearing")
#: REXS attributes for the clearance of a deep-groove bearing, the operating clearance first.
CLEARANCES = ("operating_radial_bearing_clearance", "mounted_radial_bearing_clearance", "radial_bearing_clearance")
#: Tilting stiffness [N mm/rad] from which a concept bearing counts as rigid.
RIGID = 1e20
#: Spelling of REXS units in a scene file.
SCENE_UNITS = {"mum": "um", "N / mm^2": "MPa", "1 / min": "rpm", "mm^2 / s": "mm2/s"}

#: Keys and values of a table of a scene file.
Table = dict[str, Any]
#: Material of the shaft, and default material of all parts without one.
Steels = tuple[RexsComponent | None, RexsComponent | None]


@dataclass
class RexsConversion:
    """REXS file while it is converted to a scene, with the user's values, and faults, assumptions and omissions so far."""

    #: Path of the REXS file.
    path: Path
    #: Contents of the REXS file.
    model: RexsModel
    #: Values that the user gives for attributes missing in the file: text of each value, by its key in the scene file.
    user_values: dict[str, str]
    #: Faults of the REXS file: missing attributes and values that a scene cannot have.
    faults: list[FaultMessage] = field(default_factory=list)
    #: Assumptions made in the conversion, as sentences.
    assumptions: list[str] = field(default_factory=list)
    #: Sentences on parts of the REXS file that the scene omits.
    omitted: list[str] = field(default_factory=list)

    def quantity(self, component: RexsComponent, attribute: str, key: str) -> str | None:
        """Return a quantity as text with a unit: the value that the user gives for ``key``, else the one in the REXS file.

        ``component``, ``attribute``: where the REXS file states the quantity; ``key``: key of the scene file for the
        quantity. Without a value, a fault is recorded, and None is returned.
        """
        if key in self.user_values:
            return self.user_values.pop(key)
        if (value := component.number(attribute)) is not None:
            return with_unit(attribute, value)
        self.add_missing(component, attribute, key)
        return None

    def add_missing(self, component: RexsComponent, attribute: str, key: str, unit: str = "") -> None:
        """Record a fault for an attribute that a component of the REXS file lacks.

        ``key``: key with which the user can give the value (``--set``); ``unit``: unit of the attribute in REXS, "none" for
        a number or a word; if it is empty, the unit in `UNITS`.
        """
        unit = unit or UNITS[attribute]
        where = f"component {component.id} ({component.type} {component.name}), attribute {attribute}"
        example = "a number or a word" if unit == "none" else f"a value with a unit (in REXS: {unit})"
        advice = f'add it, or write --set "{key}=VALUE"'
        self.add_fault(where, "", example, advice)

    def add_fault(self, where: str, value: str, allowed: str, advice: str) -> None:
        """Record a fault of the REXS file: its location in the file, faulty value, allowed values, advice to the user."""
        self.faults.append(FaultMessage(where, value or "nothing", allowed, advice))


def with_unit(attribute: str, value: float) -> str:
    """Return the value of a REXS attribute as text with its unit, as written in a scene file.

    ``attribute``: name of the attribute, from which the unit follows; ``value``: its value in the units of REXS.
    """
    unit = UNITS[attribute]
    return f"{value!r} {SCENE_UNITS.get(unit, unit)}"


def scene_tables_from_rexs(path: Path, shaft: str, user_values: dict[str, str]) -> tuple[Table, list[str]]:
    """Return the tables of a scene file for one shaft of a REXS file and its bearings.

    Parameters
    ----------
    path
        Path of the REXS file.
    shaft
        Name or id of the shaft; empty if the file has only one shaft with bearings.
    user_values
        The user's values for missing attributes, as text by their keys; ``NAME.KEY`` for the bearing row NAME.

    Returns
    -------
    tuple[Table, list[str]]
        The tables, and sentences on parts that were omitted.

    Raises
    ------
    SceneError
        If attributes are missing; it contains one fault for each.
    ArgumentError
        If the shaft or a key does not exist, or a user's value cannot be read.
    InputError
        If the file cannot be read or is no REXS file.
    """
    model = read_rexs_file(path)
    reader = RexsConversion(path, model, dict(user_values))
    chosen = _chosen_shaft(reader, shaft)
    if len(model.load_cases) == 1:
        for k, attributes in model.load_cases[0].items():
            model.components[k].attributes |= attributes
    try:
        table = _scene_tables_of_shaft(reader, chosen)
    except (ValueError, OverflowError) as error:  # a user's value that is not a quantity, or a count that is not a number
        advice = "correct the values of --set"
        raise ArgumentError("set", str(error), "numbers with their units", advice, str(path)) from None
    if reader.user_values:
        keys = "title, material.KEY or SET.KEY of an attribute that REXS or this file lacks"
        advice = "remove these keys, or use those that the messages on missing attributes name"
        raise ArgumentError("set", ", ".join(reader.user_values), keys, advice, str(path))
    if reader.faults:
        raise scene_error_of_all_faults(str(path), reader.faults)
    return table, reader.omitted


def _chosen_shaft(reader: RexsConversion, name: str) -> RexsComponent:
    """Return the shaft of a REXS file with the name or id ``name``, or the only shaft with bearings if that is empty.

    ArgumentError if not exactly one shaft fits.
    """
    model = reader.model
    with_bearings = {r.roles["inner_part"] for r in model.relations if _is_relation_of_bearing(model, r.roles)}
    shafts = {k: c for k, c in model.components.items() if c.type == "shaft" and k in with_bearings}
    found = [c for c in shafts.values() if not name or name in (str(c.id), c.name)]
    if len(found) != 1:
        known = ", ".join(f"{c.id} ({c.name})" for c in shafts.values()) or "none: no shaft is the inner part of a bearing"
        raise ArgumentError("shaft", name or "nothing", known, "choose a shaft by its id", str(reader.path))
    return found[0]


def _is_relation_of_bearing(model: RexsModel, roles: dict[str, int]) -> bool:
    """Return whether a REXS relation connects a rolling bearing with its inner and outer part.

    ``roles``: ids of the related components, by their roles in the relation.
    """
    return {"assembly", "inner_part", "outer_part"} <= set(roles) and model.components[roles["assembly"]].type in BEARINGS


def _scene_tables_of_shaft(reader: RexsConversion, shaft: RexsComponent) -> Table:
    """Return all tables of the scene file for a shaft of a REXS file, with bearings, supports, loads and load cases."""
    model = reader.model
    sections = model.parts(shaft.id, "shaft_section")
    steel = model.material(shaft.id)
    bearings = _bearings_on_shaft(model, shaft)
    of_rollers = (_material_of_elements(model, b) for b in bearings if b.word("bearing_type") in ROLLERS)
    shared = next((x for x in of_rollers if x is not None), steel)
    plain = [_plain_section_table(reader, x) for x in sections]
    ends = [float(x["end"].split()[0]) for x in plain if x["end"]]
    widest = max((x.number("outer_diameter_begin") or 0.0 for x in sections), default=0.0)
    if not sections:
        reader.add_missing(shaft, "length", "shaft_section", "mm (of a shaft_section that is part of it)")
    sets: list[Table] = []
    for bearing in bearings:
        sets += _set_tables_of_bearing(reader, bearing, (steel, shared), {x["name"] for x in sets})
    seats = [x for x in sets if "housing" in x]
    supports = [{"at": "0 mm", "fix": ["rz"]}]
    concepts = _components_attached_to_shaft(model, shaft, "concept_bearing")
    supports += [table for x in concepts if (table := _support_table(reader, x))]
    loads = model.parts(shaft.id, "external_load")
    _note_unmapped_parts(reader, shaft)
    speed, oil = shaft.number("rotational_speed"), _lubricant_viscosity(model, shaft)
    reader.assumptions.append("REXS: the drive holds the rotation of the shaft, at its end.")
    return {
        "title": reader.user_values.pop("title", f"{shaft.name or 'Shaft'} of {reader.path.name}"),
        "source": f"REXS file {reader.path.name}, shaft {shaft.id}",
        "assumed": reader.assumptions,
        "kind": "axis",
        "material": _material_table(reader, shared or shaft, "material"),
        "screw": {"length": f"{max(ends, default=0.0)!r} mm", "outer_diameter": f"{widest!r} mm", "plain": plain}
        | _own_material_table(reader, steel, shared, "screw"),
        "sets": sets,
        "housings": [{"name": x["housing"], "at": x["nut"]["position"], "fix": list(SEAT)} for x in seats],
        "supports": supports,
        "loads": [_load_table(x, {}) for x in loads],
        "cases": _case_tables(model, shaft, loads) if len(model.load_cases) > 1 else [],
        "motion": {} if speed is None or len(model.load_cases) > 1 else {"speed": with_unit("rotational_speed", speed)},
        "lubricant": {} if oil is None else {"viscosity": with_unit("operating_viscosity", oil)},
    }


def _plain_section_table(reader: RexsConversion, section: RexsComponent) -> Table:
    """Return the scene-file table of a section of the shaft; a cone becomes a cylinder of mean diameter."""
    needed = ("u_coordinate_on_shaft", "length", "outer_diameter_begin")
    for name in needed:
        if section.number(name) is None:
            reader.add_missing(section, name, f"shaft_section {section.id}")
    start, length, first = (section.number(name) or 0.0 for name in needed)
    last = section.number("outer_diameter_end")
    bores = [section.number(f"inner_diameter_{end}") or 0.0 for end in ("begin", "end")]
    if last not in (None, first) or bores[0] != bores[1]:
        reader.assumptions.append(f"REXS: the conical section {section.id} is a cylinder of its mean diameters.")
    outer, bore = 0.5 * (first + (first if last is None else last)), 0.5 * (bores[0] + bores[1])
    table = {"start": f"{start!r} mm", "end": f"{start + length!r} mm", "diameter": f"{outer!r} mm"}
    return table | ({"bore": f"{bore!r} mm"} if bore else {})


def _set_tables_of_bearing(reader: RexsConversion, bearing: RexsComponent, steels: Steels, names: set[str]) -> list[Table]:
    """Return the scene-file tables ``[[sets]]`` of a bearing, one for each of its rows.

    ``steels``: material of the shaft, and default material of all parts; ``names``: names already in use for other rows.
    """
    model, name = reader.model, bearing.name or f"bearing {bearing.id}"
    kind, rows = bearing.word("bearing_type"), model.parts(bearing.id, "rolling_bearing_row") or [bearing]
    if kind not in (*BALLS, *BALLS_OF_THRUST, *ROLLERS):
        where = f"component {bearing.id} ({bearing.type} {bearing.name}), attribute bearing_type"
        allowed = ", ".join((*BALLS, *BALLS_OF_THRUST, *ROLLERS))
        advice = "change the type, or remove the bearing; models cover only these types"
        reader.add_fault(where, kind, allowed, advice)
        return []
    middle = reader.quantity(bearing, "u_coordinate_on_shaft_inner_side", f"{name}.position")
    apart = bearing.number("distance_between_bearing_rows") or 0.0
    found = []
    for k, row in enumerate(rows):
        each = name if len(rows) == 1 else f"{name} row {k + 1}"
        each = f"{each} ({bearing.id})" if each in names else each
        by = (k - 0.5 * (len(rows) - 1)) * apart
        place = middle or ""
        if place and by:
            value, _, unit = place.partition(" ")
            place = f"{float(value) + by!r} {unit}"
        found.append(_set_table_of_row(reader, bearing, row, steels, each, place))
    return found


def _set_table_of_row(
    reader: RexsConversion, bearing: RexsComponent, row: RexsComponent, steels: Steels, name: str, position: str
) -> Table:
    """Return the scene-file table ``[[sets]]`` for one row of a bearing.

    ``steels``: material of the shaft, and default material of all parts; ``name``: name of the row in the scene;
    ``position``: position of the row along the shaft, as text.
    """
    model, kind = reader.model, bearing.word("bearing_type")
    elements = model.parts(row.id, "rolling_element")
    element = elements[0] if elements else row
    typed = row.number("number_of_rolling_elements") or len(elements)
    count = int(typed or reader.user_values.pop(f"{name}.count", "0"))
    takes = row.word("axial_force_absorption_of_row") or bearing.word("axial_force_absorption")
    floats = bearing.word("axial_force_absorption") == FLOATS
    stated = THRUST.get("both_directions" if takes == FLOATS else takes, takes)
    takes = reader.user_values.pop(f"{name}.thrust", "") or stated
    one_way = kind in ROLLERS or "angular_contact" in kind
    if takes not in THRUST.values() or (one_way and takes == "both"):
        where = f"component {row.id} ({row.type}), attribute axial_force_absorption_of_row"
        advice = f'add it, or write --set "{name}.thrust=+z" (or -z, or both)'
        allowed = "positive or negative" if one_way else ", ".join(THRUST)
        reader.add_fault(where, takes, allowed, advice)
    if not count:
        reader.add_missing(row, "number_of_rolling_elements", f"{name}.count")
    shift = bearing.number("preload_distance") or 0.0
    force = bearing.number("preload_force") or 0.0
    if takes == "both" and kind == "radial_grooved_ball_bearing":
        takes = "deep groove"
    table: Table = {"name": name, "thrust": takes}
    if floats and kind not in ROLLERS:  # rollers on a cone carry thrust
        table["housing"] = f"{name} seat"
    if shift:
        table["offset"] = with_unit("preload_distance", -shift if takes == "+z" else shift)
    if force:
        table["preload"] = with_unit("preload_force", force)
    if kind in ROLLERS:
        return table | _roller_tables(reader, row, element, name, position, count)
    return table | _ball_tables(reader, bearing, row, steels, name, position, count)


def _roller_tables(
    reader: RexsConversion, row: RexsComponent, element: RexsComponent, name: str, position: str, count: int
) -> Table:
    """Return the scene-file keys of position and rollers for a row of tapered rollers.

    ``element``: component of a roller; ``name``: name of the row in the scene; ``position``: position of the row along the
    shaft, as text; ``count``: number of rollers.
    """
    of = f"{name}.rollers"
    depth = reader.user_values.pop(f"{of}.ring_depth", None)
    if depth is None:
        unit = "no such attribute: the depth of rings that deforms, in mm"
        reader.add_missing(row, "ring_depth", f"{of}.ring_depth", unit)
    rollers: Table = {
        "count": count,
        "diameter": reader.quantity(element, "diameter_of_rolling_element", f"{of}.diameter"),
        "length": reader.quantity(element, "length_of_rolling_element", f"{of}.length"),
        "cup_angle": _angle_without_sign(reader.quantity(row, "pressure_angle", f"{of}.cup_angle")),
        "roller_angle": reader.quantity(element, "roller_angle", f"{of}.roller_angle"),
        "ring_depth": depth,
    }
    crown = element.number("roller_crowning_radius")
    rollers |= {} if crown is None else {"crown": with_unit("roller_crowning_radius", crown)}
    rounded = reader.user_values.pop(f"{of}.edge_radius", None)  # REXS has no attribute for it
    rollers |= {} if rounded is None else {"edge_radius": rounded}
    return {"position": position, "rollers": rollers}


def _ball_tables(
    reader: RexsConversion, bearing: RexsComponent, row: RexsComponent, steels: Steels, name: str, position: str, count: int
) -> Table:
    """Return the scene-file tables of ball path, inner ring, outer ring and balls for a row of balls.

    ``steels``: material of the shaft, and default material of all parts; ``name``: name of the row in the scene;
    ``position``: position of the row along the shaft, as text; ``count``: number of balls.
    """
    model = reader.model
    elements = model.parts(row.id, "rolling_element")
    element = elements[0] if elements else row
    rings = {x.word("bearing_ring_type"): x for x in model.parts(bearing.id, "bearing_ring")}
    inner, outer = rings.get("inner_ring", bearing), rings.get("outer_ring", bearing)
    pitch = reader.quantity(row, "reference_diameter", f"{name}.track.pitch_diameter")
    track: Table = {"pitch_diameter": pitch, "lead": "0 mm"}
    clearance = next((a for a in CLEARANCES if bearing.number(a) is not None), "")
    angle = row.number("pressure_angle")
    if clearance and not angle and f"{name}.track.contact_angle" not in reader.user_values:
        track["clearance"] = {"radial": with_unit(clearance, bearing.number(clearance) or 0.0)}
    else:
        track["contact_angle"] = _angle_without_sign(reader.quantity(row, "pressure_angle", f"{name}.track.contact_angle"))
    shoulder, key = None, f"{name}.screw.outer_diameter"
    if inner is bearing and key not in reader.user_values:
        unit = "mm (of a bearing_ring of type inner_ring: its shoulders)"
        reader.add_missing(bearing, "outer_diameter", key, unit)
    else:
        shoulder = reader.quantity(inner, "outer_diameter", key)
    angles = [x.number("angular_position_around_u") for x in elements]
    of_shaft, shared = steels
    own = {
        part: _own_material_table(reader, model.material(x.id, bearing.id), default, f"{name}.{part}")
        for part, x, default in (("screw", inner, of_shaft), ("nut", outer, shared), ("balls", element, shared))
    }
    balls: Table = {"diameter": reader.quantity(element, "diameter_of_rolling_element", f"{name}.balls.diameter")}
    if len(angles) == count and None not in angles:
        balls["azimuths"] = [with_unit("angular_position_around_u", x) for x in angles if x is not None]
    else:
        balls |= {"count": count, "turns": 1}
    return {
        "track": track,
        "screw": {
            "groove_radius": reader.quantity(row, "raceway_radius_of_inner_ring", f"{name}.screw.groove_radius"),
            "outer_diameter": shoulder,
        }
        | own["screw"],
        "nut": {
            "position": position,
            "length": reader.quantity(bearing, "width", f"{name}.nut.length"),
            "outer_diameter": reader.quantity(bearing, "outer_diameter", f"{name}.nut.outer_diameter"),
            "groove_radius": reader.quantity(row, "raceway_radius_of_outer_ring", f"{name}.nut.groove_radius"),
        }
        | own["nut"],
        "balls": balls | own["balls"],
    }


def _angle_without_sign(text: str | None) -> str | None:
    """Return a contact angle, as text, without its sign, because the thrust of the row states the direction."""
    return None if text is None else text.removeprefix("-")


def _material_table(reader: RexsConversion, component: RexsComponent, key: str) -> Table:
    """Return the scene-file table of a material from the elastic constants of ``component``; missing ones are faults.

    ``key``: prefix of the keys with which the user can give missing constants, such as ``material``.
    """
    ratio = reader.quantity(component, "poisson_ratio", f"{key}.poissons_ratio")
    modulus = reader.quantity(component, "elastic_modulus", f"{key}.youngs_modulus")
    return {"youngs_modulus": modulus, "poissons_ratio": None if ratio is None else float(ratio.split()[0])}


def _own_material_table(
    reader: RexsConversion, steel: RexsComponent | None, default_steel: RexsComponent | None, key: str
) -> Table:
    """Return the scene-file table of a part's material, or an empty table where the part has the default material.

    ``steel``: material of the part, None if unknown; ``default_steel``: default material of all parts, None if there is
    none; ``key``: prefix of the keys with which the user can give missing constants.
    """
    if steel is None or (default_steel is not None and steel.attributes == default_steel.attributes):
        return {}
    return {"material": _material_table(reader, steel, f"{key}.material")}


def _bearings_on_shaft(model: RexsModel, shaft: RexsComponent) -> list[RexsComponent]:
    """Return the rolling bearings whose inner rings sit on the shaft."""
    all_roles = (r.roles for r in model.relations if _is_relation_of_bearing(model, r.roles))
    return [model.components[roles["assembly"]] for roles in all_roles if roles["inner_part"] == shaft.id]


def _material_of_elements(model: RexsModel, bearing: RexsComponent) -> RexsComponent | None:
    """Return the material of the first rolling element of a bearing that has one, else the material of the bearing.

    None is returned if neither has a material.
    """
    rows = model.parts(bearing.id, "rolling_bearing_row")
    return model.material(*(x.id for row in rows for x in model.parts(row.id, "rolling_element")), bearing.id)


def _components_attached_to_shaft(model: RexsModel, shaft: RexsComponent, type: str) -> list[RexsComponent]:
    """Return the components of a REXS type, such as "concept_bearing", that "side" relations attach to the shaft."""
    sides = (r.roles for r in model.relations if r.type == "side" and shaft.id in r.roles.values())
    return [x for roles in sides if (x := model.components[roles["assembly"]]).type == type]


def _support_table(reader: RexsConversion, bearing: RexsComponent) -> Table:
    """Return the scene-file table of a rigid support for a REXS concept bearing (a bearing without geometry).

    The table is empty if the bearing fixes no degree of freedom.
    """
    fix = ["ux", "uy"] if bearing.attributes.get("radial_force_absorption") else []
    fix += ["uz"] if bearing.word("axial_force_absorption") == "both_directions" else []
    fix += ["rx", "ry"] if (bearing.number("bending_stiffness") or 0.0) >= RIGID else []
    reader.assumptions.append(f"REXS: the concept bearing {bearing.id} ({bearing.name}) is rigid.")
    at = reader.quantity(bearing, "u_coordinate_on_shaft_inner_side", f"{bearing.name or bearing.id}.at")
    return {"at": at, "fix": fix} if fix else {}


def _load_table(load: RexsComponent, case: dict[str, Value]) -> Table:
    """Return the scene-file table of a load on the shaft; attributes stated by the load case ``case`` take precedence.

    The torque about the axis is balanced by the support at the end of the shaft.
    """
    known = RexsComponent(load.id, load.type, load.name, load.attributes | case)
    force = [known.number(f"force_{axis}_direction") or 0.0 for axis in "vwu"]
    moment = [known.number(f"torque_around_{axis}_axis") or 0.0 for axis in "vwu"]
    table: Table = {"at": f"{known.number('u_coordinate_on_shaft') or 0.0!r} mm", "force": [f"{F!r} N" for F in force]}
    return table | ({"moment": [f"{M!r} N m" for M in moment]} if any(moment) else {})


def _case_tables(model: RexsModel, shaft: RexsComponent, loads: list[RexsComponent]) -> list[Table]:
    """Return the scene-file tables of the load cases, each with its loads and its share of the operating time.

    ``loads``: components of the loads on the shaft. If the file has a time and a speed for every load case, the tables
    state them instead of shares.
    """
    unit = next((k for k, c in model.components.items() if c.type == "gear_unit"), 0)
    of_unit = [RexsComponent(0, "", "", case.get(unit, {})) for case in model.load_cases]
    of_shaft = [RexsComponent(0, "", "", shaft.attributes | case.get(shaft.id, {})) for case in model.load_cases]
    parts, speeds = [x.number("operating_time_fraction") for x in of_unit], [x.number("rotational_speed") for x in of_shaft]
    total = math.fsum(x or 0.0 for x in parts)
    found = []
    for k, (case, part, speed) in enumerate(zip(model.load_cases, parts, speeds, strict=True), 1):
        even = 1.0 / len(parts) if not total else (part or 0.0) / total
        share: Table = {"share": even}
        if total and part and None not in (*parts, *speeds):
            share = {"time": f"{part!r} s", "speed": with_unit("rotational_speed", speed or 0.0)}
        found.append({"name": f"case-{k}", **share, "loads": [_load_table(x, case.get(x.id, {})) for x in loads]})
    return found


def _lubricant_viscosity(model: RexsModel, shaft: RexsComponent) -> float | None:
    """Return the operating viscosity [mm2/s] of the first bearing on the shaft that states one; None if none does."""
    found = (bearing.number("operating_viscosity") for bearing in _bearings_on_shaft(model, shaft))
    return next((x for x in found if x is not None), None)


def _note_unmapped_parts(reader: RexsConversion, shaft: RexsComponent) -> None:
    """Record a note on each part on the shaft, such as a gear, that is omitted because a scene cannot describe it."""
    model = reader.model
    for r in model.relations:
        if r.roles.get("assembly") == shaft.id and (x := model.components[r.roles.get("part", shaft.id)]).type not in (
            "shaft",
            "shaft_section",
            "external_load",
        ):
            reader.omitted.append(f"{x.type} {x.id} ({x.name}): not part of the scene")
        if _is_relation_of_bearing(model, r.roles) and shaft.id in r.roles.values():
            outer = model.components[r.roles["outer_part"]]
            if outer.type != "gear_casing":
                bearing = model.components[r.roles["assembly"]]
                held = "its other side" if outer.id == shaft.id else f"its outer part, a {outer.type},"
                reader.omitted.append(
                    f"bearing {bearing.id} ({bearing.name}): {held} is not part of the scene, or taken as fixed"
                )
