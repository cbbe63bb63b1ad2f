"""The first report: short, checked by one run recomputed, and made on a machine without gmsh too."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.report_samples import screw

from rollbench.compare.cases.kalker import page as rolling
from rollbench.compare.models.study import Study
from rollbench.compare.reference.store import load, shipped_store
from rollbench.compare.report import first as report_first
from rollbench.compare.report import report
from rollbench.compare.report.first import CHECKED, COSTLY, LEVEL, LiveCheck, kept_parts, live_check
from rollbench.compare.report.pages import SECTIONS
from rollbench.compare.scenes import catalogue
from rollbench.reports.content import Section


def test_costly_sections_come_by_name_or_all_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_first, "gmsh_fault", lambda: "")
    assert {part.name for part in SECTIONS} >= COSTLY
    kept, missed = kept_parts(SECTIONS, named=False, everything=False)
    assert {part.name for part in SECTIONS} - {part.name for part in kept} == COSTLY
    assert [gap.remedy for gap in missed] == ["rollbench report --all makes them too"]
    for named, everything in ((True, False), (False, True)):
        assert kept_parts(SECTIONS, named=named, everything=everything) == (list(SECTIONS), [])


def test_without_gmsh_a_report_is_made_and_says_what_installs_it(monkeypatch, tmp_path, command) -> None:
    for module in (report, report_first):
        monkeypatch.setattr(module, "gmsh_fault", lambda: "libGLU.so.1: cannot open shared object file")
    words = "--only", "hertz", "--only", "verification", "--out", tmp_path / "out"
    last = command.said("report", *words).splitlines()[-2]
    assert last.startswith("left out: verification: gmsh cannot be loaded (libGLU.so.1")
    assert re.search("apt-get install.* libgomp1", last)
    assert "libglu1-mesa" in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


def test_without_gmsh_the_rolling_section_is_made_but_for_its_meshed_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (report_first, rolling):
        monkeypatch.setattr(module, "gmsh_fault", lambda: "libGL.so.1")
    kept, missed = kept_parts(SECTIONS, named=False, everything=True)
    assert "rolling" in {part.name for part in kept}
    assert "rolling (no motion against the static reference, sizes of bodies)" in missed[-1].names

    def asked(*, meshing: bool) -> None:
        raise LookupError(f"meshing: {meshing}")

    monkeypatch.setattr(rolling, "proofs", asked)
    with pytest.raises(LookupError, match="meshing: False"):
        rolling.section(Study(None), print)


@pytest.mark.parametrize(("factor", "agrees"), [(1.0, True), (1.001, False)])
def test_the_live_check_compares_a_run_with_the_shipped_one(monkeypatch, factor, agrees, tmp_path) -> None:
    shipped = load(catalogue.scene(CHECKED), LEVEL, stores=(shipped_store(),))

    def again(task, _):
        assert (task.scenes[0].name, task.level, task.cache) == (CHECKED, LEVEL, None)
        return [replace(shipped, load=factor * shipped.load)]

    monkeypatch.setattr(report_first, "compute", again)
    found = live_check((shipped_store(),), print)
    assert found.agrees is agrees
    largest = 100.0 * (factor - 1.0) * shipped.load.max() / shipped.load[shipped.load > 0.0].mean()
    assert found.percent == pytest.approx(largest, abs=1e-9)
    assert ("DOES NOT AGREE" in str(found)) is not agrees
    assert live_check((tmp_path,), print) is None, "no run is stored"
    assert not LiveCheck("x", 1, float(np.inf), 1.0).agrees


def test_what_single_files_and_pictures_lack_is_named_with_what_installs_it(monkeypatch) -> None:
    monkeypatch.setattr(report_first, "version", lambda name: None if name == "trimesh" else name)
    (gap,) = report_first.lacking([])
    assert str(gap) == "the view that can be turned: trimesh is not installed; pip install 'rollbench[report]'"
    monkeypatch.setattr(report_first, "version", lambda name: name)
    monkeypatch.setattr(report_first, "drawing_fault", lambda: "no off-screen OpenGL on this machine")
    plain, drawn = Section("a", "No picture", ()), Section("b", "One", (screw(),))
    assert report_first.lacking([plain]) == []
    (gap,) = report_first.lacking([plain, drawn])
    assert str(gap).startswith("3D pictures: no off-screen OpenGL on this machine; apt-get install libegl1")
