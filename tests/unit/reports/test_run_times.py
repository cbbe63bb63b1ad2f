"""Run times that are kept: written and read, taken in place of new processes, shown beside errors of their version only."""

from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference import store
from rollbench.compare.reference.store import UNMEASURED, MeasuringConditions, measuring_conditions, shipped_store
from rollbench.compare.report import error_over_time, overview
from rollbench.compare.sections import reference_time
from rollbench.compare.studies import run_times as kept_times
from rollbench.compare.studies import survey_models
from rollbench.compare.studies.run_times import ColdLevelTime
from rollbench.reports.content import Figure, Table, Text

KEPT = kept_times.StoredRunTimes(
    measuring_conditions(),
    "2026-01-02",
    {
        ("lin-case1", "lin"): kept_times.RunTime(0.4, 1e-3, 99.0),
        ("lin-case1", "mei"): kept_times.RunTime(0.3, 2e-3, None),
        ("lin-case1", 4): ColdLevelTime(4, 60.0, 118.0, None, "converged", "lin-case1", 64, 0.9),
    },
)
OLD = replace(KEPT, measuring_conditions=MeasuringConditions("0.7.0", "", "a machine"))


def quiet(_):
    """A step that says nothing."""


def points_of(folder, kept):
    """Errors and times of lin-case1 as a report finds them with measured times planted in its folder of runs."""
    kept_times.save_run_times(folder, kept)
    study = SceneResultCache((folder, shipped_store()))
    return reference_time.error_and_time_points("lin-case1", study.stored_reference("lin-case1"), study, quiet)


def test_what_is_saved_is_read_with_what_it_was_measured_with(tmp_path):
    assert kept_times.load_run_times([tmp_path]) is None
    kept_times.save_run_times(tmp_path, KEPT)
    assert kept_times.load_run_times([tmp_path / "none", tmp_path]) == KEPT

    (tmp_path / kept_times.RUN_TIMES).write_text('{"times": 3}')
    assert kept_times.load_run_times([tmp_path]) is None


def test_a_measuring_run_goes_on_where_it_stopped(tmp_path):
    typed = kept_times.CommandTime("list", 0.5)
    jobs = {
        ("lin-case1", "lin"): Mock(return_value=kept_times.RunTime(0.4, 1e-3, 99.0)),
        ("lin-case1", 4): Mock(return_value=KEPT.times["lin-case1", 4]),
        ("list",): Mock(side_effect=[KeyboardInterrupt, typed, typed]),
    }
    with pytest.raises(KeyboardInterrupt):
        kept_times.measure_and_store(tmp_path, measuring_conditions(), jobs, quiet)
    found = kept_times.measure_and_store(tmp_path, measuring_conditions(), jobs, quiet)
    assert [job.call_count for job in jobs.values()] == [1, 1, 2]
    assert found == kept_times.load_run_times([tmp_path])
    assert (found.times.keys(), found.times["list",]) == (jobs.keys(), typed)

    other = replace(measuring_conditions(), machine="another")
    again = kept_times.measure_and_store(tmp_path, other, jobs, quiet)
    assert [job.call_count for job in jobs.values()] == [2, 2, 3], "times of another machine are not mixed with these"
    assert again.measuring_conditions == other


def test_a_planted_older_time_is_not_shown(tmp_path):
    kept_times.save_run_times(tmp_path, OLD)
    assert kept_times.load_run_times([tmp_path]) is None

    def shown_of_lin_case1(kept):
        """Sentence about the measuring run, and times of lin-case1, with times planted in a folder before the shipped."""
        folder = tmp_path / str(kept and kept.measuring_conditions.version)
        folder.mkdir()
        if kept is not None:
            kept_times.save_run_times(folder, kept)
        study = SceneResultCache((folder, shipped_store()))
        points = reference_time.error_and_time_points("lin-case1", study.stored_reference("lin-case1"), study, quiet)
        return reference_time.run_time_conditions_sentence(study, quiet), [(p.name, p.cold, p.warm) for p in points]

    assert shown_of_lin_case1(OLD) == shown_of_lin_case1(None)
    assert KEPT.date in shown_of_lin_case1(KEPT)[0]

    study = SceneResultCache((tmp_path, shipped_store()))
    load = np.array(survey_models.stored_loads()[74]["load"])
    loads = {name: ((1.0 + 0.01 * k) * load).tolist() for k, name in enumerate(survey_models.TIMED)}
    runs = [survey_models.TimedRun(74, name, "converged", 2.0, 1.0, loads[name]) for name in loads]
    for conditions, shown in ((OLD.measuring_conditions, False), (measuring_conditions(), True)):
        survey_models.save_timed_runs(tmp_path, survey_models.StoredTimedRuns(conditions, runs))
        found = error_over_time.measured_on_drawn_screws(study)
        assert (len(found) == len(survey_models.TIMED)) == shown
        assert (error_over_time.run_time_sentence(found) == UNMEASURED) != shown
        assert len(overview.error_distribution_and_time_figure({}, found).panels) == 1 + shown
        assert [type(item) for item in error_over_time.error_and_time_items(study)] == (
            [Figure, Text, Table] if shown else [Text]
        )


def test_a_ratio_compares_the_same_work(tmp_path):
    (row,) = reference_time.run_time_ratio_table({"lin-case1": points_of(tmp_path, KEPT)}).rows
    assert (row["time_ratio_cold"], row["time_ratio_warm"]) == pytest.approx((60.0 / 0.4, 0.9 / 1e-3))


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
