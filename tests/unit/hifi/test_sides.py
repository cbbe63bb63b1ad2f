"""Patches of one side: right flanks turned from left ones, their own compliance."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse as sp
from tests.helpers import relative
from tests.two_balls import SMALL, two_balls

from rollbench.hifi import condensation
from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.bodies.coarse import contact_modes_of_patch
from rollbench.hifi.bodies.patch import condense_patch
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.meshing.part_meshes import contact_normals_of_patch, mesh_parts, mesh_patch
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.sockets import AZIMUTH_TURNED, points_in_box_at_azimuth_zero
from rollbench.meshes.solid import dimensions_of_3d_parts

pytestmark = pytest.mark.xdist_group("both flanks")

SETTINGS = replace(SMALL, modes=8, ball_modes=12)


@pytest.fixture(scope="module")
def flanks(_one_submodel):
    """Left and right flank of screw and nut, each condensed by itself."""
    return condensed((0, 1, 2, 3), SETTINGS)


def condensed(wanted, settings):
    """Map and meshes of the two balls, and the condensed sides: all four, or the first of those that are wanted."""
    scene = two_balls()
    m, layout, dims = GrooveMap.from_scene(scene), ball_layout(scene), dimensions_of_3d_parts(scene)
    meshes = mesh_parts(scene, m, layout, dims, wanted, settings)
    pick = wanted if len(wanted) == 4 else wanted[:1]
    return (
        m,
        meshes,
        {
            s: condensation.condense_patches_of_flank(
                *condensation.collect_flank_condensation_arguments(scene, m, dims, meshes, s, settings)
            )
            for s in pick
        },
    )


@pytest.mark.parametrize("right", [1, 3])
def test_a_right_flank_is_the_left_one_turned(flanks, right):
    """Condensed by themselves both give the same matrices, points, normals and weights; own compliances as nearly as
    unstructured meshes of left and right submodels do."""
    m, meshes, found = flanks
    assert condensation.is_left_flank_after_half_turn(m, right)
    assert not condensation.is_left_flank_after_half_turn(m, right - 1)
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


def test_turning_twice_changes_nothing_and_other_radii_are_not_congruent(flanks):
    m, _, found = flanks
    back = condensation.turn_patches_to_right_flank(condensation.turn_patches_to_right_flank(found[0]))
    np.testing.assert_array_equal(back.local_compliance, found[0].local_compliance)
    np.testing.assert_array_equal(back.groove_patch.H, found[0].groove_patch.H)
    np.testing.assert_array_equal(back.ball_patch.S, found[0].ball_patch.S)
    np.testing.assert_array_equal(back.ball_patch.socket_points, found[0].ball_patch.socket_points)
    assert not condensation.is_left_flank_after_half_turn(replace(m, radius=m.radius * np.array([1.0, 1.01, 1.0, 1.0])), 1)


@pytest.mark.parametrize("part", ["groove_patch", "ball_patch"])
@pytest.mark.parametrize("count", [3, 8])
def test_few_modes_keep_the_resultants_of_all_contact_forces(flanks, part, count):
    """Whatever single hats carry: what reaches the socket's nodes through the modes is in equilibrium with it, to
    round-off. Contact forces point at the ball's centre: three modes are enough."""
    m, _, found = flanks
    patch = getattr(found[2], part)
    V, rows = contact_modes_of_patch(patch, count)
    assert V.shape[1] == count
    centre = np.array([m.R, 0.0, 0.0]) if part == "groove_patch" else np.zeros(3)
    hats = normalise_weight_rows(patch.pressure_weights)
    reached = (V @ rows).reshape(len(V), -1, 3)
    assert np.abs(reached.sum(axis=1) - hats @ patch.normals).max() < 1e-12
    moments = np.cross(patch.socket_points - centre, reached).sum(axis=1)
    assert np.abs(moments).max() < 1e-12 * m.ball


@pytest.mark.parametrize("side", [0, 3])
def test_own_compliance_is_that_of_the_patches_and_what_the_modes_do_not_carry(flanks, side):
    """Symmetric, positive definite. Under one force on all hats it is softer than both condensed patches with their sockets
    held, as modes left out and cells of the submodels add yielding, but far from the whole contact's."""
    _, _, found = flanks
    pair = found[side]
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
    mesh = mesh_patch(
        meshes,
        body.box_faces[side],
        partial(points_in_box_at_azimuth_zero, m, meshes.socket_size, side),
        replace(SETTINGS, b_over_h=1.8),
    )
    normals = contact_normals_of_patch(mesh, np.array([m.R, 0.0, 0.0]))
    groove = condense_patch(mesh, normals, 0.5 * steel.youngs_modulus, steel.poissons_ratio)
    wave = grid_wave.tabulate_gap_corrections(m, side, groove, groove.A, steel)
    loads = grid_wave.forces_resolved_by_grid(m, side, groove, steel, 5)[1:]
    trend = grid_wave.approaches_over_grid_cell(m, side, groove, groove.A, loads, (2, 2))[1]
    places = np.random.default_rng(4).uniform(-0.5, 0.5, (20, 2))
    approach = np.array(
        [grid_wave.approaches_at_grid_position(m, side, groove, groove.A, loads, tuple(x))[0] - x @ trend for x in places]
    )
    centres = wave.middle_node + (places * wave.cell_sizes) @ wave.grid_directions
    taken = np.array([wave.interpolate(np.full(len(places), load), centres) for load in loads]).T
    before, after = ((x / approach.mean(axis=0)).std(axis=0) for x in (approach, approach + taken))
    assert np.linalg.norm(after) < 0.35 * np.linalg.norm(before)
    right = condensation.turn_patches_to_right_flank(replace(found[side], gap_correction=wave)).gap_correction
    assert right.interpolate(np.full(len(places), loads[0]), centres * [1.0, -1.0, -1.0]) == pytest.approx(
        taken[:, 0], rel=1e-9
    )
