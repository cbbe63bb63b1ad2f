"""Balls that start from rest: they close their gap, meet and end in the steady state; loads of the 3D model."""

import numpy as np
import pytest
from tests.rolling_scenes import linear_pair

from rollbench.hifi.rolling.balls import RollingSettings, compute_motion_from_rest, solve_rolling
from rollbench.hifi.rolling.patch import solve_elastic_contact_on_grid
from rollbench.hifi.rolling.scenes import StaticProblem, solve_static_problem
from rollbench.hifi.rolling.verification import Creep, simulate_rolling_onset, solve_steady_rolling_like_kalker

GRID = RollingSettings((8, 8))


def test_balls_meet_and_end_in_steady_rolling_whatever_the_steps():
    scene = linear_pair()
    run, steady = compute_motion_from_rest(scene, 0.1, 20, 1e-6, GRID), solve_rolling(scene, GRID)
    assert run.converged
    assert run.ball_to_ball_forces[0, 0] == 0.0
    assert run.ball_to_ball_gaps[0, 0] > 0.0
    assert run.ball_to_ball_gaps[-1, 0] == pytest.approx(0.0, abs=1e-15)
    assert np.all(np.diff(run.ball_to_ball_gaps[:, 0]) <= 1e-15)
    assert run.track_speeds[0, 0] > run.track_speeds[0, 1]
    assert run.track_speeds[-1, 0] == pytest.approx(run.track_speeds[-1, 1], rel=1e-9)
    assert run.ball_to_ball_forces[-1, 0] == pytest.approx(steady.ball_to_ball_forces[0], rel=0.02)
    ends = [compute_motion_from_rest(scene, 0.1, n, 1e-6, GRID).ball_to_ball_forces[-1, 0] for n in (10, 30)]
    assert ends[0] == pytest.approx(ends[1], rel=0.02)


@pytest.mark.parametrize("steps", [10, 50])
def test_power_put_in_is_dissipated_or_stored(steps):
    """In every step, that in which the balls meet too; what is stored at the end is lost by the steps."""
    run = compute_motion_from_rest(linear_pair(), 0.1, steps, 1e-6, GRID)
    assert run.losses + run.stored_power == pytest.approx(run.driving_power, rel=1e-9)
    assert 0.0 <= run.stored_power[-1] < 0.03 * run.driving_power[-1]


@pytest.mark.parametrize("bad", [(0.0, 10, 0.0), (0.1, 0, 0.0), (0.1, 10, -1e-6)])
def test_steps_that_make_no_sense_are_refused(bad):
    with pytest.raises(ValueError, match="duration"):
        compute_motion_from_rest(linear_pair(), *bad, GRID)


def cell_of(n, inner, motions, pull, push):
    """One ball with contacts along these directions, without gaps."""
    count = len(n)
    return StaticProblem(
        n[None], 6e-4, np.zeros((1, count)), np.full((1, count), 1e-7), inner, motions, np.zeros((1, 2)), pull, push
    )


def test_loads_of_two_opposite_contacts_share_a_force():
    """Contacts at 45 deg under a force along one diagonal: F = force, directions unturned."""
    n = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * np.sqrt(0.5)
    pull = 100.0 * np.array([-np.sqrt(0.5), -np.sqrt(0.5)])
    inner = np.array([False, False, True, True])
    found = solve_static_problem(cell_of(n, inner, np.eye(2)[None], pull, np.zeros((1, 2))))
    assert found.converged
    assert found.force[0] == pytest.approx([100.0, 0.0, 100.0, 0.0], rel=1e-6, abs=1e-3)


def test_a_cell_that_nothing_holds_does_not_converge():
    n, push = np.array([[0.0, 1.0]]), np.array([[0.0, -5.0]])
    assert not solve_static_problem(cell_of(n, np.array([False]), np.zeros((1, 2, 0)), np.zeros(0), push)).converged


def test_a_pushed_ball_rolls_on_towards_the_creepage_of_steady_rolling() -> None:
    """Found without time, at the same force: by two contact lengths it is there."""
    load, share, mu = 0.4705, 0.657, 0.4
    patch = solve_elastic_contact_on_grid(load, (0.17, 0.17), 2.56e6, 0.28, (11, 11))
    found = simulate_rolling_onset(patch, mu, share, 22)
    steady = solve_steady_rolling_like_kalker(patch, Creep(found[-1].shift_or_creepage, 0.0, 0.0), mu)
    assert steady.friction_force[0] == pytest.approx(-share * mu * load, rel=2e-3)
    assert found[1].shift_or_creepage < 0.7 * found[-1].shift_or_creepage
    assert max(one.shift_or_creepage for one in found[1:]) > 1.05 * found[-1].shift_or_creepage
