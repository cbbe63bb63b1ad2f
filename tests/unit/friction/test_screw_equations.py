"""Equations of the balls of a screw: derivatives by differences, linear systems of a ring."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cases.lin.evidence.source_cases import oversized_pair, screw_groove
from rollbench.lowfi.friction.screw import balance, joint, neighbours
from rollbench.lowfi.friction.screw.chain import BalanceSearch, ScrewBallChain, screw_ball_chain
from rollbench.lowfi.friction.screw.coupled import loads_and_motion_system
from rollbench.lowfi.friction.screw.motion import arrays_for_contact_loads, solve_screw_contact_loads

TWO = np.radians(2.0)


def ring_times(ring: neighbours.RingMatrix, d: np.ndarray) -> np.ndarray:
    """Product of the matrix of a whole ring with one vector for each ball (N, b)."""
    times = [(block @ d_of[..., None])[..., 0] for block, d_of in zip(ring, (d, np.roll(d, -1, axis=0), d), strict=True)]
    return times[0] + times[1] + np.roll(times[2], 1, axis=0)


def balls_in_motion(rng: np.random.Generator, count: int = 5) -> tuple[ScrewBallChain, np.ndarray, np.ndarray]:
    """Balls under unlike loads, one without load, and a motion and forces in which some press on each other."""
    groove = replace(screw_groove(), mu_balls=0.3)
    force = rng.uniform(5.0, 50.0, (count, 4))
    force[2] = 0.0
    normals = groove.normals(groove.contact_angle + rng.uniform(-0.05, 0.05, (count, 4)))
    chain = screw_ball_chain(groove, force, normals, np.array([0.0, 0.3, np.inf, 0.0, 1.0])[:count])
    x = np.array([0.6, -0.4, 0.2, 1.1]) + rng.normal(size=(count, 4)) * 0.1
    return chain, x, rng.uniform(-0.1, 0.4, count)


def test_balance_of_balls_by_differences(rng: np.random.Generator) -> None:
    chain, x, f = balls_in_motion(rng)
    s, law, h = BalanceSearch(chain), balance.Smoothing(0.05, 0.7, 1e-3, 0.1), 1e-6

    def residual(t: float) -> np.ndarray:
        at = balance.force_balance(s.track, s.in_motion(x + t * dx), f + t * df, law)
        return np.column_stack([at.forces, at.gaps.value])

    for _ in range(3):
        dx, df = rng.normal(size=x.shape), rng.normal(size=f.shape)
        balls = s.in_motion(x)
        matrix = balance.jacobian(s.track, balls, f, balance.force_balance(s.track, balls, f, law), law)
        slope = (residual(h) - residual(-h)) / (2.0 * h)
        assert ring_times(matrix, np.column_stack([dx, df])) == pytest.approx(slope, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("share", [0.0, 0.7, 1.0])
def test_loads_and_motion_by_differences(share: float, rng: np.random.Generator) -> None:
    """All unknowns at once, the free motions of the screw among them."""
    pair = replace(oversized_pair(TWO), oversize=4e-6, free="rz", force=(3.0, 50.0))
    cell = pair.balls_with_loads()
    load = solve_screw_contact_loads(cell)
    chain = screw_ball_chain(cell.groove, load.force, cell.groove.normals(load.angle), np.array([0.1, np.inf]))
    system, eps, h = loads_and_motion_system(arrays_for_contact_loads(cell), cell, BalanceSearch(chain)), 0.05, 1e-5
    x, f = np.array([0.6, -0.4, 0.2, 1.1]) + rng.normal(size=(2, 4)) * 0.1, np.array([0.3, 0.0])
    at, unit = joint.LoadsAndMotionUnknowns(*load.displacements, x, f), system.position_unit
    d = joint.LoadsAndMotionUnknowns(*(rng.normal(size=part.shape) for part in at))
    step = d._replace(ball=d.ball * unit, screw=d.screw * unit)
    now, up, down = (joint.loads_and_motion_equations(system, at.moved(step, t), share, eps) for t in (0.0, h, -h))
    of_ball = np.column_stack([d.ball, d.motion, d.ball_force])
    balls = ring_times(now.ring, of_ball) + now.balls_by_screw @ d.screw
    screw = np.einsum("qki,ki->q", now.screw_by_balls, of_ball) + now.screw_by_screw @ d.screw
    assert balls == pytest.approx((up.balls - down.balls) / (2.0 * h), rel=1e-6, abs=1e-6 * np.abs(balls).max())
    assert screw == pytest.approx((up.screw - down.screw) / (2.0 * h), rel=1e-6, abs=1e-6 * np.abs(screw).max())


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_ring_cut_open_solves_its_system(count: int, rng: np.random.Generator) -> None:
    """Without the coupling across the cut, wherever it is; ill-placed zeros on the diagonal need row exchange."""
    ring, side = neighbours.RingMatrix(*rng.normal(size=(3, count, 4, 4))), rng.normal(size=(count, 4, 2))
    ring.own[:, 0, 0] = 0.0
    for start in range(count):
        last = (start - 1) % count
        cut = neighbours.RingMatrix(*(block.copy() for block in ring))
        cut.right[last], cut.below[last] = 0.0, 0.0
        at = neighbours.CutTracks((start + np.arange(count)) % count, np.array([count - 1]))
        found, (sign,) = neighbours.solve_rings_cut_open(ring, side, at)
        whole = [ring_times(cut, unit.reshape(count, 4)).ravel() for unit in np.eye(4 * count)]
        assert sign == np.linalg.slogdet(np.array(whole))[0]
        for c in range(2):
            assert ring_times(cut, found[..., c]) == pytest.approx(side[..., c], rel=1e-8, abs=1e-8)
