"""Liu's model on scenes: against Mei's bars, the case's chain, its mirror image and rigid bodies."""

from dataclasses import replace
from math import cos, sqrt

import numpy as np
import pytest

from rollbench.compare.cases.liu import evidence
from rollbench.compare.errors import InputError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.results.solving import solve_with_results
from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.as_source.liu.model import nut_as_spring_row, solve_liu
from rollbench.lowfi.as_source.mei import nut_tensile_stiffness, solve_mei
from rollbench.meshes.helix import lead_angle
from rollbench.meshes.parts import BallErrors, Calibration, Errors, Support
from rollbench.meshes.section import screw_section

CASE, QUIET = scene("lin-case1"), ModelOptions(estimate_beam_mesh_error=False)


@pytest.mark.parametrize("name", ["lin-case2", "unseen-63x20", "external-thk-bnf-3205-7p5", "liu-drawn"])
def test_with_constant_angles_it_is_mei_s_model_of_an_elastic_nut(name):
    """Both starts, circuits with gaps between them, balls too large and too small; another set of equations."""
    s = replace(scene(name), calibration=Calibration())
    ours, other = solve_liu(s, law="constant"), solve_mei(s, elastic_nut=True)
    assert ours.load == pytest.approx(other.load, abs=1e-8 * other.load.max())
    # the screw against the nut at the loaded end: Mei's nut also gives way from its held face to the first ball
    ends = [np.interp(s.loads[0].at, r.centreline_z, r.centreline[:, 2]) for r in (ours, other)]
    face = ours.z.min() - (s.nut.position - 0.5 * s.nut.length)
    assert ends[1] - ends[0] == pytest.approx(s.loads[0].force[2] * face / nut_tensile_stiffness(s), rel=1e-5)


def pushed(s, force):
    return replace(s, loads=(replace(s.loads[0], force=(0.0, 0.0, force)),))


def like_the_case(name, load):
    """A scene of Liu's screw with the nut that gives the compliance of the case's calibration."""
    s = scene(name)
    lost = evidence.calibrated_model().compliance / (s.track.lead / 26.0) - 1.0 / screw_section(s).EA
    area = 1.0 / (lost * s.nut.material.youngs_modulus)
    bore = 2.0 * (s.track.pitch_radius + s.balls.radius * cos(s.track.contact_angle))
    nut = replace(s.nut, outer_diameter=sqrt(4.0 * area / np.pi + bore**2))
    return pushed(replace(s, nut=nut, calibration=Calibration()), load)


@pytest.mark.parametrize(("name", "error"), [("liu-screw", 0.0), ("liu-small", -2.0)])
def test_its_loads_are_those_of_the_case(name, error):
    for load in (1000.0, 5000.0):
        s = like_the_case(name, load)
        found = run_model(s, "liu", QUIET).load
        assert found[:, 0] == pytest.approx(evidence.solve_with_error_of_ball_33(error, load).load, rel=1e-8, abs=1e-8)
        assert np.array_equal(found[:, 0], found[:, 3])


def test_the_publication_s_screw_is_solved_with_its_calibrated_stiffness():
    """Q78/Q1 without errors at 5 kN is 0.862 as printed; from the assumed cross-sections it is 0.907."""
    s = scene("liu-screw")
    by_keys, by_sections = (run_model(x, "liu", QUIET).load[[0, -1], 0] for x in (s, replace(s, calibration=Calibration())))
    assert by_keys[1] / by_keys[0] == pytest.approx(0.862, abs=1e-5)
    assert by_sections[1] / by_sections[0] == pytest.approx(0.907, abs=1e-3)
    assert run_model(s, "lin", QUIET).load == pytest.approx(
        run_model(replace(s, calibration=Calibration()), "lin", QUIET).load, rel=1e-12
    )


def test_rigid_bodies_share_equally_at_the_turned_angle():
    s = scene("unseen-16x5")
    steel = replace(s.nut.material, youngs_modulus=1e6 * s.nut.material.youngs_modulus)
    stiff = replace(s, nut=replace(s.nut, material=steel), ingredients=replace(s.ingredients, screw="rigid"))
    assert nut_as_spring_row(stiff).liu_chain.compliance < 1e-5 * nut_as_spring_row(s).liu_chain.compliance
    r = solve_liu(stiff)
    each = s.loads[0].force[2] / s.ball_count
    assert r.load[:, 0] * np.sin(r.contact_angle[:, 0]) * cos(lead_angle(s.track)) == pytest.approx(each, rel=1e-4)
    assert r.contact_angle[:, 0].min() > s.track.contact_angle


def test_stiffness_is_the_tangent_or_over_the_step():
    s = scene("liu-drawn")
    s = replace(s, ingredients=replace(s.ingredients, load_step=600.0))
    answers = solve_with_results(s, "liu", QUIET)
    result = answers.solution
    at = [solve_liu(pushed(s, force)).centreline[0, 2] for force in (4999.5, 5000.5, 5000.0, 5600.0)]
    shaft = abs(s.loads[0].at - result.z.min()) / screw_section(s).EA
    assert 1.0 / answers.load_point.tangent == pytest.approx((at[1] - at[0]) / 1.0, rel=1e-5)
    assert 1.0 / answers.axial.stiffness_over_load_step == pytest.approx((at[3] - at[2]) / 600.0 - shaft, rel=1e-4)
    assert answers.axial.stiffness_over_load_step > answers.load_point.tangent


REFUSED = [
    ("errors.balls.oversize", {"errors": Errors(balls=BallErrors(oversize=1e-6))}),
    ("errors.lead_offset", {"errors": Errors(lead_offset=1e-6)}),
    ("supports", {"supports": (*CASE.supports, Support(0.0, (("uz", 0.0),)))}),
    ("loads", {"loads": (replace(CASE.loads[0], at=CASE.nut.position),)}),
    ("loads", {"loads": (*CASE.loads, replace(CASE.loads[0], at=CASE.screw.length))}),
]


@pytest.mark.parametrize(("key", "change"), REFUSED)
def test_what_it_does_not_know_is_refused(key, change):
    other = replace(CASE, **change)
    assert MODELS["liu"].covers_scene(CASE)
    assert not MODELS["liu"].covers_scene(other)
    with pytest.raises(InputError) as refused:
        run_model(other, "liu", QUIET)
    assert refused.value.key == key
