"""The tables [friction], [motion], [time] and [circulation] of a scene: units, former keys, refusals, stored runs."""

from dataclasses import replace

import numpy as np
import pytest
from tests.feed_drive import mine

from rollbench.compare.errors import SceneError
from rollbench.compare.reference.store import content_key_of_run
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.meshes.parts import Friction, Motion, Time

FORMER = [("none", False, False), ("ball", True, False), ("balls", False, True)]


@pytest.mark.parametrize(("word", "feedback", "neighbours"), FORMER)
def test_the_former_key_is_read_and_its_new_names_are_said(word, feedback, neighbours):
    found = mine(("nut = 0.07", f'nut = 0.07\ncoupling = "{word}"')).friction
    assert (found.feedback, found.neighbours) == (feedback, neighbours)
    two = mine(("nut = 0.07", "nut = 0.07\nfeedback = true\nneighbours = true")).friction
    assert [(x.feedback, x.neighbours) for x in (two, mine().friction)] == [(True, True), (True, False)], "two keys"
    new = f"feedback = {str(feedback).lower()}, neighbours = {str(neighbours).lower()}"
    assert found.assumed[-1] == f'The former key coupling = "{word}" is read as {new}.'


def test_coefficients_of_both_grooves_stand_for_the_shared_one():
    assert mine(("coefficient = 0.06", "screw = 0.06")).friction == mine().friction
    with pytest.raises(SceneError, match=r"friction.coefficient: got nothing; .*0 to 2; .*screw and nut"):
        mine(("coefficient = 0.06\n", ""))
    double = catalogue.shipped_scene_text("double-nut")
    assert "coefficient = 0.05\n" in double
    with pytest.raises(SceneError, match=r"friction.coefficient: got nothing"):
        scene_file.parse_scene(double.replace("coefficient = 0.05\n", "nut = 0.05\n"), "double.toml")
    both = scene_file.parse_scene(double.replace("coefficient = 0.05\n", "screw = 0.04\nnut = 0.05\n"), "double.toml")
    assert (both.friction.screw, both.friction.nut) == (0.04, 0.05)


def test_friction_and_motion_leave_static_keys_alone():
    plain = catalogue.scene("bearing-9")
    rubbing = replace(plain, friction=Friction(0.1, 0.2, feedback=False), motion=Motion(3.0, "nut"), time=Time(angle=1.0))
    assert rubbing != plain
    assert "friction=Friction(" in repr(rubbing)
    assert content_key_of_run(rubbing, "", {}, (0, 3)) == content_key_of_run(plain, "", {}, (0, 3))


def test_tables_are_read_in_si_units():
    scene = mine()
    assert scene.friction == Friction(0.06, 0.07, ("Grease, by experience.",), True)
    assert scene.motion == Motion(pytest.approx(50.0 * np.pi), "nut")
    assert mine(("nut = 0.07\n", "")).friction == Friction(0.06, 0.06, ("Grease, by experience.",), True)
    other = mine(("nut = 0.07", "screw = 0")).friction
    assert (other.screw, other.nut) == (0.0, 0.06)
