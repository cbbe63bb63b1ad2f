"""The report's section on friction: every printed entry once, verdicts as the literature tests have them, figures."""

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.section_items import drawn, figures, tables
from tests.sources.entries import found

from rollbench.compare.cases.lin.evidence import rotary_linear
from rollbench.compare.cases.lin.pages import friction
from rollbench.compare.evidence import evidence
from rollbench.reports.content import Section

TABLES = ("lin-3.2", "lin-3.3", "lin-3.4", "lin-3.5", "lin-G")

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.fixture(scope="module")
def section() -> Section:
    return friction.make_section(STUDY, lambda _: None)


def test_right_values_stand_beside_what_comes_out_by_a_fault_alone():
    """67.58 % with right constants, a/R and its angle not cut off."""
    for key, right, faulty in (
        ("lin-3.2:force_increase_III", 87.8, 67.60),
        ("lin-G:a_over_R", 0.2186, 0.218),
        ("lin-G:eta", 6.262, 6.245),
    ):
        assert (found(key).value, found(key).as_printed) == pytest.approx((right, faulty), rel=5e-3), key
    as_printed = [f for f in evidence(STUDY, *TABLES) if f.printed.entry_class == "as-printed"]
    assert all(None not in (f.as_printed, f.value) for f in as_printed)


def test_an_increase_is_no_ratio_and_loads_are_in_balance():
    """185.2 % is the total over the baseline; Table 3.4 has the loads of Table 3.5, which 3D has too."""
    worst = found("lin-3.3:worst_ratio")
    assert (worst.value, worst.as_printed) == (pytest.approx(85.1, abs=0.05), pytest.approx(185.1, abs=0.05))
    for key in ("a_eps1_numerical", "a_eps2_numerical"):
        f = found(f"lin-3.4:{key}")
        assert (f.verdict, f.as_printed) == ("reproduced", None)
        assert f.value == pytest.approx(f.reference, rel=5e-3)


def test_misprinted_exponents_are_far_off():
    assert rotary_linear.ball_force_with_misprinted_exponents() < 0.1
    assert "0.017 N" in found("lin-3.5:a_force_analytic").remark


def test_balance_of_power_and_its_fault(section):
    rows = {(r["case_of_table_3_2"], r["friction_model"]): r for r in tables(section)["friction-balance"].rows}
    for (case, model), row in rows.items():
        limit = {"III": 0.2, "II": 1e-3}.get(case, 1e-8) if model == "as printed" else 1e-8
        assert abs(row["power_balance"]) < limit, (case, model)
        assert row["status"] == "exact"
    assert abs(rows["III", "as printed"]["power_balance"]) > 0.19


def test_sensitivity_to_the_load_assumption(section):
    rows = {(r["load_method"], r["ball_friction"]): r for r in tables(section)["friction-sensitivity"].rows}
    assert rows["balanced", 0.1]["loss_ratio_3_deg"] == pytest.approx(185.1, abs=0.05)
    assert rows["balanced", 0.0]["loss_ratio_3_deg"] == 100.0
    assert all(row["status"] == "converged" for row in rows.values())


def test_figures_have_data_and_can_be_drawn(section):
    drawn(figures(section), finite=0.8)


def test_curves_pass_through_the_printed_cases_and_differences_add_up(section):
    """As printed, the torque's curve meets Table 3.2 where the table's cases lie."""
    torque, force = friction.rotary_bearing_torque_figure(), figures(section)[4]
    panel = next(p for p in torque.panels if p.title == "friction torque")
    _, curve, dots = panel.series[:3]
    good = np.isfinite(curve.y)
    assert np.interp(dots.x, np.array(curve.x)[good], np.array(curve.y)[good]) == pytest.approx(dots.y, rel=0.02)
    for k in (0, 3):
        for ours, formula, off in zip(*(panel.series for panel in force.panels[k : k + 3]), strict=True):
            np.testing.assert_allclose(np.subtract(formula.y, ours.y), off.y, atol=1e-12)


def test_poles_stay_in_the_linear_range_and_only_the_mated_design_keeps_the_gap(section):
    """The mean force over the range of a friction line, the angle of appendix G, and designs (a) and (b) of 3.3.4.2."""
    shown = {figure.name: figure for figure in figures(section)}
    centre = {s.label: np.array(s.y) for s in shown["friction-spin-pole"].panels[1].series}
    assert np.abs(centre["force, conformity 0.52"] - centre["Lin's line, slope 1.38"]).max() < 0.07 * 0.69
    for panel in shown["friction-spin-pole-angle"].panels:
        *angles, limit = panel.series
        assert max(max(s.y) for s in angles) < min(limit.y)
    (model, formula), (mated, _) = (panel.series for panel in shown["friction-gap"].panels)
    assert model.y[60] < formula.y[60]
    assert model.y[-1] == 0.0 < formula.y[60]
    assert min(mated.y) == pytest.approx(1e6 * 0.1 * rotary_linear.LINEAR.ball_radius)
    curve = next(s for s in shown["friction-semi-axis"].panels[0].series if s.label == "conformity 0.52")
    assert curve.y[-1] == pytest.approx(found("lin-G:a_over_R").value)
