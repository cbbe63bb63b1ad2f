"""Kernels of several rolling sets: energy and its slope, Hessians, the envelope, the rollers' law."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, double_nut, nut
from tests.helpers import relative

from rollbench.compare.models.registry import MODELS
from rollbench.lowfi import jit
from rollbench.lowfi.rollers import LineLaw
from rollbench.lowfi.statics.axis import sides
from rollbench.lowfi.statics.axis.solve import prepare
from rollbench.lowfi.statics.axis.system import build, moved_flanks, tapered
from rollbench.lowfi.statics.kernel import axis, axis_matrix, ball, newton, rollers, skyline
from rollbench.lowfi.statics.kernel_types import Slopes
from rollbench.meshes.axis import Housing, Joint, RollingSet, diagonal
from rollbench.meshes.parts import Load

SPRINGS = diagonal((4e8, 5e8, 6e8, 2e5, 3e5, 4e5))


def mixed():
    """A nut, a ball bearing and rollers in two housings on springs, joined to one another."""
    roller = RollingSet("r", "tapered roller bearing", ROLLERS, 0.25, "b", thrust="+z", offset=-6e-6)
    sets = nut("n", 0.13, housing="a", offset=3e-6), bearing("k", 0.03, "-z", housing="b", offset=5e-6), roller
    housings = Housing("a", 0.14, (), SPRINGS, (10.0, 20.0, -30.0)), Housing("b", 0.2, (("rz", 0.0),), SPRINGS)
    joint = Joint("a", "b", 0.17, SPRINGS)
    return replace(assembly(*sets), housings=housings, joints=(joint,), loads=(Load(0.06, (100.0, 50.0, 400.0)),))


@pytest.fixture(scope="module", params=["lin", "lin-source-partition"])
def ready(request):
    parts = MODELS[request.param].of_assembly(mixed())
    prepared = prepare(build(parts), jit.kernels(jit.STATICS, compiled=False))
    prepared.iterate()
    rng = np.random.default_rng(1)
    prepared.state.q[:] += rng.normal(0.0, 2e-7, prepared.state.q.shape)
    n, lengths = prepared.system.structure.nodes.size, prepared.system.axis.lengths
    moved = prepared.state.q[: n - 1].copy()
    moved[:, 0] += lengths * prepared.state.q[: n - 1, 4]
    moved[:, 1] -= lengths * prepared.state.q[: n - 1, 3]
    prepared.state.d[:] = prepared.state.q[1:n] - moved
    return prepared


def evaluated(prepared, step=None, t=0.0):
    s, state = prepared.system, prepared.state
    out = Slopes(np.zeros(state.q.shape), np.zeros((s.contacts.r_ball.size, 8, 8)))
    q, d = state.q.copy(), state.d.copy()
    if step is not None:
        newton.advance(s.axis, state, q, d, step, t)
    energy, _ = axis.evaluate_axis(prepared.given, state, out)
    state.q[:], state.d[:] = q, d
    return energy, out


def test_gradient_is_the_slope_of_the_energy_and_the_matrix_that_of_the_gradient(ready):
    s = ready.system
    step = np.random.default_rng(2).normal(0.0, 1e-7, ready.state.q.shape)
    step[s.structure.fixed] = 0.0
    _, out = evaluated(ready)
    assert (ready.state.slices[:, 0] > 0.0).any()
    ends = [evaluated(ready, step, t) for t in (-1e-2, 1e-2)]
    slope = (ends[1][0] - ends[0][0]) / 2e-2
    assert slope == pytest.approx(float((out.gradient * step).sum()), rel=1e-6)
    change = (ends[1][1].gradient - ends[0][1].gradient) / 2e-2
    evaluated(ready)
    values = np.zeros(s.axis.start[-1])
    axis_matrix.add_axis(values, s.axis)
    axis_matrix.add_balls(values, s.axis, s.contacts, out.hessians)
    axis_matrix.add_rollers(values, s.axis, s.slices, ready.state.slices)
    lines = full(values, s.axis)
    place = (6 * s.axis.place[:, None] + np.arange(6)).ravel()
    placed = np.zeros(len(lines))
    placed[place] = step.ravel()
    product = (lines @ placed)[place].reshape(step.shape)
    free = ~s.structure.fixed
    assert relative(product[free], change[free]) < 1e-5


def full(values, arrays):
    """Symmetric matrix of an envelope."""
    n = arrays.first.size
    out = np.zeros((n, n))
    for i in range(n):
        j = np.arange(arrays.first[i], i + 1)
        out[i, j] = out[j, i] = values[arrays.start[i] + j]
    return out


def test_both_ways_of_adding_the_balls_agree_and_the_envelope_is_factored_as_the_full_matrix(ready):
    s = ready.system
    _, out = evaluated(ready)
    values, other = np.zeros((2, s.axis.start[-1]))
    axis_matrix.add_balls(values, s.axis, s.contacts, out.hessians)
    axis_matrix.loop_balls(other, s.axis, s.contacts, out.hessians)
    assert relative(other, values) < 1e-13
    axis_matrix.add_axis(values, s.axis)
    axis_matrix.hold(values, s.axis, np.full(6, 1e3))
    matrix, b = full(values, s.axis), np.random.default_rng(3).normal(size=s.axis.first.size)
    for factor, solve in ((skyline.row_factor, skyline.row_solve), (skyline.factor, skyline.substitute)):
        found, x = values.copy(), b.copy()
        assert factor(found, s.axis.first, s.axis.start)
        solve(found, s.axis.first, s.axis.start, x)
        assert relative(matrix @ x, b) < 1e-7
        broken = values.copy()
        broken[s.axis.start[7] + 7] = -1.0
        assert not factor(broken, s.axis.first, s.axis.start)


def test_hessian_of_four_flanks_holds_that_of_the_screws(ready):
    evaluated(ready)
    for contact in ready.state.contact[::3]:
        whole, half = np.zeros((8, 8)), np.zeros((4, 4))
        ball.flank_hessian(contact, whole)
        ball.flank_hessian(contact, half)
        assert relative(whole[:4, :4], half) < 1e-13 if half.any() else not whole[:4, :4].any()
        shifted = whole.reshape(8, 4, 2).sum(axis=1)  # all flanks together: the ball follows
        assert np.abs(shifted).max() <= 1e-12 * max(1.0, np.abs(whole).max())


def test_law_of_a_slice_is_that_of_the_bearings():
    law = tapered(ROLLERS).law()
    exact = LineLaw(law.g, law.s)
    for delta in (1e-8, 3e-6, 2e-5):
        load, slope, energy = rollers.roller_law(delta, float(law.g), law.s)
        assert load == pytest.approx(float(exact.line_load(delta)), rel=1e-12)
        assert slope == pytest.approx(float(exact.slope(load)), rel=1e-12)
        assert energy == pytest.approx(float(exact.energy(load)), rel=1e-12)


def test_law_of_a_slice_goes_on_smoothly_beyond_its_range():
    law = tapered(ROLLERS).law()
    edge = np.exp(float(law.g) / law.s - 4.0)
    delta = edge * (float(law.g) - law.s * np.log(edge))
    low, high = (rollers.roller_law(delta * t, float(law.g), law.s) for t in (1.0 - 1e-9, 1.0 + 1e-9))
    assert np.allclose(low, high, rtol=1e-7)
    beyond = rollers.roller_law(2.0 * delta, float(law.g), law.s)
    assert (beyond[2] - high[2]) / delta == pytest.approx(0.5 * (beyond[0] + high[0]), rel=1e-6)


def test_compiled_kernels_find_the_same():
    parts = double_nut()
    found = []
    for compiled in (False, True):
        prepared = prepare(build(parts), jit.kernels(jit.STATICS, compiled=compiled))
        outcome = prepared.iterate()
        assert outcome.status == 0
        found.append(prepared.state.contact[..., 0].copy())
    assert relative(found[1], found[0]) < 1e-11


def test_a_flank_between_nodes_moves_with_a_shaft_that_turns_as_one():
    """Whether or not the stations of its contacts are nodes."""
    prepared = prepare(build(double_nut()), jit.kernels(jit.STATICS, compiled=False))
    system, q = prepared.system, np.zeros_like(prepared.state.q)
    z, turn = system.structure.nodes, np.array([2e-5, -1e-5, 3e-5])
    q[: z.size, 3:] = turn
    q[: z.size, :3] = np.array([3e-6, 1e-6, -2e-6]) + np.cross(turn, np.stack([0.0 * z, 0.0 * z, z], axis=-1))
    for b in system.balls:
        for s in range(2):
            assert relative(sides._flank_motion(system, b, s, q), moved_flanks(b, q)[:, s]) < 1e-12
