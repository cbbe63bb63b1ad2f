"""From what pydantic finds in the keys of a scene file to faults in words: what is allowed there, what to do."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from rollbench.comparison.scenes.keys import tidy_schema
from rollbench.comparison.scenes.refusal import ALIASES, Said
from rollbench.comparison.scenes.units import show
from rollbench.comparison.scenes.words import hint


def key_faults(keys: type[BaseModel], error: ValidationError) -> list[Said]:
    """Faults that pydantic found in ``keys``: unknown keys first, as they explain missing ones; a missing key that an
    unknown one stands for is told with that."""
    faults = sorted(error.errors(include_url=False), key=lambda f: f["type"] != "extra_forbidden")
    schema, named = tidy_schema(keys), set()
    out = []
    for fault in faults:
        where = fault["loc"]
        if fault["type"] == "extra_forbidden":
            words, name = unknown(schema, fault)
            named.add((*where[:-1], name))
            out.append(words)
        elif not (fault["type"] == "missing" and where in named):
            out.append(_wrong(schema, fault))
    return out


def _path(where: Sequence[int | str]) -> str:
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".") or "file"


def unknown(schema: dict[str, Any], fault: Any) -> tuple[Said, str]:
    """An unknown key in words, and the known key of its table that it is taken for (may be empty)."""
    where = fault["loc"]
    known, word = list(node_at(schema, where[:-1]).get("properties", {})), hint(str(where[-1]))
    near = difflib.get_close_matches(str(where[-1]), known, n=1, cutoff=0.5)
    meant = next((name for name in known if word.startswith((f"{name} ", f"{name}:"))), "")
    if word:
        advice = f"unknown key here; a scene says {word}"
    else:
        meant = near[0] if near else ""
        advice = f"unknown key; did you mean {meant}?" if near else "unknown key: remove it or move it"
    return Said(_path(where), show(fault["input"]), ", ".join(known), advice), meant


def _wrong(schema: dict[str, Any], fault: Any) -> Said:
    """A missing key, or a value that is not allowed, in words."""
    where, context, kind = fault["loc"], fault.get("ctx", {}), fault["type"]
    node = node_at(schema, where)
    allowed = str(context.get("allowed") or _allowed(node))
    advice = str(context.get("advice") or _advice(node, str(where[-1]) if where else "", kind, fault["input"]))
    other = next((o for key, (o, *_) in ALIASES.items() if _path(where) == key and o.endswith("diameter")), "")
    if kind == "missing" and other:
        advice += f", or {other.split('.')[-1]}"
    return Said(_path(where), "nothing" if kind == "missing" else show(fault["input"]), allowed, advice)


def node_at(schema: dict[str, Any], where: Sequence[int | str]) -> dict[str, Any]:
    """The part of the JSON Schema that describes the key at ``where`` (empty if there is none)."""
    node: dict[str, Any] = schema
    for key in (*where, None):
        if "$ref" in node:
            target = schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
            node = target | {k: v for k, v in node.items() if k in ("description", "examples")}
        if key is None:
            break
        if isinstance(key, int):
            node = node.get("items", {})
        else:
            node = node.get("properties", {}).get(key) or node.get("additionalProperties") or {}
    return node


def _allowed(node: Mapping[str, Any]) -> str:
    if "x-allowed" in node:
        return f"{node['x-dimension']}, {node['x-allowed']}"
    if "enum" in node:
        return ", ".join(show(v) for v in node["enum"])
    if node.get("type") == "boolean":
        return "true, false"
    if node.get("type") == "integer":
        return f"a whole number from {node.get('minimum')} to {node.get('maximum')}"
    if node.get("type") == "string":
        return f"text of {node.get('minLength', 0)} to {node.get('maxLength')} characters"
    if node.get("type") == "array":
        low, high = node.get("minItems", 0), node.get("maxItems")
        return f"a list of {low}{'' if low == high else f' to {high}'} entries"
    return f"a table of {', '.join(node.get('properties', {})) or 'numbered entries'}"


def _advice(node: Mapping[str, Any], name: str, kind: str, given: object) -> str:
    if "enum" in node and isinstance(given, str):
        near = difflib.get_close_matches(given, node["enum"], n=1, cutoff=0.5)
        if near:
            return f"did you mean {show(near[0])}?"
    table = "properties" in node
    examples = node.get("examples", [])
    if kind == "missing":
        if table:
            return f"add a [{name}] table; rollbench new FILE writes a scene with all of them"
        return f"add {name} = {show(examples[0])}" if examples else f"add {name}"
    return f"write e.g. {show(examples[0])}" if examples else "see rollbench schema"
