"""Where the printed errors of Lin 2.4.1 come from: two explanations, and what each misses."""

from collections import defaultdict

import numpy as np
import pytest

from rollbench.compare.cases.lin.pages import reconstruction
from rollbench.compare.cases.lin.reconstruction import explanations
from rollbench.compare.evidence import evidence
from rollbench.compare.models.study import SceneResultCache
from rollbench.hifi.contact.block import JOBS

pytestmark = pytest.mark.xdist_group("reconstruction")


@pytest.fixture(scope="module")
def study():
    return SceneResultCache()


@pytest.fixture(scope="module")
def found(study):
    """All explanations with what they give."""
    return study.compute_once(explanations.evaluate_explanations)


def test_no_explanation_has_all_that_is_printed(found):
    """One has the ratio and not the fall of the largest error, the penalties have more of the fall and too small an RMS."""
    base, near, *soft = found
    assert (base.low_order_ratio, base.ratio_in_3d) == pytest.approx((1.308, 1.406), abs=1e-3)
    assert near.errors_percent == pytest.approx((5.36, 2.51, 5.32, 2.51), abs=0.02)
    falls = [reconstruction.error_fall_and_rise_to_case_2(c.errors_percent)[0] for c in (near, *soft)]
    printed_fall = reconstruction.error_fall_and_rise_to_case_2(explanations.printed_errors_percent())[0]
    assert falls == sorted(falls)  # the softer, the more of it
    assert falls[0] < 0.1 * printed_fall
    assert 0.5 * printed_fall < falls[-1] < printed_fall
    ratios = [c.ratio_in_3d for c in soft]
    assert ratios == sorted(ratios, reverse=True)
    assert ratios[-1] < explanations.printed_load_ratio() < ratios[0]
    near_max = min(soft, key=lambda c: abs(c.deviations_from_print[2]))
    assert (near_max.deviations_from_print[[3, 5]] < -0.3).all()  # RMS of both cases


def test_no_error_against_ansys_comes_out(study):
    found = {e.printed.key: e for e in evidence(study, "lin-2.4.1")}
    assert {found[key].verdict for key in explanations.ERRORS} == {"not identifiable"}
    assert all("explanations of the printed errors give " in found[key].remark for key in explanations.ERRORS)


def test_a_little_penalty_adds_what_hertz_pressure_makes_it():
    """It adds half of pressure squared over the penalty to the complementary energy, integrated over the ellipse: that goes
    as F^(4/3), and its slope, by which the approach grows, is 3/4 of the mean pressure over the penalty."""
    penalty = explanations.SOFT[0]
    (run, _) = explanations.runs_in_3d(penalty)
    exact, force = JOBS["B"].hertz_solution, float(run.load[:, 0].mean())
    size = np.cbrt(force / exact.normal_force) ** 2  # of the ellipse's area
    mean = force / (np.pi * exact.semi_x * exact.semi_y * size)
    share = 0.75 * mean / run.settings["penalty_N_m3"] / (exact.approach * size)
    assert explanations.penalty_over_hertz_approach(penalty) == pytest.approx(share, rel=0.1)


def test_the_page_answers_first_and_says_what_a_finer_mesh_does(study, found):
    text = reconstruction.origin_of_error_paragraph(found)
    assert text.startswith("Where does 5.38 % come from? It is not identified.")
    assert "The next mesh level changes" in reconstruction.contact_penalty_paragraph(study)


def test_the_shape_of_case_3_is_a_rise_on_the_inner_flanks_of_the_last_balls():
    change = np.zeros((32, 4))
    change[31, 2] = 5.0
    assert reconstruction.rises_most_at_last_balls(change)
    for other in (-change, change[::-1], np.eye(32, 4, k=-28) * 6.0):
        assert not reconstruction.rises_most_at_last_balls(other)


def test_other_statements(study):
    verdicts = defaultdict(list)
    for row in reconstruction.model_comparison_statements_table(study).rows:
        verdicts[row["thesis_place"]].append(row["conclusion"])
    assert {verdict.count("held") for verdict in verdicts["2.4.1.3, case 3"]} == {3}
    assert "may be its mesh" in verdicts["Table 3.5 (a)"][0]
    assert all("load state" in verdicts[f"Table 3.7 ({case})"][0] for case in "ab")


def test_the_tables_state_each_explanation_and_what_it_misses(found):
    given = {row["possible_explanation"]: row for row in reconstruction.ratios_and_errors_by_explanation_table(found).rows}
    missed = {row["possible_explanation"]: row for row in reconstruction.deviations_from_print_table(found).rows}
    assert list(given) == ["printed", *missed]
    for name, row in missed.items():
        for key in (("largest", "1"), ("RMS", "2")):
            error, printed = given[name]["error_in_case", *key], given["printed"]["error_in_case", *key]
            assert row["error_in_case_off", *key] == pytest.approx(error - printed)
        ratio = given[name]["load_ratio_by", "3D model"]
        assert row["load_ratio_by_off", "3D model"] == pytest.approx(100.0 * (ratio / 1.34 - 1.0))
