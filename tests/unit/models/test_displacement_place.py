"""Displacements are compared beyond the nut, where a beam's section and a 3D one mean the same."""

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.compare.models.model_form import axial_contact_force
from rollbench.lowfi.statics.static import solve_static


@pytest.mark.parametrize("force", [900.0, -1400.0, 0.03])
@pytest.mark.parametrize("oversize", [0.0, 3e-6])
def test_contacts_pull_the_nut_by_the_load(force, oversize):
    """Axial equilibrium of the screw; contacts without load pull nothing, whatever angle they are given."""
    scene = small_screw(9, 1.5, force=(0.0, 0.0, force), oversize=oversize)
    result = solve_static(scene, discretisation=False)
    assert axial_contact_force(scene, result.load, result.contact_angle) == pytest.approx(force, rel=1e-9)
    angle = np.where(result.load > 0.0, result.contact_angle, 1.0)
    assert axial_contact_force(scene, result.load, angle) == pytest.approx(force, rel=1e-9)
