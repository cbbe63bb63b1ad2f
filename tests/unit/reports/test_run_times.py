"""Run times that are kept: written, read, and taken in place of new processes."""

import pytest

from rollbench.comparison.models.study import Study
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.wings.bench.costs import kept as kept_times
from rollbench.comparison.wings.bench.costs.assembly_bench import AssemblyCost
from rollbench.comparison.wings.bench.costs.cold import Cold
from rollbench.comparison.wings.bench.sections import reference_time

KEPT = kept_times.Kept(
    "a machine",
    "2026-01-02",
    {("lin-case1", "lin"): kept_times.RunTime(0.4, 1e-3, 99.0), ("lin-case1", "mei"): kept_times.RunTime(0.3, 2e-3, None)},
    {("lin", "compiled"): Cold(12.0, 11.0, 1e-3, 380.0, "compiled", "converged")},
    assembly=(AssemblyCost("tetrahedra", 12, "one vector form", 3.0, 1e-14),),
)


def test_what_is_saved_is_read(tmp_path):
    assert kept_times.load_times([tmp_path]) is None
    kept_times.save_times(tmp_path, KEPT)
    assert kept_times.load_times([tmp_path / "none", tmp_path]) == KEPT
    (tmp_path / kept_times.RUN_TIMES).write_text('{"times": 3}')
    assert kept_times.load_times([tmp_path]) is None


def test_the_package_has_times_of_every_compared_scene():
    kept = kept_times.load_times([shipped_store()])
    assert {scene for scene, _ in kept.times} == {*reference_time.REFERENCED, *reference_time.UNSEEN}
    assert set(kept.first) == {(m, e) for m in ("lin", "refined") for e in ("interpreted", "compiled")}


def test_a_sample_is_measured_beside_the_kept_ones(monkeypatch):
    found = Cold(0.5, 0.1, 0.1, None, "interpreted", "converged")
    monkeypatch.setattr(kept_times, "measure", lambda *_, **__: found)
    said = kept_times.live("lin-case1", ("lin", "refined"), KEPT)
    assert said == "measured again for this report on lin-case1: lin 0.50 s (kept: 0.40 s)"


def test_ways_to_assemble_are_kept_ones_unless_the_study_is_timed(monkeypatch):
    kept = kept_times.load_times([shipped_store()]).assembly
    assert len({(cost.mesh, cost.way) for cost in kept}) == 8
    monkeypatch.setattr(reference_time, "assembly_costs", lambda: KEPT.assembly)
    assert [reference_time.assembly_ways(Study(timed=timed)) for timed in (False, True)] == [kept, KEPT.assembly]


@pytest.mark.parametrize("timed", [False, True])
def test_a_report_starts_processes_only_where_it_is_timed(monkeypatch, timed):
    started = []

    def measure(_, model, **__):
        started.append(model)
        return Cold(0.5, 0.1, 0.1, 50.0, "interpreted", "converged")

    monkeypatch.setattr(reference_time, "measure", measure)
    monkeypatch.setattr(reference_time, "warm_seconds", lambda *_: 0.25)
    monkeypatch.setattr(reference_time, "suited", lambda _: [reference_time.MODELS["lin"]])
    study = Study(timed=timed)
    points = reference_time.time_points("lin-case1", study.reference("lin-case1"), study, lambda _: None)
    (lin,) = [p for p in points if p.label == reference_time.MODELS["lin"].label]
    kept = kept_times.load_times([shipped_store()]).times["lin-case1", "lin"]
    assert (lin.cold, lin.warm) == ((0.5, 0.25) if timed else (kept.cold, kept.warm))
    assert ("lin" in started, bool(started)) == (timed, timed)
    kept_now = reference_time.kept_now({"lin-case1": points}, {})
    assert kept_now.times["lin-case1", "lin"].cold == lin.cold
