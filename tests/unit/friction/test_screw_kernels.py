"""Kernels of ball screws: both engines, derivatives by differences, banded elimination, cached machine code."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence.source_cases import oversized_pair, pair_as_printed
from rollbench.lowfi.friction.screw.chain import ScrewBallChain, solve_loads_and_motion, solve_motion_of_chain
from rollbench.lowfi.friction.screw.motion import balls_with_fixed_screw, solve_screw_contact_loads

TWO = np.radians(2.0)
SLACK = np.array([0.0, np.inf])


@pytest.mark.parametrize("free", ["", "z", "rz"])
@pytest.mark.parametrize("oversize", [-3e-6, 0.0, 1.7e-6])
def test_both_engines_settle_alike(free: str, oversize: float) -> None:
    pair = replace(oversized_pair(TWO), oversize=oversize, free=free, force=(3.0, 50.0)[2 - len(free) :])
    push = np.zeros((2, 2)) if oversize < 0.0 else np.array([[1.0, -2.0], [0.5, 3.0]])
    cell = replace(pair.balls_with_loads(), ball_friction_forces=push)
    fast, slow = solve_screw_contact_loads(cell), solve_screw_contact_loads(cell, fast=False)
    assert fast.converged
    assert slow.converged
    assert fast.force == pytest.approx(slow.force, rel=1e-12, abs=1e-15)
    assert fast.angle == pytest.approx(slow.angle, rel=1e-13)


@pytest.mark.parametrize("make", [pair_as_printed, oversized_pair])
def test_both_engines_move_balls_and_solve_the_joint_system_alike(make) -> None:
    """Motion, ball-to-ball force and losses, from the same loads; then loads and motion at once."""
    cell = make(TWO).balls_with_loads()
    load = solve_screw_contact_loads(cell)
    balls = ScrewBallChain(cell.groove, load.force, cell.groove.normals(load.angle), SLACK)
    fast, slow = (solve_motion_of_chain(balls, fast=f) for f in (True, False))
    assert fast.converged
    assert slow.converged
    assert fast.q == pytest.approx(slow.q, rel=1e-9)
    assert fast.ball_force == pytest.approx(slow.ball_force, rel=1e-9)
    assert fast.wrench == pytest.approx(slow.wrench, rel=1e-9, abs=1e-9)
    assert fast.neighbour_forces == pytest.approx(slow.neighbour_forces, rel=1e-9, abs=1e-12)
    assert fast.loss == pytest.approx(slow.loss, rel=1e-11)
    held, start = balls_with_fixed_screw(cell, load), (load.ball_displacements, np.zeros(0))
    fast, slow = (solve_loads_and_motion(held, SLACK, start, fast=f) for f in (True, False))
    assert fast.reached_full_friction
    assert slow.reached_full_friction
    assert fast.ball_friction_forces == pytest.approx(slow.ball_friction_forces, rel=1e-9, abs=1e-12)
    assert fast.ball_displacements == pytest.approx(slow.ball_displacements, rel=1e-9, abs=1e-15)
    assert fast.ball_force == pytest.approx(slow.ball_force, rel=1e-8)
