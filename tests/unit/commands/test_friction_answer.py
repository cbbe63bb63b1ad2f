"""The command ``rollbench friction`` for scenes of whole screws and bearings: torques, tables, JSON, dispatch."""

import json
import math
from dataclasses import replace

import pytest
from tests.feed_drive import MINE, answer, mine
from tests.helpers import small_screw

from rollbench.compare.commands.friction import friction_terminal_parts, solve_and_report_friction
from rollbench.compare.errors import InputError, SceneError
from rollbench.compare.results.rows import friction_rows
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.friction.solve import solve_friction_of_named_scene
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.meshes.parts import Friction


def test_two_start_left_hand_screw_of_a_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(MINE)
    found = solve_and_report_friction(str(path), FrictionChoices())
    data = found.data
    assert found.exit_code == 0
    json.dumps(data, allow_nan=False)
    t, e = data["torque"], data["energy"]
    assert (data["model"], data["converged"], data["kind"]) == ("refined", True, "ball screw")
    assert data["friction"] == {"screw": 0.06, "nut": 0.07}
    assert data["motion"] == {"turns": "nut", "speed_rad_s": pytest.approx(50.0 * math.pi)}
    assert e["input_power_W"] == pytest.approx(e["loss_W"], rel=1e-8)
    assert e["torque_power_W"] + e["axial_load_power_W"] == pytest.approx(e["loss_W"], rel=1e-8)
    assert data["losses"]["by_contact_W"][-1]["loss_W"] == pytest.approx(e["loss_W"], rel=1e-12)
    assert sum(sum(b["loss_mW"].values()) for b in data["balls"]) == pytest.approx(1e3 * e["loss_W"], rel=1e-9)
    assert t["axial_load_N"] == pytest.approx(-3000.0, rel=1e-6)
    assert t["load_moves"] == "against the load", "left hand, nut forward: the screw goes up, the load pulls down"
    assert t["driving_torque_on_nut_Nmm"] == pytest.approx(t["forward_torque_Nmm"], rel=1e-9)
    ideal = 3000.0 * 20.0 / (2.0 * math.pi)
    assert t["forward_torque_Nmm"] - t["friction_torque_Nmm"] == pytest.approx(ideal, rel=1e-6)
    assert t["efficiency_forward_percent"] == pytest.approx(100.0 * ideal / t["forward_torque_Nmm"], rel=1e-6)
    assert 0.0 < t["drag_torque_Nmm"] < 1.5 * t["friction_torque_Nmm"]
    assert "Grease, by experience." in data["assumed"]
    assert len(data["balls"]) == 20


def test_powers_of_several_sets_on_a_shaft_add_up():
    """What the axial loads of both nuts put in is what the shaft's torque takes out and friction loses."""
    data = solve_friction_of_named_scene("double-nut", FrictionChoices(mu=(0.1,))).data
    power, torque = data["energy"], data["torque"]
    speed = data["motion"]["speed_rad_s"]
    assert power["torque_power_W"] == pytest.approx(1e-3 * torque["driving_torque_on_screw_Nmm"] * speed, rel=1e-12)
    assert power["torque_power_W"] + power["axial_load_power_W"] == pytest.approx(power["loss_W"], rel=1e-9)
    assert power["efficiency_percent"] == pytest.approx(100.0 * (1.0 - power["loss_W"] / power["axial_load_power_W"]))


def test_nothing_loaded_is_said_and_a_scene_that_is_not_held_ends_with_its_mechanism():
    found = answer(small_screw(), mu=(0.1,))
    assert found.converged
    assert found.data["status"].startswith("converged: no contact")
    assert (found.data["torque"]["friction_torque_Nmm"], found.data["balls"][0]["orbit_rad_s"]) == (0.0, None)
    assert not found.tables
    found = answer(small_screw(fixed=(), force=(0.0, 0.0, 100.0)), mu=(0.1,))
    assert not found.converged
    assert found.data["status"].startswith("contact loads: not held")


def test_coefficients_of_the_command_line_and_a_table_over_them():
    scene = replace(mine(), friction=None)
    found = answer(scene, mu=(0.08, 0.0, 0.04))
    rows = found.data["over_friction"]
    assert [r["screw"] for r in rows] == [0.08, 0.0, 0.04]
    assert rows[0]["friction_torque_Nmm"] == pytest.approx(2.0 * rows[2]["friction_torque_Nmm"], rel=1e-2)
    assert (rows[1]["efficiency_forward_percent"], found.tables[-1][0]) == (100.0, "over the coefficient of friction")
    assert found.data["friction"] == {"screw": 0.08, "nut": 0.08}
    with pytest.raises(InputError, match=r"friction: got .*mu=0.1"):
        answer(scene)
    for mu in (-0.1, 2.1, math.nan):
        with pytest.raises(InputError, match=r"mu: .*0 to 2"):
            answer(mine(), mu=(mu,))


def test_speed_is_stated_where_the_scene_gives_none():
    with_speed, without = answer(mine()).data, answer(replace(mine(), motion=None)).data
    assert without["motion"] == {"turns": "screw", "speed_rad_s": pytest.approx(2.0 * math.pi)}
    assert ["no [motion]" in " ".join(data["assumed"]) for data in (with_speed, without)] == [False, True]
    for same in ("forward_torque_Nmm", "backward_torque_Nmm"):
        assert without["torque"][same] == pytest.approx(with_speed["torque"][same], rel=1e-6)


def test_shipped_case_and_a_bearing_answer(command):
    data = command.answer("friction", "lin-case3", "--model", "lin")
    assert data["torque"]["axial_load_N"] == pytest.approx(5000.0, rel=1e-6)
    assert 80.0 < data["torque"]["efficiency_backward_percent"] < data["torque"]["efficiency_forward_percent"] < 95.0
    assert any("Table 3.6" in line for line in data["assumed"])
    data = command.answer("friction", "bearing-9", "--model", "lin", "--mu", "0.1")
    assert (data["kind"], data["torque"]["efficiency_forward_percent"]) == ("bearing", None)
    assert data["torque"]["driving_torque_on_screw_Nmm"] == pytest.approx(data["torque"]["friction_torque_Nmm"])


def test_terminal_shows_torques_losses_and_what_is_left_out():
    found = answer(mine())
    brief, full = (
        " ".join("\n".join(part for part in friction_terminal_parts(found, details=d) if isinstance(part, str)).split())
        for d in (0, 1)
    )
    torques = ("friction torque", "drag torque", "efficiency against the load", "power lost")
    others = ("left out: lubric", "assumed: ", "solver contact loads with a residual of ")
    assert [words for words in (*torques, *others) if words in brief] == [*torques]
    assert [words for words in (*torques, *others) if words not in full] == []
    count = f"{len(found.data['assumed'])} assumptions, {len(found.data['left_out'])} neglected effects"
    assert f"--verbose also shows: {count}" in brief
    assert "--verbose" not in full
    assert "which a motor must give the nut at 157.08 rad/s, which moves against the load" in full
    locked = mine(("coefficient = 0.06", "coefficient = 0.5"), ("nut = 0.07", "nut = 0.5"), ("-3 kN", "-0.1 kN"))
    found = answer(locked)
    assert ("self-locking", "yes") in [row[:2] for row in friction_rows(found.data)]
    torque = found.data["torque"]
    assert (torque["self_locking"], torque["efficiency_backward_percent"]) == (True, None)
    assert any("jammed" in line for line in found.data["warnings"])


def test_flanks_without_contact_have_no_angle():
    scene = replace(small_screw(force=(0.0, 0.0, 300.0)), friction=Friction(0.1, 0.1, feedback=False))
    ball = answer(scene).data["balls"][0]
    open_ = [side for side, load in ball["load_N"].items() if load == 0.0]
    assert len(open_) == 2
    assert all(ball["contact_angle_deg"][side] is None for side in open_)


def test_files_and_names_go_to_the_solver_that_knows_them(tmp_path):
    screw, kind, none = tmp_path / "own.toml", tmp_path / "kind.toml", tmp_path / "none.toml"
    screw.write_text(MINE)
    kind.write_text(catalogue.shipped_scene_text("lin-pair-a"))
    none.write_text('title = "no kind"\n')
    assert solve_friction_of_named_scene(str(screw), FrictionChoices("lin")).data["kind"] == "ball screw"
    assert solve_friction_of_named_scene(str(kind), FrictionChoices()).data["kind"] == "linear pair"
    with pytest.raises(SceneError, match="track: got nothing"):
        solve_friction_of_named_scene(str(none), FrictionChoices())
    with pytest.raises(InputError, match="did you mean lin-rotary-1"):
        solve_friction_of_named_scene("lin-rotary1", FrictionChoices())
    for choices in (FrictionChoices("lin"), FrictionChoices(mu=(0.1,)), FrictionChoices(member=1)):
        with pytest.raises(InputError, match="whole screw or bearing"):
            solve_and_report_friction("lin-rotary-1", choices)
    found = solve_and_report_friction("lin-rotary-1", FrictionChoices())
    assert (found.exit_code, found.data["kind"]) == (0, "bearing ball")


def test_member_draws_the_specimen_of_loads_and_friction():
    scene = mine(('oversize = "4 um"', 'oversize = "4 um"\nsigma = "0.5 um"'))
    found = [answer(scene, member=m) for m in (0, 1)]
    first, second = (a.data["torque"]["friction_torque_Nmm"] for a in found)
    assert abs(first - second) > 1e-6 * first
    assert [a.data["member"] for a in found] == [0, 1]
    assert ", specimen 1 of its random errors, " in str(friction_terminal_parts(found[1])[0])
    assert answer(mine()).data["member"] is None
    with pytest.raises(InputError, match="no random geometric errors"):
        answer(mine(), member=1)
