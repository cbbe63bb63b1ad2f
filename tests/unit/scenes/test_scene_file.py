"""Scene files: shipped scenes, template, schema, conversion to parts, and a round trip in SI units."""

import itertools
import json
import math
import re
import subprocess
import sys
import tomllib
from dataclasses import asdict, replace

import pytest

from compare.errors import InputError, SceneError
from compare.scenes import catalogue, scene_file
from compare.scenes.catalogue import scene_text
from compare.scenes.keys import AXIS, FRICTION_ONLY, WHOLE, tidy_schema
from compare.scenes.kinds.screw_balls import ScrewRunScene
from compare.scenes.kinds.table import KINDS, json_schema
from compare.scenes.schema import SceneKeys
from compare.scenes.template import template
from meshes.parts import FREEDOMS, SIDES, FourierTerm, Scene

NAMES = catalogue.whole_names()
#: Keys that exclude another key, or that another choice needs.
EITHER_OR = {"groove_radius", "conformity", "azimuths", "creep", "sharpness", "map_step", "starts", "pitch_diameter"}
EITHER_OR |= {"diameter", "filling", "circuit_gap", "arcs"}
EXPECTED = {
    "bearing-9",
    "bearing-9-preload",
    "lin-case1",
    "lin-case2",
    "lin-case3",
    "lin-case3-clamped",
    "lin-case3-offset",
    "lin-case3-offset-clamped",
    "lin-combined",
    "lin-nominal-4p1",
    "lin-pitch",
    "lin-pitch-2p1",
    "lin-pitch-4p1",
    "lin-profile",
    "lin-random",
    "lin-roundness-2p1",
    "lin-roundness-4p1",
}


def test_scenes_are_shipped():
    assert set(NAMES) >= EXPECTED


@pytest.mark.parametrize("name", NAMES)
def test_shipped_scene_loads(name):
    scene = catalogue.scene(name)
    assert scene.name == name
    assert scene.title
    own = {"unseen": "rollbench, ", "two": "rollbench, made", "lin-case1-cut": "rollbench, cut out of"}
    own |= {"liu": "Liu et al. (2025)", "lin-case3-tolerances": "rollbench, on Lin (2019)"}
    own |= {"external": "Catalogue of "}
    assert scene.source.startswith(own.get(name, own.get(name.split("-")[0], "Lin (2019)")))
    assert all(sentence.endswith(".") for sentence in scene.assumed)
    assert len(scene.assumed) >= (1 if scene.source.startswith("rollbench") else 5)


def test_case_1_in_si_units():
    scene = catalogue.scene("lin-case1")
    assert scene.track.pitch_radius == 16.5e-3
    assert scene.track.lead == 20e-3
    assert scene.track.contact_angle == math.pi / 4
    assert scene.balls.radius == 2.778e-3
    assert scene.screw.groove_radius == scene.nut.groove_radius == 3.254e-3
    assert (scene.nut.position, scene.nut.length, scene.nut.outer_diameter) == (0.4, 54e-3, 48e-3)
    assert scene.screw.material == scene.nut.material == scene.balls.material
    assert scene.screw.material.youngs_modulus == 210e9
    assert scene.supports[0].fixed == (("ux", 0.0), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0), ("rz", 0.0))
    assert scene.loads[0].force == (0.0, 0.0, 5000.0)
    azimuth = scene.balls.azimuths
    assert len(azimuth) == 32
    assert sum(azimuth) == pytest.approx(0.0, abs=1e-12)
    steps = [math.degrees(b - a) for a, b in itertools.pairwise(azimuth)]
    assert steps == pytest.approx([22.5] * 31)


def test_case_3_supports():
    free, offset = catalogue.scene("lin-case3").supports[1], catalogue.scene("lin-case3-offset").supports[1]
    clamped = catalogue.scene("lin-case3-offset-clamped").supports[1]
    assert free.fixed == (("ux", 0.0), ("uy", 0.0))
    assert offset.fixed == (("ux", 3e-4), ("uy", 0.0))
    assert clamped.fixed == (("ux", 3e-4), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0))
    assert catalogue.scene("lin-case3").errors.balls.oversize == 7e-6
    assert catalogue.scene("lin-case3-ux").supports[1].fixed == (("ux", 0.0),)
    assert catalogue.scene("lin-case3-offset-ux").supports[1].fixed == (("ux", 3e-4),)


@pytest.mark.parametrize("name", ["lin-case3", "lin-case3-offset"])
def test_readings_of_case_3_differ_in_the_right_end_alone_and_say_which_is_the_text_s(name):
    def bare(scene):
        return replace(scene, name="", title="", assumed=(), supports=scene.supports[:1], friction=None)

    ours, text = catalogue.scene(name), catalogue.scene(f"{name}-ux")
    assert bare(ours) == bare(text) == bare(catalogue.scene(f"{name}-clamped"))
    assert any("the text's own reading" in sentence for sentence in text.assumed)
    assert any("The text sets only the x-displacement" in sentence for sentence in ours.assumed)


def test_errors_of_2_4_2():
    errors = catalogue.scene("lin-combined").errors
    assert [errors.side(s).profile for s in SIDES] == [(3e-6, -1e-6), (3e-6, -0.5e-6), (2e-6, -1e-6), (2e-6, -0.25e-6)]
    assert [errors.side(s).pitch[0].harmonic for s in SIDES] == [1.0, 1.0, 0.5, 0.5]
    assert [errors.side(s).pitch[0].sin for s in SIDES] == [3e-6, 3e-6, -2e-6, -2e-6]
    assert (errors.balls.sigma, errors.seed, errors.random) == (1e-6, 2019, True)
    assert catalogue.scene("lin-case2").errors.balls.listed == ((17, 1e-6),)


def test_bearing_load_is_3_kn_at_9_degrees():
    x, y, z = catalogue.scene("bearing-9").loads[0].force
    assert math.hypot(x, z) == pytest.approx(3000.0, abs=1e-6)
    assert math.degrees(math.atan2(x, z)) == pytest.approx(9.0, abs=1e-6)
    assert y == 0.0


def test_template_loads_as_case_1():
    scene, case = scene_file.loads(template(), "x/my.toml"), catalogue.scene("lin-case1")
    assert scene.name == "my"
    for part in ("track", "screw", "nut", "balls", "supports", "loads", "errors", "ingredients"):
        assert getattr(scene, part) == getattr(case, part)


def test_template_shows_every_key_and_loads_with_all_optional_ones():
    text = template()
    full = re.sub(r"(?m)^# (?=\[|\w+ = )", "", text)
    scene = scene_file.loads(full, "full.toml")
    assert scene.errors.NR.profile == (2e-6, -0.25e-6)
    assert scene.supports[1].fixed == (("ux", 3e-4), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0))
    words = set(re.findall(r"\w+", text))
    assert not schema_keys(tidy_schema(SceneKeys)) - words


@pytest.mark.parametrize("kind", [*WHOLE, *FRICTION_ONLY])
def test_template_of_every_kind_is_of_that_kind_and_names_every_key(kind):
    text = template(kind.replace(" ", "-"))
    scene = scene_file.read(text, "my.toml")
    assert (scene_file.kind_of(scene), scene.name) == (kind, "my")
    assert f'kind = "{kind}"' in text
    keys = SceneKeys if kind in WHOLE else KINDS[kind].keys
    words = set(re.findall(r"\w+", text))
    left_out = {"circulation"} if kind == "bearing" else set()
    assert set(tidy_schema(keys)["properties"]) - left_out <= words
    if kind in FRICTION_ONLY:
        assert schema_keys(tidy_schema(keys)) <= words
    optional = [line for line in text.splitlines() if re.match(r"# \w+ = ", line)]
    assert optional
    for line in () if kind == "ball screw" else optional:
        if line.split()[1] not in EITHER_OR:
            scene_file.read(text.replace(line, line.removeprefix("# "), 1), "my.toml")


def test_template_of_an_unknown_kind_is_refused():
    with pytest.raises(InputError, match=r"screw-run.*a whole screw is a ball-screw"):
        template("screw")


def test_whole_scene_may_name_its_kind_and_must_name_the_right_one():
    text = scene_text("lin-case1").replace("[material]", 'kind = "ball screw"\n[material]', 1)
    assert scene_file.loads(text, "lin-case1.toml") == catalogue.scene("lin-case1")
    with pytest.raises(SceneError, match='kind: got "bearing"; allowed: "ball screw" with this lead'):
        scene_file.loads(text.replace('"ball screw"', '"bearing"', 1), "a.toml")
    ring = scene_text("bearing-9").replace("[material]", 'kind = "ball screw"\n[material]', 1)
    with pytest.raises(SceneError, match='allowed: "bearing" with this lead'):
        scene_file.loads(ring, "a.toml")


def test_kinds_of_friction_are_scenes_of_the_one_catalogue(tmp_path):
    names = set(catalogue.scene_names()) - set(catalogue.whole_names()) - set(catalogue.axis_names())
    assert {scene_file.kind_of(catalogue.shipped(name)) for name in names} == set(FRICTION_ONLY)
    assert catalogue.shipped("lin-pair-a") is catalogue.shipped("lin-pair-a"), "each is read once"
    with pytest.raises(
        SceneError, match=r'"linear pair"; allowed: "ball screw", "bearing"; .*rollbench friction lin-pair-a'
    ):
        catalogue.scene("lin-pair-a")
    with pytest.raises(InputError, match='kind: got "linear pair"; allowed: "screw run"'):
        catalogue.case("lin-pair-a", ScrewRunScene)
    path = tmp_path / "mine.toml"
    path.write_text(scene_text("lin-pair-a"))
    with pytest.raises(SceneError, match="rollbench friction"):
        scene_file.load(path)
    assert scene_file.kind_of(catalogue.any_scene(str(path))) == "linear pair"


def test_tables_that_tell_a_missing_kind_are_no_whole_scene_s():
    assert not scene_file.FOREIGN & SceneKeys.model_fields.keys()
    for kind in FRICTION_ONLY:
        assert scene_file.FOREIGN & KINDS[kind].keys.model_fields.keys(), kind
    with pytest.raises(SceneError, match=r"load: got .*did you mean loads"):
        scene_file.loads(template().replace("[[loads]]", "[[load]]"), "a.toml")


def test_one_schema_for_all_kinds():
    schema = json.loads(json.dumps(json_schema(), allow_nan=False))
    assert schema["$schema"].startswith("https://json-schema.org/")
    of_kind = [schema["$defs"][branch["$ref"].rsplit("/", 1)[1]] for branch in schema["oneOf"]]
    words = [table["properties"]["kind"] for table in of_kind]
    assert words[0]["enum"] == list(WHOLE)
    assert [w["const"] for w in words[1:]] == [*FRICTION_ONLY, AXIS]
    assert ["kind" in table["required"] for table in of_kind] == [False] + [True] * len(FRICTION_ONLY) + [False]
    shared = {"MaterialKeys", "GrooveKeys", "PathKeys", "HelixKeys", "BallSizeKeys", "MotionKeys", "TrackKeys"}
    assert shared <= schema["$defs"].keys()


def test_template_alternatives_load():
    text = template()
    lines = text.splitlines()
    shown = [i for i, line in enumerate(lines) if line.startswith("# or: ")]
    assert len(shown) == 10
    for i in shown:
        j = i - 1
        changed = [*lines[:j], lines[i].removeprefix("# or: "), *lines[i + 1 :]]
        if "azimuths" in lines[i]:
            changed.remove("count = 32")
        elif 'lead = "0 mm"' in lines[i]:
            changed = ["turns = 1" if x == "turns = 2" else x for x in changed]
            changed = ["count = 18" if x == "count = 32" else x for x in changed]
        if "displace" in lines[i]:
            changed = [x.removeprefix("# ") if x in lines[j - 3 : j] else x for x in changed]
        if lines[j].startswith("# ") and "displace" not in lines[i]:
            head = max(k for k in range(i) if lines[k].startswith("# ["))
            changed[head:j] = [x.removeprefix("# ") for x in changed[head:j]]
        scene_file.loads("\n".join(changed), "other.toml")


def schema_keys(schema: dict) -> set[str]:
    parts = [schema, *schema["$defs"].values()]
    return {key for part in parts for key in part["properties"]}


def model_keys(model: type) -> set[str]:
    found = set()
    for name, field in model.model_fields.items():
        found.add(name)
        for module, inner in re.findall(r"(compare\.scenes\.\w+)\.(\w+Keys)", repr(field.annotation)):
            found |= model_keys(getattr(sys.modules[module], inner))
    return found


def test_schema_names_and_describes_every_key():
    schema = json.loads(json.dumps(tidy_schema(SceneKeys)))
    assert schema_keys(schema) == model_keys(SceneKeys)
    assert {"groove_radius", "azimuths", "listed", "harmonic", "displace", "element_length"} <= schema_keys(schema)
    assert set(schema["required"]) == {"title", "track", "screw", "nut", "balls"}
    types = {"string", "number", "integer", "array", "object"}
    for table in (schema, *schema["$defs"].values()):
        assert table["type"] == "object"
        assert table["additionalProperties"] is False
        for name, node in table["properties"].items():
            assert len(node["description"]) > 3, name
            assert "anyOf" not in node
            assert node.get("default", "") is not None
            if "$ref" in node:
                assert node["$ref"].removeprefix("#/$defs/") in schema["$defs"]
                continue
            assert node["type"] in types, name
            assert node["examples"] or name in ("track", "screw", "nut", "balls"), name
            if "x-dimension" in node and node["type"] == "string":
                assert "x-unit" in node
            for item in (node.get("items", {}), node.get("additionalProperties", {})):
                assert not item or "$ref" in item or item["type"] in types


def test_schema_examples_and_defaults_are_valid():
    schema = tidy_schema(SceneKeys)
    base = tomllib.loads(template())
    for name, node in schema["$defs"]["TrackKeys"]["properties"].items():
        for value in [*node["examples"], *([node["default"]] if "default" in node else [])]:
            SceneKeys.model_validate(base | {"track": base["track"] | {name: value}})
    for name, node in schema["properties"].items():
        for value in node.get("examples", []):
            SceneKeys.model_validate(base | {name: value})


def test_conformity_is_groove_radius_over_ball_diameter():
    text = template().replace('groove_radius = "3.254 mm"', "conformity = 0.56")
    scene = scene_file.loads(text, "a.toml")
    assert scene.screw.groove_radius == scene.nut.groove_radius == pytest.approx(0.56 * 2 * 2.778e-3)


def test_part_material_takes_the_rest_from_the_default():
    text = template().replace("turns = 2\n", 'turns = 2\nmaterial = { youngs_modulus = "310 GPa" }\n')
    scene = scene_file.loads(text, "a.toml")
    assert (scene.balls.material.youngs_modulus, scene.balls.material.poissons_ratio) == (310e9, 0.28)
    assert scene.nut.material.youngs_modulus == 210e9


def test_starts_share_the_balls():
    text = template().replace('lead = "20 mm"\n', 'lead = "20 mm"\nstarts = 2\nphase = "90 deg"\n', 1)
    scene = scene_file.loads(text, "a.toml")
    assert scene.ball_count == 32
    assert len(scene.balls.azimuths) == 16
    assert sum(scene.balls.azimuths) / 16 == pytest.approx(math.pi / 2)


def test_byte_order_mark_and_windows_line_ends(tmp_path):
    path = tmp_path / "w.toml"
    path.write_bytes(b"\xef\xbb\xbf" + template().replace("\n", "\r\n").encode())
    assert scene_file.load(path).ball_count == 32


def test_hash_follows_the_text():
    assert scene_file.scene_hash("a") == "ca978112ca1bbdca"
    assert scene_file.scene_hash("a ") != scene_file.scene_hash("a")


def test_unknown_name_suggests_near_ones(tmp_path):
    with pytest.raises(InputError, match="lin-case1") as caught:
        catalogue.scene("lin-cas1")
    assert "\n" not in str(caught.value)
    (tmp_path / "mine.toml").write_text(template())
    assert catalogue.scene(str(tmp_path / "mine.toml")).name == "mine"


def test_imports_stay_light():
    code = (
        "import sys; from compare.scenes import catalogue; catalogue.scene_names(); "
        "heavy = {'gmsh', 'pyvista', 'matplotlib', 'scipy.spatial', 'pint'} & set(sys.modules); "
        "sys.exit(f'imported: {heavy}' if heavy else 0)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def to_toml(scene: Scene) -> str:
    """The scene in SI units, every key written, azimuths listed: floats by ``repr``, so nothing is lost."""
    m, rad = (lambda v: f'"{v!r} m"'), (lambda v: f'"{v!r} rad"')

    def array(values, unit):
        return "[" + ", ".join(f'"{v!r} {unit}"' for v in values) + "]"

    def material(part):
        return (
            f'material = {{ youngs_modulus = "{part.material.youngs_modulus!r} Pa", '
            f"poissons_ratio = {part.material.poissons_ratio!r} }}"
        )

    def terms(values):
        return (
            "["
            + ", ".join(
                f"{{ harmonic = {t.harmonic!r}, sin = {m(t.sin)}, cos = {m(t.cos)}, sigma = {m(t.sigma)} }}" for t in values
            )
            + "]"
        )

    t, s, n, b, e, i = scene.track, scene.screw, scene.nut, scene.balls, scene.errors, scene.ingredients
    lines = [
        f"title = {json.dumps(scene.title)}",
        f"source = {json.dumps(scene.source)}",
        f"assumed = {json.dumps(scene.assumed)}",
        f"members = {scene.members}",
        "[track]",
        f"pitch_radius = {m(t.pitch_radius)}\nlead = {m(t.lead)}\ncontact_angle = {rad(t.contact_angle)}",
        f'hand = "{t.hand}"\nstarts = {t.starts}\nphase = {rad(t.phase)}',
        "[screw]",
        f"length = {m(s.length)}\nouter_diameter = {m(s.outer_diameter)}\nbore = {m(s.bore)}",
        f"groove_radius = {m(s.groove_radius)}\n{material(s)}",
        "[nut]",
        f"position = {m(n.position)}\nlength = {m(n.length)}\nouter_diameter = {m(n.outer_diameter)}",
        f"groove_radius = {m(n.groove_radius)}\nazimuth = {rad(n.azimuth)}\n{material(n)}",
        "[balls]",
        f"radius = {m(b.radius)}\nazimuths = {array(b.azimuths, 'rad')}\n{material(b)}",
        f"[errors]\nseed = {e.seed}\n[errors.balls]\noversize = {m(e.balls.oversize)}",
        f"sigma = {m(e.balls.sigma)}",
        f'distribution = "{e.balls.distribution}"',
        "listed = {" + ", ".join(f"{k} = {m(v)}" for k, v in e.balls.listed) + "}",
    ]
    for name in SIDES:
        side = e.side(name)
        lines += [
            f"[errors.{name}]",
            f"profile = {array(side.profile, 'm')}\nprofile_sigma = {array(side.profile_sigma, 'm')}",
            f'pitch = {terms(side.pitch)}\npitch_along = "{side.pitch_along}"',
            f"roundness = {terms(side.roundness)}",
        ]
    for support in scene.supports:
        held = ", ".join(f"{f} = {(m if f[0] == 'u' else rad)(v)}" for f, v in support.fixed)
        lines.append(f"[[supports]]\nat = {m(support.at)}\ndisplace = {{ {held} }}")
    for load in scene.loads:
        force, moment = array(load.force, "N"), array(load.moment, "N m")
        lines.append(f"[[loads]]\nat = {m(load.at)}\nforce = {force}\nmoment = {moment}")
    lines += [
        f'[ingredients]\nhertz = "{i.hertz}"\nscrew = "{i.screw}"\npartition = "{i.partition}"',
        f'element_length = {m(i.element_length)}\nsection = "{i.section}"\narm = "{i.arm}"',
        "[solid]",
        *(
            f"{k} = {m(v)}" if isinstance(v, float) else f'{k} = "{v}"'
            for k, v in asdict(scene.solid).items()
            if v is not None
        ),
    ]
    if scene.friction is not None:
        f = scene.friction
        lines.append(f"[friction]\ncoefficient = {f.screw!r}\nnut = {f.nut!r}\nassumed = {json.dumps(f.assumed)}")
        lines.append(f'coupling = "{f.coupling}"')
        lines += [] if f.balls is None else [f"balls = {f.balls!r}"]
    if scene.motion is not None:
        lines.append(f'[motion]\nspeed = "{scene.motion.speed!r} rad/s"\nturns = "{scene.motion.turns}"')
    for name, table in (("circulation", scene.circulation), ("time", scene.time)):
        if table is not None:
            units = {"gap": m, "angle": rad, "output": json.dumps, "duration": lambda v: f'"{v!r} s"'}
            lines.append(f"[{name}]")
            lines += [f"{k} = {units.get(k, repr)(v)}" for k, v in asdict(table).items() if v is not None]
    return "\n".join(lines)


@pytest.mark.parametrize("name", NAMES)
def test_round_trip_in_si_units(name):
    scene = catalogue.scene(name)
    assert scene_file.loads(to_toml(scene), f"{name}.toml") == scene


def test_round_trip_of_every_key():
    full = re.sub(r"(?m)^# (?=\[|\w+ = )", "", template())
    full = full.replace('hand = "right"', 'hand = "left"').replace('bore = "0 mm"', 'bore = "5 mm"')
    full = full.replace('azimuth = "0 deg"', 'azimuth = "30 deg"').replace('"0 N m", "0 N m"]', '"1 N m", "2 N mm"]')
    full = full.replace('sin = "5 um"', 'sin = "5 um", cos = "1 um", sigma = "2 um"').replace('["0.1 um', '["0.2 um')
    full = full.replace('hertz = "nominal"', 'hertz = "as printed"').replace('section = "groove"', 'section = "full"')
    scene = scene_file.loads(full, "full.toml")
    assert scene.track.hand == "left"
    assert scene.screw.bore == 5e-3
    assert scene.nut.azimuth == math.pi / 6
    assert scene.loads[0].moment == (0.0, 1.0, 2e-3)
    assert scene.errors.SL.profile_sigma == (2e-7, 0.0)
    assert scene.errors.SL.roundness[0] == FourierTerm(2.0, 5e-6, 1e-6, 2e-6)
    assert (scene.ingredients.hertz, scene.ingredients.section) == ("as printed", "full")
    assert set(dict(scene.supports[1].fixed)) <= set(FREEDOMS)
    assert scene_file.loads(to_toml(scene), "full.toml") == scene
