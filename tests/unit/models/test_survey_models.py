"""Models judged on the randomly drawn screws whose reference is stored, and the files of one of them."""

import csv
import json
import re
import shutil
import sys

import numpy as np
import pytest
from tests.copies import ROOT

import rollbench
from rollbench.compare.errors import InputError
from rollbench.compare.studies import survey, survey_models

SHARE = f"awk -f {ROOT / 'docs/examples/programs/share.awk'} {{scene.json}} {{loads.csv}}"
needs_awk = pytest.mark.skipif(shutil.which("awk") is None, reason="no awk here")


def test_stored_loads_are_those_that_the_record_judged_our_models_by():
    """The record has the errors of lin by the same runs, made by earlier versions: lin finds them again, but for what its
    changes since then moved."""
    record = {r["number"]: r["models"]["lin"] for r in survey.built_in_survey()["scenes"] if "models" in r}
    numbers = [*survey_models.stored_loads()][::37]
    assert len(numbers) >= 4
    for number in numbers:
        row = survey_models.judge_model_on_random_screw("lin", number)
        assert row["status"] == "converged"
        assert row["largest_percent"] == pytest.approx(record[number]["largest_percent"], abs=0.1)
        assert row["rms_percent"] == pytest.approx(record[number]["rms_percent"], abs=0.1)
        assert row["pressure_percent"] == pytest.approx(record[number]["pressure_percent"], abs=0.1)


def test_loads_of_another_screw_judge_nothing(monkeypatch):
    number = next(iter(survey_models.stored_loads()))
    changed = {**survey_models.stored_loads()[number], "of": "another"}
    monkeypatch.setattr(survey_models, "stored_loads", lambda: {number: changed})
    row = survey_models.judge_model_on_random_screw("lin", number)
    assert (row["status"], "largest_percent" in row) == ("no stored reference", False)


@needs_awk
def test_a_program_is_judged_beside_ours(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = command("survey", "--count", "12", "--model-command", SHARE)
    assert code == 0
    rows = [*csv.DictReader((tmp_path / "survey-awk-f-share.awk.csv").read_text(encoding="utf-8").splitlines())]
    count = sum(number < 12 for number in survey_models.stored_loads())
    assert [sum(r["model"] == name for r in rows) for name in ("awk -f share.awk", "refined", "lin")] == 3 * [count]
    mine = [float(r["largest_percent"]) for r in rows if r["model"] == "awk -f share.awk"]
    ours = [float(r["largest_percent"]) for r in rows if r["model"] == "refined"]
    assert re.search(rf"awk -f share.awk worst load +{count} +{np.median(mine):.2f}", out)
    assert np.median(mine) > 10.0 * np.median(ours)
    drawing = (tmp_path / "survey-awk-f-share.awk.svg").read_text(encoding="utf-8")
    assert all(f">{name}<" in drawing for name in ("awk -f share.awk", "refined", "lin"))
    found = rollbench.survey(SHARE, count=12)
    assert found.median[SHARE] == pytest.approx(np.median(mine))
    assert found.largest["lin"] == max(r["largest_percent"] for r in found.rows["lin"])
    assert all(row["seconds"] > 0.0 and row["uncertainty_percent"] > 0.0 for row in found.rows[SHARE])


def test_a_screw_without_answer_is_a_row_with_its_reason_and_the_exit_code_is_1(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (
        "import json, sys\nscene = json.load(open(sys.argv[1]))\n"
        "if scene['track']['hand'] == 'left':\n    sys.exit('right hand only')\n"
        "rows = ['%d,%s,5' % (x['ball'], s) for x in scene['contacts'] for s in ('SL', 'SR', 'NL', 'NR')]\n"
        "open(sys.argv[2], 'w').write('ball,flank,newton\\n' + '\\n'.join(rows))\n"
    )
    (tmp_path / "mine.py").write_text(text, encoding="utf-8")
    mine = f"{sys.executable} mine.py {{scene.json}} {{loads.csv}}"
    code, data = command.json("survey", "--count", "12", "--model-command", mine, "--json")
    left = {r["number"] for r in survey.built_in_survey()["scenes"] if r["hand"] == "left"}
    reasons = {r["screw"]: r["status"] for r in data["models"][mine] if r["status"] != "converged"}
    assert reasons.keys() == left & {r["screw"] for r in data["models"][mine]} != set()
    assert all("exit code 1; its last line: right hand only" in reason for reason in reasons.values())
    assert (code, data["without_answer"][mine]) == (1, len(reasons))
    describe = survey_models.judge_model_on_random_screw("mei", next(iter(left)))
    assert describe["status"] == "the model does not describe it"


@needs_awk
def test_a_drawn_screw_and_its_reference_are_files_that_check_takes(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    number = 36
    assert command("survey", "--screw", number).code == 0
    name = f"survey-20360-{number}"
    words = ("check", f"{name}.toml", "--reference", f"{name}-reference.csv", "--no-compute", "--json")
    verdict = json.loads(command(*words, "--model-command", SHARE).out)["verdicts"][0]
    row = survey_models.judge_model_on_random_screw(SHARE, number)
    assert verdict["max_percent_of_mean"] == pytest.approx(row["largest_percent"], rel=1e-6)
    assert verdict["error_percent"] == pytest.approx(row["gate_percent"], rel=1e-6)
    assert verdict["word"] == row["verdict"] == "fail"


def test_numbers_and_models_that_cannot_be_are_refused(command):
    for words in (
        ("--count", "0", "--model", "lin"),
        ("--screw", "300"),
        (),
        ("--model", "lni"),
        ("--screw", "0", "--model", "lin"),
    ):
        code, out, err = command("survey", *words)
        assert (code, out, err.count("\n")) == (2, "", 1), err
    with pytest.raises(InputError, match="max_error"):
        rollbench.survey("lin", max_error=0.0)


def test_loads_of_runs_are_kept_beside_those_that_a_file_has(tmp_path, monkeypatch):
    """A run of the survey adds its screw; what the file has of others stays."""
    number, row = next(iter(survey_models.stored_loads().items()))
    run = type("Run", (), {"load": np.array(row["load"]) + 1.0, "moving": 0.5})
    monkeypatch.setattr(survey, "stored_run", lambda _, scene: run if scene.name.endswith("-1") else None)
    path = tmp_path / survey_models.LOADS
    path.write_text(json.dumps({"seed": survey.SEED, "level": survey.LEVEL, "screws": [row]}), encoding="utf-8")
    assert survey_models.store_reference_loads(path, tmp_path, 3) == 2
    found = {r["number"]: r for r in json.loads(path.read_text(encoding="utf-8"))["screws"]}
    assert found[number] == row
    np.testing.assert_allclose(found[1]["load"], run.load, rtol=1e-5)
    assert found[1]["moving"] == 0.5
