"""What grooves and faces add to the compliance between contacts of a turn."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.comparison.scenes.catalogue import scene
from rollbench.lowfi.compliance import faces
from rollbench.lowfi.compliance.bodies import REFINED, flank_of, geometry_only, grooved_part, kept_near_face, smooth_body
from rollbench.lowfi.compliance.fourier import Body, Grid, lower_corner, solved
from rollbench.lowfi.compliance.groove import NARROW
from rollbench.meshes.helix import ball_layout

pytestmark = pytest.mark.xdist_group("near face")


@pytest.fixture(scope="module")
def case():
    """Geometry of case 1, its nut's flank and smooth body."""
    parts = geometry_only(scene("lin-case1"))
    return parts, flank_of(parts, False), smooth_body(parts, False, REFINED)


@pytest.mark.parametrize("held", [False, True])
def test_a_cut_is_a_body_of_its_own(case, held):
    """One factor of the longest body gives the motion of a shorter one, meshed and solved alone: harmonic 3."""
    _, flank, smooth = case
    grid, cuts = faces.grooved_grid(flank)
    loads = faces.true_loads(flank, grid, cuts)
    found = faces.cut_motions(flank, grid, cuts, (0.0, np.inf), smooth.held, loads, NARROW * flank.map.ball)
    k, n = 3, 3
    short = Grid(grid.r[: cuts[k] + 1], grid.z[: cuts[k] + 1])
    fixed = np.zeros((*short.shape, 3), dtype=bool)
    fixed[[0, -1] if held else 0] = True
    own = loads[:2, k, : cuts[k] + 1].reshape(2, -1)[:, ~fixed.ravel()].T
    body = Body(short, flank.material.youngs_modulus, flank.material.poissons_ratio)
    alone = own.T @ solved(body.bands(~fixed.ravel()), n, own)
    share = np.exp(-((n * NARROW * flank.map.ball / flank.contact()[0]) ** 2))
    assert found[int(held), n, :, :2, k] == pytest.approx(share * alone, rel=1e-8)


def test_a_lip_is_soft_and_a_clamp_is_stiff(case):
    """3D own compliance of case 1's nut gains 0.254 and 0.135 um/kN at 2.05 and 2.50 ball radii of the contact from
    a free face, towards which it is pressed; at a held face it loses."""
    parts, flank, _ = case
    found = kept_near_face(parts, False, REFINED)
    distance = np.array([2.05, 2.50]) * flank.map.ball + found.beside
    gain = found.by_face(False, np.zeros(2), distance)[:, 0, 0]
    assert gain * 1e9 == pytest.approx([0.254, 0.135], abs=0.03)
    assert (found.by_face(True, np.zeros(2), distance)[:, 0, 0] < 0.0).all()
    assert found.by_face(False, np.zeros(1), np.array([1.0]))[0] == pytest.approx(np.zeros((2, 2)), abs=1e-20)


def test_both_faces_are_told_apart():
    """A nut turned end for end has the same compliance, its balls and flanks turned with it."""
    parts = scene("lin-case1")
    here = grooved_part(parts, ball_layout(parts), False, REFINED)
    other = replace(parts, solid=replace(parts.solid, nut_held="right face"))
    turned = grooved_part(other, ball_layout(other), False, REFINED)
    shape = (2, ball_layout(parts).z.size, 2)
    back = (
        turned.reshape(*shape, *shape)[::-1, ::-1, :, ::-1, ::-1]
        * np.array([1.0, -1.0])
        * np.array([1.0, -1.0])[:, None, None, None]
    )
    assert here.reshape(*shape, *shape) == pytest.approx(back, abs=2e-3 * np.abs(here).max())


def test_the_free_face_is_the_other_one():
    """The nut of case 1 is held at its left face: its last right contact gains, its first left one loses."""
    layout = ball_layout(scene("lin-case1"))
    G = grooved_part(scene("lin-case1"), layout, False, REFINED).reshape(2, layout.z.size, 2, 2, layout.z.size, 2)
    left, right = (np.einsum("iaia->i", G[side, :, :, side]) for side in (0, 1))
    assert right[np.argmax(layout.z)] * 1e9 == pytest.approx(0.254, abs=0.03)
    assert left[np.argmin(layout.z)] < 0.0


def test_short_lands_are_softer():
    """Grooves 1.57 ball radii from mid land to mid land: 3D own compliance is 0.25 um/kN above a clamped cell's."""
    own = kept_near_face(geometry_only(scene("unseen-40x10")), False, REFINED).own
    assert own * 1e9 == pytest.approx(0.25, abs=0.04)


def test_corner_of_bands():
    """A block on the diagonal of a matrix kept in lower bands."""
    full = np.tril(np.arange(36.0).reshape(6, 6) + 1.0)
    bands = np.array([np.append(np.diag(full, -k), np.zeros(k)) for k in range(6)])
    assert np.array_equal(lower_corner(bands, 2, 3), full[2:5, 2:5])
