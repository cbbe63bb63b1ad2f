"""Tables of a scene: friction, motion and time, with units and former keys; the flange of a nut and how it is held."""

from dataclasses import replace

import numpy as np
import pytest
from tests.feed_drive import mine
from tests.shipped_texts import changed

from rollbench.compare.reference.store import content_key_of_run
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.template import commented_template
from rollbench.meshes import solid
from rollbench.meshes.parts import Flange, Friction, Motion, Time

FORMER = [("none", False, False), ("ball", True, False), ("balls", False, True)]


@pytest.mark.parametrize(("word", "feedback", "neighbours"), FORMER)
def test_the_former_key_is_read_and_its_new_names_are_said(word, feedback, neighbours):
    found = mine(("nut = 0.07", f'nut = 0.07\ncoupling = "{word}"')).friction
    assert (found.feedback, found.neighbours) == (feedback, neighbours)
    two = mine(("nut = 0.07", "nut = 0.07\nfeedback = true\nneighbours = true")).friction
    assert [(x.feedback, x.neighbours) for x in (two, mine().friction)] == [(True, True), (True, False)], "two keys"
    assert f'The former key coupling = "{word}" is read as' in found.assumed[-1]


def test_coefficients_of_both_grooves_stand_for_the_shared_one():
    assert mine(("coefficient = 0.06", "screw = 0.06")).friction == mine().friction
    double = changed("double-nut", ("coefficient = 0.05\n", "screw = 0.04\nnut = 0.05\n"))
    both = scene_file.parse_scene(double, "double.toml")
    assert (both.friction.screw, both.friction.nut) == (0.04, 0.05)


def test_friction_and_motion_leave_static_keys_alone():
    plain = catalogue.scene("bearing-9")
    rubbing = replace(plain, friction=Friction(0.1, 0.2, feedback=False), motion=Motion(3.0, "nut"), time=Time(angle=1.0))
    assert rubbing != plain
    assert content_key_of_run(rubbing, "", {}, (0, 3)) == content_key_of_run(plain, "", {}, (0, 3))


def test_tables_are_read_in_si_units():
    scene = mine()
    assert scene.friction == Friction(0.06, 0.07, ("Grease, by experience.",), True)
    assert scene.motion == Motion(pytest.approx(50.0 * np.pi), "nut")
    assert mine(("nut = 0.07\n", "")).friction == Friction(0.06, 0.06, ("Grease, by experience.",), True)
    other = mine(("nut = 0.07", "screw = 0")).friction
    assert (other.screw, other.nut) == (0.0, 0.06)


FLANGE = '[nut.flange]\ndiameter = "72 mm"\nthickness = "11 mm"\n'


def held(text: str):
    return scene_file.scene_from_text(commented_template() + text, "a.toml")


def test_a_flange_holds_its_nut_by_its_whole_face_unless_the_file_says_more() -> None:
    scene = held(FLANGE)
    assert scene.nut.flange == Flange(72e-3, 11e-3, (24e-3, 36e-3))
    dims = solid.dimensions_of_3d_parts(scene)
    assert (dims.nut_held, dims.held_radii) == ("flange face", (24e-3, 36e-3))
    bolted = solid.dimensions_of_3d_parts(held(FLANGE + "[nut.held]\nbolts = 6\n"))
    assert bolted.nut_held == "flange face, 6 bolts"
    fit = FLANGE + 'side = "right"\ncentring = "10 mm"\n[nut.held]\nouter_diameter = "60 mm"\ncentring = "bonded"\n'
    scene = held(fit)
    assert scene.nut.flange == Flange(72e-3, 11e-3, (24e-3, 30e-3), "right", 10e-3, bonded=True)
    assert solid.dimensions_of_3d_parts(scene).nut_held == "flange face and centring"
    assert scene.nut.flange.stations(0.373, 0.427) == pytest.approx([0.427, 0.416, 0.406])


def test_the_face_at_a_flange_reaches_as_far_as_the_flange() -> None:
    for side, radius in (("left", 36e-3), ("right", 24e-3)):
        dims = solid.dimensions_of_3d_parts(held(FLANGE + f'side = "{side}"\n[nut.held]\nat = "left face"\n'))
        assert dims.held_radii == pytest.approx((17e-3, radius))


def test_the_former_key_is_read_and_the_new_one_said() -> None:
    old, new = (held(f"[{where}]\n{key} = 'right face'\n") for where, key in (("solid", "nut_held"), ("nut.held", "at")))
    assert old.solid == new.solid
    assert set(old.assumed) - set(new.assumed) == {'The former key solid.nut_held = "right face" is read as nut.held.at.'}
