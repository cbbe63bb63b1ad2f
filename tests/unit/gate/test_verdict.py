"""Verdicts count the reference's uncertainty openly, and name the contact that decides."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.gate import verdict as gate_verdict
from rollbench.compare.gate.gate import GateCheck
from rollbench.compare.models.comparison import RULE
from rollbench.compare.reference import estimate

LOAD = np.array([[100.0, 0.0, 0.0, 100.0], [100.0, 0.0, 0.0, 100.0]])


def reference(uncertainty: float | None, load: np.ndarray = LOAD) -> estimate.Reference:
    """A reference of two levels with the same uncertainty [N] of every loaded contact (None: of one level, 0.3 N by
    experience)."""
    levels = (1,) if uncertainty is None else (1, 2)
    runs = tuple(SimpleNamespace(level=k, load=load, moving=0.0) for k in levels)
    bar = 0.3 if uncertainty is None else uncertainty
    parts = (
        estimate.MeshUncertainty(bar) if uncertainty is None else estimate.MeshUncertainty(bar, bar / 2.0, 0.0, 0.0, 0.0)
    )
    return estimate.Reference("mine", runs, load, np.where(load > 0.0, bar, 0.0), parts)


def changed(loads: dict[tuple[int, int], float]) -> np.ndarray:
    """The loads but for some."""
    out = LOAD.copy()
    for place, load in loads.items():
        out[place] = load
    return out


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_pass_undecided_fail(sign: float) -> None:
    assert [gate_verdict.verdict_on_error(sign * error, 1.0, 7.0) for error in (6.0, 8.1)] == ["pass", "fail"]
    for error, u in ((6.1, 1.0), (7.9, 1.0), (8.0, 1.0), (0.0, 8.0), (99.0, None), (float("nan"), 1.0)):
        assert gate_verdict.verdict_on_error(sign * error, u, 7.0) == "undecided", (error, u)


def test_the_contact_that_decides_is_named() -> None:
    (found,) = gate_verdict.judge_contact_loads(
        "x", changed({(1, 3): 108.5}), reference(1.0), gate_verdict.ErrorLimits(7.0)
    )
    assert (found.word, found.ball, found.flank, found.contacts, found.levels) == ("fail", 2, "NR", 4, (1, 2))
    assert found.error_percent == pytest.approx(8.5)
    first = "8.50 % of the mean load on the worst contact (ball 2 NR), 4.25 % RMS"
    assert found.line() == f"FAIL: mine, x: {first}; {gate_verdict.LARGEST} 8.50 % - 1.00 % > 7 % (ball 2 NR), {RULE}"
    (found,) = gate_verdict.judge_contact_loads(
        "x", changed({(1, 3): 105.0}), reference(1.0), gate_verdict.ErrorLimits(7.0)
    )
    assert found.word == "pass"
    assert f"{gate_verdict.LARGEST} 5.00 % + 1.00 % <= 7 % (ball 2 NR), {RULE}" in found.line()
    assert found.as_json()["max_percent_of_mean"] == pytest.approx(5.0)


def test_flanks_that_are_not_judged_do_not_count_in_the_mean() -> None:
    """Half of the contacts of 100 N, one of them off by 3 N: 3 % of the mean load, as where all are judged."""
    nominal, off = replace(reference(1.0), contacts=4), changed({(1, 3): 103.0})
    for flanks in (("NL", "NR"), ("SL", "SR", "NL", "NR")):
        (found,) = gate_verdict.judge_contact_loads("x", off, nominal, gate_verdict.ErrorLimits(7.0), flanks)
        assert found.of_mean.max_percent == pytest.approx(3.0)
    (found,) = gate_verdict.judge_contact_loads("x", off, nominal, gate_verdict.ErrorLimits(7.0), ("NR",))
    assert found.of_mean.rms_percent == pytest.approx(3.0 / np.sqrt(2.0))


def test_one_clear_failure_outweighs_a_larger_doubtful_error() -> None:
    found = reference(1.0)
    found.uncertainty[0, 0], found.uncertainty[0, 3] = 20.0, 4.5
    (verdict,) = gate_verdict.judge_contact_loads(
        "x", changed({(0, 0): 125.0, (0, 3): 112.0, (1, 0): 109.0}), found, gate_verdict.ErrorLimits(7.0)
    )
    assert (verdict.word, verdict.ball, verdict.flank) == ("fail", 2, "SL")


def test_a_load_that_the_reference_does_not_have_counts() -> None:
    load = changed({(0, 1): 9.0})
    (verdict,) = gate_verdict.judge_contact_loads("x", load, reference(0.5), gate_verdict.ErrorLimits(7.0))
    assert (verdict.word, verdict.ball, verdict.flank) == ("fail", 1, "SR")
    (verdict,) = gate_verdict.judge_contact_loads(
        "x", load, reference(0.5), gate_verdict.ErrorLimits(7.0), flanks=("SL", "NR")
    )
    assert verdict.word == "pass"


def test_one_level_decides_by_experience_and_says_so() -> None:
    (verdict,) = gate_verdict.judge_contact_loads("x", 2.0 * LOAD, reference(None), gate_verdict.ErrorLimits(7.0))
    assert (verdict.word, verdict.uncertainty_percent, verdict.detail) == (
        "fail",
        pytest.approx(0.3),
        gate_verdict.ONE_LEVEL,
    )
    assert verdict.line().endswith(gate_verdict.ONE_LEVEL)


def test_rms_is_judged_where_it_has_a_limit() -> None:
    largest, rms = gate_verdict.judge_contact_loads(
        "x", 1.04 * LOAD, reference(0.5), gate_verdict.ErrorLimits(7.0, rms_load_error=3.0)
    )
    assert (largest.word, rms.word, rms.quantity) == ("pass", "fail", gate_verdict.RMS)
    assert (rms.error_percent, rms.uncertainty_percent) == pytest.approx((4.0, 0.5))


def test_flanks_without_load_are_not_covered() -> None:
    (verdict,) = gate_verdict.judge_contact_loads(
        "x", 0.0 * LOAD, reference(0.5), gate_verdict.ErrorLimits(7.0), flanks=("SR",)
    )
    assert verdict.word == "not covered"
    assert verdict.line() == "NOT COVERED: mine, x: the reference has no contact load on the flanks SR"


def test_the_gravest_verdict_counts() -> None:
    words = ["pass", "not covered", "undecided", "fail"]
    assert [gate_verdict.worst_verdict(words[: k + 1]) for k in range(4)] == words
    assert gate_verdict.CODES == {"pass": 0, "fail": 1, "not converged": 1, "undecided": 3, "not covered": 4}


def test_no_row_of_the_shipped_gate_reads_ok_over_its_line() -> None:
    for error, limit, passed, further, expected in (
        (1.9, 2.0, True, {}, "ok"),
        (-2.5, 2.0, True, {"uncertainty_percent": 0.7}, "undecided"),
        (14.0, 7.0, True, {"gated": False}, "reported"),
        (14.0, 7.0, False, {"gated": False}, "FAIL"),
        (None, None, True, {}, "ok"),
    ):
        row = GateCheck("a", "k", None, None, error, limit, passed, **further)
        assert row.verdict == row.as_json()["verdict"] == expected
