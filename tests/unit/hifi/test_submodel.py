"""A contact's own compliance from a submodel, in a unit cube with a block under its upper face as the patch."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.helpers import relative
from tests.patch_meshes import flat, holed_cube, socket

from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies import coarse as bodies_coarse
from rollbench.hifi.bodies import patch as bodies_patch
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.meshes.fem import node_coordinates, with_node_coordinates

pytestmark = pytest.mark.xdist_group("submodel")

E, NU = 1.0, 0.3
TURN = np.array([[0.0, 0.8, 0.6], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])


@cache
def holed(*held):
    """The unit cube without the block; held: boundaries of it."""
    mesh, nodes, _ = holed_cube()
    return bodies_coarse.ContactSubmodel(mesh, nodes, np.eye(3), held)


@cache
def patch(cells=4, zone=0.5):
    """Patch of cells x cells / 2 x cells hexahedra, and directions of its forces, not quite upright."""
    line = np.linspace(-1.0, 1.0, cells + 1)
    mesh = bodies_patch.mesh_hexahedral_patch(
        bodies_patch.PatchCellBoundaries(line, np.linspace(0.0, 1.0, cells // 2 + 1), line), (zone, zone), flat, socket()
    )
    arms = mesh.points[mesh.contact_nodes] - [0.5, 0.4, 0.0]
    return mesh, arms / np.linalg.norm(arms, axis=1)[:, None]


@cache
def condensed():
    return bodies_patch.condense_patch(*patch(), E, NU)


def turned(piece):
    """The piece in another frame: its nodes turned, its patch left in its own frame."""
    return replace(piece, mesh=with_node_coordinates(piece.mesh, node_coordinates(piece.mesh) @ TURN.T), rotation=TURN)


@pytest.mark.parametrize("rotated", [False, True])
def test_of_a_held_piece_is_that_of_patch_and_body_condensed(rotated):
    """Same socket, no carrier: C_fine = A + H (K + S)^-1 H^T, dense algebra on the body's freedoms; also in a frame that is
    not the patch's."""
    piece, c = holed("floor"), condensed()
    K = bodies_coarse.assemble_body_stiffness(
        piece.mesh, [bodies_coarse.BodySocket(piece.socket_nodes, np.eye(3), 0)], {0: c}, E, NU
    ).toarray()
    free = np.flatnonzero(np.repeat(node_coordinates(piece.mesh)[:, 2] > 1e-9, 3))
    H = np.zeros((len(c.A), len(K)))
    H[:, bodies_coarse.degrees_of_freedom_of_nodes(piece.socket_nodes)] = c.H
    wanted = c.A + H[:, free] @ np.linalg.solve(K[np.ix_(free, free)], H[:, free].T)
    found = bodies_coarse.contact_compliance_in_fine_submodel(turned(piece) if rotated else piece, *patch(), E, NU)
    assert relative(found, wanted) < 1e-9


@pytest.mark.parametrize("rotated", [False, True])
def test_modes_answer_as_the_whole_piece(rotated):
    """With all modes kept, A + V G V^T of the coarse piece is its C_fine; held or free."""
    for held in (("floor",), ()):
        piece = turned(holed(*held)) if rotated else holed(*held)
        V, rows = bodies_coarse.contact_modes_of_patch(condensed(), 10**6)
        G = bodies_coarse.mode_compliance_in_coarse_submodel(piece, condensed(), rows, E, NU)
        fine = bodies_coarse.contact_compliance_in_fine_submodel(piece, *patch(), E, NU)
        inside = fine - V @ G @ V.T
        wanted = condensed().A
        if not held:  # the patch's own mass is not the coarse piece's; rigid motions of the patch tell which forces balance
            mesh, normals = patch()
            rigid = bodies_patch.mean_normal_displacement_matrix(mesh, normals) @ nodal_displacements_of_rigid_motions(
                mesh.points
            )
            null = np.linalg.svd(rigid.T)[2][6:]
            inside, wanted = null @ inside @ null.T, null @ wanted @ null.T
        assert relative(inside, wanted) < 1e-9


def test_a_free_piece_is_answered_by_inertia_relief(monkeypatch):
    """Any six freedoms may keep the matrix from being singular: the motions under any force, which a rigid field of body
    forces balances, stay the same up to a rigid motion, as nothing is left that the six would have to hold."""
    piece, (mesh, normals) = holed(), patch()
    rows = bodies_coarse.contact_modes_of_patch(condensed(), 12)[1]

    def both():
        """Motions of hats and of modes without rigid ones, under all forces."""
        at_socket = nodal_displacements_of_rigid_motions(node_coordinates(piece.mesh)[piece.socket_nodes])
        rigid = (
            bodies_patch.mean_normal_displacement_matrix(mesh, normals) @ nodal_displacements_of_rigid_motions(mesh.points),
            rows @ at_socket,
        )
        answers = (
            bodies_coarse.contact_compliance_in_fine_submodel(piece, mesh, normals, E, NU),
            bodies_coarse.mode_compliance_in_coarse_submodel(piece, condensed(), rows, E, NU),
        )
        # orthogonal to the six rigid motions
        return [np.linalg.svd(R)[0][:, 6:].T @ F for F, R in zip(answers, rigid, strict=True)]

    found = both()
    corners = [
        int(np.abs(node_coordinates(piece.mesh) - x).sum(axis=1).argmin()) for x in ([0, 0, 0], [1, 0, 0], [0, 1, 0])
    ]
    other = bodies_coarse.degrees_of_freedom_of_nodes(np.array(corners))[[0, 1, 2, 4, 5, 8]]
    monkeypatch.setattr(coarse, "select_isostatic_freedoms", lambda *_: other)
    for again, before in zip(both(), found, strict=True):
        assert relative(again, before) < 1e-8
