"""Kernels of several rolling sets: energy and its slope, Hessians, the envelope, the rollers' law."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, double_nut, nut
from tests.helpers import relative

from rollbench.compare.models.registry import MODELS
from rollbench.lowfi import jit
from rollbench.lowfi.statics.axis.solve import build_beam_assembly_equations, solve_assembly
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.kernel import axis, beam
from rollbench.lowfi.statics.kernel_types import EnergyDerivatives
from rollbench.meshes.axis import Housing, Joint, RollingSet, diagonal_stiffness
from rollbench.meshes.parts import Load

SPRINGS = diagonal_stiffness((4e8, 5e8, 6e8, 2e5, 3e5, 4e5))


def test_compiled_kernels_find_the_same():
    found = [solve_assembly(double_nut(), engine=engine) for engine in ("interpreted", "compiled")]
    assert {x.status for x in found} == {"converged"}
    for interpreted, compiled in zip(*(x.sets for x in found), strict=True):
        assert relative(compiled.balls.load, interpreted.balls.load) < 1e-11


def mixed():
    """A nut, a ball bearing and rollers in two housings on springs, joined to one another."""
    roller = RollingSet("r", "tapered roller bearing", ROLLERS, 0.25, "b", thrust="+z", offset=-6e-6)
    sets = nut("n", 0.13, housing="a", offset=3e-6), bearing("k", 0.03, "-z", housing="b", offset=5e-6), roller
    housings = Housing("a", 0.14, (), SPRINGS, (10.0, 20.0, -30.0)), Housing("b", 0.2, (("rz", 0.0),), SPRINGS)
    joint = Joint("a", "b", 0.17, SPRINGS)
    return replace(assembly(*sets), housings=housings, joints=(joint,), loads=(Load(0.06, (100.0, 50.0, 400.0)),))


@pytest.fixture(scope="module", params=["lin", "lin-source-partition"])
def ready(request):
    parts = build_assembly_arrays(MODELS[request.param].assembly_with_settings(mixed()))
    prepared = build_beam_assembly_equations(parts, jit.load_kernel_package(jit.STATICS, compiled=False))
    prepared.solve_by_newton()
    rng = np.random.default_rng(1)
    prepared.state.q[:] += rng.normal(0.0, 2e-7, prepared.state.q.shape)
    lengths = parts.structure_arrays.lengths
    moved = prepared.state.q[: lengths.size].copy()
    moved[:, 0] += lengths * moved[:, 4]
    moved[:, 1] -= lengths * moved[:, 3]
    prepared.state.d[:] = prepared.state.q[1 : lengths.size + 1] - moved
    return prepared


def evaluated(prepared, step=None, t=0.0):
    s, state = prepared.assembly_arrays, prepared.state
    out = EnergyDerivatives(np.zeros(state.q.shape), np.zeros((s.ball_arrays.r_ball.size, 8, 8)))
    q, d = state.q.copy(), state.d.copy()
    if step is not None:
        beam.advance_along_step(s.structure_arrays, state, q, d, step, t)
    energy, _ = axis.evaluate_axis(prepared.kernel_arrays, state, out)
    state.q[:], state.d[:] = q, d
    return energy, out


def test_gradient_is_the_slope_of_the_energy_and_the_matrix_that_of_the_gradient(ready):
    s = ready.assembly_arrays
    step = np.random.default_rng(2).normal(0.0, 1e-7, ready.state.q.shape)
    step[s.structure.fixed] = 0.0
    _, out = evaluated(ready)
    assert (ready.state.slices[:, 0] > 0.0).any()
    ends = [evaluated(ready, step, t) for t in (-1e-2, 1e-2)]
    slope = (ends[1][0] - ends[0][0]) / 2e-2
    assert slope == pytest.approx(float((out.gradient * step).sum()), rel=1e-6)
    change = (ends[1][1].gradient - ends[0][1].gradient) / 2e-2
    evaluated(ready)
    arrays = s.structure_arrays
    values = np.zeros(arrays.row_offsets[-1])
    axis.add_structure_stiffness(values, arrays)
    axis.add_balls(values, arrays, s.ball_arrays, out.ball_hessians)
    axis.add_roller_stiffness(values, arrays, s.slice_arrays, ready.state.slices)
    lines = full(values, arrays)
    place = (6 * arrays.body_order[:, None] + np.arange(6)).ravel()
    placed = np.zeros(len(lines))
    placed[place] = step.ravel()
    product = (lines @ placed)[place].reshape(step.shape)
    free = ~s.structure.fixed
    assert relative(product[free], change[free]) < 1e-5


def full(values, arrays):
    """Symmetric matrix of an envelope."""
    n = arrays.first_columns.size
    out = np.zeros((n, n))
    for i in range(n):
        j = np.arange(arrays.first_columns[i], i + 1)
        out[i, j] = out[j, i] = values[arrays.row_offsets[i] + j]
    return out
