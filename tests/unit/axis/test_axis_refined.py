"""The refined model of several sets: against that of one set, and against lin where its bodies are rigid."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, double_nut, fixed_axis, mirrored, nut, one_set, solved, with_nominal_arms
from tests.helpers import ALL_BUT_AXIAL, relative, small_screw

from rollbench.compare.models.registry import MODELS
from rollbench.lowfi.compliance.parts import LADDER, reduce_to_compliance_geometry, smooth_body
from rollbench.lowfi.statics import kernel
from rollbench.lowfi.statics.axis import elastic
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.elastic import solve_elastic
from rollbench.meshes.axis import Housing, RollingSet
from rollbench.meshes.parts import FREEDOMS, Load, SideErrors, Support
from rollbench.meshes.section import tube_section

#: Bodies of few harmonics on a coarse mesh, for what holds whatever they are.
COARSE = replace(LADDER["refined"], harmonics=0.4, mesh=0.6)


def refined(parts, **options):
    result = elastic.solve_assembly_with_elastic_bodies(parts, engine="compiled", **options)
    assert result.status == "converged"
    return result


@pytest.mark.parametrize(("oversize", "model"), [(0.0, "lin"), (7e-6, "lin"), (7e-6, "lin-source-partition")])
def test_one_set_is_the_refined_model_of_one_set(oversize, model):
    scene = small_screw(count=8, turns=1.5, lead=12e-3, force=(0.0, 0.0, 900.0), oversize=oversize)
    scene = MODELS[model].scene_with_settings(scene)
    alone, found = solve_elastic(scene, engine="compiled"), refined(one_set(scene))
    assert relative(found.sets[0].balls.load, alone.load) < 1e-10
    assert found.equilibrium.force_residual < 1e-11


def test_a_warm_shaft_grows_by_its_strain_and_less_where_a_nut_holds_it():
    parts = assembly(
        nut("n", 0.15), supports=(Support(0.0, (("uz", 0.0), ("rz", 0.0))),), loads=(Load(0.3),), thermal_strain=1e-4
    )
    idle = replace(parts, sets=(nut("n", 0.15, housing="h"),), housings=(Housing("h", 0.15),))
    assert refined(idle).centreline[-1, 2] == pytest.approx(0.3e-4, rel=1e-5)
    assert 0.15e-4 < refined(parts).centreline[-1, 2] < 0.3e-4


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


def test_rollers_stand_in_one_equilibrium_with_elastic_balls():
    parts = with_rollers()
    found = refined(parts)
    assert found.equilibrium.force_residual < 1e-10
    assert all(h.residual < 1e-10 for h in found.housings)
    rollers, balls = found.sets[0], found.sets[2]
    assert relative(rollers.reaction, -np.concatenate([rollers.force, rollers.moment])) < 1e-12
    rigid = refined(parts, backend=LADDER["lin"])
    assert abs(balls.force[2] / rigid.sets[2].force[2] - 1.0) > 1e-3  # elastic bodies where there are any
    assert sum("elastic rings: cone and cup are rigid" in x for x in found.left_out) == 2
    push = replace(parts, housings=(replace(parts.housings[0], force=(150.0, 80.0, 600.3)),))
    slope = 0.3 / (refined(push).housings[0].motion[2] - found.housings[0].motion[2])
    assert found.stiffness[2, 2] == pytest.approx(slope, rel=1e-5)


def test_rollers_alone_are_the_model_lin():
    rows = replace(ROWS[0], preload=900.0), ROWS[1]
    parts = replace(fixed_axis(), sets=rows, housings=(), loads=(Load(0.15, (0.0, 200.0, 300.0)),))
    found = refined(parts)
    assert np.array_equal(found.sets[0].line_loads, solved(parts).sets[0].line_loads)
    assert found.model == "refined"
    assert "elastic rings" in found.left_out[0]


def test_elastic_nuts_carry_what_the_load_and_the_spacer_ask():
    found = refined(double_nut(count=6))
    assert sum(s.force[2] for s in found.sets) == pytest.approx(-800.0, rel=1e-9)
    rigid = refined(double_nut(count=6), backend=LADDER["lin"])
    assert relative(found.sets[0].balls.load, rigid.sets[0].balls.load) > 1e-3
    push = double_nut(count=6, force=800.4)
    slope = 0.4 / (refined(push).centreline[0, 2] - found.centreline[0, 2])
    assert refined(replace(double_nut(count=6), stiffness_at=0.0)).stiffness[2, 2] == pytest.approx(slope, rel=1e-3)


def test_profiles_of_each_set_count():
    """One uneven set alone is the refined model of one set with its lever arms kept; beside another it keeps its own."""
    scene = small_screw(count=8, turns=1.5, lead=12e-3, force=(0.0, 0.0, 900.0), oversize=3e-6, arm="nominal")
    errors = replace(scene.errors, SL=SideErrors(profile=(0.0, 4e-6, -3e-6)))
    uneven = replace(scene, errors=errors)
    alone, found = solve_elastic(uneven, engine="compiled"), refined(one_set(uneven))
    assert relative(found.sets[0].balls.load, alone.load) < 1e-9
    assert relative(found.sets[0].balls.contact_point, alone.contact_point) < 1e-9
    assert relative(refined(one_set(scene)).sets[0].balls.load, alone.load) > 1e-3
    parts = double_nut(count=6)
    uneven_nut = replace(parts.sets[0].parts, errors=errors)
    both = refined(replace(parts, sets=(replace(parts.sets[0], parts=uneven_nut), parts.sets[1])))
    assert both.equilibrium.force_residual < 1e-10


def test_inner_rings_on_housings_are_rigid_and_refused_on_springs():
    found = refined(carried_nut())
    assert [s.force[2] for s in found.sets] == pytest.approx([-700.0] * 2, rel=1e-9)
    assert all(h.residual < 1e-10 for h in found.housings)
    assert any("around: elastic inner ring" in x for x in found.left_out)
    parts = double_nut(count=6)
    carried = replace(bearing("c", 0.14, "both"), carrier="h")
    with pytest.raises(ValueError, match="an inner ring sits on a housing that stands on springs"):
        elastic.solve_assembly_with_elastic_bodies(replace(parts, sets=(*parts.sets, carried)))


def half_axis():
    """An axis that only its left pair of bearings holds."""
    axis = fixed_axis((150.0, 80.0, 600.0))
    return replace(axis, sets=(*axis.sets[:2], axis.sets[4]))


MIRRORED = {
    "double nut": (with_nominal_arms(double_nut(count=6)), 1e-8),
    "axis": (with_nominal_arms(half_axis()), 2e-3),
    "lever arms to the grooves' centres": (double_nut(count=6), 1e-5),
}


@pytest.mark.parametrize(("parts", "error"), MIRRORED.values(), ids=MIRRORED)
def test_mirror_image_carries_the_mirrored_loads(parts, error):
    """Whichever end of a set's stretch of shaft is held. On the axis the patches of contacts near the ends of the bearings'
    stretches are cut off there, by less on one side than on the other, more of them the wider patches are, and the shaft's
    face adds to them. Lever arms to the grooves' centres break the mirror by what contacts turn."""
    here, there = (refined(p, backend=COARSE) for p in (parts, mirrored(parts)))
    for a, b in zip(here.sets, there.sets, strict=True):
        assert relative(b.balls.load[:, [1, 0, 3, 2]], a.balls.load) < error
        assert relative(b.force, a.force * [1.0, 1.0, -1.0]) < error
        assert np.abs(a.force + a.reaction[:3]).max() < 1e-11 * np.abs(a.balls.load).max()


@pytest.mark.parametrize("held", [False, True], ids=["free end", "held end"])
def test_one_set_with_a_shaft_beyond_it_is_the_refined_model_of_one_set(held):
    """A support and a load on either side: the section forces squeeze the contacts."""
    scene = small_screw(count=8, turns=1.5, lead=12e-3, force=(60.0, 0.0, 900.0), oversize=4e-6, load_at=0.18)
    ends = (*scene.supports, Support(0.2, (("ux", 0.0), ("uz", 20e-6)))) if held else scene.supports
    scene = replace(scene, supports=ends)
    alone, found = solve_elastic(scene, engine="compiled", everything=True), refined(one_set(scene))
    assert relative(found.sets[0].balls.load, alone.load) < 1e-9
    rigid = [refined(one_set(scene), backend=replace(LADDER["refined"], screw=kind)) for kind in ("kernel", "beam")]
    assert relative(rigid[1].sets[0].balls.load, alone.load) > 1e-3


def test_contacts_of_one_set_squeeze_those_of_another_through_a_held_bar():
    """A shaft held at its length: radial forces Q at one nut push it apart by nu r Q / EA, which it takes by N = - EA / L
    of that, and N moves the contacts of the other nut outwards by - nu r N / EA; the beam's EA is not the smooth body's."""
    ends = Support(0.0, tuple((k, 0.0) for k in FREEDOMS)), Support(0.3, (("uz", 0.0),))
    one, other = nut("one", 0.1, count=6, turns=2.0), nut("other", 0.22, count=4, turns=1.0)  # evenly around
    parts = assembly(one, other, supports=ends)
    system = build_assembly_arrays(parts, section=elastic.grooved_shaft_section(parts, LADDER["refined"]))
    added = elastic.elastic_assembly_equations(
        system, LADDER["refined"], kernel
    ).section_force_coupling.added_compliance.reshape(2, 10, 2, 2, 10, 2)
    tube = smooth_body(reduce_to_compliance_geometry(one.parts), True, LADDER["refined"])
    plain = tube_section(2.0 * tube.outer_radius, 2.0 * tube.bore_radius, tube.material)
    bar = elastic.combined_problem(system, elastic.roller_elements([])).element_sections[0]
    share = tube.material.poissons_ratio * tube.contact_radius / plain.EA
    moved = added[:, 6:, 0, :, :6, 0].sum(axis=(2, 3))  # by forces of 1 N outwards on all flanks of the first nut
    assert moved.mean() == pytest.approx(-12.0 * share**2 * bar.EA / 0.3, rel=0.02)
