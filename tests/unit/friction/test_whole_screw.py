"""Friction of whole screws and bearings at their static loads: exact balances, symmetries, orbits, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw, solved
from tests.whole_screws import AXIAL, MU, SCENES, TURN, state, two_starts

from rollbench.lowfi.friction.whole.contacts import contacts_of_result
from rollbench.lowfi.friction.whole.losses import BallsUnderLoad, ball_friction, ball_kinematics
from rollbench.meshes.parts import Friction, Motion


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("motion", [TURN, Motion(-3.0, "nut")], ids=["screw", "nut"])
@pytest.mark.parametrize("mu", [(0.1, 0.1), (0.05, 0.15), (0.2, 0.01)], ids=str)
def test_power_in_is_dissipation(name, mu, motion):
    scene = SCENES[name]()
    found = state(scene, Friction(*mu, feedback=False), motion)
    t = found.friction_sums
    assert found.ball_friction.converged
    assert t.power > 0.0
    assert t.axial_load == pytest.approx(scene.loads[0].force[2], rel=1e-7)
    assert t.input_power == pytest.approx(t.power, rel=1e-8), "moments in space times speed are the losses"
    driven, resisted = t.helical_work_per_radian
    assert driven == pytest.approx(-resisted, rel=1e-8), "what the screw drives, the nut resists"
    assert found.ball_friction.loss.min() >= -1e-12 * t.power, "no contact and no cause gains power"
    work_per_radian = t.driving_torque_on_screw + t.axial_load * t.advance_per_radian
    assert work_per_radian * t.speed == pytest.approx(t.power, rel=1e-8)


def test_forward_and_backward_frame_the_ideal_torque():
    t, back = (state(small_screw(force=AXIAL), motion=Motion(speed)).friction_sums for speed in (10.0, -10.0))
    ideal = 800.0 * 20e-3 / (2.0 * np.pi)
    assert t.forward_torque - t.friction_torque == pytest.approx(ideal, rel=1e-9)
    assert t.backward_torque + t.friction_torque == pytest.approx(ideal, rel=1e-9)
    assert t.efficiency == pytest.approx((ideal / t.forward_torque, 2.0 - t.forward_torque / ideal), rel=1e-12)
    assert not t.is_self_locking
    assert t.driving_torque_on_screw == pytest.approx(-t.backward_torque, rel=1e-12), "turning forward: the load drives"
    assert back.driving_torque_on_screw == pytest.approx(-t.forward_torque, rel=1e-12)


def test_without_friction_of_one_or_both_grooves_the_load_does_all_the_work():
    coefficients = ((0.0, 0.0), (0.05, 0.05), (0.0, 0.2), (0.1, 0.1))
    free, half, one, rough = (state(two_starts(), Friction(*c, feedback=False)) for c in coefficients)
    t = free.friction_sums
    assert t.power == t.friction_torque == 0.0
    assert t.efficiency == (1.0, 1.0)
    assert t.driving_torque_on_screw == pytest.approx(-t.advance_per_radian * t.axial_load, rel=1e-12)
    # the limit of small equal coefficients
    assert np.allclose(free.ball_friction.orbital_speed, rough.ball_friction.orbital_speed, rtol=1e-12)
    assert half.friction_sums.friction_torque == pytest.approx(0.5 * rough.friction_sums.friction_torque, rel=1e-12)
    assert one.friction_sums.power == pytest.approx(0.0, abs=1e-12), "the rough groove carries the ball along"
    assert one.ball_friction.converged


def test_balls_without_load_have_no_motion_and_lose_nothing():
    scene = small_screw(6, 0.9, force=(0.0, 0.0, 100.0))
    errors = replace(scene.errors, balls=replace(scene.errors.balls, listed=((2, -20e-6),)))
    found = state(replace(scene, errors=errors))
    assert found.ball_friction.status[1] == "no load"
    assert np.isnan(found.ball_friction.orbital_speed[1])
    assert found.ball_friction.loss[1].sum() == 0.0
    assert np.isnan(found.closing_speeds[:2]).all()
    assert np.isfinite(found.friction_sums.friction_torque)


def test_a_larger_ball_orbits_by_its_own_radius():
    scene = small_screw(4, 0.8, oversize=5e-6, force=AXIAL)
    scene = replace(scene, errors=replace(scene.errors, balls=replace(scene.errors.balls, listed=((3, 2e-6),))))
    small, _, large, _ = contacts_of_result(scene, solved(scene)).ball_radius
    assert large - small == pytest.approx(2e-6, rel=1e-6)
    assert ball_kinematics(scene, TURN, large).nominal_orbit < ball_kinematics(scene, TURN, small).nominal_orbit


def test_closing_speeds_are_differences_of_orbits_along_each_start():
    found = state(two_starts())
    radius = np.hypot(16.5e-3, 24e-3 / (2.0 * np.pi))
    order = np.argsort(found.contacts.layout.azimuth[:8])
    gain = found.ball_friction.orbital_speed[order[:-1]] - found.ball_friction.orbital_speed[order[1:]]
    assert np.allclose(found.closing_speeds[order[:-1]], radius * gain, rtol=1e-12)
    assert np.isnan(found.closing_speeds[order[-1]])
    ring = state(SCENES["ring"]())
    assert np.isfinite(ring.closing_speeds).all()
    assert ring.closing_speeds.sum() == pytest.approx(0.0, abs=1e-15)


def test_what_is_refused():
    scene = small_screw(force=AXIAL)
    result = solved(scene)
    with pytest.raises(ValueError, match="at rest"):
        ball_friction(BallsUnderLoad(scene, contacts_of_result(scene, result), MU, Motion(0.0)))
    with pytest.raises(ValueError, match="not held"):
        contacts_of_result(scene, replace(result, status="not held: it turns"))
