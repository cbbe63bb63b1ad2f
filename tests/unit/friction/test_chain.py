"""Chains of balls: equilibrium by vectors, complementarity, energy, symmetries, limits, events in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog
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
    bearing, touching = replace(BEARING, mu_balls=mu), np.ones(count - 1, dtype=bool)
    angles, loads = random_chain(count, seed, 5.0)
    velocity, force, residual = chain_by_oracle(bearing, angles, loads, touching)
    result = solved(bearing, angles, loads)
    assert residual < 1e-9
    assert force.max() > 0.01
    unit = bearing.mu * loads.sum(axis=1).max()
    np.testing.assert_allclose(result.ball_force[:-1] / unit, force, atol=1e-6)
    np.testing.assert_allclose(result.q[:, 0] / bearing.speed, velocity, atol=1e-6)


def test_power_does_not_depend_on_the_frame():
    """Seen from the carriage the bottom groove moves: same loss, and the forces on both grooves are opposite."""
    result = solved(BEARING, ANGLES, LOADS)
    assert result.ball_force[0] > 1.0
    assert solved(BEARING, ANGLES[::-1], LOADS[::-1]).ball_force[0] == 0.0, "swapped balls part"
    bottom, top = result.contact_friction[:, :2, 1].sum(), result.contact_friction[:, 2:, 1].sum()
    assert bottom == pytest.approx(-top, rel=1e-9)
    assert -bottom * BEARING.speed == pytest.approx(result.loss, rel=1e-8)


def test_energy_is_least():
    """Without ball-to-ball friction the motion minimises the dissipation under the order of the velocities."""
    bearing = replace(BEARING, mu_balls=0.0)
    result = solved(bearing, ANGLES, LOADS)
    a, b = linear_bearing.contact_semi_axes(bearing, LOADS)
    n, rng = linear_bearing.contact_directions(ANGLES), np.random.default_rng(2)

    def loss(velocity, rotation):
        around = rotation[:, None, 0] * n[..., 1] - rotation[:, None, 1] * n[..., 0]
        slide = velocity[:, None] + bearing.ball_radius * around - [0.0, 0.0, bearing.speed, bearing.speed]
        spin = np.einsum("jk,jik->ji", rotation, n)
        motion = np.stack([np.zeros(8), slide.ravel(), spin.ravel()], axis=1)
        return friction_forces(contacts_from_values(a.ravel(), b.ravel(), LOADS.ravel(), bearing.mu), motion).loss.sum()

    least = loss(result.q[:, 0], result.q[:, [3, 1]])
    assert least == pytest.approx(result.loss, rel=1e-9)
    for _ in range(200):
        dv = 1e-5 * np.sort(rng.normal(size=2))  # keeps ball 1 from overtaking ball 2
        assert loss(result.q[:, 0] + dv, result.q[:, [3, 1]] + 1e-3 * rng.normal(size=(2, 2))) > least


def test_mirror():
    """Left and right exchanged: same forces and velocities, omega_y turned."""
    angles, loads = random_chain(4, 7)
    one, two = solved(BEARING, angles, loads), solved(BEARING, angles[:, [1, 0, 3, 2]], loads[:, [1, 0, 3, 2]])
    np.testing.assert_allclose(two.q[:, 0], one.q[:, 0], rtol=1e-9)
    np.testing.assert_allclose(two.ball_force, one.ball_force, atol=1e-9)
    np.testing.assert_allclose(two.q[:, [3, 1]], one.q[:, [3, 1]] * [1.0, -1.0], atol=1e-7)
    # carriage backwards and balls in reverse order: the same contacts under the same forces
    two = solved(replace(BEARING, speed=-0.01), angles[::-1], loads[::-1])
    np.testing.assert_allclose(two.q[:, 0], -one.q[:, 0][::-1], rtol=1e-9)
    np.testing.assert_allclose(two.ball_force[:-1], one.ball_force[-2::-1], atol=1e-9)
    assert chain.carriage_drive_force(two.wrench) == pytest.approx(-chain.carriage_drive_force(one.wrench), rel=1e-9)
    assert two.loss == pytest.approx(one.loss, rel=1e-9)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_forces_scale_with_friction_and_not_with_speed(factor):
    angles, loads = random_chain(3, 1)
    changes = {}, {"speed": 0.01 * factor}, {"mu": 0.1 / factor}
    one, fast, slippery = (solved(replace(BEARING, **change), angles, loads) for change in changes)
    np.testing.assert_allclose(fast.ball_force, one.ball_force, rtol=1e-9)
    np.testing.assert_allclose(fast.q[:, 0], factor * one.q[:, 0], rtol=1e-9)
    np.testing.assert_allclose(slippery.ball_force * factor, one.ball_force, rtol=1e-8)


def test_rigid_limit():
    """Point contacts cannot resist spin: the least sum of mu F |sliding| is a linear program."""
    angles, loads = random_chain(1, 4)
    result = solved(replace(BEARING, young=2.1e23), angles, loads)
    n = linear_bearing.contact_directions(angles)[0]
    rows, right = np.column_stack([np.ones(4), n[:, 1], -n[:, 0]]), np.array([0.0, 0.0, 1.0, 1.0])
    bounds = np.block([[rows, -np.eye(4)], [-rows, -np.eye(4)]]), np.concatenate([right, -right])
    free, positive = [(None, None)] * 3, [(0.0, None)] * 4
    program = linprog(np.concatenate([np.zeros(3), loads[0]]), *bounds, bounds=free + positive)
    assert program.fun > 1e-3
    assert result.q[0, 0] / BEARING.speed == pytest.approx(program.x[0], abs=1e-4)
    assert result.loss == pytest.approx(BEARING.mu * BEARING.speed * program.fun, rel=1e-2)


def test_two_point_contact_rolls_without_slip():
    """A diagonal through the centre carries all load: pure rolling at half speed, no loss."""
    loads = np.array([[100.0, 0.0, 100.0, 0.0]])
    result = solve_motion_of_chain(chain.prepare_linear_chain(BEARING, np.full((1, 4), 0.7), loads))
    assert result.q[0, 0] == pytest.approx(0.5 * BEARING.speed, rel=1e-7)
    assert result.loss < 1e-8 * BEARING.mu * 200.0 * BEARING.speed


def test_two_point_transition_is_continuous():
    """Velocities approach those of two-point contact as the other diagonal is relieved."""
    angles = BEARING.contact_angle + linear_bearing.contact_angle_deviations(np.radians([2.0]))
    side = -1.0 + np.array([0.3, 0.1, 1e-2, 1e-3, 1e-5, 0.0])
    loads = [linear_bearing.loads_equal_on_diagonals(100.0, np.array([s])) for s in side]
    steps = np.abs(np.diff([solved(BEARING, angles, of).q[0, 0] for of in loads])) / BEARING.speed
    assert steps[:2].min() > 1e-3
    assert steps[2:-1].max() < 1e-5
    assert steps[-1] < 1e-3  # with two contacts alone, sharing the spin between them costs nothing


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
