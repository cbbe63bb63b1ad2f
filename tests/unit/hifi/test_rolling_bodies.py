"""Kernels of finite bodies: half space by closed form, resultants, reciprocity, mirror image, large bodies, rolling."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hifi.rolling.balls import NEARLY_RIGID, Choices, solve_rolling
from hifi.rolling.bodies import Sizes, ball_kernel, bar_kernel, contact_kernel, free_answer, half_space_kernel, tractions
from hifi.rolling.elements import Solids, influence
from hifi.rolling.patch import grid, hertz_patch, seen_radii
from hifi.rolling.regular import NORMAL, TANGENTS, Regular, exponents, monomials
from meshes.contact_bodies import Groove, Zone, grooved_bar, whole_ball
from meshes.fem import points_of
from tests.rolling_scenes import linear_pair

pytestmark = pytest.mark.xdist_group("rolling bodies")

E, NU, R = 210e9, 0.28, 5e-3
RADII = (R, 46.667e-3)
ZONE = Zone((0.1e-3, 0.4e-3), (2, 2), 3.0)
COARSE = Sizes(cells=(2, 2), growth=3.0, degree=2)
ROUND = (0.0, 0.0)


@cache
def kernel():
    return contact_kernel(R, RADII, 0.25 * np.pi, 100.0, E, NU, COARSE)


def part(M, rows, columns):
    """Block of directions, constant and linear loads and motions."""
    k = len(M) // 3
    return M.reshape(3, k, 3, k)[rows, :3, columns, :3]


def test_a_block_with_its_cut_moved_becomes_a_half_space():
    """Constant and linear loads against rectangles in closed form: errors fall with the cells at order 1.5 or more."""
    n, half = 24, ZONE.half
    size = 2.0 * np.array(half) / n
    _, at = grid((n, n), size)
    shear = 0.5 * E / (1.0 + NU)
    alone = Solids((shear, 1e12 * shear), (NU, NU))
    G = influence(*(at[:, None] - at[None]).transpose(2, 0, 1), *size, alone) / size.prod()
    fit = np.linalg.pinv(monomials(at, half, 1))
    exact = np.einsum("ka,abij,lb->ikjl", fit, G, fit).reshape(9, 9)
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    found = [half_space_kernel(Zone(half, (c, c), 2.0), 8e-3, E, NU, 1) for c in (2, 4)]
    errors = np.array([np.abs(f - exact) / scale for f in found])
    constant = [0, 3, 6]
    assert errors[1][constant, constant].max() < 0.02
    assert errors[1].max() < 0.13
    assert np.all(np.log2(np.diagonal(errors[0]) / np.diagonal(errors[1])) > 1.4)


def test_loads_have_the_resultants_of_their_tractions():
    """The constant traction's forces sum to one along its own direction, the linear ones' to nothing."""
    body = whole_ball(R, ZONE)
    rows = tractions(body, ZONE, 1, ROUND).toarray().reshape(3, 3, -1, 3)
    sums = rows.sum(axis=2)
    assert sums == pytest.approx(np.einsum("k,dx->dkx", [1.0, 0.0, 0.0], np.eye(3)), abs=1e-9)


def test_a_motion_of_the_whole_ball_does_no_work_on_its_answers():
    body = whole_ball(R, ZONE)
    rows = tractions(body, ZONE, 1, (100.0, 90.0))
    M = free_answer(body, rows, E, NU)
    assert pytest.approx(M.T, rel=1e-9, abs=1e-14 * np.abs(M).max()) == M  # reciprocity
    assert np.linalg.eigvalsh(M).min() > -1e-9 * np.abs(M).max()


def test_kernels_are_mirror_images_in_x():
    """Neither body knows the sense in which it rolls."""
    k = kernel()
    odd = (-1.0) ** exponents(k.degree)[:, 0]
    signs = np.concatenate([-odd, odd, odd])
    assert np.abs(k.M - k.M * np.outer(signs, signs)).max() < 1e-6 * np.abs(k.M).max()
    other = k.mirrored
    assert np.abs(other.mirrored.M - k.M).max() == 0.0
    assert np.abs(other.M - k.M).max() > 1e-4 * np.abs(k.M).max()  # the groove's bottom lies on one side


def test_large_bodies_are_half_spaces():
    """Ball and bar of four times the size: what they add to the approach falls as one over their size, along
    tangents as that times its logarithm."""
    whole = half_space_kernel(ZONE, R, E, NU, 1).diagonal()[[0, 3, 6]]
    added = []
    for factor in (1.0, 4.0):
        ball = ball_kernel(factor * R, ZONE, ROUND, E, NU, 1)
        bar = bar_kernel(Groove(factor * R, factor * 1.12 * R, 0.8, 1.4, 0.0), 5.0 * factor * R, ZONE, ROUND, E, NU, 1)
        added.append([np.abs(x.M.diagonal()[[0, 3, 6]]) / whole for x in (ball, bar)])
    first, last = np.array(added)
    assert first.max() < 0.1
    order = np.log(first / last) / np.log(4.0)
    assert np.all(order[:, 2] > 0.8)
    assert np.all(order > 0.5)


def test_a_bent_bar_is_a_ring():
    """Curvature of its surface along the track at the contact, concave and convex."""
    for bend in (20.0, -20.0):
        body = grooved_bar(Groove(R, 1.12 * R, 0.8, 1.4, bend), 2.0 * R, ZONE)
        p = points_of(body.mesh)[body.contact]
        x, z = p[np.abs(p[:, 1]) < 1e-9][:, [0, 2]].T
        assert z == pytest.approx(-0.5 * bend * x**2, rel=1e-3, abs=1e-12)


def test_zones_and_bars_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="does not fit"):
        whole_ball(R, Zone((4e-3, 4e-3), (2, 2), 3.0))
    with pytest.raises(ValueError, match="thicker than its ring"):
        grooved_bar(Groove(R, 1.12 * R, 0.8, 1.4, -100.0), 8.0 * R, ZONE)


def test_kernels_of_other_monomials_do_not_add():
    with pytest.raises(ValueError, match="same monomials"):
        Regular(np.zeros((3, 3)), (1.0, 1.0), 0) + Regular(np.zeros((9, 9)), (1.0, 1.0), 1)


def test_slope_is_the_derivative():
    at = np.array([[1e-5, 2e-4], [-4e-5, -1e-4]])
    step = 1e-8
    near = [kernel().block(at, TANGENTS, NORMAL, s) for s in (step, -step)]
    assert (near[0] - near[1]) / (2.0 * step) == pytest.approx(kernel().slope(at, TANGENTS, NORMAL), rel=1e-6, abs=1e-12)


def test_pressure_of_finite_bodies_is_that_of_the_half_spaces_they_are_seen_as():
    seen = seen_radii(100.0, RADII, E, NU, kernel())
    assert seen != RADII
    assert seen == pytest.approx(RADII, rel=0.02)
    one, two = hertz_patch(100.0, RADII, E, NU, (12, 12), kernel()), hertz_patch(100.0, seen, E, NU, (12, 12))
    assert len(one.at) == len(two.at)
    assert one.normal == pytest.approx(two.normal, rel=0.01, abs=0.01 * two.normal.max())
    assert one.approach != pytest.approx(two.approach, rel=1e-3)
    with pytest.raises(ValueError, match="not similar"):
        one.scaled(2.0, 8.0)


def test_rolling_on_finite_bodies_balances_and_loses_what_is_put_in():
    scene = linear_pair()
    half, finite = (solve_rolling(scene, Choices((10, 12), bodies=b)) for b in (None, COARSE))
    assert finite.converged
    assert finite.power == pytest.approx(finite.loss + finite.upwind, rel=1e-9)
    assert finite.force[0] == pytest.approx(half.force[0], rel=0.03)
    assert finite.force[0] != pytest.approx(half.force[0], rel=1e-5)
    rigid = [solve_rolling(scene, Choices((10, 12), NEARLY_RIGID, bodies=b)) for b in (None, COARSE)]
    assert abs(rigid[1].speed[0] / rigid[0].speed[0] - 1.0) < abs(finite.speed[0] / half.speed[0] - 1.0) + 1e-4


def test_mated_grooves_on_finite_bodies_have_no_force_by_symmetry():
    found = solve_rolling(linear_pair(mated=True), Choices((10, 12), bodies=COARSE))
    assert found.force[0] < 1e-9


def test_a_groove_whose_bottom_is_unknown_is_refused():
    scene = linear_pair()
    bare = replace(scene.balls[0], touches=tuple(replace(t, bottom=None) for t in scene.balls[0].touches))
    with pytest.raises(ValueError, match="bottom"):
        solve_rolling(replace(scene, balls=(bare, scene.balls[1])), Choices((6, 6), bodies=COARSE))
