"""Fine patches of hexahedra and of first-order tetrahedra: tie to the socket, condensation, assembled bodies, and their
loaded face: indentation, areas, nodes of ball and groove, rim, weights; a contact's own compliance from a submodel, a cube
with a block under its upper face as the patch."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from tests import patch_meshes as meshes
from tests.fe_meshes import jacobians, stiffness, volume
from tests.helpers import relative
from tests.patch_meshes import NU, ZONE, E, condensed, flat, holed_cube, places, socket, tets

from rollbench.hifi.bodies import coarse, patch
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.meshes.fem import node_coordinates, with_node_coordinates
from rollbench.meshes.tet_patch import SUB_TRIANGLES

pytestmark = pytest.mark.xdist_group("condensed patches")
KINDS = ["Q2", "P1"]


@pytest.mark.parametrize("linear", [True, False])
def test_tie_reproduces_the_socket_s_functions_and_takes_no_point_off_it(linear):
    s = socket()

    def tie(points):
        return patch.refinement_box_interpolation_matrix(points, s, linear=linear)

    with pytest.raises(ValueError, match="lies on no triangle"):
        tie(np.array([[0.5, 0.5, 0.5]]))
    np.testing.assert_allclose(tie(s.xi).toarray(), np.eye(len(s.xi)), atol=1e-12)
    weights = np.random.default_rng(0).dirichlet(np.ones(3), len(s.triangles))
    points = np.einsum("tk,tkd->td", weights, s.xi[s.triangles[:, :3]])
    T = tie(points)
    np.testing.assert_allclose(T @ s.xi, points, atol=1e-13)
    np.testing.assert_allclose(T @ np.ones(len(s.xi)), 1.0, atol=1e-13)
    bent = s.xi[:, :1] * s.xi[:, 1:2] + s.xi**2
    if not linear:
        np.testing.assert_allclose(T @ bent, points[:, :1] * points[:, 1:2] + points**2, atol=1e-13)
        return
    corners = s.triangles[:, np.array(SUB_TRIANGLES)].reshape(-1, 3)
    np.testing.assert_allclose(tie(s.xi[corners].mean(axis=1)) @ bent, bent[corners].mean(axis=1), atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_condensed_is_the_full_system_and_definite(kind):
    """Displacements, reactions and energy of the full matrix, solved at once with the socket's motion prescribed."""
    mesh, normals, c = condensed(kind)
    assert all(np.array_equal(matrix, matrix.T) for matrix in (c.S, c.A))
    values = np.linalg.eigvalsh(c.S)
    assert values[0] > -1e-11 * values[-1]
    assert values[6] > 1e-6 * values[-1]
    assert np.linalg.eigvalsh(c.A)[0] > 0.0
    rng, n = np.random.default_rng(1), len(mesh.points)
    f, q, k = 100.0 * rng.random(len(normals)), 1e-6 * rng.standard_normal(c.S.shape[0]), mesh.interface_weights.shape[1]
    loose = np.setdiff1d(np.arange(n), mesh.interface_nodes)
    place = sp.lil_matrix((n, loose.size + k))  # nodes from inner nodes and socket nodes
    place[loose, np.arange(loose.size)] = 1.0
    place[mesh.interface_nodes, loose.size :] = mesh.interface_weights
    C = sp.kron(place, sp.identity(3)).tocsc()
    K = (C.T @ stiffness(mesh.points, mesh.cells, mesh.element_type, E, NU) @ C).tocsc()
    load, mean = np.zeros((n, 3)), normalise_weight_rows(mesh.pressure_weights)
    load[mesh.contact_nodes] = (mean.T @ f)[:, None] * normals
    right = C.T @ load.ravel()
    i = 3 * loose.size
    whole = np.concatenate([sp.linalg.spsolve(K[:i, :i], right[:i] - K[:i, i:] @ q), q])
    u = (C @ whole).reshape(-1, 3)
    assert relative(c.A @ f + c.H @ q, mean @ (u[mesh.contact_nodes] * normals).sum(axis=1)) < 1e-10
    assert relative(c.S @ q - c.H.T @ f, (K @ whole)[i:]) < 1e-10
    assert relative(patch.nodal_displacements_of_patch(mesh, normals, E, NU, f, q), u) < 1e-10
    assert f @ c.A @ f + q @ c.S @ q == pytest.approx(whole @ K @ whole, rel=1e-10)


def test_map_that_turns_cells_inside_out_is_refused():
    def folded(xi):
        return np.column_stack([np.abs(xi[:, 0]), xi[:, 2], -xi[:, 1]])

    with pytest.raises(ValueError, match="inside out"):
        patch.fit_tetrahedral_patch(tets(0.16e-3), folded, socket())


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize("where", ["groove", "ball"])
def test_cells_fill_the_patch(where, side):
    """Left- and right-handed maps: every cell positive, volume and top that of the hexahedra."""
    hexa, tetra = meshes.patch("Q2", where, side)[0], meshes.patch("P1", where, side, 0.08e-3)[0]
    assert jacobians(tetra.points, tetra.cells, "P1").min() > 0.0
    assert jacobians(hexa.points, hexa.cells, "Q2").min() > 0.0
    assert volume(tetra.points, tetra.cells, "P1") == pytest.approx(volume(hexa.points, hexa.cells, "Q2"), rel=0.01)


@pytest.mark.parametrize("where", ["groove", "ball"])
def test_contact_areas(where):
    """The hats of all contact nodes share out the zone, on hexahedra and on tetrahedra."""
    place = places(0)[where][0]
    x, w = np.polynomial.legendre.leggauss(6)
    a, b = np.meshgrid(ZONE[0] * x, ZONE[1] * x, indexing="ij")
    xi = np.column_stack([a.ravel(), np.zeros(a.size), b.ravel()])
    tangents = [(place(xi + d) - place(xi - d)) / 2e-6 for d in 1e-6 * np.eye(3)[[0, 2]]]
    zone = ZONE[0] * ZONE[1] * float(np.outer(w, w).ravel() @ np.linalg.norm(np.cross(*tangents), axis=1))
    for kind, close in (("P1", 2e-3), ("Q2", 1e-4)):
        assert meshes.patch(kind, where, fine=0.08e-3)[0].areas.sum() == pytest.approx(zone, rel=close)


@pytest.mark.parametrize("side", [0, 3])
def test_contact_nodes_of_ball_and_groove_coincide(side):
    """On rays from the ball's centre, also where the two sockets are triangulated differently."""
    groove = meshes.patch("P1", "groove", side)[1]
    mesh = patch.fit_tetrahedral_patch(tets(0.16e-3, "turned"), places(side)["ball"][0], socket(turned=True))
    ball = mesh.points[mesh.contact_nodes]
    np.testing.assert_allclose(ball / np.linalg.norm(ball, axis=1)[:, None], groove, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(ball, axis=1), meshes.MAP.ball, rtol=1e-14)


@pytest.mark.parametrize("where", ["groove", "ball"])
@pytest.mark.parametrize("kind", ["P1", "Q2"])
def test_contact_weights_share_out_the_zone(kind, where):
    """Inside the rim their sums over pressures are the areas of the displacements' own functions."""
    mesh, _, c = condensed(kind, where)
    assert c.pressure_weights.shape == (len(c.nodal_areas),) * 2
    assert (abs(c.pressure_weights - mesh.pressure_weights)).max() == 0.0
    over = np.asarray(mesh.pressure_weights.sum(axis=0)).ravel()
    assert over.sum() == pytest.approx(mesh.areas.sum(), rel=1e-12)
    nodal = forms.nodal_areas(mesh.mesh, "surface")[mesh.contact_nodes]
    np.testing.assert_allclose(over[~mesh.on_zone_edge], nodal[~mesh.on_zone_edge], rtol=1e-6)
    assert (over[mesh.on_zone_edge] < nodal[mesh.on_zone_edge]).all()
    assert np.asarray(mesh.pressure_weights.sum(axis=1)).min() > 0.0


TURN = np.array([[0.0, 0.8, 0.6], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])


@cache
def holed(*held):
    """The unit cube without the block; held: boundaries of it."""
    mesh, nodes, _ = holed_cube()
    return coarse.ContactSubmodel(mesh, nodes, np.eye(3), held)


@cache
def cube_patch():
    """Patch of 4 x 2 x 4 hexahedra, and directions of its forces, not quite upright."""
    line = np.linspace(-1.0, 1.0, 5)
    cells = patch.PatchCellBoundaries(line, np.linspace(0.0, 1.0, 3), line)
    mesh = patch.mesh_hexahedral_patch(cells, (0.5, 0.5), flat, socket())
    arms = mesh.points[mesh.contact_nodes] - [0.5, 0.4, 0.0]
    return mesh, arms / np.linalg.norm(arms, axis=1)[:, None]


@cache
def condensed_cube_patch():
    return patch.condense_patch(*cube_patch(), E, NU)


def turned(piece):
    """The piece in another frame: its nodes turned, its patch left in its own frame."""
    return replace(piece, mesh=with_node_coordinates(piece.mesh, node_coordinates(piece.mesh) @ TURN.T), rotation=TURN)


def rigid_motions_of_contacts():
    """Normal motions of the patch's contact nodes by the six rigid motions."""
    mesh, normals = cube_patch()
    return patch.mean_normal_displacement_matrix(mesh, normals) @ nodal_displacements_of_rigid_motions(mesh.points)


@pytest.mark.parametrize("rotated", [False, True])
def test_own_compliance_of_a_held_piece_is_that_of_patch_and_body_condensed(rotated):
    """Same socket, no carrier: C_fine = A + H (K + S)^-1 H^T, dense algebra on the body's freedoms; also in a frame that is
    not the patch's."""
    piece, c = holed("floor"), condensed_cube_patch()
    at = [coarse.BodySocket(piece.box_nodes, np.eye(3), 0)]
    K = coarse.assemble_body_stiffness(piece.mesh, at, {0: c}, E, NU).toarray()
    free = np.flatnonzero(np.repeat(node_coordinates(piece.mesh)[:, 2] > 1e-9, 3))
    H = np.zeros((len(c.A), len(K)))
    H[:, coarse.degrees_of_freedom_of_nodes(piece.box_nodes)] = c.H
    wanted = c.A + H[:, free] @ np.linalg.solve(K[np.ix_(free, free)], H[:, free].T)
    found = coarse.contact_compliance_in_fine_submodel(turned(piece) if rotated else piece, *cube_patch(), E, NU)
    assert relative(found, wanted) < 1e-9


@pytest.mark.parametrize("rotated", [False, True])
def test_modes_answer_as_the_whole_piece(rotated):
    """With all modes kept, A + V G V^T of the coarse piece is its C_fine; held or free."""
    for held in (("floor",), ()):
        piece = turned(holed(*held)) if rotated else holed(*held)
        V, rows = coarse.contact_modes_of_patch(condensed_cube_patch(), 10**6)
        G = coarse.mode_compliance_in_coarse_submodel(piece, condensed_cube_patch(), rows, E, NU)
        whole = coarse.contact_compliance_in_fine_submodel(piece, *cube_patch(), E, NU)
        inside = whole - V @ G @ V.T
        wanted = condensed_cube_patch().A
        if not held:  # the patch's own mass is not the coarse piece's; rigid motions of the patch tell which forces balance
            null = np.linalg.svd(rigid_motions_of_contacts().T)[2][6:]
            inside, wanted = null @ inside @ null.T, null @ wanted @ null.T
        assert relative(inside, wanted) < 1e-9
