"""Boxes of first-order tetrahedra: filled, sized, matching at the contact; splitting of second-order tetrahedra."""

from functools import cache

import numpy as np
import pytest
from tests.fe_meshes import LOCAL, boundary_faces, cube, distorted, face_nodes, volume
from tests.patch_meshes import socket

from rollbench.meshes import tet_patch

pytestmark = pytest.mark.xdist_group("patches of tetrahedra")

BOX = tet_patch.TetrahedralPatchSizes((1.0e-3, 1.2e-3), 0.9e-3, (0.5, 0.15), (0.6e-3, 0.35e-3, 0.15e-3), 0.08e-3, 0.5e-3)


@cache
def mesh(kind="straight"):
    return tet_patch.mesh_patch_with_tetrahedra(BOX, socket(turned=kind == "turned"))


def area(points, triangles):
    corner = points[triangles]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)


@pytest.mark.parametrize("kind", ["straight", "turned"])
def test_box_is_filled(kind):
    m = mesh(kind)
    volumes = tet_patch.signed_volumes(m.xi, m.tetrahedra)
    assert (volumes > 0.0).all() or (volumes < 0.0).all()
    assert abs(volumes.sum()) == pytest.approx(4.0, rel=1e-12)
    assert np.array_equal(np.unique(m.tetrahedra), np.arange(len(m.xi)))
    faces = boundary_faces(m.tetrahedra, "P1")
    top = faces[(np.abs(m.xi[faces, 1]) < 1e-12).all(axis=1)]
    assert {frozenset(t) for t in top} == {frozenset(t) for t in m.top_triangles}
    assert len(top) == len(m.top_triangles)
    assert area(m.xi, m.top_triangles).sum() == pytest.approx(4.0, rel=1e-12)
    planes = ((0, -1), (0, 1), (1, 0), (1, 1), (2, -1), (2, 1))
    outside = np.any([np.abs(m.xi[:, k] - v) < 1e-12 for k, v in planes], axis=0)
    assert np.array_equal(np.unique(faces), np.flatnonzero(outside))


def test_contact_nodes_are_those_of_the_zone():
    m = mesh()
    top = np.abs(m.xi[:, 1]) < 1e-12
    zone = (np.abs(m.xi[:, 0]) < 0.5 + 1e-9) & (np.abs(m.xi[:, 2]) < 0.15 + 1e-9)
    assert np.array_equal(np.sort(m.contact_nodes), np.flatnonzero(top & zone))
    within = np.isin(m.top_triangles, m.contact_nodes).all(axis=1)
    assert area(m.xi, m.top_triangles[within]).sum() == pytest.approx(4 * 0.5 * 0.15, rel=1e-12)
    place = m.xi[m.contact_nodes]
    assert np.all((np.diff(place[:, 0]) > 1e-10) | (np.diff(place[:, 2]) > 0.0))  # across, then along


@pytest.mark.parametrize("kind", ["straight", "turned"])
def test_faces_divide_the_socket_s_triangles(kind):
    m, s = mesh(kind), socket(turned=kind == "turned")
    faces = boundary_faces(m.tetrahedra, "P1")
    faces = faces[(m.xi[faces, 1] > 1e-12).any(axis=1)]
    sub = s.xi[s.triangles[:, np.array(tet_patch.SUB_TRIANGLES)].reshape(-1, 3)]
    found = np.zeros(len(faces))
    for corner in sub:
        basis = np.column_stack([corner[1] - corner[0], corner[2] - corner[0], np.cross(*(corner[1:] - corner[0]))])
        t = (m.xi[faces] - corner[0]) @ np.linalg.inv(basis).T
        flat = np.abs(t[..., 2]) < 1e-9
        inside = flat & (t[..., :2] > -1e-9).all(axis=2) & (t[..., 0] + t[..., 1] < 1.0 + 1e-9)
        own_faces = inside.all(axis=1)
        assert area(m.xi, faces[own_faces]).sum() == pytest.approx(0.5 * np.linalg.norm(basis[:, 2]), rel=1e-9)
        found += own_faces
    assert (found == 1.0).all()


def test_split_cells_fill_the_same_volume_and_conform():
    """Their faces on the surface are the four triangles of every second-order face; inside, each is shared by two."""
    points, cells = cube("P2", 2)
    parts = tet_patch.split_into_linear_tetrahedra(points, cells)
    assert parts.shape == (8 * len(cells), 4)
    assert np.array_equal(np.unique(parts), np.unique(cells))
    outside = boundary_faces(cells, "P2")[:, np.array(tet_patch.SUB_TRIANGLES)].reshape(-1, 3)
    assert {frozenset(t) for t in boundary_faces(parts, "P1")} == {frozenset(t) for t in outside}
    _, count = np.unique(np.sort(parts[:, face_nodes("P1")].reshape(-1, 3), axis=1), axis=0, return_counts=True)
    assert set(count) == {1, 2}
    volumes = tet_patch.signed_volumes(points, parts)
    np.testing.assert_allclose(volumes, np.repeat(tet_patch.signed_volumes(points, cells[:, :4]) / 8.0, 8), rtol=1e-12)
    bent = distorted(points, 0.05)
    parts = tet_patch.split_into_linear_tetrahedra(bent, cells)
    volumes = tet_patch.signed_volumes(bent, parts)
    assert (volumes > 0.0).all()
    assert volumes.sum() == pytest.approx(volume(bent, cells, "P2"), rel=0.01)
    assert volumes.sum() == pytest.approx(volume(bent, parts, "P1"), rel=1e-12)


CORNERS = np.array([[1.0, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])
REGULAR = CORNERS[0] + LOCAL["P2"] @ (CORNERS[1:] - CORNERS[0])


def test_curved_cells_are_split_into_whole_ones_or_refused():
    rng, refused = np.random.default_rng(3), 0
    for _ in range(400):
        points = REGULAR.copy()
        points[4:] += rng.normal(0.0, 0.35, (6, 3))
        try:
            parts = tet_patch.split_into_linear_tetrahedra(points, np.arange(10)[None])
        except ValueError as error:
            assert "1 of 1 second-order cells are too curved" in str(error)  # noqa: PT017
            refused += 1
            continue
        assert (tet_patch.signed_volumes(points, parts) > 0.0).all()
    assert 5 < refused < 200
