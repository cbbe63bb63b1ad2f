"""Measures of meshes: scaled Jacobians of curved cells, mending, refusal."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshTet2
from tests.fe_meshes import KINDS, LOCAL, jacobians

from rollbench.hifi.elements.forms import elastic_stiffness
from rollbench.meshes import fem
from rollbench.meshes.fem import build_mesh, node_coordinates, with_node_coordinates

pytestmark = pytest.mark.xdist_group("shaken meshes")

REGULAR = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])[[0, 2, 1, 3]]


@pytest.fixture(scope="module")
def shaken():
    """Many moderately distorted cells of every kind: points and cells."""
    random = np.random.default_rng(3)
    found = {}
    for kind in KINDS:
        local = LOCAL[kind] - LOCAL[kind].mean(axis=0)
        turn = random.normal(size=(40, 3, 3))
        turn[:, 0] *= np.sign(np.linalg.det(turn))[:, None]
        points = (local[None] @ turn) + 0.02 * random.normal(size=(40, len(local), 3))
        found[kind] = points.reshape(-1, 3), np.arange(40 * len(local)).reshape(40, -1)
    return found


@pytest.mark.parametrize("kind", ["P1", "Q1"])
def test_scaled_jacobians_of_straight_cells_are_vtks(shaken, kind):
    """Stimpson's measure, as VTK has it for straight cells; curved ones it takes by their corners."""
    import pyvista

    points, cells = shaken[kind]
    cell_type = pyvista.CellType.TETRA if kind == "P1" else pyvista.CellType.HEXAHEDRON
    grid = pyvista.UnstructuredGrid({cell_type: cells}, points)
    theirs = grid.cell_quality("scaled_jacobian")["scaled_jacobian"]
    np.testing.assert_allclose(jacobians(points, cells, kind), theirs, atol=1e-12)


def test_measure_counts_and_places_the_worst_cell():
    base = REGULAR[:3].mean(axis=0)
    flat = np.vstack([REGULAR[:3], base + 0.02 * (REGULAR[3] - base)])
    points = np.concatenate([REGULAR, REGULAR + 5.0, flat - 5.0])
    found = fem.mesh_quality(build_mesh(points, np.arange(12).reshape(3, 4), "P1")[0])
    assert (found.cell_count, found.node_count, found.worst_cell) == (3, 12, 2)
    assert 0.0 < found.smallest_jacobian < 0.1
    np.testing.assert_allclose(found.worst_cell_centre, points[8:].mean(axis=0))


def test_bad_mesh_is_refused_with_place_and_remedy_and_a_good_one_is_not():
    good = fem.MeshQuality(10, 20, 0.06, 4, (3e-3, 4e-3, 0.1))
    fem.check_no_inverted_cells(good, "screw")
    for smallest in (-0.2, 0.0):
        with pytest.raises(ValueError, match=r"screw: cell 4 of 10 at r = 5 mm, z = 100 mm.*smaller element sizes"):
            fem.check_no_inverted_cells(replace(good, smallest_jacobian=smallest), "screw")


def bent(by):
    """Two tetrahedra on a common face; the edge (0, 1) of the first lies on a surface and is bent towards node 3."""
    corners = np.vstack([REGULAR, [-3.0, 3.0, -3.0]])
    straight, number = build_mesh(corners, np.array([[0, 1, 2, 3], [0, 2, 3, 4]]), "P1")
    mesh = MeshTet2.from_mesh(straight)
    points, middle = node_coordinates(mesh).copy(), corners[:2].mean(axis=0)
    at = int(np.abs(points - middle).sum(axis=1).argmin())
    points[at] += by * (corners[2:4].mean(axis=0) - middle)
    return with_node_coordinates(mesh, points), np.array([*number[:2], at])


def test_untangle_bends_inner_edges_along_and_leaves_a_good_mesh_alone():
    mesh, surface = bent(0.1)
    np.testing.assert_array_equal(fem.move_inner_midside_nodes(mesh, surface).doflocs, mesh.doflocs)
    mesh, surface = bent(0.62)
    assert fem.scaled_jacobians(mesh).min() < 0.0
    after = fem.move_inner_midside_nodes(mesh, surface)
    assert fem.scaled_jacobians(after).min() > 0.02
    np.testing.assert_array_equal(after.doflocs[:, surface], mesh.doflocs[:, surface])
    np.testing.assert_array_equal(after.doflocs[:, :5], mesh.doflocs[:, :5])  # corners stay


def test_a_cell_that_is_turned_inside_out_between_its_nodes_is_straightened():
    """Its Jacobians at the nodes are positive; the stiffness is integrated at places between them."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    straight = MeshTet2.from_mesh(build_mesh(corners, np.arange(4)[None], "P1")[0])
    points = node_coordinates(straight).copy()
    points[straight.dofs.element_dofs[4:, 0]] += np.random.default_rng(703).uniform(-0.3, 0.3, (6, 3))
    mesh = with_node_coordinates(straight, points)
    assert fem.scaled_jacobians(mesh).min() > 0.0
    with pytest.raises(ValueError, match="inside out"):
        elastic_stiffness(mesh, 1.0, 0.3)
    everything, vertices = np.arange(10), mesh.dofs.element_dofs[:4, 0]
    better, straightened, _ = fem.improve_curved_cells(mesh, "body", everything, vertices)
    assert straightened > 0
    elastic_stiffness(better, 1.0, 0.3)
