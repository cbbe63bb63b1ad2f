"""Balls that one diagonal pair holds, in closed form: against the ball's own minimum and its reduced stiffness."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import FLANK_ERRORS, NO_PROFILES, small_screw

from rollbench.comparison.scenes import catalogue
from rollbench.lowfi import jit
from rollbench.lowfi.statics.problem import build
from rollbench.lowfi.statics.records import BeamSlopes
from rollbench.lowfi.statics.static import iterate, prepare
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors

PAIRS = {"SL and NR": (0, np.array([True, False, False, True])), "SR and NL": (1, np.array([False, True, True, False]))}


def system(use, engine, errors=FLANK_ERRORS):
    """Arrays of a small screw whose balls are partly loose, at random motions of its nodes."""
    scene = small_screw(count=9)
    balls = BallErrors(listed=tuple((i + 1, 2e-6 * (i - 4)) for i in range(9)))
    scene = replace(scene, errors=replace(errors, balls=balls, **NO_PROFILES))
    layout = ball_layout(scene)
    problem = build(scene, specimen(scene, layout), layout, use)
    prepared = prepare(problem, jit.kernels(jit.STATICS, compiled=engine == "compiled"))
    rng = np.random.default_rng(5)
    prepared.state.q[0] = np.concatenate([rng.normal(0.0, 2e-6, 3), rng.normal(0.0, 2e-5, 3)])
    prepared.state.d[:] = rng.normal(0.0, 1e-7, prepared.state.d.shape)
    return prepared


def evaluated(prepared):
    """Energy, largest force, and slopes."""
    n, count = prepared.state.q.shape[0], prepared.contacts.node.shape[0]
    out = BeamSlopes(np.empty((n, 6)), np.zeros((count, 4, 4)))
    return (*prepared.engine.evaluate(prepared.beam, prepared.contacts, prepared.state, out), out)


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
@pytest.mark.parametrize("name", PAIRS)
def test_closed_form_is_the_minimum_over_the_centre(name, engine):
    pair, use = PAIRS[name]
    prepared = system(use, engine)
    contacts, state, kernels = prepared.contacts, prepared.state, jit.kernels(jit.STATICS, compiled=False)
    _, scale, out = evaluated(prepared)
    assert kernels.pair.pair_alone(contacts) == pair
    loaded, motion = 0, state.q.ravel()
    for i in range(len(contacts.r_ball)):
        shift = np.zeros((4, 2))
        start = 6 * contacts.node[i, pair]
        shift[pair] = contacts.B[i, pair] @ motion[start : start + 6]
        p, contact, hessian = np.zeros(2), np.zeros((4, 5)), np.zeros((4, 4))
        at = contacts.geometry[i], contacts.closure[i], contacts.r_ball[i], contacts.profile, contacts.tiny
        kernels.settle_ball(p, shift, *at, contact)
        kernels.ball.reduced_hessian(contact, hessian)
        own = contact[:, 0] > 0.0
        assert np.array_equal(state.contact[i, :, 0] > 0.0, own)
        if not own.any():  # it stands free of both flanks
            moved = np.array([state.p[i] - shift[k] for k in (pair, 3 - pair)])
            at_rest = contacts.geometry[i, [pair, 3 - pair]]
            assert np.all(np.hypot(*(at_rest[:, :2] + moved).T) - at_rest[:, 2] + at_rest[:, 3] < 0.0)
            continue
        assert state.p[i] == pytest.approx(p, abs=1e-18)
        assert out.hessians[i] == pytest.approx(hessian, rel=1e-9, abs=1e-11 * np.abs(hessian).max())
        assert state.contact[i][own] == pytest.approx(contact[own], rel=1e-10)
        assert scale >= contact[:, 0].max()
        loaded += 1
    assert 2 <= loaded < len(contacts.r_ball)


@pytest.mark.parametrize("name", PAIRS)
def test_balls_by_themselves_and_what_an_earlier_state_left(name):
    """Force and stiffness of a ball that is free now are none, whatever they were; the scale is the largest force."""
    pair, use = PAIRS[name]
    prepared = system(use, "interpreted")
    contacts, state = prepared.contacts, prepared.state
    _, _, out = evaluated(prepared)
    forces, energy = state.contact[:, :, 0].copy(), 5.0
    free = forces.max(axis=1) == 0.0
    state.contact[:], out.hessians[:, 2 * pair : 2 * pair + 2, 2 * pair : 2 * pair + 2] = 7.0, 7.0
    found, scale = prepared.engine.pair.add_pairs(contacts, state, out, pair, energy, 0.0)
    assert found > energy
    assert scale == forces.max() > 0.0
    assert free.any()
    assert not state.contact[free, :, 0].any()
    assert not out.hessians[free].any()
    assert prepared.engine.pair.add_pairs(contacts, state, out, pair, 0.0, 2.0 * scale)[1] == 2.0 * scale


@pytest.mark.parametrize("name", PAIRS)
def test_gradient_is_the_slope_of_the_energy(name):
    prepared = system(PAIRS[name][1], "interpreted")
    _, _, out = evaluated(prepared)
    gradient, q = out.gradient.copy(), prepared.state.q[0].copy()
    for k in range(6):  # the whole screw moves: sums over all nodes of the forces and of their moments about the first
        h = 1e-9 if k < 3 else 1e-7
        energies = []
        for sign in (-1.0, 1.0):
            prepared.state.q[0] = q
            prepared.state.q[0, k] += sign * h
            energies.append(evaluated(prepared)[0])
        z = prepared.problem.nodes - prepared.problem.nodes[0]
        expected = gradient[:, k].sum()
        expected += {3: -z @ gradient[:, 1], 4: z @ gradient[:, 0]}.get(k, 0.0)
        slope = (energies[1] - energies[0]) / (2.0 * h)
        assert slope == pytest.approx(expected, rel=1e-4, abs=1e-4 * np.abs(gradient).max())


def test_other_flanks_or_profiles_are_left_to_the_general_ball():
    alone = jit.kernels(jit.STATICS, compiled=False).pair.pair_alone
    for use in ([1, 1, 1, 1], [1, 0, 1, 1], [1, 0, 0, 0], [1, 0, 1, 0]):
        assert alone(system(np.array(use, dtype=bool), "interpreted", Errors()).contacts) == -1
    held = system(PAIRS["SL and NR"][1], "interpreted").contacts
    assert alone(held) == 0
    assert alone(held._replace(profile=np.zeros((4, 2)))) == -1
    same = held.geometry.copy()
    same[4, 3, :2] = same[4, 0, :2]
    assert alone(held._replace(geometry=same)) == -1


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
@pytest.mark.parametrize("name", PAIRS)
def test_even_pairs_are_the_tangent_where_all_carry_the_same(name, engine):
    """Force and stiffness are those of the energy where every ball has the interference of the even force, which balances
    the applied one; beside it the law is linear. A load that opens the pairs has none."""
    pair, use = PAIRS[name]
    prepared = system(use, engine)
    contacts, kernels = prepared.contacts, jit.kernels(jit.STATICS, compiled=engine == "compiled")
    B, geometry = contacts.B[:, pair], contacts.geometry
    line = geometry[:, 3 - pair, :2] - geometry[:, pair, :2]
    normal = line / np.hypot(*line.T)[:, None]
    one = np.einsum("nk,nkc->c", normal, B[:, :, :3])
    force, size = 130.0, prepared.state.q.size
    load = np.zeros((size // 6, 6))
    load[0, :3], load[1, :3] = 0.25 * force * one, 0.75 * force * one
    contacts.closure[:, pair] = (geometry[:, pair, 4] + geometry[:, 3 - pair, 4]) * force ** (2.0 / 3.0)
    prepared.state.q[:], prepared.state.d[:], prepared.beam.load[:] = 0.0, 0.0, 0.0
    _, scale, out = evaluated(prepared)
    assert scale == pytest.approx(force, rel=1e-12)
    step, hessians = np.zeros(size), np.zeros_like(out.hessians)
    assert kernels.pair.even_pairs(contacts, pair, load, np.zeros(size), hessians, step)
    np.testing.assert_allclose(hessians, out.hessians, rtol=1e-12, atol=1e-12 * out.hessians.max())
    np.testing.assert_allclose(-step, out.gradient.ravel(), rtol=0, atol=1e-12 * force)
    motion, beside = np.random.default_rng(2).normal(0.0, 1e-6, size), np.zeros(size)
    contacts.closure[:, pair] += 2e-6
    kernels.pair.even_pairs(contacts, pair, load, motion, hessians, beside)
    expected = -step
    for i, (node, own) in enumerate(zip(contacts.node[:, pair], B, strict=True)):
        v = own @ motion[6 * node : 6 * node + 6] + 2e-6 * normal[i]
        at = 2 * pair + np.arange(2)
        expected[6 * node : 6 * node + 6] += (hessians[i][np.ix_(at, at)] @ v) @ own
    np.testing.assert_allclose(-beside, expected, rtol=0, atol=1e-12 * force)
    assert not kernels.pair.even_pairs(contacts, pair, -load, motion, np.zeros_like(hessians), beside)


def test_a_cold_solve_takes_two_factors(monkeypatch):
    """Even loads are within a thousandth of the solution of case 1, and their factor serves the first step."""
    kernels = jit.kernels(jit.STATICS, compiled=False)
    factors, factor = [], kernels.newton.factor_band
    monkeypatch.setattr(kernels.newton, "factor_band", lambda band: factors.append(1) or factor(band))
    scene = catalogue.scene("lin-case1")
    layout = ball_layout(scene)
    prepared = prepare(build(scene, specimen(scene, layout), layout, PAIRS["SL and NR"][1]), kernels, tolerance=1e-10)
    outcome = iterate(prepared)
    assert (outcome.status, len(factors), outcome.evaluations) == (0, 2, 4)
    assert prepared.history[0] < 1e-3
    assert prepared.history[1] < 0.1 * prepared.history[0]
    assert outcome.residual < 1e-11
