"""Motion of a section of the 3D screw: the mean of its material, not of points near a load."""

import numpy as np
import pytest

from rollbench.compare.scenes import catalogue
from rollbench.hifi.bodies.coarse import end_transform
from rollbench.hifi.condensation import section_motion_matrix
from rollbench.hifi.elements.forms import assemble, elasticity
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.hifi.linear_algebra import compliance
from rollbench.hifi.shaft.section import helical_stiffness
from rollbench.meshes.fem import points_of
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import build_body
from rollbench.meshes.sockets import SocketSize
from rollbench.meshes.solid import solid_dimensions

SCENE = catalogue.scene("unseen-16x5")
LENGTH = 48e-3


def test_a_load_on_a_section_moves_it_as_beam_theory_has_it_and_rigid_motions_are_found_exactly() -> None:
    """Own flexibility of a section inside: a load on a few nodes of the hole turns these far more than the section."""
    m, radii = GrooveMap.of(SCENE), (solid_dimensions(SCENE).hole, SCENE.screw.outer_diameter / 2.0)
    spec = BodySpec(*radii, m.z0, m.z0 + LENGTH, True, (), SocketSize(0.3, 1e-3, 0.05), 4e-3, 4e-3)
    mesh, z = build_body(m, spec).mesh, m.z0 + 0.4 * LENGTH
    rows = section_motion_matrix(mesh, z) @ rigid_modes(points_of(mesh), np.array([0.0, 0.0, z]))
    np.testing.assert_allclose(rows, np.eye(6), atol=1e-9)
    z, e = m.z0 + 0.5 * LENGTH, SCENE.screw.material
    K = assemble(elasticity(e.youngs_modulus, e.poissons_ratio), mesh)
    T = end_transform(mesh, m.z0 + LENGTH)
    flexibility = compliance((T.T @ K @ T).tocsc(), section_motion_matrix(mesh, z) @ T)
    stretch, EI = helical_stiffness(m, SCENE.screw.outer_diameter / 2.0, 0.0, e)
    flexible = np.linalg.inv(stretch)
    found = np.diag(flexibility)[[2, 3, 4, 5]] / (z - m.z0)
    assert found == pytest.approx([flexible[0, 0], 1.0 / EI, 1.0 / EI, flexible[1, 1]], rel=0.08)
