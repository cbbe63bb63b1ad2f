"""Scenes of ball screws and bearings in pairs: the library's numbers, bad input in one line, table, JSON, exit code."""

from dataclasses import replace

import numpy as np
import pytest
from tests.shipped_texts import changed

from rollbench.compare.cases.lin.evidence import source_cases
from rollbench.compare.commands.friction import solve_and_report_friction
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.friction import whole
from rollbench.compare.studies.friction.kinds import solve_friction_of_single_parts
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.screw.run import SHIFTED, Pair, solve_pair_of_screw_balls, summarise_screw_run
from rollbench.lowfi.friction.screw.travel import simulate

THETA = {"a": 2.0, "b": 3.0}
#: Few steps of the run, up to the first contacts.
SHORT = (("steps = 200", "steps = 40"), ('duration = "2 s"', 'duration = "300 ms"'))
FEW = (
    (', "4 deg", "6 deg", "8 deg", "10 deg", "12 deg", "14 deg",\n', ",\n"),
    ('"18 deg", "20 deg", "22 deg", "24 deg", "26 deg", "28 deg", "30 deg"', '"18 deg"'),
)


def loaded(name, *changes):
    return scene_file.parse_scene(changed(name, *changes), f"{name}.toml")


def close(ours, theirs):
    """Whether two records of numbers agree up to the rounding of units."""
    assert ours.__dict__.keys() >= set(theirs.__dataclass_fields__)
    for name in theirs.__dataclass_fields__:
        a, b = getattr(ours, name), getattr(theirs, name)
        if hasattr(b, "__dataclass_fields__"):
            close(a, b)
        elif isinstance(b, str | bool | type(None)):
            assert a == b, name
        elif name == "rows":
            assert [r.contacts for r in a] == [r.contacts for r in b]
            assert [r.place for r in a] == pytest.approx([r.place for r in b], rel=1e-14)
        else:
            assert np.asarray(a) == pytest.approx(np.asarray(b), rel=1e-14), name


def test_oversize_is_the_opposite_of_a_clearance_and_rows_face_to_face_are_turned_round():
    rows = loaded("lin-bearing-pairs", ('back to back"\n', 'face to face"\n')).double_row.rows
    assert [r.contacts for r in rows] == [bearing.DIAGONAL, bearing.OTHER]
    preload = loaded("lin-bearing-pairs", ('"0 um"', '"2 um"'))
    assert (preload.four_point.clearance, preload.double_row.clearance) == (-2e-6, 0.0)
    tight, free = (
        bearing.solve_bearing(case, 0.1).load.force.sum()
        for case in (preload.four_point, source_cases.four_point_bearing())
    )
    assert tight > 1.01 * free


@pytest.mark.parametrize("case", list(THETA))
@pytest.mark.parametrize("reading", [source_cases.screw_pair_as_printed, source_cases.screw_pair_with_inferred_oversize])
def test_pair_scenes_are_the_library_s(case, reading):
    scene = catalogue.scene_of_any_kind(
        f"lin-screw-pair-{case}{'-inferred' if reading is source_cases.screw_pair_with_inferred_oversize else ''}"
    )
    theirs = reading(np.radians(THETA[case]))
    close(scene.pair, theirs)
    answer, r = solve_friction_of_single_parts(scene), solve_pair_of_screw_balls(theirs)
    found = answer.data
    assert answer.converged
    percent = found["friction_increase_percent"], found["ball_to_ball_percent"]
    assert percent == pytest.approx((100.0 * r.friction_increase, 100.0 * r.ball_loss_over_groove_loss), rel=1e-8)
    numbers = found["pairs"][0]["force_N"], found["energy"]["loss_W"]
    assert numbers == pytest.approx((r.force, r.touching.motion.loss), rel=1e-8)
    assert abs(found["energy"]["balance_percent"]) < 1e-8
    assert [b["state"] for b in found["balls"]] == ["apart", "apart", "touching", "touching"]
    loads = [list(b["load_N"].values()) for b in found["balls"]]
    assert loads == [
        pytest.approx(row, rel=1e-7, abs=1e-9) for s in (r.apart, r.touching) for row in s.loads_with_friction.force
    ]


def test_pair_takes_pattern_direction_hand_and_hertz():
    loads = (("[1, 1, 0, 0]", "[1, -1, 0, 0.0]"), ('"axial"', '"radial"'), ('"50 N"', '"0.1 kN"'), ('"1 rps"', '"60 rpm"'))
    rest = (
        ('hand = "right"', 'hand = "left"'),
        ('"ball"', '"ball and screw"'),
        ('oversize = "0 um"', 'oversize = "-1 um"'),
    )
    hertz = "[load]", '[ingredients]\nhertz = "as printed"\n\n[load]'
    scene = loaded("lin-screw-pair-a", *loads, hertz, *rest)
    groove = replace(source_cases.screw_pair_as_printed(0.0).groove, lead=-20e-3, hertz="as printed")
    theta = (0.0, np.radians(2.0))
    close(scene.pair, Pair(groove, theta, (SHIFTED, SHIFTED), -1e-6, "r", (100.0,), "ball and screw"))


def test_pair_of_a_still_screw_spends_nothing():
    answer = solve_friction_of_single_parts(loaded("lin-screw-pair-a-inferred", ('"1 rps"', '"0 rps"')))
    assert answer.converged
    nothing = pytest.approx(0.0, abs=1e-15)
    assert answer.data["energy"] == {"input_power_W": 0.0, "loss_W": nothing, "balance_W": nothing, "balance_percent": None}
    assert answer.data["friction_increase_percent"] is None


def test_run_scene_is_the_library_s():
    close(catalogue.scene_of_any_kind("lin-screw-run").run, source_cases.simulation_inputs_of_section_3_4_4())
    answer = solve_friction_of_single_parts(loaded("lin-screw-run", *SHORT))
    r = simulate(source_cases.simulation_inputs_of_section_3_4_4(), 0.3, 40)
    s, found = summarise_screw_run(r), answer.data["summary"]
    assert answer.converged
    assert found["largest_ball_to_groove_percent"] == pytest.approx(100.0 * s.largest_ball_to_groove_ratio, rel=1e-7)
    assert found["largest_at_deg"] == pytest.approx(s.nut_angle_of_largest_ratio)
    assert found["contact_ends_deg"] is None, "still in contact at the end"
    begins = np.degrees(r.nut_angle)[np.flatnonzero(r.presses_on_next.any(axis=1))[0]]
    assert found["contact_begins_deg"] == pytest.approx(begins)
    parts = found["mean_groove_torque_Nmm"], found["mean_ball_torque_Nmm"]
    assert sum(parts) == pytest.approx(found["mean_torque_Nmm"], rel=1e-12)
    assert found["mean_torque_Nmm"] == pytest.approx(1e3 * r.torque_statistics["mean"], rel=1e-8)
    assert (found["order_kept"], found["smallest_gap_um"] >= 0.0) == (True, True)
    assert abs(answer.data["energy"]["balance_percent"]) < 1e-8
    series = answer.data["series"]
    assert {len(row) for row in series.values()} == {r.time.size}
    assert answer.data["run"]["torque"]["mean_Nmm"] == found["mean_torque_Nmm"]
    assert answer.data["run"]["over_angle"]["groove_Nmm"] == series["groove_torque_Nmm"]
    assert series["groove_torque_Nmm"] == pytest.approx(1e3 * r.groove_torque, rel=1e-8)
    assert series["contacts"] == r.presses_on_next.sum(axis=1).tolist()


def test_a_run_takes_the_keys_of_a_whole_screw_in_time():
    """An angle in place of a duration, and steps chosen by a goal; four steps have not converged."""
    chosen = loaded("lin-screw-run", ('duration = "2 s"\nsteps = 200', 'angle = "60 deg"\ngoal = 0.02'))
    assert chosen.run.duration == pytest.approx(1.0 / 6.0)
    found = solve_friction_of_single_parts(chosen)
    error = found.data["run"]["step_error"]
    assert (found.converged, error["small"], error["goal_percent"]) == (True, True, 2.0)
    assert found.data["steps"] == error["steps"][-1]
    found = solve_friction_of_single_parts(loaded("lin-screw-run", ("steps = 200", "steps = 4")))
    assert not found.converged
    assert found.data["status"].startswith("not converged in the time step: the error of 4 steps is some ")


def test_run_without_contact_says_nothing_of_where_and_without_friction_there_are_no_ratios():
    found = solve_friction_of_single_parts(loaded("lin-screw-run", *SHORT, ('"3 deg"', '"0 deg"'))).data["summary"]
    assert found["largest_ball_to_groove_percent"] == 0.0
    assert [found[k] for k in ("largest_at_deg", "contact_begins_deg", "contact_ends_deg")] == [None] * 3
    run = solve_friction_of_single_parts(loaded("lin-screw-run", *SHORT, ("coefficient = 0.1", "coefficient = 0")))
    energy, summary = run.data["energy"], run.data["summary"]
    assert (run.converged, energy["loss_W"], energy["largest_step_balance_percent"]) == (True, 0.0, None)
    assert [summary[k] for k in ("largest_ball_to_groove_percent", "groove_variation_percent")] == [None] * 2
    assert set(run.data["series"]["ball_to_groove_percent"]) == {None}
    bearings = solve_friction_of_single_parts(loaded("lin-bearing-pairs", *FEW, ("coefficient = 0.1", "coefficient = 0")))
    assert (bearings.converged, bearings.data["four_over_double"]) == (True, [None] * 4)
    assert bearings.data["four_point"]["largest_over_smallest"] is None


@pytest.mark.parametrize("angle", [0.3, 0.9])
def test_one_ball_holds_a_tilting_ring_only_against_a_force_through_its_centre(angle):
    ball = source_cases.four_point_bearing(count=1)
    assert "ry" in bearing.describe_unresisted_motion(ball, angle)
    assert bearing.describe_unresisted_motion(replace(ball, tilt=False), angle) == ""
    through = -ball.groove.pitch_radius / np.tan(angle)
    assert bearing.describe_unresisted_motion(replace(ball, arm=through), angle) == ""
    assert "ry" in bearing.describe_unresisted_motion(replace(ball, arm=1.001 * through), angle)
    assert (
        bearing.describe_unresisted_motion(source_cases.four_point_bearing(), angle)
        == bearing.describe_unresisted_motion(source_cases.double_row_bearing(), angle)
        == ""
    )


@pytest.mark.parametrize("tilt", [True, False])
def test_bearing_scene_is_the_library_s(tilt):
    scene = loaded("lin-bearing-pairs", *FEW, ("tilt = true", f"tilt = {str(tilt).lower()}"))
    close(scene.four_point, source_cases.four_point_bearing(tilt=tilt))
    close(scene.double_row, source_cases.double_row_bearing(tilt=tilt))
    assert np.degrees(scene.angle) == pytest.approx([0.0, 2.0, 16.0, 18.0])
    answer = solve_friction_of_single_parts(scene)
    found = answer.data
    assert answer.converged
    curves = [
        bearing.bearing_torque_over_force_angles(make(tilt=tilt), scene.angle)
        for make in (source_cases.four_point_bearing, source_cases.double_row_bearing)
    ]
    for name, curve in zip(("four_point", "double_row"), curves, strict=True):
        assert found[name]["friction_torque_Nmm"] == pytest.approx(1e3 * curve.torque, rel=1e-7)
        assert found[name]["balls_beyond_two_contacts"] == curve.balls_beyond_two_contacts.tolist()
        assert found[name]["largest_over_smallest"] == pytest.approx(curve.largest_over_smallest_torque, rel=1e-7)
    assert found["four_over_double"] == pytest.approx(curves[0].torque / curves[1].torque, rel=1e-7)
    assert abs(found["energy"]["balance_percent"]) < 1e-8


# --- printing


def printed(tmp_path, name, changes):
    """What the command prints of a changed scene."""
    path = tmp_path / f"{name}.toml"
    path.write_text(changed(name, *changes), encoding="utf-8")
    return solve_and_report_friction(str(path), whole.FrictionChoices(), details=True)


SHOWN = [("lin-rotary-2", (), "per contact"), ("lin-pair-a", (), "per ball"), ("lin-chain-10", (), "per ball")]
SHOWN += [("lin-screw-pair-a", (), None), ("lin-screw-run", SHORT, None), ("lin-bearing-pairs", FEW, None)]


def test_exit_codes_of_a_ball_without_contact_and_of_a_bearing_that_one_ball_cannot_hold(tmp_path):
    loose = printed(tmp_path, "lin-rotary-1", [('"100 N"', '"0 N"')])
    one = printed(tmp_path, "lin-bearing-pairs", [*FEW, ("count = 9", "count = 1")])
    assert [(x.exit_code, x.data["converged"]) for x in (loose, one)] == [(1, False)] * 2
    assert "no contact" in loose.texts_and_tables[0]
    status = one.data["status"]
    assert status.startswith("no equilibrium: four-point bearing, load at 0 deg: rigid motion of the inner ring")
    assert "uz, ry" in status
    assert "four_point" not in one.data, "no table of torques out of balance"
