"""Kernels of finite bodies: half space by closed form, resultants, reciprocity, mirror image, large bodies, rolling."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.rolling_scenes import linear_pair

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.rolling import balls, bodies, verification
from rollbench.hifi.rolling.contact_bodies import ContactZone, Groove, mesh_half_space, mesh_whole_ball
from rollbench.hifi.rolling.patch import ComplianceKernel, create_cell_grid, displacement_by_rectangle, monomial_values
from rollbench.hifi.rolling.scenes import relative_radius_along

pytestmark = pytest.mark.xdist_group("helped by processes")

E, NU, R = 210e9, 0.28, 5e-3
ZONE = ContactZone((0.1e-3, 0.4e-3), (2, 2), 3.0)
COARSE = bodies.Sizes(cells=(2, 2), growth=3.0, degree=2)
ROUND = (0.0, 0.0)


def half_space_kernel(zone, size, degree):
    body = mesh_half_space(size, zone)
    return bodies.compliance_of_half_space_block(body, bodies.nodal_forces_of_tractions(body, zone, degree, ROUND), E, NU)


def test_a_block_with_its_cut_moved_becomes_a_half_space():
    """Constant and linear loads against rectangles in closed form: errors fall with the cells at order 1.5 or more."""
    n, half = 24, ZONE.half_lengths
    size = 2.0 * np.array(half) / n
    _, at = create_cell_grid((n, n), size)
    off = at[:, None] - at[None]
    G = 0.5 * displacement_by_rectangle(*off.transpose(2, 0, 1), *size, E, NU) / size.prod()
    # what normal forces move along tangents, and the reverse, of one body alone: by point forces, none on their own cell
    across = (1.0 - 2.0 * NU) * (1.0 + NU) / (2.0 * np.pi * E) * off / np.maximum((off**2).sum(axis=2), 1e-30)[..., None]
    G[..., 2, :2], G[..., :2, 2] = across, -across
    fit = np.linalg.pinv(monomial_values(at, half, 1))
    exact = np.einsum("ka,abij,lb->ikjl", fit, G, fit).reshape(9, 9)
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    found = [half_space_kernel(ContactZone(half, (c, c), 2.0), 4e-3, 1) for c in (2, 3, 4)]
    errors = np.array([np.abs(f - exact) / scale for f in found])
    constant = [0, 3, 6]
    assert errors[-1][constant, constant].max() < 0.02
    assert errors[-1].max() < 0.13
    diagonal = np.diagonal(errors, axis1=1, axis2=2)
    assert np.all(np.log(diagonal[:-1] / diagonal[1:]) / np.log([[1.5], [4.0 / 3.0]]) > 1.4)


def test_loads_have_the_resultants_of_their_tractions_and_a_motion_of_the_whole_ball_does_no_work_on_its_answers():
    """The constant traction's forces sum to one along its own direction, the linear ones' to nothing."""
    body = mesh_whole_ball(R, ZONE)
    sums = bodies.nodal_forces_of_tractions(body, ZONE, 1, ROUND).toarray().reshape(3, 3, -1, 3).sum(axis=2)
    assert sums == pytest.approx(np.einsum("k,dx->dkx", [1.0, 0.0, 0.0], np.eye(3)), abs=1e-9)
    curved = bodies.nodal_forces_of_tractions(body, ZONE, 1, (100.0, 90.0))
    M = bodies.compliance_of_body(body, curved, E, NU)
    assert pytest.approx(M.T, rel=1e-9, abs=1e-14 * np.abs(M).max()) == M  # reciprocity
    assert np.linalg.eigvalsh(M).min() > -1e-9 * np.abs(M).max()


@cache
def ring():
    """The nut's or outer groove of a ring of seven ball radii, its kernels as the static reference's patches and as bodies
    of tensor grids have them."""
    angle, curve = 0.8, (7.0 * R, 0.0)
    at = bodies.ContactGeometry(R, (relative_radius_along(R, curve[0], 0.0, np.cos(angle)), 46.667e-3), angle, curve)
    zone, rest = at.contact_zone(128.0, E, NU, COARSE), (at.shared_surface_curvatures, E, NU, 1)
    patches = bodies.compliance_kernels_of_patches(at, zone, E, NU, 1)
    groove = Groove(R, at.groove_radius, angle, 1.4, at.groove_curvature_along)
    grids = bodies.compliance_kernel_of_bar(groove, 5.0 * R, zone, *rest), bodies.compliance_kernel_of_ball(R, zone, *rest)
    return at, zone, patches, grids


def test_patches_of_the_static_reference_answer_as_other_meshes_of_the_same_bodies():
    """Linear tractions and motions, whose strains rolling feels, over a half space's; in all three directions."""
    _, zone, patches, grids = ring()
    whole = half_space_kernel(zone, R, 1)
    scale = np.sqrt(np.outer(whole.diagonal(), whole.diagonal()))
    mixed = [1, 2, 4, 5, 7, 8]
    for patch, body in zip(patches, grids, strict=True):
        difference = (np.abs(patch.M - body.M) / scale)[:, mixed]
        assert difference.max() < 5e-3
        assert (np.abs(body.M) / scale)[:, mixed].max() > 2e-2


def test_without_motion_rolling_presses_as_the_static_reference_does():
    """The static reference on four cells, which leaves it a tenth of the peak; finer ones are in the verification table."""
    at = ring()[0]
    here = verification.solve_normal_contact_by_rolling_model(at, 100.0, E, NU, (16, 20), COARSE)
    there = verification.solve_normal_contact_by_patches(at, 100.0, E, NU, (4, 4))
    assert here.approach == pytest.approx(there.approach, rel=5e-3)
    assert here.semi_axes == pytest.approx(there.semi_axes, rel=0.04)
    assert here.peak_pressure == pytest.approx(there.peak_pressure, rel=0.12)
    bare = solve_hertz(100.0, *at.relative_radii, E, NU)
    assert abs(bare.approach / there.approach - 1.0) > 0.015  # half spaces
    with pytest.raises(ValueError, match="straight track"):
        verification.solve_normal_contact_by_patches(replace(at, path_radius_and_rise=None), 100.0, E, NU, (4, 4))


def test_finite_balls_pushed_sideways_shift_by_what_their_bodies_do_besides(monkeypatch):
    """Cattaneo and Mindlin on two finite balls: at the half spaces' shift and the bodies' own, the same force."""
    found, exact = verification.compare_with_mindlin(16, 0.5, finite_balls=COARSE)
    assert found[0] == pytest.approx(exact[0], rel=5e-3)
    assert found[1] == pytest.approx(exact[1], rel=0.05)
    half = verification.compare_with_mindlin(16, 0.5)[0][0]
    monkeypatch.setattr(verification, "kernel_of_two_balls", lambda *_: ComplianceKernel(np.zeros((3, 3)), (1.0, 1.0), 0))
    assert verification.compare_with_mindlin(16, 0.5, finite_balls=COARSE)[0][0] == pytest.approx(half, rel=1e-9)
    assert found[0] != pytest.approx(half, rel=1e-5)


def test_the_contact_of_two_balls_is_a_point_to_them():
    """But not if they were soft and one spun on the other."""
    scene = linear_pair()
    found = balls.solve_rolling(scene, balls.RollingSettings((8, 8)))
    assert verification.compare_ball_friction_with_point(scene, found, 0) == pytest.approx((1.0, 1.0), abs=1e-5)
    # over the balls' own patch, half an approach inside their surfaces
    force, loss = verification.compare_ball_friction_with_point(scene, found, 0, 8, COARSE)
    assert force == pytest.approx(1.0, abs=1e-9)
    half = 0.5 * scene.ball_radius
    circle = solve_hertz(float(found.ball_to_ball_forces[0]), half, half, scene.young, scene.poisson)
    assert 1.0 - loss == pytest.approx(0.5 * circle.approach / scene.ball_radius, rel=0.05)
    motions = found.friction_solution.motions.copy()
    motions[3] += 5.0 * np.abs(motions).max()
    spun = replace(found, friction_solution=replace(found.friction_solution, motions=motions))
    force, loss = verification.compare_ball_friction_with_point(replace(scene, young=1e-5 * scene.young), spun, 0)
    assert force < 0.9 < 1.1 < loss


def test_rolling_on_finite_bodies_balances_and_loses_what_is_put_in():
    """Mated grooves have no force by symmetry; a groove whose bottom is unknown is refused."""
    scene = linear_pair()

    def solved(scene, *elastic, on=COARSE, cells=(10, 12)):
        return balls.solve_rolling(scene, balls.RollingSettings(cells, *elastic, finite_bodies=on))

    half, finite = solved(scene, on=None), solved(scene)
    assert finite.converged
    assert finite.driving_power == pytest.approx(finite.friction_loss + finite.numerical_dissipation, rel=1e-9)
    assert finite.ball_to_ball_forces[0] == pytest.approx(half.ball_to_ball_forces[0], rel=0.03)
    assert finite.ball_to_ball_forces[0] != pytest.approx(half.ball_to_ball_forces[0], rel=1e-5)
    rigid_half, rigid = solved(scene, balls.NEARLY_RIGID, on=None), solved(scene, balls.NEARLY_RIGID)
    elastic_change = finite.track_speeds[0] / half.track_speeds[0] - 1.0
    assert abs(rigid.track_speeds[0] / rigid_half.track_speeds[0] - 1.0) < abs(elastic_change) + 1e-4
    assert solved(linear_pair(mated=True)).ball_to_ball_forces[0] < 1e-9
    first, second = scene.balls
    unknown = tuple(replace(t, direction_to_groove_bottom=None) for t in first.groove_contacts)
    with pytest.raises(ValueError, match="bottom"):
        solved(replace(scene, balls=(replace(first, groove_contacts=unknown), second)), cells=(6, 6))


def test_steps_from_rest_stay_within_the_zone_of_finite_bodies():
    """Short steps give the force and losses of half spaces but for what bodies do; long ones are refused."""
    scene, finite = linear_pair(), balls.RollingSettings((6, 6), finite_bodies=COARSE)
    short, half = (balls.compute_motion_from_rest(scene, 2e-4, 2, 0.0, c) for c in (finite, balls.RollingSettings((6, 6))))
    assert short.converged
    assert short.losses == pytest.approx(half.losses, rel=0.03)
    assert short.losses != pytest.approx(half.losses, rel=1e-5)
    with pytest.raises(ValueError, match="outside the zone"):
        balls.compute_motion_from_rest(scene, 0.1, 10, 0.0, finite)
