"""Contacts of the 3D reference with a penalty: springs of its size times the hats' areas, one to a pair of nodes."""

from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.cases.lin.reconstruction.solvers import add_penalty_springs
from rollbench.hifi.condensation import FlankPatches
from rollbench.hifi.contact.balls import ball_block_from_dense_matrix, solve_contacts_of_one_ball
from rollbench.hifi.setup import CondensedGeometry


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
