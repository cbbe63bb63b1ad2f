"""Commented scenes to begin with, one of every kind: the values of a shipped scene, every other key as a comment."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

from rollbench.compare import data
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.catalogue import scene_text
from rollbench.compare.scenes.keys import tidy_schema
from rollbench.compare.scenes.names import KINDS, WHOLE
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.meshes.units import show

#: Shipped scenes whose values the templates take; that of a ball screw is written by hand.
EXAMPLES = {
    "bearing": "bearing-9",
    "bearing ball": "lin-rotary-1",
    "bearing pair": "lin-bearing-pairs",
    "linear pair": "lin-pair-a",
    "linear chain": "lin-chain-10",
    "screw pair": "lin-screw-pair-a",
    "screw run": "lin-screw-run",
}
#: Shipped shafts with several rolling sets that are templates as they stand.
AXES = {"axis": "axis-fixed-fixed", "double nut": "double-nut"}
#: Shafts with bearings that are templates in files of their own.
BEARINGS = ("angular contact bearing", "support bearings")
INTRODUCTION = """\
# A scene of the kind "{kind}". {about}
# Lengths, forces, angles and speeds are texts with a unit: "20 mm", "7 um", "5 kN", "210 GPa", "45 deg", "10 rps".
# Lines that begin with "# key = " show optional keys; take away "# ". All keys: rollbench schema
"""

Node = Mapping[str, Any]


def text_of(kind: str = "ball screw", size: str = "") -> str:
    """A commented scene of a kind, of a nominal size such as 40x10 where one is given. Raises InputError for an unknown
    kind, for the size of another kind than ball screw and double nut, and where the rules of sizes do not reach."""
    from rollbench.compare.scenes.like import double_nut_like, scene_like

    kind = (kind or "ball-screw").replace("-", " ")
    sized = {"ball screw": scene_like, "double nut": double_nut_like}
    if not size:
        return template(kind)
    if kind not in sized:
        allowed = "without --kind, or with --kind double-nut"
        raise ArgumentError("like", size, allowed, "a nominal size is that of a ball screw")
    return sized[kind](size)


def template(kind: str = "ball screw") -> str:
    """A commented scene of a kind that solves as it stands; words of the kind may be joined by hyphens.

    Raises InputError for an unknown kind.
    """
    name = kind.replace("-", " ")
    if name in AXES:
        lines = scene_text(AXES[name]).splitlines()
        kept = [x for x in lines if not x.startswith(("source = ", "assumed = "))]
        return "\n".join(f'title = "My {name}"' if x.startswith("title = ") else x for x in kept) + "\n"
    if name not in (*WHOLE, *BEARINGS, *KINDS):
        allowed = ", ".join(k.replace(" ", "-") for k in (*WHOLE, *AXES, *BEARINGS, *KINDS))
        raise ArgumentError("kind", kind, allowed, "a whole screw is a ball-screw")
    if name == "ball screw" or name in BEARINGS:
        file = "template.toml" if name == "ball screw" else f"template-{name.replace(' ', '-')}.toml"
        return data.text(file)
    values = tomllib.loads(scene_text(EXAMPLES[name])) | {"title": f"My {name}", "kind": name}
    for key in ("source", "assumed"):
        values.pop(key, None)
    schema = _schema(name)
    lines = list(_table(schema, schema["$defs"], values, ""))
    return INTRODUCTION.format(kind=name, about=schema["description"]) + "\n" + "\n".join(lines).strip() + "\n"


def _schema(kind: str) -> dict[str, Any]:
    if kind in WHOLE:
        schema = tidy_schema(SceneKeys)
        if kind == "bearing":  # the balls of a ring go round its one turn, and it has no flange
            schema = deepcopy(schema)
            schema["properties"].pop("circulation")
            schema["$defs"]["NutKeys"]["properties"].pop("flange")
        return schema
    from rollbench.compare.scenes.kind_table import kind_named

    return tidy_schema(kind_named(kind).keys)


def _table(node: Node, defs: Node, values: Node, path: str) -> Iterator[str]:
    """Keys of a table, those with a plain value first; then the tables in it."""
    inner = {}
    for name, entry in node["properties"].items():
        content = values.get(name)
        if isinstance(content, dict) or (isinstance(content, list) and content and isinstance(content[0], dict)):
            inner[name] = entry
        else:
            yield from _line(name, entry, content)
    for name, entry in inner.items():
        yield ""
        yield f"# {_sentence(entry)}"
        where = f"{path}{name}"
        content = values[name]
        if isinstance(content, dict):
            yield f"[{where}]"
            yield from _table(_resolve(entry, defs), defs, content, f"{where}.")
        else:
            yield f"[[{where}]]"
            yield from _table(_resolve(entry["items"], defs), defs, content[0], f"{where}.")
        for row in () if isinstance(content, dict) else content[1:]:
            yield from ("", f"[[{where}]]", *(f"{key} = {show(value)}" for key, value in row.items()))


def _line(name: str, entry: Node, value: Any) -> Iterator[str]:
    """A key with its value, or as a comment with its default or an example."""
    text = _sentence(entry)
    if "x-allowed" in entry:
        text += f" ({entry['x-allowed']})"
    elif "enum" in entry:
        text += f" ({', '.join(map(show, entry['enum']))})"
    if value is not None:
        yield f"{name} = {show(value)}  # {text}"
        return
    shown = entry["examples"][0] if entry.get("examples") else entry.get("default")
    yield f"# {name} = {show(entry['default'] if entry.get('default') not in (None, [], '') else shown)}  # {text}"


def _sentence(entry: Node) -> str:
    return str(entry["description"])


def _resolve(entry: Node, defs: Node) -> Node:
    """The table that an entry of the schema refers to."""
    table: Node = defs[entry["$ref"].rsplit("/", 1)[1]]
    return table
