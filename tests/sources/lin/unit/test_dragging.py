"""Friction of grooves that slide on balls, as forces along the nodes' normals of the 3D reference's contacts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.cases.lin.reconstruction.solvers import SlidingLoadCase
from rollbench.compare.scenes import catalogue
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
        load = forces[ball, nodes] @ normals[ball, nodes]
        friction = across[ball, nodes] @ normals[ball, nodes]
        assert np.linalg.norm(friction) == pytest.approx(0.01 * np.linalg.norm(load))
        for direction in (load, [0.0, np.cos(alpha), np.sin(alpha)]):
            assert friction @ direction == pytest.approx(0.0, abs=1e-12)
        assert np.sign(friction[2] * load[2]) == np.sign(mu)
    assert not across[1, n:].any()
