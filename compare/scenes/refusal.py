"""From faults of a scene file to one SceneError: which key is named, what is allowed there, what to do."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from pydantic import ValidationError

from compare.errors import SceneError
from compare.scenes.checks import Fault
from compare.scenes.schema import json_schema
from compare.scenes.units import show


def refuse(origin: str, raw: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Raise the first fault, if any, blaming the first of its keys that the file has."""
    if not faults:
        return
    first = faults[0]
    present = ((key, value) for key in first.keys if (value := _find(raw, key)) is not None)
    key, found = next(present, (first.keys[-1], None))
    value = first.value or ("nothing" if found is None else show(found))
    raise SceneError(origin, key, value, first.allowed, first.advice, len(faults) - 1)


def _find(raw: Any, path: str) -> Any:
    for part in re.findall(r"[^.\[\]]+", path):
        if isinstance(raw, list):
            raw = raw[int(part)] if int(part) < len(raw) else None
        elif isinstance(raw, dict):
            raw = raw.get(part)
        else:
            return None
    return raw


def refuse_keys(origin: str, error: ValidationError) -> NoReturn:
    """Raise the first fault that pydantic found (unknown keys first, as they explain missing ones)."""
    faults = error.errors(include_url=False)
    first = min(faults, key=lambda f: f["type"] != "extra_forbidden")
    where = first["loc"]
    path = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".") or "file"
    context, kind = first.get("ctx", {}), first["type"]
    schema = json_schema()
    if kind == "extra_forbidden":
        known = list(_node(schema, where[:-1]).get("properties", {}))
        near = difflib.get_close_matches(str(where[-1]), known, n=1, cutoff=0.5)
        advice = f"unknown key; did you mean {near[0]}?" if near else "unknown key: remove it or move it"
        raise SceneError(origin, path, show(first["input"]), ", ".join(known), advice, len(faults) - 1)
    node = _node(schema, where)
    allowed = str(context.get("allowed") or _allowed(node))
    name = str(where[-1]) if where else ""
    advice = str(context.get("advice") or _advice(node, name, kind, first["input"]))
    value = "nothing" if kind == "missing" else show(first["input"])
    raise SceneError(origin, path, value, allowed, advice, len(faults) - 1)


def _node(schema: dict[str, Any], where: Sequence[int | str]) -> dict[str, Any]:
    """The part of the JSON Schema that describes the key at ``where`` (empty if there is none)."""
    node: dict[str, Any] = schema
    for part in (*where, None):
        if "$ref" in node:
            target = schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
            node = target | {k: v for k, v in node.items() if k in ("description", "examples")}
        if part is None:
            break
        if isinstance(part, int):
            node = node.get("items", {})
        else:
            node = node.get("properties", {}).get(part) or node.get("additionalProperties") or {}
    return node


def _allowed(node: Mapping[str, Any]) -> str:
    if "x-allowed" in node:
        return f"{node['x-dimension']}, {node['x-allowed']}"
    if "enum" in node:
        return ", ".join(show(v) for v in node["enum"])
    if node.get("type") == "integer":
        return f"a whole number from {node.get('minimum')} to {node.get('maximum')}"
    if node.get("type") == "string":
        return f"text of {node.get('minLength', 0)} to {node.get('maxLength')} characters"
    if node.get("type") == "array":
        low, high = node.get("minItems", 0), node.get("maxItems")
        return f"a list of {low}{'' if low == high else f' to {high}'} entries"
    return f"a table of {', '.join(node.get('properties', {})) or 'numbered entries'}"


def _advice(node: Mapping[str, Any], name: str, kind: str, found: object) -> str:
    if "enum" in node and isinstance(found, str):
        near = difflib.get_close_matches(found, node["enum"], n=1, cutoff=0.5)
        if near:
            return f"did you mean {show(near[0])}?"
    table = "properties" in node
    examples = node.get("examples", [])
    if kind == "missing":
        if table:
            return f"add a [{name}] table; rollbench new FILE writes a scene with all of them"
        return f"add {name} = {show(examples[0])}" if examples else f"add {name}"
    return f"write e.g. {show(examples[0])}" if examples else "see rollbench schema"
