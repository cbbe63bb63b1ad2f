"""What catalogues give: diameters, materials by name, circuits with gaps, filling, preload, nominal sizes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.models import registry
from rollbench.compare.scenes import catalogue, from_keys, scene_file
from rollbench.compare.scenes.template import commented_template, new_scene_text
from rollbench.lowfi.friction.whole.circuit import circuits_of_scene
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes import helix, parts

GOOD = commented_template()


def changed(*changes: tuple[str, str], text: str = GOOD) -> str:
    for old, new in changes:
        assert f"\n{old}" in text, old
        text = text.replace(f"\n{old}", f"\n{new}", 1)
    return text


def read(*changes: tuple[str, str]) -> parts.Scene:
    return scene_file.scene_from_text(changed(*changes), "my.toml")


PITCH = ('pitch_radius = "16.5 mm"', 'pitch_diameter = "33 mm"')
BALL = ('radius = "2.778 mm"', 'diameter = "5.556 mm"')
HALVES = (("count = 32", "count = 24"), ("turns = 2", "turns = 0.8\ncircuits = 2\ncircuit_gap = 0.6"))
ARCS = 'arcs = [["-300 deg", "-60 deg"], ["60 deg", "300 deg"]]'


def test_diameters_are_the_radii_to_the_last_digit_and_an_oversize_is_one_by_preload() -> None:
    assert read(PITCH, BALL) == read()
    assert read(('pitch_radius = "16.5 mm"', 'pitch_diameter = "33 mm"\npitch_radius = "16.5 mm"')) == read()
    preloaded = catalogue.shipped_scene_text("lin-case3").replace("[errors.balls]", "[preload]", 1)
    assert scene_file.scene_from_text(preloaded, "lin-case3.toml") == catalogue.scene("lin-case3")


def test_materials_by_name() -> None:
    both = 'youngs_modulus = "210 GPa"\npoissons_ratio = 0.28'
    steel = (both, 'name = "bearing steel"')
    assert read(steel).screw.material == replace(read().screw.material, poissons_ratio=0.3)
    for grade in ("100Cr6", "AISI 52100"):
        assert read((steel[0], f'name = "{grade}"')).screw.material == read(steel).screw.material
    ceramic = read(("turns = 2", 'turns = 2\nmaterial = { name = "silicon nitride" }'))
    assert (ceramic.balls.material.youngs_modulus, ceramic.balls.material.poissons_ratio) == (310e9, 0.26)
    assert ceramic.screw == read().screw
    changed = read(("turns = 2", 'turns = 2\nmaterial = { name = "zirconia", youngs_modulus = "205 GPa" }'))
    assert changed.balls.material.youngs_modulus == 205e9
    for name in ("X30CrMoN15-1", "steel of our supplier", "silicon nitrid"):  # any name with both of its values
        assert read((both, f'name = "{name}"\n{both}')) == read()


def test_circuits_lie_about_the_nut_with_their_gaps() -> None:
    scene = read(("count = 32", "count = 15"), ("turns = 2", "turns = 0.5\ncircuits = 3\ncircuit_gap = 0.25"))
    places = np.array(scene.balls.azimuths).reshape(3, 5) / (2.0 * math.pi)
    np.testing.assert_allclose(np.diff(places, axis=1), 0.1, atol=1e-12)
    np.testing.assert_allclose(places.mean(axis=1), [-0.75, 0.0, 0.75], atol=1e-12)


def test_arcs_with_a_gap_are_circuits_of_their_own_in_a_run() -> None:
    """Balls would run on across the gap as if it were a loaded arc."""
    few, arcs = ("count = 32", "count = 20"), ("turns = 2", ARCS)
    run = '[motion]\nspeed = "60 rpm"\n[time]\nangle = "90 deg"\n[friction]\ncoefficient = 0.1\n[[supports]]'
    rounds = ("[[supports]]", f"[circulation]\ncircuits = 2\n{run}")
    first, second = circuits_of_scene(read(few, arcs, rounds))
    assert first.track.loaded_arc_start + first.track.arc == pytest.approx(math.radians(-60.0))
    assert second.track.loaded_arc_start == pytest.approx(math.radians(60.0))
    read(few, (arcs[0], arcs[1].replace("300 deg", "500 deg", 1)))  # unlike arcs, but none runs


def test_filling_gives_the_count() -> None:
    assert read(("count = 32", "filling = 0.9")).ball_count == 34
    full = read(("count = 32", "filling = 1"))
    apart = np.linalg.norm(np.diff(helix.ball_layout(full).centre, axis=0), axis=1)
    assert 5.556e-3 <= apart.min() < 5.556e-3 * (1.0 + 1.0 / full.ball_count), "no ball more would fit"


def test_a_preload_force_is_what_rigid_bodies_press_with() -> None:
    """The screw alone, rigid, without load: the axial force over its left flanks is the one asked for."""
    rigid = ("# [ingredients]", '[ingredients]\nscrew = "rigid"')
    scene = read(
        rigid,
        ("[[supports]]", '[preload]\nforce = "3 kN"\n[[supports]]'),
        ('force = ["0 N", "0 N", "5 kN"]', 'force = ["0 N", "0 N", "0 N"]'),
    )
    assert "elastic ones give way" in scene.assumed[-1]
    result = solve_static(scene)
    alpha = math.atan2(20e-3, 2.0 * math.pi * 16.5e-3)
    axial = float((result.load[:, 0] * np.sin(result.contact_angle[:, 0])).sum()) * math.cos(alpha)
    assert axial == pytest.approx(3000.0, rel=0.02)
    assert from_keys.ball_oversize_for_preload(scene, 3000.0) == scene.errors.balls.oversize


def test_a_lead_offset_shifts_the_nut_s_halves_and_presses_both_ways() -> None:
    """Also with an odd number of balls without a gap in the middle: it was refused, though the groove may step beside a
    ball at the nut's centre."""
    given = ("[[supports]]", '[preload]\nlead_offset = "12 um"\n[[supports]]')
    odd = read(("count = 32", "count = 31"), given)
    assert (odd.ball_count, odd.errors.lead_offset) == (31, 12e-6)
    scene = read(given, *HALVES, ('force = ["0 N", "0 N", "5 kN"]', 'force = ["0 N", "0 N", "0 N"]'))
    assert scene.errors == parts.Errors(lead_offset=12e-6)
    load = solve_static(scene).load
    assert min(load[:, 0].sum(), load[:, 1].sum()) > 100.0


@pytest.mark.parametrize("size", ["6x1", "12x4", "16x16", "20x5", "32x10", "32 x 32", "40x10", "40×80", "63X20", "160x40"])
def test_a_scene_of_every_nominal_size_reads(size: str) -> None:
    text = new_scene_text("ball screw", size)
    scene = scene_file.scene_from_text(text, "my.toml")
    assert 10 <= scene.ball_count <= 200
    wall = scene.nut.outer_diameter / 2.0 - scene.track.pitch_radius - scene.balls.radius
    assert 1.0 < wall / scene.balls.radius < 5.0
    assert (scene.errors.balls.oversize > 0.0, scene.loads[0].force[2] > 0.0) == (True, True)


def test_a_size_beyond_the_rules_is_refused() -> None:
    for size in ("40", "x10", "40x", "40x100", "4x1", "300x10", "-40x10", "40x10x2", "nan"):
        with pytest.raises(InputError, match="40x10"):
            new_scene_text("ball screw", size)


@pytest.mark.parametrize("size", ["6x1", "40x10", "63x20", "20x20"])
def test_a_double_nut_of_a_nominal_size_is_preloaded_by_a_part_of_its_rating(size: str) -> None:
    found = scene_file.parse_scene(new_scene_text("double nut", size), "d.toml")
    assert [s.thrust for s in found.sets] == ["-z", "+z"]
    for one in found.sets:
        assert one.preload == pytest.approx(0.05 * dynamic_rating(one.parts), rel=1e-12)
    left, right = (s.parts.nut for s in found.sets)
    assert right.position - left.position > left.length, "a spacer stands between them"


@pytest.mark.parametrize("text", ["5 % of C", "5% of C", " 2.5 %  of C "])
def test_a_preload_may_be_a_part_of_the_rating(text: str) -> None:
    scene = read(("[[supports]]", f'[preload]\nforce = "{text}"\n[[supports]]'))
    share = 0.025 if "2.5" in text else 0.05
    assert scene.errors.balls.oversize == from_keys.ball_oversize_for_preload(read(), share * dynamic_rating(read()))
    assert f"({100.0 * share:.3g} % of the dynamic load rating" in scene.assumed[-1]


def test_lands_that_nobody_wrote_are_not_blamed() -> None:
    wider = ('outer_diameter = "32 mm"', 'outer_diameter = "34 mm"')
    with pytest.raises(InputError, match=r"screw\.outer_diameter of 34 mm with a pitch diameter of 33") as caught:
        registry.run_model(read(wider), "refined")
    assert caught.value.key == "screw.outer_diameter"
    given = replace(read(), solid=parts.Solid(nut_inner_diameter=32e-3))
    with pytest.raises(InputError, match=r"solid\.nut_inner_diameter of 32 mm leaves no groove"):
        registry.run_model(given, "refined")
