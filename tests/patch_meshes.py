"""Shared by the tests of fine patches: a cube with a socket, patches in groove and ball, condensed ones."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
from tests.fe_meshes import boundary_faces, cube
from tests.helpers import small_screw

from rollbench.hifi.bodies import patch as bodies_patch
from rollbench.hifi.meshing.part_meshes import ball_refinement_box_and_map
from rollbench.meshes.fem import build_mesh
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.sockets import RefinementBoxFaces, RefinementBoxSize, points_in_box_at_azimuth_zero
from rollbench.meshes.tet_patch import mesh_patch_with_tetrahedra, patch_as_in_thesis

E, NU = 210e9, 0.28
MAP = GrooveMap.from_scene(small_screw(6))
SIZE = RefinementBoxSize(0.30, 1.2e-3, 1.24e-3 / MAP.R)
WIDTH = (SIZE.gamma * float(MAP.radius.mean()), SIZE.phi * MAP.R)
SEMI = (0.40e-3, 0.105e-3)
ZONE = (0.62, 0.17)


def lines(b_over_h, growth=1.7):
    """Elements of a second-order patch with so many nodes across the short semi-axis; growth: beside the contact zone."""
    step = 2.0 * SEMI[1] / b_over_h / WIDTH[1]
    across = bodies_patch.graded_cell_boundaries(ZONE[0], 2.0 * SEMI[0] / b_over_h / WIDTH[0], growth)
    return bodies_patch.PatchCellBoundaries(
        across,
        bodies_patch.growing_cell_boundaries(0.0, 1.0, 0.6 * step, 1.8),
        bodies_patch.graded_cell_boundaries(ZONE[1], step, growth),
    )


@cache
def holed_cube():
    """Unit cube of second-order tetrahedra without a block under its upper face, its floor named: mesh, nodes of the
    block's five faces, and these as a socket with gamma along x, azimuth along y."""
    points, cells = cube("P2", 4)
    local = (points - [0.5, 0.5, 1.0]) / [0.25, 0.25, -0.5]
    xi = np.column_stack([local[:, 0], local[:, 2], local[:, 1]])
    inside = (np.abs(xi - [0.0, 0.5, 0.0]) < np.array([1.0, 0.5, 1.0]) + 1e-9).all(axis=1)
    used, cells = np.unique(cells[~inside[cells].all(axis=1)], return_inverse=True)
    points, xi, inside, cells = points[used], xi[used], inside[used], cells.reshape(-1, 10)
    faces = boundary_faces(cells, "P2")
    floor = faces[(points[faces][..., 2] < 1e-9).all(axis=1)]
    nodes, triangles = np.unique(faces[inside[faces].all(axis=1)], return_inverse=True)
    triangles = triangles.reshape(-1, 6)
    assert len(triangles) == 5 * 8
    mesh, number = build_mesh(points, cells, "P2", {"floor": floor})
    corners, middles = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), triangles[:, 3:].ravel().tolist()
    midside = dict(zip(map(tuple, np.sort(corners, axis=1).tolist()), middles, strict=True))
    return mesh, number[nodes], RefinementBoxFaces(xi[nodes], triangles, midside)


def socket(*, turned=False):
    """Socket of the holed cube; turned: its mirror image, with the diagonals of two faces the other way."""
    mesh = holed_cube()[2]
    return replace(mesh, xi=mesh.xi * [-1.0, 1.0, 1.0]) if turned else mesh


def flat(xi):
    """Place of the block in the unit cube."""
    return np.column_stack([0.5 + 0.25 * xi[:, 0], 0.5 + 0.25 * xi[:, 2], 1.0 - 0.5 * xi[:, 1]])


def places(side):
    """Maps into groove and ball at a side, and the ball's centre in each."""
    groove = partial(points_in_box_at_azimuth_zero, MAP, SIZE, side)
    return {
        "groove": (groove, np.array([MAP.R, 0.0, 0.0])),
        "ball": (ball_refinement_box_and_map(MAP, SIZE, side, ZONE)[1], np.zeros(3)),
    }


@cache
def tets(fine, way="straight"):
    return mesh_patch_with_tetrahedra(patch_as_in_thesis(WIDTH, SIZE.depth, ZONE, fine), socket(turned=way == "turned"))


def patch(kind, where="groove", side=0, fine=0.16e-3):
    """Patch mesh and the directions of its contact forces."""
    place, centre = places(side)[where]
    mesh = (
        bodies_patch.mesh_hexahedral_patch(lines(2.0), ZONE, place, socket())
        if kind == "Q2"
        else bodies_patch.fit_tetrahedral_patch(tets(fine), place, socket())
    )
    arms = mesh.points[mesh.contact_nodes] - centre
    return mesh, arms / np.linalg.norm(arms, axis=1)[:, None]


@cache
def condensed(*args, **options):
    mesh, normals = patch(*args, **options)
    return mesh, normals, bodies_patch.condense_patch(mesh, normals, E, NU)
