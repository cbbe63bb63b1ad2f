"""Warnings where a solution leaves the range in which the models hold."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import small_screw

from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_static
from rollbench.lowfi.statics.validity import DENT_PRESSURE, LARGE, contact_size_warnings
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.parts import BallErrors, Balls, Errors, SideErrors, Support


def words(scene):
    return " | ".join(solve_static(scene, engine="interpreted").warnings)


def pressed(force):
    return small_screw(8, force=(0.0, 0.0, force))


def test_a_lightly_loaded_screw_has_no_warning():
    assert words(pressed(500.0)) == ""


def test_pressure_that_leaves_a_dent_is_told_from_there_on():
    """p = 1.5 F^(1/3)/(pi C_a C_b): the force at which the source's screw reaches 4.2 GPa."""
    result = solve_static(pressed(4000.0), engine="interpreted")
    constants = hertz_without_errors(pressed(4000.0))
    most = float(constants.pressure(result.load).max())
    factor = (DENT_PRESSURE / most) ** 3
    assert "GPa" not in words(pressed(4000.0 * factor * 0.9))
    assert "contact(s) above 4.2 GPa" in words(pressed(4000.0 * factor * 1.1))


def test_ellipses_too_large_for_a_half_space_are_told_from_there_on():
    radius = 3e-3
    assert contact_size_warnings(np.full((2, 4), 0.999 * LARGE * radius), radius) == []
    assert contact_size_warnings(np.full((2, 4), 1.001 * LARGE * radius), radius)[0].kind == "size"


def test_an_ellipse_beyond_the_land_is_told():
    """The land's edge lies at 48 deg, the contacts at 45 deg, and half an ellipse takes more than 3 deg."""
    low = replace(pressed(3000.0), screw=replace(pressed(1.0).screw, outer_diameter=29.32e-3))
    assert "beyond the groove's arc" in words(low)


def test_large_rotations_are_told():
    scene = pressed(100.0)
    turned = tuple((name, 0.06 if name == "rz" else 0.0) for name in ("ux", "uy", "rx", "ry", "rz"))
    assert "rotates by 60 mrad" in words(replace(scene, supports=(Support(0.0, turned),)))
    small = tuple((name, 0.04 if name == "rz" else 0.0) for name in ("ux", "uy", "rx", "ry", "rz"))
    assert "rotates by" not in words(replace(scene, supports=(Support(0.0, small),)))


@pytest.mark.parametrize(("extra", "wedged"), [(5e-6, True), (-5e-6, False)])
def test_balls_wedged_against_one_another_are_told(extra, wedged):
    """Neighbours that would just touch, one of them 5 um larger or smaller."""
    scene = small_screw(8, lead=0.0, force=(0.0, 0.0, 100.0))
    step = 2.0 * np.arcsin(scene.balls.radius / scene.track.pitch_radius)
    places = (0.0, step, np.pi, np.pi + 0.9)
    scene = replace(
        scene,
        balls=Balls(scene.balls.radius, scene.balls.material, places),
        errors=Errors(balls=BallErrors(listed=((2, extra),))),
    )
    assert ("balls 1 and 2 overlap" in words(scene)) is wedged


@pytest.mark.parametrize(("slope", "unique"), [(2e-6, True), (3e-4, False)])
def test_a_profile_that_bends_as_far_as_the_ball_is_away_is_told(slope, unique):
    """The ball's centre is 0.476 mm from that of the groove; a slope rho' shifts the centre of curvature by as much.
    At 45 deg the profile is where it would be without."""
    scene = pressed(300.0)
    errors = Errors(SL=SideErrors(profile=(0.25 * np.pi * slope, -slope)))
    assert ("not unique" in words(replace(scene, errors=errors))) is not unique


def test_a_warning_keeps_its_kind_in_a_copy_of_another_process() -> None:
    one = ResultWarning("rotation", "turned", "rotations of 60 mrad")
    copy = pickle.loads(pickle.dumps(one))
    assert (copy, copy.kind, copy.brief) == (one, "rotation", "rotations of 60 mrad")
    assert join_brief_warnings((one, one.with_part_name("nut 1"), ResultWarning("tilt", "tilted"))) == (
        "WARNING outside what the models mean: rotations of 60 mrad; nut 1: rotations of 60 mrad"
    )
    assert join_brief_warnings((ResultWarning("tilt", "tilted"),)) == ""
