"""Load distributions that can be written down: symmetric, rigid, single balls; clearance; preload; mechanisms.

In a ball's section, rigidly moved by v, the interference of a diagonal pair is |o_S + v - o_N| minus its nominal value
plus twice the ball's error, and the pair shares it as springs C F^(2/3) in series along that line.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.helpers import ALL_BUT_AXIAL, relative, small_screw, solved

from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import hertz_with_errors
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Balls, Load, Support
from rollbench.meshes.section import screw_section

BETAS = [0.3, np.pi / 4, 1.1]


def constants(scene):
    """Hertz constants of the four sides with the scene's balls, all of one size."""
    return hertz_with_errors(scene, draw_geometry_with_errors(scene, ball_layout(scene))).C[0]


def pair_constant(scene):
    C = constants(scene)
    return C[0] + C[3]


def slack_of_pair(scene):
    """Distance between opposite groove centres."""
    return scene.screw.groove_radius + scene.nut.groove_radius - 2 * scene.balls.radius


def axial_state(scene, force, count):
    """Screw motion, load per contact and contact angle of ``count`` equal balls under an axial force, tilt held."""
    alpha, beta = lead_angle(scene.track), scene.track.contact_angle
    nominal, C = slack_of_pair(scene), pair_constant(scene)
    dx, dz = nominal * np.cos(beta), nominal * np.sin(beta)

    def pair(uz):
        z = dz + uz * np.cos(alpha)
        squeeze = (uz * np.cos(alpha) * (z + dz)) / (np.hypot(dx, z) + nominal) + 2 * scene.errors.balls.oversize
        return (max(squeeze, 0.0) / C) ** 1.5, np.arctan2(z, dx)

    def balance(uz):
        load, angle = pair(uz)
        return count * load * np.sin(angle) * np.cos(alpha) - force

    uz = brentq(balance, 0.0, 1e-3, xtol=1e-20, rtol=1e-14)
    return uz, *pair(uz)


@pytest.mark.parametrize("screw", ["rigid", "beam"])
@pytest.mark.parametrize("beta", BETAS)
def test_two_balls_opposite_each_other(beta, screw):
    """F/(2 sin beta') each, beta' the contact angle under load."""
    scene = small_screw(count=2, lead=0.0, beta=beta, force=(0.0, 0.0, 400.0), screw=screw)
    result = solved(scene)
    uz, load, angle = axial_state(scene, 400.0, 2)
    assert result.load == pytest.approx(np.tile([load, 0.0, 0.0, load], (2, 1)), rel=1e-9)
    assert 400.0 / (2 * np.sin(angle)) == pytest.approx(load, rel=1e-12)
    assert angle > beta
    assert result.contact_angle[:, [0, 3]] == pytest.approx(np.full((2, 2), angle), abs=1e-9)
    if screw == "rigid":
        assert result.centreline[:, 2] == pytest.approx(uz, rel=1e-9)


@pytest.mark.parametrize("lead", [0.0, 10e-3, 30e-3])
@pytest.mark.parametrize("beta", BETAS)
@pytest.mark.parametrize(("count", "turns"), [(3, 1.0), (7, 1.0), (32, 2.0)])
def test_rigid_screw_with_balls_all_around(count, turns, beta, lead):
    """F/(N sin beta' cos alpha) each: tilt held, since a helix of finite length also carries moments."""
    scene = small_screw(count, turns, lead=lead, beta=beta, force=(0.0, 0.0, 3000.0), screw="rigid")
    result = solved(scene)
    uz, load, angle = axial_state(scene, 3000.0, count)
    assert result.load == pytest.approx(np.tile([load, 0.0, 0.0, load], (count, 1)), rel=1e-9)
    assert load == pytest.approx(3000.0 / (count * np.sin(angle) * np.cos(lead_angle(scene.track))), rel=1e-12)
    assert result.centreline[0, 2] == pytest.approx(uz, rel=1e-9)


def test_two_starts_balance_each_other():
    """Balls opposite each other at every station: equal loads without holding the tilt."""
    scene = small_screw(6, 2.0, force=(0.0, 0.0, 2000.0), screw="rigid", fixed=(("rz", 0.0),))
    scene = replace(scene, track=replace(scene.track, starts=2))
    result = solved(scene)
    uz, load, _ = axial_state(scene, 2000.0, 12)
    assert result.load == pytest.approx(np.tile([load, 0.0, 0.0, load], (12, 1)), rel=1e-9)
    assert result.centreline[0] == pytest.approx([0.0, 0.0, uz, 0.0, 0.0, 0.0], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("hand", ["right", "left"])
def test_torque_of_the_helix(hand):
    """The support takes the torque F lead / (2 pi), up to the balls' small shift against the pitch radius."""
    scene = small_screw(12, 2.0, hand=hand, force=(0.0, 0.0, 2000.0))
    torque = solved(scene).equilibrium.reaction_moment[2]
    sign = -1.0 if hand == "right" else 1.0
    assert torque == pytest.approx(sign * 2000.0 * 20e-3 / (2 * np.pi), rel=2e-3)


@pytest.mark.parametrize("name", catalogue.names_of_single_nut_scenes())
def test_shipped_scenes_are_in_equilibrium(name):
    """Contact forces at their contact points, reactions and loads, summed apart from the solver's own residual.

    That stops at 1e-12 of the largest force per node; some 70 nodes on arms of 0.4 m add up to the bounds below.
    """
    result = solved(catalogue.scene(name))
    assert result.solver.residual <= 1e-10
    assert result.equilibrium.force_residual < 1e-10
    assert result.equilibrium.moment_residual < 1e-9
    on_ball = (result.load[..., None] * result.force_direction).sum(axis=1)
    assert np.abs(on_ball).max() < 1e-9 * result.load.max()


@pytest.mark.parametrize("arm", ["nominal", "ball"])
@pytest.mark.parametrize("name", ["lin-case1", "lin-case3-offset"])
def test_lever_arm_frozen_at_the_nominal_contact_point(name, arm):
    """It costs some tenths of a per cent of a load (seed audit: about 0.2 %)."""
    scene = catalogue.scene(name)
    frozen = replace(scene, ingredients=replace(scene.ingredients, arm=arm))
    change = relative(solved(frozen).load, solved(scene).load)
    assert 5e-4 < change < 1e-2


@pytest.mark.parametrize("clearance", [0.0, 1e-6, 20e-6])
@pytest.mark.parametrize("force", [1e-3, 300.0])
def test_clearance_shifts_the_screw(force, clearance):
    """Undersized balls: the screw first runs through the gap, then the same law holds at a steeper angle."""
    scene = small_screw(5, oversize=-clearance, force=(0.0, 0.0, force), screw="rigid")
    result = solved(scene)
    uz, load, angle = axial_state(scene, force, 5)
    assert result.load[:, [0, 3]] == pytest.approx(np.full((5, 2), load), rel=1e-8)
    assert result.centreline[0, 2] == pytest.approx(uz, rel=1e-8)
    assert result.contact_angle[0, 0] == pytest.approx(angle, abs=1e-8)
    gap = np.sqrt((slack_of_pair(scene) + 2 * clearance) ** 2 - slack_of_pair(scene) ** 2 / 2)
    play = (gap - slack_of_pair(scene) / np.sqrt(2)) / np.cos(lead_angle(scene.track))
    assert uz > play
    if force < 1.0:
        assert uz == pytest.approx(play, abs=3e-9)


def test_one_ball_alone():
    """One ball carries all that the guided screw is loaded with."""
    scene = small_screw(force=(0.0, 0.0, 100.0))
    scene = replace(scene, balls=Balls(scene.balls.radius, scene.balls.material, (0.4,)))
    scene = replace(scene, supports=tuple(Support(z, ALL_BUT_AXIAL) for z in (0.0, 0.2)))
    rigid = solved(replace(scene, ingredients=replace(scene.ingredients, screw="rigid")))
    _, load, angle = axial_state(scene, 100.0, 1)
    assert rigid.load == pytest.approx(np.array([[load, 0.0, 0.0, load]]), rel=1e-9)
    assert rigid.contact_angle[0, 0] == pytest.approx(angle, abs=1e-9)
    beam = solved(scene).load
    assert beam[0, [0, 3]] == pytest.approx([load, load], rel=0.02)  # the shaft gives way
    assert not beam[0, [1, 2]].any()


def four_contacts(scene, v):
    """Loads (screw, nut) and half contact angles of a ball held by four flanks, the screw moved radially by v.

    By symmetry SL = SR and NL = NR: one unknown, the ball's radial shift.
    """
    beta, C = scene.track.contact_angle, constants(scene)
    radii = scene.screw.groove_radius, scene.nut.groove_radius

    def contact(p, body):
        """Load and angle of the screw's (0) or nut's (1) flanks with the ball's centre at p outwards of it."""
        slack = radii[body] - scene.balls.radius
        x, z = slack * np.cos(beta) + (-p if body == 0 else p), slack * np.sin(beta)
        size = np.hypot(x, z)
        # centre of the groove opposite to the contact: moving towards the contact lengthens the distance
        change = (x - slack * np.cos(beta)) * (x + slack * np.cos(beta)) / (size + slack)
        delta = scene.errors.balls.oversize + change
        return (max(delta, 0.0) / C[3 * body]) ** 1.5, np.arctan2(z, x)

    def balance(p):
        (fs, a), (fn, b) = contact(p - v, 0), contact(p, 1)
        return fn * np.cos(b) - fs * np.cos(a)

    reach = abs(v) + abs(scene.errors.balls.oversize) + 1e-9
    p = brentq(balance, -reach, reach, xtol=1e-22, rtol=1e-14)
    return contact(p - v, 0), contact(p, 1)


@pytest.mark.parametrize("oversize", [1e-6, 5e-6, 20e-6])
def test_preload_without_load(oversize):
    """All four contacts carry (2 error/(C_S + C_N))^1.5 but for the small turn of the contact angles."""
    scene = small_screw(count=8, lead=0.0, oversize=oversize, screw="rigid")
    load = solved(scene).load
    (screw, _), (nut, _) = four_contacts(scene, 0.0)
    assert load == pytest.approx(np.tile([screw, screw, nut, nut], (8, 1)), rel=1e-9)
    simple = (2 * oversize / pair_constant(scene)) ** 1.5
    assert load == pytest.approx(np.full((8, 4), simple), rel=oversize / slack_of_pair(scene))


@pytest.mark.parametrize("oversize", [0.0, 4e-6, -3e-6])
@pytest.mark.parametrize("force", [50.0, 2000.0])
def test_rigid_bearing_under_radial_load(force, oversize):
    """Stribeck's problem for four-point contact: the displacement is the root of one scalar equation."""
    scene = small_screw(count=9, lead=0.0, oversize=oversize, screw="rigid", force=(force, 0.0, 0.0), fixed=(("rz", 0.0),))
    result = solved(scene)
    azimuth = np.array(scene.balls.azimuths)

    def loads(ux):
        if oversize < 0.0:  # a ball with clearance on both sides carries nothing: solve where it closes
            return [four_contacts_or_none(scene, ux * np.cos(a)) for a in azimuth]
        return [four_contacts(scene, ux * np.cos(a)) for a in azimuth]

    def balance(ux):
        return sum(2 * n * np.cos(b) * np.cos(a) for a, (_, (n, b)) in zip(azimuth, loads(ux), strict=True)) - force

    ux = brentq(balance, 0.0, 1e-4, xtol=1e-20, rtol=1e-14)
    expected = np.array([[s, s, n, n] for (s, _), (n, _) in loads(ux)])
    assert result.load == pytest.approx(expected, rel=1e-7, abs=1e-7 * expected.max())
    assert result.centreline[0] == pytest.approx([ux, 0.0, 0.0, 0.0, 0.0, 0.0], rel=1e-9, abs=1e-15)
    assert (expected[:, 0] > 0.0).all() == (oversize > 0.0 and force < 100.0)


def four_contacts_or_none(scene, v):
    """``four_contacts`` where the radial gap is closed, else no load."""
    beta, error = scene.track.contact_angle, scene.errors.balls.oversize
    play = 0.0
    for radius in (scene.screw.groove_radius, scene.nut.groove_radius):
        slack = radius - scene.balls.radius  # the shift that brings the ball to touch both flanks of one body
        play += np.sqrt((slack - error) ** 2 - (slack * np.sin(beta)) ** 2) - slack * np.cos(beta)
    return four_contacts(scene, v) if v > play else ((0.0, 0.0), (0.0, 0.0))


def test_screw_without_support_runs_along_its_helix():
    scene = small_screw(fixed=(), force=(0.0, 0.0, 100.0))
    result = solve_static(scene)
    assert result.status.startswith("not held: screw motion along the helix")
    assert not result.converged
    assert np.isnan(result.load).all()
    turning = replace(scene, loads=(Load(0.1, moment=(0.0, 0.0, 1.0)),))
    assert solve_static(turning).status.startswith("not held: screw motion along the helix")


def test_torque_that_balances_the_axial_force_does_not_drive_the_helix():
    """F = 2 pi T / lead: nothing drives the free motion, which is then pinned and said to be."""
    scene = small_screw(12, 2.0, fixed=(), force=(0.0, 0.0, 1000.0))
    torque = -1000.0 * scene.track.lead / (2 * np.pi)
    scene = replace(scene, loads=(Load(0.1, (0.0, 0.0, 1000.0), (0.0, 0.0, torque)),))
    result = solved(scene)
    assert any("screw motion along the helix is neither driven nor resisted" in note for note in result.left_out)
    assert result.centreline[0, 5] == 0.0
    held = solved(replace(scene, supports=(Support(0.0, (("rz", 0.0),)),)))
    assert relative(result.load, held.load) < 1e-7  # the torque the pin takes now twists another part of the shaft
    # sections that stay plane along a helix resist a little by themselves: what the pin takes
    assert abs(result.equilibrium.reaction_moment[2]) < 1e-3 * abs(torque)


@pytest.mark.parametrize("model", ["lin", "lin-cell"])
def test_loads_with_another_pin_are_those_of_a_support_in_its_place(model):
    """Both pins at once, which the elastic models took for the other one, change loads by all they are."""
    scene, options = (
        small_screw(12, 2.0, fixed=()),
        ModelOptions(include_ineffective_terms=True, estimate_beam_mesh_error=False),
    )
    torque = -1000.0 * scene.track.lead / (2 * np.pi)
    scene = replace(scene, loads=(Load(0.05, (0.0, 0.0, 1000.0), (0.0, 0.0, torque)),))
    free, held = (run_model(replace(scene, supports=x), model, options) for x in ((), (Support(0.0, (("uz", 0.0),)),)))
    told = re.search(
        r"by fixing rz .* if uz is fixed instead, contact loads change by up to ([\d.e+]+) N", free.solver.notes[0]
    )
    assert float(told[1]) == pytest.approx(np.abs(held.load - free.load).max(), rel=0.05)


@pytest.mark.parametrize("screw", ["rigid", "beam"])
def test_bearing_free_to_turn_is_pinned(screw):
    scene = small_screw(9, lead=0.0, fixed=(), force=(300.0, 0.0, 500.0), screw=screw)
    result, held = solved(scene), solved(replace(scene, supports=(Support(0.1, (("rz", 0.0),)),)))
    assert result.load == pytest.approx(held.load, rel=1e-9, abs=1e-9 * held.load.max())
    notes = " ".join(result.left_out)
    assert "rotation about the screw's axis is neither driven nor resisted" in notes or "torsion" in notes
    driven = replace(scene, loads=(*scene.loads, Load(0.1, moment=(0.0, 0.0, 1.0))))
    assert solve_static(driven).status.startswith("not held: rotation about the screw's axis")


def test_one_ball_without_support_is_not_held():
    scene = replace(small_screw(fixed=(), force=(0.0, 100.0, 0.0)), balls=replace(small_screw().balls, azimuths=(0.0,)))
    result = solve_static(scene)
    assert result.status.startswith("not held: rigid motion in uy, uz, rx, ry, rz at the nut's centre")


def test_a_tilting_ball_s_mechanism_is_named_at_the_nut_not_at_the_first_node():
    """The support holds ux and uy at the nut's centre: seen from the screw's end the tilt would look like both."""
    s = small_screw(lead=0.0, fixed=(), force=(0.0, 0.0, 300.0))
    held = Support(s.nut.position, (("ux", 0.0), ("uy", 0.0), ("rz", 0.0)))
    result = solve_static(replace(s, balls=replace(s.balls, azimuths=(0.0,)), supports=(held,)))
    assert result.status.startswith("not held: rigid motion in uz, rx, ry at the nut's centre")


def test_load_away_from_the_only_ball_leaves_the_range_of_the_model():
    """A one-sided mechanism. The model's arcs are full circles, so the ball is caught at their far side: it warns."""
    scene = replace(small_screw(lead=0.0), balls=replace(small_screw().balls, azimuths=(0.0,)))
    held = (("uy", 0.0), ("uz", 0.0), ("rx", 0.0), ("ry", 0.0), ("rz", 0.0))
    away = replace(scene, supports=(Support(0.1, held),), loads=(Load(0.1, (-50.0, 0.0, 0.0)),))
    result = solve_static(away)
    assert not result.converged or any("beyond the groove's arc" in note for note in result.warnings)
    onto = solved(replace(away, loads=(Load(0.1, (50.0, 0.0, 0.0)),)))
    assert onto.load[0, [0, 2]] == pytest.approx(onto.load[0, [1, 3]], rel=1e-9)
    assert not onto.warnings


@pytest.mark.parametrize("oversize", [0.0, -10e-6])
@pytest.mark.parametrize("screw", ["rigid", "beam"])
def test_no_load_no_contact_force(screw, oversize):
    result = solved(small_screw(oversize=oversize, screw=screw))
    assert not result.load.any()
    assert not result.centreline.any()


ALL_HELD = (*ALL_BUT_AXIAL, ("uz", 0.0))


@pytest.mark.parametrize("everything", [False, True], ids=["short", "everything"])
@pytest.mark.parametrize("moment", [(0.0, 0.02, 0.0), (0.0, 2.0, 0.0), (-2.0, 1.0, 0.5), (0.0, 0.0, 0.5)])
def test_moment_on_a_shaft_that_touches_nothing(moment, everything):
    """Clearance wide enough: a cantilever, M L2/2EI and M L/EI, T L/GJ, and no contact; no force is anywhere."""
    scene = small_screw(oversize=-20e-6, moment=moment, fixed=ALL_HELD)
    result = solved(scene, everything=everything)
    assert not result.load.any()
    at_load, section, (mx, my, mz) = np.argmin(np.abs(result.centreline_z - 0.1)), screw_section(scene), moment
    bend, twist = 0.1 / section.EI, 0.1 / section.GJ
    expected = [0.05 * my * bend, -0.05 * mx * bend, 0.0, mx * bend, my * bend, mz * twist]
    assert result.centreline[at_load] == pytest.approx(expected, rel=1e-8, abs=1e-18)


@pytest.mark.parametrize("everything", [False, True], ids=["short", "everything"])
@pytest.mark.parametrize("screw", ["rigid", "beam"])
@pytest.mark.parametrize("moved", [("uz", 15e-6), ("rz", 1e-5), ("rx", 1e-7)], ids=lambda f: f[0])
@pytest.mark.parametrize("oversize", [0.0, -1e-6])
def test_displacement_that_meets_no_resistance(oversize, moved, screw, everything):
    """A screw free otherwise gives way along its helix or in its clearance: no load, and that is a solution."""
    free = {"uz": ("uy",), "rz": ("uy", "rx"), "rx": ("ux", "uy", "uz")}[moved[0]]
    held = (*((name, 0.0) for name in free), moved)
    scene = small_screw(8, beta=0.62, oversize=oversize, fixed=held, screw=screw)
    result = solved(scene, everything=everything)
    if oversize < 0.0:
        assert result.load.max() < 1e-6


@pytest.mark.parametrize("count", [6, 35])
def test_balance_of_forces_where_there_are_only_moments(count):
    """The residual of the forces is measured against what there is, not against round-off."""
    moment = (0.03, -0.0115398, 0.25257126)
    scene = small_screw(count, lead=0.0, beta=0.63, moment=moment, fixed=ALL_HELD, load_at=0.03, screw="rigid")
    scene = replace(scene, supports=(Support(0.013, ALL_HELD),))
    balance = solved(scene).equilibrium
    assert balance.reaction_moment == pytest.approx([-m for m in moment], rel=1e-12)
    assert balance.force_residual < 1e-10
    assert balance.moment_residual < 1e-10


def test_centreline_of_case_1_is_the_shaft_in_tension():
    """Between the support and the first ball the axial strain is the reaction over EA: the load is at the free end."""
    scene = catalogue.scene("lin-case1")
    result = solved(scene)
    assert result.equilibrium.reaction_force[2] == pytest.approx(0.0, abs=1e-6)
    assert result.equilibrium.contact_force[2] == pytest.approx(-5000.0, rel=1e-9)
    z, uz = result.centreline_z, result.centreline[:, 2]
    before = z < 0.36
    slope = np.diff(uz[before]) / np.diff(z[before])
    assert slope == pytest.approx(np.full(slope.size, -5000.0 / screw_section(scene).EA), rel=1e-6)
