"""The block model of Hertz contact: errors fall with the mesh, and the size of the block does not matter."""

from __future__ import annotations

import numpy as np
import pytest
from tests.hertz_studies import GROUP, study

from rollbench.hifi.contact.block import JOBS, SIZE, nodal_contact_areas, surface_compliance
from rollbench.meshes import block
from rollbench.meshes.fem import nodes_on_boundaries

pytestmark = pytest.mark.xdist_group(GROUP)


def errors(run):
    """Relative size of the errors of approach, worse semi-axis, pole pressure."""
    names = ("approach", "semi_x", "semi_y", "pole_pressure")
    approach, *semi, pole = (abs(getattr(run, name) / getattr(run.hertz_solution, name) - 1.0) for name in names)
    return np.array([approach, max(semi), pole])


@pytest.mark.parametrize("name", JOBS)
def test_errors_on_27_node_hexahedra_fall_with_every_refinement(name):
    found = np.array([errors(study(JOBS[name], "Q2", n)) for n in (2.0, 3.0, 4.0)])
    assert (found[2] < found[0] / 3.0).all()  # about second order
    assert (found[1:, 2] < found[:-1, 2]).all()  # pole pressure falls each time


@pytest.mark.parametrize(
    ("element", "coarse", "fine", "most"),
    [("Q1", 2.0, 8.0, (4e-3, 4e-3, 8e-3)), ("P1", 4.0, 8.0, (2.5e-2, 2.5e-2, 5e-2)), ("P2", 2.0, 5.0, (3e-3, 3e-3, 1e-2))],
)
def test_errors_on_other_elements_fall_too(element, coarse, fine, most):
    first, last = errors(study(JOBS["A"], element, coarse)), errors(study(JOBS["A"], element, fine))
    assert (last[:2] < 0.6 * first[:2]).all()
    assert (last < most).all()


def test_second_order_elements_beat_first_order_ones_at_equal_unknowns():
    for shape, least, most in (("Q", 0.8, 1.3), ("P", 0.0, 1.5)):
        second, first = study(JOBS["A"], f"{shape}2", 4.0), study(JOBS["A"], f"{shape}1", 8.0)
        assert least < second.free_degree_of_freedom_count / first.free_degree_of_freedom_count < most
        assert errors(second)[0] < errors(first)[0] / 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("name", "b_over_h"), [("A", 4.0), ("B", 3.0)])
def test_size_of_the_block_does_not_matter_once_its_cut_moves_as_the_half_space(name, b_over_h):
    def approaches(*sizes, **held):
        return np.array([study(JOBS[name], "Q2", b_over_h, relative_block_size=size, **held).approach for size in sizes])

    found, held = approaches(2.0, SIZE, 5.0), approaches(SIZE, 5.0, far_field=False)
    assert np.ptp(found) < 1e-3 * found.mean()
    assert (held < 0.99 * found[1:]).all()
    assert held[0] < held[1]


def test_block_of_5_mm_held_on_its_cut_shifts_the_approach_as_other_programs_found():
    job = JOBS["A"]
    held = study(job, "Q2", 3.0, relative_block_size=5e-3 / job.hertz_solution.semi_x, far_field=False)
    assert -0.025 < held.approach / job.hertz_solution.approach - 1.0 < -0.017


def test_compliance_is_symmetric_and_boussinesqs_at_a_distance():
    a, young, nu = 1e-4, 210e9, 0.28
    mesh = block.mesh_block_with_hexahedra(2, (a / 8, a / 8, a / 8), (a, a, 0.0), 3 * a, 1.5)
    found = surface_compliance(mesh, (a, a), young, nu)
    assert found.asymmetry < 1e-5
    points, places = found.surface_points, ([0.875 * a, 0.0], [0.0, 0.875 * a])
    first, second = (int(np.argmin(np.abs(points - place).sum(axis=1))) for place in places)
    away = np.linalg.norm(points[first] - points[second])
    assert found.half_space_compliance[first, second] == pytest.approx(4.0 * (1 - nu**2) / (np.pi * young * away), rel=3e-3)
    assert found.fixed_block_compliance[first, second] < 0.9 * found.half_space_compliance[first, second]


@pytest.mark.parametrize("element", ["P1", "P2", "Q1", "Q2"])
def test_mesh_fills_the_block_and_its_contact_plane(element):
    order, a = int(element[1]), 1e-4
    if element[0] == "Q":
        mesh = block.mesh_block_with_hexahedra(order, (a / 4, a / 4, a / 4), (a, a, 0.0), 3 * a, 1.5)
    else:
        mesh = block.mesh_block_with_tetrahedra(order, block.EllipsoidElementSizes(a / 4, (a, a, a / 2), 0.5, 3 * a), 3 * a)
    areas = nodal_contact_areas(mesh)
    assert mesh.element == element
    assert areas.sum() == pytest.approx((3 * a) ** 2, rel=1e-12)
    assert np.abs(mesh.points[nodes_on_boundaries(mesh.mesh, "contact"), 2]).max() < 1e-12 * a
    assert mesh.points.min() > -1e-12 * a
    assert mesh.points.max() == pytest.approx(3 * a)
    corners = np.unique(mesh.mesh.facets[:, mesh.mesh.boundaries["contact"]])
    assert (areas[corners] > 0.0).all() != (element == "P2")
    np.testing.assert_allclose(mesh.points[nodes_on_boundaries(mesh.mesh, "cut")].max(axis=1), 3 * a)


def test_grading_keeps_to_its_ratio_and_refuses_nonsense():
    x = block.graded_coordinates(0.1, 1.0, 7.0, 1.4)
    steps = np.diff(x)
    assert (x[0], x[-1]) == (0.0, 7.0)
    np.testing.assert_allclose(steps[:10], 0.1)
    assert (steps[1:] / steps[:-1]).max() < 1.4 + 1e-9
    with pytest.raises(ValueError, match="choose 0 < cell_length"):
        block.graded_coordinates(0.1, 8.0, 7.0, 1.4)
