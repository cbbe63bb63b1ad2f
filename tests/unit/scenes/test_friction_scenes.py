"""Friction scenes: shipped ones give the library's numbers, bad ones one line; table, JSON and exit code."""

import json

import numpy as np
import pytest

from compare.commands.friction import run_friction
from compare.commands.friction_kinds import solve_kind
from compare.commands.friction_whole import Choices
from compare.commands.left_out import left_out_of_kind
from compare.errors import InputError, SceneError
from compare.scenes import catalogue, scene_file
from compare.scenes.keys import tidy_schema
from compare.scenes.kinds.bearing_ball import BearingBallScene
from compare.scenes.kinds.linear import LinearScene
from compare.scenes.kinds.table import KINDS
from lowfi.friction.bearing.rotary import SIDES, Bearing, solve_ball, solve_ball_as_printed, source_law
from lowfi.friction.linear.bearing import LinearBearing
from lowfi.friction.linear.chain import prepare, solve
from lowfi.friction.linear.pair import solve_pair

ROTARY = Bearing(6.25e-3, 6.75e-3, 35e-3, 0.25 * np.pi, 2.1e11, 0.28, 0.1, 20.0 * np.pi)
LINEAR = LinearBearing(5e-3, 0.56, 0.25 * np.pi, 0.01, 0.1, 0.1, 2.1e11, 0.28)
WAYS = "friction_torque_Nmm", "driving_torque_on_screw_Nmm"
U_Y = {"1": 0.0, "2": 5.2e-6, "3": 8.0e-6}


def text(name):
    return catalogue.scene_text(name)


def changed(name, *changes):
    out = text(name)
    for old, new in changes:
        assert old in out, f"{name} has no {old}"
        out = out.replace(old, new, 1)
    return out


def solved(name, *changes):
    return solve_kind(scene_file.read(changed(name, *changes), "my.toml"))


def test_every_shipped_scene_converges_and_balances_power():
    names = sorted(set(catalogue.scene_names()) - set(catalogue.whole_names()) - set(catalogue.axis_names()))
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
    one = solve(prepare(LINEAR, scene.angles, loads))
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


# --- refusals

COULOMB = 'law = "coulomb"'
CASES = {  # name: (scene, changes, key, value as found, a part of range or advice)
    "no kind": ("lin-rotary-1", [('kind = "bearing ball"', "")], "kind", "nothing", "[load] belongs"),
    "unknown kind": (
        "lin-rotary-1",
        [('kind = "bearing ball"', 'kind = "baring ball"')],
        "kind",
        '"baring ball"',
        "did you mean",
    ),
    "kind of another type": ("lin-rotary-1", [('"bearing ball"', "3")], "kind", "3", '"bearing ball"'),
    "unknown key": ("lin-rotary-1", [("conformity", "conformty")], "screw.conformty", "0.54", "mean conformity"),
    "unknown table": ("lin-rotary-1", [("[motion]", "[moton]")], "moton", "{ speed", "did you mean motion"),
    "key of another kind": (
        "lin-pair-a",
        [("[track]", '[track]\npitch_radius = "3 mm"')],
        "track.pitch_radius",
        '"3 mm"',
        "unknown key",
    ),
    "missing key": ("lin-rotary-1", [('pitch_radius = "35 mm"', "")], "track.pitch_radius", "nothing", "16.5 mm"),
    "missing table": ("lin-pair-a", [('[motion]\ncarriage = "10 mm/s"', "")], "motion", "nothing", "[motion] table"),
    "no unit": ("lin-rotary-1", [('"6.25 mm"', "6.25")], "balls.radius", "6.25", "0.01 mm to 1 m"),
    "speed without unit": ("lin-rotary-1", [('"10 rps"', '"10"')], "motion.speed", '"10"', "rad/s, deg/s, rps"),
    "speed as a number": ("lin-rotary-1", [('"10 rps"', "10")], "motion.speed", "10", "an angular speed"),
    "speed of another kind": ("lin-pair-a", [('"10 mm/s"', '"10 rps"')], "motion.carriage", '"10 rps"', "a speed"),
    "speed too large": ("lin-pair-a", [('"10 mm/s"', '"1e5 m/s"')], "motion.carriage", '"1e5 m/s"', "-1000 m/s to"),
    "speed not finite": ("lin-pair-a", [('"10 mm/s"', '"nan mm/s"')], "motion.carriage", '"nan mm/s"', "a number"),
    "no groove": ("lin-rotary-1", [("conformity = 0.54", "")], "screw.groove_radius", "neither", "one of"),
    "two grooves": (
        "lin-rotary-1",
        [("conformity = 0.54", 'conformity = 0.54\ngroove_radius = "7 mm"')],
        "screw.groove_radius",
        "both",
        "one of",
    ),
    "groove below the ball": (
        "lin-rotary-1",
        [("conformity = 0.54", 'groove_radius = "6 mm"')],
        "screw.groove_radius",
        '"6 mm"',
        "above 6.25 mm",
    ),
    "conformity": ("lin-pair-a", [("0.56", "0.5")], "grooves.conformity", "0.5", "above 0.5"),
    "small ring": ("lin-rotary-1", [('"35 mm"', '"6 mm"')], "track.pitch_radius", '"6 mm"', "above 6.75 mm"),
    "contact angle": ("lin-rotary-1", [('"45 deg"', '"90 deg"')], "track.contact_angle", '"90 deg"', "below 90 deg"),
    "clearance": (
        "lin-rotary-1",
        [("[load]", '[errors.balls]\noversize = "0.6 mm"\n[load]')],
        "errors.balls.oversize",
        '"0.6 mm"',
        "between -0.5 mm and 0.5 mm",
    ),
    "displacement": ("lin-rotary-1", [('"0 um"', '"0.6 mm"')], "load.radial_displacement", '"0.6 mm"', "-0.5 mm"),
    "modulus": ("lin-rotary-1", [('"210 GPa"', '"210 N"')], "material.youngs_modulus", '"210 N"', "1 MPa"),
    "Poisson's ratio": ("lin-rotary-1", [("0.28", "0.5")], "material.poissons_ratio", "0.5", "below 0.5"),
    "coefficient": ("lin-rotary-1", [("ient = 0.1", "ient = -0.1")], "friction.coefficient", "-0.1", "0 to 2"),
    "unlike grooves": (
        "lin-rotary-1",
        [("[nut]\nconformity = 0.54", "[nut]\nconformity = 0.55")],
        "nut.conformity",
        "0.55",
        "6.75 mm",
    ),
    "ring with a lead": ("lin-rotary-1", [('"0 mm"', '"1 mm"')], "track.lead", '"1 mm"', '"0 mm"'),
    "no material": ("lin-rotary-1", [("poissons_ratio = 0.28", "")], "material.poissons_ratio", "nothing", "0.28"),
    "no sharpness": ("lin-rotary-1", [(COULOMB, 'law = "sigmoid"')], "friction.sharpness", "nothing", "k_S"),
    "unknown law": ("lin-rotary-1", [(COULOMB, 'law = "stribeck"')], "friction.law", '"stribeck"', '"sigmoid"'),
    "law of a linear bearing": (
        "lin-pair-a",
        [("balls = 0.1", 'law = "sigmoid"')],
        "friction.law",
        '"sigmoid"',
        "unknown key",
    ),
    "no creep": ("lin-rotary-1", [(COULOMB, 'law = "regularised"')], "friction.creep", "nothing", "above 0 m/s"),
    "creep zero": (
        "lin-rotary-1",
        [(COULOMB, 'law = "regularised"\ncreep = "0 m/s"')],
        "friction.creep",
        '"0 m/s"',
        "above 0 m/s",
    ),
    "key of another law": (
        "lin-rotary-1",
        [(COULOMB, COULOMB + "\nsharpness = 9")],
        "friction.sharpness",
        "9",
        'law = "sigmoid"',
    ),
    "sigmoid at rest": ("lin-rotary-1-printed", [('"10 rps"', '"0 rps"')], "motion.speed", '"0 rps"', "not zero"),
    "Hertz": (
        "lin-rotary-1",
        [("[load]", '[ingredients]\nhertz = "actual"\n[load]')],
        "ingredients.hertz",
        '"actual"',
        '"as printed"',
    ),
    "side force pulls": ("lin-pair-a", [("-0.6", "-0.94")], "load.side_force_ratio", "-0.94", "-0.9325 to 1"),
    "side force pulls the second": ("lin-pair-a", [("-0.6", "0.94")], "load.side_force_ratio", "0.94", "-1 to 0.9325"),
    "side force beyond a diagonal": (
        "lin-pair-a",
        [("-0.6", "-1.01"), ('"balanced"', '"diagonal"')],
        "load.side_force_ratio",
        "-1.01",
        "-1 to 1",
    ),
    "no vertical force": ("lin-pair-a", [('"100 N"', '"0 N"')], "load.vertical_force", '"0 N"', "above 0 N"),
    "unknown distribution": ("lin-pair-a", [('"balanced"', '"even"')], "load.distribution", '"even"', '"elastic"'),
    "angles past 90 deg": (
        "lin-pair-a",
        [('"2 deg"', '"14 deg"'), ('"45 deg"', '"80 deg"')],
        "angles.deviation",
        '"14 deg"',
        "below 90 deg",
    ),
    "mated": ("lin-pair-a", [("mated = false", 'mated = "no"')], "angles.mated", '"no"', "true, false"),
    "three deviations": ("lin-chain-10", [('"-2 deg", ', "")], "chain[0].angle_deviations", '["2 deg"', "4 entries"),
    "ball's side force": ("lin-chain-10", [("-0.6", "-0.95")], "chain[0].side_force_ratio", "-0.95", "-0.9325 to 1"),
    "negative gap": ("lin-chain-10", [("-0.6\n", '-0.6\ngap = "-1 um"\n')], "chain[0].gap", '"-1 um"', "0 mm to 1 m"),
    "gap after the last": ("lin-chain-10", [("= 0.6\n", '= 0.6\ngap = "1 um"\n')], "chain[9].gap", '"1 um"', "last"),
    "no title": ("lin-pair-a", [("title =", "source2 =")], "source2", '"Two', "did you mean source"),
    "not TOML": ("lin-pair-a", [("[grooves]", "[grooves")], "line 18, column 9", "[grooves", "TOML"),
}


@pytest.mark.parametrize("case", list(CASES))
def test_bad_input_is_one_line(tmp_path, case):
    name, changes, key, value, hint = CASES[case]
    path = tmp_path / "my.toml"
    path.write_text(changed(name, *changes), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        catalogue.any_scene(str(path))
    error, line = caught.value, str(caught.value)
    assert (error.file, error.key) == (str(path), key)
    assert error.value.startswith(value)
    assert hint in line
    assert line.startswith(str(path)[:40])
    for part in ("; allowed: ", "; advice: "):
        assert part in line
    assert "\n" not in line
    assert line.isprintable()
    assert "pydantic" not in line


def test_files_and_names_that_do_not_exist(tmp_path):
    with pytest.raises(InputError, match="did you mean lin-rotary-1"):
        catalogue.any_scene("lin-rotary1")
    with pytest.raises(SceneError, match="no such file"):
        catalogue.any_scene(str(tmp_path / "none.toml"))
    empty = tmp_path / "empty.toml"
    empty.write_text("", encoding="utf-8")
    with pytest.raises(SceneError, match="title: got nothing"):
        catalogue.any_scene(str(empty))


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


@pytest.mark.parametrize("kind", list(KINDS))
def test_schema_describes_every_key(kind):
    schema = tidy_schema(KINDS[kind].keys)
    nodes = [schema, *schema["$defs"].values()]
    for node in nodes:
        for name, entry in node.get("properties", {}).items():
            assert entry.get("description"), name
    json.dumps(schema, allow_nan=False)


# --- printing


def run(name, as_json):
    shown, printed = [], []
    code = run_friction(name, Choices(), as_json, lambda *parts: shown.extend(parts), printed.append)
    return code, shown, printed


@pytest.mark.parametrize("name", ["lin-rotary-2", "lin-pair-a", "lin-chain-10"])
def test_json_is_one_object_with_finite_numbers(name):
    code, shown, printed = run(name, True)
    assert (code, shown, len(printed)) == (0, [], 1)
    data = json.loads(json.dumps(printed[0], allow_nan=False))
    assert data["scene"] == name
    assert data["converged"] is True
    assert set(data["energy"]) == {"input_power_W", "loss_W", "balance_W", "balance_percent"}


@pytest.mark.parametrize("name", ["lin-rotary-2", "lin-pair-a"])
def test_table_shows_result_energy_and_assumptions(name):
    code, shown, printed = run(name, False)
    lines = [part for part in shown if isinstance(part, str)]
    assert (code, printed) == (0, [])
    for word in (name, "energy: input power", "assumed: ", "left out: lubricant", "solver: ", "law coulomb"):
        assert any(word in line for line in lines), word
    tables = [part for part in shown if not isinstance(part, str)]
    assert next(t.title for t in tables) in ("per contact", "per ball")
    assert all(t.row_count for t in tables)


def test_exit_code_of_a_scene_without_solution(tmp_path):
    path = tmp_path / "loose.toml"
    path.write_text(changed("lin-rotary-1", ('"100 N"', '"0 N"')), encoding="utf-8")
    code, shown, _ = run(str(path), False)
    assert code == 1
    assert "no contact" in shown[0]
    code, _, printed = run(str(path), True)
    assert code == 1
    assert printed[0]["converged"] is False
