"""Kernels of several rolling sets: energy and its slope, Hessians, the envelope, the rollers' law."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, double_nut, nut
from tests.helpers import relative

from rollbench.compare.models.registry import MODELS
from rollbench.lowfi import jit
from rollbench.lowfi.rollers import LineContactLaw
from rollbench.lowfi.statics.axis.solve import build_beam_assembly_equations
from rollbench.lowfi.statics.axis.system import build_assembly_arrays, tapered_bearing_of_row
from rollbench.lowfi.statics.kernel import axis, beam, rollers
from rollbench.lowfi.statics.kernel_types import EnergyDerivatives
from rollbench.meshes.axis import Housing, Joint, RollingSet, diagonal_stiffness
from rollbench.meshes.parts import Load

SPRINGS = diagonal_stiffness((4e8, 5e8, 6e8, 2e5, 3e5, 4e5))


def test_law_of_a_slice_is_that_of_the_bearings():
    law = tapered_bearing_of_row(ROLLERS).approach_law()
    exact = LineContactLaw(law.g, law.s)
    for delta in (1e-8, 3e-6, 2e-5):
        load, slope, energy = rollers.line_contact_law(delta, float(law.g), law.s)
        assert load == pytest.approx(float(exact.line_load(delta)), rel=1e-12)
        assert slope == pytest.approx(float(exact.stiffness_per_length(load)), rel=1e-12)
        assert energy == pytest.approx(float(exact.energy_per_length(load)), rel=1e-12)


def test_compiled_kernels_find_the_same():
    parts = double_nut()
    found = []
    for compiled in (False, True):
        prepared = build_beam_assembly_equations(
            build_assembly_arrays(parts), jit.load_kernel_package(jit.STATICS, compiled=compiled)
        )
        outcome = prepared.solve_by_newton()
        assert outcome.status == 0
        found.append(prepared.state.contact[..., 0].copy())
    assert relative(found[1], found[0]) < 1e-11


def mixed():
    """A nut, a ball bearing and rollers in two housings on springs, joined to one another."""
    roller = RollingSet("r", "tapered roller bearing", ROLLERS, 0.25, "b", thrust="+z", offset=-6e-6)
    sets = nut("n", 0.13, housing="a", offset=3e-6), bearing("k", 0.03, "-z", housing="b", offset=5e-6), roller
    housings = Housing("a", 0.14, (), SPRINGS, (10.0, 20.0, -30.0)), Housing("b", 0.2, (("rz", 0.0),), SPRINGS)
    joint = Joint("a", "b", 0.17, SPRINGS)
    return replace(assembly(*sets), housings=housings, joints=(joint,), loads=(Load(0.06, (100.0, 50.0, 400.0)),))


@pytest.fixture(scope="module", params=["lin", "lin-source-partition"])
def ready(request):
    parts = MODELS[request.param].assembly_with_settings(mixed())
    prepared = build_beam_assembly_equations(
        build_assembly_arrays(parts), jit.load_kernel_package(jit.STATICS, compiled=False)
    )
    prepared.solve_by_newton()
    rng = np.random.default_rng(1)
    prepared.state.q[:] += rng.normal(0.0, 2e-7, prepared.state.q.shape)
    n, lengths = prepared.assembly_arrays.structure.nodes.size, prepared.assembly_arrays.structure_arrays.lengths
    moved = prepared.state.q[: n - 1].copy()
    moved[:, 0] += lengths * prepared.state.q[: n - 1, 4]
    moved[:, 1] -= lengths * prepared.state.q[: n - 1, 3]
    prepared.state.d[:] = prepared.state.q[1:n] - moved
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
    values = np.zeros(s.structure_arrays.row_offsets[-1])
    axis.add_structure_stiffness(values, s.structure_arrays)
    axis.add_balls(values, s.structure_arrays, s.ball_arrays, out.ball_hessians)
    axis.add_roller_stiffness(values, s.structure_arrays, s.roller_slice_arrays, ready.state.slices)
    lines = full(values, s.structure_arrays)
    place = (6 * s.structure_arrays.body_order[:, None] + np.arange(6)).ravel()
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
