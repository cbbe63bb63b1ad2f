"""Whole bodies in 3D: halves of rings and balls, as exact as whole ones; a nut's flange, its surfaces and what it adds."""

from dataclasses import replace

import numpy as np
import pytest
from tests.fe_meshes import area_of, outer_faces, volume_of

from rollbench.compare.scenes import catalogue
from rollbench.hifi.condensation import nut_freedoms_from_free_ones
from rollbench.hifi.elements.forms import elastic_stiffness
from rollbench.hifi.linear_algebra import factorise_positive_definite
from rollbench.meshes.exchange import whole_bodies
from rollbench.meshes.exchange.whole_bodies import ElementSizesNearPoints, mesh_whole_body
from rollbench.meshes.fem import node_coordinates, nodes_on_boundaries
from rollbench.meshes.groove import GroovedBodySpec, outer_surfaces_of_flanged_nut
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDES, Flange
from rollbench.meshes.sockets import RefinementBoxSize
from rollbench.meshes.solid import dimensions_of_3d_parts

SCENE = catalogue.scene("two-balls")
MAP = GrooveMap.from_scene(SCENE)
FLAT = np.array([[0.0, 0.0]])
CASE = catalogue.scene("lin-case1")
LAND, WALL, ENDS = 17e-3, 24e-3, (388e-3, 412e-3)
FLANGE = Flange(66e-3, 6e-3, (26e-3, 31e-3), "left", 5e-3)
MM2 = 1e-6 * np.pi


def ring(outer: bool) -> tuple[GroovedBodySpec, ElementSizesNearPoints]:
    """Spec and sizes of the scene's screw or nut with coarse elements."""
    screw, nut = SCENE.screw, SCENE.nut
    radii = (screw.bore / 2.0, screw.outer_diameter / 2.0) if outer else (21.6e-3, nut.outer_diameter / 2.0)
    near = whole_bodies.points_on_groove(MAP, (0.0, nut.position, 0 if outer else 2), FLAT)
    size, box = ElementSizesNearPoints(near, 5e-4, 0.8, 5e-3), RefinementBoxSize(1.0, MAP.ball, 1.0)
    return GroovedBodySpec(*radii, 0.0, 14e-3, outer, (), box, 5e-4, 5e-3), size


@pytest.mark.parametrize("outer", [True, False])
def test_a_half_ring_is_half_of_the_ring(outer):
    spec, size = ring(outer)
    half = whole_bodies.mesh_half_ring(MAP, spec, size)
    assert 2.0 * volume_of(half) == pytest.approx(volume_of(mesh_whole_body(MAP, spec, size)), rel=3e-4)
    assert np.ptp(half.points[half.nodes_of_boundaries["cut"]][:, 1]) < 1e-15
    assert half.points[:, 1].min() > -1e-15
    for side in (0, 1) if outer else (2, 3):
        x = half.points[half.nodes_of_boundaries[f"flank {SIDES[side]}"]]
        assert np.abs(MAP.distances_from_flank(side, x)).max() < 1e-9
    behind, radius = ("bore", spec.inner_radius) if outer else ("outside", spec.outer_radius)
    np.testing.assert_allclose(np.hypot(*half.points[half.nodes_of_boundaries[behind]][:, :2].T), radius, rtol=1e-9)
    assert {"land", "low end", "high end"} <= set(half.nodes_of_boundaries)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_half_ball_is_half_of_the_ball(sign):
    size = ElementSizesNearPoints(whole_bodies.points_on_ball_surface(MAP, 0, MAP.ball, FLAT), 2e-4, 0.8, 2e-3)
    half = whole_bodies.mesh_half_ball(MAP.ball, size, sign)
    assert volume_of(half) == pytest.approx(2.0 / 3.0 * np.pi * MAP.ball**3, rel=2e-3)
    assert 2.0 * volume_of(half) == pytest.approx(volume_of(whole_bodies.mesh_whole_ball(MAP, MAP.ball, size)), rel=2e-3)
    assert (sign * half.points[:, 1]).min() > -1e-15
    assert np.abs(half.points[half.nodes_of_boundaries["cut"]][:, 1]).max() < 1e-15
    sphere = half.points[half.nodes_of_boundaries["sphere"]]
    np.testing.assert_allclose(np.linalg.norm(sphere, axis=1), MAP.ball, rtol=1e-12)


def body(flange: Flange | None):  # type: ignore[no-untyped-def]
    spec = GroovedBodySpec(LAND, WALL, *ENDS, False, (), RefinementBoxSize(1.0, 1.0, 1.0), 4e-3, 8e-3, flange=flange)
    sizes = ElementSizesNearPoints(np.array([[0.0, 0.0, 0.4]]), 4e-3, 1.0, 8e-3)
    return mesh_whole_body(GrooveMap.from_scene(CASE), spec, sizes)


@pytest.fixture(scope="module")
def plain() -> float:
    return volume_of(body(None))


@pytest.mark.parametrize("side", ["left", "right"])
def test_surfaces_of_a_flange_are_named_and_whole(side, plain: float) -> None:
    nut = body(Flange(66e-3, 6e-3, (26e-3, 31e-3), side, 5e-3))
    assert volume_of(nut) - plain == pytest.approx(MM2 * 6e-3 * (33.0**2 - 24.0**2), rel=0.02)
    faces, _ = outer_faces(nut.cells)
    expected = {
        "rim": 2.0 * 33.0 * 6.0,
        "seat": 31.0**2 - 26.0**2,
        "flange": 33.0**2 - 31.0**2 + 26.0**2 - 24.0**2,
        "centring": 2.0 * 24.0 * 5.0,
        "outside": 2.0 * 24.0 * 13.0,
    }
    for name, size in expected.items():
        of_surface = faces[np.isin(faces, nut.nodes_of_boundaries[name]).all(axis=1)]
        assert area_of(nut.points, of_surface) == pytest.approx(MM2 * size, rel=0.02), name
    face = ENDS[0] + 6e-3 if side == "left" else ENDS[1] - 6e-3
    assert np.abs(nut.points[nut.nodes_of_boundaries["seat"], 2] - face).max() < 1e-9


def test_single_bolts_hold_less_than_the_annulus() -> None:
    """The nut pulled along its axis by its lands: fewer bolts, more give; the annulus is stiffer than any number."""
    mesh, given = body(replace(FLANGE, seat=(24e-3, 33e-3))), []
    lands = nodes_on_boundaries(mesh.mesh, "land")
    K = elastic_stiffness(mesh.mesh, 210e9, 0.28)
    pull = np.zeros(K.shape[0])
    pull[3 * lands + 2] = 1.0 / lands.size
    for bolts in (0, 24, 6, 3):
        nut = replace(CASE.nut, flange=replace(FLANGE, seat=(24e-3, 33e-3), bolts=bolts))
        T = nut_freedoms_from_free_ones(mesh, dimensions_of_3d_parts(replace(CASE, nut=nut)))  # type: ignore[arg-type]
        given.append(float(pull @ (T @ factorise_positive_definite((T.T @ K @ T).tocsc())(T.T @ pull))))
    assert given == sorted(given)
    assert 1.2 * given[0] < given[1] < 1.5 * given[2]
    assert 1.5 * given[0] < given[2] < 3.0 * given[0]


def test_a_sliver_of_a_flange_is_not_meshed() -> None:
    """Circles closer than the deviation of their edges crossed, and gmsh did not come to an end."""
    thin = Flange(66e-3, 6e-3, (24.01e-3, 32.99e-3), "left", 0.01e-3)
    assert outer_surfaces_of_flanged_nut(thin, WALL, ENDS, 0.1e-3)[0] == ["rim", "seat", "outside"]
    assert set(outer_surfaces_of_flanged_nut(thin, WALL, ENDS)[0]) == {"rim", "flange", "seat", "centring", "outside"}
    nut = body(replace(FLANGE, seat=(24e-3, FLANGE.diameter / 2.0 - 15e-6)))
    seat = node_coordinates(nut.mesh)[nodes_on_boundaries(nut.mesh, "seat")]
    assert np.hypot(*seat[:, :2].T).max() == pytest.approx(FLANGE.diameter / 2.0)
