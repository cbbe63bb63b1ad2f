"""The weak forms: fast assembly against scikit-fem's own, rigid motions, patch test, loads, contact weights."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from skfem import BilinearForm, Functional
from skfem.helpers import ddot, dot, eye, sym_grad, trace
from tests.fe_meshes import KINDS, boundary_faces, cube, distorted, force, space

from rollbench.hifi.bodies.coarse import body_forces_like_rigid_motions
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.meshes import fem

E, NU = 210e9, 0.28
LAM, MU = E * NU / (1.0 + NU) / (1.0 - 2.0 * NU), E / 2.0 / (1.0 + NU)
LINEAR = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.1, 0.6, 0.9]])
STRAIN = 0.5 * (LINEAR + LINEAR.T)
STRESS = LAM * np.trace(STRAIN) * np.eye(3) + 2.0 * MU * STRAIN


def straight(kind):
    """The cube, its surface "all" and its six sides named."""
    points, cells = cube(kind, 2)
    faces = boundary_faces(cells, kind)
    on = {f"{k} {x}": np.all(np.abs(points[faces][:, :, k] - x) < 1e-12, axis=1) for k in range(3) for x in (0, 1)}
    return fem.build_mesh(points, cells, kind, {"all": faces} | {name: faces[rows] for name, rows in on.items()})[0]


def stiffness(mesh):
    return forms.elastic_stiffness(mesh, E, NU)


@pytest.fixture(params=KINDS)
def curved(request):
    mesh = straight(request.param)
    return fem.with_node_coordinates(mesh, distorted(fem.node_coordinates(mesh)))


def test_fast_assembly_is_scikit_fems_own_and_elasticity_hookes_law(curved, monkeypatch):
    """The stiffness is symmetric and sorted, also in chunks of cells."""
    K = stiffness(curved)

    def energy(u, v, _):
        strain = sym_grad(u)
        return ddot(LAM * eye(trace(strain), 3) + 2.0 * MU * strain, sym_grad(v))

    expected = BilinearForm(energy).assemble(space(curved))
    assert abs(K - expected).max() < 1e-12 * abs(expected).max()
    assert abs(K - K.T).max() < 1e-15 * abs(K).max()
    assert K.copy().has_sorted_indices
    monkeypatch.setattr(forms, "CHUNK_BYTES", 1.0)
    assert abs(K - stiffness(curved)).max() < 1e-14 * abs(K).max()


def test_curved_map_is_scikit_fems(curved):
    X = np.random.default_rng(0).uniform(0.05, 0.3, (3, 5))
    ours, theirs = forms.CachedIsoparametricMap(curved), curved.mapping()
    cells = np.array([1, 3])
    for tind in (None, cells):
        np.testing.assert_allclose(ours.F(X, tind), theirs.F(X, tind), atol=1e-14)
        np.testing.assert_allclose(ours.detDF(X, tind) / theirs.detDF(X, tind), 1.0, rtol=1e-12)
    with pytest.raises(ValueError, match="points on faces"):
        ours.invF(ours.F(X, cells), cells)
    # where scikit-fem's own tolerance is below round-off
    far = fem.with_node_coordinates(curved, 2e-5 * fem.node_coordinates(curved) + 16e-3)
    areas = [forms.nodal_areas(mesh, "all").sum() for mesh in (far, curved)]
    assert areas[0] == pytest.approx(4e-10 * areas[1], rel=1e-9)


def test_patch_test_on_curved_cells(curved):
    exact = (fem.node_coordinates(curved) @ LINEAR.T).ravel()
    K = stiffness(curved).tocsr()
    held = fem.degrees_of_freedom_on_boundaries(curved, "all")
    loose = np.setdiff1d(np.arange(len(exact)), held)
    u = exact.copy()
    u[loose] = spsolve(K[loose][:, loose].tocsc(), -K[loose][:, held] @ u[held])
    np.testing.assert_allclose(u, exact, atol=1e-12 * abs(exact).max())
    strain = sym_grad(space(curved).interpolate(u))
    np.testing.assert_allclose(strain, np.broadcast_to(STRAIN[:, :, None, None], strain.shape), atol=1e-14)
    stress = forms.isotropic_stress_law(E, NU)(strain)
    np.testing.assert_allclose(stress, np.broadcast_to(STRESS[:, :, None, None], stress.shape), rtol=1e-9)


def test_loads_and_areas_have_the_right_resultants(curved):
    """Volume by the divergence theorem, moment of a field of forces, tractions by the nodal areas, rigid motions as body
    forces."""
    basis = space(curved, quadrature=None, intorder=6)
    surface = forms.face_basis(curved, "all", element=basis.elem)
    volume = force(np.array([1.0, 0.0, 0.0])).assemble(basis).reshape(-1, 3)[:, 0].sum()
    around = Functional(lambda w: dot(w.x, w.n) / 3.0).assemble(surface)
    assert volume == pytest.approx(around, rel=1e-6)
    turning = force(lambda x: np.stack([-x[1], x[0], 0.0 * x[2]])).assemble(basis)
    moment = nodal_displacements_of_rigid_motions(fem.node_coordinates(curved)).T @ turning
    inertia = Functional(lambda w: w.x[0] ** 2 + w.x[1] ** 2).assemble(basis)
    assert moment[5] == pytest.approx(inertia, rel=1e-12)
    areas = forms.nodal_areas(curved, "all")
    found = force(np.array([0.0, 2.0, 0.0])).assemble(surface).reshape(-1, 3)[:, 1]
    np.testing.assert_allclose(found, 2.0 * areas, atol=1e-15)
    assert areas.sum() == pytest.approx(6.0, rel=0.1)
    assert np.abs(np.delete(areas, fem.nodes_on_boundaries(curved, "all"))).max(initial=0.0) < 1e-15

    def motion(k):
        return lambda x: nodal_displacements_of_rigid_motions(x.reshape(3, -1).T)[:, k].reshape(-1, 3).T.reshape(x.shape)

    wanted = np.array([force(motion(k)).assemble(space(curved)) for k in range(6)])
    np.testing.assert_allclose(body_forces_like_rigid_motions(curved), wanted, atol=1e-14 * np.abs(wanted).max())
