"""The Fourier kernel against a plain tube of 27-node hexahedra: Gaussian patches on its bore, clamped at one face."""

from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from skfem import ElementVector
from tests.fe_meshes import force
from tests.helpers import relative

from rollbench.hifi.elements.forms import elastic_stiffness, face_basis
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.lowfi.compliance.tube import ContactPoints, SmoothBody, contact_compliance, tube_compliance
from rollbench.meshes.fem import build_mesh, degrees_of_freedom_on_boundaries, mesh_rectangular_grid, nodes_of_cells
from rollbench.meshes.parts import Material

pytestmark = [pytest.mark.xdist_group("tube in 3D"), pytest.mark.slow]

STEEL = Material(210e9, 0.28)
BORE, OUTER, LENGTH, WIDTH = 17.4e-3, 24e-3, 54e-3, 3e-3
AZIMUTH = np.array([0.3, 0.3, 2.1, -1.7, -2.84, 1.2, -0.6])
Z = 1e-3 * np.array([14.0, 30.0, 22.0, 40.0, 27.0, 33.0, 18.0])


def hexahedra(counts):
    """Mesh of the tube, its "bore" and its held "low end" named; elements around, along and across the wall."""
    around, along, across = counts
    lines = (np.linspace(0.0, end, count + 1) for end, count in ((1.0, across), (2.0 * np.pi, around), (LENGTH, along)))
    unrolled = mesh_rectangular_grid(*lines, "Q2")
    share, turn, height = unrolled.doflocs
    r = BORE + (OUTER - BORE) * share**1.3
    points = np.stack([r * np.cos(turn), r * np.sin(turn), height], axis=-1)
    _, first, number = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)  # closed
    cells = number[nodes_of_cells(unrolled)]
    mesh, _ = build_mesh(points[first], cells, "Q2")
    return mesh.with_boundaries({"bore": lambda x: np.hypot(x[0], x[1]) < BORE + 1e-9, "low end": lambda x: x[2] < 1e-9})


def patch_rows(mesh):
    """Loads (3 c, 3 n) of unit forces along r, t and z, spread with the density of a Gaussian in z and in angle."""
    surface = face_basis(mesh, "bore", element=ElementVector(mesh.elem()), quadrature=None, intorder=9)

    def spread(azimuth, z, axis):
        def traction(x):
            t = np.arctan2(x[1], x[0])
            off = np.angle(np.exp(1j * (t - azimuth)))
            density = np.exp(-0.5 * ((x[2] - z) ** 2 + (BORE * off) ** 2) / WIDTH**2) / (2.0 * np.pi * WIDTH**2)
            c, s = np.cos(t), np.sin(t)
            return density * np.stack([[c, s, 0 * c], [-s, c, 0 * c], [0 * c, 0 * c, 1 + 0 * c]][axis])

        return force(traction).assemble(surface)

    return np.stack([spread(t, z, axis) for t, z in zip(AZIMUTH, Z, strict=True) for axis in range(3)])


@cache
def solid(counts):
    """Compliance (3 c, 3 c) of the 3D tube."""
    mesh = hexahedra(counts)
    K = elastic_stiffness(mesh, STEEL.youngs_modulus, STEEL.poissons_ratio)
    free = np.setdiff1d(np.arange(K.shape[0]), degrees_of_freedom_on_boundaries(mesh, "low end"))
    return symmetric_compliance_of_loads(K[free][:, free], sp.csr_matrix(patch_rows(mesh)[:, free]))


@cache
def kernel(harmonics=2.6, size=1.0):
    """Compliance (3 c, 3 c) of the Fourier kernel, with a scene's choice of harmonics and mesh at 1."""
    count, mesh = int(np.ceil(harmonics * BORE / WIDTH)), (1.25 * WIDTH * size, 0.6 * WIDTH * size)
    tube = SmoothBody(BORE, OUTER, (0.0, LENGTH), "low", BORE, WIDTH, count, mesh, STEEL)
    found = tube_compliance(tube, (0.0, LENGTH))
    axes = np.concatenate([np.tile(np.eye(3)[pair], (Z.size, 1, 1)) for pair in ([0, 1], [2, 0])])
    G = contact_compliance(found, ContactPoints(np.tile(AZIMUTH, 2), np.tile(Z, 2), axes), resultant=False)
    k = 2 * np.arange(Z.size)
    pick = np.stack([k, k + 1, k + 2 * Z.size], axis=1).ravel()
    return G[np.ix_(pick, pick)]


MESHES = (24, 12, 2), (30, 15, 3)


def test_solid_has_converged():
    coarse, fine = (solid(counts) for counts in MESHES)
    assert relative(coarse, fine) < 5e-3
    assert np.all(np.diag(coarse) < np.diag(fine))


@pytest.mark.parametrize("choice", [(2.6, 1.0), (4.0, 0.5)], ids=["as chosen", "finer"])
def test_kernel_is_the_solid(choice):
    """Every pair of contacts and directions within half a per cent of the largest of its kind, and of its own motion."""
    found, expected = kernel(*choice), solid(MESHES[1])
    for a in range(3):
        for b in range(3):
            assert relative(found[a::3, b::3], expected[a::3, b::3]) < 3e-3
    np.testing.assert_allclose(np.diag(found), np.diag(expected), rtol=5e-3)
    diagonal = np.sqrt(np.diag(expected))
    assert np.abs((found - expected) / np.outer(diagonal, diagonal)).max() < 5e-3


def test_opposite_contacts_ovalise_the_tube():
    """The radial motion a third of a turn and half a turn away, of either sign, is in both to a per cent of itself."""
    found, expected = kernel(), solid(MESHES[1])
    pairs = [(0, 2), (0, 4), (1, 4), (2, 6)]
    values = np.array([[G[3 * i, 3 * j] for i, j in pairs] for G in (found, expected)])
    np.testing.assert_allclose(values[0], values[1], rtol=0.01)
