"""Friction of whole screws and bearings at their static loads: exact balances, closed forms, symmetries, older solvers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipe

from compare.evidence.source_cases import four_point, table_3_6
from lowfi.friction.bearing.pairs import solve_bearing
from lowfi.friction.screw.groove import ScrewGroove
from lowfi.friction.screw.motion import ball_motion
from lowfi.friction.whole import feedback
from lowfi.friction.whole.contacts import StaticContacts, contacts_of
from lowfi.friction.whole.feedback import feed_back, seats
from lowfi.friction.whole.losses import CAUSES, ball_friction, ball_path
from lowfi.friction.whole.state import friction_state
from lowfi.friction.whole.torque import about_axis, sum_up
from lowfi.statics.problem import drawn_hertz
from meshes.errors import specimen
from meshes.helix import BallLayout, ball_layout
from meshes.parts import Balls, Friction, Load, Material, Motion, Nut, Scene, Screw, Support, Track
from tests.friction_oracles import ball_cell, coupled_ball
from tests.helpers import ALL_BUT_AXIAL, FLANK_ERRORS, small_screw, solved, with_ingredients

MU, TURN = Friction(0.1, 0.1), Motion(10.0)
AXIAL = (0.0, 0.0, 800.0)


def two_starts():
    """A preloaded left-hand screw of two starts with a side force, a moment, unlike grooves and all flank errors."""
    base = small_screw(8, 0.9, hand="left", oversize=4e-6, force=(30.0, 10.0, -600.0), moment=(0.0, 2.0, 0.0))
    errors = replace(FLANK_ERRORS, balls=base.errors.balls)
    return replace(base, track=replace(base.track, starts=2, lead=24e-3), errors=errors)


SCENES = {
    "two-point": lambda: small_screw(force=AXIAL),
    "four-point": lambda: small_screw(oversize=5e-6, force=AXIAL),
    "left hand": lambda: small_screw(hand="left", force=(20.0, 0.0, -300.0), oversize=3e-6),
    "two starts": two_starts,
    "ring": lambda: small_screw(9, 8.0 / 9.0, lead=0.0, oversize=2e-6, force=(50.0, 0.0, 400.0)),
    "rigid screw, actual Hertz": lambda: small_screw(force=AXIAL, oversize=2e-6, screw="rigid", hertz="actual"),
    "printed Hertz": lambda: small_screw(force=AXIAL, hertz="as printed"),
}


def state(scene, friction=MU, motion=TURN):
    return friction_state(scene, solved(scene), friction, motion)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("friction", [MU, Friction(0.05, 0.15), Friction(0.2, 0.01)], ids=str)
def test_power_in_is_dissipation(name, friction):
    scene = SCENES[name]()
    for motion in (TURN, Motion(-3.0, "nut")):
        found = state(scene, friction, motion)
        t = found.torque
        assert found.balls.converged
        assert t.power > 0.0
        assert t.input_power == pytest.approx(t.power, rel=1e-8), "moments in space times speed are the losses"
        assert -t.helical[1] == pytest.approx(t.helical[0], rel=1e-8), "what the screw drives, the nut resists"
        assert found.balls.loss.min() >= -1e-12 * t.power, "no contact and no cause gains power"
        speed, travel = t.speed, t.ratio * t.speed
        assert t.on_screw * speed + t.load * travel == pytest.approx(t.power, rel=1e-8)


@pytest.mark.parametrize("name", SCENES)
def test_axial_load_is_what_the_scene_applies(name):
    scene = SCENES[name]()
    assert state(scene).torque.load == pytest.approx(scene.loads[0].force[2], rel=1e-7)


def test_forward_and_backward_frame_the_ideal_torque():
    t = state(small_screw(force=AXIAL)).torque
    ideal = 800.0 * 20e-3 / (2.0 * np.pi)
    assert t.forward - t.friction == pytest.approx(ideal, rel=1e-9)
    assert t.backward + t.friction == pytest.approx(ideal, rel=1e-9)
    forward, backward = t.efficiency
    assert forward == pytest.approx(ideal / t.forward, rel=1e-12)
    assert backward == pytest.approx(2.0 - 1.0 / forward, rel=1e-12)
    assert not t.locking
    assert t.on_screw == pytest.approx(-t.backward, rel=1e-12), "+z load, right hand, turning forward: the load drives"
    assert state(small_screw(force=AXIAL), motion=Motion(-10.0)).torque.on_screw == pytest.approx(-t.forward, rel=1e-12)


def test_small_lead_and_preload_lock_the_screw():
    scene = small_screw(6, 0.9, lead=8e-3, oversize=8e-6, force=(0.0, 0.0, 30.0))
    t = state(scene, Friction(0.2, 0.2)).torque
    assert t.locking
    assert t.backward < 0.0
    assert t.efficiency[0] < 0.5


def test_reversed_motion_reverses_everything_and_loses_the_same():
    scene = two_starts()
    there, back = state(scene), state(scene, motion=Motion(-10.0))
    assert back.torque.friction == pytest.approx(there.torque.friction, rel=1e-9)
    assert np.allclose(back.balls.orbit, -there.balls.orbit, rtol=1e-9)
    assert np.allclose(back.balls.force, -there.balls.force, atol=1e-6)
    assert np.allclose(back.balls.loss, there.balls.loss, rtol=1e-6, atol=1e-9 * there.torque.power)


def test_turning_nut_is_a_turning_screw_in_another_frame():
    scene = two_starts()
    screw, nut = state(scene), state(scene, motion=Motion(-10.0, "nut"))
    assert nut.torque.on_screw == pytest.approx(screw.torque.on_screw, rel=1e-9)
    assert np.allclose(nut.balls.orbit, screw.balls.orbit - 10.0, rtol=1e-9)


def test_speed_scales_losses_and_not_torques():
    scene = two_starts()
    slow, quick = state(scene), state(scene, motion=Motion(1e4))
    assert quick.torque.friction == pytest.approx(slow.torque.friction, rel=1e-9)
    assert quick.torque.power == pytest.approx(1e3 * slow.torque.power, rel=1e-9)


def mirrored(scene):
    """The scene in a mirror that turns y: the other hand, azimuths, side forces and moments reversed."""
    track = replace(scene.track, hand="left" if scene.track.hand == "right" else "right", phase=-scene.track.phase)
    (x, y, z), (mx, my, mz) = scene.loads[0].force, scene.loads[0].moment
    load = Load(scene.loads[0].at, (x, -y, z), (-mx, my, -mz))
    balls = replace(scene.balls, azimuths=tuple(-a for a in scene.balls.azimuths))
    return replace(scene, track=track, balls=balls, loads=(load,))


@pytest.mark.parametrize("oversize", [0.0, 4e-6])
def test_left_hand_is_the_mirrored_right_hand(oversize):
    scene = small_screw(7, 0.9, oversize=oversize, force=(60.0, 25.0, 500.0), moment=(0.5, 1.0, 0.0))
    one, other = state(scene), state(mirrored(scene), motion=Motion(-10.0))
    assert other.torque.friction == pytest.approx(one.torque.friction, rel=1e-9)
    assert other.torque.on_screw == pytest.approx(-one.torque.on_screw, rel=1e-9)
    assert other.torque.load == pytest.approx(one.torque.load, rel=1e-9)
    assert np.allclose(other.balls.orbit, -one.balls.orbit, rtol=1e-8)
    assert np.allclose(other.balls.loss, one.balls.loss, rtol=1e-6, atol=1e-8 * one.torque.power)


def test_without_friction_the_load_does_all_the_work():
    scene = two_starts()
    free, rough = state(scene, Friction(0.0, 0.0)), state(scene)
    t = free.torque
    assert t.power == 0.0
    assert t.friction == 0.0
    assert t.efficiency == (1.0, 1.0)
    assert t.on_screw == pytest.approx(-t.ratio * t.load, rel=1e-12)
    assert np.allclose(free.balls.orbit, rough.balls.orbit, rtol=1e-12), "the limit of small equal coefficients"
    half = state(scene, Friction(0.05, 0.05)).torque
    assert half.friction == pytest.approx(0.5 * rough.torque.friction, rel=1e-12)


def test_one_rough_groove_carries_the_ball_along_and_loses_nothing():
    found = state(two_starts(), Friction(0.0, 0.2))
    assert found.torque.power == pytest.approx(0.0, abs=1e-12)
    assert found.balls.converged


def ring_at(angle, force, groove, clearance=0.0, count=9):
    """A rigid bearing of the groove, free to move but not to tilt, its force at ``angle`` from the axis."""
    steel = Material(groove.young, groove.poisson)
    held = (("rx", 0.0), ("ry", 0.0), ("rz", 0.0))
    push = (force * np.sin(angle), 0.0, force * np.cos(angle))
    pitch, ball = groove.pitch_radius, groove.ball_radius
    scene = Scene(
        "ring",
        "ring",
        Track(pitch, 0.0, groove.contact_angle),
        Screw(0.04, 2.0 * pitch, groove.groove_radius, steel),
        Nut(0.02, 0.04, 2.0 * (pitch + 4.0 * ball), groove.groove_radius, steel),
        Balls(ball, steel, tuple(2.0 * np.pi * np.arange(count) / count)),
        supports=(Support(0.02, held),),
        loads=(Load(0.02, push),),
    )
    errors = replace(scene.errors, balls=replace(scene.errors.balls, oversize=-clearance))
    return with_ingredients(replace(scene, errors=errors), screw="rigid", hertz="error-free")


def test_ring_under_axial_load_spins_at_one_ring_only():
    """Two-point contact: both ends of the ball roll, and all spin is where it costs less, (3/8) mu F a E(e) per ball."""
    scene = small_screw(9, 8.0 / 9.0, lead=0.0, force=AXIAL)
    found = state(scene)
    at, rows = found.at, []
    for i in range(9):
        loaded = np.flatnonzero(at.force[i] > 0.0)
        a, b = at.a[i, loaded], at.b[i, loaded]
        moment = 0.375 * 0.1 * at.force[i, loaded] * a * ellipe(1.0 - (b / a) ** 2)
        rows.append(moment.min() * np.sin(at.angle[i, loaded[0]]))
    assert found.torque.friction == pytest.approx(sum(rows), rel=1e-9)
    spin = CAUSES.index("spin")
    assert found.balls.loss[..., spin].sum() == pytest.approx(found.torque.power, rel=1e-9)
    assert found.balls.rest.sum() == 9


@pytest.mark.parametrize("angle", [0.1, 0.7, 1.4])
def test_four_point_ring_is_that_of_the_bearing_pairs(angle):
    case = four_point(tilt=False)
    expected = solve_bearing(case, angle)
    scene = ring_at(angle, case.force, case.groove, case.clearance, case.count)
    found = state(scene, motion=Motion(20.0 * np.pi))
    assert np.allclose(found.at.force, expected.load.force, rtol=0.0, atol=1e-9 * expected.load.force.max())
    assert found.torque.friction == pytest.approx(expected.torque, rel=1e-10)
    assert found.torque.input_power == pytest.approx(expected.input_power, rel=1e-10)


def single(force, angle, groove):
    """Contacts of one ball at azimuth 0 with the groove's own Hertz constants."""
    h, at = groove.constants, np.array(force, dtype=float)[None, :]
    cube = np.cbrt(np.maximum(at, 1e-9 * at.max()))
    c, s = np.cos(groove.lead_angle), np.sin(groove.lead_angle)
    layout = BallLayout(
        np.zeros(1),
        np.zeros(1),
        np.array([[groove.pitch_radius, 0.0, 0.0]]),
        np.array([[1.0, 0.0, 0.0]]),
        np.array([[0.0, -s, c]]),
        np.array([[0.0, c, s]]),
    )
    return StaticContacts(
        np.array([groove.ball_radius]),
        at,
        np.array(angle, dtype=float)[None, :],
        h.C_a * cube,
        h.C_b * cube,
        np.ones((1, 4), dtype=bool),
        layout,
    )


def scene_of(groove):
    """A screw with the kinematics of the groove."""
    steel = Material(groove.young, groove.poisson)
    track = Track(groove.pitch_radius, abs(groove.lead), groove.contact_angle, "left" if groove.lead < 0.0 else "right")
    return Scene(
        "one",
        "one",
        track,
        Screw(0.2, 2.0 * groove.pitch_radius, groove.groove_radius, steel),
        Nut(0.1, 0.05, 0.1, groove.groove_radius, steel),
        Balls(groove.ball_radius, steel, (0.0,)),
    )


@pytest.mark.parametrize("lead", [20e-3, -20e-3])
@pytest.mark.parametrize("force", [(100.0, 80.0, 75.0, 105.0), (0.0, 60.0, 60.0, 0.0), (40.0, 90.0, 130.0, 0.0)])
def test_ball_of_a_helix_moves_as_in_the_screw_s_kernels(lead, force):
    groove = replace(table_3_6(), lead=lead, nut_speed=7.0, screw_speed=0.0)
    angle = groove.contact_angle + np.array([0.02, -0.01, 0.03, 0.0])
    expected = ball_motion(groove, np.array(force), angle, fast=False)
    found = ball_friction(scene_of(groove), single(force, angle, groove), MU, Motion(7.0, "nut"))
    assert found.power == pytest.approx(expected.motion.loss, rel=1e-10)
    assert np.allclose([found.orbit[0], *found.rotation[0]], expected.motion.q, rtol=1e-10, atol=1e-10)
    assert np.allclose(found.wrench(single(force, angle, groove).normals)[0], expected.wrench, rtol=1e-9, atol=1e-12)


def coupled(mu, load):
    """A ball whose loads know of its friction: contacts, power lost, torque that drives the screw by sums in space."""
    groove = replace(table_3_6(), mu=mu, nut_speed=0.0, screw_speed=5.0)
    held = coupled_ball(ball_cell(groove, np.zeros(4), 2e-6, "z", np.array([load])), "ball and screw", fast=False)
    at, scene = single(held.load.force[0], held.load.angle[0], groove), scene_of(groove)
    assert held.converged
    found = ball_friction(scene, at, Friction(mu, mu), Motion(5.0))
    total = found.wrench(at.normals)
    total[..., :3] -= at.force[..., None] * at.normals
    axial, moment = about_axis(at, total)
    return found.power, float(axial[0, :2].sum()), float(moment[0, :2].sum()), scene, at


def test_torque_by_virtual_work_is_exact_with_feedback_and_of_first_order_without():
    load, ratio, left = 50.0, 20e-3 / (2.0 * np.pi), []
    for mu in (0.01, 0.005, 0.0025):
        power, axial, moment, scene, _ = coupled(mu, load)
        assert axial == pytest.approx(load, rel=1e-8), "on the balls: what the load presses with, friction included"
        assert moment == pytest.approx(power / 5.0 - ratio * load, rel=1e-8), "T Omega + F r Omega = P"
        bare = coupled_ball(ball_cell(replace(table_3_6(), mu=0.0), np.zeros(4), 2e-6, "z", np.array([load])), "none")
        at = single(bare.load.force[0], bare.load.angle[0], table_3_6())
        first = sum_up(scene, at, ball_friction(scene, at, Friction(mu, mu), Motion(5.0)), Motion(5.0))
        assert first.load == pytest.approx(load, rel=1e-8)
        left.append(abs(first.on_screw - moment))
    assert left[0] > 0.0
    assert 3.0 < left[0] / left[1] < 5.0, "the error falls with the square of the coefficient"
    assert 3.0 < left[1] / left[2] < 5.0


def fed(groove, load, oversize, mu, drive):
    """Feedback on one ball, begun at its loads without friction."""
    bare = coupled_ball(ball_cell(replace(groove, mu=0.0), np.zeros(4), oversize, "z", np.array([load])), "none")
    at, scene = single(bare.load.force[0], bare.load.angle[0], groove), scene_of(groove)
    turned = replace(at, angle=np.full((1, 4), groove.contact_angle))
    centre = -groove.reach * turned.normals[..., [0, 2]]
    place = seats(at, groove.constants.C[None, :], np.full((1, 4), groove.reach - oversize), centre)
    return scene, feed_back(scene, at, place, Friction(mu, mu), drive)


@pytest.mark.parametrize("mu", [0.02, 0.1, 0.2])
@pytest.mark.parametrize(("oversize", "load"), [(6e-6, 50.0), (2e-6, 50.0), (0.0, 200.0), (-3e-6, 200.0)])
def test_feedback_on_a_ball_is_that_of_the_coupled_solver(mu, oversize, load):
    """Four flanks, two of them, and a third one that friction makes the ball touch."""
    groove = replace(table_3_6(), mu=mu, nut_speed=0.0, screw_speed=5.0)
    expected = coupled_ball(ball_cell(groove, np.zeros(4), oversize, "z", np.array([load])), "ball and screw")
    assert expected.converged
    scene, found = fed(groove, load, oversize, mu, Motion(5.0))
    assert not found.failed.any()
    assert found.change <= 1e-5
    assert np.allclose(found.at.force[0], expected.load.force[0], rtol=0.0, atol=2e-4 * load)
    assert found.friction.power == pytest.approx(expected.motion.motion.loss, rel=2e-4)
    t = sum_up(scene, found.at, found.friction, Motion(5.0), coupled=True)
    assert t.load == pytest.approx(load, rel=1e-5)
    assert t.input_power == pytest.approx(t.power, rel=1e-8)


COUPLED = Friction(0.1, 0.1, (), "ball")


@pytest.mark.parametrize("name", [n for n in SCENES if n != "ring"])
def test_feedback_keeps_loads_balances_and_matters_most_in_two_point_contact(name):
    scene = SCENES[name]()
    found, t = state(scene, COUPLED), state(scene, COUPLED).torque
    assert found.coupled
    assert not found.unsettled
    assert t.load == pytest.approx(scene.loads[0].force[2], rel=1e-5)
    assert t.input_power == pytest.approx(t.power, rel=1e-8)
    assert found.bare.friction == pytest.approx(state(scene).torque.friction, rel=1e-9)
    four = name in ("four-point", "left hand", "two starts")
    assert 0.95 < t.friction / found.bare.friction < 1.2 if four else t.friction > 1.3 * found.bare.friction
    assert t.forward != t.backward


def test_feedback_mirrors_reverses_and_leaves_rings_alone():
    scene = small_screw(5, 0.9, oversize=4e-6, force=(60.0, 25.0, 500.0))
    one, other = state(scene, COUPLED).torque, state(mirrored(scene), COUPLED, Motion(-10.0)).torque
    back = state(scene, COUPLED, Motion(-10.0)).torque
    assert other.friction == pytest.approx(one.friction, rel=1e-6)
    assert (back.power, back.reverse_power) == pytest.approx((one.reverse_power, one.power), rel=1e-9)
    assert (back.forward, back.backward) == pytest.approx((one.forward, one.backward), rel=1e-6)
    assert not state(SCENES["ring"](), COUPLED).coupled
    assert not state(scene, Friction(0.0, 0.0, (), "ball")).coupled


def integral(found, at, i, s, mu):
    """mu p |v| over the ellipse of a contact [W] by midpoints in polar coordinates; p times a b in the area's place."""
    radius, turn = np.meshgrid((np.arange(400) + 0.5) / 400, 2.0 * np.pi * np.arange(400) / 400, indexing="ij")
    half_x, half_z = (at.a[i, s], at.b[i, s]) if at.across[i, s] else (at.b[i, s], at.a[i, s])
    x, z = half_x * radius * np.cos(turn), half_z * radius * np.sin(turn)
    vx, vz, spin = found.motion[i, s]
    pressure = 1.5 * at.force[i, s] / np.pi * np.sqrt(1.0 - radius**2)
    area = radius / 400.0 * 2.0 * np.pi / 400.0
    return float((mu * pressure * np.hypot(vx + spin * z, vz - spin * x) * area).sum())


@pytest.mark.parametrize("across", [True, False])
def test_loss_is_the_integral_over_an_ellipse_whichever_way_it_lies(across):
    groove = replace(table_3_6(), nut_speed=7.0, screw_speed=0.0)
    at = single((100.0, 80.0, 75.0, 105.0), np.full(4, groove.contact_angle), groove)
    at = replace(at, across=np.full((1, 4), across))
    found = ball_friction(scene_of(groove), at, MU, Motion(7.0, "nut"))
    assert not found.rest.any()
    assert at.b.max() < 0.5 * at.a.min()
    for s in range(4):
        assert found.loss[0, s].sum() == pytest.approx(integral(found, at, 0, s, 0.1), rel=1e-4)


def test_flat_grooves_have_their_long_axis_along_the_path():
    base = small_screw(3, 0.7, force=(0.0, 0.0, 60.0), screw="rigid", hertz="error-free")
    nut, screw = (replace(part, groove_radius=r) for part, r in ((base.nut, 80.0 * 2.778e-3), (base.screw, 2.95e-3)))
    at = state(replace(base, nut=nut, screw=screw)).at
    assert at.across[:, :2].all()
    assert not at.across[:, 2:].any()


def test_ellipses_are_those_that_the_scene_s_ingredients_name():
    base = small_screw(4, 0.8, oversize=8e-6, force=AXIAL, screw="rigid")
    base = replace(base, nut=replace(base.nut, groove_radius=base.screw.groove_radius))
    groove = ScrewGroove(2.778e-3, 3.254e-3, 16.5e-3, 20e-3, 0.25 * np.pi, 210e9, 0.28, 0.1, 1.0)
    found = {}
    for kind in ("nominal", "error-free", "actual", "as printed"):
        scene = with_ingredients(base, hertz=kind)
        at = contacts_of(scene, solved(scene))
        cube = np.cbrt(at.force)
        found[kind] = at.a / cube, at.b / cube
    exact, printed = groove.constants, replace(groove, hertz="as printed").constants
    for kind, h in (("error-free", exact), ("as printed", printed)):
        assert np.allclose(found[kind][0], h.C_a, rtol=1e-12)
        assert np.allclose(found[kind][1], h.C_b, rtol=1e-12)
    drawn = drawn_hertz(base, specimen(base, ball_layout(base)))
    assert np.allclose(found["nominal"][0], drawn.C_a, rtol=1e-12)
    growth = found["nominal"][0] / found["error-free"][0]
    assert growth.min() > 1.001, "larger balls conform more closely to the groove"
    assert np.abs(found["actual"][0] / found["nominal"][0] - 1.0).max() > 1e-5


def test_balls_without_load_have_no_motion_and_lose_nothing():
    scene = small_screw(6, 0.9, force=(0.0, 0.0, 100.0))
    errors = replace(scene.errors, balls=replace(scene.errors.balls, listed=((2, -20e-6),)))
    found = state(replace(scene, errors=errors))
    assert found.balls.status[1] == "no load"
    assert np.isnan(found.balls.orbit[1])
    assert found.balls.loss[1].sum() == 0.0
    assert np.isnan(found.closing[:2]).all()
    assert np.isfinite(found.torque.friction)


def test_a_larger_ball_orbits_by_its_own_radius():
    scene = small_screw(4, 0.8, oversize=5e-6, force=AXIAL)
    listed = replace(scene.errors, balls=replace(scene.errors.balls, listed=((3, 2e-6),)))
    at = contacts_of(replace(scene, errors=listed), solved(replace(scene, errors=listed)))
    assert at.ball_radius[2] - at.ball_radius[0] == pytest.approx(2e-6, rel=1e-6)
    assert ball_path(scene, TURN, at.ball_radius[2]).nominal_orbit < ball_path(scene, TURN, at.ball_radius[0]).nominal_orbit


def test_closing_speeds_are_differences_of_orbits_along_each_start():
    found = state(two_starts())
    radius = np.hypot(16.5e-3, 24e-3 / (2.0 * np.pi))
    order = np.argsort(found.at.layout.azimuth[:8])
    gain = found.balls.orbit[order[:-1]] - found.balls.orbit[order[1:]]
    assert np.allclose(found.closing[order[:-1]], radius * gain, rtol=1e-12)
    assert np.isnan(found.closing[order[-1]])
    ring = state(SCENES["ring"]())
    assert np.isfinite(ring.closing).all()
    assert ring.closing.sum() == pytest.approx(0.0, abs=1e-15)


def test_what_is_refused():
    scene = small_screw(force=AXIAL)
    result = solved(scene)
    at = contacts_of(scene, result)
    with pytest.raises(ValueError, match="at rest"):
        ball_friction(scene, at, MU, Motion(0.0))
    with pytest.raises(ValueError, match="not held"):
        contacts_of(scene, replace(result, status="not held: it turns"))


def test_contacts_take_the_specimen_that_was_solved():
    base = small_screw(5, 0.8, oversize=5e-6, force=AXIAL, fixed=ALL_BUT_AXIAL)
    scene = replace(base, errors=replace(base.errors, balls=replace(base.errors.balls, sigma=0.5e-6)))
    result = solved(scene, member=3)
    at = contacts_of(scene, result, 3)
    assert np.array_equal(at.ball_radius, specimen(scene, ball_layout(scene), 3).ball_radius)
    assert not np.array_equal(at.ball_radius, contacts_of(scene, result, 0).ball_radius)


def test_second_states_are_those_that_differ_and_settle(monkeypatch):
    scene, mu = small_screw(3, 0.7, force=(0.0, 0.0, 300.0), screw="rigid"), Friction(0.4, 0.4, coupling="ball")
    result = solved(scene)
    at = contacts_of(scene, result)
    place = feedback.seats_of(scene, result, at)
    there = feed_back(scene, at, place, mu, TURN)
    assert feedback.second_states(scene, place, at, there, mu, TURN) == ()

    def jammed(*_):
        force = there.at.force * np.array([[1.0], [3.0], [3.0]])
        return replace(there, at=replace(there.at, force=force), failed=np.array([False, False, True]))

    monkeypatch.setattr(feedback, "feed_back", jammed)
    assert feedback.second_states(scene, place, at, there, mu, TURN) == (1,)
