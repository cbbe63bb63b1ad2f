"""Linear bearing: contact law, kinematics, loads, and each rederived formula against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.special import ellipe

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.linear import chain
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain

BEARING = source_cases.linear_pair_scene().bearing


def linear_balance(bearing, angles, loads, x, force, k_f):
    """Force and moments out of balance ``(3,)`` of one ball with the linear friction law, by vectors in space."""
    radius, constants = bearing.ball_radius, bearing.contact_hertz_constants()
    a = constants.C_a * np.cbrt(loads)
    ellip = ellipe(1.0 - float(constants.C_b / constants.C_a) ** 2)
    total, turn = -force, np.zeros(3)
    omega = np.array([x[1], x[2], 0.0]) / radius
    for i in range(4):
        n = np.array([*linear_bearing.contact_directions(angles)[i], 0.0])
        slide = x[0] + np.cross(omega, radius * n)[2] - (1.0 if i > 1 else 0.0)
        spin = omega @ n
        f = -bearing.mu * loads[i] * k_f * slide / (abs(spin) * a[i])
        total += f
        turn += np.cross(radius * n, [0.0, 0.0, f]) / radius
        turn -= 0.375 * bearing.mu * loads[i] * a[i] * ellip * np.sign(spin) * n / radius
    return np.array([total, turn[0], turn[1]])


@pytest.mark.parametrize("nominal", [38.0, 45.0])
def test_velocity_formula_against_brute_force(nominal):
    """(3.37), (3.43): motion of one ball by solving its equilibrium in vectors with the same linear friction law."""
    bearing = replace(BEARING, contact_angle=np.radians(nominal), young=2.1e14)
    turn, loads = 1e-4 * np.array([-1.0, 2.0, 0.5, -0.3]), np.array([60.0, 20.0, 60.0, 20.0])
    angles = bearing.contact_angle + turn
    start = np.array([0.5, 0.5 / np.cos(bearing.contact_angle), 1e-5])
    x = fsolve(lambda x: linear_balance(bearing, angles, loads, x, 0.0, 1.4), start, xtol=1e-13)
    found = linear_bearing.relative_velocity_deviation(bearing.contact_angle, turn, 60.0, 20.0)
    assert found == pytest.approx(2.0 * x[0] - 1.0, rel=2e-3)


@pytest.mark.parametrize("nominal", [38.0, 45.0])
def test_force_formula_against_brute_force(nominal):
    """(3.51), exponents +2/3 and tan(beta_0): two balls forced to one velocity, solved in vectors."""
    bearing = replace(BEARING, contact_angle=np.radians(nominal), young=2.1e14)
    turn = 1e-4 * np.array([[-1.0, 1.0, 0.0, 0.0]] * 2)
    loads = np.array([[30.0, 100.0, 30.0, 100.0], [90.0, 40.0, 90.0, 40.0]])[::-1]
    angles = bearing.contact_angle + turn

    def balance(y):
        one = linear_balance(bearing, angles[0], loads[0], y[[0, 1, 2]], y[5], 1.4)
        two = linear_balance(bearing, angles[1], loads[1], y[[0, 3, 4]], -y[5], 1.4)
        return np.concatenate([one, two])

    roll = 0.5 / np.cos(bearing.contact_angle)
    exact = fsolve(balance, np.array([0.5, roll, 1e-5, roll, 1e-5, 1e-3]), xtol=1e-13)[5]
    epsilon = linear_bearing.relative_velocity_deviation(bearing.contact_angle, turn, loads[:, 0], loads[:, 1])
    assert exact > 0.0
    force = linear_bearing.ball_force_by_formula(bearing, loads[:, :2], epsilon[0] - epsilon[1], k_f=1.4)
    assert force == pytest.approx(exact, rel=3e-3)
    assert linear_bearing.ball_force_by_formula(bearing, loads[:, :2], epsilon[1] - epsilon[0], k_f=1.4) == 0.0


def test_rubbing_speed_and_loss():
    """(3.52), (3.53): two balls rolling at the nominal angle, in vectors."""
    bearing = replace(BEARING, contact_angle=0.6, speed=-0.02)
    omega = np.array([0.5 * bearing.speed / (bearing.ball_radius * np.cos(0.6)), 0.0, 0.0])
    z = np.array([0.0, 0.0, bearing.ball_radius])
    speed = np.linalg.norm(np.cross(omega, z) - np.cross(omega, -z))
    assert linear_bearing.ball_to_ball_sliding_speed(bearing) == pytest.approx(speed, rel=1e-12)
    assert linear_bearing.ball_to_ball_loss(bearing, 3.0) == pytest.approx(0.1 * 3.0 * speed, rel=1e-12)


def test_spin_loss_is_that_of_the_numerical_model_without_deviations():
    loads = linear_bearing.loads_equal_on_diagonals(100.0, np.array([0.2]))
    balls = chain.prepare_linear_chain(BEARING, np.full((1, 4), BEARING.contact_angle), loads)
    numerical = solve_motion_of_chain(balls)
    assert linear_bearing.groove_spin_loss(BEARING, loads).sum() == pytest.approx(numerical.loss, rel=2e-3)


def forces_on_ball(angles, loads):
    return np.einsum("...i,...ij->...j", loads, linear_bearing.contact_directions(angles))


def test_loads_are_in_equilibrium():
    rho = np.array([-0.6, 0.0, 0.3])
    angles = BEARING.contact_angle + linear_bearing.contact_angle_deviations(np.radians([2.0, -3.0, 5.0]))
    carriage = 100.0 * np.column_stack([rho, -np.ones(3)])
    balanced, flat = linear_bearing.loads_in_equilibrium(angles, 100.0, rho), np.full((3, 4), BEARING.contact_angle)
    bearings = BEARING, replace(BEARING, young=2.1e17)
    elastic, stiff = (linear_bearing.loads_of_elastic_contacts(b, angles, 100.0, rho) for b in bearings)
    for loads, turned in [(balanced, angles), elastic]:
        np.testing.assert_allclose(forces_on_ball(turned, loads), 0.0, atol=1e-9)
        on_top = forces_on_ball(turned, loads * [0.0, 0.0, 1.0, 1.0])
        np.testing.assert_allclose(on_top, -carriage, atol=1e-9)
    diagonal = linear_bearing.loads_equal_on_diagonals(100.0, rho)
    np.testing.assert_allclose(diagonal, linear_bearing.loads_in_equilibrium(flat, 100.0, rho), atol=1e-11)
    np.testing.assert_allclose(stiff[0], balanced, rtol=1e-4)
    np.testing.assert_allclose(stiff[1], angles, atol=1e-5)
