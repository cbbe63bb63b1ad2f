"""Balls in contact in a ball screw, two and many: balance, symmetry, starts, constrained dissipation, bad input."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import SCREW_STATES as STATES

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.lowfi.friction.screw import run
from rollbench.lowfi.friction.screw.chain import ScrewBallChain, screw_ball_chain, solve_motion_of_chain
from rollbench.lowfi.friction.screw.motion import solve_ball_motion

SCREW = source_cases.screw_groove()
TWO = np.radians(2.0)
PAIR = source_cases.oversized_pair(TWO)
BACK = replace(SCREW, nut_speed=-SCREW.nut_speed)


def open_chain(screw, force, angle) -> ScrewBallChain:
    """Balls that touch, but for the last one and the first."""
    return screw_ball_chain(screw, force, screw.normals(angle), np.append(np.zeros(len(force) - 1), np.inf))


@pytest.mark.parametrize("make", [source_cases.pair_as_printed, source_cases.oversized_pair])
@pytest.mark.parametrize("coupling", ["none", "ball", "ball and screw"])
def test_pair_in_equilibrium(make, coupling: str) -> None:
    """All balls with ball-to-ball force and friction; energy; complementarity."""
    pair = replace(make(TWO), coupling=coupling)
    r = run.solve_pair_of_screw_balls(pair)
    assert r.converged
    t = r.touching
    assert t.motion.input_power == pytest.approx(t.motion.loss, rel=1e-8)
    assert r.apart.motion.input_power == pytest.approx(r.apart.motion.loss, rel=1e-8)
    assert r.approach_speed_when_apart > 0.0
    assert t.motion.q[0, 0] == pytest.approx(t.motion.q[1, 0], rel=1e-11)
    assert r.force > 0.0
    n, g = SCREW.normals(t.loads_with_friction.angle), SCREW.pair
    w = g.first_ball_surface_speeds @ t.motion.q[0] - g.second_ball_surface_speeds @ t.motion.q[1]
    rub = SCREW.mu * r.force * w / np.linalg.norm(w)
    for k, sign in ((0, -1.0), (1, 1.0)):
        pushed = r.force * g.force_directions[k] + sign * rub @ g.tangent_directions[k]
        assert pushed == pytest.approx(t.motion.neighbour_forces[k], rel=1e-6, abs=1e-9)
        moment = t.motion.wrench[k, :, 3:].sum(axis=0) + np.cross(-SCREW.ball_radius * g.force_directions[k], pushed)
        moment += np.cross(SCREW.ball_radius * n[k], t.motion.wrench[k, :, :3]).sum(axis=0)
        assert np.abs(moment).max() < 1e-7 * SCREW.ball_radius * t.loads_with_friction.force.sum()
        force = t.motion.wrench[k, :, :3].sum(axis=0) + pushed - t.loads_with_friction.force[k] @ n[k]
        seen = force if coupling != "none" else force[[1]]
        assert np.abs(seen).max() < 1e-7 * t.loads_with_friction.force.sum()


def test_reversed_motion_parts_the_pair() -> None:
    r = run.solve_pair_of_screw_balls(replace(PAIR, groove=BACK))
    assert r.force == 0.0
    assert r.touching.motion.q[1, 0] > r.touching.motion.q[0, 0]
    assert r.touching.motion.loss == pytest.approx(r.apart.motion.loss, rel=1e-9)
    same = run.solve_pair_of_screw_balls(replace(source_cases.oversized_pair(0.0), coupling="none"))
    assert same.force == pytest.approx(0.0, abs=1e-6)


def many(name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Contact forces and angles of balls whose angles, or loads too, vary along the chain; some without load."""
    force, at = np.tile(STATES[name][0], (count, 1)), np.arange(count)[:, None]
    if name == "four":
        return force, STATES["four"][1] + np.radians(5.0) * np.sin(at) * np.array(run.BOTH)
    force *= 1.0 + 0.5 * np.sin(at)
    force[[10, 11, 12, 20, 21]] = 0.0
    return force, np.full((count, 4), np.pi / 4) + 0.01 * np.cos(at)


@pytest.mark.parametrize("load", [2e-5, 1.0, 2e3])
@pytest.mark.parametrize(("name", "count"), [("four", 2), ("four", 60), ("two", 30)])
def test_chains_converge(name: str, count: int, load: float) -> None:
    """Four contacts; and two with balls without load, as roundness errors make them: some contacts stick there."""
    force, angle = many(name, count)
    r = solve_motion_of_chain(open_chain(SCREW, load * force, angle))
    assert r.converged
    assert r.largest_gap_violation < 1e-10 * SCREW.speed
    assert np.all(r.ball_force >= 0.0)
    assert np.max(r.ball_force[:-1] * np.diff(r.q[:, 0])) < 1e-9 * SCREW.speed * load * 100.0
    assert r.input_power == pytest.approx(r.loss, rel=1e-8)


def test_the_load_that_a_force_and_its_losses_imply_is_the_one_whose_losses_they_are() -> None:
    force, load = 3.0, 120.0
    each = solve_ball_motion(SCREW, np.full(4, load / 4.0), np.full(4, SCREW.contact_angle)).motion.loss
    increase = 0.5 * SCREW.mu * force * run.pair_sliding_speed(PAIR) / each
    assert run.load_implied_by_ball_force(PAIR, force, increase) == pytest.approx(load, rel=1e-8)


def test_radial_part_of_the_ball_force_keeps_its_sign() -> None:
    """Lin 3.75 calls the force on ball 2 opposite; its radial part is not."""
    push = SCREW.pair.force_directions
    assert push[0, 0] == pytest.approx(push[1, 0], rel=1e-13)
    assert push[0, 0] > 0.1
    assert push[0, 1:] == pytest.approx(-push[1, 1:], rel=1e-13)
