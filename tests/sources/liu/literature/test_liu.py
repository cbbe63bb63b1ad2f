"""Liu et al. (2025): every printed number by its class, the one calibration, and which numbers no draw gives."""

from dataclasses import replace

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import check, keys, of_source

from rollbench.compare.cases.liu import evidence as liu
from rollbench.compare.evidence import PrintedEntryComparison, evidence
from rollbench.compare.printed import load_printed_table, printed_value
from rollbench.lowfi.as_source.liu import chain
from rollbench.lowfi.as_source.liu.ensemble import percentile_rank, solve_ensemble

pytestmark = pytest.mark.xdist_group(GROUP)

TABLES = of_source("liu")
#: Random numbers of sections 4.3 and 4.4.
RANDOM = [row for name in ("liu-4.3", "liu-4.4") for row in load_printed_table(name) if row.value is not None]
RANDOM = [row for row in RANDOM if row.key != "K_0_3000" and row.kind == "number"]


def by_key(key: str) -> PrintedEntryComparison:
    return next(f for f in evidence(STUDY, *TABLES) if f.printed.key == key)


@pytest.mark.parametrize("key", keys(*TABLES))
def test_entry(key: str) -> None:
    check(key)


# --- random numbers


def place(row):
    half = 0.0 if "loaded" in row.key else row.tolerance
    return percentile_rank(liu.random_screw_values_for_printed_number(row.key), row.value, half)


@pytest.mark.parametrize("row", RANDOM, ids=lambda r: r.key)
def test_open_where_no_likely_draw_gives_it_or_all_would(row) -> None:
    """Class band: at least one screw in two hundred is as far out, and the draws lie within a quarter of their middle.

    Class open: fewer, or the draws spread wider; the words say how many.
    """
    p = place(row)
    low, high = np.quantile(liu.random_screw_values_for_printed_number(row.key), [0.005, 0.995])
    narrow = high - low <= 0.25 * (high + low)
    assert (row.entry_class == "band") == (p.tail_probability >= liu.UNLIKELY and narrow), (row.key, p, low, high)
    words = by_key(row.key).remark
    assert f"percentile {p.percent:.1f} ± {p.standard_error:.1f}" in words
    assert f"probability {p.tail_probability:.4f}" in words


@pytest.mark.parametrize("row", [r for r in RANDOM if r.entry_class == "band"], ids=lambda r: r.key)
def test_bands_are_those_of_the_ensemble(row) -> None:
    """The range in the data holds the central 99 % and no more than the central 99.98 % and a twentieth of its width."""
    values = liu.random_screw_values_for_printed_number(row.key)
    low, high = np.quantile(values, [0.005, 0.995])
    assert row.low <= low + 0.02 * (high - low)
    assert row.high >= high - 0.02 * (high - low)
    slack = max(0.12 * (high - low), 0.2 if row.unit == "N" else 0.0)
    whole = max(slack, 2.0) if "loaded" in row.key else slack
    assert row.low >= low - whole
    assert row.high <= high + whole


def test_other_draws_give_the_same_percentiles() -> None:
    """Another seed: every percentile within four standard errors of both samples. All random screws converge."""
    other = solve_ensemble(liu.calibrated_model(), 2e-6, [500.0, 1000.0, 5000.0], 5000, seed=77)
    for load in (500.0, 1000.0, 5000.0):
        row = next(r for r in RANDOM if r.key == f"max_2_{load:.0f}")
        a, b = place(row), percentile_rank(other.values_at("largest", load), row.value, row.tolerance)
        assert abs(a.percent - b.percent) < 4.0 * np.hypot(a.standard_error, b.standard_error)
    for half_range in liu.LOADS:
        ensemble = liu.solve_screws_with_random_errors(half_range)
        assert ensemble.failed == 0
        assert ensemble.kept.shape == (liu.MEMBERS, len(liu.LOADS[half_range]), 6)


def test_counts_at_1000_newtons_contradict_those_at_500() -> None:
    """Given about 42 loaded balls at 500 N and +-3 um, no random screw has as few as 43 at 1000 N. Medians of the
    counts at 1000 N add up to all balls, and the printed ones are too many."""
    assert " 0 have at most 43 at 1000 N" in by_key("unloaded_3_1000").remark
    assert all(words in liu.screws_with_printed_counts_in_words(3, 42, 78) for words in ("1707 screws", " 1707 have"))
    for key, half_range in (("unloaded_2_1000", 2), ("unloaded_3_1000", 3)):
        loaded = float(np.median(liu.random_screw_values(half_range, "loaded", 1000.0)))
        assert by_key(key).value == 78 - loaded < by_key(key).printed.value


# --- the calibration


def test_what_the_calibration_implies() -> None:
    model = liu.calibrated_model()
    assert model.compliance == pytest.approx(3.874e-12, rel=1e-3)
    assert 1e6 * liu.implied_series_cross_section(26.0) == pytest.approx(387.4, abs=0.1)
    printed = printed_value("liu-4.1", "ratio")
    assert chain.last_to_first_load_ratio(model, liu.calibration_load()) == pytest.approx(printed, abs=1e-5)
    exactly = chain.calibrate_compliance(model, printed, liu.calibration_load())
    assert exactly.compliance == pytest.approx(model.compliance, rel=1e-4)
    assert by_key("ratio").verdict == "input"


def test_only_the_implicit_angle_gives_all_ratios() -> None:
    """Each reading calibrated alike: the printed ratio of Mei's model and at -2 um to half a unit of the last digit."""
    hits = {}
    for law in ("constant", "implicit", "exact"):
        model = liu.calibrated_model(law)
        q = chain.solve_ball_screw(model, liu.ball_errors_with_faulty_ball_33(-2e-6), 1000.0).load
        mei = chain.last_to_first_load_ratio(replace(model, law="constant"), 5000.0)
        hits[law] = abs(q[-1] / q[0] - 0.919) <= 5e-4, abs(mei - 0.87) <= 1e-3
    assert hits == {"constant": (False, False), "implicit": (True, True), "exact": (False, False)}


def test_two_digits_exchanged() -> None:
    q = by_key("plus_Q33_5000").value
    assert q == pytest.approx(142.55, rel=4e-3)
    assert abs(q / 124.55 - 1.0) > 0.14
    assert liu.error_of_ball_33_for_load(124.55) == pytest.approx(1.36, abs=0.01)


def test_a_step_of_load_gives_all_stiffnesses_and_the_tangent_does_not() -> None:
    """(22) is a difference over a step that is not printed: what only it decides is not identifiable."""
    rows = [row for row in load_printed_table("liu-4.4") if row.key.startswith("K_")]
    out = [row.key for row in rows if not liu.printed_stiffness_agrees(row, 0.0)]
    assert (len(rows), len(out)) == (19, 8)
    assert all(liu.printed_stiffness_agrees(row, 0.12) for row in rows)
    assert {by_key(key).verdict for key in out if key != "K_0_3000"} == {"not identifiable"}


def test_no_contact_stiffness_mends_the_offset() -> None:
    """K 3.4 % larger gives the printed stiffness without errors, and takes Q33 at -2 um out of its per cent."""
    stiffer = replace(liu.calibrated_model(), stiffness=1.034 * liu.calibrated_model().stiffness)
    stiffer = chain.calibrate_compliance(stiffer, printed_value("liu-4.1", "ratio"), liu.calibration_load())
    assert chain.solve_ball_screw(stiffer, np.zeros(78), 3000.0).stiffness == pytest.approx(8.196e8, rel=1e-3)
    assert chain.solve_ball_screw(stiffer, liu.ball_errors_with_faulty_ball_33(-2e-6), 5000.0).load[32] < 43.55 * 0.99
    assert liu.secant_stiffness_without_errors(3000.0, 1.0) == pytest.approx(by_key("K_0_3000").value, rel=1e-4)
    assert liu.secant_stiffness_without_errors(3000.0, 100.0) == pytest.approx(8.071, abs=1e-3)


def test_single_ball_by_hand() -> None:
    """+2 um, light load: ball 33 alone is a Hertz contact until the others touch, 2 um later."""
    model, errors = liu.calibrated_model(), liu.ball_errors_with_faulty_ball_33(2e-6)
    first, last = (chain.load_at_which_ball_is_loaded(model, errors, k, liu.LIGHT) for k in (0, liu.ball_count() - 1))
    assert first == pytest.approx(model.approach_per_motion * model.stiffness * 2e-6**1.5, rel=0.02)
    assert first < last
    low, high = liu.load_change_range_of_other_balls(-2.0)
    assert 0.0 < low < high
