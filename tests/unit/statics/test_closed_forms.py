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

from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.contacts import hertz_with_errors
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.parts import Load, Support
from rollbench.meshes.section import screw_section


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


ALL_AROUND = [(1, 1.0, 20e-3, "rigid"), (2, 1.0, 0.0, "beam"), (2, 1.0, 0.0, "rigid"), (5, 1.0, 20e-3, "rigid")]
ALL_AROUND += [(*balls, lead, "rigid") for balls in ((3, 1.0), (7, 1.0), (32, 2.0)) for lead in (0.0, 10e-3, 30e-3)]


@pytest.mark.parametrize(("force", "clearance"), [(3000.0, 0.0), (2e-5, 0.0), (300.0, 1e-6), (300.0, 20e-6), (2e-5, 20e-6)])
@pytest.mark.parametrize("beta", [0.3, np.pi / 4, 1.1])
@pytest.mark.parametrize(("count", "turns", "lead", "screw"), ALL_AROUND)
def test_balls_all_around_share_an_axial_load(count, turns, lead, screw, beta, force, clearance):
    """F/(N sin beta' cos alpha) each, beta' the contact angle under load: tilt held, since a helix of finite length also
    carries moments. Undersized balls: the screw first runs through the gap, then the law holds at a steeper angle."""
    scene = small_screw(count, turns, lead=lead, beta=beta, oversize=-clearance, force=(0.0, 0.0, force), screw=screw)
    result = solved(scene)
    uz, load, angle = axial_state(scene, force, count)
    near = 1e-8 if clearance or force < 1.0 else 1e-9
    assert result.load == pytest.approx(np.tile([load, 0.0, 0.0, load], (count, 1)), rel=near)
    assert load == pytest.approx(force / (count * np.sin(angle) * np.cos(lead_angle(scene.track))), rel=1e-12)
    assert angle > beta
    assert result.contact_angle[:, [0, 3]] == pytest.approx(np.full((count, 2), angle), abs=near)
    if screw == "rigid":
        assert result.centreline[:, 2] == pytest.approx(uz, rel=near)
    slack = slack_of_pair(scene)
    gap = np.sqrt((slack + 2 * clearance) ** 2 - (slack * np.cos(beta)) ** 2)
    play = (gap - slack * np.sin(beta)) / np.cos(lead_angle(scene.track))
    assert uz > play
    if force < 1.0:
        assert uz == pytest.approx(play, abs=3e-9)


def test_two_starts_balance_each_other():
    """Balls opposite each other at every station: equal loads without holding the tilt."""
    scene = small_screw(6, 2.0, force=(0.0, 0.0, 2000.0), screw="rigid", fixed=(("rz", 0.0),))
    scene = replace(scene, track=replace(scene.track, starts=2))
    result = solved(scene)
    uz, load, _ = axial_state(scene, 2000.0, 12)
    assert result.load == pytest.approx(np.tile([load, 0.0, 0.0, load], (12, 1)), rel=1e-9)
    assert result.centreline[0] == pytest.approx([0.0, 0.0, uz, 0.0, 0.0, 0.0], rel=1e-9, abs=1e-15)


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


def four_contacts(scene, v):
    """Loads (screw, nut) and half contact angles of a ball held by four flanks, the screw moved radially by v.

    By symmetry SL = SR and NL = NR: one unknown, the ball's radial shift. No load where the radial gap is open.
    """
    beta, C, error = scene.track.contact_angle, constants(scene), scene.errors.balls.oversize
    slacks = np.array([scene.screw.groove_radius, scene.nut.groove_radius]) - scene.balls.radius
    # the shift that brings the ball to touch both flanks of one body, of both bodies
    play = np.sum(np.sqrt((slacks - error) ** 2 - (slacks * np.sin(beta)) ** 2) - slacks * np.cos(beta))
    if error < 0.0 and v <= play:
        return (0.0, 0.0), (0.0, 0.0)

    def contact(p, body):
        """Load and angle of the screw's (0) or nut's (1) flanks with the ball's centre at p outwards of it."""
        slack = slacks[body]
        x, z = slack * np.cos(beta) + (-p if body == 0 else p), slack * np.sin(beta)
        # centre of the groove opposite to the contact: moving towards the contact lengthens the distance
        change = (x - slack * np.cos(beta)) * (x + slack * np.cos(beta)) / (np.hypot(x, z) + slack)
        return (max(error + change, 0.0) / C[3 * body]) ** 1.5, np.arctan2(z, x)

    def balance(p):
        (fs, a), (fn, b) = contact(p - v, 0), contact(p, 1)
        return fn * np.cos(b) - fs * np.cos(a)

    reach = abs(v) + abs(error) + 1e-9
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
        return [four_contacts(scene, ux * np.cos(a)) for a in azimuth]

    def balance(ux):
        return sum(2 * n * np.cos(b) * np.cos(a) for a, (_, (n, b)) in zip(azimuth, loads(ux), strict=True)) - force

    ux = brentq(balance, 0.0, 1e-4, xtol=1e-20, rtol=1e-14)
    expected = np.array([[s, s, n, n] for (s, _), (n, _) in loads(ux)])
    assert result.load == pytest.approx(expected, rel=1e-7, abs=1e-7 * expected.max())
    assert result.centreline[0] == pytest.approx([ux, 0.0, 0.0, 0.0, 0.0, 0.0], rel=1e-9, abs=1e-15)
    assert (expected[:, 0] > 0.0).all() == (oversize > 0.0 and force < 100.0)


ONE_BALL = replace(small_screw(lead=0.0).balls, azimuths=(0.0,))
RING = small_screw(9, lead=0.0, fixed=(), force=(300.0, 0.0, 500.0))
#: At the nut's centre: seen from the screw's end the tilt would look like ux and uy.
ACROSS = Support(0.1, (("ux", 0.0), ("uy", 0.0), ("rz", 0.0)))
TILTED = replace(small_screw(lead=0.0, force=(0.0, 0.0, 300.0)), balls=ONE_BALL, supports=(ACROSS,))
ALONE = replace(small_screw(fixed=(), force=(0.0, 100.0, 0.0)), balls=ONE_BALL)
TWISTED = replace(RING, loads=(*RING.loads, Load(0.1, moment=(0.0, 0.0, 1.0))))
NOT_HELD = {
    "axial force on a screw": (small_screw(fixed=(), force=(0.0, 0.0, 100.0)), "screw motion along the helix"),
    "torque on a screw": (small_screw(fixed=(), moment=(0.0, 0.0, 1.0)), "screw motion along the helix"),
    "torque on a bearing": (TWISTED, "rotation about the screw's axis"),
    "one ball": (ALONE, "rigid motion in uy, uz, rx, ry, rz at the nut's centre"),
    "one ball that tilts": (TILTED, "rigid motion in uz, rx, ry at the nut's centre"),
}


@pytest.mark.parametrize(("scene", "motion"), NOT_HELD.values(), ids=NOT_HELD)
def test_what_nothing_holds_is_named(scene, motion):
    result = solve_static(scene)
    assert result.status.startswith(f"not held: {motion}")
    assert not result.converged
    assert np.isnan(result.load).all()


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
    scene = small_screw(12, 2.0, fixed=())
    options = ModelOptions(include_ineffective_terms=True, estimate_beam_mesh_error=False)
    torque = -1000.0 * scene.track.lead / (2 * np.pi)
    scene = replace(scene, loads=(Load(0.05, (0.0, 0.0, 1000.0), (0.0, 0.0, torque)),))
    free, held = (run_model(replace(scene, supports=x), model, options) for x in ((), (Support(0.0, (("uz", 0.0),)),)))
    told = re.search(r"by fixing rz .* if uz is fixed .* change by up to ([\d.e+]+) N", free.solver.notes[0])
    assert float(told[1]) == pytest.approx(np.abs(held.load - free.load).max(), rel=0.05)


def test_load_away_from_the_only_ball_leaves_the_range_of_the_model():
    """A one-sided mechanism. The model's arcs are full circles, so the ball is caught at their far side: it warns."""
    held = tuple((name, 0.0) for name in ("uy", "uz", "rx", "ry", "rz"))
    away = replace(small_screw(lead=0.0, force=(-50.0, 0.0, 0.0)), balls=ONE_BALL, supports=(Support(0.1, held),))
    result = solve_static(away)
    assert not result.converged or any("beyond the groove's arc" in note for note in result.warnings)
    onto = solved(replace(away, loads=(Load(0.1, (50.0, 0.0, 0.0)),)))
    assert onto.load[0, [0, 2]] == pytest.approx(onto.load[0, [1, 3]], rel=1e-9)
    assert not onto.warnings


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
