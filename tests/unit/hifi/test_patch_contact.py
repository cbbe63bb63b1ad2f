"""The loaded face of a fine patch: indentation, areas, nodes of ball and groove, rim, weights, names."""

from __future__ import annotations

import numpy as np
import pytest
from tests.fe_meshes import jacobians, volume
from tests.patch_meshes import MAP, NU, SEMI, WIDTH, ZONE, E, condensed, lines, patch, places, socket, tets

from rollbench.hifi.bodies.patch import fit_tetrahedral_patch, mesh_hexahedral_patch, nodal_displacements_of_patch
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import normalise_weight_rows

pytestmark = pytest.mark.xdist_group("condensed patches")


def indentation(kind, where, fine=None, b_over_h=None):
    """Mean indentation [um] under a total of 225 N spread like Hertz's pressure, the socket held."""
    if kind == "Q2":
        grid = lines(b_over_h, 3.0)
        place, centre = places(0)[where]
        mesh = mesh_hexahedral_patch(grid, ZONE, place, socket())
        axes = [np.union1d(x, 0.5 * (x[1:] + x[:-1])) for x in (grid.across, grid.along)]
        axes = [x[np.abs(x) < half + 1e-9] for x, half in zip(axes, ZONE, strict=True)]
        local = np.stack(np.meshgrid(axes[0], 0.0, axes[1], indexing="ij"), -1).reshape(-1, 3)
        arms = mesh.points[mesh.contact_nodes] - centre
        normals = arms / np.linalg.norm(arms, axis=1)[:, None]
    else:
        mesh, normals = patch(kind, where, fine=fine)
        local = tets(fine).xi[mesh.contact_nodes]
    a, b = SEMI
    f = np.sqrt(np.maximum(1.0 - (local[:, 0] * WIDTH[0] / a) ** 2 - (local[:, 2] * WIDTH[1] / b) ** 2, 0.0)) * mesh.areas
    f *= 225.0 / f.sum()
    u = nodal_displacements_of_patch(mesh, normals, E, NU, f, np.zeros(3 * mesh.interface_weights.shape[1]))
    return (
        1e6
        * float(f @ normalise_weight_rows(mesh.pressure_weights) @ (u[mesh.contact_nodes] * normals).sum(axis=1))
        / 225.0
    )


@pytest.mark.parametrize("where", ["groove", "ball"])
def test_first_order_is_stiff_and_converges(where):
    """The source's 0.08 mm are 6 to 8 % too stiff within the patch.

    Hertz's pressure is sampled at the nodes, so that its edge falls anywhere between two of them: 3 % on four cells.
    """
    limit = indentation("Q2", where, b_over_h=6.0)
    assert indentation("Q2", where, b_over_h=4.0) == pytest.approx(limit, rel=0.03)
    missing = [1.0 - indentation("P1", where, fine=fine) / limit for fine in (0.16e-3, 0.08e-3, 0.04e-3)]
    assert missing[0] > 1.7 * missing[1] > 1.7**2 * missing[2] > 0.0
    assert 0.04 < missing[1] < 0.10
    assert missing[2] < 0.04


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize("where", ["groove", "ball"])
def test_cells_fill_the_patch(where, side):
    """Left- and right-handed maps: every cell positive, volume and top that of the hexahedra."""
    hexa, tetra = patch("Q2", where, side)[0], patch("P1", where, side, 0.08e-3)[0]
    assert jacobians(tetra.points, tetra.cells, "P1").min() > 0.0
    assert jacobians(hexa.points, hexa.cells, "Q2").min() > 0.0
    first, second = (volume(x.points, x.cells, x.element_type) for x in (hexa, tetra))
    assert second == pytest.approx(first, rel=0.01)


@pytest.mark.parametrize("where", ["groove", "ball"])
def test_contact_areas(where):
    """The hats of all contact nodes share out the zone, on hexahedra and on tetrahedra."""
    place = places(0)[where][0]
    x, w = np.polynomial.legendre.leggauss(6)
    a, b = np.meshgrid(ZONE[0] * x, ZONE[1] * x, indexing="ij")
    xi = np.column_stack([a.ravel(), np.zeros(a.size), b.ravel()])
    tangents = [(place(xi + d) - place(xi - d)) / 2e-6 for d in 1e-6 * np.eye(3)[[0, 2]]]
    zone = ZONE[0] * ZONE[1] * float(np.outer(w, w).ravel() @ np.linalg.norm(np.cross(*tangents), axis=1))
    for kind, close in (("P1", 2e-3), ("Q2", 1e-4)):
        assert patch(kind, where, fine=0.08e-3)[0].areas.sum() == pytest.approx(zone, rel=close)


@pytest.mark.parametrize("side", [0, 3])
def test_contact_nodes_of_ball_and_groove_coincide(side):
    """On rays from the ball's centre, also where the two sockets are triangulated differently."""
    groove = patch("P1", "groove", side)[1]
    local = tets(0.16e-3, "turned")
    mesh = fit_tetrahedral_patch(local, places(side)["ball"][0], socket(turned=True))
    ball = mesh.points[mesh.contact_nodes]
    np.testing.assert_allclose(ball / np.linalg.norm(ball, axis=1)[:, None], groove, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(ball, axis=1), MAP.ball, rtol=1e-14)


@pytest.mark.parametrize("where", ["groove", "ball"])
@pytest.mark.parametrize("kind", ["P1", "Q2"])
def test_contact_weights_share_out_the_zone(kind, where):
    """Inside the rim their sums over pressures are the areas of the displacements' own functions."""
    mesh, _, c = condensed(kind, where)
    assert c.pressure_weights.shape == (len(c.nodal_areas),) * 2
    assert (abs(c.pressure_weights - mesh.pressure_weights)).max() == 0.0
    over = np.asarray(mesh.pressure_weights.sum(axis=0)).ravel()
    assert over.sum() == pytest.approx(mesh.areas.sum(), rel=1e-12)
    nodal = forms.nodal_areas(mesh.mesh, "surface")[mesh.contact_nodes]
    np.testing.assert_allclose(over[~mesh.on_zone_edge], nodal[~mesh.on_zone_edge], rtol=1e-6)
    assert (over[mesh.on_zone_edge] < nodal[mesh.on_zone_edge]).all()
    assert np.asarray(mesh.pressure_weights.sum(axis=1)).min() > 0.0
