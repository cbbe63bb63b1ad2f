"""Template and schema of every kind: all keys shown and described, alternatives and examples valid; the shipped file."""

import json
import re
import tomllib

import pytest

from rollbench.compare import files
from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue, duty_cycle, scene_file
from rollbench.compare.scenes.keys import reader_of_tables, scene_schema_of_kind
from rollbench.compare.scenes.kinds import friction_scene_kinds, scene_json_schema
from rollbench.compare.scenes.schema import SceneKeys
from rollbench.compare.scenes.template import commented_template

#: Keys that exclude another key, or that another choice needs.
EITHER_OR = {"groove_radius", "conformity", "azimuths", "creep", "sharpness", "map_step", "starts", "pitch_diameter"}
EITHER_OR |= {"diameter", "filling", "circuit_gap", "arcs", "angle", "clearance", "washers"}


def test_template_loads_as_case_1_and_that_of_an_unknown_kind_is_refused():
    with pytest.raises(InputError, match=r"screw-run.*write ball-screw for a complete ball screw"):
        commented_template("screw")
    scene, case = scene_file.scene_from_text(commented_template(), "x/my.toml"), catalogue.scene("lin-case1")
    assert scene.name == "my"
    for part in ("track", "screw", "nut", "balls", "supports", "loads", "errors", "ingredients"):
        assert getattr(scene, part) == getattr(case, part)


@pytest.mark.parametrize("kind", [*duty_cycle.WHOLE, *friction_scene_kinds()])
def test_template_of_every_kind_is_of_that_kind_and_names_every_key(kind):
    text = commented_template(kind.replace(" ", "-"))
    scene = scene_file.parse_scene(text, "my.toml")
    assert (scene_file.kind_of_scene(scene), scene.name) == (kind, "my")
    assert f'kind = "{kind}"' in text
    keys = SceneKeys if kind in duty_cycle.WHOLE else friction_scene_kinds()[kind].key_class
    words = set(re.findall(r"\w+", text))
    assert set(scene_schema_of_kind(keys)["properties"]) - {"circulation"} <= words
    if kind != "bearing":
        assert schema_keys(scene_schema_of_kind(keys)) <= words
    optional = [line for line in text.splitlines() if re.match(r"# \w+ = ", line)]
    assert optional
    for line in () if kind == "ball screw" else optional:
        if line.split()[1] not in EITHER_OR:
            scene_file.parse_scene(text.replace(line, line.removeprefix("# "), 1), "my.toml")


def test_shipped_schema_is_the_printed_one():
    """To renew it: rollbench schema > compare/scene.schema.json."""
    shipped = files.shipped_path("scene.schema.json").read_text(encoding="utf-8")
    assert json.loads(shipped) == json.loads(json.dumps(scene_json_schema()))


def test_template_alternatives_load():
    text = commented_template()
    lines = text.splitlines()
    shown = [i for i, line in enumerate(lines) if line.startswith("# or: ")]
    assert len(shown) == 10
    for i in shown:
        j = i - 1
        changed = [*lines[:j], lines[i].removeprefix("# or: "), *lines[i + 1 :]]
        if "azimuths" in lines[i]:
            changed.remove("count = 32")
        elif 'lead = "0 mm"' in lines[i]:
            of_ring = {"turns = 2": "turns = 1", "count = 32": "count = 18"}
            changed = [of_ring.get(x, x) for x in changed]
        if "displace" in lines[i]:
            changed = [x.removeprefix("# ") if x in lines[j - 3 : j] else x for x in changed]
        if lines[j].startswith("# ") and "displace" not in lines[i]:
            head = max(k for k in range(i) if lines[k].startswith("# ["))
            changed[head:j] = [x.removeprefix("# ") for x in changed[head:j]]
        scene_file.scene_from_text("\n".join(changed), "other.toml")


def schema_keys(schema: dict) -> set[str]:
    parts = [schema, *schema["$defs"].values()]
    return {key for table in parts for key in table["properties"]}


def test_schema_names_and_describes_every_key():
    schema = json.loads(json.dumps(scene_schema_of_kind(SceneKeys)))
    assert set(schema["required"]) == {"title", "track", "screw", "nut", "balls"}
    for table in (schema, *schema["$defs"].values()):
        assert table["additionalProperties"] is False
        for name, node in table["properties"].items():
            assert len(node["description"]) > 3, name
            assert "$ref" in node or node["examples"] or name in ("track", "screw", "nut", "balls"), name


def test_schema_examples_and_defaults_are_valid():
    schema = scene_schema_of_kind(SceneKeys)
    base = tomllib.loads(commented_template())
    for name, node in schema["$defs"]["TrackKeys"]["properties"].items():
        for value in [*node["examples"], *(node[key] for key in ("default",) if key in node)]:
            reader_of_tables(SceneKeys).validate_python(base | {"track": base["track"] | {name: value}})
    for name, node in schema["properties"].items():
        for value in node.get("examples", []):
            reader_of_tables(SceneKeys).validate_python(base | {name: value})
