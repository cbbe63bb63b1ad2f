"""Friction of random screws and rings: power in is power lost, no contact gains, mirror and reversal."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.helpers import mirrored, small_screw

from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import FourierTerm, Friction, Motion


@st.composite
def scenes(draw):
    """Right-hand screws of one to three starts and rings, two- to four-point contact, unlike grooves, pitch errors."""
    ring = draw(st.booleans())
    count, starts = draw(st.integers(3, 9)), 1 if ring else draw(st.integers(1, 3))
    lead = 0.0 if ring else draw(st.sampled_from((8e-3, 20e-3, 40e-3))) * starts
    turns = (count - 1) / count if ring else 0.8
    oversize = draw(st.sampled_from((0.0, 2e-6, 8e-6)))
    side = [draw(st.integers(-8, 8)) * 25.0 for _ in range(2)]
    force = (*side, draw(st.sampled_from((-900.0, 60.0, 700.0))))
    beta = math.radians(draw(st.integers(15, 75)))
    scene = small_screw(count, turns, lead=lead, beta=beta, oversize=oversize, force=force)
    scene = replace(scene, track=replace(scene.track, starts=starts))
    wave = FourierTerm(2.0, 1e-6 * draw(st.integers(0, 3)), 1e-6)
    errors = replace(scene.errors, SL=replace(scene.errors.SL, pitch=(wave,)))
    grooves = [2.778e-3 * draw(st.sampled_from((1.02, 1.06, 1.17, 3.0))) for _ in range(2)]
    screw, nut = replace(scene.screw, groove_radius=grooves[0]), replace(scene.nut, groove_radius=grooves[1])
    return replace(scene, errors=errors, screw=screw, nut=nut)


coefficient = st.sampled_from((1e-4, 0.01, 0.1, 0.5))
turning = st.builds(Motion, st.sampled_from((-300.0, 1e-3, 20.0)), st.sampled_from(("screw", "nut")))


@settings(max_examples=20, derandomize=True, deadline=None)
@given(scenes(), coefficient, coefficient, turning)
def test_energy_and_reversal(scene, screw, nut, motion):
    result = solve_static(scene)
    assume(result.converged)
    friction = Friction(screw, nut, feedback=False)
    found = friction_state(scene, result, friction, motion)
    t = found.friction_sums
    assert found.ball_friction.converged, found.ball_friction.status
    assert t.input_power == pytest.approx(t.power, rel=1e-8)
    assert (t.driving_torque_on_screw + t.axial_load * t.advance_per_radian) * t.speed == pytest.approx(t.power, rel=1e-8)
    assert found.ball_friction.loss.min() >= -1e-9 * t.power
    full = found.contacts.force * np.array([screw, screw, nut, nut])
    assert np.all(np.hypot(*np.moveaxis(found.ball_friction.force, -1, 0)) <= full * (1.0 + 1e-6)), "no more than mu F"
    back = friction_state(scene, result, friction, replace(motion, speed=-motion.speed))
    assert back.friction_sums.friction_torque == pytest.approx(t.friction_torque, rel=1e-7)


@settings(max_examples=25, derandomize=True, deadline=None)
@given(scenes(), coefficient, coefficient, turning)
def test_feedback_settles_and_keeps_the_axial_load(scene, screw, nut, motion):
    """Two-point contact under high friction too, where plain rounds run to and fro."""
    result = solve_static(scene)
    assume(result.converged and scene.track.lead != 0.0)
    found = friction_state(scene, result, Friction(screw, nut, feedback=True), motion)
    assert not found.unsettled_balls
    assert found.change < 1e-6
    t = found.friction_sums
    assert t.axial_load == pytest.approx(found.sums_without_feedback.axial_load, abs=1e-6 * t.contact_load_sum)
    assert t.input_power == pytest.approx(t.power, rel=1e-8)


@settings(max_examples=10, derandomize=True, deadline=None)
@given(scenes(), coefficient, turning)
def test_mirror(scene, mu, motion):
    result, other = solve_static(scene), mirrored(scene)
    assume(result.converged)
    friction, back = Friction(mu, mu, feedback=False), replace(motion, speed=-motion.speed)
    one = friction_state(scene, result, friction, motion).friction_sums
    two = friction_state(other, solve_static(other), friction, back).friction_sums
    assert two.friction_torque == pytest.approx(one.friction_torque, rel=1e-6)
    assert two.axial_load == pytest.approx(one.axial_load, rel=1e-6, abs=1e-9 * one.contact_load_sum)
