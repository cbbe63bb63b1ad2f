"""Balls that touch at one instant: energy, limits, and the sizes of what they do to each other."""

from dataclasses import replace

import numpy as np
import pytest
from tests.friction_runs import WAVES, crowded
from tests.whole_screws import state

from rollbench.lowfi.friction.whole.state import TOUCHING, friction_with_neighbours
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
    return state(touching(), PUSH, TURN)


def test_balls_push_move_alike_and_power_in_is_dissipation(pushed):
    n = pushed.neighbour_friction
    assert n.touching_pair_count == 5
    assert 0.0 <= n.smallest_gap <= TOUCHING
    assert n.force_on_next_ball.min() >= 0.0
    assert n.force_on_next_ball.max() > 1e-3
    assert n.force_on_next_ball[-1] == 0.0, "the last ball of the loaded arc pushes none"
    assert n.power_lost_between_balls > 0.0
    assert pushed.friction_sums.input_power == pytest.approx(pushed.friction_sums.power, rel=1e-8)
    assert pushed.friction_sums.power != pytest.approx(pushed.sums_without_feedback.power, rel=1e-6)
    together, speeds = n.force_on_next_ball[:-1] > 0.0, np.diff(pushed.ball_friction.orbital_speed)
    assert np.abs(speeds[together]).max() < 1e-9 * np.abs(pushed.ball_friction.orbital_speed).max()
    assert np.all(speeds[~together] > 0.0), "the others part"


def test_backwards_other_neighbours_push(pushed):
    back = state(touching(), PUSH, Motion(10.0))
    assert back.friction_sums.reverse_power == pytest.approx(pushed.friction_sums.power, rel=1e-9)
    assert np.all(back.neighbour_friction.force_on_next_ball == 0.0)


def test_without_friction_of_balls_or_grooves_nothing_is_lost_there(pushed):
    smooth = state(touching(), replace(PUSH, balls=0.0), TURN)
    assert smooth.neighbour_friction.force_on_next_ball.max() > 0.0
    assert smooth.neighbour_friction.power_lost_between_balls == pytest.approx(0.0, abs=1e-12)
    free = friction_with_neighbours(touching(), pushed.contacts, Friction(0.0, 0.0, feedback=False, neighbours=True), TURN)
    assert free.power_lost_between_balls == free.ball_friction.total_power_lost == 0.0


@pytest.mark.parametrize(("feedback", "apart"), [(False, 1e-6), (True, 1e-5)])
def test_balls_apart_move_as_without_neighbours(feedback, apart):
    scene, friction = touching(apart=3e-6), replace(PUSH, feedback=feedback)
    alone, found = (state(scene, replace(friction, neighbours=n), TURN) for n in (False, True))
    assert found.neighbour_friction.touching_pair_count == 0
    assert found.neighbour_friction.smallest_gap == pytest.approx(3e-6, rel=0.1)
    assert np.all(found.neighbour_friction.force_on_next_ball == 0.0)
    for name, near in (("power", apart), ("reverse_power", apart), ("axial_load", 1e-6)):
        assert getattr(found.friction_sums, name) == pytest.approx(getattr(alone.friction_sums, name), rel=near)


def test_neighbours_push_at_the_loads_that_friction_leaves(pushed):
    """Both together: loads of the feedback alone, forces between balls, power in is all that is lost."""
    scene = touching()
    moved, found = (state(scene, replace(PUSH, feedback=True, neighbours=n), TURN) for n in (False, True))
    assert found.friction_changes_loads
    assert np.array_equal(found.contacts.force, moved.contacts.force)
    assert np.abs(found.contacts.force - pushed.contacts.force).max() > 1e-3 * pushed.contacts.force.max()
    assert found.neighbour_friction.force_on_next_ball.max() > 0.0
    assert found.friction_sums.input_power == pytest.approx(found.friction_sums.power, rel=1e-6)
    assert found.friction_sums.power > moved.friction_sums.power
