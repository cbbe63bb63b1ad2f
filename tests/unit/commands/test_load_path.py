"""Loads on held freedoms: what supports take of them is told, and little that reaches the contacts is warned of."""

import re

import pytest
from tests.shipped_texts import own_text

from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.template import commented_template, new_scene_text

pytestmark = pytest.mark.slow

SCREW, AXIS = new_scene_text("ball screw", "25x5"), catalogue.shipped_scene_text("axis-fixed-fixed")
FIX = 'fix = ["ux", "uy", "rx", "ry", "rz"]'
HELD = {
    "fixed": 'fix = ["ux", "uy", "uz", "rx", "ry", "rz"]',
    "held at zero": f'{FIX}\ndisplace = {{ uz = "0 um" }}',
    "displaced": f'{FIX}\ndisplace = {{ uz = "2 um" }}',
}


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("model", ["lin", "refined"])
def test_an_axial_load_that_a_support_takes_is_warned_of(command, scene_file, held: str, model: str) -> None:
    """Displacement and preload load the contacts all the same: what counts is what the load changes."""
    file = scene_file(SCREW, (FIX, HELD[held]))
    code, found = command.json("solve", file, "--model", model, "--strict", "--json")
    path = found["summary"]["load_path"]
    force = path["applied"]["force_N"][2]
    taken = {x["name"]: x["force_N"][2] for x in path["supports"]}
    assert code == 1
    assert "reaches the contacts" in found["warning"]
    assert max(taken.values(), key=abs) == pytest.approx(force, rel=2e-3)
    assert sum(taken.values()) + path["contacts"]["force_N"][2] == pytest.approx(force, rel=1e-6)
    assert command("solve", file, "--model", model).code == 0


PLACES = {"0 mm": '["ux"]', "200 mm": '["ux"]', "100 mm": '["uy", "rx", "rz"]'}
TWO_SUPPORTS = "".join(f'[[supports]]\nat = "{at}"\nfix = {fix}\n\n' for at, fix in PLACES.items())


def test_supports_of_a_rigid_screw_share_what_statics_divides(command, scene_file) -> None:
    text = re.sub(r"(?s)\[\[supports\]\].*?(?=\[\[loads\]\])", TWO_SUPPORTS, own_text("public/s4-tilted-nut"))
    file = scene_file(text, ('["0 N", "0 N", "3000 N"]', '["400 N", "0 N", "3000 N"]'))
    found = command.answer("solve", file, "--model", "lin")
    path = found["summary"]["load_path"]
    parts = [x["force_N"][0] for x in path["supports"]]
    assert sum(parts) + path["contacts"]["force_N"][0] == pytest.approx(400.0, rel=1e-6)
    assert found["warning"] is None


HOLDS = {
    "the carriage is displaced along the axis": ("# displace = { uz", "displace = { uz"),
    "it stands on stiff springs": ("# displace = { uz", 'springs = { uz = "100000 N/um" }\n# displace = { uz'),
}


@pytest.mark.parametrize("held", HOLDS)
def test_a_load_that_a_frame_takes_does_not_hide_behind_one_on_the_shaft(command, scene_file, held: str) -> None:
    push = "[[housings]]", '[[loads]]\nat = "0 mm"\nforce = ["0 N", "0 N", "2 kN"]\n\n[[housings]]'
    for hold in ((), (HOLDS[held],)):
        code, found = command.json("solve", scene_file(AXIS, *hold, push), "--model", "lin", "--strict", "--json")
        warned = [w for w in found["warnings"] if "reaches the contacts" in w]
        assert code == len(warned) == len(hold)
        assert all("3000 N on carriage" in w for w in warned)


SOFT = "# displace = { uz", 'springs = { uz = "50 N/um" }\n# displace = { uz'


@pytest.mark.parametrize("scene", [(SCREW,), (AXIS,), (AXIS, SOFT)], ids=["screw", "axis", "axis on soft springs"])
def test_usual_supports_soft_springs_and_bearings_are_not_warned_of(command, scene_file, scene) -> None:
    code, found = command.json("solve", scene_file(*scene), "--model", "lin", "--strict", "--json")
    assert (code, found["warning"]) == (0, None)
    if scene == (SCREW,):
        path = found["summary"]["load_path"]
        assert path["contacts"]["force_N"][2] == pytest.approx(path["applied"]["force_N"][2], rel=1e-6)


def test_a_preload_of_a_nut_that_carries_thrust_both_ways_is_refused_by_its_thrust(command, scene_file) -> None:
    error = command.refused("solve", scene_file(AXIS, ('name = "nut"\n', 'name = "nut"\npreload = "2 kN"\n')))
    assert "sets[0].preload" in error
    assert "sets[0].thrust" in error


SHOULDERS = {
    name: catalogue.shipped_scene_text(name) for name in ("smith-axis", "smith-axis-supported", "smith-axis-tandem")
}
SHOULDERS |= {kind: commented_template(kind) for kind in ("support-bearings", "angular-contact-bearing")}


@pytest.mark.parametrize("name", [*SHOULDERS, "axis-fixed-fixed"])
def test_shoulders_that_are_assumed_carry_the_ellipses(command, scene_file, name: str) -> None:
    found = command.answer("solve", scene_file(SHOULDERS.get(name, AXIS)), "--model", "lin")
    assert {s["summary"]["truncation"]["contacts_cut"] for s in found["sets"]} == {0}
    assert not any("beyond the groove's arc" in words for words in found["warnings"])
