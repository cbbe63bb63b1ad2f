"""What the curvature of a flank does to a contact's own motion: normals that turn, size and shape of the ellipse."""

import numpy as np
import pytest
from scipy.special import ive
from tests.groove_patch import patch_self_motion

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance import beyond_hertz, groove
from rollbench.lowfi.compliance.parts import half_groove_of_body, reduce_to_compliance_geometry

pytestmark = pytest.mark.xdist_group("flank")

NU = 0.28
#: alpha and beta of `contact_size_correction`.
ALPHA, BETA = 2 * (1 - NU) * (1 - 2 * NU), -(1 - 2 * NU) * (3 - 2 * NU)


@pytest.fixture(scope="module")
def flank():
    return half_groove_of_body(reduce_to_compliance_geometry(catalogue.scene("lin-case1")), True)


def test_curvature_terms_of_cylinder_and_sphere():
    """u = (A/k + (alpha tr kappa + beta k kappa k/k^2)/k^2)/2G against three bodies with exact answers, at k R = 400."""
    x, A = 400.0, 2 * (1 - NU)
    along = A * ive(1, x) ** 2 / (x**2 * ive(0, x) ** 2 - (x**2 + A) * ive(1, x) ** 2)  # long cylinder, pressure cos k z
    around = (A * x - 1 + 2 * NU) / (x**2 - 1)  # disc in plane strain, pressure cos n theta
    n = x - 0.5
    sphere = float(beyond_hertz.sphere_series_coefficients(np.array(n), NU))
    for exact, trace, along_k in ((along, 1, 0), (around, 1, 1), (sphere, 2, 1)):
        remainder = (exact - A / x) * x**2
        assert remainder == pytest.approx(ALPHA * trace + BETA * along_k, abs=2e-2)
    a, b = beyond_hertz.sphere_series_expansion(NU)
    assert (a + 2 * b) / 2 == pytest.approx(2 * ALPHA + BETA, rel=1e-12)


def test_loads_along_the_normals_move_a_concave_flank_less(flank):
    """By (1 - 2 nu)/(8 pi G rho) and terms of the patch's width: mean of (1 - 2 nu) cos^2/(4 pi G rho) over a round one."""
    m, width = flank.groove_map, 0.12 * flank.groove_map.ball
    nominal = m.signs[flank.flank_number] * np.array([np.cos(m.beta), np.sin(m.beta)])
    grid = flank.finite_element_grid()
    line = grid.shape[1] - 1
    load = groove.nodal_forces_along_flank_normals(flank, grid, width, flank.contact_position()[1])
    fixed = np.zeros((*grid.shape, 3))
    fixed[:, line, ::2] = np.linalg.norm(load, axis=1)[:, None] * nominal
    change = patch_self_motion(flank, grid, groove.forces_of_patch(flank, grid, width), width)
    change -= patch_self_motion(flank, grid, fixed, width)
    expected = -(1 - 2 * NU) / (8 * np.pi * flank.material.shear_modulus * 3.254e-3)
    assert 0.9 < change / expected < 1.5
    assert abs(change) < 0.05 * beyond_hertz.half_space_compliance(width, flank.material)
