"""Mesh levels of the 3D reference on randomly drawn screws: chosen by a seed, stored, judged by the finer level."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.cli import main
from rollbench.compare.reference.store import measuring_conditions
from rollbench.compare.studies import survey, survey_models
from rollbench.compare.studies import survey_models as studies_survey_models


def runs_of(number):
    """Level 1 with the survey's loads in 50 s, level 2 with loads that are 2 % larger in 90 s."""
    load = np.array(survey_models.stored_loads()[number]["load"])
    coarse = studies_survey_models.TimedLevelRun(number, 1, "converged", 50.0, 0.5, load.tolist())
    return [coarse, replace(coarse, level=2, seconds=90.0, further_seconds=0.8, load=(1.02 * load).tolist())]


def test_the_screws_are_chosen_from_those_that_the_models_are_judged_on():
    chosen = studies_survey_models.numbers_of_screws_for_level_2()
    assert len(set(chosen)) == len(chosen) == survey_models.COUNT
    assert set(chosen) <= {record["number"] for record in survey.records_for_error_estimates()}


def test_level_1_and_the_models_are_judged_by_level_2():
    runs = runs_of(studies_survey_models.numbers_of_screws_for_level_2()[0])
    found = {
        (s.name, s.reference_level): s
        for s in survey_models.errors_and_times_of_models(runs, survey.records_for_error_estimates())
    }
    coarse = found["3D level 1", "level 2"]
    assert coarse.gate_errors == pytest.approx([100.0 * 0.02 / 1.02])
    assert (coarse.first_case_seconds, coarse.further_case_seconds) == (50.0, 0.5)
    assert found["3D level 2", ""].gate_errors.size == 0, "the finest level has no error from these runs"
    assert found["refined", "level 1"].gate_errors.size == len(survey.records_for_error_estimates())
    record = next(r for r in survey.records_for_error_estimates() if r["number"] == runs[0].number)["models"]["lin"]
    by_level_1, by_level_2 = record["largest_percent"], found["lin", "level 2"].errors_of_mean_load[0]
    assert by_level_2 == pytest.approx(by_level_1, abs=100.0 * 0.02 * 3.0)
    assert by_level_2 != pytest.approx(by_level_1, abs=0.05)


def test_runs_of_the_same_sources_are_not_repeated(tmp_path):
    number = studies_survey_models.numbers_of_screws_for_level_2()[0]
    studies_survey_models.save_timed_level_runs(
        tmp_path, studies_survey_models.StoredTimedLevelRuns(measuring_conditions(), "2026-01-01", runs_of(number))
    )
    before = studies_survey_models.load_timed_level_runs((tmp_path,))
    assert (
        studies_survey_models.time_mesh_levels_on_screws(tmp_path, lambda text: pytest.fail(text), count=1).runs
        == before.runs
    )
    old = replace(measuring_conditions(), version="0.1.0")
    studies_survey_models.save_timed_level_runs(
        tmp_path, studies_survey_models.StoredTimedLevelRuns(old, "2026-01-01", runs_of(number))
    )
    assert not studies_survey_models.time_mesh_levels_on_screws(tmp_path, lambda text: pytest.fail(text), count=0).runs


@pytest.mark.parametrize(("options", "named"), [([], "--store"), (["--long", "--store", "x"], "--drawn")])
def test_bench_of_drawn_screws_takes_a_store_and_nothing_else(options, named, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["bench", "--drawn", *options])
    assert ended.value.code == 2
    assert named in capsys.readouterr().err
