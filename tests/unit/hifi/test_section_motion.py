"""Motion of a section of the 3D screw: the mean of its material, not of points near a load."""

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.bodies.coarse import all_freedoms_with_rigid_end
from rollbench.hifi.condensation import section_motion_matrix
from rollbench.hifi.elements.forms import assemble_constant_form, elasticity_form
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.shaft.section import stiffness_of_grooved_shaft
from rollbench.meshes.fem import node_coordinates
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.sockets import RefinementBoxSize
from rollbench.meshes.solid import dimensions_of_3d_parts

SCENE = catalogue.scene("unseen-16x5")
LENGTH = 48e-3


def test_a_load_on_a_section_moves_it_as_beam_theory_has_it_and_rigid_motions_are_found_exactly() -> None:
    """Own flexibility of a section inside: a load on a few nodes of the hole turns these far more than the section."""
    m, radii = GrooveMap.from_scene(SCENE), (dimensions_of_3d_parts(SCENE).hole, SCENE.screw.outer_diameter / 2.0)
    spec = GroovedBodySpec(*radii, m.z0, m.z0 + LENGTH, True, (), RefinementBoxSize(0.3, 1e-3, 0.05), 4e-3, 4e-3)
    mesh, z = mesh_grooved_body(m, spec).mesh, m.z0 + 0.4 * LENGTH
    rows = section_motion_matrix(mesh, z) @ nodal_displacements_of_rigid_motions(
        node_coordinates(mesh), np.array([0.0, 0.0, z])
    )
    np.testing.assert_allclose(rows, np.eye(6), atol=1e-9)
    z, e = m.z0 + 0.5 * LENGTH, SCENE.screw.material
    K = assemble_constant_form(elasticity_form(e.youngs_modulus, e.poissons_ratio), mesh)
    T = all_freedoms_with_rigid_end(mesh, m.z0 + LENGTH)
    flexibility = symmetric_compliance_of_loads((T.T @ K @ T).tocsc(), section_motion_matrix(mesh, z) @ T)
    stretch, EI = stiffness_of_grooved_shaft(m, SCENE.screw.outer_diameter / 2.0, 0.0, e)
    flexible = np.linalg.inv(stretch)
    found = np.diag(flexibility)[[2, 3, 4, 5]] / (z - m.z0)
    assert found == pytest.approx([flexible[0, 0], 1.0 / EI, 1.0 / EI, flexible[1, 1]], rel=0.08)
