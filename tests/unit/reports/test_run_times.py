"""Run times that are kept: of one measuring run, written and read, taken in place of new processes, and never mixed."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from rollbench.compare.cases.lin.pages.reconstruction import _times
from rollbench.compare.commands.compare_output import older_times, table
from rollbench.compare.models.comparison import from_run
from rollbench.compare.models.study import Study
from rollbench.compare.reference import store
from rollbench.compare.reference.measured import Measured, here, most_of, one_run
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.report import overview
from rollbench.compare.results.compared import Beside
from rollbench.compare.sections import reference_mesh as mesh_section
from rollbench.compare.sections import reference_time
from rollbench.compare.studies.mesh_study.table import closing, level_rows
from rollbench.compare.studies.run_times import kept as kept_times
from rollbench.compare.studies.run_times.cold import Cold, ColdLevel

OLD, OTHER = Measured("0.7.0", "", "a machine"), Measured("0.9.0", "abc", "a machine")
KEPT = kept_times.Kept(
    OLD,
    "2026-01-02",
    {("lin-case1", "lin"): kept_times.RunTime(0.4, 1e-3, 99.0), ("lin-case1", "mei"): kept_times.RunTime(0.3, 2e-3, None)},
    {("lin", "compiled"): Cold(12.0, 11.0, 1e-3, 380.0, "compiled", "converged")},
    (ColdLevel(4, 60.0, 118.0, None, "converged", "lin-case1", 64, 0.9),),
)


def quiet(_):
    """A step that says nothing."""


def study_of(kept, **options):
    """A study whose measuring run is known."""
    study = Study(**options)
    study.computed[reference_time.measuring_run, quiet] = kept
    return study


def points_of(study, name="lin-case1"):
    return reference_time.time_points(name, study.reference(name), study, quiet)


def test_what_is_saved_is_read_with_what_it_was_measured_with(tmp_path):
    assert kept_times.load_times([tmp_path]) is None
    kept_times.save_times(tmp_path, KEPT)
    assert kept_times.load_times([tmp_path / "none", tmp_path]) == KEPT
    assert json.loads((tmp_path / kept_times.RUN_TIMES).read_text())["version"] == "0.7.0"
    (tmp_path / kept_times.RUN_TIMES).write_text('{"times": 3}')
    assert kept_times.load_times([tmp_path]) is None
    assert "measured with 0.7.0 on a machine, 2026-01-02, not with the" in str(KEPT)
    assert "not with" not in str(replace(KEPT, measured=here()))


def test_the_package_has_times_of_every_compared_scene():
    kept = kept_times.load_times([shipped_store()])
    assert {scene for scene, _ in kept.times} == {*reference_time.REFERENCED, *reference_time.UNSEEN}
    assert set(kept.first) == {(m, e) for m in ("lin", "refined") for e in ("interpreted", "compiled")}
    assert kept.measured.version, "times of the package say their version"


def test_times_of_one_run_only_stand_beside_one_another():
    assert one_run([]) is None
    assert one_run([OLD, OLD]) == OLD
    with pytest.raises(ValueError, match="several measuring runs"):
        one_run([OLD, OTHER])
    assert most_of([OTHER, OLD, OLD]) == OLD


def test_the_points_of_the_report_have_times_of_the_measuring_run_or_none():
    """Stored runs have seconds of the version that computed them: named with it, in no column, figure or ratio."""
    study = study_of(KEPT)
    points = points_of(study)
    timed = {p.name: (p.cold, p.warm) for p in points if p.cold is not None}
    assert timed == {"lin": (0.4, 1e-3), "mei": (0.3, 2e-3), "3D level 4": (60.0, 0.9)}
    assert one_run(p.measured for p in points if p.cold is not None) == OLD
    coarse = next(p for p in points if p.name == "3D level 1")
    assert coarse.older.endswith("s, measured with 0.3.0")
    rows = reference_time.time_table({"lin-case1": points}).rows
    assert all((row["cold"] is None) or not row["older"] for row in rows)
    drawn = reference_time.time_panel("x", points)
    assert sorted(x for series in drawn.series for x in series.x) == [0.3, 0.4, 60.0]
    _, cold = overview.first_figure({}, {"lin-case1": points}, "f", (8.0, 4.0)).panels
    (warm,) = overview.further_figure({"lin-case1": points}).panels
    assert max(x for series in cold.series for x in series.x) == 60.0
    assert max(x for series in warm.series for x in series.x) == 0.9
    assert overview.standing_table(overview.standings({"lin-case1": points})).rows


def test_the_report_refuses_a_mixture():
    study = study_of(KEPT, quick=True)
    study.computed[(reference_time.ladder,)] = []
    reference_time.all_points(study, quiet)
    mixed = [replace(p, measured=OTHER) if p.name == "mei" else p for p in points_of(study)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference_time, "time_points", lambda *_: mixed)
        with pytest.raises(ValueError, match="several measuring runs"):
            reference_time.all_points(study, quiet)
    far = [replace(p, measured=OTHER) if p.kind == "level" else p for p in mixed]
    with pytest.raises(ValueError, match="several measuring runs"):
        reference_time.speed_table({"lin-case1": far})


def test_a_ratio_compares_the_same_work():
    (row,) = reference_time.speed_table({"lin-case1": points_of(study_of(KEPT))}).rows
    assert (row["cold"], row["warm"]) == (pytest.approx(60.0 / 0.4), pytest.approx(0.9 / 1e-3))
    assert set(row) == {"scene", "low", "low_warm", "ref", "ref_warm", "cold", "warm"}


@pytest.mark.parametrize("timed", [False, True])
def test_a_report_starts_processes_only_where_it_is_timed(monkeypatch, timed, tmp_path):
    started = []

    def measure(_, model, **__):
        started.append(model)
        return Cold(0.5, 0.1, 0.1, 50.0, "interpreted", "converged")

    def measure_level(scene, level):
        started.append(level)
        return ColdLevel(level, 9.0, 9.0, None, "converged", scene, 64, 0.5)

    monkeypatch.setattr(reference_time, "measure", measure)
    monkeypatch.setattr(reference_time, "measure_level", measure_level)
    monkeypatch.setattr(reference_time, "warm_seconds", lambda *_: 0.25)
    monkeypatch.setattr(reference_time, "suited", lambda _: [reference_time.MODELS["lin"]])
    monkeypatch.setattr(reference_time, "UNSEEN", ())
    monkeypatch.setattr(reference_time, "REFERENCED", ("lin-case1",))
    study = Study((tmp_path, shipped_store()), timed=timed)
    points = points_of(study)
    (lin,) = [p for p in points if p.label == reference_time.MODELS["lin"].label]
    kept = kept_times.load_times([shipped_store()]).times["lin-case1", "lin"]
    assert (lin.cold, lin.warm) == ((0.5, 0.25) if timed else (kept.cold, kept.warm))
    assert ({"lin", 0, 1, 2, 3, 4} <= set(started), bool(started)) == (timed, timed)
    if timed:
        again = kept_times.load_times([tmp_path])
        assert (again.measured, len(again.levels)) == (here(), 5)
        assert {p.cold for p in points if p.kind == "level"} == {9.0}


def run_of(level=4):
    study = Study()
    return study.scene("lin-case1"), next(r for r in study.reference("lin-case1").runs if r.level == level)


def measured_here(run):
    stamp = here()
    versions = run.versions | {"rollbench": stamp.version}
    return replace(run, versions=versions, sources=stamp.sources, machine=stamp.machine)


def test_a_stored_run_says_what_its_seconds_were_measured_with_and_keeps_its_key(tmp_path):
    scene, run = run_of()
    assert run.measured == Measured("0.3.0")
    new = measured_here(run)
    path = store.save(tmp_path, scene, new)
    assert path.name == store.path_in(shipped_store(), scene, run).name
    assert store.read(path, scene, run.level, "").measured == here()


def test_a_comparison_has_its_own_seconds_in_the_column_and_older_ones_apart(capsys):
    from rich.console import Console

    _, run = run_of()
    runs = {"old": run, "new": measured_here(run)}
    beside = [Beside(from_run(r, f"3D {k}"), None, SimpleNamespace(worst=None), 0.0, 0.0, 32) for k, r in runs.items()]
    Console(width=120).print(table(beside[1:], beside[0]))
    rows = {line.split()[1]: line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("3D")}
    seconds = f"{run.setup_seconds + run.solve_seconds:.0f}"
    assert (seconds in rows["old"], seconds in rows["new"]) == (False, True)
    assert older_times(beside[1:], beside[0]) == [f"stored times, measured with 0.3.0: 3D old {seconds} s"]


def test_tables_of_stored_runs_leave_out_the_times_of_other_versions():
    study = Study()
    found = study.references(("lin-case1", "lin-case2"))
    one, two = found.values()
    newer = replace(two, runs=tuple(replace(r, versions={"rollbench": "0.8.0"}) for r in two.runs[-2:]))
    found = {"lin-case1": one, "lin-case2": newer}
    rows = mesh_section.level_table(study, found).rows
    assert {row["scene"] for row in rows if row["setup"] is not None and row["level"] != "source"} == {"lin-case1"}
    assert [row["scene"] for row in mesh_section.stage_table({"a": one, "b": one, "lin-case2": newer}).rows] == ["a", "b"]
    assert {row["measured_with"] for row in level_rows(newer)} == {"0.8.0"}
    assert closing(newer).endswith("Times measured with 0.8.0.")
    mixed = replace(newer, runs=(one.runs[-2], newer.runs[-1]))
    assert " s)" not in closing(mixed)
    assert "measured with 0.3.0" in _times(study)["computed here"]
