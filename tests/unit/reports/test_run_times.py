"""Run times that are kept: of one measuring run, written and read, taken in place of new processes, and never mixed."""

from dataclasses import replace

import pytest

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference import store
from rollbench.compare.reference.store import MeasuringConditions, measuring_conditions, shipped_store
from rollbench.compare.sections import reference_time
from rollbench.compare.studies import run_times as kept_times
from rollbench.compare.studies.run_times import ColdLevelTime

OLD, OTHER = MeasuringConditions("0.7.0", "", "a machine"), MeasuringConditions("0.9.0", "abc", "a machine")
KEPT = kept_times.StoredRunTimes(
    OLD,
    "2026-01-02",
    {("lin-case1", "lin"): kept_times.RunTime(0.4, 1e-3, 99.0), ("lin-case1", "mei"): kept_times.RunTime(0.3, 2e-3, None)},
    (ColdLevelTime(4, 60.0, 118.0, None, "converged", "lin-case1", 64, 0.9),),
)


def quiet(_):
    """A step that says nothing."""


def study_of(kept, **options):
    """A study whose measuring run is known."""
    study = SceneResultCache(**options)
    study.computed_values[reference_time.run_times_to_show, quiet] = kept
    return study


def points_of(study, name="lin-case1"):
    return reference_time.error_and_time_points(name, study.stored_reference(name), study, quiet)


def test_what_is_saved_is_read_with_what_it_was_measured_with(tmp_path):
    assert kept_times.load_run_times([tmp_path]) is None
    kept_times.save_run_times(tmp_path, KEPT)
    assert kept_times.load_run_times([tmp_path / "none", tmp_path]) == KEPT

    (tmp_path / kept_times.RUN_TIMES).write_text('{"times": 3}')
    assert kept_times.load_run_times([tmp_path]) is None
    now = measuring_conditions()
    others = (now, OLD, replace(now, machine="another"), replace(now, sources="another"))
    said = [str(replace(KEPT, measuring_conditions=of)).partition(KEPT.date)[2] for of in others]
    assert said[0] == "."
    assert len(set(said)) == len(said), "each says what differs"


def test_a_ratio_compares_the_same_work():
    (row,) = reference_time.run_time_ratio_table({"lin-case1": points_of(study_of(KEPT))}).rows
    assert (row["cold"], row["warm"]) == pytest.approx((60.0 / 0.4, 0.9 / 1e-3))


def test_a_stored_run_says_what_its_seconds_were_measured_with_and_keeps_its_key(tmp_path):
    study, now = SceneResultCache(), measuring_conditions()
    scene = study.built_in_scene("lin-case1")
    run = next(r for r in study.stored_reference("lin-case1").runs if r.level == 4)
    assert run.measured == MeasuringConditions("0.3.0")
    versions = run.versions | {"rollbench": now.version}
    new = replace(run, versions=versions, sources=now.sources, machine=now.machine)
    path = store.save_run(tmp_path, scene, new)
    assert path.name == store.path_of_run(shipped_store(), scene, run).name
    assert store.read_run_file(path, scene, run.level, "").measured == now


def test_the_report_refuses_a_mixture():
    study = study_of(KEPT, quick=True)
    study.computed_values[(reference_time.solve_refinement_sequence_on_all_scenes,)] = []
    reference_time.errors_and_times_of_all_scenes(study, quiet)
    mixed = [replace(p, measured=OTHER) if p.name == "mei" else p for p in points_of(study)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference_time, "error_and_time_points", lambda *_: mixed)
        with pytest.raises(ValueError, match="several measuring runs"):
            reference_time.errors_and_times_of_all_scenes(study, quiet)
    far = [replace(p, measured=OTHER) if p.kind == "level" else p for p in mixed]
    with pytest.raises(ValueError, match="several measuring runs"):
        reference_time.run_time_ratio_table({"lin-case1": far})
