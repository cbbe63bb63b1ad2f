"""Coupled equations of a chain and their path: derivatives, elimination, folds, several solutions, engines."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.linear.bearing import balanced_loads
from rollbench.lowfi.friction.linear.chain import CREEP, prepare, second_state, solve_linear_chain
from rollbench.lowfi.friction.linear.kernel import equations, newton, path
from rollbench.lowfi.friction.linear.kernel_types import ChainPoint, Smoothing, Work

BEARING = replace(source_cases.linear().bearing, mu_balls=0.3)


def random_chain(count, seed, mu_balls=0.5, bare=0.0):
    """Any angles and loads; each contact is without load at the probability ``bare``."""
    rng = np.random.default_rng(seed)
    angles = BEARING.contact_angle + np.radians(rng.uniform(-5.0, 5.0, (count, 4)))
    loads = balanced_loads(angles, 100.0, rng.uniform(-0.9, 0.9, count)) * rng.uniform(0.2, 1.8, (count, 1))
    loads = np.where(rng.uniform(size=(count, 4)) < bare, 0.0, loads)
    return prepare(replace(BEARING, mu_balls=mu_balls), angles, loads)


def follow(chain, monkeypatch=None):
    """Forces at the path's end over the friction bound, and how often s turned on the way."""
    count = chain.count
    n, slopes, tangent = 4 * count, [], path._tangent
    point = ChainPoint(np.zeros((count, 4, 2)), np.zeros((count - 1, 3)), np.zeros((count, 3)), np.zeros(count - 1))
    work = Work(np.empty((n, equations.WIDTH)), np.empty((n, equations.FILLED)), np.empty(n), np.empty(n), np.zeros(n))
    equations.rebuild(chain.problem, point)

    def record(*args):
        sign = tangent(*args)
        slopes.append(sign * args[-1][-1])
        return sign

    if monkeypatch is not None:
        monkeypatch.setattr(path, "_tangent", record)
    _, good = path.trace(chain.problem, point, CREEP, work, 5000)
    assert good
    equations.reopen(point, CREEP)
    _, left = newton.semismooth_newton(chain.problem, point, Smoothing(CREEP, 1.0, 0.0, 0.0), work, 1e-12, 60, 1.0)
    assert left <= 1e-9
    return np.maximum(point.z, 0.0), np.sum(np.diff(np.sign(slopes)) != 0)


def test_two_solutions_and_the_one_taken():
    """Two balls in two-point contact: they part without friction between them, or jam by it; both are solutions.

    Force 0.094 of the friction bound makes the friction that makes balls press on each other by 0.094.
    """
    angles = np.radians([[45.415, 45.542, 42.175, 46.368], [46.394, 49.657, 49.704, 41.806]])
    loads = np.array([[0.0, 86.256, 0.0, 85.812], [130.612, 0.0, 125.399, 0.0]])
    apart, chain = prepare(BEARING, angles, loads, False), prepare(BEARING, angles, loads)
    assert np.diff(solve_linear_chain(apart).velocity)[0] > 1e-4 * BEARING.speed
    jammed, _ = follow(chain)
    assert jammed[0] == pytest.approx(0.0938, abs=1e-3)
    taken = solve_linear_chain(chain)
    assert taken.status == "converged"
    assert taken.ball_force[0] == 0.0
    second = second_state(chain, taken)
    assert second.status == "converged"
    assert second.residual < 1e-9
    assert second.ball_force[0] / chain.scale == pytest.approx(0.147, abs=1e-3), "a third state, of larger force"
    assert second.drive > 10.0 * taken.drive, "the jammed balls drag, those apart roll"
    assert second_state(chain, second).ball_force[0] / chain.scale == pytest.approx(jammed[0], abs=1e-8)
    assert second_state(apart, taken) is None
    for mu_balls, jams in ((0.1, True), (0.03, False)):
        smooth = prepare(replace(BEARING, mu_balls=mu_balls), angles, loads)
        assert (second_state(smooth, solve_linear_chain(smooth)) is not None) is jams


def test_both_engines_agree_on_the_path():
    chain = random_chain(6, 2)
    one, two = (solve_linear_chain(chain, fast=k) for k in (False, True))
    assert one.status == two.status == "converged"
    np.testing.assert_allclose(one.ball_force, two.ball_force, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.velocity, two.velocity, rtol=1e-12)
