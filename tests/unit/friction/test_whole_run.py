"""A screw or bearing over time: energy, order of the balls, symmetries, limits, states that older solvers describe."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from tests import whole_screws
from tests.friction_runs import MU, TURN, WAVES, balls_keep_their_order, crowded, setting, sparse
from tests.helpers import small_screw, solved

from rollbench.lowfi.compliance.parts import LADDER, REFINED
from rollbench.lowfi.friction.screw.travel import simulate
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.statics.nominal import contact_loads
from rollbench.lowfi.statics.static import solve_elastic, solve_static
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_per_radian
from rollbench.meshes.parts import BallErrors, Circulation, Errors, FourierTerm, Friction, Load, Motion, SideErrors

pytestmark = pytest.mark.xdist_group("run in time")

SCENES = {
    "balls that meet": lambda: crowded(),
    "bearing": lambda: sparse(),
    "two starts, uneven flanks": lambda: two_starts(),
}


def two_starts():
    return replace(whole_screws.two_starts(), circulation=Circulation(circuits=2, returning=1))


@cache
def run(name, friction=MU, motion=TURN):
    span, steps = (0.03, 3) if name.startswith("two starts") else (0.1, 10)
    return simulate(setting(SCENES[name](), friction, motion), span, steps)


@pytest.mark.parametrize("friction", [MU, Friction(0.1, 0.1, feedback=True)], ids=["loads given", "balls moved"])
@pytest.mark.parametrize(("name", "motion"), [*((name, TURN) for name in SCENES), ("balls that meet", Motion(-3.0, "nut"))])
def test_energy_load_and_order_at_every_instant(name, motion, friction):
    """Moments of all contact forces about the axis, normal ones included, against external load and losses."""
    h, scene = run(name, friction, motion), SCENES[name]()
    assert h.fully_converged
    assert np.all(h.torque > 0.0)
    assert friction.feedback or np.abs(h.imbalance).max() < 1e-8
    assert h.axial == pytest.approx(np.full(h.time.size, scene.loads[0].force[2]), rel=1e-4 if friction.feedback else 1e-9)
    turning, along = h.turning_and_axial_speed
    assert turning == pytest.approx(10.0 if motion is TURN else 3.0, rel=1e-12)
    if scene.track.lead != 0.0:
        assert along / turning == pytest.approx(lead_per_radian(scene.track), rel=1e-12)
        assert np.abs(h.axial * along).min() > 4.0 * np.abs(h.torque * turning).max()
    losses = h.torque * abs(turning)
    np.testing.assert_allclose(h.on_screw * turning, losses - h.axial * along, atol=1e-8 * losses.min(), rtol=0.0)
    balls_keep_their_order(h, 1e-10)
    if motion is TURN and not friction.feedback:
        assert (h.ball_force > 0.0).any() == (name == "balls that meet")


def test_a_tiny_run_is_the_state_at_the_instant_and_reversed_loses_the_same():
    scene = replace(sparse(), motion=TURN)
    found = friction_state(scene, solved(scene), MU, TURN)
    there, back = (simulate(setting(scene, motion=Motion(speed)), 1e-7, 2) for speed in (10.0, -10.0))
    assert there.torque[0] == pytest.approx(found.friction_sums.friction_torque, rel=1e-6)
    assert there.omega[0] == pytest.approx(found.ball_friction.orbital_speed, rel=1e-6)
    assert back.omega[0] == pytest.approx(-there.omega[0], rel=1e-6)
    assert back.torque == pytest.approx(there.torque, rel=1e-6)


def test_turning_nut_is_a_turning_screw_seen_from_it():
    """Without side loads: they stand in space, so that in the nut's frame they would turn."""
    scene = replace(sparse(), loads=(Load(0.1, (0.0, 0.0, 400.0)),))
    screw, nut = (simulate(setting(scene, motion=motion), 0.1, 8) for motion in (TURN, Motion(-10.0, "nut")))
    assert nut.torque == pytest.approx(screw.torque, rel=1e-9)
    assert nut.omega == pytest.approx(screw.omega, rel=1e-9)


def test_torque_repeats_after_a_pitch_of_the_balls():
    """Nine balls on a nut's groove of nine waves: all see the same, and each takes its neighbour's place."""
    scene = small_screw(9, 1.0, lead=0.0, oversize=12e-6, force=(0.0, 0.0, 400.0), screw="rigid")
    waves = SideErrors(roundness=(FourierTerm(9.0, 2e-6, 2e-6),))
    scene = replace(scene, errors=replace(scene.errors, NL=waves))
    pitch = 2.0 * np.pi / 9.0
    h = simulate(setting(scene), 0.4, 96)
    place, again = h.azimuth[:, 0], h.azimuth[:, 0] + pitch
    later = again < place[-1]
    torque = CubicSpline(place, h.torque)
    assert later.sum() > 20
    assert np.ptp(h.torque) > 0.01 * h.torque.mean()
    assert torque(again[later]) == pytest.approx(h.torque[later], abs=1e-3 * np.ptp(h.torque))


def test_sizes_belong_to_balls_and_errors_to_places():
    """One large ball carries its load round; a wave of the nut's groove stays where it is."""
    base = small_screw(9, 8.0 / 9.0, lead=0.0, oversize=3e-6, force=(0.0, 0.0, 50.0), screw="rigid")
    large = replace(base, errors=Errors(balls=BallErrors(oversize=3e-6, listed=((4, 2e-6),))))
    assert np.all(simulate(setting(large), 1.0, 8).load.sum(axis=2).argmax(axis=1) == 3)
    one = replace(WAVES, balls=base.errors.balls, SL=Errors().SL)
    h = simulate(setting(replace(base, errors=one)), 1.2, 8)
    load = h.load.sum(axis=2)
    for azimuth, of_balls in zip(h.azimuth, load, strict=True):
        wave = np.cos(azimuth) * 2e-6 + np.sin(azimuth) * 1e-6
        assert abs(np.corrcoef(wave, of_balls)[0, 1]) > 0.5
    assert len(set(load.argmax(axis=1))) > 1


def test_balls_of_unlike_sizes_touch_where_their_radii_meet():
    balls = setting(crowded())
    grooves, between = balls.groove, slice(balls.tracks[0].balls.start, balls.tracks[0].balls.stop - 1)
    phi = balls.spacing[between]
    chord = np.hypot(2.0 * grooves.pitch_radius * np.sin(0.5 * phi), grooves.advance_per_radian * phi)
    radius = balls.radius[balls.tracks[0].balls]
    assert chord == pytest.approx(radius[:-1] + radius[1:], abs=2e-9)
    assert np.ptp(balls.spacing) * grooves.pair.closing_speed_factor > 1e-6


def test_loads_again_are_those_of_a_single_solution():
    scene = small_screw(6, 0.8, force=(20.0, 0.0, 400.0), oversize=2e-6)
    layout = ball_layout(scene)
    for backend, once in ((LADDER["lin"], solve_static), (REFINED, solve_elastic)):
        found, expected = contact_loads(scene, draw_geometry_with_errors(scene, layout), layout, backend), once(scene)
        assert found.load == pytest.approx(expected.load, rel=1e-9, abs=1e-6)
        assert np.allclose(found.contact_angle, expected.contact_angle, rtol=1e-9, equal_nan=True)


def test_a_run_ends_where_loads_are_not_found():
    scene = replace(small_screw(6, 0.6, force=(0.0, 0.0, 100.0), screw="rigid"), supports=())
    h = simulate(setting(scene), 0.01, 4)
    assert not h.fully_converged
    assert "contact loads" in h.status
