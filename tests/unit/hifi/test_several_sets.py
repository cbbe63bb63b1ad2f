"""Several sets on one shaft in 3D: judged against sets alone, a half turn of the whole, housings, and preloads by force."""

from dataclasses import replace

import numpy as np
import pytest
from tests.two_balls import SMALL

from rollbench.compare.reference.tasks import ball_slices_by_set
from rollbench.compare.scenes import catalogue
from rollbench.hifi.meshing import settings
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import mesh_and_condense_geometry
from rollbench.hifi.several_sets import meshed_geometry_of_each_set, solve_nuts_on_one_shaft
from rollbench.meshes.axis import Assembly, Housing, RollerRow, RollingSet, diagonal_stiffness
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import FREEDOMS, Load, Support

pytestmark = pytest.mark.xdist_group("several sets in 3D")
USUAL = {"modes": settings.Settings.modes, "ball_modes": settings.Settings.ball_modes}
COARSE = replace(SMALL, b_over_h=1.0, ball_fine=1.2e-3, ball_coarse=2.4e-3, **USUAL)
LENGTH = 0.4
BUT_UZ = tuple((name, 0.0) for name in FREEDOMS if name != "uz")
CUT = catalogue.scene("lin-case1-cut")
PARTS = replace(
    CUT,
    track=replace(CUT.track, phase=0.0),
    screw=replace(CUT.screw, length=LENGTH),
    nut=replace(CUT.nut, length=0.032),
    balls=replace(CUT.balls, azimuths=tuple(np.radians([-120.0, 0.0, 120.0]))),
    solid=replace(CUT.solid, shaft=None),
    supports=(),
    loads=(),
)


def ball_nut(name, position, offset):
    parts = replace(PARTS, name=name, nut=replace(PARTS.nut, position=position))
    return RollingSet(name, "ball nut", parts, position, offset=offset)


def pulled(at, force=300.0):
    """Supports and loads of a shaft that is held but for its axis and pulled along it, both at one place."""
    return {"supports": (Support(at, BUT_UZ),), "loads": (Load(at, (0.0, 0.0, force)),)}


#: Two nuts of three balls, 16 mm apart, shifted away from each other; the shaft is loaded and held but for its axis.
PAIR = Assembly("pair", "", PARTS.screw, (ball_nut("first", 0.2, -4e-6), ball_nut("second", 0.248, 4e-6)), **pulled(0.16))
ALONE = replace(PAIR, sets=(ball_nut("alone", 0.2, 0.0),))
ROLLERS = RollerRow(9, 8e-3, 1e-2, 0.3, 0.03, 1e-2, PARTS.nut.material)


@pytest.fixture(scope="module")
def prepared(_one_submodel, tmp_path_factory):
    """Set-ups of an assembly on a coarse mesh; parts that were made are kept."""
    kept, cache = {}, Cache(tmp_path_factory.mktemp("several"))

    def set_up(of_set, expected):
        parts = of_set.parts_without_errors
        sides = tuple(sorted({s for side in expected.nearly_touching_flanks() for s in (side, 3 - side)}))
        if (parts, sides) not in kept:
            semi, reach = map(settings.round_up_lengths, (expected.typical_semi_axes(), expected.largest_reach()))
            kept[parts, sides] = mesh_and_condense_geometry(
                parts, sides, replace(COARSE, semi=semi, reach=reach), cache=cache
            )
        return kept[parts, sides]

    def set_ups(assembly):
        expected = settings.estimate_contacts_of_each_set(assembly)
        return list(map(set_up, meshed_geometry_of_each_set(assembly), expected))

    return set_ups


def assert_loads(found, wanted, close):
    """Contact forces within a share of the largest."""
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=close * wanted.max())


@pytest.mark.slow
def test_each_set_carries_what_it_carries_alone(prepared):
    """Held between the nuts, the shaft is two shafts: each nut has the loads of a scene of one set under its own force."""
    first, _ = meshed_geometry_of_each_set(PAIR)
    middle = first.origin_on_shaft + first.parts_without_errors.screw.length
    held, setups = replace(PAIR, **pulled(middle)), prepared(PAIR)
    found = solve_nuts_on_one_shaft(held, setups)
    assert found.status == "converged"
    assert max(found.unbalanced_ball_force, found.unbalanced_force_along_groove, found.unbalanced_shaft_force) < 1e-9
    assert sum(wrench[2] for wrench in found.forces_on_shaft) == pytest.approx(-300.0, rel=1e-9)
    for of_set, setup, balls, wrench in zip(
        meshed_geometry_of_each_set(held), setups, ball_slices_by_set(held), found.forces_on_shaft, strict=True
    ):
        alone = replace(of_set.parts_with_errors, **pulled(middle - of_set.origin_on_shaft, -wrench[2]))
        assert_loads(found.contact_loads[balls], solve_reference(setup, alone).contact_loads, 2e-5)


@pytest.mark.slow
def test_an_assembly_of_one_set_is_the_scene_of_it(prepared):
    (setup,), (of_set,) = prepared(ALONE), meshed_geometry_of_each_set(ALONE)
    scene = replace(of_set.parts_with_errors, **pulled(0.16 - of_set.origin_on_shaft))
    found, wanted = solve_nuts_on_one_shaft(ALONE, [setup]), solve_reference(setup, scene)
    assert_loads(found.contact_loads, wanted.contact_loads, 1e-12)
    np.testing.assert_allclose(found.centreline_motion, wanted.centreline_motion, rtol=0.0, atol=1e-15)


@pytest.mark.slow
def test_nuts_on_housings(prepared):
    """A carriage on very stiff springs holds its nuts; one that is pulled while the shaft is held moves the other way."""
    setups = prepared(PAIR)
    wanted = solve_nuts_on_one_shaft(PAIR, setups)
    on = replace(PAIR, sets=tuple(replace(s, housing="carriage") for s in PAIR.sets))
    springs = diagonal_stiffness((1e14,) * 3 + (1e12,) * 3)
    stiff = replace(on, housings=(Housing("carriage", 0.21, stiffness=springs),))
    slides = Housing("carriage", 0.21, fixed=BUT_UZ, force=(0.0, 0.0, -300.0))
    slid = replace(on, housings=(slides,), supports=(Support(0.16, (*BUT_UZ, ("uz", 0.0))),), loads=())
    for case, close in ((stiff, 1e-6), (slid, 1e-9)):
        found = solve_nuts_on_one_shaft(case, setups)
        assert found.unbalanced_shaft_force < 1e-9
        assert_loads(found.contact_loads, wanted.contact_loads, close)
    assert found.housing_motions[0, 2] == pytest.approx(-wanted.centreline_motion[0, 2], rel=1e-9)


@pytest.mark.slow
def test_preload_by_force_is_met_without_loads(prepared):
    thrusts = zip(PAIR.sets, ("+z", "-z"), strict=True)
    forced = replace(PAIR, sets=tuple(replace(s, offset=0.0, preload=200.0, thrust=t) for s, t in thrusts), loads=())
    found = solve_nuts_on_one_shaft(forced, prepared(forced))
    np.testing.assert_allclose([wrench[2] for wrench in found.forces_on_shaft], [-200.0, 200.0], rtol=1e-4)
    assert found.nut_offsets[0] == pytest.approx(-found.nut_offsets[1], rel=1e-4)


def test_equal_nuts_have_equal_bodies():
    beyond = Support(0.35, (("ux", 0.0),))  # the shaft goes on beyond the second, as beyond the first
    first, second = meshed_geometry_of_each_set(replace(PAIR, supports=(*PAIR.supports, beyond)))
    assert first.parts_without_errors == second.parts_without_errors
    assert second.origin_on_shaft - first.origin_on_shaft == pytest.approx(0.048)
    length = 0.032 + 2 * 0.008  # half the way to one another, on both sides
    assert first.parts_without_errors.screw.length == pytest.approx(length)


def test_expected_contacts_of_one_set_are_those_of_its_scene():
    alone = replace(ALONE.sets[0].parts, supports=ALONE.supports, loads=ALONE.loads)
    (found,), wanted = settings.estimate_contacts_of_each_set(ALONE), settings.estimate_contacts_of_scene(alone)
    np.testing.assert_array_equal(found.loads, wanted.loads)
    pressed = settings.estimate_contacts_of_each_set(replace(PAIR, loads=()))
    assert [e.nearly_touching_flanks() for e in pressed] == [(0, 3), (1, 2)]


def test_what_has_no_3d_body_is_refused():
    for change, why in (
        ({"thermal_strain": 1e-5}, "thermal expansion"),
        ({"sets": (ball_nut("a", 0.2, 0.0), ball_nut("b", 0.23, 0.0))}, "a and b overlap by 2 mm"),
        ({"sets": (replace(PAIR.sets[0], carrier="hub"),)}, "first: .* inner ring"),
        ({"sets": (replace(PAIR.sets[0], parts=ROLLERS),)}, "roller bearing"),
    ):
        with pytest.raises(ValueError, match=why):
            meshed_geometry_of_each_set(replace(PAIR, **change))
