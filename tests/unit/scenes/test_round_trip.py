"""Scenes written as files and read again."""

import math
import re
from dataclasses import replace

import pytest
from tests.campaign.draw import scene_text
from tests.campaign.draw_axes import axis_text

import rollbench
from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.template import commented_template
from rollbench.meshes.parts import FourierTerm, Load
from rollbench.meshes.record_keys import canonical_text


@pytest.mark.parametrize("name", catalogue.scene_names())
def test_every_shipped_scene_goes_round(name):
    scene = catalogue.shipped_scene(name)
    again = scene_file.parse_scene(scene.to_toml(), f"{name}.toml")
    assert canonical_text(again) == canonical_text(scene)  # keys of stored runs
    assert again == scene
    assert again.to_toml() == scene.to_toml()


@pytest.mark.parametrize("kind", ["ball screw", "double nut"])
def test_a_new_scene_goes_round(kind):
    scene = rollbench.new("40x10", kind=kind)
    assert scene_file.parse_scene(scene.to_toml(), "40x10") == scene


@pytest.mark.parametrize("clearance", ['{ radial = "13 um" }', '{ axial = "0.1 mm" }'])
def test_a_bearing_with_a_clearance_goes_round(clearance):
    text = catalogue.shipped_scene_text("bearing-9").replace('contact_angle = "45 deg"', f"clearance = {clearance}")
    scene = scene_file.parse_scene(text, "bearing.toml")
    assert "clearance" in scene.to_toml()
    assert scene_file.parse_scene(scene.to_toml(), "bearing.toml") == scene


def test_a_load_of_zero_goes_round():
    scene = scene_file.parse_scene(commented_template(), "template.toml")
    for loads in ((Load(0.0),), (Load(0.0, moment=(0.0, 3.0, 0.0)),)):
        assert scene_file.parse_scene(replace(scene, loads=loads).to_toml(), "zero.toml").loads == loads


@pytest.mark.parametrize("drawn", [scene_text, axis_text])
def test_drawn_screws_and_axes_go_round(drawn):
    """Those of the campaign that can be built: extreme sizes, errors, supports, springs."""
    found = 0
    for number in range(40):
        try:
            scene = scene_file.parse_scene(drawn(58, number), "drawn.toml")
        except InputError:
            continue
        again = scene_file.parse_scene(scene.to_toml(), "drawn.toml")
        assert again == scene, number
        assert canonical_text(again) == canonical_text(scene)
        found += 1
    assert found > 20


def test_round_trip_of_every_key():
    full = re.sub(r"(?m)^# (?=\[|\w+ = )", "", commented_template())
    full = full.replace('hand = "right"', 'hand = "left"').replace('bore = "0 mm"', 'bore = "5 mm"')
    full = full.replace('azimuth = "0 deg"', 'azimuth = "30 deg"').replace('"0 N m", "0 N m"]', '"1 N m", "2 N mm"]')
    full = full.replace('sin = "5 um"', 'sin = "5 um", cos = "1 um", sigma = "2 um"').replace('["0.1 um', '["0.2 um')
    full = full.replace('hertz = "nominal"', 'hertz = "as printed"').replace('section = "groove"', 'section = "full"')
    cycle = scene_file.parse_scene(full, "full.toml")
    scene = cycle.parts  # without its load case
    errors, words = scene.errors, (scene.track.hand, scene.ingredients.hertz, scene.ingredients.section)
    assert (cycle.cases[0].scene.errors.balls.oversize, errors.NR.profile) == (3e-6, (2e-6, -0.25e-6))
    assert scene.supports[1].fixed == (("ux", 3e-4), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0))
    assert (*words, scene.screw.bore, scene.nut.azimuth) == ("left", "as printed", "full", 5e-3, math.pi / 6)
    assert scene.loads[0].moment == (0.0, 1.0, 2e-3)
    assert (errors.SL.profile_sigma, errors.SL.roundness[0]) == ((2e-7, 0.0), FourierTerm(2.0, 5e-6, 1e-6, 2e-6))
    assert scene_file.scene_from_text(scene.to_toml(), "full.toml") == scene
    assert scene_file.parse_scene(cycle.to_toml(), "full.toml") == cycle
