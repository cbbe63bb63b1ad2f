"""Stability of the linear bearing: converged and unique from random starts over the whole range of inputs."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.linear import bearing as linear_bearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain
from rollbench.lowfi.friction.screw.chain import ChainMotion, solve_motion_of_chain

BEARING = source_cases.linear_pair_scene().bearing
MU = (0.001, 0.1, 0.5)


def tilted(theta: float) -> np.ndarray:
    """Contact angles of two balls that theta [deg] turns."""
    return BEARING.contact_angle + linear_bearing.contact_angle_deviations(np.radians([theta, theta]))


def check(bearing, angles, loads, rng, motion: float = 1e-6) -> ChainMotion:
    """Converged, balanced in energy, and the same from a random start; forces relative to the friction bound.

    motion: agreement asked of the velocities over the carriage's.
    """
    chain = prepare_linear_chain(bearing, angles, loads)
    start = chain.groove.nominal_motion[0] * rng.uniform(-6.0, 6.0, (len(angles), 4)) / chain.groove.levers
    one, two = solve_motion_of_chain(chain), solve_motion_of_chain(chain, start=(start, np.zeros(len(angles))))
    case = bearing.mu, angles, loads
    for result in (one, two):
        assert result.converged, (case, result.largest_unbalanced_force, result.largest_gap_violation)
        assert abs(result.input_power - result.loss) <= 1e-8 * chain.largest_friction_bound * abs(bearing.speed), case
    np.testing.assert_allclose(two.ball_force, one.ball_force, atol=1e-6 * chain.largest_friction_bound, err_msg=str(case))
    np.testing.assert_allclose(two.q[:, 0], one.q[:, 0], atol=motion * abs(bearing.speed), err_msg=str(case))
    return one


@pytest.mark.parametrize("mu", MU)
@pytest.mark.parametrize("theta", [-5.0, -1.0, -1e-6, 0.0, 0.1, 2.0, 5.0])
def test_pairs(mu: float, theta: float) -> None:
    """rho to +-0.999, loads 1e-3 to 1e5 N."""
    bearing, rng = replace(BEARING, mu=mu, mu_balls=mu), np.random.default_rng(0)
    for rho, vertical in product((-0.999, -0.9, -0.6, -1e-3, 0.0, 0.3, 0.999), (1e-3, 1.0, 100.0, 1e5)):
        loads = linear_bearing.loads_equal_on_diagonals(vertical, np.array([rho, -rho]))
        check(bearing, tilted(theta), loads, rng)


@pytest.mark.parametrize("theta", [-5.0, 0.5, 5.0])
def test_pairs_under_balanced_and_elastic_loads(theta: float) -> None:
    rng, angles = np.random.default_rng(1), tilted(theta)
    for rho, vertical in product((-0.999, -0.6, 0.4, 0.999), (1e-3, 100.0, 1e5)):
        side = np.array([rho, -rho])
        check(BEARING, angles, linear_bearing.loads_in_equilibrium(angles, vertical, side), rng)
        loads, turned = linear_bearing.loads_of_elastic_contacts(BEARING, angles, vertical, side)
        check(BEARING, turned, loads, rng)


@pytest.mark.parametrize("mu", MU)
def test_two_point_transition(mu: float) -> None:
    """One diagonal relieved step by step, to nothing: forces stay unique.

    At the end the contacts of a ball are two, equally strong and not opposite: which of them spins costs nothing, and
    the velocity that goes with it is free by some 1e-4.
    """
    bearing, rng = replace(BEARING, mu=mu, mu_balls=mu), np.random.default_rng(2)
    for theta, rest in product((0.0, 0.5, 3.0), (1e-1, 1e-3, 1e-6, 1e-9, 1e-12)):
        loads = linear_bearing.loads_equal_on_diagonals(100.0, np.array([-1.0 + rest, 1.0 - rest]))
        check(bearing, tilted(theta), loads, rng, motion=1e-6 if rest > 1e-4 else 1e-3)


@pytest.mark.parametrize(("count", "mu"), [(3, 0.02), (10, 0.1), (50, 0.02), (50, 0.1), (10, 0.3), (5, 0.5)])
def test_chains(count: int, mu: float) -> None:
    """Every angle of every ball off by up to 3 degrees, any side force."""
    bearing, rng = replace(BEARING, mu=mu, mu_balls=mu), np.random.default_rng(count)
    for _ in range(4):
        angles = bearing.contact_angle + np.radians(rng.uniform(-3.0, 3.0, (count, 4)))
        loads = linear_bearing.loads_in_equilibrium(angles, 100.0, rng.uniform(-0.9, 0.9, count))
        result = check(bearing, angles, loads, rng)
        assert result.ball_force.max() > 0.0


@pytest.mark.parametrize("bare", [0.0, 0.25])
@pytest.mark.parametrize(
    ("count", "mu", "tries"),
    [(2, 0.5, 20), (5, 0.5, 20), (10, 0.3, 10), (20, 0.5, 6), (50, 0.001, 3), (50, 0.3, 3), (100, 0.5, 1)],
)
def test_chains_with_much_friction_between_balls(count: int, mu: float, tries: int, bare: float) -> None:
    """Every angle off by up to 5 degrees, loads apart by up to nine times; contacts without load at probability bare.

    With less than three contacts a ball has motions that cost nothing, which are free.
    """
    bearing, rng = replace(BEARING, mu_balls=mu), np.random.default_rng([count, int(1000 * mu), int(4 * bare)])
    for _ in range(tries):
        angles = bearing.contact_angle + np.radians(rng.uniform(-5.0, 5.0, (count, 4)))
        loads = linear_bearing.loads_in_equilibrium(angles, 100.0, rng.uniform(-0.9, 0.9, count))
        loads *= rng.uniform(0.2, 1.8, (count, 1))
        loads = np.where(rng.uniform(size=(count, 4)) < bare, 0.0, loads)
        check(bearing, angles, loads, rng, motion=1e-6 if bare == 0.0 else 2.0)


SPEEDS, CONFORMITIES = (0.0, 1e-12, -1e-12, 1e3), (0.505, 0.52, 0.6, 0.9)


@pytest.mark.parametrize("change", [{"speed": v} for v in SPEEDS] + [{"conformity": c} for c in CONFORMITIES], ids=str)
def test_any_speed_and_conformity(change: dict[str, float]) -> None:
    loads, bearing = linear_bearing.loads_equal_on_diagonals(100.0, np.array([-0.6, 0.6])), replace(BEARING, **change)
    result = check(bearing, tilted(2.0), loads, np.random.default_rng(4))
    assert np.isfinite(result.q[:, 0]).all()
    assert (result.ball_force[0] > 1.0) == (bearing.speed > 0.0)
