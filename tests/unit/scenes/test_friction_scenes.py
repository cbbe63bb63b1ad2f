"""Friction scenes: shipped ones give the library's numbers, limits, what nothing moves or presses, exit code."""

from dataclasses import replace

import numpy as np
import pytest
from tests.shipped_texts import axis_names, changed

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.cases.lin.kinds.friction import SOLVERS
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain
from rollbench.lowfi.friction.screw.chain import solve_motion_of_chain
from rollbench.lowfi.friction.screw.run import SHIFTED

LINEAR = LinearBearing(5e-3, 0.56, 0.25 * np.pi, 0.01, 0.1, 0.1, 2.1e11, 0.28)
WAYS = "friction_torque_Nmm", "driving_torque_on_screw_Nmm"
#: Few steps of the run, up to the first contacts.
SHORT = (("steps = 200", "steps = 40"), ('duration = "2 s"', 'duration = "300 ms"'))
FEW = (
    (', "4 deg", "6 deg", "8 deg", "10 deg", "12 deg", "14 deg",\n', ",\n"),
    ('"18 deg", "20 deg", "22 deg", "24 deg", "26 deg", "28 deg", "30 deg"', '"18 deg"'),
)


def loaded(name, *changes):
    return scene_file.parse_scene(changed(name, *changes), f"{name}.toml")


def solved(name, *changes):
    """Answer to a shipped scene with some changes."""
    scene = loaded(name, *changes)
    return SOLVERS[scene.kind](scene)


def test_every_shipped_scene_converges_and_balances_power():
    for name in sorted(set(catalogue.scene_names()) - set(catalogue.names_of_single_nut_scenes()) - set(axis_names())):
        answer = solved(name)
        assert answer.converged, name
        assert abs(answer.as_json()["energy"]["balance_percent"]) < (0.2 if name.endswith("printed") else 1e-8), name


def test_chain_scene_is_the_library_s_and_a_gap_cuts_it():
    scene = catalogue.scene_of_any_kind("lin-chain-10")
    np.testing.assert_allclose(np.degrees(scene.angles), [[43.0, 47.0, 45.0, 45.0]] * 10, rtol=1e-12)
    found = SOLVERS[scene.kind](scene).as_json()
    loads = np.array([[b["load_N"][c] for c in ("BL", "BR", "TR", "TL")] for b in found["balls"]])
    one = solve_motion_of_chain(prepare_linear_chain(LINEAR, scene.angles, loads))
    assert [p["force_N"] for p in found["pairs"]] == pytest.approx(one.ball_force[:-1], rel=1e-8)
    assert np.all(one.ball_force[:-1] > 0.0)
    cut = solved("lin-chain-10", ("side_force_ratio = -0.6\n", 'side_force_ratio = -0.6\ngap = "0.5 mm"\n')).as_json()
    assert cut["pairs"][0] == {"balls": "1-2", "gap_um": pytest.approx(500.0), "force_N": 0.0, "loss_mW": 0.0}
    assert cut["pairs"][1]["force_N"] > 0.0


def test_units_signs_and_either_way_to_give_the_groove():
    base = catalogue.scene_of_any_kind("lin-rotary-2")
    units = (('"10 rps"', '"600 rpm"'), ('"5.2 um"', '"0.0052 mm"'), ('"100 N"', '"0.1 kN"'))
    again = loaded("lin-rotary-2", ("conformity = 0.54", 'groove_radius = "6.75 mm"'), *units)
    one, other = ((x.bearing.screw_speed, x.bearing.groove_radius, x.force, x.displacement) for x in (base, again))
    assert other == pytest.approx(one, rel=1e-15)
    forward, back = (solved("lin-rotary-2", x).as_json()["torque"] for x in (units[0], ('"10 rps"', '"-10 rps"')))
    assert [back[k] for k in WAYS] == pytest.approx([forward[WAYS[0]], -forward[WAYS[1]]], rel=1e-9)
    backwards = solved("lin-pair-a", ('"10 mm/s"', '"-0.01 m/s"'), ("-0.6", "0.6")).as_json()
    assert backwards["pairs"][0]["force_N"] == pytest.approx(4.065, abs=5e-4)


def test_oversize_is_the_opposite_of_a_clearance_and_adds_load_and_large_contacts_are_warned_of():
    plain = solved("lin-rotary-3").as_json()
    assert not plain["warnings"]
    assert "Hertz" in solved("lin-rotary-3", ('"100 N"', '"100 kN"')).as_json()["warnings"][0]
    tight = loaded("lin-rotary-3", ("[load]", '[errors.balls]\noversize = "1 um"\n\n[load]'))
    assert tight.bearing.clearance == -1e-6
    assert SOLVERS[tight.kind](tight).as_json()["load_sum_N"] > 1.05 * plain["load_sum_N"]


def test_no_contact_and_nothing_moving_are_said():
    answer = solved("lin-rotary-1", ('axial_force = "100 N"', 'axial_force = "0 N"'))
    assert (answer.converged, answer.as_json()["status"]) == (False, "no contact: nothing presses the ball")
    for name, old, new in (("lin-rotary-2", '"10 rps"', '"0 rps"'), ("lin-pair-a", '"10 mm/s"', '"0 mm/s"')):
        still = solved(name, (old, new))
        energy = still.as_json()["energy"]
        assert (still.converged, energy["loss_W"], energy["balance_percent"]) == (True, 0.0, None)
    rolling = solved("lin-pair-a", ('"balanced"', '"elastic"'), ("-0.6", "-3.0")).as_json()
    assert rolling["friction_increase_percent"] is None, "two contacts on a diagonal roll: no percentage of nothing"


FRICTIONLESS = ["lin-rotary-2", "lin-rotary-2-printed", "lin-pair-a", "lin-chain-10", "lin-screw-pair-a-inferred"]


@pytest.mark.parametrize("name", FRICTIONLESS)
def test_without_friction_nothing_is_lost_and_motion_is_that_of_a_vanishing_coefficient(name):
    rough, smooth = (solved(name, ("coefficient = 0.1", f"coefficient = {mu}")) for mu in ("1e-6", "0"))
    assert smooth.converged
    assert smooth.as_json()["energy"] == {"input_power_W": 0.0, "loss_W": 0.0, "balance_W": 0.0, "balance_percent": None}
    for one, two in zip(rough.as_json()["balls"], smooth.as_json()["balls"], strict=True):
        assert two["rotation_rad_s"] == pytest.approx(one["rotation_rad_s"], rel=1e-5, abs=1e-6)
        assert any(one["rotation_rad_s"])
    assert all(pair["force_N"] == pair["loss_mW"] == 0.0 for pair in smooth.as_json().get("pairs", ()))
    ratios = ("friction_increase_percent", "ball_to_ball_percent")
    assert [smooth.as_json().get(k) for k in ratios] == [None, None], "no ratio of round-off"


def test_an_oversize_loads_a_four_point_bearing_and_rows_face_to_face_are_turned_round():
    rows = loaded("lin-bearing-pairs", ('back to back"\n', 'face to face"\n')).double_row.rows
    assert [r.contacts for r in rows] == [bearing.DIAGONAL, bearing.OTHER]
    preload = loaded("lin-bearing-pairs", ('"0 um"', '"2 um"'))
    assert (preload.four_point.clearance, preload.double_row.clearance) == (-2e-6, 0.0)
    cases = preload.four_point, source_cases.four_point_bearing()
    tight, free = (bearing.solve_bearing(case, 0.1).force.sum() for case in cases)
    assert tight > 1.01 * free


def test_pair_takes_pattern_direction_hand_and_hertz():
    loads = (("[1, 1, 0, 0]", "[1, -1, 0, 0.0]"), ('"axial"', '"radial"'), ('"50 N"', '"0.1 kN"'), ('"1 rps"', '"60 rpm"'))
    rest = (('hand = "right"', 'hand = "left"'), ('"ball"', '"ball and screw"'), ('"0 um"', '"-1 um"'))
    hertz = "[load]", '[ingredients]\nhertz = "as printed"\n\n[load]'
    pair = loaded("lin-screw-pair-a", *loads, hertz, *rest).pair
    words = pair.pattern, pair.free, pair.coupling, pair.groove.hertz
    assert words == ((SHIFTED, SHIFTED), "r", "ball and screw", "as printed")
    numbers = (*pair.theta, pair.oversize, *pair.force, pair.groove.lead, pair.groove.nut_speed)
    assert numbers == pytest.approx((0.0, np.radians(2.0), -1e-6, 100.0, -20e-3, 2.0 * np.pi), rel=1e-14)


def test_a_run_takes_the_keys_of_a_whole_screw_in_time():
    """An angle in place of a duration, and steps chosen by a goal; four steps have not converged."""
    chosen = ('duration = "2 s"\nsteps = 200', 'angle = "60 deg"\ngoal = 0.02')
    assert loaded("lin-screw-run", chosen).run.duration == pytest.approx(1.0 / 6.0)
    found = solved("lin-screw-run", chosen)
    error = found.as_json()["run"]["step_error"]
    assert (found.converged, error["small"], error["goal_percent"]) == (True, True, 2.0)
    assert found.as_json()["steps"] == error["steps"][-1]
    found = solved("lin-screw-run", ("steps = 200", "steps = 4"))
    assert not found.converged
    assert found.as_json()["status"].startswith("not converged in the time step: the error of 4 steps is some ")


def test_run_without_contact_says_nothing_of_where_and_without_friction_there_are_no_ratios():
    found = solved("lin-screw-run", *SHORT, ('"3 deg"', '"0 deg"')).as_json()["summary"]
    assert found["largest_ball_to_groove_percent"] == 0.0
    assert [found[k] for k in ("largest_at_deg", "contact_begins_deg", "contact_ends_deg")] == [None] * 3
    run = solved("lin-screw-run", *SHORT, ("coefficient = 0.1", "coefficient = 0"))
    energy, summary = run.as_json()["energy"], run.as_json()["summary"]
    assert (run.converged, energy["loss_W"], energy["largest_step_balance_percent"]) == (True, 0.0, None)
    assert [summary[k] for k in ("largest_ball_to_groove_percent", "groove_variation_percent")] == [None] * 2
    bearings = solved("lin-bearing-pairs", *FEW, ("coefficient = 0.1", "coefficient = 0"))
    assert (bearings.converged, bearings.as_json()["four_over_double"]) == (True, [None] * 4)
    assert bearings.as_json()["four_point"]["largest_over_smallest"] is None


@pytest.mark.parametrize("angle", [0.3, 0.9])
def test_one_ball_holds_a_tilting_ring_only_against_a_force_through_its_centre(angle):
    ball = source_cases.four_point_bearing(count=1)
    assert "ry" in bearing.describe_unresisted_motion(ball, angle)
    assert bearing.describe_unresisted_motion(replace(ball, tilt=False), angle) == ""
    through = -ball.groove.pitch_radius / np.tan(angle)
    assert bearing.describe_unresisted_motion(replace(ball, arm=through), angle) == ""
    assert "ry" in bearing.describe_unresisted_motion(replace(ball, arm=1.001 * through), angle)
    for all_balls in (source_cases.four_point_bearing(), source_cases.double_row_bearing()):
        assert bearing.describe_unresisted_motion(all_balls, angle) == ""


def test_a_bearing_that_one_ball_cannot_hold_ends_with_1(command, tmp_path):
    (tmp_path / "one.toml").write_text(changed("lin-bearing-pairs", *FEW, ("count = 9", "count = 1")), encoding="utf-8")
    code, data = command.json("friction", tmp_path / "one.toml", "--json")
    assert code == 1
    assert data["status"].startswith("no equilibrium: four-point bearing, load at 0 deg: rigid motion of the inner ring")
