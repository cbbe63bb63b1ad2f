"""Elasticity against scikit-fem's own assembly, rigid motions, patch test, loads and cell quality."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from hifi.elasticity import (
    check_jacobians,
    load_vector,
    nodal_areas,
    rigid_modes,
    stiffness,
    strain_stress,
    traction_vector,
)
from hifi.elements import ELEMENTS
from meshes.bridge import MeshData, to_skfem
from tests.fe_meshes import boundary, boundary_faces, cube, distorted, freedoms

VOLUMES = ["P1", "P2", "Q1", "Q2"]
E, NU = 210e9, 0.28
LINEAR = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.1, 0.6, 0.9]])


@pytest.fixture(params=VOLUMES)
def mesh(request):
    points, cells = cube(request.param, 2)
    return request.param, distorted(points), cells


def test_stiffness_is_scikit_fem_s(mesh):
    import skfem
    from skfem.helpers import ddot, eye, sym_grad, trace

    name, points, cells = mesh
    element = {
        "P1": skfem.ElementTetP1(),
        "P2": skfem.ElementTetP2(),
        "Q1": skfem.ElementHex1(),
        "Q2": skfem.ElementHex2(),
    }[name]
    at, weights = ELEMENTS[name].rule()
    if not ELEMENTS[name].simplex:
        at, weights = 0.5 * (at + 1.0), weights / 8.0
    basis = skfem.Basis(
        to_skfem(MeshData(points, {name: cells}), name), skfem.ElementVector(element), quadrature=(at.T, weights)
    )
    lam, mu = E * NU / (1.0 + NU) / (1.0 - 2.0 * NU), E / 2.0 / (1.0 + NU)

    @skfem.BilinearForm
    def form(u, v, _):
        strain = sym_grad(u)
        return ddot(lam * eye(trace(strain), 3) + 2.0 * mu * strain, sym_grad(v))

    theirs = form.assemble(basis).tocsr()
    distance, node = cKDTree(points).query(basis.doflocs.T)
    assert distance.max() < 1e-12
    component = np.empty(basis.N, dtype=int)
    component[np.argsort(node, kind="stable")] = np.tile([0, 1, 2], len(points))  # the three of a node ascend
    ours = stiffness(points, cells, name, E, NU)
    order = 3 * node + component
    assert len(np.unique(order)) == 3 * len(points)
    assert abs(ours[order][:, order] - theirs).max() < 1e-12 * abs(theirs).max()


def test_stiffness_is_symmetric_and_sorted(mesh):
    name, points, cells = mesh
    K = stiffness(points, cells, name, E, NU)
    assert K.shape == (3 * len(points),) * 2
    assert abs(K - K.T).max() < 1e-15 * abs(K).max()
    assert K.copy().has_sorted_indices


def test_chunks_of_cells_change_nothing(mesh, monkeypatch):
    name, points, cells = mesh
    whole = stiffness(points, cells, name, E, NU)
    monkeypatch.setattr("hifi.elasticity.CHUNK_BYTES", 1.0)
    pieces = stiffness(points, cells, name, E, NU)
    assert abs(whole - pieces).max() < 1e-14 * abs(whole).max()


def test_moduli_per_cell_add_up(mesh):
    name, points, cells = mesh
    first = np.arange(len(cells)) < len(cells) // 3
    young, poisson = np.where(first, E, 0.5 * E), np.where(first, NU, 0.1)
    parts = stiffness(points, cells[first], name, E, NU) + stiffness(points, cells[~first], name, 0.5 * E, 0.1)
    assert abs(stiffness(points, cells, name, young, poisson) - parts).max() < 1e-14 * abs(parts).max()


def test_rigid_motions_strain_nothing_and_nothing_else_does(mesh):
    name, points, cells = mesh
    K, modes = stiffness(points, cells, name, E, NU), rigid_modes(points, points.mean(axis=0))
    assert np.linalg.matrix_rank(modes) == 6
    assert abs(K @ modes).max() < 1e-13 * abs(K).max()
    for mode in modes.T:
        assert abs(strain_stress(points, cells, name, mode, E, NU)[0]).max() < 1e-13
    values = np.linalg.eigvalsh(K.toarray())
    assert values[5] < 1e-12 * values[-1] < values[6]


def test_patch_test_on_curved_cells(mesh):
    name, points, cells = mesh
    exact = points @ LINEAR.T
    K = stiffness(points, cells, name, E, NU).tocsr()
    held = freedoms(boundary(cube(name, 2)[0]))
    loose = np.setdiff1d(np.arange(3 * len(points)), held)
    u = exact.ravel().copy()
    u[loose] = spsolve(K[loose][:, loose].tocsc(), -K[loose][:, held] @ u[held])
    np.testing.assert_allclose(u, exact.ravel(), atol=1e-12 * abs(exact).max())
    strain, stress = strain_stress(points, cells, name, u, E, NU)
    s = 0.5 * (LINEAR + LINEAR.T)
    lam, mu = E * NU / (1.0 + NU) / (1.0 - 2.0 * NU), E / 2.0 / (1.0 + NU)
    sigma = lam * np.trace(s) * np.eye(3) + 2.0 * mu * s
    pick = ([0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1])
    np.testing.assert_allclose(strain, np.broadcast_to(s[pick] * [1, 1, 1, 2, 2, 2], strain.shape), atol=1e-14)
    np.testing.assert_allclose(stress, np.broadcast_to(sigma[pick], stress.shape), rtol=1e-9)


def test_traction_of_a_constant_stress_is_the_nodal_force(mesh):
    """K u = int N sigma n dA for a linear displacement: volume and face integrals agree on flat faces."""
    name, _, cells = mesh
    points = cube(name, 2)[0]
    force = stiffness(points, cells, name, E, NU) @ (points @ LINEAR.T).ravel()
    s = 0.5 * (LINEAR + LINEAR.T)
    lam, mu = E * NU / (1.0 + NU) / (1.0 - 2.0 * NU), E / 2.0 / (1.0 + NU)
    sigma = lam * np.trace(s) * np.eye(3) + 2.0 * mu * s
    total = np.zeros(3 * len(points))
    faces = boundary_faces(cells, name)
    for axis in range(3):
        for side, sign in ((0.0, -1.0), (1.0, 1.0)):
            on = np.all(np.abs(points[faces][:, :, axis] - side) < 1e-12, axis=1)
            total += traction_vector(points, faces[on], ELEMENTS[name].face, sign * sigma[axis])
    np.testing.assert_allclose(total, force, atol=1e-12 * abs(force).max())


def test_loads_and_areas_have_the_right_resultants(mesh):
    name, points, cells = mesh
    faces = boundary_faces(cells, name)
    face = ELEMENTS[name].face
    modes = rigid_modes(points)
    # Divergence theorem on the curved cells: int x dA.n = 3 V, with V from the body force of unit density.
    volume = load_vector(points, cells, name, np.array([1.0, 0.0, 0.0])).reshape(-1, 3)[:, 0].sum()
    moment = modes.T @ load_vector(points, cells, name, lambda x: np.cross([0.0, 0.0, 1.0], x))
    assert volume == pytest.approx(1.0, abs=0.15)
    inertia = load_vector(points, cells, name, lambda x: np.column_stack([x[:, 0] ** 2 + x[:, 1] ** 2] * 3))
    assert moment[5] == pytest.approx(inertia.reshape(-1, 3)[:, 0].sum(), rel=1e-12)
    areas = nodal_areas(points, faces, face)
    np.testing.assert_allclose(
        traction_vector(points, faces, face, np.array([0.0, 2.0, 0.0])).reshape(-1, 3)[:, 1], 2.0 * areas, atol=1e-15
    )
    assert areas.sum() == pytest.approx(6.0, rel=0.1)
    assert np.all(areas[np.setdiff1d(np.arange(len(points)), faces)] == 0.0)


@pytest.mark.parametrize("name", ["P2", "Q2"])
def test_area_of_a_sphere_converges_with_the_fourth_power(name):
    errors = []
    for m in (3, 6):
        points, cells = cube(name, m)
        x = 2.0 * points - 1.0
        ball = x * (np.abs(x).max(axis=1) / np.maximum(np.linalg.norm(x, axis=1), 1e-30))[:, None]
        area = nodal_areas(ball, boundary_faces(cells, name), ELEMENTS[name].face).sum()
        errors.append(abs(area / (4.0 * np.pi) - 1.0))
    assert errors[0] < 1.5e-3
    assert np.log2(errors[0] / errors[1]) > 3.7


def test_scaled_jacobians():
    regular = np.array([[1.0, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])
    assert check_jacobians(regular, np.array([[0, 1, 2, 3]]), "P1") == pytest.approx(1.0)
    for name in ("Q1", "Q2"):
        points, cells = cube(name, 2)
        np.testing.assert_allclose(check_jacobians(3.0 * points, cells, name), 1.0)
        sheared = points @ np.array([[1.0, 0, 0], [1.0, 1, 0], [0, 0, 1]])
        np.testing.assert_allclose(check_jacobians(sheared, cells, name), np.sqrt(0.5))
    for name in VOLUMES:
        points, cells = cube(name, 2)
        assert check_jacobians(points * [1.0, 1.0, -1.0], cells, name).max() < 0.0
    points, cells = cube("P2", 1)
    straight = check_jacobians(points, cells, "P2")
    bent = points.copy()
    bent[cells[0, 4]] += 0.3 * (points[cells[0, 3]] - points[cells[0, 4]])
    assert check_jacobians(bent, cells, "P2")[0] < 0.8 * straight[0]


def test_bad_input_is_refused():
    points, cells = cube("Q1", 1)
    with pytest.raises(ValueError, match="inside out"):
        stiffness(points * [1.0, 1.0, -1.0], cells, "Q1", E, NU)
    with pytest.raises(ValueError, match=r"needs \(m, 10\)"):
        stiffness(points, cells, "P2", E, NU)
    with pytest.raises(ValueError, match="but there are 7 points"):
        stiffness(points[:7], cells, "Q1", E, NU)
    with pytest.raises(ValueError, match="expected"):
        stiffness(points[:, :2], cells, "Q1", E, NU)
    for young, poisson in ((-1.0, 0.3), (E, 0.5), (E, -1.0), (np.nan, 0.3)):
        with pytest.raises(ValueError, match="need E > 0"):
            stiffness(points, cells, "Q1", young, poisson)
