"""Dimensions that only the 3D reference needs."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import Solid
from rollbench.meshes.solid import dimensions_of_3d_parts, largest_groove_depths


def test_what_a_scene_does_not_give_is_assumed_and_said():
    scene = catalogue.scene("lin-case1")
    d = dimensions_of_3d_parts(scene)
    assert (d.land, d.hole, d.shaft) == pytest.approx((17e-3, 1.5e-3, 24.75e-3))
    assert (d.nut_held, d.screw_held, d.shaft_radius) == ("left face", "ends", None)
    assert d.ends_of_meshed_screw(scene) == pytest.approx((0.34825, 0.45175))
    assert all(word in " ".join(d.assumed) for word in ("34 mm", "3 mm diameter", "left face", "24.8 mm"))
    given = replace(scene, solid=Solid(33.6e-3, 4e-3, 10e-3, 30e-3, "both faces", "ends"))
    d = dimensions_of_3d_parts(given)
    assert (d.land, d.hole, d.shaft, d.shaft_radius) == pytest.approx((16.8e-3, 2e-3, 10e-3, 15e-3))
    assert (d.nut_held, len(d.assumed)) == ("both faces", 1)  # flat faces and a groove that runs through: nothing else


def test_a_bearing_on_a_stiff_shaft_and_a_stretch_that_ends_where_the_screw_does():
    d = dimensions_of_3d_parts(catalogue.scene("bearing-9"))
    assert (d.nut_held, d.screw_held, d.shaft, d.hole) == ("outer surface", "bore", 0.0, 25e-3)
    assert "bore" in " ".join(d.assumed)
    scene = catalogue.scene("lin-case1")
    short = replace(scene, nut=replace(scene.nut, position=30e-3))
    assert dimensions_of_3d_parts(short).ends_of_meshed_screw(short)[0] == 0.0


REFUSED = [(Solid(nut_inner_diameter=33e-3), "nut_inner_diameter"), (Solid(hole_diameter=28e-3), "hole")]


@pytest.mark.parametrize(("solid", "key"), REFUSED)
def test_dimensions_without_groove_or_wall_are_refused(solid, key):
    with pytest.raises(ValueError, match=key):
        dimensions_of_3d_parts(replace(catalogue.scene("lin-case1"), solid=solid))


def wide(radius=20e-3):
    """Two balls of 4 mm radius in nearly flat grooves on a pitch radius of 20 mm."""
    ring = catalogue.scene("two-balls")
    return replace(ring, screw=replace(ring.screw, groove_radius=radius), nut=replace(ring.nut, groove_radius=radius))


def test_a_groove_is_as_deep_as_its_bottom_and_not_as_its_radius():
    """Arcs of 20 mm whose centres lie 16 mm from the ball's at 45 deg meet 5.18 mm below the pitch circle."""
    off = 16e-3 * np.sqrt(0.5)
    depth = np.sqrt(20e-3**2 - off**2) - off
    assert largest_groove_depths(wide()) == pytest.approx((depth, depth), rel=1e-12)
    assert dimensions_of_3d_parts(wide()).hole == 11e-3  # a wall of 3.82 mm
    thin = replace(wide(), screw=replace(wide().screw, bore=2.0 * (20e-3 - depth) + 1e-6))
    with pytest.raises(ValueError, match=r"below 29.64 mm"):
        dimensions_of_3d_parts(thin)
    unlike = replace(wide(), screw=replace(wide().screw, groove_radius=8e-3))
    assert largest_groove_depths(unlike)[0] < largest_groove_depths(unlike)[1] == pytest.approx(depth)


def test_a_station_at_an_end_is_the_end():
    """Rounded apart by 6e-17 m, the support held the hole's surface in place of the flat end."""
    scene = catalogue.scene("lin-case1-cut")
    low, high = dimensions_of_3d_parts(scene).ends_of_meshed_screw(scene)
    assert low == scene.supports[0].at == scene.loads[0].at
    assert high == pytest.approx(scene.nut.position + 18e-3)
    moved = replace(scene, supports=(replace(scene.supports[0], at=low + 1e-6),), loads=())
    assert dimensions_of_3d_parts(moved).ends_of_meshed_screw(moved)[0] == pytest.approx(low, abs=1e-12)
