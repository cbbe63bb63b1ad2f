"""Scene files with several rolling sets: what is read, what is refused, templates, the command line."""

import re
import tomllib

import pytest
from tests.shipped_texts import own_text

from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue, scene_file, scene_tables
from rollbench.meshes.axis import Assembly, RollerRow

ROLLERS = own_text("rollers")


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
    text = re.sub(r"(?m)^\[(track|nut|balls)\]", r"[sets.\1]", catalogue.shipped_scene_text("lin-nominal-4p1"))
    text = text.replace("[sets.", '[[sets]]\nname = "nut"\n[sets.', 1)
    assert scene_file.parse_scene(text, "lin-nominal-4p1.toml") == plain


def test_models_and_commands_of_one_set_refuse_several_with_the_reason():
    with pytest.raises(SceneError, match="2 sets"):
        catalogue.scene("double-nut")
    with pytest.raises(InputError, match="mei does not solve several nuts or bearing rows: its bars"):
        run_model(catalogue.shipped_scene("double-nut"), "mei")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """File of a small double nut."""
    text = catalogue.shipped_scene_text("double-nut").replace("count = 68\nturns = 4.3", "count = 8\nturns = 1.5")
    path = tmp_path_factory.mktemp("axis") / "two.toml"
    path.write_text(text.replace("coefficient = 0.05", 'coefficient = 0.05\ncoupling = "none"'), encoding="utf-8")
    return path


def test_sums_of_several_sets(command, small):
    two = command.answer("solve", small, "--model", "lin")
    largest = [s["largest_load_N"] for s in two["sets"]]
    assert two["summary"]["loads"]["max_N"] == largest[two["summary"]["worst_set"] - 1] == max(largest)
    first, second = (s["summary"]["preload"]["axial_N"] for s in two["sets"])
    assert first == pytest.approx(-second, rel=1e-9)
    axial = two["summary"]["load_point"]
    assert axial["force_N"] == 2000.0
    assert axial["lost_motion_um_per_100N"] == pytest.approx(200.0 / axial["tangent_N_per_um"], rel=1e-9)


def test_commands_say_why_they_do_not_work(command, small):
    code, out, _ = command("check", small, "--no-compute", "--model", "lin")
    assert out.startswith("NOT COVERED: two by lin")
    assert "no run of its 3D reference is stored" in " ".join(out.split())
    assert code == 4
    for words, why in (
        (("--members", "3"), "no random error"),
        (("--all",), "--all: got"),
        (("--member", "1"), "the scene has no random geometric errors"),
        (("--stiffness-at", "9 m"), "0 mm to"),
    ):
        assert why in command.refused("solve", small, *words)


def test_a_ring_whose_land_does_not_cut_its_groove_is_a_fault_of_its_diameter() -> None:
    tables = tomllib.loads(catalogue.shipped_scene_text("axis-fixed-fixed"))
    del tables["sets"][1]["screw"]["outer_diameter"]
    with pytest.raises(SceneError, match=r"sets\[1\]\.screw\.outer_diameter: got nothing; allowed: above 38.856 mm, below"):
        scene_tables.scene_from_tables(tables, "axis.toml")


def test_a_groove_far_smaller_than_its_balls_is_one_fault() -> None:
    tables = tomllib.loads(catalogue.shipped_scene_text("axis-fixed-fixed"))
    tables["sets"][0]["screw"] = {"groove_radius": "1 mm"}
    with pytest.raises(SceneError, match=r"sets\[0\]\.screw\.groove_radius: got .1 mm.; allowed: a groove radius above"):
        scene_tables.scene_from_tables(tables, "axis.toml")
