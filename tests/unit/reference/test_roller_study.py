"""Tapered rollers in 3D with low-order laws: what is pressed, what is said of it, shipped runs, refusals."""

from dataclasses import asdict, replace
from math import sin

import pytest

from rollbench.compare.reference.store import run_text_with_checksum, shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.studies import roller
from rollbench.lowfi.rollers import TaperedRow, circular_crown_profile, tapered_bearing_of_row

TAPER = "smith-axis-taper"


@pytest.fixture(scope="module")
def kind():
    (only,) = roller.roller_kinds_with_largest_load(catalogue.shipped_scene(TAPER))
    return only


@pytest.fixture(scope="module")
def shipped(kind):
    runs = [roller.stored_roller_run(kind, level, (shipped_store(),)) for level in roller.LEVELS]
    assert None not in runs, "shipped runs are of another roller, or damaged"
    return runs


def test_equal_rollers_are_pressed_once_with_the_largest_load(kind):
    assert len(kind.bearing_names) == 4
    assert kind.largest_load == pytest.approx(1258.0, abs=1.0)


def test_low_order_laws_are_those_of_the_statics(kind):
    """One roller is a row of rollers under thrust over their number, at the cup's angle."""
    bearing, load = tapered_bearing_of_row(kind.roller_row), kind.largest_load
    tilt = sin(bearing.cup_angle)
    thrust = load * bearing.rollers * tilt
    low, up, down = (roller.approach_and_stiffness_by_laws(kind.roller_row, load * s) for s in (1.0, 1.001, 0.999))
    assert low["low_order"][0] == pytest.approx(TaperedRow(bearing).deflection(thrust) * tilt, rel=1e-9)
    for law, (_, stiffness) in low.items():
        assert stiffness == pytest.approx(0.002 * load / (up[law][0] - down[law][0]), rel=1e-5)
    crowned = replace(kind.roller_row, crown=2.0)
    sliced = TaperedRow(bearing, crowned.slices, circular_crown_profile(2.0)).deflection(thrust) * tilt
    assert roller.approach_and_stiffness_by_laws(crowned, load)["low_order"][0] == pytest.approx(sliced, rel=1e-9)


def test_shipped_runs_meet_line_contact_and_settle(kind, shipped):
    """Within 1 % in the middle on every level; approach and stiffness settle, and their bars cover level 1."""
    for run in shipped:
        hertz = roller.line_contact_pressures(kind.roller_row, run.middle_line_load[0])
        assert run.middle_pressure == pytest.approx(hertz, rel=0.01)
        assert run.imbalance < 1e-4
    rows = {x.name: x.as_json() for x in roller.roller_quantities(kind, shipped)}
    for name in ("approach", "stiffness"):
        row = rows[f"{name} under {kind.largest_load:.4g} N"]
        assert row["uncertainty"] < 0.01 * row["level 3"]
        assert row["level 1"] == pytest.approx(row["level 3"], rel=0.01)
        assert abs(row["low_order_error_percent"]) < 5.0


def test_damaged_runs_are_not_used(kind, shipped, tmp_path):
    text = run_text_with_checksum(asdict(shipped[0]))
    path = tmp_path / roller.roller_run_file_name(kind, 1)
    path.write_text(text)
    assert roller.stored_roller_run(kind, 1, (tmp_path,)) == shipped[0]
    path.write_text(text.replace('"level":1', '"level":2'))
    assert roller.stored_roller_run(kind, 1, (tmp_path,)) is None


@pytest.mark.parametrize(
    ("arguments", "word"), [(["two-balls"], "separate runs"), (["--spread"], "spread"), (["--levels", "4"], "1 to 3")]
)
def test_what_rollers_do_not_know_is_refused(arguments, word, command):
    assert word in command.refused("mesh-study", TAPER, *arguments)
