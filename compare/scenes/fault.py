"""Faults of a scene file, and one SceneError of all of them: key, allowed range, advice.

Faults that pydantic finds are put in words. A scene with faulty keys is read on with the valid ones, so that all faults are
listed at once.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ValidationError

from rollbench.compare import files
from rollbench.compare.errors import SceneError
from rollbench.compare.scenes.keys import tidy_schema
from rollbench.meshes.units import show

#: Lengths that differ by less than this [m] count as equal.
TOLERANCE = 1e-9

#: Keys that may replace another one in a file.
ALIASES = {
    "track.pitch_radius": ("track.pitch_diameter",),
    "balls.radius": ("balls.diameter",),
    "balls.count": ("balls.filling",),
    "errors.balls.oversize": ("preload.oversize", "preload.force"),
}


@dataclass(frozen=True)
class Fault:
    """Fault of a scene: keys that may cause it, allowed values, advice."""

    #: Keys that may cause it; the first that the file has is named.
    keys: tuple[str, ...]
    #: Allowed values, in words.
    allowed: str
    #: What to do.
    advice: str
    #: Value to show; empty: the text in the file.
    value: str = ""


def mm(length: float) -> str:
    """Return a length [m] as text: in mm, or in um below 0.1 mm."""
    return f"{length * 1e6:.6g} um" if 0.0 < abs(length) < 1e-4 else f"{length * 1e3:.7g} mm"


class Said(NamedTuple):
    """Fault as text: key, value found, allowed values, advice."""

    #: The key.
    key: str
    #: The value found.
    value: str
    #: Allowed values.
    allowed: str
    #: What to do.
    advice: str


def refusal(origin: str, said: Sequence[Said]) -> SceneError:
    """Return one error for all faults of a file: it shows the first and carries the others."""
    errors = [SceneError(origin, *one) for one in said]
    return SceneError(origin, *said[0], len(said) - 1, tuple(errors[1:]))


def refuse(origin: str, raw: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Raise all faults as one error, if there are any."""
    if faults:
        raise refusal(origin, fault_texts(raw, faults))


def fault_texts(raw: Mapping[str, Any], faults: Sequence[Fault]) -> list[Said]:
    """Return faults as text; each names the first of its keys (or aliases) that the file has."""
    out = []
    for fault in faults:
        names = [name for key in fault.keys for name in (key, *_aliases(key))]
        present = ((name, value) for name in names if (value := _find(raw, name)) is not None)
        key, given = next(present, (fault.keys[-1], None))
        value = fault.value or ("nothing" if given is None else show(given))
        half = key not in fault.keys and key.endswith("diameter")
        out.append(Said(key, value, fault.allowed, f"as a radius; {fault.advice}" if half else fault.advice))
    return out


def _aliases(key: str) -> Iterator[str]:
    """Yield the aliases of a key, which a file may have instead."""
    for suffix, others in ALIASES.items():
        if key.endswith(suffix):
            yield from (key.removesuffix(suffix) + other for other in others)


def _find(raw: Any, path: str) -> Any:
    """Return the value at a path such as ``sets[0].balls`` in a file's tables; None if it is missing."""
    for key in re.findall(r"[^.\[\]]+", path):
        if isinstance(raw, list):
            raw = raw[int(key)] if int(key) < len(raw) else None
        elif isinstance(raw, dict):
            raw = raw.get(key)
        else:
            return None
    return raw


Keys = TypeVar("Keys", bound=BaseModel)

#: Tables and keys that do not affect bodies, supports or loads.
APART = {"title", "source", "assumed", "role", "members", "kind", "friction", "motion", "gate", "operation"}

#: Pydantic's names of the error for an unknown key, of a table and of a record.
EXTRA = ("extra_forbidden", "unexpected_keyword_argument")

#: Frequent unknown keys, in lower case with underscores, and the scene's keys for them.
WORDS: dict[str, str] = files.shipped_table("words.toml")


@dataclass(frozen=True)
class Broken:
    """Faults of a file's keys, and the top-level tables or keys that were replaced so that reading could continue."""

    #: The faults.
    said: tuple[Said, ...] = ()
    #: Names of the replaced tables and keys.
    mended: frozenset[str] = frozenset()

    @property
    def bodies(self) -> bool:
        """Whether bodies, supports and loads are as in the file."""
        return self.mended <= APART

    def leaves(self, keys: Sequence[str]) -> bool:
        """Return whether a fault of these keys stems from the file: none of them lies in a replaced table."""
        return not any(key.split(".")[0].split("[")[0] in self.mended for key in keys)


def validated_or_raise(raw: Mapping[str, Any], keys: type[Keys], origin: str) -> Keys:
    """Return the validated keys of a file; SceneError with all faults."""
    try:
        return keys.model_validate(raw)
    except ValidationError as error:
        raise refusal(origin, key_faults(keys, error)) from None


def validated(raw: Mapping[str, Any], keys: type[Keys]) -> tuple[Keys | None, Broken]:
    """Return a file's keys and faults; faulty values become examples, unknown keys are left out.

    None for the keys if that does not make the file readable, such as if a whole table is missing.
    """
    try:
        return keys.model_validate(raw), Broken()
    except ValidationError as error:
        faults = error.errors(include_url=False)
        said = tuple(key_faults(keys, error))
    schema, rest, names = tidy_schema(keys), deepcopy(dict(raw)), set()
    for fault in faults:
        where = fault["loc"]
        whole = len(where) == 1 and fault["type"] in EXTRA  # what it stands for is missing, if anything
        names |= {unknown(schema, fault)[1]} - {""} if whole else {str(key) for key in where[:1]}
        if not where or not _mend(rest, where, fault["type"], node_at(schema, where)):
            return None, Broken(said, frozenset(names))
    try:
        return keys.model_validate(rest), Broken(said, frozenset(names))
    except ValidationError:
        return None, Broken(said, frozenset(names))


def _mend(raw: Any, where: Sequence[int | str], kind: str, node: Mapping[str, Any]) -> bool:
    """Replace or leave out one value in place; return whether that was possible."""
    for key in where[:-1]:
        known = isinstance(raw, list) if isinstance(key, int) else isinstance(raw, dict) and key in raw
        if not known:
            return False
        raw = raw[key]
    last: Any = where[-1]
    examples = node.get("examples", [])
    if kind not in EXTRA and examples and "properties" not in node and isinstance(raw, list | dict):
        raw[last] = deepcopy(examples[0])
        return True
    if isinstance(raw, dict):
        raw.pop(last, None)
        return kind != "missing"
    return False


def key_faults(keys: type[BaseModel], error: ValidationError) -> list[Said]:
    """Return the faults that pydantic found: unknown keys first, as they explain missing ones.

    A missing key for which an unknown one stands is reported with that.
    """
    faults = sorted(error.errors(include_url=False), key=lambda f: f["type"] not in EXTRA)
    schema, named = tidy_schema(keys), set()
    out = []
    for fault in faults:
        where = fault["loc"]
        if fault["type"] in EXTRA:
            words, name = unknown(schema, fault)
            named.add((*where[:-1], name))
            out.append(words)
        elif not ((fault["type"] == "missing" and where in named) or _only_faulty(fault)):
            out.append(_wrong(schema, fault))
    return out


def _only_faulty(fault: Any) -> bool:
    """Return whether a list is too short only because pydantic does not count its faulty entries."""
    return bool(fault["type"] == "too_short" and len(fault["input"]) >= fault["ctx"]["min_length"])


def _path(where: Sequence[int | str]) -> str:
    """Return the location of a key as text, such as ``sets[0].balls``; "file" for the whole file."""
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".") or "file"


def unknown(schema: dict[str, Any], fault: Any) -> tuple[Said, str]:
    """Return the fault of an unknown key as text, and the known key that is probably meant (may be empty)."""
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
    """Return the fault of a missing key or a refused value as text."""
    where, context, kind = fault["loc"], fault.get("ctx", {}), fault["type"]
    node = node_at(schema, where)
    allowed = str(context.get("allowed") or _allowed(node))
    advice = str(context.get("advice") or _advice(node, str(where[-1]) if where else "", kind, fault["input"]))
    other = next((o for key, (o, *_) in ALIASES.items() if _path(where) == key and o.endswith("diameter")), "")
    if kind == "missing" and other:
        advice += f", or {other.split('.')[-1]}"
    return Said(_path(where), "nothing" if kind == "missing" else show(fault["input"]), allowed, advice)


def node_at(schema: dict[str, Any], where: Sequence[int | str]) -> dict[str, Any]:
    """Return the part of the JSON Schema for the key at ``where`` (empty if there is none)."""
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
    """Return the allowed values of a key as text, from its part of the JSON Schema."""
    if "x-allowed" in node:
        return f"{node['x-dimension']}, {node['x-allowed']}"
    if "enum" in node:
        return ", ".join([*(show(v) for v in node["enum"]), *([node["x-or"]] if "x-or" in node else [])])
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
    """Return what to write for a faulty or missing key, from its part of the JSON Schema."""
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


def hint(name: str) -> str:
    """Return the scene's key for a frequent unknown key (``WORDS``), or an empty text."""
    return WORDS.get(name.strip().lower().replace("-", "_").replace(" ", "_"), "")
