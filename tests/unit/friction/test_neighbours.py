"""Balls that touch at one instant: energy, limits, and the sizes of what they do to each other."""

from dataclasses import replace

import numpy as np
import pytest
from tests.friction_runs import WAVES, crowded
from tests.helpers import solved

from rollbench.lowfi.friction.whole.state import TOUCHING, friction_state, neighbours
from rollbench.meshes.parts import BallErrors, Friction, Motion

#: Against this motion the balls of ``touching`` close up; with it they part.
TURN = Motion(-10.0)
PUSH = Friction(0.1, 0.1, feedback=False, neighbours=True)


def touching(oversize=4e-6, apart=0.0, **options):
    """Equal balls that touch, on grooves with errors, so that they would move at different speeds."""
    scene = crowded(**options)
    spacing = np.diff(scene.balls.azimuths)[0] + (2.0 * oversize - 10e-6) / 16.4e-3
    step = spacing + (apart + 0.05e-6) / 16.4e-3
    count = len(scene.balls.azimuths)
    places = tuple(float(step * (k - 0.5 * (count - 1))) for k in range(count))
    errors = replace(WAVES, balls=BallErrors(oversize=oversize))
    circulation = replace(scene.circulation, turns=count * (step + 1e-3) / (2.0 * np.pi))
    return replace(scene, balls=replace(scene.balls, azimuths=places), errors=errors, circulation=circulation, motion=TURN)


@pytest.fixture(scope="module")
def pushed():
    scene = touching()
    return scene, friction_state(scene, solved(scene), PUSH, TURN)


def test_balls_push_and_power_in_is_dissipation(pushed):
    _, found = pushed
    n = found.neighbours
    assert n.touching == 5
    assert 0.0 <= n.least <= TOUCHING
    assert n.force.min() >= 0.0
    assert n.force.max() > 1e-3
    assert n.power > 0.0
    assert found.torque.input_power == pytest.approx(found.torque.power, rel=1e-8)
    assert found.torque.power != pytest.approx(found.bare.power, rel=1e-6)


def test_balls_that_push_move_alike(pushed):
    _, found = pushed
    together = found.neighbours.force[:-1] > 0.0
    speeds = np.diff(found.balls.orbit)
    assert np.abs(speeds[together]).max() < 1e-9 * np.abs(found.balls.orbit).max()
    assert np.all(speeds[~together] > 0.0), "the others part"


def test_the_last_ball_of_the_loaded_arc_pushes_none(pushed):
    assert pushed[1].neighbours.force[-1] == 0.0


def test_backwards_other_neighbours_push():
    scene = touching()
    result = solved(scene)
    there, back = (friction_state(scene, result, PUSH, Motion(speed)) for speed in (-10.0, 10.0))
    assert back.torque.reverse_power == pytest.approx(there.torque.power, rel=1e-9)
    assert there.neighbours.force.max() > 0.0
    assert np.all(back.neighbours.force == 0.0)


def test_balls_apart_move_as_without_neighbours():
    scene = touching(apart=3e-6)
    found = friction_state(scene, solved(scene), PUSH, TURN)
    assert found.neighbours.touching == 0
    assert found.neighbours.least == pytest.approx(3e-6, rel=0.1)
    assert found.torque.power == pytest.approx(found.bare.power, rel=1e-6)
    assert np.all(found.neighbours.force == 0.0)


def test_smooth_balls_touch_without_loss_between_them():
    scene = touching()
    result = solved(scene)
    smooth = friction_state(scene, result, replace(PUSH, balls=0.0), TURN)
    rough = friction_state(scene, result, PUSH, TURN)
    assert smooth.neighbours.force.max() > 0.0
    assert smooth.neighbours.power == pytest.approx(0.0, abs=1e-12)
    assert rough.neighbours.power > 0.0


def test_without_groove_friction_nothing_is_lost():
    scene = touching()
    at = friction_state(scene, solved(scene), PUSH, TURN).at
    found = neighbours(scene, at, Friction(0.0, 0.0, feedback=False, neighbours=True), TURN)
    assert found.power == 0.0
    assert found.balls.power == 0.0


def test_flat_grooves_have_their_long_axis_along_the_path_for_chains_too():
    scene = touching(apart=3e-6)
    flat = 40.0 * scene.balls.radius
    scene = replace(scene, screw=replace(scene.screw, groove_radius=flat), nut=replace(scene.nut, groove_radius=flat))
    result = solved(scene)
    alone, found = (friction_state(scene, result, f, TURN) for f in (replace(PUSH, neighbours=False), PUSH))
    assert not alone.at.across.all()
    assert found.balls.force == pytest.approx(alone.balls.force, abs=1e-5 * np.abs(alone.balls.force).max())
    assert found.balls.orbit == pytest.approx(alone.balls.orbit, rel=1e-6)


def test_neighbours_push_at_the_loads_that_friction_leaves():
    """Both together: loads of the feedback alone, forces between balls, power in is all that is lost."""
    scene = touching()
    result = solved(scene)
    moved = friction_state(scene, result, replace(PUSH, feedback=True, neighbours=False), TURN)
    found = friction_state(scene, result, replace(PUSH, feedback=True), TURN)
    still = friction_state(scene, result, PUSH, TURN)
    assert found.coupled
    assert np.array_equal(found.at.force, moved.at.force)
    assert np.abs(found.at.force - still.at.force).max() > 1e-3 * still.at.force.max()
    assert found.neighbours.force.max() > 0.0
    assert found.torque.input_power == pytest.approx(found.torque.power, rel=1e-6)
    assert found.torque.power > moved.torque.power


def test_balls_apart_with_feedback_move_as_by_it_alone():
    scene = touching(apart=3e-6)
    result = solved(scene)
    moved = friction_state(scene, result, replace(PUSH, feedback=True, neighbours=False), TURN)
    found = friction_state(scene, result, replace(PUSH, feedback=True), TURN)
    assert found.neighbours.touching == 0
    assert found.torque.power == pytest.approx(moved.torque.power, rel=1e-5)
    assert found.torque.reverse_power == pytest.approx(moved.torque.reverse_power, rel=1e-5)
    assert found.torque.load == pytest.approx(moved.torque.load, rel=1e-6)
