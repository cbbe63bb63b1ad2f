"""Write a scene as the text of a TOML scene file, with units, and without keys that have their default values.

Tables are in the order of the schema of scene files. A table is a dict of keys, values and inner tables.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from math import cos, pi, sin
from typing import Any, get_args, get_type_hints

from rollbench.meshes import ranges
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet, Stiffness
from rollbench.meshes.helix import evenly_spaced_azimuths
from rollbench.meshes.one_arc import distance_of_groove_centres, free_contact_angle
from rollbench.meshes.parts import FIRST, FREEDOMS, Errors, Friction, Load, Material, Nut, Scene, Screw, Support

#: Number of characters up to which a table or list is written on one line with its key.
LINE = 100
#: Coefficient of thermal expansion of steel [1/K], with which a thermal strain is written as a temperature rise.
STEEL = 11.5e-6
#: Keys of a table of a scene file, with their values or inner tables.
Table = dict[str, Any]


def toml_of_tables(tables: Mapping[str, Any]) -> str:
    """Return keys and tables as TOML text; a short inner table is written on one line with its key.

    Parameters
    ----------
    tables : Mapping[str, Any]
        Keys and tables of a scene file, as returned by `scene_file_tables`.

    Returns
    -------
    str
        Text of a scene file.

    Examples
    --------
    >>> print(toml_of_tables({"title": "Two balls", "balls": {"count": 2}}), end="")
    title = "Two balls"
    <BLANKLINE>
    [balls]
    count = 2
    """
    return "\n".join(_table_lines(tables, "")).strip() + "\n"


def scene_file_tables(scene: Scene) -> Table:
    """Return the keys and tables of the scene file that describes a screw or bearing.

    Parameters
    ----------
    scene : Scene
        Screw or bearing with its loads.

    Returns
    -------
    Table
        Keys and tables, without keys that have their default values.
    """
    shared, offset = scene.screw.material, scene.errors.lead_offset
    tables = keys_of_record(
        scene,
        **_material_table(shared, None),
        track=_track_table(scene),
        screw=_screw_or_nut_table(scene, scene.screw, shared),
        nut=_nut_table(scene, shared),
        balls=_balls_table(scene, shared),
        errors=_errors_table(scene.errors),
        supports=[*map(_support_table, scene.supports)],
        solid=keys_of_record(scene.solid, "nut_held"),
        friction=_friction_table(scene.friction),
        preload={"lead_offset": with_unit(ranges.Deviation, offset)} if offset else {},
    )
    return _with_first_keys_first(tables)


def scene_file_tables_of_shaft(axis: Assembly) -> Table:
    """Return the keys and tables of the scene file that describes a shaft with its bearings and ball nuts.

    Parameters
    ----------
    axis : Assembly
        Shaft with its bearings and ball nuts, each a rolling set.

    Returns
    -------
    Table
        Keys and tables, without keys that have their default values.
    """
    shared = next((s.parts.material for s in axis.sets if isinstance(s.parts, RollerRow)), axis.screw.material)
    shaft = keys_of_record(axis.screw) | _material_table(axis.screw.material, shared)
    if axis.screw.groove_radius:
        shaft["groove_radius"] = with_unit(ranges.Size, axis.screw.groove_radius)
    at, strain = axis.stiffness_at, axis.thermal_strain
    expansion = STEEL if strain / STEEL == round(strain / STEEL, 9) else abs(strain)
    ask = {"housing": at} if isinstance(at, str) else {} if at is None else {"at": with_unit(ranges.Size, at)}
    tables = keys_of_record(
        axis,
        kind="axis",
        **_material_table(shared, None),
        screw=shaft | without_empty_values(plain=[*map(keys_of_record, axis.segments)]),
        sets=[_rolling_set_table(axis, one, shared) for one in axis.sets],
        housings=[
            keys_of_record(h, **_support_table(Support(h.at, h.fixed)), **_stiffness_table(h.stiffness))
            for h in axis.housings
        ],
        joints=[keys_of_record(j, between=[j.first, j.second], **_stiffness_table(j.stiffness)) for j in axis.joints],
        supports=[*map(_support_table, axis.supports)],
        ingredients=keys_of_record(axis.ingredients, "screw", "element_length", "arm"),
        friction=_friction_table(axis.friction),
        stiffness=ask,
        heat={"warming": f"{strain / expansion:.12g} K", "expansion": expansion} if strain else {},
    )
    return _with_first_keys_first(tables)


def _with_first_keys_first(tables: Table) -> Table:
    """Return the tables of a scene file with the title and the other keys of `FIRST` at the beginning."""
    return {name: tables[name] for name in FIRST if name in tables} | tables


def load_case_table(
    share: float, time: float | None, speed: float | None, before: Scene | Assembly, after: Scene | Assembly
) -> Table:
    """Return the keys of one load case in a scene file: only values that differ from the scene without load cases.

    Parameters
    ----------
    share : float
        Fraction of all revolutions in this load case; used where ``time`` is None.
    time : float | None
        Duration of the load case [s]; None: ``share`` is written instead.
    speed : float | None
        Angular speed [rad/s]; None: no speed is written.
    before, after : Scene | Assembly
        The scene without load cases, and the scene under this load case.

    Returns
    -------
    Table
        Keys and values of the load case's table in the scene file.
    """
    supports = [_displaced_support_table(*pair) for pair in zip(before.supports, after.supports, strict=True)]
    table: Table = {"share": share} if time is None else {"time": with_unit(ranges.Duration, time)}
    table |= {} if speed is None else {"speed": with_unit(ranges.Turning, speed)}
    table |= {} if after.loads == before.loads else {"loads": [*map(keys_of_record, after.loads)]}
    oversizes = _ball_oversizes(after)
    table |= {} if oversizes == _ball_oversizes(before) else {"oversize": with_unit(ranges.Deviation, oversizes[0])}
    if isinstance(before, Assembly) and isinstance(after, Assembly):
        loaded = [b for a, b in zip(before.housings, after.housings, strict=True) if a != b]
        housings = [{"name": h.name} | _force_and_moment_keys(h.force, h.moment) for h in loaded]
        table |= without_empty_values(housings=housings)
    return table | without_empty_values(supports=[x for x in supports if x])


def _ball_oversizes(parts: Scene | Assembly) -> list[float]:
    """Return the oversize of the ball radii [m] of each ball nut and ball bearing of a scene."""
    scenes = [parts] if isinstance(parts, Scene) else [s.parts for s in parts.sets if isinstance(s.parts, Scene)]
    return [scene.errors.balls.oversize for scene in scenes]


def _displaced_support_table(before: Support, after: Support) -> Table:
    """Return the keys of a support whose prescribed displacement changes in a load case; empty where none changes.

    ``before``: the support in the scene without load cases; ``after``: the same support in the load case.
    """
    moved = _displacements_with_unit((name, x) for name, x in after.fixed if dict(before.fixed)[name] != x)
    return {"at": with_unit(ranges.Size, after.at), "displace": moved} if moved else {}


def _displacements_with_unit(values: Iterable[tuple[str, float]]) -> Table:
    """Return displacements [m] and rotations [rad], given with their degrees of freedom, as texts with units."""
    return {name: with_unit(ranges.Shift if name[0] == "u" else ranges.Turn, value) for name, value in values}


# --- tables


def _material_table(material: Material, shared: Material | None) -> Table:
    """Return the key ``material`` of a part with its value; empty where the part has the common material ``shared``.

    ``shared``: material at the head of the scene file, or None if the key is always wanted.
    """
    if material == shared:
        return {}
    unusual = not ranges.SOLIDS[0] <= material.youngs_modulus <= ranges.SOLIDS[1]
    return {"material": ({"unusual": True} if unusual else {}) | keys_of_record(material)}


def _track_table(scene: Scene, *, by_thrust: bool = False) -> Table:
    """Return the keys of the table ``track``, the path of the ball centres.

    For a bearing whose grooves are single arcs, the clearance from which its contact angle follows is written instead of
    the angle. ``by_thrust``: whether the key ``thrust`` of a rolling set states the direction of the single arcs; then the
    angle is written, and no clearance.
    """
    track = scene.track
    if track.arcs == "two" or by_thrust:
        return keys_of_record(track)
    apart, angle = distance_of_groove_centres(scene), track.contact_angle
    table = keys_of_record(track, "contact_angle", "washers")
    ways = {"radial": 2.0 * apart * (1.0 - cos(angle)), "axial": 2.0 * apart * sin(angle)}
    for digits in range(2, 18):
        for way, size in ways.items():
            found = float(f"{size:.{digits}g}")
            radial, axial = (found, None) if way == "radial" else (None, found)
            if free_contact_angle(apart, radial, axial) == angle:
                return table | {"clearance": {way: with_unit(ranges.Clearance, found)}}
    return table | {"clearance": {"radial": with_unit(ranges.Clearance, ways["radial"])}}


def groove_table(radius: float, ball: float) -> Table:
    """Return the key that states a groove's radius r_G: as conformity r_G / (2 r_B) where that is shorter and exact.

    Parameters
    ----------
    radius, ball : float
        Radii r_G of the groove and r_B of the ball [m].

    Returns
    -------
    Table
        The key ``conformity`` or ``groove_radius`` with its value.

    Examples
    --------
    >>> groove_table(0.52 * 2.0 * 2.7765e-3, 2.7765e-3), groove_table(3.254e-3, 2.778e-3)
    ({'conformity': 0.52}, {'groove_radius': '3.254 mm'})
    """
    text, conformity = with_unit(ranges.Size, radius), float(f"{radius / (2.0 * ball):.9g}")
    shorter = len(str(conformity)) < len(str(text)) - 3 and conformity > 0.5
    if shorter and conformity * (2.0 * ball) == radius:
        return {"conformity": with_unit(ranges.Conformity, conformity)}
    return {"groove_radius": text}


def _screw_or_nut_table(scene: Scene, part: Screw | Nut, shared: Material) -> Table:
    """Return the keys of the screw or nut ``part`` in a scene file: dimensions, groove and material.

    ``scene``: scene with the ball radius; ``shared``: material at the head of the scene file; a part of this material gets
    no key for it.
    """
    return (
        keys_of_record(part) | groove_table(part.groove_radius, scene.balls.radius) | _material_table(part.material, shared)
    )


def _nut_table(scene: Scene, shared: Material) -> Table:
    """Return the keys of a nut, with its flange and the surface at which it is fixed (table ``nut.held``).

    ``shared``: material at the head of the scene file; a nut of this material gets no key for it.
    """
    nut, flange, at = scene.nut, scene.nut.flange, scene.solid.nut_held
    held = without_empty_values(at=at)
    if flange is not None and at in (None, "flange face"):
        seat = 0.5 * nut.outer_diameter, 0.5 * flange.diameter
        for name, radius, whole in zip(("inner_diameter", "outer_diameter"), flange.seat, seat, strict=True):
            held |= {} if radius == whole else {name: with_unit(ranges.Size, 2.0 * radius)}
        held |= ({"centring": "bonded"} if flange.bonded else {}) | ({"bolts": flange.bolts} if flange.bolts else {})
    own = {} if flange is None else {"flange": keys_of_record(flange)}
    return _screw_or_nut_table(scene, nut, shared) | own | without_empty_values(held=held)


def _balls_table(scene: Scene, shared: Material) -> Table:
    """Return the keys of the balls: number and turns where they are evenly spaced in each circuit, else their azimuths.

    ``shared``: material at the head of the scene file; balls of this material get no key for it.
    """
    balls, track = scene.balls, scene.track
    at, apart = balls.azimuths, [b - a for a, b in zip(balls.azimuths, balls.azimuths[1:], strict=False)]
    each = next((i for i, x in enumerate(apart, 1) if abs(x - apart[0]) > 1e-6 * abs(apart[0])), len(at))
    turns = 1.0 if each == 1 else float(f"{each * apart[0] / (2.0 * pi):.9g}")
    circuits = len(at) // each
    gap = float(f"{(at[each] - at[0]) / (2.0 * pi) - turns:.9g}") if circuits > 1 else 0.0
    table: Table = {"radius": with_unit(ranges.Size, balls.radius)}
    if at == evenly_spaced_azimuths(each, turns, track.phase, circuits, gap):
        table |= {"count": len(at) * track.starts, "turns": turns}
        table |= {"circuits": circuits, "circuit_gap": gap} if circuits > 1 else {}
    else:
        table |= {"azimuths": [with_unit(ranges.Azimuth, azimuth) for azimuth in at]}
    return table | _material_table(balls.material, shared)


def _errors_table(errors: Errors, *, seed: bool = False) -> Table:
    """Return the keys of the table ``errors``; ``seed``: whether the seed of random errors is written even if it is 0."""
    listed = {str(number): with_unit(ranges.Deviation, error) for number, error in errors.balls.listed}
    first = {"seed": errors.seed} if seed else {}
    return first | keys_of_record(errors, balls=keys_of_record(errors.balls, listed=listed))


def _support_table(support: Support) -> Table:
    """Return the keys of a support: its axial position, its fixed degrees of freedom, and prescribed displacements."""
    fix = [name for name, value in support.fixed if value == 0.0]
    moved = _displacements_with_unit((name, value) for name, value in support.fixed if value != 0.0)
    return without_empty_values(at=with_unit(ranges.Size, support.at), fix=fix, displace=moved)


def _friction_table(friction: Friction | None) -> Table:
    """Return the keys of the table ``friction``; empty for a scene without friction.

    Where screw and nut have the same coefficient, one key ``coefficient`` replaces the keys ``screw`` and ``nut``.
    """
    if friction is None:
        return {}
    table = keys_of_record(friction)
    if friction.screw == friction.nut:
        return {"coefficient": friction.screw} | {k: v for k, v in table.items() if k not in ("screw", "nut")}
    return table


def _rolling_set_table(axis: Assembly, rolling_set: RollingSet, shared: Material) -> Table:
    """Return the keys of ``rolling_set``, a bearing or ball nut on the shaft of ``axis``.

    Its inner ring (table ``screw``) is written only if its groove, diameter or material differs from that of the shaft.
    ``shared``: material at the head of the scene file.
    """
    parts, rollers = rolling_set.parts, isinstance(rolling_set.parts, RollerRow)
    bearing = isinstance(parts, Scene) and parts.track.lead == 0.0
    table = keys_of_record(
        rolling_set,
        kind=rolling_set.kind,
        thrust=rolling_set.thrust if bearing or rolling_set.thrust != "both" else "",
        preload=with_unit(ranges.Force, rolling_set.preload) if rolling_set.preload else "",
        position=with_unit(ranges.Size, rolling_set.position) if rollers else "",
        rating=keys_of_record(parts.rating),
    )
    if isinstance(parts, RollerRow):
        crown = {} if parts.crown == float("inf") else {"crown": with_unit(ranges.Size, parts.crown)}
        depth = with_unit(ranges.Size, parts.depth)
        return table | {"rollers": keys_of_record(parts, "rating", ring_depth=depth, **crown)}
    inner, ring = {}, parts.screw
    if ring != axis.screw:
        inner = groove_table(ring.groove_radius, parts.balls.radius) | _material_table(ring.material, axis.screw.material)
        if ring.outer_diameter != axis.screw.outer_diameter:
            inner["outer_diameter"] = with_unit(ranges.Size, ring.outer_diameter)
    return table | without_empty_values(
        track=_track_table(parts, by_thrust=True),
        screw=inner,
        nut=_nut_table(parts, shared),
        balls=_balls_table(parts, shared),
        errors=_errors_table(parts.errors, seed=True),
    )


def _force_and_moment_keys(force: Sequence[float], moment: Sequence[float]) -> Table:
    """Return the keys ``force`` and ``moment`` of a load [N, N m], with units; of two zero vectors the force is there."""
    return keys_of_record(Load(0.0, tuple(force), tuple(moment)), "at")  # type: ignore[arg-type]


def _stiffness_table(matrix: Stiffness | None) -> Table:
    """Return the key that states a 6x6 stiffness: ``springs`` for a diagonal matrix, else ``matrix``; empty for None."""
    if matrix is None:
        return {}
    if any(x for i, row in enumerate(matrix) for j, x in enumerate(row) if i != j):
        return {"matrix": [[*row] for row in matrix]}
    springs = {
        n: with_unit(ranges.Spring if n[0] == "u" else ranges.Twist, matrix[i][i])
        for i, n in enumerate(FREEDOMS)
        if matrix[i][i]
    }
    return {"springs": springs or {"ux": "0 N/m"}}


# --- values of fields, by their types


def without_empty_values(**table: Any) -> Table:
    """Return the keyword arguments that are neither None nor empty as a dict, the keys of a table of a scene file.

    Examples
    --------
    >>> without_empty_values(a=1, b=None, c="", d=[])
    {'a': 1}
    """
    return {name: value for name, value in table.items() if value not in (None, "", [], {})}


def with_unit(annotated_type: Any, value: float, added_offset: float = 0.0) -> str | float:
    """Return a value in SI units as text with a unit, as in a scene file.

    Parameters
    ----------
    annotated_type : Any
        Annotated type from `ranges` that defines the unit, such as ``Size``.
    value : float
        Value in SI units.
    added_offset : float, default 0.0
        Offset in SI units that is added to the value after reading, as for `QuantityRange.text_with_unit`.

    Returns
    -------
    str | float
        Text with a unit, such as ``"3.254 mm"``; the number itself where the quantity has no unit.
    """
    return ranges.quantity_of_type(annotated_type).text_with_unit(value, added_offset)


@cache
def _quantities_of_fields(record: type) -> dict[str, ranges.QuantityRange]:
    """Return the quantity (unit and range) of each field of the class ``record`` that has one, by the field's name."""
    hints = get_type_hints(record, include_extras=True)
    return {name: found[0] for name, hint in hints.items() if (found := [*_quantities_in_type(hint)])}


def _quantities_in_type(hint: Any) -> Iterator[ranges.QuantityRange]:
    """Yield the quantities with which an annotated type is annotated, also inside tuples and unions."""
    if isinstance(hint, ranges.QuantityRange):
        yield hint
    for part in (*get_args(hint), *getattr(hint, "__metadata__", ())):
        yield from _quantities_in_type(part)


def keys_of_record(record: Any, *left_out: str, **written: Any) -> Table:
    """Return the fields of a record whose values differ from the defaults, as keys of a scene file with their values.

    Fields without a description are no keys. Of keys of which a file states at least one (class attribute ``ONE_OF``) the
    first is there even so.

    Parameters
    ----------
    record : Any
        Dataclass whose fields are keys of scene files.
    *left_out : str
        Names of fields that are left out.
    **written : Any
        Values of keys as in a scene file, in place of fields or in addition; empty ones are left out.

    Returns
    -------
    Table
        Keys and their values, with units.
    """
    of: type = type(record)
    out: Table = {}
    for each in fields(record):
        value = getattr(record, each.name)
        if each.name in written:
            out[each.name] = written[each.name]
        elif "description" in each.metadata and each.name not in left_out and repr(value) != repr(each.default):
            out[each.name] = _value_with_unit(value, _quantities_of_fields(of).get(each.name))  # repr: -0 is not 0
    needed = getattr(of, "ONE_OF", ())
    if needed and not out.keys() & {*needed}:
        out[needed[0]] = _value_with_unit(getattr(record, needed[0]), _quantities_of_fields(of)[needed[0]])
    return without_empty_values(**out | written)


def _value_with_unit(value: Any, quantity: ranges.QuantityRange | None) -> Any:
    """Return the value of a record's field as in a scene file: with its unit, a record as a table, a tuple as a list.

    ``quantity``: quantity of the field, which defines the unit; None for a field without unit. A table whose keys all have
    their defaults states the first key.
    """
    if isinstance(value, tuple):
        return [_value_with_unit(x, quantity) for x in value]
    if is_dataclass(value):
        first = fields(value)[0].name
        return keys_of_record(value) or {first: getattr(value, first)}
    return quantity.text_with_unit(value) if quantity is not None and isinstance(value, float) else value


# --- text


def _table_lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    """Yield the TOML lines of a table: first its keys with plain values, then the tables inside it.

    ``path``: name of the table with a dot at its end; empty for the whole file.
    """
    inner = {}
    for name, value in table.items():
        tables = isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict))
        if tables and (not path or len(_toml_value(value)) > LINE):
            inner[name] = value
        else:
            yield f"{name} = {_toml_value(value, wrapped=True)}"
    for name, value in inner.items():
        for one in [value] if isinstance(value, dict) else value:
            yield from ("", f"[{path}{name}]" if isinstance(value, dict) else f"[[{path}{name}]]")
            yield from _table_lines(one, f"{path}{name}.")


def _toml_value(value: Any, *, wrapped: bool = False) -> str:
    """Return a value as TOML text; ``wrapped``: whether a list longer than `LINE` gets one line for each entry."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {_toml_value(x)}" for name, x in value.items()) + " }"
    if isinstance(value, list):
        entries = [_toml_value(x) for x in value]
        short = f"[{', '.join(entries)}]"
        return short if len(short) <= LINE or not wrapped else "[\n" + "".join(f"  {x},\n" for x in entries) + "]"
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return json.dumps(value, ensure_ascii=False)
