"""The report's list of sections stands once; drawing writes nothing into a store."""

from importlib import import_module
from pathlib import Path

import pytest

from rollbench.comparison.commands.reporting import report
from rollbench.comparison.commands.reporting.parts import PARTS
from rollbench.comparison.commands.reporting.report import save_model_form, wanted_parts
from rollbench.comparison.errors import InputError
from rollbench.comparison.models import ladder, model_form
from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store


def test_every_part_has_a_module_with_a_section():
    assert len({part.name for part in PARTS}) == len(PARTS)
    for part in PARTS:
        assert callable(import_module(f"rollbench.comparison.{part.module}").section)


def test_wanted_parts():
    assert [p.name for p in wanted_parts(["timing", "hertz"], quick=True)] == ["hertz", "timing"]
    assert [p.name for p in wanted_parts([])] == list(report.SECTIONS)
    left = {p.name for p in PARTS} - {p.name for p in wanted_parts([], quick=True)}
    assert left == {"crosscheck", "pictures", "stability", "timing"}
    with pytest.raises(InputError, match="no-such"):
        wanted_parts(["no-such"])


def test_the_first_screen_comes_first_and_misprints_in_the_appendix():
    assert PARTS[0].name == "overview"
    appendix = [part.name for part in PARTS if part.appendix]
    assert appendix == ["verdicts", "audit", "notes"]
    assert [part.name for part in PARTS][-len(appendix) :] == appendix


def test_points_of_the_estimate_are_a_step_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    study = Study((tmp_path, shipped_store()))
    found = study.reference("lin-case1")
    assert found is not None
    rungs = ladder.climb(study.scene("lin-case1"), found, None)[:2]
    monkeypatch.setattr(ladder, "ladder", lambda _: rungs)
    save_model_form(study)
    kept = (tmp_path / model_form.FILE).read_text(encoding="utf-8")
    assert kept.count('"scene": "lin-case1"') == 2
    save_model_form(Study())
    assert sorted(p.name for p in tmp_path.iterdir()) == [model_form.FILE]
