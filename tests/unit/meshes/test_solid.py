"""Dimensions that only the 3D reference needs."""

from dataclasses import replace

import pytest

from rollbench.comparison.scenes import catalogue
from rollbench.meshes.parts import Solid
from rollbench.meshes.solid import dimensions


def test_what_a_scene_does_not_give_is_assumed_and_said():
    scene = catalogue.scene("lin-case1")
    d = dimensions(scene)
    assert (d.land, d.hole, d.shaft) == pytest.approx((17e-3, 1.5e-3, 24.75e-3))
    assert (d.nut_held, d.screw_held, d.shaft_radius) == ("left face", "ends", None)
    assert d.ends(scene) == pytest.approx((0.34825, 0.45175))
    text = " ".join(d.assumed)
    assert all(word in text for word in ("34 mm", "3 mm diameter", "left face", "24.8 mm"))
    given = replace(scene, solid=Solid(33.6e-3, 4e-3, 10e-3, 30e-3, "both faces", "ends"))
    d = dimensions(given)
    assert (d.land, d.hole, d.shaft, d.shaft_radius) == pytest.approx((16.8e-3, 2e-3, 10e-3, 15e-3))
    assert d.nut_held == "both faces"
    assert len(d.assumed) == 1  # flat faces and a groove that runs through: nothing else


def test_a_bearing_on_a_stiff_shaft_and_a_stretch_that_ends_where_the_screw_does():
    d = dimensions(catalogue.scene("bearing-9"))
    assert (d.nut_held, d.screw_held, d.shaft, d.hole) == ("outer surface", "bore", 0.0, 25e-3)
    assert "bore" in " ".join(d.assumed)
    scene = catalogue.scene("lin-case1")
    short = replace(scene, nut=replace(scene.nut, position=30e-3))
    assert dimensions(short).ends(short)[0] == 0.0


REFUSED = [(Solid(nut_inner_diameter=33e-3), "nut_inner_diameter"), (Solid(hole_diameter=28e-3), "hole")]


@pytest.mark.parametrize(("solid", "key"), REFUSED)
def test_dimensions_without_groove_or_wall_are_refused(solid, key):
    with pytest.raises(ValueError, match=key):
        dimensions(replace(catalogue.scene("lin-case1"), solid=solid))


def test_a_station_at_an_end_is_the_end():
    """Rounded apart by 6e-17 m, the support held the hole's surface in place of the flat end."""
    scene = catalogue.scene("lin-case1-cut")
    low, high = dimensions(scene).ends(scene)
    assert low == scene.supports[0].at == scene.loads[0].at
    assert high == pytest.approx(scene.nut.position + 18e-3)
    moved = replace(scene, supports=(replace(scene.supports[0], at=low + 1e-6),), loads=())
    assert dimensions(moved).ends(moved)[0] == pytest.approx(low, abs=1e-12)
