"""Friction scenes: shipped ones give the library's numbers, limits, tables, JSON and exit code."""

import json

import numpy as np
import pytest
from tests.shipped_texts import axis_names, changed

from rollbench.comparison.scenes import catalogue, scene_file
from rollbench.comparison.wings.friction.answer import left_out_of_kind
from rollbench.comparison.wings.friction.kind_solvers import solve_kind
from rollbench.comparison.wings.friction.kinds.bearings import BearingBallScene
from rollbench.comparison.wings.friction.kinds.linear import LinearScene
from rollbench.comparison.wings.friction.kinds.table import KINDS
from rollbench.comparison.wings.friction.solve import run_friction
from rollbench.comparison.wings.friction.whole import Choices
from rollbench.lowfi.friction.bearing.rotary import SIDES, Bearing, solve_ball, solve_ball_as_printed, source_law
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare, solve_linear_chain
from rollbench.lowfi.friction.linear.pair import solve_pair

ROTARY = Bearing(6.25e-3, 6.75e-3, 35e-3, 0.25 * np.pi, 2.1e11, 0.28, 0.1, 20.0 * np.pi)
LINEAR = LinearBearing(5e-3, 0.56, 0.25 * np.pi, 0.01, 0.1, 0.1, 2.1e11, 0.28)
WAYS = "friction_torque_Nmm", "driving_torque_on_screw_Nmm"
U_Y = {"1": 0.0, "2": 5.2e-6, "3": 8.0e-6}


def solved(name, *changes):
    return solve_kind(scene_file.read(changed(name, *changes), "my.toml"))


def test_every_shipped_scene_converges_and_balances_power():
    names = sorted(set(catalogue.scene_names()) - set(catalogue.whole_names()) - set(axis_names()))
    assert names == [
        "lin-bearing-pairs",
        "lin-chain-10",
        "lin-pair-a",
        "lin-pair-b",
        "lin-pair-worst",
        "lin-rotary-1",
        "lin-rotary-1-printed",
        "lin-rotary-2",
        "lin-rotary-2-printed",
        "lin-rotary-3",
        "lin-rotary-3-printed",
        "lin-screw-pair-a",
        "lin-screw-pair-a-inferred",
        "lin-screw-pair-b",
        "lin-screw-pair-b-inferred",
        "lin-screw-run",
        "lin-screw-run-2deg",
    ]
    for name in names:
        scene = catalogue.any_scene(name)
        answer = solve_kind(scene)
        assert answer.converged, name
        assert scene.assumed, name
        assert answer.data["assumed"] == list(scene.assumed)
        assert answer.data["left_out"] == left_out_of_kind(scene.kind, answer.data.get("coupling"))
        assert abs(answer.data["energy"]["balance_percent"]) < (0.2 if name.endswith("printed") else 1e-8), name


@pytest.mark.parametrize("case", list(U_Y))
@pytest.mark.parametrize("printed", [False, True])
def test_rotary_scenes_are_the_library_s(case, printed):
    found = solve_kind(catalogue.any_scene(f"lin-rotary-{case}{'-printed' * printed}")).data
    case = ROTARY, 100.0, U_Y[case]
    one = solve_ball_as_printed(*case, source_law(ROTARY, 100.0, 0.08)) if printed else solve_ball(*case)
    assert found["load_sum_N"] == pytest.approx(one.load.force.sum(), rel=1e-9)
    (ball,) = found["balls"]
    assert [ball["orbit_rad_s"], *ball["rotation_rad_s"]] == pytest.approx([*one.motion.q, 0.0], rel=1e-7)
    name = "friction_torque_Nmm" if printed else "driving_torque_on_screw_Nmm"
    assert found["torque"][name] == pytest.approx(1e3 * one.torque, rel=1e-8)
    loaded = [s for s, f in zip(SIDES, one.load.force, strict=True) if f > 0.0]
    assert [s for s in SIDES if ball["load_N"][s] > 0.0] == loaded
    losses = 1e3 * one.motion.friction.loss
    assert list(ball["loss_mW"].values()) == pytest.approx(losses, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("mated", [False, True])
def test_pair_scenes_are_the_library_s(mated):
    found = solve_kind(catalogue.any_scene("lin-pair-b" if mated else "lin-pair-a")).data
    one = solve_pair(LINEAR, np.radians(2.0), -0.6, 100.0, mated=mated)
    assert found["pairs"][0]["force_N"] == pytest.approx(one.force, rel=1e-9, abs=1e-9)
    apart = [b["deviation_apart_percent"] for b in found["balls"]]
    assert apart == pytest.approx(100.0 * one.free.deviation, rel=1e-8, abs=1e-9)
    assert found["drive_N"] == pytest.approx(one.touching.drive, rel=1e-9)


def test_chain_scene_is_the_library_s_and_a_gap_cuts_it():
    scene = catalogue.any_scene("lin-chain-10")
    assert isinstance(scene, LinearScene)
    np.testing.assert_allclose(np.degrees(scene.angles), [[43.0, 47.0, 45.0, 45.0]] * 10, rtol=1e-12)
    found = solve_kind(scene).data
    loads = np.array([[b["load_N"][c] for c in ("BL", "BR", "TR", "TL")] for b in found["balls"]])
    one = solve_linear_chain(prepare(LINEAR, scene.angles, loads))
    assert [p["force_N"] for p in found["pairs"]] == pytest.approx(one.ball_force, rel=1e-8)
    assert np.all(one.ball_force > 0.0)
    cut = solved("lin-chain-10", ("side_force_ratio = -0.6\n", 'side_force_ratio = -0.6\ngap = "0.5 mm"\n')).data
    assert cut["pairs"][0] == {"balls": "1-2", "gap_um": pytest.approx(500.0), "force_N": 0.0, "loss_mW": 0.0}
    assert cut["pairs"][1]["force_N"] > 0.0


def test_units_signs_and_either_way_to_give_the_groove():
    base = catalogue.any_scene("lin-rotary-2")
    assert isinstance(base, BearingBallScene)
    again = scene_file.read(
        changed(
            "lin-rotary-2",
            ('"10 rps"', '"600 rpm"'),
            ("conformity = 0.54", 'groove_radius = "6.75 mm"'),
            ('"5.2 um"', '"0.0052 mm"'),
            ('"100 N"', '"0.1 kN"'),
        ),
        "lin-rotary-2.toml",
    )
    assert isinstance(again, BearingBallScene)
    assert again.bearing.speed == pytest.approx(base.bearing.speed, rel=1e-15)
    assert again.bearing.groove_radius == pytest.approx(base.bearing.groove_radius, rel=1e-15)
    assert (again.force, again.displacement) == pytest.approx((base.force, base.displacement), rel=1e-15)
    forward, back = solve_kind(base).data, solved("lin-rotary-2", ('"10 rps"', '"-10 rps"')).data
    assert [back["torque"][k] for k in WAYS] == pytest.approx(
        [forward["torque"][WAYS[0]], -forward["torque"][WAYS[1]]], rel=1e-9
    )
    backwards = solved("lin-pair-a", ('"10 mm/s"', '"-0.01 m/s"'), ("-0.6", "0.6")).data
    assert backwards["pairs"][0]["force_N"] == pytest.approx(4.065, abs=5e-4)


def test_oversize_is_the_opposite_of_a_clearance_and_adds_load():
    base = catalogue.any_scene("lin-rotary-3")
    text = changed("lin-rotary-3", ("[load]", '[errors.balls]\noversize = "1 um"\n\n[load]'))
    tight = scene_file.read(text, "lin-rotary-3.toml")
    assert (base.bearing.clearance, tight.bearing.clearance) == (0.0, -1e-6)
    assert solve_kind(tight).data["load_sum_N"] > 1.05 * solve_kind(base).data["load_sum_N"]


def test_laws_approach_coulomb():
    exact = solve_kind(catalogue.any_scene("lin-rotary-2")).data["torque"]["friction_torque_Nmm"]
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


def test_loads_follow_their_distribution():
    for loads in ("balanced", "diagonal", "elastic"):
        found = solved("lin-pair-a", ('"balanced"', f'"{loads}"')).data["pairs"][0]["force_N"]
        ours = solve_pair(LINEAR, np.radians(2.0), -0.6, 100.0, loads=loads).force
        assert found == pytest.approx(ours, rel=1e-9)
    diagonal = solved("lin-pair-a", ('"balanced"', '"diagonal"')).data
    assert diagonal["solver"]["load_imbalance"] > 0.01, "the source's approximation does not balance; it is shown"


def test_no_contact_and_nothing_moving_are_said():
    answer = solved("lin-rotary-1", ('axial_force = "100 N"', 'axial_force = "0 N"'))
    assert not answer.converged
    assert answer.data["status"] == "no contact: nothing presses the ball"
    for name, old, new in (("lin-rotary-2", '"10 rps"', '"0 rps"'), ("lin-pair-a", '"10 mm/s"', '"0 mm/s"')):
        still = solved(name, (old, new))
        assert still.converged
        assert still.data["energy"]["loss_W"] == 0.0
        assert still.data["energy"]["balance_percent"] is None
    rolling = solved("lin-pair-a", ('"balanced"', '"elastic"'), ("-0.6", "-3.0")).data
    assert rolling["friction_increase_percent"] is None, "two contacts on a diagonal roll: no percentage of nothing"


@pytest.mark.parametrize(
    "name", ["lin-rotary-2", "lin-rotary-2-printed", "lin-pair-a", "lin-chain-10", "lin-screw-pair-a-inferred"]
)
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


def test_large_contacts_are_warned_of():
    answer = solved("lin-rotary-3", ('"100 N"', '"100 kN"'))
    assert "Hertz" in answer.data["warnings"][0]
    assert not solve_kind(catalogue.any_scene("lin-rotary-3")).data["warnings"]


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_says_what_it_leaves_out(kind):
    lines = left_out_of_kind(kind, "none" if kind.startswith("screw") else None)
    assert len(set(lines)) == len(lines) >= 9
    words = "lubricant", "hysteresis", "Heathcote", "cage", "gyroscopic", "yielding", "friction in the balance of loads"
    for word in words:
        assert sum(word in line for line in lines) == 1, word


def test_a_screw_whose_friction_moves_all_leaves_no_feedback_out():
    for coupling, count in (("none", 1), ("ball", 1), ("ball and screw", 0)):
        lines = left_out_of_kind("screw pair", coupling)
        assert sum("friction in the balance of loads" in line for line in lines) == count


@pytest.mark.parametrize(
    ("name", "table"), [("lin-rotary-2", "per contact"), ("lin-pair-a", "per ball"), ("lin-chain-10", "per ball")]
)
def test_json_is_finite_and_the_table_shows_result_energy_and_assumptions(name, table):
    found = run_friction(name, Choices(), details=True)
    data = json.loads(json.dumps(found.data, allow_nan=False))
    assert (found.code, data["scene"], data["converged"]) == (0, name, True)
    assert set(data["energy"]) == {"input_power_W", "loss_W", "balance_W", "balance_percent"}
    lines = [part for part in found.parts if isinstance(part, str)]
    for word in (name, "energy    ", "put in and", "assumed: ", "left out: lubricant", "solver: ", "law: coulomb"):
        assert any(word in line for line in lines), word
    tables = [part for part in found.parts if not isinstance(part, str)]
    assert tables[0].title == table
    assert all(t.row_count for t in tables)


def test_exit_code_of_a_scene_without_solution(tmp_path):
    path = tmp_path / "loose.toml"
    path.write_text(changed("lin-rotary-1", ('"100 N"', '"0 N"')), encoding="utf-8")
    found = run_friction(str(path), Choices(), details=True)
    assert (found.code, found.data["converged"]) == (1, False)
    assert "no contact" in found.parts[0]
