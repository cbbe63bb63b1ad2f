"""What a stretched or bent screw does to its contacts by Poisson's ratio: closed forms, reciprocity, and where nothing."""

from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import relative, small_screw

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.bodies import screw_response_to_end_wrench
from rollbench.lowfi.compliance.parts import REFINED, grooved_section, reduce_to_compliance_geometry, smooth_body
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.problem import Problem, build_problem
from rollbench.lowfi.statics.static import solve_elastic
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, Load, Scene, Support
from rollbench.meshes.section import tube_section

CASE = catalogue.scene("lin-case1")
HELD = Support(0.0, tuple((name, 0.0) for name in FREEDOMS))
RIGHT = CASE.screw.length
BETWEEN = replace(CASE, supports=(HELD, replace(HELD, at=RIGHT)), loads=())
SMOOTH = replace(REFINED, flank=False)
TUBE = smooth_body(reduce_to_compliance_geometry(CASE), True, REFINED)
PLAIN = tube_section(2.0 * TUBE.outer_radius, 2.0 * TUBE.bore_radius, TUBE.material)
NU = TUBE.material.poissons_ratio


def problem_of(scene: Scene) -> Problem:
    layout = ball_layout(scene)
    section = grooved_section(reduce_to_compliance_geometry(scene), True)
    drawn, every = draw_geometry_with_errors(scene, layout), np.ones(4, dtype=bool)
    return build_problem(scene, drawn, layout, every, everything=True, section=section)


def squeeze_of(problem, used=(0, 1), strain=0.0):
    """The shaft, and what section forces do to its contacts."""
    shaft, balls = statics_shaft.build_shaft(problem), slice(0, problem.layout.z.size)
    stretch = statics_shaft.build_shaft_stretch(problem, problem.scene, problem.layout, SMOOTH, used, balls)
    return shaft, statics_shaft.couple_section_forces(shaft, used, [stretch], strain)


def test_contacts_feel_the_wrench_above_them() -> None:
    """Statics at the stretch's high end, whose closed forms are in the tests of `lowfi.compliance.bodies`: held at the
    left end, loaded at the right one."""
    force, moment = np.array([300.0, -200.0, 8e3]), np.array([40.0, 20.0, 5.0])
    problem = problem_of(replace(CASE, supports=(HELD,), loads=(Load(RIGHT, tuple(force), tuple(moment)),)))
    response = screw_response_to_end_wrench(CASE, problem.layout, SMOOTH)
    arm = np.array([0.0, 0.0, RIGHT - response.high_end])
    wanted = response.contact_motions @ np.concatenate([force, moment + np.cross(arm, force)])
    assert relative(squeeze_of(problem)[1].flank_motions_by_loads, wanted) < 1e-6


def test_what_is_held_at_its_length_and_warm_is_pressed() -> None:
    """A beam between fixed ends takes N = - EA alpha T, which squeezes outwards; its nodes do not move at all."""
    problem = problem_of(BETWEEN)
    strain = 2e-4
    problem.load[0, 2] -= problem.section.EA * strain
    problem.load[-1, 2] += problem.section.EA * strain
    moved = squeeze_of(problem, strain=strain)[1].flank_motions_by_loads.reshape(2, -1, 2)
    wanted = NU * TUBE.contact_radius * strain * problem.section.EA / PLAIN.EA
    np.testing.assert_allclose(moved[..., 0], wanted, rtol=1e-2)


def test_an_end_that_nothing_holds_adds_nothing() -> None:
    """A free upper end: no section force above the contacts; a support there makes the difference, symmetric."""
    free = problem_of(replace(CASE, supports=(HELD,), loads=()))
    held = problem_of(BETWEEN)
    cut = int(held.first_nodes.max())
    assert not statics_shaft.is_loaded_above_node(free, cut)
    assert statics_shaft.is_loaded_above_node(held, cut)
    none, some = (squeeze_of(p)[1].added_compliance for p in (free, held))
    assert np.abs(some - some.T).max() == 0.0
    assert np.abs(none).max() == 0.0 < np.abs(some).max()


def test_contacts_that_press_lengthen_the_screw() -> None:
    """Reciprocity: radial forces F push the ends apart by nu r F / EA, as tension N moves their points inward by
    nu r N / EA; held at both ends, the screw answers with N = nu r F / L, EA being the beam's over the smooth body's."""
    problem = problem_of(BETWEEN)
    shaft, squeeze = squeeze_of(problem, (0,))
    force = np.zeros((problem.layout.z.size, 2))
    force[:, 0] = -100.0
    loads = squeeze.nodal_loads_of_jumps(force.ravel())
    taken = shaft.nodal_forces(shaft.motions_under_loads(loads[:, None])[:, 0]) - loads
    wanted = NU * TUBE.contact_radius * 100.0 * len(force) / RIGHT * problem.section.EA / PLAIN.EA
    assert taken[2] == pytest.approx(wanted, rel=1e-2)
    assert taken[-4] == pytest.approx(-wanted, rel=1e-2)


def test_a_support_within_the_nut_is_the_load_that_it_carries() -> None:
    """Its reaction as a load on the same section gives the same contacts, and moves the section to where it was held."""
    at = 0.1
    held = small_screw(count=8, turns=1.5, lead=12e-3, oversize=3e-6, load_at=0.15, force=(60.0, 0.0, 900.0))
    held = replace(held, supports=(HELD, Support(at, (("ux", 2e-6), ("rz", -1e-5)))))
    found = solve_elastic(held, everything=True)
    taken = found.reactions[1]
    free = replace(held, supports=(HELD,), loads=(*held.loads, Load(at, tuple(taken[:3]), tuple(taken[3:]))))
    loaded = solve_elastic(free, everything=True)
    assert found.status == loaded.status == "converged"
    assert relative(loaded.load, found.load) < 3e-5  # each evaluates its contact laws at a typical force of its own
    moved = loaded.centreline[int(np.abs(loaded.centreline_z - at).argmin())]
    assert moved[[0, 5]] == pytest.approx([2e-6, -1e-5], rel=1e-3)
