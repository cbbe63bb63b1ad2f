"""Faults of a scene file, which a user can correct, as texts (key, value, allowed range, advice), and their SceneError.

Faults that pydantic finds are translated into such texts. Reading continues with the valid keys, so that one error lists
all faults of a file. A fault is never an error of the program.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import ValidationError

from rollbench.compare import files
from rollbench.compare.errors import SceneError
from rollbench.compare.scenes.keys import reader_of_tables, scene_schema_of_kind
from rollbench.meshes.units import toml_text

#: Lengths that differ by less than this [m] count as equal.
TOLERANCE = 1e-9

#: Keys that a file may have in place of another key.
ALIASES = {
    "track.pitch_radius": ("track.pitch_diameter",),
    "balls.radius": ("balls.diameter",),
    "balls.count": ("balls.filling",),
    "errors.balls.oversize": ("preload.oversize", "preload.force"),
}


@dataclass(frozen=True)
class Fault:
    """One fault of a scene file: keys that may cause it, allowed values, and advice to the user."""

    #: Keys that may cause the fault; the message names the first of them that the file has.
    keys: tuple[str, ...]
    #: Allowed range or condition, in words.
    allowed: str
    #: What the user should do.
    advice: str
    #: Faulty value as the message shows it; if empty, the value of the key in the file.
    value: str = ""


def length_text(length: float) -> str:
    """Return a length [m] as text with its unit: in mm, or in um below 0.1 mm."""
    return f"{length * 1e6:.6g} um" if 0.0 < abs(length) < 1e-4 else f"{length * 1e3:.7g} mm"


#: Message about one fault of a scene file, in four parts: path of the key, value, allowed values, advice to the user.
FaultMessage = tuple[str, str, str, str]


def scene_error_of_all_faults(file_name: str, messages: Sequence[FaultMessage]) -> SceneError:
    """Return one SceneError for all faults of a scene file: the message shows the first fault, attributes show the others.

    ``file_name``: name of the file; ``messages``: texts of the faults, at least one.
    """
    errors = [SceneError(file_name, *one) for one in messages]
    return SceneError(file_name, *messages[0], len(messages) - 1, tuple(errors[1:]))


def raise_scene_error_for_faults(file_name: str, tables: Mapping[str, Any], faults: Sequence[Fault]) -> None:
    """Raise a SceneError that lists the given faults of a scene file; do nothing if there are none.

    Parameters
    ----------
    file_name
        Name of the file, for the error message.
    tables
        Tables of the file as read from TOML, for the faulty values in the error message.
    faults
        The faults.
    """
    if faults:
        raise scene_error_of_all_faults(file_name, messages_of_faults(tables, faults))


def messages_of_faults(tables: Mapping[str, Any], faults: Sequence[Fault]) -> list[FaultMessage]:
    """Return key, value, allowed values and advice for each fault of a scene file.

    ``tables``: tables of the file; ``faults``: the faults. Of the keys that may cause a fault, and of the keys that may
    stand in their place (`ALIASES`), the text names the first one that the file has.
    """
    out = []
    for fault in faults:
        names = []
        for key in fault.keys:
            names.append(key)
            names += [key.removesuffix(x) + other for x, others in ALIASES.items() if key.endswith(x) for other in others]
        present = ((name, value) for name in names if (value := value_at_path(tables, name)) is not None)
        key, given = next(present, (fault.keys[-1], None))
        value = fault.value or ("nothing" if given is None else toml_text(given))
        half = key not in fault.keys and key.endswith("diameter")
        allowed = f"{fault.allowed}, as a radius" if half else fault.allowed
        out.append((key, value, allowed, fault.advice))
    return out


def value_at_path(raw: Any, path: str) -> Any:
    """Return the value of a key in the tables ``raw`` of a scene file; None if the file has no such key.

    ``path``: path of the key, such as ``sets[0].balls``.
    """
    for key in re.findall(r"[^.\[\]]+", path):
        try:
            raw = raw[int(key) if isinstance(raw, list) else key]
        except (LookupError, TypeError, ValueError):
            return None
    return raw


#: Class of the keys of a scene file.
Keys = TypeVar("Keys")

#: Tables and keys that do not affect bodies, supports or loads: a fault in them does not hide further faults.
INDEPENDENT_TABLES = {"title", "source", "assumed", "role", "members", "kind"}
INDEPENDENT_TABLES |= {"friction", "motion", "gate", "operation", "rating"}

#: Pydantic's names of the error for an unknown key, in a table and in a record.
UNKNOWN_KEY_ERRORS = ("extra_forbidden", "unexpected_keyword_argument")


def validate_or_raise(tables: Mapping[str, Any], key_class: type[Keys], file_name: str) -> Keys:
    """Return the validated keys of a scene file, or raise a SceneError that lists the faults of all keys.

    Parameters
    ----------
    tables
        Tables of the file.
    key_class
        Class of the keys.
    file_name
        Name of the file, for the error message.
    """
    keys, messages, _ = validate_and_collect_faults(tables, key_class)
    if keys is None or messages:
        raise scene_error_of_all_faults(file_name, messages)
    return keys


def validate_and_collect_faults(
    tables: Mapping[str, Any], key_class: type[Keys]
) -> tuple[Keys | None, list[FaultMessage], set[str]]:
    """Return the validated keys of a scene file, and the faults of all keys; reading continues after a fault.

    ``tables``: tables of the file; ``key_class``: class of its keys. A faulty value is replaced by the example of
    its key, and an unknown key is left out. The returned keys are None if the file cannot be read even so, for example if a
    whole table is missing. The third value names the top-level tables and keys in which a value was replaced or removed.
    """
    try:
        return reader_of_tables(key_class).validate_python(tables), [], set()
    except ValidationError as error:
        faults = error.errors(include_url=False)
        texts = messages_of_key_faults(key_class, error)
    schema, rest, names = scene_schema_of_kind(key_class), deepcopy(dict(tables)), set()  # type: ignore[arg-type]
    for fault in faults:
        where = fault["loc"]
        whole = len(where) == 1 and fault["type"] in UNKNOWN_KEY_ERRORS  # the key that is probably meant is missing
        names |= {message_on_unknown_key(schema, fault)[1]} - {""} if whole else {str(key) for key in where[:1]}
        if not where or not _replace_faulty_value(rest, where, fault["type"], schema_part_at_path(schema, where)):
            return None, texts, names
    try:
        return reader_of_tables(key_class).validate_python(rest), texts, names
    except ValidationError:
        return None, texts, names


def _replace_faulty_value(raw: Any, where: Sequence[int | str], kind: str, node: Mapping[str, Any]) -> bool:
    """Replace a faulty value of a scene file by the example of its key, or remove it; return whether that was possible.

    ``raw``: tables of the file, which are changed in place; ``where``: path of the key; ``kind``: pydantic's name of the
    error; ``node``: part of the JSON Schema for the key.
    """
    for key in where[:-1]:
        known = isinstance(raw, list) if isinstance(key, int) else isinstance(raw, dict) and key in raw
        if not known:
            return False
        raw = raw[key]
    last: Any = where[-1]
    examples = node.get("examples", [])
    if kind not in UNKNOWN_KEY_ERRORS and examples and "properties" not in node and isinstance(raw, list | dict):
        raw[last] = deepcopy(examples[0])
        return True
    if isinstance(raw, dict):
        raw.pop(last, None)
        return kind != "missing"
    return False


def messages_of_key_faults(key_class: type, error: ValidationError) -> list[FaultMessage]:
    """Return key, value, allowed values and advice for each fault that pydantic found in a scene file, unknown keys first.

    ``key_class``: class of the file's keys; ``error``: pydantic's error. A missing key is not reported if the file
    has an unknown key that was probably meant for it, because the advice on the unknown key names it.
    """
    schema, named = scene_schema_of_kind(key_class), set()
    places = {name: place for place, name in enumerate(schema["properties"])}

    def order(fault: Any) -> tuple[bool, int]:
        """Return the sort key of a fault: unknown keys first, then by the order of the keys in the schema."""
        return fault["type"] not in UNKNOWN_KEY_ERRORS, places.get(str(next(iter(fault["loc"]), "")), len(places))

    faults = sorted(error.errors(include_url=False), key=order)
    out = []
    for fault in faults:
        where = fault["loc"]
        if fault["type"] in UNKNOWN_KEY_ERRORS:
            words, name = message_on_unknown_key(schema, fault)
            named.add((*where[:-1], name))
            out.append(words)
            continue
        # pydantic does not count the faulty entries of a list, and so may report that it is too short
        short = fault["type"] == "too_short" and len(fault["input"]) >= fault["ctx"]["min_length"]
        if not short and not (fault["type"] == "missing" and where in named):
            out.append(_refused_value_text(schema, fault))
    return out


def _key_path(where: Sequence[int | str]) -> str:
    """Return the path of a key as text, such as ``sets[0].balls``; "file" for the whole file."""
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in where).lstrip(".") or "file"


def message_on_unknown_key(schema: dict[str, Any], fault: Any) -> tuple[FaultMessage, str]:
    """Return the message about an unknown key, and the known key that is probably meant (empty if none is similar).

    ``schema``: JSON Schema of the scene; ``fault``: an entry of pydantic's list of errors.
    """
    where = fault["loc"]
    known = list(schema_part_at_path(schema, where[:-1]).get("properties", {}))
    words: dict[str, str] = files.read_shipped_toml("words.toml")  # frequent unknown keys, and the scene's keys for them
    word = words.get(str(where[-1]).strip().lower().replace("-", "_").replace(" ", "_"), "")
    near = difflib.get_close_matches(str(where[-1]), known, n=1, cutoff=0.5)
    meant = next((name for name in known if word.startswith((f"{name} ", f"{name}:"))), "")
    if word:
        advice = f"the key is unknown here; in its place a scene has {word}"
    else:
        meant = near[0] if near else ""
        advice = f"unknown key; did you mean {meant}?" if near else "unknown key: remove it, or move it to its table"
    return (_key_path(where), toml_text(fault["input"]), ", ".join(known), advice), meant


def _refused_value_text(schema: dict[str, Any], fault: Any) -> FaultMessage:
    """Return the message about a missing key or a refused value of a scene file.

    ``schema``: JSON Schema of the scene; ``fault``: an entry of pydantic's list of errors.
    """
    where, context, kind = fault["loc"], fault.get("ctx", {}), fault["type"]
    node = schema_part_at_path(schema, where)
    allowed = str(context.get("allowed") or _allowed_values(node))
    advice = str(context.get("advice") or _advice_for_key(node, str(where[-1]) if where else "", kind, fault["input"]))
    other = next((o for key, (o, *_) in ALIASES.items() if _key_path(where) == key and o.endswith("diameter")), "")
    if kind == "missing" and other:
        advice += f", or {other.split('.')[-1]}"
    return _key_path(where), "nothing" if kind == "missing" else toml_text(fault["input"]), allowed, advice


def schema_part_at_path(schema: dict[str, Any], key_path: Sequence[int | str]) -> dict[str, Any]:
    """Return the part of a scene's JSON Schema for the key at the path ``key_path``; empty if there is no such key."""
    node: dict[str, Any] = schema
    for key in (*key_path, None):
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


def _allowed_values(node: Mapping[str, Any]) -> str:
    """Return in words which values a key of a scene file allows; ``node``: part of the JSON Schema for the key."""
    if "x-allowed" in node:
        return f"{node['x-dimension']}, {node['x-allowed']}"
    if "enum" in node:
        return ", ".join([*(toml_text(v) for v in node["enum"]), *([node["x-or"]] if "x-or" in node else [])])
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


def _advice_for_key(node: Mapping[str, Any], name: str, kind: str, given: object) -> str:
    """Return the advice to a user on what to write for a faulty or missing key of a scene file.

    ``node``: part of the JSON Schema for the key; ``name``: the key; ``kind``: pydantic's name of the error; ``given``: the
    faulty value.
    """
    if "enum" in node and isinstance(given, str):
        near = difflib.get_close_matches(given, node["enum"], n=1, cutoff=0.5)
        if near:
            return f"did you mean {toml_text(near[0])}?"
    table = "properties" in node
    examples = node.get("examples", [])
    if kind == "missing":
        if table:
            return f"add a [{name}] table; rollbench new FILE writes a scene with all of them"
        return f"add {name} = {toml_text(examples[0])}" if examples else f"add {name}"
    return f"write e.g. {toml_text(examples[0])}" if examples else "see the key in the output of: rollbench schema"
