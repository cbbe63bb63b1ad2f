"""The energy is convex: every start leads to the same forces, and chords lie above it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.helpers import FLANK_ERRORS, prepared, relative, small_screw
from tests.static_problems import SCENES

from rollbench.lowfi.statics.kernel_types import EnergyDerivatives
from rollbench.lowfi.statics.static import solve_static

pytestmark = pytest.mark.xdist_group("convexity")

HELD = (("ux", 0.0), ("uz", 0.0), ("rx", 0.0))


@cache
def solution(case):
    """Kernels' arguments, and the state and forces from the usual start."""
    ready = prepared(SCENES[case], "compiled")
    assert ready.solve_by_newton().residual <= 1e-10
    return ready, [x.copy() for x in ready.state], ready.contact_forces.copy()


def moved(ready, state, seed, size):
    """Put the arrays at a random state: rigid motion up to ``size`` [m], elements strained by a thousandth of it. Returns
    copies of motions and deformations."""
    rng = np.random.default_rng(seed)
    q, d = ready.state.q, ready.state.d
    q[:], d[:] = state[0], state[1]
    free, unit = ~ready.problem.fixed, np.array([1.0, 1.0, 1.0, 20.0, 20.0, 20.0])
    q[0] += np.where(free[0], size * rng.uniform(-1, 1, 6) * unit, 0.0)
    if ready.problem.rigid_motion_basis is None:
        # the held freedoms of other nodes keep their prescribed values: nodes move, deformations follow
        q[1:] = state[0][1:] + np.where(free[1:], q[0] - state[0][0], 0.0)
        q[1:] += np.where(free[1:], 1e-3 * size * rng.uniform(-1, 1, (q.shape[0] - 1, 6)) * unit, 0.0)
        lengths = ready.kernel_arrays.shaft.lengths
        rigid = q[:-1].copy()
        rigid[:, 0] += lengths * q[:-1, 4]
        rigid[:, 1] -= lengths * q[:-1, 3]
        d[:] = q[1:] - rigid
    return q.copy(), d.copy()


def energy(ready, q, d):
    ready.state.q[:], ready.state.d[:] = q, d
    out = EnergyDerivatives(np.empty_like(q), np.zeros((ready.problem.C.shape[0], 4, 4)))
    return ready.engine.evaluate_screw(ready.kernel_arrays, ready.state, out)[0], out.gradient


@pytest.mark.parametrize("case", SCENES)
@settings(max_examples=10, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), exponent=st.floats(-7.0, -3.5))
def test_random_starts_reach_the_same_forces(case, seed, exponent):
    ready, state, forces = solution(case)
    moved(ready, state, seed, 10.0**exponent)
    outcome = ready.solve_by_newton(False)
    assert outcome.status in (0, 1)
    assert outcome.residual <= 1e-10
    assert relative(ready.contact_forces, forces) < 1e-8


@pytest.mark.parametrize("case", SCENES)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(seeds=st.tuples(st.integers(0, 2**31), st.integers(0, 2**31)), exponent=st.floats(-8.0, -4.0))
def test_chords_lie_above_the_energy(case, seeds, exponent):
    """Midpoint convexity, and the tangent below: E(y) >= E(x) + g(x).(y - x)."""
    ready, state, _ = solution(case)
    (q0, d0), (q1, d1) = (moved(ready, state, seed, 10.0**exponent) for seed in seeds)
    (low, slope), (high, _) = energy(ready, q0, d0), energy(ready, q1, d1)
    middle, _ = energy(ready, (q0 + q1) / 2, (d0 + d1) / 2)
    rounding = 1e-12 * (abs(low) + abs(high)) + 1e-20
    assert middle <= (low + high) / 2 + rounding
    assert high >= low + float((slope * (q1 - q0)).sum()) - rounding - 1e-10 * float(np.abs(slope * (q1 - q0)).max())


@pytest.mark.parametrize("uneven", [False, True], ids=["arcs", "uneven"])
def test_clearance_with_uneven_flanks(uneven):
    """The gap closes from a cold start whether the flanks are arcs or not, at nearly the same loads."""
    scene = small_screw(13, lead=0.0, beta=0.64, oversize=-7.3e-6, force=(0.0, -870.0, 0.0), fixed=HELD)
    if uneven:
        scene = replace(scene, errors=replace(FLANK_ERRORS, balls=scene.errors.balls))
    result = solve_static(scene)
    assert result.status == "converged"
    assert 150.0 < result.load.max() < 300.0
