"""Verdicts count the reference's uncertainty openly, and name the contact that decides; what loads that disagree as a whole
look like: another unit, other balls, other flanks."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.gate import verdict as gate_verdict
from rollbench.compare.gate.gate import GateCheck
from rollbench.compare.gate.verdict import ALIKE, ErrorLimits, judge_contact_loads, suspected_cause_text, verdict_on_error
from rollbench.compare.reference import estimate

FLANKS = ("SL", "SR", "NL", "NR")
LOAD = np.array([[100.0, 0.0, 0.0, 100.0], [100.0, 0.0, 0.0, 100.0]])


def reference(uncertainty: float | None = 1.0) -> estimate.Reference:
    """A reference of two levels with the same uncertainty [N] of every loaded contact (None: of one level, 0.3 N by
    experience)."""
    bar, levels = (0.3, (1,)) if uncertainty is None else (uncertainty, (1, 2))
    runs = tuple(SimpleNamespace(level=k, load=LOAD, moving=0.0) for k in levels)
    own = () if uncertainty is None else (bar / 2.0, 0.0, 0.0, 0.0)
    return estimate.Reference("mine", runs, LOAD, np.where(LOAD > 0.0, bar, 0.0), estimate.MeshUncertainty(bar, *own))


def judged(change: dict[tuple[int, int], float], found: estimate.Reference, *flanks: str) -> gate_verdict.VerdictRow:
    """Verdict on the reference's loads but for some, within 7 %."""
    load = LOAD.copy()
    for place, newton in change.items():
        load[place] = newton
    (verdict,) = judge_contact_loads("x", load, found, ErrorLimits(7.0), flanks or FLANKS)
    return verdict


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_pass_undecided_fail(sign: float) -> None:
    assert [verdict_on_error(sign * error, 1.0, 7.0) for error in (6.0, 8.1)] == ["pass", "fail"]
    for error, u in ((6.1, 1.0), (7.9, 1.0), (8.0, 1.0), (0.0, 8.0), (99.0, None), (float("nan"), 1.0)):
        assert verdict_on_error(sign * error, u, 7.0) == "undecided", (error, u)


def test_the_contact_that_decides_is_named() -> None:
    found = judged({(1, 3): 108.5}, reference())
    assert (found.judgement, found.ball, found.side, found.contacts, found.levels) == ("fail", 2, "NR", 4, (1, 2))
    assert found.error == pytest.approx(8.5)
    assert found.line.startswith(f"FAIL: mine, x: {gate_verdict.LARGEST} 8.50 % - 1.00 % > 7 % (ball 2 NR)")
    assert "8.50 % of the mean load (ball 2 NR), 4.25 % RMS" in found.line
    found = judged({(1, 3): 105.0}, reference())
    assert found.judgement == "pass"
    assert f"{gate_verdict.LARGEST} 5.00 % + 1.00 % <= 7 % (ball 2 NR)" in found.line
    assert found.as_json()["max_percent_of_mean"] == pytest.approx(5.0)


def test_flanks_that_are_not_judged_do_not_count_in_the_mean() -> None:
    """Half of the contacts of 100 N, one of them off by 3 N: 3 % of the mean load, as where all are judged."""
    nominal, off = replace(reference(), contacts=4), {(1, 3): 103.0}
    for flanks in (("NL", "NR"), FLANKS):
        assert judged(off, nominal, *flanks).of_mean.max_percent == pytest.approx(3.0)
    assert judged(off, nominal, "NR").of_mean.rms_percent == pytest.approx(3.0 / np.sqrt(2.0))


def test_one_clear_failure_outweighs_a_larger_doubtful_error() -> None:
    found = reference()
    found.uncertainty[0, 0], found.uncertainty[0, 3] = 20.0, 4.5
    verdict = judged({(0, 0): 125.0, (0, 3): 112.0, (1, 0): 109.0}, found)
    assert (verdict.judgement, verdict.ball, verdict.side) == ("fail", 2, "SL")


def test_a_load_that_the_reference_does_not_have_counts_on_the_flanks_that_are_judged() -> None:
    more = {(0, 1): 9.0}
    verdict = judged(more, reference())
    assert (verdict.judgement, verdict.ball, verdict.side) == ("fail", 1, "SR")
    assert judged(more, reference(), "SL", "NR").judgement == "pass"
    none = judged({(0, 0): 0.0}, reference(), "SR")
    assert (none.judgement, none.detail) == ("not covered", "the reference has no contact load on the flanks SR")


def test_one_level_decides_by_experience_and_says_so() -> None:
    verdict = judged({(0, 0): 200.0}, reference(None))
    assert (verdict.judgement, verdict.uncertainty) == ("fail", pytest.approx(0.3))
    assert verdict.line.endswith(gate_verdict.ONE_LEVEL)


def test_rms_is_judged_where_it_has_a_limit() -> None:
    largest, rms = judge_contact_loads("x", 1.04 * LOAD, reference(0.5), ErrorLimits(7.0, rms_load_error=3.0))
    assert (largest.judgement, rms.judgement, rms.quantity) == ("pass", "fail", gate_verdict.RMS)
    assert (rms.error, rms.uncertainty) == pytest.approx((4.0, 0.5))


def test_the_gravest_verdict_counts() -> None:
    words = ["pass", "not covered", "undecided", "fail"]
    assert [gate_verdict.worst_judgement(words[: k + 1]) for k in range(4)] == words
    assert [gate_verdict.CODES[word] for word in words] == [0, 4, 3, 1]


def test_no_row_of_the_shipped_gate_reads_ok_over_its_line() -> None:
    for error, limit, passed, further, expected in (
        (1.9, 2.0, True, {}, "ok"),
        (-2.5, 2.0, True, {"uncertainty": 0.7}, "undecided"),
        (14.0, 7.0, True, {"gated": False}, "reported"),
        (14.0, 7.0, False, {"gated": False}, "FAIL"),
        (None, None, True, {}, "ok"),
    ):
        row = GateCheck("a", "k", None, None, error, limit, passed, **further)
        assert row.judgement == row.as_json()["verdict"] == expected


DIAGONAL = ("SL", "NR")
NEWTONS = {"kilonewtons": 1e3, "pounds": 0.45359237 * 9.80665, "kiloponds": 9.80665, "millinewtons": 1e-3}


def loads():
    """Eight balls on one diagonal, the last bears three times as much as the first."""
    found = np.zeros((8, 4))
    found[:, [0, 3]] = np.linspace(100.0, 300.0, 8)[:, None]
    return found


def test_units_are_those_of_their_definitions():
    """The pound is 0.45359237 kg and standard gravity 9.80665 m/s2, both exactly."""
    assert pytest.approx(NEWTONS, rel=1e-12) == gate_verdict.UNITS


@pytest.mark.parametrize("unit", gate_verdict.UNITS)
@pytest.mark.parametrize(("share", "seen"), [(1.0 - 0.99 * ALIKE, True), (1.0 + 1.01 * ALIKE, False)])
def test_a_sum_near_that_in_another_unit_is_told(unit, share, seen):
    for size in (1.0, 1e-5):
        said = suspected_cause_text(size * share * loads() / NEWTONS[unit], size * loads(), DIAGONAL, 7.0)
        assert (f"look like {unit}: in newtons they are {NEWTONS[unit]:g} times as large" in said) is seen


def test_other_balls_and_other_flanks_are_told_and_what_is_within_the_limit_is_not():
    assert "in reverse order" in suspected_cause_text(loads()[::-1], loads(), DIAGONAL, 7.0)
    assert "in another order" in suspected_cause_text(np.roll(loads(), 3, axis=0), loads(), DIAGONAL, 7.0)
    other = loads()[:, [1, 0, 3, 2]]
    assert "opposite flanks" in suspected_cause_text(other, loads() + 0.1 * other, ("SR", "NL"), 7.0)
    for factor, limit in ((1.05, 12.0), (0.0, 7.0), (1.5, 7.0)):
        assert suspected_cause_text(factor * loads(), loads(), DIAGONAL, limit) == ""
