"""Many specimens of one screw from the solution without random errors."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi import jit
from rollbench.lowfi.statics.kernel_types import MemberArrays, MemberStates
from rollbench.lowfi.statics.problem import build
from rollbench.lowfi.statics.static import prepare
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors, FourierTerm, SideErrors

PAIR = np.array([True, False, False, True])
ALL = np.ones(4, dtype=bool)
#: Pitch and roundness errors of the screw's flanks: lever arms of their own.
OWN_ARMS = {
    "SL": SideErrors(pitch=(FourierTerm(1.0, sigma=1e-6),)),
    "SR": SideErrors(roundness=(FourierTerm(2.0, sigma=1e-6),)),
}


def ready(sigma, use, oversize, sides):
    """A screw of nine balls in its solution without random errors, and the scene with them; sides: errors of flanks."""
    scene = replace(small_screw(9, force=(0.0, 30.0, 1500.0)), errors=Errors(balls=BallErrors(oversize=oversize)))
    layout = ball_layout(scene)
    prepared = prepare(build(scene, specimen(scene, layout), layout, use), jit.kernels(jit.STATICS, compiled=True))
    prepared.iterate()
    prepared.options = prepared.options._replace(tolerance=1e-11)
    errors = Errors(balls=BallErrors(oversize=oversize, sigma=sigma), seed=3, **(sides or {}))
    return prepared, replace(scene, errors=errors), layout


def one_by_one(prepared, scene, layout, count):
    """Solutions of the same specimens by Newton's method, each from its own linear start."""
    found = []
    for m in range(count):
        single = prepare(build(scene, specimen(scene, layout, m), layout, prepared.problem.use), prepared.engine)
        assert single.iterate().status == 0
        found.append(single)
    return found


@pytest.mark.parametrize(("use", "oversize"), [(PAIR, 1e-6), (ALL, 7e-6)])
@pytest.mark.parametrize("sides", [None, OWN_ARMS])
@pytest.mark.parametrize("sigma", [0.5e-6, 40e-6])
def test_specimens_are_solved_from_the_start_of_all(sigma, use, oversize, sides):
    """Of two flanks and of four, near the start and far from it, with lever arms of their own or not."""
    prepared, scene, layout = ready(sigma, use, oversize, sides)
    count = 6
    singles = one_by_one(prepared, scene, layout, count)
    arrays = MemberArrays(
        *(np.stack([getattr(s.given.contacts, n) for s in singles]) for n in ("B", "geometry", "closure", "r_ball"))
    )
    q, p = prepared.state.q, prepared.state.p
    found = MemberStates(
        np.empty((count, 9, 4)),
        np.empty(count, dtype=np.int64),
        np.empty(count),
        *(np.empty((count, *x.shape)) for x in (q, p)),
    )
    prepared.engine.ensemble(prepared.given, prepared.state, prepared.options, arrays, found)
    assert not found.status.any()
    for m, single in enumerate(singles):
        np.testing.assert_allclose(found.force[m], single.force, rtol=0, atol=1e-9 * single.force.max())
