"""The ball of the 3D reference: rays through the grooves, sockets, its mesh, and what does not fit."""

import numpy as np
import pytest
from tests.fe_meshes import outer_faces, volume_of
from tests.helpers import small_screw

from rollbench.meshes import fem, groove_map
from rollbench.meshes.ball_body import (
    BallRefinementBox,
    contact_frame_vectors,
    mesh_ball_with_refinement_boxes,
    points_in_ball_refinement_box,
    rays_from_ball_centre,
)
from rollbench.meshes.sockets import RefinementBoxSize, points_in_box_at_azimuth_zero

FOUR = (0, 1, 2, 3)


def ball_sockets(sides, gamma=0.3, phi=0.075, depth=0.9e-3):
    return tuple(BallRefinementBox(s, RefinementBoxSize(gamma, 1.2e-3, phi), depth) for s in sides)


@pytest.mark.parametrize("side", range(4))
def test_rays_of_a_ball_pass_through_the_groove(side):
    m = groove_map.GrooveMap.from_scene(small_screw(2, hand="left"))
    (socket,) = ball_sockets((side,))
    corner = np.array([1.0, 1.0, socket.exact_length_fraction])
    xi = np.random.default_rng(0).uniform(corner * [-1.0, 0.0, -1.0], corner, (50, 3))
    x = points_in_ball_refinement_box(m, socket, xi)
    groove = points_in_box_at_azimuth_zero(m, socket.groove_box_size, side, xi * [1.0, 0.0, 1.0]) - [m.R, 0.0, 0.0]
    assert np.abs(np.cross(x, groove)).max() < 1e-12 * m.ball**2
    surface, bottom = (points_in_ball_refinement_box(m, socket, xi * [1.0, 0.0, 1.0] + [0.0, u, 0.0]) for u in (0.0, 1.0))
    np.testing.assert_allclose(np.linalg.norm(surface, axis=1), m.ball, rtol=1e-12)
    np.testing.assert_allclose(bottom @ contact_frame_vectors(m, side)[0], m.ball - socket.depth, rtol=1e-12)
    top = points_in_ball_refinement_box(m, socket, np.zeros((1, 3)))[0]
    np.testing.assert_allclose(top, m.ball * contact_frame_vectors(m, side)[0], atol=1e-17)


def socket_volume(m, socket):
    """Volume of a ball's socket, from the areas of its cells on the unit sphere."""
    line = np.linspace(-1.0, 1.0, 201)
    a, b = np.meshgrid(line, line, indexing="ij")
    ray = rays_from_ball_centre(m, socket, np.stack([a, 0.0 * a, b], -1).reshape(-1, 3)).reshape(201, 201, 3)
    unit = ray / np.linalg.norm(ray, axis=2)[..., None]
    angle = 0.5 * np.linalg.norm(np.cross(unit[1:, 1:] - unit[:-1, :-1], unit[1:, :-1] - unit[:-1, 1:]), axis=2)
    inner = ((m.ball - socket.depth) * np.linalg.norm(ray, axis=2)[1:, 1:]) ** 3
    return float((angle * (m.ball**3 - inner)).sum()) / 3.0


BALLS = [(12.0, (0, 3)), (25.0, FOUR), (45.0, (1, 2)), (45.0, (2,)), (45.0, FOUR), (65.0, (2, 3)), (78.0, (0, 3))]


@pytest.mark.parametrize(("beta", "sides"), BALLS)
def test_ball(beta, sides):
    m = groove_map.GrooveMap.from_scene(small_screw(2, beta=np.radians(beta)))
    sockets = ball_sockets(sides)
    mesh = mesh_ball_with_refinement_boxes(m, sockets, 0.55e-3, 1.2e-3)
    assert fem.scaled_jacobians(mesh.mesh).min() > 0.02
    assert mesh.quality.smallest_jacobian > 0.04
    faces, count = outer_faces(mesh.cells)
    assert count.max() == 2
    assert set(np.unique(mesh.cells)) == set(range(len(mesh.points)))
    inner = np.concatenate(list(mesh.nodes_on_box_faces.values()))
    r = np.linalg.norm(mesh.points[np.setdiff1d(np.unique(faces), inner)], axis=1)
    assert np.abs(r - m.ball).max() < 1e-15
    rows = {tuple(sorted(f)) for f in faces[:, :3].tolist()}
    lost = 0.0
    for socket in sockets:
        nodes, standard = mesh.nodes_on_box_faces[socket.side], mesh.box_faces[socket.side]
        np.testing.assert_allclose(mesh.points[nodes], points_in_ball_refinement_box(m, socket, standard.xi), atol=1e-15)
        assert {tuple(sorted(nodes[t].tolist())) for t in standard.triangles[:, :3]} <= rows
        lost += socket_volume(m, socket)
    assert volume_of(mesh) == pytest.approx(4.0 / 3.0 * np.pi * m.ball**3 - lost, rel=3e-3)
