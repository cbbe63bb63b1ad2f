"""Verdicts on several sets: what is no load, what is out of balance, and what is proven not to be held."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.axes import TURNING, assembly, bearing, one_set, solved
from tests.helpers import relative, small_screw
from tests.shipped_texts import own_text

from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import scene_file
from rollbench.lowfi.statics.axis import solve
from rollbench.lowfi.statics.axis.elastic import solve_assembly_with_elastic_bodies
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import Load, SideErrors

pytestmark = pytest.mark.xdist_group("axis verdicts")


def scene(name):
    """An assembly that only tests have."""
    return scene_file.parse_scene(own_text(name), name)


MODELS = [  # each a group of its own, for a worker of its own: their kernels are most of what tests of the core compile
    pytest.param("lin", marks=[pytest.mark.compiles(37), pytest.mark.xdist_group("kernels of axes")]),
    pytest.param("refined", marks=[pytest.mark.compiles(80), pytest.mark.xdist_group("kernels of bodies")]),
]


@pytest.mark.parametrize("model", MODELS)
def test_a_row_that_carries_nothing_is_not_crossed(model):
    """Its balls carry 1e-11 of 14 kN at an angle below zero; contacts alone hold the shaft, metres away without."""
    found = run_model(scene("axis-crossed-by-nothing"), model, ModelOptions(engine="compiled"))
    assert found.converged
    assert found.solver.iterations < 60
    assert found.equilibrium.largest < 1e-9
    assert abs(found.sets[1].force).max() < 1e-9


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_contacts_that_nothing_presses_carry_nothing(model):
    found = run_model(scene("axis-no-load"), model, ModelOptions(engine="compiled"))
    assert found.converged
    assert found.equilibrium.largest < 1e-9
    assert all(np.abs(s.force).max() < 1e-9 for s in found.sets)


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize("degrees", [15.0, 50.0])
def test_rows_that_only_round_off_closes_carry_nothing(degrees, model):
    """At 50 deg forces of round-off were to be balanced, which cannot be."""
    rows = bearing("a", 0.05, "+z"), bearing("b", 0.25, "-z")
    tracks = (replace(s.parts.track, contact_angle=np.radians(degrees)) for s in rows)
    sets = (replace(s, parts=replace(s.parts, track=t)) for s, t in zip(rows, tracks, strict=True))
    found = run_model(assembly(*sets, supports=(TURNING,)), model, ModelOptions(engine="compiled"))
    assert found.converged
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


PROFILE = (0.0, 0.0, 4e-6, -3e-6)


@pytest.mark.parametrize("hertz", ["nominal", "actual"])
@pytest.mark.parametrize("elastic", [False, True])
def test_one_set_on_uneven_flanks_or_with_hertz_at_the_actual_geometry_is_that_of_one_set(elastic, hertz):
    parts = small_screw(oversize=3e-6, force=(200.0, 0.0, 900.0), hertz=hertz)
    if hertz == "nominal":
        uneven = SideErrors(profile=PROFILE)
        parts = replace(parts, errors=replace(parts.errors, SL=uneven, NR=uneven))
    if elastic:
        alone, found = (
            solve_elastic(parts, engine="compiled"),
            solve_assembly_with_elastic_bodies(one_set(parts), engine="compiled"),
        )
    else:
        alone, found = solve_static(parts, engine="compiled"), solved(one_set(parts))
    assert found.status == alone.status == "converged"
    assert relative(found.sets[0].balls.load, alone.load) < (1e-9 if elastic else 1e-11)
    assert np.abs(found.sets[0].balls.hertz_C / alone.hertz_C - 1.0).max() < 1e-9
