"""Patches of one side: right flanks turned from left ones, their own compliance."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from hifi import sides
from hifi.part_meshes import mesh_parts
from hifi.pressures import mean_weights
from hifi.sides import condense_side, congruent, turned
from meshes.groove_map import GrooveMap
from meshes.helix import ball_layout
from meshes.sockets import AZIMUTH_TURNED
from meshes.solid import dimensions
from tests.helpers import relative
from tests.unit.hifi.test_reference_small import SMALL, two_balls

pytestmark = pytest.mark.xdist_group("both flanks")

SETTINGS = replace(SMALL, modes=8, ball_modes=12)


@pytest.fixture(scope="module")
def flanks():
    """Left and right flank of screw and nut, each condensed by itself."""
    scene = two_balls()
    m, layout, dims = GrooveMap.of(scene), ball_layout(scene), dimensions(scene)
    meshes = mesh_parts(scene, m, layout, dims, (0, 1, 2, 3), SETTINGS)
    found = {s: condense_side(scene, m, dims, meshes, s, SETTINGS) for s in range(4)}
    return m, meshes, found


@pytest.mark.parametrize("right", [1, 3])
def test_a_right_flank_is_the_left_one_turned(flanks, right):
    """Condensed by themselves both give the same matrices, points, normals and weights; own compliances as nearly as
    unstructured meshes of left and right submodels do."""
    m, meshes, found = flanks
    assert congruent(m, right)
    assert not congruent(m, right - 1)
    made, direct = turned(found[right - 1]), found[right]
    body = meshes.screw if right < 2 else meshes.nut
    np.testing.assert_array_equal(body.sockets[right].xi, body.sockets[right - 1].xi * AZIMUTH_TURNED)
    for part in ("groove", "ball"):
        a, b = getattr(made, part), getattr(direct, part)
        for name in ("A", "H", "S", "normals", "areas"):
            assert relative(getattr(a, name), getattr(b, name)) < 1e-8, (part, name)
        np.testing.assert_allclose(a.points, b.points, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(a.rim, b.rim)
        assert a.shape == b.shape
        assert sp.linalg.norm(a.weights - b.weights) < 1e-9 * sp.linalg.norm(b.weights)
    assert relative(made.own, direct.own) < 5e-3
    assert relative(found[right - 1].own, direct.own) > 1e-2  # not turned, nodes stand for others


def test_turning_twice_changes_nothing(flanks):
    _, _, found = flanks
    back = turned(turned(found[0]))
    np.testing.assert_array_equal(back.own, found[0].own)
    np.testing.assert_array_equal(back.groove.H, found[0].groove.H)
    np.testing.assert_array_equal(back.ball.S, found[0].ball.S)


def test_other_radii_are_not_congruent(flanks):
    m, _, _ = flanks
    assert not congruent(replace(m, radius=m.radius * np.array([1.0, 1.01, 1.0, 1.0])), 1)


@pytest.mark.parametrize("side", [0, 3])
def test_own_compliance_is_that_of_the_patches_and_what_the_modes_do_not_carry(flanks, side):
    """Symmetric, positive definite. Under one force on all hats it is softer than both condensed patches with their sockets
    held, as modes left out and cells of the submodels add yielding, but far from the whole contact's."""
    _, _, found = flanks
    pair = found[side]
    np.testing.assert_array_equal(pair.own, pair.own.T)
    assert np.linalg.eigvalsh(pair.own).min() > 0.0
    held = pair.groove.A + pair.ball.A
    force = mean_weights(pair.groove.weights).T @ pair.groove.areas
    assert 1.0 < (force @ pair.own @ force) / (force @ held @ force) < 1.5


def test_source_s_mesh_keeps_its_patches(monkeypatch):
    """First-order tetrahedra stand for the source's mesh: no submodel, A of both patches as they are."""
    monkeypatch.setattr(sides, "fine_compliance", None)
    scene = two_balls()
    settings = replace(SETTINGS, element="P1", tet=0.16e-3)
    m, layout, dims = GrooveMap.of(scene), ball_layout(scene), dimensions(scene)
    meshes = mesh_parts(scene, m, layout, dims, (0, 3), settings)
    pair = condense_side(scene, m, dims, meshes, 0, settings)
    np.testing.assert_array_equal(pair.own, pair.groove.A + pair.ball.A)
