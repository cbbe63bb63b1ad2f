"""The source's root finding for balls of a ball screw: loads, pairs and a whole screw against ours."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.as_source import screw
from rollbench.lowfi.friction.screw.motion import solve_screw_contact_loads, starting_displacements
from rollbench.lowfi.friction.screw.run import Run, simulate_equal_steps

TWO = np.radians(2.0)
PAIR, PRINTED = source_cases.oversized_pair(TWO), source_cases.pair_as_printed(TWO)


def few_balls(count=6, steps=40) -> Run:
    """A screw with few balls that fill its turns as 3.4.4 does."""
    base = source_cases.simulation_inputs()
    turns = count * base.groove.pair.spacing / (2.0 * np.pi * 0.978)
    return replace(base, count=count, turns=turns, force=(1500.0 * count / 37,), steps=steps, duration=0.01 * steps)


@pytest.mark.parametrize("pair", [PAIR, PRINTED, replace(PRINTED, free="zr", force=(30.0, 20.0))])
def test_loads_are_ours(pair):
    cell = pair.balls_with_loads()
    ours, found = solve_screw_contact_loads(cell), screw.solve_contact_loads_by_root(cell)
    assert found.converged
    np.testing.assert_allclose(found.force, ours.force, atol=1e-8 * ours.force.max())
    loaded = ours.force > 1e-3 * ours.force.max()
    np.testing.assert_allclose(found.angle[loaded], ours.angle[loaded], atol=1e-9)


def test_loads_that_are_not_found_are_not_converged():
    cell = PRINTED.balls_with_loads()
    ball, moved = starting_displacements(cell)
    lost = screw.BallPositions(ball, cell.angle, -moved)  # off the flanks: nothing has stiffness
    assert not screw.solve_contact_loads_by_root(cell, lost).converged


def test_run_is_ours_until_balls_meet_and_near_it_after():
    """Ours meets at the end of a step, the source's after it has overlapped: places differ by part of a step."""
    run = few_balls(steps=24)
    ours, found = simulate_equal_steps(run), screw.simulate_by_root(run)
    assert found.failed_step_count == 0
    meets = int(np.argmax(ours.presses_on_next.any(axis=1)))
    assert 5 < meets < 22
    np.testing.assert_allclose(found.omega[:meets], ours.omega[:meets], rtol=1e-10)
    np.testing.assert_allclose(found.gap[:meets], ours.gap[:meets], atol=1e-12)
    np.testing.assert_allclose(found.groove_torque[:meets], ours.groove_torque[:meets], rtol=1e-9)
    first = np.flatnonzero(found.ball_force.any(axis=1))
    assert first[0] in (meets, meets + 1)
    assert int(np.argmax(found.ball_force[first[0]])) in np.flatnonzero(ours.presses_on_next[first[0]])
    late = first[first > meets + 2]
    same = late[np.array([found.status[k] == "exact" for k in late])]
    np.testing.assert_allclose(found.ball_force[same].max(axis=1), ours.ball_force[same].max(axis=1), rtol=5e-3)
    np.testing.assert_allclose(found.ball_force[same].argmax(axis=1), ours.ball_force[same].argmax(axis=1))
    np.testing.assert_allclose(found.ball_torque[same], ours.ball_torque[same], rtol=5e-3)
    assert same.size > 2
    assert 0.0 < found.largest_overlap < 0.05 * run.groove.pair.spacing
