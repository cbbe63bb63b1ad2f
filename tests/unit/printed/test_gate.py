"""The gate passes as it stands and fails where the model is made wrong."""

from dataclasses import replace

import pytest
from tests.evidence_study import GROUP, STUDY

from rollbench.compare.commands.check import check_shipped_data
from rollbench.compare.evidence import evidence
from rollbench.compare.gate import gate
from rollbench.compare.gate.gate import gate_check_of_published_entry
from rollbench.compare.models.study import SceneResultCache
from rollbench.lowfi.statics import problem

pytestmark = pytest.mark.xdist_group(GROUP)


def test_passes_with_every_kind_of_check() -> None:
    rows = check_shipped_data(STUDY, 7.0)
    assert len(rows) > 50
    assert [row.subject for row in rows if not row.passed] == []
    each = {"printed, hard", "external, band", "printed, as-printed", "input, used by its scene", "claim, hard"}
    each |= {"closed form", "balance", "two solvers", "3D reference", "3D reference, tight", "source's model", "3D rolling"}
    assert {row.quantity for row in rows} == each


def test_a_stiffness_off_by_20_per_cent_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    right = problem.hertz_constants_by_scene_choice
    monkeypatch.setattr(problem, "hertz_constants_by_scene_choice", lambda *parts: 1.2 * right(*parts))
    failed = [row.subject for row in gate.check_closed_forms(SceneResultCache(), 7.0) if not row.passed]
    assert any("oversize" in name for name in failed)


def test_a_wrong_printed_digit_and_a_number_beyond_the_limit_fail() -> None:
    found = evidence(SceneResultCache(), "lin-B1")[3]
    assert gate_check_of_published_entry(found, 7.0).passed
    wrong = replace(found, as_printed=1.001 * (found.as_printed or 0.0))
    assert not gate_check_of_published_entry(wrong, 7.0).passed
    assert [gate.gate_check_of_number("x", "closed form", x, 1.0, 7.0).passed for x in (1.05, 1.08)] == [True, False]
