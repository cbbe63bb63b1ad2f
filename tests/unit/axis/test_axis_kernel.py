"""Kernels of several rolling sets: energy and its slope, Hessians, the envelope, the rollers' law."""

import pytest
from tests.axes import ROLLERS, double_nut
from tests.helpers import relative

from rollbench.lowfi import jit
from rollbench.lowfi.rollers.line_contact import LineLaw
from rollbench.lowfi.statics.axis.solve import prepare
from rollbench.lowfi.statics.axis.system import build, tapered
from rollbench.lowfi.statics.kernel import rollers
from rollbench.meshes.axis import diagonal

SPRINGS = diagonal((4e8, 5e8, 6e8, 2e5, 3e5, 4e5))


def test_law_of_a_slice_is_that_of_the_bearings():
    law = tapered(ROLLERS).law()
    exact = LineLaw(law.g, law.s)
    for delta in (1e-8, 3e-6, 2e-5):
        load, slope, energy = rollers.roller_law(delta, float(law.g), law.s)
        assert load == pytest.approx(float(exact.line_load(delta)), rel=1e-12)
        assert slope == pytest.approx(float(exact.slope(load)), rel=1e-12)
        assert energy == pytest.approx(float(exact.energy(load)), rel=1e-12)


def test_compiled_kernels_find_the_same():
    parts = double_nut()
    found = []
    for compiled in (False, True):
        prepared = prepare(build(parts), jit.kernels(jit.STATICS, compiled=compiled))
        outcome = prepared.iterate()
        assert outcome.status == 0
        found.append(prepared.state.contact[..., 0].copy())
    assert relative(found[1], found[0]) < 1e-11
