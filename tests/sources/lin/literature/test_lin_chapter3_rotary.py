"""Printed numbers of Lin (2019), section 3.2 and appendix G: each entry is data, each is a test."""

import numpy as np
import pytest
from tests.evidence_study import GROUP
from tests.sources.entries import check, found, keys, rows

from rollbench.compare.cases.lin.evidence import rotary_linear, source_cases
from rollbench.lowfi.friction.bearing import SIDES, inner_ring_torque, solve_ball_by_lin_method
from rollbench.lowfi.friction.contact import laws
from rollbench.lowfi.friction.screw.motion import lin_sigmoid_law

pytestmark = pytest.mark.xdist_group(GROUP)

SHARPNESS = source_cases.rotary_ball_scene("I", printed=True).sharpness
#: The source's law with exact integrals in place of its maps.
EXACT = lin_sigmoid_law(rotary_linear.ROTARY, SHARPNESS)


def as_source(displacement: float, law=EXACT):
    """The ball under the source's axial load at a displacement, by its law or another one."""
    return solve_ball_by_lin_method(rotary_linear.ROTARY, rotary_linear.AXIAL, displacement, law)


@pytest.mark.parametrize("key", keys("lin-3.1", "lin-3.2", "lin-G"))
def test_entry(key: str) -> None:
    check(key)


def test_forces_to_every_printed_digit() -> None:
    table = rows("lin-3.2")
    for case in rotary_linear.CASES:
        for side in SIDES:
            row = table[f"F_{side}_{case}"]
            value = rotary_linear.value_for_table_3_2(rotary_linear.rotary_ball_as_printed(case), f"F_{side}")
            assert f"{value:.4f}" == row.number_as_printed or (row.number_as_printed == "0" and value == 0.0)


def test_printed_sum_of_case_iii_is_a_misprint() -> None:
    """The four printed forces add to 470.94, near the 67.58 % of the text (67.60); 434.82 fits neither."""
    table = rows("lin-3.2")
    total = sum(table[f"F_{side}_III"].value for side in SIDES)
    first = table["F_sum_I"].value
    assert found("lin-3.2:F_sum_III").as_printed == pytest.approx(total, abs=2e-4)
    assert abs(table["F_sum_III"].value - total) > 100.0 * table["F_sum_III"].tolerance
    row = table["force_increase_III"]
    assert 100.0 * (total / first - 1.0) == pytest.approx(row.value, abs=row.tolerance)
    assert abs(100.0 * (table["F_sum_III"].value / first - 1.0) - row.value) > 10.0
    for case in ("I", "II"):
        assert sum(table[f"F_{s}_{case}"].value for s in SIDES) == pytest.approx(table[f"F_sum_{case}"].value, abs=2e-4)


@pytest.mark.parametrize("spacing", [None, 0.05, 0.1])
def test_step_of_the_maps_is_inferred_from_case_iii(spacing: float | None) -> None:
    """Exact integrals and other steps miss the losses of case III; 0.08 gives every digit of the case (above)."""
    table = rows("lin-3.2")
    s = as_source(rotary_linear.CASES["III"], lin_sigmoid_law(rotary_linear.ROTARY, SHARPNESS, spacing))
    off = [abs(rotary_linear.value_for_table_3_2(s, f"P_{side}") - table[f"P_{side}_III"].value) for side in SIDES]
    assert max(off) > 3.0 * 5e-5
    assert s.inner_ring_torque * 1e3 == pytest.approx(table["torque_III"].value, rel=1.1e-3)


def test_interpolated_maps_break_the_balance_of_power() -> None:
    """Fault of the source: with its maps torque 3.21 is 0.2 % more than the moment friction exerts on the ring."""
    both = rotary_linear.rotary_ball_as_printed("III"), as_source(rotary_linear.CASES["III"])
    maps, exact = (s.inner_ring_torque / inner_ring_torque(rotary_linear.ROTARY, s.load, s.motion) - 1.0 for s in both)
    assert maps == pytest.approx(1.92e-3, abs=1e-4)
    assert abs(exact) < 1e-9


RIGHT = [("I", 1, 281.1399, 2.31871), ("II", 1, 318.1037, 20.22452), ("III", 0, 528.0381, 35.52587)]


@pytest.mark.parametrize(("case", "rest", "force", "torque"), RIGHT)
def test_right_values_balance_power(case: str, rest: int, force: float, torque: float) -> None:
    """Exact Hertz constants change case II most: its ball has gone on from sliding to spin. At the printed loads the
    source's total is the least dissipation; only who spends it and the motion differ."""
    s, least = rotary_linear.solve_rotary_ball(case), rotary_linear.solve_rotary_ball(case, "as printed")
    for one in (s, least):
        assert one.motion.status == "exact"
        assert one.input_power == pytest.approx(one.motion.loss, rel=1e-10)
    assert as_source(rotary_linear.CASES[case]).motion.loss == pytest.approx(least.motion.loss, rel=1e-8)
    assert least.motion.sticking_contacts.sum() == rest
    assert s.load.force.sum() == pytest.approx(force, rel=1e-6)
    assert s.inner_ring_torque * 1e3 == pytest.approx(torque, rel=1e-5)


def test_transition_of_figure_3_7() -> None:
    """Forces nearly constant before four-point contact, torque then rises much faster than force."""
    start, end = rotary_linear.rotary_ball_as_printed("I"), rotary_linear.rotary_ball_as_printed("III")
    early = as_source(3e-6, rotary_linear.PRINTED_LAW)
    assert early.load.force.sum() == pytest.approx(start.load.force.sum(), rel=5e-3)
    assert np.sum(early.load.force > 0.0) == 2
    assert end.inner_ring_torque / start.inner_ring_torque > 5.0 * end.load.force.sum() / start.load.force.sum()


def test_appendix_g() -> None:
    """The printed a/R is cut off, not rounded, and conformity 0.52 is the widest of those plotted."""
    table, pressure = rows("lin-G"), 1e6 * rows("lin-G")["pressure"].value
    a_over_r = rotary_linear.contact_ellipse_ratios(0.52, pressure)[1]
    assert a_over_r == pytest.approx(0.2186, abs=5e-5)
    assert max(rotary_linear.contact_ellipse_ratios(c, pressure)[1] for c in (0.54, 0.56, 0.58, 0.60)) < a_over_r
    assert table["a_over_R"].value < a_over_r - table["a_over_R"].tolerance


def test_linear_slope_of_the_source() -> None:
    """1.38 lies between the secants to c/a = 0.5 and the slopes at 0 of all conformities; its error is 4 to 7 %."""
    row, pressure = rows("lin-G")["k_f"], 1e6 * rows("lin-G")["pressure"].value
    ratios = np.array([rotary_linear.contact_ellipse_ratios(c, pressure)[0] for c in (0.515, 0.52, 0.54, 0.56, 0.58, 0.60)])
    start = laws.linear_friction_force_factor(ratios)
    end = start - 0.25 * laws.cubic_friction_force_factor(ratios)
    assert row.low == pytest.approx(np.min(end), abs=1e-2)
    assert row.high == pytest.approx(np.max(start), abs=1e-2)
    assert np.min(end) < row.value < np.max(start)
    error = laws.error_of_linear_friction_force(ratios, row.value)
    assert (np.min(error), np.max(error)) == pytest.approx((0.0429, 0.0691), abs=1e-4)


def test_torques_of_two_garbled_lines_are_fixed_by_the_text_and_the_losses() -> None:
    """The scan has '2 4650 12 8760 33 7180' and '2.4050 12.8709 55.7100': what is filed fits the increases in the text,
    4.22 and 12.68 times, and the summed losses over the speed; neither line does."""
    table, speed = rows("lin-3.2"), 2.0 * np.pi * rows("lin-3.1")["omega_I"].value

    def fits(one: float, two: float, three: float) -> bool:
        torques = dict(zip(rotary_linear.CASES, (one, two, three), strict=True))
        near = [abs(1e-3 * torques[c] * speed - table[f"P_sum_{c}"].value) <= 5.1e-5 for c in torques]
        near += [abs(torques[c] / one - 1.0 - table[f"torque_increase_{c}"].value) <= 0.005 for c in ("II", "III")]
        return all(near)

    assert fits(*(table[f"torque_{c}"].value for c in rotary_linear.CASES))
    assert not fits(2.4650, 12.8760, 33.7180)
    assert not fits(2.4050, 12.8709, 55.7100)
