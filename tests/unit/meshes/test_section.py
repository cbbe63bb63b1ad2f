"""Cross-section of the grooved screw: groove range and area, volume ratio, Cowper's shear coefficient."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import STEEL, small_screw

from rollbench.compare.scenes import catalogue
from rollbench.meshes import section as meshes_section

LIN = catalogue.scene("lin-case1")


def outline(scene, points=4001):
    """The gothic arch below the screw's surface as a polygon in (x3, z3): both arcs from land to land."""
    r, beta = scene.screw.groove_radius, scene.track.contact_angle
    x0, z0 = (r - scene.balls.radius) * np.cos(beta), (r - scene.balls.radius) * np.sin(beta)
    land = scene.screw.outer_diameter / 2 - scene.track.pitch_radius
    gamma = np.linspace(np.arccos((x0 - land) / r), np.arcsin(z0 / r), points)  # land edge to apex
    x, z = x0 - r * np.cos(gamma), z0 - r * np.sin(gamma)
    return np.concatenate([x, x[::-1]]), np.concatenate([z, -z[::-1]])


def polygon_area(x, z):
    return 0.5 * abs(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))


def test_groove_range_printed_in_2_4_2():
    section = meshes_section.screw_groove_section(LIN)
    assert round(section.apex_angle / np.pi, 3) == 0.033
    assert round(section.edge_angle / np.pi, 3) == 0.417


@pytest.mark.parametrize(("outer", "beta"), [(32e-3, np.pi / 4), (33e-3, np.pi / 4), (31e-3, 0.6), (34e-3, 1.2)])
def test_groove_area_against_a_polygon(outer, beta):
    scene = replace(LIN, screw=replace(LIN.screw, outer_diameter=outer), track=replace(LIN.track, contact_angle=beta))
    x, z = outline(scene)
    assert x.max() == pytest.approx(outer / 2 - 16.5e-3, abs=1e-15)
    assert meshes_section.screw_groove_section(scene).area == pytest.approx(polygon_area(x, z), rel=1e-6)


def test_nut_groove_range():
    low, high = meshes_section.section_angle_range_of_nut_groove(replace(LIN, nut=replace(LIN.nut, groove_radius=3.4e-3)))
    assert 3.4e-3 * np.sin(low) == pytest.approx((3.4e-3 - 2.778e-3) * np.sin(np.pi / 4), rel=1e-14)
    assert high == np.pi / 2


@pytest.mark.parametrize("starts", [1, 2])
def test_volume_ratio(starts):
    """1 minus the groove's volume per lead (polygon's area along the ball path) over the cylinder's."""
    scene = replace(LIN, track=replace(LIN.track, starts=starts))
    path = np.hypot(2 * np.pi * 16.5e-3, 20e-3)
    expected = 1 - starts * polygon_area(*outline(scene)) * path / (np.pi * 16e-3**2 * 20e-3)
    assert meshes_section.grooved_volume_ratio(scene) == pytest.approx(expected, rel=1e-6)
    assert 0.5 < expected < 1.0
    assert meshes_section.grooved_volume_ratio(small_screw(lead=0.0)) == 1.0


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_cowper_limits(nu):
    """Solid circle 6 (1 + nu)/(7 + 6 nu); thin tube 2 (1 + nu)/(4 + 3 nu)."""
    material = replace(STEEL, poissons_ratio=nu)

    def kappa(outer, bore):
        area = np.pi / 4 * (outer**2 - bore**2)
        return meshes_section.tube_section(outer, bore, material).kGA / (material.shear_modulus * area)

    half = 6 * (1 + nu) * 1.25**2 / ((7 + 6 * nu) * 1.25**2 + (20 + 12 * nu) * 0.25)
    assert kappa(0.03, 0.0) == pytest.approx(6 * (1 + nu) / (7 + 6 * nu), rel=1e-14)
    assert kappa(0.03, 0.03 * (1 - 1e-6)) == pytest.approx(2 * (1 + nu) / (4 + 3 * nu), rel=1e-9)
    assert kappa(0.03, 0.015) == pytest.approx(half, rel=1e-14)
