"""One changed letter in any key of any scene is one error that names the key and, where it is near, the one meant."""

import itertools
import json
import random
import re
import string
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.duty_cycle import AXIS
from rollbench.compare.scenes.kinds import friction_scene_kinds, scene_json_schema
from rollbench.compare.scenes.scene_tables import scene_from_tables
from rollbench.compare.scenes.template import commented_template, new_scene_text

TEXTS = {name: catalogue.shipped_scene_text(name) for name in catalogue.scene_names()}
SCHEMA = scene_json_schema()
TEXTS |= {f"template of {kind}": commented_template(kind) for kind in friction_scene_kinds()}


def keys_of(tables: object, path: str = "") -> Iterator[tuple[str, dict[str, object], str]]:
    """Path, table and name of every key."""
    if isinstance(tables, list):
        for k, one in enumerate(tables):
            yield from keys_of(one, f"{path}[{k}]")
    elif isinstance(tables, dict):
        for key, value in tables.items():
            yield f"{path}.{key}".lstrip("."), tables, key
            yield from keys_of(value, f"{path}.{key}")


def misspelt(key: str, draw: random.Random) -> str:
    k = draw.randrange(len(key))
    return key[:k] + draw.choice([x for x in string.ascii_lowercase if x != key[k]]) + key[k + 1 :]


@pytest.mark.parametrize("name", TEXTS)
def test_one_changed_letter_in_a_key(name: str) -> None:
    tables, draw, file = tomllib.loads(TEXTS[name]), random.Random(name), f"{name}.toml"
    scene_from_tables(tables, file)
    for path, table, key in [*keys_of(tables)]:
        before, wrong = dict(table), misspelt(key, draw)
        if wrong in before:
            continue
        _fill(table, {wrong if x == key else x: value for x, value in before.items()})
        with pytest.raises(InputError) as refused:
            scene_from_tables(tables, file)
        _fill(table, before)
        told = {one.key: one.advice for one in (refused.value, *refused.value.others)}
        said = told.get(path.removesuffix(key) + wrong, "nothing")
        assert refused.value.code == 2
        assert re.search("did you mean|in its place a scene has|correct the number", said), (path, wrong, refused.value)


def keys_of_schema(node: dict[str, Any], path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Path of every key that a scene may have, with 0 for the first entry of a list."""
    if "$ref" in node:
        node = SCHEMA["$defs"][node["$ref"].rpartition("/")[2]]
    for alike in (x for name in ("anyOf", "oneOf", "allOf") for x in node.get(name, ())):
        yield from keys_of_schema(alike, path)
    if isinstance(node.get("items"), dict):
        yield from keys_of_schema(node["items"], (*path, 0))
    for key, of in node.get("properties", {}).items():
        yield (*path, key)
        yield from keys_of_schema(of, (*path, key))


def schema_of(kind: str) -> dict[str, Any]:
    tops = [SCHEMA["$defs"][x["$ref"].rpartition("/")[2]] for x in SCHEMA["oneOf"]]
    return next(x for x in tops if f'"{kind}"' in json.dumps(x["properties"]["kind"]))


def put(tables: Any, path: tuple[str | int, ...], key: str) -> None:
    """Call the last key of the path ``key``; a table, list or key that is not there is made."""
    for part, following in itertools.pairwise(path):
        empty: Any = [] if following == 0 else {}
        if part == 0 and not tables:
            tables.append(empty)
        if (part != 0 and part not in tables) or not isinstance(tables[part], type(empty)):
            tables[part] = empty
        tables = tables[part]
    tables[key] = tables.pop(path[-1], "1 mm")


@pytest.mark.parametrize("kind", ["ball screw", AXIS, *friction_scene_kinds()])
def test_one_changed_letter_in_any_key_of_the_schema(kind: str) -> None:
    """Also in tables that no shipped scene and no template has."""
    draw, count = random.Random(kind), 0
    name = next(x for x, text in TEXTS.items() if (tomllib.loads(text).get("kind") or "ball screw") == kind)
    known = [path for path in keys_of_schema(schema_of(kind)) if path != ("kind",)]
    for path in known:
        tables, wrong = tomllib.loads(TEXTS[name]), misspelt(str(path[-1]), draw)
        if (*path[:-1], wrong) in known:  # ux for rx
            continue
        put(tables, path, wrong)
        with pytest.raises(InputError) as refused:
            scene_from_tables(tables, f"{name}.toml")
        assert any(one.key.endswith(wrong) for one in (refused.value, *refused.value.others)), (path, wrong)
        count += 1
    assert count > 20


def _fill(table: dict[str, object], values: dict[str, object]) -> None:
    table.clear()
    table.update(values)


def test_a_coefficient_of_friction_that_is_misspelt(command, tmp_path) -> None:
    text = re.sub(r"(?m)^# \[friction\].*\n# coefficient = ", "[friction]\ncoefficdent = ", new_scene_text(size="25x5"))
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    said = command.refused("solve", tmp_path / "my.toml")
    assert "my.toml: friction.coefficdent: got 0.1" in said
    assert said.endswith("advice: unknown key; did you mean coefficient?\n")
