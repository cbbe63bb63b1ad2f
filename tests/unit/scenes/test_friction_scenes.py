"""Friction scenes: shipped ones give the library's numbers, limits, tables, JSON and exit code."""

import numpy as np
import pytest
from tests.shipped_texts import axis_names, changed

from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.friction.answer import neglected_effects_of_kind
from rollbench.compare.studies.friction.kinds import solve_friction_of_single_parts
from rollbench.lowfi.friction.bearing import SIDES, Bearing, solve_ball_by_lin_method, solve_ball_of_bearing
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain, solve_linear_chain, solve_pair_of_linear_balls
from rollbench.lowfi.friction.screw.motion import lin_sigmoid_law

ROTARY = Bearing(6.25e-3, 6.75e-3, 35e-3, 0.0, 0.25 * np.pi, 2.1e11, 0.28, 0.1, 0.0, 20.0 * np.pi)
LINEAR = LinearBearing(5e-3, 0.56, 0.25 * np.pi, 0.01, 0.1, 0.1, 2.1e11, 0.28)
WAYS = "friction_torque_Nmm", "driving_torque_on_screw_Nmm"
U_Y = {"1": 0.0, "2": 5.2e-6, "3": 8.0e-6}


def solved(name, *changes):
    return solve_friction_of_single_parts(scene_file.parse_scene(changed(name, *changes), "my.toml"))


def test_every_shipped_scene_converges_and_balances_power():
    names = sorted(set(catalogue.scene_names()) - set(catalogue.names_of_single_nut_scenes()) - set(axis_names()))
    for name in names:
        scene = catalogue.scene_of_any_kind(name)
        answer = solve_friction_of_single_parts(scene)
        assert answer.converged, name
        assert len(scene.assumed) >= (5 if "screw" in name or "bearing" in name else 1), name
        assert answer.data["assumed"] == list(scene.assumed)
        assert answer.data["left_out"] == neglected_effects_of_kind(scene.kind, answer.data.get("coupling"))
        assert abs(answer.data["energy"]["balance_percent"]) < (0.2 if name.endswith("printed") else 1e-8), name


@pytest.mark.parametrize("case", list(U_Y))
@pytest.mark.parametrize("printed", [False, True])
def test_rotary_scenes_are_the_library_s(case, printed):
    found = solve_friction_of_single_parts(catalogue.scene_of_any_kind(f"lin-rotary-{case}{'-printed' * printed}")).data
    case = ROTARY, 100.0, U_Y[case]
    one = solve_ball_by_lin_method(*case, lin_sigmoid_law(ROTARY, 100.0, 0.08)) if printed else solve_ball_of_bearing(*case)
    assert found["load_sum_N"] == pytest.approx(one.load.force.sum(), rel=1e-9)
    (ball,) = found["balls"]
    assert [ball["orbit_rad_s"], *ball["rotation_rad_s"]] == pytest.approx([*one.motion.unknown_velocities, 0.0], rel=1e-7)
    name = "friction_torque_Nmm" if printed else "driving_torque_on_screw_Nmm"
    assert found["torque"][name] == pytest.approx(1e3 * one.inner_ring_torque, rel=1e-8)
    assert [ball["load_N"][s] > 0.0 for s in SIDES] == (one.load.force > 0.0).tolist()
    losses = 1e3 * one.motion.friction.loss
    assert list(ball["loss_mW"].values()) == pytest.approx(losses, rel=1e-6, abs=1e-9)


def test_chain_scene_is_the_library_s_and_a_gap_cuts_it():
    scene = catalogue.scene_of_any_kind("lin-chain-10")
    np.testing.assert_allclose(np.degrees(scene.angles), [[43.0, 47.0, 45.0, 45.0]] * 10, rtol=1e-12)
    found = solve_friction_of_single_parts(scene).data
    loads = np.array([[b["load_N"][c] for c in ("BL", "BR", "TR", "TL")] for b in found["balls"]])
    one = solve_linear_chain(prepare_linear_chain(LINEAR, scene.angles, loads))
    assert [p["force_N"] for p in found["pairs"]] == pytest.approx(one.ball_force, rel=1e-8)
    assert np.all(one.ball_force > 0.0)
    cut = solved("lin-chain-10", ("side_force_ratio = -0.6\n", 'side_force_ratio = -0.6\ngap = "0.5 mm"\n')).data
    assert cut["pairs"][0] == {"balls": "1-2", "gap_um": pytest.approx(500.0), "force_N": 0.0, "loss_mW": 0.0}
    assert cut["pairs"][1]["force_N"] > 0.0


def test_units_signs_and_either_way_to_give_the_groove():
    base = catalogue.scene_of_any_kind("lin-rotary-2")
    units = (('"10 rps"', '"600 rpm"'), ('"5.2 um"', '"0.0052 mm"'), ('"100 N"', '"0.1 kN"'))
    text = changed("lin-rotary-2", ("conformity = 0.54", 'groove_radius = "6.75 mm"'), *units)
    again = scene_file.parse_scene(text, "lin-rotary-2.toml")
    one, other = ((x.bearing.screw_speed, x.bearing.groove_radius, x.force, x.displacement) for x in (base, again))
    assert other == pytest.approx(one, rel=1e-15)
    forward, back = (
        solve_friction_of_single_parts(base).data["torque"],
        solved("lin-rotary-2", ('"10 rps"', '"-10 rps"')).data["torque"],
    )
    assert [back[k] for k in WAYS] == pytest.approx([forward[WAYS[0]], -forward[WAYS[1]]], rel=1e-9)
    backwards = solved("lin-pair-a", ('"10 mm/s"', '"-0.01 m/s"'), ("-0.6", "0.6")).data
    assert backwards["pairs"][0]["force_N"] == pytest.approx(4.065, abs=5e-4)


def test_oversize_is_the_opposite_of_a_clearance_and_adds_load_and_large_contacts_are_warned_of():
    base = catalogue.scene_of_any_kind("lin-rotary-3")
    plain = solve_friction_of_single_parts(base).data
    assert not plain["warnings"]
    assert "Hertz" in solved("lin-rotary-3", ('"100 N"', '"100 kN"')).data["warnings"][0]
    text = changed("lin-rotary-3", ("[load]", '[errors.balls]\noversize = "1 um"\n\n[load]'))
    tight = scene_file.parse_scene(text, "lin-rotary-3.toml")
    assert (base.bearing.clearance, tight.bearing.clearance) == (0.0, -1e-6)
    assert solve_friction_of_single_parts(tight).data["load_sum_N"] > 1.05 * plain["load_sum_N"]


def test_laws_approach_coulomb():
    exact = solve_friction_of_single_parts(catalogue.scene_of_any_kind("lin-rotary-2")).data["torque"][
        "friction_torque_Nmm"
    ]
    coulomb = 'law = "coulomb"'
    off = []
    for creep in ("1 mm/s", "0.1 mm/s"):
        answer = solved("lin-rotary-2", (coulomb, f'law = "regularised"\ncreep = "{creep}"'))
        assert answer.converged
        assert abs(answer.data["energy"]["balance_percent"]) < 1e-8
        off.append(abs(answer.data["torque"]["friction_torque_Nmm"] / exact - 1.0))
    assert off[1] < 0.02 * off[0]
    assert off[0] < 1e-3
    soft = solved("lin-rotary-2", (coulomb, 'law = "sigmoid"\nsharpness = 1'))
    assert soft.converged
    assert soft.data["torque"]["friction_torque_Nmm"] < 0.97 * exact


PAIRS = [(True, "balanced"), *((False, x) for x in ("balanced", "elastic", "diagonal"))]


@pytest.mark.parametrize(("mated", "loads"), PAIRS)
def test_pair_scenes_are_the_library_s(mated, loads):
    found = solved("lin-pair-b" if mated else "lin-pair-a", ('"balanced"', f'"{loads}"')).data
    one = solve_pair_of_linear_balls(LINEAR, np.radians(2.0), -0.6, 100.0, mated=mated, loads=loads)
    numbers = found["pairs"][0]["force_N"], found["drive_N"]
    assert numbers == pytest.approx((one.ball_to_ball_force, one.touching.carriage_drive_force), rel=1e-9, abs=1e-9)
    apart = [b["deviation_apart_percent"] for b in found["balls"]]
    assert apart == pytest.approx(100.0 * one.apart.velocity_deviation, rel=1e-8, abs=1e-9)
    if loads == "diagonal":
        assert found["solver"]["load_imbalance"] > 0.01, "the source's approximation does not balance; it is shown"


def test_no_contact_and_nothing_moving_are_said():
    answer = solved("lin-rotary-1", ('axial_force = "100 N"', 'axial_force = "0 N"'))
    assert (answer.converged, answer.data["status"]) == (False, "no contact: nothing presses the ball")
    for name, old, new in (("lin-rotary-2", '"10 rps"', '"0 rps"'), ("lin-pair-a", '"10 mm/s"', '"0 mm/s"')):
        still = solved(name, (old, new))
        energy = still.data["energy"]
        assert (still.converged, energy["loss_W"], energy["balance_percent"]) == (True, 0.0, None)
    rolling = solved("lin-pair-a", ('"balanced"', '"elastic"'), ("-0.6", "-3.0")).data
    assert rolling["friction_increase_percent"] is None, "two contacts on a diagonal roll: no percentage of nothing"


FRICTIONLESS = ["lin-rotary-2", "lin-rotary-2-printed", "lin-pair-a", "lin-chain-10", "lin-screw-pair-a-inferred"]


@pytest.mark.parametrize("name", FRICTIONLESS)
def test_without_friction_nothing_is_lost_and_motion_is_that_of_a_vanishing_coefficient(name):
    rough, smooth = (solved(name, ("coefficient = 0.1", f"coefficient = {mu}")) for mu in ("1e-6", "0"))
    assert smooth.converged
    assert smooth.data["energy"] == {"input_power_W": 0.0, "loss_W": 0.0, "balance_W": 0.0, "balance_percent": None}
    for one, two in zip(rough.data["balls"], smooth.data["balls"], strict=True):
        assert two["rotation_rad_s"] == pytest.approx(one["rotation_rad_s"], rel=1e-5, abs=1e-6)
        assert any(one["rotation_rad_s"])
    assert all(pair["force_N"] == pair["loss_mW"] == 0.0 for pair in smooth.data.get("pairs", ()))
    ratios = ("friction_increase_percent", "ball_to_ball_percent")
    assert [smooth.data.get(k) for k in ratios] == [None, None], "no ratio of round-off"
