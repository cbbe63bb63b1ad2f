"""Balls in steady rolling in 3D: balance, energy, symmetry, frames, the rigid limit and its low-order model."""

from dataclasses import replace

import numpy as np
import pytest
from tests.rolling_scenes import linear_pair, screw_pair

from rollbench.hifi.rolling import balls as rolling
from rollbench.hifi.rolling.kinematics import TrackMotion, ball_to_ball_contact
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import solve_pair_of_linear_balls

COARSE = rolling.RollingSettings(grid_shape=(10, 12))
SCENES = {"linear": linear_pair(), "screw": screw_pair()}


@pytest.mark.parametrize("name", list(SCENES))
def test_forces_and_moments_balance_and_power_is_lost(name):
    scene = SCENES[name]
    found = rolling.solve_rolling(scene, COARSE)
    assert found.converged
    assert found.driving_power == pytest.approx(found.friction_loss + found.numerical_dissipation, rel=1e-9)
    assert found.numerical_dissipation < 0.002 * found.driving_power
    pair = scene.ball_to_ball_contacts[0]
    forward, turning = (x / scene.track.centre_speed for x in (scene.track.centre_velocity, scene.track.rotation_axis))
    for ball, sign in ((pair.first_ball, 1.0), (pair.second_ball, -1.0)):
        wrench, pushed = found.groove_friction_wrenches[ball], found.forces_by_neighbours[ball]
        moment = wrench[3:] + np.cross(sign * scene.ball_radius * (scene.balls[ball].axes @ pair.axes[0]), pushed)
        assert np.abs(moment).max() < 1e-9 * scene.ball_radius
        assert abs((wrench[:3] + pushed) @ forward + moment @ turning) < 1e-9
    assert found.ball_to_ball_forces[0] > 0.0
    closing = pair.closing_and_sliding_speeds(found.friction_solution.motions)[0]
    assert abs(closing) < 1e-12


def test_mated_grooves_keep_the_balls_apart_without_force_and_balls_that_part_do_not_touch():
    """Case (b) of Lin 3.3.4: opposite contacts stay opposite; zero by symmetry, to round-off."""
    scene = linear_pair(mated=True)
    free = rolling.solve_rolling(replace(scene, ball_to_ball_contacts=()), COARSE)
    assert abs(free.track_speeds[0] - free.track_speeds[1]) < 1e-12 * free.track_speeds[0]
    assert rolling.solve_rolling(scene, COARSE).ball_to_ball_forces[0] < 1e-9
    parting = rolling.solve_rolling(linear_pair(rho=0.6), COARSE)
    assert parting.ball_to_ball_forces[0] == 0.0
    assert parting.track_speeds[0] < parting.track_speeds[1]


def test_mirrored_pair_has_the_same_force_and_speed_sets_the_scale_of_motion_only():
    """Side forces and angle deviations the other way round: the section's mirror image."""
    scenes = linear_pair(), linear_pair(-2.0, 0.6), linear_pair(speed=1.0)
    one, mirror, fast = (rolling.solve_rolling(scene, COARSE) for scene in scenes)
    for other in (mirror, fast):
        assert other.ball_to_ball_forces[0] == pytest.approx(one.ball_to_ball_forces[0], rel=1e-9)
    assert mirror.friction_loss == pytest.approx(one.friction_loss, rel=1e-9)
    assert fast.track_speeds == pytest.approx(100.0 * one.track_speeds, rel=1e-9)


def with_contacts(scene, change):
    """The scene with each contact as ``change`` makes it of the contacts of its ball and its place among them."""
    balls = []
    for ball in scene.balls:
        contacts = ball.groove_contacts
        balls.append(replace(ball, groove_contacts=tuple(change(contacts, k) for k in range(len(contacts)))))
    return replace(scene, balls=tuple(balls))


def test_turned_frame_changes_nothing():
    scene = linear_pair()
    turn = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-1.0, 0.3, 2.0], [0.4, 1.0, -2.0]]))[0]
    turn *= np.sign(np.linalg.det(turn))
    track = TrackMotion(turn @ scene.track.rotation_axis, turn @ scene.track.centre_velocity)
    line = turn @ np.array([0.0, 0.0, 1.0])
    between = ball_to_ball_contact(0, 1, (np.eye(3), np.eye(3)), line, track, scene.ball_radius)
    turned = with_contacts(scene, lambda of, k: replace(of[k], contact_normal=turn @ of[k].contact_normal))
    turned = replace(turned, track=track, ball_to_ball_contacts=(between,))
    one, two = rolling.solve_rolling(scene, COARSE), rolling.solve_rolling(turned, COARSE)
    assert two.ball_to_ball_forces[0] == pytest.approx(one.ball_to_ball_forces[0], rel=1e-9)
    assert two.rotations @ turn == pytest.approx(one.rotations, rel=1e-7, abs=1e-9)


def test_left_hand_screw_is_the_mirror_image():
    # mirrored, the second ball is still ahead in the sense of growing azimuth
    other = with_contacts(screw_pair(lead=-20e-3), lambda of, k: replace(of[k], contact_force=of[k ^ 1].contact_force))
    found, mirror = rolling.solve_rolling(screw_pair(), COARSE), rolling.solve_rolling(other, COARSE)
    assert mirror.ball_to_ball_forces[0] == pytest.approx(found.ball_to_ball_forces[0], rel=1e-6)
    assert mirror.friction_loss == pytest.approx(found.friction_loss, rel=1e-6)


def test_rigid_limit_is_the_low_order_model():
    """Rigid bodies on flat contacts: the low-order model's numbers at the same loads; grids of nearly rigid ones get
    there."""
    bearing = LinearBearing(5e-3, 0.56, 0.25 * np.pi, 0.01, 0.1, 0.1, 210e9, 0.28)
    low = solve_pair_of_linear_balls(bearing, np.deg2rad(2.0), -0.6, 100.0)
    limit = rolling.solve_rigid_rolling(linear_pair(), curved=False)
    assert limit.smoothing_error < 1e-5
    assert limit.ball_to_ball_forces[0] == pytest.approx(low.ball_to_ball_force, rel=3e-4)
    assert limit.friction_loss == pytest.approx(low.touching.loss, rel=1e-4)
    assert limit.track_speeds == pytest.approx(low.touching.q[:, 0], rel=1e-5)
    found = rolling.solve_rolling(linear_pair(), rolling.RollingSettings((16, 24), 0.01, curved_contacts=False))
    assert found.ball_to_ball_forces[0] == pytest.approx(limit.ball_to_ball_forces[0], rel=0.03)
    assert found.friction_loss == pytest.approx(limit.friction_loss, rel=0.01)


def test_a_ball_without_contacts_is_refused():
    scene = linear_pair()
    bare = with_contacts(scene, lambda of, k: replace(of[k], contact_force=0.0)).balls[0]
    with pytest.raises(ValueError, match="loaded contact"):
        rolling.solve_rolling(replace(scene, balls=(bare, scene.balls[1])), COARSE)
