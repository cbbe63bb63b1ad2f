"""The bench: what it measures and says (seconds are never asserted)."""

import json
from dataclasses import replace

import pytest

from rollbench.compare.cases.lin import times
from rollbench.compare.commands import bench
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.sections import reference_time
from rollbench.compare.studies import run_times
from rollbench.compare.studies.run_times import load_run_times


def test_a_process_is_launched_as_a_users_without_threads_set(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    code = "import os; print(os.environ.get('OMP_NUM_THREADS'), os.environ['OWN'])"
    done = run_times.run_timed_python_process(["-c", code], {"OWN": "x"})
    assert done.seconds >= done.first_line_seconds > 0.0
    assert done.printed_output == "None x\n"


def test_a_command_is_timed_from_an_empty_home_again_and_beside_a_busy_process():
    found = run_times.time_command_in_empty_home("schema --help")
    assert found.job.job == "schema --help, from an empty home"
    assert found.seconds >= found.first_line > 0.0
    assert min(found.cpu, found.again, found.again_cpu, found.beside, found.beside_cpu) > 0.0
    failed = run_times.time_command_in_empty_home("solve no-such-scene")
    assert failed.seconds is None
    assert failed.job.note.startswith("not measured: rollbench: ")


def test_the_report_shows_commands_as_typed_with_what_they_are_to_reach(tmp_path):
    kept = load_run_times((shipped_store(),))
    found = run_times.CommandTime("solve my.toml", 2.0, 1.9, 2.5, 0.75, 0.7, 3.0, 2.6)
    run_times.save_run_times(tmp_path, replace(kept, command_times=(found,)))
    (row,) = reference_time.command_time_table(load_run_times([tmp_path])).rows
    assert [row[key] for key in ("command", "seconds", "again", "beside_cpu")] == ["solve my.toml", 2.0, 0.75, 2.6]
    assert row["reach"]


def test_times_of_typed_commands_are_kept_for_the_report(monkeypatch, tmp_path, command):
    monkeypatch.setattr(reference_time, "measure_run_times", lambda *_, **__: load_run_times((shipped_store(),)))
    monkeypatch.setattr(reference_time, "COMMANDS", {"schema --help": ""})
    monkeypatch.setattr(run_times, "time_ensemble_with_threads", list)
    command.answer("bench", "--store", tmp_path)
    (kept,) = load_run_times([tmp_path], run_times.TYPED).command_times
    assert (kept.command, kept.note) == ("schema --help", "")
    assert load_run_times([tmp_path]) is None


def test_threads_are_compared_with_one():
    one, two = run_times.time_ensemble_with_threads(20, 1)
    assert one.ratio == 1.0
    assert two.ratio == pytest.approx(one.seconds / two.seconds)


def test_models_are_listed_with_errors_beside_their_run_times(monkeypatch, tmp_path, command):
    kept = load_run_times((shipped_store(),))
    monkeypatch.setattr(reference_time, "measure_run_times", lambda *_, **__: kept)
    monkeypatch.setattr(reference_time, "COMMANDS", ())
    monkeypatch.setattr(run_times, "time_ensemble_with_threads", list)
    rows = {row["job"]: row for row in command.answer("bench", "lin-case1")}
    study = SceneResultCache()
    study.computed_values[reference_time.run_times_to_show, print] = kept
    points = reference_time.error_and_time_points("lin-case1", study.stored_reference("lin-case1"), study, print)
    timed = {f"lin-case1: {p.label}": p for p in points if p.cold is not None}
    assert rows.keys() == timed.keys() > set()
    for name, p in timed.items():
        assert (rows[name]["seconds"], rows[name]["error_percent"]) == (p.cold, pytest.approx(p.error))
    json.dumps(list(rows.values()), allow_nan=False)
    command.answer("bench", "--long", "--store", tmp_path)
    assert load_run_times([tmp_path]) == replace(kept)
    assert "names: got two-ball" in command.refused("bench", "two-ball")
    assert "--store: got" in command.refused("bench", "lin-case1", "--store", tmp_path)


def test_what_is_not_timed_is_no_job():
    study = SceneResultCache()
    study.computed_values[reference_time.run_times_to_show, print] = None
    points = reference_time.error_and_time_points("lin-case1", study.stored_reference("lin-case1"), study, print)
    assert list(bench.run_time_rows_of_scene("lin-case1", points)) == []


def test_times_of_a_publication_are_listed_as_they_were_stored(monkeypatch, tmp_path):
    kept = load_run_times((shipped_store(),), "lin")
    monkeypatch.setattr(times, "measure_run_times", lambda *_: kept)
    rows = bench.measure_publication_times("lin", tmp_path).data
    assert [row["seconds"] for row in rows] == [
        *(one.cold for one in kept.times_by_scene_and_model.values()),
        *(one.process for one in kept.mesh_level_times),
    ]
    assert load_run_times((tmp_path,), "lin") == kept
