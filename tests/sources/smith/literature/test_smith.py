"""Smith (1994): every printed number by its class, and what the source's faults are worth."""

import numpy as np
import pytest
from tests.evidence_study import GROUP
from tests.sources.entries import check, found, keys, of_source

from rollbench.compare.cases.smith.evidence import axis, bearings
from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.printed import load_printed_table
from rollbench.lowfi.bearings import as_printed, tapered_roller
from rollbench.lowfi.bearings.angular_contact import dimensionless_hertz_parameters
from rollbench.lowfi.bearings.axis import solve_bearing_row_equilibrium

pytestmark = pytest.mark.xdist_group(GROUP)

TABLES = of_source("smith")
AS_PRINTED = [f"{name}:{row.key}" for name in TABLES for row in load_printed_table(name) if row.entry_class == "as-printed"]


@pytest.mark.parametrize("key", keys(*TABLES))
def test_entry(key: str) -> None:
    check(key)


@pytest.mark.parametrize("key", AS_PRINTED)
def test_as_printed_in_that_mode_only(key: str) -> None:
    """Comes out with the faults repeated; the right value stands beside it and is another one."""
    f = found(key)
    assert f.verdict == "only as printed", (f.as_printed, f.printed.number_as_printed)
    right = f.follows if f.value is None else f.value
    assert right not in (None, f.as_printed)
    assert f.printed.value is not None


# --- what the faults do


def test_table_2_1_is_right_to_four_parts_in_ten_thousand_but_for_one_entry() -> None:
    off = {}
    for i, difference in enumerate(bearings.DIFFERENCES[1:], 1):
        for key, value in zip(("delta", "a", "b"), dimensionless_hertz_parameters(difference), strict=True):
            printed = found(f"smith-table-2-1:{key}_{i}").printed.value
            off[key, i] = abs(printed / value - 1.0)
    assert off.pop(("b", 21)) == pytest.approx(0.0349, abs=1e-3)
    assert max(off.values()) < 3.5e-4


def test_everything_after_one_cell_of_figure_2_10_hangs_on_it() -> None:
    """With F(p)_o of the geometry the sheet would have given 58.30 deg and 0.000746 in."""
    faulty, right = bearings.ball_sheet(2040.0), bearings.ball_sheet(2040.0, None)
    assert right.curvature_differences[1] == pytest.approx(0.88444, abs=1e-5)
    assert np.degrees(faulty.contact_angle) == pytest.approx(58.27003, abs=2e-3)
    assert right.deflection / 25.4 == pytest.approx(0.000746, abs=1e-6)
    assert right.load_constant / faulty.load_constant == pytest.approx(0.970, abs=5e-3)


@pytest.mark.parametrize("difference", [0.70, 0.80, 0.90, 0.96])
def test_fits(difference: float) -> None:
    delta, a, b = dimensionless_hertz_parameters(difference)
    names = "approach", "major", "minor"
    approach, major, minor = (as_printed.hertz_parameter_by_smith_polynomial(difference, name) for name in names)
    assert (approach, major) == pytest.approx((delta, a), rel=0.02)
    assert minor / b == pytest.approx(1.415, abs=0.03)
    rows = bearings.DIFFERENCES[:-1]
    between = np.interp(difference, rows, [dimensionless_hertz_parameters(f)[0] for f in rows])
    assert between == pytest.approx(delta, rel=0.01)


def test_sheet_s_curvature_differences() -> None:
    assert as_printed.curvature_difference((1.0, 1.0, 1.0, 1.0)) == 0.0
    assert as_printed.curvature_difference((-0.5, 1.0, 1.0, 1.0)) == pytest.approx(0.6)


def test_rib_contact() -> None:
    """The area is pi a b, not a b; the printed ellipse and pressure carry 160 lbf, the roller's balance asks for 35."""
    e = ComputedEntryValues("smith-3")
    a, b, area, peak = (e.printed(f"rib_{k}") for k in ("a", "b", "A", "sigma"))
    assert area == pytest.approx(a * b, rel=0.01)
    assert np.pi * a * b == pytest.approx(0.0040, abs=5e-5)
    assert 2.0 / 3.0 * np.pi * a * b * peak == pytest.approx(160.0, abs=1.0)
    b = bearings.smith_tapered_bearing()
    rib = 2.0 * bearings.SHEET_LOAD / (b.rollers * np.sin(b.cup_angle)) * np.sin(b.roller_angle)
    assert rib / bearings.POUND == pytest.approx(35.0, abs=0.5)


def test_first_approximations() -> None:
    """2.24 in pounds and inches: 9 % off the right deflection at the load of the sheets."""
    right = bearings.ball_bearing_state(bearings.SHEET_LOAD)
    sine = float(np.sin(right.contact_angle))
    rough = 1.58e-5 * (2040.0 / (18 * sine)) ** 0.667 / (0.34375**0.333 * sine)
    assert rough * bearings.INCH / float(right.displacement) == pytest.approx(0.914, abs=5e-3)


def test_torque_of_a_tapered_row_is_a_band_beside_each_printed_one() -> None:
    """From 3.3 to 14 in-lb a row, by film, steel and an assumed friction of the rib; it grows with thrust and friction."""
    rows = axis.tapered_row_torques()
    assert [printed for _, _, printed, _ in rows] == [10.67, 14.0, 1.5, 13.5, 13.5, 1.5, 13.5, 14.5, 22.0, 6.0]
    bands = [band for _, _, _, band in sorted(rows, key=lambda x: x[1])]
    assert bands == sorted(bands)
    assert (bands[0][0], bands[-1][1]) == pytest.approx((3.28, 14.13), abs=0.01)
    for thrust in (500.0, 1500.0):
        low, high = bearings.torque_of_tapered_row_in_lbf(thrust * bearings.POUND)
        b = bearings.smith_tapered_bearing()
        cone, _ = tapered_roller.roller_speed_ratios(b)
        rib = 2.0 * np.sin(b.roller_angle) * thrust * bearings.POUND / np.sin(b.cup_angle)
        slope = (high - low) * bearings.INCH_POUND / (0.15 - 0.03)
        assert slope == pytest.approx(cone * rib * 0.1 * b.diameter, rel=1e-6), "the rib's force at a tenth of the diameter"
        assert low > 0.0


def test_source_s_sharing_balances_too_much() -> None:
    """After the stretch its loads balance the whole tension by two slips; the change under the load is twice too large."""
    for kind in axis.KINDS:
        for end in ("left", "right"):
            s, states = np.array(bearings.DIRECTIONS[kind][end]), ("stretch", "applied")
            preload = (1020.0, 1020.0, 2040.0) if end == "left" else (2040.0, 1020.0, 1020.0)
            pre = preload if kind == "ball" else (1500.0, 1500.0)
            after, loaded = (s @ axis.row_loads_by_smith_rule_lbf(kind, end, state, pre) for state in states)
            assert after == pytest.approx(1290.0)
            sign = -1.0 if end == "left" else 1.0  # a load towards the left relieves the left end of tension
            assert loaded - after == pytest.approx(sign * 1000.0)
            after, loaded = (s @ axis.bearing_set_state(kind, end, state).row_thrusts for state in states)
            assert after == pytest.approx(axis.screw_tension(), rel=1e-10)
            assert (loaded - after) / bearings.POUND == pytest.approx(sign * 500.0, rel=1e-9)


def test_right_stiffness_of_the_axis() -> None:
    """With the printed stiffness of the bearings, and with the computed one."""
    for kind, follows, ours in (("ball", 1.915e6, 1.931e6), ("taper", 1.846e6, 1.938e6)):
        f = found(f"smith-4.2:total_{kind}")
        assert (f.follows, f.value) == pytest.approx((follows, ours), rel=3e-4)
        assert f.as_printed < 0.8 * min(follows, ours)


def test_comparison_of_contact_areas_reverses() -> None:
    taper_area, ball_area = (found(f"smith-3:area_{kind}") for kind in ("taper", "ball"))
    assert taper_area.as_printed < 0.2 * ball_area.as_printed
    assert (taper_area.value, ball_area.value) == pytest.approx((0.0795, 0.0260), abs=5e-4)


def test_roundings_of_figure_3_6_do_not_explain_its_deflection() -> None:
    low, high = bearings.taper_deflection_range()
    assert 0.0004660 < low < bearings.taper_sheet_deflection() < high


def test_unseating_takes_three_times_the_printed_load() -> None:
    """The outer row of the set is just loose there, and not before."""
    limit = axis.carriage_load_that_unloads_row(axis.REDUCED)
    assert limit / bearings.POUND == pytest.approx(645.5, abs=0.5)
    rows = bearings.bearing_rows_at_end("taper", "left", axis.REDUCED)
    thrusts = (axis.screw_tension() + 0.5 * limit * share for share in (0.999, 1.001))
    before, after = (solve_bearing_row_equilibrium(rows, thrust).row_thrusts[0] for thrust in thrusts)
    assert before > 0.0 == after


def test_a_sum_of_printed_numbers_is_no_value_of_a_model() -> None:
    """2.08 in-lb a row, and 6.24 for three, follow from 0.33 + 1.75 as printed; computed are 1.06 and 3.18 in-lb."""
    for key, follows, ours in (
        ("smith-2.3:M", 2.08, 1.0616),
        ("smith-4.3:bearings_ball", 6.24, 3.1849),
        ("smith-4.3:bearings_taper", 21.34, None),
        ("smith-4.3:constant_ball", 42.48, None),
        ("smith-4.3:constant_taper", 72.68, None),
        ("smith-4.3:start_ball", 51.65, None),
        ("smith-4.3:start_taper", 81.85, None),
        ("smith-4.2:package_taper", 7.20e6, 11.477e6),
    ):
        f = found(key)
        assert f.verdict == "identity"
        assert f.follows == pytest.approx(follows, rel=1e-9)
        assert f.value == (ours and pytest.approx(ours, rel=1e-4))


def test_assumptions_matter_as_said() -> None:
    """Depth of the rings: 2.5 to 10 mm is 16 % of the tapered bearing's stiffness; nothing makes it 3.60e6."""
    soft, stiff = (bearings.taper_stiffness(1500.0, depth) for depth in reversed(bearings.DEPTHS))
    assert stiff / soft == pytest.approx(1.163, abs=5e-3)
    assert soft > 1.4 * 3.60e6


def test_stiffness_has_its_power_of_ten_in_its_value() -> None:
    """A value in its unit is the quantity: what is printed in 10^6 lbf/in is some 1e6 of them."""
    stiff = [row for name in TABLES for row in load_printed_table(name) if row.unit == "lbf/in"]
    assert len(stiff) > 22
    assert all(1e5 < row.value < 2e7 for row in stiff)
    assert found("smith-5:S_taper").printed.value == 1.355e6


def test_a_split_cell_is_no_fault_of_the_source() -> None:
    """0.015646 in are 0.397408 mm: the scan cuts the cell in two."""
    assert found("smith-2.1:P_d_mm").verdict == "identity"
