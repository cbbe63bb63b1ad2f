"""The refined model of several sets: against lin where its bodies are rigid. Against that of one set: tests/property."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ANGLE, BALL, ROLLERS, TURNING, assembly, bearing, double_nut, fixed_axis, nut, solved
from tests.helpers import ALL_BUT_AXIAL, relative

from rollbench.lowfi.compliance.parts import LADDER, reduce_to_compliance_geometry, smooth_body
from rollbench.lowfi.statics.axis import equations, solve
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.meshes.axis import Housing, RollingSet
from rollbench.meshes.parts import FREEDOMS, Load, Support
from rollbench.meshes.section import tube_section

#: Bodies of few harmonics on a coarse mesh, for what holds whatever they are.
COARSE = replace(LADDER["refined"], harmonics=0.4, mesh=0.6)


def refined(parts, **options):
    result = solve.solve_assembly_with_elastic_bodies(parts, **options)
    assert result.status == "converged"
    return result


ROWS = [RollingSet(t, "tapered roller bearing", ROLLERS, z, thrust=t) for t, z in (("+z", 0.03), ("-z", 0.07))]


def with_rollers():
    """An axis whose left pair are tapered rollers, one row of them in the carriage."""
    axis = fixed_axis((150.0, 80.0, 600.0))
    rows = replace(ROWS[0], offset=-2e-6), replace(ROWS[1], offset=2e-6, housing="carriage")
    return replace(axis, sets=(*rows, *axis.sets[2:]))


def carried_nut():
    """A nut that turns in a bearing around it, whose outer ring stands: the housing between is held by neither."""
    body = Housing("nut", 0.14, (("rz", 0.0),))
    sets = nut("screw", 0.14, housing="nut"), bearing("around", 0.14, "both", offset=1e-6, carrier="nut")
    supports, loads = (Support(0.0, ALL_BUT_AXIAL),), (Load(0.0, (0.0, 0.0, 700.0)), Load(0.25, (80.0, 0.0, 0.0)))
    return assembly(*sets, housings=(body,), supports=supports, loads=loads)


AXES = [double_nut(), fixed_axis((0.0, 0.0, 500.0)), with_rollers(), carried_nut()]


@pytest.mark.parametrize("parts", AXES, ids=["double nut", "axis", "rollers", "nut in a bearing"])
def test_with_rigid_bodies_it_is_the_model_lin(parts):
    one, other = solved(parts), refined(parts, backend=LADDER["lin"])
    for a, b in zip(one.sets, other.sets, strict=True):
        loads = [x.line_loads if x.balls is None else x.balls.load for x in (a, b)]
        assert relative(loads[1], loads[0]) < 1e-9
        assert relative(b.stiffness, a.stiffness) < 1e-9
        assert relative(b.outer, a.outer) < 1e-9
    assert other.stiffness[2, 2] == pytest.approx(one.stiffness[2, 2], rel=1e-9)
    assert all(h.residual < 1e-10 for h in other.housings)


@pytest.mark.slow
def test_rollers_stand_in_one_equilibrium_with_elastic_balls():
    parts = with_rollers()
    found = refined(parts)
    assert found.equilibrium.force_residual < 1e-10
    assert all(h.residual < 1e-10 for h in found.housings)
    rollers, balls = found.sets[0], found.sets[2]
    assert relative(rollers.reaction, -np.concatenate([rollers.force, rollers.moment])) < 1e-12
    rigid = refined(parts, backend=LADDER["lin"])
    assert abs(balls.force[2] / rigid.sets[2].force[2] - 1.0) > 1e-3  # elastic bodies where there are any
    push = replace(parts, housings=(replace(parts.housings[0], force=(150.0, 80.0, 600.3)),))
    slope = 0.3 / (refined(push).housings[0].motion[2] - found.housings[0].motion[2])
    assert found.stiffness[2, 2] == pytest.approx(slope, rel=1e-5)


def test_rollers_alone_are_the_model_lin():
    rows = replace(ROWS[0], preload=900.0), ROWS[1]
    parts = replace(fixed_axis(), sets=rows, housings=(), loads=(Load(0.15, (0.0, 200.0, 300.0)),))
    found = refined(parts)
    assert np.array_equal(found.sets[0].line_loads, solved(parts).sets[0].line_loads)
    assert found.model == "refined"


def test_elastic_nuts_carry_what_the_load_and_the_spacer_ask():
    parts = replace(double_nut(count=6), stiffness_at=0.0)
    found, rigid = refined(parts), refined(parts, backend=LADDER["lin"])
    assert sum(s.force[2] for s in found.sets) == pytest.approx(-800.0, rel=1e-9)
    assert relative(found.sets[0].balls.load, rigid.sets[0].balls.load) > 1e-3
    slope = 0.4 / (refined(double_nut(count=6, force=800.4)).centreline[0, 2] - found.centreline[0, 2])
    assert found.stiffness[2, 2] == pytest.approx(slope, rel=1e-3)


def test_inner_rings_on_housings_are_rigid_and_refused_on_springs():
    found = refined(carried_nut())
    assert [s.force[2] for s in found.sets] == pytest.approx([-700.0] * 2, rel=1e-9)
    assert all(h.residual < 1e-10 for h in found.housings)
    parts = double_nut(count=6)
    carried = replace(bearing("c", 0.14, "both"), carrier="h")
    with pytest.raises(ValueError, match="an inner ring sits on a housing that stands on springs"):
        solve.solve_assembly_with_elastic_bodies(replace(parts, sets=(*parts.sets, carried)))


@pytest.mark.slow
def test_contacts_of_one_set_squeeze_those_of_another_through_a_held_bar():
    """A shaft held at its length: radial forces Q at one nut push it apart by nu r Q / EA, which it takes by N = - EA / L
    of that, and N moves the contacts of the other nut outwards by - nu r N / EA; the beam's EA is not the smooth body's."""
    ends = Support(0.0, tuple((k, 0.0) for k in FREEDOMS)), Support(0.3, (("uz", 0.0),))
    one, other = nut("one", 0.1, count=6, turns=2.0), nut("other", 0.22, count=4, turns=1.0)  # evenly around
    parts = assembly(one, other, supports=ends)
    system = build_assembly_arrays(parts, section=equations.grooved_shaft_section(parts, LADDER["refined"]))
    coupling = equations.assembly_equations(system, LADDER["refined"]).coupling
    added = coupling.added_compliance.reshape(2, 10, 2, 2, 10, 2)
    tube = smooth_body(reduce_to_compliance_geometry(one.parts), True, LADDER["refined"])
    plain = tube_section(2.0 * tube.outer_radius, 2.0 * tube.bore_radius, tube.material)
    bar = equations.problem_of_beam(system).element_sections[0]
    share = tube.material.poissons_ratio * tube.contact_radius / plain.EA
    moved = added[:, 6:, 0, :, :6, 0].sum(axis=(2, 3))  # by forces of 1 N outwards on all flanks of the first nut
    assert moved.mean() == pytest.approx(-12.0 * share**2 * bar.EA / 0.3, rel=0.02)


#: A load of nothing between the rows.
IDLE = Load(0.15)


def warm(strain=1.4e-4, squeeze=0.0, load=IDLE):
    """A shaft between two rows that take its thrust to either side, warmed or squeezed by their outer rings."""
    rows = bearing("left", 0.05, "-z", offset=squeeze), bearing("right", 0.25, "+z", offset=-squeeze)
    return assembly(*rows, supports=(TURNING,), loads=(load,), thermal_strain=strain)


#: What the shaft grows by between its inner contact points, at either end.
GROWTH = 1.4e-4 * (0.1 - BALL * np.sin(ANGLE))


def test_a_shaft_that_only_warms_is_squeezed_like_one_between_shifted_rings():
    one, other = refined(warm(), backend=COARSE), refined(warm(0.0, GROWTH), backend=COARSE)
    for a, b in zip(one.sets, other.sets, strict=True):
        assert a.force[2] == pytest.approx(b.force[2], rel=2e-3)
        assert a.balls.load.max() == pytest.approx(b.balls.load.max(), rel=2e-3)


@pytest.mark.parametrize("along", [0, 2, 3, 4])
def test_the_squeeze_of_a_warm_shaft_is_continuous_as_any_load_goes_to_zero(along):
    least = refined(warm(), backend=COARSE).sets
    for size in (1e-3, 1.0):
        load = size * np.eye(6)[along] * np.repeat([1.0, 0.1], 3)
        found = refined(warm(load=Load(0.15, tuple(load[:3]), tuple(load[3:]))), backend=COARSE).sets
        for a, b in zip(found, least, strict=True):
            assert a.force[2] == pytest.approx(b.force[2], abs=2e-4 * abs(b.force[2]) + size)
    more = refined(warm(load=Load(0.15, (0.0, 0.0, 100.0))), backend=COARSE).sets
    means = [np.mean([abs(s.force[2]) for s in sets]) for sets in (more, least)]
    assert means[0] == pytest.approx(means[1], rel=5e-3)
