"""Verdicts on several sets: what is no load, what is out of balance, and what is proven not to be held."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.axes import TURNING, assembly, bearing
from tests.shipped_texts import own_text

from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import scene_file
from rollbench.lowfi.statics.axis import solve
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.meshes.parts import Load

pytestmark = pytest.mark.xdist_group("axis verdicts")


def run(parts, model):
    """Result of an assembly, or of one that only tests have, by its name."""
    parts = scene_file.parse_scene(own_text(parts), parts) if isinstance(parts, str) else parts
    found = run_model(parts, model, ModelOptions(engine="compiled"))
    assert found.converged
    return found


MODELS = [  # each a group of its own, for a worker of its own: their kernels are most of what tests of the core compile
    pytest.param("lin", marks=[pytest.mark.compiles(37), pytest.mark.xdist_group("kernels of axes")]),
    pytest.param("refined", marks=[pytest.mark.compiles(80), pytest.mark.xdist_group("kernels of bodies")]),
]


@pytest.mark.parametrize("model", MODELS)
def test_contacts_that_nothing_presses_carry_nothing_and_a_row_that_carries_nothing_is_not_crossed(model):
    """Balls of the second row carry 1e-11 of 14 kN at an angle below zero; contacts alone hold the shaft, metres away
    without."""
    for name, idle in (("axis-crossed-by-nothing", slice(1, 2)), ("axis-no-load", slice(None))):
        found = run(name, model)
        assert found.solver.iterations < 60
        assert found.equilibrium.largest < 1e-9
        assert all(np.abs(s.force).max() < 1e-9 for s in found.sets[idle])


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize("degrees", [15.0, 50.0])
def test_rows_that_only_round_off_closes_carry_nothing(degrees, model):
    """At 50 deg forces of round-off were to be balanced, which cannot be."""
    rows = bearing("a", 0.05, "+z"), bearing("b", 0.25, "-z")
    tracks = (replace(s.parts.track, contact_angle=np.radians(degrees)) for s in rows)
    sets = (replace(s, parts=replace(s.parts, track=t)) for s, t in zip(rows, tracks, strict=True))
    found = run(assembly(*sets, supports=(TURNING,)), model)
    assert not any(s.balls.load.any() for s in found.sets)


def test_a_load_beside_a_contact_stays_where_it_is():
    """The node between them is the contact's; the way from the load to it is rigid."""
    parts = assembly(bearing("a", 0.05, "+z", offset=-4e-6), bearing("b", 0.25, "-z", offset=4e-6), supports=(TURNING,))
    contact = build_assembly_arrays(parts).structure.nodes[0]
    load = Load(float(contact) + 5e-6, (2e3, 0.0, 100.0))
    found = solve.solve_assembly(replace(parts, loads=(load,)))
    assert found.status == "converged"
    assert found.equilibrium.largest < 1e-12


def test_balls_across_the_bottom_of_a_one_way_groove_are_no_equilibrium_of_it():
    """A radial load on two rows, one drawn off by more than the depth of its groove: its balls are at -12 deg, though
    forces at nominal contacts could balance the loads."""
    rows = bearing("a", 0.05, "+z"), bearing("b", 0.25, "-z", offset=-0.4e-3)
    loads = (Load(0.25, (2e3, 0.0, 500.0)),)
    found = solve.solve_assembly(assembly(*rows, supports=(TURNING,), loads=loads), engine="compiled")
    assert found.status.startswith("not held: no equilibrium has all loaded balls of b on the side")
    sent = pickle.loads(pickle.dumps(found.status))  # as a worker of a campaign or a sweep sends it back
    assert (sent, sent.kind, sent.cause) == (found.status, "not held", "crossed row")
    # only a groove of one arc is the same on both sides of its bottom
    assert "4 contact(s) lie beyond the groove's arc" in found.sets[1].balls.warnings[0]
