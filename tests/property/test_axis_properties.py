"""Several rolling sets on one shaft: what must hold exactly, whatever the numbers are."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import assembly, double_nut, fixed_axis, mirrored, nut, one_set, solved
from tests.helpers import ALL_BUT_AXIAL, FLANK_ERRORS, NO_PROFILES, dense, relative, small_screw, with_ingredients
from tests.slow import all_slow_but

from rollbench.compare.models.registry import MODELS as REGISTRY
from rollbench.lowfi.statics.axis import solve
from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.beam import beam_stiffness_band
from rollbench.lowfi.statics.static import solve_elastic, solve_static
from rollbench.meshes.axis import Housing, Segment, diagonal_stiffness
from rollbench.meshes.parts import Errors, Load, SideErrors, Support

AXIAL = small_screw(12, 2.0, lead=12e-3, force=(0.0, 0.0, 900.0))
SIDEWAYS = small_screw(8, 1.5, lead=12e-3, force=(60.0, 0.0, 900.0), oversize=4e-6, load_at=0.18)
PRELOADED = small_screw(12, force=(0.0, 0.0, 900.0), oversize=7e-6)
PROFILE = SideErrors(profile=(0.0, 0.0, 4e-6, -3e-6))
ACROSS = small_screw(oversize=3e-6, force=(200.0, 0.0, 900.0))
#: With a support and a load on either side the section forces squeeze the contacts.
ONE_SET = {
    "axial": AXIAL,
    "preloaded": replace(PRELOADED, errors=replace(FLANK_ERRORS, balls=PRELOADED.errors.balls, **NO_PROFILES)),
    "source partition": REGISTRY["lin-source-partition"].scene_with_settings(PRELOADED),
    "bearing": small_screw(9, lead=0.0, force=(200.0, 0.0, -900.0)),
    "left hand": small_screw(12, force=(300.0, 0.0, 0.0), moment=(0.0, 1.0, 0.0), oversize=7e-6, hand="left"),
    "uneven flank, lever arms kept": with_ingredients(replace(AXIAL, errors=Errors(SL=PROFILE)), arm="nominal"),
    "uneven flanks": replace(ACROSS, errors=replace(ACROSS.errors, SL=PROFILE, NR=PROFILE)),
    "Hertz at the actual geometry": with_ingredients(ACROSS, hertz="actual"),
    "free end": SIDEWAYS,
    "held end": replace(SIDEWAYS, supports=(*SIDEWAYS.supports, Support(0.2, (("ux", 0.0), ("uz", 20e-6))))),
}
#: Solvers of one set and of several, and how near their loads are.
MODELS = {
    "lin": (solve_static, solve.solve_assembly, 1e-11),
    "refined": (solve_elastic, solve.solve_assembly_with_elastic_bodies, 1e-10),
}
PAIRS = [(name, model) for name in ONE_SET for model in MODELS if (name, model) != ("bearing", "refined")]


@pytest.mark.parametrize(("case", "model"), all_slow_but(PAIRS[::3], PAIRS))
def test_one_set_is_the_model_of_one_set(case, model):
    scene, (solve_one, solve_several, near) = ONE_SET[case], MODELS[model]
    alone = solve_one(scene, everything=True)
    found = solve_several(one_set(scene))
    assert alone.status == found.status == "converged"
    of_set = found.sets[0].balls
    assert relative(of_set.load, alone.load) < near
    loaded = alone.load > 1e-6 * alone.load.max()
    assert np.abs(of_set.contact_angle - alone.contact_angle)[loaded].max() < 1e-10
    assert relative(of_set.contact_point[loaded], alone.contact_point[loaded]) < 1e-9
    assert np.abs(of_set.hertz_C / alone.hertz_C - 1.0).max() < 1e-9
    assert relative(found.sets[0].force, alone.equilibrium.contact_force) < 1e-10
    assert found.equilibrium.force_residual < 1e-11


def test_an_outer_part_that_stands_and_one_whose_housing_is_fixed_are_the_same():
    parts = double_nut()
    fixed = replace(parts, housings=(Housing("h", 0.14, (*ALL_BUT_AXIAL, ("uz", 0.0))),))
    free = replace(parts, housings=(), sets=tuple(replace(s, housing=None) for s in parts.sets))
    stiff = replace(parts, housings=(Housing("h", 0.14, (), diagonal_stiffness((1e18,) * 3 + (1e15,) * 3)),))
    a, b, c = solved(fixed), solved(free), solved(stiff)
    for one, two, three in zip(a.sets, b.sets, c.sets, strict=True):
        assert np.array_equal(one.balls.load, two.balls.load)
        assert relative(three.balls.load, one.balls.load) < 1e-6


def test_forces_balance_on_shaft_and_housing():
    for parts in (double_nut(), fixed_axis((150.0, 80.0, 600.0))):
        found = solved(parts)
        assert found.equilibrium.force_residual < 1e-11
        assert found.equilibrium.moment_residual < 1e-11
        assert all(h.residual < 1e-11 for h in found.housings)
        for s in found.sets:  # what a set does to the shaft it does to its outer part, backwards
            assert np.abs(s.force + s.reaction[:3]).max() < 1e-11 * np.abs(s.balls.load).max()


def pulled(*sets, force=700.0, segments=()):
    """These sets on a shaft that is pulled at its left end, which is held but for its axis."""
    supports, loads = (Support(0.0, ALL_BUT_AXIAL),), (Load(0.0, (0.0, 0.0, force)),)
    return solved(assembly(*sets, segments=segments, supports=supports, loads=loads))


def test_nuts_on_a_rigid_shaft_share_a_load_by_their_balls():
    found = pulled(nut("a", 0.12, count=8), nut("b", 0.2, count=20), segments=(Segment(0.0, 0.3, 30.0),))
    assert [s.force[2] for s in found.sets] == pytest.approx([-200.0, -500.0], rel=1e-5)


def test_nuts_on_an_elastic_shaft_share_a_load_as_their_stiffness_says():
    sets = nut("a", 0.1, count=8), nut("b", 0.2, count=16)
    thick = Segment(0.0, 0.14, 3.0), Segment(0.14, 0.16, 5e-3), Segment(0.16, 0.3, 3.0)  # elastic between the nuts only
    a, b = (pulled(*sets, force=force, segments=thick) for force in (700.0, 700.7))
    rise = [y.force[2] - x.force[2] for x, y in zip(a.sets, b.sets, strict=True)]
    bent = (b.centreline - a.centreline).T
    moved = [np.array([np.interp(s.of.position, b.centreline_z, column) for column in bent]) for s in a.sets]
    assert sum(rise) == pytest.approx(-0.7, rel=1e-9)
    assert moved[1][2] < 0.9 * moved[0][2]
    for s, motion, force in zip(a.sets, moved, rise, strict=True):  # thin stretch: each nut tilts and turns in its own way
        assert force == pytest.approx(-float(s.stiffness[2] @ motion), rel=1e-3)


def on_springs(parts, result, loads):
    """Motions of the shaft's nodes by loads on them, its bearings replaced by their tangent stiffness at their nodes."""
    system = build_assembly_arrays(parts)
    s = system.structure
    n = s.nodes.size
    K = np.zeros((6 * n, 6 * n))
    K += dense(beam_stiffness_band(np.diff(s.nodes), s.section_stiffnesses.T))
    for b, solved_set in zip(system.ball_sets, result.sets, strict=True):
        at = 6 * b.problem.first_nodes[0, 0 if b.problem.used_flanks[0] else 1]
        reach = np.eye(6)
        z = s.nodes[at // 6] - b.of.position
        reach[0, 4], reach[1, 3] = -z, z
        K[at : at + 6, at : at + 6] += reach.T @ solved_set.stiffness @ reach
    free = ~s.fixed[:n].ravel()
    q = np.zeros(6 * n)
    q[free] = np.linalg.solve(K[np.ix_(free, free)], loads.ravel()[free])
    return q.reshape(n, 6)


def test_shaft_on_bearings_is_the_shaft_on_springs_to_first_order():
    parts = replace(fixed_axis(), sets=fixed_axis().sets[:4], housings=())
    direction = np.array([60.0, -30.0, 200.0])

    def loaded(size):
        return replace(parts, loads=(Load(0.15, tuple(size * direction), (0.0, size * 0.4, 0.0)),))

    rest = solved(loaded(0.0))
    linear = on_springs(loaded(1.0), rest, build_assembly_arrays(loaded(1.0)).structure.load)
    sizes = (1.0, 0.5, 0.25, 0.125)
    errors = [relative((solved(loaded(size)).centreline - rest.centreline) / size, linear) for size in sizes]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 0.01
    assert np.all(orders > 0.85)
    assert errors[0] > 1e-4  # the bearings are no springs: there is something to converge


def test_tangent_stiffness_is_the_slope_of_the_motion():
    low, found, high = (solved(fixed_axis((0.0, 0.0, force))) for force in (499.5, 500.0, 500.5))
    slope = 1.0 / (high.housings[0].motion[2] - low.housings[0].motion[2])
    assert found.stiffness[2, 2] == pytest.approx(slope, rel=1e-6)
    assert np.isnan(found.stiffness[0, 0])  # the carriage cannot move sideways


@pytest.mark.parametrize("parts", [double_nut(), fixed_axis((150.0, 80.0, 600.0))], ids=["double nut", "axis"])
def test_mirror_image_carries_the_mirrored_loads(parts):
    here, there = solved(parts), solved(mirrored(parts))
    for a, b in zip(here.sets, there.sets, strict=True):
        assert relative(b.balls.load[:, [1, 0, 3, 2]], a.balls.load) < 1e-10
        assert relative(b.force, a.force * [1.0, 1.0, -1.0]) < 1e-10
