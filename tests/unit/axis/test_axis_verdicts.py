"""Verdicts on several sets: what is no load, what is out of balance, and what is proven not to be held."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, TURNING, assembly, bearing
from tests.shipped_texts import own_text

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import scene_file
from rollbench.lowfi.statics.axis import solve
from rollbench.lowfi.statics.axis.equations import assembly_equations
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.equilibrium import NOT_HELD
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.axis import Housing, RollingSet
from rollbench.meshes.parts import Load

pytestmark = [pytest.mark.xdist_group("axis verdicts"), pytest.mark.slow]


def run(parts, model):
    """Result of an assembly, or of one that only tests have, by its name."""
    parts = scene_file.parse_scene(own_text(parts), parts) if isinstance(parts, str) else parts
    found = run_model(parts, model, ModelOptions())
    assert found.converged
    return found


@pytest.mark.parametrize("model", ["lin", "refined"])
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
    found = solve.solve_assembly(assembly(*rows, supports=(TURNING,), loads=loads))
    assert found.status.startswith("not held: no equilibrium has all loaded balls of b on the side")
    sent = pickle.loads(pickle.dumps(found.status))  # as a worker of a campaign or a sweep sends it back
    assert (sent, sent.kind, sent.cause) == (found.status, "not held", "crossed row")
    # only a groove of one arc is the same on both sides of its bottom
    assert "4 contact(s) lie beyond the groove's arc" in found.sets[1].balls.warnings[0]


def rollers(name, z, thrust, **options):
    """A tapered roller bearing at z."""
    return RollingSet(name, "tapered roller bearing", ROLLERS, z, thrust=thrust, **options)


@pytest.mark.parametrize("force", [(0.0, 0.0, 500.0), (0.0, 0.0, -500.0), (500.0, 100.0, 0.0)], ids=str)
@pytest.mark.parametrize("play", [1e-3, 0.5])
def test_a_shaft_that_moves_far_before_a_row_closes_is_held(play, force):
    rows = rollers("a", 0.05, "+z", offset=0.5 * play), rollers("b", 0.25, "-z", offset=-0.5 * play)
    found = solve.solve_assembly(assembly(*rows, supports=(TURNING,), loads=(Load(0.1, force),)))
    assert found.status == "converged"
    assert np.abs(found.centreline[:, :3]).max() > 0.4 * play
    assert np.sum([s.force for s in found.sets], axis=0) == pytest.approx(-np.array(force), abs=1e-6)


def test_bodies_that_leave_together_with_their_own_contacts_loaded_are_soon_seen_not_to_be_held():
    """Shaft and housing, pressed against each other by a pair of bearings, leave the only row on the frame."""
    pair = tuple(
        bearing(name, z, way, housing="h", offset=by)
        for name, z, way, by in (("a", 0.05, "+z", -3e-6), ("b", 0.08, "-z", 3e-6))
    )
    housing = Housing("h", 0.06, (("rz", 0.0),))
    for load, held in ((500.0, True), (-500.0, False)):
        parts = assembly(
            *pair, rollers("c", 0.2, "+z"), housings=(housing,), supports=(TURNING,), loads=(Load(0.1, (0.0, 0.0, load)),)
        )
        outcome = solve_alone(assembly_equations(build_assembly_arrays(parts), None).solve_by_newton())
        assert (outcome.status != NOT_HELD) == held
        assert outcome.iterations < 60
