"""Simulations over time of random screws and bearings: energy, order of the balls, loads, whatever meets and leaves."""

from dataclasses import replace

import numpy as np
import pytest
from tests.friction_runs import WAVES, balls_keep_their_order, crowded, setting, sparse

from rollbench.lowfi.friction.screw.travel import simulate
from rollbench.meshes.parts import BallErrors, Friction, Motion


def random_scene(rng):
    """Two in three: a screw whose balls almost touch; else a bearing with balls apart; sizes and coefficients at random."""
    count = int(rng.integers(3, 8))
    sizes = BallErrors(oversize=4e-6, sigma=1e-6, distribution="uniform")
    if rng.integers(3) == 0:
        scene = sparse(count)
    else:
        hand = ("right", "left")[rng.integers(2)]
        scene = crowded(clearance=float(rng.choice([1e-4, 1e-3])), count=count, hand=hand)
        way = {"returning": int(rng.integers(4)), "filling": float(rng.uniform(0.5, 0.9))}
        scene = replace(scene, circulation=replace(scene.circulation, **way))
    scene = replace(scene, errors=replace(WAVES, balls=sizes, seed=int(rng.integers(1000))))
    screw, nut = (float(v) for v in rng.choice([0.01, 0.1, 0.3], 2))
    friction = Friction(screw, nut, balls=float(rng.choice([0.0, 0.1, 0.2])), feedback=False)
    motion = Motion(float(rng.choice([-20.0, 1.0, 300.0])), ("screw", "nut")[rng.integers(2)])
    return scene, friction, motion


@pytest.mark.parametrize("seed", range(12))
def test_energy_order_and_forces(seed):
    rng = np.random.default_rng(seed)
    scene, friction, motion = random_scene(rng)
    h = simulate(setting(scene, friction, motion), 0.8 / abs(motion.speed), 8)
    assert h.fully_converged, h.status
    # a groove that is rougher than the other one holds its contacts at rest, found to 1e-9 of mu F at a small loss
    near = 1e-8 if friction.screw == friction.nut else 1e-7
    losses = h.torque * abs(h.turning_and_axial_speed[0])
    assert np.abs(h.imbalance).max() < near
    assert np.abs(h.power_balance_on_screw / losses).max() < near
    assert h.axial == pytest.approx(np.full(h.time.size, scene.loads[0].force[2]), rel=1e-8)
    balls_keep_their_order(h, 1e-9)
    assert np.all(h.load[~h.loaded] == 0.0)
    assert np.all(h.torque > 0.0)
