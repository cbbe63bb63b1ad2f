"""Scene files with several rolling sets: what is read, what is refused, templates, the command line."""

import json
import tomllib

import numpy as np
import pytest

from compare.cli import main
from compare.errors import InputError, SceneError
from compare.models.axis import AXIS_MODELS, run_axis
from compare.scenes import catalogue, scene_file
from compare.scenes.catalogue import scene_text
from compare.scenes.kinds.table import json_schema
from compare.scenes.template import AXES, template
from compare.scenes.units import show
from meshes.axis import Assembly, RollerRow
from meshes.parts import Scene

ROLLERS = """
title = "rollers"
[material]
youngs_modulus = "30e6 psi"
poissons_ratio = 0.3
[screw]
length = "12 in"
outer_diameter = "1.5 in"
conformity = 0.54
[heat]
warming = "10 K"
expansion = 1e-5
[[supports]]
at = "6 in"
fix = ["ux", "uy", "uz", "rx", "ry", "rz"]
[[sets]]
name = "taper"
thrust = "+z"
position = "2 in"
housing = "box"
[sets.rollers]
count = 16
diameter = "0.33 in"
length = "0.49 in"
cup_angle = "30.8 deg"
roller_angle = "4 deg"
ring_depth = "5 mm"
[[housings]]
name = "box"
at = "2 in"
fix = ["ux", "uy", "rx", "ry", "rz"]
springs = { uz = "1e6 lbf/in" }
force = ["0 N", "0 N", "-100 lbf"]
"""


def test_shipped_axes_are_named_apart_from_whole_screws():
    assert set(catalogue.axis_names()) >= {"axis-fixed-fixed", "double-nut", "smith-axis", "lin-steering-rack"}
    assert not set(catalogue.axis_names()) & set(catalogue.whole_names())
    for name in catalogue.axis_names():
        found = catalogue.shipped(name)
        assert isinstance(found, Assembly)
        assert found.assumed
        assert all(sentence.endswith(".") for sentence in found.assumed)


@pytest.mark.parametrize("kind", AXES)
def test_templates_are_read_as_they_stand(kind):
    found = scene_file.read(template(kind.replace(" ", "-")), "mine.toml")
    assert isinstance(found, Assembly)
    assert found.title == f"My {kind}"
    assert not found.source


def test_units_positions_and_heat_are_read():
    found = scene_file.read(ROLLERS, "rollers.toml")
    assert isinstance(found, Assembly)
    (taper,) = found.sets
    assert isinstance(taper.parts, RollerRow)
    assert taper.kind == "tapered roller bearing"
    assert taper.position == pytest.approx(2.0 * 0.0254)
    assert found.thermal_strain == pytest.approx(1e-4)
    assert found.housings[0].stiffness[2][2] == pytest.approx(1e6 * 4.4482216152605 / 0.0254)
    result = run_axis(found)
    assert result.model == "lin"
    assert result.converged


def test_one_set_that_stands_is_a_plain_scene():
    plain = scene_file.loads(scene_text("lin-nominal-4p1"), "lin-nominal-4p1.toml")
    raw = tomllib.loads(scene_text("lin-nominal-4p1"))
    one = {name: raw.pop(name) for name in ("track", "nut", "balls")}
    lines = [f"{k} = {show(v)}" for k, v in raw.items() if k not in ("supports", "loads")]
    lines += [
        f"[[{k}]]\n" + "\n".join(f"{a} = {show(b)}" for a, b in row.items())
        for k in ("supports", "loads")
        for row in raw[k]
    ]
    lines += ['[[sets]]\nname = "nut"', *(f"{k} = {show(v)}" for k, v in one.items())]
    found = scene_file.read("\n".join(lines), "lin-nominal-4p1.toml")
    assert isinstance(found, Scene)
    assert found == plain


def test_circuits_with_gaps_fill_their_arcs_evenly():
    nut = next(s.parts for s in catalogue.shipped("axis-fixed-fixed").sets if s.name == "nut")
    at = np.degrees(nut.balls.azimuths)
    assert at.size == 45
    assert ((at > -720.0) & (at < -180.0)).sum() == 23 - (at[22] > 0.0)
    assert not ((at > -180.0) & (at < 180.0)).any()
    steps = np.diff(at)
    assert np.ptp(np.delete(steps, np.argmax(steps))) < 1e-9


def test_sets_take_what_catalogues_print():
    text = scene_text("double-nut")
    for own, printed in (
        ('youngs_modulus = "210 GPa"\npoissons_ratio = 0.3', 'name = "bearing steel"'),
        ('pitch_radius = "16.6 mm"', 'pitch_diameter = "33.2 mm"'),
        ('\nradius = "3.175 mm"', '\ndiameter = "6.35 mm"'),
    ):
        assert own in text
        text = text.replace(own, printed)
    assert scene_file.read(text, "double-nut.toml") == catalogue.shipped("double-nut")


BROKEN = {
    'housing = "box"': ('housing = "bx"', "sets[0].housing", "a name under [[housings]]: box"),
    'thrust = "+z"': ('thrust = "both"', "sets[0].thrust", '"+z" or "-z"'),
    'position = "2 in"': ('position = "20 in"', "sets[0].position", "0 mm to 304.8 mm"),
    'springs = { uz = "1e6 lbf/in" }': ('springs = { uz = "-1 N/um" }', "housings[0].springs.uz", "0 N/m to"),
    "[[sets]]": ("[[set]]", "set", "sets"),
    'roller_angle = "4 deg"': ('roller_angle = "20 deg"', "sets[0].rollers.roller_angle", "below half the cup's angle"),
    "expansion = 1e-5": ("expansion = 1", "heat.expansion", "0 to 0.001"),
}


@pytest.mark.parametrize("line", BROKEN)
def test_mistakes_are_refused_by_key(line):
    other, key, allowed = BROKEN[line]
    with pytest.raises(SceneError) as refused:
        scene_file.read(ROLLERS.replace(line, other, 1), "rollers.toml")
    assert refused.value.key == key
    assert allowed in refused.value.allowed


NUT = {
    "count = 68\nturns = 4.3": ("count = 68", "sets[0].balls.turns"),
    'offset = "-4 um"': ('preload = "500 N"', "sets[0].preload"),
    'position = "168 mm"': ('position = "10 mm"', "sets[0].nut.position"),
    'radius = "3.175 mm"': ('radius = "4.5 mm"', "sets[0].balls.count"),
}


@pytest.mark.parametrize("line", NUT)
def test_faults_of_a_set_are_named_in_its_table(line):
    other, key = NUT[line]
    with pytest.raises(SceneError) as refused:
        scene_file.read(scene_text("double-nut").replace(line, other, 1), "double-nut.toml")
    assert refused.value.key.startswith(key.rsplit(".", 1)[0])


def test_commands_of_one_set_refuse_several_with_the_reason():
    with pytest.raises(SceneError, match="2 sets"):
        catalogue.scene("double-nut")
    with pytest.raises(InputError, match="the other models describe one set"):
        run_axis(catalogue.shipped("double-nut"), "mei")
    assert AXIS_MODELS == ("refined", "lin")
    for kind in ("compare", "mesh-study", "export", "condense"):
        with pytest.raises(SystemExit) as stopped:
            main([kind, "double-nut", *(["screw"] if kind == "export" else [])])
        assert stopped.value.code == 2


def test_schema_knows_axes():
    text = json.dumps(json_schema())
    assert "rolling sets, in any order" in text
    assert "cup_angle" in text


def test_solve_and_friction_begin_rows_with_their_set(capsys, tmp_path):
    small = scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.5")
    small = small.replace("coefficient = 0.05", 'coefficient = 0.05\ncoupling = "none"')
    path = tmp_path / "two.toml"
    path.write_text(small, encoding="utf-8")
    for command in (["solve", str(path), "--model", "lin"], ["friction", str(path), "--model", "lin"]):
        with pytest.raises(SystemExit) as stopped:
            main([*command, "--json"])
        assert stopped.value.code == 0
        data = json.loads(capsys.readouterr().out)
        assert [next(iter(row)) for row in data["balls"]] == ["set"] * 16
        assert [(row["set"], row["index"]) for row in data["balls"]][8] == (2, 1)
        assert [s["name"] for s in data["sets"]] == ["nut 1", "nut 2"]
    total = sum(s["friction_torque_Nmm"] for s in data["sets"])
    assert data["torque"]["friction_torque_Nmm"] == pytest.approx(total, rel=1e-12)
    with pytest.raises(SystemExit):
        main(["solve", str(path), "--model", "lin"])
    assert "tangent stiffness of the whole, shaft at 0 mm" in capsys.readouterr().out
