"""The report: its sections; drawing writes nothing into a store; checked by one run that is computed again, and made on a
machine without gmsh too."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models import applicability, model_form, modelling
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import load_stored_run, shipped_store
from rollbench.compare.report import pages, report
from rollbench.compare.report.pages import CHECKED, LEVEL, RecomputedRunCheck, recompute_shipped_run
from rollbench.compare.scenes import catalogue


def test_points_of_the_estimate_are_a_step_of_their_own(tmp_path, monkeypatch: pytest.MonkeyPatch):
    study = SceneResultCache((tmp_path, shipped_store()))
    scene, found = study.built_in_scene("lin-case1"), study.stored_reference("lin-case1")
    rungs = modelling.solve_refinement_sequence(scene, found, None)[:2]
    monkeypatch.setattr(modelling, "solve_refinement_sequence_on_all_scenes", lambda _: rungs)
    report.save_model_errors(study)
    kept = (tmp_path / model_form.FILE).read_text(encoding="utf-8")
    assert kept.count('"scene": "lin-case1"') == 2
    report.save_model_errors(SceneResultCache())
    assert sorted(p.name for p in tmp_path.iterdir()) == [model_form.FILE, applicability.PLACES]
    assert (tmp_path / applicability.PLACES).read_bytes() == (shipped_store() / applicability.PLACES).read_bytes()


def test_without_gmsh_a_report_is_made_and_says_what_installs_it(monkeypatch, tmp_path, command) -> None:
    for module in (report, pages):
        monkeypatch.setattr(module, "gmsh_fault", lambda: "libGLU.so.1: cannot open shared object file")
    words = "--only", "hertz", "--only", "verification", "--out", tmp_path / "out"
    last = command.said("report", *words).splitlines()[-2]
    assert last.startswith("left out: verification: gmsh cannot be loaded (libGLU.so.1")
    assert re.search("apt-get install.* libgomp1", last)
    assert "libglu1-mesa" in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("factor", "agrees"), [(1.0, True), (1.001, False)])
def test_the_live_check_compares_a_run_with_the_shipped_one(monkeypatch, factor, agrees, tmp_path) -> None:
    shipped = load_stored_run(catalogue.scene(CHECKED), LEVEL, stores=(shipped_store(),))

    def again(task, _):
        assert (task.scenes[0].name, task.level, task.cache_folder) == (CHECKED, LEVEL, None)
        return [replace(shipped, load=factor * shipped.load)]

    monkeypatch.setattr(pages, "compute_reference_runs", again)
    found = recompute_shipped_run((shipped_store(),), print)
    assert found.agrees_with_shipped_run is agrees
    largest = 100.0 * (factor - 1.0) * shipped.load.max() / shipped.load[shipped.load > 0.0].mean()
    assert found.largest_load_difference_percent == pytest.approx(largest, abs=1e-9)
    assert ("DOES NOT AGREE" in str(found)) is not agrees
    assert recompute_shipped_run((tmp_path,), print) is None, "no run is stored"
    assert not RecomputedRunCheck(float(np.inf), 1.0).agrees_with_shipped_run
