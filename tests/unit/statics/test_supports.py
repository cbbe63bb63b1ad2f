"""Supports that contradict each other, that fall on one node, and that turn a shaft without lead."""

import tracemalloc
from dataclasses import replace

import pytest
from tests.helpers import four_flank_problem, small_screw, solved, with_ingredients
from tests.shipped_texts import changed

from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.scene_file import scene_from_text
from rollbench.lowfi.statics.held import find_unresisted_motions
from rollbench.lowfi.statics.problem import find_support_contradiction
from rollbench.lowfi.statics.static import solve_elastic, solve_static
from rollbench.meshes.parts import FREEDOMS, Load, Support

RIGID = '\n[ingredients]\nscrew = "rigid"\n'


def shipped(name, *changes, extra=""):
    return scene_from_text(changed(name, *changes) + extra, f"{name}.toml")


def test_rigid_screw_with_contradictory_supports_is_refused_and_with_those_that_agree_solved():
    with pytest.raises(SceneError) as error:
        shipped("lin-case3-offset", extra=RIGID)
    said = "supports[1].displace.ux", "ux = 300 um at 800 mm", "allowed: 0 um", "ux of supports[0], ry of supports[0]"
    assert all(words in str(error.value) for words in said), error.value
    unchecked = with_ingredients(catalogue.scene("lin-case3-offset"), screw="rigid")
    for model in ("lin", "refined"):
        with pytest.raises(InputError, match=r"contradict each other.*ux at 800 mm \(supports\[1\]\) is 300 um"):
            run_model(unchecked, model)
    turned = ('fix = ["ux", "uy", "rx", "ry", "rz"]', 'fix = ["ux", "uy", "rx", "rz"]\ndisplace = { ry = "0.375 mrad" }')
    scene = shipped("lin-case3-offset", turned, extra=RIGID)
    result = solve_static(scene)
    assert result.converged
    assert result.centreline[-1, 0] == pytest.approx(300e-6, rel=1e-9)
    assert result.centreline[0, 4] == pytest.approx(0.375e-3, rel=1e-9)


def test_one_freedom_held_twice_within_ten_micrometres_is_refused():
    def both(apart):
        second = f'\n[[supports]]\nat = "{800 + 1e-3 * apart - 0.05} mm"\nfix = ["ux"]\n'
        return shipped("lin-case3", ('at = "800 mm"\n', 'at = "799.95 mm"\n'), extra=second)

    scene = both(11)
    assert len(scene.supports) == 3
    for apart in (5, 10):
        with pytest.raises(SceneError, match=r"supports\[2\].fix: .*10 um or less apart.*supports\[1\]"):
            both(apart)
        twice = replace(scene, supports=(*scene.supports[:2], Support(0.79995 + 1e-6 * apart, (("ux", 1e-4),))))
        with pytest.raises(ValueError, match="fix ux"):
            solve_static(twice)


RING = small_screw(9, lead=0.0, fixed=(), force=(300.0, 0.0, 500.0))


@pytest.mark.parametrize("solve", [solve_static, solve_elastic])
def test_a_prescribed_rotation_turns_the_whole_shaft_without_lead(solve):
    still, turned = (solve(replace(RING, supports=(Support(0.1, (("rz", angle),)),))) for angle in (0.0, 2e-3))
    assert turned.converged
    assert turned.centreline[:, 5] == pytest.approx(2e-3, rel=1e-12)
    assert turned.load == pytest.approx(still.load, rel=1e-9, abs=1e-6)


def test_a_shaft_without_lead_twists_evenly_between_two_prescribed_rotations():
    length = RING.screw.length
    ends = (Support(0.0, (("rz", 1e-3),)), Support(length, (("rz", 3e-3),)))
    result = solved(replace(RING, supports=ends))
    assert result.centreline[:, 5] == pytest.approx(1e-3 + 2e-3 * result.centreline_z / length, rel=1e-9)
    moment = solved(replace(RING, supports=ends[:1], loads=(*RING.loads, Load(length, moment=(0, 0, 1.0)))))
    twist = moment.centreline[:, 5] - 1e-3
    assert twist / twist[-1] == pytest.approx(result.centreline_z / length, abs=1e-6)


def test_a_rotation_that_is_held_twice_is_said_as_a_rotation():
    """What the supports before it make it, in rad and not over the pitch radius."""
    first = Support(0.02, (("ux", 0.0), ("uy", 0.0), ("uz", 0.0), ("rx", 1e-3), ("ry", -2e-3), ("rz", 3e-3)))
    for name, implied in (("rx", 1e-3), ("ry", -2e-3), ("rz", 3e-3), ("ux", -2e-3 * 0.1)):
        found = find_support_contradiction(replace(small_screw(), supports=(first, Support(0.12, ((name, 0.0),)))))
        assert (found.contradicted.freedom, found.implied) == (name, pytest.approx(implied, rel=1e-9))


def test_free_motions_of_ten_thousand_balls_take_no_square_of_them():
    """A full singular value decomposition of their motions takes a minute and gigabytes."""
    scene = small_screw(10_000, 1.0, screw="rigid", fixed=(("ux", 0.0), ("uy", 0.0), ("rx", 0.0), ("ry", 0.0)))
    problem = four_flank_problem(scene)
    tracemalloc.start()
    found = find_unresisted_motions(problem)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.description == "screw motion along the helix"
    assert len(found.pins) == 1
    assert most < 50e6


def test_the_squeeze_by_a_moved_support_is_continuous_as_the_load_goes_to_zero():
    pulled = tuple((name, 40e-6 if name == "uz" else 0.0) for name in FREEDOMS)
    screws = (small_screw(8, fixed=pulled, force=(0.0, 0.0, size)) for size in (0.0, 1e-3, 1.0))
    least, *others = (solve_elastic(screw).load for screw in screws)
    assert least.max() > 100.0
    for load in others:
        assert load == pytest.approx(least, abs=1e-3 * least.max())
