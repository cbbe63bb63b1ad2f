"""Bearings on a shaft against closed formulas and independent solutions: sets of rows, tapered rollers, preload, heat."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ANGLE, BALL, GROOVE, PITCH, ROLLERS, TURNING, assembly, bearing, fixed_axis, nut, one_set, solved
from tests.helpers import ALL_BUT_AXIAL, relative, small_screw
from tests.tapered_row_oracle import solve_thrust_and_radial_equilibrium

from rollbench.compare.models.registry import MODELS
from rollbench.lowfi.bearings import angular_contact
from rollbench.lowfi.bearings.axis import BearingRows, solve_bearing_row_equilibrium
from rollbench.lowfi.rollers import TaperedRow as ThrustRow
from rollbench.lowfi.statics.axis import solve, system
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes import helix, section
from rollbench.meshes.axis import Housing, RollingSet, Segment
from rollbench.meshes.parts import Load, Support

#: A shaft so thick that only its bearings give way.
THICK = (Segment(0.0, 0.3, 30.0),)
GUIDED = Support(0.15, ALL_BUT_AXIAL)


def with_load(*sets, force, at=0.1, held=GUIDED):
    """A thick shaft with these sets under a force."""
    return assembly(*sets, segments=THICK, supports=(held,), loads=(Load(at, force),))


def ball_bearing():
    """The bearing of `tests.axes` by its closed formulas: raceways that leave its contact angle without load."""
    inner, outer = GROOVE, 0.53 * 7e-3
    gap = (inner + outer - 2.0 * BALL) * np.cos(ANGLE)
    # the ball's centre stands at the pitch radius, the grooves' centres at (r - r_B) cos(angle) to either side
    low = 2.0 * (PITCH + (inner - BALL) * np.cos(ANGLE) - inner)
    return angular_contact.BallBearing(14, 2.0 * BALL, low, low + 2.0 * (inner + outer - gap), inner, outer, 210e9, 0.28)


@pytest.mark.parametrize("pattern", ["+-", "++-", "-+", "+--"])
def test_rows_share_thrust_as_their_laws_say(pattern):
    row, gap = ball_bearing(), 6e-6
    signs = [1 if way == "+" else -1 for way in pattern]
    sets = [bearing(f"row {i}", 0.03 + 0.02 * i, f"{pattern[i]}z", offset=-s * gap) for i, s in enumerate(signs)]
    for thrust in (0.0, 500.0, -500.0, 4000.0):
        found = solved(with_load(*sets, force=(0.0, 0.0, thrust)))
        closed = solve_bearing_row_equilibrium(BearingRows((row,) * len(signs), tuple(signs), (gap,) * len(signs)), thrust)
        forces = [-s.force[2] * sign for s, sign in zip(found.sets, signs, strict=True)]
        assert relative(forces, closed.row_thrusts) < 3e-4  # Hertz: the race's curvature at its nominal contact angle
        assert sum(s.stiffness[2, 2] for s in found.sets) == pytest.approx(closed.stiffness, rel=1e-3)


def roller_set(**options):
    return RollingSet("rollers", "tapered roller bearing", ROLLERS, 0.15, thrust="+z", **options)


@pytest.mark.parametrize("radial", [0.0, 2000.0])
def test_rollers_share_thrust_and_radial_load_as_the_bearing_alone(radial):
    held = Support(0.15, tuple((k, 0.0) for k in ("uy", "rx", "ry", "rz")))
    found = solved(with_load(roller_set(), force=(radial, 0.0, 3000.0), at=0.15, held=held))
    alone = solve_thrust_and_radial_equilibrium(system.tapered_bearing_of_row(ROLLERS), 3000.0, radial)
    # without moment equilibrium, as there: the shaft is kept from tilting, and slices are loaded evenly
    assert relative(found.sets[0].roller_load, alone.roller_loads) < 1e-7
    assert np.ptp(found.sets[0].line_loads, axis=1).max() < 1e-6 * found.sets[0].line_loads.max()
    assert found.sets[0].stiffness[2, 2] == pytest.approx(alone.stiffness[0, 0], rel=1e-7)
    assert found.sets[0].stiffness[0, 0] == pytest.approx(alone.stiffness[1, 1], rel=1e-7)


def test_rollers_of_a_shaft_that_tilts_are_loaded_unevenly():
    tilted = Support(0.15, (*((k, 0.0) for k in ("ux", "uy", "rx", "rz")), ("ry", 2e-4)))
    rows = roller_set(), replace(roller_set(), parts=replace(ROLLERS, crown=2.0))
    found, relieved = (solved(with_load(row, force=(0.0, 0.0, 3000.0), at=0.15, held=tilted)) for row in rows)
    assert np.ptp(found.sets[0].line_loads, axis=1).max() > 0.2 * found.sets[0].line_loads.max()
    assert relieved.sets[0].line_loads[:, [0, -1]].max() < found.sets[0].line_loads[:, [0, -1]].max()


def test_preload_by_force_is_carried_before_loading_and_locked_then():
    sets = bearing("a", 0.03, "+z", preload=700.0), bearing("b", 0.05, "-z")
    base = assembly(*sets, segments=THICK, supports=(GUIDED,))
    idle = solved(base)
    assert [s.force[2] for s in idle.sets] == pytest.approx([-700.0, 700.0], rel=1e-9)
    by_shift = replace(base, sets=(replace(sets[0], preload=0.0, offset=idle.sets[0].of.offset), sets[1]))
    loaded, same = (solved(replace(x, loads=(Load(0.1, (0.0, 0.0, 300.0)),))) for x in (base, by_shift))
    assert [s.force[2] for s in loaded.sets] == pytest.approx([s.force[2] for s in same.sets], rel=1e-9)
    assert sum(s.force[2] for s in loaded.sets) == pytest.approx(-300.0, rel=1e-9)


def test_preload_is_set_before_the_shaft_warms():
    sets = bearing("a", 0.03, "-z", preload=700.0), bearing("b", 0.27, "+z")
    cold = assembly(*sets, supports=(GUIDED,))
    warm = solved(replace(cold, thermal_strain=2e-5))
    assert solved(cold).sets[0].force[2] == pytest.approx(700.0, rel=1e-9)
    assert warm.sets[0].force[2] > 1.2 * 700.0


def test_a_preload_that_cannot_be_met_is_a_failure():
    alone = assembly(bearing("a", 0.03, "+z", preload=700.0), segments=THICK, supports=(GUIDED,))
    for found in (solve_assembly(alone), solve.solve_assembly_with_elastic_bodies(alone)):
        assert found.status.startswith("not held: preloads by force are not met")
        assert (found.status.cause, len(found.sets)) == ("mounting", 0)


@pytest.mark.parametrize("preload", [300.0, 1431.0, 1643.0])
def test_nuts_that_press_one_another_are_preloaded_by_one_force(preload):
    """Both given it."""
    nuts = (nut(name, z, thrust=t, preload=preload) for name, z, t in (("1", 0.13, "-z"), ("2", 0.17, "+z")))
    found = solved(assembly(*nuts, supports=(Support(0.0, ALL_BUT_AXIAL),), loads=(Load(0.0, (0.0, 0.0, 1.0)),)))
    assert found.sets[0].force[2] + found.sets[1].force[2] == pytest.approx(-1.0, rel=1e-9)
    assert found.sets[0].force[2] == pytest.approx(preload - 0.5, abs=0.1)


def test_two_preloads_by_force_are_met_together():
    axis = fixed_axis((0.0, 0.0, 0.0))
    sets = [replace(s, offset=0.0, preload=p) for s, p in zip(axis.sets[:4], (500.0, 0.0, 0.0, 800.0), strict=True)]
    found = solve_assembly(replace(axis, sets=tuple(sets), housings=()))
    assert found.converged
    assert [abs(found.sets[k].force[2]) for k in (0, 3)] == pytest.approx([500.0, 800.0], rel=1e-8)


def test_tapered_preload_by_force():
    rows = roller_set(preload=900.0), replace(roller_set(), name="other", position=0.2, thrust="-z")
    found = solved(assembly(*rows, segments=THICK, supports=(GUIDED,)))
    assert [s.force[2] for s in found.sets] == pytest.approx([-900.0, 900.0], rel=1e-9)
    row = ThrustRow(system.tapered_bearing_of_row(ROLLERS))
    assert -found.sets[0].outer[2] == pytest.approx(2.0 * row.deflection(900.0), rel=1e-3)


def test_warm_shaft_grows_and_between_rigid_ends_is_pushed_by_its_strain():
    ends = Support(0.0, (*ALL_BUT_AXIAL, ("uz", 0.0))), Support(0.3, (("ux", 0.0), ("uy", 0.0), ("uz", 0.0)))
    far = bearing("idle", 0.15, "+z", offset=0.1e-3)  # so loose that it touches nothing
    warm = assembly(far, supports=ends[:1], loads=(Load(0.3),), thermal_strain=1e-4)
    assert solved(warm).centreline[-1, 2] == pytest.approx(0.3e-4, rel=1e-12)
    stretched = Support(0.3, (("ux", 0.0), ("uy", 0.0), ("uz", 0.3e-4)))
    unloaded = solved(replace(warm, supports=(ends[0], stretched)))  # Smith 4.1: the stretch is used up
    assert relative(unloaded.centreline[:, 2], 1e-4 * unloaded.centreline_z) < 1e-9
    # a bearing in the middle feels a warm shaft between rigid ends no more than a cold one: it is symmetric
    touching = replace(warm, sets=(bearing("on", 0.15, "+z", offset=-5e-6),), supports=ends)
    pushed = [solved(replace(touching, thermal_strain=e)).sets[0].force[2] for e in (0.0, 1e-4)]
    assert pushed[0] < -100.0
    assert pushed[1] == pytest.approx(pushed[0], rel=0.05)


@pytest.mark.parametrize(("away", "model"), [(9e-6, "lin"), (-9e-6, "lin"), (9e-6, "lin-source-partition")])
def test_a_support_near_a_contact_stays_where_it_is(away, model):
    scene = MODELS[model].scene_with_settings(small_screw(oversize=2e-6, force=(300.0, 0.0, 900.0)))
    at = float(section.contact_force_positions(scene, helix.ball_layout(scene))[3, 0]) + away
    scene = replace(scene, supports=(*scene.supports, Support(at, (("ux", 0.0), ("uy", 0.0)))))
    alone = solve_static(scene)
    assert relative(solved(one_set(scene)).sets[0].balls.load, alone.load) < 1e-12


def test_free_motions_are_named():
    free = assembly(bearing("a", 0.03, "+z"), loads=(Load(0.1, (0.0, 0.0, 0.0), (0.0, 0.0, 3.0)),))
    assert "not held: rigid motion of the shaft in rz" in solve_assembly(free).status
    loose = replace(free, housings=(Housing("h", 0.1, (), None, (0.0, 5.0, 0.0)),), loads=())
    assert "h in ux, uy" in solve_assembly(loose).status
    away = replace(assembly(bearing("a", 0.03, "+z"), supports=(TURNING,)), loads=(Load(0.1, (0.0, 0.0, -50.0)),))
    assert solve_assembly(away).status == "not held: the load opens a, which carries thrust along +z only (linear program)"
