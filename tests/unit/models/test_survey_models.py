"""Models and mesh levels judged on the randomly drawn screws whose reference is stored, and the files of one of them."""

import csv
import json
import re
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.errors import InputError
from rollbench.compare.models.applicability import CALIBRATING, NEW_SURVEY, SURVEY
from rollbench.compare.models.applicability import survey_records_of_random_screws as records_of_random_screws
from rollbench.compare.reference.store import measuring_conditions
from rollbench.compare.studies import survey, survey_models

SHARE = rollbench.model_command(f"awk -f {ROOT / 'docs/examples/programs/share.awk'} {{scene.json}} {{loads.csv}}")
needs_awk = pytest.mark.skipif(shutil.which("awk") is None, reason="no awk here")


def test_stored_loads_are_those_that_the_record_judged_our_models_by():
    """The record has the errors of lin by the same runs, made by earlier versions: lin finds them again, but for what its
    changes since then moved."""
    rows = [r for file in (SURVEY, NEW_SURVEY) for r in records_of_random_screws(file)]
    record = {r["number"]: r["models"]["lin"] for r in rows if "models" in r}
    numbers = [*survey_models.stored_loads()][::37]
    assert len(numbers) >= 4
    for number in numbers:
        row = survey_models.judge_model_on_random_screw("lin", number)
        assert row.status == "converged"
        for key in ("largest_percent", "rms_percent", "pressure_percent"):
            assert getattr(row, key) == pytest.approx(record[number][key], abs=0.1), (number, key)


def test_loads_of_another_screw_judge_nothing(monkeypatch):
    number = next(iter(survey_models.stored_loads()))
    changed = {**survey_models.stored_loads()[number], "of": "another"}
    monkeypatch.setattr(survey_models, "stored_loads", lambda: {number: changed})
    row = survey_models.judge_model_on_random_screw("lin", number)
    assert (row.status, row.largest_percent) == ("no stored reference", None)


@needs_awk
def test_a_program_is_judged_beside_ours(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out, name = command.said("survey", "--count", "12", "--model-command", SHARE), "awk -f share.awk"
    errors = {name: [], "refined": [], "lin": []}
    for row in csv.DictReader((tmp_path / "survey-awk-f-share.awk.csv").read_text(encoding="utf-8").splitlines()):
        errors[row["model"]].append(float(row["largest_percent"]))
    count, mine = sum(number < 12 for number in survey_models.stored_loads()), np.median(errors[name])
    assert [len(each) for each in errors.values()] == 3 * [count]
    assert re.search(rf"{name} +worst load +{count} +{mine:.2f}", out)
    assert mine > 10.0 * np.median(errors["refined"])
    found = rollbench.survey(SHARE, count=12)
    assert found.median[SHARE] == pytest.approx(mine)
    assert found.largest["lin"] == max(r.largest_percent for r in found.rows["lin"])
    assert all(row.seconds > 0.0 and row.uncertainty_percent > 0.0 for row in found.rows[SHARE])


def test_a_screw_without_answer_is_a_row_with_its_reason_and_the_exit_code_is_1(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (
        "import json, sys\nscene = json.load(open(sys.argv[1]))\n"
        "if scene['track']['hand'] == 'left':\n    sys.exit('right hand only')\n"
        "rows = ['%d,%s,5' % (x['ball'], s) for x in scene['contacts'] for s in ('SL', 'SR', 'NL', 'NR')]\n"
        "open(sys.argv[2], 'w').write('ball,flank,newton\\n' + '\\n'.join(rows))\n"
    )
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    mine = rollbench.model_command(f"{sys.executable} mine.py {{scene.json}} {{loads.csv}}")
    code, data = command.json("survey", "--count", "12", "--model-command", mine, "--json")
    left = {r["number"] for r in survey.built_in_survey()["scenes"] if r["hand"] == "left"}
    reasons = {r["screw"]: r["status"] for r in data["models"][mine] if r["status"] != "converged"}
    assert reasons.keys() == left & {r["screw"] for r in data["models"][mine]} != set()
    assert all("exit code 1; its last line: right hand only" in reason for reason in reasons.values())
    assert (code, data["without_answer"][mine]) == (1, len(reasons))
    assert survey_models.judge_model_on_random_screw("mei", next(iter(left))).status == "the model does not describe it"


@needs_awk
def test_a_drawn_screw_and_its_reference_are_files_that_check_takes(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, number = "survey-20360-36", 36
    command.said("survey", "--screw", number)
    words = ("check", f"{name}.toml", "--reference", f"{name}-reference.csv", "--no-compute", "--json")
    verdict = json.loads(command(*words, "--model-command", SHARE).out)["verdicts"][0]
    row = survey_models.judge_model_on_random_screw(SHARE, number)
    assert verdict["max_percent_of_mean"] == pytest.approx(row.largest_percent, rel=1e-6)
    assert verdict["error_percent"] == pytest.approx(row.gate_percent, rel=1e-6)
    assert verdict["word"] == row.verdict == "fail"


@pytest.mark.parametrize("words", ["--count 0 --model lin", "--screw 360", "", "--model lni", "--screw 0 --model lin"])
def test_numbers_and_models_that_cannot_be_are_refused(words, command):
    command.refused("survey", *words.split())


def test_a_limit_of_nothing_is_refused():
    with pytest.raises(InputError, match="max_error"):
        rollbench.survey("lin", max_error=0.0)


def test_loads_of_runs_are_kept_beside_those_that_a_file_has(tmp_path, monkeypatch):
    """A run of the survey adds its screw; what the file has of others stays."""
    number, row = next(iter(survey_models.stored_loads().items()))
    run = type("Run", (), {"load": np.array(row["load"]) + 1.0, "moving": 0.5})
    monkeypatch.setattr(survey, "stored_run", lambda _, scene: run if scene.name.endswith("-1") else None)
    path = tmp_path / survey.KINDS["ball screw"].loads
    path.write_text(json.dumps({"seed": survey.SEED, "level": survey.LEVEL, "screws": [row]}), encoding="utf-8")
    assert survey_models.store_reference_loads(path, tmp_path, 3) == 2
    found = {r["number"]: r for r in json.loads(path.read_text(encoding="utf-8"))["screws"]}
    assert found[number] == row
    np.testing.assert_allclose(found[1]["load"], run.load, rtol=1e-5)
    assert found[1]["moving"] == 0.5


def runs_of(number):
    """Level 1 with the survey's loads in 50 s, level 2 with loads that are 2 % larger, models with loads 10 % larger."""
    load = np.array(survey_models.stored_loads()[number]["load"])
    one = survey_models.TimedRun(number, "lin", "converged", 0.5, 0.1, (1.1 * load).tolist())
    levels = [
        replace(one, name="3D level 1", seconds=50.0, load=load.tolist()),
        replace(one, name="3D level 2", seconds=90.0, load=(1.02 * load).tolist()),
        replace(one, name="3D level 3", seconds=400.0, load=(1.01 * load).tolist()),
    ]
    return [replace(one, name=name) for name in survey_models.TIMED if name not in survey_models.LEVELS] + levels


def test_level_2_judges_models_and_level_1_and_level_3_judges_level_2():
    first, second = (runs_of(number) for number in survey_models.numbers_of_timed_screws()[:2])
    failed = replace(second[3], status="not converged")
    for runs, screws in ((first, 1), ([*first, *second[:3], failed, *second[4:]], 2)):
        found = {s.name: s for s in survey_models.errors_and_times(runs)}
        assert list(found) == list(survey_models.TIMED)
        assert found["3D level 1"].gate_errors == pytest.approx(screws * [100.0 * 0.02 / 1.02])
        assert found[failed.name].gate_errors == pytest.approx([100.0 * 0.08 / 1.02])
        assert (found["3D level 1"].first_case_seconds[0], found["lin"].further_case_seconds) == (50.0, 0.1)
        assert found["3D level 2"].gate_errors == pytest.approx(screws * [100.0 * 0.01 / 1.01])
        assert found["3D level 3"].gate_errors.size == 0, "the finest level has no error from these runs"
    found = {s.name: s for s in survey_models.errors_and_times([*first, *second[:-1]])}
    assert [found[name].gate_errors.size for name in ("lin", "3D level 1", "3D level 2")] == [2, 2, 1]


def test_a_model_is_timed_without_what_an_earlier_solution_left():
    number = survey_models.numbers_of_timed_screws()[0]
    first, again = (survey_models.solve_and_time(number, "refined") for _ in range(2))
    assert first.load == again.load
    assert again.seconds > 2.0 * again.further_seconds


def test_runs_of_the_same_sources_are_not_repeated(tmp_path):
    runs, mine = runs_of(survey_models.numbers_of_timed_screws()[0]), measuring_conditions()
    for conditions, count, expected in ((mine, 1, runs), (replace(mine, version="0.1.0"), 0, [])):
        stored = survey_models.StoredTimedRuns(conditions, runs)
        survey_models.save_timed_runs(tmp_path, stored)
        assert survey_models.load_timed_runs((tmp_path,)).runs == runs
        again = survey_models.time_models_and_levels_on_screws(tmp_path, lambda text: pytest.fail(text), count=count)
        assert list(again.runs) == expected


def test_new_screws_are_of_another_seed_and_calibrate_nothing():
    numbers = range(survey.SCENES, survey.DRAWN)
    texts = [survey.random_screw_scene_text(survey.SEED, number) for number in numbers]
    flanges = ["flange" in text.split("\n", 1)[0] for text in texts]
    assert flanges == [False] * 40 + [True] * 20
    assert all(f"survey {survey.NEW_SEED}, scene {k}:" in text for k, text in enumerate(texts))
    assert max(CALIBRATING) < survey.SCENES
    assert {r["number"] for r in records_of_random_screws()} <= set(range(survey.SCENES))
    later = survey.built_in_survey("new screw")["scenes"]
    assert [r["number"] for r in later] == list(numbers)
    assert {r["number"] for r in later if r.get("models")} <= survey_models.stored_loads().keys()
