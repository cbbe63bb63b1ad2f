"""Halves of rings and balls: as exact as whole ones, and half of them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import volume as volume_of_cells

from rollbench.compare.scenes import catalogue
from rollbench.meshes.exchange import whole_bodies
from rollbench.meshes.exchange.whole_bodies import HalfRingSurface
from rollbench.meshes.fem import largest_arc_deviation
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDES
from rollbench.meshes.shell import ClosedSurfaceMesh
from rollbench.meshes.sockets import RefinementBoxSize

SCENE = catalogue.scene("two-balls")
MAP = GrooveMap.from_scene(SCENE)
FLAT = np.array([[0.0, 0.0]])


def volume(body) -> float:
    """Volume [m3] of the curved cells."""
    return volume_of_cells(body.points, body.cells, "P2")


def ring(outer: bool) -> tuple[GroovedBodySpec, whole_bodies.ElementSizesNearPoints]:
    """Spec and sizes of the scene's screw or nut with coarse elements."""
    radii = (
        (SCENE.screw.bore / 2.0, SCENE.screw.outer_diameter / 2.0) if outer else (21.6e-3, SCENE.nut.outer_diameter / 2.0)
    )
    near = whole_bodies.points_on_groove(MAP, (0.0, SCENE.nut.position, 0 if outer else 2), FLAT)
    size = whole_bodies.ElementSizesNearPoints(near, 5e-4, 0.8, 5e-3)
    return GroovedBodySpec(
        *radii,
        0.0,
        14e-3,
        outer,
        (),
        RefinementBoxSize(1.0, MAP.ball, 1.0),
        size.edge_length_at_points,
        size.largest_edge_length,
    ), size


@pytest.mark.parametrize("outer", [True, False])
def test_a_half_ring_is_half_of_the_ring(outer):
    spec, size = ring(outer)
    half = whole_bodies.mesh_half_ring(MAP, spec, size)
    assert 2.0 * volume(half) == pytest.approx(volume(whole_bodies.mesh_whole_body(MAP, spec, size)), rel=3e-4)
    assert np.ptp(half.points[half.nodes_of_boundaries["cut"]][:, 1]) < 1e-15
    assert half.points[:, 1].min() > -1e-15
    for side in (0, 1) if outer else (2, 3):
        x = half.points[half.nodes_of_boundaries[f"flank {SIDES[side]}"]]
        section = np.hypot(x[:, 0], x[:, 1]) - MAP.R, x[:, 2] - MAP.z0
        assert largest_arc_deviation(*section, MAP.centre[side], float(MAP.radius[side])) < 1e-9
    behind = half.points[half.nodes_of_boundaries["bore" if outer else "outside"]]
    np.testing.assert_allclose(
        np.hypot(behind[:, 0], behind[:, 1]), spec.inner_radius if outer else spec.outer_radius, rtol=1e-9
    )
    assert {"land", "low end", "high end"} <= set(half.nodes_of_boundaries)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_half_ball_is_half_of_the_ball(sign):
    size = whole_bodies.ElementSizesNearPoints(whole_bodies.points_on_ball_surface(MAP, 0, MAP.ball, FLAT), 2e-4, 0.8, 2e-3)
    half = whole_bodies.mesh_half_ball(MAP.ball, size, sign)
    assert volume(half) == pytest.approx(2.0 / 3.0 * np.pi * MAP.ball**3, rel=2e-3)
    assert 2.0 * volume(half) == pytest.approx(volume(whole_bodies.mesh_whole_ball(MAP, MAP.ball, size)), rel=2e-3)
    assert (sign * half.points[:, 1]).min() > -1e-15
    assert np.abs(half.points[half.nodes_of_boundaries["cut"]][:, 1]).max() < 1e-15
    np.testing.assert_allclose(
        np.linalg.norm(half.points[half.nodes_of_boundaries["sphere"]], axis=1), MAP.ball, rtol=1e-12
    )


def test_a_helix_and_a_ring_without_bore_are_not_halved():
    spec, _ = ring(True)
    shell = ClosedSurfaceMesh(None, lambda x: np.ones(len(x)), 1e-3, 6)
    for m, body in ((replace(MAP, rg=1e-3), spec), (MAP, replace(spec, inner_radius=0.0))):
        with pytest.raises(ValueError, match="ring with a bore"):
            HalfRingSurface(shell, m, body)
