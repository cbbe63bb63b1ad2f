"""The command ``rollbench friction`` for scenes of whole screws and bearings: torques, drag without loads or with supports
that press, the band over measured coefficients, tables, JSON, dispatch."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.feed_drive import MINE, answer, mine
from tests.helpers import ALL_BUT_AXIAL, small_screw

from rollbench.compare.scenes import catalogue
from rollbench.compare.studies.friction.solve import solve_friction_of_named_scene, solve_friction_of_scene
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.compare.text.friction import friction_tables
from rollbench.lowfi.friction.whole import feedback as ball_feedback
from rollbench.meshes.parts import Errors, Friction, Motion


def test_two_start_left_hand_screw_of_a_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(MINE)
    found = solve_friction_of_named_scene(str(path), FrictionChoices())
    data = found.to_dict()
    assert found.converged
    t, e = data["torque"], data["energy"]
    assert (data["model"], data["converged"], data["kind"]) == ("refined", True, "ball screw")
    assert data["friction"] == {"screw": 0.06, "nut": 0.07}
    assert data["motion"] == {"turns": "nut", "speed_rad_s": pytest.approx(50.0 * math.pi)}
    assert [e["input_power_W"], e["torque_power_W"] + e["axial_load_power_W"]] == pytest.approx([e["loss_W"]] * 2, rel=1e-8)
    assert data["losses"]["by_contact_W"][-1]["loss_W"] == pytest.approx(e["loss_W"], rel=1e-12)
    assert len(data["balls"]) == 20
    assert sum(sum(b["loss_mW"].values()) for b in data["balls"]) == pytest.approx(1e3 * e["loss_W"], rel=1e-9)
    assert t["axial_load_N"] == pytest.approx(-3000.0, rel=1e-6)
    assert t["load_moves"] == "against the load", "left hand, nut forward: the screw goes up, the load pulls down"
    assert t["driving_torque_on_nut_Nmm"] == pytest.approx(t["forward_torque_Nmm"], rel=1e-9)
    ideal = 3000.0 * 20.0 / (2.0 * math.pi)
    assert t["forward_torque_Nmm"] - t["friction_torque_Nmm"] == pytest.approx(ideal, rel=1e-6)
    assert t["efficiency_forward_percent"] == pytest.approx(100.0 * ideal / t["forward_torque_Nmm"], rel=1e-6)
    assert 0.0 < t["drag_torque_Nmm"] < 1.5 * t["friction_torque_Nmm"]
    assert "Grease, by experience." in data["assumed"]


@pytest.mark.parametrize("name", ["double-nut", "lin-case3"])
def test_both_senses_of_rotation_stand_in_one_answer(name):
    """Torques against and with the load are those that drive and brake the scene turned the one way and the other; what the
    axial loads of all nuts put in is what the shaft's torque takes out and friction loses."""
    scene = catalogue.scene_of_any_kind(name)
    there, back = (
        solve_friction_of_scene(replace(scene, motion=Motion(speed)), FrictionChoices("lin", mu=(0.1,)), name)
        for speed in (50.0, -50.0)
    )
    for record, turned in ((there, back), (back, there)):
        one, other = record.as_json(), turned.as_json()
        t, driving = one["torque"], [abs(x["torque"]["driving_torque_on_screw_Nmm"]) for x in (one, other)]
        assert sorted(driving) == pytest.approx([t["backward_torque_Nmm"], t["forward_torque_Nmm"]], rel=1e-6)
        assert t["reverse_friction_torque_Nmm"] == pytest.approx(other["torque"]["friction_torque_Nmm"], rel=1e-6)
        against = max((one, other), key=lambda x: abs(x["torque"]["driving_torque_on_screw_Nmm"]))["torque"]
        frictionless = t["forward_torque_Nmm"] - against["friction_torque_Nmm"]
        assert t["efficiency_forward_percent"] == pytest.approx(100.0 * frictionless / t["forward_torque_Nmm"], rel=1e-6)
        power, speed = one["energy"], one["motion"]["speed_rad_s"]
        torque = 1e-3 * one["torque"]["driving_torque_on_screw_Nmm"]
        assert power["torque_power_W"] == pytest.approx(torque * speed, rel=1e-12)
        assert power["torque_power_W"] + power["axial_load_power_W"] == pytest.approx(power["loss_W"], rel=1e-9)


def test_nothing_loaded_is_said_and_a_scene_that_is_not_held_ends_with_its_mechanism():
    bare, loose = (answer(scene, mu=(0.1,)) for scene in (small_screw(), small_screw(fixed=(), force=(0.0, 0.0, 100.0))))
    assert [bare.converged, loose.converged] == [True, False]
    assert bare.as_json()["status"].startswith("converged: no contact")
    assert (bare.as_json()["torque"]["friction_torque_Nmm"], bare.as_json()["balls"][0]["orbit_rad_s"]) == (0.0, None)
    assert loose.as_json()["status"].startswith("contact loads: not held")


def test_coefficients_of_the_command_line_and_a_table_over_them():
    scene = replace(mine(), friction=None)
    found = answer(scene, mu=(0.08, 0.0, 0.04))
    rows = found.as_json()["over_friction"]
    assert [r["screw"] for r in rows] == [0.08, 0.0, 0.04]
    assert rows[0]["friction_torque_Nmm"] == pytest.approx(2.0 * rows[2]["friction_torque_Nmm"], rel=1e-2)
    assert rows[1]["efficiency_forward_percent"] == 100.0
    assert dict(friction_tables(found, balls=False))["over the coefficient of friction"] == rows
    assert found.as_json()["friction"] == {"screw": 0.08, "nut": 0.08}


def test_a_jammed_screw_is_self_locking_and_warned_of():
    found = answer(mine(("coefficient = 0.06", "coefficient = 0.5"), ("nut = 0.07", "nut = 0.5"), ("-3 kN", "-0.1 kN")))
    assert ("self-locking", "yes") in [row[:2] for row in found.rows()]
    torque = found.as_json()["torque"]
    assert (torque["self_locking"], torque["efficiency_backward_percent"]) == (True, None)
    assert any("jammed" in line for line in found.as_json()["warnings"])


def test_member_draws_the_specimen_of_loads_and_friction():
    scene = mine(('oversize = "4 um"', 'oversize = "4 um"\nsigma = "0.5 um"'))
    found = [answer(scene, member=m) for m in (0, 1)]
    first, second = (a.as_json()["torque"]["friction_torque_Nmm"] for a in found)
    assert abs(first - second) > 1e-6 * first
    assert [a.as_json()["member"] for a in found] == [0, 1]
    assert answer(mine()).as_json()["member"] is None


def test_drag_is_the_friction_torque_of_the_scene_without_loads_and_without_preload_nothing():
    scene = mine()
    bare = answer(replace(scene, loads=())).as_json()["torque"]
    assert answer(scene).as_json()["torque"]["drag_torque_Nmm"] == pytest.approx(bare["friction_torque_Nmm"], rel=1e-9)
    assert bare["drag_torque_Nmm"] == bare["friction_torque_Nmm"]
    assert bare["axial_load_N"] == 0.0
    unknown = [bare[key] for key in ("efficiency_forward_percent", "self_locking", "load_moves")]
    assert unknown == [None] * 3, "no efficiency of a load that is round-off"
    loose = answer(small_screw(force=(0.0, 0.0, 500.0)), mu=(0.1,)).as_json()
    assert (loose["torque"]["drag_torque_Nmm"], loose["drag_unknown"], loose["drag_note"]) == (0.0, None, None)


@pytest.mark.parametrize("oversize", [0.0, 5e-6])
def test_drag_where_supports_press_is_that_of_the_screw_left_free_along_its_axis(oversize):
    pressed = (*ALL_BUT_AXIAL, ("uz", 3e-6))
    held, free = (
        answer(small_screw(fixed=fixed, oversize=oversize), mu=(0.1,)).as_json() for fixed in (pressed, ALL_BUT_AXIAL)
    )
    assert abs(held["torque"]["axial_load_N"]) > 1.0
    assert held["torque"]["friction_torque_Nmm"] > 1.01 * held["torque"]["drag_torque_Nmm"]
    assert held["torque"]["drag_torque_Nmm"] == pytest.approx(free["torque"]["drag_torque_Nmm"], rel=1e-9)
    assert (free["torque"]["drag_torque_Nmm"] > 0.0) == (oversize > 0.0)
    assert "left free along its axis: its supports press it with" in held["drag_note"]
    assert (held["drag_unknown"], free["drag_note"]) == (None, None)


def test_balls_that_do_not_settle_are_named_and_leave_no_drag(monkeypatch):
    monkeypatch.setattr(ball_feedback, "ROUNDS", 0)
    monkeypatch.setattr(ball_feedback, "STEPS", 0)
    found = answer(mine())
    assert not found.converged
    assert found.as_json()["status"].startswith("friction and position do not agree on 20 balls: 1, 2")
    assert "feedback = false" in found.as_json()["status"]
    assert (found.as_json()["torque"]["drag_torque_Nmm"], found.as_json()["drag_unknown"]) == (
        None,
        "no balance of friction found",
    )
    assert found.as_json()["feedback"]["unsettled_balls"] == 20


def test_the_note_names_the_flank_that_friction_presses_the_balls_onto():
    """A note on flank SR with its load, and on flank NL reversed."""
    scene = small_screw(8, lead=10e-3, force=(0.0, 0.0, 800.0), oversize=1e-6)
    there, back = (
        answer(replace(scene, friction=Friction(0.1, 0.1), motion=Motion(speed))).as_json()
        for speed in (2.0 * np.pi, -2.0 * np.pi)
    )
    notes = [next(w for w in data["warnings"] if w.kind == "third flank") for data in (there, back)]
    for note, data, flank, other in zip(notes, (there, back), ("SR", "NL"), ("NL", "SR"), strict=True):
        losses = {row["contact"]: row for row in data["losses"]["by_contact_W"]}
        assert losses[flank]["mean_load_N"] == pytest.approx(np.mean([b["load_N"][flank] for b in data["balls"]]))
        assert losses[flank]["mean_load_N"] > losses[flank]["mean_load_without_friction_N"] + 1.0
        assert losses[flank]["sliding_along"] == max(row["sliding_along"] for name, row in losses.items() if name != "sum")
        assert f"onto flank {flank}, {losses[flank]['mean_load_N']:.3g} N a ball" in note
        assert f"reversed, flank {other}" in note
    assert there["losses"]["heathcote_percent"] == pytest.approx(
        100.0 * (there["losses"]["by_contact_W"][-1]["with_curvature_W"] / there["losses"]["total_W"] - 1.0), rel=1e-6
    )


def test_torques_over_the_measured_coefficients_stand_beside_the_maker_s_formula():
    scene = replace(small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), friction=Friction(0.05, 0.05))
    found = answer(scene)
    data = found.as_json()["band"]
    for mu, torque in zip((0.03, 0.1), data["friction_torque_Nmm"], strict=True):
        alone = answer(replace(scene, friction=Friction(mu, mu))).as_json()["torque"]
        assert torque == pytest.approx(alone["friction_torque_Nmm"], rel=1e-9)
    assert data["drag_torque_Nmm"][1] == pytest.approx(alone["drag_torque_Nmm"], rel=1e-9)
    tangent = scene.track.lead / (2 * np.pi * scene.track.pitch_radius)
    formula = 0.05 / np.sqrt(tangent) * data["preload_N"] * 1e3 * scene.track.lead / (2 * np.pi)
    assert data["makers_formula_Nmm"] == pytest.approx(formula, rel=1e-9)
    assert 0.5 < data["drag_torque_Nmm"][1] / data["makers_formula_Nmm"] < 2.0
    said = next(row for row in found.rows() if row.quantity == "drag torque by THK's formula")
    assert (float(said.value), said.unit) == (pytest.approx(data["makers_formula_Nmm"], rel=5e-3), "N mm")
    bare = answer(replace(scene, errors=Errors())).as_json()["band"]
    assert (bare["makers_formula_Nmm"], bare["drag_torque_Nmm"]) == (None, None)
