"""Chains of balls: equilibrium by vectors, complementarity, energy, symmetries, limits, events in time."""

from dataclasses import replace

import numpy as np
import pytest
from tests.linear_chain_oracle import chain_by_oracle

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.contact.laws import contacts_from_values, friction_forces
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.linear import chain
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain

BEARING = source_cases.linear_pair_scene().bearing
ANGLES, LOADS = chain.pair_angles_and_loads(BEARING, np.radians(2.0), -0.6, 100.0)


def random_chain(count, seed=0, spread=3.0):
    rng = np.random.default_rng(seed)
    angles = BEARING.contact_angle + np.radians(rng.uniform(-spread, spread, (count, 4)))
    return angles, linear_bearing.loads_in_equilibrium(angles, 100.0, rng.uniform(-0.8, 0.8, count))


def solved(bearing, angles, loads, *touching):
    """Solution of a chain that must converge, and loses what is put in."""
    result = solve_motion_of_chain(chain.prepare_linear_chain(bearing, angles, loads, *touching))
    assert result.converged
    assert result.input_power == pytest.approx(result.loss, rel=1e-8)
    return result


def out_of_balance(bearing, angles, loads, result):
    """Axial force (N,) and moments over R_B (N, 2) [N] on the balls, by vectors and the closed form of the contact."""
    count, radius = len(angles), bearing.ball_radius
    force, moment = np.zeros(count), np.zeros((count, 3))
    a, b = linear_bearing.contact_semi_axes(bearing, loads)
    for j, i in np.ndindex(count, 4):
        if loads[j, i] == 0.0:
            continue
        n = np.array([*linear_bearing.contact_directions(angles)[j, i], 0.0])
        omega = np.array([*result.q[j, [3, 1]], 0.0])
        slide = result.q[j, 0] + np.cross(omega, radius * n)[2] - (bearing.speed if i > 1 else 0.0)
        at = contacts_from_values(a[j, i], b[j, i], loads[j, i], bearing.mu)
        f = friction_forces(at, np.array([[0.0, slide, omega @ n]]))
        force[j] += f.force[0, 1]
        moment[j] += np.cross(n, [0.0, 0.0, f.force[0, 1]]) + f.moment[0] * n / radius
    for k, push in enumerate(result.ball_force[:-1]):
        force[k] -= push
        force[k + 1] += push
        rub = np.cross([*result.q[k, [3, 1]], 0.0], [0.0, 0.0, radius])
        rub -= np.cross([*result.q[k + 1, [3, 1]], 0.0], [0.0, 0.0, -radius])
        on_first = -bearing.mu_balls * push * rub / np.linalg.norm(rub)
        moment[k] += np.cross([0.0, 0.0, 1.0], on_first)
        moment[k + 1] += np.cross([0.0, 0.0, -1.0], -on_first)
    return force, moment[:, :2]


def sliding_balls(bearing, loads, result):
    """Whether all contacts of each ball (N,) slide: those that stick bear less than the closed form gives."""
    spin = result.contact_motions[..., 2] * linear_bearing.contact_semi_axes(bearing, loads)[0]
    slides = np.all(np.hypot(result.contact_motions[..., 1], spin) > 1e-6 * bearing.speed, axis=1)
    rubs = np.linalg.norm(result.q[:-1, [3, 1]] + result.q[1:, [3, 1]], axis=1) * bearing.ball_radius
    rubs = (rubs > 1e-6 * bearing.speed) | (result.ball_force[:-1] == 0.0)
    slides[:-1] &= rubs
    slides[1:] &= rubs
    return slides


#: Number of balls, seed, spread of the angles [deg], friction between balls; with much of it the path round folds decides.
CHAINS = [
    (1, 8, 3.0, 0.1),
    (2, 2, 3.0, 0.1),
    (7, 8, 3.0, 0.1),
    (50, 50, 3.0, 0.1),
    (5, 2, 5.0, 0.5),
    (20, 2, 5.0, 0.5),
    (50, 2, 5.0, 0.3),
]


@pytest.mark.parametrize(("count", "seed", "spread", "mu"), CHAINS)
def test_equilibrium_of_every_ball_and_complementarity(count, seed, spread, mu):
    """(3.25), (3.26)-(3.29), (3.31) by vectors in space: independent of the energy, its derivatives and its solver."""
    bearing, much = replace(BEARING, mu_balls=mu), mu > 0.1
    angles, loads = random_chain(count, seed, spread)
    touching = np.random.default_rng(seed).random(count - 1) < (1.0 if much else 0.9)
    result = solved(bearing, angles, loads, touching)
    force, moment = out_of_balance(bearing, angles, loads, result)
    slides = sliding_balls(bearing, loads, result)
    assert slides.mean() > 0.5 if much or count == 50 else slides.all()
    # a regularising speed of 1e-7 of the carriage's, where contacts slide by 1e-3 of it: 1e-8 of the friction bounds, 20 N
    np.testing.assert_allclose(force[slides], 0.0, atol=1e-6 if much else 2e-7)
    np.testing.assert_allclose(moment[slides], 0.0, atol=1e-6 if much else 2e-7)
    closing = -np.diff(result.q[:, 0])
    assert np.all(result.ball_force >= 0.0)
    assert np.all(result.ball_force[:-1][~touching] == 0.0)
    assert np.all(closing[touching] <= 1e-10 * bearing.speed)
    assert np.abs(closing * result.ball_force[:-1]).max(initial=0.0) <= 1e-9 * bearing.speed * 100.0
    assert count == 1 or result.ball_force.max() > 0.1
    assert (count, mu) != (50, 0.1) or closing[~touching].max() > 0.0
    assert min(result.groove_loss.min(), result.ball_loss.min(initial=0.0)) >= 0.0


@pytest.mark.parametrize(("count", "seed", "mu"), [(2, 2, 0.1), (4, 8, 0.3), (6, 5, 0.5)])
def test_state_is_the_end_of_the_path_that_the_oracle_follows(count, seed, mu):
    """Equations, regularisation and path of its own; contacts that stick creep ten times as fast here as there."""
    bearing = replace(BEARING, mu_balls=mu)
    angles, loads = random_chain(count, seed, 5.0)
    velocity, force, residual = chain_by_oracle(bearing, angles, loads)
    result = solved(bearing, angles, loads)
    assert residual < 1e-9
    assert force.max() > 0.01
    unit = bearing.mu * loads.sum(axis=1).max()
    np.testing.assert_allclose(result.ball_force[:-1] / unit, force, atol=1e-6)
    np.testing.assert_allclose(result.q[:, 0] / bearing.speed, velocity, atol=1e-6)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_forces_scale_with_friction_and_not_with_speed(factor):
    angles, loads = random_chain(3, 1)
    changes = {}, {"speed": 0.01 * factor}, {"mu": 0.1 / factor}
    one, fast, slippery = (solved(replace(BEARING, **change), angles, loads) for change in changes)
    np.testing.assert_allclose(fast.ball_force, one.ball_force, rtol=1e-9)
    np.testing.assert_allclose(fast.q[:, 0], factor * one.q[:, 0], rtol=1e-9)
    np.testing.assert_allclose(slippery.ball_force * factor, one.ball_force, rtol=1e-8)


def test_two_point_contact_rolls_without_slip():
    """A diagonal through the centre carries all load: pure rolling at half speed, no loss."""
    loads = np.array([[100.0, 0.0, 100.0, 0.0]])
    result = solve_motion_of_chain(chain.prepare_linear_chain(BEARING, np.full((1, 4), 0.7), loads))
    assert result.q[0, 0] == pytest.approx(0.5 * BEARING.speed, rel=1e-7)
    assert result.loss < 1e-8 * BEARING.mu * 200.0 * BEARING.speed


def test_zero_speed_and_no_load():
    still = solved(replace(BEARING, speed=0.0), ANGLES, LOADS)
    assert still.loss == chain.carriage_drive_force(still.wrench) == still.input_power == 0.0
    assert not still.q[:, 0].any()
    empty = solved(BEARING, ANGLES, np.zeros((2, 4)))
    assert empty.loss == 0.0
    np.testing.assert_allclose(empty.q[:, 0], 0.5 * BEARING.speed)


@pytest.mark.parametrize(("loads", "words"), [(LOADS[:1], "shape"), (-LOADS, "not negative")])
def test_bad_input_is_refused(loads, words):
    with pytest.raises(ValueError, match=words):
        chain.prepare_linear_chain(BEARING, ANGLES, loads)
