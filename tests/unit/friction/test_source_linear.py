"""The source's root finding for balls of a linear bearing: our answers where it succeeds, and its faults."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.lin_root_oracle import balls_of_linear_bearing, linear_bearing_friction_law

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.as_source import balls as chain
from rollbench.lowfi.friction.contact.laws import friction_forces
from rollbench.lowfi.friction.linear import chain as linear_chain
from rollbench.lowfi.friction.linear.bearing import contact_angle_deviations, loads_in_equilibrium
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain

BEARING = replace(source_cases.linear_pair_scene().bearing, mu_balls=0.08)
CASE = (np.radians(2.0), -0.6, 100.0)


@cache
def ours():
    """The case by our method."""
    return linear_chain.solve_pair_of_linear_balls(BEARING, *CASE)


def by_root(sharpness):
    """The case by the source's method, with Coulomb's law or a sigmoid."""
    law = linear_bearing_friction_law(BEARING, sharpness)
    return solve_by_root(BEARING, *linear_chain.pair_angles_and_loads(BEARING, *CASE), law=law)


def solve_by_root(bearing, angles, loads, may_touch=True, law=None):
    """Motion of balls by the source's method, equations 3.25 to 3.31; by Coulomb's law where none is given."""
    balls = balls_of_linear_bearing(bearing, angles, loads)
    near = np.broadcast_to(np.asarray(may_touch, dtype=bool), (balls.count - 1,))
    return chain.solve_motions_of_balls_by_root(balls, friction_forces if law is None else law, near)


def both(angles, loads):
    """A chain by our method and by the source's."""
    prepared = linear_chain.prepare_linear_chain(BEARING, angles, loads)
    return solve_motion_of_chain(prepared), solve_by_root(BEARING, angles, loads)


def state(theta, rho):
    """Contact angles and loads of balls with the given deviations [deg] and side force ratios."""
    angles = BEARING.contact_angle + contact_angle_deviations(np.radians(theta))
    return angles, loads_in_equilibrium(angles, 100.0, np.asarray(rho))


@pytest.mark.parametrize("sharpness", [None, 100.0])
def test_pair_is_ours(sharpness):
    found, touching = by_root(sharpness), ours().touching
    assert found.status == "exact"
    assert found.ball_force[0] == pytest.approx(ours().ball_to_ball_force, rel=1e-9)
    np.testing.assert_allclose(found.motions_without_ball_forces[:, 0], ours().apart.q[:, 0], rtol=1e-10)
    np.testing.assert_allclose(found.ball_motions[:, 0], touching.q[:, 0], rtol=1e-10)
    np.testing.assert_allclose(found.ball_motions[:, 1:], touching.q[:, [3, 1]], atol=1e-8)
    assert found.loss == pytest.approx(touching.loss, rel=1e-9)
    np.testing.assert_allclose(found.groove_loss, touching.groove_loss, rtol=1e-8)


def test_answer_goes_to_ours_as_the_sigmoid_sharpens():
    """Friction lacks the part 1 - tanh(k_S / 2) about the reference spin: so does the force, within a small factor."""
    for k in (6.0, 9.0, 12.0, 15.0):
        lacking = 1.0 - np.tanh(0.5 * k)
        off = abs(by_root(k).ball_force[0] / ours().ball_to_ball_force - 1.0)
        assert 0.2 * lacking < off < 3.0 * lacking


def test_chain_is_ours_where_the_rule_for_contact_holds():
    """Each ball faster than the next: all touch."""
    right, found = both(*state([2.5, 2.0, 1.0, 1.5, 2.5], [-0.5, -0.3, 0.1, 0.3, 0.5]))
    assert found.status == "exact"
    assert np.all(right.ball_force[:-1] > 0.0)
    np.testing.assert_allclose(found.ball_force, right.ball_force[:-1], rtol=1e-8)
    np.testing.assert_allclose(found.ball_loss, right.ball_loss[:-1], rtol=1e-8)
    assert found.largest_residual < 1e-10


def test_balls_that_part_or_are_out_of_reach_stay_apart():
    angles, loads = state([2.0, 2.0], [0.6, -0.6])
    parting = solve_by_root(BEARING, angles, loads)
    assert parting.status == "exact"
    assert parting.ball_motions[1, 0] > parting.ball_motions[0, 0]
    assert parting.ball_force[0] == 0.0
    far = solve_by_root(BEARING, angles[::-1], loads[::-1], False)
    assert far.ball_force[0] == 0.0
    np.testing.assert_array_equal(far.ball_motions, far.motions_without_ball_forces)


def test_rule_for_contact_lets_balls_overlap():
    """The first is slower than the second, but not than the second held up by the third: 3.31 does not see that."""
    right, found = both(*state([2.0, 2.5, 2.0], [-0.1, -0.2, 0.6]))
    assert found.motions_without_ball_forces[0, 0] < found.motions_without_ball_forces[1, 0]
    assert found.ball_motions[0, 0] > found.ball_motions[1, 0] * (1.0 + 1e-4)
    assert found.status == "overlapping"
    assert found.ball_force[0] == 0.0
    assert right.ball_force[0] > 0.1
    assert np.all(np.diff(right.q[:, 0]) > -1e-9 * BEARING.speed)


def test_failure_is_a_status():
    """All but two contacts unloaded, one rests under Coulomb's law: there is no root to find."""
    state_2p = linear_chain.pair_angles_and_loads(BEARING, np.radians(2.0), -1.0 + 1e-6, 100.0, loads="elastic")
    assert solve_by_root(BEARING, *state_2p).status == "failed"
