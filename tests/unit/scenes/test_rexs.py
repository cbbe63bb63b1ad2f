"""REXS: a bearing arrangement goes out and comes back, results are those of the solution, what lacks is asked for."""

import dataclasses
import lzma
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from tests.axes import CASES, ON_A_SHAFT

import rollbench
from rollbench.compare.commands.export import write_axis_as_rexs
from rollbench.compare.commands.new import write_scene_from_rexs
from rollbench.compare.errors import ArgumentError, InputError, SceneError
from rollbench.compare.scenes import rexs_model

#: FVA's schema of REXS 1.7: fva-net/rexs-api-java, commit 5d44fdf (Apache License 2.0, beside it).
SCHEMA = Path(__file__).with_name("rexs_schema_1.7.xml.xz")

#: What a file does not hold, or names its origin.
NOT_HELD = {"name", "title", "source", "assumed", "screw", "seed", "slices"}


def numbers_of(record, path=""):
    """Every number and word of a record by its path, without what REXS does not hold."""
    if dataclasses.is_dataclass(record):
        names = [f.name for f in dataclasses.fields(record) if f.name not in NOT_HELD or (f.name == "screw" and path)]
        record = {name: getattr(record, name) for name in names}
    elif isinstance(record, (list, tuple)):
        record = dict(enumerate(record))
    if isinstance(record, dict):
        for key, value in record.items():
            yield from numbers_of(value, f"{path}.{key}")
    else:
        yield path, record


def assert_same(one, other):
    expected = {
        path: pytest.approx(value, rel=1e-12, abs=1e-18) if isinstance(value, float) else value
        for path, value in numbers_of(one)
    }
    assert dict(numbers_of(other)) == expected


def there_and_back(tmp_path, scene, *given):
    """The scene as REXS, and the scene that is read of that."""
    file, back = tmp_path / "out.rexs", tmp_path / "back.toml"
    write_axis_as_rexs(str(scene), file, "lin")
    write_scene_from_rexs(back, file, "", [*given])
    return file, back


def edited(tmp_path, **words):
    """The arrangement as REXS, with words in place of others."""
    file = tmp_path / "edited.rexs"
    write_axis_as_rexs(str(ON_A_SHAFT), file, "lin")
    text = file.read_text()
    for old, new in words.items():
        assert old in text
        text = text.replace(old, new)
    file.write_text(text)
    return file


def test_a_bearing_arrangement_comes_back_and_solves_alike(tmp_path):
    _, back = there_and_back(tmp_path, ON_A_SHAFT)
    assert_same(rollbench.read(ON_A_SHAFT), rollbench.read(back))
    one, two = (rollbench.solve(x, model="lin") for x in (ON_A_SHAFT, back))
    np.testing.assert_allclose(two.loads, one.loads, rtol=1e-7, atol=1e-6)


def test_load_cases_come_back_with_speeds_and_shares(tmp_path):
    scene = tmp_path / "cases.toml"
    scene.write_text(ON_A_SHAFT.read_text() + CASES)
    file, back = there_and_back(tmp_path, scene)
    one, two = rollbench.read(scene), rollbench.read(back)
    assert two.revolution_shares == pytest.approx(one.revolution_shares)
    for a, b in zip(one.cases, two.cases, strict=True):
        assert b.speed == pytest.approx(a.speed)
        assert_same(a.scene.loads, b.scene.loads)
    spectrum = rexs_model.read_rexs_file(file).load_cases
    assert len(spectrum) == 2
    assert [x[1]["operating_time_fraction"] for x in spectrum] == [20.0, 80.0]


def test_rollers_come_back_with_the_depth_that_is_asked_for(tmp_path):
    with pytest.raises(SceneError, match=r"ring_depth.*left 1\.rollers\.ring_depth") as caught:
        there_and_back(tmp_path, "smith-axis-taper")
    assert len(caught.value.lines()) == 4
    names = ("left 1", "left 2", "right 1", "right 2")
    given = [f"{x}.rollers.{key}" for x in names for key in ("ring_depth=5 mm", "edge_radius=1 mm")]
    _, back = there_and_back(tmp_path, "smith-axis-taper", *given)
    before = {s.name: s for s in rollbench.read("smith-axis-taper").sets}
    for s in rollbench.read(back).sets:
        assert s.thrust == before[s.name].thrust
        assert_same(dataclasses.replace(before[s.name].parts, depth=5e-3), s.parts)


def test_results_are_those_of_the_solution(tmp_path):
    file = tmp_path / "out.rexs"
    write_axis_as_rexs(str(ON_A_SHAFT), file, "lin")
    model, solved = rexs_model.read_rexs_file(file), rollbench.solve(ON_A_SHAFT, model="lin")
    case = model.load_cases[0]
    bearings = {c.name: c.id for c in model.components.values() if c.type == "rolling_bearing_with_detailed_geometry"}
    total = np.zeros(3)
    for name, one in solved.sets.items():
        found = case[bearings[name]]
        force = np.array([found[f"force_acting_on_inner_component_{axis}"] for axis in "vwu"])
        np.testing.assert_allclose(force, one.force, rtol=1e-9, atol=1e-9)
        total += force
        key = "nominal_reference_rating_life_{}_iso_16281_2008"
        assert found[key.format("rotations")] == pytest.approx(1e-6 * one.life.L10)
        assert found[key.format("time")] == pytest.approx(one.life.seconds / 3600.0)
        row = model.parts(bearings[name], "rolling_bearing_row")[0]
        inner = [model.parts(x.id, "rolling_element_contact")[0] for x in model.parts(row.id, "rolling_element")]
        elements = [1e3 * case[x.id]["rolling_element_force"] for x in inner]
        np.testing.assert_allclose(elements, one.loads[:, :2].max(axis=1), rtol=1e-9, atol=1e-9)
        assert found["operating_point_stiffness_f_u_d_u"] == pytest.approx(one.stiffness[2, 2])
        assert found["operating_point_stiffness_m_v_rot_v"] == pytest.approx(1e3 * one.stiffness[3, 3])
    np.testing.assert_allclose(total, [-2000.0, 0.0, -1000.0], atol=1e-6)


def test_a_nut_goes_out_as_its_load(tmp_path):
    file = tmp_path / "axis.rexs"
    write_axis_as_rexs("axis-fixed-fixed", file, "lin")
    model = rexs_model.read_rexs_file(file)
    loads = [c for c in model.components.values() if c.type == "external_load"]
    assert [x.name for x in loads] == ["nut"]
    solved = rollbench.solve("axis-fixed-fixed", model="lin").sets["nut"]
    assert loads[0].number("force_u_direction") == pytest.approx(solved.force[2])


def test_two_rows_of_one_bearing_stand_apart(tmp_path):
    file = edited(tmp_path)
    model = rexs_model.read_rexs_file(file)
    left, right = (c for c in model.components.values() if c.name in ("left", "right") and "bearing_type" in c.attributes)
    rows = [r for r in model.relations if r.type == "ordered_assembly" and r.roles["assembly"] == right.id]
    model.relations = [r for r in model.relations if r not in rows and r.roles.get("assembly") != right.id]
    model.add_relation("ordered_assembly", 2, assembly=left.id, part=rows[0].roles["part"])
    left.attributes |= {"distance_between_bearing_rows": 16.0, "u_coordinate_on_shaft_inner_side": 38.0}
    left.attributes.pop("preload_distance")
    file.write_text(rexs_model.rexs_file_text(model, "1", "2026-01-01T00:00:00+00:00"))
    back = tmp_path / "two.toml"
    write_scene_from_rexs(back, file, "", [])
    found = {s.name: (s.position, s.thrust) for s in rollbench.read(back).sets}
    assert found["left row 1"] == (pytest.approx(0.030), "-z")
    assert found["left row 2"] == (pytest.approx(0.046), "+z")


def test_what_is_missing_is_asked_for_and_filled_in(tmp_path):
    file = edited(tmp_path, raceway_radius_of_outer_ring="some_other_attribute")
    with pytest.raises(SceneError) as caught:
        write_scene_from_rexs(tmp_path / "no.toml", file, "", [])
    first, *others = caught.value.lines()
    for words in ("attribute raceway_radius_of_outer_ring", "mm", '--set "left.nut.groove_radius=VALUE"'):
        assert words in first
    assert (len(others), (tmp_path / "no.toml").exists()) == (2, False)
    given = [f"{x}.nut.groove_radius=5 mm" for x in ("left", "right", "free")]
    write_scene_from_rexs(tmp_path / "yes.toml", file, "", given)
    assert_same(rollbench.read(ON_A_SHAFT), rollbench.read(tmp_path / "yes.toml"))


FAULTS = [
    ({'unit="deg"': 'unit="rad"'}, "pressure_angle|angular_position"),
    ({'version="1.7"': 'version="2.0"'}, "model"),
    ({">angular_contact_ball_bearing<": ">radial_roller_bearing<"}, "bearing_type"),
    ({">negative<": ">both_directions<"}, "axial_force_absorption_of_row"),
    ({'<attribute id="width" unit="mm">16<': '<attribute id="width" unit="mm">wide<'}, "width"),
    ({"<relations>": "<relations><relation id='999' type='side'><ref id='9999' role='x'/></relation>"}, "9999"),
    ({"</model>": ""}, "file"),
    ({"<model": "<!DOCTYPE model><model"}, "DOCTYPE"),
]


@pytest.mark.parametrize(("words", "named"), FAULTS)
def test_a_faulty_file_is_refused_where_it_is_faulty(tmp_path, words, named):
    with pytest.raises(InputError, match=named):
        write_scene_from_rexs(tmp_path / "no.toml", edited(tmp_path, **words), "", [])


def test_unknown_shafts_and_keys_are_refused(tmp_path):
    file = edited(tmp_path)
    ratio = ["material.poissons_ratio=steel"]
    wrong = (("7", [], "shaft"), ("", ["left.nose=1 mm"], "left.nose"), ("", ["left"], "KEY=VALUE"), ("", ratio, "set"))
    for shaft, given, named in wrong:
        with pytest.raises(ArgumentError, match=named):
            write_scene_from_rexs(tmp_path / "no.toml", file, shaft, given)


@pytest.mark.parametrize("scene", [ON_A_SHAFT, "smith-axis-taper"])
def test_components_attributes_and_relations_are_those_of_the_schema(tmp_path, scene):
    write_axis_as_rexs(str(scene), tmp_path / "out.rexs", "lin")
    with lzma.open(SCHEMA) as file:
        schema = ET.parse(file).getroot()
    units = {x.get("id"): x.get("name") for x in schema.find("units")}
    unit = {x.get("attributeId"): units[x.get("unit")] for x in schema.find("attributes")}
    words = {x.get("attributeId"): {v.get("value") for v in x.find("enumValues")} for x in schema.find("attributes")}
    pairs = {(x.get("componentId"), x.get("attributeId")) for x in schema.find("componentAttributeMappings")}
    allowed = {
        (r.get("relationId"), frozenset((x.get("roleId"), x.get("componentId")) for x in one))
        for r in schema.find("relations")
        for one in r.find("allowedCombinations")
    }
    root = ET.parse(tmp_path / "out.rexs").getroot()
    types = {x.get("id"): x.get("type") for x in root.find("components")}
    for relation in root.find("relations"):
        assert (relation.get("type"), frozenset((x.get("role"), types[x.get("id")]) for x in relation)) in allowed
    for component in root.iter("component"):
        for x in component:
            assert (component.get("type"), x.get("id")) in pairs
            assert x.get("unit") == unit[x.get("id")]
            assert not words[x.get("id")] or x.text in words[x.get("id")]


@pytest.mark.parametrize("words", ["--rexs a.rexs --ross b.py", "--rexs a.rexs --format msh", "--ross b.py --model lin"])
def test_options_that_would_do_nothing_are_refused(command, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    command.refused("export", "smith-axis-taper", *words.split())
    assert not list(tmp_path.iterdir())
