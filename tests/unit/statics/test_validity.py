"""Warnings where a solution leaves the range in which the models hold."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL, small_screw

from rollbench.lowfi.statics.contacts import hertz_without_errors
from rollbench.lowfi.statics.static import solve_static
from rollbench.lowfi.statics.validity import DENT_PRESSURE, LARGE, contact_size_warnings
from rollbench.lowfi.warned import ResultWarning, join_brief_warnings
from rollbench.meshes.parts import BallErrors, Errors, SideErrors, Support


def words(scene):
    return " | ".join(solve_static(scene).warnings)


def pressed(force):
    return small_screw(8, force=(0.0, 0.0, force))


def test_pressure_that_leaves_a_dent_is_told_from_there_on():
    """p = 1.5 F^(1/3)/(pi C_a C_b): the force at which the source's screw reaches 4.2 GPa."""
    result = solve_static(pressed(4000.0))
    constants = hertz_without_errors(pressed(4000.0))
    most = float(constants.pressure(result.load).max())
    factor = (DENT_PRESSURE / most) ** 3
    assert "GPa" not in words(pressed(4000.0 * factor * 0.9))
    assert "contact(s) above 4.2 GPa" in words(pressed(4000.0 * factor * 1.1))


def test_ellipses_too_large_for_a_half_space_are_told_from_there_on():
    radius = 3e-3
    assert contact_size_warnings(np.full((2, 4), 0.999 * LARGE * radius), radius) == []
    assert contact_size_warnings(np.full((2, 4), 1.001 * LARGE * radius), radius)[0].kind == "size"


def turned(angle):
    """A lightly loaded screw that its support turns about its axis."""
    held = tuple((name, angle if name == "rz" else 0.0) for name, _ in ALL_BUT_AXIAL)
    return replace(pressed(100.0), supports=(Support(0.0, held),))


def bent(slope):
    """The ball's centre is 0.476 mm from that of the groove; a slope rho' shifts the centre of curvature by as much.
    At 45 deg the profile is where it would be without."""
    return replace(pressed(300.0), errors=Errors(SL=SideErrors(profile=(0.25 * np.pi * slope, -slope))))


#: The land's edge lies at 48 deg, the contacts at 45 deg, and half an ellipse takes more than 3 deg.
LOW = replace(pressed(3000.0), screw=replace(pressed(1.0).screw, outer_diameter=29.32e-3))


BEYOND = [
    ("beyond the groove's arc", LOW, pressed(500.0)),
    ("rotates by 60 mrad", turned(0.06), turned(0.04)),
    ("not unique", bent(3e-4), bent(2e-6)),
]


@pytest.mark.parametrize(("told", "scene", "without"), BEYOND)
def test_what_leaves_the_range_is_told(told, scene, without):
    assert told in words(scene)
    assert words(without) == ""


@pytest.mark.parametrize(("extra", "wedged"), [(5e-6, True), (-5e-6, False)])
def test_balls_wedged_against_one_another_are_told(extra, wedged):
    """Neighbours that would just touch, one of them 5 um larger or smaller."""
    scene = small_screw(8, lead=0.0, force=(0.0, 0.0, 100.0))
    step = 2.0 * np.arcsin(scene.balls.radius / scene.track.pitch_radius)
    places = (0.0, step, np.pi, np.pi + 0.9)
    errors = Errors(balls=BallErrors(listed=((2, extra),)))
    scene = replace(scene, balls=replace(scene.balls, azimuths=places), errors=errors)
    assert ("balls 1 and 2 overlap" in words(scene)) is wedged


def test_a_warning_keeps_its_kind_in_a_copy_of_another_process() -> None:
    one = ResultWarning("rotation", "turned", "rotations of 60 mrad")
    copy = pickle.loads(pickle.dumps(one))
    assert (copy, copy.kind, copy.brief) == (one, "rotation", "rotations of 60 mrad")
    joined = join_brief_warnings((one, one.with_part_name("nut 1"), ResultWarning("edge", "cut")))
    assert joined.endswith(": rotations of 60 mrad; nut 1: rotations of 60 mrad")
    assert join_brief_warnings((ResultWarning("edge", "cut"),)) == ""
