"""Balls of whole screws and bearings one by one: closed forms, older solvers, ellipses of their contacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe
from tests.helpers import ALL_BUT_AXIAL, small_screw, solved, with_ingredients
from tests.whole_screws import AXIAL, MU, scene_of, single, state

from rollbench.compare.cases.lin.evidence.source_cases import four_point_bearing, screw_groove
from rollbench.lowfi.friction.bearing import solve_bearing
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.friction.screw.motion import solve_ball_motion
from rollbench.lowfi.friction.whole.contacts import contacts_of_result
from rollbench.lowfi.friction.whole.losses import CAUSES, BallsUnderLoad, ball_friction
from rollbench.lowfi.statics.contacts import hertz_with_errors
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Load, Motion, Support

HELIX = replace(screw_groove(), nut_speed=7.0, screw_speed=0.0)
#: Forces [N] of a four-point contact, and what turns its angles [rad].
FOUR, TURNED = (100.0, 80.0, 75.0, 105.0), np.array([0.02, -0.01, 0.03, 0.0])


def ring_at(angle, force, groove, clearance=0.0, count=9):
    """A rigid bearing of the groove, free to move but not to tilt, its force at ``angle`` from the axis."""
    held = (("rx", 0.0), ("ry", 0.0), ("rz", 0.0))
    push = (force * np.sin(angle), 0.0, force * np.cos(angle))
    scene = scene_of(groove, 2.0 * np.pi * np.arange(count) / count)
    scene = replace(scene, supports=(Support(0.1, held),), loads=(Load(0.1, push),))
    errors = replace(scene.errors, balls=replace(scene.errors.balls, oversize=-clearance))
    return with_ingredients(replace(scene, errors=errors), screw="rigid", hertz="error-free")


def test_ring_under_axial_load_spins_at_one_ring_only():
    """Two-point contact: both ends of the ball roll, and all spin is where it costs less, (3/8) mu F a E(e) per ball."""
    scene = small_screw(9, 8.0 / 9.0, lead=0.0, force=AXIAL)
    found = state(scene)
    at, rows = found.contacts, []
    for i in range(9):
        loaded = np.flatnonzero(at.force[i] > 0.0)
        a, b = at.a[i, loaded], at.b[i, loaded]
        moment = 0.375 * 0.1 * at.force[i, loaded] * a * ellipe(1.0 - (b / a) ** 2)
        rows.append(moment.min() * np.sin(at.angle[i, loaded[0]]))
    assert found.friction_sums.friction_torque == pytest.approx(sum(rows), rel=1e-9)
    spin = CAUSES.index("spin")
    assert found.ball_friction.loss[..., spin].sum() == pytest.approx(found.friction_sums.power, rel=1e-9)
    assert found.ball_friction.sticking_contacts.sum() == 9


def test_a_bearing_without_load_has_no_friction():
    idle = solve_bearing(replace(four_point_bearing(tilt=False), force=0.0, clearance=1e-6), 0.3)
    assert idle.torque[0] == idle.input_power[0] == idle.force.max() == 0.0
    assert idle.converged.all()


@pytest.mark.parametrize("angle", [0.1, 0.7, 1.4])
def test_four_point_ring_is_that_of_the_bearing_pairs(angle):
    case = four_point_bearing(tilt=False)
    expected = solve_bearing(case, angle)
    scene = ring_at(angle, case.force, case.groove, case.clearance, case.count)
    found = state(scene, motion=Motion(20.0 * np.pi))
    assert np.allclose(found.contacts.force, expected.force[0], rtol=0.0, atol=1e-9 * expected.force.max())
    assert found.friction_sums.friction_torque == pytest.approx(expected.torque[0], rel=1e-10)
    assert found.friction_sums.input_power == pytest.approx(expected.input_power[0], rel=1e-10)


@pytest.mark.parametrize("lead", [20e-3, -20e-3])
@pytest.mark.parametrize("force", [FOUR, (0.0, 60.0, 60.0, 0.0), (40.0, 90.0, 130.0, 0.0)])
def test_ball_of_a_helix_moves_as_in_the_screw(lead, force):
    groove, angle = replace(HELIX, lead=lead), HELIX.contact_angle + TURNED
    expected, at = solve_ball_motion(groove, np.array(force), angle), single(force, angle, groove)
    found = ball_friction(BallsUnderLoad(scene_of(groove), at, MU, Motion(7.0, "nut")))
    assert found.total_power_lost == pytest.approx(expected.motion.loss, rel=1e-10)
    moving = [found.orbital_speed[0], *found.rotation[0]]
    assert np.allclose(moving, expected.motion.unknown_velocities, rtol=1e-10, atol=1e-10)
    assert np.allclose(found.contact_wrenches(at.normals)[0], expected.wrench, rtol=1e-9, atol=1e-12)


def integral(found, at, i, s, mu):
    """mu p |v| over the ellipse of a contact [W] by midpoints in polar coordinates; p times a b in the area's place."""
    radius, turn = np.meshgrid((np.arange(400) + 0.5) / 400, 2.0 * np.pi * np.arange(400) / 400, indexing="ij")
    half_x, half_z = (at.a[i, s], at.b[i, s]) if at.across[i, s] else (at.b[i, s], at.a[i, s])
    x, z = half_x * radius * np.cos(turn), half_z * radius * np.sin(turn)
    vx, vz, spin = found.contact_motions[i, s]
    pressure = 1.5 * at.force[i, s] / np.pi * np.sqrt(1.0 - radius**2)
    area = radius / 400.0 * 2.0 * np.pi / 400.0
    return float((mu * pressure * np.hypot(vx + spin * z, vz - spin * x) * area).sum())


@pytest.mark.parametrize("across", [True, False])
def test_loss_is_the_integral_over_an_ellipse_whichever_way_it_lies(across):
    at = replace(single(FOUR, np.full(4, HELIX.contact_angle), HELIX), across=np.full((1, 4), across))
    found = ball_friction(BallsUnderLoad(scene_of(HELIX), at, MU, Motion(7.0, "nut")))
    assert not found.sticking_contacts.any()
    assert at.b.max() < 0.5 * at.a.min()
    for s in range(4):
        assert found.loss[0, s].sum() == pytest.approx(integral(found, at, 0, s, 0.1), rel=1e-4)


def test_flat_grooves_have_their_long_axis_along_the_path():
    base = small_screw(3, 0.7, force=(0.0, 0.0, 60.0), screw="rigid", hertz="error-free")
    nut, screw = (replace(part, groove_radius=r) for part, r in ((base.nut, 80.0 * 2.778e-3), (base.screw, 2.95e-3)))
    at = state(replace(base, nut=nut, screw=screw)).contacts
    assert at.across[:, :2].all()
    assert not at.across[:, 2:].any()


def test_ellipses_are_those_that_the_scene_s_ingredients_name():
    base = small_screw(4, 0.8, oversize=8e-6, force=AXIAL, screw="rigid")
    base = replace(base, nut=replace(base.nut, groove_radius=base.screw.groove_radius))
    groove = ScrewGroove(2.778e-3, 3.254e-3, 16.5e-3, 20e-3, 0.25 * np.pi, 210e9, 0.28, 0.1, 1.0)
    found = {}
    for kind in ("nominal", "error-free", "actual", "as printed"):
        scene = with_ingredients(base, hertz=kind)
        at = contacts_of_result(scene, solved(scene))
        cube = np.cbrt(at.force)
        found[kind] = at.a / cube, at.b / cube
    for kind, hertz in (("error-free", "right"), ("as printed", "as printed")):
        h = replace(groove, hertz=hertz).contact_hertz_constants
        assert np.allclose(found[kind], (np.tile(h.C_a, (4, 1)), np.tile(h.C_b, (4, 1))), rtol=1e-12)
    drawn = hertz_with_errors(base, draw_geometry_with_errors(base, ball_layout(base)))
    assert np.allclose(found["nominal"][0], drawn.C_a, rtol=1e-12)
    growth = found["nominal"][0] / found["error-free"][0]
    assert growth.min() > 1.001, "larger balls conform more closely to the groove"
    assert np.abs(found["actual"][0] / found["nominal"][0] - 1.0).max() > 1e-5


def test_contacts_take_the_specimen_that_was_solved():
    base = small_screw(5, 0.8, oversize=5e-6, force=AXIAL, fixed=ALL_BUT_AXIAL)
    scene = replace(base, errors=replace(base.errors, balls=replace(base.errors.balls, sigma=0.5e-6)))
    result = solved(scene, member=3)
    at = contacts_of_result(scene, result, 3)
    assert np.array_equal(at.ball_radius, draw_geometry_with_errors(scene, ball_layout(scene), 3).ball_radii)
    assert not np.array_equal(at.ball_radius, contacts_of_result(scene, result, 0).ball_radius)
