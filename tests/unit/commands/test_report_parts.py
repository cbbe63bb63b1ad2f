"""The report's list of sections stands once; drawing writes nothing into a store."""

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.models import applicability, model_form, modelling
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report import pages, report
from rollbench.compare.report.pages import SECTIONS


def test_wanted_parts():
    assert [p.name for p in report.select_report_parts(["stability", "hertz"], quick=True)] == ["hertz", "stability"]
    assert [p.name for p in report.select_report_parts([])] == [part.name for part in SECTIONS]
    quick = report.select_report_parts([], quick=True)
    assert {"reference", "overview", "reference-mesh"} < {p.name for p in quick}
    assert {p.name for p in quick}.isdisjoint({*pages.COSTLY, "crosscheck", "outside", "external", "verdicts", "audit"})
    with pytest.raises(InputError, match="no-such"):
        report.select_report_parts(["no-such"])


def test_points_of_the_estimate_are_a_step_of_their_own(tmp_path, monkeypatch: pytest.MonkeyPatch):
    study = SceneResultCache((tmp_path, shipped_store()))
    found = study.stored_reference("lin-case1")
    rungs = modelling.solve_refinement_sequence(study.built_in_scene("lin-case1"), found, None)[:2]
    monkeypatch.setattr(modelling, "solve_refinement_sequence_on_all_scenes", lambda _: rungs)
    report.save_model_errors(study)
    kept = (tmp_path / model_form.FILE).read_text(encoding="utf-8")
    assert kept.count('"scene": "lin-case1"') == 2
    report.save_model_errors(SceneResultCache())
    assert sorted(p.name for p in tmp_path.iterdir()) == [model_form.FILE, applicability.PLACES]
    assert (tmp_path / applicability.PLACES).read_bytes() == (shipped_store() / applicability.PLACES).read_bytes()
