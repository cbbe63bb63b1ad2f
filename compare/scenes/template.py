"""New scene files: commented templates of every kind of scene, and ball screws of a nominal size such as 40x10.

A commented scene has the values of a scene included in rollbench, and lists every other key in a comment. A ball screw of a
nominal size has typical dimensions, computed by rules that are stated in its comments.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from math import ceil, floor, pi, sin
from typing import Any

from rollbench.compare import files
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.compare.scenes.duty_cycle import WHOLE
from rollbench.compare.scenes.from_keys import angle_of_touching_balls
from rollbench.compare.scenes.keys import scene_schema_of_kind
from rollbench.compare.scenes.kinds import friction_scene_kinds
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.units import toml_text

#: Scenes of shafts with several nuts and bearings, included in rollbench, that serve as templates unchanged.
AXES = {"axis": "axis-fixed-fixed", "double nut": "double-nut"}

#: Shafts with bearings, whose templates are separate files.
BEARINGS = ("angular contact bearing", "support bearings")

#: First lines of a commented template.
INTRODUCTION = """\
# A scene of the kind "{kind}". {about}
# Lengths, forces, angles and speeds are texts with a unit: "20 mm", "7 um", "5 kN", "210 GPa", "45 deg", "10 rps".
# Lines that begin with "# key = " show optional keys; take away "# ". All keys: rollbench schema
"""

#: Part of a JSON Schema, or a table of a scene file.
Node = Mapping[str, Any]


def new_scene_text(kind: str = "ball screw", size: str = "") -> str:
    """Return the text of a new scene file: a commented template of a kind, or a ball screw of a nominal size.

    Parameters
    ----------
    kind
        Kind of the scene.
    size
        Nominal diameter and lead [mm], such as 40x10; empty: the template of the kind.

    Returns
    -------
    str
        Text of the scene file.

    Raises
    ------
    InputError
        If the kind is unknown, the size is out of range, or a size is given for a kind other than ball screw and double
        nut.
    """
    kind = (kind or "ball-screw").replace("-", " ")
    sized = {"ball screw": ball_screw_text_of, "double nut": double_nut_text_of}
    if not size:
        return commented_template(kind)
    if kind not in sized:
        allowed = "without --kind, or with --kind double-nut"
        raise ArgumentError("like", size, allowed, "leave --kind out; only ball screws have a nominal size")
    return sized[kind](typical_dimensions(size), f'title = "My {kind}"')


def commented_template(kind: str = "ball screw") -> str:
    """Return the text of a commented template of some kind of scene, which can be solved unchanged.

    ``kind``: name with spaces or hyphens between its words; InputError if it is unknown.
    """
    name = kind.replace("-", " ")
    if name in AXES:
        lines = shipped_scene_text(AXES[name]).splitlines()
        kept = [x for x in lines if not x.startswith(("source = ", "assumed = "))]
        return "\n".join(f'title = "My {name}"' if x.startswith("title = ") else x for x in kept) + "\n"
    kinds = friction_scene_kinds()
    if name not in (*WHOLE, *BEARINGS, *kinds):
        allowed = ", ".join(k.replace(" ", "-") for k in (*WHOLE, *AXES, *BEARINGS, *kinds))
        advice = "choose one of these kinds; write ball-screw for a complete ball screw"
        raise ArgumentError("kind", kind, allowed, advice)
    if name == "ball screw" or name in BEARINGS:
        file = "template.toml" if name == "ball screw" else f"template-{name.replace(' ', '-')}.toml"
        return files.shipped_text(file)
    example = "bearing-9" if name == "bearing" else kinds[name].example
    values = tomllib.loads(shipped_scene_text(example)) | {"title": f"My {name}", "kind": name}
    for key in ("source", "assumed"):
        values.pop(key, None)
    schema = _schema_of_kind(name)
    lines = list(_table_lines(schema, schema["$defs"], values, ""))
    return INTRODUCTION.format(kind=name, about=schema["description"]) + "\n" + "\n".join(lines).strip() + "\n"


def _schema_of_kind(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of scene files of the kind ``kind``: "bearing", or one of which only friction is computed."""
    if kind != "bearing":
        return scene_schema_of_kind(friction_scene_kinds()[kind].key_class)  # type: ignore[arg-type]
    schema = deepcopy(scene_schema_of_kind(SceneKeys))  # a bearing has no ball return and no flange
    schema["properties"].pop("circulation")
    schema["$defs"]["NutKeys"]["properties"].pop("flange")
    return schema


def _table_lines(node: Node, defs: Node, values: Node, path: str) -> Iterator[str]:
    """Yield the lines of a table of a template: first its keys with plain values, then the tables inside it.

    ``node``: JSON Schema of the table; ``defs``: definitions of the schema, by their names; ``values``: contents of the
    table; ``path``: name of the table with a dot, empty for the whole file.
    """
    inner = {}
    for name, entry in node["properties"].items():
        content = values.get(name)
        if isinstance(content, dict) or (isinstance(content, list) and content and isinstance(content[0], dict)):
            inner[name] = entry
        else:
            yield from _key_line(name, entry, content)
    for name, entry in inner.items():
        content, where = values[name], f"{path}{name}"
        single = isinstance(content, dict)
        header, reference = (f"[{where}]", entry) if single else (f"[[{where}]]", entry["items"])
        first, *others = [content] if single else content
        yield from ("", f"# {entry['description']}", header)
        yield from _table_lines(defs[reference["$ref"].rsplit("/", 1)[1]], defs, first, f"{where}.")
        for row in others:
            yield from ("", header, *(f"{key} = {toml_text(value)}" for key, value in row.items()))


def _key_line(name: str, entry: Node, value: Any) -> Iterator[str]:
    """Yield the line of a key in a template: with ``value``, or if that is None as a comment with default or example.

    ``entry``: part of the JSON Schema for the key.
    """
    text = entry["description"]
    if "x-allowed" in entry:
        text += f" ({entry['x-allowed']})"
    elif "enum" in entry:
        text += f" ({', '.join(map(toml_text, entry['enum']))})"
    if value is not None:
        yield f"{name} = {toml_text(value)}  # {text}"
        return
    shown = entry["examples"][0] if entry.get("examples") else entry.get("default")
    yield f"# {name} = {toml_text(entry['default'] if entry.get('default') not in (None, [], '') else shown)}  # {text}"


#: Standard ball diameters [mm].
STOCK = (0.8, 1.0, 1.2, 1.588, 2.0, 2.381, 2.778, 3.175, 3.5, 3.969, 4.763, 5.556, 6.35, 7.144, 7.938, 9.525, 12.7)

#: Range of nominal diameters and leads for which the rules hold [mm].
DIAMETERS, LEADS = (6.0, 160.0), (1.0, 100.0)

#: Largest ball diameter over lead and over nominal diameter; distance of the pitch circle from the land, in ball diameters;
#: wall of the nut under its grooves, in ball diameters; share of the turns that is filled with balls.
PER_LEAD, PER_DIAMETER, BEYOND, WALL, FILLING = 0.635, 0.2, 0.11, 1.2, 0.9

#: Outer diameter and thickness of a flange over the nut's outer diameter (in catalogues 1.4 to 1.7, and 0.18 to 0.35).
RIM, THICK = 1.5, 0.2

#: Load per ball over the squared ball diameter [N/mm2], about 13 % of a usual dynamic load rating; preload in per cent of
#: the dynamic load rating (3 to 8 % in catalogues).
LOAD, PRELOAD = 3.7, 5.0

#: Load in rapid travel over the load in cutting, in the load cases of the comments.
RAPID = 0.3

#: Standard deviation of the ball radii [um]. The diameters of a lot of grade 10 differ by at most 0.5 um (ISO 3290-1),
#: which is taken as six standard deviations.
SIGMA = 0.04

#: Length of the spacer in a double nut, over the length of a nut; load of a double nut over that of a nut of its size, so
#: that both nuts keep preload: about 2.8 times the preload frees one.
SPACER, OF_DOUBLE = 0.1, 0.45


def ball_screw_text_of(values: Mapping[str, Any], head: str) -> str:
    """Return the text of a scene file of a ball screw.

    ``values``: its dimensions and texts, by name of the placeholder; ``head``: lines with the keys title and source.
    """
    return _without_circuit_gap(_fill_in_text("screw", values, head=head), values)


def double_nut_text_of(values: Mapping[str, Any], head: str, rating: str = "") -> str:
    """Return the text of a scene file of a screw with a double nut.

    ``values``: dimensions and texts of each nut, by name of the placeholder; ``head``: lines with the keys title and
    source; ``rating``: text that follows each nut.
    """
    apart = values["nut"] + max(1.0, round(SPACER * values["nut"]))
    places = [values["middle"] - 0.5 * apart, values["middle"] + 0.5 * apart]
    nuts = [
        _fill_in_text("nut", values, number=k + 1, thrust=thrust, at=at) + rating
        for k, (thrust, at) in enumerate(zip(("-z", "+z"), places, strict=True))
    ]
    loaded = {**values, "force": float(f"{OF_DOUBLE * values['force']:.2g}")}
    return _without_circuit_gap("".join((_fill_in_text("double-nut", loaded, head=head), *nuts)), values)


def _fill_in_text(name: str, values: Mapping[str, Any], **words: object) -> str:
    """Return the template text ``name`` of the folder ``like_texts``, with its placeholders filled in.

    ``values``, ``words``: values of the placeholders by their names. Title and assumptions in the template texts contain no
    values that a user may change later.
    """
    return files.shipped_text(f"scenes/like_texts/{name}.txt").format(**values, **words)


def _without_circuit_gap(text: str, values: Mapping[str, Any]) -> str:
    """Return the text of a scene file without the line ``circuit_gap = ...`` if the nut has only one ball circuit.

    ``values``: dimensions from `typical_dimensions`, with the number of circuits.
    """
    return text if values["circuits"] > 1 else re.sub(r"(?m)^circuit_gap = .*\n", "", text)


def typical_dimensions(size: str) -> dict[str, Any]:
    """Return typical dimensions of a ball screw of a nominal size, by the names of placeholders in template texts.

    ``size``: ``DIAMETERxLEAD`` in mm, such as 40x10. Lengths are in mm. InputError for a size out of range.
    """
    outer, lead = _parse_nominal_size(size)
    ball = max(b for b in STOCK if b <= max(STOCK[0], 1.01 * min(PER_LEAD * lead, PER_DIAMETER * outer)))
    pitch = round(outer + 2.0 * BEYOND * ball, 2)
    circuits = 2 if lead <= 0.5 * outer else 1
    each = 1.5 if circuits == 2 else 2.0 if lead <= outer else 1.0
    usual = f"usual for a screw of nominal size {outer:g}x{lead:g}, by the rules in the comments of the file."
    return {
        **dimensions_around_circuits(outer, lead, ball, pitch, circuits, each),
        "like": f"of nominal size {outer:g}x{lead:g}, as is usual for it",
        "assumed": f'  "What no drawing said is {usual}",',
    }


def dimensions_around_circuits(
    outer: float, lead: float, ball: float, pitch: float, circuits: int, each: float, starts: int = 1
) -> dict[str, Any]:
    """Return typical dimensions of a screw and nut around given ball circuits, by the names of placeholders.

    ``outer``, ``lead``, ``ball``, ``pitch``: nominal diameter, lead, ball and pitch diameter [mm]; ``circuits``: number of
    circuits on each of the thread's ``starts``; ``each``: loaded turns of each circuit. Lengths are in mm.
    """
    gap = 0.5 if circuits > 1 else 0.0
    reach = circuits * each + (circuits - 1) * gap
    touching = 2.0 * pi / angle_of_touching_balls(pitch / 2.0, lead, ball)
    count = starts * circuits * max(1, floor(FILLING * each * touching))
    length = 50.0 * ceil(20.0 * outer / 50.0)
    nut, outside = ceil(reach * lead + 3.0 * ball), ceil(pitch + (1.0 + 2.0 * WALL) * ball)
    thick = max(1, min(ceil(THICK * outside), floor(0.4 * nut)))
    force = float(f"{LOAD * ball**2 * count * sin(pi / 4.0) / 1e3:.2g}")
    return {
        "outer": outer,
        "lead": lead,
        "ball": ball,
        "pitch": pitch,
        "circuits": circuits,
        "each": each,
        "gap": gap,
        "length": length,
        "middle": length / 2.0,
        "nut": nut,
        "outside": outside,
        "rim": ceil(RIM * outside),
        "rim_of": RIM,
        "thick_of": THICK,
        "thick": thick,
        "fit": max(1, floor(0.5 * (nut - thick))),
        "bore": floor(0.4 * outer),
        "filling": FILLING,
        "filling_is": "",
        "preload": PRELOAD,
        "sigma": SIGMA,
        "force": force,
        "rapid": float(f"{RAPID * force:.2g}"),
        "wall": WALL,
        "pitch_is": f"{BEYOND:g} ball diameters beyond the nominal diameter",
        "ball_is": f"the largest in stock up to {PER_LEAD:g} of the lead and {PER_DIAMETER:g} of the nominal diameter",
        "circuits_are": "number and gaps differ from maker to maker",
        "hand": '# hand = "left"',
        "starts": "# starts = 2",
    }


def _parse_nominal_size(size: str) -> tuple[float, float]:
    """Return nominal diameter and lead [mm] from a text such as ``40x10``; InputError if it is not a size in the range."""
    allowed = f"DIAMETERxLEAD in mm, {DIAMETERS[0]:g} to {DIAMETERS[1]:g} x {LEADS[0]:g} to {LEADS[1]:g}, e.g. 40x10"
    match = re.fullmatch(r"\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*[xX×]\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*", size)
    if match is None:
        raise ArgumentError("like", f'"{size}"', allowed, "write diameter and lead with an x between them")
    outer, lead = float(match[1]), float(match[2])
    if not (DIAMETERS[0] <= outer <= DIAMETERS[1] and LEADS[0] <= lead <= min(LEADS[1], 2.0 * outer)):
        advice = "choose a lead of at most twice the diameter, or write the scene by hand: rollbench new FILE"
        raise ArgumentError("like", f'"{size}"', allowed, advice)
    return outer, lead
