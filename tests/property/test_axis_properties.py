"""Several rolling sets on one shaft: what must hold exactly, whatever the numbers are."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import assembly, bearing, double_nut, fixed_axis, mirrored, nut, one_set, solved
from tests.helpers import ALL_BUT_AXIAL, FLANK_ERRORS, NO_PROFILES, dense, relative, small_screw

from rollbench.lowfi.statics.axis.system import build_assembly_arrays
from rollbench.lowfi.statics.kernel.beam import add_element_stiffness
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.axis import Housing, Segment, diagonal_stiffness
from rollbench.meshes.parts import Load, Support

CASES = {
    "axial": {"count": 12, "turns": 2.0, "lead": 12e-3, "force": (0.0, 0.0, 900.0)},
    "preloaded": {"count": 12, "force": (0.0, 0.0, 900.0), "oversize": 7e-6},
    "sideways": {"count": 12, "force": (300.0, 0.0, 0.0), "moment": (0.0, 1.0, 0.0), "oversize": 7e-6, "hand": "left"},
    "bearing": {"count": 9, "lead": 0.0, "turns": 1.0, "force": (200.0, 0.0, -900.0)},
}


@pytest.mark.parametrize("case", CASES)
def test_one_set_is_the_model_of_one_set(case):
    scene = small_screw(**CASES[case])
    if case == "preloaded":
        scene = replace(scene, errors=replace(FLANK_ERRORS, balls=scene.errors.balls, **NO_PROFILES))
    alone, found = solve_static(scene, engine="compiled"), solved(one_set(scene))
    assert alone.converged
    of_set = found.sets[0].balls
    assert relative(of_set.load, alone.load) < 1e-11
    loaded = alone.load > 1e-6 * alone.load.max()
    assert np.abs(of_set.contact_angle - alone.contact_angle)[loaded].max() < 1e-10
    assert relative(found.sets[0].force, alone.equilibrium.contact_force) < 1e-10


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


def test_nuts_on_a_rigid_shaft_share_a_load_by_their_balls():
    sets = nut("a", 0.12, count=8), nut("b", 0.2, count=20)
    thick = (Segment(0.0, 0.3, 30.0),)
    supports, loads = (Support(0.0, ALL_BUT_AXIAL),), (Load(0.0, (0.0, 0.0, 700.0)),)
    found = solved(assembly(*sets, segments=thick, supports=supports, loads=loads))
    assert [s.force[2] for s in found.sets] == pytest.approx([-200.0, -500.0], rel=1e-5)


def test_nuts_on_an_elastic_shaft_share_a_load_as_their_stiffness_says():
    sets = nut("a", 0.1, count=8), nut("b", 0.2, count=16)
    supports = (Support(0.0, ALL_BUT_AXIAL),)
    thick = Segment(0.0, 0.14, 3.0), Segment(0.14, 0.16, 5e-3), Segment(0.16, 0.3, 3.0)  # elastic between the nuts only
    base = assembly(*sets, segments=thick, supports=supports, loads=(Load(0.0, (0.0, 0.0, 700.0)),))
    raised = replace(base, loads=(Load(0.0, (0.0, 0.0, 700.7)),))
    a, b = solved(base), solved(raised)
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
    for e, (length, section) in enumerate(zip(np.diff(s.nodes), system.structure_arrays.sections, strict=True)):
        band = np.zeros((12, 12))
        add_element_stiffness(band, 0, length, section)
        K[6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += dense(band)
    for b, solved_set in zip(system.ball_sets, result.sets, strict=True):
        at = 6 * b.problem.first_nodes[0, 0 if b.problem.used_flanks[0] else 1]
        reach = np.eye(6)
        z = s.nodes[at // 6] - b.rolling_set.position
        reach[0, 4], reach[1, 3] = -z, z
        K[at : at + 6, at : at + 6] += reach.T @ solved_set.stiffness @ reach
    free = ~s.fixed[:n].ravel()
    q = np.zeros(6 * n)
    q[free] = np.linalg.solve(K[np.ix_(free, free)], loads.ravel()[free])
    return q.reshape(n, 6)


def test_shaft_on_bearings_is_the_shaft_on_springs_to_first_order():
    parts = replace(fixed_axis(), sets=fixed_axis().sets[:4], housings=())
    direction = np.array([60.0, -30.0, 200.0])

    def state(size):
        loads = (Load(0.15, tuple(size * direction), (0.0, size * 0.4, 0.0)),)
        return solved(replace(parts, loads=loads))

    rest = state(0.0)
    probe = replace(parts, loads=(Load(0.15, tuple(direction), (0.0, 0.4, 0.0)),))
    linear = on_springs(probe, rest, build_assembly_arrays(probe).structure.load)
    errors = [relative((state(t).centreline - rest.centreline) / t, linear) for t in (1.0, 0.5, 0.25, 0.125)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 0.01
    assert np.all(orders > 0.85)
    assert errors[0] > 1e-4  # the bearings are no springs: there is something to converge


def test_tangent_stiffness_is_the_slope_of_the_motion():
    parts = fixed_axis((0.0, 0.0, 500.0))
    low, high = (
        solved(replace(parts, housings=(replace(parts.housings[0], force=(0.0, 0.0, 500.0 + d)),))) for d in (-0.5, 0.5)
    )
    slope = 1.0 / (high.housings[0].motion[2] - low.housings[0].motion[2])
    assert solved(parts).stiffness[2, 2] == pytest.approx(slope, rel=1e-6)
    assert np.isnan(solved(parts).stiffness[0, 0])  # the carriage cannot move sideways


@pytest.mark.parametrize("parts", [double_nut(), fixed_axis((150.0, 80.0, 600.0))], ids=["double nut", "axis"])
def test_mirror_image_carries_the_mirrored_loads(parts):
    here, there = solved(parts), solved(mirrored(parts))
    for a, b in zip(here.sets, there.sets, strict=True):
        assert relative(b.balls.load[:, [1, 0, 3, 2]], a.balls.load) < 1e-10
        assert relative(b.force, a.force * [1.0, 1.0, -1.0]) < 1e-10


def test_envelope_grows_in_proportion_to_the_number_of_sets():
    def size(count):
        places = 0.02 + 0.26 * (np.arange(count) + 0.5) / count
        sets = [replace(bearing(f"b{i}", z, "+z"), housing=f"h{i}") for i, z in enumerate(places)]
        housings = tuple(Housing(f"h{i}", z, (), diagonal_stiffness((1e8,) * 6)) for i, z in enumerate(places))
        return int(build_assembly_arrays(assembly(*sets, housings=housings)).structure_arrays.row_offsets[-1])

    assert size(32) / size(16) == pytest.approx(2.0, rel=0.03)
    joined = [nut(f"n{i}", z) for i, z in enumerate((0.05, 0.1, 0.15, 0.2))]
    held = (Housing("h", 0.1, (), diagonal_stiffness((1e8,) * 6)),)
    apart = int(build_assembly_arrays(assembly(*joined)).structure_arrays.row_offsets[-1])
    together = int(
        build_assembly_arrays(
            assembly(*(replace(s, housing="h") for s in joined), housings=held)
        ).structure_arrays.row_offsets[-1]
    )
    assert together < 1.7 * apart
