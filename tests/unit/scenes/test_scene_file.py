"""Scene files: shipped scenes, conversion to parts, bytes, names and roles, what reading them imports."""

import math
import re
from dataclasses import replace

import pytest
from tests.shipped_texts import axis_names, parse_file

from rollbench.compare import case
from rollbench.compare.errors import SceneError
from rollbench.compare.reference.store import content_key_of_run
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.kinds import friction_scene_kinds
from rollbench.compare.scenes.template import commented_template


@pytest.mark.parametrize("name", ["lin-case3", "lin-case3-offset"])
def test_readings_of_case_3_differ_in_the_right_end_alone_and_say_which_is_the_text_s(name):
    def bare(scene):
        return replace(scene, name="", title="", assumed=(), supports=scene.supports[:1], friction=None)

    ours, text, clamped = (catalogue.scene(f"{name}{reading}") for reading in ("", "-ux", "-clamped"))
    assert bare(ours) == bare(text) == bare(clamped)
    assert any("the text's own reading" in sentence for sentence in text.assumed)


def test_a_whole_scene_may_name_its_kind():
    text = catalogue.shipped_scene_text("lin-case1").replace("[material]", 'kind = "ball screw"\n[material]', 1)
    assert scene_file.scene_from_text(text, "lin-case1.toml") == catalogue.scene("lin-case1")


def test_kinds_of_friction_are_scenes_of_the_one_catalogue(tmp_path):
    names = set(catalogue.scene_names()) - set(catalogue.names_of_single_nut_scenes()) - set(axis_names())
    assert {scene_file.kind_of_scene(catalogue.shipped_scene(name)) for name in names} == set(friction_scene_kinds())
    assert catalogue.shipped_scene("lin-pair-a") is catalogue.shipped_scene("lin-pair-a"), "each is read once"
    with pytest.raises(SceneError, match=r'"linear pair"; allowed: "ball screw", "bearing"; .*rollbench friction'):
        catalogue.scene("lin-pair-a")
    path = tmp_path / "mine.toml"
    path.write_text(catalogue.shipped_scene_text("lin-pair-a"))
    with pytest.raises(SceneError, match="rollbench friction"):
        parse_file(path)
    assert scene_file.kind_of_scene(catalogue.scene_of_any_kind(str(path))) == "linear pair"


def test_without_the_case_that_brings_a_kind_its_scenes_are_of_an_unknown_kind(monkeypatch):
    monkeypatch.setattr(case, "all_cases", lambda: ())
    case.brought_by_cases.cache_clear()
    try:
        with pytest.raises(SceneError, match='got "linear pair"; allowed: "ball screw", "bearing"; '):
            scene_file.parse_scene(catalogue.shipped_scene_text("lin-pair-a"), "a.toml")
    finally:
        case.brought_by_cases.cache_clear()


def test_conformity_part_of_a_material_and_starts():
    """A conformity is the groove's radius over the ball's diameter; a material takes the rest from the default; starts
    share the balls."""

    def changed(old, new):
        return scene_file.scene_from_text(commented_template().replace(old, new), "a.toml")

    scene = changed('groove_radius = "3.254 mm"', "conformity = 0.56")
    assert scene.screw.groove_radius == scene.nut.groove_radius == pytest.approx(0.56 * 2 * 2.778e-3)
    scene = changed("turns = 2\n", 'turns = 2\nmaterial = { youngs_modulus = "310 GPa" }\n')
    assert (scene.balls.material.youngs_modulus, scene.balls.material.poissons_ratio) == (310e9, 0.28)
    scene = changed('lead = "20 mm"\n', 'lead = "20 mm"\nstarts = 2\nphase = "90 deg"\n')
    assert (scene.ball_count, len(scene.balls.azimuths)) == (32, 16)
    assert sum(scene.balls.azimuths) / 16 == pytest.approx(math.pi / 2)


def test_byte_order_mark_windows_line_ends_and_the_hash_of_a_text(tmp_path):
    path = tmp_path / "w.toml"
    path.write_bytes(b"\xef\xbb\xbf" + commented_template().replace("\n", "\r\n").encode())
    assert parse_file(path).ball_count == 32
    assert scene_file.hash_of_scene_text("a") == "ca978112ca1bbdca" != scene_file.hash_of_scene_text("a ")


def test_hash_and_key_do_not_know_the_role():
    text = catalogue.shipped_scene_text("lin-case1")
    bare = re.sub(r'(?m)^role = "referenced"\n', "", text)
    assert bare != text
    assert scene_file.hash_of_scene_text(bare) == scene_file.hash_of_scene_text(text)
    assert scene_file.hash_of_scene_text(text.replace("lead", "Lead")) != scene_file.hash_of_scene_text(text)
    scene = catalogue.scene("lin-case1")
    other = replace(scene, role="")
    assert other == scene
    one, two = (content_key_of_run(x, "", {"b_over_h": 2.0}, (0, 3)) for x in (scene, other))
    assert one == two
