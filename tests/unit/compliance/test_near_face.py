"""What grooves and faces add to the compliance between contacts of a turn."""

import numpy as np
import pytest
from tests.groove_patch import patch_self_motion

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.catalogue import scene
from rollbench.compare.studies.survey import SEED, random_screw_scene_text
from rollbench.lowfi.compliance import between, faces
from rollbench.lowfi.compliance import parts as compliance_parts
from rollbench.lowfi.compliance.beyond_hertz import NARROW, half_space_compliance
from rollbench.lowfi.compliance.fourier import BodyOfRevolution, QuadrilateralGrid, solve_harmonic_displacements
from rollbench.lowfi.compliance.groove import forces_of_patch, sampled_harmonics
from rollbench.meshes.cache import forget_kept_results
from rollbench.meshes.helix import ball_layout

pytestmark = pytest.mark.xdist_group("near face")
LIN, REFINED = scene("lin-case1"), compliance_parts.REFINED


def nut_of(parts):
    """Geometry of a scene, its nut's flank and smooth body."""
    geometry = compliance_parts.reduce_to_compliance_geometry(parts)
    flank = compliance_parts.half_groove_of_body(geometry, False)
    return geometry, flank, compliance_parts.smooth_body(geometry, False, REFINED)


def drawn(number):
    """Scene of the survey."""
    return scene_file.scene_from_text(random_screw_scene_text(SEED, number), "drawn.toml")


@pytest.mark.parametrize("name", ["lin-case1", "unseen-40x10"])
@pytest.mark.parametrize("held", [False, True])
def test_a_cut_is_a_body_of_its_own(name, held):
    """One factor of the longest body gives the motion of a shorter one, meshed and solved alone: harmonic 3, loads on the
    own groove and on that behind, along the normals and across them."""
    _, flank, smooth = nut_of(scene(name))
    grid, cuts = faces.grooved_body_grid(flank, faces.FAR.mesh)
    k, n, width = 3, 3, NARROW * flank.groove_map.ball
    loads = faces.flank_patch_loads(flank, grid, cuts, width, 2)
    harmonics = sampled_harmonics(10.0)
    found = faces.patch_motions_for_end_faces(flank, grid, cuts, harmonics, (0.0, np.inf), smooth.held, loads, width)
    short = QuadrilateralGrid(grid.r[: cuts[k] + 1], grid.z[: cuts[k] + 1])
    fixed = np.zeros((*short.shape, 3), dtype=bool)
    fixed[[0, -1] if held else 0] = True
    forces = loads[:, :, k, : cuts[k] + 1].reshape(2 * len(loads), -1)[:, ~fixed.ravel()].T
    body = BodyOfRevolution(short, flank.material)
    motions = solve_harmonic_displacements(body.stiffness_bands(~fixed.ravel()), n, forces)
    alone = (forces[:, :4].T @ motions).reshape(2, 2, -1, 2)
    share = np.exp(-((n * width / flank.contact_position()[0]) ** 2))
    assert found[int(held), n, ..., k] == pytest.approx(share * alone, rel=1e-8, abs=1e-8 * np.abs(alone).max())


def normals_of(flank):
    """Normals of the nut's left and right flank at their nominal contacts, in the section."""
    return flank.groove_map.signs[2:] * np.array([np.cos(flank.groove_map.beta), np.sin(flank.groove_map.beta)])


def whole(parts):
    """Compliance ``(2, N, 2, N)`` [um/kN] of the nut between contacts of both flanks (left first) along their normals, but
    for what all contacts have in common."""
    layout, normal = ball_layout(parts), normals_of(nut_of(parts)[1])
    G = between.smooth_body_compliance_beyond_beam(parts, layout, False, REFINED)
    G = G + between.nut_beam_compliance(parts, layout) + between.groove_and_face_compliance(parts, layout, False, REFINED)
    count = layout.z.size
    return 1e9 * np.einsum("sa,siatjb,tb->sitj", normal, G.reshape(2, count, 2, 2, count, 2), normal)


def own(parts, flank):
    """Own compliance [um/kN] of the nut's contacts of its left or right flank."""
    return np.einsum("ii->i", whole(parts)[flank, :, flank])


def test_a_lip_is_soft_and_a_clamp_is_stiff():
    """3D own compliance of case 1's nut (level 4): the last two right contacts, 2.05 and 2.50 ball radii from the free
    face towards which they are pressed, move 1.756 and 1.352 um/kN more than a middle one; a held face takes motion."""
    (parts, flank, _), compliance = nut_of(LIN), own(LIN, 1)
    assert compliance[[-1, -2]] - compliance[16] == pytest.approx([1.756, 1.352], rel=0.04)
    found = between.groove_and_face_compliance_of_body(parts, False, REFINED)
    distance = np.array([2.05, 2.50]) * flank.groove_map.ball + found.contact_to_mid_groove
    assert (found.compliance_by_face(True, np.zeros(2), distance)[:, 0, 0, 0, 0] < 0.0).all()
    assert np.abs(found.compliance_by_face(False, np.zeros(1), np.array([1.0]))).max() < 1e-20  # far from a face


def test_a_lip_tilts_and_the_contact_leaves_it():
    """25x5, last balls 1.13, 1.29 and 1.45 radii from the free face: 3D (level 1) has contact angles of 46.2, 46.4 and 46.7
    deg on the flank pressed towards it. Without the lip's tilt they were 47.2, 47.0 and 47.0, and the load 3.9 % of the
    mean too small (116.0 N, of which level 1's mesh may have 2 N too much)."""
    result = run_model(drawn(6), "refined", ModelOptions(estimate_beam_mesh_error=False))
    assert np.degrees(result.contact_angle[[39, 38, 37], 2]) == pytest.approx([46.205, 46.433, 46.653], abs=0.12)
    assert result.load[39] == pytest.approx([50.18, 117.70, 116.04, 45.61], abs=1.0)


def test_short_lands_are_softer():
    """Grooves 1.57 ball radii from mid land to mid land: beyond the beam, 3D own compliance of a middle contact is
    0.96 um/kN above that of a cell of half a lead clamped at its end and outer surface."""
    parts, middle = scene("unseen-40x10"), 28
    (geometry, flank, _), layout = nut_of(parts), ball_layout(parts)
    width, grid = NARROW * flank.groove_map.ball, flank.finite_element_grid()
    cell = patch_self_motion(flank, grid, forces_of_patch(flank, grid, width), width)
    beam = between.nut_beam_compliance(parts, layout).reshape(2, -1, 2, 2, layout.z.size, 2)[1, middle, :, 1, middle]
    normal = normals_of(flank)[1]
    softer = between.groove_and_face_compliance_of_body(geometry, False, REFINED).self_compliance
    softer += half_space_compliance(width, flank.material) - cell
    beyond = whole(parts)[1, middle, 1, middle] - 1e9 * normal @ beam @ normal
    assert beyond + softer * 1e9 == pytest.approx(0.96, abs=0.04)


def test_a_land_between_two_contacts():
    """3D compliance (level 4) of the 40x10 nut between contacts on both sides of one land, 19 balls apart, far from the
    faces and next to the free one; the smooth body alone has 0.067 and 0.061 um/kN more."""
    G = whole(scene("unseen-40x10"))
    assert [G[0, 37, 1, 18], G[0, 56, 1, 37]] == pytest.approx([0.543, 0.796], abs=0.045)
    assert np.abs(G - G.transpose(2, 3, 0, 1)).max() < 1e-12


def test_beside_a_face_a_contact_is_as_small_as_it_is(monkeypatch):
    """Own compliance of a nut 32x10 held at both faces, its first ball 1.03 radii from one: 3D (free mesh twice as fine as
    level 1, 20 modes) has 1.63 um/kN less than at a middle ball, 1.80 on level 1; a patch of 0.18 radii 1.10."""
    parts = drawn(2)
    compliance = own(parts, 0)
    assert compliance[0] - compliance[15] == pytest.approx(-1.63, abs=0.12)
    monkeypatch.setattr(faces, "BESIDE_FACE", faces.BESIDE_FACE._replace(highest=16.0, mesh=(12, 8)))
    forget_kept_results("rollbench.lowfi")
    finer = own(parts, 0)
    forget_kept_results("rollbench.lowfi")
    assert compliance[0] - compliance[15] == pytest.approx(finer[0] - finer[15], abs=0.05)
