"""What ``rollbench friction`` warns of, once and in which words, and where it ends with 1."""

import re
from dataclasses import replace

import pytest
from tests.feed_drive import answer
from tests.helpers import small_screw

from rollbench.compare.commands.friction import friction_terminal_parts
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import BallErrors, Errors, Friction


def test_a_scene_that_states_no_play_says_what_play_does():
    """One line with both torques; none where the file says how the balls fit, or the screw is preloaded."""
    scene = replace(small_screw(force=(0.0, 0.0, 300.0)), friction=Friction(0.1, 0.1))
    found = answer(scene)
    played = found.as_json()["play"]
    smaller = replace(scene, errors=Errors(balls=BallErrors(oversize=-5e-6)))
    assert played["friction_torque_as_given_Nmm"] == found.as_json()["torque"]["friction_torque_Nmm"]
    stated = answer(smaller)
    assert played["friction_torque_Nmm"] == pytest.approx(stated.as_json()["torque"]["friction_torque_Nmm"], rel=1e-9)
    assert found.warning.startswith("WARNING: no preload and no play are stated")
    assert all(f"{played[key]:.4g} N mm" in found.warning for key in played if key.startswith("friction"))
    shown = [part for part in friction_terminal_parts(found) if isinstance(part, str)]
    assert (shown[2], sum("no preload and no play" in part for part in shown)) == (found.warning, 1)
    assert (stated.as_json()["play"], stated.warning) == (None, "")
    assert answer(replace(scene, errors=Errors(balls=BallErrors(oversize=3e-6)))).as_json()["play"] is None


STRICT = [
    ("lin-case1-cut", "", "", ("WARNING: no preload and no play are stated",)),
    ("two-balls", "", "", ()),
    ("two-balls", 'oversize = "5 um"', 'oversize = "60 um"', ("WARNING outside", "contact pressure", "static safety")),
]


@pytest.mark.parametrize(("name", "old", "new", "said"), STRICT)
def test_strict_ends_with_1_where_a_line_stands_above_the_answers(name, old, new, said, scene_file, command):
    file = scene_file(catalogue.shipped_scene_text(name), (old, new))
    code, data = command.json("friction", file, "--model", "lin", "--mu", "0.1", "--json", "--strict")
    line = data["warning"] or ""
    assert (code, bool(line)) == (bool(said), bool(said))
    assert [line.count(word) for word in said] == [1] * len(said)


@pytest.mark.parametrize(("name", "times"), [("lin-case1", 1), ("double-nut", 2)])
def test_a_coefficient_as_low_as_overall_ones_is_warned_of_by_nut(scene_file, command, name: str, times: int) -> None:
    text = re.sub(r"(?m)^coefficient = .*$", "coefficient = 0.005", catalogue.shipped_scene_text(name))
    data = command.answer("friction", scene_file(text), "--model", "lin")
    assert sum("overall coefficients" in w for w in data["warnings"]) == times
    assert "overall coefficients" in data["warning"]
