"""Fine patches of hexahedra and of first-order tetrahedra: tie to the socket, condensation, assembled bodies."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from tests.fe_meshes import boundary, stiffness, strain_stress
from tests.helpers import relative
from tests.patch_meshes import NU, E, condensed, flat, holed_cube, patch, places, socket, tets

from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies import patch as bodies_patch
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.meshes.fem import node_coordinates
from rollbench.meshes.tet_patch import SUB_TRIANGLES, mesh_patch_with_tetrahedra, patch_as_in_thesis

pytestmark = pytest.mark.xdist_group("condensed patches")
KINDS = ["Q2", "P1"]


@pytest.mark.parametrize("linear", [True, False])
def test_tie_reproduces_the_socket_s_functions_and_takes_no_point_off_it(linear):
    s = socket()
    with pytest.raises(ValueError, match="lies on no triangle"):
        bodies_patch.refinement_box_interpolation_matrix(np.array([[0.5, 0.5, 0.5]]), s, linear=linear)
    np.testing.assert_allclose(
        bodies_patch.refinement_box_interpolation_matrix(s.xi, s, linear=linear).toarray(), np.eye(len(s.xi)), atol=1e-12
    )
    rng = np.random.default_rng(0)
    weights = rng.dirichlet(np.ones(3), len(s.triangles))
    points = np.einsum("tk,tkd->td", weights, s.xi[s.triangles[:, :3]])
    T = bodies_patch.refinement_box_interpolation_matrix(points, s, linear=linear)
    np.testing.assert_allclose(T @ s.xi, points, atol=1e-13)
    np.testing.assert_allclose(T @ np.ones(len(s.xi)), 1.0, atol=1e-13)
    bent = s.xi[:, :1] * s.xi[:, 1:2] + s.xi**2
    if not linear:
        np.testing.assert_allclose(T @ bent, points[:, :1] * points[:, 1:2] + points**2, atol=1e-13)
        return
    middles = s.triangles[:, np.array(SUB_TRIANGLES)].reshape(-1, 3)
    expected = bent[middles].mean(axis=1)
    np.testing.assert_allclose(
        bodies_patch.refinement_box_interpolation_matrix(s.xi[middles].mean(axis=1), s, linear=True) @ bent,
        expected,
        atol=1e-13,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_interface_lies_on_the_socket(kind):
    """Inside the flat triangles between three of its nodes, or on its second-order ones."""
    mesh, linear = patch(kind)[0], kind == "P1"
    weights = mesh.interface_weights.toarray()
    assert (np.abs(weights) > 1e-9).sum(axis=1).max() == (3 if linear else 6)
    assert (weights.min() > -1e-6) == linear
    np.testing.assert_allclose(mesh.points[mesh.interface_nodes], weights @ places(0)["groove"][0](socket().xi), rtol=1e-14)


@pytest.mark.parametrize("where", ["groove", "ball"])
@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motions_strain_nothing(kind, where):
    mesh, normals, c = condensed(kind, where)
    middle = mesh.points.mean(axis=0)
    unit = np.repeat([1.0, 1e-3], 3)
    motions = nodal_displacements_of_rigid_motions(places(0)[where][0](socket().xi), middle) / unit
    scale = np.abs(c.S).max() * np.abs(motions).max()
    assert np.abs(c.S @ motions).max() < 1e-12 * scale
    at_contact = nodal_displacements_of_rigid_motions(mesh.points[mesh.contact_nodes], middle) / unit
    expected = np.einsum("ci,cim->cm", normals, at_contact.reshape(-1, 3, 6))
    np.testing.assert_allclose(c.H @ motions, normalise_weight_rows(mesh.pressure_weights) @ expected, atol=1e-11)
    u = bodies_patch.nodal_displacements_of_patch(mesh, normals, E, NU, np.zeros(len(normals)), motions[:, 4])
    np.testing.assert_allclose(
        u.ravel(), nodal_displacements_of_rigid_motions(mesh.points, middle)[:, 4] / 1e-3, atol=1e-11
    )


@pytest.mark.parametrize("kind", KINDS)
def test_condensed_is_the_full_system_and_definite(kind):
    """Displacements, reactions and energy of the full matrix, solved at once with the socket's motion prescribed."""
    mesh, normals, c = condensed(kind)
    assert all(np.array_equal(matrix, matrix.T) for matrix in (c.S, c.A))
    values = np.linalg.eigvalsh(c.S)
    assert values[0] > -1e-11 * values[-1]
    assert values[6] > 1e-6 * values[-1]
    assert np.linalg.eigvalsh(c.A)[0] > 0.0
    rng = np.random.default_rng(1)
    f, q = 100.0 * rng.random(len(normals)), 1e-6 * rng.standard_normal(c.S.shape[0])
    n, k = len(mesh.points), mesh.interface_weights.shape[1]
    loose = np.setdiff1d(np.arange(n), mesh.interface_nodes)
    place = sp.lil_matrix((n, loose.size + k))  # nodes from inner nodes and socket nodes
    place[loose, np.arange(loose.size)] = 1.0
    place[mesh.interface_nodes, loose.size :] = mesh.interface_weights
    C = sp.kron(place, sp.identity(3)).tocsc()
    K = (C.T @ stiffness(mesh.points, mesh.cells, mesh.element_type, E, NU) @ C).tocsc()
    load = np.zeros((n, 3))
    mean = normalise_weight_rows(mesh.pressure_weights)
    load[mesh.contact_nodes] = (mean.T @ f)[:, None] * normals
    right = C.T @ load.ravel()
    i = 3 * loose.size
    inner = sp.linalg.spsolve(K[:i, :i], right[:i] - K[:i, i:] @ q)
    whole = np.concatenate([inner, q])
    u = (C @ whole).reshape(-1, 3)
    assert relative(c.A @ f + c.H @ q, mean @ (u[mesh.contact_nodes] * normals).sum(axis=1)) < 1e-10
    reaction = (K @ whole)[i:]
    assert relative(c.S @ q - c.H.T @ f, reaction) < 1e-10
    assert relative(bodies_patch.nodal_displacements_of_patch(mesh, normals, E, NU, f, q), u) < 1e-10
    assert f @ c.A @ f + q @ c.S @ q == pytest.approx(whole @ K @ whole, rel=1e-10)


#: Displacement gradient without stress on planes z = constant, for a free top.
SLOPE = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.2, -0.4, -NU / (1 - NU) * 0.3]])


@cache
def in_the_cube(*, conforming=True):
    """First-order patch in the block of the holed cube; the zone is loaded along z."""
    box = patch_as_in_thesis((0.25, 0.25), 0.5, (0.5, 0.4), 0.05, 0.2)
    mesh = bodies_patch.fit_tetrahedral_patch(
        mesh_patch_with_tetrahedra(box, socket() if conforming else None), flat, socket()
    )
    return mesh, bodies_patch.condense_patch(mesh, np.tile([0.0, 0.0, 1.0], (len(mesh.contact_nodes), 1)), 1.0, NU)


def test_constant_strain_through_a_first_order_patch():
    """Body and patch of first order conform: a linear field on the cube's surface goes through both unchanged."""
    body, nodes, target = holed_cube()
    points = node_coordinates(body)
    mesh, c = in_the_cube()
    K = coarse.assemble_body_stiffness(
        coarse.convert_mesh_order(body, "P1"), [coarse.BodySocket(nodes, np.eye(3), 0)], {0: c}, 1.0, NU
    )
    exact = points @ SLOPE.T
    held = coarse.degrees_of_freedom_of_nodes(np.setdiff1d(boundary(points), nodes))
    loose = np.setdiff1d(np.arange(K.shape[0]), held)
    u = exact.ravel().copy()
    u[loose] = sp.linalg.spsolve(K[loose][:, loose], -(K[loose][:, held] @ u[held]))
    assert relative(u.reshape(-1, 3), exact) < 1e-11
    q = u[coarse.degrees_of_freedom_of_nodes(nodes)]
    moved = (mesh.points[mesh.contact_nodes] @ SLOPE.T)[:, 2]
    assert relative(c.H @ q, normalise_weight_rows(mesh.pressure_weights) @ moved) < 1e-11
    whole = bodies_patch.nodal_displacements_of_patch(mesh, c.normals, 1.0, NU, np.zeros(len(c.A)), q)
    assert relative(whole, mesh.points @ SLOPE.T) < 1e-11
    # each side's reaction is that of the constant stress on the socket's own first-order triangles
    strain, stress = strain_stress(mesh.points, mesh.cells, "P1", whole.ravel(), 1.0, NU)
    np.testing.assert_allclose(stress[..., [2, 3, 4]], 0.0, atol=1e-13)  # the top is free
    s = stress[0, 0][[[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
    assert np.ptp(strain, axis=0).max() < 1e-12 * np.abs(strain).max() * 100
    triangles = target.triangles[:, np.array(SUB_TRIANGLES)].reshape(-1, 3)
    corner = flat(target.xi)[triangles]
    outward = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    outward *= np.sign(np.einsum("ti,ti->t", outward, corner.mean(axis=1) - [0.5, 0.5, 0.8]))[:, None]
    expected = np.zeros((len(target.xi), 3))
    np.add.at(expected, triangles, np.repeat((outward / 6.0 @ s)[:, None], 3, axis=1))
    assert relative(c.S @ q, expected.ravel()) < 1e-11


def test_map_that_turns_cells_inside_out_is_refused():
    def folded(xi):
        return np.column_stack([np.abs(xi[:, 0]), xi[:, 2], -xi[:, 1]])

    with pytest.raises(ValueError, match="inside out"):
        bodies_patch.fit_tetrahedral_patch(tets(0.16e-3), folded, socket())
