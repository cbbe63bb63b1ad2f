"""Loads on held freedoms: what supports take of them is told, and little that reaches the contacts is warned of."""

import re
from pathlib import Path

import pytest

from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes import template as like
from rollbench.compare.scenes.template import commented_template

FIX = 'fix = ["ux", "uy", "rx", "ry", "rz"]'


def screw(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    text = like.ball_screw_text("25x5")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    return tmp_path / "my.toml"


HELD = {
    "fixed": 'fix = ["ux", "uy", "uz", "rx", "ry", "rz"]',
    "held at zero": f'{FIX}\ndisplace = {{ uz = "0 um" }}',
    "displaced": f'{FIX}\ndisplace = {{ uz = "2 um" }}',
}


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("model", ["lin", "refined"])
def test_an_axial_load_that_a_support_takes_is_warned_of(command, tmp_path: Path, held: str, model: str) -> None:
    """Displacement and preload load the contacts all the same: what counts is what the load changes."""
    file = screw(tmp_path, (FIX, HELD[held]))
    code, found = command.json("solve", file, "--model", model, "--strict", "--json")
    path = found["summary"]["load_path"]
    force = path["applied"]["force_N"][2]
    taken = {x["name"]: x["force_N"][2] for x in path["supports"]}
    assert code == 1
    assert "reaches the contacts" in found["warning"]
    assert max(taken.values(), key=abs) == pytest.approx(force, rel=2e-3)
    assert sum(taken.values()) + path["contacts"]["force_N"][2] == pytest.approx(force, rel=1e-6)
    assert command("solve", file, "--model", model).code == 0


def test_the_usual_screw_is_not_warned_of(command, tmp_path: Path) -> None:
    code, found = command.json("solve", screw(tmp_path), "--model", "lin", "--strict", "--json")
    path = found["summary"]["load_path"]
    assert (code, found["warning"]) == (0, None)
    assert path["contacts"]["force_N"][2] == pytest.approx(path["applied"]["force_N"][2], rel=1e-6)


def test_supports_of_a_rigid_screw_share_what_statics_divides(command, tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "scenes" / "public" / "s4-tilted-nut.toml").read_text(encoding="utf-8")
    two = (
        '[[supports]]\nat = "0 mm"\nfix = ["ux"]\n\n[[supports]]\nat = "200 mm"\nfix = ["ux"]\n\n'
        '[[supports]]\nat = "100 mm"\nfix = ["uy", "rx", "rz"]\n\n'
    )
    text = re.sub(r"(?s)\[\[supports\]\].*?(?=\[\[loads\]\])", two, text)
    (tmp_path / "two.toml").write_text(
        text.replace('["0 N", "0 N", "3000 N"]', '["400 N", "0 N", "3000 N"]'), encoding="utf-8"
    )
    found = command.json("solve", tmp_path / "two.toml", "--model", "lin", "--json")[1]
    path = found["summary"]["load_path"]
    parts = [x["force_N"][0] for x in path["supports"]]
    assert sum(parts) + path["contacts"]["force_N"][0] == pytest.approx(400.0, rel=1e-6)
    assert found["warning"] is None


def axis(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    text = catalogue.shipped_scene_text("axis-fixed-fixed")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (tmp_path / "axis.toml").write_text(text, encoding="utf-8")
    return tmp_path / "axis.toml"


HOLDS = {
    "the carriage is displaced along the axis": ("# displace = { uz", "displace = { uz"),
    "it stands on stiff springs": ("# displace = { uz", 'springs = { uz = "100000 N/um" }\n# displace = { uz'),
}


@pytest.mark.parametrize("held", HOLDS)
def test_a_load_that_a_frame_takes_does_not_hide_behind_one_on_the_shaft(command, tmp_path: Path, held: str) -> None:
    push = '[[loads]]\nat = "0 mm"\nforce = ["0 N", "0 N", "2 kN"]\n\n[[housings]]'
    for hold in ((), (HOLDS[held],)):
        file = axis(tmp_path, *hold, ("[[housings]]", push))
        code, found = command.json("solve", file, "--model", "lin", "--strict", "--json")
        warned = [w for w in found["warnings"] if "reaches the contacts" in w]
        assert code == len(warned) == len(hold)
        assert all("3000 N on carriage" in w for w in warned)


def test_soft_springs_and_bearings_that_take_a_load_are_not_warned_of(command, tmp_path: Path) -> None:
    soft = ("# displace = { uz", 'springs = { uz = "50 N/um" }\n# displace = { uz')
    for changes in ((), (soft,)):
        code, found = command.json("solve", axis(tmp_path, *changes), "--model", "lin", "--strict", "--json")
        assert (code, found["warning"]) == (0, None)


def test_a_preload_of_a_nut_that_carries_thrust_both_ways_is_refused_by_its_thrust(command, tmp_path: Path) -> None:
    code, _, error = command("solve", axis(tmp_path, ('name = "nut"\n', 'name = "nut"\npreload = "2 kN"\n')))
    assert code == 2
    assert "sets[0].preload" in error
    assert "sets[0].thrust" in error


@pytest.mark.parametrize("name", ["smith-axis", "smith-axis-supported", "smith-axis-tandem", "axis-fixed-fixed"])
def test_shoulders_that_a_shipped_axis_assumes_carry_its_ellipses(command, name: str) -> None:
    found = command.json("solve", name, "--model", "lin", "--json")[1]
    assert [s["summary"]["truncation"]["contacts_cut"] for s in found["sets"]] == [0] * len(found["sets"])


@pytest.mark.parametrize("kind", ["support-bearings", "angular-contact-bearing"])
def test_shoulders_of_templates_carry_their_ellipses(command, tmp_path: Path, kind: str) -> None:
    (tmp_path / "my.toml").write_text(commented_template(kind), encoding="utf-8")
    found = command.json("solve", tmp_path / "my.toml", "--model", "lin", "--json")[1]
    assert not any("beyond the groove's arc" in words for words in found["warnings"])
