"""Scene files with several rolling sets: what is read, what is refused, templates, the command line."""

import csv
import json
import tomllib

import numpy as np
import pytest
from scipy.io import mmread
from tests.shipped_texts import axis_names, own_text

from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.models.registry import AXIS_MODELS, MODELS, Model, run_model
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.friction_kinds import table as kind_table
from rollbench.compare.scenes.template import AXES, BEARINGS, commented_template
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.units import toml_text

ROLLERS = own_text("rollers")


def test_shipped_axes_are_named_apart_from_whole_screws():
    assert set(axis_names()) >= {"axis-fixed-fixed", "double-nut", "smith-axis-taper", "lin-steering-rack"}
    assert not set(axis_names()) & set(catalogue.names_of_single_nut_scenes())
    for name in axis_names():
        found = catalogue.shipped_scene(name)
        assert isinstance(found, Assembly)
        assert found.assumed
        assert all(sentence.endswith(".") for sentence in found.assumed)


@pytest.mark.parametrize("kind", [*AXES, *BEARINGS])
def test_templates_are_read_as_they_stand(kind):
    found = scene_file.parse_scene(commented_template(kind.replace(" ", "-")), "mine.toml")
    assert isinstance(found, Assembly)
    assert found.title == f"My {kind}"
    assert not found.source


def test_units_positions_and_heat_are_read():
    found = scene_file.parse_scene(ROLLERS, "rollers.toml")
    (taper,) = found.sets
    assert (type(found), type(taper.parts), taper.kind) == (Assembly, RollerRow, "tapered roller bearing")
    assert taper.position == pytest.approx(2.0 * 0.0254)
    assert found.thermal_strain == pytest.approx(1e-4)
    assert found.housings[0].stiffness[2][2] == pytest.approx(1e6 * 4.4482216152605 / 0.0254)
    result = run_model(found)
    assert (result.model, result.converged) == ("refined", True)


def test_one_set_that_stands_is_a_plain_scene():
    plain = scene_file.scene_from_text(catalogue.shipped_scene_text("lin-nominal-4p1"), "lin-nominal-4p1.toml")
    raw = tomllib.loads(catalogue.shipped_scene_text("lin-nominal-4p1"))
    one = {name: raw.pop(name) for name in ("track", "nut", "balls")}
    tables = [("", {k: v for k, v in raw.items() if k not in ("supports", "loads")})]
    tables += [(f"[[{k}]]", row) for k in ("supports", "loads") for row in raw[k]]
    tables += [("[[sets]]", {"name": "nut"} | one)]
    lines = [line for head, table in tables for line in (head, *(f"{k} = {toml_text(v)}" for k, v in table.items()))]
    assert scene_file.parse_scene("\n".join(lines), "lin-nominal-4p1.toml") == plain


def test_circuits_with_gaps_fill_their_arcs_evenly():
    nut = next(s.parts for s in catalogue.shipped_scene("axis-fixed-fixed").sets if s.name == "nut")
    at = np.degrees(nut.balls.azimuths)
    assert at.size == 45
    assert ((at > -720.0) & (at < -180.0)).sum() == 23 - (at[22] > 0.0)
    assert not ((at > -180.0) & (at < 180.0)).any()
    steps = np.diff(at)
    assert np.ptp(np.delete(steps, np.argmax(steps))) < 1e-9


def test_sets_take_what_catalogues_print():
    text = catalogue.shipped_scene_text("double-nut")
    for shipped, printed in (
        ('youngs_modulus = "210 GPa"\npoissons_ratio = 0.3', 'name = "bearing steel"'),
        ('pitch_radius = "16.6 mm"', 'pitch_diameter = "33.2 mm"'),
        ('\nradius = "3.175 mm"', '\ndiameter = "6.35 mm"'),
    ):
        assert shipped in text
        text = text.replace(shipped, printed)
    assert scene_file.parse_scene(text, "double-nut.toml") == catalogue.shipped_scene("double-nut")


def test_models_and_commands_of_one_set_refuse_several_with_the_reason(monkeypatch):
    with pytest.raises(SceneError, match="2 sets"):
        catalogue.scene("double-nut")
    assert AXIS_MODELS == ("refined", "lin", "lin-source-partition", "lin-cell", "lin-nut")
    monkeypatch.setitem(MODELS, "new", Model("new", "a new one", "new", "new", MODELS["mei"].solve_scene))
    for name, words in (
        ("mei", "mei does not solve several nuts or bearing rows: its bars"),
        ("none", "choose one of these"),
        ("new", "new does not solve several nuts or bearing rows: it solves scenes with a single nut"),
    ):
        with pytest.raises(InputError, match=words):
            run_model(catalogue.shipped_scene("double-nut"), name)


def test_schema_knows_axes():
    text = json.dumps(kind_table.scene_json_schema())
    assert all(words in text for words in ("ball nuts and bearings, in any order", "cup_angle"))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """File of a small double nut."""
    text = catalogue.shipped_scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.5")
    path = tmp_path_factory.mktemp("axis") / "two.toml"
    path.write_text(text.replace("coefficient = 0.05", 'coefficient = 0.05\ncoupling = "none"'), encoding="utf-8")
    return path


def test_result_has_the_keys_of_one_set(command, small):
    one, two = (command.answer("solve", scene, "--model", "lin") for scene in ("two-balls", small))
    assert set(one) <= set(two)
    shared = {"sides", "loads", "axial", "worst_contact", "truncation", "static_safety", "life", "rating_refused"}
    assert shared <= set(one["summary"]) & set(two["summary"])
    assert shared - {"axial"} <= set(two["sets"][1]["summary"])
    largest = [s["largest_load_N"] for s in two["sets"]]
    assert two["summary"]["loads"]["max_N"] == largest[two["summary"]["worst_set"] - 1] == max(largest)
    first, second = (s["summary"]["preload"]["axial_N"] for s in two["sets"])
    assert first == pytest.approx(-second, rel=1e-9)
    axial = two["summary"]["axial"]
    assert axial["force_N"] == 2000.0
    assert axial["lost_motion_um_per_100N"] == pytest.approx(200.0 / axial["tangent_N_per_um"], rel=1e-9)


def test_tables_files_and_stations_of_several_sets(command, small, tmp_path):
    files = "--stiffness-at", "100 mm", "--matrix", tmp_path / "k.mtx"
    code, out, _ = command("solve", small, "--model", "lin", *files)
    assert (code, "angle deg" in out, "shaft at 100 mm" in out) == (0, False, True)
    assert command("solve", small, "--model", "lin", "--curve", "0N:3kN:16:100mm", "--csv", tmp_path / "c.csv").code == 0
    rows = list(csv.DictReader((tmp_path / "c.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 16
    before, last, after = rows[9:12]
    assert float(last["load_N"]) == 2000.0
    slope = 400.0 / (float(after["displacement_um"]) - float(before["displacement_um"]))
    matrix = np.asarray(mmread(tmp_path / "k.mtx"))
    assert slope == pytest.approx(1e-6 / np.linalg.inv(matrix)[2, 2], rel=2e-3)
    assert float(last["stiffness_N_per_um"]) == pytest.approx(1e-6 / np.linalg.inv(matrix)[2, 2], rel=1e-5)
    code, out, _ = command("solve", small, "--model", "lin-nut", "--balls")
    assert (code, "angle deg" in out) == (0, True)


def test_commands_work_or_say_why_not(command, small, tmp_path):
    code, out, _ = command("check", small, "--no-compute", "--model", "lin")
    assert out.startswith("NOT COVERED: two by lin")
    assert "no run of its 3D reference is stored" in " ".join(out.split())
    assert code == 4
    vary = "--vary", "sets[0].offset=-6 um:-2 um", "--samples", "2", "--model", "lin", "--out", tmp_path / "s"
    assert command("sweep", small, *vary).code == 0
    rows = list(csv.DictReader((tmp_path / "s" / "samples.csv").read_text(encoding="utf-8").splitlines()))
    assert {(row["status"], row["at"][:7]) for row in rows} == {("converged", "nut 1: ")}
    by_offset = sorted(rows, key=lambda row: float(row["sets[0].offset"].split()[0]))
    assert float(by_offset[0]["largest_load_N"]) > float(by_offset[-1]["largest_load_N"])
    for tokens, why in (
        (("solve", small, "--members", "3"), "no random error"),
        (("solve", small, "--all"), "--all: got"),
        (("solve", small, "--member", "1"), "the scene has no random geometric errors"),
        (("sweep", small, *vary[:-3], "mei", "--out", tmp_path / "t"), "refined, lin, lin-source-partition, lin-cell"),
        (("solve", small, "--stiffness-at", "9 m"), "0 mm to"),
    ):
        assert why in command.refused(*tokens)


def test_solve_and_friction_begin_rows_with_their_set(command, small):
    for word in ("solve", "friction"):
        data = command.answer(word, small, "--model", "lin")
        assert [next(iter(row)) for row in data["balls"]] == ["set"] * 16
        assert [(row["set"], row["index"]) for row in data["balls"]][8] == (2, 1)
        assert [s["name"] for s in data["sets"]] == ["nut 1", "nut 2"]
    total = sum(s["friction_torque_Nmm"] for s in data["sets"])
    assert data["torque"]["friction_torque_Nmm"] == pytest.approx(total, rel=1e-12)
    _, out, _ = command("solve", small, "--model", "lin", "--verbose")
    assert "tangent stiffness of the whole axis, shaft at 0 mm" in out
