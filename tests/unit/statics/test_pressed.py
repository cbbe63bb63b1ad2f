"""Many specimens from one start: by the motions of the flanks alone, and by the stiffness of the start."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi import jit
from rollbench.lowfi.statics import pressed as module
from rollbench.lowfi.statics.pressed import pressed
from rollbench.lowfi.statics.problem import build, distances, hertz_C
from rollbench.lowfi.statics.records import MemberArrays, MemberStates
from rollbench.lowfi.statics.static import iterate, prepare
from rollbench.meshes.errors import specimen, specimens
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors, FourierTerm, SideErrors

PAIR = np.array([True, False, False, True])
ALL = np.ones(4, dtype=bool)
#: Pitch and roundness errors of the screw's flanks: lever arms of their own.
OWN_ARMS = {
    "SL": SideErrors(pitch=(FourierTerm(1.0, sigma=1e-6),)),
    "SR": SideErrors(roundness=(FourierTerm(2.0, sigma=1e-6),)),
}


def ready(sigma=1e-6, use=PAIR, oversize=1e-6, engine="compiled", sides=None):
    """A screw of nine balls in its solution without random errors, and the scene with them; sides: errors of flanks."""
    scene = replace(small_screw(9, force=(0.0, 30.0, 1500.0)), errors=Errors(balls=BallErrors(oversize=oversize)))
    layout = ball_layout(scene)
    prepared = prepare(
        build(scene, specimen(scene, layout), layout, use), jit.kernels(jit.STATICS, compiled=engine == "compiled")
    )
    iterate(prepared)
    prepared.options = prepared.options._replace(tolerance=1e-11)
    errors = Errors(balls=BallErrors(oversize=oversize, sigma=sigma), seed=3, **(sides or {}))
    return prepared, replace(scene, errors=errors), layout


def one_by_one(prepared, scene, layout, count):
    """Solutions of the same specimens by Newton's method, each from its own linear start."""
    found = []
    for m in range(count):
        single = prepare(build(scene, specimen(scene, layout, m), layout, prepared.problem.use), prepared.engine)
        assert iterate(single).status == 0
        found.append(single)
    return found


def solved_at_once(prepared, scene, layout, count, functions):
    quick, drawn, given = pressed(prepared, functions), specimens(scene, layout, 0, count), prepared.problem.geometry
    offset, closure = distances(scene, drawn)
    geometry = np.empty((count, *given.shape))
    geometry[..., :4], geometry[..., 5:] = offset, given[..., 5:]
    geometry[..., 4] = hertz_C(scene, prepared.problem.drawn, drawn.ball_radius)
    return quick, quick.solve(MemberArrays(None, geometry, closure, drawn.ball_radius), drawn.centre)


@pytest.mark.parametrize("engine", ["interpreted", "compiled"])
@pytest.mark.parametrize(
    ("use", "oversize", "sides"),
    [
        pytest.param(PAIR, 1e-6, {}, id="one pair"),
        pytest.param(PAIR, 1e-6, OWN_ARMS, id="one pair, own lever arms"),
        pytest.param(ALL, 7e-6, {}, id="four flanks"),
        pytest.param(ALL, 7e-6, OWN_ARMS, id="four flanks, own lever arms"),
    ],
)
def test_flanks_alone_give_what_the_whole_screw_gives(engine, use, oversize, sides):
    prepared, scene, layout = ready(0.5e-6 if use.all() else 1e-6, use, oversize, engine, sides)
    size = prepared.state.q.size
    quick, found = solved_at_once(prepared, scene, layout, 4, np.eye(size))
    assert not found.status.any()
    assert found.residual.max() <= 1e-11
    nominal = prepared.force.max()
    motions = quick.functions(found.pull)
    for m, single in enumerate(one_by_one(prepared, scene, layout, 4)):
        assert np.abs(single.force - prepared.force).max() > 0.02 * nominal  # the errors matter
        np.testing.assert_allclose(found.force[m], single.force, rtol=0, atol=1e-9 * nominal)
        np.testing.assert_allclose(found.p[m], single.state.p, rtol=0, atol=1e-9 * np.abs(single.state.p).max())
        q = single.state.q.ravel()
        np.testing.assert_allclose(motions[m], q, rtol=0, atol=1e-8 * np.abs(q).max())


@pytest.mark.parametrize(("steps", "solved"), [(3, False), (6, True)])
def test_soft_modes_save_steps(monkeypatch, steps, solved):
    """Without them the same specimens take seven or more."""
    prepared, scene, layout = ready(1e-6, ALL, 7e-6, "interpreted", OWN_ARMS)
    monkeypatch.setattr(prepared.engine.flanks, "STEPS", steps)
    _, found = solved_at_once(prepared, scene, layout, 8, np.zeros((0, prepared.state.q.size)))
    assert found.status.any() is np.bool_(not solved)


def test_residual_bounds_that_of_the_nodes():
    """With the first step taken only, the unbalanced force at a node is below the bound."""
    prepared, scene, layout = ready()
    loose = prepared.options._replace(tolerance=1e-3)
    prepared.options = loose
    size = prepared.state.q.size
    quick, found = solved_at_once(prepared, scene, layout, 4, np.eye(size))
    exact = one_by_one(prepared, scene, layout, 4)
    assert np.all(found.residual <= 1e-3)
    assert found.residual.max() > 1e-6
    for m, single in enumerate(exact):
        single.state.q[:] = quick.functions(found.pull)[m].reshape(-1, 6)
        lengths = np.diff(single.problem.nodes)
        q = single.state.q
        moved = q[:-1].copy()
        moved[:, 0] += lengths * q[:-1, 4]
        moved[:, 1] -= lengths * q[:-1, 3]
        single.state.d[:] = q[1:] - moved
        iterate(replace_tolerance(single), start=False)
        assert single.history[0] <= found.residual[m] * 1.0001
        assert single.history[0] >= 0.05 * found.residual[m]


def replace_tolerance(single):
    single.options = single.options._replace(tolerance=1e-14)
    return single


def test_specimens_far_from_the_start_are_not_claimed():
    prepared, scene, layout = ready(sigma=60e-6)
    _, found = solved_at_once(prepared, scene, layout, 20, np.eye(prepared.state.q.size))
    assert found.status.any()
    for m, single in enumerate(one_by_one(prepared, scene, layout, 20)):
        if found.status[m] == 0:
            np.testing.assert_allclose(found.force[m], single.force, rtol=0, atol=1e-9 * single.force.max())


def test_what_the_flanks_alone_do_not_serve(monkeypatch):
    functions = np.zeros((0, ready()[0].state.q.size))
    assert pressed(ready()[0], functions) is not None
    unloaded = ready()[0]
    unloaded.options = unloaded.options._replace(floor=0.0)
    assert pressed(unloaded, functions) is None
    monkeypatch.setattr(module, "LARGEST", 8)
    assert pressed(ready()[0], functions) is None


@pytest.mark.parametrize("sigma", [0.5e-6, 40e-6])
def test_newton_solves_specimens_of_four_flanks_from_the_start_of_all(sigma):
    prepared, scene, layout = ready(sigma, ALL, oversize=7e-6)
    count = 6
    singles = one_by_one(prepared, scene, layout, count)
    arrays = MemberArrays(
        *(np.stack([getattr(s.contacts, n) for s in singles]) for n in ("B", "geometry", "closure", "r_ball"))
    )
    q, p = prepared.state.q, prepared.state.p
    found = MemberStates(
        np.empty((count, 9, 4)),
        np.empty(count, dtype=np.int64),
        np.empty(count),
        *(np.empty((count, *x.shape)) for x in (q, p)),
    )
    prepared.engine.ensemble(prepared.beam, prepared.contacts, prepared.state, prepared.options, arrays, found)
    assert not found.status.any()
    for m, single in enumerate(singles):
        np.testing.assert_allclose(found.force[m], single.force, rtol=0, atol=1e-9 * single.force.max())
