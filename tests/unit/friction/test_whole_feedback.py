"""Feedback of friction on the loads of whole screws: virtual work, one ball coupled, symmetries, second states."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from tests.friction_oracles import ball_cell, coupled_ball
from tests.friction_runs import setting
from tests.helpers import small_screw, solved
from tests.whole_screws import MU, SCENES, TURN, scene_of, single, state

from rollbench.compare.cases.lin.evidence.source_cases import screw_groove
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies import survey
from rollbench.lowfi.friction.whole.feedback import DisplacedBalls, positions_in_grooves, solve_friction_equilibria
from rollbench.lowfi.friction.whole.losses import BallsUnderLoad
from rollbench.lowfi.friction.whole.state import FrictionCase, friction_state, friction_states
from rollbench.lowfi.friction.whole.torque import sum_friction_over_contacts
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.parts import Friction, Motion


def groove_with(mu):
    return replace(screw_groove(), mu=mu, nut_speed=0.0, screw_speed=5.0)


def without_friction(groove, oversize, load):
    """Contacts of one ball at its loads without friction."""
    bare = coupled_ball(ball_cell(replace(groove, mu=0.0), np.zeros(4), oversize, "z", np.array([load])), "none")
    return single(bare.loads_with_friction.force[0], bare.loads_with_friction.angle[0], groove)


def fed(groove, load, oversize, mu, drive):
    """Feedback on one ball, begun at its loads without friction."""
    at, scene, distance = without_friction(groove, oversize, load), scene_of(groove), groove.groove_ball_centre_distance
    turned = replace(at, angle=np.full((1, 4), groove.contact_angle))
    centre, reach = -distance * turned.normals[..., [0, 2]], np.full((1, 4), distance - oversize)
    place = positions_in_grooves(at, groove.contact_hertz_constants.C[None, :], reach, centre)
    still = BallsUnderLoad(scene, at, Friction(mu, mu), drive)
    return scene, solve_friction_equilibria([DisplacedBalls(still, place)])[0]


@pytest.mark.parametrize("mu", [0.02, 0.1, 0.2])
@pytest.mark.parametrize(("oversize", "load"), [(6e-6, 50.0), (2e-6, 50.0), (0.0, 200.0), (-3e-6, 200.0)])
def test_feedback_on_a_ball_is_that_of_the_coupled_solver(mu, oversize, load):
    """Four flanks, two of them, and a third one that friction makes the ball touch."""
    groove = groove_with(mu)
    expected = coupled_ball(ball_cell(groove, np.zeros(4), oversize, "z", np.array([load])), "ball and screw")
    assert expected.converged
    scene, found = fed(groove, load, oversize, mu, Motion(5.0))
    assert not found.failed_balls.any()
    assert found.largest_imbalance_ratio <= 1e-5
    assert np.allclose(found.contacts.force[0], expected.loads_with_friction.force[0], rtol=0.0, atol=2e-4 * load)
    assert found.friction.total_power_lost == pytest.approx(expected.motion.loss, rel=2e-4)
    t = sum_friction_over_contacts(scene, found.contacts, found.friction, Motion(5.0), coupled=True)
    assert t.axial_load == pytest.approx(load, rel=1e-5)
    assert t.input_power == pytest.approx(t.power, rel=1e-8)


COUPLED = Friction(0.1, 0.1, (), True)


def test_cases_together_are_as_each_alone():
    """Screws and a ring, with and without feedback, coefficients, directions and a case without load, in one call."""
    free = small_screw(force=(0.0, 0.0, 0.0))
    asked = [
        (SCENES["two-point"](), COUPLED, TURN),
        (SCENES["two-point"](), Friction(0.02, 0.05), Motion(-10.0)),
        (SCENES["ring"](), COUPLED, TURN),
        (SCENES["ring"](), COUPLED, Motion(-3.0)),
        (SCENES["two starts"](), Friction(0.3, 0.3), TURN),
        (free, COUPLED, TURN),
        (SCENES["four-point"](), MU, Motion(5.0, "nut")),
    ]
    cases = [FrictionCase(scene, solved(scene), friction, motion) for scene, friction, motion in asked]
    for case, found in zip(cases, friction_states(cases), strict=True):
        alone = friction_state(*case)
        sums, sums_alone = (np.hstack(astuple(x.friction_sums)) for x in (found, alone))
        assert sums == pytest.approx(sums_alone, rel=1e-10, abs=1e-10)
        assert found.contacts.force == pytest.approx(alone.contacts.force, rel=1e-10)
        assert found.ball_friction.loss == pytest.approx(alone.ball_friction.loss, rel=1e-8, abs=1e-15)
        assert found.ball_friction.status == alone.ball_friction.status
        assert (found.unsettled_balls, found.jammed_balls) == (alone.unsettled_balls, alone.jammed_balls)


@pytest.mark.parametrize("name", [n for n in SCENES if n != "ring"])
def test_feedback_keeps_loads_balances_and_matters_most_in_two_point_contact(name):
    scene = SCENES[name]()
    found = state(scene, COUPLED)
    t, bare = found.friction_sums, found.sums_without_feedback.friction_torque
    assert found.friction_changes_loads
    assert not found.unsettled_balls
    assert t.axial_load == pytest.approx(scene.loads[0].force[2], rel=1e-5)
    assert t.input_power == pytest.approx(t.power, rel=1e-8)
    assert bare == pytest.approx(state(scene).friction_sums.friction_torque, rel=1e-9)
    least, most = (0.95, 1.2) if name in ("four-point", "left hand", "two starts") else (1.3, np.inf)
    assert least < t.friction_torque / bare < most
    assert t.forward_torque != t.backward_torque


def test_feedback_keeps_the_load_of_contacts_past_the_apex():
    """A screw of hardly any contact angle under an axial load: balls climb one side of the groove."""
    found = state(small_screw(5, 0.9, beta=np.radians(0.001), force=(0.0, 0.0, 300.0)), COUPLED)
    assert np.any((found.contacts.angle < -0.05) & (found.contacts.force > 0.0))
    assert not found.unsettled_balls
    assert found.friction_sums.axial_load == pytest.approx(300.0, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [211.5, 216.0])
def test_feedback_settles_where_a_flank_hardly_bears(degrees):
    """The pitch error leaves a flank of one ball with less than a hundredth of its load: its friction turns far at once."""
    scene = catalogue.scene("lin-pitch-4p1")
    s, time = setting(scene, COUPLED, TURN), np.radians(degrees) / TURN.speed
    place = s.state_at_start()
    still = np.full(place.gap.size, np.inf)
    first = solve_alone(s.solve_at_instant(place.azimuth, 0.0, still, place.memory))
    azimuth, slack = place.azimuth + time * first.omega, place.gap / (2.0 * time)
    found = solve_alone(s.solve_at_instant(azimuth, time, slack, first.memory))
    assert found.converged
    assert found.axial == pytest.approx(scene.loads[0].force[2], rel=1e-6)
    light = np.sort(found.load, axis=1)[:, 0] / found.load.sum(axis=1)
    assert np.any((light > 0.0) & (light < 0.01))


@pytest.mark.slow
def test_feedback_settles_where_the_iteration_oscillates():
    """A drawn screw of two-point contacts with much friction: at some twenty balls the iteration does not end by itself."""
    scene = scene_file.parse_scene(survey.random_screw_scene_text(1719, 62), "drawn.toml")
    found = state(scene, Friction(0.2, 0.2, (), True))
    assert not found.unsettled_balls
    assert found.change < 1e-6
