"""Patches of one side: right flanks turned from left ones, their own compliance, the grid's wave; what condensed bodies
know of each contact's own approach: contacts by active sets, the fitted law, and the law of the force that takes the place
of an approach that waves."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from tests.helpers import relative
from tests.two_balls import SMALL, relative_deviation_of_fit, two_balls

from rollbench.hifi import condensation
from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.bodies.patch import condense_patch
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.meshing.part_meshes import contact_normals_of_patch, mesh_parts, mesh_patch
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.sockets import AZIMUTH_TURNED, points_in_box_at_azimuth_zero
from rollbench.meshes.solid import dimensions_of_3d_parts

pytestmark = [pytest.mark.xdist_group("both flanks"), pytest.mark.slow]

SETTINGS = replace(SMALL, modes=8, ball_modes=12)


@pytest.fixture(scope="module")
def flanks(_one_submodel):
    """Map and meshes of the two balls; left and right flank of screw and nut, each condensed by itself."""
    scene = two_balls()
    m, layout, dims = GrooveMap.from_scene(scene), ball_layout(scene), dimensions_of_3d_parts(scene)
    meshes = mesh_parts(scene, m, layout, dims, (0, 1, 2, 3), SETTINGS)
    given = [condensation.collect_flank_condensation_arguments(scene, m, dims, meshes, s, SETTINGS) for s in range(4)]
    return m, meshes, [condensation.condense_patches_of_flank(*arguments) for arguments in given]


@pytest.mark.parametrize("right", [1, 3])
def test_a_right_flank_is_the_left_one_turned(flanks, right):
    """Condensed by themselves both give the same matrices, points, normals and weights; own compliances as nearly as
    unstructured meshes of left and right submodels do."""
    m, meshes, found = flanks
    assert condensation.is_left_flank_after_half_turn(m, right)
    assert not condensation.is_left_flank_after_half_turn(m, right - 1)
    wider = replace(m, radius=np.where(np.arange(4) == right, 1.01, 1.0) * m.radius)
    assert not condensation.is_left_flank_after_half_turn(wider, right)
    mirrored, direct = condensation.turn_patches_to_right_flank(found[right - 1]), found[right]
    body = meshes.screw_mesh if right < 2 else meshes.nut_mesh
    np.testing.assert_array_equal(body.box_faces[right].xi, body.box_faces[right - 1].xi * AZIMUTH_TURNED)
    for part in ("groove_patch", "ball_patch"):
        a, b = getattr(mirrored, part), getattr(direct, part)
        for name in ("A", "H", "S", "normals", "nodal_areas"):
            assert relative(getattr(a, name), getattr(b, name)) < 1e-8, (part, name)
        np.testing.assert_allclose(a.contact_points, b.contact_points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(a.socket_points, b.socket_points, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(a.on_zone_edge, b.on_zone_edge)
        assert a.contact_grid_shape == b.contact_grid_shape
        assert sp.linalg.norm(a.pressure_weights - b.pressure_weights) < 1e-9 * sp.linalg.norm(b.pressure_weights)
    assert relative(mirrored.local_compliance, direct.local_compliance) < 5e-3
    assert relative(found[right - 1].local_compliance, direct.local_compliance) > 1e-2  # not turned, nodes stand for others


@pytest.mark.parametrize("side", [0, 3])
def test_own_compliance_is_that_of_the_patches_and_what_the_modes_do_not_carry(flanks, side):
    """Symmetric, positive definite. Under one force on all hats it is softer than both condensed patches with their sockets
    held, as modes left out and cells of the submodels add yielding, but far from the whole contact's."""
    pair = flanks[2][side]
    np.testing.assert_array_equal(pair.local_compliance, pair.local_compliance.T)
    assert np.linalg.eigvalsh(pair.local_compliance).min() > 0.0
    held = pair.groove_patch.A + pair.ball_patch.A
    force = normalise_weight_rows(pair.groove_patch.pressure_weights).T @ pair.groove_patch.nodal_areas
    assert 1.0 < (force @ pair.local_compliance @ force) / (force @ held @ force) < 1.5


@pytest.mark.parametrize("side", [0, 2])
def test_the_wave_of_a_grid_is_taken_out_across_and_along(flanks, side):
    """Approaches of one contact at places all over a cell, under several forces: what is left of their scatter, beside what
    changes evenly from cell to cell, is a third. The right flank's wave is the left one's, turned."""
    m, meshes, found = flanks
    body, steel = meshes.screw_mesh if side < 2 else meshes.nut_mesh, two_balls().balls.material
    place = partial(points_in_box_at_azimuth_zero, m, meshes.socket_size, side)
    mesh = mesh_patch(meshes, body.box_faces[side], place, replace(SETTINGS, b_over_h=1.8))
    normals = contact_normals_of_patch(mesh, np.array([m.R, 0.0, 0.0]))
    groove = condense_patch(mesh, normals, 0.5 * steel.youngs_modulus, steel.poissons_ratio)
    wave = grid_wave.tabulate_gap_corrections(m, side, groove, groove.A, steel)
    loads = grid_wave.forces_resolved_by_grid(m, side, groove, steel, 5)[1:]
    trend = grid_wave.approaches_over_grid_cell(m, side, groove, groove.A, loads, (2, 2))[1]
    places = np.random.default_rng(4).uniform(-0.5, 0.5, (20, 2))
    given = m, side, groove, groove.A, loads
    approach = np.array([grid_wave.approaches_at_grid_position(*given, tuple(x))[0] - x @ trend for x in places])
    centres = wave.middle_node + (places * wave.cell_sizes) @ wave.grid_directions
    taken = np.array([wave.interpolate(np.full(len(places), load), centres) for load in loads]).T
    before, after = ((x / approach.mean(axis=0)).std(axis=0) for x in (approach, approach + taken))
    assert np.linalg.norm(after) < 0.35 * np.linalg.norm(before)
    right = condensation.turn_patches_to_right_flank(replace(found[side], gap_correction=wave)).gap_correction
    turned = right.interpolate(np.full(len(places), loads[0]), centres * [1.0, -1.0, -1.0])
    assert turned == pytest.approx(taken[:, 0], rel=1e-9)


FORCES = np.geomspace(40.0, 600.0, 16)
C = 1.4e-7


def bodies(local):
    """Two sides of a ring whose own approaches are given."""
    given = np.array(local), np.tile(FORCES, (len(local), 1)), np.array([C, 2.0 * C])
    return CondensedBodies("none", 1, np.array([0.0, 3.0]), 0.0, np.eye(2), np.eye(2), np.eye(len(local)), *given)


def test_the_law_of_a_side_is_found_again_whatever_the_force_and_scatter_is_a_share_of_the_approach():
    law = [(-2e-9, 9e-12), (1e-10, -3e-11)]
    found = bodies([e + h * np.cbrt(FORCES) for e, h in law])
    for side, expected in zip((0, 3), law, strict=True):
        assert found.fit_local_approach_over_load(side) == pytest.approx(expected, rel=1e-9)
        assert relative_deviation_of_fit(found, side) < 1e-12
    wave = 0.002 * np.where(np.arange(FORCES.size) % 2, 1.0, -1.0) * C * np.cbrt(1.0 / FORCES)
    found = bodies([-2e-9 + wave, -2e-9 + wave])
    deviations = [relative_deviation_of_fit(found, side) for side in (0, 3)]
    assert deviations == pytest.approx([0.002, 0.001], rel=0.05)  # the second side's approach is twice as large
    e, h = found.fit_local_approach_over_load(0)
    assert np.abs(e + h * np.cbrt(FORCES) + 2e-9).max() < 0.5 * np.abs(wave).max()
