"""Scene files: shipped scenes, conversion to parts, bytes and names."""

import math
from dataclasses import replace

import pytest
from tests.shipped_texts import axis_names

from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.duty_cycle import KINDS as FRICTION_ONLY
from rollbench.compare.scenes.friction_kinds import screw_balls
from rollbench.compare.scenes.template import commented_template


@pytest.mark.parametrize("name", ["lin-case3", "lin-case3-offset"])
def test_readings_of_case_3_differ_in_the_right_end_alone_and_say_which_is_the_text_s(name):
    def bare(scene):
        return replace(scene, name="", title="", assumed=(), supports=scene.supports[:1], friction=None)

    ours, text = catalogue.scene(name), catalogue.scene(f"{name}-ux")
    assert bare(ours) == bare(text) == bare(catalogue.scene(f"{name}-clamped"))
    assert any("the text's own reading" in sentence for sentence in text.assumed)
    assert any("The text sets only the x-displacement" in sentence for sentence in ours.assumed)


def test_whole_scene_may_name_its_kind_and_must_name_the_right_one():
    text = catalogue.shipped_scene_text("lin-case1").replace("[material]", 'kind = "ball screw"\n[material]', 1)
    assert scene_file.scene_from_text(text, "lin-case1.toml") == catalogue.scene("lin-case1")
    with pytest.raises(SceneError, match='kind: got "bearing"; allowed: "ball screw" with this lead'):
        scene_file.scene_from_text(text.replace('"ball screw"', '"bearing"', 1), "a.toml")
    ring = catalogue.shipped_scene_text("bearing-9").replace("[material]", 'kind = "ball screw"\n[material]', 1)
    with pytest.raises(SceneError, match='allowed: "bearing" with this lead'):
        scene_file.scene_from_text(ring, "a.toml")


def test_kinds_of_friction_are_scenes_of_the_one_catalogue(tmp_path):
    names = set(catalogue.scene_names()) - set(catalogue.names_of_single_nut_scenes()) - set(axis_names())
    assert {scene_file.kind_of_scene(catalogue.shipped_scene(name)) for name in names} == set(FRICTION_ONLY)
    assert catalogue.shipped_scene("lin-pair-a") is catalogue.shipped_scene("lin-pair-a"), "each is read once"
    words = r'"linear pair"; allowed: "ball screw", "bearing"; .*rollbench friction lin-pair-a'
    with pytest.raises(SceneError, match=words):
        catalogue.scene("lin-pair-a")
    with pytest.raises(InputError, match='kind: got "linear pair"; allowed: "screw run"'):
        catalogue.shipped_scene_of_kind("lin-pair-a", screw_balls.ScrewRunScene)
    path = tmp_path / "mine.toml"
    path.write_text(catalogue.shipped_scene_text("lin-pair-a"))
    with pytest.raises(SceneError, match="rollbench friction"):
        scene_file.read_scene_file(path)
    assert scene_file.kind_of_scene(catalogue.scene_of_any_kind(str(path))) == "linear pair"


def test_conformity_part_of_a_material_and_starts():
    """A conformity is the groove's radius over the ball's diameter; a material takes the rest from the default; starts
    share the balls."""

    def changed(old, new):
        return scene_file.scene_from_text(commented_template().replace(old, new), "a.toml")

    scene = changed('groove_radius = "3.254 mm"', "conformity = 0.56")
    assert scene.screw.groove_radius == scene.nut.groove_radius == pytest.approx(0.56 * 2 * 2.778e-3)
    scene = changed("turns = 2\n", 'turns = 2\nmaterial = { youngs_modulus = "310 GPa" }\n')
    assert (scene.balls.material.youngs_modulus, scene.balls.material.poissons_ratio) == (310e9, 0.28)
    assert scene.nut.material.youngs_modulus == 210e9
    scene = changed('lead = "20 mm"\n', 'lead = "20 mm"\nstarts = 2\nphase = "90 deg"\n')
    assert (scene.ball_count, len(scene.balls.azimuths)) == (32, 16)
    assert sum(scene.balls.azimuths) / 16 == pytest.approx(math.pi / 2)


def test_byte_order_mark_windows_line_ends_and_the_hash_of_a_text(tmp_path):
    path = tmp_path / "w.toml"
    path.write_bytes(b"\xef\xbb\xbf" + commented_template().replace("\n", "\r\n").encode())
    assert scene_file.read_scene_file(path).ball_count == 32
    assert scene_file.hash_of_scene_text("a") == "ca978112ca1bbdca" != scene_file.hash_of_scene_text("a ")


def test_unknown_name_suggests_near_ones(tmp_path):
    with pytest.raises(InputError, match="lin-case1") as caught:
        catalogue.scene("lin-cas1")
    assert "\n" not in str(caught.value)
    (tmp_path / "mine.toml").write_text(commented_template())
    assert catalogue.scene(str(tmp_path / "mine.toml")).name == "mine"
