"""The command ``rollbench friction`` for scenes of whole screws and bearings: tables, JSON, refusals, dispatch."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.helpers import ALL_BUT_AXIAL, small_screw

from rollbench.comparison import cli
from rollbench.comparison.commands import printing
from rollbench.comparison.commands.printing import Answer, print_answer
from rollbench.comparison.errors import InputError, SceneError
from rollbench.comparison.reference.store import key_of
from rollbench.comparison.scenes import catalogue, scene_file
from rollbench.comparison.wings.friction import solve as friction_answer
from rollbench.comparison.wings.friction.answer import as_table, increase, three
from rollbench.comparison.wings.friction.band import feedback_warnings
from rollbench.comparison.wings.friction.solve import run_friction, solve_friction
from rollbench.comparison.wings.friction.whole import Choices, solve_scene
from rollbench.lowfi import jit
from rollbench.lowfi.friction.whole import feedback as ball_feedback
from rollbench.lowfi.friction.whole import state
from rollbench.lowfi.statics.static import solve_static
from rollbench.meshes.parts import BallErrors, Errors, Friction, Motion, Time

MINE = """
title = "Feed drive 40 x 20 of two starts, left hand, preloaded"
[material]
youngs_modulus = "208 GPa"
poissons_ratio = 0.3
[track]
pitch_radius = "20.5 mm"
lead = "20 mm"
contact_angle = "45 deg"
hand = "left"
starts = 2
[screw]
length = "700 mm"
outer_diameter = "40 mm"
conformity = 0.53
[nut]
position = "300 mm"
length = "70 mm"
outer_diameter = "70 mm"
conformity = 0.54
[balls]
radius = "3.175 mm"
count = 20
turns = 1.9
[errors.balls]
oversize = "4 um"
[[supports]]
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]
[[supports]]
at = "700 mm"
fix = ["ux", "uy"]
displace = { rx = "0.2 mrad" }
[[loads]]
at = "0 mm"
force = ["100 N", "0 N", "-3 kN"]
[friction]
coefficient = 0.06
nut = 0.07
assumed = ["Grease, by experience."]
[motion]
speed = "1500 rpm"
turns = "nut"
"""


def mine(*changes):
    text = MINE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return scene_file.loads(text, "my.toml")


def answer(scene, model="lin", **choices):
    return solve_scene(scene, Choices(model, **choices))


def test_two_start_left_hand_screw_of_a_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(MINE)
    found = run_friction(str(path), Choices())
    data = found.data
    assert found.code == 0
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


def test_drag_is_the_friction_torque_of_the_scene_without_loads():
    scene = mine()
    bare = answer(replace(scene, loads=())).data["torque"]
    assert answer(scene).data["torque"]["drag_torque_Nmm"] == pytest.approx(bare["friction_torque_Nmm"], rel=1e-9)
    assert bare["drag_torque_Nmm"] == bare["friction_torque_Nmm"]
    assert bare["efficiency_forward_percent"] is None, "no efficiency of a load that is round-off"
    assert bare["axial_load_N"] == 0.0
    assert bare["self_locking"] is None
    assert bare["load_moves"] is None


def test_powers_of_several_sets_on_a_shaft_add_up():
    """What the axial loads of both nuts put in is what the shaft's torque takes out and friction loses."""
    data = solve_friction("double-nut", Choices(mu=(0.1,))).data
    power, torque = data["energy"], data["torque"]
    speed = data["motion"]["speed_rad_s"]
    assert power["torque_power_W"] == pytest.approx(1e-3 * torque["driving_torque_on_screw_Nmm"] * speed, rel=1e-12)
    assert power["torque_power_W"] + power["axial_load_power_W"] == pytest.approx(power["loss_W"], rel=1e-9)
    assert power["efficiency_percent"] == pytest.approx(100.0 * (1.0 - power["loss_W"] / power["axial_load_power_W"]))


def test_without_friction_nothing_is_said_of_feedback_or_slip():
    lines = answer(mine(), mu=(0.0,)).text
    assert "energy: 0 W are put in and lost" in lines
    assert "feedback" not in lines
    assert "Heathcote" not in lines


def test_drag_without_preload_is_nothing():
    loose = answer(small_screw(force=(0.0, 0.0, 500.0)), mu=(0.1,)).data
    assert (loose["torque"]["drag_torque_Nmm"], loose["drag_unknown"], loose["drag_note"]) == (0.0, None, None)


@pytest.mark.parametrize("oversize", [0.0, 5e-6])
def test_drag_where_supports_press_is_that_of_the_screw_left_free_along_its_axis(oversize):
    pressed = (*ALL_BUT_AXIAL, ("uz", 3e-6))
    held, free = (answer(small_screw(fixed=fixed, oversize=oversize), mu=(0.1,)).data for fixed in (pressed, ALL_BUT_AXIAL))
    assert abs(held["torque"]["axial_load_N"]) > 1.0
    assert held["torque"]["friction_torque_Nmm"] > 1.01 * held["torque"]["drag_torque_Nmm"]
    assert held["torque"]["drag_torque_Nmm"] == pytest.approx(free["torque"]["drag_torque_Nmm"], rel=1e-9)
    assert (free["torque"]["drag_torque_Nmm"] > 0.0) == (oversize > 0.0)
    assert "left free along its axis: its supports press it with" in held["drag_note"]
    assert (held["drag_unknown"], free["drag_note"]) == (None, None)


def test_nothing_loaded_is_said():
    found = answer(small_screw(), mu=(0.1,))
    assert found.converged
    assert found.data["status"].startswith("converged: no contact")
    assert found.data["torque"]["friction_torque_Nmm"] == 0.0
    assert found.data["balls"][0]["orbit_rad_s"] is None
    assert not found.tables


def test_coefficients_of_the_command_line_and_a_table_over_them():
    scene = replace(mine(), friction=None)
    found = answer(scene, mu=(0.08, 0.0, 0.04))
    rows = found.data["over_friction"]
    assert [r["screw"] for r in rows] == [0.08, 0.0, 0.04]
    assert rows[0]["friction_torque_Nmm"] == pytest.approx(2.0 * rows[2]["friction_torque_Nmm"], rel=1e-2)
    assert rows[1]["efficiency_forward_percent"] == 100.0
    assert found.data["friction"] == {"screw": 0.08, "nut": 0.08}
    assert [t[0] for t in found.tables][-1] == "over the coefficient of friction"
    with pytest.raises(InputError, match=r"friction: got nothing.*--mu"):
        answer(scene)


def test_speed_is_stated_where_the_scene_gives_none():
    with_speed, without = answer(mine()).data, answer(replace(mine(), motion=None)).data
    assert without["motion"] == {"turns": "screw", "speed_rad_s": pytest.approx(2.0 * math.pi)}
    assert any("no [motion]" in line for line in without["assumed"])
    assert not any("no [motion]" in line for line in with_speed["assumed"])
    for same in ("forward_torque_Nmm", "backward_torque_Nmm"):
        assert without["torque"][same] == pytest.approx(with_speed["torque"][same], rel=1e-6)


def test_shipped_case_and_a_bearing_answer(capsys):
    assert (
        cli.commands("friction")(["friction", "lin-case3", "--model", "lin", "--json"], result_action="return_value") == 0
    )
    data = json.loads(capsys.readouterr().out)
    assert data["torque"]["axial_load_N"] == pytest.approx(5000.0, rel=1e-6)
    assert 80.0 < data["torque"]["efficiency_backward_percent"] < data["torque"]["efficiency_forward_percent"] < 95.0
    assert any("Table 3.6" in line for line in data["assumed"])
    command = ["friction", "bearing-9", "--model", "lin", "--mu", "0.1", "--json"]
    assert cli.commands("friction")(command, result_action="return_value") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["kind"] == "bearing"
    assert data["torque"]["efficiency_forward_percent"] is None
    assert data["torque"]["driving_torque_on_screw_Nmm"] == pytest.approx(data["torque"]["friction_torque_Nmm"])


@pytest.mark.parametrize("width", [60, 100])
def test_the_torque_comes_first_and_the_table_of_balls_where_asked_for(width, monkeypatch, capsys):
    found = answer(mine())
    short, long = as_table(found), as_table(found, balls=True)
    assert short[3].startswith("torque    ")
    assert "which a motor must give the nut" in short[3].replace("\n          ", " ")
    monkeypatch.setattr(printing, "text_width", lambda: width)
    print_answer(Answer(parts=[part for part in short if isinstance(part, str)], folded=True))
    assert max(map(len, capsys.readouterr().out.splitlines())) <= width
    titles = [[part.title for part in parts if not isinstance(part, str)] for parts in (short, long)]
    assert titles == [["losses by contact and cause"], ["losses by contact and cause", "per ball"]]
    assert any("--balls" in str(part) for part in short)
    assert not any("--balls" in str(part) for part in long)


def test_terminal_shows_torques_losses_and_what_is_left_out():
    found = answer(mine())
    brief, full = (
        " ".join("\n".join(part for part in as_table(found, details=d) if isinstance(part, str)).split()) for d in (0, 1)
    )
    for words in ("friction torque", "drag torque without", "efficiency", "W are put in and lost"):
        assert words in brief
        assert words in full
    for words in ("left out: lubric", "assumed: ", "solver: contact loads with a residual of "):
        assert words not in brief
        assert words in full
    count = f"{len(found.data['assumed'])} assumptions, {len(found.data['left_out'])} things left out, balance and solver"
    assert f"{count}: --assumptions" in brief
    assert "--assumptions" not in full
    assert "which a motor must give the nut at 157.08 rad/s, which moves against the load" in brief
    locked = mine(("coefficient = 0.06", "coefficient = 0.5"), ("nut = 0.07", "nut = 0.5"), ("-3 kN", "-0.1 kN"))
    found = answer(locked)
    assert "self-locking" in found.text
    assert found.data["torque"]["self_locking"] is True
    assert found.data["torque"]["efficiency_backward_percent"] is None
    assert any("jammed" in line for line in found.data["warnings"])


def test_a_scene_that_is_not_held_ends_with_its_mechanism():
    found = answer(small_screw(fixed=(), force=(0.0, 0.0, 100.0)), mu=(0.1,))
    assert not found.converged
    assert found.data["status"].startswith("contact loads: not held")


def test_two_point_contact_on_a_helix_is_warned_of():
    def warned(**options):
        scene = replace(small_screw(force=(0.0, 0.0, 300.0), **options), friction=Friction(0.1, 0.1, feedback=False))
        notes = answer(scene).data["warnings"]
        return any("two flanks only" in line for line in notes)

    assert warned()
    assert not warned(oversize=5e-6)
    assert not warned(lead=0.0, turns=5.0 / 6.0), "a ring's friction runs along its groove"


def test_balls_that_do_not_settle_are_named_and_leave_no_drag(monkeypatch):
    monkeypatch.setattr(ball_feedback, "ROUNDS", 0)
    found = answer(mine())
    assert not found.converged
    assert found.data["status"].startswith("friction and place do not agree on 20 balls: 1, 2")
    assert "feedback = false" in found.data["status"]
    assert (found.data["torque"]["drag_torque_Nmm"], found.data["drag_unknown"]) == (None, "no balance of friction found")
    assert found.data["feedback"]["unsettled_balls"] == 20


def test_few_balls_do_not_wait_for_kernels(monkeypatch, tmp_path):
    path = tmp_path / "my.toml"
    for name in ("cached", "loaded"):
        monkeypatch.setattr(state, name, lambda _: False)
    monkeypatch.setattr(jit, "_afterwards", {})
    for count, later in ((8, []), (10, [jit.CONTACT])):
        path.write_text(MINE.replace("count = 20", f"count = {count}"))
        assert run_friction(str(path), Choices("lin")).code == 0
        assert [*jit._afterwards] == later


def test_flanks_without_contact_have_no_angle():
    scene = replace(small_screw(force=(0.0, 0.0, 300.0)), friction=Friction(0.1, 0.1, feedback=False))
    ball = answer(scene).data["balls"][0]
    open_ = [side for side, load in ball["load_N"].items() if load == 0.0]
    assert len(open_) == 2
    assert all(ball["contact_angle_deg"][side] is None for side in open_)


def test_large_pressure_is_warned_of():
    small = answer(small_screw(force=(0.0, 0.0, 300.0)), mu=(0.1,)).data["warnings"]
    large = answer(small_screw(force=(0.0, 0.0, 30000.0)), mu=(0.1,)).data["warnings"]
    assert not any("ISO 76" in line for line in small)
    assert any("ISO 76" in line for line in large)


@pytest.mark.parametrize(
    ("word", "feedback", "neighbours"), [("none", False, False), ("ball", True, False), ("balls", False, True)]
)
def test_the_former_key_is_read_and_its_new_names_are_said(word, feedback, neighbours):
    found = mine(("nut = 0.07", f'nut = 0.07\ncoupling = "{word}"')).friction
    assert (found.feedback, found.neighbours) == (feedback, neighbours)
    new = f"feedback = {str(feedback).lower()}, neighbours = {str(neighbours).lower()}"
    assert found.assumed[-1] == f'The former key coupling = "{word}" is read as {new}.'


def test_feedback_and_neighbours_are_two_keys():
    found = mine(("nut = 0.07", "nut = 0.07\nfeedback = true\nneighbours = true")).friction
    assert (found.feedback, found.neighbours) == (True, True)
    plain = mine().friction
    assert (plain.feedback, plain.neighbours) == (True, False)


BAD = {
    "range": (("coefficient = 0.06", "coefficient = 2.5"), "friction.coefficient: got 2.5; allowed: 0 to 2"),
    "no coefficient": (("coefficient = 0.06\n", ""), "friction.coefficient: got nothing"),
    "coupling": (("nut = 0.07", 'coupling = "screw"'), 'friction.coupling: got "screw"; allowed: "none", "ball"'),
    "former and new key": (("nut = 0.07", 'coupling = "ball"\nfeedback = true'), "friction.coupling: got both"),
    "unit": (('"1500 rpm"', '"1500 Hz"'), "motion.speed: got .*rpm"),
    "at rest": (('"1500 rpm"', '"0 rpm"'), "motion.speed: got .*any angular speed but zero"),
    "nothing to run over": (("[motion]", "[time]\nsteps = 20\n[motion]"), "time: got .*either angle or duration"),
    "two ends of a run": (
        ("[motion]", '[time]\nangle = "1 deg"\nduration = "1 s"\n[motion]'),
        "time.angle: got both; allowed: either angle or duration",
    ),
    "two clearances": (("[motion]", '[circulation]\ngap = "1 mm"\nfilling = 0.5\n[motion]'), "circulation.gap: got both"),
    "balls too many": (
        ("[motion]", "[circulation]\nfilling = 1\n[motion]"),
        "circulation.filling: got 1; allowed: up to 0",
    ),
    "a run off the screw": (
        ("[motion]", '[time]\nangle = "90000 deg"\n[motion]'),
        "time.angle: got .*the nut on the screw",
    ),
    "part": (('turns = "nut"', 'turns = "shaft"'), 'motion.turns: got "shaft"; allowed: "screw", "nut"'),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_tables_are_refused_in_one_line(case):
    change, words = BAD[case]
    with pytest.raises(SceneError, match=words) as caught:
        mine(change)
    assert "\n" not in str(caught.value)


def test_coefficients_of_both_grooves_stand_for_the_shared_one():
    own = mine(("coefficient = 0.06", "screw = 0.06"))
    assert own.friction == mine().friction
    with pytest.raises(SceneError, match=r"friction.coefficient: got nothing; allowed: 0 to 2; .*screw and nut"):
        mine(("coefficient = 0.06\n", ""))
    double = catalogue.scene_text("double-nut")
    assert "coefficient = 0.05\n" in double
    with pytest.raises(SceneError, match=r"friction.coefficient: got nothing"):
        scene_file.read(double.replace("coefficient = 0.05\n", "nut = 0.05\n"), "double.toml")
    both = scene_file.read(double.replace("coefficient = 0.05\n", "screw = 0.04\nnut = 0.05\n"), "double.toml")
    assert (both.friction.screw, both.friction.nut) == (0.04, 0.05)


def test_files_and_names_go_to_the_solver_that_knows_them(tmp_path):
    own, kind, none = tmp_path / "own.toml", tmp_path / "kind.toml", tmp_path / "none.toml"
    own.write_text(MINE)
    kind.write_text(catalogue.scene_text("lin-pair-a"))
    none.write_text('title = "no kind"\n')
    assert solve_friction(str(own), Choices("lin")).data["kind"] == "ball screw"
    assert solve_friction(str(kind), Choices()).data["kind"] == "linear pair"
    with pytest.raises(SceneError, match="track: got nothing"):
        solve_friction(str(none), Choices())
    with pytest.raises(InputError, match="did you mean lin-rotary-1"):
        solve_friction("lin-rotary1", Choices())
    for choices in (Choices("lin"), Choices(mu=(0.1,)), Choices(member=1)):
        with pytest.raises(InputError, match="whole screw or bearing"):
            run_friction("lin-rotary-1", choices)
    found = run_friction("lin-rotary-1", Choices())
    assert (found.code, found.data["kind"]) == (0, "bearing ball")


@pytest.mark.parametrize(
    ("lead", "feedback", "words"),
    [
        (20e-3, True, ("from four displaced starts",)),
        (20e-3, False, ("none was searched for", "feedback = true")),
        (0.0, True, ("none was searched for", "along the grooves")),
    ],
)
def test_second_states_that_were_not_searched_for_are_not_said_to_be_absent(lead, feedback, words):
    scene = small_screw(3, 0.7, lead=lead, force=(0.0, 0.0, 300.0), screw="rigid")
    found = answer(replace(scene, friction=Friction(0.4, 0.4, feedback=feedback), motion=Motion(3.0)))
    note = next(n for n in found.data["warnings"] if "jammed" in n)
    assert all(word in note for word in words)
    assert (found.data["solver"]["second_states"] is None) is ("none was searched for" in note)
    assert "rolls" not in note


@pytest.mark.parametrize("mu", [-0.1, 2.1, math.nan])
def test_coefficients_of_the_command_line_have_a_range(mu):
    with pytest.raises(InputError, match=r"--mu.*0 to 2"):
        answer(mine(), mu=(mu,))


def test_member_draws_the_specimen_of_loads_and_friction():
    scene = mine(('oversize = "4 um"', 'oversize = "4 um"\nsigma = "0.5 um"'))
    found = [answer(scene, member=m) for m in (0, 1)]
    first, second = (a.data["torque"]["friction_torque_Nmm"] for a in found)
    assert abs(first - second) > 1e-6 * first
    assert [a.data["member"] for a in found] == [0, 1]
    assert ", member 1 of its random errors, " in str(as_table(found[1])[0])
    assert answer(mine()).data["member"] is None
    with pytest.raises(InputError, match="no random errors"):
        answer(mine(), member=1)


def test_friction_and_motion_leave_static_keys_alone():
    plain = catalogue.scene("bearing-9")
    rubbing = replace(plain, friction=Friction(0.1, 0.2, feedback=False), motion=Motion(3.0, "nut"), time=Time(angle=1.0))
    assert rubbing != plain
    assert "friction=Friction(" in repr(rubbing)
    assert key_of(rubbing, "", {}, (0, 3)) == key_of(plain, "", {}, (0, 3))


def test_tables_are_read_in_si_units():
    scene = mine()
    assert scene.friction == Friction(0.06, 0.07, ("Grease, by experience.",), True)
    assert scene.motion == Motion(pytest.approx(50.0 * np.pi), "nut")
    assert mine(("nut = 0.07\n", "")).friction == Friction(0.06, 0.06, ("Grease, by experience.",), True)
    other = mine(("nut = 0.07", "screw = 0")).friction
    assert (other.screw, other.nut) == (0.0, 0.06)


def test_what_is_wrong_with_a_contact_is_told_once_and_as_solve_tells_it():
    """Warnings of size and pressure are those of the state with friction; the contact loads' own are not repeated."""
    hard = replace(small_screw(8, force=(0.0, 0.0, 60e3)), friction=Friction(0.1, 0.1, feedback=False))
    static = solve_static(hard).warnings
    for feedback in (False, True):
        scene = replace(hard, friction=replace(hard.friction, feedback=feedback))
        found = solve_scene(scene, Choices(model="lin")).data["warnings"]
        for head in ("contact ellipse too large", "contact pressure too high"):
            (once,) = (line for line in found if line.startswith(head))
            (other,) = (line for line in static if line.startswith(head))
            assert feedback or once == other


def test_a_scene_that_states_no_play_says_what_play_does():
    """One line with both torques; none where the file says how the balls fit, or the screw is preloaded."""
    scene = replace(small_screw(force=(0.0, 0.0, 300.0)), friction=Friction(0.1, 0.1))
    found = answer(scene)
    played = found.data["play"]
    smaller = replace(scene, errors=Errors(balls=BallErrors(oversize=-5e-6)))
    assert played["friction_torque_as_given_Nmm"] == found.data["torque"]["friction_torque_Nmm"]
    stated = answer(smaller)
    assert played["friction_torque_Nmm"] == pytest.approx(stated.data["torque"]["friction_torque_Nmm"], rel=1e-9)
    assert found.warning.startswith("WARNING: no preload and no play are stated")
    assert all(f"{played[key]:.4g} N mm" in found.warning for key in played if key.startswith("friction"))
    shown = [part for part in as_table(found) if isinstance(part, str)]
    assert (shown[2], sum("no preload and no play" in part for part in shown)) == (found.warning, 1)
    assert stated.data["play"] is None
    assert stated.warning == ""
    assert answer(replace(scene, errors=Errors(balls=BallErrors(oversize=3e-6)))).data["play"] is None


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("lin-case1-cut", "", "", ("WARNING: no preload and no play are stated",)),
        ("two-balls", "", "", ()),
        ("two-balls", 'oversize = "5 um"', 'oversize = "60 um"', ("WARNING outside", "contact pressure", "static safety")),
        ("double-nut", "", "", ()),
        ("double-nut", 'offset = "-4 um"', 'offset = "-120 um"', ("WARNING outside", "nut 1: preload", "nut 2: preload")),
    ],
)
def test_strict_ends_with_1_where_a_line_stands_above_the_answers(name, old, new, said, tmp_path, capsys, monkeypatch):
    (tmp_path / "a.toml").write_text(catalogue.scene_text(name).replace(old, new), encoding="utf-8")
    found = solve_friction(str(tmp_path / "a.toml"), Choices(mu=(0.1,)))
    monkeypatch.setattr(friction_answer, "solve_friction", lambda *_: found)
    for strict in (False, True):
        with pytest.raises(SystemExit) as stop:
            cli.main(["friction", name, "--mu", "0.1", "--json", *(["--strict"] if strict else [])])
        line = json.loads(capsys.readouterr().out)["warning"] or ""
        assert (stop.value.code or 0) == int(strict and bool(said))
        assert [line.count(word) for word in said] == [1] * len(said)
        assert bool(line) == bool(said)


def test_torques_over_the_measured_coefficients_stand_beside_the_maker_s_formula():
    scene = replace(small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), friction=Friction(0.05, 0.05))
    found = answer(scene)
    data = found.data["band"]
    for mu, torque in zip((0.003, 0.1), data["friction_torque_Nmm"], strict=True):
        own = answer(replace(scene, friction=Friction(mu, mu))).data["torque"]
        assert torque == pytest.approx(own["friction_torque_Nmm"], rel=1e-9)
    assert data["drag_torque_Nmm"][1] == pytest.approx(own["drag_torque_Nmm"], rel=1e-9)
    tangent = scene.track.lead / (2 * np.pi * scene.track.pitch_radius)
    formula = 0.05 / np.sqrt(tangent) * data["preload_N"] * 1e3 * scene.track.lead / (2 * np.pi)
    assert data["makers_formula_Nmm"] == pytest.approx(formula, rel=1e-9)
    assert 0.5 < data["drag_torque_Nmm"][1] / data["makers_formula_Nmm"] < 2.0
    assert f"{three(data['makers_formula_Nmm'])} N mm" in found.text
    bare = answer(replace(scene, errors=Errors())).data["band"]
    assert (bare["makers_formula_Nmm"], bare["drag_torque_Nmm"]) == (None, None)


def test_friction_that_raises_the_torque_much_is_said():
    state = SimpleNamespace(coupled=True, bare=SimpleNamespace(friction=0.1), torque=SimpleNamespace(friction=0.16))
    assert "raises the torque 1.6 times, from 100 to 160 N mm" in feedback_warnings(state)[0]
    state.torque.friction = 0.149
    assert feedback_warnings(state) == []


def test_changes_of_round_off_are_none():
    assert increase(1.0 + 2.8e-15, 1.0, 1.0) == 0.0
    assert increase(1.01, 1.0, 1.0) == pytest.approx(1.0)
