"""Contacts of the 3D reference as the reconstruction changes them: friction of grooves that slide on balls, as forces along
the nodes' normals; a penalty, as springs of its size times the hats' areas, one to a pair of nodes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.cases.lin.reconstruction.solvers import SlidingLoadCase, add_penalty_springs
from rollbench.compare.scenes import catalogue
from rollbench.hifi.condensation import FlankPatches
from rollbench.hifi.contact.balls import ball_block_from_dense_matrix, solve_contacts_of_one_ball
from rollbench.hifi.setup import CondensedGeometry
from rollbench.meshes.groove_map import GrooveMap


@pytest.mark.parametrize("mu", [0.01, -0.01])
def test_forces_on_the_nodes_have_the_friction_of_each_contact_for_resultant(mu: float) -> None:
    """Across the contact's load in the section of the groove, with the axial part of that load where the screw goes on."""
    alpha, n = 0.2, 9
    m = replace(GrooveMap.from_scene(catalogue.scene("lin-case1")), alpha=alpha)
    section = np.array([[1.0, 0.0, 0.0], [0.0, -np.sin(alpha), np.cos(alpha)]])
    turned = np.radians(np.linspace(-8.0, 8.0, n))
    left, right = (np.stack([np.cos(0.8 + turned), s * np.sin(0.8 + turned)], axis=1) @ section for s in (1.0, -1.0))
    normals = np.stack([np.concatenate([-x, x]) for x in (left, right)])  # two balls, on SL and NR, SR and NL
    forces = np.random.default_rng(1).uniform(1.0, 2.0, (2, 2 * n))
    forces[1, n:] = 0.0
    case = SlidingLoadCase.__new__(SlidingLoadCase)
    zones = (slice(0, n), 0), (slice(n, 2 * n), 3)
    case.mu, case.sets = mu, [SimpleNamespace(geometry=SimpleNamespace(groove_map=m), node_slices_of_flanks=zones)]
    across = case.friction_as_normal_forces(SimpleNamespace(nodal_forces_by_set=[forces], contact_normals=[normals]))
    for ball, nodes in ((0, slice(0, n)), (0, slice(n, 2 * n)), (1, slice(0, n))):
        load, friction = (of_nodes[ball, nodes] @ normals[ball, nodes] for of_nodes in (forces, across))
        assert np.linalg.norm(friction) == pytest.approx(0.01 * np.linalg.norm(load))
        for direction in (load, [0.0, np.cos(alpha), np.sin(alpha)]):
            assert friction @ direction == pytest.approx(0.0, abs=1e-12)
        assert np.sign(friction[2] * load[2]) == np.sign(mu)
    assert not across[1, n:].any()


def test_rigid_bodies_press_by_the_penalty_alone():
    """A paraboloid of radii R1, R2 pressed into a bed of springs k [N/m3] by d: F = pi k d^2 sqrt(R1 R2)."""
    penalty, radii, pressed = 6e14, (3e-3, 0.5e-3), 5e-6
    reach = [1.3 * np.sqrt(2.0 * r * pressed) for r in radii]
    x, y = (np.linspace(-a, a, 41) for a in reach)
    area = np.full(41 * 41, (x[1] - x[0]) * (y[1] - y[0]))
    gap = (x[:, None] ** 2 / (2.0 * radii[0]) + y[None, :] ** 2 / (2.0 * radii[1])).ravel()
    pair = FlankPatches(SimpleNamespace(nodal_areas=area), None, np.zeros((gap.size, gap.size)), None)
    setup = CondensedGeometry.__new__(CondensedGeometry)
    setup.__dict__.update(dict.fromkeys(CondensedGeometry.__dataclass_fields__), patches_by_flank={0: pair})
    local = add_penalty_springs(setup, penalty).patches_by_flank[0].local_compliance
    found = solve_contacts_of_one_ball(ball_block_from_dense_matrix(local), gap - pressed, np.zeros(gap.size, dtype=bool))
    assert found.forces.sum() == pytest.approx(np.pi * penalty * pressed**2 * np.sqrt(radii[0] * radii[1]), rel=5e-3)
